//! The one loop that advances time: a system's state, clock and inputs.

use super::accuracy::{self, Accuracy, Clocked, Taken};
use super::system::{Driver, Ending, Held, Moment, Observed, Sizes, System};
use std::ops::{ControlFlow, Deref};
use wingbeat_math::{Dynamics, EqualSteps, RK4, Workspace};
use wingbeat_ocp::plant::Fault;

/// Halvings of a step that place an event in it: to 1e-12 of the step.
const HALVINGS: usize = 40;

/// All that changes while a system is stepped, as [`Stepper::save`] gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct Saved<M = ()> {
    x: Vec<f64>,
    u: Vec<f64>,
    memory: M,
    clock: EqualSteps,
}

impl Saved {
    /// State, inputs, and the clock as the time at which it was set (s), the length of its steps (s) and their number.
    pub fn parts(&self) -> (&[f64], &[f64], (f64, f64, usize)) {
        (&self.x, &self.u, (self.clock.start, self.clock.length, self.clock.first))
    }

    /// What [`parts`](Self::parts) gave.
    pub fn of_parts(x: Vec<f64>, u: Vec<f64>, (start, length, first): (f64, f64, usize)) -> Self {
        Self { x, u, memory: (), clock: EqualSteps { first, ..EqualSteps::new(start, length, 0) } }
    }
}

/// A system under way: state, clock, inputs and memory, advanced by classical Runge-Kutta steps.
/// Holds the system by reference, `Box` or `Arc`. Stepping allocates nothing after the first step of a thread.
///
/// ```
/// use wingbeat_math::Scalar;
/// use wingbeat_ocp::plant::{Channel, Fault, Plant};
/// use wingbeat_flight::simulate::Stepper;
///
/// /// A mass of 1 kg pushed by a force of at most 2 N.
/// struct Mass([Channel; 2], [Channel; 1]);
///
/// impl Plant for Mass {
///     fn states(&self) -> &[Channel] {
///         &self.0
///     }
///     fn inputs(&self) -> &[Channel] {
///         &self.1
///     }
///     fn rates<S: Scalar>(&self, _: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
///         (dx[0], dx[1]) = (x[1], u[0]);
///         Ok(())
///     }
/// }
///
/// let states = [Channel::free("place", "m", "W"), Channel::free("speed", "m/s", "W")];
/// let mass = Mass(states, [Channel::limited("force", "N", "W", -2.0, 2.0)]);
/// let mut stepper = Stepper::new(&mass, 0.0, &[0.0, 0.0]);
/// stepper.set_inputs(&[5.0]);
/// let start = stepper.save();
/// for _ in 0..10 {
///     stepper.step(0.1)?;
/// }
/// assert_eq!(stepper.inputs(), [2.0]);
/// assert!((stepper.time() - 1.0).abs() < 1e-15 && (stepper.state()[0] - 1.0).abs() < 1e-14);
/// stepper.restore(&start);
/// assert_eq!((stepper.time(), stepper.state()), (0.0, [0.0, 0.0].as_slice()));
/// # Ok::<(), Fault>(())
/// ```
pub struct Stepper<R: Deref<Target: System>> {
    system: R,
    x: Vec<f64>,
    u: Vec<f64>,
    memory: <R::Target as System>::Memory,
    /// `first` steps of `length` were taken since `start`; `count` is of no meaning here.
    clock: EqualSteps,
    work: Workspace<f64>,
}

impl<R: Deref<Target: System>> Stepper<R> {
    /// `system` at the time `t` (s) in the state `x`, inputs at zero or the nearest allowed.
    ///
    /// # Panics
    /// When `x` has not one number per state.
    pub fn new(system: R, t: f64, x: &[f64]) -> Self {
        let Sizes { states, inputs } = system.sizes();
        let mut stepper = Self {
            x: vec![0.0; states],
            u: vec![0.0; inputs],
            memory: Default::default(),
            clock: EqualSteps::new(t, 0.0, 0),
            work: Workspace::new(states, RK4.b.len()),
            system,
        };
        stepper.reset(t, x);
        stepper
    }

