//! Forces and moments of the strips from their washes and impulses.

use super::influence::multiply;
use super::motion::Strip;
use super::response::Response;
use super::{Flow, StripModel};
use crate::aero::section::{SectionForce, suction_share};
use crate::aero::{Loads, StripLoads, Wrench};
use crate::math::Scalar;

impl StripModel {
    /// Sum of the loads of all strips; `loads` receives them by strip and source.
    pub(super) fn load_strips<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        response: &Response<S, N>,
        mut loads: Option<&mut Loads<S>>,
    ) -> Wrench<S> {
        let mut wrench = Wrench::ZERO;
        for i in 0..self.settings.strips {
            let strip = &flow.strips[i];
            let attached = self.attached(strip.along, response.lift_wash[i].squared());
            let [plain, turned] = self.circulatory(i, strip, response, attached);
            let carried = self.carried_air(i, strip, response);
            let drag = self.profile_drag(i, strip, attached);
            if let Some(loads) = loads.as_deref_mut() {
                loads.strip[i] = StripLoads {
                    circulatory: strip.wrench(plain),
                    induced_drag: strip.wrench(turned),
                    added_mass: strip.wrench(carried),
                    profile_drag: strip.wrench(drag),
                };
                loads.incidence[i] = response.lift_wash[i].atan2(strip.along);
                loads.wash[i] = response.wash[i];
                loads.circulation[i] = response.circulation[i];
                loads.strips = self.settings.strips;
            }
            wrench += strip.wrench(plain + turned + carried + drag);
        }
        wrench
    }

    /// Force at 1/4 chord, N: as the wash of motion alone directs it, and what
    /// the wash of wake and lags adds by turning it.
    /// F = rho dy g lw [V |uc|/Ve n - s W e_c], Ve = sqrt(uc^2 + W^2 + delta^2), with the attached
    /// share of the lift, of which the suction s takes another share.
    ///
    /// Equation: aero.strip.force
    fn circulatory<S: Scalar, const N: usize>(
        &self,
        i: usize,
        strip: &Strip<S>,
        response: &Response<S, N>,
        attached: S,
    ) -> [SectionForce<S>; 2] {
        let scale = self.settings.density_kg_m3 * self.grid.width[i] * self.slope[i];
        let lift = response.lift_wash[i] * attached * scale;
        let forward = strip.along.smooth_abs(self.floor);
        let part = |wash: S, speed: S| {
            let inverse = speed.recip();
            let suction = suction_share(strip.along * inverse) * attached;
            (-(lift * wash * suction), lift * strip.speed * forward * inverse)
        };
        let ahead = S::from(0.25 * self.grid.chord[i]);
        let (chordwise, normal) = part(strip.wash, strip.speed);
        let plain = SectionForce::in_plane(chordwise, normal, ahead);
        if !self.settings.force_tilt {
            return [plain, SectionForce::in_plane(S::ZERO, S::ZERO, S::ZERO)];
        }
        let wash = response.turning_wash[i];
        let speed = (strip.along.squared() + wash.squared() + self.floor * self.floor).sqrt();
        let turned = part(wash, speed);
        [plain, SectionForce::in_plane(turned.0 - chordwise, turned.1 - normal, ahead)]
    }

    /// Profile drag of the section in the wind of motion.
    fn profile_drag<S: Scalar>(&self, i: usize, strip: &Strip<S>, attached: S) -> SectionForce<S> {
        let (set, chord) = (&self.settings, self.grid.chord[i]);
        let delta2 = self.floor * self.floor;
        let drag = set.drag.section(set.law, strip.along, strip.wash_half, attached, delta2);
        let scale = 0.5 * set.density_kg_m3 * self.grid.width[i] * chord;
        let ahead = (S::from(0.5) - drag.centre) * chord;
        SectionForce::in_plane(drag.chordwise * scale, drag.normal * scale, ahead)
    }

    /// Force of the carried air at 1/2 chord, and its couple: F = d(P n)/dt, the impulse carried
    /// across (Kirchhoff) and the moment of the pitching section
    /// -rho dy ma f [(b/2) V q + (b^2/8) q'], f the normal speed left of a unit one.
    ///
    /// Equation: aero.strip.carried_air
    fn carried_air<S: Scalar, const N: usize>(
        &self,
        i: usize,
        strip: &Strip<S>,
        response: &Response<S, N>,
    ) -> SectionForce<S> {
        let impulse = response.impulse[i];
        let mut force = SectionForce {
            chordwise: strip.normal_rate.dot(strip.chordwise) * impulse,
            normal: response.impulse_rate[i],
            across: strip.normal_rate.dot(strip.across) * impulse,
            nose_up: S::ZERO,
            about_chord: strip.drift * impulse,
        };
        if self.settings.section_moment {
            let b = 0.5 * self.grid.chord[i];
            let moment = strip.speed * strip.pitch * (0.5 * b) + strip.pitch_rate * (0.125 * b * b);
            force.nose_up = -(moment * self.section_mass(i, response));
        }
        force
    }

    /// Added mass that resists pitching of the section, kg.
    fn section_mass<S: Scalar, const N: usize>(&self, i: usize, response: &Response<S, N>) -> S {
        response.relief[i] * self.strip_mass(i)
    }

    /// M = J' B J with J = [n; r x n] per strip, plus the pitch inertia of the sections.
    ///
    /// Equation: aero.strip.added_mass_matrix
    pub(super) fn added_mass<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        response: &Response<S, N>,
    ) -> [[S; 6]; 6] {
        let n = self.settings.strips;
        let mut matrix = [[S::ZERO; 6]; 6];
        if self.settings.added_mass {
            let lever = jacobian(&flow.strips);
            for r in 0..6 {
                let carried = multiply(&response.inertia, &lever[r], n);
                for c in 0..=r {
                    for i in 0..n {
                        matrix[r][c] += carried[i] * lever[c][i];
                    }
                }
            }
        }
        if self.settings.section_moment {
            for (i, strip) in flow.strips.iter().enumerate().take(n) {
                let b = 0.5 * self.grid.chord[i];
                let inertia = self.section_mass(i, response) * (0.125 * b * b);
                for r in 0..3 {
                    for c in 0..=r {
                        matrix[3 + r][3 + c] += strip.across[r] * strip.across[c] * inertia;
                    }
                }
            }
        }
        for r in 0..6 {
            for c in 0..r {
                matrix[c][r] = matrix[r][c];
            }
        }
        matrix
    }
}

/// Normal acceleration at 1/2 chord per acceleration and angular acceleration of
/// the body, by rows.
fn jacobian<S: Scalar, const N: usize>(strips: &[Strip<S>; N]) -> [[S; N]; 6] {
    let mut rows = [[S::ZERO; N]; 6];
    for (i, strip) in strips.iter().enumerate() {
        let moment = strip.half.cross(strip.normal);
        for axis in 0..3 {
            rows[axis][i] = strip.normal[axis];
            rows[3 + axis][i] = moment[axis];
        }
    }
    rows
}
