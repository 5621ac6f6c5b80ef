//! An emulator of the box: UDP RDT, configuration pages, and faults on request.

use std::io::{Read, Write};
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use wingbeat::math::Random;
use wingbeat::rig::netft::{Command, RDT_PORT, RECORD_BYTES, RdtRecord, Request, Scale};

use crate::Error;

/// What the emulated cell feels.
#[derive(Clone, Debug)]
pub enum Signal {
    /// A flapping robot at 3.5 Hz.
    Flapping,
    /// Samples of Fx .. Tz at 7 kHz, N and N m, again and again.
    Samples(Vec<[f64; 6]>),
}

impl Signal {
    fn at(&self, sample: u64) -> [f64; 6] {
        match self {
            Self::Flapping => {
                let (s, c) = (std::f64::consts::TAU * 3.5 * sample as f64 / 7000.0).sin_cos();
                let bend = 2.0 * s * c;
                [0.01 * c, 0.02 * s, 0.4 * s + 0.1 * bend - 0.45, 1e-3 * s, 0.02 * c, 5e-4 * bend]
            }
            Self::Samples(list) => list.get(sample as usize % list.len().max(1)).copied().unwrap_or([0.0; 6]),
        }
    }
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
    /// After this many records the stream stops until it is asked for again; 0 never.
    pub stall_after: u64,
    /// Seed of all this.
    pub seed: u64,
}

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
    /// Stalls.
    pub stalls: u64,
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
/// Records of a buffered datagram.
const PACK: usize = 28;

impl Emulator {
    /// Starts on `address`: UDP 49152 and TCP 80, both plus `port_offset`.
    ///
    /// # Errors
    /// A port that cannot be had.
    pub fn start(address: IpAddr, port_offset: u16, signal: Signal, faults: Faults) -> Result<Self, Error> {
        let port = |base: u16| SocketAddr::new(address, base.wrapping_add(port_offset));
        let bind =
            |at: SocketAddr| move |e| Error::network(format!("{at}: cannot be bound; try --port-offset"), e);
        let udp = UdpSocket::bind(port(RDT_PORT)).map_err(bind(port(RDT_PORT)))?;
        let tcp = TcpListener::bind(port(80)).map_err(bind(port(80)))?;
        udp.set_read_timeout(Some(Duration::from_micros(200)))
            .map_err(|e| Error::network("UDP socket", e))?;
        tcp.set_nonblocking(true).map_err(|e| Error::network("TCP socket", e))?;
        let (stop, sent) = (Arc::new(AtomicBool::new(false)), Arc::new(Mutex::new(Sent::default())));
        let rate = Arc::new(AtomicU32::new(7000));
        let (rdt, http) = (port(RDT_PORT), port(80));
        let stream = Stream::new(udp, signal, faults, Arc::clone(&sent), Arc::clone(&rate));
        let (halt, halt_pages) = (Arc::clone(&stop), Arc::clone(&stop));
        let threads = vec![
            thread::spawn(move || stream.run(&halt)),
            thread::spawn(move || pages(&tcp, &rate, &halt_pages)),
        ];
        Ok(Self { rdt, http, stop, sent, threads })
    }

