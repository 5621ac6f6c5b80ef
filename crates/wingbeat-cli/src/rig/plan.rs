//! `wingbeat rig plan`.

use std::time::Instant;

use wingbeat::parallel;
use wingbeat::rig::JointTrajectory;
use wingbeat::rig::plan::{LARGEST_POSITION, TurnPlan};
use wingbeat::scenario::RigRun;
use wingbeat_io::trajectory::{kinova_json, kortex_csv, ros_yaml};

use super::{pictures, runs};
use crate::args::RigPlan;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::run_folder::{RunFolder, named_after};
use crate::say;

/// Points between the poses of the Web App's list.
const POSE_EVERY: usize = 50;

/// Plans every run and writes its trajectory in the arm's formats.
pub fn plan(arguments: &RigPlan) -> Result<(), Error> {
    let start = Instant::now();
    let interrupt = Interrupt::listen()?;
    let (options, file) = (&arguments.runs.run, &arguments.runs.file);
    let runs = runs::load(file, &options.overrides)?;
    let from = arguments.from_deg.as_deref().map(present).transpose()?;
    let name = named_after(file, options.out.as_deref())?;
    let folder = RunFolder::create(options.out.as_deref(), &name, options.force)?;
    let plans = parallel::map(&runs, |_, run| run.plan().map_err(|error| run.explain(&error)));
    let (mut refusals, mut written, mut told) = (Vec::new(), 0, String::new());
    for (run, plan) in runs.iter().zip(plans) {
        let name = &run.spec.name;
        let mut refused = |what: &str, why: String| {
            refusals.push(format!("{name}: {what}{why}"));
            format!("{what}refused under limit profile {}: {why}\n", run.profile.name)
        };
        let text = match plan? {
            Ok(plan) => {
                write(&folder, run, &plan)?;
                pictures::draw(&folder, run, &plan)?;
                written += 1;
                let approach = approach(&folder, run, &plan, from.as_deref())?;
                let approach = approach.unwrap_or_else(|why| refused("way from the present pose: ", why));
                plan.report(&run.arm, &run.profile) + &approach
            }
            Err(refusal) => refused("", refusal.to_string()),
        };
        told += &format!("{name}\n{text}\n");
        folder.write(&format!("{name}.txt"), &text)?;
    }
    // Where no run can be planned there is nothing to keep.
    if refusals.len() == runs.len() && written == 0 {
        return Err(Error::Input(refusals.join("\n")));
    }
    crate::report::beside(&folder, name.as_str(), None, !arguments.page.no_report)?;
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(options.seed.unwrap_or(0), start.elapsed()))?;
    let printed = say::unless(options.quiet, || format!("{told}plans: {}\n", path.display()));
    match refusals.is_empty() {
        true => printed,
        false => Err(Error::Failed { status: "refused".into(), reason: refusals.join("\n"), folder: path }),
    }
}

/// The present pose in rad.
fn present(from_deg: &[f64]) -> Result<Vec<f64>, Error> {
    let largest = LARGEST_POSITION.to_degrees();
    match from_deg.iter().find(|deg| deg.is_nan() || deg.abs() > largest) {
        Some(deg) => {
            Err(Error::Input(format!("--from-deg {deg}: allowed are angles of at most {largest:.0} deg")))
        }
        None => Ok(from_deg.iter().map(|deg| deg.to_radians()).collect()),
    }
}

fn write(folder: &RunFolder, run: &RigRun, plan: &TurnPlan) -> Result<(), Error> {
    let name = &run.spec.name;
    trajectory(folder, name, &plan.trajectory)?;
    folder.write(&format!("{name}.toml"), &run.resolved)
}

/// Plans and writes the way from the pose `from`, where there is one: the report, or why not.
fn approach(
    folder: &RunFolder,
    run: &RigRun,
    plan: &TurnPlan,
    from: Option<&[f64]>,
) -> Result<Result<String, String>, Error> {
    let Some(from) = from else { return Ok(Ok(String::new())) };
    match run.approach(from, plan).map_err(|error| error.renamed(&[("from", "--from-deg")]))? {
        Ok(approach) => {
            trajectory(folder, &format!("{}_approach", run.spec.name), &approach.trajectory)?;
            Ok(Ok(approach.report(&run.profile)))
        }
        Err(refusal) => Ok(Err(refusal.to_string())),
    }
}

/// Writes a motion in the formats of the arm's controllers.
fn trajectory(folder: &RunFolder, name: &str, motion: &JointTrajectory) -> Result<(), Error> {
    folder.write(&format!("{name}.csv"), &kortex_csv(motion).map_err(Error::Input)?)?;
    folder.write(&format!("{name}.yaml"), &ros_yaml(motion, "base_link"))?;
    folder.write(&format!("{name}.json"), &kinova_json(motion, POSE_EVERY))
}
