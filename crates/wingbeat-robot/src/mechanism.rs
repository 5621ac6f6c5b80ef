//! From what a robot file says of links and joints to the tree and what moves each joint.

use super::numbers::{Numbers, SpringNumbers, StopNumbers};
use super::pin_springs::PinSpring;
use super::spar::SparJoints;
use super::spec::{
    ElasticSpec, GaitSpec, JointSpec, LinkSide, LinkSpec, LinkageOutput, RobotSpec, SparShape, WingSpec,
};
use crate::body::{Base, FourierSeries, JointKind, Link, Linkage, Tree};
use wingbeat_math::Error;
use wingbeat_math::names::one_of;
use wingbeat_math::{Mat3, Meets, Quat, Scalar, Vec3};
use wingbeat_ocp::plant::MAX_COORDINATES;

/// Links, what moves their joints, and which is whose mirror image.
#[derive(Clone, Debug)]
pub(super) struct Mechanism<P: Scalar = f64> {
    pub tree: Tree<P>,
    /// What moves each joint.
    pub drives: Vec<JointDrive<P>>,
    /// For every joint the first that a series moves alike; itself where none before it is.
    pub alike: Vec<usize>,
    /// For every link its mirror image; itself on the plane of symmetry.
    pub twins: Vec<usize>,
    /// Joints whose coordinates are states, in order.
    pub coordinates: Vec<usize>,
    /// The spars of its links.
    pub spars: Vec<SparJoints>,
    /// Joints between their pieces whose motion is given.
    pub given: Vec<usize>,
    /// How its spars stand for beams.
    pub spar_shape: Option<SparShape>,
    /// The linkage that the gait turns, one on each side.
    pub linkage: Option<Box<Linkage<P>>>,
    /// Springs on its pins.
    pub pin_springs: Vec<PinSpring<P>>,
}

/// What moves a joint.
#[derive(Clone, Debug)]
pub(super) enum JointDrive<P: Scalar = f64> {
    /// Nothing: it stays at zero.
    Fixed,
    /// Held at zero by the gait; structure elements may displace it.
    Held,
    /// A series of the phase, which lags by this angle, rad.
    Series(FourierSeries<P>, P),
    /// An output of the linkage of a wing (0 left, 1 right).
    Linkage(usize, LinkageOutput),
    /// Its spring: the coordinate is a state.
    Elastic(Spring<P>),
    /// Who flies it: the coordinate, its rate and its acceleration are given.
    Given,
}

/// Spring, damper and stops of a joint; all zero for a free one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spring<P: Scalar = f64> {
    pub numbers: SpringNumbers<P>,
    /// Coordinate at the start.
    pub start: f64,
}

impl Spring {
    const FREE: Self =
        Self { numbers: SpringNumbers { stiffness: 0.0, damping: 0.0, rest: 0.0, stops: None }, start: 0.0 };

    fn new(spec: &ElasticSpec) -> Self {
        let stops = spec.stops.map(|s| StopNumbers { low: s.low, high: s.high, stiffness: s.stiffness });
        let ElasticSpec { stiffness, damping, rest, start, .. } = *spec;
        Self { numbers: SpringNumbers { stiffness, damping, rest, stops }, start: start.unwrap_or(rest) }
    }

    /// Energy stored, J, from no deflection on, the rest displaced by `moved`.
    pub fn energy(&self, q: f64, moved: f64) -> f64 {
        let SpringNumbers { stiffness, rest, .. } = self.numbers;
        let linear = 0.5 * stiffness * (q - rest - moved).powi(2);
        linear + self.numbers.stops.map_or(0.0, |stops| stops.energy(q))
    }

    /// Power that the damper takes, W.
    pub fn dissipation(&self, d: f64) -> f64 {
        self.numbers.damping * d * d
    }
}

