//! A dive: from a level orbit the nose goes down and the robot pulls out to the same orbit below, by commands that are planned on the
//! whole model before the flight, and feedback about the plan.

use super::family::Asked;
use super::feedback::{DEVIATIONS, Feedback, INTEGRAL, back, costs_of, effort, measured, with_integral};
use super::spec::OrbitWeights;
use crate::orbit::{Cycle, Deviations, Direction, Interval, Point, Section, alone, fly_part, interval};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::interpolation::lerp;
use wingbeat_math::parallel;
use wingbeat_math::range::{Range, ranges};
use wingbeat_ocp::plant::{Channel, Fault};

/// Error of the nose at its lowest that costs as much as a full command, rad. *Choice.*
const NOSE: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// Cost of the planned commands over that of the controller's: with less they are rough, with more the nose falls short. *Choice.*
const EFFORT: f64 = 0.1;
/// Most iterations of the plan, the share of its cost that the last must still save, and shares of a step that are tried.
const ITERATIONS: usize = 60;
const SAVED: f64 = 1e-3;
const SHARES: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.03, 0.01];
/// Damping of a step over the cost of the commands: least, first, and the most that is tried.
const DAMPING: [f64; 3] = [1e-6, 1e-4, 1e6];
/// What the nose may be off what is asked, rad.
const SHORT: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// Nose down from level flight, and the pull-out to level flight below.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct DiveSpec {
    /// When it is commanded, s; it begins with the next cycle of the gait.
    pub start_s: f64,
    /// Pitch half way through, deg; positive is nose down. In the mean over a cycle the nose is less far down, by the swing of a stroke.
    pub nose_down_deg: f64,
    /// Cycles of the gait until the flight is level again.
    pub cycles: usize,
    /// Share of the range of each command that the plan may use; the rest is left to the feedback.
    #[serde(default = "most")]
    pub share: f64,
}

fn most() -> f64 {
    0.9
}

ranges!(DiveSpec {
    start_s: Range::NOT_NEGATIVE,
    nose_down_deg: Range::between(1.0, 75.0),
    cycles: Range::between(2.0, 40.0),
    share: Range::between(0.1, 1.0),
});

/// A planned dive and the feedback about it, by parts of a cycle.
pub(super) struct Dive {
    /// When it is commanded, s.
    pub start_s: f64,
    /// Cycles that it takes.
    pub cycles: f64,
    /// What deviates at every step.
    steps: Vec<Vec<f64>>,
    /// Commands of every part.
    commands: Vec<Vec<f64>>,
    /// Feedback at the begin of every part, and at the end.
    gains: Vec<DMatrix<f64>>,
    /// Share of its cost that the last iteration of the plan saved.
    pub saved: f64,
    /// Height of the level flight after it above that before it, m.
    pub climb: f64,
}

/// What a dive is planned with.
pub(super) struct Level<'a> {
    pub cycle: &'a Cycle<'a>,
    pub deviations: &'a Deviations,
    /// The level orbit, and what deviates at its phase 0.
    pub point: &'a Point,
    pub begin: &'a [f64],
    pub feedback: &'a Feedback,
    pub weights: &'a OrbitWeights,
    /// The commands that act on both sides alike, and each that is fed back.
    pub pairs: &'a [Direction],
    pub inputs: &'a [usize],
}

/// A plan under way: what deviates at the begin of every part and at the end, the commands of every part beside those of the orbit, its
/// cost.
struct Flown {
    nodes: Vec<Vec<f64>>,
    commands: Vec<DVector<f64>>,
    cost: f64,
}

/// Costs and limits of a plan.
struct Problem<'a> {
    level: &'a Level<'a>,
    channels: &'a [Channel],
    directions: Vec<Direction>,
    parts: usize,
    /// Pitch asked half way, rad.
    nose: f64,
    effort: DMatrix<f64>,
    /// Cost of what deviates from the level orbit at the end, at any height.
    end: DMatrix<f64>,
    low: DVector<f64>,
    high: DVector<f64>,
}

