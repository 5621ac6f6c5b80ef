//! The verdict on a sweep.

use super::sweep_spec::{Draw, Sampling};
use super::{Sweep, SweepOf};
use std::collections::BTreeMap;
use wingbeat_flight::simulate::Record;
use wingbeat_judge::limits::sweep;
use wingbeat_judge::{Judge, Status, Verdict, Warning};

/// How many runs ended how.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepCounts {
    /// Runs of the sweep.
    pub runs: usize,
    /// Those that were carried out to their end: what tables and figures are of.
    pub completed: usize,
    /// Those of them whose own verdict lets them be used: what was asked may be missed.
    pub usable: usize,
    /// Completed runs that carry warnings.
    pub warned: usize,
    /// Runs by the status of their own verdict.
    pub statuses: BTreeMap<&'static str, usize>,
}

/// The status that a number of the column `status` stands for.
pub(super) fn status(number: f64) -> Option<Status> {
    Status::ALL.into_iter().enumerate().find(|(place, _)| *place as f64 == number).map(|(_, status)| status)
}

impl SweepCounts {
    /// Of the rows of a sweep.
    pub fn new(record: &Record) -> Self {
        let column = |name: &str| record.values(name).unwrap_or_default();
        let statuses: Vec<Status> = column("status").iter().filter_map(|number| status(*number)).collect();
        let mut counts = Self {
            runs: record.rows(),
            completed: column("completed").iter().filter(|done| **done == 1.0).count(),
            usable: Self::usable_rows(record).len(),
            warned: column("warnings")
                .iter()
                .zip(column("completed"))
                .filter(|(n, done)| **n > 0.0 && **done == 1.0)
                .count(),
            statuses: BTreeMap::new(),
        };
        statuses.iter().for_each(|status| *counts.statuses.entry(status.name()).or_default() += 1);
        counts
    }

    /// Rows of the completed runs whose own verdict lets them be used, missed goals among them.
    pub fn usable_rows(record: &Record) -> Vec<usize> {
        let column = |name: &str| record.values(name).unwrap_or_default();
        let rows = column("completed").iter().zip(column("status")).enumerate();
        let usable = |(done, number): (&f64, &f64)| {
            *done == 1.0 && status(*number).is_some_and(|status| status <= Status::OffTarget)
        };
        rows.filter(|(_, row)| usable(*row)).map(|(row, _)| row).collect()
    }

    /// In words, the best first: "20 ok, 3 off_target, 1 failed".
    pub fn words(&self) -> String {
        let of = |status: &Status| Some(format!("{} {}", self.statuses.get(status.name())?, status.name()));
        Status::ALL.iter().filter_map(of).collect::<Vec<_>>().join(", ")
    }
}

impl Sweep {
    /// Holds the runs of a sweep, a row each, against its limits.
    pub fn verdict(&self, record: &Record) -> Verdict {
        let counts = SweepCounts::new(record);
        let share = |part: usize, whole: usize| part as f64 / whole.max(1) as f64;
        let mut judge = Judge::new(&self.limits);
        if let Some(search) = &self.spec.search {
            self.judge_search(search, record, &mut judge);
            self.of_fits().into_iter().chain(self.given_twice()).for_each(|warning| judge.warn(warning));
            return judge.verdict();
        }
        if counts.completed == 0 {
            judge.find(Status::Failed, "no run was carried out to its end");
        }
        judge.hold(&sweep::COMPLETED, share(counts.completed, counts.runs));
        judge.hold(&sweep::FAILED, share(counts.runs - counts.completed, counts.runs));
        if counts.completed > 0 {
            judge.hold(&sweep::WARNED, share(counts.warned, counts.completed));
            let unjudged = counts.statuses.get(Status::NotJudged.name()).copied().unwrap_or_default();
            judge.hold(&sweep::UNJUDGED, share(unjudged, counts.completed));
        }
        if counts.completed > 0 {
            judge.hold(&sweep::USABLE, share(counts.usable, counts.completed));
            judge.hold(&sweep::SOME, counts.usable as f64);
        }
        if matches!(self.of, SweepOf::Flights(_)) {
            let held = record.values("held").unwrap_or_default();
            let windowless = held.iter().filter(|held| held.is_nan()).count();
            judge.hold(&sweep::WINDOWLESS, share(windowless, counts.runs));
            let held = held.iter().filter(|held| **held == 1.0).count();
            judge.hold(&sweep::HELD, share(held, counts.runs));
        }
        let in_vain = self.given_twice().into_iter().chain(self.unheard(record)).chain(self.alike(record));
        self.of_fits().into_iter().chain(in_vain).for_each(|warning| judge.warn(warning));
        judge.verdict()
    }

