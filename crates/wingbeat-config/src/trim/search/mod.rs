//! Search of gaits: the one that flies the orbit that `[trim]` asks for on the least power, at the lowest frequency or
//! with the largest payload.

pub(crate) mod descent;
mod gaits;
pub(crate) mod quadratic;
mod spec;

pub use descent::Ended;
pub use spec::{Goal, LimitsSpec, SearchSpec, VarySpec};

use super::super::sweep::with_all;
use super::super::{ConfigError, Document, Scenario, written};
use super::{TrimProgress, Trimmed};
use descent::{Descent, DescentPoint, KEPT, descend};
use gaits::{Gait, Gaits};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use wingbeat_flight::orbit::Point;
use wingbeat_flight::simulate::{Column, Record};
use wingbeat_judge::{Status, Warning};
use wingbeat_math::Error;
use wingbeat_math::Random;
use wingbeat_math::order::filled;

/// Columns of a start before those of the varied numbers, with their units.
const COLUMNS: [(&str, &str); 14] = [
    ("start", ""),
    ("ended", ""),
    ("kept", ""),
    ("iterations", ""),
    ("violation", ""),
    ("objective", ""),
    ("frequency_hz", "Hz"),
    ("speed_m_s", "m/s"),
    ("power_w_kg", "W/kg"),
    ("stall_fraction_12", ""),
    ("stall_fraction_20", ""),
    ("least_clearance_m", "m"),
    ("largest_multiplier", ""),
    ("mass_kg", "kg"),
];
/// Halvings of a start's distance from the scenario's own gait until there is an orbit.
const HALVINGS: usize = 6;
/// Objectives closer than this, relative, count as one minimum.
const ALIKE: f64 = 1e-3;

/// What a search tells on the way.
#[derive(Clone, Copy, Debug)]
pub struct SearchProgress {
    /// Start, from 0.
    pub start: usize,
    /// Iteration, from 1.
    pub iteration: usize,
    /// Power over the mass, W/kg.
    pub power_w_kg: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Worst limit missed, as a ratio to its scale.
    pub violation: f64,
}

/// What `summary.json` says of a search.
#[derive(Clone, Debug, Serialize)]
pub struct SearchSummary {
    /// What was to be best.
    pub goal: Goal,
    /// Number of starts.
    pub starts: usize,
    /// Starts whose gait keeps to the limits.
    pub kept: usize,
    /// Minima among them: objectives that differ by more than a thousandth, of starts that ended at one.
    pub minima: usize,
    /// Number of the best start, from 0.
    pub best: usize,
    /// How it ended.
    pub ended: &'static str,
    /// Its iterations: steps that were tried, also those that were refused.
    pub iterations: usize,
    /// The worst limit that it misses, in its scale: 10 mm of clearance, .1 of a share or a multiplier, .025 of the range of a
    /// command, the frequency, the power.
    pub violation: f64,
    /// Least clearance in the scenario's own air and strips, `airs` and `strips`, m; missing without two parts that can meet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_clearance_m: Option<f64>,
    /// The varied numbers, by their keys and in the units of these.
    pub values: BTreeMap<String, f64>,
}

/// A search of gaits of a scenario, ready to be made start by start.
pub struct GaitSearch<'a> {
    scenario: &'a Scenario,
    spec: &'a SearchSpec,
    gaits: Gaits<'a>,
    /// Shares of the scenario's own gait, and its orbit.
    own: Vec<f64>,
    first: DescentPoint<Gait>,
}

/// A search that was made.
#[derive(Debug)]
pub struct Searched {
    /// A row for each start, in their order.
    pub starts: Record,
    /// The scenario of the best gait, on its orbit.
    pub best: Scenario,
    /// What the search came to.
    pub summary: SearchSummary,
}

