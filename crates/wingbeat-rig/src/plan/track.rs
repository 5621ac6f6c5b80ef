//! Joint motion that carries the body along a path.

use super::{Clearance, Envelope, TurnPath};
use crate::arm::{InverseKinematics, InverseStatus, Jacobian, MAX_JOINTS, SerialArm};
use crate::plan::clearance::clearance;
use crate::{FrameMotion, Pose};
use wingbeat_math::linear::solve_symmetric;
use wingbeat_math::{Jet, Vec3};

/// How the robot sits on the arm and where the path lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPlacement {
    /// Path frame in the base frame, X_WP.
    pub path: Pose,
    /// Body in the tool frame, X_TB.
    pub body: Pose,
}

/// One instant of a tracked path.
#[derive(Clone, Copy, Debug)]
pub struct TrackInstant {
    /// Time, s.
    pub t: f64,
    /// Joint positions, rad, with rates and accelerations.
    pub q: [Jet; MAX_JOINTS],
    /// Smallest singular value of the Jacobian, m/rad.
    pub margin: f64,
    /// Distances.
    pub clearance: Clearance,
    /// Motion of the tool in the base frame.
    pub tool: FrameMotion,
}

/// Why a path cannot be tracked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Untracked {
    /// The tool stays this far (m, rad) from the path at time t: out of reach, or held by a joint limit.
    OutOfReach {
        /// Time, s.
        t: f64,
        /// Distance left, m.
        distance: f64,
        /// The joint that its position limit holds, if any.
        limit: Option<usize>,
    },
    /// The arm is singular at time t.
    Singular {
        /// Time, s.
        t: f64,
    },
}

/// Follows the path at `samples` + 1 equal steps of time from the posture
/// `start` at time zero; the posture stays on its branch. `table` is the
/// height of the table in the base frame, m.
pub fn track(
    arm: &SerialArm,
    path: &TurnPath,
    placement: &PathPlacement,
    start: &[f64],
    envelope: &Envelope,
    table: f64,
    samples: usize,
) -> Result<Vec<TrackInstant>, Untracked> {
    let solver = InverseKinematics { restarts: 0, iterations: 40, ..Default::default() };
    let tool_in_body = Pose::constant(&placement.body.inverse());
    let mut q: [f64; MAX_JOINTS] = std::array::from_fn(|i| start.get(i).copied().unwrap_or(0.0));
    let mut instants = Vec::with_capacity(samples + 1);
    for k in 0..=samples {
        let t = path.duration() * k as f64 / samples as f64;
        let body = Pose::constant(&placement.path) * path.body(t);
        let tool = body * tool_in_body;
        let solution = solver.follow(arm, &tool.values(), &q);
        if solution.status != InverseStatus::Solved {
            let held = |i: &usize| {
                let joint = &arm.joints[*i];
                solution.q[*i] <= joint.low || solution.q[*i] >= joint.high
            };
            let limit = (0..arm.dof()).find(held);
            return Err(Untracked::OutOfReach { t, distance: solution.position_error, limit });
        }
        q = solution.q;
        let frames = arm.frames(&q);
        let jacobian = arm.jacobian(&frames);
        let motion = FrameMotion::from_jets(&tool);
        let rates = joint_rates(arm, &jacobian, &q, &motion).ok_or(Untracked::Singular { t })?;
        let distances = clearance(arm, &frames, &body.values(), envelope, table);
        let margin = jacobian.singularity_margin();
        instants.push(TrackInstant { t, q: rates, margin, clearance: distances, tool: motion });
    }
    Ok(instants)
}

/// Joint rates and accelerations that give the tool its motion:
/// dq = J^-1 [v; w], ddq = J^-1 ([a; alpha] - dJ/dt dq). None when singular.
fn joint_rates(
    arm: &SerialArm,
    jacobian: &Jacobian,
    q: &[f64; MAX_JOINTS],
    tool: &FrameMotion,
) -> Option<[Jet; MAX_JOINTS]> {
    let dq = pseudo_inverse(jacobian, tool.velocity, tool.rate)?;
    let at: [Jet; MAX_JOINTS] = std::array::from_fn(|i| Jet::new(q[i], dq[i], 0.0));
    let swept = FrameMotion::from_jets(&arm.tool_pose(&at));
    let ddq = pseudo_inverse(
        jacobian,
        tool.acceleration - swept.acceleration,
        tool.angular_acceleration - swept.angular_acceleration,
    )?;
    Some(std::array::from_fn(|i| Jet::new(q[i], dq[i], ddq[i])))
}

/// J' (J J')^-1 [v; w].
fn pseudo_inverse(jacobian: &Jacobian, v: Vec3, w: Vec3) -> Option<[f64; MAX_JOINTS]> {
    let y = solve_symmetric(jacobian.gram(1.0), [v[0], v[1], v[2], w[0], w[1], w[2]])?;
    Some(jacobian.transpose_mul(y))
}
