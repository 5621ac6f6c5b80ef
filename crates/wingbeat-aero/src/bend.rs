//! How the chord line of a section is bent: by a membrane, by a flap.

use crate::{Aero, MEMBRANE_DRAWN};
use wingbeat_math::interpolation::piecewise_linear;
use wingbeat_math::{Scalar, Vec3};

/// A bent chord line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChordBend<S: Scalar = f64> {
    /// Heights over the chord of both shapes of a membrane, dimensionless.
    pub heights: [S; 2],
    /// Angle of a flap, trailing edge down, rad.
    pub angle: S,
    /// Place of its hinge over the chord; 1 without one.
    pub hinge: f64,
}

impl<S: Scalar> ChordBend<S> {
    /// Place over the chord, along it from the leading edge and up, of the point at the share `x` of the straight chord.
    ///
    /// Equation: aero.chord_bend
    /// `x - y + y cos a along, sin^2 t (h_1 + h_2 cos t) - y sin a up, cos t = 1 - 2 x, y = max(0, x - hinge)`
    /// Source: choice: two shapes of a membrane, a plain flap.
    /// Test: `a_bent_chord_is_its_two_shapes_and_turns_about_its_hinge`.
    pub fn at(&self, x: S) -> [S; 2] {
        let [camber, forward] = self.heights;
        let up = x * 4.0 * (-x + 1.0) * (camber + forward * (-x * 2.0 + 1.0));
        if x.value() <= self.hinge {
            return [x, up];
        }
        let (behind, (sine, cosine)) = (x - self.hinge, self.angle.sin_cos());
        [behind * cosine + self.hinge, up - behind * sine]
    }
}

/// Height of a membrane over the chord at the share `x` of the chord from the leading edge, from [`Loads::camber`](crate::Loads::camber) and
/// [`Loads::camber_forward`](crate::Loads::camber_forward): sin^2 t (h_1 + h_2 cos t), cos t = 1 - 2 x.
pub fn membrane_height(camber: f64, forward: f64, x: f64) -> f64 {
    ChordBend { heights: [camber, forward], angle: 0.0, hinge: 1.0 }.at(x)[1]
}

impl Aero {
    /// How the chord lines at the arcs `arcs` (m) are bent where its strips are as `bent` says, the numbers of
    /// [`bent_states`](Self::bent_states); none where they are straight. Between strips, and ribs, which hold a membrane, heights and
    /// angles go linearly.
    pub fn chord_bends(&self, bent: &[f64], arcs: &[f64]) -> Vec<ChordBend> {
        let n = self.strips();
        let along = |values: Vec<(f64, f64)>| -> Vec<f64> {
            let mut knots = values;
            // From the right tip on, as the interpolation asks.
            wingbeat_math::order::ascend_by(&mut knots, |item| item.0);
            let (at, of): (Vec<f64>, Vec<f64>) = knots.into_iter().unzip();
            arcs.iter().map(|arc| piecewise_linear(&at, &of, *arc)).collect()
        };
        let strips =
            |values: &[f64]| self.strip_arcs().iter().copied().zip(values.to_vec()).collect::<Vec<_>>();
        if let Some(flap) = self.flap().and_then(|model| model.settings().flap) {
            let hinge = 1.0 - flap.chord_fraction;
            let of = |angle| ChordBend { heights: [0.0; 2], angle, hinge };
            return along(strips(&bent[..n])).into_iter().map(of).collect();
        }
        let Some(membrane) = self.membrane() else { return Vec::new() };
        let held = membrane.membrane_ribs().iter().map(|arc| (*arc, 0.0));
        let [camber, forward] =
            [0, 1].map(|m| along(strips(&bent[m * n..][..n]).into_iter().chain(held.clone()).collect()));
        let of = |(camber, forward)| ChordBend { heights: [camber, forward], angle: 0.0, hinge: 1.0 };
        camber.into_iter().zip(forward).map(of).collect()
    }
}

/// Unit vector up across the chord of the section number `k` of `sections` (leading and trailing edge), times the chord, m. A pointed tip
/// has no chord, and nothing rises over it.
fn up(sections: &[[Vec3; 2]], k: usize) -> Vec3 {
    let beside = [sections[k.saturating_sub(1)], sections[(k + 1).min(sections.len() - 1)]];
    let across = beside[1][0] + beside[1][1] - beside[0][0] - beside[0][1];
    let chord = sections[k][1] - sections[k][0];
    let normal = chord.cross(across);
    if normal.norm() > 0.0 { normal.unit() * chord.norm() } else { Vec3::ZERO }
}

