//! The command line.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use wingbeat::scenario::DocumentKind;
use wingbeat_lattice::course::CourseRequest;

use crate::watch::WatchArguments;

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

/// Fly a scenario and write its run folder
///
/// The folder holds scenario.toml (as resolved), record.parquet, summary.json, manifest.json and figures, and
/// strips.parquet where the key flight.record_strips_every_s (s) asks for it: for every strip and instant its force
/// by source in body axes, angle of attack, width, point at 1/4 chord from the body origin, and circulation where the model
/// has one (preset paper, five lags of preset full; three lags give circulation_lag_sum). It appears when the run is
/// whole.
#[derive(Debug, Args)]
pub struct Fly {
    /// The scenario
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    #[command(flatten)]
    pub run: RunArguments,
    #[command(flatten)]
    pub page: Page,
    #[command(flatten)]
    pub live: WatchArguments,
}

/// Run a scenario or a case many times with keys drawn at random or from a grid, on all cores
///
/// The folder holds sweep.toml (as resolved), flights.csv (of a case runs.csv) and record.parquet (one row per run),
/// summary.json, manifest.json and a figure; of a case also its tables. An interrupted sweep goes on when the same
/// command is given again.
///
/// With `[search]` each candidate gives the keys of `draws` a value and is flown once for each of `flights`. Its cost is the sum of
/// (miss / `per`)^2 over all goals and flights; a flight that breaks down or is not resolved costs 1e6 or more. The search is separable
/// CMA-ES, a local evolution strategy (Ros & Hansen 2008); the same seed gives the same candidates. candidates.csv holds values, goals,
/// verdicts and cost of every candidate, best.toml the scenario of the best, for `fly`. It ends `ok` where one candidate meets all goals
/// and no verdict of its flights refuses them, else `not_found` with a warning `search.missed` for each that is missed.
#[derive(Debug, Args)]
pub struct SweepArguments {
    /// The sweep: scenario and what counts as held, or case; draws
    #[arg(value_name = "SWEEP.toml")]
    pub sweep: PathBuf,
    #[command(flatten)]
    pub run: RunArguments,
    #[command(flatten)]
    pub page: Page,
}

/// Move a wing as prescribed in a wind and write its loads
///
/// The folder holds case.toml (as resolved), loads.csv, strips.parquet, means.csv, summary.json, manifest.json and
/// figures; with --converge also converge.csv, with --compare compare.csv. It appears when the run is whole. What the
/// numbers mean: docs/tether.md.
#[derive(Debug, Args)]
pub struct TetherArguments {
    /// The case
    #[arg(value_name = "CASE.toml")]
    pub case: PathBuf,
    /// Also run it with three numbers of strips and three of steps (half, once and twice its own; a quarter, half and once where twice is not
    /// allowed), and with twice the elements of a spar, on all cores, and say whether its numbers converge
    #[arg(long)]
    pub converge: bool,
    /// Also compare the last cycle with a measured one: columns t (s) or phase (cycles) and channels, see
    /// `--set compare.channels.force_z=Fz`, `--set compare.by=phase` and `--set compare.frequency_hz=3.4`
    #[arg(long, value_name = "MEASURED.csv")]
    pub compare: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunArguments,
    #[command(flatten)]
    pub page: Page,
}

