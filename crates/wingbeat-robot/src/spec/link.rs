//! Links and their joints.

use super::super::numbers::{DAMPING, STIFFNESS, STOP_STIFFNESS};
use super::{CapsuleSpec, GaitSpec, LinkSparSpec};
use crate::body::{FourierSeries, Harmonic, INERTIA, JointKind, MASS};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::ranges;
use wingbeat_math::require::{finite, principal_inertias};

/// On which side of the plane of symmetry a link lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LinkSide {
    /// A link of its own, as written.
    #[default]
    Single,
    /// A pair: the left link as written, its name ending in `_left`, and its mirror image `_right`.
    Mirrored,
}

/// A link and the joint by which its parent carries it; lengths from the joint, in link axes, which at
/// joint coordinate zero and without `orientation_deg` are those of the body. Exactly one of
/// `driven`, `elastic`, `free` or none of them (fixed).
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct LinkSpec {
    /// Name, also that of its joint.
    pub name: String,
    /// One link or a mirrored pair.
    #[serde(default)]
    pub side: LinkSide,
    /// The link that carries it: `body`, or the name of a link before it; a mirrored link on a
    /// mirrored one names the pair. Of a link with a spar, the piece on which the joint lies carries it.
    #[serde(default = "body")]
    pub parent: String,
    /// Place of the joint in the parent's frame, m.
    #[serde(default)]
    pub origin_m: [f64; 3],
    /// Roll, pitch, yaw of the link against its parent at joint coordinate zero, deg.
    #[serde(default)]
    pub orientation_deg: [f64; 3],
    /// Whether the joint turns or slides.
    #[serde(default)]
    pub joint: JointKind,
    /// Direction of the joint's axis in link axes, dimensionless; any length above 0.
    #[serde(default = "forward")]
    pub axis: [f64; 3],
    /// Mass, kg.
    #[serde(default)]
    pub mass_kg: f64,
    /// Centre of mass, m.
    #[serde(default)]
    pub com_m: [f64; 3],
    /// Principal inertias about the centre of mass along x, y, z, kg m2.
    #[serde(default)]
    pub inertia_kg_m2: [f64; 3],
    /// Room it takes; with a spar it bends with that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capsule: Option<CapsuleSpec>,
    /// Moved by the gait.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub driven: Option<DrivenSpec>,
    /// Held by a spring: the joint's coordinate is a state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elastic: Option<ElasticSpec>,
    /// Free to move: a state without a spring.
    #[serde(default)]
    pub free: bool,
    /// A beam that it carries along its y axis, on which surfaces ride that name the link.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spar: Option<LinkSparSpec>,
}

fn body() -> String {
    "body".into()
}
fn forward() -> [f64; 3] {
    [1.0, 0.0, 0.0]
}

/// Coordinate of a driven joint: mean + sum_n amplitude cos(n (phase - lag) - phase_n), rad or m, or an
/// output of the linkage.
#[derive(Clone, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DrivenSpec {
    /// Mean, rad (m for a sliding joint).
    pub mean_rad: f64,
    /// Harmonics 1, 2, ... of the gait.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub harmonics: Vec<Harmonic>,
    /// Lag behind the phase of the gait, rad.
    pub lag_rad: f64,
    /// Angle in the glide of a gait with `bound`, rad (m); the mean where it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub folded_rad: Option<f64>,
    /// Output of the linkage, in place of a series.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linkage: Option<LinkageOutput>,
}

/// Angles that the linkage puts out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LinkageOutput {
    /// Humerus against the body.
    Shoulder,
    /// Radius against the humerus.
    Elbow,
}

/// Spring and damper of an elastic joint: effort = -stiffness (q - rest) - damping q'.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct ElasticSpec {
    /// N m/rad, or N/m of a sliding joint.
    pub stiffness: f64,
    /// N m s/rad, or N s/m.
    #[serde(default)]
    pub damping: f64,
    /// Coordinate without effort, rad or m.
    #[serde(default)]
    pub rest: f64,
    /// Coordinate at the start, rad or m; `rest` where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// Stops on either side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stops: Option<StopSpec>,
}

/// Smooth stops: beyond low and high a further stiffness, the corner rounded off over a hundredth of
/// the range either way.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct StopSpec {
    /// Lower stop, rad or m.
    pub low: f64,
    /// Upper stop, rad or m.
    pub high: f64,
    /// N m/rad, or N/m.
    pub stiffness: f64,
}