    /// What was sent until now.
    pub fn sent(&self) -> Sent {
        *self.sent.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
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

/// The stream of records to the client that asked last.
struct Stream {
    socket: UdpSocket,
    signal: Signal,
    faults: Faults,
    random: Random,
    sent: Arc<Mutex<Sent>>,
    rate: Arc<AtomicU32>,
    books: Sent,
    client: Option<Client>,
    offset: [f64; 6],
    samples: u64,
}

/// Whom to send, how, and how far.
struct Client {
    address: SocketAddr,
    buffered: bool,
    left: Option<u64>,
    sequence: u32,
    began: Instant,
    made: u64,
    held: Option<Vec<u8>>,
}

impl Stream {
    fn new(
        socket: UdpSocket,
        signal: Signal,
        faults: Faults,
        sent: Arc<Mutex<Sent>>,
        rate: Arc<AtomicU32>,
    ) -> Self {
        let random = Random::new(faults.seed);
        let books = Sent::default();
        Self { socket, signal, faults, random, sent, rate, books, client: None, offset: [0.0; 6], samples: 0 }
    }

    fn run(mut self, stop: &AtomicBool) {
        let mut buffer = [0; 64];
        while !stop.load(Ordering::Relaxed) {
            if let Ok((size, from)) = self.socket.recv_from(&mut buffer)
                && let Some(request) = Request::parse(&buffer[..size])
            {
                self.obey(request, from);
            }
            self.send_due();
            *self.sent.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = self.books;
        }
    }

    fn obey(&mut self, request: Request, address: SocketAddr) {
        match request.command {
            Command::Stop => self.client = None,
            Command::Bias => self.offset = self.signal.at(self.samples),
            Command::RealTime | Command::Buffered => {
                self.client = Some(Client {
                    address,
                    buffered: request.command == Command::Buffered,
                    left: (request.count > 0).then_some(u64::from(request.count)),
                    sequence: 0,
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
        let rate = f64::from(self.rate.load(Ordering::Relaxed));
        let due = (client.began.elapsed().as_secs_f64() * rate) as u64;
        let pack = if client.buffered { PACK } else { 1 };
        let mut datagram = Vec::with_capacity(pack * RECORD_BYTES);
        while client.made + pack as u64 <= due {
            datagram.clear();
            for _ in 0..pack {
                if client.left == Some(0) {
                    break;
                }
                client.left = client.left.map(|left| left - 1);
                client.made += 1;
                client.sequence = client.sequence.wrapping_add(1);
                let record = self.record(client.sequence);
                datagram.extend(record.bytes());
            }
            if datagram.is_empty() {
                return;
            }
            self.send(&mut client, &datagram);
            if self.faults.stall_after > 0 && client.made >= self.faults.stall_after {
                self.books.stalls += 1;
                return;
            }
        }
        self.client = Some(client);
    }

    fn record(&mut self, rdt_sequence: u32) -> RdtRecord {
        let wrench = self.signal.at(self.samples);
        let loaded = std::array::from_fn(|i| wrench[i] - self.offset[i]);
        self.samples += u64::from(7000 / self.rate.load(Ordering::Relaxed).max(1));
        self.books.records += 1;
        let saturated = self.random.unit() < self.faults.saturation;
        self.books.saturated += u64::from(saturated);
        RdtRecord {
            rdt_sequence,
            ft_sequence: self.samples as u32,
            status: if saturated { 0x8002_0000 } else { 0 },
            counts: SCALE.counts(loaded),
        }
    }

    /// Sends a datagram, or does to it what the faults say.
    fn send(&mut self, client: &mut Client, datagram: &[u8]) {
        let mut happens = |share: f64| share > 0.0 && self.random.unit() < share;
        let (drop, twice) = (happens(self.faults.drop), happens(self.faults.duplicate));
        let (late, slow, garbage) =
            (happens(self.faults.reorder), happens(self.faults.delay), happens(self.faults.garbage));
        let out = |bytes: &[u8]| drop_result(self.socket.send_to(bytes, client.address));
        if drop {
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
            let _ = self.socket.send_to(&bytes, client.address);
        }
    }
}

fn drop_result<T>(result: std::io::Result<T>) {
    // A client that has gone is found out by its silence.
    drop(result);
}

/// Serves the configuration pages until stopped.
fn pages(listener: &TcpListener, rate: &AtomicU32, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        match listener.accept() {
            Ok((stream, _)) => drop_result(answer(stream, rate)),
            Err(_) => thread::sleep(Duration::from_millis(5)),
        }
    }
}

fn answer(mut stream: TcpStream, rate: &AtomicU32) -> std::io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(Duration::from_millis(500)))?;
    let mut buffer = [0; 2048];
    let size = stream.read(&mut buffer)?;
    let request = String::from_utf8_lossy(&buffer[..size]);
    let path = request.split_whitespace().nth(1).unwrap_or("/");
    let (status, body) = match path.split('?').next().unwrap_or("") {
        "/netftapi2.xml" => ("200 OK", xml("cfg", "scfgfu", "scfgtu", rate)),
        "/netftcalapi.xml" => ("200 OK", xml("cal", "calfu", "caltu", rate)),
        "/comm.cgi" => match new_rate(path) {
            Some(hz) => {
                rate.store(hz, Ordering::Relaxed);
                ("200 OK", "<html>saved</html>".into())
            }
            None => ("400 Bad Request", "comrdtrate: 1 to 7000".into()),
        },
        _ => ("404 Not Found", "no such page".into()),
    };
    let head =
        format!("HTTP/1.0 {status}\r\nContent-Type: text/xml\r\nContent-Length: {}\r\n\r\n", body.len());
    stream.write_all(head.as_bytes())?;
    stream.write_all(body.as_bytes())
}

fn xml(prefix: &str, force: &str, torque: &str, rate: &AtomicU32) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<netft><prodname>Net F/T emulator</prodname>\
         <{prefix}cpf>{}</{prefix}cpf><{prefix}cpt>{}</{prefix}cpt><{force}>N</{force}><{torque}>Nm</{torque}>\
         <comrdtrate>{}</comrdtrate></netft>\n",
        SCALE.per_newton,
        SCALE.per_newton_metre,
        rate.load(Ordering::Relaxed)
    )
}

/// The nearest rate below that the box can make: 7000 over a whole number.
fn new_rate(path: &str) -> Option<u32> {
    let (_, query) = path.split_once('?')?;
    let wanted = query.split('&').find_map(|pair| pair.strip_prefix("comrdtrate="))?;
    let hz = wanted.parse::<u32>().ok().filter(|hz| (1..=7000).contains(hz))?;
    Some(7000 / 7000_u32.div_ceil(hz))
}
