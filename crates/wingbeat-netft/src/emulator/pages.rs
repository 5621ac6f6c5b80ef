//! The configuration pages of the emulated box.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread;
use std::time::Duration;

use super::{BOX_RATE, SCALE};

/// Serves the pages until stopped.
pub fn serve(listener: &TcpListener, rate: &AtomicU32, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        match listener.accept() {
            // A client that has gone wants no answer.
            Ok((stream, _)) => drop(answer(stream, rate)),
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
            None => ("400 Bad Request", format!("comrdtrate: 1 to {BOX_RATE}")),
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
         <{prefix}cpf>{}</{prefix}cpf><{prefix}cpt>{}</{prefix}cpt><{force}>N</{force}><{torque}>N-m</{torque}>\
         <comrdtrate>{}</comrdtrate></netft>\n",
        SCALE.per_newton,
        SCALE.per_newton_metre,
        rate.load(Ordering::Relaxed)
    )
}

/// The nearest rate below that the box can make: its own over a whole number.
fn new_rate(path: &str) -> Option<u32> {
    let (_, query) = path.split_once('?')?;
    let wanted = query.split('&').find_map(|pair| pair.strip_prefix("comrdtrate="))?;
    let hz = wanted.parse::<u32>().ok().filter(|hz| (1..=BOX_RATE).contains(hz))?;
    Some(BOX_RATE / BOX_RATE.div_ceil(hz))
}
