//! Rigid bodies, gait, linkage and structure response. Knows no air: loads come
//! in as wrenches on links, motion goes out.

mod coordinates;
mod dynamics;
mod forward;
mod gait;
mod inertia;
mod joint;
mod linkage;
mod momentum;
mod motion;
mod planar;
mod response;
mod tree;

pub use coordinates::Coordinates;
pub use dynamics::{BaseAcceleration, drive_power, joint_power};
pub use forward::FreeAcceleration;
pub use gait::{FourierSeries, Harmonic, MAX_HARMONICS};
pub use inertia::{BodyNumbers, INERTIA, MASS, PLACE, principal_moments};
pub use linkage::{Directions, Linkage, LinkageDimensions, LinkagePin, LinkagePose, MARGIN_LIMIT, REGULATED};
pub use momentum::Momentum;
pub use motion::LinkMotion;
pub use planar::Planar;
pub use response::{Coupled, Element, Response};
pub use tree::{Base, JointKind, JointNumbers, Link, Tree};

/// Largest number of links of a tree; the scratch lives on the stack.
pub const MAX_LINKS: usize = 40;
