//! Every public number of the libraries names its unit: in its docs, or in its own name by the ends of keys that documents know.

mod source;
mod words;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use source::{Item, Source};
use wingbeat::scenario::unit;
use words::Doc;

/// What a name that ends a path says: the table of the documents knows `_m`, `_deg`, `_hz`.
fn named(name: &str) -> bool {
    !unit(&name.to_lowercase()).is_empty()
}

/// All sources of one crate, because items refer to one another by name.
struct Library {
    items: Vec<(Item, Doc)>,
    /// Names of items and types whose docs or names settle their unit.
    settled: BTreeSet<String>,
    /// Types and files that speak for all that is in them, and types that speak for their fields.
    speakers: BTreeSet<String>,
    of_fields: BTreeSet<String>,
}

impl Library {
    fn new(files: &[(String, String)]) -> Self {
        let sources: Vec<Source> = files.iter().map(|(path, text)| Source::read(path, text)).collect();
        let types = sources.iter().flat_map(|source| &source.types);
        let types: Vec<(&String, Doc)> = types.map(|(name, doc)| (name, Doc::read(doc))).collect();
        let which = |is: &dyn Fn(&Doc) -> bool| {
            types
                .iter()
                .filter(|(_, doc)| is(doc))
                .map(|(name, _)| (*name).clone())
                .collect::<BTreeSet<String>>()
        };
        let (speakers, of_fields) = (which(&Doc::speaks_for_all), which(&Doc::settles_fields));
        let settled = which(&Doc::names_unit);
        let aliases: BTreeSet<String> =
            sources.iter().flat_map(|source| source.aliases.iter().cloned()).collect();
        let all = sources.into_iter().flat_map(|source| source.items);
        let items = all.filter_map(|item| item.in_need(&aliases, &named));
        let items = items.map(|item| {
            let doc = Doc::read(&item.doc);
            (item, doc)
        });
        Self { items: items.collect(), settled, speakers, of_fields }
    }

    /// Whether an item says its unit, given the names that are settled; `before` tells whether the item before it did.
    fn says(&self, (item, doc): &(Item, Doc), before: bool) -> bool {
        item.owners().iter().any(|owner| self.speakers.contains(owner))
            || (item.is_field && self.of_fields.contains(item.place()))
            || (if item.gives_number && !item.is_field {
                doc.names_unit_of_result()
            } else {
                doc.names_unit()
            })
            || (item.is_rotation && doc.says_rotation())
            || (doc.continues() && before)
            || doc.references.iter().any(|name| named(name) || self.settled.contains(name))
    }

    /// Those that name no unit. A reference counts once what it leads to is settled, so the walk repeats until nothing is added.
    fn silent(mut self) -> Vec<String> {
        loop {
            let known = self.settled.len();
            let mut silent = Vec::new();
            let mut last: Option<(&str, bool)> = None;
            let mut found = BTreeSet::new();
            for pair in &self.items {
                let place = pair.0.place();
                let before = last.is_some_and(|(other, said)| said && place == other);
                let says = self.says(pair, before);
                last = Some((place, says));
                match says {
                    true => _ = found.insert(pair.0.name.clone()),
                    false => silent.push(pair.0.to_string()),
                }
            }
            self.settled.extend(found);
            if self.settled.len() == known {
                return silent;
            }
        }
    }
}

#[test]
fn every_public_number_names_its_unit() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut libraries: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    for folder in fs::read_dir(&crates).unwrap().map(|entry| entry.unwrap().path()) {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        let sources = super::files(&folder.join("src"));
        for path in
            sources.iter().filter(|path| path.extension().is_some_and(|end| end == "rs") && name != "xtask")
        {
            let short = format!("{name}/{}", path.strip_prefix(&folder).unwrap().display());
            libraries.entry(name.clone()).or_default().push((short, fs::read_to_string(path).unwrap()));
        }
    }
    libraries.values_mut().for_each(|files| files.sort());
    let libraries: Vec<Library> = libraries.values().map(|files| Library::new(files)).collect();
    let read: usize = libraries.iter().map(|library| library.items.len()).sum();
    assert!(read > 2000, "only {read} public numbers were read");
    let silent: Vec<String> = libraries.into_iter().flat_map(Library::silent).collect();
    assert!(silent.is_empty(), "{} public numbers name no unit:\n{}", silent.len(), silent.join("\n"));
}

/// What a source of one file leaves without a unit, by name.
fn silent(text: &str) -> Vec<String> {
    let all = Library::new(&[("a.rs".to_owned(), text.to_owned())]).silent();
    all.iter().map(|line| line.split(' ').nth(1).unwrap().to_owned()).collect()
}

