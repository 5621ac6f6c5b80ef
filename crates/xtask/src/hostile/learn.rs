//! Class 8: a stranger learns every input and output from the program itself.

use std::fs;

use super::case::{ScriptedCase, refused};
use crate::tools;

/// Commands whose help says what each option is.
const COMMANDS: [&[&str]; 14] = [
    &["fly"],
    &["sweep"],
    &["tether"],
    &["wake"],
    &["plan"],
    &["rig"],
    &["rig", "plan"],
    &["rig", "simulate"],
    &["rig", "record"],
    &["rig", "emulate"],
    &["rig", "process"],
    &["validate"],
    &["new"],
    &["schema"],
];
/// Documents that `new` writes and that a command runs as they are.
const RUNNING: [(&str, &[&str]); 4] = [
    ("scenario", &["fly", "scenario.toml", "--set", "flight.duration_s=0.02"]),
    ("case", &["tether", "case.toml"]),
    ("sweep", &["sweep", "sweep.toml", "--set", "runs=1"]),
    ("run", &["rig", "plan", "run.toml"]),
];

/// The cases.
pub fn cases() -> Vec<ScriptedCase> {
    let kinds = kinds();
    let mut all: Vec<ScriptedCase> = COMMANDS.iter().map(|words| helped(words)).collect();
    all.extend(kinds.iter().flat_map(|kind| [begun(kind), described(kind)]));
    all.extend(RUNNING.iter().map(|(kind, words)| runs(kind, words)));
    all.extend([
        refused(8, "no_such_kind", &[], &["new", "spaceship"], &["spaceship"]),
        refused(8, "no_such_schema", &[], &["schema", "spaceship"], &["spaceship"]),
        units("flight", &["fly", "glide.toml"], &["record.parquet"]),
        units(
            "strips",
            &["fly", "glide.toml", "--set", "flight.record_strips_every_s=1e-3"],
            &["strips.parquet"],
        ),
        units("tether", &["tether", "{root}/cases/step.toml"], &["strips.parquet"]),
        units("rig", &["rig", "simulate", "hold.toml", "--set", "rig.rest_s=0"], &[]),
        tables(),
    ]);
    all
}

/// The kinds of documents, by their schemas.
fn kinds() -> Vec<String> {
    let entries = fs::read_dir(tools::root().join("docs/schema")).into_iter().flatten().flatten();
    let stem = |entry: fs::DirEntry| Some(entry.path().file_stem()?.to_string_lossy().into_owned());
    let mut kinds: Vec<String> = entries.filter_map(stem).collect();
    kinds.sort();
    kinds
}

/// `--help` of a command describes every option that it lists.
fn helped(words: &'static [&'static str]) -> ScriptedCase {
    ScriptedCase::new(8, format!("help_{}", words.join("_")), move |place| {
        let words: Vec<&str> = words.iter().copied().chain(["--help"]).collect();
        let said = place.run(&words)?.exits(0)?.stdout;
        let lines: Vec<&str> = said.lines().collect();
        let option = |i: &usize| lines[*i].trim_start().starts_with("--");
        for i in (0..lines.len()).filter(option) {
            let told = lines.get(i + 1).is_some_and(|next| !next.trim().is_empty());
            if !told && !lines[i].trim().contains("  ") {
                return Err(format!("nothing is said of {}", lines[i].trim()));
            }
        }
        if said.contains("Usage: ") { Ok(()) } else { Err("no usage".into()) }
    })
}

/// `new` writes a document that names its schema, and does not write over it.
fn begun(kind: &str) -> ScriptedCase {
    let kind = kind.to_owned();
    ScriptedCase::new(8, format!("new_{kind}"), move |place| {
        place.run(&["new", &kind])?.exits(0)?;
        let name = format!("{kind}.toml");
        let text = place.read(&name)?;
        if !text.contains("#:schema ") || !text.starts_with("# ") {
            return Err("no schema, or no comment".into());
        }
        let before = place.state()?;
        place.run(&["new", &kind])?.exits(2)?.says(&[&name])?;
        place.unchanged(&before)
    })
}

/// `schema` prints what lies in docs/schema.
fn described(kind: &str) -> ScriptedCase {
    let kind = kind.to_owned();
    ScriptedCase::new(8, format!("schema_{kind}"), move |place| {
        let said = place.run(&["schema", &kind])?.exits(0)?.stdout;
        let kept = fs::read_to_string(tools::root().join(format!("docs/schema/{kind}.json")));
        let read = |text: &str| serde_json::from_str::<serde_json::Value>(text).map_err(|e| e.to_string());
        let schema = read(&said)?;
        let same = schema == read(&kept.map_err(|error| error.to_string())?)?;
        let whole = schema["$schema"].is_string() && schema["properties"].is_object();
        if same && whole { Ok(()) } else { Err("not what docs/schema holds".into()) }
    })
}

/// What `new` writes runs.
fn runs(kind: &'static str, words: &'static [&'static str]) -> ScriptedCase {
    ScriptedCase::new(8, format!("run_{kind}"), move |place| {
        place.run(&["new", kind])?.exits(0)?;
        let words: Vec<&str> = words.iter().copied().chain(["--quiet", "--out", "a"]).collect();
        place.run(&words)?.exits(0).map(drop)
    })
}

/// Tables carry their units where pandas looks for them.
fn units(name: &str, words: &'static [&'static str], tables: &'static [&'static str]) -> ScriptedCase {
    ScriptedCase::new(8, format!("units_{name}"), move |place| {
        place.write_texts()?;
        let words: Vec<&str> = words.iter().copied().chain(["--quiet", "--out", "a"]).collect();
        place.run(&words)?.exits(0)?;
        let mut found = place.names("a")?;
        found.retain(|name| name.ends_with(".parquet"));
        if let Some(missing) = tables.iter().find(|table| !found.iter().any(|name| name == *table)) {
            return Err(format!("no {missing}"));
        }
        found.iter().try_for_each(|name| {
            let bytes = fs::read(place.path("a").join(name)).map_err(|error| error.to_string())?;
            let held = |word: &[u8]| bytes.windows(word.len()).any(|window| window == word);
            if held(b"PANDAS_ATTRS") && held(b"units") {
                Ok(())
            } else {
                Err(format!("{name} says no units"))
            }
        })
    })
}

/// Tables in text begin with the names of their columns.
fn tables() -> ScriptedCase {
    ScriptedCase::new(8, "tables_in_text", |place| {
        place.write_texts()?;
        place.run(&["sweep", "sweep.toml", "--quiet", "--out", "a"])?.exits(0)?;
        let mut found = place.names("a")?;
        found.retain(|name| name.ends_with(".csv"));
        found.iter().try_for_each(|name| {
            let text = place.read(&format!("a/{name}"))?;
            let first = text.lines().next().unwrap_or_default();
            let named = first.split(',').all(|word| word.parse::<f64>().is_err() && !word.starts_with('#'));
            if named { Ok(()) } else { Err(format!("{name} begins with {first}")) }
        })
    })
}
