//! Limits of kind `rig`.

use super::Limit;

/// All of them.
pub const ALL: [Limit; 0] = [];
