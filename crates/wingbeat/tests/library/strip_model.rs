//! Limits, symmetries and smoothness of the strip model.

mod sections;
mod wing;

use std::f64::consts::PI;
use wing::{ELBOW, Wing, planform};
use wingbeat::aero::{
    Gap, LagSet, LiftLaw, Loads, Planform, PlanformStation, ProfileDrag, SectionMotion, SectionSettings,
    StripModel, StripSettings,
};
use wingbeat::math::{Dual, Random, Scalar, Vec3, linear::solve_symmetric};

fn settings(strips: usize) -> StripSettings {
    StripSettings { strips, hinge_arcs_m: vec![0.0, ELBOW], ..Default::default() }
}

fn model(settings: StripSettings) -> StripModel {
    StripModel::new(&planform(), settings).unwrap()
}

fn state(model: &StripModel) -> Vec<f64> {
    (0..model.states()).map(|i| 0.05 * (1.7 * i as f64).sin()).collect()
}

fn evaluate(
    model: &StripModel,
    sections: &[SectionMotion<f64>],
    wind: Vec3<f64>,
    x: &[f64],
) -> (Vec<f64>, Loads<f64>) {
    let mut loads = Loads::default();
    let mut dx = vec![0.0; model.states()];
    model.evaluate_in_numbers(sections, wind, x, &mut dx, &mut loads);
    (dx, loads)
}

/// Every combination of law and lag set.
fn variants() -> Vec<StripModel> {
    let five = [LiftLaw::Stall, LiftLaw::Lev].map(|law| (law, LagSet::Five));
    let three = LiftLaw::ALL.map(|law| (law, LagSet::Three));
    three
        .into_iter()
        .chain(five)
        .map(|(law, lags)| {
            model(StripSettings {
                lags,
                section: SectionSettings { law, ..settings(10).section },
                ..settings(10)
            })
        })
        .collect()
}

#[test]
fn loads_are_affine_in_the_body_acceleration() {
    for model in variants() {
        let sections = Wing::cyclic(0.7, 20.0).sections(model.arcs(), &planform());
        let (a, w_dot) = (Vec3::new(3.0, -2.0, 5.0), Vec3::new(40.0, 20.0, -30.0));
        let full: Vec<_> = sections
            .iter()
            .map(|s| SectionMotion {
                a_le: s.a_le + a + w_dot.cross(s.le),
                a_te: s.a_te + a + w_dot.cross(s.te),
                ..*s
            })
            .collect();
        let (wind, x) = (Vec3::new(-1.5, 0.2, 0.4), state(&model));
        let (bias, full) = (evaluate(&model, &sections, wind, &x).1, evaluate(&model, &full, wind, &x).1);
        let s = [a[0], a[1], a[2], w_dot[0], w_dot[1], w_dot[2]];
        for i in 0..6 {
            let pick = |l: &Loads<f64>| if i < 3 { l.wrench.force[i] } else { l.wrench.moment[i - 3] };
            let carried: f64 = (0..6).map(|j| bias.added_mass[i][j] * s[j]).sum();
            let difference = pick(&bias) - carried - pick(&full);
            assert!(difference.abs() < 1e-12 * (1.0 + carried.abs()), "row {i}: {difference}");
        }
    }
}

#[test]
fn the_added_mass_is_symmetric_and_positive() {
    for model in variants() {
        for k in 0..12 {
            let sections = Wing::cyclic(0.5 * k as f64, 20.0).sections(model.arcs(), &planform());
            let (_, loads) = evaluate(&model, &sections, Vec3::new(-1.5, 0.2, 0.4), &state(&model));
            let mut matrix = loads.added_mass;
            for i in 0..6 {
                for j in 0..6 {
                    assert_eq!(matrix[i][j], matrix[j][i]);
                }
                matrix[i][i] += 1e-9; // sliding within the plane moves no air
            }
            assert!(solve_symmetric(matrix, [1.0; 6]).is_some());
        }
    }
}

#[test]
fn a_common_velocity_of_wing_and_wind_changes_nothing() {
    for model in variants() {
        let sections = Wing::cyclic(0.4, 20.0).sections(model.arcs(), &planform());
        let (wind, shift, x) = (Vec3::new(-1.5, 0.2, 0.4), Vec3::new(7.0, -3.0, 2.0), state(&model));
        let moved: Vec<_> = sections
            .iter()
            .map(|s| SectionMotion { v_le: s.v_le + shift, v_te: s.v_te + shift, ..*s })
            .collect();
        let (dx, loads) = evaluate(&model, &sections, wind, &x);
        let (dx_moved, moved) = evaluate(&model, &moved, wind + shift, &x);
        assert!((loads.wrench.force - moved.wrench.force).norm() < 1e-11);
        assert!((loads.wrench.moment - moved.wrench.moment).norm() < 1e-12);
        assert!(dx.iter().zip(&dx_moved).all(|(a, b)| (a - b).abs() < 1e-9 * (1.0 + a.abs())));
    }
}

