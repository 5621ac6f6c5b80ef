//! What commands take that look at measured loads, and those of the rig, which measure them.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::{Page, RunArguments};
use crate::watch::WatchArguments;

/// Fit parameters of robot and rig to measured loads, with their standard errors
///
/// First prints which run tells of which parameter, and refuses what the runs cannot identify. The folder holds
/// calibration.toml (as resolved), numbers.toml (the result, for `--set robot.numbers=FILE` of `fly`, `--set
/// rig.robot.numbers=FILE` of `rig`), residual.toml where runs with `residual = true` tell what the fitted model leaves of their loads (for
/// `robot.residual`, beside the numbers), report.md, summary.json, information.csv, record.parquet (measured and predicted cycles
/// with their bands), manifest.json and figures. An interrupted calibration goes on when the same command is given again.
/// What the numbers mean: docs/calibration.md.
#[derive(Debug, Args)]
pub struct Calibrate {
    /// The calibration
    #[arg(value_name = "CALIBRATION.toml")]
    pub calibration: PathBuf,
    /// Only print what the runs can identify
    #[arg(long, conflicts_with = "watch")]
    pub information: bool,
    /// Only list the parameters that can be fitted, with the model's values
    #[arg(long, conflicts_with_all = ["information", "watch"])]
    pub names: bool,
    #[command(flatten)]
    pub run: RunArguments,
    #[command(flatten)]
    pub page: Page,
    #[command(flatten)]
    pub live: WatchArguments,
}

/// Average measured loads over the cycles of the wings, from a file of the load cell alone
///
/// The folder holds cycles.csv (phase, and for each channel its mean and standard deviation over the cycles), summary.json,
/// manifest.json and a figure with every channel. The frequency comes from the data. No robot, rig or arm is needed;
/// `rig process` also takes weight and inertia away. More in docs/average.md.
///
/// A line of a channel's spectrum (Hann's window, without the straight trend) must have 36 times the power of the noise beside it
/// (`data.line_over_noise`) and stand above what larger lines leak there. The strongest, `strongest_line_hz`, has the largest share
/// of the power of all channels. It is taken as the harmonic k of the frequency, at most the sixth, if other lines lie at multiples
/// of its k-th part that are coprime to k: the first, or two of them. Least squares of four harmonics give the frequency of each
/// channel; the result is their weighted mean.
#[derive(Debug, Args)]
pub struct Average {
    /// The samples: text with columns and a header, or six columns without one, or any file that `rig process` reads
    #[arg(value_name = "FILE.csv")]
    pub file: PathBuf,
    /// Samples per second, Hz; without it the file has a column t (s)
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub rate: Option<f64>,
    /// Units: of forces and of moments, or one for each channel, e.g. `--units N,"N m"`; without it those of the file
    #[arg(long, value_name = "UNIT,UNIT", value_delimiter = ',')]
    pub units: Vec<String>,
    /// Channels to average; without it all columns but time, status and sequence
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    pub columns: Vec<String>,
    /// Frequency of the cycle, Hz, in place of the one that the data have
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub frequency: Option<f64>,
    /// Seconds of rest at the start of the file: what the channels read there is subtracted, and they are left out
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub rest: Option<f64>,
    /// Phases of the average
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub bins: usize,
    /// Folder of the run; without it runs/NAME, or runs/NAME-2 and so on when that is taken
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the run that --out names, if nothing else lies there
    #[arg(long, requires = "out")]
    pub force: bool,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
}

/// Plan, simulate, record and process runs on the test rig
#[derive(Debug, Subcommand)]
pub enum Rig {
    Plan(RigPlan),
    /// Simulate runs: the carried robot, the arm's motion, the load cell
    Simulate(RigSimulate),
    Process(RigProcess),
    Record(RigRecord),
    Emulate(RigEmulate),
}

