//! A wing in prescribed motion in a wind, without a robot: hinges and body
//! follow given functions of time; loads come out.

mod comparison;
mod coordinate;
mod cycle;
mod ground;
mod numbers;
mod outline;
mod power;
mod recorder;
mod run;
mod sensitivity;
mod spar;
mod wing;

pub use comparison::cycle_of;
pub use comparison::{CycleFit, PHASES, fit, smooth};
pub use coordinate::Coordinate;
pub use cycle::{CycleMean, Periodicity};
pub use ground::Plane;
pub use numbers::WingNumbers;
pub use outline::Shape;
pub use recorder::TetherRun;
pub use run::{Clock, CoefficientScales, Motion, Tether};
pub use sensitivity::{BODY_LOADS, CycleWrenches};
pub use spar::{Bent, STRAIN, Spar, Steady};
pub use wing::{Frame, Hinge, HingeKind, Side, TetheredBody, Wing};
