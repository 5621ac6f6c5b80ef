//! Guidance: what to fly, the predictive controller that flies it, and
//! manoeuvres planned offline.

mod about_orbit;
mod attitude_tracking;
mod controllers;
mod free_end;
mod history;
mod hover;
mod inertial;
mod least_power;
mod manoeuvre;
mod mpc;
pub mod path;
mod playback;
mod receding;
mod reorientation;
mod roll_in;
mod soft_clearance;
mod stand;
mod told;
mod turn;

/// Most intervals of the first mesh of a plan, and most meshes.
const MAX_INTERVALS: usize = 500;
const MAX_MESHES: usize = 20;
/// Most iterations that a plan may ask for.
const MAX_ITERATIONS: usize = 100_000;

/// Iterations of a plan that does not say them. *Choice*: the shipped plans take a tenth to a third.
fn most_iterations() -> usize {
    1000
}

/// A limit of processor time; none is any.
fn processor_time(limit_s: Option<f64>) -> std::time::Duration {
    limit_s
        .and_then(|limit| std::time::Duration::try_from_secs_f64(limit).ok())
        .unwrap_or(std::time::Duration::MAX)
}

pub use about_orbit::{
    AboutOrbitSpec, AdaptSpec, DiveSpec, HoldingGains, LandingSpec, LegSpec, ORBIT_STEP, OrbitWeights,
    PlanStructure, PredictiveSpec, Terminal, TrackingSpec,
};
pub use about_orbit::{gains_of, holding_inputs};
pub use attitude_tracking::AttitudeTracking;
pub use controllers::{ControllerSpec, ControllerTask, Prepared, RobotSolver, SearchWatch, SolverSpec};
pub use free_end::FreeEnd;
pub use hover::HoverSpec;
pub use inertial::EstimatorSpec;
pub use least_power::CYCLES;
pub use least_power::{LeastPower, LeastPowerSpec, Means};
pub use manoeuvre::angle_error;
pub use manoeuvre::{Manoeuvre, Reference};
pub use mpc::{Mpc, MpcSpec, Weights};
pub use path::{
    CurveSpec, FigureEightSpec, HelixSpec, LaneChangeSpec, LineSpec, Path, PathOffset, PathSpec, PointsSpec,
    Station,
};
pub use playback::{CommandsSpec, HeldCommands, Playback};
pub use reorientation::{GuessSpec, ReorientationSpec, WaveSpec};
pub use roll_in::{RollIn, RollInSpec, TrackingCost};
pub use stand::{Flapping, Stand};
pub use told::Told;
pub use turn::{Track, Turn};
