//! Running times of what a flight is made of: medians over repeats, and ratios between them.
//! `cargo xtask bench` runs this.

mod instructions;
mod mechanics;

use std::fs;
use std::hint::black_box;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use wingbeat::aero::SectionMotion;
use wingbeat::math::{RK4, Vec3, Workspace};
use wingbeat::plant::{Linearisation, Plant};
use wingbeat::robot::Robot;
use wingbeat::scenario::{Run, Scenario};

/// Times of each row of which the median is taken.
const REPEATS: usize = 101;

/// Median time of `run`, s, over [`REPEATS`] batches of `batch` runs. Batches of less than a
/// millisecond are seldom interrupted by other work of the machine.
fn median(batch: usize, mut run: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..REPEATS)
        .map(|_| {
            let start = Instant::now();
            (0..batch).for_each(|_| run());
            start.elapsed().as_secs_f64() / batch as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[REPEATS / 2]
}

fn row(name: &str, value: f64, unit: &str) {
    println!("{name:<52} {value:>10.3} {unit}");
}

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(name);
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
    Scenario::load(&path, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

/// Evaluations of the plant in mid flight: whole, of the air alone, and its exact Jacobian.
fn evaluation(name: &str, robot: &Robot, x: &[f64]) {
    let (mut dx, u) = (x.to_vec(), vec![0.01; robot.inputs().len()]);
    let whole = median(100, || {
        robot.rates_in_numbers(black_box(0.1), black_box(x), black_box(&u), &mut dx).unwrap();
        black_box(&dx);
    });
    let air = air(robot);
    let mut linearisation = Linearisation::new(x.len(), u.len());
    let jacobian = median(1, || linearisation.evaluate(robot, black_box(0.1), x, &u).unwrap());
    row(&format!("{name}: evaluation of the plant"), 1e6 * whole, "us");
    row(&format!("{name}:   of which air"), 1e6 * air, "us");
    row(&format!("{name}:   of which body"), 1e6 * (whole - air), "us");
    row(&format!("{name}: exact Jacobian of {} states", x.len()), 1e6 * jacobian, "us");
    row(&format!("{name}:   in evaluations"), jacobian / whole, "");
}

/// Median time of the robot's aerodynamics alone, s, on wings in mid stroke.
fn air(robot: &Robot) -> f64 {
    let (_, aero) = robot.surfaces().next().unwrap();
    let sections: Vec<SectionMotion<f64>> = aero.arcs().iter().map(|&arc| section(arc)).collect();
    let x: Vec<f64> = (0..aero.states()).map(|i| 0.05 * (i as f64).sin()).collect();
    let mut dx = x.clone();
    median(100, || {
        black_box(aero.evaluate_sum(
            black_box(&sections),
            Vec3([-1.0, 0.0, 0.2]),
            black_box(&x),
            &mut dx,
            None,
        ));
    })
}

fn section(arc: f64) -> SectionMotion<f64> {
    SectionMotion {
        le: Vec3([0.05, arc, 0.02 * arc]),
        te: Vec3([-0.08, arc, 0.02 * arc]),
        v_le: Vec3([1.0, 0.1, arc]),
        v_te: Vec3([1.0, 0.1, arc + 0.1]),
        a_le: Vec3([1.0, 2.0, 20.0 * arc]),
        a_te: Vec3([1.0, 2.0, 21.0 * arc]),
        span: Vec3([0.0, -1.0, 0.0]),
        w: Vec3([1.0, 0.2, 0.3]),
        alpha: Vec3([30.0, 2.0, 3.0]),
    }
}

/// Whole flights: updates of the controller, and the real-time factor, each the median flight of five.
fn flights(name: &str, file: &str, overrides: &[&str]) {
    let scenario = scenario(file, overrides);
    let mut runs: Vec<Run> =
        (0..5).filter_map(|_| scenario.fly(|_| ControlFlow::Continue(())).ok()).collect();
    runs.sort_by(|a, b| a.summary.real_time_factor.total_cmp(&b.summary.real_time_factor));
    let summary = &runs[runs.len() / 2].summary;
    row(&format!("{name}: update of the controller, median"), summary.controller.median_us, "us");
    row(&format!("{name}:   99 %"), summary.controller.p99_us, "us");
    row(&format!("{name}:   99.9 %"), summary.controller.p999_us, "us");
    row(&format!("{name}: real-time factor"), summary.real_time_factor, "");
}

/// Five simulated seconds of the plant in steps of 0.1 ms, regulators at rest, no controller:
/// a thousand times the median of blocks of 5 ms.
fn uncontrolled(name: &str, robot: &Robot, start: &[f64]) {
    let (u, step, per_block) = (vec![0.0; robot.inputs().len()], 1e-4, 50);
    let mut work = Workspace::new(start.len(), 4);
    let (mut x, mut k) = (start.to_vec(), 0);
    let mut blocks: Vec<f64> = (0..1000)
        .map(|_| {
            let clock = Instant::now();
            for _ in 0..per_block {
                let rates = |t: f64, x: &[f64], dx: &mut [f64]| robot.rates_in_numbers(t, x, &u, dx);
                RK4.step(rates, f64::from(k) * step, step, &mut x, &mut work)
                    .unwrap_or_else(|fault| panic!("{fault}"));
                k += 1;
            }
            clock.elapsed().as_secs_f64()
        })
        .collect();
    blocks.sort_by(f64::total_cmp);
    row(&format!("{name}: 5 s at 0.1 ms, no controller"), 1000.0 * blocks[500], "s");
}

/// Largest resident memory of this process so far, MiB; none where the system does not say.
fn peak_memory() -> Option<f64> {
    let status = fs::read_to_string(Path::new("/proc/self/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(("count", work)) = arguments.split_first().map(|(first, rest)| (first.as_str(), rest)) {
        assert!(instructions::count(work).is_some(), "count WORK PRESET STRIPS RUNS");
        return;
    }
    mechanics::rows();
    let full: &[&str] = &["aero.preset='full'", "aero.full.strips=16"];
    let cases: [(&str, &str, &[&str]); 5] = [
        ("paper, 12 strips", "banking_turn.toml", &[]),
        ("paper, 16 strips", "banking_turn.toml", &["aero.paper.nodes=16"]),
        ("full, 9 strips", "banking_turn.toml", &["aero.preset='full'", "aero.full.strips=9"]),
        ("full, 16 strips", "banking_turn.toml", full),
        ("linkage, paper, 12 strips", "banking_turn_beta.toml", &[]),
    ];
    for (name, file, overrides) in cases {
        let scenario = scenario(file, overrides);
        evaluation(name, scenario.robot(), &scenario.start());
        uncontrolled(name, scenario.robot(), &scenario.start());
    }
    flights("banking turn, paper", "banking_turn.toml", &[]);
    flights("banking turn, full, 16 strips", "banking_turn.toml", full);
    if let Some(memory) = peak_memory() {
        row("peak memory", memory, "MiB");
    }
}
