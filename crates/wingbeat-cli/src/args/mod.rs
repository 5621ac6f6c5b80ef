//! The command line.

mod documents;
mod flights;
mod measured;
mod pictures;

pub use documents::*;
pub use flights::*;
pub use measured::*;
pub use pictures::*;

use std::path::PathBuf;

use clap::{Args, Parser};

/// Simulation, calibration and control of dynamic-morphing flapping flight.
#[derive(Debug, Parser)]
#[command(name = "wingbeat", version, about, max_term_width = 100, after_help = EXIT_CODES)]
pub struct CommandLine {
    #[command(subcommand)]
    pub command: crate::ProgramCommand,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 a comparison failed; 2 bad input; 3 a limit is missed, nothing is found or data are suspect, \
its folder is kept and its summary.json says why; 130 interrupted, nothing is kept but what the same command goes on \
from. Where runs lie and what is replaced: docs/runs.md.";

/// What commands take whose run folder has a page.
#[derive(Debug, Args)]
pub struct Page {
    /// Write no report.html
    #[arg(long)]
    pub no_report: bool,
}

/// What all commands that make a run folder take.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// Folder of the run; without it runs/NAME, or runs/NAME-2 and so on when that is taken
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the run that --out names, if nothing else lies there
    #[arg(long, requires = "out")]
    pub force: bool,
    /// Override a key, e.g. `--set robot.body.mass_kg=0.012`, an item of a list by its name or number; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Seed of everything random, in place of the file's key `seed`
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
}

impl RunArguments {
    /// The overrides, with the seed as one of them.
    pub fn all_overrides(&self) -> Vec<String> {
        let seed = self.seed.map(|seed| format!("seed={seed}"));
        self.overrides.iter().cloned().chain(seed).collect()
    }
}