#[test]
fn a_mirrored_motion_mirrors_the_loads() {
    for model in variants() {
        let n = model.strips();
        let x: Vec<f64> = (0..model.states())
            .map(|i| 0.04 + 0.02 * ((i % n) as f64 - (n - 1) as f64 / 2.0).abs())
            .collect();
        let sections = Wing::cyclic(1.1, 15.0).sections(model.arcs(), &planform());
        let (_, loads) = evaluate(&model, &sections, Vec3::new(-2.0, 0.0, 0.3), &x);
        assert!(loads.wrench.force[1].abs() < 1e-13 && loads.wrench.force[2].abs() > 1e-3);
        assert!(loads.wrench.moment[0].abs() < 1e-13 && loads.wrench.moment[2].abs() < 1e-13);
        for i in 0..n / 2 {
            let (a, b) = (loads.strip[i].total(), loads.strip[n - 1 - i].total());
            assert!((a.force[2] - b.force[2]).abs() < 1e-13 && (a.force[1] + b.force[1]).abs() < 1e-13);
            assert!((a.moment[1] - b.moment[1]).abs() < 1e-13 && (a.moment[0] + b.moment[0]).abs() < 1e-13);
        }
    }
}

#[test]
fn sums_agree_and_breakdown_adds_up() {
    for model in variants() {
        let sections = Wing::cyclic(0.4, 20.0).sections(model.arcs(), &planform());
        let (wind, x) = (Vec3::new(-1.5, 0.2, 0.4), state(&model));
        let (dx, loads) = evaluate(&model, &sections, wind, &x);
        let mut dx_sum = vec![0.0; model.states()];
        let (wrench, added_mass) = model.sum_in_numbers(&sections, wind, &x, &mut dx_sum);
        assert_eq!((dx, added_mass), (dx_sum, loads.added_mass));
        for w in [wrench, loads.by_source().total()] {
            assert!((w.force - loads.wrench.force).norm() < 1e-13);
            assert!((w.moment - loads.wrench.moment).norm() < 1e-13);
        }
    }
}

/// Wrench, rates and added mass for a wing whose phase, wind and states depend on `p`.
fn outputs<S: Scalar>(model: &StripModel, p: S) -> Vec<S> {
    let sections = Wing::cyclic(p + 0.6, 15.0).sections(model.arcs(), &planform());
    let wind = Vec3::new(S::from(-1.5), p * 0.5, p.sin() + 0.2);
    let x: Vec<S> = state(model).iter().map(|&v| p * v + v).collect();
    let mut dx = vec![S::ZERO; model.states()];
    let mut loads = Loads::default();
    model.evaluate(&sections, wind, &x, &mut dx, &mut loads);
    let matrix = loads.added_mass.iter().flatten().copied();
    dx.iter().copied().chain(loads.wrench.force.0).chain(loads.wrench.moment.0).chain(matrix).collect()
}

#[test]
fn duals_agree_with_central_differences() {
    for model in variants() {
        let exact = outputs(&model, Dual::<1>::variable(0.3, 0));
        let h = 1e-5;
        let [plus, minus] = [0.3 + h, 0.3 - h].map(|p| outputs(&model, Dual::<1>::constant(p)));
        for (i, e) in exact.iter().enumerate() {
            let difference = (plus[i].re - minus[i].re) / (2.0 * h);
            assert!(
                (difference - e.eps[0]).abs() < 1e-6 * (1.0 + e.eps[0].abs()),
                "output {i}: {difference} {}",
                e.eps[0]
            );
        }
    }
}

#[test]
fn the_carried_air_of_strips_gives_no_mean_force() {
    let set = StripSettings { wake_wash: false, doublet_wash: false, ..settings(10) };
    let model = model(set);
    let steps = 96;
    let (mut sum, mut largest) = ([Vec3::ZERO; 10], [0.0_f64; 10]);
    for k in 0..steps {
        let wing = Wing::cyclic(2.0 * PI * k as f64 / steps as f64, 20.0);
        let sections = wing.sections(model.arcs(), &planform());
        let (_, loads) = evaluate(&model, &sections, Vec3::new(-2.0, 0.3, 0.2), &state(&model));
        for i in 0..10 {
            let force = loads.strip[i].added_mass.force;
            sum[i] += force;
            largest[i] = largest[i].max(force.norm());
        }
    }
    for i in 0..10 {
        assert!(
            sum[i].norm() / steps as f64 / largest[i] < 1e-8,
            "strip {i}: {}",
            sum[i].norm() / largest[i]
        );
    }
}

#[test]
fn switches_leave_out_what_they_name() {
    let wind = Vec3::new(-2.0, 0.0, 0.4);
    let loads = |set: StripSettings| {
        let model = model(set);
        let sections = Wing::cyclic(0.9, 15.0).sections(model.arcs(), &planform());
        evaluate(&model, &sections, wind, &state(&model)).1
    };
    let all = loads(settings(10));
    let no_tilt = loads(StripSettings { force_tilt: false, ..settings(10) });
    assert_eq!(no_tilt.by_source().induced_drag.force, Vec3::ZERO);
    assert!(all.by_source().induced_drag.force.norm() > 1e-3);
    let no_mass = loads(StripSettings {
        section: SectionSettings { added_mass: false, section_moment: false, ..settings(10).section },
        ..settings(10)
    });
    assert_eq!(no_mass.added_mass, [[0.0; 6]; 6]);
    let infinite = loads(StripSettings { wake_wash: false, doublet_wash: false, ..settings(10) });
    assert!((infinite.wrench.force - all.wrench.force).norm() > 1e-3);
}

