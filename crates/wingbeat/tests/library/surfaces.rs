//! Several surfaces: their order, their wash on each other, and one surface alone.

mod craft;

use craft::{Craft, Placed, full, full_with, paper, rectangle};
use std::f64::consts::PI;
use wingbeat::aero::{Aero, Ground, LagSet, LiftLaw, Loads, MAX_STRIPS, SectionMotion, Sections, Surfaces};
use wingbeat::math::linear::{lu_factor, lu_solve};
use wingbeat::math::{Dual, Scalar, Vec3};

fn named(surfaces: Vec<(&str, Aero)>) -> Surfaces {
    Surfaces::new(surfaces.into_iter().map(|(name, aero)| (name.to_string(), aero))).unwrap()
}

fn some_state(states: usize) -> Vec<f64> {
    (0..states).map(|i| 0.05 * (1.7 * i as f64).sin()).collect()
}

fn same_loads(a: &Loads<f64>, b: &Loads<f64>) {
    assert_eq!((a.wrench.force, a.wrench.moment), (b.wrench.force, b.wrench.moment));
    assert_eq!((a.added_mass, a.strips), (b.added_mass, b.strips));
    assert_eq!((&a.incidence, &a.wash, &a.circulation), (&b.incidence, &b.wash, &b.circulation));
    for (a, b) in a.strip.iter().zip(&b.strip) {
        assert_eq!((a.total().force, a.total().moment), (b.total().force, b.total().moment));
    }
}

#[test]
fn one_surface_is_itself_to_the_last_bit() {
    for aero in [full(&rectangle(4.0, 1.0), 8), paper(&rectangle(4.0, 1.0), 9)] {
        let surfaces = Surfaces::from(aero.clone());
        assert_eq!((surfaces.arcs(), surfaces.strip_arcs()), (aero.arcs(), aero.strip_arcs()));
        assert_eq!((surfaces.strips(), surfaces.states()), (aero.strips(), aero.states()));
        let names = |channels: Vec<wingbeat::plant::Channel>| -> Vec<String> {
            channels.into_iter().map(|c| c.name).collect()
        };
        assert_eq!(names(surfaces.channels()), names(aero.channels()));
        let sections = Placed::at(Vec3::ZERO).pitched(0.1).sections(aero.arcs(), &rectangle(4.0, 1.0));
        let (wind, x) = (Vec3::new(-1.5, 0.2, 0.4), some_state(aero.states()));
        let (mut dx, mut dx_alone) = (x.clone(), x.clone());
        let (mut loads, mut alone) = (Loads::default(), Loads::default());
        surfaces.evaluate_in_numbers(&sections, wind, &x, &mut dx, &mut loads);
        aero.evaluate_in_numbers(&sections, wind, &x, &mut dx_alone, &mut alone);
        assert_eq!(dx, dx_alone);
        same_loads(&loads, &alone);
        let (wrench, mass) = surfaces.sum_in_numbers(&sections, wind, &x, &mut dx);
        let (wrench_alone, mass_alone) = aero.sum_in_numbers(&sections, wind, &x, &mut dx_alone);
        assert_eq!(
            (wrench.force, wrench.moment, mass),
            (wrench_alone.force, wrench_alone.moment, mass_alone)
        );
        assert_eq!(dx, dx_alone);
    }
}

