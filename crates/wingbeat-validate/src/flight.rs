//! Flight under control about orbits: the shipped scenarios keep their height, hold their bank, and no wing passes
//! through another.

mod adaptation;
mod dive;
pub mod draws;
mod dryden;
mod estimator;
mod hover;
pub mod laws;
mod path;
mod reorientation;

use std::ops::ControlFlow;

use wingbeat::orbit::SKIN;
use wingbeat::scenario::Run;
use wingbeat::simulate::Record;

use crate::shipped::{Shipped, scenario};
use crate::{Case, ComparisonRow, Error, LongCase};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "flight.bank15_20g", quick: true, run: || flown("bank15_20g", 5e-3, 15.0) },
    Case { id: "flight.bank30_20g", quick: false, run: || flown("bank30_20g", 10e-3, 30.0) },
    Case { id: "flight.bank45_20g", quick: false, run: || flown("bank45_20g", 30e-3, 45.0) },
    Case { id: "flight.bank15_20g_lev", quick: false, run: || flown("bank15_20g_lev", 5e-3, 15.0) },
    Case { id: "flight.bank30_20g_lev", quick: false, run: || flown("bank30_20g_lev", 10e-3, 30.0) },
    Case { id: "flight.bank45_20g_lev", quick: false, run: || flown("bank45_20g_lev", 30e-3, 45.0) },
    Case { id: "flight.any_air_bank15_beta", quick: false, run: || flown("any_air_bank15_beta", 5e-3, 15.0) },
    Case { id: "flight.any_air_bank30_20g", quick: false, run: || flown("any_air_bank30_20g", 10e-3, 30.0) },
    Case { id: "flight.bank15_beta", quick: false, run: || flown("bank15_beta", 5e-3, 15.0) },
    Case { id: "flight.bank30_beta", quick: false, run: || flown("bank30_beta", 10e-3, 30.0) },
    Case { id: "flight.bank45_beta", quick: false, run: || flown("bank45_beta", 30e-3, 45.0) },
    Case { id: "flight.bank15_beta_lev", quick: false, run: || flown("bank15_beta_lev", 5e-3, 15.0) },
    Case { id: "flight.bank30_beta_lev", quick: false, run: || flown("bank30_beta_lev", 10e-3, 30.0) },
    Case { id: "flight.bank45_beta_lev", quick: false, run: || flown("bank45_beta_lev", 30e-3, 45.0) },
    Case { id: "flight.linkage_bank15", quick: false, run: || flown("linkage_bank15", 5e-3, 15.0) },
    Case { id: "flight.linkage_bank30", quick: false, run: || flown("linkage_bank30", 15e-3, 30.0) },
    Case { id: "flight.passive_bank15", quick: false, run: || flown("passive_bank15", 5e-3, 15.0) },
    Case { id: "flight.passive_bank15_20g", quick: false, run: || flown("passive_bank15_20g", 5e-3, 15.0) },
    Case { id: "flight.passive_bank30_20g", quick: false, run: || flown("passive_bank30_20g", 10e-3, 30.0) },
    Case { id: "flight.climb", quick: false, run: || flown("climb", 30e-3, 0.0) },
    Case { id: "flight.dive_pullout", quick: false, run: || flown("dive_pullout", 30e-3, 0.0) },
    Case { id: "flight.dive_45_20g", quick: false, run: dive::rows },
    Case { id: "flight.decelerate", quick: false, run: || flown("decelerate", 25e-3, 0.0) },
    Case { id: "flight.predictive_20g", quick: true, run: || flown("predictive_20g", 30e-3, 45.0) },
    Case { id: "flight.path_figure8", quick: false, run: || path::rows(path::EIGHT) },
    Case { id: "flight.predictive_figure8", quick: false, run: || path::rows(path::PLANNED) },
    Case { id: "flight.hover_guarded", quick: false, run: hover::rows },
    Case { id: "flight.dryden", quick: true, run: dryden::rows },
    Case { id: "flight.adaptation", quick: false, run: adaptation::rows },
    Case { id: "flight.estimator", quick: true, run: estimator::rows },
    Case { id: "flight.reorientation", quick: false, run: reorientation::rows },
];

