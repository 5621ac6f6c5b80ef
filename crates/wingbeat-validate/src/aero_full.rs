//! The strip model of folding wings.

use crate::Case;

/// The comparisons.
pub const CASES: &[Case] = &[];
