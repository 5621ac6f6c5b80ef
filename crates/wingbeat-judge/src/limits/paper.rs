//! Limits of the sheet of `wingbeat paper`.

use super::Limit;
use crate::status::Status::Failed;

/// A sheet without one of its figures is not what was asked for.
pub const MISSING: Limit = Limit::at_most("paper.missing_figures", 0.0, "", Failed)
    .on("figures of the sheet that could not be drawn");

/// All of them.
pub const ALL: [Limit; 1] = [MISSING];
