//! The recorder: every record that the box sends is written or counted as missing.

use std::net::{SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use wingbeat::rig::netft::{Account, Command, RdtRecord, Request, Scale};

use crate::clock::ClockFit;
use crate::log::Log;
use crate::receive::{self, Datagram, LARGEST, PATIENCE};
use crate::{Error, ROW_BYTES, Row};

/// Datagrams between the kernel and the log: nine seconds of single records.
const QUEUE: usize = 1 << 16;
/// Waits in vain in a row after which silence is the box's and not this machine's.
const EMPTY_WAITS: u32 = 3;
/// Longest pause before asking again.
const LONGEST_PAUSE: Duration = Duration::from_secs(2);

/// How to record.
#[derive(Clone, Debug)]
pub struct RecordingOptions {
    /// The box's RDT address.
    pub address: SocketAddr,
    /// Records per datagram as the box likes, or one.
    pub buffered: bool,
    /// Stop after this many records; 0 for without end.
    pub count: u64,
    /// Stop after this time.
    pub duration: Option<Duration>,
    /// Take the load at the start as zero and see that it became so.
    pub bias: bool,
    /// Receive buffer asked of the kernel, bytes.
    pub buffer_bytes: usize,
    /// Silence after which the stream counts as stalled.
    pub stall: Duration,
    /// Ask again after a stall, with growing pauses, this many times; 0 stops at the first.
    pub reconnects: u32,
    /// Rows after which a new log file is begun; 0 for one file.
    pub rotate_rows: u64,
}

impl RecordingOptions {
    /// Real-time records from `address` until stopped.
    pub fn new(address: SocketAddr) -> Self {
        Self {
            address,
            buffered: false,
            count: 0,
            duration: None,
            bias: false,
            buffer_bytes: 8 << 20,
            stall: Duration::from_millis(500),
            reconnects: 10,
            rotate_rows: 0,
        }
    }
}

/// How a recording ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordingEnd {
    /// What was asked for is there, or the observer stopped it.
    Complete,
    /// The box fell silent and stayed so.
    Silent,
    /// A log could not be written; the rows that it holds are whole.
    Disk(String),
}

/// What a recording gave.
#[derive(Clone, Debug)]
pub struct Report {
    /// How it ended.
    pub ending: RecordingEnd,
    /// Every record accounted for.
    pub account: Account,
    /// Stalls seen.
    pub stalls: u64,
    /// Longest time between the arrivals of two datagrams.
    pub longest_silence: Duration,
    /// Datagrams that the kernel threw away for want of buffer.
    pub kernel_drops: u64,
    /// Receive buffer that the kernel granted, bytes.
    pub buffer_bytes: usize,
    /// Samples per second by the kernel's clock, from a line through sequence and time.
    pub rate_hz: f64,
    /// Time that this line spans.
    pub rate_span: Duration,
    /// From asking for records to the first that came, or to the end.
    pub head: Duration,
    /// From the last record that came to the end.
    pub tail: Duration,
    /// Spread of arrival about that line, s.
    pub jitter_s: f64,
    /// Largest mean |load| right after a bias, N or N m; none when no bias was asked.
    pub bias_residual: Option<f64>,
    /// Rows in the logs of this recording.
    pub rows: u64,
    /// The logs of this recording, in order.
    pub files: Vec<PathBuf>,
}

/// Records into logs called `<stem>-000.rdt`, `-001` and so on in `folder`. Logs
/// that are already there stay; numbers go on after them. `observe` sees every
/// new row, none while nothing comes, and returns false to stop.
///
/// # Errors
/// A socket or a first log that cannot be opened.
pub fn record(
    options: &RecordingOptions,
    scale: &Scale,
    folder: &Path,
    stem: &str,
    mut observe: impl FnMut(Option<&Row>) -> bool,
) -> Result<Report, Error> {
    let mut session = Session::open(options, folder, stem)?;
    if options.bias {
        session.report.bias_residual = Some(session.bias(scale)?);
    }
    session.request(session.stream())?;
    let (queue, datagrams) = sync_channel(QUEUE);
    let (stop, drops) = (AtomicBool::new(false), AtomicU64::new(0));
    let socket = session.socket.try_clone().map_err(|e| Error::network("UDP socket", e))?;
    thread::scope(|scope| {
        let pump = || receive::pump(&socket, &{ queue }, &drops, &stop);
        let started = thread::Builder::new().spawn_scoped(scope, pump);
        started.map_err(|error| Error::network("a thread that receives", error))?;
        session.run(datagrams, &mut observe);
        session.ended = Instant::now();
        stop.store(true, Ordering::Relaxed);
        Ok::<(), Error>(())
    })?;
    session.report.kernel_drops = drops.into_inner();
    let _ = session.request(Command::Stop);
    Ok(session.finish())
}

