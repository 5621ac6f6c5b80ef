//! Bounding: strokes and a glide on folded wings in turn, as one cycle of the gait.

use crate::body::{FourierSeries, Harmonic, MAX_HARMONICS};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};

/// Flapping and a glide in turn. A cycle of the gait, whose frequency is `frequency_hz`, is as long as both together; its middle
/// wingbeat begins at phase 0.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct BoundSpec {
    /// Wingbeats in a cycle.
    pub strokes: usize,
    /// Length of the glide, in wingbeats.
    pub glide: usize,
    /// Share by which the wings come to rest at the links' `folded_rad` in the glide: 1 wholly, 0 not at all, so that they flap on.
    #[serde(default = "wholly")]
    pub depth: f64,
    /// Harmonics of the cycle from which the change between flapping and glide is made: the more, the shorter it is.
    #[serde(default = "six")]
    pub harmonics: usize,
}

/// Coefficients up to which are those of rounding, rad.
const ROUNDING: f64 = 1e-15;

fn wholly() -> f64 {
    1.0
}
fn six() -> usize {
    6
}

ranges!(BoundSpec {
    strokes: Range::between(1.0, 20.0),
    glide: Range::between(1.0, 20.0),
    depth: Range::between(0.0, 1.0),
    harmonics: Range::between(1.0, 40.0),
});

/// A trigonometric polynomial: coefficients of exp(i k phase), k from 0 up, as real and imaginary part; those of -k are conjugate.
type Wave = Vec<[f64; 2]>;

impl BoundSpec {
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()
    }

    /// Strokes that the cycle would have without a glide.
    pub fn strokes_per_cycle(&self) -> usize {
        self.strokes + self.glide
    }

    /// Equation: robot.bound
    /// `q = r + e(phase) (q_gait(N (phase - lag)) - r), e = 1 - depth (1 - box), box the mean of strokes/N of the cycle with Lanczos' factors`
    /// Source: choice; Lanczos 1956, Applied Analysis, ch. 4 (factors).
    /// Test: `a_bound_flaps_and_folds`.
    ///
    /// The series of a joint over the cycle: that of its stroke under an envelope, about the angle at which it is folded, in
    /// rad. Both are trigonometric polynomials, and so is their product.
    ///
    /// # Errors
    /// [`Error::Invalid`] with more harmonics than a series may have.
    pub fn series(
        &self,
        stroke: &FourierSeries,
        lag: f64,
        folded: Option<f64>,
    ) -> Result<FourierSeries, Error> {
        let n = self.strokes_per_cycle();
        let most = n * stroke.harmonics.len() + self.harmonics;
        if most > MAX_HARMONICS {
            let allowed = format!(
                "at most {MAX_HARMONICS} harmonics of the cycle, (strokes + glide) times those of a joint and bound.harmonics together"
            );
            return Err(Error::invalid("harmonics", format!("{most} harmonics"), allowed));
        }
        let folded = folded.unwrap_or(stroke.mean_rad);
        let mut swing: Wave = vec![[0.0; 2]; most + 1];
        swing[0] = [stroke.mean_rad - folded, 0.0];
        for (k, harmonic) in stroke.harmonics.iter().enumerate() {
            let turned = -harmonic.phase_rad - (k + 1) as f64 * lag;
            let half = 0.5 * harmonic.amplitude_rad;
            swing[n * (k + 1)] = [half * turned.cos(), half * turned.sin()];
        }
        let product = self.envelope().iter().enumerate().fold(vec![[0.0; 2]; most + 1], |mut sum, (j, e)| {
            for (k, to) in sum.iter_mut().enumerate() {
                let sides =
                    if j == 0 { vec![k as isize] } else { vec![k as isize - j as isize, (k + j) as isize] };
                for side in sides {
                    let Some(part) = swing.get(side.unsigned_abs()) else { continue };
                    to[0] += e * part[0];
                    to[1] += e * part[1] * if side < 0 { -1.0 } else { 1.0 };
                }
            }
            sum
        });
        // What only rounding leaves has no phase.
        let kept = |x: f64| if x.abs() < ROUNDING { 0.0 } else { x };
        let harmonics = product[1..].iter().map(|part| {
            let [re, im] = part.map(kept);
            Harmonic { amplitude_rad: 2.0 * re.hypot(im), phase_rad: 0.0 - im.atan2(re) }
        });
        Ok(FourierSeries { mean_rad: product[0][0] + folded, harmonics: harmonics.collect() })
    }

    /// Coefficients of the envelope, which is even about phase 0: each stands for itself and that of the negative harmonic.
    fn envelope(&self) -> Vec<f64> {
        let duty = self.strokes as f64 / self.strokes_per_cycle() as f64;
        let factor = |j: usize| {
            let x = PI * j as f64 / (self.harmonics + 1) as f64;
            x.sin() / x * (0.5 * TAU * j as f64 * duty).sin() / (PI * j as f64)
        };
        let of_box = |j: usize| if j == 0 { duty } else { factor(j) };
        let flaps_on = |j: usize| if j == 0 { 1.0 - self.depth } else { 0.0 };
        (0..=self.harmonics).map(|j| flaps_on(j) + self.depth * of_box(j)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_math::Jet;

    #[test]
    fn a_bound_flaps_and_folds() {
        let stroke = FourierSeries {
            mean_rad: 0.2,
            harmonics: vec![
                Harmonic { amplitude_rad: 0.8, phase_rad: 0.3 },
                Harmonic { amplitude_rad: 0.1, phase_rad: -1.0 },
            ],
        };
        let at = |series: &FourierSeries, phase: f64| series.angle(Jet::<f64>::from(phase)).x;
        let bound = BoundSpec { strokes: 3, glide: 2, depth: 1.0, harmonics: 8 };
        let all = bound.series(&stroke, 0.4, Some(-1.1)).unwrap();
        assert_eq!(all.harmonics.len(), 18);
        let envelope = bound.envelope();
        for k in 0..40 {
            let phase = TAU * k as f64 / 40.0;
            let e = envelope
                .iter()
                .enumerate()
                .map(|(j, c)| c * (j as f64 * phase).cos() * if j == 0 { 1.0 } else { 2.0 });
            let asked = -1.1 + e.sum::<f64>() * (at(&stroke, 5.0 * phase - 0.4) + 1.1);
            assert!((at(&all, phase) - asked).abs() < 1e-12, "{k}");
        }
        // In the middle of the strokes as the stroke alone, in that of the glide folded.
        assert!((at(&all, 0.0) - at(&stroke, -0.4)).abs() < 0.03);
        assert!((at(&all, PI) + 1.1).abs() < 0.03, "{}", at(&all, PI));
        // Without depth it flaps on, and a joint that is not folded rests at its mean.
        let on = BoundSpec { depth: 0.0, ..bound }.series(&stroke, 0.0, None).unwrap();
        assert!((0..9).all(|k| (at(&on, 0.7 * k as f64) - at(&stroke, 3.5 * k as f64)).abs() < 1e-12));
        let many = BoundSpec { strokes: 20, glide: 20, ..bound };
        assert!(many.series(&stroke, 0.0, None).unwrap_err().to_string().contains("at most 64 harmonics"));
    }
}
