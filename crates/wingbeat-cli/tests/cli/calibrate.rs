//! `wingbeat calibrate` on data that are wrong: what it says, and with which exit code it ends.

use std::fmt::Write;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use wingbeat::math::Random;
use wingbeat::scenario::TetherCase;

use crate::{root, scratch, wingbeat};

/// Cycles of a file, and steps of each.
const CYCLES: usize = 12;
const STEPS: usize = 48;
/// Deviation of the noise of force and moment.
const NOISE: [f64; 3] = [0.003, 0.004, 2e-4];

/// Fx, Fz and My of `flap_f2` under a law, with another slope, a row per step.
fn measured(law: &str) -> Vec<[f64; 4]> {
    let steps = format!("time.steps_per_cycle={STEPS}");
    let law = format!("aero.law={law}");
    let path = root().join("cases/flap_f2.toml");
    let case = TetherCase::load(&path, &[steps, law], &|_| Err("no table".into())).unwrap();
    let tether = case.adjusted(&[("surfaces.wing.lift_slope_per_rad", 5.9)]).unwrap();
    let run = tether.run(|_| ControlFlow::Continue(()));
    let of = ["force_x", "force_z", "moment_y"].map(|name| run.last_cycle(name).unwrap().to_vec());
    let mut random = Random::new(5);
    let row = |k: usize| {
        let mut load = |i: usize| of[i][k % STEPS] + NOISE[i] * random.normal();
        [k as f64 * tether.clock.step(), load(0), load(1), load(2)]
    };
    (0..=CYCLES * STEPS).map(row).collect()
}

/// What is done to a row: its number, its numbers, and all rows.
type Change<'a> = &'a dyn Fn(usize, [f64; 4], &[[f64; 4]]) -> [f64; 4];

fn write(path: &Path, rows: &[[f64; 4]], change: Change) {
    let mut text = "t,force_x,force_z,moment_y\n".to_owned();
    for (k, row) in rows.iter().enumerate() {
        let [t, fx, fz, my] = change(k, *row, rows);
        writeln!(text, "{t},{fx:e},{fz:e},{my:e}").unwrap();
    }
    fs::write(path, text).unwrap();
}

fn calibration(folder: &Path, data: &str) -> String {
    let case = root().join("cases/flap_f2.toml");
    let text = format!(
        "name = \"wing\"\nstarts = 1\n[[cases]]\ncase = {case:?}\nset = [\"time.steps_per_cycle={STEPS}\"]\ndata = [{data:?}]\n\
         [[parameters]]\nname = \"surfaces.wing.lift_slope_per_rad\"\n"
    );
    let name = format!("{data}.toml");
    fs::write(folder.join(&name), text).unwrap();
    name
}

/// What a wrong file is called, what is done to it, the exit code of the fit and of `--information`, and words that it must say.
type Wrong<'a> = (&'static str, Change<'a>, [i32; 2], &'static str);

