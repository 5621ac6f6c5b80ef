//! A perch beside the robot, the claw that meets it, and the force between them.

use super::Robot;
use crate::body::LinkMotion;
use wingbeat_math::{Mat3, Quat, Scalar, Vec3, Wrench, segment_distance, triangle_distance};
use wingbeat_ocp::plant::Fault;

/// Speed of sliding below which friction is rounded off, m/s. *Choice.*
const SLIDING: f64 = 0.01;
/// Steps to the frequency of a contact; each halves its error at least.
const TURNS: usize = 60;

/// What there is to hold on to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PerchShape {
    /// A round bar about a straight axis.
    Bar {
        /// Unit vector along it, in W.
        axis: Vec3,
        /// Half its length, m.
        half_length: f64,
        /// Its radius, m.
        radius: f64,
    },
    /// A ceiling, endless for what hits it; the claw holds in a disc about the place.
    Ceiling {
        /// Radius of the disc, m.
        radius: f64,
    },
}

/// How claw and perch bounce off each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Speed after a central hit over that before.
    pub restitution: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Duration of a central hit, s.
    pub duration: f64,
}

/// A perch at rest in W and the claw, a point that is fixed in the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perch {
    place: Vec3,
    shape: PerchShape,
    claw: Vec3,
    friction: f64,
    stiffness: f64,
    damping: f64,
}

/// Where the claw is against the perch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// From the claw to where it could hold, m; 0 where they touch.
    pub distance: f64,
    /// Of the claw, m/s.
    pub speed: f64,
    /// Between the back of the robot, +z of B, and straight down, rad.
    pub off_hanging: f64,
    /// Force between claw and perch, N.
    pub force: f64,
}

/// The body's motion in numbers of type `S`.
#[derive(Clone, Copy)]
pub(super) struct BodyPose<S: Scalar> {
    pub position: Vec3<S>,
    pub attitude: Mat3<S>,
    pub velocity: Vec3<S>,
    /// In B.
    pub rate: Vec3<S>,
}

impl Perch {
    /// A perch at `place` in W for a robot of `mass` (kg) with its claw at `claw` in B.
    ///
    /// Equation: robot.perch_contact
    /// `F = k d + c d' where above 0, k = m (s^2 + b^2), c = 2 m b, s T = pi - atan2(2 b s, s^2 - b^2), e = exp(-b T); friction mu F`
    /// Source: Cundall & Strack 1979, Geotechnique 29: spring and dashpot; Schwager & Poeschel 2007, Granular Matter 9: end of the contact.
    /// Test: `a_claw_bounces_off_by_its_restitution`.
    ///
    /// A central hit of the mass m ends after T, where the force would begin to pull, and leaves the share e of its speed.
    pub fn new(place: Vec3, shape: PerchShape, claw: Vec3, contact: Contact, mass: f64) -> Self {
        let Contact { restitution, friction, duration } = contact;
        // The decay follows from T and e, the frequency by steps to a fixed point.
        let decay = -restitution.ln() / duration;
        let mut turning = std::f64::consts::PI / duration;
        for _ in 0..TURNS {
            let angle = (2.0 * decay * turning).atan2(turning * turning - decay * decay);
            turning = 0.5 * (turning + (std::f64::consts::PI - angle) / duration);
        }
        Self {
            place,
            shape,
            claw,
            friction,
            stiffness: mass * (turning * turning + decay * decay),
            damping: 2.0 * mass * decay,
        }
    }

    /// The same at another place in W, m.
    #[must_use]
    pub fn at(&self, place: Vec3) -> Self {
        Self { place, ..*self }
    }

    /// Its place in W, m.
    pub fn place(&self) -> Vec3 {
        self.place
    }

    /// Ends of the line that stands for it in pictures, m in W: the axis of a bar, a span of a ceiling's disc.
    pub fn ends(&self) -> [Vec3; 2] {
        let half = match self.shape {
            PerchShape::Bar { axis, half_length, .. } => axis * half_length,
            PerchShape::Ceiling { radius } => Vec3::new(0.0, radius, 0.0),
        };
        [self.place - half, self.place + half]
    }

