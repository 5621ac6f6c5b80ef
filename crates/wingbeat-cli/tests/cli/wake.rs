//! `wingbeat wake` as a user meets it: run folder, figures, numbers, refusals.

use std::fs;

use crate::{entries, root, scratch, wingbeat};
use wingbeat_io::read_parquet;

fn case(name: &str) -> String {
    root().join("cases").join(name).display().to_string()
}

#[test]
fn a_case_leaves_its_wake() {
    let folder = scratch("wake-whole");
    let small = ["--chordwise", "2", "--spanwise", "8", "--steps", "16", "--set", "time.cycles=2"];
    let output = wingbeat(&folder, &[&["wake", &case("flap_f2.toml"), "--out", "a"], &small[..]].concat());
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("attached flow is assumed") && text.contains("run folder: a"), "{text}");
    let names = [
        "case.toml",
        "downstroke_begins.vtk",
        "figures",
        "manifest.json",
        "middle_of_downstroke.vtk",
        "middle_of_upstroke.vtk",
        "record.parquet",
        "report.html",
        "summary.json",
        "upstroke_begins.vtk",
    ];
    assert_eq!(entries(&folder.join("a")), names);
    let figures = [
        "frontal_planes.png",
        "frontal_planes.svg",
        "wake.png",
        "wake.svg",
        "wake_phases.png",
        "wake_phases.svg",
    ];
    assert_eq!(entries(&folder.join("a/figures")), figures);
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.join("a/summary.json")).unwrap()).unwrap();
    assert_eq!(summary["status"], "ok");
    assert!(
        summary["judged"].as_array().unwrap().iter().any(|judged| judged["id"] == "wake.circulation_error")
    );
    let warned = summary["warnings"].as_array().unwrap().last().unwrap();
    assert!(warned["id"] == "wake.attached_flow" && warned["size"].as_f64().unwrap() > 0.0, "{warned}");
    let number = |key: &str| summary.pointer(key).and_then(serde_json::Value::as_f64).unwrap();
    assert!(number("/circulation_error") < 1e-12 && number("/symmetry_error") < 1e-6);
    let ratios = [number("/down_over_up/left"), number("/down_over_up/right")];
    assert!((ratios[0] / ratios[1] - 1.0).abs() < 1e-6 && ratios[0] < -1.0, "{ratios:?}");
}

#[test]
fn a_wake_beyond_its_limit_ends_with_the_name_of_the_limit() {
    let folder = scratch("wake-limit");
    let small = ["--chordwise", "2", "--spanwise", "8", "--steps", "16", "--set", "time.cycles=1"];
    let limit = ["--set", "limits.wake.circulation_error=0.0", "--out", "a"];
    let output = wingbeat(&folder, &[&["wake", &case("flap_f2.toml")], &small[..], &limit[..]].concat());
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.join("a/summary.json")).unwrap()).unwrap();
    assert!(output.status.code() == Some(3) && summary["status"] == "not_resolved", "{output:?}");
    let (said, told) = (String::from_utf8(output.stderr).unwrap(), String::from_utf8(output.stdout).unwrap());
    assert!(said.contains("limits.wake.circulation_error"), "{said}");
    assert!(told.contains("limit overridden: wake.circulation_error = 0"), "{told}");
    let coarse =
        ["--chordwise", "1", "--spanwise", "1", "--steps", "8", "--set", "time.cycles=1", "--out", "b"];
    let output = wingbeat(&folder, &[&["wake", &case("flap_f2.toml"), "--no-report"], &coarse[..]].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    let named = ["limits.wake.panels_along_chord", "limits.wake.panels_along_span"];
    assert!(output.status.code() == Some(3) && named.iter().all(|name| said.contains(name)), "{said}");
}

#[test]
fn a_wing_that_does_not_stroke_is_drawn_at_its_end() {
    let folder = scratch("wake-step");
    let small = ["--chordwise", "2", "--spanwise", "6", "--steps", "40", "--prescribed", "--quiet"];
    let output = wingbeat(&folder, &[&["wake", &case("step.toml"), "--out", "a"], &small[..]].concat());
    assert!(output.status.success() && output.stdout.is_empty(), "{output:?}");
    assert!(entries(&folder.join("a")).contains(&"end_of_the_run.vtk".to_owned()));
}

