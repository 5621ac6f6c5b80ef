//! A flap at the trailing edge of a surface: what a surface says of it, its numbers, and Theodorsen's functions of its hinge.

use super::Planform;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{DeclaredQuantity, Error, Parameters, Scalar, Walk};

/// A flap on a hinge along a surface that the pressure difference turns against a spring, on every strip by itself. Preset `full` only.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct FlapSpec {
    /// Chord of the flap over that of the wing.
    pub chord_fraction: f64,
    /// Moment of its spring over angle and span, N/rad.
    pub stiffness_n_rad: f64,
    /// Mass over area of the flap, an even sheet, kg/m2; the links' masses have to hold it too.
    pub areal_density_kg_m2: f64,
    /// Time in which the spring's own damping lets the flap follow it, s.
    #[serde(default = "damping")]
    pub damping_s: f64,
    /// Angle at which the spring bears nothing, deg; trailing edge down is positive.
    #[serde(default)]
    pub rest_deg: f64,
    /// Arc length from the root at which it begins, m; the root where not given.
    #[serde(default)]
    pub from_arc_m: f64,
    /// Arc length at which it ends, m; the tip where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_arc_m: Option<f64>,
}

/// A tenth of the period of a flap of 16 Hz over 2 pi; a choice.
fn damping() -> f64 {
    1e-3
}

const STIFFNESS_RANGE: Range = Range::between(0.0, 1e4);
const DENSITY_RANGE: Range = Range::over(0.0, 1e4);
const DAMPING_RANGE: Range = Range::between(0.0, 10.0);
const REST_DEG: f64 = 60.0;

ranges!(FlapSpec {
    chord_fraction: Range::between(0.05, 0.8),
    stiffness_n_rad: STIFFNESS_RANGE,
    areal_density_kg_m2: DENSITY_RANGE,
    damping_s: DAMPING_RANGE,
    rest_deg: Range::between(-REST_DEG, REST_DEG),
    from_arc_m: Range::NOT_NEGATIVE,
    to_arc_m: Range::POSITIVE,
});

impl FlapSpec {
    /// Refuses values without physical meaning.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()
    }

    /// Refuses an end beyond the tip of that outline.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn end_within(&self, planform: &Planform) -> Result<(), Error> {
        let tip = planform.station_arcs().last().copied().unwrap_or_default();
        match self.to_arc_m.filter(|end| *end > tip * (1.0 + 1e-9)) {
            Some(end) => {
                Err(Error::invalid("flap.to_arc_m", end, format!("at most {tip}, the arc of the tip")))
            }
            None => Ok(()),
        }
    }

    /// The numbers that may carry derivatives, as set.
    pub fn numbers(&self) -> FlapNumbers {
        FlapNumbers {
            stiffness: self.stiffness_n_rad,
            areal_density: self.areal_density_kg_m2,
            damping: self.damping_s,
            rest: self.rest_deg.to_radians(),
        }
    }

    /// Whether it lies at the arc `arc` from the root, m.
    pub(super) fn covers(&self, arc: f64) -> bool {
        arc >= self.from_arc_m && self.to_arc_m.is_none_or(|end| arc <= end)
    }
}

/// Numbers of a flap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlapNumbers<P: Scalar = f64> {
    /// Moment of its spring over angle and span, N/rad.
    pub stiffness: P,
    /// Mass over area, kg/m2.
    pub areal_density: P,
    /// Time of the spring's own damping, s.
    pub damping: P,
    /// Angle at which the spring bears nothing, rad.
    pub rest: P,
}

const STIFFNESS: DeclaredQuantity = DeclaredQuantity::within("N/rad", STIFFNESS_RANGE, 0.0, 1e4);
const AREAL_DENSITY: DeclaredQuantity = DeclaredQuantity::within("kg/m2", DENSITY_RANGE, 1e-6, 1e4);
const DAMPING: DeclaredQuantity = DeclaredQuantity::within("s", DAMPING_RANGE, 0.0, 10.0);
const REST: DeclaredQuantity = DeclaredQuantity::within("rad", Range::between(-1.05, 1.05), -1.05, 1.05);

impl<P: Scalar> Parameters<P> for FlapNumbers<P> {
    type In<Q: Scalar> = FlapNumbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> FlapNumbers<Q> {
        FlapNumbers {
            stiffness: at.number("stiffness_n_rad", &STIFFNESS, self.stiffness),
            areal_density: at.number("areal_density_kg_m2", &AREAL_DENSITY, self.areal_density),
            damping: at.number("damping_s", &DAMPING, self.damping),
            rest: at.number("rest_rad", &REST, self.rest),
        }
    }
}

