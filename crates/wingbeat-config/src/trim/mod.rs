//! Periodic flights: an orbit of the scenario's robot, how it holds, and a scenario that flies it.

pub(crate) mod alone;
mod family;
pub(crate) mod search;
mod spec;
mod summary;
mod verdict;

pub use alone::{AloneSummary, RobotTrim, Tried, TurnSummary};
pub use search::{
    Ended, GaitSearch, Goal, LimitsSpec, SearchProgress, SearchSpec, SearchSummary, Searched, VarySpec,
};
pub use spec::{FamilySpec, TrimSpec};
pub use summary::{Multiplier, TrimSummary};
use verdict::said_of;

use super::recorder::{Recorded, Recorder};
use super::{ConfigError, Scenario, ScenarioSpec, StartSpec, plausible};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};
use wingbeat_flight::guide::{HeldCommands, OrbitWeights, gains_of, holding_inputs};
use wingbeat_flight::orbit::{
    Course, Cycle, Failure, FoundOrbit, Free, Interval, Modes, Orbit, Point, Sector, floquet, floquet_over,
    intervals_along, measure, search, search_from,
};
use wingbeat_flight::simulate::{Column, Record, Sample};
use wingbeat_math::Error;
use wingbeat_math::order::filled;
use wingbeat_math::{Quat, Vec3};
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_robot::BeyondLoads;

/// Largest step of the bank from orbit to orbit on the way to a turn, deg.
const BANK_STEP_DEG: f64 = 3.0;
/// Most iterations of Newton's method for the orbit asked, all its starts and steps of bank together. *Choice*: one
/// start of straight flight takes 120 at most.
const MOST_ITERATIONS: usize = 200;

/// A trimmed flight.
#[derive(Clone, Debug)]
pub struct Trimmed {
    /// One cycle, a row per step.
    pub record: Option<Record>,
    /// Multipliers, a row each.
    pub multipliers: Option<Record>,
    /// The family, a row per orbit.
    pub family: Option<Record>,
    /// The starts of a search of gaits, a row each.
    pub starts: Option<Record>,
    /// Numbers.
    pub summary: TrimSummary,
    /// The scenario that flies the orbit, and of a search the robot, by file name.
    pub files: Vec<(&'static str, String)>,
}

/// What a trim tells on the way.
#[derive(Clone, Copy, Debug)]
pub enum TrimProgress {
    /// Of a search of gaits.
    Search(SearchProgress),
    /// Of an orbit.
    Orbit {
        /// Orbits found before.
        orbits: usize,
        /// Iteration of Newton's method, from 1.
        iteration: usize,
        /// Largest condition missed, in its own SI unit.
        residual: f64,
    },
    /// Of a turn that is flown.
    Turn {
        /// Number of the flight, from 1.
        flight: usize,
    },
}

impl Trimmed {
    /// That nothing was found.
    fn nothing(summary: TrimSummary) -> Self {
        Self { record: None, multipliers: None, family: None, starts: None, summary, files: Vec::new() }
    }
}

impl Scenario {
    /// Finds the orbit that the scenario's `[trim]` asks for, of the robot as the controller knows it; with `[trim.search]`
    /// that of the best gait. `observe` sees the search and may stop it.
    ///
    /// # Errors
    /// No `[trim]`, or a setting that is out of range, with its place.
    pub fn trim(
        &self,
        observe: &mut dyn FnMut(TrimProgress) -> ControlFlow<()>,
    ) -> Result<Trimmed, ConfigError> {
        self.without_lattice().map_err(|error| self.explain(&error))?;
        let Some(search) = self.gait_search()? else {
            return self.trim_orbit(observe).map_err(|error| self.explain(&error));
        };
        let started = Instant::now();
        let nothing_kept = &mut |_: &[f64]| Ok::<(), ConfigError>(());
        let tell = &mut |at| observe(TrimProgress::Search(at));
        match search.all(Vec::new(), nothing_kept, tell)? {
            Some(searched) => searched.trim(observe),
            None => {
                let asked = self
                    .cycle()
                    .and_then(|cycle| Ok(self.asked(&cycle, self.trim_spec()?, started.elapsed())));
                let mut summary = asked.map_err(|error| self.explain(&error))?;
                summary.reason = Some(Failure::Stopped.to_string());
                Ok(Trimmed::nothing(summary))
            }
        }
    }

