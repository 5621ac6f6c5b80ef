//! Class 4: files are read once, run folders fly again from anywhere, logs take no foreign rows.

use std::time::Duration;

use super::case::{Case, Judged};
use super::place::Place;
use super::runs::{GLIDE, HOLD, SWEEP};

/// Keys of a summary that hold times.
const TIMES: [&str; 9] = [
    "real_time_factor",
    "median_us",
    "p99_us",
    "p999_us",
    "max_us",
    "late",
    "wall_s",
    "solve_s",
    "wall_time_s",
];

/// The cases.
pub fn cases() -> Vec<Case> {
    let mut all = again();
    all.extend(sweeps());
    all
}

fn written(place: &Place) -> Judged {
    place.write("glide.toml", GLIDE)?;
    place.write("sweep.toml", SWEEP)?;
    place.write("hold.toml", HOLD)?;
    place.write("elsewhere/none", "")
}

/// Two summaries are the same but for times.
fn same_summary(place: &Place, a: &str, b: &str) -> Judged {
    let read = |name: &str| -> Result<serde_json::Value, String> {
        let mut value =
            serde_json::from_str(&place.read(name)?).map_err(|error| format!("{name}: {error}"))?;
        strip(&mut value);
        Ok(value)
    };
    if read(a)? == read(b)? { Ok(()) } else { Err(format!("{a} and {b} differ")) }
}

fn strip(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::Object(map) => {
            map.retain(|key, _| !TIMES.contains(&key.as_str()));
            map.values_mut().for_each(strip);
        }
        serde_json::Value::Array(items) => items.iter_mut().for_each(strip),
        _ => {}
    }
}

/// Runs `words` into `a`, then the file `again` of it from another folder into `b`: `same` files have the same bytes,
/// the summaries agree.
fn flies_again(
    name: &str,
    words: &'static [&'static str],
    again: &'static [&'static str],
    same: &'static [&'static str],
    summary: &'static str,
) -> Case {
    Case::new(4, format!("again_{name}"), move |place| {
        written(place)?;
        let with = |words: &'static [&'static str], out| -> Vec<&'static str> {
            words.iter().copied().chain(["--quiet", "--out", out]).collect()
        };
        place.run(&with(words, "a"))?.exits(0)?;
        // What they were made of changes: the run does not.
        ["glide.toml", "sweep.toml", "hold.toml", "table.csv"]
            .iter()
            .try_for_each(|name| place.write(name, "gone"))?;
        place.call(&with(again, "../b")).within("elsewhere").run()?.exits(0)?;
        same.iter().try_for_each(|file| place.same(&format!("a/{file}"), &format!("b/{file}")))?;
        if summary.is_empty() {
            return Ok(());
        }
        same_summary(place, &format!("a/{summary}"), &format!("b/{summary}"))
    })
}

