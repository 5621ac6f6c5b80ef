//! Flight by instruments: readings alone reach the controller, late and noisy, and the filter knows how well it knows.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::guide::Told as Known;
use wingbeat::math::{Quat, Vec3};
use wingbeat::plant::{Plant, Role};
use wingbeat::scenario::{Document, Scenario, ShownSample};
use wingbeat::simulate::{Controller, Estimator, Measurement, Reading, Record, SensorSpec, Stepper, Update};

const LEVEL: &str = "controller.orbit.legs=[]";
const PERIOD: f64 = 0.0075;

fn scenario(overrides: &[&str]) -> Scenario {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/estimator_20g.toml");
    let document = overrides.iter().fold(Document::file(&path).unwrap(), |d, text| d.set(*text));
    Scenario::new(document).unwrap_or_else(|error| panic!("{error}"))
}

/// What a controller was told at one update, and what it commanded then.
type Told = (f64, Vec<Reading>, Vec<f64>);

/// Notes what the controller within is told and what it says.
struct Overheard<'a> {
    own: Box<dyn Controller + 'a>,
    inputs: usize,
    told: RefCell<Vec<Told>>,
}

impl Controller for Overheard<'_> {
    fn update(&mut self, t: f64, measurement: &Measurement) -> Update {
        assert!(measurement.channels().is_empty() && measurement.values().is_empty());
        assert_eq!((measurement.value(Role::Position(2)), measurement.attitude()), (None, None));
        let update = self.own.update(t, measurement);
        let mut u = vec![0.0; self.inputs];
        self.own.input(t, &mut u);
        self.told.get_mut().push((t, measurement.readings().to_vec(), u));
        update
    }
    fn input(&self, t: f64, u: &mut [f64]) {
        self.own.input(t, u);
    }
}

fn overheard(scenario: &Scenario) -> (Vec<Told>, wingbeat::scenario::Run) {
    let own = scenario.controller().unwrap().unwrap();
    let mut overheard =
        Overheard { own, inputs: scenario.robot().inputs().len(), told: RefCell::new(Vec::new()) };
    let run =
        scenario.fly_with(&mut overheard, PERIOD, scenario.sensors(), |_| ControlFlow::Continue(())).unwrap();
    (overheard.told.into_inner(), run)
}

#[test]
fn nothing_but_readings_reaches_the_controller() {
    // The robot that flies is another one than that of the model, in gusts.
    let flown = scenario(&[
        LEVEL,
        "flight.duration_s=0.45",
        "air.gust_m_s=0.3",
        "mismatch.density=0.95",
        "mismatch.com_y_m=0.001",
    ]);
    let (told, _) = overheard(&flown);
    // A controller that has never seen that flight says the same by the same readings, to the bit.
    let nominal = scenario(&[LEVEL]);
    let mut own = nominal.controller().unwrap().unwrap();
    for (t, readings, commands) in &told {
        own.update(*t, &Measurement::of_instruments(*t, readings));
        let mut u = vec![0.0; commands.len()];
        own.input(*t, &mut u);
        assert_eq!(&u, commands, "at {t} s");
    }
    assert!(told.len() == 60 && told.iter().map(|(_, readings, _)| readings.len()).sum::<usize>() > 1000);
}

