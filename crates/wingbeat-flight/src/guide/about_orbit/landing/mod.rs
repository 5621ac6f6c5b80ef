//! A landing heel above head: from a level orbit the nose goes up and over in half a loop that ends at the perch, slow and upside down,
//! by commands that are planned on the whole model before the flight, and feedback about the plan.

mod airs;
mod plan;

pub(super) use airs::Airs;

use super::dive::{gain_at, mean_over};
use crate::orbit::{Cycle, Direction, Point};
use nalgebra::DMatrix;
use plan::apart;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use wingbeat_aero::LiftLaw;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Error, Mat3, Quat, Vec3, require};
use wingbeat_robot::{Layout, Perch, Robot};

/// Half a loop from level flight to the perch of the scenario, whose height above the start it takes; it begins with the cycle that starts
/// nearest to where the plan does.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct LandingSpec {
    /// Cycles of the gait from level flight to the perch.
    pub cycles: usize,
    /// Share of the range of each command that the plan may use; the rest is left to the feedback.
    #[serde(default = "most")]
    pub share: f64,
    /// Speed of the claw at the end of the plan that is refused beyond, m/s.
    #[serde(default = "slow")]
    pub speed_within_m_s: f64,
    /// Pitch off half a turn at the end of the plan that is refused beyond, deg.
    #[serde(default = "over")]
    pub pitch_within_deg: f64,
    /// Most iterations to each of the three ends by which the plan is led to the landing.
    #[serde(default = "most_iterations")]
    pub iterations: usize,
    /// Laws of lift that may hold in place of the one that the controller knows. The landing is planned under each, and commands are
    /// the mean of those of all plans, weighted by how far the flight shows each law to hold. Name at most three, each once,
    /// but not `linear`, under which the flow never separates.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = MOST_LAWS))]
    pub laws: Vec<LiftLaw>,
}

fn most() -> f64 {
    0.9
}

fn slow() -> f64 {
    0.3
}

fn over() -> f64 {
    12.0
}

fn most_iterations() -> usize {
    60
}

/// Most laws beside the one that is known.
const MOST_LAWS: usize = 3;

impl LandingSpec {
    /// All that can be said of it and the `robot` without a plan.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub(super) fn check(&self, robot: &Robot) -> Result<(), Error> {
        self.in_range()?;
        require::between("laws", self.laws.len(), 0, MOST_LAWS)?;
        (0..self.laws.len()).try_for_each(|i| self.check_law(i, robot))
    }

    /// Refuses a law that is no other, or under which a surface would lack what it bears broadside.
    fn check_law(&self, i: usize, robot: &Robot) -> Result<(), Error> {
        let law = self.laws[i];
        let known: Vec<LiftLaw> = robot.surfaces().map(|(_, aero)| aero.law()).collect();
        let other = !self.laws[..i].contains(&law) && known.iter().any(|known| *known != law);
        if other && law.separates() && known.iter().all(|known| known.separates()) {
            return Ok(());
        }
        let allowed = "other laws than the one that the controller knows, each once, all of which let the flow separate";
        Err(Error::invalid(format!("laws[{i}]"), law.name(), allowed))
    }
}

ranges!(LandingSpec {
    cycles: Range::between(2.0, 20.0),
    share: Range::between(0.1, 1.0),
    speed_within_m_s: Range::POSITIVE,
    pitch_within_deg: Range::between(0.1, 180.0),
    iterations: Range::between(1.0, 1000.0),
});

/// A landing that is planned under every law that may hold, from the origin with heading zero on.
pub(super) struct Landing {
    /// How long it takes, s, and a cycle of the gait.
    duration: f64,
    cycle: f64,
    /// Under the law that is known, and under the others.
    plans: Vec<PlannedLanding>,
    /// The robot under the law of each plan, where there are several.
    robots: Vec<Arc<Robot>>,
    /// Numbers of the inputs that are fed back.
    inputs: Vec<usize>,
    /// Where the claw ends.
    end: Vec3,
    /// Of the worst plan the share of its cost that the last iteration saved, speed of the claw at its end, m/s, and pitch off half a turn
    /// there, rad.
    pub reached: [f64; 3],
    /// Where the crank's part of the phase is among the states.
    crank: Option<usize>,
}

/// A plan and the feedback about it, by parts of a cycle.
struct PlannedLanding {
    /// States at every step.
    steps: Vec<Vec<f64>>,
    /// Commands of every part.
    commands: Vec<Vec<f64>>,
    /// Feedback of the inputs by what deviates, at the begin of every part and at the end.
    gains: Vec<DMatrix<f64>>,
    layout: Layout,
    /// Place and velocity of the claw at the end.
    end: [Vec3; 2],
    /// Share of its cost that the last iteration saved.
    saved: f64,
    /// Pitch off half a turn at the end, rad.
    over: f64,
}

