//! What bears along the span of strips, as it was resolved: what is kept of a run says it, and so flies the same whatever the defaults become.

use super::Scenario;
use super::document::tree::steps;
use super::spec::FullAeroSpec;
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

impl Scenario {
    /// Puts what the models of the robot that flies and of the one that its controller knows have into a `resolved` document, in which this
    /// scenario stands at `at`.
    pub(super) fn resolve_span_keys(&self, resolved: &mut toml::Table, at: &str) {
        resolve(resolved, &format!("{at}aero"), aeros(&self.model));
        if self.spec.mismatch.as_ref().is_some_and(|mismatch| mismatch.aero.is_some()) {
            resolve(resolved, &format!("{at}mismatch.aero"), aeros(&self.robot));
        }
    }
}

impl FullAeroSpec {
    /// Gives both keys as the `models` have them, where they are not given.
    pub(super) fn resolve<'a>(&mut self, models: impl IntoIterator<Item = &'a Aero>) {
        if let Some([edges, turns]) = chosen(models) {
            self.edge_suction.get_or_insert(edges);
            self.turning_impulse.get_or_insert(turns);
        }
    }
}
