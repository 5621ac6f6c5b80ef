//! The best gait near the orbits of a scan.

use super::begin::FASTEST;
use super::scan::{Candidate, ENOUGH, STALLED, Tried};
use super::{RobotTrim, SCENARIO, numbers};
use crate::trim::TrimProgress;
use crate::trim::search::{Ended, Goal, LimitsSpec, SearchSpec, VarySpec};
use crate::{ConfigError, Document, Scenario, ScenarioSpec};
use std::cell::Cell;
use std::ops::ControlFlow;
use wingbeat_judge::limits::trim;
use wingbeat_math::order::ascend_by;

/// Orbits of the scan from which gaits are searched, until one keeps to the limits. *Choice.*
const SEARCHES: usize = 2;
/// Further orbits of the scan from which gaits are searched at most, where the gait found takes more power than they do. *Choice.*
const FURTHER: usize = 2;
/// Frequencies over that of scaling laws at which a search begins again where the one from the file's own has got stuck, as many as
/// [`ANEW`] at most, none within this share of the file's. *Choices.*
const OTHERS: [f64; 3] = [1.0, 0.7, 1.4];
const ANEW: usize = 2;
const BESIDE: f64 = 0.1;

/// Which orbit of the scan a gait is searched from next, of `powers` (W/kg), those nearest to the limits first: after a number of
/// `searches` that have found as the best gait one with this violation and power. One that keeps to the limits may still take more
/// power than the scan has seen elsewhere.
pub fn next(powers: &[f64], best: Option<(f64, f64)>, searches: usize) -> Option<usize> {
    match best {
        Some((violation, power)) if violation <= 0.0 => {
            let less = powers.iter().enumerate().filter(|(_, other)| **other < power);
            less.min_by(|a, b| a.1.total_cmp(b.1)).map(|(place, _)| place)
        }
        _ => (searches < SEARCHES && !powers.is_empty()).then_some(0),
    }
}

/// A gait that a search has found, on its orbit, or that of the scan where the search found none.
pub(super) struct Gaited {
    /// By how much it misses a limit.
    violation: f64,
    /// W/kg.
    power: f64,
    pub(super) spec: ScenarioSpec,
    pub(super) searched: SearchEnd,
    /// Whether the scan found fewer orbits than it looked for.
    few: bool,
}

/// How a search of gaits came out.
pub(super) enum SearchEnd {
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
    /// The best gait from the frequency of the file and, where its search gets stuck, from others.
    pub(super) fn of_starts(
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
