//! The periodic gait that needs the least power for a given mean force, planned offline.

use super::roll_in::{clearance_path, limited_clearances};
use super::stand::{Flapping, Stand};
use super::{MAX_INTERVALS, MAX_ITERATIONS, MAX_MESHES, processor_time};
use crate::simulate::{Held, Moment, Sizes, Stepper, System};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use std::time::Duration;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;
use wingbeat_math::{Scalar, pitch_of_nose_up};
use wingbeat_ocp::interior_point::{Options, SolveStatus};
use wingbeat_ocp::plant::{Channel, Fault, Plant};
use wingbeat_ocp::{
    Ends, FREE, Instant, Interpolant, OptimalControl, Optimum, Pass, Progress, Refinement, Scheme, Setup,
    Trajectory, defects, optimise_stage,
};
use wingbeat_robot::body::drive_power;

/// Cycles from rest after which a gait counts as periodic: the slowest lag of a slow wing decays by a third per cycle.
pub const CYCLES: usize = 24;
/// Runge-Kutta steps and samples per cycle of the guess.
const STEPS: usize = 600;
const SAMPLES: usize = 100;
/// Power below which the loss of a joint is rounded off, as a share of the drive power of the robot's own gait.
/// The corner of max(0, -P) is too sharp to be met at once: it is first rounded more, and the solution is the guess.
const ROUNDED: f64 = 0.03;
const ROUNDED_FIRST: f64 = 0.15;
/// Barrier and margin of the problems after the first.
const WARM: [f64; 2] = [1e-3, 1e-5];
/// What is missing of a force, as a share of the one asked for, that is gone at once: a choice.
const NEAR: f64 = 0.1;
/// Share of a longer way that is gone at once, the share below which a step that failed is not halved, and the
/// iterations in which a step succeeds or fails (20 to 130 where it does succeed): choices.
const WAY: f64 = 0.125;
const SHORTEST_WAY: f64 = 0.03;
const STEP_ITERATIONS: usize = 200;
/// Most iterations on a mesh.
const ITERATIONS: usize = 400;
/// Forces and moments are summed in mN and mN m, so that their states are of the order of the others.
const MILLI: f64 = 1e3;

/// Goal and effort of a gait of least power.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct LeastPowerSpec {
    /// Least mean upward force of the air, N; without it that of the robot's own gait.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up_n: Option<f64>,
    /// Least mean forward force of the air, N, drag included; without it that of the robot's own gait.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub forward_n: Option<f64>,
    /// Largest mean pitching moment of the air about the centre of mass, either way, N m; without it any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trim_within_n_m: Option<f64>,
    /// Least clearance between parts, m; without it any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clearance_m: Option<f64>,
    /// Lowest and highest flapping frequency, Hz.
    pub frequency_hz: [f64; 2],
    /// Lowest and highest pitch, deg, positive is nose up; without it that of the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nose_up_deg: Option<[f64; 2]>,
    /// Share of a joint's negative power that is stored and used again: 0 none, 1 all of it.
    #[serde(default)]
    pub storage: f64,
    /// Power counted when every regulator is held at its limit, W; it keeps the commands calm.
    pub effort_w: f64,
    /// Order of the collocation: 4 (Hermite-Simpson) or 6 (Gauss-Lobatto).
    #[serde(default = "fourth")]
    pub order: u8,
    /// Intervals of the first mesh.
    pub intervals: usize,
    /// Most meshes.
    pub meshes: usize,
    /// Largest error of an interval, relative.
    pub tolerance: f64,
    /// Most iterations of the solver, over all meshes: a count that no load of the machine changes.
    #[serde(default = "super::most_iterations")]
    pub iterations: usize,
    /// Most processor time of the plan, s, beside `iterations`; without it any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_limit_s: Option<f64>,
}

fn fourth() -> u8 {
    4
}

