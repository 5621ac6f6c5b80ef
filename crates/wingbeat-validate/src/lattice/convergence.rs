//! Orders of convergence.

use super::small::{plunging, steady_slope};
use crate::{ComparisonRow, Error};

/// Order of three values at sizes each half the one before.
fn order([a, b, c]: [f64; 3]) -> f64 {
    ((a - b) / (b - c)).abs().log2()
}

/// Orders in the chordwise panels: of steady flow, and of plunge with the step that goes with the panels.
pub fn convergence() -> Result<Vec<ComparisonRow>, Error> {
    let [a, b, c] = [3, 6, 12].map(|chordwise| steady_slope(4.0, chordwise, 24));
    let steady = order([a?, b?, c?]);
    let [a, b, c] = [4, 8, 16].map(|chordwise| plunging(4.0, 0.5, (chordwise, 8), 20.0));
    let (a, b, c) = (a?, b?, c?);
    let far = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1);
    let unsteady = (far(a, b) / far(b, c)).log2();
    let rows = [
        ComparisonRow::order(
            "lattice.convergence.steady",
            "own refinement, 3 to 12 panels",
            steady,
            2.0,
            0.3,
        ),
        ComparisonRow::order(
            "lattice.convergence.plunge",
            "own refinement, 4 to 16 panels and their steps",
            unsteady,
            2.0,
            0.3,
        ),
    ];
    Ok(rows.map(|row| ComparisonRow { metric: row.metric + "; tolerance a choice", ..row }).into())
}
