//! A horizon solver of one's own, chosen from a scenario: it holds one input over the horizon and searches for it
//! along its axes, without derivatives.
//!
//! `cargo run --release --example own_solver`

use std::error::Error;
use std::ops::ControlFlow;
use wingbeat::guide::{AttitudeTracking, RobotSolver, SolverSpec};
use wingbeat::math::{EqualSteps, RK4, Workspace};
use wingbeat::ocp::realtime::{Horizon, HorizonSolver, Plan, Settings, Statistics, Tracking, UpdateStatus};
use wingbeat::plant::{LocalChart, Plant};
use wingbeat::robot::Robot;
use wingbeat::scenario::{Document, Doors, Scenario};

/// What `[solver.axes]` says.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct AxesSpec {
    /// First step along an axis, over half of the input's range.
    step: f64,
    /// Sweeps over all axes in an iteration; the step halves from one to the next.
    sweeps: usize,
    /// Longest Runge-Kutta step, s.
    substep_s: f64,
}

/// The search along the axes.
struct Axes {
    step: f64,
    sweeps: usize,
    substeps: usize,
    plan: Plan,
    trial: Plan,
    work: Workspace<f64>,
    residual: Vec<f64>,
    statistics: Statistics,
}

impl SolverSpec for AxesSpec {
    fn build<'a>(
        &self,
        plant: &LocalChart<'a, Robot>,
        tracking: &AttitudeTracking<'a, Robot>,
        settings: Settings,
    ) -> Result<RobotSolver<'a>, wingbeat::Error> {
        if !(self.substep_s > 0.0) {
            return Err(wingbeat::Error::invalid("substep_s", self.substep_s, "above 0"));
        }
        let (states, inputs) = (plant.states().len(), plant.inputs().len());
        let Settings { intervals, step, .. } = settings;
        let plan = Plan::new(Horizon { states, inputs, intervals, step });
        let residuals = (0..=intervals).map(|node| tracking.residuals(node)).max().unwrap_or(0);
        Ok(Box::new(Axes {
            step: self.step,
            sweeps: self.sweeps,
            substeps: (step / self.substep_s).ceil() as usize,
            trial: plan.clone(),
            plan,
            work: Workspace::new(states, 4),
            residual: vec![0.0; residuals],
            statistics: Statistics::default(),
        }))
    }
}

impl Axes {
    /// Integrates the trial plan from its first state under its inputs; its cost, infinite where the model fails.
    fn cost<P: Plant, T: Tracking>(&mut self, plant: &P, tracking: &T) -> f64 {
        let Horizon { states, intervals, step, .. } = self.trial.horizon;
        let mut cost = 0.0;
        for node in 0..=intervals {
            if node > 0 {
                self.trial.x.copy_within((node - 1) * states..node * states, node * states);
                let steps =
                    EqualSteps::new(self.trial.time(node - 1), step / self.substeps as f64, self.substeps);
                let (inputs, x) = (self.trial.input(node).to_vec(), self.trial.state_mut(node));
                let mut rates = |t: f64, x: &[f64], dx: &mut [f64]| plant.rates(t, x, &inputs, dx);
                if RK4.integrate(&mut rates, steps, x, &mut self.work).is_err() {
                    return f64::INFINITY;
                }
            }
            let r = &mut self.residual[..tracking.residuals(node)];
            tracking.residual(node, self.trial.time(node), self.trial.state(node), self.trial.input(node), r);
            cost += r.iter().map(|r| r * r).sum::<f64>();
        }
        cost
    }

    /// The trial plan with `value` for input `j` at every node.
    fn hold(&mut self, j: usize, value: f64) {
        for node in 0..self.trial.nodes() {
            self.trial.input_mut(node)[j] = value;
        }
    }
}

impl<P: Plant, T: Tracking> HorizonSolver<P, T> for Axes {
    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn plan_mut(&mut self) -> &mut Plan {
        &mut self.plan
    }

    fn reset(&mut self, plant: &P, x0: &[f64]) {
        self.plan.rest(x0, plant.inputs(), 0);
    }

    fn shift(&mut self, _: &P, dt: f64) {
        self.plan.start += dt; // the input is the same everywhere
    }

    fn solve(&mut self, plant: &P, tracking: &T, t0: f64, x0: &[f64], iterations: usize) -> UpdateStatus {
        self.trial.copy_from(&self.plan);
        self.trial.start = t0;
        self.trial.state_mut(0).copy_from_slice(x0);
        let mut best = self.cost(plant, tracking);
        let mut step = self.step;
        for _ in 0..iterations * self.sweeps {
            for (j, channel) in plant.inputs().iter().enumerate() {
                let (held, half_range) = (self.trial.input(0)[j], 0.5 * (channel.high - channel.low));
                let mut choice = held;
                for tried in [held - step * half_range, held + step * half_range] {
                    let tried = channel.clamp(tried);
                    self.hold(j, tried);
                    let cost = self.cost(plant, tracking);
                    if cost < best {
                        (best, choice) = (cost, tried);
                    }
                }
                self.hold(j, choice);
            }
            step *= 0.5;
        }
        if !self.cost(plant, tracking).is_finite() {
            return UpdateStatus::NumericalTrouble;
        }
        // Interpolation between nodes asks for the rates.
        if let Err(fault) = self.trial.evaluate_rates(plant) {
            return UpdateStatus::ModelFault(fault);
        }
        self.statistics.iterations = iterations;
        std::mem::swap(&mut self.plan, &mut self.trial);
        UpdateStatus::IterationLimit
    }

    fn statistics(&self) -> Statistics {
        self.statistics
    }
}

/// Runs the example.
pub fn main() -> Result<(), Box<dyn Error>> {
    let doors = Doors::shipped().solver::<AxesSpec>("axes");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/banking_turn.toml");
    let axes = Document::text("axes", "[axes]\nstep = 0.2\nsweeps = 3\nsubstep_s = 0.005")?;
    let document = Document::file(path.as_ref())?.put("solver", axes)?.overridden(
        &["controller.period_s=0.02", "flight.duration_s=0.5", "goal.settle_s=0.2"].map(String::from),
    );
    let run = Scenario::open(document, &doors)?.fly(|_| ControlFlow::Continue(()))?;
    let error = run.summary.roll_rms_error_deg.ok_or("the flight is not judged")?;
    println!("level flight held within {error:.2} deg rms of roll");
    assert_eq!(run.summary.controller.failures, 0);
    assert!(error < 5.0, "{error}");
    Ok(())
}
