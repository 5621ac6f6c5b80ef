//! The nodes of the lifting line: places, weights and constants.

use super::LiftingLineSettings;
use crate::strip::{AngleMap, spacing};
use crate::{Planform, SurfaceNumbers};
use std::f64::consts::PI;
use wingbeat_math::Error;
use wingbeat_math::Scalar;
use wingbeat_math::linear::{lu_factor, lu_solve};

/// Constants of one node.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineNode<P> {
    /// 1 / chord of the planform, 1/m; all else holds the floored chord.
    pub inverse_edge: P,
    pub half_chord: P,
    pub inverse_chord: P,
    /// Circulation per wash, a0 c / 2, m.
    pub circulation: P,
    /// Rates of the lags per airspeed, 1/m.
    pub lag_rates: [P; 2],
    /// rho a0 (c/2) dy: lift per wash and airspeed, kg/m.
    pub lift: P,
    /// Added mass, kg.
    pub mass: P,
    /// rho c dy / 2, kg/m.
    pub drag: P,
    /// Slope of the line of the quarter chords along the arc, and cosine of its angle.
    pub sweep: P,
    pub sweep_cosine: P,
}

/// What a node stands for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<P = f64> {
    /// Chord at the node, m.
    pub edge: P,
    /// Mean chord, m.
    pub chord: P,
    /// Quadrature weight of the lift, m.
    pub width: P,
    /// Integrals of the chord, m2, and of its square, m3.
    pub area: P,
    pub square: P,
    /// Slope of the line of the quarter chords along the arc: forward as the arc goes to the left.
    pub sweep: P,
}

impl<P: Scalar> Cell<P> {
    /// Of a smooth `chord` (m) with its `sweep` (a slope) at the `angle` (rad) that stands for the span, by quadrature: the
    /// lift vanishes at the tips, area and square do not.
    pub fn smooth(
        [chord, sweep]: [P; 2],
        width: P,
        half_span: P,
        angle: f64,
        set: &LiftingLineSettings,
    ) -> Self {
        let (edge, chord) = (chord, floored(chord, set));
        let area_width = half_span * fejer_weight(angle, set.nodes);
        Self { edge, chord, width, area: chord * area_width, square: chord * chord * area_width, sweep }
    }
}

impl<P: Scalar> LineNode<P> {
    /// The node of a cell.
    pub fn new(cell: &Cell<P>, numbers: &SurfaceNumbers<P>) -> Self {
        let half_chord = cell.chord * 0.5;
        Self {
            inverse_edge: cell.edge.recip(),
            half_chord,
            inverse_chord: cell.chord.recip(),
            circulation: numbers.section_slope * half_chord,
            lag_rates: std::array::from_fn(|k| numbers.lags[k].rate / half_chord),
            lift: numbers.density * numbers.section_slope * half_chord * cell.width,
            mass: numbers.density * PI * 0.25 * cell.square * numbers.added_mass_scale,
            drag: numbers.density * 0.5 * cell.area,
            sweep: cell.sweep,
            sweep_cosine: (cell.sweep * cell.sweep + P::ONE).sqrt().recip(),
        }
    }
}

/// A chord, or the smallest one.
pub(super) fn floored<P: Scalar>(chord: P, set: &LiftingLineSettings) -> P {
    if chord.value() < set.chord_floor_m { P::from(set.chord_floor_m) } else { chord }
}

/// Arcs of the nodes, m, their cells and their angles.
pub(super) type Cells<P> = (Vec<P>, Vec<Cell<P>>, Vec<P>);

