//! Clearances: corners of wings to the middle plane, capsules of links, what flights and plans make of them.

use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::body::LinkMotion;
use wingbeat::guide::{LeastPower, LeastPowerSpec, Stand};
use wingbeat::judge::Status;
use wingbeat::math::{Dual, Jet, Scalar, Vec3};
use wingbeat::ocp::{Instant, OptimalControl};
use wingbeat::plant::{LocalChart, Plant};
use wingbeat::robot::{Air, Robot, Wind};
use wingbeat::scenario::Document;
use wingbeat::scenario::{PlanSpec, Run, Scenario};

/// Width of the smooth minimum, and the corners of Aerobat: 2 edges at 2 and 4 arcs of each wing.
const WIDTH: f64 = 1e-3;
const CORNERS: f64 = 24.0;

fn load(name: &str, overrides: &[&str]) -> Scenario {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenarios/{name}.toml"));
    let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
    Scenario::load(&path, &overrides).unwrap_or_else(|e| panic!("{e}"))
}

fn fly(name: &str, overrides: &[&str]) -> Run {
    load(name, overrides).fly(|_| ControlFlow::Continue(())).unwrap()
}

/// The robot of the banking turn with an elbow that folds deeper than its wings have room for.
const DEEP_FOLD: [&str; 2] =
    ["robot.gait.fourier.elbow.mean_rad=-0.65", "robot.gait.fourier.elbow.harmonics[0].amplitude_rad=-0.65"];

fn clearance<S: Scalar>(robot: &Robot, t: S, structure: &[S]) -> S {
    let mut values = [S::ZERO];
    robot.smooth_clearances(t, structure, &mut values).unwrap();
    values[0]
}

/// Displacements of shoulder, elbow, twist and sweep, left and right, and their rates.
const DISPLACED: [f64; 16] =
    [0.21, -0.28, -0.4, 0.35, 0.2, -0.15, 0.09, -0.07, 1.0, -2.0, 0.5, 0.3, -0.7, 0.2, 0.1, -0.4];

/// Distances of the corners of one wing of `robots/aerobat_paper.toml` from the middle plane, by hand: about x by
/// shoulder and elbow, about -y by the twist, about -z by the sweep.
fn by_hand([shoulder, elbow, twist, sweep]: [f64; 4]) -> Vec<f64> {
    const SHIFT: f64 = -0.0325;
    let proximal = [(0.0, 0.0635), (0.0, -0.0956), (0.05, 0.0765), (0.05, -0.111)];
    let distal = [
        (0.0, 0.0765),
        (0.0, -0.111),
        (0.0085, 0.0807),
        (0.0085, -0.115),
        (0.084, 0.118),
        (0.084, 0.01705),
        (0.132, 0.101),
        (0.132, 0.081),
    ];
    let beyond_shoulder = |x: f64, y: f64, z: f64| {
        let y = y * shoulder.cos() - z * shoulder.sin();
        0.0207 + y * sweep.cos() - x * sweep.sin()
    };
    let inner = proximal.map(|(y, x)| beyond_shoulder(x + SHIFT, y, 0.0));
    let outer = distal.map(|(y, x)| {
        let (x, z) = ((x + SHIFT) * twist.cos(), (x + SHIFT) * twist.sin());
        beyond_shoulder(x, 0.05 + y * elbow.cos() - z * elbow.sin(), y * elbow.sin() + z * elbow.cos())
    });
    inner.into_iter().chain(outer).collect()
}

/// The gait of `robots/aerobat_paper.toml`.
fn gait(t: f64) -> [f64; 2] {
    let phase = std::f64::consts::TAU * 3.5 * t;
    [0.1 + 0.95 * phase.cos(), -0.35 - 0.35 * (phase - 1.25 * std::f64::consts::PI).cos()]
}

