//! The pictures of an animation of a run.

use wingbeat::math::Vec3;
use wingbeat::plant::Plant;
use wingbeat::robot::Robot;
use wingbeat_figures::animation::{Area, Picture, PictureLine, PictureView};
use wingbeat_figures::space::{Bounds, Camera, Pane, WorldPoint};
use wingbeat_io::shortest;

use crate::flight::add_skeleton;
use crate::motion::{RunMotion, at, direction, spindle};
use crate::run::ShownRun;

/// Most frames of an animation, and most pixels of all, two bytes each.
const MOST: usize = 1200;
const MOST_PIXELS: f64 = 4e8;
/// Colours of left, right and neither side, as in the figures.
const SIDES: [[f64; 3]; 3] = [[0.0, 114.0, 178.0], [213.0, 94.0, 0.0], [140.0, 146.0, 153.0]];
/// Colour of the body, of the way, of its curtain and of the grid.
const BODY: [f64; 3] = [110.0, 116.0, 125.0];
const WAY: &str = "#222222";
const CURTAIN: &str = "#808080";
const GRID: &str = "#cccccc";
/// The grid on a ground.
const SOIL: &str = "#b39a6b";
/// Where the light comes from.
const LIGHT: [f64; 3] = [-0.34, 0.24, 0.91];
/// Share of the way's size that the robot's reach takes at least.
const SHARE: f64 = 0.16;
/// What a view leaves free for axes at each side, px, which these pictures have not, and what is left of it.
const MARGIN: f64 = 46.0;
const KEPT: f64 = 12.0;
/// Intervals between the instants of a still picture.
const STILLS: usize = 6;
/// Pieces of the drawn way.
const PIECES: usize = 70;
/// Half the time over which the place that a close view follows is averaged, s.
const FOLLOWS: f64 = 0.15;

/// From where a run is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Viewpoint {
    /// The whole way from behind, and the robot near by in a corner.
    Whole,
    /// The robot near by, from behind.
    Behind,
    /// The whole way from its right side.
    Side,
    /// The whole way from above.
    Above,
}

/// The views by name.
const VIEWS: [(&str, Viewpoint); 4] = [
    ("whole", Viewpoint::Whole),
    ("behind", Viewpoint::Behind),
    ("side", Viewpoint::Side),
    ("above", Viewpoint::Above),
];

impl Viewpoint {
    /// The view of a name.
    ///
    /// # Errors
    /// A name that is none of them.
    pub fn named(name: &str) -> Result<Self, String> {
        let found = VIEWS.iter().find(|(known, _)| *known == name);
        let known = VIEWS.map(|(known, _)| known).join(", ");
        found.map(|(_, seen)| *seen).ok_or_else(|| format!("view = {name:?}: allowed are {known}"))
    }
}

/// What an animation shows and how.
#[derive(Clone, Copy, Debug)]
pub struct AnimationSettings {
    /// From where.
    pub seen: Viewpoint,
    /// Seconds of the run in a second.
    pub speed: f64,
    /// Frames a second.
    pub rate: f64,
    /// Width, px.
    pub width: f64,
    /// Whether the picture is 16:9; else it is 4:3.
    pub wide: bool,
}

impl AnimationSettings {
    /// The same within what is drawn; names of what is refused begin with `prefix`.
    ///
    /// # Errors
    /// A number beyond its range.
    pub fn checked(self, prefix: &str) -> Result<Self, String> {
        let numbers = [
            ("speed", self.speed, 0.001, 1000.0),
            ("rate", self.rate, 1.0, 100.0),
            ("width", self.width, 160.0, 3840.0),
        ];
        match numbers.into_iter().find(|(_, value, low, high)| !(value >= low && value <= high)) {
            None => Ok(self),
            Some((name, value, low, high)) => {
                Err(format!("{prefix}{name} {}: allowed is {low} to {high}", shortest(value)))
            }
        }
    }
}

