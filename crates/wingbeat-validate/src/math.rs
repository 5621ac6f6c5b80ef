//! Scalars, derivatives and Runge-Kutta tables.

use crate::Case;

/// The comparisons.
pub const CASES: &[Case] = &[];
