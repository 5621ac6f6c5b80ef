//! Colours from blue by white to red.

use crate::style;

/// Ends of the scale (Okabe & Ito's blue and vermilion, darkened) and its middle.
const LOW: [f64; 3] = [0.0, 68.0, 136.0];
const MIDDLE: [f64; 3] = [247.0, 247.0, 247.0];
const HIGH: [f64; 3] = [178.0, 60.0, 0.0];

/// A scale alike on both sides of zero. Its values are in the caller's unit, m2/s of a wake.
#[derive(Clone, Copy, Debug)]
pub struct Diverging {
    /// Value at its ends.
    pub most: f64,
}

impl Diverging {
    /// The scale that just holds `values`.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = style::span(values);
        let most = low.abs().max(high.abs());
        Self { most: if most > 0.0 { most } else { 1.0 } }
    }

    /// Colour of a value.
    pub fn colour(&self, value: f64) -> String {
        let share = (value / self.most).clamp(-1.0, 1.0);
        let end = if share < 0.0 { LOW } else { HIGH };
        let part = |i: usize| (MIDDLE[i] + (end[i] - MIDDLE[i]) * share.abs()).round() as u8;
        format!("#{:02x}{:02x}{:02x}", part(0), part(1), part(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_is_white_and_signs_have_their_colours() {
        let scale = Diverging::of([-0.5, 2.0].into_iter());
        assert_eq!(scale.most, 2.0);
        assert_eq!([0.0, -2.0, 9.0].map(|v| scale.colour(v)), ["#f7f7f7", "#004488", "#b23c00"]);
    }
}
