//! Thrusters on a robot, and the hover that they hold.

use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::math::{GRAVITY, Vec3};
use wingbeat::plant::Plant;
use wingbeat::scenario::{Document, Scenario};
use wingbeat::simulate::Stepper;

fn document(overrides: &[&str]) -> Document {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/hover_guarded.toml");
    overrides.iter().fold(Document::file(&path).unwrap(), |d, text| d.set(*text))
}

fn scenario(overrides: &[&str]) -> Scenario {
    Scenario::new(document(overrides)).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn thrusters_push_the_body_and_lag_their_commands() {
    let scenario = scenario(&["flight.flapping=false"]);
    let (robot, start) = (scenario.robot(), scenario.start());
    let place = |name: &str| robot.states().iter().position(|c| c.name == name).unwrap();
    let (element, velocity) = (place("displacement_thruster_1"), robot.layout().velocity);
    let rates = |thrust: f64| {
        let (mut x, mut dx) = (start.clone(), vec![0.0; start.len()]);
        x[element] = thrust;
        robot.rates_in_numbers(0.0, &x, &vec![0.0; robot.inputs().len()], &mut dx).unwrap();
        dx
    };
    // What a thrust adds is linear in it, and the d'Alembert sum of an observation closes with it.
    let [none, one, two] = [0.0, 0.1, 0.2].map(|thrust| Vec3::from_slice(&rates(thrust)[velocity..]));
    assert!((two - none - (one - none) * 2.0).norm() < 1e-9 && (one - none).norm() > 0.5);
    let mut pushed = start.clone();
    pushed[element] = 0.2;
    let seen = robot.observe(0.0, &pushed, &vec![0.0; robot.inputs().len()]).unwrap();
    let sum = seen.parts().iter().fold(seen.thrust, |sum, part| sum + *part);
    assert!(sum.force.norm() < 1e-9 && sum.moment.norm() < 1e-9, "{sum:?}");
    assert!((seen.thrust.force.norm() - 0.2).abs() < 1e-12);
    let arm = robot.thrusters()[0].place;
    assert!((seen.thrust.moment - arm.cross(seen.thrust.force)).norm() < 1e-15);
    // A thrust that has come to rest is its command, limited; on the way it lags by .03 s: the integral of what is missing.
    let mut stepper = Stepper::new(robot, 0.0, &start);
    let mut commands = vec![0.0; robot.inputs().len()];
    let thruster = &robot.thrusters()[0];
    commands[thruster.element] = 9.0;
    stepper.set_inputs(&commands);
    assert_eq!(stepper.inputs()[thruster.element], 0.3);
    commands[thruster.element] = 0.1;
    stepper.set_inputs(&commands);
    let (step, mut missing) = (1e-3, 0.0);
    for _ in 0..400 {
        missing += (0.1 - stepper.state()[element]) * step;
        stepper.step(step).unwrap();
    }
    assert!((stepper.state()[element] - 0.1).abs() < 1e-6);
    assert!((missing / 0.1 - 0.03).abs() < 1e-3, "{missing}");
}

#[test]
fn a_guarded_robot_hovers_and_its_observer_finds_the_force_of_the_air() {
    let run = scenario(&["flight.duration_s=6.0"]).fly(|_| ControlFlow::Continue(())).unwrap();
    let hover = run.summary.hover.unwrap();
    assert!(hover.place_rms_m < 0.05 && hover.attitude_max_deg < 3.0, "{hover:?}");
    assert!(hover.air_force_error < 0.1, "{hover:?}");
    assert_eq!(run.summary.controller.failures, 0);
    // Without wings that beat the thrusters carry all of the weight.
    let still = scenario(&["flight.duration_s=4.0", "flight.flapping=false"]);
    let run = still.fly(|_| ControlFlow::Continue(())).unwrap();
    let (up, weight) = (run.record.values("thrust_z").unwrap(), still.robot().mass() * GRAVITY);
    assert!((up[up.len() - 1] / weight - 1.0).abs() < 1e-3, "{}", up[up.len() - 1]);
    assert!(run.summary.hover.unwrap().place_rms_m < 1e-3);
}

#[test]
fn thrusters_that_cannot_be_are_refused() {
    for (text, key, allowed) in [
        ("robot.thrusters[0].max_n=0.0", "robot.thrusters[0].max_n", "above 0"),
        (
            "robot.thrusters[1].name=thruster_1",
            "robot.thrusters[1].name",
            "a name of its own: thrusters[0].name is the same",
        ),
        ("robot.thrusters[0].direction=[0.0, 0.0, 0.0]", "robot.thrusters[0].direction", "a direction"),
        ("robot.thrusters=[]", "controller.hover", "six or more"),
        ("controller.hover.period_s=0.0", "controller.hover.period_s", "whole number"),
    ] {
        let message =
            Scenario::new(document(&[text])).err().unwrap_or_else(|| panic!("{text} is taken")).to_string();
        assert!(message.contains(key) && message.contains(allowed), "{text}: {message}");
    }
}
