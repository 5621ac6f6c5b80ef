//! The loads of a tethered wing over its last cycle, with their derivatives by numbers of the wing and its air.

use super::Tether;
use super::numbers::WingNumbers;
use crate::simulate::{Ending, Held, Moment, Observed, Sensitive, Sizes, Stepper, System, Varied, packed};
use std::ops::ControlFlow;
use wingbeat_aero::{Aero, Loads, SectionMotion};
use wingbeat_math::Error;
use wingbeat_math::names::one_of;
use wingbeat_math::{Declared, Parameters, Scalar, Vec3, Wrench};
use wingbeat_ocp::plant::Fault;
use wingbeat_robot::{TOGETHER, Varying};

/// Columns of the wrench about the body's origin in B.
pub const BODY_LOADS: [&str; 6] = ["force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z"];
/// Forces and moments about the body's origin in B, N and N m, one per step of a cycle.
pub type CycleWrenches = Vec<[f64; 6]>;

impl Tether {
    /// The wrench of the air on the wing over the last cycle, its end left out.
    ///
    /// # Errors
    /// A fault of the model.
    pub fn last_wrenches(&self) -> Result<CycleWrenches, Fault> {
        if self.spar.is_some() {
            return self.last_of_run();
        }
        let weights = self.strip_weights();
        self.last_cycle(self, &self.start(), |t, loads| self.in_body(t, loads, &weights))
    }

    /// The same of a wing that bends, from its record.
    fn last_of_run(&self) -> Result<CycleWrenches, Fault> {
        let run = self.run(|_| ControlFlow::Continue(()));
        if let Ending::Fault(fault) = run.ending {
            return Err(fault);
        }
        if run.steady.is_some_and(|steady| !steady.found) {
            return Err(Fault::Structure { time: 0.0 });
        }
        let columns = BODY_LOADS.map(|name| run.loads.values(name).unwrap_or_default());
        let last = self.clock.steps() - self.clock.steps_per_cycle..self.clock.steps();
        let row = |step: usize| columns.map(|column| column.get(step).copied().unwrap_or(f64::NAN));
        Ok(last.map(row).collect())
    }

    /// The derivatives of [`last_wrenches`](Self::last_wrenches) by the numbers called `keys`, as a robot calls those of its wing, in their order. They
    /// are those of the steps taken, to rounding.
    ///
    /// # Errors
    /// An unknown number; a fault of the model.
    pub fn differentiated(&self, keys: &[&str]) -> Result<Result<Vec<CycleWrenches>, Fault>, Error> {
        if self.spar.is_some() {
            return Err(Error::invalid("spar", "given", "none where loads are differentiated by numbers"));
        }
        if let Some(plane) = &self.ground {
            let allowed = "none where loads are differentiated by numbers";
            return Err(Error::invalid("air.ground_m", plane.height_m, allowed));
        }
        let mut all = Vec::with_capacity(keys.len());
        for keys in keys.chunks(TOGETHER) {
            match self.batch(keys)? {
                Ok(batch) => all.extend(batch),
                Err(fault) => return Ok(Err(fault)),
            }
        }
        Ok(Ok(all))
    }

    fn batch(&self, keys: &[&str]) -> Result<Result<Vec<CycleWrenches>, Fault>, Error> {
        let numbers = WingNumbers::of(&self.aero);
        let known = numbers.named(&|_, _, _| None);
        let names: Vec<&str> = known.iter().map(|number| number.name.as_str()).collect();
        if let Some(unknown) = keys.iter().find(|key| !names.contains(key)) {
            return Err(Error::invalid("numbers", unknown, one_of(unknown, &names)));
        }
        let eps = |name: &str| {
            std::array::from_fn(|k| f64::from(u8::from(keys.get(k).is_some_and(|key| *key == name))))
        };
        let varied = |number: Declared, re| Varying { re, eps: eps(number.name) };
        let WingNumbers(numbers) = numbers.map_named(&|_, _, _| None, Varying::constant, varied);
        let wing = VariedWing { of: self, aero: self.aero.with(&numbers)?, weights: self.strip_weights() };
        let mut x = vec![Varying::ZERO; wing.aero.states()];
        wing.aero.settle(&wing.sections(0.0), wing.wind(), &mut x);
        Ok(self.last_cycle(&Sensitive(wing), &packed(x), |_, now| *now).map(|rows| {
            let of = |k: usize| rows.iter().map(|row| row.map(|number| number.eps[k])).collect();
            (0..keys.len()).map(of).collect()
        }))
    }

