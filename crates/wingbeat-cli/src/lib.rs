//! The program `wingbeat`: a thin face over the library. It is a library of its own, so that it is compiled beside the crates that it
//! calls; a program waits for the last of them.

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

use args::CommandLine;

/// The schema of a kind of document, which `schema` prints.
fn schema(of: &args::Schema) -> Result<(), error::Error> {
    say::say(&schema_text(of.kind))
}

/// The JSON Schema of a kind of document as a file has it.
fn schema_text(kind: DocumentKind) -> String {
    format!("{:#}\n", kind.schema_of_files())
}

/// Declares the verbs: the words after each are its arguments and what it does with them.
macro_rules! verbs {
    ($($(#[$said:meta])* $verb:ident($arguments:path) => $does:path,)+) => {
        #[derive(Debug, clap::Subcommand)]
        pub(crate) enum ProgramCommand {
            $($(#[$said])* $verb($arguments),)+
        }

        impl ProgramCommand {
            /// Does what was asked.
            fn run(&self) -> Result<(), error::Error> {
                match self {
                    $(Self::$verb(arguments) => $does(arguments),)+
                }
            }
        }
    };
}

// A verb is a file of its own, its name among the modules above, and its line here.
verbs! {
    Fly(args::Fly) => fly::fly,
    Sweep(args::SweepArguments) => sweep::sweep,
    Tether(args::TetherArguments) => tether::tether,
    Wake(args::WakeArguments) => wake::wake,
    Plan(args::PlanArguments) => plan::plan,
    Calibrate(args::Calibrate) => calibrate::calibrate,
    Trim(args::Trim) => trim::trim,
    #[command(subcommand)]
    Rig(args::Rig) => rig::rig,
    Average(args::Average) => average::average,
    Paper(args::PaperArguments) => paper::paper,
    Show(args::Show) => show::show,
    Report(args::ReportArguments) => report::report,
    Animate(args::Animate) => animate::animate,
    Export(args::Export) => export::export,
    Validate(wingbeat_program::comparisons::Comparisons) => validate::validate,
    New(args::New) => new::new,
    Migrate(args::Migrate) => migrate::migrate,
    Schema(args::Schema) => schema,
}

/// Does what the command line asks; the exit code says how that ended.
pub fn main() -> ExitCode {
    wingbeat_program::run(|| CommandLine::parse().command.run())
}
