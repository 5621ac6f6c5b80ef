//! Distances between the arm, the flapping robot and the table.

use crate::Pose;
use crate::arm::{MAX_JOINTS, SerialArm};
use wingbeat_math::{Vec3, segment_distance};

/// The space that the flapping wings sweep, as points in the body frame, m.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Envelope {
    /// Points of the body and of wing outlines over a stroke.
    pub points: Vec<Vec3>,
}

impl Envelope {
    /// A fan: wings of `half_span` turned from `low` to `high` (rad, positive up) about the
    /// body's x axis, `front` ahead and `back` behind the origin, m.
    pub fn fan(half_span: f64, low: f64, high: f64, front: f64, back: f64) -> Self {
        const ANGLES: usize = 5;
        let mut points = vec![Vec3([front, 0.0, 0.0]), Vec3([-back, 0.0, 0.0])];
        for k in 0..ANGLES {
            let (sin, cos) = (low + (high - low) * k as f64 / (ANGLES - 1) as f64).sin_cos();
            for share in [0.33, 0.67, 1.0] {
                let (y, z) = (half_span * share * cos, half_span * share * sin);
                for x in [front, -back] {
                    points.extend([Vec3([x, y, z]), Vec3([x, -y, z])]);
                }
            }
        }
        Self { points }
    }
}

/// Smallest distances along a motion, m; negative means contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Between the table and the arm beyond its shoulder or the wings.
    pub table: f64,
    /// Between links of the arm that are not neighbours.
    pub arm: f64,
    /// Between the wings' envelope and the arm.
    pub wings: f64,
}

impl Clearance {
    /// Nothing near.
    pub const FREE: Self = Self { table: f64::INFINITY, arm: f64::INFINITY, wings: f64::INFINITY };

    /// The smaller of each.
    pub fn min(self, o: Self) -> Self {
        Self { table: self.table.min(o.table), arm: self.arm.min(o.arm), wings: self.wings.min(o.wings) }
    }
    /// The smallest of all, m.
    pub fn smallest(self) -> f64 {
        self.table.min(self.arm).min(self.wings)
    }
}

/// A link as a capsule: the segment between two points and a radius.
#[derive(Clone, Copy, Debug)]
struct LinkCapsule {
    ends: [Vec3; 2],
    radius: f64,
}

/// Clearances of one pose: joint and tool frames from [`SerialArm::frames`],
/// the body at `body`, the table at the height `table` (m) in the base frame.
pub fn clearance(
    arm: &SerialArm,
    frames: &[Pose; MAX_JOINTS + 1],
    body: &Pose,
    envelope: &Envelope,
    table: f64,
) -> Clearance {
    let capsules: Vec<LinkCapsule> = (0..=arm.dof()).map(|i| capsule(arm, frames, i)).collect();
    let mut least = Clearance::FREE;
    for (i, a) in capsules.iter().enumerate() {
        for b in capsules.iter().skip(i + 2) {
            least.arm = least.arm.min(segment_distance(a.ends, b.ends) - a.radius - b.radius);
        }
        if i >= 2 {
            least.table = least.table.min(a.ends[0][2].min(a.ends[1][2]) - a.radius - table);
        }
    }
    for &p in &envelope.points {
        let at = body.point(p);
        least.table = least.table.min(at[2] - table);
        for c in &capsules {
            least.wings = least.wings.min(segment_distance([at, at], c.ends) - c.radius);
        }
    }
    least
}

/// Capsule 0 is the base, capsule i the link that joint i - 1 carries.
fn capsule(arm: &SerialArm, frames: &[Pose; MAX_JOINTS + 1], i: usize) -> LinkCapsule {
    match i.checked_sub(1) {
        None => LinkCapsule { ends: [Vec3::ZERO, frames[0].origin], radius: arm.base.radius },
        Some(link) => LinkCapsule {
            ends: [frames[link].origin, frames[link + 1].origin],
            radius: arm.links[link].radius,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_upright_arm_stands_clear() {
        let arm = crate::arm::ArmConfig::kinova_gen3().build().unwrap();
        let frames = arm.frames(&[0.0; 6]);
        let body = frames[6] * Pose::from_xyz_rpy([0.0, 0.0, 0.3], [0.0; 3]);
        let c = clearance(&arm, &frames, &body, &Envelope::fan(0.2, -0.85, 1.05, 0.05, 0.1), 0.0);
        assert!(c.table > 0.2 && c.arm > 0.0 && c.wings > 0.05, "{c:?}");
    }
}
