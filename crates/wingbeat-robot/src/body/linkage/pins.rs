//! The pins between the bodies of the linkage that turn to and fro. Those of the crank turn all the way round.

use super::Directions;
use crate::body::Planar;
use serde::{Deserialize, Serialize};
use wingbeat_math::{Jet, Scalar};

/// A pin of the linkage, called by what it joins; its angle is that of the second body against the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LinkagePin {
    /// Body and humerus, at `p5_m`.
    Shoulder,
    /// Humerus and radius.
    Elbow,
    /// Body and bell crank, at `p8_m`.
    BellCrank,
    /// Coupler and humerus, where `l2a_m` ends.
    CouplerHumerus,
    /// Coupler and the rod `l4_m`.
    CouplerRod,
    /// The rod `l4_m` and the bell crank.
    RodBellCrank,
    /// Bell crank and the rod `l6_m`.
    BellCrankRod,
    /// The rod `l6_m` and the radius.
    RodRadius,
}

impl LinkagePin {
    /// Number of pins.
    pub const COUNT: usize = 8;

    /// Its name in files and records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shoulder => "shoulder",
            Self::Elbow => "elbow",
            Self::BellCrank => "bell_crank",
            Self::CouplerHumerus => "coupler_humerus",
            Self::CouplerRod => "coupler_rod",
            Self::RodBellCrank => "rod_bell_crank",
            Self::BellCrankRod => "bell_crank_rod",
            Self::RodRadius => "rod_radius",
        }
    }

    /// Its angle within half a turn of `middle`, rad, from the directions of the bodies.
    ///
    /// Equation: body.linkage_pin
    /// `theta = arg(e_b conj(e_a)), e_a and e_b the directions of the bodies that the pin joins`
    /// Source: complex numbers in the plane of the linkage.
    /// Test: `pins_turn_as_the_bodies_that_they_join`.
    #[inline(never)]
    pub fn angle<S: Scalar>(self, e: &Directions<S>, middle: f64) -> Jet<S> {
        let against = |of: Planar<S>, first: Planar<S>| of * first.conjugate();
        let turn = match self {
            Self::Shoulder => e.e5,
            Self::BellCrank => e.e8,
            Self::Elbow => against(e.e6, e.e5),
            Self::CouplerHumerus => against(e.e5, e.e2),
            Self::CouplerRod => against(e.e3, e.e2),
            Self::RodBellCrank => against(e.e8, e.e3),
            Self::BellCrankRod => against(e.e9, e.e8),
            Self::RodRadius => against(e.e6, e.e9),
        };
        turn.angle_about(middle)
    }
}
