//! The server of one page: on 127.0.0.1, at a port that the system gives, behind a random word, as long as it lives.

use std::hash::{BuildHasher, RandomState};
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::Question;

/// Longest request that is read, bytes.
const LONGEST: usize = 8 << 10;
/// Most browsers at a time; who comes beyond takes the place of the one that has been silent longest.
const MOST: usize = 8;
/// Time in which a request must be there, and an answer taken.
const PATIENCE: Duration = Duration::from_secs(5);
/// Rest after a connection that the system could not give. *Choice.*
const PAUSE: Duration = Duration::from_millis(100);

/// What a browser asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PageRequest {
    /// The page.
    Page,
    /// What has come since this version.
    DataAfter(u64),
}

/// A server; dropped, it ends.
pub struct Server {
    at: SocketAddr,
    token: String,
    ended: Arc<AtomicBool>,
    guests: Guests,
}

impl Server {
    /// Listens from now on; what is asked goes to `questions`.
    ///
    /// # Errors
    /// No port, or no thread.
    pub fn begin(questions: Sender<Question>) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let server = Self {
            at: listener.local_addr()?,
            token: token(),
            ended: Arc::default(),
            guests: Guests::default(),
        };
        let (token, ended, guests) = (server.token.clone(), server.ended.clone(), server.guests.clone());
        let port = server.at.port();
        thread::Builder::new()
            .name("watch".into())
            .spawn(move || accept(&listener, (port, &token), &ended, &questions, &guests))?;
        Ok(server)
    }

    /// Whether somebody who has asked is still being answered.
    pub fn answers(&self) -> bool {
        self.guests.all().iter().any(|guest| guest.heard)
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        format!("http://{}/{}/", self.at, self.token)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        // Wakes the thread that waits for a browser; where it cannot be woken it ends with the program.
        let _ = TcpStream::connect_timeout(&self.at, Duration::from_millis(100));
    }
}

/// A word of 128 bits: two values of the keyed hash of the standard library, whose key of 128 bits comes from the system and is used
/// for nothing else.
fn token() -> String {
    let keyed = RandomState::new();
    [0_u8, 1].iter().map(|number| format!("{:016x}", keyed.hash_one(number))).collect()
}

/// The browsers that are served, the first that came first.
#[derive(Clone, Default)]
struct Guests(Arc<Mutex<Vec<Guest>>>);

struct Guest {
    number: u64,
    stream: TcpStream,
    /// Whether its request is there.
    heard: bool,
}

impl Guests {
    fn all(&self) -> MutexGuard<'_, Vec<Guest>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes room for one more; without success where all have asked and are being answered.
    fn admit(&self, number: u64, stream: TcpStream) -> bool {
        let mut all = self.all();
        if all.len() >= MOST {
            let Some(silent) = all.iter().position(|guest| !guest.heard) else { return false };
            // Its thread wakes and ends.
            let _ = all.remove(silent).stream.shutdown(Shutdown::Both);
        }
        all.push(Guest { number, stream, heard: false });
        true
    }

    fn heard(&self, number: u64) {
        self.all().iter_mut().filter(|guest| guest.number == number).for_each(|guest| guest.heard = true);
    }

    fn leave(&self, number: u64) {
        self.all().retain(|guest| guest.number != number);
    }
}

fn accept(
    listener: &TcpListener,
    (port, token): (u16, &str),
    ended: &AtomicBool,
    questions: &Sender<Question>,
    guests: &Guests,
) {
    for number in 0.. {
        let accepted = listener.accept();
        if ended.load(Ordering::Acquire) {
            return;
        }
        let Ok((stream, _)) = accepted else {
            thread::sleep(PAUSE);
            continue;
        };
        if !stream.try_clone().is_ok_and(|other| guests.admit(number, other)) {
            continue;
        }
        let (token, questions, here) = (token.to_owned(), questions.clone(), guests.clone());
        let serve = move || {
            // A browser that hangs or goes away is no matter of the run.
            let _ = serve(stream, port, &token, &questions, || here.heard(number));
            here.leave(number);
        };
        if thread::Builder::new().name("watch answer".into()).spawn(serve).is_err() {
            guests.leave(number);
        }
    }
}

/// Answers one request; `heard` is called when it is there.
fn serve(
    mut stream: TcpStream,
    port: u16,
    token: &str,
    questions: &Sender<Question>,
    heard: impl FnOnce(),
) -> io::Result<()> {
    let until = Instant::now() + PATIENCE;
    let request = request(&mut stream, until)?;
    heard();
    let answer = match asked(&request, port, token) {
        Err(status) => reply(status, "text/plain", "wingbeat: not here\n"),
        Ok(asked) => {
            let (sender, receiver) = channel();
            let lost = |_| io::Error::from(io::ErrorKind::BrokenPipe);
            questions.send((asked, sender)).map_err(lost)?;
            let text = receiver.recv().map_err(|_| io::Error::from(io::ErrorKind::BrokenPipe))?;
            let kind = if asked == PageRequest::Page { "text/html" } else { "application/json" };
            match text {
                Some(text) => reply("200 OK", kind, &text),
                None => reply("204 No Content", kind, ""),
            }
        }
    };
    written(&mut stream, &answer, Instant::now() + PATIENCE)
}

