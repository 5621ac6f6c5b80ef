//! Colours, sizes and weights common to all figures.

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
/// Lines that only guide the eye.
pub const GUIDE: &str = "#9a9a9a";

/// Colours that stay apart for colour-blind readers and in grey (Okabe & Ito 2008).
pub const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8b5a2b"];

/// A number as it is written beside a tick.
pub fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
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
    fn tints_are_lighter() {
        assert_eq!(tint(0), "#7fb8d8");
    }
}
