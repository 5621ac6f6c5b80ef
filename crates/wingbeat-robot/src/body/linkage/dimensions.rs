//! Dimensions of the linkage as data.

use wingbeat_math::Error;
use wingbeat_math::range::Range;
use wingbeat_math::{DeclaredQuantity, Jet, Meets, NamedNumber, Parameters, Scalar, Walk};

use serde::{Deserialize, Serialize};

/// Most that a regulated link may be lengthened: a factor.
const LONGEST: f64 = 1e3;

/// Lengths, fixed pivots (y outboard, z up) and actuator ranges of one wing's
/// linkage. The default is the published design of Aerobat's computational structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(
    rename = "LinkageDimensions",
    bound = "P: schemars::JsonSchema + Serialize, LinkageDimensions<P>: Default"
)]
#[serde(
    deny_unknown_fields,
    default,
    bound(deserialize = "P: Deserialize<'de>, LinkageDimensions<P>: Default", serialize = "P: Serialize")
)]
pub struct LinkageDimensions<P = f64> {
    /// Crank.
    pub l1_m: P,
    /// Coupler, from crank to humerus.
    pub l2a_m: P,
    /// Coupler, from crank to the rod of the bell crank, along.
    pub l2b_m: P,
    /// Coupler, from crank to the rod of the bell crank, across.
    pub l2c_m: P,
    /// Humerus, from shoulder to elbow.
    pub l3a_m: P,
    /// Humerus, from shoulder to the coupler, along; changes the flapping amplitude.
    pub l3b_m: P,
    /// Humerus, from shoulder to the coupler, across.
    pub l3c_m: P,
    /// Angle of the humerus against its coupler arm.
    pub a3_deg: P,
    /// Rod between coupler and bell crank.
    pub l4_m: P,
    /// Bell crank, from pivot to its rod, along; regulates the fold.
    pub l5a_m: P,
    /// Bell crank, from pivot to its rod, across; regulates the fold.
    pub l5b_m: P,
    /// Bell crank, from pivot to the rod of the radius, along.
    pub l5c_m: P,
    /// Bell crank, from pivot to the rod of the radius, across.
    pub l5d_m: P,
    /// Rod between bell crank and radius.
    pub l6_m: P,
    /// Radius, from elbow to tip.
    pub l7a_m: P,
    /// Radius, from elbow to its rod, along.
    pub l7b_m: P,
    /// Radius, from elbow to its rod, across.
    pub l7c_m: P,
    /// Pivot of the crank.
    pub p1_m: [P; 2],
    /// Shoulder.
    pub p5_m: [P; 2],
    /// Pivot of the bell crank.
    pub p8_m: [P; 2],
    /// Turn of the whole mechanism about the shoulder, positive raises the wing; the crank's angle turns with it.
    pub turned_deg: P,
    /// Smallest and largest `l3b_m` as multiples of the nominal one.
    pub l3b_range: [P; 2],
    /// The same of `l5a_m`.
    pub l5a_range: [P; 2],
    /// The same of `l5b_m`.
    pub l5b_range: [P; 2],
}

impl Default for LinkageDimensions {
    fn default() -> Self {
        let (sin35, cos35) = 35f64.to_radians().sin_cos();
        let (sin20, cos20) = 20f64.to_radians().sin_cos();
        let (sin25, cos25) = 25f64.to_radians().sin_cos();
        Self {
            l1_m: 7.5e-3,
            l2a_m: 35e-3,
            l2b_m: 5e-3 * cos35,
            l2c_m: 5e-3 * sin35,
            l3a_m: 50e-3,
            l3b_m: 6.71e-3,
            l3c_m: 6e-3,
            a3_deg: -15.0,
            l4_m: 36e-3,
            l5a_m: 11.18e-3,
            l5b_m: 10e-3,
            l5c_m: 78.78e-3,
            l5d_m: -3.89e-3,
            l6_m: 36e-3,
            l7a_m: 90e-3,
            l7b_m: 35e-3,
            l7c_m: 15e-3,
            p1_m: [-10e-3, -9.8e-3],
            p5_m: [22e-3 * cos20, 22e-3 * sin20],
            p8_m: [22e-3 * sin25, 22e-3 * cos25],
            turned_deg: 0.0,
            l3b_range: [0.876, 3.0],
            l5a_range: [0.876, 1.648],
            l5b_range: [0.876, 1.166],
        }
    }
}

/// A regulated length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Regulated<P> {
    /// Nominal length, m.
    pub(super) nominal: P,
    factors: [P; 2],
}

