//! What can be chosen in the strip model; each ingredient is a switch, so that
//! its effect can be shown.

use super::constants::{FIVE_LAGS, Lags, THREE_LAGS};
use crate::{FlapSpec, MAX_STRIPS, MembraneSpec, SectionSettings, SurfaceNumbers};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};

/// Which set of lags the model carries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LagSet {
    /// Two wash lags, one wake lag: three states per strip.
    #[default]
    Three,
    /// Three wash lags, two wake lags: five states per strip; circulation within 8 % instead of 23 %, but of a wing
    /// that tapers and folds the force in plunge and pitch within 3.3 % only, with three lags within 2.1 %.
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

/// What the circulation bears along the span, and as a section drifts along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SpanForce {
    /// Nothing.
    Nothing,
    /// The impulse that turns with the section (`aero.strip.turned_circulation`).
    Impulse,
    /// Suction of edges and pressure (`aero.strip.along_span`).
    Edges,
}

/// Settings of [`StripModel`](super::StripModel).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StripSettings {
    /// Number of strips over both wings and body.
    pub strips: usize,
    /// Arc coordinates of the half wing that must have a strip edge (hinges), m.
    pub hinge_arcs_m: Vec<f64>,
    /// How far beyond each of these the surface passes over to the outer side, m: an edge lies there too; 0, or none, at once.
    pub webs_m: Vec<f64>,
    /// Speed below which directions lose their meaning, m/s; smooths every root.
    pub regularisation_m_s: f64,
    /// Lags carried per strip.
    pub lags: LagSet,
    /// Three-dimensional wash of bound and shed circulation; off: strips of an
    /// infinite wing.
    pub wake_wash: bool,
    /// Three-dimensional wash of the potential jump on the chord.
    pub doublet_wash: bool,
    /// Rates of that wash as the wing folds and the wake turns, in the force of the carried air: one state more per strip. Without
    /// them that force has a mean over a cycle, 5 % of the lift of Aerobat on its stand; without added mass there is none.
    pub folding_rates: bool,
    /// Impulse of the bound circulation as a section turns about its chord and drifts along its span: a spanwise force and a couple.
    /// Without it a rectangular wing that folds by 50 degrees in the upstroke lifts 25 % more than the free lattice, with it as much. On
    /// wings with a swept trailing edge it is too large: over the cycle the lift of shipped gaits errs by 0.39 to 0.52 of its rms with
    /// it, by 0.20 to 0.27 with `edge_suction`. Where it is not given it is on, unless `edge_suction` is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turning_impulse: Option<bool>,
    /// Suction square to swept leading edges and of the side edges at the tips along the span, and the pressure where sections drift
    /// along it. The rectangular wing that folds lifts 8 % less than the free lattice with it; over the cycle the lift of shipped gaits
    /// errs by 0.20 to 0.27 of its rms. Where not given: unless `turning_impulse` is true or the wing has a membrane, a flap or one
    /// strip, which are refused it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge_suction: Option<bool>,
    /// Vortices above the tips of a wing that ends in sharp side edges, after Lamar: a normal force that grows with the square of the
    /// lift. A plate of aspect ratio 2 lifts a twentieth more with it at 5 degrees, a tenth at 10; past stall and in fast motion too much.
    pub side_edges: bool,
    /// Distance at which the wash of a vortex on a strip is half faded, over the distance at which the
    /// two pass on the flat wing: 0.01 to 0.5.
    pub vortex_core: f64,
    /// Turning of the force by the wash of wake and lags: induced drag.
    pub force_tilt: bool,
    /// Section and air.
    pub section: SectionSettings,
    /// The membrane that the strips are made of; none is rigid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub membrane: Option<MembraneSpec>,
    /// The flap at their trailing edge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flap: Option<FlapSpec>,
}

impl Default for StripSettings {
    fn default() -> Self {
        Self {
            strips: 16,
            hinge_arcs_m: Vec::new(),
            webs_m: Vec::new(),
            regularisation_m_s: 0.02,
            lags: LagSet::Three,
            wake_wash: true,
            doublet_wash: true,
            folding_rates: false,
            turning_impulse: None,
            edge_suction: None,
            side_edges: false,
            vortex_core: 0.3,
            force_tilt: true,
            section: SectionSettings::default(),
            membrane: None,
            flap: None,
        }
    }
}

