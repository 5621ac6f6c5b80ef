//! A flap on its spring: at rest in the wind, and with a wing that is free.

use super::mechanism::{FLAPPER, Preset, moving, robot};
use std::f64::consts::PI;
use wingbeat::aero::{
    Aero, FlapSpec, LiftLaw, Loads, Planform, PlanformStation, ProfileDrag, SectionMotion, SectionSettings,
    Span, StripModel, StripSettings, Surfaces, flap_hinge, flap_points,
};
use wingbeat::math::{GRAVITY, RK4, Vec3, Workspace};
use wingbeat::plant::Plant;

const SPAN: f64 = 10.0;
const SHARE: f64 = 0.25;
const STIFFNESS: f64 = 0.02;
const DENSITY: f64 = 0.2;

/// A wing of 1 m chord whose strips know nothing of each other, in air of that density.
fn wing(density_kg_m3: f64, law: LiftLaw, flap: FlapSpec) -> StripModel {
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.5, trailing_edge_m: -0.5 };
    let settings = StripSettings {
        strips: 4,
        wake_wash: false,
        doublet_wash: false,
        regularisation_m_s: 1e-6,
        section: SectionSettings {
            law,
            drag: ProfileDrag { cd0: 0.0, cd90: 0.0 },
            density_kg_m3,
            ..Default::default()
        },
        flap: Some(flap),
        ..Default::default()
    };
    let planform = Planform::new(&[station(0.0), station(0.5 * SPAN)]).unwrap();
    StripModel::new(&planform, settings).unwrap()
}

fn spring() -> FlapSpec {
    FlapSpec {
        chord_fraction: SHARE,
        stiffness_n_rad: STIFFNESS,
        areal_density_kg_m2: DENSITY,
        damping_s: 0.02,
        rest_deg: 0.0,
        from_arc_m: 0.0,
        to_arc_m: None,
    }
}

/// The chord at rest at the incidence `alpha`, or with velocities upward at its ends.
fn sections(model: &StripModel, alpha: f64, [v_le, v_te]: [f64; 2]) -> Vec<SectionMotion<f64>> {
    let (s, c) = alpha.sin_cos();
    let end = |x: f64, y: f64| Vec3([x * c, y, x * s]);
    let section = |y: &f64| SectionMotion {
        le: end(0.5, *y),
        te: end(-0.5, *y),
        span: Vec3([0.0, -1.0, 0.0]),
        v_le: Vec3([0.0, 0.0, v_le]),
        v_te: Vec3([0.0, 0.0, v_te]),
        ..Default::default()
    };
    model.arcs().iter().map(section).collect()
}

#[test]
fn a_flap_of_one_half_lies_where_its_arcs_say() {
    let outline = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.5, trailing_edge_m: -0.5 };
    let half = |span, flap| {
        let planform = Planform::new(&[outline(0.0), outline(SPAN)]).unwrap().spanning(span).unwrap();
        StripModel::new(&planform, StripSettings { strips: 8, flap: Some(flap), ..Default::default() })
    };
    for span in [Span::Left, Span::Right] {
        let flap = FlapSpec { from_arc_m: 0.7 * SPAN, ..spring() };
        let model = half(span, flap).unwrap();
        let reach: f64 = model.flap_masses().iter().sum::<f64>() / (DENSITY * SHARE);
        assert!((0.1 * SPAN..0.5 * SPAN).contains(&reach), "{span:?}: {reach}");
        let middle = model.flap_masses().iter().zip(model.arcs()).map(|(m, s)| m * s).sum::<f64>();
        assert_eq!(middle > 0.0, span == Span::Left);
    }
    let planform = Planform::new(&[outline(0.0), outline(SPAN)]).unwrap().spanning(Span::Left).unwrap();
    let end = |to_arc_m| FlapSpec { to_arc_m, ..spring() }.end_within(&planform);
    assert!(end(None).is_ok() && end(Some(SPAN)).is_ok());
    let error = end(Some(1.1 * SPAN)).unwrap_err().to_string();
    assert!(error.contains("flap.to_arc_m") && error.contains("at most 10"), "{error}");
}

