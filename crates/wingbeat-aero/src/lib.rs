//! Aerodynamics of a flapping, folding wing: planform, station, section laws,
//! Wagner lags, lifting line, added mass. Knows no body: stations come in, loads go out.

// Its derive writes nothing: schemas are made by tests alone.
#[cfg(not(feature = "schema"))]
extern crate wingbeat_no_schema as schemars;

mod bend;
mod camber;
mod compiled;
mod flap;
mod law;
mod lifting_line;
mod loads;
mod membrane;
mod momentum;
mod numbers;
mod planform;
mod section;
mod section_settings;
mod station;
mod strip;
mod surfaces;

pub use bend::{ChordBend, flap_hinge, flap_points, membrane_height, membrane_points};
pub use camber::ThinSection;
pub use flap::{FlapNumbers, FlapSpec};
pub use law::{
    Attachment, CD0, CD90, CRITICAL_SUCTION, LIFT_SLOPE, Law, LiftLaw, Parameter, ProfileDrag, STALL_ANGLE,
    SectionSpec, StallCount, StallShares, StripState, ZERO_LIFT_ANGLE,
};
pub use lifting_line::{JONES_RATES, JONES_WEIGHTS, LagSpeed, LiftTilt, LiftingLine, LiftingLineSettings};
use loads::ImpulseRow;
pub use loads::{
    Circulation, Coupling, ForceDetail, ImpulseRates, LoadSource, Loads, MembraneWork, StripLoads,
};
pub use membrane::{MEMBRANE_DRAWN, MembraneNumbers, MembraneSpec, membrane_rise};
pub use momentum::induced_power;
pub use numbers::{AIR_DENSITY, DENSITY, LagNumbers, MAX_WASH_LAGS, SurfaceNumbers, walk_web};
pub use planform::{COORDINATE, Gap, Planform, PlanformStation, Span};
pub use section_settings::SectionSettings;
pub use station::{Ground, SectionField, SectionFields, SectionMotion, Sections};
pub use strip::{
    AngleMap, ByStates, LagSet, Lags, MembraneScales, SkinSheet, StripModel, StripSettings, StripSpacing,
    spacing as lan_spacing,
};
pub use surfaces::{Surface, Surfaces};
pub use wingbeat_math::Wrench;

use strip::{Others, Source, Wanted};
use wingbeat_math::Error;
use wingbeat_math::{Meets, Over, Scalar, Vec3};
use wingbeat_ocp::plant::Channel;

/// Largest number of strips of all surfaces together; loads live on the stack.
pub const MAX_STRIPS: usize = 32;
/// Largest number of surfaces of one robot.
pub const MAX_SURFACES: usize = 8;
/// Largest number of sections of all surfaces together: strips lie between sections.
pub const MAX_SECTIONS: usize = MAX_STRIPS + MAX_SURFACES;

/// Angle of attack, rad, from which a section meets the wind from behind rather than broadside on. *Choice.*
pub const FROM_BEHIND: f64 = 0.75 * std::f64::consts::PI;

/// The aerodynamic models by name.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// The paper's unsteady lifting line with nodal circulation, the local airspeed, added mass, section moment,
    /// suction of pitching and profile drag.
    Paper,
    /// The paper's equations (1) to (4) as printed, the reduced time by the velocity of each section; law `linear`.
    AsPrinted,
    /// Strip model with three-dimensional delayed wash.
    #[default]
    Full,
}

impl Preset {
    /// Name as written in configurations and results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::AsPrinted => "as_printed",
            Self::Full => "full",
        }
    }
}

/// The aerodynamic model of one surface.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "one per robot, never moved in a loop")]
pub enum Aero<P: Scalar = f64> {
    /// Presets `paper` and `as_printed`: unsteady lifting line.
    LiftingLine(LiftingLine<P>),
    /// Preset `full`: strip model with three-dimensional delayed wash.
    Strip(StripModel<P>),
}

