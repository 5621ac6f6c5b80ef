//! What the controller is told of the state: which channels, how noisy, how late.

use super::fitted::Fitted;
use super::{Reading, SensorSpec};
use crate::simulate::record::Column;
use std::collections::VecDeque;
use wingbeat_math::{Quat, Random, Vec3};
use wingbeat_ocp::plant::{Channel, Fault, Plant, Role};
use wingbeat_robot::Robot;

/// What a controller is told: channels of the plant's state as measured.
#[derive(Clone, Copy, Debug)]
pub struct Measurement<'a> {
    taken: f64,
    channels: &'a [Channel],
    values: &'a [f64],
    readings: &'a [Reading],
}

impl<'a> Measurement<'a> {
    /// `values` of `channels`, taken at the time `taken`, s.
    ///
    /// # Panics
    /// When there is not one value per channel.
    pub fn new(taken: f64, channels: &'a [Channel], values: &'a [f64]) -> Self {
        assert_eq!(channels.len(), values.len(), "one value per channel");
        Self { taken, channels, values, readings: &[] }
    }

    /// What instruments have told at the time `t`, s, and no state.
    pub fn of_instruments(t: f64, readings: &'a [Reading]) -> Self {
        Self { taken: t, channels: &[], values: &[], readings }
    }

    /// What has arrived of instruments since the last update, in the order in which it was read.
    pub fn readings(&self) -> &'a [Reading] {
        self.readings
    }

    /// Time at which it was taken, s: older than the update by the delay of the sensors.
    pub fn taken(&self) -> f64 {
        self.taken
    }
    /// The channels measured, in the order of the state.
    pub fn channels(&self) -> &'a [Channel] {
        self.channels
    }
    /// One value per channel, in its unit.
    pub fn values(&self) -> &'a [f64] {
        self.values
    }
    /// The value of the channel of this role, in its unit, if it is measured.
    pub fn value(&self, role: Role) -> Option<f64> {
        role.place(self.channels).map(|i| self.values[i])
    }
    /// Three components, if they are measured, in the unit of their channels: `vector(Role::AngularRate)`.
    pub fn vector(&self, role: fn(usize) -> Role) -> Option<Vec3> {
        Some(Vec3::new(self.value(role(0))?, self.value(role(1))?, self.value(role(2))?))
    }
    /// q_WB, if it is measured.
    pub fn attitude(&self) -> Option<Quat> {
        let first = Role::Attitude(0).place(self.channels)?;
        self.values.get(first..first + 4).map(Quat::from_wxyz)
    }
}

/// The sensors of a plant.
#[derive(Debug)]
pub struct Sensors {
    /// States measured, by number, and their channels.
    seen: Vec<usize>,
    channels: Vec<Channel>,
    noise: Option<Noise>,
    delay: usize,
    /// Measurements on their way with the times at which they were taken, oldest first.
    waiting: VecDeque<(f64, Vec<f64>)>,
    scratch: Vec<f64>,
    fitted: Option<Fitted>,
    told: Vec<Reading>,
    /// What the record of a flight shows of them.
    shown: Vec<f64>,
}

/// White noise on the state.
#[derive(Debug)]
struct Noise {
    deviation: Vec<f64>,
    attitude: Option<usize>,
    attitude_deviation: f64,
    random: Random,
}

impl Noise {
    fn add(&mut self, x: &mut [f64]) {
        let attitude = self.attitude.map(|a| (a, Quat::from_wxyz(&x[a..])));
        for (m, deviation) in x.iter_mut().zip(&self.deviation) {
            *m += deviation * self.random.normal();
        }
        if let Some((a, q)) = attitude {
            let turn = Vec3([(); 3].map(|()| self.random.normal()));
            (q * Quat::exp(turn * self.attitude_deviation)).normalized().store_wxyz(&mut x[a..]);
        }
    }
}

