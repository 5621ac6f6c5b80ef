//! The linearisation, which leaves out what has no derivative, beside one that carries every derivative through everything.

use std::path::Path;
use wingbeat::math::Random;
use wingbeat::plant::{Early, Linearisation, LocalChart, MAX_STATES, Plant};
use wingbeat::robot::Robot;
use wingbeat::scenario::Scenario;

/// Presets, laws, linkage, elastic joints, motor, tail, several wings, gusts, membranes, a ground, a perch.
const FLOWN: [(&str, &[&str]); 29] = [
    ("banking_turn.toml", &[]),
    ("banking_turn.toml", &["aero.law=stall", "air.gust_m_s=0.3"]),
    ("banking_turn.toml", &["aero.preset=full", "aero.full.strips=9", "air.wind_m_s=[0.2,-0.4,0.1]"]),
    ("banking_turn.toml", &["aero.preset=full", "aero.full.strips=16", "aero.law=lev", "air.gust_m_s=0.3"]),
    ("banking_turn.toml", &["aero.preset=full", "aero.full.strips=9", "aero.law=stall"]),
    ("banking_turn.toml", &["aero.preset=full", "aero.full.strips=16", "aero.full.turning_impulse=true"]),
    (
        "banking_turn.toml",
        &[
            "aero.preset=full",
            "aero.full.strips=16",
            "aero.full.turning_impulse=false",
            "aero.full.edge_suction=false",
        ],
    ),
    ("banking_turn.toml", &["aero.law=lev", "air.gust_m_s=0.3"]),
    ("banking_turn.toml", &["aero.preset=full", "aero.full.strips=16", "aero.full.edge_suction=true"]),
    (
        "passive_20g.toml",
        &["aero.full.edge_suction=true", "aero.full.strips=16", "air.wind_m_s=[0.2,-0.4,0.1]"],
    ),
    (
        "cruise_44g_lev.toml",
        &["aero.full.edge_suction=true", "aero.full.folding_rates=true", "air.gust_m_s=0.3"],
    ),
    ("aerobat_elastic.toml", &["aero.full.edge_suction=true"]),
    ("as_printed_fourier.toml", &[]),
    ("banking_turn_beta.toml", &[]),
    ("cruise_linkage.toml", &[]),
    ("bank15_20g.toml", &[]),
    ("aerobat_elastic.toml", &[]),
    ("aerobat_elastic.toml", &["aero.preset=paper", "aero.law=stall"]),
    ("aerobat_membrane.toml", &[]),
    ("aerobat_membrane.toml", &["aero.law=lev", "aero.full.strips=12"]),
    ("aerobat_membrane.toml", &["aero.law=linear", "aero.full.strips=16", "air.gust_m_s=0.3"]),
    ("soft_20g.toml", &[]),
    ("soft_20g.toml", &["aero.law=lev", "aero.full.strips=12"]),
    ("flap_glide.toml", &[]),
    ("motor_flapper.toml", &[]),
    ("glider.toml", &[]),
    ("four_wings.toml", &[]),
    ("glider.toml", &["aero.preset=full", "air.ground_m=-0.3", "aero.full.side_edges=true"]),
    (
        "glide.toml",
        &["perch={place_m=[0.0,0.0,0.02],capture_m=0.001,speed_within_m_s=0.1,attitude_within_deg=5.0}"],
    ),
];

/// Derivatives of the rates by all states, then by all inputs, a column each.
fn columns<P: Plant>(plant: &P, t: f64, x: &[f64], u: &[f64]) -> Vec<Vec<f64>> {
    let constant = |values: &[f64]| values.iter().map(|v| Early::constant(*v)).collect::<Vec<_>>();
    let mut columns = Vec::new();
    for first in (0..x.len() + u.len()).step_by(Early::LANES) {
        let (mut seeded, mut inputs, mut dx) = (constant(x), constant(u), constant(x));
        let last = (first + Early::LANES).min(x.len() + u.len());
        for column in first..last {
            let (of, i) =
                if column < x.len() { (&mut seeded, column) } else { (&mut inputs, column - x.len()) };
            of[i].eps[column - first] = 1.0;
        }
        plant.rates_in_early(t, &seeded, &inputs, &mut dx).unwrap();
        columns.extend((0..last - first).map(|lane| dx.iter().map(|rate| rate.eps[lane]).collect()));
    }
    columns
}

