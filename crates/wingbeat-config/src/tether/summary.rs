//! The numbers of a tethered run.

use super::{ClockSpec, StepChange, TetherCase};
use crate::hinged::FlapSummary;
use crate::skin::MembraneSummary;
use crate::{MeasuredComparison, Smoothed};
use serde::Serialize;
use wingbeat_flight::simulate::Ending;
use wingbeat_flight::tether::{CycleMean, Periodicity, Steady, TetherRun};
use wingbeat_judge::{Verdict, Warning};

/// The numbers of a tethered run.
#[derive(Clone, Debug, Serialize)]
pub struct TetherSummary {
    /// What the run is, what that rests on, and what to beware of.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// Name of the case.
    pub name: String,
    /// Aerodynamic preset.
    pub preset: &'static str,
    /// Lift law.
    pub lift_law: &'static str,
    /// Share of strips past the stall angle over the last cycle; this and all that follows is missing of a run that broke down.
    pub stall_fraction: Option<f64>,
    /// Mean separated share of the flow over the strips of the last cycle.
    pub separated_fraction: Option<f64>,
    /// Mean share of the linear leading-edge suction that law `lev` takes away, likewise.
    pub suction_lost_fraction: Option<f64>,
    /// Membrane: largest rise over the chord, slack share, frequency of the motion over its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub membrane: Option<MembraneSummary>,
    /// Flap: largest angle, and that by its weight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flap: Option<FlapSummary>,
    /// Largest change of a mean force or moment over the last cycle with half the steps per cycle, or where that is
    /// above 2 % with twice as many, over the range of the largest force or moment; NaN when that run fails.
    pub step_change: Option<f64>,
    /// The same of the least and the largest of a force or moment; compared with twice as many steps above 5 %.
    pub step_change_of_peaks: Option<f64>,
    /// The same of the mean power, over the mean of its size; compared with twice as many steps above 2 %.
    pub step_change_of_power: Option<f64>,
    /// Mean lift over the last cycle, N.
    pub mean_lift_n: Option<f64>,
    /// Mean force against the wind over the last cycle, N.
    pub mean_thrust_n: Option<f64>,
    /// Mean power that the motion gives to the air over the last cycle, W, with what it takes from the air: the net power.
    pub mean_power_w: Option<f64>,
    /// Mean of the positive part of that power, W: what a drive gives that takes nothing back.
    pub mean_positive_power_w: Option<f64>,
    /// Ratio of mean thrust times wind speed to mean power; negative where the wing drags.
    pub propulsive_efficiency: Option<f64>,
    /// How far the last cycle is from the one before; none of a single cycle.
    pub periodicity: Option<Periodicity>,
    /// Of a wing with spars.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spar: Option<SparSummary>,
    /// What fits of harmonics left of the tables.
    pub smoothed: Vec<Smoothed>,
    /// Means and ranges over the last cycle.
    pub cycle: Vec<CycleMean>,
}

/// The shape from which a wing with spars begins: at rest in the wind, body and hinges held as they are at the start.
#[derive(Clone, Debug, Serialize)]
pub struct SparSummary {
    /// Whether it was found; else the wing begins unbent.
    pub found: bool,
    /// Displacement of the tip up, m, in the axes of the spar's root.
    pub tip_up_m: f64,
    /// Displacement of the tip ahead, m.
    pub tip_ahead_m: f64,
    /// Twist of the tip, nose up, deg.
    pub tip_nose_up_deg: f64,
    /// Lowest frequencies of the unbent beam without air, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Growth rate, 1/s, of the small motion about it that decays least beside its angular frequency, or beside the lowest of the spar where
    /// that is larger, among those up to a reduced frequency of 2 or the third of the spar. Above `tether.growth_fraction` of that the wing flutters or diverges.
    pub growth_1_s: Option<f64>,
    /// Frequency of that motion, Hz; 0 of one that does not oscillate.
    pub frequency_hz: Option<f64>,
    /// Move of the tip with one more coefficient of the strains, over its displacement.
    pub grid_change: Option<f64>,
    /// Largest change of the three lowest frequencies with one more coefficient, over them.
    pub frequency_change: Option<f64>,
    /// The same of the lowest.
    pub lowest_frequency_change: Option<f64>,
}

impl SparSummary {
    /// Frequencies that are told.
    const TOLD: usize = 6;

    pub(super) fn of(steady: &Steady) -> Self {
        let [up, ahead, nose_up] = steady.tip;
        let [growth, omega] = steady.least_damped.map(|x| x.is_finite().then_some(x));
        Self {
            found: steady.found,
            tip_up_m: up,
            tip_ahead_m: ahead,
            tip_nose_up_deg: nose_up.to_degrees(),
            frequencies_hz: steady.frequencies_hz.iter().copied().take(Self::TOLD).collect(),
            growth_1_s: growth,
            frequency_hz: omega.map(|omega| omega / std::f64::consts::TAU),
            grid_change: steady.grid_change,
            frequency_change: steady.frequency_change.map(|[_, largest]| largest),
            lowest_frequency_change: steady.frequency_change.map(|[lowest, _]| lowest),
        }
    }