impl Sensors {
    /// Tells every state of `plant` as it is, the air's included, at once: what no instrument does.
    pub fn perfect<P: Plant>(plant: &P) -> Self {
        Self {
            seen: (0..plant.states().len()).collect(),
            channels: plant.states().to_vec(),
            noise: None,
            delay: 0,
            waiting: VecDeque::new(),
            scratch: Vec::new(),
            fitted: None,
            told: Vec::new(),
            shown: Vec::new(),
        }
    }

    /// The sensors of `robot` that `spec` says, on a flight in steps of `step` s; noise and offsets follow `seed`.
    pub fn of(robot: &Robot, spec: &SensorSpec, step: f64, seed: u64) -> Self {
        let wind = robot.wind_over_time().clone();
        let fitted = Fitted::new(spec.named_instruments(), robot.states(), wind, step, seed);
        Self { fitted: fitted.filter(|_| spec.reads()), ..Self::noisy(robot, spec, seed) }
    }

    /// Lets instruments read that are due at step `k`: `plant` in the state `x` under the inputs `u` now in force.
    pub(in crate::simulate) fn watch<P: Plant>(
        &mut self,
        k: usize,
        plant: &P,
        t: f64,
        x: &[f64],
        u: &[f64],
    ) -> Result<(), Fault> {
        self.fitted.as_mut().map_or(Ok(()), |fitted| fitted.watch(k, plant, t, x, u))
    }

    /// Columns of what the sensors read, as the record of a flight has them: of each instrument the newest reading that has
    /// arrived; without instruments, of a controller that is `updated`, what it was last told of each state that has noise or
    /// comes late.
    pub fn columns(&self, updated: bool) -> Vec<Column> {
        match &self.fitted {
            Some(fitted) => return fitted.columns().to_vec(),
            None if !updated => return Vec::new(),
            None => {}
        }
        let of = |i: usize| {
            let Channel { name, unit, frame, .. } = &self.channels[i];
            Column::new(format!("reading_{name}"), *unit, *frame)
        };
        self.off_truth().map(of).collect()
    }

    /// Numbers of [`columns`](Self::columns) at the time `t`, s, in their units; none before anything was measured.
    pub(in crate::simulate) fn shown(&mut self, t: f64) -> &[f64] {
        let mut shown = std::mem::take(&mut self.shown);
        shown.clear();
        match (&mut self.fitted, self.waiting.front()) {
            (Some(fitted), _) => fitted.held(t, &mut shown),
            (None, Some((_, values))) => shown.extend(self.off_truth().map(|i| values[i])),
            (None, None) => {}
        }
        self.shown = shown;
        &self.shown
    }

