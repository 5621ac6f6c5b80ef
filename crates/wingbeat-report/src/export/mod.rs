//! Runs in the files of other programs.

mod arrays;
mod cdr;
mod gltf;
mod mcap;
mod ros;
mod vtk;

pub use arrays::{mat, npz};
pub use gltf::glb;
pub use mcap::mcap;
pub use vtk::{series, vtk};
