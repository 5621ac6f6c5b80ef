//! `wingbeat plan` as a user meets it: a gait of least power, its replays, messages, exit codes.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use wingbeat::scenario::Scenario;
use wingbeat_io::read_parquet;

use crate::{entries, root, scratch, wingbeat};

/// Plans a smooth variant of the gait on one coarse mesh.
fn plan(folder: &Path, keys: &[&str]) -> Output {
    plan_with(folder, keys, &[])
}

fn plan_with(folder: &Path, keys: &[&str], more: &[&str]) -> Output {
    let scenario = root().join("scenarios/least_power_gait.toml");
    let mut arguments = vec!["plan", scenario.to_str().unwrap(), "--out", "a"];
    let short = [
        "storage=1.0",
        "up_n=0.08",
        "frequency_hz=[3.5, 3.5]",
        "nose_up_deg=[15.0, 15.0]",
        "effort_w=0.3",
        "intervals=16",
        "meshes=1",
        "tolerance=1e-2",
    ];
    let keys: Vec<String> = short.iter().chain(keys).map(|key| format!("plan.least_power.{key}")).collect();
    arguments.extend(keys.iter().flat_map(|key| ["--set", key]));
    arguments.extend(more);
    wingbeat(folder, &arguments)
}

fn summary(folder: &Path) -> Value {
    json(folder, "summary.json")
}

fn json(folder: &Path, name: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join(name)).unwrap()).unwrap()
}

/// That these limits were judged, and met.
fn met(summary: &Value, limits: &[&str]) {
    for limit in limits {
        let judged = summary["judged"].as_array().unwrap();
        let found = judged.iter().find(|judged| judged["id"] == *limit);
        assert!(found.is_some_and(|judged| judged["met"] == true), "{limit}: {judged:?}");
    }
}

/// Reads a plan back and holds it against the model: defects from states and inputs, multipliers against limits. The largest
/// defect may be `within`.
fn reads_back(folder: &Path, within: f64) {
    let points = read_parquet(&folder.join("plan.parquet")).unwrap();
    let constants = json(folder, "plan.json");
    let all = |key: &str| constants[key].as_array().unwrap().clone();
    let number = |value: &Value, key: &str| value[key].as_f64();
    let parameters: Vec<f64> = all("unknowns")[2..].iter().map(|p| number(p, "value").unwrap()).collect();
    let scenario = Scenario::load(&folder.join("scenario.toml"), &[]).unwrap();
    let defects = scenario.plan_defects(&points, &parameters).unwrap();
    let worst = defects.iter().flatten().fold(0.0_f64, |m, d| m.max(d.abs()));
    assert!(worst < within && defects.len() == points.rows(), "{worst:e}");
    let intervals = number(&constants, "intervals").unwrap() as usize;
    let rows = number(&constants, "rows_per_interval").unwrap() as usize;
    assert_eq!(points.rows(), intervals * rows + 1);
    // A state that is moved is seen.
    let mut columns = points.clone().into_columns();
    columns[2].values[1] += 0.1;
    let moved = wingbeat::simulate::Record::new(columns, 0).unwrap();
    let seen = scenario.plan_defects(&moved, &parameters).unwrap();
    assert!(seen[1].iter().any(|d| d.abs() > 0.05), "{:?}", seen[1]);
    // Multipliers push against the limits that hold, and against no other.
    for column in points.columns() {
        let Some(limit) = points.values(&format!("limit_{}", column.name)) else { continue };
        assert!(column.values.iter().chain(limit).all(|v| v.is_finite()), "{}", column.name);
        let range = column.high - column.low;
        if !range.is_finite() || range <= 0.0 {
            continue;
        }
        let held = |v: f64| (column.high - v).min(v - column.low) < 0.02 * range;
        let largest = limit.iter().fold(0.0_f64, |m, z| m.max(z.abs()));
        // Where it starts a state is given, and its multiplier is what holding it there costs.
        let given = usize::from(!column.name.starts_with("command_"));
        for (value, multiplier) in column.values.iter().zip(limit).skip(given) {
            let pushes = multiplier.abs() > 0.2 * largest && largest > 1e-3;
            assert!(!pushes || held(*value), "{}: {value} with {multiplier}", column.name);
            let upper = column.high - value < value - column.low;
            assert!(!pushes || (*multiplier > 0.0) == upper, "{}: {value} with {multiplier}", column.name);
        }
    }
    for end in all("ends") {
        let value = number(&end, "value").unwrap();
        let [low, high] = ["low", "high"].map(|key| number(&end, key));
        let off = low.map_or(0.0, |low| low - value).max(high.map_or(0.0, |high| value - high));
        assert!(off < within, "{end}");
    }
}

