//! Simulation: the stepper that advances every system, the flight of a plant
//! under a controller, the record of a run.

mod fly;
mod record;
mod sensors;
mod stepper;

pub use fly::{AtRest, Controller, Flight, Sample, Schedule, Update, fly};
pub use record::{Column, Record};
pub use sensors::{Sensed, SensorSpec};
pub use stepper::{Driver, Ending, Held, Moment, Observed, Saved, Sizes, Stepper, System};
