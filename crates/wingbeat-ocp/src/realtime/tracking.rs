//! What a plan is asked to follow.

use std::ops::Range;
use wingbeat_math::Scalar;

/// A least-squares cost on the nodes of the horizon, and what limits it beyond
/// the plant's own channels:
///
/// J = sum_k |r(k, t_k, x_k, u_k)|^2 + sum_k sum_j c_j (u_{j,k+1} - u_{j,k})^2.
pub trait Tracking {
    /// Number of residuals at `node`, 0 to the number of intervals.
    fn residuals(&self, node: usize) -> usize;

    /// Writes the residuals of `node` at the time `t`, s; `r` has the length
    /// given by [`residuals`](Self::residuals).
    fn residual<S: Scalar>(&self, node: usize, t: f64, x: &[S], u: &[S], r: &mut [S]);

    /// States of which residuals know, of so many, the same at all times; all by default. Derivatives by others are zero and not asked for.
    fn known_states(&self, states: usize) -> Range<usize> {
        0..states
    }

    /// Weight c_j on the squared change of input `j` over each interval, 1 over the square of its unit: the cost is
    /// dimensionless.
    fn change_weight(&self, _input: usize) -> f64 {
        0.0
    }

    /// Largest rate r_j of input `j`, in its unit per second: |u_{j,k+1} - u_{j,k}| <= r_j h on every interval. Infinite: no
    /// limit.
    fn rate_limit(&self, _input: usize) -> f64 {
        f64::INFINITY
    }

    /// Linear limits on states and inputs, held at every node after the first.
    fn limits(&self) -> &[LinearLimit] {
        &[]
    }
}

/// One component of the stage's vector [x, u].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// State of this index.
    State(usize),
    /// Input of this index.
    Input(usize),
}

/// low <= sum_i c_i component_i <= high.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearLimit {
    /// Name for messages.
    pub name: String,
    /// Components and their coefficients.
    pub terms: Vec<(Component, f64)>,
    /// Lower limit, in the unit of the sum.
    pub low: f64,
    /// Upper limit, in the unit of the sum.
    pub high: f64,
}
