//! The robot at the instants at which it is drawn.

use wingbeat::simulate::Record;

use super::{Point, points};

/// Seconds between two drawings of the robot.
pub const INTERVAL: f64 = 0.25;

/// The robot at one instant.
pub struct Bird {
    /// Origin of the body.
    pub body: Point,
    /// Left and right wing.
    pub wings: [Wing; 2],
}

/// The edges of a wing at shoulder, elbow and tip.
#[derive(Clone, Copy)]
pub struct Wing {
    pub leading: [Point; 3],
    pub trailing: [Point; 3],
}

impl Bird {
    /// The bird with all distances from the body enlarged.
    pub fn enlarged(&self, factor: f64) -> Self {
        let grow = |p: Point| std::array::from_fn(|i| self.body[i] + factor * (p[i] - self.body[i]));
        let wing = |wing: Wing| Wing { leading: wing.leading.map(grow), trailing: wing.trailing.map(grow) };
        Self { body: self.body, wings: self.wings.map(wing) }
    }

    /// Largest distance of a point from the body.
    pub fn reach(&self) -> f64 {
        self.points().map(|point| distance(point, self.body)).fold(0.0, f64::max)
    }

    /// Every point of the wings.
    pub fn points(&self) -> impl Iterator<Item = Point> {
        self.wings.iter().flat_map(|wing| wing.leading.into_iter().chain(wing.trailing))
    }
}

/// The robot every [`INTERVAL`]; none where the record has no wings.
pub fn birds(record: &Record, t: &[f64], track: &[Point]) -> Vec<Bird> {
    let edge = |line: &str, side: &str| -> Option<[Vec<Point>; 3]> {
        let [shoulder, elbow, tip] =
            ["shoulder", "elbow", "tip"].map(|joint| points(record, &format!("{line}_{side}_{joint}")).ok());
        Some([shoulder?, elbow?, tip?])
    };
    let edges = ["left", "right"].map(|side| Some((edge("leading", side)?, edge("trailing", side)?)));
    let [Some(left), Some(right)] = edges else { return Vec::new() };
    let wing = |(leading, trailing): &([Vec<Point>; 3], [Vec<Point>; 3]), row: usize| Wing {
        leading: [0, 1, 2].map(|joint| leading[joint][row]),
        trailing: [0, 1, 2].map(|joint| trailing[joint][row]),
    };
    rows(t).map(|row| Bird { body: track[row], wings: [wing(&left, row), wing(&right, row)] }).collect()
}

/// The rows nearest after each multiple of the interval.
fn rows(t: &[f64]) -> impl Iterator<Item = usize> {
    let (first, last) = (t.first().copied().unwrap_or(0.0), t.last().copied().unwrap_or(0.0));
    let count = ((last - first) / INTERVAL + 1e-6) as usize;
    (0..=count)
        .map(move |n| t.partition_point(|&time| time < first + n as f64 * INTERVAL - 1e-9).min(t.len() - 1))
}

fn distance(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_robot_is_drawn_at_round_times() {
        let t: Vec<f64> = (0..=1000).map(|i| 1e-3 * f64::from(i)).collect();
        assert_eq!(rows(&t).collect::<Vec<_>>(), [0, 250, 500, 750, 1000]);
    }
}
