//! The search of a sweep: candidates, what their flights came to, and the best of them.

use super::sweep::with_all;
use super::sweep_verdict::status;
use super::{ConfigError, Scenario, SearchGoal, Summary, Sweep, SweepSearch};
use serde::Serialize;
use std::ops::ControlFlow;
use wingbeat_flight::simulate::{Column, Record};
use wingbeat_judge::{Judge, Status, Verdict, Warning, limits};
use wingbeat_math::order::ascend_by;
use wingbeat_math::{Error, Evolution};

/// What a flight costs that was not flown whole, times 2 less the share that was: more than any miss that is worth a look.
/// *Choice.*
const BROKEN: f64 = 1e6;
/// Column of the verdict of a flight, by the place of its status in [`Status::ALL`].
const STATUS: &str = "status";
/// Measures of a candidate beside those of its flights.
const OWN: [(&str, &str); 2] = [("ends_apart", "m"), ("cost", "")];

/// A search under way.
pub struct CandidateSearch<'a> {
    sweep: &'a Sweep,
    spec: &'a SweepSearch,
    evolution: Evolution,
    /// Candidates of the generations that are told.
    told: usize,
}

/// What the best candidate came to.
#[derive(Clone, Debug, Serialize)]
pub struct SearchFound {
    /// Candidates flown.
    pub candidates: usize,
    /// Number of the best one.
    pub best: usize,
    /// Its cost, dimensionless: sum of the squares of all misses; 0 meets all goals.
    pub cost: f64,
    /// Its values, by the keys of the draws and in the units of these.
    pub values: Vec<(String, f64)>,
    /// What its flights came to.
    pub flights: Vec<SearchFlight>,
    /// Largest distance between their end points, m.
    pub ends_apart_m: Option<f64>,
}

/// A flight of the best candidate.
#[derive(Clone, Debug, Serialize)]
pub struct SearchFlight {
    /// Its overrides.
    pub overrides: Vec<String>,
    /// Status of its own verdict; missing where the scenario refused the values.
    pub status: Option<&'static str>,
    /// Its goals: key, value in the unit that ends it, what is asked, and whether it is met.
    pub goals: Vec<(String, Option<f64>, String, bool)>,
}

/// `summary.json` of a search.
#[derive(Serialize)]
pub struct SweepFound {
    /// What became of it.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// The best candidate.
    #[serde(flatten)]
    pub found: SearchFound,
}

impl SearchFlight {
    /// The status of a verdict that lets nobody use the flight.
    fn refused(&self) -> Option<&'static str> {
        let refuses = |status: &&Status| **status > Status::OffTarget && self.status == Some(status.name());
        Status::ALL.iter().find(refuses).map(|status| status.name())
    }
}

impl SweepFound {
    /// As JSON.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

impl Sweep {
    /// What a search came to by the rows of all its candidates; none without a row, or where the sweep draws.
    pub fn searched(&self, record: &Record) -> Option<SweepFound> {
        let found = SearchFound::new(self, self.spec.search.as_ref()?, record)?;
        Some(SweepFound { verdict: self.verdict(record), found })
    }

    /// The search after the candidates of whole generations among `rows`, in the units of their columns, in any order.
    ///
    /// # Errors
    /// A row that is not of this search.
    pub fn search_after(&self, rows: &[Vec<f64>]) -> Option<Result<CandidateSearch<'_>, Error>> {
        let mut search = self.search()?;
        let mut sorted: Vec<&Vec<f64>> = rows.iter().collect();
        ascend_by(&mut sorted, |row| *row.first().unwrap_or(&0.0));
        while !search.generation().is_empty() && sorted.len() >= search.generation().end {
            let own = &sorted[search.generation()];
            let strange =
                search.generation().zip(own).find(|(run, row)| row[0] != *run as f64 || !search.has_row(row));
            if let Some((run, _)) = strange {
                return Some(Err(Error::invalid("rows", run, "candidates of this search")));
            }
            search.tell(own.iter().map(|row| row.as_slice()));
        }
        Some(Ok(search))
    }