#[test]
fn data_that_are_wrong_end_with_their_name_and_exit_code() {
    let folder = scratch("calibrate-wrong");
    let rows = measured("linear");
    let mut random = Random::new(6);
    let noise: Vec<f64> = (0..3 * rows.len()).map(|_| random.normal()).collect();
    let end = rows.len() as f64;
    let late = |k: usize, rows: &[[f64; 4]]| {
        // 9.4 deg of a cycle by linear interpolation; the file goes round.
        let back = 9.4 / 360.0 * STEPS as f64;
        let at = (k as f64 + (CYCLES * STEPS) as f64 - back) % (CYCLES * STEPS) as f64;
        let (low, share) = (at.floor() as usize, at.fract());
        std::array::from_fn(|i| rows[low][i] + share * (rows[low + 1][i] - rows[low][i]))
    };
    let cases: [Wrong; 13] = [
        ("good", &|_, row, _| row, [0, 0], "calibration.gain_unchecked"),
        ("constant", &|_, [t, ..], _| [t, 0.1, -0.5, 0.01], [2, 2], "never change"),
        ("zero", &|_, [t, ..], _| [t, 0.0, 0.0, 0.0], [2, 2], "never change"),
        (
            "noise",
            &|k, [t, ..], _| [t, noise[3 * k], noise[3 * k + 1], 0.1 * noise[3 * k + 2]],
            [3, 3],
            "data.noise",
        ),
        (
            "tiny",
            &|_, [t, a, b, c], _| [t, 1e-300 * a, 1e-300 * b, 1e-300 * c],
            [2, 2],
            "check the unit and the scale",
        ),
        ("drift", &|k, [t, a, b, c], _| [t, a, b + 0.3 * k as f64 / end, c], [3, 3], "data.drift"),
        (
            "bow",
            &|k, [t, a, b, c], _| [t, a, b + 0.4 * (2.0 * k as f64 / end - 1.0).powi(2), c],
            [3, 3],
            "data.drift",
        ),
        ("reversed", &|_, [t, a, b, c], _| [t, -a, b, c], [3, 3], "data.reversed"),
        (
            "gain",
            &|_, [t, a, b, c], _| [t, 1.15 * a, 1.15 * b, 1.15 * c],
            [0, 0],
            "calibration.gain_unchecked",
        ),
        (
            "stuck",
            &|k, row, rows| if k < 200 { row } else { [row[0], row[1], rows[200][2], row[3]] },
            [3, 3],
            "data.stuck",
        ),
        ("dead", &|_, [t, _, b, c], _| [t, 0.02, b, c], [3, 3], "data.dead"),
        ("standing", &|_, [t, a, _, c], _| [t, a, 0.05, c], [3, 3], "data.dead"),
        (
            "late",
            &|k, [t, ..], rows| {
                let [_, a, b, c] = late(k, rows);
                [t, a, b, c]
            },
            [3, 3],
            "data.shift",
        ),
    ];
    for (name, change, codes, words) in cases {
        let data = format!("{name}.csv");
        write(&folder.join(&data), &rows, change);
        let file = calibration(&folder, &data);
        let fit = wingbeat(&folder, &["calibrate", &file, "--out", name]);
        let told = wingbeat(&folder, &["calibrate", &file, "--information", "--out", "none"]);
        for (output, code) in [&fit, &told].into_iter().zip(codes) {
            let said = String::from_utf8_lossy(&output.stderr).into_owned()
                + &String::from_utf8_lossy(&output.stdout);
            println!(
                "{name}: {:?}, {}",
                output.status.code(),
                said.lines()
                    .filter(|line| line.contains("data.") || line.contains("calibration."))
                    .collect::<Vec<_>>()
                    .join(" | ")
            );
            assert_eq!(output.status.code(), Some(code), "{name}: {said}");
            assert!(said.contains(words), "{name}: {said}");
            let named = said.contains(&data) || said.contains("flap_f2");
            assert!(code == 0 || named, "{name} is named: {said}");
            // Three of six channels are measured, with noise.
            assert!(!said.contains("calibration.no_noise"), "{name}: {said}");
        }
        assert!(!folder.join("none").exists());
        assert_eq!(folder.join(name).is_dir(), codes[0] != 2, "{name}");
        if codes[0] == 3 {
            let numbers = fs::read_to_string(folder.join(name).join("numbers.toml")).unwrap();
            // In the stall of this case the law shifts loads as a late clock does.
            let status = if name == "late" { "outside" } else { "suspect_data" };
            assert!(numbers.contains(status), "{numbers}");
        }
    }
}

/// Mean and deviation.
fn spread(values: &[f64]) -> [f64; 2] {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
    [mean, square.sqrt()]
}

#[test]
fn a_sweep_draws_the_fit_that_was_written() {
    const NAME: &str = "surfaces.wing.lift_slope_per_rad";
    let folder = scratch("calibrate-drawn");
    write(&folder.join("good.csv"), &measured("linear"), &|_, row, _| row);
    let file = calibration(&folder, "good.csv");
    assert_eq!(wingbeat(&folder, &["calibrate", &file, "--out", "fit"]).status.code(), Some(0));
    let numbers: toml::Table = fs::read_to_string(folder.join("fit/numbers.toml")).unwrap().parse().unwrap();
    let told = &numbers["uncertainty"];
    assert_eq!(told["of"][0].as_str(), Some(NAME));
    let [value, error] = [&numbers[NAME], &told["standard_error"][0]].map(|of| of.as_float().unwrap());
    assert!((value - 5.9).abs() < 4.0 * error && error > 0.0, "{value} +- {error}");
    // The interval of the summary is of the degrees of freedom by which the fit is drawn.
    let freedom = told["degrees_of_freedom"].as_float().unwrap();
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.join("fit/summary.json")).unwrap()).unwrap();
    let high = summary["parameters"][0]["high"].as_f64().unwrap();
    let reach = wingbeat_calibrate::student_95(freedom) * error;
    assert!((high - value - reach).abs() < 1e-9 * reach, "{freedom}: {high}, {value} + {reach}");
    let case = root().join("cases/flap_f2.toml");
    let text = format!(
        "name = \"drawn\"\ncase = {case:?}\nset = [\"time.steps_per_cycle=12\", \"aero.law=linear\"]\nruns = 40\n\
         [[draws]]\nkey = \"numbers\"\nfit = \"fit/numbers.toml\"\n"
    );
    fs::write(folder.join("drawn.toml"), text).unwrap();
    let swept = wingbeat(&folder, &["sweep", "drawn.toml", "--out", "swept"]);
    println!("{}", String::from_utf8_lossy(&swept.stderr));
    assert!(folder.join("swept/runs.csv").is_file());
    let rows = fs::read_to_string(folder.join("swept/runs.csv")).unwrap();
    let head: Vec<&str> = rows.lines().next().unwrap().split(',').collect();
    let at = head.iter().position(|name| name.contains(NAME)).unwrap_or_else(|| panic!("{head:?}"));
    let drawn: Vec<f64> =
        rows.lines().skip(1).map(|row| row.split(',').nth(at).unwrap().parse().unwrap()).collect();
    // Of 40 draws the mean has a deviation of 0.16 errors, the deviation of 0.11.
    let [mean, deviation] = spread(&drawn);
    assert!(drawn.len() == 40 && (mean - value).abs() < 0.6 * error, "{mean}");
    assert!((deviation / error - 1.0).abs() < 0.4, "{deviation}");
}