    /// The claw in B, m.
    pub fn claw(&self) -> Vec3 {
        self.claw
    }

    /// How far the claw at `at` in W is in front of the surface, and the normal there, towards the claw.
    fn gap<S: Scalar>(&self, at: Vec3<S>) -> (S, Vec3<S>) {
        let off = at - Vec3::constant(self.place);
        match self.shape {
            PerchShape::Bar { axis, half_length, radius } => {
                let axis: Vec3<S> = Vec3::constant(axis);
                let along = off.dot(axis);
                let [low, high] = [-half_length, half_length].map(S::from);
                let along = along.if_below(low, low, S::ZERO.if_below(along - high, high, along));
                let away = off - axis * along;
                // A claw in the very axis has no direction out of it.
                let size = away.norm_squared().smooth_abs(1e-18).sqrt();
                (size - radius, away * size.recip())
            }
            PerchShape::Ceiling { .. } => (-off[2], Vec3::new(S::ZERO, S::ZERO, S::from(-1.0))),
        }
    }

    /// Place and velocity of the claw in W.
    fn claw_of<S: Scalar>(&self, pose: &BodyPose<S>) -> [Vec3<S>; 2] {
        let arm: Vec3<S> = Vec3::constant(self.claw);
        [pose.position + pose.attitude * arm, pose.velocity + pose.attitude * pose.rate.cross(arm)]
    }

    /// Force on the claw in W, N.
    fn force<S: Scalar>(&self, pose: &BodyPose<S>) -> Vec3<S> {
        let [at, velocity] = self.claw_of(pose);
        let (gap, normal) = self.gap(at);
        let closing = -velocity.dot(normal);
        let push = closing * self.damping - gap * self.stiffness;
        // In front of the surface there is no force, and none that pulls.
        let push = gap.if_below(S::ZERO, push.if_below(S::ZERO, S::ZERO, push), S::ZERO);
        let sliding = velocity + normal * closing;
        let rounded = (sliding.norm_squared() + SLIDING * SLIDING).sqrt();
        normal * push - sliding * (push * self.friction * rounded.recip())
    }

    /// The load on the body about its origin, in B.
    pub(super) fn load<S: Scalar>(&self, pose: &BodyPose<S>) -> Wrench<S> {
        let force = pose.attitude.transpose_mul(self.force(pose));
        let arm: Vec3<S> = Vec3::constant(self.claw);
        Wrench { force, moment: arm.cross(force) }
    }

    /// How far a flat triangle in W is from its surface, m; minus the radius where a bar pierces it, negative beyond a ceiling.
    fn triangle_distance<S: Scalar>(&self, triangle: [Vec3<S>; 3]) -> S {
        match self.shape {
            PerchShape::Bar { radius, .. } => triangle_distance(self.axis(), triangle) - radius,
            PerchShape::Ceiling { .. } => self.below(&triangle),
        }
    }

    /// The same of a capsule, by its axis in W and its radius.
    fn capsule_distance<S: Scalar>(&self, axis: [Vec3<S>; 2], round: f64) -> S {
        match self.shape {
            PerchShape::Bar { radius, .. } => segment_distance(self.axis(), axis) - (radius + round),
            PerchShape::Ceiling { .. } => self.below(&axis) - round,
        }
    }

    /// Its [`ends`](Self::ends).
    fn axis<S: Scalar>(&self) -> [Vec3<S>; 2] {
        self.ends().map(Vec3::constant)
    }

    /// How far the highest of `points` is below the place.
    fn below<S: Scalar>(&self, points: &[Vec3<S>]) -> S {
        let below = points.iter().map(|p| -p[2] + self.place[2]);
        below.fold(S::from(f64::INFINITY), less)
    }

    fn seen(&self, pose: &BodyPose<f64>) -> Seen {
        let [at, velocity] = self.claw_of(pose);
        let (gap, _) = self.gap(at);
        let distance = match self.shape {
            PerchShape::Bar { .. } => gap.max(0.0),
            PerchShape::Ceiling { radius } => {
                let off = at - self.place;
                (off[0].hypot(off[1]) - radius).max(0.0).hypot(gap.max(0.0))
            }
        };
        let back = pose.attitude * Vec3::new(0.0, 0.0, 1.0);
        Seen {
            distance,
            speed: velocity.norm(),
            off_hanging: (-back[2]).clamp(-1.0, 1.0).acos(),
            force: self.force(pose).norm(),
        }
    }
}

