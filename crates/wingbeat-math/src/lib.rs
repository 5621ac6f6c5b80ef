//! Scalars, frames and rotations, interpolation, Runge-Kutta tables, small solves.

mod angle;
mod dual;
mod error;
mod evolution;
mod fourier;
mod harmonics;
pub mod interpolation;
mod jet;
mod lanes;
pub mod linear;
pub mod multifrontal;
pub mod names;
pub mod order;
mod over;
pub mod parallel;
mod parameters;
pub mod processor;
mod random;
pub mod range;
mod room;
pub mod rows;
mod runge_kutta;
mod scalar;
mod segment;
mod space;
mod spline;
mod tape;
mod wrench;

pub use angle::{pitch_of_nose_up, unwrapped, whole_turns};
pub use dual::Dual;
pub use error::{Error, require};
pub use evolution::Evolution;
pub use fourier::power_spectrum;
pub use harmonics::Harmonics;
pub use jet::Jet;
pub use lanes::{Double4, Lanes, Single8};
pub use over::{Meets, Over, lift};
pub use parameters::{Declared, DeclaredQuantity, Labels, NamedNumber, Parameters, Walk, axial, polar};
pub use random::Random;
pub use room::{append, append_copies, kept};
pub use runge_kutta::{Dynamics, EqualSteps, RK4, Tableau, Workspace};
pub use scalar::Scalar;
pub use segment::{segment_distance, triangle_distance};
pub use space::{Mat3, Quat, Vec3};
pub use spline::CubicSpline;
pub use tape::{FourDerivatives, Tape, TapeFour};
pub use wrench::{CHANNELS, Wrench};

/// Standard gravity, m/s2 (CGPM 1901).
pub const GRAVITY: f64 = 9.80665;
/// Density of air at sea level, kg/m3 (standard atmosphere, ISO 2533:1975).
pub const SEA_LEVEL_DENSITY: f64 = 1.225;
/// Radians in a degree, rad/deg.
pub const RADIANS: f64 = std::f64::consts::PI / 180.0;
/// Degrees in a radian, deg/rad.
pub const DEGREES: f64 = 180.0 / std::f64::consts::PI;
