//! `wingbeat wake`.

mod draw;
mod stroke;
mod watch;

use std::time::Instant;

use wingbeat::scenario::TetherCase;
use wingbeat_io::write_parquet;
use wingbeat_lattice::{Core, Flapping, Lattice, Panels, Scene, Settings, Spacing, WakeMotion};

use crate::args::Wake;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;
use crate::tether::Tables;
use stroke::Stroke;
use watch::{Summary, Watch};

/// Most rings of a wake: minutes of work.
const MOST_RINGS: usize = 200_000;
/// Fewest and most steps of a cycle that are chosen.
const STEPS: (f64, f64) = (24.0, 400.0);
/// Steps of a cycle without wind.
const STILL: f64 = 48.0;

/// Steps the lattice of a case and writes its run folder.
pub fn wake(arguments: &Wake) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let tables = Tables::default();
    let case = TetherCase::load(&arguments.case, &options.overrides, &|path| tables.read(path))?;
    let (settings, panels, steps) = settings(arguments, &case)?;
    let folder = RunFolder::create(options.out.as_deref(), &case.spec.run_name()?, options.force)?;
    let watch = step(&case, settings, panels, steps, &interrupt, options.quiet)?;
    let summary = watch.summary(&case, arguments);
    folder.write("case.toml", &case.kept(|path| tables.name(path))?)?;
    tables.keep(&folder)?;
    folder.write_json("summary.json", &summary)?;
    write_parquet(&folder.file("record.parquet"), &watch.record)?;
    for shot in &watch.shots {
        folder.write(&format!("{}.vtk", shot.name.replace(' ', "_")), &shot.picture.vtk())?;
    }
    draw::draw(&folder, &watch)?;
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(options.seed.unwrap_or(0), start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    match &watch.failed {
        Some(reason) => {
            Err(Error::Failed { status: summary.status, reason: reason.clone(), folder: shown.into() })
        }
        None => {
            say::unless(options.quiet, || format!("{}\nrun folder: {}\n", table(&summary), shown.display()))
        }
    }
}

/// Settings, panels and steps per cycle that the command line asks for.
fn settings(arguments: &Wake, case: &TetherCase) -> Result<(Settings, Panels, usize), Error> {
    let tether = &case.tether;
    let (clock, chord) = (tether.clock, tether.reference.chord_m);
    let way = chord / arguments.chordwise as f64;
    let fitting = tether.wind.norm() / (clock.frequency_hz * way);
    let fitting = if fitting > 0.0 { fitting.round().clamp(STEPS.0, STEPS.1) } else { STILL };
    let steps = arguments.steps.unwrap_or(fitting as usize);
    let rings = clock.cycles.saturating_mul(steps).saturating_mul(arguments.spanwise);
    if rings > MOST_RINGS {
        let text = format!(
            "cycles times steps times spanwise panels are {rings} rings of the wake: allowed are at most {MOST_RINGS}"
        );
        return Err(Error::Input(text));
    }
    let step_s = 1.0 / (clock.frequency_hz * steps as f64);
    let core = Core { radius_m: arguments.core * chord, viscosity_m2_s: 0.0, squire: 0.0 };
    let wake = if arguments.prescribed { WakeMotion::Prescribed } else { WakeMotion::Free };
    let settings = Settings { wake, core, ..Settings::new(step_s, core.radius_m) };
    let panels =
        Panels { chordwise: arguments.chordwise, spanwise: arguments.spanwise, spacing: Spacing::Lan };
    Ok((settings, panels, steps))
}

/// Steps all cycles; a lattice that fails ends the run with what there is.
fn step(
    case: &TetherCase,
    settings: Settings,
    panels: Panels,
    steps: usize,
    interrupt: &Interrupt,
    quiet: bool,
) -> Result<Watch, Error> {
    let refused = |error: wingbeat_lattice::Error| Error::Input(error.to_string());
    let flapping = Flapping::try_from(&case.tether).map_err(refused)?;
    let symmetric = Scene::new(&flapping, panels, true).map_err(refused)?.symmetric;
    let scene = Scene::new(&flapping, panels, false).map_err(refused)?;
    let mut lattice = Lattice::new(scene, settings).map_err(refused)?;
    let total = case.tether.clock.cycles * steps;
    let mut watch = Watch::new(&case.tether, Stroke::of(&case.tether, steps), steps, symmetric);
    let bar = progress::bar(Some(total as u64), "stepping {bar:30} {percent:>3} %  ({eta} left)", quiet);
    for k in 0..total {
        match lattice.step() {
            Ok(loads) => watch.see(k, &lattice, &loads),
            Err(error) => {
                watch.failed = Some(error.to_string());
                break;
            }
        }
        bar.set_position(k as u64);
        interrupt.check()?;
    }
    bar.finish_and_clear();
    watch.circulation_error = lattice.circulation_error();
    Ok(watch)
}

/// What is printed.
fn table(summary: &Summary) -> String {
    let mut text = format!(
        "{}: vortex lattice, {} wake, {} x {} panels, {} steps per cycle; last cycle, from rest\n\n",
        summary.name, summary.wake, summary.panels[0], summary.panels[1], summary.steps_per_cycle
    );
    let rows = [
        ("mean lift", summary.mean_lift_n, "N, by Joukowski"),
        ("", summary.mean_lift_bernoulli_n, "N, by Bernoulli with leading-edge suction"),
        ("mean drag", summary.mean_drag_n, "N, by Joukowski"),
        ("", summary.mean_drag_bernoulli_n, "N, by Bernoulli with leading-edge suction"),
        ("circulation error", Some(summary.circulation_error), ""),
        ("symmetry error", summary.symmetry_error, ""),
        ("down over up, left", summary.down_over_up.left, "mean bound circulation"),
        ("down over up, right", summary.down_over_up.right, "mean bound circulation"),
    ];
    for (name, value, unit) in rows {
        let value = value.map_or("-".into(), |value| format!("{value:.4e}"));
        text += format!("{name:<22}{value:>12}  {unit}").trim_end();
        text.push('\n');
    }
    for warning in &summary.warnings {
        text += &format!("\nnote: {warning}\n");
    }
    text
}
