//! A run as it is shown: read from its folder, or from what has just been computed.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use wingbeat::scenario::{RigRun, Scenario, TetherCase};
use wingbeat::simulate::Record;
use wingbeat_io::{read_csv, read_parquet};

use crate::motion::{Motion, rows};
use crate::panels::{self, Curve, Panel, Role};
use crate::wake::{Shot, shots};
use crate::{Error, flight, held};

/// Largest text of a run that is read, bytes.
const LARGEST: u64 = 8 << 20;
/// Most runs of the rig that are shown on one page.
const MOST_RUNS: usize = 8;

/// What the plots run over.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Its name.
    pub label: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its values, one a frame.
    pub values: Vec<f64>,
    /// Whether neighbours are joined by lines.
    pub joined: bool,
}

/// A run.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: &'static str,
    /// `summary.json`.
    pub summary: Value,
    /// The document that it was made from.
    pub settings: String,
    /// What a reader must know of the page.
    pub notes: Vec<String>,
    /// What the plots run over.
    pub axis: Axis,
    /// What moves.
    pub motion: Option<Motion>,
    /// The pictures of a wake.
    pub shots: Vec<Shot>,
    /// The plots.
    pub panels: Vec<Panel>,
}

impl Run {
    /// The name in its document, or else that of its folder.
    pub fn title(&self) -> &str {
        let named = self.settings.lines().find_map(|line| line.strip_prefix("name = \"")?.strip_suffix('"'));
        named.unwrap_or(&self.name)
    }
}

/// What a flight left in memory.
#[derive(Clone, Copy)]
pub struct Flown<'a> {
    /// The scenario.
    pub scenario: &'a Scenario,
    /// Its record.
    pub record: &'a Record,
}

/// The runs of a run folder: one, or those of the rig.
///
/// # Errors
/// A folder that is none of a run, or is damaged.
pub fn read(folder: &Path) -> Result<Vec<Run>, Error> {
    if !folder.is_dir() {
        return Err(Error::run(folder, "no such folder; allowed is a run folder, as `wingbeat fly` writes"));
    }
    if !folder.join("manifest.json").is_file() {
        return Err(Error::run(folder, "no run of wingbeat: it has no manifest.json"));
    }
    let manifest = json(&folder.join("manifest.json"))?;
    if manifest["program"] != "wingbeat" {
        return Err(Error::run(&folder.join("manifest.json"), "not the manifest of a run of wingbeat"));
    }
    of(folder, &label(folder), None)
}

/// The runs of a folder that may not be finished, called `name`; of a flight those that it left in memory.
///
/// # Errors
/// As [`read`].
pub fn of(folder: &Path, name: &str, flown: Option<Flown>) -> Result<Vec<Run>, Error> {
    let has = |file: &str| folder.join(file).is_file();
    if !has("summary.json") && flown.is_none() {
        return of_rig(folder, name);
    }
    let summary = json(&folder.join("summary.json"))?;
    let blank = |kind, axis| Run {
        name: name.into(),
        kind,
        summary: summary.clone(),
        settings: String::new(),
        notes: Vec::new(),
        axis,
        motion: None,
        shots: Vec::new(),
        panels: Vec::new(),
    };
    let vtk = shots(folder)?;
    let run = if !vtk.is_empty() {
        wake(folder, vtk, &blank)?
    } else if has("case.toml") && has("loads.csv") {
        tether(folder, &blank)?
    } else if has("scenario.toml") && (has("record.parquet") || flown.is_some()) {
        flight_of(folder, flown, &blank)?
    } else {
        table(folder, &blank)?
    };
    Ok(vec![run])
}

type Blank<'a> = &'a dyn Fn(&'static str, Axis) -> Run;

fn label(folder: &Path) -> String {
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.into());
    folder.file_name().map_or("run".into(), |name| name.to_string_lossy().into_owned())
}

/// A text of the run.
fn text(path: &Path) -> Result<String, Error> {
    let size = fs::metadata(path).map_err(|source| Error::file(path, source))?.len();
    if size > LARGEST {
        return Err(Error::run(path, format!("{size} bytes; read are at most {LARGEST}")));
    }
    fs::read_to_string(path).map_err(|source| Error::file(path, source))
}

fn json(path: &Path) -> Result<Value, Error> {
    let value: Value =
        serde_json::from_str(&text(path)?).map_err(|error| Error::run(path, format!("damaged: {error}")))?;
    match value.is_object() {
        true => Ok(value),
        false => Err(Error::run(path, "damaged: not an object")),
    }
}

fn time(values: Vec<f64>) -> Axis {
    Axis { label: "time", unit: "s", values, joined: true }
}