#[test]
fn surfaces_stand_one_behind_the_other() {
    let outlines = [rectangle(4.0, 1.0), rectangle(1.5, 0.5)];
    let alone = [full(&outlines[0], 8), paper(&outlines[1], 5)];
    let craft = Craft::new(vec![
        ("wing", alone[0].clone(), outlines[0].clone(), Placed::at(Vec3::ZERO)),
        ("tail", alone[1].clone(), outlines[1].clone(), Placed::at(Vec3::new(-3.0, 0.0, 0.2))),
    ]);
    let (sections, x) = (craft.sections::<f64>(), some_state(craft.surfaces.states()));
    let wind = Vec3::new(-1.0, 0.1, 0.2);
    let (mut dx, mut loads) = (x.clone(), Loads::default());
    craft.surfaces.evaluate_in_numbers(&sections, wind, &x, &mut dx, &mut loads);
    let mut sum = Vec3::ZERO;
    for (surface, aero) in craft.surfaces.surfaces().iter().zip(&alone) {
        let (mut own_dx, mut own) = (vec![0.0; aero.states()], Loads::default());
        let of_surface: &[SectionMotion<f64>] = &sections[surface.sections()];
        aero.evaluate_in_numbers(of_surface, wind, &x[surface.states()], &mut own_dx, &mut own);
        assert_eq!(own_dx, dx[surface.states()], "{}", surface.name());
        assert_eq!(own.circulation[..aero.strips()], loads.circulation[surface.strips()]);
        sum += own.wrench.force;
    }
    assert!((sum - loads.wrench.force).norm() < 1e-14);
    assert_eq!(loads.strips, 13);
    assert_eq!(craft.surfaces.of_strip(8).name(), "tail");
    let names: Vec<String> = craft.surfaces.channels().into_iter().map(|c| c.name).collect();
    assert_eq!((names[0].as_str(), names[24].as_str()), ("wash_lag1_0", "tail_circulation_0"));
    let mut seen = vec![false; craft.surfaces.states()];
    for i in 0..seen.len() {
        let image = craft.surfaces.mirrored(i);
        assert_eq!(craft.surfaces.mirrored(image), i);
        seen[image] = true;
    }
    assert!(seen.into_iter().all(|s| s));
}

#[test]
fn bad_collections_are_refused() {
    let refused = |names: &[&str], strips: usize| {
        let surfaces = names.iter().map(|name| (name.to_string(), full(&rectangle(4.0, 1.0), strips)));
        Surfaces::new(surfaces).unwrap_err().to_string()
    };
    assert!(refused(&["a", "b", "a"], 4).starts_with("surfaces[2].name = \"a\""));
    assert!(refused(&["a"; 2], 4).starts_with("surfaces[1].name = \"a\""));
    assert!(
        refused(&["a", "b", "c", "d", "e", "f", "g", "h", "i"], 1)
            .starts_with("surfaces = 9: allowed is at most 8")
    );
    assert!(refused(&["a", "b", "c"], 11).starts_with("surfaces = 33 strips"));
    assert_eq!(named(vec![("a", full(&rectangle(4.0, 1.0), MAX_STRIPS))]).strips(), MAX_STRIPS);
}

/// A wing and a tail half as wide, behind it by `behind` and above it by `above`.
fn wing_and_tail(behind: f64, above: f64, side: f64) -> Craft {
    let (wing, tail) = (rectangle(6.0, 1.0), rectangle(3.0, 0.6));
    Craft::new(vec![
        ("wing", full(&wing, 16), wing, Placed::at(Vec3::ZERO).pitched(0.05)),
        ("tail", full(&tail, 8), tail, Placed::at(Vec3::new(-behind, side, above))),
    ])
}

const WIND: Vec3<f64> = Vec3([-1.0, 0.0, 0.0]);

/// State and loads after `time` from `x` in steps of `step`.
fn march(craft: &Craft, wind: Vec3<f64>, mut x: Vec<f64>, time: f64, step: f64) -> (Vec<f64>, Loads<f64>) {
    let sections = craft.sections::<f64>();
    let mut dx = x.clone();
    for _ in 0..(time / step).round() as usize {
        craft.surfaces.sum_in_numbers(&sections, wind, &x, &mut dx);
        x.iter_mut().zip(&dx).for_each(|(x, d)| *x += step * d);
    }
    let mut loads = Loads::default();
    craft.surfaces.evaluate_in_numbers(&sections, wind, &x, &mut dx, &mut loads);
    (x, loads)
}

fn steady(craft: &Craft) -> (Vec<f64>, Loads<f64>) {
    march(craft, WIND, vec![0.0; craft.surfaces.states()], 150.0, 0.04)
}

fn lift(loads: &Loads<f64>, craft: &Craft, surface: usize) -> f64 {
    loads.strip[craft.surfaces.surfaces()[surface].strips()].iter().map(|s| s.total().force[2]).sum()
}

