//! Robots that learn side by side.

use std::path::Path;
use std::sync::Arc;
use wingbeat::scenario::Scenario;
use wingbeat_config::learn::{BankingTurn, Flock, Precision};

fn flock(count: usize, threads: usize) -> Flock {
    exact(count, threads, Precision::Double)
}

fn exact(count: usize, threads: usize, precision: Precision) -> Flock {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let scenario = Scenario::load(&path, &["flight.duration_s=0.02".into()]).unwrap();
    let task = Arc::new(BankingTurn::of(&scenario).unwrap());
    Flock::new(&scenario, task, count, threads, precision).unwrap()
}

/// What robot `number` of `count` tells of six steps.
fn told(count: usize, threads: usize, number: usize) -> Vec<(Vec<f64>, f64, bool, bool)> {
    let mut flock = flock(count, threads);
    let seeds: Vec<u64> = (0..count).map(|i| (7 + i - number) as u64).collect();
    let start = flock.reset(&seeds, 1.0);
    let seen = flock.observations();
    let mut all = vec![(start[number * seen..][..seen].to_vec(), 0.0, false, false)];
    for step in 0..6 {
        let action = |robot: usize| ((step + robot - number) as f64).sin();
        let actions: Vec<f64> = (0..count).flat_map(|robot| [action(robot + 20); 8]).collect();
        let batch = flock.step(&actions).unwrap();
        let row = batch.observations[number * seen..][..seen].to_vec();
        all.push((row, batch.rewards[number], batch.terminated[number], batch.truncated[number]));
    }
    all
}

#[test]
fn a_robot_does_not_know_its_neighbours() {
    let alone = told(1, 1, 0);
    assert_eq!(told(3, 1, 1), alone);
    assert_eq!(told(5, 2, 4), alone);
}

#[test]
fn an_episode_is_cut_off_at_its_end_and_the_next_one_begins_a_step_later() {
    let told = told(1, 1, 0);
    let flags: Vec<bool> = told.iter().map(|(.., truncated)| *truncated).collect();
    assert_eq!(flags, [false, false, false, false, true, false, false]);
    assert!(told[5].1 == 0.0 && told[6].1 > 0.0 && told[5].0 != told[0].0);
}

#[test]
fn actions_are_kept_within_and_refused_by_their_place() {
    let mut flock = flock(2, 1);
    flock.reset(&[1, 2], 0.0);
    let mut actions = vec![7.0; 16];
    assert_eq!(flock.step(&actions).unwrap().observations[31..39], [1.0; 8]);
    actions[9] = f64::NAN;
    let refused = flock.step(&actions).unwrap_err().to_string();
    assert!(refused.starts_with("actions[1][1] = NaN"), "{refused}");
    assert!(flock.step(&actions[..3]).unwrap_err().to_string().contains("16, 8 of each of 2"));
}

#[test]
fn without_spread_the_start_is_that_of_the_scenario() {
    let mut flock = flock(2, 1);
    let rows = flock.reset(&[1, 2], 0.0);
    assert_eq!(rows[..39], rows[39..]);
    let step = |flock: &mut Flock| flock.step(&[0.0; 16]).unwrap();
    let (first, again) = (step(&mut flock), {
        flock.again();
        step(&mut flock)
    });
    assert_eq!(first, again);
}