/// A controller is told states by name: what it lacks of the air follows its own model, to the truth where that is the model, and
/// where it lacks nothing it is told the truth to the bit.
#[test]
fn an_air_that_nobody_tells_follows_the_model() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn_short.toml");
    let turn = |overrides: &[&str]| {
        let document = Document::file(&path).unwrap().set("flight.duration_s=0.2");
        Scenario::new(overrides.iter().fold(document, |d, text| d.set(*text))).unwrap()
    };
    let own = turn(&[]);
    let fly = |scenario: &Scenario| scenario.fly(|_| ControlFlow::Continue(())).unwrap();
    let air = Document::value("air", &own.spec.aero).unwrap();
    let document = Document::file(&path).unwrap().set("flight.duration_s=0.2");
    let told = fly(&Scenario::new(document.put("mismatch.aero", air).unwrap()).unwrap());
    let alike = fly(&own);
    for (a, b) in alike.record.columns().iter().zip(told.record.columns()) {
        assert!(a.name == b.name && a.values == b.values, "{}", a.name);
    }
    let (robot, aero) = (own.model(), own.model().layout().aero);
    let (mut stepper, mut estimator) = (Stepper::new(robot, 0.0, &own.start()), Known::new(robot));
    let mut x = vec![0.0; robot.states().len()];
    let u = vec![0.0; robot.inputs().len()];
    for update in 0..=40 {
        let t = 5e-3 * f64::from(update);
        let known = Measurement::new(t, &robot.states()[..aero], &stepper.state()[..aero]);
        estimator.estimate(t, &known, &u, &mut x).unwrap();
        assert_eq!(x[..aero], stepper.state()[..aero]);
        (0..50).for_each(|_| stepper.step(1e-4).unwrap());
        stepper.set_time(5e-3 * f64::from(update + 1));
    }
    let last = Measurement::new(0.205, &robot.states()[..aero], &stepper.state()[..aero]);
    estimator.estimate(0.205, &last, &u, &mut x).unwrap();
    let air = &stepper.state()[aero..];
    let largest = air.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (i, (estimated, true_)) in x[aero..].iter().zip(air).enumerate() {
        assert!((estimated - true_).abs() < 1e-6 * largest, "{i}: {estimated} {true_}");
    }
    // Another air: the paper's lifting line plans, the strips with separation fly.
    let other = turn(&["mismatch.aero={preset='full', law='lev'}", "flight.duration_s=1.0"]);
    let run = fly(&other);
    assert!(other.robot().states().len() != other.model().states().len());
    assert!(run.summary.completed() && run.summary.aero_preset == "full" && run.summary.lift_law == "lev");
    // States of the same names in another place: those of 16 strips are not told to a model of 9.
    let strips = |n: usize| turn(&["aero.preset=full", "aero.law=stall", &format!("aero.full.strips={n}")]);
    let (few, many) = (strips(9), strips(16));
    let (states, mut waving) = (many.robot().states(), many.start());
    let first = few.model().layout().aero;
    waving[first..].iter_mut().enumerate().for_each(|(i, x)| *x = 1.0 + i as f64);
    let mut of_few = vec![0.0; few.model().states().len()];
    Known::new(few.model()).estimate(0.0, &Measurement::new(0.0, states, &waving), &u, &mut of_few).unwrap();
    assert_eq!(of_few[..first], waving[..first]);
    assert!(of_few[first..].iter().all(|x| *x == 0.0));
    let start = own.start();
    let untold = Measurement::new(0.0, &robot.states()[..aero - 1], &start[..aero - 1]);
    let refused = Known::new(robot).estimate(0.0, &untold, &u, &mut x).unwrap_err();
    assert!(refused.to_string().contains("are measured"), "{refused}");
}

#[test]
fn readings_are_the_truth_when_they_were_taken_and_come_late() {
    let still = [
        LEVEL,
        "flight.duration_s=0.3",
        "sensors.imu={place_m=[0.0, 0.0, 0.0], every_s=5e-3, delay_s=4e-3}",
        "sensors.height={every_s=20e-3, delay_s=31e-3}",
        "sensors.airspeed={every_s=10e-3}",
    ];
    let flown = scenario(&still);
    let instruments = flown.spec.sensors.as_ref().map(SensorSpec::instruments).unwrap();
    let (told, run) = overheard(&flown);
    let column = |name: &str| run.record.values(name).unwrap();
    let (mut seen, every) = ([0; 3], 1e-3);
    for (t, readings, _) in &told {
        for reading in readings {
            let (instrument, row) =
                (&instruments[reading.instrument], (reading.taken / every).round() as usize);
            let late = t - reading.taken;
            assert!(late > instrument.delay - 1e-9 && late < instrument.delay + PERIOD + 1e-9, "{late}");
            let truth = match instrument.quantity.name {
                "rate_x" => column("w_WB_B_x")[row],
                "rate_y" => column("w_WB_B_y")[row],
                "rate_z" => column("w_WB_B_z")[row],
                "height" => column("p_WB_z")[row],
                _ => continue,
            };
            assert_eq!(reading.value, truth);
            seen[usize::from(instrument.quantity.name == "height")] += 1;
        }
    }
    assert!(seen[0] > 150 && seen[1] >= 13, "{seen:?}");
}

