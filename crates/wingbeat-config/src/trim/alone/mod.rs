//! Trim of a robot from its file alone: what is free is chosen, the speed scanned, the gait searched within the limits of the verdict.
//!
//! 1. Scaling laws give speed and frequency ([`guess`]); joints without actuators get them ([`numbers`]).
//! 2. At each speed of a scan the gait is brought into balance in the mean ([`balance`]), and Newton's method finds its orbit.
//! 3. From the best of them, the search of gaits takes the power down and keeps to the limits.
//! 4. A turn is flown about the orbits of what was found ([`turn`]).

pub(crate) mod balance;
mod begin;
pub(crate) mod guess;
mod numbers;
mod turn;

pub use turn::TurnSummary;

use super::search::{Ended, Goal, LimitsSpec, SearchSpec, VarySpec, ended_early};
use super::spec::COUPLED;
use super::summary::TrimSummary;
use super::{TrimProgress, TrimSpec, Trimmed};
use crate::{ConfigError, Document, Scenario, ScenarioSpec, written};
use balance::{Balance, BalancingGait};
use begin::{FASTEST, flaps, frequency_key, let_flap, longest_chord, with_actuators, without_motor};
use guess::Size;
use serde::Serialize;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use wingbeat_flight::orbit::{FoundOrbit, Measures, OrbitSection, Point, measure, search, search_from};
use wingbeat_judge::limits::trim;
use wingbeat_judge::{Status, Warning};
use wingbeat_math::order::{ascend_by, filled};
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Error, SEA_LEVEL_DENSITY};
use wingbeat_robot::{LinkSide, Outline, RobotSpec};

/// What messages call the scenario that stands around a robot.
const SCENARIO: &str = "the scenario that `trim` puts around a robot";
/// What stands around a robot: still air at sea level, strips under law `stall`.
fn around() -> String {
    format!(
        "name = \"trim\"\n[air]\ndensity_kg_m3 = {SEA_LEVEL_DENSITY}\n[aero]\npreset = \"full\"\nlaw = \"stall\"\n[flight]\nduration_s = 2.0\n\
         step_s = 5e-4\nrecord_every_s = 2e-3\n"
    )
}
/// Strips of a surface, where its hinges do not ask for more, and of all together at most. *Choice*: a turn takes half the time of one
/// with 9; and what a robot may have.
const STRIPS: [usize; 2] = [7, 32];
/// Shares of the guessed speed that are scanned, in this order. *Choice.*
const SPEEDS: [f64; 6] = [1.0, 0.8, 1.25, 1.55, 0.65, 1.9];
/// Orbits after which the scan ends. *Choice.*
const ENOUGH: usize = 2;
/// Room that the wings are to keep, as a share of the span, and of what they have as the gait starts. *Choices*: a bank takes about
/// 20 mm of a span of .4 m.
const ROOM: [f64; 2] = [0.05, 0.7];
/// Largest share beyond 20 deg in a search. *Choice*, well within the limit of the verdict.
pub const STALLED: f64 = 0.3;
/// Share of a limit of the search by which the orbit found may miss it: its steps are shorter than those of the search. *Choice.*
const MISSED: f64 = 0.01;
/// Orbits of the scan from which gaits are searched, until one keeps to the limits. *Choice.*
const SEARCHES: usize = 2;
/// Further orbits of the scan from which gaits are searched at most, where the gait found takes more power than they do. *Choice.*
const FURTHER: usize = 2;
/// Iterations of the search of gaits. *Choice.*
const ITERATIONS: usize = 20;
/// Frequencies over that of scaling laws at which a search begins again where the one from the file's own has got stuck, as many as
/// [`ANEW`] at most, none within this share of the file's. *Choices.*
const OTHERS: [f64; 3] = [1.0, 0.7, 1.4];
const ANEW: usize = 2;
const BESIDE: f64 = 0.1;
/// Steps of integration of scan and search, s: the second where what the first finds is no orbit in the step of a trim. *Choices.*
const STEPS_S: [f64; 2] = [1e-3, 5e-4];
/// Mean pitches, rad, and paces to begin from at each speed, one after another until there is an orbit. *Choices.*
const STARTS: [(f64, f64); 4] = [(-0.15, 1.0), (-0.4, 1.0), (-0.15, 1.7), (-0.3, 2.5)];

