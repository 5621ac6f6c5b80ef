//! Class 3: status, ranges, cautions.

use super::Case;

/// The cases.
pub fn cases() -> Vec<Case> {
    Vec::new()
}
