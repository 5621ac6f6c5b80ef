//! The nodes of the lifting line: places, weights and constants.

use super::LiftingLineSettings;
use crate::Error;
use crate::aero::strip::spacing;
use crate::aero::{Planform, SurfaceNumbers};
use crate::math::Scalar;
use crate::math::linear::{lu_factor, lu_solve};
use std::f64::consts::PI;

/// Constants of one node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node<P> {
    /// 1 / chord of the planform, 1/m; all else holds the floored chord.
    pub inverse_edge: f64,
    pub half_chord: f64,
    pub inverse_chord: f64,
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
}

/// What a node stands for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Chord at the node, m.
    pub edge: f64,
    /// Mean chord, m.
    pub chord: f64,
    /// Quadrature weight of the lift, m.
    pub width: f64,
    /// Integrals of the chord, m2, and of its square, m3.
    pub area: f64,
    pub square: f64,
}

impl Cell {
    /// Of a smooth `chord` at `angle` by quadrature: the lift vanishes at the tips, area and square do not.
    pub fn smooth(chord: f64, width: f64, half_span: f64, angle: f64, set: &LiftingLineSettings) -> Self {
        let (edge, chord) = (chord, chord.max(set.chord_floor_m));
        let area_width = half_span * fejer_weight(angle, set.nodes);
        Self { edge, chord, width, area: chord * area_width, square: chord * chord * area_width }
    }
}

impl<P: Scalar> Node<P> {
    /// The node of a cell.
    pub fn new(cell: &Cell, numbers: &SurfaceNumbers<P>) -> Self {
        let half_chord = 0.5 * cell.chord;
        Self {
            inverse_edge: 1.0 / cell.edge,
            half_chord,
            inverse_chord: 1.0 / cell.chord,
            circulation: numbers.section_slope * half_chord,
            lag_rates: std::array::from_fn(|k| numbers.lags[k].rate / half_chord),
            lift: numbers.density * numbers.section_slope * half_chord * cell.width,
            mass: numbers.density * PI * 0.25 * cell.square * numbers.added_mass_scale,
            drag: numbers.density * 0.5 * cell.area,
        }
    }
}

/// Arcs of the nodes, m, their cells and their angles.
pub(super) type Cells = (Vec<f64>, Vec<Cell>, Vec<f64>);

/// Nodes between hinges, from left tip to right tip: arcs, m, cells and angles cos^-1(arc / half span). Each cell
/// lies on one side of every hinge, holds the means of its chord, and weighs the lift by sin(angle) times its
/// part of the angle; the outermost cells reach to the tips.
///
/// Equation: aero.lifting_line.cells
pub(super) fn cells(
    planform: &Planform,
    hinge_arcs: &[f64],
    set: &LiftingLineSettings,
) -> Result<Cells, Error> {
    let named = |e: Error| e.renamed(&[("strips", "nodes")]);
    let (edges, fraction) = spacing(planform, set.nodes, hinge_arcs).map_err(named)?;
    let (half, last) = (planform.half_span(), set.nodes - 1);
    let angle = |arc: f64| (arc / half).clamp(-1.0, 1.0).acos();
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
        cells.push(Cell {
            edge: planform.chord(arc),
            chord: chord.max(set.chord_floor_m),
            width,
            area,
            square,
        });
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
pub(super) fn influence(angles: &[f64], span: f64) -> Vec<f64> {
    let m = angles.len();
    let mut d = vec![0.0; m * m];
    for i in 0..m {
        for j in (0..m).filter(|j| i == *j || (i + j) % 2 == 1) {
            let sum: f64 =
                (1..=m).map(|n| n as f64).map(|n| n * (n * angles[j]).sin() * (n * angles[i]).sin()).sum();
            d[i * m + j] = sum / (span * (m + 1) as f64 * angles[i].sin());
        }
    }
    d
}

/// The same for nodes at any angles: D = A B^-1, B_jn = sin(n theta_j), A_in = n sin(n theta_i) / (2 span
/// sin(theta_i)), by its transpose. With hinges the angles are near the even ones, for which this is well conditioned.
pub(super) fn influence_between(angles: &[f64], span: f64) -> Vec<f64> {
    let m = angles.len();
    let sine = |n: usize, t: f64| ((n + 1) as f64 * t).sin();
    let (mut b, mut a) = (vec![0.0; m * m], vec![0.0; m * m]);
    for n in 0..m {
        for (i, &t) in angles.iter().enumerate() {
            b[n * m + i] = sine(n, t);
            a[n * m + i] = (n + 1) as f64 * sine(n, t) / (2.0 * span * t.sin());
        }
    }
    let mut pivots = vec![0; m];
    // Sines of different angles are independent.
    lu_factor(&mut b, m, &mut pivots);
    lu_solve(&b, m, &pivots, &mut a, m);
    (0..m * m).map(|k| a[k % m * m + k / m]).collect()
}
