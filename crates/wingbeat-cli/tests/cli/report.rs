//! `wingbeat report` as a user meets it: the page of a run, of several, and what is refused.

use std::fs;
use std::path::Path;

use crate::{entries, root, scratch, wingbeat};

/// Glides for a tenth of a second into `out`.
fn glide(folder: &Path, out: &str, more: &[&str]) {
    let scenario = root().join("scenarios/glider.toml").display().to_string();
    let arguments = ["fly", &scenario, "--set", "flight.duration_s=0.1", "--quiet", "--out", out];
    let output = wingbeat(folder, &[&arguments, more].concat());
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn a_run_has_its_page_and_several_share_one() {
    let folder = scratch("report-page");
    glide(&folder, "a", &[]);
    glide(&folder, "b", &["--no-report"]);
    let page = fs::read_to_string(folder.join("a/report.html")).unwrap();
    assert!(page.contains("<h1>glider</h1>") && page.contains("id=\"bytes\""), "{}", page.len());
    assert!(!page.contains("http://") || page.matches("http://").count() == 1, "only the name of SVG");
    assert!(!folder.join("b/report.html").exists());
    let output = wingbeat(&folder, &["report", "b"]);
    assert!(output.status.success(), "{output:?}");
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.contains("b: flight, ") && told.contains("page: b/report.html"), "{told}");
    // The page belongs to the run now, which may be replaced as a whole.
    assert!(fs::read_to_string(folder.join("b/manifest.json")).unwrap().contains("report.html"));
    glide(&folder, "b", &["--force"]);
    let output = wingbeat(&folder, &["report", "a", "b", "--no-wake", "--no-strips"]);
    assert!(output.status.success(), "{output:?}");
    assert_eq!(entries(&folder), ["a", "b", "report.html"]);
    let both = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(both.contains("<title>a, b</title>"));
}

#[test]
fn what_is_no_run_or_a_damaged_one_is_refused_in_one_message() {
    let folder = scratch("report-refused");
    glide(&folder, "a", &[]);
    let refused = |arguments: &[&str], what: &str| {
        let output = wingbeat(&folder, arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.contains(what), "{arguments:?}: {said}");
        assert_eq!(said.lines().filter(|line| line.starts_with("error")).count(), 1, "{said}");
    };
    refused(&["report", "nowhere"], "no such folder");
    refused(&["report", "a", "a", "--out", "a/summary.json"], "is there already");
    fs::create_dir(folder.join("empty")).unwrap();
    refused(&["report", "empty"], "manifest.json");
    let damaged = [
        ("summary.json", "{", "damaged"),
        ("summary.json", "[]", "damaged"),
        ("record.parquet", "PAR1", "record.parquet"),
        ("manifest.json", "{\"program\": \"other\"}", "not the manifest"),
    ];
    for (file, text, what) in damaged {
        let whole = fs::read(folder.join("a").join(file)).unwrap();
        fs::write(folder.join("a").join(file), text).unwrap();
        refused(&["report", "a"], what);
        fs::write(folder.join("a").join(file), whole).unwrap();
    }
    fs::write(folder.join("a/scenario.toml"), "name = 3").unwrap();
    let output = wingbeat(&folder, &["report", "a", "--out", "b.html"]);
    assert!(output.status.success(), "the plots need no scenario: {output:?}");
    assert!(fs::read_to_string(folder.join("b.html")).unwrap().contains("no picture in space"));
}
