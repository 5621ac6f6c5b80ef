//! `wingbeat sweep`: the same rows whether or not it was interrupted.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output};
use std::time::Duration;

use crate::{root, scratch};

/// A sweep of short turns.
fn written(folder: &Path, flights: usize, lanes: bool) {
    let scenario = root().join("scenarios/banking_turn.toml");
    let text = format!(
        "name = \"small\"\nscenario = {:?}\nruns = {flights}\nlanes = {lanes}\n\
         [hold]\nroll_within_deg = 5.0\npitch_within_deg = 10.0\n\
         [[draws]]\nkey = \"mismatch.mass\"\nlow = 0.9\nhigh = 1.1\n\
         [[draws]]\nkey = \"flight.duration_s\"\nlow = 0.3\nhigh = 0.3\n\
         [[draws]]\nkey = \"goal.settle_s\"\nlow = 0.0\nhigh = 0.0\n",
        scenario
    );
    fs::write(folder.join("small.toml"), text).unwrap();
}

fn command(folder: &Path, out: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wingbeat"));
    command.args(["sweep", "small.toml", "--out", out]).current_dir(folder);
    command
}

fn sweep(folder: &Path, out: &str) -> Output {
    command(folder, out).output().unwrap()
}

fn flights(folder: &Path, out: &str) -> String {
    fs::read_to_string(folder.join(out).join("flights.csv")).unwrap()
}

#[cfg(unix)]
fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

#[cfg(unix)]
#[test]
fn an_interrupted_sweep_goes_on_to_the_same_rows() {
    let told = goes_on("sweep-sweep", 6, false);
    assert!(told.contains("of 6 flights") && !told.contains("lanes"), "{told}");
}

#[cfg(unix)]
#[test]
fn flights_in_lanes_go_on_to_the_same_rows_in_other_company() {
    // Two batches for each of the cores; what is left is made in other company than before.
    let flights = 8 * std::thread::available_parallelism().map_or(1, usize::from) + 2;
    let told = goes_on("sweep-lanes", flights, true);
    assert!(told.contains(&format!("{flights} flights in lanes: on average ")), "{told}");
}

/// Interrupts a sweep and goes on; what a whole one says.
#[cfg(unix)]
fn goes_on(name: &str, count: usize, lanes: bool) -> String {
    let folder = scratch(name);
    written(&folder, count, lanes);
    let output = sweep(&folder, "whole");
    assert!(output.status.success(), "{output:?}");
    for name in ["sweep.toml", "summary.json", "manifest.json", "record.parquet", "figures/robustness.png"] {
        assert!(folder.join("whole").join(name).exists(), "{name}");
    }

    let mut child = command(&folder, "parts").spawn().unwrap();
    let log = folder.join(".parts.partial/flights.log");
    while fs::read_to_string(&log).unwrap_or_default().lines().count() < 2 {
        std::thread::sleep(Duration::from_millis(2));
    }
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!folder.join("parts").exists());
    let done = fs::read_to_string(&log).unwrap();
    assert!(done.lines().count() >= 2);

    assert!(sweep(&folder, "parts").status.success());
    assert_eq!(flights(&folder, "parts"), flights(&folder, "whole"));
    for row in done.lines() {
        assert!(flights(&folder, "parts").contains(row), "{row} was flown again");
    }
    String::from_utf8(output.stdout).unwrap()
}

/// A sweep of glides, of which those with a huge drag break down.
fn glides(folder: &Path, drags: &str, more: &str) {
    let scenario = root().join("scenarios/glide.toml");
    let text = format!(
        "name = \"small\"\nscenario = {scenario:?}\nsampling = \"grid\"\n\
         [hold]\nroll_within_deg = 5.0\npitch_within_deg = 90.0\n\
         [[draws]]\nkey = \"robot.body.drag_area_m2[2]\"\nvalues = {drags}\n\
         [[draws]]\nkey = \"flight.duration_s\"\nlow = 0.1\nhigh = 0.12\npoints = 3\n{more}"
    );
    fs::write(folder.join("small.toml"), text).unwrap();
}

fn summary(folder: &Path, out: &str) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(folder.join(out).join("summary.json")).unwrap()).unwrap()
}