/// An animation of a run.
pub struct Film<'a> {
    run: &'a ShownRun,
    motion: &'a RunMotion,
    asked: AnimationSettings,
    /// The box of the whole way with the robot, and the enlargement of the robot in it.
    bounds: Bounds,
    enlarged: f64,
    /// Height of the ground, where it is drawn, m.
    ground: Option<f64>,
}

impl<'a> Film<'a> {
    /// The film of `run`.
    ///
    /// # Errors
    /// A run in which nothing moves, or more frames than are made.
    pub fn new(run: &'a ShownRun, asked: AnimationSettings) -> Result<Self, String> {
        let motion = run.motion.as_ref().filter(|motion| motion.frames() > 1 && !motion.surfaces.is_empty());
        let Some(motion) = motion else {
            return Err(format!("{}: nothing moves in this {}", run.name, run.kind));
        };
        let reach = motion.reach();
        let places = (0..motion.frames()).map(|i| at(&motion.position, i).0);
        let way = Bounds::of(places).unwrap_or(Bounds { low: [0.0; 3], high: [0.0; 3] });
        let size = (0..3).map(|i| way.high[i] - way.low[i]).fold(2.0 * reach, f64::max);
        let enlarged = if motion.free { (SHARE * size / reach).clamp(1.0, 12.0).round() } else { 1.0 };
        let room = reach * enlarged;
        let mut bounds = Bounds { low: way.low.map(|x| x - room), high: way.high.map(|x| x + room) };
        // The grid lies on a ground that is nearer below than the way is large.
        let middle = 0.5 * (way.low[2] + way.high[2]);
        let ground = motion.ground.filter(|z| (way.low[2] - size..=middle).contains(z));
        bounds.low[2] = ground.unwrap_or(bounds.low[2]);
        let film = Self { run, motion, asked, bounds, enlarged, ground };
        match film.frames() {
            0 => Err("no frames".into()),
            frames if frames > MOST => {
                Err(format!("{frames} frames: allowed are at most {MOST}; raise --speed or lower --rate"))
            }
            frames if frames as f64 * film.asked.width * film.height() > MOST_PIXELS => Err(format!(
                "{frames} frames of {} by {} pixels: allowed are {MOST_PIXELS:e} pixels in all; lower --width or --rate",
                film.asked.width,
                film.height()
            )),
            _ => Ok(film),
        }
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        let span = self.motion.t[self.motion.frames() - 1] - self.motion.t[0];
        (span / self.asked.speed * self.asked.rate).ceil().clamp(0.0, 1e9) as usize
    }

    /// Height of a frame, px.
    fn height(&self) -> f64 {
        (self.asked.width * if self.asked.wide { 9.0 / 16.0 } else { 0.75 }).round()
    }

    /// Frame number `k`.
    pub fn picture(&self, k: usize) -> Picture {
        let t = self.motion.t[0] + k as f64 / self.asked.rate * self.asked.speed;
        let i = self.motion.t.partition_point(|time| *time < t).min(self.motion.frames() - 1);
        let width = self.asked.width;
        let height = self.height();
        let whole = Pane { x: 0.0, y: 0.0, width, height };
        let title = format!("{}, t = {t:.2} s", self.run.title());
        let views = match self.asked.seen {
            Viewpoint::Behind => vec![self.near(i, whole, false)],
            _ if !self.motion.free => vec![self.far(i, &[i], whole)],
            _ => {
                let (corner, beside) = self.panes();
                vec![self.far(i, &[i], beside), self.near(i, corner, true)]
            }
        };
        Picture { width, height, views, title, note: self.note() }
    }

    /// What is shown where pictures do not move: the whole way with the robot at a few instants, and its last one near by.
    pub fn cover(&self) -> Picture {
        let last = self.motion.frames() - 1;
        if self.asked.seen == Viewpoint::Behind || !self.motion.free {
            return self.picture(0);
        }
        let (width, height, t) = (self.asked.width, self.height(), &self.motion.t);
        let instants = |k: usize| t[0] + k as f64 / STILLS as f64 * (t[last] - t[0]);
        let rows: Vec<usize> =
            (0..=STILLS).map(|k| t.partition_point(|time| *time < instants(k)).min(last)).collect();
        let (corner, beside) = self.panes();
        let views = vec![self.far(last, &rows, beside), self.near(last, corner, true)];
        let title = format!("{}, t = {:.2} to {:.2} s", self.run.title(), t[0], t[last]);
        Picture { width, height, views, title, note: self.note() }
    }

