//! Commands and documents that the pages show, tried: those that neither the tutorials nor the pages on the paper cover.
//!
//! A TOML block is a document by the comment before it: `<!-- robot -->` of its own, `<!-- case of cases/flap_f2.toml -->` what it says
//! beside a shipped one, and behind a colon lines that stand before it, ` / ` between two. `<!-- part -->` is what no document holds alone.

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use crate::tools;
use crate::tutorials;

/// Pages whose commands others run.
const ELSEWHERE: [&str; 3] = ["docs/tutorials/", "docs/paper", "docs/cli.md"];
/// Folders that the pages name.
const SHARED: [&str; 6] = ["robots", "scenarios", "cases", "rigs", "calibrations", "sweeps"];
/// Verbs that take a second here, and so run before every change.
const QUICK: [&str; 4] = ["new", "tether", "average", "show"];
/// Beginnings of lines that build, install or rename.
const BUILDS: [&str; 7] = [
    "cargo install ",
    "cargo build ",
    "cargo test ",
    "pip install ",
    "export PATH=",
    "RUSTFLAGS=",
    "CARGO_INCREMENTAL=",
];
/// The program as it is built and run at once.
const BUILT: &str = "cargo run --release -- ";
/// What shows a document of a kind, or reads it.
const READ: [(&str, &str); 5] = [
    ("robot", "show"),
    ("scenario", "show"),
    ("case", "show"),
    ("sweep", "sweep"),
    ("calibration", "calibrate --names"),
];