/// Place banking turns in the arm's workspace and write its trajectories
///
/// The folder holds for each run NAME.txt (the report), NAME.toml (as resolved), and the joint motion at 1 kHz as
/// NAME.csv (Kortex), NAME.yaml (ROS 2) and NAME.json (Kinova Web App); with --from-deg also NAME_approach in the
/// same formats.
#[derive(Debug, Args)]
pub struct RigPlan {
    #[command(flatten)]
    pub runs: RigRuns,
    /// Present joint positions, deg: also plan the way from there to the start of each run, straight in joint space
    /// and in least time
    #[arg(long, value_name = "J1,J2,...", value_delimiter = ',', allow_hyphen_values = true)]
    pub from_deg: Option<Vec<f64>>,
    #[command(flatten)]
    pub page: Page,
}

/// A run on the rig, or a list of runs
#[derive(Debug, Args)]
pub struct RigSimulate {
    #[command(flatten)]
    pub runs: RigRuns,
    #[command(flatten)]
    pub page: Page,
}

/// A run on the rig, or a list of runs
#[derive(Debug, Args)]
pub struct RigRuns {
    /// The run, or a file with `runs = ["a.toml", ...]`
    #[arg(value_name = "RUN.toml")]
    pub file: PathBuf,
    #[command(flatten)]
    pub run: RunArguments,
}

/// Correct, filter and phase-average recorded runs, and draw forces and moments
///
/// The folder of results holds averages (NAME.parquet), envelope.parquet, summary.json with every step in words,
/// manifest.json and figures. Runs of static tilts give mass, centre and offsets instead. Files: Parquet, MATLAB 4, 5
/// and 7.3, NumPy npz and npy, HDF5, MCAP of ROS 2, text with columns, text of ATI's demo application; what they do
/// not say is set: `--set process.input.rate_hz=7000`, `--set process.input.columns.Fz=NAME`, `--set
/// process.input.units.force=N`, `--set process.input.start_s=4`, `--set process.phase=force`.
///
/// At most 4096 columns with together 2^26 numbers are read, and the last line of a text ends with a line break. Where several
/// columns could be a channel, `process.input.columns` must name one; a unit by key that contradicts the file is refused. Of ATI's
/// application whole numbers are counts and numbers with a point units; samples are placed by the RDT sequence and sample rate,
/// because the time in the file is the host's, to a second.
#[derive(Debug, Args)]
pub struct RigProcess {
    /// A folder of `rig simulate` or `rig record`, a folder of such folders, or a file of samples
    #[arg(value_name = "PATH")]
    pub path: PathBuf,
    /// The run that was measured; needed where no scenario.toml lies beside the samples
    #[arg(long, value_name = "RUN.toml")]
    pub run: Option<PathBuf>,
    /// Folder of the results; without it PATH/processed, or FILE-processed beside a file,
    /// with -2 and so on when that is taken
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the results that --out names, if nothing else lies there
    #[arg(long, requires = "out")]
    pub force: bool,
    /// Override a key of every run, e.g. `--set process.steps.tare=false`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
    #[command(flatten)]
    pub page: Page,
}

/// Record from a Net F/T box without losing a sample silently
///
/// Scale factors come from the box. The folder holds record.parquet with raw counts and newtons, the raw logs,
/// report.txt, summary.json and manifest.json; it appears when the recording is whole. A recording that was killed
/// or ran out of disk goes on when the same command is given again. Exit code 3: the box was silent at the end, or
/// the records, those booked as missing included, are not as many as the box's rate makes in the time by the clock
/// (those of a twentieth of the time, of 0.1 to 0.5 s, and 1 % may differ, and the rate itself by 10 %).
#[derive(Debug, Args)]
pub struct RigRecord {
    /// Address of the box
    #[arg(value_name = "ADDRESS")]
    pub address: std::net::IpAddr,
    /// Added to the box's ports 49152 and 80
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = offset())]
    pub port_offset: u16,
    /// Seconds to record from now on, also where a recording goes on; without it until Ctrl-C
    #[arg(long, value_name = "S")]
    pub duration: Option<f64>,
    /// Take the load at the start as zero
    #[arg(long)]
    pub bias: bool,
    /// Several records per datagram
    #[arg(long)]
    pub buffered: bool,
    /// Stop at the first stall instead of asking again
    #[arg(long)]
    pub fail_stop: bool,
    /// Rows of one raw log before the next is begun; 0 for one log
    #[arg(long, value_name = "ROWS", default_value_t = 0)]
    pub rotate: u64,
    /// Flapping frequency for the live phase average of Fz, Hz
    #[arg(long, value_name = "HZ", default_value_t = 3.5)]
    pub frequency: f64,
    /// Folder of the recording
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Replace the recording that --out names, if nothing else lies there
    #[arg(long)]
    pub force: bool,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
}

