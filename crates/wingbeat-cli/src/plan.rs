//! `wingbeat plan`.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget};
use wingbeat::ocp::Progress;
use wingbeat::ocp::interior_point::Iteration;
use wingbeat::scenario::{PlanSummary, Scenario};
use wingbeat_io::write_parquet;

use crate::args::Plan;
use crate::error::Error;
use crate::fly::draw;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::run_folder::RunFolder;

/// Plans the scenario's manoeuvre and writes its run folder.
pub fn plan(arguments: &Plan) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let scenario = Scenario::load(&arguments.scenario, &options.all_overrides())?;
    let folder = RunFolder::create(options.out.as_deref(), &scenario.spec.name, options.force)?;
    let interrupt = Interrupt::listen()?;
    let progress = progress(options.quiet);
    let planned = scenario.plan(&mut |step| {
        match step {
            Progress::Iteration(iteration) => progress.set_message(iteration.to_string()),
            Progress::Pass(pass) => progress.println(format!(
                "mesh {} of {} intervals: {} after {} iterations, objective {:.6}, error {:.1e}",
                pass.number + 1,
                pass.intervals,
                pass.status,
                pass.iterations,
                pass.objective,
                pass.error
            )),
        }
        interrupt.flow()
    })?;
    progress.finish_and_clear();
    interrupt.check()?;
    folder.write("scenario.toml", &scenario.resolved)?;
    folder.write_json("summary.json", &planned.summary)?;
    if let Some(record) = &planned.record {
        write_parquet(&folder.file("record.parquet"), record)?;
        draw(&folder, record, &interrupt)?;
    }
    if let Some(tracking) = &planned.tracking {
        folder.write("track.toml", tracking)?;
    }
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(scenario.spec.seed, start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    if !options.quiet {
        print!("{}", table(&planned.summary));
        println!("\nrun folder: {}", shown.display());
    }
    if planned.record.is_some() {
        return Ok(());
    }
    let (status, reason) = (planned.summary.status.into(), planned.summary.solver);
    Err(Error::Failed { status, reason, folder: shown.into() })
}

fn progress(quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(None, target);
    bar.println(Iteration::HEADING);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

fn table(summary: &PlanSummary) -> String {
    let worst = summary.resimulation_error.iter().max_by(|a, b| a.1.total_cmp(b.1));
    let worst = worst.map_or("-".into(), |(name, error)| format!("{error:.1e} in {name}"));
    let angles = |a: [f64; 3]| format!("{:.2} / {:.2} / {:.2} deg", a[0], a[1], a[2]);
    let lines = [
        ("status", format!("{}: {}", summary.status, summary.solver)),
        ("duration", format!("{:.4} s from {:.3} s on", summary.duration_s, summary.start_s)),
        ("roll / pitch / yaw, plan", angles(summary.final_angles_deg)),
        ("roll / pitch / yaw, flown", angles(summary.flown_angles_deg)),
        ("error between the nodes", format!("{:.1e}, relative", summary.interval_error)),
        ("error re-simulated", worst),
        ("intervals", format!("{} on mesh {}", summary.intervals, summary.meshes)),
        ("iterations", format!("{} in {:.1} s", summary.iterations, summary.solve_s)),
    ];
    lines.iter().map(|(name, value)| format!("{name:<28}{value}\n")).collect()
}
