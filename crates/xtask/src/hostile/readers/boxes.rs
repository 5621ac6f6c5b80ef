//! Class 5: recordings from an emulated box with faults: every record is there, booked as missing, or the exit says so.

use std::net::TcpStream;
use std::sync::atomic::{AtomicU16, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::super::case::{Judged, refused};
use super::super::place::{Ended, Place, Running};
use super::{Case, holds, json};

/// Added to the box's ports: every case has its own.
static OFFSET: AtomicU16 = AtomicU16::new(12_000);

/// The cases.
pub fn cases() -> Vec<Case> {
    [honest(), lying(), silent(), arguments(), signals()].into_iter().flatten().collect()
}

/// An emulated box that runs as long as this lives.
struct Box {
    running: Option<Running>,
    offset: String,
}

impl Box {
    fn start(place: &Place, faults: &[&str]) -> Result<Self, String> {
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

    fn record(&self, place: &Place, more: &[&str]) -> Result<Ended, String> {
        let arguments = ["rig", "record", "127.0.0.1", "--port-offset", &self.offset, "--out", "taken"];
        place.run(&[&arguments, more].concat())
    }
}

impl Drop for Box {
    fn drop(&mut self) {
        if let Some(running) = self.running.take() {
            let _ = running.send("TERM");
            let _ = running.end(Duration::from_secs(5));
        }
    }
}

/// What the summary of a recording must hold.
type Look = fn(&Value) -> Judged;

/// A recording from a box with `faults` that ends with `code` and whose summary passes `look`.
fn recording(
    name: &str,
    faults: &'static [&'static str],
    options: &'static [&'static str],
    code: i32,
    words: &'static [&'static str],
    look: Look,
) -> Case {
    let case = Case::new(5, name, move |place| {
        let emulated = Box::start(place, faults)?;
        emulated.record(place, options)?.exits(code)?.says(words)?;
        let summary = json(place, "taken/summary.json")?;
        let status = summary["status"].as_str().unwrap_or_default();
        holds((status == "ok") == (code == 0), format!("status {status} with exit {code}"))?;
        look(&summary)
    });
    case.long().alone()
}

fn count(summary: &Value, key: &str) -> f64 {
    summary[key].as_f64().unwrap_or(f64::NAN)
}

/// What came and what is booked as missing is what the clock says, within a tenth.
fn accounted(summary: &Value) -> Judged {
    let booked = count(summary, "records") + count(summary, "lost") + count(summary, "unsent");
    let clock = &summary["by_clock"];
    let tail = count(clock, "tail_s") * count(clock, "stated_rate_hz");
    let expected = count(clock, "expected");
    holds(
        (booked + tail - expected).abs() <= 0.1 * expected + 700.0,
        format!("{booked} + {tail} of {expected}"),
    )
}

/// The same, with more than none of `key`.
fn some(summary: &Value, key: &str) -> Judged {
    holds(count(summary, key) > 0.0, format!("{key}: {}", summary[key]))?;
    accounted(summary)
}

fn none(summary: &Value, key: &str) -> Judged {
    holds(count(summary, key) == 0.0, format!("{key}: {}", summary[key]))
}

const TWO: &[&str] = &["--duration", "2"];
const LONG: &[&str] = &["--duration", "4"];

fn honest() -> Vec<Case> {
    vec![
        recording("clean", &[], TWO, 0, &[], |s| none(s, "lost").and(accounted(s))),
        recording("clean_packs", &[], &["--duration", "2", "--buffered"], 0, &[], accounted),
        recording("drop_some", &["--drop", "0.01"], TWO, 0, &[], |s| some(s, "lost")),
        recording("drop_half", &["--drop", "0.5"], TWO, 0, &[], |s| some(s, "lost")),
        recording("duplicates", &["--duplicate", "0.05"], TWO, 0, &[], |s| some(s, "duplicates")),
        recording("late", &["--reorder", "0.05"], TWO, 0, &[], |s| some(s, "reordered")),
        recording("noise_beside", &["--garbage", "0.2"], TWO, 0, &[], |s| some(s, "malformed")),
        recording("serious", &["--serious", "0.1"], TWO, 0, &[], |s| some(s, "serious")),
        recording("wrap", &["--sequence", "4294960000"], TWO, 0, &[], |s| none(s, "lost").and(accounted(s))),
        recording("stalls", &["--stall-after", "6000"], LONG, 0, &[], |s| some(s, "stalls")),
    ]
}

fn lying() -> Vec<Case> {
    let reboot = |s: &Value| some(s, "reboots");
    // 6000 records, then a second of silence and what the recorder waits: the last stream is under way at the end.
    let restart = |name: &str, faults: &'static [&'static str]| {
        recording(name, faults, &["--duration", "3.2"], 0, &[], reboot)
    };
    vec![
        restart("restart", &["--restart-after", "6000"]),
        restart("restart_passes", &["--restart-after", "6000", "--restart-at", "40000"]),
        restart("restart_far", &["--restart-after", "6000", "--restart-at", "2000000000"]),
        restart("restart_wraps", &["--restart-after", "6000", "--restart-at", "4294967295"]),
        recording("jump", &["--jump-after", "5000"], TWO, 0, &[], |s| none(s, "lost").and(some(s, "jumps"))),
        recording("jump_with_drop", &["--jump-after", "5000", "--drop", "0.01"], TWO, 0, &[], |s| {
            some(s, "jumps")
        }),
        recording("pace_fifth", &["--pace", "0.2"], TWO, 3, &["clock:", "by the clock"], |s| none(s, "lost")),
        recording("pace_fifth_short", &["--pace", "0.2"], &["--duration", "0.8"], 3, &["clock:"], |s| {
            none(s, "lost")
        }),
        recording("pace_half", &["--pace", "0.5"], TWO, 3, &["7000 Hz"], |s| none(s, "lost")),
        recording(
            "pace_fifth_packs",
            &["--pace", "0.2"],
            &["--duration", "2", "--buffered"],
            3,
            &["clock:"],
            |_| Ok(()),
        ),
    ]
}

