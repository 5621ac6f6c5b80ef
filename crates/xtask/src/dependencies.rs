//! What the dependencies are allowed to be: licences, bans, sources and advisories, by cargo-deny and deny.toml.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::report::Tally;
use crate::tools;

/// The version that is installed into target/tools.
const VERSION: &str = "0.20.2";
/// What is looked at in the tests.
const CHECKS: [&str; 3] = ["licenses", "bans", "sources"];
/// Workspaces with a lock file: that of the program, and that of the fuzz targets.
const MANIFESTS: [&str; 2] = ["Cargo.toml", "fuzz/Cargo.toml"];
/// Where this version seeks the advisory database of RustSec, below the `db-path` of deny.toml.
const DATABASE: &str = "target/advisories/advisory-db-3157b0e258782691";

/// Checks licences, bans and sources of every package that is linked in.
pub fn check() -> Tally {
    Tally::one(deny(MANIFESTS[0], "--locked", &CHECKS))
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
