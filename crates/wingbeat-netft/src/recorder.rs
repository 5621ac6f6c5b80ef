//! The recorder: every record that the box sends is written or counted as missing.

use std::fs::{File, OpenOptions};
use std::io::{BufWriter, IoSliceMut, Write};
use std::net::{SocketAddr, UdpSocket};
use std::os::fd::AsRawFd;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use nix::cmsg_space;
use nix::sys::socket::{ControlMessageOwned, MsgFlags, SockaddrStorage, recvmsg, setsockopt, sockopt};
use nix::sys::time::TimeSpec;
use wingbeat::rig::netft::{Account, Command, RECORD_BYTES, RdtRecord, Request, Scale};

use crate::{Error, ROW_BYTES, Row};

/// How to record.
#[derive(Clone, Debug)]
pub struct Options {
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

impl Options {
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
pub enum Ending {
    /// What was asked for is there, or the observer stopped it.
    Complete,
    /// The box fell silent and stayed so.
    Silent,
    /// A log could not be written; what was written is whole.
    Disk(String),
}

/// What a recording gave.
#[derive(Clone, Debug)]
pub struct Report {
    /// How it ended.
    pub ending: Ending,
    /// Every record accounted for.
    pub account: Account,
    /// Stalls seen.
    pub stalls: u64,
    /// Longest time between two datagrams.
    pub longest_silence: Duration,
    /// Datagrams that the kernel threw away for want of buffer.
    pub kernel_drops: u64,
    /// Receive buffer that the kernel granted, bytes.
    pub buffer_bytes: usize,
    /// Samples per second by the kernel's clock, from a line through sequence and time.
    pub rate_hz: f64,
    /// Spread of arrival about that line, s.
    pub jitter_s: f64,
    /// Largest mean |load| right after a bias, N or N m; none when no bias was asked.
    pub bias_residual: Option<f64>,
    /// The logs, in order.
    pub files: Vec<PathBuf>,
}

/// Records into logs called `<stem>-000.rdt`, `-001` and so on in `folder`. Logs
/// that are already there stay; numbers go on after them. `observe` sees every
/// new row and returns false to stop.
///
/// # Errors
/// A socket or a first log that cannot be opened.
pub fn record(
    options: &Options,
    scale: &Scale,
    folder: &Path,
    stem: &str,
    mut observe: impl FnMut(&Row) -> bool,
) -> Result<Report, Error> {
    let mut session = Session::open(options, folder, stem)?;
    if options.bias {
        session.report.bias_residual = Some(session.bias(scale)?);
    }
    session.request(if options.buffered { Command::Buffered } else { Command::RealTime })?;
    session.run(&mut observe);
    let _ = session.request(Command::Stop);
    session.finish()
}

/// Socket, log and books of one recording.
struct Session<'a> {
    options: &'a Options,
    socket: UdpSocket,
    log: Log,
    report: Report,
    clock: ClockFit,
    last_datagram: Instant,
    began: Instant,
    failures: u32,
}

impl<'a> Session<'a> {
    fn open(options: &'a Options, folder: &Path, stem: &str) -> Result<Self, Error> {
        let any: SocketAddr =
            if options.address.is_ipv4() { ([0, 0, 0, 0], 0).into() } else { ([0u16; 8], 0).into() };
        let socket = UdpSocket::bind(any).map_err(|e| Error::network("UDP socket", e))?;
        socket.connect(options.address).map_err(|e| Error::network(options.address.to_string(), e))?;
        let patience = Some(Duration::from_millis(50));
        socket.set_read_timeout(patience).map_err(|e| Error::network("UDP socket", e))?;
        let set = |e: nix::Error| Error::network("UDP socket options", e);
        setsockopt(&socket, sockopt::RcvBuf, &options.buffer_bytes).map_err(set)?;
        setsockopt(&socket, sockopt::ReceiveTimestampns, &true).map_err(set)?;
        setsockopt(&socket, sockopt::RxqOvfl, &1).map_err(set)?;
        let granted = nix::sys::socket::getsockopt(&socket, sockopt::RcvBuf).map_err(set)?;
        let report = Report {
            ending: Ending::Complete,
            account: Account::default(),
            stalls: 0,
            longest_silence: Duration::ZERO,
            kernel_drops: 0,
            buffer_bytes: granted,
            rate_hz: 0.0,
            jitter_s: 0.0,
            bias_residual: None,
            files: Vec::new(),
        };
        let log = Log::open(folder, stem, options.rotate_rows)?;
        let now = Instant::now();
        Ok(Self {
            options,
            socket,
            log,
            report,
            clock: ClockFit::default(),
            last_datagram: now,
            began: now,
            failures: 0,
        })
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
        let mut buffer = vec![0; 64 << 10];
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

    fn run(&mut self, observe: &mut impl FnMut(&Row) -> bool) {
        let mut buffer = vec![0u8; 64 << 10];
        self.began = Instant::now();
        self.last_datagram = self.began;
        loop {
            if self.options.duration.is_some_and(|d| self.began.elapsed() >= d) {
                return;
            }
            let goes_on = match self.receive(&mut buffer) {
                Some((size, kernel_ns)) => self.datagram(&buffer[..size], kernel_ns, observe),
                None if self.last_datagram.elapsed() > self.options.stall => self.stalled(),
                None => true,
            };
            if !goes_on {
                return;
            }
        }
    }

    /// The next datagram and the kernel's time of it; none when the wait ran out.
    fn receive(&mut self, buffer: &mut [u8]) -> Option<(usize, u64)> {
        let mut control = cmsg_space!(TimeSpec, u32);
        let mut slices = [IoSliceMut::new(buffer)];
        let message = recvmsg::<SockaddrStorage>(
            self.socket.as_raw_fd(),
            &mut slices,
            Some(&mut control),
            MsgFlags::empty(),
        );
        let message = message.ok()?;
        let mut kernel_ns = 0;
        for control in message.cmsgs().into_iter().flatten() {
            match control {
                ControlMessageOwned::ScmTimestampns(t) => {
                    kernel_ns = t.tv_sec() as u64 * 1_000_000_000 + t.tv_nsec() as u64;
                }
                ControlMessageOwned::RxqOvfl(n) => self.report.kernel_drops = u64::from(n),
                _ => {}
            }
        }
        Some((message.bytes, kernel_ns))
    }

    /// Books and writes a datagram; false to stop.
    fn datagram(&mut self, bytes: &[u8], kernel_ns: u64, observe: &mut impl FnMut(&Row) -> bool) -> bool {
        let silence = self.last_datagram.elapsed();
        self.report.longest_silence = self.report.longest_silence.max(silence);
        self.last_datagram = Instant::now();
        let Some(records) = RdtRecord::parse(bytes) else {
            self.report.account.malformed += 1;
            return true;
        };
        self.failures = 0;
        let host = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_nanos() as u64);
        for record in records {
            if !self.report.account.take(&record) {
                continue;
            }
            let row = Row { host_ns: host, kernel_ns, record };
            self.clock.add(record.rdt_sequence, if kernel_ns > 0 { kernel_ns } else { host });
            if let Err(error) = self.log.append(&row) {
                self.report.ending = Ending::Disk(error.to_string());
                return false;
            }
            let enough = self.options.count > 0 && self.report.account.received >= self.options.count;
            if !observe(&row) || enough {
                return false;
            }
        }
        true
    }