#[test]
fn surfaces_far_apart_act_as_if_alone() {
    let alone = wing_and_tail(0.0, 400.0, 0.0);
    let one = |k: usize| {
        let craft = Craft::new(vec![(
            "one",
            alone.surfaces.surfaces()[k].aero().clone(),
            alone.outlines[k].clone(),
            Placed::at(Vec3::ZERO).pitched(0.05),
        )]);
        lift(&steady(&craft).1, &craft, 0)
    };
    let (wing, tail) = (one(0), one(1));
    for (above, side) in [(400.0, 0.0), (0.0, 400.0), (-300.0, 300.0)] {
        let mut craft = wing_and_tail(3.0, above, side);
        craft.placed[1] = craft.placed[1].pitched(0.05);
        let loads = steady(&craft).1;
        let errors = [lift(&loads, &craft, 0) / wing - 1.0, lift(&loads, &craft, 1) / tail - 1.0];
        assert!(errors.iter().all(|e| e.abs() < 1e-3), "{errors:?}");
    }
}

#[test]
fn a_steady_state_does_not_know_the_delay() {
    let craft = wing_and_tail(6.0, 0.3, 0.0);
    let (x, loads) = steady(&craft);
    let arrivals = &x[72..];
    for lag in 0..2 {
        for i in 0..16 {
            assert!((arrivals[16 + 16 * lag + i] - loads.circulation[i]).abs() < 1e-9);
        }
        for i in 0..8 {
            assert!((arrivals[8 * lag + i] - loads.circulation[16 + i]).abs() < 1e-9);
        }
    }
    assert!(loads.wash_of_others[16..24].iter().all(|w| *w < -1e-3));
}

#[test]
fn a_change_at_the_wing_reaches_the_tail_distance_over_speed_later() {
    for (behind, speed) in [(6.0, 1.0), (12.0, 1.0), (6.0, 3.0)] {
        let craft = wing_and_tail(behind, 0.0, 0.0);
        let (sections, step) = (craft.sections::<f64>(), 0.02 / speed);
        let mut x = vec![0.0; craft.surfaces.states()];
        let (mut dx, mut loads) = (x.clone(), Loads::default());
        let (mut late, mut last) = (0.0, 0.0);
        for _ in 0..10_000 {
            craft.surfaces.evaluate_in_numbers(&sections, WIND * speed, &x, &mut dx, &mut loads);
            late += step * (loads.circulation[7] - x[72 + 16 + 16 + 7]);
            last = loads.circulation[7];
            x.iter_mut().zip(&dx).for_each(|(x, d)| *x += step * d);
        }
        // From the trailing edge of the wing to 3/4 chord of the tail.
        let way = behind - 1.0 + 0.45;
        assert!(
            (late / last * speed / way - 1.0).abs() < 0.03,
            "{behind} at {speed}: {} of {way}",
            late / last * speed
        );
    }
}

/// Sections over a ground.
struct Over<S: Scalar> {
    sections: Vec<SectionMotion<S>>,
    ground: Ground<S>,
}

impl<S: Scalar> Sections<S> for Over<S> {
    fn section(&self, i: usize) -> SectionMotion<S> {
        self.sections[i]
    }
    fn ground(&self) -> Option<Ground<S>> {
        Some(self.ground)
    }
}

const TILTED: Ground<f64> = Ground { normal: Vec3([0.0, 0.6, 0.8]), offset: -0.5 };

/// A wing under law `lev` with a tail that stalls, pitching and heaving at `t` s.
fn pitching_craft(t: f64) -> Craft {
    let (wing, tail) = (rectangle(4.0, 1.0), rectangle(2.0, 0.6));
    let (heave, rate) = ((2.0 * t).sin(), 2.0 * (2.0 * t).cos());
    let moving = |at: Vec3<f64>| Placed {
        velocity: Vec3::new(0.0, 0.0, 0.1 * rate),
        acceleration: Vec3::new(0.0, 0.0, -0.4 * heave),
        ..Placed::at(at + Vec3::new(0.0, 0.0, 0.1 * heave)).pitched(0.25 * heave)
    };
    Craft::new(vec![
        ("wing", full_with(&wing, 8, LiftLaw::Lev, LagSet::Three), wing, moving(Vec3::new(0.0, 0.0, 0.2))),
        ("tail", full_with(&tail, 5, LiftLaw::Stall, LagSet::Five), tail, moving(Vec3::new(-2.0, 0.1, 0.4))),
    ])
}