#[test]
fn flights_that_broke_down_are_counted_and_in_no_number() {
    let folder = scratch("sweep-broken");
    glides(&folder, "[0.002, 0.003, 1e6]", "");
    let output = sweep(&folder, "a");
    assert!(output.status.success(), "{output:?}");
    let found = summary(&folder, "a");
    assert_eq!((&found["status"], &found["ending"]), (&"ok".into(), &"incomplete".into()));
    assert_eq!((&found["flights"], &found["completed"], &found["held"]), (&9.into(), &6.into(), &6.into()));
    // A tenth of a second says nothing of the weight.
    assert_eq!(found["statuses"], serde_json::json!({ "not_judged": 6, "failed": 3 }));
    assert_eq!((&found["counted"]["pitch_max_error"], &found["clear"]), (&6.into(), &6.into()));
    assert_eq!(found["end_points"][0]["completed"], 6);
    let warned = found["warnings"].as_array().unwrap().iter().map(|warning| &warning["id"]);
    assert_eq!(warned.collect::<Vec<_>>(), ["sweep.failed_fraction", "sweep.unjudged_fraction"]);
    let most = found["pitch_max_error_deg"][2].as_f64().unwrap();
    assert!(most > 5.0 && most < 7.0, "{most}");
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(
        told.contains("6 of 9 flights completed: 6 not_judged, 3 failed") && !told.contains("NaN"),
        "{told}"
    );
    // What broke down has no numbers in the rows either.
    let rows = flights(&folder, "a");
    let broken: Vec<&str> = rows.lines().filter(|row| row.split(',').nth(5) == Some("8")).collect();
    assert!(broken.len() == 3 && broken.iter().all(|row| row.matches("NaN").count() == 14), "{rows}");
}

#[test]
fn a_sweep_is_judged_by_its_limits() {
    let folder = scratch("sweep-judged");
    for (out, drags, limit, status) in [
        ("a", "[0.002, 1e6, 9e5]", "", "not_resolved"),
        ("b", "[1e6, 9e5]", "", "failed"),
        ("c", "[0.002, 0.003]", "[limits]\nsweep.held_fraction = 1.0\n", "ok"),
        ("d", "[0.002, 1e6]", "[limits]\nsweep.held_fraction = 0.9\n", "off_target"),
    ] {
        glides(&folder, drags, limit);
        let output = sweep(&folder, out);
        assert_eq!(output.status.code(), Some(if status == "ok" { 0 } else { 3 }), "{out}: {output:?}");
        assert_eq!(summary(&folder, out)["status"], status, "{out}");
        assert!(!String::from_utf8(output.stdout).unwrap().contains("NaN"), "{out}");
        // Off until a document gives it.
        let judged = summary(&folder, out)["judged"].to_string();
        assert_eq!(judged.contains("sweep.held_fraction"), !limit.is_empty(), "{out}: {judged}");
    }
    let of = summary(&folder, "b");
    assert!(
        of["pitch_max_error_deg"][0].is_null() && of["end_points"][0]["distance_x_m"][1].is_null(),
        "{of}"
    );
    glides(&folder, "[0.002]", "[limits]\nsweep.helt_fraction = 0.9\n");
    let output = sweep(&folder, "e");
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && message.contains("sweep.held_fraction"), "{message}");
}

#[test]
fn flights_that_their_own_verdict_refuses_are_neither_held_nor_used() {
    let folder = scratch("sweep-refused");
    glides(&folder, "[0.002, 0.003]", "");
    let with = |limits: &str| {
        let text = fs::read_to_string(folder.join("small.toml")).unwrap();
        fs::write(folder.join("small.toml"), format!("set = [{limits}]\n{text}")).unwrap();
    };
    with("'limits.flight.steps_lost_m=1e-30'");
    let output = sweep(&folder, "a");
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let found = summary(&folder, "a");
    assert_eq!(
        (&found["status"], &found["held"], &found["usable"]),
        (&"not_resolved".into(), &0.into(), &0.into())
    );
    assert!(found["reason"].as_str().unwrap().contains("sweep.usable_runs"), "{found}");
}

