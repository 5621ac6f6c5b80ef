//! Every command that the pages show is one that the program knows.

use std::fs;
use std::path::PathBuf;

use clap::Parser;
use clap::error::ErrorKind;

use crate::args::CommandLine;

/// README.md and all pages in docs but the generated ones.
fn pages() -> Vec<PathBuf> {
    let (mut folders, mut found) = (vec![super::root().join("docs")], vec![super::root().join("README.md")]);
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            let generated = ["cli.md", "reference.md"].iter().any(|name| path.ends_with(name));
            match path.is_dir() {
                true => folders.push(path),
                false if path.extension().is_some_and(|end| end == "md") && !generated => found.push(path),
                false => {}
            }
        }
    }
    found
}

/// The words of a line as a shell makes them: quotes are taken away, a comment, a pipe, a redirection or another command ends it.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for letter in line.chars() {
        match (quote, letter) {
            (Some(open), letter) if letter == open => quote = None,
            (None, '"' | '\'') => (quote, word) = (Some(letter), Some(word.unwrap_or_default())),
            (None, '#') if word.is_none() => break,
            (None, '>' | '|' | '&' | ';') => break,
            (None, letter) if letter.is_whitespace() => words.extend(word.take()),
            (_, letter) => word.get_or_insert_default().push(letter),
        }
    }
    words.extend(word);
    words
}

/// Whether brackets or wildcards stand outside of quotes: some shells (zsh) take them for names of files.
fn is_bare(command: &str) -> bool {
    let mut quote = None;
    for letter in command.chars() {
        match (quote, letter) {
            (Some(open), letter) if letter == open => quote = None,
            (None, '"' | '\'') => quote = Some(letter),
            (None, '#' | '>' | '|' | '&' | ';') => return false,
            (None, '[' | ']' | '*' | '?' | '{' | '}') => return true,
            _ => {}
        }
    }
    false
}

/// Why the program would not understand a command; none where only its arguments are left out.
fn wrong(command: &str) -> Option<String> {
    let of_program = command.split_once("wingbeat ").map_or(command, |(_, rest)| rest);
    let arguments = std::iter::once("wingbeat".to_owned()).chain(words(of_program));
    let error = CommandLine::try_parse_from(arguments).err()?;
    let left_out = [
        ErrorKind::MissingRequiredArgument,
        ErrorKind::MissingSubcommand,
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand,
        ErrorKind::DisplayHelp,
        ErrorKind::DisplayVersion,
    ];
    (!left_out.contains(&error.kind()))
        .then(|| error.to_string().lines().next().unwrap_or_default().to_owned())
}

/// The commands of a page: lines of its blocks, and what stands between backticks.
fn commands(text: &str) -> Vec<String> {
    let mut fenced = false;
    let mut found = Vec::new();
    for line in text.lines() {
        let is_fence = line.trim_start().starts_with("```");
        fenced ^= is_fence;
        let line = line.trim();
        if (fenced && !is_fence) || line.starts_with("    wingbeat ") {
            found.extend(line.starts_with("wingbeat ").then(|| line.to_owned()));
        } else if !fenced {
            found.extend(
                line.split('`')
                    .skip(1)
                    .step_by(2)
                    .filter(|code| code.starts_with("wingbeat "))
                    .map(Into::into),
            );
        }
    }
    // What leaves something out says so; a key of Cargo is no command.
    found.retain(|command: &String| !command.contains("...") && !command.starts_with("wingbeat ="));
    found
}

#[test]
fn every_command_of_the_pages_is_in_the_reference_of_the_program() {
    let mut found = 0;
    let mut faults = Vec::new();
    for page in pages() {
        for command in commands(&fs::read_to_string(&page).unwrap()) {
            found += 1;
            let bare = is_bare(&command).then(|| "brackets need quotes".to_owned());
            faults.extend(
                bare.or_else(|| wrong(&command)).map(|why| format!("{}: {command}: {why}", page.display())),
            );
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(found > 100, "{found}");
}

#[test]
fn wrong_commands_are_found_by_this_reference() {
    assert!(is_bare("fly --set a[0]=1") && !is_bare("fly --set 'a[0]=1' # [b]"));
    assert_eq!(words("fly a.toml --set \"k=[1, 2]\" # it flies"), ["fly", "a.toml", "--set", "k=[1, 2]"]);
    for (command, known) in [
        ("wingbeat fly a.toml --set x=1 && wingbeat no", true),
        ("wingbeat rig plan", true),
        ("wingbeat flies a.toml", false),
        ("wingbeat fly a.toml --sett x=1", false),
        ("wingbeat new house", false),
    ] {
        assert_eq!(wrong(command).is_none(), known, "{command}");
    }
    assert_eq!(
        commands("a `wingbeat show F`\n```sh\nwingbeat fly b\n```\n"),
        ["wingbeat show F", "wingbeat fly b"]
    );
}