/// Unsteady and past stall, over a plane that is not level: forces, washes and states are those of the pair.
#[test]
fn a_wing_over_a_ground_is_the_upper_one_of_a_mirrored_pair() {
    let alone = pitching_craft(0.0).surfaces.over_ground();
    let four = ["wing", "tail", "wing_image", "tail_image"];
    let models = alone.surfaces().iter().chain(alone.surfaces()).map(|surface| surface.aero().clone());
    let pair = Surfaces::new(four.map(String::from).into_iter().zip(models)).unwrap();
    // In the plane.
    let wind = Vec3::new(-1.0, 0.16, -0.12);
    let (mut x, mut of_pair) = (vec![0.0; alone.states()], vec![0.0; pair.states()]);
    let (mut dx, mut d_pair) = (x.clone(), of_pair.clone());
    let (mut loads, mut both) = (Loads::default(), Loads::default());
    let own: usize = alone.surfaces().iter().map(|surface| surface.states().len()).sum();
    let mut largest = 0.0_f64;
    for step in 0..120 {
        let sections = pitching_craft(0.05 * f64::from(step)).sections::<f64>();
        let image = |s: &SectionMotion<f64>| SectionMotion {
            le: TILTED.point(s.le),
            te: TILTED.point(s.te),
            v_le: TILTED.direction(s.v_le),
            v_te: TILTED.direction(s.v_te),
            a_le: TILTED.direction(s.a_le),
            a_te: TILTED.direction(s.a_te),
            ..*s
        };
        let mirrored: Vec<_> = sections.iter().copied().chain(sections.iter().map(image)).collect();
        alone.evaluate_over(Some(TILTED), &sections, wind, &x, &mut dx, &mut loads);
        pair.evaluate_in_numbers(&mirrored, wind, &of_pair, &mut d_pair, &mut both);
        for i in 0..loads.strips {
            let [a, b] = [&loads, &both].map(|loads| loads.strip[i].total());
            assert!(
                (a.force - b.force).norm() + (a.moment - b.moment).norm() < 1e-10,
                "strip {i}, step {step}"
            );
            assert!((loads.wash_of_others[i] - both.wash_of_others[i]).abs() < 1e-10);
            largest = largest.max(loads.wash_of_others[i].abs());
        }
        assert!((0..own).all(|i| (dx[i] - d_pair[i]).abs() < 1e-10), "step {step}");
        x.iter_mut().zip(&dx).for_each(|(x, d)| *x += 0.05 * d);
        of_pair.iter_mut().zip(&d_pair).for_each(|(x, d)| *x += 0.05 * d);
    }
    assert!(largest > 0.05, "{largest}");
}

