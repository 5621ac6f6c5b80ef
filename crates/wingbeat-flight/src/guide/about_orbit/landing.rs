//! A landing heel above head: from a level orbit the nose goes up and over in half a loop that ends at the perch, slow and upside down,
//! by commands that are planned on the whole model before the flight, and feedback about the plan.

use super::ddp::{self, Flown, Parts, Quadratic};
use super::dive::{gain_at, mean_over};
use super::feedback::{back, effort};
use crate::orbit::{Cycle, Direction, Point, Section, alone, fly_held};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use wingbeat_math::parallel;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Error, Mat3, Quat, Scalar, Vec3};
use wingbeat_ocp::plant::{Channel, Early, Fault, Plant};
use wingbeat_robot::{Layout, Perch, Robot};

/// What counts as one at the end of the plan: velocity of the claw, m/s, pitch, rad, its rate, rad/s, and height off the perch, m.
/// *Choices.*
const END: [f64; 5] = [0.15, 0.15, 5.0 * PI / 180.0, 5.0, 0.01];
/// Cost of a full command over a part. *Choice.*
const EFFORT: f64 = 0.01;
/// Clearance below which the plan pays, and what counts as one below it, m. *Choices.*
const CLEAR: [f64; 2] = [0.008, 1.0 / 60.0];
/// Steps by which the plan is led from level flight to the landing.
const STAGES: usize = 3;
/// Share of the cost that an iteration must save for another one.
const SAVED: f64 = 1e-3;
/// Deviations that cost as much as each other in the feedback: of place, m, attitude, rad, velocity, m/s, and rate, rad/s, on the way and
/// at the end; and what a full command costs over a part. *Fitted* to flights in gusts and air that the plan does not know.
const ON_THE_WAY: [f64; 4] = [0.03, 30.0 * PI / 180.0, 0.6, 20.0];
const AT_THE_END: [f64; 4] = [0.01, 5.0 * PI / 180.0, 0.05, 5.0];
const COMMAND: f64 = 0.1;
/// Numbers of the body among what deviates: place, rotation, velocity, rate.
const BODY: usize = 12;

/// Half a loop from level flight to the perch of the scenario, whose height above the start it takes; it begins with the cycle that starts
/// nearest to where the plan does.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
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

ranges!(LandingSpec {
    cycles: Range::between(2.0, 20.0),
    share: Range::between(0.1, 1.0),
    speed_within_m_s: Range::POSITIVE,
    pitch_within_deg: Range::between(0.1, 180.0),
    iterations: Range::between(1.0, 1000.0),
});

/// A planned landing and the feedback about it, by parts of a cycle, from the origin with heading zero on.
pub(super) struct Landing {
    /// How long it takes, s.
    duration: f64,
    /// States at every step.
    steps: Vec<Vec<f64>>,
    /// Commands of every part.
    commands: Vec<Vec<f64>>,
    /// Feedback of the inputs by what deviates, at the begin of every part and at the end.
    gains: Vec<DMatrix<f64>>,
    /// Numbers of the inputs.
    inputs: Vec<usize>,
    /// Where the claw ends.
    end: Vec3,
    /// Share of its cost that the last iteration saved, speed of the claw at its end, m/s, and pitch off half a turn there, rad.
    pub reached: [f64; 3],
    /// Where the crank's part of the phase is among the states.
    crank: Option<usize>,
    layout: Layout,
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
    /// Height, roll and pitch off the plan, and how far ahead of it.
    pub off: [f64; 4],
    /// Share of the plan that is done.
    pub done: f64,
}

/// What a landing is planned with.
pub(super) struct Approach<'a> {
    pub cycle: &'a Cycle<'a>,
    /// The level orbit.
    pub point: &'a Point,
    /// The commands that act on both sides alike, and each that is fed back.
    pub pairs: &'a [Direction],
    pub inputs: &'a [usize],
    pub perch: &'a Perch,
}

/// What is differentiated by state and commands.
type Differentiated<'a> = dyn Fn(&[Early], &[Early]) -> Result<Vec<Early>, Fault> + 'a;

