//! `wingbeat new`: documents to begin from, made of those that ship.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use wingbeat::scenario::{DocumentKind, RunName};

use crate::args::{New, NewKind};
use crate::error::Error;
use crate::say;

mod around;

/// Writes a document and, where they are not there yet, those that it names.
pub fn new(arguments: &New) -> Result<(), Error> {
    use DocumentKind::{Calibration, Robot, Scenario};
    let refuse = |option: &str, kinds: &str| Err(Error::Input(format!("{option}: allowed with {kinds}")));
    match (arguments.kind, &arguments.robot, &arguments.case) {
        (NewKind::Document(Robot), ..) if arguments.minimal => {
            around::write(arguments, "robot", around::minimal)
        }
        _ if arguments.minimal => refuse("--minimal", "`new robot`"),
        (NewKind::Document(Scenario), Some(robot), _) => {
            around::write(arguments, "scenario", |name, folder| around::flight(name, robot, folder, false))
        }
        (NewKind::Trim, Some(robot), _) => {
            around::write(arguments, "trim", |name, folder| around::flight(name, robot, folder, true))
        }
        (NewKind::Trim, None, _) => {
            Err(Error::Input("--robot: `new trim` needs the robot to be trimmed, --robot ROBOT.toml".into()))
        }
        (NewKind::Document(Calibration), _, Some(case)) => {
            around::write(arguments, "calibration", |name, folder| around::calibration(name, case, folder))
        }
        (_, Some(_), _) => refuse("--robot", "`new scenario` and `new trim`"),
        (_, _, Some(_)) => refuse("--case", "`new calibration`"),
        (NewKind::Document(kind), None, None) => {
            shipped_document(arguments, kind, beside(kind), shipped(kind, kind))
        }
        (NewKind::Search, None, None) => {
            let text = include_str!("../documents/search.toml");
            shipped_document(arguments, DocumentKind::Sweep, "search.toml".into(), text)
        }
    }
}

/// Writes the document `text`, in a file called `usual` where no other is asked, and, where they are not there yet, those that it names.
fn shipped_document(arguments: &New, kind: DocumentKind, usual: String, text: &str) -> Result<(), Error> {
    let path = arguments.path.clone().unwrap_or_else(|| PathBuf::from(usual));
    let file = name_of(&path)?;
    let mut told = String::new();
    let taken = is_taken(&path, arguments.force)?;
    if let Some(clash) = named(kind).iter().map(|other| beside(*other)).find(|other| *other == file) {
        return Err(Error::Input(format!(
            "{}: another name: what the {} names is written as {clash}",
            path.display(),
            kind.name()
        )));
    }
    for &other in named(kind) {
        let companion = path.with_file_name(beside(other));
        match create(&companion, &document(other, shipped(other, kind), kind, file)) {
            Ok(()) => told += &format!("{}: written\n", companion.display()),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                told += &format!("{}: was there already, kept\n", companion.display());
            }
            Err(source) => return Err(Error::file(&companion, source)),
        }
    }
    put(&path, &document(kind, text, kind, file), taken)?;
    told += &format!("{}: written\n{}\n", path.display(), next(kind, &path));
    say::say(&told)
}

/// Whether a file is at `path` that may be replaced.
fn is_taken(path: &Path, force: bool) -> Result<bool, Error> {
    let taken = fs::symlink_metadata(path).is_ok();
    if taken && !(force && path.is_file()) {
        let allowed = if path.is_file() { "; --force replaces it" } else { "" };
        return Err(Error::Input(format!("{}: is there already{allowed}", path.display())));
    }
    Ok(taken)
}

fn put(path: &Path, text: &str, taken: bool) -> Result<(), Error> {
    let written = if taken { write(path, text) } else { create(path, text) };
    written.map_err(|source| Error::file(path, source))
}

/// The file name of `path`, as the documents beside it give it.
fn name_of(path: &Path) -> Result<&str, Error> {
    let name = path.file_name().and_then(|name| name.to_str());
    let good = name.filter(|name| RunName::new("PATH", name).is_ok() && name.ends_with(".toml"));
    good.ok_or_else(|| {
        Error::Input(format!(
            "{}: allowed is a file name that ends with .toml and is good on every system",
            path.display()
        ))
    })
}

fn create(path: &Path, text: &str) -> io::Result<()> {
    if fs::symlink_metadata(path).is_ok() {
        return Err(io::ErrorKind::AlreadyExists.into());
    }
    write(path, text)
}

/// Writes the whole file or nothing: under another name first.
fn write(path: &Path, text: &str) -> io::Result<()> {
    // Where a link lies, what it leads to.
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = path.with_file_name(format!(".{name}.partial"));
    let written = fs::write(&partial, text).and_then(|()| fs::rename(&partial, path));
    if written.is_err() {
        let _ = fs::remove_file(&partial);
    }
    written
}