    /// The same without any search of gaits.
    fn trim_orbit(&self, observe: &mut dyn FnMut(TrimProgress) -> ControlFlow<()>) -> Result<Trimmed, Error> {
        let spec = self.trim_spec()?;
        self.in_still_air()?;
        let cycle = self.cycle()?;
        let family = spec.family.as_ref().map(|family| self.family(spec, family)).transpose()?;
        let mut orbits = 0;
        let started = Instant::now();
        let mut tell = |iteration: usize, residual: f64| {
            if iteration == 1 {
                orbits += 1;
            }
            observe(TrimProgress::Orbit { orbits: orbits - 1, iteration, residual })
        };
        let found = self.find_orbit(&cycle, &mut tell)?;
        let search = started.elapsed();
        let mut summary = self.asked(&cycle, spec, search);
        let inputs = holding_inputs(&cycle);
        let (found, measured) = match found.and_then(|found| {
            let areas = self.strip_areas();
            let measures = measure(&cycle, &found.orbit, &areas)?;
            let (modes, all) = modes_and_intervals(&cycle, &found.orbit, &inputs)?;
            Ok((found, (measures, modes, all)))
        }) {
            Ok(both) => both,
            Err(failure) => {
                let broke = matches!(&failure, Failure::Fault(_));
                let shorter =
                    broke.then(|| plausible::of_short_periods(cycle.robot(), "a shorter trim.step_s"));
                let mend = if broke {
                    ""
                } else {
                    "; `wingbeat trim ROBOT.toml` finds speed, frequency and gait by itself"
                };
                summary.reason = Some(format!("{failure}{}{mend}", shorter.unwrap_or_default()));
                return Ok(Trimmed::nothing(summary));
            }
        };
        let (measures, modes, all) = measured;
        summary.found(&cycle, &found, &measures, &modes);
        let broken = |fault: Fault| Error::invalid("trim", fault, "an orbit that can be observed");
        let gains = gains_of(&cycle, &found.orbit, &inputs, &all, &OrbitWeights::default());
        summary.held_multiplier = gains.as_ref().map(|held| held.multiplier);
        let Recorded { record, means, .. } = self.cycle_record(&cycle, &found.orbit)?.map_err(broken)?;
        summary.spar = means.as_ref().and_then(|means| means.spar);
        summary.pin_springs = means.as_ref().and_then(|means| means.pin_springs);
        summary.judge(cycle.robot(), &self.spec, &self.limits, means.as_ref());
        summary.warnings.extend(self.in_vain());
        let family =
            family.map(|family| self.follow(&family, &found, &mut tell, &mut summary)).transpose()?;
        let gains = gains.map(|held| ("gains.csv", held.table));
        Ok(Trimmed {
            record: Some(record),
            multipliers: Some(multipliers(&modes, cycle.section().names())?),
            family,
            starts: None,
            files: vec![("orbit.toml", self.orbit_scenario(&cycle, &found.orbit)?)]
                .into_iter()
                .chain(gains)
                .collect(),
            summary,
        })
    }

    fn in_still_air(&self) -> Result<(), Error> {
        self.spec.without_ground("a periodic flight")?;
        if self.model.mean_wind().norm() > 0.0 {
            let allowed = "still air: speeds are those over the ground";
            return Err(Error::invalid("air.wind_m_s", format!("{:?}", self.spec.air.wind_m_s), allowed));
        }
        Ok(())
    }

    /// What `[trim]` asks.
    fn trim_spec(&self) -> Result<&TrimSpec, Error> {
        self.spec
            .trim
            .as_ref()
            .ok_or_else(|| Error::invalid("trim", "none", "a [trim], which `wingbeat new trim` writes"))
    }

    /// A cycle of the robot as the controller knows it, in the steps of `[trim]`.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there is no `[trim]`, or the robot has no cycle.
    pub fn cycle(&self) -> Result<Cycle<'_>, Error> {
        let gait = format!("robot.gait.{}", self.spec.robot.gait.kind());
        Cycle::new(&self.model, self.trim_spec()?.step_s).map_err(|e| e.renamed(&[("gait", gait)]))
    }

