//! Class 2: sizes without bounds, documents without an end, broken pipes, signals.

use std::fs;
use std::os::unix::ffi::OsStringExt;
use std::process::Command;
use std::time::Duration;

use super::case::{Case, refused};
use super::place::{Place, Stdout};
use super::runs::{GLIDE, HOLD, SWEEP};

/// Keys with a value that asks for too much: what it is called, the words of the command, the override.
const KEYS: [(&str, &[&str], &str); 40] = [
    ("nodes", FLY, "aero.paper.nodes=1000000000"),
    ("strips", FLY, "aero.full.strips=1000000000"),
    ("duration", FLY, "flight.duration_s=1e300"),
    ("duration_12", FLY, "flight.duration_s=1e12"),
    ("step", FLY, "flight.step_s=1e-300"),
    ("records", FLY, "flight.record_every_s=1e-9"),
    ("strip_records", FLY, "flight.record_strips_every_s=1e-9"),
    ("shift", FLY, "robot.wing.planform_shift_m=1e9"),
    ("shift_full", FLY, "robot.wing.planform_shift_m=-1e9"),
    ("shoulder", FLY, "robot.wing.shoulder_m=[1e9, 0.02, 0.0]"),
    ("mass", FLY, "robot.body.mass_kg=1e300"),
    ("wind", FLY, "air.wind_m_s=[1e12, 0.0, 0.0]"),
    ("velocity", FLY, "start.velocity_m_s=[1e9, 0.0, 0.0]"),
    ("roll", FLY, "start.roll_deg=1e300"),
    ("roll_12", FLY, "start.roll_deg=1e12"),
    ("density", FLY, "air.density_kg_m3=1e12"),
    ("seed", FLY, "seed=1e300"),
    ("intervals", TURN, "controller.intervals=1000000"),
    ("intervals_max", TURN, "controller.intervals=18446744073709551615"),
    ("iterations", TURN, "controller.iterations=1000000000"),
    ("plan_intervals", ROLL_IN, "plan.roll_in.intervals=1000000"),
    ("plan_meshes", ROLL_IN, "plan.roll_in.meshes=1000000000"),
    ("plan_longest", ROLL_IN, "plan.roll_in.longest_s=1e300"),
    ("gait_intervals", GAIT, "plan.least_power.intervals=1000000"),
    ("runs", SWEEPS, "runs=1000000000000"),
    ("runs_max", SWEEPS, "runs=9223372036854775807"),
    ("runs_none", SWEEPS, "runs=0"),
    ("cycles", TETHERS, "time.cycles=1000000000"),
    ("cycles_max", TETHERS, "time.cycles=9223372036854775807"),
    ("steps_per_cycle", TETHERS, "time.steps_per_cycle=1000000000000"),
    ("tether_strips", TETHERS, "aero.full.strips=1000000000"),
    ("tether_speed", TETHERS, "wind.speed_m_s=1e12"),
    ("each", HOLDS, "hold.each_s=1e300"),
    ("each_12", HOLDS, "hold.each_s=1e12"),
    ("rate", HOLDS, "rig.cell.rate_hz=1e12"),
    ("rest", HOLDS, "rig.rest_s=1e9"),
    ("bins", HOLDS, "process.bins=1000000000"),
    ("measured", BANK, "turn.measured_s=1e9"),
    ("run_up", BANK, "turn.run_up_s=1e300"),
    ("speed", BANK, "turn.speed_m_s=1e12"),
];
const FLY: &[&str] = &["fly", "glide.toml"];
const TURN: &[&str] = &["fly", "{root}/scenarios/banking_turn.toml"];
const ROLL_IN: &[&str] = &["plan", "{root}/scenarios/roll_in.toml"];
const GAIT: &[&str] = &["plan", "{root}/scenarios/least_power_gait.toml"];
const SWEEPS: &[&str] = &["sweep", "sweep.toml"];
const TETHERS: &[&str] = &["tether", "{root}/cases/step.toml"];
const HOLDS: &[&str] = &["rig", "simulate", "hold.toml"];
const BANK: &[&str] = &["rig", "plan", "{root}/rigs/runs/roll15_speed08.toml"];