impl Dive {
    /// Plans the dive `spec`, and the feedback about it.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the robot cannot fly it so.
    pub fn plan(spec: &DiveSpec, level: &Level, channels: &[Channel]) -> Result<Self, Error> {
        let cost = level.feedback.cost(0.0).root;
        let cost = &cost * cost.transpose();
        let problem = Problem::new(spec, level, channels, &cost)?;
        let broken = |fault: Fault| Error::invalid("nose_down_deg", fault, "a dive that the model can fly");
        let (flown, saved) = problem.solve().map_err(broken)?;
        let reached = flown.nodes[problem.parts / 2][Deviations::PITCH];
        if !((reached - problem.nose).abs() <= SHORT) {
            let allowed = format!(
                "a dive of which the robot is capable: with these cycles its nose gets to {:.1} deg",
                reached.to_degrees()
            );
            return Err(Error::invalid("nose_down_deg", spec.nose_down_deg, allowed));
        }
        let off = problem.off(&flown.nodes[problem.parts]);
        let climb = (&problem.raw(&cost) * &off)[0] / problem.raw(&cost)[(0, 0)];
        let mut commands: Vec<Vec<f64>> = flown.commands.iter().map(|v| problem.held(v)).collect();
        let mut steps = vec![flown.nodes[0].clone()];
        for (k, held) in commands.iter().enumerate() {
            problem.fly(&flown.nodes[k], k, held, &mut |s| steps.push(s)).map_err(broken)?;
        }
        let gains = problem.gains(&flown.nodes, &commands, cost).map_err(broken)?;
        let gains = gains.ok_or_else(|| {
            Error::invalid("weights", "given", "weights with which the feedback of the dive has a solution")
        })?;
        if let Some((input, value)) = level.cycle.pacing(level.point.pace) {
            commands.iter_mut().for_each(|held| held[input] = value);
        }
        let (start_s, cycles) = (spec.start_s, spec.cycles as f64);
        Ok(Self { start_s, cycles, steps, commands, gains, saved, climb })
    }

    /// Changes what is `asked` of the level flight to what the dive asks `since` cycles after its begin, of commands the mean over the
    /// `coming` cycles; after it to the level flight below.
    pub fn ask(&self, since: f64, coming: f64, asked: &mut Asked) {
        if since >= self.cycles {
            asked.numbers[Deviations::HEIGHT] += self.climb;
        } else if since > 0.0 {
            (asked.numbers, asked.commands) = self.at(since, coming);
        }
    }

    fn at(&self, since: f64, coming: f64) -> (Vec<f64>, Vec<f64>) {
        let last = self.steps.len() - 1;
        let at = (since / self.cycles * last as f64).clamp(0.0, last as f64);
        let i = (at as usize).min(last - 1);
        let numbers = self.steps[i].iter().zip(&self.steps[i + 1]);
        let numbers = numbers.map(|(one, other)| lerp(*one, *other, at - i as f64)).collect();
        let parts = self.commands.len();
        let per = parts as f64 / self.cycles;
        let (from, to) = (since * per, (since + coming) * per);
        let mut mean = vec![0.0; self.commands[0].len()];
        for k in from as usize..=(to as usize) {
            let share = ((to.min((k + 1) as f64) - from.max(k as f64)) / (to - from)).max(0.0);
            let part = &self.commands[k.min(parts - 1)];
            mean.iter_mut().zip(part).for_each(|(mean, command)| *mean += share * command);
        }
        (numbers, mean)
    }

    /// The feedback there.
    pub fn gain(&self, since: f64) -> DMatrix<f64> {
        let last = self.gains.len() - 1;
        let at = (since / self.cycles * last as f64).clamp(0.0, last as f64);
        let k = (at as usize).min(last - 1);
        let share = at - k as f64;
        &self.gains[k] * (1.0 - share) + &self.gains[k + 1] * share
    }
}

