//! Robots in air that is stepped beside them and bears on them together with their motion.

use super::fly::{Controller, Flight, Pilot, Sample, SampleObserver, Schedule};
use super::secant::Secant;
use super::sensor::Sensors;
use super::stepper::Stepper;
use super::system::{Driver, Ending, Moment, Sizes, System, upright};
use std::ops::ControlFlow;
use wingbeat_math::{GRAVITY, Vec3, Wrench};
use wingbeat_ocp::plant::Fault;
use wingbeat_robot::{BeyondLoads, Robot, Stance};

/// Air that is stepped beside a robot: it takes the place of all that the robot's own models say of attached flow, profile drag is
/// theirs.
pub trait Flow {
    /// Steps of the flight that one step of the air takes.
    fn every(&self) -> usize;

    /// Length with which moments are compared with forces, m.
    fn length(&self) -> f64;

    /// Loads of the air on links, body and what bends at its next instant, `t` s, if the robot is then as it is `at`: as
    /// [`Robot::rates_beyond`] takes them, those of attached flow whole, with what bends bears of its own inertia and weight. The first
    /// instant is the begin.
    ///
    /// # Errors
    /// [`Fault::Flow`].
    fn loads(&mut self, t: f64, at: &Stance) -> Result<BeyondLoads, Fault>;

    /// Goes on from what was asked for last to the instant after it.
    fn keep(&mut self);

    /// How fine the steps so far were.
    fn fineness(&self) -> Fineness;
}

/// Way of the surfaces' trailing edges through the air in a step, rms over edges and steps in which they moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fineness {
    /// In chords of a panel, a ratio; 0 where nothing moved.
    pub panels: f64,
    /// In radii of the wake's cores, a ratio.
    pub cores: f64,
    /// Largest way of a vortex in a step that has left a leading edge, as a ratio to the length of the air; none in attached
    /// flow.
    pub sheet: Option<f64>,
    /// Share of trailing edges and steps at which the air comes in.
    pub inflow: f64,
}

/// How the motion of a robot and the air beside it were brought together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AirCoupling {
    /// Step of the air, s.
    pub step: f64,
    /// Steps of the air.
    pub steps: usize,
    /// States of the robot that were tried.
    pub iterations: usize,
    /// Most of them in a step.
    pub most: usize,
    /// How fine the steps were.
    pub fineness: Fineness,
}

/// Change of a load below which motion and air agree, weights.
const TOLERANCE: f64 = 1e-6;
/// Most states tried for one step. *Choice.*
const MOST: usize = 40;

/// What the air bears beyond the robot's models, straight from the begin of a step of the air to its end, on flaps as at its end.
#[derive(Clone, Debug, Default)]
pub struct Beyond {
    from: f64,
    length: f64,
    ends: [BeyondLoads; 2],
}

impl Beyond {
    /// The loads at `t` s.
    pub fn at(&self, t: f64) -> BeyondLoads {
        let share = (t - self.from) / self.length;
        self.ends[0].with(&self.ends[1], |a, b| a + (b - a) * share)
    }
}

/// A system that moves a robot, with loads of the air beside it in its memory.
pub trait Bears: System<Memory = Beyond> {
    /// The robot.
    fn robot(&self) -> &Robot;

    /// How the robot is in the state `x` at `t` s under the inputs `u` and the loads `beyond`.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    fn stance(&self, t: f64, x: &[f64], u: &[f64], beyond: &BeyondLoads) -> Result<Stance, Fault>;

    /// As [`Robot::attached_loads`].
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    fn attached_loads(
        &self,
        t: f64,
        x: &[f64],
        u: &[f64],
        beyond: &BeyondLoads,
    ) -> Result<BeyondLoads, Fault>;
}

/// A robot in flight.
struct FlyingRobot<'a>(&'a Robot);

impl System for FlyingRobot<'_> {
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

impl Bears for FlyingRobot<'_> {
    fn robot(&self) -> &Robot {
        self.0
    }
    fn stance(&self, t: f64, x: &[f64], u: &[f64], beyond: &BeyondLoads) -> Result<Stance, Fault> {
        let stance = self.0.stance(t, x);
        if !self.0.has_bent_chords() {
            return Ok(stance);
        }
        let (mut dx, air) = (vec![0.0; x.len()], self.0.layout().aero);
        self.0.rates_beyond(t, x, u, beyond, &mut dx)?;
        Ok(self.0.bent_as(stance, (&x[air..], &dx[air..])))
    }
    fn attached_loads(
        &self,
        t: f64,
        x: &[f64],
        u: &[f64],
        beyond: &BeyondLoads,
    ) -> Result<BeyondLoads, Fault> {
        self.0.attached_loads(t, x, u, beyond)
    }
}