#[test]
fn a_gait_leaves_a_whole_folder_and_the_tethered_wing_bears_its_force() {
    let folder = scratch("plan-gait");
    let output = plan(&folder, &[]);
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("replayed from rest") && text.contains("own gait"), "{text}");
    // Each gait on the way is a stage of its own.
    let meshes = String::from_utf8(output.stderr).unwrap();
    for stage in ["stage 1, mesh 1 of 16 intervals: ", "stage 2, mesh 1 of 16 intervals: "] {
        assert_eq!(meshes.matches(stage).count(), 1, "{meshes}");
    }
    let names = [
        "figures",
        "joints.csv",
        "manifest.json",
        "plan.json",
        "plan.parquet",
        "record.parquet",
        "report.html",
        "scenario.toml",
        "summary.json",
        "tether.toml",
    ];
    assert_eq!(entries(&folder.join("a")), names);
    let page = fs::read_to_string(folder.join("a/report.html")).unwrap();
    assert!(!page.contains("no picture in space"), "the gait is drawn");
    let figures = ["commands.png", "commands.svg", "forces.png", "forces.svg", "gait.png", "gait.svg"];
    assert_eq!(entries(&folder.join("a/figures")), figures);
    let planned = summary(&folder.join("a"));
    assert_eq!((&planned["status"], &planned["reason"]), (&Value::from("ok"), &Value::Null));
    met(
        &planned,
        &["plan.violation", "plan.residual", "plan.interval_error", "plan.replayed_force_fraction"],
    );
    let listed = json(&folder.join("a"), "manifest.json").to_string();
    assert!(listed.contains("plan.parquet") && listed.contains("plan.json"), "{listed}");
    reads_back(&folder.join("a"), 1e-4);
    assert!(planned["plan"]["up_n"].as_f64().unwrap() > 0.0799);

    // The same motion of the wing alone, by the path of `tether`; the drag of the body is added by hand.
    let output = wingbeat(&folder, &["tether", "a/tether.toml", "--out", "b", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let tethered = summary(&folder.join("b"));
    let mean = |name: &str| {
        let cycle = tethered["cycle"].as_array().unwrap();
        cycle.iter().find(|column| column["name"] == name).unwrap()["mean"].as_f64().unwrap()
    };
    let pitch = -15_f64.to_radians();
    let body = -0.5 * 1.225 * 0.002 * (2.0 * pitch.cos()).powi(2);
    let (up, forward) =
        (mean("force_wind_lift") - body * pitch.sin(), body * pitch.cos() - mean("force_wind_drag"));
    let replay = |name: &str| planned["replay"][name].as_f64().unwrap();
    assert!((up - replay("up_n")).abs() < 5e-5, "{up} {}", replay("up_n"));
    assert!((forward - replay("forward_n")).abs() < 5e-5, "{forward} {}", replay("forward_n"));
}

#[test]
fn a_force_out_of_reach_is_named_in_a_folder_that_is_kept() {
    let folder = scratch("plan-reach");
    let output = plan(&folder, &["up_n=3.0", "intervals=3"]);
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.contains("infeasible: mean upward force misses its limits"), "{text}");
    // The nodes of the best point that was met are kept; it is not replayed.
    let names =
        ["manifest.json", "plan.json", "plan.parquet", "report.html", "scenario.toml", "summary.json"];
    assert_eq!(entries(&folder.join("a")), names);
    let summary = summary(&folder.join("a"));
    assert_eq!(summary["status"], "not_found");
    let reason = summary["reason"].as_str().unwrap();
    assert!(reason.contains("mean upward force") && reason.contains("limits.plan.violation"), "{reason}");
    assert!(summary["objective_w"].is_number() && summary["replay"].is_null(), "{summary}");
}