/// The files that the words above name.
const FILES: [(&str, &str); 3] = [("glide.toml", GLIDE), ("sweep.toml", SWEEP), ("hold.toml", HOLD)];

/// The cases.
pub fn cases() -> Vec<Case> {
    let key = |(name, words, set): &(&str, &[&str], &str)| {
        let arguments: Vec<&str> = words.iter().copied().chain(["--set", set]).collect();
        let key = set.split_once(['=', '[']).map_or("", |(key, _)| key);
        refused(2, &format!("key_{name}"), &FILES, &arguments, &[key, "allowed is"])
    };
    let mut all: Vec<Case> = KEYS.iter().map(key).collect();
    all.extend(documents());
    all.extend(pipes());
    all.extend(signals());
    all
}

/// Writes all files.
fn written(place: &Place) -> Result<(), String> {
    FILES.iter().try_for_each(|(name, text)| place.write(name, text))
}

/// Documents that are none, have no end, or no floor.
fn documents() -> Vec<Case> {
    let long = |name: &str, set: fn() -> String, word: &'static str| {
        Case::new(2, format!("set_{name}"), move |place| {
            written(place)?;
            let before = place.state()?;
            place.run(&["fly", "glide.toml", "--set", &set()])?.exits(2)?.says(&[word])?;
            place.unchanged(&before)
        })
    };
    let text = |name: &str, text: fn() -> String, words: &'static [&'static str]| {
        Case::new(2, format!("file_{name}"), move |place| {
            place.write("bad.toml", &text())?;
            let before = place.state()?;
            place.run(&["fly", "bad.toml"])?.exits(2)?.says(&["bad.toml"])?.says(words)?;
            place.unchanged(&before)
        })
    };
    let robot = |name: &str, file: &str, word: &str| {
        let set = format!("robot={file}");
        refused(2, &format!("robot_{name}"), &FILES, &["fly", "glide.toml", "--set", &set], &["robot", word])
    };
    vec![
        long("deep", || format!("{}a=1", "a.".repeat(60_000)), "at most 32 names"),
        long("deep_list", || format!("name={}{}", "[".repeat(30_000), "]".repeat(30_000)), "name"),
        long("deep_index", || format!("a{}=1", "[0]".repeat(30_000)), "at most 32 names"),
        long("long_value", || format!("name={}", "x".repeat(100_000)), "name"),
        long("no_value", || "a".repeat(100_000), "KEY=VALUE"),
        text("deep_keys", || format!("{}a = 1", "a.".repeat(300_000)), &["not TOML"]),
        text("deep_lists", || format!("a = {}{}", "[".repeat(300_000), "]".repeat(300_000)), &["not TOML"]),
        text(
            "deep_tables",
            || format!("a = {}{}", "{a=".repeat(100_000), "}".repeat(100_000)),
            &["not TOML"],
        ),
        text("zeros", || "\0".repeat(1 << 20), &["not TOML"]),
        text("empty", String::new, &["missing"]),
        text("endless", || format!("a = \"{}\"", "x".repeat(9 << 20)), &["the most that is read"]),
        text("huge_number", || format!("a = {}", "9".repeat(100_000)), &["bad.toml"]),
        text("many_keys", || (0..300_000).map(|i| format!("k{i} = 1\n")).collect(), &["unknown key"]),
        refused(2, "file_zero", &[], &["fly", "/dev/zero"], &["/dev/zero", "not a regular file"]),
        refused(2, "file_random", &[], &["tether", "/dev/urandom"], &["/dev/urandom", "not a regular file"]),
        refused(2, "file_folder", &[], &["fly", "/tmp"], &["/tmp", "not a regular file"]),
        refused(2, "file_none", &[], &["sweep", "none.toml"], &["none.toml"]),
        refused(2, "file_memory", &[], &["fly", "/proc/self/mem"], &["/proc/self/mem"]),
        robot("zero", "/dev/zero", "not a regular file"),
        robot("folder", "/tmp", "not a regular file"),
        robot("terminal", "/dev/tty", "robot"),
        robot("itself", "glide.toml", "robot"),
        Case::new(2, "robot_pipe", |place| {
            written(place)?;
            let made = Command::new("mkfifo").arg(place.path("pipe")).status();
            if !made.is_ok_and(|status| status.success()) {
                return Err("mkfifo failed".into());
            }
            let ended = place.run(&["fly", "glide.toml", "--set", "robot=pipe"])?;
            ended.exits(2)?.says(&["robot", "not a regular file"]).map(drop)
        }),
        Case::new(2, "many_overrides", |place| {
            written(place)?;
            place.write("big.toml", &format!("{GLIDE}# {}\n", "x".repeat(4 << 20)))?;
            let mut words = vec!["fly", "big.toml"];
            (0..200).for_each(|_| words.extend(["--set", "air.gust_m_s=0.0"]));
            place.run(&words)?.exits(2)?.says(&["fewer or shorter"]).map(drop)
        }),
        Case::new(2, "not_text_file", |place| {
            let name = std::ffi::OsString::from_vec(b"a\xff.toml".to_vec());
            place.call(&["fly"]).argument(name).run()?.exits(2).map(drop)
        }),
        Case::new(2, "not_text_set", |place| {
            written(place)?;
            let set = std::ffi::OsString::from_vec(b"name=a\xff".to_vec());
            place.call(&["fly", "glide.toml", "--set"]).argument(set).run()?.exits(2).map(drop)
        }),
        Case::new(2, "not_text_path", |place| {
            use std::os::unix::ffi::OsStrExt;
            let name = std::ffi::OsStr::from_bytes(b"a\xff.toml");
            place.write("glide.toml", GLIDE)?;
            let moved = fs::rename(place.path("glide.toml"), place.folder.join(name));
            moved.map_err(|error| error.to_string())?;
            place.call(&["fly", "--out", "a", "--quiet"]).argument(name.into()).run()?.exits(0)?;
            place.run(&["fly", "a/scenario.toml", "--out", "b", "--quiet"])?.exits(0).map(drop)
        }),
    ]
}