/// Largest difference of the linearisation, over the largest entry of its row and one.
fn apart<P: Plant>(plant: &P, t: f64, x: &[f64], u: &[f64]) -> f64 {
    let (n, m) = (x.len(), u.len());
    let mut linear = Linearisation::new(n, m);
    linear.evaluate(plant, t, x, u).unwrap();
    let whole = columns(plant, t, x, u);
    let mut values = vec![0.0; n];
    plant.rates_in_numbers(t, x, u, &mut values).unwrap();
    let mut largest: f64 = 0.0;
    for (i, value) in values.iter().enumerate() {
        let scale = whole.iter().fold(1.0, |most: f64, column| most.max(column[i].abs()));
        let of =
            |column: usize| if column < n { linear.a[i * n + column] } else { linear.b[i * m + column - n] };
        for (column, exact) in whole.iter().enumerate() {
            largest = largest.max((of(column) - exact[i]).abs() / scale);
        }
        largest = largest.max((linear.f[i] - value).abs() / (1.0 + value.abs()));
    }
    // States that are driven know only themselves.
    let driven = plant.driven_states();
    for i in driven.clone() {
        let others = (0..n).filter(|column| !driven.contains(column));
        assert!(others.into_iter().all(|column| whole[column][i] == 0.0), "state {i} is not driven");
    }
    let mut inputs = Linearisation::new(n, m);
    inputs.evaluate_inputs(plant, t, x, u).unwrap();
    let same = inputs.b.iter().zip(&linear.b).all(|(a, b)| (a - b).abs() <= 1e-12 * (1.0 + b.abs()));
    assert!(same, "B alone and beside A");
    largest
}

#[test]
fn what_has_no_derivative_is_left_out_and_nothing_else() {
    for (name, overrides) in FLOWN {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(name);
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
        let scenario = Scenario::load(&path, &overrides).unwrap_or_else(|error| panic!("{error}"));
        let (robot, mut x, mut random) = (scenario.robot(), scenario.start(), Random::new(7));
        let layout = robot.layout();
        x[layout.velocity..layout.aero].iter_mut().for_each(|v| *v += random.between(-0.02, 0.02));
        if robot.perch().is_some() {
            // Within the bar, so that it pushes.
            x[layout.position + 2] = 0.018;
            assert!(robot.at_perch(&x).unwrap().force > 0.0);
        }
        x[layout.aero..].iter_mut().for_each(|v| *v += random.between(-0.01, 0.01));
        let u: Vec<f64> = robot.inputs().iter().map(|_| random.between(-0.01, 0.01)).collect();
        let mut largest = apart(robot, 0.13, &x, &u);
        if x.len() <= MAX_STATES {
            let mut chart = LocalChart::new(robot);
            chart.center_at(&x);
            let mut local = vec![0.0; chart.states().len()];
            chart.localise(&x, &mut local);
            local[layout.attitude..layout.attitude + 3].copy_from_slice(&[0.05, -0.1, 0.2]);
            largest = largest.max(apart(&chart, 0.13, &local, &u));
        }
        if robot.is_soft() {
            let (chart, local) = given(robot, &x, &u);
            largest = largest.max(apart(&chart, 0.13, &local, &u));
        }
        println!("{name} {overrides:?}: {largest:.1e}");
        assert!(largest < 1e-12, "{name} {overrides:?}: {largest:.1e}");
    }
}

/// A chart of `robot` whose shape moves as it does in the state `x` under the commands `u`, and that state in it.
fn given<'a>(robot: &Robot, x: &[f64], u: &[f64]) -> (LocalChart<'a, Robot>, Vec<f64>) {
    let mut rates = x.to_vec();
    robot.rates_in_numbers(0.13, x, u, &mut rates).unwrap();
    let other = robot.with_shape_given();
    let (mut kept, mut row) = (Vec::new(), Vec::new());
    for (i, channel) in other.states().iter().enumerate() {
        let of = channel.name.replacen("rate_of_", "", 1);
        let state = robot.states().iter().position(|channel| channel.name == of).unwrap();
        let value = if of == channel.name { x[state] } else { rates[state] };
        let is_given = other.given_states().iter().any(|run| run.contains(&i));
        if is_given { row.push(value) } else { kept.push(value) }
    }
    let mut chart = LocalChart::owning(other);
    chart.motion_mut().rows = row;
    chart.center_at(&kept);
    let mut local = vec![0.0; chart.states().len()];
    chart.localise(&kept, &mut local);
    (chart, local)
}