    /// The orbit that `[trim]` asks for, a turn by way of straight flight. `tell` hears iteration and residual (in SI units) and may
    /// stop the search.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there is no `[trim]`, or it frees what there is not.
    pub fn find_orbit(
        &self,
        cycle: &Cycle,
        tell: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
    ) -> Result<Result<FoundOrbit, Failure>, Error> {
        let mut taken = 0;
        let mut counted = |iteration: usize, residual: f64| {
            taken += 1;
            if taken > MOST_ITERATIONS { ControlFlow::Break(()) } else { tell(iteration, residual) }
        };
        let found = self.find_within(cycle, &mut counted)?;
        let exhausted = taken > MOST_ITERATIONS;
        Ok(found.map_err(|failure| match failure {
            Failure::Stopped if exhausted => Failure::Exhausted(MOST_ITERATIONS),
            other => other,
        }))
    }

    /// The same with as many iterations as `tell` lets it have.
    fn find_within(
        &self,
        cycle: &Cycle,
        tell: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
    ) -> Result<Result<FoundOrbit, Failure>, Error> {
        let spec = self.trim_spec()?;
        let guess = self.guess(cycle);
        let course = spec.course();
        if !course.turns() {
            let free = spec.free(&self.model, cycle.coupled(&course))?;
            return Ok(search(cycle, &course, &free, guess, tell));
        }
        let straight = Course { bank: 0.0, ..course };
        let level = spec.free(&self.model, cycle.coupled(&straight))?;
        let free = spec.free(&self.model, true)?;
        if let Ok(found) = search_from(cycle, &course, &free, guess.clone(), tell) {
            return Ok(Ok(found));
        }
        let found = search(cycle, &straight, &level, guess, tell);
        let steps = (spec.bank_deg.abs() / BANK_STEP_DEG).ceil().max(1.0) as usize;
        Ok(found.and_then(|mut found| {
            for k in 1..=steps {
                let bank_deg = spec.bank_deg * k as f64 / steps as f64;
                let course = TrimSpec { bank_deg, ..spec.clone() }.course();
                found = search_from(cycle, &course, &free, found.orbit.point, tell)?;
            }
            Ok(found)
        }))
    }

    /// The scenario's start as a point of the section.
    fn guess(&self, cycle: &Cycle) -> Point {
        let x = self.start_of(&self.model);
        let mut z = vec![0.0; cycle.section().len()];
        cycle.section().coordinates(&x, &mut z);
        Point { z, pace: 1.0, inputs: self.held_commands() }
    }

    /// Areas of the strips of all surfaces, m2; 0 in gaps.
    fn strip_areas(&self) -> Vec<f64> {
        let outlines = self.spec.robot.outlines().unwrap_or_default();
        let of = |((_, aero), outline): ((&str, &wingbeat_aero::Aero), wingbeat_robot::SurfaceOutline)| {
            let strips = aero.strip_arcs().iter().zip(aero.widths()).enumerate();
            let area = |(i, (arc, width)): (usize, (&f64, &f64))| {
                if aero.covers(i) { outline.planform.chord(*arc) * width } else { 0.0 }
            };
            strips.map(area).collect::<Vec<_>>()
        };
        self.model.surfaces().zip(outlines).flat_map(of).collect()
    }

    /// The summary of what is asked.
    fn asked(&self, cycle: &Cycle, spec: &TrimSpec, search: Duration) -> TrimSummary {
        TrimSummary {
            warnings: said_of(&self.spec, &self.model).chain(self.in_vain()).collect(),
            speed_m_s: spec.speed_m_s,
            climb_m_s: spec.climb_m_s,
            bank_deg: spec.bank_deg,
            yaw_rate_rad_s: spec.course().yaw_rate(),
            steps: cycle.steps(),
            search_s: search.as_secs_f64(),
            aero_preset: self.named(&self.model, self.spec.aero.preset.name(), |aero| aero.preset().name()),
            lift_law: self.named(&self.model, self.spec.aero.law.name(), |aero| aero.law().name()),
            ..TrimSummary::default()
        }
    }

    /// One cycle as `fly` records it, at every step.
    fn cycle_record(&self, cycle: &Cycle, orbit: &Orbit) -> Result<Result<Recorded, Fault>, Error> {
        let robot = self.model.paced(orbit.point.pace);
        let held = HeldCommands(orbit.point.inputs.clone());
        let mut recorder = Recorder::new(&robot, None, (&held, Vec::new()), cycle.steps() + 1, None)?;
        let mut sample = |t: f64, x: &[f64]| {
            recorder.sample(
                &Sample {
                    t,
                    x,
                    u: &orbit.point.inputs,
                    beyond: &BeyondLoads::NONE,
                    readings: &[],
                    elapsed: Duration::ZERO,
                },
                &held,
            )
        };
        let flown = sample(0.0, &cycle.start(&orbit.point)).and_then(|()| {
            cycle.fly(&orbit.point.z, orbit.point.pace, &orbit.point.inputs, |_, t, x| sample(t, x))
        });
        Ok(flown.map(|_| recorder.finish()))
    }

