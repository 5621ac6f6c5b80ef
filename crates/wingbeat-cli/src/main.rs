//! The program `wingbeat`: a thin face over the library.

mod animate;
mod args;
mod average;
mod calibrate;
mod export;
mod fly;
mod migrate;
mod new;
mod outcome;
mod paper;
mod plan;
#[cfg(test)]
mod reference;
mod report;
mod rig;
mod show;
mod sweep;
mod tether;
mod time_left;
mod trim;
mod validate;
mod wake;
mod watch;

use std::process::ExitCode;

use clap::Parser;

use wingbeat::scenario::DocumentKind;
use wingbeat_program::{error, interrupt, manifest, progress, run_folder, say};

use args::{Arguments, Command};

/// The JSON Schema of a kind of document as a file has it.
fn schema_text(kind: DocumentKind) -> String {
    format!("{:#}\n", kind.schema_of_files())
}

fn main() -> ExitCode {
    wingbeat_program::run(|| match Arguments::parse().command {
        Command::Fly(arguments) => fly::fly(&arguments),
        Command::Sweep(arguments) => sweep::sweep(&arguments),
        Command::Tether(arguments) => tether::tether(&arguments),
        Command::Wake(arguments) => wake::wake(&arguments),
        Command::Plan(arguments) => plan::plan(&arguments),
        Command::Calibrate(arguments) => calibrate::calibrate(&arguments),
        Command::Trim(arguments) => trim::trim(&arguments),
        Command::Rig(command) => rig::rig(&command),
        Command::Average(arguments) => average::average(&arguments),
        Command::Paper(arguments) => paper::paper(&arguments),
        Command::Show(arguments) => show::show(&arguments),
        Command::Report(arguments) => report::report(&arguments),
        Command::Animate(arguments) => animate::animate(&arguments),
        Command::Export(arguments) => export::export(&arguments),
        Command::Validate(_) => validate::validate(),
        Command::New(arguments) => new::new(&arguments),
        Command::Migrate(arguments) => migrate::migrate(&arguments),
        Command::Schema(arguments) => say::say(&schema_text(arguments.kind)),
    })
}