/// A trim of a robot from its file.
#[derive(Debug)]
pub struct RobotTrim {
    /// The scenario around the robot, with its actuators.
    pub scenario: Scenario,
    document: Document,
    vary: Vec<VarySpec>,
    size: Size,
    ask: Ask,
    assumed: Vec<String>,
    /// Frequency of the file, Hz.
    given_hz: f64,
    /// Numbers of the file that are left out, and what they are there.
    left_out: Vec<(String, f64)>,
    warnings: Vec<Warning>,
    /// Most iterations of the search of gaits; 0 keeps the gait of the scan.
    pub iterations: usize,
}

/// What is asked beside level flight.
#[derive(Clone, Copy, Debug, Default)]
struct Ask {
    bank_deg: f64,
}

ranges!(Ask { bank_deg: Range::inside(-80.0, 80.0) });

/// What a trim from a robot's file did, in `summary.json`.
#[derive(Clone, Debug, Default, Serialize)]
pub struct AloneSummary {
    /// Speed of the scaling laws, m/s.
    pub guessed_speed_m_s: f64,
    /// Frequency of the scaling laws, Hz.
    pub guessed_frequency_hz: f64,
    /// Names of the actuators that were assumed.
    pub assumed_actuators: Vec<String>,
    /// What was tried at each speed, and what became of it.
    pub tried: Vec<Tried>,
    /// Numbers that were changed: key, value of the file and value found in the unit that ends the key, none where it was left
    /// out, as those of a motor.
    pub changed: BTreeMap<String, [Option<f64>; 2]>,
    /// How the search of the gait ended: `converged`, `no shorter step gains`, `iteration limit`, `no orbit beside the last one`, or `none
    /// found` where it could not begin or was stopped; missing where none was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub search_ended: Option<String>,
    /// Steps that it tried, also those that were refused; missing where none was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub search_iterations: Option<usize>,
    /// The turn that was flown.
    pub turn: Option<TurnSummary>,
}

/// A try of the scan.
#[derive(Clone, Debug, Serialize)]
pub struct Tried {
    /// m/s.
    pub speed_m_s: f64,
    /// Power over the mass of the orbit, W/kg.
    pub power_w_kg: Option<f64>,
    /// Its frequency, Hz.
    pub frequency_hz: Option<f64>,
    /// Why there is none, or which limit it misses.
    pub reason: Option<String>,
}

/// An orbit of the scan.
struct Candidate {
    spec: ScenarioSpec,
    /// How far beyond the limits of the verdict, then the power.
    order: (f64, f64),
    tried: Tried,
}

/// Which orbit of the scan a gait is searched from next, of `powers` (W/kg), those nearest to the limits first: after a number of
/// `searches` that have found as the best gait one with this violation and power. One that keeps to the limits may still take more
/// power than the scan has seen elsewhere.
fn next(powers: &[f64], best: Option<(f64, f64)>, searches: usize) -> Option<usize> {
    match best {
        Some((violation, power)) if violation <= 0.0 => {
            let less = powers.iter().enumerate().filter(|(_, other)| **other < power);
            less.min_by(|a, b| a.1.total_cmp(b.1)).map(|(place, _)| place)
        }
        _ => (searches < SEARCHES && !powers.is_empty()).then_some(0),
    }
}

/// A gait that a search has found, on its orbit, or that of the scan where the search found none.
struct Gaited {
    /// By how much it misses a limit.
    violation: f64,
    /// W/kg.
    power: f64,
    spec: ScenarioSpec,
    searched: SearchEnd,
    /// Whether the scan found fewer orbits than it looked for.
    few: bool,
}

/// How a search of gaits came out.
enum SearchEnd {
    /// None was asked for.
    NotAsked,
    /// It ended in words after so many steps.
    Ended(&'static str, usize),
    /// It found nothing, and why.
    NotMade(String),
}

impl Gaited {
    /// What is the less the better the gait is.
    fn order(&self) -> (f64, f64) {
        (self.violation.max(0.0), self.power)
    }

    /// Whether another start may find a better one: the search got stuck beside gaits without an orbit, or at once where the scan had little
    /// to begin from. One that used up its iterations was on its way.
    fn is_stuck(&self) -> bool {
        match self.searched {
            SearchEnd::NotAsked => false,
            SearchEnd::NotMade(_) => true,
            SearchEnd::Ended(how, _) => {
                how == Ended::NoSlopes.words() || self.few && how == Ended::NoStep.words()
            }
        }
    }
}

impl RobotTrim {
    /// Whether a document is a robot, and not a scenario that holds one.
    pub fn takes(document: &Document) -> bool {
        document.written("robot").is_none() && document.written("body").is_some()
    }

