//! Panels of curves over a common axis, one below another.

use crate::canvas::{Canvas, Primitive, TextAnchor};
use crate::plot_frame::{FrameAxis, PlotFrame};
use crate::scale::TickScale;
use crate::style;

/// Most points of a curve: four of each pixel's width.
pub const MOST_POINTS: usize = 2800;

/// Room to the left of a panel, for the numbers of its axis, px.
const LEFT: f64 = 58.0;
/// Room above a panel, for its title, px.
const HEAD: f64 = 28.0;
/// Room below a panel, px.
const GAP: f64 = 8.0;
/// Room below the last panel, for the common axis, px.
const FOOT: f64 = 46.0;
/// Length of the sample of a curve in the legend, px: longer than any pattern of strokes.
const SAMPLE: f64 = 34.0;
/// Room before and after the sample, px.
const BESIDE: f64 = 8.0;
/// From name to name in the legend, px, and the least where a low panel has many.
const LINE: f64 = 17.0;
const CLOSE: f64 = 13.5;
/// Room around the figure, px.
const PADDING: f64 = 6.0;

/// Most names in the legend of a panel, or of a grid of panels.
pub const MOST_NAMED: usize = 8;
/// Share of the largest value of its unit in a figure below which a curve is rounding, drawn as zero.
const ROUNDING: f64 = 1e-9;

/// A curve with its name in the legend.
pub struct PanelCurve {
    pub name: String,
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub colour: String,
    /// Thickness of the line, px.
    pub weight: f64,
    /// Strokes and gaps, px; a whole line where there are none.
    pub dashes: Option<&'static str>,
}

impl PanelCurve {
    /// A curve, in the units of the axes, of ordinary weight in the colour and the strokes number `index`; of one of many
    /// points, what would be seen.
    pub fn new(name: impl Into<String>, x: &[f64], y: Vec<f64>, index: usize) -> Self {
        let kept = seen(&y, MOST_POINTS);
        let of = |values: &[f64]| kept.iter().map(|k| values[*k]).collect();
        Self {
            name: name.into(),
            x: of(x),
            y: of(&y),
            colour: style::colour(index).into(),
            weight: style::CURVE,
            dashes: style::dashes(index),
        }
    }

    /// The same as a whole line.
    pub fn whole(self) -> Self {
        Self { dashes: None, ..self }
    }

    /// A whole black line, heavier than others: the sum of what the others show, in the units of the axes.
    pub fn total(name: &str, x: &[f64], y: Vec<f64>) -> Self {
        let total = Self::new(name, x, y, 0);
        Self { colour: style::INK.into(), weight: 1.5 * style::CURVE, ..total }
    }

    /// A fine black line: what the others are to follow, in the units of the axes.
    pub fn reference(name: &str, x: &[f64], y: Vec<f64>) -> Self {
        let reference = Self::new(name, x, y, 0);
        Self { colour: style::INK.into(), weight: style::FINE, ..reference }
    }
}

/// Which points of a curve, in the unit of its axis, to draw, `most` or fewer: of every stretch its first, lowest, highest and
/// last, so that no peak is lost.
pub fn seen(y: &[f64], most: usize) -> Vec<usize> {
    if y.len() <= most {
        return (0..y.len()).collect();
    }
    let stretch = y.len().div_ceil((most / 4).max(1));
    let mut kept = Vec::with_capacity(most);
    for from in (0..y.len()).step_by(stretch) {
        let to = (from + stretch).min(y.len());
        let by = |a: &usize, b: &usize| y[*a].total_cmp(&y[*b]);
        let there = || (from..to).filter(|k| y[*k].is_finite());
        // A gap stays one.
        let mut points = vec![from, (from..to).find(|k| !y[*k].is_finite()).unwrap_or(to - 1)];
        points.extend(there().min_by(by).into_iter().chain(there().max_by(by)));
        points.sort_unstable();
        points.dedup();
        kept.extend(points);
    }
    kept
}

/// Curves over a common axis.
#[derive(Default)]
pub struct FigurePanel {
    /// What is drawn, with its unit in brackets.
    pub title: String,
    pub curves: Vec<PanelCurve>,
    /// What the curves may not leave, in the unit of the title; shaded outside.
    pub limits: Option<(f64, f64)>,
    /// Where curves should lie: (x, low, high) along x, in the units of the axes, shaded inside.
    pub bands: Vec<Vec<(f64, f64, f64)>>,
    /// Whether the bands are narrow, and so darker.
    pub narrow: bool,
    /// Where thin lines lie, which the axis holds, in the unit of the title.
    pub levels: Vec<f64>,
}

