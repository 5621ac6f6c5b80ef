//! What is kept of each run of a sweep.

use super::document::unit;
use super::measure::measures;
use super::side_by_side::MOST;
use super::{ConfigError, Hold, ReadTable, Scenario, Summary, Sweep, SweepOf};
use std::ops::ControlFlow;
use wingbeat_flight::simulate::{Column, Ending};
use wingbeat_flight::tether::TetherRun;
use wingbeat_judge::Verdict;

/// Columns of a flight beside its number and its draws, with their units.
const FLIGHT: [(&str, &str); 19] = [
    ("held", ""),
    ("completed", ""),
    ("status", ""),
    ("warnings", ""),
    ("clear", ""),
    ("roll_max_error", "deg"),
    ("pitch_max_error", "deg"),
    ("roll_mean", "deg"),
    ("pitch_mean", "deg"),
    ("distance_x", "m"),
    ("distance_y", "m"),
    ("altitude_change", "m"),
    ("height_max_error", "m"),
    ("cross_rms", "m"),
    ("least_clearance", "m"),
    ("positive_power", "W/kg"),
    ("controller_failures", ""),
    ("perch_caught", ""),
    ("perch_clearance", "m"),
];

/// Columns of a run of a tethered wing beside its number and its draws, with their units.
const CASE: [(&str, &str); 11] = [
    ("completed", ""),
    ("status", ""),
    ("warnings", ""),
    ("mean_lift", "N"),
    ("mean_thrust", "N"),
    ("peak_lift", "N"),
    ("mean_power", "W"),
    ("peak_power", "W"),
    ("propulsive_efficiency", ""),
    ("stall_fraction", ""),
    ("periodicity", ""),
];

/// Rows of a batch of runs.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepRows {
    /// One for each run, in the units of the columns; none where they were stopped.
    pub rows: Vec<Vec<f64>>,
    /// Groups in which they were made: of lanes as many as registers were filled.
    pub groups: usize,
}

impl SweepOf {
    /// Columns beside the number of a run and its draws, with their units.
    pub fn measures(self) -> Vec<(&'static str, &'static str)> {
        match self {
            Self::Flights(_) => FLIGHT.into_iter().chain(measures().filter_map(|m| m.swept)).collect(),
            Self::Cases => CASE.into(),
        }
    }
}

impl Sweep {
    /// The columns of a row, still empty: number of the run, its draws, its measures.
    pub fn columns(&self) -> Vec<Column> {
        let draws = self.draws().iter().map(|draw| Column::new(draw.key.clone(), unit(&draw.key), ""));
        let measures = self.of.measures().into_iter().map(|(name, unit)| Column::new(name, unit, ""));
        std::iter::once(Column::new("run", "", "")).chain(draws).chain(measures).collect()
    }

    /// The runs `todo` in the company in which they are made: one by one, or with `lanes` as many as are stepped at once,
    /// alike in what is drawn from lists.
    pub fn batches(&self, mut todo: Vec<usize>) -> Vec<Vec<usize>> {
        if !self.spec.lanes {
            return todo.into_iter().map(|run| vec![run]).collect();
        }
        let listed = |run: usize| -> Vec<u64> {
            let values = self.draws().iter().zip(self.values(run));
            values.filter(|(draw, _)| !draw.values.is_empty()).map(|(_, value)| value.to_bits()).collect()
        };
        todo.sort_by_cached_key(|run| listed(*run));
        let alike = todo.chunk_by(|a, b| listed(*a) == listed(*b));
        alike.flat_map(|runs| runs.chunks(MOST)).map(<[usize]>::to_vec).collect()
    }

    /// Makes the runs of a batch: each row is a pure function of the sweep and its number, whatever is made beside it. `watch`
    /// may stop them; then there are no rows.
    ///
    /// # Errors
    /// A drawn key that the scenario or case does not know, or refuses.
    pub fn rows(
        &self,
        batch: &[usize],
        read: ReadTable,
        watch: impl Fn() -> ControlFlow<()>,
    ) -> Result<SweepRows, ConfigError> {
        let (measures, groups) = match self.of {
            SweepOf::Flights(hold) => {
                let mut scenarios =
                    batch.iter().map(|run| self.scenario(*run)).collect::<Result<Vec<_>, _>>()?;
                scenarios.iter_mut().for_each(|scenario| self.shared.give(scenario));
                let (summaries, groups) = self.flown(&scenarios, &watch)?;
                let of = |summary: &Summary| flight(summary, hold);
                (summaries.iter().map(of).collect::<Vec<_>>(), groups)
            }
            SweepOf::Cases => {
                let of = |run: &usize| {
                    let case = self.case(*run, read)?;
                    let run = case.tether.run(|_| watch());
                    Ok(Vec::from(of_case(&run, &case.verdict(&run, None, None))))
                };
                (batch.iter().map(of).collect::<Result<_, ConfigError>>()?, batch.len())
            }
        };
        if watch().is_break() {
            return Ok(SweepRows { rows: Vec::new(), groups: 0 });
        }
        let row =
            |(run, measures): (&usize, Vec<f64>)| [vec![*run as f64], self.values(*run), measures].concat();
        Ok(SweepRows { rows: batch.iter().zip(measures).map(row).collect(), groups })
    }

