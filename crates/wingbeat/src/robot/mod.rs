//! The flying robot: body and aerodynamics meet here and nowhere else. Stations
//! carry geometry down to the wing, loads come back up by name.

mod air;
mod carried;
mod dynamics;
mod mirror;
mod observe;
mod sections;
mod spec;

pub use air::{Air, Wind};
pub use carried::{BodyMotion, CarriedLoads};
pub use mirror::Mirror;
pub use observe::{Observation, WING_POINTS};
pub use spec::{BodySpec, Displaced, ElementSpec, GaitSpec, LinkSpec, RobotSpec, StructureSpec, WingSpec};

use crate::Error;
use crate::aero::Aero;
use crate::body::{Base, Gait, Link, Response, Tree};
use crate::math::{Mat3, Vec3};
use crate::plant::{Channel, Role};
use sections::Section;

/// Joints of both wings, left first; from body to tip: sweep about z (positive
/// forward), shoulder about x (positive up), elbow about x (positive up), twist
/// about the span (positive nose up).
pub const JOINTS: [&str; 8] = [
    "sweep_left",
    "shoulder_left",
    "elbow_left",
    "twist_left",
    "sweep_right",
    "shoulder_right",
    "elbow_right",
    "twist_right",
];

/// Largest number of structure elements.
pub const MAX_ELEMENTS: usize = 16;

/// Links that carry the wing: proximal and distal, left and right.
const CARRIERS: [usize; 4] = [1, 3, 5, 7];

/// Index of the state's parts.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Position p_WB, m (3).
    pub position: usize,
    /// Attitude q_WB, w x y z (4).
    pub attitude: usize,
    /// Velocity v_WB_W, m/s (3).
    pub velocity: usize,
    /// Angular rate w_WB_B, rad/s (3).
    pub rate: usize,
    /// Displacements of the structure elements (n), then their rates (n).
    pub structure: usize,
    /// States of the aerodynamic model.
    pub aero: usize,
    /// Number of states.
    pub len: usize,
}

/// A robot in air, as a [`Plant`](crate::plant::Plant). Inputs are the
/// regulators omega of the structure elements.
#[derive(Clone, Debug)]
pub struct Robot {
    tree: Tree,
    gait: Gait,
    phase_rate: f64,
    phase_start: f64,
    response: Response,
    displaced: Vec<Vec<Displaced>>,
    aero: Aero,
    sections: Vec<Section>,
    strip_links: Vec<Option<usize>>,
    wing_points: [Section; WING_POINTS],
    drag_area: Vec3,
    air: Air,
    layout: Layout,
    states: Vec<Channel>,
    inputs: Vec<Channel>,
}

impl Robot {
    /// Builds a robot from its specification and an aerodynamic model of its
    /// planform; the gait's phase at t = 0 is `phase_start`, rad.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the offending key of the robot file.
    pub fn new(spec: &RobotSpec, aero: Aero, air: Air, phase_start: f64) -> Result<Self, Error> {
        spec.check()?;
        let planform = spec.wing.outline().map_err(|e| e.within("wing"))?;
        let section = |s: &f64| Section::at(*s, &spec.wing, &planform);
        let elements = spec.structure.elements.len();
        let layout = Layout::new(elements, aero.states());
        let gait = spec.gait.build().map_err(|e| e.within("gait"))?;
        Ok(Self {
            tree: tree(spec)?,
            phase_rate: std::f64::consts::TAU * spec.gait.frequency_hz(),
            phase_start,
            response: spec.structure.build().map_err(|e| e.within("structure"))?,
            displaced: spec.structure.elements.iter().map(|e| e.moves.clone()).collect(),
            strip_links: aero.strip_arcs().iter().map(|s| section(s).link).collect(),
            sections: aero.arcs().iter().map(section).collect(),
            wing_points: observe::wing_point_arcs(spec, &planform).map(|s| section(&s)),
            drag_area: Vec3(spec.body.drag_area_m2),
            air,
            layout,
            states: layout.channels(spec, &aero),
            inputs: spec.structure.channels(&gait).map_err(|e| e.within("structure"))?,
            gait,
            aero,
        })
    }

