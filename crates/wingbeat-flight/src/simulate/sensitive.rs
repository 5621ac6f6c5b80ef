//! States with their derivatives side by side, so that whatever steps plain numbers steps both.

use super::system::{Moment, Observed, Sizes, System};
use wingbeat_math::Dual;
use wingbeat_ocp::plant::Fault;

/// What has rates of states that carry N derivatives.
pub trait Varied<const N: usize> {
    /// What it shows.
    type Seen;

    /// Numbers of states, each with its derivatives one, and of inputs.
    fn sizes(&self) -> Sizes;

    /// Writes the rates, in the units of the states per s, of the states `x` at `t` under the inputs `u`, and tells what is to
    /// be seen there.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    fn evaluated(&self, t: f64, x: &[Dual<N>], u: &[f64], rates: &mut [Dual<N>])
    -> Result<Self::Seen, Fault>;
}

/// A system of plain numbers, for each state its value and then the derivatives.
pub struct Sensitive<T, const N: usize>(pub T);

/// States with their derivatives as plain numbers, in the units of the states and of these over what varies.
pub fn packed<const N: usize>(x: Vec<Dual<N>>) -> Vec<f64> {
    x.into_iter().flat_map(|x| std::iter::once(x.re).chain(x.eps)).collect()
}

impl<T: Varied<N>, const N: usize> Sensitive<T, N> {
    fn evaluated(&self, at: Moment, dx: &mut [f64]) -> Result<T::Seen, Fault> {
        let one = |of: &[f64]| Dual { re: of[0], eps: std::array::from_fn(|k| of[1 + k]) };
        let x: Vec<Dual<N>> = at.x.chunks_exact(1 + N).map(one).collect();
        let mut rates = vec![Dual::constant(0.0); x.len()];
        let seen = self.0.evaluated(at.t, &x, at.u, &mut rates)?;
        for (out, rate) in dx.chunks_exact_mut(1 + N).zip(&rates) {
            out[0] = rate.re;
            out[1..].copy_from_slice(&rate.eps);
        }
        Ok(seen)
    }
}

impl<T: Varied<N>, const N: usize> System for Sensitive<T, N> {
    type Memory = ();

    fn sizes(&self) -> Sizes {
        let Sizes { states, inputs } = self.0.sizes();
        Sizes { states: (1 + N) * states, inputs }
    }
    fn slope(&self, at: Moment, dx: &mut [f64]) -> Result<(), Fault> {
        self.evaluated(at, dx).map(drop)
    }
}

impl<T: Varied<N>, const N: usize> Observed for Sensitive<T, N> {
    type Observation = T::Seen;

    fn observed(&self, at: Moment) -> Result<T::Seen, Fault> {
        self.evaluated(at, &mut vec![0.0; at.x.len()])
    }
}
