//! What turns the crank and what displaces the structure: motors, regulators, their power.

use std::ops::ControlFlow;
use wingbeat::aero::{
    Aero, LiftLaw, LiftingLine, LiftingLineSettings, SectionSettings, StripModel, StripSettings,
};
use wingbeat::guide::Stand;
use wingbeat::math::{Jet, Mat3, Quat, Vec3};
use wingbeat::plant::{Linearisation, Plant, Role};
use wingbeat::robot::{Air, BodyMotion, Robot, Wind};
use wingbeat::scenario::Document;
use wingbeat::simulate::{Held, Moment, Observed, Stepper};

/// Wings on series of the phase, an elastic feather, three regulators on four elements.
const FLAPPER: &str = r#"
name = "flapper"
[body]
mass_kg = 0.012
inertia_kg_m2 = [9e-6, 3e-5, 3e-5]
drag_area_m2 = [0.001, 0.002, 0.0]
[gait.fourier]
frequency_hz = 4.0
[[links]]
name = "arm"
side = "mirrored"
origin_m = [0.0, 0.02, 0.005]
mass_kg = 0.001
com_m = [0.0, 0.025, 0.0]
inertia_kg_m2 = [2e-7, 1e-8, 2e-7]
driven = { mean_rad = 0.1, harmonics = [{ amplitude_rad = 0.6, phase_rad = 0.0 }] }
[[links]]
name = "hand"
side = "mirrored"
parent = "arm"
origin_m = [0.0, 0.05, 0.0]
mass_kg = 0.001
com_m = [0.0, 0.03, 0.0]
inertia_kg_m2 = [4e-7, 1e-7, 4e-7]
driven = { mean_rad = -0.3, harmonics = [{ amplitude_rad = 0.3, phase_rad = 1.0 }], lag_rad = 0.4 }
[[links]]
name = "feather"
side = "mirrored"
parent = "hand"
origin_m = [0.01, 0.06, 0.0]
axis = [0.0, -1.0, 0.0]
mass_kg = 0.001
com_m = [-0.01, 0.03, 0.0]
inertia_kg_m2 = [4e-7, 4e-7, 6e-7]
elastic = { stiffness = 4e-3, damping = 2e-5, rest = 0.05 }
[[surfaces]]
name = "wing"
cd0 = 0.05
cd90 = 1.5
planform = [
  { arc_m = 0.0, leading_edge_m = 0.04, trailing_edge_m = -0.06 },
  { arc_m = 0.20, leading_edge_m = 0.02, trailing_edge_m = -0.03 },
]
panels = [
  { link = "body", origin_m = [0.0, 0.0, 0.005] },
  { link = "arm", from_arc_m = 0.02 },
  { link = "hand", from_arc_m = 0.07 },
  { link = "feather", from_arc_m = 0.13, origin_m = [-0.01, 0.0, 0.0] },
]
[[structure.elements]]
name = "arm_left"
moves = ["arm_left"]
frequency_hz = 12.0
[[structure.elements]]
name = "arm_right"
moves = ["arm_right"]
frequency_hz = 12.0
[[structure.elements]]
name = "hand_left"
moves = ["hand_left"]
[[structure.elements]]
name = "hand_right"
moves = ["hand_right"]
[structure]
frequency_hz = 9.0
damping = 0.7
[[structure.regulators]]
name = "fold"
elements = { hand_left = 1.0, hand_right = 1.0 }
low = -0.3
high = 0.3
[[structure.regulators]]
name = "left"
elements = { arm_left = 1.0, hand_left = -0.5 }
low = -0.2
high = 0.2
[[structure.regulators]]
name = "right"
elements = { arm_right = 1.0, hand_right = -0.5 }
low = -0.2
high = 0.2
"#;

/// A coreless motor of the class of a few watts; all choices.
const MOTOR: &str = r#"
[drive.motor]
torque_constant_n_m_a = 1.5e-3
resistance_ohm = 1.0
supply_v = 3.7
gear_ratio = 60.0
efficiency = 0.8
rotor_inertia_kg_m2 = 3e-9
crank_inertia_kg_m2 = 1e-6
"#;

