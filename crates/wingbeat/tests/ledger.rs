//! docs/equations.md and the doc lines `Equation: <id>` match both ways.

use std::fs;
use std::path::{Path, PathBuf};

/// A row of docs/equations.md.
struct Entry {
    id: String,
    function: String,
    test: String,
}

/// A doc line `Equation: <id>` with the item below it.
struct Address {
    id: String,
    item: String,
    place: String,
}

/// The rows of the table `| id | equation | source | function | test |`.
fn entries(ledger: &str) -> Vec<Entry> {
    let cells = |line: &str| -> Vec<String> {
        line.trim()
            .trim_matches('|')
            .split('|')
            .map(|cell| cell.trim().trim_matches('`').to_owned())
            .collect()
    };
    let rows = ledger.lines().filter(|line| line.starts_with('|')).map(cells).skip(2);
    rows.map(|row| match <[String; 5]>::try_from(row) {
        Ok([id, _, _, function, test]) => Entry { id, function, test },
        Err(row) => panic!("docs/equations.md: a row has five cells, not {}: {row:?}", row.len()),
    })
    .collect()
}

/// The addresses in `text`; the item is the first line below that is neither doc nor attribute.
fn addresses(place: &str, text: &str) -> Vec<Address> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let mut found = Vec::new();
    for (number, line) in lines.iter().enumerate() {
        let doc = line.strip_prefix("///").or_else(|| line.strip_prefix("//!"));
        let Some(id) = doc.and_then(|doc| doc.trim().strip_prefix("Equation: ")) else { continue };
        let below = lines[number..].iter().find(|line| !line.starts_with("//") && !line.starts_with("#["));
        found.push(Address {
            id: id.trim().trim_end_matches('.').into(),
            item: below.map_or(String::new(), |item| (*item).into()),
            place: format!("{place}:{}", number + 1),
        });
    }
    found
}

/// Where ledger, addresses and tests disagree; `tests` holds the names of the test functions.
fn disagreements(entries: &[Entry], addresses: &[Address], tests: &[String]) -> Vec<String> {
    let mut found = Vec::new();
    for (index, entry) in entries.iter().enumerate() {
        let Entry { id, function, test } = entry;
        if entries[..index].iter().any(|earlier| earlier.id == *id) {
            found.push(format!("docs/equations.md: {id} has two rows"));
        }
        let name = function.rsplit("::").next().unwrap_or(function);
        let mut of_id = addresses.iter().filter(|address| address.id == *id).peekable();
        if of_id.peek().is_none() {
            found.push(format!("docs/equations.md: no function has the doc line `Equation: {id}`"));
        } else if !of_id.any(|address| defines(&address.item, name)) {
            found.push(format!("docs/equations.md: {id} names {function}, which is not below its doc line"));
        }
        let test = test.rsplit("::").next().unwrap_or(test);
        if !tests.iter().any(|name| name == test) {
            found.push(format!("docs/equations.md: {id} names the test {test}, which does not exist"));
        }
    }
    for Address { id, place, .. } in addresses {
        if !entries.iter().any(|entry| entry.id == *id) {
            found.push(format!("{place}: {id} has no row in docs/equations.md"));
        }
    }
    found
}

/// True when the line `item` defines a function, type or constant called `name`.
fn defines(item: &str, name: &str) -> bool {
    let mut words = item.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    let keyword =
        words.by_ref().find(|word| ["fn", "struct", "enum", "const", "trait", "impl", "mod"].contains(word));
    keyword.is_some() && words.any(|word| word == name)
}

/// Names of the functions below `#[test]`, also inside macros that write such functions.
fn tests(text: &str) -> Vec<String> {
    let name = |line: &str| -> Option<String> {
        let rest = line.trim().trim_start_matches("pub ").strip_prefix("fn ")?;
        Some(rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next()?.into())
    };
    let lines: Vec<&str> = text.lines().collect();
    let marked = (0..lines.len()).filter(|&at| lines[at].trim() == "#[test]");
    marked.filter_map(|at| lines[at + 1..].iter().find_map(|line| name(line))).collect()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let all = entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] });
    all.filter(|path| path.extension().is_some_and(|extension| extension == "rs")).collect()
}

