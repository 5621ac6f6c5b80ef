//! The table of limits.

use std::collections::BTreeSet;
use wingbeat_judge::limits::{self, RunLimits};

#[test]
fn every_limit_has_a_name_of_its_own_its_kind_and_a_meaning() {
    let mut names = BTreeSet::new();
    for limit in limits::all() {
        assert!(names.insert(limit.id), "{} stands twice", limit.id);
        let (kind, quantity) = limit.id.split_once('.').unwrap();
        assert!(!kind.is_empty() && !quantity.contains('.') && !limit.meaning.is_empty(), "{}", limit.id);
        assert!(!limit.value.is_nan() && limit.allows(limit.value, limit.value), "{}", limit.id);
        assert!(!limit.allows(f64::NAN, limit.value), "{}", limit.id);
        // One that is off until a document gives it.
        assert_eq!(limit.value.is_finite(), limit.id != "sweep.held_fraction", "{}", limit.id);
    }
}

#[test]
fn an_unknown_limit_names_those_of_its_kind() {
    let error = RunLimits::default().with("flight.altitud_m", 1.0).unwrap_err().to_string();
    assert!(error.contains("flight.altitud_m") && error.contains("flight.altitude_m"), "{error}");
    assert!(!error.contains("trim."), "{error}");
    assert!(RunLimits::default().with("nothing", 1.0).unwrap_err().known.contains("flight.altitude_m"));
}
