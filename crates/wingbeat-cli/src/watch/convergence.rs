//! A search or a fit while it converges.

use serde_json::json;
use wingbeat_report::panels::{CurveRole, PageCurve, PagePanel};
use wingbeat_report::run::{PlotAxis, ShownRun};

use super::{Watch, WatchArguments};
use crate::error::Error;

/// Starts that are shown: the last ones.
const STARTS: usize = 8;
/// Iterations of a start that are shown; of more, every second one.
const MOST: usize = 4000;

/// An iteration of a start.
pub struct SearchIteration {
    /// What it is a start of, and its number.
    pub series: String,
    /// What converges: name, unit, value in that unit.
    pub values: Vec<(String, &'static str, f64)>,
}

/// The iterations of a start.
struct StartSeries {
    name: String,
    iterations: Vec<f64>,
    columns: Vec<(String, &'static str, Vec<f64>)>,
    /// Its number among all, and the iterations that came.
    number: usize,
    count: usize,
    every: usize,
}

/// Begins to watch the search or fit `name`, which is told as `kind`, where it is wanted.
pub struct ConvergenceWatch(Option<Watch<SearchIteration>>);

impl ConvergenceWatch {
    /// Begins where it is wanted.
    ///
    /// # Errors
    /// Those of [`Watch::begin`].
    pub fn begin(
        live: &WatchArguments,
        name: &str,
        kind: &'static str,
        settings: &str,
    ) -> Result<Self, Error> {
        let (name, settings) = (name.to_owned(), settings.to_owned());
        let watch = Watch::begin(live, move |painter| {
            let take = |starts: &mut Vec<StartSeries>, news: Vec<SearchIteration>| {
                news.into_iter().for_each(|point| add(starts, point));
            };
            painter.run(Vec::new(), take, |starts, runs| {
                let mut now: Vec<ShownRun> =
                    starts.iter().map(|series| series.run(&name, kind, &settings)).collect();
                if now.is_empty() {
                    let axis = PlotAxis { label: "iteration", unit: "", values: Vec::new(), joined: true };
                    now.push(ShownRun { settings: settings.clone(), ..ShownRun::blank(&name, kind, axis) });
                }
                let earlier = std::mem::replace(runs, now);
                runs.len() == earlier.len()
                    && runs.iter().zip(&earlier).all(|(now, then)| now.continues(then))
            });
        })?;
        Ok(Self(watch))
    }

    /// Shows an iteration.
    pub fn see(&self, point: impl FnOnce() -> SearchIteration) {
        if let Some(watch) = &self.0 {
            watch.tell(point());
        }
    }

    /// Says that it is over.
    pub fn end(&self) {
        self.0.iter().for_each(Watch::end);
    }
}

/// Adds an iteration to its start, the last one, or a new one.
fn add(starts: &mut Vec<StartSeries>, SearchIteration { series, values }: SearchIteration) {
    if starts.last().is_none_or(|last| last.name != series) {
        let number = starts.last().map_or(0, |last| last.number + 1);
        if starts.len() == STARTS {
            starts.remove(0);
        }
        let columns = values.iter().map(|(name, unit, _)| (name.clone(), *unit, Vec::new())).collect();
        starts.push(StartSeries {
            name: series,
            iterations: Vec::new(),
            columns,
            number,
            count: 0,
            every: 1,
        });
    }
    if let Some(last) = starts.last_mut() {
        last.add(&values);
    }
}

impl StartSeries {
    fn add(&mut self, values: &[(String, &'static str, f64)]) {
        self.count += 1;
        if !self.count.is_multiple_of(self.every) {
            return;
        }
        self.iterations.push(self.count as f64);
        for ((_, _, column), (_, _, value)) in self.columns.iter_mut().zip(values) {
            column.push(*value);
        }
        if self.iterations.len() >= MOST {
            self.every *= 2;
            let mut k = 0;
            let mut second = |_: &f64| {
                k += 1;
                k % 2 == 0
            };
            self.iterations.retain(&mut second);
            for (_, _, column) in &mut self.columns {
                let mut k = 0;
                column.retain(|_| {
                    k += 1;
                    k % 2 == 0
                });
            }
        }
    }

    fn run(&self, name: &str, kind: &'static str, settings: &str) -> ShownRun {
        let axis = PlotAxis { label: "iteration", unit: "", values: self.iterations.clone(), joined: true };
        let panel = |(title, unit, values): &(String, &'static str, Vec<f64>)| PagePanel {
            title: title.clone(),
            unit,
            curves: vec![PageCurve {
                label: String::new(),
                role: CurveRole::Own(self.number),
                values: values.clone(),
            }],
            limits: None,
        };
        let last = self.columns.iter().map(|(title, _, values)| (title.clone(), json!(values.last())));
        let mut summary: serde_json::Map<String, serde_json::Value> = last.collect();
        summary.insert("iteration".into(), json!(self.count));
        ShownRun {
            summary: summary.into(),
            settings: settings.into(),
            panels: self.columns.iter().map(panel).collect(),
            ..ShownRun::blank(&format!("{name}, {}", self.name), kind, axis)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_starts_are_kept_and_long_ones_thinned() {
        let mut starts = Vec::new();
        for start in 0..12 {
            for k in 0..5 {
                let values = vec![("cost".into(), "", f64::from(k))];
                add(&mut starts, SearchIteration { series: format!("start {start}"), values });
            }
        }
        let names: Vec<&str> = starts.iter().map(|series| series.name.as_str()).collect();
        assert_eq!((names[0], names[7], names.len()), ("start 4", "start 11", 8));
        for k in 0..20_000 {
            let values = vec![("cost".into(), "", f64::from(k))];
            add(&mut starts, SearchIteration { series: "start 11".into(), values });
        }
        let run = starts[7].run("fit", "fit under way", "");
        let curve = &run.panels[0].curves[0].values;
        assert!(curve.len() == run.axis.values.len() && curve.len() < MOST, "{}", curve.len());
        let (last, count) = (run.axis.values[curve.len() - 1], starts[7].count as f64);
        assert!(count - last <= starts[7].every as f64 && curve[curve.len() - 1] == last - 6.0, "{last}");
    }
}
