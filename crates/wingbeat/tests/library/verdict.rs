//! What a flight is called without a goal of its own.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use wingbeat::guide::SearchWatch;
use wingbeat::judge::data::{CyclePair, mean_apart};
use wingbeat::judge::{RunLimits, Status, Warning};
use wingbeat::scenario::{Scenario, Summary};

fn scenario(name: &str, overrides: &[&str]) -> Result<Scenario, String> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
    Scenario::load(&root.join(format!("scenarios/{name}.toml")), &overrides).map_err(|e| e.to_string())
}

fn fly(name: &str, overrides: &[&str]) -> Summary {
    scenario(name, overrides).unwrap().fly(|_| ControlFlow::Continue(())).unwrap().summary
}

fn missed(summary: &Summary) -> Vec<&str> {
    summary.judged.iter().filter(|judged| !judged.met).map(|judged| judged.id).collect()
}

/// The controller knows law `lev`; the air that flies is another.
const OTHER_AIR: &str = "mismatch.aero.law=stall";

#[test]
fn a_flight_that_falls_is_off_target_without_a_goal() {
    let lost = fly("bank15_20g_lev", &[OTHER_AIR, "flight.duration_s=3"]);
    assert!(lost.status >= Status::OffTarget, "{:?}", lost.reason);
    let missed = missed(&lost);
    assert!(
        missed.contains(&"flight.altitude_m") || missed.contains(&"flight.attitude_rms_deg"),
        "{missed:?}"
    );
    let reason = lost.reason.unwrap();
    assert!(reason.contains("allowed is at most") && reason.contains("limits.flight."), "{reason}");
}

#[test]
fn a_flight_of_more_power_than_muscles_and_motors_give_is_outside() {
    let fast = fly("cruise_20g", &["robot.gait.fourier.frequency_hz=14.0", "flight.duration_s=1.0"]);
    assert_eq!(fast.status, Status::Outside, "{:?}", fast.reason);
    assert!(missed(&fast).contains(&"trim.power_w_kg"), "{:?}", missed(&fast));
}

#[test]
fn a_flight_that_holds_its_orbit_is_ok_and_says_on_what_that_rests() {
    let held = fly("bank15_beta_lev", &["flight.duration_s=1.5"]);
    assert_eq!(held.status, Status::Ok, "{:?}", held.reason);
    let judged: Vec<&str> = held.judged.iter().map(|judged| judged.id).collect();
    for id in [
        "flight.altitude_m",
        "flight.attitude_rms_deg",
        "flight.saturation_fraction",
        "flight.crossing_fraction",
    ] {
        assert!(judged.contains(&id), "{id} of {judged:?}");
    }
    assert!(missed(&held).is_empty() && held.judged.iter().all(|judged| !judged.overridden));
}

#[test]
fn a_document_overrides_a_limit_and_the_verdict_says_so() {
    let short = ["flight.duration_s=0.3", "limits.flight.altitude_m=1e-9"];
    let strict = fly("bank15_beta_lev", &short);
    assert_eq!(strict.status, Status::OffTarget);
    let height = strict.judged.iter().find(|judged| judged.id == "flight.altitude_m").unwrap();
    assert!(height.overridden && height.limit == 1e-9 && !height.met);
    let refused = scenario("glide", &["limits.flight.altitud_m=1.0"]).unwrap_err();
    assert!(
        refused.contains("limits.flight.altitud_m") && refused.contains("flight.altitude_m,"),
        "{refused}"
    );
}

#[test]
fn a_goal_takes_the_place_of_the_usual_limits_of_its_quantities() {
    let short = ["flight.duration_s=0.1"];
    let turn = fly("banking_turn", &short);
    assert_eq!((turn.status, turn.not_judged.len()), (Status::NotJudged, 2));
    assert_eq!(turn.status.exit_code(), 0);
    assert!(turn.warnings.iter().any(|warning| warning.id == "flight.goal_not_judged"));
    assert!(turn.judged.iter().all(|judged| judged.id != "flight.attitude_rms_deg"));
}

