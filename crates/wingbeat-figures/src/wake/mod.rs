//! The wake of a wing: as it lies, and the vorticity that crosses a plane behind the wing.

mod colour;
mod paper;
mod planes;

pub use planes::{Cut, frontal_planes};

use kuva::render::render::TextAnchor;

use crate::path::projection::View;
use crate::write::Figure;
use crate::{Error, style};
use colour::Diverging;
use paper::Paper;

/// A point in world coordinates, m.
pub type Point = [f64; 3];

/// Azimuth and elevation of the view, degrees.
const VIEW: (f64, f64) = (-50.0, 28.0);
/// Room around the picture, px.
const MARGIN: f64 = 40.0;
/// Room below it for the scale, px.
const FOOT: f64 = 70.0;

/// A wing with its wake at an instant.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    /// What is shown, a line above the picture.
    pub title: String,
    /// Panels of the wings.
    pub wing: Vec<[Point; 4]>,
    /// Rings of the wakes with their circulation, m2/s.
    pub wake: Vec<([Point; 4], f64)>,
}

/// The wing and its wake seen from the side and above, rings coloured by circulation.
///
/// # Errors
/// A sheet without a wake.
pub fn wake(sheet: &Sheet) -> Result<Figure, Error> {
    if sheet.wake.is_empty() {
        return Err(Error::Rows { rows: 0, needed: 1 });
    }
    let view = View::new(VIEW.0, VIEW.1);
    let scale = Diverging::of(sheet.wake.iter().map(|(_, circulation)| *circulation));
    let all = sheet.wake.iter().map(|(corners, _)| corners).chain(&sheet.wing).flatten();
    let seen: Vec<(f64, f64)> = all.map(|point| view.project(*point)).collect();
    let (left, right) = style::span(seen.iter().map(|p| p.0));
    let (top, bottom) = style::span(seen.iter().map(|p| p.1));
    let size = (style::WIDTH - 2.0 * MARGIN) / (right - left).max(1e-9);
    let height = size * (bottom - top) + 2.0 * MARGIN + FOOT;
    let mut paper = Paper::new(style::WIDTH, height);
    let at = |point: &Point| {
        let (x, y) = view.project(*point);
        (MARGIN + size * (x - left), MARGIN + 16.0 + size * (y - top))
    };
    paper.text((MARGIN, 22.0), &sheet.title, TextAnchor::Start);
    // What lies further away is drawn first.
    let depth = |corners: &[Point; 4]| corners.iter().map(|corner| view.nearness(*corner)).sum::<f64>();
    let wake = sheet.wake.iter().map(|(corners, value)| (corners, scale.colour(*value), 0.9));
    let wing = sheet.wing.iter().map(|corners| (corners, "#4a4a4a".to_owned(), 1.0));
    let mut quads: Vec<_> = wake.chain(wing).collect();
    quads.sort_by(|a, b| depth(a.0).total_cmp(&depth(b.0)));
    for (corners, colour, opacity) in quads {
        paper.area(&corners.map(|corner| at(&corner)), &colour, opacity);
    }
    paper.scale(&scale, (MARGIN, height - 52.0), "circulation of the rings [m2/s]");
    Ok(Figure::new("wake", paper.scene))
}