/// Costs and limits of a plan.
struct Problem<'a> {
    approach: &'a Approach<'a>,
    robot: &'a Robot,
    directions: Vec<Direction>,
    parts: usize,
    effort: DMatrix<f64>,
    low: DVector<f64>,
    high: DVector<f64>,
    /// Commands of the orbit.
    level: Vec<f64>,
    /// What is asked at the end, in the order of [`END`]; any height where it is not finite.
    asked: [f64; 5],
}

impl Landing {
    /// Plans the landing `spec`, and the feedback about it.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the robot cannot fly it so.
    pub fn plan(spec: &LandingSpec, approach: &Approach) -> Result<Self, Error> {
        let Approach { cycle, point, .. } = *approach;
        let broken = |fault: Fault| Error::invalid("cycles", fault, "a landing that the model can fly");
        let mut problem = Problem::new(spec, approach)?;
        let begin = cycle.start(point);
        let flown = problem.solve(&begin, spec.iterations).map_err(broken)?;
        let end = &flown.nodes[problem.parts];
        let [vx, vz, pitch, ..] = problem.ends(end);
        let speed = vx.hypot(vz);
        let over = (pitch + PI).abs().to_degrees();
        if !(speed <= spec.speed_within_m_s && over <= spec.pitch_within_deg) {
            let allowed = format!(
                "a landing of which the robot is capable: with these cycles it gets to {speed:.2} m/s, nose up by {:.0} deg",
                -pitch.to_degrees()
            );
            return Err(Error::invalid("cycles", spec.cycles, allowed));
        }
        let commands: Vec<Vec<f64>> = flown.commands.iter().map(|v| problem.held(v.as_slice())).collect();
        let mut steps = vec![begin];
        for (k, held) in commands.iter().enumerate() {
            problem.fly(k, &flown.nodes[k], held, &mut |x: &[f64]| steps.push(x.to_vec())).map_err(broken)?;
        }
        let gains = problem.gains(&flown.nodes, &commands).map_err(broken)?;
        let gains = gains.ok_or_else(|| {
            Error::invalid("cycles", spec.cycles, "a landing about which the feedback has a solution")
        })?;
        let layout = *problem.robot.layout();
        Ok(Self {
            duration: spec.cycles as f64 * cycle.duration(1.0),
            end: claw_of(&layout, end, approach.perch.claw())[0],
            reached: [flown.saved, speed, over.to_radians()],
            steps,
            commands,
            gains,
            inputs: approach.inputs.to_vec(),
            crank: problem.robot.pacer().map(|pacer| layout.structure + pacer.element),
            layout,
        })
    }

    /// Begins it, where the whole of a cycle has just begun at the time `t` in the state `x` and no other begins nearer to where the plan
    /// does. A cycle has begun where the number of `cycles` is whole, up to the share `late` of one.
    pub fn begins(&self, perch: &Perch, t: f64, x: &[f64], (cycles, period): (f64, f64)) -> Option<Begun> {
        let l = &self.layout;
        let whole = cycles.round();
        // Updates may come a little before or after the cycle begins.
        if !((cycles - whole).abs() <= 0.5 * period / self.cycle()) {
            return None;
        }
        let yaw = Quat::from_wxyz(&x[l.attitude..]).matrix().roll_pitch_yaw()[2];
        let velocity = Vec3::from_slice(&x[l.velocity..]);
        let ahead = Mat3::rotation_z(-yaw) * (perch.place() - Vec3::from_slice(&x[l.position..]));
        let to_go = ahead[0] - self.end[0];
        let half = 0.5 * self.cycle() * velocity[0].hypot(velocity[1]);
        let mut begun = Begun {
            time: t - (cycles - whole) * self.cycle(),
            cycles: whole,
            heading: yaw,
            ahead: Vec3::ZERO,
        };
        (to_go <= half).then(|| {
            let (off, _) = self.off(&begun, perch, (t, cycles), x);
            begun.ahead = Vec3([off[0], off[1], 0.0]);
            begun
        })
    }

