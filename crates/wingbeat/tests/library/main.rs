//! What the library promises, module by module: one program, so that the generic code of the models is built once for all.

mod chord_lines;
mod clearance;
mod cost;
mod document;
mod doors;
mod drive;
mod estimator;
mod every_number;
mod flight;
mod flyers;
mod followed_impulse;
mod full_turn;
mod gait_search;
mod horizon;
mod hover;
mod inherit;
mod linkage;
mod mechanism;
mod multibody;
mod numbers;
mod orbit;
mod outline;
mod power;
#[cfg(target_arch = "x86_64")]
mod processor;
mod refusals;
mod residual;
mod rig;
mod robot;
mod side_by_side;
mod strip_model;
mod surfaces;
mod tether;
mod tether_numbers;
mod tracking;
mod verdict;
