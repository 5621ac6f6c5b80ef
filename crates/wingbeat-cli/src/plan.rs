//! `wingbeat plan`.

use std::collections::BTreeMap;
use std::time::Instant;

use indicatif::ProgressBar;
use wingbeat::judge::{Status, Verdict};
use wingbeat::ocp::Progress;
use wingbeat::ocp::interior_point::Iteration;
use wingbeat::scenario::{GaitNumbers, LeastPowerSummary, PlanSpec, PlanSummary, RollInSummary, Scenario};
use wingbeat_figures::{FLIGHT, FigureMaker, FigureTargets, GAIT};
use wingbeat_io::write_parquet;

use crate::args::PlanArguments;
use crate::error::Error;
use crate::fly::draw;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::outcome::overridden;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;

/// Plans the scenario's manoeuvre and writes its run folder.
pub fn plan(arguments: &PlanArguments) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let scenario = Scenario::load(&arguments.scenario, &options.all_overrides())?;
    let folder = RunFolder::create(options.out.as_deref(), &scenario.spec.run_name()?, options.force)?;
    let bar = iterations(options.quiet);
    let stage = match &scenario.spec.plan {
        Some(PlanSpec::LeastPower(_)) => "stage",
        _ => "start",
    };
    let planned = scenario.plan(&mut |step| {
        // From now on there is something to be kept: the solver hears of the signal at its next iteration.
        interrupt.patient();
        match step {
            Progress::Iteration(iteration) => bar.set_message(iteration.to_string()),
            Progress::Pass(pass) => progress::line(
                &bar,
                &format!(
                    "{stage} {}, mesh {} of {} intervals: {} after {} iterations, objective {:.6}, error {:.1e}",
                    pass.stage + 1,
                    pass.number + 1,
                    pass.intervals,
                    pass.status,
                    pass.iterations,
                    pass.objective,
                    pass.error
                ),
            ),
        }
        interrupt.flow()
    });
    let planned = planned.map_err(|error| scenario.explain(&error))?;
    bar.finish_and_clear();
    if planned.nodes.is_none() {
        interrupt.check()?;
    }
    folder.write("scenario.toml", &scenario.resolved)?;
    folder.write_json("summary.json", &planned.summary)?;
    if let Some(nodes) = &planned.nodes {
        write_parquet(&folder.file("plan.parquet"), &nodes.points)?;
        folder.write_json("plan.json", &nodes.constants)?;
    }
    for (name, text) in &planned.files {
        folder.write(name, text)?;
    }
    let mut drawn = Ok(());
    if let Some(record) = &planned.record {
        write_parquet(&folder.file("record.parquet"), record)?;
        let plan_start_s = match &planned.summary {
            PlanSummary::RollIn(summary) => Some(summary.start_s),
            PlanSummary::LeastPower(_) => None,
        };
        let asked = FigureTargets { robot: Some(scenario.robot()), plan_start_s, ..FigureTargets::default() };
        drawn = draw(&folder, record, asked, figures(&planned.summary), &interrupt);
    }
    let cut = match drawn {
        Err(Error::Interrupted) => true,
        drawn => drawn.map(|()| false)?,
    };
    crate::report::beside(&folder, &scenario.spec.name, None, !arguments.page.no_report)?;
    let path = folder.finish(&Manifest::new(scenario.spec.seed, start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    let printed = say::unless(options.quiet, || {
        format!("{}\nrun folder: {}\n", table(&planned.summary), shown.display())
    });
    let Verdict { status, reason, .. } = planned.summary.verdict();
    if cut {
        let reason = format!("figures are left out, the plan is whole and {status}");
        return Error::unless_usable(Status::Interrupted, Some(&reason), shown);
    }
    Error::unless_usable(*status, reason.as_deref(), shown)?;
    printed
}

fn iterations(quiet: bool) -> ProgressBar {
    let bar = progress::bar(None, "{spinner} {msg}", quiet);
    progress::line(&bar, Iteration::HEADING);
    bar
}

fn figures(summary: &PlanSummary) -> &'static [FigureMaker] {
    match summary {
        PlanSummary::RollIn(_) => &FLIGHT,
        PlanSummary::LeastPower(_) => &GAIT,
    }
}

fn table(summary: &PlanSummary) -> String {
    let solver = summary.solver();
    let verdict = &solver.verdict;
    let mut lines = vec![("status", format!("{}: the solver ended {}", verdict.status, solver.solver))];
    lines.extend(match summary {
        PlanSummary::RollIn(summary) => roll_in(summary),
        PlanSummary::LeastPower(summary) => least_power(summary),
    });
    if verdict.status == Status::Ok {
        lines.push(("minimum", format!("{}: another guess may end lower", solver.minimum)));
    }
    let size = |of: Option<f64>| of.map_or("-".into(), |of| format!("{of:.1e}"));
    lines.push(("constraints missed by", format!("{}, scaled", size(solver.violation))));
    lines.push(("optimality missed by", format!("{}, scaled", size(solver.residual))));
    lines.push(("error between the nodes", format!("{}, relative", size(solver.interval_error))));
    lines.push(("inputs at a limit", solver.saturated_fraction.map_or("-".into(), percent)));
    lines.push(("intervals", format!("{} after {} meshes", solver.intervals, solver.meshes)));
    let seconds = format!("{:.1} s, {:.1} s of processor time", solver.solve_s, solver.processor_s);
    lines.push(("iterations", format!("{} in {seconds}", solver.iterations)));
    let mut text: String = lines.iter().map(|(name, value)| format!("{name:<28}{value}\n")).collect();
    text += &overridden(&verdict.judged);
    text.extend(verdict.warnings.iter().map(|warning| format!("\n{warning}\n")));
    text
}

