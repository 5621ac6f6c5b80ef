//! `wingbeat rig plan`.

use std::time::Instant;

use wingbeat::rig::plan::Plan;
use wingbeat::scenario::RigRun;
use wingbeat_io::trajectory::{kinova_json, kortex_csv, ros_yaml};

use super::runs;
use crate::args::RigRuns;
use crate::error::Error;
use crate::manifest::Manifest;
use crate::run_folder::RunFolder;

/// Points between the poses of the Web App's list.
const POSE_EVERY: usize = 50;

/// Plans every run and writes its trajectory in the arm's formats.
pub fn plan(arguments: &RigRuns) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let runs = runs::load(&arguments.file, &options.overrides)?;
    let name = arguments.file.file_stem().map_or("plan".into(), |stem| stem.to_string_lossy());
    let folder = RunFolder::create(options.out.as_deref(), &name, options.force)?;
    let plans = runs::shared(&runs, |_, run| run.plan());
    let mut refusals = Vec::new();
    for (run, plan) in runs.iter().zip(plans) {
        let text = match plan? {
            Ok(plan) => {
                write(&folder, run, &plan)?;
                plan.report(&run.arm, &run.profile)
            }
            Err(refusal) => {
                refusals.push(format!("{}: {refusal}", run.spec.name));
                format!("refused under limit profile {}: {refusal}\n", run.profile.name)
            }
        };
        if !options.quiet {
            println!("{}\n{text}", run.spec.name);
        }
        folder.write(&format!("{}.txt", run.spec.name), &text)?;
    }
    let path = folder.finish(&Manifest::new(options.seed.unwrap_or(0), start.elapsed()))?;
    if !options.quiet {
        println!("plans: {}", path.display());
    }
    match refusals.is_empty() {
        true => Ok(()),
        false => Err(Error::Failed { status: "refused".into(), reason: refusals.join("\n"), folder: path }),
    }
}

fn write(folder: &RunFolder, run: &RigRun, plan: &Plan) -> Result<(), Error> {
    let name = &run.spec.name;
    let csv = kortex_csv(&plan.trajectory).map_err(Error::Input)?;
    folder.write(&format!("{name}.csv"), &csv)?;
    folder.write(&format!("{name}.yaml"), &ros_yaml(&plan.trajectory, "base_link"))?;
    folder.write(&format!("{name}.json"), &kinova_json(&plan.trajectory, POSE_EVERY))?;
    folder.write(&format!("{name}.toml"), &run.resolved)
}
