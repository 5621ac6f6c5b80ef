//! The flight of a robot in air that is stepped beside it and bears on it together with its motion.

use super::fly::{Controller, Flight, Pilot, Sample, Schedule};
use super::secant::Secant;
use super::sensors::Sensors;
use super::stepper::Stepper;
use super::system::{Driver, Ending, Moment, Sizes, System, upright};
use crate::body::MAX_LINKS;
use crate::math::{GRAVITY, Vec3, Wrench};
use crate::plant::Fault;
use crate::robot::Robot;
use arrayvec::ArrayVec;
use std::ops::ControlFlow;

/// Loads on links and body.
type OnLinks = ArrayVec<Wrench<f64>, { MAX_LINKS + 1 }>;

/// Air that is stepped beside a robot: it takes the place of all that the robot's own models say of attached flow, profile drag is
/// theirs.
pub trait Flow {
    /// Steps of the flight that one step of the air takes.
    fn every(&self) -> usize;

    /// Length with which moments are compared with forces, m.
    fn length(&self) -> f64;

    /// Loads of the air on links and body at its next instant, `t` s, if the robot is then in the state `x`: as
    /// [`Robot::rates_beyond`] takes them, those of attached flow whole. The first instant is the flight's begin.
    ///
    /// # Errors
    /// [`Fault::Flow`].
    fn loads(&mut self, t: f64, x: &[f64]) -> Result<Vec<Wrench<f64>>, Fault>;

    /// Goes on from the state asked for last to the instant after it.
    fn keep(&mut self);
}

/// How the motion of a robot and the air beside it were brought together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coupling {
    /// Steps of the air.
    pub steps: usize,
    /// States of the robot that it was asked for.
    pub iterations: usize,
    /// Most of them in a step.
    pub most: usize,
}

/// Change of a load below which motion and air agree, weights.
const TOLERANCE: f64 = 1e-6;
/// Most states tried for one step. *Choice.*
const MOST: usize = 40;

/// What the air bears beyond the robot's models, straight from the begin of a step of the air to its end.
#[derive(Clone, Debug, Default)]
struct Beyond {
    from: f64,
    length: f64,
    ends: [Vec<Wrench<f64>>; 2],
}

impl Beyond {
    fn at(&self, t: f64) -> OnLinks {
        let share = (t - self.from) / self.length;
        let between = |(a, b): (&Wrench<f64>, &Wrench<f64>)| Wrench {
            force: a.force + (b.force - a.force) * share,
            moment: a.moment + (b.moment - a.moment) * share,
        };
        self.ends[0].iter().zip(&self.ends[1]).map(between).collect()
    }
}

/// A robot with loads of the air beside it in its memory.
struct Beside<'a>(&'a Robot);

impl System for Beside<'_> {
    type Memory = Beyond;

    fn sizes(&self) -> Sizes {
        self.0.sizes()
    }
    fn slope(&self, at: Moment<Beyond>, dx: &mut [f64]) -> Result<(), Fault> {
        self.0.rates_beyond(at.t, at.x, at.u, &at.memory.at(at.t), dx)
    }
    fn limit(&self, u: &mut [f64]) {
        self.0.limit(u);
    }
    fn advance(&self, _: f64, _: f64, x: &mut [f64], _: &[f64], _: &mut Beyond) -> Result<(), Fault> {
        upright(self.0, x);
        Ok(())
    }
}

/// Steers as planned: nobody sees it.
struct Tried<'a, 'b, C, O>(&'b Pilot<'a, Robot, C, O>);

/// Steers as planned and shows all but the last end of its steps; its first is the flight's `first`.
struct Flown<'a, 'b, C, O> {
    pilot: &'b mut Pilot<'a, Robot, C, O>,
    first: usize,
    steps: usize,
}

impl<C: Controller, O> Driver<Beyond> for Tried<'_, '_, C, O>
where
    O: FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
{
    fn inputs(&self, t: f64, u: &mut [f64]) {
        self.0.planned(t, u);
    }
    fn observe(&mut self, _: usize, _: Moment<Beyond>) -> Result<ControlFlow<()>, Fault> {
        Ok(ControlFlow::Continue(()))
    }
}

