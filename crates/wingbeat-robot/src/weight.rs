//! What carries the weight of a robot: the vertical forces of the air and of thrusters, by part.

use super::{Observation, Robot};
use wingbeat_math::{GRAVITY, Vec3};

/// A part of the forces on a flying robot, in the order of [`WeightPart::ALL`]; together they are all but weight and inertia.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WeightPart {
    /// Normal force of the attached flow. In a flight coupled to the vortex lattice all that the lattice gives.
    Attached,
    /// Leading-edge suction of the attached flow, along the zero-lift line.
    Suction,
    /// Normal force of the leading-edge vortex (law `lev`).
    Vortex,
    /// What `cd90` gives: the normal force of separated flow, or under law `linear` the drag of the plate.
    Separated,
    /// What `cd0` gives: profile drag.
    Friction,
    /// The tilt of the attached lift by the downwash of wake and lags.
    Wash,
    /// Reaction of the accelerated air.
    AddedMass,
    /// Drag of the body.
    BodyDrag,
    /// What `robot.residual` adds, learned from measured loads.
    Residual,
    /// Thrusters.
    Thrust,
}

impl WeightPart {
    /// All parts.
    pub const ALL: [Self; 10] = [
        Self::Attached,
        Self::Suction,
        Self::Vortex,
        Self::Separated,
        Self::Friction,
        Self::Wash,
        Self::AddedMass,
        Self::BodyDrag,
        Self::Residual,
        Self::Thrust,
    ];

    /// Name as written in columns and summaries.
    pub fn name(self) -> &'static str {
        match self {
            Self::Attached => "attached",
            Self::Suction => "suction",
            Self::Vortex => "vortex",
            Self::Separated => "separated",
            Self::Friction => "friction",
            Self::Wash => "wash",
            Self::AddedMass => "added_mass",
            Self::BodyDrag => "body_drag",
            Self::Residual => "residual",
            Self::Thrust => "thrust",
        }
    }

    /// What it is, for tables and legends, of a robot with these [words](Robot::broadside_words) for what `cd90` gives.
    pub fn words(self, broadside: &'static str) -> &'static str {
        match self {
            Self::Attached => "attached flow",
            Self::Suction => "leading-edge suction",
            Self::Vortex => "leading-edge vortex",
            Self::Separated => broadside,
            Self::Friction => "profile drag (cd0)",
            Self::Wash => "tilt by the downwash",
            Self::AddedMass => "added mass",
            Self::BodyDrag => "drag of the body",
            Self::Residual => "robot.residual",
            Self::Thrust => "thrusters",
        }
    }
}

/// What `cd90` gives under laws of both kinds, or under a law that is not known.
pub const BROADSIDE: &str = "broadside force (cd90)";

impl Robot {
    /// What `cd90` gives in words: of flow that separates, or under law `linear`, which knows none, the drag of a plate broadside on.
    pub fn broadside_words(&self) -> &'static str {
        let any = |separates: bool| self.surfaces().any(|(_, aero)| aero.law().separates() == separates);
        match (any(true), any(false)) {
            (true, false) => "separated flow (cd90)",
            (false, true) => "broadside drag (cd90)",
            _ => BROADSIDE,
        }
    }
}

/// Shares of the weight by part, in the order of [`WeightPart::ALL`].
pub type WeightShares = [f64; WeightPart::ALL.len()];

impl Observation {
    /// The upward force of each part over the weight of a robot of `mass` kg: s_i = (R_WB F_i)_z / (m g). The sum of the shares
    /// is the upward force of air and thrusters over the weight; of a periodic level flight its mean is 1.
    ///
    /// Equation: robot.weight_shares
    /// `s_i = (R_WB F_i)_z / (m g), F_i the force of each part`
    /// Source: definition.
    /// Test: `the_shares_of_the_weight_sum_to_the_upward_force`.
    pub fn weight_shares(&self, mass: f64) -> WeightShares {
        let (air, detail) = (&self.air, &self.detail);
        let force = |part: WeightPart| -> Vec3 {
            match part {
                WeightPart::Attached => air.circulatory.force - detail.suction - detail.vortex,
                WeightPart::Suction => detail.suction,
                WeightPart::Vortex => detail.vortex,
                WeightPart::Separated => detail.plate,
                WeightPart::Friction => air.profile_drag.force - detail.plate,
                WeightPart::Wash => air.induced_drag.force,
                WeightPart::AddedMass => air.added_mass.force,
                WeightPart::BodyDrag => self.body_drag.force - self.residual.force,
                WeightPart::Residual => self.residual.force,
                WeightPart::Thrust => self.thrust.force,
            }
        };
        WeightPart::ALL.map(|part| (self.attitude * force(part))[2] / (mass * GRAVITY))
    }
}
