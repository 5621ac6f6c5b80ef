//! What a sweep file says, and the checks of it.

use super::fit_draw::DrawnNumbers;
use super::{RunName, Summary, SweepOf, SweepSearch, VerdictLimits};
use serde::{Deserialize, Serialize};
use wingbeat_judge::Status;
use wingbeat_math::Error;
use wingbeat_math::Random;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;
use wingbeat_robot::GivenNumbers;

/// Most runs of a sweep.
const MAX_RUNS: usize = 1_000_000;
/// Largest seed of the first run: TOML's whole numbers end beyond the last one's.
const MAX_SEED: u64 = i64::MAX as u64 - MAX_RUNS as u64;

/// A sweep file.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct SweepSpec {
    /// Name; the run folder is called after it.
    pub name: String,
    /// Scenario file, relative to the sweep file; or a table, the scenario itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "crate::schema::file_or::<crate::ScenarioSpec>")]
    pub scenario: Option<toml::Value>,
    /// Case file of `wingbeat tether`, relative to the sweep file, or a table, the case itself; in place of `scenario`
    /// and `hold`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "crate::schema::file_or::<crate::TetherSpec>")]
    pub case: Option<toml::Value>,
    /// Overrides of the scenario or case, as `--set` takes them: `set = ["flight.duration_s=2.0"]`; files in them are sought beside this one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// How values are drawn.
    #[serde(default)]
    pub sampling: Sampling,
    /// Number of runs; of a grid the product of its points, and not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub runs: Option<usize>,
    /// Seed of the draws; flight `i` flies with the seed `seed + i`.
    #[serde(default)]
    pub seed: u64,
    /// Steps four flights at once in the lanes of vector registers; their rows differ by rounding from those without. Flights
    /// can be stepped beside others that differ in `[air]`, `[start]`, `[mismatch]`, `[sensors]`, `[controller]`, the numbers
    /// of `[robot.body]`, `robot.numbers` and the gait's frequency; where anything else is drawn lanes stand empty.
    #[serde(default, skip_serializing_if = "is_false")]
    pub lanes: bool,
    /// Keys of the scenario or case and the ranges they are drawn from.
    pub draws: Vec<Draw>,
    /// Searches the draws for what meets goals, in place of drawing them; `runs` is then the number of candidates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub search: Option<SweepSearch>,
    /// What counts as held; of flights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold: Option<Hold>,
    /// Limits of the verdict on the sweep, `sweep.held_fraction = 0.9`; those on a run are in its scenario or case.
    #[serde(default, skip_serializing_if = "VerdictLimits::is_empty")]
    pub limits: VerdictLimits,
}

fn is_false(truth: &bool) -> bool {
    !truth
}

/// How the values of a sweep are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
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

/// One key drawn from [low, high], or from a list of values; or the numbers of a fit.
#[derive(Clone, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct Draw {
    /// Key of the scenario or case, e.g. `mismatch.mass`, `mismatch.com_x_m` or `time.frequency_hz`.
    pub key: String,
    /// Lower end, in the unit of the key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Upper end, in the unit of the key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// Number of values of a grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<usize>,
    /// Values in place of a range: numbers, words or truth values, each as likely as the others. What is recorded of
    /// words is their place in the list, from 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Vec<Listed>")]
    pub values: Vec<toml::Value>,
    /// Value with which a search begins, in the unit of the key; without it the middle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// Other keys that take the same value; behind a minus sign its negative: `-robot.structure.elements[0].low`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<String>,
    /// Numbers of a fit in place of a range, a file that `wingbeat calibrate` wrote or its table, for a key `robot.numbers`,
    /// `mismatch.numbers` or, of a case, `numbers`: those that it fitted are drawn together, with its standard errors and correlations, by Student's distribution with its degrees of freedom (normal where the file has none);
    /// those that it held stay.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "wingbeat_robot::file_or_numbers")]
    pub fit: Option<GivenNumbers>,
}

/// A value of a list, for the schema.
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

/// What a sweep of flights must have.
const HOLD: &str =
    "a table [hold] with roll_within_deg and pitch_within_deg, which say what counts as held, of flights";

