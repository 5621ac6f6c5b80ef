//! Points, velocities and directions of edges and strips at one instant.

use super::StripModel;
use crate::aero::section::SectionForce;
use crate::aero::{SectionMotion, Wrench};
use crate::math::{Scalar, Vec3};

/// Speed over the general floor below which the wake has no direction of its own
/// and leaves along the chord: a wing that reverses in still air turns its wake by and by.
const WAKE_FLOOR: f64 = 5.0;

/// An edge between strips: the bound vortex bends at `bound`, the wake leaves at `trailing`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Edge<S: Scalar> {
    /// Quarter-chord point.
    pub bound: Vec3<S>,
    /// Trailing edge.
    pub trailing: Vec3<S>,
    /// Direction in which the wake leaves.
    pub wake: Vec3<S>,
}

/// The control section of a strip.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Strip<S: Scalar> {
    /// Points at 1/4, 1/2 and 3/4 chord.
    pub quarter: Vec3<S>,
    pub half: Vec3<S>,
    pub three_quarter: Vec3<S>,
    /// Unit normal towards the upper side, and its rate.
    pub normal: Vec3<S>,
    pub normal_rate: Vec3<S>,
    /// Unit vector from leading to trailing edge.
    pub chordwise: Vec3<S>,
    /// Unit vector across the section: the axis of nose-up pitch.
    pub across: Vec3<S>,
    /// Velocity across the section relative to the air at 1/2 chord.
    pub drift: S,
    /// Normal wash at 3/4 and 1/2 chord by motion and wind.
    pub wash: S,
    pub wash_half: S,
    /// Rate of `wash_half` from the accelerations known.
    pub wash_half_rate: S,
    /// Chordwise speed at 3/4 chord.
    pub along: S,
    /// Smooth speed at 3/4 chord.
    pub speed: S,
    /// Pitch rate and its rate.
    pub pitch: S,
    pub pitch_rate: S,
}

impl<S: Scalar> Edge<S> {
    /// The wake leaves with the wind that the trailing edge meets, turned so that
    /// it never runs forward over the wing:
    /// u = unit(v + e_c g), g = smooth max(0, |v|/4 + delta - v.e_c).
    ///
    /// Equation: aero.strip.wake_direction
    pub fn new(section: &SectionMotion<S>, wind: Vec3<S>, floor: f64) -> Self {
        let air = wind - section.v_te;
        let chordwise = (section.te - section.le).unit();
        let least = (air.norm_squared() + floor * floor).sqrt() * 0.25 + floor;
        let turn = (least - air.dot(chordwise)).smooth_positive(floor);
        Self { bound: section.point(0.25), trailing: section.te, wake: (air + chordwise * turn).unit() }
    }
}

impl<S: Scalar> Strip<S> {
    /// The strip between two edge sections, its control section at `fraction`.
    ///
    /// Equation: aero.strip.kinematics
    pub fn new(a: &SectionMotion<S>, b: &SectionMotion<S>, fraction: f64, wind: Vec3<S>, floor: f64) -> Self {
        let (f, g) = (S::from(fraction), S::from(1.0 - fraction));
        let mix = |p: Vec3<S>, q: Vec3<S>| p * g + q * f;
        let (le, te) = (mix(a.le, b.le), mix(a.te, b.te));
        let (v_le, v_te) = (mix(a.v_le, b.v_le), mix(a.v_te, b.v_te));
        let (a_le, a_te) = (mix(a.a_le, b.a_le), mix(a.a_te, b.a_te));
        let at = |x: f64, p: Vec3<S>, q: Vec3<S>| p * S::from(1.0 - x) + q * S::from(x);

        let (chord, chord_rate) = (te - le, v_te - v_le);
        let line = (b.le - a.le) + (b.te - a.te);
        let line_rate = (b.v_le - a.v_le) + (b.v_te - a.v_te);
        let inverse_chord = chord.norm().recip();
        let chordwise = chord * inverse_chord;
        let area = chord.cross(line);
        let area_rate = chord_rate.cross(line) + chord.cross(line_rate);
        let inverse_area = area.norm().recip();
        let normal = area * inverse_area;
        let turning = area_rate * inverse_area;
        let normal_rate = turning - normal * turning.dot(normal);

        let across = normal.cross(chordwise);

        let air = wind - at(0.75, v_le, v_te);
        let air_half = wind - at(0.5, v_le, v_te);
        let (wash, along) = (air.dot(normal), air.dot(chordwise));
        Self {
            quarter: at(0.25, le, te),
            half: at(0.5, le, te),
            three_quarter: at(0.75, le, te),
            normal,
            normal_rate,
            chordwise,
            across,
            drift: -air_half.dot(across),
            wash,
            wash_half: air_half.dot(normal),
            wash_half_rate: air_half.dot(normal_rate) - at(0.5, a_le, a_te).dot(normal),
            along,
            speed: (wash * wash + along * along + floor * floor).sqrt(),
            pitch: -chord_rate.dot(normal) * inverse_chord,
            pitch_rate: -((a_te - a_le).dot(normal) + chord_rate.dot(normal_rate)) * inverse_chord,
        }
    }
}

impl<S: Scalar> Strip<S> {
    /// A force of the section as a wrench about the body origin.
    #[inline]
    pub fn wrench(&self, force: SectionForce<S>) -> Wrench<S> {
        force.wrench(self.half, self.chordwise, self.normal, self.across)
    }
}

impl StripModel {
    /// Motion of edge `j`.
    #[inline]
    pub(super) fn edge<S: Scalar>(&self, sections: &[SectionMotion<S>], wind: Vec3<S>, j: usize) -> Edge<S> {
        Edge::new(&sections[j], wind, WAKE_FLOOR * self.floor)
    }
    /// Motion of strip `i`.
    #[inline]
    pub(super) fn strip<S: Scalar>(
        &self,
        sections: &[SectionMotion<S>],
        wind: Vec3<S>,
        i: usize,
    ) -> Strip<S> {
        Strip::new(&sections[i], &sections[i + 1], self.grid.fraction[i], wind, self.floor)
    }
}
