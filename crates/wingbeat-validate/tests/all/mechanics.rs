//! The rows of mathematics and mechanics pass, each by itself.

use std::ops::ControlFlow;

use wingbeat_validate::{Selection, cases, run, select};

fn assert_passing(only: &str, rows_expected: usize) {
    let (all, selection) = (cases(), Selection { only: Some(only.into()), quick: false });
    let rows = run(&select(&all, &selection), &selection, |_| ControlFlow::Continue(()));
    assert_eq!(rows.len(), rows_expected, "{only}");
    for row in rows {
        assert!(row.passes(), "{row:?}");
    }
}

#[test]
fn linkage_and_bodies_agree() {
    assert_passing("linkage", 1);
    assert_passing("body", 7);
    assert_passing("fsi", 10);
}

#[test]
fn periodic_flights_close_and_hold_as_their_multipliers_say() {
    assert_passing("trim", 142);
}

#[test]
fn a_turn_at_15_deg_keeps_its_height_and_its_bank() {
    assert_passing("flight.bank15_20g", 5);
}

#[test]
fn a_turn_at_45_deg_by_a_plan_keeps_its_height_and_its_bank() {
    assert_passing("flight.predictive_20g", 5);
}

#[test]
fn a_turn_by_instruments_and_a_hover_keep_what_is_asked() {
    assert_passing("flight.estimator", 12);
    assert_passing("flight.hover_guarded", 5);
}

#[test]
fn numbers_and_integration_agree() {
    assert_passing("math", 2);
}
