//! The banking turn flown through the library: its numbers, its repeatability,
//! its convergence with the step.

use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::aero::LoadSource;
use wingbeat::judge::Status;
use wingbeat::plant::{Linearisation, Plant};
use wingbeat::scenario::{Run, Scenario};
use wingbeat::simulate::Record;

fn fly(overrides: &[&str]) -> Run {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
    let scenario = Scenario::load(&path, &overrides).unwrap_or_else(|e| panic!("{e}"));
    scenario.fly(|_| ControlFlow::Continue(())).unwrap()
}

/// Of a roll that swings about half a turn the mean is half a turn, not the mean of 179 and -179 deg.
#[test]
fn a_flight_on_its_back_has_a_mean_roll_of_half_a_turn() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/glide.toml");
    let sets = ["start.roll_deg=180", "start.rate_rad_s=[0.02, 0.0, 0.0]", "flight.duration_s=0.4"];
    let scenario = Scenario::load(&path, &sets.map(str::to_owned)).unwrap_or_else(|e| panic!("{e}"));
    let run = scenario.fly(|_| ControlFlow::Continue(())).unwrap();
    let roll = run.record.values("roll").unwrap();
    assert!(roll.iter().any(|roll| *roll > 0.0) && roll.iter().any(|roll| *roll < 0.0));
    let mean = run.summary.roll_mean_deg.unwrap();
    assert!(mean.abs() > 170.0, "{mean} deg");
}

#[test]
fn the_banking_turn_holds_the_attitude_of_the_paper_and_converges_with_the_step() {
    let run = fly(&["flight.record_every_s=0.005"]);
    let s = &run.summary;
    assert_eq!(s.status, Status::Ok, "{:?}", s.reason);
    assert!((s.roll_mean_deg.unwrap() - 15.0).abs() < 1.5, "roll {:?}", s.roll_mean_deg);
    assert!((s.pitch_mean_deg.unwrap() + 15.0).abs() < 2.0, "pitch {:?}", s.pitch_mean_deg);
    assert!(s.pitch_half_amplitude_deg.unwrap() < 10.0);
    assert!(s.input_saturation_fraction > 0.1, "the shoulders work at their limits");
    // The end point is a fit, 1.2 m from the paper's (4.1, 5) m.
    assert!(
        (s.distance_x_m - 3.96).hypot(s.distance_y_m + 3.83) < 0.1,
        "{} {}",
        s.distance_x_m,
        s.distance_y_m
    );
    assert_eq!(s.controller.failures, 0);

    let fine = fly(&["flight.record_every_s=0.005", "flight.step_s=5e-5"]).summary;
    let moved = [
        fine.distance_x_m - s.distance_x_m,
        fine.distance_y_m - s.distance_y_m,
        fine.altitude_change_m - s.altitude_change_m,
    ];
    let moved = moved.iter().map(|d| d * d).sum::<f64>().sqrt();
    assert!(moved < 0.05, "halving the step moves the end point by {moved} m");
}

/// The number of nodes, a choice, decides nothing of the turn.
#[test]
#[ignore = "long: cargo xtask long tests"]
fn the_banking_turn_converges_with_the_nodes() {
    let [coarse, fine] = ["12", "24"]
        .map(|nodes| fly(&["flight.record_every_s=0.005", &format!("aero.paper.nodes={nodes}")]).summary);
    let apart = (coarse.distance_x_m - fine.distance_x_m).hypot(coarse.distance_y_m - fine.distance_y_m);
    assert!(apart < 0.3, "twice the nodes move the end by {apart} m");
    assert!(coarse.yaw_change_deg.unwrap() < -100.0 && fine.yaw_change_deg.unwrap() < -100.0);
    assert!((coarse.roll_mean_deg.unwrap() - fine.roll_mean_deg.unwrap()).abs() < 0.5);
}