    /// What `[trim]` asks of straight flight: its course, and what is free.
    fn asked_of_orbit(&self, cycle: &Cycle) -> Result<(Course, Vec<Free>), Error> {
        let (spec, course) = (self.trim_spec()?, self.trim_spec()?.course());
        Ok((course, spec.free(&self.model, cycle.coupled(&course))?))
    }

    /// This scenario on the orbit through `point`, whose cycle takes `duration` s.
    fn on_orbit(&self, cycle: &Cycle, point: &Point, duration: f64) -> ScenarioSpec {
        let mut spec = ScenarioSpec { start: self.orbit_start(cycle, point), ..self.spec.clone() };
        spec.robot.gait.set_frequency_hz(1.0 / duration);
        spec
    }

    /// The scenario that flies the orbit.
    fn orbit_scenario(&self, cycle: &Cycle, orbit: &Orbit) -> Result<String, Error> {
        let mut spec = self.on_orbit(cycle, &orbit.point, orbit.end.duration);
        spec.name = format!("{}-orbit", self.spec.name);
        self.written(spec).map_err(|e| Error::invalid("trim", e, "a scenario that TOML can hold"))
    }

    /// The start of the orbit.
    fn orbit_start(&self, cycle: &Cycle, point: &Point) -> StartSpec {
        let (robot, x) = (&self.model, cycle.start(point));
        let layout = robot.layout();
        let angles = Quat::from_wxyz(&x[layout.attitude..]).matrix().roll_pitch_yaw();
        let states = robot.states()[layout.joints..].iter().zip(&x[layout.joints..]);
        let commands = robot.inputs().iter().zip(&point.inputs).filter(|(_, u)| **u != 0.0);
        StartSpec {
            velocity_m_s: Vec3::from_slice(&x[layout.velocity..]).0,
            roll_deg: angles[0].to_degrees(),
            nose_up_deg: 0.0 - angles[1].to_degrees(),
            yaw_deg: 0.0,
            phase_rad: self.spec.start.phase_rad,
            rate_rad_s: Vec3::from_slice(&x[layout.rate..]).0,
            states: filled(states.map(|(channel, x)| (channel.name.clone(), *x))),
            commands: filled(commands.map(|(channel, u)| (channel.name.clone(), *u))),
        }
    }
}

/// The modes of `orbit` and, where its feedback has `inputs`, the intervals by which it is made; then these give the modes too.
fn modes_and_intervals(
    cycle: &Cycle,
    orbit: &Orbit,
    inputs: &[usize],
) -> Result<(Modes, Vec<Interval>), Fault> {
    if inputs.is_empty() {
        return Ok((floquet(cycle, orbit)?, Vec::new()));
    }
    let all = intervals_along(cycle, &orbit.point, cycle.parts(), inputs)?;
    Ok((floquet_over(cycle, orbit, &all)?, all))
}

/// Multipliers as a record, a row each: its place, growth and frequency, sector, and the shares of the coordinates.
fn multipliers(modes: &Modes, coordinates: &[String]) -> Result<Record, Error> {
    let own = [
        ("multiplier_re", ""),
        ("multiplier_im", ""),
        ("lateral", ""),
        ("growth_per_s", "1/s"),
        ("frequency_hz", "Hz"),
    ];
    let own = own.map(|(name, unit)| Column::new(name, unit, "")).into_iter();
    let shares = coordinates.iter().map(|name| Column::new(format!("share_{name}"), "", ""));
    let mut record = Record::new(own.chain(shares).collect(), modes.modes.len())?;
    for mode in &modes.modes {
        let lateral = f64::from(u8::from(mode.sector != Sector::Longitudinal));
        let [re, im] = mode.multiplier;
        let own = [re, im, lateral, mode.growth, mode.frequency];
        let row: Vec<f64> = own.into_iter().chain(mode.shares.iter().copied()).collect();
        record.append(&row);
    }
    Ok(record)
}
