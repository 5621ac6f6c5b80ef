//! Pages of runs in headless Chromium (Debian's package `chromium`).

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::report::Tally;
use crate::{exports, tools};

/// Where Chromium is, unless `CHROMIUM` says.
const CHROMIUM: &str = "/usr/bin/chromium";

/// The runs whose pages are opened, with the arguments that make them.
const RUNS: [(&str, &[&str]); 18] = [
    ("turn", &["fly", "scenarios/banking_turn.toml"]),
    ("minute", &["fly", "scenarios/banking_turn.toml", "--set", "flight.duration_s=60"]),
    ("glide", &["fly", "scenarios/glider.toml", "--set", "flight.duration_s=1"]),
    ("bank", &["fly", "scenarios/bank30_20g_lev.toml"]),
    ("land", &["fly", "scenarios/land_20g.toml"]),
    (
        "ground",
        &["fly", "scenarios/level_20g.toml", "--set", "air.ground_m=-0.3", "--set", "flight.duration_s=1"],
    ),
    ("dive", &["fly", "scenarios/dive_45_20g.toml"]),
    ("membrane", &["fly", "scenarios/aerobat_membrane.toml"]),
    ("reorientation", &["plan", "scenarios/reorientation.toml"]),
    ("rollin", &["plan", "scenarios/roll_in.toml"]),
    ("spar", &["tether", "cases/pazy.toml"]),
    ("trim", &["trim", "scenarios/cruise_20g.toml"]),
    ("tether", &["tether", "cases/flap_f2.toml"]),
    ("wake", &["wake", "cases/flap_f2.toml"]),
    ("sweep", &["sweep", "sweeps/flap_map.toml"]),
    ("arm", &["rig", "simulate", "rigs/runs/roll15_speed08.toml"]),
    ("armplan", &["rig", "plan", "rigs/runs/roll15_speed08.toml"]),
    (
        "fit",
        &[
            "calibrate",
            "calibrations/two_runs.toml",
            "--set",
            "limits.calibration.wrong_model_chi_squared=1e12",
        ],
    ),
];

/// Makes the runs and opens their pages.
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
            let mut node = Command::new("node");
            node.arg(script.join("check.mjs")).arg(&folder).env("CHROMIUM", &chromium);
            node.env("WINGBEAT", tools::program());
            Tally::of(node)
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
    exports::packages(folder, &package, "puppeteer-core")?;
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
    let (turn, small) = (inside("turn"), inside("small.html"));
    run(&["report", &turn, "--no-wake", "--force", "--quiet", "--out", &small], &[])?;
    let both = inside("two/report.html");
    fs::create_dir_all(folder.join("two")).map_err(|error| error.to_string())?;
    run(&["report", &turn, &inside("glide"), "--force", "--quiet", "--out", &both], &[])?;
    odd_loads(folder)?;
    hostile(folder, &turn)
}

/// Pages of a wing whose loads have no row, one, numbers beyond all sense, or a million rows.
fn odd_loads(folder: &Path) -> Result<(), String> {
    let text = |error: std::io::Error| error.to_string();
    let (from, run) = (folder.join("tether"), folder.join("odd"));
    let loads = fs::read_to_string(from.join("loads.csv")).map_err(text)?;
    let (head, rows) = loads.split_once('\n').ok_or("loads.csv has no rows")?;
    let rows: Vec<&str> = rows.lines().collect();
    let kept = |lines: &mut dyn Iterator<Item = String>| {
        lines.fold(format!("{head}\n"), |text, line| text + &line + "\n")
    };
    let huge = |(k, row): (usize, &&str)| match (k, row.split_once(',')) {
        (3, Some((t, rest))) => format!("{t}{}", ",1e300".repeat(rest.split(',').count())),
        _ => (*row).to_owned(),
    };
    let million = (0..1_000_000).map(|k| format!("{:.4},{}\n", f64::from(k) * 1e-4, k % 7));
    let all = [
        ("none", kept(&mut std::iter::empty())),
        ("one", kept(&mut rows.iter().take(1).map(|row| (*row).to_owned()))),
        ("huge", kept(&mut rows.iter().enumerate().map(huge))),
        ("million", format!("t,force_wind_lift\n{}", million.collect::<String>())),
    ];
    for (name, loads) in all {
        let _ = fs::remove_dir_all(&run);
        fs::create_dir_all(&run).map_err(text)?;
        for file in ["case.toml", "summary.json"] {
            fs::copy(from.join(file), run.join(file)).map_err(text)?;
        }
        fs::write(run.join("loads.csv"), loads).map_err(text)?;
        without_sums(&from, &run)?;
        report(&run, &folder.join(format!("hostile-{name}.html")))?;
    }
    fs::remove_dir_all(&run).map_err(text)
}

/// The manifest of a run without checksums, by which the program would find its files changed.
fn without_sums(from: &Path, to: &Path) -> Result<(), String> {
    let text = |error: std::io::Error| error.to_string();
    let manifest = fs::read_to_string(from.join("manifest.json")).map_err(text)?;
    let mut manifest: serde_json::Value =
        serde_json::from_str(&manifest).map_err(|error| format!("manifest.json: {error}"))?;
    manifest["checksums"].take();
    fs::write(to.join("manifest.json"), manifest.to_string()).map_err(text)
}

/// Writes the `page` of a run.
fn report(run: &Path, page: &Path) -> Result<(), String> {
    let [run, page] = [run, page].map(|path| path.display().to_string());
    let made = tools::wingbeat(&["report", &run, "--force", "--quiet", "--out", &page]);
    tools::succeeds(made).then_some(()).ok_or_else(|| format!("wingbeat report {run}"))
}

/// A run whose name and texts are markup.
fn hostile(folder: &Path, turn: &str) -> Result<(), String> {
    let text = |error: std::io::Error| error.to_string();
    let name = "<img src=x onerror='window.pwned=1'>";
    let run = folder.join(name);
    let _ = fs::remove_dir_all(&run);
    fs::create_dir_all(&run).map_err(text)?;
    fs::copy(Path::new(turn).join("record.parquet"), run.join("record.parquet")).map_err(text)?;
    without_sums(Path::new(turn), &run)?;
    let markup = "</script><script>window.pwned = 1</script>";
    let scenario = fs::read_to_string(Path::new(turn).join("scenario.toml")).map_err(text)?;
    fs::write(run.join("scenario.toml"), format!("# {markup}\n{scenario}")).map_err(text)?;
    let summary = format!("{{ \"status\": \"failed\", \"reason\": \"{markup}\", \"size\": 1e300 }}");
    fs::write(run.join("summary.json"), summary).map_err(text)?;
    report(&run, &folder.join("hostile.html"))
}