#[test]
fn the_same_flight_twice_is_the_same_to_the_bit() {
    let overrides = ["flight.duration_s=0.3"];
    let (a, b) = (fly(&overrides).record, fly(&overrides).record);
    for (a, b) in a.columns().iter().zip(b.columns()) {
        let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&a.values), bits(&b.values), "{}", a.name);
    }
}

/// D'Alembert: the inertia of body and links, computed from their accelerations,
/// balances air, gravity and body drag.
#[test]
fn sources_of_force_sum_to_zero() {
    let record = fly(&["flight.duration_s=0.1"]).record;
    let sources = LoadSource::ALL.map(LoadSource::name);
    for row in 0..record.rows() {
        for kind in ["force", "moment"] {
            for axis in ["x", "y", "z"] {
                let value = |s: &&str| record.values(&format!("{kind}_{s}_{axis}")).unwrap()[row];
                let sum: f64 = sources.iter().map(value).sum();
                assert!(sum.abs() < 1e-12, "row {row}: {kind} {axis} {sum} left");
            }
        }
    }
}

/// Columns of one row of a record.
fn at<'a>(record: &'a Record, row: usize) -> impl Fn(&str) -> f64 + 'a {
    move |name| record.values(name).unwrap_or_else(|| panic!("no column {name}"))[row]
}

#[test]
fn strips_sum_to_the_recorded_loads_and_lie_on_the_wing() {
    let asked = ["flight.duration_s=0.02", "flight.record_strips_every_s=0.004"];
    let run = fly(&asked);
    let (record, strips) = (&run.record, run.strips.unwrap());
    let count = 1 + strips.values("strip").unwrap().iter().fold(0.0_f64, |m, s| m.max(*s)) as usize;
    assert_eq!((count, strips.rows()), (12, 12 * 6));
    for instant in 0..6 {
        let whole = at(record, 4 * instant);
        let each: Vec<_> = (0..count).map(|i| at(&strips, instant * count + i)).collect();
        for source in LoadSource::STRIP.map(LoadSource::name) {
            for axis in ["x", "y", "z"] {
                let name = format!("force_{source}_{axis}");
                let sum: f64 = each.iter().map(|strip| strip(&name)).sum();
                assert!((sum - whole(&name)).abs() < 1e-14, "{name}: {sum} and {}", whole(&name));
            }
        }
        for (i, strip) in each.iter().enumerate() {
            assert_eq!(strip("t"), whole("t"));
            assert_eq!(strip("circulation"), whole(&format!("circulation_{i}")));
            assert_eq!(strip("incidence"), whole(&format!("incidence_{i}")));
            let reach = strip("quarter_chord_y").hypot(strip("quarter_chord_z"));
            assert!(reach < strip("arc").abs() + 0.02 && strip("width") > 0.0, "strip {i} at {reach}");
        }
        let width: f64 = each.iter().map(|strip| strip("width")).sum();
        assert!((width / (each[0]("arc") - each[count - 1]("arc")) - 1.0).abs() < 0.1, "{width}");
    }
    assert!(fly(&asked[..1]).strips.is_none());
}

#[test]
fn only_a_bound_circulation_is_called_one() {
    let columns = |lags: &str| {
        let lags = format!("aero.full.lags={lags}");
        let asked =
            ["aero.preset=full", &lags, "flight.duration_s=0.002", "flight.record_strips_every_s=0.001"];
        let strips = fly(&asked).strips.unwrap();
        ["circulation", "circulation_lag_sum"].map(|name| strips.column(name).is_some())
    };
    assert_eq!((columns("three"), columns("five")), ([false, true], [true, false]));
}

#[test]
fn strips_are_recorded_at_whole_records() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let refused = Scenario::load(&path, &["flight.record_strips_every_s=0.0015".into()]).err().unwrap();
    assert!(refused.to_string().contains("a whole number of records every 0.001 s"), "{refused}");
}