impl FigurePanel {
    /// Curves with a thin line at zero.
    pub fn new(title: impl Into<String>, curves: Vec<PanelCurve>) -> Self {
        Self { title: title.into(), curves, levels: vec![0.0], ..Self::default() }
    }
}

/// The panels one below another over the axis `x_label`, which spans all curves; `height` is that of a panel, px.
pub fn stacked(panels: Vec<FigurePanel>, x_label: &str, height: f64) -> Canvas {
    stacked_with(panels, x_label, height, &[])
}

/// As [`stacked`], with broken lines up every panel at the places `marks`, in the unit of x.
pub fn stacked_with(panels: Vec<FigurePanel>, x_label: &str, height: f64, marks: &[f64]) -> Canvas {
    stacked_from(panels, x_label, height, marks, b'a')
}

/// The panels in two stacks beside one another; `height` is that of a panel, px.
pub fn two_stacks(mut panels: Vec<FigurePanel>, x_label: &str, height: f64) -> Canvas {
    let right = panels.split_off(panels.len().div_ceil(2));
    let letter = b'a' + panels.len() as u8;
    let left = stacked_from(panels, x_label, height, &[], b'a');
    if right.is_empty() {
        left
    } else {
        style::beside(left, stacked_from(right, x_label, height, &[], letter))
    }
}

/// As [`stacked_with`], the first panel called `letter`.
fn stacked_from(
    mut panels: Vec<FigurePanel>,
    x_label: &str,
    height: f64,
    marks: &[f64],
    letter: u8,
) -> Canvas {
    quieten(&mut panels);
    let count = panels.len();
    let (left, right) = x_range(&panels);
    let across = TickScale::new(left, right).whole();
    let legend = legend_width(&panels);
    let titles: Vec<String> = panels.iter().map(|panel| upwards(panel).label(&panel.title)).collect();
    let top = |row: usize| PADDING + height * row as f64;
    let beside = style::WIDTH - PADDING - legend + BESIDE;
    let legends: Vec<Vec<Primitive>> = panels
        .iter()
        .enumerate()
        .map(|(row, panel)| named(&panel.curves, (beside, top(row) + HEAD + BESIDE), height))
        .collect();
    let last_row = height + FOOT - GAP;
    let wide = style::WIDTH - 2.0 * PADDING;
    let mut scene = Canvas::new(style::WIDTH, height * (count as f64 - 1.0) + last_row + 2.0 * PADDING);
    for (row, panel) in panels.into_iter().enumerate() {
        let last = row + 1 == count;
        let (tall, foot) = if last { (last_row, FOOT) } else { (height, GAP) };
        let place = [PADDING, top(row), wide, tall];
        let axis = FrameAxis::of(across);
        let axis = if last { axis.labelled(across.label(x_label)) } else { axis.without_numbers() };
        let mut frame =
            PlotFrame::new(place, [LEFT, legend, HEAD, foot], axis, FrameAxis::of(upwards(&panel)));
        fill(&mut frame, panel);
        marks
            .iter()
            .for_each(|at| frame.upwards(*at, style::GUIDE, style::GUIDE_WEIGHT, Some(style::GUIDE_DASHES)));
        frame.draw(&mut scene);
    }
    scene.elements.extend(legends.into_iter().flatten());
    for (row, title) in titles.into_iter().enumerate() {
        let y = top(row) + HEAD - 8.0;
        scene.elements.push(style::words(
            PADDING + 8.0,
            y,
            char::from(letter + row as u8),
            TextAnchor::Start,
            true,
        ));
        scene.elements.push(style::words(PADDING + LEFT, y, title, TextAnchor::Start, false));
    }
    scene
}

/// Draws as zero what is rounding beside the other curves of its unit, the words in brackets in the title of its panel.
fn quieten(panels: &mut [FigurePanel]) {
    let unit = |panel: &FigurePanel| panel.title.split_once('[').map_or("", |(_, unit)| unit).to_owned();
    let size =
        |curve: &PanelCurve| curve.y.iter().map(|y| y.abs()).filter(|y| y.is_finite()).fold(0.0, f64::max);
    let units: Vec<String> = panels.iter().map(unit).collect();
    let sizes: Vec<f64> =
        panels.iter().map(|panel| panel.curves.iter().map(size).fold(0.0, f64::max)).collect();
    for (panel, unit) in panels.iter_mut().zip(&units) {
        let same = sizes.iter().zip(&units).filter(|(_, other)| *other == unit);
        let largest = same.map(|(size, _)| *size).fold(0.0, f64::max);
        for curve in panel.curves.iter_mut().filter(|curve| size(curve) < ROUNDING * largest) {
            curve.y.iter_mut().filter(|y| y.is_finite()).for_each(|y| *y = 0.0);
        }
    }
}

