//! Joint angles of one wing over the flapping cycle.

use super::linkage::{Linkage, REGULATED};
use crate::math::{Jet, Scalar};
use crate::plant::Fault;
use serde::{Deserialize, Serialize};

/// One harmonic amplitude cos(k phase - phase_k).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Harmonic {
    /// Amplitude, rad.
    pub amplitude_rad: f64,
    /// Phase lag, rad.
    pub phase_rad: f64,
}

/// An angle as mean and harmonics of the stroke phase, positive = wing up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FourierSeries {
    /// Mean, rad.
    pub mean_rad: f64,
    /// Harmonics 1, 2, ... of the stroke.
    #[serde(default)]
    pub harmonics: Vec<Harmonic>,
}

impl FourierSeries {
    /// mean + amplitude cos(phase - lag).
    pub fn single(mean_rad: f64, amplitude_rad: f64, phase_rad: f64) -> Self {
        Self { mean_rad, harmonics: vec![Harmonic { amplitude_rad, phase_rad }] }
    }

    /// Equation: body.gait_fourier
    ///
    /// mean + sum_k a_k cos(k phase - p_k), with rate and acceleration.
    #[inline]
    pub fn angle<S: Scalar>(&self, phase: Jet<S>) -> Jet<S> {
        let terms = self.harmonics.iter().zip(1..);
        terms.fold(Jet::from(self.mean_rad), |sum, (harmonic, k)| {
            sum + (phase * f64::from(k) - harmonic.phase_rad).cos() * harmonic.amplitude_rad
        })
    }
}

/// How the wing is driven over the cycle.
#[derive(Clone, Debug, PartialEq)]
pub enum Gait {
    /// Shoulder and elbow angle as Fourier series.
    Fourier {
        /// Shoulder angle.
        shoulder: FourierSeries,
        /// Elbow angle.
        elbow: FourierSeries,
    },
    /// The linkage; the stroke phase is its crank angle.
    Linkage(Box<Linkage>),
}

/// Joint angles of one wing, positive = wing up; the same on either side.
#[derive(Clone, Copy, Debug)]
pub struct WingAngles<S: Scalar = f64> {
    /// Humerus against the body, rad.
    pub shoulder: Jet<S>,
    /// Radius against the humerus, rad.
    pub elbow: Jet<S>,
}

impl Gait {
    /// What the displacements of one wing are: joint offsets (rad) or link lengths (m).
    pub fn displacements(&self) -> &'static [&'static str] {
        match self {
            Self::Fourier { .. } => &["shoulder", "elbow"],
            Self::Linkage(_) => &REGULATED,
        }
    }

    /// Angles at the stroke phase (rad), displaced about the gait by one entry
    /// per name in [`Gait::displacements`].
    ///
    /// # Errors
    /// [`Fault::LinkageSingular`] near a pose where the linkage does not assemble.
    pub fn angles<S: Scalar>(&self, phase: Jet<S>, displacement: &[Jet<S>]) -> Result<WingAngles<S>, Fault> {
        match self {
            Self::Fourier { shoulder, elbow } => Ok(WingAngles {
                shoulder: shoulder.angle(phase) + displacement[0],
                elbow: elbow.angle(phase) + displacement[1],
            }),
            Self::Linkage(linkage) => {
                let pose = linkage.pose(phase, [displacement[0], displacement[1], displacement[2]])?;
                Ok(WingAngles { shoulder: pose.humerus, elbow: pose.radius - pose.humerus })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Dual;

    #[test]
    fn fourier_rates_are_derivatives_and_the_extremes_are_known() {
        let gait = Gait::Fourier {
            shoulder: FourierSeries::single(0.1, 0.95, 0.0),
            elbow: FourierSeries {
                mean_rad: -0.65,
                harmonics: vec![
                    Harmonic { amplitude_rad: -0.65, phase_rad: 3.9 },
                    Harmonic { amplitude_rad: 0.1, phase_rad: 0.4 },
                ],
            },
        };
        assert_eq!(gait.angles(Jet::<f64>::from(0.0), &[Jet::ZERO; 2]).unwrap().shoulder.x, 1.05);
        let rate = 21.0;
        let t = Dual::<1, Dual<1>> { re: Dual::variable(0.4, 0), eps: [Dual::constant(1.0)] };
        let phase = Jet::new(t * rate, Dual::ZERO, Dual::ZERO);
        let moved = gait.angles(phase, &[Jet::ZERO; 2]).unwrap();
        let exact = gait.angles(Jet::new(0.4 * rate, rate, 0.0), &[Jet::ZERO; 2]).unwrap();
        for (a, b) in [(moved.shoulder.x, exact.shoulder), (moved.elbow.x, exact.elbow)] {
            assert!((a.re.eps[0] - b.d).abs() < 1e-12);
            assert!((a.eps[0].eps[0] - b.dd).abs() < 1e-9);
        }
    }
}
