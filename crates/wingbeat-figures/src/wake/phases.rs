//! Wing and wake in space at phases of the stroke.

use super::colour::Diverging;
use super::paper::Paper;
use super::{VIEW, WakeSheet};
use crate::canvas::TextAnchor;
use crate::space::{Bounds, Camera, Pane, Space, WorldPoint};
use crate::write::Figure;
use crate::{Error, style};

/// Most height of a picture, px.
const HIGHEST: f64 = 300.0;
/// Width of all on a slide, px.
const WIDE: f64 = 1500.0;
/// Room above it for two lines of words, px.
const WORDS: f64 = 44.0;
/// What of the room above a picture, where its axes have no numbers, the words take, px.
const FREE: f64 = 34.0;
/// Room below all for the scale of colour, px.
const FOOT: f64 = 64.0;
/// From line to line of the notes, px.
const LINE: f64 = 18.0;

/// Wings and wakes in space, two in a row on one scale of length and one of colour, with axes, a bar of length and the outline of
/// the wing; `notes` stand above, a line each, and `wide` is for a slide. Axes are along flight, to the left and up, from the body.
///
/// # Errors
/// No sheet, or one without a wake.
pub fn wake_phases(sheets: &[WakeSheet], notes: &[String], wide: bool) -> Result<Figure, Error> {
    let points = sheets.iter().flat_map(|sheet| {
        sheet.wake.iter().flat_map(|(corners, _)| corners).chain(sheet.outline.iter().flatten()).copied()
    });
    let rings = sheets.iter().all(|sheet| !sheet.wake.is_empty());
    let bounds = Bounds::of(points).filter(|_| rings).ok_or(Error::Rows { rows: 0, needed: 1 })?;
    let scale = Diverging::of(sheets.iter().flat_map(|sheet| sheet.wake.iter().map(|ring| ring.1)));
    let head = LINE * notes.len() as f64 + 8.0;
    let rows = sheets.len().div_ceil(2) as f64;
    let page = if wide { WIDE } else { style::WIDTH };
    let (camera, width) = (Camera::orthographic(VIEW.0, VIEW.1), 0.5 * page);
    // A slide is filled to its height.
    let slide = (page * 9.0 / 16.0 - head - FOOT) / rows - (WORDS - FREE);
    let most = if wide { slide.max(0.5 * HIGHEST) } else { HIGHEST };
    let height = Space::height(&camera, &bounds, width, most);
    let row = height + WORDS - FREE;
    let total = head + rows * row + FOOT;
    let mut paper = Paper::new(page, total);
    for (k, note) in notes.iter().enumerate() {
        paper.text((14.0, LINE * (k + 1) as f64), note, TextAnchor::Start);
    }
    for (k, sheet) in sheets.iter().enumerate() {
        let (x, y) = (width * (k % 2) as f64, head + row * (k / 2) as f64);
        let letter = char::from(b'a' + (k % 26) as u8);
        paper.scene.elements.push(style::words(x + 14.0, y + 16.0, letter, TextAnchor::Start, true));
        paper.text((x + 30.0, y + 16.0), &sheet.title, TextAnchor::Start);
        paper.text((x + 30.0, y + 34.0), &sheet.note, TextAnchor::Start);
        let pane = Pane { x, y: y + WORDS - FREE, width, height };
        drawn(sheet, Space::new(camera, bounds, pane), &scale).paint(&mut paper.scene);
    }
    paper.scale(&scale, (54.0, total - FOOT + 14.0), "circulation of the rings [m2/s]");
    Ok(Figure::new("wake_phases", paper.scene))
}

fn drawn(sheet: &WakeSheet, mut space: Space, scale: &Diverging) -> Space {
    space.axes(["along flight [m]", "left [m]", "up [m]"]);
    for (corners, circulation) in &sheet.wake {
        space.area(corners, &scale.colour(*circulation), 0.9, None);
    }
    for corners in &sheet.wing {
        space.area(corners, WING, 0.85, None);
    }
    for edge in &sheet.outline {
        space.outline(edge, style::INK, 1.3);
    }
    space.bar(space.round_length());
    space
}

/// Colour of the wing.
const WING: &str = "#8f8f8f";

/// The outline of a surface from its leading and trailing edge: once around.
pub fn around(leading: &[WorldPoint], trailing: &[WorldPoint]) -> Vec<WorldPoint> {
    let closed = leading.first().copied();
    leading.iter().chain(trailing.iter().rev()).copied().chain(closed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_phase_has_axes_a_bar_and_its_words() {
        let ring = [[0.0, 0.0, 0.0], [0.0, 0.2, 0.0], [-0.4, 0.2, 0.1], [-0.4, 0.0, 0.1]];
        let outline = vec![around(&ring[..2], &ring[2..])];
        let sheet = |title: &str| WakeSheet {
            title: title.into(),
            note: "strongest".into(),
            wing: vec![ring],
            wake: vec![(ring, 0.2)],
            outline: outline.clone(),
        };
        let figure = wake_phases(&["one", "two", "three"].map(sheet), &["attached".into()], false).unwrap();
        let text = figure.svg();
        assert_eq!(text.matches("along flight [m]").count(), 3);
        assert_eq!(text.matches("100 mm").count(), 3);
        assert!(text.contains("attached") && text.contains("three"));
        assert_eq!(outline[0].len(), 5);
        // Two rows fill a slide to its height and no more.
        let slide = wake_phases(&["one", "two", "three"].map(sheet), &["attached".into()], true).unwrap();
        let filled = slide.scene.height / (slide.scene.width * 9.0 / 16.0);
        assert!((0.9..1.0 + 1e-9).contains(&filled), "{filled}");
        assert!(
            wake_phases(&[], &[], true).is_err() && wake_phases(&[WakeSheet::default()], &[], false).is_err()
        );
    }
}
