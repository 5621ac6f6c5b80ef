//! The lattice by itself, along flights and below runs on the rig.

mod bent;
mod coupled;
mod inflow;
mod physics;
mod rig;
mod shedding;
mod soft;