impl Searched {
    /// Trims the best gait; with the table of the starts, and the robot with its gait as `robot.toml`.
    ///
    /// # Errors
    /// A setting that is out of range.
    pub fn trim(
        self,
        observe: &mut dyn FnMut(TrimProgress) -> ControlFlow<()>,
    ) -> Result<Trimmed, ConfigError> {
        let Self { starts, best, summary: search } = self;
        let mut trimmed = best.trim(observe)?;
        let robot = written::toml(&best.spec.robot)
            .map_err(|error| best.explain(&Error::invalid("robot", error, "a robot that TOML can hold")))?;
        trimmed.files.push(("robot.toml", robot));
        trimmed.starts = Some(starts);
        let summary = &mut trimmed.summary;
        if search.kept == 0 && summary.status < Status::NotFound {
            let missed = format!(
                "no gait keeps to trim.search.limits; the nearest misses one by {:.4} of its scale, {}",
                search.violation, search.ended
            );
            summary.status = summary.status.max(Status::OffTarget);
            summary.reason =
                Some(summary.reason.iter().cloned().chain([missed]).collect::<Vec<_>>().join("; "));
        }
        summary.warnings.extend(ended_early(search.ended, search.iterations));
        summary.hold_elsewhere(best.limits(), search.least_clearance_m);
        summary.search = Some(search);
        Ok(trimmed)
    }
}

/// The warning that a search which ended so, in words, after so many iterations need not have found a minimum.
pub(super) fn ended_early(ended: &str, iterations: usize) -> Option<Warning> {
    let ended = Ended::ALL.into_iter().find(|of| ended == of.words());
    let (how, key) = match ended? {
        Ended::IterationLimit => (format!("used up its {iterations} iterations"), "trim.search.iterations"),
        Ended::NoSlopes => {
            let text = format!(
                "ended after {iterations} iterations, as beside its last gait one has no orbit, or the scenario refuses its values"
            );
            (text, "trim.search.vary")
        }
        Ended::Converged | Ended::NoStep => return None,
    };
    let text = format!("the search {how}, so that its gait need not be a minimum");
    Some(Warning::new("trim.search_ended", text).size(iterations as f64).key(key))
}

