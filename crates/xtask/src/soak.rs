//! The recorder on the emulated box at its full rate for a long time: every sample accounted for, memory flat.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::tools;

/// Seconds, when not said.
const SECONDS: u64 = 600;
/// Busy processes that may be asked for.
const MOST_BUSY: u64 = 64;
/// Added to the box's ports.
const OFFSET: &str = "8130";
/// Samples per second of the box.
const RATE: f64 = 7000.0;
/// Time from the start after which memory must stay.
const WARM: Duration = Duration::from_secs(3);
/// Growth of resident memory after that which is none, kB.
const FLAT: u64 = 1024;

/// Resident memory of a process over the recording, kB.
#[derive(Default)]
struct ResidentMemory {
    start: u64,
    end: u64,
    most: u64,
}

/// Records for `--seconds N` beside `--busy N` processes that never rest, with the program that is built or with `--program FILE`, and
/// prints the account; true when nothing was lost silently and memory stayed flat.
pub fn soak(arguments: &[String]) -> bool {
    let (mut seconds, mut busy, mut program) = (SECONDS, 0, None);
    let mut rest = arguments.iter();
    while let Some(option) = rest.next() {
        let value = rest.next();
        let number = value.and_then(|word| word.parse::<u64>().ok());
        match (option.as_str(), number) {
            ("--seconds", Some(number)) if number > 0 => seconds = number,
            ("--busy", Some(number)) if number <= MOST_BUSY => busy = number,
            ("--program", _) if value.is_some() => program = value.map(PathBuf::from),
            _ => {
                eprintln!(
                    "error: {option}: there are --seconds N above zero, --busy N up to {MOST_BUSY}, --program FILE"
                );
                return false;
            }
        }
    }
    let built = program.is_some() || tools::built();
    built && run(&program.unwrap_or_else(tools::program), seconds, busy)
}

/// An hour beside eight busy processes, as `cargo xtask long` asks.
pub fn hour() -> bool {
    run(&tools::program(), 3600, 8)
}

/// Processes that count without rest, at the lowest priority; they end with this value.
struct Busy(Vec<Child>);