ranges!(LeastPowerSpec {
    trim_within_n_m: Range::POSITIVE,
    frequency_hz: Range::POSITIVE,
    nose_up_deg: Range::inside(-80.0, 80.0),
    storage: Range::between(0.0, 1.0),
    effort_w: Range::POSITIVE,
    intervals: Range::between(1.0, MAX_INTERVALS as f64),
    meshes: Range::between(1.0, MAX_MESHES as f64),
    tolerance: Range::POSITIVE,
    iterations: Range::between(1.0, MAX_ITERATIONS as f64),
    time_limit_s: Range::POSITIVE,
});

impl LeastPowerSpec {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        require::finite("up_n", self.up_n.as_slice())?;
        require::finite("forward_n", self.forward_n.as_slice())?;
        require::finite("clearance_m", self.clearance_m.as_slice())?;
        require::range("frequency_hz", self.frequency_hz)?;
        if let Some(pitch) = self.nose_up_deg {
            require::range("nose_up_deg", pitch)?;
        }
        if ![4, 6].contains(&self.order) {
            return Err(Error::invalid("order", self.order, "4 or 6"));
        }
        Ok(())
    }
}

/// Means over a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Means {
    /// Power that the drives give, W ([`drive_power`]).
    pub drive_power_w: f64,
    /// Upward force of the air, N.
    pub up_n: f64,
    /// Forward force of the air, N.
    pub forward_n: f64,
    /// Nose-up moment of the air about the centre of mass, N m.
    pub trim_n_m: f64,
}

/// The periodic gait of least power on a [`Stand`]: the regulators' commands over
/// a cycle, the frequency and the pitch such that
///
/// min f int_0^{1/f} (P_drive + effort mean_i (u_i/limit_i)^2) dt, x(1/f) = x(0),
/// mean force >= the one asked for, commands and displacements within the strokes.
///
/// Equation: guide.least_power
/// `min f int_0^(1/f) P_drive + effort mean_i (u_i/limit_i)^2 dt, x(1/f) = x(0), mean force >= asked`
/// Source: choice; periodic optimal control, Betts 2010, ch. 4.
/// Test: `a_gait_of_least_power_holds_its_force_with_less_power`.
///
/// The state is that of structure and air of one wing, then the running means of
/// drive power (W), upward and forward force (mN) and trim moment (mN m).
#[derive(Clone, Debug)]
pub struct LeastPower<'a> {
    stand: Stand<'a>,
    spec: LeastPowerSpec,
    pitch: [f64; 2],
    half_ranges: Vec<f64>,
    asked: [f64; 2],
    own: Trajectory,
    /// Power below which the loss of a joint is rounded off, W.
    width: f64,
}

impl<'a> LeastPower<'a> {
    /// The problem on `stand`; `pitch` (rad) is that of the robot's own gait.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a setting is out of range or the robot's own gait cannot be computed.
    pub fn new(stand: Stand<'a>, pitch: f64, spec: &LeastPowerSpec) -> Result<Self, Error> {
        spec.check()?;
        limited_clearances(stand.robot(), spec.clearance_m)?;
        let half_ranges = stand.robot().inputs().iter().map(|c| 0.5 * (c.high - c.low)).collect();
        let range = spec.nose_up_deg.map_or([pitch; 2], |[low, high]| [high, low].map(pitch_of_nose_up));
        let mut problem = Self {
            spec: spec.clone(),
            pitch: range,
            half_ranges,
            asked: [0.0; 2],
            own: Trajectory::default(),
            width: 0.0,
            stand,
        };
        let own = Flapping { frequency_hz: problem.stand.robot().frequency_hz(), pitch };
        let broken =
            |fault: Fault| Error::invalid("robot.gait", fault, "a gait that can be flapped on the stand");
        problem.own = problem.cycle(&own).map_err(broken)?;
        let means = problem.own_means();
        problem.width = ROUNDED * means.drive_power_w;
        problem.asked = [spec.up_n.unwrap_or(means.up_n), spec.forward_n.unwrap_or(means.forward_n)];
        Ok(problem)
    }

