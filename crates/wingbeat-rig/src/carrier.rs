//! What carries the robot: the arm playing a trajectory, or a fixed stand, and
//! the mount with the load cell between.

use super::arm::{MAX_JOINTS, SerialArm};
use super::{FrameMotion, JointTrajectory, Pose};
use wingbeat_math::{GRAVITY, Jet, Mat3, Scalar, Vec3, Wrench};
use wingbeat_robot::BodyMotion;

/// The cell and what sits on its far side, rigidly. Its numbers may carry derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellMount<P: Scalar = f64> {
    /// Sensing frame C of the cell in the tool frame, X_TC.
    pub cell: Pose,
    /// Robot body in the cell frame, X_CB.
    pub body: Pose<P>,
    /// Mass between sensing element and robot, kg.
    pub mass: P,
    /// Its centre in C, m.
    pub com: Vec3<P>,
    /// Its inertia about that centre, in C axes, kg m2.
    pub inertia: Mat3,
}

impl<S: Scalar> CellMount<S> {
    /// Wrench, N and N m, that the mount itself puts on the cell while it moves as `cell`, about the cell's origin, in C:
    /// weight and inertia.
    ///
    /// Equation: rig.mount_wrench
    /// `F = -m (a_c - g), M = c x F - (I w' + w x I w)`
    /// Source: Newton-Euler.
    /// Test: `wrenches_go_to_the_cell_and_back`.
    pub fn wrench(&self, cell: &FrameMotion) -> Wrench<S> {
        let a = cell.point_acceleration(self.com) + Vec3::constant(Vec3([0.0, 0.0, GRAVITY]));
        let r = cell.pose.rotation;
        let force = Mat3::<S>::constant(r).transpose_mul(a) * -self.mass;
        let spin = r.transpose_mul(cell.spin_rate(self.inertia));
        Wrench { force, moment: self.com.cross(force) - Vec3::constant(spin) }
    }

    /// A wrench (N and N m) about the body origin in B as a wrench about the cell's origin in C.
    pub fn to_cell(&self, body: &Wrench<S>) -> Wrench<S> {
        let force = self.body.rotation * body.force;
        Wrench { force, moment: self.body.rotation * body.moment + self.body.origin.cross(force) }
    }

    /// A wrench (N and N m) about the cell's origin in C as a wrench about the body origin in B.
    pub fn to_body(&self, cell: &Wrench<S>) -> Wrench<S> {
        let about_body = cell.moment - self.body.origin.cross(cell.force);
        let turn = |v: Vec3<S>| self.body.rotation.transpose_mul(v);
        Wrench { force: turn(cell.force), moment: turn(about_body) }
    }

    /// Motion of the body while the sensing frame moves as `cell`.
    pub fn body_motion(&self, cell: &FrameMotion) -> BodyMotion<S> {
        let attitude = Mat3::<S>::constant(cell.pose.rotation) * self.body.rotation;
        let turned = |v: Vec3| attitude.transpose_mul(Vec3::constant(v));
        BodyMotion {
            attitude,
            velocity: cell.point_velocity(self.body.origin),
            rate: turned(cell.rate),
            acceleration: cell.point_acceleration(self.body.origin),
            angular_acceleration: turned(cell.angular_acceleration),
        }
    }
}

/// What moves the tool.
#[derive(Clone, Debug)]
pub enum ToolCarrier {
    /// An arm that plays a trajectory and stands still before and after.
    Arm {
        /// The arm.
        arm: Box<SerialArm>,
        /// Its motion.
        trajectory: JointTrajectory,
    },
    /// A stand that holds the tool in one placement after another, without motion between.
    Stand {
        /// (time at which it begins in s, placement X_WT), ascending.
        holds: Vec<(f64, Pose)>,
    },
}

impl ToolCarrier {
    /// Duration of the motion, s.
    pub fn duration(&self) -> f64 {
        match self {
            Self::Arm { trajectory, .. } => trajectory.duration(),
            Self::Stand { holds } => holds.last().map_or(0.0, |hold| hold.0),
        }
    }

    /// Joint positions, rad, with rates and accelerations at `t`; none for a stand.
    pub fn joints(&self, t: f64) -> Option<[Jet; MAX_JOINTS]> {
        match self {
            Self::Arm { trajectory, .. } => Some(trajectory.at(t)),
            Self::Stand { .. } => None,
        }
    }

