//! Continuous turbulence by Dryden's spectra.

use wingbeat_math::{Random, Vec3};

/// Feet to a metre.
const FEET: f64 = 1.0 / 0.3048;
/// Nodes of the course in the time in which the air passes the shortest scale. *Choice*: linear between nodes, the course has 0.7 % less
/// variance than at them.
const NODES: f64 = 50.0;
/// Ratio of the numerator's scale to the denominator's in the spectra across the flight.
const ACROSS: f64 = 1.732_050_807_568_877_2;

/// Turbulence that flies past at a constant airspeed, frozen: along the flight, to its left, up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dryden {
    /// Standard deviations, m/s.
    pub deviation: [f64; 3],
    /// Scales, m.
    pub length: [f64; 3],
    /// Airspeed, m/s.
    pub airspeed: f64,
}

impl Dryden {
    /// Equation: robot.dryden_low
    /// `L_w = h, L_u = L_v = h/(0.177 + 0.000823 h)^1.2, s_w = 0.1 W, s_u = s_v = s_w/(0.177 + 0.000823 h)^0.4, h in ft`
    /// Source: MIL-F-8785C, 3.7.3.
    /// Test: `low_turbulence_has_the_scales_of_the_specification`.
    ///
    /// Scales and deviations below 1000 ft, of the altitude, m, and the wind at 20 ft, m/s.
    pub fn low(altitude: f64, wind: f64, airspeed: f64) -> Self {
        let feet = altitude * FEET;
        let rough = 0.177 + 0.000823 * feet;
        let (length, deviation) = (altitude * rough.powf(-1.2), 0.1 * wind * rough.powf(-0.4));
        Self { deviation: [deviation, deviation, 0.1 * wind], length: [length, length, altitude], airspeed }
    }

    /// Time between nodes of a course, s.
    pub fn step(&self) -> f64 {
        self.length.into_iter().fold(f64::INFINITY, f64::min) / (NODES * self.airspeed)
    }

    /// Equation: robot.dryden
    /// `S_u = s^2 (2 L/pi)/(1 + x^2), S_v,w = s^2 (L/pi)(1 + 3 x^2)/(1 + x^2)^2, x = L omega/V, over omega/V from 0 on`
    /// Source: MIL-F-8785C, 3.7.2; exact in discrete time.
    /// Test: `turbulence_has_drydens_correlation`.
    ///
    /// Velocities at `count` nodes a [`step`](Self::step) apart, along the flight, to its left, up: of the filters that make these
    /// spectra of white noise, started in their stationary state and stepped by their exact transition. Along the flight
    /// u' = -a u + noise with a = V/L; across it p' = a r, r' = a (-p - 2 r + noise), v = s (p + sqrt(3) r)/2, of which p and r
    /// have variance 1 and no covariance; a step h takes them by exp(-a h) (1 + a h (1 1; -1 -1)) and adds noise of the covariance
    /// 1 - that times its transpose.
    pub fn nodes(&self, count: usize, seed: u64) -> Vec<Vec3> {
        let mut axes = [0, 1, 2].map(|axis| {
            let turned = self.airspeed / self.length[axis] * self.step();
            ShapingFilter::new(axis > 0, turned, Random::stream(seed, axis as u64 + 1))
        });
        let node = |_| Vec3(std::array::from_fn(|axis| self.deviation[axis] * axes[axis].next()));
        (0..count).map(node).collect()
    }
}

/// A shaping filter of unit variance.
struct ShapingFilter {
    across: bool,
    state: [f64; 2],
    /// Rows of the transition, and the lower root of the noise's covariance.
    transition: [[f64; 2]; 2],
    root: [f64; 3],
    random: Random,
}

impl ShapingFilter {
    /// `turned` is a h.
    fn new(across: bool, turned: f64, mut random: Random) -> Self {
        let decay = (-turned).exp();
        let transition = match across {
            true => [[decay * (1.0 + turned), decay * turned], [-decay * turned, decay * (1.0 - turned)]],
            false => [[decay, 0.0], [0.0, 0.0]],
        };
        let covariance = |i: usize, j: usize| {
            let kept: f64 = (0..2).map(|k| transition[i][k] * transition[j][k]).sum();
            f64::from(u8::from(i == j)) - kept
        };
        let first = covariance(0, 0).max(0.0).sqrt();
        let below = if first > 0.0 { covariance(1, 0) / first } else { 0.0 };
        let root = [first, below, (covariance(1, 1) - below * below).max(0.0).sqrt()];
        let state = [random.normal(), random.normal()];
        Self { across, state, transition, root, random }
    }

    /// The velocity now, over its deviation; a step is taken after it.
    fn next(&mut self) -> f64 {
        let [p, r] = self.state;
        let velocity = if self.across { 0.5 * (p + ACROSS * r) } else { p };
        let noise = [self.random.normal(), self.random.normal()];
        let [one, other] = self.transition;
        self.state = [
            one[0] * p + one[1] * r + self.root[0] * noise[0],
            other[0] * p + other[1] * r + self.root[1] * noise[0] + self.root[2] * noise[1],
        ];
        velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_turbulence_has_the_scales_of_the_specification() {
        // At 100 ft: L_w = 100 ft, L_u = 100/(0.2593)^1.2 = 505.2 ft, s_u/s_w = 1/(0.2593)^0.4 = 1.7160.
        let low = Dryden::low(30.48, 5.0, 10.0);
        assert!((low.length[2] - 30.48).abs() < 1e-12 && (low.deviation[2] - 0.5).abs() < 1e-12);
        assert!((low.length[0] * FEET - 505.2).abs() < 0.1, "{}", low.length[0] * FEET);
        assert!((low.deviation[0] / low.deviation[2] - 1.7160).abs() < 1e-3);
        // At 1000 ft all are alike: 0.177 + 0.823 = 1.
        let high = Dryden::low(304.8, 5.0, 10.0);
        assert!((high.length[0] - 304.8).abs() < 1e-9 && (high.deviation[0] - 0.5).abs() < 1e-12);
    }

    #[test]
    fn turbulence_has_drydens_correlation() {
        let of = Dryden { deviation: [0.4, 0.3, 0.2], length: [2.0, 1.0, 1.5], airspeed: 4.0 };
        let (count, step) = (400_000, of.step());
        let nodes = of.nodes(count, 3);
        for axis in 0..3 {
            let a = of.airspeed / of.length[axis];
            for lag in [0, 10, 40, 100] {
                let pairs = (lag..count).map(|k| nodes[k][axis] * nodes[k - lag][axis]);
                let found = pairs.sum::<f64>() / (count - lag) as f64 / of.deviation[axis].powi(2);
                let turned = a * step * lag as f64;
                let factor = if axis == 0 { 1.0 } else { 1.0 - 0.5 * turned };
                let expected = factor * (-turned).exp();
                assert!((found - expected).abs() < 0.05, "{axis} {lag}: {found} for {expected}");
            }
        }
        assert_eq!(of.nodes(5, 3), nodes[..5]);
        assert_ne!(of.nodes(5, 4), nodes[..5]);
    }
}