fn silent() -> Vec<Case> {
    let tail = |s: &Value| holds(count(&s["by_clock"], "tail_s") > 0.5, &s["by_clock"]);
    let nothing = |name: &str,
                   faults: &'static [&'static str],
                   options: &'static [&'static str],
                   word: &'static str| {
        let case = Case::new(5, name, move |place| {
            let emulated = Box::start(place, faults)?;
            emulated.record(place, options)?.exits(2)?.says(&[word])?;
            drop(emulated);
            place.holds("", &[])
        });
        case.long().alone()
    };
    vec![
        recording("dies", &["--die-after", "5000"], LONG, 3, &["stopped sending"], tail),
        recording(
            "dies_packs",
            &["--die-after", "5000"],
            &["--duration", "4", "--buffered"],
            3,
            &["stopped sending"],
            tail,
        ),
        recording("dies_at_once", &["--die-after", "1"], TWO, 3, &["stopped sending"], tail),
        recording(
            "dies_fail_stop",
            &["--die-after", "5000"],
            &["--fail-stop"],
            3,
            &["stopped sending"],
            |_| Ok(()),
        ),
        recording(
            "stalls_fail_stop",
            &["--stall-after", "5000"],
            &["--fail-stop"],
            3,
            &["stopped sending"],
            |_| Ok(()),
        ),
        nothing("only_noise", &["--drop", "1", "--garbage", "1"], TWO, "none of which is a record"),
        nothing(
            "only_noise_fail_stop",
            &["--drop", "1", "--garbage", "1"],
            &["--fail-stop"],
            "none of which is a record",
        ),
        nothing("mute", &["--drop", "1"], TWO, "the box sent no record"),
        nothing("mute_fail_stop", &["--drop", "1"], &["--fail-stop"], "the box sent no record"),
        nothing("no_time", &[], &["--duration", "0"], "the box sent no record"),
    ]
}

fn arguments() -> Vec<Case> {
    let emulate = |name: &str, key: &'static str, value: &str| {
        refused(5, name, &[], &["rig", "emulate", "--port-offset", "11999", key, value], &[key])
    };
    let record = |name: &str, key: &'static str, value: &str| {
        let arguments = ["rig", "record", "127.0.0.1", "--out", "taken", key, value];
        refused(5, name, &[], &arguments, &[key])
    };
    let mut all = vec![
        emulate("offset_wraps", "--port-offset", "16384"),
        emulate("offset_most", "--port-offset", "65535"),
        record("record_offset_wraps", "--port-offset", "16384"),
        record("frequency_zero", "--frequency", "0"),
        refused(
            5,
            "frequency_negative",
            &[],
            &["rig", "record", "127.0.0.1", "--out", "taken", "--frequency=-1"],
            &["--frequency -1"],
        ),
        record("frequency_nan", "--frequency", "nan"),
        record("frequency_infinite", "--frequency", "inf"),
        record("duration_nan", "--duration", "nan"),
        record("duration_endless", "--duration", "1e300"),
        emulate("pace_nan", "--pace", "nan"),
        refused(
            5,
            "marked_too_often",
            &[],
            &["rig", "emulate", "--port-offset", "11999", "--warning", "0.6", "--serious", "0.6"],
            &["--saturation", "together"],
        ),
    ];
    for key in [
        "--drop",
        "--duplicate",
        "--reorder",
        "--delay",
        "--garbage",
        "--saturation",
        "--warning",
        "--serious",
    ] {
        let plain = key.trim_start_matches('-');
        all.push(emulate(&format!("{plain}_two"), key, "2"));
        all.push(emulate(&format!("{plain}_nan"), key, "nan"));
    }
    all
}

fn signals() -> Vec<Case> {
    let ended = Case::new(5, "interrupt_keeps_what_came", |place| {
        let emulated = Box::start(place, &[])?;
        let arguments = ["rig", "record", "127.0.0.1", "--port-offset", &emulated.offset, "--out", "taken"];
        place.call(&arguments).signal("INT", Duration::from_secs(2)).run()?.exits(0)?;
        accounted(&json(place, "taken/summary.json")?)
    });
    let mute = Case::new(5, "interrupt_of_a_mute_box", |place| {
        let emulated = Box::start(place, &["--drop", "1"])?;
        let arguments = ["rig", "record", "127.0.0.1", "--port-offset", &emulated.offset, "--out", "taken"];
        place.call(&arguments).signal("INT", Duration::from_secs(3)).run()?.exits(130)?.in_time()?;
        drop(emulated);
        place.holds("", &[])
    });
    vec![ended.long().alone(), mute.long().alone()]
}