ranges!(StripSettings {
    strips: Range::between(1.0, MAX_STRIPS as f64),
    regularisation_m_s: Range::POSITIVE,
    vortex_core: Range::between(0.01, 0.5),
});

impl StripSettings {
    /// The numbers that may carry derivatives, as set.
    pub fn numbers(&self) -> SurfaceNumbers {
        let membrane = self.membrane.as_ref().map(MembraneSpec::numbers);
        let flap = self.flap.as_ref().map(FlapSpec::numbers);
        SurfaceNumbers { membrane, flap, ..self.section.numbers(self.lags.lags().numbers()) }
    }

    /// Whether suction of edges can bear along the span: strips without membrane and flap, more than one.
    pub fn is_flat(&self) -> bool {
        self.membrane.is_none() && self.flap.is_none() && self.strips > 1
    }

    /// The settings of a surface among others of which some are flat and some are not: where `edge_suction` is true, it bears on the
    /// flat ones and `turning_impulse` counts for the others.
    #[must_use]
    pub fn among_both_kinds(mut self) -> Self {
        match (self.edge_suction, self.is_flat()) {
            (Some(true), true) => self.turning_impulse = Some(false),
            (Some(true), false) => self.edge_suction = Some(false),
            _ => {}
        }
        self
    }

    /// What bears along the span, of `edge_suction` and `turning_impulse`.
    ///
    /// # Errors
    /// [`Error::Invalid`] when both are asked for, or the first of what is not flat or is one strip.
    pub(super) fn span_force(&self) -> Result<SpanForce, Error> {
        let flat = self.is_flat();
        let edges = self.edge_suction.unwrap_or(flat && self.turning_impulse != Some(true));
        let turns = self.turning_impulse.unwrap_or(!edges);
        let refused = |allowed| Error::invalid("edge_suction", true, allowed);
        match (edges, turns) {
            (true, true) => Err(refused("false beside turning_impulse = true, whose place it takes")
                .against(["turning_impulse"])),
            (true, false) if !flat => Err(refused(
                "false of a wing with a membrane, a flap or one strip: this was derived of flat sections",
            )),
            (true, false) => Ok(SpanForce::Edges),
            (false, true) => Ok(SpanForce::Impulse),
            (false, false) => Ok(SpanForce::Nothing),
        }
    }

    /// Refuses values without physical meaning.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        if let Some(membrane) = &self.membrane {
            membrane.check().map_err(|e| e.within("membrane"))?;
        }
        if let Some(flap) = &self.flap {
            flap.check().map_err(|e| e.within("flap"))?;
            if self.membrane.is_some() {
                return Err(Error::invalid("flap", "given", "none beside a membrane"));
            }
        }
        self.section.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FlapSpec;

    const FLAP: FlapSpec = FlapSpec {
        chord_fraction: 0.3,
        stiffness_n_rad: 0.1,
        areal_density_kg_m2: 0.2,
        damping_s: 0.0,
        rest_deg: 0.0,
        from_arc_m: 0.0,
        to_arc_m: None,
    };

    #[test]
    fn one_force_bears_along_the_span() {
        use SpanForce::{Edges, Impulse, Nothing};
        let flat = |edge_suction, turning_impulse| StripSettings {
            edge_suction,
            turning_impulse,
            ..StripSettings::default()
        };
        let of = |settings: StripSettings| settings.span_force().ok();
        for (edges, turns, expected) in [
            (None, None, Some(Edges)),
            (None, Some(true), Some(Impulse)),
            (None, Some(false), Some(Edges)),
            (Some(true), None, Some(Edges)),
            (Some(true), Some(false), Some(Edges)),
            (Some(true), Some(true), None),
            (Some(false), None, Some(Impulse)),
            (Some(false), Some(false), Some(Nothing)),
            (Some(false), Some(true), Some(Impulse)),
        ] {
            assert_eq!(of(flat(edges, turns)), expected, "{edges:?}, {turns:?}");
        }
        for edges in [None, Some(true)] {
            let flap = StripSettings { flap: Some(FLAP), ..flat(edges, None) };
            let one = StripSettings { strips: 1, ..flat(edges, None) };
            let expected = edges.is_none().then_some(Impulse);
            assert_eq!([of(flap), of(one)], [expected; 2]);
        }
    }
}
