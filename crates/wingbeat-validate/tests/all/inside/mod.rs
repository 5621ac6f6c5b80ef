//! What the comparisons are made of.

mod aero_full_lattice;
mod aero_full_linear;
mod aero_surfaces;
mod body_urdf;
mod case;
mod flight_draws;
mod flight_laws;
mod fsi_theodorsen;
mod orbit_replay;
mod page;
mod reference;
mod report;
mod shipped;