impl<'a> Problem<'a> {
    fn new(
        spec: &DiveSpec,
        level: &'a Level<'a>,
        channels: &'a [Channel],
        cost: &DMatrix<f64>,
    ) -> Result<Self, Error> {
        let directions = level.deviations.symmetric(level.cycle)?;
        let m = level.pairs.len();
        let of = |end: fn(&Channel) -> f64| {
            let range = |pair: &Direction| {
                spec.share * end(&channels[pair[0].0]) / pair[0].1 - level.point.inputs[pair[0].0] / pair[0].1
            };
            DVector::from_iterator(m, level.pairs.iter().map(range))
        };
        let (low, high) = (of(|channel| channel.low), of(|channel| channel.high));
        let cost_of = |pair: &Direction| -> f64 {
            pair.iter().map(|(i, share)| (share / channels[*i].high).powi(2)).sum::<f64>() * EFFORT
        };
        let mut problem = Self {
            level,
            channels,
            directions,
            parts: spec.cycles * level.cycle.parts(),
            nose: spec.nose_down_deg.to_radians(),
            effort: DMatrix::from_diagonal(&DVector::from_iterator(m, level.pairs.iter().map(cost_of))),
            end: DMatrix::zeros(0, 0),
            low: low.map(|v| v.min(0.0)),
            high: high.map(|v| v.max(0.0)),
        };
        // What no height can lessen: the least over it of the quadratic form.
        let raw = problem.raw(cost);
        let height = raw.column(Deviations::HEIGHT);
        problem.end = &raw - height * height.transpose() / raw[(0, 0)];
        Ok(problem)
    }

    /// The cost of deviations along the directions that are alike on both sides.
    fn raw(&self, cost: &DMatrix<f64>) -> DMatrix<f64> {
        let mut along = DMatrix::zeros(cost.nrows(), self.directions.len());
        for (j, direction) in self.directions.iter().enumerate() {
            direction.iter().for_each(|(i, share)| along[(DEVIATIONS + i, j)] = *share);
        }
        along.transpose() * cost * along
    }

    /// What `s` is off the level orbit at phase 0.
    fn off(&self, s: &[f64]) -> DVector<f64> {
        self.apart(s, self.level.begin)
    }

    fn apart(&self, s: &[f64], from: &[f64]) -> DVector<f64> {
        let along = |d: &Direction| Section::along(d, s) - Section::along(d, from);
        DVector::from_iterator(self.directions.len(), self.directions.iter().map(along))
    }

    /// Which part of the cycle part `k` of the dive is, and of how many.
    fn part(&self, k: usize) -> [usize; 2] {
        let parts = self.level.cycle.parts();
        [k % parts, parts]
    }

    /// All commands for those `beside` the orbit's.
    fn held(&self, beside: &DVector<f64>) -> Vec<f64> {
        let mut held = self.level.point.inputs.clone();
        for (pair, step) in self.level.pairs.iter().zip(beside.iter()) {
            pair.iter().for_each(|(i, share)| held[*i] += share * step);
        }
        held
    }

    /// Flies part `k` of the plan; `each` takes what deviates after every step.
    fn fly(
        &self,
        s: &[f64],
        k: usize,
        held: &[f64],
        each: &mut dyn FnMut(Vec<f64>),
    ) -> Result<Vec<f64>, Fault> {
        let Level { cycle, deviations, point, .. } = self.level;
        let mut of = |x: &[f64]| {
            let mut s = vec![0.0; deviations.len()];
            deviations.of(x, &mut s);
            each(s);
        };
        Ok(fly_part(cycle, deviations, s, point.pace, held, self.part(k), &mut of)?.0)
    }

    /// The flight by `command` of part and what deviates at its begin; none where the model breaks down.
    fn roll(&self, mut command: impl FnMut(usize, &[f64]) -> DVector<f64>) -> Option<Flown> {
        let mut nodes = vec![self.level.begin.to_vec()];
        let mut commands = Vec::with_capacity(self.parts);
        let mut cost = 0.0;
        for k in 0..self.parts {
            let s = &nodes[k];
            let v = command(k, s);
            cost += v.dot(&(&self.effort * &v));
            let next = self.fly(s, k, &self.held(&v), &mut |_| ()).ok()?;
            nodes.push(next);
            commands.push(v);
        }
        cost += ((nodes[self.parts / 2][Deviations::PITCH] - self.nose) / NOSE).powi(2);
        let off = self.off(&nodes[self.parts]);
        cost += off.dot(&(&self.end * &off));
        cost.is_finite().then_some(Flown { nodes, commands, cost })
    }

