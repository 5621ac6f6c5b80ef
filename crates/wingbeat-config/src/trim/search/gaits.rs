//! Gaits as points of a search: the orbit of each, and what it takes.

use super::descent::{DescentPoint, Landscape, Slopes};
use super::spec::{Goal, SearchSpec};
use crate::sweep::with_all;
use crate::{Document, Scenario};
use std::ops::ControlFlow;
use wingbeat_flight::orbit::{
    Cycle, Failure, FoundOrbit, Measures, Point, Tangent, floquet, measure, search_near,
};
use wingbeat_math::parallel;
use wingbeat_ocp::plant::Fault;

/// Scales of the limits: what counts as one of a clearance, m, of a share and of a multiplier.
const CLEARANCE: f64 = 0.01;
const SHARE: f64 = 0.1;
const MULTIPLIER: f64 = 0.1;
/// Step of the differences, as a share of a range: orbits close to 1e-11.
const STEP: f64 = 1e-5;
/// Parts of the way from the scenario's own gait to one that its start does not lead to.
const PARTS: usize = 16;

/// What a gait takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    pub frequency: f64,
    pub speed: f64,
    /// Mean of the scenario's own air and the others.
    pub power_per_mass: f64,
    pub stalled: [f64; 2],
    /// Of all numbers of strips.
    pub clearance: f64,
    /// Of all numbers of strips; not a number where no limit asks for it.
    pub multiplier: f64,
    pub mass: f64,
    /// Largest excess of the sharp shares over their limits, of all numbers of strips.
    pub stalled_beyond: f64,
}

/// An orbit with one number of strips.
struct FlownOrbit {
    found: FoundOrbit,
    measures: Measures,
    multiplier: f64,
    speed: f64,
    mass: f64,
}

/// What belongs to a gait.
pub(super) struct Gait {
    pub points: Vec<Point>,
    /// Where derivatives were asked for.
    tangents: Vec<Tangent>,
    pub facts: Facts,
}

/// All gaits of a search.
pub(super) struct Gaits<'a> {
    spec: &'a SearchSpec,
    /// The scenario without its search: its own, those of the other airs, those of the other numbers of strips.
    documents: Vec<Document>,
    /// How many of the first of them the power is the mean of.
    averaged: usize,
    /// Objective of the own gait.
    scale: f64,
}

impl<'a> Gaits<'a> {
    pub fn new(spec: &'a SearchSpec, own: Document) -> Self {
        let airs = spec.airs.iter().map(|air| with_all(own.clone(), air));
        let strips = spec.strips.iter().map(|strips| own.clone().set(format!("aero.full.strips={strips}")));
        let documents = std::iter::once(own.clone()).chain(airs).chain(strips).collect();
        Self { spec, documents, averaged: 1 + spec.airs.len(), scale: 1.0 }
    }

    /// The scenario at `x` with the model of number `model`.
    pub fn scenario(&self, model: usize, x: &[f64]) -> Result<Scenario, String> {
        let varied = self.spec.vary.iter().zip(x);
        let document = varied.fold(self.documents[model].clone(), |document, (vary, x)| {
            document.set(format!("{}={:?}", vary.key, vary.at(*x)))
        });
        Scenario::new(document).map_err(|error| error.to_string())
    }

    /// The gait at `x`, found as `wingbeat trim` does.
    pub fn first(&mut self, x: &[f64]) -> Result<DescentPoint<Gait>, String> {
        let seen = self.anew(x)?;
        self.scale = seen.objective.abs();
        self.anew(x)
    }

    /// The gait at `x` from its scenario's own start.
    fn anew(&self, x: &[f64]) -> Result<DescentPoint<Gait>, String> {
        self.gait(x, |_, scenario, cycle| {
            let found = scenario.find_orbit(cycle, &mut |_, _| ControlFlow::Continue(()));
            found.map_err(|error| error.to_string())?.map_err(|failure| failure.to_string())
        })
    }

    /// The gait at the shares `x` of the ranges: from its scenario's own start, or step by step from `own` at `from`.
    pub fn reached(
        &self,
        x: &[f64],
        from: &[f64],
        own: &DescentPoint<Gait>,
    ) -> Result<DescentPoint<Gait>, String> {
        self.anew(x).or_else(|_| {
            let between = |k: usize| -> Vec<f64> {
                let share = k as f64 / PARTS as f64;
                from.iter().zip(x).map(|(a, b)| a + share * (b - a)).collect()
            };
            let first = self.near(&between(1), own, &self.tangents(from, own)?)?;
            (2..=PARTS).try_fold(first, |last, k| {
                self.near(&between(k), &last, &self.tangents(&between(k - 1), &last)?)
            })
        })
    }

    /// The gait at `x` from one close by.
    fn near(
        &self,
        x: &[f64],
        close: &DescentPoint<Gait>,
        tangents: &[Tangent],
    ) -> Result<DescentPoint<Gait>, String> {
        self.gait(x, |model, scenario, cycle| {
            let (course, free) = scenario.asked_of_orbit(cycle).map_err(|error| error.to_string())?;
            let point = close.more.points[model].clone();
            search_near(cycle, &course, &free, point, &tangents[model]).map_err(|failure| failure.to_string())
        })
    }

