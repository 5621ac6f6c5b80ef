//! The flying robot: body and aerodynamics meet here and nowhere else. Stations
//! carry geometry down to the surfaces, loads come back up by name.

// Its derive writes nothing: schemas are made by tests alone.
#[cfg(not(feature = "schema"))]
extern crate wingbeat_no_schema as schemars;

mod air;
mod balance;
mod beyond;
pub mod body;
mod carried;
mod chord_lines;
mod clearance;
mod compiled;
mod crank;
mod drive;
mod dryden;
mod dynamics;
mod inertance;
mod joints;
mod known;
mod lanes;
mod loaded;
mod mechanism;
mod mirror;
mod numbers;
mod observe;
mod perch;
mod physical;
mod pin_springs;
mod placement;
mod regulators;
mod residual;
mod sections;
mod skeleton;
mod spar;
mod spec;
mod stance;
mod surface;
mod thrust;
mod weight;

pub use air::{Air, Pulse, Wind};
pub use beyond::BeyondLoads;
pub use carried::{BodyMotion, CarriedLoads, Deflections};
pub use compiled::{Compiled, CycleScalar};
pub use crank::*;
pub use dryden::Dryden;
pub use mirror::Mirror;
pub use numbers::{Numbers, SpringNumbers, StopNumbers, TOGETHER, Varying};
pub use numbers::{check_given, former, stands_for};
pub use observe::Observation;
pub use perch::{Contact, Perch, PerchShape, Seen};
pub use pin_springs::{PinDeflection, PinWork};
pub use placement::{PanelNumbers, PlacementNumbers};
pub use residual::{MOST_HARMONICS, RESIDUAL_FREQUENCY, Residual, Term};
pub use skeleton::{LinkPlace, Outline, Skeleton};
pub use spec::{
    BodySpec, BoundSpec, CapsuleSpec, ClearanceSpec, DrivenSpec, ElasticSpec, ElementSpec, FitUncertainty,
    FitVerdict, FittedModel, GaitSpec, GivenNumbers, JointSpec, LinkSide, LinkSparSpec, LinkSpec,
    LinkageOutput, PanelSpec, PinSpringSpec, RegulatorSpec, ResidualSpec, RobotSpec, SparInWing, SparShape,
    StopSpec, StructureSpec, SurfaceSpec, ThrusterSpec, WingLinkSpec, WingSpec,
};
pub use spec::{PHASE_RATE, counts_on_rig_alone, is_of_rig};
#[cfg(feature = "schema")]
pub use spec::{file_or, file_or_numbers, numbers_table};
pub use stance::Stance;
pub use surface::SurfaceOutline;
pub use thrust::Thruster;
pub use weight::{BROADSIDE, WeightPart, WeightShares};

use crate::body::{LinkMotion, MAX_LINKS, Response, Tree};
use arrayvec::ArrayVec;
use clearance::Clearances;
use inertance::Inertance;
use joints::{CRANK, Displaced, ElementMoves, Placed};
use loaded::Loaded;
use mechanism::Mechanism;
use std::ops::Range;
use std::sync::Arc;
use surface::Covering;
pub use wingbeat_aero::StallCount;
use wingbeat_aero::{Aero, LiftLaw, Surfaces};
use wingbeat_math::Error;
use wingbeat_math::{Jet, Scalar, Vec3};
use wingbeat_ocp::plant::{Channel, MAX_COORDINATES, Role};

/// Largest number of structure elements.
pub const MAX_ELEMENTS: usize = 16;

/// Coordinates of all joints with rates and accelerations.
pub type Joints<S> = ArrayVec<Jet<S>, MAX_LINKS>;
/// Motion of all links.
pub type Links<S> = ArrayVec<LinkMotion<S>, MAX_LINKS>;

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
    /// Coordinates of the elastic and free joints and, where a motor turns it, the angle of the crank as
    /// the last of them (m); then their rates (m).
    pub joints: usize,
    /// Angle and rate of the crank under a motor.
    pub crank: Option<[usize; 2]>,
    /// States of the surfaces, one after another.
    pub aero: usize,
    /// Number of states.
    pub len: usize,
}

