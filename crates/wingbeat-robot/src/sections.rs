//! Sections of surfaces riding on body and links.

use crate::body::{Coordinates, LinkMotion, MAX_LINKS};
use arrayvec::ArrayVec;
use wingbeat_aero::{Ground, SectionField, SectionFields, SectionMotion, Sections};
use wingbeat_math::{Meets, Over, Scalar, Vec3, Wrench, append_copies};

/// One section of a surface fixed to the body or a link.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceSection<P: Scalar = f64> {
    /// Link index; `None` rides on the body.
    pub link: Option<usize>,
    /// Place of the link among those that carry surfaces.
    carrier: Option<usize>,
    /// Leading edge in the link's frame, m.
    le: Vec3<P>,
    /// Trailing edge in the link's frame, m.
    te: Vec3<P>,
    /// Unit vector across the section, from left tip to right tip, in the link's frame; `None` is -y.
    across: Option<Vec3<P>>,
}

impl<P: Scalar> SurfaceSection<P> {
    /// A section with leading and trailing edge `edges` (m), which differ in x alone, and the unit
    /// vector `across` it, in the frame of `link`, the `carrier`-th of those that carry surfaces.
    pub fn new(link: Option<usize>, carrier: Option<usize>, edges: [Vec3<P>; 2], across: Vec3<P>) -> Self {
        let to_the_right = Vec3([P::ZERO, -P::ONE, P::ZERO]);
        let across = (!(across - to_the_right).is_zero()).then_some(across);
        Self { link, carrier, le: edges[0], te: edges[1], across }
    }
}

/// A chord line between two links: a sum of lines fixed to each.
#[derive(Clone, Debug)]
pub struct Web<P: Scalar = f64> {
    /// On the inner link; its share is what the others leave of 1.
    pub inner: SurfaceSection<P>,
    /// On the outer link, with its share; of a spar on the piece there, then on the first piece.
    pub outer: ArrayVec<(SurfaceSection<P>, P), 2>,
}

impl<P: Scalar> Web<P> {
    /// Its lines with their shares, which sum to 1.
    #[inline(always)]
    fn parts(&self) -> impl Iterator<Item = (&SurfaceSection<P>, P)> {
        let rest = self.outer.iter().fold(P::ONE, |rest, (_, share)| rest - *share);
        let outer = self.outer.iter().map(|(section, share)| (section, *share));
        std::iter::once((&self.inner, rest)).chain(outer)
    }

    /// The sum of the values `at` its lines, each with its share.
    #[inline(always)]
    fn sum<S: Scalar + Meets<P>>(&self, inner: Vec3<S>, outer: impl Fn(usize) -> Vec3<S>) -> Vec3<S> {
        let parts = self.outer.iter().enumerate();
        parts.fold(inner, |sum, (k, (_, share))| sum + (outer(k) - inner).scaled(*share))
    }
}

/// The lines on links that a strip between two sections is the sum of.
pub(super) type BorneParts<S> = ArrayVec<Borne<S>, 6>;

/// A chord line on a link, of which a section has a share.
#[derive(Clone, Copy)]
pub(super) struct Borne<S: Scalar> {
    pub link: Option<usize>,
    pub share: S,
    /// Leading and trailing edge, m in B.
    pub ends: [Vec3<S>; 2],
}

impl SurfaceSection {
    /// The hinge line of the section, from the body origin, m in B.
    pub fn hinge_point(&self, link: &LinkMotion<f64>) -> Vec3 {
        link.point(Vec3::new(0.0, self.le[1], self.le[2]))
    }

    /// Leading and trailing edge, from the body origin, m in B.
    pub fn edges<S: Scalar>(&self, link: &LinkMotion<S>) -> [Vec3<S>; 2] {
        [link.point(self.le), link.point(self.te)]
    }
}

/// Position, velocity and acceleration of a point, or their change along a line.
#[derive(Clone, Copy)]
struct PointMotion<S: Scalar> {
    p: Vec3<S>,
    v: Vec3<S>,
    a: Vec3<S>,
}

/// Motion of the points of a link: the track of its origin, and its change along the axes of
/// the link, which for a rigid body is linear.
#[derive(Clone, Copy)]
struct Carrier<S: Scalar> {
    origin: PointMotion<S>,
    along: [PointMotion<S>; 3],
    rate: Vec3<S>,
    rate_dot: Vec3<S>,
}

impl<S: Scalar> PointMotion<S> {
    const ZERO: Self = Self { p: Vec3::ZERO, v: Vec3::ZERO, a: Vec3::ZERO };

    /// The track of the point `x` m further along `axis`.
    #[inline(always)]
    fn shifted<P: Copy>(&self, axis: &Self, x: P) -> Self
    where
        S: Meets<P>,
    {
        let [p, v, a] = [self.p.shifted(axis.p, x), self.v.shifted(axis.v, x), self.a.shifted(axis.a, x)];
        Self { p, v, a }
    }
}

