//! Orbits along a parameter.

use super::spec::{FamilySpec, TrimSpec};
use super::verdict::OrbitMeasures;
use super::{Scenario, TrimSummary};
use crate::{ConfigError, Document};
use std::ops::ControlFlow;
use wingbeat_flight::orbit::{Cycle, Failure, FoundOrbit, Point, floquet, measure, search_from};
use wingbeat_flight::simulate::{Column, Record};
use wingbeat_judge::{Judge, Status, Verdict, Warning};
use wingbeat_math::Error;
use wingbeat_ocp::plant::{Fault, Plant};

/// Columns before that of the key and those of the commands: name and unit.
const COLUMNS: [(&str, &str); 11] = [
    ("speed_m_s", "m/s"),
    ("climb_m_s", "m/s"),
    ("bank_deg", "deg"),
    ("frequency_hz", "Hz"),
    ("power_w_kg", "W/kg"),
    ("pitch_mean_deg", "deg"),
    ("stall_fraction_12", ""),
    ("stall_fraction_20", ""),
    ("least_clearance_m", "m"),
    ("largest_multiplier", ""),
    ("lift_over_weight", ""),
];
/// Keys of the course, which have columns of their own.
const COURSE: [&str; 3] = ["trim.speed_m_s", "trim.climb_m_s", "trim.bank_deg"];
/// Halvings of a step from orbit to orbit before the family ends: *choice*.
const HALVINGS: usize = 3;

/// A family to be followed.
pub(super) struct Family {
    /// The scenario without its family.
    document: Document,
    key: String,
    from: f64,
    to: f64,
    steps: usize,
}

/// Why a family ended.
#[derive(thiserror::Error, Debug)]
enum FamilyEnd {
    #[error(transparent)]
    Failure(#[from] Failure),
    #[error(transparent)]
    Refused(#[from] ConfigError),
    #[error(transparent)]
    Invalid(#[from] Error),
}

impl From<Fault> for FamilyEnd {
    fn from(fault: Fault) -> Self {
        Self::Failure(fault.into())
    }
}

/// The last orbit of a family that is being followed.
struct FamilyWalk<'f> {
    family: &'f Family,
    at: f64,
    point: Point,
    /// The orbit before it.
    before: Option<(f64, Point)>,
}

impl Family {
    /// The scenario at `value`.
    fn scenario(&self, value: f64) -> Result<Scenario, ConfigError> {
        Scenario::new(self.document.clone().set(format!("{}={value:?}", self.key)))
    }
}

impl FamilyWalk<'_> {
    /// The orbit at `value` from the last one, or along the secant of the last two.
    fn step(
        &mut self,
        value: f64,
        tell: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
    ) -> Result<(Scenario, FoundOrbit), FamilyEnd> {
        let scenario = self.family.scenario(value)?;
        let cycle = scenario.cycle()?;
        let (course, free) = scenario.asked_of_orbit(&cycle)?;
        let secant = self.before.as_ref().map(|(at, point)| {
            let ahead = (value - self.at) / (self.at - at);
            self.point.beyond(point, ahead)
        });
        let guesses = secant.into_iter().chain([self.point.clone()]);
        let mut found = Err(Failure::Stopped);
        for guess in guesses {
            let guess = if cycle.coupled(&course) { guess } else { guess.alike(&cycle) };
            found = search_from(&cycle, &course, &free, guess, tell);
            if matches!(found, Ok(_) | Err(Failure::Stopped)) {
                break;
            }
        }
        drop(cycle);
        Ok((scenario, found?))
    }

    /// The orbit at `value`, by steps halved up to `halvings` times.
    fn reach(
        &mut self,
        value: f64,
        halvings: usize,
        tell: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
    ) -> Result<(Scenario, FoundOrbit), FamilyEnd> {
        match self.step(value, tell) {
            Ok((scenario, found)) => {
                let before = std::mem::replace(&mut self.point, found.orbit.point.clone());
                self.before = Some((std::mem::replace(&mut self.at, value), before));
                Ok((scenario, found))
            }
            Err(FamilyEnd::Failure(failure)) if failure != Failure::Stopped && halvings > 0 => {
                self.reach(0.5 * (self.at + value), halvings - 1, tell)?;
                self.reach(value, halvings - 1, tell)
            }
            Err(ended) => Err(ended),
        }
    }
}

impl Scenario {
    /// The family that `spec` asks for; its last orbit's scenario is tried.
    ///
    /// # Errors
    /// [`Error::Invalid`] at `trim.family`.
    pub(super) fn family(&self, spec: &TrimSpec, family: &FamilySpec) -> Result<Family, Error> {
        let own = format!("trim.{}", family.along);
        let key = if COURSE.contains(&own.as_str()) { own } else { family.along.clone() };
        let alone = TrimSpec { family: None, search: None, ..spec.clone() };
        let alone = super::ScenarioSpec { trim: Some(alone), ..self.spec.clone() };
        let invalid = |end: &str, value: String, allowed: String| {
            Error::invalid(format!("trim.family.{end}"), value, allowed)
        };
        let refused = |error: ConfigError| invalid("along", format!("{:?}", family.along), error.to_string());
        let document = Document::value("family", &alone).map_err(refused)?;
        let from = document.number(&key).map_err(|key| {
            let allowed = format!("speed_m_s, climb_m_s, bank_deg, or {key}");
            invalid("along", format!("{:?}", family.along), allowed)
        })?;
        let asked = Family { document, key, from, to: family.to, steps: family.steps };
        let last = asked.scenario(family.to);
        let last = last
            .map_err(|e| invalid("to", family.to.to_string(), format!("what the scenario allows ({e})")))?;
        let still = last.in_still_air();
        still.map_err(|e| {
            invalid("along", format!("{:?}", family.along), format!("another key: with it {e}"))
        })?;
        if last.model.states().len() != self.model.states().len() {
            let allowed = "a key that leaves the states of the robot and its air as many as they are";
            return Err(invalid("along", format!("{:?}", family.along), allowed.into()));
        }
        Ok(asked)
    }

