//! Every model in lanes beside the same model alone, and lanes that do not know each other.

use std::path::Path;
use std::sync::Arc;
use wingbeat::math::{Double4, Random, Single8};
use wingbeat::plant::{Plant, PlantLanes};
use wingbeat::robot::Robot;
use wingbeat::scenario::Scenario;
use wingbeat::simulate::{Stepper, Together};

type Robots = Vec<Stepper<Arc<Robot>>>;

const STEP_S: f64 = 1e-3;

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(name);
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
    Scenario::load(&path, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

/// Robots of a scenario, each at a phase and in a state of its own, under inputs of its own.
fn robots(scenario: &Scenario, count: usize) -> Robots {
    let (robot, start) = (Arc::new(scenario.robot().clone()), scenario.start());
    let layout = *robot.layout();
    let one = |number: usize| {
        let mut random = Random::new(number as u64);
        let mut x = start.clone();
        x[layout.velocity..layout.velocity + 3].iter_mut().for_each(|v| *v += random.between(-0.3, 0.3));
        x[layout.rate..layout.rate + 3].iter_mut().for_each(|v| *v += random.between(-1.0, 1.0));
        x[layout.aero..].iter_mut().for_each(|v| *v += random.between(-0.01, 0.01));
        let mut stepper = Stepper::new(robot.clone(), random.between(0.0, 0.3), &x);
        let inputs: Vec<f64> = robot
            .inputs()
            .iter()
            .map(|channel| {
                let share = random.unit();
                if channel.low.is_finite() && channel.high.is_finite() {
                    channel.low + share * (channel.high - channel.low)
                } else {
                    0.0
                }
            })
            .collect();
        stepper.set_inputs(&inputs);
        stepper
    };
    (0..count).map(one).collect()
}

/// Steps the robots of `order` at once, as many steps of 1 ms as asked.
fn together<S: PlantLanes>(robots: &mut Robots, order: &[usize], steps: usize) {
    let plant = robots[0].system();
    let mut together = Together::<S>::new(plant.states().len(), plant.inputs().len());
    let mut all: Vec<Option<&mut Stepper<_>>> = robots.iter_mut().map(Some).collect();
    let mut chosen: Vec<_> = order.iter().map(|number| all[*number].take().unwrap()).collect();
    together.step(&mut chosen, STEP_S, steps);
}

/// Largest difference of two states, in units of 1 + |x|; infinite where a number is lost.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let difference = |(a, b): (&f64, &f64)| (a - b).abs() / (1.0 + b.abs());
    a.iter()
        .zip(b)
        .map(difference)
        .fold(0.0, |most: f64, d| if d.is_nan() { f64::INFINITY } else { most.max(d) })
}

/// What is flown: paper and full, all laws, linkage, elastic joints, motor, tail, four wings, gusts.
const FLOWN: [(&str, &[&str]); 12] = [
    ("banking_turn.toml", &[]),
    ("banking_turn.toml", &["aero.law=stall", "air.gust_m_s=0.3"]),
    ("banking_turn.toml", &["aero.preset=full", "aero.full.strips=9"]),
    ("banking_turn.toml", &["aero.preset=full", "aero.full.strips=16", "aero.law=lev"]),
    ("as_printed_fourier.toml", &[]),
    ("banking_turn_beta.toml", &[]),
    ("cruise_linkage.toml", &[]),
    ("bank15_20g.toml", &[]),
    ("aerobat_elastic.toml", &[]),
    ("motor_flapper.toml", &[]),
    ("glider.toml", &[]),
    ("four_wings.toml", &[]),
];

#[test]
fn lanes_fly_as_robots_alone() {
    for (name, overrides) in FLOWN {
        let scenario = scenario(name, overrides);
        let alone: Vec<Vec<f64>> = robots(&scenario, 8)
            .iter_mut()
            .map(|robot| {
                (0..5).for_each(|_| robot.step(STEP_S).unwrap());
                robot.state().to_vec()
            })
            .collect();
        let (mut double, mut single) = (robots(&scenario, 8), robots(&scenario, 8));
        together::<Double4>(&mut double, &[0, 1, 2, 3], 5);
        together::<Double4>(&mut double, &[4, 5, 6, 7], 5);
        together::<Single8>(&mut single, &[0, 1, 2, 3, 4, 5, 6, 7], 5);
        let mut largest = [0.0_f64; 2];
        for (i, alone) in alone.iter().enumerate() {
            for (largest, robots) in largest.iter_mut().zip([&double, &single]) {
                *largest = largest.max(apart(robots[i].state(), alone));
            }
        }
        println!("{name} {overrides:?}: double {:.1e}, single {:.1e}", largest[0], largest[1]);
        assert!(largest[0] < 1e-13, "{name} {overrides:?}: {largest:?}");
        assert!(largest[1] < 3e-5, "{name} {overrides:?}: {largest:?}");
    }
}

fn keeps_to_itself<S: PlantLanes>(name: &str, overrides: &[&str]) {
    let scenario = scenario(name, overrides);
    let states = |order: &[usize], spoil: Option<(usize, usize, f64)>| -> Vec<Vec<u64>> {
        let mut robots = robots(&scenario, 4);
        if let Some((number, state, value)) = spoil {
            robots[number].state_mut()[state] = value;
        }
        together::<S>(&mut robots, order, 5);
        if let Some((number, ..)) = spoil {
            assert!(robots[number].check().is_err(), "{name}");
        }
        robots.iter().map(|robot| robot.state().iter().map(|x| x.to_bits()).collect()).collect()
    };
    let all = states(&[0, 1, 2, 3], None);
    assert!(all.iter().flatten().all(|bits| f64::from_bits(*bits).is_finite()), "{name}");
    for number in 0..4 {
        assert_eq!(states(&[number], None)[number], all[number], "{name}: alone");
    }
    assert_eq!(states(&[3, 1, 0, 2], None), all, "{name}: in another order");
    assert_eq!(states(&[2, 0], None)[2], all[2], "{name}: in other company");
    let rate = scenario.robot().layout().rate;
    for spoiled in [(1, rate, f64::NAN), (1, rate, f64::INFINITY), (1, rate + 1, 1e200)] {
        let beside = states(&[0, 1, 2, 3], Some(spoiled));
        for number in [0, 2, 3] {
            assert_eq!(beside[number], all[number], "{name}: beside {spoiled:?}");
        }
    }
}

#[test]
fn a_lane_does_not_know_the_others() {
    for (name, overrides) in FLOWN {
        keeps_to_itself::<Double4>(name, overrides);
    }
    keeps_to_itself::<Single8>("banking_turn.toml", &[]);
    keeps_to_itself::<Single8>("banking_turn.toml", &["aero.preset=full"]);
}
