//! What a user sees when a scenario is wrong: one message with file, line, key, value and what is allowed.

use std::fs;
use std::path::PathBuf;

use serde::Deserialize;
use wingbeat::Error;
use wingbeat::scenario::{ConfigError, Document, ValuePlace};

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Scenario {
    name: String,
    robot: Robot,
    simulation: Simulation,
    gait: Option<Gait>,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Robot {
    mass_kg: f64,
    #[serde(default)]
    elements: Vec<Element>,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Element {
    limit_rad: f64,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Simulation {
    step_s: f64,
    nodes: usize,
    law: Law,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
enum Law {
    Linear,
    Stall,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
enum Gait {
    Fourier(Fourier),
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Fourier {
    frequency_hz: f64,
}

const SCENARIO: &str = "\
name = \"turn\"
robot = \"../robots/bat.toml\"

[simulation]
step_s = 1e-4
nodes = 12
law = \"linear\"
";
const ROBOT: &str = "mass_kg = 0.02\n\n[[elements]]\nlimit_rad = 0.3\n[[elements]]\nlimit_rad = 0.5\n";

/// A folder of one test, with a scenario and its robot.
struct Files {
    folder: PathBuf,
}

impl Files {
    fn new(test: &str, scenario: &str, robot: &str) -> Self {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(test);
        for (path, text) in [("scenarios/turn.toml", scenario), ("robots/bat.toml", robot)] {
            let path = folder.join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        Self { folder }
    }

    fn load(&self, overrides: &[&str]) -> Result<Document, ConfigError> {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
        Document::load(&self.folder.join("scenarios/turn.toml"), &overrides, &["robot"])
    }

    /// The message about a scenario that does not parse, with paths as seen from the folder.
    fn complaint(&self, overrides: &[&str]) -> String {
        let error = self.load(overrides).and_then(|document| document.parse::<Scenario>()).unwrap_err();
        self.relative(&error)
    }

    fn relative(&self, error: &ConfigError) -> String {
        error.to_string().replace(&format!("{}/", self.folder.display()), "")
    }
}

fn complaint(test: &str, scenario: &str) -> String {
    Files::new(test, scenario, ROBOT).complaint(&[])
}

#[test]
fn a_scenario_and_its_robot_become_one_table() {
    let files = Files::new("good", SCENARIO, ROBOT);
    let document = files.load(&[]).unwrap();
    let scenario: Scenario = document.parse().unwrap();
    assert_eq!(scenario.robot.mass_kg, 0.02);
    assert_eq!(scenario.robot.elements.len(), 2);
    assert_eq!(document.files().count(), 2);
}

#[test]
fn overrides_reach_every_key_and_may_name_another_robot() {
    let files = Files::new("overrides", SCENARIO, ROBOT);
    let document = files
        .load(&["robot.elements[1].limit_rad=0.7", "simulation.law=stall", "gait.fourier.frequency_hz=3.5"])
        .unwrap();
    let scenario: Scenario = document.parse().unwrap();
    assert_eq!(scenario.robot.elements[1].limit_rad, 0.7);
    assert_eq!(scenario.simulation.law, Law::Stall);
    assert_eq!(scenario.gait, Some(Gait::Fourier(Fourier { frequency_hz: 3.5 })));

    let other = files.folder.join("robots/other.toml");
    fs::write(&other, "mass_kg = 0.045").unwrap();
    let document = files.load(&[&format!("robot={}", other.display()), "robot.mass_kg=0.05"]).unwrap();
    assert_eq!(document.parse::<Scenario>().unwrap().robot, Robot { mass_kg: 0.05, elements: vec![] });
}

#[test]
fn the_resolved_text_gives_the_same_scenario() {
    let files = Files::new("resolved", SCENARIO, ROBOT);
    let document = files.load(&["simulation.nodes=20"]).unwrap();
    let again = Files::new("resolved_again", &document.resolved().unwrap(), "");
    assert_eq!(again.load(&[]).unwrap().parse::<Scenario>().unwrap(), document.parse::<Scenario>().unwrap());
}

#[test]
fn unknown_key() {
    let text = SCENARIO.replace("nodes = 12", "nodes = 12\nsteps_s = 0.1");
    assert_eq!(
        complaint("unknown", &text),
        "scenarios/turn.toml:7: unknown key simulation.steps_s = 0.1: \
         did you mean step_s? allowed is step_s, nodes, law"
    );
}

#[test]
fn unknown_key_of_a_robot_names_the_robot_file() {
    let files =
        Files::new("unknown_robot", SCENARIO, "mass_kg = 1\n\n[[elements]]\nlimit_rad = 0.3\nwidth = 2\n");
    assert_eq!(
        files.complaint(&[]),
        "robots/bat.toml:5: unknown key robot.elements[0].width = 2: allowed is limit_rad"
    );
}

#[test]
fn unknown_key_of_an_override() {
    let files = Files::new("unknown_set", SCENARIO, ROBOT);
    assert_eq!(
        files.complaint(&["simulation.step=0.1"]),
        "--set simulation.step=0.1: unknown key simulation.step = 0.1: \
         did you mean step_s? allowed is step_s, nodes, law"
    );
}

#[test]
fn unknown_table() {
    assert_eq!(
        complaint("unknown_table", &format!("{SCENARIO}[wind]\nspeed_m_s = 1\n")),
        "scenarios/turn.toml:8: unknown key wind: allowed is name, robot, simulation, gait"
    );
}

#[test]
fn missing_key() {
    assert_eq!(
        complaint("missing", &SCENARIO.replace("nodes = 12\n", "")),
        "scenarios/turn.toml:4: simulation.nodes is missing: it must be given"
    );
    assert_eq!(
        complaint("missing_root", &SCENARIO.replace("name = \"turn\"\n", "")),
        "scenarios/turn.toml:1: name is missing: it must be given"
    );
    let files = Files::new("missing_robot", SCENARIO, "\n[[elements]]\nlimit_rad = 0.3\n");
    assert_eq!(files.complaint(&[]), "robots/bat.toml:1: robot.mass_kg is missing: it must be given");
}

#[test]
fn everything_that_is_wrong_is_told_at_once() {
    let text = SCENARIO.replace("step_s = 1e-4\nnodes = 12\n", "node = 12\n").replace("linear", "liner");
    let files = Files::new("all", &text, "masskg = 1\n\n[[elements]]\n[[elements]]\nlimit_rad = []\n");
    let expected = [
        "scenarios/turn.toml:6: simulation.law = \"liner\": did you mean linear? allowed is linear, stall",
        "scenarios/turn.toml:4: simulation.nodes is missing: it must be given",
        "scenarios/turn.toml:4: simulation.step_s is missing: it must be given",
        "scenarios/turn.toml:5: unknown key simulation.node = 12: did you mean nodes? allowed is step_s, nodes, law",
        "robots/bat.toml:1: robot.mass_kg is missing: it must be given",
        "robots/bat.toml:1: unknown key robot.masskg = 1: did you mean mass_kg? allowed is mass_kg, elements",
        "robots/bat.toml:3: robot.elements[0].limit_rad is missing: it must be given",
        "robots/bat.toml:5: robot.elements[1].limit_rad = []: allowed is a number",
    ];
    let message = files.complaint(&[]);
    let mut told: Vec<&str> = message.lines().collect();
    let mut expected = expected.to_vec();
    told.sort_unstable();
    expected.sort_unstable();
    assert_eq!(told, expected);
}

#[test]
fn lists_of_another_length_are_refused() {
    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Place {
        #[serde(rename = "at_m")]
        _at_m: [f64; 3],
    }
    for (list, length) in [("[1, 2]", 2), ("[1, 2, 3, 4]", 4), ("[]", 0)] {
        let document = Document::text("place", &format!("at_m = {list}")).unwrap();
        let message = document.parse::<Place>().unwrap_err().to_string();
        assert_eq!(
            message,
            format!("place:1: at_m = {list}: allowed is a list of length 3"),
            "{length} given"
        );
    }
}

#[test]
fn documents_come_from_text_value_and_parts() {
    let robot = toml::Table::from_iter([("mass_kg".to_owned(), toml::Value::from(0.02))]);
    let scenario = SCENARIO.replace("robot = \"../robots/bat.toml\"\n", "");
    let document = Document::text("turn", &scenario).unwrap();
    let document = document.put("robot", Document::value("bat", &robot).unwrap()).unwrap();
    assert_eq!(document.parse::<Scenario>().unwrap().robot.mass_kg, 0.02);
    assert_eq!(document.files().count(), 0);
    let refused = document.explain(&Error::invalid("robot.mass_kg", 0.02, "more"));
    assert_eq!(refused.to_string(), "bat: robot.mass_kg = 0.02: allowed is more");
    let clash =
        Error::invalid("simulation.step_s", 1e-4, "less").against(["robot.mass_kg", "simulation.wind"]);
    assert_eq!(
        document.explain(&clash).to_string(),
        "turn:4: simulation.step_s = 1e-4: allowed is less; robot.mass_kg = 0.02 (bat)"
    );
    let part = document.part("simulation").unwrap().set("nodes=0x10");
    assert_eq!(part.parse::<Simulation>().unwrap().nodes, 16);
    let message = part.set("law=flat").parse::<Simulation>().unwrap_err().to_string();
    assert_eq!(message, "--set law=flat: law = flat: allowed is linear, stall");
    let message = document.part("name").unwrap_err().to_string();
    assert!(
        message.starts_with("turn:1: name = \"turn\": allowed is a file that can be read; turn: "),
        "{message}"
    );
}

#[test]
fn wrong_type() {
    assert_eq!(
        complaint("type", &SCENARIO.replace("1e-4", "\"fast\"")),
        "scenarios/turn.toml:5: simulation.step_s = \"fast\": allowed is a number"
    );
    assert_eq!(
        complaint("negative", &SCENARIO.replace("= 12", "= -1")),
        "scenarios/turn.toml:6: simulation.nodes = -1: allowed is a whole number, not negative"
    );
    let text = SCENARIO.split("\n[simulation]").next().unwrap().to_owned() + "simulation = 3\n";
    assert_eq!(complaint("table", &text), "scenarios/turn.toml:3: simulation = 3: allowed is a table");
}

#[test]
fn unknown_name() {
    assert_eq!(
        complaint("variant", &SCENARIO.replace("linear", "liner")),
        "scenarios/turn.toml:7: simulation.law = \"liner\": did you mean linear? allowed is linear, stall"
    );
}

#[test]
fn numbers_are_finite() {
    let finite = |largest: &str| format!("a finite number, {largest} or less in magnitude");
    for bad in ["nan", "-inf", "1e400", "2e12"] {
        let allowed = if bad == "nan" { "a finite number".to_owned() } else { finite("1e7") };
        assert_eq!(
            complaint("nan", &SCENARIO.replace("1e-4", bad)),
            format!("scenarios/turn.toml:5: simulation.step_s = {bad}: allowed is {allowed}")
        );
    }
    let files = Files::new("nan_set", SCENARIO, ROBOT);
    assert_eq!(
        files.complaint(&["robot.mass_kg=nan"]),
        "--set robot.mass_kg=nan: robot.mass_kg = nan: allowed is a finite number"
    );
}

#[test]
fn what_a_builder_refuses_is_found_in_its_file() {
    let files = Files::new("builder", SCENARIO, "mass_kg = -0.02\n\n[[elements]]\nlimit_rad = 30.0e-2\n");
    let document = files.load(&["simulation.nodes=2"]).unwrap();
    let explained = |error: Error| files.relative(&document.explain(&error));
    assert_eq!(
        explained(Error::invalid("robot.mass_kg", -0.02, "a positive mass")),
        "robots/bat.toml:1: robot.mass_kg = -0.02: allowed is a positive mass"
    );
    assert_eq!(
        explained(Error::invalid("robot.elements[0].limit_rad", 0.3, "at most 0.2")),
        "robots/bat.toml:4: robot.elements[0].limit_rad = 30.0e-2: allowed is at most 0.2"
    );
    assert_eq!(
        explained(Error::invalid("simulation.nodes", 2, "3 or more")),
        "--set simulation.nodes=2: simulation.nodes = 2: allowed is 3 or more"
    );
    assert_eq!(
        explained(Error::invalid("simulation.wind", 2, "less")),
        "scenarios/turn.toml:4: simulation.wind = 2: allowed is less"
    );
}

#[test]
fn files_that_are_not_there_or_not_toml() {
    let text = SCENARIO.replace("bat.toml", "cat.toml");
    let message = complaint("absent_robot", &text);
    assert!(
        message.starts_with("scenarios/turn.toml:2: robot = \"../robots/cat.toml\": allowed is a file"),
        "{message}"
    );
    assert!(message.contains("robots/cat.toml: No such file"), "{message}");

    let files = Files::new("not_toml", "name = \"x\"\n[simulation\n", ROBOT);
    let message = files.complaint(&[]);
    assert!(message.starts_with("scenarios/turn.toml:2: not TOML: "), "{message}");
    let files = Files::new("robot_not_toml", SCENARIO, "mass_kg = 1\nmass_kg = 2\n");
    let message = files.complaint(&[]);
    assert!(message.starts_with("robots/bat.toml:2: not TOML: duplicate key"), "{message}");

    let error = Document::load(&files.folder.join("none.toml"), &[], &[]).unwrap_err();
    assert!(matches!(error.all()[0].place, ValuePlace::File(_)));
}

#[test]
fn overrides_that_name_no_place() {
    let files = Files::new("bad_set", SCENARIO, ROBOT);
    assert_eq!(files.complaint(&["simulation.nodes"]), "--set simulation.nodes: allowed is KEY=VALUE");
    let inside = files.complaint(&["name.x=1"]);
    assert_eq!(inside, "--set name.x=1: name.x: allowed is a key of a table; x would be inside a string");
    let index = files.complaint(&["robot.elements[2].limit_rad=1"]);
    assert!(index.contains("allowed is an index from 0 to 1"), "{index}");
    assert!(index.ends_with(" in place of 2"), "{index}");
}

#[test]
fn an_override_reaches_an_item_of_a_list_by_its_name() {
    let robot = "mass_kg = 0.02\n\n[[elements]]\nname = \"left\"\nlimit_rad = 0.3\n[[elements]]\nname = \"right\"\nlimit_rad = 0.5\n";
    let files = Files::new("by_name", SCENARIO, robot);
    let load =
        |set: &str| Document::load(&files.folder.join("scenarios/turn.toml"), &[set.to_owned()], &["robot"]);
    let parsed = |set: &str| -> toml::Table { load(set).unwrap().parse().unwrap() };
    assert_eq!(parsed("robot.elements.right.limit_rad=0.7"), parsed("robot.elements[1].limit_rad=0.7"));
    let told = load("robot.elements.rihgt.limit_rad=0.7").unwrap_err().to_string();
    let end = "robot.elements.rihgt.limit_rad: allowed is an index from 0 to 1 or a name of left, right in place of rihgt";
    assert!(told.ends_with(end), "{told}");
}

/// A flight along a figure of eight.
fn along_path(overrides: &[&str]) -> Result<wingbeat::scenario::Scenario, ConfigError> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/path_figure8.toml");
    let document = Document::file(&path)?;
    wingbeat::scenario::Scenario::new(overrides.iter().fold(document, |document, text| document.set(*text)))
}

/// Of several tables of which a document has one, an override takes the place of that of a file, by a path into it as by the whole.
#[test]
fn an_override_takes_the_place_of_another_alternative() {
    let curve = |overrides: &[&str]| {
        let flown = along_path(overrides).unwrap_or_else(|error| panic!("{error}"));
        Document::value("path", flown.spec.path.as_ref().unwrap()).unwrap().resolved().unwrap()
    };
    let line = curve(&["path.curve={line={length_m=12.0}}"]);
    assert!(line.contains("length_m = 12") && !line.contains("figure_eight"), "{line}");
    assert_eq!(curve(&["path.curve.line.length_m=12.0"]), line);
    assert_eq!(curve(&["path.curve.line={length_m=12.0}"]), line);
    // A key of the one that stands there changes that alone.
    assert!(curve(&["path.curve.figure_eight.radius_m=5.0"]).contains("radius_m = 5"));
    let both = along_path(&["path.curve.line.length_m=12.0", "path.curve.helix.radius_m=5.0"])
        .unwrap_err()
        .to_string();
    let whole =
        along_path(&["path.curve={line={length_m=12.0}, helix={radius_m=5.0}}"]).unwrap_err().to_string();
    for refused in [both, whole] {
        assert!(refused.contains("path.curve = "), "{refused}");
        assert!(
            refused.contains("allowed is one of line, lane_change, helix, figure_eight, points, alone"),
            "{refused}"
        );
    }
    // Tables that stand beside one another stay.
    let sensors =
        Document::text("s", "[sensors.imu]\nevery_s = 0.01").unwrap().set("sensors.height.every_s=0.1");
    assert!(sensors.resolved().unwrap().contains("[sensors.imu]"));
}
