//! Flying a plant: the record of a run.

mod record;

pub use record::{Column, Record};