/// Those that fly a shipped sweep whole.
pub const LONG: &[LongCase] = &[
    LongCase {
        id: "flight.draws.level_20g",
        core_minutes: 1.9,
        run: |watch| draws::rows(&draws::LEVEL, watch),
    },
    LongCase {
        id: "flight.draws.bank15_20g",
        core_minutes: 1.9,
        run: |watch| draws::rows(&draws::BANK15, watch),
    },
    LongCase {
        id: "flight.draws.any_air_bank30_20g",
        core_minutes: 6.0,
        run: |watch| draws::rows(&draws::ANY_AIR_BANK30, watch),
    },
    LongCase {
        id: "flight.draws.any_air_bank15_beta",
        core_minutes: 6.0,
        run: |watch| draws::rows(&draws::ANY_AIR_BETA, watch),
    },
    LongCase {
        id: "flight.draws.any_air_level_20g",
        core_minutes: 6.0,
        run: |watch| draws::rows(&draws::ANY_AIR_LEVEL, watch),
    },
    LongCase {
        id: "flight.draws.launch_20g",
        core_minutes: 1.5,
        run: |watch| draws::rows(&draws::LAUNCH, watch),
    },
    LongCase {
        id: "flight.draws.land_20g",
        core_minutes: 3.0,
        run: |watch| draws::rows(&draws::LAND, watch),
    },
    LongCase {
        id: "flight.draws.passive_level_20g",
        core_minutes: 3.0,
        run: |watch| draws::rows(&draws::PASSIVE_LEVEL, watch),
    },
    LongCase {
        id: "flight.draws.passive_bank15_20g",
        core_minutes: 3.0,
        run: |watch| draws::rows(&draws::PASSIVE_BANK15, watch),
    },
    LongCase {
        id: "flight.draws.path_figure8",
        core_minutes: 4.0,
        run: |watch| draws::rows(&draws::FIGURE8, watch),
    },
    LongCase { id: "flight.laws", core_minutes: 5.0, run: laws::rows },
];

/// Largest difference of roll from what is asked, deg: of its mean at the end, and as root mean square all through the turn.
const ROLL_WITHIN: f64 = 1.0;
/// Largest share of commands at a limit.
const SATURATED: f64 = 0.05;

/// A shipped scenario from the begin of its first leg on: largest error of the height, m, and the mean roll of the last
/// second, deg; of straight flight, which symmetry keeps level, nothing is asked.
fn flown(of: Shipped, height: f64, roll_deg: f64) -> Result<Vec<ComparisonRow>, Error> {
    let scenario = scenario(of, &[])?;
    let Run { record, summary, .. } = scenario.fly(|_| ControlFlow::Continue(()))?;
    let column = |name: &str| values(&record, name);
    let (t, legs) = (column("t")?, column("orbit_legs")?);
    let first = legs.partition_point(|legs| *legs == 0.0);
    let off = column("orbit_height_error")?[first..].iter().fold(0.0, |most: f64, e| most.max(e.abs()));
    let last = t.partition_point(|at| *at < t[t.len() - 1] - 1.0);
    let roll = &column("roll")?[last..];
    let mean = roll.iter().sum::<f64>().to_degrees() / roll.len() as f64;
    let (id, source) = (format!("flight.{of}"), "what is asked of the flight");
    let least = summary.least_clearance_m.unwrap_or(f64::NAN);
    let row = |end: &str, metric: &str, value: f64, limit: f64, unit| {
        ComparisonRow::judged(&format!("{id}.{end}"), source, metric, value, limit, unit)
    };
    let saturated = summary.input_saturation_fraction;
    let mut rows = vec![
        row("height", "largest error of the height from the first leg on", off, height, "m"),
        row("saturated", "share of commands at a limit", saturated, SATURATED, ""),
        row("clearance", "3 mm of skin less the least clearance", SKIN - least, 0.0, "m"),
    ];
    if roll_deg != 0.0 {
        let off = (mean - roll_deg).abs();
        rows.push(row("roll", "mean roll of the last second less that asked", off, ROLL_WITHIN, "deg"));
        let errors = &column("orbit_roll_error")?[first..];
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt().to_degrees();
        let metric = "root mean square of roll less that of the reference, from the first leg on";
        rows.push(row("roll_rms", metric, rms, ROLL_WITHIN, "deg"));
    }
    Ok(rows)
}

fn values<'a>(record: &'a Record, name: &str) -> Result<&'a [f64], Error> {
    record.values(name).ok_or_else(|| Error::reference("record", format!("no column {name}")))
}