/// Nodes between hinges, from left tip to right tip: arcs, m, cells and angles cos^-1(arc / half span). Each cell
/// lies on one side of every hinge, holds the means of its chord, and weighs the lift by sin(angle) times its
/// part of the angle; the outermost cells reach to the tips.
///
/// Equation: aero.lifting_line.cells
/// `means of c and c^2 over cells that end at hinges; weights sin(theta) dtheta; D = A B^-1, B_jn = sin(n theta_j)`
/// Source: midpoint rule; Glauert 1926.
/// Test: `nodes_between_hinges_know_every_sine_and_the_whole_wing`.
pub(super) fn cells<P: Scalar>(
    planform: &Planform<P>,
    hinge_arcs: &[P],
    set: &LiftingLineSettings,
) -> Result<Cells<P>, Error> {
    let named = |e: Error| e.renamed(&[("strips", "nodes")]);
    let laid = spacing(planform, set.nodes, hinge_arcs, AngleMap::Straight).map_err(named)?;
    let (edges, fraction) = (laid.edges, laid.fractions);
    let (half, last) = (planform.half_span(), set.nodes - 1);
    let angle = |arc: P| (arc / half).clamped(-1.0, 1.0).acos();
    let (mut arcs, mut cells, mut angles) = (Vec::new(), Vec::new(), Vec::new());
    for (i, ends) in edges.windows(2).enumerate() {
        // Edges ascend from the right tip, where the arc coordinate is negative.
        let (inner, outer) = (-ends[0], -ends[1]);
        let arc = inner + fraction[i] * (outer - inner);
        let chord = planform.chord_integrals(outer, inner)[0] / (inner - outer);
        let to = if i == 0 { half } else { inner };
        let from = if i == last { -half } else { outer };
        let [area, square] = planform.chord_integrals(from, to);
        let width = half * angle(arc).sin() * (angle(outer) - angle(inner));
        let (edge, chord) = (planform.chord(arc), floored(chord, set));
        cells.push(Cell { edge, chord, width, area, square, sweep: planform.sweep(arc) });
        arcs.push(arc);
        angles.push(angle(arc));
    }
    Ok((arcs, cells, angles))
}

/// theta_i = i pi/(m+1), left tip (0) to right tip (pi).
pub(super) fn node_angles(m: usize) -> Vec<f64> {
    (1..=m).map(|i| i as f64 * PI / (m + 1) as f64).collect()
}

/// Fejer's second rule on cos(theta_i) over [-1, 1] (Fejer 1933): for
/// quantities that do not vanish at the tips, exact for polynomials.
fn fejer_weight(angle: f64, m: usize) -> f64 {
    let sum: f64 = (1..=m.div_ceil(2)).map(|k| (2 * k - 1) as f64).map(|n| (n * angle).sin() / n).sum();
    4.0 * angle.sin() / (m + 1) as f64 * sum
}

/// D_ij = 1/(2 span) sum_n n 2/(m+1) sin(n theta_j) sin(n theta_i) / sin(theta_i)
/// (Glauert 1926; Multhopp 1938). Entries that cancel exactly are set to zero.
pub(super) fn influence<P: Scalar>(angles: &[f64], span: P) -> Vec<P> {
    let m = angles.len();
    let mut d = vec![P::ZERO; m * m];
    for i in 0..m {
        for j in (0..m).filter(|j| i == *j || (i + j) % 2 == 1) {
            let sum: f64 =
                (1..=m).map(|n| n as f64).map(|n| n * (n * angles[j]).sin() * (n * angles[i]).sin()).sum();
            d[i * m + j] = P::from(sum) / (span * (m + 1) as f64 * angles[i].sin());
        }
    }
    d
}

/// The same for nodes at any angles: D = A B^-1, B_jn = sin(n theta_j), A_in = n sin(n theta_i) / (2 span
/// sin(theta_i)), by its transpose. With hinges the angles are near the even ones, for which this is well conditioned.
pub(super) fn influence_between<P: Scalar>(angles: &[P], span: P) -> Vec<P> {
    let m = angles.len();
    let sine = |n: usize, t: P| (t * (n + 1) as f64).sin();
    let (mut b, mut a) = (vec![P::ZERO; m * m], vec![P::ZERO; m * m]);
    for n in 0..m {
        for (i, &t) in angles.iter().enumerate() {
            b[n * m + i] = sine(n, t);
            a[n * m + i] = sine(n, t) * (n + 1) as f64 / (span * 2.0 * t.sin());
        }
    }
    let mut pivots = vec![0; m];
    // Sines of different angles are independent.
    lu_factor(&mut b, m, &mut pivots);
    lu_solve(&b, m, &pivots, &mut a, m);
    (0..m * m).map(|k| a[k % m * m + k / m]).collect()
}
