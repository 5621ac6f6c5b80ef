//! Class 5: files that contradict themselves or the keys beside them.

use std::fs;

use super::{BENCH, Case, HEADER, holds, json, process, table};
use crate::tools;

/// The cases.
pub fn cases() -> Vec<Case> {
    [cuts(), columns(), units(), rates(), counts()].into_iter().flatten().collect()
}

/// A file of samples that is refused by its name and with each of `words`.
fn refused(
    name: &str,
    text: impl Fn() -> String + Send + Sync + 'static,
    set: &[&str],
    words: &[&str],
) -> Case {
    let case = super::refused_file(name, "taken.csv", move || text().into_bytes(), set, words);
    Case { class: 5, ..case }
}

/// Two seconds at 1 kHz.
fn whole() -> String {
    String::from_utf8(table(2000, 1000.0, ',')).unwrap_or_default()
}

fn headed(header: &'static str) -> impl Fn() -> String + Send + Sync + 'static {
    move || whole().replacen(HEADER, header, 1)
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

fn cuts() -> Vec<Case> {
    let cut = |bytes: usize| {
        move || {
            let text = whole();
            text[..text.len() - bytes].to_owned()
        }
    };
    vec![
        refused("cut_line_break", cut(1), &[], &["cut short at sample 1999", "no line break"]),
        refused("cut_one_digit", cut(2), &[], &["cut short at sample 1999", "no line break"]),
        refused("cut_half_number", cut(8), &[], &["cut short at sample 1999"]),
        refused("cut_at_comma", cut(13), &[], &["cut short at sample 1999"]),
        refused("cut_column", cut(20), &[], &["cut short at sample 1999", "6 of 7 columns"]),
        refused("ragged", || whole() + "1,2,3\n0,0,0,0,0,0,0\n", &[], &["line 2002: 3 columns"]),
        refused("word", || whole() + "1,2,3,4,five,6,7\n", &[], &["line 2002", "`five` is not a number"]),
        refused("infinite", || whole() + "2,0,0,inf,0,0,0\n", &[], &["line 2002", "`inf` is not a number"]),
    ]
}

fn columns() -> Vec<Case> {
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
        refused(
            "one_for_two",
            whole,
            &["process.input.columns.Fx=fy_N"],
            &["column fy_N would be Fx and Fy", "process.input.columns.Fx"],
        ),
        refused("one_for_time", whole, &["process.input.columns.t=fy_N"], &["column fy_N would be Fy and t"]),
        refused("no_such_column", whole, &["process.input.columns.Fx=up"], &["no column `up` for Fx"]),
        refused("no_such_channel", whole, &["process.input.columns.F=fx_N"], &["process.input.columns.F"]),
        refused("missing", headed("time_s,fx_N,fy_N,up_N,tx_Nm,ty_Nm,tz_Nm"), &[], &["no column for Fz"]),
    ]
}

fn units() -> Vec<Case> {
    vec![
        refused(
            "unit_by_key",
            whole,
            &["process.input.units.force=lbf"],
            &["unit lbf by process.input.units.force, but N by the column's name"],
        ),
        refused(
            "unit_by_line",
            || format!("# units: s, mN, mN, mN, N m, N m, N m\n{}", whole()),
            &[],
            &["unit mN by the file, but N by the column's name"],
        ),
        refused(
            "unit_time",
            whole,
            &["process.input.units.time=ms"],
            &["unit ms by process.input.units.time, but s by the column's name"],
        ),
        refused(
            "unit_unknown",
            headed("time_s,fx [stone],fy_N,fz_N,tx_Nm,ty_Nm,tz_Nm"),
            &[],
            &["unit `stone` is not known"],
        ),
        refused(
            "unit_missing",
            headed("time_s,fx,fy,fz,tx,ty,tz"),
            &[],
            &["column fx: unit missing", "process.input.units.force=UNIT"],
        ),
        refused(
            "counts_unused",
            whole,
            &["process.input.counts_per_newton=1e6"],
            &["process.input.counts_per_newton is for columns in counts"],
        ),
        refused(
            "counts_missing",
            headed("time_s,fx_counts,fy_counts,fz_counts,tx_Nm,ty_Nm,tz_Nm"),
            &[],
            &["process.input.counts_per_newton=N"],
        ),
        key("counts_denormal", "process.input.counts_per_newton=1e-320"),
        key("counts_zero", "process.input.counts_per_newton_metre=0"),
    ]
}

/// A table from which some rows are missing.
fn holed() -> String {
    let whole = whole();
    let kept = whole.lines().enumerate().filter(|(k, _)| !(700..740).contains(k));
    kept.map(|(_, line)| format!("{line}\n")).collect()
}

/// A file that is processed although a key contradicts it, which is said.
fn said(name: &str, text: fn() -> String, rate: &'static str, part: &'static str) -> Case {
    Case::new(5, name, move |place| {
        place.write("taken.csv", &text())?;
        let key = rate.split('=').next().unwrap_or_default();
        process(place, "taken.csv", &[rate, "process.phase=frequency"])?
            .exits(0)?
            .prints(&["caution", key, part])?;
        let summary = json(place, "taken-processed/summary.json")?;
        let cautions = &summary["runs"]["bench"]["import"]["cautions"];
        holds(cautions[0].as_str().is_some_and(|text| text.contains(part)), cautions)
    })
}

/// A setting that is refused by its key before any file is read.
fn key(name: &str, set: &str) -> Case {
    let arguments = ["rig", "process", "taken.csv", "--run", BENCH, "--set", set];
    let key = set.split('=').next().unwrap_or_default();
    super::super::case::refused(5, name, &[("taken.csv", "t,Fx\n0,0\n")], &arguments, &[key])
}

fn rates() -> Vec<Case> {
    vec![
        said("rate_over_holes", holed, "process.input.rate_hz=1000", "40 samples missing"),
        said("rate_twice", whole, "process.input.rate_hz=2000", "1000.000000 Hz"),
        key("rate_zero", "process.input.rate_hz=0"),
        key("rate_negative", "process.input.rate_hz=-7000"),
        refused("time_back", || whole() + "0.5,0,0,0,0,0,0\n", &[], &["time goes back at sample 2000"]),
        refused(
            "time_still",
            || format!("{HEADER}\n{}", "1,0,0,0,0,0,0\n".repeat(500)),
            &[],
            &["repeat the time"],
        ),
        refused("time_far", || whole() + "1e9,0,0,0,0,0,0\n", &[], &["samples are missing"]),
        refused("window_short", whole, &["process.window_s=[0.5,0.6]"], &["process.window_s = 0.35 cycles"]),
    ]
}

/// The demo application's file with another factor.
fn factor(name: &str, value: &'static str) -> Case {
    let text = move || {
        let file = tools::root().join("crates/wingbeat-io/tests/data/samples/ati_counts.csv");
        let text = fs::read_to_string(file).unwrap_or_default();
        text.replace("Counts per Unit Force: 1000000.0", &format!("Counts per Unit Force: {value}"))
    };
    refused(name, text, &[], &["counts per unit force", "allowed is a number"])
}

fn counts() -> Vec<Case> {
    vec![
        factor("ati_denormal", "1e-320"),
        factor("ati_zero", "0"),
        factor("ati_negative", "-1"),
        factor("ati_nan", "nan"),
        factor("ati_huge", "1e300"),
        factor("ati_word", "many"),
    ]
}
