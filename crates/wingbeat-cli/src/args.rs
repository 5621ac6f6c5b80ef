//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

/// Simulation, calibration and control of dynamic-morphing flapping flight.
#[derive(Debug, Parser)]
#[command(name = "wingbeat", version, about, max_term_width = 100)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    Validate(Validate),
}

/// Compare the models with published or independent numbers.
///
/// Prints id, source, metric, value, limit and verdict of every comparison. The exit code is 1 when one fails.
#[derive(Debug, Args)]
pub struct Validate {
    /// Only this comparison, or all below this name: `aero` selects `aero.wagner_limit`
    #[arg(long, value_name = "ID")]
    pub only: Option<String>,
    /// Only comparisons that take seconds
    #[arg(long)]
    pub quick: bool,
    /// Also write the table as a JSON list of {id, source, metric, value, limit, pass}
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// No progress
    #[arg(long)]
    pub quiet: bool,
}
