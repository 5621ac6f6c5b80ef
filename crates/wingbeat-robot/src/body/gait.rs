//! Joint coordinates over the flapping cycle.

use serde::{Deserialize, Serialize};
use wingbeat_math::{DeclaredQuantity, Jet, Meets, Parameters, Scalar, Walk};
use wingbeat_math::{Error, require};

/// Most harmonics of a series.
pub const MAX_HARMONICS: usize = 64;

/// One harmonic amplitude cos(k phase - phase_k).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(rename = "Harmonic", bound = "P: schemars::JsonSchema + Default + Serialize")]
#[serde(deny_unknown_fields)]
pub struct Harmonic<P = f64> {
    /// Amplitude, rad.
    pub amplitude_rad: P,
    /// Phase lag, rad.
    #[serde(default)]
    pub phase_rad: P,
}

/// An angle as mean and harmonics of the stroke phase, positive = wing up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(rename = "FourierSeries", bound = "P: schemars::JsonSchema + Default + Serialize")]
#[serde(deny_unknown_fields)]
pub struct FourierSeries<P = f64> {
    /// Mean, rad.
    #[serde(default)]
    pub mean_rad: P,
    /// Harmonics 1, 2, ... of the gait.
    #[serde(default)]
    pub harmonics: Vec<Harmonic<P>>,
}

impl FourierSeries {
    /// Refuses what is not finite, and more harmonics than a series may have.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        require::finite("mean_rad", &[self.mean_rad])?;
        if self.harmonics.len() > MAX_HARMONICS {
            let allowed = format!("at most {MAX_HARMONICS} harmonics");
            return Err(Error::invalid("harmonics", format!("{} harmonics", self.harmonics.len()), allowed));
        }
        for (i, h) in self.harmonics.iter().enumerate() {
            require::finite(&format!("harmonics[{i}].amplitude_rad"), &[h.amplitude_rad])?;
            require::finite(&format!("harmonics[{i}].phase_rad"), &[h.phase_rad])?;
        }
        Ok(())
    }

    /// mean + amplitude cos(phase - lag).
    pub fn single(mean_rad: f64, amplitude_rad: f64, phase_rad: f64) -> Self {
        Self { mean_rad, harmonics: vec![Harmonic { amplitude_rad, phase_rad }] }
    }
}

impl<P: Scalar> FourierSeries<P> {
    /// Equation: body.gait_fourier
    /// `mean + sum_k a_k cos(k phase - p_k)`
    /// Source: Paper section V (gait).
    /// Test: `fourier_rates_are_derivatives_and_the_extremes_are_known`.
    ///
    /// mean + sum_k a_k cos(k phase - p_k), with rate and acceleration, in rad.
    #[inline]
    pub fn angle<S: Scalar + Meets<P>>(&self, phase: Jet<S>) -> Jet<S> {
        let mut sum = Jet::constant(S::from(self.mean_rad));
        for (before, harmonic) in self.harmonics.iter().enumerate() {
            let turned = (phase * (before + 1) as f64).shifted(-harmonic.phase_rad);
            sum += turned.cos().scaled(harmonic.amplitude_rad);
        }
        sum
    }

    /// True when the numbers of both are the same with all derivatives.
    pub fn is(&self, other: &Self) -> bool {
        let same = |a: P, b: P| (a - b).is_zero();
        let mut harmonics = self.harmonics.iter().zip(&other.harmonics);
        self.harmonics.len() == other.harmonics.len()
            && same(self.mean_rad, other.mean_rad)
            && harmonics
                .all(|(a, b)| same(a.amplitude_rad, b.amplitude_rad) && same(a.phase_rad, b.phase_rad))
    }
}

/// An angle, or the length of a joint that slides.
const ANGLE: DeclaredQuantity = DeclaredQuantity::free("rad");

impl<P: Scalar> Parameters<P> for FourierSeries<P> {
    type In<Q: Scalar> = FourierSeries<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> FourierSeries<Q> {
        FourierSeries {
            mean_rad: at.number("mean_rad", &ANGLE, self.mean_rad),
            harmonics: at.list(("harmonics", ""), &self.harmonics, |at, harmonic| Harmonic {
                amplitude_rad: at.number("amplitude_rad", &ANGLE, harmonic.amplitude_rad),
                phase_rad: at.number("phase_rad", &ANGLE, harmonic.phase_rad),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_math::Dual;

    #[test]
    fn fourier_rates_are_derivatives_and_the_extremes_are_known() {
        let elbow = FourierSeries {
            mean_rad: -0.65,
            harmonics: vec![
                Harmonic { amplitude_rad: -0.65, phase_rad: 3.9 },
                Harmonic { amplitude_rad: 0.1, phase_rad: 0.4 },
            ],
        };
        let shoulder = FourierSeries::single(0.1, 0.95, 0.0);
        assert_eq!(shoulder.angle(Jet::<f64>::from(0.0)).x, 1.05);
        let rate = 21.0;
        let t = Dual::<1, Dual<1>> { re: Dual::variable(0.4, 0), eps: [Dual::constant(1.0)] };
        let phase = Jet::new(t * rate, Dual::ZERO, Dual::ZERO);
        for series in [shoulder, elbow] {
            let moved = series.angle(phase).x;
            let exact = series.angle(Jet::new(0.4 * rate, rate, 0.0));
            assert!((moved.re.eps[0] - exact.d).abs() < 1e-12);
            assert!((moved.eps[0].eps[0] - exact.dd).abs() < 1e-9);
        }
    }

    #[test]
    fn a_series_without_meaning_is_refused_by_key() {
        let message = |series: FourierSeries| series.check().unwrap_err().to_string();
        assert!(message(FourierSeries::single(f64::NAN, 0.1, 0.0)).starts_with("mean_rad = NaN"));
        assert!(
            message(FourierSeries::single(0.0, 0.1, f64::INFINITY)).starts_with("harmonics[0].phase_rad")
        );
        let many = FourierSeries {
            harmonics: vec![Harmonic { amplitude_rad: 0.0, phase_rad: 0.0 }; 65],
            mean_rad: 0.0,
        };
        assert!(message(many).contains("at most 64"));
    }
}
