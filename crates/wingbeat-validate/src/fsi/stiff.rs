//! What an inertance beside springs keeps of a robot, and what it costs.

use super::energy::{FLAP, OF_WING, STEP, Trial, derivatives};
use crate::{ComparisonRow, Error};
use wingbeat::simulate::fastest_vibration;

/// Time of the inertance, s.
const TIME: f64 = STEP;

/// Fastest vibration times the time of the inertance, the largest of springs and flaps without air: stiffnesses of 1 to 1e9 times that of the
/// flapper, dampers from none to where nothing oscillates.
fn fastest() -> Result<f64, Error> {
    let mut worst = 0.0_f64;
    for stiffer in [1.0, 1e3, 1e6, 1e9] {
        for damping in [0.0, 1e-4, 1e-2, 1.0] {
            let spring = [4e-3 * stiffer, 4e-3 * stiffer * damping];
            let trial = Trial { soft: FLAP, spring, inertance: TIME, density: 1e-12, ..OF_WING };
            worst = worst.max(TIME * fastest_vibration(&trial.robot()?)?);
        }
    }
    Ok(worst)
}

/// Order in the time of the inertance of where the flapper is after a cycle, by springs without dampers.
fn order() -> Result<f64, Error> {
    let place =
        |inertance: f64| Trial { spring: [4e-3, 0.0], inertance, step: 0.25 * STEP, ..OF_WING }.place();
    let exact = place(0.0)?;
    let [coarse, fine] = [4.0 * TIME, 2.0 * TIME].map(|time| place(time).map(|at| (at - exact).norm()));
    Ok((coarse? / fine?).log2())
}

/// Where a flapper of springs ten thousand times as stiff is after a cycle in steps that would not follow them, less where it is by steps that do, m.
fn far() -> Result<f64, Error> {
    let stiff = Trial { spring: [40.0, 2e-3], ..OF_WING };
    let followed = Trial { step: STEP / 20.0, ..stiff }.place()?;
    Ok((Trial { inertance: STEP, ..stiff }.place()? - followed).norm())
}

fn row(id: &str, source: &str, metric: &str, value: f64, limit: f64, unit: &'static str) -> ComparisonRow {
    ComparisonRow::judged(&format!("fsi.stiff.{id}"), source, metric, value, limit, unit)
}

/// The rows.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let carried = Trial { inertance: TIME, ..OF_WING };
    let flapped = Trial { soft: FLAP, density: 1e-12, step: 0.25 * STEP, ..carried };
    let mut rows = vec![
        row(
            "fastest",
            "bound of robot.inertance",
            "fastest vibration times the time of the inertance, springs 1 to 1e9 times as stiff, dampers of 0 to 1 s, without air",
            fastest()?,
            1.0 + 1e-3,
            "",
        ),
        row(
            "order",
            "order 4 without dampers",
            "order in that time of where a flapper is after a cycle, less 4",
            (order()? - 4.0).abs(),
            0.1,
            "",
        ),
        row(
            "place",
            "steps of 2e-5 s without it",
            "place after a cycle, springs 1e4 times as stiff, steps of 4e-4 s with it",
            far()?,
            1e-6,
            "m",
        ),
        row(
            "energy",
            "conservation of energy",
            "work of drives, dampers and air less change of energy, over the peak work, one cycle, springs with it, without and with flaps",
            carried.run()?.energy.max(Trial { density: OF_WING.density, ..flapped }.run()?.energy),
            1e-8,
            "",
        ),
        row(
            "momentum",
            "conservation of momentum",
            "largest change of the momentum of links and flaps but by the weight, over it, one cycle without air",
            flapped.run()?.momentum,
            1e-10,
            "",
        ),
    ];
    rows.extend(derivatives(
        "fsi.stiff.derivatives",
        "springs and flaps with it",
        Trial { density: OF_WING.density, ..flapped },
    )?);
    Ok(rows)
}
