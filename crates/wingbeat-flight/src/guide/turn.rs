//! The shipped manoeuvre: a level approach and a turn at constant bank, or a planned way into it.

use super::manoeuvre::{Manoeuvre, Reference};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::interpolation::piecewise_linear;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Vec3, pitch_of_nose_up};

/// A level approach, then a turn at constant bank.
#[derive(Clone, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// Start of the turn, s.
    #[serde(default)]
    pub turn_start_s: f64,
    /// Bank in the turn, deg; positive is right wing down.
    #[serde(default)]
    pub roll_deg: f64,
    /// Pitch throughout, deg; positive is nose up.
    #[serde(default)]
    pub nose_up_deg: f64,
    /// Heading rate in the turn, rad/s; negative turns right.
    #[serde(default)]
    pub yaw_rate_rad_s: f64,
    /// A planned way into the turn; while it lasts it is the reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub track: Option<Track>,
}

ranges!(Turn {
    turn_start_s: Range::NOT_NEGATIVE,
    roll_deg: Range::between(-180.0, 180.0),
    nose_up_deg: Range::between(-90.0, 90.0),
});

/// Attitude and angular rate at ascending times, linear in between.
#[derive(Clone, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Track {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Roll, rad.
    pub roll_rad: Vec<f64>,
    /// Pitch, rad.
    pub pitch_rad: Vec<f64>,
    /// Angular rate w_WB_B, rad/s.
    pub rate_rad_s: Vec<[f64; 3]>,
}

/// Refuses times `time_s` that do not ascend, and less than two.
pub(super) fn ascending(times: &[f64]) -> Result<(), Error> {
    let count = times.len();
    if count < 2 {
        return Err(Error::invalid("time_s", format!("{count} times"), "two or more"));
    }
    let Some(i) = (1..count).find(|&i| !(times[i - 1] < times[i])) else { return Ok(()) };
    let [before, this] = [i - 1, i].map(|i| format!("time_s[{i}]"));
    Err(Error::invalid(this, times[i], "more than the one before").against([before]))
}

impl Track {
    /// Checks that the times ascend and that every series has as many values.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        ascending(&self.time_s)?;
        let count = self.time_s.len();
        let series = [
            ("roll_rad", self.roll_rad.len()),
            ("pitch_rad", self.pitch_rad.len()),
            ("rate_rad_s", self.rate_rad_s.len()),
        ];
        match series.into_iter().find(|(_, n)| *n != count) {
            Some((key, n)) => {
                Err(Error::invalid(key, format!("{n} values"), format!("{count}, one per time")))
            }
            None => Ok(()),
        }
    }

    /// The reference at `t`; none outside the track.
    fn reference(&self, t: f64) -> Option<Reference> {
        let last = self.time_s.len() - 1;
        if t < self.time_s[0] || t > self.time_s[last] {
            return None;
        }
        let at = |values: &[f64]| piecewise_linear(&self.time_s, values, t);
        let k = self.time_s.partition_point(|&v| v <= t).clamp(1, last);
        let share = (t - self.time_s[k - 1]) / (self.time_s[k] - self.time_s[k - 1]);
        let (a, b) = (Vec3(self.rate_rad_s[k - 1]), Vec3(self.rate_rad_s[k]));
        Some(Reference { roll: at(&self.roll_rad), pitch: at(&self.pitch_rad), w: a + (b - a) * share })
    }
}

impl Manoeuvre for Turn {
    fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        self.track.as_ref().map_or(Ok(()), |track| track.check().map_err(|e| e.within("track")))
    }

    fn begins(&self) -> Vec<(String, f64)> {
        let turns = self.roll_deg != 0.0 || self.yaw_rate_rad_s != 0.0;
        turns.then(|| ("turn_start_s".to_owned(), self.turn_start_s)).into_iter().collect()
    }

    /// Within the turn the body rates are those of a steady turn,
    /// w = psi' (-sin theta, cos theta sin phi, cos theta cos phi).
    fn reference(&self, t: f64) -> Reference {
        if let Some(reference) = self.track.as_ref().and_then(|track| track.reference(t)) {
            return reference;
        }
        let turning = t >= self.turn_start_s;
        let (roll, yaw_rate) =
            if turning { (self.roll_deg.to_radians(), self.yaw_rate_rad_s) } else { (0.0, 0.0) };
        let pitch = pitch_of_nose_up(self.nose_up_deg);
        let ((sp, cp), (sr, cr)) = (pitch.sin_cos(), roll.sin_cos());
        Reference { roll, pitch, w: Vec3::new(-sp, cp * sr, cp * cr) * yaw_rate }
    }
}
