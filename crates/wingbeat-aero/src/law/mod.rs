//! Section laws: what becomes of lift and suction as the angle of attack grows, and the profile drag.
//!
//! A law is one file here and one arm of [`LiftLaw`]. Beside its physics the file declares as data what the law is,
//! which parameters of the section it asks for and which states each strip carries for it; configurations, records
//! and pages read it there.

mod count;
mod drag;
mod kinds;
pub(super) mod lev;
mod lev3d;
mod linear;
mod stall;

pub use count::{StallCount, StallShares};
pub use drag::ProfileDrag;

use crate::SurfaceNumbers;
use std::f64::consts::{FRAC_PI_2, PI};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Meets, Over, Scalar};

// A law is a file of its own, its name among those above, and its arm here.
kinds::laws! {
    /// Lift proportional to the wash at any angle of attack: the paper's law, which
    /// knows no stall. Valid below the stall angle.
    Linear: linear,
    /// Flat, thin wing at low Reynolds number (1e3 to 1e5): the attached lift
    /// fades with the flow's separation and the normal force of a plate in
    /// separated flow takes its place (Hoerner 1965, ch. 3; Dickinson, Lehmann
    /// & Sane 1999). Quasi-steady: no dynamic-stall vortex is shed, so it errs
    /// where the angle of attack crosses the stall angle faster than about a chord
    /// of travel, and at thick or strongly cambered sections.
    Stall: stall,
    /// The leading edge holds suction up to its critical parameter; what it loses
    /// becomes the normal force of a leading-edge vortex, and separation lags behind
    /// the effective angle of attack (Polhamus 1966; Goman & Khrabrov 1994; Ramesh et al.
    /// 2014). Two states per strip.
    Lev: lev,
    /// As `lev`, for wings of finite aspect ratio: the separated flow bears the normal force of a plate of that aspect
    /// ratio (Lindenburg 2001), and the static stall follows from the critical suction.
    Lev3d: lev3d,
}

/// What a law is and does to a section, beside what all do.
pub(super) trait Section {
    /// What it is, as data.
    const LAW: Law;

    /// Scale of [`stall::attached_share`] for the static share of the attached lift.
    fn separation<P: Scalar>(numbers: &SurfaceNumbers<P>) -> P {
        stall::scale(numbers.stall_angle)
    }

    /// Normal force of the separated flow over cd90 and the sine of the angle of attack, where it is not 1; `relief` is what the ends of a
    /// plate of the surface's aspect ratio take.
    #[inline]
    fn broadside<P, G: Scalar + Meets<P>>(_absolute_sine: G, _relief: P) -> Option<G> {
        None
    }
}

/// What a law is, as data.
#[derive(Debug)]
pub struct Law {
    /// Name as written in configurations and results.
    pub name: &'static str,
    /// What it says, in one line.
    pub meaning: &'static str,
    /// What it asks of the section.
    pub parameters: &'static [Parameter],
    /// What each strip carries for it, in order.
    pub states: &'static [StripState],
    /// Which share of the lift stays attached.
    pub attachment: Attachment,
    /// True when the leading edge holds limited suction and sheds a vortex, whose normal force is the first of the
    /// states.
    pub edge_vortex: bool,
    /// Angle of attack up to which it holds, deg, where that is not the stall angle.
    pub holds_to_deg: Option<f64>,
    /// What it does past that angle, as the end of a sentence.
    pub beyond: &'static str,
}

/// How a law tells the share of the lift that stays attached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attachment {
    /// All of it.
    Whole,
    /// By the angle of attack of the moment.
    AtOnce,
    /// One less a state of the strip, the separated share, which follows what [`AtOnce`](Self::AtOnce) would
    /// separate.
    Lagging {
        /// Which of the law's states.
        state: usize,
        /// Chords of travel in which it follows.
        chords: f64,
    },
}

/// A number of the section that a law asks for.
#[derive(Debug)]
pub struct Parameter {
    /// Key in configurations.
    pub key: &'static str,
    /// Unit; empty when dimensionless.
    pub unit: &'static str,
    /// What it may be.
    pub range: Range,
    /// Value where none is given, in `unit`: a thin, flat plate at Reynolds numbers of 1e3 to 1e5.
    pub default: f64,
    /// What it is.
    pub meaning: &'static str,
    /// Where the default comes from.
    pub source: &'static str,
}

