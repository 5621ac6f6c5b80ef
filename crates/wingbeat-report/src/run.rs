//! A run as it is shown: read from its folder, or from what has just been computed.

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use wingbeat::rig::cell::CHANNELS;
use wingbeat::scenario::{RigRun, Scenario, TetherCase};
use wingbeat::simulate::{Column, Record};
use wingbeat_figures::TurnsOfBody;
use wingbeat_io::read_csv;

use crate::files::Files;
use crate::motion::{RunMotion, rows};
use crate::panels::{self, CurveRole, PageCurve, PagePanel, begins_with};
use crate::wake::Shot;
use crate::{Error, flight, held};

/// Most runs of the rig that are shown on one page.
const MOST_RUNS: usize = 8;

/// What the plots run over.
#[derive(Clone, Debug)]
pub struct PlotAxis {
    /// Its name.
    pub label: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its values, in the unit of the axis, one a frame.
    pub values: Vec<f64>,
    /// Whether neighbours are joined by lines.
    pub joined: bool,
}

/// A run.
#[derive(Clone, Debug)]
pub struct ShownRun {
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
    pub axis: PlotAxis,
    /// What moves.
    pub motion: Option<RunMotion>,
    /// The pictures of a wake.
    pub shots: Vec<Shot>,
    /// The plots.
    pub panels: Vec<PagePanel>,
}

impl ShownRun {
    /// A run of which nothing is known yet.
    pub fn blank(name: &str, kind: &'static str, axis: PlotAxis) -> Self {
        Self {
            name: name.into(),
            kind,
            summary: json!({}),
            settings: String::new(),
            notes: Vec::new(),
            axis,
            motion: None,
            shots: Vec::new(),
            panels: Vec::new(),
        }
    }

    /// What moves.
    ///
    /// # Errors
    /// Nothing does, and why.
    pub fn moves(&self) -> Result<&RunMotion, String> {
        self.motion.as_ref().ok_or_else(|| {
            let why = self.notes.iter().filter(|note| note.starts_with("no"));
            let notes: String = why.map(|note| format!("; {note}")).collect();
            format!("{}: nothing moves in this {}{notes}", self.name, self.kind)
        })
    }

    /// Whether it plots what `earlier` plots and what comes behind; what moves is not looked at.
    pub fn continues(&self, earlier: &Self) -> bool {
        self.name == earlier.name
            && begins_with(&self.axis.values, &earlier.axis.values)
            && panels::continue_all(&self.panels, &earlier.panels)
    }

    /// The name in its document, or else that of its folder.
    pub fn title(&self) -> &str {
        let named = self.settings.lines().find_map(|line| line.strip_prefix("name = \"")?.strip_suffix('"'));
        named.unwrap_or(&self.name)
    }
}

/// What a flight left in memory.
#[derive(Clone, Copy)]
pub struct FlownScenario<'a> {
    /// The scenario.
    pub scenario: &'a Scenario,
    /// Its record.
    pub record: &'a Record,
}

/// Refuses runs that are drawn over different axes.
///
/// # Errors
/// That.
pub fn one_axis(runs: &[ShownRun]) -> Result<(), String> {
    let Some(first) = runs.first() else { return Ok(()) };
    match runs.iter().find(|run| run.axis.label != first.axis.label) {
        None => Ok(()),
        Some(other) => Err(format!(
            "{} is drawn over {}, {} over {}: allowed on one page are runs over the same",
            first.name, first.axis.label, other.name, other.axis.label
        )),
    }
}

/// The runs of a run folder: one, or those of the rig.
///
/// # Errors
/// A folder that is none of a run, or is damaged.
pub fn read(folder: &Path) -> Result<Vec<ShownRun>, Error> {
    if !folder.is_dir() {
        return Err(Error::run(folder, "no such folder; allowed is a run folder, as `wingbeat fly` writes"));
    }
    let files = Files::Folder(folder);
    if !files.has("manifest.json") {
        return Err(Error::run(folder, "no run of wingbeat: it has no manifest.json"));
    }
    if files.json("manifest.json")?["program"] != "wingbeat" {
        return Err(Error::run(&folder.join("manifest.json"), "not the manifest of a run of wingbeat"));
    }
    of(files, &label(folder), None)
}

