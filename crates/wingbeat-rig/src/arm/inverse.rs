//! Inverse kinematics: damped least squares with joint limits and restarts.

use super::{MAX_JOINTS, SerialArm};
use crate::arm::jacobian::LENGTH_SCALE;
use crate::{Pose, rotation_vector};
use std::f64::consts::PI;
use wingbeat_math::linear::solve_symmetric;
use wingbeat_math::{Random, Vec3, whole_turns};

/// Where the tool shall be, in the base frame.
pub type ToolGoal = Pose;

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InverseStatus {
    /// Position and angle within tolerance, joints within limits.
    Solved,
    /// No start led to the goal; the answer is the nearest pose found.
    NotReached,
}

/// The nearest joint positions found.
#[derive(Clone, Copy, Debug)]
pub struct InverseSolution {
    /// Joint positions, rad or m; the first `dof` are valid.
    pub q: [f64; MAX_JOINTS],
    /// Distance to the goal, m.
    pub position_error: f64,
    /// Angle to the goal, rad.
    pub angle_error: f64,
    /// Steps over all starts.
    pub iterations: usize,
    /// Starts beyond the seed.
    pub restarts: usize,
    /// How it ended.
    pub status: InverseStatus,
}

/// Settings of the solver.
#[derive(Clone, Copy, Debug)]
pub struct InverseKinematics {
    /// Distance at which the goal counts as reached, m.
    pub position_tolerance: f64,
    /// Angle at which the goal counts as reached, rad.
    pub angle_tolerance: f64,
    /// Steps for one start.
    pub iterations: usize,
    /// Random starts after the seed.
    pub restarts: usize,
    /// Seed of the random starts.
    pub random_seed: u64,
}

impl Default for InverseKinematics {
    fn default() -> Self {
        Self {
            position_tolerance: 1e-10,
            angle_tolerance: 1e-10,
            iterations: 60,
            restarts: 100,
            random_seed: 1,
        }
    }
}

impl InverseKinematics {
    /// Joint positions, rad, that bring the tool to `goal`: from `seed` first, then from random poses. Continuous joints come
    /// back within half a turn of the seed.
    pub fn solve(&self, arm: &SerialArm, goal: &ToolGoal, seed: &[f64]) -> InverseSolution {
        let mut random = Random::new(self.random_seed);
        let mut best = self.descend(arm, goal, start_from(arm, seed));
        let mut total = best.iterations;
        for restart in 1..=self.restarts {
            if best.status == InverseStatus::Solved {
                break;
            }
            let candidate = self.descend(arm, goal, random_start(arm, &mut random));
            total += candidate.iterations;
            let better = error(&candidate) < error(&best) || candidate.status == InverseStatus::Solved;
            if better {
                best = candidate;
            }
            best.restarts = restart;
        }
        best.iterations = total;
        unwind(arm, &mut best.q, seed);
        best
    }

    /// The nearest solution on the branch of `seed` (rad): no restart, so that a path stays on one branch.
    pub fn follow(&self, arm: &SerialArm, goal: &ToolGoal, seed: &[f64]) -> InverseSolution {
        self.descend(arm, goal, start_from(arm, seed))
    }

    /// Different arm postures, rad, that reach `goal`, found from `tries` random starts.
    pub fn postures(&self, arm: &SerialArm, goal: &ToolGoal, tries: usize) -> Vec<[f64; MAX_JOINTS]> {
        let mut random = Random::new(self.random_seed);
        let mut found: Vec<[f64; MAX_JOINTS]> = Vec::new();
        for _ in 0..tries {
            let mut solution = self.descend(arm, goal, random_start(arm, &mut random));
            if solution.status != InverseStatus::Solved {
                continue;
            }
            unwind(arm, &mut solution.q, &[0.0; MAX_JOINTS]);
            let differs = |other: &[f64; MAX_JOINTS]| {
                (0..arm.dof()).any(|i| turn_between(solution.q[i], other[i]).abs() > 1e-3)
            };
            if found.iter().all(differs) {
                found.push(solution.q);
            }
        }
        found
    }

    /// Levenberg-Marquardt with damping proportional to the squared error
    /// (Sugihara 2011, IEEE T-RO 27(5)); joints on a limit and pushed outward are held.
    ///
    /// Equation: rig.inverse_kinematics
    /// `dq = J' (J J' + lambda 1)^-1 e, lambda proportional to e'e`
    /// Source: Sugihara 2011, IEEE T-RO 27(5).
    /// Test: `random_reachable_poses_are_found`.
    fn descend(&self, arm: &SerialArm, goal: &ToolGoal, mut q: [f64; MAX_JOINTS]) -> InverseSolution {
        let mut iterations = 0;
        loop {
            let frames = arm.frames(&q);
            let (dp, dr) = twist_to(&frames[arm.dof()], goal);
            let (position_error, angle_error) = (dp.norm(), dr.norm());
            let reached = position_error <= self.position_tolerance && angle_error <= self.angle_tolerance;
            if reached || iterations == self.iterations {
                let status = if reached { InverseStatus::Solved } else { InverseStatus::NotReached };
                return InverseSolution { q, position_error, angle_error, iterations, restarts: 0, status };
            }
            let step = damped_step(arm, &frames, &q, dp, dr);
            for (i, joint) in arm.joints.iter().enumerate() {
                q[i] = (q[i] + step[i]).clamp(joint.low, joint.high);
            }
            iterations += 1;
        }
    }
}