    /// Cautions: no shape, disturbances that grow about the start of a motion by more than `most` of their angular frequency, steps that
    /// miss the lowest frequency.
    pub(super) fn warnings(&self, clock: &ClockSpec, still: bool, most: f64) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if !self.found {
            let text = "no shape at rest in the wind was found, so that the wing begins unbent in still air";
            warnings.push(Warning::new("tether.spar_shape", text).key("wind.speed_m_s"));
        }
        if self.found && !still && self.growth_1_s.is_none() {
            let text = "no growth of small disturbances of the wing at rest in the wind was found: it may flutter or diverge";
            warnings.push(Warning::new("tether.flutter", text).key("wind.speed_m_s"));
        }
        if let (Some(growth), Some(frequency)) = (self.growth_1_s, self.frequency_hz)
            && let Some(lowest) = self.frequencies_hz.first()
            && growth > most * std::f64::consts::TAU * frequency.max(*lowest)
            && !still
        {
            let what = if frequency > 0.0 { "flutters" } else { "diverges" };
            let text = format!(
                "small disturbances of the wing at rest in the wind grow by {growth:.3} 1/s at {frequency:.3} Hz: it {what}"
            );
            warnings.push(Warning::new("tether.flutter", text).size(growth).key("wind.speed_m_s"));
        }
        let rate = clock.frequency_hz * clock.steps_per_cycle as f64;
        if let Some(lowest) = self.frequencies_hz.first()
            && rate < STEPS_PER_PERIOD * lowest
        {
            let text = format!(
                "the wing's lowest frequency of {lowest:.2} Hz has {:.1} steps per period; its oscillations need {STEPS_PER_PERIOD}",
                rate / lowest
            );
            warnings.push(
                Warning::new("tether.spar_steps", text).size(rate / lowest).key("time.steps_per_cycle"),
            );
        }
        warnings
    }
}

/// Steps per period of the lowest frequency of a spar below which there is a caution: the implicit steps are stable at any length,
/// and of third order. *Choice.*
const STEPS_PER_PERIOD: f64 = 12.0;

impl TetherCase {
    /// The numbers of a run, with warnings; `step_change` says by what share they depend on the steps, and `compared` what was
    /// found of a measurement.
    pub fn summary(
        &self,
        run: &TetherRun,
        step_change: Option<StepChange>,
        compared: Option<&MeasuredComparison>,
    ) -> TetherSummary {
        let law = self.tether.aero.law();
        // Of a run that broke down there is no last cycle to take means of.
        let complete = run.ending == Ending::Complete;
        let whole = |value: Option<f64>| value.filter(|_| complete);
        TetherSummary {
            verdict: self.verdict(run, step_change, compared),
            name: self.spec.name.clone(),
            preset: self.spec.aero.preset.name(),
            lift_law: law.name(),
            stall_fraction: whole(Some(run.stalled.stalled())),
            step_change: step_change.map(|change| change.mean),
            step_change_of_peaks: step_change.map(|change| change.peak),
            step_change_of_power: step_change.map(|change| change.power),
            separated_fraction: whole(Some(run.separated_fraction)),
            suction_lost_fraction: whole(Some(run.suction_lost_fraction)),
            membrane: self.skin(run),
            flap: self.hinged(run),
            mean_lift_n: whole(run.mean("force_wind_lift")),
            mean_thrust_n: whole(run.mean("thrust")),
            mean_power_w: whole(run.mean("power")),
            mean_positive_power_w: whole(run.mean_positive_power()),
            propulsive_efficiency: whole(run.efficiency),
            periodicity: run.periodicity.clone().filter(|_| complete),
            spar: run.steady.as_ref().map(SparSummary::of),
            smoothed: self.smoothed.clone(),
            cycle: if complete { run.means.clone() } else { Vec::new() },
        }
    }

    /// The membrane over the last cycle; none of a wing without one, or of a run that broke down.
    pub(super) fn skin(&self, run: &TetherRun) -> Option<MembraneSummary> {
        let (clock, strips) = (self.tether.clock, self.tether.aero.strips());
        let (camber, forward) = (run.strips.values("camber")?, run.strips.values("camber_forward")?);
        let heights = camber.iter().zip(forward).map(|(a, b)| [*a, *b]);
        let first = heights.len().saturating_sub(clock.steps_per_cycle * strips);
        let skin = MembraneSummary::of(&self.tether.aero, heights.skip(first), clock.frequency_hz);
        skin.filter(|_| run.ending == Ending::Complete)
    }

    /// The flap over the last cycle, likewise.
    pub(super) fn hinged(&self, run: &TetherRun) -> Option<FlapSummary> {
        let last = self.tether.clock.steps_per_cycle * self.tether.aero.strips();
        let angles = run.strips.values("flap")?;
        let first = angles.len().saturating_sub(last);
        let flap = FlapSummary::tethered(&self.tether.aero, angles[first..].iter().copied());
        flap.filter(|_| run.ending == Ending::Complete)
    }
}