#[test]
fn corners_lie_where_the_joints_put_them() {
    let scenario = load("banking_turn", &[]);
    let (robot, d) = (scenario.robot(), DISPLACED);
    assert_eq!(robot.clearances()[0].name, "clearance_wing_middle");
    for t in [0.0, 0.07, 0.13, 0.19, 0.26] {
        let [shoulder, elbow] = gait(t);
        let wing = |i: usize| by_hand([shoulder + d[i], elbow + d[2 + i], d[4 + i], d[6 + i]]);
        let hand = wing(0).into_iter().chain(wing(1)).fold(f64::INFINITY, f64::min);
        let least = robot.least_clearances(t, &d).unwrap();
        assert!(least.len() == 1 && (least[0] - hand).abs() < 1e-14, "{least:?} {hand}");
        let sum: f64 = wing(0).into_iter().chain(wing(1)).map(|c| (-c / WIDTH).exp()).sum();
        let smooth = clearance(robot, t, &d);
        assert!((smooth + WIDTH * sum.ln()).abs() < 1e-14, "{smooth}");
        assert!(smooth <= hand && smooth >= hand - WIDTH * CORNERS.ln());
        let mut x = scenario.start();
        x[robot.layout().structure..][..16].copy_from_slice(&d);
        assert_eq!(robot.observe(t, &x, &[0.0; 8]).unwrap().clearances, least);
    }
}

#[test]
fn derivatives_of_clearances_are_exact() {
    for (name, t) in [("banking_turn", 0.19), ("banking_turn_beta", 0.05)] {
        let scenario = load(name, &[]);
        let robot = scenario.robot();
        let elements = robot.inputs().len();
        let scale = |i: usize| robot.inputs()[i % elements].high;
        let x: Vec<f64> = (0..2 * elements).map(|i| 0.3 * scale(i) * (1.3 * i as f64).sin()).collect();
        let at = |moved: Option<usize>, h: f64| {
            let mut x = x.clone();
            if let Some(i) = moved {
                x[i] += h;
            }
            clearance(robot, if moved.is_none() { t + h } else { t }, &x)
        };
        for moved in std::iter::once(None).chain((0..2 * elements).map(Some)) {
            let mut dual: Vec<Dual<1>> = x.iter().map(|&v| Dual::constant(v)).collect();
            let mut time = Dual::<1>::constant(t);
            let variable = match moved {
                Some(i) => &mut dual[i],
                None => &mut time,
            };
            variable.eps[0] = 1.0;
            let exact = clearance(robot, time, &dual);
            assert_eq!(exact.re, at(None, 0.0));
            let h = 1e-4 * moved.map_or(0.05, scale);
            let (one, two) = (
                (at(moved, h) - at(moved, -h)) / (2.0 * h),
                (at(moved, 2.0 * h) - at(moved, -2.0 * h)) / (4.0 * h),
            );
            let difference = (4.0 * one - two) / 3.0;
            let error = (exact.eps[0] - difference).abs();
            assert!(error < 1e-6 * difference.abs().max(0.1), "{moved:?}: {} {difference}", exact.eps[0]);
            assert!(moved.is_none_or(|i| i < elements) || exact.eps[0] == 0.0, "rates do not enter");
        }
    }
}

#[test]
fn the_clearance_does_not_tell_left_from_right() {
    for name in ["banking_turn", "banking_turn_beta"] {
        let scenario = load(name, &[]);
        let robot = scenario.robot();
        let elements = robot.inputs().len();
        let half = |i: usize| 0.4 * robot.inputs()[i % elements].high * (0.8 * i as f64).cos();
        let x: Vec<f64> = (0..2 * elements).map(half).collect();
        let swapped: Vec<f64> = (0..x.len()).map(|i| x[i ^ 1]).collect();
        assert_ne!(x, swapped);
        for t in [0.0, 0.1, 0.2] {
            let [one, other] = [&x, &swapped].map(|x| robot.least_clearances(t, x).unwrap()[0]);
            assert!((one - other).abs() < 1e-15, "{one} {other}");
        }
    }
}

/// The published linkage itself folds its tips past the middle plane.
#[test]
fn the_published_linkage_carries_its_tips_past_the_middle() {
    let scenario = load("banking_turn_beta", &[]);
    let robot = scenario.robot();
    let structure = vec![0.0; robot.layout().aero - robot.layout().structure];
    let samples = 2000;
    let at = |i: usize| robot.least_clearances(i as f64 / (3.5 * samples as f64), &structure).unwrap()[0];
    let cycle: Vec<f64> = (0..samples).map(at).collect();
    let least = cycle.iter().copied().fold(f64::INFINITY, f64::min);
    let share = cycle.iter().filter(|c| **c < 0.0).count() as f64 / samples as f64;
    assert!((least + 0.008).abs() < 5e-4, "least {least}");
    assert!((share - 0.10).abs() < 0.01, "share {share}");
}

