//! How a bench runs beside what its files say: crank, encoder, arm, unrest of the loads.

use super::JointTrajectory;
use std::f64::consts::TAU;
use wingbeat_math::{Jet, Random, Scalar};

/// First-order noise of six channels, each of deviation 1, that forgets itself over a time.
#[derive(Clone, Debug)]
pub struct Unrest {
    keep: f64,
    state: [f64; 6],
}

impl Unrest {
    /// Noise in steps of `step` s that forgets itself over `time` s; it begins at zero.
    pub fn new(step: f64, time: f64) -> Self {
        Self { keep: (-step / time).exp(), state: [0.0; 6] }
    }

    /// The next step, each channel in standard deviations.
    pub fn next(&mut self, random: &mut Random) -> [f64; 6] {
        let kick = (1.0 - self.keep * self.keep).sqrt();
        for channel in &mut self.state {
            *channel = self.keep * *channel + kick * random.normal();
        }
        self.state
    }
}

/// Rms of each channel about its mean, in the unit of the channel.
pub fn rms_about_mean(rows: &[[f64; 6]]) -> [f64; 6] {
    let count = rows.len().max(1) as f64;
    std::array::from_fn(|i| {
        let mean = rows.iter().map(|row| row[i]).sum::<f64>() / count;
        (rows.iter().map(|row| (row[i] - mean).powi(2)).sum::<f64>() / count).sqrt()
    })
}

/// A sine: amplitude, rate in rad/s, phase in rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sinusoid {
    /// Amplitude, in the unit of what it moves.
    pub amplitude: f64,
    /// Rate, rad/s.
    pub rate: f64,
    /// Phase, rad.
    pub phase: f64,
}

impl Sinusoid {
    /// Its value at the time `t` (s), in the unit of its amplitude, with the rates of that.
    pub fn at(&self, t: Jet) -> Jet {
        (t * self.rate + self.phase).sin() * self.amplitude
    }
}

/// What of one run differs from what its files say. The default differs in nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BenchDeviations {
    /// How far the crank runs ahead of its even clock, s: slow waves make one cycle longer than another.
    pub pace: Vec<Sinusoid>,
    /// By how much the encoder shows more than the phase, rad.
    pub encoder_rad: f64,
    /// Deviation of loads that differ from instant to instant, by channel, N and N m.
    pub unrest: [f64; 6],
    /// Time over which they forget themselves, s.
    pub unrest_time_s: f64,
}

/// Rates of the waves of the pace, in parts of the flapping frequency: none repeats within a few cycles. *Choice.*
const PACES: [f64; 3] = [0.13, 0.29, 0.47];

impl BenchDeviations {
    /// Waves by which the rate of a crank at `frequency` Hz differs by `share` rms, of drawn phases.
    pub fn paces(share: f64, frequency: f64, random: &mut Random) -> Vec<Sinusoid> {
        let size = share * (2.0 / PACES.len() as f64).sqrt();
        let wave = |part: &f64| {
            let rate = TAU * frequency * part;
            Sinusoid { amplitude: size / rate, rate, phase: random.between(0.0, TAU) }
        };
        PACES.iter().map(wave).collect()
    }

    /// The gait's clock, s, with the pace of the crank; it begins with the even one.
    pub fn clock(&self, even: Jet) -> Jet {
        let ahead = |wave: &Sinusoid| wave.at(even) + -wave.at(Jet::default()).x;
        self.pace.iter().fold(even, |clock, wave| clock + ahead(wave))
    }

    /// Whether loads differ from instant to instant.
    pub fn is_restless(&self) -> bool {
        self.unrest.iter().any(|channel| *channel > 0.0)
    }
}

impl JointTrajectory {
    /// The motion as an arm makes it that lags by `lag` s and whose joints err by a wave each, which vanishes at both ends.
    pub fn tracked(&self, lag: f64, errors: &[Sinusoid]) -> Self {
        let rows = self.len() + (lag / self.step).ceil() as usize;
        let duration = (rows.max(2) - 1) as f64 * self.step;
        let mut made = Self { joints: self.joints.clone(), step: self.step, ..Self::default() };
        for row in 0..rows {
            let t = Jet::new(row as f64 * self.step, 1.0, 0.0);
            let swell = ((t * (TAU / duration)).cos() * -0.5) + 0.5;
            let asked = self.at(t.x - lag);
            let joints: Vec<Jet> = (0..self.joints.len())
                .map(|j| errors.get(j).map_or(asked[j], |error| asked[j] + swell * error.at(t)))
                .collect();
            made.position.push(joints.iter().map(|q| q.x).collect());
            made.velocity.push(joints.iter().map(|q| q.d).collect());
            made.acceleration.push(joints.iter().map(|q| q.dd).collect());
        }
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pace_differs_by_its_share_and_begins_with_the_even_clock() {
        let mut random = Random::new(3);
        let deviations = BenchDeviations {
            pace: BenchDeviations::paces(0.01, 3.5, &mut random),
            ..BenchDeviations::default()
        };
        assert_eq!(deviations.clock(Jet::default()), Jet::default());
        let n = 200_000;
        let rates = (0..n).map(|k| deviations.clock(Jet::new(k as f64 * 1e-3, 1.0, 0.0)).d - 1.0);
        let rms = (rates.map(|x| x * x).sum::<f64>() / f64::from(n)).sqrt();
        assert!((rms - 0.01).abs() < 2e-4, "{rms}");
    }

    #[test]
    fn a_tracked_motion_lags_errs_and_knows_its_rates() {
        let step = 1e-3;
        let s = |k: usize| Jet::new(k as f64 * step, 1.0, 0.0);
        let q = |k: usize| s(k) * s(k) * s(k) * (s(k) * -1.0 + 1.0) * 3.0;
        let rows = |f: fn(Jet) -> f64| (0..=1000).map(|k| vec![f(q(k))]).collect();
        let asked = JointTrajectory {
            joints: vec!["a".into()],
            step,
            position: rows(|q| q.x),
            velocity: rows(|q| q.d),
            acceleration: rows(|q| q.dd),
        };
        let error = Sinusoid { amplitude: 2e-3, rate: 12.0, phase: 0.4 };
        let made = asked.tracked(0.02, &[error]);
        assert_eq!(made.len(), 1021);
        assert_eq!(made.position[0], asked.position[0]);
        let apart = made.position[500][0] - asked.at(0.48)[0].x;
        assert!(apart.abs() > 1e-4 && apart.abs() < 2e-3, "{apart}");
        let seen = made.differenced();
        assert!((seen.velocity[500][0] - made.velocity[500][0]).abs() < 1e-5);
        assert!((seen.acceleration[500][0] - made.acceleration[500][0]).abs() < 1e-3);
    }

    #[test]
    fn unrest_has_its_deviation_and_its_time() {
        let (mut unrest, mut random) = (Unrest::new(1e-3, 0.02), Random::new(5));
        let x: Vec<f64> = (0..200_000).map(|_| unrest.next(&mut random)[3]).collect();
        let product = |lag: usize| x.iter().zip(&x[lag..]).map(|(a, b)| a * b).sum::<f64>() / x.len() as f64;
        assert!((product(0) - 1.0).abs() < 0.05 && (product(20) - (-1.0_f64).exp()).abs() < 0.05);
    }
}
