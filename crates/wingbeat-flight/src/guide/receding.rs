//! A plan that moves on with the flight: what predictive controllers share.

use crate::simulate::{Column, Update};
use std::time::{Duration, Instant};
use wingbeat_math::Vec3;
use wingbeat_ocp::plant::{LocalChart, Plant};
use wingbeat_ocp::realtime::{HorizonSolver, Plan, Statistics, Tracking};

/// Names of the solver's measures, as [`measures`] has them.
const MEASURES: [&str; 5] = ["iterations", "qp_changes", "active_limits", "stationarity", "defect"];

/// A horizon solver with its plan, in the chart of the last update.
pub(super) struct Receding<H> {
    pub solver: H,
    /// The plan to go on with when an update comes late.
    previous: Plan,
    deadline: Option<Duration>,
    iterations: usize,
    /// Start of the plan, s; none before the first update.
    last_update: Option<f64>,
    local: Vec<f64>,
    /// The update that is expected, where the plan was moved on to it.
    expected: Option<ExpectedUpdate>,
    /// Whether the last update gave a new plan, so that it begins where something was measured.
    fresh: bool,
    /// Time that the preparation of the update took.
    spent: Duration,
    /// Angle between the attitude that the last update expected and that which it found, rad.
    pub missed: f64,
    /// Largest of it so far, rad.
    pub missed_largest: f64,
}

/// An update whose state is not measured yet.
#[derive(Clone, Copy)]
struct ExpectedUpdate {
    /// Its time, s.
    t: f64,
    /// Whether the solver can answer.
    ready: bool,
}

impl<H> Receding<H> {
    /// `solver`, whose plan is `previous`; an update that takes longer than `deadline_s` is dropped.
    pub fn new(solver: H, previous: Plan, deadline_s: Option<f64>, iterations: usize) -> Self {
        Self {
            deadline: deadline_s.map(|s| Duration::try_from_secs_f64(s).unwrap_or(Duration::MAX)),
            iterations,
            last_update: None,
            local: vec![0.0; previous.horizon.states],
            previous,
            solver,
            expected: None,
            fresh: false,
            spent: Duration::ZERO,
            missed: 0.0,
            missed_largest: 0.0,
        }
    }

    /// Whether there was an update.
    pub fn begun(&self) -> bool {
        self.last_update.is_some()
    }

    /// Moves the plan on to `t` and centres `chart` at the state `x` of the plant; false at the first update, which
    /// finds a plan that rests there.
    pub fn follow<'a, P: Plant, T: Tracking>(
        &mut self,
        chart: &mut LocalChart<'a, P>,
        t: f64,
        x: &[f64],
    ) -> bool
    where
        H: HorizonSolver<LocalChart<'a, P>, T>,
    {
        let last = self.last_update.replace(t);
        let expected = self.expected.filter(|expected| expected.t == t);
        if let Some(last) = last.filter(|_| expected.is_none()) {
            self.solver.shift(chart, t - last);
        }
        if let (Some(expected), Some(r)) = (expected, chart.rotation()) {
            chart.localise(x, &mut self.local);
            self.missed = Vec3::from_slice(&self.local[r..]).norm();
            // What is no number is further off than any.
            if self.missed > self.missed_largest || self.missed.is_nan() {
                self.missed_largest = self.missed;
            }
            if expected.ready {
                return true;
            }
        }
        let old = chart.reference();
        chart.center_at(x);
        chart.localise(x, &mut self.local);
        if last.is_none() {
            self.solver.reset(chart, &self.local);
            return false;
        }
        let plan = self.solver.plan_mut();
        (0..plan.nodes()).for_each(|k| chart.adopt(old, plan.state_mut(k)));
        true
    }

    /// Moves the plan on to `t`, s, where nothing is measured yet, and centres `chart` at the state that it leads to, which is left in `state`,
    /// in the units of the plant's channels.
    /// False before the first update, and where it was done.
    pub fn expect<'a, P: Plant, T: Tracking>(
        &mut self,
        chart: &mut LocalChart<'a, P>,
        t: f64,
        state: &mut [f64],
    ) -> bool
    where
        H: HorizonSolver<LocalChart<'a, P>, T>,
    {
        let Some(last) = self.last_update.filter(|_| self.expected.is_none_or(|expected| expected.t != t))
        else {
            return false;
        };
        self.solver.shift(chart, t - last);
        (self.last_update, self.expected) = (Some(t), Some(ExpectedUpdate { t, ready: false }));
        let old = chart.reference();
        chart.globalise(self.solver.plan().state(0), state);
        chart.center_at(state);
        let plan = self.solver.plan_mut();
        (0..plan.nodes()).for_each(|k| chart.adopt(old, plan.state_mut(k)));
        true
    }

    /// Does what can be done for the update that is [expected](Self::expect) before its state is measured. A plan that was kept begins where
    /// nothing was measured: the update after it is made whole.
    pub fn prepare<P: Plant, T: Tracking>(&mut self, plant: &P, tracking: &T)
    where
        H: HorizonSolver<P, T>,
    {
        let begun = Instant::now();
        if let Some(expected) = self.expected.as_mut().filter(|_| self.fresh) {
            expected.ready = self.solver.prepare(plant, tracking, expected.t, self.iterations);
        }
        self.spent = begun.elapsed();
    }

    /// Solves for the plan at `t`, to which it was moved; the deadline counts from `begun`.
    pub fn improve<P: Plant, T: Tracking>(
        &mut self,
        plant: &P,
        tracking: &T,
        t: f64,
        begun: Instant,
    ) -> Update
    where
        H: HorizonSolver<P, T>,
    {
        self.previous.clone_from(self.solver.plan());
        let ready = self.expected.take().is_some_and(|expected| expected.ready && expected.t == t);
        self.fresh = false;
        let answered = ready && self.solver.answer(plant, tracking, &self.local).updated();
        let solve = |solver: &mut H| solver.solve(plant, tracking, t, &self.local, self.iterations);
        if !answered && !solve(&mut self.solver).updated() {
            return Update::Kept;
        }
        let spent = std::mem::take(&mut self.spent);
        if self.deadline.is_some_and(|limit| spent + begun.elapsed() > limit) {
            self.solver.plan_mut().clone_from(&self.previous);
            return Update::Late;
        }
        self.fresh = true;
        Update::Fresh
    }
}

/// Columns of [`measures`].
pub(super) fn columns() -> impl Iterator<Item = Column> {
    MEASURES.into_iter().map(|m| Column::new(format!("solver_{m}"), "", ""))
}

/// What a solver tells of its last update.
pub(super) fn measures(s: &Statistics) -> [f64; MEASURES.len()] {
    [s.iterations as f64, s.qp_changes as f64, s.active as f64, s.stationarity, s.defect]
}
