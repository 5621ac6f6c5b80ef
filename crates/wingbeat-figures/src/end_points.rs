//! Where the flights of a sweep end.

use wingbeat::simulate::Record;

use crate::clouds::{PointCloud, clouds};
use crate::plot_frame::{FrameAxis, MarkShape};
use crate::scale::TickScale;
use crate::write::Figure;
use crate::{Error, needed, style};

/// Flights by group, and what is published.
pub struct EndPoints<'a> {
    /// Name and rows of each group.
    pub groups: &'a [(String, Vec<usize>)],
    /// Published end point, m; y to the left.
    pub published: Option<(f64, f64)>,
    /// The only number that was varied: its column, and what it is with its unit.
    pub varied: Option<(&'a str, String)>,
}

/// Room beyond the outermost points, as a share of the larger side, and its least, m.
const ROOM: (f64, f64) = (0.08, 0.05);
/// Height of a number above its point, over that room.
const NUMBER: f64 = 0.15;
/// Radius of the mark of a flight that held its attitude, of another, and of what is published, px.
const DISC: f64 = 3.2;
const CROSS: f64 = 3.0;
const STAR: f64 = 6.0;

/// Every flight that was flown to the end by its end point, seen from above with x to the right and y up; those that did
/// not hold their attitude are crosses.
///
/// Needs `distance_x`, `distance_y`, `held` and `completed` (1 or 0).
pub fn end_points(record: &Record, what: &EndPoints) -> Result<Figure, Error> {
    let (x, y) = (needed(record, "distance_x")?, needed(record, "distance_y")?);
    let (held, completed) = (needed(record, "held")?, needed(record, "completed")?);
    let mut all_clouds: Vec<PointCloud> = Vec::new();
    // Of a turn the start is shown too: it tells the way.
    let mut all = if what.varied.is_some() { Vec::new() } else { vec![(0.0, 0.0)] };
    let flown_from = all.len();
    for (index, (name, rows)) in what.groups.iter().enumerate() {
        let flown = |wanted: bool| -> Vec<(f64, f64)> {
            let rows = rows.iter().filter(|&&row| completed[row] == 1.0 && (held[row] == 1.0) == wanted);
            rows.map(|&row| (x[row], y[row])).filter(|p| p.0.is_finite() && p.1.is_finite()).collect()
        };
        let (kept, lost) = (flown(true), flown(false));
        all.extend(kept.iter().chain(&lost));
        let cloud = |name: String, points: Vec<(f64, f64)>, shape: MarkShape| {
            let (colour, size) =
                (style::colour(index).into(), if shape == MarkShape::Cross { CROSS } else { DISC });
            PointCloud { name, points, shape, size, colour, opacity: 1.0 }
        };
        let mut legend = format!("{name}: {} of {} held", kept.len(), rows.len());
        if !lost.is_empty() {
            legend += " (others: crosses)";
        }
        if !lost.is_empty() {
            all_clouds.push(cloud(String::new(), lost, MarkShape::Cross));
        }
        all_clouds.push(cloud(legend, kept, MarkShape::Disc));
    }
    if let Some(point) = what.published {
        all.push(point);
        all_clouds.push(PointCloud {
            name: "the paper's end point".into(),
            points: vec![point],
            shape: MarkShape::Diamond,
            size: STAR,
            colour: style::INK.into(),
            opacity: 1.0,
        });
    }
    if all.len() == flown_from {
        return Err(Error::Rows { rows: 0, needed: 1 });
    }
    let ((left, right), (low, high)) =
        (style::span(all.iter().map(|p| p.0)), style::span(all.iter().map(|p| p.1)));
    let room = (ROOM.0 * (right - left).max(high - low)).max(ROOM.1);
    let varied = what.varied.as_ref().map_or(String::new(), |(_, label)| format!("; numbers: {label}"));
    // The ends of what was varied have their numbers.
    let values = what.varied.as_ref().and_then(|(key, _)| record.values(key)).unwrap_or_default();
    let flown = |row: &usize| completed[*row] == 1.0 && x[*row].is_finite() && y[*row].is_finite();
    let mut rows: Vec<usize> = (0..values.len()).filter(flown).collect();
    wingbeat::math::order::ascend_by(&mut rows, |row| values[*row]);
    let ends = [rows.first(), rows.last().filter(|_| rows.len() > 1)];
    let (across, up) = (TickScale::new(left - room, right + room), TickScale::new(low - room, high + room));
    let axes = (
        FrameAxis::of(across).labelled(format!("x at the end [m]{varied}")),
        FrameAxis::of(up).labelled("y at the end [m], left is positive"),
    );
    Ok(clouds("end_points", &all_clouds, axes, 0.68, |frame| {
        for row in ends.into_iter().flatten().copied() {
            frame.words((x[row], y[row] + NUMBER * room), style::number(values[row]));
        }
    }))
}