    /// The stand.
    pub fn stand(&self) -> &Stand<'a> {
        &self.stand
    }
    /// Means of the robot's own gait with resting regulators.
    pub fn own_means(&self) -> Means {
        self.means(&self.own)
    }
    /// Mean upward and forward force asked for, N.
    pub fn asked(&self) -> [f64; 2] {
        self.asked
    }
    /// Frequency and pitch of a trajectory.
    pub fn flapping(&self, trajectory: &Trajectory) -> Flapping {
        flapping(&trajectory.p)
    }
    /// Means at the end of a trajectory.
    pub fn means(&self, trajectory: &Trajectory) -> Means {
        let last = trajectory.x.len() - 1;
        let [drive_power_w, up, forward, trim] = self.sums(&trajectory.x[last]);
        Means { drive_power_w, up_n: up / MILLI, forward_n: forward / MILLI, trim_n_m: trim / MILLI }
    }

    /// Mean drive power of a plan without the rounded corner of its losses, W, by the trapezoid rule.
    ///
    /// # Errors
    /// The [`Fault`] of a state of the plan that the model refuses.
    pub fn unrounded_power(&self, plan: &Interpolant) -> Result<f64, Fault> {
        let n = self.stand.mirror().states.len();
        let (flapping, mut dx) = (self.flapping(&plan.points), vec![0.0; n]);
        let period = 1.0 / flapping.frequency_hz;
        let mut sum = 0.0;
        for k in 0..=STEPS {
            let t = plan.points.t[0] + period * k as f64 / STEPS as f64;
            let (x, u) = plan.at(t);
            let loads = self.stand.evaluate(t, &flapping, &x[..n], &u, &mut dx)?;
            let weight = if k == 0 || k == STEPS { 0.5 } else { 1.0 };
            sum += weight * drive_power(&loads.torques, &loads.joints, self.spec.storage, 0.0);
        }
        Ok(sum / STEPS as f64)
    }

    /// Plans the gait; `observer` sees every iteration and mesh.
    ///
    /// # Errors
    /// The [`Fault`] of the gait that is the guess.
    pub fn plan(&self, observer: &mut dyn FnMut(Progress) -> ControlFlow<()>) -> Result<Optimum, Fault> {
        let mut stages = Stages::new(self.refinement(), observer);
        let guess = self.guess()?;
        let smoother = Self { width: self.width / ROUNDED * ROUNDED_FIRST, ..self.clone() };
        let first = smoother.approach(&guess, &mut stages);
        let planned = match &first.solution {
            Some(guess) if solved(&first) => {
                stages.warm = true;
                stages.solve(self, &guess.points, self.spec.meshes, ITERATIONS)
            }
            _ => first,
        };
        Ok(stages.whole(planned))
    }

    /// The gait on the first mesh. From one that bears half of the forces asked for the solver seldom finds its way at once, so
    /// that these are raised from those of the guess in steps, each the guess of the next. They leave a fifth of the iterations to
    /// the whole, which says what cannot be met.
    fn approach(&self, guess: &Trajectory, stages: &mut Stages) -> Optimum {
        let given = self.means(guess);
        let given = [given.up_n, given.forward_n];
        let far = self.asked.iter().zip(given).any(|(asked, given)| asked - given > NEAR * asked.abs());
        let (mut reached, mut step) = (0.0, if far { WAY } else { 1.0 });
        let mut start = guess.clone();
        loop {
            let last = step < SHORTEST_WAY || 5 * stages.iterations > 4 * self.spec.iterations;
            let share = if last { 1.0 } else { f64::min(reached + step, 1.0) };
            let part = |i: usize| self.asked[i].min(given[i] + share * (self.asked[i] - given[i]));
            let problem = Self { asked: [part(0), part(1)], ..self.clone() };
            let iterations = if last { ITERATIONS } else { STEP_ITERATIONS };
            let optimum = stages.solve(&problem, &start, 1, iterations);
            let found = solved(&optimum);
            if share == 1.0 && (found || last) || stages.is_over(&optimum.status) {
                return optimum;
            }
            match &optimum.solution {
                Some(solution) if found => {
                    (start, reached) = (solution.points.clone(), share);
                    stages.warm = true;
                }
                _ => step *= 0.5,
            }
        }
    }

    /// Defects of a plan from its states and inputs alone, in the units of the states.
    ///
    /// # Errors
    /// The [`Fault`] of a state that the model refuses.
    pub fn defects(&self, unknowns: &Trajectory) -> Result<Vec<Vec<f64>>, Fault> {
        defects(self, &self.scheme(), unknowns)
    }

    /// Rows of a plan from one start of an interval to the next.
    pub fn rows_of_interval(&self) -> usize {
        let scheme = self.scheme();
        if scheme.compressed { 1 } else { scheme.points() - 1 }
    }

    fn scheme(&self) -> Scheme {
        if self.spec.order == 6 { Scheme::lobatto() } else { Scheme::hermite_simpson() }
    }

    fn refinement(&self) -> Refinement {
        let solver = Options {
            time: processor_time(self.spec.time_limit_s),
            iterations: ITERATIONS,
            tolerance: 1e-5,
            complementarity: 1e-6,
            acceptable: 1e-4,
            ..Options::default()
        };
        Refinement {
            scheme: self.scheme(),
            intervals: self.spec.intervals,
            tolerance: self.spec.tolerance,
            objective_tolerance: 1e-3,
            meshes: self.spec.meshes,
            iterations: self.spec.iterations,
            solver,
            ..Refinement::default()
        }
    }

    /// The robot's own gait at the nearest frequency and pitch allowed.
    fn guess(&self) -> Result<Trajectory, Fault> {
        let [low, high] = self.spec.frequency_hz;
        let own = flapping(&self.own.p);
        self.cycle(&Flapping {
            frequency_hz: own.frequency_hz.clamp(low, high),
            pitch: own.pitch.clamp(self.pitch[0], self.pitch[1]),
        })
    }

    /// The periodic cycle of the gait with resting regulators.
    fn cycle(&self, flapping: &Flapping) -> Result<Trajectory, Fault> {
        let states = self.stand.mirror().states.len();
        let gait = SteadyGait { problem: self, p: [flapping.frequency_hz, flapping.pitch] };
        let h = 1.0 / (flapping.frequency_hz * STEPS as f64);
        let mut stepper = Stepper::new(&gait, 0.0, &vec![0.0; states + 4]);
        let mut out = Trajectory { p: gait.p.to_vec(), ..Trajectory::default() };
        for _ in 0..CYCLES {
            stepper.set_time(0.0);
            stepper.state_mut()[states..].fill(0.0);
            (out.t, out.x) = (Vec::new(), Vec::new());
            let mut keep = Held(|step: usize, at: Moment| {
                if step < STEPS && step.is_multiple_of(STEPS / SAMPLES) {
                    out.t.push(at.t);
                    out.x.push(at.x.to_vec());
                }
                Ok(ControlFlow::Continue(()))
            });
            stepper.run(h, STEPS, &mut keep).check()?;
        }
        out.t.push(1.0 / flapping.frequency_hz);
        out.x.push(stepper.state().to_vec());
        out.u = vec![stepper.inputs().to_vec(); out.t.len()];
        Ok(out)
    }

    /// The running means among the states.
    fn sums<S: Copy>(&self, x: &[S]) -> [S; 4] {
        let n = self.stand.mirror().states.len();
        [x[n], x[n + 1], x[n + 2], x[n + 3]]
    }

    /// States of structure and air of one wing; displacements keep to the strokes.
    fn states(&self) -> impl Iterator<Item = Channel> {
        let robot = self.stand.robot();
        let structure = robot.layout().structure;
        self.stand.mirror().states.iter().map(move |&i| {
            let mut channel = robot.states()[structure + i].clone();
            if let Some([low, high]) = robot.strokes().get(i) {
                (channel.low, channel.high) = (*low, *high);
            }
            channel
        })
    }
}

