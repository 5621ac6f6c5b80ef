use std::path::Path;

use wingbeat_config::inside::{MOST_STATIONS, OutlineFile};

fn outline(toml: &str, text: &str) -> Result<String, String> {
    let outline: OutlineFile = toml::from_str(toml).unwrap();
    outline.toml(Path::new("a.csv"), text, "wing.planform").map_err(|wrong| wrong.to_string())
}

#[test]
fn rows_keep_their_lines_and_get_metres_and_sign() {
    let text = "# drawn\narc_mm,leading_edge_mm,trailing_edge_mm\n0,-63.5,95.6\n\n202.7,0,2e1\n";
    let toml = outline("file = \"a.csv\"\nx = \"aft\"", text).unwrap();
    let lines: Vec<&str> = toml.lines().collect();
    assert_eq!(lines[2], "{arc_m=0.0,leading_edge_m=0.0635,trailing_edge_m=-0.0956},");
    assert_eq!(lines[4], "{arc_m=0.2027,leading_edge_m=0.0,trailing_edge_m=-0.02},]");
}

#[test]
fn what_is_wrong_is_told_by_file_line_key_and_value() {
    let (file, header) = ("file = \"a.csv\"", "arc,leading_edge,trailing_edge\n");
    for (toml, text, said) in [
        (file, "s,le,te\n0,1,0\n", "a.csv:1: wing.planform.file = s, le, te: allowed is columns arc"),
        (
            "file = \"a.csv\"\ncolumns = [\"s\", \"le\", \"tail\"]",
            "s,le,te\n",
            "a.csv:1: wing.planform.columns = tail: allowed is one of s, le, te",
        ),
        (
            "file = \"a.csv\"\nunit = \"m\"",
            "arc_mm,leading_edge,trailing_edge\n",
            "a.csv:1: wing.planform.unit = m: allowed is one unit; unit says m, column arc_mm says mm",
        ),
        (
            file,
            &format!("{header}0,1,0\n1,x,0\n"),
            "a.csv:3: wing.planform[1].leading_edge = x: allowed is a finite number in column 2",
        ),
        (file, &format!("{header}0,1\n"), "a.csv:2: wing.planform[0].trailing_edge = : allowed is a finite"),
        (file, header, "a.csv: wing.planform = \"a.csv\": allowed is a header and a row"),
        (
            file,
            &(header.to_owned() + &"0,1,0\n".repeat(MOST_STATIONS + 1)),
            "allowed is at most 10000 stations",
        ),
    ] {
        let error = outline(toml, text).unwrap_err();
        assert!(error.contains(said), "{error}\nnot: {said}");
    }
}