#[test]
fn means_begin_where_the_goal_says_or_halfway_through_a_short_flight() {
    let judged = fly(&["flight.duration_s=0.05"]).summary;
    assert_eq!((judged.roll_mean_deg, judged.pitch_half_amplitude_deg), (None, None));

    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/glide.toml");
    let scenario =
        Scenario::load(&path, &["flight.duration_s=0.05".into()]).unwrap_or_else(|e| panic!("{e}"));
    let run = scenario.fly(|_| ControlFlow::Continue(())).unwrap();
    let (t, pitch) = (run.record.values("t").unwrap(), run.record.values("pitch").unwrap());
    let late: Vec<f64> = t.iter().zip(pitch).filter(|(t, _)| **t >= 0.025).map(|(_, pitch)| *pitch).collect();
    let mean = late.iter().sum::<f64>() / late.len() as f64;
    assert!(late.len() > 1 && (run.summary.pitch_mean_deg.unwrap() - mean.to_degrees()).abs() < 1e-12);
    assert_eq!(run.summary.controller.updates, 0);
}

/// Rates of the shoulders, rad/s, as overrides.
fn shoulder_rates(rate: f64) -> [String; 2] {
    ["left", "right"].map(|side| format!("controller.input_rate_per_s.command_shoulder_{side}={rate}"))
}

#[test]
fn limited_rates_of_inputs_are_kept_throughout_a_flight() {
    let every_step = ["flight.duration_s=1.4", "flight.record_every_s=1e-4"];
    let flown = |rate: Option<f64>| {
        let rates = rate.map(shoulder_rates);
        let rates = rates.iter().flatten().map(String::as_str);
        fly(&every_step.into_iter().chain(rates).collect::<Vec<_>>())
    };
    let fastest = |run: &Run, name: &str| {
        let (t, u) = (run.record.values("t").unwrap(), run.record.values(name).unwrap());
        let rates = t.windows(2).zip(u.windows(2)).map(|(t, u)| ((u[1] - u[0]) / (t[1] - t[0])).abs());
        rates.fold(0.0, f64::max)
    };
    let (free, huge, slow) = (flown(None), flown(Some(1e6)), flown(Some(2.0)));
    for name in ["command_shoulder_left", "command_shoulder_right"] {
        assert!(fastest(&free, name) > 4.0, "{name}: {} rad/s without a limit", fastest(&free, name));
        assert!(fastest(&slow, name) < 2.0 * (1.0 + 1e-6), "{name}: {} rad/s", fastest(&slow, name));
        assert_eq!(free.record.values(name), huge.record.values(name));
    }
    assert_eq!(slow.summary.controller.failures, 0);
}

#[test]
fn rate_limits_that_cannot_be_kept_are_refused() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let refusal = |overrides: &[String]| Scenario::load(&path, overrides).err().unwrap().to_string();
    let mut jumping = shoulder_rates(2.0).to_vec();
    jumping.push("controller.continuous_input=false".into());
    assert!(refusal(&jumping).contains("continuous_input"), "{}", refusal(&jumping));
    assert!(refusal(&shoulder_rates(0.0)).contains("above 0"), "{}", refusal(&shoulder_rates(0.0)));
    let unknown = refusal(&["controller.input_rate_per_s.shoulder=1.0".into()]);
    assert!(unknown.contains("command_shoulder_left"), "{unknown}");
}

fn glider(keys: &[&str]) -> Result<Scenario, String> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/glider.toml");
    let keys: Vec<String> = ["flight.duration_s=0.5"].iter().chain(keys).map(|key| (*key).into()).collect();
    Scenario::load(&path, &keys).map_err(|error| error.to_string())
}

