//! The soft limit of clearances in the costs of predictive controllers.

use wingbeat_math::Error;
use wingbeat_math::Scalar;
use wingbeat_ocp::plant::{LocalChart, Plant};

/// Most clearances of a plant that a controller may watch.
const MAX_CLEARANCES: usize = 16;

/// Clearances that cost where they are short of a limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct SoftClearance {
    /// Number of the clearances; none where they cost nothing.
    pub count: usize,
    /// Clearance below which they cost, and the width over which that is rounded off, m.
    pub limit: f64,
    pub width: f64,
    /// Per m.
    pub weight: f64,
}

impl SoftClearance {
    /// That of all clearances of `plant`, with a `weight` (1/m) below `limit`, rounded off over `width` (both m); `key` names
    /// the weight.
    pub fn new<P: Plant>(plant: &P, key: &str, weight: f64, limit: f64, width: f64) -> Result<Self, Error> {
        let count = match (weight == 0.0, plant.clearances().len()) {
            (true, _) => 0,
            (false, count @ 1..=MAX_CLEARANCES) => count,
            (false, count) => {
                let allowed =
                    format!("0 for a robot with {count} clearances; with 1 to {MAX_CLEARANCES} any");
                return Err(Error::invalid(key, weight, allowed));
            }
        };
        Ok(Self { count, limit, width, weight })
    }

    /// Weight times the smooth positive part, dimensionless, of what each clearance is short of its limit. Where the model
    /// cannot be evaluated it has none: its rates refuse the state.
    ///
    /// Equation: guide.soft_clearance
    /// `r = weight s(c_min - c), s the smooth positive part over 1 mm`
    /// Source: choice.
    /// Test: `residuals_of_the_soft_limit_and_their_derivatives_are_exact`.
    pub fn shortfalls<P: Plant, S: Scalar>(&self, chart: &LocalChart<P>, t: f64, x: &[S], r: &mut [S]) {
        if self.count == 0 {
            return;
        }
        let mut clearances = [S::ZERO; MAX_CLEARANCES];
        let clearances = &mut clearances[..self.count];
        if chart.clear(S::from(t), x, clearances).is_err() {
            return r.fill(S::ZERO);
        }
        for (r, c) in r.iter_mut().zip(clearances) {
            *r = (-*c + self.limit).smooth_positive(self.width) * self.weight;
        }
    }
}