impl<P: Scalar> Spring<P> {
    /// What spring and damper give to a rate that lasts for `time` s, over it: t (t k + c), kg m2 or kg.
    pub fn impulse(&self, time: f64) -> P {
        let SpringNumbers { stiffness, damping, .. } = self.numbers;
        (stiffness * time + damping) * time
    }

    /// Effort on the joint, N m or N, at the coordinate `q` with the rate `d`, the rest displaced by y:
    /// -k (q - rest - y) - c q' - k_s [s(q - high) - s(low - q)]. Stops bear nothing between their corners of half the width w.
    ///
    /// Equation: robot.joint_spring
    /// `effort = -k (q - rest - y) - c q' - k_s [s(q - high) - s(low - q)]; s(x) = 0 up to -w, x from w on, with the slope 3 u^2 - 2 u^3 between, u = (x + w)/(2 w)`
    /// Source: Hooke; stops a choice.
    /// Test: `elastic_joints_bear_the_efforts_of_their_springs`.
    pub fn effort<S: Scalar + Meets<P>>(&self, q: S, d: S, moved: S) -> S {
        let SpringNumbers { stiffness, damping, rest, stops } = self.numbers;
        let linear = -((q - rest - moved) * stiffness) - d * damping;
        stops.map_or(linear, |stops| linear - stops.beyond(q) * stops.stiffness)
    }
}

/// A link before it has a place in the tree.
struct Part {
    link: Link,
    drive: JointDrive,
    twin: usize,
}

impl Mechanism {
    /// # Errors
    /// [`Error::Invalid`] with the key of the robot file.
    pub fn new(spec: &RobotSpec) -> Result<Self, Error> {
        let (linkage, pin_springs) = match &spec.gait {
            GaitSpec::Linkage { dimensions, springs, .. } => {
                let built = Linkage::new(*dimensions.clone());
                let built = built.map_err(|e| e.within("gait.linkage.dimensions"))?;
                let springs = PinSpring::all(springs, &built);
                (Some(Box::new(built)), springs.map_err(|e| e.within("gait.linkage.springs"))?)
            }
            GaitSpec::Fourier { .. } => (None, Vec::new()),
        };
        let mut parts = Vec::new();
        if let Some(wing) = &spec.wing {
            add_wing(wing, &spec.gait, &mut parts)?;
        }
        let mut spars: Vec<SparJoints> = spec.links.iter().filter_map(SparJoints::of).collect();
        for (i, link) in spec.all_links() {
            let first = parts.len();
            add_link(&link, &spec.gait, &mut parts).map_err(|e| e.within(&format!("links[{i}]")))?;
            let of = |spar: &&mut SparJoints| spar.name == spec.links[i].name && spar.name != link.name;
            if let (Some(joints), Some(spar)) = (spars.iter_mut().find(of), &spec.links[i].spar) {
                joints.take(spar, &link, first..parts.len());
            }
        }
        let body = &spec.body;
        let inertia = Mat3::diagonal(Vec3(body.inertia_kg_m2));
        let base = Base { mass: body.mass_kg, com: Vec3(body.com_m), inertia };
        let links: Vec<Link> = parts.iter().map(|p| p.link.clone()).collect();
        let tree = Tree::new(&base, &links)?;
        let elastic = |p: &Part| matches!(p.drive, JointDrive::Elastic(_));
        let coordinates: Vec<usize> = (0..parts.len()).filter(|&i| elastic(&parts[i])).collect();
        if coordinates.len() > MAX_COORDINATES {
            let of_spars = if spars.is_empty() {
                ""
            } else {
                ", those of a mirrored link twice; a spar has one for each segment, with edge_bending_n_m2 and torsion_n_m2 one more each"
            };
            let allowed = format!("at most {MAX_COORDINATES} elastic or free joints{of_spars}");
            return Err(Error::invalid("links", format!("{} of them", coordinates.len()), allowed));
        }
        let twins = parts.iter().map(|p| p.twin).collect();
        let drives: Vec<JointDrive> = parts.into_iter().map(|p| p.drive).collect();
        if !pin_springs.is_empty() && !drives.iter().any(|drive| matches!(drive, JointDrive::Linkage(..))) {
            let allowed = "none where no joint is driven by the linkage";
            let given = format!("{} springs", pin_springs.len());
            return Err(Error::invalid("gait.linkage.springs", given, allowed));
        }
        Ok(Self {
            tree,
            alike: alike(&drives),
            drives,
            twins,
            coordinates,
            spars,
            given: Vec::new(),
            spar_shape: spec.spar_shape(),
            linkage,
            pin_springs,
        })
    }

