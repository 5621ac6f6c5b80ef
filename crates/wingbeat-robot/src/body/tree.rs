//! The constant model: a floating base with links in a tree of revolute and prismatic joints.

use super::MAX_LINKS;
use super::dynamics::BaseAcceleration;
use super::inertia::{BodyNumbers, LinkInertia, PLACE};
use super::joint::RotationAxis;
use super::motion::LinkMotion;
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::{DeclaredQuantity, Mat3, Parameters, Scalar, Vec3, Walk, axial, polar};

/// The floating base body.
#[derive(Clone, Debug, PartialEq)]
pub struct Base {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass from the body origin, in B, m.
    pub com: Vec3,
    /// Inertia about the centre of mass, in B, kg m2.
    pub inertia: Mat3,
}

/// How a link moves against its parent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// Turns about the axis; the coordinate is an angle, rad.
    #[default]
    Revolute,
    /// Slides along the axis; the coordinate is a length, m.
    Prismatic,
}

impl JointKind {
    /// Units of the coordinate, its rate and the effort along it.
    pub fn units(self) -> [&'static str; 3] {
        match self {
            Self::Revolute => ["rad", "rad/s", "N m"],
            Self::Prismatic => ["m", "m/s", "N"],
        }
    }
}

/// A rigid link jointed to its parent. Mass and inertia may be zero: two joints
/// in a row are two links, the first without mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name, unique within the tree.
    pub name: String,
    /// Index of the parent link, smaller than the own; None for the base.
    pub parent: Option<usize>,
    /// Joint origin in the parent's frame, m.
    pub origin: Vec3,
    /// Rotation that turns link coordinates into the parent's at joint coordinate zero.
    pub orientation: Mat3,
    /// Whether it turns about or slides along the axis.
    pub kind: JointKind,
    /// Unit vector of the joint axis, in link axes.
    pub axis: Vec3,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass from the joint origin, in link axes, m.
    pub com: Vec3,
    /// Inertia about the centre of mass, in link axes, kg m2.
    pub inertia: Mat3,
}

/// One link prepared for evaluation.
#[derive(Clone, Debug)]
pub(super) struct LinkNode<P: Scalar = f64> {
    pub(super) parent: Option<usize>,
    pub(super) origin: Vec3<P>,
    /// None when it is the identity.
    pub(super) orientation: Option<Mat3<P>>,
    /// The orientation without the turn that the numbers add, and that turn.
    mount: Option<Mat3>,
    turn: Vec3<P>,
    pub(super) kind: JointKind,
    pub(super) axis: RotationAxis,
    /// None when massless.
    pub(super) inertia: Option<LinkInertia<P>>,
    /// The links that the joint carries, the own among them, as bits.
    pub(super) carried: u64,
}

/// Place of a joint on its parent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointNumbers<P: Scalar = f64> {
    /// Joint origin in the parent's frame, m.
    pub origin: Vec3<P>,
    /// Turn of the link's frame beyond its orientation, about the parent's axes: roll, pitch and yaw, rad.
    pub turn: Vec3<P>,
}

impl<P: Scalar> Parameters<P> for JointNumbers<P> {
    type In<Q: Scalar> = JointNumbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> JointNumbers<Q> {
        JointNumbers {
            origin: at.vector("origin_m", &polar(PLACE), self.origin),
            turn: at.vector("turn_rad", &axial(TURN), self.turn),
        }
    }
}

/// A turn beside how things are drawn.
const TURN: DeclaredQuantity = DeclaredQuantity { given: [-0.5, 0.5], ..DeclaredQuantity::free("rad") };

/// A floating base and its links. Constant; every evaluation brings its own
/// scratch and allocates nothing. Masses, inertias and places of joints are of type `P`, so that they may carry derivatives.
#[derive(Clone, Debug)]
pub struct Tree<P: Scalar = f64> {
    pub(super) base: LinkInertia<P>,
    pub(super) nodes: Vec<LinkNode<P>>,
    names: Vec<String>,
}

impl Tree {
    /// Checks and stores the bodies.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there are more than [`MAX_LINKS`] links, a parent does not
    /// come before its child, an axis or orientation is not a unit vector or rotation,
    /// a name appears twice, or a mass or inertia is impossible.
    pub fn new(base: &Base, links: &[Link]) -> Result<Self, Error> {
        if links.len() > MAX_LINKS {
            return Err(Error::invalid("links", links.len(), format!("at most {MAX_LINKS}")));
        }
        if !(base.mass > 0.0) {
            return Err(Error::invalid("base.mass_kg", base.mass, "more than zero"));
        }
        let stored = LinkInertia::new(base.mass, base.com, base.inertia).map_err(|e| e.within("base"))?;
        let mut nodes: Vec<LinkNode> = Vec::with_capacity(links.len());
        for (i, link) in links.iter().enumerate() {
            if links[..i].iter().any(|other| other.name == link.name) {
                return Err(Error::invalid("links.name", &link.name, "a name of its own"));
            }
            let key = format!("links.{}", link.name);
            nodes.push(LinkNode::new(i, link).map_err(|e| e.within(&key))?);
        }
        for i in (0..nodes.len()).rev() {
            nodes[i].carried |= 1 << i;
            if let Some(p) = nodes[i].parent {
                nodes[p].carried |= nodes[i].carried;
            }
        }
        Ok(Self { base: stored, nodes, names: links.iter().map(|l| l.name.clone()).collect() })
    }
}

