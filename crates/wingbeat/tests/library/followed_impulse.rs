//! The impulse of the air that states follow: its rate is the force.

use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::math::{Jet, Quat, Vec3};
use wingbeat::plant::{Early, Plant};
use wingbeat::robot::BodyMotion;
use wingbeat::scenario::{Scenario, TetherCase};
use wingbeat::simulate::{Ending, Held, Moment, Record, Stepper};
use wingbeat::tether::Tether;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The wing that folds, with its impulse followed on so many strips.
fn folding(law: &str, strips: usize) -> Tether {
    let none = |_: &std::path::Path| Err::<Record, String>("no table".into());
    let following = "aero.full.folding_rates=true".into();
    let set = [format!("aero.law={law}"), format!("aero.full.strips={strips}"), following];
    TetherCase::load(&root().join("cases/flap_fold.toml"), &set, &none).unwrap().tether
}

/// States along the last cycle of `tether`, at the times of its steps.
fn cycle(tether: &Tether) -> Vec<(f64, Vec<f64>)> {
    let (clock, mut states) = (tether.clock, Vec::new());
    let mut keep = Held(|step: usize, at: Moment| {
        if step >= clock.steps() - clock.steps_per_cycle {
            states.push((at.t, at.x.to_vec()));
        }
        Ok(ControlFlow::Continue(()))
    });
    let ending = Stepper::new(tether, 0.0, &tether.start()).run(clock.step(), clock.steps(), &mut keep);
    assert_eq!(ending, Ending::Complete);
    states
}

/// The impulses of the air itself, which the states that follow them are drawn to.
fn impulses(tether: &Tether, t: f64, x: &[f64]) -> Vec<f64> {
    let mut x = x.to_vec();
    tether.settle(t, &mut x);
    x[x.len() - tether.aero.strips()..].to_vec()
}

#[test]
fn the_impulse_is_followed_and_its_rate_has_no_mean() {
    // What is faster than the states: share of the impulse of a strip; of the force per length of span, and of the wing's.
    // `stall` separates at once, so the force that separation changes within T is lost there. Per length of span the share is free
    // of the strips' widths: with 16 and 32 strips .558 and .543, with four times the steps .557 and .546, so much that it is not
    // judged. The wing's is .100 and .101, .102 with four times the steps. Steps move those of the other laws by 1 % at most: .026 and .021
    // in `linear`, .0093 and .0088 in `lev`.
    for (law, strips, [held, local, wing]) in [
        ("linear", 16, [0.02, 0.028, 0.022]),
        ("stall", 16, [0.15, f64::INFINITY, 0.12]),
        ("stall", 32, [0.15, f64::INFINITY, 0.12]),
        ("lev", 16, [0.02, 0.012, 0.01]),
    ] {
        let tether = folding(law, strips);
        let states = cycle(&tether);
        let impulse: Vec<Vec<f64>> = states.iter().map(|(t, x)| impulses(&tether, *t, x)).collect();
        let each = || (0..states.len()).flat_map(|k| (0..strips).map(move |i| (k, i)));
        let largest =
            |of: &dyn Fn(usize, usize) -> f64| each().map(|(k, i)| of(k, i).abs()).fold(0.0, f64::max);
        let followed = |x: &[f64], i: usize| x[x.len() - strips + i];
        let size = largest(&|k, i| followed(&states[k].1, i));
        let error = largest(&|k, i| followed(&states[k].1, i) - impulse[k][i]);
        assert!(error < held * size, "{law}: impulse off by {error} of {size} N s");
        // The force is the rate of the impulse itself, by differences of two steps, but for what is faster than the states.
        let rate = |k: usize, i: usize| {
            (impulse[k + 1][i] - impulse[k - 1][i]) / (states[k + 1].0 - states[k - 1].0)
        };
        let forces: Vec<Vec<f64>> = states
            .iter()
            .map(|(t, x)| {
                let mut dx = vec![0.0; x.len()];
                tether.evaluate(*t, x, &mut dx, &mut wingbeat::aero::Loads::default());
                dx[dx.len() - strips..].to_vec()
            })
            .collect();
        let widths = tether.aero.widths();
        let per_length = |k, i| [rate(k, i) / widths[i], forces[k][i] / widths[i]];
        let inner = 1..states.len() - 1;
        let worse = |[scale, error]: [f64; 2], [rate, force]: [f64; 2]| {
            [scale.max(rate.abs()), error.max((rate - force).abs())]
        };
        let along = inner.clone().flat_map(|k| (0..strips).map(move |i| per_length(k, i)));
        let [scale, error] = along.fold([0.0; 2], worse);
        assert!(error < local * scale, "{law}: force off by {error} of {scale} N/m");
        let whole = |k: usize| [(0..strips).map(|i| rate(k, i)).sum(), forces[k].iter().sum()];
        let [scale, error] = inner.map(whole).fold([0.0; 2], worse);
        assert!(error < wing * scale, "{law}: force of the wing off by {error} of {scale} N");
        // Over a cycle the forces add up to the change of the impulses followed, which ends where it began once the wake has settled.
        let last = &states[states.len() - 1].1;
        let change: f64 = (0..strips).map(|i| followed(last, i) - followed(&states[0].1, i)).sum();
        let force_over = |k: usize| forces[k].iter().sum::<f64>() * tether.clock.step();
        let whole: f64 = (0..states.len() - 1).map(|k| 0.5 * (force_over(k) + force_over(k + 1))).sum();
        assert!((whole - change).abs() < 1e-3 * size, "{law}: {whole} and {change} N s");
        assert!(change.abs() < 0.05 * size, "{law}: the cycle closes within {change} of {size} N s");
    }
}

