//! Each example runs, and what a scenario chooses by name is refused as what ships is.

#[path = "../../examples/own_controller.rs"]
mod own_controller;
#[path = "../../examples/own_manoeuvre.rs"]
mod own_manoeuvre;
#[path = "../../examples/own_plant.rs"]
mod own_plant;
#[path = "../../examples/own_solver.rs"]
mod own_solver;

use wingbeat::Error;
use wingbeat::guide::{AttitudeTracking, RobotSolver, SolverSpec};
use wingbeat::ocp::realtime::Settings;
use wingbeat::plant::LocalChart;
use wingbeat::robot::Robot;
use wingbeat::scenario::{Document, Doors, Scenario};

#[test]
fn a_manoeuvre_of_ones_own_is_chosen_from_toml() {
    own_manoeuvre::main().unwrap();
}

#[test]
fn a_controller_of_ones_own_is_chosen_from_toml() {
    own_controller::main().unwrap();
}

#[test]
fn a_horizon_solver_of_ones_own_is_chosen_from_toml() {
    own_solver::main().unwrap();
}

#[test]
fn a_plant_of_ones_own_flies_under_the_predictive_controller() {
    own_plant::main().unwrap();
}

fn turn() -> Document {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/banking_turn.toml");
    Document::file(path.as_ref()).unwrap()
}

fn refusal(document: Document) -> String {
    Scenario::new(document).map(|_| ()).unwrap_err().to_string()
}

#[test]
fn a_name_that_no_kind_has_is_refused_with_what_there_is() {
    let weave = || Document::text("weave.toml", "[weave]\nroll_deg = 5.0").unwrap();
    let manoeuvre = refusal(turn().put("manoeuvre", weave()).unwrap());
    assert!(
        manoeuvre.contains("manoeuvre.weave") && manoeuvre.contains("turn_start_s, roll_deg"),
        "{manoeuvre}"
    );
    let controller = refusal(turn().put("controller", weave()).unwrap());
    assert!(controller.contains("controller.weave") && controller.contains("period_s"), "{controller}");
    let solver = refusal(turn().put("solver", weave()).unwrap());
    assert!(solver.contains("solver.weave") && solver.contains("no other kind"), "{solver}");
}

/// A horizon solver that refuses its settings.
#[derive(Debug, serde::Deserialize)]
struct Refusing {
    step: f64,
}

impl SolverSpec for Refusing {
    fn build<'a>(
        &self,
        _: &LocalChart<'a, Robot>,
        _: &AttitudeTracking<'a, Robot>,
        _: Settings,
    ) -> Result<RobotSolver<'a>, Error> {
        Err(Error::invalid("step", self.step, "another"))
    }
}

#[test]
fn what_a_solver_refuses_is_told_by_its_own_key_and_place() {
    let doors = Doors::shipped().solver::<Refusing>("mine");
    let table = Document::text("mine.toml", "[mine]\nstep = 7.0").unwrap();
    let document = turn().put("solver", table).unwrap();
    let refused = Scenario::open(document, &doors).map(|_| ()).unwrap_err().to_string();
    assert!(refused.starts_with("mine.toml:2: solver.mine.step = 7"), "{refused}");
    let table = Document::text("mine.toml", "[mine]\nstep = 7.0").unwrap();
    let document = turn().put("solver", table).unwrap().set("controller.prepared=true");
    let refused = Scenario::open(document, &doors).map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("controller.prepared = true") && refused.contains("solver"), "{refused}");
}

#[test]
fn unknown_and_missing_keys_of_what_ships_are_told_as_ever() {
    let unknown = refusal(turn().set("manoeuvre.rol_deg=3"));
    assert!(unknown.contains("manoeuvre.rol_deg") && unknown.contains("did you mean roll_deg?"), "{unknown}");
    let first = refusal(turn().set("manoeuvre.a=3"));
    assert!(first.contains("manoeuvre.a") && first.contains("turn_start_s"), "{first}");
    let missing =
        refusal(turn().put("controller", Document::text("c", "period_s = 0.005").unwrap()).unwrap());
    assert!(missing.contains("controller.intervals") && missing.contains("controller.weights"), "{missing}");
}

#[test]
fn a_choice_survives_writing_and_reading() {
    let weave = Document::text("weave.toml", "[weave]\nroll_deg = 5.0").unwrap();
    let document = turn().put("manoeuvre", weave).unwrap().merged(&["robot"], &|_, _| None).unwrap();
    let spec = document.scenario().unwrap();
    let again = Document::of_scenario("spec", &spec).unwrap().scenario().unwrap();
    assert_eq!(format!("{:?}", again.manoeuvre), format!("{:?}", spec.manoeuvre));
    assert!(spec.manoeuvre.is_some_and(|chosen| chosen.shipped().is_none()));
}
