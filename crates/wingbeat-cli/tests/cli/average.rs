//! `wingbeat average`.

use std::f64::consts::TAU;
use std::fs;

use serde_json::Value;

use super::{entries, scratch, wingbeat};

/// Even numbers from -1 to 1, without a crate.
fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Six channels at 1 kHz over 12 s: mean, first and second harmonic of `frequency` Hz, even noise up to `noise`.
fn cell(frequency: f64, size: f64, level: f64) -> String {
    let mut seed = 7;
    let row = |k: u32| {
        let p = TAU * frequency * f64::from(k) * 1e-3;
        let load = |i: u32| {
            let a = size * f64::from(i + 1);
            0.1 * f64::from(i) + a * p.cos() + 0.3 * a * (2.0 * p).sin()
        };
        (0..6).map(|i| format!("{:.6}", load(i) + level * noise(&mut seed))).collect::<Vec<_>>().join(",")
    };
    (0..12_000).map(row).map(|row| row + "\n").collect()
}

fn json(text: &[u8]) -> Value {
    serde_json::from_slice(text).unwrap()
}

#[test]
fn six_columns_give_their_frequency_and_phase_averages() {
    let folder = scratch("average");
    fs::write(folder.join("cell.csv"), cell(5.2134, 1.0, 0.5)).unwrap();
    let answer = wingbeat(&folder, &["average", "cell.csv", "--rate", "1000", "--units", "N,N m"]);
    let text = String::from_utf8(answer.stdout).unwrap();
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    assert!(text.contains("frequency 5.213") && text.contains("runs/cell"), "{text}");
    let run = folder.join("runs/cell");
    assert_eq!(entries(&run), ["cycles.csv", "figures", "manifest.json", "summary.json"]);
    let summary = json(&fs::read(run.join("summary.json")).unwrap());
    assert_eq!((&summary["status"], &summary["frequency_from"]), (&"ok".into(), &"data".into()), "{summary}");
    let (frequency, error) = (&summary["frequency_hz"], &summary["frequency_error_hz"]);
    let off = (frequency.as_f64().unwrap() - 5.2134).abs();
    assert!(off < 1e-3 && off < 4.0 * error.as_f64().unwrap(), "{frequency} +- {error}");
    let channels = summary["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 6);
    assert_eq!((&channels[2]["name"], &channels[4]["unit"]), (&"Fz".into(), &"N m".into()));
    let cycles = fs::read_to_string(run.join("cycles.csv")).unwrap();
    let mut rows = cycles.lines();
    assert_eq!(rows.next().unwrap(), "phase,Fx,Fx_std,Fy,Fy_std,Fz,Fz_std,Tx,Tx_std,Ty,Ty_std,Tz,Tz_std");
    for row in rows {
        let row: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let p = TAU * row[0];
        for i in 0..6 {
            let a = f64::from(i + 1);
            let load = 0.1 * f64::from(i) + a * p.cos() + 0.3 * a * (2.0 * p).sin();
            let (mean, std) = (row[1 + 2 * i as usize], row[2 + 2 * i as usize]);
            // Even noise up to 0.5 has the deviation 0.29, and 0.04 in the mean of 62 cycles.
            assert!((mean - load).abs() < 0.2, "{i} at {}: {mean}, not {load}", row[0]);
            assert!((0.1..0.5).contains(&std), "{i} at {}: {std}", row[0]);
        }
    }
    // All six channels are drawn.
    let figure = fs::read_to_string(run.join("figures/cycles.svg")).unwrap();
    for title in ["Fx [N]", "Fy [N]", "Fz [N]", "Tx [N m]", "Ty [N m]", "Tz [N m]"] {
        assert!(figure.contains(title), "{title}");
    }
}

#[test]
fn a_temperature_that_rests_hides_no_wings_that_move() {
    let folder = scratch("average-rest-beside");
    let row = |k: u32| {
        let t = f64::from(k) * 2e-3;
        let warm = if t < 2.0 { 0.0 } else { (TAU * t / 7.0).sin() };
        format!("{t},{},{}\n", (TAU * 5.0 * t).sin() + 0.1 * (TAU * 10.0 * t).cos(), 20.0 + warm)
    };
    let text = format!("t,Fz (N),cell (degC)\n{}", (0..5000).map(row).collect::<String>());
    fs::write(folder.join("cell.csv"), text).unwrap();
    let answer = wingbeat(&folder, &["average", "cell.csv", "--rest", "2", "--out", "a"]);
    let told = String::from_utf8_lossy(&answer.stderr).into_owned();
    assert!(answer.status.code() == Some(3) && told.contains("data.rest_fraction"), "{told}");
}

#[test]
fn a_rest_at_the_begin_is_subtracted() {
    let folder = scratch("average-rest");
    let mut seed = 3;
    let rest = (0..2000).map(|_| {
        let of = |i: u32| format!("{:.6}", 0.1 * f64::from(i) + 0.02 * noise(&mut seed));
        (0..6).map(of).collect::<Vec<_>>().join(",") + "\n"
    });
    let rest: String = rest.collect();
    fs::write(folder.join("cell.csv"), rest + &cell(5.0, 1.0, 0.02)).unwrap();
    let with = |seconds: &str, out: &str| {
        let given = ["average", "cell.csv", "--rate", "1000", "--rest", seconds, "--out", out];
        wingbeat(&folder, &given)
    };
    let answer = with("2", "a");
    assert!(answer.status.success(), "{answer:?}");
    let summary = json(&fs::read(folder.join("a/summary.json")).unwrap());
    assert_eq!(summary["warnings"], Value::Array(Vec::new()), "{summary}");
    for i in 0..6 {
        let read = summary["rest"]["channels"][i]["mean"].as_f64().unwrap();
        let mean = summary["channels"][i]["mean"].as_f64().unwrap();
        assert!((read - 0.1 * i as f64).abs() < 2e-3 && mean.abs() < 2e-3, "{i}: {read}, {mean}");
    }
    // Wings that move in it, were it a fifth of a second at its end.
    for (seconds, out) in [("8", "b"), ("2.2", "d")] {
        let answer = with(seconds, out);
        let told = String::from_utf8_lossy(&answer.stderr).into_owned();
        assert!(answer.status.code() == Some(3) && told.contains("data.rest_fraction"), "{seconds}: {told}");
    }
    for seconds in ["0", "-1", "nan", "1e300", "0.001", "14"] {
        let answer = with(seconds, "c");
        let told = String::from_utf8_lossy(&answer.stderr).into_owned();
        assert!(answer.status.code() == Some(2) && told.contains("--rest"), "{seconds}: {told}");
        assert!(!folder.join("c").exists());
    }
}

#[test]
fn a_given_frequency_is_held_against_the_data_and_noise_has_none() {
    let folder = scratch("average_suspect");
    fs::write(folder.join("cell.csv"), cell(5.2, 1.0, 0.2)).unwrap();
    fs::write(folder.join("noise.csv"), cell(5.2, 0.0, 1.0)).unwrap();
    let run = |arguments: &[&str]| {
        let answer = wingbeat(&folder, &[&["average", "--rate", "1000", "--quiet"], arguments].concat());
        (answer.status.code(), String::from_utf8(answer.stderr).unwrap())
    };
    let (code, said) = run(&["cell.csv", "--frequency", "5.0", "--out", "other"]);
    assert!(code == Some(3) && said.contains("suspect_data"), "{code:?}: {said}");
    let summary = json(&fs::read(folder.join("other/summary.json")).unwrap());
    let warnings = summary["warnings"].to_string();
    assert!(warnings.contains("repeats at 5.200") && warnings.contains("--frequency"), "{warnings}");
    let (code, said) = run(&["cell.csv", "--frequency", "5.2", "--out", "same"]);
    assert_eq!((code, said.as_str()), (Some(0), ""));

    let (code, said) = run(&["noise.csv", "--out", "none"]);
    assert!(code == Some(3) && said.contains("suspect_data"), "{code:?}: {said}");
    assert_eq!(entries(&folder.join("none")), ["manifest.json", "summary.json"]);
    let summary = json(&fs::read(folder.join("none/summary.json")).unwrap());
    assert_eq!(summary["judged"][0]["id"], "data.line_over_noise");
    assert_eq!(summary["warnings"][0]["id"], "data.noise");
    assert_eq!(summary["frequency_hz"], Value::Null);
}

#[test]
fn a_file_without_one_frequency_is_not_found_and_numbers_of_samples_are_no_channels() {
    let folder = scratch("average_beyond");
    let load = |k: u32, cycles: f64| {
        2.0 * (TAU * cycles).cos() + 0.7 * (TAU * 2.0 * cycles + 0.3).sin() + f64::from(k % 2) * 1e-3
    };
    let file = |cycles: &dyn Fn(f64) -> f64, seconds: f64| -> String {
        let row = |k: u32| {
            format!("{:.3},{},{:.5}\n", f64::from(k) * 1e-3, 100 + k, load(k, cycles(f64::from(k) * 1e-3)))
        };
        "t,sequence,Fz_N\n".to_owned() + &(0..(1000.0 * seconds) as u32).map(row).collect::<String>()
    };
    // From 5.2 to 6 Hz; and steady.
    fs::write(folder.join("sweep.csv"), file(&|t| 5.2 * t + 0.04 * t * t, 10.0)).unwrap();
    fs::write(folder.join("steady.csv"), file(&|t| 5.2 * t, 10.0)).unwrap();
    let run = |arguments: &[&str]| {
        let answer = wingbeat(&folder, &[&["average", "--quiet"], arguments].concat());
        (answer.status.code(), String::from_utf8(answer.stderr).unwrap())
    };
    let (code, said) = run(&["sweep.csv", "--out", "sweep"]);
    assert!(code == Some(3) && said.contains("not_found: lines stand above the noise"), "{code:?}: {said}");
    assert_eq!(run(&["steady.csv", "--out", "steady"]), (Some(0), String::new()));
    let summary = json(&fs::read(folder.join("steady/summary.json")).unwrap());
    assert_eq!(summary["channels"].as_array().unwrap().len(), 1, "{summary}");
    // By the rate it is another file.
    let (code, said) = run(&["steady.csv", "--rate", "500", "--out", "rate"]);
    assert_eq!(code, Some(0), "{said}");
    let warnings = json(&fs::read(folder.join("rate/summary.json")).unwrap())["warnings"].to_string();
    assert!(warnings.contains("data.rate") && warnings.contains("1000.0"), "{warnings}");
}

#[test]
fn a_column_of_time_stands_for_the_rate_and_bad_files_are_refused_by_line_and_column() {
    let folder = scratch("average_time");
    let rows = |text: String| -> String {
        let timed = text.lines().enumerate().map(|(k, row)| format!("{:.4},{row}\n", 2.5e-3 * k as f64));
        timed.collect()
    };
    let header = "t,fx_N,fy_N,fz_N,tx_Nm,ty_Nm,tz_Nm\n";
    // Samples of 1 kHz at steps of 2.5 ms: 2.08 Hz.
    let timed = rows(cell(5.2, 1.0, 0.2));
    fs::write(folder.join("timed.csv"), format!("{header}{timed}")).unwrap();
    let answer =
        wingbeat(&folder, &["average", "timed.csv", "--columns", "Fz,Ty", "--out", "a", "--bins", "50"]);
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    let summary = json(&fs::read(folder.join("a/summary.json")).unwrap());
    assert!((summary["frequency_hz"].as_f64().unwrap() - 2.08).abs() < 1e-3, "{summary}");
    assert_eq!(summary["channels"][1]["unit"], "Nm");
    assert_eq!(fs::read_to_string(folder.join("a/cycles.csv")).unwrap().lines().count(), 51);

    fs::write(folder.join("bad.csv"), format!("{header}{}0,1,2,x,4,5,6\n", rows("1,2,3,4,5,6\n".repeat(9))))
        .unwrap();
    for (arguments, words) in [
        (&["average", "bad.csv"][..], "bad.csv: line 11, column fz_N: `x` is not a number"),
        (&["average", "timed.csv", "--rate", "-1"], "--rate -1.0: allowed is above 0, at most 1e9 Hz"),
        (
            &["average", "timed.csv", "--frequency", "inf"],
            "--frequency inf: allowed is above 0, at most 1e9 Hz",
        ),
        (&["average", "timed.csv", "--bins", "1"], "--bins 1: allowed is a whole number from 2 to 10000"),
        (&["average", "timed.csv", "--frequency", "0.01"], "allowed is at least one whole cycle"),
        (
            &["average", "timed.csv", "--units", "N"],
            "--units: 1 for 6 channels; allowed is one for each, or two",
        ),
        (&["average", "timed.csv", "--units", "N,s"], "--units: `s` is no unit of moment; allowed are N m"),
        (&["average", "timed.csv", "--columns", "lift"], "--columns: no column `lift`; found t, fx_N"),
        (&["average", "none.csv"], "none.csv"),
    ] {
        let answer = wingbeat(&folder, arguments);
        let said = String::from_utf8(answer.stderr).unwrap();
        assert_eq!(
            (answer.status.code(), said.trim().lines().count()),
            (Some(2), 1),
            "{arguments:?}: {said}"
        );
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
    assert!(!folder.join("runs").exists() || entries(&folder.join("runs")).is_empty());
}

/// Cycles at rest among those that beat: their mean is neither.
#[test]
fn a_mean_cycle_that_is_that_of_none_is_not_periodic() {
    let folder = scratch("average_of_none");
    let mut seed = 5;
    let rest = (0..4000).map(|_| {
        let of = |i: u32| format!("{:.6}", 0.1 * f64::from(i) + 0.02 * noise(&mut seed));
        (0..6).map(of).collect::<Vec<_>>().join(",") + "\n"
    });
    fs::write(folder.join("cell.csv"), rest.collect::<String>() + &cell(5.0, 1.0, 0.02)).unwrap();
    let answer = |more: &[&str]| {
        let given = ["average", "cell.csv", "--rate", "1000", "--out", "a", "--force"];
        let answer = wingbeat(&folder, &[&given[..], more].concat());
        let told = fs::read(folder.join("a/summary.json"));
        let summary = json(&told.unwrap_or_else(|error| panic!("{error}: {answer:?}")));
        (answer.status.code(), summary["status"].clone(), summary["reason"].to_string())
    };
    let (code, status, reason) = answer(&[]);
    assert!(code == Some(3) && status == "not_periodic", "{code:?} {status} {reason}");
    assert!(reason.contains("none of them") && reason.contains("--rest SECONDS"), "{reason}");
    let (code, status, reason) = answer(&["--rest", "4"]);
    assert!(code == Some(0) && status == "ok", "{code:?} {status} {reason}");
}

#[test]
fn times_that_jitter_lose_no_cycle_and_lost_ones_are_told() {
    let folder = scratch("average-times");
    let mut seed = 3;
    let mut write = |name: &str, late: &dyn Fn(u32, f64) -> f64, keep: &dyn Fn(u32) -> bool, rows: u32| {
        let mut text = String::from("t [s],Fz [N]\n");
        for k in (0..rows).filter(|k| keep(*k)) {
            let t = f64::from(k) * 1e-3;
            let load = (TAU * 3.5 * t).cos() + 0.3 * (TAU * 7.0 * t).sin() + 0.02 * noise(&mut seed);
            text += &format!("{:.6},{load:.6}\n", t + late(k, noise(&mut seed)));
        }
        fs::write(folder.join(name), text).unwrap();
    };
    let lost = |k: u32| k % 200 == 17 + k / 200 * 37 % 100;
    write("jitter.csv", &|_, even| 3e-4 * even, &|_| true, 12_000);
    write("late.csv", &|_, even| if even > 0.96 { 7e-4 } else { 0.0 }, &|_| true, 12_000);
    write("gaps.csv", &|_, _| 0.0, &|k| ![100, 2344, 5432, 9000, 11_000].contains(&(k - k % 2)), 12_000);
    write("many.csv", &|_, _| 0.0, &|k| !lost(k), 12_000);
    write("one.csv", &|_, _| 0.0, &|_| true, 400);
    let told = |name: &str, more: &[&str]| {
        let out = format!("{name}.out");
        let answer =
            wingbeat(&folder, &[&["average", name, "--out", &out, "--quiet", "--force"], more].concat());
        let error = String::from_utf8(answer.stderr).unwrap();
        let summary = fs::read(folder.join(&out).join("summary.json"));
        (error, summary.map(|text| json(&text)).unwrap_or_default())
    };
    for name in ["jitter.csv", "late.csv"] {
        let (_, summary) = told(name, &[]);
        assert_eq!(
            (&summary["status"], summary["warnings"].as_array().unwrap().len()),
            (&"ok".into(), 0),
            "{summary}"
        );
        assert_eq!(
            (summary["samples"].as_u64(), summary["missing"].as_u64()),
            (Some(12_000), Some(0)),
            "{summary}"
        );
        assert!(summary["channels"][0]["cycles"].as_u64() >= Some(40), "{summary}");
    }
    // Of five of 41 cycles two samples are missing.
    let (_, summary) = told("gaps.csv", &[]);
    assert_eq!(summary["status"], "ok", "{summary}");
    assert_eq!(summary["warnings"][0]["id"], "data.cycles_left_out_told", "{summary}");
    // Each cycle has a gap.
    let (error, summary) = told("many.csv", &[]);
    assert!(error.contains("60 of 12000 samples are missing") && error.contains("--rate HZ"), "{error}");
    assert!(summary.is_null() && told("many.csv", &["--rate", "1000"]).1["status"] != Value::Null);
    // But for one all cycles have.
    write("most.csv", &|_, _| 0.0, &|k| k < 600 || !lost(k), 12_000);
    let (error, summary) = told("most.csv", &[]);
    assert_eq!(summary["status"], "suspect_data", "{summary}");
    assert!(error.contains("data.cycles_left_out_fraction") && error.contains("--rate HZ"), "{error}");
    // Of a single cycle no deviation is known.
    let (_, summary) = told("one.csv", &["--frequency", "3.5"]);
    let channel = &summary["channels"][0];
    assert_eq!((&channel["cycles"], &channel["std"]), (&1.into(), &Value::Null), "{summary}");
    let cycles = fs::read_to_string(folder.join("one.csv.out/cycles.csv")).unwrap();
    assert!(cycles.lines().nth(1).unwrap().ends_with("NaN"), "{cycles}");
}

/// Gaps that come again every third or fourth stroke make lines of their own in a spectrum, which are no strokes; strokes that differ by turns are.
#[test]
fn gaps_that_come_again_make_no_frequency() {
    let folder = scratch("average-gaps");
    let mut seed = 11;
    let mut found = |every: f64, gap: f64, by_turns: f64| {
        let mut text = "t,Fz\n".to_owned();
        for k in 0..12_000 {
            let t = f64::from(k) * 1e-3;
            let stroke = 3.5 * t;
            if (stroke / every).fract() * every > every - gap {
                continue;
            }
            let p = TAU * stroke;
            let load = 0.4 * p.cos()
                + 0.15 * (2.0 * p + 0.4).sin()
                + by_turns * (0.5 * p).cos()
                + 0.01 * noise(&mut seed);
            text += &format!("{t:.3},{load:.5}\n");
        }
        fs::write(folder.join("gaps.csv"), text).unwrap();
        let answer = wingbeat(&folder, &["average", "gaps.csv", "--out", "o", "--force"]);
        let summary = fs::read(folder.join("o/summary.json"));
        let told = String::from_utf8_lossy(&answer.stderr).into_owned();
        assert!(answer.status.code() != Some(2), "{every} {gap}: {told}");
        json(&summary.unwrap())["frequency_hz"].as_f64().unwrap()
    };
    for (every, gap) in [(4.0, 0.3), (4.0, 0.7), (4.0, 1.0), (3.0, 0.3), (3.0, 0.5), (2.0, 0.3)] {
        let frequency = found(every, gap, 0.0);
        assert!((frequency - 3.5).abs() < 0.01, "{every} {gap}: {frequency}");
    }
    let frequency = found(4.0, 0.3, 0.2);
    assert!((frequency - 1.75).abs() < 0.01, "{frequency}");
}

/// Fz = 1 + 0.3 cos + 1.5 cos 2 at so many samples a cycle.
fn two_harmonics(path: &std::path::Path, per_cycle: f64) {
    let (hz, seconds) = (7.313, 60.0);
    let rate = per_cycle * hz;
    let row = |k: usize| {
        let t = k as f64 / rate;
        let phase = std::f64::consts::TAU * hz * t;
        let noise = 0.01 * (12.9898 * k as f64).sin();
        format!("{t:.9},{}\n", 1.0 + 0.3 * phase.cos() + 1.5 * (2.0 * phase).cos() + noise)
    };
    let rows: String = (0..(seconds * rate) as usize).map(row).collect();
    fs::write(path, format!("t,Fz\n{rows}")).unwrap();
}

#[test]
fn a_mean_cycle_that_loses_its_second_harmonic_is_told() {
    let folder = scratch("average-sparse");
    for (per_cycle, code, words) in
        [(4.24, 3, "data.samples_per_cycle_of_loads"), (5.5, 0, "data.few_samples"), (9.3, 0, "")]
    {
        two_harmonics(&folder.join("a.csv"), per_cycle);
        let output = wingbeat(
            &folder,
            &["average", "a.csv", "--units", "N", "--frequency", "7.313", "--force", "--out", "o"],
        );
        let told =
            String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(code), "{per_cycle}: {told}");
        assert!(told.contains(words) && (!words.is_empty() || !told.contains("second harmonic")), "{told}");
    }
}