/// A landing under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Begun {
    /// When it began, s.
    pub time: f64,
    /// Cycles of the gait at which it began.
    pub cycles: f64,
    /// Heading then, rad.
    heading: f64,
    /// Place then less that of the plan, m.
    ahead: Vec3,
}

/// What a landing asks for now.
pub(super) struct Landed {
    pub commands: Vec<f64>,
    /// Those of the plans alone.
    pub planned: Vec<f64>,
    /// Height, roll and pitch off the plan, and how far ahead of it.
    pub off: [f64; 4],
    /// Share of the plan that is done.
    pub done: f64,
    /// How far other laws than the one that is known are taken to hold.
    pub others: f64,
}

/// What a landing is planned with.
#[derive(Clone, Copy)]
pub(super) struct Approach<'a> {
    pub cycle: &'a Cycle<'a>,
    /// The level orbit.
    pub point: &'a Point,
    /// The commands that act on both sides alike, and each that is fed back.
    pub pairs: &'a [Direction],
    pub inputs: &'a [usize],
    pub perch: &'a Perch,
}

impl Landing {
    /// Plans the landing `spec`, and the feedback about it.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the robot cannot fly it so.
    pub fn plan(spec: &LandingSpec, approach: &Approach) -> Result<Self, Error> {
        let Approach { cycle, point, .. } = *approach;
        let robot = cycle.robot();
        let begin = cycle.start(point);
        let mut plans = vec![PlannedLanding::new(spec, approach, &begin, None)?];
        let under = |(i, law): (usize, &LiftLaw)| {
            spec.check_law(i, robot)?;
            robot.under(*law).map(Arc::new).map_err(|e| e.within(&format!("laws[{i}]")))
        };
        let mut robots = spec.laws.iter().enumerate().map(under).collect::<Result<Vec<_>, _>>()?;
        for robot in &robots {
            // As many steps as under the law that is known.
            let step = cycle.duration(1.0) / cycle.steps() as f64 * (1.0 + 1e-9);
            let (cycle, begin) = (Cycle::new(robot, step)?, robot.named_as(cycle.robot(), &begin));
            let other =
                PlannedLanding::new(spec, &Approach { cycle: &cycle, ..*approach }, &begin, Some(&plans[0]))?;
            plans.push(other);
        }
        if !robots.is_empty() {
            robots.insert(0, Arc::new(robot.clone()));
        }
        let worst = |of: fn(&PlannedLanding) -> f64| plans.iter().map(of).fold(0.0, f64::max);
        let reached = [worst(|plan| plan.saved), worst(PlannedLanding::speed), worst(|plan| plan.over)];
        Ok(Self {
            duration: spec.cycles as f64 * cycle.duration(1.0),
            cycle: cycle.duration(1.0),
            end: plans[0].end[0],
            reached,
            plans,
            robots,
            inputs: approach.inputs.to_vec(),
            crank: robot.pacer().map(|pacer| robot.layout().structure + pacer.element),
        })
    }

    /// What finds out which law holds, where several may.
    pub fn airs(&self) -> Option<Airs> {
        (!self.robots.is_empty()).then(|| Airs::new(&self.robots))
    }

    /// Begins it, where the whole of a cycle has just begun at the time `t` in the state `x` and no other begins nearer to where the plan
    /// does. A cycle has begun where the number of `cycles` is whole, up to the share `late` of one.
    pub fn begins(&self, perch: &Perch, t: f64, x: &[f64], (cycles, period): (f64, f64)) -> Option<Begun> {
        let l = &self.plans[0].layout;
        let whole = cycles.round();
        // Updates may come a little before or after the cycle begins.
        if !((cycles - whole).abs() <= 0.5 * period / self.cycle) {
            return None;
        }
        let yaw = Quat::from_wxyz(&x[l.attitude..]).matrix().roll_pitch_yaw()[2];
        let velocity = Vec3::from_slice(&x[l.velocity..]);
        let ahead = Mat3::rotation_z(-yaw) * (perch.place() - Vec3::from_slice(&x[l.position..]));
        let to_go = ahead[0] - self.end[0];
        let half = 0.5 * self.cycle * velocity[0].hypot(velocity[1]);
        let mut begun =
            Begun { time: t - (cycles - whole) * self.cycle, cycles: whole, heading: yaw, ahead: Vec3::ZERO };
        (to_go <= half).then(|| {
            let (off, _) = self.off(&self.plans[0], &begun, perch, (t, cycles), x);
            begun.ahead = Vec3([off[0], off[1], 0.0]);
            begun
        })
    }

