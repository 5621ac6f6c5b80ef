//! From the cell's raw channels to clean, phase-averaged wrenches of the robot:
//! tare and drift, weight and inertia by model, body frame, zero-phase filter,
//! phase average, envelope.

mod clock;
mod correct;
mod filter;
mod input;
mod motion;
mod tilt;

pub use clock::{CrankRipple, fitted_phase};
pub use correct::{Corrected, Corrector, RestDrift, Samples, Steps, tare_line};
pub use filter::Butterworth;
pub use input::{InputSpec, UnitSpec};
pub use motion::recorded_motion;
pub use tilt::{Tilt, Weighing, weigh};
pub use wingbeat_flight::cycle::{Comparison, CycleAverage, PhaseSource, compare, phase_average, phase_of};
