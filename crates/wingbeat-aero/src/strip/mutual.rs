//! The wash of other surfaces.
//!
//! Where a surface stands in the wake of another, or beside it, the vortices of the other wash over it.
//! The rings that lie on the other (bound vortex, legs along the chord) act at once. What has been shed
//! acts when it has travelled: a wake carries the circulation that left its strip distance over speed ago.
//! That is told to each pair of surfaces by a short chain of lags of each strip's circulation, whose mean
//! delay is that time; a steady state does not depend on it.
//!
//! The wash is taken as a wind along the normal, at 3/4 chord and, where it turns the force, at 1/4 chord.
//! Over a ground every surface sees the mirror images of all surfaces, its own too, as it sees other surfaces: a robot over it is the
//! upper one of a mirrored pair.
//!
//! Neglected are its parts along chord and span (they change the speed that the strip meets by CL c/(4 pi h)
//! of it at the distance h), its force on the carried air (a gust that travels along the chord has hardly any:
//! Kuessner's lift starts at zero), the air that one surface carries for the other (their common added mass),
//! and the bending of one wake by the other surface.

use super::StripModel;
use super::influence::{INVERSE_4PI, NEAREST, PlueckerLine, StripColumn, cored, divide, segment};
use super::motion::{ChordLine, Edges, StripEdge, Strips, Vectors};
use crate::law::Attachment;
use crate::{Ground, Loads, MAX_SECTIONS, MAX_STRIPS, Sections};
use wingbeat_math::{Meets, Over, Scalar, Vec3};

/// Lags in the chain by which circulation travels from one surface to another.
pub const ARRIVAL_LAGS: usize = 2;
/// Core radius of a vortex for other surfaces where it leaves, over the half width of the narrower
/// strip beside it: a choice, so that a sheet of vortices is smooth and a neighbour in one plane is felt.
const CORE: f64 = 0.3;
/// Core radius of a wake over the mean chord when it has run one chord: it grows with the root of the way as
/// a vortex that diffuses (Squire 1965). A fit to the tail's downwash of row `aero.tandem`, which 0.1 misses by 6.2 %
/// and this by 2.6 %, against smoothness where a surface crosses the wake.
const CORE_GROWTH: f64 = 0.05;
/// Least distance of arrival over the mean chord of the source.
const LEAST_DISTANCE: f64 = 0.5;

/// The vortices of all surfaces at one instant.
#[derive(Clone)]
pub(crate) struct Vortices<G: Scalar, S> {
    edges: [StripEdge<G, G>; MAX_SECTIONS],
    circulation: [S; MAX_STRIPS],
}

impl<G: Scalar, S: Scalar> Vortices<G, S> {
    /// None yet.
    pub const NONE: Self = {
        let zero = Vec3::ZERO;
        let edge = StripEdge { bound: zero, trailing: zero, wake: zero };
        Self { edges: [edge; MAX_SECTIONS], circulation: [S::ZERO; MAX_STRIPS] }
    };

    /// The mirror images of the vortices between the first `edges` edges, `self` its own: a mirror turns the sense of a circulation.
    ///
    /// Equation: aero.strip.ground
    /// `images of all bound and trailing vortices at the plane, of the circulation -Gamma`
    /// Source: method of images; Katz & Plotkin 2001, section 12.3.
    /// Test: `a_wing_over_a_ground_is_the_upper_one_of_a_mirrored_pair`.
    #[inline(never)]
    pub fn mirror(&mut self, ground: &Ground<G>, edges: usize) {
        for edge in &mut self.edges[..edges] {
            edge.bound = ground.point(edge.bound);
            edge.trailing = ground.point(edge.trailing);
            edge.wake = ground.direction(edge.wake);
        }
        for circulation in &mut self.circulation {
            *circulation = -*circulation;
        }
    }
}

/// What never changes of a surface that washes over another.
#[derive(Clone, Debug)]
pub(crate) struct Source<P = f64> {
    /// Its first edge and strip among those of all surfaces.
    pub first_edge: usize,
    pub first_strip: usize,
    /// Whether it is the mirror image of the surface at the ground.
    image: bool,
    strips: usize,
    /// Core radii of the vortices that leave its edges, m.
    edge_cores: Vec<P>,
    /// Growth of their squares with the distance run, m.
    core_growth: P,
    /// Least distance of arrival, m.
    least: P,
}

