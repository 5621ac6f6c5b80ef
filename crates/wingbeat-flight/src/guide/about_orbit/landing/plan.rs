//! The plan of a landing on the whole model, and the feedback about it.

use super::super::ddp::{self, Commanded, Parts, Quadratic, TrialPlan, Until};
use super::super::feedback::{back, effort};
use super::{Approach, LandingSpec, PlannedLanding};
use crate::orbit::{Direction, OrbitSection, alone, fly_held};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;
use wingbeat_math::parallel;
use wingbeat_math::{Error, Quat, Scalar, Vec3};
use wingbeat_ocp::plant::{Channel, Early, Fault, Plant};
use wingbeat_robot::{Layout, Perch, Robot};

/// What counts as one at the end of the plan: velocity of the claw, m/s, pitch, rad, its rate, rad/s, height off the perch, m, and place
/// along the way off that of the first plan, m. *Choices.*
const END: [f64; 6] = [0.15, 0.15, 5.0 * PI / 180.0, 5.0, 0.01, 0.01];
/// Cost of a full command over a part. *Choice.*
const EFFORT: f64 = 0.01;
/// Clearance below which the plan pays, and what counts as one below it, m. *Choices.*
const CLEAR: [f64; 2] = [0.008, 1.0 / 60.0];
/// Room beside the perch below which the plan pays, and what counts as one below it, m; instants to a part at which it is looked at.
/// *Choices.*
const ROOM: [f64; 2] = [0.02, 0.02];
const LOOKS: usize = 5;
/// Steps by which the plan is led from level flight to the landing.
const STAGES: usize = 3;
/// Share of the cost that one of so many iterations on end must save for another one; on the way to the landing each must. *Choices.*
const SAVED: f64 = 1e-3;
const ON_END: usize = 3;
/// Deviations that cost as much as each other in the feedback: of place, m, attitude, rad, velocity, m/s, and rate, rad/s, on the way and
/// at the end; and what a full command costs over a part. *Fitted* to flights in gusts and air that the plan does not know.
const ON_THE_WAY: [f64; 4] = [0.03, 30.0 * PI / 180.0, 0.6, 20.0];
const AT_THE_END: [f64; 4] = [0.01, 5.0 * PI / 180.0, 0.05, 5.0];
const COMMAND: f64 = 0.1;
/// Numbers of the body among what deviates: place, rotation, velocity, rate.
const BODY: usize = 12;

/// What is differentiated by state and commands.
type Differentiated<'a> = dyn Fn(&[Early], &[Early]) -> Result<Vec<Early>, Fault> + 'a;

/// Costs and limits of a plan.
struct LandingProblem<'a> {
    approach: &'a Approach<'a>,
    robot: &'a Robot,
    directions: Vec<Direction>,
    commanded: Commanded,
    /// Commands of the orbit.
    level: Vec<f64>,
    /// What is asked at the end, in the order of [`END`]; nothing of what is not finite.
    asked: [f64; 6],
    /// The perch that wings and body are to pass, once its place along the way is known.
    beside: Option<Perch>,
}

impl PlannedLanding {
    /// Of the approach, from the state `begin`, in the units of the states, on; near to a plan under another law, where there is one, and to where that ends.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the robot cannot fly it so.
    pub fn new(
        spec: &LandingSpec,
        approach: &Approach,
        begin: &[f64],
        near: Option<&Self>,
    ) -> Result<Self, Error> {
        let broken = |fault: Fault| Error::invalid("cycles", fault, "a landing that the model can fly");
        let mut problem = LandingProblem::new(spec, approach)?;
        let flown = match near {
            None => problem.solve(begin, spec.iterations),
            Some(near) => problem.solve_near(near, begin, spec.iterations),
        };
        let flown = flown.map_err(broken)?;
        let layout = *problem.robot.layout();
        let end = &flown.nodes[problem.commanded.parts];
        let [vx, vz, pitch, ..] = problem.ends(end);
        let (speed, over) = (vx.hypot(vz), (pitch + PI).abs());
        if !(speed <= spec.speed_within_m_s && over.to_degrees() <= spec.pitch_within_deg) {
            let law = problem.robot.surfaces().next().map_or("", |(_, aero)| aero.law().name());
            let allowed = format!(
                "a landing of which the robot is capable: with these cycles it gets to {speed:.2} m/s, nose up by {:.0} deg under law {law}",
                -pitch.to_degrees()
            );
            return Err(Error::invalid("cycles", spec.cycles, allowed));
        }
        let commands: Vec<Vec<f64>> = flown.commands.iter().map(|v| problem.held(v.as_slice())).collect();
        let mut steps = vec![begin.to_vec()];
        for (k, held) in commands.iter().enumerate() {
            problem.fly(k, &flown.nodes[k], held, &mut |x: &[f64]| steps.push(x.to_vec())).map_err(broken)?;
        }
        let gains = problem.gains(&flown.nodes, &commands).map_err(broken)?;
        let gains = gains.ok_or_else(|| {
            Error::invalid("cycles", spec.cycles, "a landing about which the feedback has a solution")
        })?;
        let end = claw_of(&layout, end, approach.perch.claw());
        Ok(Self { steps, commands, gains, layout, end, saved: flown.saved, over })
    }