/// Step the vortex lattice of a wing in prescribed motion, or along a flight, and draw its wake
///
/// The folder holds case.toml or scenario.toml (as resolved), record.parquet (loads by Joukowski and by Bernoulli), summary.json,
/// manifest.json, a VTK file of wing and wake at the start and in the middle of down- and upstroke of the last cycle, and figures: the wake,
/// and the vorticity in a frontal plane at these phases. Of a flight with a turn there are two stretches, the last cycles before
/// the turn and the last of the flight. Attached flow is assumed without `--critical-suction`. More in docs/wake.md.
///
/// In summary.json, `circulation_error` is the largest circulation around a strip and its wake over that of the largest ring, zero
/// by Kelvin's theorem; `symmetry_error` is the largest difference between a ring and its mirror image over the largest ring, null
/// where the motion is not symmetric. `down_over_up` is the mean bound circulation by width, positive where it lifts the wing's
/// upper side, in the downstroke over that in the upstroke, of each half of the first surface: negative where one of them pushes down.
/// `left_over_right` is that of left and right. `wake_drag_n` is the drag by the wake
/// far behind (Trefftz plane) and `span_efficiency` that of the mean lift by it; both are null in unsteady flow, where the mean
/// bound circulation of a half changes by more than 0.02 of it within the last cycle (`unsteadiness`). `past_stall` is the share of
/// strips and time steps that the strip model has past its stall angle, and `strongest` the strongest ring at each phase drawn, and
/// when it was shed.
#[derive(Debug, Args)]
pub struct WakeArguments {
    /// The case, as `tether` takes it, or the run folder of `fly`
    #[arg(value_name = "CASE.toml|RUN")]
    pub case: PathBuf,
    /// Of a flight, the times at which the stretches end, s
    #[arg(long, value_name = "S,S", value_delimiter = ',')]
    pub at: Vec<f64>,
    /// Of a flight, cycles of a stretch, from rest; without it 3
    #[arg(long, value_name = "N")]
    pub cycles: Option<usize>,
    /// Of a flight, shed the circulations of the model that flew (preset paper, or full with five lags), not those of the lattice
    #[arg(long)]
    pub model: bool,
    /// Panels along the chord
    #[arg(long, value_name = "N", default_value_t = CourseRequest::default().chordwise)]
    pub chordwise: usize,
    /// Panels along the span
    #[arg(long, value_name = "N", default_value_t = CourseRequest::default().spanwise)]
    pub spanwise: usize,
    /// Steps per cycle; by default the wind moves by a panel's chord a step, 24 to 400 steps
    #[arg(long, value_name = "N")]
    pub steps: Option<usize>,
    /// Let the wind alone carry the wake
    #[arg(long)]
    pub prescribed: bool,
    /// Radius of the cores of the wake's vortices, mean chords; as wings feel them, at most a tenth of their way from the trailing edge
    #[arg(long, value_name = "SHARE", default_value_t = CourseRequest::default().core)]
    pub core: f64,
    /// Largest suction parameter of the leading edges (dimensionless, about 0.11 for flat plates): what is above is shed there;
    /// without it the flow stays attached
    #[arg(long, value_name = "A0")]
    pub critical_suction: Option<f64>,
    #[command(flatten)]
    pub run: RunArguments,
    #[command(flatten)]
    pub page: Page,
}

/// Plan offline: the quickest roll-in or reorientation, or the gait of least power for a mean force
///
/// The scenario's `[plan]` says which. The folder holds plan.parquet and plan.json: nodes, inputs and multipliers. That
/// of a roll-in also holds what `fly` writes, from the open-loop flight of the plan, and track.toml: the scenario with the
/// plan as the controller's reference, for `fly`. The folder of a gait also holds its cycle as simulated from rest on a
/// stand in the scenario's wind, figures, and tether.toml with joints.csv: the motion of the wing, for `tether`. Ctrl-C
/// keeps the best plan so far, which is not flown.
#[derive(Debug, Args)]
pub struct PlanArguments {
    /// The scenario
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    #[command(flatten)]
    pub run: RunArguments,
    #[command(flatten)]
    pub page: Page,
}

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