    /// Refuses a bank that no turn is flown with, as `bank_deg`.
    ///
    /// # Errors
    /// One out of range.
    pub fn check_bank(bank_deg: f64) -> Result<(), Error> {
        Ask { bank_deg }.in_range()
    }

    /// A trim of `robot`; `overrides` are of the scenario around it (`robot.body.mass_kg=.02`, `aero.law=lev`).
    ///
    /// # Errors
    /// What the robot's file or an override says wrongly.
    pub fn new(robot: Document, overrides: &[String], bank_deg: f64) -> Result<Self, ConfigError> {
        let ask = Ask { bank_deg };
        ask.in_range().map_err(|error| robot.explain(&error))?;
        let chosen = overrides.iter().filter_map(|text| text.split_once('='));
        if let Some((key, value)) = chosen.into_iter().find(|(key, _)| key.trim().starts_with("trim")) {
            let allowed = "none with a robot's file, whose speed and gait `trim` chooses: `wingbeat new trim` writes a scenario that gives them";
            return Err(robot.explain(&Error::invalid(key.trim(), value, allowed)));
        }
        let around = Document::text(SCENARIO, &around())?;
        let own: RobotSpec = robot.parse()?;
        let surfaces = own.surfaces.len() + usize::from(own.wing.is_some());
        let most = STRIPS[1] / surfaces.max(1);
        let around = around.put("robot", robot)?;
        let with = |strips: usize| {
            Scenario::new(around.clone().set(format!("aero.full.strips={strips}")).overridden(overrides))
        };
        // Every hinge, with those of spars, needs an edge of its own.
        let mut given = with(STRIPS[0].min(most));
        for strips in STRIPS[0] + 1..=most {
            if given.is_ok() {
                break;
            }
            given = with(strips);
        }
        let given = given?;
        let refused = |error: Error| given.explain(&error);
        given.in_still_air().map_err(refused)?;
        let size = given.size().map_err(refused)?;
        let mut spec = ScenarioSpec { name: given.spec.robot.name.clone(), ..given.spec.clone() };
        let given_hz = spec.robot.gait.frequency_hz();
        let mut warnings = Vec::new();
        let left_out = without_motor(&mut spec, &mut warnings);
        let_flap(&mut spec, &size, &mut warnings);
        spec.trim = Some(TrimSpec::level(size.speed().clamp(0.5, 50.0)));
        let alike =
            Scenario::new(Document::value(SCENARIO, &spec)?)?.cycle().map_or(true, |c| c.section().alike());
        let needed = if alike && bank_deg == 0.0 { 1 } else { COUPLED };
        let assumed = with_actuators(&mut spec, &given, needed, &mut warnings);
        let chord = longest_chord(&given.spec.robot);
        let vary = numbers::numbers(&spec.robot, chord);
        let free = vec!["frequency".to_string()];
        let asked = |free| TrimSpec { free, ..TrimSpec::level(size.speed().clamp(0.5, 50.0)) };
        spec.trim = Some(asked(free));
        let named = Scenario::new(Document::value(SCENARIO, &spec)?)?;
        let mut free = numbers::free(named.model());
        // A rudder has no effect on level flight: what level flight takes comes first.
        ascend_by(&mut free, |name| f64::from(u8::from(numbers::acts_across(&spec.robot, name))));
        spec.trim = Some(asked(free));
        let document = Document::value(SCENARIO, &spec)?;
        let scenario = Scenario::new(document.clone())?;
        scenario.cycle().map_err(refused)?;
        let iterations = ITERATIONS;
        Ok(Self { scenario, document, vary, size, ask, assumed, given_hz, left_out, warnings, iterations })
    }

    /// What the free numbers of its orbits are called, the frequency first.
    pub fn free(&self) -> &[String] {
        self.scenario.spec.trim.as_ref().map_or(&[], |trim| &trim.free)
    }

