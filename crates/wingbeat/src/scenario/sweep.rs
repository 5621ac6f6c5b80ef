//! Many runs of one scenario or case with keys drawn at random or from a grid.

use super::document::{ConfigError, Document, Place, Problem, Wrong};
use super::shared::Shared;
use super::{PaperResults, ReadTable, RunName, Scenario, Summary, TetherCase};
use crate::Error;
use crate::math::Random;
use crate::range::{Range, ranges};
use crate::require;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

/// Most runs of a sweep.
const MAX_RUNS: usize = 1_000_000;
/// Largest seed of the first run: TOML's whole numbers end beyond the last one's.
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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(
        feature = "schema",
        schemars(schema_with = "crate::scenario::schema::file_or::<crate::scenario::ScenarioSpec>")
    )]
    pub scenario: Option<toml::Value>,
    /// Case file of `wingbeat tether`, relative to the sweep file, or a table, the case itself; in place of `scenario`
    /// and `hold`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(
        feature = "schema",
        schemars(schema_with = "crate::scenario::schema::file_or::<crate::scenario::TetherSpec>")
    )]
    pub case: Option<toml::Value>,
    /// How values are drawn.
    #[serde(default)]
    pub sampling: Sampling,
    /// Number of runs; of a grid the product of its points, and not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub runs: Option<usize>,
    /// Seed of the draws; flight `i` flies with the seed `seed + i`.
    #[serde(default)]
    pub seed: u64,
    /// Keys of the scenario or case and the ranges they are drawn from.
    pub draws: Vec<Draw>,
    /// What counts as held; of flights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold: Option<Hold>,
}

/// How the values of a sweep are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Each evenly from its range, by itself.
    #[default]
    Random,
    /// As many equal parts of each range as runs, each used once, in an order of its own (McKay, Beckman & Conover
    /// 1979).
    LatinHypercube,
    /// All combinations of `points` values from each range, ends included.
    Grid,
}

/// One key drawn from [low, high], or from a list of values.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(transform = crate::range::put(Self::RANGES)))]
#[serde(deny_unknown_fields)]
pub struct Draw {
    /// Key of the scenario or case, e.g. `mismatch.mass`, `mismatch.com_m[0]` or `time.frequency_hz`.
    pub key: String,
    /// Lower end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Upper end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// Number of values of a grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<usize>,
    /// Values in place of a range: numbers, words or truth values, each as likely as the others. What is recorded of
    /// words is their place in the list, from 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(with = "Vec<Listed>"))]
    pub values: Vec<toml::Value>,
}

/// A value of a list, for the schema.
#[cfg(feature = "schema")]
#[derive(schemars::JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
pub(super) enum Listed {
    /// A number.
    Number(f64),
    /// A word.
    Word(String),
    /// A truth value.
    Truth(bool),
}

/// Largest errors of a held flight, from the goal's settling time on.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(transform = crate::range::put(Self::RANGES)))]
#[serde(deny_unknown_fields)]
pub struct Hold {
    /// Largest |roll - reference|, deg.
    pub roll_within_deg: f64,
    /// Largest |pitch - reference|, deg.
    pub pitch_within_deg: f64,
    /// Largest |height - reference| under `[controller.orbit]`, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_within_m: Option<f64>,
    /// Largest root mean square of the distance across the path, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross_rms_within_m: Option<f64>,
    /// Least clearance over the whole flight at which it counts as clear, m; of being held it is no part.
    #[serde(default)]
    pub clearance_m: f64,
}

impl Hold {
    /// True when the whole flight was flown and the errors stayed within.
    pub fn met(&self, summary: &Summary) -> bool {
        summary.completed()
            && summary.roll_max_error_deg.is_some_and(|e| e <= self.roll_within_deg)
            && summary.pitch_max_error_deg.is_some_and(|e| e <= self.pitch_within_deg)
            && self.height_within_m.is_none_or(|most| summary.height_max_error_m.is_some_and(|e| e <= most))
            && self
                .cross_rms_within_m
                .is_none_or(|most| summary.path.as_ref().is_some_and(|path| path.cross_rms_m <= most))
    }

