//! Limits of kind `data`.

use super::Limit;

/// All of them.
pub const ALL: [Limit; 0] = [];