    /// What the robot of the trim has beyond its file, as the tables of a document whose robot is based on the file; none where that is
    /// nothing.
    ///
    /// # Errors
    /// A robot that TOML cannot hold.
    pub fn beyond_file(&self) -> Result<Option<String>, ConfigError> {
        if self.assumed.is_empty() {
            return Ok(None);
        }
        let robot = &self.scenario.spec.robot;
        let mut own = toml::Table::new();
        let put = |own: &mut toml::Table, key: &str, value: Result<toml::Value, toml::ser::Error>| {
            let value = value.map_err(|e| Error::invalid(key, e, "what TOML can hold"));
            value.map(|value| own.insert(key.into(), value)).map_err(|e| self.scenario.explain(&e))
        };
        let tails: Vec<_> = robot.links.iter().filter(|link| self.assumed.contains(&link.name)).collect();
        let tails = tails.into_iter().filter(|link| link.side == LinkSide::Single);
        let mut links = Vec::new();
        for link in tails {
            let mut table = toml::Table::new();
            table.insert("name".into(), link.name.clone().into());
            put(&mut table, "axis", written::tree(&link.axis))?;
            put(&mut table, "driven", written::tree(&link.driven))?;
            links.push(toml::Value::Table(table));
        }
        if !links.is_empty() {
            own.insert("links".into(), toml::Value::Array(links));
        }
        put(&mut own, "structure", written::tree(&robot.structure))?;
        let mut whole = toml::Table::new();
        whole.insert("robot".into(), toml::Value::Table(own));
        Ok(Some(whole.to_string()))
    }

    /// Trims the robot.
    ///
    /// # Errors
    /// A gait that moves no surface; a scenario that cannot be written.
    pub fn trim(
        &self,
        observe: &mut dyn FnMut(TrimProgress) -> ControlFlow<()>,
    ) -> Result<Trimmed, ConfigError> {
        if !flaps(&self.scenario) {
            let allowed = "links that the gait drives: without flapping there is no cycle to trim";
            let error = Error::invalid("robot.links", "none moves a surface", allowed);
            return Err(self.scenario.explain(&error));
        }
        self.can_be_held()?;
        let mut alone = AloneSummary {
            guessed_speed_m_s: self.size.speed(),
            guessed_frequency_hz: self.size.frequency(),
            assumed_actuators: self.assumed.clone(),
            changed: filled(self.left_out.iter().map(|(key, value)| (key.clone(), [Some(*value), None]))),
            ..AloneSummary::default()
        };
        let (mut found, mut stopped) = (None, false);
        let observe = &mut |at| {
            let flow = observe(at);
            stopped |= flow.is_break();
            flow
        };
        for step in STEPS_S {
            let Some(Gaited { mut spec, searched, .. }) = self.of_starts(step, &mut alone.tried, observe)?
            else {
                continue;
            };
            spec.trim.iter_mut().for_each(|trim| trim.step_s = TrimSpec::level(1.0).step_s);
            let scenario = Scenario::new(Document::value(SCENARIO, &spec)?)?;
            let trimmed = scenario.trim(observe)?;
            let done = trimmed.summary.frequency_hz.is_some();
            found = Some((spec, scenario, trimmed, searched));
            if done {
                break;
            }
        }
        let Some((spec, scenario, mut trimmed, searched)) = found else {
            return Ok(self.nothing(alone, stopped));
        };
        match searched {
            SearchEnd::NotAsked => {}
            SearchEnd::Ended(how, steps) => {
                // Its keys are not the caller's.
                let early = ended_early(how, steps).map(|warning| Warning { key: None, ..warning });
                trimmed.summary.warnings.extend(early);
                (alone.search_ended, alone.search_iterations) = (Some(how.into()), Some(steps));
            }
            SearchEnd::NotMade(why) => {
                let text =
                    format!("the gait is that of the scan: the search of a better one gave none ({why})");
                trimmed.summary.warnings.push(Warning::new("trim.search_ended", text));
                alone.search_ended = Some("none found".into());
            }
        }
        for vary in &self.vary {
            let now = Document::value(SCENARIO, &spec)?;
            if let (Ok(from), Ok(to)) = (self.document.number(&vary.key), now.number(&vary.key))
                && from != to
            {
                alone.changed.insert(vary.key.clone(), [Some(from), Some(to)]);
            }
        }
        let found = spec.robot.gait.frequency_hz();
        alone.changed.insert(frequency_key(&spec), [Some(self.given_hz), Some(found)]);
        self.keeps_its_limits(&mut trimmed.summary);
        let text = |toml: Result<String, toml::ser::Error>| {
            toml.map_err(|e| scenario.explain(&Error::invalid("trim", e, "what TOML can hold")))
        };
        trimmed.files.push(("trim.toml", text(scenario.written(spec.clone()))?));
        trimmed.files.push(("robot.toml", text(written::toml(&spec.robot))?));
        if self.ask.bank_deg != 0.0 && trimmed.summary.frequency_hz.is_some() {
            let (summary, file) = turn::flown(&spec, &trimmed.summary, self.ask.bank_deg, observe)?;
            trimmed.files.extend(file.map(|text| ("turn.toml", text)));
            trimmed.summary.with_turn(&summary);
            alone.turn = Some(summary);
        }
        trimmed.summary.warnings.extend(self.warnings.iter().cloned());
        trimmed.summary.alone = Some(alone);
        Ok(trimmed)
    }

