//! Flights in the lattice: motion and air found together.

use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::judge::Status;
use wingbeat::math::GRAVITY;
use wingbeat::plant::Fault;
use wingbeat::robot::BeyondLoads;
use wingbeat::scenario::{Document, LatticeTask, Run, Scenario};
use wingbeat::simulate::Flow;
use wingbeat_lattice::{CoupledLattice, doors};

const DENSITY: f64 = 1.225;
/// Sides of the plate, m.
const CHORD: f64 = 0.1;
const SPAN: f64 = 0.4;

pub(super) fn open(document: Document) -> Scenario {
    Scenario::open(document, &doors()).unwrap_or_else(|error| panic!("{error}"))
}

pub(super) fn fly(scenario: &Scenario) -> Run {
    let run = scenario.fly(|_| ControlFlow::Continue(())).unwrap_or_else(|error| panic!("{error}"));
    let status = run.summary.status;
    assert!(run.summary.completed(), "{status}: {:?}", run.summary.reason);
    run
}

pub(super) fn shipped(name: &str, set: &[&str]) -> Document {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(name);
    set.iter().fold(Document::file(&path).unwrap(), |document, set| document.set(*set))
}

/// A plate of `mass` kg that hardly turns, let go level in still air; its lattice has `chordwise` panels and steps of `step` s.
fn plate(mass: f64, chordwise: usize, step: f64, set: &[&str]) -> Document {
    with_robot(mass, chordwise, step, "", set)
}

/// The same with `more` in the robot's file.
fn with_robot(mass: f64, chordwise: usize, step: f64, more: &str, set: &[&str]) -> Document {
    let [half, edge] = [0.5 * SPAN, 0.5 * CHORD];
    let robot = format!(
        "name = \"plate\"\n[body]\nmass_kg = {mass}\ninertia_kg_m2 = [1.0, 1.0, 1.0]\n[[surfaces]]\nname = \"wing\"\ncd0 = 0.0\n\
         cd90 = 0.0\npanels = [{{ link = \"body\" }}]\nplanform = [{{ arc_m = 0.0, leading_edge_m = {edge}, trailing_edge_m = -{edge} }}, \
         {{ arc_m = {half}, leading_edge_m = {edge}, trailing_edge_m = -{edge} }}]\n{more}"
    );
    let flight = format!(
        "name = \"plate\"\n[air]\ndensity_kg_m3 = {DENSITY}\n[aero]\npreset = \"full\"\nlaw = \"linear\"\n[lattice]\nstep_s = {step}\n\
         chordwise = {chordwise}\nspanwise = 24\n[flight]\nduration_s = {}\nstep_s = {}\nrecord_every_s = {step}\n",
        10.0 * step,
        0.1 * step,
    );
    let robot = Document::text("plate.toml", &robot).unwrap();
    let document = Document::text("flight.toml", &flight).unwrap().put("robot", robot).unwrap();
    set.iter().fold(document, |document, set| document.set(*set))
}

/// Mass of the air that a plate of these sides carries broadside: .872 of the cylinder on its chord (DNV-RP-C205, table A-2, sides
/// 4 to 1).
fn carried() -> f64 {
    0.872 * DENSITY * std::f64::consts::PI * 0.25 * CHORD * CHORD * SPAN
}

/// Downward acceleration in the first moments of a fall, over gravity.
fn falls(document: Document) -> f64 {
    let run = fly(&open(document));
    let (t, v) = (run.record.values("t").unwrap(), run.record.values("v_WB_W_z").unwrap());
    -v[2] / (t[2] * GRAVITY)
}

#[test]
fn a_light_plate_falls_as_the_air_that_it_carries_lets_it() {
    // An eighth of the mass of that air.
    let mass = 0.125 * carried();
    // The wake has hardly left the edge, whatever its cores.
    for core in ["lattice.core_chords=1e-4", "lattice.core_chords=0.02"] {
        let found = mass * (1.0 / falls(plate(mass, 8, 1e-4, &[core])) - 1.0);
        assert!((found / carried() - 1.0).abs() < 0.01, "{core}: {found} {}", carried());
    }
}

#[test]
fn what_the_models_own_added_mass_says_changes_nothing() {
    let mass = 0.3 * carried();
    let with = falls(plate(mass, 4, 1e-3, &[]));
    for set in ["aero.added_mass=false", "aero.preset=paper"] {
        let other = falls(plate(mass, 4, 1e-3, &[set]));
        assert!((other / with - 1.0).abs() < 2e-3, "{set}: {other} {with}");
    }
}

