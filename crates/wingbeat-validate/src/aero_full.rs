//! The strip model of folding wings, and the same comparisons with the paper's
//! lifting line, which are shown without a limit.

mod flapping;
mod flaps;
mod folds;
mod half_span;
mod impulse;
pub mod lattice;
pub mod linear;
mod mean;
mod plates;
mod small;
mod thrust;
pub mod wings;
pub(crate) mod yeo;

pub use flapping::{
    E1, F2, ForceComparison, added_mass_lift, last_cycle, lattice_lift, oracle_series, reduced_frequency,
    small_flap_lift,
};
pub use linear::Complex;
pub use mean::{
    STATIC_DRAG, Thrust, induced_over_trefftz, scherer_lev_thrust, scherer_points, scherer_thrust,
};
pub use plates::{Ramp, fast_pitch, steady_normal_force};
pub use small::{
    ComparedPoint, SpanLoading, other_points, plunge_points, slope_points, span_loadings, step_points,
};

use crate::{Case, ComparisonRow, Error};
use wingbeat::aero::{
    Aero, CD0, CD90, CRITICAL_SUCTION, LagSet, LiftLaw, LiftingLine, LiftingLineSettings, Planform,
    ProfileDrag, STALL_ANGLE, SectionSettings, StripModel, StripSettings,
};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "aero.full.slope", quick: true, run: || small::slope(ComparedPreset::Full) },
    Case { id: "aero.full.plunge", quick: true, run: || small::plunge(ComparedPreset::Full) },
    Case { id: "aero.full.step", quick: true, run: || small::step(ComparedPreset::Full) },
    Case { id: "aero.full.other_wings", quick: true, run: || small::other_wings(ComparedPreset::Full) },
    Case { id: "aero.full.folded_aerobat", quick: false, run: folds::folded_aerobat },
    Case { id: "aero.full.small_flap", quick: false, run: flaps::small_flap },
    Case { id: "aero.full.span_loading", quick: false, run: || small::span_loading(ComparedPreset::Full) },
    Case { id: "aero.full.trefftz", quick: true, run: mean::trefftz },
    Case { id: "aero.full.oracle", quick: true, run: flapping::oracle },
    Case {
        id: "aero.full.added_mass_mean",
        quick: true,
        run: || flapping::added_mass_mean(ComparedPreset::Full),
    },
    Case { id: "aero.full.added_mass_lift", quick: true, run: impulse::added_mass_lift },
    Case { id: "aero.full.half_span", quick: false, run: half_span::half_span },
    Case { id: "aero.full.deep_fold", quick: false, run: impulse::deep_fold },
    Case { id: "aero.full.pitch_thrust", quick: false, run: || thrust::pitch_thrust(ComparedPreset::Full) },
    Case { id: "aero.garrick", quick: false, run: || thrust::garrick_rows(ComparedPreset::Full) },
    Case {
        id: "aero.garrick.five_lags",
        quick: false,
        run: || thrust::garrick_rows(ComparedPreset::FiveLags),
    },
    Case { id: "aero.garrick.paper", quick: false, run: || thrust::garrick_rows(ComparedPreset::Paper) },
    Case { id: "aero.lev.scherer", quick: true, run: mean::scherer_lev },
    Case { id: "aero.yeo", quick: true, run: yeo::yeo },
    Case { id: "aero.plates", quick: true, run: plates::plates },
    Case { id: "aero.mancini", quick: true, run: plates::mancini },
    Case { id: "aero.side_edges", quick: true, run: plates::side_edges },
    Case { id: "aero.scherer", quick: true, run: || mean::scherer(ComparedPreset::Full) },
    Case { id: "aero.uvlm_small_flap", quick: true, run: || flapping::lattice(ComparedPreset::Full) },
    Case { id: "aero.five_lags.slope", quick: true, run: || small::slope(ComparedPreset::FiveLags) },
    Case { id: "aero.five_lags.plunge", quick: true, run: || small::plunge(ComparedPreset::FiveLags) },
    Case { id: "aero.five_lags.step", quick: true, run: || small::step(ComparedPreset::FiveLags) },
    Case {
        id: "aero.five_lags.other_wings",
        quick: true,
        run: || small::other_wings(ComparedPreset::FiveLags),
    },
    Case {
        id: "aero.five_lags.span_loading",
        quick: false,
        run: || small::span_loading(ComparedPreset::FiveLags),
    },
    Case { id: "aero.five_lags.scherer", quick: true, run: || mean::scherer(ComparedPreset::FiveLags) },
    Case { id: "aero.paper.slope", quick: true, run: || small::slope(ComparedPreset::Paper) },
    Case { id: "aero.paper.plunge", quick: true, run: || small::plunge(ComparedPreset::Paper) },
    Case { id: "aero.paper.step", quick: true, run: || small::step(ComparedPreset::Paper) },
    Case { id: "aero.paper.other_wings", quick: true, run: || small::other_wings(ComparedPreset::Paper) },
    Case {
        id: "aero.paper.added_mass_mean",
        quick: true,
        run: || flapping::added_mass_mean(ComparedPreset::Paper),
    },
    Case { id: "aero.paper.pitch_thrust", quick: false, run: || thrust::pitch_thrust(ComparedPreset::Paper) },
    Case { id: "aero.paper.scherer", quick: true, run: || mean::scherer(ComparedPreset::Paper) },
    Case { id: "aero.paper.uvlm_small_flap", quick: true, run: || flapping::lattice(ComparedPreset::Paper) },
];

/// The models under comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComparedPreset {
    /// Strip model, three states per strip: the default.
    Full,
    /// Strip model, five states per strip.
    FiveLags,
    /// That of three states with the impulse that turns in place of edges' suction.
    Turned,
    /// That of three states without a force of the circulation along the span.
    Neither,
    /// The paper's lifting line.
    Paper,
}