impl<P> Source<P> {
    /// Number of states that carry its circulation to one other surface.
    pub fn arrivals(&self) -> usize {
        ARRIVAL_LAGS * self.strips
    }
    /// Whether it is a mirror image.
    pub fn is_image(&self) -> bool {
        self.image
    }
    /// Its mirror image at a ground.
    pub fn image(&self) -> Self
    where
        P: Clone,
    {
        Self { image: true, ..self.clone() }
    }
    /// The state of the other wing that stands for arrival `i`.
    pub fn mirrored(&self, i: usize) -> usize {
        i - i % self.strips + (self.strips - 1 - i % self.strips)
    }
}

/// The surfaces that wash over one, and the states that carry their circulation to it: for each of them
/// a block per lag of one value per strip, m2/s.
pub(crate) struct Others<'a, P, G: Scalar, S> {
    pub vortices: &'a Vortices<G, S>,
    /// Their mirror images, where there is a ground.
    pub images: Option<&'a Vortices<G, S>>,
    pub sources: &'a [Source<P>],
    pub x: &'a [S],
    pub dx: &'a mut [S],
}

/// Normal wash of other surfaces on the strips of one, m/s.
pub(super) struct Foreign<S, const N: usize> {
    pub at_control: StripColumn<S, N>,
    pub at_bound: StripColumn<S, N>,
}

/// Points and the normals through them, over 4 pi, with their moments about the origin.
struct NormalPoints<G: Scalar, const N: usize> {
    at: Vectors<G, N>,
    normal: Vectors<G, N>,
    moment: Vectors<G, N>,
}

/// Distances of the points to the ends of the leg of one edge, and the normal wash of leg and wake of unit strength.
struct LegDistances<G, const N: usize> {
    to_bound: StripColumn<G, N>,
    to_trailing: StripColumn<G, N>,
    leg: StripColumn<G, N>,
    wake: StripColumn<G, N>,
}

impl<G: Scalar, const N: usize> LegDistances<G, N> {
    const ZERO: Self = {
        let zero = [G::ZERO; N];
        Self { to_bound: zero, to_trailing: zero, leg: zero, wake: zero }
    };
}

impl<G: Scalar, const N: usize> NormalPoints<G, N> {
    fn new<K: Scalar>(points: &Vectors<K, N>, normals: &Vectors<K, N>) -> Self
    where
        G: Over<K>,
    {
        let (mut at, mut normal, mut moment) = (Vectors::ZERO, Vectors::ZERO, Vectors::ZERO);
        for i in 0..N {
            let (p, n) = (points.get(i), normals.get(i).scaled(INVERSE_4PI));
            at.set(i, p.lifted());
            normal.set(i, n.lifted());
            moment.set(i, p.cross(n).lifted());
        }
        Self { at, normal, moment }
    }

    #[inline(always)]
    fn line(&self, i: usize) -> PlueckerLine<G> {
        PlueckerLine { direction: self.normal.get(i), moment: self.moment.get(i) }
    }

    /// The leg along the chord, and the wake behind it, whose core grows with the distance run,
    /// core^2 = h^2 + g^2 c x, so that a surface crosses it smoothly.
    ///
    /// Equation: aero.strip.foreign_wake
    /// `aero.strip.segment and aero.strip.trailing_vortex on other surfaces, core^2 = h^2 + g^2 c x with x the
    /// distance run`
    /// Source: Biot & Savart; Squire 1965, Aeronautical Quarterly 16 (growth); h and g a choice.
    /// Test: `a_tail_crosses_the_wake_smoothly`.
    fn beside<P: Scalar>(&self, edge: &StripEdge<G, G>, core: P, growth: P, out: &mut LegDistances<G, N>)
    where
        G: Meets<P>,
    {
        let chord = edge.trailing - edge.bound;
        let (chord2, core2) = (chord.norm_squared(), core * core);
        let (leg, wake) = (PlueckerLine::new(edge.bound, chord), PlueckerLine::new(edge.trailing, edge.wake));
        let least = core2 * NEAREST;
        for i in 0..N {
            let (p, n) = (self.at.get(i), self.line(i));
            let (ra, rt) = (p - edge.bound, p - edge.trailing);
            let (a, b) = ((ra.norm_squared() + least).sqrt(), (rt.norm_squared() + least).sqrt());
            let run = rt.dot(edge.wake);
            let ahead = (run + (run * run + core2).sqrt()) * 0.5;
            let grown2 = ahead * growth + core2;
            let own = G::from(core2 * core2);
            let leg = segment(leg.turn::<G>(&n), chord2, [a, b], |x, y| cored(x, y, own));
            let wake = cored(wake.turn::<G>(&n), b * (b - run), grown2 * grown2);
            (out.leg[i], out.wake[i]) = divide(leg, wake);
            (out.to_bound[i], out.to_trailing[i]) = (a, b);
        }
    }