/// What of a page is tried.
#[derive(Debug, PartialEq)]
enum TriedBlock {
    /// A line of a shell, and the exit code with which it ends.
    Line(String, i32),
    /// A document in a file, and the verb that reads it.
    Document(String, &'static str),
}

impl TriedBlock {
    fn is_quick(&self) -> bool {
        let verb = match self {
            Self::Line(line, _) => line.split_whitespace().nth(1).unwrap_or_default(),
            Self::Document(_, verb) => *verb,
        };
        QUICK.contains(&verb)
    }
}

/// What a page shows, in order; else what is wrong with its blocks.
fn shown(text: &str) -> Result<Vec<TriedBlock>, String> {
    let (mut found, mut lines, mut comment) = (Vec::new(), text.lines(), None);
    while let Some(line) = lines.next() {
        if let Some(said) = line.strip_prefix("<!-- ").and_then(|rest| rest.strip_suffix(" -->")) {
            comment = Some(said);
            continue;
        }
        let Some(kind) = line.strip_prefix("```") else {
            comment = comment.filter(|_| line.trim().is_empty());
            continue;
        };
        let block: Vec<&str> = lines.by_ref().take_while(|line| !line.starts_with("```")).collect();
        match kind {
            "sh" => found.extend(
                block.iter().filter_map(|line| tried(line).transpose()).collect::<Result<Vec<_>, _>>()?,
            ),
            "toml" => found.extend(document(comment, &block.join("\n"))?),
            _ => {}
        }
        comment = None;
    }
    Ok(found)
}

/// What is tried of a line; nothing of one that builds.
fn tried(line: &str) -> Result<Option<TriedBlock>, String> {
    let (command, code) = tutorials::command(line);
    if let Some(arguments) = command.strip_prefix(BUILT) {
        return Ok(Some(TriedBlock::Line(format!("wingbeat {arguments}"), code)));
    }
    if let Some(task) = command.strip_prefix("cargo xtask ") {
        let name = task.split_whitespace().next().unwrap_or_default();
        let known = crate::HELP
            .lines()
            .any(|line| line.strip_prefix("  ").is_some_and(|line| line.split(' ').next() == Some(name)));
        return if known { Ok(None) } else { Err(format!("{command}: no such task")) };
    }
    if command.is_empty()
        || BUILDS.iter().any(|start| command.starts_with(start))
        || command.contains(" --example ")
    {
        return Ok(None);
    }
    if command.starts_with("wingbeat ") {
        return Ok(Some(TriedBlock::Line(command.into(), code)));
    }
    Err(format!("{command}: what is neither the program nor known to build it cannot be tried"))
}

/// The document that a block is, by the comment before it.
fn document(comment: Option<&str>, block: &str) -> Result<Option<TriedBlock>, String> {
    let first = block.lines().next().unwrap_or_default();
    block.parse::<toml::Table>().map_err(|error| format!("{first}: {}", error.message()))?;
    let comment =
        comment.ok_or_else(|| format!("{first}: a comment before it says of what document it is"))?;
    if comment == "part" {
        return Ok(None);
    }
    let (what, before) = comment.split_once(": ").unwrap_or((comment, ""));
    let (kind, base) = what.split_once(" of ").map_or((what, None), |(kind, base)| (kind, Some(base)));
    let Some(&(_, verb)) = READ.iter().find(|(known, _)| *known == kind) else {
        return Err(format!("{comment}: of another kind than {}", READ.map(|(kind, _)| kind).join(", ")));
    };
    let base = base.map_or(String::new(), |base| format!("base = \"../{base}\"\n"));
    Ok(Some(TriedBlock::Document(format!("{base}{}\n{block}\n", before.replace(" / ", "\n")), verb)))
}

/// The pages that are tried here.
fn pages() -> Vec<String> {
    let elsewhere = |page: &String| ELSEWHERE.iter().any(|start| page.starts_with(start));
    tools::pages().into_iter().filter(|page| !elsewhere(page)).collect()
}

/// Tries what `page` shows, or what of it is quick, in an empty folder; how much that was, and what did not go.
fn page(page: &str, quick: bool) -> (usize, Vec<String>) {
    let text = fs::read_to_string(tools::root().join(page)).unwrap_or_default();
    let shown = match shown(&text) {
        Ok(shown) => shown.into_iter().filter(|tried| tried.is_quick() || !quick).collect::<Vec<_>>(),
        Err(why) => return (0, vec![format!("{page}: {why}")]),
    };
    if shown.is_empty() {
        return (0, Vec::new());
    }
    let name = format!("{}-{}", if quick { "quick" } else { "page" }, page.replace(['/', '.'], "-"));
    let folder = match tutorials::folder(&name, &SHARED).and_then(with_given) {
        Ok(folder) => folder,
        Err(error) => return (0, vec![format!("{page}: {error}")]),
    };
    let mut wrong = Vec::new();
    for (number, tried) in shown.iter().enumerate() {
        let (line, code) = match tried {
            TriedBlock::Line(line, code) => (line.clone(), *code),
            TriedBlock::Document(text, verb) => {
                let file = format!("documents/{number}.toml");
                wrong.extend(
                    fs::write(folder.join(&file), text).err().map(|error| format!("{file}: {error}")),
                );
                (format!("wingbeat {verb} {file}"), 0)
            }
        };
        wrong.extend(
            tutorials::shell(&line, code, &folder, &mut Vec::new()).err().map(|why| format!("{page}: {why}")),
        );
    }
    (shown.len(), wrong)
}

/// The folder with what the pages take for given, also in the folder of documents.
fn with_given(folder: PathBuf) -> std::io::Result<PathBuf> {
    let documents = folder.join("documents");
    fs::create_dir_all(&documents)?;
    given(&folder)?;
    given(&documents)?;
    Ok(folder)
}

/// Files that the pages take for given: loads of a cell, outlines, motions, a section.
fn given(folder: &Path) -> std::io::Result<()> {
    // No noise that repeats with the wings: the angle of a golden section.
    let noise = |n: u32| (f64::from(n) * 2.399_963).sin();
    let cell = |n: u32| {
        let phase = TAU * 3.5 * f64::from(n) * 1e-3;
        let load = |k: u32| format!("{:.6}", (phase + f64::from(k)).cos() + 0.01 * noise(6 * n + k));
        (0..6).map(load).collect::<Vec<_>>().join(",") + "\n"
    };
    fs::write(folder.join("cell.csv"), (0..4000).map(cell).collect::<String>())?;
    let row = |n: u32| {
        let phase = TAU * 3.5 * f64::from(n) * 1e-3;
        format!(
            "{:.3},{:.6},{:.6}\n",
            f64::from(n) * 1e-3,
            0.02 * phase.cos(),
            0.3 * phase.sin() + 1e-3 * noise(n)
        )
    };
    fs::write(folder.join("measured.csv"), "t,Fx,Fz\n".to_owned() + &(0..4000).map(row).collect::<String>())?;
    let stroke = |n: u32| {
        format!("{:.3},{:.5}\n", f64::from(n) * 1e-3, 30.0 * (TAU * 3.5 * f64::from(n) * 1e-3).sin())
    };
    fs::write(
        folder.join("stroke.csv"),
        "t,shoulder\n".to_owned() + &(0..2000).map(stroke).collect::<String>(),
    )?;
    let insect = |n: u32| {
        let phase = TAU * f64::from(n) / 64.0;
        let angles = [60.0 * phase.cos(), 5.0 * (2.0 * phase).sin(), 90.0 + 45.0 * phase.sin()];
        format!("{:.6},{:.5},{:.5},{:.5}\n", f64::from(n) / 64.0, angles[0], angles[1], angles[2])
    };
    fs::write(
        folder.join("insect.csv"),
        "phase,stroke,deviation,rotation\n".to_owned() + &(0..64).map(insect).collect::<String>(),
    )?;
    fs::write(
        folder.join("outline.csv"),
        "arc,leading_edge,trailing_edge\n0,-63.5,95.6\n79.2,-80.7,115\n202.7,-101,-81\n",
    )?;
    let groups = "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES 0 LWPOLYLINE 8 outline 70 1 \
                  10 0 20 30 10 200 20 20 10 200 20 -20 10 0 20 -60 0 ENDSEC 0 EOF";
    fs::write(
        folder.join("wing.dxf"),
        groups.split_whitespace().map(|group| format!("{group}\n")).collect::<String>(),
    )?;
    let side =
        |x: f64, up: f64| format!("{x:.5} {:.5}\n", 0.08 * x * (1.0 - x) + up * (x * (1.0 - x)).sqrt());
    let x = |k: i32| f64::from(k) / 20.0;
    let upper: String = (0..=20).rev().map(|k| side(x(k), 0.05)).collect();
    let lower: String = (1..=20).map(|k| side(x(k), -0.05)).collect();
    fs::write(folder.join("naca2412.dat"), format!("a section\n{upper}{lower}"))
}

/// Tries everything that the pages show; true when all goes.
pub fn all() -> bool {
    let (mut tried, mut good) = (0, true);
    for name in pages() {
        let (number, wrong) = page(&name, false);
        tried += number;
        println!("{name}: {number} tried{}", if wrong.is_empty() { "" } else { ", NOT all went" });
        wrong.iter().for_each(|wrong| println!("    {wrong}"));
        good &= wrong.is_empty();
    }
    println!("{tried} commands and documents");
    good && tried > 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quick_commands_and_documents_of_the_pages_go() {
        let (mut tried, mut wrong) = (0, Vec::new());
        for name in pages() {
            let (number, faults) = page(&name, true);
            tried += number;
            wrong.extend(faults);
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
        assert!(tried > 15, "{tried}");
    }

    #[test]
    fn blocks_are_read_from_a_page() {
        let page = "```sh\ncargo run --release -- fly a   # it flies\nwingbeat tether b # exit 3: why\ncargo xtask test\n```\n\
                    <!-- case of cases/c.toml: [wing] / a = 1 -->\n\n```toml\nb = 2\n```\n<!-- part -->\n```toml\n[x]\n```\n";
        let fly = TriedBlock::Line("wingbeat fly a".into(), 0);
        let tether = TriedBlock::Line("wingbeat tether b".into(), 3);
        let case = TriedBlock::Document("base = \"../cases/c.toml\"\n[wing]\na = 1\nb = 2\n".into(), "show");
        assert_eq!(shown(page).unwrap(), [fly, tether, case]);
        for (wrong, said) in [
            ("```toml\na = 1\n```\n", "a comment before it"),
            ("<!-- part -->\nText.\n```toml\na = 1\n```\n", "a comment before it"),
            ("<!-- part -->\n```toml\na = \n```\n", "a = "),
            ("```sh\nrm -r x\n```\n", "cannot be tried"),
            ("```sh\ncargo xtask nothing\n```\n", "no such task"),
            ("<!-- house -->\n```toml\na = 1\n```\n", "of another kind"),
        ] {
            let told = shown(wrong).unwrap_err();
            assert!(told.contains(said), "{told}");
        }
    }
}