#[test]
fn a_free_flight_that_tumbles_gets_a_warning_and_a_glide_none() {
    let said =
        |summary: &Summary| summary.warnings.iter().any(|warning| warning.id == "flight.free_path_angle_deg");
    let fallen = fly("cruise_20g_lev", &[]);
    assert!(said(&fallen) && fallen.sink_rate_m_s.unwrap() > 3.0, "{:?}", fallen.warnings);
    let glide = fly("glide", &["flight.duration_s=2.5"]);
    assert!(!said(&glide) && glide.status == Status::Ok, "{:?}", glide.warnings);
}

/// Five kilograms on the wings of twenty grams fall, whoever controls them; what glides, or has no air to be carried by, does not miss it.
#[test]
fn a_robot_that_its_wings_do_not_carry_is_off_target() {
    let heavy = ["robot.body.mass_kg=5", "flight.duration_s=1"];
    for (name, more) in [("cruise_20g", &[][..]), ("banking_turn", &["goal.settle_s=0.5"])] {
        let fallen = fly(name, &[&heavy, more].concat());
        assert_eq!(fallen.status, Status::OffTarget, "{name}: {:?}", fallen.reason);
        assert!(missed(&fallen).contains(&"flight.weight_carried"), "{name}: {:?}", missed(&fallen));
        assert!(fallen.reason.unwrap().contains("the robot falls: "));
    }
    let meant = fly("cruise_20g", &[heavy[0], "flight.duration_s=2", "limits.flight.weight_carried=-1.0"]);
    assert_eq!(meant.status, Status::Ok, "{:?}", meant.reason);
    for (name, overrides) in [("glide", &["flight.duration_s=2"][..]), ("reorientation", &[])] {
        let held = fly(name, overrides);
        assert_eq!(held.status, Status::Ok, "{name}: {:?}", held.reason);
    }
    // A whole stroke in all is enough, where none is in the part that counts.
    let one = fly("cruise_20g", &[heavy[0], "flight.duration_s=0.2"]);
    assert!(missed(&one).contains(&"flight.weight_carried"), "{:?}", one.reason);
    // Drag carries what has fallen for long.
    let fallen =
        fly("cruise_20g", &[heavy[0], "flight.duration_s=8", "robot.body.drag_area_m2=[1.0, 1.0, 1.0]"]);
    assert!(fallen.cost.weight_carried.unwrap() > 0.9, "{:?}", fallen.cost);
    assert!(missed(&fallen).contains(&"flight.falling_path_angle_deg"), "{:?}", fallen.reason);
}

/// A stroke that is not whole carries nothing in the mean, and what has just begun to fall is no fall yet.
#[test]
fn a_flight_too_short_to_be_carried_is_not_judged() {
    for (name, duration) in [("cruise_20g", "0.1"), ("glide", "0.7")] {
        let brief = fly(name, &["robot.body.mass_kg=5", &format!("flight.duration_s={duration}")]);
        assert_eq!(brief.status, Status::NotJudged, "{name}: {:?}", brief.reason);
        assert!(brief.reason.unwrap().contains("flight.weight_carried") && brief.status.exit_code() == 0);
        assert!(brief.judged.iter().all(|judged| judged.id != "flight.weight_carried"));
    }
    // Its goal settles after its end; whole cycles say that it is carried.
    let turn = fly("banking_turn", &["flight.duration_s=0.5"]);
    let open = turn.reason.unwrap_or_default();
    assert!(turn.status == Status::NotJudged && !open.contains("flight.weight_carried"), "{open}");
    // A vacuum carries nothing; this flight holds a whole cycle, but not in its second half.
    assert_eq!(fly("reorientation", &["flight.duration_s=0.1"]).status, Status::Ok);
    let elastic = fly("aerobat_elastic", &[]).reason.unwrap_or_default();
    assert!(
        elastic.contains("the angle of the path") && !elastic.contains("flight.weight_carried"),
        "{elastic}"
    );
}