/// A robot in air, as a [`Plant`](wingbeat_ocp::plant::Plant). Inputs are the
/// regulators omega of the structure elements. Its numbers are of type `P`, so that they may carry derivatives:
/// [`Robot::varied`].
#[derive(Debug)]
pub struct Robot<P: Scalar = f64> {
    mechanism: Mechanism<P>,
    phase_rate: P,
    phase_start: P,
    /// Strokes of the wings that a cycle of the gait would have without a glide.
    strokes_per_cycle: usize,
    motor: Option<CrankMotor<P>>,
    response: Response<P>,
    /// How far each element is displaced at rest.
    strokes: Vec<[f64; 2]>,
    elements: Vec<Placed>,
    moved: ElementMoves,
    /// Those of them that bear what their joints bear.
    loaded: Vec<Loaded<P>>,
    thrusters: Vec<Thruster>,
    covering: Covering<P>,
    clearances: Clearances,
    /// Links that carry surfaces.
    carriers: Vec<usize>,
    drag_area: Vec3<P>,
    /// What keeps its springs to long steps.
    inertance: Inertance<P>,
    /// Of the air that the body's drag takes, kg/m3.
    density: P,
    wind: Wind<P>,
    /// Height of the plane that the air does not cross, m in W.
    ground: Option<f64>,
    /// What the models of the air leave of measured loads.
    residual: Option<Arc<Residual>>,
    /// A perch beside it.
    perch: Option<Perch>,
    layout: Layout,
    states: Vec<Channel>,
    /// Those of them that are given.
    given: Vec<Range<usize>>,
    inputs: Vec<Channel>,
}

/// Of plain numbers alone: this is compiled here once, a copy of any numbers again in every crate that makes one.
impl Clone for Robot {
    fn clone(&self) -> Self {
        Self {
            mechanism: self.mechanism.clone(),
            phase_rate: self.phase_rate,
            phase_start: self.phase_start,
            strokes_per_cycle: self.strokes_per_cycle,
            motor: self.motor,
            response: self.response.clone(),
            strokes: self.strokes.clone(),
            elements: self.elements.clone(),
            moved: self.moved.clone(),
            loaded: self.loaded.clone(),
            thrusters: self.thrusters.clone(),
            covering: self.covering.clone(),
            clearances: self.clearances.clone(),
            carriers: self.carriers.clone(),
            drag_area: self.drag_area,
            inertance: self.inertance.clone(),
            density: self.density,
            wind: self.wind.clone(),
            ground: self.ground,
            residual: self.residual.clone(),
            perch: self.perch,
            layout: self.layout,
            states: self.states.clone(),
            given: self.given.clone(),
            inputs: self.inputs.clone(),
        }
    }
}

/// The regulator that paces the crank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pacer {
    /// Number of the element whose displacement is the phase of the gait beyond that at a constant rate, rad.
    pub element: usize,
    /// Number of the input.
    pub input: usize,
    /// Steady rate of the crank beyond the gait's over the command, in rad/s over the unit of the command.
    pub gain: f64,
}

impl Robot {
    /// Builds a robot from its specification and an aerodynamic model of each of its surfaces, in the
    /// order of [`RobotSpec::outlines`]; the gait's phase at t = 0 is `phase_start`, rad.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the offending key of the robot file.
    ///
    /// # Panics
    /// When there is not one model per surface.
    pub fn new(spec: &RobotSpec, aero: Vec<Aero>, air: Air, phase_start: f64) -> Result<Self, Error> {
        spec.check()?;
        let (own, spec) = (spec, &spec.with_thrusts());
        let mechanism = Mechanism::new(spec)?;
        let elements = Placed::all(spec, &mechanism)?;
        let carriers = carriers(spec, &mechanism)?;
        let covering = Covering::new(spec, &mechanism, &carriers, aero)?;
        let motor = motor(spec, &mechanism)?;
        if let (Some(_), Some(i)) = (motor, elements.iter().position(|e| e.moves.contains(&Displaced::Crank)))
        {
            let allowed = "joints: a motor turns the crank";
            return Err(Error::invalid(format!("structure.elements[{i}].moves"), CRANK, allowed));
        }
        let air_states = covering.aero.states();
        let layout = Layout::new(elements.len(), &mechanism, motor.is_some(), air_states);
        let response = spec.structure.build().map_err(|e| e.within("structure"))?;
        let residual =
            spec.residual.as_ref().map(Residual::new).transpose().map_err(|e| e.within("residual"))?;
        let inputs = regulators::channels(&spec.structure, &elements).map_err(|e| e.within("structure"))?;
        let robot = Self {
            phase_rate: joints::phase_rate(&spec.gait),
            phase_start,
            strokes_per_cycle: spec.gait.bound().map_or(1, BoundSpec::strokes_per_cycle),
            motor,
            response,
            strokes: regulators::strokes(&spec.structure, &elements, &inputs),
            carriers,
            drag_area: Vec3(spec.body.drag_area_m2),
            inertance: Inertance::none(),
            density: air.density,
            wind: air.wind,
            ground: None,
            residual: residual.map(Arc::new),
            perch: None,
            layout,
            states: layout.channels(&elements, &mechanism, &covering.aero),
            given: Vec::new(),
            inputs,
            loaded: Loaded::all(spec, &elements, &mechanism)?,
            thrusters: Thruster::all(&own.thrusters, own.structure.elements.len()),
            moved: ElementMoves::by(&elements),
            elements,
            covering,
            clearances: Clearances::new(spec, &mechanism)?,
            mechanism,
        };
        spec.residual.iter().try_for_each(|residual| robot.check_residual(residual))?;
        Ok(robot)
    }

