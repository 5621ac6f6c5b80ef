//! Linkage and multibody dynamics.

use crate::Case;

/// The comparisons.
pub const CASES: &[Case] = &[];