    /// What the state `x` is off the `plan` at the time `t` with the gait's phase `cycles`, place and velocity along the axes of the plan, and
    /// the share of it that is done.
    fn off(
        &self,
        plan: &PlannedLanding,
        begun: &Begun,
        perch: &Perch,
        (t, cycles): (f64, f64),
        x: &[f64],
    ) -> (Vec<f64>, f64) {
        let l = &plan.layout;
        let since = t - begun.time;
        let done = (since / self.duration).clamp(0.0, 1.0);
        let last = plan.steps.len() - 1;
        let at = done * last as f64;
        let i = (at as usize).min(last - 1);
        let share = at - i as f64;
        let nearer = |(one, other): (&f64, &f64)| one + share * (other - one);
        let mut asked: Vec<f64> = plan.steps[i].iter().zip(&plan.steps[i + 1]).map(nearer).collect();
        Quat::from_wxyz(&asked[l.attitude..]).normalized().store_wxyz(&mut asked[l.attitude..]);
        let mut own = x.to_vec();
        let back = Mat3::rotation_z(-begun.heading);
        // What it began ahead is made up smoothly until the end.
        let left = 1.0 - done * done * (3.0 - 2.0 * done);
        let leaves = -6.0 * done * (1.0 - done) / self.duration;
        let place = back * (Vec3::from_slice(&x[l.position..]) - perch.place()) + self.end;
        (place - begun.ahead * left).store(&mut own[l.position..]);
        (back * Vec3::from_slice(&x[l.velocity..]) - begun.ahead * leaves).store(&mut own[l.velocity..]);
        let turned = Quat::from_roll_pitch_yaw(0.0, 0.0, -begun.heading) * Quat::from_wxyz(&x[l.attitude..]);
        turned.store_wxyz(&mut own[l.attitude..]);
        if let Some(crank) = self.crank {
            // The phase counts, whatever part of it was the crank's before.
            own[crank] = std::f64::consts::TAU * (cycles - begun.cycles - since / self.cycle);
        }
        (apart(l, &asked, &own), done)
    }

    /// What it asks for at the time `t`, s, in the state `x` with the gait's phase `cycles`, in cycles, over the coming `period`, s; `airs` say
    /// which law holds.
    pub fn ask(
        &self,
        begun: &Begun,
        perch: &Perch,
        (t, cycles, period): (f64, f64, f64),
        (x, airs): (&[f64], Option<&Airs>),
    ) -> Landed {
        let weights = airs.map_or_else(|| vec![1.0], Airs::weights);
        let states: Vec<&[f64]> = airs.map_or_else(|| vec![x], |airs| airs.states().collect());
        let others = weights[1..].iter().sum();
        let mut all = Landed { commands: Vec::new(), planned: Vec::new(), off: [0.0; 4], done: 0.0, others };
        for ((plan, weight), x) in self.plans.iter().zip(weights).zip(states) {
            let (off, done) = self.off(plan, begun, perch, (t, cycles), x);
            let planned = self.planned(plan, done, period);
            let commands = self.fed_back(plan, &planned, &off, done);
            for (all, own) in [(&mut all.commands, commands), (&mut all.planned, planned)] {
                all.resize(own.len(), 0.0);
                all.iter_mut().zip(own).for_each(|(all, own)| *all += weight * own);
            }
            let seen = [off[2], off[3], off[4], off[0]];
            all.off.iter_mut().zip(seen).for_each(|(all, own)| *all += weight * own);
            all.done = done;
        }
        all
    }

    /// Commands of `plan` over the coming `period`, where it is done up to `done`.
    fn planned(&self, plan: &PlannedLanding, done: f64, period: f64) -> Vec<f64> {
        let parts = plan.commands.len() as f64;
        let per = parts / self.duration;
        let from = (done * parts).min(parts - 1e-6);
        mean_over(&plan.commands, [from, from + period * per])
    }

    /// The commands `planned` and the feedback of what is `off` the `plan`, where it is done up to `done`.
    fn fed_back(&self, plan: &PlannedLanding, planned: &[f64], off: &[f64], done: f64) -> Vec<f64> {
        let (gain, mut commands) = (gain_at(&plan.gains, done), planned.to_vec());
        for (row, input) in self.inputs.iter().enumerate() {
            commands[*input] -= off.iter().enumerate().map(|(j, off)| gain[(row, j)] * off).sum::<f64>();
        }
        commands
    }
}