impl Busy {
    fn start(count: u64) -> Self {
        let one = || {
            let mut command = Command::new("nice");
            command.args(["-n", "19", "sh", "-c", "while :; do :; done"]).stdin(Stdio::null()).spawn().ok()
        };
        Self((0..count).filter_map(|_| one()).collect())
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        for child in &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Records for so many seconds with `program` beside so many busy processes.
pub fn run(program: &Path, seconds: u64, busy: u64) -> bool {
    let out = tools::root().join("target/soak");
    let _ = fs::remove_dir_all(&out);
    let beside = Busy::start(busy);
    if beside.0.len() as u64 != busy {
        eprintln!("error: only {} of {busy} busy processes started", beside.0.len());
        return false;
    }
    let Some((mut box_, pages)) = emulator(program) else { return false };
    let recorded = recorder(program, seconds, &out).and_then(|mut recorder| {
        let memory = watch(&recorder, &box_, seconds);
        recorder.wait().is_ok_and(|status| status.success()).then_some(memory)
    });
    let sent = stop(&mut box_, pages);
    let summary = fs::read_to_string(out.join("summary.json")).ok();
    let summary = summary.and_then(|text| serde_json::from_str::<Value>(&text).ok());
    match (recorded, summary) {
        (Some(memory), Some(summary)) => judge((seconds, busy), &summary, sent, &memory),
        _ => false,
    }
}

fn wingbeat(program: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(["rig"]).args(arguments).stdin(Stdio::null());
    command
}

/// The emulator, once it listens, and the rest of its output.
fn emulator(program: &Path) -> Option<(Child, BufReader<std::process::ChildStdout>)> {
    let mut child =
        wingbeat(program, &["emulate", "--port-offset", OFFSET]).stdout(Stdio::piped()).spawn().ok()?;
    let mut output = BufReader::new(child.stdout.take()?);
    let mut line = String::new();
    let listens = output.read_line(&mut line).is_ok() && line.starts_with("RDT");
    listens.then_some((child, output))
}

fn recorder(program: &Path, seconds: u64, out: &Path) -> Option<Child> {
    let seconds = seconds.to_string();
    let mut command = wingbeat(
        program,
        &["record", "127.0.0.1", "--port-offset", OFFSET, "--duration", &seconds, "--quiet"],
    );
    command.arg("--out").arg(out).spawn().ok()
}

/// Interrupts the emulator; the records that it says it made.
fn stop(emulator: &mut Child, mut output: impl Read) -> u64 {
    let interrupt = Command::new("kill").args(["-INT", &emulator.id().to_string()]).status();
    if !interrupt.is_ok_and(|status| status.success()) {
        let _ = emulator.kill();
    }
    let mut text = String::new();
    let _ = output.read_to_string(&mut text);
    let _ = emulator.wait();
    let records = text.lines().find_map(|line| line.strip_prefix("records"));
    records.and_then(|number| number.trim().parse().ok()).unwrap_or(0)
}

/// Memory of recorder and emulator, from warm to a second before the end.
fn watch(recorder: &Child, emulator: &Child, seconds: u64) -> [ResidentMemory; 2] {
    let began = Instant::now();
    let end = Duration::from_secs(seconds.saturating_sub(1));
    let mut memory = [ResidentMemory::default(), ResidentMemory::default()];
    while began.elapsed() < end {
        thread::sleep(Duration::from_secs(1).min(end.saturating_sub(began.elapsed())));
        if began.elapsed() < WARM {
            continue;
        }
        for (memory, process) in memory.iter_mut().zip([recorder, emulator]) {
            let resident = resident(process.id());
            memory.start = if memory.start == 0 { resident } else { memory.start };
            memory.end = resident;
            memory.most = memory.most.max(resident);
        }
    }
    memory
}

/// Resident memory of a process, kB.
fn resident(id: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// Prints the account. What the emulator made after the recorder's last record is what was on its way at the end. Beside busy processes
/// the emulator itself may fall silent for so long that it is asked again: what lies between two streams is then counted as not sent.
fn judge((seconds, busy): (u64, u64), summary: &Value, sent: u64, memory: &[ResidentMemory; 2]) -> bool {
    let count = |key: &str| summary[key].as_u64().unwrap_or(u64::MAX);
    let (records, lost) = (count("records"), count("lost"));
    let accounted = records.saturating_add(lost);
    let after = sent.saturating_sub(accounted);
    println!(
        "{records} records in {seconds} s, {lost} lost in {} gaps (longest {})",
        count("gaps"),
        count("longest_gap")
    );
    println!(
        "{} dropped by the kernel, {} stalls, {} restarts with {} records between",
        count("kernel_drops"),
        count("stalls"),
        count("restarts"),
        count("unsent")
    );
    println!("{sent} made by the emulator, {after} of them after the last that was recorded");
    println!("longest silence {:.1} ms", 1e3 * summary["longest_silence_s"].as_f64().unwrap_or(f64::NAN));
    println!("{:<10} {:>9} {:>9} {:>9}", "memory, kB", "start", "end", "most");
    for (name, m) in ["recorder", "emulator"].iter().zip(memory) {
        println!("{name:<10} {:>9} {:>9} {:>9}", m.start, m.end, m.most);
    }
    let flat = memory.iter().all(|m| m.most <= m.start + FLAT);
    let between = if busy > 0 { count("unsent") } else { 0 };
    let (all, most) = (records as f64 + between as f64, RATE + between as f64);
    let whole = accounted <= sent && after as f64 <= most && all >= 0.98 * RATE * seconds as f64;
    let counted = lost == count("kernel_drops") && (busy > 0 || count("restarts") == 0);
    println!("every sample accounted for: {}; memory flat: {flat}", whole && counted);
    whole && counted && flat
}
