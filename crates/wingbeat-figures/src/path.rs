//! The path through space with the robot drawn at intervals as a stick figure.

use kuva::render::color::Color;
use kuva::render::render::{Primitive, Scene, TextAnchor};
use wingbeat::flight::Record;

use crate::projection::View;
use crate::write::Figure;
use crate::{Error, needed, style};

/// Seconds between two drawings of the robot.
const INTERVAL: f64 = 0.25;
/// Azimuth and elevation of the view, degrees.
const VIEW: (f64, f64) = (-62.0, 24.0);
/// Share of the picture that the wing span should take at least.
const SPAN_SHARE: f64 = 0.075;

type Point = [f64; 3];

/// The path `p_WB_x`, `p_WB_y`, `p_WB_z` (world frame) above its shadow on the ground. Where the record has the
/// polylines `wing_left_<i>_x/y/z` and `wing_right_<i>_x/y/z` (world frame), the wings are drawn every quarter second.
pub fn path(record: &Record) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    let track = points(record, "p_WB")?;
    if track.len() < 2 {
        return Err(Error::Rows { rows: track.len(), needed: 2 });
    }
    let birds = birds(record, t, &track);
    let room = Room::around(&track, &birds);
    let mut sheet = Sheet::new(&room);
    sheet.ground(&room);
    sheet.shadow(&room, &track);
    sheet.track(&track);
    birds.iter().for_each(|bird| sheet.bird(&room, bird));
    sheet.ends(&track, t);
    sheet.note(&birds, room.enlargement);
    Ok(Figure { name: "path", scene: sheet.scene })
}

/// The robot at one instant: body, and wings from root to tip.
struct Bird {
    body: Point,
    wings: [Vec<Point>; 2],
}

impl Bird {
    fn span(&self) -> f64 {
        let tips: Vec<Point> = self.wings.iter().filter_map(|wing| wing.last().copied()).collect();
        if let [left, right] = tips[..] { distance(left, right) } else { 0.0 }
    }

    /// The wing's points with their distance from the body enlarged.
    fn enlarged(&self, side: usize, factor: f64) -> Vec<Point> {
        let grow = |p: &Point| std::array::from_fn(|i| self.body[i] + factor * (p[i] - self.body[i]));
        self.wings[side].iter().map(grow).collect()
    }
}

/// What is drawn, in world coordinates.
struct Room {
    low: Point,
    high: Point,
    step: f64,
    enlargement: f64,
}

impl Room {
    fn around(track: &[Point], birds: &[Bird]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in track {
            for i in 0..3 {
                low[i] = low[i].min(point[i]);
                high[i] = high[i].max(point[i]);
            }
        }
        let size = (0..3).map(|i| high[i] - low[i]).fold(0.1, f64::max);
        let step = round_step(size / 5.0);
        let span = birds.iter().map(Bird::span).fold(0.0, f64::max);
        let enlargement =
            if span > 0.0 { (SPAN_SHARE * 2.0 * size / span).round().clamp(1.0, 10.0) } else { 1.0 };
        let margin = (0.6 * enlargement * span).max(0.2 * step);
        for i in 0..3 {
            low[i] = ((low[i] - margin) / step).floor() * step;
            high[i] = ((high[i] + margin) / step).ceil() * step;
        }
        Self { low, high, step, enlargement }
    }

    /// The multiples of the step from `low` to `high` along axis `i`.
    fn ticks(&self, i: usize) -> Vec<f64> {
        let count = ((self.high[i] - self.low[i]) / self.step).round() as usize;
        (0..=count).map(|n| self.low[i] + n as f64 * self.step).collect()
    }

    fn corners(&self) -> Vec<Point> {
        let pick = |bit: usize, i: usize| if bit >> i & 1 == 0 { self.low[i] } else { self.high[i] };
        (0..8).map(|bit| std::array::from_fn(|i| pick(bit, i))).collect()
    }
}

/// 1, 2 or 5 times a power of ten, not below `least` by more than a third.
fn round_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().find(|n| n * power >= 0.75 * least).unwrap_or(10.0) * power
}

/// The drawing and its scale.
struct Sheet {
    scene: Scene,
    view: View,
    scale: f64,
    origin: (f64, f64),
}

