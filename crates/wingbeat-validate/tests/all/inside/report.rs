use wingbeat_validate::*;

#[test]
fn table_is_aligned_and_says_the_verdict() {
    let rows = [
        ComparisonRow::judged("a.b", "Jones 1940", "max error", 2.5e-5, 4e-4, "deg"),
        ComparisonRow::judged("a.c", "Jones 1940", "max error", 1.0, 0.5, ""),
        ComparisonRow::shown("a.longer", "Jones 1940", "max error", 0.25, ""),
    ];
    let text = table(&rows);
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines[2], "a.b       Jones 1940  max error [deg]  2.50e-5  4.00e-4  pass");
    assert!(lines[3].ends_with("FAIL"));
    assert!(lines[4].ends_with("shown"));
}

#[test]
fn json_has_exactly_the_named_fields() {
    let rows = [ComparisonRow::judged("a", "s", "m", f64::NAN, 1.0, "")];
    let text = serde_json::to_string(&to_json(&rows)).unwrap();
    assert_eq!(text, r#"[{"id":"a","source":"s","metric":"m","value":null,"limit":1.0,"pass":false}]"#);
}
