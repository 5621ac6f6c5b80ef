//! Simulation: the stepper that advances every system, the flight of a plant
//! under a controller behind sensors, the record of a run.

mod estimator;
mod fly;
mod record;
mod sensors;
mod stepper;
mod strips;
mod system;
mod together;

pub use estimator::{Estimator, TrueState, Unmeasured};
pub use fly::{AtRest, Controller, Flight, Sample, Schedule, Update, fly};
pub use record::{Column, Record};
pub use sensors::{Measurement, SensorSpec, Sensors};
pub use stepper::{Saved, Stepper};
pub use strips::{AXES, StripMotion, StripRecorder};
pub use system::{Driver, Ending, Held, Moment, Observed, Sizes, System};
pub use together::Together;