/// A robot in flight whose impulses are followed, with every part in motion.
fn flying(scenario: &str, extra: &[&str]) -> (Scenario, Vec<f64>) {
    let set = ["aero.preset=full", "aero.full.folding_rates=true"].iter().chain(extra);
    let set: Vec<String> = set.map(|text| (*text).to_owned()).collect();
    let scenario = Scenario::load(&root().join(format!("scenarios/{scenario}.toml")), &set).unwrap();
    let (mut x, layout) = (scenario.start(), *scenario.robot().layout());
    Quat::from_roll_pitch_yaw(0.2, -0.3, 0.4).store_wxyz(&mut x[layout.attitude..]);
    Vec3::new(0.4, -0.8, 0.5).store(&mut x[layout.rate..]);
    for (i, lag) in x[layout.aero..].iter_mut().enumerate() {
        *lag += 0.02 * (1.7 * i as f64).sin();
    }
    (scenario, x)
}

/// The rates of a free robot are those of one that is carried with the acceleration found.
#[test]
fn a_free_robot_follows_its_impulses_like_a_carried_one() {
    for (name, extra) in [
        ("banking_turn", &[][..]),
        ("aerobat_elastic", &[]),
        ("four_wings", &[]),
        ("banking_turn", &["aero.law=lev"]),
    ] {
        let (scenario, x) = flying(name, extra);
        let (robot, t) = (scenario.robot(), 0.13);
        let (l, u) = (robot.layout(), vec![0.0; robot.inputs().len()]);
        let mut dx = vec![0.0; x.len()];
        robot.rates_in_numbers(t, &x, &u, &mut dx).unwrap();
        let attitude = Quat::from_wxyz(&x[l.attitude..]).matrix();
        let body = BodyMotion {
            rate: Vec3::from_slice(&x[l.rate..]),
            acceleration: Vec3::from_slice(&dx[l.velocity..]),
            angular_acceleration: Vec3::from_slice(&dx[l.rate..]),
            ..BodyMotion::steady(attitude, Vec3::from_slice(&x[l.velocity..]))
        };
        let mut carried = vec![0.0; robot.carried_states()];
        robot.carried_in_numbers(&Jet::new(t, 1.0, 0.0), &body, &x[l.structure..], &u, &mut carried).unwrap();
        let free = &dx[l.structure..];
        let largest = free.iter().fold(0.0_f64, |m, rate| m.max(rate.abs()));
        for (i, (a, b)) in free.iter().zip(&carried).enumerate() {
            let channel = &robot.states()[l.structure + i].name;
            assert!((a - b).abs() < 1e-9 * largest, "{name} {channel}: {a} {b}");
        }
        assert!(robot.states().iter().any(|channel| channel.name.contains("impulse")), "{name}");
    }
}

#[test]
fn derivatives_through_followed_impulses_are_exact() {
    let (scenario, x) = flying("aerobat_elastic", &[]);
    let (robot, t, h) = (scenario.robot(), 0.13, 1e-6);
    let u = vec![0.0; robot.inputs().len()];
    let direction: Vec<f64> = (0..x.len()).map(|i| (0.9 * i as f64).cos()).collect();
    let along = |step: f64| {
        let moved: Vec<f64> = x.iter().zip(&direction).map(|(x, d)| x + step * d).collect();
        let mut dx = vec![0.0; x.len()];
        robot.rates_in_numbers(t, &moved, &u, &mut dx).unwrap();
        dx
    };
    let lifted: Vec<Early> =
        x.iter().zip(&direction).map(|(x, d)| Early::variable(*x, 0) * *d + (*x - *x * *d)).collect();
    let (inputs, mut dx) = (vec![Early::constant(0.0); u.len()], vec![Early::constant(0.0); x.len()]);
    robot.rates_in_early(t, &lifted, &inputs, &mut dx).unwrap();
    let (ahead, behind) = (along(h), along(-h));
    let largest = dx.iter().fold(0.0_f64, |m, rate| m.max(rate.eps[0].abs()));
    for ((exact, a), b) in dx.iter().zip(&ahead).zip(&behind) {
        assert!((exact.eps[0] - (a - b) / (2.0 * h)).abs() < 1e-6 * largest);
    }
}

#[test]
fn a_flight_with_followed_impulses_begins_without_a_blow() {
    let (scenario, _) = flying("banking_turn", &[]);
    let robot = scenario.robot();
    let (l, u) = (robot.layout(), vec![0.0; robot.inputs().len()]);
    let acceleration = |x: &[f64]| {
        let mut dx = vec![0.0; x.len()];
        robot.rates_in_numbers(0.0, x, &u, &mut dx).unwrap();
        Vec3::from_slice(&dx[l.velocity..]).norm()
    };
    let begun = scenario.start();
    let mut struck = begun.clone();
    for (channel, x) in robot.states().iter().zip(&mut struck) {
        *x = if channel.name.contains("impulse") { 0.0 } else { *x };
    }
    let (begun, struck) = (acceleration(&begun), acceleration(&struck));
    assert!(begun < 20.0 && struck > begun + 2.0, "{begun} m/s2, from zero {struck} m/s2");
}