fn again() -> Vec<Case> {
    let fly = |name: &str, words| {
        flies_again(
            name,
            words,
            &["fly", "../a/scenario.toml"],
            &["record.parquet", "scenario.toml"],
            "summary.json",
        )
    };
    let tether = |name: &str, words| {
        let same = &["loads.csv", "strips.parquet", "means.csv"];
        flies_again(name, words, &["tether", "../a/case.toml"], same, "summary.json")
    };
    let simulate = |name: &str, words| {
        let same = &["ho/record.parquet", "ho/scenario.toml"];
        flies_again(name, words, &["rig", "simulate", "../a/ho/scenario.toml"], same, "ho/summary.json")
    };
    vec![
        fly("fly", &["fly", "glide.toml"]),
        fly("fly_seed", &["fly", "glide.toml", "--seed", "7", "--set", "air.gust_m_s=0.3"]),
        fly(
            "fly_set",
            &[
                "fly",
                "glide.toml",
                "--set",
                "robot.body.mass_kg=0.04",
                "--set",
                "air.wind_m_s=[0.1, 0.2, 0.3]",
            ],
        ),
        fly("fly_full", &["fly", "glide.toml", "--set", "aero.preset=full", "--set", "flight.flapping=true"]),
        fly("turn", &["fly", "{root}/scenarios/banking_turn.toml", "--set", "flight.duration_s=0.1"]),
        fly("motor", &["fly", "{root}/scenarios/motor_flapper.toml", "--set", "flight.duration_s=0.02"]),
        fly("four_wings", &["fly", "{root}/scenarios/four_wings.toml", "--set", "flight.duration_s=0.02"]),
        fly("glider", &["fly", "{root}/scenarios/glider.toml", "--set", "flight.duration_s=0.02"]),
        fly("elastic", &["fly", "{root}/scenarios/aerobat_elastic.toml", "--set", "flight.duration_s=0.02"]),
        tether("tether", &["tether", "{root}/cases/step.toml", "--set", "time.steps_per_cycle=100"]),
        tether("tether_flap", &["tether", "{root}/cases/flap_fold.toml", "--set", "time.cycles=1"]),
        simulate("simulate", &["rig", "simulate", "hold.toml", "--set", "rig.rest_s=0"]),
        simulate("simulate_seed", &["rig", "simulate", "hold.toml", "--set", "rig.rest_s=0", "--seed", "9"]),
        flies_again(
            "sweep",
            &["sweep", "sweep.toml"],
            &["sweep", "../a/sweep.toml"],
            &["flights.csv", "record.parquet", "sweep.toml"],
            "summary.json",
        ),
        flies_again(
            "sweep_seed",
            &["sweep", "sweep.toml", "--seed", "5", "--set", "runs=5"],
            &["sweep", "../a/sweep.toml"],
            &["flights.csv", "record.parquet", "sweep.toml"],
            "summary.json",
        ),
        flies_again(
            "rig_plan",
            &["rig", "plan", "{root}/rigs/runs/roll15_speed08.toml"],
            &["rig", "plan", "../a/roll15_speed08.toml"],
            &["roll15_speed08.csv", "roll15_speed08.yaml", "roll15_speed08.json", "roll15_speed08.toml"],
            "",
        ),
        Case::new(4, "again_tables", |place| {
            written(place)?;
            let rows: String = (0..21).map(|i| format!("{},{}\n", f64::from(i) * 0.05, i * i)).collect();
            place.write("x/table.csv", &format!("t,angle\n{rows}"))?;
            place.write("y/table.csv", &format!("t,angle\n{}", rows.replace(",1\n", ",2\n")))?;
            let wing = "wing.planform = [{ arc_m = 0.0, leading_edge_m = 0.0, trailing_edge_m = -1.0 }, \
                        { arc_m = 2.0, leading_edge_m = 0.0, trailing_edge_m = -1.0 }]";
            let table =
                |at: &str| format!("{{ table = {{ file = \"{at}/table.csv\", column = \"angle\" }} }}");
            place.write(
                "case.toml",
                &format!(
                    "name = \"t\"\n{wing}\nbody.nose_up_deg = {}\nbody.roll_deg = {}\n\
                     wind = {{ speed_m_s = 1.0, density_kg_m3 = 1.2 }}\naero.law = \"linear\"\n\
                     time = {{ frequency_hz = 1.0, cycles = 1, steps_per_cycle = 40 }}\n",
                    table("x"),
                    table("y")
                ),
            )?;
            place.run(&["tether", "case.toml", "--quiet", "--out", "a"])?.exits(0)?;
            std::fs::remove_dir_all(place.path("x")).map_err(|error| error.to_string())?;
            let call = place.call(&["tether", "../a/case.toml", "--quiet", "--out", "../b"]);
            call.within("elsewhere").run()?.exits(0)?;
            place.same("a/loads.csv", "b/loads.csv")
        }),
        Case::new(4, "list_keeps_seeds", |place| {
            written(place)?;
            place.write("two.toml", &HOLD.replace("\"ho\"", "\"two\""))?;
            place.write("list.toml", "runs = [\"two.toml\", \"hold.toml\"]\n")?;
            place
                .run(&[
                    "rig",
                    "simulate",
                    "list.toml",
                    "--set",
                    "rig.rest_s=0",
                    "--seed",
                    "3",
                    "--quiet",
                    "--out",
                    "a",
                ])?
                .exits(0)?;
            place.run(&["rig", "simulate", "a/ho/scenario.toml", "--quiet", "--out", "b"])?.exits(0)?;
            place.same("a/ho/record.parquet", "b/ho/record.parquet")
        }),
    ]
}

/// Flies the sweep for a while, then stops it; the names of what it left.
fn stopped(place: &Place) -> Judged {
    written(place)?;
    let words = ["sweep", "sweep.toml", "--quiet", "--out", "a", "--set", "runs=100000"];
    place.call(&words).signal("INT", Duration::from_millis(500)).run()?.exits(130).map(drop)
}

/// A stopped sweep, spoiled by `spoil`, then `words`: refused with `say`, and nothing is lost.
fn spoiled(
    name: &str,
    spoil: fn(&Place) -> Judged,
    words: &'static [&'static str],
    say: &'static [&'static str],
) -> Case {
    Case::new(4, format!("sweep_{name}"), move |place| {
        stopped(place)?;
        spoil(place)?;
        let before = place.state()?;
        let words: Vec<&str> = words.iter().copied().chain(["--quiet", "--out", "a"]).collect();
        place.run(&words)?.exits(2)?.says(say)?;
        place.unchanged(&before)
    })
    .long()
}

fn log(place: &Place, change: impl Fn(&str) -> String) -> Judged {
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

fn sweeps() -> Vec<Case> {
    const SAME: &[&str] = &["sweep", "sweep.toml", "--set", "runs=100000"];
    const LOG: &[&str] = &["flights.log"];
    let nothing: fn(&Place) -> Judged = |_| Ok(());
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
            |p| p.write("glide.toml", &GLIDE.replace("pitch_deg = 5.0", "pitch_deg = 6.0")),
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
        Case::new(4, "sweep_cut_row", |place| {
            written(place)?;
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
        Case::new(4, "sweep_reads_once", |place| {
            written(place)?;
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
        Case::new(4, "sweep_table_with_robot_file", |place| {
            written(place)?;
            let inside = GLIDE.replace("name", "scenario.name").replace("robot =", "scenario.robot =");
            let inside = ["air", "aero", "start", "flight"].iter().fold(inside, |text, key| {
                text.replace(&format!("\n{key} ="), &format!("\nscenario.{key} ="))
            });
            place.write("sweep.toml", &(SWEEP.replace("scenario = \"glide.toml\"\n", "") + &inside))?;
            place.run(&["sweep", "sweep.toml", "--quiet", "--out", "a"])?.exits(0).map(drop)
        }),
    ]
}