    /// Duration of a cycle of the gait, s.
    fn cycle(&self) -> f64 {
        let parts = self.commands.len();
        let per_cycle = crate::orbit::PARTS;
        self.duration / (parts / per_cycle) as f64
    }

    /// What the state `x` is off the plan at the time `t` with the gait's phase `cycles`, place and velocity along the axes of the plan, and
    /// the share of it that is done.
    fn off(&self, begun: &Begun, perch: &Perch, (t, cycles): (f64, f64), x: &[f64]) -> (Vec<f64>, f64) {
        let l = &self.layout;
        let since = t - begun.time;
        let done = (since / self.duration).clamp(0.0, 1.0);
        let last = self.steps.len() - 1;
        let at = done * last as f64;
        let i = (at as usize).min(last - 1);
        let share = at - i as f64;
        let nearer = |(one, other): (&f64, &f64)| one + share * (other - one);
        let mut asked: Vec<f64> = self.steps[i].iter().zip(&self.steps[i + 1]).map(nearer).collect();
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
            own[crank] = std::f64::consts::TAU * (cycles - begun.cycles - since / self.cycle());
        }
        (apart(l, &asked, &own), done)
    }

    /// What it asks for at the time `t` in the state `x` with the gait's phase `cycles`, over the coming `period` (s).
    pub fn ask(
        &self,
        begun: &Begun,
        perch: &Perch,
        (t, cycles, period): (f64, f64, f64),
        x: &[f64],
    ) -> Landed {
        let (off, done) = self.off(begun, perch, (t, cycles), x);
        let gain = gain_at(&self.gains, done);
        let parts = self.commands.len() as f64;
        let per = parts / self.duration;
        let from = (done * parts).min(parts - 1e-6);
        let mut commands = mean_over(&self.commands, [from, from + period * per]);
        for (row, input) in self.inputs.iter().enumerate() {
            commands[*input] -= off.iter().enumerate().map(|(j, off)| gain[(row, j)] * off).sum::<f64>();
        }
        Landed { commands, off: [off[2], off[3], off[4], off[0]], done }
    }
}

/// The state that is `d` off `x0`.
fn beside<S: Scalar>(l: &Layout, x0: &[f64], d: &[S]) -> Vec<S> {
    let mut x: Vec<S> = x0.iter().map(|value| S::from(*value)).collect();
    for i in 0..3 {
        x[l.position + i] += d[i];
        x[l.velocity + i] += d[6 + i];
        x[l.rate + i] += d[9 + i];
    }
    let turned = Quat::from_wxyz(&x[l.attitude..]) * Quat::exp(Vec3::new(d[3], d[4], d[5]));
    turned.store_wxyz(&mut x[l.attitude..]);
    x[l.structure..].iter_mut().zip(&d[BODY..]).for_each(|(x, d)| *x += *d);
    x
}

/// What the state `x` is off `x0`: place, twice the vector of the quaternion between them, velocity, rate, and the rest.
fn apart<S: Scalar>(l: &Layout, x0: &[f64], x: &[S]) -> Vec<S> {
    let mut d = vec![S::ZERO; x.len() - 1];
    let difference = |i: usize| x[i] - x0[i];
    for i in 0..3 {
        d[i] = difference(l.position + i);
        d[6 + i] = difference(l.velocity + i);
        d[9 + i] = difference(l.rate + i);
    }
    let from: Quat<S> = Quat::constant(Quat::from_wxyz(&x0[l.attitude..]));
    let between = from.conjugate() * Quat::from_wxyz(&x[l.attitude..]);
    let twice = if between.w.value() < 0.0 { -2.0 } else { 2.0 };
    (between.v * S::from(twice)).store(&mut d[3..]);
    (l.structure..x.len()).for_each(|i| d[i - 1] = difference(i));
    d
}