/// Draws in the frame what the panel has: shades, thin lines and curves, in this order.
fn fill(frame: &mut PlotFrame, panel: FigurePanel) {
    let TickScale { low, high, .. } = upwards(&panel);
    if let Some((floor, ceiling)) = panel.limits {
        for (from, to) in [(low, floor), (ceiling, high)] {
            frame.shade(from, to, style::SHADE, 0.6);
        }
    }
    let (colour, opacity) = if panel.narrow { (style::DARK_SHADE, 0.9) } else { (style::SHADE, 0.6) };
    panel.bands.iter().for_each(|edges| frame.band(edges, colour, opacity));
    let limits = panel.limits.into_iter().flat_map(|(floor, ceiling)| [floor, ceiling]);
    let levels = panel.levels.into_iter().filter(|level| low < *level && *level < high);
    limits.chain(levels).for_each(|level| frame.guide(level));
    for curve in panel.curves {
        frame.line(curve.x.into_iter().zip(curve.y), &curve.colour, curve.weight, curve.dashes);
    }
}

/// A sample and the name of each curve that has one, from the middle of the first sample's left end `(x, y)` down by less than `height`,
/// where the legend of the next panel begins.
fn named(curves: &[PanelCurve], (x, y): (f64, f64), height: f64) -> Vec<Primitive> {
    let named: Vec<&PanelCurve> = curves.iter().filter(|curve| !curve.name.is_empty()).collect();
    // Beside them their sum.
    let most = (MOST_NAMED + 1).min((height / CLOSE) as usize).max(1);
    let shown = if named.len() > most { most - 1 } else { named.len() };
    let line = (height / (named.len().min(most) as f64 + 0.5)).min(LINE);
    let left = (named.len() > shown).then(|| {
        let words = format!("and {} more", named.len() - shown);
        style::words(x + SAMPLE + BESIDE, y + line * shown as f64 + 4.5, words, TextAnchor::Start, false)
    });
    let named = named.into_iter().take(shown).enumerate();
    let entry = |(row, curve): (usize, &PanelCurve)| {
        let y = y + line * row as f64;
        let sample = style::sample((x, y), (x + SAMPLE, y), &curve.colour, curve.weight, curve.dashes);
        let name = style::words(x + SAMPLE + BESIDE, y + 4.5, &curve.name, TextAnchor::Start, false);
        [sample, name]
    };
    named.flat_map(entry).chain(left).collect()
}

fn x_range(panels: &[FigurePanel]) -> (f64, f64) {
    style::span(panels.iter().flat_map(|panel| &panel.curves).flat_map(|curve| curve.x.iter().copied()))
}

/// The axis of the curves, their limits and bands with a margin.
fn upwards(panel: &FigurePanel) -> TickScale {
    let limits = panel.limits.into_iter().flat_map(|(low, high)| [low, high]);
    let bands = panel.bands.iter().flatten().flat_map(|edge| [edge.1, edge.2]);
    let levels = panel.levels.iter().copied();
    let values = panel.curves.iter().flat_map(|curve| curve.y.iter().copied());
    let (low, high) = style::span(values.chain(limits).chain(bands).chain(levels));
    TickScale::padded(low, high, 0.07)
}

/// Room to the right for the longest name.
fn legend_width(panels: &[FigurePanel]) -> f64 {
    let names = panels.iter().flat_map(|panel| &panel.curves).map(|curve| curve.name.chars().count());
    SAMPLE + 3.0 * BESIDE + 7.4 * names.max().unwrap_or(0) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_peak_of_a_long_curve_is_lost() {
        let mut y: Vec<f64> = (0..1_000_000).map(|k| (f64::from(k) * 1e-4).sin()).collect();
        (y[123_456], y[777_777], y[500_000]) = (9.0, -9.0, f64::NAN);
        let kept = seen(&y, MOST_POINTS);
        assert!(kept.len() <= MOST_POINTS && kept.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(kept.contains(&123_456) && kept.contains(&777_777));
        assert_eq!((kept[0], kept.last()), (0, Some(&999_999)));
        assert_eq!(seen(&y[..5], 5), [0, 1, 2, 3, 4]);
    }
}