impl<P: Scalar> Aero<P> {
    /// The numbers that may carry derivatives.
    pub fn numbers(&self) -> &SurfaceNumbers<P> {
        match self {
            Self::LiftingLine(line) => line.numbers(),
            Self::Strip(model) => model.numbers(),
        }
    }
    /// The same model with other numbers than its settings say.
    ///
    /// # Errors
    /// [`Error::Invalid`] when strips or nodes do not fit an outline.
    #[inline(never)]
    pub fn with<Q: Scalar>(&self, numbers: &SurfaceNumbers<Q>) -> Result<Aero<Q>, Error> {
        Ok(match self {
            Self::LiftingLine(line) => Aero::LiftingLine(line.with(numbers)?),
            Self::Strip(model) => Aero::Strip(model.with(numbers)?),
        })
    }
    /// The same model under another law.
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub fn under(&self, law: LiftLaw) -> Result<Self, Error> {
        Ok(match self {
            Self::LiftingLine(line) => Self::LiftingLine(line.under(law)?),
            Self::Strip(model) => Self::Strip(model.under(law)?),
        })
    }
    /// Arc coordinates where [`SectionMotion`]s are wanted, m, left tip
    /// (positive) to right tip.
    pub fn arcs(&self) -> &[P] {
        match self {
            Self::LiftingLine(line) => line.arcs(),
            Self::Strip(model) => model.arcs(),
        }
    }
    /// Arc coordinates of the strips' middles, m.
    pub fn strip_arcs(&self) -> &[P] {
        match self {
            Self::LiftingLine(line) => line.node_arcs(),
            Self::Strip(model) => model.strip_arcs(),
        }
    }
    /// Number of strips.
    pub fn strips(&self) -> usize {
        match self {
            Self::LiftingLine(line) => line.strips(),
            Self::Strip(model) => model.strips(),
        }
    }
    /// False of a strip `i` in a gap of the planform.
    pub fn covers(&self, i: usize) -> bool {
        match self {
            Self::LiftingLine(_) => true,
            Self::Strip(model) => model.covers(i),
        }
    }
    /// Number of states.
    pub fn states(&self) -> usize {
        match self {
            Self::LiftingLine(line) => line.states(),
            Self::Strip(model) => model.states(),
        }
    }
    /// Names and units of the states, in order.
    #[inline(never)]
    pub fn channels(&self) -> Vec<Channel> {
        match self {
            Self::LiftingLine(line) => line.channels(),
            Self::Strip(model) => model.channels(),
        }
    }
    /// The state of the other wing that stands for state `i`: strips are counted from left tip to right tip.
    pub fn mirrored(&self, i: usize) -> usize {
        let strips = self.strips();
        i - i % strips + (strips - 1 - i % strips)
    }
    /// Widths of the strips along the arc, m.
    pub fn widths(&self) -> &[P] {
        match self {
            Self::LiftingLine(line) => line.widths(),
            Self::Strip(model) => model.widths(),
        }
    }
    /// What [`Loads::circulation`] holds: three lags make no bound circulation.
    pub fn circulation(&self) -> Circulation {
        match self {
            Self::LiftingLine(_) => Circulation::Bound,
            Self::Strip(model) => match model.settings().lags {
                LagSet::Three => Circulation::LagSum,
                LagSet::Five => Circulation::Bound,
            },
        }
    }
    /// What others need to know of the surface, given its first section and strip among those of all; none
    /// where it neither sees nor is seen.
    fn source(&self, first_section: usize, first_strip: usize) -> Option<Source<P>> {
        match self {
            Self::Strip(model) if model.settings().wake_wash => {
                Some(model.source(first_section, first_strip))
            }
            _ => None,
        }
    }
    /// Sets states that follow the impulse of the air to that impulse and flaps to rest in their hinges, the other states as they are in
    /// `x`, under the wind `wind` (m/s, B): the surface has always moved as it does. From zero they would begin with the blow of an impulsive
    /// start.
    pub fn settle<S: Scalar + Meets<P>>(&self, sections: &impl Sections<S>, wind: Vec3<S>, x: &mut [S]) {
        if let Self::Strip(model) = self {
            model.settle(sections, wind, x);
        }
    }
    /// Whether [`settle`](Self::settle) sets states.
    fn settles(&self) -> bool {
        match self {
            Self::LiftingLine(_) => false,
            Self::Strip(model) => model.settles(),
        }
    }
    /// Whether states follow the impulse of the air.
    fn follows_impulse(&self) -> bool {
        match self {
            Self::LiftingLine(_) => false,
            Self::Strip(model) => model.follows(),
        }
    }
    /// Which model it is.
    pub fn preset(&self) -> Preset {
        match self {
            Self::LiftingLine(line) if line.settings().as_printed => Preset::AsPrinted,
            Self::LiftingLine(_) => Preset::Paper,
            Self::Strip(_) => Preset::Full,
        }
    }
    /// The strip model with a membrane, where that is what it is.
    pub fn membrane(&self) -> Option<&StripModel<P>> {
        match self {
            Self::Strip(model) if model.is_membrane() => Some(model),
            _ => None,
        }
    }
    /// The same model whose membrane moves as it is given: see [`StripModel::with_shapes_given`].
    fn with_shapes_given(&self) -> Self {
        match self {
            Self::LiftingLine(_) => self.clone(),
            Self::Strip(model) => Self::Strip(model.with_shapes_given()),
        }
    }
    /// The strip model with a flap, where that is what it is.
    pub fn flap(&self) -> Option<&StripModel<P>> {
        match self {
            Self::Strip(model) if model.has_flap() => Some(model),
            _ => None,
        }
    }
    /// What bends the chords of its strips, a membrane or flaps; none of another model.
    pub fn bent(&self) -> Option<&StripModel<P>> {
        self.membrane().or_else(|| self.flap())
    }

