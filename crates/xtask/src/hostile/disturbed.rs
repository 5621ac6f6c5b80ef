//! `cargo xtask long faults` and `kills`: every verb is disturbed at each of its writes and starts of threads, or killed at random,
//! and must leave nothing that looks finished, and the same command must then end as if nothing had happened.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::place::{CallEnd, CaseFolder, PATIENCE};
use super::{readers, snapshot};
use crate::report::Tally;
use crate::tools;

/// Points of a verb at which it is disturbed; where there are more, so many that lie evenly among them.
const POINTS: u64 = 60;
/// The same of a verb that takes seconds.
const POINTS_OF_SLOW: u64 = 24;
/// Added to the ports of the emulated load cell.
const OFFSET: &str = "8160";
/// Bytes of a record in a raw log.
const ROW: u64 = 52;
/// Kills over all verbs.
const KILLS: usize = 500;
/// What a manifest says of a run that another run does not.
const OF_THE_RUN: [&str; 3] = ["started_unix_s", "wall_time_s", "checksums"];

/// A call of a verb that writes the folder or the file `a`, and what must have run before it.
struct Verb {
    name: &'static str,
    words: &'static [&'static str],
    before: &'static [&'static str],
    points: u64,
    /// Records the emulated load cell: no two recordings are equal, and what is on disk stays.
    records: bool,
}

const fn verb(name: &'static str, words: &'static [&'static str]) -> Verb {
    Verb { name, words, before: &[], points: POINTS, records: false }
}

const fn slow(name: &'static str, words: &'static [&'static str]) -> Verb {
    Verb { points: POINTS_OF_SLOW, ..verb(name, words) }
}

impl Verb {
    /// What it leaves when it has ended.
    fn leaves(&self) -> &'static str {
        match self.name {
            "new" => "a.toml",
            "report" => "a.html",
            "animate_file" => "a.png",
            "migrate" => "then.toml",
            _ => "a",
        }
    }

    /// How it is told where to write.
    fn out(&self) -> &'static [&'static str] {
        match self.name {
            "new" | "migrate" => &[],
            "report" => &["--quiet", "--out", "a.html"],
            "animate_file" => &["--quiet", "--out", "a.png"],
            _ => &["--quiet", "--out", "a"],
        }
    }
}

/// A gait on one coarse mesh; in three iterations it is not found, and not replayed.
const GAIT: &str = "{root}/scenarios/least_power_gait.toml";
const SHORT: &str = "plan.least_power={storage=1.0, up_n=0.08, forward_n=0.0, frequency_hz=[3.5, 3.5], \
                     nose_up_deg=[15.0, 15.0], effort_w=0.3, intervals=4, meshes=1, tolerance=0.1}";

/// A reorientation on a coarse mesh, not found either.
const CONES: &str = "plan.reorientation={rotation_deg=[0.0, -180.0, 0.0], within_deg=1.0, rate_within_rad_s=2.0, \
                     displacement_within=0.1, clearance_m=0.003, longest_s=0.5, effort=1.0, intervals=8, meshes=1, tolerance=1e-4, \
                     iterations=3, guess={frequency_hz=4.5, waves=[{input=\"command_stroke\", amplitude=1.1, phase_rad=-1.5708}, \
                     {input=\"command_sweep\", amplitude=0.6, phase_rad=0.0}]}}";

/// A document of then: `migrate` rewrites it in its place.
const THEN: &str = "start.pitch_deg = -3.5\n";

