//! What calibrations find, what they say of it, and what they refuse.

mod calibrate;
mod few_passes;
mod linear;
mod residual;
mod tethered;
mod tilts;
