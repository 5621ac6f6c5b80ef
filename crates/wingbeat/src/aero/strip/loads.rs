//! Forces and moments of the strips from their washes and impulses.

use super::influence::{Column, dot, multiply};
use super::motion::Strip;
use super::response::Response;
use super::{Flow, StripModel};
use crate::aero::section::{SectionForce, suction_share};
use crate::aero::{Loads, StripLoads, Wrench};
use crate::math::Scalar;

/// Forces in the planes of all sections, N, and how far ahead of mid chord they act, m.
#[derive(Clone, Copy)]
struct InPlane<S: Scalar, const N: usize> {
    chordwise: Column<S, N>,
    normal: Column<S, N>,
    ahead: Column<S, N>,
}

impl<S: Scalar, const N: usize> InPlane<S, N> {
    const ZERO: Self = Self { chordwise: [S::ZERO; N], normal: [S::ZERO; N], ahead: [S::ZERO; N] };

    fn set_ahead(&mut self, values: impl Iterator<Item = S>) {
        for (ahead, value) in self.ahead.iter_mut().zip(values) {
            *ahead = value;
        }
    }
    #[inline(always)]
    fn at(&self, i: usize) -> SectionForce<S> {
        SectionForce::in_plane(self.chordwise[i], self.normal[i], self.ahead[i])
    }
}

impl StripModel {
    /// Sum of the loads of all strips; `loads` receives them by strip and source.
    pub(super) fn load_strips<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        response: &Response<S, N>,
        mut loads: Option<&mut Loads<S>>,
    ) -> Wrench<S> {
        let [plain, lift] = self.circulatory(flow, response);
        let drag = self.profile_drag(flow, &response.attached);
        let mut wrench = Wrench::ZERO;
        for i in 0..self.settings.strips {
            let strip = &flow.strips[i];
            let carried = self.carried_air(i, strip, response);
            wrench += strip.wrench(lift.at(i) + carried + drag.at(i));
            let Some(loads) = loads.as_deref_mut() else { continue };
            let circulatory = strip.wrench(plain.at(i));
            let turned = strip.wrench(lift.at(i));
            loads.strip[i] = StripLoads {
                circulatory,
                induced_drag: turned + -circulatory,
                added_mass: strip.wrench(carried),
                profile_drag: strip.wrench(drag.at(i)),
            };
            if self.grid.covered[i] {
                loads.incidence[i] = response.lift_wash[i].atan2(strip.along);
            }
            loads.wash[i] = response.wash[i];
            loads.circulation[i] = response.circulation[i];
            loads.strips = self.settings.strips;
        }
        wrench
    }

    /// Forces at 1/4 chord, N: as the wash of motion alone directs them, and as the wash of
    /// wake and lags turns them.
    /// F = rho dy g lw [V |uc|/Ve n - W s e_c], Ve = sqrt(uc^2 + W^2 + delta^2), with the attached
    /// share of the lift, of which the suction s takes another share.
    ///
    /// Equation: aero.strip.force
    fn circulatory<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        response: &Response<S, N>,
    ) -> [InPlane<S, N>; 2] {
        let (attached, delta2) = (&response.attached, self.floor * self.floor);
        let mut lift: Column<S, N> = std::array::from_fn(|i| response.lift_wash[i] * attached[i]);
        for (lift, scale) in lift.iter_mut().zip(&self.lift_scale) {
            *lift *= *scale;
        }
        let directed = |wash: &Column<S, N>| {
            let mut force = InPlane::ZERO;
            for i in 0..N {
                let along2 = flow.along[i].squared() + delta2;
                let inverse = (wash[i].squared() + along2).sqrt().recip();
                let suction = suction_share(flow.along[i] * inverse) * attached[i];
                force.chordwise[i] = -(lift[i] * wash[i] * suction);
                force.normal[i] = lift[i] * flow.speed[i] * along2.sqrt() * inverse;
            }
            force.set_ahead(self.grid.chord.iter().map(|c| S::from(0.25 * c)));
            force
        };
        let plain = directed(&flow.wash);
        [plain, if self.settings.force_tilt { directed(&response.turning_wash) } else { plain }]
    }

    /// Profile drag of the sections in the wind of motion.
    fn profile_drag<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        attached: &Column<S, N>,
    ) -> InPlane<S, N> {
        let (law, drag, delta2) = (self.settings.law, self.settings.drag, self.floor * self.floor);
        let mut force = InPlane::ZERO;
        let mut ahead = [S::ZERO; N];
        for i in 0..N {
            let section = drag.section(law, flow.along[i], flow.half[i], attached[i], delta2);
            force.chordwise[i] = section.chordwise;
            force.normal[i] = section.normal;
            ahead[i] = S::from(0.5) - section.centre;
        }
        for (i, scale) in self.drag_scale.iter().enumerate().take(N) {
            force.chordwise[i] *= *scale;
            force.normal[i] *= *scale;
        }
        force.set_ahead(ahead.iter().zip(&self.grid.chord).map(|(ahead, chord)| *ahead * *chord));
        force
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
        response.relief[i] * self.strip_mass[i]
    }

    /// M = sym(J' rho dy ma A0^-1 J) with J = [n; r x n] per strip, plus the pitch inertia of the sections.
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
            let left: [Column<S, N>; 6] = std::array::from_fn(|r| {
                let mut column = multiply(&flow.relief, &lever[r], n);
                for (x, mass) in column.iter_mut().zip(&self.strip_mass) {
                    *x *= *mass;
                }
                column
            });
            for r in 0..6 {
                for c in 0..=r {
                    matrix[r][c] = (dot(&left[r], &lever[c], n) + dot(&left[c], &lever[r], n)) * 0.5;
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
