//! Guidance: what to fly, the predictive controller that flies it, and
//! manoeuvres planned offline.

mod about_orbit;
mod controllers;
mod least_power;
mod manoeuvre;
mod mpc;
mod playback;
mod roll_in;
mod stand;
mod turn;

/// Most intervals of the first mesh of a plan, and most meshes.
const MAX_INTERVALS: usize = 500;
const MAX_MESHES: usize = 20;

pub use about_orbit::{AboutOrbitSpec, LegSpec, OrbitWeights};
pub use controllers::{ControllerSpec, Prepared, RobotSolver, SolverSpec, Task};
pub(crate) use least_power::CYCLES;
pub use least_power::{LeastPower, LeastPowerSpec, Means};
pub use manoeuvre::{Manoeuvre, Reference, angle_error};
pub use mpc::{AttitudeTracking, Mpc, MpcSpec, Weights};
pub use playback::{HeldCommands, Playback};
pub use roll_in::{RollIn, RollInSpec, TrackingCost};
pub use stand::{Flapping, Stand};
pub use turn::{Track, Turn};