#[test]
fn the_filter_knows_how_well_it_knows() {
    let run = scenario(&["flight.duration_s=4.0"]).fly(|_| ControlFlow::Continue(())).unwrap();
    let estimate = run.summary.estimate.unwrap();
    assert!(estimate.within_3_sigma > 0.98 && estimate.normalised_square < 2.0, "{estimate:?}");
    assert!(estimate.height_rms_m < 0.01 && estimate.roll_rms_deg < 0.5, "{estimate:?}");
    assert!(estimate.innovation_square.iter().all(|square| *square > 0.3 && *square < 1.5), "{estimate:?}");
    assert!(run.summary.height_max_error_m.unwrap() < 0.04);
    assert_eq!(run.summary.controller.failures, 0);
}

/// Errors of an angle, deg: root mean square of the true one less that asked, at the updates from `from` s on.
fn true_rms_deg(run: &wingbeat::scenario::Run, angle: &str, from: f64) -> f64 {
    let column = |name: &str| run.record.values(name).unwrap();
    let (t, asked) = (column("t"), column(&format!("orbit_{angle}_asked")));
    // None at the end, which nothing follows.
    let updated = |k: &usize| {
        let number = t[*k] / PERIOD;
        t[*k] >= from && k + 1 < t.len() && (number - number.round()).abs() < 1e-6
    };
    let squares: Vec<f64> =
        (0..t.len()).filter(updated).map(|k| (column(angle)[k] - asked[k]).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt().to_degrees()
}

/// In gusts that the filter takes for rotations the controller believes that it turns, and does not.
#[test]
fn a_flight_is_judged_by_the_truth_and_not_by_what_its_controller_believes() {
    let lost = scenario(&["flight.duration_s=5.0", "air.gust_m_s=1.5"]);
    let run = lost.fly(|_| ControlFlow::Continue(())).unwrap();
    let (told, own) = (run.summary.roll_rms_error_deg.unwrap(), true_rms_deg(&run, "roll", 2.0));
    // Those that fall on a record, every second one.
    assert!((told / own - 1.0).abs() < 0.01 && own > 5.0, "{told} deg told, {own} are");
    let warned = run.summary.warnings.iter().any(|w| w.id == "flight.estimate_normalised_square");
    assert!(warned && run.summary.estimate.as_ref().unwrap().normalised_square > 4.0);
}

/// A place that is told 100 mm beside where the robot is does not put it there.
#[test]
fn noise_of_the_sensors_is_no_error_of_the_flight() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/bank15_20g.toml");
    let document = Document::file(&path).unwrap().set("flight.duration_s=3.0").set("sensors.position_m=0.1");
    let run = Scenario::new(document).unwrap().fly(|_| ControlFlow::Continue(())).unwrap();
    let largest =
        |name: &str| run.record.values(name).unwrap().iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let (told, believed) = (run.summary.height_max_error_m.unwrap(), largest("orbit_height_error"));
    assert!(believed > 0.25 && told < 0.15, "{told} m told, {believed} m believed");
}

