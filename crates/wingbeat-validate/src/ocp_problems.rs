//! Optimal-control and nonlinear problems with known optima.

use crate::Case;

/// The comparisons.
pub const CASES: &[Case] = &[];