    /// Whether all runs, of which `record` has a row each, have the same results to the last digit: then they are one run made several times, and
    /// no sample.
    pub fn all_alike(&self, record: &Record) -> bool {
        let results = self.of.measures();
        let same = |(name, _): &(&str, &str)| {
            let values = record.values(name).unwrap_or_default();
            values.iter().all(|value| *value == values[0] || value.is_nan() && values[0].is_nan())
        };
        record.rows() > 1 && results.iter().all(same)
    }

    /// The warning that the flights of a sample, of which one was carried out to its end, are one flight.
    fn alike(&self, record: &Record) -> Option<Warning> {
        let flown = record.values("completed").unwrap_or_default().contains(&1.0);
        let sample = matches!(self.of, SweepOf::Flights(_)) && self.spec.sampling != Sampling::Grid;
        let text = format!(
            "all {} flights agree to the last digit and count as one: the share held has no confidence interval (draw what acts on the flight)",
            record.rows()
        );
        let warning = || Warning::new("sweep.alike", text).size(record.rows() as f64).key("draws");
        (flown && sample && self.all_alike(record)).then(warning)
    }

    /// The warnings that a draw changes no result: runs that differ in it alone agree to the last digit. `record` has a row for each run.
    fn unheard(&self, record: &Record) -> Vec<Warning> {
        let column = |name: &str| record.values(name).unwrap_or_default();
        let completed: Vec<usize> = column("completed")
            .iter()
            .enumerate()
            .filter(|(_, done)| **done == 1.0)
            .map(|(k, _)| k)
            .collect();
        let results: Vec<&[f64]> =
            self.of.measures().iter().map(|(name, _)| column(name)).filter(|of| !of.is_empty()).collect();
        let draws: Vec<&[f64]> = self.draws().iter().map(|draw| column(&draw.key)).collect();
        let bits =
            |columns: &[&[f64]], row: usize| columns.iter().map(|of| of[row].to_bits()).collect::<Vec<_>>();
        let agree =
            |a: usize, b: usize| results.iter().all(|of| of[a] == of[b] || of[a].is_nan() && of[b].is_nan());
        // Where no result differs anywhere, none of the draws does anything, however many differ at once.
        let all_agree = completed.iter().all(|row| agree(completed[0], *row));
        let told = |(k, draw): (usize, &Draw)| {
            let own = draws[k];
            if all_agree {
                let other = completed.iter().filter(|row| own[**row] != own[completed[0]]).count();
                return in_vain(self.place(k), draw, other);
            }
            let others: Vec<&[f64]> =
                draws.iter().enumerate().filter(|(o, _)| *o != k).map(|(_, of)| *of).collect();
            let mut alone: BTreeMap<Vec<u64>, Vec<usize>> = BTreeMap::new();
            completed.iter().for_each(|row| alone.entry(bits(&others, *row)).or_default().push(*row));
            let mut compared = 0;
            for rows in alone.values() {
                let first = rows[0];
                let other: Vec<usize> = rows.iter().copied().filter(|row| own[*row] != own[first]).collect();
                if !other.iter().all(|row| agree(first, *row)) {
                    return None;
                }
                compared += other.len();
            }
            in_vain(self.place(k), draw, compared)
        };
        self.draws().iter().enumerate().filter_map(told).collect()
    }
}

/// The warning that draw number `k` changes no result, as so many runs show that have another value of it; none without such.
fn in_vain(k: usize, draw: &Draw, runs: usize) -> Option<Warning> {
    let text = format!(
        "{} changes no result: {runs} runs have to the last digit those of ones with another value of it and nothing else that acts",
        draw.key
    );
    (runs > 0).then(|| Warning::new("sweep.unheard", text).size(runs as f64).key(format!("draws[{k}].key")))
}
