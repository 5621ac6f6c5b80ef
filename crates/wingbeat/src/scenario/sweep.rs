//! Many flights of one scenario with keys drawn at random.

use super::document::{ConfigError, Document, Place, Problem, Wrong};
use super::{RunName, Scenario, Summary};
use crate::Error;
use crate::math::Random;
use crate::range::{Range, ranges};
use crate::require;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Most flights of a sweep.
const MAX_RUNS: usize = 1_000_000;
/// Largest seed of the first flight: TOML's whole numbers end beyond the last one's.
const MAX_SEED: u64 = i64::MAX as u64 - MAX_RUNS as u64;

/// A sweep file.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(transform = crate::range::put(Self::RANGES)))]
#[serde(deny_unknown_fields)]
pub struct SweepSpec {
    /// Name; the run folder is called after it.
    pub name: String,
    /// Scenario file, relative to the sweep file; or a table, the scenario itself.
    #[cfg_attr(
        feature = "schema",
        schemars(schema_with = "crate::scenario::schema::file_or::<crate::scenario::ScenarioSpec>")
    )]
    pub scenario: toml::Value,
    /// Number of flights.
    pub runs: usize,
    /// Seed of the draws; flight `i` flies with the seed `seed + i`.
    #[serde(default)]
    pub seed: u64,
    /// Keys of the scenario and the ranges they are drawn from, evenly.
    pub draws: Vec<Draw>,
    /// What counts as held.
    pub hold: Hold,
}

/// One key drawn evenly from [low, high].
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Draw {
    /// Key of the scenario, e.g. `mismatch.mass` or `mismatch.com_m[0]`.
    pub key: String,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Largest errors of a held flight, from the goal's settling time on.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(transform = crate::range::put(Self::RANGES)))]
#[serde(deny_unknown_fields)]
pub struct Hold {
    /// Largest |roll - reference|, deg.
    pub roll_within_deg: f64,
    /// Largest |pitch - reference|, deg.
    pub pitch_within_deg: f64,
}

impl Hold {
    /// True when the whole flight was flown and both errors stayed within.
    pub fn met(&self, summary: &Summary) -> bool {
        summary.completed()
            && summary.roll_max_error_deg.is_some_and(|e| e <= self.roll_within_deg)
            && summary.pitch_max_error_deg.is_some_and(|e| e <= self.pitch_within_deg)
    }
}

/// A checked sweep.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// What the file said.
    pub spec: SweepSpec,
    /// The sweep as TOML, scenario and robot inside; flies the same flights.
    pub resolved: String,
    document: Document,
    scenario: Document,
}

