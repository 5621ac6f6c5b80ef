//! Tasks of the developers: `cargo xtask test`, `docs`, `reference`, `bench`, `peers`, `fuzz`, `hostile`,
//! `faults`, `advisories`, `python`, `soak`, `paper`, `long`.

mod against;
mod blocks;
mod book;
mod browser;
mod copies;
mod dependencies;
mod documents;
mod doors;
mod exports;
mod fuzz;
mod hostile;
mod instructions;
mod long;
#[cfg(test)]
mod names;
#[cfg(test)]
mod pages;
mod paper;
mod peers;
mod plain;
mod programs;
mod python;
mod report;
mod soak;
mod test;
mod tools;
mod tutorials;

use std::process::ExitCode;

const HELP: &str = "\
cargo xtask TASK

  test    format, lints, all tests, the Python package, licences, bans and sources of dependencies, quick comparisons; what
          .ci/run calls
  long    [NAME...] what takes hours: the commands behind the pages on the paper, the recorder for an hour, all hostile cases, all
          comparisons, fuzzing, and the other programs where they are installed; docs/testing.md lists both
  docs    write again what is generated: what `reference` writes, docs/validation.md, the tables and the pictures of
          docs/banking_turn.md and docs/flight.md; flies and compares everything, a quarter of an hour
  reference  docs/cli.md, docs/reference.md, docs/schema, docs/equations.md, docs/paper-commands.md,
          docs/python_reference.md, the tables of docs/sections.md and docs/verdicts.md
  bench   [--against REVISION] medians of the running times; with a revision the least of five rounds in turns with that one, which is
          built in target/against
  peers   the same beside Pinocchio, PteraSoftware (`peers mechanics`) and CasADi (`peers control`), which are
          installed into target/peers (Python 3.11 or later); `peers netft` lets pynetft read the emulated box,
          `peers lattice` steps PteraSoftware's vortex lattice beside ours, `peers steps` MuJoCo's tree without air
          beside the environments, `peers first` runs the first version that flew
  fuzz    [--seconds 600] [TARGET...] everything that reads what others wrote, each for so long
  hostile [--list] [--quick] [--class N] [--program FILE] [NAME...] what an unlucky or hostile user does, under limits
          of memory, time and disk; the cases are the lists of crates/xtask/hostile
  faults  [VERB...] each write, creation, renaming, removal and start of a thread of these verbs, or of all, fails in turn (Linux)
  advisories --db PATH  the lock files against a clone of https://github.com/rustsec/advisory-db
  python  test | wheel | notebooks | calls | measure | policies [STEPS [SEED...]]: the tests of the Python package; the wheel to be
          released, in target/wheels (on Linux for glibc 2.28 and later); the notebooks with what they print and draw; 10,000 calls
          with hostile arguments; what the package costs; policies trained by Stable-Baselines3 beside the predictive controller
          (installs PyTorch, some GB, into target/tools/policies)
  paper   every command of validation/paper/commands.txt, into target/paper: exit codes and numbers as it says
  soak    [--seconds 600] [--busy 0] [--program FILE] the recorder on the emulated box at 7 kHz beside so many busy processes: every
          sample accounted for, memory flat
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if plain::is_called() {
        return plain::compile(&arguments);
    }
    let helped = arguments.iter().any(|argument| argument == "--help" || argument == "-h");
    let task = if helped { "help" } else { arguments.first().map_or("", String::as_str) };
    let outcome = match task {
        "test" => test::test(),
        "docs" => documents::write(),
        "reference" => documents::reference(),
        "long" => long::long(&arguments[1..]),
        "bench" => against::bench(&arguments[1..]),
        "fuzz" => fuzz::fuzz(&arguments[1..]),
        "hostile" => hostile::hostile(&arguments[1..]),
        "advisories" => dependencies::advisories(&arguments[1..]),
        "faults" => tools::tests_built() && hostile::disturbed::faults_of(&arguments[1..]).failed == 0,
        "soak" => soak::soak(&arguments[1..]),
        "python" => python::task(&arguments[1..]),
        "paper" => paper::run(),
        "peers" => peers::compare(arguments.get(1).map(String::as_str)),
        "" | "help" => {
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
