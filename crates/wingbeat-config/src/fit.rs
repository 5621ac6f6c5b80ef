//! What a run says of the numbers that it is given by name: the fit that they are from, another model than it had, and overrides that they make vain.

use super::rig_spec::RigRunSpec;
use super::spec::ScenarioSpec;
use super::{AeroSpec, Document};
use wingbeat_aero::PlanformStation;
use wingbeat_judge::Warning;
use wingbeat_math::NamedNumber;
use wingbeat_rig::RigNumbers;
use wingbeat_robot::{FittedModel, GivenNumbers, RobotSpec, counts_on_rig_alone, stands_for};

/// Numbers by name, which stand under a key.
pub(super) struct ByName<'a> {
    /// The key.
    pub key: &'static str,
    /// Whose numbers they are, where that is not all that the run has.
    pub of: &'static str,
    /// Names and values.
    pub given: &'a GivenNumbers,
    /// Tables whose overrides may say the same numbers.
    pub tables: &'static [&'static str],
}

impl ByName<'_> {
    /// The warnings that overrides of the merged `document` say a number that is given by name too, and have no effect. `numbers` tells what
    /// the numbers of a document are where none is given by name.
    pub fn given_twice(
        &self,
        document: &Document,
        numbers: impl Fn(&Document) -> Option<Vec<NamedNumber>>,
    ) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if self.given.is_empty() {
            return warnings;
        }
        let Some(with) = numbers(document) else { return warnings };
        for (at, text, others) in document.without_each_override().filter(|(at, ..)| self.may_say(at)) {
            let Some(without) = numbers(&others) else { continue };
            let same = |number: &NamedNumber| {
                without.iter().any(|o| o.name == number.name && o.value.to_bits() == number.value.to_bits())
            };
            let said: Vec<&NamedNumber> = with.iter().filter(|number| !same(number)).collect();
            for (name, value) in self.given.iter() {
                if said.iter().any(|number| stands_for(name, &number.name).is_some()) {
                    let place = document.written(&format!("{}.\"{name}\"", self.key));
                    let place = place.map_or(String::new(), |(_, place)| format!(" ({place})"));
                    let text = format!(
                        "{} gives {name} = {value}{place}, which takes the place of what --set {text} says{}: leave one of them out",
                        self.key, self.of
                    );
                    warnings.push(Warning::new("numbers.given_twice", text).size(*value).key(&at));
                }
            }
        }
        warnings
    }

    /// Whether an override of `key` may say one of the numbers.
    fn may_say(&self, key: &str) -> bool {
        let table = key.split(['.', '[']).next().unwrap_or_default();
        self.tables.contains(&table) && key != table && !key.starts_with(self.key)
    }
}

/// The warnings of a run in the `model` that uses `numbers`, which stand under `key`: that their fit was not found good, and that they are
/// of another model.
pub(super) fn of_numbers(
    key: &'static str,
    numbers: &GivenNumbers,
    model: &FittedModel,
) -> impl Iterator<Item = Warning> + use<> {
    rejected_fit(key, numbers).into_iter().chain(other_model(key, numbers, model))
}

/// The warning that `numbers`, which stand under `key`, were fitted with another model than `model`.
fn other_model(key: &'static str, numbers: &GivenNumbers, model: &FittedModel) -> Option<Warning> {
    let apart = numbers.model.as_ref()?.apart(model);
    let text = format!(
        "what stands under {key} was fitted with another model ({}): its numbers make up for what that one lacks, and may not hold here",
        apart.join("; ")
    );
    (!apart.is_empty()).then(|| Warning::new("fit.other_model", text).key(key))
}

/// Name of the surface whose numbers a wing alone has.
const WING: &str = "wing";

/// The model of `robot` in the air of `aero`.
pub(super) fn model_of(robot: &RobotSpec, aero: &AeroSpec) -> FittedModel {
    let surface = robot.surfaces.iter().find(|surface| surface.name == WING).map(|of| of.planform.as_slice());
    let wing = robot.wing.as_ref().map(|wing| wing.planform.as_slice());
    FittedModel { robot: robot.name.clone(), ..model_of_wing(wing.or(surface).unwrap_or_default(), aero) }
}

/// The model of a wing of this planform, which has no name, in the air of `aero`.
pub(super) fn model_of_wing(planform: &[PlanformStation], aero: &AeroSpec) -> FittedModel {
    FittedModel {
        robot: String::new(),
        preset: aero.preset.name().into(),
        law: aero.law.name().into(),
        half_span_m: planform.last().map(|tip| tip.arc_m),
    }
}

