//! Public items of a source, read by its lines as rustfmt lays them out: an item begins on a line of its own, and the line `}` at its
//! indentation ends it.

use std::collections::BTreeSet;
use std::fmt::{self, Display};

/// A public item that may hold numbers.
pub struct Item {
    path: String,
    line: usize,
    pub name: String,
    pub doc: String,
    /// Type and file in which it stands.
    owners: [String; 2],
    pub is_field: bool,
    /// Of a function its parameters with their types; else nothing.
    takes: Vec<(String, String)>,
    /// Its type, or what the function gives.
    gives: String,
    /// Whether that is a number that its name does not settle.
    pub gives_number: bool,
    /// Letters that stand for a number type.
    generic: BTreeSet<String>,
    pub is_rotation: bool,
    /// What has no docs is no part of the library's interface, or `missing_docs` would refuse it.
    is_documented: bool,
}

/// Types that are numbers, or are made of numbers alone. A quaternion of the library has length 1 and is none.
const NUMBERS: [&str; 21] = [
    "f64", "f32", "Vec3", "Mat3", "Wrench", "Jet", "Dual", "Varying", "Traced", "DMatrix", "DVector",
    "SMatrix", "SVector", "Vector2", "Vector3", "Vector6", "Matrix2", "Matrix3", "Matrix6", "Complex",
    "f64x4",
];
/// Types that hold what their arguments are; the arguments of others are theirs to document.
const HOLDS: [&str; 17] = [
    "Vec",
    "Option",
    "Result",
    "Box",
    "Arc",
    "Rc",
    "Cow",
    "BTreeMap",
    "HashMap",
    "ArrayVec",
    "Iterator",
    "IntoIterator",
    "ExactSizeIterator",
    "DoubleEndedIterator",
    "Range",
    "RangeInclusive",
    "AsRef",
];
/// Traits of number types.
const SCALARS: [&str; 5] = ["Scalar", "Over", "Lanes", "CycleScalar", "Real"];

/// Names of a text in turn, each with the rest of the text behind it.
fn names(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut rest = text;
    std::iter::from_fn(move || {
        let start = rest.find(is_name)?;
        let end = rest[start..].find(|c| !is_name(c)).map_or(rest.len(), |end| start + end);
        let name = &rest[start..end];
        rest = &rest[end..];
        Some((name, rest))
    })
}

/// Length of what the bracket that opens `text` encloses, with it.
fn enclosed(text: &str) -> usize {
    let mut depth = 0;
    let mut before = ' ';
    for (i, c) in text.char_indices() {
        match c {
            '<' | '(' | '[' | '{' => depth += 1,
            '>' if before == '-' || before == '=' => {}
            '>' | ')' | ']' | '}' => depth -= 1,
            _ => {}
        }
        before = c;
        if depth == 0 {
            return i + 1;
        }
    }
    text.len()
}

/// `text` without what stands in the brackets of types that document it themselves.
fn plain(text: &str) -> String {
    let mut kept = String::new();
    let mut rest = text;
    while let Some(open) = rest.find('<') {
        let of = rest[..open].rsplit(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default();
        let open_is_kept = of.is_empty() || NUMBERS.contains(&of) || HOLDS.contains(&of);
        let skipped = if open_is_kept { 1 } else { enclosed(&rest[open..]) };
        kept += &rest[..open];
        kept.push(' ');
        rest = &rest[open + skipped..];
    }
    kept + rest
}

/// The parts of a list between commas that no bracket encloses.
fn listed(text: &str) -> Vec<&str> {
    let (mut parts, mut start, mut depth, mut before) = (Vec::new(), 0, 0, ' ');
    for (i, c) in text.char_indices() {
        match c {
            '<' | '(' | '[' | '{' => depth += 1,
            '>' if before == '-' || before == '=' => {}
            '>' | ')' | ']' | '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&text[start..i]);
                start = i + 1;
            }
            _ => {}
        }
        before = c;
    }
    parts.push(&text[start..]);
    parts
}

/// The first of `lines` as one, up to that which ends with one of `ends`, and how many they are.
fn joined(lines: &[&str], ends: &[char]) -> (String, usize) {
    let mut all = String::new();
    for (i, line) in lines.iter().enumerate() {
        all.push_str(line.split(" // ").next().unwrap_or_default().trim());
        all.push(' ');
        if all.trim_end().ends_with(ends) {
            return (all, i + 1);
        }
    }
    (all, lines.len())
}

