//! Joint coordinates over time: gait, structure response and states of elastic joints.

use super::drive::Ratios;
use super::mechanism::{JointDrive, Mechanism};
use super::spec::{ElementSpec, GaitSpec, LinkageOutput, RobotSpec};
use super::{Joints, MAX_ELEMENTS, Robot};
use crate::body::{LinkagePose, REGULATED};
use wingbeat_math::Error;
use wingbeat_math::names::one_of;
use wingbeat_math::{Jet, Meets, Over, Scalar, append_copies};
use wingbeat_ocp::plant::Fault;

/// Name of the crank among what an element may move.
pub(super) const CRANK: &str = "crank";

/// What a structure element displaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Displaced {
    /// A driven joint.
    Joint(usize),
    /// The series of a driven joint about its mean: the share by which its harmonics grow.
    Scale(usize),
    /// The rest of the spring of an elastic joint.
    Rest(usize),
    /// The crank: the phase of the gait beyond that at a constant rate.
    Crank,
    /// The thrust of a thruster, which moves no joint.
    Thrust(usize),
    /// A length of the linkage of a wing (0 left, 1 right), by its place in [`REGULATED`].
    Length(usize, usize),
}

impl Displaced {
    /// The joint whose series is scaled.
    fn scaled(name: &str, mechanism: &Mechanism) -> Result<Self, Error> {
        let series = |i: &usize| matches!(mechanism.drives[*i], JointDrive::Series(..));
        let tree = &mechanism.tree;
        tree.find(name).filter(series).map(Self::Scale).ok_or_else(|| {
            let names: Vec<&str> = (0..tree.links()).filter(series).map(|i| tree.name(i)).collect();
            Error::invalid("scales", format!("{name:?}"), one_of(name, &names))
        })
    }

    /// The joint, length or crank called `name`.
    fn find(name: &str, mechanism: &Mechanism) -> Result<Self, Error> {
        if name == CRANK
            && mechanism.tree.find(CRANK).is_none()
            && mechanism.drives.iter().any(JointDrive::cranked)
        {
            return Ok(Self::Crank);
        }
        let lengths = || {
            let of = |(wing, side)| {
                REGULATED.iter().enumerate().map(move |(i, l)| (wing, i, format!("{l}{side}")))
            };
            super::mechanism::SIDES.into_iter().enumerate().flat_map(of)
        };
        let tree = &mechanism.tree;
        let movable = |i: &usize| !matches!(mechanism.drives[*i], JointDrive::Fixed);
        if let Some(joint) = tree.find(name).filter(movable) {
            return Ok(match &mechanism.drives[joint] {
                JointDrive::Elastic(_) => Self::Rest(joint),
                _ => Self::Joint(joint),
            });
        }
        let length = lengths().find(|(.., length)| mechanism.linkage.is_some() && length == name);
        if let Some((wing, i, _)) = length {
            return Ok(Self::Length(wing, i));
        }
        let mut names: Vec<String> =
            (0..tree.links()).filter(movable).map(|i| tree.name(i).to_string()).collect();
        if mechanism.linkage.is_some() {
            names.extend(lengths().map(|(.., name)| name));
        }
        Err(Error::invalid("moves", format!("{name:?}"), one_of(name, &names)))
    }

    /// The same of the other side.
    pub fn mirrored(self, mechanism: &Mechanism) -> Self {
        match self {
            Self::Joint(joint) => Self::Joint(mechanism.twins[joint]),
            Self::Scale(joint) => Self::Scale(mechanism.twins[joint]),
            Self::Rest(joint) => Self::Rest(mechanism.twins[joint]),
            Self::Crank | Self::Thrust(_) => self,
            Self::Length(wing, i) => Self::Length(1 - wing, i),
        }
    }

    /// Units of the displacement, its rate and the command.
    fn units(self, mechanism: &Mechanism) -> [&'static str; 3] {
        match self {
            Self::Joint(joint) | Self::Rest(joint) => {
                let [unit, rate, _] = mechanism.tree.kind(joint).units();
                [unit, rate, unit]
            }
            Self::Scale(_) => ["", "1/s", ""],
            Self::Crank => ["rad", "rad/s", "rad/s"],
            Self::Thrust(_) => ["N", "N/s", "N"],
            Self::Length(..) => ["m", "m/s", "m"],
        }
    }

