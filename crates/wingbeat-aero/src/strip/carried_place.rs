//! Where along its chord a strip carries air.

use super::cores::Flat;
use super::grid::StripGrid;
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use wingbeat_math::{Scalar, Vec3};

/// Vortices, in chords behind the leading edge: the two nodes of Gauss and Chebyshev.
const NODES: [f64; 2] = [0.5 - 0.5 * FRAC_1_SQRT_2, 0.5 + 0.5 * FRAC_1_SQRT_2];
/// Those of the ring that the wash of a doublet is taken of.
const RING: [f64; 2] = [0.25, 1.0];
/// Where flow is tangent, in chords behind the leading edge.
const CONTROL: f64 = 0.75;

/// How far behind mid chord the wash drives the carried air of each strip, and its force acts, m.
///
/// The doublet pi b^2 w of a chord stands as a ring from 1/4 chord to the trailing edge, as in steady flow its circulation does. What
/// pitching adds, pi b^2 (w12 - w34), leaves no circulation: its vorticity over 1/sqrt(b^2 - x^2) is a square in x, and the sum over
/// two nodes keeps its first moment, which is the doublet, and its want of circulation. Its wash beside that of the ring is, with w12 -
/// w34 = -q b/2, what the wash at a place h behind mid chord has beside w12. K and K' are taken on the flat wing, less the wash of straight
/// lines as long as they are, which two-dimensional theory has.
///
/// On rectangles h is nothing but beside the tips; on a panel that tapers with one edge swept it lies ahead by up to .1 chords.
///
/// Equation: aero.strip.carried_place
/// `h = -(beta/2) sum(K' d' b - K d b), d' = pi b cos(sweep)/sqrt 2, K' of rings between the chord fractions 1/2 -+ 1/(2 sqrt 2)`
/// Source: Gauss & Chebyshev's sum over the vorticity of thin-aerofoil theory (Glauert 1926); own derivation.
/// Test: `the_carried_air_lies_at_mid_chord_of_long_rectangles_and_ahead_on_tapers`.
pub(super) fn carried_places<P: Scalar>(grid: &StripGrid<P>, beta: f64) -> Vec<P> {
    let flat = Flat::plain(grid);
    let cosine = |i: usize, x: f64| {
        let run = flat.edge(i + 1, x)[0] - flat.edge(i, x)[0];
        grid.width[i] / grid.width[i].hypot(run)
    };
    let own = |i: usize, ends: [f64; 2], cosines: [P; 2]| {
        let of = |k: usize| (cosines[k] * grid.between[i] * (2.0 * PI * (CONTROL - ends[k]).abs())).recip();
        of(0) + of(1)
    };
    let place = |i: usize| {
        let at = flat.target(i, CONTROL);
        (0..grid.chord.len()).filter(|j| grid.covered[*j]).fold(P::ZERO, |sum, j| {
            let [mut nodes, mut ring] = [NODES, RING].map(|ends| ring_wash(&flat, j, ends, at));
            if i == j {
                nodes += own(i, NODES, NODES.map(|x| cosine(i, x)));
                ring += own(i, RING, [grid.cos_half[i], grid.cos_three_quarter[i]]);
            }
            // Both doublets over pi b cos(sweep).
            let doublets = nodes * FRAC_1_SQRT_2 - ring * (1.0 / 1.5);
            let half_chord = grid.between[j] * 0.5;
            sum - doublets * (half_chord * half_chord * grid.cos_half[j] * (0.5 * PI * beta))
        })
    };
    (0..grid.chord.len()).map(|i| if grid.covered[i] { place(i) } else { P::ZERO }).collect()
}

/// Upwash at `at` of a ring of unit circulation on strip `j` of the flat wing, from the first to the second of the chord fractions `ends`.
fn ring_wash<P: Scalar>(flat: &Flat<'_, P>, j: usize, ends: [f64; 2], at: Vec3<P>) -> P {
    let [[a, d], [b, c]] = [j, j + 1].map(|edge| ends.map(|x| flat.edge(edge, x)));
    [(a, b), (b, c), (c, d), (d, a)].into_iter().fold(P::ZERO, |sum, (from, to)| {
        let (r, s) = (at - from, at - to);
        let (near, far) = (r.norm(), s.norm());
        let both = near * far;
        sum + r.cross(s)[2] * (near + far) / (both * (both + r.dot(s)) * (4.0 * PI))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Planform, PlanformStation};

    fn places(rows: &[[f64; 3]], strips: usize) -> (StripGrid, Vec<f64>) {
        let station = |&[arc_m, leading_edge_m, trailing_edge_m]: &[f64; 3]| PlanformStation {
            arc_m,
            leading_edge_m,
            trailing_edge_m,
        };
        let planform = Planform::new(&rows.iter().map(station).collect::<Vec<_>>()).unwrap();
        let grid = StripGrid::new(&planform, strips, &[], true).unwrap();
        let over_chord = carried_places(&grid, 1.0).iter().zip(&grid.chord).map(|(h, c)| h / c).collect();
        (grid, over_chord)
    }

    #[test]
    fn the_carried_air_lies_at_mid_chord_of_long_rectangles_and_ahead_on_tapers() {
        let (grid, rectangle) = places(&[[0.0, 0.0, -1.0], [5.0, 0.0, -1.0]], 16);
        assert!(rectangle[4..12].iter().all(|h| h.abs() < 1e-3), "{rectangle:?}");
        assert!(grid.chord.iter().all(|c| (c - 1.0).abs() < 1e-12));
        // A trailing edge that sweeps forward by 60 degrees behind a leading edge that does by 26.
        let (grid, taper) =
            places(&[[0.0, 0.6, -1.0], [0.8, 0.8, -1.1], [1.6, 1.18, 0.18], [2.07, 1.01, 0.81]], 32);
        let on_taper = |i: usize| (0.9..1.5).contains(&grid.control_arcs[i].abs());
        let ahead = (0..32).filter(|i| on_taper(*i)).map(|i| taper[i]);
        assert!(ahead.clone().count() >= 6);
        assert!(ahead.clone().all(|h| (-0.15..-0.01).contains(&h)), "{:?}", ahead.collect::<Vec<_>>());
        for (left, right) in taper.iter().zip(taper.iter().rev()) {
            assert!((left - right).abs() < 1e-12);
        }
    }
}
