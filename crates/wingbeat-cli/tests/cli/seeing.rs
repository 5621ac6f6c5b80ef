//! A run on its page while it is computed, runs over one another, and recordings of ROS 2 there and back.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use wingbeat::rig::process::InputSpec;
use wingbeat_io::read_parquet;
use wingbeat_io::samples::read_samples;

use crate::{entries, root, scratch, wingbeat};

/// What the server at `port` answers to a request for `path`.
fn asked(port: u16, path: &str) -> String {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[test]
fn a_flight_is_watched_by_who_knows_the_word_and_waits_for_nobody() {
    let folder = scratch("watch");
    let scenario = root().join("scenarios/banking_turn.toml").display().to_string();
    let fly = ["fly", &scenario, "--set", "flight.duration_s=1", "--quiet", "--no-report", "--out"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_wingbeat"))
        .args(fly)
        .args(["a", "--watch"])
        .current_dir(&folder)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = String::new();
    BufReader::new(child.stderr.take().unwrap()).read_line(&mut said).unwrap();
    let address = said.strip_prefix("watch: http://127.0.0.1:").unwrap().trim();
    let (port, path) = address.split_once('/').unwrap();
    let (port, path): (u16, String) = (port.parse().unwrap(), format!("/{path}"));
    // Browsers that connect and say nothing, more than are served at a time.
    let _hangs: Vec<TcpStream> = (0..20).map(|_| TcpStream::connect(("127.0.0.1", port)).unwrap()).collect();
    let began = Instant::now();
    let page = asked(port, &path);
    assert!(began.elapsed().as_secs_f64() < 4.0, "{:?}", began.elapsed());
    assert!(page.starts_with("HTTP/1.1 200 OK\r\n"), "{}", &page[..300.min(page.len())]);
    assert!(page.contains("<html lang=\"en\" data-live=\"") && page.contains("connect-src 'self'"));
    let word = path.trim_matches('/');
    assert!(word.len() == 32 && word.bytes().all(|letter| letter.is_ascii_hexdigit()), "{word}");
    for wrong in ["/", "/data?after=0", &format!("/{}/", "0".repeat(32))] {
        assert!(asked(port, wrong).starts_with("HTTP/1.1 404"), "{wrong}");
    }
    let news = asked(port, &format!("{path}data?after=0"));
    let shown = |news: &str| news[news.len().saturating_sub(300)..].to_owned();
    assert!(news.contains("\"ended\":") && news.contains("\"bytes\":\""), "{}", shown(&news));
    // Who asks on is told what has come since, and the end before the program goes.
    let number = |news: &str, key: &str| -> Option<u64> {
        let (_, rest) = news.split_once(&format!("\"{key}\":"))?;
        rest.split(|letter: char| !letter.is_ascii_digit()).next()?.parse().ok()
    };
    let (mut version, mut grown) = (number(&news, "version").unwrap(), false);
    assert_eq!(number(&news, "after"), None);
    loop {
        let more = asked(port, &format!("{path}data?after={version}"));
        if more.starts_with("HTTP/1.1 204") {
            std::thread::sleep(Duration::from_millis(20));
            continue;
        }
        grown |= number(&more, "after") == Some(version);
        version = number(&more, "version").unwrap_or_else(|| panic!("{}", shown(&more)));
        if more.contains("\"ended\":true") {
            break;
        }
    }
    assert!(grown, "rows behind those that were known");
    assert!(child.wait().unwrap().success());
    assert!(TcpStream::connect(("127.0.0.1", port)).is_err(), "it ends with the run");
    assert!(wingbeat(&folder, &[&fly[..], &["b"]].concat()).status.success());
    assert_eq!(entries(&folder.join("a")), entries(&folder.join("b")));
    for file in ["record.parquet", "scenario.toml", "figures/states.svg"] {
        let read = |run: &str| fs::read(folder.join(run).join(file)).unwrap();
        assert!(read("a") == read("b"), "{file}");
    }
}

#[test]
fn runs_are_drawn_over_one_another() {
    let folder = scratch("sheet");
    let scenario = root().join("scenarios/glider.toml").display().to_string();
    for (out, seconds) in [("a", "0.1"), ("b", "0.2")] {
        let set = format!("flight.duration_s={seconds}");
        let output =
            wingbeat(&folder, &["fly", &scenario, "--set", &set, "--quiet", "--no-report", "--out", out]);
        assert!(output.status.success(), "{output:?}");
    }
    let drawn = |more: &[&str]| wingbeat(&folder, &[&["report", "a", "b", "--quiet"], more].concat());
    assert!(drawn(&["--sheet", "s.png"]).status.success());
    assert!(drawn(&["--sheet", "s.svg"]).status.success());
    assert_eq!(entries(&folder), ["a", "b", "s.png", "s.svg"]);
    let figure = fs::read_to_string(folder.join("s.svg")).unwrap();
    for word in ["a: roll, right wing down +", "b: roll, right wing down +", "height [m]", "time [s]"] {
        assert!(figure.contains(word), "{word}");
    }
    for (more, said) in [
        (&["--sheet", "s.pdf"][..], "allowed is a figure, FILE.png or FILE.svg"),
        (&["--sheet", "s.png"], "s.png: is there already"),
        (&["--sheet", "a"], "allowed is a figure"),
        (&["--force"], "--force: allowed with --out or --sheet"),
        (&["--sheet", "t.png", "--no-wake"], "cannot be used with"),
    ] {
        let output = drawn(more);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && told.contains(said), "{more:?}: {told}");
    }
    assert!(drawn(&["--sheet", "s.png", "--force"]).status.success());
}

#[test]
fn a_run_on_the_rig_goes_to_ros_and_back() {
    let folder = scratch("rig-mcap");
    let run = root().join("rigs/runs/bench.toml").display().to_string();
    let done = |arguments: &[&str]| {
        let output = wingbeat(&folder, &[arguments, &["--quiet"]].concat());
        // A second and a half of strokes is too short for their frequency: suspect_data, both times.
        let short = arguments[1] == "process" && output.status.code() == Some(3);
        assert!(output.status.success() || short, "{arguments:?}: {output:?}");
    };
    done(&["rig", "simulate", &run, "--set", "hold.each_s=1.5", "--no-report", "--out", "sim"]);
    done(&["export", "sim", "--mcap", "--out", "a.mcap"]);
    let name = entries(&folder.join("sim")).into_iter().find(|name| name != "manifest.json").unwrap();
    let scenario = format!("sim/{name}/scenario.toml");
    done(&["rig", "process", "a.mcap", "--run", &scenario, "--out", "read"]);
    assert!(folder.join("read/report.html").is_file());
    // Mean, band, truth and model of a channel share a plot.
    let shown = wingbeat_report::run::read(&folder.join("read")).unwrap();
    let lift = shown[0].panels.iter().find(|panel| panel.title == "Fz").unwrap();
    let labels: Vec<&str> = lift.curves.iter().map(|curve| curve.label.as_str()).collect();
    assert_eq!((labels, lift.unit), (vec!["mean", "truth", "model", "low", "high"], "N"));
    // Every number that was recorded comes back as it was; times are kept to the nanosecond.
    let input = InputSpec::default();
    let read = read_samples(&folder.join("a.mcap"), &input).and_then(|table| table.import(&input)).unwrap();
    let raw = read_parquet(&folder.join("sim").join(&name).join("record.parquet")).unwrap();
    let names = read.record.columns().iter().map(|column| column.name.as_str());
    let kept = |name: &str| names.clone().any(|other| other == name);
    assert!(["t", "phase", "Fx", "Tz", "true_Fx"].into_iter().all(kept) && read.import.cautions.is_empty());
    for name in names {
        let (a, b) = (raw.values(name).unwrap(), read.record.values(name).unwrap());
        let size = a.iter().fold(1e-9_f64, |size, value| size.max(value.abs()));
        let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let most = if name == "t" { 1e-9 } else { 1e-12 * size };
        assert!(a.len() == b.len() && apart <= most, "{name}: {apart} of {size}, {} of {}", b.len(), a.len());
    }
    damaged(&folder, &scenario);
}

/// Files that are no whole recording end with one message and no folder.
fn damaged(folder: &Path, scenario: &str) {
    let whole = fs::read(folder.join("a.mcap")).unwrap();
    let changed = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = whole.clone();
        change(&mut bytes);
        bytes
    };
    let find = |word: &[u8]| whole.windows(word.len()).position(|there| there == word).unwrap();
    let encoding = find(b"\x03\x00\x00\x00cdr") + 4;
    let size = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| whole[at + 1 + i]));
    // The first chunk: its sum stands 24 bytes into it, its compression behind that.
    let mut chunk = 8;
    while whole[chunk] != 6 {
        chunk += 9 + size(chunk) as usize;
    }
    let crc = chunk + 9 + 24;
    let cases: [(&str, Vec<u8>, &str); 5] = [
        ("cut.mcap", whole[..whole.len() / 2].to_vec(), "cut short"),
        ("head.mcap", whole[..8].to_vec(), "cut short"),
        ("flipped.mcap", changed(&|bytes| bytes[chunk + 5000] ^= 1), "check sum"),
        (
            "zstd.mcap",
            changed(&|bytes| {
                let rest = bytes.split_off(crc + 4);
                bytes.extend(b"\x04\x00\x00\x00zstd");
                bytes.extend(&rest[4..]);
                let size = size(chunk) + 4;
                bytes[chunk + 1..chunk + 9].copy_from_slice(&size.to_le_bytes());
            }),
            "compressed by zstd",
        ),
        (
            "ros1.mcap",
            changed(&|bytes| {
                bytes[crc..crc + 4].fill(0);
                bytes[encoding..encoding + 3].copy_from_slice(b"ro1");
            }),
            "messages in ro1; allowed is cdr",
        ),
    ];
    for (name, bytes, said) in cases {
        fs::write(folder.join(name), bytes).unwrap();
        let output =
            wingbeat(folder, &["rig", "process", name, "--run", scenario, "--quiet", "--out", "none"]);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        let refused = output.status.code() == Some(2) && told.contains(said) && told.lines().count() == 1;
        assert!(refused && !folder.join("none").exists(), "{name}: {told}");
    }
}
