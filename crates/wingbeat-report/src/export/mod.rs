//! Runs in the files of other programs.

mod arrays;
mod gltf;
mod vtk;

pub use arrays::{mat, npz};
pub use gltf::glb;
pub use vtk::{series, vtk};
