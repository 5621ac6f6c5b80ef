//! Views of a robot or a rig with its frames, links, hinges, outlines, mount and arm.

mod sheet;

use wingbeat::body::JointKind;
use wingbeat::math::Vec3;
use wingbeat::rig::Pose;
use wingbeat::rig::arm::SerialArm;
use wingbeat::rig::carrier::CellMount;
use wingbeat::robot::Skeleton;

use crate::style;
use crate::write::Figure;
use sheet::Sheet;

/// A point, m.
type ViewPoint = [f64; 3];

/// Length of the axes of a frame, and of a hinge on either side, over the size of what is drawn.
const AXIS: f64 = 0.07;

/// Number of joints of one name but for their numbers from which on only the first is named. *Choice.*
const SEVERAL: usize = 4;

/// Most letters of a line of notes.
const WIDEST: usize = 112;

/// How a line looks.
#[derive(Clone, Copy)]
struct LineLook {
    colour: &'static str,
    weight: f64,
    dashes: Option<&'static str>,
}

impl LineLook {
    const fn line(colour: &'static str, weight: f64) -> Self {
        Self { colour, weight, dashes: None }
    }
}

/// What is drawn, in one frame.
#[derive(Default)]
pub struct Drawing {
    lines: Vec<(Vec<ViewPoint>, LineLook)>,
    areas: Vec<(Vec<ViewPoint>, &'static str, f64)>,
    dots: Vec<(ViewPoint, f64, &'static str)>,
    frames: Vec<Pose>,
    labels: Vec<(ViewPoint, String)>,
    notes: Vec<String>,
}

impl Drawing {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Words below the drawing.
    pub fn note(&mut self, text: &str) {
        let mut line = String::new();
        for word in text.split_whitespace() {
            if line.len() + word.len() > WIDEST {
                self.notes.push(std::mem::take(&mut line));
            }
            line += if line.is_empty() { "" } else { " " };
            line += word;
        }
        self.notes.push(line);
    }

    /// A frame with its name.
    pub fn frame(&mut self, name: &str, at: &Pose) {
        self.frames.push(*at);
        self.labels.push((at.origin.0, name.into()));
    }

    /// The robot with its body at `at`; hinges, links and centres of mass named where `labelled`.
    pub fn robot(&mut self, robot: &Skeleton, at: &Pose, labelled: bool) {
        let place = |p: Vec3| at.point(p).0;
        for outline in &robot.outlines {
            self.outline(outline, at);
        }
        for link in &robot.links {
            let from = link.parent.map_or(Vec3::ZERO, |parent| robot.links[parent].origin);
            let bone = vec![place(from), place(link.origin)];
            self.lines.push((bone, LineLook::line(style::INK, 2.0)));
        }
        if !labelled {
            return;
        }
        let size = AXIS * reach(robot);
        for (i, link) in robot.links.iter().enumerate() {
            // The pieces of a spar are too many to name each.
            let alike = robot
                .links
                .iter()
                .enumerate()
                .filter(|(_, other)| unnumbered(&other.name) == unnumbered(&link.name));
            let (alike, first) = (alike.clone().count(), alike.clone().all(|(k, _)| k >= i));
            let named = alike < SEVERAL || first;
            let several = if alike < SEVERAL { String::new() } else { format!(", one of {alike}") };
            let name = match link.kind {
                JointKind::Revolute => format!("hinge {}{several}", link.name),
                JointKind::Prismatic => format!("slide {}{several}", link.name),
            };
            let ends = [-size, size].map(|s| place(link.origin + link.axis * s));
            let look = LineLook { colour: style::colour(3), weight: 1.4, dashes: Some("5 2") };
            self.lines.push((ends.into(), look));
            self.labels.extend(named.then(|| (place(link.origin), name)));
            if link.mass > 0.0 {
                self.dots.push((place(link.com), 3.0, style::GUIDE));
                let mass = || format!("{:.2} g, {}{several}", 1e3 * link.mass, link.name);
                self.labels.extend(named.then(|| (place(link.com), mass())));
            }
        }
        let (mass, com) = robot.body;
        self.dots.push((place(com), 3.0, style::GUIDE));
        self.labels.push((place(com), format!("{:.2} g, body", 1e3 * mass)));
        self.dots.push((place(robot.center_of_mass), 4.0, style::INK));
        self.labels.push((place(robot.center_of_mass), "centre of mass of all".into()));
    }

    /// A surface: its panels, edges and ribs, and the hinge line of a flap, left and right in the colours of the sides.
    pub fn outline(&mut self, outline: &wingbeat::robot::Outline, at: &Pose) {
        let edge = |p: Vec3| at.point(p).0;
        let count = outline.covered.len();
        for (i, pair) in outline.ribs.windows(2).enumerate() {
            if !outline.covered[i] {
                continue;
            }
            let (_, side) = style::SIDES[usize::from(2 * i >= count)];
            let [[a, b], [c, d]] = [pair[0].map(edge), pair[1].map(edge)];
            let colour = style::colour(side);
            let hinge = outline.hinge.map(|k| [i, i + 1].map(|rib| edge(outline.raised[rib][k])));
            let (areas, [left, right]) = match hinge {
                Some([h, k]) => {
                    self.lines.push((vec![h, k], LineLook::line(colour, 0.9)));
                    (vec![vec![a, c, k, h], vec![h, k, d, b]], [vec![a, h, b], vec![c, k, d]])
                }
                None => (vec![vec![a, c, d, b]], [vec![a, b], vec![c, d]]),
            };
            self.areas.extend(areas.into_iter().map(|area| (area, colour, 0.35)));
            for line in [vec![a, c], vec![b, d], left, right] {
                self.lines.push((line, LineLook::line(colour, 0.9)));
            }
        }
    }

    /// The arm in the posture `q` (rad or m) on its base, joints named where `labelled`; the pose of its tool.
    pub fn arm(&mut self, arm: &SerialArm, q: &[f64], labelled: bool) -> Pose {
        let frames = arm.frames(q);
        let mut bones = vec![[0.0; 3]];
        bones.extend(frames[..=arm.dof()].iter().map(|frame| frame.origin.0));
        self.lines.push((bones, LineLook::line(style::GUIDE, if labelled { 7.0 } else { 3.0 })));
        let size = AXIS;
        for (joint, frame) in arm.joints.iter().zip(&frames).filter(|_| labelled) {
            let axis = frame.rotation * joint.axis;
            let ends = [-size, size].map(|s| (frame.origin + axis * s).0);
            let look = LineLook { colour: style::colour(3), weight: 1.4, dashes: Some("5 2") };
            self.lines.push((ends.into(), look));
            self.labels.push((frame.origin.0, joint.name.clone()));
        }
        frames[arm.dof()]
    }

    /// A horizontal table of half the width `half` m at the height `z` m, and what the arm stands on.
    pub fn table(&mut self, z: f64, half: f64) {
        self.lines.push((
            vec![[0.0; 3], [0.0, 0.0, z]],
            LineLook { dashes: Some("3 3"), ..LineLook::line(style::GUIDE, 3.0) },
        ));
        let corners = [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
        self.areas.push((corners.into(), style::SHADE, 0.5));
        let around = corners.into_iter().chain([corners[0]]);
        self.lines.push((around.collect(), LineLook::line(style::GUIDE, 0.8)));
        self.labels.push(([0.0, -half, z], format!("table, z = {} m", style::number(z))));
    }

    /// The robot on its mount, whose tool frame is at `tool`: cell, sting and body; the pose of the body.
    pub fn mounted(&mut self, robot: &Skeleton, mount: &CellMount, tool: &Pose, labelled: bool) -> Pose {
        let cell = *tool * mount.cell;
        let body = cell * mount.body;
        let sting = vec![tool.origin.0, cell.origin.0, body.origin.0];
        self.lines.push((sting, LineLook::line(style::colour(4), if labelled { 4.0 } else { 2.0 })));
        self.robot(robot, &body, false);
        if labelled {
            self.labels.push((cell.point(mount.com).0, format!("mount, {:.1} g", 1e3 * mount.mass)));
            for (name, frame) in [("tool T", tool), ("cell C", &cell), ("body B", &body)] {
                self.frame(name, frame);
            }
        }
        body
    }

    /// A path of a point.
    pub fn path(&mut self, points: Vec<ViewPoint>) {
        self.lines.push((points, LineLook::line(style::INK, 1.0)));
    }

    /// Words at a point.
    pub fn label(&mut self, at: ViewPoint, text: impl Into<String>) {
        self.labels.push((at, text.into()));
    }

    /// A large labelled view and three from the sides.
    pub fn views(&self, name: &'static str, title: &str) -> Figure {
        Figure::new(name, Sheet::labelled(self, title))
    }

    /// Two views, oblique and from above, with the labels in the first.
    pub fn snapshots(&self, name: &'static str, title: &str) -> Figure {
        Figure::new(name, Sheet::pair(self, title))
    }

    fn points(&self) -> impl Iterator<Item = ViewPoint> {
        let lines = self.lines.iter().flat_map(|line| line.0.iter().copied());
        lines.chain(self.areas.iter().flat_map(|area| area.0.iter().copied()))
    }

    /// Largest side of the box around what is drawn, m.
    fn size(&self) -> f64 {
        let span = |i: usize| style::span(self.points().map(|p| p[i]));
        (0..3).map(|i| span(i).1 - span(i).0).fold(1e-6, f64::max)
    }
}

/// A name without its numbers.
fn unnumbered(name: &str) -> String {
    name.chars().filter(|letter| !letter.is_ascii_digit()).collect()
}

/// Largest distance of an edge from the body origin, m.
fn reach(robot: &Skeleton) -> f64 {
    let ribs = robot.outlines.iter().flat_map(|outline| outline.ribs.iter().flatten());
    ribs.map(|p| p.norm()).chain(robot.links.iter().map(|link| link.origin.norm())).fold(1e-3, f64::max)
}
