//! The drawing: world coordinates to lines and letters on paper.

use super::bird::Bird;
use super::room::SceneBox;
use crate::canvas::{Canvas, Colour, Primitive, TextAnchor};
use crate::space::Camera;
use crate::space::WorldPoint;
use crate::style;

/// Azimuth and elevation of the view, degrees.
const VIEW: (f64, f64) = (-62.0, 24.0);
/// Colour of the grid.
const GRID: &str = "#e4e4e4";
/// Colour of the track's shadow.
const SHADOW: &str = "#bdbdbd";

/// From the end of a path to the words beside it, px.
const SIDE: f64 = 30.0;
/// How near the ends of a path are whose words would meet them, across and down, px.
const NEAR: (f64, f64) = (90.0, 24.0);

/// The drawing and its scale.
pub struct PathSheet {
    pub scene: Canvas,
    view: Camera,
    scale: f64,
    origin: (f64, f64),
}

impl PathSheet {
    const MARGINS: (f64, f64) = (70.0, 50.0);

    pub fn new(room: &SceneBox) -> Self {
        let view = Camera::orthographic(VIEW.0, VIEW.1);
        let seen: Vec<(f64, f64)> = room.corners().into_iter().map(|corner| view.project(corner)).collect();
        let bounds = |of: fn(&(f64, f64)) -> f64| {
            let low = seen.iter().map(of).fold(f64::INFINITY, f64::min);
            (low, seen.iter().map(of).fold(f64::NEG_INFINITY, f64::max))
        };
        let ((left, right), (top, bottom)) = (bounds(|p| p.0), bounds(|p| p.1));
        let scale = (style::WIDTH - 2.0 * Self::MARGINS.0) / (right - left);
        let height = scale * (bottom - top) + 2.0 * Self::MARGINS.1;
        let scene = Canvas::new(style::WIDTH, height);
        Self { scene, view, scale, origin: (Self::MARGINS.0 - scale * left, Self::MARGINS.1 - scale * top) }
    }

    fn at(&self, point: WorldPoint) -> (f64, f64) {
        let (right, down) = self.view.project(point);
        (self.origin.0 + self.scale * right, self.origin.1 + self.scale * down)
    }

    fn line(&mut self, points: &[WorldPoint], colour: &str, weight: f64) {
        let points = points.iter().map(|&point| self.at(point)).collect();
        self.scene.elements.push(Primitive::PolyLine {
            points,
            stroke: Colour::from(colour),
            stroke_width: weight,
            stroke_dasharray: None,
        });
    }

    fn area(&mut self, points: &[WorldPoint], colour: &str, opacity: f64) {
        let corners: Vec<(f64, f64)> = points.iter().map(|point| self.at(*point)).collect();
        self.scene.elements.push(style::area(&corners, colour, opacity));
    }

