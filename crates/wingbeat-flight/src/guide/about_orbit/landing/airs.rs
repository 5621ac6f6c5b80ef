//! Which of several laws of lift the flight shows to hold.

use crate::guide::history::STEP;
use crate::simulate::Stepper;
use std::sync::Arc;
use wingbeat_math::Vec3;
use wingbeat_ocp::plant::Plant;
use wingbeat_robot::{Layout, Robot};

/// Time over which what the models miss is averaged, s: about half a cycle of a robot of 20 g. *Choice.*
const FORGOTTEN: f64 = 0.06;
/// Velocity, m/s, and angular rate, rad/s, that count alike in what a model misses over an update. *Choice.*
const ALIKE: [f64; 2] = [0.6, 20.0];
/// What every model is taken to have missed before, in squares of [`ALIKE`]. *Choice.*
const BEFORE: f64 = 1e-4;
/// Least mean square, far below rounding's: shares of nothing have no sense.
const LEAST: f64 = 1e-30;
/// Power of the squares that a model misses: half the number of independent looks. *Choice.*
const LOOKS: i32 = 3;

/// Models of the same robot under several laws, each flown on from every measured motion of the body and the structure, with states of
/// the air of its own.
pub(in super::super) struct Airs {
    models: Vec<Model>,
    /// Time of the last update, s.
    last: Option<f64>,
}

struct Model {
    robot: Arc<Robot>,
    x: Vec<f64>,
    /// Mean square of what it misses.
    missed: f64,
}

impl Airs {
    /// Of the `robots`, of which none has been seen to be right.
    pub fn new(robots: &[Arc<Robot>]) -> Self {
        let model = |robot: &Arc<Robot>| Model {
            robot: Arc::clone(robot),
            x: vec![0.0; robot.states().len()],
            missed: BEFORE,
        };
        Self { models: robots.iter().map(model).collect(), last: None }
    }

    /// Compares what each has expected under the commands `held`, in the units of the inputs, with the state `x` of the robot `known`, in the
    /// units of its states, measured at the time `t`, s. A model that breaks down counts no more.
    pub fn learn(&mut self, t: f64, (known, x): (&Robot, &[f64]), held: &[f64]) {
        let since = self.last.replace(t).filter(|since| t > *since);
        for model in &mut self.models {
            let (Some(since), true) = (since, model.missed.is_finite()) else {
                model.x = model.robot.named_as(known, x);
                continue;
            };
            let mut stepper = Stepper::new(&*model.robot, since, &model.x);
            stepper.set_inputs(held);
            let steps = ((t - since) / STEP).ceil();
            let flown = (0..steps as usize).try_for_each(|_| stepper.step((t - since) / steps));
            if flown.is_err() {
                (model.missed, model.x) = (f64::INFINITY, model.robot.named_as(known, x));
                continue;
            }
            let (l, expected) = (model.robot.layout(), stepper.state());
            let share = 1.0 - (-(t - since) / FORGOTTEN).exp();
            model.missed += share * (missed(l, x, expected) - model.missed);
            model.missed = model.missed.max(LEAST);
            model.x.copy_from_slice(expected);
            model.x[..l.aero].copy_from_slice(&x[..l.aero]);
        }
    }

    /// Equation: guide.law_weights
    /// `w_i = S_i^-n / sum_j S_j^-n, S' = (e'e - S)/tau, e = what model i misses of velocity and rate over an update`
    /// Source: Magill 1965, IEEE Trans. Autom. Control 10: several models; likelihood of 2 n looks of unknown variance.
    /// Test: `the_law_that_holds_is_found_as_it_lands`.
    ///
    /// Share to which each law is taken to hold; together 1, the first where every model has broken down.
    pub fn weights(&self) -> Vec<f64> {
        let least = self.models.iter().map(|model| model.missed).fold(f64::INFINITY, f64::min);
        if least.is_infinite() {
            return (0..self.models.len()).map(|i| if i == 0 { 1.0 } else { 0.0 }).collect();
        }
        let shares: Vec<f64> = self.models.iter().map(|model| (least / model.missed).powi(LOOKS)).collect();
        let sum: f64 = shares.iter().sum();
        shares.into_iter().map(|share| share / sum).collect()
    }

    /// The state of each model, in the units of its states.
    pub fn states(&self) -> impl Iterator<Item = &[f64]> {
        self.models.iter().map(|model| &model.x[..])
    }
}

/// Square of what is `expected` wrongly of the velocity and the rate in the state `x`, by [`ALIKE`].
fn missed(l: &Layout, x: &[f64], expected: &[f64]) -> f64 {
    let of = |place: usize, size: f64| {
        let off: Vec3 = Vec3::from_slice(&x[place..]) - Vec3::from_slice(&expected[place..]);
        off.norm_squared() / (size * size)
    };
    of(l.velocity, ALIKE[0]) + of(l.rate, ALIKE[1])
}