/// Problems solved one after another within one limit of iterations and time.
struct Stages<'o> {
    refinement: Refinement,
    observer: &'o mut dyn FnMut(Progress) -> ControlFlow<()>,
    /// True where the guess is the solution of the problem before.
    warm: bool,
    /// Number of the next.
    stage: usize,
    passes: Vec<Pass>,
    iterations: usize,
    time: Duration,
    processor_time: Duration,
}

impl<'o> Stages<'o> {
    fn new(refinement: Refinement, observer: &'o mut dyn FnMut(Progress) -> ControlFlow<()>) -> Self {
        let (time, processor_time) = (Duration::ZERO, Duration::ZERO);
        let passes = Vec::new();
        Self { refinement, observer, warm: false, stage: 0, passes, iterations: 0, time, processor_time }
    }

    /// Solves `problem` from `guess` on so many meshes at most, each in so many iterations at most; where the mesh is one, on that of
    /// the settings alone.
    fn solve(
        &mut self,
        problem: &LeastPower,
        guess: &Trajectory,
        meshes: usize,
        iterations: usize,
    ) -> Optimum {
        let mut refinement = Refinement { meshes, ..self.refinement.clone() };
        refinement.solver.iterations = iterations;
        if meshes == 1 {
            // The gaits on the way to the whole are no meshes of it.
            self.passes.clear();
            refinement.most_intervals = refinement.intervals;
        }
        refinement.iterations = refinement.iterations.saturating_sub(self.iterations);
        refinement.solver.time = refinement.solver.time.saturating_sub(self.processor_time);
        if self.warm {
            [refinement.solver.barrier, refinement.solver.margin] = WARM;
        }
        let optimum = optimise_stage(problem, guess, &refinement, self.observer, self.stage);
        self.stage += 1;
        self.passes.extend(optimum.passes.iter().cloned());
        self.iterations += optimum.iterations;
        self.time += optimum.time;
        self.processor_time += optimum.processor_time;
        optimum
    }

