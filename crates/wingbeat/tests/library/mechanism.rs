//! Robots read from data: any links, elastic and free joints, several surfaces.

use wingbeat::aero::{
    Aero, LiftLaw, LiftingLine, LiftingLineSettings, SectionSettings, StripModel, StripSettings,
};
use wingbeat::body::LinkMotion;
use wingbeat::math::{Jet, Quat, RK4, Vec3, Workspace, Wrench};
use wingbeat::plant::{Linearisation, Plant};
use wingbeat::robot::{Air, Outline, Robot, Varying, Wind};
use wingbeat::scenario::Document;

/// Body with a chain of a skew hinge, a slide and a driven hinge, and a pair of elastic fins.
const CHAIN: &str = r#"
name = "chain"
[body]
mass_kg = 0.02
com_m = [0.003, 0.001, -0.002]
inertia_kg_m2 = [2e-5, 3e-5, 4e-5]
[[links]]
name = "boom"
origin_m = [-0.05, 0.0, 0.01]
orientation_deg = [10.0, -20.0, 30.0]
axis = [1.0, 2.0, -1.0]
mass_kg = 0.004
com_m = [-0.04, 0.002, 0.003]
inertia_kg_m2 = [1e-7, 3e-6, 3e-6]
free = true
[[links]]
name = "slider"
parent = "boom"
origin_m = [-0.08, 0.0, 0.0]
joint = "prismatic"
axis = [0.0, 1.0, 0.5]
mass_kg = 0.002
com_m = [0.0, 0.01, 0.0]
inertia_kg_m2 = [2e-7, 1e-7, 2e-7]
elastic = { stiffness = 30.0, damping = 0.02, rest = 0.002, stops = { low = -0.01, high = 0.01, stiffness = 200.0 } }
[[links]]
name = "fin"
side = "mirrored"
origin_m = [0.0, 0.02, 0.0]
axis = [0.2, -1.0, 0.1]
mass_kg = 0.001
com_m = [-0.01, 0.03, 0.0]
inertia_kg_m2 = [4e-7, 1e-7, 4e-7]
elastic = { stiffness = 2e-3, damping = 1e-6 }
"#;

/// Wings of three links each, the outer one on an elastic twist hinge; a tail on a free hinge.
pub(super) const FLAPPER: &str = include_str!("../../../../validation/fsi/flapper.toml");