/// Flat strips of an infinite wing of unit chord in a wind of 1 m/s, without drag, under `law`.
fn plane_strips(law: LiftLaw) -> StripModel {
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.25, trailing_edge_m: -0.75 };
    let wing = Planform::new(&[station(0.0), station(4.0)]).unwrap();
    let set = StripSettings {
        strips: 6,
        wake_wash: false,
        doublet_wash: false,
        regularisation_m_s: 1e-6,
        section: SectionSettings {
            law,
            drag: ProfileDrag { cd0: 0.0, cd90: 0.0 },
            density_kg_m3: 1.0,
            ..Default::default()
        },
        ..Default::default()
    };
    StripModel::new(&wing, set).unwrap()
}

/// Its sections, pitching nose up at `rate` (rad/s) about `axis` m ahead of the quarter chord.
fn plane_sections(model: &StripModel, rate: f64, axis: f64) -> Vec<SectionMotion<f64>> {
    let at = |x: f64, arc: f64| (Vec3::new(x, arc, 0.0), Vec3::new(0.0, 0.0, rate * (x - axis)));
    let section = |arc: &f64| {
        let ((le, v_le), (te, v_te)) = (at(0.25, *arc), at(-0.75, *arc));
        SectionMotion { le, te, v_le, v_te, ..SectionMotion::default() }
    };
    model.arcs().iter().map(section).collect()
}

#[test]
fn a_pitching_strip_has_garricks_suction() {
    let model = plane_strips(LiftLaw::Linear);
    let (rate, axis, wind) = (0.02, -0.1, Vec3::new(-1.0, 0.0, 0.01));
    let x: Vec<f64> = (0..model.states()).map(|i| 0.01 * (1.3 * i as f64).sin()).collect();
    let (_, loads) = evaluate(&model, &plane_sections(&model, rate, axis), wind, &x);
    let lags = LagSet::Three.lags();
    let (own, _) = lags.of_wing(&lags.numbers(), model.widths().iter().sum());
    for i in 0..6 {
        // Upwash at 3/4 chord: the wind's, and the speed down of what lies behind the axis.
        let wash = 0.01 + rate * (0.5 + axis);
        let lift_wash =
            0.5 * wash + own.iter().enumerate().map(|(k, lag)| lag.weight * x[6 * k + i]).sum::<f64>();
        let suction = PI * model.widths()[i] * (lift_wash - 0.25 * rate).powi(2);
        let force = loads.strip[i].total().force[0];
        assert!((force - suction).abs() < 1e-3 * suction, "{i}: {force} {suction}");
    }
}

#[test]
fn law_lev_turns_the_suction_that_the_edge_cannot_hold_into_normal_force() {
    let (linear, lev) = (plane_strips(LiftLaw::Linear), plane_strips(LiftLaw::Lev));
    let suction_and_normal = |model: &StripModel, alpha: f64, vortex: f64| {
        let mut x = vec![alpha.sin(); model.states()];
        if model.states() > 18 {
            x[18..24].fill(vortex);
            x[24..30].fill(0.0);
        }
        let wind = Vec3::new(-alpha.cos(), 0.0, alpha.sin());
        let (dx, loads) = evaluate(model, &plane_sections(model, 0.0, 0.0), wind, &x);
        let scale = 0.5 * model.widths()[2];
        (dx, loads.strip[2].total().force[0] / scale, loads.strip[2].total().force[2] / scale, loads)
    };
    // Thin-airfoil theory: c_s = 2 pi sin^2 and c_n = 2 pi sin cos; the edge holds 2 pi A0c^2 = 0.0760.
    for degrees in [1.0_f64, 3.0] {
        let ((_, a, n, _), (_, b, m, loads)) = (
            suction_and_normal(&linear, degrees.to_radians(), 0.0),
            suction_and_normal(&lev, degrees.to_radians(), 0.0),
        );
        assert!((b / a - 1.0).abs() < 0.002 && (m / n - 1.0).abs() < 1e-9, "{degrees}: {a} {b}");
        assert!(loads.suction_lost[2] < 0.002 && loads.separated[2] == 0.0);
    }
    let alpha = 25_f64.to_radians();
    let limit = 2.0 * PI * 0.11_f64.powi(2);
    let lost = 2.0 * PI * alpha.sin().powi(2) - limit;
    let (dx, held, normal, _) = suction_and_normal(&lev, alpha, lost);
    assert!((held / limit - 1.0).abs() < 1e-3, "{held} {limit}");
    let attached = 2.0 * PI * alpha.sin() * alpha.cos();
    assert!((normal / (attached + lost) - 1.0).abs() < 1e-3, "{normal} {attached} {lost}");
    // The vortex is in balance; the separated share grows towards its static value in eight chords.
    let still = 1.0 - 1.0 / (1.0 + (alpha.sin() / 12_f64.to_radians().sin()).powi(4) / 3.0);
    assert!(dx[20].abs() < 1e-3 * lost && (dx[26] * 8.0 / still - 1.0).abs() < 1e-6);
}

#[test]
fn idle_lanes_carry_nothing() {
    for strips in [8, 9, 13, 16] {
        for law in LiftLaw::ALL {
            let model = model(StripSettings {
                hinge_arcs_m: vec![],
                section: SectionSettings { law, ..settings(strips).section },
                ..settings(strips)
            });
            let sections = Wing::still(0.0, 0.0).sections(model.arcs(), &planform());
            let (_, loads) =
                evaluate(&model, &sections, Vec3::new(-1.0, 0.0, 1.5), &vec![0.3; model.states()]);
            let sum = loads.by_source().total();
            assert!((sum.force - loads.wrench.force).norm() < 1e-13, "{law:?} {strips}");
            assert!(loads.wrench.force[1].abs() < 1e-13 && loads.wrench.moment[0].abs() < 1e-13);
        }
    }
}