/// Socket, log and books of one recording.
struct Session<'a> {
    options: &'a RecordingOptions,
    socket: UdpSocket,
    log: Log,
    report: Report,
    clock: ClockFit,
    /// When records were taken from the queue, or asked for, and the arrival of the last, ns since 1970.
    last_seen: Instant,
    last_arrival: Option<u64>,
    empty_waits: u32,
    failures: u32,
    /// When to ask again.
    ask_at: Option<Instant>,
    /// When records were asked for first, when the first came, and when the last.
    began: Instant,
    came: Option<(Instant, Instant)>,
    ended: Instant,
}

impl<'a> Session<'a> {
    fn open(options: &'a RecordingOptions, folder: &Path, stem: &str) -> Result<Self, Error> {
        let (socket, granted) = receive::open(options.address, options.buffer_bytes)?;
        let report = Report {
            ending: RecordingEnd::Complete,
            account: Account::default(),
            stalls: 0,
            longest_silence: Duration::ZERO,
            kernel_drops: 0,
            buffer_bytes: granted,
            rate_hz: 0.0,
            rate_span: Duration::ZERO,
            head: Duration::ZERO,
            tail: Duration::ZERO,
            jitter_s: 0.0,
            bias_residual: None,
            rows: 0,
            files: Vec::new(),
        };
        Ok(Self {
            options,
            socket,
            log: Log::open(folder, stem, options.rotate_rows)?,
            report,
            clock: ClockFit::default(),
            last_seen: Instant::now(),
            last_arrival: None,
            empty_waits: 0,
            failures: 0,
            ask_at: None,
            began: Instant::now(),
            came: None,
            ended: Instant::now(),
        })
    }

    /// The command that asks for the stream.
    fn stream(&self) -> Command {
        if self.options.buffered { Command::Buffered } else { Command::RealTime }
    }

    fn request(&self, command: Command) -> Result<(), Error> {
        let bytes = Request { command, count: 0 }.bytes();
        self.socket.send(&bytes).map(drop).map_err(|e| Error::network(self.options.address.to_string(), e))
    }

    /// Biases the box and returns the largest mean load of a tenth of a second after it.
    fn bias(&mut self, scale: &Scale) -> Result<f64, Error> {
        self.request(Command::Bias)?;
        std::thread::sleep(Duration::from_millis(20));
        self.request(Command::RealTime)?;
        let (mut sum, mut count) = ([0.0; 6], 0.0);
        let end = Instant::now() + Duration::from_millis(400);
        let mut buffer = vec![0; LARGEST];
        while Instant::now() < end && count < 700.0 {
            let Ok(size) = self.socket.recv(&mut buffer) else { continue };
            for record in RdtRecord::parse(&buffer[..size]).into_iter().flatten() {
                for (sum, x) in sum.iter_mut().zip(scale.wrench(record.counts)) {
                    *sum += x;
                }
                count += 1.0;
            }
        }
        self.request(Command::Stop)?;
        self.drain(&mut buffer);
        if count == 0.0 {
            let url = self.options.address.to_string();
            return Err(Error::Answer { url, what: "no record came after the bias".into() });
        }
        Ok(sum.iter().fold(0.0, |m: f64, s| m.max((s / count).abs())))
    }

    /// Takes what is still on its way.
    fn drain(&self, buffer: &mut [u8]) {
        let end = Instant::now() + Duration::from_millis(100);
        while Instant::now() < end {
            if self.socket.recv(buffer).is_err() {
                break;
            }
        }
    }

