//! The flights of a sweep: largest errors of roll and pitch, and what counts as held.

use wingbeat::simulate::Record;

use crate::clouds::{PointCloud, clouds};
use crate::plot_frame::{FrameAxis, MarkShape};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Least error that is told apart, deg: the axes are logarithmic.
const LEAST: f64 = 1e-2;

/// A measure that the picture does not show: its column, the most that a held flight has, in the unit of the column, and its name in words.
pub type UndrawnLimit<'a> = (&'a str, f64, &'a str);

/// Why a flight is where it is in the legend: held, or what it missed, the first that it did.
fn outcome<'a>(
    record: &Record,
    limits: (f64, f64),
    others: &[UndrawnLimit<'a>],
    row: usize,
) -> (usize, String) {
    let at = |name: &str| record.values(name).map_or(f64::NAN, |values| values[row]);
    if at("held") == 1.0 {
        return (0, "held".into());
    }
    if at("held").is_nan() {
        return (4, "not judged".into());
    }
    if at("roll_max_error") > limits.0 || at("pitch_max_error") > limits.1 {
        return (1, "roll or pitch missed".into());
    }
    match others.iter().find(|(column, most, _)| !(at(column) <= *most)) {
        Some((_, _, words)) => (2, format!("{words} missed")),
        None => (3, "refused by own verdict".into()),
    }
}

/// Every flight by its largest errors (deg) of roll and pitch; `limits` (deg) are those of a held flight, `others` those that the picture does
/// not show: the legend says what a flight missed.
///
/// Needs `roll_max_error`, `pitch_max_error` and `held` (1, 0 or no number).
pub fn robustness(record: &Record, limits: (f64, f64), others: &[UndrawnLimit]) -> Result<Figure, Error> {
    let (roll, pitch) = (needed(record, "roll_max_error")?, needed(record, "pitch_max_error")?);
    needed(record, "held")?;
    let flights: Vec<(f64, f64, (usize, String))> = (0..record.rows())
        .filter(|&row| roll[row].is_finite() && pitch[row].is_finite())
        .map(|row| (roll[row].max(LEAST), pitch[row].max(LEAST), outcome(record, limits, others, row)))
        .collect();
    if flights.is_empty() {
        return Err(Error::Rows { rows: 0, needed: 1 });
    }
    let mut outcomes: Vec<(usize, String)> = vec![(0, "held".into())];
    outcomes.extend(flights.iter().map(|flight| flight.2.clone()));
    outcomes.sort();
    outcomes.dedup();
    let cloud = |wanted: &(usize, String)| -> PointCloud {
        let points: Vec<(f64, f64)> =
            flights.iter().filter(|flight| flight.2 == *wanted).map(|flight| (flight.0, flight.1)).collect();
        let name = format!("{}: {} of {}", wanted.1, points.len(), record.rows());
        let colour = style::colour(wanted.0).into();
        // What is missed in a measure that is not drawn lies among the held.
        let shape = if wanted.0 < 2 { MarkShape::Disc } else { MarkShape::Ring };
        PointCloud { name, points, shape, size: 3.0, colour, opacity: 0.75 }
    };
    let mut all: Vec<PointCloud> = outcomes.iter().map(cloud).collect();
    let broken = record.rows() - flights.len();
    if broken > 0 {
        let name = format!("without errors: {broken} of {}", record.rows());
        let (shape, colour) = (MarkShape::Cross, style::INK.into());
        all.push(PointCloud { name, points: Vec::new(), shape, size: 3.0, colour, opacity: 0.75 });
    }
    let least = |errors: &[f64]| errors.iter().any(|error| *error < LEAST);
    let below = if least(roll) || least(pitch) {
        format!("; smaller than {LEAST}° drawn there")
    } else {
        String::new()
    };
    let range = |errors: Vec<f64>, limit: f64| {
        let values = errors.into_iter().chain([limit]);
        let (low, high) =
            values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        FrameAxis::log(0.7 * low, 1.5 * high)
    };
    let x = range(flights.iter().map(|flight| flight.0).collect(), limits.0)
        .labelled(format!("largest error of roll [°]; dashed: limit {}°{below}", limits.0));
    let y = range(flights.iter().map(|flight| flight.1).collect(), limits.1)
        .labelled(format!("largest error of pitch [°]; dashed: limit {}°", limits.1));
    Ok(clouds("robustness", &all, (x, y), 0.6, |frame| {
        frame.upwards(limits.0, style::GUIDE, style::FINE, Some(style::GUIDE_DASHES));
        frame.across(limits.1, style::GUIDE, style::FINE, Some(style::GUIDE_DASHES));
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::simulate::Column;

    #[test]
    fn the_legend_says_what_a_flight_missed() {
        let column =
            |name: &str, values: [f64; 5]| Column { values: values.into(), ..Column::new(name, "", "") };
        let columns = vec![
            column("held", [1.0, 0.0, 0.0, 0.0, f64::NAN]),
            column("roll_max_error", [1.0, 40.0, 2.0, 3.0, 4.0]),
            column("pitch_max_error", [1.0, 2.0, 2.0, 3.0, 4.0]),
            column("height_max_error", [0.01, 0.01, 0.2, 0.02, 0.03]),
        ];
        let record = Record::new(columns, 0).unwrap();
        let text = robustness(&record, (30.0, 30.0), &[("height_max_error", 0.07, "height")]).unwrap().svg();
        for name in ["held", "roll or pitch missed", "height missed", "refused by own verdict", "not judged"]
        {
            assert!(text.contains(&format!("{name}: 1 of 5")), "{name}: {text}");
        }
        assert!(!text.contains("lost"));
    }
}