/// Who steers a system that bears loads of the air, and watches it; `k` counts its steps.
pub trait Steers {
    /// Decides anew before step `k`, at the time `_t` (s) in the state `_x`.
    fn update(&mut self, _k: usize, _t: f64, _x: &[f64]) {}

    /// Writes what is decided for the time `t` (s), in the units of the inputs; what it leaves alone stays as it was.
    fn planned(&self, _t: f64, _u: &mut [f64]) {}

    /// Sees the system before step `k`, or after the last, under the loads `beyond` (N and N m), and stops by `Break`.
    ///
    /// # Errors
    /// The [`Fault`] of a system that cannot be looked at.
    fn see(
        &mut self,
        k: usize,
        at: (f64, &[f64], &[f64]),
        beyond: &BeyondLoads,
    ) -> Result<ControlFlow<()>, Fault>;
}

/// Steers as decided: nobody sees it.
struct TrialSteers<'a>(&'a dyn Steers);

/// Steers as decided and shows all but the last end of its steps; its first is the step `first` of all.
struct Kept<'a> {
    steering: &'a mut dyn Steers,
    first: usize,
    steps: usize,
}

impl Driver<Beyond> for TrialSteers<'_> {
    fn inputs(&self, t: f64, u: &mut [f64]) {
        self.0.planned(t, u);
    }
    fn observe(&mut self, _: usize, _: Moment<Beyond>) -> Result<ControlFlow<()>, Fault> {
        Ok(ControlFlow::Continue(()))
    }
}

impl Driver<Beyond> for Kept<'_> {
    fn inputs(&self, t: f64, u: &mut [f64]) {
        self.steering.planned(t, u);
    }
    fn observe(&mut self, k: usize, at: Moment<Beyond>) -> Result<ControlFlow<()>, Fault> {
        if k == self.steps {
            return Ok(ControlFlow::Continue(()));
        }
        self.steering.see(self.first + k, (at.t, at.x, at.u), &at.memory.at(at.t))
    }
}

/// As [`fly`](super::fly), in the air `flow`. Every step of the air its loads at the end and the motion that leads there are found
/// together: the loads of the robot's own models, the reaction of accelerated air among them, act at every instant as they are, and
/// what the air bears beyond them, straight over the step and on flaps as at its end, is changed until there the sum is the load of the
/// air, to 1e-6 of the weight. The controller's updates lie on ends of steps of the air.
///
/// Equation: robot.coupling
/// `F = F_models(a) + g, g straight from step to step and such that F at its ends is the load of the air; g by
/// secants`
/// Source: defect correction; Anderson 1965, J. ACM 12(4); Degroote, Bathe & Vierendeels 2009, Comput. Struct. 87.
/// Test: `weak_coupling_diverges_where_strong_coupling_holds`.
pub fn fly_in<C: Controller + ?Sized>(
    robot: &Robot,
    flow: &mut dyn Flow,
    sensors: &mut Sensors,
    controller: &mut C,
    schedule: &Schedule,
    x: &mut [f64],
    mut observe: impl FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
) -> (Flight, AirCoupling) {
    let observe: SampleObserver<C> = &mut observe;
    let mut pilot = Pilot::new(robot, sensors, controller, schedule, observe);
    let system = FlyingRobot(robot);
    let mut stepper = Stepper::new(&system, 0.0, x);
    let (ending, coupling) = step_in(flow, &mut stepper, (schedule.step, schedule.steps), &mut pilot);
    x.copy_from_slice(stepper.state());
    (pilot.flight(ending, stepper.time()), coupling)
}

/// `steps` steps of `step` s in the air `flow`, as [`fly_in`] says.
pub fn step_in<B: Bears>(
    flow: &mut dyn Flow,
    stepper: &mut Stepper<&B>,
    steps: (f64, usize),
    steering: &mut dyn Steers,
) -> (Ending, AirCoupling) {
    let step = flow.every() as f64 * steps.0;
    let mut coupled = CoupledSteps { flow, coupling: AirCoupling { step, ..AirCoupling::default() } };
    let ending = coupled.run(stepper, steps, steering).unwrap_or_else(Ending::Fault);
    let fineness = coupled.flow.fineness();
    (ending, AirCoupling { fineness, ..coupled.coupling })
}

