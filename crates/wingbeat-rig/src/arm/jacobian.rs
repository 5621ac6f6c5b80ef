//! The geometric Jacobian and how far it is from singular.

use super::{ArmJointKind, MAX_JOINTS, SerialArm};
use crate::Pose;
use wingbeat_math::Vec3;
use wingbeat_math::linear::symmetric_eigenvalues;

/// Columns d[v; w]/dq_i of the tool's velocity and angular rate in the base
/// frame; the first `dof` are valid.
#[derive(Clone, Copy, Debug)]
pub struct Jacobian {
    /// Columns [vx, vy, vz, wx, wy, wz], m/rad and, dimensionless, rad/rad.
    pub columns: [[f64; 6]; MAX_JOINTS],
    /// Number of joints.
    pub dof: usize,
}

/// Length that makes rotations comparable with displacements in the singular
/// values, m: about the forearm of the arm.
pub const LENGTH_SCALE: f64 = 0.3;

impl SerialArm {
    /// The geometric Jacobian at the tool from [`SerialArm::frames`] (Lynch &
    /// Park, Modern Robotics, 5.1).
    ///
    /// Equation: rig.jacobian
    /// `column [a x (p - p_i); a] of a turning joint`
    /// Source: Lynch & Park, Modern Robotics, 5.1.
    /// Test: `jacobian_is_the_derivative_of_the_pose`.
    pub fn jacobian(&self, frames: &[Pose; MAX_JOINTS + 1]) -> Jacobian {
        let tool = frames[self.dof()].origin;
        let mut columns = [[0.0; 6]; MAX_JOINTS];
        for (i, joint) in self.joints.iter().enumerate() {
            let axis = frames[i].rotation * joint.axis;
            let (v, w) = match joint.kind {
                ArmJointKind::Revolute => (axis.cross(tool - frames[i].origin), axis),
                ArmJointKind::Prismatic => (axis, Vec3::ZERO),
            };
            v.store(&mut columns[i][..3]);
            w.store(&mut columns[i][3..]);
        }
        Jacobian { columns, dof: self.dof() }
    }
}

impl Jacobian {
    /// J J' with rotation rows scaled by `length`, m.
    pub fn gram(&self, length: f64) -> [[f64; 6]; 6] {
        let mut gram = [[0.0; 6]; 6];
        for column in &self.columns[..self.dof] {
            let c: [f64; 6] = std::array::from_fn(|i| if i < 3 { column[i] } else { column[i] * length });
            for i in 0..6 {
                for j in 0..6 {
                    gram[i][j] += c[i] * c[j];
                }
            }
        }
        gram
    }
    /// Smallest singular value, m/rad, with rotations scaled by
    /// `LENGTH_SCALE`; zero at a singularity.
    pub fn singularity_margin(&self) -> f64 {
        symmetric_eigenvalues(self.gram(LENGTH_SCALE))[0].max(0.0).sqrt()
    }
    /// Tool velocity (m/s) and angular rate (rad/s) for the joint rates `dq`.
    pub fn velocity(&self, dq: &[f64]) -> (Vec3, Vec3) {
        let mut twist = [0.0; 6];
        for (column, rate) in self.columns.iter().zip(dq) {
            for i in 0..6 {
                twist[i] += column[i] * rate;
            }
        }
        (Vec3::from_slice(&twist[..3]), Vec3::from_slice(&twist[3..]))
    }
    /// J' [force; moment], N and N m: joint torques, N m, that balance a load on the tool.
    pub fn transpose_mul(&self, load: [f64; 6]) -> [f64; MAX_JOINTS] {
        let dot = |c: &[f64; 6]| c.iter().zip(load).map(|(a, b)| a * b).sum();
        std::array::from_fn(|i| dot(&self.columns[i]))
    }
}

#[cfg(test)]
mod tests {
    use crate::arm::ArmConfig;
    use wingbeat_math::{Dual, Scalar};

    #[test]
    fn jacobian_is_the_derivative_of_the_pose() {
        let arm = ArmConfig::kinova_gen3().build().unwrap();
        let q = [0.4, -0.7, 1.1, 0.3, -0.9, 2.0];
        let jacobian = arm.jacobian(&arm.frames(&q));
        let dual: [Dual<6>; 6] = std::array::from_fn(|i| Dual::variable(q[i], i));
        let pose = arm.tool_pose(&dual);
        let r = pose.values().rotation;
        for i in 0..6 {
            let slope = |x: Dual<6>| x.eps[i];
            for k in 0..3 {
                assert!((jacobian.columns[i][k] - slope(pose.origin[k])).abs() < 1e-14);
            }
            // w = vee(R' dR/dq) rotated to the base: skew(w) = dR/dq R'.
            let dr = pose.rotation.each(slope);
            let skew = dr * r.transpose();
            let w = [skew.0[2][1], skew.0[0][2], skew.0[1][0]];
            for k in 0..3 {
                assert!((jacobian.columns[i][k + 3] - w[k]).abs() < 1e-14);
            }
        }
        assert!(Dual::<6>::ZERO.value() == 0.0);
    }

    #[test]
    fn a_stretched_arm_is_singular() {
        let arm = ArmConfig::kinova_gen3().build().unwrap();
        let at = |q: [f64; 6]| arm.jacobian(&arm.frames(&q)).singularity_margin();
        assert!(at([0.0; 6]) < 1e-9);
        assert!(at([0.4, -0.7, 1.1, 0.3, -0.9, 2.0]) > 0.02);
    }
}
