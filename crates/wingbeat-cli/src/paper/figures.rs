//! The six figures.

use std::path::{Path, PathBuf};

use wingbeat::rig::plan::Refusal;
use wingbeat::scenario::{Document, PaperResults, RigRun};
use wingbeat_figures::{CellOrigin, Figure, FigureTargets};
use wingbeat_io::{read_parquet, urdf_as_toml};
use wingbeat_lattice::course::{CourseRequest, WakeSummary};

use super::shipped;
use super::statements::{Arm, RigForces};
use crate::args::{RunArguments, Show};
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::rig::pictures;
use crate::run_folder::RunFolder;
use crate::{show, wake};

/// The run on the rig that set-up and arm show.
const RUN: &str = "rigs/runs/roll15_speed08.toml";
/// The slowest run, and what gives it the paper's limit of the tool's speed.
const SLOWEST: (&str, &str) = ("rigs/runs/roll15_speed07.toml", "profile=paper-tool");
/// Name and caption of the six figures, in the order of the sheet.
const FIGURES: [(&str, &str); 6] = [
    ("setup", "Set-up: arm, load cell, mount and robot with their frames."),
    ("arm", "Snapshots of arm and flapping robot in the banking turn."),
    (
        "force_moment",
        "Forces and moments on the load cell over three cycles: red the simulated rig (band of seven runs), which is no \
         experiment, black another model on the measured motion.",
    ),
    (
        "wake_phases",
        "Wake in the turn at four phases of the cycle, prescribed wake. The strongest vorticity that is seen in an upstroke was \
         mostly shed before, in a downstroke: each panel says when. Attached flow is assumed.",
    ),
    ("states", "States in the turn with the references of roll and pitch."),
    ("path", "Snapshots of the turn; the paper's end point is marked at the height of ours."),
];

/// Plans the slowest run under the paper's limit of the tool's speed.
pub fn slowest(from: &Path) -> Result<Arm, Error> {
    let (file, limit) = SLOWEST;
    let run = RigRun::new(Document::file(&shipped(from, file))?.set(limit), &urdf_as_toml)?;
    Ok(match run.plan().map_err(|error| run.explain(&error))? {
        Ok(_) => Arm::Planned,
        Err(limited @ Refusal::Limit { .. }) => Arm::Limited(limited.to_string()),
        Err(refusal) => Arm::Refused(refusal.to_string()),
    })
}

/// The figures as they are drawn.
pub struct PaperFigures {
    folder: PathBuf,
    wide: Option<PathBuf>,
    done: Vec<(&'static str, String)>,
}

impl PaperFigures {
    /// None yet; with `wide` each is drawn for a slide too.
    pub fn new(folder: &RunFolder, wide: bool) -> Result<Self, Error> {
        let wide = wide.then(|| folder.folder("figures/wide")).transpose()?;
        Ok(Self { folder: folder.folder("figures")?, wide, done: Vec::new() })
    }

    /// Names of those that are there.
    pub fn names(&self) -> Vec<&str> {
        self.done.iter().map(|(name, _)| *name).collect()
    }

    /// Number of those that are not.
    pub fn missing(&self) -> usize {
        FIGURES.len() - self.done.len()
    }

    /// Caption and SVG of the figures that are there, in the order of the sheet.
    pub fn shown(&self) -> impl Iterator<Item = (&'static str, &'static str, &str)> {
        FIGURES.into_iter().filter_map(|(name, caption)| {
            let (_, svg) = self.done.iter().find(|(done, _)| *done == name)?;
            Some((name, caption, svg.as_str()))
        })
    }

    /// Writes a figure under `name`, and for a slide the figure `wide` or else the same; one that cannot be drawn is said and left out.
    fn put(
        &mut self,
        name: &'static str,
        figure: Result<Figure, wingbeat_figures::Error>,
        wide: Option<Result<Figure, wingbeat_figures::Error>>,
    ) -> Result<(), Error> {
        let written = figure.and_then(|figure| {
            let figure = figure.named(name);
            wingbeat_figures::write(&self.folder, &figure)?;
            let svg = figure.svg();
            if let Some(folder) = &self.wide {
                let slide = wide.unwrap_or(Ok(figure))?.named(name);
                wingbeat_figures::write_slide(folder, slide)?;
            }
            Ok(svg)
        });
        match written {
            Ok(svg) => {
                self.done.push((name, svg));
                Ok(())
            }
            Err(error) => crate::fly::left_out(Err(error)),
        }
    }

    /// The rig.
    pub fn set_up(&mut self, from: &Path) -> Result<(), Error> {
        let run = RunArguments { out: None, force: false, overrides: Vec::new(), seed: None, quiet: true };
        let asked = Show { file: shipped(from, RUN), phase: None, joints_deg: None, run };
        let figure = show::figure(&asked)?;
        self.put("setup", Ok(figure), None)
    }

    /// Arm and robot in the turn.
    pub fn arm(&mut self, from: &Path) -> Result<(), Error> {
        let run = RigRun::new(Document::file(&shipped(from, RUN))?, &urdf_as_toml)?;
        let plan = run.plan().map_err(|error| run.explain(&error))?;
        let plan = plan.map_err(|refusal| Error::Input(format!("{RUN}: {refusal}")))?;
        self.put("arm", pictures::snapshots(&run, &plan).map_err(wingbeat_figures::Error::Picture), None)
    }

    /// Forces and moments of the processed runs.
    pub fn forces(&mut self, folder: &Path) -> Result<Option<RigForces>, Error> {
        let file = folder.join("envelope.parquet");
        if !file.is_file() {
            return Ok(None);
        }
        let envelope = read_parquet(&file)?;
        self.put("force_moment", wingbeat_figures::force_moment(&envelope, CellOrigin::Simulated), None)?;
        Ok(RigForces::of(&envelope))
    }

    /// States, path and wake of the flight in `folder`: what is said of the wake, and what the paper gives.
    pub fn flight(
        &mut self,
        folder: &Path,
        interrupt: &Interrupt,
    ) -> Result<(Option<WakeSummary>, Option<PaperResults>), Error> {
        let flown = wake::recorded(folder)?;
        let spec = &flown.scenario().spec;
        let (robot, paper) = (Some(flown.scenario().robot()), spec.paper.clone());
        let asked = FigureTargets { robot, goal: spec.goal.as_ref(), ..FigureTargets::default() };
        let record = read_parquet(&folder.join("record.parquet"))?;
        self.put(
            "states",
            wingbeat_figures::states(&record, asked),
            Some(wingbeat_figures::states_wide(&record, asked)),
        )?;
        self.put("path", wingbeat_figures::path(&record, paper.as_ref()), None)?;
        let asked = CourseRequest { prescribed: true, ..CourseRequest::default() };
        let mut courses = flown.courses(&asked).map_err(wake::refused)?;
        // The last beats, which are in the turn.
        let Some(course) = courses.pop() else { return Ok((None, paper)) };
        let watches = [course.step(&asked, &mut |_| interrupt.flow()).map_err(wake::refused)?];
        interrupt.check()?;
        let sheets = wake::phases(&watches);
        let notes = wake::notes(&watches);
        let drawn = |wide| wingbeat_figures::wake_phases(&sheets, &notes, wide);
        self.put("wake_phases", drawn(false), Some(drawn(true)))?;
        let told = WakeSummary::new(&spec.name, &asked, &watches, flown.scenario().limits());
        Ok((Some(told), paper))
    }
}
