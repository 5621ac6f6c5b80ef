//! What is kept of each run of a sweep.

use super::{ConfigError, Hold, ReadTable, Summary, Sweep, SweepOf};
use crate::simulate::{Column, Ending};
use crate::tether::TetherRun;
use std::ops::ControlFlow;

/// Columns of a flight beside its number and its draws, with their units.
const FLIGHT: [(&str, &str); 14] = [
    ("held", ""),
    ("completed", ""),
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
    ("controller_failures", ""),
];

/// Columns of a run of a tethered wing beside its number and its draws, with their units.
const CASE: [(&str, &str); 9] = [
    ("completed", ""),
    ("mean_lift", "N"),
    ("mean_thrust", "N"),
    ("peak_lift", "N"),
    ("mean_power", "W"),
    ("peak_power", "W"),
    ("propulsive_efficiency", ""),
    ("stall_fraction", ""),
    ("periodicity", ""),
];

impl SweepOf {
    /// Columns beside the number of a run and its draws, with their units.
    pub fn measures(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Flights(_) => &FLIGHT,
            Self::Cases => &CASE,
        }
    }
}

impl Sweep {
    /// The columns of a row, still empty: number of the run, its draws, its measures.
    pub fn columns(&self) -> Vec<Column> {
        let draws = self.spec.draws.iter().map(|draw| Column::new(draw.key.clone(), "", ""));
        let measures = self.of.measures().iter().map(|(name, unit)| Column::new(*name, *unit, ""));
        std::iter::once(Column::new("run", "", "")).chain(draws).chain(measures).collect()
    }

    /// Makes run `run`: a pure function of the sweep and the number. `watch` may stop it; then there is no row.
    ///
    /// # Errors
    /// A drawn key that the scenario or case does not know, or refuses.
    pub fn row(
        &self,
        run: usize,
        read: ReadTable,
        watch: impl Fn() -> ControlFlow<()>,
    ) -> Result<Option<Vec<f64>>, ConfigError> {
        let measures: Vec<f64> = match self.of {
            SweepOf::Flights(hold) => {
                let mut scenario = self.scenario(run)?;
                self.shared.give(&mut scenario);
                let flown = scenario.fly(|_| watch()).map_err(|error| scenario.explain(&error))?;
                flight(&flown.summary, hold).into()
            }
            SweepOf::Cases => case(&self.case(run, read)?.tether.run(|_| watch())).into(),
        };
        Ok(watch().is_continue().then(|| [vec![run as f64], self.values(run), measures].concat()))
    }

    /// Whether `row` is that of a run of the sweep: its number and its draws.
    pub fn has_row(&self, row: &[f64]) -> bool {
        let draws = self.spec.draws.len();
        let run = row.first().copied().unwrap_or(f64::NAN);
        row.len() == 1 + draws + self.of.measures().len()
            && run.fract() == 0.0
            && (0.0..self.runs() as f64).contains(&run)
            && self.values(run as usize) == row[1..=draws]
    }
}

fn flight(summary: &Summary, hold: Hold) -> [f64; FLIGHT.len()] {
    let of = |value: Option<f64>| value.unwrap_or(f64::NAN);
    [
        f64::from(u8::from(hold.met(summary))),
        f64::from(u8::from(summary.completed())),
        f64::from(u8::from(hold.clear(summary))),
        of(summary.roll_max_error_deg),
        of(summary.pitch_max_error_deg),
        of(summary.roll_mean_deg),
        of(summary.pitch_mean_deg),
        summary.distance_x_m,
        summary.distance_y_m,
        summary.altitude_change_m,
        of(summary.height_max_error_m),
        of(summary.path.as_ref().map(|path| path.cross_rms_m)),
        of(summary.least_clearance_m),
        summary.controller.failures as f64,
    ]
}

fn case(run: &TetherRun) -> [f64; CASE.len()] {
    let completed = run.ending == Ending::Complete;
    let row = |name: &str| run.means.iter().find(|row| row.name == name && completed);
    let mean = |name: &str| row(name).map_or(f64::NAN, |row| row.mean);
    let peak = |name: &str| row(name).map_or(f64::NAN, |row| row.high);
    [
        f64::from(u8::from(completed)),
        mean("force_wind_lift"),
        mean("thrust"),
        peak("force_wind_lift"),
        mean("power"),
        peak("power"),
        run.efficiency.filter(|_| completed).unwrap_or(f64::NAN),
        if completed { run.stall_fraction } else { f64::NAN },
        run.periodicity.as_ref().filter(|_| completed).map_or(f64::NAN, |periodicity| periodicity.change),
    ]
}
