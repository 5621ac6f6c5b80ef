//! Shipped sweeps flown whole: of many draws of the model's errors, gusts and courses of gusts the flights that are held, and clear.

use std::ops::ControlFlow;
use std::path::Path;

use wingbeat::parallel;
use wingbeat::scenario::{Hold, ReadTable, Sweep, SweepOf};

use crate::{CaseWatch, ComparisonRow, Error};

/// What is asked of the flights of a sweep; what counts as held and as clear the sweep says itself.
pub struct SweepDemand {
    /// Name of the sweep.
    pub sweep: &'static str,
    /// Largest share of flights that are not held; infinite where it is shown alone.
    lost: f64,
    /// Largest share of flights that are not clear, where it is asked.
    crossing: Option<f64>,
    /// Largest mean of the positive power, W/kg, where it is asked.
    power: Option<f64>,
}

/// Level flight.
pub const LEVEL: SweepDemand = held("level_20g", DRIVEN);
/// A turn at 15 deg.
pub const BANK15: SweepDemand = held("bank15_20g", DRIVEN);
/// Level flight with a passive shoulder.
pub const PASSIVE_LEVEL: SweepDemand = held("passive_level_20g", PASSIVE);
/// A turn at 15 deg with a passive shoulder.
pub const PASSIVE_BANK15: SweepDemand = held("passive_bank15_20g", PASSIVE);
/// The figure of eight.
pub const FIGURE8: SweepDemand =
    SweepDemand { sweep: "path_figure8", lost: 0.05, crossing: None, power: None };

/// Launches by hand, of which none may be lost; their wings are not clear in most.
pub const LAUNCH: SweepDemand = SweepDemand { sweep: "launch_20g", lost: 0.0, crossing: None, power: None };

/// Landings, of which 90 of 100 are asked to be caught, clear of the bar and of themselves.
pub const LAND: SweepDemand = SweepDemand { sweep: "land_20g", lost: 0.1, crossing: Some(0.1), power: None };

/// In unknown air: 190 of 200 in the turn, 195 level, 180 of Beta.
pub const ANY_AIR_BANK30: SweepDemand =
    SweepDemand { sweep: "any_air_bank30_20g", lost: 0.05, crossing: Some(0.05), power: Some(90.0) };
/// A turn of Aerobat Beta at 15 deg in any air.
pub const ANY_AIR_BETA: SweepDemand =
    SweepDemand { sweep: "any_air_bank15_beta", lost: 0.1, crossing: Some(0.1), power: Some(120.0) };
/// Level flight in any air.
pub const ANY_AIR_LEVEL: SweepDemand =
    SweepDemand { sweep: "any_air_level_20g", lost: 0.025, crossing: Some(0.025), power: Some(90.0) };

/// Largest shares of flights in which the wings come closer than the sweep allows: of a driven twist, and of one that the air moves.
const DRIVEN: f64 = 0.05;
const PASSIVE: f64 = 0.1;

/// A sweep of which every flight is asked to be held.
const fn held(sweep: &'static str, crossing: f64) -> SweepDemand {
    SweepDemand { sweep, lost: 0.0, crossing: Some(crossing), power: None }
}

const NO_TABLES: ReadTable = &|_: &Path| Err("flights read no tables".into());

/// The sweep of this name and what it holds.
pub fn read(name: &str) -> Result<(Sweep, Hold), Error> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sweeps").join(name).with_extension("toml");
    let refused = |e: wingbeat::scenario::ConfigError| Error::reference(name, e.to_string());
    let sweep = Sweep::load(&path, &[], NO_TABLES).map_err(refused)?;
    match sweep.of {
        SweepOf::Flights(hold) => Ok((sweep, hold)),
        SweepOf::Cases => Err(Error::reference(name, "no sweep of flights")),
    }
}

