//! The wake of a wing: as it lies, and the vorticity that crosses a plane behind the wing.

mod colour;
mod paper;
mod phases;
mod planes;

pub use phases::{around, wake_phases};
pub use planes::{PlaneCut, frontal_planes, half_circulations};

use crate::canvas::TextAnchor;
use crate::space::{Camera, WorldPoint};
use crate::write::Figure;
use crate::{Error, style};
pub(crate) use colour::Diverging;
use paper::Paper;

/// Azimuth and elevation of the view, degrees.
const VIEW: (f64, f64) = (-50.0, 28.0);
/// Room around the picture, px.
const MARGIN: f64 = 40.0;
/// Room below it for the scale, px.
const FOOT: f64 = 70.0;

/// A wing with its wake at an instant.
#[derive(Clone, Debug, Default)]
pub struct WakeSheet {
    /// What is shown, a line above the picture.
    pub title: String,
    /// What must be known of it, a line below that.
    pub note: String,
    /// Panels of the wings.
    pub wing: Vec<[WorldPoint; 4]>,
    /// Rings of the wakes with their circulation, m2/s.
    pub wake: Vec<([WorldPoint; 4], f64)>,
    /// Outlines of the wings.
    pub outline: Vec<Vec<WorldPoint>>,
}

/// Room for title and note above a picture, px.
const HEAD: f64 = 40.0;

impl WakeSheet {
    /// Corners of all that is drawn, as seen in `view`: ranges to the right and down.
    fn seen(&self, view: &Camera) -> [(f64, f64); 2] {
        let corners = self.wake.iter().map(|(corners, _)| corners).chain(&self.wing).flatten();
        let seen: Vec<(f64, f64)> = corners.map(|point| view.project(*point)).collect();
        [style::span(seen.iter().map(|p| p.0)), style::span(seen.iter().map(|p| p.1))]
    }
}

/// Wings and wakes seen from the side and above, one below the other on one scale of length, rings coloured by circulation on one
/// scale of colour.
///
/// # Errors
/// No sheet, or one without a wake.
pub fn wake(sheets: &[WakeSheet]) -> Result<Figure, Error> {
    if sheets.is_empty() || sheets.iter().any(|sheet| sheet.wake.is_empty()) {
        return Err(Error::Rows { rows: 0, needed: 1 });
    }
    let view = Camera::orthographic(VIEW.0, VIEW.1);
    let rings = sheets.iter().flat_map(|sheet| sheet.wake.iter().map(|(_, circulation)| *circulation));
    let scale = Diverging::of(rings);
    let seen: Vec<[(f64, f64); 2]> = sheets.iter().map(|sheet| sheet.seen(&view)).collect();
    let widest = seen.iter().fold(0.0_f64, |most, [across, _]| most.max(across.1 - across.0));
    let size = (style::WIDTH - 2.0 * MARGIN) / widest.max(1e-9);
    let heights: Vec<f64> = seen.iter().map(|[_, down]| size * (down.1 - down.0) + HEAD + MARGIN).collect();
    let total = heights.iter().sum::<f64>() + FOOT;
    let mut paper = Paper::new(style::WIDTH, total);
    let mut top = 0.0;
    for ((sheet, [across, down]), height) in sheets.iter().zip(&seen).zip(&heights) {
        let at = |point: &WorldPoint| {
            let (x, y) = view.project(*point);
            (MARGIN + size * (x - across.0), top + HEAD + size * (y - down.0))
        };
        paper.text((MARGIN, top + 22.0), &sheet.title, TextAnchor::Start);
        paper.text((MARGIN, top + 38.0), &sheet.note, TextAnchor::Start);
        draw(&mut paper, sheet, &view, &scale, at);
        top += height;
    }
    paper.scale(&scale, (MARGIN, total - 52.0), "circulation of the rings [m2/s]");
    Ok(Figure::new("wake", paper.scene))
}

/// Draws what lies further away first.
fn draw(
    paper: &mut Paper,
    sheet: &WakeSheet,
    view: &Camera,
    scale: &Diverging,
    at: impl Fn(&WorldPoint) -> (f64, f64),
) {
    let depth = |corners: &[WorldPoint; 4]| corners.iter().map(|corner| view.nearness(*corner)).sum::<f64>();
    let wake = sheet.wake.iter().map(|(corners, value)| (corners, scale.colour(*value), 0.9));
    let wing = sheet.wing.iter().map(|corners| (corners, "#4a4a4a".to_owned(), 1.0));
    let mut quads: Vec<_> = wake.chain(wing).collect();
    wingbeat::math::order::ascend_by(&mut quads, |item| depth(item.0));
    for (corners, colour, opacity) in quads {
        paper.area(&corners.map(|corner| at(&corner)), &colour, opacity);
    }
}
