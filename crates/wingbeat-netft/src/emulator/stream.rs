//! The stream of records of the emulated box.

use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use wingbeat::math::Random;
use wingbeat::rig::netft::{Command, RECORD_BYTES, RdtRecord, Request};

use super::{BOX_RATE, Faults, LoadPattern, RecordNumbering, SCALE, Sent, Signal};

/// Records of a buffered datagram.
const PACK: usize = 28;
/// By how much numbers leap.
const JUMP: u32 = 1 << 30;
/// Time in which a box that restarts hears nothing.
const REBOOT: Duration = Duration::from_secs(1);

/// The box: its sample count, its zero, and the stream to the client that asked last.
pub struct Stream {
    pub socket: UdpSocket,
    pub signal: Signal,
    pub faults: Faults,
    pub sent: Arc<Mutex<Sent>>,
    pub rate: Arc<AtomicU32>,
    random: Random,
    books: Sent,
    client: Option<Client>,
    offset: [f64; 6],
    /// When the box's samples began to be counted, from `first`; none of a box that is dead.
    born: Option<Instant>,
    first: u32,
}

/// Whom to send, how, and how far.
struct Client {
    address: SocketAddr,
    buffered: bool,
    left: Option<u64>,
    /// Numbers of the last record.
    rdt_sequence: u32,
    ft_sequence: u32,
    began: Instant,
    made: u64,
    held: Option<Vec<u8>>,
}

impl Stream {
    pub fn new(
        socket: UdpSocket,
        signal: Signal,
        faults: Faults,
        sent: Arc<Mutex<Sent>>,
        rate: Arc<AtomicU32>,
    ) -> Self {
        Self {
            socket,
            signal,
            faults,
            sent,
            rate,
            random: Random::new(faults.seed),
            books: Sent::default(),
            client: None,
            offset: [0.0; 6],
            born: Some(Instant::now()),
            first: faults.sequence,
        }
    }

    pub fn run(mut self, stop: &AtomicBool) {
        let mut buffer = [0; 64];
        while !stop.load(Ordering::Relaxed) {
            if let Ok((size, from)) = self.socket.recv_from(&mut buffer)
                && let Some(request) = Request::parse(&buffer[..size])
                && self.born.is_some_and(|born| Instant::now() >= born)
            {
                self.obey(request, from);
            }
            self.send_due();
            *self.sent.lock().unwrap_or_else(PoisonError::into_inner) = self.books;
        }
    }

    fn obey(&mut self, request: Request, address: SocketAddr) {
        let age = self.born.map_or(0.0, |born| born.elapsed().as_secs_f64());
        let now = self.first.wrapping_add((age * f64::from(BOX_RATE)) as u32);
        match request.command {
            Command::Stop => self.client = None,
            Command::Bias => self.offset = self.signal.at(now),
            Command::RealTime | Command::Buffered => {
                self.client = Some(Client {
                    address,
                    buffered: request.command == Command::Buffered,
                    left: (request.count > 0).then_some(u64::from(request.count)),
                    rdt_sequence: self.faults.sequence,
                    ft_sequence: now,
                    began: Instant::now(),
                    made: 0,
                    held: None,
                });
            }
        }
    }

    /// Sends all records whose time has come.
    fn send_due(&mut self) {
        let Some(mut client) = self.client.take() else { return };
        let rate = self.rate.load(Ordering::Relaxed);
        let pace = if self.faults.pace > 0.0 { self.faults.pace } else { 1.0 };
        let due = (client.began.elapsed().as_secs_f64() * f64::from(rate) * pace) as u64;
        let pack = if client.buffered { PACK } else { 1 };
        let mut datagram = Vec::with_capacity(pack * RECORD_BYTES);
        while client.made + pack as u64 <= due {
            datagram.clear();
            for _ in 0..pack {
                if client.left == Some(0) {
                    break;
                }
                datagram.extend(self.record(&mut client, BOX_RATE / rate.max(1)).bytes());
            }
            if !datagram.is_empty() {
                self.send(&mut client, &datagram);
            }
            if datagram.is_empty() || self.ends(client.made) {
                if let Some(held) = client.held.take() {
                    let _ = self.socket.send_to(&held, client.address);
                }
                return;
            }
        }
        self.client = Some(client);
    }

