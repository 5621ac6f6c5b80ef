//! Simulation: the stepper that advances every system, the flight of a plant
//! under a controller behind sensors, the record of a run.

mod accuracy;
mod cost;
mod coupled;
mod estimator;
mod fly;
mod inertance;
mod record;
mod secant;
mod sensitive;
mod sensor;
mod side_by_side;
mod stepper;
mod strips;
mod system;
mod together;

pub use accuracy::{Accuracy, Reach, Taken, mean_error};
pub use cost::{Cost, pin_columns, whole_strokes};
pub use coupled::{AirCoupling, Fineness, Flow, fly_in};
pub use coupled::{Bears, Beyond, Steers, step_in};
pub use estimator::{Estimator, NoEstimate, TrueState};
pub use fly::{AtRest, Controller, Event, Flight, Sample, Schedule, Update, fly, fly_until, fly_within};
pub use inertance::{fastest_vibration, follow};
pub use record::{Column, Record, is_at};
pub use sensitive::{Sensitive, Varied, packed};
pub use sensor::*;
pub use side_by_side::{Seat, fly_side_by_side};
pub use stepper::{Saved, Stepper};
pub use strips::AXES;
pub(crate) use strips::detail_columns;
pub use strips::{StripMotion, StripRecorder};
pub use system::{Driver, Ending, Held, Moment, Observed, Sizes, System};
pub use together::Together;