/// Place and velocity of a point of the body.
fn claw_of<S: Scalar>(l: &Layout, x: &[S], claw: Vec3) -> [Vec3<S>; 2] {
    let attitude = Quat::from_wxyz(&x[l.attitude..]).matrix();
    let arm: Vec3<S> = Vec3::constant(claw);
    let swept = attitude * Vec3::from_slice(&x[l.rate..]).cross(arm);
    [Vec3::from_slice(&x[l.position..]) + attitude * arm, Vec3::from_slice(&x[l.velocity..]) + swept]
}

impl<'a> Problem<'a> {
    fn new(spec: &LandingSpec, approach: &'a Approach<'a>) -> Result<Self, Error> {
        let (cycle, pairs) = (approach.cycle, approach.pairs);
        let robot = cycle.robot();
        let level = &approach.point.inputs;
        let of = |end: fn(&Channel) -> f64| {
            let range = |pair: &Direction| {
                let (i, share) = pair[0];
                (spec.share * end(&robot.inputs()[i]) - level[i]) / share
            };
            DVector::from_iterator(pairs.len(), pairs.iter().map(range))
        };
        let (low, high) = (of(|channel| channel.low), of(|channel| channel.high));
        let cost_of = |pair: &Direction| EFFORT * (pair[0].1 / robot.inputs()[pair[0].0].high).powi(2);
        let costs = DVector::from_iterator(pairs.len(), pairs.iter().map(cost_of));
        Ok(Self {
            approach,
            robot,
            directions: symmetric(robot)?,
            parts: spec.cycles * cycle.parts(),
            effort: DMatrix::from_diagonal(&costs),
            low: low.map(|v| v.min(0.0)),
            high: high.map(|v| v.max(0.0)),
            level: level.clone(),
            asked: [0.0; 5],
        })
    }

    /// Equation: guide.landing_plan
    /// `min sum u'Ru + sum ((v_claw, pitch + pi, pitch rate, height off the perch)/END)^2 + sum (max(0, CLEAR - clearance))^2, u within its limits`
    /// Source: Tassa, Mansard & Todorov 2014, ICRA; bats on a ceiling: Riskin et al. 2009, J. Exp. Biol. 212.
    /// Test: `a_landing_ends_upside_down_at_the_perch`.
    ///
    /// From the level flight on, by ends on the way to the landing.
    fn solve(&mut self, begin: &[f64], iterations: usize) -> Result<Flown, Fault> {
        let [vx, vz, pitch, ..] = self.ends(begin);
        let mut commands = vec![DVector::zeros(self.low.len()); self.parts];
        let mut flown = None;
        for stage in 1..=STAGES {
            let left = 1.0 - stage as f64 / STAGES as f64;
            let last = stage == STAGES;
            let height = if last { self.approach.perch.place()[2] } else { f64::NAN };
            self.asked = [left * vx, left * vz, left * pitch - (1.0 - left) * PI, 0.0, height];
            let found = ddp::solve(self, begin, commands, (iterations, SAVED, EFFORT))?;
            commands = found.commands.clone();
            flown = Some(found);
        }
        flown.ok_or(Fault::NotFinite { state: 0, time: 0.0 })
    }

    /// All commands for those `beside` the orbit's.
    fn held<S: Scalar>(&self, beside: &[S]) -> Vec<S> {
        let mut held: Vec<S> = self.level.iter().map(|level| S::from(*level)).collect();
        for (pair, step) in self.approach.pairs.iter().zip(beside) {
            pair.iter().for_each(|(i, share)| held[*i] += *step * *share);
        }
        held
    }

    /// Flies part `k` from the state `x`; `each` sees every step.
    fn fly<S: wingbeat_robot::CycleScalar>(
        &self,
        k: usize,
        x: &[S],
        held: &[S],
        each: &mut dyn FnMut(&[S]),
    ) -> Result<Vec<S>, Fault> {
        let mut x = x.to_vec();
        fly_held(self.approach.cycle, &mut x, held, [k, self.approach.cycle.parts()], each)?;
        Ok(x)
    }