    /// The search that the sweep asks for; none where it draws.
    pub fn search(&self) -> Option<CandidateSearch<'_>> {
        let spec = self.spec.search.as_ref()?;
        let share = |draw: &super::Draw| {
            let [low, high] = draw.ends();
            draw.start.map_or(0.5, |start| (start - low) / (high - low))
        };
        let mean = self.spec.draws.iter().map(share).collect();
        let evolution = Evolution::new(mean, spec.spread, spec.population, self.spec.seed);
        Some(CandidateSearch { sweep: self, spec, evolution, told: 0 })
    }

    /// Holds what a search found against its limits, and says what the best candidate misses.
    pub(super) fn judge_search(&self, spec: &SweepSearch, record: &Record, judge: &mut Judge) {
        let Some(found) = SearchFound::new(self, spec, record) else {
            return judge.find(Status::Failed, "no candidate was flown");
        };
        let mut missed = 0;
        let mut say = |text: String| {
            missed += 1;
            judge.warn(Warning::new("search.missed", text));
        };
        for (number, flight) in found.flights.iter().enumerate() {
            let which = match flight.overrides.is_empty() {
                true => String::new(),
                false => format!(" (flight {number}, {})", flight.overrides.join(", ")),
            };
            if let Some(refused) = flight.refused() {
                say(format!("the own verdict of the best candidate{which} refuses it: {refused}"));
            }
            for (key, value, asked, met) in &flight.goals {
                if !met {
                    let value = value.map_or("not known".into(), |value| format!("{value:.4}"));
                    say(format!("the best candidate misses {key}{which}: it is {value}, asked is {asked}"));
                }
            }
        }
        if let Some(most) = spec.ends_within_m
            && found.ends_apart_m.is_none_or(|apart| apart > most)
        {
            let apart = found
                .ends_apart_m
                .map_or("at an unknown distance".into(), |a| format!("up to {a:.3} m apart"));
            say(format!("the best candidate's flights end {apart}, asked is at most {most} m"));
        }
        judge.hold(&limits::sweep::MISSED, f64::from(missed));
    }
}

impl<'a> CandidateSearch<'a> {
    /// Columns of a row: number, values, the goals of each flight, and the candidate's own.
    pub fn columns(&self) -> Vec<Column> {
        let draws = self.sweep.spec.draws.iter().map(|draw| Column::new(draw.key.clone(), "", ""));
        let goals = (0..self.spec.count()).flat_map(|flight| {
            let name = move |key: &str| Column::new(format!("flight_{flight}_{key}"), "", "");
            self.spec.goals.iter().map(move |goal| name(&goal.key)).chain([name(STATUS)])
        });
        let own = OWN.iter().map(|(name, unit)| Column::new(*name, *unit, ""));
        std::iter::once(Column::new("run", "", "")).chain(draws).chain(goals).chain(own).collect()
    }

    /// Numbers of the candidates of the present generation, fewer in the last.
    pub fn generation(&self) -> std::ops::Range<usize> {
        self.told..(self.told + self.spec.population).min(self.sweep.runs())
    }

    /// The values of a candidate of the present generation, in the units of their draws.
    pub fn values(&self, run: usize) -> Vec<f64> {
        let shares = self.evolution.candidate(run - self.told);
        let of = |(draw, share): (&super::Draw, f64)| {
            let [low, high] = draw.ends();
            low + (high - low) * share
        };
        self.sweep.spec.draws.iter().zip(shares).map(of).collect()
    }

    /// Whether `row`, in the units of the columns, is that of a candidate: of the present generation its values too.
    pub fn has_row(&self, row: &[f64]) -> bool {
        let run = row.first().copied().unwrap_or(f64::NAN);
        let whole = run.fract() == 0.0 && (0.0..self.sweep.runs() as f64).contains(&run);
        let own = || self.values(run as usize) == row[1..=self.sweep.spec.draws.len()];
        row.len() == self.columns().len() && whole && (!self.generation().contains(&(run as usize)) || own())
    }

