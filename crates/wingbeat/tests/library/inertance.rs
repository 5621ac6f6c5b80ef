//! Stiff wings in steps that would not follow them.

use super::mechanism::{FLAPPER, Preset, moving, robot};
use std::ops::ControlFlow;
use wingbeat::math::Vec3;
use wingbeat::plant::Plant;
use wingbeat::robot::Robot;
use wingbeat::scenario::{Run, Scenario};
use wingbeat::simulate::{fastest_vibration, follow};

const STIFF: &str = "robot.surfaces[0].flap.stiffness_n_rad=100";

/// A flapper whose spring of stiffness k (N m/rad) has the damping c (N m s/rad), and whose wing has a flap as stiff.
fn stiff(k: f64, c: f64) -> Robot {
    let wing = "[[surfaces]]\nname = \"wing\"\n";
    let flap = format!(
        "flap = {{ chord_fraction = 0.3, stiffness_n_rad = {k:e}, areal_density_kg_m2 = 0.05, damping_s = {:e} }}\n",
        c / k
    );
    let text = FLAPPER.replace(wing, &format!("{wing}{flap}"));
    let spring = "stiffness = 4e-3, damping = 2e-5";
    assert!(text.contains(spring));
    robot(&text.replace(spring, &format!("stiffness = {k:e}, damping = {c:e}")), Preset::Full, 1e-9)
}

/// The same robot with an inertance, s.
fn slowed(robot: &Robot, time: f64) -> Robot {
    let mut robot = robot.clone();
    robot.set_inertance(time).unwrap();
    robot
}

/// Joints and flaps have inertances apart, though the parts move each other.
#[test]
fn no_vibration_is_faster_than_its_inertance_lets_it() {
    for time in [1e-4, 1e-3] {
        for (k, c) in [(1e-2, 0.0), (1e3, 0.0), (1e3, 1.0), (1e4, 1e5)] {
            let robot = stiff(k, c);
            let (free, held) =
                (fastest_vibration(&robot).unwrap(), fastest_vibration(&slowed(&robot, time)).unwrap());
            assert!(held < 1.01 / time && held <= free * 1.001, "{k} {c}: {free} {held}");
            let mut chosen = robot;
            follow(&mut chosen, time).unwrap();
            let chosen = chosen.inertance_s();
            assert_eq!(chosen, if free * time > 1.0 { time } else { 0.0 }, "{k} {c}: {free}");
        }
    }
}

/// It slows what is on springs, stays where other numbers change, and leaves nothing behind.
#[test]
fn an_inertance_stays_with_other_numbers_and_can_be_taken_back() {
    let robot = stiff(2.0, 1e-3);
    let carried = slowed(&robot, 1e-3);
    let x = moving(&robot);
    let rates = |robot: &Robot| {
        let mut dx = vec![0.0; x.len()];
        robot.rates_in_numbers(0.0, &x, &[], &mut dx).unwrap();
        dx
    };
    let (free, held) = (rates(&robot), rates(&carried));
    let feather = robot.states().iter().position(|c| c.name == "coordinate_rate_feather_left").unwrap();
    assert!(held[feather].abs() < 0.5 * free[feather].abs(), "{} {}", held[feather], free[feather]);
    let heavier = carried.adjusted(&[("body.mass_kg", 0.02)]).unwrap();
    assert_eq!(heavier.inertance_s(), 1e-3);
    assert_eq!(rates(&slowed(&carried, 0.0)), free);
}

/// A glider whose flap is a hundred times as stiff as that shipped: one flight in the step that is shipped and in half of it, none without an
/// inertance. One whose damper lets it creep for a tenth of a second creeps as in steps a tenth as long.
#[test]
fn stiff_wings_keep_the_step_of_soft_ones() {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/flap_glide.toml"));
    let glide = |set: &[&str]| {
        let all = ["flight.duration_s=0.5", "flight.record_every_s=0.01", STIFF];
        let sets: Vec<String> = all.iter().chain(set).map(|set| (*set).to_owned()).collect();
        Scenario::load(path, &sets).unwrap_or_else(|e| panic!("{e}"))
    };
    let fly = |scenario: &Scenario| scenario.fly(|_| ControlFlow::Continue(())).unwrap();
    let end = |scenario: &Scenario| {
        let run = fly(scenario);
        assert!(run.summary.completed(), "{:?}", run.summary.reason);
        let of = |name| *run.record.values(name).unwrap().last().unwrap();
        Vec3::new(of("p_WB_x"), of("p_WB_y"), of("p_WB_z"))
    };
    let (shipped, half) = (glide(&["flight.step_s=5e-4"]), glide(&["flight.step_s=2.5e-4"]));
    assert_eq!((shipped.robot().inertance_s(), half.robot().inertance_s()), (5e-4, 2.5e-4));
    let apart = (end(&shipped) - end(&half)).norm();
    assert!(apart < 5e-6, "{apart}");
    let damped = ["robot.surfaces[0].flap.stiffness_n_rad=1e4", "robot.surfaces[0].flap.damping_s=0.1"];
    let crept = |step: &str| end(&glide(&[damped[0], damped[1], step]));
    let apart = (crept("flight.step_s=1e-3") - crept("flight.step_s=1e-4")).norm();
    assert!(apart < 2e-3, "{apart}");
    let soft = glide(&["robot.surfaces[0].flap.stiffness_n_rad=1"]);
    assert_eq!(soft.robot().inertance_s(), 0.0);
    let none = fly(&glide(&["flight.inertance_s=0"]));
    assert!(!none.summary.completed());
    let warned =
        |run: &Run| run.summary.warnings.iter().any(|warning| warning.id == "flight.inertance_unheard");
    let rigid = path.with_file_name("glider.toml");
    let sets = ["flight.duration_s=0.01", "flight.inertance_s=1e-3"].map(str::to_owned);
    assert!(warned(&fly(&Scenario::load(&rigid, &sets).unwrap())) && !warned(&fly(&soft)));
}

/// What is shipped is followed as it is.
#[test]
fn shipped_structures_need_no_inertance() {
    let scenarios = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios"));
    for name in [
        "soft_20g",
        "soft_bank15",
        "flap_glide",
        "sail_glide",
        "passive_20g",
        "aerobat_elastic",
        "membrane_bank15",
    ] {
        let scenario = Scenario::load(&scenarios.join(name).with_extension("toml"), &[]);
        assert_eq!(scenario.unwrap().robot().inertance_s(), 0.0, "{name}");
    }
}

/// Joints whose motion is given have no inertance, and the others keep theirs.
#[test]
fn a_shape_that_is_given_leaves_the_inertance_of_the_other_joints() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/soft_20g.toml");
    let scenario = Scenario::load(path.as_ref(), &["flight.inertance_s=1e-3".into()]).unwrap();
    let given = scenario.robot().with_shape_given();
    assert_eq!(given.inertance_s(), 1e-3);
    let (x, mut dx) = (given.still(), vec![0.0; given.states().len()]);
    given.rates_in_numbers(0.0, &x, &vec![0.0; given.inputs().len()], &mut dx).unwrap();
    assert!(dx.iter().all(|rate| rate.is_finite()));
}
