//! The tutorials, carried out from their own text: files are written, commands run, and what the pages show of the output is compared
//! with it.
//!
//! Comments of the page say what a reader does by hand: `<!-- file NAME -->` writes the next block, `<!-- append NAME -->` adds it,
//! `<!-- replace NAME: A => B -->` edits a line, `<!-- copy PAGE NAME -->` writes the first TOML block of a page.
//! Behind `<!-- long -->` stands what takes longer than a test before every change may take, and so does the block below
//! `<!-- long block -->`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::tools;

/// The pages, each with the folders of the repository that its commands name.
const PAGES: [(&str, &[&str]); 4] = [
    ("docs/tutorials/wing.md", &[]),
    ("docs/tutorials/robot.md", &["robots", "scenarios"]),
    ("docs/tutorials/load_cell.md", &[]),
    ("docs/tutorials/paper.md", &["robots", "scenarios", "rigs"]),
];
/// A step of a page.
#[derive(Debug, PartialEq)]
enum TutorialStep {
    /// A file with its text; whether it is added to what is there.
    File { name: String, text: String, more: bool },
    /// A file, what stands in it, what takes its place.
    Replace(String, String, String),
    /// A page of docs and the file that its first TOML block is written to.
    Copy(String, String),
    /// A line of a shell and the exit code that its comment says.
    Run(String, i32),
    /// Lines that the commands before have printed.
    Printed(Vec<String>),
}

/// The steps of a page, in order.
fn steps(text: &str) -> Vec<TutorialStep> {
    let (mut steps, mut lines, mut named) = (Vec::new(), text.lines(), None);
    while let Some(line) = lines.next() {
        if let Some(comment) = line.strip_prefix("<!-- ").and_then(|rest| rest.strip_suffix(" -->")) {
            let (verb, rest) = comment.split_once(' ').unwrap_or((comment, ""));
            match verb {
                "file" | "append" => named = Some((rest.to_owned(), verb == "append")),
                "replace" => steps.extend(replacement(rest)),
                "copy" => steps.extend(
                    rest.split_once(' ').map(|(page, name)| TutorialStep::Copy(page.into(), name.into())),
                ),
                _ => {}
            }
            continue;
        }
        let Some(kind) = line.strip_prefix("```") else { continue };
        let block: Vec<&str> = lines.by_ref().take_while(|line| !line.starts_with("```")).collect();
        match (named.take(), kind) {
            (Some((name, more)), _) => {
                steps.push(TutorialStep::File { name, text: block.join("\n") + "\n", more })
            }
            (None, "sh") => {
                steps.extend(block.iter().filter(|line| !line.trim().is_empty()).map(|line| run(line)))
            }
            (None, "text") => {
                steps.push(TutorialStep::Printed(block.iter().map(|line| plain(line)).collect()))
            }
            _ => {}
        }
    }
    steps
}

fn replacement(rest: &str) -> Option<TutorialStep> {
    let (name, edit) = rest.split_once(": ")?;
    let (then, now) = edit.split_once(" => ")?;
    Some(TutorialStep::Replace(name.into(), then.into(), now.into()))
}

fn run(line: &str) -> TutorialStep {
    let (command, code) = command(line);
    TutorialStep::Run(command.into(), code)
}

/// The command of a line of a shell and its exit code, which is 0 where no `# exit 3` behind it says another one.
pub fn command(line: &str) -> (&str, i32) {
    let (command, comment) = line.split_once(" #").unwrap_or((line, ""));
    let code = comment
        .trim()
        .strip_prefix("exit ")
        .and_then(|code| code.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok());
    (command.trim(), code.unwrap_or(0))
}

/// A line with single blanks.
fn plain(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// An empty folder with links to those of the repository.
pub fn folder(name: &str, shared: &[&str]) -> std::io::Result<PathBuf> {
    let folder = tools::root().join("target/tutorials").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder)?;
    for shared in shared {
        #[cfg(unix)]
        std::os::unix::fs::symlink(tools::root().join(shared), folder.join(shared))?;
        #[cfg(not(unix))]
        return Err(std::io::Error::other(format!("{shared}: no links on this system")));
    }
    Ok(folder)
}

/// Carries a page out in `folder`; the steps that went otherwise than it says.
fn carried_out(text: &str, folder: &Path) -> Vec<String> {
    let (mut wrong, mut printed) = (Vec::new(), Vec::new());
    let mut fresh = true;
    for step in steps(text) {
        let result = match step {
            TutorialStep::Run(line, code) => {
                if std::mem::take(&mut fresh) {
                    printed.clear();
                }
                shell(&line, code, folder, &mut printed)
            }
            TutorialStep::Printed(lines) => {
                fresh = true;
                missing(&lines, &printed)
            }
            TutorialStep::File { name, text, more } => {
                let before = if more {
                    fs::read_to_string(folder.join(&name)).unwrap_or_default()
                } else {
                    String::new()
                };
                fs::write(folder.join(&name), before + &text).map_err(|error| format!("{name}: {error}"))
            }
            TutorialStep::Replace(name, then, now) => replace(&folder.join(name), &then, &now),
            TutorialStep::Copy(page, name) => {
                copied(&page).and_then(|text| fs::write(folder.join(name), text).map_err(|e| e.to_string()))
            }
        };
        wrong.extend(result.err());
    }
    wrong
}

