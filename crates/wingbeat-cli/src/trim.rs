//! `wingbeat trim`.

mod search;

use std::time::Instant;

use wingbeat::scenario::{AloneSummary, Document, RobotTrim, Scenario, TrimProgress, TrimSummary, Trimmed};
use wingbeat::simulate::Record;
use wingbeat_figures::{FigureMaker, family, multipliers, orbit};
use wingbeat_io::write_parquet;

use crate::args::Trim;
use crate::error::Error;
use crate::fly::draw_each;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;
use crate::watch::{ConvergenceWatch, SearchIteration};

/// Finds the scenario's periodic flight and writes its run folder.
pub fn trim(arguments: &Trim) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let document = Document::file(&arguments.file)?;
    if RobotTrim::takes(&document) {
        return alone(arguments, document, &interrupt, start);
    }
    if arguments.bank.is_some() {
        let text = "--bank: allowed with a robot's file; a scenario has trim.bank_deg";
        return Err(Error::Input(text.into()));
    }
    let scenario = Scenario::new(document.overridden(&options.all_overrides()))?;
    let (out, name) = (options.out.as_deref(), &scenario.spec.run_name()?);
    let search = scenario.gait_search()?;
    let folder = match &search {
        Some(_) => RunFolder::resume(out, name, options.force, ("scenario.toml", &scenario.resolved))?,
        None => RunFolder::create(out, name, options.force)?,
    };
    wingbeat_figures::prepare();
    let watch = ConvergenceWatch::begin(
        &arguments.live,
        &scenario.spec.name,
        "search under way",
        &scenario.resolved,
    )?;
    let searched = match &search {
        Some(search) => Some(search::searched(search, &folder, &interrupt, options.quiet, &watch)?),
        None => None,
    };
    let bar = progress::bar(None, "{spinner} {elapsed}  {msg}", options.quiet);
    let mut tell = |at: TrimProgress| {
        if let TrimProgress::Orbit { orbits, iteration, residual } = at {
            watch.see(|| orbit_point(orbits, residual));
            bar.set_message(format!("orbit {}, iteration {iteration}: residual {residual:.1e}", orbits + 1));
        }
        interrupt.flow()
    };
    let trimmed = match searched {
        Some(searched) => searched.trim(&mut tell)?,
        None => scenario.trim(&mut tell)?,
    };
    bar.finish_and_clear();
    watch.end();
    interrupt.check()?;
    if search.is_none() {
        folder.write("scenario.toml", &scenario.resolved)?;
    }
    let (name, seed) = (&scenario.spec.name, scenario.spec.seed);
    written(arguments, folder, &trimmed, (name, seed), &interrupt, start)
}

/// Trims a robot from its file alone and writes its run folder.
fn alone(arguments: &Trim, document: Document, interrupt: &Interrupt, start: Instant) -> Result<(), Error> {
    let options = &arguments.run;
    let checked = RobotTrim::check_bank(arguments.bank.unwrap_or(0.0));
    checked.map_err(|error| error.renamed(&[("bank_deg", "--bank")]))?;
    let asked = RobotTrim::new(document, &options.all_overrides(), arguments.bank.unwrap_or(0.0))?;
    let scenario = &asked.scenario;
    let folder = RunFolder::create(options.out.as_deref(), &scenario.spec.run_name()?, options.force)?;
    wingbeat_figures::prepare();
    let watch =
        ConvergenceWatch::begin(&arguments.live, &scenario.spec.name, "trim under way", &scenario.resolved)?;
    let bar = progress::bar(None, "{spinner} {elapsed}  {msg}", options.quiet);
    let trimmed = asked.trim(&mut |at| {
        bar.set_message(match at {
            TrimProgress::Orbit { orbits, iteration, residual } => {
                watch.see(|| orbit_point(orbits, residual));
                format!("orbit {}, iteration {iteration}: residual {residual:.1e}", orbits + 1)
            }
            TrimProgress::Search(at) => {
                format!(
                    "search, iteration {}: {:.1} W/kg, {:.2} Hz",
                    at.iteration, at.power_w_kg, at.frequency_hz
                )
            }
            TrimProgress::Turn { flight } => format!("turn, flight {flight}"),
        });
        interrupt.flow()
    })?;
    bar.finish_and_clear();
    watch.end();
    interrupt.check()?;
    folder.write("scenario.toml", &scenario.resolved)?;
    let (name, seed) = (&scenario.spec.name, scenario.spec.seed);
    written(arguments, folder, &trimmed, (name, seed), interrupt, start)
}