    /// Speed of the claw at the end, m/s.
    pub fn speed(&self) -> f64 {
        self.end[1].norm()
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
pub(super) fn apart<S: Scalar>(l: &Layout, x0: &[f64], x: &[S]) -> Vec<S> {
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
pub(super) fn claw_of<S: Scalar>(l: &Layout, x: &[S], claw: Vec3) -> [Vec3<S>; 2] {
    let attitude = Quat::from_wxyz(&x[l.attitude..]).matrix();
    let arm: Vec3<S> = Vec3::constant(claw);
    let swept = attitude * Vec3::from_slice(&x[l.rate..]).cross(arm);
    [Vec3::from_slice(&x[l.position..]) + attitude * arm, Vec3::from_slice(&x[l.velocity..]) + swept]
}

impl<'a> LandingProblem<'a> {
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
        let ranges = [of(|channel| channel.low), of(|channel| channel.high)];
        let cost_of = |pair: &Direction| EFFORT * (pair[0].1 / robot.inputs()[pair[0].0].high).powi(2);
        let costs = DVector::from_iterator(pairs.len(), pairs.iter().map(cost_of));
        Ok(Self {
            approach,
            robot,
            directions: symmetric(robot)?,
            commanded: Commanded::new(spec.cycles * cycle.parts(), ranges, &costs),
            level: level.clone(),
            asked: [0.0; 6],
            beside: None,
        })
    }

    /// Equation: guide.landing_plan
    /// `min sum u'Ru + sum ((v_claw, pitch + pi, pitch rate, place off the perch)/END)^2 + sum (max(0, CLEAR - clearance))^2
    /// + sum (max(0, ROOM - distance of body and wings from the perch))^2, u within its limits`
    /// Source: Tassa, Mansard & Todorov 2014, ICRA; bats on a ceiling: Riskin et al. 2009, J. Exp. Biol. 212.
    /// Test: `a_landing_ends_upside_down_at_the_perch`.
    ///
    /// From the level flight on, by ends on the way to the landing; the last one, whose place along the way is then kept, past the perch.
    fn solve(&mut self, begin: &[f64], iterations: usize) -> Result<TrialPlan, Fault> {
        let [vx, vz, pitch, ..] = self.ends(begin);
        let mut commands = vec![DVector::zeros(self.commanded.low.len()); self.commanded.parts];
        let mut flown = None;
        for stage in 1..=STAGES {
            let left = 1.0 - stage as f64 / STAGES as f64;
            let last = stage == STAGES;
            let height = if last { self.approach.perch.place()[2] } else { f64::NAN };
            self.asked = [left * vx, left * vz, left * pitch - (1.0 - left) * PI, 0.0, height, f64::NAN];
            let until = Until { iterations, saved: SAVED, on_end: if last { ON_END } else { 1 } };
            let found = ddp::solve(self, begin, commands, until, EFFORT)?;
            commands = found.commands.clone();
            flown = Some(found);
        }
        let flown = flown.ok_or(Fault::NotFinite { state: 0, time: 0.0 })?;
        self.ends_at(self.ends(&flown.nodes[self.commanded.parts])[5]);
        ddp::solve(self, begin, commands, Until { iterations, saved: SAVED, on_end: ON_END }, EFFORT)
    }

    /// Asks for the landing with the claw at the perch, which stands `along` m along the way.
    fn ends_at(&mut self, along: f64) {
        let height = self.approach.perch.place()[2];
        self.asked = [0.0, 0.0, -PI, 0.0, height, along];
        self.beside = Some(self.approach.perch.at(Vec3::new(along, 0.0, height)));
    }

    /// As [`solve`](Self::solve), from the commands on by which the feedback of the plan `near` would land.
    fn solve_near(
        &mut self,
        near: &PlannedLanding,
        begin: &[f64],
        iterations: usize,
    ) -> Result<TrialPlan, Fault> {
        let air = near.layout.aero - 1;
        let (mut commands, mut x) = (Vec::with_capacity(self.commanded.parts), begin.to_vec());
        let steps = self.approach.cycle.steps() / self.approach.cycle.parts();
        for (k, planned) in near.commands.iter().enumerate() {
            let off = apart(&near.layout, &near.steps[k * steps][..=air], &x[..=air]);
            let v = self
                .approach
                .pairs
                .iter()
                .zip(self.commanded.low.iter().zip(self.commanded.high.iter()))
                .map(|(pair, (low, high))| {
                    let (input, share) = pair[0];
                    let row = self.approach.inputs.iter().position(|i| *i == input);
                    let fed = |row| {
                        off.iter().enumerate().map(|(j, off)| near.gains[k][(row, j)] * off).sum::<f64>()
                    };
                    ((planned[input] - row.map_or(0.0, fed) - self.level[input]) / share).clamp(*low, *high)
                });
            let v = DVector::from_iterator(self.commanded.low.len(), v);
            x = self.fly(k, &x, &self.held(v.as_slice()), &mut |_| ())?;
            commands.push(v);
        }
        self.ends_at(near.end[0][0]);
        ddp::solve(self, begin, commands, Until { iterations, saved: SAVED, on_end: ON_END }, EFFORT)
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

    /// Velocity of the claw ahead and up, pitch beyond half a turn too, its rate, height of the claw, its place along the way.
    fn ends<S: Scalar>(&self, x: &[S]) -> [S; 6] {
        let l = self.robot.layout();
        let [place, velocity] = claw_of(l, x, self.approach.perch.claw());
        let pitch = x[l.attitude + 2].atan2(x[l.attitude]) * 2.0;
        [velocity[0], velocity[2], pitch, x[l.rate + 1], place[2], place[0]]
    }

    /// What counts at the end of the plan, or before part `k`: its squares are the cost.
    fn missed<S: Scalar>(&self, k: usize, x: &[S]) -> Vec<S> {
        let mut missed = Vec::new();
        if k == self.commanded.parts {
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
        if let Some(perch) = &self.beside
            && let Ok(crowded) = self.crowded(k, x, perch)
        {
            missed.extend(crowded);
        }
        missed
    }

    /// How much room beside the `perch` is missing about the begin of part `k`, up to half a part before and after it, over what counts as
    /// one. The body moves on as fast as it does then, and so do the elements; the joints are those of the gait.
    fn crowded<S: Scalar>(&self, k: usize, x: &[S], perch: &Perch) -> Result<Vec<S>, Fault> {
        let l = self.robot.layout();
        let parts = self.commanded.parts;
        let part = self.approach.cycle.duration(1.0) / self.approach.cycle.parts() as f64;
        let look = |i: usize| ((i as f64 + 0.5) / LOOKS as f64 - 0.5) * part;
        let within = |by: &f64| !(k == parts && *by > 1e-9 || k == 0 && *by < -1e-9);
        let room = |by: f64| {
            let moved = self.moved_on(l, x, by);
            let away = self.robot.clearance_from(perch, S::from(k as f64 * part + by), &moved)?;
            Ok(away.if_below(S::from(ROOM[0]), -away + ROOM[0], S::ZERO) * (1.0 / ROOM[1]))
        };
        (0..LOOKS).map(look).filter(within).map(room).collect()
    }

    /// The state `x` up to those of the air after `by` s at the rates that it has.
    fn moved_on<S: Scalar>(&self, l: &Layout, x: &[S], by: f64) -> Vec<S> {
        let mut moved = x[..l.aero].to_vec();
        let elements = self.robot.response().elements();
        (0..3).for_each(|i| moved[l.position + i] += x[l.velocity + i] * by);
        (l.structure..l.structure + elements).for_each(|i| moved[i] += x[i + elements] * by);
        let turn: Vec3<S> = Vec3::from_slice(&x[l.rate..]);
        let turned = Quat::from_wxyz(&x[l.attitude..]) * Quat::exp(turn * S::from(by));
        turned.store_wxyz(&mut moved[l.attitude..]);
        moved
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
            Ok(directions.iter().map(|direction| OrbitSection::along(direction, &off)).collect())
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

impl Parts for LandingProblem<'_> {
    fn commanded(&self) -> &Commanded {
        &self.commanded
    }

    fn next(&self, k: usize, s: &[f64], v: &DVector<f64>) -> Option<Vec<f64>> {
        self.fly(k, s, &self.held(v.as_slice()), &mut |_| ()).ok()
    }

    fn apart(&self, s: &[f64], from: &[f64]) -> DVector<f64> {
        let off = apart(self.robot.layout(), from, s);
        let along = |direction: &Direction| OrbitSection::along(direction, &off);
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
