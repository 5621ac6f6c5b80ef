//! Predictive control about orbits: commands by a plan of the coming strokes that keeps within their limits.

use super::cycles;
use super::family::{Asked, ReferenceFamily};
use super::feedback::{CostToGo, DEVIATIONS, INTEGRAL, OFF_PATH};
use super::plan_shape::{OrbitShape, PlanStructure};
use super::spec::OrbitWeights;
use super::tracking::{Demand, OffsetPlace};
use crate::guide::angle_error;
use crate::guide::mpc::{MAX_INTERVALS, clearance_width};
use crate::guide::receding::Receding;
use crate::guide::soft_clearance::SoftClearance;
use crate::orbit::Deviations;
use crate::simulate::Update;
use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::time::Instant;
use wingbeat_math::Error;
use wingbeat_math::append_copies;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Scalar, Vec3};
use wingbeat_ocp::plant::{Channel, LocalChart, MAX_STATES, Plant};
use wingbeat_ocp::realtime::{Plan, RealTime, Settings, Statistics, Tracking};
use wingbeat_robot::Robot;

/// Weight of the commands that are led and not fed back, per half of their range: no other cost moves them.
const LED: f64 = 1e3;

/// Rows of the given shape in an interval: at its ends and in its middle, where the plant is linearised.
const ROWS: usize = 2;

/// A plan of commands that costs what the controller's do, deviations and commands alike, and that at its end costs what the
/// controller still needs from there on.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct PredictiveSpec {
    /// Intervals of the horizon.
    pub intervals: usize,
    /// Length of an interval, s; at most a tenth of a cycle.
    pub interval_s: f64,
    /// Iterations of sequential quadratic programming per update.
    #[serde(default = "once")]
    pub iterations: usize,
    /// An update that takes longer by the wall clock is dropped and counted, s; without it none is. A flight with a deadline
    /// does not repeat to the bit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deadline_s: Option<f64>,
    /// What the end of the plan costs.
    #[serde(default)]
    pub terminal: Terminal,
    /// What the plan knows of spars and membranes.
    #[serde(default)]
    pub structure: PlanStructure,
    /// Weight of the change of a command over an interval, per half of its range, beside the command itself.
    #[serde(default)]
    pub command_change: f64,
    /// Cost of clearance short of `clearance_m`, per m, at the nodes after the first; 0 for none.
    #[serde(default)]
    pub clearance: f64,
    /// Clearance below which that counts, m.
    #[serde(default)]
    pub clearance_m: f64,
    /// Width over which that limit is rounded off, m.
    #[serde(default = "clearance_width")]
    pub clearance_width_m: f64,
    /// Distance across the path that costs as much as a full command, m: with it the plan is what leads back to the path,
    /// and no bank is asked for but that of the path's curvature. Needs `tracking`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross_m: Option<f64>,
    /// Distance missing along the path that costs as much, m; without it only the speed asked makes up for it. Needs `cross_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along_m: Option<f64>,
}

/// What the end of a plan costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Terminal {
    /// What the controller needs from there on, without end.
    #[default]
    Regulator,
    /// What every other node costs.
    None,
}

fn once() -> usize {
    1
}

ranges!(PredictiveSpec {
    intervals: Range::between(1.0, MAX_INTERVALS as f64),
    interval_s: Range::over(0.0, 1.0),
    iterations: Range::between(1.0, MAX_INTERVALS as f64),
    deadline_s: Range::POSITIVE,
    command_change: Range::between(0.0, 1e6),
    clearance: Range::between(0.0, 1e9),
    clearance_m: Range::between(-1.0, 1.0),
    clearance_width_m: Range::over(0.0, 1.0),
    cross_m: Range::over(0.0, 1000.0),
    along_m: Range::over(0.0, 1000.0),
});