impl<S: Scalar> Carrier<S> {
    const ZERO: Self = Self {
        origin: PointMotion::ZERO,
        along: [PointMotion::ZERO; 3],
        rate: Vec3::ZERO,
        rate_dot: Vec3::ZERO,
    };

    /// Along a fixed direction e of the link: v = w x e, a = w' x e + w x (w x e). Written in place: a copy of what has just
    /// been written piece by piece waits for its pieces.
    #[inline(always)]
    fn follow(&mut self, link: &LinkMotion<S>, wind_dot: Vec3<S>) {
        (self.origin.p, self.origin.v) = (link.position, link.velocity);
        for i in 0..3 {
            self.origin.a[i] = link.acceleration[i] - wind_dot[i];
        }
        for (axis, along) in self.along.iter_mut().enumerate() {
            for i in 0..3 {
                along.p[i] = link.rotation.0[i][axis];
            }
            along.v.set_cross(&link.rate, &along.p);
            along.a.set_cross(&link.rate_dot, &along.p);
            along.a.add_cross(&link.rate, &along.v);
        }
        (self.rate, self.rate_dot) = (link.rate, link.rate_dot);
    }

    /// Leading and trailing edge of `section`.
    #[inline(always)]
    fn ends<P: Scalar>(&self, section: &SurfaceSection<P>) -> [Vec3<S>; 2]
    where
        S: Meets<P>,
    {
        let SectionMotion { le, te, .. } = self.section(section);
        [le, te]
    }

    #[inline(always)]
    fn section<P: Scalar>(&self, section: &SurfaceSection<P>) -> SectionMotion<S>
    where
        S: Meets<P>,
    {
        let [x, y, z] = section.le.0;
        let mut root = self.origin.shifted(&self.along[1], y);
        if !z.is_zero() {
            root = root.shifted(&self.along[2], z);
        }
        let (le, te) = (root.shifted(&self.along[0], x), root.shifted(&self.along[0], section.te[0]));
        let span = match section.across {
            None => -self.along[1].p,
            Some(across) => self.along[1].p.scaled(across[1]) + self.along[2].p.scaled(across[2]),
        };
        SectionMotion {
            le: le.p,
            te: te.p,
            v_le: le.v,
            v_te: te.v,
            a_le: le.a,
            a_te: te.a,
            span,
            w: self.rate,
            alpha: self.rate_dot,
        }
    }
}

/// Room for the motions of body and links that carry surfaces, which [`Carriers::follow`] writes.
pub(super) struct CarrierRoom<S: Scalar> {
    base: Carrier<S>,
    links: ArrayVec<Carrier<S>, MAX_LINKS>,
}

impl<S: Scalar> CarrierRoom<S> {
    /// Nothing is written yet.
    #[inline(always)]
    pub fn new() -> Self {
        Self { base: Carrier::ZERO, links: ArrayVec::new() }
    }
}

/// Body and links that carry surfaces, at one instant; accelerations
/// against air that itself accelerates with `wind_dot` (resolved in B), so that the added mass
/// feels the gust.
pub(super) struct Carriers<'a, S: Scalar> {
    room: &'a mut CarrierRoom<S>,
    /// Coordinates whose second rates the accelerations leave out.
    pub coordinates: &'a Coordinates<S>,
    /// The plane that the air does not cross.
    pub ground: Option<Ground<S>>,
    /// Acceleration of gravity, m/s2 in B.
    pub gravity: Vec3<S>,
    /// Whether accelerations leave nothing out.
    pub complete: bool,
}

impl<'a, S: Scalar> Carriers<'a, S> {
    /// Those that `room` has place for.
    #[inline(always)]
    pub fn within(room: &'a mut CarrierRoom<S>, coordinates: &'a Coordinates<S>) -> Self {
        Self { room, coordinates, ground: None, gravity: Vec3::ZERO, complete: false }
    }

    /// Takes the body and the links `carriers`, in air that accelerates by `wind_dot`, under `gravity` (m/s2, B).
    #[inline(always)]
    pub fn follow(
        &mut self,
        base: &LinkMotion<S>,
        carriers: &[usize],
        links: &[LinkMotion<S>],
        [wind_dot, gravity]: [Vec3<S>; 2],
    ) {
        self.gravity = gravity;
        let room = &mut *self.room;
        room.base.follow(base, wind_dot);
        // What an evaluation before has left is written over.
        room.links.truncate(carriers.len());
        let lacking = carriers.len() - room.links.len();
        append_copies(&mut room.links, Carrier::ZERO, lacking);
        for i in 0..carriers.len() {
            room.links[i].follow(&links[carriers[i]], wind_dot);
        }
    }
}