/// How a joint moves, one of the choices of a [`LinkSpec`].
#[derive(Clone, Copy, Debug)]
pub enum JointSpec<'a> {
    /// Not at all.
    Fixed,
    /// By the gait.
    Driven(&'a DrivenSpec),
    /// By its spring.
    Elastic(&'a ElasticSpec),
    /// By what acts on it.
    Free,
}

ranges!(LinkSpec { mass_kg: MASS.range, inertia_kg_m2: INERTIA.range });
ranges!(ElasticSpec { stiffness: STIFFNESS.range, damping: DAMPING.range });
ranges!(StopSpec { stiffness: STOP_STIFFNESS.range });

impl LinkSpec {
    /// How the joint moves.
    pub fn moved(&self) -> JointSpec<'_> {
        match (&self.driven, &self.elastic, self.free) {
            (Some(driven), _, _) => JointSpec::Driven(driven),
            (_, Some(elastic), _) => JointSpec::Elastic(elastic),
            (_, _, true) => JointSpec::Free,
            _ => JointSpec::Fixed,
        }
    }

    pub(super) fn check(&self, gait: &GaitSpec) -> Result<(), Error> {
        let [roll, pitch, yaw] = self.orientation_deg;
        finite("origin_m", &self.origin_m)?;
        finite("orientation_deg", &[roll, pitch, yaw])?;
        finite("axis", &self.axis)?;
        if !(self.axis.iter().map(|a| a * a).sum::<f64>() > 0.0) {
            let error = Error::invalid("axis", format!("{:?}", self.axis), "a direction");
            return Err(error.against([0, 1, 2].map(|i| format!("axis[{i}]"))));
        }
        self.in_range()?;
        finite("com_m", &self.com_m)?;
        principal_inertias("inertia_kg_m2", self.inertia_kg_m2)?;
        self.capsule.iter().try_for_each(CapsuleSpec::check)?;
        self.spar.iter().try_for_each(|spar| spar.check().map_err(|e| e.within("spar")))?;
        let ways = [self.driven.is_some(), self.elastic.is_some(), self.free];
        if ways.iter().filter(|w| **w).count() > 1 {
            let allowed = "one of `driven`, `elastic` and `free`, or none for a fixed joint";
            return Err(Error::invalid("driven", "more than one way to move", allowed));
        }
        match self.moved() {
            JointSpec::Driven(driven) => driven.check(gait, self.joint).map_err(|e| e.within("driven")),
            JointSpec::Elastic(elastic) => elastic.check().map_err(|e| e.within("elastic")),
            JointSpec::Free | JointSpec::Fixed => Ok(()),
        }
    }
}

impl DrivenSpec {
    /// The series.
    pub fn series(&self) -> FourierSeries {
        FourierSeries { mean_rad: self.mean_rad, harmonics: self.harmonics.clone() }
    }

    fn check(&self, gait: &GaitSpec, joint: JointKind) -> Result<(), Error> {
        finite("lag_rad", &[self.lag_rad])?;
        self.series().check()?;
        if let Some(folded) = self.folded_rad {
            finite("folded_rad", &[folded])?;
            if gait.bound().is_none() {
                return Err(Error::invalid(
                    "folded_rad",
                    folded,
                    "nothing without gait.fourier.bound, whose glide folds the wings",
                ));
            }
        }
        let Some(output) = self.linkage else { return Ok(()) };
        if !matches!(gait, GaitSpec::Linkage { .. }) || joint != JointKind::Revolute {
            let allowed = "an output only of a [gait.linkage], on a joint that turns";
            return Err(Error::invalid("linkage", format!("{output:?}"), allowed));
        }
        if self.mean_rad != 0.0 || !self.harmonics.is_empty() || self.lag_rad != 0.0 {
            let allowed = "either an output of the linkage or a series";
            return Err(Error::invalid("linkage", format!("{output:?}"), allowed));
        }
        Ok(())
    }
}

impl ElasticSpec {
    fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        finite("rest", &[self.rest])?;
        finite("start", &[self.start.unwrap_or(0.0)])?;
        let Some(stops) = &self.stops else { return Ok(()) };
        stops.in_range().map_err(|e| e.within("stops"))?;
        finite("stops.low", &[stops.low])?;
        finite("stops.high", &[stops.high])?;
        if stops.low < stops.high {
            return Ok(());
        }
        Err(Error::invalid("stops.low", stops.low, format!("less than stops.high = {}", stops.high)))
    }
}