/// One rule for all that moves: below zero parts pass through each other, below the thickness of their skins they touch.
#[test]
fn wings_that_touch_are_told_in_flight_as_in_trim() {
    let told = |limit: &str| {
        let flown = fly("cruise_20g", &["flight.duration_s=0.2", limit]);
        assert_eq!(flown.status, Status::NotJudged, "{:?}", flown.reason);
        flown.warnings.iter().any(|warning| warning.id == "trim.skin_clearance_m")
    };
    assert!(told("limits.trim.skin_clearance_m=0.02") && !told("limits.trim.skin_clearance_m=0.003"));
}

#[test]
fn a_clearance_that_never_changes_says_what_it_is() {
    let short = ["flight.duration_s=0.2"];
    let root = Some("wing to middle plane".to_owned());
    assert_eq!(fly("glide", &short).constant_clearance, root);
    assert_eq!(fly("cruise_20g_margin", &short).constant_clearance, root);
    assert_eq!(fly("cruise_20g", &short).constant_clearance, None);
}

/// What a snapshot says of the states of another preset.
#[test]
fn states_of_another_model_are_refused_with_the_way_out() {
    let of_strips = "start.states={ wash_lag1_0 = 0.1 }";
    let paper = ["aero.preset=paper", of_strips];
    let refused = scenario("cruise_20g", &paper).map(|_| ()).unwrap_err();
    assert!(refused.contains("--set start.states={}"), "{refused}");
    assert!(scenario("cruise_20g", &[paper[0], paper[1], "start.states={}"]).is_ok());
}

#[test]
fn the_search_of_orbits_tells_how_far_it_is() {
    let told = Arc::new(Mutex::new(Vec::new()));
    let seen = told.clone();
    let mut turn = scenario("bank15_20g", &["flight.duration_s=0.01"]).unwrap();
    turn.watch_search(SearchWatch::new(move |found, all| seen.lock().unwrap().push((found, all))));
    turn.fly(|_| ControlFlow::Continue(())).unwrap();
    let told = told.lock().unwrap();
    let all = told[0].1;
    assert!(all > 4 && told.iter().copied().eq((1..=all).map(|found| (found, all))), "{told:?}");
}

#[test]
fn a_start_that_turns_more_than_once_is_refused() {
    for (key, allowed) in [
        ("start.nose_up_deg=500", "-180 to 180"),
        ("start.nose_up_deg=nan", "-180 to 180"),
        ("start.velocity_m_s=[inf, 0.0, 0.0]", "-1000 to 1000"),
        ("start.roll_deg=-181", "-180 to 180"),
        ("start.yaw_deg=361", "-360 to 360"),
        ("start.rate_rad_s=[0.0, 1e5, 0.0]", "-1000 to 1000"),
        ("start.velocity_m_s=[0.0, 0.0, 1001.0]", "-1000 to 1000"),
    ] {
        let refused = scenario("glide", &[key]).map(|_| ()).unwrap_err();
        assert!(refused.contains(key.split('=').next().unwrap()) && refused.contains(allowed), "{refused}");
    }
    assert!(scenario("glide", &["start.nose_up_deg=170", "start.yaw_deg=270"]).is_ok());
}

#[test]
fn a_crank_that_its_motor_does_not_turn_is_outside() {
    let told = |summary: &Summary| {
        summary.judged.iter().find(|judged| judged.id == "linkage.crank_rate_fraction").cloned().unwrap()
    };
    let turning = fly("motor_flapper", &["flight.duration_s=0.3"]);
    assert!(told(&turning).met && turning.status != Status::Outside, "{:?}", turning.reason);
    let weak = ["flight.duration_s=0.3", "robot.drive.motor.stall_torque_n_m=1e-9"];
    let stalled = fly("motor_flapper", &weak);
    assert!(!told(&stalled).met && stalled.status == Status::Outside, "{:?}", told(&stalled));
    // What turns back is no part of a cycle.
    let cycles = stalled.judged.iter().find(|judged| judged.id == "flight.cycles_averaged");
    assert!(cycles.is_none_or(|cycles| cycles.value.is_none_or(|count| count >= 0.0)), "{cycles:?}");
    // Of gaits at a constant rate nothing is said.
    let constant = fly("cruise_20g", &["flight.duration_s=0.1"]);
    assert!(constant.judged.iter().all(|judged| judged.id != "linkage.crank_rate_fraction"));
}

