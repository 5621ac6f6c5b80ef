//! Runs in the files of other programs.

mod arrays;
mod cdr;
mod gltf;
mod mcap;
mod ros;
mod vtk;

use wingbeat::simulate::Record;
use wingbeat_io::csv_bytes;

use crate::motion::RunMotion;
use crate::run::ShownRun;

pub use arrays::{mat, npz};
pub use gltf::glb;
pub use mcap::{mcap, rig_mcap};
pub use vtk::{series, vtk};

/// Names and bytes of the files of an export.
type ExportFiles = Vec<(String, Vec<u8>)>;

/// In what a run is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text with columns.
    Csv,
    /// Arrays of NumPy.
    Npz,
    /// Variables of MATLAB.
    Mat,
    /// Polygons frame by frame.
    Vtk,
    /// The robot with its animation.
    Gltf,
    /// Messages of ROS 2.
    Mcap,
}

/// The formats by name.
const FORMATS: [(&str, Format); 6] = [
    ("csv", Format::Csv),
    ("npz", Format::Npz),
    ("mat", Format::Mat),
    ("vtk", Format::Vtk),
    ("gltf", Format::Gltf),
    ("mcap", Format::Mcap),
];

impl Format {
    /// The format of a name.
    ///
    /// # Errors
    /// A name that is none of them.
    pub fn named(name: &str) -> Result<Self, String> {
        let found = FORMATS.iter().find(|(known, _)| *known == name);
        let known = FORMATS.map(|(known, _)| known).join(", ");
        found.map(|(_, format)| *format).ok_or_else(|| format!("format = {name:?}: allowed are {known}"))
    }
}

/// The bytes of a run with its `record` in a format; a single file has no name of its own.
///
/// # Errors
/// A run in which nothing moves where the format shows motion; more bytes than are written.
pub fn of_run(format: Format, run: &ShownRun, record: &Record) -> Result<ExportFiles, String> {
    let single = |bytes: Vec<u8>| vec![(String::new(), bytes)];
    match format {
        Format::Csv => {
            csv_fits(record)?;
            csv_bytes(record).map(single)
        }
        Format::Npz => npz(record).map(single),
        Format::Mat => mat(record).map(single),
        Format::Gltf => glb(run.moves()?, &run.name).map(single),
        Format::Mcap => match record.values("Fz") {
            Some(_) => rig_mcap(record),
            None => mcap(run.moves()?, record, run.title()),
        }
        .map(single),
        Format::Vtk => {
            let motion = run.moves()?;
            vtk_fits(motion)?;
            let name = |i: usize| format!("frame_{i:05}.vtk");
            let list: Vec<(String, f64)> = motion.t.iter().enumerate().map(|(i, t)| (name(i), *t)).collect();
            let frames = (0..motion.frames()).map(|i| (name(i), vtk(motion, i).into_bytes()));
            Ok(frames.chain([(SERIES.to_owned(), series(&list).into_bytes())]).collect())
        }
    }
}

/// Name of the list of the files for VTK.
pub const SERIES: &str = "frames.vtk.series";

/// Refuses more frames for VTK than fit: about the letters of a rib, its panel and its strip.
///
/// # Errors
/// That.
pub fn vtk_fits(motion: &RunMotion) -> Result<(), String> {
    let ribs: usize = motion.surfaces.iter().map(|s| s.ribs.len() + 3 * s.raised.len()).sum();
    fits("the frames", motion.frames() as f64 * ribs as f64 * 400.0)
}

/// Refuses more text than fits: the most letters of a number.
///
/// # Errors
/// That.
pub fn csv_fits(record: &Record) -> Result<(), String> {
    record_fits("the .csv file", record, 25.0)
}

/// Most bytes of an export; sizes and offsets of the formats have 32 bits.
const LARGEST: f64 = (1_u64 << 31) as f64;

/// Refuses so many `bytes` (in bytes) where they are more than an export may have.
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
pub fn record_fits(what: &str, record: &Record, each: f64) -> Result<(), String> {
    let head = 256.0;
    fits(what, record.columns().len() as f64 * (record.rows() as f64 * each + head))
}