#[test]
fn a_plan_cut_off_by_its_iterations_is_kept_with_its_status() {
    let folder = scratch("plan-cut");
    let output = plan_with(&folder, &["iterations=12"], &["--set", "limits.plan.violation=1e-3"]);
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let found = summary(&folder.join("a"));
    let judged = found["judged"].as_array().unwrap();
    let violation = judged.iter().find(|judged| judged["id"] == "plan.violation").unwrap();
    assert_eq!((&violation["overridden"], &violation["limit"]), (&true.into(), &1e-3.into()));
    assert_eq!(found["iterations"], 12);
    let reason = found["reason"].as_str().unwrap();
    assert!(["not_resolved", "not_found"].contains(&found["status"].as_str().unwrap()), "{found}");
    assert!(reason.contains("iteration limit"), "{reason}");
    for key in ["objective_w", "violation", "residual", "interval_error"] {
        assert!(found[key].is_number(), "{key}: {found}");
    }
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(!text.contains("NaN") && !text.contains("inf,"), "{text}");
    assert!(text.contains("limit overridden: plan.violation = 0.001"), "{text}");
    assert!(read_parquet(&folder.join("a/plan.parquet")).unwrap().rows() == 17);
    // A limit of time counts the processor: next to none, and the same answer in kind.
    let output = plan_with(&folder, &["time_limit_s=1e-3"], &["--force"]);
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let found = summary(&folder.join("a"));
    assert!(found["reason"].as_str().unwrap().contains("time limit"), "{found}");
    assert!(found["objective_w"].is_number(), "{found}");
}

#[test]
#[ignore = "long: cargo xtask long tests"]
fn a_gait_that_its_limits_refuse_ends_with_their_names() {
    let folder = scratch("plan-limits");
    let limits = ["--set", "limits.trim.power_w_kg=1.0", "--set", "limits.plan.violation=1e-3"];
    let output = plan_with(&folder, &[], &limits);
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let found = summary(&folder.join("a"));
    assert_eq!(found["status"], "outside");
    assert!(found["reason"].as_str().unwrap().contains("trim.power_w_kg"), "{found}");
    let judged = found["judged"].as_array().unwrap();
    let of = |id: &str| judged.iter().find(|judged| judged["id"] == id).unwrap().clone();
    assert_eq!(
        (&of("plan.violation")["overridden"], &of("plan.violation")["limit"]),
        (&true.into(), &1e-3.into())
    );
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("limit overridden: trim.power_w_kg = 1"), "{text}");
    assert!(entries(&folder.join("a")).contains(&"record.parquet".into()));
}

#[test]
fn a_roll_in_is_flown_judged_and_read_back() {
    let folder = scratch("plan-roll-in");
    let scenario = root().join("scenarios/roll_in.toml");
    let short = ["plan.roll_in.meshes=1", "plan.roll_in.tolerance=1e-2", "plan.roll_in.intervals=10"];
    let mut arguments = vec!["plan", scenario.to_str().unwrap(), "--out", "a"];
    arguments.extend(short.iter().flat_map(|key| ["--set", key]));
    let output = wingbeat(&folder, &arguments);
    assert!(output.status.success(), "{output:?}");
    let found = summary(&folder.join("a"));
    assert_eq!(found["status"], "ok", "{found}");
    met(&found, &["plan.flown_attitude_deg", "plan.speed_change_fraction", "flight.altitude_m"]);
    reads_back(&folder.join("a"), 1e-4);
}

