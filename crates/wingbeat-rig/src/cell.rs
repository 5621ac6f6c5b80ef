//! The load cell: an ATI Nano17 between mount and robot.

use crate::netft::BOX_RATE;
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Random, Vec3, Wrench};

pub use wingbeat_math::CHANNELS;

/// Calibrations of the Nano17 (ATI Industrial Automation, Nano17 data sheet).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub enum Calibration {
    /// 12 N, 17 N along z, 120 N mm.
    #[serde(rename = "SI-12-0.12")]
    Si12,
    /// 25 N, 35 N along z, 250 N mm.
    #[serde(rename = "SI-25-0.25")]
    Si25,
    /// 50 N, 70 N along z, 500 N mm.
    #[serde(rename = "SI-50-0.5")]
    Si50,
}

impl Calibration {
    /// Largest magnitude of each channel, N and N m.
    pub fn range(self) -> [f64; 6] {
        let (xy, z, t) = match self {
            Self::Si12 => (12.0, 17.0, 0.12),
            Self::Si25 => (25.0, 35.0, 0.25),
            Self::Si50 => (50.0, 70.0, 0.5),
        };
        [xy, xy, z, t, t, t]
    }
    /// Smallest step of each channel, N and N m.
    pub fn resolution(self) -> [f64; 6] {
        let coarse = match self {
            Self::Si12 => 1.0,
            Self::Si25 => 2.0,
            Self::Si50 => 4.0,
        };
        let (f, t) = (coarse / 320.0, coarse * 1e-3 / 64.0);
        [f, f, f, t, t, t]
    }
}

/// A load cell as written in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct CellSpec {
    /// Which calibration.
    pub calibration: Calibration,
    /// Samples per second: 7000 divided by a whole number.
    pub rate_hz: f64,
    /// Standard deviation of the noise, as a ratio to the step of resolution.
    #[serde(default)]
    pub noise_steps: f64,
    /// Offset at the start, N and N m.
    #[serde(default)]
    pub bias: [f64; 6],
    /// Drift, N/s and N m/s.
    #[serde(default)]
    pub drift_per_s: [f64; 6],
    /// Natural frequency of robot and mount on the cell, Hz.
    pub resonance_hz: f64,
    /// Damping ratio of that resonance.
    pub resonance_damping: f64,
    /// Corner of the box's low-pass filter, Hz.
    pub filter_hz: f64,
}

ranges!(CellSpec {
    rate_hz: Range::over(0.0, BOX_RATE),
    noise_steps: Range::NOT_NEGATIVE,
    resonance_hz: Range::inside(0.0, 0.5 * BOX_RATE),
    resonance_damping: Range::inside(0.0, 1.0),
    filter_hz: Range::inside(0.0, 0.5 * BOX_RATE),
});

impl CellSpec {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the key.
    pub fn check(&self) -> Result<(), Error> {
        let check = |key: &str, value: f64, good: bool, allowed: &str| {
            if good { Ok(()) } else { Err(Error::invalid(key, value, allowed).against(["rate_hz"])) }
        };
        let divisor = BOX_RATE / self.rate_hz;
        let whole = divisor >= 1.0 && (divisor - divisor.round()).abs() < 1e-9;
        check("rate_hz", self.rate_hz, whole, "7000 divided by a whole number")?;
        let nyquist = 0.5 * self.rate_hz;
        let below = |x: f64| x > 0.0 && x < nyquist;
        let allowed = format!("above 0 and below half the rate, {nyquist} Hz");
        check("resonance_hz", self.resonance_hz, below(self.resonance_hz), &allowed)?;
        check("filter_hz", self.filter_hz, below(self.filter_hz), &allowed)?;
        self.in_range()
    }
}

/// One sample of the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellReading {
    /// Forces and moments in the cell's frame, N and N m.
    pub values: [f64; 6],
    /// True when a channel is at the end of its range.
    pub saturated: bool,
}

/// A load cell at work: resonance, filter, noise, drift, quantisation, saturation.
#[derive(Clone, Debug)]
pub struct LoadCell {
    spec: CellSpec,
    step: f64,
    /// Displacement and rate of each channel's resonance.
    resonance: [[f64; 2]; 6],
    filtered: [f64; 6],
    samples: usize,
    random: Random,
}

impl LoadCell {
    /// A cell that has rested under `wrench` (N and N m, in C).
    ///
    /// # Errors
    /// What [`CellSpec::check`] refuses.
    pub fn new(spec: &CellSpec, wrench: &Wrench<f64>, seed: u64) -> Result<Self, Error> {
        spec.check()?;
        let mut cell = Self {
            spec: spec.clone(),
            step: 1.0 / spec.rate_hz,
            resonance: [[0.0; 2]; 6],
            filtered: [0.0; 6],
            samples: 0,
            random: Random::new(seed),
        };
        cell.rest(wrench);
        Ok(cell)
    }

    /// Lets the cell rest under `wrench` (N and N m, in C).
    pub fn rest(&mut self, wrench: &Wrench<f64>) {
        self.filtered = six(wrench);
        self.resonance = self.filtered.map(|x| [x, 0.0]);
    }