impl PredictiveSpec {
    /// Checks ranges, and what `robot` must have; `tracking` says whether a path is followed.
    pub(super) fn check(&self, robot: &Robot, tracking: bool) -> Result<(), Error> {
        self.in_range()?;
        let longest = 0.1 / robot.frequency_hz();
        if self.interval_s > longest {
            let allowed = format!("at most {longest:.5}, a tenth of a cycle");
            return Err(Error::invalid("interval_s", self.interval_s, allowed));
        }
        self.soft_clearance(robot)?;
        let (structure, states) = match self.structure {
            PlanStructure::Full => ("full", robot.states().len()),
            PlanStructure::Orbit if robot.is_soft() => ("orbit", robot.with_shape_given().states().len()),
            PlanStructure::Orbit => {
                let allowed = "full: the robot has neither a spar nor a membrane";
                return Err(Error::invalid("structure", "orbit", allowed).against(["robot"]));
            }
        };
        if states > MAX_STATES {
            let allowed = format!("a robot with at most {MAX_STATES} states, not {states}: fewer strips");
            return Err(Error::invalid("structure", structure, allowed));
        }
        let needs = [
            ("cross_m", self.cross_m, tracking, "tracking"),
            ("along_m", self.along_m, self.cross_m.is_some(), "cross_m"),
        ];
        for (key, given, met, needed) in needs {
            if let Some(value) = given.filter(|_| !met) {
                return Err(Error::invalid(key, value, format!("none without {needed}")));
            }
        }
        Ok(())
    }

    fn soft_clearance(&self, robot: &Robot) -> Result<SoftClearance, Error> {
        SoftClearance::new(robot, "clearance", self.clearance, self.clearance_m, self.clearance_width_m)
    }

    /// Distances along and across the path that cost as much as a full command each, if it is in the cost.
    pub(super) fn path(&self) -> Option<[f64; 2]> {
        self.cross_m.map(|cross| [self.along_m.unwrap_or(f64::INFINITY), cross])
    }
}

/// A node of the horizon.
struct HorizonNode {
    asked: Asked,
    /// Where the plan was beside the path.
    beside: Option<OffsetPlace>,
}

/// What a plan costs.
struct PlanCost<'a> {
    chart: LocalChart<'a, Robot>,
    /// The shape of the wings, where it is none of the plan's states.
    shape: Option<OrbitShape>,
    deviations: Deviations,
    /// Deviations that cost as much as a full command.
    sizes: [f64; Deviations::BODY],
    path: Option<[f64; 2]>,
    /// Cost of each command at full deflection from that asked, and of its change.
    per_command: Vec<f64>,
    per_change: Vec<f64>,
    clearance: SoftClearance,
    /// Number of the last node, and how it costs.
    last: usize,
    terminal: Terminal,
    nodes: Vec<HorizonNode>,
    to_go: CostToGo,
    /// Integral of the height's deviation at the last node, m s.
    integral: f64,
    /// Length of an interval, s.
    interval: f64,
}

/// Predictive control.
pub(super) struct Predictive<'a> {
    cost: PlanCost<'a>,
    receding: Receding<RealTime>,
    robot: &'a Robot,
    state: Vec<f64>,
    /// What the plan knows of the state.
    known: Vec<f64>,
    /// Root mean square, over the deviations of the body from what is asked, of what the plan before missed now, by deviations that cost as much
    /// as a full command.
    pub missed: f64,
}

/// What is known of the height at an update.
#[derive(Clone, Copy, Debug)]
pub(super) struct Height {
    /// Deviation, m.
    pub error: f64,
    /// Its integral, m s.
    pub integral: f64,
}

