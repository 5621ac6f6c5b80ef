//! The robot in the numbers that other crates ask for, compiled once and here: a crate that calls generic code compiles a copy
//! of its own. [`Plant::rates_in_numbers`](wingbeat_ocp::plant::Plant::rates_in_numbers) is the same for the free robot.

use super::{BodyMotion, CarriedLoads, Robot, Varying};
use wingbeat_math::{Double4, Jet, Scalar};
use wingbeat_ocp::plant::{Early, Fault};

/// Scalars in which this crate has compiled a robot whose numbers are of the same scalar.
pub trait Compiled: Scalar {
    /// [`Robot::carried`] in this scalar.
    ///
    /// # Errors
    /// Those of `carried`.
    fn carried(
        robot: &Robot<Self>,
        clock: &Jet<Self>,
        body: &BodyMotion<Self>,
        x: &[Self],
        u: &[Self],
        dx: &mut [Self],
    ) -> Result<CarriedLoads<Self>, Fault>;
}

impl Compiled for f64 {
    fn carried(
        robot: &Robot,
        clock: &Jet,
        body: &BodyMotion<f64>,
        x: &[f64],
        u: &[f64],
        dx: &mut [f64],
    ) -> Result<CarriedLoads<f64>, Fault> {
        robot.carried_in_numbers(clock, body, x, u, dx)
    }
}

impl Compiled for Varying {
    fn carried(
        robot: &Robot<Self>,
        clock: &Jet<Self>,
        body: &BodyMotion<Self>,
        x: &[Self],
        u: &[Self],
        dx: &mut [Self],
    ) -> Result<CarriedLoads<Self>, Fault> {
        robot.carried_in_varying(clock, body, x, u, dx)
    }
}

/// Scalars in which this crate has compiled the rates of a robot of plain numbers over a cycle of its gait.
pub trait CycleScalar: Scalar {
    /// [`Robot::rates_by_clock`] in this scalar.
    ///
    /// # Errors
    /// Those of `rates_by_clock`.
    fn rates_by_clock(
        robot: &Robot,
        t: Self,
        clock: &Jet<Self>,
        x: &[Self],
        u: &[Self],
        dx: &mut [Self],
    ) -> Result<(), Fault>;
}

impl CycleScalar for f64 {
    fn rates_by_clock(
        robot: &Robot,
        t: f64,
        clock: &Jet,
        x: &[f64],
        u: &[f64],
        dx: &mut [f64],
    ) -> Result<(), Fault> {
        robot.rates_by_clock(t, clock, x, u, dx)
    }
}

impl CycleScalar for Early {
    fn rates_by_clock(
        robot: &Robot,
        t: Self,
        clock: &Jet<Self>,
        x: &[Self],
        u: &[Self],
        dx: &mut [Self],
    ) -> Result<(), Fault> {
        robot.rates_by_clock(t, clock, x, u, dx)
    }
}

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

impl Robot<Double4> {
    /// [`state_rates`](Self::state_rates) of robots that differ, each in a lane.
    ///
    /// # Errors
    /// Those of `state_rates`.
    pub fn rates_side_by_side(
        &self,
        t: Double4,
        x: &[Double4],
        u: &[Double4],
        dx: &mut [Double4],
    ) -> Result<(), Fault> {
        self.state_rates(t, x, u, dx)
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