    /// Index of the link called `name` on the left (0) or right (1) side: of a mirrored pair by the
    /// name of the pair. None within for the body.
    ///
    /// # Errors
    /// [`Error::Invalid`], the names there are in its text.
    pub fn link_on(&self, key: &str, name: &str, side: usize) -> Result<Option<usize>, Error> {
        if name == BODY {
            return Ok(None);
        }
        let sided = format!("{name}{}", SIDES[side]);
        let found = self.tree.find(&sided).or_else(|| self.tree.find(name));
        let names = || (0..self.tree.links()).map(|i| self.tree.name(i)).collect::<Vec<_>>().join(", ");
        match found {
            Some(link) => Ok(Some(link)),
            None => Err(Error::invalid(key, format!("{name:?}"), format!("{BODY} or a link: {}", names()))),
        }
    }
}

impl<P: Scalar> Mechanism<P> {
    /// Joints between the pieces of spars.
    pub fn pieces(&self) -> impl Iterator<Item = usize> {
        self.spars.iter().flat_map(SparJoints::joints)
    }

    /// The same mechanism, the motion of whose spars is given.
    pub fn with_spars_given(&self) -> Self {
        let mut other = self.clone();
        other.given = self.pieces().collect();
        other.coordinates.retain(|joint| !other.given.contains(joint));
        other.given.iter().for_each(|joint| other.drives[*joint] = JointDrive::Given);
        other
    }

    /// Springs of the coordinates.
    pub fn springs(&self) -> impl Iterator<Item = &Spring<P>> {
        self.drives.iter().filter_map(|d| match d {
            JointDrive::Elastic(spring) => Some(spring),
            _ => None,
        })
    }

    /// The series of the joints that have one, with their lags, rad.
    pub fn series(&self) -> impl Iterator<Item = (usize, &FourierSeries<P>, P)> {
        self.drives.iter().enumerate().filter_map(|(joint, drive)| match drive {
            JointDrive::Series(series, lag) => Some((joint, series, *lag)),
            _ => None,
        })
    }

    /// The same mechanism with other numbers.
    pub fn with<Q: Scalar>(&self, numbers: &Numbers<Q>) -> Mechanism<Q> {
        let (mut springs, mut series) = (numbers.springs.iter(), numbers.series.iter());
        let drive = |drive: &JointDrive<P>| match drive {
            JointDrive::Fixed => JointDrive::Fixed,
            JointDrive::Held => JointDrive::Held,
            JointDrive::Given => JointDrive::Given,
            JointDrive::Series(..) => {
                let (series, lag) = series.next().expect("numbers of every series");
                JointDrive::Series(series.clone(), *lag)
            }
            JointDrive::Linkage(wing, output) => JointDrive::Linkage(*wing, *output),
            JointDrive::Elastic(spring) => {
                let numbers = *springs.next().expect("numbers of every spring");
                JointDrive::Elastic(Spring { numbers, start: spring.start })
            }
        };
        let drives: Vec<JointDrive<Q>> = self.drives.iter().map(drive).collect();
        Mechanism {
            tree: self.tree.with(&numbers.bodies, &numbers.places),
            alike: alike(&drives),
            drives,
            twins: self.twins.clone(),
            coordinates: self.coordinates.clone(),
            spars: self.spars.clone(),
            given: self.given.clone(),
            spar_shape: self.spar_shape,
            linkage: (self.linkage.as_ref().zip(numbers.linkage.as_ref()))
                .map(|(linkage, dimensions)| Box::new(linkage.with(dimensions.clone()))),
            pin_springs: self
                .pin_springs
                .iter()
                .zip(&numbers.pin_springs)
                .map(|(of, n)| of.with(n))
                .collect(),
        }
    }
}

