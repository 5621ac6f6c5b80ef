//! What a flight cost: the shares of the weight by part, and the powers with their names.

use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::aero::{LoadSource, Loads};
use wingbeat::math::{GRAVITY, Quat, Vec3, Wrench};
use wingbeat::plant::Plant;
use wingbeat::robot::{BeyondLoads, WeightPart};
use wingbeat::scenario::{Run, Scenario};
use wingbeat::simulate::{Cost, Record};

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(name);
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).into()).collect();
    Scenario::load(&path, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

fn fly(scenario: &Scenario) -> Run {
    scenario.fly(|_| ControlFlow::Continue(())).unwrap()
}

/// Share of the weight that the recorded forces of `sources` (their names) carry at a row.
fn carried(record: &Record, row: usize, mass: f64, sources: &[&str]) -> f64 {
    let at = |name: &str| record.values(name).map_or(0.0, |values| values[row]);
    let quat = ["w", "x", "y", "z"].map(|axis| at(&format!("quat_{axis}")));
    let attitude = Quat::from_wxyz(&quat).matrix();
    let of = |source: &str| Vec3(["x", "y", "z"].map(|axis| at(&format!("{source}_{axis}"))));
    let force = sources.iter().fold(Vec3::ZERO, |sum, source| sum + of(source));
    (attitude * force)[2] / (mass * GRAVITY)
}

fn share(record: &Record, row: usize, parts: &[WeightPart]) -> f64 {
    parts.iter().map(|part| record.values(&Cost::column(*part)).unwrap()[row]).sum()
}

/// All powers of a flight are means over the same strokes: what drive and actuators take is the net power, and what they give is no less
/// than the positive one.
#[test]
fn powers_of_a_short_flight_are_of_the_same_strokes() {
    let run = fly(&scenario("banking_turn.toml", &["flight.duration_s=0.9", "goal.settle_s=0.2"]));
    let of = |key: &str| {
        let found = run.summary.measured.iter().find(|(measure, _)| measure.key == key);
        found.and_then(|(_, value)| value.to_owned()).unwrap()
    };
    let cost = &run.summary.cost;
    let (net, positive) = (cost.net_power_w.unwrap(), cost.positive_power_w.unwrap());
    let sum = of("drive_power_w") + of("regulator_power_w");
    assert!((sum - net).abs() < 1e-9 * net.abs(), "{sum} {net}");
    assert!(of("drive_power_given_w") + of("regulator_power_given_w") >= positive, "{positive}");
}

/// At every instant the parts sum to the forces by source, as these are recorded, and all together to the upward force.
#[test]
fn the_shares_of_the_weight_sum_to_the_upward_force() {
    use WeightPart::*;
    let air: Vec<String> = LoadSource::ALL
        .into_iter()
        .filter(|source| source.is_of_air())
        .map(|source| format!("force_{}", source.name()))
        .chain(["thrust".to_owned()])
        .collect();
    let air: Vec<&str> = air.iter().map(String::as_str).collect();
    let groups: [(&[WeightPart], &[&str]); 5] = [
        (&[Attached, Suction, Vortex], &["force_circulatory"]),
        (&[Wash], &["force_induced_drag"]),
        (&[AddedMass], &["force_added_mass"]),
        (&[Separated, Friction], &["force_profile_drag"]),
        (&[BodyDrag, Residual, Thrust], &["force_body_drag", "thrust"]),
    ];
    let brief = "flight.duration_s=0.04";
    for (file, preset) in [
        ("banking_turn.toml", "paper"),
        ("banking_turn.toml", "full"),
        ("four_wings.toml", "full"),
        ("hover_guarded.toml", "full"),
    ] {
        for law in ["linear", "stall", "lev"] {
            let asked = [brief, &format!("aero.preset={preset}"), &format!("aero.law={law}")];
            let scenario = scenario(file, &asked);
            let (run, mass) = (fly(&scenario), scenario.robot().mass());
            let record = &run.record;
            for row in 0..record.rows() {
                for (parts, sources) in &groups {
                    let off = share(record, row, parts) - carried(record, row, mass, sources);
                    assert!(off.abs() < 1e-12, "{file} {preset} {law}, row {row}: {parts:?} are {off} off");
                }
                let off = share(record, row, &WeightPart::ALL) - carried(record, row, mass, &air);
                assert!(off.abs() < 1e-12, "{file} {preset} {law}, row {row}: {off} left");
            }
            let least =
                |part| (0..record.rows()).map(|row| share(record, row, &[part]).abs()).fold(0.0, f64::max);
            assert_eq!(least(Vortex) > 0.0, law == "lev", "{file} {preset} {law}");
            assert!(least(Separated) > 0.0 && least(Friction) > 0.0 && least(Suction) > 0.0);
            let cost = Cost::of_record(record, 0).unwrap();
            // The record is shorter than a stroke: all of it counts.
            let up = (0..record.rows()).map(|row| carried(record, row, mass, &air)).sum::<f64>();
            assert!((cost.carried() - up / record.rows() as f64).abs() < 1e-12);
            assert!(cost.separate_power >= cost.positive_power && cost.positive_power >= cost.net_power);
            // Nothing is averaged before the goal's settling time.
            assert_eq!(run.summary.cost.weight_carried.is_some(), scenario.spec.goal.is_none());
        }
    }
}

/// Without its coefficient a part is nothing, and the flow of the equations as printed has suction alone beside its normal force.
#[test]
fn a_part_hangs_on_its_own_coefficient() {
    let largest = |file: &str, asked: &[&str], part: WeightPart| {
        let all = [&["flight.duration_s=0.01"], asked].concat();
        let record = fly(&scenario(file, &all)).record;
        (0..record.rows()).map(|row| share(&record, row, &[part]).abs()).fold(0.0, f64::max)
    };
    for law in ["aero.law=linear", "aero.law=stall"] {
        assert_eq!(
            largest("cruise_20g.toml", &[law, "robot.surfaces[0].cd90=0.0"], WeightPart::Separated),
            0.0,
            "{law}"
        );
        assert!(
            largest("cruise_20g.toml", &[law, "robot.surfaces[0].cd0=0.0"], WeightPart::Friction) < 1e-15,
            "{law}"
        );
    }
    let printed = ["aero.preset=as_printed", "aero.law=linear"];
    assert!(largest("banking_turn.toml", &printed, WeightPart::Suction) > 0.01);
    assert_eq!(largest("banking_turn.toml", &printed, WeightPart::Vortex), 0.0);
}

/// What `cd90` gives is named by the laws of the surfaces, in tables as in legends.
#[test]
fn the_part_of_cd90_has_the_name_that_its_law_deserves() {
    let short = "flight.duration_s=0.8";
    let of_turn = |law: &str| scenario("banking_turn.toml", &[short, "goal.settle_s=0.2", law]);
    let of_glider = scenario("glider.toml", &["robot.surfaces[1].law=lev"]);
    for (scenario, words) in [
        (of_turn("aero.law=linear"), "broadside drag (cd90)"),
        (of_turn("aero.law=stall"), "separated flow (cd90)"),
        (of_glider, "broadside force (cd90)"),
    ] {
        assert_eq!(WeightPart::Separated.words(scenario.robot().broadside_words()), words);
    }
    let lines = fly(&of_turn("aero.law=linear")).summary.cost.weight_lines();
    assert!(lines.iter().any(|(name, ..)| *name == "broadside drag (cd90)"), "{lines:?}");
}

/// Under loads from beyond the model they are the attached flow's; nothing is counted twice.
#[test]
fn loads_from_beyond_the_model_are_shared_once() {
    let scenario = scenario("banking_turn.toml", &["aero.law=lev", "aero.preset=full"]);
    let robot = scenario.robot();
    let (x, u) = (scenario.start(), vec![0.0; robot.inputs().len()]);
    let links = (0..robot.bearers())
        .map(|k| Wrench { force: Vec3::new(0.01 * k as f64, -0.02, 0.03), moment: Vec3::ZERO })
        .collect();
    let beyond = BeyondLoads { links, bends: Vec::new() };
    let seen = robot.observe_beyond(0.0, &x, &u, &beyond, Loads::boxed()).unwrap();
    let shares = seen.weight_shares(robot.mass());
    let up = (seen.attitude * (seen.air.total() + seen.body_drag + seen.thrust).force)[2];
    let off = shares.iter().sum::<f64>() - up / (robot.mass() * GRAVITY);
    assert!(off.abs() < 1e-12, "{off}");
    assert_eq!((shares[1], shares[2], shares[5], shares[6]), (0.0, 0.0, 0.0, 0.0));
}

/// An observation that writes over the strips of another robot tells what a fresh one does.
#[test]
fn loads_written_over_are_those_of_fresh_room() {
    let robots = ["full", "paper"].map(|preset| {
        scenario(
            "banking_turn.toml",
            &["aero.law=lev", &format!("aero.preset={preset}"), "aero.full.strips=16"],
        )
    });
    let [other, scenario] = &robots;
    let look = |of: &Scenario, strips| {
        let (robot, x) = (of.robot(), of.start());
        robot.observe_beyond(0.02, &x, &vec![0.01; robot.inputs().len()], &BeyondLoads::NONE, strips).unwrap()
    };
    let over = look(scenario, look(other, Loads::boxed()).strips);
    let fresh = look(scenario, Loads::boxed());
    assert_eq!(over.strips.strips, 12);
    assert_eq!(format!("{over:?}"), format!("{fresh:?}"));
}

/// A periodic level flight is carried whole, its powers are those of its record, and those of the flight on it.
#[test]
fn a_level_orbit_carries_its_weight_and_flies_at_its_powers() {
    let trimmed = scenario("cruise_20g_lev.toml", &[]).trim(&mut |_| ControlFlow::Continue(())).unwrap();
    let summary = &trimmed.summary;
    let cost = &summary.cost;
    let lift = summary.lift_over_weight.unwrap();
    assert!((cost.weight_carried.unwrap() - lift).abs() < 1e-12 && (lift - 1.0).abs() < 1e-6);
    let mass = cost.positive_power_w.unwrap() / cost.positive_power_w_kg.unwrap();
    let recorded = Cost::of_record(&trimmed.record.unwrap(), 1).unwrap();
    let [of_cycle, of_record] = [
        [cost.positive_power_w, cost.separate_power_w, cost.net_power_w].map(Option::unwrap),
        [recorded.positive_power, recorded.separate_power, recorded.net_power],
    ];
    println!("{of_cycle:?} W, {mass} kg, {:?}", cost.weight_shares);
    for (a, b) in of_cycle.iter().zip(of_record) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} and {b}");
    }
    assert!((recorded.carried() - lift).abs() < 1e-9);
    // docs/flight.md and docs/gaits.md print it.
    assert!(
        (summary.power_w_kg.unwrap() - 50.6).abs() < 0.05 && summary.power_w_kg == cost.positive_power_w_kg
    );
    assert!((cost.net_power_w_kg.unwrap() - 33.5).abs() < 0.05, "{cost:?}");
    let (_, text) = &trimmed.files[0];
    let document = wingbeat::scenario::Document::text("orbit", text).unwrap();
    let flown = Scenario::new(document.set("flight.duration_s=4.0")).unwrap();
    let flown = fly(&flown).summary.cost;
    println!("{flown:?}");
    let sum: f64 = flown.weight_shares.values().sum();
    assert!((sum - flown.weight_carried.unwrap()).abs() < 1e-12);
    let near = |a: Option<f64>, b: Option<f64>| (a.unwrap() / b.unwrap() - 1.0).abs() < 0.02;
    assert!(near(flown.positive_power_w_kg, cost.positive_power_w_kg), "{flown:?} {cost:?}");
    assert!(
        near(flown.net_power_w_kg, cost.net_power_w_kg) && near(flown.weight_carried, cost.weight_carried)
    );
}
