//! Limits of kind `recording`.

use super::Limit;

/// All of them.
pub const ALL: [Limit; 0] = [];
