//! What `wingbeat rig process` tells of faulty recordings: each a simulated one that is made worse.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::{root, scratch};
use wingbeat::simulate::Record;
use wingbeat_io::{read_parquet, write_parquet};

fn wingbeat(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wingbeat"));
    command.arg("rig").args(arguments).current_dir(folder).output().unwrap()
}

/// The run, told where it is.
const HELD: [&str; 10] = [
    "--set",
    "hold.each_s=3.3",
    "--set",
    "rig.rest_s=2.0",
    "--set",
    "process.phase=\"encoder\"",
    "--set",
    "process.steps.tare=true",
    "--set",
    "process.steps.drift=true",
];

struct Bench {
    folder: PathBuf,
    run: String,
    record: Record,
}

impl Bench {
    fn simulated(name: &str) -> Self {
        let folder = scratch(name);
        let run = root().join("rigs/runs/bench.toml").to_string_lossy().into_owned();
        let output = wingbeat(
            &folder,
            &[&["simulate", &run, "--out", "simulated", "--no-report"][..], &HELD].concat(),
        );
        assert!(output.status.success(), "{output:?}");
        let record = read_parquet(&folder.join("simulated/bench/record.parquet"))
            .or_else(|_| read_parquet(&folder.join("simulated/record.parquet")))
            .unwrap();
        Self { folder, run, record }
    }

    /// What is said of the recording as `change` leaves a column of it: by the columns t and `name`, from row to row.
    fn told(&self, name: &str, change: impl Fn(f64, f64) -> f64, sets: &[&str]) -> (Option<i32>, String) {
        let t = self.record.values("t").unwrap().to_vec();
        let mut columns = self.record.clone().into_columns();
        columns.retain(|column| !column.name.starts_with("true_"));
        for column in columns.iter_mut().filter(|column| column.name == name) {
            column.values.iter_mut().zip(&t).for_each(|(value, t)| *value = change(*t, *value));
        }
        write_parquet(&self.folder.join("made.parquet"), &Record::new(columns, 0).unwrap()).unwrap();
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
        let asked = [
            &["process", "made.parquet", "--run", &self.run, "--out", "made", "--force", "--no-report"][..],
            &HELD,
            &sets,
        ];
        let output = wingbeat(&self.folder, &asked.concat());
        let said = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
        (output.status.code(), said)
    }
}

#[test]
fn an_encoder_of_counts_or_noise_serves_and_one_that_cannot_be_is_told() {
    let bench = Bench::simulated("rig-encoders");
    let count = TAU / 1024.0;
    for (name, change) in [
        (
            "1024 counts",
            Box::new(move |_, phase: f64| (phase / count).round() * count) as Box<dyn Fn(f64, f64) -> f64>,
        ),
        ("noise of a milliradian", Box::new(|t: f64, phase| phase + 1.4e-3 * (1e4 * t).sin())),
        ("absolute, 0 to 1 turn", Box::new(|_, phase: f64| phase.rem_euclid(TAU))),
    ] {
        for inertia in ["process.steps.robot_inertia=false", "process.steps.robot_inertia=true"] {
            let (code, said) = bench.told("phase", &change, &[inertia]);
            assert!(code == Some(0) && !said.contains("go ahead"), "{name}: {said}");
        }
    }
    let (code, said) = bench.told("phase", |_, phase| -phase, &[]);
    assert!(code == Some(2) && said.contains("{phase = \"-phase\"}"), "{said}");
    let (code, said) = bench.told("phase", |_, phase| -phase, &["process.input.columns={phase=\"-phase\"}"]);
    assert_eq!(code, Some(0), "{said}");
    let (code, said) = bench.told("phase", |_, phase| 5.0 * phase, &[]);
    assert!(code == Some(3) && said.contains("times the 3.5 Hz") && !said.contains("caution"), "{said}");
    assert_eq!(said.matches("warning").count(), 1, "{said}");
    let (code, said) = bench.told("phase", |t, phase| if t > 2.0 { 2.0 } else { phase }, &[]);
    assert!(code == Some(3) && said.contains("phase of bench: does not go ahead"), "{said}");
}

#[test]
fn loads_that_are_cut_off_and_rests_that_drift_are_told() {
    let bench = Bench::simulated("rig-cut-off");
    let fz = bench.record.values("Fz").unwrap();
    let (low, high) = fz.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    for share in [0.3, 0.5, 0.7] {
        let at = low + share * (high - low);
        for drift in ["process.steps.drift=true", "process.steps.drift=false"] {
            let (code, said) = bench.told("Fz", |_, load| load.min(at), &[drift]);
            assert!(code == Some(3) && said.contains("clipped"), "{share}, {drift}: {said}");
        }
    }
    let (code, said) = bench.told("Fz", |_, load| load, &[]);
    assert!(code == Some(0) && !said.contains("clipped") && !said.contains("in the rest"), "{said}");
    let warm = |t: f64, load| load + 0.4 * (1.0 - (-(t + 2.0) / 3.0).exp());
    let (_, said) = bench.told("Fz", warm, &["process.steps.drift=false"]);
    assert!(said.contains("data.rest_drifts") && said.contains("process.steps.drift"), "{said}");
    let (_, said) = bench.told("Fz", |_, load| load, &["process.steps.drift=false"]);
    assert!(!said.contains("data.rest_drifts"), "{said}");
}

#[test]
fn means_that_are_not_the_models_and_a_resonance_in_the_averages_are_told() {
    let bench = Bench::simulated("rig-means");
    let away = |t: f64, load| if t > 0.0 { load + 0.1 } else { load };
    let (code, said) = bench.told("Fy", away, &[]);
    assert!(code == Some(0) && said.contains("data.mean") && said.contains("the fixture's mass"), "{said}");
    let (_, said) = bench.told("Fy", |_, load| load, &[]);
    assert!(!said.contains("data.mean") && !said.contains("data.resonance"), "{said}");
    let (_, said) = bench.told("Fy", |_, load| load, &["rig.cell.resonance_hz=80.0"]);
    assert!(said.contains("data.resonance") && said.contains("harmonic 8"), "{said}");
}