fn beta() -> String {
    let path = format!("{}/../../robots/aerobat_beta.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

fn with_motor(text: &str) -> String {
    format!("{text}{MOTOR}")
}

fn build(text: &str, full: bool, density: f64) -> Result<Robot, wingbeat::Error> {
    let spec = Document::text("robot", text).unwrap().robot().unwrap();
    let models = spec.outlines()?.into_iter().map(|outline| {
        if full {
            let settings = StripSettings {
                strips: outline.strips.unwrap_or(14),
                hinge_arcs_m: outline.hinges.clone(),
                section: SectionSettings {
                    density_kg_m3: density,
                    drag: outline.drag(LiftLaw::Linear),
                    ..Default::default()
                },
                ..StripSettings::default()
            };
            Aero::Strip(StripModel::new(&outline.planform, settings).unwrap())
        } else {
            let settings = LiftingLineSettings {
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
    });
    let models = models.collect();
    Robot::new(&spec, models, Air { density, wind: Wind::steady(Vec3(STEADY)) }, 0.3)
}

const STEADY: [f64; 3] = [0.1, 0.0, 0.05];

fn robot(text: &str) -> Robot {
    build(text, false, 1.2).unwrap()
}

/// In flight, the structure as it starts.
fn start(robot: &Robot) -> Vec<f64> {
    let l = robot.layout();
    let mut x = vec![0.0; l.len];
    Quat::from_roll_pitch_yaw(0.1, -0.2, 0.0).store_wxyz(&mut x[l.attitude..]);
    x[l.velocity] = 2.0;
    x[l.joints..l.aero].copy_from_slice(&robot.start_coordinates());
    x
}

/// In flight with every part in motion, and inputs.
fn moving(robot: &Robot) -> (Vec<f64>, Vec<f64>) {
    let l = robot.layout();
    let mut x: Vec<f64> = (0..l.len).map(|i| 0.05 * (1.7 * i as f64).sin()).collect();
    Quat::from_roll_pitch_yaw(0.2, -0.3, 0.4).store_wxyz(&mut x[l.attitude..]);
    Vec3::new(2.0, 0.1, -0.3).store(&mut x[l.velocity..]);
    let elements = (l.joints - l.structure) / 2;
    for (i, stroke) in robot.strokes().iter().enumerate() {
        x[l.structure + i] = stroke[0] + (0.4 + 0.1 * (i as f64).sin()) * (stroke[1] - stroke[0]);
        x[l.structure + elements + i] = 8.0 * (stroke[1] - stroke[0]) * (0.7 + i as f64).sin();
    }
    if let Some([angle, rate]) = l.crank {
        (x[angle], x[rate]) = (1.1, 19.0);
    }
    let u = robot.inputs().iter().map(|c| 0.6 * c.high + 0.4 * c.low).collect();
    (x, u)
}

fn rates(robot: &Robot, x: &[f64], u: &[f64]) -> Vec<f64> {
    let mut dx = vec![0.0; x.len()];
    robot.rates_in_numbers(0.02, x, u, &mut dx).unwrap();
    dx
}

/// A robot's text with the motor, its rotor as heavy as a house.
fn heavy(text: &str) -> String {
    let heavy = with_motor(text).replace("rotor_inertia_kg_m2 = 3e-9", "rotor_inertia_kg_m2 = 30.0");
    assert!(heavy.contains("= 30.0"));
    heavy
}

#[test]
fn a_crank_of_endless_inertia_turns_at_a_constant_rate() {
    for text in [FLAPPER.to_string(), beta()] {
        let (constant, motor) = (robot(&text), robot(&heavy(&text)));
        let fly = |robot: &Robot| {
            let mut stepper = Stepper::new(robot, 0.0, &start(robot));
            stepper.set_inputs(&vec![0.01; robot.inputs().len()]);
            let mut quiet = Held(|_, _: Moment| Ok(ControlFlow::Continue(())));
            stepper.run(2e-4, 1000, &mut quiet).check().unwrap();
            stepper.state().to_vec()
        };
        let (expected, found) = (fly(&constant), fly(&motor));
        let [angle, rate] = motor.layout().crank.unwrap();
        assert!((found[angle] - constant.phase(0.2)).abs() < 1e-6, "{}", found[angle]);
        assert!((found[rate] / (std::f64::consts::TAU * constant.frequency_hz()) - 1.0).abs() < 1e-6);
        let others = found.iter().enumerate().filter(|(i, _)| *i != angle && *i != rate);
        for ((_, found), expected) in others.zip(&expected) {
            assert!((found - expected).abs() < 1e-5 * (1.0 + expected.abs()), "{found} {expected}");
        }
        assert!((expected[1] - start(&constant)[1]).abs() > 1e-4, "the robots must have flown");
    }
}

/// The crank bears by virtual work what the joints need, and what is left of the motor's torque
/// accelerates rotor and crank.
#[test]
fn the_crank_bears_its_joints() {
    for (text, full) in [(FLAPPER.to_string(), false), (FLAPPER.to_string(), true), (beta(), true)] {
        let robot = build(&with_motor(&text), full, 1.2).unwrap();
        let (x, u) = moving(&robot);
        let [angle, rate] = robot.layout().crank.unwrap();
        let (dx, seen) = (rates(&robot, &x, &u), robot.observe(0.02, &x, &u).unwrap());
        let motor = seen.motor.unwrap();
        assert_eq!((dx[angle], motor.crank_rate, seen.phase), (x[rate], x[rate], x[angle]));
        let needed = motor.crank_torque - robot.motor().unwrap().inertia() * dx[rate];
        let found = seen.drive_power / x[rate];
        assert!((found - needed).abs() < 1e-10 * needed.abs().max(motor.crank_torque), "{found} {needed}");
    }
}

#[test]
fn drive_and_regulators_share_the_power_of_the_joints() {
    for text in [FLAPPER.to_string(), with_motor(FLAPPER), beta(), with_motor(&beta())] {
        let robot = robot(&text);
        let (x, u) = moving(&robot);
        let seen = robot.observe(0.02, &x, &u).unwrap();
        let sum = seen.drive_power + seen.regulator_power;
        let scale = seen.drive_power.abs() + seen.regulator_power.abs();
        assert!((sum - seen.power).abs() < 1e-12 * scale, "{sum} {}", seen.power);
        assert!(seen.drive_power.abs() > 1e-3 && seen.regulator_power.abs() > 1e-3, "{seen:?}");
    }
}

/// The regulators' power is what remains when the crank stands still, by differences of the joints.
#[test]
fn the_linkage_gives_its_regulators_the_partial_rates_of_its_pose() {
    let robot = robot(&beta());
    let (x, u) = moving(&robot);
    let (l, h) = (*robot.layout(), 1e-6);
    let elements = (l.joints - l.structure) / 2;
    let seen = robot.observe(0.02, &x, &u).unwrap();
    let joints = |sign: f64| {
        let mut x = x.clone();
        (0..elements).for_each(|i| x[l.structure + i] += sign * h * x[l.structure + elements + i]);
        robot.observe(0.02, &x, &u).unwrap().joints
    };
    let (up, down) = (joints(1.0), joints(-1.0));
    let rates = up.iter().zip(&down).map(|(up, down)| (up - down) / (2.0 * h));
    let power: f64 = rates.zip(&seen.torques).map(|(rate, torque)| rate * torque).sum();
    assert!((power - seen.regulator_power).abs() < 1e-6 * power.abs(), "{power} {}", seen.regulator_power);
}

#[test]
fn motor_regulators_and_air_account_for_the_energy() {
    for (text, full) in [(FLAPPER.to_string(), false), (FLAPPER.to_string(), true), (beta(), false)] {
        let robot = build(&with_motor(&text), full, 1.2).unwrap();
        let ((x, u), t, h) = (moving(&robot), 0.02, 1e-5);
        let seen = robot.observe(t, &x, &u).unwrap();
        let energies = |h: f64| {
            let mut stepper = Stepper::new(&robot, t, &x);
            stepper.set_inputs(&u);
            stepper.step(h).unwrap();
            let seen = robot.observed(stepper.moment()).unwrap();
            [seen.energy, seen.energy + seen.motor.unwrap().energy]
        };
        let near = [energies(h), energies(-h)];
        let far = [energies(2.0 * h), energies(-2.0 * h)];
        let slope = |i: usize| (8.0 * (near[0][i] - near[1][i]) - (far[0][i] - far[1][i])) / (12.0 * h);
        let motor = seen.motor.unwrap();
        let lost = seen.dissipation - seen.air_power - seen.regulator_power;
        for (slope, power) in
            [(slope(0), seen.drive_power - lost), (slope(1), motor.crank_torque * motor.crank_rate - lost)]
        {
            assert!((slope - power).abs() < 2e-7 * power.abs().max(0.1), "{slope} {power}");
        }
        let passed = motor.crank_torque * motor.crank_rate / motor.shaft_power;
        assert!((passed - 0.8).abs() < 1e-4, "gearbox {passed}");
        assert!(motor.electrical_power > motor.shaft_power);
    }
}

#[test]
fn derivatives_through_the_crank_are_exact() {
    for (text, full) in [(FLAPPER.to_string(), false), (FLAPPER.to_string(), true), (beta(), false)] {
        let robot = build(&with_motor(&text), full, 1.2).unwrap();
        let ((x, u), n, m) = (moving(&robot), robot.states().len(), robot.inputs().len());
        let mut exact = Linearisation::new(n, m);
        exact.evaluate(&robot, 0.02, &x, &u).unwrap();
        let l = robot.layout();
        let [angle, rate] = l.crank.unwrap();
        for j in [l.attitude, l.velocity, l.rate, l.structure, l.joints, angle, rate, l.aero, n - 1] {
            let h = 1e-6;
            let at = |sign: f64| {
                let mut moved = x.clone();
                moved[j] += sign * h;
                rates(&robot, &moved, &u)
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

/// The crank's rate over `turns` nominal turns from `omega` (rad/s) on, the body held in the wind:
/// mean over the last turn, its range over its mean, and the mean power of the joints over that turn.
fn turned(text: &str, omega: f64, turns: usize) -> [f64; 3] {
    let text =
        text.replace("frequency_hz = 4.0", &format!("frequency_hz = {}", omega / std::f64::consts::TAU));
    let robot = robot(&text);
    let body = BodyMotion::steady(Mat3::from_roll_pitch_yaw(0.0, -0.2, 0.0), Vec3::new(2.0, 0.0, 0.0));
    let l = robot.layout();
    let first = l.structure;
    let mut x = vec![0.0; robot.carried_states()];
    x[l.joints - first..l.aero - first].copy_from_slice(&robot.start_coordinates());
    let u = vec![0.0; robot.inputs().len()];
    let (per_turn, mut dx) = (400, x.clone());
    let h = std::f64::consts::TAU / omega / per_turn as f64;
    let slope = |t: f64, x: &[f64], dx: &mut [f64]| {
        robot.carried_in_numbers(&Jet::new(t, 1.0, 0.0), &body, x, &u, dx).map(|loads| loads.joint_power())
    };
    let (mut rates, mut power) = (Vec::new(), 0.0);
    let mut work = wingbeat::math::Workspace::new(x.len(), wingbeat::math::RK4.b.len());
    for step in 0..turns * per_turn {
        let t = step as f64 * h;
        if step >= (turns - 1) * per_turn {
            power += slope(t, &x, &mut dx).unwrap() / per_turn as f64;
            rates.push(l.crank.map_or(omega, |[_, rate]| x[rate - first]));
        }
        wingbeat::math::RK4.step(|t, x, dx| slope(t, x, dx).map(|_| ()), t, h, &mut x, &mut work).unwrap();
    }
    let mean = rates.iter().sum::<f64>() / rates.len() as f64;
    let range = rates.iter().fold([f64::MAX, f64::MIN], |r, x| [r[0].min(*x), r[1].max(*x)]);
    [mean, (range[1] - range[0]) / mean, power]
}

/// Where the mean load of the turning wings meets the torque-speed line, found at constant rates, there
/// the motor settles; without wings to move it settles at its no-load speed.
#[test]
fn the_crank_settles_on_the_torque_speed_line() {
    // Elastic joints give power back and forth; without them the joints' power is the drive's.
    let text = FLAPPER.replace("elastic = { stiffness = 4e-3, damping = 2e-5, rest = 0.05 }", "");
    let (kt, ohm, volt, gear, efficiency) = (1.5e-3, 1.0, 3.7, 60.0, 0.8);
    let torque = |w: f64| efficiency * gear * kt / ohm * (volt - kt * gear * w);
    let excess = |w: f64| torque(w) - turned(&text, w, 3)[2] / w;
    let (mut low, mut high) = (15.0, volt / kt / gear);
    assert!(excess(low) > 0.0 && excess(high) < 0.0);
    for _ in 0..9 {
        let middle = 0.5 * (low + high);
        *(if excess(middle) > 0.0 { &mut low } else { &mut high }) = middle;
    }
    let expected = 0.5 * (low + high);
    // Heavy enough that the load's swing hardly shows, light enough to settle.
    let motor = with_motor(&text).replace("crank_inertia_kg_m2 = 1e-6", "crank_inertia_kg_m2 = 4e-4");
    let [mean, ripple, _] = turned(&motor, 0.9 * expected, 12);
    assert!((mean / expected - 1.0).abs() < 5e-3, "{mean} {expected}");
    assert!(ripple > 1e-3 && ripple < 0.1, "{ripple}");
    let light = turned(&with_motor(&text), 0.9 * expected, 6)[1];
    assert!(light > 3.0 * ripple, "a lighter rotor ripples more: {light} {ripple}");

    let still = motor.replace("amplitude_rad = 0.6", "amplitude_rad = 0.0");
    let still = still.replace("amplitude_rad = 0.3", "amplitude_rad = 0.0");
    let free = turned(&still, 0.9 * volt / kt / gear, 40)[0];
    assert!((free * gear * kt / volt - 1.0).abs() < 1e-3, "{free}");
}

#[test]
fn held_regulators_displace_by_their_placement() {
    let robot = robot(FLAPPER);
    let (l, u) = (*robot.layout(), [0.2, -0.1, 0.15]);
    let placed = [-0.1, 0.15, 0.2 + 0.05, 0.2 - 0.075];
    let names: Vec<&str> = robot.inputs().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["command_fold", "command_left", "command_right"]);
    assert_eq!(robot.inputs()[2].role, Role::Command(2));
    let mut x = start(&robot);
    x[l.structure..l.structure + 4].copy_from_slice(&placed);
    let dx = rates(&robot, &x, &u);
    assert!(dx[l.structure..l.joints].iter().all(|dx| dx.abs() < 1e-12), "{:?}", &dx[l.structure..l.joints]);
    assert_eq!(robot.strokes()[0], [-0.2, 0.2]);
    let [low, high] = robot.strokes()[2];
    assert!((low + 0.4).abs() < 1e-15 && (high - 0.4).abs() < 1e-15);
}

/// The regulators of FLAPPER by stiffness and damping, and by full matrices.
fn matrices(full: bool) -> String {
    let element = |hz: f64| {
        let w = std::f64::consts::TAU * hz;
        (w * w, 2.0 * 0.7 * w)
    };
    let parts = [12.0, 12.0, 9.0, 9.0].map(element);
    let placement = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, -0.5, 0.0], [1.0, 0.0, -0.5]];
    let diagonal = |of: fn(&(f64, f64)) -> f64, sign: f64| -> Vec<Vec<f64>> {
        let row = |i: usize| (0..4).map(|j| if i == j { sign * of(&parts[i]) } else { 0.0 }).collect();
        (0..4).map(row).collect()
    };
    let head = FLAPPER.find("[structure]").unwrap();
    let elements = FLAPPER[..head].replace("\nfrequency_hz = 12.0", "");
    if !full {
        let (k, c) = (diagonal(|p| p.0, 1.0), diagonal(|p| p.1, 1.0));
        let tail = FLAPPER[head..].replace("frequency_hz = 9.0", &format!("stiffness_per_s2 = {k:?}"));
        return elements + &tail.replace("damping = 0.7", &format!("damping_per_s = {c:?}"));
    }
    let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
    let mut a: Vec<Vec<f64>> = (0..4).map(|i| (0..8).map(|j| unit(i + 4, j)).collect()).collect();
    a.extend(diagonal(|p| p.0, -1.0).into_iter().zip(diagonal(|p| p.1, -1.0)).map(|(k, c)| [k, c].concat()));
    let mut b = vec![vec![0.0; 3]; 4];
    b.extend((0..4).map(|i| placement[i].iter().map(|p| p * parts[i].0).collect::<Vec<_>>()));
    let regulator = |name| format!("[[structure.regulators]]\nname = \"{name}\"\nlow = -0.2\nhigh = 0.2\n");
    let regulators: String = ["fold", "left", "right"].map(regulator).concat();
    format!("{elements}[structure]\na = {a:?}\nb = {b:?}\n{regulators}")
}

#[test]
fn placement_parts_and_matrices_are_one_structure() {
    let elements = robot(FLAPPER);
    let (x, u) = moving(&elements);
    let expected = rates(&elements, &x, &u);
    for text in [matrices(false), matrices(true)] {
        let other = robot(&text);
        for (found, expected) in rates(&other, &x, &u).iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-10 * expected.abs().max(1.0), "{found} {expected}");
        }
    }
}

#[test]
fn a_regulator_takes_its_limits_from_link_lengths() {
    let text = |gain: f64, more: &str| {
        let own = "\n[[structure.regulators]]\nname = \"fold\"\n";
        format!("{}{own}elements = {{ l5a_left = {gain}, l5a_right = {gain} }}\n{more}", beta())
    };
    let own = robot(&beta());
    let length = own.inputs().iter().find(|c| c.name == "command_l5a_left").unwrap().clone();
    for gain in [1.0, -2.0] {
        let fold = robot(&text(gain, "")).inputs()[0].clone();
        let limits = [length.low / gain, length.high / gain];
        assert_eq!([fold.low, fold.high], [limits[0].min(limits[1]), limits[0].max(limits[1])]);
        assert_eq!(fold.unit, "m");
    }
    let refused = build(&text(1.0, "low = -0.1\nhigh = 0.1\n"), false, 1.2).unwrap_err().to_string();
    assert!(refused.starts_with("structure.regulators[0].low = -0.1"), "{refused}");
}

#[test]
fn regulators_have_images_on_the_other_wing() {
    let robot = robot(FLAPPER);
    let stand = Stand::new(&robot, Vec3::new(2.0, 0.0, 0.0), 0.0).unwrap();
    assert_eq!(stand.mirror().inputs, [0, 1]);
    let mut all = [0.0; 3];
    stand.mirror().expand_inputs(&[0.3, 0.1], &mut all);
    assert_eq!(all, [0.3, 0.1, 0.1]);
    let one_sided = FLAPPER.replace("arm_right = 1.0, hand_right = -0.5", "arm_right = 1.0");
    let refused =
        Stand::new(&self::robot(&one_sided), Vec3::new(2.0, 0.0, 0.0), 0.0).unwrap_err().to_string();
    assert!(refused.starts_with("robot.structure.regulators = command_left"), "{refused}");
    let motor = self::robot(&with_motor(FLAPPER));
    let refused = Stand::new(&motor, Vec3::new(2.0, 0.0, 0.0), 0.0).unwrap_err().to_string();
    assert!(refused.starts_with("robot.drive.motor"), "{refused}");
}

#[test]
fn what_a_drive_or_a_regulator_cannot_be_is_refused_by_key() {
    let refusal = |text: &str| match build(text, false, 1.2) {
        Err(error) => error.to_string(),
        Ok(_) => String::from("accepted"),
    };
    let motor = |from: &str, to: &str| {
        let text = with_motor(FLAPPER).replacen(from, to, 1);
        assert_ne!(text, with_motor(FLAPPER), "{from}");
        refusal(&text)
    };
    for (from, to, key) in [
        ("gear_ratio = 60.0", "gear_ratio = 0.0", "drive.motor.gear_ratio = 0"),
        ("efficiency = 0.8", "efficiency = 1.2", "drive.motor.efficiency = 1.2"),
        ("kg_m2 = 3e-9", "kg_m2 = 0.0", "drive.motor.rotor_inertia_kg_m2 = 0"),
        ("kg_m2 = 1e-6", "kg_m2 = -1.0", "drive.motor.crank_inertia_kg_m2 = -1"),
        ("supply_v = 3.7", "", "drive.motor.supply_v = missing"),
        ("resistance_ohm = 1.0", "resistance_ohm = nan", "drive.motor.resistance_ohm = NaN"),
        ("supply_v = 3.7", "stall_torque_n_m = 0.01", "drive.motor.stall_torque_n_m = 0.01"),
        (
            "elements = { hand_left = 1.0, ",
            "elements = { hand = 1.0, ",
            "structure.regulators[0].elements = \"hand\"",
        ),
        ("hand_left = 1.0", "hand_left = 0.0", "structure.regulators[0].elements.hand_left = 0"),
        ("elements = { hand_left = 1.0, hand_right = 1.0 }", "", "structure.regulators[0].elements = {}"),
        ("low = -0.3\n", "", "structure.regulators[0].low = missing"),
        (
            "name = \"right\"",
            "name = \"left\"",
            "structure.regulators[2].name = \"left\": allowed is a name of its own",
        ),
        ("damping = 0.7", "damping = -0.7", "structure.damping = -0.7"),
        ("damping = 0.7", "", "structure.damping = missing"),
        ("\nfrequency_hz = 12.0", "\nfrequency_hz = 0.0", "structure.elements[0].frequency_hz = 0"),
        ("damping = 0.7", "damping = 0.7\na = [[1.0]]", "structure.b = missing"),
        ("damping = 0.7", "damping = 0.7\na = [[1.0]]\nb = [[1.0]]", "structure.regulators[0].elements"),
        ("damping = 0.7", "stiffness_per_s2 = [[1.0]]", "structure.damping_per_s = missing"),
        (
            "damping = 0.7",
            "stiffness_per_s2 = [[1.0]]\ndamping_per_s = [[1.0]]",
            "structure.frequency_hz = 9",
        ),
    ] {
        let refused = motor(from, to);
        assert!(refused.starts_with(key), "{from} -> {to}: {refused}, not {key}");
    }
    let short = matrices(false).replacen("damping_per_s = [[", "damping_per_s = [[1.0], [", 1);
    assert!(refusal(&short).starts_with("structure.damping_per_s"), "{}", refusal(&short));
    let still = "name = \"still\"\n[body]\nmass_kg = 1.0\ninertia_kg_m2 = [1.0, 1.0, 1.0]\n";
    assert!(refusal(&with_motor(still)).starts_with("drive.motor"), "{}", refusal(&with_motor(still)));
    let spare = "[[structure.regulators]]\nname = \"x\"\nelements = { hand_left = 1.0 }\n";
    let many = refusal(&format!("{FLAPPER}{spare}{}", spare.replace("\"x\"", "\"y\"")));
    assert!(many.starts_with("structure.regulators = 5"), "{many}");
}
