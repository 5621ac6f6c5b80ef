//! What a flight is held against: what its controller was asked, and what the models of its air were made for.

use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::judge::Status;
use wingbeat::scenario::{Document, Scenario, Summary};

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
    Scenario::load(&root.join(format!("scenarios/{name}.toml")), &overrides).unwrap_or_else(|e| panic!("{e}"))
}

fn fly(name: &str, overrides: &[&str]) -> Summary {
    scenario(name, overrides).fly(|_| ControlFlow::Continue(())).unwrap_or_else(|e| panic!("{e}")).summary
}

/// Whether a limit was held against, and its value.
fn held(summary: &Summary, id: &str) -> Option<(bool, f64)> {
    summary
        .judged
        .iter()
        .find(|judged| judged.id == id)
        .map(|judged| (judged.met, judged.value.unwrap_or(f64::NAN)))
}

fn said(summary: &Summary, id: &str) -> usize {
    summary.warnings.iter().filter(|warning| warning.id == id).count()
}

#[test]
fn a_turn_to_the_other_side_is_off_target() {
    let duration = "flight.duration_s=3.5";
    let turned = fly("banking_turn", &[duration]);
    assert_eq!(turned.status, Status::Ok, "{:?}", turned.reason);
    assert!(held(&turned, "flight.turned_fraction").is_some_and(|(met, of)| met && of > 0.7));
    // Heading is weighed as little as roll and pitch.
    let away = fly("banking_turn", &[duration, "controller.weights.rate_axes=[0.05,0.05,0.05]"]);
    assert_eq!(away.status, Status::OffTarget);
    assert!(held(&away, "flight.turned_fraction").is_some_and(|(met, of)| !met && of < -0.5));
    // No heading is asked.
    let free = fly("banking_turn", &[duration, "manoeuvre.yaw_rate_rad_s=0.0"]);
    assert_eq!(held(&free, "flight.turned_fraction"), None);
}

#[test]
fn the_speed_of_an_orbit_and_height_and_place_on_a_path_are_judged() {
    let level = fly("level_20g", &["flight.duration_s=3.0"]);
    assert!(held(&level, "flight.speed_error_fraction").is_some_and(|(met, of)| met && of < 0.01));
    let slow = fly("level_20g", &["flight.duration_s=6.0", "mismatch.profile_drag=3.0"]);
    let (met, of) = held(&slow, "flight.speed_error_fraction").unwrap();
    assert!(!met && (0.15..0.4).contains(&of) && slow.status == Status::OffTarget, "{of}");
    let strict =
        ["flight.duration_s=3.0", "limits.flight.altitude_m=1e-9", "limits.flight.path_along_m=1e-9"];
    let path = fly("path_figure8", &strict);
    assert!(held(&path, "flight.altitude_m").is_some_and(|(met, _)| !met));
    assert!(held(&path, "flight.path_along_m").is_some_and(|(met, _)| !met));
    assert!(held(&path, "flight.path_m").is_some_and(|(met, _)| met));
    // A landing has speeds of its own; a glide has no orbit.
    assert_eq!(held(&fly("glide", &["flight.duration_s=0.2"]), "flight.speed_error_fraction"), None);
}

#[test]
fn small_slow_wings_are_told_in_flight_and_trim() {
    let duration = "flight.duration_s=0.5";
    let (met, of) = held(&fly("glider", &[duration]), "range.reynolds").unwrap();
    assert!(met && (5e4..1e5).contains(&of), "{of}");
    // The number goes with the density.
    let thin = fly("glider", &[duration, "air.density_kg_m3=0.0123"]);
    let (met, small) = held(&thin, "range.reynolds").unwrap();
    assert!(!met && said(&thin, "range.reynolds") == 1 && (small * 100.0 / of - 1.0).abs() < 0.2, "{small}");
    let trimmed = scenario("cruise_20g", &[]).trim(&mut |_| ControlFlow::Continue(())).unwrap();
    let of = trimmed.summary.judged.iter().find(|judged| judged.id == "range.reynolds");
    assert!(of.is_some_and(|judged| judged.met && judged.value.is_some_and(|of| of > 1e4)));
}

#[test]
fn the_mach_number_is_that_of_the_fastest_strip() {
    let fast = [
        "flight.duration_s=0.05",
        "flight.step_s=2e-5",
        "flight.record_every_s=1e-4",
        "robot.gait.fourier.frequency_hz=300.0",
        "air.density_kg_m3=0.06",
    ];
    let (met, of) = held(&fly("cruise_20g", &fast), "range.mach_outside").unwrap();
    assert!(!met && of > 0.7, "{of}");
}

#[test]
fn strips_close_to_the_ground_are_outside() {
    let near = |ground: &str| fly("level_20g", &["flight.duration_s=0.5", ground]);
    let low = near("air.ground_m=-0.085");
    assert!(held(&low, "flight.ground_chords").is_some_and(|(met, of)| !met && of > 0.0), "{:?}", low.reason);
    // The warning counts in the same chord, of other strips too.
    let other = fly("level_20g", &["flight.duration_s=0.1", "air.ground_m=-0.085", "aero.full.strips=12"]);
    for flown in [&low, &other] {
        let warned = flown.warnings.iter().find(|warning| warning.id == "ground.near").unwrap();
        assert_eq!(warned.size, held(flown, "flight.ground_chords").map(|(_, chords)| chords));
    }
    assert!(held(&near("air.ground_m=-1.0"), "flight.ground_chords").is_some_and(|(met, _)| met));
}