    /// True when a solve that ended so leaves nothing to go on with: it was stopped, or iterations or time are used up.
    fn is_over(&self, status: &SolveStatus) -> bool {
        *status == SolveStatus::Stopped
            || self.iterations >= self.refinement.iterations
            || self.processor_time >= self.refinement.solver.time
    }

    /// The last of the solutions, with what all together took.
    fn whole(self, last: Optimum) -> Optimum {
        let Self { passes, iterations, time, processor_time, .. } = self;
        Optimum { passes, iterations, time, processor_time, ..last }
    }
}

/// The states of a [`LeastPower`] problem at one frequency and pitch.
struct SteadyGait<'a> {
    problem: &'a LeastPower<'a>,
    p: [f64; 2],
}

impl System for SteadyGait<'_> {
    type Memory = ();

    fn sizes(&self) -> Sizes {
        let mirror = self.problem.stand.mirror();
        Sizes { states: mirror.states.len() + 4, inputs: mirror.inputs.len() }
    }
    fn slope(&self, at: Moment, dx: &mut [f64]) -> Result<(), Fault> {
        let Moment { t, x, u, .. } = at;
        OptimalControl::rates(self.problem, Instant { t, x, u, p: &self.p }, dx)
    }
}

/// Whether the last mesh has an optimum, which may be coarse.
fn solved(optimum: &Optimum) -> bool {
    optimum.passes.last().is_some_and(|pass| pass.status.is_success())
}

fn flapping<S: Copy>(p: &[S]) -> Flapping<S> {
    Flapping { frequency_hz: p[0], pitch: p[1] }
}