impl Sheet {
    const MARGINS: (f64, f64) = (70.0, 44.0);

    fn new(room: &Room) -> Self {
        let view = View::new(VIEW.0, VIEW.1);
        let seen: Vec<(f64, f64)> = room.corners().into_iter().map(|corner| view.project(corner)).collect();
        let bounds = |of: fn(&(f64, f64)) -> f64| {
            let low = seen.iter().map(of).fold(f64::INFINITY, f64::min);
            (low, seen.iter().map(of).fold(f64::NEG_INFINITY, f64::max))
        };
        let ((left, right), (top, bottom)) = (bounds(|p| p.0), bounds(|p| p.1));
        let scale = (style::WIDTH - 2.0 * Self::MARGINS.0) / (right - left);
        let height = scale * (bottom - top) + 2.0 * Self::MARGINS.1;
        let mut scene = Scene::new(style::WIDTH, height);
        scene.font_family = Some("DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif".into());
        Self { scene, view, scale, origin: (Self::MARGINS.0 - scale * left, Self::MARGINS.1 - scale * top) }
    }

    fn at(&self, point: Point) -> (f64, f64) {
        let (right, down) = self.view.project(point);
        (self.origin.0 + self.scale * right, self.origin.1 + self.scale * down)
    }

    fn line(&mut self, points: &[Point], colour: &str, weight: f64) {
        let points = points.iter().map(|&point| self.at(point)).collect();
        self.scene.elements.push(Primitive::PolyLine {
            points,
            stroke: Color::from(colour),
            stroke_width: weight,
            stroke_dasharray: None,
        });
    }

    fn text(&mut self, (x, y): (f64, f64), content: String, anchor: TextAnchor, size: u32) {
        let color = Some(Color::from(style::INK));
        self.scene.elements.push(Primitive::Text {
            x,
            y,
            content,
            size,
            anchor,
            rotate: None,
            bold: false,
            color,
        });
    }

    /// The ground with its grid, and the two walls behind, with ticks and names of the axes.
    fn ground(&mut self, room: &Room) {
        let Room { low, high, .. } = *room;
        let (x, y, z) = (room.ticks(0), room.ticks(1), room.ticks(2));
        let grid = "#e4e4e4";
        for &x in &x {
            self.line(&[[x, low[1], low[2]], [x, high[1], low[2]], [x, high[1], high[2]]], grid, 0.8);
        }
        for &y in &y {
            self.line(&[[high[0], y, low[2]], [low[0], y, low[2]], [low[0], y, high[2]]], grid, 0.8);
        }
        for &z in &z {
            self.line(&[[high[0], high[1], z], [low[0], high[1], z], [low[0], low[1], z]], grid, 0.8);
        }
        self.line(
            &[[low[0], low[1], high[2]], [low[0], low[1], low[2]], [high[0], low[1], low[2]]],
            style::INK,
            1.0,
        );
        self.line(&[[high[0], low[1], low[2]], [high[0], high[1], low[2]]], style::INK, 1.0);
        self.axis(&x, |x| [x, low[1], low[2]], (-4.0, 17.0), TextAnchor::End);
        self.axis(&y, |y| [high[0], y, low[2]], (8.0, 14.0), TextAnchor::Start);
        self.axis(&z, |z| [low[0], low[1], z], (-8.0, 4.0), TextAnchor::End);
        let middle = |i: usize| 0.5 * (low[i] + high[i]);
        self.name("x [m]", [middle(0), low[1], low[2]], (-34.0, 46.0));
        self.name("y [m]", [high[0], middle(1), low[2]], (48.0, 34.0));
        self.name("z [m]", [low[0], low[1], high[2]], (-14.0, -14.0));
    }

    fn axis(&mut self, ticks: &[f64], place: impl Fn(f64) -> Point, shift: (f64, f64), anchor: TextAnchor) {
        for &tick in ticks {
            let (x, y) = self.at(place(tick));
            self.text((x + shift.0, y + shift.1), style::number(tick), anchor, style::TICKS);
        }
    }

    fn name(&mut self, name: &str, place: Point, shift: (f64, f64)) {
        let (x, y) = self.at(place);
        self.text((x + shift.0, y + shift.1), name.into(), TextAnchor::Middle, style::LETTERS);
    }

