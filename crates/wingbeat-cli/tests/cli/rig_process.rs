//! `wingbeat rig process` as a user meets it: recordings, files of other programs, tilts, messages.

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use crate::{root, scratch};
use wingbeat::rig::cell::CHANNELS;
use wingbeat::simulate::{Column, Record};
use wingbeat_io::{read_parquet, write_parquet};

fn rigs() -> PathBuf {
    root().join("rigs")
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wingbeat"));
    command.arg("rig").args(arguments).current_dir(folder);
    command
}

fn rig(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

fn bench() -> String {
    rigs().join("runs/bench.toml").to_string_lossy().into_owned()
}

/// An emulator that ends with the test.
struct Emulator(Child);

impl Emulator {
    fn start(folder: &Path, offset: &str, more: &[&str]) -> Self {
        let mut command = command(folder, &["emulate", "--port-offset", offset]);
        let child = command.args(more).stdout(Stdio::null()).spawn().unwrap();
        Self(child)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Records from the emulator at `offset`, which may still be starting.
fn record(folder: &Path, offset: &str, seconds: &str) {
    for _ in 0..100 {
        let arguments = [
            "record",
            "127.0.0.1",
            "--port-offset",
            offset,
            "--duration",
            seconds,
            "--out",
            "taken",
            "--quiet",
        ];
        let output = rig(folder, &arguments);
        if output.status.success() {
            return;
        }
        let _ = fs::remove_dir_all(folder.join("taken"));
        std::thread::sleep(Duration::from_millis(100));
    }
    panic!("no recording");
}

/// The built-in signal of the emulator: Fz = 0.4 sin + 0.1 sin 2 - 0.45, Ty = 0.02 cos, by its own phase.
fn built_in(phase: f64) -> [f64; 6] {
    let (s, c) = phase.sin_cos();
    let bend = 2.0 * s * c;
    [0.01 * c, 0.02 * s, 0.4 * s + 0.1 * bend - 0.45, 1e-3 * s, 0.02 * c, 5e-4 * bend]
}

/// Every correction by model left out, in the cell's frame.
const AS_MEASURED: [&str; 6] = [
    "--set",
    "process.steps.gravity=false",
    "--set",
    "process.steps.mount_inertia=false",
    "--set",
    "process.steps.body_frame=false",
];

#[test]
fn a_recording_gives_the_phase_averages_of_what_was_played() {
    let folder = scratch("rig-recording");
    let _emulator = Emulator::start(&folder, "11240", &[]);
    record(&folder, "11240", "3.2");
    let refused = rig(&folder, &["process", "taken"]);
    let message = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(message.contains("taken/record.parquet") && message.contains("--run RUN.toml"), "{message}");
    assert!(!folder.join("taken/processed").exists());
    let output = rig(&folder, &[&["process", "taken", "--run", &bench()][..], &AS_MEASURED].concat());
    assert!(output.status.success(), "{output:?}");
    let average = read_parquet(&folder.join("taken/processed/bench.parquet")).unwrap();
    // Phase 0 is the largest value of the fundamental of Fz: a quarter turn of the signal's own phase.
    for (i, (name, _)) in CHANNELS.iter().enumerate() {
        let values = average.values(name).unwrap();
        let range = [0.02, 0.04, 0.8, 2e-3, 0.04, 1e-3][i];
        for (bin, value) in values.iter().enumerate() {
            let truth = built_in(TAU * (bin as f64 / values.len() as f64 + 0.25))[i];
            assert!((value - truth).abs() < 0.01 * range, "{name} {bin}: {value} {truth}");
        }
    }
    let summary = fs::read_to_string(folder.join("taken/processed/summary.json")).unwrap();
    assert!(summary.contains("tare: left out") && summary.contains("filter: Butterworth"), "{summary}");
    // What was measured does not pass for a simulation; the model stands beside it.
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        summary.contains("\"simulated\": []") && summary.contains("\"simulation\": \"bench\""),
        "{summary}"
    );
    assert!(!said.contains("of a simulated load cell"), "{said}");
    for figure in ["force_moment.png", "bench/filtered.png", "bench/cycles.png"] {
        assert!(folder.join("taken/processed/figures").join(figure).is_file(), "{figure}");
    }
}

#[test]
fn gaps_stay_open_and_their_cycles_are_left_out() {
    let folder = scratch("rig-gaps");
    let _emulator = Emulator::start(&folder, "11241", &["--drop", "0.0002", "--seed", "3"]);
    record(&folder, "11241", "4");
    let bench = bench();
    let run = [&["process", "taken", "--run", &bench, "--quiet"][..], &AS_MEASURED].concat();
    let output = rig(&folder, &run);
    assert!(output.status.success(), "{output:?}");
    let summary = fs::read_to_string(folder.join("taken/processed/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let of = &summary["runs"]["bench"];
    assert!(of["import"]["missing"].as_u64() > Some(0), "{of}");
    assert!(of["cycles_left_out"].as_u64() > Some(0) && of["cycles"].as_u64() > Some(0), "{of}");
    let average = read_parquet(&folder.join("taken/processed/bench.parquet")).unwrap();
    let fz = average.values("Fz").unwrap();
    let truth = |bin: usize| built_in(TAU * (bin as f64 / fz.len() as f64 + 0.25))[2];
    assert!(fz.iter().enumerate().all(|(bin, value)| (value - truth(bin)).abs() < 8e-3));
    let bridged = rig(&folder, &[&run[..], &["--set", "process.input.bridge_samples=50"]].concat());
    assert!(bridged.status.success(), "{bridged:?}");
    let summary = fs::read_to_string(folder.join("taken/processed-2/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["runs"]["bench"]["cycles_left_out"], 0);
}

/// A file with the built-in signal, 4 s at 1 kHz.
fn signal(path: &Path, change: impl Fn(usize, &mut [f64; 6])) {
    let mut columns = vec![Column::new("t", "s", "")];
    columns.extend(CHANNELS.map(|(name, unit)| Column::new(name, unit, "C")));
    let mut record = Record::new(columns, 4000).unwrap();
    for k in 0..4000 {
        let t = k as f64 * 1e-3;
        let mut values = built_in(TAU * 3.5 * t);
        change(k, &mut values);
        record.append(&[&[t][..], &values].concat());
    }
    write_parquet(path, &record).unwrap();
}

#[test]
fn settings_without_meaning_are_refused_by_their_key() {
    let folder = scratch("rig-process-settings");
    signal(&folder.join("a.csv"), |_, _| {});
    for (set, part) in [
        ("process.bins=0", "process.bins"),
        ("process.bins=100000000", "2 to 10000"),
        ("process.window_s=[5,1]", "process.window_s[0] = 5: allowed is at most 1"),
        ("process.steps.cutoff_multiple=-1", "cutoff_multiple"),
    ] {
        let output = rig(&folder, &["process", "a.csv", "--run", &bench(), "--set", set, "--out", "b"]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{set}: {message}");
        assert!(message.contains(part) && !folder.join("b").exists(), "{set}: {message}");
    }
}

#[test]
fn bad_input_is_one_message_and_no_folder() {
    let folder = scratch("rig-bad");
    signal(&folder.join("good.parquet"), |_, _| ());
    signal(&folder.join("saturated.parquet"), |k, values| {
        values[2] = if k == 1234 { 17.0 } else { values[2] }
    });
    fs::write(folder.join("cut.csv"), "time_s,fx_N,fy_N,fz_N,tx_Nm,ty_Nm,tz_Nm\n0,1,1,1,1,1,1\n0.1,1,1")
        .unwrap();
    fs::write(folder.join("bare.csv"), "time_s,fx,fy,fz,tx,ty,tz\n0,1,1,1,1,1,1\n0.1,1,1,1,1,1,1\n").unwrap();
    let bench = bench();
    for (file, set, parts) in [
        ("good.parquet", "process.steps.tare=true", &["0 samples before 0", "process.input.start_s"][..]),
        ("good.parquet", "process.input.columns.Fz=up", &["no column `up` for Fz; found t, Fx"]),
        ("good.parquet", "process.stepz=1", &["unknown key process.stepz"]),
        (
            "good.parquet",
            "process.window_s=[0.5, 0.6]",
            &["process.window_s = 0.35 cycles", "at least one whole cycle"],
        ),
        ("saturated.parquet", "frequency=1", &["unknown key frequency"]),
        (
            "saturated.parquet",
            "process.bins=100",
            &["1 saturated samples, the first by Fz", "t 1.2340 s", "leave_out"],
        ),
        ("cut.csv", "process.bins=100", &["cut short at sample 1: line 3"]),
        ("bare.csv", "process.bins=100", &["column fx: unit missing", "process.input.units.force=UNIT"]),
        ("none.csv", "process.bins=100", &["none.csv", "No such file"]),
    ] {
        let output = rig(&folder, &["process", file, "--run", &bench, "--set", set]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{file} {set}: {message}");
        parts.iter().for_each(|part| assert!(message.contains(part), "{file} {set}: {message}"));
    }
    let left: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left.len(), 4, "{left:?}");
    let kept = rig(
        &folder,
        &["process", "saturated.parquet", "--run", &bench, "--set", "process.saturated=leave_out", "--quiet"],
    );
    assert!(kept.status.success(), "{kept:?}");
    let summary = fs::read_to_string(folder.join("saturated-processed/summary.json")).unwrap();
    assert!(summary.contains("\"cycles_left_out\": 1") && summary.contains("\"bench\": 1"), "{summary}");
}

#[test]
fn static_tilts_weigh_the_mount() {
    let folder = scratch("rig-tilts");
    let tilts = rigs().join("identification/static_tilts.toml");
    let set =
        ["--set", "rig.cell.rate_hz=1000", "--set", "rig.cell.filter_hz=400", "--set", "hold.each_s=1.0"];
    let simulated =
        rig(&folder, &[&["simulate", tilts.to_str().unwrap(), "--out", "a", "--quiet"][..], &set].concat());
    assert!(simulated.status.success(), "{simulated:?}");
    let output = rig(&folder, &["process", "a"]);
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("mount without robot") && text.contains("residual"), "{text}");
    let summary = fs::read_to_string(folder.join("a/processed/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let mount = &summary["static_tilts"]["static_tilts"]["mount"];
    let near = |value: &serde_json::Value, truth: f64, tolerance: f64| {
        assert!((value.as_f64().unwrap() - truth).abs() < tolerance, "{value} {truth}");
    };
    near(&mount["mass_kg"], 0.012, 1e-4);
    near(&mount["com_m"][2], 0.03, 1e-3);
    // The bias of the rig's file and its drift over the rest of 4 s.
    for (k, bias) in [0.128, -0.084, 0.312].iter().enumerate() {
        near(&mount["bias"][k], *bias, 1e-3);
    }
}

#[test]
fn a_rest_in_which_wings_flap_and_a_window_that_holds_rest_are_suspect() {
    let folder = scratch("rig-process-rest");
    // At rest up to 1.5 s, with the noise of the cell.
    signal(&folder.join("rest.parquet"), |k, values| {
        for (i, value) in values.iter_mut().enumerate() {
            let noise = [1.0, 1.0, 1.0, 5e-3, 5e-3, 5e-3][i] * 2e-3 * (12.9898 * (6 * k + i) as f64).sin();
            *value = if k < 1500 { noise } else { *value + noise };
        }
    });
    signal(&folder.join("moves.parquet"), |_, _| {});
    let process = |file: &str, sets: &[&str]| {
        let mut run = vec!["process", file, "--run", "", "--force", "--out", "o", "--quiet"];
        let bench = bench();
        run[3] = &bench;
        run.extend(AS_MEASURED);
        run.extend(sets.iter().flat_map(|set| ["--set", *set]));
        let output = rig(&folder, &run);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let tared = |start: &'static str| ["process.steps.tare=true", start];
    for (file, start, limit) in [
        ("moves.parquet", "process.input.start_s=1.5", "limits.data.rest_fraction"),
        ("rest.parquet", "process.input.start_s=0.5", "limits.data.size_scatter_fraction"),
    ] {
        let (code, told) = process(file, &tared(start));
        assert!(code == Some(3) && told.contains(limit), "{file} {start}: {told}");
    }
    let (_, told) = process("rest.parquet", &tared("process.input.start_s=1.5"));
    assert!(!told.contains("rest_fraction") && !told.contains("size_scatter"), "{told}");
}

/// A spring that rests turned by a radian hangs there, and not at 0, while the mount is weighed.
#[test]
fn elastic_joints_are_weighed_where_they_rest() {
    let folder = scratch("rig-process-elastic");
    let read = |name: &str| fs::read_to_string(root().join(name)).unwrap();
    let robot = read("robots/any/elastic_16g.toml");
    let turned =
        robot.replace("stiffness = 1e-2, damping = 1e-4", "stiffness = 10.0, damping = 0.02, rest = 1.0");
    assert_ne!(robot, turned);
    fs::write(folder.join("robot.toml"), turned).unwrap();
    fs::copy(rigs().join("arms/kinova_gen3_6dof.toml"), folder.join("arm.toml")).unwrap();
    let rig_text = read("rigs/aerobat_on_gen3.toml");
    let rig_text = rig_text.replace("../robots/aerobat_beta.toml", "robot.toml");
    let rig_text = rig_text.replace("arms/kinova_gen3_6dof.toml", "arm.toml");
    fs::write(folder.join("rig.toml"), rig_text).unwrap();
    let run = "name = \"tilts\"\nrig = \"rig.toml\"\nfrequency_hz = 0.0\n[hold]\neach_s = 0.4\n\
        tilts_deg = [[0.0, 0.0], [40.0, 0.0], [-40.0, 0.0], [0.0, 40.0], [0.0, -40.0], [30.0, 30.0]]\n\
        [process]\nphase = \"frequency\"\n";
    fs::write(folder.join("run.toml"), run).unwrap();
    let quiet = [
        "rig.air.density_kg_m3=0.001",
        "rig.aero.preset=full",
        "rig.aero.law=stall",
        "rig.cell.noise_steps=0",
        "rig.cell.bias=[0,0,0,0,0,0]",
        "rig.cell.drift_per_s=[0,0,0,0,0,0]",
        "rig.truth.set=[]",
        "process.steps.drift=false",
    ];
    let with = |verb: &[&str]| {
        let sets = quiet.iter().flat_map(|set| ["--set", *set]);
        rig(&folder, &verb.iter().copied().chain(sets).chain(["--quiet"]).collect::<Vec<_>>())
    };
    let output = with(&["simulate", "run.toml", "--out", "s"]);
    assert!(output.status.success(), "{output:?}");
    let output = with(&["process", "s", "--run", "run.toml", "--out", "p"]);
    assert!(output.status.success(), "{output:?}");
    let summary = fs::read_to_string(folder.join("p/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let com = &summary["static_tilts"]["tilts"]["mount"]["com_m"];
    assert!((0..2).all(|i| com[i].as_f64().unwrap().abs() < 2e-4), "{summary}");
}