/// One step J' (J J' + lambda I)^-1 e with the joints that a limit holds taken out.
fn damped_step(
    arm: &SerialArm,
    frames: &[Pose; MAX_JOINTS + 1],
    q: &[f64; MAX_JOINTS],
    dp: Vec3,
    dr: Vec3,
) -> [f64; MAX_JOINTS] {
    let mut jacobian = arm.jacobian(frames);
    let e = [dp[0], dp[1], dp[2], dr[0] * LENGTH_SCALE, dr[1] * LENGTH_SCALE, dr[2] * LENGTH_SCALE];
    let damping = 0.5 * e.iter().map(|x| x * x).sum::<f64>() * 1e-1 + 1e-14;
    let mut step = [0.0; MAX_JOINTS];
    for _ in 0..arm.dof() {
        let mut gram = jacobian.gram(LENGTH_SCALE);
        for (i, row) in gram.iter_mut().enumerate() {
            row[i] += damping;
        }
        let Some(mut y) = solve_symmetric(gram, e) else { return [0.0; MAX_JOINTS] };
        for value in &mut y[3..] {
            *value *= LENGTH_SCALE;
        }
        step = jacobian.transpose_mul(y);
        let held = (0..arm.dof()).find(|&i| {
            let joint = &arm.joints[i];
            (q[i] <= joint.low && step[i] < 0.0) || (q[i] >= joint.high && step[i] > 0.0)
        });
        match held {
            Some(i) => jacobian.columns[i] = [0.0; 6],
            None => break,
        }
    }
    let largest = step.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if largest > 1.0 { step.map(|x| x / largest) } else { step }
}

/// Displacement (m) and rotation vector (rad) from `at` to `goal`, in the base frame.
pub fn twist_to(at: &Pose, goal: &ToolGoal) -> (Vec3, Vec3) {
    (goal.origin - at.origin, rotation_vector(&(goal.rotation * at.rotation.transpose())))
}

fn error(s: &InverseSolution) -> f64 {
    s.position_error + s.angle_error * LENGTH_SCALE
}

fn start_from(arm: &SerialArm, seed: &[f64]) -> [f64; MAX_JOINTS] {
    let mut q = [0.0; MAX_JOINTS];
    for (i, joint) in arm.joints.iter().enumerate() {
        q[i] = seed[i].clamp(joint.low, joint.high);
    }
    q
}

fn random_start(arm: &SerialArm, random: &mut Random) -> [f64; MAX_JOINTS] {
    let mut q = [0.0; MAX_JOINTS];
    for (x, joint) in q.iter_mut().zip(&arm.joints) {
        *x = random.between(joint.low.max(-PI), joint.high.min(PI));
    }
    q
}

/// Brings continuous joints within half a turn of `seed`.
fn unwind(arm: &SerialArm, q: &mut [f64; MAX_JOINTS], seed: &[f64]) {
    for (i, joint) in arm.joints.iter().enumerate() {
        if joint.continuous() {
            q[i] = seed[i] + turn_between(q[i], seed[i]);
        }
    }
}

/// a - b brought into [-pi, pi], rad.
fn turn_between(a: f64, b: f64) -> f64 {
    (a - b) - whole_turns(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::ArmConfig;

    #[test]
    fn random_reachable_poses_are_found() {
        let arm = ArmConfig::kinova_gen3().build().unwrap();
        let solver = InverseKinematics::default();
        let mut random = Random::new(11);
        let mut steps = 0;
        for k in 0..200 {
            let goal = arm.tool_pose(&random_start(&arm, &mut random));
            let s = solver.solve(&arm, &goal, &[0.3, 0.4, -0.9, 0.0, -0.7, 0.0]);
            steps += s.iterations;
            assert_eq!(s.status, InverseStatus::Solved, "pose {k}: {s:?}");
            assert!(arm.beyond_limits(&s.q, 0.0).is_none());
        }
        println!("mean steps {}", steps as f64 / 200.0);
    }

    #[test]
    fn an_unreachable_pose_says_how_far_it_stays() {
        let arm = ArmConfig::kinova_gen3().build().unwrap();
        let goal = Pose::from_xyz_rpy([2.0, 0.0, 0.5], [0.0; 3]);
        let s = InverseKinematics { restarts: 5, ..Default::default() }.solve(&arm, &goal, &[0.1; 6]);
        assert!(s.status == InverseStatus::NotReached && s.position_error > 0.9);
    }

    #[test]
    fn several_postures_reach_one_pose() {
        let arm = ArmConfig::kinova_gen3().build().unwrap();
        let goal = arm.tool_pose(&[0.3, 0.4, -1.2, 0.2, -0.7, 0.5]);
        let found = InverseKinematics::default().postures(&arm, &goal, 60);
        assert!(found.len() >= 4, "{found:?}");
        for q in &found {
            let (dp, dr) = twist_to(&arm.tool_pose(q), &goal);
            assert!(dp.norm() < 1e-9 && dr.norm() < 1e-9);
        }
    }
}