/// A state that a law adds to every strip.
#[derive(Debug)]
pub struct StripState {
    /// Name; the number of the strip follows.
    pub name: &'static str,
    /// Unit; empty when it is a share.
    pub unit: &'static str,
    /// What it is, as a table of results names it.
    pub meaning: &'static str,
}

/// Angle of attack past which no law was compared with a measurement, deg: plates at rest reach 29, a pitched one 45 (Mancini et al. 2017).
pub const UNTESTED_DEG: f64 = 45.0;

/// Angle of attack at which the attached lift is largest.
pub const STALL_ANGLE: Parameter = Parameter {
    key: "stall_angle_deg",
    unit: "deg",
    range: Range::inside(0.0, 90.0),
    default: 12.0,
    meaning: "angle of attack at which the attached lift is largest",
    source: "Mueller 1999, flat plates at 1e4",
};

/// Leading-edge suction parameter A0 beyond which the leading edge holds no more suction.
pub const CRITICAL_SUCTION: Parameter = Parameter {
    key: "critical_suction",
    unit: "",
    range: Range::inside(0.0, 1.0),
    default: 0.11,
    meaning: "leading-edge suction parameter A0 beyond which the leading edge holds no more suction",
    source: "Ramesh et al. 2014, flat plate at 1e3 to 1e4",
};

/// Angle of attack at which the section bears no lift.
pub const ZERO_LIFT_ANGLE: Parameter = Parameter {
    key: "zero_lift_angle_deg",
    unit: "deg",
    range: Range::inside(-30.0, 30.0),
    default: 0.0,
    meaning: "angle of attack of the chord at which the section bears no lift; negative with camber upward",
    source: "a section without camber",
};

/// Lift slope of the section in plane flow.
pub const LIFT_SLOPE: Parameter = Parameter {
    key: "lift_slope_per_rad",
    unit: "1/rad",
    // Below 2 pi/3 the strip model's lags would hold less circulation than the chord's own doublet.
    range: Range::between(2.1, 12.0),
    default: 2.0 * PI,
    meaning: "lift slope of the section in plane flow",
    source: "thin section, 2 pi",
};

/// Drag coefficient of skin friction.
pub const CD0: Parameter = Parameter {
    key: "cd0",
    unit: "",
    range: Range::between(0.0, 2.0),
    default: 0.05,
    meaning: "drag coefficient along the wind at zero angle of attack",
    source: "laminar plate, both sides, 2.66/sqrt(Re) at 3e3",
};

/// Drag coefficient of the plate broadside on.
pub const CD90: Parameter = Parameter {
    key: "cd90",
    unit: "",
    range: Range::NOT_NEGATIVE,
    default: 2.0,
    meaning: "drag coefficient broadside on",
    source: "Hoerner 1965, ch. 3, infinite plate 1.98",
};

impl Parameter {
    /// Refuses `value`, in the unit of the parameter, outside the range, under the parameter's key.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn check(&self, value: f64) -> Result<(), Error> {
        self.range.check(self.key, value)
    }
}

impl LiftLaw {
    /// Name as written in configurations and results.
    pub fn name(self) -> &'static str {
        self.about().name
    }

    /// What each strip carries for it.
    #[inline]
    pub fn states(self) -> &'static [StripState] {
        self.about().states
    }

    /// Angle of attack up to which it holds, rad, of a section with the stall angle `stall_angle`, rad.
    pub fn holds_to(self, stall_angle: f64) -> f64 {
        self.about().holds_to_deg.map_or(stall_angle, f64::to_radians)
    }

    /// True when the flow separates under it, so that it takes the force broadside from `cd90`.
    #[inline]
    pub fn separates(self) -> bool {
        self.about().attachment != Attachment::Whole
    }
}

ranges!(SectionSpec {
    stall_angle_deg: STALL_ANGLE.range,
    critical_suction: CRITICAL_SUCTION.range,
    zero_lift_angle_deg: ZERO_LIFT_ANGLE.range,
    lift_slope_per_rad: LIFT_SLOPE.range,
});