/// Half a turn on a coarse mesh, flown again from the file that the plan leaves.
#[test]
fn a_reorientation_is_planned_and_its_commands_are_flown_again() {
    let folder = scratch("plan-reorientation");
    let scenario = root().join("scenarios/reorientation.toml");
    let short = ["plan.reorientation.meshes=1", "plan.reorientation.tolerance=1e-2"];
    let mut arguments = vec!["plan", scenario.to_str().unwrap(), "--out", "a"];
    arguments.extend(short.iter().flat_map(|key| ["--set", key]));
    let output = wingbeat(&folder, &arguments);
    assert!(output.status.success(), "{output:?}");
    let found = summary(&folder.join("a"));
    assert_eq!(found["status"], "ok", "{found}");
    let momentum = "flight.angular_momentum_kg_m2_s";
    met(&found, &["plan.flown_attitude_deg", "flight.crossing_fraction", momentum]);
    assert!(found["turned_deg"].as_f64().unwrap() > 150.0, "{found}");
    assert!(found["duration_s"].as_f64().unwrap() < 0.5, "{found}");
    reads_back(&folder.join("a"), 1e-4);
    let output = wingbeat(&folder, &["fly", "a/flight.toml", "--out", "b", "--no-report"]);
    assert!(output.status.success(), "{output:?}");
    met(&summary(&folder.join("b")), &[momentum]);
    let [plan, flown] = ["a", "b"].map(|run| read_parquet(&folder.join(run).join("record.parquet")).unwrap());
    let [planned_at, flown_at] = [&plan, &flown].map(|record| record.values("t").unwrap());
    let mut together = 0;
    for (i, t) in planned_at.iter().enumerate() {
        let Some(k) = flown_at.iter().position(|other| (other - t).abs() < 1e-9) else { continue };
        together += 1;
        for name in ["quat_w", "quat_y", "p_WB_z", "displacement_stroke"] {
            let [plan, flown] =
                [(&plan, i), (&flown, k)].map(|(record, row)| record.values(name).unwrap()[row]);
            assert!((plan - flown).abs() < 1e-12, "{name} at {t}: {plan} {flown}");
        }
    }
    assert!(together > 20, "{together} instants are in both records");
    for (key, said) in [
        ("plan.reorientation.rotation_deg=[0.0, 0.0, 0.0]", "plan.reorientation.rotation_deg"),
        ("plan.reorientation.rotation_deg=[300.0, 300.0, 0.0]", "plan.reorientation.rotation_deg"),
        (
            "plan.reorientation.guess.waves=[{ input = \"stroke\", amplitude = 1.0, phase_rad = 0.0 }]",
            "plan.reorientation.guess.waves[0].input",
        ),
        ("plan.reorientation.guess.frequency_hz=0.0", "plan.reorientation.guess.frequency_hz"),
        ("air.density_kg_m3=-1.0", "air.density_kg_m3"),
    ] {
        let output = wingbeat(&folder, &["plan", scenario.to_str().unwrap(), "--out", "c", "--set", key]);
        assert_eq!(output.status.code(), Some(2), "{key}: {output:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(said), "{key}: {text}");
    }
}

#[test]
fn bad_settings_are_refused_in_one_message_and_leave_nothing() {
    let folder = scratch("plan-refused");
    for (key, said) in [
        ("frequency_hz=[5.0, 4.0]", "plan.least_power.frequency_hz"),
        ("frequency_hz=[0.0, 4.0]", "plan.least_power.frequency_hz"),
        ("nose_up_deg=[0.0, 95.0]", "plan.least_power.nose_up_deg"),
        ("storage=1.5", "plan.least_power.storage"),
        ("order=5", "plan.least_power.order"),
        ("effort_w=0.0", "plan.least_power.effort_w"),
        ("intervals=0", "plan.least_power.intervals"),
        ("iterations=0", "plan.least_power.iterations"),
        ("time_limit_s=0.0", "plan.least_power.time_limit_s"),
        ("trim_within_n_m=-1.0", "plan.least_power.trim_within_n_m"),
        ("upward_n=1.0", "upward_n"),
    ] {
        let output = plan(&folder, &[key]);
        assert_eq!(output.status.code(), Some(2), "{key}: {output:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(said), "{key}: {text}");
        assert!(entries(&folder).is_empty(), "{key}");
    }
}