impl PlanCost<'_> {
    /// Gives the plan from the state `x` at `t` the shape of the wings as it is on the orbits that are asked for, at the phase that the last plan
    /// leads to.
    fn give_shape(
        &mut self,
        robot: &Robot,
        (t, x): (f64, &[f64]),
        receding: &Receding<RealTime>,
        family: &ReferenceFamily,
        demand: &mut impl FnMut(f64, Vec3) -> Demand,
    ) {
        let Some(shape) = &self.shape else { return };
        let rows = ROWS * self.last + 1;
        let step = self.interval / ROWS as f64;
        let (mut local, mut state) = (vec![0.0; self.chart.states().len()], x.to_vec());
        let mut given = std::mem::take(&mut self.chart.motion_mut().rows);
        given.clear();
        for row in 0..rows {
            let at = t + row as f64 * step;
            if receding.begun() {
                receding.solver.plan().state_at(at, &mut local);
                self.chart.globalise(&local, &mut state);
            }
            let place = demand(at, Vec3::from_slice(&state[self.deviations.position()..])).place;
            let faster = robot.pacer().map_or(0.0, |pacer| {
                state[robot.layout().structure + robot.response().elements() + pacer.element]
            });
            let pace = robot.frequency_hz() + faster / TAU;
            family.shape(place, [cycles(robot, at, &state), pace], &shape.sources, &mut given);
        }
        let motion = self.chart.motion_mut();
        (motion.start, motion.step, motion.rows) = (t, step, given);
    }

    /// Root of the share of the controller's update that an interval is.
    fn share(&self) -> f64 {
        (self.interval / self.to_go.interval).sqrt()
    }

    /// Root mean square of the deviations of the body between the state `x` and that of the plan for it, `planned` in the chart, by deviations that cost as
    /// much as a full command.
    ///
    /// Equation: guide.plan_error
    /// `sqrt(mean of ((planned - found)/size)^2) over height, velocity, roll, pitch and rates at the update after that of the plan`
    /// Source: one-step prediction error (Ljung 1999, System Identification, 3.2).
    /// Test: `a_plan_may_take_the_shape_of_the_wings_from_the_orbit`.
    fn miss(&self, planned: &[f64], x: &[f64]) -> f64 {
        let mut ahead = x.to_vec();
        self.chart.globalise(planned, &mut ahead);
        let [found, planned] = [x, &ahead].map(|kept| {
            let mut numbers = vec![0.0; self.deviations.len()];
            let mut whole = ArrayVec::new();
            let state = match &self.shape {
                None => kept,
                Some(shape) => shape.complete(kept, &numbers, &mut whole),
            };
            self.deviations.of(state, &mut numbers);
            numbers
        });
        let over = |i: usize| ((planned[i] - found[i]) / self.sizes[i]).powi(2);
        ((0..self.sizes.len()).map(over).sum::<f64>() / self.sizes.len() as f64).sqrt()
    }

    /// Whether `node` costs what the controller needs from there on.
    fn ends(&self, node: usize) -> bool {
        node == self.last && self.terminal == Terminal::Regulator
    }

    /// Number of deviations with place and heading beside the path, and the integral of the height before them.
    fn deviating(&self) -> usize {
        DEVIATIONS + self.deviations.len() + self.path.map_or(0, |_| OFF_PATH)
    }

    /// Those of the state `x` in the chart from what `node` asks, at its time the integral of the height included.
    fn deviate<S: Scalar>(&self, node: usize, x: &[S], e: &mut [S]) {
        let (mut state, mut whole) = (ArrayVec::<S, MAX_STATES>::new(), ArrayVec::new());
        append_copies(&mut state, S::ZERO, x.len() + 1);
        self.chart.globalise(x, &mut state);
        let HorizonNode { asked, beside } = &self.nodes[node];
        let state = match &self.shape {
            None => &state[..],
            Some(shape) => shape.complete(&state, &asked.numbers, &mut whole),
        };
        e[INTEGRAL] = S::from(self.integral);
        let (own, off_path) = e[DEVIATIONS..].split_at_mut(asked.numbers.len());
        let heading = self.deviations.of(state, own);
        own.iter_mut().zip(&asked.numbers).for_each(|(e, asked)| *e -= S::from(*asked));
        if let Some(beside) = beside {
            let [ahead, left, heads] = asked.off_path;
            let (along, cross, turned) = beside.off(Vec3::from_slice(&state[self.deviations.position()..]));
            let off = angle_error(heading - turned, beside.heading() + heads);
            off_path.copy_from_slice(&[along - ahead, cross - left, off]);
        }
    }
}

