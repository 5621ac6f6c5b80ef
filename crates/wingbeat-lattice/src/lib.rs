//! An unsteady vortex-ring lattice of moving, folding wings with prescribed and free wakes: the independent truth of attached flow.
//!
//! Panels carry rings of vortices whose front stands at 1/4 of a panel; the flow is tangent at 3/4. The circulation of the rings
//! at the trailing edge goes into the wake every step (Kutta). Vortices of the wake have cores; bound ones have none.
//!
//! ```
//! use wingbeat::scenario::{Document, TetherCase};
//! use wingbeat_lattice::{FlappingWing, Lattice, Panels, Scene, LatticeSettings, Spacing};
//!
//! let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../cases/flap_f1.toml");
//! let no_tables = &|_: &std::path::Path| Err("no tables here".to_owned());
//! let case = TetherCase::new(Document::file(path.as_ref())?, no_tables)?;
//! let panels = Panels { chordwise: 4, spanwise: 12, spacing: Spacing::Lan };
//! let scene = Scene::new(&FlappingWing::try_from(&case.tether)?, panels, true)?;
//! let mut lattice = Lattice::new(scene, LatticeSettings::new(0.01, 0.002))?;
//! let lift: Vec<f64> = (0..10).map(|_| Ok(lattice.step()?.joukowski.force[2])).collect::<Result<_, wingbeat_lattice::Error>>()?;
//! assert!(lattice.circulation_error() < 1e-12 && lift.iter().all(|lift| lift.is_finite()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod coupled;
pub mod course;
mod error;
mod flown;
mod impulse;
mod influence;
mod kernel;
mod lattice;
mod layout;
mod loads;
mod mesh;
mod motion;
mod multipole;
mod picture;
mod settings;
mod shedding;
mod skin;
mod spread;
mod tree;
mod trefftz;
mod wake;
#[cfg(target_arch = "x86_64")]
mod wider;

pub use coupled::{CoupledLattice, doors};
pub use error::{Error, LayoutError, RecordError};
pub use flown::FlightStretch;
pub use kernel::{VortexGrid, cored_segment, segment};
pub use lattice::Lattice;
pub use layout::{PanelLayout, Spacing};
pub use loads::{LatticeLoads, PanelLoads};
pub use mesh::{Control, Mesh, VortexElement};
pub use motion::{FlappingWing, LatticeSurface, MovingSections, Panels, Scene};
pub use picture::{Quad, VortexPicture};
pub use settings::{Conventions, Core, LatticeSettings, WakeMotion};
pub use skin::EdgeBends;
pub use wake::Wake;