const CAPSULES: &str = r#"
name = "capsules"
[body]
mass_kg = 0.012
inertia_kg_m2 = [9e-6, 3e-5, 3e-5]
capsule = { from_m = [0.05, 0.0, 0.0], to_m = [-0.06, 0.0, 0.0], radius_m = 0.01 }
[gait.fourier]
frequency_hz = 4.0
[[links]]
name = "arm"
side = "mirrored"
origin_m = [0.0, 0.02, 0.005]
mass_kg = 0.001
com_m = [0.0, 0.025, 0.0]
inertia_kg_m2 = [2e-7, 1e-8, 2e-7]
capsule = { to_m = [-0.03, 0.09, 0.01], radius_m = 0.004 }
driven = { mean_rad = 0.3, harmonics = [{ amplitude_rad = 1.1, phase_rad = 0.0 }] }
[[links]]
name = "tail"
origin_m = [-0.02, 0.0, 0.0]
axis = [0.0, 0.6, 1.0]
mass_kg = 0.0005
com_m = [-0.02, 0.0, 0.0]
inertia_kg_m2 = [1e-7, 1e-7, 2e-7]
capsule = { to_m = [-0.07, 0.01, 0.03], radius_m = 0.003 }
free = true
[[clearances]]
between = ["arm", "arm"]
[[clearances]]
between = ["arm", "tail"]
[[clearances]]
between = ["body", "arm_right"]
"#;

fn build(text: &str) -> Result<Robot, wingbeat::Error> {
    let spec = Document::text("robot", text).unwrap().robot().unwrap();
    Robot::new(&spec, Vec::new(), Air { density: 1.2, wind: Wind::steady(Vec3::ZERO) }, 0.0)
}

/// Least distance of two capsules by a fine search along both.
fn searched(one: ([Vec3; 2], f64), other: ([Vec3; 2], f64)) -> f64 {
    let at = |[a, b]: [Vec3; 2], i: usize| a + (b - a) * (i as f64 / 400.0);
    let pairs = (0..=400).flat_map(|i| (0..=400).map(move |j| (i, j)));
    let least = pairs.map(|(i, j)| (at(one.0, i) - at(other.0, j)).norm()).fold(f64::INFINITY, f64::min);
    least - one.1 - other.1
}

#[test]
fn capsules_are_as_far_apart_as_a_search_finds() {
    let robot = build(CAPSULES).unwrap();
    let names: Vec<&str> = robot.clearances().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["clearance_arm_arm", "clearance_arm_tail", "clearance_body_arm_right"]);
    for (t, tail) in [(0.0, 0.4), (0.03, -0.8), (0.11, 1.2), (0.17, -1.5)] {
        let angle = 0.3 + 1.1 * (std::f64::consts::TAU * 4.0 * t).cos();
        let joints = [angle, angle, tail].map(|q| Jet::new(q, 0.0, 0.0));
        let mut links = [LinkMotion::default(); 3];
        robot.tree().motions(&joints, Vec3::ZERO, Vec3::ZERO, &mut links);
        let capsule = |link: usize, to: [f64; 3], radius: f64| {
            ([links[link].point(Vec3::<f64>::ZERO), links[link].point(Vec3(to))], radius)
        };
        let (left, right) = (capsule(0, [-0.03, 0.09, 0.01], 0.004), capsule(1, [-0.03, -0.09, 0.01], 0.004));
        let tail_room = capsule(2, [-0.07, 0.01, 0.03], 0.003);
        let body = ([Vec3::new(0.05, 0.0, 0.0), Vec3::new(-0.06, 0.0, 0.0)], 0.01);
        let expected = [
            searched(left, right),
            searched(left, tail_room).min(searched(right, tail_room)),
            searched(body, right),
        ];
        let found = robot.least_clearances(t, &[tail, 0.0]).unwrap();
        let mut smooth = [0.0; 3];
        robot.smooth_clearances(t, &[tail, 0.0], &mut smooth).unwrap();
        for i in 0..3 {
            assert!(
                found[i] <= expected[i] + 1e-12 && expected[i] - found[i] < 4e-4,
                "{found:?} {expected:?}"
            );
            assert!(smooth[i] <= found[i] && smooth[i] >= found[i] - WIDTH * 2_f64.ln());
        }
    }
}

