//! Files of others: damaged, lying, immense; recordings and their accounts; large real files.

use super::Case;

/// The cases.
pub fn cases() -> Vec<Case> {
    Vec::new()
}