/// Derivatives pass through the images, in both ways to the loads; far away nothing is left of them.
#[test]
fn the_ground_is_felt_by_height() {
    let craft = pitching_craft(0.3);
    let grounded = craft.surfaces.clone().over_ground();
    let x = some_state(grounded.states());
    let of = |offset: Dual<1>| {
        let lifted = |v: Vec3<f64>| Vec3(v.0.map(Dual::from));
        let ground = Ground { normal: lifted(TILTED.normal), offset };
        let x: Vec<Dual<1>> = x.iter().copied().map(Dual::from).collect();
        let (mut dx, mut loads, sections) = (x.clone(), Loads::default(), craft.sections());
        grounded.evaluate_over(Some(ground), &sections, lifted(WIND), &x, &mut dx, &mut loads);
        let mut summed = x.clone();
        let over = Over { sections, ground };
        let (wrench, _) = grounded.evaluate_sum(&over, lifted(WIND), &x, &mut summed, None);
        assert_eq!((wrench.force, &summed), (loads.wrench.force, &dx));
        dx.into_iter().chain(wrench.force.0).chain(wrench.moment.0).collect::<Vec<_>>()
    };
    let (h, exact) = (1e-5, of(Dual::variable(-0.5, 0)));
    let [plus, minus] = [h, -h].map(|h| of(Dual::constant(-0.5 + h)));
    for (i, e) in exact.iter().enumerate() {
        let difference = (plus[i].re - minus[i].re) / (2.0 * h);
        assert!((e.eps[0] - difference).abs() < 1e-6 * (1.0 + difference.abs()), "{i}: {e:?} {difference}");
    }
    assert!(exact[exact.len() - 4].eps[0].abs() > 1e-3);
    let far = of(Dual::constant(-1e6));
    // The same states without those that come from images.
    let channels = grounded.channels();
    let same = |name: &str| channels.iter().position(|channel| channel.name == name).unwrap();
    let of: Vec<usize> = craft.surfaces.channels().iter().map(|channel| same(&channel.name)).collect();
    let free: Vec<f64> = of.iter().map(|&i| x[i]).collect();
    let mut dx = free.clone();
    let (wrench, _) = craft.surfaces.sum_in_numbers(&craft.sections::<f64>(), WIND, &free, &mut dx);
    for (&i, dx) in of.iter().zip(&dx) {
        assert!((far[i].re - dx).abs() < 1e-9 * (1.0 + dx.abs()), "{}", channels[i].name);
    }
    assert!((0..3).all(|k| (far[far.len() - 6 + k].re - wrench.force[k]).abs() < 1e-9));
}

fn stalled_craft() -> Craft {
    let mut craft = wing_and_tail(4.0, 0.2, 0.3);
    let [wing, tail] = [0, 1].map(|k: usize| craft.outlines[k].clone());
    craft.surfaces = named(vec![
        ("wing", full_with(&wing, 10, LiftLaw::Stall, LagSet::Five)),
        ("tail", full_with(&tail, 7, LiftLaw::Linear, LagSet::Three)),
        ("fin", full_with(&tail, 5, LiftLaw::Stall, LagSet::Three)),
    ]);
    craft.outlines.push(tail);
    craft.placed.push(Placed::at(Vec3::new(-5.0, 0.0, 1.0)).pitched(-0.2));
    craft
}

/// Rates, wrench and added mass of a craft whose tail's place, wind and states depend on `p`.
fn outputs<S: Scalar>(craft: &Craft, p: S) -> Vec<S> {
    let mut placed: Vec<Placed<S>> = craft.placed.iter().map(Placed::lifted).collect();
    placed[1].at += Vec3([p * 0.5, p * 0.2, p.sin()]);
    placed[1].velocity = Vec3([p, p * p, p * -0.3]);
    placed[0].pitch += p * 0.3;
    let sections = craft.sections_of(&placed);
    let wind = Vec3::new(p * 0.1 - 1.0, S::from(0.05), p.cos() * 0.2);
    let x: Vec<S> = some_state(craft.surfaces.states()).iter().map(|&v| p * v + v).collect();
    let (mut dx, mut loads) = (x.clone(), Loads::default());
    craft.surfaces.evaluate(&sections, wind, &x, &mut dx, &mut loads);
    let mut summed = x.clone();
    let (wrench, mass) = craft.surfaces.evaluate_sum(&sections, wind, &x, &mut summed, None);
    assert_eq!((wrench.force, mass), (loads.wrench.force, loads.added_mass));
    assert!(dx.iter().zip(&summed).all(|(a, b)| a == b));
    let matrix = mass.into_iter().flatten();
    dx.into_iter().chain(wrench.force.0).chain(wrench.moment.0).chain(matrix).collect()
}

#[test]
fn derivatives_across_surfaces_are_exact() {
    let craft = stalled_craft();
    let exact = outputs(&craft, Dual::<1>::variable(0.3, 0));
    let h = 1e-5;
    let [plus, minus] = [0.3 + h, 0.3 - h].map(|p| outputs(&craft, Dual::<1>::constant(p)));
    for (i, e) in exact.iter().enumerate() {
        let difference = (plus[i].re - minus[i].re) / (2.0 * h);
        assert!(
            (difference - e.eps[0]).abs() < 1e-6 * (1.0 + e.eps[0].abs()),
            "output {i}: {difference} {}",
            e.eps[0]
        );
    }
}