/// Find the periodic flight that a scenario's `[trim]` asks for, and its stability
///
/// The folder holds summary.json (frequency, power, stall shares, Floquet multipliers, or why there is no orbit),
/// record.parquet (one cycle), multipliers.parquet, family.parquet where `[trim.family]` asks for orbits along a parameter,
/// figures, gains.csv, the periodic linear-quadratic regulator that holds the orbit where one does, and orbit.toml: the scenario on its orbit,
/// for `fly`. Where `[trim.search]` asks for the gait that does something
/// best, starts.csv and starts.parquet have what each start came to, robot.toml is the best robot, and an interrupted search
/// goes on when the same command is given again. What the numbers mean: docs/trim.md.
///
/// Of a robot, scaling laws give the first speed (lift coefficient 0.6 of all surfaces as seen from above) and a frequency
/// (Pennycuick 1996, J. Exp. Biol. 199, 1613; area of the largest surface), which replaces the file's where that is not within 0.3
/// to 3 times it. At each of up to six speeds, steps of least norm bring the mean accelerations of the free body to zero, and
/// Newton's method finds the orbit. They change pitch, frequency and numbers of the file: means, amplitudes and phases of joints,
/// springs, settings of surfaces, and the centre of mass along the body. A gait search then takes the power down, within 200 W/kg,
/// three times the frequency of birds of that size, 45 deg of driven twist, 30 % of U^2 c dy beyond 20 deg, and a clearance of 5 %
/// of the span or 70 % of that at the start. Where it gets stuck beside gaits without an orbit, up to two other frequencies begin anew.
/// `--bank` flies level, into the turn and in it, with up to three speeds and weights, for 20 mm of height and 3 deg of mean roll.
#[derive(Debug, Args)]
pub struct Trim {
    /// The scenario; or a robot, which is trimmed from its file alone
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// Of a robot: also fly a turn of this bank, deg, about the gait that is found; positive is right wing down
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub bank: Option<f64>,
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

/// Draw a robot, a case, a rig or a run of the rig from its file, with frames, links, hinges, outlines, mount and arm
///
/// The folder holds figures/show.svg and .png, and manifest.json. FILE is a robot, a scenario (its robot at the start), a
/// case (its wing), a rig, or a run (its arm in the middle of the steady turn).
#[derive(Debug, Args)]
pub struct Show {
    /// Robot, scenario, case, rig or run
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// Phase of the gait of a robot, scenario or case, rad, where files of cases count cycles of 2 pi; without it that of the start
    #[arg(long, value_name = "RAD", allow_hyphen_values = true)]
    pub phase: Option<f64>,
    /// Joint positions of the arm, deg; without them those of the run's plan, else all zero
    #[arg(long, value_name = "J1,J2,...", value_delimiter = ',', allow_hyphen_values = true)]
    pub joints_deg: Option<Vec<f64>>,
    #[command(flatten)]
    pub run: RunArguments,
}

/// Draw the figures of the paper by our numbers, with one sheet of what it says and what came out here
///
/// Flies the banking turn and the turn on the paper's own joints, simulates and processes the seven runs of the rig, steps the wake
/// of the turn and draws set-up, arm, forces and moments, wake, states and path. The folder holds sheet.html with all of them inside,
/// figures, summary.json with every statement and its verdict, manifest.json, and the run folders turn, clear, rig and forces.
#[derive(Debug, Args)]
pub struct PaperArguments {
    /// The folder with the shipped scenarios, robots and rigs
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub from: PathBuf,
    /// Also draw every figure on a page of 16 to 9 for slides, into figures/wide
    #[arg(long)]
    pub wide: bool,
    /// Folder of the run; without it runs/paper, or runs/paper-2 and so on when that is taken
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the run that --out names, if nothing else lies there
    #[arg(long, requires = "out")]
    pub force: bool,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
}

/// Show runs on one page that moves, from their run folders
///
/// The page is one file that needs no network: the run in space, plots beside it, numbers and settings. Of several runs it shows all at
/// once. Without --out the page of one run becomes report.html in its folder, as every run writes it, and that of several runs
/// report.html in the present folder. More in docs/report.md.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// Run folders
    #[arg(value_name = "RUN", required = true)]
    pub runs: Vec<PathBuf>,
    /// The page; without it report.html in the folder of the run, or of several runs in the present folder
    #[arg(long, value_name = "PAGE.html")]
    pub out: Option<PathBuf>,
    /// Replace the file that --out or --sheet names
    #[arg(long)]
    pub force: bool,
    /// Draw the plots that the runs have in common over one another, in place of the page
    #[arg(long, value_name = "FILE.png|FILE.svg", conflicts_with_all = ["out", "no_wake", "no_strips"])]
    pub sheet: Option<PathBuf>,
    /// Leave the wake out
    #[arg(long)]
    pub no_wake: bool,
    /// Leave the forces of the strips out
    #[arg(long)]
    pub no_strips: bool,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
}

/// Write a run that moves in space as an animated PNG, or as a sequence of PNG files
///
/// Browsers and GitHub show an animated PNG as a picture that moves. It shows the whole path with the robot enlarged, and the robot near
/// by in a corner. Without --out the file is NAME.png in the present folder. More in docs/report.md.
#[derive(Debug, Args)]
pub struct Animate {
    /// The run folder
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// FILE.png for an animated PNG, else the folder of frame_0000.png and so on; without it NAME.png in the present folder
    #[arg(long, value_name = "FILE.png|DIR")]
    pub out: Option<PathBuf>,
    /// From where the run is seen
    #[arg(long, value_enum, default_value = "whole")]
    pub view: AnimatedView,
    /// Seconds of the run in a second
    #[arg(long, value_name = "X", default_value_t = 1.0, allow_negative_numbers = true)]
    pub speed: f64,
    /// Frames a second
    #[arg(long, value_name = "HZ", default_value_t = 20.0, allow_negative_numbers = true)]
    pub rate: f64,
    /// Width, px
    #[arg(long, value_name = "PX", default_value_t = 640, value_parser = clap::value_parser!(u32).range(160..=3840))]
    pub width: u32,
    /// A picture of 16:9 in place of 4:3
    #[arg(long)]
    pub wide: bool,
    /// Replace what --out names: the file, or the frames in the folder
    #[arg(long)]
    pub force: bool,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
}

