//! The banking turn with preset `full`: mirror images and convergence with the step.

use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::plant::Plant;
use wingbeat::robot::Robot;
use wingbeat::scenario::Scenario;
use wingbeat::simulate::Record;

fn scenario(overrides: &[&str]) -> Scenario {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let overrides = ["aero.preset=full"].iter().chain(overrides).map(|s| s.to_string()).collect::<Vec<_>>();
    Scenario::load(&path, &overrides).unwrap_or_else(|e| panic!("{e}"))
}

fn fly(overrides: &[&str]) -> Record {
    scenario(overrides).fly(|_| ControlFlow::Continue(())).unwrap().record
}

/// For every carried state the one of the other wing.
fn images(robot: &Robot) -> Vec<usize> {
    let mirror = robot.mirror().unwrap();
    let count = robot.states().len() - robot.layout().structure;
    let kept: Vec<usize> = (0..mirror.states.len()).collect();
    let mut place = vec![0; count];
    mirror.expand_states(&kept, &mut place);
    let image = |i: usize| (0..count).find(|&j| j != i && place[j] == place[i]).unwrap_or(i);
    (0..count).map(image).collect()
}

/// A state, or its rate, seen in the mirror of the plane of symmetry.
fn mirrored(robot: &Robot, images: &[usize], x: &[f64]) -> Vec<f64> {
    let l = robot.layout();
    let mut image = x.to_vec();
    let turned = [l.position + 1, l.attitude + 1, l.attitude + 3, l.velocity + 1, l.rate, l.rate + 2];
    turned.iter().for_each(|&i| image[i] = -x[i]);
    for (i, &other) in images.iter().enumerate() {
        image[l.structure + i] = x[l.structure + other];
    }
    image
}

/// Numbers in [-1, 1] that look drawn at random (Weyl's sequence).
fn draws() -> impl FnMut() -> f64 {
    let mut k = 0.0_f64;
    move || {
        k += 1.0;
        2.0 * (k * 0.618_033_988_749_895 + (k * k * 0.000_137_3)).fract() - 1.0
    }
}

/// A state of flight: tumbling, in any stroke of the wings, with any lags.
fn drawn_state(robot: &Robot, draw: &mut impl FnMut() -> f64) -> Vec<f64> {
    let l = robot.layout();
    let mut x: Vec<f64> = (0..l.len).map(|_| 0.3 * draw()).collect();
    x[l.attitude] = 1.0;
    let norm = x[l.attitude..l.attitude + 4].iter().map(|q| q * q).sum::<f64>().sqrt();
    x[l.attitude..l.attitude + 4].iter_mut().for_each(|q| *q /= norm);
    (0..3).for_each(|i| x[l.velocity + i] += [1.5, 0.0, 0.0][i] + draw());
    (0..3).for_each(|i| x[l.rate + i] = 3.0 * draw());
    (l.structure..l.joints).for_each(|i| x[i] *= 0.3);
    x
}

#[test]
fn the_rates_of_a_mirror_image_are_the_mirror_image_of_the_rates() {
    for strips in [8, 9, 13, 16] {
        let scenario = scenario(&[&format!("aero.full.strips={strips}")]);
        let robot = scenario.robot();
        let (images, mut draw) = (images(robot), draws());
        for case in 0..1000 {
            let x = drawn_state(robot, &mut draw);
            let (t, u) = (draw().abs(), vec![0.0; robot.inputs().len()]);
            let rates = |x: &[f64]| {
                let mut dx = x.to_vec();
                robot.rates_in_numbers(t, x, &u, &mut dx).unwrap();
                dx
            };
            let expected = mirrored(robot, &images, &rates(&x));
            let found = rates(&mirrored(robot, &images, &x));
            let largest = expected.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
            for (i, (a, b)) in expected.iter().zip(&found).enumerate() {
                let off = (a - b).abs();
                assert!(off <= 1e-12 * largest, "{strips} strips, state {case}, rate {i}: {a} and {b}");
            }
        }
    }
}

#[test]
fn a_symmetric_flight_stays_symmetric() {
    let record = fly(&["flight.duration_s=1.0", "manoeuvre.turn_start_s=2.0"]);
    let roll = record.values("roll").unwrap();
    let largest = roll.iter().fold(0.0_f64, |m, v| m.max(v.abs())).to_degrees();
    assert!(largest <= 1e-9, "{largest} deg");
}

#[test]
fn left_and_right_turns_mirror_each_other() {
    let turn = |side: f64| {
        let asked = [
            format!("manoeuvre.roll_deg={}", 15.0 * side),
            format!("manoeuvre.yaw_rate_rad_s={}", -0.6 * side),
            "manoeuvre.turn_start_s=0.2".into(),
            "flight.duration_s=1.2".into(),
        ];
        fly(&asked.each_ref().map(|s: &String| s.as_str()))
    };
    let (right, left) = (turn(1.0), turn(-1.0));
    for (name, sign) in [("roll", -1.0), ("pitch", 1.0), ("yaw", -1.0)] {
        let (a, b) = (right.values(name).unwrap(), left.values(name).unwrap());
        let off = a.iter().zip(b).fold(0.0_f64, |m, (a, b)| m.max((a - sign * b).abs()));
        assert!(off < 1e-9, "{name}: {off} rad");
    }
    assert!(right.values("roll").unwrap().last().unwrap().to_degrees() > 5.0);
}

/// Largest differences of position, m, and of attitude, rad, at the last instant of two flights.
fn apart(a: &Record, b: &Record) -> [f64; 2] {
    let off = |names: [&str; 3]| {
        let last =
            |r: &Record, name: &str| *r.values(name).unwrap_or_else(|| panic!("{name}")).last().unwrap();
        names.iter().fold(0.0_f64, |m, name| m.max((last(a, name) - last(b, name)).abs()))
    };
    [off(["com_x", "com_y", "com_z"]), off(["roll", "pitch", "yaw"])]
}

#[test]
fn a_flight_converges_with_the_step() {
    let flown = |step: &str| fly(&["flight.duration_s=1.0", &format!("flight.step_s={step}")]);
    let [coarse, middle, fine] = ["2e-4", "1e-4", "5e-5"].map(flown);
    let (first, second) = (apart(&coarse, &middle), apart(&middle, &fine));
    assert!(second[0] < 1e-8 && second[1] < 1e-8, "{second:?}");
    let order = (first[0] / second[0]).log2();
    assert!((3.5..4.5).contains(&order), "order {order}: {first:?} and {second:?}");
}
