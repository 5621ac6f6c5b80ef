//! Flight under control about orbits: the shipped scenarios keep their height, hold their bank, and no wing passes
//! through another.

mod draws;
mod estimator;
mod hover;
mod path;

use std::ops::ControlFlow;

use wingbeat::orbit::SKIN;
use wingbeat::scenario::Run;
use wingbeat::simulate::Record;

use crate::shipped::{Shipped, scenario, shipped};
use crate::{Case, Error, LongCase, Row};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "flight.bank15_20g", quick: true, run: || flown(&BANK15_20G) },
    Case { id: "flight.bank30_20g", quick: false, run: || flown(&BANK30_20G) },
    Case { id: "flight.bank45_20g", quick: false, run: || flown(&BANK45_20G) },
    Case { id: "flight.bank15_20g_lev", quick: false, run: || flown(&BANK15_LEV) },
    Case { id: "flight.bank30_20g_lev", quick: false, run: || flown(&BANK30_LEV) },
    Case { id: "flight.bank45_20g_lev", quick: false, run: || flown(&BANK45_LEV) },
    Case { id: "flight.bank15_beta", quick: false, run: || flown(&BANK15_BETA) },
    Case { id: "flight.bank30_beta", quick: false, run: || flown(&BANK30_BETA) },
    Case { id: "flight.bank45_beta", quick: false, run: || flown(&BANK45_BETA) },
    Case { id: "flight.bank15_beta_lev", quick: false, run: || flown(&BANK15_BETA_LEV) },
    Case { id: "flight.bank30_beta_lev", quick: false, run: || flown(&BANK30_BETA_LEV) },
    Case { id: "flight.bank45_beta_lev", quick: false, run: || flown(&BANK45_BETA_LEV) },
    Case { id: "flight.linkage_bank15", quick: false, run: || flown(&LINKAGE15) },
    Case { id: "flight.linkage_bank30", quick: false, run: || flown(&LINKAGE30) },
    Case { id: "flight.passive_bank15", quick: false, run: || flown(&PASSIVE15) },
    Case { id: "flight.passive_bank15_20g", quick: false, run: || flown(&PASSIVE15_20G) },
    Case { id: "flight.passive_bank30_20g", quick: false, run: || flown(&PASSIVE30_20G) },
    Case { id: "flight.climb", quick: false, run: || flown(&CLIMB) },
    Case { id: "flight.dive_pullout", quick: false, run: || flown(&DIVE) },
    Case { id: "flight.decelerate", quick: false, run: || flown(&DECELERATE) },
    Case { id: "flight.predictive_20g", quick: true, run: || flown(&PREDICTIVE45_20G) },
    Case { id: "flight.path_figure8", quick: false, run: || path::rows(path::EIGHT) },
    Case { id: "flight.predictive_figure8", quick: false, run: || path::rows(path::PLANNED) },
    Case { id: "flight.hover_guarded", quick: false, run: hover::rows },
    Case { id: "flight.estimator", quick: true, run: estimator::rows },
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
];

/// What is asked of a flight from the begin of its first leg on.
struct Asked {
    of: Shipped,
    /// Largest error of the height, m.
    height: f64,
    /// Mean roll of the last second, deg; of straight flight, which symmetry keeps level, nothing is asked.
    roll_deg: f64,
}