    fn run(&mut self, datagrams: Receiver<Datagram>, observe: &mut impl FnMut(Option<&Row>) -> bool) {
        (self.began, self.last_seen) = (Instant::now(), Instant::now());
        while self.options.duration.is_none_or(|duration| self.began.elapsed() < duration) {
            let goes_on = match datagrams.recv_timeout(PATIENCE) {
                Ok(datagram) => self.datagram(&datagram, observe),
                Err(_) => observe(None) && self.silence(),
            };
            if !goes_on {
                return;
            }
        }
    }

    /// Books and writes a datagram; false to stop.
    fn datagram(&mut self, datagram: &Datagram, observe: &mut impl FnMut(Option<&Row>) -> bool) -> bool {
        let Datagram { bytes, kernel_ns, host_ns } = datagram;
        let Some(records) = RdtRecord::parse(bytes) else {
            // Noise is no record: a box that sends nothing else is silent.
            self.report.account.malformed += 1;
            return observe(None) && self.silence();
        };
        (self.last_seen, self.empty_waits, self.ask_at) = (Instant::now(), 0, None);
        self.came = Some((self.came.map_or(self.last_seen, |(first, _)| first), self.last_seen));
        let arrival = if *kernel_ns > 0 { *kernel_ns } else { *host_ns };
        let silence = Duration::from_nanos(arrival.saturating_sub(self.last_arrival.unwrap_or(arrival)));
        self.report.longest_silence = self.report.longest_silence.max(silence);
        self.last_arrival = Some(arrival);
        self.failures = 0;
        for record in records {
            let row = Row { host_ns: *host_ns, kernel_ns: *kernel_ns, record };
            if !self.row(&row, observe) {
                return false;
            }
        }
        true
    }

    /// Books and writes a row; false to stop.
    fn row(&mut self, row: &Row, observe: &mut impl FnMut(Option<&Row>) -> bool) -> bool {
        let restarts = self.report.account.restarts;
        if !self.report.account.take(&row.record, row.arrival_ns()) {
            return observe(None);
        }
        if self.report.account.restarts > restarts {
            self.clock = ClockFit::default();
        }
        self.clock.add(row.record.rdt_sequence, row.arrival_ns());
        if let Err(error) = self.log.append(row) {
            self.report.ending = RecordingEnd::Disk(error.to_string());
            return false;
        }
        let enough = self.options.count > 0 && self.report.account.received >= self.options.count;
        observe(Some(row)) && !enough
    }

    /// No record came for a while: asks again after a pause once that is too long, or gives up; false to stop.
    fn silence(&mut self) -> bool {
        self.empty_waits = self.empty_waits.saturating_add(1);
        if let Some(at) = self.ask_at {
            if Instant::now() >= at {
                let _ = self.request(self.stream());
                self.report.account.asked();
                (self.ask_at, self.last_seen) = (None, Instant::now());
            }
            return true;
        }
        if self.empty_waits < EMPTY_WAITS || self.last_seen.elapsed() <= self.options.stall {
            return true;
        }
        self.report.stalls += u64::from(self.failures == 0);
        if self.failures >= self.options.reconnects {
            self.report.ending = RecordingEnd::Silent;
            return false;
        }
        let pause = Duration::from_millis(100) * 2u32.pow(self.failures.min(5));
        self.failures += 1;
        self.ask_at = Some(Instant::now() + pause.min(LONGEST_PAUSE));
        true
    }

    fn finish(mut self) -> Report {
        (self.report.rate_hz, self.report.jitter_s) = self.clock.result();
        self.report.rate_span = Duration::from_secs_f64(self.clock.span);
        let end = self.ended;
        (self.report.head, self.report.tail) = match self.came {
            Some((first, last)) => (first - self.began, end.saturating_duration_since(last)),
            None => (end - self.began, Duration::ZERO),
        };
        if let Err(error) = self.log.close()
            && self.report.ending == RecordingEnd::Complete
        {
            self.report.ending = RecordingEnd::Disk(error.to_string());
        }
        self.report.files = self.log.files;
        self.report.rows = self.report.files.iter().map(|file| whole_rows(file)).sum();
        self.report
    }
}

fn whole_rows(file: &Path) -> u64 {
    file.metadata().map_or(0, |metadata| metadata.len() / ROW_BYTES as u64)
}
