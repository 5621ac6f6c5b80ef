//! What a lattice is stepped through: surfaces in motion, a number of cycles, and the axes in which it is looked at.

use std::ops::Range;
use std::sync::Arc;

use wingbeat::aero::SectionMotion;
use wingbeat::math::Vec3;
use wingbeat_lattice::{Flight, Layout, Scene};

use super::stroke::Stroke;

/// Places of the wings at which they are held against their mirror image.
const COMPARED: usize = 97;
/// Distance from it below which a motion is symmetric, mean chords: positions of metres carry rounding.
const SYMMETRIC: f64 = 1e-9;

/// The air's axes in W: direction of flight through it, left, up.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    pub flight: Vec3,
    pub left: Vec3,
    pub up: Vec3,
}

impl Axes {
    /// Of a flight with the velocity `through` the air; at rest flight is along x.
    pub fn new(through: Vec3) -> Self {
        let flight = if through.norm() > 0.0 { through.unit() } else { Vec3::new(1.0, 0.0, 0.0) };
        let upward = if flight[0].hypot(flight[1]) > 1e-9 {
            Vec3::new(0.0, 0.0, 1.0)
        } else {
            Vec3::new(-1.0, 0.0, 0.0)
        };
        let up = (upward - flight * upward.dot(flight)).unit();
        Self { flight, left: up.cross(flight), up }
    }

    /// The components of `v` along flight, left and up.
    pub fn of(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.flight), v.dot(self.left), v.dot(self.up))
    }
}

/// Cycles and steps from rest.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    pub frequency_hz: f64,
    pub cycles: usize,
    /// Steps per cycle.
    pub steps: usize,
}

impl Clock {
    /// Step, s.
    pub fn step_s(&self) -> f64 {
        1.0 / (self.frequency_hz * self.steps as f64)
    }
    /// Number of steps.
    pub fn total(&self) -> usize {
        self.cycles * self.steps
    }
    /// The first step of the last cycle.
    pub fn first_of_last(&self) -> usize {
        (self.cycles - 1) * self.steps
    }
}

/// The flight that moves the surfaces.
#[derive(Clone)]
pub struct Flown {
    pub flight: Arc<Flight>,
    /// Time of the flight at which the course begins, s.
    pub from_s: f64,
    /// Layouts of the scene's surfaces, with the number of the robot's surface.
    pub layouts: Vec<(usize, Layout)>,
    /// Whether the circulations are those of the model that flew.
    pub by_model: bool,
}

/// What a lattice is stepped through.
pub struct Course {
    /// Beginning of its files' names; empty where there is no other course.
    pub name: String,
    /// What it is called in figures.
    pub title: String,
    pub scene: Scene,
    pub clock: Clock,
    pub stroke: Stroke,
    pub axes: Axes,
    /// Mean chord, m.
    pub chord: f64,
    /// Surfaces of the scene that mirror each other from both ends on.
    pub groups: Vec<Range<usize>>,
    pub symmetric: bool,
    pub flown: Option<Flown>,
    /// Share of strips and instants of the last cycle past the stall angle of their section.
    pub past_stall: f64,
    /// Whether parts of the robot pass through each other on the way.
    pub crosses: bool,
}

impl Course {
    /// The body's origin at `t` s of the course.
    pub fn origin(&self, t: f64) -> Vec3 {
        self.flown.as_ref().map_or(Vec3::ZERO, |flown| flown.flight.body(flown.from_s + t).0)
    }

    /// What is assumed of the flow.
    pub fn assumed(&self) -> String {
        let attached = "attached flow is assumed";
        match self.past_stall > 0.0 {
            true => format!("{attached}, {:.0} % of the strips are past stall", 100.0 * self.past_stall),
            false => attached.into(),
        }
    }

    /// What is said of wings that pass through each other.
    pub fn crossing(&self) -> Option<&'static str> {
        self.crosses.then_some("the wings cross, bound vortices are rounded off there")
    }

    /// What must be known to read a figure.
    pub fn note(&self) -> String {
        std::iter::once(self.assumed()).chain(self.crossing().map(Into::into)).collect::<Vec<_>>().join("; ")
    }

    /// Whether the wings move as their mirror images at the plane of flight and up.
    pub fn is_symmetric(&self) -> bool {
        let end = self.clock.total() as f64 * self.clock.step_s();
        let mut edges: Vec<Vec<SectionMotion<f64>>> = vec![Vec::new(); self.scene.surfaces.len()];
        (0..COMPARED).all(|k| {
            let t = end * k as f64 / COMPARED as f64;
            for (surface, edges) in self.scene.surfaces.iter().zip(&mut edges) {
                surface.sections.sections(t, &surface.layout.arcs, edges);
            }
            let origin = self.origin(t);
            let at = |p: Vec3| self.axes.of(p - origin);
            self.groups.iter().all(|group| {
                let all = || edges[group.clone()].iter().flatten().flat_map(|edge| [edge.le, edge.te]);
                let back = edges[group.clone()].iter().flatten().rev().flat_map(|edge| [edge.le, edge.te]);
                all().zip(back).all(|(a, b)| {
                    let (a, b) = (at(a), at(b));
                    (a - Vec3::new(b[0], -b[1], b[2])).norm() < SYMMETRIC * self.chord
                })
            })
        })
    }
}