/// The same whose twists and folds pass over within a web, its strips between four chord lines on links.
fn webbed() -> String {
    let text = FLAPPER.replace("from_arc_m = 0.07 }", "from_arc_m = 0.07, web_m = 0.02 }");
    let text = text.replace("from_arc_m = 0.13,", "from_arc_m = 0.13, web_m = 0.05,");
    assert_eq!(text.matches("web_m").count(), 2);
    text
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Preset {
    Paper,
    Full,
}

pub(super) fn robot(text: &str, preset: Preset, density: f64) -> Robot {
    let spec = Document::text("robot", text).unwrap().robot().unwrap();
    let models = spec.outlines().unwrap().into_iter().map(|outline| match preset {
        Preset::Paper => {
            let settings = LiftingLineSettings {
                nodes: outline.strips.unwrap_or(12),
                section: SectionSettings {
                    density_kg_m3: density,
                    law: LiftLaw::Stall,
                    drag: outline.drag(LiftLaw::Stall),
                    ..Default::default()
                },
                ..LiftingLineSettings::default()
            };
            Aero::LiftingLine(LiftingLine::new(&outline.planform, settings).unwrap())
        }
        Preset::Full => {
            let settings = StripSettings {
                strips: outline.strips.unwrap_or(14),
                hinge_arcs_m: outline.hinges.clone(),
                webs_m: outline.webs.clone(),
                flap: outline.flap,
                section: SectionSettings {
                    density_kg_m3: density,
                    drag: outline.drag(LiftLaw::Linear),
                    ..Default::default()
                },
                ..StripSettings::default()
            };
            Aero::Strip(StripModel::new(&outline.planform, settings).unwrap())
        }
    });
    let air = Air { density, wind: Wind::steady(Vec3::new(0.1, -0.2, 0.05)) };
    Robot::new(&spec, models.collect(), air, 0.3).unwrap()
}

/// In flight with every part in motion.
pub(super) fn moving(robot: &Robot) -> Vec<f64> {
    let l = robot.layout();
    let mut x: Vec<f64> = (0..l.len).map(|i| 0.05 * (1.7 * i as f64).sin()).collect();
    Quat::from_roll_pitch_yaw(0.2, -0.3, 0.4).store_wxyz(&mut x[l.attitude..]);
    Vec3::new(2.0, 0.1, -0.3).store(&mut x[l.velocity..]);
    Vec3::new(0.4, -0.8, 0.5).store(&mut x[l.rate..]);
    let count = (l.aero - l.joints) / 2;
    for (i, joint) in x[l.joints..l.aero].iter_mut().enumerate() {
        *joint = if i < count { 0.004 + 0.002 * i as f64 } else { 0.3 - 0.2 * i as f64 };
    }
    x
}

fn rates(robot: &Robot, t: f64, x: &[f64]) -> Vec<f64> {
    let mut dx = vec![0.0; x.len()];
    robot.rates_in_numbers(t, x, &vec![0.0; robot.inputs().len()], &mut dx).unwrap();
    dx
}

#[test]
fn coordinates_and_articulated_bodies_agree_in_vacuum() {
    let robot = robot(CHAIN, Preset::Paper, 0.0);
    let (x, l, tree) = (moving(&robot), *robot.layout(), robot.tree());
    let dx = rates(&robot, 0.0, &x);
    let attitude = Quat::from_wxyz(&x[l.attitude..]).matrix();
    let (v, w) = (attitude.transpose_mul(Vec3::from_slice(&x[l.velocity..])), Vec3::from_slice(&x[l.rate..]));
    let joints: Vec<Jet> = (0..4).map(|i| Jet::new(x[l.joints + i], x[l.joints + 4 + i], 0.0)).collect();
    let mut motions = [LinkMotion::default(); 4];
    tree.motions(&joints, v, w, &mut motions);
    let (q, d) = (joints[1].x, joints[1].d);
    let slide = -30.0 * (q - 0.002) - 0.02 * d;
    let fin = |i: usize| -2e-3 * joints[i].x - 1e-6 * joints[i].d;
    let efforts = [0.0, slide, fin(2), fin(3)];
    let g = attitude.transpose_mul(Vec3::new(0.0, 0.0, -wingbeat::math::GRAVITY));
    let free = tree.forward_dynamics(w, &motions, &efforts, g, Wrench::ZERO, &[Wrench::ZERO; 4]).unwrap();
    let base = attitude * free.base.origin;
    let expected = base.0.into_iter().chain(free.base.angular.0).chain(free.joints);
    let found = dx[l.velocity..l.velocity + 6].iter().chain(&dx[l.joints + 4..l.joints + 8]);
    for (found, expected) in found.zip(expected) {
        assert!((found - expected).abs() < 1e-10 * expected.abs().max(1.0), "{found} {expected}");
    }
    assert_eq!(dx[l.joints..l.joints + 4], x[l.joints + 4..l.joints + 8]);
}

/// Between their corners stops bear nothing, beyond them all that lies beyond; in a corner too their energy is that of their effort.
#[test]
fn stops_bear_nothing_between_them() {
    let [with, without] =
        [CHAIN.into(), CHAIN.replace(", stops = { low = -0.01, high = 0.01, stiffness = 200.0 }", "")];
    let [with, without] = [with, without].map(|text: String| robot(&text, Preset::Paper, 0.0));
    let of = |q: f64| {
        let (mut x, joint) = (moving(&with), with.layout().joints + 1);
        x[joint] = q;
        let [with, without] = [&with, &without].map(|robot| robot.observe(0.0, &x, &[]).unwrap());
        (with.torques[1] - without.torques[1], with.energy - without.energy)
    };
    for q in [-0.0097, -1e-3, 0.0, 0.004, 0.0097] {
        assert_eq!(of(q), (0.0, 0.0), "{q}");
    }
    for (q, beyond) in [(0.0103, 3e-4), (0.02, 0.01), (-0.012, -2e-3), (0.0101, 4e-4 * 0.421875 * 0.625)] {
        assert!((of(q).0 + 200.0 * beyond).abs() < 1e-11, "{q}: {}", of(q).0);
    }
    for q in [-0.0105, -0.01015, -0.00995, 0.00985, 0.01, 0.01012, 0.0102, 0.013] {
        let h = 1e-6;
        let apart = |h: f64| of(q + h).1 - of(q - h).1;
        let slope = (8.0 * apart(h) - apart(2.0 * h)) / (12.0 * h);
        assert!((slope + of(q).0).abs() < 1e-8, "{q}: {slope} {}", of(q).0);
    }
}

/// Inverse dynamics with the loads of the accelerated strips returns what the springs exert: air,
/// inertia and coupling all enter once, on the way there and on the way back.
#[test]
fn elastic_joints_bear_the_efforts_of_their_springs() {
    let webbed = webbed();
    for (text, preset) in [(FLAPPER, Preset::Paper), (FLAPPER, Preset::Full), (&webbed, Preset::Full)] {
        let robot = robot(text, preset, 1.2);
        let (x, l) = (moving(&robot), *robot.layout());
        let seen = robot.observe(0.05, &x, &[]).unwrap();
        let joint = |name: &str| robot.tree().find(name).unwrap();
        let coordinates = ["feather_left", "feather_right", "tail"].map(joint);
        let largest = seen.torques.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        for (c, &i) in coordinates.iter().enumerate() {
            let (q, d) = (x[l.joints + c], x[l.joints + 3 + c]);
            let effort = if c < 2 { -4e-3 * (q - 0.05) - 2e-5 * d } else { 0.0 };
            let error = (seen.torques[i] - effort).abs();
            assert!(error < 1e-12 * largest.max(1.0), "{} {effort} {error:e}", seen.torques[i]);
        }
        let loads = [seen.air.total(), seen.body_drag, seen.gravity, seen.inertia];
        let net = loads.into_iter().fold(Wrench::ZERO, |sum, load| sum + load);
        assert!(net.force.norm() < 1e-11 && net.moment.norm() < 1e-12, "{net:?}");
    }
}

#[test]
fn drives_air_and_dampers_account_for_the_energy() {
    let webbed = webbed();
    let [wings, webs, chain] = [FLAPPER, &webbed, CHAIN];
    for (text, preset) in
        [(wings, Preset::Paper), (wings, Preset::Full), (webs, Preset::Full), (chain, Preset::Paper)]
    {
        let robot = robot(text, preset, 1.2);
        let (t, h) = (0.05, 1e-5);
        let seen = robot.observe(t, &moving(&robot), &[]).unwrap();
        let energy = |h: f64| {
            let mut x = moving(&robot);
            let mut work = Workspace::new(x.len(), RK4.b.len());
            RK4.step(|t, x, dx| robot.rates_in_numbers(t, x, &[], dx), t, h, &mut x, &mut work).unwrap();
            robot.observe(t + h, &x, &[]).unwrap().energy
        };
        let slope = (8.0 * (energy(h) - energy(-h)) - (energy(2.0 * h) - energy(-2.0 * h))) / (12.0 * h);
        let power = seen.power + seen.air_power - seen.dissipation;
        assert!((slope - power).abs() < 1e-7 * power.abs().max(0.1), "{slope} {power}");
        assert!(seen.dissipation > 0.0);
    }
}

#[test]
fn mirrored_elastic_joints_stay_alike() {
    let robot = robot(FLAPPER, Preset::Full, 1.2);
    let l = *robot.layout();
    let mut x = vec![0.0; l.len];
    Quat::from_roll_pitch_yaw(0.0, -0.2, 0.0).store_wxyz(&mut x[l.attitude..]);
    x[l.velocity] = 2.0;
    let air = Air { density: 1.2, wind: Wind::steady(Vec3::ZERO) };
    let spec = Document::text("robot", FLAPPER).unwrap().robot().unwrap();
    let models = robot.surfaces().map(|(_, aero)| aero.clone()).collect();
    let robot = Robot::new(&spec, models, air, 0.3).unwrap();
    let mut work = Workspace::new(x.len(), RK4.b.len());
    for i in 0..200 {
        let t = i as f64 * 5e-4;
        RK4.step(|t, x, dx| robot.rates_in_numbers(t, x, &[], dx), t, 5e-4, &mut x, &mut work).unwrap();
    }
    assert!(x[l.joints].abs() > 1e-3, "the hinge must have moved: {}", x[l.joints]);
    assert!((x[l.joints] - x[l.joints + 1]).abs() < 1e-10, "{:?}", &x[l.joints..l.aero]);
    assert!(x[1].abs() < 1e-10 && x[l.rate].abs() < 1e-8);
}

#[test]
fn derivatives_through_elastic_joints_are_exact() {
    let webbed = webbed();
    for (text, preset) in [(FLAPPER, Preset::Paper), (FLAPPER, Preset::Full), (&webbed, Preset::Full)] {
        let robot = robot(text, preset, 1.2);
        let (x, n) = (moving(&robot), robot.states().len());
        let mut exact = Linearisation::new(n, 0);
        exact.evaluate(&robot, 0.05, &x, &[]).unwrap();
        let l = robot.layout();
        for j in [l.attitude, l.velocity, l.rate, l.joints, l.joints + 1, l.joints + 5, l.aero, n - 1] {
            let h = 1e-6;
            let at = |sign: f64| {
                let mut moved = x.clone();
                moved[j] += sign * h;
                rates(&robot, 0.05, &moved)
            };
            let (up, down) = (at(1.0), at(-1.0));
            for i in 0..n {
                let (difference, exact) = ((up[i] - down[i]) / (2.0 * h), exact.a[i * n + j]);
                let scale = 1.0 + exact.abs().max(up[i].abs());
                assert!((difference - exact).abs() < 2e-4 * scale, "d{i}/d{j}: {difference} {exact}");
            }
        }
    }
}

/// The length of a web is a number of the robot as the arc is at which its panel begins.
#[test]
fn derivatives_by_the_length_of_a_web_are_exact() {
    let robot = robot(&webbed(), Preset::Full, 1.2);
    let x = moving(&robot);
    let constant: Vec<Varying> = x.iter().map(|x| Varying::constant(*x)).collect();
    let values = robot.named_numbers();
    for (name, length) in
        [("surfaces.wing.panels.hand.web_m", 0.02), ("surfaces.wing.panels.feather.web_m", 0.05)]
    {
        assert!(values.iter().any(|(other, value)| other == name && *value == length), "{values:?}");
        let at = |length: f64| rates(&robot.adjusted(&[(name, length)]).unwrap(), 0.05, &x);
        let (h, mut dx) = (1e-6, constant.clone());
        let (up, down) = (at(length + h), at(length - h));
        let varied = robot.varied(&[name]).unwrap();
        varied.state_rates(Varying::constant(0.05), &constant, &[], &mut dx).unwrap();
        let exact: Vec<f64> = dx.iter().map(|rate| rate.eps[0]).collect();
        let largest = exact.iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
        for (i, exact) in exact.iter().enumerate() {
            let difference = (up[i] - down[i]) / (2.0 * h);
            assert!((difference - exact).abs() < 1e-6 * largest, "{name}, d{i}: {difference} {exact}");
        }
        let refused = robot.adjusted(&[(name, 0.5)]).map(drop).unwrap_err().to_string();
        assert!(refused.contains("web_m") && refused.contains("less than the panel's length"), "{refused}");
    }
    assert_eq!(values.iter().filter(|(name, _)| name.ends_with("web_m")).count(), 4, "{values:?}");
}

/// A wing on the left alone and its mirror image on the right load the body alike.
#[test]
fn one_sided_surfaces_mirror_one_another() {
    let side = |span: &str, y: f64, direction: &str| {
        format!(
            r#"
name = "half"
body = {{ mass_kg = 0.02, inertia_kg_m2 = [1e-5, 1e-5, 1e-5] }}
[[surfaces]]
name = "wing"
span = "{span}"
planform = [
  {{ arc_m = 0.0, leading_edge_m = 0.03, trailing_edge_m = -0.07 }},
  {{ arc_m = 0.3, leading_edge_m = 0.01, trailing_edge_m = -0.03 }},
]
panels = [{{ link = "body", origin_m = [0.0, {y}, 0.0]{direction} }}]
"#
        )
    };
    let turned = Document::text("turned", &side("right", -0.02, ", direction = [0.0, 1.0, 0.0]"));
    let refused = turned.unwrap().robot().unwrap().check().unwrap_err().to_string();
    assert!(refused.contains("panels[0].direction") && refused.contains("y below 0"), "{refused}");
    // The direction of the span follows from the side where it is not given.
    let side = |span: &str, y: f64| side(span, y, "");
    for preset in [Preset::Paper, Preset::Full] {
        let load = |span: &str, y: f64| {
            let robot = robot(&side(span, y), preset, 1.2);
            let l = *robot.layout();
            let mut x = vec![0.0; l.len];
            Quat::from_roll_pitch_yaw(0.0, -0.1, 0.0).store_wxyz(&mut x[l.attitude..]);
            Vec3::new(3.1, -0.2, 0.05).store(&mut x[l.velocity..]);
            for _ in 0..40 {
                let dx = rates(&robot, 0.0, &x);
                (l.aero..l.len).for_each(|s| x[s] += 2e-4 * dx[s]);
            }
            robot.observe(0.0, &x, &[]).unwrap().air.total()
        };
        let (left, right) = (load("left", 0.02), load("right", -0.02));
        let scale = left.force.norm();
        assert!(left.force[2] > 0.01, "lift {:?}", left.force);
        for (i, sign) in [(0, 1.0), (1, -1.0), (2, 1.0)] {
            assert!((left.force[i] - sign * right.force[i]).abs() < 1e-12 * scale, "{left:?} {right:?}");
            assert!((left.moment[i] + sign * right.moment[i]).abs() < 1e-12 * scale, "{left:?} {right:?}");
        }
    }
}

/// Panels meet on their hinges; one that begins elsewhere is as far from there as it was moved.
#[test]
fn panels_that_do_not_meet_are_measured() {
    for text in [FLAPPER.to_owned(), webbed()] {
        let apart = robot(&text, Preset::Full, 1.2).panels_apart().unwrap();
        assert!(apart < 1e-12, "{apart}");
        let torn = text.replace("from_arc_m = 0.07", "from_arc_m = 0.06");
        // The hand's other end is as far from the feather, where the chord is less.
        let chord = 0.1 - 0.25 * 0.13;
        let apart = robot(&torn, Preset::Full, 1.2).panels_apart().unwrap();
        assert!((apart - 0.01 / chord).abs() < 1e-9, "{apart}");
        // Drawn with a gap on both hinges that are torn, over the way that one was moved.
        let (whole, torn) = (robot(&text, Preset::Full, 1.2), robot(&torn, Preset::Full, 1.2));
        let [own, same, parted] = [(&whole, 1.0), (&whole, 0.05), (&torn, 0.05)]
            .map(|(robot, least)| robot.parted(robot.at_rest(0.0).unwrap(), least).outlines.remove(0));
        assert_eq!((own.ribs.len(), &own.covered), (same.ribs.len(), &same.covered));
        let gaps = |outline: &Outline| outline.covered.iter().filter(|covered| !**covered).count();
        assert_eq!((parted.ribs.len(), gaps(&parted)), (own.ribs.len() + 4, gaps(&own) + 4));
        let pairs = parted.ribs.windows(2).zip(&parted.covered).filter(|(_, covered)| !**covered);
        let ways: Vec<f64> = pairs.map(|(pair, _)| (pair[0][0] - pair[1][0]).norm()).collect();
        assert!(ways.iter().any(|way| (way - 0.01).abs() < 1e-9), "{ways:?}");
    }
}

#[test]
fn the_documented_robot_is_built() {
    let page = include_str!("../../../../docs/robots.md");
    let text = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let robot = robot(text, Preset::Full, 1.2);
    assert_eq!(
        robot.joint_names().collect::<Vec<_>>(),
        ["wing_left", "wing_right", "hand_left", "hand_right"]
    );
    assert!(rates(&robot, 0.05, &moving(&robot)).iter().all(|rate| rate.is_finite()));
}

#[test]
fn what_a_mechanism_cannot_be_is_refused_by_key() {
    let refusal = |from: &str, to: &str| {
        let text = CHAIN.replacen(from, to, 1);
        assert_ne!(text, CHAIN);
        let spec = Document::text("robot", &text).unwrap().robot().unwrap();
        let air = Air { density: 1.2, wind: Wind::steady(Vec3::ZERO) };
        Robot::new(&spec, Vec::new(), air, 0.0).unwrap_err().to_string()
    };
    let unknown = refusal("parent = \"boom\"", "parent = \"bom\"");
    assert_eq!(
        unknown,
        "links[1].parent = \"bom\": allowed is body or a link before this one, of body, boom; did you mean boom?"
    );
    assert!(refusal("axis = [1.0, 2.0, -1.0]", "axis = [0.0, 0.0, 0.0]").starts_with("links[0].axis"));
    assert!(refusal("stiffness = 30.0", "stiffness = -1.0").starts_with("links[1].elastic.stiffness = -1"));
    assert!(refusal("low = -0.01", "low = 0.02").starts_with("links[1].elastic.stops.low = 0.02"));
    assert!(refusal("free = true", "free = true\ndriven = {}").contains("one of `driven`"));
}
