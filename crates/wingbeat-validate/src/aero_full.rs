//! The strip model of folding wings, and the same comparisons with the paper's
//! lifting line, which are shown without a limit.

mod flapping;
pub(crate) mod lattice;
pub(crate) mod linear;
mod mean;
mod small;
pub(crate) mod wings;

pub use flapping::{
    Comparison, E1, F2, added_mass_lift, last_cycle, lattice_lift, oracle_series, reduced_frequency, small_flap_lift,
};
pub use linear::Complex;
pub use mean::{STATIC_DRAG, Thrust, induced_over_trefftz, scherer_points, scherer_thrust};
pub use small::{Point, SpanLoading, other_points, plunge_points, slope_points, span_loadings, step_points};

use crate::{Case, Error, Row};
use wingbeat::aero::{
    Aero, LagSet, LiftingLine, LiftingLineSettings, Planform, ProfileDrag, StripModel, StripSettings,
};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "aero.full.slope", quick: true, run: || small::slope(Preset::Full) },
    Case { id: "aero.full.plunge", quick: true, run: || small::plunge(Preset::Full) },
    Case { id: "aero.full.step", quick: true, run: || small::step(Preset::Full) },
    Case { id: "aero.full.other_wings", quick: true, run: || small::other_wings(Preset::Full) },
    Case { id: "aero.full.span_loading", quick: false, run: || small::span_loading(Preset::Full) },
    Case { id: "aero.full.trefftz", quick: true, run: mean::trefftz },
    Case { id: "aero.full.oracle", quick: true, run: flapping::oracle },
    Case { id: "aero.full.added_mass_mean", quick: true, run: || flapping::added_mass_mean(Preset::Full) },
    Case { id: "aero.scherer", quick: true, run: || mean::scherer(Preset::Full) },
    Case { id: "aero.uvlm_small_flap", quick: true, run: || flapping::lattice(Preset::Full) },
    Case { id: "aero.five_lags.slope", quick: true, run: || small::slope(Preset::FiveLags) },
    Case { id: "aero.five_lags.plunge", quick: true, run: || small::plunge(Preset::FiveLags) },
    Case { id: "aero.five_lags.step", quick: true, run: || small::step(Preset::FiveLags) },
    Case { id: "aero.five_lags.other_wings", quick: true, run: || small::other_wings(Preset::FiveLags) },
    Case { id: "aero.five_lags.span_loading", quick: false, run: || small::span_loading(Preset::FiveLags) },
    Case { id: "aero.five_lags.scherer", quick: true, run: || mean::scherer(Preset::FiveLags) },
    Case { id: "aero.paper.slope", quick: true, run: || small::slope(Preset::Paper) },
    Case { id: "aero.paper.plunge", quick: true, run: || small::plunge(Preset::Paper) },
    Case { id: "aero.paper.step", quick: true, run: || small::step(Preset::Paper) },
    Case { id: "aero.paper.other_wings", quick: true, run: || small::other_wings(Preset::Paper) },
    Case { id: "aero.paper.added_mass_mean", quick: true, run: || flapping::added_mass_mean(Preset::Paper) },
    Case { id: "aero.paper.scherer", quick: true, run: || mean::scherer(Preset::Paper) },
    Case { id: "aero.paper.uvlm_small_flap", quick: true, run: || flapping::lattice(Preset::Paper) },
];

/// The models under comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Strip model, three states per strip: the default.
    Full,
    /// Strip model, five states per strip.
    FiveLags,
    /// The paper's lifting line.
    Paper,
}

/// Strips or nodes in all comparisons.
const STRIPS: usize = 16;

impl Preset {
    /// The id of a comparison: `aero.<preset>.<name>`.
    fn id(self, name: &str) -> String {
        format!("aero.{}.{name}", self.name())
    }

    /// Its name in ids and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::FiveLags => "five_lags",
            Self::Paper => "paper",
        }
    }

    /// A row judged by `limit` for the default, shown without a judgement for the others.
    fn row(self, id: &str, source: &str, metric: &str, value: f64, limit: f64) -> Row {
        match self {
            Self::Full => Row::judged(id, source, metric, value, limit, ""),
            _ => Row::shown(id, source, metric, value, ""),
        }
    }

    /// The inviscid model of `wing`, with strip edges at `hinges` (arcs, m), in air of
    /// density `density` kg/m3; speeds below `least` m/s are rounded off.
    fn model(self, wing: &Planform, hinges: &[f64], density: f64, least: f64) -> Result<Aero, Error> {
        self.model_of(STRIPS, wing, hinges, density, least)
    }

    /// The same with another number of strips or nodes.
    pub(crate) fn model_of(
        self,
        strips: usize,
        wing: &Planform,
        hinges: &[f64],
        density: f64,
        least: f64,
    ) -> Result<Aero, Error> {
        let drag = ProfileDrag { cd0: 0.0, cd90: 0.0 };
        if self == Self::Paper {
            let settings = LiftingLineSettings {
                nodes: strips,
                drag,
                density_kg_m3: density,
                regularisation_m_s: least,
                chord_floor_m: 1e-9,
                ..Default::default()
            };
            return Ok(Aero::LiftingLine(LiftingLine::new(wing, settings)?));
        }
        let settings = StripSettings {
            strips,
            hinge_arcs_m: hinges.to_vec(),
            drag,
            density_kg_m3: density,
            regularisation_m_s: least,
            lags: if self == Self::Full { LagSet::Three } else { LagSet::Five },
            ..Default::default()
        };
        Ok(Aero::Strip(StripModel::new(wing, settings)?))
    }
}
