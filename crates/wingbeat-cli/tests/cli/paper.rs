//! The pages on the paper: every command in their tables is in the list of commands, whose quick ones end as it says.

use std::fs;

use crate::{entries, root, scratch, wingbeat};

/// The page of verdicts, then that of the evidence.
fn page() -> String {
    ["docs/paper.md", "docs/paper-evidence.md"]
        .map(|page| fs::read_to_string(root().join(page)).unwrap())
        .concat()
}

/// The commands of validation/paper/commands.txt, quick ones first: arguments and exit code.
fn lists() -> Vec<Vec<(String, i32)>> {
    let text = fs::read_to_string(root().join("validation/paper/commands.txt")).unwrap();
    let command = |line: &str| {
        let (text, code) = line.split_once('#').unwrap_or((line, "0"));
        let code = code.split(['>', '|']).next().unwrap();
        (text.trim().to_owned(), code.trim().parse().unwrap())
    };
    let list = |block: &str| -> Vec<_> {
        block.lines().filter(|line| line.starts_with("wingbeat ")).map(command).collect()
    };
    text.split("\n\n").map(list).filter(|list| !list.is_empty()).collect()
}

#[test]
fn every_command_of_the_tables_is_in_a_list() {
    let page = page();
    let listed: Vec<String> = lists().concat().into_iter().map(|(command, _)| command).collect();
    let tables = page.lines().filter(|line| line.starts_with('|'));
    let named =
        tables.flat_map(|line| line.split('`').skip(1).step_by(2)).filter(|c| c.starts_with("wingbeat "));
    let missing: Vec<&str> = named.filter(|command| !listed.iter().any(|known| known == command)).collect();
    assert!(missing.is_empty(), "not in validation/paper/commands.txt: {missing:?}");
    assert!(listed.len() > 15);
}

#[test]
fn the_quick_commands_end_as_the_list_says() {
    for (i, (command, code)) in lists()[0].iter().enumerate() {
        let folder = scratch(&format!("paper-{i}"));
        let place = |word: &str| match word.ends_with(".toml") {
            true => root().join(word).to_string_lossy().into_owned(),
            false => word.to_owned(),
        };
        let words = command.split_whitespace().skip(1).map(|word| word.trim_matches('\''));
        let mut words: Vec<String> = words.map(place).collect();
        words.extend(["--out", "a", "--quiet"].map(str::to_owned));
        let arguments: Vec<&str> = words.iter().map(String::as_str).collect();
        let output = wingbeat(&folder, &arguments);
        assert_eq!(output.status.code(), Some(*code), "{command}: {output:?}");
        assert_eq!(entries(&folder).is_empty(), *code == 2, "{command}");
    }
}

#[test]
fn show_draws_each_kind_of_file_and_refuses_the_others() {
    for (name, file, more) in [
        ("robot", "robots/four_wings.toml", &["--phase", "1.5"][..]),
        ("scenario", "scenarios/glider.toml", &[]),
        ("rig", "rigs/aerobat_on_gen3.toml", &["--joints-deg", "0,20,-100,0,-60,0"]),
    ] {
        let folder = scratch(&format!("show-{name}"));
        let file = root().join(file);
        let arguments = [&["show", file.to_str().unwrap(), "--out", "a", "--quiet"], more].concat();
        let output = wingbeat(&folder, &arguments);
        assert!(output.status.success(), "{name}: {output:?}");
        assert_eq!(entries(&folder.join("a/figures")), ["show.png", "show.svg"], "{name}");
    }
    let folder = scratch("show-refused");
    for (file, more, said) in [
        ("rigs/seven_runs.toml", &[][..], "a list of runs"),
        ("rigs/aerobat_on_gen3.toml", &["--joints-deg", "1,2"], "6 finite numbers"),
        ("robots/aerobat_paper.toml", &["--phase", "nan"], "--phase NaN"),
        ("robots/four_wings.toml", &["--joints-deg", "1,2"], "for the arm of a rig"),
        ("sweeps/flap_map.toml", &[], "key"),
    ] {
        let file = root().join(file);
        let arguments = [&["show", file.to_str().unwrap(), "--out", "a"], more].concat();
        let output = wingbeat(&folder, &arguments);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(said) && entries(&folder).is_empty(), "{text}");
    }
}

#[test]
fn the_sheet_needs_the_shipped_documents() {
    let folder = scratch("paper-nowhere");
    let output = wingbeat(&folder, &["paper", "--from", "nowhere", "--out", "a"]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("nowhere/scenarios/banking_turn.toml"), "{told}");
    assert!(entries(&folder).is_empty());
}

#[test]
#[ignore = "long: cargo xtask long tests"]
fn the_sheet_holds_six_figures_and_the_statements() {
    let (folder, from) = (scratch("paper-sheet"), root().to_string_lossy().into_owned());
    let output = wingbeat(&folder, &["paper", "--wide", "--from", &from, "--out", "a"]);
    assert!(output.status.success(), "{output:?}");
    let read = |name: &str| fs::read_to_string(folder.join("a").join(name)).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).unwrap();
    assert_eq!(summary["status"], "ok");
    let figures = summary["figures"].as_array().unwrap();
    assert_eq!(figures.len(), 6);
    for name in figures.iter().map(|name| name.as_str().unwrap()) {
        let picture = format!("{name}.png");
        assert!(folder.join("a/figures").join(&picture).is_file(), "{name}");
        let slide = fs::read(folder.join("a/figures/wide").join(&picture)).unwrap();
        let size = [16, 20].map(|at| u32::from_be_bytes(slide[at..at + 4].try_into().unwrap()));
        assert_eq!(size, [1920, 1080], "{name}");
    }
    let sheet = read("sheet.html");
    assert_eq!((sheet.matches("<figure ").count(), sheet.matches("<svg").count()), (6, 6));
    assert!(!sheet.contains("href=\"figures") && sheet.contains("off_target"));
    let outcomes: Vec<&str> =
        summary["statements"].as_array().unwrap().iter().map(|s| s["outcome"].as_str().unwrap()).collect();
    assert_eq!(outcomes[..3], ["reproduced"; 3]);
    assert!(outcomes.contains(&"missed") && !outcomes.contains(&"not_computed"));
    assert_eq!(outcomes[outcomes.len() - 2..], ["refuted"; 2]);
    for run in ["turn", "clear", "rig", "forces"] {
        assert!(folder.join("a").join(run).join("manifest.json").is_file(), "{run}");
    }
    assert_eq!(wingbeat(&folder, &["paper", "--from", &from, "--out", "a"]).status.code(), Some(2));
}
