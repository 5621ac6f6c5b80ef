//! Points, velocities and directions of edges and strips at one instant.

use super::StripModel;
use super::influence::{StripColumn, lanes, large, plain};
use crate::section::ZeroLift;
use crate::{SectionMotion, Sections};
use wingbeat_math::{Meets, Over, Scalar, Vec3};

/// Speed over the general floor below which the wake has no direction of its own
/// and leaves along the chord: a wing that reverses in still air turns its wake by and by.
const WAKE_FLOOR: f64 = 5.0;

/// A vector per strip, by component.
#[derive(Clone, Copy)]
pub(super) struct Vectors<S, const N: usize>(pub [[S; N]; 3]);

impl<S: Scalar, const N: usize> Vectors<S, N> {
    pub const ZERO: Self = Self([[S::ZERO; N]; 3]);

    #[inline(always)]
    pub fn get(&self, i: usize) -> Vec3<S> {
        Vec3([self.0[0][i], self.0[1][i], self.0[2][i]])
    }
    #[inline(always)]
    pub fn set(&mut self, i: usize, v: Vec3<S>) {
        let [x, y, z] = v.0;
        (self.0[0][i], self.0[1][i], self.0[2][i]) = (x, y, z);
    }
}

/// Ends of a chord line with their velocities and accelerations. Here and below what places alone decide is in `K`.
#[derive(Clone, Copy)]
pub(super) struct ChordLine<K: Scalar, S: Scalar> {
    le: Vec3<K>,
    te: Vec3<K>,
    v_le: Vec3<S>,
    v_te: Vec3<S>,
    a_le: Vec3<S>,
    a_te: Vec3<S>,
}

impl<K: Scalar, S: Over<K>> From<&SectionMotion<S>> for ChordLine<K, S> {
    #[inline(always)]
    fn from(s: &SectionMotion<S>) -> Self {
        Self {
            le: s.le.beneath(),
            te: s.te.beneath(),
            v_le: s.v_le,
            v_te: s.v_te,
            a_le: s.a_le,
            a_te: s.a_te,
        }
    }
}

/// A chord line per strip: its left or its right edge.
#[derive(Clone, Copy)]
struct ChordLines<K: Scalar, S: Scalar, const N: usize> {
    ends: [Vectors<K, N>; 2],
    moving: [Vectors<S, N>; 4],
}

impl<K: Scalar, S: Scalar, const N: usize> ChordLines<K, S, N> {
    const ZERO: Self = Self { ends: [Vectors::ZERO; 2], moving: [Vectors::ZERO; 4] };

    #[inline(always)]
    fn get(&self, i: usize) -> ChordLine<K, S> {
        let ([le, te], [v_le, v_te, a_le, a_te]) = (&self.ends, &self.moving);
        ChordLine {
            le: le.get(i),
            te: te.get(i),
            v_le: v_le.get(i),
            v_te: v_te.get(i),
            a_le: a_le.get(i),
            a_te: a_te.get(i),
        }
    }
    #[inline(always)]
    fn set(&mut self, i: usize, line: &ChordLine<K, S>) {
        self.ends[0].set(i, line.le);
        self.ends[1].set(i, line.te);
        let moving = [line.v_le, line.v_te, line.a_le, line.a_te];
        for k in 0..moving.len() {
            self.moving[k].set(i, moving[k]);
        }
    }
}

/// The edges of all strips; lanes beyond the last strip repeat it.
pub(super) struct Edges<K: Scalar, S: Scalar, const N: usize> {
    left: ChordLines<K, S, N>,
    right: ChordLines<K, S, N>,
    last: ChordLine<K, S>,
}

impl<K: Scalar, S: Over<K>, const N: usize> Edges<K, S, N> {
    pub const ZERO: Self = {
        let zero = Vec3::ZERO;
        let last =
            ChordLine { le: Vec3::ZERO, te: Vec3::ZERO, v_le: zero, v_te: zero, a_le: zero, a_te: zero };
        Self { left: ChordLines::ZERO, right: ChordLines::ZERO, last }
    };

    /// Takes the edges of `n` strips.
    #[inline(always)]
    pub fn fill(&mut self, sections: &dyn Sections<S>, n: usize) {
        for j in 0..=n {
            let line = ChordLine::from(&sections.section(j));
            if j < n {
                self.left.set(j, &line);
            }
            if j > 0 {
                self.right.set(j - 1, &line);
            }
            self.last = line;
        }
        let before = self.left.get(n - 1);
        for i in n..N {
            self.left.set(i, &before);
            self.right.set(i, &self.last);
        }
    }
}