    fn tangents(&self, x: &[f64], seen: &DescentPoint<Gait>) -> Result<Vec<Tangent>, String> {
        let of = |(model, point): (usize, &Point)| {
            let scenario = self.scenario(model, x)?;
            let cycle = scenario.cycle().map_err(|error| error.to_string())?;
            let (course, free) = scenario.asked_of_orbit(&cycle).map_err(|error| error.to_string())?;
            Tangent::at(&cycle, &course, &free, point).map_err(|failure: Failure| failure.to_string())
        };
        seen.more.points.iter().enumerate().map(of).collect()
    }

    fn gait(
        &self,
        x: &[f64],
        find: impl Fn(usize, &Scenario, &Cycle) -> Result<FoundOrbit, String>,
    ) -> Result<DescentPoint<Gait>, String> {
        let flown = |model: usize| -> Result<FlownOrbit, String> {
            let scenario = self.scenario(model, x)?;
            let cycle = scenario.cycle().map_err(|error| error.to_string())?;
            let found = find(model, &scenario, &cycle)?;
            let broken = |fault: Fault| fault.to_string();
            let measures = measure(&cycle, &found.orbit, &scenario.strip_areas()).map_err(broken)?;
            let multiplier = match self.spec.limits.multiplier {
                Some(_) => floquet(&cycle, &found.orbit).map_err(broken)?.largest(),
                None => f64::NAN,
            };
            let (speed, mass) = (found.orbit.course.speed, scenario.model().mass());
            Ok(FlownOrbit { found, measures, multiplier, speed, mass })
        };
        let flown: Vec<FlownOrbit> = (0..self.documents.len()).map(flown).collect::<Result<_, _>>()?;
        Ok(self.seen(&flown))
    }

    fn seen(&self, flown: &[FlownOrbit]) -> DescentPoint<Gait> {
        let own = &flown[0];
        let least = |flown: &FlownOrbit| flown.measures.least_clearance.unwrap_or(f64::INFINITY);
        let power = |flown: &FlownOrbit| flown.measures.cost.positive_power / flown.mass;
        let asked = &self.spec.limits;
        let shares = [asked.stall_fraction_12, asked.stall_fraction_20];
        let beyond = |flown: &FlownOrbit| {
            let excess = flown.measures.stalled.iter().zip(shares);
            excess.filter_map(|(share, limit)| limit.map(|limit| share - limit)).fold(0.0, f64::max)
        };
        let facts = Facts {
            frequency: 1.0 / own.found.orbit.end.duration,
            speed: own.speed,
            power_per_mass: flown[..self.averaged].iter().map(power).sum::<f64>() / self.averaged as f64,
            stalled: own.measures.stalled,
            clearance: flown.iter().map(least).fold(f64::INFINITY, f64::min),
            multiplier: flown.iter().map(|f| f.multiplier).fold(f64::NAN, f64::max),
            mass: own.mass,
            stalled_beyond: flown.iter().map(beyond).fold(0.0, f64::max),
        };
        let objective = match self.spec.goal {
            Goal::Power => facts.power_per_mass,
            Goal::Frequency => facts.frequency,
            Goal::Payload => -facts.mass,
        };
        let mut limits = Vec::new();
        let mut at_most = |value: f64, limit: Option<f64>, scale: f64| {
            limits.extend(limit.map(|limit| (value - limit) / scale));
        };
        for flown in flown {
            for clearance in flown.measures.clearances.iter().filter(|clearance| clearance.is_finite()) {
                at_most(-clearance, asked.clearance_m.map(|least| -least), CLEARANCE);
            }
            at_most(flown.measures.softly_stalled[0], asked.stall_fraction_12, SHARE);
            at_most(flown.measures.softly_stalled[1], asked.stall_fraction_20, SHARE);
            at_most(flown.multiplier, asked.multiplier, MULTIPLIER);
        }
        at_most(facts.frequency, asked.frequency_hz, facts.frequency);
        at_most(facts.power_per_mass, asked.power_w_kg, facts.power_per_mass);
        let points = flown.iter().map(|flown| flown.found.orbit.point.clone()).collect();
        let more = Gait { points, tangents: Vec::new(), facts };
        DescentPoint { objective: objective / self.scale, limits, more }
    }
}

impl Landscape for Gaits<'_> {
    type More = Gait;

    fn look(&self, x: &[f64], near: &DescentPoint<Gait>) -> Option<DescentPoint<Gait>> {
        self.near(x, near, &near.more.tangents).ok()
    }

    /// Differences of orbits found anew beside this one, on all cores.
    fn slopes(&self, x: &[f64], seen: &mut DescentPoint<Gait>) -> Option<Slopes> {
        seen.more.tangents = self.tangents(x, seen).ok()?;
        let columns: Vec<usize> = (0..x.len()).collect();
        let beside = |_: usize, &i: &usize| {
            let step = if x[i] > 0.5 { -STEP } else { STEP };
            let mut x = x.to_vec();
            x[i] += step;
            let there = self.near(&x, seen, &seen.more.tangents).ok()?;
            let limits = there.limits.iter().zip(&seen.limits).map(|(b, a)| (b - a) / step).collect();
            Some(((there.objective - seen.objective) / step, limits))
        };
        let columns: Vec<(f64, Vec<f64>)> =
            parallel::map(&columns, beside).into_iter().collect::<Option<_>>()?;
        let rows = seen.limits.len();
        Some(Slopes {
            objective: columns.iter().map(|(objective, _)| *objective).collect(),
            limits: (0..rows).map(|j| columns.iter().map(|(_, limits)| limits[j]).collect()).collect(),
        })
    }
}
