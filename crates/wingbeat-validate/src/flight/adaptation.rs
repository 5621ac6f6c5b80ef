//! Adaptation in flight: flights in unknown air, with and without it.

use std::ops::ControlFlow;

use wingbeat::scenario::Summary;

use crate::shipped::{Shipped, scenario};
use crate::{ComparisonRow, Error};

/// What is asked: height held within, and wings clear by, m.
const HELD: f64 = 0.05;
const CLEAR: f64 = 0.003;
const ADAPTED: &[&str] = &["controller.orbit.adapt={crank_s=0.1, missed_s=0.09}"];
/// The slowest adaptation that there is: within six seconds it learns nothing.
const NONE: &[&str] = &["controller.orbit.adapt={crank_s=1000.0, missed_s=1000.0}"];

/// The controllers are told law `lev`.
const TOLD: &[&str] = &["aero.law=lev"];
/// What they are not told.
const STALL: &[&str] = &["mismatch.aero={preset='full', law='stall'}"];
const DRAG: &[&str] = &["mismatch.profile_drag=1.5", "mismatch.density=0.82"];
const GUSTS: &[&str] = &["air.gust_m_s=0.5"];

/// A flight: the end of its id, the scenario, what is untold in words and as settings, and whether its gait was found for many airs:
/// that alone has the room that clearance takes, so clearance is judged there; the scenario says itself how it adapts.
type UnknownAirFlight = (&'static str, Shipped, &'static str, &'static [&'static str], bool);

const UNTOLD_STALL: &str = "law `stall` unknown to the controller";
const UNTOLD_DRAG: &str = "profile drag x 1.5 and 18 % thinner air unknown to it";
const FLIGHTS: [UnknownAirFlight; 8] = [
    ("untold_stall", "bank30_20g_lev", UNTOLD_STALL, STALL, false),
    ("untold_stall_beta", "bank15_beta_lev", UNTOLD_STALL, STALL, false),
    ("untold_drag", "bank30_20g_lev", UNTOLD_DRAG, DRAG, false),
    ("gusts", "bank30_20g_lev", "gusts of 0.5 m/s", GUSTS, false),
    ("any_air.untold_stall", "any_air_bank30_20g", UNTOLD_STALL, STALL, true),
    ("any_air.untold_stall_beta", "any_air_bank15_beta", UNTOLD_STALL, STALL, true),
    ("any_air.untold_drag", "any_air_bank30_20g", UNTOLD_DRAG, DRAG, true),
    ("any_air.gusts", "any_air_bank30_20g", "gusts of 0.5 m/s", GUSTS, true),
];

/// The comparisons.
pub(super) fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = Vec::new();
    for (name, of, what, untold, many) in FLIGHTS {
        let fly = |adapted: &[&str]| -> Result<Summary, Error> {
            let run = scenario(of, &[TOLD, untold, adapted].concat())?;
            Ok(run.fly(|_| ControlFlow::Continue(()))?.summary)
        };
        let (with, without) = if many { (&[][..], NONE) } else { (ADAPTED, &[][..]) };
        let (with, without) = (fly(with)?, fly(without)?);
        let height = |summary: &Summary| summary.height_max_error_m.unwrap_or(f64::NAN);
        let id = |end: &str| format!("flight.adaptation.{name}.{end}");
        let source = "what is asked of the flight";
        let metric = format!("largest error of the height of {of}, {what}");
        let adapted = format!("{metric}, with adaptation");
        rows.push(ComparisonRow::judged(&id("height"), source, &adapted, height(&with), HELD, "m"));
        let without_it = format!("{metric}, without");
        rows.push(ComparisonRow::shown(&id("height_without"), source, &without_it, height(&without), "m"));
        let least = with.least_clearance_m.unwrap_or(f64::NAN);
        rows.push(if many {
            let metric = format!("3 mm less the least clearance of {of}, {what}, with adaptation");
            ComparisonRow::judged(&id("clearance"), source, &metric, CLEAR - least, 0.0, "m")
        } else {
            let metric = format!("least clearance of {of}, {what}, with adaptation (3 mm asked)");
            ComparisonRow::shown(&id("clearance"), source, &metric, least, "m")
        });
    }
    Ok(rows)
}