    /// Adds the wash of the strips between `edges`: rings of the strength `bound`, and wakes of the
    /// strength `shed`, m2/s.
    fn add<P: Scalar, S: Over<G>>(
        &self,
        source: &Source<P>,
        edges: &[StripEdge<G, G>],
        [bound, shed]: [&[S]; 2],
        sum: &mut StripColumn<S, N>,
    ) where
        G: Meets<P>,
    {
        let cores = &source.edge_cores;
        let (mut left, mut right) = (LegDistances::ZERO, LegDistances::ZERO);
        self.beside(&edges[0], cores[0], source.core_growth, &mut right);
        for (j, ends) in edges.windows(2).enumerate() {
            std::mem::swap(&mut left, &mut right);
            self.beside(&ends[1], cores[j + 1], source.core_growth, &mut right);
            let core = if cores[j + 1] < cores[j] { cores[j + 1] } else { cores[j] };
            let core4 = G::from(core.powi(4));
            let core = |x, y| cored(x, y, core4);
            let [ahead, behind] = [ends[1].bound - ends[0].bound, ends[0].trailing - ends[1].trailing];
            let lines =
                [PlueckerLine::new(ends[0].bound, ahead), PlueckerLine::new(ends[1].trailing, behind)];
            let lengths = [ahead.norm_squared(), behind.norm_squared()];
            for i in 0..N {
                let n = self.line(i);
                let ends = [left.to_bound[i], right.to_bound[i]];
                let front = segment(lines[0].turn::<G>(&n), lengths[0], ends, core);
                let sides = [right.to_trailing[i], left.to_trailing[i]];
                let (front, rear) = divide(front, segment(lines[1].turn::<G>(&n), lengths[1], sides, core));
                let ring = front + rear + (right.leg[i] - left.leg[i]);
                let wake = right.wake[i] - left.wake[i] - rear;
                sum[i] = shed[j].fused(wake, bound[j].fused(ring, sum[i]));
            }
        }
    }
}

/// Where a surface is and how fast it goes through the air, as a whole.
struct MeanMotion<G: Scalar> {
    centre: Vec3<G>,
    speed: G,
}

impl<G: Scalar> MeanMotion<G> {
    /// Rate of each lag of the chain from the strip between two edges, 1/s: number of lags times speed over
    /// distance. The distance is the way along the wake, (r + u.r)/2: r where the other surface follows in the
    /// wake, half of it where it stands beside, and never less than part of a chord.
    ///
    /// Equation: aero.strip.arrival
    /// `rate of each of n lags n V/d, d = (r + u.r)/2`
    /// Source: Taylor 1938 (frozen wake); n = 2 and the distance a choice.
    /// Test: `a_change_at_the_wing_reaches_the_tail_distance_over_speed_later`.
    fn arrival_rate<P: Scalar>(&self, ends: &[StripEdge<G, G>], least: P) -> G
    where
        G: Meets<P>,
    {
        let least2 = least * least;
        let from = (ends[0].trailing + ends[1].trailing).scaled(0.5);
        let along = (ends[0].wake + ends[1].wake).scaled(0.5);
        let r = self.centre - from;
        let way = ((r.norm_squared() + least2).sqrt() + r.dot(along)) * 0.5;
        self.speed * (way * way + least2).sqrt().recip() * ARRIVAL_LAGS as f64
    }
}

impl<P: Scalar> StripModel<P> {
    /// What others need to know of the surface, given its place among them.
    pub(crate) fn source(&self, first_edge: usize, first_strip: usize) -> Source<P> {
        Source {
            first_edge,
            first_strip,
            image: false,
            strips: self.settings.strips,
            edge_cores: self.grid.half_widths().map(|half| half * CORE).collect(),
            core_growth: self.grid.mean_chord * CORE_GROWTH.powi(2),
            least: self.grid.mean_chord * LEAST_DISTANCE,
        }
    }

