//! Where a robot is and how it moves, without its loads.

use super::carried::air_power;
use super::drive::Ratios;
use super::placement::{LinkLine, PanelMeeting};
use super::sections::{CarrierRoom, Carriers, Riding, SurfaceSection, Web};
use super::{BodyMotion, Joints, Links, Robot};
use crate::body::{Coordinates, LinkMotion};
use wingbeat_math::{Jet, Mat3, Quat, Vec3, Wrench, segment_distance};
use wingbeat_ocp::plant::Fault;

/// What the places and velocities of a robot's surfaces follow from.
#[derive(Clone, Debug)]
pub struct Stance {
    /// The gait's time, s, with its rate.
    pub clock: Jet,
    /// R_WB.
    pub attitude: Mat3,
    /// p_WB, m.
    pub origin: Vec3,
    /// v_WB_W, m/s.
    pub velocity: Vec3,
    /// w_WB_B, rad/s.
    pub rate: Vec3,
    /// States of the structure, in the units of their channels.
    pub structure: Vec<f64>,
    /// How the chords of the surfaces are bent, and how fast, in the order of [`Robot::bent_chords`]: heights over the chord and 1/s, angles
    /// in rad and rad/s; none where they count as straight.
    pub bends: Vec<[f64; 2]>,
}

impl PartialEq for Stance {
    fn eq(&self, other: &Self) -> bool {
        let clock = |at: &Self| (at.clock.x, at.clock.d);
        let body = |at: &Self| (at.attitude, at.origin, at.velocity, at.rate);
        let soft = self.structure == other.structure && self.bends == other.bends;
        clock(self) == clock(other) && body(self) == body(other) && soft
    }
}

/// Distance of two chord lines over the shorter of them, dimensionless.
pub(super) fn lines_apart([inner, outer]: [[Vec3; 2]; 2]) -> f64 {
    let chord = [inner, outer].map(|[leading, trailing]| (leading - trailing).norm());
    segment_distance(inner, outer) / chord[0].min(chord[1])
}

impl Robot {
    /// A robot in flight in the state `x` at `t` s.
    pub fn stance(&self, t: f64, x: &[f64]) -> Stance {
        let l = &self.layout;
        Stance {
            clock: Jet::new(t, 1.0, 0.0),
            attitude: Quat::from_wxyz(&x[l.attitude..]).matrix(),
            origin: Vec3::from_slice(&x[l.position..]),
            velocity: Vec3::from_slice(&x[l.velocity..]),
            rate: Vec3::from_slice(&x[l.rate..]),
            structure: x[l.structure..l.aero].to_vec(),
            bends: Vec::new(),
        }
    }

    /// A robot that is carried in the state `x`, its body's origin at `origin` and moving as `body`.
    pub fn carried_stance(&self, clock: &Jet, origin: Vec3, body: &BodyMotion, x: &[f64]) -> Stance {
        Stance {
            clock: *clock,
            attitude: body.attitude,
            origin,
            velocity: body.velocity,
            rate: body.rate,
            structure: x[..self.layout.aero - self.layout.structure].to_vec(),
            bends: Vec::new(),
        }
    }

    /// The same with its chords bent as `air` says, the states of the air with their rates.
    #[must_use]
    pub fn bent_as(&self, stance: Stance, (air, rates): (&[f64], &[f64])) -> Stance {
        Stance { bends: self.bends_of(air, rates), ..stance }
    }

    /// Whether the chords of a surface bend.
    pub fn has_bent_chords(&self) -> bool {
        self.bent_chords().next().is_some()
    }

    /// Power that loads on links and body, in B about the body's origin and the body's last, give to a robot as it is `at`, W.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    ///
    /// Equation: robot.air_power
    pub fn power_of(&self, at: &Stance, loads: &[Wrench<f64>]) -> Result<f64, Fault> {
        let (base, links) = self.moving_at(at)?;
        Ok(air_power(&base, &links, loads))
    }

    /// Body and links of a robot as it is `at`, accelerations left out.
    fn moving_at(&self, at: &Stance) -> Result<(LinkMotion, Links<f64>), Fault> {
        let velocity = at.attitude.transpose_mul(at.velocity);
        let inputs = vec![0.0; self.inputs.len()];
        let mut rates = vec![0.0; self.layout.joints - self.layout.structure];
        let (mut joints, mut ratios) = (Joints::new(), Ratios::new());
        self.joints(&at.clock, &at.structure, &inputs, &mut rates, &mut joints, &mut ratios)?;
        let mut links = Links::new();
        self.links(&joints, velocity, at.rate, &mut links);
        Ok((LinkMotion::base(velocity, at.rate), links))
    }

    /// Largest distance on a hinge between the chord lines of the panels that meet there, over the shorter of them, dimensionless, as the robot
    /// hangs still; none of surfaces of one panel. Chord lines that cross, as those on a joint do, are 0 apart.
    pub fn panels_apart(&self) -> Option<f64> {
        let body = BodyMotion::steady(Mat3::IDENTITY, Vec3::ZERO);
        let still = self.carried_stance(&Jet::new(0.0, 1.0, 0.0), Vec3::ZERO, &body, &self.carried_still());
        let (base, links) = self.moving_at(&still).ok()?;
        let line = |(link, ends): LinkLine<f64>| {
            let link = link.map_or(&base, |i| &links[i]);
            ends.map(|end| link.point(end))
        };
        let apart = |meeting: PanelMeeting<f64>| lines_apart(meeting.lines.map(line));
        let meetings = self.covering.laid.iter().flat_map(|surface| surface.placement.meetings());
        meetings.map(apart).filter(|apart| apart.is_finite()).reduce(f64::max)
    }

    /// `then` with the sections of the surface number `surface` at the arc coordinates `arcs`, riding on links whose accelerations
    /// are left out.
    pub(super) fn riding_at<T>(
        &self,
        at: &Stance,
        surface: usize,
        arcs: &[f64],
        then: impl FnOnce(&Riding<f64, f64>) -> T,
    ) -> Result<T, Fault> {
        let (base, links) = self.moving_at(at)?;
        let still = Coordinates::none();
        let mut room = CarrierRoom::new();
        let mut carriers = Carriers::within(&mut room, &still);
        carriers.follow(&base, &self.carriers, &links, [Vec3::ZERO; 2]);
        let placement = &self.covering.laid[surface].placement;
        let sections: Vec<SurfaceSection> =
            arcs.iter().map(|s| placement.section(*s, &self.carriers)).collect();
        let webs: Vec<Option<Web>> = arcs.iter().map(|s| placement.web(*s, &self.carriers)).collect();
        Ok(then(&Riding { sections: &sections, webs: &webs, carriers: &carriers }))
    }
}
