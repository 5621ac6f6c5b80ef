//! What a run says of the fit that its numbers are from.

use wingbeat_judge::Warning;
use wingbeat_robot::GivenNumbers;

/// The warning of a run that uses `numbers` of a fit that was not found good.
pub(super) fn rejected_fit(numbers: &GivenNumbers) -> Option<Warning> {
    let verdict = numbers.verdict.as_ref().filter(|verdict| !verdict.is_ok())?;
    let reason = if verdict.reason.is_empty() { String::new() } else { format!(" ({})", verdict.reason) };
    let text = format!("the numbers are from a calibration whose verdict is {}{reason}", verdict.status);
    Some(Warning::new("fit.rejected", text).key("robot.numbers"))
}
