//! A pair of wings of two panels each, the left one given.

use super::CapsuleSpec;
use crate::body::INERTIA;
use serde::{Deserialize, Serialize};
use wingbeat_aero::{CD0, CD90, FlapSpec, Gap, MembraneSpec, Planform, PlanformStation, SectionSpec};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require::{finite, positive, principal_inertias};

/// The left wing of a pair: sweep, shoulder, elbow and twist joints, from body to tip.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct WingSpec {
    /// Shoulder hinge from the body origin, m.
    pub shoulder_m: [f64; 3],
    /// Profile drag coefficient along the wind at zero angle of attack.
    pub cd0: f64,
    /// Additional drag coefficient broadside to the wind.
    pub cd90: f64,
    /// What laws `stall` and `lev` need of its section, where it differs from the scenario's.
    #[serde(default, skip_serializing_if = "SectionSpec::is_empty")]
    pub section: SectionSpec,
    /// Membrane between its leading and trailing edge; rigid where not given. Preset `full` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub membrane: Option<MembraneSpec>,
    /// Flap at its trailing edge, turned by the air against a spring; none where not given. Preset `full` only, and not of a membrane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flap: Option<FlapSpec>,
    /// Shift of the planform along x against the hinge line, m.
    #[serde(default)]
    pub planform_shift_m: f64,
    /// Link between shoulder and elbow.
    pub proximal: WingLinkSpec,
    /// Link beyond the elbow.
    pub distal: WingLinkSpec,
    /// Outline by arc length from the middle, body strip included; or in a file, `{ file = "outline.csv", unit = "mm", x = "aft" }` (docs/robots.md).
    pub planform: Vec<PlanformStation>,
    /// Where there is no wing, by the same arc; preset `full` only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<Gap>,
}

/// One wing link; lengths from its inner hinge, y along the span.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct WingLinkSpec {
    /// Length along the span, m.
    pub length_m: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    pub com_m: [f64; 3],
    /// Principal inertias about the centre of mass along x, y, z, kg m2.
    pub inertia_kg_m2: [f64; 3],
    /// Room it takes; from its inner hinge, y along the span.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capsule: Option<CapsuleSpec>,
}

ranges!(WingSpec { cd0: CD0.range, cd90: CD90.range });
ranges!(WingLinkSpec { length_m: Range::POSITIVE, mass_kg: Range::POSITIVE, inertia_kg_m2: INERTIA.range });

impl WingSpec {
    /// The planform with its gaps.
    pub fn outline(&self) -> Result<Planform, Error> {
        Planform::new(&self.planform)?.with_gaps(&self.gaps)
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        finite("shoulder_m", &self.shoulder_m)?;
        positive("shoulder_m[1]", self.shoulder_m[1])?;
        finite("planform_shift_m", &[self.planform_shift_m])?;
        self.in_range()?;
        self.section.check().map_err(|e| e.within("section"))?;
        self.membrane.iter().try_for_each(|m| m.check().map_err(|e| e.within("membrane")))?;
        self.flap.iter().try_for_each(|f| f.check().map_err(|e| e.within("flap")))?;
        self.proximal.check().map_err(|e| e.within("proximal"))?;
        self.distal.check().map_err(|e| e.within("distal"))?;
        let span = self.shoulder_m[1] + self.proximal.length_m + self.distal.length_m;
        match self.planform.last() {
            Some(tip) if (tip.arc_m - span).abs() <= 1e-6 * span => Ok(()),
            Some(tip) => {
                let key = format!("planform[{}].arc_m", self.planform.len() - 1);
                let error = Error::invalid(key, tip.arc_m, format!("{span} m: shoulder plus both links"));
                Err(error.against(["shoulder_m[1]", "proximal.length_m", "distal.length_m"]))
            }
            None => Err(Error::invalid("planform", "[]", "at least two stations")),
        }
    }
}

impl WingLinkSpec {
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        finite("com_m", &self.com_m)?;
        self.capsule.iter().try_for_each(CapsuleSpec::check)?;
        principal_inertias("inertia_kg_m2", self.inertia_kg_m2)
    }
}