    fn shadow(&mut self, room: &Room, track: &[Point]) {
        let ground: Vec<Point> = track.iter().map(|point| [point[0], point[1], room.low[2]]).collect();
        self.line(&ground, "#bdbdbd", 1.6);
    }

    fn track(&mut self, track: &[Point]) {
        self.line(track, style::colour(0), style::CURVE);
    }

    fn bird(&mut self, room: &Room, bird: &Bird) {
        self.line(&[bird.body, [bird.body[0], bird.body[1], room.low[2]]], "#cfcfcf", 0.6);
        for side in 0..2 {
            let mut arm = vec![bird.body];
            arm.extend(bird.enlarged(side, room.enlargement));
            self.line(&arm, style::colour(1 + side), 1.8);
        }
        let (cx, cy) = self.at(bird.body);
        self.disc(cx, cy, 2.6, style::INK);
    }

    fn disc(&mut self, cx: f64, cy: f64, r: f64, colour: &str) {
        let fill = Color::from(colour);
        self.scene.elements.push(Primitive::Circle {
            cx,
            cy,
            r,
            fill,
            fill_opacity: None,
            stroke: None,
            stroke_width: None,
        });
    }

    fn ends(&mut self, track: &[Point], t: &[f64]) {
        for (point, time) in [(track[0], t[0]), (track[track.len() - 1], t[t.len() - 1])] {
            let (x, y) = self.at(point);
            self.disc(x, y, 3.6, style::colour(0));
            self.text((x - 30.0, y + 5.0), format!("{time:.1} s"), TextAnchor::End, style::TICKS);
        }
    }

    /// What the colours and the size of the robot mean.
    fn note(&mut self, birds: &[Bird], enlargement: f64) {
        let mut x = Self::MARGINS.0;
        let mut entries = vec![("path", style::colour(0)), ("on the ground", "#bdbdbd")];
        if !birds.is_empty() {
            entries.extend([("left wing", style::colour(1)), ("right wing", style::colour(2))]);
        }
        for (name, colour) in entries {
            let stroke = Color::from(colour);
            let (x1, x2, y) = (x, x + 22.0, 16.0);
            let line =
                Primitive::Line { x1, y1: y, x2, y2: y, stroke, stroke_width: 2.0, stroke_dasharray: None };
            self.scene.elements.push(line);
            self.text((x2 + 6.0, y + 4.5), name.into(), TextAnchor::Start, style::LETTERS);
            x = x2 + 26.0 + 7.6 * name.len() as f64;
        }
        if !birds.is_empty() {
            let size = if enlargement > 1.0 {
                format!(", wings {enlargement:.0} times enlarged")
            } else {
                String::new()
            };
            let text = format!("every {INTERVAL} s{size}");
            self.text((x, 20.5), text, TextAnchor::Start, style::LETTERS);
        }
    }
}

/// The points `<name>_x`, `_y`, `_z` of every row.
fn points(record: &Record, name: &str) -> Result<Vec<Point>, Error> {
    let columns = ["x", "y", "z"].map(|axis| needed(record, &format!("{name}_{axis}")));
    let [x, y, z] = columns;
    let (x, y, z) = (x?, y?, z?);
    Ok((0..x.len()).map(|row| [x[row], y[row], z[row]]).collect())
}

/// The robot every [`INTERVAL`]; none where the record has no wings.
fn birds(record: &Record, t: &[f64], track: &[Point]) -> Vec<Bird> {
    let wings = ["left", "right"].map(|side| {
        let point = |i: usize| points(record, &format!("wing_{side}_{i}")).ok();
        (0..).map_while(point).collect::<Vec<_>>()
    });
    if wings.iter().any(Vec::is_empty) {
        return Vec::new();
    }
    let mut rows: Vec<usize> = Vec::new();
    let count = ((t[t.len() - 1] - t[0]) / INTERVAL + 1e-6) as usize;
    for n in 0..=count {
        rows.push(t.partition_point(|&time| time < t[0] + n as f64 * INTERVAL - 1e-9).min(t.len() - 1));
    }
    let at = |row: usize, side: usize| wings[side].iter().map(|point| point[row]).collect();
    rows.into_iter().map(|row| Bird { body: track[row], wings: [at(row, 0), at(row, 1)] }).collect()
}

fn distance(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
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
}
