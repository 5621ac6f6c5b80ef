//! How much the loads of a tethered wing depend on its steps.

use super::TetherCase;
use wingbeat_flight::simulate::Ending;
use wingbeat_flight::tether::{CycleMean, Tether, TetherRun};
use wingbeat_judge::Warning;

/// Loads over those of the dynamic pressure on the wing below which they are rounding. *Choice.*
const ROUNDED: f64 = 1e-9;

/// Change of the means with other steps above which there is a caution. *Choice.*
pub(super) const STEP_CHANGE: f64 = 0.02;
/// The same of the least and the largest loads: 25 times what the shipped cases reach. *Choice.*
const PEAK_CHANGE: f64 = 0.05;

/// How much the loads of the last cycle depend on the steps: the largest change with other steps, forces and moments each over the
/// largest of their kind; NaN when the other run fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepChange {
    /// Of a mean, dimensionless.
    pub mean: f64,
    /// Of a least or largest value, dimensionless.
    pub peak: f64,
    /// Of the mean power, over the mean of its size, dimensionless.
    pub power: f64,
}

impl TetherCase {
    /// How much the loads of `run` depend on its steps: their relative change against the run with half the steps per
    /// cycle and, where that is large, against the one with twice as many, which tells whether this one or that coarse one is
    /// at fault. None for a run that did not end. `simulate` makes the other runs.
    ///
    /// # Errors
    /// Those of `simulate`.
    pub fn step_change<E>(
        &self,
        run: &TetherRun,
        mut simulate: impl FnMut(&Tether) -> Result<TetherRun, E>,
    ) -> Result<Option<StepChange>, E> {
        if !matches!(run.ending, Ending::Complete) {
            return Ok(None);
        }
        let steps = self.tether.clock.steps_per_cycle;
        let scales = self.tether.reference;
        let force = ROUNDED * 0.5 * scales.density_kg_m3 * scales.speed_m_s.powi(2) * scales.area_m2;
        let least = [force, force * scales.chord_m];
        let mut against = |steps| {
            let other = simulate(&self.tether.stepped(steps))?;
            let power = power_change(run, &other, force * scales.speed_m_s);
            Ok(StepChange { power, ..change(&run.means, &other.means, least) })
        };
        let coarse = against((steps / 2).max(2))?;
        let most = [STEP_CHANGE, PEAK_CHANGE, STEP_CHANGE];
        let parts = |of: StepChange| [of.mean, of.peak, of.power];
        let holds: [bool; 3] = std::array::from_fn(|k| parts(coarse)[k] <= most[k]);
        if holds == [true; 3] || self.tether.stepped(2 * steps).check().is_err() {
            return Ok(Some(coarse));
        }
        let fine = against(2 * steps)?;
        let [mean, peak, power] = std::array::from_fn(|k| parts(if holds[k] { coarse } else { fine })[k]);
        Ok(Some(StepChange { mean, peak, power }))
    }

    /// The cautions that the steps are too long for the means and for the peaks.
    pub(super) fn coarse(&self, change: StepChange) -> impl Iterator<Item = Warning> {
        let steps = self.spec.time.steps_per_cycle;
        let means = ("tether.steps", "mean loads", change.mean, STEP_CHANGE);
        let peaks = ("tether.steps_of_peaks", "least and largest loads", change.peak, PEAK_CHANGE);
        let power = ("tether.steps_of_power", "mean power", change.power, STEP_CHANGE);
        [means, peaks, power].into_iter().filter(|(_, _, change, most)| !(change <= most)).map(
            move |(name, loads, change, _)| {
                let by = percent(change);
                let text = match name {
                    "tether.steps_of_power" => format!(
                        "with other steps than time.steps_per_cycle = {steps} the {loads} changes by {by} of the mean of its size: \
                         take more steps per cycle"
                    ),
                    _ => format!(
                        "with other steps than time.steps_per_cycle = {steps} the {loads} change by {by} of their range: take \
                         more steps per cycle"
                    ),
                };
                Warning::new(name, text).size(change).key("time.steps_per_cycle")
            },
        )
    }
}

/// A share in per cent, with as many digits as say something.
fn percent(share: f64) -> String {
    match 100.0 * share.abs() {
        size if !size.is_finite() => "more than can be told".to_owned(),
        size if size >= 1e4 => format!("{size:.1e} %"),
        size if size >= 10.0 => format!("{size:.0} %"),
        size => format!("{size:.1} %"),
    }
}

/// The change of the mean power over the last cycle between two runs, over the mean of its size in the one where that is smaller; below
/// `least`, W, it is rounding.
fn power_change(one: &TetherRun, other: &TetherRun, least: f64) -> f64 {
    let mean = |run: &TetherRun| run.mean("power").unwrap_or(f64::NAN);
    let size = |run: &TetherRun| {
        let power = run.last_cycle("power").unwrap_or_default();
        power.iter().map(|power| power.abs()).sum::<f64>() / power.len() as f64
    };
    let scale = size(one).min(size(other));
    match mean(one) - mean(other) {
        apart if !apart.is_finite() => f64::NAN,
        apart if scale > least => apart.abs() / scale,
        _ => 0.0,
    }
}

/// The largest relative changes of the loads between two runs, forces and moments each by the largest of their kind, in the run
/// where that is smaller: the other may have grown without bound. Loads below `least`, N and N m, are rounding; of power nothing is said.
pub fn change(one: &[CycleMean], other: &[CycleMean], least: [f64; 2]) -> StepChange {
    let of = |kind: &str, least: f64, apart: fn(&CycleMean, &CycleMean) -> f64| {
        let rows = |means: &[CycleMean]| -> Vec<CycleMean> {
            means.iter().filter(|row| row.name.starts_with(kind)).cloned().collect()
        };
        let (one, other) = (rows(one), rows(other));
        let largest =
            |rows: &[CycleMean]| rows.iter().map(|r| r.low.abs().max(r.high.abs())).fold(0.0, f64::max);
        let scale = largest(&one).min(largest(&other));
        let apart: Vec<f64> = one.iter().zip(&other).map(|(a, b)| apart(a, b)).collect();
        match apart.iter().any(|apart| apart.is_nan()) {
            true => f64::NAN,
            false if scale > least => apart.into_iter().fold(0.0, f64::max) / scale,
            false => 0.0,
        }
    };
    let both = |apart: fn(&CycleMean, &CycleMean) -> f64| {
        let (force, moment) = (of("force_wind_", least[0], apart), of("moment_", least[1], apart));
        if force.is_nan() || moment.is_nan() { f64::NAN } else { force.max(moment) }
    };
    let mean = both(|a, b| (a.mean - b.mean).abs());
    // A value that is not a number must not be lost.
    let peak = both(|a, b| {
        let [low, high] = [(a.low - b.low).abs(), (a.high - b.high).abs()];
        if low.is_nan() || high.is_nan() { f64::NAN } else { low.max(high) }
    });
    StepChange { mean, peak, power: 0.0 }
}
