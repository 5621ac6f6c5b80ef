//! What the lifting line is made of.

use super::{JONES_RATES, JONES_WEIGHTS};
use crate::{LagNumbers, LiftLaw, MAX_STRIPS, ProfileDrag, SectionSettings, SurfaceNumbers};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};

/// The speed by which the reduced time of preset `as_printed` runs.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum LagSpeed {
    /// The paper's definition: of each section the velocity of its quarter chord perpendicular to the sweep.
    #[default]
    Section,
    /// The paper's approximation where the free stream is much faster than the flapping: one airspeed for the wing.
    Stream,
}

/// What turns the lift of preset `as_printed` from the normal to the wind of motion.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum LiftTilt {
    /// The effective wash: the downwash of equation (2), lagged as (4) lags it.
    #[default]
    Wash,
    /// The downwash of equation (2) alone.
    Downwash,
    /// Nothing: no induced drag.
    None,
}

/// What the lifting line is made of.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LiftingLineSettings {
    /// Interior nodes over the full span, 3 to 32.
    pub nodes: usize,
    /// Airspeed below which the flow quantities are rounded off, m/s.
    pub regularisation_m_s: f64,
    /// Smallest chord, m.
    pub chord_floor_m: f64,
    /// The paper's equations (1) to (4) as printed: one airspeed for the whole wing, and coefficients whose rates lack that
    /// of the airspeed.
    pub as_printed: bool,
    /// Speed of its reduced time.
    pub lag_speed: LagSpeed,
    /// What turns its lift.
    pub lift_tilt: LiftTilt,
    /// Section and air.
    pub section: SectionSettings,
}

impl Default for LiftingLineSettings {
    fn default() -> Self {
        Self {
            nodes: 12,
            regularisation_m_s: 0.1,
            chord_floor_m: 0.01,
            as_printed: false,
            lag_speed: LagSpeed::Section,
            lift_tilt: LiftTilt::Wash,
            section: SectionSettings::default(),
        }
    }
}

ranges!(LiftingLineSettings {
    nodes: Range::between(3.0, MAX_STRIPS as f64),
    regularisation_m_s: Range::POSITIVE,
    chord_floor_m: Range::POSITIVE,
});

impl LiftingLineSettings {
    /// These settings with the terms that the printed equations hold, and no others; no drag of sections.
    pub fn printed(self) -> Self {
        let section = SectionSettings {
            law: LiftLaw::Linear,
            drag: ProfileDrag { cd0: 0.0, cd90: 0.0 },
            added_mass: false,
            section_moment: false,
            pitch_suction: false,
            ..self.section
        };
        Self { as_printed: true, section, ..self }
    }

    /// The numbers that may carry derivatives, as set.
    pub fn numbers(&self) -> SurfaceNumbers {
        let lags = JONES_WEIGHTS.iter().zip(JONES_RATES);
        self.section.numbers(lags.map(|(&weight, rate)| LagNumbers { weight, rate }).collect())
    }

    /// Refuses values without physical meaning.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        self.section.check()
    }
}
