//! A recording's raw logs as one record, and the account of it.

use std::path::Path;
use std::time::Duration;

use serde::Serialize;
use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::netft::{APART_S, Account, BOX_RATE, Scale};
use wingbeat::simulate::{Column, Record};
use wingbeat_io::ParquetWriter;
use wingbeat_judge::limits::recording;
use wingbeat_judge::{Judge, RunLimits, Status, Verdict};
use wingbeat_netft::{Config, ROW_BYTES, RecordingEnd, Report, Row, Timeline, logs, read_log};

use super::faults::{self, Signs};
use crate::error::Error;
use crate::run_folder::RunFolder;

/// Name that the raw logs begin with.
pub const RAW: &str = "raw";
/// Rows in memory at once.
const PART: usize = 1 << 16;

/// The account of a recording. Counts of records are of all its raw logs, other counts of the last start.
#[derive(Debug, Serialize)]
pub struct RecordingSummary {
    /// Whether it can be used, and what that rests on.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// Begin and end, s.
    pub window_s: (f64, f64),
    /// Records written.
    pub records: u64,
    /// Records that never came.
    pub lost: u64,
    /// Places where some are missing.
    pub gaps: u64,
    /// Records missing in the longest of them.
    pub longest_gap: u64,
    /// Records that came after later ones.
    pub reordered: u64,
    /// Streams begun anew.
    pub restarts: u64,
    /// Records between one stream and the next, by the box's count or by the clock.
    pub unsent: u64,
    /// Restarts of the box, before which what was missed is known by the clock alone.
    pub reboots: u64,
    /// Leaps of the box's numbers.
    pub jumps: u64,
    /// Records with a warning status.
    pub status_warnings: u64,
    /// Records with a saturated channel.
    pub saturated: u64,
    /// Records with a serious status.
    pub serious: u64,
    /// Records that came again.
    pub duplicates: u64,
    /// Datagrams that are no records.
    pub malformed: u64,
    /// Times that the box fell silent.
    pub stalls: u64,
    /// Longest time between two datagrams, s.
    pub longest_silence_s: f64,
    /// Datagrams that the kernel threw away.
    pub kernel_drops: u64,
    /// Receive buffer, bytes.
    pub buffer_bytes: usize,
    /// Samples per second by the kernel's clock.
    pub rate_hz: f64,
    /// What the clock says of all that.
    pub by_clock: ByClock,
    /// Spread of arrival, s.
    pub jitter_s: f64,
    /// Largest mean load right after the bias, N or N m.
    pub bias_residual: Option<f64>,
    /// Raw logs.
    pub logs: usize,
}

/// Wall clock times rate, against what was recorded or booked as missing.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ByClock {
    /// Samples per second that the box states, or else makes by its own numbers.
    pub stated_rate_hz: f64,
    /// From asking for records to the end, s; of a recording that went on, from its first record on.
    pub wall_s: f64,
    /// Time without a record at the end, s.
    pub tail_s: f64,
    /// Number of records that this rate makes in this time.
    pub expected: f64,
    /// Number of those that are neither recorded nor booked as missing; negative when there are too many.
    pub unaccounted: f64,
}

/// Part of a recording, and time at least, s, by which clock and count may differ: what a host delays. *Choice.*
const FORGIVEN: f64 = 0.05;
const LEAST_S: f64 = 0.1;
/// Time for which a rate must be seen to be judged.
const SEEN: Duration = Duration::from_millis(200);

impl ByClock {
    /// Of a recording whose records came over `span` seconds, `whole` when the last start made all of it.
    fn of(report: &Report, account: &Account, stated: Option<f64>, span: f64, whole: bool) -> Self {
        let rate = stated.or(account.rate()).unwrap_or(BOX_RATE);
        let (head, tail_s) = (if whole { report.head } else { Duration::ZERO }, report.tail.as_secs_f64());
        let wall_s = head.as_secs_f64() + span + tail_s;
        let expected = rate * wall_s;
        let unaccounted = expected - account.booked() as f64;
        Self { stated_rate_hz: rate, wall_s, tail_s, expected, unaccounted }
    }