/// The rates that are left are those of the whole: what holds the given shape is what moved it.
#[test]
fn a_robot_whose_shape_is_given_moves_as_the_one_that_found_it() {
    for name in ["soft_20g.toml", "aerobat_membrane.toml"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(name);
        let scenario = Scenario::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let (robot, mut x, mut random) = (scenario.robot(), scenario.start(), Random::new(3));
        let layout = robot.layout();
        x[layout.velocity..].iter_mut().for_each(|v| *v += random.between(-0.01, 0.01));
        let u: Vec<f64> = robot.inputs().iter().map(|_| random.between(-0.01, 0.01)).collect();
        let mut rates = x.clone();
        robot.rates_in_numbers(0.13, &x, &u, &mut rates).unwrap();
        let (chart, local) = given(robot, &x, &u);
        let mut found = local.clone();
        chart.rates_in_numbers(0.13, &local, &u, &mut found).unwrap();
        assert!(found.len() + 16 < x.len(), "{name}: {} of {} states are left", found.len(), x.len());
        for (channel, found) in chart.states().iter().zip(&found) {
            let Some(i) = robot.states().iter().position(|other| other.name == channel.name) else {
                continue;
            };
            let apart = (found - rates[i]).abs() / (1.0 + rates[i].abs());
            assert!(apart < 1e-10, "{name} {}: {found} {}", channel.name, rates[i]);
        }
    }
}

/// Rates, their derivatives and a sample, in the rooms that this thread keeps.
fn evaluated(scenario: &Scenario) -> Vec<u64> {
    let (robot, x) = (scenario.robot(), scenario.start());
    let u = vec![0.01; robot.inputs().len()];
    let (mut linear, mut rates) = (Linearisation::new(x.len(), u.len()), x.clone());
    robot.rates_in_numbers(0.13, &x, &u, &mut rates).unwrap();
    linear.evaluate(robot, 0.13, &x, &u).unwrap();
    let sample = robot.observe(0.13, &x, &u).unwrap();
    let told = [sample.power, sample.energy, sample.air_power];
    let all = rates.iter().chain(&linear.f).chain(&linear.a).chain(&linear.b);
    all.chain(&told).chain(&sample.torques).map(|value| value.to_bits()).collect()
}

#[test]
fn models_that_take_turns_in_the_rooms_of_a_thread_give_what_fresh_ones_give() {
    let full = |strips: u32, law: &str| {
        let overrides = ["preset=full", &format!("full.strips={strips}"), &format!("law={law}")];
        ("banking_turn.toml", overrides.map(|text| format!("aero.{text}")).to_vec())
    };
    let others = ["aerobat_membrane.toml", "four_wings.toml", "bank15_20g.toml", "banking_turn.toml"];
    let mut flown =
        vec![full(16, "lev"), full(9, "linear"), full(16, "linear"), full(24, "stall"), full(12, "lev")];
    flown.extend(others.map(|name| (name, Vec::new())));
    let scenarios: Vec<Scenario> = flown
        .iter()
        .map(|(name, overrides)| {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(name);
            Scenario::load(&path, overrides).unwrap_or_else(|error| panic!("{error}"))
        })
        .collect();
    let fresh: Vec<Vec<u64>> = std::thread::scope(|scope| {
        scenarios.iter().map(|scenario| scope.spawn(|| evaluated(scenario)).join().unwrap()).collect()
    });
    for _ in 0..2 {
        for ((scenario, fresh), of) in scenarios.iter().zip(&fresh).zip(&flown) {
            assert!(evaluated(scenario) == *fresh, "{of:?}");
        }
    }
}
