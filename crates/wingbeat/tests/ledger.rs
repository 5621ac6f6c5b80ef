//! Tables of pages that the code fills: equations, limits, lift laws. A stale page fails; `cargo xtask reference` writes it again.

use std::fs;
use std::path::{Path, PathBuf};

/// What the doc lines from `Equation: <id>` on say, and the item below them.
struct Equation {
    id: String,
    formula: String,
    source: String,
    test: String,
    item: String,
    place: String,
}

impl Equation {
    /// Name of the item: the word behind `fn`, `struct` or the like.
    fn name(&self) -> Option<&str> {
        let mut words = self.item.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        words.by_ref().find(|word| ["fn", "struct", "enum", "const", "trait", "type"].contains(word))?;
        words.next().filter(|name| !name.is_empty())
    }

    /// Whether it says anything; one that does not is another place of an equation that another item states.
    fn is_stated(&self) -> bool {
        !(self.formula.is_empty() && self.source.is_empty() && self.test.is_empty())
    }

    /// Its row of docs/equations.md.
    fn row(&self) -> String {
        let Self { id, formula, source, test, place, .. } = self;
        format!("| {id} | {formula} | {source} | {place}: `{}` | {test} |", self.name().unwrap_or("?"))
    }
}

/// The text of a doc line.
fn doc<'a>(line: &&'a str) -> Option<&'a str> {
    line.strip_prefix("///").or_else(|| line.strip_prefix("//!")).map(str::trim)
}

/// The equations in the file `place` of the text `text`.
///
/// A block is `Equation: <id>`, the formula between backticks, `Source: ...`, `Test: ...`, up to an empty doc line.
fn equations(place: &str, text: &str) -> Vec<Equation> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let mut found = Vec::new();
    for (number, line) in lines.iter().enumerate() {
        let Some(id) = doc(line).and_then(|doc| doc.strip_prefix("Equation: ")) else { continue };
        let block = lines[number + 1..].iter().map_while(doc).take_while(|doc| !doc.is_empty());
        let block = block.collect::<Vec<_>>().join(" ");
        let (rest, test) = block.split_once("Test: ").unwrap_or((&block, ""));
        let (formula, source) = rest.split_once("Source: ").unwrap_or((rest, ""));
        let below = lines[number..].iter().find(|line| !line.starts_with("//") && !line.starts_with("#["));
        let text = |part: &str| part.trim().trim_end_matches('.').to_owned();
        found.push(Equation {
            id: text(id),
            formula: text(formula),
            source: text(source),
            test: text(test),
            item: below.map_or(String::new(), |item| (*item).into()),
            place: place.to_owned(),
        });
    }
    found
}