/// Largest errors of a held flight, from the goal's settling time on; one that is not resolved is not held. A flight to a `[perch]` is held
/// where the claw latches and it misses no limit.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
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
    /// What every flight meets: that of a search, which has goals in its place.
    const ANY: Self = Self {
        roll_within_deg: f64::INFINITY,
        pitch_within_deg: f64::INFINITY,
        height_within_m: None,
        cross_rms_within_m: None,
        clearance_m: f64::NEG_INFINITY,
    };

    /// True when the whole flight was flown and resolved, and the errors stayed within; on a landing, where it latched and no limit was missed.
    /// None of a flight that was flown whole, of which one record or none is left to judge.
    pub fn met(&self, summary: &Summary) -> Option<bool> {
        if let Some(perch) = &summary.perch {
            return Some(perch.caught && summary.status.exit_code() == 0);
        }
        (!summary.completed() || summary.settled_records > 1).then(|| self.within(summary))
    }

    /// True when a flight was flown whole and resolved, and its errors stayed within.
    fn within(&self, summary: &Summary) -> bool {
        summary.status < Status::NotResolved
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

    /// Keys of the draws, and the overrides of the flights of a search.
    pub(super) fn settings(&self) -> Vec<&str> {
        let drawn = self.draws.iter().flat_map(|draw| std::iter::once(&draw.key).chain(&draw.also));
        let flown = self.search.iter().flat_map(|search| search.flights.iter().flatten());
        drawn.chain(flown).map(String::as_str).collect()
    }

    /// Number of runs; 0 where the file does not say.
    pub(super) fn count(&self) -> usize {
        match self.sampling {
            Sampling::Grid => {
                let points = self.draws.iter().map(Draw::count);
                points.fold(1, usize::saturating_mul)
            }
            Sampling::Random | Sampling::LatinHypercube => self.runs.unwrap_or(0),
        }
    }

    /// For every draw of a Latin hypercube an order of the parts of its range, from a stream that no run has.
    pub(super) fn parts(&self) -> Vec<Vec<usize>> {
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

    pub(super) fn check(&self) -> Result<SweepOf, Error> {
        self.run_name()?;
        self.in_range()?;
        require::at_most("seed", self.seed, MAX_SEED)?;
        let grid = self.sampling == Sampling::Grid;
        for (i, draw) in self.draws.iter().enumerate() {
            draw.check(grid).map_err(|e| e.within(&format!("draws[{i}]")))?;
            if draw.fit.is_some() && (self.sampling != Sampling::Random || self.search.is_some()) {
                let allowed = "none of a grid, a Latin hypercube or a search: a fit has no range to divide";
                let error = Error::invalid(format!("draws[{i}].fit"), "given", allowed);
                return Err(error.against(["sampling", "search"]));
            }
        }
        match &self.search {
            Some(search) => self.check_search(search)?,
            None => {
                if let Some(i) = self.draws.iter().position(|draw| draw.start.is_some()) {
                    return Err(Error::invalid(
                        format!("draws[{i}].start"),
                        "given",
                        "none without [search]",
                    ));
                }
            }
        }
        if grid && let Some(runs) = self.runs {
            let allowed = "none of a grid: draws[].points make its runs";
            return Err(Error::invalid("runs", runs, allowed).against(["sampling"]));
        }
        require::between(if grid { "draws" } else { "runs" }, self.count(), 1, MAX_RUNS)?;
        if self.draws.is_empty() && self.count() > 1 {
            let allowed = "at least one draw, or runs = 1: without a draw all runs are equal";
            return Err(Error::invalid("draws", "none", allowed).against(["runs"]));
        }
        match (&self.scenario, &self.case, self.hold) {
            (Some(_), None, Some(_)) if self.search.is_some() => {
                Err(Error::invalid("hold", "given", "none of a search: its goals say what is asked"))
            }
            (Some(_), None, None) if self.search.is_some() => Ok(SweepOf::Flights(Hold::ANY)),
            (Some(_), None, Some(hold)) => {
                hold.check().map_err(|e| e.within("hold"))?;
                Ok(SweepOf::Flights(hold))
            }
            (None, Some(_), None) if self.lanes => {
                Err(Error::invalid("lanes", true, "false of a case: flights alone are stepped side by side"))
            }
            (None, Some(_), None) => Ok(SweepOf::Cases),
            (Some(_), None, None) => Err(Error::invalid("hold", "missing", HOLD)),
            (_, Some(_), Some(_)) => Err(Error::invalid("hold", "given", "none of a case: nothing is held")),
            _ => Err(Error::invalid("scenario", "none, or one beside a case", "one of scenario and case")),
        }
    }
}

impl SweepSpec {
    /// No two draws set the same key, items of lists by their `numbered` places, and a minus sign stands before the key of a number.
    pub(super) fn check_keys(drawn: &DrawnNumbers, numbered: &dyn Fn(&str) -> String) -> Result<(), Error> {
        let mut seen: Vec<String> = Vec::new();
        for (i, draw) in drawn.places.iter().zip(&drawn.draws) {
            for (k, written) in std::iter::once(&draw.key).chain(&draw.also).enumerate() {
                let wrong = |allowed: &str| {
                    let place = if k == 0 { "key".into() } else { format!("also[{}]", k - 1) };
                    Err(Error::invalid(format!("draws[{i}].{place}"), written, allowed))
                };
                let key = if k == 0 { written } else { written.strip_prefix('-').unwrap_or(written) };
                if key.is_empty() {
                    return wrong("the key of a number or word");
                }
                if key.len() < written.len() && draw.values.iter().any(|value| number(value).is_none()) {
                    return wrong("no minus sign: words and truth values have no negative");
                }
                let place = numbered(key);
                if seen.contains(&place) {
                    return wrong("a key that is drawn once");
                }
                seen.push(place);
            }
        }
        Ok(())
    }

    /// What a search needs of the sweep around it.
    fn check_search(&self, search: &SweepSearch) -> Result<(), Error> {
        search.check().map_err(|e| e.within("search"))?;
        if self.sampling != Sampling::Random {
            return Err(Error::invalid("sampling", "given", "none of a search: it chooses the values"));
        }
        if self.case.is_some() || self.lanes {
            let key = if self.lanes { "lanes" } else { "case" };
            return Err(Error::invalid(
                key,
                "given",
                "none of a search: it flies a scenario, flight by flight",
            ));
        }
        for (i, draw) in self.draws.iter().enumerate() {
            let within = |e: Error| e.within(&format!("draws[{i}]"));
            if !draw.values.is_empty() {
                return Err(within(Error::invalid(
                    "values",
                    "given",
                    "low and high: a search varies numbers",
                )));
            }
            let [low, high] = draw.ends();
            if !(low < high) {
                return Err(within(Error::invalid("high", high, format!("above low = {low}"))));
            }
            if let Some(start) = draw.start {
                require::between("start", start, low, high).map_err(within)?;
            }
        }
        Ok(())
    }
}

impl Draw {
    /// The ends of its range; both 0 of a list.
    pub(super) fn ends(&self) -> [f64; 2] {
        [self.low, self.high].map(Option::unwrap_or_default)
    }

    /// Number of values of a grid.
    pub(super) fn count(&self) -> usize {
        if self.values.is_empty() { self.points.unwrap_or(1) } else { self.values.len() }
    }

    /// The value at the share `part` of the range, in [0, 1).
    pub(super) fn share(&self, part: f64) -> f64 {
        let [low, high] = self.ends();
        match self.values.len() {
            0 => low + (high - low) * part,
            count => self.at(((part * count as f64) as usize).min(count - 1)),
        }
    }

    /// The value at a place of a grid; the last is the upper end itself.
    pub(super) fn at(&self, place: usize) -> f64 {
        if let Some(value) = self.values.get(place) {
            return number(value).unwrap_or(place as f64);
        }
        let ([low, high], steps) = (self.ends(), (self.count() - 1).max(1));
        if place == steps { high } else { low + (high - low) * place as f64 / steps as f64 }
    }

    /// What is tried before any run, with the key that it stands for: both ends and a value between, of a grid its
    /// second, which is whole where all are; or all of a list.
    pub(super) fn tried(&self) -> Vec<(String, f64)> {
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

    /// The word of a list that the recorded `value` stands for (a number of its place, without unit); none of numbers.
    pub fn word(&self, value: f64) -> Option<&toml::Value> {
        self.values.get(value as usize).filter(|word| number(word).is_none())
    }

    pub(super) fn check(&self, grid: bool) -> Result<(), Error> {
        self.in_range()?;
        if self.fit.is_some() {
            return self.check_alone();
        }
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

    /// Beside a fit nothing else says what is drawn.
    fn check_alone(&self) -> Result<(), Error> {
        let given = [
            ("low", self.low.is_some()),
            ("high", self.high.is_some()),
            ("points", self.points.is_some()),
            ("values", !self.values.is_empty()),
            ("start", self.start.is_some()),
            ("also", !self.also.is_empty()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((key, _)) => Err(Error::invalid(key, "given", "none beside fit").against(["fit"])),
            None => Ok(()),
        }
    }

    pub(super) fn check_list(&self) -> Result<(), Error> {
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
    pub(super) fn check(self) -> Result<(), Error> {
        self.in_range()
    }
}