/// The warning of a run that uses `numbers`, which stand under `key`, of a fit that was not found good.
fn rejected_fit(key: &'static str, numbers: &GivenNumbers) -> Option<Warning> {
    let verdict = numbers.verdict.as_ref().filter(|verdict| !verdict.is_ok())?;
    let reason = if verdict.reason.is_empty() { String::new() } else { format!(" ({})", verdict.reason) };
    let text =
        format!("the numbers of {key} are from a calibration whose verdict is {}{reason}", verdict.status);
    Some(Warning::new("fit.rejected", text).key(key))
}

/// The warning of a flight that `numbers`, which stand under `key`, hold some that count on the rig alone.
fn of_rig(key: &'static str, numbers: &GivenNumbers) -> Option<Warning> {
    let names: Vec<&str> =
        numbers.keys().map(String::as_str).filter(|name| counts_on_rig_alone(name)).collect();
    let text = format!("{key} holds numbers of the rig, which no flight takes: {}", names.join(", "));
    (!names.is_empty()).then(|| Warning::new("fit.rig_alone", text).size(names.len() as f64).key(key))
}

/// The same of the robot that a scenario's controller knows, in flight.
pub(super) fn of_known(spec: &ScenarioSpec) -> impl Iterator<Item = Warning> {
    let (key, numbers) = ("robot.numbers", &spec.robot.numbers);
    of_numbers(key, numbers, &model_of(&spec.robot, &spec.aero)).chain(of_rig(key, numbers))
}

/// The same of that robot and of the one that flies.
pub(super) fn of_flown(spec: &ScenarioSpec) -> impl Iterator<Item = Warning> {
    let own = spec.mismatch.as_ref().and_then(|mismatch| mismatch.numbers.as_ref());
    let model = model_of(&spec.robot, spec.flown_aero());
    let of_own = own.map(|numbers| {
        let key = "mismatch.numbers";
        of_numbers(key, numbers, &model).chain(of_rig(key, numbers))
    });
    of_known(spec).chain(of_own.into_iter().flatten())
}

/// The warnings that overrides of the merged `document` of a scenario, `spec`, say numbers of its robot that `robot.numbers` gives too, or
/// `mismatch.numbers` those of the robot that flies.
pub(super) fn given_twice(document: &Document, spec: &ScenarioSpec) -> Vec<Warning> {
    let of = if spec.mismatch.is_some() { " of the robot that the controller knows" } else { "" };
    let tables = &["robot", "aero", "air"];
    let by_name = ByName { key: "robot.numbers", of, given: &spec.robot.numbers, tables };
    let mut warnings = by_name.given_twice(document, |document| {
        let mut spec: ScenarioSpec = document.parse().ok()?;
        spec.robot.numbers = GivenNumbers::default();
        Some(spec.known_robot().ok()?.parameters())
    });
    let Some(given) = spec.mismatch.as_ref().and_then(|mismatch| mismatch.numbers.as_ref()) else {
        return warnings;
    };
    let tables = &["robot", "aero", "air", "mismatch"];
    let by_name = ByName { key: "mismatch.numbers", of: " of the robot that flies", given, tables };
    warnings.extend(by_name.given_twice(document, |document| {
        let mut spec: ScenarioSpec = document.parse().ok()?;
        spec.robot.numbers = GivenNumbers::default();
        // Its factors act on the numbers that are given by name.
        spec.aero = spec.flown_aero().clone();
        spec.mismatch = None;
        Some(spec.known_robot().ok()?.parameters())
    }));
    warnings
}

/// The warnings that overrides of the merged `document` of a run on the rig, `spec`, say numbers of robot and rig that `rig.robot.numbers`
/// gives too.
pub(super) fn given_twice_on_rig(document: &Document, spec: &RigRunSpec) -> Vec<Warning> {
    let tables = &["rig"];
    let by_name = ByName { key: "rig.robot.numbers", of: "", given: &spec.rig.robot.numbers, tables };
    by_name.given_twice(document, |document| {
        let mut spec: RigRunSpec = document.parse().ok()?;
        spec.rig.robot.numbers = GivenNumbers::default();
        let mut numbers = spec.robot().ok()?.parameters();
        numbers.extend(RigNumbers::of(&spec.rig.mount.drawn()).parameters());
        Some(numbers)
    })
}
