//! Orbits along a parameter.

use super::spec::{Along, FamilySpec, TrimSpec};
use super::{Scenario, TrimSummary};
use crate::Error;
use crate::orbit::{Cycle, Failure, Found, Free, Point, floquet, measure, search_from};
use crate::plant::Plant;
use crate::simulate::{Column, Record};
use std::ops::ControlFlow;

/// Columns before those of the commands: name and unit.
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

impl Scenario {
    /// Orbits from `found` on along the parameter of `family`; where the family ends before, the summary says why.
    pub(super) fn family(
        &self,
        cycle: &Cycle,
        spec: &TrimSpec,
        family: &FamilySpec,
        found: &Found,
        tell: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
        summary: &mut TrimSummary,
    ) -> Result<Record, Error> {
        let mut columns: Vec<Column> =
            COLUMNS.iter().map(|(name, unit)| Column::new(*name, *unit, "")).collect();
        columns.extend(self.model.inputs().iter().map(Column::from));
        let mut record = Record::new(columns, family.steps + 1)?;
        let areas = self.strip_areas();
        let mut row = |found: &Found| -> Result<(), Failure> {
            let (measures, modes) = (measure(cycle, &found.orbit, &areas)?, floquet(cycle, &found.orbit)?);
            let course = &found.orbit.course;
            let numbers = [
                course.speed,
                course.climb,
                course.bank.to_degrees(),
                1.0 / found.orbit.end.duration,
                measures.power / self.model.mass(),
                measures.mean_angles[1].to_degrees(),
                measures.stalled[0],
                measures.stalled[1],
                measures.least_clearance.unwrap_or(f64::NAN),
                modes.largest(),
                measures.lift_over_weight,
            ];
            let row: Vec<f64> = numbers.into_iter().chain(found.orbit.point.inputs.iter().copied()).collect();
            record.append(&row);
            Ok(())
        };
        let mut last = found.clone();
        let mut before: Option<Point> = None;
        let mut ended = row(&last).err();
        let from = match family.along {
            Along::SpeedMS => spec.speed_m_s,
            Along::ClimbMS => spec.climb_m_s,
            Along::BankDeg => spec.bank_deg,
        };
        for k in 1..=family.steps {
            if ended.is_some() {
                break;
            }
            let value = from + (family.to - from) * k as f64 / family.steps as f64;
            let mut next = spec.clone();
            match family.along {
                Along::SpeedMS => next.speed_m_s = value,
                Along::ClimbMS => next.climb_m_s = value,
                Along::BankDeg => next.bank_deg = value,
            }
            let course = next.course();
            let free: Vec<Free> = if course.turns() {
                spec.free(&self.model, true)?
            } else {
                spec.straight().free(&self.model, false)?
            };
            // The secant of the last two orbits predicts the next.
            let point = last.orbit.point.clone();
            let guess = before.as_ref().map_or_else(|| point.clone(), |before| point.beyond(before));
            let next = search_from(cycle, &course, &free, guess, tell)
                .or_else(|failure| match failure {
                    Failure::Stopped => Err(failure),
                    _ => search_from(cycle, &course, &free, point.clone(), tell),
                })
                .and_then(|found| row(&found).map(|()| found));
            match next {
                Ok(found) => {
                    before = Some(point);
                    last = found;
                }
                Err(failure) => ended = Some(failure),
            }
        }
        if let Some(failure) = ended {
            summary.family_ended = Some(failure.to_string());
        }
        summary.family_orbits = Some(record.rows());
        Ok(record)
    }
}