#[test]
fn strips_of_an_infinite_wing_have_the_slope_two_pi() {
    let model = plane_strips(LiftLaw::Linear);
    let sections = plane_sections(&model, 0.0, 0.0);
    let alpha: f64 = 1e-4;
    // The lags of a steady stream hold the wash itself.
    let mut x = vec![alpha; model.states()];
    for i in 0..6 {
        x[12 + i] = PI * alpha;
    }
    let (dx, loads) = evaluate(&model, &sections, Vec3::new(-1.0, 0.0, alpha), &x);
    assert!(dx.iter().all(|v| v.abs() < 1e-9));
    let area: f64 = model.widths().iter().sum();
    assert!((loads.wrench.force[2] / (0.5 * area * alpha) / (2.0 * PI) - 1.0).abs() < 1e-6);
}

/// Steady lift slope and induced drag over the Trefftz drag of its own loading, for a
/// rectangular wing of the given aspect ratio.
fn steady_rectangle(aspect: f64) -> (f64, f64) {
    steady_strips(0.5 * aspect, &[], 16)
}

/// Incidence of wings at rest, rad.
const SMALL: f64 = 1e-3;

/// A flat wing of unit chord at rest in a wind that has blown for long.
struct SteadyWing {
    planform: Planform,
    settings: StripSettings,
    sections: Vec<SectionMotion<f64>>,
    wind: Vec3,
    x: Vec<f64>,
}

impl SteadyWing {
    fn new(half_span: f64, gaps: &[Gap], strips: usize) -> Self {
        Self::swept(half_span, gaps, strips, 0.0)
    }

    /// The edges run aft by `slope` times the arc.
    fn swept(half_span: f64, gaps: &[Gap], strips: usize, slope: f64) -> Self {
        Self::at(half_span, gaps, strips, slope, (SMALL, LiftLaw::Linear))
    }

    /// The same at an incidence under a law of lift.
    fn at(half_span: f64, gaps: &[Gap], strips: usize, slope: f64, of: (f64, LiftLaw)) -> Self {
        Self::from_share(half_span, gaps, strips, slope, of, 0.0)
    }

    /// The same, whose flow begins with the share `separated`, where the law has such a state.
    fn from_share(
        half_span: f64,
        gaps: &[Gap],
        strips: usize,
        slope: f64,
        (incidence, law): (f64, LiftLaw),
        separated: f64,
    ) -> Self {
        let station = |arc_m| {
            let leading_edge_m = -slope * arc_m;
            PlanformStation { arc_m, leading_edge_m, trailing_edge_m: leading_edge_m - 1.0 }
        };
        let planform = Planform::new(&[station(0.0), station(half_span)]).unwrap().with_gaps(gaps).unwrap();
        let drag = ProfileDrag { cd0: 0.0, cd90: 0.0 };
        let settings = StripSettings {
            strips,
            regularisation_m_s: 1e-6,
            section: SectionSettings { drag, law, density_kg_m3: 1.0, ..Default::default() },
            ..Default::default()
        };
        let model = StripModel::new(&planform, settings.clone()).unwrap();
        let at = |x: f64, s: f64| Vec3::new(x, s, 0.0);
        let still = |&s: &f64| {
            let le = at(-slope * s.abs(), s);
            SectionMotion { le, te: le + at(-1.0, 0.0), ..SectionMotion::default() }
        };
        let sections: Vec<_> = model.arcs().iter().map(still).collect();
        let wind = Vec3::new(-incidence.cos(), 0.0, incidence.sin());
        let begins = |name: &str| if name.starts_with("separated") { separated } else { 0.0 };
        let mut x: Vec<f64> = model.channels().iter().map(|channel| begins(&channel.name)).collect();
        for _ in 0..6000 {
            let (dx, _) = evaluate(&model, &sections, wind, &x);
            x.iter_mut().zip(&dx).for_each(|(x, d)| *x += 0.05 * d);
        }
        Self { planform, settings, sections, wind, x }
    }

    /// Its edges and the forces of its strips in a wind that drifts by `drift` m/s along y, without and with the suction of edges.
    fn with_edges(&self, drift: f64) -> (Vec<f64>, [Vec<Vec3>; 2]) {
        let wind = self.wind + Vec3::new(0.0, drift, 0.0);
        let mut arcs = Vec::new();
        let forces = [false, true].map(|edge_suction| {
            let (edge_suction, turning_impulse) = (Some(edge_suction), Some(false));
            let settings = StripSettings { edge_suction, turning_impulse, ..self.settings.clone() };
            let model = StripModel::new(&self.planform, settings).unwrap();
            arcs = model.arcs().to_vec();
            let (_, loads) = evaluate(&model, &self.sections, wind, &self.x);
            loads.strip.iter().map(|strip| strip.circulatory.force + strip.induced_drag.force).collect()
        });
        (arcs, forces)
    }

