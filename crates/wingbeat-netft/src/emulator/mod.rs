//! An emulator of the box: UDP RDT, configuration pages, and faults on request.

mod pages;
mod stream;

use std::net::{IpAddr, SocketAddr, TcpListener, UdpSocket};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use wingbeat::rig::netft::{self, RDT_PORT, Scale};

use crate::Error;
use stream::Stream;

/// Samples per second inside the box, whole.
const BOX_RATE: u32 = netft::BOX_RATE as u32;

/// What the emulated cell feels.
#[derive(Clone, Debug)]
pub enum Signal {
    /// A flapping robot at 3.5 Hz.
    Flapping,
    /// Samples of Fx .. Tz at 7 kHz, N and N m, again and again.
    Samples(Vec<[f64; 6]>),
}

impl Signal {
    /// What the cell feels at sample `sample` of the box, N and N m.
    pub fn at(&self, sample: u32) -> [f64; 6] {
        match self {
            Self::Flapping => {
                let (s, c) = (std::f64::consts::TAU * 3.5 * f64::from(sample) / netft::BOX_RATE).sin_cos();
                let bend = 2.0 * s * c;
                [0.01 * c, 0.02 * s, 0.4 * s + 0.1 * bend - 0.45, 1e-3 * s, 0.02 * c, 5e-4 * bend]
            }
            Self::Samples(list) => list.get(sample as usize % list.len().max(1)).copied().unwrap_or([0.0; 6]),
        }
    }
}

/// How the box numbers its records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RecordNumbering {
    /// By one and by the samples between, as the box does.
    #[default]
    Counted,
    /// The number of the record is random.
    Random,
    /// Both count backward.
    Backward,
    /// Both stand still.
    Frozen,
    /// The count of samples stands still.
    FrozenSamples,
}

/// What the records say of the loads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoadPattern {
    /// What the cell feels.
    #[default]
    Measured,
    /// Nothing at all.
    Zero,
    /// Fz as it was at the begin.
    StuckFz,
    /// What the first record said.
    Frozen,
}

/// Misbehaviour: shares are probabilities per record or datagram.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    /// Share of datagrams not sent.
    pub drop: f64,
    /// Share of datagrams sent twice.
    pub duplicate: f64,
    /// Share of datagrams sent after the next one.
    pub reorder: f64,
    /// Share of datagrams delayed by 20 ms together with all after them.
    pub delay: f64,
    /// Share of datagrams followed by one of random bytes.
    pub garbage: f64,
    /// Share of records with a saturated status.
    pub saturation: f64,
    /// Share of records with a warning status.
    pub warning: f64,
    /// Share of records with a serious status.
    pub serious: f64,
    /// After this many records the stream stops until it is asked for again; 0 never.
    pub stall_after: u64,
    /// After this many records the box restarts: deaf for a second, then it counts from 0 without a bias; 0 never.
    pub restart_after: u64,
    /// Number from which the box counts its samples after a restart.
    pub restart_at: u32,
    /// After this many records of a stream the box sends nothing any more; 0 never.
    pub die_after: u64,
    /// After this many records of a stream its numbers leap ahead by 2^30; 0 never.
    pub jump_after: u64,
    /// Share of records made of those that its rate says; 1 all, and 0 means 1.
    pub pace: f64,
    /// Number before the first record of a stream and of the box's own count, to see numbers wrap.
    pub sequence: u32,
    /// How records are numbered.
    pub numbers: RecordNumbering,
    /// What records say of the loads.
    pub loads: LoadPattern,
    /// Seed of all this.
    pub seed: u64,
}

