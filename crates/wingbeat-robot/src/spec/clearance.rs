//! Parts that must not meet.

use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require::finite;

/// The room that a link takes: all points within a radius of a segment, in link axes from its joint.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct CapsuleSpec {
    /// Begin of the segment, m.
    #[serde(default)]
    pub from_m: [f64; 3],
    /// End of the segment, m.
    pub to_m: [f64; 3],
    /// Radius, m.
    pub radius_m: f64,
}

/// Two parts, each with a capsule, whose clearance is watched.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClearanceSpec {
    /// `body` or links; the name of a mirrored pair stands for both of them.
    pub between: [String; 2],
}

ranges!(CapsuleSpec { radius_m: Range::POSITIVE });

impl CapsuleSpec {
    pub(super) fn check(&self) -> Result<(), Error> {
        finite("capsule.from_m", &self.from_m)?;
        finite("capsule.to_m", &self.to_m)?;
        self.in_range().map_err(|e| e.within("capsule"))
    }
}