/// A verb that shows a run.
const fn shows(name: &'static str, words: &'static [&'static str]) -> Verb {
    let before = &["fly", "glide.toml", "--quiet", "--no-report", "--out", "r"];
    Verb { before, ..slow(name, words) }
}

/// Every verb that writes, but those of the list `others` below.
const VERBS: [Verb; 25] = [
    verb("fly", &["fly", "glide.toml"]),
    verb("fly_watch", &["fly", "glide.toml", "--watch"]),
    verb("sweep", &["sweep", "sweep.toml"]),
    verb(
        "tether",
        &["tether", "{root}/cases/plunge.toml", "--set", "time.cycles=2", "--set", "time.steps_per_cycle=24"],
    ),
    verb(
        "wake",
        &["wake", "{root}/cases/plunge.toml", "--chordwise", "2", "--spanwise", "8", "--steps", "12"],
    ),
    verb("rig_plan", &["rig", "plan", "{root}/rigs/runs/roll15_speed08.toml"]),
    verb("rig_simulate", &["rig", "simulate", "hold.toml"]),
    Verb {
        before: &["rig", "simulate", "hold.toml", "--quiet", "--out", "s"],
        ..verb("rig_process", &["rig", "process", "s"])
    },
    Verb {
        records: true,
        ..verb("rig_record", &["rig", "record", "127.0.0.1", "--port-offset", OFFSET, "--duration", "0.3"])
    },
    verb("validate", &["validate", "--only", "aero.wagner_limit"]),
    verb("average", &["average", "cell.csv"]),
    verb("show", &["show", "{root}/robots/glider.toml"]),
    verb("new", &["new", "case", "a.toml"]),
    verb("trim", &["trim", "{root}/scenarios/cruise_20g.toml"]),
    verb("plan", &["plan", GAIT, "--set", SHORT, "--set", "plan.least_power.iterations=3"]),
    verb("plan_reorientation", &["plan", "{root}/scenarios/reorientation.toml", "--set", CONES]),
    verb(
        "tether_spar",
        &["tether", "{root}/cases/pazy.toml", "--set", "time.steps_per_cycle=48", "--set", "time.cycles=1"],
    ),
    slow("plan_replayed", &["plan", GAIT, "--set", SHORT]),
    slow("calibrate", &["calibrate", "fit.toml"]),
    verb("migrate", &["migrate", "then.toml"]),
    shows("report", &["report", "r"]),
    shows("animate", &["animate", "r", "--width", "160", "--rate", "4", "--speed", "0.005"]),
    shows("animate_file", &["animate", "r", "--width", "160", "--rate", "4", "--speed", "0.005"]),
    shows("export", &["export", "r", "--npz"]),
    shows("export_vtk", &["export", "r", "--vtk"]),
];

/// A fit of one number to two short runs.
const FIT: &str = "\
name = \"fit\"
model = [\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]
starts = 1
steps_per_cycle = 40
[truth]
set = [\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]
[[runs]]
run = \"{root}/rigs/runs/roll15_speed08.toml\"
[[parameters]]
name = \"surfaces.wing.lift_slope_per_rad\"
";

/// What lies in the folder, by name; what differs between equal runs, their times, is left out.
type FolderFiles = BTreeMap<PathBuf, Vec<u8>>;

/// A verb in its folder, with what it leaves when nothing disturbs it.
struct TriedVerb<'a> {
    verb: &'a Verb,
    place: CaseFolder,
    exit: Option<i32>,
    left: FolderFiles,
    took: Duration,
    /// The emulated load cell, as long as it is needed.
    emulator: Option<EmulatedCell>,
}

/// An emulated load cell that ends with this value.
struct EmulatedCell(Child);

impl EmulatedCell {
    /// Once it listens.
    fn start() -> Result<Self, String> {
        let mut command = Command::new(tools::program());
        command.args(["rig", "emulate", "--port-offset", OFFSET]).stdin(Stdio::null()).stdout(Stdio::piped());
        let mut child = command.spawn().map_err(|error| format!("rig emulate: {error}"))?;
        let output = child.stdout.take();
        let emulator = Self(child);
        let mut line = String::new();
        let read = output.map(|output| BufReader::new(output).read_line(&mut line));
        match read {
            Some(Ok(_)) if line.starts_with("RDT") => Ok(emulator),
            _ => Err(format!("rig emulate does not listen: {line}")),
        }
    }
}

impl Drop for EmulatedCell {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl<'a> TriedVerb<'a> {
    fn new(verb: &'a Verb, folder: &str) -> Result<Self, String> {
        let place =
            CaseFolder::new(&tools::program(), &tools::root().join("target").join(folder).join(verb.name))?;
        let mut tried =
            Self { verb, place, exit: None, left: FolderFiles::new(), took: Duration::ZERO, emulator: None };
        if verb.records {
            tried.emulator = Some(EmulatedCell::start()?);
        }
        tried.clear()?;
        let begun = Instant::now();
        let ended = tried.call(&[])?;
        tried.took = begun.elapsed();
        tried.exit = ended.code;
        if !matches!(ended.code, Some(0 | 3)) {
            return Err(format!("undisturbed: exit {:?}: {}", ended.code, ended.stderr.trim()));
        }
        tried.left = tried.look()?;
        Ok(tried)
    }

