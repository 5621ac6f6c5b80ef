//! What a run says of the fit that its numbers are from.

use super::spec::ScenarioSpec;
use wingbeat_judge::Warning;
use wingbeat_robot::GivenNumbers;

/// The warning of a run that uses `numbers`, which stand under `key`, of a fit that was not found good.
pub(super) fn rejected_fit(key: &'static str, numbers: &GivenNumbers) -> Option<Warning> {
    let verdict = numbers.verdict.as_ref().filter(|verdict| !verdict.is_ok())?;
    let reason = if verdict.reason.is_empty() { String::new() } else { format!(" ({})", verdict.reason) };
    let text =
        format!("the numbers of {key} are from a calibration whose verdict is {}{reason}", verdict.status);
    Some(Warning::new("fit.rejected", text).key(key))
}

/// The same of the robot that a scenario's controller knows.
pub(super) fn of_known(spec: &ScenarioSpec) -> Option<Warning> {
    rejected_fit("robot.numbers", &spec.robot.numbers)
}

/// The same of that robot and of the one that flies.
pub(super) fn of_flown(spec: &ScenarioSpec) -> impl Iterator<Item = Warning> {
    let own = spec.mismatch.as_ref().and_then(|mismatch| mismatch.numbers.as_ref());
    of_known(spec).into_iter().chain(own.and_then(|numbers| rejected_fit("mismatch.numbers", numbers)))
}
