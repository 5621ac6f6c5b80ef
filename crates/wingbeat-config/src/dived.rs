//! What a dive took.

use super::flight_verdict::velocity_at;
use super::summary::mean;
use super::told_errors::{TrueErrors, Updates};
use serde::Serialize;
use wingbeat_flight::simulate::Record;
use wingbeat_judge::limits::flight;
use wingbeat_judge::{Judge, Status};
use wingbeat_math::{GRAVITY, Vec3};

/// Angle of the path over a cycle at which it counts as level, deg. *Choice*: gusts of 0.3 m/s turn it by as much.
const LEVEL_DEG: f64 = 4.0;
/// Cycles for which it must be level at the end of the flight. *Choice.*
const LEVEL_CYCLES: f64 = 4.0;

/// A dive of `[controller.orbit.dive]` from the first instant of its plan on.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct DiveSummary {
    /// Mean height over the cycle before it less the least height in it and after it, m.
    pub height_lost_m: f64,
    /// The same over the velocity head v^2/(2 g) at the mean airspeed over that cycle.
    pub velocity_heads: f64,
    /// Share of its cost that the last iteration of the plan saved.
    pub plan_saved_fraction: f64,
    /// Largest pitch, deg; nose down is positive.
    pub nose_down_deg: f64,
    /// Largest mean pitch over a cycle of the gait, deg.
    pub nose_down_cycle_deg: f64,
    /// Steepest path over a cycle, deg below the horizon.
    pub path_down_deg: f64,
    /// Time from its begin until the path is level in every cycle to the end of the flight, s; none where it never is.
    pub level_after_s: Option<f64>,
    /// Largest difference of the pitch from the plan until it ends, at the updates of the controller, deg.
    pub pitch_error_deg: f64,
}

impl DiveSummary {
    /// Of a record whose gait has cycles of `cycle` s; none without a dive, or where the flight ends within two cycles of its begin.
    /// `wind` is the mean velocity of the air, m/s.
    pub(super) fn new(record: &Record, cycle: f64, wind: Vec3, updates: Updates) -> Option<Self> {
        let column = |name: &str| record.values(name);
        let (t, dived) = (column("t")?, column("orbit_dive")?);
        let [x, y, z] = ["x", "y", "z"].map(|axis| column(&format!("p_WB_{axis}")));
        let (x, y, z, pitch) = (x?, y?, z?, column("pitch")?);
        let first = dived.iter().position(|share| *share > 0.0)?;
        let at = |time: f64| t.partition_point(|t| *t < time - 1e-9);
        let last = at(t[t.len() - 1] - cycle);
        if first >= last {
            return None;
        }
        let begin = t[first];
        let path = |row: usize| {
            let end = at(t[row] + cycle).min(t.len() - 1);
            (z[row] - z[end]).atan2((x[end] - x[row]).hypot(y[end] - y[row])).to_degrees()
        };
        let paths: Vec<f64> = (first..last).map(path).collect();
        let steep = paths.iter().rposition(|down| down.abs() > LEVEL_DEG);
        let flat = steep.map_or(first, |row| first + row + 1);
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NEG_INFINITY, f64::max);
        let over = |row: usize| mean(&pitch[row..at(t[row] + cycle)]).unwrap_or(f64::NAN).to_degrees();
        let level = at(begin - cycle)..=first;
        let speeds: Option<Vec<f64>> =
            level.clone().map(|row| Some((velocity_at(record, row)? - wind).norm())).collect();
        let head = mean(&speeds?)?.powi(2) / (2.0 * GRAVITY);
        let height_lost_m = mean(&z[level])? - z[first..].iter().copied().fold(f64::INFINITY, f64::min);
        let planned = first..first + dived[first..].partition_point(|share| *share < 1.0);
        let errors = TrueErrors::new(record, planned, updates).angle("pitch")?;
        Some(Self {
            height_lost_m,
            velocity_heads: height_lost_m / head,
            plan_saved_fraction: column("orbit_dive_saved")?[first],
            nose_down_deg: largest(&mut pitch[first..].iter().copied()).to_degrees(),
            nose_down_cycle_deg: largest(&mut (first..last).map(over)),
            path_down_deg: largest(&mut paths.iter().copied()),
            level_after_s: (flat < at(t[t.len() - 1] - LEVEL_CYCLES * cycle)).then(|| t[flat] - begin),
            pitch_error_deg: largest(&mut errors.iter().map(|e| e.abs())).to_degrees(),
        })
    }

    pub(super) fn judge(&self, judge: &mut Judge) {
        judge.hold(&flight::DIVE_HEIGHT, self.velocity_heads);
        judge.hold(&flight::DIVE_PLAN, self.plan_saved_fraction);
        judge.hold(&flight::DIVE_PITCH, self.pitch_error_deg);
        if self.level_after_s.is_none() {
            judge.find(
                Status::OffTarget,
                "the path is not level over the last four cycles of the flight after the dive",
            );
        }
    }
}