    /// Placement X_WT of the tool along time.
    pub fn tool(&self, t: f64) -> Pose<Jet> {
        match self {
            Self::Arm { arm, trajectory } => arm.tool_pose(&trajectory.at(t)),
            Self::Stand { holds } => {
                let index = holds.partition_point(|hold| hold.0 <= t).max(1) - 1;
                holds.get(index).map_or(Pose::IDENTITY, |hold| Pose::constant(&hold.1))
            }
        }
    }
}

/// The motions of cell and body that follow from the tool's.
pub fn carried_frames(tool: &Pose<Jet>, mount: &CellMount) -> (FrameMotion, FrameMotion) {
    let cell = *tool * Pose::constant(&mount.cell);
    let body = cell * Pose::constant(&mount.body);
    (FrameMotion::from_jets(&cell), FrameMotion::from_jets(&body))
}

impl From<&FrameMotion> for BodyMotion {
    fn from(m: &FrameMotion) -> Self {
        let r = m.pose.rotation;
        Self {
            attitude: r,
            velocity: m.velocity,
            rate: r.transpose_mul(m.rate),
            acceleration: m.acceleration,
            angular_acceleration: r.transpose_mul(m.angular_acceleration),
        }
    }
}

impl JointTrajectory {
    /// Joint motion, rad, at `t` by quintic Hermite polynomials between the samples; the first pose before, the last after.
    /// Without stored accelerations or rates these count as zero at the samples.
    pub fn at(&self, t: f64) -> [Jet; MAX_JOINTS] {
        let mut q = [Jet::default(); MAX_JOINTS];
        let last = self.len().saturating_sub(1);
        let share = (t / self.step).clamp(0.0, last as f64);
        let k = (share as usize).min(last.saturating_sub(1));
        let rest = t <= 0.0 || t >= self.duration();
        for (j, q) in q.iter_mut().enumerate().take(self.joints.len()) {
            let end = |i: usize| {
                let or_zero = |rows: &[Vec<f64>]| rows.get(i).map_or(0.0, |row| row[j]);
                Jet::new(self.position[i][j], or_zero(&self.velocity), or_zero(&self.acceleration))
            };
            *q = match (rest, last) {
                (_, 0) => Jet::new(self.position[0][j], 0.0, 0.0),
                (true, _) => Jet::new(self.position[if t <= 0.0 { 0 } else { last }][j], 0.0, 0.0),
                _ => quintic(end(k), end(k + 1), self.step, share - k as f64),
            };
        }
        q
    }
}

/// Quintic Hermite polynomial between two jets, `h` s apart, at the share `s` in [0, 1].
fn quintic(a: Jet, b: Jet, h: f64, s: f64) -> Jet {
    let (av, aa) = (a.d * h, 0.5 * a.dd * h * h);
    let (bv, ba) = (b.d * h, b.dd * h * h);
    let x = b.x - a.x - av - aa;
    let v = bv - av - 2.0 * aa;
    let w = ba - 2.0 * aa;
    let c3 = 10.0 * x - 4.0 * v + 0.5 * w;
    let c4 = -15.0 * x + 7.0 * v - w;
    let c5 = 6.0 * x - 3.0 * v + 0.5 * w;
    let value = a.x + s * (av + s * (aa + s * (c3 + s * (c4 + s * c5))));
    let slope = av + s * (2.0 * aa + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)));
    let bend = 2.0 * aa + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5));
    Jet::new(value, slope / h, bend / (h * h))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quintic_reproduces_a_quintic() {
        let f = |t: f64| {
            let t = Jet::new(t, 1.0, 0.0);
            t * t * t * t * t * 0.7 - t * t * t * 2.0 + t * 0.5 + 1.0
        };
        let (x, y) = (quintic(f(0.2), f(0.9), 0.7, 0.3), f(0.2 + 0.21));
        assert!((x.x - y.x).abs() < 1e-14 && (x.d - y.d).abs() < 1e-13 && (x.dd - y.dd).abs() < 1e-12);
    }

    #[test]
    fn wrenches_go_to_the_cell_and_back() {
        let mount = CellMount {
            cell: Pose::IDENTITY,
            body: Pose::from_xyz_rpy([0.01, -0.02, 0.08], [3.0, 0.2, -0.4]),
            mass: 0.0,
            com: Vec3::ZERO,
            inertia: Mat3::ZERO,
        };
        let w = Wrench { force: Vec3([1.0, -2.0, 0.5]), moment: Vec3([0.1, 0.2, -0.3]) };
        let back = mount.to_body(&mount.to_cell(&w));
        assert!((back.force - w.force).norm() < 1e-15 && (back.moment - w.moment).norm() < 1e-15);
    }
}