    /// The folder as it is before the verb.
    fn clear(&self) -> Result<(), String> {
        let folder = &self.place.folder;
        fs::remove_dir_all(folder)
            .and_then(|()| fs::create_dir_all(folder))
            .map_err(|error| error.to_string())?;
        self.place.write_texts()?;
        self.place.write("fit.toml", FIT)?;
        self.place.write("then.toml", THEN)?;
        self.place.write("cell.csv", &String::from_utf8_lossy(&readers::table(4000, 1000.0, ',')))?;
        if !self.verb.before.is_empty() {
            self.place.run(self.verb.before)?.exits_with(&[0, 3])?;
        }
        Ok(())
    }

    fn words(&self) -> Vec<&'static str> {
        [self.verb.words, self.verb.out()].concat()
    }

    fn call(&self, environment: &[(&'static str, String)]) -> Result<CallEnd, String> {
        self.place.call(&self.words()).environment(environment).run()
    }

    /// What lies in the folder.
    fn look(&self) -> Result<FolderFiles, String> {
        let mut left = FolderFiles::new();
        for path in self.place.state()?.into_keys().filter(|path| path.is_file()) {
            let mut bytes = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            if path.extension().is_some_and(|extension| extension == "json")
                && let Ok(mut value) = serde_json::from_slice::<Value>(&bytes)
            {
                snapshot::strip(&mut value);
                if let Some(table) = value.as_object_mut() {
                    table.retain(|key, _| !OF_THE_RUN.contains(&key.as_str()));
                }
                bytes = value.to_string().into_bytes();
            }
            // The page repeats what the summary says of running times: kept is whether it has an end.
            if path.extension().is_some_and(|extension| extension == "html") {
                bytes = vec![u8::from(bytes.ends_with(b"</html>\n"))];
            }
            let name = path.strip_prefix(&self.place.folder).unwrap_or(&path).to_path_buf();
            if self.verb.records {
                bytes.clear();
            }
            // One that goes on has a log more.
            if !(self.verb.records && path.extension().is_some_and(|extension| extension == "rdt")) {
                left.insert(name, bytes);
            }
        }
        Ok(left)
    }

    /// What is left is what an undisturbed call leaves.
    fn whole(&self) -> Result<(), String> {
        let left = self.look()?;
        let differs =
            |(name, bytes): (&PathBuf, &Vec<u8>)| (left.get(name) != Some(bytes)).then(|| name.clone());
        if let Some(name) = self.left.iter().find_map(differs) {
            let how = if left.contains_key(&name) { "differs" } else { "is missing" };
            return Err(format!("{} {how}", name.display()));
        }
        match left.keys().find(|name| !self.left.contains_key(*name)) {
            Some(name) => Err(format!("{} was left", name.display())),
            None => Ok(()),
        }
    }

    /// Where the folder could not be moved to its name alone, it has the next one, and that is told.
    fn renamed(&self, ended: &CallEnd) -> Result<(), String> {
        let (other, name) = (self.place.path("a-2"), self.place.path(self.verb.leaves()));
        if other.exists() && !name.exists() && ended.stderr.contains("a-2") {
            fs::rename(&other, &name).map_err(|error| format!("a-2: {error}"))?;
        }
        Ok(())
    }

    /// Whether what the verb leaves is there.
    fn is_finished(&self) -> bool {
        let leaves = self.verb.leaves();
        match self.verb.name {
            "migrate" => self.place.read(leaves).is_ok_and(|text| text != THEN),
            _ => self.place.path(leaves).exists(),
        }
    }

    /// Nothing looks finished, or all is.
    fn nothing_finished(&self) -> Result<(), String> {
        if self.is_finished() {
            self.whole().map_err(|what| format!("a lies there, but {what}"))
        } else {
            Ok(())
        }
    }

    /// Records in the raw logs of a recording that is not finished.
    fn rows(&self) -> u64 {
        let files = fs::read_dir(self.place.path(".a.partial")).into_iter().flatten().flatten();
        let logs = files.filter(|file| file.path().extension().is_some_and(|extension| extension == "rdt"));
        logs.map(|log| log.metadata().map_or(0, |data| data.len() / ROW)).sum()
    }

    /// The same command again ends as if nothing had happened, and loses no record.
    fn again(&self) -> Result<(), String> {
        if self.is_finished() {
            return Ok(());
        }
        let rows = self.rows();
        let ended = self.call(&[]).map_err(|what| format!("again: {what}"))?;
        // The rate of a third of a second is judged, and depends on what else runs.
        let rate =
            self.verb.records && ended.code == Some(3) && ended.stderr.contains("recording.rate_error");
        if ended.code != self.exit && !rate {
            return Err(format!("again: exit {:?}: {}", ended.code, ended.stderr.trim()));
        }
        self.whole().map_err(|what| format!("again: {what}"))?;
        if !self.verb.records {
            return Ok(());
        }
        let summary: Value = serde_json::from_str(&self.place.read("a/summary.json")?)
            .map_err(|error| format!("again: summary.json: {error}"))?;
        match summary["records"].as_u64() {
            Some(records) if records >= rows => Ok(()),
            records => Err(format!("again: {records:?} records of {rows} that were on disk")),
        }
    }
}

/// The library that fails calls, built.
fn library() -> Option<PathBuf> {
    tools::succeeds(tools::cargo(&["build", "--release", "--quiet", "--package", "wingbeat-faults"]))
        .then_some(())?;
    Some(tools::root().join("target/release/libwingbeat_faults.so"))
}

/// Disturbs each verb at each of its points, once alone and once with all that follow.
pub fn faults() -> Tally {
    faults_of(&[])
}

/// The same of the verbs that are named, or of all.
pub fn faults_of(names: &[String]) -> Tally {
    let Some(library) = library() else { return Tally::one(false) };
    let mut tally = Tally::default();
    for verb in VERBS.iter().filter(|verb| names.is_empty() || names.iter().any(|name| name == verb.name)) {
        match disturbed(verb, &library) {
            Ok(of_verb) => {
                println!("{}: {} passed, {} failed", verb.name, of_verb.passed, of_verb.failed);
                tally.passed += of_verb.passed;
                tally.failed += of_verb.failed;
            }
            Err(what) => {
                println!("{}: {what}", verb.name);
                tally.failed += 1;
            }
        }
    }
    tally
}

fn disturbed(verb: &Verb, library: &Path) -> Result<Tally, String> {
    let tried = TriedVerb::new(verb, "faults")?;
    let told = tools::root().join("target/faults").join(format!("{}.told", verb.name));
    let environment = |at: u64, on: bool| {
        let mut all = vec![
            ("LD_PRELOAD", library.to_string_lossy().into_owned()),
            ("WINGBEAT_FAULTS_UNDER", tried.place.folder.to_string_lossy().into_owned()),
            ("WINGBEAT_FAULTS_TOLD", told.to_string_lossy().into_owned()),
        ];
        if at > 0 {
            all.push(("WINGBEAT_FAULTS_AT", at.to_string()));
        }
        if on {
            all.push(("WINGBEAT_FAULTS_ON", "1".into()));
        }
        all
    };
    tried.clear()?;
    tried.call(&environment(0, false))?;
    let count: u64 = fs::read_to_string(&told).ok().and_then(|text| text.trim().parse().ok()).unwrap_or(0);
    if count == 0 {
        return Err("no point was counted".into());
    }
    let step = count.div_ceil(verb.points).max(1);
    let (mut tally, mut missed) = (Tally::default(), 0);
    for at in (1..=count).step_by(step as usize) {
        for on in [false, true] {
            tried.clear()?;
            let _ = fs::remove_file(&told);
            let outcome = tried.call(&environment(at, on)).and_then(|ended| after_a_fault(&tried, &ended));
            let what = fs::read_to_string(&told).unwrap_or_default();
            if what.is_empty() && outcome.is_ok() {
                // Threads that start later leave fewer points.
                missed += 1;
                continue;
            }
            if let Err(why) = &outcome {
                let on = if on { " and all after it" } else { "" };
                println!("{}: point {at} of {count}{on}, {what}: {why}", verb.name);
            }
            tally.passed += usize::from(outcome.is_ok());
            tally.failed += usize::from(outcome.is_err());
        }
    }
    if missed > 0 {
        println!("{}: {missed} points were not reached", verb.name);
    }
    Ok(tally)
}

/// A fault ends the program with 2 and a message and leaves nothing that looks finished, or it does not matter.
fn after_a_fault(tried: &TriedVerb, ended: &CallEnd) -> Result<(), String> {
    match ended.code {
        Some(2) if ended.stderr.contains("error") => {}
        // What was recorded is safe, and said to be unfinished.
        Some(3) if tried.verb.records && ended.stderr.contains("are safe in its raw logs") => {}
        Some(2) => return Err("exit 2 without a message".into()),
        code if code == tried.exit
            || (tried.verb.records && ended.stderr.contains("recording.rate_error")) =>
        {
            tried.renamed(ended)?;
            return tried.whole().map_err(|what| format!("exit {code:?}, but {what}"));
        }
        code => return Err(format!("exit {code:?}: {}", ended.stderr.trim())),
    }
    tried.nothing_finished()?;
    tried.again()
}

/// Kills verbs, one after another, at times that are drawn.
pub fn kills() -> Tally {
    let mut tally = Tally::default();
    let tried: Vec<TriedVerb> = VERBS
        .iter()
        .filter_map(|verb| {
            let tried = TriedVerb::new(verb, "kills");
            tally.failed += usize::from(tried.is_err());
            tried.map_err(|what| println!("{}: {what}", verb.name)).ok()
        })
        .collect();
    // The seed stays, so that a kill can be tried once more.
    let mut state: u64 = 0x9e37_79b9_7f4a_7c15;
    let (mut under_way, mut finished) = (0, 0);
    for kill in 0..KILLS {
        let Some(one) = tried.get(kill % tried.len().max(1)) else { break };
        let after = one.took.mul_f64(drawn(&mut state));
        match killed(one, after) {
            Ok(true) => under_way += 1,
            Ok(false) => finished += 1,
            Err(why) => println!("{}: kill {kill} after {after:?}: {why}", one.verb.name),
        }
    }
    println!("{under_way} were killed, {finished} had ended before");
    tally.passed += under_way + finished;
    tally.failed += KILLS - under_way - finished;
    tally
}

/// A number between 0 and 1 by the generator of Marsaglia, Xorshift RNGs (2003), with the shifts 13, 7, 17.
fn drawn(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

/// Kills a call so long after its start; whether it was under way.
fn killed(tried: &TriedVerb, after: Duration) -> Result<bool, String> {
    tried.clear()?;
    let words = tried.words();
    let running = tried.place.call(&words).start()?;
    thread::sleep(after);
    let _ = running.send("KILL");
    let ended = running.end(PATIENCE)?;
    tried.nothing_finished()?;
    let texts = ["glide.toml", "sweep.toml", "hold.toml"];
    if let Some(name) = texts.iter().find(|name| {
        tried.look().is_ok_and(|left| left.get(Path::new(name)) != tried.left.get(Path::new(name)))
    }) {
        return Err(format!("{name} was changed"));
    }
    tried.again()?;
    Ok(ended.code.is_none())
}

#[cfg(test)]
mod tests {
    use super::super::place::placed;
    use super::*;

    #[test]
    fn draws_lie_between_zero_and_one_and_every_verb_that_writes_is_there() {
        let mut state = 7;
        let draws: Vec<f64> = (0..1000).map(|_| drawn(&mut state)).collect();
        assert!(draws.iter().all(|draw| (0.0..1.0).contains(draw)));
        assert!((draws.iter().sum::<f64>() / 1000.0 - 0.5).abs() < 0.03);
        assert!(!placed(FIT).contains("{root}"));
        let page = fs::read_to_string(tools::root().join("docs/cli.md")).unwrap();
        let listed = page.lines().filter_map(|line| line.strip_prefix("## wingbeat "));
        let missing = |verb: &&str| {
            let words: Vec<&str> = verb.split(' ').collect();
            // `paper` computes for minutes, and writes its folder with the code of `plan` and `fly`; the rest writes nothing.
            let others = ["rig", "rig emulate", "schema", "help", "paper"];
            !others.contains(verb) && !VERBS.iter().any(|known| known.words.starts_with(&words))
        };
        let listed: Vec<&str> = listed.collect();
        assert!(listed.len() > 10, "{listed:?}");
        assert_eq!(listed.into_iter().filter(missing).collect::<Vec<_>>(), [""; 0]);
    }
}