impl Tracking for PlanCost<'_> {
    fn residuals(&self, node: usize) -> usize {
        let costing = match node {
            0 => 0,
            _ if self.ends(node) => self.deviating(),
            _ => self.sizes.len() + self.path.map_or(0, |path| path.len()),
        };
        self.per_command.len() + if node == 0 { 0 } else { self.clearance.count } + costing
    }

    /// Equation: guide.orbit_plan
    /// `sum over nodes of h/T (sum (deviation/size)^2 + sum ((u - u_orbit)/limit)^2), of the commands half at either
    /// end, + abs(L's)^2 at the last, L L' = P of guide.periodic_regulator there; T the time between its updates, h
    /// that between nodes`
    /// Source: Rawlings, Mayne & Diehl 2017, Model Predictive Control, 2.5 (infinite-horizon cost at the end).
    /// Test: `near_an_orbit_a_short_plan_asks_what_the_regulator_does`.
    fn residual<S: Scalar>(&self, node: usize, t: f64, x: &[S], u: &[S], r: &mut [S]) {
        let share = self.share();
        let (commands, r) = r.split_at_mut(u.len());
        // The trapezoidal rule, commands being linear in between.
        let of_command = if node == 0 || node == self.last { share * 0.5_f64.sqrt() } else { share };
        for (i, r) in commands.iter_mut().enumerate() {
            *r = (u[i] - self.nodes[node].asked.commands[i]) * (self.per_command[i] * of_command);
        }
        if node == 0 {
            return;
        }
        let (clearances, r) = r.split_at_mut(self.clearance.count);
        self.clearance.shortfalls(&self.chart, t, x, clearances);
        let mut e = [S::ZERO; MAX_STATES + OFF_PATH];
        let e = &mut e[..self.deviating()];
        self.deviate(node, x, e);
        if self.ends(node) {
            for (i, r) in r.iter_mut().enumerate() {
                *r = e
                    .iter()
                    .enumerate()
                    .skip(i)
                    .fold(S::ZERO, |sum, (j, e)| sum + *e * self.to_go.root[(j, i)]);
            }
            return;
        }
        let (own, off_path) = r.split_at_mut(self.sizes.len());
        for (i, r) in own.iter_mut().enumerate() {
            *r = e[DEVIATIONS + i] * (share / self.sizes[i]);
        }
        let beside = &e[DEVIATIONS + self.deviations.len()..];
        for (r, (e, size)) in off_path.iter_mut().zip(beside.iter().zip(self.path.unwrap_or_default())) {
            *r = *e * (share / size);
        }
    }

    fn change_weight(&self, input: usize) -> f64 {
        self.per_change[input]
    }
}

impl<'a> Predictive<'a> {
    /// That of `robot` whose `inputs` are fed back.
    pub fn new(
        robot: &'a Robot,
        deviations: &Deviations,
        inputs: &[usize],
        spec: &PredictiveSpec,
        weights: &OrbitWeights,
        family: &ReferenceFamily,
    ) -> Result<Self, Error> {
        let half =
            |c: &Channel| if c.high.is_finite() && c.low.is_finite() { 0.5 * (c.high - c.low) } else { 1.0 };
        let channels = robot.inputs();
        let per_command =
            |(i, c): (usize, &Channel)| if inputs.contains(&i) { 1.0 / c.high } else { LED / half(c) };
        let asked = family.asked(None, 0.0);
        let (chart, shape) = match spec.structure {
            PlanStructure::Full => (LocalChart::new(robot), None),
            PlanStructure::Orbit => {
                let given = robot.with_shape_given();
                let shape = OrbitShape::new(robot, &given);
                (LocalChart::owning(given), Some(shape))
            }
        };
        let cost = PlanCost {
            chart,
            shape,
            deviations: deviations.clone(),
            sizes: weights.sizes(),
            path: spec.path(),
            per_command: channels.iter().enumerate().map(per_command).collect(),
            per_change: channels.iter().map(|c| (spec.command_change / half(c)).powi(2)).collect(),
            clearance: spec.soft_clearance(robot)?,
            last: spec.intervals,
            terminal: spec.terminal,
            nodes: (0..=spec.intervals).map(|_| HorizonNode { asked: asked.clone(), beside: None }).collect(),
            to_go: family.cost(None, 0.0),
            integral: 0.0,
            interval: spec.interval_s,
        };
        let solver = RealTime::new(&cost.chart, &cost, Settings::new(spec.intervals, spec.interval_s))?;
        let plan = solver.plan().clone();
        let receding = Receding::new(solver, plan, spec.deadline_s, spec.iterations);
        let state = vec![0.0; cost.chart.states().len() + 1];
        Ok(Self { cost, receding, robot, known: state.clone(), state, missed: 0.0 })
    }