/// Writes what was found into the folder, and prints it.
fn written(
    arguments: &Trim,
    folder: RunFolder,
    trimmed: &Trimmed,
    (name, seed): (&str, u64),
    interrupt: &Interrupt,
    start: Instant,
) -> Result<(), Error> {
    let options = &arguments.run;
    folder.write_json("summary.json", &trimmed.summary)?;
    let tables = [
        ("record.parquet", &trimmed.record),
        ("multipliers.parquet", &trimmed.multipliers),
        ("family.parquet", &trimmed.family),
    ];
    for (name, record) in tables {
        if let Some(record) = record {
            write_parquet(&folder.file(name), record)?;
        }
    }
    let draws: [(&Option<Record>, FigureMaker); 3] = [
        (&trimmed.record, |record, _| orbit(record)),
        (&trimmed.multipliers, |record, _| multipliers(record)),
        (&trimmed.family, |record, _| family(record)),
    ];
    let mut draws: Vec<_> =
        draws.iter().filter_map(|(record, figure)| record.as_ref().map(|record| (record, *figure))).collect();
    let given_way =
        |record| wingbeat_figures::of_deformation(record).into_iter().map(move |draw| (record, draw));
    draws.extend(trimmed.record.iter().flat_map(given_way));
    draw_each(&folder, &draws, wingbeat_figures::FigureTargets::default(), interrupt)?;
    for (name, text) in &trimmed.files {
        folder.write(name, text)?;
    }
    crate::report::beside(&folder, name, None, !arguments.page.no_report)?;
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(seed, start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    let printed = say::unless(options.quiet, || {
        format!("{}\nrun folder: {}\n", table(&trimmed.summary), shown.display())
    });
    Error::unless_usable(trimmed.summary.status, trimmed.summary.reason.as_deref(), shown)?;
    printed
}

/// The residual of an orbit as it is shown.
fn orbit_point(orbits: usize, residual: f64) -> SearchIteration {
    let values = vec![("decimal logarithm of the residual".into(), "", residual.log10())];
    SearchIteration { series: format!("orbit {}", orbits + 1), values }
}

fn table(summary: &TrimSummary) -> String {
    let number = |value: Option<f64>, digits: usize| value.map_or("-".into(), |v| format!("{v:.digits$}"));
    let share = |value: Option<f64>| value.map_or("-".into(), |v| format!("{:.1} %", 100.0 * v));
    let course = format!(
        "{:.3} m/s, climb {:.3} m/s, bank {:.1} deg",
        summary.speed_m_s, summary.climb_m_s, summary.bank_deg
    );
    let power = format!(
        "{} W/kg of {} W; joint by joint {}, net {}",
        number(summary.cost.positive_power_w_kg, 1),
        number(summary.cost.positive_power_w, 3),
        number(summary.cost.separate_power_w_kg, 1),
        number(summary.cost.net_power_w_kg, 1)
    );
    let carried = summary.cost.weight_lines().into_iter().skip(1);
    let carried: Vec<String> = carried.map(|(name, share, unit)| format!("{name} {share} {unit}")).collect();
    let constant = summary.constant_clearance.as_ref().map(|parts| format!(", always that of {parts}"));
    let clearance = number(summary.least_clearance_m.map(|c| 1e3 * c), 2) + " mm";
    let clearance = clearance + &constant.unwrap_or_default();
    let stalled = format!("{} / {}", share(summary.stall_fraction_12), share(summary.stall_fraction_20));
    let commands: Vec<String> = (summary.commands.iter().filter(|(_, value)| **value != 0.0))
        .map(|(name, value)| format!("{} {value:.4}", name.trim_start_matches("command_")))
        .collect();
    let lines = [
        ("status", summary.status.to_string()),
        ("course", course),
        ("frequency", format!("{} Hz", number(summary.frequency_hz, 4))),
        ("positive power", power),
        (
            "power of twist / actuators",
            format!("{} / {} W", number(summary.twist_power_w, 4), number(summary.regulator_power_w, 4)),
        ),
        ("lift over weight", number(summary.lift_over_weight, 6)),
        ("weight carried by", if carried.is_empty() { "-".into() } else { carried.join(", ") }),
        ("Strouhal number", number(summary.strouhal, 3)),
        ("stalled at 12 / 20 deg", stalled),
        ("least clearance", clearance),
        (
            "roll / nose up, mean",
            format!(
                "{} / {} deg",
                number(summary.roll_mean_deg, 2),
                number(summary.pitch_mean_deg.map(|pitch| -pitch), 2)
            ),
        ),
        ("heave", format!("{} mm", number(summary.heave_m.map(|h| 1e3 * h), 1))),
        ("commands", if commands.is_empty() { "at rest".into() } else { commands.join(", ") }),
        ("largest multiplier", number(summary.largest_multiplier, 5)),
        ("held by gains.csv", number(summary.held_multiplier, 5)),
        (
            "residual",
            summary.residual.map_or("-".into(), |r| {
                format!("{r:.1e} after {} iterations", summary.iterations.unwrap_or(0))
            }),
        ),
        ("search", format!("{:.2} s, {} steps a cycle", summary.search_s, summary.steps)),
        ("lift law", summary.lift_law.clone()),
    ];
    // Of a search that found nothing there is nothing to tell but what was asked.
    let asked = ["status", "course", "search", "lift law"];
    let told = |name: &str| summary.residual.is_some() || asked.contains(&name);
    let lines = lines.iter().filter(|(name, _)| told(name));
    let mut text: String = lines.map(|(name, value)| format!("{name:<28}{value}\n")).collect();
    for mode in summary.multipliers.iter().take(8) {
        text += &format!(
            "{:<28}{:>8.5}  {:+.2} 1/s  {:.2} Hz  {} {}\n",
            "multiplier", mode.size, mode.growth_per_s, mode.frequency_hz, mode.sector, mode.label
        );
    }
    if let Some(search) = &summary.search {
        text += &search::table(search);
    }
    if let Some(orbits) = summary.family_orbits {
        let ended = summary.family_ended.as_deref().unwrap_or("to its end");
        text += &format!("{:<28}{orbits} orbits: {ended}\n", "family");
    }
    if let Some(alone) = &summary.alone {
        text += &of_alone(alone);
    }
    for warning in &summary.warnings {
        text += &format!("\n{warning}\n");
    }
    text
}

/// A number with five places, or four digits where these say too little.
fn five_places(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 { format!("{value:.3e}") } else { format!("{value:.5}") }
}

/// What a trim from a robot's file chose, in words.
fn of_alone(alone: &AloneSummary) -> String {
    let mut text = format!(
        "{:<28}{:.2} m/s, {:.2} Hz\n",
        "guess of scaling laws", alone.guessed_speed_m_s, alone.guessed_frequency_hz
    );
    for tried in &alone.tried {
        let what = match (tried.power_w_kg, tried.frequency_hz) {
            (Some(power), Some(frequency)) => format!("{power:.0} W/kg at {frequency:.2} Hz"),
            _ => "no orbit".into(),
        };
        let reason = tried.reason.as_deref().map_or(String::new(), |reason| format!("; {reason}"));
        text += &format!("{:<28}{:.2} m/s: {what}{reason}\n", "tried", tried.speed_m_s);
    }
    let steps = alone.search_iterations.map_or(String::new(), |steps| format!(" after {steps} steps tried"));
    text.extend(
        alone.search_ended.iter().map(|ended| format!("{:<28}{ended}{steps}\n", "search of the gait")),
    );
    for (key, [from, to]) in &alone.changed {
        let number = |value: &Option<f64>| value.map_or("left out".into(), five_places);
        text += &format!("{:<28}{key} = {}, was {}\n", "chosen", number(to), number(from));
    }
    let Some(turn) = &alone.turn else { return text };
    let number = |value: Option<f64>, scale: f64| value.map_or("-".into(), |v| format!("{:.1}", scale * v));
    text += &format!(
        "{:<28}{}: {:.0} deg at {:.2} m/s, roll {} deg, height off by {} mm, clear by {} mm, {} W/kg; flight {}\n",
        "turn",
        turn.status,
        turn.bank_deg,
        turn.speed_m_s,
        number(turn.roll_mean_deg, 1.0),
        number(turn.height_max_error_m, 1e3),
        number(turn.least_clearance_m, 1e3),
        number(turn.power_w_kg, 1.0),
        turn.flights
    );
    text
}
