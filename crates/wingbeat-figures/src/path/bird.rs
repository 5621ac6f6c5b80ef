//! The robot at the instants at which it is drawn.

use wingbeat::math::{Mat3, Vec3};
use wingbeat::simulate::Record;

use super::points;
use crate::space::WorldPoint;

/// Seconds between two drawings of the robot, or a part of them: no whole number of strokes at 3.5, 5.9, 8, 10 or 12.8 Hz, so that they show different
/// phases.
const INTERVAL: f64 = 0.22;
/// Least distance of two drawings of the robot, in its reaches. *Choice*: wings of neighbours do not meet.
const APART: f64 = 2.0;
/// Fewest drawings for which robots at equal intervals are sought.
const FEWEST: usize = 4;
/// Most drawings of the robot but the last: a longer flight shows it at a multiple of [`INTERVAL`].
const MOST: f64 = 36.0;

/// The robot at one instant.
pub struct Bird {
    /// Origin of the body.
    pub body: WorldPoint,
    /// Its wings, tails and fins.
    pub wings: Vec<WingEdges>,
}

/// The edges of a surface on one side, at the ends of its panels.
#[derive(Clone)]
pub struct WingEdges {
    /// 0 left, 1 right, none of one that is of neither.
    pub side: Option<usize>,
    pub leading: Vec<WorldPoint>,
    pub trailing: Vec<WorldPoint>,
}

impl Bird {
    /// The bird with all distances from the body enlarged by the factor `factor`.
    pub fn enlarged(&self, factor: f64) -> Self {
        let grow = |p: &WorldPoint| std::array::from_fn(|i| self.body[i] + factor * (p[i] - self.body[i]));
        let wing = |wing: &WingEdges| WingEdges {
            side: wing.side,
            leading: wing.leading.iter().map(grow).collect(),
            trailing: wing.trailing.iter().map(grow).collect(),
        };
        Self { body: self.body, wings: self.wings.iter().map(wing).collect() }
    }

    /// Largest distance of a point from the body, m.
    pub fn reach(&self) -> f64 {
        self.points().map(|point| distance(point, self.body)).fold(0.0, f64::max)
    }

    /// Every point of the wings.
    pub fn points(&self) -> impl Iterator<Item = WorldPoint> {
        self.wings.iter().flat_map(|wing| wing.leading.iter().chain(&wing.trailing).copied())
    }
}

/// Those of the `birds` that do not lie over a later one, each enlarged by the factor `enlargement`, back from the last: every so manyth,
/// with its number, where neighbours then lie apart, and else those for which there is room.
pub fn apart(birds: Vec<Bird>, enlargement: f64) -> (Vec<Bird>, Option<usize>) {
    let clear =
        |a: &Bird, b: &Bird| distance(a.body, b.body) >= APART * enlargement * a.reach().max(b.reach());
    let every = (1..=birds.len().div_ceil(FEWEST)).find(|every| {
        let shown: Vec<&Bird> = birds.iter().rev().step_by(*every).collect();
        shown.windows(2).all(|pair| clear(pair[0], pair[1]))
    });
    let mut kept: Vec<Bird> = Vec::new();
    let mut crossed = false;
    for bird in birds.into_iter().rev().step_by(every.unwrap_or(1)) {
        if kept.iter().all(|later| clear(later, &bird)) {
            kept.push(bird);
        } else {
            crossed = true;
        }
    }
    kept.reverse();
    (kept, every.filter(|_| !crossed))
}

/// The robot at every [`interval`] back from the end; none where the record has no wings.
pub fn birds(record: &Record, t: &[f64], track: &[WorldPoint]) -> Vec<Bird> {
    let edges: Vec<EdgeTracks> =
        outlines(record).iter().filter_map(|outline| outline.edges(record)).collect();
    if edges.is_empty() {
        return Vec::new();
    }
    rows(t)
        .map(|row| Bird { body: track[row], wings: edges.iter().map(|edges| edges.at(row)).collect() })
        .collect()
}

/// Ends of the panels of a surface on one side, from one end to the other.
#[derive(Debug, PartialEq)]
struct SideOutline<'a> {
    surface: &'a str,
    side: Option<usize>,
    ends: Vec<&'a str>,
}

/// The edges of an outline over the record, end by end.
struct EdgeTracks {
    side: Option<usize>,
    leading: Vec<Vec<WorldPoint>>,
    trailing: Vec<Vec<WorldPoint>>,
}

/// Every `leading_<end>_x` of a record, in its order.
fn outlines(record: &Record) -> Vec<SideOutline<'_>> {
    let names = record.columns().iter().map(|column| column.name.as_str());
    of_ends(names.filter_map(|name| name.strip_prefix("leading_")?.strip_suffix("_x")))
}