impl Scenario {
    /// The search that `[trim.search]` asks for; none where there is none.
    ///
    /// # Errors
    /// A key that the scenario does not know, or refuses; no orbit of the scenario's own gait.
    pub fn gait_search(&self) -> Result<Option<GaitSearch<'_>>, ConfigError> {
        let Some(spec) = self.spec.trim.as_ref().and_then(|trim| trim.search.as_ref()) else {
            return Ok(None);
        };
        let mut alone = self.spec.clone();
        alone.trim.iter_mut().for_each(|trim| trim.search = None);
        let document = Document::value("gait", &alone)?;
        let mut own = Vec::with_capacity(spec.vary.len());
        for (i, vary) in spec.vary.iter().enumerate() {
            let place = document.numbered(&vary.key);
            if spec.vary[..i].iter().any(|other| document.numbered(&other.key) == place) {
                let key = format!("trim.search.vary[{i}].key");
                return Err(self.explain(&Error::invalid(key, &vary.key, "each key once")));
            }
            own.push(self.own_share(&document, i, vary)?);
        }
        if spec.goal == Goal::Payload && !self.varies_mass(&document, &spec.vary) {
            let keys = spec.vary.iter().map(|vary| vary.key.as_str()).collect::<Vec<_>>().join(", ");
            let allowed = "a key among them that changes the mass, as trim.search.goal = payload asks for: robot.body.mass_kg";
            return Err(self.explain(&Error::invalid("trim.search.vary", keys, allowed)));
        }
        for (i, air) in spec.airs.iter().enumerate() {
            Self::new(with_all(document.clone(), air)).map_err(|error| {
                let allowed = format!("keys and values of the scenario ({error})");
                self.explain(&Error::invalid(format!("trim.search.airs[{i}]"), air.join(", "), allowed))
            })?;
        }
        let mut gaits = Gaits::new(spec, document);
        match gaits.first(&own) {
            Ok(first) => Ok(Some(GaitSearch { scenario: self, spec, gaits, own, first })),
            Err(reason) => {
                let allowed =
                    format!("one that begins at a gait with an orbit; the robot's own has none: {reason}");
                Err(self.explain(&Error::invalid("trim.search", "a search", allowed)))
            }
        }
    }

    /// Whether one of the numbers that are varied changes the mass of the robot between the ends of its range.
    fn varies_mass(&self, document: &Document, vary: &[VarySpec]) -> bool {
        let mass = |key: &str, at: f64| {
            Self::new(document.clone().set(format!("{key}={at:?}"))).map(|scenario| scenario.model().mass())
        };
        vary.iter().any(|vary| matches!((mass(&vary.key, vary.low), mass(&vary.key, vary.high)), (Ok(a), Ok(b)) if a != b))
    }

    /// The share of its range at which a varied number stands; both ends are tried.
    fn own_share(&self, document: &Document, i: usize, vary: &VarySpec) -> Result<f64, ConfigError> {
        let refused = |end: &str, value: String, allowed: String| {
            self.explain(&Error::invalid(format!("trim.search.vary[{i}].{end}"), value, allowed))
        };
        let key = format!("{:?}", vary.key);
        let value = document.number(&vary.key).map_err(|allowed| refused("key", key, allowed))?;
        for (end, at) in [("low", vary.low), ("high", vary.high)] {
            let tried = Self::new(document.clone().set(format!("{}={at:?}", vary.key)));
            if let Err(error) = tried {
                return Err(refused(end, at.to_string(), format!("what the scenario allows ({error})")));
            }
        }
        if value < vary.low || value > vary.high {
            let end = if value < vary.low { "low" } else { "high" };
            let given = if value < vary.low { vary.low } else { vary.high };
            return Err(refused(
                end,
                given.to_string(),
                format!("a range that holds the scenario's own {value}"),
            ));
        }
        Ok(vary.share(value))
    }
}

