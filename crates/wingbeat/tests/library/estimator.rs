//! Flight by instruments: readings alone reach the controller, late and noisy, and the filter knows how well it knows.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::plant::{Plant, Role};
use wingbeat::scenario::{Document, Scenario};
use wingbeat::simulate::{Controller, Measurement, Quantity, Reading, SensorSpec, Update};

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
            let truth = match instrument.quantity {
                Quantity::Rate(axis) => column(["w_WB_B_x", "w_WB_B_y", "w_WB_B_z"][axis])[row],
                Quantity::Height => column("p_WB_z")[row],
                Quantity::Force(_) | Quantity::Airspeed => continue,
            };
            assert_eq!(reading.value, truth);
            seen[usize::from(instrument.quantity == Quantity::Height)] += 1;
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
