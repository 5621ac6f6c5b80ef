//! How far the parts of a robot stay from one another.

use super::mechanism::{BODY, Mechanism, SIDES, mirrored};
use super::placement::corners;
use super::spec::{CapsuleSpec, LinkSide, RobotSpec};
use super::{Joints, Links, Robot};
use crate::body::LinkMotion;
use wingbeat_math::Error;
use wingbeat_math::{Jet, Scalar, Vec3, segment_distance};
use wingbeat_ocp::plant::{Channel, Fault};

/// Width of the smooth minimum, m: it lies below the least of n distances by at most ln n widths.
const WIDTH: f64 = 1e-3;

/// A corner of a surface on a link of one side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub link: usize,
    /// In the link's frame, m.
    pub place: Vec3,
    /// 1 on the left side, -1 on the right.
    pub side: f64,
}

/// The room that a link takes.
#[derive(Clone, Copy, Debug)]
struct Capsule {
    /// Whose it is; `None` is the body.
    of: Option<usize>,
    /// On which it rides: with a spar a piece of that.
    link: Option<usize>,
    /// In the link's frame, m.
    ends: [Vec3; 2],
    radius: f64,
}

/// Parts that should stay clear of each other.
#[derive(Clone, Debug)]
enum Apart {
    /// Both halves of a surface, of the middle plane of the body.
    Halves(Vec<Corner>),
    /// Capsules, two by two.
    Capsules(Vec<[Capsule; 2]>),
}

/// What a robot's clearances are between, each with its channel.
#[derive(Clone, Debug)]
pub(super) struct Clearances {
    pub channels: Vec<Channel>,
    parts: Vec<Apart>,
    capsules: Vec<Capsule>,
}

impl Clearances {
    /// Those of the symmetric surfaces whose halves ride on links of either side, then those the file names.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key of the robot file.
    pub fn new(spec: &RobotSpec, mechanism: &Mechanism) -> Result<Self, Error> {
        let capsules = Capsule::all(spec, mechanism);
        let mut found = Self { channels: Vec::new(), parts: Vec::new(), capsules: Vec::new() };
        for surface in spec.all_surfaces() {
            let corners = corners(&surface, mechanism)?;
            if !corners.is_empty() {
                found.add(format!("{}_middle", surface.name), Apart::Halves(corners));
            }
        }
        for (i, pair) in spec.clearances.iter().enumerate() {
            let [one, other] = &pair.between;
            let name = format!("{one}_{other}");
            let key = format!("clearances[{i}].between");
            let pairs = pairs(&key, [one, other], &capsules, mechanism)?;
            if !found.add(name, Apart::Capsules(pairs)) {
                return Err(Error::invalid(
                    key,
                    format!("{:?}", pair.between),
                    "parts not yet named together",
                ));
            }
        }
        Ok(Self { capsules, ..found })
    }

    /// The axes of all capsules, from the body origin, m in B, with their radii, m.
    pub fn capsules<S: Scalar>(&self, links: &[LinkMotion<S>]) -> impl Iterator<Item = ([Vec3<S>; 2], f64)> {
        self.capsules.iter().map(|capsule| (capsule.segment(links), capsule.radius))
    }

    /// False when the name is taken.
    fn add(&mut self, name: String, parts: Apart) -> bool {
        let channel = Channel::free(format!("clearance_{name}"), "m", "B");
        let fresh = self.channels.iter().all(|c| c.name != channel.name);
        self.channels.push(channel);
        self.parts.push(parts);
        fresh
    }

    /// The least distance of each, m.
    pub fn least(&self, links: &[LinkMotion]) -> impl Iterator<Item = f64> {
        self.parts.iter().map(|parts| {
            let mut least = f64::INFINITY;
            parts.distances(links, |d| least = least.min(d));
            least
        })
    }
}

impl Capsule {
    fn new(spec: &CapsuleSpec, [of, link]: [Option<usize>; 2], mirror: f64) -> Self {
        let ends = [spec.from_m, spec.to_m].map(|end| mirrored(end, mirror));
        Self { of, link, ends, radius: spec.radius_m }
    }

    /// Of body and links.
    fn all(spec: &RobotSpec, mechanism: &Mechanism) -> Vec<Self> {
        let wing = spec.wing.iter().flat_map(|w| [("shoulder", &w.proximal), ("twist", &w.distal)]);
        let wing =
            wing.filter_map(|(name, link)| Some((name, LinkSide::Mirrored, name.to_owned(), link.capsule?)));
        let links = spec.links.iter().flat_map(|link| {
            let parts = RobotSpec::capsule_parts(link).into_iter();
            parts.map(|(piece, capsule)| (link.name.as_str(), link.side, piece, capsule))
        });
        let body = spec.body.capsule.iter();
        let mut found: Vec<Self> = body.map(|c| Self::new(c, [None; 2], 1.0)).collect();
        let tree = &mechanism.tree;
        for (name, side, piece, capsule) in wing.chain(links) {
            match side {
                LinkSide::Single => {
                    found.push(Self::new(&capsule, [name, &piece].map(|of| tree.find(of)), 1.0))
                }
                LinkSide::Mirrored => {
                    for (end, mirror) in SIDES.into_iter().zip([1.0, -1.0]) {
                        let links = [name, &piece].map(|of| tree.find(&format!("{of}{end}")));
                        found.push(Self::new(&capsule, links, mirror));
                    }
                }
            }
        }
        found
    }

