//! Class 2 and 5: boxes whose configuration pages lie, never end, or are none.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use super::super::place::Place;
use super::{Case, holds};

/// The cases.
pub fn cases() -> Vec<Case> {
    [bodies(), connections()].into_iter().flatten().collect()
}

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

fn record<'a>(place: &'a Place, offset: &str) -> super::super::place::Call<'a> {
    place.call(&["rig", "record", "127.0.0.1", "--port-offset", offset, "--out", "taken", "--duration", "1"])
}

/// A page that is refused with each of `words`, and leaves nothing.
fn page(
    name: &str,
    body: impl Fn() -> String + Send + Sync + Clone + 'static,
    words: &'static [&'static str],
) -> Case {
    Case::new(5, name, move |place| {
        let body = body.clone();
        let offset = serve(move |stream| {
            let text = body();
            let head = format!("HTTP/1.0 200 OK\r\nContent-Length: {}\r\n\r\n", text.len());
            let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(text.as_bytes()));
        })?;
        record(place, &offset).run()?.exits(2)?.says(&["http://127.0.0.1"])?.says(words)?;
        place.holds("", &[])
    })
}

const PAGE: &str = "<?xml version=\"1.0\"?><netft><cfgcpf>1000000</cfgcpf><cfgcpt>1000000</cfgcpt><scfgfu>N</scfgfu>\
                    <scfgtu>N-m</scfgtu><comrdtrate>7000</comrdtrate></netft>";

fn with(from: &'static str, to: &'static str) -> impl Fn() -> String + Send + Sync + Clone + 'static {
    move || PAGE.replacen(from, to, 1)
}

fn bodies() -> Vec<Case> {
    let factor = "<cfgcpf>1000000</cfgcpf>";
    vec![
        page("page_comment", with(factor, "<!-- <cfgcpf>1000000</cfgcpf> -->"), &["no element <cfgcpf>"]),
        page("page_cdata", with(factor, "<x><![CDATA[<cfgcpf>7</cfgcpf>]]></x>"), &["no element <cfgcpf>"]),
        page("page_twice", with(factor, "<cfgcpf>5</cfgcpf><cfgcpf>6</cfgcpf>"), &["different values"]),
        page("page_denormal", with("1000000", "1e-320"), &["cfgcpf = 1e-320"]),
        page("page_zero", with("1000000", "0"), &["cfgcpf = 0"]),
        page("page_huge", with("1000000", "1e300"), &["cfgcpf = 1e300"]),
        page("page_nan", with("1000000", "nan"), &["cfgcpf = nan"]),
        page("page_unit", with(">N<", ">stone<"), &["scfgfu = stone"]),
        page("page_rate", with("7000", "0"), &["comrdtrate = 0"]),
        page("page_rate_above", with("7000", "1e9"), &["comrdtrate = 1e9"]),
        page("page_cut", with("</netft>", ""), &["not a whole page of XML"]),
        page("page_html", || "<html><p>Login<br></html>".into(), &["XML"]),
        page("page_empty", String::new, &["XML"]),
        page("page_deep", || "<a>".repeat(60_000), &["deep"]),
        page(
            "page_entities",
            || {
                let e = "&a;".repeat(5000);
                format!("<!DOCTYPE n [<!ENTITY a \"{}\">]><netft>{e}</netft>", "a".repeat(5000))
            },
            &[],
        ),
    ]
}

/// A box that does `answer` to whoever connects: refused within eight seconds, with each of `words`.
fn connection(
    name: &str,
    answer: impl Fn(&mut TcpStream) + Send + Sync + Clone + 'static,
    words: &'static [&'static str],
) -> Case {
    let case = Case::new(2, name, move |place| {
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

fn connections() -> Vec<Case> {
    let interrupted = |name: &str, signal: &'static str| {
        let case = Case::new(2, name, move |place| {
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