    /// The next sample under `wrench` (N and N m, in the cell's frame), held over one sampling step.
    pub fn sample(&mut self, wrench: &Wrench<f64>) -> CellReading {
        let t = self.samples as f64 * self.step;
        self.samples += 1;
        let load = six(wrench);
        let (range, resolution) = (self.spec.calibration.range(), self.spec.calibration.resolution());
        let keep = (-std::f64::consts::TAU * self.spec.filter_hz * self.step).exp();
        let mut reading = CellReading { values: [0.0; 6], saturated: false };
        for i in 0..6 {
            self.resonance[i] = self.ring(self.resonance[i], load[i]);
            self.filtered[i] = keep * self.filtered[i] + (1.0 - keep) * self.resonance[i][0];
            let noise = self.spec.noise_steps * resolution[i] * self.random.normal();
            let seen = self.filtered[i] + self.spec.bias[i] + self.spec.drift_per_s[i] * t + noise;
            let limited = seen.clamp(-range[i], range[i]);
            reading.saturated |= limited != seen;
            reading.values[i] = (limited / resolution[i]).round() * resolution[i];
        }
        reading
    }

    /// Exact step of x'' = w^2 (load - x) - 2 z w x' under a constant load.
    fn ring(&self, [x, v]: [f64; 2], load: f64) -> [f64; 2] {
        let w = std::f64::consts::TAU * self.spec.resonance_hz;
        let z = self.spec.resonance_damping;
        let wd = w * (1.0 - z * z).sqrt();
        let (sin, cos) = (wd * self.step).sin_cos();
        let decay = (-z * w * self.step).exp();
        let (e, a) = (x - load, (v + z * w * (x - load)) / wd);
        let position = decay * (e * cos + a * sin);
        let velocity = decay * (wd * (a * cos - e * sin)) - z * w * position;
        [load + position, velocity]
    }
}

/// Fx, Fy, Fz, Tx, Ty, Tz of a wrench, N and N m.
pub fn six(wrench: &Wrench<f64>) -> [f64; 6] {
    let (f, m) = (wrench.force, wrench.moment);
    [f[0], f[1], f[2], m[0], m[1], m[2]]
}

/// The wrench, N and N m, of Fx, Fy, Fz, Tx, Ty, Tz.
pub fn wrench(x: [f64; 6]) -> Wrench<f64> {
    Wrench { force: Vec3([x[0], x[1], x[2]]), moment: Vec3([x[3], x[4], x[5]]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> CellSpec {
        CellSpec {
            calibration: Calibration::Si12,
            rate_hz: 7000.0,
            noise_steps: 0.0,
            bias: [0.0; 6],
            drift_per_s: [0.0; 6],
            resonance_hz: 180.0,
            resonance_damping: 0.05,
            filter_hz: 1000.0,
        }
    }

    #[test]
    fn a_steady_load_is_read_to_half_a_step() {
        let load = wrench([0.1234, -0.2, 0.4321, 0.001, -0.002, 0.0031]);
        let mut cell = LoadCell::new(&spec(), &Wrench::ZERO, 1).unwrap();
        let last = (0..7000).map(|_| cell.sample(&load)).last().unwrap();
        for ((value, true_value), step) in
            last.values.iter().zip(six(&load)).zip(Calibration::Si12.resolution())
        {
            assert!((value - true_value).abs() <= 0.5 * step + 1e-12);
        }
    }

    #[test]
    fn a_step_rings_at_the_resonance() {
        let mut cell = LoadCell::new(&spec(), &Wrench::ZERO, 1).unwrap();
        let load = wrench([0.0, 0.0, 8.0, 0.0, 0.0, 0.0]);
        let z: Vec<f64> = (0..400).map(|_| cell.sample(&load).values[2]).collect();
        let peak = (1..399).find(|&k| z[k] >= z[k - 1] && z[k] > z[k + 1]).unwrap();
        let half_period = 0.5 / 180.0 + 1.0 / (std::f64::consts::TAU * 1000.0);
        assert!((peak as f64 / 7000.0 - half_period).abs() < 3e-4, "{peak}");
        assert!(z[peak] > 14.0, "overshoot {}", z[peak]);
    }

    #[test]
    fn noise_drift_and_range() {
        let noisy = CellSpec { noise_steps: 2.0, drift_per_s: [0.05; 6], ..spec() };
        let mut cell = LoadCell::new(&noisy, &Wrench::ZERO, 5).unwrap();
        let x: Vec<f64> = (0..14_000).map(|_| cell.sample(&Wrench::ZERO).values[0]).collect();
        let mean = x[7000..].iter().sum::<f64>() / 7000.0;
        assert!((mean - 0.075).abs() < 5e-4, "{mean}");
        let over = cell.sample(&wrench([0.0, 0.0, 0.0, 9.0, 0.0, 0.0]));
        assert!(
            (0..3000).any(|_| cell.sample(&wrench([0.0, 0.0, 0.0, 9.0, 0.0, 0.0])).saturated)
                || over.saturated
        );
    }

    #[test]
    fn odd_rates_are_refused() {
        let message = CellSpec { rate_hz: 3000.0, ..spec() }.check().unwrap_err().to_string();
        assert!(message.contains("7000 divided by a whole number"));
    }
}