    /// The corner of the robot near by, below the title, and what is left of the picture beside it.
    fn panes(&self) -> (Pane, Pane) {
        let (width, height) = (self.asked.width, self.height());
        let (w, h) = (0.32 * width, 0.44 * height);
        let corner = Pane { x: width - w - 8.0, y: 30.0, width: w, height: h };
        (corner, Pane { x: 0.0, y: 0.0, width: width - w - 12.0, height })
    }

    /// The distance of the grid's lines, and how much larger than its way the robot is.
    fn note(&self) -> String {
        if self.asked.seen == Viewpoint::Behind {
            return String::new();
        }
        let name = if self.ground.is_some() { "ground, grid" } else { "grid" };
        let grid = format!("{name} {} m", shortest(self.grid()));
        if self.enlarged > 1.0 {
            format!("{grid}; robot enlarged {} times on its path", self.enlarged)
        } else {
            grid
        }
    }

    /// Distance of the lines of the grid, m.
    fn grid(&self) -> f64 {
        let Bounds { low, high } = self.bounds;
        let size = (high[0] - low[0]).max(high[1] - low[1]);
        let power = 10_f64.powf((size / 10.0).log10().floor());
        [1.0, 2.0, 5.0, 10.0].into_iter().find(|n| n * power >= size / 12.0).unwrap_or(10.0) * power
    }

    /// The whole way with its curtain and the ground, flown up to frame `now`, with the robot in the frames `shown`.
    fn far(&self, now: usize, shown: &[usize], pane: Pane) -> PictureView {
        let (azimuth, elevation) = match self.asked.seen {
            Viewpoint::Side => (-90.0, 6.0),
            Viewpoint::Above => (180.0, 89.0),
            _ => (202.0, 22.0),
        };
        let Bounds { low, high } = self.bounds;
        let middle: WorldPoint = std::array::from_fn(|axis| 0.5 * (low[axis] + high[axis]));
        let size = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let mut view = PictureView {
            camera: Camera::perspective(azimuth, elevation, middle, 2.4 * size),
            bounds: self.bounds,
            pane: filled(pane),
            framed: None,
            areas: Vec::new(),
            lines: Vec::new(),
            words: Vec::new(),
        };
        self.ground(&mut view);
        if self.motion.free {
            self.way(&mut view, now);
        }
        perch(self.motion, &mut view, now);
        shown.iter().for_each(|i| robot(self.motion, &mut view, *i, self.enlarged));
        view
    }

    /// The robot near by, with a level line.
    fn near(&self, i: usize, pane: Pane, framed: bool) -> PictureView {
        let (middle, heading) = self.followed(i);
        close(self.motion, i, (middle, heading.to_degrees() + 180.0 + 18.0, 14.0), pane, framed)
    }

    /// Mean place of the body about frame `i`, and the direction over the ground in which it goes.
    fn followed(&self, i: usize) -> (Vec3, f64) {
        let motion = self.motion;
        let mean = |t: f64| {
            let near = |k: &usize| (motion.t[*k] - t).abs() <= FOLLOWS;
            let rows: Vec<usize> = (0..motion.frames()).filter(near).collect();
            let sum = rows.iter().fold(Vec3::ZERO, |sum, &k| sum + at(&motion.position, k));
            sum * (1.0 / rows.len().max(1) as f64)
        };
        let (last, t) = (motion.t[motion.frames() - 1], motion.t[i]);
        let way = mean((t + FOLLOWS).min(last)) - mean((t - FOLLOWS).max(motion.t[0]));
        let goes = motion.free && way.0[0].hypot(way.0[1]) > 1e-3 * motion.reach();
        (mean(t), if goes { way.0[1].atan2(way.0[0]) } else { 0.0 })
    }