    /// Flies scenarios one by one, or with `lanes` those at once that fit side by side; the number of groups.
    fn flown(
        &self,
        scenarios: &[Scenario],
        watch: &impl Fn() -> ControlFlow<()>,
    ) -> Result<(Vec<Summary>, usize), ConfigError> {
        // Lanes take equal steps.
        if !self.spec.lanes || scenarios.iter().any(|scenario| scenario.spec.flight.error_m.is_some()) {
            let fly = |scenario: &Scenario| {
                let flown = scenario.fly(|_| watch()).map_err(|error| scenario.explain(&error));
                flown.map(|run| run.summary)
            };
            return Ok((scenarios.iter().map(fly).collect::<Result<_, _>>()?, scenarios.len()));
        }
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (number, scenario) in scenarios.iter().enumerate() {
            let fits =
                |group: &&mut Vec<usize>| group.len() < MOST && scenarios[group[0]].fits_beside(scenario);
            match groups.iter_mut().find(fits) {
                Some(group) => group.push(number),
                None => groups.push(vec![number]),
            }
        }
        let mut summaries: Vec<Option<Summary>> = scenarios.iter().map(|_| None).collect();
        for group in &groups {
            let members: Vec<&Scenario> = group.iter().map(|number| &scenarios[*number]).collect();
            for (number, summary) in group.iter().zip(Scenario::fly_side_by_side(&members, watch)?) {
                summaries[*number] = Some(summary);
            }
        }
        Ok((summaries.into_iter().flatten().collect(), groups.len()))
    }

    /// Whether `row`, in the units of the columns, is that of a run of the sweep: its number and its draws.
    pub fn has_row(&self, row: &[f64]) -> bool {
        let draws = self.draws().len();
        let run = row.first().copied().unwrap_or(f64::NAN);
        row.len() == 1 + draws + self.of.measures().len()
            && run.fract() == 0.0
            && (0.0..self.runs() as f64).contains(&run)
            && self.values(run as usize) == row[1..=draws]
    }
}

/// A row of a flight; of one that was not flown whole nothing but how it ended.
fn flight(summary: &Summary, hold: Hold) -> Vec<f64> {
    let completed = summary.completed();
    let of = |value: Option<f64>| value.filter(|_| completed).unwrap_or(f64::NAN);
    let whole = |value: f64| of(Some(value));
    let fixed: [f64; FLIGHT.len()] = [
        hold.met(summary).map_or(f64::NAN, |held| f64::from(u8::from(held))),
        f64::from(u8::from(completed)),
        f64::from(summary.status as u8),
        summary.warnings.len() as f64,
        f64::from(u8::from(completed && hold.clear(summary))),
        of(summary.roll_max_error_deg),
        of(summary.pitch_max_error_deg),
        of(summary.roll_mean_deg),
        of(summary.pitch_mean_deg),
        whole(summary.distance_x_m),
        whole(summary.distance_y_m),
        whole(summary.altitude_change_m),
        of(summary.height_max_error_m),
        of(summary.path.as_ref().map(|path| path.cross_rms_m)),
        of(summary.least_clearance_m),
        of(summary.cost.positive_power_w_kg),
        whole(summary.controller.failures as f64),
        of(summary.perch.as_ref().map(|perch| f64::from(u8::from(perch.caught)))),
        of(summary.perch.as_ref().and_then(|perch| perch.least_clearance_m)),
    ];
    let measured = summary.measured.iter().filter(|(measure, _)| measure.swept.is_some());
    fixed.into_iter().chain(measured.map(|(_, value)| of(value))).collect()
}

fn of_case(run: &TetherRun, verdict: &Verdict) -> [f64; CASE.len()] {
    let completed = run.ending == Ending::Complete;
    let row = |name: &str| run.means.iter().find(|row| row.name == name && completed);
    let mean = |name: &str| row(name).map_or(f64::NAN, |row| row.mean);
    let peak = |name: &str| row(name).map_or(f64::NAN, |row| row.high);
    [
        f64::from(u8::from(completed)),
        f64::from(verdict.status as u8),
        verdict.warnings.len() as f64,
        mean("force_wind_lift"),
        mean("thrust"),
        peak("force_wind_lift"),
        mean("power"),
        peak("power"),
        run.efficiency.filter(|_| completed).unwrap_or(f64::NAN),
        if completed { run.stalled.stalled() } else { f64::NAN },
        run.periodicity.as_ref().filter(|_| completed).map_or(f64::NAN, |periodicity| periodicity.change),
    ]
}
