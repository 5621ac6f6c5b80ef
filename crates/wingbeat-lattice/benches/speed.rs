//! Running times of the lattice: case F2 on the panels and steps of PteraSoftware's, and with `growth` what a free wake of up to
//! 200 000 rings costs a step, by direct and by fast sums.
//!
//! Prints `name<TAB>number`: seconds of processor time, medians over repeats; MB of memory; relative errors.

use cpu_time::ProcessTime;
use std::hint::black_box;
use std::path::Path;
use wingbeat::math::Vec3;
use wingbeat::scenario::TetherCase;
use wingbeat_lattice::{
    FlappingWing, Lattice, LatticeLoads, LatticeSettings, Panels, Scene, Spacing, WakeMotion,
};

/// Steps of a cycle, cycles, frequency (Hz) and chord (m) of the case.
const STEPS: usize = 48;
const CYCLES: usize = 3;
const FREQUENCY: f64 = 3.5;
const CHORD: f64 = 0.08;
/// Repeats of a run.
const REPEATS: usize = 5;
/// Segments from which the fast run sums by multipoles.
const FAST: usize = 1000;
/// Strips of the large wakes, and points at which their direct sum is taken.
const STRIPS: usize = 100;
const SAMPLES: usize = 2000;

fn case() -> FlappingWing {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
    let none = |file: &Path| Err(format!("{} is not read here", file.display()));
    let case = TetherCase::load(&path, &[], &none).unwrap_or_else(|error| panic!("{error}"));
    FlappingWing::try_from(&case.tether).unwrap_or_else(|error| panic!("{error}"))
}

fn settings(wake: WakeMotion, fast_from: usize, steps: usize) -> LatticeSettings {
    let own = LatticeSettings::new(1.0 / (FREQUENCY * steps as f64), 0.03 * CHORD);
    LatticeSettings { wake, fast_from, ..own }
}

/// Loads of the case with panels `fine` times as many along the chord and the span, and as many steps.
fn run(wake: WakeMotion, halved: bool, fast_from: usize, fine: usize) -> Vec<LatticeLoads> {
    let panels = Panels { chordwise: 4 * fine, spanwise: 20 * fine, spacing: Spacing::Uniform };
    let scene = Scene::new(&case(), panels, halved).unwrap_or_else(|error| panic!("{error}"));
    let settings = settings(wake, fast_from, fine * STEPS);
    let mut lattice = Lattice::new(scene, settings).unwrap_or_else(|error| panic!("{error}"));
    let step = |_| lattice.step().unwrap_or_else(|error| panic!("{error}"));
    (0..CYCLES * STEPS * fine).map(step).collect()
}

/// Median processor time of `work`, s.
fn median(repeats: usize, mut work: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..repeats)
        .map(|_| {
            let start = ProcessTime::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[repeats / 2]
}

fn row(name: &str, value: f64) {
    println!("{name}\t{value:e}");
}

/// Most memory that the program has held, MB.
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().trim_end_matches("kB").trim().parse::<f64>().ok()? / 1024.0)
}

/// Rms difference of lift over the last cycle over its rms, every `other`-th of `b`.
fn apart(a: &[LatticeLoads], b: &[LatticeLoads], other: usize) -> f64 {
    let last = (CYCLES - 1) * STEPS;
    let lift = |loads: &LatticeLoads| loads.joukowski.force[2];
    let pairs = a[last..].iter().map(lift).zip(b[last * other..].iter().step_by(other).map(lift));
    let (far, size) = pairs.fold((0.0, 0.0), |(far, size), (a, b)| (far + (a - b).powi(2), size + b * b));
    (far / size).sqrt()
}

fn flapping() {
    let simulated = CYCLES as f64 / FREQUENCY;
    let time = |name: &str, wake, halved, fast| {
        row(name, median(REPEATS, || drop(black_box(run(wake, halved, fast, 1)))) / simulated);
    };
    time("lattice_prescribed", WakeMotion::Prescribed, true, usize::MAX);
    time("lattice_free", WakeMotion::Free, true, usize::MAX);
    time("lattice_free_fast", WakeMotion::Free, true, FAST);
    time("lattice_prescribed_whole", WakeMotion::Prescribed, false, usize::MAX);
    time("lattice_free_whole", WakeMotion::Free, false, usize::MAX);
    if let Some(memory) = memory() {
        row("memory_mb", memory);
    }
}

/// Lift of the free wake summed fast and directly, and against panels and steps twice as fine.
fn errors() {
    let direct = run(WakeMotion::Free, true, usize::MAX, 1);
    row("fast_over_direct", apart(&run(WakeMotion::Free, true, FAST, 1), &direct, 1));
    row("coarse_over_fine", apart(&direct, &run(WakeMotion::Free, true, 20_000, 2), 2));
}

/// A wake of `rings` rings as the case leaves it in the wind, with a made circulation.
fn large(rings: usize, fast_from: usize) -> Lattice {
    let panels = Panels { chordwise: 1, spanwise: STRIPS, spacing: Spacing::Uniform };
    let scene = Scene::new(&case(), panels, false).unwrap_or_else(|error| panic!("{error}"));
    let settings = settings(WakeMotion::Prescribed, fast_from, STEPS);
    let mut lattice = Lattice::new(scene, settings).unwrap_or_else(|error| panic!("{error}"));
    for k in 0..rings / STRIPS + 1 {
        let phase = std::f64::consts::TAU * k as f64 / STEPS as f64;
        let ring = |j: usize| {
            let y = 2.0 * (j as f64 + 0.5) / STRIPS as f64 - 1.0;
            (1.0 - y * y).sqrt() * (0.02 + 0.1 * phase.cos())
        };
        let rings: Vec<f64> = (0..STRIPS).map(ring).collect();
        lattice.step_with(&rings).unwrap_or_else(|error| panic!("{error}"));
    }
    lattice
}

/// Time of the velocities at all vertices of large wakes.
fn growth() {
    for rings in [5_000, 10_000, 20_000, 50_000, 100_000, 200_000] {
        let (direct, fast) = (large(rings, usize::MAX), large(rings, 0));
        let points = &fast.wakes()[0].grid.points;
        let every = points.len().div_ceil(SAMPLES);
        let some: Vec<Vec3> = points.iter().step_by(every).copied().collect();
        let mut exact = Vec::new();
        let time = median(1, || exact = direct.velocities(&some));
        row(&format!("direct_{rings}"), time * points.len() as f64 / some.len() as f64);
        let mut found = Vec::new();
        row(&format!("fast_{rings}"), median(3, || found = fast.velocities(points)));
        let wind = fast.scene().wind;
        let pairs = exact.iter().zip(found.iter().step_by(every));
        let (far, size) = pairs.fold((0.0, 0.0), |(far, size), (a, b)| {
            (far + (*a - *b).norm_squared(), size + (*a - wind).norm_squared())
        });
        row(&format!("error_{rings}"), (far / size).sqrt());
    }
    if let Some(memory) = memory() {
        row("memory_large_mb", memory);
    }
}

fn main() {
    let asked = |name: &str| std::env::args().any(|argument| argument == name);
    if asked("growth") {
        growth();
        return;
    }
    if asked("errors") {
        errors();
        return;
    }
    flapping();
}
