//! The program `wingbeat`: a thin face over the library.

mod args;
mod error;
mod fly;
mod interrupt;
mod manifest;
mod outcome;
mod plan;
mod progress;
#[cfg(test)]
mod reference;
mod rig;
mod run_folder;
mod say;
mod sweep;
mod tether;
mod validate;

use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, Command};

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Fly(arguments) => fly::fly(&arguments),
        Command::Sweep(arguments) => sweep::sweep(&arguments),
        Command::Tether(arguments) => tether::tether(&arguments),
        Command::Plan(arguments) => plan::plan(&arguments),
        Command::Rig(command) => rig::rig(&command),
        Command::Validate(arguments) => validate::validate(&arguments),
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
