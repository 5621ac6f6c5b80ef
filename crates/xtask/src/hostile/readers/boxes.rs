//! Emulated boxes, and the account of what is recorded from one; the cases are data, `boxes.toml`.

use std::net::TcpStream;
use std::sync::atomic::{AtomicU16, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::super::case::CaseOutcome;
use super::super::place::{CaseFolder, Running};
use super::holds;

/// Added to the box's ports: every case has its own.
static OFFSET: AtomicU16 = AtomicU16::new(12_000);

/// An emulated box that runs as long as this lives.
pub struct Emulated {
    running: Option<Running>,
    /// What is added to its ports.
    pub offset: String,
}

impl Emulated {
    /// Starts one with these faults and waits until it answers.
    pub fn start(place: &CaseFolder, faults: &[&str]) -> Result<Self, String> {
        let number = OFFSET.fetch_add(1, Ordering::Relaxed);
        let offset = number.to_string();
        let arguments = [&["rig", "emulate", "--port-offset", &offset], faults].concat();
        let running = place.call(&arguments).start()?;
        let begun = Instant::now();
        while TcpStream::connect(("127.0.0.1", 80 + number)).is_err() {
            if begun.elapsed() > Duration::from_secs(10) {
                return Err("the emulated box does not answer".into());
            }
            thread::sleep(Duration::from_millis(20));
        }
        Ok(Self { running: Some(running), offset })
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        if let Some(running) = self.running.take() {
            let _ = running.send("TERM");
            let _ = running.end(Duration::from_secs(5));
        }
    }
}

fn count(summary: &Value, key: &str) -> f64 {
    summary[key].as_f64().unwrap_or(f64::NAN)
}

/// What came and what is booked as missing is what the clock says, within a tenth.
pub fn accounted(summary: &Value) -> CaseOutcome {
    let booked = count(summary, "records") + count(summary, "lost") + count(summary, "unsent");
    let clock = &summary["by_clock"];
    let tail = count(clock, "tail_s") * count(clock, "stated_rate_hz");
    let expected = count(clock, "expected");
    holds(
        (booked + tail - expected).abs() <= 0.1 * expected + 700.0,
        format!("{booked} + {tail} of {expected}"),
    )
}
