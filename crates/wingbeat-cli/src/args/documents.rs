//! What commands take that write documents.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use wingbeat::scenario::DocumentKind;

/// Write a commented document that runs as it is, to begin from
///
/// The documents that it names are written beside it as robot.toml, scenario.toml, rig.toml, arm.toml or run.toml,
/// unless they are there already. Every key is in docs/reference.md.
#[derive(Debug, Args)]
pub struct New {
    /// What to write
    #[arg(value_parser = new_kind())]
    pub kind: NewKind,
    /// Where; without it KIND.toml in the present folder
    #[arg(value_name = "PATH")]
    pub path: Option<PathBuf>,
    /// Of a robot: the least that flies, in place of the robot of the paper
    #[arg(long, conflicts_with_all = ["robot", "case"])]
    pub minimal: bool,
    /// Of a scenario or a trim: for this robot, without controller
    #[arg(long, value_name = "ROBOT.toml", conflicts_with = "case")]
    pub robot: Option<PathBuf>,
    /// Of a calibration: from measurements of this case
    #[arg(long, value_name = "CASE.toml")]
    pub case: Option<PathBuf>,
    /// Replace the file at PATH; what is written beside it is never replaced
    #[arg(long)]
    pub force: bool,
}

/// Rewrite former names of keys in documents
///
/// `pitch_deg` becomes `nose_up_deg` with the sign turned, in draws and in overrides (`key=value`) too, and former names of
/// parameters become those of today. Comments, order and everything else are kept; what changes is printed.
#[derive(Debug, Args)]
pub struct Migrate {
    /// Documents: TOML files of any kind
    #[arg(value_name = "FILE.toml", required = true)]
    pub files: Vec<PathBuf>,
    /// Print what would change and write nothing
    #[arg(long)]
    pub dry_run: bool,
}

/// Print the JSON Schema of a kind of document
///
/// An editor that knows TOML completes, explains and checks a document whose first line is `#:schema FILE`. The same
/// schemas are in docs/schema.
#[derive(Debug, Args)]
pub struct Schema {
    /// The kind
    #[arg(value_parser = kind())]
    pub kind: DocumentKind,
}

/// What `new` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NewKind {
    /// A document of a kind.
    Document(DocumentKind),
    /// A scenario with `[trim]`.
    Trim,
    /// A sweep with `[search]`.
    Search,
}

fn new_kind() -> impl TypedValueParser<Value = NewKind> {
    let names = DocumentKind::ALL.map(DocumentKind::name).into_iter().chain(["trim", "search"]);
    PossibleValuesParser::new(names).map(|name| match (DocumentKind::named(&name), name.as_str()) {
        (Some(kind), _) => NewKind::Document(kind),
        (None, "search") => NewKind::Search,
        _ => NewKind::Trim,
    })
}

/// Kinds of documents by name.
fn kind() -> impl TypedValueParser<Value = DocumentKind> {
    let names = PossibleValuesParser::new(DocumentKind::ALL.map(DocumentKind::name));
    names.try_map(|name| DocumentKind::named(&name).ok_or("no such kind"))
}
