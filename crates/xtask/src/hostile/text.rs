//! What lies in a file or stands in a word: text, or pieces of it.

use std::fs;

use serde::Deserialize;

use super::place::placed;
use super::readers;
use super::series::MeasuredSeries;
use crate::tools;

/// Text, or pieces one after another.
#[derive(Clone, Deserialize)]
#[serde(untagged)]
pub enum Text {
    /// As it is; `{root}` stands for the repository.
    Plain(String),
    /// One after another.
    Pieces(Vec<TextPiece>),
}

/// A piece of a text.
#[derive(Clone, Deserialize)]
#[serde(untagged)]
pub enum TextPiece {
    /// As it is.
    Plain(String),
    /// The same many times.
    Repeated {
        /// What.
        repeat: String,
        /// How often.
        times: usize,
    },
    /// A table of samples at 1 kHz.
    Samples {
        /// Rows.
        samples: usize,
        /// Bytes that its end lacks.
        #[serde(default)]
        cut: usize,
        /// Its header, where it is another one.
        header: Option<String>,
    },
    /// Loads or a motion over time.
    Series(MeasuredSeries),
    /// A file of the repository.
    File {
        /// Its path from the root.
        file: String,
        /// A text in it and what stands in its place.
        replace: Option<[String; 2]>,
    },
}

impl Text {
    /// Its bytes.
    pub fn bytes(&self) -> Result<Vec<u8>, String> {
        match self {
            Self::Plain(text) => Ok(placed(text).into_bytes()),
            Self::Pieces(pieces) => {
                pieces.iter().map(TextPiece::bytes).collect::<Result<Vec<_>, _>>().map(|all| all.concat())
            }
        }
    }
}

impl TextPiece {
    fn bytes(&self) -> Result<Vec<u8>, String> {
        match self {
            Self::Plain(text) => Ok(placed(text).into_bytes()),
            Self::Repeated { repeat, times } => Ok(repeat.repeat(*times).into_bytes()),
            Self::Samples { samples, cut, header } => {
                let mut bytes = readers::table(*samples, 1000.0, ',');
                bytes.truncate(bytes.len() - cut);
                if let Some(header) = header {
                    bytes.splice(..readers::HEADER.len(), header.bytes());
                }
                Ok(bytes)
            }
            Self::Series(series) => series.bytes(),
            Self::File { file, replace } => {
                let text = fs::read_to_string(tools::root().join(file));
                let text = text.map_err(|error| format!("{file}: {error}"))?;
                Ok(match replace {
                    Some([from, to]) => placed(&text).replace(from, to),
                    None => placed(&text),
                }
                .into_bytes())
            }
        }
    }
}