/// What equations lack; `tests` holds the names of the test functions.
fn lacks(equations: &[Equation], tests: &[String]) -> Vec<String> {
    let mut found = Vec::new();
    for (index, equation) in equations.iter().enumerate() {
        let Equation { id, formula, source, test, place, .. } = equation;
        let mut others = equations.iter().enumerate().filter(|(i, other)| *i != index && other.id == *id);
        if !equation.is_stated() {
            if !others.any(|(_, other)| other.is_stated()) {
                found.push(format!(
                    "{place}: {id} needs a formula between backticks, `Source: ...` and `Test: ...`"
                ));
            }
            continue;
        }
        if others.any(|(_, other)| other.is_stated()) {
            found.push(format!("{place}: {id} is stated twice"));
        }
        if !(formula.starts_with('`') && formula.ends_with('`') && formula.matches('`').count() == 2) {
            found.push(format!(
                "{place}: {id}: the formula stands between one pair of backticks, not {formula:?}"
            ));
        }
        if source.is_empty() {
            found.push(format!("{place}: {id} has no line `Source: ...`"));
        }
        if [id, formula, source].iter().any(|cell| cell.contains('|')) {
            found.push(format!("{place}: {id} has a `|`, which a table cannot hold"));
        }
        if equation.name().is_none() {
            found.push(format!("{place}: {id} is not above a function, type or constant"));
        }
        if !tests.iter().any(|name| *name == test.trim_matches('`')) {
            found.push(format!("{place}: {id} names the test {test}, which does not exist"));
        }
    }
    found
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

/// The text of a page in docs as the code has it: `fill` changes what is written there. It is written again where that is asked for.
fn is_current(name: &str, fill: impl Fn(&str) -> String) {
    let path = root().join("docs").join(name);
    let page = fs::read_to_string(&path).unwrap_or_default();
    let filled = fill(&page);
    if std::env::var_os("WINGBEAT_WRITE_DOCS").is_some() {
        fs::write(&path, filled).unwrap();
    } else {
        assert!(page == filled, "docs/{name} is stale, run `cargo xtask reference`");
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// `page` with `rows` behind the line `<!-- name -->` and a table's head, up to `<!-- end -->`.
fn with_block(page: &str, name: &str, head: &str, rows: &[String]) -> String {
    let mark = format!("<!-- {name} -->\n");
    let (before, rest) = page.split_once(&mark).unwrap_or_else(|| panic!("no mark {mark}"));
    let (_, after) = rest.split_once("<!-- end -->").unwrap();
    format!("{before}{mark}{head}\n{}\n<!-- end -->{after}", rows.join("\n"))
}

const EQUATIONS: &str = "# Equations and their addresses

Generated by `cargo xtask reference` from the doc lines `Equation: <id>` in the sources: do not edit it here.
Each equation stands above the one function, type or constant that holds it, with its source and the test that checks it.

| id | equation | source | function | test |
|---|---|---|---|---|
";

#[test]
fn the_page_of_equations_is_that_of_the_sources() {
    let (mut stated, mut tested) = (Vec::new(), Vec::new());
    let mut paths = files(&root().join("crates"));
    paths.sort();
    for path in paths {
        let text = fs::read_to_string(&path).unwrap();
        let place = path.strip_prefix(root().join("crates")).unwrap();
        if place.components().any(|part| part.as_os_str() == "src") {
            stated.extend(equations(&place.display().to_string(), &text));
        }
        tested.extend(tests(&text));
    }
    let found = lacks(&stated, &tested);
    assert!(found.is_empty(), "equations of the sources:\n{}", found.join("\n"));
    let mut stated: Vec<&Equation> = stated.iter().filter(|equation| equation.is_stated()).collect();
    assert!(stated.len() > 100);
    stated.sort_by(|a, b| a.id.cmp(&b.id));
    let rows: Vec<String> = stated.into_iter().map(Equation::row).collect();
    is_current("equations.md", |_| [EQUATIONS, &rows.join("\n"), "\n"].concat());
}

#[test]
fn what_an_equation_lacks_is_seen() {
    let code = "    /// Equation: a.b\n    /// `x =\n    /// y`\n    /// Source: Book.\n    /// Test: `it_holds`.\n    ///\n    /// The force.\n    #[inline]\n    pub fn force<S>(&self) {\n";
    let holds = tests("#[test]\nfn it_holds() {\n");
    let seen = |code: &str, tests: &[String]| lacks(&equations("f.rs", code), tests);
    assert!(seen(code, &holds).is_empty());
    assert_eq!(equations("f.rs", code)[0].row(), "| a.b | `x = y` | Book | f.rs: `force` | `it_holds` |");
    assert!(seen(code, &[])[0].contains("does not exist"));
    assert!(seen(&code.replace("Source: Book.", ""), &holds)[0].contains("no line `Source"));
    assert!(seen(&code.replace("`x =", "x ="), &holds)[0].contains("pair of backticks"));
    assert!(seen(&code.replace("pub fn", "pub"), &holds)[0].contains("not above"));
    assert!(seen(&(code.to_owned() + code), &holds)[0].contains("stated twice"));
    assert!(seen("/// Equation: a.b\nfn force() {\n", &holds)[0].contains("needs a formula"));
    assert!(seen(&(code.to_owned() + "/// Equation: a.b\nfn force() {\n"), &holds).is_empty());
}

#[test]
fn the_page_of_commands_on_the_paper_is_the_list_that_the_tests_run() {
    const HEAD: &str = "# The paper: commands\n\nGenerated by `cargo xtask reference` from `validation/paper/commands.txt`: do not edit it here.\n";
    let list = fs::read_to_string(root().join("validation/paper/commands.txt")).unwrap();
    is_current("paper-commands.md", |_| format!("{HEAD}\n```sh\n{}\n```\n", list.trim_end()));
}

#[test]
fn the_page_of_verdicts_lists_every_status_and_limit() {
    use wingbeat::judge::Status;
    use wingbeat::judge::limits::{self, Sense};
    let statuses: Vec<String> = Status::ALL
        .iter()
        .map(|status| format!("| `{status}` | {} | {} |", status.meaning(), status.exit_code()))
        .collect();
    let mut kinds: Vec<(&str, Vec<String>)> = Vec::new();
    for limit in limits::all() {
        let side = if limit.sense == Sense::AtMost { "at most" } else { "at least" };
        let unit = if limit.unit.is_empty() { String::new() } else { format!(" {}", limit.unit) };
        let status = limit.status.map_or("warning", Status::name);
        let size = limit.value.abs();
        let powers = size > 0.0 && !(1e-3..1e5).contains(&size);
        let value = if powers { format!("{:e}", limit.value) } else { limit.value.to_string() };
        let allowed = format!("{side} {value}{unit}");
        let allowed =
            if limit.value.is_finite() { allowed } else { format!("{side} what `[limits]` gives; else off") };
        let row =
            format!("| `{}` | {} | {allowed} | {status} |", limit.id, limit.meaning.trim_end_matches(','));
        let kind = limit.id.split('.').next().unwrap();
        match kinds.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, rows)) => rows.push(row),
            None => kinds.push((kind, vec![row])),
        }
    }
    let head = "| limit | what is judged | allowed | if missed |\n|---|---|---|---|";
    is_current("verdicts.md", |page| {
        let page =
            with_block(page, "statuses", "| `status` | meaning | exit code |\n|---|---|---:|", &statuses);
        kinds
            .iter()
            .fold(page, |page, (kind, rows)| with_block(&page, &format!("limits of {kind}"), head, rows))
    });
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
    const HEADS: [(&str, &str); 2] = [
        ("laws", "| law | what it says | asks of the section | states per strip |\n|---|---|---|---|"),
        (
            "parameters",
            "| parameter | unit | default | meaning | source of the default |\n|---|---|---:|---|---|",
        ),
    ];
    is_current("sections.md", |page| {
        HEADS
            .iter()
            .zip(section_tables())
            .fold(page.to_owned(), |page, ((mark, head), rows)| with_block(&page, mark, head, &rows))
    });
}
