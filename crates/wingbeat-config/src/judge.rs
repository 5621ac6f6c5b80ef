//! What a flight's goal asks, and whether it was met.

use super::spec::GoalSpec;
use super::summary::Summary;
use wingbeat_flight::simulate::Record;
use wingbeat_math::Vec3;

/// What was judged and how.
#[derive(Debug, Default)]
pub struct Verdict {
    /// Keys of the goal that were judged.
    pub judged: Vec<&'static str>,
    /// Keys that could not be.
    pub not_judged: Vec<&'static str>,
    /// Why not, the last of several reasons.
    pub why: Option<&'static str>,
    /// What was missed, in words.
    pub missed: Vec<String>,
}

impl Verdict {
    /// Judges the flight that `record` and `summary` tell of by `goal`; roll and pitch only where there is a
    /// `reference` to hold.
    pub fn new(summary: &Summary, record: &Record, goal: &GoalSpec, reference: bool) -> Self {
        let mut verdict = Self::default();
        let t = record.values("t").unwrap_or_default();
        let first = t.partition_point(|&t| t < goal.settle_s);
        let unsettled = "the flight ended before the goal's settling time";
        let (held, why) = match reference {
            true => (Some(summary), unsettled),
            false => (None, "without [manoeuvre] there is no reference to hold"),
        };
        let angle = |rms: Option<f64>, name: &'static str, within: f64| {
            rms.map(|rms| at_most(name, rms, within, "deg"))
        };
        let roll = held.and_then(|s| angle(s.roll_rms_error_deg, "rms error of roll", goal.roll_within_deg));
        let pitch =
            held.and_then(|s| angle(s.pitch_rms_error_deg, "rms error of pitch", goal.pitch_within_deg));
        verdict.take("goal.roll_within_deg", roll, why);
        verdict.take("goal.pitch_within_deg", pitch, why);
        if let Some(within) = goal.altitude_within_m {
            let z = record.values("p_WB_z").unwrap_or_default();
            let start = z.first().copied().unwrap_or(0.0);
            let change = z.iter().skip(first).map(|z| (z - start).abs()).reduce(f64::max);
            verdict.take(
                "goal.altitude_within_m",
                change.map(|c| at_most("change of altitude", c, within, "m")),
                unsettled,
            );
        }
        if let Some([low, high]) = goal.speed_between_m_s {
            let mean = speed(record, first);
            let judged = mean
                .map(|v| at_least("mean speed", v, low, "m/s").and(at_most("mean speed", v, high, "m/s")));
            verdict.take("goal.speed_between_m_s", judged, unsettled);
        }
        if let Some(least) = goal.clearance_m {
            let judged = summary.least_clearance_m.map(|c| at_least("least clearance", c, least, "m"));
            verdict.take("goal.clearance_m", judged, "the robot has no clearances");
        }
        verdict
    }

    /// Takes in how `key` was judged, or why it was not.
    fn take(&mut self, key: &'static str, outcome: Option<Result<(), Missed>>, why: &'static str) {
        match outcome {
            None => {
                self.not_judged.push(key);
                self.why = Some(why);
            }
            Some(outcome) => {
                self.judged.push(key);
                self.missed.extend(outcome.err().map(Missed::words));
            }
        }
    }
}

/// What is off, its value, what is allowed, the unit.
#[derive(Clone, Copy)]
struct Missed(&'static str, f64, f64, &'static str);

impl Missed {
    fn words(self) -> String {
        let Self(name, value, allowed, unit) = self;
        format!("{name} {value:.2} {unit}, allowed is {allowed} {unit}")
    }
}

fn at_most(name: &'static str, value: f64, allowed: f64, unit: &'static str) -> Result<(), Missed> {
    if value <= allowed { Ok(()) } else { Err(Missed(name, value, allowed, unit)) }
}

fn at_least(name: &'static str, value: f64, allowed: f64, unit: &'static str) -> Result<(), Missed> {
    if value >= allowed { Ok(()) } else { Err(Missed(name, value, allowed, unit)) }
}

/// Mean magnitude of the velocity from the row `first` on, m/s.
fn speed(record: &Record, first: usize) -> Option<f64> {
    let axes = ["x", "y", "z"].map(|axis| record.values(&format!("v_WB_W_{axis}")));
    let [Some(x), Some(y), Some(z)] = axes else { return None };
    let speeds: Vec<f64> = (first..x.len()).map(|row| Vec3::new(x[row], y[row], z[row]).norm()).collect();
    (!speeds.is_empty()).then(|| speeds.iter().sum::<f64>() / speeds.len() as f64)
}
