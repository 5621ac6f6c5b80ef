//! Text that is generated into the documents.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::report::Tally;
use crate::tools;

/// Writes again what is generated: what [`reference()`] writes, docs/validation.md, the tables and the pictures of docs/banking_turn.md and docs/flight.md.
pub fn write() -> bool {
    // The tests build the program too, with the features that they take.
    tools::tests_built() && reference() && banking_turns() && six_flights() && comparisons()
}

/// Writes docs/cli.md, docs/reference.md, docs/schema, docs/equations.md, docs/paper-commands.md, docs/python_reference.md and the tables of
/// docs/sections.md and docs/verdicts.md again.
pub fn reference() -> bool {
    let mut reference = tools::cargo(&["test", "--release", "--quiet", "--workspace", "--lib", "reference"]);
    reference.env("WINGBEAT_WRITE_DOCS", "1");
    let mut tables =
        tools::cargo(&["test", "--release", "--quiet", "--workspace", "--test", "ledger", "the_page_of"]);
    tables.env("WINGBEAT_WRITE_DOCS", "1");
    let mut names = tools::python();
    names.args(["crates/wingbeat-py/reference.py", "--write"]).current_dir(tools::root());
    tools::succeeds(reference) && tools::succeeds(tables) && tools::succeeds(names)
}

/// The page of the paper's turn, which shows the turn under all presets and laws.
const TURN_PAGE: &str = "docs/banking_turn.md";

/// The animation of the turn that was flown last.
const MOVES: [&str; 13] = [
    "animate",
    "target/shown",
    "--out",
    "docs/images/banking_turn_moves.png",
    "--wide",
    "--width",
    "800",
    "--speed",
    "0.5",
    "--rate",
    "12",
    "--force",
    "--quiet",
];

/// Flies the banking turn with both aerodynamic presets and a turn that carries its weight, and puts tables and
/// pictures into their pages.
fn banking_turns() -> bool {
    let turn = "scenarios/banking_turn.toml";
    shown(TURN_PAGE, "banking turn", &[turn], Some("banking_turn.png"))
        && tools::succeeds(tools::wingbeat(&MOVES))
        && shown(TURN_PAGE, "banking turn, full", &[turn, "--set", "aero.preset=full"], None)
        && shown(
            "docs/flight.md",
            "turn that carries its weight",
            &["scenarios/any_air_bank30_20g.toml"],
            Some("any_air_bank30_20g.png"),
        )
}

/// Flies what `arguments` say, puts its table at `mark` of the document `page` and the picture of its path into the
/// file `picture`.
fn shown(page: &str, mark: &str, arguments: &[&str], picture: Option<&str>) -> bool {
    let root = tools::root();
    let run = root.join("target/shown");
    let _ = fs::remove_dir_all(&run);
    let mut command = tools::wingbeat(&["fly"]);
    command.args(arguments).arg("--out").arg(&run);
    let Some(output) = tools::output(command) else { return false };
    let table = untimed(output.split("\nrun folder").next().unwrap_or("").trim_end());
    let images = root.join("docs/images");
    let copied = picture.is_none_or(|picture| {
        fs::create_dir_all(&images)
            .and_then(|()| fs::copy(run.join("figures/path.png"), images.join(picture)))
            .is_ok()
    });
    copied && put_into(page, mark, &format!("```text\n{table}\n```"))
}

/// Starting phases of the flights under other laws, rad: what these move is not a result.
const PHASES: [&str; 3] = ["0.0", "1e-9", "-1e-9"];

/// Flies the banking turn with both presets under every lift law, and puts the results into its page.
fn six_flights() -> bool {
    let mut text = String::from(
        "| preset | law | status | roll, mean / rms error, deg | nose up, mean / rms error, deg | altitude, m | inputs at a limit | clearance, mm | separated | suction lost |\n\
         |---|---|---|---:|---:|---:|---:|---:|---:|---:|",
    );
    for (preset, law) in ["paper", "full"].iter().flat_map(|p| ["linear", "stall", "lev"].map(|law| (p, law)))
    {
        let flights: Vec<Value> = PHASES.iter().filter_map(|phase| flight(preset, law, phase)).collect();
        if flights.len() < PHASES.len() {
            return false;
        }
        text += &flight_row(preset, law, &flights);
    }
    put_into(TURN_PAGE, "six flights", &text)
}