/// Rates and observation feel the same ground, and it bears the glider where it flies low; far away there is none.
#[test]
fn a_glider_feels_the_ground_in_rates_and_loads() {
    let fly = |keys: &[&str]| {
        let run = glider(keys).unwrap().fly(|_| ControlFlow::Continue(())).unwrap();
        let force = |source: &str| *run.record.values(&format!("force_{source}_z")).unwrap().last().unwrap();
        let sum: f64 = LoadSource::ALL.iter().map(|source| force(source.name())).sum();
        (run.summary, sum)
    };
    let (free, low, far) = (fly(&[]), fly(&["air.ground_m=-0.8"]), fly(&["air.ground_m=-1e4"]));
    assert!(low.1.abs() < 1e-11, "{}", low.1);
    let [free_m, low_m, far_m] = [&free, &low, &far].map(|(summary, _)| summary.altitude_change_m);
    assert!((free_m - far_m).abs() < 1e-8 && low_m > free_m + 1e-3, "{free_m} {far_m} {low_m}");
    assert_eq!((free.0.ground_distance_m, low.0.status), (None, Status::NotJudged));
    for plane in ["air.ground_m=-0.2", "air.ground_m=0.05"] {
        let through = fly(&[plane]).0;
        assert!(through.ground_distance_m.unwrap() < 0.0 && through.status == Status::Outside, "{plane}");
        assert!(through.warnings.iter().any(|warning| warning.id == "ground.near"), "{plane}");
    }
    assert!(far.0.warnings.iter().all(|warning| warning.id != "ground.near"));
    let gusty = fly(&["air.ground_m=-0.8", "air.gust_m_s=0.1"]).0.warnings;
    assert!(gusty.iter().any(|warning| warning.id == "flight.ground_gusts"));
}

#[test]
fn a_ground_that_is_not_felt_is_refused() {
    for key in ["aero.preset=\"paper\"", "air.ground_m=nan", "air.wind_m_s=[1.0, 0.0, 0.1]"] {
        let error = glider(&["air.ground_m=-0.8", key]).err();
        assert!(error.as_ref().is_some_and(|error| error.contains(": air.ground_m = ")), "{key}: {error:?}");
    }
    let reorientation = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/reorientation.toml");
    let error = Scenario::load(&reorientation, &["air.ground_m=-0.8".into()]).err().unwrap().to_string();
    assert!(error.contains("air.ground_m") && error.contains("vacuum"), "{error}");
    let bound = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/bounding_20g.toml");
    let bound = Scenario::load(&bound, &["air.ground_m=-0.8".into()]).unwrap();
    let error = bound.trim(&mut |_| ControlFlow::Continue(())).err().unwrap().to_string();
    assert!(error.contains("air.ground_m = -0.8"), "{error}");
}

/// The derivatives of the rates by all states, the height among them, are those of the values.
#[test]
fn the_ground_is_in_the_linearisation() {
    let scenario = glider(&["air.ground_m=-0.6"]).unwrap();
    let (robot, mut x) = (scenario.robot(), scenario.start());
    let air = robot.layout().aero;
    x[air..].iter_mut().enumerate().for_each(|(i, x)| *x = 0.3 * (1.7 * i as f64).sin());
    let u = vec![0.0; robot.inputs().len()];
    let n = x.len();
    let mut slopes = Linearisation::new(n, u.len());
    slopes.evaluate(robot, 0.0, &x, &u).unwrap();
    let rates = |k: usize, h: f64| {
        let (mut x, mut dx) = (x.clone(), vec![0.0; n]);
        x[k] += h;
        robot.rates_in_numbers(0.0, &x, &u, &mut dx).unwrap();
        dx
    };
    let height = robot.layout().position + 2;
    assert_eq!(robot.unfelt_states(), 0..2);
    for k in [height, robot.layout().attitude, robot.layout().velocity, n - 1] {
        let (plus, minus) = (rates(k, 1e-5), rates(k, -1e-5));
        let largest = (0..n).fold(0.0_f64, |most, i| {
            let difference = (plus[i] - minus[i]) / 2e-5;
            let exact: f64 = slopes.a[i * n + k];
            assert!(
                (exact - difference).abs() < 2e-5 * (1.0 + difference.abs()),
                "{i} by {k}: {exact} {difference}"
            );
            most.max(exact.abs())
        });
        assert!(largest > 1e-3, "{k}");
    }
}
