//! Vorticity through a plane behind the wing at phases of the stroke.

use super::colour::Diverging;
use super::paper::Paper;
use crate::canvas::TextAnchor;
use crate::scale::TickScale;
use crate::write::Figure;
use crate::{Error, style};

/// Cells of the field across the widest picture.
const CELLS: usize = 96;
/// Room around vortices, radii of their spots.
const SPOTS: f64 = 3.0;
/// Share of the largest vorticity below which nothing is drawn.
const FAINT: f64 = 0.01;
/// Room around a picture, px.
const MARGIN: (f64, f64) = (54.0, 40.0);
/// Room above them for a note, px.
const NOTE: f64 = 20.0;
/// Room below the pictures for the scale, px.
const FOOT: f64 = 60.0;

/// Least distance of the numbers of the axis across and of that up, px.
const APART: (f64, f64) = (36.0, 14.0);

/// What crosses a plane at an instant; y to the left and z up, m.
#[derive(Clone, Debug, Default)]
pub struct PlaneCut {
    /// What is shown, a line above the picture.
    pub title: String,
    /// Vortices that cross the plane: place (y, z), and circulation about the direction of flight, m2/s.
    pub vortices: Vec<([f64; 2], f64)>,
    /// The wing's leading and trailing edges as seen in the plane.
    pub outline: Vec<Vec<[f64; 2]>>,
}

/// The pictures side by side, two in a row, on one scale, with `notes` above, a line each. Every vortex is drawn as a round spot of the radius `spread` m (Gaussian)
/// that holds its circulation.
///
/// # Errors
/// No vortex crosses a plane.
pub fn frontal_planes(cuts: &[PlaneCut], notes: &[String], spread: f64) -> Result<Figure, Error> {
    if cuts.iter().all(|cut| cut.vortices.is_empty()) {
        return Err(Error::Rows { rows: 0, needed: 1 });
    }
    let [across, up] = ranges(cuts, spread);
    let width = 0.5 * style::WIDTH - 1.5 * MARGIN.0;
    let size = width / (across.1 - across.0);
    let height = size * (up.1 - up.0);
    let cell = (across.1 - across.0) / CELLS as f64;
    let rows = ((up.1 - up.0) / cell).ceil() as usize;
    let fields: Vec<Vec<f64>> =
        cuts.iter().map(|cut| field(cut, [across.0, up.1], cell, rows, spread)).collect();
    let scale = Diverging::of(fields.iter().flatten().copied());
    let lines = cuts.len().div_ceil(2) as f64;
    let head = NOTE * notes.len() as f64;
    let total = lines * (height + MARGIN.1 + 30.0) + FOOT + 20.0 + head;
    let mut paper = Paper::new(style::WIDTH, total);
    for (k, note) in notes.iter().enumerate() {
        paper.text((MARGIN.0, NOTE * (k + 1) as f64), note, TextAnchor::Start);
    }
    for (k, (cut, field)) in cuts.iter().zip(&fields).enumerate() {
        let origin = (
            MARGIN.0 + (k % 2) as f64 * (width + MARGIN.0),
            head + MARGIN.1 + (k / 2) as f64 * (height + MARGIN.1 + 30.0),
        );
        let at = |y: f64, z: f64| (origin.0 + size * (across.1 - y), origin.1 + size * (up.1 - z));
        for (index, value) in field.iter().enumerate().filter(|(_, v)| v.abs() > FAINT * scale.most) {
            let (row, column) = (index / CELLS, index % CELLS);
            let (y, z) = (across.0 + column as f64 * cell, up.1 - row as f64 * cell);
            let corners = [at(y, z), at(y + cell, z), at(y + cell, z - cell), at(y, z - cell)];
            paper.area(&corners, &scale.colour(*value), 1.0);
        }
        for line in &cut.outline {
            paper.line(line.iter().map(|p| at(p[0], p[1])).collect(), style::INK, 1.2);
        }
        frame(&mut paper, &at, across, up, char::from(b'a' + k as u8), &cut.title);
    }
    paper.scale(&scale, (MARGIN.0, total - FOOT + 8.0), "vorticity about the direction of flight [1/s]");
    Ok(Figure::new("frontal_planes", paper.scene))
}

/// Ranges of y and z that hold vortices and outlines with their spots, m.
fn ranges(cuts: &[PlaneCut], spread: f64) -> [(f64, f64); 2] {
    let points = || {
        let vortices = cuts.iter().flat_map(|cut| cut.vortices.iter().map(|vortex| vortex.0));
        vortices.chain(cuts.iter().flat_map(|cut| cut.outline.iter().flatten().copied()))
    };
    [0, 1].map(|axis| {
        let (low, high) = style::span(points().map(|point| point[axis]));
        (low - SPOTS * spread, high + SPOTS * spread)
    })
}

/// Circulation of the vorticity that [`frontal_planes`] draws of `cut` alone, in the left and the right half of the plane, m2/s.
pub fn half_circulations(cut: &PlaneCut, spread: f64) -> [f64; 2] {
    let [across, up] = ranges(std::slice::from_ref(cut), spread);
    let cell = (across.1 - across.0) / CELLS as f64;
    let rows = ((up.1 - up.0) / cell).ceil() as usize;
    let field = field(cut, [across.0, up.1], cell, rows, spread);
    let mut halves = [0.0; 2];
    for (index, value) in field.iter().enumerate() {
        // A cell on the middle belongs to both halves by its parts.
        let low = across.0 + (index % CELLS) as f64 * cell;
        let left = ((low + cell) / cell).clamp(0.0, 1.0);
        halves[0] += value * cell * cell * left;
        halves[1] += value * cell * cell * (1.0 - left);
    }
    halves
}