impl OptimalControl for LeastPower<'_> {
    fn setup(&self) -> Setup {
        let (robot, mirror) = (self.stand.robot(), self.stand.mirror());
        let mut states: Vec<Channel> = self.states().collect();
        let closed =
            |c: &Channel| Channel::limited(format!("closure of {}", c.name), c.unit, c.frame, 0.0, 0.0);
        let mut ends: Vec<Channel> = states.iter().map(closed).collect();
        let at_least = |name, low| Channel::limited(name, "N", "W", low, f64::INFINITY);
        ends.push(Channel::limited("cycles", "", "", 1.0, 1.0));
        ends.push(at_least("mean upward force", self.asked[0]));
        ends.push(at_least("mean forward force", self.asked[1]));
        if let Some(size) = self.spec.trim_within_n_m {
            ends.push(Channel::limited("mean trim moment", "N m", "B", -size, size));
        }
        let mut start = vec![FREE; states.len()];
        start.extend([[0.0, 0.0]; 4]);
        let sums =
            [("drive power", "W"), ("upward force", "mN"), ("forward force", "mN"), ("trim moment", "mN m")];
        states.extend(sums.map(|(name, unit)| Channel::free(format!("running mean of {name}"), unit, "")));
        let inputs = mirror.inputs.iter().map(|&i| robot.inputs()[i].clone()).collect();
        let [slowest, fastest] = self.spec.frequency_hz;
        let mut setup = Setup::new(states, inputs, [1.0 / fastest, 1.0 / slowest]);
        setup.parameters = vec![
            Channel::limited("frequency", "Hz", "", slowest, fastest),
            Channel::limited("pitch", "rad", "WB", self.pitch[0], self.pitch[1]),
        ];
        let path = clearance_path(robot.clearances(), self.spec.clearance_m);
        Setup { start, ends, path, ..setup }
    }

    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        let n = self.stand.mirror().states.len();
        let flapping = flapping(at.p);
        let (dx, means) = dx.split_at_mut(n);
        let loads = self.stand.evaluate(at.t, &flapping, &at.x[..n], at.u, dx)?;
        let drive = drive_power(&loads.torques, &loads.joints, self.spec.storage, self.width);
        let [up, forward, trim] = self.stand.lift_thrust_trim(&loads, flapping.pitch);
        let values = [drive, up * MILLI, forward * MILLI, trim * MILLI];
        for (mean, value) in means.iter_mut().zip(values) {
            *mean = value * flapping.frequency_hz;
        }
        Ok(())
    }

    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        let mirror = self.stand.mirror();
        let share = |(u, &i): (&S, &usize)| (*u * (1.0 / self.half_ranges[i])).squared();
        let sum = at.u.iter().zip(&mirror.inputs).map(share).fold(S::ZERO, |sum, s| sum + s);
        sum * at.p[0] * (self.spec.effort_w / mirror.inputs.len() as f64)
    }

    fn constrain_path<S: Scalar>(&self, at: Instant<S>, values: &mut [S]) {
        let states = &at.x[..self.stand.mirror().states.len()];
        if !values.is_empty() && self.stand.clear(at.t, &flapping(at.p), states, values).is_err() {
            values.fill(S::from(f64::NAN));
        }
    }

    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        self.sums(ends.x[1])[0]
    }

    fn constrain_ends<S: Scalar>(&self, ends: Ends<S>, values: &mut [S]) {
        let n = self.stand.mirror().states.len();
        for (i, value) in values[..n].iter_mut().enumerate() {
            *value = ends.x[1][i] - ends.x[0][i];
        }
        let [_, up, forward, trim] = self.sums(ends.x[1]);
        let means = [(ends.t[1] - ends.t[0]) * ends.p[0], up / MILLI, forward / MILLI, trim / MILLI];
        for (value, mean) in values[n..].iter_mut().zip(means) {
            *value = mean;
        }
    }
}
