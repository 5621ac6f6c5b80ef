//! A dive: from a level orbit the nose goes down and the robot pulls out to the same orbit below, by commands that are planned on the
//! whole model before the flight, and feedback about the plan.

use super::ddp::{self, Commanded, Parts, Quadratic, TrialPlan, Until};
use super::family::Asked;
use super::feedback::{DEVIATIONS, Feedback, INTEGRAL, back, costs_of, effort, measured, with_integral};
use super::spec::OrbitWeights;
use crate::orbit::{Cycle, Deviations, Direction, Interval, OrbitSection, Point, alone, fly_part, interval};
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
/// Most iterations of the plan, and the share of its cost that the last must still save.
const ITERATIONS: usize = 60;
const SAVED: f64 = 1e-3;
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

/// Costs and limits of a plan.
struct DiveProblem<'a> {
    level: &'a Level<'a>,
    channels: &'a [Channel],
    directions: Vec<Direction>,
    commanded: Commanded,
    /// Pitch asked half way, rad.
    nose: f64,
    /// Cost of what deviates from the level orbit at the end, at any height.
    end: DMatrix<f64>,
}

impl Dive {
    /// Plans the dive `spec`, and the feedback about it.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the robot cannot fly it so.
    pub fn plan(spec: &DiveSpec, level: &Level, channels: &[Channel]) -> Result<Self, Error> {
        let cost = level.feedback.cost(0.0).root;
        let cost = &cost * cost.transpose();
        let problem = DiveProblem::new(spec, level, channels, &cost)?;
        let broken = |fault: Fault| Error::invalid("nose_down_deg", fault, "a dive that the model can fly");
        let flown = problem.solve().map_err(broken)?;
        let reached = flown.nodes[problem.commanded.parts / 2][Deviations::PITCH];
        if !((reached - problem.nose).abs() <= SHORT) {
            let allowed = format!(
                "a dive of which the robot is capable: with these cycles its nose gets to {:.1} deg",
                reached.to_degrees()
            );
            return Err(Error::invalid("nose_down_deg", spec.nose_down_deg, allowed));
        }
        let off = problem.off(&flown.nodes[problem.commanded.parts]);
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
        Ok(Self { start_s, cycles, steps, commands, gains, saved: flown.saved, climb })
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
        let per = self.commands.len() as f64 / self.cycles;
        let mean = mean_over(&self.commands, [since * per, (since + coming) * per]);
        (numbers, mean)
    }

    /// The feedback `since` cycles after its begin, in the units of commands over those of deviations.
    pub fn gain(&self, since: f64) -> DMatrix<f64> {
        gain_at(&self.gains, since / self.cycles)
    }
}

/// Mean of the `commands` of parts from one to another place among them.
pub(super) fn mean_over(commands: &[Vec<f64>], [from, to]: [f64; 2]) -> Vec<f64> {
    let mut mean = vec![0.0; commands[0].len()];
    for k in from as usize..=(to as usize) {
        let share = ((to.min((k + 1) as f64) - from.max(k as f64)) / (to - from)).max(0.0);
        let part = &commands[k.min(commands.len() - 1)];
        mean.iter_mut().zip(part).for_each(|(mean, command)| *mean += share * command);
    }
    mean
}

/// The feedback at the share `done` of a plan.
pub(super) fn gain_at(gains: &[DMatrix<f64>], done: f64) -> DMatrix<f64> {
    let last = gains.len() - 1;
    let at = (done * last as f64).clamp(0.0, last as f64);
    let k = (at as usize).min(last - 1);
    let share = at - k as f64;
    &gains[k] * (1.0 - share) + &gains[k + 1] * share
}

impl<'a> DiveProblem<'a> {
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
        let ranges = [of(|channel| channel.low), of(|channel| channel.high)];
        let cost_of = |pair: &Direction| -> f64 {
            pair.iter().map(|(i, share)| (share / channels[*i].high).powi(2)).sum::<f64>() * EFFORT
        };
        let costs = DVector::from_iterator(m, level.pairs.iter().map(cost_of));
        let mut problem = Self {
            level,
            channels,
            directions,
            commanded: Commanded::new(spec.cycles * level.cycle.parts(), ranges, &costs),
            nose: spec.nose_down_deg.to_radians(),
            end: DMatrix::zeros(0, 0),
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
        self.between(s, self.level.begin)
    }

    fn between(&self, s: &[f64], from: &[f64]) -> DVector<f64> {
        let along = |d: &Direction| OrbitSection::along(d, s) - OrbitSection::along(d, from);
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

    /// Equation: guide.dive_plan
    /// `min sum u'Ru + ((pitch(half) - asked)/NOSE)^2 + min_h d'P d, d = s(end) - level - h, u within its limits`
    /// Source: Tassa, Mansard & Todorov 2014, ICRA: differential dynamic programming with limits; steps of Gauss and Newton (Li & Todorov 2004).
    /// Test: `a_dive_pulls_out_within_its_height`.
    ///
    /// From the level flight on.
    fn solve(&self) -> Result<TrialPlan, Fault> {
        let still = vec![DVector::zeros(self.commanded.low.len()); self.commanded.parts];
        ddp::solve(
            self,
            self.level.begin,
            still,
            Until { iterations: ITERATIONS, saved: SAVED, on_end: 1 },
            EFFORT,
        )
    }

    /// How deviations grow over every part.
    fn grown(
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
        parallel::map(&nodes[..self.commanded.parts], of).into_iter().collect()
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
        let all = self.grown(nodes, |k| commands[k].clone(), &each, &inputs)?;
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

impl Parts for DiveProblem<'_> {
    fn commanded(&self) -> &Commanded {
        &self.commanded
    }

    fn next(&self, k: usize, s: &[f64], v: &DVector<f64>) -> Option<Vec<f64>> {
        self.fly(s, k, &self.held(v), &mut |_| ()).ok()
    }

    fn apart(&self, s: &[f64], from: &[f64]) -> DVector<f64> {
        self.between(s, from)
    }

    fn linear(&self, k: usize, s: &[f64], v: &DVector<f64>) -> Result<[DMatrix<f64>; 2], Fault> {
        let Level { cycle, deviations, point, pairs, .. } = self.level;
        let held = self.held(v);
        let along = [&self.directions[..], pairs];
        let over = interval(cycle, deviations, s, (point.pace, &held), self.part(k), along)?.1;
        Ok([over.a, over.b])
    }

    fn cost(&self, k: usize, s: &[f64]) -> f64 {
        let nose =
            if k == self.commanded.parts / 2 { (s[Deviations::PITCH] - self.nose) / NOSE } else { 0.0 };
        let off = if k == self.commanded.parts { self.off(s) } else { return nose * nose };
        nose * nose + off.dot(&(&self.end * &off))
    }

    fn quadratic(&self, k: usize, s: &[f64]) -> Option<Quadratic> {
        if k == self.commanded.parts {
            return Some((self.end.clone(), &self.end * self.off(s)));
        }
        let n = self.directions.len();
        let pitch = self.directions.iter().position(|d| d[0].0 == Deviations::PITCH)?;
        (k == self.commanded.parts / 2).then(|| {
            let (mut p, mut g) = (DMatrix::zeros(n, n), DVector::zeros(n));
            p[(pitch, pitch)] = NOSE.powi(-2);
            g[pitch] = (s[Deviations::PITCH] - self.nose) * NOSE.powi(-2);
            (p, g)
        })
    }
}
