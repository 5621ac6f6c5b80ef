//! Tasks of the developers: `cargo xtask test`, `docs`, `bench`, `peers`, `fuzz`.

mod licences;
mod report;
mod test;
mod tools;

use std::process::ExitCode;

const HELP: &str = "\
cargo xtask TASK

  test    format, lints, all tests, licences of dependencies, quick comparisons; what .ci/run calls
  docs    write again what is generated: docs/cli.md
  bench   medians of the running times
  peers   compare running times with other programs
  fuzz    feed the readers of files with broken input
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let task = arguments.first().map_or("", String::as_str);
    let outcome = match task {
        "test" => test::test(),
        "docs" => tools::docs(),
        "" | "help" | "--help" | "-h" => {
            print!("{HELP}");
            return ExitCode::SUCCESS;
        }
        unknown => {
            eprintln!("error: no task {unknown}\n\n{HELP}");
            return ExitCode::from(2);
        }
    };
    if outcome { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
