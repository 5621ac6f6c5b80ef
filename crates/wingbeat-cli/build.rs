//! Has the linker keep machine code that is equal once: generic code is often the same for types of the same size, and the program
//! is a twentieth smaller. No function of ours is known by its address.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=RUSTC_LINKER");
    if links_with_lld() {
        println!("cargo::rustc-link-arg-bins=-Wl,--icf=all");
    }
}

/// Whether the linker is the one that comes with the compiler, which has the option; GNU's ld refuses it.
fn links_with_lld() -> bool {
    let is = |key: &str, value: &str| env::var(key).is_ok_and(|given| given == value);
    let target = ["OS", "ARCH", "ENV"].map(|part| format!("CARGO_CFG_TARGET_{part}"));
    let linux = is(&target[0], "linux") && is(&target[1], "x86_64") && is(&target[2], "gnu");
    let flags = env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    let chosen = env::var_os("RUSTC_LINKER").is_some() || flags.contains("link");
    linux && !chosen
}
