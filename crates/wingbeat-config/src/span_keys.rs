//! What bears along the span of strips, as it was resolved: what is kept of a run says it, and so flies the same whatever the defaults become.

use super::document::tree::steps;
use super::spec::FullAeroSpec;
use super::{Scenario, ScenarioSpec, written};
use wingbeat_aero::Aero;
use wingbeat_robot::Robot;

/// The keys, in the order of [`wingbeat_aero::StripModel::span_keys`].
pub const SPAN_KEYS: [&str; 2] = ["edge_suction", "turning_impulse"];

/// The models of a robot's surfaces.
pub(super) fn aeros(robot: &Robot) -> impl Iterator<Item = &Aero> {
    robot.surfaces().map(|(_, aero)| aero)
}

/// Which of the two any of the `models` has; none where none of them is of strips. Suction of edges leaves the other key open: it says that
/// the impulse does not turn on flat surfaces, and a membrane or flap that is given later has it by default.
fn chosen<'a>(models: impl IntoIterator<Item = &'a Aero>) -> Option<[Option<bool>; 2]> {
    let of = |model: &'a Aero| match model {
        Aero::Strip(strips) => Some(strips.span_keys()),
        Aero::LiftingLine(_) => None,
    };
    let all = models.into_iter().filter_map(of).reduce(|all, one| [all[0] || one[0], all[1] || one[1]]);
    all.map(|[edges, turns]| [Some(edges), Some(turns).filter(|turns| *turns || !edges)])
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
    for (key, value) in SPAN_KEYS.into_iter().zip(chosen) {
        if let Some(value) = value {
            table.entry(key).or_insert(toml::Value::Boolean(value));
        }
    }
}

/// Whether one of the `settings`, overrides or keys of draws, changes what the keys of the table at `aero` are resolved of: written keys would
/// stand against it. One that gives the whole table anew takes them away.
pub(super) fn varied<'a>(settings: impl IntoIterator<Item = &'a str>, aero: &str) -> bool {
    let keys = SPAN_KEYS.map(|key| format!("{aero}.full.{key}"));
    let keys: Vec<_> = keys.into_iter().chain([format!("{aero}.preset")]).map(|key| steps(&key)).collect();
    settings.into_iter().any(|text| {
        let key = text.split_once('=').map_or(text, |(key, _)| key);
        keys.contains(&steps(key.trim_start_matches('-')))
    })
}

impl Scenario {
    /// Puts what the models of the robot that flies and of the one that its controller knows have into a `resolved` document, in which this
    /// scenario stands at `at`; nothing where the airs of its search or the `settings` of the document vary them.
    pub(super) fn resolve_span_keys(&self, resolved: &mut toml::Table, at: &str, settings: &[&str]) {
        let search = self.spec.trim.as_ref().and_then(|trim| trim.search.as_ref());
        let airs = search.into_iter().flat_map(|search| search.airs.iter().flatten().map(String::as_str));
        let settings: Vec<&str> = airs.chain(settings.iter().copied()).collect();
        let mut put = |aero: &str, robot: &Robot| {
            if !varied(settings.iter().copied(), aero) {
                resolve(resolved, &format!("{at}{aero}"), aeros(robot));
            }
        };
        put("aero", &self.model);
        if self.spec.mismatch.as_ref().is_some_and(|mismatch| mismatch.aero.is_some()) {
            put("mismatch.aero", &self.robot);
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
            self.edge_suction = self.edge_suction.or(edges);
            self.turning_impulse = self.turning_impulse.or(turns);
        }
    }
}