    /// What `see` makes of every step of the last cycle of `system`, which begins in the state `x`.
    fn last_cycle<T: Observed + System<Memory = ()>, R>(
        &self,
        system: &T,
        x: &[f64],
        see: impl Fn(f64, &T::Observation) -> R,
    ) -> Result<Vec<R>, Fault> {
        let clock = self.clock;
        let last = clock.steps() - clock.steps_per_cycle..clock.steps();
        let mut rows = Vec::with_capacity(clock.steps_per_cycle);
        let mut watch = Held(|step: usize, at: Moment| {
            if last.contains(&step) {
                rows.push(see(at.t, &system.observed(at)?));
            }
            Ok(ControlFlow::Continue(()))
        });
        match Stepper::new(system, 0.0, x).run(clock.step(), clock.steps(), &mut watch) {
            Ending::Fault(fault) => Err(fault),
            Ending::Complete | Ending::Stopped => Ok(rows),
        }
    }

    /// Loads in W about W's origin, at `t`, of the strips that count, as the wrench about the body's origin in B.
    fn in_body<S: Scalar>(&self, t: f64, loads: &Loads<S>, weights: &[f64]) -> [S; 6] {
        let frame = self.motion.body(t).frame();
        let back = frame.turn.each(|j| S::from(j.x)).transpose();
        let origin = frame.origin.each(|j| S::from(j.x));
        let mut sum = Wrench::ZERO;
        for (strip, weight) in loads.strip[..loads.strips].iter().zip(weights) {
            let total = strip.total();
            sum += Wrench { force: total.force * S::from(*weight), moment: total.moment * S::from(*weight) };
        }
        let (Vec3(f), Vec3(m)) = (back * sum.force, back * (sum.moment - origin.cross(sum.force)));
        [f[0], f[1], f[2], m[0], m[1], m[2]]
    }
}

/// A run whose states are those of the air with their derivatives.
struct VariedWing<'a> {
    of: &'a Tether,
    aero: Aero<Varying>,
    weights: Vec<f64>,
}

impl VariedWing<'_> {
    fn wind(&self) -> Vec3<Varying> {
        self.of.wind.each(Varying::constant)
    }

    fn sections(&self, t: f64) -> Vec<SectionMotion<Varying>> {
        let count = self.aero.arcs().len();
        self.of.sections(t)[..count].iter().map(lifted).collect()
    }
}

/// A section whose motion no number moves.
fn lifted(section: &SectionMotion<f64>) -> SectionMotion<Varying> {
    let vector = |v: Vec3| v.each(Varying::constant);
    SectionMotion {
        le: vector(section.le),
        te: vector(section.te),
        v_le: vector(section.v_le),
        v_te: vector(section.v_te),
        a_le: vector(section.a_le),
        a_te: vector(section.a_te),
        span: vector(section.span),
        w: vector(section.w),
        alpha: vector(section.alpha),
    }
}

impl Varied<TOGETHER> for VariedWing<'_> {
    type Seen = [Varying; 6];

    fn sizes(&self) -> Sizes {
        Sizes { states: self.aero.states(), inputs: 0 }
    }

    fn evaluated(
        &self,
        t: f64,
        x: &[Varying],
        _: &[f64],
        rates: &mut [Varying],
    ) -> Result<[Varying; 6], Fault> {
        let mut loads = Loads::default();
        self.aero.evaluate_in_varying(&self.sections(t), self.wind(), x, rates, &mut loads);
        Ok(self.of.in_body(t, &loads, &self.weights))
    }
}
