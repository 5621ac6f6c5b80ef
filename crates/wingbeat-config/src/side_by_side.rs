//! Flights of several scenarios at once, in the lanes of vector registers.

use super::recorder::Recorder;
use super::{ConfigError, Scenario, Summary, written};
use std::ops::ControlFlow;
use wingbeat_flight::guide::HeldCommands;
use wingbeat_flight::simulate::{Controller, Flight, Sample, Seat, fly_side_by_side};
use wingbeat_math::{Double4, Lanes};
use wingbeat_robot::{BodySpec, Robot};

/// Most flights that are stepped at once.
pub(super) const MOST: usize = Double4::WIDTH;

/// The controller of one of them.
type Steering<'a> = Box<dyn Controller + 'a>;

impl Scenario {
    /// Whether the flight of `other` can be stepped beside this one: robot, model of the air and clock are the same but for
    /// the numbers of the body, the rate of the gait, `robot.numbers` and all that other tables say.
    pub(super) fn fits_beside(&self, other: &Self) -> bool {
        let clocks =
            [self, other].map(|s| (s.schedule.step.to_bits(), s.schedule.steps, s.spec.flight.flapping));
        // The claw latches within a step, which all lanes take whole.
        self.spec.perch.is_none()
            && other.spec.perch.is_none()
            && self.without_lattice().is_ok()
            && other.without_lattice().is_ok()
            && clocks[0] == clocks[1]
            && self.make() == other.make()
            && self.robot.fits_beside(&other.robot)
    }

    /// What has to be the same in all lanes; none where it cannot be told.
    fn make(&self) -> Option<[String; 2]> {
        let mut robot = self.spec.robot.clone();
        let BodySpec { mass_kg, com_m, inertia_kg_m2, drag_area_m2, .. } = &mut robot.body;
        (*mass_kg, *com_m, *inertia_kg_m2, *drag_area_m2) = (1.0, [0.0; 3], [1.0; 3], [0.0; 3]);
        robot.gait.set_frequency_hz(1.0);
        robot.numbers.values_mut().for_each(|number| *number = 0.0);
        Some([written::toml(&robot).ok()?, written::toml(self.spec.flown_aero()).ok()?])
    }

    /// Flies up to [`MOST`] scenarios that fit side by side; `watch` is asked at every sample and may stop them. The
    /// summaries say nothing of the error of the steps.
    pub(super) fn fly_side_by_side<'a>(
        all: &[&'a Self],
        watch: impl Fn() -> ControlFlow<()>,
    ) -> Result<Vec<Summary>, ConfigError> {
        let Some(first) = all.first() else { return Ok(Vec::new()) };
        let robots: Vec<_> = all.iter().map(|scenario| &scenario.robot).collect();
        let robot: Robot<Double4> = Robot::side_by_side(&robots).map_err(|error| first.explain(&error))?;
        let controller = |scenario: &&'a Self| -> Result<Steering<'a>, ConfigError> {
            let given = scenario.controller().map_err(|error| scenario.explain(&error))?;
            Ok(given.unwrap_or_else(|| Box::new(HeldCommands(scenario.held_commands()))))
        };
        let mut controllers = all.iter().map(controller).collect::<Result<Vec<_>, _>>()?;
        let mut sensors: Vec<_> = all.iter().map(|scenario| scenario.sensors()).collect();
        let starts: Vec<_> = all.iter().map(|scenario| scenario.start()).collect();
        let recorder = |(scenario, controller): (&&'a Self, &Steering<'a>)| {
            let rows = scenario.schedule.steps / scenario.schedule.steps_per_sample + 1;
            let recorder =
                Recorder::new(&scenario.robot, scenario.manoeuvre(), (controller, Vec::new()), rows, None);
            recorder.map_err(|error| scenario.explain(&error))
        };
        let mut recorders = all.iter().zip(&controllers).map(recorder).collect::<Result<Vec<_>, _>>()?;
        let watch = &watch;
        let seats = (all.iter().zip(&mut controllers).zip(&mut sensors).zip(&starts).zip(&mut recorders))
            .map(|((((scenario, controller), sensors), start), recorder)| Seat {
                plant: &scenario.robot,
                sensors,
                controller,
                schedule: &scenario.schedule,
                start,
                observe: move |sample: &Sample, controller: &Steering<'a>| {
                    recorder.sample(sample, controller)?;
                    Ok(watch())
                },
            })
            .collect();
        let flights = fly_side_by_side(|t, x, u, dx| robot.rates_side_by_side(t, x, u, dx), seats);
        let summary = |((scenario, recorder), flight): ((&&Self, Recorder), Flight)| {
            scenario.summarise(&recorder.finish(), &flight, &scenario.schedule, [None; 2], None)
        };
        Ok(all.iter().zip(recorders).zip(flights).map(summary).collect())
    }
}