impl GaitSearch<'_> {
    /// The columns of a row, still empty.
    pub fn columns(&self) -> Vec<Column> {
        let varied = self.spec.vary.iter().map(|vary| Column::new(vary.key.clone(), "", ""));
        COLUMNS.iter().map(|(name, unit)| Column::new(*name, *unit, "")).chain(varied).collect()
    }

    /// Whether `row`, in the units of its columns, can be that of a start of the search.
    pub fn has_row(&self, row: &[f64]) -> bool {
        row.len() == COLUMNS.len() + self.spec.vary.len() && row[0] >= 0.0 && row[0] < self.spec.starts as f64
    }

    /// Number of starts.
    pub fn starts(&self) -> usize {
        self.spec.starts
    }

    /// Searches from the starts of which there is no row in `rows` (in the units of the columns); `keep` gets the row of each
    /// as soon as it is known. None where `tell` stopped it.
    ///
    /// # Errors
    /// What `keep` says; a start, or a best gait, without an orbit.
    pub fn all<E: From<ConfigError>>(
        &self,
        mut rows: Vec<Vec<f64>>,
        keep: &mut dyn FnMut(&[f64]) -> Result<(), E>,
        tell: &mut dyn FnMut(SearchProgress) -> ControlFlow<()>,
    ) -> Result<Option<Searched>, E> {
        let refused = |what: String, allowed: &str| {
            E::from(self.scenario.explain(&Error::invalid("trim.search", what, allowed)))
        };
        let mut orbits = Vec::new();
        for start in 0..self.starts() {
            if rows.iter().any(|row| row[0] == start as f64) {
                continue;
            }
            let mut stopped = false;
            let descent = self.descent(start, &mut |at| {
                let flow = tell(at);
                stopped |= flow.is_break();
                flow
            });
            match descent {
                Some(descent) => {
                    let row = self.told(start, &descent);
                    keep(&row)?;
                    rows.push(row);
                    orbits.push((start, descent.seen));
                }
                None if stopped => return Ok(None),
                None => return Err(refused(format!("start {start}"), "a start beside a gait with an orbit")),
            }
        }
        wingbeat_math::order::ascend_by(&mut rows, |item| item[0]);
        let mut starts = Record::new(self.columns(), rows.len())
            .map_err(|error| E::from(self.scenario.explain(&error)))?;
        rows.iter().for_each(|row| starts.append(row));
        let (best, summary) =
            self.best_of(&starts, &orbits).map_err(|reason| refused(reason, "a best gait with an orbit"))?;
        Ok(Some(Searched { starts, best, summary }))
    }

    /// Searches from start `start`: a row in the units of its columns, a pure function of the scenario and the number. `tell`
    /// may stop it; then there is no row.
    pub fn row(
        &self,
        start: usize,
        tell: &mut dyn FnMut(SearchProgress) -> ControlFlow<()>,
    ) -> Option<Vec<f64>> {
        Some(self.told(start, &self.descent(start, tell)?))
    }

    /// The descent from start `start`.
    fn descent(
        &self,
        start: usize,
        tell: &mut dyn FnMut(SearchProgress) -> ControlFlow<()>,
    ) -> Option<Descent<Gait>> {
        let (x, seen) = self.begin(start)?;
        descend(&self.gaits, x, seen, self.spec.iterations, &mut |iteration, seen| {
            let facts = &seen.more.facts;
            tell(SearchProgress {
                start,
                iteration,
                power_w_kg: facts.power_per_mass,
                frequency_hz: facts.frequency,
                violation: seen.violation(),
            })
        })
    }

    /// Where start `start` begins: beside the own gait, as near as it needs to be for an orbit.
    fn begin(&self, start: usize) -> Option<(Vec<f64>, DescentPoint<Gait>)> {
        let mut random = Random::stream(self.spec.seed, start as u64);
        let spread = if start == 0 { 0.0 } else { self.spec.spread };
        let beside: Vec<f64> = self.own.iter().map(|_| spread * random.between(-1.0, 1.0)).collect();
        (0..=HALVINGS).find_map(|k| {
            let share = if k == HALVINGS { 0.0 } else { 0.5f64.powi(k as i32) };
            let x: Vec<f64> =
                self.own.iter().zip(&beside).map(|(own, by)| (own + share * by).clamp(0.0, 1.0)).collect();
            let seen = self.gaits.reached(&x, &self.own, &self.first).ok()?;
            Some((x, seen))
        })
    }

    /// The orbit at the shares `x`, to which the descent from `start` came with this objective: that it found, of those `made`, else the
    /// one to which the scenario's own leads, or the descent made again where that is no such orbit.
    fn orbit(
        &self,
        (start, objective): (usize, f64),
        x: &[f64],
        made: &[(usize, DescentPoint<Gait>)],
    ) -> Result<(Point, Vec<String>), String> {
        let own = |seen: &DescentPoint<Gait>| (seen.more.points[0].clone(), seen.more.free[0].clone());
        if let Some((_, seen)) = made.iter().find(|(number, _)| *number == start) {
            return Ok(own(seen));
        }
        let again = |reason: String| {
            let descent = self.descent(start, &mut |_| ControlFlow::Continue(()));
            descent.map(|descent| own(&descent.seen)).ok_or(reason)
        };
        match self.gaits.reached(x, &self.own, &self.first) {
            Ok(seen) if (seen.objective - objective).abs() <= ALIKE * objective.abs() => Ok(own(&seen)),
            Ok(_) => again("another orbit is found".into()),
            Err(reason) => again(reason),
        }
    }

    fn told(&self, start: usize, descent: &Descent<Gait>) -> Vec<f64> {
        let Descent { x, seen, iterations, ended } = descent;
        let facts = &seen.more.facts;
        let violation = seen.violation();
        let ended = Ended::ALL.iter().position(|e| e == ended).unwrap_or(Ended::ALL.len());
        let numbers = [
            start as f64,
            ended as f64,
            f64::from(u8::from(violation <= KEPT && facts.stalled_beyond <= 0.0)),
            *iterations as f64,
            violation,
            seen.objective,
            facts.frequency,
            facts.speed,
            facts.power_per_mass,
            facts.stalled[0],
            facts.stalled[1],
            facts.clearance,
            facts.multiplier,
            facts.mass,
        ];
        let varied = self.spec.vary.iter().zip(x).map(|(vary, x)| vary.at(*x));
        numbers.into_iter().chain(varied).collect()
    }

    /// The best of the rows, on its orbit: the lowest objective among those that keep to the limits, else the one that
    /// misses them least.
    ///
    /// # Errors
    /// Why its orbit is not found again.
    pub fn best(&self, record: &Record) -> Result<(Scenario, SearchSummary), String> {
        self.best_of(record, &[])
    }

    /// The same, with the gaits of starts whose descent was made just now.
    fn best_of(
        &self,
        record: &Record,
        made: &[(usize, DescentPoint<Gait>)],
    ) -> Result<(Scenario, SearchSummary), String> {
        let column = |name: &str| record.values(name).unwrap_or_default();
        let (kept, objective, violation) = (column("kept"), column("objective"), column("violation"));
        let order = |i: usize| if kept[i] == 1.0 { (0, objective[i]) } else { (1, violation[i]) };
        let best = (0..record.rows())
            .min_by(|&a, &b| order(a).0.cmp(&order(b).0).then(order(a).1.total_cmp(&order(b).1)))
            .ok_or("no start")?;
        let values: Vec<f64> = record.columns()[COLUMNS.len()..].iter().map(|c| c.values[best]).collect();
        let x: Vec<f64> = self.spec.vary.iter().zip(&values).map(|(vary, v)| vary.share(*v)).collect();
        let start = column("start")[best] as usize;
        let (point, free) = self.orbit((start, objective[best]), &x, made)?;
        let mut scenario = self.gaits.scenario(0, &x)?;
        scenario.spec.trim.iter_mut().for_each(|trim| trim.free.clone_from(&free));
        let cycle = scenario.cycle().map_err(|error| error.to_string())?;
        let end = cycle.end(&point).map_err(|fault| fault.to_string())?;
        let spec = scenario.on_orbit(&cycle, &point, end.duration);
        let document = Document::value("gait", &spec).map_err(|error| error.to_string())?;
        let good = || (0..record.rows()).filter(|&i| kept[i] == 1.0);
        let ended = |i: usize| Ended::ALL.get(column("ended")[i] as usize).copied();
        let is_minimum = |i: &usize| ended(*i).is_some_and(Ended::is_minimum);
        let mut least: Vec<f64> = good().filter(is_minimum).map(|i| objective[i]).collect();
        wingbeat_math::order::ascend(&mut least);
        let apart = |pair: &[f64]| pair[1] - pair[0] > ALIKE * pair[0].abs().max(pair[1].abs());
        let summary = SearchSummary {
            goal: self.spec.goal,
            starts: record.rows(),
            kept: good().count(),
            minima: usize::from(!least.is_empty()) + least.windows(2).filter(|pair| apart(pair)).count(),
            best: start,
            ended: ended(best).map_or("", Ended::words),
            iterations: column("iterations")[best] as usize,
            violation: violation[best],
            least_clearance_m: Some(column("least_clearance_m")[best]).filter(|least| least.is_finite()),
            values: filled(self.spec.vary.iter().zip(values).map(|(vary, v)| (vary.key.clone(), v))),
        };
        Ok((Scenario::new(document).map_err(|error| error.to_string())?, summary))
    }
}