    /// Starts anew at the time `t` (s) in the state `x`: empty memory, inputs at zero or the
    /// nearest allowed.
    ///
    /// # Panics
    /// When `x` has not one number per state.
    pub fn reset(&mut self, t: f64, x: &[f64]) {
        self.x.copy_from_slice(x);
        self.memory = Default::default();
        self.u.fill(0.0);
        self.system.limit(&mut self.u);
        self.set_time(t);
    }

    /// The system.
    pub fn system(&self) -> &R::Target {
        &self.system
    }
    /// Time, s.
    pub fn time(&self) -> f64 {
        self.clock.time(self.clock.first)
    }
    /// Sets the clock, s, and nothing else: what is periodic begins its next cycle.
    pub fn set_time(&mut self, t: f64) {
        self.clock = EqualSteps::new(t, 0.0, 0);
    }
    /// State, in the units of its channels.
    pub fn state(&self) -> &[f64] {
        &self.x
    }
    /// The same, to be set.
    pub fn state_mut(&mut self) -> &mut [f64] {
        &mut self.x
    }
    /// What the system carries, to be set.
    pub fn memory_mut(&mut self) -> &mut <R::Target as System>::Memory {
        &mut self.memory
    }
    /// Inputs in force, in the units of their channels.
    pub fn inputs(&self) -> &[f64] {
        &self.u
    }
    /// Sets the inputs, limited to what the system can do.
    ///
    /// # Panics
    /// When `u` has not one number per input.
    pub fn set_inputs(&mut self, u: &[f64]) {
        self.u.copy_from_slice(u);
        self.system.limit(&mut self.u);
    }
    /// The present instant.
    pub fn moment(&self) -> Moment<'_, <R::Target as System>::Memory> {
        Moment { t: self.time(), x: &self.x, u: &self.u, memory: &self.memory }
    }

    /// Looks at the system now.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn observe(&self) -> Result<<R::Target as Observed>::Observation, Fault>
    where
        R::Target: Observed,
    {
        self.system.observed(self.moment())
    }

    /// All that changes, for [`restore`](Self::restore).
    pub fn save(&self) -> Saved<<R::Target as System>::Memory> {
        Saved { x: self.x.clone(), u: self.u.clone(), memory: self.memory.clone(), clock: self.clock }
    }

    /// Goes back to what was saved; what follows repeats to the bit.
    ///
    /// # Panics
    /// When `saved` is of a system of other sizes.
    pub fn restore(&mut self, saved: &Saved<<R::Target as System>::Memory>) {
        self.x.copy_from_slice(&saved.x);
        self.u.copy_from_slice(&saved.u);
        self.memory.clone_from(&saved.memory);
        self.clock = saved.clock;
    }

    /// One step of `dt` seconds under the inputs as they are set.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable; time and state are then those before the
    /// step, or a state that is not finite.
    pub fn step(&mut self, dt: f64) -> Result<(), Fault> {
        self.run(dt, 1, &mut Held(|_, _: Moment<_>| Ok(ControlFlow::Continue(())))).check()
    }

    /// Whether the state can be gone on from.
    ///
    /// # Errors
    /// [`Fault::NotFinite`] with the first state that is not finite.
    pub fn check(&self) -> Result<(), Fault> {
        finite(&self.x, self.time())
    }

    /// Moves the clock on by `steps` steps of `dt` seconds that were taken elsewhere.
    pub(super) fn count_steps(&mut self, dt: f64, steps: usize) {
        if self.clock.length != dt {
            self.clock = EqualSteps::new(self.time(), dt, 0);
        }
        self.clock.first += steps;
    }

    /// `steps` steps of `dt` seconds steered by `driver`, which sees the ends of all steps, unless its event ends the run within one.
    /// There is one copy of the loop for each system, whoever drives it.
    pub fn run(
        &mut self,
        dt: f64,
        steps: usize,
        driver: &mut dyn Driver<<R::Target as System>::Memory>,
    ) -> Ending {
        self.driven(dt, steps, driver, &mut |run, todo, x, work| RK4.integrate(run, todo, x, work))
    }

    /// As [`run`](Self::run) in steps as long as `asked` allows; all ends of steps of `dt` seconds are seen, and those at which something is
    /// decided are met. Says what steps were taken.
    pub fn run_within(
        &mut self,
        dt: f64,
        steps: usize,
        driver: &mut dyn Driver<<R::Target as System>::Memory>,
        asked: &Accuracy,
    ) -> (Ending, Taken) {
        let mut taken = Taken::default();
        let ending = self.driven(dt, steps, driver, &mut |run, todo, x, _| {
            let (whole, all) = accuracy::integrate(run, asked, todo, x)?;
            taken = all;
            Ok(whole)
        });
        (ending, taken)
    }

    fn driven(
        &mut self,
        dt: f64,
        steps: usize,
        driver: &mut dyn Driver<<R::Target as System>::Memory>,
        integrate: Integrate<R::Target>,
    ) -> Ending {
        self.count_steps(dt, 0);
        let began = self.clock.first;
        let Self { system, x, u, memory, clock, work } = self;
        let todo = EqualSteps { count: steps, ..*clock };
        // Kept only where an event may end a step.
        let before = if driver.event(todo.time(todo.first), x).is_finite() { x.clone() } else { Vec::new() };
        let mut run = StepperRun { system: &**system, memory, u, clock, began, driver, before };
        let end = run.boundary(x).and_then(|flow| match flow {
            ControlFlow::Break(()) => Ok(false),
            ControlFlow::Continue(()) => integrate(&mut run, todo, x, work),
        });
        match end {
            Ok(true) => Ending::Complete,
            Ok(false) => Ending::Stopped,
            Err(fault) => Ending::Fault(fault),
        }
    }
}

