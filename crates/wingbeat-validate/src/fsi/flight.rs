//! Flights on wings that give way, beside the same flights on rigid ones.

use std::ops::ControlFlow;

use crate::shipped::scenario;
use crate::{Case, ComparisonRow, Error};
use wingbeat::judge::Status;
use wingbeat::scenario::Summary;

/// The comparisons.
pub const CASES: &[Case] = &[Case { id: "fsi.flight", quick: false, run: rows }];

/// Seconds of each flight: level, the turn from 2 to 3.5 s, level again.
const DURATION: &str = "flight.duration_s=4.0";
/// What is asked of the height, m, and of the roll, rms from 2 s on, deg.
const HELD: f64 = 0.02;
const ROLL: f64 = 1.0;
/// Clearance for two skins, m.
const SKINS: f64 = 3e-3;

/// A turn at 15 deg of bank.
struct FlexibleTurn {
    name: &'static str,
    of: &'static str,
    rigid: &'static str,
    /// What makes its air that of the flexible one.
    air: &'static [&'static str],
    /// Interval of the plan, s. Those of a wing that bends resolve its bending.
    interval: &'static str,
    /// What halves and doubles its stiffness.
    scaled: [&'static [&'static str]; 2],
}

const TURNS: [FlexibleTurn; 2] = [
    FlexibleTurn {
        name: "membrane",
        of: "membrane_bank15",
        rigid: "bank15_beta",
        air: &["aero.full.turning_impulse=true"],
        interval: "controller.orbit.predictive.interval_s=0.0071",
        scaled: [
            &["robot.surfaces[0].membrane.modulus_pa=1e8"],
            &["robot.surfaces[0].membrane.modulus_pa=4e8"],
        ],
    },
    FlexibleTurn {
        name: "spar",
        of: "soft_bank15",
        rigid: "bank15_20g",
        air: &["aero.full.strips=12"],
        interval: "controller.orbit.predictive.interval_s=0.004",
        scaled: [
            &["robot.links[2].spar.bending_n_m2=0.019", "robot.links[2].spar.torsion_n_m2=0.031"],
            &["robot.links[2].spar.bending_n_m2=0.076", "robot.links[2].spar.torsion_n_m2=0.124"],
        ],
    },
];
const PLANNED: &[&str] =
    &["controller.orbit.predictive.intervals=5", "controller.orbit.predictive.terminal=\"regulator\""];

/// A flight's summary, and the largest torque at the shoulders, N m.
fn fly(of: &'static str, set: &[&str]) -> Result<(Summary, f64), Error> {
    let run = scenario(of, &[&[DURATION], set].concat())?.fly(|_| ControlFlow::Continue(()))?;
    let torque = |side: &str| run.record.values(&format!("torque_shoulder_{side}")).unwrap_or_default();
    let largest = ["left", "right"].into_iter().flat_map(torque).fold(0.0, |m: f64, t| m.max(t.abs()));
    Ok((run.summary, largest))
}

fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = Vec::new();
    for turn in TURNS {
        rows.extend(rows_of(&turn)?);
    }
    Ok(rows)
}

fn rows_of(turn: &FlexibleTurn) -> Result<Vec<ComparisonRow>, Error> {
    let FlexibleTurn { name, of, rigid, air, interval, scaled } = turn;
    let (own, torque) = fly(of, &[])?;
    let (twin, twin_torque) = fly(rigid, air)?;
    let (planned, _) = fly(of, &[PLANNED, &[interval]].concat())?;
    let mut rows = Vec::new();
    for (end, how, flight) in [("", "a regulator", &own), (".planned", "a plan by collocation", &planned)] {
        let id = |what: &str| format!("fsi.flight.{name}{end}.{what}");
        let with = format!("turn of {of} under {how}");
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let asked = "what is asked of the flight";
        let height = format!("largest error of the height, {with}");
        let roll = format!("rms error of the roll, {with}");
        let missing = SKINS - number(flight.least_clearance_m);
        let ok = if flight.status == Status::Ok { 0.0 } else { 1.0 };
        rows.extend([
            ComparisonRow::judged(
                &id("height"),
                asked,
                &height,
                number(flight.height_max_error_m),
                HELD,
                "m",
            ),
            ComparisonRow::judged(&id("roll"), asked, &roll, number(flight.roll_rms_error_deg), ROLL, "deg"),
            ComparisonRow::judged(
                &id("clearance"),
                asked,
                &format!("what is missing of a clearance of 3 mm, {with}"),
                missing.max(0.0),
                0.0,
                "m",
            ),
            ComparisonRow::judged(
                &id("status"),
                asked,
                &format!("statuses that are not ok, {with}"),
                ok,
                0.0,
                "",
            ),
        ]);
    }
    let mut shown = |what: &str, metric: &str, value: Option<f64>, unit| {
        let metric = format!("{metric}, turn of {of}");
        let id = format!("fsi.flight.{name}.{what}");
        rows.push(ComparisonRow::shown(&id, rigid, &metric, value.unwrap_or(f64::NAN), unit));
    };
    shown("power", "mean positive power", own.cost.positive_power_w_kg, "W/kg");
    shown("power.rigid", "the same on rigid wings", twin.cost.positive_power_w_kg, "W/kg");
    let [half, double] = scaled.map(|set| fly(of, set).map(|(summary, _)| summary.cost.positive_power_w_kg));
    shown("power.half", "the same with half the stiffness", half?, "W/kg");
    shown("power.double", "the same with twice the stiffness", double?, "W/kg");
    shown(
        "actuators",
        "mean positive power of the actuators",
        own.measured.get("regulator_power_given_w"),
        "W",
    );
    shown("actuators.rigid", "the same on rigid wings", twin.measured.get("regulator_power_given_w"), "W");
    shown("torque", "largest torque at a shoulder", Some(torque), "N m");
    shown("torque.rigid", "the same on rigid wings", Some(twin_torque), "N m");
    Ok(rows)
}
