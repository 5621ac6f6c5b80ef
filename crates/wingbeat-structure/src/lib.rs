//! Geometrically exact beams: static shapes under large loads, modes about any shape or rotation, motion in time.
//!
//! The unknowns are the strains of the beam, as polynomials along each element, and its shape is the product of
//! exponentials of them, so that a rotation is never approximated and a rigid motion strains nothing. Strains that are
//! left out (by default extension and shear) bear no force, so that they bring no stiff modes.
//!
//! ```
//! use wingbeat_math::{Mat3, Vec3};
//! use wingbeat_structure::{Beam, Grid, Load, Place, CrossSection, Setting, SectionStation, StaticsStatus, Strain, hold};
//!
//! // A strip of steel, 1 m long, 30 mm wide and 1 mm thick, under its own tip load of 1 N.
//! let section = CrossSection::isotropic(210e9 * 30e-6, [80e9 * 1e-11, 210e9 * 2.5e-12, 210e9 * 2.25e-9]).with_mass(
//!     0.234,
//!     Vec3::ZERO,
//!     Mat3::diagonal(Vec3::new(1.8e-5, 2e-8, 1.8e-5)),
//! );
//! let stations = [SectionStation { arc_m: 0.0, section }, SectionStation { arc_m: 1.0, section }];
//! let beam = Beam::new(&stations, &[], &Grid { elements: 1, order: 6, strains: Strain::INEXTENSIBLE, arcs: vec![] })?;
//! let load = Load::dead(beam.tip(), Vec3::new(0.0, 0.0, -1.0));
//! let held = hold(&beam, &Setting { loads: vec![load], ..Setting::default() }, 4);
//! assert_eq!(held.status, StaticsStatus::Converged);
//! let tip = beam.places(&Place::IDENTITY, &held.q)[beam.tip()].p;
//! // P L^3 / (3 E I) = 0.635 m by linear theory; the exact beam gives less.
//! assert!(tip[2] < -0.45 && tip[2] > -0.635);
//! # Ok::<(), wingbeat_math::Error>(())
//! ```

mod basis;
mod beam;
mod group;
mod implicit;
mod modes;
mod motion;
mod section;
mod spectrum;
mod statics;

pub use beam::{Beam, Grid, Lump, MAX_COORDINATES};
pub use group::Place;
pub use implicit::{Implicit, Rule, Stage, StepFactors, Stepped, step};
pub use modes::{SmallMotionMatrices, eigenvalues, frequencies, linear, of_first_order};
pub use motion::{Energy, Load, Setting, Swung, turning};
pub use section::{CrossSection, SectionStation, Strain};
pub use spectrum::spectrum;
pub use statics::{HeldShape, StaticsStatus, hold};
