//! What the prescribed motion costs: power by body, hinge and side, and torques of the air about the hinges.

use super::spar::Bent;
use super::wing::Frame;
use super::{Motion, Side, Tether};
use crate::simulate::{Column, StripMotion};
use wingbeat_aero::{Loads, SectionMotion};
use wingbeat_math::{Jet, Vec3, Wrench};

/// Motion of a rigid body as seen at W's origin, in W.
#[derive(Clone, Copy, Debug, Default)]
struct Twist {
    /// Velocity of its point at W's origin, m/s.
    velocity: Vec3,
    /// Angular rate, rad/s.
    rate: Vec3,
}

impl Twist {
    /// Of a chord line: along itself it turns as its link does, across itself as its edges say, which know of a
    /// twist that grows along the link.
    fn of(section: &SectionMotion<f64>) -> Self {
        let chord = section.le - section.te;
        let square = chord.dot(chord);
        let rate = match square > 0.0 {
            true => {
                (chord.cross(section.v_le - section.v_te) + chord * chord.dot(section.w)) * (1.0 / square)
            }
            false => section.w,
        };
        Self { velocity: section.v_te - rate.cross(section.te), rate }
    }

    /// Power of a load about W's origin on the body, W.
    fn power(&self, load: &Wrench<f64>) -> f64 {
        load.force.dot(self.velocity) + load.moment.dot(self.rate)
    }
}

/// A half of the wing with a hinge.
#[derive(Clone, Copy, Debug)]
struct Half {
    hinge: usize,
    side: Side,
    /// Share of a strip in the middle of the wing: all of it where the other half has no part.
    of_middle: f64,
}

/// Powers and torques at one instant.
///
/// | what | sign |
/// |---|---|
/// | power of a strip, of all of them, of the body's motion, of a hinge | positive where the motion gives it to the air |
/// | torque about a hinge | of the air on what lies outboard, positive where it turns the hinge its positive way |
#[derive(Clone, Debug)]
pub(super) struct Powers {
    halves: Vec<Half>,
    /// Of all strips, W.
    pub total: f64,
    /// Of the body's motion, W.
    pub body: f64,
    /// Torque (N m) and power (W) of each half with a hinge.
    pub hinges: Vec<[f64; 2]>,
    /// How each strip moves, in W.
    pub strips: Vec<StripMotion>,
}

impl Powers {
    pub fn new(tether: &Tether) -> Self {
        let sides = [Side::Left, Side::Right];
        let has = |hinge: Side, side: Side| {
            let sign = if side == Side::Left { 1.0 } else { -1.0 };
            hinge.holds(sign) && tether.side.holds(sign)
        };
        let of_hinge = |(hinge, own): (usize, Side)| {
            let found: Vec<Side> = sides.into_iter().filter(|side| has(own, *side)).collect();
            let of_middle = 1.0 / found.len().max(1) as f64;
            found.into_iter().map(move |side| Half { hinge, side, of_middle })
        };
        let halves: Vec<Half> =
            tether.wing.hinges().iter().map(|hinge| hinge.side).enumerate().flat_map(of_hinge).collect();
        let hinges = vec![[0.0; 2]; halves.len()];
        Self { halves, total: 0.0, body: 0.0, hinges, strips: Vec::with_capacity(tether.aero.strips()) }
    }

    /// Columns of powers and torques.
    pub fn columns(&self, motion: &Motion) -> Vec<Column> {
        let mut columns = vec![Column::new("power", "W", ""), Column::new("power_body", "W", "")];
        for Half { hinge, side, .. } in &self.halves {
            let side = if *side == Side::Left { "left" } else { "right" };
            let name = &motion.hinges[*hinge].0;
            columns.push(Column::new(format!("torque_{name}_{side}"), "N m", ""));
            columns.push(Column::new(format!("power_{name}_{side}"), "W", ""));
        }
        columns
    }

    /// Of the strips' `loads` (in W about W's origin) at time `t`, each times its weight. Power is that of the motion
    /// relative to still ground, so that a body that moves forward pays for its drag. The torque about a hinge is the
    /// power of the loads when it alone turns, at 1 rad/s: its axis, its place and the share of a growing twist are
    /// those of the wing's own kinematics.
    ///
    /// Equation: tether.power
    /// `P = -sum (f.v + m.w) over strips relative to still ground; torque of a hinge = sum (f.v_j + m.w_j), the
    /// strips' motion as it alone turns at 1 rad/s`
    /// Source: virtual work.
    /// Test: `power_is_that_of_body_and_hinges`.
    ///
    /// `bent` is the shape of a wing with spars.
    pub fn update(&mut self, tether: &Tether, t: f64, seen: (&Loads<f64>, Option<&Bent>), weights: &[f64]) {
        let still = |jet: &Jet<f64>| Jet::from(jet.x);
        let (body, angles) = (tether.motion.body(t), tether.motion.angles(t));
        let (frame, held) = (body.frame(), body.frame().still());
        let fixed: Vec<Jet<f64>> = angles.iter().map(still).collect();
        let mut turning = fixed.clone();
        (self.total, self.body) = (0.0, 0.0);
        self.hinges.fill([0.0; 2]);
        self.strips.clear();
        let (loads, bent) = seen;
        let still_shape = bent.map(Bent::still);
        let arcs = tether.aero.strip_arcs();
        let all = |frame: &Frame<f64>, angles: &[Jet<f64>], bent: Option<&Bent>| {
            tether.sections_at(arcs, frame, angles, bent)
        };
        let moving = all(&frame, &angles, bent);
        let with_body = all(&frame, &fixed, still_shape.as_ref());
        let units: Vec<Vec<SectionMotion<f64>>> = self
            .halves
            .iter()
            .map(|half| {
                turning[half.hinge].d = 1.0;
                let unit = all(&held, &turning, still_shape.as_ref());
                turning[half.hinge].d = 0.0;
                unit
            })
            .collect();
        for (i, &arc) in arcs.iter().enumerate() {
            let whole = loads.strip[i].total();
            let load = Wrench { force: whole.force * weights[i], moment: whole.moment * weights[i] };
            let section = moving[i];
            let moved = StripMotion::of(&section, -Twist::of(&section).power(&whole));
            self.total += moved.power * weights[i];
            self.strips.push(moved);
            self.body -= Twist::of(&with_body[i]).power(&load);
            for ((half, sum), unit) in self.halves.iter().zip(&mut self.hinges).zip(&units) {
                let torque = half.share(arc) * Twist::of(&unit[i]).power(&load);
                sum[0] += torque;
                sum[1] -= torque * angles[half.hinge].d;
            }
        }
    }
}

impl Half {
    /// The share of the strip at `arc` that belongs to the half.
    fn share(self, arc: f64) -> f64 {
        match (arc == 0.0, self.side.holds(arc)) {
            (true, _) => self.of_middle,
            (false, true) => 1.0,
            (false, false) => 0.0,
        }
    }
}