    fn alike(self, other: Self, mechanism: &Mechanism) -> bool {
        match (self, other) {
            (Self::Joint(a), Self::Joint(b)) | (Self::Rest(a), Self::Rest(b)) => {
                mechanism.tree.kind(a) == mechanism.tree.kind(b)
            }
            (Self::Scale(_), Self::Scale(_)) | (Self::Crank, Self::Crank) => true,
            (Self::Length(_, a), Self::Length(_, b)) | (Self::Thrust(a), Self::Thrust(b)) => a == b,
            _ => false,
        }
    }
}

/// A structure element in place.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub name: String,
    pub moves: Vec<Displaced>,
    /// Units of the displacement, its rate and the command.
    pub units: [&'static str; 3],
    /// Its own limits: given, or of a link length.
    pub limits: Option<[f64; 2]>,
}

impl Placed {
    /// The elements of the structure.
    pub fn all(spec: &RobotSpec, mechanism: &Mechanism) -> Result<Vec<Self>, Error> {
        let place = |(i, e): (usize, &ElementSpec)| {
            Self::new(e, mechanism).map_err(|error| error.within(&format!("structure.elements[{i}]")))
        };
        spec.structure.elements.iter().enumerate().map(place).collect()
    }

    fn new(spec: &ElementSpec, mechanism: &Mechanism) -> Result<Self, Error> {
        let moves = spec.moves.iter().map(|name| Displaced::find(name, mechanism));
        let scales = spec.scales.iter().map(|name| Displaced::scaled(name, mechanism));
        let thrust = spec.thruster.map(|thruster| Ok(Displaced::Thrust(thruster)));
        let moves: Vec<Displaced> = moves.chain(scales).chain(thrust).collect::<Result<_, _>>()?;
        let Some(&first) = moves.first() else {
            return Err(Error::invalid("moves", "[]", "at least one joint or link length"));
        };
        if !moves.iter().all(|m| m.alike(first, mechanism)) {
            let allowed =
                "either joints that all turn or all slide, or springs of such, or one kind of link length";
            return Err(Error::invalid("moves", format!("{:?}", spec.moves), allowed));
        }
        let limits = limits(spec, first, mechanism)?;
        Ok(Self { name: spec.name.clone(), moves, units: first.units(mechanism), limits })
    }
}

/// Stroke limits: a joint's as given, a length's from the ranges of the linkage.
fn limits(spec: &ElementSpec, first: Displaced, mechanism: &Mechanism) -> Result<Option<[f64; 2]>, Error> {
    if let (Displaced::Length(_, i), Some(linkage)) = (first, &mechanism.linkage) {
        let given = [("low", spec.low), ("high", spec.high)].into_iter().find_map(|(k, v)| Some((k, v?)));
        return match given {
            None => Ok(Some(linkage.displacement_limits()[i])),
            Some((key, given)) => {
                let allowed = "no limits here: a link length has its range in gait.linkage.dimensions";
                Err(Error::invalid(key, given, allowed))
            }
        };
    }
    match (spec.low, spec.high) {
        (None, None) => Ok(None),
        (low, high) => super::regulators::range(low, high).map(Some),
    }
}

/// What the elements move, kind by kind, each behind the number of its element.
#[derive(Clone, Debug, Default)]
pub(super) struct ElementMoves {
    /// Driven joints.
    pub joints: Vec<(usize, usize)>,
    /// Joints whose series are scaled.
    pub scaled: Vec<(usize, usize)>,
    /// The crank.
    pub crank: Vec<usize>,
    /// Lengths of the linkage of a wing.
    pub lengths: Vec<(usize, [usize; 2])>,
}

impl ElementMoves {
    /// By the elements.
    pub fn by(elements: &[Placed]) -> Self {
        let mut moved = Self::default();
        for (i, element) in elements.iter().enumerate() {
            for moves in &element.moves {
                match *moves {
                    Displaced::Joint(joint) => moved.joints.push((i, joint)),
                    Displaced::Scale(joint) => moved.scaled.push((i, joint)),
                    Displaced::Crank if !moved.crank.contains(&i) => moved.crank.push(i),
                    Displaced::Length(wing, length) => moved.lengths.push((i, [wing, length])),
                    Displaced::Crank | Displaced::Rest(_) | Displaced::Thrust(_) => {}
                }
            }
        }
        moved
    }
}

