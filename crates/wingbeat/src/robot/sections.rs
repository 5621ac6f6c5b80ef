//! Where the wing's sections ride: from arc length to link and local edges.

use super::CARRIERS;
use super::spec::WingSpec;
use crate::aero::{Planform, SectionMotion, Sections};
use crate::body::LinkMotion;
use crate::math::{Scalar, Vec3};

/// How far beyond a hinge a section still lies on it, relative: left and right differ by rounding.
const ON_HINGE: f64 = 1e-9;

/// One wing section fixed to the body or a link.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Link index; `None` rides on the body.
    pub link: Option<usize>,
    /// Place of the link among the [`CARRIERS`].
    carrier: Option<usize>,
    /// Leading edge in the link's frame, m.
    le: Vec3,
    /// Trailing edge in the link's frame, m.
    te: Vec3,
}

impl Section {
    /// The section at the signed arc length `s` (left positive), m. A section on
    /// a hinge belongs to the inner link.
    pub fn at(s: f64, wing: &WingSpec, planform: &Planform) -> Self {
        let (leading, trailing) = planform.edges(s);
        let root = wing.shoulder_m[1];
        let elbow = root + wing.proximal.length_m;
        let side = if s >= 0.0 { 0 } else { 1 };
        let (carrier, inner) = match s.abs() / (1.0 + ON_HINGE) {
            a if a <= root => (None, 0.0),
            a if a <= elbow => (Some(2 * side), root),
            _ => (Some(2 * side + 1), elbow),
        };
        let base = match carrier {
            None => Vec3::new(wing.shoulder_m[0], 0.0, wing.shoulder_m[2]),
            Some(_) => Vec3::ZERO,
        };
        let y = s - s.signum() * inner;
        let edge = |x: f64| base + Vec3::new(x + wing.planform_shift_m, y, 0.0);
        let link = carrier.map(|place| CARRIERS[place]);
        Self { link, carrier, le: edge(leading), te: edge(trailing) }
    }

    /// The hinge line of the section, from the body origin.
    pub fn hinge_point(&self, link: &LinkMotion<f64>) -> Vec3 {
        link.point(Vec3::new(0.0, self.le[1], self.le[2]))
    }

    /// Leading and trailing edge, from the body origin.
    pub fn edges(&self, link: &LinkMotion<f64>) -> [Vec3; 2] {
        [link.point(self.le), link.point(self.te)]
    }
}

/// Position, velocity and acceleration of a point, or their change along a line.
#[derive(Clone, Copy)]
struct Track<S: Scalar> {
    p: Vec3<S>,
    v: Vec3<S>,
    a: Vec3<S>,
}

/// Motion of the points of a link: the track of its origin, and its change along the axes of
/// the link, which for a rigid body is linear.
#[derive(Clone, Copy)]
struct Carrier<S: Scalar> {
    origin: Track<S>,
    along: [Track<S>; 3],
    rate: Vec3<S>,
    rate_dot: Vec3<S>,
}

impl<S: Scalar> Track<S> {
    const ZERO: Self = Self { p: Vec3::ZERO, v: Vec3::ZERO, a: Vec3::ZERO };

    /// The track of the point `x` m further along `axis`.
    #[inline(always)]
    fn shifted(&self, axis: &Self, x: f64) -> Self {
        Self { p: self.p + axis.p.scaled(x), v: self.v + axis.v.scaled(x), a: self.a + axis.a.scaled(x) }
    }
}

impl<S: Scalar> Carrier<S> {
    const ZERO: Self =
        Self { origin: Track::ZERO, along: [Track::ZERO; 3], rate: Vec3::ZERO, rate_dot: Vec3::ZERO };

    /// Along a fixed direction e of the link: v = w x e, a = w' x e + w x (w x e).
    #[inline(always)]
    fn follow(&mut self, link: &LinkMotion<S>, wind_dot: Vec3<S>) {
        self.origin = Track { p: link.position, v: link.velocity, a: link.acceleration - wind_dot };
        for (axis, along) in self.along.iter_mut().enumerate() {
            let direction = link.rotation.column(axis);
            let sweep = link.rate.cross(direction);
            let bend = link.rate_dot.cross(direction) + link.rate.cross(sweep);
            *along = Track { p: direction, v: sweep, a: bend };
        }
        self.rate = link.rate;
        self.rate_dot = link.rate_dot;
    }

    #[inline(always)]
    fn section(&self, section: &Section) -> SectionMotion<S> {
        let [x, y, z] = section.le.0;
        let mut root = self.origin.shifted(&self.along[1], y);
        if z != 0.0 {
            root = root.shifted(&self.along[2], z);
        }
        let (le, te) = (root.shifted(&self.along[0], x), root.shifted(&self.along[0], section.te[0]));
        SectionMotion {
            le: le.p,
            te: te.p,
            v_le: le.v,
            v_te: te.v,
            a_le: le.a,
            a_te: te.a,
            span: -self.along[1].p,
            w: self.rate,
            alpha: self.rate_dot,
        }
    }
}

/// The wing's sections riding on body and links, one by one; accelerations
/// against air that itself accelerates with `wind_dot` (resolved in B), so that the added mass
/// feels the gust.
pub(super) struct Riding<'a, S: Scalar> {
    sections: &'a [Section],
    base: Carrier<S>,
    links: [Carrier<S>; CARRIERS.len()],
}

impl<'a, S: Scalar> Riding<'a, S> {
    #[inline(always)]
    pub fn new(
        sections: &'a [Section],
        base: &LinkMotion<S>,
        links: &[LinkMotion<S>],
        wind_dot: Vec3<S>,
    ) -> Self {
        let mut riding = Self { sections, base: Carrier::ZERO, links: [Carrier::ZERO; CARRIERS.len()] };
        riding.base.follow(base, wind_dot);
        for (carrier, link) in riding.links.iter_mut().zip(CARRIERS) {
            carrier.follow(&links[link], wind_dot);
        }
        riding
    }
}

impl<S: Scalar> Sections<S> for Riding<'_, S> {
    #[inline(always)]
    fn section(&self, i: usize) -> SectionMotion<S> {
        let section = &self.sections[i];
        section.carrier.map_or(&self.base, |carrier| &self.links[carrier]).section(section)
    }
}
