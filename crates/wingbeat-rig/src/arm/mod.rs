//! Serial arms: kinematics, inverse kinematics, inverse dynamics, limits.

mod chain;
mod config;
mod dynamics;
mod inverse;
mod jacobian;
mod limits;

pub use chain::{ArmJointKind, Joint, LinkBody, MAX_JOINTS, SerialArm};
pub use config::{ArmConfig, JointConfig, LinkConfig, ProfileConfig, ToolConfig};
pub use dynamics::{JointMotion, Payload};
pub use inverse::{InverseKinematics, InverseSolution, InverseStatus, ToolGoal};
pub use jacobian::Jacobian;
pub use limits::{LimitProfile, ToolLimits};
