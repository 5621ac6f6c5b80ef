//! Forward dynamics with every joint free.

use super::dynamics::BaseAcceleration;
use super::inertia::{Reaction, Symmetric};
use super::motion::LinkMotion;
use super::tree::{LinkNode, Tree};
use wingbeat_math::linear::solve_symmetric;
use wingbeat_math::{Mat3, Meets, Scalar, Vec3, Wrench};

/// Accelerations of the tree with free joints.
#[derive(Clone, Copy, Debug)]
pub struct FreeAcceleration<const N: usize, S: Scalar = f64> {
    /// Base acceleration, in B.
    pub base: BaseAcceleration<S>,
    /// Joint accelerations, rad/s2, one per link.
    pub joints: [S; N],
}

/// Articulated inertia [linear, cross; cross', angular] and bias wrench of one subtree,
/// about the body origin.
#[derive(Clone, Copy)]
struct Articulated<S: Scalar> {
    linear: Symmetric<S>,
    cross: Mat3<S>,
    angular: Symmetric<S>,
    bias: Wrench<S>,
}

/// What the outward pass needs of one joint.
#[derive(Clone, Copy)]
struct JointPass<S: Scalar> {
    /// Acceleration field about the body origin per unit joint acceleration.
    axis: BaseAcceleration<S>,
    /// Articulated inertia times `axis`.
    reaction: Wrench<S>,
    /// 1 / (axis . reaction).
    inverse: S,
    /// Torque left for acceleration.
    torque: S,
}

impl<P: Scalar> Tree<P> {
    /// Equation: body.articulated
    /// `I_p += I - U U'/D, p_p += p + U u/D, q'' = (u - U . x_p) / D`
    /// Source: Featherstone 2008, table 7.1.
    /// Test: `free_joints_agree_with_pinocchio`.
    ///
    /// Accelerations of base and joints for the joint efforts `torques` (N m, or N along a slide) and
    /// external wrenches (gravity `g_b` is added), by the articulated-body
    /// algorithm (Featherstone 2008, table 7.1). Every quantity is resolved in B
    /// about the body origin, so no inertia is ever transformed between links.
    ///
    /// `motions` comes from [`Tree::motions`] with zero joint accelerations; `base_wrench`
    /// acts on the base, `external[i]` on link i; `N` is at least the number of links.
    /// None when a mass matrix is not positive definite (a massless tip).
    pub fn forward_dynamics<const N: usize, S: Scalar + Meets<P>>(
        &self,
        w_b: Vec3<S>,
        motions: &[LinkMotion<S>],
        torques: &[S; N],
        g_b: Vec3<S>,
        base_wrench: Wrench<S>,
        external: &[Wrench<S>; N],
    ) -> Option<FreeAcceleration<N, S>> {
        let mut bodies = [Articulated::ZERO; N];
        let mut hinges = [JointPass::ZERO; N];
        let mut base = Articulated::ZERO;
        base.add_body(self.base.mass, &self.base.reaction_of_base(&w_b), g_b);
        base.bias += -base_wrench;
        for (i, node) in self.nodes.iter().enumerate().rev() {
            let body = &mut bodies[i];
            if let Some(inertia) = &node.inertia {
                body.add_body(inertia.mass, &inertia.reaction(&motions[i]), g_b);
            }
            body.bias += -external[i];
            let hinge = JointPass::new(node, &motions[i], body, torques[i])?;
            let seen = body.through(&hinge);
            hinges[i] = hinge;
            match node.parent {
                Some(p) => bodies[p].add(&seen),
                None => base.add(&seen),
            }
        }
        let base = base.freely_accelerated()?;
        Some(FreeAcceleration { base, joints: self.outward(base, &hinges) })
    }

    /// Joint accelerations from the base outwards: q'' = (u - U . x_parent) / D.
    fn outward<const N: usize, S: Scalar + Meets<P>>(
        &self,
        base: BaseAcceleration<S>,
        hinges: &[JointPass<S>; N],
    ) -> [S; N] {
        let mut fields = [base; N];
        let mut joints = [S::ZERO; N];
        for (i, node) in self.nodes.iter().enumerate() {
            let (parent, hinge) = (node.parent.map_or(base, |p| fields[p]), &hinges[i]);
            joints[i] = (hinge.torque - parent.power(&hinge.reaction)) * hinge.inverse;
            fields[i] = BaseAcceleration {
                origin: parent.origin + hinge.axis.origin * joints[i],
                angular: parent.angular + hinge.axis.angular * joints[i],
            };
        }
        joints
    }
}