/// The ends by surface and side. One that reaches from tip to tip without an end between is cut in the middle.
fn of_ends<'a>(ends: impl Iterator<Item = &'a str>) -> Vec<SideOutline<'a>> {
    let mut outlines: Vec<SideOutline> = Vec::new();
    for end in ends {
        let (surface, side) = place(end);
        match outlines.last_mut() {
            Some(last) if last.surface == surface && last.side == side => last.ends.push(end),
            _ => outlines.push(SideOutline { surface, side, ends: vec![end] }),
        }
    }
    for right in 1..outlines.len() {
        let [left, right] = &mut outlines[right - 1..=right] else { continue };
        if left.surface == right.surface && left.ends.len() == 1 && right.ends.len() == 1 {
            let (one, other) = (left.ends[0], right.ends[0]);
            left.ends.push(other);
            right.ends.insert(0, one);
        }
    }
    outlines.retain(|outline| outline.ends.len() > 1);
    outlines
}

/// Surface and side of an end called `[surface_]left_tip` or, of a surface of neither side, `fin_tip`.
fn place(end: &str) -> (&str, Option<usize>) {
    for (side, word) in [(0, "left_"), (1, "right_")] {
        if let Some(at) = end.find(word).filter(|&at| at == 0 || end[..at].ends_with('_')) {
            return (&end[..at], Some(side));
        }
    }
    (end.rsplit_once('_').map_or("", |(surface, _)| surface), None)
}

impl SideOutline<'_> {
    fn edges(&self, record: &Record) -> Option<EdgeTracks> {
        let line = |line: &str| -> Option<Vec<Vec<WorldPoint>>> {
            self.ends.iter().map(|end| points(record, &format!("{line}_{end}")).ok()).collect()
        };
        let (mut leading, mut trailing) = (line("leading")?, line("trailing")?);
        let (first, last) = (place(self.ends[0]).1, place(self.ends[self.ends.len() - 1]).1);
        if first != last {
            let cut = if first == self.side { 1 } else { 0 };
            for edge in [&mut leading, &mut trailing] {
                edge[cut] = edge[0].iter().zip(&edge[1]).map(|(a, b)| middle(*a, *b)).collect();
            }
        }
        Some(EdgeTracks { side: self.side.or_else(|| lies_on(record, &leading)), leading, trailing })
    }
}

/// The side on which a surface lies that its name does not tell: a wing by itself reaches further across the body than upward at some
/// time, a fin never does.
fn lies_on(record: &Record, edge: &[Vec<WorldPoint>]) -> Option<usize> {
    let body = points(record, "p_WB").ok()?;
    let angles = ["roll", "pitch", "yaw"].map(|name| record.values(name));
    let [Some(roll), Some(pitch), Some(yaw)] = angles else { return None };
    let (first, last) = (edge.first()?, edge.last()?);
    let (mut most, mut middle) = ([0.0_f64; 2], 0.0);
    for row in 0..body.len() {
        let attitude = Mat3::from_roll_pitch_yaw(roll[row], pitch[row], yaw[row]);
        let [one, other] = [first[row], last[row]].map(|p| attitude.transpose_mul(Vec3(p) - Vec3(body[row])));
        let along = other - one;
        if along[1].abs() > most[0] {
            (most[0], middle) = (along[1].abs(), one[1] + other[1]);
        }
        most[1] = most[1].max(along[2].abs());
    }
    (most[0] > most[1]).then(|| usize::from(middle < 0.0))
}

impl EdgeTracks {
    fn at(&self, row: usize) -> WingEdges {
        let at = |edge: &[Vec<WorldPoint>]| edge.iter().map(|end| end[row]).collect();
        WingEdges { side: self.side, leading: at(&self.leading), trailing: at(&self.trailing) }
    }
}

fn middle(a: WorldPoint, b: WorldPoint) -> WorldPoint {
    std::array::from_fn(|i| 0.5 * (a[i] + b[i]))
}

/// Seconds between two drawings of the robot over the times `t`.
pub fn interval(t: &[f64]) -> f64 {
    let span = t.last().copied().unwrap_or(0.0) - t.first().copied().unwrap_or(0.0);
    INTERVAL * (span / (MOST * INTERVAL) - 1e-6).ceil().max(1.0)
}

/// The rows at each multiple of the interval before the end, the last one last.
fn rows(t: &[f64]) -> impl Iterator<Item = usize> {
    let (first, last) = (t.first().copied().unwrap_or(0.0), t.last().copied().unwrap_or(0.0));
    let interval = interval(t);
    let count = ((last - first) / interval + 1e-6) as usize;
    (0..=count)
        .rev()
        .map(move |n| t.partition_point(|&time| time < last - n as f64 * interval - 1e-9).min(t.len() - 1))
}