/// What a surface says of its section; what it leaves out the scenario says for all surfaces.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct SectionSpec {
    /// Angle of attack at which the attached lift is largest, deg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stall_angle_deg: Option<f64>,
    /// Dimensionless leading-edge suction parameter A0 beyond which the edge holds no more suction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub critical_suction: Option<f64>,
    /// Angle of attack of the chord at which the section bears no lift, deg; negative with camber upward.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zero_lift_angle_deg: Option<f64>,
    /// Lift slope of the section in plane flow, 1/rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lift_slope_per_rad: Option<f64>,
}

impl SectionSpec {
    /// Refuses values outside the ranges that the laws declare.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()
    }

    /// True when nothing is said.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A law with the constants of a section, ready for the inner loops.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polar<P> {
    law: LiftLaw,
    /// Fourth power of 1/sine at which half of the lift stays attached.
    separation: P,
    /// One over the largest suction coefficient, 1/(a0 A0c^2).
    inverse_limit: P,
    /// What the ends of a plate of the surface's aspect ratio take from its normal force.
    end_relief: P,
}

impl<P: Scalar> Polar<P> {
    /// The law of a surface of the aspect ratio `aspect`.
    pub fn new(law: LiftLaw, numbers: &SurfaceNumbers<P>, aspect: P) -> Self {
        let limit = numbers.section_slope * numbers.critical_suction * numbers.critical_suction;
        let separation = law.separation(numbers);
        Self { law, separation, inverse_limit: limit.recip(), end_relief: lev3d::end_relief(aspect) }
    }

    /// The same with its numbers turned by `f`.
    #[inline]
    pub fn map<Q>(&self, f: impl Fn(P) -> Q) -> Polar<Q> {
        Polar {
            law: self.law,
            separation: f(self.separation),
            inverse_limit: f(self.inverse_limit),
            end_relief: f(self.end_relief),
        }
    }

    /// Rate of the separated share, s' = V (s_0 - s)/(tau_s c), s_0 (`still`) the static share and tau_s `chords`.
    ///
    /// Equation: aero.separation_lag
    /// `s' = V (s_0 - s)/(tau_s c), tau_s = 8 in law lev`
    /// Source: Goman & Khrabrov 1994, J. Aircraft 31(5); the length a choice.
    /// Test: `states_follow_in_their_chords_of_travel`.
    #[inline]
    pub fn separation_rate<G: Scalar, S: Over<G>>(
        separated: S,
        still: S,
        chords_per_second: G,
        chords: f64,
    ) -> S {
        (still - separated) * (chords_per_second * chords.recip())
    }

    /// Static share of separated flow, from the squared sine of the effective angle of attack.
    #[inline]
    pub fn separated_share<S: Scalar + Meets<P>>(&self, sine_squared: S) -> S {
        S::ONE - self.attached_share(sine_squared)
    }

    /// Share of the lift that stays attached, or would if the flow had time, from the squared sine of the
    /// effective angle of attack.
    #[inline]
    pub fn attached_share<S: Scalar + Meets<P>>(&self, sine_squared: S) -> S {
        match self.law.about().attachment {
            Attachment::Whole => S::ONE,
            Attachment::AtOnce | Attachment::Lagging { .. } => {
                stall::attached_share(sine_squared, self.separation)
            }
        }
    }
}

/// Refuses stall angles outside (0, pi/2), rad, and zero-lift angles (rad), lift slopes and critical suction
/// parameters outside their range.
pub(super) fn check_section(
    stall_angle_rad: f64,
    critical_suction: f64,
    zero_lift_angle_rad: f64,
    section_slope: f64,
) -> Result<(), Error> {
    CRITICAL_SUCTION.check(critical_suction)?;
    ZERO_LIFT_ANGLE.check(zero_lift_angle_rad.to_degrees())?;
    LIFT_SLOPE.check(section_slope)?;
    if stall_angle_rad > 0.0 && stall_angle_rad < FRAC_PI_2 {
        return Ok(());
    }
    Err(Error::invalid("stall_angle_rad", stall_angle_rad, "between 0 and pi/2"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_say_what_they_are() {
        for law in LiftLaw::ALL {
            let about = law.about();
            assert_eq!(toml::Value::try_from(law).unwrap().as_str(), Some(about.name));
            for p in about.parameters {
                p.check(p.default).unwrap();
                assert!(p.check(-100.0).is_err() && p.check(f64::NAN).is_err(), "{}", p.key);
                assert!(!p.meaning.is_empty() && !p.source.is_empty());
            }
        }
    }
}
