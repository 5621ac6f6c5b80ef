//! Why a figure could not be drawn.

use std::path::PathBuf;

/// Why a figure could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The record lacks a column.
    #[error("the record has no column {0}")]
    Column(String),
    /// The record has too few rows to draw.
    #[error("the record has {rows} rows; a figure needs {needed} or more")]
    Rows {
        /// Rows there are.
        rows: usize,
        /// Rows needed.
        needed: usize,
    },
    /// The record has too many rows to draw.
    #[error("the record has {rows} rows; the figure takes at most {most}")]
    Many {
        /// Rows there are.
        rows: usize,
        /// Most that are drawn.
        most: usize,
    },
    /// The picture could not be made.
    #[error("{0}")]
    Picture(String),
    /// A file could not be written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}
