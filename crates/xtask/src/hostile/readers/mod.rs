//! Files of others: damaged, lying, immense; recordings and their accounts; large real files.

mod bombs;
pub mod boxes;
mod files;
mod large;
pub mod pages;

use super::ScriptedCase;
use super::case::CaseOutcome;
use super::place::{CallEnd, CaseFolder};

/// The cases.
pub fn cases() -> Vec<ScriptedCase> {
    [bombs::cases(), files::cases(), pages::cases(), large::cases()].into_iter().flatten().collect()
}

/// The run that measured files are taken to be of.
const BENCH: &str = "{root}/rigs/runs/bench.toml";
/// Corrections by model left out.
const PLAIN: [&str; 6] = [
    "--set",
    "process.steps.gravity=false",
    "--set",
    "process.steps.mount_inertia=false",
    "--set",
    "process.steps.body_frame=false",
];

/// `rig process FILE` with these settings.
fn process(place: &CaseFolder, file: &str, set: &[&str]) -> Result<CallEnd, String> {
    let mut arguments = vec!["rig", "process", file, "--run", BENCH];
    set.iter().for_each(|set| arguments.extend(["--set", set]));
    arguments.extend(PLAIN);
    place.run(&arguments)
}

/// A file of samples that is refused by its name, with each of `words`, and leaves nothing.
fn refused_file(
    name: &str,
    file: &str,
    bytes: impl Fn() -> Vec<u8> + Send + Sync + 'static,
    set: &[&str],
    words: &[&str],
) -> ScriptedCase {
    let own = |list: &[&str]| -> Vec<String> { list.iter().map(|word| (*word).to_owned()).collect() };
    let (file, set, words) = (file.to_owned(), own(set), own(words));
    ScriptedCase::new(2, name, move |place| {
        place.write_bytes(&file, &bytes())?;
        let before = place.state()?;
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        process(place, &file, &set)?.exits(2)?.says(&[&file])?.says(&words)?;
        place.unchanged(&before)
    })
}

/// A JSON file of the case's folder.
pub fn json(place: &CaseFolder, name: &str) -> Result<serde_json::Value, String> {
    serde_json::from_str(&place.read(name)?).map_err(|error| format!("{name}: {error}"))
}

/// A condition with what it was about.
pub fn holds(condition: bool, what: impl ToString) -> CaseOutcome {
    if condition { Ok(()) } else { Err(what.to_string()) }
}

/// The header of a table of samples in N and N m.
pub const HEADER: &str = "time_s,fx_N,fy_N,fz_N,tx_Nm,ty_Nm,tz_Nm";

/// Sample `k` at `rate` of a robot that flaps at 3.5 Hz, hanging from the cell.
fn sample(k: usize, rate: f64) -> [f64; 7] {
    let t = k as f64 / rate;
    let (s, c) = (std::f64::consts::TAU * 3.5 * t).sin_cos();
    let ripple = 1e-3 * (k as f64 * 0.7).sin();
    [
        t,
        0.01 * c + ripple,
        0.02 * s - ripple,
        0.4 * s + 0.2 * s * c - 0.45 + ripple,
        1e-3 * s + 1e-3 * ripple,
        0.02 * c - 1e-3 * ripple,
        1e-3 * s * c + 1e-3 * ripple,
    ]
}

/// A table of `rows` samples at `rate`.
pub fn table(rows: usize, rate: f64, delimiter: char) -> Vec<u8> {
    use std::io::Write;
    let mut text = HEADER.replace(',', &delimiter.to_string()).into_bytes();
    text.reserve(rows * 100);
    for k in 0..rows {
        for (i, value) in sample(k, rate).iter().enumerate() {
            let between = if i == 0 { '\n' } else { delimiter };
            let _ = write!(text, "{between}{value:.10}");
        }
    }
    text.push(b'\n');
    text
}
