//! `wingbeat rig record` on `wingbeat rig emulate`: whole, interrupted, killed, out of disk.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;
use wingbeat_io::read_parquet;

use crate::{root, scratch};

fn rig(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wingbeat"));
    command.arg("rig").args(arguments);
    command
}

/// A running emulator; dropped, it is killed.
struct Emulator {
    child: Child,
    output: BufReader<ChildStdout>,
    offset: String,
}

impl Emulator {
    fn start(offset: u16, faults: &[&str]) -> Self {
        let offset = offset.to_string();
        let mut command = rig(&["emulate", "--port-offset", &offset]);
        let mut child = command.args(faults).stdout(Stdio::piped()).spawn().unwrap();
        let mut output = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        output.read_line(&mut line).unwrap();
        assert!(line.starts_with("RDT"), "{line}");
        Self { child, output, offset }
    }

    /// A recorder of this box that writes to `out` and prints nothing.
    fn recorder(&self, folder: &Path, out: &str, arguments: &[&str]) -> Command {
        let mut command =
            rig(&["record", "127.0.0.1", "--port-offset", &self.offset, "--quiet", "--out", out]);
        command.args(arguments).current_dir(folder);
        command
    }

    /// Ends the emulator; its count called `name`.
    fn end(mut self, name: &str) -> u64 {
        interrupt(&self.child);
        assert!(self.child.wait().unwrap().success());
        let mut text = String::new();
        self.output.read_to_string(&mut text).unwrap();
        let line = text.lines().find_map(|line| line.strip_prefix(name)).unwrap_or_else(|| panic!("{text}"));
        line.trim().parse().unwrap()
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

/// Waits until a raw log in `folder` holds something.
fn until_rows(folder: &Path) {
    while !fs::metadata(folder.join("raw-000.rdt")).is_ok_and(|data| data.len() > 0) {
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn summary(run: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap()
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Names of the limits that a summary says are not met, and of its warnings.
fn broken(summary: &Value) -> Vec<String> {
    let judged = summary["judged"].as_array().unwrap().iter().filter(|judged| judged["met"] == false);
    let warnings = summary["warnings"].as_array().unwrap().iter();
    judged.chain(warnings).map(|item| item["id"].as_str().unwrap().to_owned()).collect()
}

/// The times of the record of `run`, which must not go back.
fn times(run: &Path) -> Vec<f64> {
    let record = read_parquet(&run.join("record.parquet")).unwrap();
    let t = record.values("t").unwrap().to_vec();
    assert!(t.windows(2).all(|w| w[1] > w[0]), "time goes back");
    t
}

#[test]
fn a_recording_is_whole_and_counts_what_the_box_did() {
    let folder = scratch("record_whole");
    let emulator =
        Emulator::start(8201, &["--drop", "0.01", "--warning", "0.02", "--sequence", "4294965000"]);
    let output =
        emulator.recorder(&folder, "rec", &["--duration", "1.5", "--rotate", "4000"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let run = folder.join("rec");
    for name in
        ["record.parquet", "raw-000.rdt", "raw-001.rdt", "report.txt", "summary.json", "manifest.json"]
    {
        assert!(run.join(name).exists(), "{name}");
    }
    let s = summary(&run);
    let count = |key: &str| s[key].as_u64().unwrap();
    assert_eq!((s["status"].as_str(), count("restarts"), count("duplicates")), (Some("ok"), 0, 0));
    assert!(count("records") > 5000 && count("status_warnings") > 50, "{s}");
    assert_eq!(times(&run).len() as u64, count("records"));
    let dropped = emulator.end("dropped");
    assert!(count("lost") > 20 && count("lost") - count("kernel_drops") <= dropped, "{s} {dropped}");
    let again = rig(&["record", "127.0.0.1", "--out", "rec"]).current_dir(&folder).output().unwrap();
    assert_eq!(again.status.code(), Some(2), "{again:?}");
}

#[test]
fn an_interrupt_ends_a_recording_well() {
    let folder = scratch("record_interrupt");
    let emulator = Emulator::start(8202, &[]);
    let mut child = emulator.recorder(&folder, "rec", &[]).spawn().unwrap();
    until_rows(&folder.join(".rec.partial"));
    assert!(!folder.join("rec").exists());
    interrupt(&child);
    assert!(child.wait().unwrap().success());
    assert_eq!(
        times(&folder.join("rec")).len() as u64,
        summary(&folder.join("rec"))["records"].as_u64().unwrap()
    );
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
}

#[test]
fn a_killed_recording_goes_on_with_the_same_command() {
    let folder = scratch("record_killed");
    let emulator = Emulator::start(8203, &[]);
    let mut child = emulator.recorder(&folder, "rec", &[]).spawn().unwrap();
    until_rows(&folder.join(".rec.partial"));
    let second = emulator.recorder(&folder, "rec", &["--duration", "0.2"]).output().unwrap();
    assert!(message(&second).contains("another command"), "{second:?}");
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!folder.join("rec").exists());
    let rows = fs::metadata(folder.join(".rec.partial/raw-000.rdt")).unwrap().len() / 52;

    let output = emulator.recorder(&folder, "rec", &["--duration", "0.5"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let s = summary(&folder.join("rec"));
    assert_eq!(
        (s["logs"].as_u64(), s["restarts"].as_u64(), s["reboots"].as_u64()),
        (Some(2), Some(1), Some(0))
    );
    // What the box sampled between the two, by its own count, is neither there nor lost silently.
    assert!(s["unsent"].as_u64().unwrap() > 0 && s["records"].as_u64().unwrap() > rows, "{s}");
    times(&folder.join("rec"));
}

#[test]
fn a_full_disk_ends_a_recording_that_goes_on_once_there_is_room() {
    let folder = scratch("record_disk");
    let emulator = Emulator::start(8204, &[]);
    // No file may grow beyond 100 blocks of 512 bytes: writing fails as on a full disk.
    let script = "trap '' XFSZ; ulimit -f 100; exec \"$0\" \"$@\"";
    let limited = emulator.recorder(&folder, "rec", &["--duration", "20"]);
    let mut shell = Command::new("sh");
    shell.args(["-c", script]).arg(limited.get_program()).args(limited.get_args()).current_dir(&folder);
    let output = shell.output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let text = message(&output);
    assert!(text.contains("raw-000.rdt") && text.contains("records are safe"), "{text}");
    assert!(text.contains(".rec.partial") && !folder.join("rec").exists(), "{text}");

    // Long beside the time for which a busy machine may starve the box, which then sends faster than it says.
    let output = emulator.recorder(&folder, "rec", &["--duration", "2"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let s = summary(&folder.join("rec"));
    assert!(s["records"].as_u64().unwrap() > 900, "{s}");
    assert_eq!(times(&folder.join("rec")).len() as u64, s["records"].as_u64().unwrap());
}

#[test]
fn a_box_that_restarts_is_recorded_on_and_one_that_falls_silent_is_told() {
    let folder = scratch("record_restart");
    let emulator = Emulator::start(8205, &["--restart-after", "2000"]);
    let output = emulator.recorder(&folder, "rec", &["--duration", "3.5"]).output().unwrap();
    let s = summary(&folder.join("rec"));
    // Most of the time the box was deaf, and it may be so at the end: there is a record, but no data to go by.
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    assert!(broken(&s).contains(&"recording.unsent_fraction".to_owned()), "{s}");
    let boxes = emulator.end("restarts");
    assert!(s["reboots"].as_u64().unwrap() >= 1 && s["reboots"].as_u64().unwrap() <= boxes, "{s}");
    // What it did not send is booked by the clock.
    let count = |key: &str| s[key].as_f64().unwrap();
    let booked = count("records") + count("lost") + count("unsent");
    let clock = |key: &str| s["by_clock"][key].as_f64().unwrap();
    let there = clock("expected") - 7000.0 * clock("tail_s");
    assert!((booked - there).abs() < 0.1 * there, "{s}");
    times(&folder.join("rec"));

    let emulator = Emulator::start(8206, &["--stall-after", "2000"]);
    let output = emulator.recorder(&folder, "silent", &["--fail-stop"]).output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    assert!(message(&output).contains("stopped sending"), "{output:?}");
    let s = summary(&folder.join("silent"));
    assert_eq!((s["status"].as_str(), s["records"].as_u64()), (Some("failed"), Some(2000)));
}

#[test]
fn without_a_box_there_is_a_message_and_no_folder() {
    let folder = scratch("record_nothing");
    let output = rig(&["record", "127.0.0.1", "--port-offset", "8299", "--out", "rec"])
        .current_dir(&folder)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(message(&output).contains("is the box on"), "{output:?}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
}

#[test]
fn what_a_killed_run_left_is_removed_by_the_next() {
    let folder = scratch("killed_run");
    let scenario = root().join("scenarios/glide.toml");
    let fly = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_wingbeat"));
        command.arg("fly").arg(&scenario).args(["--out", "run", "--quiet"]).current_dir(&folder);
        command
    };
    let mut child = fly().args(["--set", "flight.duration_s=100"]).spawn().unwrap();
    let left = folder.join(".run.partial/unfinished.json");
    while !left.exists() {
        assert!(child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(left.exists() && !folder.join("run").exists());
    let output = fly().output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(message(&output).contains("left by a command that was killed"), "{output:?}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
}

#[test]
fn faulty_boxes_are_judged_and_healthy_ones_that_look_odd_are_not() {
    let folder = scratch("record_judged");
    // Faults, options of the recorder, and the limit that is broken; none of a recording that is sound.
    let cases: [(&[&str], &[&str], &str); 22] = [
        (&["--serious", "1"], &[], "serious_fraction"),
        (&["--serious", "0.01"], &[], "serious_fraction"),
        (&["--saturation", "0.3"], &[], "saturated_fraction"),
        (&["--drop", "0.5"], &[], "lost_fraction"),
        (&["--drop", "0.1"], &["--buffered"], "lost_fraction"),
        (&["--duplicate", "0.5"], &[], "duplicate_fraction"),
        (&["--reorder", "0.5"], &[], "disorder_fraction"),
        (&["--garbage", "0.9"], &[], "malformed_fraction"),
        (&["--numbers", "random"], &[], "disorder_fraction"),
        (&["--numbers", "backward"], &[], "disorder_fraction"),
        (&["--numbers", "frozen"], &[], "duplicate_fraction"),
        (&["--numbers", "frozen-samples"], &[], "standing_fraction"),
        (&["--loads", "zero"], &[], "dead_channels"),
        (&["--loads", "stuck-fz"], &[], "dead_channels"),
        (&["--loads", "frozen"], &[], "held_s"),
        (&["--pace", "0.5"], &[], "rate_error_fraction"),
        (&["--die-after", "2000"], &[], "silent_end_s"),
        (&["--sequence", "4294965000"], &[], ""),
        (&["--warning", "0.01"], &[], ""),
        (&[], &["--buffered"], ""),
        (&[], &["--duration", "0.1"], ""),
        (&["--jump-after", "2000"], &[], ""),
    ];
    for (number, (faults, options, limit)) in cases.into_iter().enumerate() {
        let emulator = Emulator::start(8210 + number as u16, faults);
        let out = format!("rec-{number}");
        let times: &[&str] = if options.contains(&"--duration") { &[] } else { &["--duration", "1.2"] };
        let output = emulator.recorder(&folder, &out, times).args(options).output().unwrap();
        let s = summary(&folder.join(&out));
        let told = broken(&s);
        let expected = if limit.is_empty() { Some(0) } else { Some(3) };
        assert_eq!(output.status.code(), expected, "{faults:?} {told:?} {output:?}");
        assert_eq!(s["status"] == "ok", limit.is_empty(), "{faults:?} {s}");
        assert!(limit.is_empty() || told.contains(&format!("recording.{limit}")), "{faults:?} {told:?}");
    }
}

#[test]
fn an_alarm_comes_while_the_recording_runs() {
    let folder = scratch("record_alarm");
    let emulator = Emulator::start(8240, &["--serious", "1"]);
    let output = emulator.recorder(&folder, "rec", &["--duration", "2.5"]).output().unwrap();
    let text = message(&output);
    assert_eq!(text.matches("alarm: recording.serious_fraction").count(), 1, "{text}");
    // Nothing else is wrong with that box.
    assert_eq!(text.matches("alarm: ").count(), 1, "{text}");
}

#[test]
fn a_disk_that_is_full_while_figures_are_drawn_ends_the_run_and_leaves_nothing() {
    let folder = scratch("figures_disk");
    // No file may grow beyond 200 blocks of 512 bytes: the record fits (92 kB), the picture of the path does not (115 kB).
    let script = "trap '' XFSZ; ulimit -f 200; exec \"$0\" \"$@\"";
    let mut shell = Command::new("sh");
    shell
        .args(["-c", script, env!("CARGO_BIN_EXE_wingbeat"), "fly"])
        .arg(root().join("scenarios/glide.toml"));
    shell.args(["--set", "flight.duration_s=0.02", "--set", "flight.record_every_s=0.01"]);
    shell.args(["--set", "aero.paper.nodes=4", "--out", "run", "--quiet"]).current_dir(&folder);
    let output = shell.output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(message(&output).contains("figures/"), "{output:?}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
}
