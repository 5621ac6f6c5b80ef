//! The paper's unsteady lifting line.

use crate::Case;

/// The comparisons.
pub const CASES: &[Case] = &[];
