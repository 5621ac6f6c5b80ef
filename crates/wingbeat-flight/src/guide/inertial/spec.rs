//! What `[controller.orbit.estimator]` says.

use super::BODY;
use crate::simulate::SensorSpec;
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};

/// An extended Kalman filter that makes of the readings of sensors the state that the controller feeds back: its
/// model is the nominal robot, with accelerations that the model misses as states of the filter. It starts at the orbit
/// of the begin.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct EstimatorSpec {
    /// Standard deviation of the start from the orbit, of the height, m.
    pub height_m: f64,
    /// The same of each velocity, m/s.
    pub velocity_m_s: f64,
    /// The same of the rotation about each axis, deg.
    pub angle_deg: f64,
    /// The same of each angular rate, rad/s.
    pub rate_rad_s: f64,
    /// Standard deviation of the acceleration that the model misses along each axis of B, m/s2.
    pub missed_m_s2: f64,
    /// The same of the angular acceleration, rad/s2.
    pub missed_rad_s2: f64,
    /// Time over which what is missed stays alike, s.
    pub missed_s: f64,
}

impl Default for EstimatorSpec {
    fn default() -> Self {
        Self {
            height_m: 0.003,
            velocity_m_s: 0.05,
            angle_deg: 1.0,
            rate_rad_s: 0.3,
            missed_m_s2: 1.0,
            missed_rad_s2: 30.0,
            missed_s: 0.1,
        }
    }
}

ranges!(EstimatorSpec {
    height_m: Range::POSITIVE,
    velocity_m_s: Range::POSITIVE,
    angle_deg: Range::POSITIVE,
    rate_rad_s: Range::POSITIVE,
    missed_m_s2: Range::POSITIVE,
    missed_rad_s2: Range::POSITIVE,
    missed_s: Range::POSITIVE,
});

impl EstimatorSpec {
    /// Standard deviations of the errors of the body at the start.
    pub(super) fn of_body(&self) -> [f64; BODY] {
        let mut deviations = [0.0; BODY];
        deviations[0] = self.height_m;
        deviations[1..4].fill(self.angle_deg.to_radians());
        deviations[4..7].fill(self.velocity_m_s);
        deviations[7..10].fill(self.rate_rad_s);
        deviations
    }

    /// Refuses numbers out of range, and an estimator without instruments. Whether they tell enough is found when it is built.
    pub fn check(&self, sensors: Option<&SensorSpec>) -> Result<(), Error> {
        self.in_range()?;
        match sensors.filter(|sensors| sensors.reads()) {
            Some(_) => Ok(()),
            None => {
                let tables = SensorSpec::INSTRUMENTS.iter().map(|name| format!("[sensors.{name}]"));
                let tables = tables.collect::<Vec<_>>().join(", ");
                Err(Error::invalid("", "given", format!("an estimator beside instruments: {tables}")))
            }
        }
    }
}
