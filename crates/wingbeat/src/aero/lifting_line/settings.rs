//! What the lifting line is made of.

use super::{JONES_RATES, JONES_WEIGHTS};
use crate::Error;
use crate::aero::law::{
    CD0, CD90, CRITICAL_SUCTION, LIFT_SLOPE, STALL_ANGLE, ZERO_LIFT_ANGLE, check_section,
};
use crate::aero::{LagNumbers, LiftLaw, MAX_STRIPS, ProfileDrag, SurfaceNumbers};
use crate::range::{Range, ranges};

/// What the lifting line is made of.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LiftingLineSettings {
    /// Interior nodes over the full span, 3 to 32.
    pub nodes: usize,
    /// Lift slope of the section in plane flow, 1/rad.
    pub section_slope: f64,
    /// Incidence of the chord at which the section bears no lift, rad.
    pub zero_lift_angle_rad: f64,
    /// Airspeed below which the flow quantities are rounded off, m/s.
    pub regularisation_m_s: f64,
    /// Smallest chord, m.
    pub chord_floor_m: f64,
    /// Lift law.
    pub law: LiftLaw,
    /// Incidence beyond which the wing counts as stalled, rad; laws `stall` and
    /// `lev` have their largest attached lift there.
    pub stall_angle_rad: f64,
    /// Leading-edge suction parameter A0 beyond which the edge holds no more suction; law `lev`.
    pub critical_suction: f64,
    /// Profile drag.
    pub drag: ProfileDrag,
    /// Reaction of the accelerated air.
    pub added_mass: bool,
    /// Moment of pitching about the quarter chord.
    pub section_moment: bool,
    /// Leading-edge suction that the section's rate of pitch adds; the paper has none.
    pub pitch_suction: bool,
    /// The paper's equations (1) to (4) as printed: one airspeed for the whole wing, coefficients whose rates lack that of
    /// the airspeed, lift normal to the wind of motion, and no other force.
    pub as_printed: bool,
    /// Air density, kg/m3.
    pub density_kg_m3: f64,
}

impl Default for LiftingLineSettings {
    fn default() -> Self {
        Self {
            nodes: 12,
            section_slope: LIFT_SLOPE.default,
            zero_lift_angle_rad: ZERO_LIFT_ANGLE.default.to_radians(),
            regularisation_m_s: 0.1,
            chord_floor_m: 0.01,
            law: LiftLaw::Linear,
            stall_angle_rad: STALL_ANGLE.default.to_radians(),
            critical_suction: CRITICAL_SUCTION.default,
            drag: ProfileDrag { cd0: CD0.default, cd90: CD90.default },
            added_mass: true,
            section_moment: true,
            pitch_suction: true,
            as_printed: false,
            density_kg_m3: 1.225,
        }
    }
}

ranges!(LiftingLineSettings {
    nodes: Range::between(3.0, MAX_STRIPS as f64),
    regularisation_m_s: Range::POSITIVE,
    chord_floor_m: Range::POSITIVE,
    density_kg_m3: Range::POSITIVE,
});

impl LiftingLineSettings {
    /// These settings with the terms that the printed equations hold, and no others.
    pub fn printed(self) -> Self {
        Self {
            as_printed: true,
            law: LiftLaw::Linear,
            drag: ProfileDrag { cd0: 0.0, cd90: 0.0 },
            added_mass: false,
            section_moment: false,
            pitch_suction: false,
            ..self
        }
    }

    /// The numbers that may carry derivatives, as set.
    pub fn numbers(&self) -> SurfaceNumbers {
        SurfaceNumbers {
            density: self.density_kg_m3,
            section_slope: self.section_slope,
            zero_lift_angle: self.zero_lift_angle_rad,
            cd0: self.drag.cd0,
            cd90: self.drag.cd90,
            stall_angle: self.stall_angle_rad,
            critical_suction: self.critical_suction,
            added_mass_scale: 1.0,
            lags: JONES_WEIGHTS
                .iter()
                .zip(JONES_RATES)
                .map(|(&weight, rate)| LagNumbers { weight, rate })
                .collect(),
            outline: None,
            hinges: Vec::new(),
        }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
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