impl Sweep {
    /// Reads and checks a sweep file and its scenario.
    ///
    /// # Errors
    /// One message with file, line, key, the value given and what is allowed.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, ConfigError> {
        Self::new(Document::file(path)?.overridden(overrides))
    }

    /// Checks a sweep from files or memory. Its key `scenario` names a file, or holds the scenario.
    ///
    /// ```no_run
    /// use std::path::Path;
    /// use wingbeat::scenario::{Document, Sweep};
    ///
    /// let text = r#"
    /// name = "gusts"
    /// runs = 20
    /// draws = [{ key = "air.gust_m_s", low = 0.0, high = 0.5 }]
    /// hold = { roll_within_deg = 5.0, pitch_within_deg = 10.0 }
    /// "#;
    /// let scenario = Document::file(Path::new("scenarios/banking_turn.toml"))?;
    /// let sweep = Sweep::new(Document::text("gusts", text)?.put("scenario", scenario)?)?;
    /// assert_eq!(sweep.values(3).len(), 1);
    /// # Ok::<(), wingbeat::scenario::ConfigError>(())
    /// ```
    ///
    /// # Errors
    /// Messages with the place, the key, the value given and what is allowed.
    pub fn new(document: Document) -> Result<Self, ConfigError> {
        // Scenario and robot are read here, once: all flights are of the same, and the sweep holds them.
        let document = document.merged(&["scenario", "scenario.robot"], &|_, _| None)?;
        let spec: SweepSpec = document.parse()?;
        let resolved = document.resolved()?;
        spec.check().map_err(|error| document.explain(&error))?;
        let scenario = document.part("scenario")?;
        let sweep = Self { spec, resolved, document, scenario };
        sweep.check_draws()?;
        Ok(sweep)
    }

    /// The values drawn for flight `run`, in the order of the draws: a stream of
    /// its own for every flight, so that order and interruption do not matter.
    pub fn values(&self, run: usize) -> Vec<f64> {
        let mut random = Random::stream(self.spec.seed, run as u64);
        let draw = |d: &Draw| random.between(d.low, d.high);
        self.spec.draws.iter().map(draw).collect()
    }

    /// The scenario of flight `run`.
    ///
    /// # Errors
    /// A drawn key that the scenario does not know, or refuses.
    pub fn scenario(&self, run: usize) -> Result<Scenario, ConfigError> {
        let draws = self.spec.draws.iter().zip(self.values(run));
        let document = draws.fold(self.scenario.clone(), |document, (d, v)| document.set(drawn(d, v)));
        let seed = self.spec.seed + run as u64;
        Scenario::new(document.set(format!("seed={seed}")))
    }

    /// Flies flight `run` of the scenario with both ends of every draw, one at a time.
    fn check_draws(&self) -> Result<(), ConfigError> {
        Scenario::new(self.scenario.clone())?;
        for (i, draw) in self.spec.draws.iter().enumerate() {
            for (end, value) in [("low", draw.low), ("high", draw.high)] {
                let given = drawn(draw, value);
                let built = Scenario::new(self.scenario.clone().set(given.as_str()));
                built.map_err(|error| self.blamed(error, &given, &format!("draws[{i}]"), end))?;
            }
        }
        Ok(())
    }

    /// An error about the drawn value `given` as one about the end of the draw, or about its key.
    fn blamed(&self, error: ConfigError, given: &str, draw: &str, end: &str) -> ConfigError {
        let here = Place::Override(given.into());
        let by_draw = |one: &&Wrong| one.place == here || one.against.iter().any(|o| o.place == here);
        let Some(wrong) = error.all().iter().find(by_draw) else { return error };
        let end = if matches!(wrong.problem, Problem::Value(_)) { end } else { "key" };
        let key = format!("{draw}.{end}");
        let value = self.document.written(&key).map_or(String::new(), |(value, _)| value);
        self.document.explain(&Error::invalid(key, value, format!("what the scenario allows ({error})")))
    }
}

/// The override of one draw.
fn drawn(draw: &Draw, value: f64) -> String {
    format!("{}={value:?}", draw.key)
}

ranges!(SweepSpec { runs: Range::between(1.0, MAX_RUNS as f64) });
ranges!(Hold { roll_within_deg: Range::POSITIVE, pitch_within_deg: Range::POSITIVE });

impl SweepSpec {
    /// The checked name.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key `name`.
    pub fn run_name(&self) -> Result<RunName, Error> {
        RunName::new("name", &self.name)
    }

    fn check(&self) -> Result<(), Error> {
        self.run_name()?;
        self.in_range()?;
        require::at_most("seed", self.seed, MAX_SEED)?;
        self.hold.check().map_err(|e| e.within("hold"))?;
        let mut draws = self.draws.iter().enumerate();
        draws.try_for_each(|(i, draw)| draw.check().map_err(|e| e.within(&format!("draws[{i}]"))))
    }
}

impl Draw {
    fn check(&self) -> Result<(), Error> {
        require::finite("low", &[self.low])?;
        require::finite("high", &[self.high])?;
        require::at_most("low", self.low, self.high).map_err(|e| e.against(["high"]))
    }
}

impl Hold {
    fn check(self) -> Result<(), Error> {
        self.in_range()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep() -> Sweep {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sweeps/banking_turn_robustness.toml");
        Sweep::load(&path, &[]).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn draws_lie_in_their_ranges_and_belong_to_their_flight() {
        let sweep = sweep();
        let later = sweep.values(41);
        for run in 0..50 {
            for (draw, value) in sweep.spec.draws.iter().zip(sweep.values(run)) {
                assert!((draw.low..=draw.high).contains(&value), "{} = {value}", draw.key);
            }
        }
        assert_eq!(sweep.values(41), later);
        assert_ne!(sweep.values(42), later);
    }

    #[test]
    fn the_flown_robot_differs_and_the_known_one_does_not() {
        let sweep = sweep();
        let (a, b) = (sweep.scenario(0).unwrap(), sweep.scenario(1).unwrap());
        assert_eq!(a.model().mass(), b.model().mass());
        assert!(a.robot().mass() != b.robot().mass());
    }
}
