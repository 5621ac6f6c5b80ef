//! Class 2: sizes without bounds, broken pipes, signals.

use super::Case;

/// The cases.
pub fn cases() -> Vec<Case> {
    Vec::new()
}
