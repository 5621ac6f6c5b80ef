//! The phase of the stroke with its rates, out of the encoder's samples.

use wingbeat_math::Jet;

/// Part of a cycle over which the encoder is fitted. *Choice*: counts of 1/1024 turn leave 1 % of the wings' acceleration, and what
/// beats twice a cycle loses 4 % of its own.
const PART: f64 = 0.125;
/// Samples on either side of one that are fitted, at least and at most. *Choice*: a cubic takes five.
const HALF: [usize; 2] = [2, 512];

/// Cubics by least squares through the samples about each one.
#[derive(Clone, Copy, Debug)]
pub struct PhaseFit {
    half: usize,
    step: f64,
    /// Sums of u^0, u^2, u^4, u^6 over the samples, u from -1 to 1.
    sums: [f64; 4],
}

impl PhaseFit {
    /// For samples at `step` (s) of strokes at `frequency` (Hz), `many` of them; none where they are too few.
    pub fn new(step: f64, frequency: f64, many: usize) -> Option<Self> {
        let [least, most] = HALF;
        let half =
            ((0.5 * PART / (frequency * step)) as usize).clamp(least, most).min(many.saturating_sub(1) / 2);
        let known = half >= least && step > 0.0 && frequency > 0.0;
        let places = |half: usize| (0..=2 * half).map(move |k| k as f64 / half as f64 - 1.0);
        let sum = |power: i32| places(half).map(|u| u.powi(power)).sum();
        known.then(|| Self { half, step, sums: [0, 2, 4, 6].map(sum) })
    }

    /// Phase (rad), its rate and the slope of that, per s, at `row`.
    ///
    /// Equation: rig.encoder_clock
    /// `phase(t_k + s) = c0 + c1 s + c2 s^2 + c3 s^3, least squares over 1/8 cycle`
    /// Source: A. Savitzky and M. J. E. Golay, Anal. Chem. 36 (1964) 1627-1639.
    /// Test: `counts_and_noise_of_an_encoder_leave_its_rates`.
    pub fn at(&self, phase: &[f64], row: usize) -> Jet {
        let half = self.half;
        let centre = row.clamp(half, phase.len() - 1 - half);
        let of = 1.0 / half as f64;
        let mut y = [0.0; 4];
        for (k, value) in phase[centre - half..=centre + half].iter().enumerate() {
            let (u, d) = (k as f64 * of - 1.0, value - phase[centre]);
            y[0] += d;
            y[1] += u * d;
            y[2] += u * u * d;
            y[3] += u * u * u * d;
        }
        let [n, s2, s4, s6] = self.sums;
        let (even, odd) = (n * s4 - s2 * s2, s2 * s6 - s4 * s4);
        let c0 = (s4 * y[0] - s2 * y[2]) / even;
        let c2 = (n * y[2] - s2 * y[0]) / even;
        let c1 = (s6 * y[1] - s4 * y[3]) / odd;
        let c3 = (s2 * y[3] - s4 * y[1]) / odd;
        // Away from the middle only at the ends of the record.
        let u = (row as f64 - centre as f64) * of;
        let per = of / self.step;
        Jet::new(
            phase[centre] + c0 + u * (c1 + u * (c2 + u * c3)),
            (c1 + u * (2.0 * c2 + 3.0 * u * c3)) * per,
            (2.0 * c2 + 6.0 * u * c3) * per * per,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use wingbeat_math::{Random, Scalar};

    /// A crank at 3.5 Hz that beats a little twice a cycle, read at 7 kHz.
    fn crank(t: f64) -> Jet {
        let w = 3.5 * TAU;
        let t = Jet::new(t, 1.0, 0.0);
        t * w + (t * (2.0 * w)).sin() * 0.02
    }

    #[test]
    fn counts_and_noise_of_an_encoder_leave_its_rates() {
        let step = 1.0 / 7000.0;
        let w = 3.5 * TAU;
        let mut random = Random::stream(3, 0);
        let count = TAU / 1024.0;
        let mut read = |of: usize, t: f64| match of {
            0 => (crank(t).x / count).round() * count,
            1 => crank(t).x + 1e-3 * random.normal(),
            // Read at 1 kHz and held.
            _ => crank((t * 1000.0).floor() / 1000.0).x,
        };
        for (of, lag) in [(0, 0.0), (1, 0.0), (2, 3.0 * step)] {
            let seen: Vec<f64> = (0..14_000).map(|k| read(of, k as f64 * step)).collect();
            let fit = PhaseFit::new(step, 3.5, seen.len()).unwrap();
            let (mut rate, mut slope) = (0.0, 0.0);
            for row in 500..13_500 {
                let (found, right) = (fit.at(&seen, row), crank(row as f64 * step - lag));
                assert!((found.x - right.x).abs() < 3e-3, "{of}: {found:?} {right:?}");
                rate += (found.d - right.d).powi(2) / 13_000.0;
                slope += (found.dd - right.dd).powi(2) / 13_000.0;
                assert!(row == 500 || found.x > fit.at(&seen, row - 1).x, "{of}: the phase goes back");
            }
            assert!(rate.sqrt() < 0.01 * w && slope.sqrt() < 0.015 * w * w, "{of}: {rate} {slope}");
        }
    }

    #[test]
    fn cubics_come_back_at_the_ends_too() {
        let step = 1e-3;
        let cubic = |t: f64| 0.3 + 20.0 * t - 3.0 * t * t + 5.0 * t * t * t;
        let seen: Vec<f64> = (0..300).map(|k| cubic(k as f64 * step)).collect();
        let fit = PhaseFit::new(step, 2.0, seen.len()).unwrap();
        for row in [0, 3, 150, 299] {
            let (found, t) = (fit.at(&seen, row), row as f64 * step);
            assert!((found.x - cubic(t)).abs() < 1e-12);
            assert!((found.d - (20.0 - 6.0 * t + 15.0 * t * t)).abs() < 1e-9);
            assert!((found.dd - (-6.0 + 30.0 * t)).abs() < 1e-6);
        }
        assert!(PhaseFit::new(step, 2.0, 4).is_none() && PhaseFit::new(step, 0.0, 300).is_none());
    }
}