impl<P: Scalar> Robot<P> {
    /// Joint coordinates with rates and accelerations on the time `clock`, of a gait that may run up
    /// or stand still; the second rates of elastic joints, of elements with an inertia and of the crank under a motor,
    /// which the dynamics decide, are zero. `structure` holds the states of the elements, then those of elastic
    /// joints and crank; `dx` receives the rates of the elements' states, `joints` the coordinates,
    /// `ratios` those of crank and elements which the dynamics decide.
    #[inline(never)]
    pub(super) fn joints<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        clock: &Jet<G>,
        structure: &[G],
        u: &[G],
        dx: &mut [S],
        joints: &mut Joints<G>,
        ratios: &mut Ratios<G>,
    ) -> Result<(), Fault> {
        let mut displacements = [Jet::ZERO; MAX_ELEMENTS];
        self.response.displacements(structure, u, &mut displacements);
        self.response.rates(&displacements, dx);
        self.press(&mut displacements, ratios);
        let phase = self.phase_of(clock, structure, &displacements);
        self.driven(phase, &displacements, joints)?;
        if self.motor.is_some() {
            self.ratios(phase.x, &displacements, &mut ratios.crank)?;
        }
        self.loaded_ratios(phase.x, &displacements, ratios)?;
        self.load_by_pins(&phase, &displacements, ratios)?;
        self.decided(structure, joints);
        Ok(())
    }

    /// Joint coordinates with the elements and elastic joints of `structure` standing still.
    pub(super) fn rest<G: Scalar + Meets<P>>(
        &self,
        clock: &Jet<G>,
        structure: &[G],
        joints: &mut Joints<G>,
    ) -> Result<(), Fault> {
        let mut displacements = [Jet::ZERO; MAX_ELEMENTS];
        for (displacement, y) in displacements.iter_mut().zip(&structure[..self.elements.len()]) {
            displacement.x = *y;
        }
        self.driven(self.phase_of(clock, structure, &displacements), &displacements, joints)?;
        self.decided(structure, joints);
        Ok(())
    }

    /// Coordinates and rates of elastic joints, and of those whose motion is given with their accelerations.
    #[inline(always)]
    fn decided<G: Scalar + Meets<P>>(&self, structure: &[G], joints: &mut Joints<G>) {
        let states = &structure[2 * self.elements.len()..];
        let count = self.degrees();
        for (i, &joint) in self.mechanism.coordinates.iter().enumerate() {
            joints[joint] = Jet::new(states[i], states[count + i], G::ZERO);
        }
        let given = self.mechanism.given.len();
        for (i, &joint) in self.mechanism.given.iter().enumerate() {
            let [x, d, dd] = [0, 1, 2].map(|of| states[2 * count + of * given + i]);
            joints[joint] = Jet::new(x, d, dd);
        }
    }

    /// Shows the poses of the linkages of left (0) and right wing (1), where there is one, their lengths displaced.
    #[inline(always)]
    pub(super) fn poses<G: Scalar + Meets<P>>(
        &self,
        phase: Jet<G>,
        displacements: &[Jet<G>],
        mut see: impl FnMut(usize, &LinkagePose<G>),
    ) -> Result<(), Fault> {
        if let Some(linkage) = &self.mechanism.linkage {
            let mut lengths = [[Jet::ZERO; REGULATED.len()]; 2];
            for &(i, [wing, length]) in &self.moved.lengths {
                lengths[wing][length] += displacements[i];
            }
            for wing in 0..2 {
                see(wing, &linkage.pose(phase, lengths[wing])?);
            }
        }
        Ok(())
    }

    /// Joint coordinates by the gait alone, its linkages with their lengths displaced.
    #[inline(never)]
    pub(super) fn drive<G: Scalar + Meets<P>>(
        &self,
        phase: Jet<G>,
        displacements: &[Jet<G>],
        joints: &mut Joints<G>,
    ) -> Result<(), Fault> {
        let mut poses = [[Jet::ZERO; 2]; 2];
        self.poses(phase, displacements, |wing, pose| {
            poses[wing] = [pose.humerus, pose.radius - pose.humerus];
        })?;
        append_copies(joints, Jet::ZERO, self.mechanism.drives.len());
        for (joint, drive) in self.mechanism.drives.iter().enumerate() {
            let alike = self.mechanism.alike[joint];
            joints[joint] = match drive {
                JointDrive::Fixed | JointDrive::Held | JointDrive::Elastic(_) | JointDrive::Given => continue,
                JointDrive::Series(..) if alike < joint => joints[alike],
                JointDrive::Series(series, lag) => series.angle(phase.shifted(-*lag)),
                JointDrive::Linkage(wing, LinkageOutput::Shoulder) => poses[*wing][0],
                JointDrive::Linkage(wing, LinkageOutput::Elbow) => poses[*wing][1],
            };
        }
        Ok(())
    }
}

/// Flapping rate of the gait, rad/s.
pub(super) fn phase_rate(gait: &GaitSpec) -> f64 {
    std::f64::consts::TAU * gait.frequency_hz()
}
