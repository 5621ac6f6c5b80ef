//! What the dependencies are allowed to be, by deny.toml: licences, bans and sources, and by cargo-deny advisories.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::report::Tally;
use crate::tools;

/// The version that is installed into target/tools.
const VERSION: &str = "0.20.2";
/// Workspaces with a lock file: that of the program, and that of the fuzz targets.
const MANIFESTS: [&str; 2] = ["Cargo.toml", "fuzz/Cargo.toml"];
/// The registry from which alone packages come.
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";
/// Where this version seeks the advisory database of RustSec, below the `db-path` of deny.toml.
const DATABASE: &str = "target/advisories/advisory-db-3157b0e258782691";

/// What deny.toml allows.
struct Allowed {
    licences: Vec<spdx::Licensee>,
    banned: Vec<String>,
    targets: Vec<String>,
}

impl Allowed {
    /// What the text of deny.toml says; none where it cannot be read so.
    fn read(text: &str) -> Option<Self> {
        let table: toml::Table = text.parse().ok()?;
        let words = |of: &str, key: &str| -> Option<Vec<String>> {
            let list = table.get(of)?.get(key)?.as_array()?;
            list.iter().map(|word| word.as_str().map(str::to_owned)).collect()
        };
        Some(Self {
            licences: words("licenses", "allow")?
                .iter()
                .map(|name| spdx::Licensee::parse(name).ok())
                .collect::<Option<_>>()?,
            banned: words("bans", "deny")?,
            targets: words("graph", "targets")?,
        })
    }

    /// What is wrong with a package of `cargo metadata`; nothing where it is allowed.
    fn objection(&self, package: &Value) -> Option<String> {
        let word = |key: &str| package[key].as_str();
        let name = word("name").unwrap_or("?");
        // A package of the workspace has no source.
        if word("source").is_some_and(|source| source != REGISTRY) {
            return Some(format!("{name}: it comes from {}", package["source"]));
        }
        if self.banned.iter().any(|banned| banned == name) {
            return Some(format!("{name}: [bans] of deny.toml names it"));
        }
        let Some(licence) = word("license") else { return Some(format!("{name}: it names no licence")) };
        let expression = match spdx::Expression::parse_mode(licence, spdx::ParseMode::LAX) {
            Ok(expression) => expression,
            Err(error) => return Some(format!("{name}: {licence}: {error}")),
        };
        let allowed = expression.evaluate(|asked| self.licences.iter().any(|given| given.satisfies(asked)));
        (!allowed).then(|| format!("{name}: its licence, {licence}, is none that deny.toml allows"))
    }
}

/// Checks licences, bans and sources of every package that may be linked in on the targets of deny.toml, with all features.
pub fn check() -> Tally {
    let text = fs::read_to_string(tools::root().join("deny.toml")).unwrap_or_default();
    let Some(allowed) = Allowed::read(&text) else {
        eprintln!(
            "error: deny.toml: licenses.allow, bans.deny and graph.targets are not lists of what they name"
        );
        return Tally::one(false);
    };
    let mut metadata = tools::cargo(&["metadata", "--format-version", "1", "--locked", "--all-features"]);
    for target in &allowed.targets {
        metadata.args(["--filter-platform", target]);
    }
    let packages = tools::output(metadata).and_then(|text| serde_json::from_str::<Value>(&text).ok());
    let packages = packages.as_ref().and_then(|graph| graph["packages"].as_array());
    let objections: Vec<String> =
        packages.into_iter().flatten().filter_map(|package| allowed.objection(package)).collect();
    objections.iter().for_each(|objection| eprintln!("error: {objection}"));
    let seen = packages.map_or(0, Vec::len);
    Tally { passed: seen - objections.len(), failed: objections.len() + usize::from(seen == 0) }
}

/// Checks the lock files against the clone of the advisory database that `--db PATH` names; true when no advisory is
/// about them. Nothing is fetched.
pub fn advisories(arguments: &[String]) -> bool {
    let [option, path] = arguments else {
        eprintln!("error: advisories takes --db PATH, a clone of https://github.com/rustsec/advisory-db");
        return false;
    };
    if option != "--db" || !Path::new(path).join("crates").is_dir() {
        eprintln!("error: {option} {path}: allowed is --db PATH with a folder `crates` in it");
        return false;
    }
    let clean = |manifest: &&str| {
        println!("{manifest}");
        tools::succeeds(tools::cargo(&["fetch", "--locked", "--manifest-path", manifest]))
            && deny(manifest, "--offline", &["advisories"])
    };
    cloned(Path::new(path)) && MANIFESTS.iter().filter(|manifest| !clean(manifest)).count() == 0
}

/// Clones the database at `path` to where it is sought.
fn cloned(path: &Path) -> bool {
    let Ok(path) = std::path::absolute(path) else { return false };
    let target = tools::root().join(DATABASE);
    if target.exists() && fs::remove_dir_all(&target).is_err() {
        eprintln!("error: {} cannot be removed", target.display());
        return false;
    }
    let mut clone = Command::new("git");
    clone.args(["clone", "--quiet", "--no-hardlinks"]).arg(path).arg(target);
    tools::succeeds(clone)
}

/// Runs `checks` over the workspace of `manifest`; true when all pass.
fn deny(manifest: &str, network: &str, checks: &[&str]) -> bool {
    // Unoptimised it is there in half the time and checks in seconds.
    let Some(program) = tools::installed("cargo-deny", VERSION, &["--debug"]) else { return false };
    let mut command = Command::new(program);
    command.current_dir(tools::root()).args(["--manifest-path", manifest, network, "--config", "deny.toml"]);
    command.args(["--log-level", "error", "check", "--hide-inclusion-graph"]).args(checks);
    tools::succeeds(command)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_deny_toml_does_not_allow_is_named() {
        let text = fs::read_to_string(tools::root().join("deny.toml")).unwrap();
        let allowed = Allowed::read(&text).unwrap();
        let objection = |name: &str, licence: &str, source: &str| {
            allowed.objection(&json!({ "name": name, "license": licence, "source": source }))
        };
        assert_eq!(objection("a", "MIT OR GPL-3.0-only", REGISTRY), None);
        assert_eq!(objection("a", "MIT/Apache-2.0", REGISTRY), None);
        assert_eq!(objection("a", "Apache-2.0 WITH LLVM-exception", REGISTRY), None);
        assert!(objection("a", "MIT AND GPL-3.0-only", REGISTRY).unwrap().contains("GPL-3.0-only"));
        assert!(
            objection("a", "EPL-2.0", REGISTRY).is_some() && objection("cmake", "MIT", REGISTRY).is_some()
        );
        assert!(objection("a", "MIT", "git+https://example.org/a").unwrap().contains("example.org"));
        assert!(allowed.objection(&json!({ "name": "a" })).unwrap().contains("no licence"));
        assert!(Allowed::read("[licenses]\nallow = [1]").is_none());
    }
}
