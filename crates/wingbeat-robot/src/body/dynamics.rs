//! Mass matrix and bias of the whole tree with its joints prescribed, gravity, joint torques.

use super::MAX_LINKS;
use super::inertia::{CompositeBody, LinkInertia, Reaction, Symmetric};
use super::motion::LinkMotion;
use super::tree::{JointKind, Tree};
use wingbeat_math::{Jet, Mat3, Meets, Over, Scalar, Vec3, Wrench};

impl<P: Scalar> Tree<P> {
    /// Equation: body.mass_matrix
    /// `M [a0; w_dot] + bias = external wrench, M = [m 1, -[h]x; [h]x, I]`
    /// Source: Newton-Euler summed over links.
    /// Test: `joint_work_equals_the_change_of_energy`.
    ///
    /// (M, bias) with M [a0; w_dot] + bias = external wrench about the body origin; `a0` is the inertial acceleration of the
    /// body origin and `w_dot` the angular acceleration, both in B; all in SI units. The bias holds the reaction of the
    /// prescribed joint motion and every velocity term, not gravity. `motions` comes from [`Tree::motions`] with the same
    /// `w_b`.
    pub fn inertia_and_bias<S: Scalar + Meets<P>>(
        &self,
        w_b: Vec3<S>,
        motions: &[LinkMotion<S>],
    ) -> ([[S; 6]; 6], Wrench<S>) {
        let mut mass = [[S::ZERO; 6]; 6];
        let (bias, _) = self.inertia_bias_and_moment(w_b, motions, &mut mass);
        (mass, bias)
    }

    /// The same, the mass matrix in place, with the sum of mass times position, kg m.
    #[inline]
    pub(crate) fn inertia_bias_and_moment<S: Scalar + Meets<P>>(
        &self,
        w_b: Vec3<S>,
        motions: &[LinkMotion<S>],
        mass: &mut [[S; 6]; 6],
    ) -> (Wrench<S>, Vec3<S>) {
        let base = self.base.reaction_of_base(&w_b);
        let mut bias = base.bias;
        let mut first_moment = base.com.scaled(self.base.mass);
        let mut about_origin = base.about_origin;
        for i in 0..self.nodes.len() {
            let Some(inertia) = &self.nodes[i].inertia else { continue };
            let link = inertia.reaction(&motions[i]);
            bias += link.bias;
            first_moment += link.com.scaled(inertia.mass);
            about_origin.add(&link.about_origin);
        }
        fill_mass_matrix(mass, self.mass(), first_moment, &about_origin);
        (bias, first_moment)
    }

    /// The wrench about the body origin that base and links need to move as they do, with the base's own acceleration `field`, which
    /// `motions` hold too; then the sum of mass times position, kg m.
    #[inline]
    pub(crate) fn inertial_and_moment<S: Scalar + Meets<P>>(
        &self,
        w_b: Vec3<S>,
        field: &BaseAcceleration<S>,
        motions: &[LinkMotion<S>],
    ) -> (Wrench<S>, Vec3<S>) {
        let base = self.base.reaction_of_base(&w_b);
        let mut needed = base.full(self.base.mass, field.origin, field.angular);
        let mut first_moment = base.com.scaled(self.base.mass);
        for i in 0..self.nodes.len() {
            let Some(inertia) = &self.nodes[i].inertia else { continue };
            let (com, _, of_link) = inertia.needed(&motions[i]);
            needed += of_link;
            first_moment += com.scaled(inertia.mass);
        }
        (needed, first_moment)
    }

    /// Weight of base and links: the wrench about the body origin for the
    /// gravitational acceleration `g_b` in B, m/s2.
    pub fn gravity<S: Scalar + Meets<P>>(&self, g_b: Vec3<S>, motions: &[LinkMotion<S>]) -> Wrench<S> {
        self.weight(g_b, self.first_moment(motions))
    }

    /// The same from the sum of mass times position.
    #[inline]
    pub(crate) fn weight<S: Scalar + Meets<P>>(&self, g_b: Vec3<S>, first_moment: Vec3<S>) -> Wrench<S> {
        Wrench { force: g_b.scaled(self.mass()), moment: first_moment.cross(g_b) }
    }

