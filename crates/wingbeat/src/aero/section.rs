//! One strip of air and wing: the directions of a moving section, the wind it
//! meets, and the air that it carries along.

use super::{SectionMotion, Wrench};
use crate::math::{Scalar, Vec3};

/// Directions, winds and rates of one section, resolved in B. Chord lines are rigid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section<S: Scalar> {
    /// Unit vector from leading to trailing edge.
    pub chordwise: Vec3<S>,
    /// Unit vector to the upper side, chordwise x span.
    pub normal: Vec3<S>,
    /// Unit vector across the section, normal x chordwise: from left tip to right tip.
    pub across: Vec3<S>,
    /// Mid-chord point.
    pub middle: Vec3<S>,
    /// Wind along the chord, m/s.
    pub uc: S,
    /// Wind along the normal at 1/2 chord, m/s.
    pub w_half: S,
    /// Wind along the normal at 3/4 chord, m/s.
    pub w_three_quarter: S,
    /// Velocity across the section relative to the air, m/s.
    pub drift: S,
    /// Rate of pitch, nose up, rad/s.
    pub pitch_rate: S,
    /// Rate of roll of the normal towards `across`, rad/s: n' = pitch_rate e_c + roll_rate across.
    pub roll_rate: S,
    /// Acceleration of mid chord along the normal, m/s2.
    pub acceleration: S,
    /// Acceleration of pitch, nose up, rad/s2.
    pub pitch_acceleration: S,
}

impl<S: Scalar> Section<S> {
    /// Geometry and kinematics of a section in the air velocity `wind`.
    ///
    /// With the span direction at the sweep angle L from `across`, the normal
    /// turns by n' = q e_c + p across, p = -w.e_c - tan(L) (q - w.across).
    ///
    /// Equation: aero.section_kinematics
    #[inline]
    pub fn new(motion: &SectionMotion<S>, wind: Vec3<S>) -> Self {
        let chord = motion.te - motion.le;
        let inverse_chord = chord.norm_squared().sqrt().recip();
        let chordwise = chord * inverse_chord;
        let normal_raw = chordwise.cross(motion.span);
        let normal = normal_raw * normal_raw.norm().recip();
        let across = normal.cross(chordwise);
        let tan_sweep = motion.span.dot(chordwise) / motion.span.dot(across);
        let velocity = motion.velocity(0.5) - wind;
        let velocity_change = motion.v_te - motion.v_le;
        let pitch_rate = -(velocity_change.dot(normal) * inverse_chord);
        let roll_rate = -motion.w.dot(chordwise) - tan_sweep * (pitch_rate - motion.w.dot(across));
        let pitch_acceleration = -(((motion.a_te - motion.a_le).dot(normal)
            + roll_rate * velocity_change.dot(across))
            * inverse_chord);
        let w_half = -velocity.dot(normal);
        Self {
            chordwise,
            normal,
            across,
            middle: motion.point(0.5),
            uc: -velocity.dot(chordwise),
            w_half,
            w_three_quarter: w_half - velocity_change.dot(normal) * 0.25,
            drift: velocity.dot(across),
            pitch_rate,
            roll_rate,
            acceleration: motion.acceleration(0.5).dot(normal),
            pitch_acceleration,
        }
    }

    /// Force of the carried air at mid chord, and couple, for the strip's added
    /// mass `mass` kg: Kirchhoff's F = -d/dt(m v_n n) with the couple
    /// -m v_n v_span (across x n). Its mean over any closed cycle is zero.
    ///
    /// Equation: aero.added_mass
    #[inline]
    pub fn added_mass(&self, mass: f64) -> (Vec3<S>, Vec3<S>) {
        let v_n = -self.w_half;
        let rate = self.acceleration - self.pitch_rate * self.uc + self.roll_rate * self.drift;
        let turning = self.chordwise * self.pitch_rate + self.across * self.roll_rate;
        let force = (self.normal * rate + turning * v_n) * S::from(-mass);
        (force, self.chordwise * (v_n * self.drift * -mass))
    }

    /// Nose-up couple about the quarter chord of a pitching section beyond the
    /// mid-chord force: -m [(b/2) V q + (b^2/8) q'].
    ///
    /// Equation: aero.section_moment
    #[inline]
    pub fn section_moment(&self, mass: f64, half_chord: f64, speed: S) -> S {
        speed * self.pitch_rate * (-0.5 * mass * half_chord)
            - self.pitch_acceleration * (mass * half_chord * half_chord / 8.0)
    }

    /// Adds this strip's share of the added-mass matrix (upper triangle) on
    /// [acceleration; angular acceleration] of the body origin: `mass` along
    /// the normal at mid chord, `inertia` kg m2 about the section's axis.
    #[inline]
    pub fn add_inertia(&self, mass: f64, inertia: f64, matrix: &mut [[S; 6]; 6]) {
        let [n, m] = [self.normal, self.middle.cross(self.normal)];
        let g = [n[0], n[1], n[2], m[0], m[1], m[2]];
        let scaled = g.map(|x| x * mass);
        for i in 0..6 {
            for j in i..6 {
                matrix[i][j] += scaled[i] * g[j];
            }
        }
        if inertia != 0.0 {
            for i in 0..3 {
                let row = self.across[i] * inertia;
                for j in i..3 {
                    matrix[3 + i][3 + j] += row * self.across[j];
                }
            }
        }
    }
}

/// Forces of one strip with their points of attack.
#[derive(Clone, Copy, Debug)]
pub(super) struct StripForces<S: Scalar> {
    /// Quarter-chord point, where lift and induced drag act.
    pub quarter: Vec3<S>,
    /// Lift perpendicular to the wind of motion.
    pub circulatory: Vec3<S>,
    /// What turning by the wash adds.
    pub induced_drag: Vec3<S>,
    /// Mid-chord point, where the added mass acts.
    pub middle: Vec3<S>,
    /// Force of the carried air.
    pub added_mass: Vec3<S>,
    /// Couple of the carried air, section moment included.
    pub couple: Vec3<S>,
    /// Where the profile drag acts.
    pub drag_centre: Vec3<S>,
    /// Profile drag.
    pub profile_drag: Vec3<S>,
}

impl<S: Scalar> StripForces<S> {
    /// By source.
    #[inline]
    pub fn by_source(&self) -> super::StripLoads<S> {
        super::StripLoads {
            circulatory: Wrench::at(self.quarter, self.circulatory),
            induced_drag: Wrench::at(self.quarter, self.induced_drag),
            added_mass: Wrench::at(self.middle, self.added_mass) + Wrench::couple(self.couple),
            profile_drag: Wrench::at(self.drag_centre, self.profile_drag),
        }
    }

    /// Sum over the sources.
    #[inline]
    pub fn total(&self) -> Wrench<S> {
        let lift = self.circulatory + self.induced_drag;
        Wrench {
            force: lift + self.added_mass + self.profile_drag,
            moment: self.quarter.cross(lift)
                + self.middle.cross(self.added_mass)
                + self.drag_centre.cross(self.profile_drag)
                + self.couple,
        }
    }
}