/// Lift 2 pi a + 2 (f + sin f) b, f the angle of the hinge from the trailing edge, under every law; the spring bears the moment of the hinge; no
/// drag.
#[test]
fn a_flap_at_rest_turns_and_lifts_as_glauert_says() {
    let (alpha, wind) = (2e-3, Vec3([-1.0, 0.0, 0.0]));
    let arc = (1.0 - 2.0 * SHARE).acos();
    for law in [LiftLaw::Linear, LiftLaw::Lev] {
        let model = wing(1.0, law, spring());
        let sections = sections(&model, alpha, [0.0; 2]);
        let (mut x, mut dx) = (vec![0.0; model.states()], vec![0.0; model.states()]);
        let mut loads = Loads::default();
        model.evaluate(&sections, wind, &x, &mut dx, &mut loads);
        for _ in 0..12_000 {
            x.iter_mut().zip(&dx).for_each(|(x, dx)| *x += 0.01 * dx);
            model.evaluate(&sections, wind, &x, &mut dx, &mut loads);
        }
        let area: f64 = model.widths().iter().sum();
        let flap = loads.flap[1];
        let lift = loads.wrench.force[2] / (0.5 * area);
        let exact = 2.0 * PI * alpha + 2.0 * (arc + arc.sin()) * flap;
        assert!((lift / exact - 1.0).abs() < 2e-3, "{law:?}: lift {lift} {exact}");
        let cells = 20_000;
        let hinge = 1.0 - 2.0 * SHARE;
        let moment = |pressure: &dyn Fn(f64) -> f64| -> f64 {
            let at = |k: usize| (k as f64 + 0.5) * PI / f64::from(cells);
            let arm = |t: f64| (-t.cos() - hinge).max(0.0) * 0.5;
            (0..cells as usize).map(|k| pressure(at(k)) * arm(at(k))).sum::<f64>() * PI / f64::from(cells)
        };
        // The pressures over rho V^2 times dx = (sin t)/2 dt: of the angle of attack, and of the flap by Glauert's series.
        let by_alpha = moment(&|t| 1.0 + t.cos());
        let by_flap = moment(&|t| {
            let series = (1..600).map(|n| {
                let n = f64::from(n);
                // (2/(pi n)) sin(n t_h), t_h from the leading edge.
                2.0 / (PI * n) * (n * (PI - arc)).sin() * (n * t).sin()
            });
            arc / PI * (1.0 + t.cos()) + series.sum::<f64>() * t.sin()
        });
        let turned = -alpha * by_alpha / (STIFFNESS + by_flap);
        assert!((flap / turned - 1.0).abs() < 5e-3, "{law:?}: angle {flap} {turned}");
        let drag = -loads.wrench.force[0];
        assert!(drag.abs() < 1e-3 * alpha * loads.wrench.force[2], "{law:?}: drag {drag}");
    }
}

