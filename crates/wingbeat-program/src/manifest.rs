//! What produced a run: program, command, seed, machine and time.

use std::env;
use std::fs;
use std::num::NonZero;
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::Serialize;

/// The contents of `manifest.json`.
#[derive(Debug, Serialize)]
pub struct Manifest {
    version: &'static str,
    git_commit: &'static str,
    command: Vec<String>,
    seed: u64,
    started_unix_s: f64,
    wall_time_s: f64,
    host: Host,
}

#[derive(Debug, Serialize)]
struct Host {
    name: String,
    system: &'static str,
    architecture: &'static str,
    processor: String,
    cores: usize,
}

impl Manifest {
    /// The manifest of a run that took `wall` until now.
    pub fn new(seed: u64, wall: Duration) -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self {
            version: env!("CARGO_PKG_VERSION"),
            git_commit: crate::COMMIT,
            command: env::args_os().map(|word| word.to_string_lossy().into_owned()).collect(),
            seed,
            started_unix_s: now.saturating_sub(wall).as_secs_f64(),
            wall_time_s: wall.as_secs_f64(),
            host: Host::here(),
        }
    }
}

impl Host {
    fn here() -> Self {
        let name = fs::read_to_string("/etc/hostname").ok().or_else(|| env::var("HOSTNAME").ok());
        Self {
            name: name.map_or("unknown".into(), |name| name.trim().into()),
            system: env::consts::OS,
            architecture: env::consts::ARCH,
            processor: processor().unwrap_or_else(|| "unknown".into()),
            cores: thread::available_parallelism().map_or(1, NonZero::get),
        }
    }
}

fn processor() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    line.split_once(':').map(|(_, name)| name.trim().into())
}