    /// The model and its loads, with or without vortices above its side edges.
    fn loads(&self, side_edges: bool) -> (StripModel, Loads<f64>) {
        let settings = StripSettings { side_edges, ..self.settings.clone() };
        let model = StripModel::new(&self.planform, settings).unwrap();
        let (_, loads) = evaluate(&model, &self.sections, self.wind, &self.x);
        (model, loads)
    }
}

/// Only the outermost strips bear it, along the normal.
#[test]
fn side_edges_have_the_suction_of_a_vortex_lattice() {
    // The lattice of validation/lifting_surface/side_edges.csv: pull over q S a^2, that times the distance behind mid chord.
    for (aspect, [pull, behind]) in [(2.0, [1.5698, 0.1315]), (8.0, [0.5477, 0.0454])] {
        let wing = SteadyWing::new(0.5 * aspect, &[], 16);
        let [without, with] = [false, true].map(|side_edges| wing.loads(side_edges).1);
        let scale = 0.5 * aspect * SMALL * SMALL;
        let normal = (with.wrench.force[2] - without.wrench.force[2]) / scale;
        assert!((normal / pull - 1.0).abs() < 0.03, "AR {aspect}: {normal} {pull}");
        // The moment is nose down about mid chord, at x = -0.5.
        let moment = (with.wrench.moment[1] - without.wrench.moment[1]) / scale - 0.5 * normal;
        assert!((moment / behind - 1.0).abs() < 0.06, "AR {aspect}: {moment} {behind}");
        let added = |i: usize| with.strip[i].total().force[2] - without.strip[i].total().force[2];
        let uneven =
            (added(0) / added(15) - 1.0).abs() + ((added(0) + added(15)) / (normal * scale) - 1.0).abs();
        assert!(uneven < 1e-6, "AR {aspect}: {uneven}");
        let across: f64 =
            [0, 1].iter().map(|k| (with.wrench.force[*k] - without.wrench.force[*k]).abs()).sum();
        assert!(across < 1e-6 * normal * scale, "{across}");
    }
}

#[test]
fn suction_is_square_to_swept_edges() {
    for slope in [-0.3, 0.0, 0.5] {
        let wing = SteadyWing::swept(2.0, &[], 8, slope);
        let (arcs, [without, with]) = wing.with_edges(0.0);
        let [plain, vortices] = [false, true].map(|side_edges| wing.loads(side_edges).1);
        let mut least = f64::MAX;
        for i in 0..8 {
            let outward = if arcs[i] > 1e-9 { 1.0 } else { -1.0 };
            let added = with[i] - without[i];
            // No drag: what points forward is suction. The circulation has 0.89 of the pull of a tip, which the vortices tell.
            let tip = vortices.strip[i].total().force[2] - plain.strip[i].total().force[2];
            let expected = outward * (slope * without[i][0] + 0.89017 * tip.abs());
            least = least.min(without[i][0]);
            let off = (added - Vec3::new(0.0, expected, 0.0)).norm();
            assert!(
                off < 1e-4 * (without[i][0] + expected.abs()),
                "{slope}, strip {i}: {added:?}, {expected}"
            );
            assert_eq!(tip.abs() > 0.0, i == 0 || i == 7);
        }
        assert!(least > 0.0);
    }
    let wing = SteadyWing::new(1.0, &[], 16);
    let one = StripSettings { edge_suction: Some(true), strips: 1, ..wing.settings.clone() };
    let both = StripSettings { edge_suction: Some(true), turning_impulse: Some(true), ..wing.settings };
    for settings in [one, both] {
        let refused = StripModel::new(&wing.planform, settings).err().map(|error| error.to_string());
        assert!(refused.as_ref().is_some_and(|text| text.contains("edge_suction")), "{refused:?}");
    }
}

/// What stays attached beside a tip does not depend on how narrow the strips there are: at 25 deg the law `stall` leaves 0.31 attached.
#[test]
fn the_pull_of_a_stalled_tip_converges_with_the_strips() {
    for (law, limits) in [
        (LiftLaw::Linear, [0.1, 0.03]),
        (LiftLaw::Stall, [0.1, 0.03]),
        (LiftLaw::Lev, [0.1, 0.03]),
        (LiftLaw::Lev3d, [0.3, 0.06]),
    ] {
        let pulls = [8, 16, 32].map(|strips| {
            let wing = SteadyWing::at(2.0, &[], strips, 0.0, (25_f64.to_radians(), law));
            let (_, [without, with]) = wing.with_edges(0.0);
            let along = with[0][1] - without[0][1];
            let [plain, vortices] = [false, true].map(|side_edges| wing.loads(side_edges).1);
            [along, vortices.strip[0].total().force[2] - plain.strip[0].total().force[2]]
        });
        for force in [0, 1] {
            let off = |n: usize| (pulls[n][force] / pulls[2][force] - 1.0).abs();
            assert!(off(0) < limits[0] && off(1) < limits[1], "{law:?}: {pulls:?}");
        }
    }
}