#[test]
fn what_cannot_be_stepped_is_refused() {
    let folder = scratch("wake-refused");
    for (more, says) in [
        (["--chordwise", "0"], "--chordwise 0: allowed is 1 or more"),
        (
            ["--chordwise", "1000000000"],
            "--chordwise times --spanwise: 24000000000 panels: allowed is at most",
        ),
        (["--core", "0"], "--core: a radius of 0 m: allowed is above 0"),
        (["--core", "nan"], "--core: a radius of NaN m: allowed is above 0"),
        (["--core", "1e300"], "e298 m: allowed is above 0 and at most 0.08"),
        (["--steps", "100000"], "allowed are at most 200000"),
        (["--spanwise", "1"], "strips = 1"),
    ] {
        let output = wingbeat(&folder, &[&["wake", &case("flap_fold.toml")], &more[..]].concat());
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && text.contains(says), "{text}");
    }
}

#[test]
fn few_panels_are_told() {
    let folder = scratch("wake-few-panels");
    let case = root().join("cases/flap_f2.toml");
    let told = |panels: [&str; 2]| {
        let set = ["--steps", "16", "--prescribed", "--quiet", "--no-report", "--force", "--out", "o"];
        let all = [
            "wake",
            case.to_str().unwrap(),
            "--set",
            "time.cycles=1",
            "--chordwise",
            panels[0],
            "--spanwise",
            panels[1],
        ];
        let output = wingbeat(&folder, &[&all[..], &set].concat());
        assert!(output.status.code() != Some(2), "{output:?}");
        let text = fs::read_to_string(folder.join("o/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        let warnings = summary["warnings"].to_string();
        ["wake.few_panels_along_chord", "wake.few_panels_along_span"].map(|id| warnings.contains(id))
    };
    assert_eq!(told(["3", "8"]), [true, false]);
    assert_eq!(told(["4", "7"]), [false, true]);
    assert_eq!(told(["4", "8"]), [false, false]);
}

#[test]
fn a_wake_from_rest_says_how_far_it_is_from_settled() {
    let folder = scratch("wake-settled");
    let small =
        ["--prescribed", "--chordwise", "2", "--spanwise", "8", "--no-report", "--force", "--out", "o"];
    let run = |name: &str, more: &[&str]| {
        let output = wingbeat(&folder, &[&["wake", &case(name)], &small[..], more].concat());
        let summary = fs::read_to_string(folder.join("o/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), summary)
    };
    let (code, text, summary) = run("flap_f1.toml", &["--set", "time.cycles=1", "--steps", "24"]);
    assert!(
        code == Some(0) && summary["status"] == "not_judged" && summary["cycle_change_fraction"].is_null()
    );
    assert!(text.contains("not_judged: the motion repeats"), "{text}");
    let (code, _, summary) = run("flap_f1.toml", &["--steps", "24"]);
    let change = summary["cycle_change_fraction"].as_f64().unwrap();
    assert!(code == Some(0) && change > 1e-4 && change < 0.01, "{code:?} {change}");
    let short = ["--set", "time.cycles=2", "--set", "time.frequency_hz=1", "--steps", "24"];
    let (code, _, summary) = run("step.toml", &short);
    assert!(code == Some(3) && summary["status"] == "not_periodic", "{code:?} {summary}");
    // A wing at rest that meets the wind: one instant is no flow, forty semi-chords are a start.
    let (code, _, summary) = run("step.toml", &["--steps", "1"]);
    assert!(code == Some(3) && summary["status"] == "not_resolved" && summary["wake_drag_n"].is_null());
    let (code, _, summary) = run("step.toml", &["--steps", "40"]);
    assert!(code == Some(0) && summary["warnings"].to_string().contains("wake.started_fraction"));
    let (code, _, summary) = run("step.toml", &["--steps", "40", "--set", "time.cycles=3"]);
    assert!(code == Some(0) && !summary["warnings"].to_string().contains("wake.started_fraction"));
    assert!(summary["cycle_change_fraction"].as_f64().unwrap() < 1e-2, "{summary}");
}

#[test]
fn ratios_of_strokes_hold_with_any_number_of_steps() {
    let folder = scratch("wake-strokes");
    let ratio = |steps: &str| {
        let small =
            ["--prescribed", "--chordwise", "2", "--spanwise", "8", "--no-report", "--force", "--out", "o"];
        let output =
            wingbeat(&folder, &[&["wake", &case("flap_f1.toml"), "--steps", steps], &small[..]].concat());
        assert!(output.status.success(), "{output:?}");
        let summary = fs::read_to_string(folder.join("o/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        summary["down_over_up"]["left"].as_f64().unwrap()
    };
    let [a, b, c] = ["29", "30", "31"].map(ratio);
    assert!((b / a - 1.0).abs() < 5e-3 && (c / b - 1.0).abs() < 5e-3, "{a} {b} {c}");
}

/// A joint that lowers the wing as its angle grows begins the downstroke where the wing is highest too.
#[test]
fn the_downstroke_does_not_depend_on_the_sign_of_the_joint() {
    let folder = scratch("wake-sign");
    let written = wingbeat(&folder, &["new", "robot", "up.toml", "--minimal"]);
    assert!(written.status.success(), "{written:?}");
    let up = fs::read_to_string(folder.join("up.toml")).unwrap();
    let down = up.replace("axis = [1.0, 0.0, 0.0]", "axis = [-1.0, 0.0, 0.0]").replace(
        "{ mean_rad = 0.0989, harmonics = [{ amplitude_rad = 0.9003,",
        "{ mean_rad = -0.0989, harmonics = [{ amplitude_rad = -0.9003,",
    );
    assert_eq!(down.matches("-0.9003").count(), 1);
    fs::write(folder.join("down.toml"), down).unwrap();
    let ratio = |name: &str| {
        let robot = format!("{name}.toml");
        let scenario = format!("{name}_flight.toml");
        let made = wingbeat(&folder, &["new", "scenario", &scenario, "--robot", &robot]);
        assert!(made.status.success(), "{made:?}");
        let flown =
            ["fly", &scenario, "--quiet", "--no-report", "--out", name, "--set", "flight.duration_s=0.5"];
        assert!(wingbeat(&folder, &flown).status.success());
        let small = ["--prescribed", "--chordwise", "2", "--spanwise", "8", "--steps", "24", "--cycles", "1"];
        let out = format!("{name}_wake");
        let output = wingbeat(&folder, &[&["wake", name, "--out", &out], &small[..]].concat());
        assert!(output.status.code() != Some(2), "{output:?}");
        let summary = fs::read_to_string(folder.join(&out).join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        summary["down_over_up"]["left"].as_f64().unwrap()
    };
    let (up, down) = (ratio("up"), ratio("down"));
    assert!((up - down).abs() < 1e-6 * up.abs() && up < -1.0, "{up} {down}");
}

#[test]
fn an_upstroke_that_pushes_down_has_the_other_sign() {
    let folder = scratch("wake-signs");
    let level = ["--set", "wind.incidence_deg=0", "--prescribed", "--chordwise", "4", "--spanwise", "12"];
    let output = wingbeat(
        &folder,
        &[&["wake", &case("flap_f1.toml"), "--out", "a", "--steps", "60", "--no-report"], &level[..]]
            .concat(),
    );
    assert!(output.status.success(), "{output:?}");
    let summary = fs::read_to_string(folder.join("a/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    // A wing that flaps alike upward and downward in a level wind.
    for side in ["left", "right"] {
        let ratio = summary["down_over_up"][side].as_f64().unwrap();
        assert!((ratio + 1.0).abs() < 0.02, "{ratio}");
    }
    let record = read_parquet(&folder.join("a/record.parquet")).unwrap();
    let circulation = record.values("circulation_left").unwrap();
    assert!(circulation.iter().any(|c| *c < -0.01) && circulation.iter().any(|c| *c > 0.01));
}

/// The warnings and what else a wake of a case says of its strips.
fn summary_of(folder: &std::path::Path, case: &str, set: &[&str]) -> serde_json::Value {
    let small =
        ["--prescribed", "--chordwise", "4", "--spanwise", "8", "--steps", "24", "--no-report", "--force"];
    let output = wingbeat(folder, &[&["wake", case, "--out", "o"], &small[..], set].concat());
    assert!(output.status.success(), "{output:?}");
    serde_json::from_str(&fs::read_to_string(folder.join("o/summary.json")).unwrap()).unwrap()
}

#[test]
fn keys_that_change_no_load_of_the_lattice_are_told() {
    let folder = scratch("wake-unheard");
    let told = |set: &[&str]| -> Vec<String> {
        let summary = summary_of(&folder, &case("flap_f2.toml"), set);
        let warnings = summary["warnings"].as_array().unwrap().iter();
        let unheard = warnings.filter(|warning| warning["id"] == "aero.unheard");
        unheard.map(|warning| warning["key"].as_str().unwrap().to_owned()).collect()
    };
    assert!(told(&[]).is_empty() && told(&["--set", "wind.speed_m_s=1.4"]).is_empty());
    let set = [
        "--set",
        "aero.lift_slope_per_rad=4.0",
        "--set",
        "wing.cd0=0.1",
        "--set",
        "numbers={\"surfaces.wing.lift_slope_per_rad\"=4.0}",
    ];
    let keys = told(&set);
    assert_eq!(keys.len(), 3, "{keys:?}");
    for key in ["aero.lift_slope_per_rad", "wing.cd0", "numbers"] {
        assert!(keys.iter().any(|told| told.starts_with(key)), "{key}: {keys:?}");
    }
}

/// An ellipse of 32 strips, the outermost of which are so narrow that their lags need a hundred times these steps.
#[test]
fn strips_that_break_down_say_nothing_of_stall() {
    let folder = scratch("wake-strips");
    let stations: Vec<String> = (0..=30)
        .map(|k| {
            let s = (std::f64::consts::FRAC_PI_2 * f64::from(k) / 30.0).sin();
            let chord = (1.0 - s * s).sqrt().max(0.01) * 1.273_24;
            let (ahead, behind) = (0.25 * chord, -0.75 * chord);
            format!("{{ arc_m = {}, leading_edge_m = {ahead}, trailing_edge_m = {behind} }}", 4.0 * s)
        })
        .collect();
    let text = format!(
        "name = \"ellipse\"\nwing.planform = [{}]\nbody.nose_up_deg.constant = 2.0\nwind = {{ speed_m_s = 10.0, density_kg_m3 = 1.225 }}\n\
         [aero]\npreset = \"full\"\nlaw = \"linear\"\nfull = {{ strips = 32, regularisation_m_s = 0.001 }}\n\
         [time]\nfrequency_hz = 0.2\ncycles = 2\nsteps_per_cycle = 300\n",
        stations.join(", ")
    );
    fs::write(folder.join("ellipse.toml"), text).unwrap();
    let summary = summary_of(&folder, "ellipse.toml", &[]);
    assert!(summary["past_stall"].is_null(), "{}", summary["past_stall"]);
    let warnings = summary["warnings"].to_string();
    assert!(warnings.contains("the strip model that tells what is past stall breaks down"), "{warnings}");
    let whole = summary_of(&folder, "ellipse.toml", &["--set", "time.steps_per_cycle=8000"]);
    assert_eq!(whole["past_stall"], 0.0);
}

#[test]
fn a_prescribed_wake_that_stays_with_the_wing_is_outside() {
    let folder = scratch("wake-stays");
    let case = root().join("cases/flap_f2.toml");
    let run = |more: &[&str]| {
        let mut args =
            vec!["wake", case.to_str().unwrap(), "--force", "--out", "o", "--quiet", "--no-report"];
        args.extend([
            "--chordwise",
            "2",
            "--spanwise",
            "8",
            "--steps",
            "24",
            "--set",
            "reference.speed_m_s=1.5",
        ]);
        args.extend(more);
        wingbeat(&folder, &args)
    };
    let told = |output: &std::process::Output| String::from_utf8_lossy(&output.stderr).into_owned();
    let stays = run(&["--prescribed", "--set", "wind.speed_m_s=0.1"]);
    let words = "a prescribed wake moves with the wind alone";
    assert!(stays.status.code() == Some(3) && told(&stays).contains(words), "{stays:?}");
    for more in [&["--prescribed"][..], &["--set", "wind.speed_m_s=0.1"]] {
        assert!(!told(&run(more)).contains(words), "{more:?}");
    }
    let cambered = run(&["--set", "aero.zero_lift_angle_deg=-3"]);
    let words = "zero_lift_angle_deg of `aero` or of a section = -3: allowed is 0";
    assert!(cambered.status.code() == Some(2) && told(&cambered).contains(words), "{cambered:?}");
}