/// An edge between strips: the bound vortex bends at `bound`, the wake leaves at `trailing`.
#[derive(Clone, Copy)]
pub(super) struct StripEdge<K: Scalar, S: Scalar> {
    /// Quarter-chord point.
    pub bound: Vec3<K>,
    /// Trailing edge.
    pub trailing: Vec3<K>,
    /// Direction in which the wake leaves.
    pub wake: Vec3<S>,
}

impl<K: Scalar, S: Over<K>> StripEdge<K, S> {
    /// The wake leaves with the wind that the trailing edge meets, turned so that
    /// it never runs forward over the wing:
    /// u = unit(v + e_c g), g = smooth max(0, |v|/4 + delta - v.e_c).
    ///
    /// Equation: aero.strip.wake_direction
    /// `u = unit(v + e_c g), g = smooth max(0, abs(v)/4 + delta - v.e_c)`
    /// Source: choice: the wake never runs forward over the wing.
    /// Test: `deep_folds_and_any_wind_stay_smooth_in_time`.
    #[inline(always)]
    fn new(line: &ChordLine<K, S>, wind: Vec3<S>, floor: f64) -> Self {
        let air = wind - line.v_te;
        let chord = line.te - line.le;
        let chordwise = chord.unit();
        let least = (air.norm_squared() + floor * floor).sqrt() * 0.25 + floor;
        let turn = (least - chordwise.dot_over(air)).smooth_positive(floor);
        let bound = line.le + chord.scaled(0.25);
        Self { bound, trailing: line.te, wake: (air + chordwise.times(turn)).unit() }
    }
}

/// Vortex lines of all edges: left edge of each strip, and the last edge.
pub(super) struct Wakes<K: Scalar, S: Scalar, const N: usize> {
    bound: Vectors<K, N>,
    trailing: Vectors<K, N>,
    wake: Vectors<S, N>,
    strips: usize,
    last: StripEdge<K, S>,
}

impl<K: Scalar, S: Over<K>, const N: usize> Wakes<K, S, N> {
    pub const ZERO: Self = {
        let last = StripEdge { bound: Vec3::ZERO, trailing: Vec3::ZERO, wake: Vec3::ZERO };
        Self { bound: Vectors::ZERO, trailing: Vectors::ZERO, wake: Vectors::ZERO, strips: 0, last }
    };

    /// Edge `j`, 0 to the number of strips.
    #[inline(always)]
    pub fn edge(&self, j: usize) -> StripEdge<K, S> {
        if j == self.strips {
            return self.last;
        }
        StripEdge { bound: self.bound.get(j), trailing: self.trailing.get(j), wake: self.wake.get(j) }
    }

    #[inline(always)]
    fn set(&mut self, j: usize, edge: &StripEdge<K, S>) {
        self.bound.set(j, edge.bound);
        self.trailing.set(j, edge.trailing);
        self.wake.set(j, edge.wake);
    }
}

/// The control section of a strip.
#[derive(Clone, Copy)]
struct Strip<K: Scalar, S: Scalar> {
    quarter: Vec3<K>,
    half: Vec3<K>,
    three_quarter: Vec3<K>,
    normal: Vec3<K>,
    normal_rate: Vec3<S>,
    chordwise: Vec3<K>,
    across: Vec3<K>,
    drift: S,
    wash: S,
    wash_half: S,
    wash_half_rate: S,
    along: S,
    speed: S,
    pitch: S,
    pitch_rate: S,
}

