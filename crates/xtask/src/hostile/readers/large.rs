//! Class 6: real files of many minutes, in any format: time and memory are those of every call (60 s, 1 GB), figures
//! stay small, and what is averaged is what was measured.

use super::super::case::CaseOutcome;
use super::super::place::CaseFolder;
use super::{HEADER, ScriptedCase, holds, json, process, sample, table};

/// Samples per second of the box.
const RATE: f64 = 7000.0;
/// Largest figure, bytes.
const MOST_FIGURE: u64 = 2 << 20;
/// A minute.
const MINUTE: usize = 7000 * 60;

/// The cases.
pub fn cases() -> Vec<ScriptedCase> {
    let mut all = vec![
        whole("ten_minutes_csv", "long.csv", || table(10 * MINUTE, RATE, ','), &[], 2099).alone(),
        whole(
            "ten_minutes_by_frequency",
            "long.csv",
            || table(10 * MINUTE, RATE, ','),
            &["process.phase=frequency"],
            2100,
        )
        .alone(),
        whole("ten_minutes_npy", "long.npy", || npy(10 * MINUTE), MATRIX, 2099).alone(),
        whole("ten_minutes_mat", "long.mat", || matlab4(10 * MINUTE), UNITS, 2099).alone(),
    ];
    for (name, minutes) in [("one", 1), ("two", 2), ("three", 3)] {
        let cycles = minutes * 210 - 1;
        let rows = minutes * MINUTE;
        all.extend([
            whole(&format!("{name}_csv"), "long.csv", move || table(rows, RATE, ','), &[], cycles),
            whole(&format!("{name}_semicolons"), "long.csv", move || decimal_commas(rows), &[], cycles),
            whole(&format!("{name}_tabs"), "long.txt", move || table(rows, RATE, '\t'), &[], cycles),
            whole(&format!("{name}_npy"), "long.npy", move || npy(rows), MATRIX, cycles),
            whole(&format!("{name}_mat"), "long.mat", move || matlab4(rows), UNITS, cycles),
            whole(&format!("{name}_unfiltered"), "long.npy", move || npy(rows), UNFILTERED, cycles),
            whole(&format!("{name}_more_columns"), "long.csv", move || more_columns(rows), &[], cycles),
            whole(&format!("{name}_holes"), "long.csv", move || holed(rows), BRIDGED, cycles),
            cut(&format!("{name}_cut"), rows),
        ]);
    }
    all
}

const UNITS: &[&str] =
    &["process.input.units.force=N", "process.input.units.moment=N m", "process.input.units.time=s"];
const MATRIX: &[&str] = &[
    "process.input.columns={t=\"long[0]\",Fx=\"long[1]\",Fy=\"long[2]\",Fz=\"long[3]\",Tx=\"long[4]\",Ty=\"long[5]\",\
     Tz=\"long[6]\"}",
    "process.input.units={force=\"N\",moment=\"N m\",time=\"s\"}",
];
const UNFILTERED: &[&str] = &[MATRIX[0], MATRIX[1], "process.steps.cutoff_multiple=0"];
const BRIDGED: &[&str] = &["process.input.bridge_samples=3"];

/// A file that is processed within the limits; this many cycles, Fz as it was put in, figures of bounded size.
fn whole(
    name: &str,
    file: &'static str,
    bytes: impl Fn() -> Vec<u8> + Send + Sync + 'static,
    set: &'static [&'static str],
    cycles: usize,
) -> ScriptedCase {
    let case = ScriptedCase::new(6, name, move |place: &CaseFolder| {
        place.write_bytes(file, &bytes())?;
        // The window of the run ends with it; here it is the whole file.
        let set = [&["process.window_s=[0,1e5]"], set].concat();
        process(place, file, &set)?.exits(0)?;
        let summary = json(place, "long-processed/summary.json")?;
        let run = &summary["runs"]["bench"];
        let found = run["cycles"].as_u64().unwrap_or(0) + run["cycles_left_out"].as_u64().unwrap_or(0);
        holds(found.abs_diff(cycles as u64) <= 1, run)?;
        small_figures(place)
    });
    case.long()
}

fn small_figures(place: &CaseFolder) -> CaseOutcome {
    for name in place.names("long-processed/figures/bench")? {
        let path = place.path("long-processed/figures/bench").join(&name);
        let size = std::fs::metadata(&path).map_err(|error| format!("{name}: {error}"))?.len();
        holds(size <= MOST_FIGURE, format!("{name}: {size} bytes"))?;
    }
    Ok(())
}

/// A long file that lacks its end.
fn cut(name: &str, rows: usize) -> ScriptedCase {
    let case = ScriptedCase::new(6, name, move |place: &CaseFolder| {
        let bytes = table(rows, RATE, ',');
        place.write_bytes("long.csv", &bytes[..bytes.len() - 5])?;
        let word = format!("cut short at sample {}", rows - 1);
        process(place, "long.csv", &[])?.exits(2)?.says(&["long.csv", &word])?;
        place.holds("", &["long.csv"])
    });
    case.long()
}

fn decimal_commas(rows: usize) -> Vec<u8> {
    let mut bytes = table(rows, RATE, ';');
    let header = HEADER.len();
    bytes[header..].iter_mut().filter(|byte| **byte == b'.').for_each(|byte| *byte = b',');
    bytes
}

/// Eleven columns of which nobody asked.
fn more_columns(rows: usize) -> Vec<u8> {
    let text = String::from_utf8(table(rows, RATE, ',')).unwrap_or_default();
    let mut more = String::with_capacity(2 * text.len());
    for (k, line) in text.lines().enumerate() {
        more += line;
        for c in 0..11 {
            more += &if k == 0 { format!(",more{c}") } else { format!(",{}", k + c) };
        }
        more.push('\n');
    }
    more.into_bytes()
}

/// Every thousandth row is missing.
fn holed(rows: usize) -> Vec<u8> {
    let text = String::from_utf8(table(rows, RATE, ',')).unwrap_or_default();
    let kept = text.lines().enumerate().filter(|(k, _)| k % 1000 != 500);
    kept.map(|(_, line)| format!("{line}\n")).collect::<String>().into_bytes()
}

/// The seven columns as one array.
fn npy(rows: usize) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, 7), }}\n");
    let length = (header.len() as u16).to_le_bytes();
    let mut bytes = [&b"\x93NUMPY\x01\x00"[..], &length, header.as_bytes()].concat();
    (0..rows).for_each(|k| sample(k, RATE).iter().for_each(|x| bytes.extend(x.to_le_bytes())));
    bytes
}

/// The seven columns as matrices of MATLAB level 4.
fn matlab4(rows: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (c, name) in ["t", "Fx", "Fy", "Fz", "Tx", "Ty", "Tz"].iter().enumerate() {
        let words = [0, rows as u32, 1, 0, name.len() as u32 + 1];
        words.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
        bytes.extend(name.as_bytes());
        bytes.push(0);
        (0..rows).for_each(|k| bytes.extend(sample(k, RATE)[c].to_le_bytes()));
    }
    bytes
}