    /// True when no two parts came closer than allowed.
    pub fn clear(&self, summary: &Summary) -> bool {
        summary.least_clearance_m.is_none_or(|least| least >= self.clearance_m)
    }
}

/// A checked sweep.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// What the file said.
    pub spec: SweepSpec,
    /// What is run.
    pub of: SweepOf,
    /// The sweep as TOML, what is run inside; makes the same runs.
    pub resolved: String,
    document: Document,
    inner: Document,
    /// Part of its range by draw and run, of a Latin hypercube.
    parts: Vec<Vec<usize>>,
    pub(super) shared: Arc<Shared>,
}

/// What a sweep runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SweepOf {
    /// Flights of a scenario.
    Flights(Hold),
    /// Runs of a tethered wing.
    Cases,
}

impl SweepOf {
    fn key(self) -> &'static str {
        match self {
            Self::Flights(_) => "scenario",
            Self::Cases => "case",
        }
    }
}

impl Sweep {
    /// Reads and checks a sweep file and its scenario or case; `read` reads the tables of a case.
    ///
    /// # Errors
    /// One message with file, line, key, the value given and what is allowed.
    pub fn load(path: &Path, overrides: &[String], read: ReadTable) -> Result<Self, ConfigError> {
        Self::new(Document::file(path)?.overridden(overrides), read)
    }

    /// Checks a sweep from files or memory. Its key `scenario` or `case` names a file, or holds what is run.
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
    /// let no_tables = &|_: &Path| Err("no tables here".to_owned());
    /// let sweep = Sweep::new(Document::text("gusts", text)?.put("scenario", scenario)?, no_tables)?;
    /// assert_eq!(sweep.values(3).len(), 1);
    /// # Ok::<(), wingbeat::scenario::ConfigError>(())
    /// ```
    ///
    /// # Errors
    /// Messages with the place, the key, the value given and what is allowed.
    pub fn new(document: Document, read: ReadTable) -> Result<Self, ConfigError> {
        // What is run is read here, once: all runs are of the same, and the sweep holds it.
        let document = document
            .merged(&["scenario", "scenario.robot", "scenario.robot.numbers", "case"], &|_, _| None)?;
        let spec: SweepSpec = document.parse()?;
        let resolved = document.resolved()?;
        let of = spec.check().map_err(|error| document.explain(&error))?;
        let inner = document.part(of.key())?;
        let parts = spec.parts();
        let shared = Arc::default();
        let sweep = Self { spec, of, resolved, document, inner, parts, shared };
        sweep.check_draws(read)?;
        Ok(sweep)
    }

    /// What is published of the scenario of its flights.
    pub fn paper(&self) -> Option<PaperResults> {
        self.inner.parse::<super::ScenarioSpec>().ok()?.paper
    }

    /// Number of runs.
    pub fn runs(&self) -> usize {
        self.spec.count()
    }

    /// The values drawn for run `run`, in the order of the draws: random numbers are from
    /// a stream of its own for every run, so that order and interruption do not matter. Of a grid the last draw varies
    /// fastest.
    pub fn values(&self, run: usize) -> Vec<f64> {
        let mut random = Random::stream(self.spec.seed, run as u64);
        let (mut left, mut grid) = (self.runs(), run);
        let mut value = |(k, draw): (usize, &Draw)| match self.spec.sampling {
            Sampling::Random => draw.share(random.unit()),
            Sampling::LatinHypercube => {
                draw.share((self.parts[k][run] as f64 + random.unit()) / self.runs() as f64)
            }
            Sampling::Grid => {
                let points = draw.count();
                left /= points;
                let place = grid / left;
                grid %= left;
                draw.at(place)
            }
        };
        self.spec.draws.iter().enumerate().map(&mut value).collect()
    }