/// Vorticity at the cells, by row from above and column from low y: sum of Gamma exp(-r^2/(2 s^2))/(2 pi s^2).
fn field(cut: &PlaneCut, [low, high]: [f64; 2], cell: f64, rows: usize, spread: f64) -> Vec<f64> {
    let peak = 1.0 / (std::f64::consts::TAU * spread * spread);
    let at = |index: usize| {
        let (row, column) = (index / CELLS, index % CELLS);
        let (y, z) = (low + (column as f64 + 0.5) * cell, high - (row as f64 + 0.5) * cell);
        let spot = |(place, circulation): &([f64; 2], f64)| {
            let square = (place[0] - y).powi(2) + (place[1] - z).powi(2);
            circulation * peak * (-0.5 * square / (spread * spread)).exp()
        };
        cut.vortices.iter().map(spot).sum()
    };
    (0..rows * CELLS).map(at).collect()
}

/// How many steps of `size` px lie from a number to the next that do not meet: `least` px or more, in steps that stay round.
fn stride(size: f64, least: f64) -> f64 {
    [1.0, 2.0, 5.0, 10.0, 20.0, 50.0].into_iter().find(|steps| steps * size >= least).unwrap_or(100.0)
}

fn frame(
    paper: &mut Paper,
    at: &impl Fn(f64, f64) -> (f64, f64),
    across: (f64, f64),
    up: (f64, f64),
    letter: char,
    title: &str,
) {
    let corners = [(across.0, up.0), (across.1, up.0), (across.1, up.1), (across.0, up.1), (across.0, up.0)];
    paper.line(corners.iter().map(|c| at(c.0, c.1)).collect(), style::INK, style::AXIS);
    let (x, y) = at(across.1, up.1);
    paper.scene.elements.push(style::words(x - 16.0, y - 10.0, letter, TextAnchor::Start, true));
    let upwards = TickScale::new(up.0, up.1).label("z up [m]");
    paper.text((x + 4.0, y - 10.0), &format!("{title}; {upwards}"), TextAnchor::Start);
    for (range, sideways) in [(across, true), (up, false)] {
        let scale = TickScale::new(range.0, range.1);
        let per_step = if sideways {
            at(0.0, 0.0).0 - at(scale.step, 0.0).0
        } else {
            at(0.0, 0.0).1 - at(0.0, scale.step).1
        };
        let step = scale.step * stride(per_step.abs(), if sideways { APART.0 } else { APART.1 });
        let (first, last) = ((range.0 / step).ceil() as i64, (range.1 / step).floor() as i64);
        for value in (first..=last).map(|k| k as f64 * step) {
            let (x, y) = if sideways { at(value, up.0) } else { at(across.1, value) };
            let (tick, place, anchor) = if sideways {
                ((x, y - 5.0), (x, y + 16.0), TextAnchor::Middle)
            } else {
                ((x + 5.0, y), (x - 6.0, y + 4.0), TextAnchor::End)
            };
            paper.line(vec![(x, y), tick], style::INK, style::AXIS);
            paper.text(place, &scale.number(value), anchor);
        }
    }
    let (x, y) = at(0.5 * (across.0 + across.1), up.0);
    paper.text(
        (x, y + 32.0),
        &TickScale::new(across.0, across.1).label("y, left wing to the left [m]"),
        TextAnchor::Middle,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spots_hold_their_circulation() {
        let cut = PlaneCut { vortices: vec![([0.0, 0.0], 0.3), ([0.1, 0.05], -0.1)], ..PlaneCut::default() };
        let (cell, spread) = (1.2 / CELLS as f64, 0.03);
        let field = field(&cut, [-0.6, 0.6], cell, CELLS, spread);
        let sum: f64 = field.iter().sum::<f64>() * cell * cell;
        assert!((sum - 0.2).abs() < 1e-9, "{sum}");
        assert_eq!(frontal_planes(&[cut], &[], spread).unwrap().name, "frontal_planes");
        assert!(frontal_planes(&[PlaneCut::default()], &[], spread).is_err());
    }

    /// Numbers up the axis of a flat wing lie apart, and are more than one.
    #[test]
    fn numbers_of_a_flat_plane_do_not_meet() {
        let vortices = vec![([2.0, 0.05], 0.3), ([-2.0, -0.05], -0.3)];
        let text = frontal_planes(&[PlaneCut { vortices, ..PlaneCut::default() }], &[], 0.1).unwrap().svg();
        assert!([">0.2<", ">−0.2<"].iter().all(|number| text.contains(number)), "{text}");
        assert!([">0.1<", ">0.3<", ">−0.1<"].iter().all(|number| !text.contains(number)), "{text}");
        assert_eq!((stride(7.6, 14.0), stride(40.0, 14.0), stride(1.0, 14.0)), (2.0, 1.0, 20.0));
    }

    #[test]
    fn a_wake_needs_rings() {
        assert!(super::super::wake(&[]).is_err());
        assert!(super::super::wake(&[super::super::WakeSheet::default()]).is_err());
        let square = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        let sheet = super::super::WakeSheet {
            wake: vec![(square, 0.2)],
            wing: vec![square],
            title: "one".into(),
            ..Default::default()
        };
        assert_eq!(super::super::wake(&[sheet.clone(), sheet]).unwrap().name, "wake");
    }
}
