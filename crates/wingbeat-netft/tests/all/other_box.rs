//! The recorder reads a box that shares no line with it: tests/box.py.

use std::io::{BufRead, BufReader};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use wingbeat::rig::netft::Scale;
use wingbeat_netft::{RecordingEnd, RecordingOptions, Report, Row, read_config, read_log, record};

/// A running box.py; dropped, it ends.
struct Box {
    child: Child,
    rdt: SocketAddr,
    pages: SocketAddr,
}

impl Box {
    /// None, and a message, where there is no Python 3.
    fn start(rdt: u16, pages: u16) -> Option<Self> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/box.py");
        let mut command = Command::new("python3");
        command.arg(script).args([rdt.to_string(), pages.to_string()]).stdout(Stdio::piped());
        let Ok(mut child) = command.spawn() else {
            eprintln!("skipped: there is no python3 to run the other box");
            return None;
        };
        let mut line = String::new();
        BufReader::new(child.stdout.take()?).read_line(&mut line).unwrap();
        assert_eq!(line.trim(), "ready");
        let at = |port| SocketAddr::from((Ipv4Addr::LOCALHOST, port));
        Some(Self { child, rdt: at(rdt), pages: at(pages) })
    }

    /// Records `count` records.
    fn record(&self, count: u64, buffered: bool) -> (Report, Vec<Row>) {
        let mut options = RecordingOptions::new(self.rdt);
        (options.count, options.buffered) = (count, buffered);
        options.duration = Some(Duration::from_secs(60));
        let folder = std::env::temp_dir().join(format!("wingbeat-box-{buffered}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        let report = record(&options, &self.scale(), &folder, "raw", |_| true).unwrap();
        let rows = read_log(&report.files[0]).unwrap().map(Result::unwrap).collect();
        std::fs::remove_dir_all(folder).unwrap();
        (report, rows)
    }

    fn scale(&self) -> Scale {
        read_config(self.pages).unwrap().scale
    }
}

impl Drop for Box {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Counts of box.py at its sample `k`.
fn wave(k: u32) -> [i32; 6] {
    let angle = std::f64::consts::TAU * 3.5 * f64::from(k) / 7000.0;
    std::array::from_fn(|i| {
        let i = i as f64;
        ((500_000.0 + 1000.0 * i) * (angle + i).sin()).round() as i32
    })
}

#[test]
fn every_sample_of_another_box_is_read() {
    let Some(other) = Box::start(49891, 49892) else { return };
    // Its counts are per lbf and lbf-in: a million per newton and newton metre.
    let scale = other.scale();
    assert!(
        (scale.per_newton - 1e6).abs() < 1e-3 && (scale.per_newton_metre - 1e6).abs() < 1e-3,
        "{scale:?}"
    );
    for (buffered, count) in [(false, 3500), (true, 3520)] {
        let (report, rows) = other.record(count, buffered);
        let a = &report.account;
        assert_eq!(report.ending, RecordingEnd::Complete);
        assert_eq!((a.received, a.lost, a.duplicates, a.malformed, a.restarts), (count, 0, 0, 0, 0));
        for (k, row) in rows.iter().enumerate() {
            assert_eq!(row.record.rdt_sequence as usize, k + 1);
            // Python and Rust may round half a count to either side.
            let there = wave(row.record.ft_sequence);
            assert!(row.record.counts.iter().zip(there).all(|(a, b)| (a - b).abs() <= 1), "{row:?}");
        }
    }
}
