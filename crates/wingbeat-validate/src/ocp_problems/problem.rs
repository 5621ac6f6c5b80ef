//! The optimal-control problems of the comparisons as one type: the solver is compiled once for all of them.

use super::classics::{AlpRider, CartProblem, CatalystMixing, Ceiling, HangingChain, LinearTangent, Zermelo};
use super::trajectories::{
    Brachistochrone, BrysonDenham, CartPole, DoubleIntegrator, Hypersensitive, LqrScalar, MoonLander,
    Rayleigh, VanDerPol,
};
use wingbeat::math::Scalar;
use wingbeat::ocp::{Ends, Instant, OptimalControl, Setup};
use wingbeat::plant::Fault;

macro_rules! problems {
    ($($name:ident)*) => {
        pub(super) enum ClassicProblem {
            $($name($name)),*
        }

        $(impl From<$name> for ClassicProblem {
            fn from(own: $name) -> Self {
                Self::$name(own)
            }
        })*

        impl OptimalControl for ClassicProblem {
            fn setup(&self) -> Setup {
                match self { $(Self::$name(own) => own.setup()),* }
            }
            fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
                match self { $(Self::$name(own) => own.rates(at, dx)),* }
            }
            fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
                match self { $(Self::$name(own) => own.running_cost(at)),* }
            }
            fn constrain_path<S: Scalar>(&self, at: Instant<S>, values: &mut [S]) {
                match self { $(Self::$name(own) => own.constrain_path(at, values)),* }
            }
            fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
                match self { $(Self::$name(own) => own.end_cost(ends)),* }
            }
            fn constrain_ends<S: Scalar>(&self, ends: Ends<S>, values: &mut [S]) {
                match self { $(Self::$name(own) => own.constrain_ends(ends, values)),* }
            }
        }
    };
}

problems! {
    AlpRider Brachistochrone BrysonDenham CartProblem CartPole CatalystMixing Ceiling DoubleIntegrator HangingChain
    Hypersensitive LinearTangent LqrScalar MoonLander Rayleigh VanDerPol Zermelo
}
