//! What the sources of the libraries keep to. A module uses only what stands below it: between crates Cargo sees to that, between
//! the modules of one crate this test does. Every public number names its unit.

mod units;

use std::fs;
use std::path::{Path, PathBuf};

/// A module, the modules of its own crate that it may use, and crates that it may not use though its crate does.
struct Rung {
    module: &'static str,
    may: &'static [&'static str],
    may_not: &'static [&'static str],
}

/// Systems know no solver, and bodies know no air: the two physics meet in `robot` alone.
const RUNGS: [Rung; 6] = [
    Rung { module: "wingbeat-ocp/src/plant", may: &[], may_not: &[] },
    Rung { module: "wingbeat-robot/src/body", may: &[], may_not: &["wingbeat_aero"] },
    Rung { module: "wingbeat-flight/src/simulate", may: &[], may_not: &[] },
    Rung { module: "wingbeat-flight/src/orbit", may: &["simulate"], may_not: &[] },
    Rung { module: "wingbeat-flight/src/guide", may: &["simulate", "orbit"], may_not: &[] },
    Rung { module: "wingbeat-flight/src/tether", may: &["simulate", "cycle"], may_not: &[] },
];

impl Rung {
    /// Its own name.
    fn name(&self) -> &str {
        self.module.rsplit('/').next().unwrap_or(self.module)
    }

    /// What `text`, a file of the module, uses and may not.
    fn breaches(&self, text: &str) -> Vec<String> {
        let line = |(number, line): (usize, &str)| {
            let code = line.split("//").next().unwrap_or("");
            let inside = named(code).filter(|name| *name != self.name() && !self.may.contains(name));
            let outside = self.may_not.iter().copied().filter(|name| code.contains(name));
            let all: Vec<String> = inside.chain(outside).map(str::to_owned).collect();
            all.into_iter().map(move |name| format!("line {}: {} uses {name}", number + 1, self.name()))
        };
        text.lines().enumerate().flat_map(line).collect()
    }
}

/// The modules named in `crate::module` or `crate::{module, ...}` in a line of code.
fn named(code: &str) -> impl Iterator<Item = &str> {
    code.split("crate::").skip(1).flat_map(|part| {
        let group = part.strip_prefix('{').map(|inside| inside.split('}').next().unwrap_or(inside));
        let paths: Vec<&str> = group.map_or_else(|| vec![part], |inside| inside.split(',').collect());
        paths.into_iter().map(|path| {
            let path = path.trim();
            let end = path.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(path.len());
            &path[..end]
        })
    })
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
fn every_module_uses_only_what_is_below_it() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    for rung in &RUNGS {
        let sources = files(&crates.join(rung.module));
        assert!(!sources.is_empty(), "{} has no files", rung.module);
        for path in sources {
            let breaches = rung.breaches(&fs::read_to_string(&path).unwrap());
            found.extend(breaches.into_iter().map(|breach| format!("{}, {breach}", path.display())));
        }
    }
    assert!(found.is_empty(), "modules reach upward:\n{}", found.join("\n"));
}

/// Files outside its crate that a source includes: a package of the crate would lack them. Tests are in no package's build, and name such
/// files from `CARGO_MANIFEST_DIR`.
fn outside(text: &str, depth: usize) -> impl Iterator<Item = &str> {
    let includes = text.split("include_str!(\"").chain(text.split("include_bytes!(\"")).skip(1);
    let paths = includes.map(|rest| rest.split('"').next().unwrap_or_default());
    paths.filter(move |path| path.split('/').take_while(|part| *part == "..").count() > depth)
}

#[test]
fn no_package_lacks_what_its_sources_include() {
    let mut found = Vec::new();
    for folder in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap() {
        let folder = folder.unwrap().path();
        for path in files(&folder.join("src")) {
            let Ok(text) = fs::read_to_string(&path) else { continue };
            let depth = path.strip_prefix(&folder).unwrap().components().count() - 1;
            found.extend(outside(&text, depth).map(|file| format!("{}: {file}", path.display())));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    assert_eq!(
        outside("include_str!(\"../a\"); include_str!(\"../../b\")", 1).collect::<Vec<_>>(),
        ["../../b"]
    );
}

#[test]
fn a_breach_is_seen() {
    let [plant, body, ..] = &RUNGS;
    assert!(plant.breaches("use wingbeat_math::Vec3;\nuse crate::plant::Role;").is_empty());
    assert_eq!(plant.breaches("\nuse crate::realtime::Plan;"), ["line 2: plant uses realtime"]);
    assert_eq!(body.breaches("use crate::{Robot, body::Tree};"), ["line 1: body uses Robot"]);
    assert_eq!(body.breaches("    let loads: wingbeat_aero::Loads;").len(), 1);
    assert!(body.breaches("// as crate::Robot does").is_empty());
}