/// Letters that a head, `impl<S: Scalar> A<S>` or `fn f<T: Over<S>>(...)`, bounds by a number trait.
fn scalars(head: &str) -> BTreeSet<String> {
    let is_bound = |rest: &str| {
        let bound = rest.strip_prefix(": ").unwrap_or_default();
        names(bound).next().is_some_and(|(name, _)| SCALARS.contains(&name))
    };
    names(head)
        .filter(|(name, rest)| name.len() == 1 && is_bound(rest))
        .map(|(name, _)| name.to_owned())
        .collect()
}

impl Item {
    /// Where it stands: items of one type of one file follow each other.
    pub fn place(&self) -> &str {
        &self.owners[0]
    }

    /// What may speak for it: its type, its file, and the modules above in files of their own, all but the crate.
    pub fn owners(&self) -> Vec<String> {
        let mut all = self.owners.to_vec();
        let mut folder = self.path.as_str();
        while let Some((above, _)) = folder.rsplit_once('/').filter(|(above, _)| !above.ends_with("src")) {
            all.extend([format!("{above}/mod.rs"), format!("{above}.rs")]);
            folder = above;
        }
        all
    }

    fn holds(&self, kind: &str, aliases: &BTreeSet<String>) -> bool {
        let alias =
            |name: &str| aliases.contains(name) || aliases.contains(&format!("{}::{name}", self.path));
        let is_number = |name: &str| NUMBERS.contains(&name) || self.generic.contains(name) || alias(name);
        names(&plain(kind)).any(|(name, _)| is_number(name))
    }

    /// Itself, where a number of it is not named by what `named` knows. The time `t`, the state `x` with its rates `dx` and the inputs `u`
    /// are those of `Plant`, which says their units.
    pub fn in_need(self, aliases: &BTreeSet<String>, named: &dyn Fn(&str) -> bool) -> Option<Self> {
        let convention = |name: &str, kind: &str| match name {
            "t" => true,
            "x" | "u" | "dx" => kind.contains('['),
            _ => false,
        };
        let takes = |(name, kind): &(String, String)| {
            !convention(name, kind) && !named(name) && self.holds(kind, aliases)
        };
        let gives_number = self.holds(&self.gives, aliases) && !named(self.name.trim_end_matches("()"));
        let in_need = self.is_documented && (gives_number || self.takes.iter().any(takes));
        in_need.then_some(Self { gives_number, ..self })
    }
}

impl Display for Item {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}:{}: {} {}", self.path, self.line, self.name, self.doc.trim())
    }
}

/// What a file has.
#[derive(Default)]
pub struct Source {
    pub items: Vec<Item>,
    /// Types, and the file itself by its path, with their docs.
    pub types: Vec<(String, String)>,
    /// Other names of number types where their docs name no unit, those that only this file knows behind its path.
    pub aliases: Vec<String>,
}

/// What encloses a line.
struct Scope {
    indent: usize,
    kind: Kind,
    name: String,
    head: String,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Its fields and functions count where they are `pub`.
    Open,
    /// A public trait, or a variant of a public enum: all in it counts.
    Public,
    Enum,
    Hidden,
}

impl Source {
    /// Reads the text of the file at `path`.
    pub fn read(path: &str, text: &str) -> Self {
        let mut reader = Reader {
            path,
            source: Self::default(),
            scopes: Vec::new(),
            doc: String::new(),
            part: Part::Prose,
            is_documented: false,
            of_tests: false,
        };
        let lines: Vec<&str> = text.lines().collect();
        let heading: Vec<&str> = lines.iter().filter_map(|line| line.strip_prefix("//!")).collect();
        reader.source.types.push((path.to_owned(), heading.join(" ")));
        let mut at = 0;
        while at < lines.len() {
            at += reader.line(&lines, at);
        }
        reader.source
    }
}

struct Reader<'a> {
    path: &'a str,
    source: Source,
    scopes: Vec<Scope>,
    doc: String,
    part: Part,
    /// Whether a doc comment precedes the line at hand.
    is_documented: bool,
    of_tests: bool,
}

/// Parts of a doc comment.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Prose,
    Equation,
    Example,
    Section,
}