/// Attached or separated at first, a wing past stall comes to rest in the same state, and its lift does not go with the number of strips.
#[test]
fn a_wing_past_stall_has_one_state_of_rest() {
    for (law, half_span, degrees) in
        [(LiftLaw::Lev, 2.0, 25.0_f64), (LiftLaw::Lev3d, 2.0, 18.0), (LiftLaw::Lev, 3.125, 40.0)]
    {
        let of = (degrees.to_radians(), law);
        let rest = |strips: usize, separated: f64| {
            SteadyWing::from_share(half_span, &[], strips, 0.0, of, separated)
        };
        let lift = |wing: &SteadyWing| wing.loads(false).1.wrench.force[2];
        let [attached, separated] = [0.0, 1.0].map(|share| rest(32, share));
        let apart = attached.x.iter().zip(&separated.x).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(apart < 1e-4, "{law:?} at {degrees} deg: {apart}");
        let coarse = lift(&rest(16, 0.0)) / lift(&attached) - 1.0;
        assert!(coarse.abs() < 0.01, "{law:?} at {degrees} deg: {coarse}");
    }
}

#[test]
fn a_drifting_section_feels_the_circulation_beside_it() {
    for slope in [0.0, 0.5] {
        let (arcs, [without, with]) = SteadyWing::swept(2.0, &[], 16, slope).with_edges(0.2);
        // The sections' axis points to the right, against the drift; the speed along the chord is one.
        let bound: Vec<f64> = (0..16).map(|i| without[i][2] / (arcs[i] - arcs[i + 1])).collect();
        let edge = |j: usize| if j == 0 || j == 16 { 0.0 } else { 0.5 * (bound[j - 1] + bound[j]) };
        let largest = bound.iter().fold(0.0_f64, |m, b| m.max(*b));
        for i in 0..16 {
            let width = arcs[i] - arcs[i + 1];
            let aft = slope * (arcs[i + 1].abs() - arcs[i].abs());
            let expected = -0.2 * (0.5 * (edge(i + 1) - edge(i)) - bound[i] * aft);
            let found = with[i][2] - without[i][2];
            assert!(
                (found - expected).abs() < 1e-3 * largest * width,
                "{slope}, strip {i}: {found} {expected}"
            );
        }
    }
}

#[test]
fn wings_that_are_not_whole_and_flat_refuse_side_edges() {
    let refused =
        |set: StripSettings| StripModel::new(&planform(), StripSettings { side_edges: true, ..set }).err();
    assert!(refused(StripSettings { hinge_arcs_m: vec![0.0], ..settings(10) }).is_none());
    assert!(refused(settings(10)).unwrap().to_string().contains("side_edges"));
    let half = planform().with_gaps(&[Gap { from_arc_m: 0.0, to_arc_m: 0.02 }]).unwrap();
    let set = StripSettings { side_edges: true, hinge_arcs_m: vec![], ..settings(10) };
    assert!(StripModel::new(&half, set).is_err());
}

/// The same of a wing of unit chord with gaps, given its half span.
fn steady_strips(half_span: f64, gaps: &[Gap], strips: usize) -> (f64, f64) {
    let wing = SteadyWing::new(half_span, gaps, strips);
    let (alpha, wind) = (SMALL, wing.wind);
    let (model, loads) = wing.loads(false);
    let lift = loads.wrench.force.dot(Vec3::new(alpha.sin(), 0.0, alpha.cos()));
    let drag = loads.wrench.force.dot(wind);
    let (gamma, edges, middles) = (&loads.circulation, model.arcs(), model.strip_arcs());
    let trefftz: f64 = (0..strips)
        .map(|i| {
            let pair = |j: usize| 1.0 / (middles[i] - edges[j + 1]) - 1.0 / (middles[i] - edges[j]);
            let downwash: f64 = (0..strips).map(|j| gamma[j] * pair(j) / (2.0 * PI)).sum();
            0.5 * gamma[i] * (edges[i] - edges[i + 1]) * downwash
        })
        .sum();
    (lift / (0.5 * wing.planform.area() * alpha), drag / trefftz)
}

/// Lift of the wing at rest with `strips`, folded to the dihedrals `shoulder` and `elbow` (rad), in a wind that has blown for long.
fn folded_lift(strips: usize, [shoulder, elbow]: [f64; 2]) -> f64 {
    let model = model(settings(strips));
    let sections = Wing::still(shoulder, elbow).sections(model.arcs(), &planform());
    let mut x = vec![0.0; model.states()];
    let mut lift = 0.0;
    for _ in 0..1500 {
        let (dx, loads) = evaluate(&model, &sections, Vec3::new(-2.0, 0.0, 0.02), &x);
        x.iter_mut().zip(&dx).for_each(|(x, d)| *x += 1e-3 * d);
        lift = loads.wrench.force[2];
    }
    lift
}

#[test]
fn the_lift_of_a_folded_wing_converges_with_its_strips() {
    for fold in [[0.0, 0.0], [0.3, -1.2], [0.5, -0.8]] {
        let fine = folded_lift(32, fold);
        for strips in [9, 10, 12, 16, 20] {
            let error = folded_lift(strips, fold) / fine - 1.0;
            assert!(error.abs() < 0.02, "{strips} strips, {fold:?}: {error}");
        }
    }
}

