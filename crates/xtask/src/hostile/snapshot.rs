//! Class 4: logs of sweeps take no foreign rows, files are read once; runs that are made again are data, `snapshots.toml`.

use std::time::Duration;

use super::case::{CaseOutcome, ScriptedCase};
use super::data::{GLIDE, SWEEP};
use super::place::CaseFolder;

/// Keys of a summary that hold times.
const TIMES: [&str; 13] = [
    "search_s",
    "real_time_factor",
    "median_us",
    "p99_us",
    "p999_us",
    "max_us",
    "answer_median_us",
    "answer_p999_us",
    "late",
    "wall_s",
    "solve_s",
    "processor_s",
    "wall_time_s",
];

/// Two summaries are the same but for times.
pub fn same_summary(place: &CaseFolder, a: &str, b: &str) -> CaseOutcome {
    let read = |name: &str| -> Result<serde_json::Value, String> {
        let mut value =
            serde_json::from_str(&place.read(name)?).map_err(|error| format!("{name}: {error}"))?;
        strip(&mut value);
        Ok(value)
    };
    if read(a)? == read(b)? { Ok(()) } else { Err(format!("{a} and {b} differ")) }
}

/// Takes times out of a summary.
pub fn strip(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::Object(map) => {
            map.retain(|key, _| !TIMES.contains(&key.as_str()));
            map.values_mut().for_each(strip);
        }
        serde_json::Value::Array(items) => items.iter_mut().for_each(strip),
        _ => {}
    }
}

/// Flies the sweep for a while, then stops it; the names of what it left.
fn stopped(place: &CaseFolder) -> CaseOutcome {
    place.write_texts()?;
    let words = ["sweep", "sweep.toml", "--quiet", "--out", "a", "--set", "runs=100000"];
    place.call(&words).signal("INT", Duration::from_millis(500)).run()?.exits(130).map(drop)
}

/// A stopped sweep, spoiled by `spoil`, then `words`: refused with `say`, and nothing is lost.
fn spoiled(
    name: &str,
    spoil: fn(&CaseFolder) -> CaseOutcome,
    words: &'static [&'static str],
    say: &'static [&'static str],
) -> ScriptedCase {
    ScriptedCase::new(4, format!("sweep_{name}"), move |place| {
        stopped(place)?;
        spoil(place)?;
        let before = place.state()?;
        let words: Vec<&str> = words.iter().copied().chain(["--quiet", "--out", "a"]).collect();
        place.run(&words)?.exits(2)?.says(say)?;
        place.unchanged(&before)
    })
    .long()
}

fn log(place: &CaseFolder, change: impl Fn(&str) -> String) -> CaseOutcome {
    let text = place.read(".a.partial/flights.log")?;
    place.write(".a.partial/flights.log", &change(&text))
}

/// The log with another value in one field of its first row: rows stand in the order in which flights ended.
fn with_field(text: &str, field: usize, value: &str) -> String {
    let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
    let mut fields: Vec<&str> = first.split(',').collect();
    if let Some(changed) = fields.get_mut(field) {
        *changed = value;
    }
    format!("{}\n{rest}", fields.join(","))
}

