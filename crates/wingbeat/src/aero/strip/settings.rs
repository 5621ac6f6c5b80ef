//! What can be chosen in the strip model; each ingredient is a switch, so that
//! its effect can be shown.

use super::constants::{FIVE_LAGS, Lags, THREE_LAGS};
use crate::Error;
use crate::aero::law::{
    CD0, CD90, CRITICAL_SUCTION, LIFT_SLOPE, STALL_ANGLE, ZERO_LIFT_ANGLE, check_section,
};
use crate::aero::{LiftLaw, MAX_STRIPS, ProfileDrag, SurfaceNumbers};
use crate::range::{Range, ranges};
use serde::{Deserialize, Serialize};

/// Which set of lags the model carries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LagSet {
    /// Two wash lags, one wake lag: three states per strip.
    #[default]
    Three,
    /// Three wash lags, two wake lags: five states per strip; circulation
    /// within 8 % instead of 25 %.
    Five,
}

impl LagSet {
    /// The constants of the set.
    pub fn lags(self) -> &'static Lags {
        match self {
            LagSet::Three => &THREE_LAGS,
            LagSet::Five => &FIVE_LAGS,
        }
    }
}

/// Settings of [`StripModel`](super::StripModel).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StripSettings {
    /// Number of strips over both wings and body.
    pub strips: usize,
    /// Arc coordinates of the half wing that must have a strip edge (hinges), m.
    pub hinge_arcs_m: Vec<f64>,
    /// Air density, kg/m3.
    pub density_kg_m3: f64,
    /// Speed below which directions lose their meaning, m/s; smooths every root.
    pub regularisation_m_s: f64,
    /// Lags carried per strip.
    pub lags: LagSet,
    /// Three-dimensional wash of bound and shed circulation; off: strips of an
    /// infinite wing.
    pub wake_wash: bool,
    /// Three-dimensional wash of the potential jump on the chord.
    pub doublet_wash: bool,
    /// Rates of that wash as the wing folds, in the force of the carried air.
    pub folding_rates: bool,
    /// Distance at which the wash of a vortex on a strip is half faded, over the distance at which the
    /// two pass on the flat wing: 0.01 to 0.5.
    pub vortex_core: f64,
    /// Turning of the force by the wash of wake and lags: induced drag.
    pub force_tilt: bool,
    /// Reaction of the accelerated air.
    pub added_mass: bool,
    /// Moment of the pitching section beyond the added-mass force.
    pub section_moment: bool,
    /// Leading-edge suction that the section's rate of pitch adds.
    pub pitch_suction: bool,
    /// Lift law.
    pub law: LiftLaw,
    /// Incidence beyond which the wing counts as stalled, rad; laws `stall` and
    /// `lev` have their largest attached lift there.
    pub stall_angle_rad: f64,
    /// Leading-edge suction parameter A0 beyond which the edge holds no more suction; law `lev`.
    pub critical_suction: f64,
    /// Incidence of the chord at which the section bears no lift, rad.
    pub zero_lift_angle_rad: f64,
    /// Lift slope of the section in plane flow, 1/rad.
    pub section_slope: f64,
    /// Profile drag.
    pub drag: ProfileDrag,
}

impl Default for StripSettings {
    fn default() -> Self {
        Self {
            strips: 16,
            hinge_arcs_m: Vec::new(),
            density_kg_m3: 1.225,
            regularisation_m_s: 0.02,
            lags: LagSet::Three,
            wake_wash: true,
            doublet_wash: true,
            folding_rates: false,
            vortex_core: 0.3,
            force_tilt: true,
            added_mass: true,
            section_moment: true,
            pitch_suction: true,
            law: LiftLaw::Linear,
            stall_angle_rad: STALL_ANGLE.default.to_radians(),
            critical_suction: CRITICAL_SUCTION.default,
            zero_lift_angle_rad: ZERO_LIFT_ANGLE.default.to_radians(),
            section_slope: LIFT_SLOPE.default,
            drag: ProfileDrag { cd0: CD0.default, cd90: CD90.default },
        }
    }
}

ranges!(StripSettings {
    strips: Range::between(1.0, MAX_STRIPS as f64),
    density_kg_m3: Range::POSITIVE,
    regularisation_m_s: Range::POSITIVE,
    vortex_core: Range::between(0.01, 0.5),
});

impl StripSettings {
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
            lags: self.lags.lags().numbers(),
            outline: None,
            hinges: Vec::new(),
        }
    }

    /// Refuses values without physical meaning.
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
