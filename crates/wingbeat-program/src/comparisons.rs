//! The command line of the comparisons, of `wingbeat validate` and of the program `wingbeat-validate`.

use std::path::PathBuf;

use clap::Args;

/// Compare the models with published or independent numbers
///
/// Prints id, source, metric, value, limit and verdict of every comparison. The exit code is 1 when one fails.
/// With --out the folder holds rows.json, rows.csv, summary.json, manifest.json, the figures of what was compared and,
/// when that is everything, the page validation.md.
#[derive(Debug, Args)]
pub struct Comparisons {
    /// Only this comparison, or all below this name: `aero` selects `aero.wagner_limit`
    #[arg(long, value_name = "ID")]
    pub only: Option<String>,
    /// Only comparisons that take seconds
    #[arg(long)]
    pub quick: bool,
    /// Also fits, Monte Carlo and the lattice along orbits, which take minutes each
    #[arg(long, conflicts_with = "quick")]
    pub long: bool,
    /// Write a folder of the results
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the run that --out names, if nothing else lies there
    #[arg(long, requires = "out")]
    pub force: bool,
    /// Also write the table as a JSON list of {id, source, metric, value, limit, pass}
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// No progress
    #[arg(long)]
    pub quiet: bool,
}
