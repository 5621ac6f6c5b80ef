//! Measured and computed curves, compared by means over stretches of them, and the ramp of a plate that is pitched fast.

use std::f64::consts::FRAC_PI_4;

/// Smoothness a of Eldredge's ramp, per chord of travel.
const SMOOTHNESS: f64 = 15.0;
/// Chords of travel from the start of the motion to the corner of the ramp: there its acceleration is 1 % of its largest,
/// sech^2(0.2 a) = 0.01.
pub const START: f64 = 0.2;

/// Angle, rad, and its rate per chord of travel, `s` chords after the beginning, of a plate that is pitched to 45 degrees within one
/// chord, its corner at `start`: (45 deg / 2) [1 + (log cosh a(s - start) - log cosh a(s - start - 1))/a] (Eldredge, Wang & Ol 2009).
pub fn eldredge(s: f64, start: f64) -> (f64, f64) {
    let log_cosh = |x: f64| x.abs() + (-2.0 * x.abs()).exp().ln_1p();
    let [first, last] = [start, start + 1.0].map(|at| SMOOTHNESS * (s - at));
    let angle = 0.5 * FRAC_PI_4 * (1.0 + (log_cosh(first) - log_cosh(last)) / SMOOTHNESS);
    (angle, 0.5 * FRAC_PI_4 * (first.tanh() - last.tanh()))
}

/// A curve, straight between its points. Abscissae and values are in the caller's units.
pub struct SampledCurve {
    /// Where, rising.
    pub at: Vec<f64>,
    /// What is there.
    pub value: Vec<f64>,
}

impl SampledCurve {
    /// Mean from `low` to `high`, of the part that the curve has.
    pub fn mean(&self, low: f64, high: f64) -> f64 {
        let (mut area, mut width) = (0.0, 0.0);
        for (s, y) in self.at.windows(2).zip(self.value.windows(2)) {
            let (from, to) = (low.max(s[0]), high.min(s[1]));
            if to > from {
                let at = |x: f64| y[0] + (y[1] - y[0]) * (x - s[0]) / (s[1] - s[0]);
                area += 0.5 * (at(from) + at(to)) * (to - from);
                width += to - from;
            }
        }
        area / width
    }

    /// Rms difference from `measured` over its rms, at the points of `measured`; both are means over `window` about each of
    /// them, of the part within `ends`.
    pub fn error(&self, measured: &Self, window: f64, ends: [f64; 2]) -> f64 {
        self.error_where(measured, window, ends, |_| true)
    }

    /// The same at the points that `counts`.
    pub fn error_where(
        &self,
        measured: &Self,
        window: f64,
        ends: [f64; 2],
        counts: impl Fn(f64) -> bool,
    ) -> f64 {
        let (mut error, mut scale) = (0.0, 0.0);
        for at in measured.at.iter().filter(|at| counts(**at)) {
            let (low, high) = ((at - 0.5 * window).max(ends[0]), (at + 0.5 * window).min(ends[1]));
            let truth = measured.mean(low, high);
            error += (self.mean(low, high) - truth).powi(2);
            scale += truth * truth;
        }
        (error / scale).sqrt()
    }
}
