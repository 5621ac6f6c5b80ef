//! A recording's raw logs as one record, and the account of it.

use std::path::Path;

use serde::Serialize;
use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::netft::{Account, Scale};
use wingbeat::simulate::{Column, Record};
use wingbeat_io::ParquetWriter;
use wingbeat_netft::{Ending, ROW_BYTES, Report, Row, Timeline, logs, read_log};

use crate::error::Error;
use crate::run_folder::RunFolder;

/// Name that the raw logs begin with.
pub const RAW: &str = "raw";
/// Rows in memory at once.
const PART: usize = 1 << 16;

/// The account of a recording. Counts of records are of all its raw logs, other counts of the last start.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// `ok` or `silent`.
    pub status: String,
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
    /// Samples of the box between one stream and the next.
    pub unsent: u64,
    /// Restarts of the box, before which what was missed is not known.
    pub reboots: u64,
    /// Records with a warning status.
    pub warnings: u64,
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
    /// Spread of arrival, s.
    pub jitter_s: f64,
    /// Largest mean load right after the bias, N or N m.
    pub bias_residual: Option<f64>,
    /// Raw logs.
    pub logs: usize,
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
pub fn write(folder: &RunFolder, report: &Report, scale: &Scale) -> Result<Summary, Error> {
    let empty = || Record::new(columns(), PART);
    let mut file = ParquetWriter::create(&folder.file("record.parquet"), &empty()?)?;
    let (mut part, mut account, mut line) = (empty()?, Account::default(), Timeline::default());
    let mut first: Option<Row> = None;
    let (mut begin, mut end) = (0.0_f64, 0.0_f64);
    let logs = logs(folder.partial(), RAW).map_err(input)?;
    for log in &logs {
        for row in read_log(log).map_err(input)? {
            let row = row.map_err(input)?;
            account.take_new(&row.record);
            let t = line.time(&row);
            (begin, end) = (begin.min(t), end.max(t));
            part.append(&cells(&row, t, first.get_or_insert(row), scale));
            if part.rows() == PART {
                file.append(&part)?;
                part = empty()?;
            }
        }
    }
    file.append(&part)?;
    file.close()?;
    Ok(Summary::new(report, &account, (begin, end), logs.len()))
}

fn columns() -> Vec<Column> {
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

impl Summary {
    fn new(report: &Report, account: &Account, window_s: (f64, f64), logs: usize) -> Self {
        Self {
            status: if report.ending == Ending::Silent { "silent" } else { "ok" }.into(),
            window_s,
            records: account.received,
            lost: account.lost,
            gaps: account.gaps,
            longest_gap: account.longest_gap,
            reordered: account.reordered,
            restarts: account.restarts,
            unsent: account.unsent,
            reboots: account.reboots,
            warnings: account.warnings,
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
             {} stalls, {} restarts of the stream ({} samples between), {} restarts of the box\n\
             longest silence {:.1} ms, {} datagrams dropped by the kernel (buffer {} kB)\n\
             {:.2} samples/s by the kernel's clock, arrival spread {:.3} ms\n",
            self.records,
            self.lost,
            self.gaps,
            self.longest_gap,
            self.duplicates,
            self.reordered,
            self.malformed,
            self.warnings,
            self.saturated,
            self.serious,
            self.stalls,
            self.restarts,
            self.unsent,
            self.reboots,
            1e3 * self.longest_silence_s,
            self.kernel_drops,
            self.buffer_bytes / 1024,
            self.rate_hz,
            1e3 * self.jitter_s,
        );
        if let Some(residual) = self.bias_residual {
            text += &format!("bias: largest mean load right after it {residual:.4} (N or N m)\n");
        }
        text
    }
}