/// The lesser of two numbers.
fn less<S: Scalar>(one: S, other: S) -> S {
    if other < one { other } else { one }
}

impl Robot {
    /// The same robot beside `perch`.
    #[must_use]
    pub fn beside(mut self, perch: Perch) -> Self {
        self.perch = Some(perch);
        self
    }

    /// The perch beside it.
    pub fn perch(&self) -> Option<&Perch> {
        self.perch.as_ref()
    }

    /// Least distance of its surfaces, as drawn, and its capsules from the perch at the time `t` (s) in the state `x`, m, of a
    /// robot that has neither that of the body's origin; none without a perch.
    ///
    /// # Errors
    /// The [`Fault`] that makes the gait unusable there.
    pub fn perch_clearance(&self, t: f64, x: &[f64]) -> Result<Option<f64>, Fault> {
        self.perch.as_ref().map(|perch| self.clearance_from(perch, t, x)).transpose()
    }

    /// Least distance from `perch`, m, whether the robot is beside it or not; only states up to those of the air are read. Derivatives are exact where the
    /// nearest points are unique, and zero where a bar pierces a surface.
    ///
    /// Equation: robot.perch_clearance
    /// `least over flat pieces of the surfaces and capsules of the distance from the bar's axis less the radii, or of the height below the
    /// ceiling`
    /// Source: definition.
    /// Test: `wings_keep_clear_of_the_perch_or_are_told`.
    ///
    /// # Errors
    /// The [`Fault`] that makes the gait unusable there.
    pub fn clearance_from<S: Scalar>(&self, perch: &Perch, t: S, x: &[S]) -> Result<S, Fault> {
        let links = self.posed(t, &x[self.layout.structure..])?;
        let (position, attitude) = (
            Vec3::from_slice(&x[self.layout.position..]),
            Quat::from_wxyz(&x[self.layout.attitude..]).matrix(),
        );
        let place = |p: Vec3<S>| position + attitude * p;
        let still = LinkMotion::REST;
        // Derivatives are those of the nearest piece alone.
        let mut nearest: Option<(f64, [Vec3<S>; 3])> = None;
        for laid in &self.covering.laid {
            let edges = |k: usize| {
                let rib = &laid.ribs[k];
                rib.edges(rib.link.map_or(&still, |link| &links[link])).map(place)
            };
            for k in (0..laid.covered.len()).filter(|k| laid.covered[*k]) {
                let ([le, te], [next_le, next_te]) = (edges(k), edges(k + 1));
                for triangle in [[le, te, next_te], [le, next_te, next_le]] {
                    let away = perch.triangle_distance(triangle.map(|p| Vec3(p.0.map(S::value))));
                    if nearest.is_none_or(|(least, _)| away < least) {
                        nearest = Some((away, triangle));
                    }
                }
            }
        }
        let surfaces = nearest.map(|(_, triangle)| perch.triangle_distance(triangle));
        let capsules = self.clearances.capsules(&links);
        let capsules = capsules.map(|(axis, radius)| perch.capsule_distance(axis.map(place), radius));
        let least = surfaces.into_iter().chain(capsules).reduce(less);
        Ok(least.unwrap_or_else(|| perch.capsule_distance([position; 2], 0.0)))
    }

    /// Where its claw is against the perch in the state `x`; none without one.
    pub fn at_perch(&self, x: &[f64]) -> Option<Seen> {
        let l = &self.layout;
        let pose = BodyPose {
            position: Vec3::from_slice(&x[l.position..]),
            attitude: Quat::from_wxyz(&x[l.attitude..]).matrix(),
            velocity: Vec3::from_slice(&x[l.velocity..]),
            rate: Vec3::from_slice(&x[l.rate..]),
        };
        self.perch.map(|perch| perch.seen(&pose))
    }
}
