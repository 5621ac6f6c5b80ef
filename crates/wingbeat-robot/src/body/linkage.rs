//! The computational structure: a planar linkage with one crank that drives
//! humerus and radius of one wing through three closed loops. The other wing is
//! its mirror image, so both use the same numbers.

mod closure;
mod dimensions;
mod pins;

pub use dimensions::LinkageDimensions;
pub use pins::LinkagePin;

use super::planar::Planar;
use closure::Loop;
use wingbeat_math::{Error, Jet, Meets, RADIANS, Scalar};
use wingbeat_ocp::plant::Fault;

/// Smallest margin 1 - |cos| of a loop's elbow, dimensionless: rates grow as 1/sqrt(margin).
pub const MARGIN_LIMIT: f64 = 0.003;

/// Names of the regulated lengths, in the order of every displacement.
pub const REGULATED: [&str; 3] = ["l3b", "l5a", "l5b"];

/// Crank positions at which a new linkage is tried.
const TRIALS: usize = 360;

/// A linkage that was seen to close through a whole turn of its crank.
#[derive(Clone, Debug, PartialEq)]
pub struct Linkage<P: Scalar = f64> {
    dimensions: LinkageDimensions<P>,
    /// Angles opposite the branch cuts of humerus and radius, so that neither
    /// angle ever jumps over the cycle, rad.
    middle: [f64; 2],
}

/// Pose of the linkage with rates and accelerations.
#[derive(Clone, Copy, Debug)]
pub struct LinkagePose<S: Scalar = f64> {
    /// Humerus angle above the horizontal, t5, rad.
    pub humerus: Jet<S>,
    /// Radius angle above the horizontal, t6, rad.
    pub radius: Jet<S>,
    /// Unit vectors e(t2), e(t3), e(t5), e(t6), e(t8), e(t9).
    pub directions: Directions<S>,
    /// 1 - |cos| of each loop's elbow, dimensionless.
    pub margins: [f64; 3],
}

/// Unit vectors of the moving bodies, numbered as their angles in the loop equations.
#[derive(Clone, Copy, Debug)]
pub struct Directions<S: Scalar = f64> {
    /// Coupler from the crank.
    pub e2: Planar<S>,
    /// Rod to the bell crank.
    pub e3: Planar<S>,
    /// Humerus.
    pub e5: Planar<S>,
    /// Radius.
    pub e6: Planar<S>,
    /// Bell crank.
    pub e8: Planar<S>,
    /// Rod to the radius.
    pub e9: Planar<S>,
}

impl Linkage {
    /// Turns the crank once at nominal lengths and stores the linkage.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a dimension is not allowed or a loop does not close
    /// with the least margin somewhere along the turn.
    pub fn new(dimensions: LinkageDimensions) -> Result<Self, Error> {
        dimensions.check()?;
        let mut linkage = Self { dimensions, middle: [0.0; 2] };
        let mut path = [[0.0; 2]; TRIALS];
        for (k, angles) in path.iter_mut().enumerate() {
            let degrees = 360.0 * k as f64 / TRIALS as f64;
            let pose = linkage.pose(Jet::<f64>::from(degrees.to_radians()), [Jet::ZERO; 3]);
            let pose = pose.map_err(|fault| {
                let value = format!("({fault}, at crank {degrees} deg)");
                let error =
                    Error::invalid("", value, format!("closed loops, every margin >= {MARGIN_LIMIT}"));
                error.against(LinkageDimensions::KEYS)
            })?;
            *angles = [pose.humerus.x, pose.radius.x];
        }
        linkage.middle = [middle(path.map(|a| a[0])), middle(path.map(|a| a[1]))];
        Ok(linkage)
    }

    /// Middle of the travel of a pin over a turn of the crank at nominal lengths, rad.
    pub fn pin_middle(&self, pin: LinkagePin) -> f64 {
        middle(std::array::from_fn(|k| {
            let crank = Jet::from(std::f64::consts::TAU * k as f64 / TRIALS as f64);
            // It closed there when it was made.
            self.pose(crank, [Jet::ZERO; 3]).map_or(0.0, |pose| pin.angle(&pose.directions, 0.0).x)
        }))
    }

    /// Limits of the displacement of each regulated length about its nominal value, m.
    pub fn displacement_limits(&self) -> [[f64; 2]; 3] {
        self.dimensions.regulated().map(|r| r.range().map(|limit| limit - r.nominal))
    }
}