    /// What run `run` runs, with its values.
    fn drawn(&self, run: usize) -> Document {
        let draws = self.spec.draws.iter().zip(self.values(run));
        draws.fold(self.inner.clone(), |document, (d, v)| document.set(drawn(d, v)))
    }

    /// The scenario of flight `run`.
    ///
    /// # Errors
    /// A drawn key that the scenario does not know, or refuses.
    pub fn scenario(&self, run: usize) -> Result<Scenario, ConfigError> {
        let seed = self.spec.seed + run as u64;
        Scenario::new(self.drawn(run).set(format!("seed={seed}")))
    }

    /// The case of run `run`.
    ///
    /// # Errors
    /// A drawn key that the case does not know, or refuses.
    pub fn case(&self, run: usize, read: ReadTable) -> Result<TetherCase, ConfigError> {
        TetherCase::new(self.drawn(run), read)
    }

    /// The sweep as TOML, each table of its case under the name that `name` gives for its file, beside the sweep.
    ///
    /// # Errors
    /// A sweep that TOML cannot hold.
    pub fn kept(&self, read: ReadTable, name: impl Fn(&Path) -> String) -> Result<String, ConfigError> {
        if self.of != SweepOf::Cases {
            return Ok(self.resolved.clone());
        }
        let case = TetherCase::new(self.inner.clone(), read)?.kept(name)?;
        let spec = SweepSpec { case: None, ..self.spec.clone() };
        Document::value("sweep", &spec)?.put("case", Document::text("case", &case)?)?.resolved()
    }

