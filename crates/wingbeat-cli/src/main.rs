//! The program `wingbeat`: a thin face over the library.

mod args;
mod calibrate;
mod error;
mod fly;
mod interrupt;
mod manifest;
mod new;
mod outcome;
mod plan;
mod progress;
#[cfg(test)]
mod reference;
mod rig;
mod run_folder;
mod say;
mod show;
mod sweep;
mod tether;
mod time_left;
mod trim;
mod validate;
mod wake;

use std::process::ExitCode;

use clap::Parser;

use wingbeat::scenario::DocumentKind;

use args::{Arguments, Command};

/// Keeps what a decoder of another library says when it fails on a damaged file from the user: it becomes an error.
fn silence_decoders() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if std::thread::current().name() != Some(wingbeat_io::DECODER) {
            usual(panic);
        }
    }));
}

/// The JSON Schema of a kind of document as a file has it.
fn schema_text(kind: DocumentKind) -> String {
    format!("{:#}\n", kind.schema_of_files())
}

fn main() -> ExitCode {
    silence_decoders();
    let outcome = match Arguments::parse().command {
        Command::Fly(arguments) => fly::fly(&arguments),
        Command::Sweep(arguments) => sweep::sweep(&arguments),
        Command::Tether(arguments) => tether::tether(&arguments),
        Command::Wake(arguments) => wake::wake(&arguments),
        Command::Plan(arguments) => plan::plan(&arguments),
        Command::Calibrate(arguments) => calibrate::calibrate(&arguments),
        Command::Trim(arguments) => trim::trim(&arguments),
        Command::Rig(command) => rig::rig(&command),
        Command::Show(arguments) => show::show(&arguments),
        Command::Validate(arguments) => validate::validate(&arguments),
        Command::New(arguments) => new::new(&arguments),
        Command::Schema(arguments) => say::say(&schema_text(arguments.kind)),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            if !error.is_silent() {
                say::note(&format!("error: {error}"));
            }
            ExitCode::from(error.exit_code())
        }
    }
}
