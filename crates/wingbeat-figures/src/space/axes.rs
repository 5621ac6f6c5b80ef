//! Axes of a box of space: the walls behind it with a grid, numbers and names at its edges, and a bar of length.

use super::{Space, WorldPoint};
use crate::canvas::TextAnchor;
use crate::scale::TickScale;
use crate::style;

/// Colour of the grid.
const GRID: &str = "#e4e4e4";
/// Least length of an axis on paper that is told, px.
const SHORTEST: f64 = 24.0;
/// Least distance of two numbers on an axis, px.
const APART: f64 = 34.0;
/// From an edge to its numbers and to its name, px.
const NUMBERS: f64 = 13.0;
const NAME: f64 = 42.0;
/// Width of a letter, px.
const LETTER: f64 = 8.0;

/// From number to number below it, px.
const HIGH: f64 = 15.0;

/// 1, 2 or 5 times a power of ten, not below `least` by more than a quarter.
pub(crate) fn round_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().find(|n| n * power >= 0.75 * least).unwrap_or(10.0) * power
}

/// By what vector, px, the second of two numbers on a short axis moves on along it, and the first back, so that they do not meet.
fn meeting([(one, first), (other, second)]: [((f64, f64), String); 2]) -> (f64, f64) {
    let (along, down) = (other.0 - one.0, other.1 - one.1);
    let wide = LETTER * first.chars().count().max(second.chars().count()) as f64 + 0.5 * LETTER;
    // As far as the nearer of both ways apart: beside or below one another.
    let short = |part: f64, least: f64| if part == 0.0 { f64::INFINITY } else { least / part.abs() };
    let times = short(along, wide).min(short(down, HIGH));
    if !times.is_finite() || times <= 1.0 {
        return (0.0, 0.0);
    }
    (0.5 * (times - 1.0) * along, 0.5 * (times - 1.0) * down)
}

impl Space {
    /// The three walls behind the box with a grid, and numbers and the name, with its unit in brackets, of each axis that has a
    /// length in this view.
    pub fn axes(&mut self, names: [&str; 3]) {
        // Of both walls across an axis the one behind.
        let behind: [bool; 3] = std::array::from_fn(|i| self.wall(i, true) < self.wall(i, false));
        let ticks: [Vec<f64>; 3] = std::array::from_fn(|i| self.ticks(i));
        for across in 0..3 {
            for along in (0..3).filter(|axis| *axis != across) {
                let third = 3 - across - along;
                for tick in &ticks[along] {
                    let mut ends = [self.corner(behind); 2];
                    ends.iter_mut().for_each(|end| end[along] = *tick);
                    (ends[0][third], ends[1][third]) = (self.bounds.low[third], self.bounds.high[third]);
                    self.behind(ends, GRID, 0.8);
                }
            }
        }
        for (axis, name) in names.into_iter().enumerate() {
            self.edge(axis, behind, &ticks[axis], name);
        }
    }

    /// How near the middle of the wall at the high or low end of an axis is.
    fn wall(&self, axis: usize, high: bool) -> f64 {
        let mut middle: WorldPoint =
            std::array::from_fn(|i| 0.5 * (self.bounds.low[i] + self.bounds.high[i]));
        middle[axis] = if high { self.bounds.high[axis] } else { self.bounds.low[axis] };
        self.camera.nearness(middle)
    }

    fn corner(&self, high: [bool; 3]) -> WorldPoint {
        std::array::from_fn(|i| if high[i] { self.bounds.high[i] } else { self.bounds.low[i] })
    }

    fn behind(&mut self, [from, to]: [WorldPoint; 2], colour: &str, weight: f64) {
        let line = style::sample(self.at(from), self.at(to), colour, weight, None);
        self.back.push(line);
    }

    /// Multiples of a round step on an axis; none where it is seen end on.
    fn ticks(&self, axis: usize) -> Vec<f64> {
        let (low, high) = (self.bounds.low[axis], self.bounds.high[axis]);
        let length = self.on_paper(self.bounds.low, axis);
        if !(length >= SHORTEST) {
            return Vec::new();
        }
        // No finer than the numbers beside the ticks can tell apart.
        let finest = TickScale::new(low, high).step;
        let ends = |step: f64| ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
        let apart = round_step((high - low) * APART / length).max(finest);
        let mut step = apart;
        // A single number tells no scale; of finer ones the outer two are furthest apart.
        while ends(step).1 <= ends(step).0 && round_step(0.4 * step) >= finest {
            step = round_step(0.4 * step);
        }
        let (first, last) = ends(step);
        let every = if step < apart { (last - first).max(1) as usize } else { 1 };
        (first..=last).step_by(every).map(|k| k as f64 * step).collect()
    }

    /// Whether an axis that is seen has two ticks or more.
    #[cfg(test)]
    pub(super) fn has_scale(&self, axis: usize) -> bool {
        self.ticks(axis).len() > 1
    }

    /// Length on paper of the edge along `axis` that begins at `from`, px.
    fn on_paper(&self, from: WorldPoint, axis: usize) -> f64 {
        let mut to = from;
        to[axis] = self.bounds.high[axis];
        let ((a, b), (c, d)) = (self.at(from), self.at(to));
        (c - a).hypot(d - b)
    }