    fn record(&mut self, client: &mut Client, step: u32) -> RdtRecord {
        client.left = client.left.map(|left| left - 1);
        client.made += 1;
        self.books.records += 1;
        let leaps = self.faults.jump_after > 0 && client.made == self.faults.jump_after + 1;
        self.books.jumps += u64::from(leaps);
        client.rdt_sequence = client.rdt_sequence.wrapping_add(if leaps { JUMP } else { 1 });
        client.ft_sequence = client.ft_sequence.wrapping_add(step);
        let (rdt_sequence, ft_sequence) = self.numbers(client);
        let wrench = self.signal.at(client.ft_sequence);
        let loaded = std::array::from_fn(|i| wrench[i] - self.offset[i]);
        RdtRecord {
            rdt_sequence,
            ft_sequence,
            status: self.status(),
            counts: SCALE.counts(self.loads(loaded)),
        }
    }

    /// The numbers that a record carries.
    fn numbers(&mut self, client: &Client) -> (u32, u32) {
        let (rdt, ft, first) = (client.rdt_sequence, client.ft_sequence, self.faults.sequence);
        match self.faults.numbers {
            RecordNumbering::Counted => (rdt, ft),
            RecordNumbering::Random => (self.random.bits() as u32, ft),
            RecordNumbering::Backward => (0_u32.wrapping_sub(rdt), 0_u32.wrapping_sub(ft)),
            RecordNumbering::Frozen => (first.wrapping_add(1), first),
            RecordNumbering::FrozenSamples => (rdt, first),
        }
    }

    /// The loads that a record carries.
    fn loads(&self, measured: [f64; 6]) -> [f64; 6] {
        let [fx, fy, _, tx, ty, tz] = measured;
        let first = self.signal.at(0);
        match self.faults.loads {
            LoadPattern::Measured => measured,
            LoadPattern::Zero => [0.0; 6],
            LoadPattern::StuckFz => [fx, fy, first[2], tx, ty, tz],
            LoadPattern::Frozen => first,
        }
    }

    fn status(&mut self) -> u32 {
        let draw = self.random.unit();
        let Faults { saturation, warning, serious, .. } = self.faults;
        let (status, book) = match draw {
            d if d < saturation => (0x8002_0000, &mut self.books.saturated),
            d if d < saturation + warning => (0x8001_0000, &mut self.books.warnings),
            d if d < saturation + warning + serious => (0x8000_0001, &mut self.books.serious),
            _ => return 0,
        };
        *book += 1;
        status
    }

    /// True when the stream stalls or the box restarts after so many records.
    fn ends(&mut self, made: u64) -> bool {
        let after = |limit: u64| limit > 0 && made >= limit;
        if after(self.faults.restart_after) {
            self.books.restarts += 1;
            (self.born, self.first) = (Some(Instant::now() + REBOOT), self.faults.restart_at);
            self.offset = [0.0; 6];
            return true;
        }
        if after(self.faults.die_after) {
            self.born = None;
            return true;
        }
        let stalls = after(self.faults.stall_after);
        self.books.stalls += u64::from(stalls);
        stalls
    }

    /// Sends a datagram, or does to it what the faults say.
    fn send(&mut self, client: &mut Client, datagram: &[u8]) {
        let mut happens = |share: f64| share > 0.0 && self.random.unit() < share;
        let (drops, twice) = (happens(self.faults.drop), happens(self.faults.duplicate));
        let (late, slow, garbage) =
            (happens(self.faults.reorder), happens(self.faults.delay), happens(self.faults.garbage));
        // A client that has gone is found out by its silence.
        let out = |bytes: &[u8]| drop(self.socket.send_to(bytes, client.address));
        if drops {
            self.books.dropped += (datagram.len() / RECORD_BYTES) as u64;
        } else if late && client.held.is_none() {
            self.books.reordered += 1;
            client.held = Some(datagram.to_vec());
            return;
        } else {
            if slow {
                self.books.delayed += 1;
                thread::sleep(Duration::from_millis(20));
            }
            out(datagram);
            if twice {
                self.books.duplicated += 1;
                out(datagram);
            }
        }
        if let Some(held) = client.held.take() {
            out(&held);
        }
        if garbage {
            self.books.garbage += 1;
            let length = 1 + (self.random.bits() % 35) as usize;
            let bytes: Vec<u8> = (0..length).map(|_| self.random.bits() as u8).collect();
            out(&bytes);
        }
    }
}