    /// Its segment from the body origin, in B.
    fn segment<S: Scalar>(&self, links: &[LinkMotion<S>]) -> [Vec3<S>; 2] {
        self.ends.map(|end| self.link.map_or(Vec3::constant(end), |link| links[link].point(end)))
    }
}

/// The capsules of both parts, two by two; a mirrored pair with itself is left with right.
fn pairs(
    key: &str,
    between: [&str; 2],
    capsules: &[Capsule],
    mechanism: &Mechanism,
) -> Result<Vec<[Capsule; 2]>, Error> {
    let of = |name: &str| -> Result<Vec<Capsule>, Error> {
        let mut links = vec![mechanism.link_on(key, name, 0)?, mechanism.link_on(key, name, 1)?];
        links.dedup();
        let mut all = Vec::new();
        for link in links {
            let before = all.len();
            all.extend(capsules.iter().filter(|c| c.of == link));
            if all.len() == before {
                let allowed = format!("{BODY} or links with a capsule");
                return Err(Error::invalid(key, format!("{name:?}"), allowed));
            }
        }
        Ok(all)
    };
    let (ones, others) = (of(between[0])?, of(between[1])?);
    let mut pairs: Vec<[Capsule; 2]> = Vec::new();
    for one in &ones {
        for other in &others {
            let known = |p: &[Capsule; 2]| p[0].link == other.link && p[1].link == one.link;
            if one.of != other.of && !pairs.iter().any(known) {
                pairs.push([*one, *other]);
            }
        }
    }
    if pairs.is_empty() {
        return Err(Error::invalid(key, format!("{between:?}"), "two parts"));
    }
    Ok(pairs)
}

impl Apart {
    /// Hands every distance to `each`, m: of a corner to the middle plane, positive on its own side; between
    /// two capsules that of their segments less the radii.
    ///
    /// Equation: robot.clearance
    /// `y of a left corner, -y of a right one in B; distance of segments less both radii`
    /// Source: definition.
    /// Test: `corners_lie_where_the_joints_put_them`.
    fn distances<S: Scalar>(&self, links: &[LinkMotion<S>], mut each: impl FnMut(S)) {
        match self {
            Self::Halves(corners) => {
                corners.iter().for_each(|c| each(links[c.link].point(c.place)[1] * c.side));
            }
            Self::Capsules(pairs) => {
                for [one, other] in pairs {
                    let apart = segment_distance(one.segment(links), other.segment(links));
                    each(apart - (one.radius + other.radius));
                }
            }
        }
    }
}

/// Smooth minimum -w ln sum exp(-d/w) of distances as they come.
struct SmoothMinimum<S> {
    /// The least so far, and the sum of exp((least - d)/w).
    least: S,
    sum: S,
}

impl<S: Scalar> SmoothMinimum<S> {
    fn new() -> Self {
        Self { least: S::from(f64::INFINITY), sum: S::ZERO }
    }

    fn add(&mut self, d: S) {
        if self.sum.value() == 0.0 {
            (self.least, self.sum) = (d, S::ONE);
        } else if d < self.least {
            self.sum = self.sum * ((d - self.least) * (1.0 / WIDTH)).exp() + 1.0;
            self.least = d;
        } else {
            self.sum += ((self.least - d) * (1.0 / WIDTH)).exp();
        }
    }

    /// Equation: robot.smooth_clearance
    /// `-w ln sum exp(-d/w), w = 1 mm: at most w ln n below the least of n distances`
    /// Source: log-sum-exp, Boyd & Vandenberghe 2004, section 3.1.5; width a choice.
    /// Test: `corners_lie_where_the_joints_put_them`.
    fn value(&self) -> S {
        self.least - self.sum.ln() * WIDTH
    }
}

impl Robot {
    /// Smooth clearances at `t` s, m, in the order of
    /// [`Plant::clearances`](wingbeat_ocp::plant::Plant::clearances), into `values`: at most
    /// 1 mm times ln n below the least of the n distances of a pair, never above it. `structure` holds the states of
    /// the structure elements, then those of elastic joints. Allocates nothing.
    ///
    /// # Errors
    /// The [`Fault`] that makes the gait unusable there.
    pub fn smooth_clearances<S: Scalar>(&self, t: S, structure: &[S], values: &mut [S]) -> Result<(), Fault> {
        let links = self.posed(t, structure)?;
        for (value, parts) in values.iter_mut().zip(&self.clearances.parts) {
            let mut minimum = SmoothMinimum::new();
            parts.distances(&links, |d| minimum.add(d));
            *value = minimum.value();
        }
        Ok(())
    }

    /// The clearances themselves at `t` s, m; `structure` as for [`smooth_clearances`](Self::smooth_clearances).
    ///
    /// # Errors
    /// The [`Fault`] that makes the gait unusable there.
    pub fn least_clearances(&self, t: f64, structure: &[f64]) -> Result<Vec<f64>, Fault> {
        Ok(self.clearances.least(&self.posed(t, structure)?).collect())
    }

    /// Places of the links, at rest.
    pub(super) fn posed<S: Scalar>(&self, t: S, structure: &[S]) -> Result<Links<S>, Fault> {
        let (mut joints, mut links) = (Joints::new(), Links::new());
        self.rest(&Jet::new(t, S::ZERO, S::ZERO), structure, &mut joints)?;
        self.links(&joints, Vec3::ZERO, Vec3::ZERO, &mut links);
        Ok(links)
    }
}