#[test]
fn weak_coupling_diverges_where_strong_coupling_holds() {
    let mass = 0.125 * carried();
    let step = 1e-3;
    let scenario = open(plate(mass, 4, step, &["aero.added_mass=false"]));
    let strong = fly(&scenario);
    let speed = strong.record.values("v_WB_W_z").unwrap().last().copied().unwrap();
    assert!(speed < 0.0 && speed > -GRAVITY * 10.0 * step, "{speed}");
    let lattice = strong.summary.lattice.unwrap();
    assert!(lattice.steps == 10 && lattice.iterations_most < 20, "{lattice:?}");
    // The same steps with the load of the lattice a step ago.
    let (robot, spec) = (scenario.robot(), scenario.spec.lattice.as_ref().unwrap());
    let outlines = scenario.spec.robot.outlines().unwrap();
    let task = LatticeTask { spec, robot, outlines, density_kg_m3: DENSITY, every: 1, steps: 10 };
    let mut air = CoupledLattice::new(&task).unwrap();
    let (mut x, u) = (scenario.start(), []);
    let fastest = (0..10).try_fold(0.0_f64, |most, k| {
        let t = f64::from(k) * step;
        let loads = air.loads(t, &robot.stance(t, &x))?;
        air.keep();
        let own = robot.attached_loads(t, &x, &u, &BeyondLoads::NONE)?;
        let held = loads.with(&own, |load, own| load - own);
        let mut dx = vec![0.0; x.len()];
        for _ in 0..10 {
            robot.rates_beyond(t, &x, &u, &held, &mut dx)?;
            x.iter_mut().zip(&dx).for_each(|(x, dx)| *x += 0.1 * step * dx);
        }
        Ok::<f64, Fault>(most.max(x[robot.layout().velocity + 2].abs()))
    });
    assert!(fastest.is_err() || fastest.unwrap() > 100.0 * speed.abs(), "{fastest:?} {speed}");
}

#[test]
fn a_glider_glides_as_by_strips_and_its_forces_sum_to_nothing() {
    let set = ["flight.duration_s=1.0"];
    let strips = fly(&open(shipped("glider.toml", &set)));
    let lattice = fly(&open(shipped("glider.toml", &set).set("lattice.step_s=0.004")));
    let end = |run: &Run, name: &str| run.record.values(name).unwrap().last().copied().unwrap();
    for (name, within) in [("p_WB_x", 0.1), ("p_WB_z", 0.1), ("pitch", 0.02)] {
        let (a, b) = (end(&strips, name), end(&lattice, name));
        assert!((a - b).abs() < within, "{name}: {a} {b}");
    }
    let weight = open(shipped("glider.toml", &set)).robot().mass() * GRAVITY;
    let sources =
        ["circulatory", "induced_drag", "added_mass", "profile_drag", "body_drag", "gravity", "inertia"];
    for axis in ["x", "y", "z"] {
        let columns = sources.map(|source| lattice.record.values(&format!("force_{source}_{axis}")).unwrap());
        let rows = columns[0].len();
        let worst = (0..rows).map(|i| columns.iter().map(|c| c[i]).sum::<f64>().abs()).fold(0.0, f64::max);
        assert!(worst < 1e-5 * weight, "{axis}: {worst}");
    }
    assert!(lattice.record.values("force_added_mass_z").unwrap().iter().all(|force| *force == 0.0));
}

#[test]
fn a_flapping_flight_under_its_controller_goes_on_in_the_lattice() {
    let set = ["flight.duration_s=0.1", "lattice.step_s=0.005", "aero.preset=full"];
    let scenario = open(shipped("banking_turn.toml", &set));
    let run = fly(&scenario);
    let lattice = run.summary.lattice.unwrap();
    assert_eq!(lattice.steps, 20);
    assert_eq!(run.record.values("t").map(<[f64]>::len), Some(101));
    assert!(run.summary.controller.updates > 0 && run.summary.controller.failures == 0);
}

#[test]
fn odd_flights_are_finite_or_end_with_their_reason() {
    let mass = 0.5 * carried();
    let odd: [&[&str]; 5] = [
        &["lattice.chordwise=1", "lattice.spanwise=2"],
        &["lattice.free_wake=true"],
        &["lattice.longest_age_s=0.002"],
        &["air.gust_m_s=2.0", "air.wind_m_s=[-3.0, 0.0, 0.0]"],
        // Its own wake is blown through the plate from behind.
        &["air.wind_m_s=[3.0, 0.0, 0.1]", "lattice.free_wake=true"],
    ];
    for set in odd {
        let run = fly(&open(plate(mass, 4, 1e-3, set)));
        assert_eq!(run.summary.lattice.map(|lattice| lattice.steps), Some(10), "{set:?}");
    }
    // A second plate in the place of the first: their circulations are not determined.
    let text = "\n[[surfaces]]\nname = \"twin\"\ncd0 = 0.0\npanels = [{ link = \"body\" }]\nplanform = [{ arc_m = 0.0, leading_edge_m = 0.05, \
                trailing_edge_m = -0.05 }, { arc_m = 0.2, leading_edge_m = 0.05, trailing_edge_m = -0.05 }]\n";
    let twins = with_robot(mass, 4, 1e-3, text, &["aero.added_mass=false"]);
    let run = open(twins).fly(|_| ControlFlow::Continue(())).unwrap();
    assert_eq!(run.summary.status, Status::Failed);
    let reason = run.summary.reason.unwrap();
    assert!(reason.contains("surfaces touch or cross"), "{reason}");
}

