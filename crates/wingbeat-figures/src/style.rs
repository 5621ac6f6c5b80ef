//! Colours, sizes, weights and axes common to all figures.

use crate::canvas::{Canvas, Colour, PaperPoint, PathData, Primitive, TextAnchor};

/// Width of a figure over the full width of a page, px at 120 px per inch.
pub const WIDTH: f64 = 860.0;
/// Height of one panel, px.
pub const PANEL: f64 = 190.0;
/// Letters of axes, legends and notes, px.
pub const LETTERS: u32 = 13;
/// Letters of tick labels, px.
pub const TICKS: u32 = 12;
/// Weight of a curve, px.
pub const CURVE: f64 = 1.6;
/// Weight of a curve that another may cover, px.
pub const BROAD: f64 = 3.2;
/// Weight of a curve that only explains another, px.
pub const FINE: f64 = 1.0;
/// Weight of an axis, px.
pub const AXIS: f64 = 1.0;
/// Ink of axes and letters.
pub const INK: &str = "#222222";
/// Ground of what is not allowed, and of shadows.
pub const SHADE: &str = "#d9d9d9";
/// The same where little of it is to be seen.
pub const DARK_SHADE: &str = "#a0a0a0";
/// Lines that only guide the eye.
pub const GUIDE: &str = "#9a9a9a";
/// Weight of such a line, px.
pub const GUIDE_WEIGHT: f64 = 0.8;
/// Strokes and gaps where a line is dashed, px.
pub const GUIDE_DASHES: &str = "6 4";

/// Colours that stay apart for colour-blind readers and in grey (Okabe & Ito 2008).
pub const COLOURS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8b5a2b", "#5e4fa2"];
/// Strokes and gaps, px, that tell as many curves apart without colour; the first is whole.
const DASHES: [&str; 8] = ["", "9 4", "2 3", "10 3 2 3", "16 4", "5 3", "10 3 2 3 2 3", "1 5"];
/// Number of the colour of each side of the robot, in every figure.
pub const SIDES: [(&str, usize); 2] = [("left", 0), ("right", 1)];

/// A number, in the unit that is written beside it (any unit of the caller), to nine digits, in the shortest form.
pub fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.8e}").parse().unwrap_or(value);
    let text = rounded.to_string();
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}

/// The power of ten whose exponent (dimensionless) stands at a tick.
pub fn decade(exponent: f64) -> String {
    if (-2.0..=3.0).contains(&exponent) {
        return number(10_f64.powf(exponent));
    }
    decade_of(exponent.round() as i32)
}

/// Ten to the power of `exponent`, raised.
pub fn decade_of(exponent: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        other => char::from_u32(other as u32 - '0' as u32 + '⁰' as u32).unwrap_or(other),
    };
    format!("10{}", exponent.to_string().chars().map(digit).collect::<String>())
}

/// Strokes and gaps of the curve number `index`; none where it is whole.
pub fn dashes(index: usize) -> Option<&'static str> {
    Some(DASHES[index % DASHES.len()]).filter(|dashes| !dashes.is_empty())
}

/// A line on a figure from one point to another, px, with strokes and gaps where there are any.
pub fn sample(
    from: (f64, f64),
    to: (f64, f64),
    colour: &str,
    weight: f64,
    dashes: Option<&str>,
) -> Primitive {
    let ((x1, y1), (x2, y2)) = (from, to);
    let (stroke, stroke_dasharray) = (Colour::from(colour), dashes.map(Into::into));
    Primitive::Line { x1, y1, x2, y2, stroke, stroke_width: weight, stroke_dasharray }
}

/// What is on a drawing, moved to the right and down, px.
pub fn moved(scene: Canvas, right: f64, down: f64) -> Vec<Primitive> {
    let begin = Primitive::GroupStart { right, down };
    let inside = scene.elements.into_iter();
    std::iter::once(begin).chain(inside).chain([Primitive::GroupEnd]).collect()
}

/// Two drawings beside one another.
pub fn beside(mut left: Canvas, right: Canvas) -> Canvas {
    let from = left.width;
    left.height = left.height.max(right.height);
    left.width += right.width;
    left.elements.extend(moved(right, from, 0.0));
    left
}

/// An area without an outline, its corners in px.
pub fn area(corners: &[(f64, f64)], colour: &str, opacity: f64) -> Primitive {
    Primitive::Path(Box::new(PathData {
        pieces: vec![closed(corners)],
        fill: Colour::from(colour),
        stroke: Colour::None,
        stroke_width: 0.0,
        opacity: Some(opacity),
    }))
}

/// A filled disc without an edge; its centre and radius in px.
pub fn disc((cx, cy): PaperPoint, r: f64, colour: &str) -> Primitive {
    let fill = Colour::from(colour);
    Primitive::Circle { cx, cy, r, fill, fill_opacity: None, stroke: None, stroke_width: None }
}

/// The corners of an area, px, with the first at the end again.
pub fn closed(corners: &[PaperPoint]) -> Vec<PaperPoint> {
    corners.iter().chain(corners.first()).copied().collect()
}

/// Words on a figure, px from its upper left corner.
pub fn words(x: f64, y: f64, content: impl Into<String>, anchor: TextAnchor, bold: bool) -> Primitive {
    let color = Some(Colour::from(INK));
    Primitive::Text { x, y, content: content.into(), size: LETTERS, anchor, rotate: None, bold, color }
}

/// Words in the size of the numbers of axes, px from the upper left corner.
pub fn small(x: f64, y: f64, content: String, anchor: TextAnchor) -> Primitive {
    let color = Some(Colour::from(INK));
    Primitive::Text { x, y, content, size: TICKS, anchor, rotate: None, bold: false, color }
}

/// Red, green and blue of a share from 0, dark, to 1, light, which stay in order in grey and for colour-blind readers.
pub fn viridis(share: f64) -> [u8; 3] {
    colorous::VIRIDIS.eval_continuous(share.clamp(0.0, 1.0)).as_array()
}

/// Least and largest of the finite `values`, in the unit of these; 0 and 1 when there are none.
pub fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = values.filter(|value| value.is_finite());
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high { (0.0, 1.0) } else { (low, high) }
}

/// The colour of the curve number `index`.
pub fn colour(index: usize) -> &'static str {
    COLOURS[index % COLOURS.len()]
}

/// The colour number `index`, halfway to white.
pub fn tint(index: usize) -> String {
    let part = |at: usize| u8::from_str_radix(&colour(index)[at..at + 2], 16).unwrap_or(0);
    let [r, g, b] = [1, 3, 5].map(|at| (u16::from(part(at)) + 255) / 2);
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(-0.5), "−0.5");
        assert_eq!(number(2.0), "2");
        assert_eq!(number(-0.0), "0");
    }

    #[test]
    fn decades_are_powers() {
        assert_eq!(decade(-12.0), "10⁻¹²");
        assert_eq!(decade(-1.0), "0.1");
        assert_eq!(decade(4.0), "10⁴");
    }

    #[test]
    fn tints_are_lighter() {
        assert_eq!(tint(0), "#7fb8d8");
    }
}