#[test]
fn wings_that_cross_put_the_flight_outside_of_its_model() {
    let crossed = fly("cruise_beta_lev", &["robot.links[1].driven.mean_rad=-0.45"]);
    assert_eq!(crossed.status, Status::Outside, "{:?}", crossed.reason);
    assert_eq!(missed(&crossed), ["flight.crossing_fraction"]);
}

#[test]
fn a_spar_that_winds_up_is_outside() {
    let soft = |share: f64| {
        let [bending, torsion] = [0.038, 0.062].map(|stiffness| share * stiffness);
        let spar = "robot.links[2].spar";
        let [bending, torsion] =
            [format!("{spar}.bending_n_m2={bending}"), format!("{spar}.torsion_n_m2={torsion}")];
        fly("soft_20g", &[&bending, &torsion, "flight.duration_s=0.2"])
    };
    let [own, weak] = [1.0, 1e-3].map(soft);
    let told = |summary: &Summary| summary.judged.iter().find(|j| j.id == "spar.angle_outside_deg").cloned();
    assert!(told(&own).unwrap().met && own.spar.unwrap().angle_max_deg < 30.0, "{:?}", own.spar);
    assert!(!told(&weak).unwrap().met, "{:?}", weak.spar);
    assert_eq!(weak.status, Status::Outside);
}

#[test]
fn spars_of_links_in_other_units_or_of_few_pieces_are_told() {
    let judged = |set: &str| {
        let spar = set.split(", ").map(|set| format!("robot.links[2].spar.{set}"));
        let all: Vec<String> = spar.chain(["flight.duration_s=0.02".into()]).collect();
        fly("soft_20g", &all.iter().map(String::as_str).collect::<Vec<_>>())
    };
    for (set, id, status) in [
        ("inertia_kg_m=0.06", "spar.gyration", Some(Status::Outside)),
        ("ahead_m=-0.9", "spar.off_chord", Some(Status::Outside)),
        ("length_m=0.1", "spar.end_fraction", None),
        ("segments=1, taper=1.0", "spar.frequency_fraction", None),
    ] {
        let summary = judged(set);
        assert!(!summary.judged.iter().find(|judged| judged.id == id).unwrap().met, "{set}: {summary:?}");
        assert!(status.is_none_or(|status| summary.status == status), "{set}: {:?}", summary.status);
    }
    let own = judged("segments=2");
    assert!(own.judged.iter().filter(|j| j.id.starts_with("spar.")).all(|judged| judged.met), "{own:?}");
    assert!((0.0..0.1).contains(&own.spar.unwrap().frequency_error.abs()), "{:?}", own.spar);
}

#[test]
fn a_spar_longer_than_its_wing_is_refused_by_its_key() {
    let error = scenario("soft_20g", &["robot.links[2].spar.length_m=1.32"]).map(|_| ()).unwrap_err();
    assert!(error.contains("links[2].spar.length_m") && error.contains("0.2027"), "{error}");
}

/// One strip closes a twist within its own width, which the number of strips decides.
#[test]
fn a_twist_without_a_web_is_told() {
    let told = |summary: &Summary| summary.warnings.iter().any(|warning| warning.id == "aero.open_twist");
    let short = "flight.duration_s=0.01";
    assert!(!told(&fly("cruise_20g", &[short])));
    assert!(told(&fly("cruise_20g", &[short, "robot.surfaces[0].panels[2].web_m=0"])));
    assert!(!told(&fly("cruise_20g", &[short, "robot.surfaces[0].panels[2].web_m=0", "aero.preset=paper"])));
}

