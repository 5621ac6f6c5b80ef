//! Limits of a plan. All values are choices; each stands beside what the shipped plans reach.
//!
//! A plan is also held against limits of other kinds: a roll-in against `flight.altitude_m` and `flight.crossing_fraction`, a
//! gait against `flight.crossing_fraction`, `trim.high_power_w_kg` and `trim.power_w_kg`.

use super::JudgedLimit;
use crate::status::Status::{NotFound, NotPeriodic, NotResolved, OffTarget};

/// Ten times the tolerance of the quickest plans, and what the solver calls acceptable.
pub const VIOLATION: JudgedLimit = JudgedLimit::at_most("plan.violation", 1e-4, "", NotFound)
    .on("largest violation of a constraint, scaled as the solver sees it,");
/// Error of the optimality conditions: what the solver calls acceptable.
pub const RESIDUAL: JudgedLimit = JudgedLimit::at_most("plan.residual", 1e-4, "", NotResolved)
    .on("largest error of the optimality conditions, scaled as the solver sees it,");
/// What the dynamics lack between the nodes, whatever tolerance the plan asks for. Meshes that leave .03 still fly to .1 deg.
pub const INTERVAL_ERROR: JudgedLimit = JudgedLimit::at_most("plan.interval_error", 0.1, "", NotResolved)
    .on("largest error of an interval between its nodes, relative,");
/// The same over the tolerance that the plan asks for; up to a hundred times of it the solver goes on.
pub const OVER_TOLERANCE: JudgedLimit = JudgedLimit::warn_above("plan.error_over_tolerance", 1.0, "")
    .on("the mesh is coarser than the plan asks (more meshes, or a larger tolerance): error between the nodes over the tolerance");
/// An optimum that moves with its mesh. Shipped roll-ins change by .007 and less. *Choice.*
pub const OBJECTIVE_CHANGE: JudgedLimit = JudgedLimit::warn_above("plan.objective_change_fraction", 0.01, "")
    .on("the optimum moves with the mesh: relative change of the objective from the mesh before");
/// A simulation under the planned inputs that comes elsewhere says that mesh or model do not hold the plan.
pub const RESIMULATION: JudgedLimit =
    JudgedLimit::at_most("plan.resimulation_fraction", 0.1, "", NotResolved)
        .on("largest distance of the re-simulated states from the plan, relative,");
/// Inputs at their limits: the plan is then theirs more than the robot's.
pub const SATURATION: JudgedLimit = JudgedLimit::warn_above("plan.saturated_fraction", 0.9, "")
    .on("share of the inputs at a limit, over the nodes");
/// Attitude at the end of a roll-in as it was flown under the planned inputs.
pub const FLOWN: JudgedLimit = JudgedLimit::at_most("plan.flown_attitude_deg", 2.0, "deg", OffTarget)
    .on("largest difference of roll, pitch or yaw between the planned and the flown end");
/// Speed over a roll-in, which is to end in a turn that flies on.
pub const SPEED: JudgedLimit = JudgedLimit::at_most("plan.speed_change_fraction", 0.5, "", OffTarget)
    .on("change of the speed over the planned roll-in, relative to that at its start,");
/// Force of a gait that is simulated from rest under the planned commands.
pub const REPLAYED: JudgedLimit = JudgedLimit::at_most("plan.replayed_force_fraction", 0.05, "", OffTarget)
    .on("what the replayed gait lacks of the mean force asked for, over the weight,");
/// Over the last of the simulated cycles.
pub const CLOSURE: JudgedLimit = JudgedLimit::at_most("plan.replay_closure", 0.02, "", NotPeriodic)
    .on("largest change of a state over the last replayed cycle");
/// The same commands under the other preset: what depends on the model.
pub const MODELS: JudgedLimit = JudgedLimit::warn_above("plan.model_force_fraction", 0.1, "")
    .on("the gait depends on the aerodynamic preset: change of the mean upward force under the other one, over the weight,");

/// All of them.
pub const ALL: [JudgedLimit; 12] = [
    VIOLATION,
    RESIDUAL,
    INTERVAL_ERROR,
    OVER_TOLERANCE,
    OBJECTIVE_CHANGE,
    RESIMULATION,
    SATURATION,
    FLOWN,
    SPEED,
    REPLAYED,
    CLOSURE,
    MODELS,
];