/// What the thin-aerofoil theory of a flap hinged at x = c b says, b the half chord, x from mid chord towards the trailing edge; angle and
/// rate are positive with the trailing edge down. All are numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HingeFunctions {
    /// Place c of the hinge.
    pub place: f64,
    /// Lifting wash at 3/4 chord by the angle over V, T10/pi, and by the rate over b, T11/(2 pi).
    pub wash: [f64; 2],
    /// What the angle takes of that wash at the leading edge, over V: T20/pi, T20 = sqrt(1 - c^2).
    pub nose: f64,
    /// Impulse over pi rho b^2 by V times the angle, -T4/pi.
    pub impulse: f64,
    /// Mass that couples flap and heave over pi rho b^3, -T1/pi; flap and pitch about mid chord over pi rho b^4, 2 T13/pi; the flap's own over
    /// pi rho b^4, -T3/pi^2.
    pub masses: [f64; 3],
    /// Nose-up couple about mid chord but that of the lift: over rho b^2 V^2 by the angle, T4 + T10, and over pi rho b^3 V by the rate,
    /// (T1 - T8 - c T4 + T11/2)/pi; both are nose down.
    pub couple: [f64; 2],
    /// Hinge moment over the lift of the circulation times b, T12/(2 pi), up.
    pub lifted: f64,
    /// Hinge moment over rho b^2 V^2 by the angle, (T5 - T4 T10)/pi, up.
    pub held: f64,
    /// Hinge moment over pi rho b^3 V, by the rate, T4 T11/(2 pi^2), and by the pitch rate, (2 T9 + T4/2)/pi; both down.
    pub damped: [f64; 2],
}

