//! The flights of a sweep: largest errors of roll and pitch, and what counts as held.

use wingbeat::simulate::Record;

use crate::clouds::{PointCloud, clouds};
use crate::plot_frame::{FrameAxis, MarkShape};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Least error that is told apart, deg: the axes are logarithmic.
const LEAST: f64 = 1e-2;

/// Every flight by its largest errors (deg) of roll and pitch; `limits` are those of a held flight.
///
/// Needs `roll_max_error`, `pitch_max_error` and `held` (1 or 0).
pub fn robustness(record: &Record, limits: (f64, f64)) -> Result<Figure, Error> {
    let (roll, pitch) = (needed(record, "roll_max_error")?, needed(record, "pitch_max_error")?);
    let held = needed(record, "held")?;
    let flights: Vec<(f64, f64, bool)> = (0..record.rows())
        .filter(|&row| roll[row].is_finite() && pitch[row].is_finite())
        .map(|row| (roll[row].max(LEAST), pitch[row].max(LEAST), held[row] == 1.0))
        .collect();
    if flights.is_empty() {
        return Err(Error::Rows { rows: 0, needed: 1 });
    }
    let cloud = |wanted: bool, name: &str, index: usize| -> PointCloud {
        let points: Vec<(f64, f64)> =
            flights.iter().filter(|flight| flight.2 == wanted).map(|flight| (flight.0, flight.1)).collect();
        let missing = if wanted || flights.len() == record.rows() {
            String::new()
        } else {
            format!(", {} broke down", record.rows() - flights.len())
        };
        let name = format!("{name}: {} of {}{missing}", points.len(), record.rows());
        let colour = style::colour(index).into();
        PointCloud { name, points, shape: MarkShape::Disc, size: 3.0, colour, opacity: 0.75 }
    };
    let mut all = vec![cloud(true, "held", 0)];
    if flights.iter().any(|flight| !flight.2) || flights.len() < record.rows() {
        all.push(cloud(false, "lost", 1));
    }
    let least = |errors: &[f64]| errors.iter().any(|error| *error < LEAST);
    let below = if least(roll) || least(pitch) {
        format!("; smaller than {LEAST}° drawn there")
    } else {
        String::new()
    };
    let range = |of: fn(&(f64, f64, bool)) -> f64, limit: f64| {
        let values = flights.iter().map(of).chain([limit]);
        let (low, high) =
            values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        FrameAxis::log(0.7 * low, 1.5 * high)
    };
    let x = range(|flight| flight.0, limits.0)
        .labelled(format!("largest error of roll [°]; dashed: limit {}°{below}", limits.0));
    let y = range(|flight| flight.1, limits.1)
        .labelled(format!("largest error of pitch [°]; dashed: limit {}°", limits.1));
    Ok(clouds("robustness", &all, (x, y), 0.6, |frame| {
        frame.upwards(limits.0, style::GUIDE, style::FINE, Some(style::GUIDE_DASHES));
        frame.across(limits.1, style::GUIDE, style::FINE, Some(style::GUIDE_DASHES));
    }))
}