/// A wing of 3 kg and 0.5 kg m2 without air, free to heave and to pitch: the momentum that it gains its flap lacks, and the energy stays.
#[test]
fn a_flap_keeps_energy_and_momentum_with_its_wing() {
    let (mass, inertia) = (3.0, 0.5);
    let model = wing(1e-12, LiftLaw::Linear, FlapSpec { damping_s: 0.0, ..spring() });
    let n = model.states();
    let at = 2 + model.channels().iter().position(|c| c.name == "flap_0").unwrap();
    let mut x = vec![0.0; n + 2];
    x[at..at + model.strips()].fill(0.1);
    let evaluate = |x: &[f64], dx: &mut [f64]| {
        let mut loads = Loads::default();
        let ends = [x[0] + 0.5 * x[1], x[0] - 0.5 * x[1]];
        model.evaluate(&sections(&model, 0.0, ends), Vec3::ZERO, &x[2..], &mut dx[2..], &mut loads);
        // Nose up turns about -y.
        let m = &loads.added_mass;
        let (a, b, d) = (mass + m[2][2], -m[2][4], inertia + m[4][4]);
        let (f, g) = (loads.wrench.force[2], -loads.wrench.moment[1]);
        let inverse = 1.0 / (a * d - b * b);
        (dx[0], dx[1]) = ((d * f - b * g) * inverse, (a * g - b * f) * inverse);
        loads.membrane.momentum[2]
    };
    let rates = |_: f64, x: &[f64], dx: &mut [f64]| -> Result<(), std::convert::Infallible> {
        evaluate(x, dx);
        Ok(())
    };
    let area: f64 = model.widths().iter().sum();
    let (first, own) = (DENSITY * SHARE * SHARE / 2.0 * area, DENSITY * SHARE * SHARE * SHARE / 3.0 * area);
    let energy = |x: &[f64], rate: f64| {
        let [heave, pitch] = [x[0], x[1]];
        // The hinge lies (1/2 - share) behind mid chord.
        let across = (own + first * (0.5 - SHARE)) * pitch - first * heave;
        0.5 * (mass * heave * heave + inertia * pitch * pitch + own * rate * rate)
            + across * rate
            + 0.5 * STIFFNESS * area * x[at] * x[at]
    };
    let (mut work, mut dx) = (Workspace::new(n + 2, 4), vec![0.0; n + 2]);
    evaluate(&x, &mut dx);
    let start = energy(&x, dx[at]);
    let (mut rest, mut largest, mut lacking) = (0.0_f64, 0.0_f64, 0.0_f64);
    for k in 0..800 {
        RK4.step(rates, f64::from(k) * 5e-3, 5e-3, &mut x, &mut work).unwrap();
        let flap = evaluate(&x, &mut dx);
        rest = rest.max((mass * x[0] + flap).abs());
        largest = largest.max(flap.abs());
        lacking = lacking.max((energy(&x, dx[at]) / start - 1.0).abs());
    }
    assert!(largest > 1e-3 && rest < 1e-9 * largest, "{rest} {largest}");
    assert!(lacking < 1e-7, "{lacking}");
}

/// Without air a flap hangs at m g r/k and pulls at its hinge with its weight aside; one that falls with its wing does not turn: the weight
/// is what the same acceleration of the wing would ask.
#[test]
fn a_flap_hangs_by_its_weight_and_falls_with_its_wing() {
    let model = wing(1e-12, LiftLaw::Linear, FlapSpec { damping_s: 0.3, ..spring() });
    let (n, gravity) = (model.states(), Vec3([0.03, -0.05, -0.1]));
    let at = model.channels().iter().position(|c| c.name == "flap_0").unwrap();
    let still = sections(&model, 0.0, [0.0; 2]);
    let aero = Surfaces::from(Aero::Strip(model.clone()));
    let evaluate = |x: &[f64], dx: &mut [f64]| {
        let mut loads = Loads::default();
        aero.evaluate_under((None, gravity, false), &still, Vec3::ZERO, x, dx, &mut loads);
        loads
    };
    let (mut x, mut dx) = (vec![0.0; n], vec![0.0; n]);
    let (loads, m) = (evaluate(&x, &mut dx), evaluate(&x, &mut dx).added_mass);
    for i in 0..6 {
        let weight = if i < 3 { loads.wrench.force[i] } else { loads.wrench.moment[i - 3] };
        let falling: f64 = (0..3).map(|c| m[i][c] * gravity[c]).sum();
        assert!((weight - falling).abs() < 1e-12, "{i}: {weight} {falling}");
    }
    assert!(loads.wrench.force[2].abs() > 1e-3);
    let rates = |_: f64, x: &[f64], dx: &mut [f64]| -> Result<(), std::convert::Infallible> {
        evaluate(x, dx);
        Ok(())
    };
    let mut work = Workspace::new(n, 4);
    for k in 0..4000 {
        RK4.step(rates, f64::from(k) * 5e-3, 5e-3, &mut x, &mut work).unwrap();
    }
    let loads = evaluate(&x, &mut dx);
    let first = DENSITY * SHARE * SHARE / 2.0;
    let sag = first * 0.1 / STIFFNESS;
    assert!((x[at] / sag - 1.0).abs() < 1e-6, "{} {sag}", x[at]);
    let area: f64 = model.widths().iter().sum();
    let aside = Vec3([0.0, 0.0, -first * area * sag]).cross(gravity);
    let Loads { wrench, .. } = loads;
    assert!(wrench.force.norm() < 1e-9 && (wrench.moment - aside).norm() < 1e-8, "{wrench:?} {aside:?}");
}