impl<C: Controller, O> Driver<Beyond> for Flown<'_, '_, C, O>
where
    O: FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
{
    fn inputs(&self, t: f64, u: &mut [f64]) {
        self.pilot.planned(t, u);
    }
    fn observe(&mut self, k: usize, at: Moment<Beyond>) -> Result<ControlFlow<()>, Fault> {
        if k == self.steps {
            return Ok(ControlFlow::Continue(()));
        }
        self.pilot.see(self.first + k, (at.t, at.x, at.u), &at.memory.at(at.t))
    }
}

/// As [`fly`](super::fly), in the air `flow`. Every step of the air its loads at the end and the motion that leads there are found
/// together: the loads of the robot's own models, the reaction of accelerated air among them, act at every instant as they are, and
/// what the air bears beyond them, straight over the step, is changed until at its end the sum is the load of the air, to 1e-6 of the
/// weight. The controller's updates lie on ends of steps of the air.
///
/// Equation: robot.coupling
pub fn fly_in<C: Controller>(
    robot: &Robot,
    flow: &mut dyn Flow,
    sensors: &mut Sensors,
    controller: &mut C,
    schedule: &Schedule,
    x: &mut [f64],
    observe: impl FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
) -> (Flight, Coupling) {
    let mut pilot = Pilot::new(robot, sensors, controller, schedule, observe);
    let system = Beside(robot);
    let mut stepper = Stepper::new(&system, 0.0, x);
    let mut coupled = Coupled { robot, flow, schedule, coupling: Coupling::default() };
    let ending = coupled.run(&mut stepper, &mut pilot).unwrap_or_else(Ending::Fault);
    x.copy_from_slice(stepper.state());
    (pilot.flight(ending, stepper.time()), coupled.coupling)
}

struct Coupled<'a, 'b> {
    robot: &'a Robot,
    flow: &'b mut dyn Flow,
    schedule: &'b Schedule,
    coupling: Coupling,
}

impl Coupled<'_, '_> {
    fn run<C: Controller, O>(
        &mut self,
        stepper: &mut Stepper<&Beside<'_>>,
        pilot: &mut Pilot<'_, Robot, C, O>,
    ) -> Result<Ending, Fault>
    where
        O: FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
    {
        let Schedule { step, steps, .. } = *self.schedule;
        let (every, mut taken) = (self.flow.every(), 0);
        let mut loads = self.flow.loads(0.0, stepper.state())?;
        self.flow.keep();
        // All begins at once: what air and motion agree on at the end of the first step holds from its begin on.
        let mut begin: Option<Vec<Wrench<f64>>> = None;
        let mut before: Option<Vec<Wrench<f64>>> = None;
        loop {
            let t = stepper.time();
            pilot.update(taken, t, stepper.state());
            let mut u = stepper.inputs().to_vec();
            pilot.planned(t, &mut u);
            stepper.set_inputs(&u);
            let settled = begin.take().map(|begin| self.settled(stepper, &loads, begin)).transpose()?;
            let known = settled.clone().unwrap_or_else(|| vec![Wrench::ZERO; loads.len()]);
            if taken == steps {
                let (x, u) = (stepper.state().to_vec(), stepper.inputs().to_vec());
                let flow = pilot.see(taken, (t, &x, &u), &known)?;
                return Ok(if flow.is_break() { Ending::Stopped } else { Ending::Complete });
            }
            let goes_on = |(now, before): (&Wrench<f64>, &Wrench<f64>)| Wrench {
                force: now.force * 2.0 - before.force,
                moment: now.moment * 2.0 - before.moment,
            };
            let guess = match &before {
                Some(before) => known.iter().zip(before).map(goes_on).collect(),
                None => known.clone(),
            };
            let saved = stepper.save();
            let length = every as f64 * step;
            let mut memory = Beyond { from: t, length, ends: [known.clone(), guess] };
            let (mut secant, mut tried) = (Secant::default(), 0);
            loop {
                stepper.restore(&saved);
                stepper.memory_mut().clone_from(&memory);
                stepper.run(step, every, &mut Tried(&*pilot)).check()?;
                loads = self.flow.loads(stepper.time(), stepper.state())?;
                tried += 1;
                let found = self.beyond(stepper, &loads, &memory.ends[1])?;
                if self.apart(&memory.ends[1], &found) <= TOLERANCE {
                    break;
                }
                if tried == MOST {
                    let why = "its loads and the motion do not agree; try a shorter lattice.step_s";
                    return Err(Fault::Flow { time: stepper.time(), why });
                }
                let next = secant.next(&self.numbers(&memory.ends[1]), &self.numbers(&found));
                let next = self.loads_of(&next);
                if settled.is_none() {
                    memory.ends[0].clone_from(&next);
                }
                memory.ends[1] = next;
            }
            self.flow.keep();
            let Coupling { steps: counted, iterations, most } = self.coupling;
            self.coupling =
                Coupling { steps: counted + 1, iterations: iterations + tried, most: most.max(tried) };
            stepper.restore(&saved);
            stepper.memory_mut().clone_from(&memory);
            let now = every.min(steps - taken);
            let ending = stepper.run(step, now, &mut Flown { pilot, first: taken, steps: now });
            if ending != Ending::Complete {
                return Ok(ending);
            }
            taken += now;
            if now < every {
                loads = self.sum(stepper, &memory.at(stepper.time()))?;
            }
            before = settled;
            begin = Some(memory.at(stepper.time()).to_vec());
        }
    }