/// A flight, a planned one, or one cycle of a periodic one.
fn flight_of(folder: &Path, flown: Option<Flown>, blank: Blank) -> Result<Run, Error> {
    let kind = match () {
        () if folder.join("multipliers.parquet").is_file() || folder.join("gains.csv").is_file() => {
            "periodic flight"
        }
        () if folder.join("plan.json").is_file() => "plan",
        () => "flight",
    };
    let path = folder.join("scenario.toml");
    let read;
    let record = match flown {
        Some(flown) => flown.record,
        None => {
            read = read_parquet(&folder.join("record.parquet"))?;
            &read
        }
    };
    let shown = flight::shown(record);
    let mut run =
        blank(kind, time(flight::taken(record, &shown, "t").map_err(|why| Error::run(folder, why))?));
    run.settings = text(&path)?;
    if shown.len() < 2 {
        run.notes.push(format!("nothing moves: {} rows can be drawn", shown.len()));
    }
    let loaded;
    let scenario = match flown {
        Some(flown) => Some(flown.scenario),
        None => match Scenario::load(&path, &[]) {
            Ok(scenario) => {
                loaded = scenario;
                Some(&loaded)
            }
            Err(error) => {
                run.notes.push(format!("no picture in space: {error}"));
                None
            }
        },
    };
    run.panels = panels::flight(record, &shown);
    if let Some(goal) = scenario.and_then(|scenario| scenario.spec.goal.as_ref()) {
        run.notes.push(format!(
            "goal: rms errors of roll within {} deg and of pitch within {} deg",
            goal.roll_within_deg, goal.pitch_within_deg
        ));
    }
    if let Some(scenario) = scenario.filter(|_| shown.len() > 1) {
        match flight::motion(scenario, record, &shown) {
            Ok(motion) => run.motion = Some(Motion { repeats: kind == "periodic flight", ..motion }),
            Err(why) => run.notes.push(format!("no picture in space: {why}")),
        }
    }
    let rows = record.rows();
    if shown.last().is_some_and(|last| last + 1 < rows.saturating_sub(rows / shown.len().max(1))) {
        let last = shown.last().map_or(0, |last| last + 1);
        run.notes.push(format!("shown are the {last} of {rows} rows before numbers grew without bound"));
    }
    Ok(run)
}

/// A wing in prescribed motion.
fn tether(folder: &Path, blank: Blank) -> Result<Run, Error> {
    let path = folder.join("case.toml");
    let read = |path: &Path| read_csv(path).map_err(|error| error.to_string());
    let case = TetherCase::load(&path, &[], &read).map_err(|error| Error::run(&path, error))?;
    let loads = read_csv(&folder.join("loads.csv"))?;
    let strips = folder.join("strips.parquet");
    let strips = if strips.is_file() { Some(read_parquet(&strips)?) } else { None };
    let shown = rows(loads.values("t").unwrap_or_default(), loads.rows());
    let axis = flight::taken(&loads, &shown, "t").map_err(|why| Error::run(folder, why))?;
    let mut run = blank("wing in prescribed motion", time(axis));
    run.settings = text(&path)?;
    run.panels = panels::loads(&loads, &shown);
    if shown.len() > 1 {
        match held::wing(&case, &loads, strips.as_ref(), &shown) {
            Ok(motion) => {
                if strips.is_some() && motion.surfaces.iter().all(|surface| surface.strips.is_empty()) {
                    run.notes.push("strips.parquet does not fit loads.csv: no strips are shown".into());
                }
                run.motion = Some(Motion { repeats: true, ..motion });
            }
            Err(why) => run.notes.push(format!("no picture in space: {why}")),
        }
    }
    Ok(run)
}

/// The wake of a wing at several instants.
fn wake(folder: &Path, shots: Vec<Shot>, blank: Blank) -> Result<Run, Error> {
    let files = parquets(folder)?;
    let record = files.first().map(|file| read_parquet(file)).transpose()?;
    let t = record.as_ref().and_then(|record| record.values("t")).unwrap_or_default();
    let all: Vec<usize> = rows(t, t.len());
    let mut run = blank("wake", time(all.iter().map(|&row| t[row]).collect()));
    let document = ["case.toml", "scenario.toml"].map(|name| folder.join(name));
    run.settings =
        document.iter().find(|path| path.is_file()).map(|path| text(path)).transpose()?.unwrap_or_default();
    if let Some(record) = &record {
        run.panels = panels::every(record, &all, "t");
        run.panels.retain(|panel| panel.title != "phase");
    }
    if let [first, _, ..] = &files[..] {
        run.notes.push(format!("the plots are of {}, the first of {} stretches", label(first), files.len()));
    }
    run.shots = shots;
    Ok(run)
}

fn parquets(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = fs::read_dir(folder).map_err(|source| Error::file(folder, source))?;
    let files = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<PathBuf> =
        files.filter(|file| file.extension().is_some_and(|e| e == "parquet")).collect();
    files.sort();
    Ok(files)
}

