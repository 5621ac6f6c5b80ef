//! The table of limits.

use std::collections::BTreeSet;
use wingbeat_judge::Status;
use wingbeat_judge::limits::{self, Limits, Sense};

#[test]
fn every_limit_has_a_name_of_its_own_its_kind_and_a_meaning() {
    let mut names = BTreeSet::new();
    for limit in limits::all() {
        assert!(names.insert(limit.id), "{} stands twice", limit.id);
        let (kind, quantity) = limit.id.split_once('.').unwrap();
        assert!(!kind.is_empty() && !quantity.contains('.') && !limit.meaning.is_empty(), "{}", limit.id);
        assert!(limit.value.is_finite() && limit.allows(limit.value, limit.value), "{}", limit.id);
        assert!(!limit.allows(f64::NAN, limit.value), "{}", limit.id);
    }
}

#[test]
fn an_unknown_limit_names_those_of_its_kind() {
    let error = Limits::default().with("flight.altitud_m", 1.0).unwrap_err().to_string();
    assert!(error.contains("flight.altitud_m") && error.contains("flight.altitude_m"), "{error}");
    assert!(!error.contains("trim."), "{error}");
    assert!(Limits::default().with("nothing", 1.0).unwrap_err().known.contains("flight.altitude_m"));
}

/// The page says every limit as it is.
#[test]
fn the_page_of_verdicts_lists_every_status_and_limit() {
    let page = include_str!("../../../../docs/verdicts.md");
    for limit in limits::all() {
        let side = if limit.sense == Sense::AtMost { "at most" } else { "at least" };
        let unit = if limit.unit.is_empty() { String::new() } else { format!(" {}", limit.unit) };
        let status = limit.status.map_or("warning", Status::name);
        let row = format!("| `{}` | {} | {side} {}{unit} | {status} |", limit.id, limit.meaning, limit.value);
        assert!(page.contains(&row), "docs/verdicts.md lacks the row\n{row}");
    }
    for status in Status::ALL {
        let row = format!("| `{status}` | {} | {} |", status.meaning(), status.exit_code());
        assert!(page.contains(&row), "docs/verdicts.md lacks the row\n{row}");
    }
}