    /// Velocity of the claw ahead and up, pitch beyond half a turn too, its rate, height of the claw.
    fn ends<S: Scalar>(&self, x: &[S]) -> [S; 5] {
        let l = self.robot.layout();
        let [place, velocity] = claw_of(l, x, self.approach.perch.claw());
        let pitch = x[l.attitude + 2].atan2(x[l.attitude]) * 2.0;
        [velocity[0], velocity[2], pitch, x[l.rate + 1], place[2]]
    }

    /// What counts at the end of the plan, or before part `k`: its squares are the cost.
    fn missed<S: Scalar>(&self, k: usize, x: &[S]) -> Vec<S> {
        let mut missed = Vec::new();
        if k == self.parts {
            let ends = self.ends(x).into_iter().zip(self.asked.into_iter().zip(END));
            let asked = ends.filter(|(_, (asked, _))| asked.is_finite());
            missed.extend(asked.map(|(is, (asked, size))| (is - asked) * (1.0 / size)));
        }
        let mut clear = vec![S::ZERO; self.robot.clearances().len()];
        let time = self.approach.cycle.duration(1.0) * k as f64 / self.approach.cycle.parts() as f64;
        if self.robot.clear(S::from(time), x, &mut clear).is_ok() {
            let short = |clear: S| clear.if_below(S::from(CLEAR[0]), -clear + CLEAR[0], S::ZERO);
            missed.extend(clear.into_iter().map(|clear| short(clear) * (1.0 / CLEAR[1])));
        }
        missed
    }

    /// Columns of the derivatives of `of` the state about `x` along `directions`, then along `inputs` of commands `beside`.
    fn columns(
        &self,
        (x, directions): (&[f64], &[Direction]),
        (beside_level, inputs): (&[f64], usize),
        of: &Differentiated,
    ) -> Result<(Vec<f64>, DMatrix<f64>), Fault> {
        let l = self.robot.layout();
        let n = directions.len();
        let (mut values, mut all) = (Vec::new(), DMatrix::zeros(0, 0));
        for first in (0..n + inputs).step_by(Early::LANES) {
            let mut d = vec![Early::ZERO; l.len - 1];
            let mut v: Vec<Early> = beside_level.iter().map(|v| Early::constant(*v)).collect();
            let last = (n + inputs).min(first + Early::LANES);
            for column in first..last {
                match column.checked_sub(n) {
                    None => directions[column].iter().for_each(|(i, s)| d[*i].eps[column - first] = *s),
                    Some(input) => v[input].eps[column - first] = 1.0,
                }
            }
            let found = of(&beside(l, x, &d), &v)?;
            if first == 0 {
                all = DMatrix::zeros(found.len(), n + inputs);
                values = found.iter().map(|found| found.re).collect();
            }
            for (row, found) in found.iter().enumerate() {
                (first..last).for_each(|column| all[(row, column)] = found.eps[column - first]);
            }
        }
        Ok((values, all))
    }

    /// How deviations along `directions` and commands grow over part `k`; commands are those that `held` makes of `v`.
    fn grown(
        &self,
        k: usize,
        (x, next): (&[f64], &[f64]),
        (directions, v): (&[Direction], &[f64]),
        held: &dyn Fn(&[Early]) -> Vec<Early>,
    ) -> Result<[DMatrix<f64>; 2], Fault> {
        let l = self.robot.layout();
        let (_, all) = self.columns((x, directions), (v, v.len()), &|x, v| {
            let end = self.fly(k, x, &held(v), &mut |_| ())?;
            let off = apart(l, next, &end);
            Ok(directions.iter().map(|direction| Section::along(direction, &off)).collect())
        })?;
        let n = directions.len();
        Ok([all.columns(0, n).into(), all.columns(n, v.len()).into()])
    }

