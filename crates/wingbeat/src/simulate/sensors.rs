//! What the controller is told of the state: noise and delay.

use super::fly::{Controller, Update};
use super::record::Column;
use crate::Error;
use crate::math::{Quat, Random, Vec3};
use crate::plant::Plant;
use crate::require;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Standard deviations of white noise per measurement, and the delay of the
/// measurement chain. States not named here are known exactly.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorSpec {
    /// Position, m.
    pub position_m: f64,
    /// Attitude, deg about each body axis.
    pub attitude_deg: f64,
    /// Velocity, m/s.
    pub velocity_m_s: f64,
    /// Angular rate, rad/s.
    pub rate_rad_s: f64,
    /// Displacements of the structure, in their own unit.
    pub displacement: f64,
    /// Age of the newest measurement in whole controller updates.
    pub delay_updates: usize,
}

impl SensorSpec {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        let levels = [
            ("position_m", self.position_m),
            ("attitude_deg", self.attitude_deg),
            ("velocity_m_s", self.velocity_m_s),
            ("rate_rad_s", self.rate_rad_s),
            ("displacement", self.displacement),
        ];
        levels.iter().try_for_each(|(key, value)| require::not_negative(key, *value))
    }
}

/// A controller behind sensors.
#[derive(Debug)]
pub struct Sensed<C: Controller> {
    inner: C,
    deviation: Vec<f64>,
    attitude: Option<usize>,
    attitude_deviation: f64,
    waiting: VecDeque<Vec<f64>>,
    delay: usize,
    random: Random,
}

impl<C: Controller> Sensed<C> {
    /// Puts sensors between `plant` and `inner`; the noise follows `seed`.
    pub fn new<P: Plant>(inner: C, plant: &P, spec: &SensorSpec, seed: u64) -> Self {
        let deviation = |name: &str| match name {
            n if n.starts_with("p_WB") => spec.position_m,
            n if n.starts_with("v_WB_W") => spec.velocity_m_s,
            n if n.starts_with("w_WB_B") => spec.rate_rad_s,
            n if n.starts_with("displacement_") => spec.displacement,
            _ => 0.0,
        };
        Self {
            inner,
            deviation: plant.states().iter().map(|c| deviation(&c.name)).collect(),
            attitude: plant.attitude(),
            attitude_deviation: spec.attitude_deg.to_radians(),
            waiting: VecDeque::with_capacity(spec.delay_updates + 1),
            delay: spec.delay_updates,
            random: Random::new(seed),
        }
    }

    /// The state with noise, in the storage of `measured`.
    fn measure(&mut self, x: &[f64], measured: &mut Vec<f64>) {
        measured.clear();
        measured.extend_from_slice(x);
        for (m, deviation) in measured.iter_mut().zip(&self.deviation) {
            *m += deviation * self.random.normal();
        }
        if let Some(a) = self.attitude {
            let turn = Vec3([(); 3].map(|()| self.random.normal()));
            let attitude = Quat::from_wxyz(&x[a..]) * Quat::exp(turn * self.attitude_deviation);
            attitude.normalized().store_wxyz(&mut measured[a..]);
        }
    }
}

impl<C: Controller> Controller for Sensed<C> {
    fn update(&mut self, t: f64, x: &[f64]) -> Update {
        // Until the first measurement is old enough, the oldest one serves.
        let mut newest =
            if self.waiting.len() > self.delay { self.waiting.pop_front() } else { None }.unwrap_or_default();
        self.measure(x, &mut newest);
        self.waiting.push_back(newest);
        self.inner.update(t, &self.waiting[0])
    }
    fn input(&self, t: f64, u: &mut [f64]) {
        self.inner.input(t, u);
    }
    fn columns(&self) -> Vec<Column> {
        self.inner.columns()
    }
    fn diagnostics(&self, row: &mut Vec<f64>) {
        self.inner.diagnostics(row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keeps what it is told.
    struct Listener(Vec<f64>);
    impl Controller for Listener {
        fn update(&mut self, _: f64, x: &[f64]) -> Update {
            self.0 = x.to_vec();
            Update::Fresh
        }
        fn input(&self, _: f64, u: &mut [f64]) {
            u.fill(self.0[0]);
        }
    }

    struct Line([crate::plant::Channel; 1]);
    impl Plant for Line {
        fn states(&self) -> &[crate::plant::Channel] {
            &self.0
        }
        fn inputs(&self) -> &[crate::plant::Channel] {
            &[]
        }
        fn rates<S: crate::math::Scalar>(
            &self,
            _: S,
            _: &[S],
            _: &[S],
            _: &mut [S],
        ) -> Result<(), crate::plant::Fault> {
            Ok(())
        }
    }

    fn heard(spec: &SensorSpec, updates: usize) -> Vec<f64> {
        let plant = Line([crate::plant::Channel::free("v_WB_W_x", "m/s", "W")]);
        let mut sensed = Sensed::new(Listener(vec![0.0]), &plant, spec, 3);
        let hear = |i: usize| {
            sensed.update(0.0, &[i as f64]);
            sensed.inner.0[0]
        };
        (0..updates).map(hear).collect()
    }

    #[test]
    fn a_delay_is_whole_updates() {
        let spec = SensorSpec { delay_updates: 2, ..Default::default() };
        assert_eq!(heard(&spec, 5), [0.0, 0.0, 0.0, 1.0, 2.0]);
        assert_eq!(heard(&SensorSpec::default(), 3), [0.0, 1.0, 2.0]);
    }

    #[test]
    fn noise_has_its_deviation() {
        let spec = SensorSpec { velocity_m_s: 0.1, ..Default::default() };
        let errors: Vec<f64> = heard(&spec, 4000).iter().enumerate().map(|(i, x)| x - i as f64).collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        assert!((rms - 0.1).abs() < 0.005, "rms {rms}");
    }
}