impl<K: Scalar, S: Over<K>> Strip<K, S> {
    /// The strip between two edges, its control section at `fraction`, whose own 1/4, 1/2 and 3/4 chord lie at the chord fractions
    /// `quarter`, `half` and `three_quarter` of the straight lines between the edges: see aero.strip.bulge.
    ///
    /// Equation: aero.strip.kinematics
    /// `n = unit(chord x line), n' and q from the rates of both`
    /// Source: rigid sections between straight edges.
    /// Test: `the_carried_air_of_strips_gives_no_mean_force`.
    #[inline(always)]
    fn new<P: Scalar>(
        [a, b]: [&ChordLine<K, S>; 2],
        [fraction, quarter, half, three_quarter]: [P; 4],
        wind: Vec3<S>,
        floor: f64,
        zero_lift: ZeroLift<P>,
    ) -> Self
    where
        K: Meets<P>,
        S: Meets<P>,
    {
        let mix = |p: Vec3<S>, q: Vec3<S>| p.shifted(q - p, fraction);
        let between = |p: Vec3<K>, q: Vec3<K>| p.shifted(q - p, fraction);
        let (le, v_le, a_le) = (between(a.le, b.le), mix(a.v_le, b.v_le), mix(a.a_le, b.a_le));
        let chord = between(a.te, b.te) - le;
        let chord_rate = mix(a.v_te, b.v_te) - v_le;
        let chord_change = mix(a.a_te, b.a_te) - a_le;

        let line = (b.le - a.le) + (b.te - a.te);
        let line_rate = (b.v_le - a.v_le) + (b.v_te - a.v_te);
        let inverse_chord = chord.norm().recip();
        let forward = chord * inverse_chord;
        let area = chord.cross(line);
        let area_rate = chord_rate.cross_under(line) + chord.cross_over(line_rate);
        let inverse_area = area.norm().recip();
        let upward = area * inverse_area;
        let turning = area_rate.scaled(inverse_area);
        let upward_rate = turning - upward.times(upward.dot_over(turning));
        let across = upward.cross(forward);
        let (chordwise, normal) = zero_lift.turned(forward, upward);
        let normal_rate = zero_lift.turned_rate(upward_rate, || {
            let swinging = chord_rate.scaled(inverse_chord);
            swinging - forward.times(forward.dot_over(swinging))
        });

        let air_half = wind - (v_le + chord_rate.scaled(half));
        let air = air_half - chord_rate.scaled(three_quarter - half);
        let (wash, along) = (normal.dot_over(air), chordwise.dot_over(air));
        Self {
            quarter: le + chord.scaled(quarter),
            half: le + chord.scaled(half),
            three_quarter: le + chord.scaled(three_quarter),
            normal,
            normal_rate,
            chordwise,
            across,
            drift: -across.dot_over(air_half),
            wash,
            wash_half: normal.dot_over(air_half),
            wash_half_rate: air_half.dot(normal_rate) - normal.dot_over(a_le + chord_change.scaled(half)),
            along,
            speed: (wash * wash + along * along + floor * floor).sqrt(),
            pitch: -upward.dot_over(chord_rate) * inverse_chord,
            pitch_rate: -(upward.dot_over(chord_change) + chord_rate.dot(upward_rate)) * inverse_chord,
        }
    }
}

/// The control sections of all strips.
pub(super) struct Strips<K: Scalar, S: Scalar, const N: usize> {
    /// Points at 1/4, 1/2 and 3/4 chord.
    pub quarter: Vectors<K, N>,
    pub half: Vectors<K, N>,
    pub three_quarter: Vectors<K, N>,
    /// Unit normals towards the upper side, and their rates.
    pub normal: Vectors<K, N>,
    pub normal_rate: Vectors<S, N>,
    /// Unit vectors along the zero-lift lines towards the trailing edge.
    pub chordwise: Vectors<K, N>,
    /// Unit vectors across the sections: the axes of nose-up pitch.
    pub across: Vectors<K, N>,
    /// Velocity across the section relative to the air at 1/2 chord, m/s.
    pub drift: StripColumn<S, N>,
    /// Normal wash at 3/4 and 1/2 chord by motion and wind, m/s.
    pub wash: StripColumn<S, N>,
    pub wash_half: StripColumn<S, N>,
    /// Rate of `wash_half` from the accelerations known, m/s2.
    pub wash_half_rate: StripColumn<S, N>,
    /// Chordwise and smooth speed of the air at 3/4 chord, m/s.
    pub along: StripColumn<S, N>,
    pub speed: StripColumn<S, N>,
    /// Pitch rate, rad/s, and its rate, rad/s2.
    pub pitch: StripColumn<S, N>,
    pub pitch_rate: StripColumn<S, N>,
}

impl<K: Scalar, S: Over<K>, const N: usize> Strips<K, S, N> {
    /// Nothing moves yet.
    pub const ZERO: Self = {
        let (vectors, zero) = (Vectors::ZERO, [S::ZERO; N]);
        Self {
            quarter: vectors,
            half: vectors,
            three_quarter: vectors,
            normal: vectors,
            normal_rate: Vectors::ZERO,
            chordwise: vectors,
            across: vectors,
            drift: zero,
            wash: zero,
            wash_half: zero,
            wash_half_rate: zero,
            along: zero,
            speed: zero,
            pitch: zero,
            pitch_rate: zero,
        }
    };

    #[inline(always)]
    fn set(&mut self, i: usize, strip: &Strip<K, S>) {
        self.quarter.set(i, strip.quarter);
        self.half.set(i, strip.half);
        self.three_quarter.set(i, strip.three_quarter);
        self.normal.set(i, strip.normal);
        self.normal_rate.set(i, strip.normal_rate);
        self.chordwise.set(i, strip.chordwise);
        self.across.set(i, strip.across);
        self.drift[i] = strip.drift;
        self.wash[i] = strip.wash;
        self.wash_half[i] = strip.wash_half;
        self.wash_half_rate[i] = strip.wash_half_rate;
        self.along[i] = strip.along;
        self.speed[i] = strip.speed;
        self.pitch[i] = strip.pitch;
        self.pitch_rate[i] = strip.pitch_rate;
    }
}

