//! The wrench on the cell over a run, with its derivatives by numbers of robot and rig.

use super::Experiment;
use super::carrier::Mount;
use super::cell::six;
use super::numbers::RigNumbers;
use crate::Error;
use crate::math::{Scalar, Vec3, Wrench};
use crate::plant::Fault;
use crate::robot::{Robot, TOGETHER, Varying};
use crate::simulate::{Ending, Held, Moment, Observed, Sizes, Stepper, System};
use std::ops::ControlFlow;

/// When a run is looked at: at equal steps, which are those of the integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instants {
    /// The first, s; the wings begin to flap at 0.
    pub begin: f64,
    /// Between them, s.
    pub step: f64,
    /// Steps after the first.
    pub steps: usize,
}

/// Fx .. Tz on the cell in its frame, N and N m, one per instant.
pub type Wrenches = Vec<[f64; 6]>;

impl Experiment<'_> {
    /// The wrench on the cell at `instants`, without noise; the air at rest at the first.
    ///
    /// # Errors
    /// A fault of the model.
    pub fn wrenches(&self, instants: &Instants) -> Result<Wrenches, Fault> {
        let begun =
            self.still(self.robot, (&self.numbers.mount(self.mount), &self.numbers), instants.begin)?;
        looked_at(self, &begun, instants, |now| six(&now.wrench))
    }

    /// The derivatives of [`wrenches`](Self::wrenches) by the numbers called `keys`, in their order: those of
    /// [`Robot::named_numbers`] and of [`RigNumbers`]. They are those of the steps taken, to rounding.
    ///
    /// # Errors
    /// An unknown number; a fault of the model.
    pub fn differentiated(
        &self,
        instants: &Instants,
        keys: &[&str],
    ) -> Result<Result<Vec<Wrenches>, Fault>, Error> {
        for key in keys.iter().filter(|key| RigNumbers::names_one(key)) {
            let mut known = self.numbers;
            known.set(key, 0.0)?;
        }
        let batches = self.robot.in_batches(keys, RigNumbers::names_one, |robot, keys| {
            let numbers = varied(&self.numbers, keys);
            let mount = numbers.mount(self.mount);
            let system = Sensitive { of: self, robot, mount, numbers };
            let begin = |x: Varying| std::iter::once(x.re).chain(x.eps);
            let begun = self.still(&system.robot, (&system.mount, &system.numbers), instants.begin)?;
            let still: Vec<f64> = begun.into_iter().flat_map(begin).collect();
            let rows = looked_at(&system, &still, instants, |now| *now)?;
            let of = |k: usize| rows.iter().map(|row| row.map(|number| number.eps[k])).collect();
            Ok((0..keys.len()).map(of).collect::<Vec<Wrenches>>())
        })?;
        Ok(batches.into_iter().collect::<Result<Vec<_>, _>>().map(|batches| batches.concat()))
    }
}

/// What `see` makes of every instant of `system`, which begins in the state `x`.
fn looked_at<T: Observed + System<Memory = ()>, R>(
    system: &T,
    x: &[f64],
    instants: &Instants,
    see: impl Fn(&T::Observation) -> R,
) -> Result<Vec<R>, Fault> {
    let mut rows = Vec::with_capacity(instants.steps + 1);
    let mut watch = Held(|_: usize, at: Moment| {
        rows.push(see(&system.observed(at)?));
        Ok(ControlFlow::Continue(()))
    });
    match Stepper::new(system, instants.begin, x).run(instants.step, instants.steps, &mut watch) {
        Ending::Fault(fault) => Err(fault),
        Ending::Complete | Ending::Stopped => Ok(rows),
    }
}

/// The numbers of the rig with those called `keys` as variables.
fn varied(numbers: &RigNumbers, keys: &[&str]) -> RigNumbers<Varying> {
    let mut varied = RigNumbers::<Varying>::constant(numbers);
    for (name, number) in varied.by_name() {
        for (variable, key) in number.eps.iter_mut().zip(keys) {
            *variable = f64::from(u8::from(name == *key));
        }
    }
    varied
}

/// A run whose states are those of the air with their derivatives: for each state its value, then the derivatives.
struct Sensitive<'a, 'b> {
    of: &'a Experiment<'b>,
    robot: Robot<Varying>,
    mount: Mount<Varying>,
    numbers: RigNumbers<Varying>,
}

/// Numbers per state.
const WIDTH: usize = 1 + TOGETHER;

/// States with their derivatives out of plain numbers.
fn lifted(x: &[f64]) -> Vec<Varying> {
    let one = |of: &[f64]| Varying { re: of[0], eps: std::array::from_fn(|k| of[1 + k]) };
    x.chunks_exact(WIDTH).map(one).collect()
}

impl Sensitive<'_, '_> {
    fn evaluated(&self, at: Moment, dx: &mut [f64]) -> Result<[Varying; 6], Fault> {
        let x = lifted(at.x);
        let u: Vec<Varying> = at.u.iter().map(|u| Varying::constant(*u)).collect();
        let mut rates = vec![Varying::ZERO; x.len()];
        let (cell, loads) =
            self.of.carried(&self.robot, (&self.mount, &self.numbers), (at.t, &x, &u), &mut rates)?;
        for (out, rate) in dx.chunks_exact_mut(WIDTH).zip(&rates) {
            out[0] = rate.re;
            out[1..].copy_from_slice(&rate.eps);
        }
        let wrench: Wrench<Varying> = self.mount.to_cell(&loads.total()) + self.mount.wrench(&cell);
        let (Vec3(f), Vec3(m)) = (wrench.force, wrench.moment);
        Ok([f[0], f[1], f[2], m[0], m[1], m[2]])
    }
}

impl System for Sensitive<'_, '_> {
    type Memory = ();

    fn sizes(&self) -> Sizes {
        Sizes { states: WIDTH * self.of.robot.carried_states(), inputs: self.of.sizes().inputs }
    }
    fn slope(&self, at: Moment, dx: &mut [f64]) -> Result<(), Fault> {
        self.evaluated(at, dx).map(drop)
    }
}

impl Observed for Sensitive<'_, '_> {
    type Observation = [Varying; 6];

    fn observed(&self, at: Moment) -> Result<[Varying; 6], Fault> {
        self.evaluated(at, &mut vec![0.0; at.x.len()])
    }
}