    /// Refuses a robot whose left and right differ and that has too few numbers to be chosen.
    ///
    /// # Errors
    /// Such a robot, with the numbers that it needs.
    pub fn can_be_held(&self) -> Result<(), ConfigError> {
        self.has_enough_free().map_err(|error| self.scenario.explain(&error))
    }

    fn has_enough_free(&self) -> Result<(), Error> {
        let (cycle, course) = (self.scenario.cycle()?, self.scenario.trim_spec()?.course());
        let coupled = cycle.coupled(&course);
        let free = numbers::all_free(self.scenario.model(), coupled).len();
        if !coupled || free >= COUPLED {
            return Ok(());
        }
        let allowed = format!(
            "actuators that make it {COUPLED} or more, as left and right of the robot differ and no flight stays level by fewer"
        );
        let given = format!("{free} number to choose, the frequency counted");
        Err(Error::invalid("robot.structure.elements", given, allowed))
    }

    /// The best gait from the frequency of the file and, where its search gets stuck, from others.
    fn of_starts(
        &self,
        step: f64,
        tried: &mut Vec<Tried>,
        observe: &mut dyn FnMut(TrimProgress) -> ControlFlow<()>,
    ) -> Result<Option<Gaited>, ConfigError> {
        let stopped = Cell::new(false);
        let mut observe = |at| {
            let flow = observe(at);
            stopped.set(stopped.get() || flow.is_break());
            flow
        };
        let own = self.scenario.spec.robot.gait.frequency_hz();
        let Some(mut best) = self.best((own, step), tried, &mut observe)? else { return Ok(None) };
        let others = OTHERS.map(|share| share * self.size.frequency());
        let others = others.into_iter().filter(|other| (other / own - 1.0).abs() > BESIDE);
        for other in others.take(ANEW) {
            if stopped.get() || !best.is_stuck() {
                break;
            }
            let found = self.best((other, step), tried, &mut observe)?;
            best = found
                .into_iter()
                .fold(best, |best, found| if found.order() < best.order() { found } else { best });
        }
        Ok(Some(best))
    }

    /// The best gait that scan and search find from the frequency `hz` in steps of `step` s, on its orbit.
    fn best(
        &self,
        (hz, step): (f64, f64),
        tried: &mut Vec<Tried>,
        observe: &mut dyn FnMut(TrimProgress) -> ControlFlow<()>,
    ) -> Result<Option<Gaited>, ConfigError> {
        let mut candidates = self.scan((hz, step), tried, observe);
        let few = candidates.len() < ENOUGH;
        // Equal ones keep the order of the second number.
        ascend_by(&mut candidates, |candidate| candidate.order.1);
        ascend_by(&mut candidates, |candidate| candidate.order.0);
        let mut best: Option<Gaited> = None;
        for searches in 0..SEARCHES + FURTHER {
            let powers: Vec<f64> = candidates.iter().map(|candidate| candidate.order.1).collect();
            let Some(next) = next(&powers, best.as_ref().map(Gaited::order), searches) else { break };
            let found = Gaited { few, ..self.searched(candidates.remove(next), observe)? };
            if best.as_ref().is_none_or(|best| found.order() < best.order()) {
                best = Some(found);
            }
        }
        Ok(best)
    }

    /// That no orbit was found, and why.
    fn nothing(&self, alone: AloneSummary, stopped: bool) -> Trimmed {
        let spec = &self.scenario.spec;
        // A finer step that finds no more says the same of each speed.
        let mut why: Vec<String> = Vec::new();
        for tried in &alone.tried {
            let told = format!("at {:.2} m/s {}", tried.speed_m_s, tried.reason.as_deref().unwrap_or("none"));
            if !why.contains(&told) {
                why.push(told);
            }
        }
        let mut summary = TrimSummary {
            speed_m_s: self.size.speed(),
            aero_preset: spec.aero.preset.name().into(),
            lift_law: spec.aero.law.name().into(),
            warnings: self.warnings.clone(),
            ..TrimSummary::default()
        };
        summary.reason = Some(format!("no level flight: {}", why.join("; ")));
        if stopped {
            summary.status = Status::Interrupted;
        }
        summary.alone = Some(alone);
        Trimmed::nothing(summary)
    }

