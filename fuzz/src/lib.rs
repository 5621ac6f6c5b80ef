//! What the fuzz targets share: memory with a ceiling, and inputs as files.

use std::alloc::System;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Memory that one input may take, bytes; beyond it the target ends as after a panic.
const CEILING: usize = 512 << 20;

#[global_allocator]
static MEMORY: cap::Cap<System> = cap::Cap::new(System, CEILING);

/// Writes `bytes` where files of the workspace that an input names are found as from `rigs/runs` and `scenarios`.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let path = FOLDER.get_or_init(folder).join(name);
    fs::write(&path, bytes).expect("the scratch folder is writable");
    path
}

fn folder() -> PathBuf {
    let shared = Path::new("/dev/shm");
    let parent = if shared.is_dir() { shared.into() } else { std::env::temp_dir() };
    let root = parent.join(format!("wingbeat-fuzz-{}", std::process::id()));
    let runs = root.join("rigs/runs");
    fs::create_dir_all(&runs).expect("a scratch folder");
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let copies = [
        ("robots", "robots"),
        ("robots", "rigs/robots"),
        ("rigs/arms", "rigs/arms"),
        ("scenarios", "rigs/scenarios"),
    ];
    for (from, to) in copies {
        copy(&workspace.join(from), &root.join(to));
    }
    let rig = "rigs/aerobat_on_gen3.toml";
    fs::copy(workspace.join(rig), root.join(rig)).expect("the example rig");
    runs
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a scratch folder");
    for entry in fs::read_dir(from).expect("a folder of examples").flatten() {
        fs::copy(entry.path(), to.join(entry.file_name())).expect("an example");
    }
}