#[test]
fn states_may_carry_more_derivatives_than_the_motion() {
    let craft = stalled_craft();
    let (sections, x) = (craft.sections::<f64>(), some_state(craft.surfaces.states()));
    let dual: Vec<Dual<1>> =
        x.iter().enumerate().map(|(i, &v)| Dual { re: v, eps: [(0.3 * i as f64).cos()] }).collect();
    let mut dx = dual.clone();
    let (wrench, _) = craft.surfaces.evaluate_sum(&sections, WIND, &dual, &mut dx, None);
    let at = |h: f64| {
        let x: Vec<f64> = dual.iter().map(|d| d.re + h * d.eps[0]).collect();
        let mut dx = x.clone();
        (craft.surfaces.sum_in_numbers(&sections, WIND, &x, &mut dx).0.force[2], dx)
    };
    let ((plus, plus_dx), (minus, minus_dx)) = (at(1e-5), at(-1e-5));
    assert!((wrench.force[2].eps[0] - (plus - minus) / 2e-5).abs() < 1e-6);
    for (i, d) in dx.iter().enumerate() {
        assert!(
            (d.eps[0] - (plus_dx[i] - minus_dx[i]) / 2e-5).abs() < 1e-6 * (1.0 + d.eps[0].abs()),
            "state {i}"
        );
    }
}

#[test]
fn the_mirror_image_has_mirrored_rates_and_loads() {
    let craft = stalled_craft();
    let mut image = craft.placed.clone();
    for placed in &mut image {
        placed.at = Vec3::new(placed.at[0], -placed.at[1], placed.at[2]);
    }
    let x = some_state(craft.surfaces.states());
    let mirrored = |v: &[f64]| -> Vec<f64> { (0..v.len()).map(|i| v[craft.surfaces.mirrored(i)]).collect() };
    let run = |placed: &[Placed<f64>], side: f64, x: &[f64]| {
        let mut dx = x.to_vec();
        let wind = Vec3::new(-1.0, side, 0.3);
        let (wrench, _) = craft.surfaces.sum_in_numbers(&craft.sections_of(placed), wind, x, &mut dx);
        (dx, wrench)
    };
    let (dx, wrench) = run(&craft.placed, 0.2, &x);
    let (dx_image, of_image) = run(&image, -0.2, &mirrored(&x));
    for (i, (a, b)) in mirrored(&dx).iter().zip(&dx_image).enumerate() {
        assert!((a - b).abs() < 1e-11 * (1.0 + a.abs()), "state {i}: {a} {b}");
    }
    for (axis, sign) in [(0, 1.0), (1, -1.0), (2, 1.0)] {
        assert!((wrench.force[axis] - sign * of_image.force[axis]).abs() < 1e-12);
        assert!((wrench.moment[axis] + sign * of_image.moment[axis]).abs() < 1e-12);
    }
}

/// Steady lift and drag of two halves of a rectangle of aspect ratio 8, `n` strips each, over those of one surface
/// of `2 n`; with their outlines abutting, or moved so that their last edges meet.
fn halves_over_whole(n: usize, meeting: bool) -> [f64; 2] {
    let (half, whole) = (rectangle(4.0, 1.0), rectangle(8.0, 1.0));
    let at = |y: f64| Placed::at(Vec3::new(0.0, y, 0.0)).pitched(0.05);
    let one = Craft::new(vec![("wing", full(&whole, 2 * n), whole.clone(), at(0.0))]);
    let part = full(&half, n);
    let y = if meeting { part.arcs()[0] } else { 2.0 };
    let two =
        Craft::new(vec![("left", part.clone(), half.clone(), at(y)), ("right", part, half.clone(), at(-y))]);
    let [one, two] = [&one, &two].map(|craft| steady(craft).1.wrench.force);
    [two[2] / one[2], two[0] / one[0]]
}