    fn text(&mut self, (x, y): (f64, f64), content: String, anchor: TextAnchor, size: u32) {
        let color = Some(Colour::from(style::INK));
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
    pub fn ground(&mut self, room: &SceneBox) {
        let SceneBox { low, high, .. } = *room;
        let (x, y, z) = (room.ticks(0), room.ticks(1), room.ticks(2));
        for &x in &x {
            self.line(&[[x, low[1], low[2]], [x, high[1], low[2]], [x, high[1], high[2]]], GRID, 0.8);
        }
        for &y in &y {
            self.line(&[[high[0], y, low[2]], [low[0], y, low[2]], [low[0], y, high[2]]], GRID, 0.8);
        }
        for &z in &z {
            self.line(&[[high[0], high[1], z], [low[0], high[1], z], [low[0], low[1], z]], GRID, 0.8);
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

    fn axis(
        &mut self,
        ticks: &[f64],
        place: impl Fn(f64) -> WorldPoint,
        shift: (f64, f64),
        anchor: TextAnchor,
    ) {
        for &tick in ticks {
            let (x, y) = self.at(place(tick));
            self.text((x + shift.0, y + shift.1), style::number(tick), anchor, style::TICKS);
        }
    }

    fn name(&mut self, name: &str, place: WorldPoint, shift: (f64, f64)) {
        let (x, y) = self.at(place);
        self.text((x + shift.0, y + shift.1), name.into(), TextAnchor::Middle, style::LETTERS);
    }

    pub fn shadow(&mut self, room: &SceneBox, track: &[WorldPoint]) {
        let ground: Vec<WorldPoint> = track.iter().map(|point| [point[0], point[1], room.low[2]]).collect();
        self.line(&ground, SHADOW, 1.6);
    }

    pub fn track(&mut self, track: &[WorldPoint]) {
        self.line(track, style::INK, style::CURVE);
    }

    /// A robot with its membranes, above its place on the floor of the axes.
    pub fn bird(&mut self, room: &SceneBox, bird: &Bird) {
        self.line(&[bird.body, [bird.body[0], bird.body[1], room.low[2]]], "#d4d4d4", 0.6);
        let bird = bird.enlarged(room.enlargement);
        for wing in &bird.wings {
            let colour = wing.side.map_or(style::INK, |side| style::colour(style::SIDES[side].1));
            for (leading, trailing) in wing.leading.windows(2).zip(wing.trailing.windows(2)) {
                self.area(&[leading[0], leading[1], trailing[1], trailing[0]], colour, 0.45);
            }
            self.line(&wing.leading, colour, 1.4);
        }
        let at = self.at(bird.body);
        self.scene.elements.push(style::disc(at, 2.4, style::INK));
    }

    pub fn ends(&mut self, track: &[WorldPoint], t: &[f64]) {
        let [start, end] = [track[0], track[track.len() - 1]];
        let (a, b) = (self.at(start), self.at(end));
        // Where the ends lie so near that the words of one would lie over the other, each has them on its own side.
        let near = (a.0 - b.0).abs() < NEAR.0 && (a.1 - b.1).abs() < NEAR.1;
        let span = t[t.len() - 1] - t[0];
        let decimals = if span < 1.0 { 3 } else { 1 };
        for (here, there, time) in [(a, b, t[0]), (b, a, t[t.len() - 1])] {
            self.scene.elements.push(style::disc(here, 3.6, style::INK));
            let right = near && here.0 > there.0;
            let (x, anchor) =
                if right { (here.0 + 10.0, TextAnchor::Start) } else { (here.0 - SIDE, TextAnchor::End) };
            let x = if near && !right { here.0 - 10.0 } else { x };
            self.text((x, here.1 + 5.0), format!("{time:.decimals$} s"), anchor, style::TICKS);
        }
    }

    /// The end point that is published, above its place on the floor of the axes.
    pub fn published(&mut self, room: &SceneBox, point: WorldPoint) {
        let colour = style::colour(3);
        self.line(&[point, [point[0], point[1], room.low[2]]], colour, 0.8);
        for place in [point, [point[0], point[1], room.low[2]]] {
            let (x, y) = self.at(place);
            for (dx, dy) in [(5.0, 5.0), (5.0, -5.0)] {
                let stroke = style::sample((x - dx, y - dy), (x + dx, y + dy), colour, 2.2, None);
                self.scene.elements.push(stroke);
            }
        }
        let (x, y) = self.at(point);
        let text = "the paper's end, its height not given".into();
        self.text((x - 8.0, y - 8.0), text, TextAnchor::End, style::TICKS);
    }

    /// A perch, above its place on the floor of the axes.
    pub fn perch(&mut self, room: &SceneBox, place: WorldPoint) {
        let colour = style::colour(2);
        self.line(&[place, [place[0], place[1], room.low[2]]], colour, 0.8);
        let (x, y) = self.at(place);
        self.scene.elements.push(style::disc((x, y), 5.0, colour));
        self.text((x + 8.0, y - 8.0), "perch".into(), TextAnchor::Start, style::TICKS);
    }

    /// What the colours and the size of the robot mean, drawn at intervals of `every` seconds and too large by the factor
    /// `enlargement`.
    pub fn note(&mut self, birds: &[Bird], every: Option<f64>, enlargement: f64) {
        let mut x = Self::MARGINS.0;
        let mut entries = vec![("path", style::INK), ("shadow below", SHADOW)];
        if let Some(bird) = birds.first() {
            let parts = [
                ("left wing", Some(0), style::colour(0)),
                ("right wing", Some(1), style::colour(1)),
                ("fin", None, style::INK),
            ];
            let drawn =
                parts.into_iter().filter(|(_, side, _)| bird.wings.iter().any(|wing| wing.side == *side));
            entries.extend(drawn.map(|(name, _, colour)| (name, colour)));
        }
        for (name, colour) in entries {
            let x2 = x + 22.0;
            self.scene.elements.push(style::sample((x, 16.0), (x2, 16.0), colour, 2.0, None));
            self.text((x2 + 6.0, 20.5), name.into(), TextAnchor::Start, style::LETTERS);
            x = x2 + 26.0 + 7.6 * name.len() as f64;
        }
        if !birds.is_empty() {
            let size = match enlargement {
                1.0 => "robot in the scale of its path".into(),
                enlarged => format!("robot enlarged {enlarged:.0} times about its body"),
            };
            let text = match every {
                _ if birds.len() == 1 => format!("{size}, at the end"),
                Some(interval) => format!("{size}, every {interval:.2} s back from the end"),
                None => format!("{size}, back from the end where there is room"),
            };
            self.text((Self::MARGINS.0, 40.5), text, TextAnchor::Start, style::LETTERS);
        }
    }
}