#[test]
fn a_sweep_of_a_rejected_fit_says_so() {
    let folder = scratch("sweep-fit");
    let fit = "[scenario.mismatch]\nnumbers = { verdict = { status = \"suspect_data\" } }\n";
    let base = root().join("scenarios/glide.toml");
    let text = format!(
        "name = \"small\"\nruns = 2\n[hold]\nroll_within_deg = 5.0\npitch_within_deg = 90.0\n\
         [[draws]]\nkey = \"flight.duration_s\"\nvalues = [0.1, 0.12]\n[scenario]\nbase = {base:?}\n{fit}"
    );
    fs::write(folder.join("small.toml"), text).unwrap();
    let output = sweep(&folder, "a");
    assert!(output.status.success(), "{output:?}");
    let warned = summary(&folder, "a")["warnings"].clone();
    // Each of its runs says so too, which the sweep counts.
    assert!(warned[0]["id"] == "sweep.warned_fraction" && warned[0]["size"] == 1.0, "{warned}");
    assert!(warned[1]["id"] == "sweep.unjudged_fraction" && warned[1]["size"] == 1.0, "{warned}");
    assert!(warned[2]["id"] == "fit.rejected" && warned[2]["key"] == "mismatch.numbers", "{warned}");
}

#[test]
fn a_bad_sweep_is_one_message() {
    let folder = scratch("sweep-bad_sweep");
    written(&folder, 0, false);
    let output = sweep(&folder, "out");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    assert!(message.starts_with("error: small.toml:3: runs = 0: allowed is 1 to 1000000"), "{message}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
}

#[test]
fn a_case_is_swept_over_a_grid_with_its_table() {
    let folder = scratch("sweep-case");
    let row = |i: u32| {
        let phase = f64::from(i) / 40.0;
        format!("{phase},{}\n", (std::f64::consts::TAU * phase).sin())
    };
    fs::write(folder.join("s.csv"), (0..=40).map(row).fold("phase,a\n".to_owned(), |a, b| a + &b)).unwrap();
    let text = fs::read_to_string(root().join("cases/flap_f2.toml")).unwrap();
    let table = "table = { file = \"s.csv\", column = \"a\", by = \"phase\", scale = 35.0 }";
    let text = text.replace("fourier = { sin = [35.0] }", table).replace("= 192", "= 32");
    fs::write(folder.join("flap.toml"), text).unwrap();
    let draws = "[[draws]]\nkey = \"time.frequency_hz\"\nlow = 2.0\nhigh = 4.0\npoints = 3\n\
         [[draws]]\nkey = \"wing.hinges[0].angle_deg.table.scale\"\nlow = 10.0\nhigh = 30.0\npoints = 2\n";
    let head = "name = \"small\"\ncase = \"flap.toml\"\nsampling = \"grid\"\n";
    fs::write(folder.join("small.toml"), format!("{head}{draws}")).unwrap();
    let output = sweep(&folder, "a");
    assert!(output.status.success(), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("6 of 6 runs completed: 6 ok"), "{output:?}");
    let told = summary(&folder, "a");
    assert_eq!((&told["status"], &told["completed"], &told["usable"]), (&"ok".into(), &6.into(), &6.into()));
    assert_eq!(told["measures"][0]["counted"], 6);
    let run = folder.join("a");
    for name in ["sweep.toml", "s.csv", "record.parquet", "figures/map.png"] {
        assert!(run.join(name).is_file(), "{name}");
    }
    let rows = fs::read_to_string(run.join("runs.csv")).unwrap();
    let rows: Vec<Vec<f64>> =
        rows.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!((rows.len(), rows[3][1], rows[3][2]), (6, 3.0, 30.0));
    // More frequency or more amplitude takes more power.
    assert!(rows[5][8] > rows[3][8] && rows[5][8] > rows[4][8], "{rows:?}");

    fs::write(folder.join("small.toml"), fs::read_to_string(run.join("sweep.toml")).unwrap()).unwrap();
    let again = sweep(&folder, "again");
    assert!(again.status.success(), "{again:?}");
    let of = |out: &str| fs::read_to_string(folder.join(out).join("runs.csv")).unwrap();
    assert_eq!(of("a"), of("again"));

    for (text, part) in [
        (format!("{head}runs = 3\n{draws}"), "none of a grid"),
        (format!("{head}{}", draws.replace("points = 2\n", "")), "the number of values of a grid"),
        (format!("{head}{}", draws.replace("high = 4.0", "high = 2e9")), "draws[0].high"),
        (format!("{head}scenario = \"x.toml\"\n{draws}"), "x.toml"),
        (head.replace("grid", "random") + &draws.replace("points", "# points"), "runs = 0"),
        (head.replace("grid", "random") + "runs = 6\ndraws = []\n", "without a draw all runs are equal"),
    ] {
        fs::write(folder.join("small.toml"), text).unwrap();
        let output = sweep(&folder, "bad");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(part), "{part}: {message}");
    }
}

