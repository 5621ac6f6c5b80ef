//! Limits of kind `calibration`.

use super::Limit;

/// All of them.
pub const ALL: [Limit; 0] = [];
