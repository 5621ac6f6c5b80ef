//! The air the robot flies in: density, mean wind and gusts.

use crate::math::{Random, Scalar, Vec3};
use std::f64::consts::TAU;

/// The air.
#[derive(Clone, Debug, PartialEq)]
pub struct Air {
    /// Density, kg/m3.
    pub density: f64,
    /// Its motion.
    pub wind: Wind,
}

/// Velocity of the air over time, the same everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Wind {
    mean: Vec3,
    waves: Vec<Wave>,
    pulses: Vec<Pulse>,
}

/// One gust at a stated time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Begin, s.
    pub start: f64,
    /// From begin to end, s.
    pub duration: f64,
    /// Velocity in its middle, m/s in W.
    pub velocity: Vec3,
}

impl Pulse {
    /// Share of the velocity at the time `t`, and its rate, 1/s; zero before and after.
    ///
    /// Equation: robot.pulse
    fn share<S: Scalar>(&self, t: S) -> (S, S) {
        let since = t - self.start;
        let rate = TAU / self.duration;
        let (s, c) = (since * rate).sin_cos();
        let during = |x| {
            let begun = S::ZERO.if_below(since, x, S::ZERO);
            since.if_below(S::from(self.duration), begun, S::ZERO)
        };
        (during((-c + 1.0) * 0.5), during(s * (0.5 * rate)))
    }
}

/// One sinusoid of a gust: v_i = amplitude_i sin(rate t + phase_i).
#[derive(Clone, Debug, PartialEq)]
struct Wave {
    amplitude: f64,
    rate: f64,
    phase: [f64; 3],
}

/// Frequencies of a gust, Hz: slow against the flapping, so that the air may
/// count as uniform over the wing.
const GUST_FREQUENCIES: [f64; 6] = [0.2, 0.33, 0.54, 0.87, 1.4, 2.3];

impl Wind {
    /// Wind that does not change, m/s in W.
    pub fn steady(mean: Vec3) -> Self {
        Self { mean, waves: Vec::new(), pulses: Vec::new() }
    }

    /// Mean wind with a gust: along each axis a sum of sinusoids with random
    /// phases, amplitudes falling with the inverse of the frequency (a velocity
    /// spectrum of slope -2, Dryden's beyond its corner: MIL-F-8785C) and adding
    /// up to `peak`, m/s, so that no component ever exceeds it.
    pub fn gusty(mean: Vec3, peak: f64, seed: u64) -> Self {
        if peak == 0.0 {
            return Self::steady(mean);
        }
        let mut random = Random::new(seed);
        let total: f64 = GUST_FREQUENCIES.iter().map(|f| 1.0 / f).sum();
        let waves = GUST_FREQUENCIES
            .iter()
            .map(|f| Wave {
                amplitude: peak / (f * total),
                rate: TAU * f,
                phase: std::array::from_fn(|_| random.between(0.0, TAU)),
            })
            .collect();
        Self { mean, waves, pulses: Vec::new() }
    }

    /// This wind with gusts at stated times.
    #[must_use]
    pub fn with(mut self, pulses: impl IntoIterator<Item = Pulse>) -> Self {
        self.pulses.extend(pulses);
        self
    }

    /// The wind without its gust, m/s in W.
    pub fn mean(&self) -> Vec3 {
        self.mean
    }

    /// Velocity (m/s) and acceleration (m/s2) of the air in W at the time `t`, s.
    #[inline]
    pub fn at<S: Scalar>(&self, t: S) -> (Vec3<S>, Vec3<S>) {
        let (mut velocity, mut acceleration) = (Vec3::constant(self.mean), Vec3::ZERO);
        for wave in &self.waves {
            for i in 0..3 {
                let (s, c) = (t * wave.rate + wave.phase[i]).sin_cos();
                velocity[i] += s * wave.amplitude;
                acceleration[i] += c * (wave.amplitude * wave.rate);
            }
        }
        for pulse in &self.pulses {
            let (share, rate) = pulse.share(t);
            for i in 0..3 {
                velocity[i] += share * pulse.velocity[i];
                acceleration[i] += rate * pulse.velocity[i];
            }
        }
        (velocity, acceleration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Dual;

    #[test]
    fn a_gust_stays_below_its_peak_and_follows_its_seed() {
        let gust = Wind::gusty(Vec3::new(1.0, 0.0, 0.0), 0.3, 7);
        let largest = (0..20000)
            .map(|i| gust.at(i as f64 * 1e-3).0 - gust.mean())
            .fold(0.0, |m: f64, v| m.max(v[0].abs()).max(v[1].abs()).max(v[2].abs()));
        assert!(largest <= 0.3 && largest > 0.15, "peak {largest}");
        assert_eq!(gust, Wind::gusty(Vec3::new(1.0, 0.0, 0.0), 0.3, 7));
        assert_ne!(gust, Wind::gusty(Vec3::new(1.0, 0.0, 0.0), 0.3, 8));
    }

    const PULSE: Pulse = Pulse { start: 0.5, duration: 0.4, velocity: Vec3([0.0, -0.3, 0.6]) };

    #[test]
    fn the_acceleration_is_the_derivative() {
        for wind in [Wind::gusty(Vec3::ZERO, 0.2, 1), Wind::steady(Vec3::ZERO).with([PULSE])] {
            let (v, _) = wind.at(Dual::<1>::variable(0.62, 0));
            let (_, a) = wind.at(0.62);
            for i in 0..3 {
                assert!((v[i].eps[0] - a[i]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_pulse_has_its_velocity_in_its_middle_and_none_outside() {
        let mean = Vec3::new(1.0, 0.0, 0.0);
        let wind = Wind::steady(mean).with([PULSE]);
        let at = |t: f64| (wind.at(t).0 - mean).0;
        assert_eq!((at(0.5), at(0.9), at(3.0)), ([0.0; 3], [0.0; 3], [0.0; 3]));
        let [x, y, z] = at(0.7);
        assert!(x == 0.0 && (y + 0.3).abs() < 1e-15 && (z - 0.6).abs() < 1e-15);
        assert!((at(0.6)[2] - 0.3).abs() < 1e-15);
    }
}