/// What counts is how chords lie beside one another: an axis that is not along the span twists too, and twists that undo one another do
/// not.
#[test]
fn a_twist_is_told_by_the_chords_beside_it() {
    let told = |more: &[&str]| {
        let open = ["flight.duration_s=0.01", "robot.surfaces[0].panels[2].web_m=0"];
        let summary = fly("cruise_20g", &[&open, more].concat());
        summary.warnings.iter().any(|warning| warning.id == "aero.open_twist")
    };
    assert!(told(&["robot.links[2].axis=[0.8, -0.6, 0.0]"]));
    assert!(!told(&["robot.links[2].axis=[1.0, 0.0, 0.0]"]));
    let swing = "{mean_rad=-0.1, harmonics=[{amplitude_rad=0.7, phase_rad=-1.3}]}";
    let [elbow, twist] = [1, 2].map(|link| format!("robot.links[{link}].driven={swing}"));
    let crank = "robot.structure.elements=[{name='crank', moves=['crank'], low=-20.0, high=20.0}]";
    let undone = [&elbow, &twist, crank, "robot.links[1].axis=[0.0, 1.0, 0.0]"];
    assert!(!told(&undone));
    assert!(told(&undone[..3]));
}

/// Nodes of preset `paper` ride on rigid panels, whatever web these have.
#[test]
fn a_web_that_no_model_has_is_told() {
    let told = |summary: &Summary| {
        let of_web =
            |warning: &&Warning| warning.id == "aero.unheard" && warning.text.contains("web_m = 0.0544457");
        summary.warnings.iter().filter(of_web).count()
    };
    let short = "flight.duration_s=0.01";
    assert_eq!(told(&fly("cruise_20g", &[short])), 0);
    assert_eq!(told(&fly("cruise_20g", &[short, "aero.preset=paper"])), 1);
    assert_eq!(told(&fly("cruise_20g", &[short, "robot.surfaces[0].preset=paper"])), 1);
    assert_eq!(told(&fly("aerobat_elastic", &[short])), 0);
}

#[test]
fn means_over_less_than_a_cycle_are_told() {
    let told = |duration: &str| {
        let flown = fly("cruise_20g", &[duration]);
        flown.warnings.iter().any(|warning| warning.id == "flight.cycles_averaged")
    };
    // A cycle takes 0.169 s, and half of a flight counts.
    assert!(
        told("flight.duration_s=0.05") && told("flight.duration_s=0.3") && !told("flight.duration_s=0.4")
    );
}

/// The key of a robot is 0 where it is left out.
#[test]
fn a_surface_that_separates_without_profile_drag_is_told() {
    let told = |set: &[&str]| {
        let flown = fly("cruise_20g", &[&["flight.duration_s=0.02"], set].concat());
        flown.warnings.into_iter().find(|warning| warning.id == "aero.no_profile_drag")
    };
    let smooth = "robot.surfaces[0].cd0=0.0";
    let warning = told(&[smooth]).unwrap();
    assert!(warning.text.contains("wing") && warning.text.contains("0.05"), "{warning}");
    assert_eq!(warning.key.as_deref(), Some("robot.surfaces[0].cd0"));
    assert!(told(&[]).is_none() && told(&[smooth, "aero.law=linear"]).is_none());
}

fn warned<'a>(summary: &'a Summary, id: &str) -> Option<&'a Warning> {
    summary.warnings.iter().find(|warning| warning.id == id)
}

/// A cycle takes 0.170 s.
#[test]
fn a_record_that_is_too_sparse_for_its_powers_is_told_and_then_not_resolved() {
    let of = |every: &str| fly("cruise_20g", &[&format!("flight.record_every_s={every}")]);
    let [fine, enough, few, sparse] = ["1e-3", "5e-3", "0.01", "0.02"].map(of);
    let power = |summary: &Summary| summary.cost.positive_power_w_kg.unwrap();
    assert!((power(&enough) / power(&fine) - 1.0).abs() < 0.01, "{} {}", power(&enough), power(&fine));
    assert!(warned(&enough, "flight.few_records_per_cycle").is_none() && enough.status == Status::Ok);
    let told = warned(&few, "flight.few_records_per_cycle").unwrap();
    assert!(told.text.contains("flight.record_every_s") && (told.size.unwrap() - 17.0).abs() < 0.1, "{told}");
    assert_eq!(few.status, Status::Ok, "{:?}", few.reason);
    assert!(
        sparse.status == Status::NotResolved && warned(&sparse, "flight.few_records_per_cycle").is_none()
    );
    assert!(missed(&sparse).contains(&"flight.records_per_cycle"), "{:?}", sparse.reason);
    // Wings at rest count by the second.
    let glide = fly("glide", &["flight.record_every_s=0.05", "flight.duration_s=2.5"]);
    assert!(warned(&glide, "flight.few_records_per_cycle").is_some(), "{:?}", glide.warnings);
}

