//! Class 1: names, places, `--force`, several commands at once, links, full disks.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::time::Duration;

use super::case::{Case, Judged, refused};
use super::place::Place;

/// A short flight without a controller.
pub const GLIDE: &str = "\
name = \"gl\"
robot = \"{root}/robots/aerobat_beta.toml\"
air = { density_kg_m3 = 1.225 }
aero = { preset = \"paper\", law = \"stall\" }
start = { velocity_m_s = [3.32, 0.0, -0.8], pitch_deg = 5.0, phase_rad = 5.0 }
flight = { duration_s = 0.01, step_s = 1e-4, record_every_s = 1e-3, flapping = false }
";
/// Three flights of it.
pub const SWEEP: &str = "\
name = \"sw\"
scenario = \"glide.toml\"
runs = 3
draws = [{ key = \"air.gust_m_s\", low = 0.0, high = 0.1 }]
hold = { roll_within_deg = 5.0, pitch_within_deg = 10.0 }
";
/// A hold of less than three cycles on the rig.
pub const HOLD: &str = "\
name = \"ho\"
rig = \"{root}/rigs/aerobat_on_gen3.toml\"
frequency_hz = 3.5
hold = { each_s = 0.8, tilts_deg = [[0.0, 0.0]] }
process = { phase = \"force\", steps = { tare = false, drift = false } }
";
/// Its rest is left out.
pub const NO_REST: [&str; 2] = ["--set", "rig.rest_s=0"];

/// Names that are none, with what they are called.
const NAMES: [(&str, &str); 20] = [
    ("empty", ""),
    ("dot", "."),
    ("up", ".."),
    ("up_into", "../home/thesis"),
    ("below", "a/b"),
    ("absolute", "/tmp/wingbeat-hostile"),
    ("backslash", "a\\\\b"),
    ("hidden", ".bashrc"),
    ("option", "-rf"),
    ("control", "a\\u0007b"),
    ("line", "a\\nb"),
    ("nul", "a\\u0000b"),
    (
        "long",
        "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx",
    ),
    ("blank", " "),
    ("blank_end", "a "),
    ("dot_end", "a."),
    ("colon", "c:a"),
    ("star", "a*"),
    ("device", "NUL"),
    ("manifest", "manifest"),
];

/// Commands that make runs: what they are called, their file, the words before and after it.
const MAKERS: [(&str, &str, &str, &[&str]); 6] = [
    ("fly", "glide.toml", GLIDE, &["fly", "glide.toml"]),
    ("plan", "glide.toml", GLIDE, &["plan", "glide.toml"]),
    ("sweep", "sweep.toml", SWEEP, &["sweep", "sweep.toml"]),
    ("tether", "none", "", &["tether", "{root}/cases/step.toml"]),
    ("rig_plan", "none", "", &["rig", "plan", "{root}/rigs/runs/roll15_speed08.toml"]),
    ("rig_simulate", "hold.toml", HOLD, &["rig", "simulate", "hold.toml"]),
];

/// The cases.
pub fn cases() -> Vec<Case> {
    let mut all = names();
    all.extend(places());
    all.extend(force());
    all.extend(together());
    all.extend(ends());
    all
}

/// Every bad name is refused by every command, by the key that it was given under.
fn names() -> Vec<Case> {
    let of = |(what, name): &(&str, &str)| {
        MAKERS.map(|(command, file, text, words)| {
            let set = format!("name=\"{name}\"");
            let arguments: Vec<&str> = words.iter().copied().chain(["--set", &set]).collect();
            let files = [(file, text), ("glide.toml", GLIDE), ("home/thesis.txt", "years of work")];
            refused(1, &format!("name_{what}_{command}"), &files, &arguments, &["name"])
        })
    };
    NAMES.iter().flat_map(of).collect()
}

/// The files of all makers beside one another.
fn files(place: &Place) -> Judged {
    place.write("glide.toml", GLIDE)?;
    place.write("sweep.toml", SWEEP)?;
    place.write("hold.toml", HOLD)
}

/// A case of what `--out` names, prepared by `prepare`: refused before any work, naming `--out`.
fn place(name: &str, out: &'static str, prepare: fn(&Place) -> Judged) -> Vec<Case> {
    let one = |(command, words): (&str, &'static [&'static str])| {
        Case::new(1, format!("out_{name}_{command}"), move |place| {
            files(place)?;
            prepare(place)?;
            let before = place.state()?;
            let arguments: Vec<&str> = words.iter().copied().chain(["--out", out]).collect();
            place.run(&arguments)?.exits(2)?.says(&["--out"])?;
            place.unchanged(&before)
        })
    };
    let validate: (&str, &[&str]) = ("validate", &["validate", "--only", "math"]);
    let makers = MAKERS.iter().map(|(command, _, _, words)| (*command, *words));
    makers.filter(|(command, _)| *command != "plan").chain([validate]).map(one).collect()
}

fn linked(place: &Place, to: &str, at: &str) -> Judged {
    symlink(Path::new(to), place.path(at)).map_err(|error| error.to_string())
}

fn places() -> Vec<Case> {
    [
        place("other_files", "mine", |p| p.write("mine/thesis.txt", "years of work")),
        place("file", "mine", |p| p.write("mine", "years of work")),
        place("below_file", "mine/run", |p| p.write("mine", "years of work")),
        place("link", "link", |p| {
            p.write("mine/thesis.txt", "years of work")?;
            linked(p, "mine", "link")
        }),
        place("link_to_empty", "link", |p| {
            fs::create_dir(p.path("mine")).map_err(|error| error.to_string())?;
            linked(p, "mine", "link")
        }),
        place("dangling", "link", |p| linked(p, "nowhere", "link")),
        place("here", ".", |_| Ok(())),
        place("up", "..", |_| Ok(())),
        place("root", "/", |_| Ok(())),
        place("empty", "", |_| Ok(())),
        place("mount", "/dev/shm", |_| Ok(())),
        place("up_later", "nowhere/../run", |_| Ok(())),
    ]
    .into_iter()
    .flatten()
    .chain([not_text("out")])
    .collect()
}

/// A name that is not UTF-8 is refused before the flight.
fn not_text(what: &str) -> Case {
    use std::os::unix::ffi::OsStringExt;
    Case::new(1, format!("{what}_not_text"), |place| {
        files(place)?;
        let before = place.state()?;
        let out = std::ffi::OsString::from_vec(b"a\xff".to_vec());
        place
            .call(&["fly", "glide.toml", "--out"])
            .argument(out)
            .run()?
            .exits(2)?
            .says(&["--out", "UTF-8"])?;
        place.unchanged(&before)
    })
}

/// Flies into `a`.
fn flown(place: &Place, more: &[&str]) -> Judged {
    let arguments: Vec<&str> =
        ["fly", "glide.toml", "--quiet", "--out", "a"].into_iter().chain(more.iter().copied()).collect();
    place.run(&arguments)?.exits(0).map(drop)
}

/// `a` is not replaced by force once `spoil` has changed it.
fn kept(name: &str, spoil: fn(&Place) -> Judged) -> Case {
    Case::new(1, format!("force_{name}"), move |place| {
        files(place)?;
        flown(place, &[])?;
        spoil(place)?;
        let before = place.state()?;
        let again = place.run(&["fly", "glide.toml", "--quiet", "--out", "a", "--force"])?;
        again.exits(2)?.says(&["--out a"])?;
        place.unchanged(&before)
    })
}

/// A folder that is no run of ours is not replaced by force.
fn foreign(name: &str, manifest: &'static str) -> Case {
    Case::new(1, format!("force_foreign_{name}"), move |place| {
        files(place)?;
        place.write("a/manifest.json", manifest)?;
        place.write("a/src/background.js", "years of work")?;
        let before = place.state()?;
        let again = place.run(&["fly", "glide.toml", "--quiet", "--out", "a", "--force"])?;
        again.exits(2)?.says(&["--out a"])?;
        place.unchanged(&before)
    })
}

fn force() -> Vec<Case> {
    vec![
        Case::new(1, "out_twice", |place| {
            files(place)?;
            flown(place, &[])?;
            let before = place.state()?;
            place.run(&["fly", "glide.toml", "--out", "a"])?.exits(2)?.says(&["--out a", "--force"])?;
            place.unchanged(&before)?;
            place.run(&["fly", "glide.toml"])?.exits(0)?.prints(&["run folder: runs/gl"]).map(drop)
        }),
        Case::new(1, "force_replaces", |place| {
            files(place)?;
            flown(place, &["--seed", "1"])?;
            flown(place, &["--seed", "2", "--force"])?;
            let manifest = place.read("a/manifest.json")?;
            if !manifest.contains("\"seed\": 2") {
                return Err("not replaced".into());
            }
            place.holds(".", &["a", "glide.toml", "hold.toml", "sweep.toml"])
        }),
        kept("notes", |p| p.write("a/notes.txt", "years of work")),
        kept("folder", |p| p.write("a/thesis/one.tex", "years of work")),
        kept("figure", |p| p.write("a/figures/mine.png", "years of work")),
        kept("link", |p| linked(p, "/etc", "a/etc")),
        kept("linked_file", |p| {
            fs::remove_file(p.path("a/summary.json")).map_err(|error| error.to_string())?;
            linked(p, "../glide.toml", "a/summary.json")
        }),
        kept("no_manifest", |p| fs::remove_file(p.path("a/manifest.json")).map_err(|e| e.to_string())),
        kept("broken_manifest", |p| p.write("a/manifest.json", "{")),
        foreign("extension", "{ \"manifest_version\": 3, \"name\": \"blocker\", \"version\": \"1.0\" }"),
        foreign("empty", ""),
        foreign("list", "[]"),
        foreign("old", "{ \"version\": \"0.1.0\", \"command\": [\"wingbeat\"], \"seed\": 0 }"),
        foreign(
            "upward",
            "{ \"program\": \"wingbeat\", \"version\": \"0.1.0\", \"files\": [\"../glide.toml\", \"src/background.js/\"] }",
        ),
        Case::new(1, "force_other_kind", |place| {
            files(place)?;
            flown(place, &[])?;
            place.run(&["sweep", "sweep.toml", "--quiet", "--out", "a", "--force"])?.exits(0)?;
            if place.path("a/scenario.toml").exists() { Err("a mix of two runs".into()) } else { Ok(()) }
        }),
        Case::new(1, "process_counts_up", |place| {
            files(place)?;
            let simulate: Vec<&str> = ["rig", "simulate", "hold.toml", "--quiet", "--out", "s"]
                .into_iter()
                .chain(NO_REST)
                .collect();
            place.run(&simulate)?.exits(0)?;
            let process = ["rig", "process", "s/ho", "--quiet"];
            let first = place.run(&process)?;
            if first.code != Some(0) {
                return first.exits(0).map(drop);
            }
            let before = place.state()?;
            place.run(&process)?.exits(0)?;
            place.kept(&before)?;
            if place.path("s/ho/processed-2").is_dir() { Ok(()) } else { Err("no processed-2".into()) }
        }),
    ]
}

/// Starts `count` calls of one command at once and waits for them; their exit codes.
fn at_once(place: &Place, count: usize, arguments: &[&str]) -> Result<Vec<Option<i32>>, String> {
    let running: Vec<_> =
        (0..count).map(|_| place.call(arguments).start()).collect::<Result<Vec<_>, String>>()?;
    running.into_iter().map(|one| one.end(Duration::from_secs(60)).map(|ended| ended.code)).collect()
}

/// Every entry of `folder` is a whole run.
fn whole(place: &Place, folder: &str) -> Judged {
    for name in place.names(folder)? {
        if !place.path(folder).join(&name).join("manifest.json").is_file() {
            return Err(format!("{folder}/{name} is no whole run"));
        }
    }
    Ok(())
}

fn together() -> Vec<Case> {
    let three = |name: &str, words: &'static [&'static str], run: &'static str| {
        Case::new(1, format!("three_at_once_{name}"), move |place| {
            files(place)?;
            let codes = at_once(place, 3, words)?;
            if codes.iter().any(|code| *code != Some(0)) {
                return Err(format!("exit codes {codes:?}"));
            }
            let names = [run.to_owned(), format!("{run}-2"), format!("{run}-3")];
            place.holds("runs", &names.each_ref().map(String::as_str))?;
            whole(place, "runs")
        })
        .long()
    };
    let one = |name: &str, words: &'static [&'static str]| {
        Case::new(1, format!("three_at_once_out_{name}"), move |place| {
            files(place)?;
            let mut codes = at_once(place, 3, words)?;
            codes.sort();
            if codes != [Some(0), Some(2), Some(2)] {
                return Err(format!("exit codes {codes:?}, wanted one 0 and two 2"));
            }
            place.holds(".", &["a", "glide.toml", "hold.toml", "sweep.toml"])
        })
        .long()
    };
    vec![
        three("fly", &["fly", "glide.toml", "--quiet"], "gl"),
        three(
            "tether",
            &["tether", "{root}/cases/step.toml", "--quiet", "--set", "time.steps_per_cycle=100"],
            "step",
        ),
        three("simulate", &["rig", "simulate", "hold.toml", "--quiet", "--set", "rig.rest_s=0"], "hold"),
        three(
            "rig_plan",
            &["rig", "plan", "{root}/rigs/runs/roll15_speed08.toml", "--quiet"],
            "roll15_speed08",
        ),
        one("fly", &["fly", "glide.toml", "--quiet", "--out", "a"]),
        one("sweep", &["sweep", "sweep.toml", "--quiet", "--out", "a"]),
        one("validate", &["validate", "--only", "math", "--quiet", "--out", "a"]),
    ]
}