    /// Where each part of the state lies.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }
    /// Body, links and joints.
    pub fn tree(&self) -> &Tree {
        &self.mechanism.tree
    }
    /// Names of the joints, in the order of the tree.
    pub fn joint_names(&self) -> impl Iterator<Item = &str> {
        (0..self.tree().links()).map(|i| self.tree().name(i))
    }
    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.mechanism.tree.mass()
    }
    /// The surfaces with their aerodynamic models.
    pub fn surfaces(&self) -> impl Iterator<Item = (&str, &Aero)> {
        self.covering.aero.surfaces().iter().map(|s| (s.name(), s.aero()))
    }
    /// Names of the ends of all panels, surface after surface, as [`Observation::outlines`] has them; of
    /// surfaces beyond the first with the surface's name before.
    pub fn outline_names(&self) -> Vec<String> {
        self.covering.laid.iter().enumerate().flat_map(|(i, s)| s.outline_names(i == 0)).collect()
    }
    /// How far each structure element is displaced by held commands within their limits, rad or m.
    pub fn strokes(&self) -> &[[f64; 2]] {
        &self.strokes
    }
    /// Density of the air, kg/m3.
    pub fn density(&self) -> f64 {
        self.density
    }
    /// Velocity of the air without its gust, m/s in W.
    pub fn mean_wind(&self) -> Vec3 {
        self.wind.mean()
    }
    /// Velocity of the air over time.
    pub fn wind_over_time(&self) -> &Wind {
        &self.wind
    }
    /// The same robot where there is no air: its surfaces keep their places, bear nothing and have no states.
    #[must_use]
    pub fn in_vacuum(mut self) -> Self {
        self.covering.strip();
        (self.density, self.residual) = (0.0, None);
        self.lay_states()
    }
    /// The same robot under another law of lift; what is measured of its loads belongs to its own and is left out.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a surface has no model under it.
    pub fn under(&self, law: LiftLaw) -> Result<Self, Error> {
        let mut other = Self { residual: None, ..self.clone() };
        other.covering.aero = other.covering.aero.under(law)?;
        Ok(other.lay_states())
    }
    /// Its state that has the numbers of the state `x` of the robot `other`, in the units of its states, where names are the same, and 0
    /// elsewhere.
    pub fn named_as(&self, other: &Self, x: &[f64]) -> Vec<f64> {
        let of = |own: &Channel| {
            other.states.iter().position(|other| other.name == own.name).map_or(0.0, |i| x[i])
        };
        self.states.iter().map(of).collect()
    }
    /// The same robot over a ground, or under a ceiling, at the height `ground` m in W: its surfaces of preset `full` feel the mirror
    /// images of all vortices as it flies, for which states follow.
    #[must_use]
    pub fn over(mut self, ground: f64) -> Self {
        self.covering.aero = self.covering.aero.over_ground();
        self.ground = Some(ground);
        self.lay_states()
    }
    /// The states anew, of which those of the air come last.
    fn lay_states(mut self) -> Self {
        let air = &self.covering.aero;
        self.layout = Layout::new(self.elements.len(), &self.mechanism, self.motor.is_some(), air.states());
        self.states = self.layout.channels(&self.elements, &self.mechanism, air);
        self
    }
    /// The same robot, the shape of whose wings is given: joints of spars with their rates and accelerations, membranes with both heights,
    /// their rates and the rate as followed. They stand among the states and have no rates of their own; the air, body and the other
    /// joints feel them as before.
    ///
    /// Equation: robot.given_shape
    /// `M_rr a_r = F_r(x, s, s') - M_rs s''; s spars and cambers as functions of time, their own balance left out`
    /// Source: rheonomic constraint (Goldstein 1980, section 1.3), the multipliers of which the rows left out hold.
    /// Test: `a_robot_whose_shape_is_given_moves_as_the_one_that_found_it`.
    #[must_use]
    pub fn with_shape_given(&self) -> Self {
        let mut other = self.clone();
        let spars = 3 * self.mechanism.pieces().count();
        other.mechanism = self.mechanism.with_spars_given();
        other.inertance = Inertance::none();
        let (air, given) = self.covering.aero.with_shapes_given();
        other.covering.aero = air;
        other = other.lay_states();
        let aero = other.layout.aero;
        other.given = given.into_iter().map(|run| aero + run.start..aero + run.end).collect();
        if spars > 0 {
            other.given.insert(0, aero - spars..aero);
        }
        // Where it fails at rest, its flight does.
        let _ = other.set_inertance(self.inertance.time);
        other
    }
    /// Whether its wings give way: it has spars or membranes.
    pub fn is_soft(&self) -> bool {
        !self.mechanism.spars.is_empty() || self.surfaces().any(|(_, aero)| aero.membrane().is_some())
    }
    /// Height of the plane that the air does not cross, m in W.
    pub fn ground(&self) -> Option<f64> {
        self.ground
    }
    /// Whether there is no air.
    pub fn is_in_vacuum(&self) -> bool {
        self.density == 0.0
    }
    /// The same robot, its gait's frequency times `pace`.
    #[must_use]
    pub fn paced(&self, pace: f64) -> Self {
        Self { phase_rate: self.phase_rate * pace, ..self.clone() }
    }
    /// How the elements follow the commands.
    pub fn response(&self) -> &Response {
        &self.response
    }
    /// Displacements of the elements at rest by the held commands, in the units of elements over those of commands, a row for
    /// each element; none of what follows its command with its rate.
    pub fn rest_gains(&self) -> Vec<f64> {
        self.response.rest()
    }
    /// Whether the coordinate of the joint `joint` is a state.
    pub fn is_elastic(&self, joint: usize) -> bool {
        self.mechanism.coordinates.contains(&joint)
    }
    /// The joints at which the pieces of spars turn against each other.
    pub fn spar_joints(&self) -> Vec<usize> {
        self.mechanism.pieces().collect()
    }
    /// How the spars of its links stand for beams in their surfaces, as the file gives them; none without one.
    pub fn spar_shape(&self) -> Option<SparShape> {
        self.mechanism.spar_shape
    }
    /// Whether the joint `joint` twists a wing: it turns a link of one side, which carries a surface, about its span.
    pub fn is_twist(&self, joint: usize) -> bool {
        let sided = self.mechanism.twins[joint] != joint;
        sided && self.tree().turns_about_y(joint) && self.carriers.contains(&joint)
    }
    /// The regulator that paces the crank, if there is one.
    pub fn pacer(&self) -> Option<Pacer> {
        let element = self.elements.iter().position(|e| e.moves.contains(&Displaced::Crank))?;
        let gain = |input: &usize| self.response.command_gain(element, *input);
        let input = (0..self.inputs.len()).find(|input| gain(input) != 0.0)?;
        let damping = -self.response.state_gain(element, self.elements.len() + element);
        (damping > 0.0).then(|| Pacer { element, input, gain: gain(&input) / damping })
    }
    /// Strokes of the wings in a cycle of the gait, those left out in a glide too.
    pub fn strokes_per_cycle(&self) -> usize {
        self.strokes_per_cycle
    }
    /// Flapping frequency of the gait, Hz; a motor starts with it. Of a bound that of strokes and glide together.
    pub fn frequency_hz(&self) -> f64 {
        self.phase_rate / std::f64::consts::TAU
    }
    /// Flapping phase at time `t` at a constant rate, rad.
    pub fn phase(&self, t: f64) -> f64 {
        self.phase_start + self.phase_rate * t
    }
}