/// Emulate a Net F/T box, faults included
#[derive(Debug, Args)]
pub struct RigEmulate {
    /// Address to listen on
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    pub bind: std::net::IpAddr,
    /// Added to the ports 49152 and 80
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = offset())]
    pub port_offset: u16,
    /// A record with columns Fx .. Tz at 7 kHz to play, instead of a flapping robot
    #[arg(long, value_name = "RECORD.parquet")]
    pub play: Option<PathBuf>,
    /// Share of datagrams not sent
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub drop: f64,
    /// Share of datagrams sent twice
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub duplicate: f64,
    /// Share of datagrams sent late
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub reorder: f64,
    /// Share of datagrams delayed by 20 ms
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub delay: f64,
    /// Share of datagrams followed by random bytes
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub garbage: f64,
    /// Share of records marked saturated
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub saturation: f64,
    /// Share of records marked with a warning
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub warning: f64,
    /// Share of records marked with a serious error
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub serious: f64,
    /// Stall after this many records of a stream; 0 never
    #[arg(long, value_name = "RECORDS", default_value_t = 0)]
    pub stall_after: u64,
    /// Restart the box after this many records of a stream: deaf for 1 s, counts from 0; 0 never
    #[arg(long, value_name = "RECORDS", default_value_t = 0)]
    pub restart_after: u64,
    /// Number from which the box counts its samples after a restart
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub restart_at: u32,
    /// Send nothing any more after this many records of a stream; 0 never
    #[arg(long, value_name = "RECORDS", default_value_t = 0)]
    pub die_after: u64,
    /// Let the numbers leap ahead after this many records of a stream; 0 never
    #[arg(long, value_name = "RECORDS", default_value_t = 0)]
    pub jump_after: u64,
    /// Share of records made of those that the stated rate says; 0 all
    #[arg(long, value_name = "SHARE", default_value_t = 1.0)]
    pub pace: f64,
    /// Number before the first record of a stream and of the box's own count, to see numbers wrap
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub sequence: u32,
    /// How records are numbered
    #[arg(long, value_name = "HOW", value_enum, default_value = "counted")]
    pub numbers: EmulatedNumbers,
    /// What records say of the loads
    #[arg(long, value_name = "WHAT", value_enum, default_value = "measured")]
    pub loads: EmulatedLoads,
    /// Seed of the faults
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
}

/// How an emulated box numbers its records.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum EmulatedNumbers {
    /// As the box does
    Counted,
    /// At random
    Random,
    /// Backward, samples too
    Backward,
    /// Always the same, samples too
    Frozen,
    /// With the same number of the sample
    FrozenSamples,
}

/// What an emulated box says of the loads.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum EmulatedLoads {
    /// What the cell feels
    Measured,
    /// Zero
    Zero,
    /// Fz as it was at the start
    StuckFz,
    /// All as they were at the start
    Frozen,
}

/// What may be added to the box's ports.
fn offset() -> clap::builder::RangedI64ValueParser<u16> {
    clap::value_parser!(u16).range(..=i64::from(wingbeat_netft::LARGEST_OFFSET))
}