    /// Orbits at the speeds of the scan, from the frequency `hz` in steps of `step` s.
    fn scan(
        &self,
        (hz, step): (f64, f64),
        tried: &mut Vec<Tried>,
        observe: &mut dyn FnMut(TrimProgress) -> ControlFlow<()>,
    ) -> Vec<Candidate> {
        let mut found: Vec<Candidate> = Vec::new();
        let mut stopped = false;
        for speed in SPEEDS.map(|share| share * self.size.speed()) {
            let mut reason = String::new();
            for start in STARTS {
                let mut tell = |iteration, residual| {
                    let flow = observe(TrimProgress::Orbit { orbits: found.len(), iteration, residual });
                    stopped |= flow.is_break();
                    flow
                };
                match self.at((speed, hz, step), start, &mut tell) {
                    Ok(candidate) => {
                        reason.clear();
                        tried.push(candidate.tried.clone());
                        found.push(candidate);
                        break;
                    }
                    Err(why) if reason.is_empty() => reason = why,
                    Err(_) => {}
                }
            }
            if !reason.is_empty() {
                let none =
                    Tried { speed_m_s: speed, power_w_kg: None, frequency_hz: None, reason: Some(reason) };
                tried.push(none);
            }
            let good = found.iter().filter(|candidate| candidate.order.0 <= 0.0).count();
            if stopped || good >= ENOUGH {
                break;
            }
        }
        found
    }

    /// The orbit at `speed`, from the frequency `hz` in steps of `step` s, of the gait nearest to the file's that is in balance.
    fn at(
        &self,
        (speed, hz, step): (f64, f64, f64),
        (pitch, pace): (f64, f64),
        tell: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
    ) -> Result<Candidate, String> {
        let document = self
            .document
            .clone()
            .set(format!("trim.speed_m_s={speed:?}"))
            .set(format!("trim.step_s={step:?}"))
            .set(format!("{}={hz:?}", frequency_key(&self.scenario.spec)));
        let balance = Balance { document: &document, vary: &self.vary, length: 0.1 * self.size.span };
        let own = |vary: &VarySpec| document.number(&vary.key).map_or(0.5, |value| vary.share(value));
        let x: Vec<f64> = self.vary.iter().map(own).collect();
        let first = balance.scenario(&x)?;
        let cycle = first.cycle().map_err(|error| error.to_string())?;
        let mut z = vec![0.0; cycle.section().len()];
        (z[OrbitSection::VELOCITY.start], z[OrbitSection::PITCH]) = (speed, pitch);
        let joints = first.model().start_coordinates();
        z[OrbitSection::BODY..][..joints.len()].copy_from_slice(&joints);
        let inputs = first.held_commands();
        let gait = BalancingGait { x, point: Point { z, pace, inputs }, pitch };
        let gait = balance.near(gait, tell)?;
        let scenario = balance.scenario(&gait.x)?;
        let cycle = scenario.cycle().map_err(|error| error.to_string())?;
        let (course, _) = scenario.asked_of_orbit(&cycle).map_err(|error| error.to_string())?;
        let free = numbers::all_free(scenario.model(), cycle.coupled(&course));
        let found = search_from(&cycle, &course, &free, gait.point.clone(), tell)
            .or_else(|_| search(&cycle, &course, &free, gait.point, tell))
            .map_err(|failure| format!("balanced in the mean, but {failure}"))?;
        let measures =
            measure(&cycle, &found.orbit, &scenario.strip_areas()).map_err(|fault| fault.to_string())?;
        let mut spec = scenario.on_orbit(&cycle, &found.orbit.point, found.orbit.end.duration);
        numbers::fold(&mut spec);
        if let Some(trim) = &mut spec.trim {
            trim.frees_the_steadiest(&scenario, &cycle, &found.orbit.point, 1.0)?;
        }
        let mass = scenario.model().mass();
        Ok(self.candidate(spec, &found, &measures, mass))
    }