const BANK15_20G: Asked = asked(shipped!("bank15_20g", "cruise_20g_margin"), 5e-3, 15.0);
const BANK30_20G: Asked = asked(shipped!("bank30_20g", "cruise_20g_margin"), 10e-3, 30.0);
const BANK45_20G: Asked = asked(shipped!("bank45_20g", "cruise_20g_margin"), 30e-3, 45.0);
const BANK15_LEV: Asked = asked(shipped!("bank15_20g_lev", "cruise_20g_lev"), 5e-3, 15.0);
const BANK30_LEV: Asked = asked(shipped!("bank30_20g_lev", "cruise_20g_lev"), 10e-3, 30.0);
const BANK45_LEV: Asked = asked(shipped!("bank45_20g_lev", "cruise_20g_lev"), 30e-3, 45.0);
const BANK15_BETA: Asked = asked(shipped!("bank15_beta", "cruise_beta"), 5e-3, 15.0);
const BANK30_BETA: Asked = asked(shipped!("bank30_beta", "cruise_beta"), 10e-3, 30.0);
const BANK45_BETA: Asked = asked(shipped!("bank45_beta", "cruise_beta"), 30e-3, 45.0);
const BANK15_BETA_LEV: Asked = asked(shipped!("bank15_beta_lev", "cruise_beta_lev"), 5e-3, 15.0);
const BANK30_BETA_LEV: Asked = asked(shipped!("bank30_beta_lev", "cruise_beta_lev"), 10e-3, 30.0);
const BANK45_BETA_LEV: Asked = asked(shipped!("bank45_beta_lev", "cruise_beta_lev"), 30e-3, 45.0);
const LINKAGE15: Asked = asked(shipped!("linkage_bank15", "cruise_linkage"), 5e-3, 15.0);
const LINKAGE30: Asked = asked(shipped!("linkage_bank30", "cruise_linkage"), 15e-3, 30.0);
const PASSIVE15: Asked = asked(shipped!("passive_bank15", "passive_linkage"), 5e-3, 15.0);
const PASSIVE15_20G: Asked = asked(shipped!("passive_bank15_20g", "passive_20g_margin"), 5e-3, 15.0);
const PASSIVE30_20G: Asked = asked(shipped!("passive_bank30_20g", "passive_20g_margin"), 10e-3, 30.0);
const CLIMB: Asked = asked(shipped!("climb", "cruise_20g_margin"), 30e-3, 0.0);
const DIVE: Asked = asked(shipped!("dive_pullout", "cruise_20g_margin"), 30e-3, 0.0);
const DECELERATE: Asked = asked(shipped!("decelerate", "cruise_beta_margin"), 25e-3, 0.0);

const PREDICTIVE45_20G: Asked = asked(shipped!("predictive_20g", "cruise_20g_margin"), 30e-3, 45.0);

const fn asked(of: Shipped, height: f64, roll_deg: f64) -> Asked {
    Asked { of, height, roll_deg }
}

/// Largest difference of roll from what is asked, deg: of its mean at the end, and as root mean square all through the turn.
const ROLL_WITHIN: f64 = 1.0;
/// Largest share of commands at a limit.
const SATURATED: f64 = 0.05;

fn flown(asked: &Asked) -> Result<Vec<Row>, Error> {
    let Asked { of, height, roll_deg } = asked;
    let scenario = scenario(*of, &[])?;
    let Run { record, summary, .. } = scenario.fly(|_| ControlFlow::Continue(()))?;
    let column = |name: &str| values(&record, name);
    let (t, legs) = (column("t")?, column("orbit_legs")?);
    let first = legs.partition_point(|legs| *legs == 0.0);
    let off = column("orbit_height_error")?[first..].iter().fold(0.0, |most: f64, e| most.max(e.abs()));
    let last = t.partition_point(|at| *at < t[t.len() - 1] - 1.0);
    let roll = &column("roll")?[last..];
    let mean = roll.iter().sum::<f64>().to_degrees() / roll.len() as f64;
    let (id, source) = (format!("flight.{}", of.0), "what is asked of the flight");
    let least = summary.least_clearance_m.unwrap_or(f64::NAN);
    let row = |end: &str, metric: &str, value: f64, limit: f64, unit| {
        Row::judged(&format!("{id}.{end}"), source, metric, value, limit, unit)
    };
    let saturated = summary.input_saturation_fraction;
    let mut rows = vec![
        row("height", "largest error of the height from the first leg on", off, *height, "m"),
        row("saturated", "share of commands at a limit", saturated, SATURATED, ""),
        row("clearance", "3 mm of skin less the least clearance", SKIN - least, 0.0, "m"),
    ];
    if *roll_deg != 0.0 {
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