/// The comparisons; none where they were ended.
pub fn rows(asked: &SweepDemand, watch: &mut CaseWatch<'_>) -> Result<Vec<ComparisonRow>, Error> {
    let name = asked.sweep;
    let (sweep, hold) = read(name)?;
    let Some(flown) = flown(&sweep, watch)? else { return Ok(Vec::new()) };
    let columns = sweep.columns();
    let column = |name: &str| -> Result<Vec<f64>, Error> {
        let at = columns.iter().position(|column| column.name == name);
        let at = at.ok_or_else(|| Error::reference("sweep", format!("no column {name}")))?;
        Ok(flown.iter().map(|row| row[at]).collect())
    };
    let flights = flown.len();
    let missed =
        |truths: &[f64]| truths.iter().filter(|truth| **truth != 1.0).count() as f64 / flights as f64;
    let (lost, crossing) = (missed(&column("held")?), missed(&column("clear")?));
    let id = |end: &str| format!("flight.draws.{name}.{end}");
    let source = "what is asked of the flights";
    let of = |what: &str| format!("share of {flights} flights {what}");
    let mut rows = Vec::new();
    let (mut within, mut worst) = (Vec::new(), Vec::new());
    for (end, measure, limit, what) in [
        ("height", "height_max_error", hold.height_within_m, "height"),
        ("cross", "cross_rms", hold.cross_rms_within_m, "rms distance across the path"),
    ] {
        let Some(limit) = limit else { continue };
        let values = column(measure)?;
        within.push(format!("{:.0} mm of {what}", 1e3 * limit));
        let (id, metric) = (id(end), format!("largest error of the {what} of {flights} flights"));
        worst.push(ComparisonRow::shown(&id, source, &metric, most(&values), "m"));
    }
    let metric = match within.is_empty() {
        true => of("not held"),
        false => of(&format!("not held within {}", within.join(" and "))),
    };
    rows.push(match asked.lost.is_finite() {
        true => ComparisonRow::judged(&id("held"), source, &metric, lost, asked.lost, ""),
        false => ComparisonRow::shown(&id("held"), source, &metric, lost, ""),
    });
    let caught = column("perch_caught")?;
    if caught.iter().any(|caught| caught.is_finite()) {
        rows.push(ComparisonRow::shown(
            &id("caught"),
            source,
            &of("whose claw does not latch"),
            missed(&caught),
            "",
        ));
    }
    let metric = of(&format!("with less than {:.0} mm of clearance", 1e3 * hold.clearance_m));
    rows.push(match asked.crossing {
        Some(limit) => ComparisonRow::judged(&id("clear"), source, &metric, crossing, limit, ""),
        None => ComparisonRow::shown(&id("clear"), source, &metric, crossing, ""),
    });
    rows.append(&mut worst);
    let least = -most(&column("least_clearance")?.iter().map(|c| -c).collect::<Vec<_>>());
    let metric = format!("least clearance of {flights} flights");
    rows.push(ComparisonRow::shown(&id("least_clearance"), source, &metric, least, "m"));
    let power = column("positive_power")?;
    let most = asked.power.map_or(String::new(), |most| format!(" (at most {most} asked)"));
    let metric = format!("mean positive power of {flights} flights{most}");
    rows.push(ComparisonRow::shown(
        &id("power"),
        source,
        &metric,
        power.iter().sum::<f64>() / flights as f64,
        "W/kg",
    ));
    Ok(rows)
}

/// The largest; not a number where one is not.
fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, |most, v| if v.is_nan() || v > most { v } else { most })
}

/// The rows of the sweep, on all cores; none where it was ended.
fn flown(sweep: &Sweep, watch: &mut CaseWatch<'_>) -> Result<Option<Vec<Vec<f64>>>, Error> {
    let (all, stopped) = (sweep.runs(), std::sync::atomic::AtomicBool::new(false));
    let mut rows = Vec::with_capacity(all);
    let mut failed = None;
    if watch(0, all).is_break() {
        return Ok(None);
    }
    let go_on = || match stopped.load(std::sync::atomic::Ordering::Relaxed) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    parallel::each(
        &sweep.batches((0..all).collect()),
        |_, batch| sweep.rows(batch, NO_TABLES, go_on),
        |_, made| {
            let flow = match made {
                Ok(made) => {
                    rows.extend(made.rows);
                    watch(rows.len(), all)
                }
                Err(error) => {
                    failed = Some(Error::NoAnswer(error.to_string()));
                    ControlFlow::Break(())
                }
            };
            stopped.store(flow.is_break(), std::sync::atomic::Ordering::Relaxed);
            flow
        },
    );
    match failed {
        Some(error) => Err(error),
        None => Ok((rows.len() == all).then_some(rows)),
    }
}