/// A beam that bends under a post: its capsule lies along its pieces, and what it carries at its tip rides on the last of them.
const BENT: &str = r#"
name = "bent"
body = { mass_kg = 0.02, inertia_kg_m2 = [2e-5, 3e-5, 4e-5] }
[[links]]
name = "arm"
side = "mirrored"
origin_m = [0.0, 0.02, 0.0]
spar = { length_m = 0.2, segments = 2, bending_n_m2 = 2e-3, mass_kg_m = 0.03, taper = 0.3 }
capsule = { from_m = [0.0, 0.02, 0.0], to_m = [0.01, 0.2, 0.0], radius_m = 0.004 }
[[links]]
name = "tip"
side = "mirrored"
parent = "arm"
origin_m = [0.0, 0.19, 0.0]
mass_kg = 0.002
capsule = { to_m = [0.05, 0.0, 0.0], radius_m = 0.003 }
[[links]]
name = "post"
origin_m = [0.0, 0.1, 0.06]
capsule = { to_m = [0.0, 0.15, 0.0], radius_m = 0.005 }
[[clearances]]
between = ["arm_left", "post"]
[[clearances]]
between = ["arm", "arm"]
[[clearances]]
between = ["tip_right", "post"]
"#;

#[test]
fn what_a_spar_carries_bends_with_it() {
    let robot = build(BENT).unwrap();
    let tree = robot.tree();
    // Its joint is where the file has it, from that of the whole arm.
    let numbers = robot.named_numbers();
    assert!(numbers.contains(&("links.tip_left.origin_m[1]".into(), 0.19)), "{numbers:?}");
    let single = BENT.replacen("side = \"mirrored\"\n", "", 1).replace("\"arm_left\"", "\"arm\"");
    let refused = Document::text("robot", &single).unwrap().robot().unwrap().outlines().unwrap_err();
    assert!(
        refused.to_string().starts_with("links[1].parent = \"arm\": allowed is a link without a spar"),
        "{refused}"
    );
    let [left, right] = [[0.35, -0.2], [-0.3, 0.5]];
    let found =
        robot.least_clearances(0.0, &[left[0], right[0], left[1], right[1], 0.0, 0.0, 0.0, 0.0]).unwrap();
    let mut joints = vec![Jet::new(0.0, 0.0, 0.0); tree.links()];
    for (side, angles) in [("left", left), ("right", right)] {
        for (piece, angle) in (1..).zip(angles) {
            joints[tree.find(&format!("arm_{piece}_{side}")).unwrap()] = Jet::new(angle, 0.0, 0.0);
        }
    }
    let mut links = vec![LinkMotion::default(); tree.links()];
    tree.motions(&joints, Vec3::ZERO, Vec3::ZERO, &mut links);
    // Where the joints at a quarter and three quarters of the length cut the capsule.
    let along = |y: f64| Vec3::new(0.01 * (y - 0.02) / 0.18, y, 0.0);
    let pieces = |side: &str, mirror: f64| {
        [("arm_0", 0.0, [0.02, 0.05]), ("arm_1", 0.05, [0.05, 0.15]), ("arm_2", 0.15, [0.15, 0.2])].map(
            |(name, at, ends)| {
                let link = tree.find(&format!("{name}_{side}")).unwrap();
                (
                    ends.map(|y| {
                        let Vec3([x, y, z]) = along(y) - Vec3::new(0.0, at, 0.0);
                        links[link].point(Vec3::new(x, mirror * y, z))
                    }),
                    0.004,
                )
            },
        )
    };
    let post = ([Vec3::new(0.0, 0.1, 0.06), Vec3::new(0.0, 0.25, 0.06)], 0.005);
    let least = |ones: &[([Vec3; 2], f64)], others: &[([Vec3; 2], f64)]| {
        let pairs = ones.iter().flat_map(|one| others.iter().map(move |other| searched(*one, *other)));
        pairs.fold(f64::INFINITY, f64::min)
    };
    let (arms, tip) = ([pieces("left", 1.0), pieces("right", -1.0)], tree.find("arm_2_right").unwrap());
    let tip = [0.0, 0.05].map(|x| links[tip].point(Vec3::new(x, -0.04, 0.0)));
    let expected = [least(&arms[0], &[post]), least(&arms[0], &arms[1]), least(&[(tip, 0.003)], &[post])];
    for (found, expected) in found.iter().zip(expected) {
        assert!(*found <= expected + 1e-12 && expected - found < 4e-4, "{found} {expected}");
    }
}