/// Commands whose reader goes, or whose output cannot be written: the run is whole all the same.
fn pipes() -> Vec<Case> {
    let makers: [(&str, &[&str]); 6] = [
        ("fly", &["fly", "glide.toml", "--out", "a"]),
        ("tether", &["tether", "{root}/cases/step.toml", "--set", "time.steps_per_cycle=100", "--out", "a"]),
        ("sweep", &["sweep", "sweep.toml", "--out", "a"]),
        ("simulate", &["rig", "simulate", "hold.toml", "--set", "rig.rest_s=0", "--out", "a"]),
        ("rig_plan", &["rig", "plan", "{root}/rigs/runs/roll15_speed08.toml", "--out", "a"]),
        ("validate", &["validate", "--only", "math", "--out", "a"]),
    ];
    let ways = [("head", Stdout::Head, 0), ("full", Stdout::Full, 2), ("closed", Stdout::Closed, 0)];
    let of = |(command, words): (&str, &'static [&'static str])| {
        ways.map(|(way, stdout, code)| {
            Case::new(2, format!("stdout_{way}_{command}"), move |place| {
                written(place)?;
                let ended = place.call(words).stdout(stdout).run()?.exits(code)?;
                if code == 2 {
                    ended.says(&["could not be printed"])?;
                }
                match place.path("a/manifest.json").is_file() {
                    true => Ok(()),
                    false => Err("the run is lost".into()),
                }
            })
        })
    };
    let help = |way: &str, stdout: Stdout, words: &'static [&'static str]| {
        Case::new(2, format!("stdout_{way}_{}", words.join("_").replace("--", "")), move |place| {
            let ended = place.call(words).stdout(stdout).run()?;
            if ended.code.is_some_and(|code| code <= 2) { Ok(()) } else { ended.exits(0).map(drop) }
        })
    };
    let mut all: Vec<Case> = makers.into_iter().flat_map(of).collect();
    for (name, redirection) in [("full", "2>/dev/full"), ("closed", "2>&-")] {
        all.push(Case::new(2, format!("stderr_{name}"), move |place| {
            written(place)?;
            let bad = place.call(&["fly", "glide.toml", "--set", "name=.."]).stderr(redirection);
            bad.run()?.exits(2)?;
            place.call(&["fly", "glide.toml", "--out", "a"]).stderr(redirection).run()?.exits(0)?;
            place.call(&["sweep", "sweep.toml", "--out", "b"]).stderr(redirection).run()?.exits(0).map(drop)
        }));
    }
    all.push(help("full", Stdout::Full, &["--help"]));
    all.push(help("head", Stdout::Head, &["rig", "--help"]));
    all.push(help("full", Stdout::Full, &["--version"]));
    all.push(help("full", Stdout::Full, &["validate", "--only", "math"]));
    all.push(help("head", Stdout::Head, &["validate", "--only", "math"]));
    all
}

