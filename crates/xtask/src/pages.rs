//! Checks of README.md and of the pages in docs: length, links, the book's table of contents, plain English.

use std::fs;
use std::path::{Component, Path};

use crate::tools::{self, pages};

/// The most lines of README.md.
const README_LINES: usize = 120;

/// The most lines of a page that is written by hand.
const PAGE_LINES: usize = 300;

/// The most words of a sentence.
const SENTENCE_WORDS: usize = 35;

/// The most bytes of docs that are written by hand: all of its pages but what [`GENERATED`] and [`BLOCKS`] name, and [`WORDS`].
const HAND_WRITTEN_BYTES: usize = 220_000;

/// Pages that the code writes; their text is that of its doc comments, or of [`WORDS`].
const GENERATED: [&str; 6] = [
    "docs/cli.md",
    "docs/equations.md",
    "docs/paper-commands.md",
    "docs/python_reference.md",
    "docs/reference.md",
    "docs/validation.md",
];

/// The words of docs/validation.md, written by hand beside the comparisons.
const WORDS: &str = "crates/wingbeat-validate/src/page.md";

/// Blocks of other pages that the code writes, from `<!-- NAME -->` to `<!-- end -->`: what flies, what measures, what is declared.
const BLOCKS: [(&str, &[&str]); 5] = [
    ("docs/banking_turn.md", &["banking turn", "banking turn, full", "six flights"]),
    ("docs/flight.md", &["turn that carries its weight"]),
    ("docs/performance.md", &["mechanics", "first", "flapbody14", "offline", "lattice", "steps"]),
    ("docs/sections.md", &["laws", "parameters"]),
    (
        "docs/verdicts.md",
        &[
            "statuses",
            "limits of flight",
            "limits of range",
            "limits of membrane",
            "limits of flap",
            "limits of spar",
            "limits of linkage",
            "limits of trim",
            "limits of plan",
            "limits of sweep",
            "limits of calibration",
            "limits of tether",
            "limits of wake",
            "limits of paper",
            "limits of rig",
            "limits of data",
            "limits of recording",
        ],
    ),
];

/// Pages whose prose is not yet plain English; one that has become so must leave the list.
const NOT_YET_PLAIN: &[&str] = &[];

/// Words that a reader of the field does not know in that sense, and what to write.
const PRIVATE_WORDS: [(&str, &str); 26] = [
    ("told", "reported, given or distinguished"),
    ("made a choice", "we chose it"),
    ("led and not fed back", "feed-forward only"),
    ("what stands before", "the name of what it is"),
    ("tested for", "outside the validated range"),
    ("work runs beside", "what goes on and where"),
    ("cannot tell", "cannot identify"),
    ("unrest", "loads that differ from step to step"),
    ("test bench", "rig"),
    ("benches", "rigs"),
    ("half amplitude", "amplitude"),
    ("hang on", "depend on"),
    ("hangs on", "depends on"),
    ("one's own", "your own"),
    ("the begin", "the start"),
    ("refused are", "a sentence with subject and verb"),
    ("carried air", "added mass"),
    // One word for one thing, over all pages; the glossary has them.
    ("regulators", "actuators (what moves a joint) or controllers; the linear-quadratic regulator is one"),
    ("beat", "cycle"),
    ("beats", "cycles"),
    ("strokes", "cycles, flapping or amplitudes; of actuators their ranges"),
    ("caution", "warning"),
    ("cautions", "warnings"),
    ("by a fit", "fitted"),
    ("on the ground", "along the horizon, or ground speed"),
    ("over the ground", "in world axes, or ground speed"),
];

/// The text of a page, by its path from the root.
fn text(page: &str) -> String {
    fs::read_to_string(tools::root().join(page)).unwrap()
}

/// The lines outside of fenced blocks.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut fenced = false;
    text.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fence && !fenced
    })
}

/// A line without what stands between backticks.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join("x")
}

/// The targets of the links of a page.
fn links(text: &str) -> Vec<String> {
    let target = |rest: &str| rest.split(')').next().unwrap_or("").to_owned();
    let of_line = |line: &str| without_code(line).split("](").skip(1).map(target).collect::<Vec<_>>();
    prose(text).flat_map(of_line).collect()
}