/// Takes steps of a run; says whether all were taken.
type Integrate<'a, S> = &'a mut dyn FnMut(
    &mut StepperRun<'_, S>,
    EqualSteps,
    &mut [f64],
    &mut Workspace<f64>,
) -> Result<bool, Fault>;

/// A run as the integrator sees it.
struct StepperRun<'a, S: System + ?Sized> {
    system: &'a S,
    memory: &'a mut S::Memory,
    u: &'a mut [f64],
    clock: &'a mut EqualSteps,
    began: usize,
    driver: &'a mut dyn Driver<S::Memory>,
    /// State at the start of the step, where an event may end it.
    before: Vec<f64>,
}

impl<S: System + ?Sized> StepperRun<'_, S> {
    /// Ends the step `k`, at whose end the state is `x`, at the event within it.
    ///
    /// Equation: flight.event
    /// `g(t + s h, x(t + s h)) = 0, x by a Runge-Kutta step of length s h from the start of the step, s by bisection`
    /// Source: Hairer, Noersett & Wanner 1993, Solving Ordinary Differential Equations I, II.6; order 4, as the step.
    /// Test: `the_instant_of_an_event_is_of_the_order_of_the_steps`.
    fn end_within(&mut self, k: usize, x: &mut [f64]) -> Result<ControlFlow<()>, Fault> {
        let (start, length) = (self.clock.time(k), self.clock.length);
        let (before, mut work) = (std::mem::take(&mut self.before), Workspace::new(x.len(), RK4.b.len()));
        let (mut early, mut late, mut trial) = (0.0, 1.0, before.clone());
        for _ in 0..HALVINGS {
            let share = 0.5 * (early + late);
            trial.copy_from_slice(&before);
            RK4.step(|t, x, dx| self.slope(t, x, dx), start, share * length, &mut trial, &mut work)?;
            match self.driver.event(start + share * length, &trial) > 0.0 {
                true => early = share,
                false => {
                    late = share;
                    x.copy_from_slice(&trial);
                }
            }
        }
        let t = start + late * length;
        self.set_inputs(t);
        self.system.advance(t, late * length, x, self.u, self.memory)?;
        *self.clock = EqualSteps::new(t, length, 0);
        self.driver.ended(Moment { t, x, u: self.u, memory: self.memory })?;
        Ok(ControlFlow::Break(()))
    }

    fn set_inputs(&mut self, t: f64) {
        self.driver.inputs(t, self.u);
        self.system.limit(self.u);
    }

    /// Between two steps: decide, apply, look.
    fn boundary(&mut self, x: &[f64]) -> Result<ControlFlow<()>, Fault> {
        let (k, t) = (self.clock.first - self.began, self.clock.time(self.clock.first));
        self.driver.decide(k, t, x);
        self.set_inputs(t);
        self.driver.observe(k, Moment { t, x, u: self.u, memory: self.memory })
    }
}

