//! The shipped turns and changes of speed under law `lev3d`, which no gait was made for.

use std::ops::ControlFlow;

use wingbeat::parallel;
use wingbeat::scenario::Summary;

use crate::shipped::{Shipped, scenario};
use crate::{CaseWatch, ComparisonRow, Error};

/// The flights.
const FLIGHTS: [Shipped; 20] = [
    "bank15_20g",
    "bank30_20g",
    "bank45_20g",
    "bank15_beta",
    "bank30_beta",
    "bank45_beta",
    "linkage_bank15",
    "linkage_bank30",
    "passive_bank15",
    "passive_bank15_20g",
    "passive_bank30_20g",
    "climb",
    "dive_pullout",
    "decelerate",
    "bank15_20g_lev",
    "bank30_20g_lev",
    "bank45_20g_lev",
    "bank15_beta_lev",
    "bank30_beta_lev",
    "bank45_beta_lev",
];

/// How a refusal ends that says that the gait has no orbit within the command ranges.
const NO_ORBIT: &str = "the gait has an orbit";

/// What the flight under its own law or under the `other` came to; None where its gait has no orbit.
///
/// # Errors
/// What is refused otherwise.
pub fn flown(of: Shipped, other: bool) -> Result<Option<Summary>, Error> {
    let built = scenario(of, if other { &["aero.law=lev3d"] } else { &[] });
    let summary = built.and_then(|scenario| Ok(scenario.fly(|_| ControlFlow::Continue(()))?.summary));
    match summary {
        Err(error) if other && error.to_string().contains(NO_ORBIT) => Ok(None),
        summary => summary.map(Some),
    }
}

/// Power and clearance of each flight under its own law and under `lev3d`; none where they were ended.
pub fn rows(watch: &mut CaseWatch<'_>) -> Result<Vec<ComparisonRow>, Error> {
    let jobs: Vec<(Shipped, bool)> =
        FLIGHTS.into_iter().flat_map(|of| [false, true].map(|other| (of, other))).collect();
    let mut told: Vec<Result<Vec<ComparisonRow>, Error>> = jobs.iter().map(|_| Ok(Vec::new())).collect();
    let mut flow = watch(0, jobs.len());
    let mut done = 0;
    if flow.is_continue() {
        parallel::each(
            &jobs,
            |_, job| flown(job.0, job.1),
            |at, found| {
                let (of, other) = jobs[at];
                told[at] = found.map(|summary| rows_of(of, other, summary.as_ref()));
                done += 1;
                flow = watch(done, jobs.len());
                flow
            },
        );
    }
    match flow {
        ControlFlow::Break(()) => Ok(Vec::new()),
        ControlFlow::Continue(()) => Ok(told.into_iter().collect::<Result<Vec<_>, _>>()?.concat()),
    }
}

/// The rows of one flight.
fn rows_of(of: Shipped, other: bool, summary: Option<&Summary>) -> Vec<ComparisonRow> {
    let (law, under) = if other { ("lev3d", "law lev3d") } else { ("own", "its own law") };
    let row = |end: &str, metric: &str, value: f64, unit| {
        let metric = format!("{metric} under {under}");
        ComparisonRow::shown(
            &format!("flight.laws.{of}.{law}.{end}"),
            "the flight itself",
            &metric,
            value,
            unit,
        )
    };
    let Some(summary) = summary else {
        return vec![row("orbits", "orbits within the command ranges", 0.0, "")];
    };
    let power = summary.cost.positive_power_w_kg.unwrap_or(f64::NAN);
    let least = summary.least_clearance_m.unwrap_or(f64::NAN);
    vec![row("power", "mean positive power", power, "W/kg"), row("clearance", "least clearance", least, "m")]
}
