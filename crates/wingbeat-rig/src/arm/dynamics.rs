//! Inverse dynamics: the joint torques of a motion with a payload.

use super::{LinkBody, MAX_JOINTS, SerialArm};
use crate::{FrameMotion, Pose};
use wingbeat_math::{GRAVITY, Jet, Vec3};

/// What the tool carries: mass, centre and inertia in the tool frame.
pub type Payload = LinkBody;

/// Position, rate and acceleration of each joint.
pub type JointMotion = [Jet; MAX_JOINTS];

impl SerialArm {
    /// Joint torques (N m; forces in N for sliding joints) that produce the
    /// motion `q` under gravity along -z of the base.
    ///
    /// Virtual work of Newton-Euler loads: tau_i = sum over the bodies beyond
    /// joint i of axis_i . ((c - p_i) x m (a - g) + dL/dt) (Featherstone 2008, 5.3).
    ///
    /// Equation: rig.arm_torques
    /// `t_i = sum_j a_i . ((c_j - p_i) x m_j (a_j - g) + dL_j/dt)`
    /// Source: Newton-Euler; Featherstone 2008, section 5.3.
    /// Test: `torques_do_the_work_that_changes_the_energy`.
    pub fn torques(&self, q: &[Jet], payload: &Payload) -> [f64; MAX_JOINTS] {
        let frames = self.frames(q);
        let axes: [Vec3; MAX_JOINTS] = std::array::from_fn(|i| match self.joints.get(i) {
            Some(joint) => frames[i].values().rotation * joint.axis,
            None => Vec3::ZERO,
        });
        let mut torques = [0.0; MAX_JOINTS];
        let carried = self.links.iter().enumerate().chain([(self.dof(), payload)]);
        for (j, body) in carried {
            let (force, spin, com) = inertial_load(&frames[j], body);
            for i in 0..=j.min(self.dof() - 1) {
                torques[i] += match self.joints[i].kind {
                    super::ArmJointKind::Revolute => {
                        axes[i].dot((com - frames[i].origin.values()).cross(force) + spin)
                    }
                    super::ArmJointKind::Prismatic => axes[i].dot(force),
                };
            }
        }
        torques
    }
}

/// Force m (a - g), moment dL/dt about the centre of mass, and that centre, in the base frame.
fn inertial_load(frame: &Pose<Jet>, body: &LinkBody) -> (Vec3, Vec3, Vec3) {
    let motion = FrameMotion::from_jets(frame);
    let a = motion.point_acceleration(body.com) + Vec3([0.0, 0.0, GRAVITY]);
    (a * body.mass, motion.spin_rate(body.inertia), motion.pose.point(body.com))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::ArmConfig;
    use wingbeat_math::{Mat3, Scalar};

    const PAYLOAD: Payload = Payload {
        mass: 0.2,
        com: Vec3([0.01, -0.02, 0.06]),
        inertia: Mat3([[2e-4, 0.0, 0.0], [0.0, 3e-4, 0.0], [0.0, 0.0, 1e-4]]),
        radius: 0.0,
    };

    /// Kinetic plus potential energy, J.
    fn energy(arm: &SerialArm, q: &[Jet]) -> f64 {
        let frames = arm.frames(q);
        let bodies = arm.links.iter().chain([&PAYLOAD]).zip(&frames);
        bodies
            .map(|(body, frame)| {
                let m = FrameMotion::from_jets(frame);
                let lever = m.pose.rotation * body.com;
                let v = m.velocity + m.rate.cross(lever);
                let w = m.pose.rotation.transpose_mul(m.rate);
                let height = m.pose.point(body.com)[2];
                0.5 * (body.mass * v.norm_squared() + w.dot(body.inertia * w)) + body.mass * GRAVITY * height
            })
            .sum()
    }

    #[test]
    fn torques_do_the_work_that_changes_the_energy() {
        let arm = ArmConfig::kinova_gen3().build().unwrap();
        let at = |t: f64| -> [Jet; 6] {
            std::array::from_fn(|i| {
                let phase = Jet::new(t, 1.0, 0.0) * (1.0 + 0.3 * i as f64) + i as f64;
                phase.sin() * (0.6 - 0.05 * i as f64)
            })
        };
        let q = at(0.4);
        let torques = arm.torques(&q, &PAYLOAD);
        let power: f64 = q.iter().zip(torques).map(|(q, tau)| q.d * tau).sum();
        let h = 1e-3;
        let e = |k: f64| energy(&arm, &at(0.4 + k * h));
        let slope = (8.0 * (e(1.0) - e(-1.0)) - (e(2.0) - e(-2.0))) / (12.0 * h);
        assert!((power - slope).abs() < 1e-9 * slope.abs().max(1.0), "{power} {slope}");
    }
}