    /// Equation: guide.dive_plan
    /// `min sum u'Ru + ((pitch(half) - asked)/NOSE)^2 + min_h d'P d, d = s(end) - level - h, u within its limits`
    /// Source: Tassa, Mansard & Todorov 2014, ICRA: differential dynamic programming with limits; steps of Gauss and Newton (Li & Todorov 2004).
    /// Test: `a_dive_pulls_out_within_its_height`.
    ///
    /// Improves the level flight step by step: the model about the present plan is linear, the cost quadratic, and backwards in time
    /// every part has its best command within the limits and its feedback. Beside the plan stands the share of its cost that the last
    /// iteration saved: no more than `SAVED` unless the iterations ran out.
    fn solve(&self) -> Result<(Flown, f64), Fault> {
        let still = DVector::zeros(self.low.len());
        let none = Fault::NotFinite { state: 0, time: 0.0 };
        let mut best = self.roll(|_, _| still.clone()).ok_or(none)?;
        let (mut damping, mut saved) = (DAMPING[0], f64::INFINITY);
        for _ in 0..ITERATIONS {
            let all = self.linear(
                &best.nodes,
                |k| self.held(&best.commands[k]),
                &self.directions,
                self.level.pairs,
            )?;
            let better = loop {
                let found =
                    self.backward(&all, &best, damping).and_then(|policy| self.forward(&best, &policy));
                if found.is_some() || damping > DAMPING[2] {
                    break found;
                }
                damping = (damping * 10.0).max(DAMPING[1]);
            };
            let Some(better) = better else {
                saved = 0.0;
                break;
            };
            damping = (damping / 5.0).max(DAMPING[0]);
            saved = (best.cost - better.cost) / better.cost;
            best = better;
            if saved < SAVED {
                break;
            }
        }
        Ok((best, saved))
    }

    /// How deviations grow over every part.
    fn linear(
        &self,
        nodes: &[Vec<f64>],
        held: impl Fn(usize) -> Vec<f64> + Sync,
        directions: &[Direction],
        inputs: &[Direction],
    ) -> Result<Vec<Interval>, Fault> {
        let Level { cycle, deviations, point, .. } = self.level;
        let of = |k: usize, s: &Vec<f64>| {
            let part = self.part(k);
            Ok(interval(cycle, deviations, s, (point.pace, &held(k)), part, [directions, inputs])?.1)
        };
        parallel::map(&nodes[..self.parts], of).into_iter().collect()
    }

    /// For every part the change of its command and its feedback; none where the damping is too little.
    fn backward(
        &self,
        all: &[Interval],
        of: &Flown,
        damping: f64,
    ) -> Option<Vec<(DVector<f64>, DMatrix<f64>)>> {
        let off = self.off(&of.nodes[self.parts]);
        let (mut p, mut g) = (self.end.clone(), &self.end * off);
        let pitch = self.directions.iter().position(|d| d[0].0 == Deviations::PITCH)?;
        let mut policy = Vec::with_capacity(self.parts);
        for k in (0..self.parts).rev() {
            let (a, b, u) = (&all[k].a, &all[k].b, &of.commands[k]);
            let pb = &p * b;
            let curved = b.transpose() * &pb + &self.effort * (1.0 + damping / EFFORT);
            let slope = &self.effort * u + b.transpose() * &g;
            let cross = pb.transpose() * a;
            let (step, free) = boxed(&curved, &slope, &(&self.low - u), &(&self.high - u))?;
            let feedback = -masked(&curved, &free).cholesky()?.solve(&cross_of(&cross, &free));
            g = a.transpose() * &g
                + feedback.transpose() * (&curved * &step + &slope)
                + cross.transpose() * &step;
            p = a.transpose() * &p * a
                + feedback.transpose() * (&curved * &feedback + &cross)
                + cross.transpose() * &feedback;
            p = (&p + p.transpose()) * 0.5;
            if k == self.parts / 2 {
                p[(pitch, pitch)] += NOSE.powi(-2);
                g[pitch] += (of.nodes[k][Deviations::PITCH] - self.nose) * NOSE.powi(-2);
            }
            policy.push((step, feedback));
        }
        policy.reverse();
        Some(policy)
    }

