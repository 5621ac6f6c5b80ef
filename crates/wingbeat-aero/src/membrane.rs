//! A skin that gives way: what a surface says of it, and its numbers.

use crate::membrane_height;
use serde::{Deserialize, Serialize};
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{DeclaredQuantity, Error, Parameters, Scalar, Walk};

/// A membrane between leading and trailing edge of a surface: every strip is cambered by the pressure difference as far as the
/// tension lets it. Preset `full` only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct MembraneSpec {
    /// Thickness, m.
    pub thickness_m: f64,
    /// Young's modulus, Pa.
    pub modulus_pa: f64,
    /// Density, kg/m3; the links' masses have to hold the membrane's too.
    pub density_kg_m3: f64,
    /// Strain of the flat membrane at rest along the chord, dimensionless; negative is slack, by which it is longer than the
    /// chord.
    #[serde(default)]
    pub prestrain: f64,
    /// Strain of the flat membrane along the span where ribs hold it, dimensionless; `prestrain` where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prestrain_span: Option<f64>,
    /// Poisson's ratio; acts between ribs.
    #[serde(default = "poisson_ratio")]
    pub poisson_ratio: f64,
    /// Time in which the membrane's own damping lets it follow its tension, s.
    #[serde(default = "damping")]
    pub damping_s: f64,
    /// Arc lengths from the root at which a rib holds the membrane to the chord, m; between two of them it is tense along the span
    /// too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ribs_m: Vec<f64>,
}

/// Of rubber and films; a choice.
fn poisson_ratio() -> f64 {
    0.4
}

/// Some periods of a taut membrane of small size; a choice.
fn damping() -> f64 {
    2e-3
}

const PRESTRAIN_RANGE: Range = Range::between(-0.2, 1.0);
const DAMPING_RANGE: Range = Range::between(1e-5, 10.0);

ranges!(MembraneSpec {
    thickness_m: Range::over(0.0, 0.1),
    modulus_pa: Range::over(0.0, 1e12),
    density_kg_m3: Range::between(0.0, 1e5),
    prestrain: PRESTRAIN_RANGE,
    prestrain_span: PRESTRAIN_RANGE,
    poisson_ratio: Range::between(0.0, 0.5),
    damping_s: DAMPING_RANGE,
    ribs_m: Range::NOT_NEGATIVE,
});

impl MembraneSpec {
    /// Refuses values without physical meaning.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()
    }

    /// Its keys that act between ribs alone and are not as where they are left out, with their values, dimensionless.
    pub fn of_ribs(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let span = self.prestrain_span.filter(|span| *span != self.prestrain);
        let ratio = Some(self.poisson_ratio).filter(|ratio| *ratio != poisson_ratio());
        [("prestrain_span", span), ("poisson_ratio", ratio)]
            .into_iter()
            .filter_map(|(key, value)| Some((key, value?)))
    }

    /// The numbers that may carry derivatives, as set.
    pub fn numbers(&self) -> MembraneNumbers {
        MembraneNumbers {
            stiffness: self.modulus_pa * self.thickness_m,
            areal_density: self.density_kg_m3 * self.thickness_m,
            prestrain: self.prestrain,
            prestrain_span: self.prestrain_span.unwrap_or(self.prestrain),
            poisson_ratio: self.poisson_ratio,
            damping: self.damping_s,
        }
    }
}

/// Numbers of a membrane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MembraneNumbers<P: Scalar = f64> {
    /// Tension over strain E t, N/m.
    pub stiffness: P,
    /// Mass over area, kg/m2.
    pub areal_density: P,
    /// Strain of the flat membrane along the chord, dimensionless.
    pub prestrain: P,
    /// And along the span, dimensionless.
    pub prestrain_span: P,
    /// Poisson's ratio.
    pub poisson_ratio: P,
    /// Time of the membrane's own damping, s.
    pub damping: P,
}

const STIFFNESS: DeclaredQuantity = DeclaredQuantity::within("N/m", Range::over(0.0, 1e11), 1e-3, 1e11);
const AREAL_DENSITY: DeclaredQuantity = DeclaredQuantity::within("kg/m2", Range::NOT_NEGATIVE, 0.0, 1e4);
const PRESTRAIN: DeclaredQuantity = DeclaredQuantity::within("", PRESTRAIN_RANGE, -0.2, 1.0);
const POISSON_RATIO: DeclaredQuantity = DeclaredQuantity::within("", Range::between(0.0, 0.5), 0.0, 0.5);
const DAMPING: DeclaredQuantity = DeclaredQuantity::within("s", DAMPING_RANGE, 1e-5, 10.0);

impl<P: Scalar> Parameters<P> for MembraneNumbers<P> {
    type In<Q: Scalar> = MembraneNumbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> MembraneNumbers<Q> {
        MembraneNumbers {
            stiffness: at.number("stiffness_n_m", &STIFFNESS, self.stiffness),
            areal_density: at.number("areal_density_kg_m2", &AREAL_DENSITY, self.areal_density),
            prestrain: at.number("prestrain", &PRESTRAIN, self.prestrain),
            prestrain_span: at.number("prestrain_span", &PRESTRAIN, self.prestrain_span),
            poisson_ratio: at.number("poisson_ratio", &POISSON_RATIO, self.poisson_ratio),
            damping: at.number("damping_s", &DAMPING, self.damping),
        }
    }
}

/// Largest size of [`membrane_height`] over the chord, by tenths of it around the middle.
pub fn membrane_rise(camber: f64, forward: f64) -> f64 {
    [0.3, 0.4, 0.5, 0.6, 0.7]
        .into_iter()
        .map(|x| membrane_height(camber, forward, x).abs())
        .fold(0.0, f64::max)
}

/// Places over the chord, from the leading edge, of the points of a membrane that are drawn.
pub const MEMBRANE_DRAWN: [f64; 3] = [0.25, 0.5, 0.75];