/// The runs of the rig in the folders inside, those on an arm in space.
fn of_rig(folder: &Path, name: &str) -> Result<Vec<Run>, Error> {
    let entries = fs::read_dir(folder).map_err(|source| Error::file(folder, source))?;
    let inside = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut inside: Vec<PathBuf> = inside
        .filter(|inside| ["scenario.toml", "record.parquet"].iter().all(|file| inside.join(file).is_file()))
        .collect();
    inside.sort();
    if inside.is_empty() {
        return Err(Error::run(
            folder,
            "nothing to show: neither summary.json nor folders with scenario.toml and record.parquet",
        ));
    }
    let shown = inside.iter().take(MOST_RUNS);
    let mut runs = shown
        .map(|inside| on_rig(inside, &format!("{name}/{}", label(inside))))
        .collect::<Result<Vec<Run>, Error>>()?;
    if inside.len() > MOST_RUNS {
        runs[0].notes.push(format!("shown are the first {MOST_RUNS} of {} runs of {name}", inside.len()));
    }
    Ok(runs)
}

fn on_rig(folder: &Path, name: &str) -> Result<Run, Error> {
    let path = folder.join("scenario.toml");
    let record = read_parquet(&folder.join("record.parquet"))?;
    let run = RigRun::load(&path, &[]).map_err(|error| Error::run(&path, error))?;
    let shown = rows(record.values("t").unwrap_or_default(), record.rows());
    let axis = flight::taken(&record, &shown, "t").map_err(|why| Error::run(folder, why))?;
    let (motion, notes) = match held::on_arm(&run, &record, &shown) {
        Ok(motion) => (Some(motion), Vec::new()),
        Err(why) => (None, vec![format!("no picture in space: {why}")]),
    };
    Ok(Run {
        name: name.into(),
        kind: "run on the rig",
        summary: json(&folder.join("summary.json"))?,
        settings: text(&path)?,
        notes,
        axis: time(axis),
        motion: motion.filter(|motion| motion.frames() > 1),
        shots: Vec::new(),
        panels: panels::every(&record, &shown, "t"),
    })
}

/// A run whose record is a table: a calibration, a sweep, averages.
fn table(folder: &Path, blank: Blank) -> Result<Run, Error> {
    let files = parquets(folder)?;
    let first = files.iter().find(|file| label(file) == "record.parquet").or(files.first());
    let record = match first {
        Some(file) => read_parquet(file)?,
        None if folder.join("cycles.csv").is_file() => read_csv(&folder.join("cycles.csv"))?,
        None => Record::default(),
    };
    let count = record.rows().min(crate::motion::MOST);
    let all: Vec<usize> = (0..count).map(|k| k * record.rows() / count.max(1)).collect();
    let column = |name: &str| flight::taken(&record, &all, name).ok();
    let document = ["calibration.toml", "sweep.toml", "scenario.toml", "case.toml"];
    let document = document.iter().find(|name| folder.join(name).is_file());
    let number = |all: &[usize]| all.iter().map(|&row| row as f64).collect::<Vec<f64>>();
    let mut run = match (column("run"), column("cycle"), column("t")) {
        (Some(run), Some(cycle), _) => {
            let values = run.iter().zip(&cycle).map(|(run, cycle)| run + cycle).collect();
            blank("calibration", Axis { label: "run and phase", unit: "cycles", values, joined: true })
        }
        (Some(run), None, _) => blank("sweep", Axis { label: "run", unit: "", values: run, joined: false }),
        (None, Some(values), _) => {
            blank("averages", Axis { label: "phase", unit: "cycles", values, joined: true })
        }
        (None, None, Some(values)) => blank("record", time(values)),
        _ => blank("run", Axis { label: "row", unit: "", values: number(&all), joined: true }),
    };
    if let Some(document) = document {
        run.settings = text(&folder.join(document))?;
    }
    run.panels = match run.kind {
        "calibration" => fits(&record, &all),
        _ => panels::every(&record, &all, if run.kind == "sweep" { "run" } else { "cycle" }),
    };
    if run.panels.is_empty() {
        run.notes.push("the run holds no table that is drawn here".into());
    }
    Ok(run)
}

/// Of each channel of a calibration what was measured, and the model before and after the fit.
fn fits(record: &Record, rows: &[usize]) -> Vec<Panel> {
    let of = |channel: &str| {
        let unit = if channel.starts_with('F') { "N" } else { "N m" };
        let curve = |(what, role)| {
            let values = flight::taken(record, rows, &format!("{what}_{channel}")).ok()?;
            Some(Curve { label: String::from(what), role, values })
        };
        let curves = [
            ("measured", Role::Total),
            ("before", Role::Pale(2)),
            ("after", Role::Own(0)),
            ("low", Role::Reference),
            ("high", Role::Reference),
        ];
        let curves: Vec<Curve> = curves.into_iter().filter_map(curve).collect();
        (!curves.is_empty()).then(|| Panel { title: channel.into(), unit, curves, limits: None })
    };
    ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"].into_iter().filter_map(of).collect()
}
