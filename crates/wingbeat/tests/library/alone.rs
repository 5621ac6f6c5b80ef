//! Robots trimmed from their files alone.

use std::ops::ControlFlow;
use std::path::Path;

use wingbeat::judge::Status;
use wingbeat::scenario::{Document, RobotTrim, TrimProgress, Trimmed, TurnSummary};

fn robot(name: &str) -> Document {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../robots/any/{name}.toml"));
    Document::file(&path).unwrap_or_else(|e| panic!("{e}"))
}

fn trimmed(name: &str, iterations: Option<usize>, bank_deg: f64, overrides: &[&str]) -> Trimmed {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let mut trim = RobotTrim::new(robot(name), &overrides, bank_deg).unwrap_or_else(|e| panic!("{e}"));
    trim.iterations = iterations.unwrap_or(trim.iterations);
    trim.trim(&mut |_| ControlFlow::Continue(())).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_robot_alone_is_trimmed() {
    let trimmed = trimmed("elastic_16g", Some(0), 0.0, &[]);
    let summary = &trimmed.summary;
    assert_eq!(summary.status, Status::Ok, "{:?}", summary.reason);
    // The mean of samples at the steps of the cycle.
    assert!((summary.lift_over_weight.unwrap() - 1.0).abs() < 1e-6, "{:?}", summary.lift_over_weight);
    assert!(summary.residual.unwrap() < 1e-10);
    let alone = summary.alone.as_ref().unwrap();
    assert_eq!(alone.assumed_actuators, ["arm_stroke", "arm", "feather"]);
    assert!(alone.guessed_speed_m_s > 2.0 && !alone.changed.is_empty() && !alone.tried.is_empty());
    let files: Vec<&str> = trimmed.files.iter().map(|(name, _)| *name).collect();
    assert_eq!(files, ["orbit.toml", "gains.csv", "trim.toml", "robot.toml"]);
    // What is written is the scenario of this very orbit.
    let text = &trimmed.files.iter().find(|(name, _)| *name == "trim.toml").unwrap().1;
    let says = |key: &str| text.contains(&format!("{key} = true"));
    assert!(says("edge_suction") || says("turning_impulse"), "{text}");
    let again = wingbeat::scenario::Scenario::new(Document::text("again", text).unwrap()).unwrap();
    let again = again.trim(&mut |_| ControlFlow::Continue(())).unwrap().summary;
    assert!((again.power_w_kg.unwrap() / summary.power_w_kg.unwrap() - 1.0).abs() < 1e-9);
}

/// The gait found does not hang on 2 % of the mass, its orbit is that of the search, and it has left the 50 W/kg of the scan far behind.
#[test]
#[ignore = "long: cargo xtask long tests"]
fn a_robot_a_little_lighter_is_trimmed_alike() {
    let power = |mass: &str| {
        let overrides = ["aero.full.turning_impulse=true", &format!("robot.body.mass_kg={mass}")];
        let summary = trimmed("elastic_16g", None, 0.0, &overrides).summary;
        assert_eq!(summary.status, Status::Ok, "{:?}", summary.reason);
        summary.power_w_kg.unwrap()
    };
    let (own, lighter) = (power("0.013"), power("0.01274"));
    assert!(own < 35.0 && (lighter / own - 1.0).abs() < 0.05, "{own} {lighter}");
}

#[test]
fn what_cannot_be_trimmed_says_why() {
    let refused = |bank_deg: f64, set: &str| {
        let error = RobotTrim::new(robot("single_12g"), &[set.into()], bank_deg).err().unwrap();
        error.to_string()
    };
    assert!(refused(90.0, "air.density_kg_m3=1.2").contains("bank_deg"));
    assert!(refused(f64::NAN, "air.density_kg_m3=1.2").contains("bank_deg"));
    assert!(refused(0.0, "robot.body.mass_kg=-1.0").contains("robot.body.mass_kg"));
    assert!(refused(0.0, "robot.bodies=1").contains("unknown key"));
    assert!(refused(0.0, "air.wind_m_s=[1.0, 0.0, 0.0]").contains("still air"));
    // What it chooses itself is not overridden, and messages name its scenario.
    let own = refused(0.0, "trim.speed_m_s=3.0");
    assert!(own.contains("trim.speed_m_s = 3.0: allowed is none with a robot's file"), "{own}");
    let clash = refused(0.0, "aero.preset=as_printed");
    assert!(
        clash.contains("the scenario that `trim` puts around a robot") && clash.contains("aero.law"),
        "{clash}"
    );
    let stopped = RobotTrim::new(robot("single_12g"), &[], 0.0).unwrap();
    let stopped = stopped.trim(&mut |_| ControlFlow::Break(())).unwrap().summary;
    assert!(stopped.status == Status::Interrupted && stopped.reason.unwrap().contains("stopped"));
}

/// A search that gives nothing leaves the gait of the scan, and the summary says so.
#[test]
fn a_search_that_finds_no_gait_is_told() {
    let mut trim = RobotTrim::new(robot("elastic_16g"), &[], 0.0).unwrap();
    trim.iterations = 1;
    let trimmed = trim.trim(&mut |at| match at {
        TrimProgress::Search(_) => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    });
    let summary = trimmed.unwrap().summary;
    let alone = summary.alone.as_ref().unwrap();
    assert_eq!((alone.search_ended.as_deref(), alone.search_iterations), (Some("none found"), None));
    let told = summary.warnings.iter().find(|warning| warning.id == "trim.search_ended").unwrap();
    assert!(told.text.contains("that of the scan") && told.text.contains("stopped"), "{}", told.text);
}

/// One wing on the left: no number but the frequency can be chosen, and a level flight takes four.
#[test]
fn a_wing_on_one_side_is_refused_before_its_search() {
    let file = "name = \"one\"\n[body]\nmass_kg = 0.02\ninertia_kg_m2 = [1e-5, 2e-5, 3e-5]\n[[links]]\nname = \"arm\"\nside = \"single\"\n\
                mass_kg = 0.001\ninertia_kg_m2 = [1e-6, 1e-7, 1e-6]\naxis = [1.0, 0.0, 0.0]\n\
                driven = { mean_rad = 0.1, harmonics = [{ amplitude_rad = 0.6, phase_rad = 0.0 }] }\n[gait.fourier]\nfrequency_hz = 8.0\n\
                [[surfaces]]\nname = \"wing\"\nspan = \"left\"\npanels = [{ link = \"arm\" }]\nplanform = [\n\
                { arc_m = 0.0, leading_edge_m = 0.03, trailing_edge_m = -0.05 },\n\
                { arc_m = 0.2, leading_edge_m = 0.03, trailing_edge_m = -0.05 }]\n";
    let trim =
        RobotTrim::new(Document::text("one.toml", file).unwrap(), &[], 0.0).unwrap_or_else(|e| panic!("{e}"));
    let error = trim.trim(&mut |_| ControlFlow::Continue(())).err().unwrap().to_string();
    assert!(error.contains("robot.structure.elements") && error.contains("left and right"), "{error}");
    // So `new trim` asks before it writes.
    assert_eq!(trim.can_be_held().unwrap_err().to_string(), error);
}

/// A robot whose sides differ is given as many actuators as its level flight takes, where its own are fewer.
#[test]
fn a_robot_whose_sides_differ_gets_actuators_enough() {
    let one = "[{ name = \"tip\", moves = [\"wing_left\"], low = -0.3, high = 0.3 }, \
               { name = \"tip_other\", moves = [\"wing_right\"], low = -0.3, high = 0.3 }]";
    let overrides = |aside: &str| {
        let elements = format!("robot.structure={{ frequency_hz = 12.0, damping = 0.8, elements = {one} }}");
        [elements, format!("robot.body.com_m=[0.0, {aside}, -0.005]")]
    };
    let free = |aside: &str| {
        let trim =
            RobotTrim::new(robot("single_12g"), &overrides(aside), 0.0).unwrap_or_else(|e| panic!("{e}"));
        assert!(trim.can_be_held().is_ok(), "{:?}", trim.free());
        trim.free().to_vec()
    };
    assert!(free("0.0").iter().any(|name| name == "tip"), "{:?}", free("0.0"));
    assert_eq!(free("0.004"), ["frequency", "wing_stroke", "wing"]);
}

/// The robot that docs/robots.md shows.
fn shown() -> Document {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/robots.md");
    let page = std::fs::read_to_string(page).unwrap();
    let block = page.split("<!-- robot -->\n```toml\n").nth(1).unwrap().split("```").next().unwrap();
    Document::text("flapper.toml", block).unwrap()
}

/// Its wings beat at 4 Hz, and heave is damped within a third of that period: slopes of cycles that do not settle lead its gait to one that glides.
#[test]
fn a_robot_that_beats_slowly_is_balanced_at_the_first_speed() {
    let mut trim = RobotTrim::new(shown(), &[], 0.0).unwrap_or_else(|e| panic!("{e}"));
    trim.iterations = 0;
    let until_an_orbit = &mut |at: TrimProgress| match at {
        TrimProgress::Orbit { orbits: 0, .. } => ControlFlow::Continue(()),
        _ => ControlFlow::Break(()),
    };
    let summary = trim.trim(until_an_orbit).unwrap().summary;
    let tried = &summary.alone.as_ref().unwrap().tried[0];
    assert!(tried.power_w_kg.is_some_and(|power| power < 100.0), "{tried:?}");
    assert!((tried.speed_m_s / trim.scenario.guessed_speed().unwrap() - 1.0).abs() < 0.05, "{tried:?}");
}

/// What a speed lacks is told, and the best gait glides most of the way.
#[test]
#[ignore = "long: cargo xtask long tests"]
fn the_robot_that_is_shown_is_trimmed() {
    let trim = RobotTrim::new(shown(), &[], 0.0).unwrap_or_else(|e| panic!("{e}"));
    let summary = trim.trim(&mut |_| ControlFlow::Continue(())).unwrap().summary;
    assert_eq!(summary.status, Status::Ok, "{:?}", summary.reason);
    assert!(summary.power_w_kg.unwrap() < 12.0, "{:?}", summary.power_w_kg);
    assert!((summary.lift_over_weight.unwrap() - 1.0).abs() < 1e-6, "{:?}", summary.lift_over_weight);
    let tried = &summary.alone.as_ref().unwrap().tried;
    let lacks = tried.iter().filter_map(|tried| tried.reason.as_deref());
    assert!(lacks.clone().any(|why| why.contains("g ahead")), "{tried:?}");
}

/// Why a turn was not flown is told in words of what was asked, not of the controller that `trim` puts around it.
#[test]
fn a_turn_without_a_feedback_says_so() {
    let refused = |key: &str| {
        let error = wingbeat::math::Error::invalid(key, "given", "weights with which the feedback settles");
        TurnSummary::not_flown(&error, 8.671)
    };
    let told = refused("controller.orbit.weights");
    assert_eq!(told, "at 8.67 m/s no feedback by its actuators holds the flight into it");
    let told = refused("controller.orbit.legs[0]");
    assert_eq!(told, "at 8.67 m/s no periodic flight leads into it: given");
}

/// From the file's 8 Hz the search of this robot ends at 140 W/kg with no way on; from the frequency of scaling laws it finds less.
#[test]
#[ignore = "long: cargo xtask long tests"]
fn a_search_that_got_stuck_begins_again() {
    let summary = trimmed("single_12g", None, 0.0, &[]).summary;
    assert_eq!(summary.status, Status::Ok, "{:?}", summary.reason);
    assert!(summary.power_w_kg.unwrap() < 45.0, "{:?}", summary.power_w_kg);
}

/// What is told of a robot whose trim is stopped at once.
fn stopped(name: &str, overrides: &[String]) -> wingbeat::scenario::TrimSummary {
    let trim = RobotTrim::new(robot(name), overrides, 0.0).unwrap();
    trim.trim(&mut |_| ControlFlow::Break(())).unwrap().summary
}

#[test]
fn what_is_put_in_place_of_the_file_is_told() {
    let told = |name: &str, overrides: &[String]| -> Vec<String> {
        stopped(name, overrides).warnings.iter().map(|warning| warning.id.to_string()).collect()
    };
    assert!(!told("hand_30g", &[]).iter().any(|id| id == "trim.frequency_replaced"));
    let fast = told("hand_30g", &["robot.gait.fourier.frequency_hz=40.0".into()]);
    assert!(fast.iter().any(|id| id == "trim.frequency_replaced"), "{fast:?}");
    let motor = stopped("motor_19g", &[]);
    assert!(motor.warnings.iter().any(|warning| warning.id == "trim.motor_left_out"));
    let changed = motor.alone.unwrap().changed;
    let left_out =
        changed.iter().filter(|(key, value)| key.starts_with("robot.drive.motor.") && value[1].is_none());
    assert!(left_out.count() >= 3, "{changed:?}");
}

/// Whether left and right of a robot count as alike.
fn alike(robot: Document, overrides: &[String]) -> bool {
    let trim = RobotTrim::new(robot, overrides, 0.0).unwrap_or_else(|e| panic!("{e}"));
    trim.scenario.cycle().unwrap().section().alike()
}

#[test]
fn a_fin_is_no_asymmetry_and_springs_that_differ_are_one() {
    let glider = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/glider.toml");
    let glider = Document::file(&glider).unwrap();
    assert!(alike(glider.clone(), &[]));
    // The fin beside the plane of symmetry is.
    assert!(!alike(glider, &["robot.surfaces[2].panels[0].origin_m=[-0.5, 0.1, 0.0]".into()]));
    assert!(alike(robot("elastic_16g"), &[]) && !alike(robot("beside_35g"), &[]));
    // Two flaps about axes along the span, which a displacement of both turns alike, at rest in the wind.
    let flap = |side: &str, y: f64, stiffness: f64| {
        format!(
            "[[links]]\nname = \"{side}\"\norigin_m = [-0.05, {y:?}, 0.0]\naxis = [0.0, 1.0, 0.0]\nmass_kg = 1e-3\ncom_m = [-0.02, 0.0, \
             0.0]\ninertia_kg_m2 = [1e-6, 1e-6, 1e-6]\nelastic = {{ stiffness = {stiffness:?}, damping = 1e-5 }}\n"
        )
    };
    let body = "name = \"flaps\"\n[body]\nmass_kg = 0.05\ninertia_kg_m2 = [1e-4, 1e-4, 1e-4]\n[gait.fourier]\nfrequency_hz = 5.0\n";
    let wing = "[[surfaces]]\nname = \"wing\"\ncd0 = 0.02\nplanform = [{ arc_m = 0.0, leading_edge_m = 0.03, trailing_edge_m = -0.09 }, { \
                arc_m = 0.3, leading_edge_m = 0.03, trailing_edge_m = -0.09 }]\npanels = [{ link = \"body\" }]\n";
    let flaps = |right: f64| {
        let tail = "[[links]]\nname = \"tail\"\naxis = [0.0, 1.0, 0.0]\ndriven = { mean_rad = 0.0 }\n";
        let text = format!("{body}{tail}{}{}{wing}", flap("left", 0.1, 0.02), flap("right", -0.1, right));
        Document::text("flaps", &text).unwrap()
    };
    assert!(alike(flaps(0.02), &[]) && !alike(flaps(0.03), &[]));
}

/// Robots of `robots/any` from their files alone: status of level flight and of the turn, as docs/trim.md has them. Robots of which
/// the table has no turn are trimmed level alone.
const TABLE: [(&str, Status, Option<Status>); 10] = [
    ("single_12g", Status::Ok, Some(Status::NotFound)),
    ("hand_30g", Status::Ok, Some(Status::Ok)),
    ("elastic_16g", Status::Ok, Some(Status::Ok)),
    ("tandem_28g", Status::Ok, Some(Status::Ok)),
    ("three_links_60g", Status::Ok, Some(Status::NotFound)),
    ("beside_35g", Status::Ok, Some(Status::Ok)),
    ("moth_10g", Status::Ok, None),
    ("x_wing_22g", Status::Ok, Some(Status::Outside)),
    ("motor_19g", Status::Ok, Some(Status::Ok)),
    ("gull_180g", Status::Ok, Some(Status::OffTarget)),
];

#[test]
#[ignore = "long: cargo xtask long tests"]
fn robots_fly_level_and_turn_from_their_files() {
    let mut found = Vec::new();
    for (name, _, turn) in TABLE {
        let summary = trimmed(name, None, if turn.is_some() { 30.0 } else { 0.0 }, &[]).summary;
        let turned = summary.alone.as_ref().and_then(|alone| alone.turn.as_ref()).map(|turn| turn.status);
        println!("{name}: {:?}, {turned:?}: {:?}", summary.status, summary.reason);
        found.push((name, summary.status, turned, summary.lift_over_weight.is_some()));
    }
    // The status of the whole is that of the worse of the two.
    let told = |(name, level, turn): (&'static str, Status, Option<Status>)| {
        (name, turn.map_or(level, |turn| level.max(turn)), turn, level < Status::NotFound)
    };
    assert_eq!(found, TABLE.map(told));
}