#[test]
fn a_search_keeps_its_candidates_and_says_what_its_best_misses() {
    let folder = scratch("sweep-search");
    let scenario = root().join("scenarios/paper_turn.toml");
    let text = format!(
        "name = \"small\"\nscenario = {scenario:?}\nruns = 4\n[search]\npopulation = 4\nflights = [[\"flight.duration_s=0.05\"]]\n\
         goals = [{{ key = \"distance_x_m\", low = 1.0 }}]\n\
         [[draws]]\nkey = \"controller.weights.roll\"\nlow = 4.0\nhigh = 6.0\n\
         [[draws]]\nkey = \"controller.weights.pitch\"\nlow = 1.0\nhigh = 2.0\n"
    );
    fs::write(folder.join("small.toml"), text).unwrap();
    let output = sweep(&folder, "a");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert!(told.contains("not_found"), "{told}");
    let table = fs::read_to_string(folder.join("a/candidates.csv")).unwrap();
    assert_eq!(table.lines().count(), 5, "{table}");
    assert!(table.lines().next().unwrap().contains("flight_0_status"), "{table}");
    let summary = fs::read_to_string(folder.join("a/summary.json")).unwrap();
    assert!(summary.contains("search.missed") && summary.contains("distance_x_m"), "{summary}");
    for name in ["best.toml", "figures/search.png", "record.parquet", "sweep.toml", "manifest.json"] {
        assert!(folder.join("a").join(name).is_file(), "{name}");
    }
    assert!(!folder.join("a/candidates.log").exists());
}