    /// A grid under everything.
    fn ground(&self, view: &mut PictureView) {
        let Bounds { low, high } = self.bounds;
        let step = self.grid();
        let ticks = |axis: usize| {
            let (first, last) = ((low[axis] / step).ceil() as i64, (high[axis] / step).floor() as i64);
            (first..=last).map(move |k| k as f64 * step)
        };
        let z = low[2];
        let colour = if self.ground.is_some() { SOIL } else { GRID };
        view.lines.extend(ticks(0).map(|x| line(vec![[x, low[1], z], [x, high[1], z]], colour, 1.0)));
        view.lines.extend(ticks(1).map(|y| line(vec![[low[0], y, z], [high[0], y, z]], colour, 1.0)));
    }

    /// The way on its curtain: dark as far as it was flown.
    fn way(&self, view: &mut PictureView, now: usize) {
        let (n, z) = (self.motion.frames(), self.bounds.low[2]);
        let row = |k: usize| k * (n - 1) / PIECES;
        for k in 0..PIECES {
            let (i, j) = (row(k), row(k + 1));
            let (a, b) = (at(&self.motion.position, i).0, at(&self.motion.position, j).0);
            let flown = j <= now;
            let corners = vec![a, b, [b[0], b[1], z], [a[0], a[1], z]];
            let opacity = if flown { 0.3 } else { 0.12 };
            view.areas.push(Area { corners, colour: CURTAIN.into(), opacity, edge: None });
            let (colour, weight) = if flown { (WAY, 2.2) } else { ("#9a9a9a", 1.0) };
            view.lines.push(line(vec![a, b], colour, weight));
            view.lines.push(line(vec![[a[0], a[1], z], [b[0], b[1], z]], "#9a9a9a", 1.0));
        }
    }
}

/// A robot at one instant, from behind and from its right side, with level lines; width and height in px.
///
/// # Errors
/// A state in which the robot has no place.
pub fn still(
    robot: &Robot,
    t: f64,
    x: &[f64],
    u: &[f64],
    [width, height]: [f64; 2],
) -> Result<Picture, String> {
    let channel = |name: &str| {
        let number = robot.states().iter().position(|state| state.name == name);
        number.map(|number| vec![x[number]]).ok_or_else(|| format!("the robot has no state {name}"))
    };
    let [px, py, pz] = ["p_WB_x", "p_WB_y", "p_WB_z"].map(channel);
    let [w, i, j, k] = ["quat_w", "quat_x", "quat_y", "quat_z"].map(channel);
    let mut motion = RunMotion {
        t: vec![t],
        position: [px?, py?, pz?],
        attitude: [w?, i?, j?, k?],
        free: true,
        ..RunMotion::default()
    };
    add_skeleton(&mut motion, &robot.skeleton(t, x, u).map_err(|fault| fault.to_string())?);
    let [forward, left, top] =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| motion.turned(0, Vec3(axis)).0);
    let heading = forward[1].atan2(forward[0]).to_degrees();
    let place = at(&motion.position, 0);
    let pane = |n: f64| Pane { x: n * 0.5 * width, y: 0.0, width: 0.5 * width, height };
    let view = |azimuth: f64, n: f64| close(&motion, 0, (place, azimuth, 8.0), pane(n), false);
    let views = vec![view(heading + 180.0, 0.0), view(heading - 90.0, 1.0)];
    // Of body axes x forward, y left, z up: a positive roll is right wing down.
    let roll = left[2].atan2(top[2]).to_degrees();
    let nose_up = forward[2].clamp(-1.0, 1.0).asin().to_degrees();
    let [px, py, pz] = place.0;
    let title =
        format!("{t:.3} s, roll {roll:.1} deg, nose up {nose_up:.1} deg, at ({px:.2}, {py:.2}, {pz:.2}) m");
    Ok(Picture { width, height, views, title, note: String::new() })
}