    /// Orbits from `found` on along `family`; where it ends before, the summary says why.
    pub(super) fn follow(
        &self,
        family: &Family,
        found: &FoundOrbit,
        tell: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
        summary: &mut TrimSummary,
    ) -> Result<Record, Error> {
        let changes = (!COURSE.contains(&family.key.as_str())).then(|| Column::new(&family.key, "", ""));
        let columns = COLUMNS.iter().map(|(name, unit)| Column::new(*name, *unit, ""));
        let columns = columns.chain(changes.clone()).chain(self.model.inputs().iter().map(Column::from));
        let mut record = Record::new(columns.collect(), family.steps + 1)?;
        let mut row = |scenario: &Scenario, value: f64, found: &FoundOrbit| -> Result<(), FamilyEnd> {
            let numbers = scenario.family_row(&scenario.cycle()?, found)?;
            let value = changes.iter().map(|_| value);
            let inputs = found.orbit.point.inputs.iter().copied();
            let row: Vec<f64> = numbers.into_iter().chain(value).chain(inputs).collect();
            record.append(&row);
            Ok(())
        };
        let mut walk = FamilyWalk { family, at: family.from, point: found.orbit.point.clone(), before: None };
        let mut ended = row(self, family.from, found).err();
        for k in 1..=family.steps {
            if ended.is_some() {
                break;
            }
            let value = family.from + (family.to - family.from) * k as f64 / family.steps as f64;
            let reached = walk.reach(value, HALVINGS, tell);
            ended = reached.and_then(|(scenario, found)| row(&scenario, value, &found)).err();
        }
        if let Some(reason) = ended {
            summary.family_ended = Some(format!("past {} = {:.6}: {reason}", family.key, walk.at));
        }
        summary.family_orbits = Some(record.rows());
        let ended = summary.family_ended.as_ref().map(|why| {
            let text = format!("the family ended before its last orbit, {why}");
            Warning::new("trim.family_ended", text).size(record.rows() as f64).key("trim.family.to")
        });
        summary.warnings.extend(ended.into_iter().chain(self.missed_by(family, &record)));
        Ok(record)
    }

    /// Warns of the orbits of a family past the limits of a periodic flight, of which the first has its own verdict.
    fn missed_by(&self, family: &Family, record: &Record) -> Option<Warning> {
        let verdicts: Vec<(usize, Verdict)> = (1..record.rows())
            .map(|row| (row, self.verdict_of_row(record, row)))
            .filter(|(_, verdict)| verdict.status > Status::Ok)
            .collect();
        let (row, first) = verdicts.first()?;
        let text = format!(
            "{} of {} orbits of the family are past limits, the first of them number {} along {}: {}",
            verdicts.len(),
            record.rows(),
            row + 1,
            family.key,
            first.reason.as_deref().unwrap_or(first.status.name())
        );
        Some(Warning::new("trim.family_limits", text).size(verdicts.len() as f64).key("trim.family"))
    }

    /// The verdict on an orbit by its [`COLUMNS`].
    fn verdict_of_row(&self, record: &Record, row: usize) -> Verdict {
        let value = |name: &str| record.values(name).map(|values| values[row]);
        let mut judge = Judge::new(&self.limits);
        let measures = OrbitMeasures {
            power_w_kg: value("power_w_kg"),
            stall_fraction_20: value("stall_fraction_20"),
            least_clearance_m: value("least_clearance_m").filter(|least| !least.is_nan()),
            largest_multiplier: value("largest_multiplier"),
            lift_over_weight: value("lift_over_weight"),
        };
        measures.hold(&self.model, &mut judge);
        judge.verdict()
    }

    /// The numbers of [`COLUMNS`].
    fn family_row(&self, cycle: &Cycle, found: &FoundOrbit) -> Result<[f64; COLUMNS.len()], Fault> {
        let (orbit, course) = (&found.orbit, &found.orbit.course);
        let (measures, modes) = (measure(cycle, orbit, &self.strip_areas())?, floquet(cycle, orbit)?);
        Ok([
            course.speed,
            course.climb,
            course.bank.to_degrees(),
            1.0 / orbit.end.duration,
            measures.cost.positive_power / self.model.mass(),
            measures.mean_angles[1].to_degrees(),
            measures.stall.sharp[0],
            measures.stall.sharp[1],
            measures.least_clearance.unwrap_or(f64::NAN),
            modes.largest(),
            measures.lift_over_weight,
        ])
    }
}