/// What a killed, stopped or starved command leaves.
fn ends() -> Vec<Case> {
    let long: &[&str] = &["fly", "glide.toml", "--quiet", "--set", "flight.duration_s=50"];
    let killed = |name: &str, signal: &'static str| {
        Case::new(1, format!("after_{name}"), move |place| {
            files(place)?;
            let ended = place.call(long).signal(signal, Duration::from_millis(700)).run()?;
            if ended.code == Some(0) {
                return Err("exit 0".into());
            }
            if place.path("runs/gl").exists() {
                return Err("left what looks finished".into());
            }
            place.run(&["fly", "glide.toml", "--quiet"])?.exits(0)?;
            place.holds("runs", &["gl"])
        })
        .long()
    };
    let starved = |command: &str, words: &'static [&'static str]| {
        Case::new(1, format!("full_disk_{command}"), move |place| {
            files(place)?;
            let before = place.state()?;
            let arguments: Vec<&str> = words.iter().copied().chain(["--quiet", "--out", "a"]).collect();
            let ended = place.call(&arguments).blocks(8).run()?.exits(2)?;
            let lines = ended.stderr.lines().filter(|line| line.starts_with("error")).count();
            if lines != 1 {
                return Err(format!("{lines} messages: {}", ended.stderr.trim()));
            }
            place.unchanged(&before)
        })
    };
    vec![
        killed("kill", "KILL"),
        killed("interrupt", "INT"),
        killed("term", "TERM"),
        killed("hangup", "HUP"),
        starved("fly", &["fly", "glide.toml"]),
        starved("tether", &["tether", "{root}/cases/step.toml", "--set", "time.steps_per_cycle=100"]),
        starved("rig_simulate", &["rig", "simulate", "hold.toml", "--set", "rig.rest_s=0"]),
        starved("rig_plan", &["rig", "plan", "{root}/rigs/runs/roll15_speed08.toml"]),
        Case::new(1, "full_disk_sweep", |place| {
            files(place)?;
            let before = place.state()?;
            let call = place.call(&["sweep", "sweep.toml", "--quiet", "--out", "a", "--set", "runs=300"]);
            call.blocks(16).run()?.exits(2)?.says(&["flights.log"])?;
            place.kept(&before)?;
            if place.path("a").exists() { Err("left what looks finished".into()) } else { Ok(()) }
        }),
        Case::new(1, "orphan_of_another", |place| {
            files(place)?;
            place.write("runs/.gl.partial/thesis.txt", "years of work")?;
            let before = place.state()?;
            place.run(&["fly", "glide.toml", "--quiet"])?.exits(0)?;
            place.kept(&before)
        }),
        Case::new(1, "place_taken_meanwhile", |place| {
            files(place)?;
            let call =
                place.call(&["fly", "glide.toml", "--quiet", "--out", "a", "--set", "flight.duration_s=3"]);
            let running = call.start()?;
            std::thread::sleep(Duration::from_millis(300));
            place.write("a/thesis.txt", "years of work")?;
            let before = place.state()?;
            running.end(Duration::from_secs(60))?;
            let thesis = place.path("a/thesis.txt");
            match before.get(&thesis) == place.state()?.get(&thesis)
                && !place.path("a/manifest.json").exists()
            {
                true => Ok(()),
                false => Err("wrote over a folder that came meanwhile".into()),
            }
        })
        .long(),
        Case::new(1, "runs_is_a_file", |place| {
            files(place)?;
            place.write("runs", "years of work")?;
            let before = place.state()?;
            place.run(&["fly", "glide.toml"])?.exits(2)?.says(&["runs"])?;
            place.unchanged(&before)
        }),
    ]
}