#[test]
fn what_no_controller_follows_is_told() {
    let given = [
        "flight.duration_s=0.2",
        "manoeuvre={turn_start_s=0.1,roll_deg=30.0,nose_up_deg=3.0,yaw_rate_rad_s=-1.0}",
        "path={curve={line={length_m=3.0}}}",
        "sensors.attitude_deg=3.0",
    ];
    assert_eq!(said(&fly("glider", &given), "flight.not_controlled"), 3);
    assert_eq!(said(&fly("glider", &given[..1]), "flight.not_controlled"), 0);
    assert_eq!(said(&fly("banking_turn", &given[..1]), "flight.not_controlled"), 0);
}

#[test]
fn a_clearance_without_a_weight_is_told() {
    let told = |more: &[&str]| {
        said(&fly("banking_turn", &[&["flight.duration_s=0.05"], more].concat()), "flight.clearance_unheard")
    };
    assert_eq!(told(&[]), 0);
    assert_eq!(told(&["controller.clearance_m=0.03"]), 1);
    assert_eq!(told(&["controller.clearance_m=0.03", "controller.weights.clearance=1.0"]), 0);
}

/// A flight of rectangular plates of 0.1 m chord, each given by name, side, half span and place, m.
fn plates(of: &[(&str, &str, f64, [f64; 3])]) -> Summary {
    let mut text = String::from(
        "name = \"plates\"\nair.density_kg_m3 = 1.225\naero = { preset = \"full\", law = \"linear\", full.strips = 16 }\n\
         start = { velocity_m_s = [9.0, 0.0, 0.0], nose_up_deg = 3.0 }\n\
         flight = { duration_s = 0.05, step_s = 1e-3, record_every_s = 0.01 }\n\
         [robot]\nname = \"plates\"\nbody = { mass_kg = 0.3, inertia_kg_m2 = [1.0, 1.0, 1.0] }\n",
    );
    for (name, side, half, [x, y, z]) in of {
        let along = if *side == "right" { -1.0 } else { 1.0 };
        let edges = "leading_edge_m = 0.025, trailing_edge_m = -0.075";
        text += &format!(
            "[[robot.surfaces]]\nname = \"{name}\"\nspan = \"{side}\"\nstrips = 8\n\
             planform = [{{ arc_m = 0.0, {edges} }}, {{ arc_m = {half:?}, {edges} }}]\n\
             panels = [{{ link = \"body\", origin_m = [{x:?}, {y:?}, {z:?}], direction = [0.0, {along:?}, 0.0] }}]\n"
        );
    }
    let scenario = Scenario::new(Document::text("plates", &text).unwrap()).unwrap_or_else(|e| panic!("{e}"));
    scenario.fly(|_| ControlFlow::Continue(())).unwrap_or_else(|e| panic!("{e}")).summary
}

#[test]
fn surfaces_that_lie_on_one_another_are_outside_and_others_are_not() {
    const NEAR: &str = "range.surfaces_apart_chords";
    let two = |place: [f64; 3], half: f64| {
        plates(&[("one", "symmetric", 0.4, [0.0; 3]), ("other", "symmetric", half, place)])
    };
    for (place, half, apart) in [
        ([0.0, 0.0, 0.0138], 0.4, 0.138),
        ([0.0, 0.0, 0.015], 0.2, 0.15),
        ([-0.02, 0.0, 0.005], 0.4, 0.05),
        ([0.03, 0.0, 0.0], 0.4, 0.0),
        ([0.0, 0.0, 0.03], 0.4, 0.3),
    ] {
        let flown = two(place, half);
        let (met, of) = held(&flown, NEAR).unwrap();
        assert!((of - apart).abs() < 1e-3 && met == (apart >= 0.2), "{place:?}: {of}");
        assert!(met || flown.status >= Status::Outside, "{place:?}");
    }
    // Behind, far above, and beside each other.
    for place in [[-0.15, 0.0, 0.0], [0.0, 0.0, 0.1]] {
        assert_eq!(held(&two(place, 0.4), NEAR), None, "{place:?}");
    }
    let halves = plates(&[("left", "left", 0.4, [0.0; 3]), ("right", "right", 0.4, [0.0; 3])]);
    assert_eq!(held(&halves, NEAR), None);
    assert_eq!(said(&halves, "aero.wing_in_pieces"), 1);
    let apart =
        plates(&[("left", "left", 0.4, [0.0, 0.05, 0.0]), ("right", "right", 0.4, [0.0, -0.05, 0.0])]);
    assert_eq!(said(&apart, "aero.wing_in_pieces"), 0);
    assert_eq!(said(&two([-0.3, 0.0, 0.0], 0.2), "aero.wing_in_pieces"), 0);
}