    /// Total mass, kg.
    #[inline]
    pub fn mass(&self) -> P {
        let mut links = P::ZERO;
        for node in &self.nodes {
            if let Some(inertia) = &node.inertia {
                links += inertia.mass;
            }
        }
        self.base.mass + links
    }

    /// Centre of mass of base and links from the body origin, in B, m.
    pub fn center_of_mass<S: Scalar + Meets<P>>(&self, motions: &[LinkMotion<S>]) -> Vec3<S> {
        self.first_moment(motions).scaled(self.mass().recip())
    }

    /// Sum of mass times position, kg m.
    fn first_moment<S: Scalar + Meets<P>>(&self, motions: &[LinkMotion<S>]) -> Vec3<S> {
        let base = (self.base.com * self.base.mass).met();
        self.massive(motions).fold(base, |sum, (i, m)| sum + m.point(i.com).scaled(i.mass))
    }

    /// The links with mass and their motion.
    pub(super) fn massive<'a, S: Scalar + Meets<P>>(
        &'a self,
        motions: &'a [LinkMotion<S>],
    ) -> impl Iterator<Item = (&'a LinkInertia<P>, &'a LinkMotion<S>)> {
        self.nodes.iter().zip(motions).filter_map(|(node, motion)| Some((node.inertia.as_ref()?, motion)))
    }

    /// Equation: body.joint_torques
    /// `t_i = e_i . (T_i - p_i x F_i), wrenches summed from the tips`
    /// Source: recursive Newton-Euler; Featherstone 2008, table 5.1.
    /// Test: `inverse_dynamics_returns_the_torques_of_forward_dynamics`.
    ///
    /// Effort of every joint, torque about its axis (N m) or force along it (N), that the motion needs, by summing link wrenches from the tips inwards (recursive
    /// Newton-Euler; Featherstone 2008, table 5.1).
    ///
    /// `base` is the base's own acceleration, `g_b` gravity in B, `external[i]` the
    /// wrench on link i about the body origin, in B. One entry per link each.
    pub fn joint_torques<S: Scalar + Meets<P>>(
        &self,
        motions: &[LinkMotion<S>],
        base: BaseAcceleration<S>,
        g_b: Vec3<S>,
        external: &[Wrench<S>],
        torques: &mut [S],
    ) {
        let apparent = base.origin - g_b;
        let mut carried = [Wrench::ZERO; MAX_LINKS];
        for i in (0..self.nodes.len()).rev() {
            let (node, motion) = (&self.nodes[i], &motions[i]);
            let mut needed = carried[i] + -external[i];
            if let Some(inertia) = &node.inertia {
                needed += inertia.reaction(motion).full(inertia.mass, apparent, base.angular);
            }
            let axis = node.axis.direction(&motion.rotation);
            torques[i] = match node.kind {
                JointKind::Revolute => axis.dot(needed.moment - motion.position.cross(needed.force)),
                JointKind::Prismatic => axis.dot(needed.force),
            };
            if let Some(p) = node.parent {
                carried[p] += needed;
            }
        }
    }
}

/// The base's own acceleration, resolved in B.
#[derive(Clone, Copy, Debug, Default)]
pub struct BaseAcceleration<S: Scalar = f64> {
    /// Inertial acceleration of the body origin, m/s2.
    pub origin: Vec3<S>,
    /// Angular acceleration, rad/s2.
    pub angular: Vec3<S>,
}

impl<S: Scalar> BaseAcceleration<S> {
    /// From [origin; angular].
    pub fn from_slice(x: &[S]) -> Self {
        Self { origin: Vec3::from_slice(x), angular: Vec3::from_slice(&x[3..]) }
    }

    /// Virtual power, N m/s2: force times acceleration, of a wrench about the body origin in this field of motion.
    #[inline]
    pub fn power<T: Over<S>>(&self, wrench: &Wrench<T>) -> T {
        self.origin.dot_over(wrench.force) + self.angular.dot_over(wrench.moment)
    }