    /// The flight by `policy` about the plan `of`, by the first share of its steps that costs less.
    fn forward(&self, of: &Flown, policy: &[(DVector<f64>, DMatrix<f64>)]) -> Option<Flown> {
        let by = |share: f64| {
            let flown = self.roll(|k, s| {
                let (step, feedback) = &policy[k];
                let v = &of.commands[k] + step * share + feedback * self.apart(s, &of.nodes[k]);
                v.sup(&self.low).inf(&self.high)
            });
            flown.filter(|flown| flown.cost < of.cost)
        };
        SHARES.into_iter().find_map(by)
    }

    /// The feedback about the plan by all commands that are fed back, backwards from the `cost` of what deviates at its end.
    fn gains(
        &self,
        nodes: &[Vec<f64>],
        commands: &[Vec<f64>],
        cost: DMatrix<f64>,
    ) -> Result<Option<Vec<DMatrix<f64>>>, Fault> {
        let level = self.level;
        let (each, inputs) = (alone(0..level.deviations.len()), alone(level.inputs.iter().copied()));
        let all = self.linear(nodes, |k| commands[k].clone(), &each, &inputs)?;
        let limits: Vec<f64> = level.inputs.iter().map(|i| self.channels[*i].high).collect();
        let (n, length) = (cost.nrows(), level.cycle.duration(level.point.pace) / level.cycle.parts() as f64);
        let (q, r) = (costs_of(level.weights, n), effort(&limits));
        let (mut p, mut gains) = (cost, vec![level.feedback.at(0.0)]);
        debug_assert_eq!(INTEGRAL + 1, DEVIATIONS);
        for over in all.iter().rev() {
            let (a, b) = with_integral(over, length, n);
            let Some((mut gain, before)) = back(&a, &b, &q, &r, &p) else { return Ok(None) };
            measured(&mut gain, level.cycle.section().len());
            gains.push(gain);
            p = before;
        }
        gains.reverse();
        Ok(Some(gains))
    }
}

/// Most steps of the quadratic problem of a command: each frees or holds some of a handful.
const BOXED: usize = 30;

/// The least of v'Hv/2 + g'v within limits, and which numbers are at none.
fn boxed(
    h: &DMatrix<f64>,
    g: &DVector<f64>,
    low: &DVector<f64>,
    high: &DVector<f64>,
) -> Option<(DVector<f64>, Vec<bool>)> {
    let mut v = DVector::zeros(g.len()).sup(low).inf(high);
    for _ in 0..BOXED {
        let slope = g + h * &v;
        let free: Vec<bool> = (0..g.len())
            .map(|i| !(v[i] <= low[i] && slope[i] > 0.0 || v[i] >= high[i] && slope[i] < 0.0))
            .collect();
        let step = -masked(h, &free)
            .cholesky()?
            .solve(&DVector::from_fn(g.len(), |i, _| if free[i] { slope[i] } else { 0.0 }));
        let next = (&v + step).sup(low).inf(high);
        let moved = (&next - &v).amax();
        v = next;
        if moved < 1e-12 {
            return Some((v, free));
        }
    }
    let free = (0..g.len()).map(|i| v[i] > low[i] && v[i] < high[i]).collect();
    Some((v, free))
}

/// The matrix of the free numbers, those held standing alone.
fn masked(h: &DMatrix<f64>, free: &[bool]) -> DMatrix<f64> {
    DMatrix::from_fn(h.nrows(), h.ncols(), |i, j| {
        if free[i] && free[j] { h[(i, j)] } else { f64::from(u8::from(i == j)) }
    })
}

/// Rows of the free numbers, zero for those held.
fn cross_of(cross: &DMatrix<f64>, free: &[bool]) -> DMatrix<f64> {
    DMatrix::from_fn(cross.nrows(), cross.ncols(), |i, j| if free[i] { cross[(i, j)] } else { 0.0 })
}
