//! The vortex lattice: small motions against the linear lifting surface and exact solutions, large ones against a peer.

mod convergence;
pub(crate) mod flapping;
mod flight;
mod ground;
mod shedding;
mod small;
mod span;
mod wake;
pub(crate) mod wings;

pub(crate) use ground::{elliptic_over, rectangle_over, rectangle_pair};
pub(crate) use span::steady_half;

use crate::Case;

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "lattice.slope", quick: true, run: small::slope },
    Case { id: "lattice.span_efficiency", quick: true, run: span::efficiency },
    Case { id: "lattice.shedding.suction", quick: true, run: shedding::edge_suction },
    Case { id: "lattice.shedding.kept", quick: true, run: shedding::kept },
    Case { id: "lattice.shedding.momentum", quick: false, run: shedding::momentum },
    Case { id: "lattice.shedding.measured", quick: false, run: shedding::measured },
    Case { id: "lattice.step", quick: false, run: small::step },
    Case { id: "lattice.plunge", quick: false, run: small::plunge },
    Case { id: "lattice.pitch_thrust", quick: false, run: small::pitch_thrust },
    Case { id: "lattice.wagner", quick: true, run: small::wagner },
    Case { id: "lattice.theodorsen", quick: false, run: small::theodorsen },
    Case { id: "lattice.kelvin", quick: true, run: flapping::kelvin },
    Case { id: "lattice.force_methods_agree", quick: false, run: flapping::force_methods_agree },
    Case { id: "lattice.f1", quick: false, run: flapping::f1 },
    Case { id: "lattice.f2", quick: false, run: flapping::f2 },
    Case { id: "lattice.free_flight", quick: false, run: flight::free_flight },
    Case { id: "lattice.coupled", quick: false, run: flight::coupled },
    Case { id: "wake.plane_circulation", quick: false, run: wake::plane_circulation },
    Case { id: "wake.symmetry", quick: false, run: wake::symmetry },
    Case { id: "lattice.convergence", quick: false, run: convergence::convergence },
];