    /// Numbers of the measured channels of body and structure that are told with noise or late.
    fn off_truth(&self) -> impl Iterator<Item = usize> + '_ {
        let noisy = move |i: usize, role: Role| {
            let noise = self.noise.as_ref();
            noise.is_some_and(|noise| match role {
                Role::Attitude(_) => noise.attitude_deviation > 0.0,
                _ => noise.deviation[self.seen[i]] > 0.0,
            })
        };
        let sensed = |role: Role| {
            use Role::{AngularRate, Attitude, Displacement, Position, Velocity};
            matches!(role, Position(_) | Attitude(_) | Velocity(_) | AngularRate(_) | Displacement(_))
        };
        let roles = self.channels.iter().map(|channel| channel.role).enumerate();
        roles.filter(move |&(i, role)| sensed(role) && (self.delay > 0 || noisy(i, role))).map(|(i, _)| i)
    }

    /// Tells every state of `plant` with the noise and delay of `spec`; the noise follows `seed`.
    pub fn noisy<P: Plant>(plant: &P, spec: &SensorSpec, seed: u64) -> Self {
        let noise = Noise {
            deviation: plant.states().iter().map(|channel| spec.deviation(channel)).collect(),
            attitude: plant.attitude(),
            attitude_deviation: spec.attitude_deg.to_radians(),
            random: Random::new(seed),
        };
        Self {
            noise: Some(noise),
            delay: spec.delay_updates,
            waiting: VecDeque::with_capacity(spec.delay_updates + 1),
            ..Self::perfect(plant)
        }
    }

    /// The same sensors without those of the channels that `sees` denies: an inertial unit is
    /// `|role| matches!(role, Role::Attitude(_) | Role::AngularRate(_))`.
    #[must_use]
    pub fn only(mut self, sees: impl Fn(Role) -> bool) -> Self {
        let kept = |(_, channel): &(usize, Channel)| sees(channel.role);
        (self.seen, self.channels) = self.seen.into_iter().zip(self.channels).filter(kept).unzip();
        self
    }

    /// Measures the state `x` at `t` (s) and tells the newest measurement that has arrived;
    /// until one is old enough, the oldest serves.
    pub fn measure(&mut self, t: f64, x: &[f64]) -> Measurement<'_> {
        if let Some(fitted) = &mut self.fitted {
            fitted.tell(t, &mut self.told);
            return Measurement::of_instruments(t, &self.told);
        }
        let arrived = if self.waiting.len() > self.delay { self.waiting.pop_front() } else { None };
        let (_, mut values) = arrived.unwrap_or_default();
        self.scratch.clear();
        self.scratch.extend_from_slice(x);
        if let Some(noise) = &mut self.noise {
            noise.add(&mut self.scratch);
        }
        values.clear();
        values.extend(self.seen.iter().map(|&i| self.scratch[i]));
        self.waiting.push_back((t, values));
        let (taken, values) = &self.waiting[0];
        Measurement::new(*taken, &self.channels, values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_math::Scalar;
    use wingbeat_ocp::plant::Fault;

    struct Line([Channel; 2]);

    impl Plant for Line {
        fn states(&self) -> &[Channel] {
            &self.0
        }
        fn inputs(&self) -> &[Channel] {
            &[]
        }
        fn rates<S: Scalar>(&self, _: S, _: &[S], _: &[S], _: &mut [S]) -> Result<(), Fault> {
            Ok(())
        }
    }

    fn line() -> Line {
        let speed = Channel::free("a name of its own", "m/s", "W").of(Role::Velocity(0));
        Line([Channel::free("lag", "m/s", "").of(Role::Air), speed])
    }

    fn heard(spec: &SensorSpec, updates: usize) -> Vec<(f64, f64)> {
        let mut sensors = Sensors::noisy(&line(), spec, 3);
        let hear = |i: usize| {
            let measurement = sensors.measure(i as f64, &[7.0, i as f64]);
            assert_eq!(measurement.value(Role::Air), Some(7.0));
            (measurement.taken(), measurement.value(Role::Velocity(0)).unwrap())
        };
        (0..updates).map(hear).collect()
    }

    #[test]
    fn a_delay_is_whole_updates() {
        let spec = SensorSpec { delay_updates: 2, ..Default::default() };
        let twice = |v: f64| (v, v);
        assert_eq!(heard(&spec, 5), [0.0, 0.0, 0.0, 1.0, 2.0].map(twice));
        assert_eq!(heard(&SensorSpec::default(), 3), [0.0, 1.0, 2.0].map(twice));
    }

    #[test]
    fn noise_has_its_deviation() {
        let spec = SensorSpec { velocity_m_s: 0.1, ..Default::default() };
        let errors: Vec<f64> = heard(&spec, 4000).iter().map(|(t, x)| x - t).collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        assert!((rms - 0.1).abs() < 0.005, "rms {rms}");
    }

    #[test]
    fn what_is_not_sensed_is_not_told() {
        let mut sensors = Sensors::perfect(&line()).only(|role| role != Role::Air);
        let measurement = sensors.measure(0.5, &[7.0, 2.0]);
        assert_eq!((measurement.values(), measurement.value(Role::Air)), ([2.0].as_slice(), None));
        assert_eq!((measurement.vector(Role::Velocity), measurement.attitude()), (None, None));
    }
}
