//! Lifting surfaces.

use serde::{Deserialize, Serialize};
use wingbeat_aero::{
    CD0, CD90, FlapSpec, Gap, LiftLaw, MAX_STRIPS, MembraneSpec, Planform, PlanformStation, Preset,
    SectionSpec, Span,
};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require::finite;

/// A lifting surface: an outline by arc length, laid over links from the root to the tip.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct SurfaceSpec {
    /// Name.
    pub name: String,
    /// `symmetric` about the middle plane, its outline that of the left half; or one-sided, `left` with
    /// the tip to the left (or upward) and `right`.
    #[serde(default)]
    pub span: Span,
    /// Profile drag coefficient along the wind at zero angle of attack.
    #[serde(default)]
    pub cd0: f64,
    /// Additional drag coefficient broadside to the wind; where not given 0 under law `linear`, that of a flat
    /// plate under laws that separate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cd90: Option<f64>,
    /// What its section asks of its law ([sections.md](sections.md)), where it differs from the scenario's.
    #[serde(default, skip_serializing_if = "SectionSpec::is_empty")]
    pub section: SectionSpec,
    /// Membrane between its leading and trailing edge; rigid where not given. Preset `full` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub membrane: Option<MembraneSpec>,
    /// Flap at its trailing edge, turned by the air against a spring; none where not given. Preset `full` only, and not of a membrane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flap: Option<FlapSpec>,
    /// Aerodynamic model; that of the scenario where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<Preset>,
    /// Lift law; that of the scenario where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<LiftLaw>,
    /// Strips, or nodes of preset `paper`; those of the scenario where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strips: Option<usize>,
    /// Shift of the outline along x, m.
    #[serde(default)]
    pub planform_shift_m: f64,
    /// Outline by arc length from the root; or in a file, `{ file = "outline.csv", unit = "mm", x = "aft" }` (docs/robots.md).
    pub planform: Vec<PlanformStation>,
    /// Where there is no surface, by the same arc; preset `full` only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<Gap>,
    /// The links that carry it, from the root on.
    pub panels: Vec<PanelSpec>,
}

/// A stretch of a surface that rides on one link.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PanelSpec {
    /// Name of its begin in the columns of a record; that of the link where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// `body` or a link; of a mirrored pair the name of the pair in a symmetric surface.
    pub link: String,
    /// Arc length at which it begins, m; it ends where the next begins.
    #[serde(default)]
    pub from_arc_m: f64,
    /// Place of its begin in the frame of the link, m; edges lie ahead of it along x.
    #[serde(default)]
    pub origin_m: [f64; 3],
    /// Direction of the span from the root on, in the frame of the link, across x, dimensionless; any length above 0. By default along
    /// y to the side of the surface: `[0, 1, 0]`, of one with `span = "right"` `[0, -1, 0]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// Length from its begin over which chord lines pass over from that of the panel before to its own, m; where 0 one strip does it,
    /// whatever its width. Of the lattice and preset `full`.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub web_m: f64,
    /// Whether it is the next piece of a spar, over which the web of the first goes on.
    #[serde(skip)]
    pub(crate) piece: bool,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_zero(length: &f64) -> bool {
    *length == 0.0
}

ranges!(SurfaceSpec { cd0: CD0.range, cd90: CD90.range, strips: Range::between(1.0, MAX_STRIPS as f64) });

impl SurfaceSpec {
    /// The panels with their places and the links that they name.
    pub(super) fn panels_of(surface: &Self) -> impl Iterator<Item = (usize, &str)> {
        surface.panels.iter().map(|panel| panel.link.as_str()).enumerate()
    }

    /// The outline.
    pub fn outline(&self) -> Result<Planform, Error> {
        Planform::new(&self.planform)?.with_gaps(&self.gaps)?.spanning(self.span)
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        self.section.check().map_err(|e| e.within("section"))?;
        self.membrane.iter().try_for_each(|m| m.check().map_err(|e| e.within("membrane")))?;
        self.flap.iter().try_for_each(|f| f.check().map_err(|e| e.within("flap")))?;
        finite("planform_shift_m", &[self.planform_shift_m])?;
        if self.panels.is_empty() {
            return Err(Error::invalid("panels", "[]", "at least one panel"));
        }
        self.outline()?;
        let tip = self.planform.last().map_or(0.0, |s| s.arc_m);
        for (i, panel) in self.panels.iter().enumerate() {
            let within = |e: Error| e.within(&format!("panels[{i}]"));
            panel.check(self.span).map_err(within)?;
            let from = |i: usize| self.panels.get(i).map(|panel| panel.from_arc_m);
            let beside = [i.checked_sub(1).and_then(from), from(i + 1)];
            let placed = panel.numbers(self.span).check(beside, tip).map_err(within);
            placed.map_err(|e| e.against([format!("planform[{}].arc_m", self.planform.len() - 1)]))?;
        }
        Ok(())
    }
}

impl PanelSpec {
    /// The direction of its span, of a surface that spans `span`.
    pub(crate) fn along(&self, span: Span) -> [f64; 3] {
        self.direction.unwrap_or([0.0, outwards(span), 0.0])
    }

    fn check(&self, span: Span) -> Result<(), Error> {
        finite("origin_m", &self.origin_m)?;
        let along = self.along(span);
        finite("direction", &along)?;
        let [_, y, z] = along;
        if span != Span::Symmetric && y * outwards(span) < 0.0 && y.abs() > z.abs() {
            let allowed = match span {
                Span::Right => {
                    "one with y below 0: the tip of a surface with span = \"right\" is to the right, its root at its left"
                }
                _ => {
                    "one with y above 0: the tip of a surface with span = \"left\" is to the left, its root at its right"
                }
            };
            return Err(Error::invalid("direction", format!("{along:?}"), allowed).against(["span"]));
        }
        Ok(())
    }
}

/// The sign of y on the way from the root of a surface to its tip; of one on both sides to the left tip.
fn outwards(span: Span) -> f64 {
    if span == Span::Right { -1.0 } else { 1.0 }
}
