//! A compared number, the case that computes it, and the running of many.

use std::ops::ControlFlow;
use std::panic::AssertUnwindSafe;

use wingbeat::parallel;

use crate::Error;

/// One compared number.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Stable name, e.g. `aero.wagner_limit`.
    pub id: String,
    /// Where the number compared with comes from.
    pub source: String,
    /// What `value` is, e.g. `max error of the humerus angle`.
    pub metric: String,
    /// Distance from the source: the smaller, the better.
    pub value: f64,
    /// Largest value that passes; none for a number shown without a judgement.
    pub limit: Option<f64>,
    /// Unit of `value` and `limit`; empty when dimensionless.
    pub unit: &'static str,
}

impl Row {
    /// A number that passes when it is at most `limit`.
    pub fn judged(id: &str, source: &str, metric: &str, value: f64, limit: f64, unit: &'static str) -> Self {
        Self { limit: Some(limit), ..Self::shown(id, source, metric, value, unit) }
    }

    /// A number printed without a judgement.
    pub fn shown(id: &str, source: &str, metric: &str, value: f64, unit: &'static str) -> Self {
        Self { id: id.into(), source: source.into(), metric: metric.into(), value, limit: None, unit }
    }

    /// An observed order of convergence: value = |observed - expected|.
    pub fn order(id: &str, source: &str, observed: f64, expected: f64, tolerance: f64) -> Self {
        let metric = format!("|observed order {observed:.3} - {expected}|");
        Self::judged(id, source, &metric, (observed - expected).abs(), tolerance, "")
    }

    /// The row that stands for a case that could not be computed.
    fn failed(id: &str, error: &Error) -> Self {
        Self::judged(id, "-", &format!("not computed: {error}"), f64::NAN, 0.0, "")
    }

    /// True unless the value is above its limit or not a number.
    pub fn passes(&self) -> bool {
        self.limit.is_none_or(|limit| self.value <= limit)
    }
}

/// A comparison: its function runs the model and returns one row per number.
///
/// The rows' ids are the case's id, or start with it and a dot; no two are the same.
#[derive(Debug)]
pub struct Case {
    /// Stable name, e.g. `linkage.cycle`.
    pub id: &'static str,
    /// True when it takes a second or less.
    pub quick: bool,
    /// Computes the rows.
    pub run: fn() -> Result<Vec<Row>, Error>,
}

/// A comparison of many runs, which shares them among the cores itself.
#[derive(Debug)]
pub struct LongCase {
    /// Stable name, as that of a [`Case`].
    pub id: &'static str,
    /// Processor time that it takes, min, as measured: what is told before it is run.
    pub core_minutes: f64,
    /// Computes the rows; none where it was ended.
    pub run: fn(&mut Watch<'_>) -> Result<Vec<Row>, Error>,
}

/// Hears how many runs of how many are done, and may end them.
pub type Watch<'a> = dyn FnMut(usize, usize) -> ControlFlow<()> + 'a;

/// Which rows are wanted.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// An id, or the part of ids before a dot: `aero` selects `aero.wagner_limit`.
    pub only: Option<String>,
    /// Only quick cases.
    pub quick: bool,
}

impl Selection {
    fn keeps_case(&self, id: &str, quick: bool) -> bool {
        let named = self.only.as_deref().is_none_or(|only| below(id, only) || below(only, id));
        named && (quick || !self.quick)
    }

    fn keeps_row(&self, row: &Row) -> bool {
        self.only.as_deref().is_none_or(|only| below(&row.id, only))
    }
}

/// True when `id` is `prefix` or starts with `prefix.`.
pub fn below(id: &str, prefix: &str) -> bool {
    id.strip_prefix(prefix).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// The cases of `all` that `selection` wants.
pub fn select<'a>(all: &[&'a Case], selection: &Selection) -> Vec<&'a Case> {
    all.iter().copied().filter(|case| selection.keeps_case(case.id, case.quick)).collect()
}