/// Every command ends within a second of a signal and leaves nothing that looks finished.
fn signals() -> Vec<Case> {
    let long: [(&str, u64, &[&str]); 9] = [
        ("fly", 700, &["fly", "glide.toml", "--set", "flight.duration_s=50"]),
        ("turn", 700, &["fly", "{root}/scenarios/banking_turn.toml", "--set", "flight.record_every_s=1.0"]),
        ("tether", 700, &["tether", "{root}/cases/step.toml", "--set", "time.steps_per_cycle=120000"]),
        ("plan", 1500, &["plan", "{root}/scenarios/roll_in.toml"]),
        ("gait", 1500, &["plan", "{root}/scenarios/least_power_gait.toml"]),
        ("sweep", 700, &["sweep", "sweep.toml", "--set", "runs=1000000"]),
        ("simulate", 700, &["rig", "simulate", "{root}/rigs/seven_runs.toml"]),
        ("rig_plan", 100, &["rig", "plan", "{root}/rigs/seven_runs.toml"]),
        ("validate", 900, &["validate", "--only", "ocp"]),
    ];
    let of = |(command, after, words): (&str, u64, &'static [&'static str])| {
        ["INT", "TERM"].map(|signal| {
            Case::new(2, format!("signal_{}_{command}", signal.to_lowercase()), move |place| {
                written(place)?;
                let words: Vec<&str> = words.iter().copied().chain(["--quiet", "--out", "a"]).collect();
                let ended = place.call(&words).signal(signal, Duration::from_millis(after)).run()?;
                ended.in_time()?.exits(130)?.says(&["interrupted"])?;
                match place.path("a").exists() {
                    true => Err("left what looks finished".into()),
                    false => Ok(()),
                }
            })
            .long()
            .alone()
        })
    };
    let mut all: Vec<Case> = long.into_iter().flat_map(of).collect();
    all.push(
        Case::new(2, "signal_keeps_sweep", |place| {
            written(place)?;
            let words = ["sweep", "sweep.toml", "--quiet", "--out", "a", "--set", "runs=3000"];
            let ended = place.call(&words).signal("INT", Duration::from_millis(400)).run()?;
            ended.in_time()?.exits(130)?.says(&["goes on"])?;
            place.run(&words)?.exits(0)?;
            place.run(&["sweep", "sweep.toml", "--quiet", "--out", "b", "--set", "runs=3000"])?.exits(0)?;
            place.same("a/flights.csv", "b/flights.csv")
        })
        .long()
        .alone(),
    );
    all
}