    /// What the air bears beyond the robot's models where the stepper is, its loads being `loads`, while `beyond` acts.
    fn beyond(
        &self,
        stepper: &Stepper<&Beside<'_>>,
        loads: &[Wrench<f64>],
        beyond: &[Wrench<f64>],
    ) -> Result<Vec<Wrench<f64>>, Fault> {
        let (t, x, u) = (stepper.time(), stepper.state(), stepper.inputs());
        let own = self.robot.attached_loads(t, x, u, beyond)?;
        Ok(loads.iter().zip(own).map(|(load, own)| *load + -own).collect())
    }

    /// The loads of the air that `beyond` makes of the robot's models.
    fn sum(&self, stepper: &Stepper<&Beside<'_>>, beyond: &[Wrench<f64>]) -> Result<Vec<Wrench<f64>>, Fault> {
        let (t, x, u) = (stepper.time(), stepper.state(), stepper.inputs());
        let own = self.robot.attached_loads(t, x, u, beyond)?;
        Ok(beyond.iter().zip(own).map(|(load, own)| *load + own).collect())
    }

    /// That at which the sum is `loads` in the state as it is: the robot's own models feel the acceleration.
    fn settled(
        &self,
        stepper: &Stepper<&Beside<'_>>,
        loads: &[Wrench<f64>],
        mut guess: Vec<Wrench<f64>>,
    ) -> Result<Vec<Wrench<f64>>, Fault> {
        let mut secant = Secant::default();
        for _ in 0..MOST {
            let found = self.beyond(stepper, loads, &guess)?;
            if self.apart(&guess, &found) <= TOLERANCE {
                return Ok(guess);
            }
            guess = self.loads_of(&secant.next(&self.numbers(&guess), &self.numbers(&found)));
        }
        Err(Fault::Flow { time: stepper.time(), why: "no acceleration fits its loads" })
    }

    /// Units of force and moment.
    fn units(&self) -> [f64; 2] {
        let weight = self.robot.mass() * GRAVITY;
        [weight, weight * self.flow.length()]
    }

    fn numbers(&self, loads: &[Wrench<f64>]) -> Vec<f64> {
        let [force, moment] = self.units();
        let of = |load: &Wrench<f64>| {
            load.force.0.map(|f| f / force).into_iter().chain(load.moment.0.map(|m| m / moment))
        };
        loads.iter().flat_map(of).collect()
    }

    fn loads_of(&self, numbers: &[f64]) -> Vec<Wrench<f64>> {
        let [force, moment] = self.units();
        let load = |n: &[f64]| Wrench {
            force: Vec3::new(n[0], n[1], n[2]) * force,
            moment: Vec3::new(n[3], n[4], n[5]) * moment,
        };
        numbers.chunks_exact(6).map(load).collect()
    }

    /// Largest difference.
    fn apart(&self, one: &[Wrench<f64>], other: &[Wrench<f64>]) -> f64 {
        let (one, other) = (self.numbers(one), self.numbers(other));
        // What is no number is no agreement.
        let far = |(a, b): (&f64, &f64)| if (a - b).is_finite() { (a - b).abs() } else { f64::INFINITY };
        one.iter().zip(&other).map(far).fold(0.0, f64::max)
    }
}
