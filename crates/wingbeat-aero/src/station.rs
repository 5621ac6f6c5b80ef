//! The motion of one wing section, the only thing aerodynamics hears of the structure.

use arrayvec::ArrayVec;
use wingbeat_math::{Meets, Scalar, Vec3};
use wingbeat_ocp::plant::MAX_COORDINATES;

/// Motion of one chord line. All vectors are resolved in the body frame B;
/// positions are from the body origin; velocities and accelerations are
/// inertial (relative to W). SI units.
#[derive(Clone, Copy, Debug, Default)]
pub struct SectionMotion<S: Scalar> {
    /// Leading edge.
    pub le: Vec3<S>,
    /// Trailing edge.
    pub te: Vec3<S>,
    /// Velocity of the leading edge.
    pub v_le: Vec3<S>,
    /// Velocity of the trailing edge.
    pub v_te: Vec3<S>,
    /// Acceleration of the leading edge.
    pub a_le: Vec3<S>,
    /// Acceleration of the trailing edge.
    pub a_te: Vec3<S>,
    /// Unit vector along the span of the section's link, from left tip to right
    /// tip, perpendicular to the chord line.
    pub span: Vec3<S>,
    /// Angular rate of the section's link.
    pub w: Vec3<S>,
    /// Angular acceleration of the section's link.
    pub alpha: Vec3<S>,
}

/// Where the motions of a wing's sections come from: a slice, or whoever can
/// tell them one by one, so that they need not all be kept.
pub trait Sections<S: Scalar> {
    /// Motion of section `i`, counted from the left tip.
    fn section(&self, i: usize) -> SectionMotion<S>;
    /// The same of a section that lies on one link, as those of preset `paper` do. Who knows others says it apart, so that no number
    /// waits for the branch.
    #[inline(always)]
    fn on_link(&self, i: usize) -> SectionMotion<S> {
        self.section(i)
    }
    /// Number of coordinates, beyond the six of the body, whose second rates the motions leave out.
    fn coordinates(&self) -> usize {
        0
    }
    /// The plane that the air does not cross, where there is one.
    fn ground(&self) -> Option<Ground<S>> {
        None
    }
    /// Acceleration of gravity, m/s2 in B, which turns flaps; none where what carries the sections does not tell it.
    fn gravity(&self) -> Vec3<S> {
        Vec3::ZERO
    }
    /// Whether the motions hold all accelerations, so that nobody asks for the added mass on those that they leave out.
    fn complete(&self) -> bool {
        false
    }
    /// Writes how section `i` moves per unit rate of each coordinate; returns the numbers of those that move it, as bits.
    fn fields(&self, _i: usize, fields: &mut SectionFields<S>) -> u32 {
        fields.clear();
        0
    }
}

/// Those of one section, one for each coordinate.
pub type SectionFields<S> = ArrayVec<SectionField<S>, MAX_COORDINATES>;

/// A plane that the air does not cross, ground or ceiling, in B.
#[derive(Clone, Copy, Debug)]
pub struct Ground<S: Scalar> {
    /// Unit normal, in B.
    pub normal: Vec3<S>,
    /// Its distance from the body origin along the normal, m.
    pub offset: S,
}

impl<S: Scalar> Ground<S> {
    /// Mirror image of a point, m in B.
    #[inline]
    pub fn point(&self, p: Vec3<S>) -> Vec3<S> {
        p - self.normal * ((self.normal.dot(p) - self.offset) * 2.0)
    }
    /// Mirror image of a direction, in its own unit.
    #[inline]
    pub fn direction(&self, v: Vec3<S>) -> Vec3<S> {
        v - self.normal * (self.normal.dot(v) * 2.0)
    }
}

/// Velocities of a chord line per unit rate of a coordinate, in B.
#[derive(Clone, Copy, Debug, Default)]
pub struct SectionField<S: Scalar> {
    /// Of the leading edge, m/s over the unit of the rate: m/rad for a turn.
    pub le: Vec3<S>,
    /// The same of the trailing edge.
    pub te: Vec3<S>,
}

impl<S: Scalar> SectionField<S> {
    /// Nothing moves.
    pub const STILL: Self = Self { le: Vec3::ZERO, te: Vec3::ZERO };

    /// The field that lies the share `x` of the way to another.
    #[inline]
    pub fn mixed<P: Scalar>(&self, other: &Self, x: P) -> Self
    where
        S: Meets<P>,
    {
        Self { le: along(self.le, other.le, x), te: along(self.te, other.te, x) }
    }

    /// Velocity (m/s) of the chord fraction `x` along `normal`, and rate (rad/s) of nose-up pitch of a chord 1/`inverse_chord` m
    /// long, whose own normal is `upward`.
    #[inline]
    pub fn heave_and_pitch<P: Scalar>(&self, x: P, [normal, upward]: [Vec3<S>; 2], inverse_chord: S) -> (S, S)
    where
        S: Meets<P>,
    {
        let heave = along(self.le, self.te, x).dot(normal);
        (heave, -((self.te - self.le).dot(upward) * inverse_chord))
    }
}

impl<S: Scalar, T: AsRef<[SectionMotion<S>]> + ?Sized> Sections<S> for T {
    #[inline]
    fn section(&self, i: usize) -> SectionMotion<S> {
        self.as_ref()[i]
    }
}

impl<S: Scalar> SectionMotion<S> {
    /// Position, m in B, at the chord fraction `x` (0 leading edge, 1 trailing edge).
    #[inline]
    pub fn point(&self, x: f64) -> Vec3<S> {
        along(self.le, self.te, x)
    }
    /// Velocity, m/s in B, at the chord fraction `x`.
    #[inline]
    pub fn velocity(&self, x: f64) -> Vec3<S> {
        along(self.v_le, self.v_te, x)
    }
    /// Acceleration, m/s2 in B, at the chord fraction `x`.
    #[inline]
    pub fn acceleration(&self, x: f64) -> Vec3<S> {
        along(self.a_le, self.a_te, x)
    }
}

#[inline]
fn along<P: Scalar, S: Scalar + Meets<P>>(a: Vec3<S>, b: Vec3<S>, x: P) -> Vec3<S> {
    (a * S::from(P::ONE - x)).shifted::<S>(b, S::from(x))
}
