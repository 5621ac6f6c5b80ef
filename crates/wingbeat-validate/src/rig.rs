//! Arm, load cell and processing.

use crate::Case;

/// The comparisons.
pub const CASES: &[Case] = &[];
