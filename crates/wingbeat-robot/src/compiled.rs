//! The robot in the numbers that other crates ask for, compiled once and here: a crate that calls generic code compiles a copy
//! of its own. [`Plant::rates_in_numbers`](wingbeat_ocp::plant::Plant::rates_in_numbers) is the same for the free robot.

use super::{BodyMotion, CarriedLoads, Robot, Varying};
use wingbeat_math::Jet;
use wingbeat_ocp::plant::Fault;

impl Robot {
    /// [`carried`](Self::carried) in plain numbers.
    ///
    /// # Errors
    /// Those of `carried`.
    pub fn carried_in_numbers(
        &self,
        clock: &Jet<f64>,
        body: &BodyMotion<f64>,
        x: &[f64],
        u: &[f64],
        dx: &mut [f64],
    ) -> Result<CarriedLoads<f64>, Fault> {
        self.carried(clock, body, x, u, dx)
    }
}

impl Robot<Varying> {
    /// [`state_rates`](Self::state_rates) with the derivatives by numbers varied together.
    ///
    /// # Errors
    /// Those of `state_rates`.
    pub fn rates_in_varying(
        &self,
        t: f64,
        x: &[Varying],
        u: &[Varying],
        dx: &mut [Varying],
    ) -> Result<(), Fault> {
        self.state_rates(Varying::from(t), x, u, dx)
    }

    /// [`carried`](Self::carried) with the derivatives by numbers varied together.
    ///
    /// # Errors
    /// Those of `carried`.
    pub fn carried_in_varying(
        &self,
        clock: &Jet<Varying>,
        body: &BodyMotion<Varying>,
        x: &[Varying],
        u: &[Varying],
        dx: &mut [Varying],
    ) -> Result<CarriedLoads<Varying>, Fault> {
        self.carried(clock, body, x, u, dx)
    }
}
