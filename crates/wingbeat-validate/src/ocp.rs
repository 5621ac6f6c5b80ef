//! Transcription and derivatives of optimal-control problems.

use crate::Case;

/// The comparisons.
pub const CASES: &[Case] = &[];