/// The long cases of `all` that `selection` wants.
pub fn select_long<'a>(all: &[&'a LongCase], selection: &Selection) -> Vec<&'a LongCase> {
    all.iter().copied().filter(|case| selection.keeps_case(case.id, false)).collect()
}

/// Runs `cases` on all cores and hands each case's rows to `show` in the order of `cases`, until it breaks.
pub fn run(
    cases: &[&Case],
    selection: &Selection,
    mut show: impl FnMut(&[Row]) -> ControlFlow<()>,
) -> Vec<Row> {
    let mut done: Vec<Option<Vec<Row>>> = vec![None; cases.len()];
    let (mut shown, mut front) = (Vec::new(), 0);
    parallel::each(
        cases,
        |_, case| rows_of(case, selection),
        |index, rows| {
            done[index] = Some(rows);
            while let Some(rows) = done.get_mut(front).and_then(Option::take) {
                show(&rows)?;
                shown.extend(rows);
                front += 1;
            }
            ControlFlow::Continue(())
        },
    );
    shown
}

/// Runs long cases one after another; `told` hears the case's name and how many of its runs are done, and may end them all, `show` gets
/// the rows of each.
pub fn run_long(
    cases: &[&LongCase],
    selection: &Selection,
    mut told: impl FnMut(&str, usize, usize) -> ControlFlow<()>,
    mut show: impl FnMut(&[Row]),
) -> Vec<Row> {
    let mut shown = Vec::new();
    for case in cases {
        let mut ended = false;
        let rows = kept(case.id, selection, || {
            (case.run)(&mut |done, all| {
                let flow = told(case.id, done, all);
                ended |= flow.is_break();
                flow
            })
        });
        if ended {
            break;
        }
        show(&rows);
        shown.extend(rows);
    }
    shown
}

fn rows_of(case: &Case, selection: &Selection) -> Vec<Row> {
    kept(case.id, selection, case.run)
}

/// The wanted rows of the case `id`, or the one that says why there are none.
fn kept(id: &str, selection: &Selection, run: impl FnOnce() -> Result<Vec<Row>, Error>) -> Vec<Row> {
    let mut rows = match std::panic::catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(rows)) => rows,
        Ok(Err(error)) => return vec![Row::failed(id, &error)],
        Err(_) => return vec![Row::failed(id, &Error::Panicked)],
    };
    let own = |i: usize| below(&rows[i].id, id) && rows[..i].iter().all(|row| row.id != rows[i].id);
    if !(0..rows.len()).all(own) {
        return vec![Row::failed(id, &Error::Ids)];
    }
    rows.retain(|row| selection.keeps_row(row));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: Case = Case {
        id: "a.good",
        quick: true,
        run: || {
            Ok(vec![
                Row::judged("a.good.x", "s", "m", 1.0, 2.0, ""),
                Row::shown("a.good.y", "s", "m", 9.0, ""),
            ])
        },
    };
    const BAD: Case =
        Case { id: "a.bad", quick: false, run: || Err(Error::reference("f.csv", "line 3: not a number")) };
    const PANIC: Case = Case { id: "b", quick: true, run: || panic!("broken") };

    #[test]
    fn limits_judge_and_missing_limits_do_not() {
        assert!(Row::judged("i", "s", "m", 1.0, 1.0, "").passes());
        assert!(!Row::judged("i", "s", "m", f64::NAN, 1.0, "").passes());
        assert!(Row::shown("i", "s", "m", 1e9, "").passes());
        assert!(!Row::order("i", "s", 3.7, 4.0, 0.2).passes());
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
                ControlFlow::Continue(()) => Ok(vec![Row::shown("c.long.x", "s", "m", 1.0, "")]),
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
        let twice = || Ok(vec![Row::shown("c", "s", "m", 1.0, ""), Row::shown("c", "s", "n", 1.0, "")]);
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
}