/// What a document is called beside that which names it.
fn beside(kind: DocumentKind) -> String {
    format!("{}.toml", kind.name())
}

/// What must be there for a document to run.
fn named(kind: DocumentKind) -> &'static [DocumentKind] {
    use DocumentKind::{Arm, Calibration, Case, Rig, Robot, Run, Runs, Scenario, Sweep};
    match kind {
        Robot | Case | Arm => &[],
        Scenario => &[Robot],
        Sweep => &[Robot, Scenario],
        Run => &[Robot, Arm, Rig],
        Runs => &[Robot, Arm, Rig, Run],
        Rig => &[Robot, Arm, Run],
        Calibration => &[Robot, Arm, Rig, Run],
    }
}

/// The shipped text of a document for that which is asked for.
fn shipped(kind: DocumentKind, asked: DocumentKind) -> &'static str {
    use DocumentKind::{Arm, Calibration, Case, Rig, Robot, Run, Runs, Scenario, Sweep};
    match (kind, asked) {
        (Robot, Robot | Scenario | Sweep) => include_str!("../documents/aerobat_paper.toml"),
        (Robot, _) => include_str!("../documents/aerobat_beta.toml"),
        (Scenario, _) => include_str!("../documents/banking_turn.toml"),
        (Case, _) => include_str!("../documents/flap_fold.toml"),
        (Sweep, _) => include_str!("../documents/banking_turn_robustness.toml"),
        (Rig, _) => include_str!("../documents/aerobat_on_gen3.toml"),
        (Arm, _) => include_str!("../documents/kinova_gen3_6dof.toml"),
        (Run, _) => include_str!("../documents/roll15_speed08.toml"),
        (Calibration, _) => include_str!("../documents/two_runs.toml"),
        (Runs, _) => {
            "# Runs on the rig, planned, simulated and processed together.\nruns = [\n    \"run.toml\",\n]\n"
        }
    }
}

/// How a document of a kind begins.
fn head(kind: DocumentKind) -> String {
    format!(
        "# Every key, its unit and range: docs/reference.md. For an editor that completes and checks:\n\
         # `wingbeat schema {0} > {0}.schema.json`, and `#:schema {0}.schema.json` as the first line here.\n\n",
        kind.name()
    )
}

/// The `given` text of a document among those of `wingbeat new`, of which `main` is in the file `file` and called after it.
fn document(kind: DocumentKind, given: &str, main: DocumentKind, file: &str) -> String {
    let stem = file.trim_end_matches(".toml");
    let mut text = head(kind);
    for line in given.lines().filter(|line| !line.starts_with("#:schema")) {
        // A cell's `calibration` is no document.
        let named = |key| DocumentKind::named(key).filter(|named| *named != DocumentKind::Calibration);
        text += &match line.split_once(" = \"").map(|(key, _)| (key, named(key))) {
            Some(("name", _)) if kind == main && !text.contains("\nname = ") => format!("name = \"{stem}\""),
            Some((_, Some(named))) if named == main => format!("{} = \"{file}\"", named.name()),
            Some((_, Some(named))) => format!("{} = \"{}\"", named.name(), beside(named)),
            _ => line.to_owned(),
        };
        text.push('\n');
    }
    text
}

/// What to do with a document.
fn next(kind: DocumentKind, path: &Path) -> String {
    use DocumentKind::{Arm, Calibration, Case, Rig, Robot, Run, Runs, Scenario, Sweep};
    let shown = as_word(path);
    let file = path.file_name().unwrap_or_default().display();
    match kind {
        Robot => format!("next: name it in a scenario, robot = \"{file}\" (wingbeat new scenario)"),
        Arm => format!("next: name it in a rig, arm = \"{file}\" (wingbeat new rig)"),
        Scenario => format!("next: wingbeat fly {shown}"),
        Case => format!("next: wingbeat tether {shown}"),
        Sweep => format!("next: wingbeat sweep {shown}"),
        Run | Runs => format!("next: wingbeat rig plan {shown}"),
        Calibration => format!("next: wingbeat calibrate {shown}"),
        Rig => format!("next: wingbeat rig plan {}", as_word(&path.with_file_name(beside(Run)))),
    }
}

/// A path as one word of a shell.
fn as_word(path: &Path) -> String {
    let shown = path.display().to_string();
    let plain = |letter: char| letter.is_alphanumeric() || "/\\._-+:,@%".contains(letter);
    if shown.chars().all(plain) { shown } else { format!("'{}'", shown.replace('\'', r"'\''")) }
}