impl<P: Scalar> Robot<P> {
    /// Where the states of elastic and free joints and crank start, from [`Layout::joints`] to
    /// [`Layout::aero`]: the joints at rest, the crank at the starting phase and the gait's frequency.
    pub fn start_coordinates(&self) -> Vec<P> {
        let crank = |state: P| self.motor.map(|_| state);
        let still = self.mechanism.springs().map(|_| P::ZERO);
        let joints = self.mechanism.springs().map(|s| P::from(s.start)).chain(crank(self.phase_start));
        joints.chain(still).chain(crank(self.phase_rate)).collect()
    }
    /// States of the carried robot as it hangs still in still air, in the units of their channels. Elements have no
    /// displacement, joints are where they start, and the crank of a motor stands at the starting phase.
    pub fn carried_still(&self) -> Vec<P> {
        let mut x = vec![P::ZERO; self.carried_states()];
        let mut joints = self.start_coordinates();
        if self.motor.is_some() {
            joints.pop();
            joints.push(P::ZERO);
        }
        x[self.layout.joints - self.layout.structure..][..joints.len()].copy_from_slice(&joints);
        x
    }
}

/// The motor, if there is one, of a gait that moves something.
fn motor(spec: &RobotSpec, mechanism: &Mechanism) -> Result<Option<CrankMotor>, Error> {
    let motor = spec.drive.build().map_err(|e| e.within("drive"))?;
    let key = || format!("drive.{}", spec.drive.given().join(", "));
    if motor.is_some() && !mechanism.drives.iter().any(mechanism::JointDrive::cranked) {
        return Err(Error::invalid(key(), "given", "a motor only where a gait drives joints"));
    }
    if motor.is_some() && mechanism.coordinates.len() == MAX_COORDINATES {
        let allowed = format!("at most {} elastic or free joints beside a motor", MAX_COORDINATES - 1);
        return Err(Error::invalid(key(), "given", allowed));
    }
    Ok(motor)
}