impl<P: Scalar> Tree<P> {
    /// Numbers of the base, then of the links; of a link without mass they are zero.
    pub fn numbers(&self) -> Vec<BodyNumbers<P>> {
        let link = |node: &LinkNode<P>| {
            node.inertia.as_ref().map_or_else(BodyNumbers::default, LinkInertia::numbers)
        };
        std::iter::once(self.base.numbers()).chain(self.nodes.iter().map(link)).collect()
    }

    /// Places of the joints.
    pub fn places(&self) -> Vec<JointNumbers<P>> {
        self.nodes.iter().map(|node| JointNumbers { origin: node.origin, turn: node.turn }).collect()
    }

    /// The same tree with the numbers of base and links in the order of [`numbers`](Self::numbers), and with the
    /// `places` of its joints; what has no mass keeps none.
    ///
    /// # Panics
    /// When there are not as many.
    pub fn with<Q: Scalar>(&self, numbers: &[BodyNumbers<Q>], places: &[JointNumbers<Q>]) -> Tree<Q> {
        assert_eq!(numbers.len(), 1 + self.nodes.len(), "numbers of the base and of every link");
        assert_eq!(places.len(), self.nodes.len(), "a place for every joint");
        let node = |((node, numbers), place): ((&LinkNode<P>, &BodyNumbers<Q>), &JointNumbers<Q>)| LinkNode {
            parent: node.parent,
            origin: place.origin,
            orientation: turned(place.turn, node.mount),
            mount: node.mount,
            turn: place.turn,
            kind: node.kind,
            axis: node.axis,
            inertia: node.inertia.as_ref().map(|inertia| inertia.with(numbers)),
            carried: node.carried,
        };
        Tree {
            base: self.base.with(&numbers[0]),
            nodes: self.nodes.iter().zip(&numbers[1..]).zip(places).map(node).collect(),
            names: self.names.clone(),
        }
    }

    /// Number of links, the base not counted.
    pub fn links(&self) -> usize {
        self.nodes.len()
    }

    /// Name of a link.
    pub fn name(&self, link: usize) -> &str {
        &self.names[link]
    }

    /// Index of the link of this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }

    /// Whether the joint of a link turns or slides.
    pub fn kind(&self, link: usize) -> JointKind {
        self.nodes[link].kind
    }

    /// Whether the joint of a link turns it about the y axis of its own frame, which lies along the span.
    pub fn turns_about_y(&self, link: usize) -> bool {
        let node = &self.nodes[link];
        node.kind == JointKind::Revolute && matches!(node.axis, RotationAxis::Coordinate { index: 1, .. })
    }

    /// Axis of the joint of a link that moves as `motion`, a unit vector in B.
    pub fn axis(&self, link: usize, motion: &LinkMotion) -> Vec3 {
        self.nodes[link].axis.direction(&motion.rotation)
    }

    /// Parent of a link; None for the base.
    pub fn parent(&self, link: usize) -> Option<usize> {
        self.nodes[link].parent
    }
}

impl<P: Scalar> LinkNode<P> {
    /// The field of motion about the body origin that a unit rate of the joint gives the links it
    /// carries, in B.
    #[inline]
    pub(super) fn field<S: Scalar>(&self, motion: &LinkMotion<S>) -> BaseAcceleration<S> {
        let axis = self.axis.direction(&motion.rotation);
        match self.kind {
            JointKind::Revolute => BaseAcceleration { origin: motion.position.cross(axis), angular: axis },
            JointKind::Prismatic => BaseAcceleration { origin: axis, angular: Vec3::ZERO },
        }
    }
}

impl LinkNode {
    fn new(index: usize, link: &Link) -> Result<Self, Error> {
        if let Some(p) = link.parent.filter(|&p| p >= index) {
            return Err(Error::invalid(
                "parent",
                p,
                format!("a link before this one (0 to {index}, exclusive)"),
            ));
        }
        if !link.origin.is_finite() {
            return Err(Error::invalid("origin_m", format!("{:?}", link.origin.0), "finite numbers"));
        }
        if !((link.axis.norm() - 1.0).abs() < 1e-9) {
            return Err(Error::invalid("axis", format!("{:?}", link.axis.0), "a unit vector"));
        }
        if !is_rotation(link.orientation) {
            return Err(Error::invalid(
                "orientation",
                format!("{:?}", link.orientation.0),
                "a rotation matrix",
            ));
        }
        let inertia = LinkInertia::new(link.mass, link.com, link.inertia)?;
        let mount = (link.orientation != Mat3::IDENTITY).then_some(link.orientation);
        Ok(Self {
            parent: link.parent,
            origin: link.origin,
            orientation: turned(Vec3::ZERO, mount),
            mount,
            turn: Vec3::ZERO,
            kind: link.kind,
            axis: RotationAxis::new(link.axis),
            inertia: (!inertia.is_massless()).then_some(inertia),
            carried: 0,
        })
    }
}

/// Orientation of a link: its `mount` on the parent and a further turn.
fn turned<P: Scalar>(turn: Vec3<P>, mount: Option<Mat3>) -> Option<Mat3<P>> {
    let mounted = mount.map(|mount| mount.each(P::from));
    if turn.is_zero() {
        return mounted;
    }
    let Vec3([roll, pitch, yaw]) = turn;
    let turn = Mat3::from_roll_pitch_yaw(roll, pitch, yaw);
    Some(mounted.map_or(turn, |mounted| turn * mounted))
}

/// True when R'R = 1 and det R = 1 within rounding.
fn is_rotation(r: Mat3) -> bool {
    let defect = r.transpose() * r - Mat3::IDENTITY;
    let det = r.column(0).cross(r.column(1)).dot(r.column(2));
    defect.0.iter().flatten().all(|d| d.abs() < 1e-9) && det > 0.0
}
