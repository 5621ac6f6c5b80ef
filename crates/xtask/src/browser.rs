//! Pages of runs in headless Chromium (Debian's package `chromium`), and files for other programs by their own validators.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::report::Tally;
use crate::tools;

/// Where Chromium is, unless `CHROMIUM` says.
const CHROMIUM: &str = "/usr/bin/chromium";

/// The runs whose pages are opened, with the arguments that make them.
const RUNS: [(&str, &[&str]); 11] = [
    ("turn", &["fly", "scenarios/banking_turn.toml"]),
    ("minute", &["fly", "scenarios/banking_turn.toml", "--set", "flight.duration_s=60"]),
    ("glide", &["fly", "scenarios/glider.toml", "--set", "flight.duration_s=1"]),
    ("bank", &["fly", "scenarios/bank30_20g_lev.toml"]),
    ("trim", &["trim", "scenarios/cruise_20g.toml"]),
    ("tether", &["tether", "cases/flap_f2.toml"]),
    ("wake", &["wake", "cases/flap_f2.toml"]),
    ("sweep", &["sweep", "sweeps/flap_map.toml"]),
    ("arm", &["rig", "simulate", "rigs/runs/roll15_speed08.toml"]),
    ("armplan", &["rig", "plan", "rigs/runs/roll15_speed08.toml"]),
    ("fit", &["calibrate", "calibrations/two_runs.toml"]),
];

/// Makes the runs, opens their pages, and validates their glTF files.
pub fn check() -> Tally {
    let chromium = std::env::var("CHROMIUM").unwrap_or_else(|_| CHROMIUM.into());
    if !Path::new(&chromium).exists() {
        eprintln!("error: no {chromium}: `apt-get install chromium`, or set CHROMIUM");
        return Tally::one(false);
    }
    let folder = tools::root().join("target/browser");
    match made(&folder) {
        Ok(()) => {
            let script = tools::root().join("crates/xtask/browser");
            let node = |name: &str| {
                let mut command = Command::new("node");
                command.arg(script.join(name)).arg(&folder).env("CHROMIUM", &chromium);
                command.env("WINGBEAT", tools::program());
                Tally::of(command)
            };
            let (pages, models) = (node("check.mjs"), node("models.mjs"));
            Tally { passed: pages.passed + models.passed, failed: pages.failed + models.failed }
        }
        Err(why) => {
            eprintln!("error: {why}");
            Tally::one(false)
        }
    }
}

/// The packages of npm and the runs in `folder`.
fn made(folder: &Path) -> Result<(), String> {
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let package = tools::root().join("crates/xtask/browser/package.json");
    fs::copy(&package, folder.join("package.json")).map_err(|error| error.to_string())?;
    if !folder.join("node_modules/puppeteer-core").is_dir() {
        let mut npm = Command::new("npm");
        npm.args(["install", "--no-audit", "--no-fund", "--ignore-scripts"]).current_dir(folder);
        tools::succeeds(npm)
            .then_some(())
            .ok_or("npm could not install puppeteer-core, axe-core and gltf-validator")?;
    }
    let run = |arguments: &[&str], more: &[&str]| {
        tools::succeeds(tools::wingbeat(&[arguments, more].concat()))
            .then_some(())
            .ok_or_else(|| format!("wingbeat {}", arguments.join(" ")))
    };
    let inside = |name: &str| folder.join(name).display().to_string();
    for (name, arguments) in RUNS {
        run(arguments, &["--quiet", "--force", "--out", &inside(name)])?;
    }
    run(&["rig", "process", &inside("arm")], &["--quiet", "--force", "--out", &inside("processed")])?;
    let (turn, small, model) = (inside("turn"), inside("small.html"), inside("turn.glb"));
    run(&["report", &turn, "--no-wake", "--force", "--quiet", "--out", &small], &[])?;
    let both = inside("two/report.html");
    fs::create_dir_all(folder.join("two")).map_err(|error| error.to_string())?;
    run(&["report", &turn, &inside("glide"), "--force", "--quiet", "--out", &both], &[])?;
    run(&["export", &turn, "--gltf", "--force", "--quiet", "--out", &model], &[])?;
    hostile(folder, &turn)
}

/// A run whose name and texts are markup.
fn hostile(folder: &Path, turn: &str) -> Result<(), String> {
    let text = |error: std::io::Error| error.to_string();
    let name = "<img src=x onerror='window.pwned=1'>";
    let run = folder.join(name);
    let _ = fs::remove_dir_all(&run);
    fs::create_dir_all(&run).map_err(text)?;
    fs::copy(Path::new(turn).join("record.parquet"), run.join("record.parquet")).map_err(text)?;
    // Without checksums, by which the program would find the texts changed.
    let manifest = fs::read_to_string(Path::new(turn).join("manifest.json")).map_err(text)?;
    let mut manifest: serde_json::Value =
        serde_json::from_str(&manifest).map_err(|error| format!("manifest.json: {error}"))?;
    manifest["checksums"].take();
    fs::write(run.join("manifest.json"), manifest.to_string()).map_err(text)?;
    let markup = "</script><script>window.pwned = 1</script>";
    let scenario = fs::read_to_string(Path::new(turn).join("scenario.toml")).map_err(text)?;
    fs::write(run.join("scenario.toml"), format!("# {markup}\n{scenario}")).map_err(text)?;
    let summary = format!("{{ \"status\": \"failed\", \"reason\": \"{markup}\", \"size\": 1e300 }}");
    fs::write(run.join("summary.json"), summary).map_err(text)?;
    let page = folder.join("hostile.html").display().to_string();
    let run = run.display().to_string();
    let made = tools::wingbeat(&["report", &run, "--force", "--quiet", "--out", &page]);
    tools::succeeds(made).then_some(()).ok_or_else(|| "wingbeat report of a hostile run".into())
}