#[test]
fn what_has_no_room_is_refused_by_key() {
    let refusal = |from: &str, to: &str| {
        let text = CAPSULES.replacen(from, to, 1);
        assert_ne!(text, CAPSULES);
        build(&text).unwrap_err().to_string()
    };
    let between = "between = [\"arm\", \"tail\"]";
    let unknown = refusal(between, "between = [\"arm\", \"tale\"]");
    assert!(unknown.starts_with("clearances[1].between = \"tale\""), "{unknown}");
    let itself = refusal(between, "between = [\"tail\", \"tail\"]");
    assert!(itself.contains("clearances[1].between") && itself.contains("two parts"), "{itself}");
    let twice = refusal(between, "between = [\"arm\", \"arm\"]");
    assert!(twice.starts_with("clearances[1].between") && twice.contains("not yet named"), "{twice}");
    let bare = refusal("capsule = { to_m = [-0.07, 0.01, 0.03], radius_m = 0.003 }", "");
    assert!(bare.contains("clearances[1].between = \"tail\"") && bare.contains("capsule"), "{bare}");
    let thin = refusal("radius_m = 0.003", "radius_m = 0.0");
    assert!(thin.starts_with("links[1].capsule.radius_m = 0"), "{thin}");
}

#[test]
fn a_flight_in_which_wings_cross_says_so() {
    // A gait by itself, regulators at rest, past its deepest fold.
    let shift = "robot.wing.planform_shift_m=-0.037";
    let run = fly("least_power_gait", &[DEEP_FOLD[0], DEEP_FOLD[1], shift, "flight.duration_s=0.3"]);
    let (least, share) = (run.summary.least_clearance_m.unwrap(), run.summary.crossing_fraction.unwrap());
    let column = run.record.values("clearance_wing_middle").unwrap();
    assert_eq!(least, column.iter().copied().fold(f64::INFINITY, f64::min));
    // -3.67429 mm at the deepest of a fine cycle by hand; samples are 1 ms apart.
    assert!((-3.6743e-3..-3.66e-3).contains(&least), "{least}");
    assert!((0.04..0.07).contains(&share), "{share}");
    let said = |run: &Run| {
        let reason = run.summary.reason.as_deref().unwrap_or_default();
        run.summary.status == Status::Outside && reason.contains("clearance_wing_middle falls to -3.7 mm")
    };
    assert!(said(&run), "{:?}", run.summary.reason);
    let glide = fly("glide", &["flight.duration_s=0.02"]);
    assert!(glide.summary.least_clearance_m.unwrap() > 0.0 && glide.summary.crossing_fraction == Some(0.0));
    assert!(!said(&glide));
}

