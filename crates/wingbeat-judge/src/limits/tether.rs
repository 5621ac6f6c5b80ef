//! Limits of kind `tether`.

use super::Limit;

/// All of them.
pub const ALL: [Limit; 0] = [];