impl<S: Scalar> Carriers<'_, S> {
    /// Adds the forces of `load` (N and N m, B) on `link` along the coordinates.
    pub fn project<T: Over<S>>(&self, link: usize, load: &Wrench<T>, forces: &mut [T]) {
        self.coordinates.project(link, load, forces);
    }
}

/// The sections of a surface, one by one.
pub(super) struct Riding<'a, P: Scalar, S: Scalar> {
    pub sections: &'a [SurfaceSection<P>],
    /// Those of them that lie between two links; empty where none does.
    pub webs: &'a [Option<Web<P>>],
    pub carriers: &'a Carriers<'a, S>,
}

impl<P: Scalar, S: Scalar + Meets<P>> Riding<'_, P, S> {
    /// The section number `i`.
    pub fn at(&self, i: usize) -> SectionMotion<S> {
        self.section(i)
    }

    #[inline(always)]
    fn on(&self, section: &SurfaceSection<P>) -> SectionMotion<S> {
        self.carrier(section).section(section)
    }

    #[inline(always)]
    fn carrier(&self, section: &SurfaceSection<P>) -> &Carrier<S> {
        let room = &*self.carriers.room;
        section.carrier.map_or(&room.base, |carrier| &room.links[carrier])
    }

    /// Whether section `i` lies between two links.
    pub fn is_web(&self, i: usize) -> bool {
        self.webs.get(i).is_some_and(Option::is_some)
    }

    /// Adds what section `i` with the share `share` is the sum of; returns its leading and trailing edge, m in B.
    pub fn bear(&self, i: usize, share: S, parts: &mut BorneParts<S>) -> [Vec3<S>; 2] {
        let Some(Some(web)) = self.webs.get(i) else {
            let section = &self.sections[i];
            let ends = self.carrier(section).ends(section);
            parts.push(Borne { link: section.link, share, ends });
            return ends;
        };
        let mut whole = [Vec3::ZERO; 2];
        for (of, weight) in web.parts() {
            let ends = self.carrier(of).ends(of);
            parts.push(Borne { link: of.link, share: share * weight, ends });
            whole = [0, 1].map(|end| whole[end] + ends[end].scaled(weight));
        }
        whole
    }

    /// As [`Self::on`], compiled once.
    #[inline(never)]
    fn line(&self, section: &SurfaceSection<P>) -> SectionMotion<S> {
        self.on(section)
    }

    #[inline(never)]
    fn between(&self, web: &Web<P>) -> SectionMotion<S> {
        let inner = self.line(&web.inner);
        let outer: ArrayVec<SectionMotion<S>, 2> = web.outer.iter().map(|(of, _)| self.line(of)).collect();
        let mix = |of: fn(&SectionMotion<S>) -> Vec3<S>| web.sum(of(&inner), |k| of(&outer[k]));
        SectionMotion {
            le: mix(|line| line.le),
            te: mix(|line| line.te),
            v_le: mix(|line| line.v_le),
            v_te: mix(|line| line.v_te),
            a_le: mix(|line| line.a_le),
            a_te: mix(|line| line.a_te),
            ..outer[0]
        }
    }
}

impl<P: Scalar, S: Scalar + Meets<P>> Sections<S> for Riding<'_, P, S> {
    #[inline(always)]
    fn section(&self, i: usize) -> SectionMotion<S> {
        match self.webs.get(i) {
            Some(Some(web)) => self.between(web),
            _ => self.on(&self.sections[i]),
        }
    }
    #[inline(always)]
    fn on_link(&self, i: usize) -> SectionMotion<S> {
        self.on(&self.sections[i])
    }
    #[inline]
    fn coordinates(&self) -> usize {
        self.carriers.coordinates.count()
    }
    fn ground(&self) -> Option<Ground<S>> {
        self.carriers.ground
    }
    fn gravity(&self) -> Vec3<S> {
        self.carriers.gravity
    }
    fn complete(&self) -> bool {
        self.carriers.complete
    }
    fn fields(&self, i: usize, fields: &mut SectionFields<S>) -> u32 {
        let coordinates = self.carriers.coordinates;
        fields.clear();
        append_copies(fields, SectionField::STILL, coordinates.count());
        let mut moved = 0;
        let mut move_by = |part: &SurfaceSection<P>, share: P| {
            let Some(link) = part.link else { return };
            let [le, te] = self.carrier(part).ends(part);
            for (coordinate, motion) in coordinates.moving(link) {
                let field = &mut fields[coordinate];
                field.le += motion.at(le).scaled(share);
                field.te += motion.at(te).scaled(share);
                moved |= 1 << coordinate;
            }
        };
        match self.webs.get(i) {
            Some(Some(web)) => web.parts().for_each(|(part, share)| move_by(part, share)),
            _ => move_by(&self.sections[i], P::ONE),
        }
        moved
    }
}
