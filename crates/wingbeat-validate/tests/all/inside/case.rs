use std::ops::ControlFlow;

use wingbeat_validate::*;

const GOOD: Case = Case {
    id: "a.good",
    quick: true,
    run: || {
        Ok(vec![
            ComparisonRow::judged("a.good.x", "s", "m", 1.0, 2.0, ""),
            ComparisonRow::shown("a.good.y", "s", "m", 9.0, ""),
        ])
    },
};
const BAD: Case =
    Case { id: "a.bad", quick: false, run: || Err(Error::reference("f.csv", "line 3: not a number")) };
const PANIC: Case = Case { id: "b", quick: true, run: || panic!("broken") };

#[test]
fn limits_judge_and_missing_limits_do_not() {
    assert!(ComparisonRow::judged("i", "s", "m", 1.0, 1.0, "").passes());
    assert!(!ComparisonRow::judged("i", "s", "m", f64::NAN, 1.0, "").passes());
    assert!(ComparisonRow::shown("i", "s", "m", 1e9, "").passes());
    assert!(!ComparisonRow::order("i", "s", 3.7, 4.0, 0.2).passes());
}

#[test]
fn selection_goes_by_dotted_names() {
    let all = [&GOOD, &BAD, &PANIC];
    let ids = |only: Option<&str>, quick| {
        let selection = Selection { only: only.map(Into::into), quick };
        select(&all, &selection).iter().map(|case| case.id).collect::<Vec<_>>()
    };
    assert_eq!(ids(None, false), ["a.good", "a.bad", "b"]);
    assert_eq!(ids(None, true), ["a.good", "b"]);
    assert_eq!(ids(Some("a"), false), ["a.good", "a.bad"]);
    assert_eq!(ids(Some("a.good.y"), false), ["a.good"]);
    assert!(ids(Some("a.go"), false).is_empty());
}

#[test]
fn rows_come_in_order_and_failures_are_rows() {
    let all = [&GOOD, &BAD, &PANIC];
    let mut seen = 0;
    let rows = run(&all, &Selection::default(), |rows| {
        seen += rows.len();
        ControlFlow::Continue(())
    });
    assert_eq!(
        rows.iter().map(|row| row.id.as_str()).collect::<Vec<_>>(),
        ["a.good.x", "a.good.y", "a.bad", "b"]
    );
    assert_eq!(seen, 4);
    assert_eq!(rows.iter().filter(|row| !row.passes()).count(), 2);
}

#[test]
fn long_cases_tell_how_far_they_are_and_end_when_told_to() {
    const LONG: LongCase = LongCase {
        id: "c.long",
        core_minutes: 1.0,
        run: |watch| match (0..3).try_for_each(|done| watch(done + 1, 3)) {
            ControlFlow::Continue(()) => Ok(vec![ComparisonRow::shown("c.long.x", "s", "m", 1.0, "")]),
            ControlFlow::Break(()) => Ok(Vec::new()),
        },
    };
    let selection = Selection { only: Some("c".into()), quick: false };
    let cases = select_long(&[&LONG], &selection);
    let mut heard = Vec::new();
    let all = |id: &str, done, of| {
        heard.push((id.to_owned(), done, of));
        ControlFlow::Continue(())
    };
    assert_eq!(run_long(&cases, &selection, all, |rows| assert_eq!(rows.len(), 1)).len(), 1);
    assert_eq!(heard.last(), Some(&("c.long".to_owned(), 3, 3)));
    let at_once = |_: &str, _, _| ControlFlow::Break(());
    assert!(run_long(&[&LONG, &LONG], &selection, at_once, |_| panic!("no rows")).is_empty());
    assert!(select_long(&[&LONG], &Selection { only: None, quick: true }).is_empty());
}

#[test]
fn a_break_ends_the_running() {
    let mut seen = 0;
    let rows = run(&[&GOOD, &BAD, &GOOD, &BAD], &Selection::default(), |_| {
        seen += 1;
        ControlFlow::Break(())
    });
    assert_eq!((rows.len(), seen), (0, 1));
}

#[test]
fn two_rows_of_one_id_are_refused() {
    let twice = || {
        Ok(vec![ComparisonRow::shown("c", "s", "m", 1.0, ""), ComparisonRow::shown("c", "s", "n", 1.0, "")])
    };
    let rows = run(&[&Case { id: "c", quick: true, run: twice }], &Selection::default(), |_| {
        ControlFlow::Continue(())
    });
    assert_eq!((rows.len(), rows[0].passes()), (1, false));
}

#[test]
fn one_row_of_a_case_can_be_chosen() {
    let selection = Selection { only: Some("a.good.y".into()), quick: false };
    let rows = run(&[&GOOD], &selection, |_| ControlFlow::Continue(()));
    assert_eq!(rows.len(), 1);
}
