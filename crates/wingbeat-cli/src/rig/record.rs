//! `wingbeat rig record` and `wingbeat rig emulate`.

use std::fs;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use wingbeat::flight::{Column, Record};
use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::netft::{RDT_PORT, Scale};
use wingbeat_io::{read_parquet, write_parquet};
use wingbeat_netft::{Emulator, Ending, Faults, Options, Report, Row, Signal, read_config, read_log};

use crate::args::{RigEmulate, RigRecord};
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::progress;

/// Bins of the live phase average.
const BINS: usize = 16;
/// Time between two lines of the display.
const REFRESH: Duration = Duration::from_millis(250);

/// Records until the time is over or Ctrl-C.
pub fn record(arguments: &RigRecord) -> Result<(), Error> {
    let at = |port: u16| SocketAddr::new(arguments.address, port.wrapping_add(arguments.port_offset));
    let refused = |error: wingbeat_netft::Error| Error::Input(error.to_string());
    let interrupt = Interrupt::listen()?;
    let config = read_config(at(80)).map_err(refused)?;
    let mut options = Options::new(at(RDT_PORT));
    options.buffered = arguments.buffered;
    options.bias = arguments.bias;
    options.rotate_rows = arguments.rotate;
    options.duration =
        arguments.duration.map(Duration::try_from_secs_f64).transpose().map_err(|e| {
            Error::Input(format!("--duration {}: {e}", arguments.duration.unwrap_or_default()))
        })?;
    if arguments.fail_stop {
        options.reconnects = 0;
    }
    let mut display = Display::new(config.scale, arguments.frequency, arguments.quiet);
    let report = wingbeat_netft::record(&options, &config.scale, &arguments.out, "raw", |row| {
        display.see(row);
        interrupt.flow().is_continue()
    })
    .map_err(refused)?;
    display.bar.finish_and_clear();
    write(arguments, &report, &config.scale)?;
    let text = words(&report);
    let file = arguments.out.join("report.txt");
    fs::write(&file, &text).map_err(|source| Error::file(&file, source))?;
    if !arguments.quiet {
        print!("{text}");
    }
    match &report.ending {
        Ending::Complete => Ok(()),
        Ending::Silent => failed("silent", "the box stopped sending", arguments),
        Ending::Disk(why) => failed("disk", why, arguments),
    }
}

fn failed(status: &str, reason: &str, arguments: &RigRecord) -> Result<(), Error> {
    Err(Error::Failed { status: status.into(), reason: reason.into(), folder: arguments.out.clone() })
}

/// The raw logs as one record, under another name until it is whole.
fn write(arguments: &RigRecord, report: &Report, scale: &Scale) -> Result<(), Error> {
    let mut columns: Vec<Column> = [
        ("t", "s"),
        ("t_kernel", "s"),
        ("t_host", "s"),
        ("rdt_sequence", ""),
        ("ft_sequence", ""),
        ("status", ""),
    ]
    .map(|(name, unit)| Column::new(name, unit, ""))
    .into();
    columns.extend(CHANNELS.map(|(name, unit)| Column::new(name, unit, "C")));
    columns.extend(CHANNELS.map(|(name, _)| Column::new(format!("counts_{name}"), "", "C")));
    let mut record = Record::new(columns, report.account.received as usize)?;
    let mut first: Option<Row> = None;
    for file in &report.files {
        for row in read_log(file).map_err(|error| Error::Input(error.to_string()))? {
            let begin = *first.get_or_insert(row);
            let seconds = |now: u64, then: u64| (now as i64 - then as i64) as f64 * 1e-9;
            let r = &row.record;
            let samples = f64::from(r.ft_sequence.wrapping_sub(begin.record.ft_sequence) as i32);
            let head = [
                samples / 7000.0,
                seconds(row.kernel_ns, begin.kernel_ns),
                seconds(row.host_ns, begin.host_ns),
                f64::from(r.rdt_sequence),
                f64::from(r.ft_sequence),
                f64::from(r.status),
            ];
            let line: Vec<f64> =
                head.into_iter().chain(scale.wrench(r.counts)).chain(r.counts.map(f64::from)).collect();
            record.append(&line);
        }
    }
    let (partial, target) = (arguments.out.join(".record.partial"), arguments.out.join("record.parquet"));
    write_parquet(&partial, &record)?;
    fs::rename(&partial, &target).map_err(|source| Error::file(&target, source))
}

