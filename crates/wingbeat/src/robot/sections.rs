//! Where the wing's sections ride: from arc length to link and local edges.

use super::spec::WingSpec;
use crate::aero::{Planform, SectionMotion, Sections};
use crate::body::LinkMotion;
use crate::math::{Scalar, Vec3};

/// One wing section fixed to the body or a link.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Link index; `None` rides on the body.
    pub link: Option<usize>,
    /// Leading edge in the link's frame, m.
    le: Vec3,
    /// Trailing edge in the link's frame, m.
    te: Vec3,
}

impl Section {
    /// The section at the signed arc length `s` (left positive), m. A section on
    /// a hinge belongs to the inner link.
    pub fn at(s: f64, wing: &WingSpec, planform: &Planform, links: [usize; 4]) -> Self {
        let (leading, trailing) = planform.edges(s);
        let root = wing.shoulder_m[1];
        let elbow = root + wing.proximal.length_m;
        let side = if s >= 0.0 { 0 } else { 1 };
        let (link, inner) = match s.abs() {
            a if a <= root => (None, 0.0),
            a if a <= elbow => (Some(links[2 * side]), root),
            _ => (Some(links[2 * side + 1]), elbow),
        };
        let base = match link {
            None => Vec3::new(wing.shoulder_m[0], 0.0, wing.shoulder_m[2]),
            Some(_) => Vec3::ZERO,
        };
        let y = s - s.signum() * inner;
        let edge = |x: f64| base + Vec3::new(x + wing.planform_shift_m, y, 0.0);
        Self { link, le: edge(leading), te: edge(trailing) }
    }

    /// Motion of the section riding on `link`.
    #[inline]
    pub fn motion<S: Scalar>(&self, link: &LinkMotion<S>) -> SectionMotion<S> {
        let (le, te) = (link.point(self.le), link.point(self.te));
        let ((v_le, a_le), (v_te, a_te)) = (link.moving_at(le), link.moving_at(te));
        SectionMotion {
            le,
            te,
            v_le,
            v_te,
            a_le,
            a_te,
            span: -link.rotation.column(1),
            w: link.rate,
            alpha: link.rate_dot,
        }
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

/// The wing's sections riding on body and links, one by one; accelerations
/// against air that itself accelerates with `wind_dot`, so that the added mass
/// feels the gust.
pub(super) struct Riding<'a, S: Scalar> {
    /// The sections.
    pub sections: &'a [Section],
    /// The body as a link.
    pub base: &'a LinkMotion<S>,
    /// The links.
    pub links: &'a [LinkMotion<S>],
    /// Acceleration of the air, resolved in B.
    pub wind_dot: Vec3<S>,
}

impl<S: Scalar> Sections<S> for Riding<'_, S> {
    #[inline]
    fn section(&self, i: usize) -> SectionMotion<S> {
        let section = &self.sections[i];
        let mut motion = section.motion(section.link.map_or(self.base, |link| &self.links[link]));
        motion.a_le -= self.wind_dot;
        motion.a_te -= self.wind_dot;
        motion
    }
}
