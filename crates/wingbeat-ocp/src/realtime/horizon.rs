//! What a predictive controller needs of the solver of its horizon.

use super::{Plan, RealTime, Statistics, Tracking, UpdateStatus};
use crate::plant::Plant;

/// Improves a plan from update to update. [`RealTime`] is the one that ships.
pub trait HorizonSolver<P: Plant, T: Tracking> {
    /// The plan: states, inputs and rates at the nodes.
    fn plan(&self) -> &Plan;
    /// The plan, to move its states into other coordinates or to set a guess.
    fn plan_mut(&mut self) -> &mut Plan;
    /// Fills the plan with the state `x0` and inputs of zero, or the nearest allowed, in the units of the plant's channels.
    fn reset(&mut self, plant: &P, x0: &[f64]);
    /// Moves the plan on by `dt`, s: the warm start of the next update.
    fn shift(&mut self, plant: &P, dt: f64);
    /// Improves the plan from the state `x0` at the time `t0`, s, by at most `iterations` iterations.
    /// Leaves it as it was unless the status says that it was updated.
    fn solve(&mut self, plant: &P, tracking: &T, t0: f64, x0: &[f64], iterations: usize) -> UpdateStatus;
    /// First phase of an update in two: what can be done for the time `t0`, s, before the state is found, from the first state of the plan.
    /// False where the update is left to [`solve`](Self::solve), as by default.
    fn prepare(&mut self, _plant: &P, _tracking: &T, _t0: f64, _iterations: usize) -> bool {
        false
    }
    /// Second phase of an update that was prepared, from the state `x0` that was found, in the units of the plant's channels.
    fn answer(&mut self, _plant: &P, _tracking: &T, _x0: &[f64]) -> UpdateStatus {
        UpdateStatus::NumericalTrouble
    }
    /// Measures of the last update.
    fn statistics(&self) -> Statistics;
}

/// The methods of a solver by those of another.
macro_rules! handed_on {
    ($to:ty) => {
        fn plan(&self) -> &Plan {
            <$to>::plan(self)
        }
        fn plan_mut(&mut self) -> &mut Plan {
            <$to>::plan_mut(self)
        }
        fn reset(&mut self, plant: &P, x0: &[f64]) {
            <$to>::reset(self, plant, x0);
        }
        fn shift(&mut self, plant: &P, dt: f64) {
            <$to>::shift(self, plant, dt);
        }
        fn solve(&mut self, plant: &P, tracking: &T, t0: f64, x0: &[f64], iterations: usize) -> UpdateStatus {
            <$to>::solve(self, plant, tracking, t0, x0, iterations)
        }
        fn prepare(&mut self, plant: &P, tracking: &T, t0: f64, iterations: usize) -> bool {
            <$to>::prepare(self, plant, tracking, t0, iterations)
        }
        fn answer(&mut self, plant: &P, tracking: &T, x0: &[f64]) -> UpdateStatus {
            <$to>::answer(self, plant, tracking, x0)
        }
        fn statistics(&self) -> Statistics {
            <$to>::statistics(self)
        }
    };
}

impl<P: Plant, T: Tracking> HorizonSolver<P, T> for RealTime {
    handed_on!(RealTime);
}

impl<P: Plant, T: Tracking, H: HorizonSolver<P, T> + ?Sized> HorizonSolver<P, T> for Box<H> {
    handed_on!(H);
}
