//! A compiler between cargo and rustc: unit tests that would compile the models once more, optimised, are compiled without
//! optimisation. Cargo has one optimisation for a package, whether it builds the library or its tests.

use std::process::{Command, ExitCode};

/// Programs of tests by the names of their crates: to compile these optimised takes three times as long, and what they then save when they
/// run is less. What other programs of tests use is compiled in the libraries.
const PLAIN: [&str; 8] = [
    "cli",
    "wingbeat",
    "wingbeat_aero",
    "wingbeat_figures",
    "wingbeat_flight",
    "wingbeat_math",
    "wingbeat_ocp",
    "wingbeat_rig",
];

/// Set where this program is called as a compiler.
const CALLED: &str = "WINGBEAT_PLAIN_TESTS";

/// Lets `cargo` compile by this program, unless the user has a wrapper, such as a cache, of their own.
pub fn compiled_plain(cargo: &mut Command) {
    if let (Ok(own), None) = (std::env::current_exe(), std::env::var_os("RUSTC_WRAPPER")) {
        cargo.env("RUSTC_WRAPPER", own).env(CALLED, "1");
    }
}

/// Whether this program is called as a compiler.
pub fn is_called() -> bool {
    std::env::var_os(CALLED).is_some()
}

/// Calls the compiler, the first of `arguments`, with the others.
pub fn compile(arguments: &[String]) -> ExitCode {
    let Some((compiler, arguments)) = arguments.split_first() else { return ExitCode::from(2) };
    match Command::new(compiler).args(plain(arguments)).status() {
        Ok(status) => ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1)),
        Err(error) => {
            eprintln!("error: {compiler}: {error}");
            ExitCode::FAILURE
        }
    }
}

/// `arguments` of the compiler as they are, or without optimisation for tests of these crates. Checks of debug builds stay away, as
/// cargo leaves them away.
fn plain(arguments: &[String]) -> Vec<String> {
    let mut all = arguments.to_vec();
    let name = arguments.iter().position(|argument| argument == "--crate-name");
    let name = name.and_then(|at| arguments.get(at + 1)).map_or("", String::as_str);
    if PLAIN.contains(&name) && arguments.iter().any(|argument| argument == "--test") {
        // The last of several holds.
        let options = ["opt-level=0", "debug-assertions=off", "overflow-checks=off"];
        all.extend(options.iter().flat_map(|option| ["-C".into(), (*option).into()]));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn tests_of_the_models_are_compiled_plain_and_the_models_are_not() {
        let asked = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let library = asked("--crate-name wingbeat_aero src/lib.rs --crate-type lib -C opt-level=3");
        assert_eq!(plain(&library), library);
        let other = asked("--crate-name wingbeat_robot src/lib.rs --test -C opt-level=3");
        assert_eq!(plain(&other), other);
        let tests = plain(&asked("--crate-name wingbeat_aero src/lib.rs --test -C opt-level=3"));
        assert!(tests.ends_with(&asked(
            "-C opt-level=3 -C opt-level=0 -C debug-assertions=off -C overflow-checks=off"
        )));
        assert_eq!(plain(&asked("-vV")), ["-vV"]);
    }
}