/// From where an animation shows a run.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum AnimatedView {
    /// The whole path from behind, and the robot near by in a corner
    Whole,
    /// The robot near by, from behind
    Behind,
    /// The whole path from its right side
    Side,
    /// The whole path from above
    Above,
}

/// Write a run in the files of another program
///
/// Without --out the file is NAME.csv, NAME.npz, NAME.mat, NAME.glb or NAME.mcap, or the folder NAME-vtk, in the present folder; the
/// program prints which. More in docs/report.md.
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("format").required(true))]
pub struct Export {
    /// The run folder
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// The record as text with columns
    #[arg(long, group = "format")]
    pub csv: bool,
    /// The record for NumPy, an array for each column
    #[arg(long, group = "format")]
    pub npz: bool,
    /// The record for MATLAB, a variable for each column
    #[arg(long, group = "format")]
    pub mat: bool,
    /// Wings, forces and circulation frame by frame for VTK, ParaView and pyvista: a folder with a list of its files
    #[arg(long, group = "format")]
    pub vtk: bool,
    /// The robot with its animation as binary glTF, z up turned to y up
    #[arg(long, group = "format")]
    pub gltf: bool,
    /// A flight as MCAP for ROS 2, every message in CDR: transforms, robot description, joints, odometry, wrenches by source
    #[arg(long, group = "format")]
    pub mcap: bool,
    /// Where; without it NAME.csv, NAME.npz, NAME.mat, NAME.glb, NAME.mcap or the folder NAME-vtk in the present folder
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Replace the file, or the frames in the folder
    #[arg(long)]
    pub force: bool,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
}

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

/// Write a commented document that runs as it is, to begin from
///
/// The documents that it names are written beside it as robot.toml, scenario.toml, rig.toml, arm.toml or run.toml,
/// unless they are there already. Every key is in docs/reference.md.
#[derive(Debug, Args)]
pub struct New {
    /// What to write
    #[arg(value_parser = new_kind())]
    pub kind: NewKind,
    /// Where; without it KIND.toml in the present folder
    #[arg(value_name = "PATH")]
    pub path: Option<PathBuf>,
    /// Of a robot: the least that flies, in place of the robot of the paper
    #[arg(long, conflicts_with_all = ["robot", "case"])]
    pub minimal: bool,
    /// Of a scenario or a trim: for this robot, without controller
    #[arg(long, value_name = "ROBOT.toml", conflicts_with = "case")]
    pub robot: Option<PathBuf>,
    /// Of a calibration: from measurements of this case
    #[arg(long, value_name = "CASE.toml")]
    pub case: Option<PathBuf>,
    /// Replace the file at PATH; what is written beside it is never replaced
    #[arg(long)]
    pub force: bool,
}

/// Rewrite former names of keys in documents
///
/// `pitch_deg` becomes `nose_up_deg` with the sign turned, in draws and in overrides (`key=value`) too, and former names of
/// parameters become those of today. Comments, order and everything else are kept; what changes is printed.
#[derive(Debug, Args)]
pub struct Migrate {
    /// Documents: TOML files of any kind
    #[arg(value_name = "FILE.toml", required = true)]
    pub files: Vec<PathBuf>,
    /// Print what would change and write nothing
    #[arg(long)]
    pub dry_run: bool,
}

/// Print the JSON Schema of a kind of document
///
/// An editor that knows TOML completes, explains and checks a document whose first line is `#:schema FILE`. The same
/// schemas are in docs/schema.
#[derive(Debug, Args)]
pub struct Schema {
    /// The kind
    #[arg(value_parser = kind())]
    pub kind: DocumentKind,
}

/// What `new` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NewKind {
    /// A document of a kind.
    Document(DocumentKind),
    /// A scenario with `[trim]`.
    Trim,
    /// A sweep with `[search]`.
    Search,
}

fn new_kind() -> impl TypedValueParser<Value = NewKind> {
    let names = DocumentKind::ALL.map(DocumentKind::name).into_iter().chain(["trim", "search"]);
    PossibleValuesParser::new(names).map(|name| match (DocumentKind::named(&name), name.as_str()) {
        (Some(kind), _) => NewKind::Document(kind),
        (None, "search") => NewKind::Search,
        _ => NewKind::Trim,
    })
}

/// Kinds of documents by name.
fn kind() -> impl TypedValueParser<Value = DocumentKind> {
    let names = PossibleValuesParser::new(DocumentKind::ALL.map(DocumentKind::name));
    names.try_map(|name| DocumentKind::named(&name).ok_or("no such kind"))
}
