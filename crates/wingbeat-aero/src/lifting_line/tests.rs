use super::*;
use crate::{LiftLaw, MAX_STRIPS, ProfileDrag, SectionSettings};
use wingbeat_math::{Dual, Jet, Mat3, RK4, Workspace};

fn settings(nodes: usize) -> LiftingLineSettings {
    LiftingLineSettings { nodes, chord_floor_m: 1e-9, ..Default::default() }
}

fn rectangle(aspect_ratio: f64, nodes: usize) -> LiftingLine {
    LiftingLine::with_chords(0.5, |_| 1.0 / aspect_ratio, settings(nodes)).unwrap()
}

fn elliptic(aspect_ratio: f64, nodes: usize) -> LiftingLine {
    let root = 4.0 / (PI * aspect_ratio);
    LiftingLine::with_chords(0.5, |s| root * (1.0 - 4.0 * s * s).max(0.0).sqrt(), settings(nodes)).unwrap()
}

/// Effective wash by node after `chords` mean chords of travel from rest at
/// airspeed `u` and unit incidence; the span is 1 m.
fn sudden_start(line: &LiftingLine, chord: f64, u: f64, chords: f64, steps: usize) -> Vec<f64> {
    let m = line.strips();
    let airspeed = vec![u; m];
    let (mut x, mut dx, mut effective) = (vec![0.0; 3 * m], vec![0.0; 3 * m], vec![0.0; m]);
    let mut work = Workspace::new(3 * m, 4);
    for _ in 0..steps {
        let rates = |_: f64, x: &[f64], dx: &mut [f64]| {
            line.rates_in_wash(&airspeed, &airspeed, x, dx, &mut effective);
            Ok::<(), ()>(())
        };
        RK4.step(rates, 0.0, chords * chord / (u * steps as f64), &mut x, &mut work).unwrap();
    }
    line.rates_in_wash(&airspeed, &airspeed, &x, &mut dx, &mut effective);
    effective
}

/// Lift coefficient per incidence from the effective wash.
fn lift_slope(line: &LiftingLine, effective: &[f64], u: f64, area: f64) -> f64 {
    let set = line.settings();
    let lift: f64 = line.nodes.iter().zip(effective).map(|(n, w)| n.lift * u * w).sum();
    lift / (0.5 * set.section.density_kg_m3 * u * u * area)
}

