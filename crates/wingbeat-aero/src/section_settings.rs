//! What both models are told of section and air.

use super::law::{CD0, CD90, CRITICAL_SUCTION, LIFT_SLOPE, STALL_ANGLE, ZERO_LIFT_ANGLE, check_section};
use super::{LagNumbers, LiftLaw, MAX_WASH_LAGS, ProfileDrag, SurfaceNumbers};
use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Error, SEA_LEVEL_DENSITY};

/// Section, air, and the forces that a section takes from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SectionSettings {
    /// Lift law.
    pub law: LiftLaw,
    /// Lift slope of the section in plane flow, 1/rad.
    pub section_slope: f64,
    /// Incidence of the chord at which the section bears no lift, rad.
    pub zero_lift_angle_rad: f64,
    /// Incidence beyond which the wing counts as stalled, rad; laws `stall` and
    /// `lev` have their largest attached lift there.
    pub stall_angle_rad: f64,
    /// Dimensionless leading-edge suction parameter A0 beyond which the edge holds no more suction; law `lev`.
    pub critical_suction: f64,
    /// Profile drag.
    pub drag: ProfileDrag,
    /// Reaction of the accelerated air.
    pub added_mass: bool,
    /// Moment of the pitching section beyond the added-mass force.
    pub section_moment: bool,
    /// Leading-edge suction that the section's rate of pitch adds; the paper has none.
    pub pitch_suction: bool,
    /// Air density, kg/m3.
    pub density_kg_m3: f64,
}

impl Default for SectionSettings {
    fn default() -> Self {
        Self {
            law: LiftLaw::Linear,
            section_slope: LIFT_SLOPE.default,
            zero_lift_angle_rad: ZERO_LIFT_ANGLE.default.to_radians(),
            stall_angle_rad: STALL_ANGLE.default.to_radians(),
            critical_suction: CRITICAL_SUCTION.default,
            drag: ProfileDrag { cd0: CD0.default, cd90: CD90.default },
            added_mass: true,
            section_moment: true,
            pitch_suction: true,
            density_kg_m3: SEA_LEVEL_DENSITY,
        }
    }
}

ranges!(SectionSettings { density_kg_m3: Range::POSITIVE });

impl SectionSettings {
    /// The numbers that may carry derivatives, as set, with the `lags` of a model.
    pub(super) fn numbers(&self, lags: ArrayVec<LagNumbers, MAX_WASH_LAGS>) -> SurfaceNumbers {
        SurfaceNumbers {
            density: self.density_kg_m3,
            section_slope: self.section_slope,
            zero_lift_angle: self.zero_lift_angle_rad,
            cd0: self.drag.cd0,
            cd90: self.drag.cd90,
            stall_angle: self.stall_angle_rad,
            critical_suction: self.critical_suction,
            added_mass_scale: 1.0,
            lags,
            membrane: None,
            flap: None,
            outline: None,
            hinges: Vec::new(),
            webs: Vec::new(),
        }
    }

    /// Refuses values without physical meaning.
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        self.drag.check()?;
        check_section(
            self.stall_angle_rad,
            self.critical_suction,
            self.zero_lift_angle_rad,
            self.section_slope,
        )
    }
}