/// The standard error of a parameter as the information tells it for a file, from all runs.
fn promised(folder: &Path, data: &str) -> f64 {
    let file = calibration(folder, data);
    let told = wingbeat(folder, &["calibrate", &file, "--information"]);
    let text = String::from_utf8(told.stdout).unwrap();
    let line = text
        .lines()
        .find(|line| line.starts_with("surfaces.wing.lift_slope"))
        .unwrap_or_else(|| panic!("{text}"));
    line.split_whitespace().nth(2).unwrap().parse().unwrap()
}

#[test]
fn the_information_promises_nothing_for_a_channel_that_does_not_move() {
    let folder = scratch("calibrate-promise");
    let rows = measured("linear");
    write(&folder.join("good.csv"), &rows, &|_, row, _| row);
    write(&folder.join("dead.csv"), &rows, &|_, [t, _, b, c], _| [t, 0.02, b, c]);
    write(&folder.join("stuck.csv"), &rows, &|k, row, rows| {
        if k < 100 { row } else { [row[0], row[1], rows[100][2], row[3]] }
    });
    let good = promised(&folder, "good.csv");
    for data in ["dead.csv", "stuck.csv"] {
        let left = promised(&folder, data);
        println!("{data}: {left} where {good} is told of the whole file");
        assert!(left > 0.9 * good && left.is_finite(), "{data}: {left} and {good}");
    }
}

/// A model that is wrong leaves a cycle of its own; one that is right leaves noise.
#[test]
fn what_a_wrong_model_leaves_is_told_from_noise() {
    let folder = scratch("calibrate-colour");
    let left = |law: &str| {
        let data = format!("{law}.csv");
        write(&folder.join(&data), &measured(law), &|_, row, _| row);
        let file = calibration(&folder, &data);
        let output = wingbeat(&folder, &["calibrate", &file, "--out", law, "--quiet"]);
        assert!(folder.join(law).is_dir(), "{output:?}");
        let text = fs::read_to_string(folder.join(law).join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        println!(
            "{law}: chi squared {}, correlation {}",
            summary["chi_squared"], summary["residual_autocorrelation"]
        );
        let warned = summary["warnings"].to_string().contains("calibration.residual_autocorrelation");
        // What misses the loads by ten times their noise is no `ok`.
        let misses = summary["reason"].to_string().contains("limits.calibration.wrong_model_chi_squared");
        assert_eq!(
            (misses, output.status.code()),
            (law == "stall", Some(if misses { 3 } else { 0 })),
            "{law}"
        );
        (summary["residual_autocorrelation"].as_f64().unwrap(), warned)
    };
    let (noise, warned) = left("linear");
    assert!(noise.abs() < 0.3 && !warned, "{noise}");
    let (own, warned) = left("stall");
    assert!(own > 0.5 && warned, "{own}");
}

#[test]
fn a_late_clock_is_told_beside_the_parameters() {
    let folder = scratch("calibrate-late");
    let rows = measured("linear");
    let all = (CYCLES * STEPS) as f64;
    let told = |name: &str, deg: f64| {
        let back = deg / 360.0 * STEPS as f64;
        let shifted = |k: usize, [t, ..]: [f64; 4], rows: &[[f64; 4]]| {
            let at = (k as f64 + all - back) % all;
            let (low, share) = (at.floor() as usize, at.fract());
            let [_, a, b, c] =
                std::array::from_fn(|i| rows[low][i] + share * (rows[low + 1][i] - rows[low][i]));
            [t, a, b, c]
        };
        let data = format!("{name}.csv");
        write(&folder.join(&data), &rows, &shifted);
        let file = calibration(&folder, &data);
        let output = wingbeat(&folder, &["calibrate", &file, "--out", name, "--quiet"]);
        assert!(output.status.code().is_some_and(|code| code != 2), "{output:?}");
        let summary = fs::read_to_string(folder.join(name).join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        let left = summary["reason"].as_str().is_some_and(|reason| reason.contains("shift that is left"));
        assert_eq!((summary["status"] != "ok", left), (deg.abs() > 5.0, deg.abs() > 5.0), "{summary}");
        let warnings = summary["warnings"].as_array().unwrap().iter();
        let found: Vec<String> = warnings
            .filter(|warning| warning["id"] == "calibration.shift_errors")
            .map(|warning| warning["text"].as_str().unwrap().to_owned())
            .collect();
        println!("{name}: {found:?}");
        found
    };
    assert_eq!(told("right", 0.0), [""; 0]);
    let late = told("late", 4.0);
    assert!(late.len() == 1 && late[0].contains("deg behind"), "{late:?}");
    let early = told("early", -4.0);
    assert!(early.len() == 1 && early[0].contains("deg ahead"), "{early:?}");
    assert_eq!(told("later", 12.0).len(), 1);
}