/// The point of a bent section at the share `x` of its chord from the leading edge `le`, m.
fn raised(le: Vec3, [chord, up]: [Vec3; 2], bend: &ChordBend, x: f64) -> Vec3 {
    let [along, above] = bend.at(x);
    le + chord * along + up * above
}

/// Points above the sections `sections` at the arcs `arcs`, leading and trailing edge from the left tip to the right, of the membrane of
/// `aero` at the places [`MEMBRANE_DRAWN`]; `heights` are [`Loads::camber`](crate::Loads::camber) and
/// [`Loads::camber_forward`](crate::Loads::camber_forward) of its strips. Between strips and ribs, which hold it, heights go linearly.
pub fn membrane_points(
    sections: &[[Vec3; 2]],
    arcs: &[f64],
    aero: &Aero,
    heights: [&[f64]; 2],
) -> Vec<[Vec3; 3]> {
    let bends = aero.chord_bends(&heights.concat(), arcs);
    let points = |(k, ([le, te], bend)): (usize, (&[Vec3; 2], &ChordBend))| {
        let (chord, up) = (*te - *le, up(sections, k));
        MEMBRANE_DRAWN.map(|x| raised(*le, [chord, up], bend, x))
    };
    sections.iter().zip(&bends).enumerate().map(points).collect()
}

/// Which of the points of [`flap_points`] is the hinge, that of a flap of that share of the chord.
fn drawn_hinge(chord_fraction: f64) -> usize {
    if chord_fraction > 0.5 { 0 } else { 2 }
}

/// The same of the flap of `aero`; none without one.
pub fn flap_hinge(aero: &Aero) -> Option<usize> {
    Some(drawn_hinge(aero.flap()?.settings().flap?.chord_fraction))
}

/// Turns the trailing edges of the sections `sections` (leading and trailing edge, m) at the arcs `arcs` (m) by the flap of `aero`, `angles` (rad)
/// those of its strips, from the left tip to the right; returns the points of each section at the places
/// [`MEMBRANE_DRAWN`](crate::MEMBRANE_DRAWN), m, with the hinge in place of that one of the outer two on whose side of mid chord it lies.
/// Between strips angles go linearly.
pub fn flap_points(sections: &mut [[Vec3; 2]], arcs: &[f64], aero: &Aero, angles: &[f64]) -> Vec<[Vec3; 3]> {
    let Some(flap) = aero.flap().and_then(|model| model.settings().flap) else { return Vec::new() };
    let (flat, bends) = (sections.to_vec(), aero.chord_bends(angles, arcs));
    let mut places = MEMBRANE_DRAWN;
    places[drawn_hinge(flap.chord_fraction)] = 1.0 - flap.chord_fraction;
    let points = |(k, ([le, te], bend)): (usize, (&mut [Vec3; 2], &ChordBend))| {
        let (front, chord, up) = (*le, *te - *le, up(&flat, k));
        *te = raised(front, [chord, up], bend, 1.0);
        places.map(|x| raised(front, [chord, up], bend, x))
    };
    sections.iter_mut().zip(&bends).enumerate().map(points).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bent_chord_is_its_two_shapes_and_turns_about_its_hinge() {
        let sail = ChordBend { heights: [0.03, 0.02], angle: 0.0, hinge: 1.0 };
        for k in 0..=20 {
            let x = f64::from(k) / 20.0;
            let [along, up] = sail.at(x);
            let t = (1.0 - 2.0 * x).acos();
            assert!((up - t.sin().powi(2) * (0.03 + 0.02 * t.cos())).abs() < 1e-15);
            assert!(along == x && up == membrane_height(0.03, 0.02, x));
        }
        let flap = ChordBend { heights: [0.0; 2], angle: 0.4, hinge: 0.7 };
        let [along, up] = flap.at(1.0);
        assert!(
            ((along - 0.7).hypot(up) - 0.3).abs() < 1e-15 && ((-up).atan2(along - 0.7) - 0.4).abs() < 1e-14
        );
        assert_eq!(flap.at(0.5), [0.5, 0.0]);
    }
}