fn words(report: &Report) -> String {
    let a = &report.account;
    let mut text = format!(
        "{} records, {} lost in {} gaps (longest {}), {} duplicates, {} late, {} malformed datagrams\n\
         status: {} warnings, {} saturated, {} serious\n\
         {} stalls, {} restarts, longest silence {:.1} ms, {} datagrams dropped by the kernel (buffer {} kB)\n\
         {:.2} samples/s by the kernel's clock, arrival spread {:.3} ms\n",
        a.received,
        a.lost,
        a.gaps,
        a.longest_gap,
        a.duplicates,
        a.reordered,
        a.malformed,
        a.warnings,
        a.saturated,
        a.serious,
        report.stalls,
        a.restarts,
        1e3 * report.longest_silence.as_secs_f64(),
        report.kernel_drops,
        report.buffer_bytes / 1024,
        report.rate_hz,
        1e3 * report.jitter_s,
    );
    if let Some(residual) = report.bias_residual {
        text += &format!("bias: largest mean load right after it {residual:.4} (N or N m)\n");
    }
    text
}

/// The six channels and the phase-averaged Fz on one line.
struct Display {
    scale: Scale,
    frequency: f64,
    fz: [(f64, f64); BINS],
    shown: Instant,
    bar: ProgressBar,
    rows: u64,
}

impl Display {
    fn new(scale: Scale, frequency: f64, quiet: bool) -> Self {
        let bar = progress::bar(None, "{elapsed} {wide_msg}", quiet);
        Self { scale, frequency, fz: [(0.0, 0.0); BINS], shown: Instant::now(), bar, rows: 0 }
    }

    fn see(&mut self, row: &Row) {
        self.rows += 1;
        let w = self.scale.wrench(row.record.counts);
        let turn = f64::from(row.record.ft_sequence) / 7000.0 * self.frequency;
        let bin = ((turn.fract() * BINS as f64) as usize).min(BINS - 1);
        let (mean, weight) = &mut self.fz[bin];
        *weight = (*weight + 1.0).min(5000.0);
        *mean += (w[2] - *mean) / *weight;
        if self.shown.elapsed() < REFRESH {
            return;
        }
        self.shown = Instant::now();
        let (low, high) =
            self.fz.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), b| (l.min(b.0), h.max(b.0)));
        let bars = self.fz.iter().map(|b| level((b.0 - low) / (high - low).max(1e-9))).collect::<String>();
        let [fx, fy, fz, tx, ty, tz] = w;
        let (rows, mm) = (self.rows, 1e3);
        self.bar.set_message(format!(
            "{rows} F {fx:7.3} {fy:7.3} {fz:7.3} N  T {:7.2} {:7.2} {:7.2} N mm  Fz/cycle {bars}",
            tx * mm,
            ty * mm,
            tz * mm
        ));
        self.bar.tick();
    }
}

fn level(share: f64) -> char {
    const LEVELS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    LEVELS[((share * 7.99) as usize).min(7)]
}

/// Emulates the box until Ctrl-C.
pub fn emulate(arguments: &RigEmulate) -> Result<(), Error> {
    let interrupt = Interrupt::listen()?;
    let signal = match &arguments.play {
        None => Signal::Flapping,
        Some(file) => Signal::Samples(samples(&read_parquet(file)?)?),
    };
    let faults = Faults {
        drop: arguments.drop,
        duplicate: arguments.duplicate,
        reorder: arguments.reorder,
        delay: arguments.delay,
        garbage: arguments.garbage,
        saturation: arguments.saturation,
        stall_after: arguments.stall_after,
        seed: arguments.seed,
    };
    let emulator = Emulator::start(arguments.bind, arguments.port_offset, signal, faults)
        .map_err(|error| Error::Input(error.to_string()))?;
    println!("RDT on udp://{}, pages on http://{}; Ctrl-C ends", emulator.rdt, emulator.http);
    while interrupt.flow().is_continue() {
        std::thread::sleep(Duration::from_millis(100));
    }
    println!("{:?}", emulator.sent());
    Ok(())
}

fn samples(record: &Record) -> Result<Vec<[f64; 6]>, Error> {
    let columns = CHANNELS.map(|(name, _)| record.values(name));
    if let Some(index) = columns.iter().position(Option::is_none) {
        return Err(Error::Input(format!("the record has no column {}", CHANNELS[index].0)));
    }
    let value = |i: usize, row: usize| columns[i].map_or(0.0, |values| values[row]);
    Ok((0..record.rows()).map(|row| std::array::from_fn(|i| value(i, row))).collect())
}
