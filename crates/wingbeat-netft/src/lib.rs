//! Recording from an ATI Net F/T box, and an emulator of the box.

mod clock;
mod emulator;
mod http;
mod log;
mod page;
mod receive;
mod recorder;

pub use clock::Timeline;
pub use emulator::{Emulator, Faults, LARGEST_OFFSET, LoadPattern, RecordNumbering, Sent, Signal};
pub use http::{get_scale, parse_answer, read_config, read_config_while};
pub use log::{ROW_BYTES, Row, logs, read_log};
pub use page::Config;
pub use recorder::{RecordingEnd, RecordingOptions, Report, record};

use std::path::{Path, PathBuf};

/// Why nothing could be recorded or emulated.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The network refused.
    #[error("{what}: {source}")]
    Network {
        /// What was tried.
        what: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// The box answered with something else.
    #[error("{url}: {what}")]
    Answer {
        /// What was asked for.
        url: String,
        /// What is wrong.
        what: String,
    },
    /// A file could not be written or read.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A value that is not allowed.
    #[error(transparent)]
    Refused(#[from] wingbeat::Error),
}

impl Error {
    fn network(what: impl Into<String>, source: impl Into<std::io::Error>) -> Self {
        Self::Network { what: what.into(), source: source.into() }
    }
    fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File { path: path.into(), source }
    }
}
