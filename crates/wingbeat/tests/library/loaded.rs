//! Structure elements with an inertia, which the wings push back: eq. (6) of the paper with loads.

use super::mechanism::{FLAPPER, Preset, moving, robot};
use wingbeat::math::{Jet, Mat3, RK4, Vec3, Workspace};
use wingbeat::plant::{Linearisation, Plant};
use wingbeat::robot::{Air, BodyMotion, Robot, Wind};

/// A link of 3e-6 + 2e-3 0.03^2 = 4.8e-6 kg m2 about the vertical on a body at rest, its element of 2e-6 kg m2.
const ARM: &str = r#"
name = "arm"
[body]
mass_kg = 0.1
inertia_kg_m2 = [1e-4, 1e-4, 1e-4]
[gait.fourier]
frequency_hz = 4.0
[[links]]
name = "arm"
origin_m = [0.0, 0.02, 0.0]
axis = [0.0, 0.0, 1.0]
mass_kg = 2e-3
com_m = [0.0, 0.03, 0.0]
inertia_kg_m2 = [3e-6, 1e-7, 3e-6]
driven = {}
[[structure.elements]]
name = "arm"
moves = ["arm"]
low = -1.0
high = 1.0
frequency_hz = 10.0
damping = 0.1
inertia = 2e-6
"#;

/// The wings of the flapper on elements that move joints and scale series, all with an inertia.
const ELEMENTS: &str = r#"
[structure]
frequency_hz = 12.0
damping = 0.3
elements = [
  { name = "arm_left", scales = ["arm_left"], low = -1.0, high = 1.0, inertia = 2e-6 },
  { name = "arm_right", scales = ["arm_right"], low = -1.0, high = 1.0, inertia = 2e-6 },
  { name = "hand_left", moves = ["hand_left"], low = -1.0, high = 1.0, inertia = 4e-7 },
  { name = "hand_right", moves = ["hand_right"], low = -1.0, high = 1.0 },
]
"#;

fn flapper(preset: Preset) -> Robot {
    robot(&format!("{FLAPPER}{ELEMENTS}"), preset, 1.2)
}

/// The linkage's three lengths of the left wing, each an element.
fn linkage(inertia: &str) -> Robot {
    let text = include_str!("../../../../robots/aerobat_beta.toml");
    let lengths = ["l3b", "l5a", "l5b"]
        .map(|length| format!("  {{ name = \"{length}\", moves = [\"{length}_left\"]{inertia} }},\n"));
    let (before, _) = text.split_once("[structure]").unwrap();
    let structure =
        format!("[structure]\nfrequency_hz = 12.0\ndamping = 0.4\nelements = [\n{}]\n", lengths.concat());
    robot(&format!("{before}{structure}"), Preset::Paper, 1.2)
}

const U: [f64; 4] = [0.05, -0.03, 0.02, 0.04];

/// A single hinge: y'' = (w^2 (u - y) - 2 z w y') m/(m + I), so that its frequency is f sqrt(m/(m + I)); with an endless inertia, that
/// of the element alone.
#[test]
fn an_element_with_an_inertia_swings_as_its_actuator_and_link_do() {
    let omega = 10.0 * std::f64::consts::TAU;
    let link = 3e-6 + 2e-3 * 0.03 * 0.03;
    for (inertia, share) in [("2e-6", 2e-6 / (2e-6 + link)), ("2e3", 1.0)] {
        let robot = robot(&ARM.replace("2e-6\n", &format!("{inertia}\n")), Preset::Paper, 1.2);
        let still = BodyMotion::steady(Mat3::IDENTITY, Vec3::ZERO);
        let (x, u, mut dx) = ([0.2, -3.0], [0.5], [0.0; 2]);
        let loads = robot.carried(&Jet::new(0.0, 1.0, 0.0), &still, &x, &u, &mut dx).unwrap();
        let own = omega * omega * (0.5 - 0.2) + 0.2 * omega * 3.0;
        assert_eq!(dx[0], -3.0);
        assert!((dx[1] / (own * share) - 1.0).abs() < 1e-8, "{inertia}: {} {}", dx[1], own * share);
        assert!((loads.joints[0].dd - dx[1]).abs() < 1e-9 * dx[1].abs());
    }
}

/// Term by term: the inertia of each element times what its acceleration lacks of the response by itself is what its joints bear along it.
#[test]
fn what_an_element_lacks_of_its_own_response_is_its_load() {
    let by_itself = |text: &str| text.replace(", inertia = 2e-6", "").replace(", inertia = 4e-7", "");
    let of_flapper =
        (flapper(Preset::Full), robot(&by_itself(&format!("{FLAPPER}{ELEMENTS}")), Preset::Full, 1.2));
    let of_linkage = (linkage(", inertia = 0.05"), linkage(""));
    for ((loaded, driven), inertias) in [(of_flapper, vec![2e-6, 2e-6, 4e-7]), (of_linkage, vec![0.05; 3])] {
        let (l, x, t) = (*loaded.layout(), in_flight(&loaded), 0.05);
        let (elements, u) = ((l.joints - l.structure) / 2, &U[..loaded.inputs().len()]);
        let rates = |robot: &Robot| {
            let mut dx = vec![0.0; x.len()];
            robot.rates_in_numbers(t, &x, u, &mut dx).unwrap();
            dx
        };
        let (with, without) = (rates(&loaded), rates(&driven));
        let at = l.structure + elements;
        // Of its three parts a power is linear in the rate of each element: all but the one at rest.
        for (e, inertia) in inertias.iter().enumerate() {
            let power = |rate: f64| {
                let mut x = x.clone();
                x[at..at + elements].fill(0.0);
                x[at + e] = rate;
                let mut dx = vec![0.0; x.len()];
                loaded.rates_in_numbers(t, &x, u, &mut dx).unwrap();
                let mut own = vec![0.0; x.len()];
                driven.rates_in_numbers(t, &x, u, &mut own).unwrap();
                let push = inertia * (own[at + e] - dx[at + e]);
                (loaded.observe(t, &x, u).unwrap().regulator_power, push * rate)
            };
            let (given, pushed) = power(0.7);
            assert!((given - pushed).abs() < 1e-9 * given.abs(), "element {e}: {given} {pushed}");
            assert!((with[at + e] / without[at + e] - 1.0).abs() > 1e-3, "element {e} feels its load");
        }
    }
}