/// For every joint the first of which series and lag are the same, with all derivatives of their numbers.
fn alike<P: Scalar>(drives: &[JointDrive<P>]) -> Vec<usize> {
    let first = |i: usize| match &drives[i] {
        JointDrive::Series(series, lag) => drives[..i].iter().position(
            |before| matches!(before, JointDrive::Series(s, l) if s.is(series) && (*l - *lag).is_zero()),
        ),
        _ => None,
    };
    (0..drives.len()).map(|i| first(i).unwrap_or(i)).collect()
}

/// Name of the base among the links.
pub(super) const BODY: &str = "body";
/// What the names of a mirrored pair end in.
pub(super) const SIDES: [&str; 2] = ["_left", "_right"];

/// Mirrors a polar vector in the plane of symmetry; `mirror` is 1 or -1.
pub(super) fn mirrored(v: [f64; 3], mirror: f64) -> Vec3 {
    Vec3::new(v[0], mirror * v[1], v[2])
}

/// Four joints and two massive links per wing; the right wing mirrors the left.
fn add_wing(wing: &WingSpec, gait: &GaitSpec, parts: &mut Vec<Part>) -> Result<(), Error> {
    let driven = |side: usize, output: LinkageOutput| match gait {
        GaitSpec::Linkage { .. } => Ok(JointDrive::Linkage(side, output)),
        GaitSpec::Fourier { shoulder, elbow, .. } => {
            let series = if output == LinkageOutput::Shoulder { shoulder } else { elbow };
            series.as_ref().map_or(Ok(JointDrive::Held), |series| series_of(gait, series, 0.0, None))
        }
    };
    for (side, mirror) in [(0, 1.0), (1, -1.0)] {
        let up = Vec3::new(mirror, 0.0, 0.0);
        let sweep = (Vec3::new(0.0, 0.0, -mirror), mirrored(wing.shoulder_m, mirror));
        let elbow = Vec3::new(0.0, mirror * wing.proximal.length_m, 0.0);
        let joints = [
            ("sweep", sweep, None, JointDrive::Held),
            ("shoulder", (up, Vec3::ZERO), Some(&wing.proximal), driven(side, LinkageOutput::Shoulder)?),
            ("elbow", (up, elbow), None, driven(side, LinkageOutput::Elbow)?),
            ("twist", (Vec3::new(0.0, -1.0, 0.0), Vec3::ZERO), Some(&wing.distal), JointDrive::Held),
        ];
        for (i, (name, (axis, origin), carried, drive)) in joints.into_iter().enumerate() {
            let link = Link {
                name: format!("{name}{}", SIDES[side]),
                parent: (i > 0).then(|| parts.len() - 1),
                origin,
                orientation: Mat3::IDENTITY,
                kind: JointKind::Revolute,
                axis,
                mass: carried.map_or(0.0, |l| l.mass_kg),
                com: carried.map_or(Vec3::ZERO, |l| mirrored(l.com_m, mirror)),
                inertia: carried.map_or(Mat3::ZERO, |l| Mat3::diagonal(Vec3(l.inertia_kg_m2))),
            };
            parts.push(Part { link, drive, twin: 4 * (1 - side) + i });
        }
    }
    Ok(())
}

/// The series of a joint over a cycle of the gait: that of its stroke, or of strokes and glide.
fn series_of(
    gait: &GaitSpec,
    stroke: &FourierSeries,
    lag: f64,
    folded: Option<f64>,
) -> Result<JointDrive, Error> {
    let Some(bound) = gait.bound() else { return Ok(JointDrive::Series(stroke.clone(), lag)) };
    Ok(JointDrive::Series(bound.series(stroke, lag, folded)?, 0.0))
}

