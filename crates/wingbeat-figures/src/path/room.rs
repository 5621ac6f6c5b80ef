//! The box of space that is drawn.

use super::bird::Bird;
use crate::space::WorldPoint;
use crate::space::round_step;

/// Share of the picture that the robot's reach should take at least.
const SHARE: f64 = 0.07;

/// Most lines of the grid along the longest side, about.
const LINES: f64 = 20.0;

/// A box whose sides are whole steps long.
pub struct SceneBox {
    pub low: WorldPoint,
    pub high: WorldPoint,
    /// Distance of two lines of the grid, m.
    pub step: f64,
    /// Factor by which the robot is drawn too large.
    pub enlargement: f64,
}

impl SceneBox {
    /// The room around the track and the robots on it.
    pub fn around(track: &[WorldPoint], birds: &[Bird]) -> Self {
        let (low, high) = bounds(track.iter().copied());
        let size = (0..3).map(|i| high[i] - low[i]).fold(0.1, f64::max);
        let reach = birds.iter().map(Bird::reach).fold(0.0, f64::max);
        let enlargement = if reach > 0.0 { (SHARE * size / reach).round().clamp(1.0, 10.0) } else { 1.0 };
        let robots = birds.iter().flat_map(|bird| bird.enlarged(enlargement).points().collect::<Vec<_>>());
        let (low, high) = bounds(track.iter().copied().chain(robots));
        let reached = (0..3).map(|i| high[i] - low[i]).fold(size, f64::max);
        let step = round_step((size / 5.0).max(reached / LINES));
        Self {
            low: low.map(|low| (low / step - 0.1).floor() * step),
            high: high.map(|high| (high / step + 0.1).ceil() * step),
            step,
            enlargement,
        }
    }

    /// The multiples of the step from `low` to `high` along axis `i`, m.
    pub fn ticks(&self, i: usize) -> Vec<f64> {
        let count = ((self.high[i] - self.low[i]) / self.step).round();
        (0..=count.min(2.0 * LINES) as usize).map(|n| self.low[i] + n as f64 * self.step).collect()
    }

    /// The eight corners.
    pub fn corners(&self) -> Vec<WorldPoint> {
        let pick = |bit: usize, i: usize| if bit >> i & 1 == 0 { self.low[i] } else { self.high[i] };
        (0..8).map(|bit| std::array::from_fn(|i| pick(bit, i))).collect()
    }
}

fn bounds(points: impl Iterator<Item = WorldPoint>) -> (WorldPoint, WorldPoint) {
    points.fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), point| {
        (std::array::from_fn(|i| low[i].min(point[i])), std::array::from_fn(|i| high[i].max(point[i])))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        assert_eq!(round_step(0.9), 1.0);
        assert_eq!(round_step(1.1), 1.0);
        assert_eq!(round_step(1.6), 2.0);
        assert_eq!(round_step(0.03), 0.05);
    }

    #[test]
    fn a_room_holds_its_track() {
        let room = SceneBox::around(&[[0.0, 0.0, 0.0], [4.2, -5.3, -1.9]], &[]);
        assert_eq!((room.low, room.high, room.step), ([-1.0, -6.0, -2.0], [5.0, 1.0, 1.0], 1.0));
        assert_eq!(room.ticks(2), [-2.0, -1.0, 0.0, 1.0]);
    }
}
