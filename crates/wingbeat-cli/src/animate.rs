//! `wingbeat animate`.

use std::path::{Path, PathBuf};

use wingbeat_figures::animation::Animation;
use wingbeat_report::animate::{AnimationSettings, Film, Viewpoint};
use wingbeat_report::run::{ShownRun, read};

use crate::args::{Animate, AnimatedView};
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::report::{free, refused};
use crate::run_folder::{Numbered, replace_by, replace_folder};
use crate::{progress, say};

/// The frames in a folder.
const FRAMES: Numbered = Numbered { prefix: "frame_", suffix: ".png", list: "" };

/// Draws the frames of a run and writes them.
pub fn animate(arguments: &Animate) -> Result<(), Error> {
    let interrupt = Interrupt::listen()?;
    let asked = asked(arguments)?;
    let asked_out = arguments.out.as_deref();
    if let Some(out) = asked_out.filter(|_| !arguments.force) {
        // Before the run is read: refused at once.
        is_file(out)?.then(|| free(out, false)).transpose()?;
    }
    let run = only(read(&arguments.run).map_err(refused)?)?;
    let out =
        &asked_out.map_or_else(|| PathBuf::from(run.name.replace('/', "_") + ".png"), Path::to_path_buf);
    let animated = is_file(out)?;
    if animated {
        free(out, arguments.force)?;
    }
    let film = Film::new(&run, asked).map_err(Error::Input)?;
    let template = "drawing {bar:30} {percent:>3} %  ({eta} left)";
    let bar = progress::bar(Some(film.frames() as u64), template, arguments.quiet);
    let mut draw = |out: &Path| {
        let mut animation = Animation::default();
        for k in 0..film.frames() {
            interrupt.check()?;
            animation.push(&film.picture(k)).map_err(failed)?;
            bar.inc(1);
        }
        animation.cover(&film.cover()).map_err(failed)?;
        bar.finish_and_clear();
        let written = if animated { animation.write(out, 1.0 / asked.rate) } else { animation.sequence(out) };
        written.map_err(failed)
    };
    match animated {
        true => replace_by(out, draw)?,
        false => replace_folder(out, FRAMES, arguments.force, &mut draw)?,
    }
    say::unless(arguments.quiet, || format!("{} frames: {}\n", film.frames(), out.display()))
}

/// The run of a folder that holds one; of the rig the first that moves.
pub fn only(runs: Vec<ShownRun>) -> Result<ShownRun, Error> {
    let moves = runs.iter().position(|run| run.motion.is_some()).unwrap_or(0);
    runs.into_iter().nth(moves).ok_or_else(|| Error::Input("no run".into()))
}

fn failed(error: wingbeat_figures::Error) -> Error {
    match error {
        wingbeat_figures::Error::File { path, source } => Error::File { path, source },
        error => Error::Input(format!("the animation cannot be written: {error}")),
    }
}

/// Whether `out` is an animated PNG; else it is a folder.
fn is_file(out: &Path) -> Result<bool, Error> {
    match out.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase()) {
        Some(extension) if extension == "png" || extension == "apng" => Ok(true),
        Some(extension) if ["webp", "mp4", "gif", "avi", "mov", "webm", "jpg"].contains(&&*extension) => {
            Err(Error::Input(format!(
                "--out {}: no .{extension} is written; allowed is FILE.png, an animated PNG, or a folder for a sequence of PNG files",
                out.display()
            )))
        }
        _ => Ok(false),
    }
}

fn asked(arguments: &Animate) -> Result<AnimationSettings, Error> {
    let asked = AnimationSettings {
        seen: match arguments.view {
            AnimatedView::Whole => Viewpoint::Whole,
            AnimatedView::Behind => Viewpoint::Behind,
            AnimatedView::Side => Viewpoint::Side,
            AnimatedView::Above => Viewpoint::Above,
        },
        speed: arguments.speed,
        rate: arguments.rate,
        width: f64::from(arguments.width),
        wide: arguments.wide,
    };
    asked.checked("--").map_err(Error::Input)
}