impl Reader<'_> {
    /// Reads what begins at line `at`, and says how many lines it took.
    fn line(&mut self, lines: &[&str], at: usize) -> usize {
        let text = lines[at].trim_start();
        let indent = lines[at].len() - text.len();
        if let Some(doc) = text.strip_prefix("///") {
            self.doc_line(doc);
            return 1;
        }
        if text.starts_with("#[") {
            self.of_tests |= text.starts_with("#[cfg(test)]");
            let end = lines[at..].iter().position(|line| line.trim_end().ends_with(']'));
            return end.map_or(1, |end| end + 1);
        }
        if text.is_empty() || text.starts_with("//") {
            return 1;
        }
        if text.starts_with('}') {
            self.scopes.retain(|scope| scope.indent < indent);
        }
        let taken = match self.inside() == Kind::Hidden {
            true => 1,
            false => self.item(lines, at, text, indent),
        };
        self.doc.clear();
        (self.part, self.is_documented, self.of_tests) = (Part::Prose, false, false);
        taken
    }

    /// Keeps a line of a doc comment, unless it is of an equation with its source, of an example or of a section "Errors".
    fn doc_line(&mut self, line: &str) {
        let text = line.trim_start();
        self.part = match self.part {
            Part::Prose if text.starts_with("Equation:") => Part::Equation,
            Part::Prose if text.starts_with("# ") => Part::Section,
            Part::Prose if text.starts_with("```") => Part::Example,
            Part::Example if text.starts_with("```") => Part::Prose,
            part => part,
        };
        match self.part {
            Part::Prose if text != "```" => self.doc += &format!("{line} "),
            Part::Equation if text.starts_with("Test:") => self.part = Part::Prose,
            _ => {}
        }
        self.is_documented = true;
    }

    fn inside(&self) -> Kind {
        let hidden = self.scopes.iter().any(|scope| scope.kind == Kind::Hidden);
        if hidden { Kind::Hidden } else { self.scopes.last().map_or(Kind::Open, |scope| scope.kind) }
    }

    fn item(&mut self, lines: &[&str], at: usize, text: &str, indent: usize) -> usize {
        let is_public = text.starts_with("pub ") || self.inside() == Kind::Public;
        let bare = text.strip_prefix("pub ").unwrap_or(text);
        let bare = bare.strip_prefix("const fn").map_or(bare, |_| &bare[6..]);
        let word = names(bare).next().map_or("", |(word, _)| word);
        let head = |ends: &[char]| joined(&lines[at..], ends);
        match word {
            "struct" | "enum" | "trait" | "impl" | "mod" | "union" => {
                let (head, taken) = head(&['{', ';', '}']);
                self.enclosing(word, &head, indent, is_public, at);
                taken
            }
            "fn" | "unsafe" | "async" => {
                let (head, taken) = head(&['{', ';', '}']);
                if head.trim_end().ends_with('{') {
                    let (name, head) = (String::new(), String::new());
                    self.scopes.push(Scope { indent, kind: Kind::Hidden, name, head });
                }
                if is_public {
                    self.function(head.trim_start_matches("pub "), at);
                }
                taken
            }
            "type" if is_public || text.starts_with("type ") => {
                let (head, taken) = head(&[';']);
                self.alias(&head);
                taken
            }
            "const" | "static" if is_public => {
                let (head, taken) = head(&['=', ';', ',', '[', '(', '{']);
                let head = &head[head.find(word).unwrap_or(0) + word.len()..];
                let kind = head.split(" = ").next().unwrap_or(head).trim_end_matches([';', '=', ' ']);
                self.value(kind, at, false);
                taken
            }
            _ if self.inside() == Kind::Enum => self.variant(&head(&[',', '{']), word, indent, at),
            _ if is_public && self.scopes.last().is_some() && bare[word.len()..].starts_with(':') => {
                let (head, taken) = head(&[',']);
                self.value(head.trim_start_matches("pub "), at, true);
                taken
            }
            _ => 1,
        }
    }

    /// A type, a trait, a module or the functions of a type.
    fn enclosing(&mut self, word: &str, head: &str, indent: usize, is_public: bool, at: usize) {
        let rest = &head[head.find(word).unwrap_or(0) + word.len()..];
        let rest = if rest.starts_with('<') { &rest[enclosed(rest)..] } else { rest };
        let of = rest.split(" for ").last().unwrap_or(rest);
        let of = if word == "impl" { of.split(['<', '{']).next().unwrap_or(of) } else { of };
        let path = names(of).map(|(name, _)| name);
        let name = if word == "impl" { path.last() } else { { path }.next() }.unwrap_or_default().to_owned();
        let kind = match word {
            "mod" if self.of_tests => Kind::Hidden,
            "impl" if rest.contains(" for ") => Kind::Hidden,
            "impl" | "mod" => Kind::Open,
            _ if !is_public => Kind::Hidden,
            "enum" => Kind::Enum,
            "trait" => Kind::Public,
            _ => Kind::Open,
        };
        if word != "impl" {
            self.source.types.push((name.clone(), self.doc.clone()));
        }
        let tuple = rest.split('{').next().and_then(|start| start.find('(').map(|open| &start[open..]));
        if let (Some(fields), true, "struct") = (tuple, is_public, word) {
            let public = fields
                .trim_matches(['(', ')', ';', ' '])
                .split(", ")
                .filter_map(|field| field.strip_prefix("pub "));
            let public: Vec<&str> = public.collect();
            self.scopes.push(Scope { indent, kind, name: name.clone(), head: head.to_owned() });
            self.push(name.clone(), Vec::new(), public.join(", "), at, true);
            self.scopes.pop();
        }
        if head.trim_end().ends_with('{') {
            self.scopes.push(Scope { indent, kind, name, head: head.to_owned() });
        }
    }

    fn variant(&mut self, (head, taken): &(String, usize), word: &str, indent: usize, at: usize) -> usize {
        let head = head.trim();
        if head.ends_with('{') {
            let name = self.scopes.last().map(|scope| scope.name.clone()).unwrap_or_default();
            self.scopes.push(Scope { indent, kind: Kind::Public, name, head: head.to_owned() });
        } else if head[word.len()..].starts_with('(') {
            self.push(word.to_owned(), Vec::new(), head[word.len()..].to_owned(), at, true);
        }
        *taken
    }

    fn alias(&mut self, head: &str) {
        let Some((name, kind)) = head.split_once(" = ") else { return };
        let name = names(name).map(|(name, _)| name).find(|name| !matches!(*name, "pub" | "type"));
        let is_number = names(&plain(kind)).any(|(name, _)| NUMBERS.contains(&name));
        if let (Some(name), true) = (name, is_number && !super::Doc::read(&self.doc).names_unit()) {
            let of_file = !head.starts_with("pub ");
            self.source.aliases.push(if of_file {
                format!("{}::{name}", self.path)
            } else {
                name.to_owned()
            });
        }
    }

    /// A constant or a field, `name: kind`.
    fn value(&mut self, text: &str, at: usize, is_field: bool) {
        let Some((name, kind)) = text.split_once(':') else { return };
        self.push(
            name.trim().to_owned(),
            Vec::new(),
            kind.trim_end_matches([',', ' ']).to_owned(),
            at,
            is_field,
        );
    }

    fn function(&mut self, head: &str, at: usize) {
        let after = &head[head.find("fn ").unwrap_or(0) + 3..];
        let name = names(after).next().map_or("", |(name, _)| name);
        let rest = &after[name.len()..];
        let bounds = if rest.starts_with('<') { enclosed(rest) } else { 0 };
        let (generic, rest) = rest.split_at(bounds);
        let (inside, behind) = rest.split_at(enclosed(rest));
        let takes = listed(inside.trim_matches(['(', ')', ' ']).trim_end_matches(','));
        let takes = takes.into_iter().filter_map(|text| text.split_once(':'));
        let takes =
            takes.map(|(name, kind)| (name.trim().trim_start_matches("mut ").to_owned(), kind.to_owned()));
        let gives = behind.split(" where ").next().unwrap_or(behind);
        let gives = gives.split('{').next().unwrap_or(gives).to_owned();
        let scope = Scope {
            indent: usize::MAX,
            kind: Kind::Open,
            name: String::new(),
            head: format!("{generic} {behind}"),
        };
        self.scopes.push(scope);
        self.push(format!("{name}()"), takes.collect(), gives, at, false);
        self.scopes.pop();
    }

    fn push(&mut self, name: String, takes: Vec<(String, String)>, gives: String, at: usize, is_field: bool) {
        let generic = self.scopes.iter().flat_map(|scope| scalars(&scope.head)).collect();
        let owner = self.scopes.iter().rev().find(|scope| !scope.name.is_empty());
        let owner = owner.map(|scope| scope.name.clone()).unwrap_or_else(|| self.path.to_owned());
        let is_rotation = gives.contains("Mat3");
        let owners = [owner, self.path.to_owned()];
        self.source.items.push(Item {
            path: self.path.to_owned(),
            line: at + 1,
            name,
            doc: self.doc.clone(),
            is_documented: self.is_documented,
            owners,
            is_field,
            takes,
            gives,
            gives_number: false,
            generic,
            is_rotation,
        });
    }
}
