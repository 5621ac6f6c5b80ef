//! Many flights of one scenario with keys drawn at random.

use super::document::{ConfigError, Document};
use super::{Scenario, Summary};
use crate::Error;
use crate::math::Random;
use crate::require;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A sweep file.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SweepSpec {
    /// Name; the run folder is called after it.
    pub name: String,
    /// Scenario file, relative to the sweep file.
    pub scenario: PathBuf,
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
    /// The sweep as TOML.
    pub resolved: String,
    scenario: PathBuf,
}

impl Sweep {
    /// Reads and checks a sweep file and its scenario.
    ///
    /// # Errors
    /// One message with file, line, key, the value given and what is allowed.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, ConfigError> {
        let document = Document::load(path, overrides, &[])?;
        let spec: SweepSpec = document.parse()?;
        spec.check().map_err(|error| document.explain(&error))?;
        let scenario = path.parent().unwrap_or(Path::new("")).join(&spec.scenario);
        let sweep = Self { spec, resolved: document.resolved()?, scenario };
        sweep.scenario(0)?;
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
        let mut overrides: Vec<String> = draws.map(|(d, v)| format!("{}={v:?}", d.key)).collect();
        overrides.push(format!("seed={}", self.spec.seed.wrapping_add(run as u64)));
        Scenario::load(&self.scenario, &overrides)
    }
}

impl SweepSpec {
    fn check(&self) -> Result<(), Error> {
        require::name("name", &self.name)?;
        if self.runs == 0 {
            return Err(Error::invalid("runs", 0, "at least 1"));
        }
        for (i, draw) in self.draws.iter().enumerate() {
            if !(draw.low <= draw.high && draw.low.is_finite() && draw.high.is_finite()) {
                let given = format!("[{}, {}]", draw.low, draw.high);
                return Err(Error::invalid(format!("draws[{i}].low"), given, "finite, low not above high"));
            }
        }
        Ok(())
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