    /// Writes the surface's vortices among those of all.
    pub(crate) fn shed<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        sections: &dyn Sections<G>,
        wind: Vec3<G>,
        x: &[S],
        [first_edge, first_strip]: [usize; 2],
        vortices: &mut Vortices<G, S>,
    ) {
        let n = self.settings.strips;
        for (j, edge) in vortices.edges[first_edge..].iter_mut().enumerate().take(n + 1) {
            *edge = self.vortex_line(&ChordLine::from(&sections.section(j)), wind);
        }
        let mut strips = Strips::<G, G, MAX_STRIPS>::ZERO;
        if self.settings.section.law.about().attachment == Attachment::AtOnce {
            let mut edges = Edges::ZERO;
            edges.fill(sections, n);
            self.move_strips(&edges, wind, &mut strips);
        }
        let attached = self.attached_shares(&strips, x);
        let sums = self.lag_sums(&self.lagged(x), &attached);
        vortices.circulation[first_strip..first_strip + n].copy_from_slice(&sums.circulation[..n]);
    }

    /// Wash of the other surfaces; advances what carries their circulation here:
    /// z_1' = r (Gamma - z_1), z_2' = r (z_1 - z_2), the last one shed where this surface is.
    ///
    /// Equation: aero.strip.foreign_wash
    /// `w += sum(ring Gamma + wake z_n), z_1' = r (Gamma - z_1), z_n' = r (z_(n-1) - z_n)`
    /// Source: Helmholtz; own derivation.
    /// Test: `a_steady_state_does_not_know_the_delay`.
    #[inline(never)]
    pub(super) fn wash_of_others<K: Scalar, G: Over<K> + Meets<P>, S: Over<G> + Meets<P>, const N: usize>(
        &self,
        strips: &Strips<K, G, N>,
        others: Others<'_, P, G, S>,
    ) -> Foreign<S, N> {
        let whole = self.whole(strips);
        let [control, bound]: [NormalPoints<G, N>; 2] = [
            NormalPoints::new(&strips.three_quarter, &strips.normal),
            NormalPoints::new(&strips.quarter, &strips.normal),
        ];
        let mut foreign = Foreign { at_control: [S::ZERO; N], at_bound: [S::ZERO; N] };
        let (mut x, mut dx) = (others.x, others.dx);
        for source in others.sources {
            let n = source.strips;
            let (arrived, x_rest) = x.split_at(source.arrivals());
            let (rates, dx_rest) = std::mem::take(&mut dx).split_at_mut(source.arrivals());
            (x, dx) = (x_rest, dx_rest);
            let vortices = if source.image { others.images } else { Some(others.vortices) };
            let Some(vortices) = vortices else {
                rates.fill(S::ZERO);
                continue;
            };
            let edges = &vortices.edges[source.first_edge..][..n + 1];
            let circulation = &vortices.circulation[source.first_strip..][..n];
            for (j, ends) in edges.windows(2).enumerate() {
                let rate = whole.arrival_rate(ends, source.least);
                let mut before = circulation[j];
                for at in (j..arrived.len()).step_by(n) {
                    rates[at] = (before - arrived[at]) * rate;
                    before = arrived[at];
                }
            }
            let strengths = [circulation, &arrived[(ARRIVAL_LAGS - 1) * n..]];
            control.add(source, edges, strengths, &mut foreign.at_control);
            bound.add(source, edges, strengths, &mut foreign.at_bound);
        }
        foreign
    }

    /// Makes room behind the strips that `loads` holds and writes the wash of others there.
    pub(super) fn note_others<S: Scalar + Meets<P>, const N: usize>(
        &self,
        foreign: Option<&Foreign<S, N>>,
        loads: &mut Loads<S>,
    ) {
        let first = loads.extend(self.settings.strips);
        if let Some(foreign) = foreign {
            let own = &mut loads.wash_of_others[first..];
            own.copy_from_slice(&foreign.at_control[..own.len()]);
        }
    }

    /// Means over the surface's area, at 3/4 chord.
    fn whole<K: Scalar, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        strips: &Strips<K, G, N>,
    ) -> MeanMotion<G> {
        let (mut centre, mut air) = (Vec3::ZERO, Vec3::ZERO);
        for i in 0..N {
            let share = self.tables.share[i];
            centre += strips.three_quarter.get(i).lifted::<G>().scaled(share);
            let met = strips.chordwise.get(i).times(strips.along[i])
                + strips.normal.get(i).times(strips.wash[i])
                - strips.across.get(i).times(strips.drift[i]);
            air += met.scaled(share);
        }
        MeanMotion { centre, speed: (air.norm_squared() + self.floor * self.floor).sqrt() }
    }
}