#[test]
fn a_number_without_a_unit_is_seen() {
    let field = |doc: &str, name: &str, kind: &str| {
        silent(&format!("/// A thing.\npub struct A {{\n    /// {doc}\n    pub {name}: {kind},\n}}\n"))
            .is_empty()
    };
    let scalar = |doc: &str| field(doc, "a", "f64");
    for doc in [
        "Length, m.",
        "Length in m.",
        "Speed (m/s).",
        "Rate of strain, N s/m.",
        "Turned by `a` rad.",
        "Time, seconds.",
        "Share of the range.",
        "Roll error, per rad.",
        "rad, positive right wing down.",
        "Limit, in `unit`.",
        "Rise over the chord.",
        "Gain, in the unit of `b`.",
        "Time, cycles.",
        "Cycles that it takes.",
        "Slope, 1/rad.",
        "Forces, N, and moments, N m.",
        "Power, W.",
        "Factor on the mass.",
    ] {
        assert!(scalar(doc), "{doc}");
    }
    for doc in [
        "Length.",
        "A number.",
        "Factor.",
        "The rate per step.",
        "A force.",
        "Velocity in W.",
        "Largest in the first 2 s.",
        "The link's place.",
        "A - B.",
        "Degrees of freedom.",
        "Mean over the run.",
        "Length of two cycles.",
        "Unit.",
        "The same as before.",
        "In the middle.",
        "As `b`.",
        "`x_m` in code.",
        "Numbers of the robot.",
    ] {
        assert!(!scalar(doc), "{doc}");
    }
    assert!(field("Length.", "length_m", "Option<Vec<f64>>") && field("Count.", "a", "usize"));
    assert!(field("Of others.", "a", "Loads<f64>") && !field("Of all.", "a", "Vec<(String, f64)>"));
    assert!(
        field("Force, N, and moment, N m, in B.", "a", "Wrench<f64>")
            && !field("Drag, in B.", "a", "Wrench<f64>")
    );
    assert!(field("Rotation from B to W.", "a", "Mat3") && !field("Inertia.", "a", "Mat3"));
}

#[test]
fn a_function_says_what_it_takes_and_gives() {
    let function = |doc: &str, head: &str| {
        silent(&format!("impl A {{\n    /// {doc}\n    pub fn {head} {{\n        b\n    }}\n}}\n"))
    };
    assert!(function("Length, m.", "length(&self) -> f64").is_empty());
    assert_eq!(function("Length.", "length(&self) -> f64"), ["length()"]);
    assert_eq!(function("Sets it.", "set(&mut self, angle: f64)"), ["set()"]);
    assert!(function("Sets it.", "set(&mut self, angle_deg: f64)").is_empty());
    assert!(function("Sets it to `angle` rad.", "set(&mut self, angle: f64)").is_empty());
    assert_eq!(function("Place at `angle` rad.", "of(&self, angle: f64) -> Vec3"), ["of()"]);
    assert_eq!(
        function("Place at the share `a` and `b` (rad, B).", "of(&self, a: f64, b: f64) -> Vec3"),
        ["of()"]
    );
    assert!(function("Place, m, at `angle` rad.", "of(&self, angle: f64) -> Vec3").is_empty());
    assert_eq!(
        function("Place.\n    ///\n    /// # Errors\n    /// Beyond a limit, m.", "of(&self) -> f64"),
        ["of()"]
    );
    assert_eq!(
        function(
            "Place.\n    ///\n    /// Equation: a.b\n    /// `a`\n    /// Source: A, J. B.\n    /// Test: `c`.",
            "of(&self) -> f64"
        ),
        ["of()"]
    );
    assert!(function("Power.", "power_w(&self) -> f64").is_empty());
    assert!(function("Names it.", "of(&self, t: f64, x: &[f64], u: &[f64]) -> String").is_empty());
    assert_eq!(function("Place.", "of(&self, t: f64) -> Vec3"), ["of()"]);
    assert_eq!(function("Place.", "of<S: Scalar>(&self) -> S"), ["of()"]);
    assert!(function("Air.", "of<S: Clone>(&self) -> S").is_empty());
    assert_eq!(silent("/// T.\npub trait T {\n    /// Mass.\n    fn mass(&self) -> f64;\n}\n"), ["mass()"]);
    assert!(silent("trait T {\n    /// Mass.\n    fn mass(&self) -> f64;\n}\n").is_empty());
}

#[test]
fn a_unit_is_found_where_docs_lead() {
    let two = |first: &str, second: &str, of: &str| {
        silent(&format!(
            "/// {of}\npub struct A {{\n    /// {first}\n    pub a: f64,\n    /// {second}\n    pub b: f64,\n}}\n"
        ))
    };
    assert!(two("Length, m.", "As [`a`](Self::a), mirrored.", "A thing.").is_empty());
    assert!(two("As [`b`](Self::b), mirrored.", "Length, m.", "A thing.").is_empty());
    assert!(
        two("Length, m.", "As `a`.", "A thing.").is_empty()
            && two("Length, m.", "The same behind.", "A thing.").is_empty()
    );
    assert_eq!(two("Length.", "As [`a`](Self::a).", "A thing."), ["a", "b"]);
    assert_eq!(two("As [`b`](Self::b).", "As [`a`](Self::a).", "A thing."), ["a", "b"]);
    assert!(two("As [`a_m`](B::a_m).", "Length, m.", "A thing.").is_empty());
    assert!(two("Before.", "Behind.", "Lengths in m.").is_empty());
    assert_eq!(two("Before.", "Behind.", "A wing of some lengths, cut in pieces."), ["a", "b"]);
    assert!(two("Of motion.", "Of strain.", "Energies of a beam, J.").is_empty());
    assert!(two("Before.", "Behind.", "A line. Its numbers are in the caller's units.").is_empty());
    let module = |line: &str| {
        silent(&format!("{line}\n\n/// Least.\npub fn least(a: &[f64]) -> f64 {{\n    0.0\n}}\n"))
    };
    assert!(module("//! Sums, in the caller's units.").is_empty());
    assert!(module("//! Sums. Items are in the units of their list.").is_empty());
    assert_eq!(module("//! Sums, in m."), ["least()"]);
    assert_eq!(
        silent("/// Weight.\npub const A: f64 = 1.0;\n/// Lift coefficient.\npub const B: f64 = 1.0;\n"),
        ["A"]
    );
    assert!(
        silent("#[cfg(test)]\nmod tests {\n    /// Length.\n    pub const A: f64 = 1.0;\n}\n").is_empty()
    );
}
