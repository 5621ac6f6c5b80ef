//! Comparisons of wingbeat with published or independent numbers.
//!
//! Each part of the library has a module here with its [`Case`]s; a case runs the model and
//! returns one [`ComparisonRow`] per compared number. Reference tables live in `validation/<source>/`.

mod case;
mod curve;
mod error;
pub mod page;
mod reference;
mod report;
pub mod shipped;

pub mod aero_full;
pub mod aero_ground;
pub mod aero_paper;
pub mod aero_surfaces;
pub mod aero_symmetry;
pub mod aero_turn;
pub mod body;
pub mod calibrate;
pub mod figures;
pub mod flapbody;
pub mod flight;
pub mod fsi;
pub mod lattice;
pub mod math;
pub mod ocp;
pub mod ocp_problems;
pub mod orbit;
pub mod paper;
pub mod paper_flight;
pub mod paper_nlp;
pub mod paper_printed;
pub mod rig;

pub use case::{
    Case, CaseWatch, ComparisonRow, LongCase, Selection, below, run, run_long, select, select_long,
};
pub use error::Error;
pub use page::{PagePiece, page, pieces};
pub use reference::ReferenceTable;
pub use report::{ReportLine, table, to_json};

/// Every case, part by part.
pub fn cases() -> Vec<&'static Case> {
    [
        math::CASES,
        aero_paper::CASES,
        paper::CASES,
        paper_printed::CASES,
        paper_flight::CASES,
        paper_nlp::CASES,
        aero_full::CASES,
        aero_surfaces::CASES,
        aero_ground::CASES,
        aero_symmetry::CASES,
        aero_turn::CASES,
        lattice::CASES,
        body::CASES,
        fsi::CASES,
        fsi::beam::CASES,
        fsi::goland::CASES,
        fsi::pazy::CASES,
        fsi::membrane::CASES,
        fsi::flapping::CASES,
        fsi::flight::CASES,
        orbit::CASES,
        flight::CASES,
        ocp::CASES,
        ocp_problems::hock_schittkowski::CASES,
        ocp_problems::trajectories::CASES,
        ocp_problems::classics::CASES,
        ocp_problems::flapbody::CASES,
        rig::CASES,
        calibrate::CASES,
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The cases that take minutes each and run beside the others: fits.
pub fn slow_cases() -> Vec<&'static Case> {
    calibrate::LONG.iter().collect()
}

/// The cases that take minutes each on all cores: Monte Carlo, and the lattice along orbits.
pub fn long_cases() -> Vec<&'static LongCase> {
    orbit::LONG.iter().chain(flight::LONG).collect()
}