    /// Acceleration, m/s2 in B, of the point `r` (m, B) of a body that moves with this field.
    #[inline]
    pub fn at(&self, r: Vec3<S>) -> Vec3<S> {
        self.origin + self.angular.cross(r)
    }
}

/// Power that the joints put into the motion, W: sum of torque times rate.
pub fn joint_power<S: Scalar>(torques: &[S], joints: &[Jet<S>]) -> S {
    torques.iter().zip(joints).fold(S::ZERO, |sum, (torque, joint)| sum + *torque * joint.d)
}

/// Equation: body.drive_power
/// `P_drive = sum_i P_i + (1 - storage) max(0, -P_i), P_i = t_i q_i'`
/// Source: Weis-Fogh 1973, J. Exp. Biol. 59; Ellington 1984, Phil. Trans. R. Soc. B 305, part VI.
/// Test: `what_a_joint_gives_back_is_stored_or_lost`.
///
/// Power that the joints draw from their drives, W: P_drive = sum_i P_i + (1 - storage) max(0, -P_i),
/// P_i torque times rate. What a joint gives back is stored and used again to the share `storage`:
/// 0 is no elastic storage, 1 perfect storage (Weis-Fogh 1973; Ellington 1984, part VI). The corner
/// at P_i = 0 is rounded off over `width` W.
pub fn drive_power<S: Scalar>(torques: &[S], joints: &[Jet<S>], storage: f64, width: f64) -> S {
    torques.iter().zip(joints).fold(S::ZERO, |sum, (torque, joint)| {
        let power = *torque * joint.d;
        sum + power + (-power).smooth_positive(width) * (1.0 - storage)
    })
}

impl<S: Scalar> Reaction<S> {
    /// Wrench about the body origin with the base's acceleration included.
    #[inline]
    fn full<P: Scalar>(&self, mass: P, a0: Vec3<S>, w_dot: Vec3<S>) -> Wrench<S>
    where
        S: Meets<P>,
    {
        self.inertial(mass, &BaseAcceleration { origin: a0, angular: w_dot }) + self.bias
    }

    /// Wrench about the body origin that the field of acceleration `x` alone needs.
    #[inline]
    pub(super) fn inertial<P: Scalar>(&self, mass: P, x: &BaseAcceleration<S>) -> Wrench<S>
    where
        S: Meets<P>,
    {
        let (first_moment, about_origin) = (self.com.scaled(mass), self.about_origin);
        CompositeBody { mass, first_moment, about_origin }.needed(x)
    }
}

impl<P: Scalar, S: Scalar + Meets<P>> CompositeBody<P, S> {
    /// Nothing.
    pub(super) const NONE: Self =
        Self { mass: P::ZERO, first_moment: Vec3::ZERO, about_origin: Symmetric([S::ZERO; 6]) };

    /// Takes in a body of the mass `mass`, kg.
    #[inline]
    pub(super) fn add(&mut self, mass: P, body: &Reaction<S>) {
        self.mass += mass;
        self.first_moment += body.com.scaled(mass);
        self.about_origin.add(&body.about_origin);
    }

    /// Wrench about the body origin that the field of acceleration `x` alone needs.
    #[inline]
    pub(super) fn needed(&self, x: &BaseAcceleration<S>) -> Wrench<S> {
        Wrench {
            force: x.origin.scaled(self.mass) + x.angular.cross(self.first_moment),
            moment: self.first_moment.cross(x.origin) + self.about_origin.apply(&x.angular),
        }
    }
}

/// M = [m 1, -[h]x; [h]x, I] for mass m, first moment h and inertia I about the origin.
#[inline]
fn fill_mass_matrix<P: Scalar, S: Scalar + Meets<P>>(
    m: &mut [[S; 6]; 6],
    mass: P,
    h: Vec3<S>,
    about_origin: &Symmetric<S>,
) {
    let (cross, about_origin) = (Mat3::skew(h), about_origin.full());
    for i in 0..3 {
        for j in 0..3 {
            m[i][j] = if i == j { S::from(mass) } else { S::ZERO };
            m[i + 3][j] = cross.0[i][j];
            m[i][j + 3] = cross.0[j][i];
            m[i + 3][j + 3] = about_origin.0[i][j];
        }
    }
}