/// The runs of files that may not be all there, called `name`; of a flight that which is still in memory.
///
/// # Errors
/// As [`read`].
pub fn of(files: Files, name: &str, flown: Option<FlownScenario>) -> Result<Vec<ShownRun>, Error> {
    let has = |file: &str| files.has(file);
    if let (false, None, Files::Folder(folder)) = (has("summary.json"), flown, files) {
        return of_rig(folder, name);
    }
    // In memory a run on the rig stands alone.
    if let Files::Memory(memory) = files
        && memory.records.get("record.parquet").is_some_and(|record| record.values("q1").is_some())
    {
        return Ok(vec![on_rig(files, name)?]);
    }
    let summary = files.json("summary.json")?;
    let blank = |kind, axis| ShownRun { summary: summary.clone(), ..ShownRun::blank(name, kind, axis) };
    let shots = files.shots()?;
    if !shots.is_empty() {
        return Ok(vec![wake(files, shots, &blank)?]);
    }
    if has("case.toml") && has("loads.csv") {
        return Ok(vec![tether(files, &blank)?]);
    }
    if has("scenario.toml") && (has("record.parquet") || flown.is_some()) {
        return Ok(vec![flight_of(files, flown, &blank)?]);
    }
    let averages = files.parquets()?;
    let averaged = averages.iter().filter(|file| *file != "envelope.parquet");
    let averaged: Vec<&String> = averaged.collect();
    match (&averaged[..], has("sweep.toml") || has("calibration.toml")) {
        // Processed runs of the rig, each with its own file.
        ([_, _, ..], false) if !has("record.parquet") => {
            let several = averaged.iter().take(MOST_RUNS).map(|file| {
                let own = ShownRun::blank(
                    &format!("{name}/{}", file.trim_end_matches(".parquet")),
                    "averages",
                    time(Vec::new()),
                );
                table(files, Some(file), &|kind, axis| ShownRun {
                    kind,
                    axis,
                    summary: of_one(&summary, file),
                    ..own.clone()
                })
            });
            several.collect()
        }
        ([one], false) if has("envelope.parquet") => Ok(vec![table(files, Some(one), &blank)?]),
        _ => Ok(vec![table(files, None, &blank)?]),
    }
}

/// What the summary of several runs says of that of `file`, with the verdict on all.
fn of_one(summary: &Value, file: &str) -> Value {
    let name = file.trim_end_matches(".parquet");
    let own = &summary["runs"][name];
    let mut own = if own.is_object() { own.clone() } else { json!({}) };
    for key in ["status", "reason", "judged", "warnings"] {
        own[key] = summary[key].clone();
    }
    own
}

type Blank<'a> = &'a dyn Fn(&'static str, PlotAxis) -> ShownRun;

fn label(folder: &Path) -> String {
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.into());
    folder.file_name().map_or("run".into(), |name| name.to_string_lossy().into_owned())
}

fn time(values: Vec<f64>) -> PlotAxis {
    PlotAxis { label: "time", unit: "s", values, joined: true }
}

