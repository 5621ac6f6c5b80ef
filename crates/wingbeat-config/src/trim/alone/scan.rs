//! The scan of speeds: orbits of gaits in balance, and by how much they miss the limits of the search.

use super::balance::{Balance, Balanced, BalancingGait};
use super::begin::{FASTEST, frequency_key};
use super::{RobotTrim, numbers};
use crate::trim::TrimProgress;
use crate::trim::search::VarySpec;
use crate::trim::summary::TrimSummary;
use crate::{Document, ScenarioSpec};
use serde::Serialize;
use std::ops::ControlFlow;
use wingbeat_flight::orbit::{FoundOrbit, Measures, OrbitSection, Point, measure, search, search_from};
use wingbeat_judge::Status;
use wingbeat_judge::limits::trim;

/// Shares of the guessed speed that are scanned, in this order. *Choice.*
const SPEEDS: [f64; 6] = [1.0, 0.8, 1.25, 1.55, 0.65, 1.9];
/// Orbits after which the scan ends. *Choice.*
pub(super) const ENOUGH: usize = 2;
/// Mean pitches, rad, and paces to begin from at each speed, one after another until there is an orbit. *Choices.*
const STARTS: [(f64, f64); 4] = [(-0.15, 1.0), (-0.4, 1.0), (-0.15, 1.7), (-0.3, 2.5)];
/// Largest share beyond 20 deg in a search. *Choice*, well within the limit of the verdict.
pub const STALLED: f64 = 0.3;
/// Share of a limit of the search by which the orbit found may miss it: its steps are shorter than those of the search. *Choice.*
const MISSED: f64 = 0.01;

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
pub(super) struct Candidate {
    pub(super) spec: ScenarioSpec,
    /// How far beyond the limits of the verdict, then the power.
    pub(super) order: (f64, f64),
    tried: Tried,
}

/// What a scan has found.
#[derive(Default)]
struct Scanned {
    found: Vec<Candidate>,
    stopped: bool,
}

impl Scanned {
    /// Tells `observe` of an iteration.
    fn teller<'a>(
        &'a mut self,
        observe: &'a mut dyn FnMut(TrimProgress) -> ControlFlow<()>,
    ) -> impl FnMut(usize, f64) -> ControlFlow<()> + 'a {
        let orbits = self.found.len();
        move |iteration, residual| {
            let flow = observe(TrimProgress::Orbit { orbits, iteration, residual });
            self.stopped |= flow.is_break();
            flow
        }
    }

    /// Takes an orbit over, and tells what was tried.
    fn take(&mut self, candidate: Candidate, tried: &mut Vec<Tried>) {
        tried.push(candidate.tried.clone());
        self.found.push(candidate);
    }

    /// Whether it was stopped or has found enough.
    fn ends(&self) -> bool {
        let good = self.found.iter().filter(|candidate| candidate.order.0 <= 0.0).count();
        self.stopped || good >= ENOUGH
    }
}

impl RobotTrim {
    /// Orbits at the speeds of the scan, from the frequency `hz` in steps of `step` s.
    pub(super) fn scan(
        &self,
        (hz, step): (f64, f64),
        tried: &mut Vec<Tried>,
        observe: &mut dyn FnMut(TrimProgress) -> ControlFlow<()>,
    ) -> Vec<Candidate> {
        let mut scan = Scanned::default();
        let mut far = Vec::new();
        for speed in SPEEDS.map(|share| share * self.size.speed()) {
            let document = self.document_at(speed, hz, step);
            let (mut reason, mut lacking) = (String::new(), Vec::new());
            for start in STARTS {
                let balanced = self.balanced(&document, speed, start, &mut scan.teller(observe));
                let candidate = match balanced {
                    Ok(Balanced { gait, lacks: Some(lacks) }) => {
                        lacking.push(gait);
                        Err(lacks)
                    }
                    Ok(Balanced { gait, .. }) => self.orbit(&document, gait, &mut scan.teller(observe)),
                    Err(why) => Err(why),
                };
                match candidate {
                    Ok(candidate) => {
                        reason.clear();
                        scan.take(candidate, tried);
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
                far.push((document, lacking));
            }
            if scan.ends() {
                return scan.found;
            }
        }
        self.scan_far(far, scan, tried, observe)
    }

    /// Goes on with the gaits that lack more, each with the scenario of its speed: Newton's method takes long where there is no orbit.
    fn scan_far(
        &self,
        far: Vec<(Document, Vec<BalancingGait>)>,
        mut scan: Scanned,
        tried: &mut Vec<Tried>,
        observe: &mut dyn FnMut(TrimProgress) -> ControlFlow<()>,
    ) -> Vec<Candidate> {
        for (document, gaits) in far {
            if scan.ends() {
                break;
            }
            let mut tell = scan.teller(observe);
            let orbit = gaits.into_iter().find_map(|gait| self.orbit(&document, gait, &mut tell).ok());
            drop(tell);
            orbit.into_iter().for_each(|candidate| scan.take(candidate, tried));
        }
        scan.found
    }

    /// The scenario at `speed`, at the frequency `hz` and in steps of `step` s.
    fn document_at(&self, speed: f64, hz: f64, step: f64) -> Document {
        let document = self.document.clone().set(format!("trim.speed_m_s={speed:?}"));
        let document = document.set(format!("trim.step_s={step:?}"));
        document.set(format!("{}={hz:?}", frequency_key(&self.scenario.spec)))
    }

    /// What is balanced in `document`.
    fn balance<'a>(&'a self, document: &'a Document) -> Balance<'a> {
        Balance { document, vary: &self.vary, length: 0.1 * self.size.span }
    }

    /// The gait nearest to the file's that is in balance at `speed`.
    fn balanced(
        &self,
        document: &Document,
        speed: f64,
        (pitch, pace): (f64, f64),
        tell: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
    ) -> Result<Balanced, String> {
        let balance = self.balance(document);
        let own = |vary: &VarySpec| document.number(&vary.key).map_or(0.5, |value| vary.share(value));
        let x: Vec<f64> = self.vary.iter().map(own).collect();
        let first = balance.scenario(&x)?;
        let cycle = first.cycle().map_err(|error| error.to_string())?;
        let mut z = vec![0.0; cycle.section().len()];
        (z[OrbitSection::VELOCITY.start], z[OrbitSection::PITCH]) = (speed, pitch);
        let joints = first.model().start_coordinates();
        z[OrbitSection::BODY..][..joints.len()].copy_from_slice(&joints);
        let inputs = first.held_commands();
        balance.near(BalancingGait { x, point: Point { z, pace, inputs }, pitch }, tell)
    }

    /// The orbit that Newton's method finds from a gait.
    fn orbit(
        &self,
        document: &Document,
        gait: BalancingGait,
        tell: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
    ) -> Result<Candidate, String> {
        let scenario = self.balance(document).scenario(&gait.x)?;
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
}