#[test]
fn steady_elliptic_wing_has_prandtls_slope_at_any_speed() {
    for aspect_ratio in [4.0, 8.0] {
        let line = elliptic(aspect_ratio, 12);
        let slope = |u| {
            let effective = sudden_start(&line, 1.0 / aspect_ratio, u, 400.0, 8000);
            lift_slope(&line, &effective, u, 1.0 / aspect_ratio)
        };
        let exact = 2.0 * PI / (1.0 + 2.0 / aspect_ratio);
        let slopes = [0.5, 1.0, 4.0].map(slope);
        assert!((slopes[1] / exact - 1.0).abs() < 1e-9, "AR {aspect_ratio}: {}", slopes[1] / exact - 1.0);
        for s in slopes {
            assert!((s / slopes[0] - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn a_sudden_start_follows_wagner_and_begins_at_half() {
    let line = rectangle(1e5, 13);
    let middle = 6;
    for s in [0.0_f64, 1.0, 4.0, 10.0, 40.0] {
        let steps = if s == 0.0 { 0 } else { 400 };
        let lift = sudden_start(&line, 1e-5, 1.0, s / 2.0, steps)[middle];
        let jones = 1.0 - 0.165 * (-0.0455 * s).exp() - 0.335 * (-0.3 * s).exp();
        assert!((lift - jones).abs() < 4e-4, "s {s}: {lift} {jones}");
        if s == 0.0 {
            assert!((lift - 0.5).abs() < 1e-15);
        }
    }
}

#[test]
fn rectangles_have_glauerts_slope() {
    // Prandtl lifting line, 200 odd terms.
    for (aspect_ratio, reference) in [(3.0, 3.63136162933), (8.0, 4.83770401183), (20.0, 5.54427366957)] {
        let line = rectangle(aspect_ratio, 31);
        let effective = sudden_start(&line, 1.0 / aspect_ratio, 1.0, 150.0, 12000);
        let slope = lift_slope(&line, &effective, 1.0, 1.0 / aspect_ratio);
        assert!((slope / reference - 1.0).abs() < 1e-3, "AR {aspect_ratio}: {}", slope / reference - 1.0);
    }
}

/// Two wing halves that flap, pitch, sweep and move, as jets of time.
#[derive(Clone, Copy)]
struct FlappingHalves<S: Scalar> {
    position: Vec3<Jet<S>>,
    flap: Jet<S>,
    pitch: Jet<S>,
    sweep: Jet<S>,
}

impl<S: Scalar> FlappingHalves<S> {
    fn cyclic(phase: S, omega: f64) -> Self {
        let angle = Jet::new(phase, S::from(omega), S::ZERO);
        let wave = |amplitude: f64, harmonic: f64, lag: f64| (angle * harmonic + lag).sin() * amplitude;
        Self {
            position: Vec3::new(wave(0.02, 1.0, 0.3), wave(0.01, 2.0, 1.0), wave(0.05, 1.0, 2.0)),
            flap: wave(0.6, 1.0, 0.0),
            pitch: wave(0.4, 1.0, 1.2) - 0.2,
            sweep: wave(0.3, 2.0, 0.7),
        }
    }

    /// Section at `arc`; the left wing flaps up by `flap`, the right by its mirror image.
    fn section(&self, arc: f64, chord: f64) -> SectionMotion<S> {
        let side = arc.signum();
        let turn = Mat3::rotation_x(self.flap * side)
            * Mat3::rotation_z(self.sweep * side)
            * Mat3::rotation_y(self.pitch);
        let at = |x: f64| self.position + turn * Vec3::constant(Vec3::new(x, arc, 0.0));
        let (le, te) = (at(0.3 * chord), at(-0.7 * chord));
        let part = |v: Vec3<Jet<S>>, f: fn(Jet<S>) -> S| Vec3(v.0.map(f));
        let rate = |m: Mat3<Jet<S>>, f: fn(Jet<S>) -> S| Mat3(m.0.map(|r| r.map(f)));
        let (r, dr, ddr) = (rate(turn, |j| j.x), rate(turn, |j| j.d), rate(turn, |j| j.dd));
        let axial = |m: Mat3<S>| Vec3::new(m.0[2][1], m.0[0][2], m.0[1][0]);
        let spin = dr * r.transpose();
        SectionMotion {
            le: part(le, |j| j.x),
            te: part(te, |j| j.x),
            v_le: part(le, |j| j.d),
            v_te: part(te, |j| j.d),
            a_le: part(le, |j| j.dd),
            a_te: part(te, |j| j.dd),
            span: r * Vec3::new(S::ZERO, -S::ONE, S::ZERO),
            w: axial(spin),
            alpha: axial(ddr * r.transpose() + dr * dr.transpose()),
        }
    }

    fn sections(&self, line: &LiftingLine) -> Vec<SectionMotion<S>> {
        line.arcs().iter().zip(&line.nodes).map(|(&s, n)| self.section(s, 2.0 * n.half_chord)).collect()
    }
}

fn state(line: &LiftingLine) -> Vec<f64> {
    (0..line.states()).map(|i| 0.05 * (1.7 * i as f64).sin()).collect()
}

fn loads_of(line: &LiftingLine, sections: &[SectionMotion<f64>], wind: Vec3<f64>) -> Loads<f64> {
    let mut loads = Loads::default();
    line.evaluate(sections, wind, &state(line), &mut vec![0.0; line.states()], &mut loads);
    loads
}

#[test]
fn the_carried_air_gives_no_mean_force() {
    let line = rectangle(5.0, 8);
    let (steps, omega) = (64, 20.0);
    let mut sum = [Vec3::ZERO; 8];
    let mut largest = [0.0_f64; 8];
    for k in 0..steps {
        let wing = FlappingHalves::cyclic(2.0 * PI * k as f64 / steps as f64, omega);
        let loads = loads_of(&line, &wing.sections(&line), Vec3::new(-2.0, 0.3, 0.2));
        for i in 0..8 {
            let force = loads.strip[i].added_mass.force;
            sum[i] += force;
            largest[i] = largest[i].max(force.norm());
        }
    }
    for i in 0..8 {
        assert!(sum[i].norm() / steps as f64 / largest[i] < 1e-10, "strip {i}");
    }
}

#[test]
fn loads_are_affine_in_the_body_acceleration() {
    for law in LiftLaw::ALL {
        let line = LiftingLine::with_chords(
            0.5,
            |_| 0.2,
            LiftingLineSettings { section: SectionSettings { law, ..settings(8).section }, ..settings(8) },
        )
        .unwrap();
        let sections = FlappingHalves::cyclic(0.7, 20.0).sections(&line);
        let (a, w_dot) = (Vec3::new(3.0, -2.0, 5.0), Vec3::new(40.0, 20.0, -30.0));
        let full: Vec<_> = sections
            .iter()
            .map(|s| SectionMotion {
                a_le: s.a_le + a + w_dot.cross(s.le),
                a_te: s.a_te + a + w_dot.cross(s.te),
                alpha: s.alpha + w_dot,
                ..*s
            })
            .collect();
        let wind = Vec3::new(-1.5, 0.2, 0.4);
        let (bias, full) = (loads_of(&line, &sections, wind), loads_of(&line, &full, wind));
        let s = [a[0], a[1], a[2], w_dot[0], w_dot[1], w_dot[2]];
        for i in 0..6 {
            let pick = |w: &Wrench<f64>| if i < 3 { w.force[i] } else { w.moment[i - 3] };
            let carried: f64 = (0..6).map(|j| bias.added_mass[i][j] * s[j]).sum();
            let difference = pick(&bias.wrench) - carried - pick(&full.wrench);
            assert!(difference.abs() < 1e-12 * (1.0 + carried.abs()), "row {i}: {difference}");
        }
    }
}

#[test]
fn a_mirrored_motion_mirrors_the_loads() {
    let line = rectangle(6.0, 8);
    let mut wing = FlappingHalves::cyclic(1.1, 15.0);
    wing.position[1] = Jet::from(0.0);
    let loads = loads_of_even_state(&line, &wing.sections(&line));
    assert!(loads.wrench.force[1].abs() < 1e-13 && loads.wrench.force[2].abs() > 1e-3);
    assert!(loads.wrench.moment[0].abs() < 1e-13 && loads.wrench.moment[2].abs() < 1e-13);
    for i in 0..4 {
        let (a, b) = (loads.strip[i].total(), loads.strip[7 - i].total());
        assert!((a.force[0] - b.force[0]).abs() < 1e-13 && (a.force[1] + b.force[1]).abs() < 1e-13);
        assert!((a.moment[1] - b.moment[1]).abs() < 1e-13 && (a.moment[0] + b.moment[0]).abs() < 1e-13);
    }
}

fn loads_of_even_state(line: &LiftingLine, sections: &[SectionMotion<f64>]) -> Loads<f64> {
    let m = line.strips();
    let x: Vec<f64> =
        (0..line.states()).map(|i| 0.04 + 0.02 * ((i % m) as f64 - (m - 1) as f64 / 2.0).abs()).collect();
    let mut loads = Loads::default();
    line.evaluate(sections, Vec3::new(-2.0, 0.0, 0.3), &x, &mut vec![0.0; line.states()], &mut loads);
    loads
}

#[test]
fn sums_agree_and_breakdown_adds_up() {
    let line = rectangle(6.0, 12);
    let sections = FlappingHalves::cyclic(0.4, 20.0).sections(&line);
    let (wind, x) = (Vec3::new(-1.5, 0.2, 0.4), state(&line));
    let (mut dx, mut dx_sum) = (vec![0.0; 36], vec![0.0; 36]);
    let mut loads = Loads::default();
    line.evaluate(&sections, wind, &x, &mut dx, &mut loads);
    let (wrench, added_mass) = line.evaluate_sum(&sections, wind, &x, &mut dx_sum, None);
    assert_eq!((dx, added_mass), (dx_sum, loads.added_mass));
    let by_source = loads.by_source().total();
    for w in [wrench, by_source] {
        assert!((w.force - loads.wrench.force).norm() < 1e-13);
        assert!((w.moment - loads.wrench.moment).norm() < 1e-13);
    }
}

/// Wrench and rates for a wing whose phase, wind and states depend on `p`.
fn outputs<S: Scalar>(line: &LiftingLine, p: S) -> Vec<S> {
    let sections = FlappingHalves::cyclic(p + 0.6, 15.0).sections(line);
    let wind = Vec3::new(S::from(-1.5), p * 0.5, p.sin() + 0.2);
    let x: Vec<S> = state(line).iter().map(|&v| p * v + v).collect();
    let mut dx = vec![S::ZERO; line.states()];
    let mut loads = Loads::default();
    line.evaluate(&sections, wind, &x, &mut dx, &mut loads);
    let matrix = loads.added_mass.iter().flatten().copied();
    dx.iter().copied().chain(loads.wrench.force.0).chain(loads.wrench.moment.0).chain(matrix).collect()
}

#[test]
fn duals_agree_with_central_differences() {
    for law in LiftLaw::ALL {
        let line = LiftingLine::with_chords(
            0.5,
            |_| 0.15,
            LiftingLineSettings { section: SectionSettings { law, ..settings(7).section }, ..settings(7) },
        )
        .unwrap();
        let exact = outputs(&line, Dual::<1>::variable(0.3, 0));
        let h = 1e-5;
        let (plus, minus) = (outputs(&line, 0.3 + h), outputs(&line, 0.3 - h));
        for (i, e) in exact.iter().enumerate() {
            let difference = (plus[i] - minus[i]) / (2.0 * h);
            assert!((difference - e.eps[0]).abs() < 1e-7 * (1.0 + e.eps[0].abs()), "output {i}");
        }
    }
}

#[test]
fn any_wind_gives_finite_loads_that_vary_smoothly() {
    for law in LiftLaw::ALL {
        let line = LiftingLine::with_chords(
            0.5,
            |_| 0.2,
            LiftingLineSettings { section: SectionSettings { law, ..settings(6).section }, ..settings(6) },
        )
        .unwrap();
        let still =
            FlappingHalves { position: Vec3::ZERO, flap: 0.0.into(), pitch: 0.0.into(), sweep: 0.0.into() };
        let constant: FlappingHalves<Dual<1>> = FlappingHalves {
            position: Vec3::ZERO,
            flap: Jet::from(0.0),
            pitch: Jet::from(0.0),
            sweep: Jet::from(0.0),
        };
        let zero = vec![0.0; line.states()];
        let loads = |wind| {
            let mut loads = Loads::default();
            let mut dx = zero.clone();
            line.evaluate(&still.sections(&line), wind, &zero, &mut dx, &mut loads);
            assert!(dx.iter().all(|v| v.is_finite()));
            loads.wrench
        };
        for speed in [0.0, 1e-9, 2.0, 50.0] {
            let mut last = loads(Vec3::new(-speed, 0.0, 0.0));
            for k in 0..=720 {
                let angle = PI * k as f64 / 360.0;
                let wind = Vec3::new(-speed * angle.cos(), 0.0, speed * angle.sin());
                let now = loads(wind);
                let jump = (now.force - last.force).norm() + (now.moment - last.moment).norm();
                assert!(now.force.is_finite() && jump < 0.2 * speed * speed + 1e-12, "{law:?} {k}: {jump}");
                last = now;
            }
        }
        let x = vec![Dual::<1>::constant(0.0); line.states()];
        let mut dx = x.clone();
        let wind = Vec3::new(Dual::variable(0.0, 0), Dual::from(0.0), Dual::from(0.0));
        let (wrench, matrix) = line.evaluate_sum(&constant.sections(&line), wind, &x, &mut dx, None);
        assert!(wrench.force.is_finite() && wrench.moment.is_finite());
        assert!(dx.iter().chain(matrix.iter().flatten()).all(|v| v.is_finite()));
    }
}

#[test]
fn settings_outside_their_range_are_refused() {
    let refuse = |set: LiftingLineSettings| LiftingLine::with_chords(0.5, |_| 0.1, set).is_err();
    assert!(refuse(LiftingLineSettings { nodes: 1, ..Default::default() }));
    assert!(refuse(LiftingLineSettings { nodes: MAX_STRIPS + 1, ..Default::default() }));
    assert!(refuse(LiftingLineSettings { regularisation_m_s: 0.0, ..Default::default() }));
    assert!(refuse(LiftingLineSettings {
        section: SectionSettings { density_kg_m3: f64::NAN, ..Default::default() },
        ..Default::default()
    }));
}

#[test]
fn the_carried_air_of_a_pitching_plate_is_theodorsens() {
    // NACA Rep. 496, eqs. (18), (20), non-circulatory part; the axis lies a b behind mid chord.
    let (chord, u, a) = (0.2, 3.0, 0.3);
    let b = 0.5 * chord;
    let set = LiftingLineSettings { regularisation_m_s: 1e-9, ..settings(4) };
    let line = LiftingLine::with_chords(0.5, |_| chord, set).unwrap();
    let (h_ddot, q, q_dot) = (2.0, 1.5, -7.0);
    let h_dot = q * (a * b - 0.5 * b); // no wash at 3/4 chord
    let at = |x: f64, arc: f64| {
        let (v, w) = (-h_dot + q * x, -h_ddot + q_dot * x);
        (Vec3::new(x, arc, 0.0), Vec3::new(0.0, 0.0, v), Vec3::new(-q * q * x, 0.0, w))
    };
    let section = |&arc: &f64| {
        let ((le, v_le, a_le), (te, v_te, a_te)) = (at(a * b + b, arc), at(a * b - b, arc));
        let turn = |rate: f64| Vec3::new(0.0, -rate, 0.0);
        let (w, alpha) = (turn(q), turn(q_dot));
        SectionMotion { le, te, v_le, v_te, a_le, a_te, span: turn(1.0), w, alpha }
    };
    let sections: Vec<_> = line.arcs().iter().map(section).collect();
    let loads = loads_of(&line, &sections, Vec3::new(-u, 0.0, 0.0));
    let lift = h_ddot + u * q - a * b * q_dot;
    let moment = a * b * h_ddot - u * b * (0.5 - a) * q - b * b * (0.125 + a * a) * q_dot;
    for (strip, node) in loads.strip.iter().zip(&line.nodes) {
        assert!((strip.added_mass.force[2] / (node.mass * lift) - 1.0).abs() < 1e-12);
        assert!((-strip.added_mass.moment[1] / (node.mass * moment) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn nodes_between_hinges_know_every_sine_and_the_whole_wing() {
    let rows = [[0.0, 0.02, -0.14], [0.07, 0.035, -0.15], [0.15, 0.08, -0.02], [0.2, 0.06, 0.04]];
    let stations = rows.map(|[arc_m, leading_edge_m, trailing_edge_m]| crate::PlanformStation {
        arc_m,
        leading_edge_m,
        trailing_edge_m,
    });
    let planform = crate::Planform::new(&stations).unwrap();
    for nodes in [8, 12, 13, 16, 32] {
        let line = LiftingLine::hinged(&planform, &[0.02, 0.07], settings(nodes)).unwrap();
        for n in 1..=nodes {
            let angles: Vec<f64> = line.arcs().iter().map(|arc| (arc / 0.2).acos()).collect();
            let gamma: Vec<f64> = angles.iter().map(|t| (n as f64 * t).sin()).collect();
            for (i, t) in angles.iter().enumerate() {
                let exact = -(n as f64) * (n as f64 * t).sin() / (0.8 * t.sin());
                let error = line.induced_wash(i, &gamma) - exact;
                assert!(error.abs() < 1e-9 * n as f64 * nodes as f64, "{nodes}, {n}: {error}");
            }
        }
        let drag: f64 = line.nodes.iter().map(|node| node.drag).sum();
        assert!((drag / (0.5 * line.settings.section.density_kg_m3 * planform.area()) - 1.0).abs() < 1e-12);
        for (a, b) in line.arcs().iter().zip(line.arcs().iter().rev()) {
            assert!((a + b).abs() < 1e-15);
        }
    }
}

#[test]
fn nodes_between_hinges_converge_with_their_number() {
    let station =
        |arc_m, trailing_edge_m| crate::PlanformStation { arc_m, leading_edge_m: 0.1, trailing_edge_m };
    let wing = [station(0.0, -0.1), station(0.3, -0.2), station(0.5, -0.02)];
    let planform = crate::Planform::new(&wing).unwrap();
    let lift = |nodes: usize| {
        let line = LiftingLine::hinged(&planform, &[0.1, 0.25], settings(nodes)).unwrap();
        let (airspeed, wash) = (vec![1.0; nodes], vec![0.1; nodes]);
        let (mut x, mut dx, mut w) = (vec![0.0; 3 * nodes], vec![0.0; 3 * nodes], vec![0.0; nodes]);
        for _ in 0..20000 {
            line.rates_in_wash(&airspeed, &wash, &x, &mut dx, &mut w);
            x.iter_mut().zip(&dx).for_each(|(x, d)| *x += 0.005 * d);
        }
        x[..nodes].iter().zip(line.widths()).map(|(g, w)| g * w).sum::<f64>()
    };
    let [coarse, middle, fine] = [8, 16, 32].map(lift);
    assert!((middle / fine - 1.0).abs() < 0.005, "{coarse} {middle} {fine}");
    assert!((middle / fine - 1.0).abs() < (coarse / fine - 1.0).abs());
}

#[test]
fn a_pitching_section_has_garricks_suction() {
    let set = LiftingLineSettings {
        section: SectionSettings { drag: ProfileDrag { cd0: 0.0, cd90: 0.0 }, ..settings(5).section },
        ..settings(5)
    };
    let line = LiftingLine::with_chords(0.5, |_| 0.2, set).unwrap();
    let rate = 3.0;
    let pitching = |arc: &f64| {
        let at = |x: f64| (Vec3::new(x, *arc, 0.0), Vec3::new(0.0, 0.0, rate * (x + 0.03)));
        let ((le, v_le), (te, v_te)) = (at(0.05), at(-0.15));
        let (span, w) = (Vec3::new(0.0, -1.0, 0.0), Vec3::new(0.0, -rate, 0.0));
        SectionMotion { le, te, v_le, v_te, span, w, ..SectionMotion::default() }
    };
    let sections: Vec<_> = line.arcs().iter().map(pitching).collect();
    let x = state(&line);
    let mut loads = Loads::default();
    line.evaluate(&sections, Vec3::new(-80.0, 0.0, 0.1), &x, &mut vec![0.0; x.len()], &mut loads);
    for i in 0..5 {
        let node = &line.nodes[i];
        let (b, w) = (node.half_chord, 0.1 + rate * 0.07);
        let effective = (w + line.induced_wash(i, &x[..5])) * 0.5 + 0.165 * x[5 + i] + 0.335 * x[10 + i];
        // Lift counts with the nodes' widths, what the air carries with Fejer's; both are exact for their kind.
        let (lift, mass) = (node.lift, node.mass);
        let suction = lift * effective * effective - 2.0 * mass * rate * (effective - 0.25 * b * rate);
        let force = loads.strip[i].total().force[0];
        assert!((force - suction).abs() < 1e-3 * suction.abs(), "{i}: {force} {suction}");
    }
}