/// Perfect sensors are no other way: the true motion at the updates, each counted once.
#[test]
fn a_flight_with_perfect_sensors_is_judged_as_any_other() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/bank15_20g.toml");
    // A whole number of updates, and none at the end; the second half counts.
    let document = Document::file(&path).unwrap().set("flight.duration_s=3.0");
    let run = Scenario::new(document).unwrap().fly(|_| ControlFlow::Continue(())).unwrap();
    let controller = &run.summary.controller;
    assert_eq!((controller.period_s, controller.updates), (Some(PERIOD), 400));
    // What it found at each stands in the first record from there on.
    let column = |name: &str| run.record.values(name).unwrap();
    let found = |name: &str, number: usize| {
        column(name)[column("t").partition_point(|t| *t < number as f64 * PERIOD - 1e-9)].to_degrees()
    };
    let squares: f64 = (200..400).map(|number| found("orbit_roll_error", number).powi(2)).sum();
    let (told, own) = (run.summary.roll_rms_error_deg.unwrap(), (squares / 200.0).sqrt());
    assert!((told / own - 1.0).abs() < 1e-6 && own > 0.1, "{told} deg told, {own} are");
    let most = (200..400).map(|number| found("orbit_pitch_error", number).abs()).fold(0.0, f64::max);
    let told = run.summary.pitch_max_error_deg.unwrap();
    assert!((told / most - 1.0).abs() < 1e-4, "{told} deg told, {most} are");
}

#[test]
fn without_the_airspeed_the_filter_flies_by_its_model() {
    let mut scenario = scenario(&[]);
    let sensors = scenario.spec.sensors.as_mut().unwrap();
    sensors.airspeed = None;
    let run = scenario.fly(|_| ControlFlow::Continue(())).unwrap();
    let estimate = run.summary.estimate.as_ref().unwrap();
    assert_eq!(estimate.innovation_square.len(), 3);
    assert!(run.record.values("estimate_innovation_airspeed").is_none());
    assert!(run.record.values("estimate_bias_airspeed").is_none());
    assert!(estimate.height_rms_m < 0.015 && estimate.roll_rms_deg < 1.0, "{estimate:?}");
    assert!(run.summary.completed() && run.summary.height_max_error_m.unwrap() < 0.06);
}

#[test]
fn what_no_instrument_tells_is_refused_by_its_name_with_the_sensor_that_would() {
    let refused = |sensors: SensorSpec| {
        let mut scenario = scenario(&[LEVEL]);
        scenario.spec.sensors = Some(sensors);
        scenario.controller().err().map_or_else(|| panic!("taken"), |error| error.to_string())
    };
    let all = scenario(&[]).spec.sensors.unwrap();
    let message = refused(SensorSpec { height: None, ..all.clone() });
    assert!(message.contains("do not tell height:") || message.contains("do not tell height;"), "{message}");
    assert!(message.contains("[sensors.height]") && !message.contains("[sensors.airspeed]"), "{message}");
    let message = refused(SensorSpec { imu: None, ..all.clone() });
    assert!(message.contains("roll") && message.contains("leftward"), "{message}");
    assert!(message.contains("[sensors.imu]"), "{message}");
    let message = refused(SensorSpec { imu: None, height: None, ..all });
    assert!(message.contains("height") && message.contains("roll"), "{message}");
}

#[test]
fn the_same_seed_reads_the_same_and_another_does_not() {
    let told = |seed: &str| overheard(&scenario(&[LEVEL, "flight.duration_s=0.06", seed])).0;
    assert_eq!(told("seed=3"), told("seed=3"));
    assert_ne!(told("seed=3"), told("seed=4"));
}

#[test]
fn what_the_filter_cannot_be_made_of_is_refused() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/estimator_20g.toml");
    let refused = |text: &str| {
        let document = Document::file(&path).unwrap().set(text);
        Scenario::new(document).err().unwrap_or_else(|| panic!("{text} is taken")).to_string()
    };
    for (text, key, allowed) in [
        ("sensors.imu.every_s=1.1e-3", "sensors.imu.every_s", "whole number of steps"),
        ("sensors.height.delay_s=-1.0", "sensors.height.delay_s", "0 to 1"),
        ("sensors.position_m=0.1", "sensors.position_m", "0 beside instruments"),
        ("sensors={}", "controller.orbit.estimator", "sensors.imu"),
        ("controller.orbit.estimator.missed_s=0.0", "controller.orbit.estimator.missed_s", "above 0"),
    ] {
        let message = refused(text);
        assert!(message.contains(key) && message.contains(allowed), "{text}: {message}");
    }
}