/// The robot of frame `i` near by, about `middle` from `azimuth` and `elevation` (deg), with a level line and its own axis to the left and
/// right where it is free.
fn close(
    motion: &RunMotion,
    i: usize,
    (middle, azimuth, elevation): (Vec3, f64, f64),
    pane: Pane,
    framed: bool,
) -> PictureView {
    // A wing tip before the middle is seen larger.
    let reach = 1.1 * motion.reach();
    let bounds = Bounds {
        low: std::array::from_fn(|axis| middle.0[axis] - reach),
        high: std::array::from_fn(|axis| middle.0[axis] + reach),
    };
    let mut view = PictureView {
        camera: Camera::perspective(azimuth, elevation, middle.0, 7.0 * reach),
        bounds,
        pane: filled(pane),
        framed: framed.then_some(pane),
        areas: Vec::new(),
        lines: Vec::new(),
        words: Vec::new(),
    };
    perch(motion, &mut view, i);
    robot(motion, &mut view, i, 1.0);
    if motion.free {
        let (com, along) = (motion.in_world(i, at(&motion.com, i)), motion.turned(i, Vec3([1.0, 0.0, 0.0])));
        let level = direction(Vec3([-along.0[1], along.0[0], 0.0])) * reach;
        view.lines.push(line(vec![(com - level).0, (com + level).0], WAY, 1.0));
        let side = motion.turned(i, Vec3([0.0, reach, 0.0]));
        for (side, colour) in [(side, "#0072b2"), (-side, "#d55e00")] {
            view.lines.push(line(vec![com.0, (com + side).0], colour, 2.4));
        }
    }
    view
}

/// Wings and body, all distances from the body's origin enlarged.
fn robot(motion: &RunMotion, view: &mut PictureView, i: usize, enlarged: f64) {
    let place = |p: Vec3| motion.in_world(i, p * enlarged);
    for surface in &motion.surfaces {
        for (k, side) in surface.side.iter().enumerate().filter(|(k, _)| surface.covered[*k]) {
            let [one, next] = [k, k + 1].map(|k| surface.along(k, i));
            for (a, d) in one.windows(2).zip(next.windows(2)) {
                let corners = [a[0], a[1], d[1], d[0]].map(place);
                view.areas.push(shaded(&corners, SIDES[*side], Some("#333333")));
            }
        }
    }
    let rings = spindle(at(&motion.com, i), motion.reach(), 6);
    for pair in rings.windows(2).filter(|_| !motion.bare) {
        for (k, next) in (0..6).zip((1..6).chain([0])) {
            let corners = [pair[0][k], pair[0][next], pair[1][next], pair[1][k]].map(place);
            view.areas.push(shaded(&corners, BODY, None));
        }
    }
}

/// A pane from which a view that leaves room for axes fills `pane`.
fn filled(Pane { x, y, width, height }: Pane) -> Pane {
    let more = MARGIN - KEPT;
    Pane { x: x - more, y: y - more, width: width + 2.0 * more, height: height + 2.0 * more }
}

/// The perch, where there is one.
fn perch(motion: &RunMotion, view: &mut PictureView, i: usize) {
    if !motion.free {
        return;
    }
    let ends = |of: &crate::motion::LineTrack| of.points.iter().map(|point| at(point, i).0).collect();
    view.lines.extend(motion.lines.iter().map(|of| line(ends(of), WAY, 4.0)));
}

fn line(points: Vec<WorldPoint>, colour: &str, weight: f64) -> PictureLine {
    PictureLine { points, colour: colour.into(), weight }
}

/// An area as bright as it faces the light, from either side.
fn shaded(corners: &[Vec3], colour: [f64; 3], edge: Option<&'static str>) -> Area {
    let normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
    let facing = normal.dot(Vec3(LIGHT)).abs() / normal.norm().max(1e-300);
    let [r, g, b] = colour.map(|part| (part * (0.7 + 0.3 * facing)).round() as u8);
    let corners = corners.iter().map(|corner| corner.0).collect();
    Area { corners, colour: format!("#{r:02x}{g:02x}{b:02x}"), opacity: 1.0, edge }
}