impl<S: Scalar> JointPass<S> {
    const ZERO: Self = Self {
        axis: BaseAcceleration { origin: Vec3::ZERO, angular: Vec3::ZERO },
        reaction: Wrench::ZERO,
        inverse: S::ZERO,
        torque: S::ZERO,
    };

    #[inline]
    fn new<P: Scalar>(
        node: &LinkNode<P>,
        motion: &LinkMotion<S>,
        body: &Articulated<S>,
        torque: S,
    ) -> Option<Self> {
        let axis = node.field(motion);
        let reaction = body.apply(&axis);
        let effective = axis.power(&reaction);
        if !(effective.value() > 0.0) {
            return None;
        }
        let torque = torque - axis.power(&body.bias);
        Some(Self { axis, reaction, inverse: effective.recip(), torque })
    }
}

impl<S: Scalar> Articulated<S> {
    const ZERO: Self = Self {
        linear: Symmetric([S::ZERO; 6]),
        cross: Mat3::ZERO,
        angular: Symmetric([S::ZERO; 6]),
        bias: Wrench::ZERO,
    };

    /// Adds a rigid body with its weight.
    #[inline]
    fn add_body<P: Scalar>(&mut self, mass: P, reaction: &Reaction<S>, g_b: Vec3<S>)
    where
        S: Meets<P>,
    {
        let h = reaction.com.scaled(mass);
        for diagonal in &mut self.linear.0[..3] {
            *diagonal += S::from(mass);
        }
        let [x, y, z] = h.0;
        for (i, j, entry) in [(0, 1, z), (1, 2, x), (2, 0, y)] {
            self.cross.0[i][j] += entry;
            self.cross.0[j][i] -= entry;
        }
        self.angular.add(&reaction.about_origin);
        self.bias += reaction.bias + -Wrench { force: g_b.scaled(mass), moment: h.cross(g_b) };
    }

    #[inline]
    fn add(&mut self, o: &Self) {
        self.linear.add(&o.linear);
        self.angular.add(&o.angular);
        for (row, other) in self.cross.0.iter_mut().flatten().zip(o.cross.0.iter().flatten()) {
            *row += *other;
        }
        self.bias += o.bias;
    }

    /// Wrench of an acceleration field, without the bias.
    #[inline]
    fn apply(&self, x: &BaseAcceleration<S>) -> Wrench<S> {
        Wrench {
            force: self.linear.apply(&x.origin) + self.cross * x.angular,
            moment: self.cross.transpose_mul(x.origin) + self.angular.apply(&x.angular),
        }
    }

    /// As felt through the hinge: I - U U'/D, p + U u/D.
    #[inline]
    fn through(&self, hinge: &JointPass<S>) -> Self {
        let (mut seen, Wrench { force, moment }) = (*self, hinge.reaction);
        let (f, m) = (force * -hinge.inverse, moment * -hinge.inverse);
        seen.linear.add_product(&f, &force);
        seen.angular.add_product(&m, &moment);
        for i in 0..3 {
            for j in 0..3 {
                seen.cross.0[i][j] += f[i] * moment[j];
            }
        }
        seen.bias += Wrench { force: f * -hinge.torque, moment: m * -hinge.torque };
        seen
    }

    /// Acceleration of the whole without further load.
    fn freely_accelerated(&self) -> Option<BaseAcceleration<S>> {
        let (linear, angular) = (self.linear.full(), self.angular.full());
        let mut matrix = [[S::ZERO; 6]; 6];
        for i in 0..3 {
            for j in 0..3 {
                matrix[i][j] = linear.0[i][j];
                matrix[i][j + 3] = self.cross.0[i][j];
                matrix[j + 3][i] = self.cross.0[i][j];
                matrix[i + 3][j + 3] = angular.0[i][j];
            }
        }
        let ([fx, fy, fz], [tx, ty, tz]) = (self.bias.force.0, self.bias.moment.0);
        let x = solve_symmetric(matrix, [-fx, -fy, -fz, -tx, -ty, -tz])?;
        Some(BaseAcceleration::from_slice(&x))
    }
}