    /// Numbers and name at the edge along `axis` that lies outside of what is seen, where one wall behind ends: of both the lower one,
    /// of an upright axis the one to the left.
    fn edge(&mut self, axis: usize, behind: [bool; 3], ticks: &[f64], name: &str) {
        let [first, second] = [(axis + 1) % 3, (axis + 2) % 3];
        let candidates = [first, second].map(|turned| {
            let mut high = behind;
            high[turned] = !high[turned];
            high[axis] = false;
            let from = self.corner(high);
            high[axis] = true;
            [from, self.corner(high)]
        });
        let middle = |edge: &[WorldPoint; 2]| {
            let [a, b] = edge.map(|end| self.at(end));
            (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1))
        };
        let upright = axis == 2;
        let order = |edge: &[WorldPoint; 2]| if upright { -middle(edge).0 } else { middle(edge).1 };
        let chosen =
            if order(&candidates[0]) >= order(&candidates[1]) { candidates[0] } else { candidates[1] };
        if ticks.is_empty() {
            return;
        }
        // Outwards: across the edge on paper and away from the middle of the box.
        let [a, b] = chosen.map(|end| self.at(end));
        let length = (b.0 - a.0).hypot(b.1 - a.1).max(1e-9);
        let normal = ((b.1 - a.1) / length, -(b.0 - a.0) / length);
        let centre = self.at(std::array::from_fn(|i| 0.5 * (self.bounds.low[i] + self.bounds.high[i])));
        let here = middle(&chosen);
        let outside = (here.0 - centre.0) * normal.0 + (here.1 - centre.1) * normal.1;
        let out = if outside < 0.0 { (-normal.0, -normal.1) } else { normal };
        self.behind(chosen, style::INK, style::AXIS);
        let anchor = match out.0 {
            x if x < -0.35 => TextAnchor::End,
            x if x > 0.35 => TextAnchor::Start,
            _ => TextAnchor::Middle,
        };
        let scale = TickScale::new(self.bounds.low[axis], self.bounds.high[axis]);
        let on_axis = |tick: f64| {
            let mut point = chosen[0];
            point[axis] = tick;
            self.at(point)
        };
        let spread = match *ticks {
            [first, second] => {
                meeting([(on_axis(first), scale.number(first)), (on_axis(second), scale.number(second))])
            }
            _ => (0.0, 0.0),
        };
        for (index, tick) in ticks.iter().enumerate() {
            let mut point = chosen[0];
            point[axis] = *tick;
            let place = self.at(point);
            let tip = (place.0 + 4.0 * out.0, place.1 + 4.0 * out.1);
            self.back.push(style::sample(place, tip, style::INK, style::AXIS, None));
            let number = scale.number(*tick);
            // A number that would begin left of the pane begins there.
            let begins = place.0 + NUMBERS * out.0 - LETTER * number.chars().count() as f64;
            let before = if anchor == TextAnchor::End { (self.pane.x - begins).max(0.0) } else { 0.0 };
            let aside = if index == 0 { -1.0 } else { 1.0 };
            let shift =
                (NUMBERS * out.0 + before + aside * spread.0, NUMBERS * out.1 + 4.5 + aside * spread.1);
            self.label(point, shift, &number, anchor);
        }
        // An upright axis has its name above its upper end.
        if upright {
            self.label(chosen[1], (4.0, -10.0), &scale.label(name), TextAnchor::End);
            return;
        }
        let middle: WorldPoint = std::array::from_fn(|i| 0.5 * (chosen[0][i] + chosen[1][i]));
        let text = scale.label(name);
        // A name that begins near the right end of the pane ends there.
        let ends = self.at(middle).0 + NAME * out.0 + LETTER * text.chars().count() as f64;
        let beyond = match anchor {
            TextAnchor::Start => (ends - self.pane.x - self.pane.width).max(0.0),
            _ => 0.0,
        };
        self.label(middle, (NAME * out.0 - beyond, NAME * out.1 + 4.5), &text, anchor);
    }

    /// A bar of `length` m in the lower left corner of the pane, true at the target of the view and across it.
    pub fn bar(&mut self, length: f64) {
        let (x, y) = (self.pane.x + 8.0, self.pane.y + self.pane.height - 8.0);
        let right = x + self.scale * length;
        let text = if length < 1.0 {
            format!("{} mm", style::number(1e3 * length))
        } else {
            format!("{} m", style::number(length))
        };
        self.front.push(style::words(0.5 * (x + right), y - 6.0, text, TextAnchor::Middle, false));
        self.front.push(style::sample((x, y), (right, y), style::INK, 2.4, None));
    }

    /// A round length, m, of which the bar takes about a fifth of the pane's width.
    pub fn round_length(&self) -> f64 {
        round_step(0.2 * self.pane.width / self.scale.max(1e-9))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_numbers_that_would_meet_move_apart_along_their_axis() {
        let number = |at: (f64, f64), text: &str| (at, text.to_owned());
        let (x, y) = meeting([number((0.0, 0.0), "−1"), number((16.0, -9.0), "1")]);
        assert!(x > 0.0 && (x * -9.0 - y * 16.0).abs() < 1e-9, "{x} {y}");
        let (along, down) = (16.0 + 2.0 * x, 9.0 - 2.0 * y);
        assert!(along >= 2.5 * LETTER - 1e-9 || down >= HIGH - 1e-9, "{along} {down}");
        assert_eq!(meeting([number((0.0, 0.0), "−1"), number((40.0, 0.0), "1")]), (0.0, 0.0));
        assert_eq!(meeting([number((0.0, 0.0), "−1"), number((0.0, 0.0), "1")]), (0.0, 0.0));
    }
}
