//! Text that is generated into the documents.

use std::fs;

use serde_json::Value;

use crate::tools;

/// Writes again what is generated: docs/cli.md, the tables and the picture of README.md.
pub fn write() -> bool {
    let mut reference =
        tools::cargo(&["test", "--release", "--quiet", "--package", "wingbeat-cli", "reference"]);
    reference.env("WINGBEAT_WRITE_DOCS", "1");
    tools::succeeds(reference) && banking_turns() && comparisons()
}

/// Flies the banking turn with both aerodynamic presets and puts tables and
/// picture into the README.
fn banking_turns() -> bool {
    banking_turn("banking turn", "paper", true) && banking_turn("banking turn, full", "full", false)
}

/// Flies the banking turn with an aerodynamic preset and puts its table at `mark`.
fn banking_turn(mark: &str, preset: &str, picture: bool) -> bool {
    let root = tools::root();
    let run = root.join("target/banking_turn");
    let _ = fs::remove_dir_all(&run);
    let mut command =
        tools::cargo(&["run", "--release", "--quiet", "--", "fly", "scenarios/banking_turn.toml"]);
    command.arg("--set").arg(format!("aero.preset={preset}")).arg("--out").arg(&run);
    let Some(output) = tools::output(command) else { return false };
    let table = untimed(output.split("\nrun folder").next().unwrap_or("").trim_end());
    let images = root.join("docs/images");
    let copied = !picture
        || fs::create_dir_all(&images)
            .and_then(|()| fs::copy(run.join("figures/path.png"), images.join("banking_turn.png")))
            .is_ok();
    copied && put(mark, &format!("```text\n{table}\n```"))
}

/// The table without its running times, which belong to the machine.
fn untimed(table: &str) -> String {
    let timed = |line: &&str| line.starts_with("update, ") || line.starts_with("real-time factor");
    table.lines().filter(|line| !timed(line)).collect::<Vec<_>>().join("\n")
}

/// Runs every comparison and puts the table into the README.
fn comparisons() -> bool {
    let file = tools::root().join("target/validation.json");
    let mut command = tools::cargo(&["run", "--release", "--quiet", "--", "validate", "--json"]);
    command.arg(&file);
    tools::succeeds(command);
    let rows = fs::read_to_string(&file).ok().and_then(|text| serde_json::from_str::<Vec<Value>>(&text).ok());
    rows.is_some_and(|rows| put("validation", &markdown(&rows)))
}

/// The rows as a Markdown table.
fn markdown(rows: &[Value]) -> String {
    let mut text = String::from("| id | source | metric | value | limit |\n|---|---|---|---:|---:|");
    for row in rows {
        let words = |key: &str| row[key].as_str().unwrap_or("").replace('|', "\\|");
        let limit = row["limit"].as_f64().map_or("-".into(), number);
        let value = row["value"].as_f64().map_or("-".into(), number);
        let failed = if row["pass"] == false { " **fails**" } else { "" };
        text += &format!(
            "\n| {} | {} | {} | {value}{failed} | {limit} |",
            words("id"),
            words("source"),
            words("metric")
        );
    }
    text
}

fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e5).contains(&size) { format!("{value:.4}") } else { format!("{value:.1e}") }
}

/// Puts `text` between the marks `<!-- name -->` and `<!-- end -->` of README.md.
fn put(name: &str, text: &str) -> bool {
    put_into("README.md", name, text)
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
    fn running_times_stay_out() {
        assert_eq!(untimed("roll 15 deg\nupdate, median 1 ms\nreal-time factor 3"), "roll 15 deg");
    }

    #[test]
    fn a_number_without_limit_is_only_shown() {
        let rows: Vec<Value> = serde_json::from_str(
            r#"[{"id":"a","source":"s","metric":"m","value":2e-9,"limit":null,"pass":true}]"#,
        )
        .unwrap();
        assert!(markdown(&rows).ends_with("| a | s | m | 2.0e-9 | - |"));
    }
}