#[test]
fn the_wake_of_a_folded_wing_comes_sooner() {
    let model = model(StripSettings { lags: LagSet::Five, ..settings(16) });
    // Circulation by the first lag alone, nothing in the wake.
    let x: Vec<f64> = (0..model.states()).map(|i| if i < 16 { 0.1 } else { 0.0 }).collect();
    let rate = |shoulder: f64, elbow: f64| {
        let sections = Wing::still(shoulder, elbow).sections(model.arcs(), &planform());
        let wind = Vec3::new(-2.0, 0.0, 0.0);
        let (dx, _) = evaluate(&model, &sections, wind, &x);
        let quarter = |s: &SectionMotion<f64>| s.le + (s.te - s.le) * 0.25;
        (dx[3 * 16 + 3], (quarter(&sections[0]) - quarter(&sections[16])).norm())
    };
    let ((flat, span), (folded, between)) = (rate(0.0, 0.0), rate(0.4, -1.3));
    let chord = planform().area() / 0.5;
    let expected = ((between.powi(2) + chord.powi(2)) / (span.powi(2) + chord.powi(2)))
        .powf(-0.5 * LagSet::Five.lags().folding);
    assert!((folded / flat / expected - 1.0).abs() < 2e-3, "{folded} over {flat}, {expected} by the tips");
    assert!(expected > 1.05);
}

#[test]
fn rectangles_have_the_slope_of_the_lifting_surface_and_the_drag_of_their_wake() {
    // Slopes of the linear lifting surface, validation/lifting_surface/steady.csv.
    for (aspect, slope) in [(4.0, 3.612014), (8.0, 4.586058)] {
        let (value, drag) = steady_rectangle(aspect);
        assert!((value / slope - 1.0).abs() < 0.015, "AR {aspect}: {value}");
        assert!((drag - 1.0).abs() < 0.005, "AR {aspect}: {drag}");
    }
}

#[test]
fn wings_far_apart_lift_like_one_each_and_a_gap_costs_lift() {
    let apart = |gap: f64| {
        let gap = Gap { from_arc_m: 0.0, to_arc_m: 0.5 * gap };
        steady_strips(gap.to_arc_m + 4.0, &[gap], 17)
    };
    let (one, _) = steady_strips(2.0, &[], 8);
    let (far, drag) = apart(400.0);
    assert!((far / one - 1.0).abs() < 1e-3, "{far} against {one}");
    assert!((drag - 1.0).abs() < 0.005, "{drag}");
    let slopes = [0.02, 0.2, 1.0, 5.0].map(|gap| apart(gap).0);
    let (whole, _) = steady_strips(4.0, &[], 16);
    assert!(whole > slopes[0] && slopes.windows(2).all(|s| s[0] > s[1]), "{whole} {slopes:?}");
}

#[test]
fn a_gap_in_each_half_carries_nothing_and_no_air() {
    let gap = Gap { from_arc_m: 0.06, to_arc_m: 0.1 };
    let wing = planform().with_gaps(&[gap]).unwrap();
    let set = StripSettings { hinge_arcs_m: vec![], ..settings(12) };
    let model = StripModel::new(&wing, set).unwrap();
    let motion = Wing::cyclic(0.7, 20.0).sections(model.arcs(), &planform());
    let (_, loads) = evaluate(&model, &motion, Vec3::new(-1.5, 0.0, 0.3), &state(&model));
    let mut empty = 0;
    for (i, arc) in model.strip_arcs().iter().enumerate() {
        let force = loads.strip[i].total().force.norm();
        assert_eq!(force == 0.0, !wing.covers(*arc), "{arc}: {force}");
        empty += usize::from(force == 0.0);
    }
    assert_eq!(empty, 2);
    assert!((wing.area() - planform().area() + 2.0 * 0.04 * planform().chord(0.08)).abs() < 1e-12);
}

#[test]
fn bad_gaps_are_refused() {
    let refused = |gaps: &[(f64, f64)]| {
        let gaps: Vec<Gap> =
            gaps.iter().map(|&(from_arc_m, to_arc_m)| Gap { from_arc_m, to_arc_m }).collect();
        planform().with_gaps(&gaps).unwrap_err().to_string()
    };
    assert!(refused(&[(0.1, 0.1)]).starts_with("gaps[0].to_arc_m = 0.1"));
    assert!(refused(&[(0.0, 0.25)]).starts_with("gaps[0].to_arc_m = 0.25"));
    assert!(refused(&[(0.0, 0.1), (0.05, 0.2)]).starts_with("gaps[1].from_arc_m = 0.05"));
    assert!(refused(&[(0.05, 0.1), (0.1, 0.2)]).starts_with("gaps[1].from_arc_m = 0.1"));
    let gap = Gap { from_arc_m: 0.1, to_arc_m: 0.12 };
    let wing = planform().with_gaps(&[gap]).unwrap();
    assert!(StripModel::new(&wing, settings(4)).unwrap_err().to_string().starts_with("strips = 4"));
    let paper = wingbeat::aero::LiftingLine::new(&wing, wingbeat::aero::LiftingLineSettings::default());
    assert!(paper.unwrap_err().to_string().starts_with("gaps = 1 gaps"));
}

#[test]
fn bad_settings_are_refused() {
    let refused = |set: StripSettings| StripModel::new(&planform(), set).unwrap_err().to_string();
    assert_eq!(refused(settings(0)), "strips = 0: allowed is 1 to 32");
    assert!(refused(settings(33)).starts_with("strips = 33"));
    assert!(
        refused(StripSettings { hinge_arcs_m: vec![0.3], ..settings(8) })
            .starts_with("hinge_arcs_m[0] = 0.3")
    );
    assert!(
        refused(StripSettings {
            section: SectionSettings { density_kg_m3: 0.0, ..settings(8).section },
            ..settings(8)
        })
        .starts_with("density_kg_m3 = 0")
    );
    assert!(refused(StripSettings { hinge_arcs_m: vec![0.1, 0.11], ..settings(4) }).contains("every hinge"));
}