impl Faults {
    /// Checks the numbers.
    ///
    /// # Errors
    /// A share that is none.
    pub fn check(&self) -> Result<(), wingbeat::Error> {
        let shares = [
            ("drop", self.drop),
            ("duplicate", self.duplicate),
            ("reorder", self.reorder),
            ("delay", self.delay),
            ("garbage", self.garbage),
            ("saturation", self.saturation),
            ("warning", self.warning),
            ("serious", self.serious),
            ("pace", self.pace),
        ];
        let share = |(key, value): (&str, f64)| match (0.0..=1.0).contains(&value) {
            true => Ok(()),
            false => Err(wingbeat::Error::invalid(key, value, "a share from 0 to 1")),
        };
        shares.into_iter().try_for_each(share)?;
        let marked = self.saturation + self.warning + self.serious;
        match marked <= 1.0 {
            true => Ok(()),
            false => {
                let allowed = "at most 1 together with the other two";
                let error = wingbeat::Error::invalid("saturation", self.saturation, allowed);
                Err(error.against(["warning", "serious"]))
            }
        }
    }
}

/// Largest number that is added to the box's ports.
pub const LARGEST_OFFSET: u16 = u16::MAX - RDT_PORT;

/// What the emulator did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sent {
    /// Records made.
    pub records: u64,
    /// Records in datagrams that were not sent.
    pub dropped: u64,
    /// Datagrams sent twice.
    pub duplicated: u64,
    /// Datagrams sent late.
    pub reordered: u64,
    /// Datagrams delayed.
    pub delayed: u64,
    /// Datagrams of random bytes.
    pub garbage: u64,
    /// Records marked saturated.
    pub saturated: u64,
    /// Records marked with a warning.
    pub warnings: u64,
    /// Records marked serious.
    pub serious: u64,
    /// Stalls.
    pub stalls: u64,
    /// Restarts of the box.
    pub restarts: u64,
    /// Jumps of its numbers.
    pub jumps: u64,
}

/// A running emulator; dropped, it stops.
#[derive(Debug)]
pub struct Emulator {
    /// RDT address.
    pub rdt: SocketAddr,
    /// Address of the configuration pages.
    pub http: SocketAddr,
    stop: Arc<AtomicBool>,
    sent: Arc<Mutex<Sent>>,
    threads: Vec<JoinHandle<()>>,
}

/// What the emulated box is set to.
const SCALE: Scale = Scale { per_newton: 1e6, per_newton_metre: 1e6 };

impl Emulator {
    /// Starts on `address`: UDP 49152 and TCP 80, both plus `port_offset`.
    ///
    /// # Errors
    /// A port that cannot be had, faults that are none.
    pub fn start(address: IpAddr, port_offset: u16, signal: Signal, faults: Faults) -> Result<Self, Error> {
        faults.check()?;
        if port_offset > LARGEST_OFFSET {
            let allowed = format!("at most {LARGEST_OFFSET}: ports end at 65535");
            return Err(wingbeat::Error::invalid("port_offset", port_offset, allowed).into());
        }
        let port = |base: u16| SocketAddr::new(address, base + port_offset);
        let bind =
            |at: SocketAddr| move |e| Error::network(format!("{at}: cannot be bound; try --port-offset"), e);
        let udp = UdpSocket::bind(port(RDT_PORT)).map_err(bind(port(RDT_PORT)))?;
        let tcp = TcpListener::bind(port(80)).map_err(bind(port(80)))?;
        udp.set_read_timeout(Some(Duration::from_micros(200)))
            .map_err(|e| Error::network("UDP socket", e))?;
        tcp.set_nonblocking(true).map_err(|e| Error::network("TCP socket", e))?;
        let (stop, sent) = (Arc::new(AtomicBool::new(false)), Arc::new(Mutex::new(Sent::default())));
        let rate = Arc::new(AtomicU32::new(BOX_RATE));
        let (rdt, http) = (port(RDT_PORT), port(80));
        let stream = Stream::new(udp, signal, faults, Arc::clone(&sent), Arc::clone(&rate));
        let (halt, halt_pages) = (Arc::clone(&stop), Arc::clone(&stop));
        let threads = vec![
            thread::spawn(move || stream.run(&halt)),
            thread::spawn(move || pages::serve(&tcp, &rate, &halt_pages)),
        ];
        Ok(Self { rdt, http, stop, sent, threads })
    }

    /// What was sent until now.
    pub fn sent(&self) -> Sent {
        *self.sent.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}