#[test]
fn a_draw_that_changes_nothing_is_told() {
    let folder = scratch("sweep-in-vain");
    let told = |set: &str| {
        let text = format!(
            "name = \"s\"\ncase = {:?}\nsampling = \"grid\"\nset = ['time.cycles=1', {set}]\n\
             [[draws]]\nkey = \"wind.density_kg_m3\"\nlow = 0.9\nhigh = 1.3\npoints = 3\n\
             [[draws]]\nkey = \"wind.speed_m_s\"\nlow = 6.0\nhigh = 7.0\npoints = 2\n",
            root().join("cases/flap_f2.toml")
        );
        fs::write(folder.join("small.toml"), text).unwrap();
        let _ = fs::remove_dir_all(folder.join("o"));
        let answer = sweep(&folder, "o");
        assert!(answer.status.code() != Some(2), "{}", String::from_utf8_lossy(&answer.stderr));
        let summary = fs::read_to_string(folder.join("o/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        let warnings = summary["warnings"].as_array().unwrap().iter();
        warnings.map(|warning| (warning["id"].clone(), warning["key"].clone())).collect::<Vec<_>>()
    };
    let twice = ("numbers.given_twice".into(), "wind.density_kg_m3".into());
    let unheard = ("sweep.unheard".into(), "draws[0].key".into());
    let found = told(r#"'numbers={"air.density_kg_m3"=1.1}'"#);
    assert!(found.contains(&twice) && found.contains(&unheard), "{found:?}");
    assert!(!found.iter().any(|(_, key)| *key == "draws[1].key"), "{found:?}");
    let found = told("");
    assert!(!found.contains(&twice) && !found.iter().any(|(id, _)| *id == "sweep.unheard"), "{found:?}");
}

#[test]
fn draws_at_random_of_which_none_does_anything_are_told() {
    let folder = scratch("sweep-all-in-vain");
    let drawn =
        |key: &str, low: f64, high: f64| format!("[[draws]]\nkey = {key:?}\nlow = {low}\nhigh = {high}\n");
    let text = format!(
        "name = \"s\"\ncase = {:?}\nruns = 4\nset = ['time.cycles=1', 'numbers={{\"air.density_kg_m3\"=1.1}}']\n{}{}",
        root().join("cases/flap_f2.toml"),
        drawn("wind.density_kg_m3", 0.9, 1.3),
        drawn("aero.paper.regularisation_m_s", 0.01, 0.02)
    );
    fs::write(folder.join("small.toml"), text).unwrap();
    let answer = sweep(&folder, "o");
    assert!(answer.status.code() != Some(2), "{}", String::from_utf8_lossy(&answer.stderr));
    let found = summary(&folder, "o");
    let told =
        found["warnings"].as_array().unwrap().iter().filter(|warning| warning["id"] == "sweep.unheard");
    assert_eq!(told.map(|warning| &warning["key"]).collect::<Vec<_>>(), ["draws[0].key", "draws[1].key"]);
}

/// A sweep of the banking turn, whose means are from `settle` on in a flight of `duration`, s.
fn windows(folder: &Path, draw: &str, duration: f64, settle: f64) {
    let scenario = root().join("scenarios/banking_turn.toml");
    let text = format!(
        "name = \"small\"\nscenario = {scenario:?}\nruns = 3\nset = [\"flight.duration_s={duration}\", \"goal.settle_s={settle}\"]\n\
         [hold]\nroll_within_deg = 10.0\npitch_within_deg = 15.0\n[[draws]]\nkey = \"mismatch.mass\"\n{draw}\n"
    );
    fs::write(folder.join("small.toml"), text).unwrap();
}

#[test]
fn flights_that_are_all_alike_have_no_confidence_interval() {
    let folder = scratch("sweep-alike");
    for (out, draw, alike) in [("a", "values = [1.0]", true), ("b", "low = 0.95\nhigh = 1.05", false)] {
        windows(&folder, draw, 0.3, 0.0);
        let output = sweep(&folder, out);
        let told = String::from_utf8(output.stdout).unwrap();
        let found = summary(&folder, out);
        assert_eq!((&found["held"], &found["share_held"]), (&3.into(), &1.0.into()), "{found}");
        assert_eq!(found["share_held_low"].is_null(), alike, "{found}");
        assert_eq!(found["share_held_high"].is_null(), alike, "{found}");
        assert_eq!(told.contains("95 % confidence"), !alike, "{told}");
        assert_eq!(told.contains("all 3 flights agree to the last digit and count as one"), alike, "{told}");
        let warned = found["warnings"].as_array().unwrap();
        assert_eq!(warned.iter().any(|warning| warning["id"] == "sweep.alike"), alike, "{found}");
    }
}

#[test]
fn a_window_of_one_record_or_none_is_not_held() {
    let folder = scratch("sweep-window");
    for (out, settle, resolved) in [("one", 0.3, false), ("none", 0.4, false), ("some", 0.1, true)] {
        windows(&folder, "low = 0.95\nhigh = 1.05", 0.3, settle);
        let output = sweep(&folder, out);
        assert_eq!(output.status.code(), Some(0), "{out}: {output:?}");
        let found = summary(&folder, out);
        let missing = if resolved { 0 } else { 3 };
        assert_eq!(
            (&found["held"], &found["held_not_judged"]),
            (&(3 - missing).into(), &missing.into()),
            "{found}"
        );
        assert_eq!(found["share_held"].is_null(), !resolved, "{found}");
        assert_eq!(found["status"] == "not_judged", !resolved, "{found}");
        let said = String::from_utf8(output.stdout).unwrap();
        assert_eq!(said.contains("one record or none is left"), !resolved, "{said}");
        assert_eq!(flights(&folder, out).lines().nth(1).unwrap().split(',').nth(2) == Some("NaN"), !resolved);
    }
}