/// Finite loads and rates, also with derivatives, and no jump over a small change of the wind.
fn check_wind(model: &StripModel, wing: &Wing<f64>, wind: Vec3<f64>, x: &[f64]) {
    let sections = wing.sections(model.arcs(), &planform());
    let (dx, loads) = evaluate(model, &sections, wind, x);
    let drawn = (wing.shoulder.x, wing.elbow.x, wind);
    assert!(dx.iter().all(|v| v.is_finite()), "{drawn:?}");
    assert!(loads.wrench.force.is_finite() && loads.wrench.moment.is_finite(), "{drawn:?}");
    let still = Wing::<Dual<1>>::still(wing.shoulder.x, wing.elbow.x).sections(model.arcs(), &planform());
    let dual_wind = Vec3::new(Dual::variable(wind[0], 0), Dual::from(wind[1]), Dual::from(wind[2]));
    let dual_x: Vec<_> = x.iter().map(|&v| Dual::<1>::constant(v)).collect();
    let mut dual_dx = dual_x.clone();
    let (wrench, matrix) = model.evaluate_sum(&still, dual_wind, &dual_x, &mut dual_dx, None);
    assert!(wrench.force.is_finite() && wrench.moment.is_finite(), "{drawn:?}");
    assert!(dual_dx.iter().chain(matrix.iter().flatten()).all(|v| v.is_finite()), "{drawn:?}");
    let step = 1e-6 * (wind.norm() + 1e-3);
    let (_, near) = evaluate(model, &sections, wind + Vec3::new(step, step, -step), x);
    let scale = 1e-3 * (0.01 + loads.wrench.force.norm());
    assert!((near.wrench.force - loads.wrench.force).norm() < scale, "{drawn:?}");
}

#[test]
fn any_wind_and_fold_give_finite_loads() {
    let mut random = Random::new(1);
    for _ in 0..96 {
        let strips = 6 + random.bits() as usize % 14;
        let (shoulder, elbow) = (random.between(-1.4, 1.4), random.between(-1.95, 1.0));
        let speed = [0.0, 1e-9, random.between(0.01, 20.0)][random.bits() as usize % 3];
        let (incidence, slip) = (random.between(-PI, PI), random.between(-1.5, 1.5));
        let law = LiftLaw::ALL[random.bits() as usize % LiftLaw::ALL.len()];
        let lags = [LagSet::Three, LagSet::Five][random.bits() as usize % 2];
        let section = SectionSettings { law, ..settings(strips).section };
        let model = model(StripSettings { lags, section, ..settings(strips) });
        let wind = Vec3::new(-incidence.cos() * slip.cos(), slip.sin(), incidence.sin() * slip.cos()) * speed;
        check_wind(&model, &Wing::still(shoulder, elbow), wind, &state(&model));
    }
}

#[test]
fn a_wing_of_one_panel_gives_finite_loads() {
    let mut random = Random::new(1);
    let model = model(StripSettings { hinge_arcs_m: vec![], ..settings(1) });
    for _ in 0..96 {
        let (speed, incidence) = (random.between(0.0, 5.0), random.between(-PI, PI));
        let wind = Vec3::new(-incidence.cos(), 0.0, incidence.sin()) * speed;
        check_wind(&model, &Wing::still(0.0, 0.0), wind, &state(&model));
    }
}

/// Marches through two cycles; the largest force of the second and its largest change per step.
fn march(model: &StripModel, amplitude: f64, wind: Vec3<f64>) -> (f64, f64) {
    let (steps, omega) = (400, 22.0);
    let h = 2.0 * PI / omega / steps as f64;
    let mut x = vec![0.0; model.states()];
    let (mut largest, mut change, mut last) = (0.0_f64, 0.0_f64, Vec3::ZERO);
    for k in 0..2 * steps {
        let phase = 2.0 * PI * k as f64 / steps as f64;
        let angle = wingbeat::math::Jet::new(phase, omega, 0.0);
        let mut wing = Wing::still(0.0, 0.0);
        wing.shoulder = angle.sin() * (0.5 * amplitude);
        wing.elbow = (angle + 1.0).cos() * (0.5 * amplitude) - 0.5 * amplitude;
        let (dx, loads) = evaluate(model, &wing.sections(model.arcs(), &planform()), wind, &x);
        x.iter_mut().zip(&dx).for_each(|(x, d)| *x += h * d);
        let force = loads.wrench.force;
        assert!(force.is_finite() && x.iter().all(|v| v.is_finite()), "step {k}");
        if k > steps {
            largest = largest.max(force.norm());
            change = change.max((force - last).norm());
        }
        last = force;
    }
    (largest, change)
}

#[test]
fn deep_folds_and_any_wind_stay_smooth_in_time() {
    for model in variants() {
        let deep = 110_f64.to_radians();
        for wind in [[-1.5, 0.0, 0.2], [0.0, 0.0, 0.0], [1.5, 0.0, 0.0], [0.0, 0.0, 1.5], [0.0, 1.5, 0.0]] {
            let (largest, change) = march(&model, deep, Vec3(wind));
            assert!(change < 0.1 * largest, "{wind:?}: {change} of {largest}");
        }
    }
}
