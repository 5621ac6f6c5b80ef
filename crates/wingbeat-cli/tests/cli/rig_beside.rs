//! What stands beside measured wrenches: the model on the measured motion, and what of a file cannot be right.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::{root, scratch};
use serde_json::Value;
use wingbeat::simulate::{Column, Record};
use wingbeat_io::{read_parquet, write_parquet};

fn rig(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wingbeat"));
    command.arg("rig").args(arguments).current_dir(folder).output().unwrap()
}

fn run() -> String {
    root().join("rigs/runs/roll15_speed08.toml").to_string_lossy().into_owned()
}

fn summary(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

/// What is done to the columns of a file.
type Change<'a> = &'a dyn Fn(&mut [Vec<f64>]);

/// The samples of the simulated bench as a file of another program: time, cell, encoder, joints without rates.
fn foreign(record: &Record, path: &Path, change: Change) {
    let names: Vec<String> = ["t", "Fx", "Fy", "Fz", "Tx", "Ty", "Tz", "phase"].map(String::from).into();
    let names: Vec<String> = names.into_iter().chain((1..=6).map(|j| format!("q{j}"))).collect();
    let mut values: Vec<Vec<f64>> = names.iter().map(|name| record.values(name).unwrap().to_vec()).collect();
    change(&mut values);
    let column = |(name, values): (&String, Vec<f64>)| {
        let unit = record.column(name).unwrap().unit.clone();
        Column { values, ..Column::new(name, unit, "") }
    };
    let columns = names.iter().zip(values).map(column).collect();
    write_parquet(path, &Record::new(columns, 0).unwrap()).unwrap();
}

/// The cell at 1.75 kHz in place of 7: what a bench costs is its samples.
fn coarse(folder: &Path, arguments: &[&str]) -> Output {
    let cell = ["--set", "rig.cell.rate_hz=1750", "--set", "rig.cell.filter_hz=500"];
    rig(folder, &[arguments, &cell].concat())
}

/// The bench simulated once: its folder.
fn simulated(name: &str) -> (PathBuf, Record) {
    let folder = scratch(name);
    let output = coarse(&folder, &["simulate", &run(), "--out", "sim", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let record = read_parquet(&folder.join("sim/roll15_speed08/record.parquet")).unwrap();
    (folder, record)
}

#[test]
fn the_simulation_beside_a_bench_is_another_model_on_the_measured_motion() {
    let (folder, record) = simulated("rig-beside");
    let output = rig(&folder, &["process", "sim", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let own = summary(&folder.join("sim/processed"));
    let of = &own["runs"]["roll15_speed08"];
    let measured = of["frequency_hz"].as_f64().unwrap();
    assert!(measured != 3.5 && (measured / 3.5 - 1.0).abs() < 0.012, "{measured}");
    // What the encoder shows more than the phase, 0.03 rad, and what the pace of the crank adds.
    assert!((of["ahead_rad"].as_f64().unwrap() - 0.03).abs() < 0.15, "{of}");
    let against = &own["runs_against_model"]["roll15_speed08"]["Fz"];
    let (rmse, range) = (against["rmse"].as_f64().unwrap(), against["range"].as_f64().unwrap());
    assert!(
        rmse > 0.02 * range && rmse < 0.3 * range,
        "the truth is not the model, nor far from it: {against}"
    );
    let envelope = read_parquet(&folder.join("sim/processed/envelope.parquet")).unwrap();
    for prefix in ["low_", "simulation_"] {
        let fz = envelope.values(&format!("{prefix}Fz")).unwrap();
        let apart = (0..200).map(|k| (fz[k] - fz[k + 200]).abs()).fold(0.0, f64::max);
        assert!(apart > 1e-4, "{prefix}: one cycle is drawn twice");
        let step = fz.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        assert!(step < 0.1, "{prefix}: the strokes join, but for {step} N");
    }

    // The same as a file: the motion of the arm comes from its positions alone.
    foreign(&record, &folder.join("file.parquet"), &|_| {});
    let output = coarse(&folder, &["process", "file.parquet", "--run", &run(), "--out", "file", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let file = summary(&folder.join("file"));
    assert_eq!(file["simulation"], "roll15_speed08");
    assert_eq!(
        (file["simulated"].as_array().unwrap().len(), &file["runs_against_truth"]),
        (0, &Value::Object(Default::default()))
    );
    assert!(file.to_string().contains("motion as recorded"), "{file}");
    let again = file["runs_against_model"]["roll15_speed08"]["Fz"]["rmse"].as_f64().unwrap();
    assert!((again / rmse - 1.0).abs() < 0.1, "{again} {rmse}");
}

#[test]
fn wrong_signs_axes_and_phases_of_a_file_are_told_and_mended_as_proposed() {
    let (folder, record) = simulated("rig-wrong");
    let cases: [(&str, Change, &str, &str); 3] = [
        (
            "flipped",
            &|v| v[3].iter_mut().for_each(|x| *x = -*x),
            "Fz is -Fz of the file",
            "process.input.columns={Fz = \"-Fz\"}",
        ),
        (
            "swapped",
            &|v| v.swap(1, 3),
            "Fz is Fx of the file",
            "process.input.columns={Fx = \"Fz\", Fz = \"Fx\"}",
        ),
        (
            "late",
            &|v| v[7].iter_mut().for_each(|x| *x += 0.3),
            "behind the model's",
            "rig.robot.numbers={\"gait.phase_rad\"=",
        ),
    ];
    for (name, change, said, mend) in cases {
        let file = format!("{name}.parquet");
        foreign(&record, &folder.join(&file), change);
        let output = coarse(&folder, &["process", &file, "--run", &run(), "--out", name]);
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && text.contains(said) && text.contains(mend), "{name}: {text}");
        let proposed = text.split("--set '").nth(1).unwrap().split('\'').next().unwrap();
        let mended = format!("{name}-mended");
        let output =
            coarse(&folder, &["process", &file, "--run", &run(), "--set", proposed, "--out", &mended]);
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && !text.contains("caution"), "{name}: {text}");
        let fz = |of: &str| {
            summary(&folder.join(of))["runs_against_model"]["roll15_speed08"]["Fz"]["rmse"].as_f64().unwrap()
        };
        assert!(fz(&mended) < 0.6 * fz(name), "{name}: {} {}", fz(&mended), fz(name));
    }
    // All six: no model is wrong like that, so the samples are suspect.
    foreign(&record, &folder.join("over.parquet"), &|v| v[1..7].iter_mut().flatten().for_each(|x| *x = -*x));
    let output = coarse(&folder, &["process", "over.parquet", "--run", &run(), "--out", "over"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(3) && text.contains("suspect_data"), "{text}");
    assert!(summary(&folder.join("over"))["warnings"].to_string().contains("turned over"));
}

/// Simulates the seven shipped runs and processes them: each is measured well, whatever is noted of it.
fn the_seven_runs_are_ok(name: &str, settings: &[&str]) {
    let folder = scratch(name);
    let list = root().join("rigs/seven_runs.toml").to_string_lossy().into_owned();
    let simulate = [&["simulate", &list, "--out", "sim", "--quiet"][..], settings].concat();
    for arguments in [&simulate[..], &["process", "sim", "--quiet", "--no-report"]] {
        let output = rig(&folder, arguments);
        assert!(output.status.success(), "{output:?}");
    }
    let own = summary(&folder.join("sim/processed"));
    assert_eq!(own["status"], "ok", "{}", own["reason"]);
    assert_eq!(own["runs"].as_object().unwrap().len(), 7);
}

#[test]
fn the_seven_runs_of_a_slower_cell_are_ok() {
    the_seven_runs_are_ok("rig-seven", &["--set", "rig.cell.rate_hz=500", "--set", "rig.cell.filter_hz=200"]);
}

#[test]
#[ignore = "long: cargo xtask long tests"]
fn the_seven_runs_as_shipped_are_ok() {
    the_seven_runs_are_ok("rig-seven-shipped", &[]);
}
