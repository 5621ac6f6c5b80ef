//! What commands take that compute flights and wings.

use std::path::PathBuf;

use clap::Args;
use wingbeat_lattice::course::CourseRequest;

use super::{Page, RunArguments};
use crate::watch::WatchArguments;

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
/// bound circulation of a half changes by more than 0.02 of it within the last cycle (`unsteadiness`). `cycle_change_fraction` is the
/// change of the mean force by Joukowski from the last cycle but one, over its root mean square. `past_stall` is the share of
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
