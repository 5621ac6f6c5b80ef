//! Zero-phase low-pass filtering.

use wingbeat_math::Error;

/// Fourth-order Butterworth low-pass in two second-order sections, run forward
/// and backward: no phase shift, the gain of the eighth order.
#[derive(Clone, Debug)]
pub struct Butterworth {
    sections: [FilterSection; 2],
    /// tan(pi cutoff / rate)
    warp: f64,
    rate: f64,
    /// Samples mirrored at the ends.
    padding: usize,
}

/// y = (b0 x + b1 x' + b2 x'' - a1 y' - a2 y'').
#[derive(Clone, Copy, Debug)]
struct FilterSection {
    b: [f64; 3],
    a: [f64; 2],
}

impl Butterworth {
    /// The filter with -3 dB of each pass at `cutoff` (Hz) for `rate` samples per second.
    ///
    /// # Errors
    /// A cut-off outside (0, rate / 2).
    pub fn new(cutoff: f64, rate: f64) -> Result<Self, Error> {
        if !(cutoff > 0.0 && cutoff < 0.5 * rate) {
            let allowed = format!("above 0 and below half the rate, {} Hz", 0.5 * rate);
            return Err(Error::invalid("process.cutoff_hz", cutoff, allowed));
        }
        let warp = (std::f64::consts::PI * cutoff / rate).tan();
        // Poles of order 4: 1/Q = 2 cos(pi/8), 2 cos(3 pi/8).
        let sections = [1.0, 3.0]
            .map(|k: f64| FilterSection::low_pass(warp, 2.0 * (k * std::f64::consts::PI / 8.0).cos()));
        let padding = (10.0 * rate / cutoff).ceil() as usize;
        Ok(Self { sections, warp, rate, padding })
    }

    /// Gain of both passes together at `frequency`, Hz: 1 / (1 + (w / wc)^8) with
    /// the bilinear map's warped frequencies.
    ///
    /// Equation: rig.butterworth
    /// `gain 1 / (1 + (w / wc)^8), w = tan(pi f / rate)`
    /// Source: Butterworth 1930; bilinear transform, both directions.
    /// Test: `gain_follows_the_formula_and_the_phase_stays`.
    pub fn gain(&self, frequency: f64) -> f64 {
        let w = (std::f64::consts::PI * frequency / self.rate).tan() / self.warp;
        1.0 / (1.0 + w.powi(8))
    }

    /// `x`, in its unit, without what lies above the cut-off and without delay; the ends are continued by point reflection.
    pub fn apply(&self, x: &[f64]) -> Vec<f64> {
        if x.len() < 2 {
            return x.to_vec();
        }
        let n = x.len();
        let pad = self.padding.min(n - 1);
        let before = (1..=pad).rev().map(|i| 2.0 * x[0] - x[i]);
        let after = (1..=pad).map(|i| 2.0 * x[n - 1] - x[n - 1 - i]);
        let mut y: Vec<f64> = before.chain(x.iter().copied()).chain(after).collect();
        self.pass(&mut y);
        y.reverse();
        self.pass(&mut y);
        y.reverse();
        y[pad..pad + n].to_vec()
    }

    /// As [`Butterworth::apply`], each stretch between missing samples (not-a-number) by itself.
    pub fn apply_between_gaps(&self, x: &[f64]) -> Vec<f64> {
        let mut y = Vec::with_capacity(x.len());
        for stretch in x.chunk_by(|a, b| a.is_nan() == b.is_nan()) {
            match stretch[0].is_nan() {
                true => y.extend_from_slice(stretch),
                false => y.extend(self.apply(stretch)),
            }
        }
        y
    }

    /// One pass, begun in the steady state of the first sample.
    fn pass(&self, y: &mut [f64]) {
        for s in &self.sections {
            let first = y[0];
            let (mut x1, mut x2, mut y1, mut y2) = (first, first, first, first);
            for v in y.iter_mut() {
                let x = *v;
                *v = s.b[0] * x + s.b[1] * x1 + s.b[2] * x2 - s.a[0] * y1 - s.a[1] * y2;
                (x2, x1, y2, y1) = (x1, x, y1, *v);
            }
        }
    }
}

impl FilterSection {
    /// Bilinear transform of 1 / (s^2 + s / Q + 1).
    fn low_pass(k: f64, inverse_q: f64) -> Self {
        let norm = 1.0 / (1.0 + inverse_q * k + k * k);
        let b0 = k * k * norm;
        Self { b: [b0, 2.0 * b0, b0], a: [2.0 * (k * k - 1.0) * norm, (1.0 - inverse_q * k + k * k) * norm] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Complex amplitude of `x` at `f` over its middle half: (in phase, quadrature).
    fn amplitude(x: &[f64], f: f64, rate: f64) -> (f64, f64) {
        let period = rate / f;
        let from = x.len() / 4;
        let count = ((x.len() as f64 / 2.0 / period).floor() * period).round() as usize;
        let sum = |g: fn(f64) -> f64| {
            (from..from + count).map(|k| x[k] * g(TAU * f * k as f64 / rate)).sum::<f64>() * 2.0
                / count as f64
        };
        (sum(f64::sin), sum(f64::cos))
    }

    #[test]
    fn gain_follows_the_formula_and_the_phase_stays() {
        let filter = Butterworth::new(70.0, 7000.0).unwrap();
        for f in [3.5, 35.0, 70.0, 140.0] {
            let x: Vec<f64> = (0..28_000).map(|k| (TAU * f * k as f64 / 7000.0).sin()).collect();
            let (s, c) = amplitude(&filter.apply(&x), f, 7000.0);
            assert!((s - filter.gain(f)).abs() < 1e-6 && c.abs() < 1e-6, "{f}: {s} {c}");
        }
        assert!((filter.gain(70.0) - 0.5).abs() < 1e-12 && 1.0 - filter.gain(3.5) < 1e-9);
    }

    #[test]
    fn straight_lines_pass_unchanged() {
        let filter = Butterworth::new(35.0, 7000.0).unwrap();
        let x: Vec<f64> = (0..7000).map(|k| 2.0 - 3e-4 * k as f64).collect();
        for (y, x) in filter.apply(&x).iter().zip(&x) {
            assert!((y - x).abs() < 1e-9);
        }
        assert!(Butterworth::new(4000.0, 7000.0).is_err());
        let mut gap = x.clone();
        gap[3000..3010].fill(f64::NAN);
        let y = filter.apply_between_gaps(&gap);
        assert!(y[3000..3010].iter().all(|y| y.is_nan()));
        assert!(y.iter().zip(&x).all(|(y, x)| y.is_nan() || (y - x).abs() < 1e-9));
    }
}