/// The cases.
pub fn cases() -> Vec<ScriptedCase> {
    const SAME: &[&str] = &["sweep", "sweep.toml", "--set", "runs=100000"];
    const LOG: &[&str] = &["flights.log"];
    let nothing: fn(&CaseFolder) -> CaseOutcome = |_| Ok(());
    vec![
        spoiled(
            "other_runs",
            nothing,
            &["sweep", "sweep.toml", "--set", "runs=99999"],
            &["--out a", "other settings"],
        ),
        spoiled(
            "other_seed",
            nothing,
            &["sweep", "sweep.toml", "--set", "runs=100000", "--seed", "2"],
            &["--out a"],
        ),
        spoiled(
            "other_name",
            nothing,
            &["sweep", "sweep.toml", "--set", "runs=100000", "--set", "name=b"],
            &["--out a"],
        ),
        spoiled("other_command", nothing, &["fly", "glide.toml"], &["--out a", "waits"]),
        spoiled(
            "other_scenario",
            |p| p.write("glide.toml", &GLIDE.replace("nose_up_deg = -5.0", "nose_up_deg = -6.0")),
            SAME,
            &["--out a"],
        ),
        spoiled(
            "other_robot",
            |p| {
                let robot = std::fs::read_to_string(crate::tools::root().join("robots/aerobat_beta.toml"));
                p.write(
                    "robot.toml",
                    &robot.map_err(|error| error.to_string())?.replace("0.034168", "0.034169"),
                )?;
                p.write("glide.toml", &GLIDE.replace("{root}/robots/aerobat_beta.toml", "robot.toml"))
            },
            SAME,
            &["--out a"],
        ),
        spoiled("foreign_row", |p| log(p, |text| with_field(text, 1, "9.0")), SAME, LOG),
        spoiled("row_beyond", |p| log(p, |text| with_field(text, 0, "100000")), SAME, LOG),
        spoiled("row_of_half", |p| log(p, |text| with_field(text, 0, "0.5")), SAME, LOG),
        spoiled(
            "row_twice",
            |p| log(p, |text| format!("{text}{}\n", text.lines().next().unwrap_or_default())),
            SAME,
            LOG,
        ),
        spoiled("short_row", |p| log(p, |text| format!("1,2\n{text}")), SAME, LOG),
        spoiled("no_row", |p| log(p, |text| format!("hello\n{text}")), SAME, LOG),
        spoiled("no_text", |p| p.write_bytes(".a.partial/flights.log", b"\xff\xfe\n"), SAME, LOG),
        ScriptedCase::new(4, "sweep_cut_row", |place| {
            place.write_texts()?;
            place
                .run(&["sweep", "sweep.toml", "--quiet", "--out", "whole", "--set", "runs=3000"])?
                .exits(0)?;
            let words = ["sweep", "sweep.toml", "--quiet", "--out", "a", "--set", "runs=3000"];
            place.call(&words).signal("KILL", Duration::from_millis(250)).run()?;
            log(place, |text| text[..text.len() - 4].to_owned())?;
            place.call(&words).signal("KILL", Duration::from_millis(100)).run()?;
            place.run(&words)?.exits(0)?;
            place.same("a/flights.csv", "whole/flights.csv")
        })
        .long(),
        ScriptedCase::new(4, "sweep_reads_once", |place| {
            place.write_texts()?;
            let robot = std::fs::read_to_string(crate::tools::root().join("robots/aerobat_beta.toml"));
            let robot = robot.map_err(|error| error.to_string())?;
            place.write("robot.toml", &robot)?;
            place.write("glide.toml", &GLIDE.replace("{root}/robots/aerobat_beta.toml", "robot.toml"))?;
            let words = ["sweep", "sweep.toml", "--quiet", "--set", "runs=3000", "--out"];
            place.call(&words).argument("whole".into()).run()?.exits(0)?;
            let call = place.call(&words).argument("a".into());
            let running = call.start()?;
            std::thread::sleep(Duration::from_millis(400));
            place.write("robot.toml", &robot.replace("0.034168", "0.134168"))?;
            running.end(Duration::from_secs(60))?.exits(0)?;
            place.same("a/flights.csv", "whole/flights.csv")
        })
        .long(),
        ScriptedCase::new(4, "sweep_table_with_robot_file", |place| {
            place.write_texts()?;
            let inside = GLIDE.replace("name", "scenario.name").replace("robot =", "scenario.robot =");
            let inside = ["air", "aero", "start", "flight"].iter().fold(inside, |text, key| {
                text.replace(&format!("\n{key} ="), &format!("\nscenario.{key} ="))
            });
            place.write("sweep.toml", &(SWEEP.replace("scenario = \"glide.toml\"\n", "") + &inside))?;
            place.run(&["sweep", "sweep.toml", "--quiet", "--out", "a"])?.exits(0).map(drop)
        }),
    ]
}
