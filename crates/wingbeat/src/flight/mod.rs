//! Flying a plant: the record of a run.

mod closed_loop;
mod record;
mod sensors;

pub use closed_loop::{AtRest, Controller, Ending, Flight, Sample, Schedule, Update, fly};
pub use record::{Column, Record};
pub use sensors::{Sensed, SensorSpec};