/// The anchors of a page's headings, as GitHub and mdbook make them.
fn anchors(text: &str) -> Vec<String> {
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    let anchor = |title: &str| {
        title.trim().to_lowercase().chars().filter(kept).map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    prose(text)
        .filter(|line| line.starts_with('#'))
        .map(|line| anchor(line.trim_start_matches('#')))
        .collect()
}

/// The path from the root that a link of `page` leads to; none where it leaves the repository.
fn resolved(page: &str, target: &str) -> Option<String> {
    let mut path = Path::new(page).parent()?.to_path_buf();
    for part in Path::new(target).components() {
        match part {
            Component::ParentDir => path.pop().then_some(())?,
            part => path.push(part),
        }
    }
    Some(path.to_string_lossy().into_owned())
}

/// What is wrong with a link of `page`.
fn broken(page: &str, link: &str) -> Option<String> {
    if link.contains("://") {
        return None;
    }
    let (target, anchor) = link.split_once('#').unwrap_or((link, ""));
    let file = if target.is_empty() { page.to_owned() } else { resolved(page, target)? };
    if !tools::root().join(&file).exists() {
        return Some(format!("{page}: {link} leads nowhere"));
    }
    if page.starts_with("docs/") && !file.starts_with("docs/") {
        return Some(format!("{page}: {link} leaves the book"));
    }
    let missing = !anchor.is_empty() && !anchors(&text(&file)).iter().any(|known| known == anchor);
    missing.then(|| format!("{page}: {link}: {file} has no such heading"))
}

/// The sentences of a page, without tables, headings, comments and indented blocks.
fn sentences(text: &str) -> Vec<String> {
    let item = |line: &str| {
        let start = line.trim_start();
        start.starts_with("- ") || start.split_once(". ").is_some_and(|(n, _)| n.parse::<u8>().is_ok())
    };
    let mut paragraphs = vec![String::new()];
    for line in prose(text) {
        let apart = line.trim().is_empty() || line.starts_with(['|', '#', '<']) || line.starts_with("    ");
        if apart || item(line) {
            paragraphs.push(String::new());
        }
        if let (false, Some(last)) = (apart, paragraphs.last_mut()) {
            *last += &format!("{} ", without_code(line));
        }
    }
    let ended = |paragraph: &String| -> Vec<String> {
        let marked =
            paragraph.replace(".** ", ".**\n").replace(". ", ".\n").replace("? ", "?\n").replace("! ", "!\n");
        marked.lines().map(|sentence| sentence.trim().to_owned()).collect()
    };
    paragraphs.iter().flat_map(ended).collect()
}

/// Sentences that are too long and words that a reader does not know, in a page.
fn unplain(page: &str, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    // Cells of tables may be longer than a sentence, but no stranger; those of the limits are the code's.
    let tables = page != "docs/verdicts.md";
    let cells = prose(text).filter(|line| tables && line.starts_with('|')).map(without_code);
    let sentences = sentences(text).into_iter().map(|sentence| (sentence, true));
    for (sentence, whole) in sentences.chain(cells.map(|cells| (cells, false))) {
        let words = sentence.split_whitespace().count();
        if whole && words > SENTENCE_WORDS {
            found.push(format!("{page}: a sentence of {words} words: {sentence}"));
        }
        let lower = sentence.to_lowercase();
        let has = |word: &str| {
            let apart = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
            lower.match_indices(word).any(|(i, _)| {
                apart(lower[..i].chars().next_back()) && apart(lower[i + word.len()..].chars().next())
            })
        };
        for (word, better) in PRIVATE_WORDS.iter().filter(|(word, _)| has(word)) {
            found.push(format!("{page}: {word:?}, write {better}: {sentence}"));
        }
    }
    found
}

/// The text of a page without the blocks that the code writes; which of them it has.
fn by_hand(text: &str) -> (String, Vec<&str>) {
    let (mut kept, mut names) = (String::new(), Vec::new());
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once("\n<!-- end -->") {
        let at = before.rfind("<!-- ").unwrap_or_else(|| panic!("`<!-- end -->` ends nothing: {before}"));
        let (name, _) = before[at + 5..].split_once(" -->\n").expect("a mark is a line of its own");
        kept += &before[..at];
        names.push(name);
        rest = behind;
    }
    (kept + rest, names)
}

#[test]
fn pages_by_hand_are_short_together() {
    let mut sizes = vec![(text(WORDS).len(), WORDS.to_owned())];
    for page in pages().iter().filter(|page| page.starts_with("docs/") && !GENERATED.contains(&page.as_str()))
    {
        let text = text(page);
        let (kept, names) = by_hand(&text);
        let known = BLOCKS.iter().find(|(known, _)| known == page).map_or(&[][..], |(_, names)| names);
        assert_eq!(names, known, "{page}: blocks that the code writes");
        sizes.push((kept.len(), page.clone()));
    }
    let bytes: usize = sizes.iter().map(|(size, _)| size).sum();
    sizes.sort_unstable();
    println!("{bytes} bytes by hand: {sizes:?}");
    assert!(
        bytes <= HAND_WRITTEN_BYTES,
        "docs has {bytes} bytes that are written by hand, allowed are {HAND_WRITTEN_BYTES}; the longest: {:?}",
        &sizes[sizes.len() - 5..]
    );
}

#[test]
fn no_page_is_long() {
    for page in pages() {
        let (lines, most) = (
            by_hand(&text(&page)).0.lines().count(),
            if page == "README.md" { README_LINES } else { PAGE_LINES },
        );
        assert!(
            lines <= most || GENERATED.contains(&page.as_str()),
            "{page} has {lines} lines, allowed are {most}"
        );
    }
}

#[test]
fn every_link_leads_somewhere() {
    let found: Vec<String> = pages()
        .iter()
        .flat_map(|page| {
            links(&text(page)).into_iter().filter_map(|link| broken(page, &link)).collect::<Vec<_>>()
        })
        .collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_book_holds_every_page() {
    let summary = "docs/SUMMARY.md";
    let listed: Vec<String> =
        links(&text(summary)).iter().filter_map(|link| resolved(summary, link)).collect();
    let pages = pages();
    let missing: Vec<&String> = pages
        .iter()
        .filter(|page| page.starts_with("docs/") && *page != summary && !listed.contains(page))
        .collect();
    assert!(missing.is_empty(), "not in {summary}: {missing:?}");
}

#[test]
fn prose_is_plain() {
    let (mut found, mut plain) = (Vec::new(), Vec::new());
    let words = WORDS.to_owned();
    for page in pages().iter().filter(|page| !GENERATED.contains(&page.as_str())).chain([&words]) {
        let here = unplain(page, &text(page));
        match (NOT_YET_PLAIN.contains(&page.as_str()), here.is_empty()) {
            (true, true) => plain.push(page.clone()),
            (true, false) => {}
            (false, _) => found.extend(here),
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    assert!(plain.is_empty(), "now plain, to be taken from the list of those that are not yet: {plain:?}");
}

/// Their sentences are those of many places, and only their words are held against the list.
#[test]
fn pages_of_the_code_use_the_same_words() {
    let mut found = Vec::new();
    for page in GENERATED.iter().filter(|page| **page != "docs/validation.md") {
        // The help texts stand in fenced blocks.
        let text = text(page).replace("```", "");
        found.extend(text.lines().flat_map(|line| unplain(page, &format!("| {line}"))));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn what_the_code_writes_does_not_count() {
    let page = "a\n<!-- long -->\n\n<!-- x y -->\n| 1 |\n<!-- end -->\nb\n";
    assert_eq!(by_hand(page), ("a\n<!-- long -->\n\n\nb\n".to_owned(), vec!["x y"]));
}

#[test]
fn links_anchors_and_sentences_are_read() {
    let page =
        "# A & B, c\n\nSee [x](y.md#z) and `[no](link)`.\nNext told one. Two words\n\n```\n[n](o)\n```\n";
    assert_eq!(links(page), ["y.md#z"]);
    assert_eq!(anchors(page), ["a--b-c"]);
    let read = sentences(page);
    assert!(read.iter().any(|sentence| sentence == "Two words"), "{read:?}");
    assert_eq!(unplain("p", page).len(), 1);
    assert_eq!(unplain("p", &"word ".repeat(36)).len(), 1);
    assert_eq!(resolved("docs/a/b.md", "../c.md"), Some("docs/c.md".into()));
}