/// It rears up and goes over within two seconds.
#[test]
fn a_flight_past_the_vertical_has_no_roll_and_no_heading() {
    let over = fly("cruise_20g_lev", &[]);
    let told = warned(&over, "flight.vertical_deg").unwrap();
    assert!(told.text.contains("left out") && told.size == Some(90.0), "{told}");
    assert_eq!((over.roll_mean_deg, over.yaw_change_deg, over.pitch_mean_deg), (None, None, None));
    assert!(over.roll_max_error_deg.unwrap() > 90.0);
    let kept = fly("cruise_20g_lev", &["limits.flight.vertical_deg=90"]);
    assert!(kept.yaw_change_deg.is_some() && kept.roll_mean_deg.is_some());
    let level = fly("cruise_20g", &["flight.duration_s=0.4"]);
    assert!(warned(&level, "flight.vertical_deg").is_none() && level.yaw_change_deg.is_some());
}

/// Seen from a wind, in which the same robot flies.
#[test]
fn a_path_is_as_steep_in_any_wind() {
    let angle = |overrides: &[&str]| {
        let flown = fly("glide", &[&["flight.duration_s=2.5"], overrides].concat());
        let judged = flown.judged.iter().find(|judged| judged.id == "flight.falling_path_angle_deg").unwrap();
        (judged.value.unwrap(), flown.status)
    };
    let still = angle(&[]);
    for overrides in [
        ["air.wind_m_s=[-3.32, 0.0, 0.0]", "start.velocity_m_s=[0.0, 0.0, -0.8]"],
        ["air.wind_m_s=[2.0, 1.0, -0.5]", "start.velocity_m_s=[5.32, 1.0, -1.3]"],
    ] {
        let seen = angle(&overrides);
        assert!((seen.0 - still.0).abs() < 1e-9 && seen.1 == still.1, "{overrides:?}: {seen:?} {still:?}");
    }
}

#[test]
fn a_path_that_turns_back_on_itself_is_refused() {
    let curve = "path.curve={points={points_m=[[3.0, 0.0, 0.0], [0.5, 0.0, 0.0]]}}";
    let told = scenario("path_figure8", &[curve])
        .and_then(|of| of.fly(|_| ControlFlow::Continue(())).map_err(|e| e.to_string()));
    let told = told.err().unwrap();
    assert!(told.contains("points_m[0] = ") && told.contains("nowhere turns back on itself"), "{told}");
}

#[test]
fn a_flight_too_short_for_its_path_is_not_judged() {
    let brief = fly("glide", &["flight.duration_s=1.9"]);
    assert_eq!(brief.status, Status::NotJudged, "{:?}", brief.reason);
    assert!(brief.reason.unwrap().contains("shorter than 2 s"));
}

#[test]
fn a_goal_is_not_judged_by_a_single_sample_or_a_part_of_a_stroke() {
    for settle in ["goal.settle_s=0.6", "goal.settle_s=0.5"] {
        let turn = fly("banking_turn", &["flight.duration_s=0.6", "goal.roll_within_deg=90", settle]);
        assert_eq!(turn.status, Status::NotJudged, "{settle}: {:?}", turn.reason);
        assert_eq!(turn.not_judged, ["goal.roll_within_deg", "goal.pitch_within_deg"], "{settle}");
        let told = warned(&turn, "flight.goal_not_judged").unwrap();
        assert!(told.text.contains("less than a cycle"), "{told}");
        assert!(warned(&turn, "flight.cycles_averaged").is_some(), "{settle}: {:?}", turn.warnings);
    }
}