    /// Where each part of the state lies.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }
    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.tree.mass()
    }
    /// The aerodynamic model.
    pub fn aero(&self) -> &Aero {
        &self.aero
    }
    /// Velocity of the air without its gust, m/s in W.
    pub fn mean_wind(&self) -> Vec3 {
        self.air.wind.mean()
    }
    /// Flapping frequency of the gait, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.phase_rate / std::f64::consts::TAU
    }
    /// Flapping phase at time `t`, rad.
    pub fn phase(&self, t: f64) -> f64 {
        self.phase_start + self.phase_rate * t
    }
}

impl Layout {
    fn new(elements: usize, aero_states: usize) -> Self {
        let aero = 13 + 2 * elements;
        Self { position: 0, attitude: 3, velocity: 7, rate: 10, structure: 13, aero, len: aero + aero_states }
    }

    fn channels(&self, spec: &RobotSpec, aero: &Aero) -> Vec<Channel> {
        let axes = |name: &'static str, unit, frame, of: &'static str, role: fn(usize) -> Role| {
            let axes = of.chars().enumerate();
            axes.map(move |(i, axis)| Channel::free(format!("{name}_{axis}"), unit, frame).of(role(i)))
        };
        let elements = &spec.structure.elements;
        let displacement = |(i, e): (usize, &ElementSpec)| {
            Channel::free(format!("displacement_{}", e.name), e.unit(), "").of(Role::Displacement(i))
        };
        let rate = |(i, e): (usize, &ElementSpec)| {
            Channel::free(format!("rate_{}", e.name), e.rate_unit(), "").of(Role::DisplacementRate(i))
        };
        axes("p_WB", "m", "W", "xyz", Role::Position)
            .chain(axes("quat", "", "WB", "wxyz", Role::Attitude))
            .chain(axes("v_WB_W", "m/s", "W", "xyz", Role::Velocity))
            .chain(axes("w_WB_B", "rad/s", "B", "xyz", Role::AngularRate))
            .chain(elements.iter().enumerate().map(displacement))
            .chain(elements.iter().enumerate().map(rate))
            .chain(aero.channels().into_iter().map(|channel| channel.of(Role::Air)))
            .collect()
    }
}

/// Body with four hinges and two massive links per wing; the right wing mirrors the left.
fn tree(spec: &RobotSpec) -> Result<Tree, Error> {
    let (wing, body) = (&spec.wing, &spec.body);
    let mut links = Vec::with_capacity(JOINTS.len());
    for (first, mirror) in [(0, 1.0), (4, -1.0)] {
        let hinge = |i: usize, arm: f64, axis: Vec3, carried: Option<&LinkSpec>| Link {
            name: JOINTS[first + i].into(),
            parent: i.checked_sub(1).map(|p| first + p),
            origin: Vec3::new(0.0, mirror * arm, 0.0),
            orientation: Mat3::IDENTITY,
            axis,
            mass: carried.map_or(0.0, |l| l.mass_kg),
            com: carried.map_or(Vec3::ZERO, |l| mirrored(l.com_m, mirror)),
            inertia: carried.map_or(Mat3::ZERO, |l| Mat3::diagonal(Vec3(l.inertia_kg_m2))),
        };
        let up = Vec3::new(mirror, 0.0, 0.0);
        let mut sweep = hinge(0, 0.0, Vec3::new(0.0, 0.0, -mirror), None);
        sweep.origin = mirrored(wing.shoulder_m, mirror);
        links.push(sweep);
        links.push(hinge(1, 0.0, up, Some(&wing.proximal)));
        links.push(hinge(2, wing.proximal.length_m, up, None));
        links.push(hinge(3, 0.0, Vec3::new(0.0, -1.0, 0.0), Some(&wing.distal)));
    }
    let base =
        Base { mass: body.mass_kg, com: Vec3(body.com_m), inertia: Mat3::diagonal(Vec3(body.inertia_kg_m2)) };
    Tree::new(&base, &links)
}

fn mirrored(v: [f64; 3], mirror: f64) -> Vec3 {
    Vec3::new(v[0], mirror * v[1], v[2])
}
