//! Trim of a robot from its file alone: what is free is chosen, the speed scanned, the gait searched within the limits of the verdict.
//!
//! 1. Scaling laws give speed and frequency ([`guess`]); joints without actuators get them ([`numbers`]).
//! 2. At each speed of a scan ([`scan`]) the gait is brought into balance in the mean ([`balance`]), and Newton's method finds its orbit.
//! 3. From the best of them, the search of gaits ([`gait`]) takes the power down and keeps to the limits.
//! 4. A turn is flown about the orbits of what was found ([`turn`]).

pub(crate) mod balance;
mod begin;
mod gait;
pub(crate) mod guess;
mod numbers;
mod scan;
mod turn;

pub use gait::next;
pub use scan::{STALLED, Tried};
pub use turn::TurnSummary;

use super::search::{VarySpec, ended_early};
use super::spec::COUPLED;
use super::summary::TrimSummary;
use super::{TrimProgress, TrimSpec, Trimmed};
use crate::{ConfigError, Document, Scenario, ScenarioSpec, written};
use begin::{flaps, frequency_key, let_flap, longest_chord, with_actuators, without_motor};
use gait::{Gaited, SearchEnd};
use guess::Size;
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use wingbeat_judge::{Status, Warning};
use wingbeat_math::order::{ascend_by, filled};
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Error, SEA_LEVEL_DENSITY};
use wingbeat_robot::{LinkSide, RobotSpec};

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
/// Iterations of the search of gaits. *Choice.*
const ITERATIONS: usize = 20;
/// Steps of integration of scan and search, s: the second where what the first finds is no orbit in the step of a trim. *Choices.*
const STEPS_S: [f64; 2] = [1e-3, 5e-4];

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
}
