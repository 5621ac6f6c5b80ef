//! The box's configuration pages over HTTP.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use wingbeat::rig::netft::Scale;

use crate::Error;

/// Longest answer that is read, bytes.
const LONGEST: u64 = 256 << 10;
/// Longest wait for the box, s.
const PATIENCE: Duration = Duration::from_secs(3);

/// What the box says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Counts per N and N m.
    pub scale: Scale,
    /// Where it was found.
    pub page: String,
}

/// Reads the scale factors from `/netftapi2.xml`, or else `/netftcalapi.xml`.
///
/// # Errors
/// No connection, or neither page holds them: what the first page lacks.
pub fn read_config(address: SocketAddr) -> Result<Config, Error> {
    let mut first = None;
    for page in ["/netftapi2.xml", "/netftcalapi.xml"] {
        let answer = get(address, page).and_then(|text| {
            Scale::from_xml(&text).map_err(|error| Error::Answer {
                url: format!("http://{address}{page}"),
                what: error.to_string(),
            })
        });
        match answer {
            Ok(scale) => return Ok(Config { scale, page: page.into() }),
            Err(error @ Error::Network { .. }) => return Err(error),
            Err(error) => first = first.or(Some(error)),
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

/// The body of a page of bounded length.
fn get(address: SocketAddr, page: &str) -> Result<String, Error> {
    let url = format!("http://{address}{page}");
    let failed =
        |source| Error::network(format!("{url}: no answer; is the box on and the address right?"), source);
    let mut stream = TcpStream::connect_timeout(&address, PATIENCE).map_err(failed)?;
    stream.set_read_timeout(Some(PATIENCE)).map_err(failed)?;
    let request = format!("GET {page} HTTP/1.0\r\nHost: {}\r\nConnection: close\r\n\r\n", address.ip());
    stream.write_all(request.as_bytes()).map_err(failed)?;
    let mut bytes = Vec::new();
    stream.take(LONGEST).read_to_end(&mut bytes).map_err(failed)?;
    body(&String::from_utf8_lossy(&bytes)).map(str::to_owned).map_err(|what| Error::Answer { url, what })
}

/// The scale factors in an answer of the box's web server, head and page.
///
/// # Errors
/// What is wrong with it.
pub fn parse_answer(bytes: &[u8]) -> Result<Scale, String> {
    Scale::from_xml(body(&String::from_utf8_lossy(bytes))?).map_err(|error| error.to_string())
}

/// The page of a whole answer whose status is 200.
fn body(text: &str) -> Result<&str, String> {
    let (head, body) = text.split_once("\r\n\r\n").ok_or("the answer is cut short")?;
    let status = head.lines().next().unwrap_or("");
    if status.split_whitespace().nth(1) != Some("200") {
        return Err(status.to_owned());
    }
    Ok(body)
}
