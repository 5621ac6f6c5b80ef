//! The licences of everything that is linked in.

use serde_json::Value;

use crate::report::Tally;
use crate::tools;

/// Licences that ask for no more than their text to be kept.
const ALLOWED: [&str; 13] = [
    "MIT",
    "MIT-0",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
    "0BSD",
];

/// Checks the licence of every package of the lock file.
pub fn check() -> Tally {
    let metadata = tools::output(tools::cargo(&["metadata", "--format-version", "1", "--locked"]));
    let Some(metadata) = metadata.and_then(|text| serde_json::from_str::<Value>(&text).ok()) else {
        println!("cargo metadata failed");
        return Tally::one(false);
    };
    let packages = metadata["packages"].as_array().cloned().unwrap_or_default();
    let mut tally = Tally::default();
    for package in packages {
        let licence = package["license"].as_str().unwrap_or("");
        if allowed(licence) {
            tally.passed += 1;
        } else {
            tally.failed += 1;
            println!("{} {}: licence `{licence}` is not on the list", package["name"], package["version"]);
        }
    }
    println!("{} packages, {} refused", tally.passed + tally.failed, tally.failed);
    tally
}

/// True when a choice of `licence` (SPDX: OR binds weaker than AND) is on the list.
fn allowed(licence: &str) -> bool {
    let plain = licence.replace(['(', ')'], "").replace('/', " OR ");
    plain.split(" OR ").any(|choice| choice.split(" AND ").all(|part| ALLOWED.contains(&part.trim())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_choice_suffices_and_all_parts_are_needed() {
        assert!(allowed("MIT OR GPL-3.0"));
        assert!(allowed("MIT/Apache-2.0"));
        assert!(allowed("(MIT OR Apache-2.0) AND Unicode-3.0"));
        assert!(!allowed("MIT AND GPL-3.0"));
        assert!(!allowed("EPL-2.0"));
        assert!(!allowed(""));
    }
}
