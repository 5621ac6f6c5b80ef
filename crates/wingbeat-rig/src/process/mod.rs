//! From the cell's raw channels to clean, phase-averaged wrenches of the robot:
//! tare and drift, weight and inertia by model, body frame, zero-phase filter,
//! phase average, envelope.

mod correct;
mod cycle;
mod filter;
mod input;
mod motion;
mod tilt;

pub use correct::{Corrected, Corrector, Samples, Steps, tare_line};
pub(crate) use cycle::phase_average;
pub use cycle::{Comparison, CycleAverage, PhaseSource, compare, phase_of};
pub use filter::Butterworth;
pub use input::{InputSpec, UnitSpec};
pub(crate) use motion::recorded_motion;
pub use tilt::{Tilt, Weighing, weigh};
