//! Robots that differ in their numbers, in lanes: the same bits in any company, and what they do alone but for rounding.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use wingbeat::math::{Double4, Lanes};
use wingbeat::plant::Plant;
use wingbeat::robot::Robot;
use wingbeat::scenario::{Document, Scenario, Sweep, SweepRows};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
    Scenario::load(&root().join("scenarios").join(name), &overrides).unwrap_or_else(|error| panic!("{error}"))
}

/// Rates of robots side by side in one state.
fn rates(robots: &[&Robot], x: &[f64], u: &[f64]) -> Vec<Vec<f64>> {
    let robot: Robot<Double4> = Robot::side_by_side(robots).unwrap();
    let wide = |values: &[f64]| values.iter().map(|v| Double4::from(*v)).collect::<Vec<_>>();
    let mut dx = vec![Double4::from(0.0); x.len()];
    robot.state_rates(Double4::from(0.013), &wide(x), &wide(u), &mut dx).unwrap();
    (0..robots.len()).map(|lane| dx.iter().map(|rate| rate.lane(lane)).collect()).collect()
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Every number of the robot moved by itself, in the second of three lanes.
fn numbers_keep_to_their_lane(name: &str, overrides: &[&str]) {
    let scenario = scenario(name, overrides);
    let robot = scenario.robot();
    let layout = robot.layout();
    let mut x = scenario.start();
    for (i, x) in x[layout.rate..].iter_mut().enumerate() {
        *x += 1e-2 * ((i * i) as f64).sin();
    }
    let u: Vec<f64> = robot.inputs().iter().map(|input| input.clamp(0.02)).collect();
    let own = rates(&[robot], &x, &u);
    let (mut beside, mut moved, mut worst) = (0, 0, 0.0_f64);
    let mut names: Vec<String> = robot.named_numbers().into_iter().map(|(name, _)| name).collect();
    names.sort();
    names.dedup();
    for name in &names {
        let value = robot.named_numbers().into_iter().find(|(other, _)| other == name).unwrap().1;
        let Ok(other) = robot.adjusted(&[(name, value * 1.03)]) else { continue };
        if !robot.fits_beside(&other) {
            continue;
        }
        beside += 1;
        let told = rates(&[robot, &other, robot], &x, &u);
        let alone = rates(&[&other], &x, &u);
        assert_eq!(bits(&told[0]), bits(&own[0]), "{name} moves its neighbours");
        assert_eq!(bits(&told[2]), bits(&own[0]), "{name} moves its neighbours");
        assert_eq!(bits(&told[1]), bits(&alone[0]), "{name} beside others");
        let mut dx = vec![0.0; x.len()];
        other.state_rates(0.013, &x, &u, &mut dx).unwrap();
        let most = dx.iter().fold(1.0, |most: f64, rate| most.max(rate.abs()));
        let apart = dx.iter().zip(&told[1]).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        worst = worst.max(apart / most);
        moved += usize::from(bits(&told[1]) != bits(&own[0]));
    }
    println!(
        "{name} {overrides:?}: {beside} of {} numbers fit, {moved} move something, {worst:.1e}",
        names.len()
    );
    assert!(moved > 20 && worst < 1e-12, "{name}: {moved} numbers, {worst:e}");
}

#[test]
fn every_number_that_fits_keeps_to_its_lane() {
    for (name, overrides) in [
        ("banking_turn.toml", &[] as &[&str]),
        ("banking_turn.toml", &["aero.preset=full", "aero.full.strips=9", "aero.law=lev"]),
        ("cruise_20g.toml", &[]),
        ("cruise_linkage.toml", &[]),
        ("motor_flapper.toml", &[]),
        ("glider.toml", &[]),
    ] {
        numbers_keep_to_their_lane(name, overrides);
    }
}

#[test]
fn what_lays_strips_or_is_not_there_does_not_fit() {
    let scenario = scenario("banking_turn.toml", &[]);
    let robot = scenario.robot();
    let beside = |key: &str, value: f64| robot.fits_beside(&robot.adjusted(&[(key, value)]).unwrap());
    assert!(
        beside("body.mass_kg", 0.02)
            && beside("body.com_m[2]", 0.001)
                == (robot
                    .named_numbers()
                    .iter()
                    .any(|(name, value)| name == "body.com_m[2]" && *value != 0.0))
    );
    let outline =
        robot.named_numbers().into_iter().find(|(name, _)| name.contains("planform_shift_m")).unwrap().0;
    assert!(!beside(&outline, 0.003));
}

fn sweep(name: &str, overrides: &[&str]) -> Sweep {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
    let path = root().join("sweeps").join(name);
    Sweep::load(&path, &overrides, NO_TABLES).unwrap_or_else(|error| panic!("{error}"))
}

const NO_TABLES: wingbeat::scenario::ReadTable = &|_: &Path| Err(String::new());

fn made(sweep: &Sweep, batch: &[usize]) -> SweepRows {
    sweep.rows(batch, NO_TABLES, || ControlFlow::Continue(())).unwrap_or_else(|error| panic!("{error}"))
}

/// Rows of a sweep in lanes: the same whatever is beside them, and near those without lanes; the largest difference in
/// units of 1 + |x|.
fn rows_keep_to_themselves(name: &str, overrides: &[&str]) -> f64 {
    let lanes = sweep(name, &[overrides, &["runs=6", "lanes=true"]].concat());
    let plain = sweep(name, &[overrides, &["runs=6"]].concat());
    let batches = lanes.batches((0..6).collect());
    assert_eq!(batches.iter().map(Vec::len).collect::<Vec<_>>(), [4, 2]);
    assert_eq!(plain.batches((0..6).collect()).len(), 6);
    let whole: Vec<SweepRows> = batches.iter().map(|batch| made(&lanes, batch)).collect();
    assert_eq!(whole.iter().map(|made| made.groups).sum::<usize>(), 2, "{name}");
    let mut worst = 0.0_f64;
    for row in whole.iter().flat_map(|made| &made.rows) {
        let run = row[0] as usize;
        assert!(lanes.has_row(row));
        let company = [run, (run + 3) % 6, (run + 1) % 6];
        assert_eq!(bits(&made(&lanes, &[run]).rows[0]), bits(row), "{name}: run {run} alone");
        assert_eq!(bits(&made(&lanes, &company).rows[0]), bits(row), "{name}: run {run} in other company");
        let scalar = &made(&plain, &[run]).rows[0];
        for (a, b) in row.iter().zip(scalar) {
            assert_eq!(a.is_nan(), b.is_nan(), "{name}: {row:?} {scalar:?}");
            worst = worst.max(if a.is_nan() { 0.0 } else { (a - b).abs() / (1.0 + b.abs()) });
        }
    }
    println!("{name} {overrides:?}: {worst:.1e}");
    worst
}

#[test]
fn rows_in_lanes_do_not_know_their_neighbours() {
    // Under a regulator about an orbit, with gusts and every factor of the mismatch drawn.
    let orbit = ["scenario.flight.duration_s=0.2"];
    assert!(rows_keep_to_themselves("bank15_20g.toml", &orbit) < 1e-9);
    // Under the predictive controller, whose plans stop iterating where they are good enough.
    let turn = ["scenario.flight.duration_s=0.05"];
    assert!(rows_keep_to_themselves("banking_turn_robustness.toml", &turn) < 1e-9);
}

#[test]
fn what_cannot_be_side_by_side_is_grouped_or_refused() {
    let mixed = sweep(
        "banking_turn_robustness.toml",
        &[
            "scenario.flight.duration_s=0.02",
            "lanes=true",
            "runs=4",
            "draws=[{key='aero.law', values=['linear', 'stall']}, {key='mismatch.mass', low=0.9, high=1.1}]",
        ],
    );
    let batches = mixed.batches(vec![0, 1, 2, 3]);
    for batch in &batches {
        let law = |run: &usize| mixed.values(*run)[0];
        assert!(batch.iter().all(|run| law(run) == law(&batch[0])));
    }
    // Side by side by force, they are flown in groups of their own, to the same rows.
    let all = made(&mixed, &[0, 1, 2, 3]);
    assert_eq!(all.groups, batches.len());
    for batch in &batches {
        for row in made(&mixed, batch).rows {
            assert_eq!(bits(&row), bits(&all.rows[row[0] as usize]));
        }
    }
    let text = "name = 'map'\nruns = 2\nlanes = true\ndraws = [{key='time.frequency_hz', low=2.0, high=4.0}]";
    let case = Document::file(&root().join("cases/flap_f2.toml")).unwrap();
    let refused = Sweep::new(Document::text("map", text).unwrap().put("case", case).unwrap(), NO_TABLES);
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("lanes = true") && refused.contains("flights alone"), "{refused}");
}