/// In flight with every part in motion, lengths of a linkage by tenths of a millimetre.
fn in_flight(robot: &Robot) -> Vec<f64> {
    let (l, mut x) = (*robot.layout(), moving(robot));
    let small = if robot.states()[l.structure].unit == "m" { 1e-3 } else { 1.0 };
    x[l.structure..l.joints].iter_mut().for_each(|x| *x *= small);
    x
}

/// With an inertia beyond all loads an element follows its command as one without.
#[test]
fn elements_of_endless_inertia_are_driven() {
    let [loaded, driven] = [", inertia = 1e9", ""].map(linkage);
    let x = in_flight(&driven);
    let [with, without] = [&loaded, &driven].map(|robot| {
        let mut dx = vec![0.0; x.len()];
        robot.rates_in_numbers(0.05, &x, &U[..3], &mut dx).unwrap();
        dx
    });
    for (i, (with, without)) in with.iter().zip(&without).enumerate() {
        assert!((with - without).abs() < 1e-7 * without.abs().max(1.0), "{i}: {with} {without}");
    }
}

#[test]
fn drives_air_and_loaded_elements_account_for_the_energy() {
    for robot in [flapper(Preset::Paper), flapper(Preset::Full), linkage(", inertia = 0.05")] {
        let (t, h, u) = (0.05, 1e-5, &U[..robot.inputs().len()]);
        let seen = robot.observe(t, &in_flight(&robot), u).unwrap();
        let energy = |h: f64| {
            let mut x = in_flight(&robot);
            let mut work = Workspace::new(x.len(), RK4.b.len());
            RK4.step(|t, x, dx| robot.rates_in_numbers(t, x, u, dx), t, h, &mut x, &mut work).unwrap();
            robot.observe(t + h, &x, u).unwrap().energy
        };
        let slope = (8.0 * (energy(h) - energy(-h)) - (energy(2.0 * h) - energy(-2.0 * h))) / (12.0 * h);
        let power = seen.power + seen.air_power - seen.dissipation;
        assert!((slope - power).abs() < 1e-7 * power.abs().max(0.1), "{slope} {power}");
    }
}

#[test]
fn derivatives_through_loaded_elements_are_exact() {
    let robot = flapper(Preset::Full);
    let (x, n, m) = (in_flight(&robot), robot.states().len(), robot.inputs().len());
    let mut exact = Linearisation::new(n, m);
    exact.evaluate(&robot, 0.05, &x, &U).unwrap();
    let l = robot.layout();
    for j in [l.velocity, l.rate, l.structure, l.structure + 2, l.structure + 5, l.joints, l.aero, n - 1, n] {
        let at = |sign: f64| {
            let (mut x, mut u, mut dx) = (x.clone(), U, vec![0.0; n]);
            if j < n {
                x[j] += sign * 1e-6
            } else {
                u[j - n] += sign * 1e-6
            }
            robot.rates_in_numbers(0.05, &x, &u, &mut dx).unwrap();
            dx
        };
        let (up, down) = (at(1.0), at(-1.0));
        for i in 0..n {
            let difference = (up[i] - down[i]) / 2e-6;
            let exact = if j < n { exact.a[i * n + j] } else { exact.b[i * m + j - n] };
            let scale = 1.0 + exact.abs().max(up[i].abs());
            assert!((difference - exact).abs() < 2e-6 * scale, "d{i}/d{j}: {difference} {exact}");
        }
    }
}

#[test]
fn an_inertia_without_joints_is_refused_by_key() {
    use wingbeat::scenario::Document;
    let refused = |text: &str| {
        let air = Air { density: 1.2, wind: Wind::steady(Vec3::ZERO) };
        match Document::text("robot", text).and_then(|document| document.robot()) {
            Ok(spec) => Robot::new(&spec, Vec::new(), air, 0.0).unwrap_err().to_string(),
            Err(error) => error.to_string(),
        }
    };
    let of_spring = ARM.replace("driven = {}", "elastic = { stiffness = 1e-3, damping = 0.0 }");
    assert!(refused(&of_spring).contains("structure.elements[0].inertia"), "{}", refused(&of_spring));
    let negative = ARM.replace("inertia = 2e-6\n", "inertia = -2e-6\n");
    assert!(refused(&negative).contains("inertia = "), "{}", refused(&negative));
}