/// Wings on hinges, one of which twists a strip whose edges ride on two links: by differences over small steps.
#[test]
fn links_and_flaps_of_a_flapper_account_for_momentum_and_energy() {
    let wing = "[[surfaces]]\nname = \"wing\"\n";
    let flap = "flap = { chord_fraction = 0.3, stiffness_n_rad = 0.02, areal_density_kg_m2 = 0.05, rest_deg = 2.0 }\n";
    let text = FLAPPER.replace(wing, &format!("{wing}{flap}"));
    for density in [1e-12, 1.2] {
        let robot = robot(&text, Preset::Full, density);
        let (t, h, mut start) = (0.05, 1e-5, moving(&robot));
        robot.settle(t, &mut start, &[]).unwrap();
        for (i, channel) in robot.states().iter().enumerate() {
            if channel.unit == "N m s" {
                start[i] += 1e-8 * (1.0 + (i as f64).sin());
            }
        }
        let at = |h: f64| {
            let mut x = start.clone();
            let mut work = Workspace::new(x.len(), RK4.b.len());
            RK4.step(|t, x, dx| robot.rates_in_numbers(t, x, &[], dx), t, h, &mut x, &mut work).unwrap();
            let seen = robot.observe(t + h, &x, &[]).unwrap();
            let [x, y, z] = (seen.momentum + seen.attitude * seen.strips.membrane.momentum).0;
            [x, y, z, seen.energy]
        };
        let steps = [h, -h, 2.0 * h, -2.0 * h].map(at);
        let slope = |i: usize| {
            let [up, down, far_up, far_down] = steps.map(|of| of[i]);
            (8.0 * (up - down) - (far_up - far_down)) / (12.0 * h)
        };
        let seen = robot.observe(t, &start, &[]).unwrap();
        let power = seen.power + seen.air_power - seen.dissipation;
        assert!((slope(3) - power).abs() < 1e-7 * power.abs().max(0.1), "{} {power}", slope(3));
        if density < 1.0 {
            let lacking = [slope(0), slope(1), slope(2) + GRAVITY * robot.mass()];
            assert!(lacking.iter().all(|lacking| lacking.abs() < 1e-10), "{lacking:?}");
        }
    }
}

/// The trailing edge turns about the hinge at 3/4 chord, and what lies ahead of it stays.
#[test]
fn a_flap_is_drawn_where_it_stands() {
    let aero = Aero::Strip(wing(1.0, LiftLaw::Linear, spring()));
    let mut ribs: Vec<_> =
        aero.arcs().iter().map(|y| [Vec3([0.5, *y, 0.0]), Vec3([-0.5, *y, 0.0])]).collect();
    let points = flap_points(&mut ribs, aero.arcs(), &aero, &[0.1; 4]);
    let (sine, cosine) = 0.1_f64.sin_cos();
    for (rib, points) in ribs.iter().zip(&points) {
        let y = rib[0][1];
        let turned = Vec3([-0.25 - SHARE * cosine, y, -SHARE * sine]);
        assert!((rib[1] - turned).norm() < 1e-12, "{rib:?}");
        assert!((points[2] - Vec3([-0.25, y, 0.0])).norm() < 1e-12, "{points:?}");
    }
    assert_eq!(flap_hinge(&aero), Some(2));
}

#[test]
fn a_flap_is_refused_by_its_keys() {
    let refused = |flap: FlapSpec| flap.check().unwrap_err().to_string();
    assert!(refused(FlapSpec { chord_fraction: 0.9, ..spring() }).contains("chord_fraction"));
    assert!(refused(FlapSpec { stiffness_n_rad: -1.0, ..spring() }).contains("stiffness_n_rad"));
    assert!(refused(FlapSpec { areal_density_kg_m2: 0.0, ..spring() }).contains("areal_density_kg_m2"));
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.5, trailing_edge_m: -0.5 };
    let planform = Planform::new(&[station(0.0), station(5.0)]).unwrap();
    let beyond = FlapSpec { from_arc_m: 4.99, ..spring() };
    let told = StripModel::new(&planform, StripSettings { flap: Some(beyond), ..Default::default() });
    assert!(told.unwrap_err().to_string().contains("flap.from_arc_m = 4.99"));
}