/// The links that carry surfaces, ascending.
fn carriers(spec: &RobotSpec, mechanism: &Mechanism) -> Result<Vec<usize>, Error> {
    let mut carriers = Vec::new();
    for (surface, outline) in spec.all_surfaces().zip(spec.outlines()?) {
        for (i, panel) in surface.panels.iter().enumerate() {
            let key = format!("{}.panels[{i}].link", outline.key);
            for side in 0..2 {
                carriers.extend(mechanism.link_on(&key, &panel.link, side)?);
            }
        }
    }
    carriers.sort_unstable();
    carriers.dedup();
    Ok(carriers)
}

impl Layout {
    fn new(elements: usize, mechanism: &Mechanism, motor: bool, aero_states: usize) -> Self {
        let joints = 13 + 2 * elements;
        let degrees = mechanism.coordinates.len() + usize::from(motor);
        let given = joints + 2 * degrees;
        let aero = given + 3 * mechanism.given.len();
        let crank = motor.then_some([joints + degrees - 1, given - 1]);
        let len = aero + aero_states;
        Self { position: 0, attitude: 3, velocity: 7, rate: 10, structure: 13, joints, crank, aero, len }
    }

    fn channels(&self, elements: &[Placed], mechanism: &Mechanism, air: &Surfaces) -> Vec<Channel> {
        let axes = |name: &'static str, unit, frame, of: &'static str, role: fn(usize) -> Role| {
            let axes = of.chars().enumerate();
            axes.map(move |(i, axis)| Channel::free(format!("{name}_{axis}"), unit, frame).of(role(i)))
        };
        let element = |prefix: &'static str, of: usize, role: fn(usize) -> Role| {
            let channel = move |e: &Placed| Channel::free(format!("{prefix}_{}", e.name), e.units[of], "");
            elements.iter().enumerate().map(move |(i, e)| channel(e).of(role(i)))
        };
        let joint = |prefix: &'static str, of: usize, role: fn(usize) -> Role| {
            let tree = &mechanism.tree;
            let named = move |i: usize| (format!("{prefix}_{}", tree.name(i)), tree.kind(i).units()[of]);
            let named = mechanism.coordinates.iter().map(move |&i| named(i)).enumerate();
            named.map(move |(k, (name, unit))| Channel::free(name, unit, "").of(role(k)))
        };
        let crank = |name, unit, role| self.crank.map(|_| Channel::free(name, unit, "").of(role));
        let spar = |prefix: &'static str, unit: &'static str| {
            let names = mechanism.given.iter().map(|&joint| mechanism.tree.name(joint));
            names.map(move |name| Channel::free(format!("{prefix}_{name}"), unit, ""))
        };
        axes("p_WB", "m", "W", "xyz", Role::Position)
            .chain(axes("quat", "", "WB", "wxyz", Role::Attitude))
            .chain(axes("v_WB_W", "m/s", "W", "xyz", Role::Velocity))
            .chain(axes("w_WB_B", "rad/s", "B", "xyz", Role::AngularRate))
            .chain(element("displacement", 0, Role::Displacement))
            .chain(element("rate", 1, Role::DisplacementRate))
            .chain(joint("coordinate", 0, Role::Coordinate))
            .chain(crank("crank_angle", "rad", Role::Crank))
            .chain(joint("coordinate_rate", 1, Role::CoordinateRate))
            .chain(crank("crank_rate", "rad/s", Role::CrankRate))
            .chain(spar("coordinate", "rad"))
            .chain(spar("coordinate_rate", "rad/s"))
            .chain(spar("rate_of_coordinate_rate", "rad/s2"))
            .chain(air.channels().into_iter().map(|c| c.of(Role::Air)))
            .collect()
    }
}
