//! Limits of kind `plan`.

use super::Limit;

/// All of them.
pub const ALL: [Limit; 0] = [];