fn distance(a: WorldPoint, b: WorldPoint) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn the_robot_is_drawn_at_round_times() {
        let t: Vec<f64> = (0..=1000).map(|i| 1e-3 * f64::from(i)).collect();
        assert_eq!(rows(&t).collect::<Vec<_>>(), [120, 340, 560, 780, 1000]);
        // A flight of 16 s is too long for that.
        let t: Vec<f64> = (0..=1600).map(|i| 1e-2 * f64::from(i)).collect();
        assert_eq!(rows(&t).take(3).collect::<Vec<_>>(), [16, 82, 148]);
    }

    #[test]
    fn drawings_of_the_robot_do_not_pile_up() {
        let wing = WingEdges { side: None, leading: vec![[0.0; 3]], trailing: vec![[0.0; 3]] };
        let at = |x: f64| {
            let edge = [x, 0.1, 0.0];
            let wing = WingEdges { leading: vec![edge], trailing: vec![edge], ..wing.clone() };
            Bird { body: [x, 0.0, 0.0], wings: vec![wing] }
        };
        let kept = |places: &[f64], size| {
            let (kept, every) = apart(places.iter().map(|x| at(*x)).collect(), size);
            (kept.iter().map(|bird| bird.body[0]).collect::<Vec<_>>(), every)
        };
        let equal: Vec<f64> = (0..9).map(|k| 0.125 * f64::from(k)).collect();
        assert_eq!(kept(&equal, 1.0), (vec![0.0, 0.25, 0.5, 0.75, 1.0], Some(2)));
        assert_eq!(kept(&equal[..3], 0.4), (vec![0.0, 0.125, 0.25], Some(1)));
        // The path comes back to where it began, and stands at its end.
        assert_eq!(kept(&[0.0, 1.0, 2.0, 1.0, 0.0], 1.0), (vec![2.0, 1.0, 0.0], None));
        assert_eq!(kept(&[0.0, 0.5, 1.0, 1.01], 1.0), (vec![0.0, 0.5, 1.01], None));
    }

    /// A wing by itself at a dihedral of 30 deg, to the left of a body that heads along y, and a fin behind.
    #[test]
    fn a_single_wing_is_of_the_side_on_which_it_lies_and_a_fin_of_none() {
        let column = |name: &str, value: f64| wingbeat::simulate::Column {
            values: vec![value; 2],
            ..wingbeat::simulate::Column::new(name, "", "")
        };
        let mut columns = vec![column("roll", 0.0), column("pitch", 0.0), column("yaw", FRAC_PI_2)];
        // The left of a body that heads along y is towards negative x.
        let places = [
            ("p_WB", [1.0, 2.0, 3.0]),
            ("wing_tip", [0.9 - 0.5 * 0.866, 2.0, 3.25]),
            ("wing_root", [0.9, 2.0, 3.0]),
            ("right_wing_tip", [1.1, 2.0, 3.0]),
            ("right_wing_end", [1.6, 2.0, 3.0]),
            ("fin_tip", [1.0, 1.8, 3.2]),
            ("fin_root", [1.0, 1.8, 3.0]),
        ];
        for (name, place) in places {
            let axes = ["x", "y", "z"].into_iter().zip(place);
            columns.extend(axes.map(|(axis, value)| column(&format!("{name}_{axis}"), value)));
        }
        let record = Record::new(columns, 2).unwrap();
        let edge = |ends: [&str; 2]| ends.map(|end| points(&record, end).unwrap());
        assert_eq!(lies_on(&record, &edge(["wing_tip", "wing_root"])), Some(0));
        assert_eq!(lies_on(&record, &edge(["right_wing_end", "right_wing_tip"])), Some(1));
        assert_eq!(lies_on(&record, &edge(["fin_tip", "fin_root"])), None);
    }

    #[test]
    fn ends_belong_to_surfaces_and_sides() {
        let ends = ["left_tip", "left_fore", "right_fore", "right_tip", "tail_left_tip", "tail_right_tip"];
        let found = of_ends(ends.into_iter().chain(["fin_tip", "fin_root"]));
        let told: Vec<_> =
            found.iter().map(|outline| (outline.surface, outline.side, outline.ends.join(" "))).collect();
        let expected = [
            ("", Some(0), "left_tip left_fore"),
            ("", Some(1), "right_fore right_tip"),
            ("tail_", Some(0), "tail_left_tip tail_right_tip"),
            ("tail_", Some(1), "tail_left_tip tail_right_tip"),
            ("fin", None, "fin_tip fin_root"),
        ];
        assert_eq!(told, expected.map(|(surface, side, ends)| (surface, side, ends.to_string())));
    }
}
