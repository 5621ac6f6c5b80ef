//! Files of `wingbeat export` read by the programs that they are for: readers of MCAP, Rerun, NumPy, SciPy, pandas and pyvista in Python;
//! Khronos's validator and three.js in node.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::report::Tally;
use crate::tools;

/// The flight, as it is exported.
const FLIGHT: [&str; 2] = ["fly", "scenarios/banking_turn.toml"];
/// Format and name of each of its files.
const FILES: [(&str, &str); 6] = [
    ("--mcap", "turn.mcap"),
    ("--csv", "turn.csv"),
    ("--npz", "turn.npz"),
    ("--mat", "turn.mat"),
    ("--gltf", "turn.glb"),
    ("--vtk", "turn-vtk"),
];

/// Makes the files and reads them.
pub fn check() -> Tally {
    let (folder, scripts) =
        (tools::root().join("target/exports"), tools::root().join("crates/xtask/exports"));
    if let Err(why) = made(&folder) {
        eprintln!("error: {why}");
        return Tally::one(false);
    }
    let mut tally = Tally::default();
    let python = tools::python_environment("target/exports/venv")
        .filter(|python| tools::pip(python, &["--requirement"], &scripts.join("requirements.txt")).is_some());
    tally += python.map_or(Tally::one(false), |python| {
        let mut command = Command::new(python);
        command.arg(scripts.join("check.py")).arg(&folder).env("WINGBEAT", tools::program());
        Tally::of(command)
    });
    match packages(&folder, &scripts.join("package.json"), "three") {
        Ok(()) => {
            let mut command = Command::new("node");
            command.arg(scripts.join("models.mjs")).arg(&folder);
            tally += Tally::of(command);
        }
        Err(why) => {
            eprintln!("error: {why}");
            tally += Tally::one(false);
        }
    }
    tally
}

/// The flight and its files in `folder`.
fn made(folder: &Path) -> Result<(), String> {
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let inside = |name: &str| folder.join(name).display().to_string();
    let run = |arguments: &[&str], out: &str| {
        let more = ["--quiet", "--force", "--out", out];
        tools::succeeds(tools::wingbeat(&[arguments, &more].concat()))
            .then_some(())
            .ok_or_else(|| format!("wingbeat {}", arguments.join(" ")))
    };
    let turn = inside("turn");
    run(&FLIGHT, &turn)?;
    FILES.iter().try_for_each(|(format, name)| run(&["export", &turn, format], &inside(name)))
}

/// The packages of npm of `list` in `folder`, installed where `one` of them is not there.
///
/// # Errors
/// They cannot be had.
pub fn packages(folder: &Path, list: &Path, one: &str) -> Result<(), String> {
    fs::copy(list, folder.join("package.json")).map_err(|error| error.to_string())?;
    if folder.join("node_modules").join(one).is_dir() {
        return Ok(());
    }
    let mut npm = Command::new("npm");
    npm.args(["install", "--no-audit", "--no-fund", "--ignore-scripts"]).current_dir(folder);
    tools::succeeds(npm)
        .then_some(())
        .ok_or_else(|| format!("npm could not install what {} lists", list.display()))
}
