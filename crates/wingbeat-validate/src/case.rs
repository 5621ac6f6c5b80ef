//! A compared number, the case that computes it, and the running of many.

use std::ops::ControlFlow;
use std::panic::AssertUnwindSafe;

use wingbeat::parallel;

use crate::Error;

/// One compared number.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonRow {
    /// Stable name, e.g. `aero.wagner_limit`.
    pub id: String,
    /// Where the number compared with comes from.
    pub source: String,
    /// What `value` is, e.g. `max error of the humerus angle`.
    pub metric: String,
    /// Distance from the source, in `unit`: the smaller, the better.
    pub value: f64,
    /// Largest value that passes, in `unit`; none for a number shown without a judgement.
    pub limit: Option<f64>,
    /// Unit of `value` and `limit`; empty when dimensionless.
    pub unit: &'static str,
}

impl ComparisonRow {
    /// A number that passes when it is at most `limit`, both in `unit`.
    pub fn judged(id: &str, source: &str, metric: &str, value: f64, limit: f64, unit: &'static str) -> Self {
        Self { limit: Some(limit), ..Self::shown(id, source, metric, value, unit) }
    }

    /// A number, in `unit`, printed without a judgement.
    pub fn shown(id: &str, source: &str, metric: &str, value: f64, unit: &'static str) -> Self {
        Self { id: id.into(), source: source.into(), metric: metric.into(), value, limit: None, unit }
    }

    /// An observed order of convergence, dimensionless: value = |observed - expected|.
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
    pub run: fn() -> Result<Vec<ComparisonRow>, Error>,
}

/// A comparison of many runs, which shares them among the cores itself.
#[derive(Debug)]
pub struct LongCase {
    /// Stable name, as that of a [`Case`].
    pub id: &'static str,
    /// Processor time that it takes, min, as measured: what is told before it is run.
    pub core_minutes: f64,
    /// Computes the rows; none where it was ended.
    pub run: fn(&mut CaseWatch<'_>) -> Result<Vec<ComparisonRow>, Error>,
}

/// Hears how many runs of how many are done, and may end them.
pub type CaseWatch<'a> = dyn FnMut(usize, usize) -> ControlFlow<()> + 'a;

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

    fn keeps_row(&self, row: &ComparisonRow) -> bool {
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
    mut show: impl FnMut(&[ComparisonRow]) -> ControlFlow<()>,
) -> Vec<ComparisonRow> {
    let mut done: Vec<Option<Vec<ComparisonRow>>> = vec![None; cases.len()];
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
    mut show: impl FnMut(&[ComparisonRow]),
) -> Vec<ComparisonRow> {
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

fn rows_of(case: &Case, selection: &Selection) -> Vec<ComparisonRow> {
    kept(case.id, selection, case.run)
}

/// The wanted rows of the case `id`, or the one that says why there are none.
fn kept(
    id: &str,
    selection: &Selection,
    run: impl FnOnce() -> Result<Vec<ComparisonRow>, Error>,
) -> Vec<ComparisonRow> {
    let mut rows = match std::panic::catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(rows)) => rows,
        Ok(Err(error)) => return vec![ComparisonRow::failed(id, &error)],
        Err(_) => return vec![ComparisonRow::failed(id, &Error::Panicked)],
    };
    let own = |i: usize| below(&rows[i].id, id) && rows[..i].iter().all(|row| row.id != rows[i].id);
    if !(0..rows.len()).all(own) {
        return vec![ComparisonRow::failed(id, &Error::Ids)];
    }
    rows.retain(|row| selection.keeps_row(row));
    rows
}