/// A flight without gusts in records every 2.5 ms, and its column of a name.
fn flown_with(overrides: &[&str]) -> wingbeat::scenario::Run {
    let always = [LEVEL, "flight.duration_s=1.5", "flight.record_every_s=0.0025"];
    scenario(&[&always, overrides].concat()).fly(|_| ControlFlow::Continue(())).unwrap()
}

/// Mean and standard deviation.
fn spread(errors: &[f64]) -> [f64; 2] {
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    [mean, (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()]
}

/// Without noise a reading is the truth of the time at which it was taken, held until the next arrives; an offset is constant, and
/// noise has its deviation and no mean.
#[test]
fn the_record_has_what_each_instrument_read() {
    let exact = ["rate_rad_s", "rate_bias_rad_s", "force_m_s2", "force_bias_m_s2"]
        .map(|key| format!("sensors.imu.{key}=0"));
    let exact: Vec<&str> = exact
        .iter()
        .map(String::as_str)
        .chain([
            "sensors.height.height_m=0",
            "sensors.height.bias_m=0",
            "sensors.airspeed.speed_m_s=0",
            "sensors.airspeed.bias_m_s=0",
        ])
        .collect();
    let run = flown_with(&exact);
    let column = |name: &str| run.record.values(name).unwrap_or_else(|| panic!("{name}"));
    // Both come 5 ms late, two records.
    for k in 2..column("t").len() {
        for axis in ["x", "y", "z"] {
            let (read, truth) =
                (column(&format!("reading_imu_rate_{axis}"))[k], column(&format!("w_WB_B_{axis}"))[k - 2]);
            assert!((read - truth).abs() < 1e-12, "{axis}, record {k}: {read} read, {truth} is");
        }
        // Taken every 8 records.
        let truth = column("p_WB_z")[(k - 2) / 8 * 8];
        assert!((column("reading_height")[k] - truth).abs() < 1e-12, "record {k}");
    }
    // Before the first arrives, that one.
    assert_eq!(column("reading_height")[..2], [column("p_WB_z")[0]; 2]);
    // Body x of a tube ahead of the origin feels no rate: e_x . R'(v - wind) in still air.
    let quat = ["quat_w", "quat_x", "quat_y", "quat_z"].map(column);
    let velocity = ["v_WB_W_x", "v_WB_W_y", "v_WB_W_z"].map(column);
    for k in 2..column("t").len() {
        let taken = (k - 2) / 8 * 8;
        let attitude = Quat::from_wxyz(&quat.map(|part| part[taken])).matrix();
        let truth = attitude.transpose_mul(Vec3(velocity.map(|part| part[taken])))[0];
        let read = column("reading_airspeed")[k];
        assert!((read - truth).abs() < 1e-12, "record {k}: {read} m/s read, {truth} are");
    }
    let of = |name: &str| run.record.column(name).map(|c| [c.unit.clone(), c.frame.clone()]);
    assert_eq!(of("reading_imu_force_x"), Some(["m/s2", "B"].map(String::from)));
    assert_eq!(of("reading_airspeed"), Some(["m/s", "B"].map(String::from)));
    // The same with an offset alone, then with noise alone.
    let errors = |run: &wingbeat::scenario::Run, every: usize| -> Vec<f64> {
        let column = |name: &str| run.record.values(name).unwrap();
        let taken = (2..column("t").len()).filter(|k| (k - 2) % every == 0);
        taken.map(|k| column("reading_imu_rate_x")[k] - column("w_WB_B_x")[k - 2]).collect()
    };
    let [mean, deviation] = spread(&errors(&flown_with(&["sensors.imu.rate_rad_s=0"]), 1));
    assert!(
        deviation < 1e-12 && mean.abs() > 1e-4 && mean.abs() < 4.0 * 0.02,
        "offset {mean}, {deviation} about it"
    );
    let noise = errors(&flown_with(&["sensors.imu.rate_bias_rad_s=0"]), 1);
    let ([mean, deviation], n) = (spread(&noise), noise.len() as f64);
    assert!(mean.abs() < 3.0 * 0.02 / n.sqrt(), "mean {mean} of {n}");
    // The standard error of a deviation is 1/sqrt(2 (n - 1)) of it.
    assert!((deviation / 0.02 - 1.0).abs() < 3.0 / (2.0 * (n - 1.0)).sqrt(), "deviation {deviation} of {n}");
}

#[test]
fn the_record_has_what_a_controller_was_told_of_the_states_that_have_noise() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/bank15_20g.toml");
    let fly = |overrides: &[&str]| {
        let always = ["flight.duration_s=3.0", "flight.record_every_s=0.0025"];
        let document = Document::file(&path).unwrap();
        let document = always.iter().chain(overrides).fold(document, |d, text| d.set(*text));
        Scenario::new(document).unwrap().fly(|_| ControlFlow::Continue(())).unwrap()
    };
    let names = |run: &wingbeat::scenario::Run| -> Vec<String> {
        let names = run.record.columns().iter().map(|column| column.name.clone());
        names.filter(|name| name.starts_with("reading_")).collect()
    };
    let perfect = fly(&[]);
    assert_eq!(names(&perfect), [""; 0]);
    let noisy = fly(&["sensors.position_m=0.002"]);
    assert_eq!(names(&noisy), ["reading_p_WB_x", "reading_p_WB_y", "reading_p_WB_z"]);
    assert_eq!(noisy.record.columns().len(), perfect.record.columns().len() + 3);
    let column = |name: &str| noisy.record.values(name).unwrap();
    // An update every third record, of which the last has none.
    let updates = (column("t").len() - 1) / 3;
    let errors: Vec<f64> =
        (0..3 * updates).step_by(3).map(|k| column("reading_p_WB_z")[k] - column("p_WB_z")[k]).collect();
    let ([mean, deviation], n) = (spread(&errors), updates as f64);
    assert!(mean.abs() < 3.0 * 0.002 / n.sqrt(), "mean {mean} of {n}");
    assert!((deviation / 0.002 - 1.0).abs() < 3.0 / (2.0 * (n - 1.0)).sqrt(), "deviation {deviation} of {n}");
    assert!((0..3 * updates).all(|k| column("reading_p_WB_z")[k] == column("reading_p_WB_z")[k / 3 * 3]));
    // Late, and without noise: the truth of the update before.
    let late = fly(&["sensors.delay_updates=1", "flight.duration_s=0.3"]);
    let column = |name: &str| late.record.values(name).unwrap();
    assert!((3..120).all(|k| column("reading_v_WB_W_x")[k] == column("v_WB_W_x")[k / 3 * 3 - 3]));
}

/// The record that a page shows while a flight goes on has the readings of the record that it ends with.
#[test]
fn a_watched_flight_has_the_readings_of_its_record() {
    let flown = scenario(&[LEVEL, "flight.duration_s=0.1"]);
    let mut watched = flown.watched().unwrap();
    let run = flown
        .fly(|sample| {
            watched.add(&ShownSample::of(sample)).unwrap();
            ControlFlow::Continue(())
        })
        .unwrap();
    let names = |record: &Record| -> Vec<String> {
        let all = record.columns().iter().map(|column| column.name.clone());
        all.filter(|name| name.starts_with("reading_")).collect()
    };
    let read = names(&run.record);
    assert!(read.len() > 6 && names(watched.record()) == read, "{read:?}");
    assert!(read.iter().all(|name| watched.record().values(name) == run.record.values(name)));
}
