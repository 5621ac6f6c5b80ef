//! Momentum and energy of the whole tree.

use super::motion::LinkMotion;
use super::tree::Tree;
use wingbeat_math::{Meets, Scalar, Vec3};

/// Linear and angular momentum, resolved in B.
#[derive(Clone, Copy, Debug)]
pub struct Momentum<S: Scalar = f64> {
    /// Linear, N s.
    pub linear: Vec3<S>,
    /// Angular about the chosen point, N m s.
    pub angular: Vec3<S>,
}

impl<P: Scalar> Tree<P> {
    /// Momentum, N s, with the angular part about the fixed point that lies at `about` from the body origin, in B (for the
    /// world origin: -R_WB' p_WB).
    pub fn momentum<S: Scalar + Meets<P>>(
        &self,
        v_b: Vec3<S>,
        w_b: Vec3<S>,
        motions: &[LinkMotion<S>],
        about: Vec3<S>,
    ) -> Momentum<S> {
        let base = LinkMotion::base(v_b, w_b);
        let zero = Momentum { linear: Vec3::ZERO, angular: Vec3::ZERO };
        std::iter::once((&self.base, &base)).chain(self.massive(motions)).fold(zero, |sum, (i, m)| {
            let com = m.point(i.com);
            let linear = m.velocity_at(com).scaled(i.mass);
            let spin = i.about_com(&m.rotation).apply(&m.rate);
            Momentum {
                linear: sum.linear + linear,
                angular: sum.angular + (com - about).cross(linear) + spin,
            }
        })
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy<S: Scalar + Meets<P>>(
        &self,
        v_b: Vec3<S>,
        w_b: Vec3<S>,
        motions: &[LinkMotion<S>],
    ) -> S {
        let base = LinkMotion::base(v_b, w_b);
        std::iter::once((&self.base, &base)).chain(self.massive(motions)).fold(S::ZERO, |sum, (i, m)| {
            let v = m.velocity_at(m.point(i.com));
            let spin = i.about_com(&m.rotation).apply(&m.rate);
            sum + (v.norm_squared() * i.mass + m.rate.dot(spin)) * 0.5
        })
    }

    /// Potential energy, J, above the point that lies at `datum` from the body
    /// origin, for gravity `g_b`; both in B.
    pub fn potential_energy<S: Scalar + Meets<P>>(
        &self,
        g_b: Vec3<S>,
        motions: &[LinkMotion<S>],
        datum: Vec3<S>,
    ) -> S {
        -(self.center_of_mass(motions) - datum).dot(g_b) * self.mass()
    }
}