#[test]
fn every_equation_has_one_address_and_a_test() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
    let entries = entries(&fs::read_to_string(root.join("docs/equations.md")).unwrap());
    assert!(entries.len() > 10);
    let (mut known, mut checked) = (Vec::new(), Vec::new());
    for path in files(&root.join("crates")) {
        let text = fs::read_to_string(&path).unwrap();
        let place = path.strip_prefix(&root).unwrap();
        if place.components().any(|part| part.as_os_str() == "src") {
            known.extend(addresses(&place.display().to_string(), &text));
        }
        checked.extend(tests(&text));
    }
    let found = disagreements(&entries, &known, &checked);
    assert!(found.is_empty(), "the ledger does not match:\n{}", found.join("\n"));
}

#[test]
fn a_disagreement_is_seen() {
    let ledger = "| id | equation | source | function | test |\n|---|---|---|---|---|\n\
                  | a.b | x = y | Book | `Thing::force` | `it_holds` |\n";
    let code =
        "    /// Equation: a.b\n    ///\n    /// The force.\n    #[inline]\n    pub fn force<S>(&self) {\n";
    let holds = tests("#[test]\nfn it_holds() {\n");
    let seen = |ledger: &str, code: &str, tests: &[String]| {
        disagreements(&entries(ledger), &addresses("f.rs", code), tests)
    };
    assert!(seen(ledger, code, &holds).is_empty());
    assert!(seen(ledger, code, &[])[0].contains("does not exist"));
    assert!(seen(ledger, "", &holds)[0].contains("no function"));
    assert!(seen(ledger, &code.replace("force<", "lift<"), &holds)[0].contains("not below"));
    let other = code.replace("a.b", "a.c");
    assert!(seen(ledger, &(code.to_owned() + &other), &holds)[0].contains("f.rs:6: a.c has no row"));
    assert!(
        seen(&(ledger.to_owned() + ledger.lines().last().unwrap()), code, &holds)[0].contains("two rows")
    );
}

/// Rows of the tables of laws and of their parameters.
fn section_tables() -> [Vec<String>; 2] {
    use wingbeat::aero::LiftLaw;
    let names = |names: Vec<String>| if names.is_empty() { "-".to_owned() } else { names.join(", ") };
    let or_dash = |unit: &str| if unit.is_empty() { "-".to_owned() } else { unit.to_owned() };
    let (mut laws, mut parameters) = (Vec::new(), Vec::new());
    for law in LiftLaw::ALL {
        let about = law.about();
        let asked = names(about.parameters.iter().map(|p| format!("`{}`", p.key)).collect());
        let states = names(about.states.iter().map(|s| format!("`{}`", s.name)).collect());
        laws.push(format!("| `{}` | {} | {asked} | {states} |", about.name, about.meaning));
        for p in about.parameters {
            let (unit, default) = (or_dash(p.unit), p.default);
            parameters.push(format!("| `{}` | {unit} | {default} | {} | {} |", p.key, p.meaning, p.source));
        }
    }
    // As the laws that ask most name them.
    parameters.sort_by_key(|row| {
        let of_lev = LiftLaw::Lev.about().parameters.iter();
        of_lev.map(|p| format!("| `{}` |", p.key)).position(|key| row.starts_with(&key)).unwrap_or(usize::MAX)
    });
    parameters.dedup();
    [laws, parameters]
}

#[test]
fn the_page_of_sections_lists_what_the_laws_declare() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/sections.md");
    let page = fs::read_to_string(&path).unwrap();
    let mut written = page.clone();
    for (rows, head) in section_tables().iter().zip(["| law |", "| parameter |"]) {
        let begin = written.find(head).unwrap();
        let body = begin + written[begin..].match_indices('\n').nth(1).unwrap().0 + 1;
        let end = body + written[body..].find("\n\n").unwrap();
        written.replace_range(body..end, &rows.join("\n"));
    }
    if std::env::var_os("WINGBEAT_WRITE_DOCS").is_some() {
        fs::write(&path, &written).unwrap();
    } else {
        assert_eq!(page, written, "docs/sections.md is stale, run `cargo xtask docs`");
    }
}