    /// Holds it against the limits.
    fn judge(&self, report: &Report, judge: &mut Judge) {
        let Self { stated_rate_hz, wall_s, tail_s, expected, unaccounted } = *self;
        let told = judge.hold(&recording::SILENT_END, tail_s);
        if report.ending == RecordingEnd::Silent && told {
            judge.find(Status::Failed, format!("the box stopped sending {tail_s:.1} s before the end"));
        }
        let there = expected - unaccounted;
        let about = format!(
            "({expected:.0} should be there by the clock, {stated_rate_hz} Hz over {wall_s:.2} s, and {there:.0} are)"
        );
        let forgiven = (FORGIVEN * wall_s).clamp(LEAST_S, APART_S) * stated_rate_hz;
        let beyond = (unaccounted.abs() - forgiven).max(0.0) / expected.max(1.0);
        judge.hold_about(&recording::UNACCOUNTED, beyond, &about);
        if report.rate_span >= SEEN && report.rate_hz > 0.0 {
            let rate = report.rate_hz;
            let about =
                format!("(records came at {rate:.0} Hz by the clock; the box states {stated_rate_hz} Hz)");
            judge.hold_about(&recording::RATE, (rate / stated_rate_hz - 1.0).abs(), &about);
        }
    }
}

/// Rows in the raw logs of `folder`.
pub fn rows(folder: &Path) -> Result<u64, Error> {
    let logs = logs(folder, RAW).map_err(input)?;
    Ok(logs.iter().map(|log| log.metadata().map_or(0, |data| data.len() / ROW_BYTES as u64)).sum())
}

fn input(error: wingbeat_netft::Error) -> Error {
    Error::Input(error.to_string())
}

/// Writes all raw logs of `folder` as record.parquet and gives account of them.
pub fn write(folder: &RunFolder, report: &Report, config: &Config) -> Result<RecordingSummary, Error> {
    let empty = || Record::new(columns(), PART);
    let mut file = ParquetWriter::create(&folder.file("record.parquet"), &empty()?)?;
    let (mut part, mut account, mut line) = (empty()?, Account::default(), Timeline::default());
    let mut signs = Signs::default();
    let mut first: Option<Row> = None;
    let (mut begin, mut end, mut last_ns) = (0.0_f64, 0.0_f64, 0);
    let logs = logs(folder.partial(), RAW).map_err(input)?;
    for log in &logs {
        for row in read_log(log).map_err(input)? {
            let row = row.map_err(input)?;
            account.take_new(&row.record, row.arrival_ns());
            signs.see(&row);
            last_ns = last_ns.max(row.arrival_ns());
            let t = line.time(&row);
            (begin, end) = (begin.min(t), end.max(t));
            part.append(&cells(&row, t, first.get_or_insert(row), &config.scale));
            if part.rows() == PART {
                file.append(&part)?;
                part = empty()?;
            }
        }
    }
    file.append(&part)?;
    file.close()?;
    let span = first.map_or(0.0, |first| (last_ns as f64 - first.arrival_ns() as f64) * 1e-9);
    let whole = report.rows == account.received;
    let by_clock = ByClock::of(report, &account, config.rate_hz, span, whole);
    let verdict = verdict(report, &account, &by_clock, &signs);
    Ok(RecordingSummary::new(verdict, report, &account, by_clock, (begin, end), logs.len()))
}

/// The verdict on a recording: its counts, the clock and its loads.
fn verdict(report: &Report, account: &Account, by_clock: &ByClock, signs: &Signs) -> Verdict {
    let limits = RunLimits::default();
    let mut judge = Judge::new(&limits);
    by_clock.judge(report, &mut judge);
    faults::judge(account, &mut judge);
    faults::judge_stream(&report.account, &mut judge);
    signs.judge(account.received, &mut judge);
    judge.verdict()
}

/// The columns of a recording.
pub fn columns() -> Vec<Column> {
    let head = [
        ("t", "s"),
        ("t_kernel", "s"),
        ("t_host", "s"),
        ("rdt_sequence", ""),
        ("ft_sequence", ""),
        ("status", ""),
    ];
    let mut columns: Vec<Column> = head.map(|(name, unit)| Column::new(name, unit, "")).into();
    columns.extend(CHANNELS.map(|(name, unit)| Column::new(name, unit, "C")));
    columns.extend(CHANNELS.map(|(name, _)| Column::new(format!("counts_{name}"), "", "C")));
    columns
}

fn cells(row: &Row, t: f64, first: &Row, scale: &Scale) -> Vec<f64> {
    let seconds = |now: u64, then: u64| (now as i64 - then as i64) as f64 * 1e-9;
    let r = &row.record;
    let head = [
        t,
        seconds(row.kernel_ns, first.kernel_ns),
        seconds(row.host_ns, first.host_ns),
        f64::from(r.rdt_sequence),
        f64::from(r.ft_sequence),
        f64::from(r.status),
    ];
    head.into_iter().chain(scale.wrench(r.counts)).chain(r.counts.map(f64::from)).collect()
}