impl<S: System + ?Sized> Dynamics<f64, Fault> for StepperRun<'_, S> {
    fn slope(&mut self, t: f64, x: &[f64], dx: &mut [f64]) -> Result<(), Fault> {
        self.set_inputs(t);
        self.system.slope(Moment { t, x, u: self.u, memory: self.memory }, dx)
    }

    fn after_step(&mut self, k: usize, t: f64, x: &mut [f64]) -> Result<ControlFlow<()>, Fault> {
        finite(x, self.clock.time(k))?;
        if !self.before.is_empty() && self.driver.event(t, x) <= 0.0 {
            return self.end_within(k, x);
        }
        self.system.advance(t, self.clock.length, x, self.u, self.memory)?;
        self.clock.first = k + 1;
        self.before.iter_mut().zip(&*x).for_each(|(before, x)| *before = *x);
        self.boundary(x)
    }
}

impl<S: System + ?Sized> Clocked for StepperRun<'_, S> {
    fn next(&self, k: usize) -> usize {
        self.driver.next(k - self.began).saturating_add(self.began)
    }
    fn settle(&mut self, t: f64, length: f64, x: &mut [f64]) -> Result<(), Fault> {
        self.system.advance(t, length, x, self.u, self.memory)
    }
}

/// Whether a state can be gone on from.
pub(super) fn finite(x: &[f64], time: f64) -> Result<(), Fault> {
    match x.iter().position(|v| !v.is_finite()) {
        Some(state) => Err(Fault::NotFinite { state, time }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point that leaves a mark behind at every step and is drawn to the mean of its marks:
    /// a system with a stepped memory.
    struct Trail;

    impl System for Trail {
        type Memory = Vec<f64>;

        fn sizes(&self) -> Sizes {
            Sizes { states: 1, inputs: 1 }
        }
        fn slope(&self, at: Moment<Vec<f64>>, dx: &mut [f64]) -> Result<(), Fault> {
            let mean = at.memory.iter().sum::<f64>() / at.memory.len().max(1) as f64;
            dx[0] = at.u[0] - at.x[0] + mean;
            Ok(())
        }
        fn limit(&self, u: &mut [f64]) {
            u[0] = u[0].min(1.0);
        }
        fn advance(
            &self,
            t: f64,
            dt: f64,
            x: &mut [f64],
            _: &[f64],
            memory: &mut Vec<f64>,
        ) -> Result<(), Fault> {
            memory.push(x[0] * (t / dt).round());
            Ok(())
        }
    }

    fn states(stepper: &mut Stepper<&Trail>, steps: usize) -> Vec<f64> {
        let mut seen = Vec::new();
        let ending = stepper.run(
            0.1,
            steps,
            &mut Held(|_, at: Moment<_>| {
                seen.push(at.x[0]);
                Ok(ControlFlow::Continue(()))
            }),
        );
        assert_eq!(ending, Ending::Complete);
        seen
    }

    #[test]
    fn what_is_saved_repeats_to_the_bit_with_its_memory() {
        let mut stepper = Stepper::new(&Trail, 0.0, &[0.0]);
        stepper.set_inputs(&[3.0]);
        assert_eq!(stepper.inputs(), [1.0]);
        states(&mut stepper, 7);
        let saved = stepper.save();
        let first = states(&mut stepper, 5);
        assert_eq!(stepper.moment().memory.len(), 12);
        stepper.restore(&saved);
        assert_eq!((stepper.time(), stepper.moment().memory.len()), (0.1 * 7.0, 7));
        assert_eq!(states(&mut stepper, 5), first);
        stepper.reset(2.0, &[0.5]);
        assert!(stepper.moment().memory.is_empty() && stepper.inputs() == [0.0] && stepper.time() == 2.0);
    }

    #[test]
    fn single_steps_are_those_of_a_run() {
        let (mut one, mut run) = (Stepper::new(&Trail, 0.0, &[0.2]), Stepper::new(&Trail, 0.0, &[0.2]));
        (0..9).for_each(|_| one.step(0.1).unwrap());
        states(&mut run, 9);
        assert_eq!(one.save(), run.save());
        one.step(0.05).unwrap();
        assert_eq!(one.time(), 0.1 * 9.0 + 0.05);
    }

    /// A mass that falls, and whoever waits for it at a height of 0.
    struct Fall;

    impl System for Fall {
        type Memory = ();

        fn sizes(&self) -> Sizes {
            Sizes { states: 2, inputs: 0 }
        }
        fn slope(&self, at: Moment, dx: &mut [f64]) -> Result<(), Fault> {
            (dx[0], dx[1]) = (at.x[1], -2.0);
            Ok(())
        }
    }

    #[derive(Default)]
    struct Waits {
        seen: usize,
        ended: Option<(f64, f64)>,
    }

    impl Driver<()> for Waits {
        fn inputs(&self, _: f64, _: &mut [f64]) {}
        fn observe(&mut self, _: usize, _: Moment) -> Result<ControlFlow<()>, Fault> {
            self.seen += 1;
            Ok(ControlFlow::Continue(()))
        }
        fn event(&self, _: f64, x: &[f64]) -> f64 {
            x[0]
        }
        fn ended(&mut self, at: Moment) -> Result<(), Fault> {
            self.ended = Some((at.t, at.x[1]));
            Ok(())
        }
    }

    /// Height 1 - t^2: it is 0 after 1 s, whatever the steps.
    #[test]
    fn an_event_ends_a_run_within_its_step() {
        for (step, seen) in [(0.3, 4), (0.7, 2)] {
            let (mut stepper, mut driver) = (Stepper::new(&Fall, 0.0, &[1.0, 0.0]), Waits::default());
            assert_eq!(stepper.run(step, 9, &mut driver), Ending::Stopped);
            let (t, speed) = driver.ended.unwrap();
            assert!((t - 1.0).abs() < 1e-12 && (speed + 2.0).abs() < 1e-12, "{t} {speed}");
            assert_eq!((stepper.time(), driver.seen), (t, seen));
            assert!(stepper.state()[0] <= 0.0 && stepper.state()[0] > -1e-11);
        }
        let mut driver = Waits::default();
        assert_eq!(Stepper::new(&Fall, 0.0, &[1.0, 0.0]).run(0.3, 3, &mut driver), Ending::Complete);
        assert!(driver.ended.is_none());
    }

    /// A mass on a spring.
    struct Swing;

    impl System for Swing {
        type Memory = ();

        fn sizes(&self) -> Sizes {
            Sizes { states: 2, inputs: 0 }
        }
        fn slope(&self, at: Moment, dx: &mut [f64]) -> Result<(), Fault> {
            (dx[0], dx[1]) = (at.x[1], -at.x[0]);
            Ok(())
        }
    }

    /// cos t is no polynomial: where it becomes 0 is found with an error that falls by 16 as the step halves, order 4.
    #[test]
    fn the_instant_of_an_event_is_of_the_order_of_the_steps() {
        let missed = |step: f64| {
            let mut driver = Waits::default();
            assert_eq!(Stepper::new(&Swing, 0.0, &[1.0, 0.0]).run(step, 99, &mut driver), Ending::Stopped);
            driver.ended.unwrap().0 - std::f64::consts::FRAC_PI_2
        };
        let errors = [0.3, 0.15, 0.075].map(missed);
        assert!(errors[0].abs() > 1e-5, "{errors:?}");
        let orders = [0, 1].map(|i: usize| (errors[i] / errors[i + 1]).log2());
        assert!(orders.iter().all(|order| (order - 4.0).abs() < 0.1), "{orders:?}");
    }

    #[test]
    fn a_state_that_is_not_finite_ends_the_run_at_its_step() {
        let mut stepper = Stepper::new(&Trail, 0.0, &[0.0]);
        stepper.step(0.1).unwrap();
        stepper.state_mut()[0] = f64::NAN;
        assert_eq!(stepper.step(0.1), Err(Fault::NotFinite { state: 0, time: 0.1 }));
        assert_eq!(stepper.time(), 0.1);
    }
}