    /// The box is silent: asks again after a pause, or gives up.
    fn stalled(&mut self) -> bool {
        self.report.stalls += u64::from(self.failures == 0);
        if self.failures >= self.options.reconnects {
            self.report.ending = Ending::Silent;
            return false;
        }
        let pause = Duration::from_millis(100) * 2u32.pow(self.failures.min(5));
        self.failures += 1;
        std::thread::sleep(pause.min(Duration::from_secs(2)));
        // A stream that only paused goes on with its numbers; a box that starts anew counts from 1.
        let before = self.report.account.received;
        let mut buffer = vec![0u8; RECORD_BYTES];
        if self.socket.peek(&mut buffer).is_ok() {
            self.last_datagram = Instant::now();
            return true;
        }
        let _ = self.request(if self.options.buffered { Command::Buffered } else { Command::RealTime });
        if before > 0 {
            self.report.account.restart();
            self.clock = ClockFit::default();
        }
        self.last_datagram = Instant::now();
        true
    }

    fn finish(mut self) -> Result<Report, Error> {
        (self.report.rate_hz, self.report.jitter_s) = self.clock.result();
        if let Err(error) = self.log.close()
            && self.report.ending == Ending::Complete
        {
            self.report.ending = Ending::Disk(error.to_string());
        }
        self.report.files = self.log.files;
        Ok(self.report)
    }
}

/// Logs that follow one another.
struct Log {
    folder: PathBuf,
    stem: String,
    rotate_rows: u64,
    rows: u64,
    writer: BufWriter<File>,
    files: Vec<PathBuf>,
}

impl Log {
    fn open(folder: &Path, stem: &str, rotate_rows: u64) -> Result<Self, Error> {
        std::fs::create_dir_all(folder).map_err(|source| Error::file(folder, source))?;
        let (path, file) = next(folder, stem)?;
        let writer = BufWriter::with_capacity(ROW_BYTES * 1024, file);
        Ok(Self { folder: folder.into(), stem: stem.into(), rotate_rows, rows: 0, writer, files: vec![path] })
    }

