//! Limits of kind `trim`.

use super::Limit;

/// All of them.
pub const ALL: [Limit; 0] = [];