/// The head of a request.
fn request(stream: &mut TcpStream, until: Instant) -> io::Result<String> {
    let (mut head, mut piece) = (Vec::new(), [0; 1024]);
    loop {
        stream.set_read_timeout(Some(left(until)?))?;
        match stream.read(&mut piece)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            read => head.extend_from_slice(&piece[..read]),
        }
        if head.windows(4).any(|end| end == b"\r\n\r\n") {
            return String::from_utf8(head).map_err(|_| io::ErrorKind::InvalidData.into());
        }
        if head.len() > LONGEST {
            return Err(io::ErrorKind::InvalidData.into());
        }
    }
}

fn written(stream: &mut TcpStream, mut bytes: &[u8], until: Instant) -> io::Result<()> {
    while !bytes.is_empty() {
        stream.set_write_timeout(Some(left(until)?))?;
        let sent = stream.write(bytes)?;
        bytes = bytes.get(sent.max(1)..).unwrap_or_default();
    }
    Ok(())
}

/// The time that is left.
fn left(until: Instant) -> io::Result<Duration> {
    let left = until.saturating_duration_since(Instant::now());
    if left.is_zero() { Err(io::ErrorKind::TimedOut.into()) } else { Ok(left) }
}

/// What a request asks for, or the status that refuses it.
fn asked(request: &str, port: u16, token: &str) -> Result<PageRequest, &'static str> {
    const NONE: &str = "404 Not Found";
    let mut lines = request.split("\r\n");
    let mut words = lines.next().unwrap_or_default().split(' ');
    let (method, path) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    // A name that another page made to point here is none of these.
    let known = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    let host = |line: &str| {
        let (name, value) = line.split_once(':')?;
        name.eq_ignore_ascii_case("host").then(|| value.trim().to_owned())
    };
    if !lines.filter_map(host).any(|host| known.contains(&host)) {
        return Err(NONE);
    }
    let (word, rest) = path.strip_prefix('/').and_then(|path| path.split_once('/')).ok_or(NONE)?;
    if !same(word.as_bytes(), token.as_bytes()) {
        return Err(NONE);
    }
    if method != "GET" {
        return Err("405 Method Not Allowed");
    }
    match rest.strip_prefix("data?after=") {
        Some(version) => version.parse().map(PageRequest::DataAfter).map_err(|_| NONE),
        None if rest.is_empty() => Ok(PageRequest::Page),
        None => Err(NONE),
    }
}

/// Whether two words are the same, in a time that does not depend on where they differ.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |differs, (a, b)| differs | (a ^ b)) == 0
}

fn reply(status: &str, kind: &str, text: &str) -> Vec<u8> {
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {}\r\nConnection: close\r\n\
         Cache-Control: no-store\r\nReferrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\n\
         X-Frame-Options: DENY\r\nCross-Origin-Resource-Policy: same-origin\r\n\r\n",
        text.len()
    );
    [head.as_bytes(), text.as_bytes()].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_who_knows_the_word_is_answered() {
        let token = token();
        assert!(token.len() == 32 && token != super::token());
        let ask = |path: &str, host: &str| {
            asked(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n"), 4000, &token)
        };
        assert_eq!(ask(&format!("/{token}/"), "127.0.0.1:4000"), Ok(PageRequest::Page));
        assert_eq!(ask(&format!("/{token}/data?after=7"), "localhost:4000"), Ok(PageRequest::DataAfter(7)));
        let wrong = [
            ("/".to_owned(), "127.0.0.1:4000"),
            (format!("/{token}"), "127.0.0.1:4000"),
            (format!("/{}/", "0".repeat(32)), "127.0.0.1:4000"),
            (format!("/{token}/"), "evil.example:4000"),
            (format!("/{token}/"), "127.0.0.1:4001"),
            (format!("/{token}/data?after=-1"), "127.0.0.1:4000"),
            (format!("/{token}/../etc/passwd"), "127.0.0.1:4000"),
        ];
        for (path, host) in wrong {
            assert!(ask(&path, host).is_err(), "{path} {host}");
        }
        let post = format!("POST /{token}/ HTTP/1.1\r\nhost: 127.0.0.1:4000\r\n\r\n");
        assert_eq!(asked(&post, 4000, &token), Err("405 Method Not Allowed"));
    }
}