type SummaryLines = Vec<(&'static str, String)>;

/// Power of drive and actuators on the joints.
fn powers(summary: &RollInSummary) -> String {
    let watts = |power: Option<f64>| power.map_or("-".into(), |power| format!("{power:.3}"));
    format!(
        "drive {} W, actuators {} W, {} W without taking back",
        watts(summary.drive_power_w),
        watts(summary.regulator_power_w),
        watts(summary.regulator_power_given_w)
    )
}

fn roll_in(summary: &RollInSummary) -> SummaryLines {
    let angles = |a: Option<[f64; 3]>| {
        a.map_or("-".into(), |a| format!("{:.2} / {:.2} / {:.2} deg", a[0], a[1], a[2]))
    };
    let duration = summary.duration_s.map_or("-".into(), |duration| format!("{duration:.4} s"));
    let momentum = summary.angular_momentum_change_kg_m2_s;
    let mut lines = vec![
        ("duration", format!("{duration} from {:.3} s on", summary.start_s)),
        ("roll / pitch / yaw, plan", angles(summary.final_angles_deg)),
        ("roll / pitch / yaw, flown", angles(summary.flown_angles_deg)),
        ("least clearance, flown", clearance(summary.least_clearance_m)),
        ("power, flown", powers(summary)),
        ("strips past stall, flown", summary.stall_fraction.map_or("-".into(), percent)),
        ("error re-simulated", worst(&summary.resimulation_error)),
    ];
    lines.extend(summary.turned_deg.map(|turned| ("turned", format!("{turned:.2} deg"))));
    lines.extend(
        momentum.map(|change| ("change of angular momentum", format!("{change:.1e} kg m2/s, flown"))),
    );
    lines.extend(summary.starts.iter().map(|words| ("starts", words.clone())));
    lines
}

fn least_power(summary: &LeastPowerSummary) -> SummaryLines {
    let gait = |gait: &GaitNumbers| {
        let m = &gait.means;
        format!(
            "{:.4} W, up {:.4} N, forward {:.4} N, {:.3} Hz, nose up {:.2} deg",
            m.drive_power_w, m.up_n, m.forward_n, gait.frequency_hz, -gait.pitch_deg
        )
    };
    let asked = format!(
        "up {:.4} N, forward {:.4} N (weight {:.4} N)",
        summary.asked_up_n, summary.asked_forward_n, summary.weight_n
    );
    let mut lines = vec![("asked", asked), ("own gait", gait(&summary.own))];
    lines.extend(summary.own_least_clearance_m.map(|m| ("least clearance, own gait", clearance(Some(m)))));
    lines.extend(summary.own_stall_fraction.map(|share| ("strips past stall, own gait", percent(share))));
    if let (Some(plan), Some(means)) = (&summary.plan, &summary.replay) {
        let replay = GaitNumbers { means: *means, ..*plan };
        lines.push(("plan", gait(plan)));
        let unrounded = summary.plan_unrounded_power_w.map_or("-".into(), |power| format!("{power:.4} W"));
        lines.push(("plan, unrounded power", unrounded));
        lines.push(("replayed from rest", gait(&replay)));
        lines.extend(summary.replay_up_by_source_n.get("profile_drag").map(|drag| {
            ("lift from profile drag", format!("{drag:.4} N of {:.4} N, by the choice of cd90", means.up_n))
        }));
        if let Some(other) = summary.replay_other {
            let m = other.means;
            let text = format!(
                "{:.4} W, up {:.4} N, forward {:.4} N under preset {}",
                m.drive_power_w, m.up_n, m.forward_n, other.preset
            );
            lines.push(("the same commands", text));
        }
        lines.push(("least clearance, replayed", clearance(summary.least_clearance_m)));
        lines.extend(summary.stall_fraction.map(|share| ("strips past stall, replayed", percent(share))));
        lines.push(("error re-simulated", worst(&summary.resimulation_error)));
    }
    lines
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn clearance(least_m: Option<f64>) -> String {
    least_m.map_or("-".into(), |least| format!("{:.2} mm", 1e3 * least))
}

fn worst(errors: &BTreeMap<String, f64>) -> String {
    let worst = errors.iter().max_by(|a, b| a.1.total_cmp(b.1));
    worst.map_or("-".into(), |(name, error)| format!("{error:.1e} in {name}"))
}
