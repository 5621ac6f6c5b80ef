//! The wrench on the cell over a run, with its derivatives by numbers of robot and rig.

use super::Experiment;
use super::carrier::CellMount;
use super::cell::six;
use super::numbers::RigNumbers;
use std::ops::ControlFlow;
use wingbeat_flight::simulate::{
    Ending, Held, Moment, Observed, Sensitive, Sizes, Stepper, System, Varied, packed,
};
use wingbeat_math::Error;
use wingbeat_math::{Parameters, Vec3, Wrench};
use wingbeat_ocp::plant::Fault;
use wingbeat_robot::{Robot, TOGETHER, Varying};

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
            let run = VariedRun { of: self, robot, mount, numbers };
            let begun = self.still(&run.robot, (&run.mount, &run.numbers), instants.begin)?;
            let rows = looked_at(&Sensitive(run), &packed(begun), instants, |now| *now)?;
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
    let eps = |name: &str| {
        std::array::from_fn(|k| f64::from(u8::from(keys.get(k).is_some_and(|key| *key == name))))
    };
    numbers.map_named(&|_, _, _| None, Varying::constant, |number, re| Varying { re, eps: eps(number.name) })
}

/// A run whose states are those of the air with their derivatives.
struct VariedRun<'a, 'b> {
    of: &'a Experiment<'b>,
    robot: Robot<Varying>,
    mount: CellMount<Varying>,
    numbers: RigNumbers<Varying>,
}

impl Varied<TOGETHER> for VariedRun<'_, '_> {
    type Seen = [Varying; 6];

    fn sizes(&self) -> Sizes {
        Sizes { states: self.of.robot.carried_states(), inputs: self.of.sizes().inputs }
    }

    fn evaluated(
        &self,
        t: f64,
        x: &[Varying],
        u: &[f64],
        rates: &mut [Varying],
    ) -> Result<[Varying; 6], Fault> {
        let u: Vec<Varying> = u.iter().map(|u| Varying::constant(*u)).collect();
        let (cell, loads) = self.of.carried(&self.robot, (&self.mount, &self.numbers), (t, x, &u), rates)?;
        let wrench: Wrench<Varying> = self.mount.to_cell(&loads.total()) + self.mount.wrench(&cell);
        let (Vec3(f), Vec3(m)) = (wrench.force, wrench.moment);
        Ok([f[0], f[1], f[2], m[0], m[1], m[2]])
    }
}
