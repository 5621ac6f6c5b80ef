//! Limits of the sheet of `wingbeat paper`.

use super::JudgedLimit;
use crate::status::Status::Failed;

/// A sheet without one of its figures is not what was asked for.
pub const MISSING: JudgedLimit = JudgedLimit::at_most("paper.missing_figures", 0.0, "", Failed)
    .on("figures of the sheet that could not be drawn");

/// A run that broke down gives no numbers for the statements.
pub const FAILED: JudgedLimit =
    JudgedLimit::at_most("paper.failed_steps", 0.0, "", Failed).on("runs of the sheet with status `failed`");

/// All of them.
pub const ALL: [JudgedLimit; 2] = [MISSING, FAILED];