    /// Where the states lie that say how the chords of its strips are bent: see [`StripModel::bent_states`].
    pub fn bent_states(&self) -> std::ops::Range<usize> {
        match self {
            Self::LiftingLine(_) => 0..0,
            Self::Strip(model) => model.bent_states(),
        }
    }
    /// The lift law.
    pub fn law(&self) -> LiftLaw {
        match self {
            Self::LiftingLine(line) => line.settings().section.law,
            Self::Strip(model) => model.settings().section.law,
        }
    }
    /// Profile drag coefficient along the wind.
    pub fn cd0(&self) -> f64 {
        self.numbers().cd0.value()
    }
    /// Speed below which the model rounds speeds off, m/s.
    pub fn regularisation_m_s(&self) -> f64 {
        match self {
            Self::LiftingLine(line) => line.settings().regularisation_m_s,
            Self::Strip(model) => model.settings().regularisation_m_s,
        }
    }
    /// Incidence beyond which a strip counts as stalled, rad.
    pub fn stall_angle(&self) -> f64 {
        self.numbers().stall_angle.value()
    }
    /// State rates and loads of the sections at [`arcs`](Self::arcs) in air
    /// that moves with `wind` (resolved in B). See [`Loads`] for the body acceleration.
    pub fn evaluate<S: Scalar + Meets<P>>(
        &self,
        sections: &[SectionMotion<S>],
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        loads: &mut Loads<S>,
    ) {
        loads.clear();
        (loads.wrench, loads.added_mass) = self.append(&sections, wind, x, dx, None, loads);
    }
    /// Loads and state rates among `others`, of which preset `paper` knows nothing. Writes the loads by
    /// strip behind the strips that `loads` holds; returns the sum, which the other fields of `loads` do not get.
    fn append<S: Scalar + Meets<P>>(
        &self,
        sections: &impl Sections<S>,
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        others: Option<Others<'_, P, S, S>>,
        loads: &mut Loads<S>,
    ) -> (Wrench<S>, [[S; 6]; 6]) {
        match self {
            Self::LiftingLine(line) => line.append(sections, wind, x, dx, loads),
            Self::Strip(model) => {
                let wanted = Wanted { loads: Some(loads), coupling: None };
                model.evaluate_among::<S, S, S>(sections, wind, x, dx, others, wanted)
            }
        }
    }
    /// As [`evaluate`](Self::evaluate) for the sum alone: the wrench and the
    /// added-mass matrix. The states may carry more derivatives than the motion. `coupling` receives
    /// what the coordinates of `sections` take.
    pub fn evaluate_sum<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        sections: &impl Sections<G>,
        wind: Vec3<G>,
        x: &[S],
        dx: &mut [S],
        coupling: Option<Coupling<G, S>>,
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        self.sum::<G, G, S>(sections, wind, x, dx, None, coupling)
    }
    /// The same among `others`, of which preset `paper` knows nothing; the places of the sections carry the derivatives of `K` alone.
    fn sum<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, S: Over<G> + Over<K> + Meets<P>>(
        &self,
        sections: &impl Sections<G>,
        wind: Vec3<G>,
        x: &[S],
        dx: &mut [S],
        others: Option<Others<'_, P, G, S>>,
        coupling: Option<Coupling<'_, G, S>>,
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        match self {
            Self::LiftingLine(line) => line.evaluate_sum(sections, wind, x, dx, coupling),
            Self::Strip(model) => {
                let wanted = Wanted { loads: None, coupling };
                model.evaluate_among::<K, G, S>(sections, wind, x, dx, others, wanted)
            }
        }
    }
    /// The sections between which strip `i` lies, and the share of the second.
    pub fn strip_sections(&self, i: usize) -> ([usize; 2], P) {
        match self {
            Self::LiftingLine(_) => ([i, i], P::ZERO),
            Self::Strip(model) => ([i, i + 1], model.fraction(i)),
        }
    }
}