    /// Builds what is run, and then with both ends of every draw and a value between, one at a time.
    fn check_draws(&self, read: ReadTable) -> Result<(), ConfigError> {
        let built = |document: Document| match self.of {
            SweepOf::Flights(_) => Scenario::new(document).map(drop),
            SweepOf::Cases => TetherCase::new(document, read).map(drop),
        };
        built(self.inner.clone())?;
        for (i, draw) in self.spec.draws.iter().enumerate() {
            for (end, value) in draw.tried() {
                let given = drawn(draw, value);
                let outcome = built(self.inner.clone().set(given.as_str()));
                outcome.map_err(|error| self.blamed(error, &given, &format!("draws[{i}]"), &end))?;
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
        let allowed = format!("what the {} allows ({error})", self.of.key());
        self.document.explain(&Error::invalid(key, value, allowed))
    }
}

/// Below this whole numbers are floats without a gap.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// The override of one draw: without a fraction a whole number, which keys of either kind take.
fn drawn(draw: &Draw, value: f64) -> String {
    if let Some(word) = draw.word(value) {
        return format!("{}={word}", draw.key);
    }
    match value.fract() == 0.0 && value.abs() < LARGEST_WHOLE {
        true => format!("{}={value}", draw.key),
        false => format!("{}={value:?}", draw.key),
    }
}

ranges!(SweepSpec { runs: Range::between(1.0, MAX_RUNS as f64) });
ranges!(Draw { points: Range::between(1.0, MAX_RUNS as f64) });
ranges!(Hold {
    roll_within_deg: Range::POSITIVE,
    pitch_within_deg: Range::POSITIVE,
    height_within_m: Range::POSITIVE,
    cross_rms_within_m: Range::POSITIVE,
    clearance_m: Range::between(-1.0, 1.0),
});

impl SweepSpec {
    /// The checked name.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key `name`.
    pub fn run_name(&self) -> Result<RunName, Error> {
        RunName::new("name", &self.name)
    }

    /// Number of runs; 0 where the file does not say.
    fn count(&self) -> usize {
        match self.sampling {
            Sampling::Grid => {
                let points = self.draws.iter().map(Draw::count);
                points.fold(1, usize::saturating_mul)
            }
            Sampling::Random | Sampling::LatinHypercube => self.runs.unwrap_or(0),
        }
    }

    /// For every draw of a Latin hypercube an order of the parts of its range, from a stream that no run has.
    fn parts(&self) -> Vec<Vec<usize>> {
        if self.sampling != Sampling::LatinHypercube {
            return Vec::new();
        }
        let order = |k: usize| {
            let mut random = Random::stream(self.seed, u64::MAX - k as u64);
            let mut parts: Vec<usize> = (0..self.count()).collect();
            for i in (1..parts.len()).rev() {
                parts.swap(i, (random.unit() * (i + 1) as f64) as usize);
            }
            parts
        };
        (0..self.draws.len()).map(order).collect()
    }

    fn check(&self) -> Result<SweepOf, Error> {
        self.run_name()?;
        self.in_range()?;
        require::at_most("seed", self.seed, MAX_SEED)?;
        let grid = self.sampling == Sampling::Grid;
        for (i, draw) in self.draws.iter().enumerate() {
            draw.check(grid).map_err(|e| e.within(&format!("draws[{i}]")))?;
        }
        if grid && let Some(runs) = self.runs {
            let allowed = "none of a grid: draws[].points make its runs";
            return Err(Error::invalid("runs", runs, allowed).against(["sampling"]));
        }
        require::between(if grid { "draws" } else { "runs" }, self.count(), 1, MAX_RUNS)?;
        match (&self.scenario, &self.case, self.hold) {
            (Some(_), None, Some(hold)) => {
                hold.check().map_err(|e| e.within("hold"))?;
                Ok(SweepOf::Flights(hold))
            }
            (None, Some(_), None) => Ok(SweepOf::Cases),
            (Some(_), None, None) => Err(Error::invalid("hold", "none", "what counts as held, of flights")),
            (_, Some(_), Some(_)) => Err(Error::invalid("hold", "given", "none of a case: nothing is held")),
            _ => Err(Error::invalid("scenario", "none, or one beside a case", "one of scenario and case")),
        }
    }
}

impl Draw {
    /// The ends of its range; both 0 of a list.
    fn ends(&self) -> [f64; 2] {
        [self.low, self.high].map(Option::unwrap_or_default)
    }

    /// Number of values of a grid.
    fn count(&self) -> usize {
        if self.values.is_empty() { self.points.unwrap_or(1) } else { self.values.len() }
    }

    /// The value at the share `part` of the range, in [0, 1).
    fn share(&self, part: f64) -> f64 {
        let [low, high] = self.ends();
        match self.values.len() {
            0 => low + (high - low) * part,
            count => self.at(((part * count as f64) as usize).min(count - 1)),
        }
    }

    /// The value at a place of a grid; the last is the upper end itself.
    fn at(&self, place: usize) -> f64 {
        if let Some(value) = self.values.get(place) {
            return number(value).unwrap_or(place as f64);
        }
        let ([low, high], steps) = (self.ends(), (self.count() - 1).max(1));
        if place == steps { high } else { low + (high - low) * place as f64 / steps as f64 }
    }

    /// What is tried before any run, with the key that it stands for: both ends and a value between, of a grid its
    /// second, which is whole where all are; or all of a list.
    fn tried(&self) -> Vec<(String, f64)> {
        if !self.values.is_empty() {
            return (0..self.values.len())
                .map(|place| (format!("values[{place}]"), self.at(place)))
                .collect();
        }
        let [low, high] = self.ends();
        let inner = low + (high - low) / std::f64::consts::E;
        let ends = [("low", low), ("high", high), ("high", self.points.map_or(inner, |_| self.at(1)))];
        ends.map(|(key, value)| (key.into(), value)).into()
    }

    /// The word of a list that the recorded `value` stands for; none of numbers.
    pub fn word(&self, value: f64) -> Option<&toml::Value> {
        self.values.get(value as usize).filter(|word| number(word).is_none())
    }

    fn check(&self, grid: bool) -> Result<(), Error> {
        self.in_range()?;
        if !self.values.is_empty() {
            return self.check_list();
        }
        let [low, high] = [("low", self.low), ("high", self.high)].map(|(key, end)| {
            end.ok_or_else(|| Error::invalid(key, "none", "an end of the range, or values"))
        });
        let (low, high) = (low?, high?);
        require::finite("low", &[low])?;
        require::finite("high", &[high])?;
        require::at_most("low", low, high).map_err(|e| e.against(["high"]))?;
        match self.points {
            Some(points) if !grid => {
                Err(Error::invalid("points", points, "none: they are of sampling = \"grid\"")
                    .against(["sampling"]))
            }
            None if grid => Err(Error::invalid("points", "none", "the number of values of a grid")),
            _ => Ok(()),
        }
    }

    fn check_list(&self) -> Result<(), Error> {
        for (key, given) in
            [("low", self.low), ("high", self.high), ("points", self.points.map(|n| n as f64))]
        {
            if let Some(given) = given {
                return Err(Error::invalid(key, given, "none beside values").against(["values"]));
            }
        }
        let kinds = self.values.iter().filter(|value| number(value).is_some()).count();
        let known = |value: &toml::Value| value.is_str() || value.is_bool() || number(value).is_some();
        if self.values.iter().all(known) && (kinds == 0 || kinds == self.values.len()) {
            return Ok(());
        }
        let numbers = 2 * kinds > self.values.len();
        let odd = |value: &&toml::Value| !known(value) || number(value).is_some() != numbers;
        let place = self.values.iter().position(|value| odd(&value)).unwrap_or(0);
        let given = &self.values[place];
        let error =
            Error::invalid(format!("values[{place}]"), given, "numbers alone, or words and truth values");
        let others = (0..self.values.len()).filter(|other| *other != place);
        Err(error.against(others.map(|other| format!("values[{other}]"))))
    }
}

/// A finite number of a list.
fn number(value: &toml::Value) -> Option<f64> {
    match value {
        toml::Value::Integer(whole) => Some(*whole as f64),
        toml::Value::Float(number) if number.is_finite() => Some(*number),
        _ => None,
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
        Sweep::load(&path, &[], NO_TABLES).unwrap_or_else(|e| panic!("{e}"))
    }

    const NO_TABLES: ReadTable = &|_: &Path| Err(String::new());

    fn of_case(more: &str) -> Sweep {
        let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
        let text = format!(
            "name = \"map\"\n{more}\n[[draws]]\nkey = \"time.frequency_hz\"\nlow = 2.0\nhigh = 4.0\n[[draws]]\n\
             key = \"wing.hinges[0].angle_deg.fourier.sin[0]\"\nlow = 10.0\nhigh = 40.0\n"
        );
        let document = Document::text("map", &text).unwrap();
        Sweep::new(document.put("case", Document::file(&case).unwrap()).unwrap(), NO_TABLES).unwrap()
    }

    #[test]
    fn a_grid_has_every_combination_and_a_hypercube_every_part_once() {
        let points = "sampling = \"grid\"\ndraws = [\
             { key = \"time.frequency_hz\", low = 2.0, high = 4.0, points = 3 },\
             { key = \"wind.speed_m_s\", low = 1.0, high = 2.0, points = 2 }]";
        let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
        let document = Document::text("map", &format!("name = \"map\"\n{points}\n")).unwrap();
        let document = document.put("case", Document::file(&case).unwrap()).unwrap();
        let grid = Sweep::new(document, NO_TABLES).unwrap();
        let values: Vec<Vec<f64>> = (0..grid.runs()).map(|run| grid.values(run)).collect();
        assert_eq!(values, [[2.0, 1.0], [2.0, 2.0], [3.0, 1.0], [3.0, 2.0], [4.0, 1.0], [4.0, 2.0]]);
        assert_eq!(grid.case(3, NO_TABLES).unwrap().spec.wind.speed_m_s, 2.0);
        let [low, high] = [0.1, 0.7].map(Some);
        let tenths = Draw { key: String::new(), low, high, points: Some(8), values: Vec::new() };
        assert_eq!((tenths.at(0), tenths.at(7)), (0.1, 0.7));

        let cube = of_case("runs = 20\nsampling = \"latin_hypercube\"\nseed = 3");
        for k in 0..2 {
            let [low, high] = cube.spec.draws[k].ends();
            let part = |run: usize| ((cube.values(run)[k] - low) / (high - low) * 20.0) as usize;
            let mut parts: Vec<usize> = (0..20).map(part).collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..20).collect::<Vec<_>>());
        }
        let orders: Vec<bool> = (0..20).map(|run| cube.parts[0][run] == cube.parts[1][run]).collect();
        assert!(orders.iter().filter(|same| **same).count() < 10);
    }

