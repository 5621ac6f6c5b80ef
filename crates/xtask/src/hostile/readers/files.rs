//! Class 5: tables with one column more or rows less; the other files that contradict themselves are data, `files.toml`.

use super::{ScriptedCase, holds, json, process, table};

/// The cases.
pub fn cases() -> Vec<ScriptedCase> {
    columns().into_iter().chain(rates()).collect()
}

/// A file of samples that is refused by its name and with each of `words`.
fn refused(
    name: &str,
    text: impl Fn() -> String + Send + Sync + 'static,
    set: &[&str],
    words: &[&str],
) -> ScriptedCase {
    let case = super::refused_file(name, "taken.csv", move || text().into_bytes(), set, words);
    ScriptedCase { class: 5, ..case }
}

/// Two seconds at 1 kHz.
fn whole() -> String {
    String::from_utf8(table(2000, 1000.0, ',')).unwrap_or_default()
}

/// The table with one more column of this name, twice Fx.
fn with_more(name: &'static str) -> impl Fn() -> String + Send + Sync + 'static {
    move || {
        let more = |(k, line): (usize, &str)| {
            let cell = if k == 0 { name } else { line.split(',').nth(1).unwrap_or_default() };
            format!("{line},{cell}\n")
        };
        whole().lines().enumerate().map(more).collect()
    }
}

/// Columns that could be one another; the other cases are data.
fn columns() -> Vec<ScriptedCase> {
    let set = "process.input.columns";
    vec![
        refused("twice_fx", with_more("force_x_N"), &[], &["fx_N, force_x_N could all be Fx", set]),
        refused("twice_tx", with_more("mx_Nm"), &[], &["could all be Tx"]),
        refused("twice_time", with_more("time"), &[], &["could all be t"]),
        refused("same_name", with_more("fx_N"), &[], &["fx_N, fx_N could all be Fx"]),
        refused(
            "same_name_named",
            with_more("fx_N"),
            &["process.input.columns.Fx=fx_N"],
            &["several columns are called `fx_N`"],
        ),
    ]
}

/// A table from which some rows are missing.
fn holed() -> String {
    let whole = whole();
    let kept = whole.lines().enumerate().filter(|(k, _)| !(700..740).contains(k));
    kept.map(|(_, line)| format!("{line}\n")).collect()
}

/// A file that is processed although a key contradicts it, which is said; `exit` says what its data are held for.
fn said(name: &str, text: fn() -> String, rate: &'static str, part: &'static str, exit: i32) -> ScriptedCase {
    ScriptedCase::new(5, name, move |place| {
        place.write("taken.csv", &text())?;
        let key = rate.split('=').next().unwrap_or_default();
        process(place, "taken.csv", &[rate, "process.phase=frequency"])?
            .exits(exit)?
            .prints(&["caution", key, part])?;
        let summary = json(place, "taken-processed/summary.json")?;
        let cautions = &summary["runs"]["bench"]["import"]["cautions"];
        holds(cautions[0].as_str().is_some_and(|text| text.contains(part)), cautions)
    })
}

fn rates() -> Vec<ScriptedCase> {
    vec![
        // The rate closes the holes: the cycle is too short by what is missing.
        said("rate_over_holes", holed, "process.input.rate_hz=1000", "40 samples missing", 3),
        said("rate_twice", whole, "process.input.rate_hz=2000", "1000.000000 Hz", 0),
    ]
}
