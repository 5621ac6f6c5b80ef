//! TOML to checked objects: the only place where strings become things.

mod document;

pub use document::{ConfigError, Document, Place, Problem};