    /// By how much the limits of the search are missed, as shares of them.
    fn misses(&self, power: f64, stalled: f64, clearance: f64, frequency: f64) -> [(f64, &'static str); 4] {
        [
            (power / trim::HIGH_POWER.value - 1.0, "the power"),
            (stalled / STALLED - 1.0, "the share beyond 20 deg"),
            (1.0 - clearance / self.size.room, "the clearance"),
            (frequency / (FASTEST * self.size.frequency()) - 1.0, "the frequency"),
        ]
    }

    /// Says in the verdict which limits of the search the orbit misses.
    #[doc(hidden)]
    pub fn keeps_its_limits(&self, summary: &mut TrimSummary) {
        let (Some(power), Some(stalled), Some(frequency)) =
            (summary.power_w_kg, summary.stall_fraction_20, summary.frequency_hz)
        else {
            return;
        };
        let clearance = summary.least_clearance_m.unwrap_or(f64::INFINITY);
        let most = [
            format!("{power:.0} W/kg, allowed is {:.0}", trim::HIGH_POWER.value),
            format!("{stalled:.2}, allowed is {STALLED}"),
            format!("{:.1} mm, needed are {:.1}", 1e3 * clearance, 1e3 * self.size.room),
            format!("{frequency:.1} Hz, allowed is {:.1}", FASTEST * self.size.frequency()),
        ];
        let misses = self.misses(power, stalled, clearance, frequency).into_iter().zip(most);
        let missed: Vec<String> = misses
            .filter(|((by, _), _)| *by > MISSED)
            .map(|((_, name), numbers)| format!("{name} is {numbers}"))
            .collect();
        if missed.is_empty() || summary.status >= Status::NotFound {
            return;
        }
        let missed = format!("no gait within the limits of the search was found: {}", missed.join(", "));
        summary.status = summary.status.max(Status::OffTarget);
        summary.reason = Some(summary.reason.iter().cloned().chain([missed]).collect::<Vec<_>>().join("; "));
    }

    /// An orbit beside the limits of the verdict.
    fn candidate(&self, spec: ScenarioSpec, found: &FoundOrbit, measures: &Measures, mass: f64) -> Candidate {
        let power = measures.cost.positive_power / mass;
        let frequency = 1.0 / found.orbit.end.duration;
        let least = measures.least_clearance.unwrap_or(f64::INFINITY);
        let misses = self.misses(power, measures.stall.sharp[1], least, frequency);
        let missed: Vec<&str> = misses.iter().filter(|(by, _)| *by > 0.0).map(|(_, name)| *name).collect();
        let sum: f64 = misses.iter().map(|(by, _)| by.max(0.0)).sum();
        let reason = (!missed.is_empty()).then(|| format!("beyond what is searched: {}", missed.join(", ")));
        let tried = Tried {
            speed_m_s: found.orbit.course.speed,
            power_w_kg: Some(power),
            frequency_hz: Some(frequency),
            reason,
        };
        Candidate { spec, order: (sum, power), tried }
    }

    /// The best gait near that of a candidate; the candidate's where the search finds none.
    fn searched(
        &self,
        candidate: Candidate,
        observe: &mut dyn FnMut(TrimProgress) -> ControlFlow<()>,
    ) -> Result<Gaited, ConfigError> {
        let Candidate { spec, order: (violation, power), .. } = candidate;
        let mut gait = Gaited { violation, power, spec, searched: SearchEnd::NotAsked, few: false };
        if self.iterations == 0 {
            return Ok(gait);
        }
        let spec = &gait.spec;
        let speed = spec.trim.as_ref().map_or(1.0, |trim| trim.speed_m_s);
        let own = Document::value(SCENARIO, spec)?;
        let mut vary = self.vary.clone();
        vary.push(VarySpec { key: "trim.speed_m_s".into(), low: 0.6 * speed, high: 1.5 * speed });
        // What was folded in may lie beyond a range.
        vary.retain_mut(|vary| {
            let value = own.number(&vary.key);
            value.is_ok_and(|value| {
                (vary.low, vary.high) = (vary.low.min(value), vary.high.max(value));
                true
            })
        });
        let limits = LimitsSpec {
            clearance_m: Some(self.size.room),
            frequency_hz: Some(FASTEST * self.size.frequency()),
            power_w_kg: Some(trim::HIGH_POWER.value),
            stall_fraction_20: Some(STALLED),
            ..LimitsSpec::default()
        };
        let search = SearchSpec { iterations: self.iterations, ..SearchSpec::new(Goal::Power, vary, limits) };
        let mut asked = spec.clone();
        asked.trim.iter_mut().for_each(|trim| trim.search = Some(search.clone()));
        let scenario = Scenario::new(Document::value(SCENARIO, &asked)?)?;
        let tell = &mut |at| observe(TrimProgress::Search(at));
        let searched = match scenario.gait_search() {
            Ok(Some(search)) => search.all::<ConfigError>(Vec::new(), &mut |_| Ok(()), tell),
            Ok(None) => Ok(None),
            Err(error) => Err(error),
        };
        gait.searched = match &searched {
            Ok(Some(searched)) => SearchEnd::Ended(searched.summary.ended, searched.summary.iterations),
            Ok(None) => SearchEnd::NotMade("it was stopped".into()),
            Err(error) => SearchEnd::NotMade(error.to_string()),
        };
        if let Ok(Some(searched)) = searched {
            gait.spec = searched.best.spec.clone();
            numbers::fold(&mut gait.spec);
            let power = searched.starts.values("power_w_kg").and_then(|all| all.get(searched.summary.best));
            gait.power = power.copied().unwrap_or(gait.power);
            gait.violation = if searched.summary.kept > 0 { 0.0 } else { searched.summary.violation };
        }
        Ok(gait)
    }
}

/// Area of an outline between its ribs as seen from above, m2: half of the cross product of the diagonals of each quadrilateral, of which
/// a fin has none.
fn area(outline: &Outline) -> f64 {
    let covered = outline.ribs.windows(2).zip(&outline.covered).filter(|(_, covered)| **covered);
    covered.map(|(ribs, _)| 0.5 * (ribs[1][1] - ribs[0][0]).cross(ribs[1][0] - ribs[0][1])[2].abs()).sum()
}

impl Scenario {
    /// What scaling laws take of the robot, its wings as its gait starts.
    fn size(&self) -> Result<Size, Error> {
        let still = self.model.at_rest(0.0);
        let still = still.map_err(|fault| Error::invalid("robot", fault, "a robot that can be evaluated"))?;
        let areas: Vec<f64> = still.outlines.iter().map(area).collect();
        let (area, wing) = (areas.iter().sum::<f64>(), areas.iter().copied().fold(0.0, f64::max));
        let widest = still.outlines.iter().map(|outline| {
            let tips = outline.ribs.iter().map(|rib| rib[0][1]);
            tips.clone().fold(0.0, f64::max) - tips.fold(0.0, f64::min)
        });
        let span = widest.fold(0.0, f64::max);
        if !(area > 0.0 && span > 0.0) {
            return Err(Error::invalid("robot.surfaces", "no area", "a surface that carries"));
        }
        let seen = self.model.observe(0.0, &self.start_of(&self.model), &self.held_commands());
        let least =
            seen.map_or(f64::INFINITY, |seen| seen.clearances.iter().copied().fold(f64::INFINITY, f64::min));
        let room = (ROOM[0] * span).min(ROOM[1] * least).max(trim::SKIN.value);
        Ok(Size { mass: self.model.mass(), span, area, wing, density: self.spec.air.density_kg_m3, room })
    }

    /// Speed at which all surfaces of the robot carry its weight at a lift coefficient of .6, m/s.
    ///
    /// # Errors
    /// A robot without surfaces.
    pub fn guessed_speed(&self) -> Result<f64, ConfigError> {
        Ok(self.size().map_err(|error| self.explain(&error))?.speed())
    }
}

#[cfg(test)]
mod tests {
    use super::next;

    /// Of a gait within the limits at 151 W/kg the search goes on to the orbit of 71 that lies beyond them, and to no dearer one.
    #[test]
    fn a_gait_that_keeps_its_limits_is_not_the_last_that_is_searched() {
        assert_eq!(next(&[160.0, 71.0, 90.0], None, 0), Some(0));
        assert_eq!(next(&[200.0, 90.0, 71.0], Some((0.0, 151.0)), 1), Some(2));
        assert_eq!(next(&[200.0, 90.0], Some((0.0, 80.0)), 2), None);
        assert_eq!(next(&[71.0, 90.0], Some((0.3, 60.0)), 1), Some(0));
        assert_eq!(next(&[71.0], Some((0.3, 60.0)), 2), None);
        assert_eq!(next(&[], None, 0), None);
    }
}