impl HingeFunctions {
    /// Of a flap of that chord over that of the wing. With the wash w at mid chord, whose rate holds V q, and the pitch rate q,
    /// M = -d/dt[-rho b^3 T1 w + 2 T13 rho b^4 q - (T3/pi) rho b^4 beta'] + rho b^3 (2 T9 + T4/2) V q - rho b^2 V^2 (T5 - T4 T10)/pi beta +
    /// rho b^3 V T4 T11/(2 pi) beta' - rho V b^2 T12 w_l for each span, positive with the trailing edge down; T9 with the axis at mid chord.
    ///
    /// Equation: aero.flap
    /// `w_l = C(w34 + T10/pi V beta + T11/(2 pi) b beta'), impulse -T1 rho b^3 beta' - T4 rho b^2 V beta, T1 to T13 of the hinge's place`
    /// Source: Theodorsen 1935, NACA Rep. 496 (axis at mid chord); suction Garrick 1936, NACA Rep. 567; slope and moment at rest Glauert
    /// 1927, R. & M. 1095.
    /// Test: `hinge_functions_are_the_integrals_of_thin_aerofoil_theory`.
    pub fn new(chord_fraction: f64) -> Self {
        let c = 1.0 - 2.0 * chord_fraction;
        let (root, arc) = ((1.0 - c * c).sqrt(), c.acos());
        let t1 = -root * (2.0 + c * c) / 3.0 + c * arc;
        let t3 = -(1.0 - c * c) * (5.0 * c * c + 4.0) / 8.0 + c * (7.0 + 2.0 * c * c) * root * arc / 4.0
            - (0.125 + c * c) * arc * arc;
        let t4 = -arc + c * root;
        let t5 = -(1.0 - c * c) - arc * arc + 2.0 * c * root * arc;
        let t7 = -(0.125 + c * c) * arc + c * root * (7.0 + 2.0 * c * c) / 8.0;
        let t8 = -root * (2.0 * c * c + 1.0) / 3.0 + c * arc;
        let twice_t9 = root * root * root / 3.0;
        let (t10, t11) = (root + arc, arc * (1.0 - 2.0 * c) + root * (2.0 - c));
        let t12 = root * (2.0 + c) - arc * (2.0 * c + 1.0);
        let twice_t13 = -t7 - c * t1;
        Self {
            place: c,
            wash: [t10 / PI, t11 / (2.0 * PI)],
            nose: root / PI,
            impulse: -t4 / PI,
            masses: [-t1 / PI, twice_t13 / PI, -t3 / (PI * PI)],
            couple: [t4 + t10, (t1 - t8 - c * t4 + 0.5 * t11) / PI],
            lifted: t12 / (2.0 * PI),
            held: (t5 - t4 * t10) / PI,
            damped: [t4 * t11 / (2.0 * PI * PI), (twice_t9 + 0.5 * t4) / PI],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over the chord with x = -cos t: a potential of the jump sum B_n phi_n of the wash sum B_n cos n t, phi_0 = sin t, phi_1 = (sin 2t)/4,
    /// phi_n = [sin (n + 1) t/(n + 1) - sin (n - 1) t/(n - 1)]/2.
    struct Chord {
        cells: usize,
        terms: usize,
    }

    impl Chord {
        fn angles(&self) -> impl Iterator<Item = f64> + '_ {
            (0..self.cells).map(|k| (k as f64 + 0.5) * PI / self.cells as f64)
        }

        /// Coefficients of a wash over x.
        fn series(&self, wash: impl Fn(f64) -> f64) -> Vec<f64> {
            let share = |n: usize| if n == 0 { 1.0 } else { 2.0 } / self.cells as f64;
            let term = |n: usize| self.angles().map(|t| wash(-t.cos()) * (n as f64 * t).cos()).sum::<f64>();
            (0..self.terms).map(|n| share(n) * term(n)).collect()
        }

        /// Integral over x of a load over the potential, twice the potential of the `series` times `weight`.
        fn potential(&self, series: &[f64], weight: impl Fn(f64) -> f64) -> f64 {
            let shape = |n: usize, t: f64| {
                let sine = |m: usize| (m as f64 * t).sin() / m as f64;
                match n {
                    0 => t.sin(),
                    1 => 0.25 * (2.0 * t).sin(),
                    n => 0.5 * (sine(n + 1) - sine(n - 1)),
                }
            };
            let at = |t: f64| series.iter().enumerate().map(|(n, b)| b * shape(n, t)).sum::<f64>();
            let sum: f64 = self.angles().map(|t| at(t) * weight(-t.cos()) * t.sin()).sum();
            2.0 * sum * PI / self.cells as f64
        }
    }

    #[test]
    fn hinge_functions_are_the_integrals_of_thin_aerofoil_theory() {
        let chord = Chord { cells: 3200, terms: 80 };
        for fraction in [0.2, 0.45, 0.7] {
            let of = HingeFunctions::new(fraction);
            let c = of.place;
            let behind = |x: f64| if x > c { x - c } else { 0.0 };
            let (angle, rate) = (|x: f64| if x > c { 1.0 } else { 0.0 }, behind);
            let near = |found: f64, exact: f64, what: &str| {
                assert!((found - exact).abs() < 2e-3, "{fraction} {what}: {found} {exact}");
            };
            let series = [chord.series(angle), chord.series(rate)];
            for (k, b) in series.iter().enumerate() {
                near(of.wash[k], b[0] - 0.5 * b[1], "wash");
            }
            near(of.nose, of.wash[0] - series[0][0], "nose");
            near(of.impulse * PI, chord.potential(&series[0], |_| 1.0), "impulse");
            near(of.masses[0] * PI, chord.potential(&series[1], |_| 1.0), "heave");
            near(of.masses[1] * PI, chord.potential(&series[1], |x| x), "pitch");
            near(of.masses[2] * PI, chord.potential(&series[1], behind), "own");
            let heave = chord.series(|_| 1.0);
            near(of.masses[0] * PI, chord.potential(&heave, behind), "reciprocal heave");
            // By parts, V d/dx of the potential: no Kutta condition yet, which the lift brings. Q = b0 - b1/2 of each wash presses with
            // 2 rho V Q x/sqrt(1 - x^2) besides.
            let besides = |b: &[f64], weight: &dyn Fn(f64) -> f64| {
                let sum: f64 = chord.angles().map(|t| -t.cos() * weight(-t.cos())).sum();
                2.0 * (b[0] - 0.5 * b[1]) * sum * PI / chord.cells as f64
            };
            let steady = |b: &[f64], weight: &dyn Fn(f64) -> f64, slope: &dyn Fn(f64) -> f64| {
                besides(b, weight) - chord.potential(b, slope)
            };
            near(of.couple[0], steady(&series[0], &|x| x, &|_| 1.0), "couple of the angle");
            near(of.held, steady(&series[0], &behind, &angle), "hinge moment of the angle");
            let shifted = chord.potential(&series[0], |x| x);
            near(of.couple[1] * PI, steady(&series[1], &|x| x, &|_| 1.0) + shifted, "couple of the rate");
            let shifted = chord.potential(&series[0], behind);
            near(-of.damped[0] * PI, steady(&series[1], &behind, &angle) + shifted, "damping");
            let pitch = chord.series(|x| x);
            near(-of.damped[1] * PI, steady(&pitch, &behind, &angle), "damping by the pitch rate");
            let lift = chord.angles().map(|t| behind(-t.cos()) * (1.0 + t.cos())).sum::<f64>();
            near(of.lifted, lift / chord.cells as f64, "lift on the hinge");
        }
    }
}