/// Runs a line in `folder` with the program that the tests have built in front of the path; it ends with `code`.
///
/// # Errors
/// That it did not.
pub fn shell(line: &str, code: i32, folder: &Path, printed: &mut Vec<String>) -> Result<(), String> {
    let programs = tools::program().parent().map(Path::to_path_buf).unwrap_or_default();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::env::join_paths(std::iter::once(programs).chain(std::env::split_paths(&path)));
    let mut command = Command::new("sh");
    command.args(["-c", line]).current_dir(folder).env("PATH", paths.map_err(|error| error.to_string())?);
    let output = command.output().map_err(|error| format!("{line}: {error}"))?;
    for text in [&output.stdout, &output.stderr] {
        printed.extend(String::from_utf8_lossy(text).lines().map(plain));
    }
    let last = printed.last().map_or("", String::as_str);
    match output.status.code() {
        Some(ended) if ended == code => Ok(()),
        ended => Err(format!("{line}: exit code {ended:?}, the page says {code}: {last}")),
    }
}

/// The first line that was not printed.
fn missing(lines: &[String], printed: &[String]) -> Result<(), String> {
    let lacks = |line: &&String| !line.is_empty() && !printed.iter().any(|said| said == *line);
    match lines.iter().find(lacks) {
        None => Ok(()),
        Some(line) => {
            let word = line.split(' ').next().unwrap_or_default();
            let near = printed.iter().find(|said| said.starts_with(word)).map_or("", String::as_str);
            Err(format!("not printed: {line}\n      there is: {near}"))
        }
    }
}

fn replace(path: &Path, then: &str, now: &str) -> Result<(), String> {
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    if !text.contains(then) {
        return Err(format!("{}: there is no {then}", path.display()));
    }
    fs::write(path, text.replacen(then, now, 1)).map_err(|error| error.to_string())
}

/// The first TOML block of a page.
fn copied(page: &str) -> Result<String, String> {
    let text = fs::read_to_string(tools::root().join(page)).map_err(|error| format!("{page}: {error}"))?;
    let block = text.split_once("```toml\n").and_then(|(_, rest)| rest.split_once("```"));
    block.map(|(block, _)| block.to_owned()).ok_or_else(|| format!("{page}: no TOML block"))
}

/// Carries out every page whole; true when all goes as they say.
pub fn all() -> bool {
    let mut good = true;
    for (page, shared) in PAGES {
        let name = page.rsplit('/').next().unwrap_or(page).trim_end_matches(".md");
        let text = fs::read_to_string(tools::root().join(page)).map_err(|error| error.to_string());
        let done = folder(name, shared).map_err(|error| error.to_string());
        let wrong = match (text, done) {
            (Ok(text), Ok(folder)) => carried_out(&text, &folder),
            (text, folder) => text.err().into_iter().chain(folder.err()).collect(),
        };
        println!("{page}: {}", if wrong.is_empty() { "as it says" } else { "NOT as it says" });
        wrong.iter().for_each(|wrong| println!("    {wrong}"));
        good &= wrong.is_empty();
    }
    good
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Most commands of a tutorial.
    const MOST_COMMANDS: usize = 20;
    /// What each page does not wait for.
    const LONG: &str = "<!-- long -->";
    /// What stands above a block that is not waited for.
    const LONG_BLOCK: &str = "<!-- long block -->\n```";

    /// The text without the blocks that are not waited for.
    fn without_long_blocks(text: &str) -> String {
        let mut parts = text.split(LONG_BLOCK);
        let first = parts.next().unwrap_or_default().to_owned();
        parts.fold(first, |kept, part| kept + part.split_once("\n```").map_or("", |(_, after)| after))
    }

    #[test]
    fn the_short_parts_of_the_tutorials_go_as_they_say() {
        for (page, shared) in PAGES {
            let text = fs::read_to_string(tools::root().join(page)).unwrap();
            let commands = steps(&text).iter().filter(|step| matches!(step, TutorialStep::Run(..))).count();
            assert!(commands <= MOST_COMMANDS, "{page}: {commands} commands");
            let (short, long) = text.split_once(LONG).unwrap_or((&text, ""));
            assert!(!long.is_empty(), "{page}: no {LONG}");
            let name = page.rsplit('/').next().unwrap().trim_end_matches(".md");
            let short = without_long_blocks(short);
            let wrong = carried_out(&short, &folder(&format!("short-{name}"), shared).unwrap());
            assert!(wrong.is_empty(), "{page}: {}", wrong.join("\n"));
        }
    }

    #[test]
    fn long_blocks_are_left_out() {
        let page = "a\n<!-- long block -->\n```sh\nslow\n```\nb\n```sh\nquick\n```\n";
        assert_eq!(without_long_blocks(page), "a\n\nb\n```sh\nquick\n```\n");
        assert_eq!(steps(page).len(), 2);
    }

    #[test]
    fn steps_are_read_from_a_page() {
        let page = "a\n<!-- file x.toml -->\n```toml\na = 1\n```\n```sh\nwingbeat fly x   # exit 3: why\nls\n```\n```text\n a   b\n```\n\
                    <!-- replace x.toml: a = 1 => a = 2 -->\n```python\nno\n```\n";
        let file = TutorialStep::File { name: "x.toml".into(), text: "a = 1\n".into(), more: false };
        let edit = TutorialStep::Replace("x.toml".into(), "a = 1".into(), "a = 2".into());
        let printed = TutorialStep::Printed(vec!["a b".into()]);
        let runs = [TutorialStep::Run("wingbeat fly x".into(), 3), TutorialStep::Run("ls".into(), 0)];
        let [fly, ls] = runs;
        assert_eq!(steps(page), [file, fly, ls, printed, edit]);
        let said = |lines: &[&str]| lines.iter().map(|line| (*line).to_owned()).collect::<Vec<_>>();
        assert!(missing(&said(&["a b", ""]), &said(&["c", "a b"])).is_ok());
        assert!(missing(&said(&["a b"]), &said(&["a c"])).unwrap_err().contains("there is: a c"));
    }
}