    /// Goes on to the next generation by the rows of this one, in the units of their columns.
    pub fn tell<'r>(&mut self, rows: impl Iterator<Item = &'r [f64]>) {
        let costs: Vec<f64> = rows.map(|row| row.last().copied().unwrap_or(f64::NAN)).collect();
        self.told += costs.len();
        if costs.len() == self.spec.population {
            self.evolution.tell(&costs);
        }
    }

    /// Flies a candidate: its row in the units of the columns, or none where `watch` stopped it.
    ///
    /// # Errors
    /// A scenario that cannot be flown.
    pub fn row(
        &self,
        run: usize,
        watch: impl Fn() -> ControlFlow<()>,
    ) -> Result<Option<Vec<f64>>, ConfigError> {
        self.row_of(run, &self.values(run), watch)
    }

    /// Flies candidate `run` with these values, in the units of their draws, which need not be of the present generation: its
    /// row, or none where `watch` stopped it.
    ///
    /// # Errors
    /// A scenario that cannot be flown.
    pub fn row_of(
        &self,
        run: usize,
        values: &[f64],
        watch: impl Fn() -> ControlFlow<()>,
    ) -> Result<Option<Vec<f64>>, ConfigError> {
        let (mut row, mut cost, mut ends) = (vec![run as f64], 0.0, Vec::new());
        row.extend(values);
        for flight in 0..self.spec.count() {
            // Values that the scenario refuses cost as much as a flight that broke down at once.
            let Ok(scenario) = Scenario::new(self.document(values, flight)) else {
                row.extend(vec![f64::NAN; self.spec.goals.len() + 1]);
                cost += 2.0 * BROKEN;
                ends.push((f64::NAN, f64::NAN));
                continue;
            };
            let flown = scenario.fly(|_| watch()).map_err(|error| scenario.explain(&error))?;
            if watch().is_break() {
                return Ok(None);
            }
            let summary = &flown.summary;
            let told = serde_json::to_value(summary).unwrap_or_default();
            for goal in &self.spec.goals {
                let value = number(&told, &goal.key).filter(|_| resolved(summary)).unwrap_or(f64::NAN);
                row.push(value);
                cost += goal.miss(value).map_or(BROKEN, |miss| (miss / goal.per).powi(2)).min(BROKEN);
            }
            row.push(f64::from(summary.status as u8));
            cost += broken(summary, scenario.spec.flight.duration_s);
            ends.push((summary.distance_x_m, summary.distance_y_m));
        }
        let apart = apart(&ends);
        if let Some(most) = self.spec.ends_within_m {
            cost +=
                if apart.is_nan() { BROKEN } else { ((apart - most).max(0.0) / most).powi(2).min(BROKEN) };
        }
        row.extend([apart, cost]);
        Ok(Some(row))
    }

    fn document(&self, values: &[f64], flight: usize) -> super::Document {
        let overrides = self.spec.flights.get(flight).map_or(&[][..], |flight| flight);
        with_all(self.sweep.with(values), overrides)
    }

    /// The scenario of the best candidate's first flight as TOML.
    ///
    /// # Errors
    /// Values that the scenario refuses.
    pub fn scenario(&self, found: &SearchFound) -> Result<String, ConfigError> {
        let values: Vec<f64> = found.values.iter().map(|(_, value)| *value).collect();
        Ok(Scenario::new(self.document(&values, 0))?.resolved)
    }
}

impl SearchFound {
    /// Of the rows of a search; none without a row.
    fn new(sweep: &Sweep, spec: &SweepSearch, record: &Record) -> Option<Self> {
        let costs = record.values("cost")?;
        let best = (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
        let at = |name: &str| record.values(name).map_or(f64::NAN, |values| values[best]);
        let flight = |number: usize| {
            let goal = |goal: &SearchGoal| {
                let value = at(&format!("flight_{number}_{}", goal.key));
                let met = goal.miss(value) == Some(0.0);
                (goal.key.clone(), Some(value).filter(|value| value.is_finite()), goal.asked(), met)
            };
            let overrides = spec.flights.get(number).cloned().unwrap_or_default();
            let status = status(at(&format!("flight_{number}_{STATUS}"))).map(Status::name);
            SearchFlight { overrides, status, goals: spec.goals.iter().map(goal).collect() }
        };
        let apart = at("ends_apart");
        Some(Self {
            candidates: costs.len(),
            best: at("run") as usize,
            cost: costs[best],
            values: sweep.spec.draws.iter().map(|draw| (draw.key.clone(), at(&draw.key))).collect(),
            flights: (0..spec.count()).map(flight).collect(),
            ends_apart_m: (spec.count() > 1 && apart.is_finite()).then_some(apart),
        })
    }
}

/// The number that `key` names in a summary, or what was held against the limit of that name.
fn number(summary: &serde_json::Value, key: &str) -> Option<f64> {
    let own = key.split('.').try_fold(summary, |value, part| value.get(part));
    let judged = || summary["judged"].as_array()?.iter().find(|judged| judged["id"] == key)?.get("value");
    own.or_else(judged)?.as_f64()
}

/// Whether a flight was flown to its end, and does not depend on its steps.
fn resolved(summary: &Summary) -> bool {
    summary.status < Status::NotResolved
}

/// What a flight costs that was not flown to its end, or is not resolved.
fn broken(summary: &Summary, duration: f64) -> f64 {
    if resolved(summary) { 0.0 } else { BROKEN * (2.0 - (summary.duration_s / duration).clamp(0.0, 1.0)) }
}

/// Largest distance between two of the points, m; 0 of one, and not a number where one of them is not known.
fn apart(ends: &[(f64, f64)]) -> f64 {
    let mut most = 0.0_f64;
    for (i, a) in ends.iter().enumerate() {
        for b in &ends[..i] {
            let apart = (a.0 - b.0).hypot(a.1 - b.1);
            most = if apart.is_nan() || apart > most { apart } else { most };
        }
    }
    most
}