impl<P: Scalar> Linkage<P> {
    /// The dimensions.
    pub fn dimensions(&self) -> &LinkageDimensions<P> {
        &self.dimensions
    }

    /// The same linkage with other dimensions, near enough that its angles keep their branches.
    pub fn with<Q: Scalar>(&self, dimensions: LinkageDimensions<Q>) -> Linkage<Q> {
        Linkage { dimensions, middle: self.middle }
    }

    /// Equation: body.linkage_closure
    /// `three loops P1 + L1 e1 + ... = P5, P8; each an intersection of two circles`
    /// Source: Paper (computational structure); law of cosines.
    /// Test: `the_reference_cycle_is_met_to_a_thousandth_of_a_degree`.
    ///
    /// Pose at the crank angle `crank`, with the regulated lengths displaced from
    /// nominal by `displacement` (m, order of [`REGULATED`]); the actual lengths
    /// are clamped to their limits. The three loops close one after another, each
    /// as an intersection of two circles:
    ///
    /// P1 + L1 e1 + L2a e2 + R(t5 - a3)[L3b; -L3c] = P5,
    /// P1 + L1 e1 + R(t2)[L2b; L2c] + L4 e3 + R(t8)[L5a; -L5b] = P8,
    /// P8 + R(t8)[L5c; L5d] + L6 e9 = P5 + R(t5)[L3a + L3c sin a3; L3c cos a3] + R(t6)[L7b; L7c].
    ///
    /// # Errors
    /// [`Fault::LinkageSingular`] when a loop's margin is below [`MARGIN_LIMIT`].
    #[inline(never)]
    pub fn pose<S: Scalar + Meets<P>>(
        &self,
        crank: Jet<S>,
        displacement: [Jet<S>; 3],
    ) -> Result<LinkagePose<S>, Fault> {
        let d = &self.dimensions;
        let regulated = d.regulated();
        let length = |i: usize| regulated[i].displaced(displacement[i]);
        let (p1, p5, p8) = (Planar::constant(d.p1_m), Planar::constant(d.p5_m), Planar::constant(d.p8_m));
        let (sin_a3, cos_a3) = (d.a3_deg * RADIANS).sin_cos();
        let crank_pin = p1 + Planar::unit(crank).times(d.l1_m);

        let arm3 = Planar::new(length(0), Jet::constant(S::from(-d.l3c_m)));
        let loop1 = Loop::close(1, p5 - crank_pin, d.l2a_m, arm3)?;
        let (e2, e5) = (loop1.bar, loop1.body.turned([cos_a3, sin_a3]));

        let arm5 = Planar::new(length(1), -length(2));
        let loop2 = Loop::close(2, p8 - crank_pin - e2.turned([d.l2b_m, d.l2c_m]), d.l4_m, arm5)?;
        let (e3, e8) = (loop2.bar, loop2.body);

        let elbow = p5 + e5.turned([d.l3a_m + d.l3c_m * sin_a3, d.l3c_m * cos_a3]);
        let arm7 = Planar::constant([-d.l7b_m, -d.l7c_m]);
        let gap = elbow - p8 - e8.turned([d.l5c_m, d.l5d_m]);
        let loop3 = Loop::close(3, gap, d.l6_m, arm7)?;
        let (e9, e6) = (loop3.bar, loop3.body);

        let (humerus, radius) = (e5.angle_about(self.middle[0]), e6.angle_about(self.middle[1]));
        let turned = d.turned_deg * RADIANS;
        let (sin, cos) = turned.sin_cos();
        let turn = |e: Planar<S>| e.turned([cos, sin]);
        Ok(LinkagePose {
            humerus: humerus.shifted(turned),
            radius: radius.shifted(turned),
            directions: Directions {
                e2: turn(e2),
                e3: turn(e3),
                e5: turn(e5),
                e6: turn(e6),
                e8: turn(e8),
                e9: turn(e9),
            },
            margins: [loop1.margin, loop2.margin, loop3.margin],
        })
    }
}

/// Middle of the range that a closed path of angles covers, in (-pi, pi] up to
/// half the range; the path is unwrapped from its first angle.
fn middle(mut path: [f64; TRIALS]) -> f64 {
    use std::f64::consts::{PI, TAU};
    for k in 1..TRIALS {
        path[k] -= TAU * ((path[k] - path[k - 1]) / TAU).round();
    }
    let low = path.iter().copied().fold(f64::INFINITY, f64::min);
    let high = path.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let middle = 0.5 * (low + high);
    middle - TAU * ((middle - PI) / TAU).ceil()
}
