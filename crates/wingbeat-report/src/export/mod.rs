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

/// Most bytes of an export; sizes and offsets of the formats have 32 bits.
const LARGEST: f64 = (1_u64 << 31) as f64;

/// Refuses more bytes than an export may have.
///
/// # Errors
/// That.
pub fn fits(what: &str, bytes: f64) -> Result<(), String> {
    if bytes <= LARGEST {
        return Ok(());
    }
    Err(format!("{what} would have about {bytes:.1e} bytes; allowed are {LARGEST:.1e}"))
}

/// Refuses a record with more numbers than fit, `each` bytes a number.
///
/// # Errors
/// That.
pub fn record_fits(what: &str, record: &wingbeat::simulate::Record, each: f64) -> Result<(), String> {
    let head = 256.0;
    fits(what, record.columns().len() as f64 * (record.rows() as f64 * each + head))
}