    /// The feedback about the plan by all commands that are fed back; the states of the air are not measured.
    fn gains(&self, nodes: &[Vec<f64>], commands: &[Vec<f64>]) -> Result<Option<Vec<DMatrix<f64>>>, Fault> {
        let l = self.robot.layout();
        let (n, inputs) = (l.len - 1, self.approach.inputs);
        let each = alone(0..n);
        let of = |k: usize, command: &Vec<f64>| {
            let v: Vec<f64> = inputs.iter().map(|i| command[*i]).collect();
            let held = |v: &[Early]| {
                let mut held: Vec<Early> = command.iter().map(|value| Early::constant(*value)).collect();
                inputs.iter().zip(v).for_each(|(i, v)| held[*i] = *v);
                held
            };
            self.grown(k, (&nodes[k], &nodes[k + 1]), (&each, &v), &held)
        };
        let all: Vec<_> = parallel::map(commands, of).into_iter().collect::<Result<_, Fault>>()?;
        let costs = |sizes: [f64; 4]| {
            let of = |i: usize| if i < BODY { sizes[i / 3].powi(-2) } else { 0.0 };
            DMatrix::from_diagonal(&DVector::from_iterator(n, (0..n).map(of)))
        };
        let limits: Vec<f64> = inputs.iter().map(|i| self.robot.inputs()[*i].high).collect();
        let (q, r) = (costs(ON_THE_WAY), effort(&limits) * COMMAND);
        let (mut p, mut gains) = (costs(AT_THE_END), Vec::new());
        for [a, b] in all.iter().rev() {
            let Some((mut gain, before)) = back(a, b, &q, &r, &p) else { return Ok(None) };
            (l.aero - 1..n).for_each(|column| gain.column_mut(column).fill(0.0));
            gains.push(gain);
            p = before;
        }
        gains.reverse();
        gains.extend(gains.last().cloned());
        Ok(Some(gains))
    }
}

/// Directions of flight in the plane of symmetry, both sides alike, among what deviates.
fn symmetric(robot: &Robot) -> Result<Vec<Direction>, Error> {
    let l = robot.layout();
    let mirror = robot.pairs()?;
    let mut stands = vec![0; l.len - l.structure];
    mirror.expand_states(&mirror.states, &mut stands);
    let own = (0..stands.len()).filter(|i| stands[*i] == *i);
    let pair = |i: usize| (i..stands.len()).filter(|j| stands[*j] == i).map(|j| (BODY + j, 1.0)).collect();
    let body = [0, 2, 4, 6, 8, 10].map(|i| vec![(i, 1.0)]);
    Ok(body.into_iter().chain(own.map(pair)).collect())
}

impl Parts for Problem<'_> {
    fn parts(&self) -> usize {
        self.parts
    }

    fn limits(&self) -> [&DVector<f64>; 2] {
        [&self.low, &self.high]
    }

    fn effort(&self) -> &DMatrix<f64> {
        &self.effort
    }

    fn next(&self, k: usize, s: &[f64], v: &DVector<f64>) -> Option<Vec<f64>> {
        self.fly(k, s, &self.held(v.as_slice()), &mut |_| ()).ok()
    }

    fn apart(&self, s: &[f64], from: &[f64]) -> DVector<f64> {
        let off = apart(self.robot.layout(), from, s);
        let along = |direction: &Direction| Section::along(direction, &off);
        DVector::from_iterator(self.directions.len(), self.directions.iter().map(along))
    }

    fn linear(&self, k: usize, s: &[f64], v: &DVector<f64>) -> Result<[DMatrix<f64>; 2], Fault> {
        let next = self.fly(k, s, &self.held(v.as_slice()), &mut |_| ())?;
        let held = |v: &[Early]| self.held(v);
        self.grown(k, (s, &next), (&self.directions, v.as_slice()), &held)
    }

    fn cost(&self, k: usize, s: &[f64]) -> f64 {
        self.missed(k, s).iter().map(|missed| missed * missed).sum()
    }

    fn quadratic(&self, k: usize, s: &[f64]) -> Option<Quadratic> {
        let of = |x: &[Early], _: &[Early]| Ok(self.missed(k, x));
        let (missed, by) = self.columns((s, &self.directions), (&[], 0), &of).ok()?;
        Some((by.transpose() * &by, by.transpose() * DVector::from_vec(missed)))
    }
}
