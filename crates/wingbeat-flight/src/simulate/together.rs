//! Several robots of one kind, stepped at once in the lanes of a scalar.

use super::Stepper;
use super::system::upright;
use std::ops::{ControlFlow, Deref};
use wingbeat_math::{Dynamics, EqualSteps, Lanes, RK4, Workspace};
use wingbeat_ocp::plant::{Fault, Plant, PlantLanes};

/// Room to step up to [`Lanes::WIDTH`] steppers of one plant at once, by the steps of [`Stepper::step`] with inputs held.
///
/// What becomes of a stepper does not depend, to the bit, on those beside it, nor on their number or order. It differs
/// from what [`Stepper::step`] makes of it by the rounding of `S`.
#[derive(Debug)]
pub struct Together<S: Lanes> {
    x: Vec<S>,
    u: Vec<S>,
    work: Workspace<S>,
}

impl<S: PlantLanes> Together<S> {
    /// Room for plants of so many states and inputs.
    pub fn new(states: usize, inputs: usize) -> Self {
        Self { x: vec![S::ZERO; states], u: vec![S::ZERO; inputs], work: Workspace::new(states, RK4.b.len()) }
    }

    /// Takes `steps` steps of `dt` seconds with every one of `members`, which all are of the plant of the first. A member
    /// whose model becomes unusable keeps a state that is not finite, see [`Stepper::check`].
    ///
    /// # Panics
    /// When there are more members than lanes, or of other sizes.
    pub fn step<P: Plant, R: Deref<Target = P>>(
        &mut self,
        members: &mut [&mut Stepper<R>],
        dt: f64,
        steps: usize,
    ) {
        assert!(members.len() <= S::WIDTH, "{} members in {} lanes", members.len(), S::WIDTH);
        let Some(last) = members.len().checked_sub(1) else { return };
        // The lanes that are left over repeat the last member.
        for (i, x) in self.x.iter_mut().enumerate() {
            *x = S::of(|lane| members[lane.min(last)].state()[i]);
        }
        for (i, u) in self.u.iter_mut().enumerate() {
            *u = S::of(|lane| members[lane.min(last)].inputs()[i]);
        }
        let start = S::of(|lane| members[lane.min(last)].time());
        let mut run = LaneRun { plant: members[0].system(), u: &self.u };
        let todo = EqualSteps::new(start, S::from(dt), steps);
        if RK4.integrate(&mut run, todo, &mut self.x, &mut self.work).is_err() {
            self.x.fill(S::from(f64::NAN));
        }
        for (lane, member) in members.iter_mut().enumerate() {
            for (to, from) in member.state_mut().iter_mut().zip(&self.x) {
                *to = from.lane(lane);
            }
            member.count_steps(dt, steps);
        }
    }
}

/// The lanes as the integrator sees them.
struct LaneRun<'a, S, P> {
    plant: &'a P,
    u: &'a [S],
}

impl<S: PlantLanes, P: Plant> Dynamics<S, Fault> for LaneRun<'_, S, P> {
    fn slope(&mut self, t: S, x: &[S], dx: &mut [S]) -> Result<(), Fault> {
        S::rates_of(self.plant, t, x, self.u, dx)
    }

    fn after_step(&mut self, _: usize, _: S, x: &mut [S]) -> Result<ControlFlow<()>, Fault> {
        upright(self.plant, x);
        Ok(ControlFlow::Continue(()))
    }
}
