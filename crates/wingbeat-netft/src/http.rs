//! The box's configuration pages over HTTP.

use std::io::{Error as IoError, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use wingbeat::rig::netft::Scale;

use crate::{Config, Error};

/// Longest answer that is read, bytes.
const LONGEST: usize = 256 << 10;
/// Longest time for all pages together.
const PATIENCE: Duration = Duration::from_secs(5);
/// Longest wait before it is asked whether to go on.
const SLICE: Duration = Duration::from_millis(200);

/// Reads scale factors and rate from `/netftapi2.xml`, or else `/netftcalapi.xml`.
///
/// # Errors
/// No connection, no whole answer within five seconds, or neither page holds them: what the first page lacks.
pub fn read_config(address: SocketAddr) -> Result<Config, Error> {
    read_config_while(address, &|| true)
}

/// The same as long as `goes_on` says so, which is asked five times a second.
///
/// # Errors
/// Those of [`read_config`]; one of kind [`ErrorKind::Interrupted`] when it was told to stop.
pub fn read_config_while(address: SocketAddr, goes_on: &dyn Fn() -> bool) -> Result<Config, Error> {
    let wait = Wait { end: Instant::now() + PATIENCE, goes_on };
    let mut first = None;
    for page in ["/netftapi2.xml", "/netftcalapi.xml"] {
        let url = format!("http://{address}{page}");
        let answer = get(address, page, &wait).map_err(|source| {
            let why = format!("{url}: no whole answer; is the box on and the address right?");
            Error::network(why, source)
        })?;
        let found = body(&answer).and_then(|body| Config::of_page(body, page));
        match found {
            Ok(config) => return Ok(config),
            Err(what) => first = first.or(Some(Error::Answer { url, what })),
        }
    }
    Err(first.unwrap_or_else(|| Error::Answer { url: address.to_string(), what: "no page".into() }))
}

/// The scale factors alone.
///
/// # Errors
/// Those of [`read_config`].
pub fn get_scale(address: SocketAddr) -> Result<Scale, Error> {
    Ok(read_config(address)?.scale)
}

/// Until when to wait, and whether to go on at all.
struct Wait<'a> {
    end: Instant,
    goes_on: &'a dyn Fn() -> bool,
}

impl Wait<'_> {
    /// The next wait, if there is time for one.
    fn slice(&self) -> Result<Duration, IoError> {
        if !(self.goes_on)() {
            return Err(ErrorKind::Interrupted.into());
        }
        let left = self.end.saturating_duration_since(Instant::now());
        match left.is_zero() {
            true => Err(IoError::new(ErrorKind::TimedOut, format!("within {} s", PATIENCE.as_secs()))),
            false => Ok(left.min(SLICE)),
        }
    }
}

/// True of an error that says only that a wait is over.
fn waits(error: &IoError) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

/// An answer of bounded length, head and body.
fn get(address: SocketAddr, page: &str, wait: &Wait) -> Result<Vec<u8>, IoError> {
    let mut stream = loop {
        match TcpStream::connect_timeout(&address, wait.slice()?) {
            Ok(stream) => break stream,
            Err(error) if waits(&error) => {}
            Err(error) => return Err(error),
        }
    };
    let request = format!("GET {page} HTTP/1.0\r\nHost: {}\r\nConnection: close\r\n\r\n", address.ip());
    stream.set_write_timeout(Some(wait.slice()?))?;
    stream.write_all(request.as_bytes())?;
    let (mut answer, mut part) = (Vec::new(), [0; 4096]);
    loop {
        stream.set_read_timeout(Some(wait.slice()?))?;
        match stream.read(&mut part) {
            Ok(0) => return Ok(answer),
            Ok(size) => answer.extend(&part[..size]),
            Err(error) if waits(&error) => {}
            Err(error) => return Err(error),
        }
        if answer.len() > LONGEST {
            return Err(IoError::other(format!("longer than {LONGEST} bytes")));
        }
    }
}

/// What the box says in an answer of its web server, head and page.
///
/// # Errors
/// What is wrong with it.
pub fn parse_answer(bytes: &[u8]) -> Result<Config, String> {
    Config::of_page(body(bytes)?, "")
}

/// The page of a whole answer whose status is 200.
fn body(answer: &[u8]) -> Result<&[u8], String> {
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").ok_or("the answer is cut short")?;
    let (head, body) = (String::from_utf8_lossy(&answer[..end]), &answer[end + 4..]);
    let status = head.lines().next().unwrap_or("");
    if status.split_whitespace().nth(1) != Some("200") {
        return Err(format!("the box answers `{}`", status.chars().take(80).collect::<String>()));
    }
    let length = head.lines().find_map(|line| {
        let (name, value) = line.split_once(':')?;
        value.trim().parse::<usize>().ok().filter(|_| name.eq_ignore_ascii_case("content-length"))
    });
    match length {
        Some(length) if body.len() < length => {
            Err(format!("the answer is cut short: {} of {length} bytes", body.len()))
        }
        _ => Ok(body),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;
    use std::thread;

    #[test]
    fn heads_are_read_and_cut_answers_are_told() {
        let answer =
            |head: &str, page: &str| body(format!("{head}\r\n\r\n{page}").as_bytes()).map(<[u8]>::len);
        assert_eq!(answer("HTTP/1.0 200 OK", "four"), Ok(4));
        assert_eq!(answer("HTTP/1.0 200 OK\r\ncontent-length: 4", "four"), Ok(4));
        let cut = answer("HTTP/1.0 200 OK\r\nContent-Length: 40", "four");
        assert_eq!(cut, Err("the answer is cut short: 4 of 40 bytes".into()));
        assert_eq!(
            answer("HTTP/1.0 404 Not Found", ""),
            Err("the box answers `HTTP/1.0 404 Not Found`".into())
        );
        assert!(body(b"HTTP/1.0 200 OK\r\n").is_err());
    }

    /// A box that answers one byte at a time, without end.
    fn slow_box() -> SocketAddr {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        thread::spawn(move || {
            for mut stream in listener.incoming().flatten() {
                while stream.write_all(b"H").is_ok() {
                    thread::sleep(Duration::from_millis(300));
                }
            }
        });
        address
    }

    #[test]
    fn a_box_that_answers_byte_by_byte_has_one_deadline() {
        let began = Instant::now();
        let error = read_config(slow_box()).unwrap_err().to_string();
        assert!(error.contains("within 5 s"), "{error}");
        assert!(began.elapsed() < PATIENCE + Duration::from_secs(2), "{:?}", began.elapsed());
    }

    #[test]
    fn waiting_ends_when_told_to() {
        let began = Instant::now();
        let error =
            read_config_while(slow_box(), &|| began.elapsed() < Duration::from_millis(300)).unwrap_err();
        let interrupted =
            matches!(&error, Error::Network { source, .. } if source.kind() == ErrorKind::Interrupted);
        assert!(interrupted && began.elapsed() < Duration::from_secs(2), "{error} {:?}", began.elapsed());
    }
}