    /// Plans from the state `x` at `t`, where what is asked at later times is said by `demand`, of the time (s) and the place
    /// (m) planned for it. The phase of the gait at a node is what the last plan leads to: the crank's command is led. The
    /// integral of the height enters at the end as it would be with the deviation of now: no command changes that soon.
    pub fn update(
        &mut self,
        t: f64,
        x: &[f64],
        height: Height,
        family: &ReferenceFamily,
        mut demand: impl FnMut(f64, Vec3) -> Demand,
        begun: Instant,
    ) -> Update {
        let Self { cost, receding, robot, state, known, missed } = self;
        let position = cost.deviations.position();
        match &cost.shape {
            None => known.copy_from_slice(x),
            Some(shape) => shape.keep(x, known),
        }
        let x = &known[..];
        cost.give_shape(robot, (t, x), receding, family, &mut demand);
        if !receding.follow::<_, PlanCost>(&mut cost.chart, t, x) {
            let place = demand(t, Vec3::from_slice(&x[position..])).place;
            fly_on(&mut receding.solver, &cost.chart, t, &family.asked(place, cycles(robot, t, x)).commands);
        }
        let plan = receding.solver.plan();
        if cost.shape.is_some() {
            *missed = cost.miss(plan.state(0), x);
        }
        for (k, node) in cost.nodes.iter_mut().enumerate() {
            let at = t + k as f64 * cost.interval;
            cost.chart.globalise(plan.state(k), state);
            let cycles = cycles(robot, at, state);
            let demand = demand(at, Vec3::from_slice(&state[position..]));
            node.asked = family.asked(demand.place, cycles);
            node.asked.numbers[Deviations::HEIGHT] += demand.height;
            node.asked.numbers[Deviations::VELOCITY.start] += demand.faster;
            node.beside = demand.beside.filter(|_| cost.path.is_some());
            if k == cost.last {
                cost.to_go = family.cost(demand.place, cycles);
            }
        }
        cost.integral = height.integral + height.error * cost.interval * cost.last as f64;
        receding.improve(&cost.chart, &*cost, t, begun)
    }

    /// Whether the plan leaves out the structure.
    pub fn is_reduced(&self) -> bool {
        self.cost.shape.is_some()
    }

    /// The plan, in the chart of the last update.
    pub fn plan(&self) -> &Plan {
        self.receding.solver.plan()
    }

    /// Measures of the last update.
    pub fn statistics(&self) -> Statistics {
        self.receding.solver.statistics()
    }
}

/// Fills a plan that rests with the flight from `t` on under `commands`.
fn fly_on(solver: &mut RealTime, chart: &LocalChart<Robot>, t: f64, commands: &[f64]) {
    let plan = solver.plan_mut();
    let length = plan.horizon.step * plan.horizon.intervals as f64;
    plan.start = t - length;
    (0..plan.nodes()).for_each(|k| plan.input_mut(k).copy_from_slice(commands));
    solver.shift(chart, length);
}