impl<P: Scalar> Regulated<P> {
    /// Smallest and largest length, m.
    #[inline]
    pub(super) fn range(&self) -> [P; 2] {
        let [low, high] = self.factors;
        [low * self.nominal, high * self.nominal]
    }
    /// The length displaced by `displacement`, held within its range.
    #[inline]
    pub(super) fn displaced<S: Scalar + Meets<P>>(&self, displacement: Jet<S>) -> Jet<S> {
        let (length, [low, high]) = (displacement.shifted(self.nominal), self.range());
        let (low, high) = (Jet::constant(S::from(low)), Jet::constant(S::from(high)));
        length.if_below(low, low, high.if_below(length, high, length))
    }
}

impl<P: Scalar> LinkageDimensions<P> {
    /// L3b, L5a and L5b.
    pub(super) fn regulated(&self) -> [Regulated<P>; 3] {
        [
            Regulated { nominal: self.l3b_m, factors: self.l3b_range },
            Regulated { nominal: self.l5a_m, factors: self.l5a_range },
            Regulated { nominal: self.l5b_m, factors: self.l5b_range },
        ]
    }
}

/// Length of a link.
const LENGTH: DeclaredQuantity = DeclaredQuantity { range: Range::POSITIVE, ..PLACE };
/// Coordinate of a joint.
const PLACE: DeclaredQuantity = DeclaredQuantity::free("m");
/// Angle within a link.
const ANGLE: DeclaredQuantity = DeclaredQuantity::free("deg");
/// Turn of the whole mechanism.
const TURN: DeclaredQuantity = DeclaredQuantity::within("deg", Range::between(-180.0, 180.0), -180.0, 180.0);
/// Shortest and longest length of a regulated link as factors.
const FACTORS: [DeclaredQuantity; 2] = [
    DeclaredQuantity::within("", Range::over(0.0, 1.0), 0.0, 1.0),
    DeclaredQuantity::within("", Range::between(1.0, LONGEST), 1.0, LONGEST),
];

/// The numbers that decide the pose.
impl<P: Scalar> Parameters<P> for LinkageDimensions<P> {
    type In<Q: Scalar> = LinkageDimensions<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> LinkageDimensions<Q> {
        LinkageDimensions {
            l1_m: at.number("l1_m", &LENGTH, self.l1_m),
            l2a_m: at.number("l2a_m", &LENGTH, self.l2a_m),
            l2b_m: at.number("l2b_m", &PLACE, self.l2b_m),
            l2c_m: at.number("l2c_m", &PLACE, self.l2c_m),
            l3a_m: at.number("l3a_m", &LENGTH, self.l3a_m),
            l3b_m: at.number("l3b_m", &LENGTH, self.l3b_m),
            l3c_m: at.number("l3c_m", &PLACE, self.l3c_m),
            a3_deg: at.number("a3_deg", &ANGLE, self.a3_deg),
            l4_m: at.number("l4_m", &LENGTH, self.l4_m),
            l5a_m: at.number("l5a_m", &LENGTH, self.l5a_m),
            l5b_m: at.number("l5b_m", &LENGTH, self.l5b_m),
            l5c_m: at.number("l5c_m", &PLACE, self.l5c_m),
            l5d_m: at.number("l5d_m", &PLACE, self.l5d_m),
            l6_m: at.number("l6_m", &LENGTH, self.l6_m),
            // No load and no surface knows where the radius ends.
            l7a_m: at.fixed(self.l7a_m),
            l7b_m: at.number("l7b_m", &PLACE, self.l7b_m),
            l7c_m: at.number("l7c_m", &PLACE, self.l7c_m),
            p1_m: at.array("p1_m", &[PLACE; 2], self.p1_m),
            p5_m: at.array("p5_m", &[PLACE; 2], self.p5_m),
            p8_m: at.array("p8_m", &[PLACE; 2], self.p8_m),
            turned_deg: at.number("turned_deg", &TURN, self.turned_deg),
            l3b_range: at.array("l3b_range", &FACTORS, self.l3b_range),
            l5a_range: at.array("l5a_range", &FACTORS, self.l5a_range),
            l5b_range: at.array("l5b_range", &FACTORS, self.l5b_range),
        }
    }
}

impl LinkageDimensions {
    /// The keys that say where a loop closes.
    pub(super) const KEYS: [&str; 23] = [
        "l1_m", "l2a_m", "l2b_m", "l2c_m", "l3a_m", "l3b_m", "l3c_m", "a3_deg", "l4_m", "l5a_m", "l5b_m",
        "l5c_m", "l5d_m", "l6_m", "l7b_m", "l7c_m", "l7a_m", "p1_m[0]", "p1_m[1]", "p5_m[0]", "p5_m[1]",
        "p8_m[0]", "p8_m[1]",
    ];

    /// Checks each dimension by itself.
    pub(super) fn check(&self) -> Result<(), Error> {
        LENGTH.range.check("l7a_m", self.l7a_m)?;
        self.named(&|_, _, _| None).iter().try_for_each(NamedNumber::check)
    }
}