impl<K: Scalar, S: Over<K>, const N: usize> Strips<K, S, N> {
    /// Acceleration of mid chord of strip `i` by the turn of its normal in the air, m/s2.
    #[inline(always)]
    pub fn turning(&self, i: usize) -> S {
        let rate = self.normal_rate.get(i);
        self.along[i] * self.chordwise.get(i).dot_over(rate)
            - self.drift[i] * self.across.get(i).dot_over(rate)
    }
}

impl<P: Scalar> StripModel<P> {
    /// Motion of all strips and vortex lines of all edges, one section after the other.
    #[inline(never)]
    pub(super) fn move_on<K: Scalar + Meets<P>, S: Over<K> + Meets<P>, const N: usize>(
        &self,
        sections: &dyn Sections<S>,
        wind: Vec3<S>,
        strips: &mut Strips<K, S, N>,
        wakes: &mut Wakes<K, S, N>,
    ) {
        let n = self.settings.strips.min(N);
        let mut put = |i: usize, left: &ChordLine<K, S>, right: &ChordLine<K, S>| {
            wakes.set(i, &self.vortex_line(left, wind));
            let section = self.tables.section(i);
            strips.set(i, &Strip::new([left, right], section, wind, self.floor, self.zero_lift));
        };
        // The left and the right edge take turns.
        let last = if const { large::<S>() } {
            let mut edges = [ChordLine::from(&sections.section(0)); 2];
            for i in 0..n {
                let (left, right) = (i % 2, (i + 1) % 2);
                edges[right] = ChordLine::from(&sections.section(i + 1));
                put(i, &edges[left], &edges[right]);
            }
            edges[n % 2]
        } else {
            // As sections, which come to where they stay.
            let mut even = sections.section(0);
            let mut odd = even;
            for i in 0..n {
                let (left, right) = if i.is_multiple_of(2) {
                    odd = sections.section(i + 1);
                    (&even, &odd)
                } else {
                    even = sections.section(i + 1);
                    (&odd, &even)
                };
                put(i, &ChordLine::from(left), &ChordLine::from(right));
            }
            ChordLine::from(if n.is_multiple_of(2) { &even } else { &odd })
        };
        wakes.last = self.vortex_line(&last, wind);
        wakes.strips = n;
    }

    /// Motion of all strips.
    #[inline(never)]
    pub(super) fn move_strips<K: Scalar + Meets<P>, S: Over<K> + Meets<P>, const N: usize>(
        &self,
        edges: &Edges<K, S, N>,
        wind: Vec3<S>,
        out: &mut Strips<K, S, N>,
    ) {
        // Of plain numbers each case a loop of its own, so that both vectorise.
        match self.zero_lift {
            ZeroLift::Chord if const { plain::<S>() } => self.move_each(edges, wind, ZeroLift::Chord, out),
            inclined => self.move_each(edges, wind, inclined, out),
        }
    }

    #[inline(always)]
    fn move_each<K: Scalar + Meets<P>, S: Over<K> + Meets<P>, const N: usize>(
        &self,
        edges: &Edges<K, S, N>,
        wind: Vec3<S>,
        zero_lift: ZeroLift<P>,
        out: &mut Strips<K, S, N>,
    ) {
        for i in 0..lanes::<S, N>(self.settings.strips) {
            let (a, b) = (edges.left.get(i), edges.right.get(i));
            let section = self.tables.section(i);
            out.set(i, &Strip::new([&a, &b], section, wind, self.floor, zero_lift));
        }
    }

    /// Vortex lines of all edges.
    #[inline(never)]
    pub(super) fn shed_wakes<K: Scalar + Meets<P>, S: Over<K> + Meets<P>, const N: usize>(
        &self,
        edges: &Edges<K, S, N>,
        wind: Vec3<S>,
        out: &mut Wakes<K, S, N>,
    ) {
        for j in 0..lanes::<S, N>(self.settings.strips) {
            out.set(j, &self.vortex_line(&edges.left.get(j), wind));
        }
        out.last = self.vortex_line(&edges.last, wind);
        out.strips = self.settings.strips;
    }

    /// The vortex line of one edge.
    #[inline(always)]
    pub(super) fn vortex_line<K: Scalar + Meets<P>, S: Over<K> + Meets<P>>(
        &self,
        line: &ChordLine<K, S>,
        wind: Vec3<S>,
    ) -> StripEdge<K, S> {
        StripEdge::new(line, wind, WAKE_FLOOR * self.floor)
    }
}