/// The predictive controller keeps the wings further apart where it is asked to: with a fold, limits, weights and a heading
/// rate that drive them together without.
#[test]
fn a_soft_limit_keeps_wings_from_crossing() {
    let turn = |weight: &str| {
        let weight = format!("controller.weights.clearance={weight}");
        let mut asked: Vec<String> = DEEP_FOLD.map(Into::into).into();
        for (element, stroke) in [0.3, 0.3, 0.5, 0.5, 0.25, 0.25].into_iter().enumerate() {
            let limit = |end: &str, at: f64| format!("robot.structure.elements[{element}].{end}={at}");
            asked.extend([limit("low", -stroke), limit("high", stroke)]);
        }
        let more = [
            "flight.duration_s=0.9",
            "aero.paper.cells=false",
            "manoeuvre.yaw_rate_rad_s=-1.5",
            "controller.interval_s=0.02",
            "controller.weights.roll=2.0",
            "controller.weights.rate_axes=[0.05, 0.05, 0.05]",
            "controller.clearance_m=0.004",
            &weight,
        ];
        asked.extend(more.map(String::from));
        let run = fly("banking_turn", &asked.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(run.summary.controller.failures, 0);
        run.summary.least_clearance_m.unwrap()
    };
    let (without, with) = (turn("0"), turn("100"));
    assert!(with > without + 1e-3, "{without} {with}");
    let glide = load("glide", &[]);
    assert!(glide.controller().unwrap().is_none());
}

/// At no phase of the gait do the regulators within their limits, at rest or at either end, carry a wing across the
/// middle: the limits alone keep the wings apart, whatever commands them.
#[test]
fn no_command_carries_a_wing_across() {
    let scenario = load("banking_turn", &[]);
    let robot = scenario.robot();
    let channels = robot.inputs();
    let mut least = f64::INFINITY;
    for corner in 0..81 {
        let mut displaced = [0.0; 16];
        for pair in 0..4 {
            let channel = &channels[2 * pair];
            let end = [channel.low, 0.0, channel.high][corner / 3_usize.pow(pair as u32) % 3];
            displaced[2 * pair..][..2].fill(end);
        }
        for phase in 0..72 {
            let t = f64::from(phase) / 72.0 / 3.5;
            least = least.min(robot.least_clearances(t, &displaced).unwrap()[0]);
        }
    }
    assert!((1e-3..3e-3).contains(&least), "{least}");
}

/// Every scenario on a gait of our own keeps its wings apart.
#[test]
fn shipped_flights_stay_clear() {
    let clear = |name: &str| {
        let summary = fly(name, &[]).summary;
        assert_eq!(summary.crossing_fraction, Some(0.0), "{name}: {:?}", summary.least_clearance_m);
        summary
    };
    let whole = clear("banking_turn");
    for name in ["banking_turn_short", "banking_turn_stall", "roll_in", "aerobat_elastic"] {
        clear(name);
    }
    assert_eq!((whole.status, whole.controller.failures), (Status::Ok, 0));
}

#[test]
fn a_chart_and_a_stand_pass_clearances_on() {
    let scenario = load("least_power_gait", &["plan.least_power.clearance_m=0.002"]);
    let robot = scenario.model();
    let mut chart = LocalChart::new(robot);
    let mut x = scenario.start();
    let first = robot.layout().structure;
    let mirrored: Vec<f64> = (0..16).map(|i| DISPLACED[i & !1]).collect();
    x[first..first + 16].copy_from_slice(&mirrored);
    chart.center_at(&x);
    let mut local = vec![0.0; x.len() - 1];
    chart.localise(&x, &mut local);
    let mut value = [0.0];
    chart.clear(0.19, &local, &mut value).unwrap();
    let expected = clearance(robot, 0.19, &mirrored);
    assert_eq!(value[0], expected);

    let Some(PlanSpec::LeastPower(spec)) = &scenario.spec.plan else { panic!("a plan of least power") };
    let wind_of = |spec: &LeastPowerSpec| {
        let stand = Stand::new(robot, Vec3(scenario.spec.start.velocity_m_s), 0.0).unwrap();
        LeastPower::new(stand, -0.26, spec).unwrap()
    };
    let problem = wind_of(spec);
    let path = problem.setup().path;
    assert!(path.len() == 1 && path[0].low == 0.002 && path[0].high == f64::INFINITY, "{path:?}");
    let kept = &problem.stand().mirror().states;
    let states: Vec<f64> = kept.iter().map(|&i| *mirrored.get(i).unwrap_or(&0.0)).collect();
    let at = Instant { t: 0.19 * 3.5 / 5.0, x: &states, u: &[0.0; 4], p: &[5.0, -0.3] };
    problem.constrain_path(at, &mut value);
    assert!((value[0] - expected).abs() < 1e-14, "{} {expected}", value[0]);
    let free = LeastPowerSpec { clearance_m: None, ..spec.clone() };
    assert!(wind_of(&free).setup().path.is_empty());
}