    fn append(&mut self, row: &Row) -> Result<(), Error> {
        if self.rotate_rows > 0 && self.rows >= self.rotate_rows {
            self.close()?;
            let (path, file) = next(&self.folder, &self.stem)?;
            self.writer = BufWriter::with_capacity(ROW_BYTES * 1024, file);
            self.files.push(path);
            self.rows = 0;
        }
        self.rows += 1;
        let failed = |source| Error::file(self.files.last().map_or(Path::new(""), |p| p), source);
        self.writer.write_all(&row.bytes()).map_err(failed)
    }

    fn close(&mut self) -> Result<(), Error> {
        let path = self.files.last().cloned().unwrap_or_default();
        self.writer.flush().and_then(|()| self.writer.get_ref().sync_all()).map_err(|e| Error::file(&path, e))
    }
}

/// The first free name and its file.
fn next(folder: &Path, stem: &str) -> Result<(PathBuf, File), Error> {
    for number in 0.. {
        let path = folder.join(format!("{stem}-{number:03}.rdt"));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((path, file)),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(source) => return Err(Error::file(&path, source)),
        }
    }
    unreachable!("numbers do not end")
}

/// A line through (sequence, time) by running sums.
#[derive(Default)]
struct ClockFit {
    first: Option<(u32, u64)>,
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl ClockFit {
    fn add(&mut self, sequence: u32, ns: u64) {
        let (s0, t0) = *self.first.get_or_insert((sequence, ns));
        let x = f64::from(sequence.wrapping_sub(s0) as i32);
        let y = (ns as i64 - t0 as i64) as f64 * 1e-9;
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    /// Samples per second and spread of arrival, s.
    fn result(&self) -> (f64, f64) {
        let (sxx, sxy) = (self.xx - self.x * self.x / self.n, self.xy - self.x * self.y / self.n);
        let syy = self.yy - self.y * self.y / self.n;
        if self.n < 3.0 || sxx <= 0.0 || sxy <= 0.0 {
            return (0.0, 0.0);
        }
        (sxx / sxy, ((syy - sxy * sxy / sxx).max(0.0) / self.n).sqrt())
    }
}