impl RecordingSummary {
    fn new(
        verdict: Verdict,
        report: &Report,
        account: &Account,
        by_clock: ByClock,
        window_s: (f64, f64),
        logs: usize,
    ) -> Self {
        Self {
            verdict,
            by_clock,
            jumps: account.jumps,
            window_s,
            records: account.received,
            lost: account.lost,
            gaps: account.gaps,
            longest_gap: account.longest_gap,
            reordered: account.reordered,
            restarts: account.restarts,
            unsent: account.unsent,
            reboots: account.reboots,
            status_warnings: account.warnings,
            saturated: account.saturated,
            serious: account.serious,
            duplicates: report.account.duplicates,
            malformed: report.account.malformed,
            stalls: report.stalls,
            longest_silence_s: report.longest_silence.as_secs_f64(),
            kernel_drops: report.kernel_drops,
            buffer_bytes: report.buffer_bytes,
            rate_hz: report.rate_hz,
            jitter_s: report.jitter_s,
            bias_residual: report.bias_residual,
            logs,
        }
    }

    /// The account in words.
    pub fn words(&self) -> String {
        let mut text = format!(
            "{} records, {} lost in {} gaps (longest {}), {} duplicates, {} late, {} malformed datagrams\n\
             status: {} warnings, {} saturated, {} serious\n\
             {} stalls, {} restarts of the stream ({} records between), {} restarts of the box, {} jumps\n\
             longest silence {:.1} ms, {} datagrams dropped by the kernel (buffer {} kB)\n\
             {:.2} samples/s by the kernel's clock, arrival spread {:.3} ms\n",
            self.records,
            self.lost,
            self.gaps,
            self.longest_gap,
            self.duplicates,
            self.reordered,
            self.malformed,
            self.status_warnings,
            self.saturated,
            self.serious,
            self.stalls,
            self.restarts,
            self.unsent,
            self.reboots,
            self.jumps,
            1e3 * self.longest_silence_s,
            self.kernel_drops,
            self.buffer_bytes / 1024,
            self.rate_hz,
            1e3 * self.jitter_s,
        );
        let ByClock { stated_rate_hz, wall_s, expected, unaccounted, .. } = self.by_clock;
        text += &format!(
            "{stated_rate_hz} Hz over {wall_s:.2} s make {expected:.0} records; {unaccounted:.0} are not accounted for\n"
        );
        if let Some(residual) = self.bias_residual {
            text += &format!("bias: largest mean load right after it {residual:.4} (N or N m)\n");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(rate_hz: f64, tail: f64) -> Report {
        Report {
            ending: RecordingEnd::Complete,
            account: Account::default(),
            stalls: 0,
            longest_silence: Duration::ZERO,
            kernel_drops: 0,
            buffer_bytes: 0,
            rate_hz,
            rate_span: Duration::from_secs(10),
            head: Duration::from_millis(10),
            tail: Duration::from_secs_f64(tail),
            jitter_s: 0.0,
            bias_residual: None,
            rows: 0,
            files: Vec::new(),
        }
    }

    /// Status of a recording of `seconds` with so many records of 7 kHz, none of them booked as missing.
    fn status(seconds: f64, records: u64, rate: f64, tail: f64) -> Status {
        let mut account = Account::default();
        account.received = records;
        let report = report(rate, tail);
        let limits = RunLimits::default();
        let mut judge = Judge::new(&limits);
        ByClock::of(&report, &account, Some(7000.0), seconds, true).judge(&report, &mut judge);
        judge.verdict().status
    }

    #[test]
    fn count_and_clock_agree_within_the_tolerance_stated() {
        assert_eq!(status(10.0, 70_000, 7000.0, 0.0), Status::Ok);
        // Half a second and 1 %: 3500 + 700.
        assert_eq!(status(10.0, 66_000, 7000.0, 0.0), Status::Ok);
        assert_eq!(status(10.0, 65_500, 7000.0, 0.0), Status::SuspectData);
        assert_eq!(status(10.0, 75_000, 7000.0, 0.0), Status::SuspectData);
        assert_eq!(status(10.0, 70_000, 7000.0, 0.6), Status::Failed);
        // A box at 93 % of its rate, and one that began 0.1 s late.
        assert_eq!(status(2.0, 13_020, 7000.0, 0.0), Status::SuspectData);
        assert_eq!(status(2.0, 13_300, 7000.0, 0.0), Status::Ok);
        // A second at a fifth of the rate is within half a second of records, yet not at the rate stated.
        assert_eq!(status(0.3, 2100, 1400.0, 0.0), Status::SuspectData);
    }
}