/// What is known as a step begins of what the air bears beyond the robot's models.
enum StepBegin {
    /// Nothing: all begins at once, so that what air and motion agree on at the end of the first step holds from its begin on.
    AtOnce,
    /// What it bore at the end of the first step.
    Second(Box<BeyondLoads>),
    /// What it bore at the end of the last step, and at the begin of that.
    Later { end: Box<BeyondLoads>, before: Box<BeyondLoads> },
}

struct CoupledSteps<'a> {
    flow: &'a mut dyn Flow,
    coupling: AirCoupling,
}

impl CoupledSteps<'_> {
    fn run<B: Bears>(
        &mut self,
        stepper: &mut Stepper<&B>,
        (step, steps): (f64, usize),
        steering: &mut dyn Steers,
    ) -> Result<Ending, Fault> {
        let (every, mut taken) = (self.flow.every(), 0);
        let mut loads = self.asked(stepper, &BeyondLoads::NONE)?;
        self.flow.keep();
        let mut begin = StepBegin::AtOnce;
        loop {
            let t = stepper.time();
            steering.update(taken, t, stepper.state());
            let mut u = stepper.inputs().to_vec();
            steering.planned(t, &mut u);
            stepper.set_inputs(&u);
            let known = match &begin {
                StepBegin::AtOnce => loads.with(&loads, |_, _| 0.0),
                StepBegin::Second(end) | StepBegin::Later { end, .. } => {
                    self.settled(stepper, &loads, BeyondLoads::clone(end))?
                }
            };
            if taken == steps {
                let (x, u) = (stepper.state().to_vec(), stepper.inputs().to_vec());
                let flow = steering.see(taken, (t, &x, &u), &known)?;
                return Ok(if flow.is_break() { Ending::Stopped } else { Ending::Complete });
            }
            let guess = match &begin {
                StepBegin::AtOnce | StepBegin::Second(_) => known.clone(),
                StepBegin::Later { before, .. } => known.with(before, |now, before| now * 2.0 - before),
            };
            let at_once = matches!(begin, StepBegin::AtOnce);
            let length = every as f64 * step;
            let mut memory = Beyond { from: t, length, ends: [known.clone(), guess] };
            loads = self.agreed(stepper, step, (&mut memory, at_once), &*steering)?;
            let now = every.min(steps - taken);
            let ending = stepper.run(step, now, &mut Kept { steering, first: taken, steps: now });
            if ending != Ending::Complete {
                return Ok(ending);
            }
            taken += now;
            let end = Box::new(memory.at(stepper.time()));
            if now < every {
                let own = own_loads(stepper, &end)?;
                loads = end.with(&own, |load, own| load + own);
            }
            begin = match at_once {
                true => StepBegin::Second(end),
                false => StepBegin::Later { end, before: Box::new(known) },
            };
        }
    }

    /// Tries a step of the air until its loads and those in `memory` agree at its end, where these are all `at_once` from its begin on; returns the
    /// loads of the air there, with the stepper at the begin of the step.
    fn agreed<B: Bears>(
        &mut self,
        stepper: &mut Stepper<&B>,
        step: f64,
        (memory, at_once): (&mut Beyond, bool),
        steering: &dyn Steers,
    ) -> Result<BeyondLoads, Fault> {
        let (saved, every) = (stepper.save(), self.flow.every());
        let mut secant = Secant::default();
        for tried in 1..=MOST {
            stepper.system().robot().hold_momenta(&mut memory.ends);
            stepper.restore(&saved);
            stepper.memory_mut().clone_from(memory);
            stepper.run(step, every, &mut TrialSteers(steering)).check()?;
            let loads = self.asked(stepper, &memory.ends[1])?;
            let found = self.beyond(stepper, &loads, &memory.ends[1])?;
            if self.apart(stepper, &memory.ends[1], &found) <= TOLERANCE {
                self.flow.keep();
                self.coupling.steps += 1;
                self.coupling.iterations += tried;
                self.coupling.most = self.coupling.most.max(tried);
                stepper.restore(&saved);
                stepper.memory_mut().clone_from(memory);
                return Ok(loads);
            }
            let next = self.next(stepper, &mut secant, &memory.ends[1], &found);
            if at_once {
                memory.ends[0].clone_from(&next);
            }
            memory.ends[1] = next;
        }
        let why = "its loads and the motion do not agree; try a shorter lattice.step_s, or lattice.crossing where parts of \
                   the robot pass through each other";
        Err(Fault::Flow { time: stepper.time(), why })
    }

    /// Loads of the air where the stepper is.
    fn asked<B: Bears>(&mut self, stepper: &Stepper<&B>, beyond: &BeyondLoads) -> Result<BeyondLoads, Fault> {
        let (t, x) = (stepper.time(), stepper.state());
        let at = stepper.system().stance(t, x, stepper.inputs(), beyond)?;
        self.flow.loads(t, &at)
    }

    /// What the air bears beyond the robot's models where the stepper is, its loads being `loads`, while `beyond` acts.
    fn beyond<B: Bears>(
        &self,
        stepper: &Stepper<&B>,
        loads: &BeyondLoads,
        beyond: &BeyondLoads,
    ) -> Result<BeyondLoads, Fault> {
        Ok(loads.with(&own_loads(stepper, beyond)?, |load, own| load - own))
    }

    /// That at which the sum is `loads` in the state as it is: the robot's own models feel the acceleration.
    fn settled<B: Bears>(
        &self,
        stepper: &Stepper<&B>,
        loads: &BeyondLoads,
        mut guess: BeyondLoads,
    ) -> Result<BeyondLoads, Fault> {
        let mut secant = Secant::default();
        for _ in 0..MOST {
            let found = self.beyond(stepper, loads, &guess)?;
            if self.apart(stepper, &guess, &found) <= TOLERANCE {
                return Ok(guess);
            }
            guess = self.next(stepper, &mut secant, &guess, &found);
        }
        Err(Fault::Flow { time: stepper.time(), why: "no acceleration fits its loads" })
    }

    /// The guess after `guess`, at which `found` was found.
    fn next<B: Bears>(
        &self,
        stepper: &Stepper<&B>,
        secant: &mut Secant,
        guess: &BeyondLoads,
        found: &BeyondLoads,
    ) -> BeyondLoads {
        let [force, moment] = self.units(stepper);
        let next = secant.next(&self.numbers(stepper, guess), &self.numbers(stepper, found));
        let load = |n: &[f64]| Wrench {
            force: Vec3::new(n[0], n[1], n[2]) * force,
            moment: Vec3::new(n[3], n[4], n[5]) * moment,
        };
        let (links, bends) = next.split_at(6 * guess.links.len());
        BeyondLoads {
            links: links.chunks_exact(6).map(load).collect(),
            bends: bends.iter().map(|of| of * moment).collect(),
        }
    }

    /// Units of force and moment.
    fn units<B: Bears>(&self, stepper: &Stepper<&B>) -> [f64; 2] {
        let weight = stepper.system().robot().mass() * GRAVITY;
        [weight, weight * self.flow.length()]
    }

    fn numbers<B: Bears>(&self, stepper: &Stepper<&B>, loads: &BeyondLoads) -> Vec<f64> {
        let [force, moment] = self.units(stepper);
        let of = |load: &Wrench<f64>| {
            load.force.0.map(|f| f / force).into_iter().chain(load.moment.0.map(|m| m / moment))
        };
        loads.links.iter().flat_map(of).chain(loads.bends.iter().map(|of| of / moment)).collect()
    }

    /// Largest difference.
    fn apart<B: Bears>(&self, stepper: &Stepper<&B>, one: &BeyondLoads, other: &BeyondLoads) -> f64 {
        let (one, other) = (self.numbers(stepper, one), self.numbers(stepper, other));
        // What is no number is no agreement.
        let far = |(a, b): (&f64, &f64)| if (a - b).is_finite() { (a - b).abs() } else { f64::INFINITY };
        one.iter().zip(&other).map(far).fold(0.0, f64::max)
    }
}

/// Loads of the robot's own models where the stepper is, while `beyond` acts.
fn own_loads<B: Bears>(stepper: &Stepper<&B>, beyond: &BeyondLoads) -> Result<BeyondLoads, Fault> {
    stepper.system().attached_loads(stepper.time(), stepper.state(), stepper.inputs(), beyond)
}
