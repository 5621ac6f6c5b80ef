//! A horizon whose length is an unknown: the paper's t_f.

use wingbeat_math::{EqualSteps, Error, RK4, Workspace};
use wingbeat_ocp::plant::Plant;
use wingbeat_ocp::realtime::{HorizonSolver, Plan, RealTime, Settings, Statistics, Tracking, UpdateStatus};

/// First change of the length tried, and the least and largest, over the length. *Choice.*
const FIRST: f64 = 0.02;
const LEAST: f64 = 0.002;
const LARGEST: f64 = 0.05;

/// Longest Runge-Kutta step of the motion whose cost decides, s. *Choice.*
const SUBSTEP: f64 = 0.01;

/// Solves for states and inputs by [`RealTime`] and for the length of the horizon by direct search: each update solves at the
/// present length and at one beside it, from the same plan, and keeps the one of lower cost. Success doubles the change that
/// is tried next, failure halves it and turns it round.
///
/// The cost is J at the nodes of the motion that the plan's inputs give from the present state, so no length can win by a plan that
/// misses the dynamics. J is a sum over nodes: a length can still win because its nodes fall where the swing of the gait is small. The
/// statistics are those of the solve that was kept.
///
/// The length is no variable of the quadratic program, since a [`Plant`] has no derivative by the time.
///
/// Equation: guide.free_end
/// `min over t_f of J at the optimal states and inputs, J along the motion of the inputs, by one trial beside the
/// present t_f an update`
/// Source: Paper section IV: t_f unknown; direct search a choice.
/// Test: `a_free_horizon_keeps_to_its_range_and_one_without_room_is_the_given_one`.
pub struct FreeEnd {
    now: RealTime,
    beside: RealTime,
    /// Allowed lengths of an interval, s.
    between: [f64; 2],
    change: f64,
    motion: StoredMotion,
}

/// Storage of a motion and its cost.
struct StoredMotion {
    state: Vec<f64>,
    input: Vec<f64>,
    residual: Vec<f64>,
    work: Workspace<f64>,
}

impl FreeEnd {
    /// Intervals that begin with the length of `settings` and stay `between` two, s.
    ///
    /// # Errors
    /// As [`RealTime::new`].
    pub fn new<P: Plant, T: Tracking>(
        plant: &P,
        tracking: &T,
        settings: Settings,
        between: [f64; 2],
    ) -> Result<Self, Error> {
        let now = RealTime::new(plant, tracking, settings)?;
        let most = (0..=settings.intervals).map(|node| tracking.residuals(node)).max().unwrap_or(0);
        let (states, inputs) = (plant.states().len(), plant.inputs().len());
        let (state, input, residual) = (vec![0.0; states], vec![0.0; inputs], vec![0.0; most]);
        let motion = StoredMotion { state, input, residual, work: Workspace::new(states, 4) };
        Ok(Self { beside: now.clone(), now, between, change: FIRST, motion })
    }
}

impl StoredMotion {
    /// J of the motion that the inputs of the plan of `solver` give from its first state; endless where the model fails on the way.
    fn cost<P: Plant, T: Tracking>(&mut self, solver: &RealTime, plant: &P, tracking: &T) -> f64 {
        let plan = solver.plan();
        let (step, mut cost) = (plan.horizon.step, 0.0);
        self.state.copy_from_slice(plan.state(0));
        let count = (step / SUBSTEP).ceil().max(1.0);
        for node in 0..plan.nodes() {
            let r = &mut self.residual[..tracking.residuals(node)];
            tracking.residual(node, plan.time(node), &self.state, plan.input(node), r);
            cost += r.iter().map(|r| r * r).sum::<f64>();
            if node + 1 < plan.nodes() {
                let steps = EqualSteps::new(plan.time(node), step / count, count as usize);
                let input = &mut self.input;
                let mut rates = |t: f64, x: &[f64], dx: &mut [f64]| {
                    plan.input_at(t, input);
                    plant.rates_in_numbers(t, x, input, dx)
                };
                if RK4.integrate(&mut rates, steps, &mut self.state, &mut self.work).is_err() {
                    return f64::INFINITY;
                }
            }
        }
        for node in 1..plan.nodes() {
            let pairs = plan.input(node).iter().zip(plan.input(node - 1)).enumerate();
            cost += pairs.map(|(j, (b, a))| tracking.change_weight(j) * (b - a) * (b - a)).sum::<f64>();
        }
        if cost.is_finite() { cost } else { f64::INFINITY }
    }
}

impl<P: Plant, T: Tracking> HorizonSolver<P, T> for FreeEnd {
    fn plan(&self) -> &Plan {
        self.now.plan()
    }

    fn plan_mut(&mut self) -> &mut Plan {
        self.now.plan_mut()
    }

    fn reset(&mut self, plant: &P, x0: &[f64]) {
        self.now.reset(plant, x0);
    }

    fn shift(&mut self, plant: &P, dt: f64) {
        self.now.shift(plant, dt);
    }

    fn solve(&mut self, plant: &P, tracking: &T, t0: f64, x0: &[f64], iterations: usize) -> UpdateStatus {
        let present = self.now.plan().horizon.step;
        let [low, high] = self.between;
        let tried = (present * (1.0 + self.change)).clamp(low, high);
        if tried != present {
            self.beside.take(self.now.plan());
            self.beside.stretch(plant, tried);
        }
        let status = self.now.solve(plant, tracking, t0, x0, iterations);
        if tried != present {
            let other = self.beside.solve(plant, tracking, t0, x0, iterations);
            let mut cost = |solver| self.motion.cost(solver, plant, tracking);
            if other.updated() && (!status.updated() || cost(&self.beside) < cost(&self.now)) {
                std::mem::swap(&mut self.now, &mut self.beside);
                self.change = (2.0 * self.change).clamp(-LARGEST, LARGEST);
                return other;
            }
        }
        self.change = -(0.5 * self.change.abs()).max(LEAST).copysign(self.change);
        status
    }

    fn statistics(&self) -> Statistics {
        self.now.statistics()
    }
}
