//! What bears along the span of strips, as it was resolved: what is kept of a run says it, and so flies the same whatever the defaults become.

use super::document::tree::steps;
use super::spec::FullAeroSpec;
use super::{Scenario, ScenarioSpec, written};
use wingbeat_aero::Aero;
use wingbeat_robot::Robot;

/// The keys, in the order of [`wingbeat_aero::StripModel::span_keys`].
const KEYS: [&str; 2] = ["edge_suction", "turning_impulse"];

/// The models of a robot's surfaces.
pub(super) fn aeros(robot: &Robot) -> impl Iterator<Item = &Aero> {
    robot.surfaces().map(|(_, aero)| aero)
}

/// Which of the two any of the `models` has; none where none of them is of strips.
fn chosen<'a>(models: impl IntoIterator<Item = &'a Aero>) -> Option<[bool; 2]> {
    let of = |model: &'a Aero| match model {
        Aero::Strip(strips) => Some(strips.span_keys()),
        Aero::LiftingLine(_) => None,
    };
    models.into_iter().filter_map(of).reduce(|all, one| [all[0] || one[0], all[1] || one[1]])
}

/// Puts what the `models` have into the table of aerodynamics at `aero` of a `resolved` document, where it gives neither.
pub(super) fn resolve<'a>(
    resolved: &mut toml::Table,
    aero: &str,
    models: impl IntoIterator<Item = &'a Aero>,
) {
    let Some(chosen) = chosen(models) else { return };
    let mut table = resolved;
    for step in steps(aero).into_iter().chain(["full".to_owned()]) {
        let inner = table.entry(step).or_insert_with(|| toml::Value::Table(toml::Table::new()));
        let Some(inner) = inner.as_table_mut() else { return };
        table = inner;
    }
    for (key, value) in KEYS.into_iter().zip(chosen) {
        table.entry(key).or_insert(toml::Value::Boolean(value));
    }
}

/// Whether a text within `value`, as an override or the key of a draw, varies what the keys are resolved of: written keys would stand
/// against it.
fn varied(value: &toml::Value) -> bool {
    match value {
        toml::Value::String(text) => KEYS.into_iter().chain(["aero.preset"]).any(|key| text.contains(key)),
        toml::Value::Array(items) => items.iter().any(varied),
        toml::Value::Table(table) => table.values().any(varied),
        _ => false,
    }
}

impl Scenario {
    /// Puts what the models of the robot that flies and of the one that its controller knows have into a `resolved` document, in which this
    /// scenario stands at `at`; nothing where the document varies them.
    pub(super) fn resolve_span_keys(&self, resolved: &mut toml::Table, at: &str) {
        if resolved.values().any(varied) {
            return;
        }
        resolve(resolved, &format!("{at}aero"), aeros(&self.model));
        if self.spec.mismatch.as_ref().is_some_and(|mismatch| mismatch.aero.is_some()) {
            resolve(resolved, &format!("{at}mismatch.aero"), aeros(&self.robot));
        }
    }
}

impl Scenario {
    /// The text of `spec`, of the models of this scenario, with both keys as these have them.
    ///
    /// # Errors
    /// What TOML cannot hold.
    pub(super) fn written(&self, mut spec: ScenarioSpec) -> Result<String, toml::ser::Error> {
        spec.aero.full.resolve(aeros(&self.model));
        if let Some(aero) = spec.mismatch.as_mut().and_then(|mismatch| mismatch.aero.as_mut()) {
            aero.full.resolve(aeros(&self.robot));
        }
        written::toml(&spec)
    }
}

impl FullAeroSpec {
    /// Gives both keys as `model` has them, whatever is given for it among others.
    pub(super) fn alone(&mut self, model: &Aero) {
        (self.edge_suction, self.turning_impulse) = (None, None);
        self.resolve([model]);
    }

    /// Gives both keys as the `models` have them, where they are not given.
    pub(super) fn resolve<'a>(&mut self, models: impl IntoIterator<Item = &'a Aero>) {
        if let Some([edges, turns]) = chosen(models) {
            self.edge_suction.get_or_insert(edges);
            self.turning_impulse.get_or_insert(turns);
        }
    }
}