/// A flight, a planned one, or one cycle of a periodic one.
fn flight_of(files: Files, flown: Option<FlownScenario>, blank: Blank) -> Result<ShownRun, Error> {
    let kind = match () {
        () if files.has("multipliers.parquet") || files.has("gains.csv") => "periodic flight",
        () if files.has("plan.json") => "plan",
        () => "flight",
    };
    let record = match flown {
        Some(flown) => Cow::Borrowed(flown.record),
        None => files.record("record.parquet")?,
    };
    let record = record.as_ref();
    let shown = flight::shown(record);
    let axis = flight::taken(record, &shown, "t").map_err(|why| Error::run(&files.path(""), why))?;
    let mut run = blank(kind, time(axis));
    run.settings = files.text("scenario.toml")?;
    let loaded;
    let scenario = match flown {
        Some(flown) => Some(flown.scenario),
        None => match files.document("scenario.toml").and_then(Scenario::new) {
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
    fill(&mut run, record, scenario, &shown);
    Ok(run)
}

/// The rows `shown` of a flight as far as it is known, without a verdict.
pub fn of_flight(name: &str, kind: &'static str, flown: FlownScenario, shown: &[usize]) -> ShownRun {
    let mut run =
        ShownRun::blank(name, kind, time(flight::taken(flown.record, shown, "t").unwrap_or_default()));
    fill(&mut run, flown.record, Some(flown.scenario), shown);
    run
}

/// Adds to a run what moves and what is plotted of a flight, of which the rows `shown` can be drawn.
fn fill(run: &mut ShownRun, record: &Record, scenario: Option<&Scenario>, shown: &[usize]) {
    run.panels = panels::flight(record, shown, scenario.and_then(|scenario| scenario.robot().ground()));
    if TurnsOfBody::of(record).is_ok_and(|turns| shown.iter().any(|&row| turns.heading[row].is_nan())) {
        run.notes.push("roll and heading have a gap where the nose passes the vertical".into());
    }
    if shown.len() < 2 {
        run.notes.push(format!("nothing moves: {} rows can be drawn", shown.len()));
    }
    if let Some(goal) = scenario.and_then(|scenario| scenario.spec.goal.as_ref()) {
        run.notes.push(format!(
            "goal: rms errors of roll within {} deg and of pitch within {} deg",
            goal.roll_within_deg, goal.pitch_within_deg
        ));
    }
    if let Some(scenario) = scenario.filter(|_| shown.len() > 1) {
        // A gait that was planned on a stand has no place.
        let stands = record.values("p_WB_x").is_none() && record.values("phase").is_some();
        let motion = if stands {
            let pitch = run.summary["plan"]["pitch_deg"].as_f64().unwrap_or(0.0);
            held::gait(scenario, record, shown, pitch.to_radians())
        } else {
            flight::motion(scenario, record, shown)
                .map(|motion| RunMotion { repeats: run.kind == "periodic flight", ..motion })
        };
        match motion {
            Ok(motion) => run.motion = Some(motion),
            Err(why) => run.notes.push(format!("no picture in space: {why}")),
        }
        if scenario.spec.lattice.is_some() {
            run.notes.push(
                "flown in the air of the vortex lattice, which the record does not hold: no wake and no forces of strips \
                 are shown, `wingbeat wake RUN` computes the wake"
                    .into(),
            );
        }
    }
    let rows = record.rows();
    if shown.last().is_some_and(|last| last + 1 < rows.saturating_sub(rows / shown.len().max(1))) {
        let last = shown.last().map_or(0, |last| last + 1);
        run.notes.push(format!("shown are the {last} of {rows} rows before numbers grew without bound"));
    }
}

/// A wing in prescribed motion.
fn tether(files: Files, blank: Blank) -> Result<ShownRun, Error> {
    let read = |path: &Path| read_csv(path).map_err(|error| error.to_string());
    let case = files.document("case.toml").and_then(|document| TetherCase::new(document, &read));
    let case = case.map_err(|error| Error::run(&files.path("case.toml"), error))?;
    let loads = files.record("loads.csv")?;
    let strips = files.has("strips.parquet").then(|| files.record("strips.parquet")).transpose()?;
    let shown = rows(loads.values("t").unwrap_or_default(), loads.rows());
    let axis = flight::taken(&loads, &shown, "t").map_err(|why| Error::run(&files.path(""), why))?;
    let mut run = blank("wing in prescribed motion", time(axis));
    run.settings = files.text("case.toml")?;
    run.panels = panels::loads(&loads, &shown);
    if files.has("compare.csv") {
        let (measured, frequency) = (files.record("compare.csv")?, case.tether.clock.frequency_hz);
        run.panels.splice(0..0, panels::compared(&measured, &run.axis.values, frequency));
    }
    if shown.len() > 1 {
        match held::wing(&case, &loads, strips.as_deref(), &shown) {
            Ok(motion) => {
                if strips.is_some() && motion.surfaces.iter().all(|surface| surface.strips.is_empty()) {
                    run.notes.push("strips.parquet does not fit loads.csv: no strips are shown".into());
                }
                if case.tether.spar.is_some() && held::strains(&case, &loads).is_empty() {
                    run.notes
                        .push("loads.csv lacks coordinates of the spar: the wing is drawn unbent".into());
                }
                run.motion = Some(RunMotion { repeats: true, ..motion });
            }
            Err(why) => run.notes.push(format!("no picture in space: {why}")),
        }
    }
    Ok(run)
}

/// The wake of a wing at several instants.
fn wake(files: Files, shots: Vec<Shot>, blank: Blank) -> Result<ShownRun, Error> {
    let names = files.parquets()?;
    let record = names.first().map(|name| files.record(name)).transpose()?;
    let t = record.as_ref().and_then(|record| record.values("t")).unwrap_or_default();
    let all: Vec<usize> = rows(t, t.len());
    let mut run = blank("wake", time(all.iter().map(|&row| t[row]).collect()));
    let document = ["case.toml", "scenario.toml"].iter().find(|name| files.has(name));
    run.settings = document.map(|name| files.text(name)).transpose()?.unwrap_or_default();
    if let Some(record) = &record {
        run.panels = panels::every(record, &all, "t");
        run.panels.retain(|panel| panel.title != "phase");
    }
    if let [first, _, ..] = &names[..] {
        run.notes.push(format!("the plots are of {first}, the first of {} stretches", names.len()));
    }
    run.shots = shots;
    Ok(run)
}

/// The runs of the rig in the folders inside, those on an arm in space, or planned ones.
fn of_rig(folder: &Path, name: &str) -> Result<Vec<ShownRun>, Error> {
    let entries = fs::read_dir(folder).map_err(|source| Error::file(folder, source))?;
    let mut inside: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    inside.sort();
    let whole =
        |inside: &PathBuf| ["scenario.toml", "record.parquet"].iter().all(|file| inside.join(file).is_file());
    // A plan is NAME.toml with its motion.
    let motion = |inside: &PathBuf| {
        inside.extension().is_some_and(|ending| ending == "toml") && inside.with_extension("csv").is_file()
    };
    let (measured, plans): (Vec<&PathBuf>, Vec<&PathBuf>) = (
        inside.iter().filter(|path| whole(path)).collect(),
        inside.iter().filter(|path| motion(path)).collect(),
    );
    let (all, planned) = if measured.is_empty() { (plans, true) } else { (measured, false) };
    if all.is_empty() {
        return Err(Error::run(
            folder,
            "nothing to show: neither summary.json, nor folders with scenario.toml and record.parquet, nor planned runs",
        ));
    }
    let mut runs = Vec::new();
    for path in all.iter().take(MOST_RUNS) {
        if planned {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            runs.push(planned_run(Files::Folder(folder), &stem, &format!("{name}/{stem}"))?);
        } else {
            runs.push(on_rig(Files::Folder(path), &format!("{name}/{}", label(path)))?);
        }
    }
    if all.len() > MOST_RUNS {
        runs[0].notes.push(format!("shown are the first {MOST_RUNS} of {} runs of {name}", all.len()));
    }
    Ok(runs)
}

/// What lines of the report of a plan begin with that are noted on its page.
const TOLD: [&str; 4] = ["turn at", "limit profile", "binding", "clearance"];

/// A run that was planned: its motion is that of the arm's table, in degrees.
fn planned_run(files: Files, stem: &str, name: &str) -> Result<ShownRun, Error> {
    let document = format!("{stem}.toml");
    let path = files.path(&document);
    let run = files.document(&document).and_then(|document| RigRun::new(document, &|_, _| None));
    let run = run.map_err(|error| Error::run(&path, error))?;
    let table = files.record(&format!("{stem}.csv"))?;
    let dof = run.arm.dof();
    let columns = table.columns();
    if columns.len() != 1 + 3 * dof {
        let what = format!("{} columns; allowed are time and three of each of {dof} joints", columns.len());
        return Err(Error::run(&files.path(&format!("{stem}.csv")), what));
    }
    let named = |k: usize, column: &Column| {
        let (name, unit) = match k.checked_sub(1) {
            None => ("t".to_owned(), "s"),
            Some(k) => {
                let (prefix, unit) = [("q", "rad"), ("dq", "rad/s"), ("ddq", "rad/s2")][k / dof];
                (format!("{prefix}{}", k % dof + 1), unit)
            }
        };
        let factor = if k == 0 { 1.0 } else { wingbeat::math::RADIANS };
        let values = column.values.iter().map(|value| factor * value).collect();
        Column { values, ..Column::new(name, unit, "") }
    };
    let columns = columns.iter().enumerate().map(|(k, column)| named(k, column)).collect();
    let record = Record::new(columns, 0).map_err(|error| Error::run(&path, error))?;
    let shown = of_rig_run(name, &run, &record).map_err(|why| Error::run(&path, why))?;
    // What the report of the plan says beside its table of limits.
    let told = files.text(&format!("{stem}.txt")).unwrap_or_default();
    let lines =
        told.lines().filter(|line| TOLD.iter().any(|begin| line.starts_with(begin))).map(String::from);
    let notes = shown.notes.iter().cloned().chain(lines).collect();
    let report: String = told.lines().map(|line| format!("# {line}\n")).collect();
    let settings = report + &files.text(&document)?;
    Ok(ShownRun { kind: "planned run of the rig", settings, notes, ..shown })
}

fn on_rig(files: Files, name: &str) -> Result<ShownRun, Error> {
    let path = files.path("scenario.toml");
    let record = files.record("record.parquet")?;
    let run = files.document("scenario.toml").and_then(|document| RigRun::new(document, &|_, _| None));
    let run = run.map_err(|error| Error::run(&path, error))?;
    let shown = of_rig_run(name, &run, &record).map_err(|why| Error::run(&files.path(""), why))?;
    Ok(ShownRun { summary: files.json("summary.json")?, settings: files.text("scenario.toml")?, ..shown })
}

/// What a `record` of the joints shows of a run on the rig; summary and settings are still to come.
///
/// # Errors
/// A record without times.
pub fn of_rig_run(name: &str, run: &RigRun, record: &Record) -> Result<ShownRun, String> {
    let shown = rows(record.values("t").unwrap_or_default(), record.rows());
    let axis = flight::taken(record, &shown, "t")?;
    let (motion, notes) = match held::on_arm(run, record, &shown) {
        Ok(motion) => (Some(motion), Vec::new()),
        Err(why) => (None, vec![format!("no picture in space: {why}")]),
    };
    Ok(ShownRun {
        notes,
        motion: motion.filter(|motion| motion.frames() > 1),
        panels: panels::every(record, &shown, "t"),
        ..ShownRun::blank(name, "run on the rig", time(axis))
    })
}

/// A run whose record is a table: a calibration, a sweep, averages.
fn table(files: Files, which: Option<&str>, blank: Blank) -> Result<ShownRun, Error> {
    let names = files.parquets()?;
    let known = names.iter().find(|name| *name == "record.parquet").or(names.first());
    let record = match which.or(known.map(String::as_str)) {
        Some(name) => files.record(name)?,
        None if files.has("cycles.csv") => files.record("cycles.csv")?,
        None => Cow::Owned(Record::default()),
    };
    let count = record.rows().min(crate::motion::MOST);
    let all: Vec<usize> = (0..count).map(|k| k * record.rows() / count.max(1)).collect();
    let column = |name: &str| flight::taken(&record, &all, name).ok();
    let document = ["calibration.toml", "sweep.toml", "scenario.toml", "case.toml"];
    let document = document.iter().find(|name| files.has(name));
    let number = |all: &[usize]| all.iter().map(|&row| row as f64).collect::<Vec<f64>>();
    let mut run = match (column("run"), column("cycle"), column("t")) {
        (Some(run), Some(cycle), _) => {
            let values = run.iter().zip(&cycle).map(|(run, cycle)| run + cycle).collect();
            blank("calibration", PlotAxis { label: "run and phase", unit: "cycles", values, joined: true })
        }
        (Some(run), None, _) => {
            blank("sweep", PlotAxis { label: "run", unit: "", values: run, joined: false })
        }
        (None, Some(values), _) => {
            blank("averages", PlotAxis { label: "phase", unit: "cycles", values, joined: true })
        }
        (None, None, Some(values)) => blank("record", time(values)),
        _ => blank("run", PlotAxis { label: "row", unit: "", values: number(&all), joined: true }),
    };
    if let Some(document) = document {
        run.settings = files.text(document)?;
    }
    run.panels = match run.kind {
        "calibration" => fits(&record, &all),
        // What is the same in all runs is said by the summary.
        "sweep" => {
            let mut panels = panels::every(&record, &all, "run");
            panels.retain(|panel| panel.curves.iter().any(PageCurve::varies));
            panels
        }
        "averages" if record.values("low_Fx").is_some() => fits(&record, &all),
        "record" => panels::every(&record, &all, "t"),
        _ => panels::every(&record, &all, "cycle"),
    };
    if run.panels.is_empty() {
        run.notes.push("the run holds no table that is drawn here".into());
    }
    Ok(run)
}

/// Of each channel of a calibration what was measured, and the model before and after the fit; of averages the mean with its band, truth
/// and model.
fn fits(record: &Record, rows: &[usize]) -> Vec<PagePanel> {
    let of = |channel: &str| {
        let unit = if channel.starts_with('F') { "N" } else { "N m" };
        let curve = |(what, role)| {
            let name = if what == "mean" { channel.into() } else { format!("{what}_{channel}") };
            let values = flight::taken(record, rows, &name).ok()?;
            Some(PageCurve { label: String::from(what), role, values })
        };
        let curves = [
            ("measured", CurveRole::Total),
            ("mean", CurveRole::Total),
            ("truth", CurveRole::Own(1)),
            ("model", CurveRole::Own(0)),
            ("before", CurveRole::Pale(2)),
            ("after", CurveRole::Own(0)),
            ("low", CurveRole::Reference),
            ("high", CurveRole::Reference),
        ];
        let curves: Vec<PageCurve> = curves.into_iter().filter_map(curve).collect();
        (!curves.is_empty()).then(|| PagePanel { title: channel.into(), unit, curves, limits: None })
    };
    CHANNELS.iter().filter_map(|(channel, _)| of(channel)).collect()
}