/// With its shoulders raised the wings swing through each other from .02 s on, where vortices without cores meet.
#[test]
fn wings_that_pass_through_each_other_fly_on_with_rounded_vortices() {
    let raised = "robot.links[0].driven.mean_rad=0.65";
    let set = ["lattice.step_s=0.002", "flight.duration_s=0.12", raised];
    let sharp = open(shipped("passive_20g.toml", &set)).fly(|_| ControlFlow::Continue(())).unwrap();
    assert_eq!(sharp.summary.status, Status::Failed);
    assert!(sharp.summary.reason.unwrap().contains("lattice.crossing"));
    let run = fly(&open(shipped("passive_20g.toml", &set).set("lattice.crossing=true")));
    assert!(run.summary.least_clearance_m.unwrap() < -0.002, "{:?}", run.summary.least_clearance_m);
    assert_eq!(run.summary.lattice.map(|lattice| lattice.steps), Some(60));
}

#[test]
fn what_a_lattice_cannot_do_is_refused() {
    let refused = |name: &str, set: &[&str]| {
        Scenario::open(shipped(name, set), &doors()).map(drop).unwrap_err().to_string()
    };
    let says = |message: String, words: &[&str]| {
        assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
    };
    says(
        refused("glider.toml", &["lattice.step_s=0.0005"]),
        &["lattice.step_s", "whole number of steps of 0.001 s"],
    );
    says(refused("glider.toml", &["lattice.step_s=40.0"]), &["lattice.step_s", "at most the flight's 20 s"]);
    says(refused("banking_turn.toml", &["lattice.step_s=0.003"]), &["lattice.step_s", "controller's period"]);
    let none = ["lattice.step_s=0.001", "lattice.chordwise=0"];
    says(refused("glider.toml", &none), &["lattice.chordwise", "1 to 64"]);
    says(refused("estimator_20g.toml", &["lattice.step_s=0.0025"]), &["no instruments beside a lattice"]);
    let strips = ["lattice.step_s=0.001", "flight.record_strips_every_s=0.01"];
    says(refused("glider.toml", &strips), &["record_strips_every_s", "strips are the model's"]);
    let fails = |scenario: &Scenario| scenario.fly(|_| ControlFlow::Continue(())).unwrap_err().to_string();
    let shut = Scenario::new(shipped("glider.toml", &["lattice.step_s=0.001"])).unwrap();
    says(fails(&shut), &["lattice", "wingbeat_lattice::doors()"]);
    let cambered = open(shipped("glider.toml", &["lattice.step_s=0.001", "aero.zero_lift_angle_deg=-2.0"]));
    says(fails(&cambered), &["zero_lift_angle_deg", "the panels are flat"]);
    let coarse = open(shipped("banking_turn.toml", &["lattice.step_s=0.005", "lattice.spanwise=1"]));
    says(fails(&coarse), &["lattice.spanwise = 1"]);
    let long = open(shipped("glider.toml", &["lattice.step_s=0.001"]));
    says(fails(&long), &["rings of the wake", "lattice.longest_age_s"]);
    for end in ["from_arc_m=0.05", "to_arc_m=0.2"] {
        let short = format!("robot.surfaces[0].flap.{end}");
        says(
            fails(&open(shipped("flap_glide.toml", &["lattice.step_s=0.001", &short]))),
            &["lattice = given", "a flap that ends before the tip"],
        );
    }
    let trim = open(shipped("cruise_20g.toml", &["lattice.step_s=0.001"]));
    says(
        trim.trim(&mut |_| ControlFlow::Continue(())).unwrap_err().to_string(),
        &["lattice", "no derivatives"],
    );
    let plan = open(shipped("roll_in.toml", &["lattice.step_s=0.001"]));
    says(
        plan.plan(&mut |_| ControlFlow::Continue(())).unwrap_err().to_string(),
        &["lattice", "no derivatives"],
    );
}

/// A glider near the ground sinks less in the lattice too.
#[test]
fn the_lattice_of_a_flight_feels_the_ground() {
    let set = ["lattice={ step_s = 0.01, chordwise = 2, spanwise = 8 }", "flight.duration_s=0.2"];
    let sinks = |keys: &[&str]| {
        let document = keys.iter().fold(shipped("glider.toml", &set), |document, key| document.set(*key));
        fly(&open(document)).summary.altitude_change_m
    };
    let [free, low, far] = [sinks(&[]), sinks(&["air.ground_m=-0.3"]), sinks(&["air.ground_m=-1e4"])];
    assert!(low > free + 1e-4 && (far - free).abs() < 1e-8, "{free} {low} {far}");
}
