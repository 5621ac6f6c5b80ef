//! `wingbeat sweep`: the same rows whether or not it was interrupted.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output};
use std::time::Duration;

use crate::{root, scratch};

/// A sweep of short turns.
fn written(folder: &Path, flights: usize) {
    let scenario = root().join("scenarios/banking_turn.toml");
    let text = format!(
        "name = \"small\"\nscenario = {:?}\nruns = {flights}\n\
         [hold]\nroll_within_deg = 5.0\npitch_within_deg = 10.0\n\
         [[draws]]\nkey = \"mismatch.mass\"\nlow = 0.9\nhigh = 1.1\n\
         [[draws]]\nkey = \"flight.duration_s\"\nlow = 0.3\nhigh = 0.3\n\
         [[draws]]\nkey = \"goal.settle_s\"\nlow = 0.0\nhigh = 0.0\n",
        scenario
    );
    fs::write(folder.join("small.toml"), text).unwrap();
}

fn command(folder: &Path, out: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wingbeat"));
    command.args(["sweep", "small.toml", "--out", out]).current_dir(folder);
    command
}

fn sweep(folder: &Path, out: &str) -> Output {
    command(folder, out).output().unwrap()
}

fn flights(folder: &Path, out: &str) -> String {
    fs::read_to_string(folder.join(out).join("flights.csv")).unwrap()
}

#[cfg(unix)]
fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

#[cfg(unix)]
#[test]
fn an_interrupted_sweep_goes_on_to_the_same_rows() {
    let folder = scratch("sweep-sweep");
    written(&folder, 6);
    let output = sweep(&folder, "whole");
    assert!(output.status.success(), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("of 6 flights"));
    for name in ["sweep.toml", "summary.json", "manifest.json", "record.parquet", "figures/robustness.png"] {
        assert!(folder.join("whole").join(name).exists(), "{name}");
    }

    let mut child = command(&folder, "parts").spawn().unwrap();
    let log = folder.join(".parts.partial/flights.log");
    while fs::read_to_string(&log).unwrap_or_default().lines().count() < 2 {
        std::thread::sleep(Duration::from_millis(2));
    }
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!folder.join("parts").exists());
    let done = fs::read_to_string(&log).unwrap();
    assert!(done.lines().count() >= 2);

    assert!(sweep(&folder, "parts").status.success());
    assert_eq!(flights(&folder, "parts"), flights(&folder, "whole"));
    for row in done.lines() {
        assert!(flights(&folder, "parts").contains(row), "{row} was flown again");
    }
}

#[test]
fn a_bad_sweep_is_one_message() {
    let folder = scratch("sweep-bad_sweep");
    written(&folder, 0);
    let output = sweep(&folder, "out");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    assert!(message.starts_with("error: small.toml:3: runs = 0: allowed is 1 to 1000000"), "{message}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
}
