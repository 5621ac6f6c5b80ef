//! Derivatives of the cycles of a run by its numbers, against differences.

use super::{no_answer, shipped, structure};
use crate::{ComparisonRow, Error};
use wingbeat_calibrate::RigTarget;

/// Numbers of every kind, each with a value to be looked at and the step of a difference.
const NUMBERS: [(&str, f64, f64); 19] = [
    ("surfaces.wing.lift_slope_per_rad", 5.6, 1e-3),
    ("surfaces.wing.cd0", 0.05, 1e-5),
    ("surfaces.wing.cd90", 1.8, 1e-3),
    ("surfaces.wing.stall_angle_rad", 0.25, 3e-5),
    ("surfaces.wing.critical_suction", 0.15, 2e-5),
    ("surfaces.wing.added_mass_scale", 0.9, 1e-3),
    ("air.density_kg_m3", 1.2, 1e-3),
    ("links.twist.mass_kg", 1.2e-3, 1e-6),
    ("links.twist.com_m[1]", 0.04, 1e-5),
    ("links.shoulder.mass_kg", 1.5e-3, 1e-6),
    ("body.com_m[0]", 0.002, 1e-5),
    ("body.drag_area_m2[0]", 1e-3, 1e-6),
    ("gait.phase_rad", 0.03, 1e-5),
    ("mount.shift_m[2]", 0.001, 1e-5),
    ("mount.turn_rad[1]", 0.02, 1e-5),
    ("mount.mass_kg", 0.013, 1e-5),
    ("mount.com_m[0]", 0.002, 1e-5),
    ("crank.ripple_rad[0]", 0.01, 1e-5),
    ("crank.ripple_rad[1]", -0.02, 1e-5),
];

/// Largest difference of a derivative from the central one, over the largest derivative by that number.
fn worst(target: &RigTarget) -> Result<(f64, &'static str), Error> {
    let at: Vec<(&str, f64)> = NUMBERS.iter().map(|(name, value, _)| (*name, *value)).collect();
    let exact = target.slopes(&at, at.len()).map_err(no_answer)?;
    let mut worst = (0.0, "");
    for (k, (name, value, step)) in NUMBERS.iter().enumerate() {
        let moved = |by: f64| {
            let mut to = at.clone();
            to[k].1 = value + by * step;
            target.predict(&to).map_err(no_answer)
        };
        // Central differences of two steps: the error is of the fourth order.
        let (a, b, c, d) = (moved(2.0)?, moved(1.0)?, moved(-1.0)?, moved(-2.0)?);
        let largest = exact[k].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        if largest == 0.0 {
            return Err(no_answer(format!("nothing depends on {name}")));
        }
        for i in 0..a.len() {
            let difference = (8.0 * (b[i] - c[i]) - (a[i] - d[i])) / (12.0 * step);
            let error = (exact[k][i] - difference).abs() / largest;
            if error > worst.0 {
                worst = (error, *name);
            }
        }
    }
    Ok(worst)
}

/// Both presets, law `lev`, a banking turn with few steps.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = Vec::new();
    let mut all = 0.0_f64;
    for preset in ["paper", "full"] {
        let model = format!("model=[\"rig.aero.preset={preset}\", \"rig.aero.law=lev\"]");
        let calibration = shipped("two_runs.toml", &[&model, "steps_per_cycle=60"])?;
        let (error, by) = worst(&structure(&calibration)?.model.targets[0])?;
        all = all.max(error);
        let metric = format!("the same with preset {preset}; the worst by {by}");
        let id = format!("calibrate.gradient.{preset}");
        rows.push(ComparisonRow::shown(&id, "own central differences", &metric, error, ""));
    }
    let metric =
        "max error of a turn's harmonics by 19 numbers of wing, air, bodies, gait, mount and crank, law lev";
    rows.insert(
        0,
        ComparisonRow::judged("calibrate.gradient", "own central differences", metric, all, 1e-6, ""),
    );
    Ok(rows)
}