/// A link, or a pair of which the right one mirrors the left.
fn add_link(spec: &LinkSpec, gait: &GaitSpec, parts: &mut Vec<Part>) -> Result<(), Error> {
    let first = parts.len();
    match spec.side {
        LinkSide::Single => {
            let parent = parent_of(spec, parts, None)?;
            parts.push(part(spec, gait, spec.name.clone(), parent, 1.0, first)?);
        }
        LinkSide::Mirrored => {
            for (side, mirror) in [(0, 1.0), (1, -1.0)] {
                let parent = parent_of(spec, &parts[..first], Some(side))?;
                let name = format!("{}{}", spec.name, SIDES[side]);
                parts.push(part(spec, gait, name, parent, mirror, first + 1 - side)?);
            }
        }
    }
    Ok(())
}

/// The parent among the links before, on `side` where the link is one of a pair.
fn parent_of(spec: &LinkSpec, parts: &[Part], side: Option<usize>) -> Result<Option<usize>, Error> {
    if spec.parent == BODY {
        return Ok(None);
    }
    let find = |name: &str| parts.iter().position(|p| p.link.name == name);
    let sided = side.and_then(|s| find(&format!("{}{}", spec.parent, SIDES[s])));
    sided.or_else(|| find(&spec.parent)).map(Some).ok_or_else(|| {
        let mut names = vec![BODY];
        names.extend(parts.iter().map(|part| {
            let name = part.link.name.as_str();
            SIDES.iter().find_map(|end| name.strip_suffix(end)).unwrap_or(name)
        }));
        names.dedup();
        let allowed = format!("{BODY} or a link before this one, {}", one_of(&spec.parent, &names));
        Error::invalid("parent", format!("{:?}", spec.parent), allowed)
    })
}

/// A link of the left side, or its image at `mirror` -1: of an axis about which it turns the parts in the plane
/// change sign, of a direction along which it slides the one across it.
fn part(
    spec: &LinkSpec,
    gait: &GaitSpec,
    name: String,
    parent: Option<usize>,
    mirror: f64,
    twin: usize,
) -> Result<Part, Error> {
    let axis = Vec3(spec.axis);
    let axis = axis * axis.norm().recip();
    let axis = match spec.joint {
        JointKind::Revolute => Vec3::new(mirror * axis[0], axis[1], mirror * axis[2]),
        JointKind::Prismatic => mirrored(axis.0, mirror),
    };
    let [roll, pitch, yaw] = spec.orientation_deg.map(f64::to_radians);
    let turned = spec.orientation_deg != [0.0; 3];
    let orientation = Quat::from_roll_pitch_yaw(mirror * roll, pitch, mirror * yaw).matrix();
    let side = usize::from(mirror < 0.0);
    let drive = match spec.moved() {
        JointSpec::Fixed => JointDrive::Fixed,
        JointSpec::Free => JointDrive::Elastic(Spring::FREE),
        JointSpec::Elastic(elastic) => JointDrive::Elastic(Spring::new(elastic)),
        JointSpec::Driven(driven) => match driven.linkage {
            Some(output) => JointDrive::Linkage(side, output),
            None => series_of(gait, &driven.series(), driven.lag_rad, driven.folded_rad)
                .map_err(|e| e.within("driven"))?,
        },
    };
    let link = Link {
        name,
        parent,
        origin: mirrored(spec.origin_m, mirror),
        orientation: if turned { orientation } else { Mat3::IDENTITY },
        kind: spec.joint,
        axis,
        mass: spec.mass_kg,
        com: mirrored(spec.com_m, mirror),
        inertia: Mat3::diagonal(Vec3(spec.inertia_kg_m2)),
    };
    Ok(Part { link, drive, twin })
}