    #[test]
    fn whole_numbers_are_drawn_from_a_grid_of_them() {
        let drawn = |sampling: &str| {
            let key = "key = \"time.steps_per_cycle\", low = 32.0, high = 96";
            let text = format!("name = \"steps\"\n{}", sampling.replace("KEY", key));
            let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
            let document = Document::text("steps", &text).unwrap();
            Sweep::new(document.put("case", Document::file(&case).unwrap()).unwrap(), NO_TABLES)
        };
        let grid = drawn("sampling = \"grid\"\ndraws = [{ KEY, points = 3 }]").unwrap();
        assert_eq!(grid.case(1, NO_TABLES).unwrap().spec.time.steps_per_cycle, 64);
        for other in ["sampling = \"grid\"\ndraws = [{ KEY, points = 4 }]", "runs = 3\ndraws = [{ KEY }]"] {
            let message = drawn(other).unwrap_err().to_string();
            assert!(message.contains("time.steps_per_cycle"), "{message}");
        }
    }

    #[test]
    fn lists_are_drawn_by_their_values() {
        let drawn = |draws: &str| {
            let text = format!("name = \"laws\"\nruns = 12\nsampling = \"latin_hypercube\"\n{draws}");
            let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
            let document = Document::text("laws", &text).unwrap();
            Sweep::new(document.put("case", Document::file(&case).unwrap()).unwrap(), NO_TABLES)
        };
        let laws = "draws = [{ key = \"aero.law\", values = [\"linear\", \"stall\", \"lev\"] }, \
                    { key = \"aero.full.strips\", values = [12, 16] }]";
        let sweep = drawn(laws).unwrap();
        let count = |k: usize, v: f64| (0..12).filter(|&run| sweep.values(run)[k] == v).count();
        assert_eq!([0.0, 1.0, 2.0].map(|law| count(0, law)), [4, 4, 4]);
        assert_eq!([12.0, 16.0].map(|strips| count(1, strips)), [6, 6]);
        let stalling = (0..12).find(|&run| sweep.values(run)[0] == 1.0).unwrap();
        assert_eq!(sweep.case(stalling, NO_TABLES).unwrap().spec.aero.law.name(), "stall");
        for (bad, key) in [
            ("draws = [{ key = \"aero.law\", values = [\"linear\", \"still\"] }]", "key"),
            ("draws = [{ key = \"aero.law\", values = [\"linear\", 1.0] }]", "values"),
            ("draws = [{ key = \"aero.law\", values = [\"linear\"], low = 1.0 }]", "low"),
            ("draws = [{ key = \"wind.speed_m_s\", low = 1.0 }]", "high"),
        ] {
            let message = drawn(bad).unwrap_err().to_string();
            assert!(message.contains(&format!("draws[0].{key}")), "{message}");
        }
    }

    #[test]
    fn draws_lie_in_their_ranges_and_belong_to_their_flight() {
        let sweep = sweep();
        let later = sweep.values(41);
        for run in 0..50 {
            for (draw, value) in sweep.spec.draws.iter().zip(sweep.values(run)) {
                let [low, high] = draw.ends();
                assert!((low..=high).contains(&value), "{} = {value}", draw.key);
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
