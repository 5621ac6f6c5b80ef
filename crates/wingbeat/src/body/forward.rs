//! Forward dynamics with every joint free.

use super::MAX_LINKS;
use super::dynamics::{BaseAcceleration, mass_matrix};
use super::motion::LinkMotion;
use super::tree::{Node, Tree};
use crate::math::linear::solve_symmetric;
use crate::math::{Scalar, Vec3, Wrench};

/// Accelerations of the tree with free joints.
#[derive(Clone, Copy, Debug)]
pub struct FreeAcceleration<S: Scalar = f64> {
    /// Base acceleration, in B.
    pub base: BaseAcceleration<S>,
    /// Joint accelerations, rad/s2, one per link.
    pub joints: [S; MAX_LINKS],
}

type Spatial<S> = [S; 6];

/// Articulated inertia and bias wrench of one subtree, about the body origin.
#[derive(Clone, Copy)]
struct Articulated<S> {
    inertia: [Spatial<S>; 6],
    bias: Spatial<S>,
}

/// What the outward pass needs of one joint.
#[derive(Clone, Copy)]
struct Hinge<S> {
    /// Motion of the body-fixed point at the body origin per unit joint rate.
    axis: Spatial<S>,
    /// Articulated inertia times `axis`.
    inertia: Spatial<S>,
    /// 1 / (axis . inertia).
    inverse: S,
    /// Torque left for acceleration.
    torque: S,
}

impl Tree {
    /// Equation: body.articulated
    ///
    /// Accelerations of base and joints for the joint torques `torques` (N m) and
    /// external wrenches (gravity `g_b` is added), by the articulated-body
    /// algorithm (Featherstone 2008, table 7.1). Every quantity is resolved in B
    /// about the body origin, so no inertia is ever transformed between links.
    ///
    /// `motions` comes from [`Tree::motions`] with zero joint accelerations; `base_wrench`
    /// acts on the base, `external[i]` on link i. None when a mass matrix is not
    /// positive definite (a massless tip).
    pub fn forward_dynamics<S: Scalar>(
        &self,
        w_b: Vec3<S>,
        motions: &[LinkMotion<S>],
        torques: &[S],
        g_b: Vec3<S>,
        base_wrench: Wrench<S>,
        external: &[Wrench<S>],
    ) -> Option<FreeAcceleration<S>> {
        let mut bodies = [Articulated { inertia: [[S::ZERO; 6]; 6], bias: [S::ZERO; 6] }; MAX_LINKS];
        let mut base = self.own(None, &LinkMotion::base(Vec3::ZERO, w_b), g_b, base_wrench);
        let mut hinges =
            [Hinge { axis: [S::ZERO; 6], inertia: [S::ZERO; 6], inverse: S::ZERO, torque: S::ZERO };
                MAX_LINKS];
        for i in (0..self.nodes.len()).rev() {
            let node = &self.nodes[i];
            bodies[i].add(&self.own(Some(node), &motions[i], g_b, external[i]));
            hinges[i] = Hinge::new(node, &motions[i], &bodies[i], torques[i])?;
            let reduced = bodies[i].through(&hinges[i]);
            match node.parent {
                Some(p) => bodies[p].add(&reduced),
                None => base.add(&reduced),
            }
        }
        let x = solve_symmetric(base.inertia, base.bias.map(|b| -b))?;
        Some(FreeAcceleration { base: BaseAcceleration::from_slice(&x), joints: self.outward(x, &hinges) })
    }

    /// Joint accelerations from the base outwards: q'' = (u - U . x_parent) / D.
    fn outward<S: Scalar>(&self, base: Spatial<S>, hinges: &[Hinge<S>]) -> [S; MAX_LINKS] {
        let mut field = [[S::ZERO; 6]; MAX_LINKS];
        let mut joints = [S::ZERO; MAX_LINKS];
        for (i, node) in self.nodes.iter().enumerate() {
            let parent = node.parent.map_or(base, |p| field[p]);
            let hinge = &hinges[i];
            joints[i] = (hinge.torque - dot(&hinge.inertia, &parent)) * hinge.inverse;
            field[i] = std::array::from_fn(|k| parent[k] + hinge.axis[k] * joints[i]);
        }
        joints
    }

    /// Inertia and bias of one body alone (None: the base), with its external wrench.
    fn own<S: Scalar>(
        &self,
        node: Option<&Node>,
        motion: &LinkMotion<S>,
        g_b: Vec3<S>,
        external: Wrench<S>,
    ) -> Articulated<S> {
        let Some(body) = node.map_or(Some(&self.base), |n| n.inertia.as_ref()) else {
            return Articulated {
                inertia: [[S::ZERO; 6]; 6],
                bias: spatial(-external.force, -external.moment),
            };
        };
        let reaction = body.reaction(motion);
        let first_moment = reaction.com.scaled(body.mass);
        let weight = Wrench { force: g_b.scaled(body.mass), moment: first_moment.cross(g_b) };
        let load = reaction.bias + -weight + -external;
        Articulated {
            inertia: mass_matrix(body.mass, first_moment, &reaction.about_origin),
            bias: spatial(load.force, load.moment),
        }
    }
}

impl<S: Scalar> Hinge<S> {
    fn new(node: &Node, motion: &LinkMotion<S>, body: &Articulated<S>, torque: S) -> Option<Self> {
        let direction = node.axis.direction(&motion.rotation);
        let axis = spatial(motion.position.cross(direction), direction);
        let inertia = std::array::from_fn(|i| dot(&body.inertia[i], &axis));
        let effective = dot(&axis, &inertia);
        if !(effective.value() > 0.0) {
            return None;
        }
        let torque = torque - dot(&axis, &body.bias);
        Some(Self { axis, inertia, inverse: effective.recip(), torque })
    }
}

impl<S: Scalar> Articulated<S> {
    fn add(&mut self, o: &Self) {
        for i in 0..6 {
            self.bias[i] += o.bias[i];
            for j in 0..6 {
                self.inertia[i][j] += o.inertia[i][j];
            }
        }
    }

    /// As felt through the hinge: I - U U'/D, p + U u/D.
    fn through(&self, hinge: &Hinge<S>) -> Self {
        let mut seen = *self;
        let push = hinge.torque * hinge.inverse;
        for i in 0..6 {
            let scaled = hinge.inertia[i] * hinge.inverse;
            seen.bias[i] += hinge.inertia[i] * push;
            for j in 0..6 {
                seen.inertia[i][j] -= scaled * hinge.inertia[j];
            }
        }
        seen
    }
}

#[inline]
fn spatial<S: Scalar>(linear: Vec3<S>, angular: Vec3<S>) -> Spatial<S> {
    let ([a, b, c], [d, e, f]) = (linear.0, angular.0);
    [a, b, c, d, e, f]
}

#[inline]
fn dot<S: Scalar>(a: &Spatial<S>, b: &Spatial<S>) -> S {
    (1..6).fold(a[0] * b[0], |sum, i| sum + a[i] * b[i])
}
