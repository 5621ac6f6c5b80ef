//! Class 2: boxes whose configuration pages never end or are none; pages that lie are data, `files.toml`.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use super::super::place::CaseFolder;
use super::{ScriptedCase, holds};

/// A server of one answer on a port of its own, as long as the program runs; the offset of its port.
fn serve(answer: impl Fn(&mut TcpStream) + Send + 'static) -> Result<String, String> {
    let failed = |error: std::io::Error| error.to_string();
    let listener = loop {
        let listener = TcpListener::bind("127.0.0.1:0").map_err(failed)?;
        // An offset above 16383 would carry the other port beyond the last.
        if listener.local_addr().map_err(failed)?.port() < 16_000 {
            break listener;
        }
        if let Some(listener) = (13_000..16_000).find_map(|port| TcpListener::bind(("127.0.0.1", port)).ok())
        {
            break listener;
        }
    };
    let port = listener.local_addr().map_err(failed)?.port();
    thread::spawn(move || {
        for mut stream in listener.incoming().flatten() {
            let _ = stream.read(&mut [0; 2048]);
            answer(&mut stream);
        }
    });
    Ok((port - 80).to_string())
}

fn record<'a>(place: &'a CaseFolder, offset: &str) -> super::super::place::Call<'a> {
    place.call(&["rig", "record", "127.0.0.1", "--port-offset", offset, "--out", "taken", "--duration", "1"])
}

/// Serves `page` to whoever asks; the offset of its port.
pub fn serve_page(page: Vec<u8>) -> Result<String, String> {
    serve(move |stream| {
        let head = format!("HTTP/1.0 200 OK\r\nContent-Length: {}\r\n\r\n", page.len());
        let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(&page));
    })
}

/// A box that does `answer` to whoever connects: refused within eight seconds, with each of `words`.
fn connection(
    name: &str,
    answer: impl Fn(&mut TcpStream) + Send + Sync + Clone + 'static,
    words: &'static [&'static str],
) -> ScriptedCase {
    let case = ScriptedCase::new(2, name, move |place| {
        let offset = serve(answer.clone())?;
        let begun = Instant::now();
        record(place, &offset).run()?.exits(2)?.says(&["http://127.0.0.1"])?.says(words)?;
        holds(begun.elapsed() < Duration::from_secs(8), format!("after {:?}", begun.elapsed()))?;
        place.holds("", &[])
    });
    case.long()
}

fn byte_by_byte(stream: &mut TcpStream) {
    while stream.write_all(b"H").is_ok() {
        thread::sleep(Duration::from_secs(1));
    }
}

fn flood(stream: &mut TcpStream) {
    let _ = stream.write_all(b"HTTP/1.0 200 OK\r\n\r\n");
    while stream.write_all(&[b'x'; 65_536]).is_ok() {}
}

/// The cases.
pub fn cases() -> Vec<ScriptedCase> {
    let interrupted = |name: &str, signal: &'static str| {
        let case = ScriptedCase::new(2, name, move |place| {
            let offset = serve(byte_by_byte)?;
            record(place, &offset)
                .signal(signal, Duration::from_millis(1500))
                .run()?
                .exits(130)?
                .in_time()?;
            place.holds("", &[])
        });
        case.long()
    };
    vec![
        connection("box_byte_by_byte", byte_by_byte, &["within 5 s"]),
        connection("box_mute_page", |_| thread::sleep(Duration::from_secs(30)), &["within 5 s"]),
        connection("box_flood", flood, &["longer than 262144 bytes"]),
        connection("box_closes", |_| {}, &["cut short"]),
        connection(
            "box_no_page",
            |s| drop(s.write_all(b"HTTP/1.0 404 Not Found\r\n\r\n")),
            &["404 Not Found"],
        ),
        connection(
            "box_cut_page",
            |s| drop(s.write_all(b"HTTP/1.0 200 OK\r\nContent-Length: 99\r\n\r\n<n")),
            &["2 of 99 bytes"],
        ),
        interrupted("box_slow_interrupted", "INT"),
        interrupted("box_slow_terminated", "TERM"),
    ]
}