#[test]
fn what_begins_after_the_end_is_told_by_its_key() {
    for (name, key, more) in [
        ("banking_turn", "manoeuvre.turn_start_s", "manoeuvre.turn_start_s=20"),
        ("bank15_20g", "controller.orbit.legs[0].start_s", "controller.orbit.legs[0].start_s=100"),
        (
            "glide",
            "air.gusts[0].start_s",
            "air.gusts=[{start_s=1.0, duration_s=0.1, velocity_m_s=[1.0, 0.0, 0.0]}]",
        ),
    ] {
        let flown = fly(name, &["flight.duration_s=0.02", more]);
        let told = warned(&flown, "flight.never_begins").unwrap();
        assert!(told.key.as_deref() == Some(key) && told.text.contains("0.02 s"), "{told}");
    }
    assert!(
        warned(
            &fly("banking_turn", &["flight.duration_s=0.02", "manoeuvre.turn_start_s=0.01"]),
            "flight.never_begins"
        )
        .is_none()
    );
}

#[test]
fn a_robot_that_nothing_lifts_is_told() {
    let bare = fly("cruise_20g", &["flight.duration_s=0.02", "robot.surfaces=[]"]);
    assert_eq!(warned(&bare, "flight.nothing_lifts").unwrap().key.as_deref(), Some("robot.surfaces"));
    assert!(warned(&fly("cruise_20g", &["flight.duration_s=0.02"]), "flight.nothing_lifts").is_none());
}

#[test]
fn wind_beside_orbits_is_refused_by_its_key() {
    for name in ["bank15_20g", "any_air_bank30_20g", "path_figure8"] {
        let told = scenario(name, &["air.wind_m_s=[0.0, 1.0, 0.0]"]).unwrap_err();
        assert!(
            told.contains("air.wind_m_s = [0.0, 1.0, 0.0]") && told.contains("still air"),
            "{name}: {told}"
        );
    }
}

#[test]
fn steps_that_are_too_long_for_the_loads_are_named() {
    let torn = fly(
        "cruise_20g",
        &["flight.step_s=0.01", "flight.record_every_s=0.01", "start.velocity_m_s=[200, 0, 0]"],
    );
    let reason = torn.reason.unwrap_or_default();
    assert!(torn.status == Status::Failed && reason.contains("shorten flight.step_s"), "{reason}");
}

/// Whoever is held by the air: thrusters carry a hover on wings past any law.
#[test]
fn a_flight_backwards_or_past_every_law_is_outside() {
    let back = ["start.velocity_m_s=[-4.0, 0.0, -0.4]", "flight.duration_s=0.2"];
    let flown = fly("cruise_20g", &back);
    assert_eq!(flown.status, Status::Outside, "{:?}", flown.reason);
    for id in ["range.reversed_outside_fraction", "range.stall_outside_fraction"] {
        assert!(missed(&flown).contains(&id), "{id}: {:?}", flown.reason);
    }
    let allowed = ["limits.range.reversed_outside_fraction=1", "limits.range.stall_outside_fraction=1"];
    let allowed = fly("cruise_20g", &[&back[..], &allowed].concat());
    assert!(!missed(&allowed).iter().any(|id| id.contains("outside_fraction")), "{:?}", allowed.reason);
    let hover = fly("hover_guarded", &["flight.duration_s=0.2"]);
    assert!(hover.judged.iter().all(|judged| judged.id != "range.stall_outside_fraction"));
}

/// Where nothing is computed, as of the air in a vacuum, a mean is not held against it.
#[test]
fn means_are_held_against_loads_that_are_computed() {
    let wave = |mean: f64, size: f64| -> Vec<f64> {
        (0..64).map(|k| mean + size * (f64::from(k) * std::f64::consts::TAU / 64.0).sin()).collect()
    };
    let told = |size: f64| {
        let (measured, computed, moments) = (wave(0.3, 0.02), wave(0.0, size), wave(0.0, 0.01));
        let pairs = [
            CyclePair { name: "Fz", unit: "N", measured: &measured, computed: &computed },
            CyclePair { name: "Ty", unit: "N m", measured: &moments, computed: &moments },
        ];
        mean_apart("run", &pairs)
            .filter(|finding| finding.breaks(&RunLimits::default()))
            .map(|finding| finding.about)
    };
    assert_eq!(told(0.02), Some("Fz of run".into()));
    for nothing in [0.0, 1e-30, 1e-5] {
        assert_eq!(told(nothing), None, "{nothing}");
    }
}
