//! The library compiles only for processors with AVX2 and FMA, unless its user says otherwise.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What becomes of processor.rs, compiled alone for `processor` with `options`.
fn compiled(processor: &str, options: &[&str]) -> Output {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../wingbeat-math/src/processor.rs");
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("processor");
    std::fs::create_dir_all(&out).unwrap();
    let mut rustc = Command::new(option_env!("RUSTC").unwrap_or("rustc"));
    rustc.args(["--edition", "2024", "--crate-type", "lib", "--emit", "metadata", "--out-dir"]).arg(out);
    rustc.args(["-C", &format!("target-cpu={processor}")]).args(options).arg(source).output().unwrap()
}

#[test]
fn without_the_flags_it_is_said_what_to_set() {
    let refused = compiled("x86-64", &[]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(!refused.status.success(), "{said}");
    assert!(said.contains("target-cpu=x86-64-v3") && said.contains(".cargo/config.toml"), "{said}");
    assert!(said.contains("`portable`"), "{said}");
}

#[test]
fn the_flags_or_the_feature_are_enough() {
    for (processor, options) in [("x86-64-v3", &[][..]), ("x86-64", &["--cfg", "feature=\"portable\""])] {
        let done = compiled(processor, options);
        assert!(done.status.success(), "{processor}: {}", String::from_utf8_lossy(&done.stderr));
    }
}
