//! What the controllers of a sweep's flights share.

use super::chosen::{Chosen, Named};
use super::perch::PerchSpec;
use super::spec::{AeroSpec, AirSpec, FlightSpec, ScenarioSpec, StartSpec};
use super::{Scenario, written};
use serde::Serialize;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use wingbeat_flight::guide::{MpcSpec, PathSpec, Prepared, Turn};
use wingbeat_flight::simulate::SensorSpec;
use wingbeat_robot::RobotSpec;

/// Most that are kept: a sweep may draw what they are made from.
const KEPT: usize = 4;

/// What is being made, or made; none where there is nothing to share, or it cannot be made.
type Made = Arc<OnceLock<Option<Prepared>>>;

/// What was prepared, by all that it was made from; the latest last.
#[derive(Debug, Default)]
pub(super) struct Shared(Mutex<Vec<(String, Made)>>);

impl Shared {
    /// Gives `scenario` what its controller shares with others of the same model. Who comes first makes it, others wait.
    pub fn give(&self, scenario: &mut Scenario) {
        let Some(key) = what_a_controller_knows(&scenario.spec) else { return };
        let made = {
            let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            match all.iter().find(|(other, _)| *other == key) {
                Some((_, made)) => made.clone(),
                None => {
                    if all.len() == KEPT {
                        all.remove(0);
                    }
                    let made = Made::default();
                    all.push((key, made.clone()));
                    made
                }
            }
        };
        scenario.prepared = made.get_or_init(|| scenario.prepare()).clone();
    }
}

/// All that [`prepare`](wingbeat_flight::guide::ControllerSpec::prepare) can read: its model and its task.
#[derive(Serialize)]
struct MadeFrom<'a> {
    density_kg_m3: f64,
    wind_m_s: [f64; 3],
    phase_rad: f64,
    flapping: bool,
    robot: &'a RobotSpec,
    aero: &'a AeroSpec,
    controller: &'a Chosen<MpcSpec>,
    manoeuvre: &'a Option<Chosen<Turn>>,
    solver: &'a Option<Named>,
    sensors: &'a Option<SensorSpec>,
    path: &'a Option<PathSpec>,
    perch: &'a Option<PerchSpec>,
}

/// What the controller of `spec` is made from, as text; none without a controller. Every field of the tables is named, so that a new one
/// does not compile until it is said whether a controller knows of it.
pub fn what_a_controller_knows(spec: &ScenarioSpec) -> Option<String> {
    let ScenarioSpec {
        robot,
        air,
        aero,
        start,
        flight,
        controller,
        manoeuvre,
        solver,
        sensors,
        path,
        perch,
        // A controller is told neither what happens to the flight nor what is asked of it, nor what else the scenario is used for.
        name: _,
        seed: _,
        lattice: _,
        mismatch: _,
        goal: _,
        trim: _,
        plan: _,
        limits: _,
        paper: _,
    } = spec;
    let AirSpec { density_kg_m3, wind_m_s, ground_m: _, gust_m_s: _, gusts: _, dryden: _ } = air;
    let StartSpec {
        phase_rad,
        velocity_m_s: _,
        roll_deg: _,
        nose_up_deg: _,
        yaw_deg: _,
        rate_rad_s: _,
        states: _,
        commands: _,
    } = start;
    let FlightSpec {
        flapping,
        duration_s: _,
        step_s: _,
        error_m: _,
        inertance_s: _,
        record_every_s: _,
        record_strips_every_s: _,
    } = flight;
    let made_from = MadeFrom {
        density_kg_m3: *density_kg_m3,
        wind_m_s: *wind_m_s,
        phase_rad: *phase_rad,
        flapping: *flapping,
        controller: controller.as_ref()?,
        robot,
        aero,
        manoeuvre,
        solver,
        sensors,
        path,
        perch,
    };
    written::toml(&made_from).ok()
}