/// The summary of a flight.
fn flight(preset: &str, law: &str, phase: &str) -> Option<Value> {
    let run = tools::root().join("target/six_flights");
    let _ = fs::remove_dir_all(&run);
    let mut command = tools::wingbeat(&["fly", "scenarios/banking_turn.toml", "--quiet"]);
    for (key, value) in [("aero.preset", preset), ("aero.law", law), ("start.phase_rad", phase)] {
        command.arg("--set").arg(format!("{key}={value}"));
    }
    command.arg("--out").arg(&run);
    // A turn that misses its goal ends with another code than 0, and is told all the same.
    let _ = tools::output(command);
    serde_json::from_str(&fs::read_to_string(run.join("summary.json")).ok()?).ok()
}

/// What flights came to, as a row; from the least to the most where they differ.
fn flight_row(preset: &str, law: &str, flights: &[Value]) -> String {
    let range = |key: &str, scale: f64, digits: usize| {
        let values = || flights.iter().map(|flight| scale * flight[key].as_f64().unwrap_or(f64::NAN));
        let ends = [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
        let [low, high] = ends.map(|end| format!("{end:.digits$}"));
        if low == high { low } else { format!("{low} to {high}") }
    };
    // Records and summaries give pitch negative nose up, pages nose up.
    let pair = |angle: &str, sign: f64| {
        let part = |what: &str, scale: f64| range(&format!("{angle}_{what}_deg"), scale, 1);
        format!("{} / {}", part("mean", sign), part("rms_error", 1.0))
    };
    let mut statuses: Vec<&str> = flights.iter().filter_map(|flight| flight["status"].as_str()).collect();
    statuses.sort_unstable();
    statuses.dedup();
    let percent = |key: &str| format!("{} %", range(key, 100.0, 0));
    format!(
        "\n| `{preset}` | `{law}` | {} | {} | {} | {} | {} | {} | {} | {} |",
        statuses.join(", "),
        pair("roll", 1.0),
        pair("pitch", -1.0),
        range("altitude_change_m", 1.0, 1),
        percent("input_saturation_fraction"),
        range("least_clearance_m", 1e3, 0),
        percent("separated_fraction"),
        percent("suction_lost_fraction"),
    )
}

/// The table without its running times, which belong to the machine.
fn untimed(table: &str) -> String {
    const TIMED: [&str; 3] = ["update, ", "updates past their period", "real-time factor"];
    let timed = |line: &&str| TIMED.iter().any(|start| line.starts_with(start));
    table.lines().filter(|line| !timed(line)).collect::<Vec<_>>().join("\n")
}

/// Runs every comparison, and puts the page with its figures into docs.
fn comparisons() -> bool {
    let run = tools::root().join("target/validation");
    let mut command = tools::wingbeat(&["validate", "--force", "--out"]);
    let _ = fs::create_dir_all(tools::root().join("target"));
    command.arg(&run);
    tools::succeeds(command);
    page(&run)
}

/// The rows that a file of `wingbeat validate` holds.
fn rows_of(file: &Path) -> Option<Vec<Value>> {
    serde_json::from_str(&fs::read_to_string(file).ok()?).ok()
}

/// Copies the page of the comparisons and its figures from the folder `run`.
fn page(run: &Path) -> bool {
    let docs = tools::root().join("docs");
    let images = docs.join("images/validation");
    let Ok(text) = fs::read_to_string(run.join("validation.md")) else { return false };
    let text = text.replace("](figures/", "](images/validation/");
    let _ = fs::remove_dir_all(&images);
    let pictures = || -> std::io::Result<()> {
        fs::create_dir_all(&images)?;
        for entry in fs::read_dir(run.join("figures"))? {
            let path = entry?.path();
            if let (Some("png"), Some(name)) = (path.extension().and_then(|e| e.to_str()), path.file_name()) {
                fs::copy(&path, images.join(name))?;
            }
        }
        fs::write(docs.join("validation.md"), text)
    };
    pictures().is_ok()
}

/// The comparisons that `which` chooses, their rows in `file`, and the numbers of docs/validation.md beside theirs.
pub fn compared(file: &str, which: &[&str]) -> Tally {
    let file = tools::root().join(file);
    let path = file.to_string_lossy();
    let mut tally = Tally::of(tools::wingbeat(&[&["validate", "--quiet", "--json", &path], which].concat()));
    let stale = rows_of(&file).map(|rows| stale(&rows)).unwrap_or_default();
    for what in &stale {
        println!("docs/validation.md is stale, run `cargo xtask docs`: {what}");
    }
    tally.failed += stale.len();
    tally
}

/// What the tables of docs/validation.md say otherwise than `rows`, which may be some of all.
///
/// Numbers agree within two per cent; below 1e-4 they are rounding and need only stay there.
fn stale(rows: &[Value]) -> Vec<String> {
    let page = fs::read_to_string(tools::root().join("docs/validation.md")).unwrap_or_default();
    rows.iter().filter_map(|row| disagreement(row, &page)).collect()
}

fn disagreement(row: &Value, page: &str) -> Option<String> {
    let id = row["id"].as_str().unwrap_or("");
    let start = format!("| `{id}` |");
    let Some(line) = page.lines().find(|line| line.starts_with(&start)) else {
        return Some(format!("{id} is missing"));
    };
    let cells: Vec<&str> = line.trim_end_matches(" |").rsplit(" | ").take(2).collect();
    let written = |cell: usize| cells.get(cell).and_then(|cell| cell.parse::<f64>().ok());
    let same = |written: Option<f64>, now: Option<f64>| match (written, now) {
        (Some(a), Some(b)) => (a - b).abs() <= 0.02 * b.abs() || (a.abs() <= 1e-4 && b.abs() <= 1e-4),
        (a, b) => a.is_none() && b.is_none(),
    };
    let agrees = same(written(0), row["limit"].as_f64()) && same(written(1), row["value"].as_f64());
    (!agrees).then(|| format!("{id} is now {} with limit {}", row["value"], row["limit"]))
}

/// Puts `text` between the marks `<!-- name -->` and `<!-- end -->` of the document at `path`.
pub fn put_into(path: &str, name: &str, text: &str) -> bool {
    let path = tools::root().join(path);
    let Ok(document) = fs::read_to_string(&path) else { return false };
    between(&document, name, text).is_some_and(|document| fs::write(&path, document).is_ok())
}

fn between(document: &str, name: &str, text: &str) -> Option<String> {
    let mark = format!("<!-- {name} -->\n");
    let (before, rest) = document.split_once(&mark)?;
    let (_, after) = rest.split_once("<!-- end -->")?;
    Some(format!("{before}{mark}{text}\n<!-- end -->{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_goes_between_its_marks() {
        let document = "a\n<!-- x -->\nold\n<!-- end -->\nb";
        assert_eq!(between(document, "x", "new").unwrap(), "a\n<!-- x -->\nnew\n<!-- end -->\nb");
        assert_eq!(between(document, "y", "new"), None);
    }

    #[test]
    fn a_page_is_stale_when_a_number_has_moved() {
        let page = "| `a.b` | error \\| x | 0.0152 | 0.02 |\n| `a.c` | error | 6e-14 | - |";
        let row = |id: &str, value: f64, limit: Option<f64>| serde_json::json!({"id": id, "value": value, "limit": limit});
        assert_eq!(disagreement(&row("a.b", 0.01523, Some(0.02)), page), None);
        assert_eq!(disagreement(&row("a.c", 2e-13, None), page), None);
        assert!(disagreement(&row("a.b", 0.0160, Some(0.02)), page).is_some());
        assert!(disagreement(&row("a.b", 0.0152, Some(0.03)), page).is_some());
        assert!(disagreement(&row("a.d", 0.0152, None), page).is_some());
    }

    #[test]
    fn running_times_stay_out() {
        assert_eq!(
            untimed("roll 15 deg\nupdates past their period 9\nupdate, median 1 ms\nreal-time factor 3"),
            "roll 15 deg"
        );
    }
}