#[test]
fn halves_whose_last_edges_meet_lift_like_one_wing() {
    // Strips end a little short of the outline: outlines that abut leave a slit, which costs lift.
    let [lift, drag] = halves_over_whole(8, true);
    assert!((lift - 1.0).abs() < 0.02 && (drag - 1.0).abs() < 0.02, "{lift} {drag}");
    let slit = halves_over_whole(8, false)[0];
    assert!((0.88..0.95).contains(&slit), "{slit}");
}

/// Largest wash of the wing on the tail, and its largest slope by height from one millimetre to the next, 1/s, while the tail crosses
/// the wake.
fn crossing(behind: f64, side: f64) -> [f64; 2] {
    const STEP: f64 = 1e-3;
    let craft = wing_and_tail(behind, 0.0, side);
    let x = steady(&craft).0;
    let (mut largest, mut slope) = (0.0_f64, 0.0_f64);
    let mut below: Option<Vec<f64>> = None;
    for k in -600..600 {
        let mut placed: Vec<Placed<f64>> = craft.placed.iter().map(Placed::lifted).collect();
        placed[1].at[2] = STEP * f64::from(k);
        let sections = craft.sections_of(&placed);
        let (mut dx, mut loads) = (x.clone(), Loads::default());
        craft.surfaces.evaluate(&sections, WIND, &x, &mut dx, &mut loads);
        let wash = loads.wash_of_others[16..24].to_vec();
        largest = wash.iter().fold(largest, |most, wash| most.max(wash.abs()));
        for (a, b) in below.iter().flatten().zip(&wash) {
            slope = slope.max((b - a).abs() / STEP);
        }
        below = Some(wash);
    }
    [largest, slope]
}

#[test]
fn a_tail_crosses_the_wake_smoothly() {
    // Behind the middle of the wing, and with the tail's tip through the tip vortex.
    for side in [0.13, 1.6] {
        for behind in [1.2, 2.0, 6.0] {
            let [largest, slope] = crossing(behind, side);
            assert!(slope < 12.0 * largest, "{behind} behind, {side} aside: {slope} of {largest}");
        }
    }
}

/// Potential jumps, summed over each of two flat plates in one plane, per unit normal velocity of the first: the
/// added mass per density and span, of the first and mutual.
fn plates(chords: [f64; 2], gap: f64) -> [f64; 2] {
    let n = 60;
    let starts = [0.0, chords[0] + gap];
    // Panels even in the angle, each a pair of vortices at its ends.
    let ends = |plate: usize, k: usize| {
        starts[plate] + 0.5 * chords[plate] * (1.0 - (PI * k as f64 / n as f64).cos())
    };
    let middle = |plate: usize, k: usize| {
        starts[plate] + 0.5 * chords[plate] * (1.0 - (PI * (k as f64 + 0.5) / n as f64).cos())
    };
    let size = 2 * n;
    let (mut m, mut jump) = (vec![0.0; size * size], vec![0.0; size]);
    for row in 0..size {
        let x = middle(row / n, row % n);
        jump[row] = if row < n { 1.0 } else { 0.0 };
        for column in 0..size {
            let [a, b] = [0, 1].map(|end| x - ends(column / n, column % n + end));
            m[row * size + column] = (1.0 / b - 1.0 / a) / (-2.0 * PI);
        }
    }
    let mut pivots = vec![0; size];
    assert!(lu_factor(&mut m, size, &mut pivots));
    lu_solve(&m, size, &pivots, &mut jump, 1);
    let sum = |plate: usize| -> f64 {
        (0..n).map(|k| jump[plate * n + k] * (ends(plate, k + 1) - ends(plate, k))).sum::<f64>().abs()
    };
    [sum(0), sum(1)]
}

#[test]
fn the_neglected_added_mass_between_wing_and_tail_is_small() {
    let [own, mutual] = plates([1.0, 0.6], 1.0);
    assert!((own / (PI / 4.0) - 1.0).abs() < 0.01, "{own}");
    let of_tail = mutual / (PI * 0.36 / 4.0);
    assert!((0.03..0.06).contains(&of_tail), "{of_tail}");
}