/// A law with what it asks of the section.
#[derive(Clone, Copy, Debug)]
pub struct SectionLaw {
    law: LiftLaw,
    stall_angle_deg: f64,
    critical_suction: f64,
    drag: ProfileDrag,
    side_edges: bool,
}

impl SectionLaw {
    /// Inviscid: law `linear` without drag.
    pub const INVISCID: Self = Self {
        law: LiftLaw::Linear,
        stall_angle_deg: STALL_ANGLE.default,
        critical_suction: CRITICAL_SUCTION.default,
        drag: ProfileDrag { cd0: 0.0, cd90: 0.0 },
        side_edges: false,
    };
    /// A thin plate under law `lev`, as the laws have it by default.
    pub const PLATE: Self = Self {
        law: LiftLaw::Lev,
        drag: ProfileDrag { cd0: CD0.default, cd90: CD90.default },
        ..Self::INVISCID
    };

    /// The same section under law `linear`.
    pub const fn linear(self) -> Self {
        Self { law: LiftLaw::Linear, ..self }
    }
    /// The same section under law `stall`.
    pub const fn stall(self) -> Self {
        Self { law: LiftLaw::Stall, ..self }
    }

    /// The same section under law `lev3d`.
    pub const fn lev3d(self) -> Self {
        Self { law: LiftLaw::Lev3d, ..self }
    }

    /// The same section with vortices above the side edges of the wing.
    pub const fn with_side_edges(self) -> Self {
        Self { side_edges: true, ..self }
    }

    /// The same section with the stall angle that follows from its critical suction: see [`stalling_at`](Self::stalling_at).
    pub fn stalling_with_the_edge(self) -> Self {
        let stall_angle_deg = (self.critical_suction * 3_f64.powf(0.25)).asin().to_degrees();
        Self { stall_angle_deg, ..self }
    }

    /// Under law `lev`, without skin friction, a section whose lift has fallen a tenth below its line at that incidence
    /// (degrees) in static, plane flow. Its leading edge holds the suction that thin-airfoil theory gives there, A0c = sin;
    /// nine tenths of the law's lift are attached there, 1/(1 + x^4/3) = 0.9 at x = 3^(-1/4) of the sine of its stall angle.
    pub fn stalling_at(static_stall_deg: f64) -> Self {
        let critical_suction = static_stall_deg.to_radians().sin();
        let drag = ProfileDrag { cd0: 0.0, cd90: CD90.default };
        Self { critical_suction, drag, ..Self::PLATE }.stalling_with_the_edge()
    }
}

/// Strips or nodes in all comparisons.
const STRIPS: usize = 16;

impl ComparedPreset {
    /// The id of a comparison: `aero.<preset>.<name>`.
    fn id(self, name: &str) -> String {
        format!("aero.{}.{name}", self.name())
    }

    /// Its name in ids and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full | Self::Turned | Self::Neither => "full",
            Self::FiveLags => "five_lags",
            Self::Paper => "paper",
        }
    }

    /// A row judged by `limit` for the default, shown without a judgement for the others.
    fn row(self, id: &str, source: &str, metric: &str, value: f64, limit: f64) -> ComparisonRow {
        match self {
            Self::Full => ComparisonRow::judged(id, source, metric, value, limit, ""),
            _ => ComparisonRow::shown(id, source, metric, value, ""),
        }
    }

    /// The inviscid model of `wing`, with strip edges at `hinges` (arcs, m), in air of
    /// density `density` kg/m3; speeds below `least` m/s are rounded off.
    pub fn model(self, wing: &Planform, hinges: &[f64], density: f64, least: f64) -> Result<Aero, Error> {
        self.model_of(STRIPS, wing, hinges, density, least)
    }

    /// The same with another number of strips or nodes.
    pub fn model_of(
        self,
        strips: usize,
        wing: &Planform,
        hinges: &[f64],
        density: f64,
        least: f64,
    ) -> Result<Aero, Error> {
        self.model_with(SectionLaw::INVISCID, strips, wing, hinges, density, least)
    }

    /// The same with a law and its section.
    pub fn model_with(
        self,
        section: SectionLaw,
        strips: usize,
        wing: &Planform,
        hinges: &[f64],
        density: f64,
        least: f64,
    ) -> Result<Aero, Error> {
        let SectionLaw { law, stall_angle_deg, critical_suction, drag, side_edges } = section;
        let stall_angle_rad = stall_angle_deg.to_radians();
        if self == Self::Paper {
            let settings = LiftingLineSettings {
                nodes: strips,
                regularisation_m_s: least,
                chord_floor_m: 1e-9,
                section: SectionSettings {
                    law,
                    stall_angle_rad,
                    critical_suction,
                    drag,
                    density_kg_m3: density,
                    ..Default::default()
                },
                ..Default::default()
            };
            return Ok(Aero::LiftingLine(LiftingLine::new(wing, settings)?));
        }
        let settings = StripSettings {
            strips,
            hinge_arcs_m: hinges.to_vec(),
            regularisation_m_s: least,
            lags: if self == Self::FiveLags { LagSet::Five } else { LagSet::Three },
            turning_impulse: matches!(self, Self::Turned | Self::Neither).then_some(self == Self::Turned),
            edge_suction: (self == Self::Neither).then_some(false),
            side_edges,
            section: SectionSettings {
                law,
                stall_angle_rad,
                critical_suction,
                drag,
                density_kg_m3: density,
                ..Default::default()
            },
            ..Default::default()
        };
        Ok(Aero::Strip(StripModel::new(wing, settings)?))
    }
}
