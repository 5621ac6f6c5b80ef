//! Gaits as points of a search: the orbit of each, and what it takes.

use super::descent::{DescentPoint, Landscape, Slopes};
use super::spec::{Goal, SearchSpec};
use crate::sweep::with_all;
use crate::{Document, Scenario};
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use wingbeat_flight::orbit::{
    Cycle, Failure, FoundOrbit, Free, Measures, Point, Tangent, floquet, measure, search_near,
};
use wingbeat_math::parallel;
use wingbeat_ocp::plant::{Fault, Plant};

/// Scales of the limits: what counts as one of a clearance, m, of a share and of a multiplier.
const CLEARANCE: f64 = 0.01;
const SHARE: f64 = 0.1;
const MULTIPLIER: f64 = 0.1;
/// Where in its range, from -1 to 1, a command that is free stops, and what counts as one beyond. *Choice*: an orbit beyond 1 is none.
const HELD: [f64; 2] = [0.95, 0.05];
/// Step of the differences, as a share of a range: orbits close to 1e-11.
const STEP: f64 = 1e-5;
/// How many times as well as the first two of what is free two others lead to the orbits about one before they take their places.
/// *Choice.*
const BETTER: f64 = 2.0;
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
    /// As [`held`] says.
    held: Vec<f64>,
    measures: Measures,
    multiplier: f64,
    speed: f64,
    mass: f64,
}

/// What belongs to a gait.
pub(super) struct Gait {
    /// Shares of the ranges.
    x: Vec<f64>,
    pub points: Vec<Point>,
    /// What is free, `trim.free` of each scenario: the orbits of straight flight are those of the first two.
    pub free: Vec<Vec<String>>,
    /// Where derivatives were asked for.
    tangents: Vec<Tangent>,
    /// The same: derivatives of each orbit's point by the coordinates.
    moves: Vec<Vec<Point>>,
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

    /// The same in which `free` is free.
    fn freeing(&self, model: usize, x: &[f64], free: &[String]) -> Result<Scenario, String> {
        let mut scenario = self.scenario(model, x)?;
        scenario.spec.trim.iter_mut().for_each(|trim| trim.free = free.to_vec());
        Ok(scenario)
    }

    /// The gait at `x`, found as `wingbeat trim` does.
    pub fn first(&mut self, x: &[f64]) -> Result<DescentPoint<Gait>, String> {
        let seen = self.anew(x)?;
        self.scale = seen.objective.abs();
        self.anew(x)
    }

    /// The gait at `x` from its scenario's own start.
    fn anew(&self, x: &[f64]) -> Result<DescentPoint<Gait>, String> {
        let own = |document: &Document| {
            let scenario = Scenario::new(document.clone()).map_err(|error| error.to_string())?;
            Ok::<_, String>(scenario.spec.trim.map_or(Vec::new(), |trim| trim.free))
        };
        let free = self.documents.iter().map(own).collect::<Result<Vec<_>, _>>()?;
        self.gait(x, &free, |_, scenario, cycle| {
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
        self.gait(x, &close.more.free, |model, scenario, cycle| {
            let (course, free) = scenario.asked_of_orbit(cycle).map_err(|error| error.to_string())?;
            let point = close.more.ahead(model, x);
            search_near(cycle, &course, &free, point, &tangents[model]).map_err(|failure| failure.to_string())
        })
    }

    fn tangents(&self, x: &[f64], seen: &DescentPoint<Gait>) -> Result<Vec<Tangent>, String> {
        let of = |(model, point): (usize, &Point)| {
            let scenario = self.freeing(model, x, &seen.more.free[model])?;
            let cycle = scenario.cycle().map_err(|error| error.to_string())?;
            let (course, free) = scenario.asked_of_orbit(&cycle).map_err(|error| error.to_string())?;
            Tangent::at(&cycle, &course, &free, point).map_err(|failure: Failure| failure.to_string())
        };
        seen.more.points.iter().enumerate().map(of).collect()
    }

    /// What is free for the gaits about the one at `x`.
    fn steadiest(&self, x: &[f64], seen: &DescentPoint<Gait>) -> Result<Vec<Vec<String>>, String> {
        let of = |(model, point): (usize, &Point)| {
            let scenario = self.freeing(model, x, &seen.more.free[model])?;
            let cycle = scenario.cycle().map_err(|error| error.to_string())?;
            let mut trim = scenario.trim_spec().map_err(|error| error.to_string())?.clone();
            trim.frees_the_steadiest(&scenario, &cycle, point, BETTER)?;
            Ok(trim.free)
        };
        seen.more.points.iter().enumerate().map(of).collect()
    }

    fn gait(
        &self,
        x: &[f64],
        all_free: &[Vec<String>],
        find: impl Fn(usize, &Scenario, &Cycle) -> Result<FoundOrbit, String>,
    ) -> Result<DescentPoint<Gait>, String> {
        let flown = |model: usize| -> Result<FlownOrbit, String> {
            let scenario = self.freeing(model, x, &all_free[model])?;
            let cycle = scenario.cycle().map_err(|error| error.to_string())?;
            let found = find(model, &scenario, &cycle)?;
            let broken = |fault: Fault| fault.to_string();
            let measures = measure(&cycle, &found.orbit, &scenario.strip_areas()).map_err(broken)?;
            let multiplier = match self.spec.limits.multiplier {
                Some(_) => floquet(&cycle, &found.orbit).map_err(broken)?.largest(),
                None => f64::NAN,
            };
            let held = held(&scenario, &cycle, &found.orbit.point);
            let (speed, mass) = (found.orbit.course.speed, scenario.model().mass());
            Ok(FlownOrbit { found, held, measures, multiplier, speed, mass })
        };
        let flown: Vec<FlownOrbit> = (0..self.documents.len()).map(flown).collect::<Result<_, _>>()?;
        Ok(self.seen(x, all_free, &flown))
    }

    fn seen(&self, x: &[f64], free: &[Vec<String>], flown: &[FlownOrbit]) -> DescentPoint<Gait> {
        let own = &flown[0];
        let least = |flown: &FlownOrbit| flown.measures.least_clearance.unwrap_or(f64::INFINITY);
        let power = |flown: &FlownOrbit| flown.measures.cost.positive_power / flown.mass;
        let asked = &self.spec.limits;
        let shares = [asked.stall_fraction_12, asked.stall_fraction_20];
        let beyond = |flown: &FlownOrbit| {
            let excess = flown.measures.stall.sharp.iter().zip(shares);
            excess.filter_map(|(share, limit)| limit.map(|limit| share - limit)).fold(0.0, f64::max)
        };
        let facts = Facts {
            frequency: 1.0 / own.found.orbit.end.duration,
            speed: own.speed,
            power_per_mass: flown[..self.averaged].iter().map(power).sum::<f64>() / self.averaged as f64,
            stalled: own.measures.stall.sharp,
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
            at_most(flown.measures.stall.soft[0], asked.stall_fraction_12, SHARE);
            at_most(flown.measures.stall.soft[1], asked.stall_fraction_20, SHARE);
            at_most(flown.multiplier, asked.multiplier, MULTIPLIER);
            for held in &flown.held {
                at_most(*held, Some(HELD[0]), HELD[1]);
                at_most(-held, Some(HELD[0]), HELD[1]);
            }
        }
        at_most(facts.frequency, asked.frequency_hz, facts.frequency);
        at_most(facts.power_per_mass, asked.power_w_kg, facts.power_per_mass);
        let points = flown.iter().map(|flown| flown.found.orbit.point.clone()).collect();
        let (x, free) = (x.to_vec(), free.to_vec());
        let more = Gait { x, points, free, tangents: Vec::new(), moves: Vec::new(), facts };
        DescentPoint { objective: objective / self.scale, limits, more }
    }
}

impl Gait {
    /// Where the orbit of `model` is at the shares `x` of the ranges, to first order where derivatives are known.
    fn ahead(&self, model: usize, x: &[f64]) -> Point {
        let mut point = self.points[model].clone();
        for (moves, (to, from)) in self.moves.iter().zip(x.iter().zip(&self.x)) {
            add(&mut point, &moves[model], to - from);
        }
        point
    }
}

/// Where the commands that `[trim]` may free lie in their ranges, from -1 to 1, in the order of the inputs.
fn held(scenario: &Scenario, cycle: &Cycle, point: &Point) -> Vec<f64> {
    let (model, trim) = (scenario.model(), scenario.spec.trim.as_ref());
    let coupled = trim.is_some_and(|trim| cycle.coupled(&trim.course()));
    let names = trim.map_or(&[][..], |trim| &trim.free);
    let free = names.iter().filter_map(|name| Free::named(model, name, coupled)).flatten();
    let inputs: BTreeSet<usize> = free
        .filter_map(|free| match free {
            Free::Inputs(direction) => direction.first().map(|(input, _)| *input),
            Free::Frequency => None,
        })
        .collect();
    let share = |&input: &usize| {
        let channel = &model.inputs()[input];
        (point.inputs[input] - 0.5 * (channel.low + channel.high)) / (0.5 * (channel.high - channel.low))
    };
    inputs.iter().map(share).filter(|share| share.is_finite()).collect()
}

/// `point` and `share` times `other`.
fn add(point: &mut Point, other: &Point, share: f64) {
    point.z.iter_mut().zip(&other.z).for_each(|(a, b)| *a += share * b);
    point.pace += share * other.pace;
    point.inputs.iter_mut().zip(&other.inputs).for_each(|(a, b)| *a += share * b);
}

impl Landscape for Gaits<'_> {
    type More = Gait;

    fn look(&self, x: &[f64], near: &DescentPoint<Gait>) -> Option<DescentPoint<Gait>> {
        self.near(x, near, &near.more.tangents).ok()
    }

    /// Differences of orbits found anew beside this one, on all cores.
    fn slopes(&self, x: &[f64], seen: &mut DescentPoint<Gait>) -> Option<Slopes> {
        seen.more.moves.clear();
        seen.more.free = self.steadiest(x, seen).ok()?;
        seen.more.tangents = self.tangents(x, seen).ok()?;
        let columns: Vec<usize> = (0..x.len()).collect();
        let beside = |_: usize, &i: &usize| {
            let inwards = if x[i] > 0.5 { -STEP } else { STEP };
            // Where there is no orbit on one side, there may be one on the other.
            let sides = [inwards, -inwards].into_iter().filter(|step| (0.0..=1.0).contains(&(x[i] + step)));
            let (step, there) = sides.into_iter().find_map(|step| {
                let mut x = x.to_vec();
                x[i] += step;
                Some((step, self.near(&x, seen, &seen.more.tangents).ok()?))
            })?;
            let limits = there.limits.iter().zip(&seen.limits).map(|(b, a)| (b - a) / step).collect();
            let change = |(there, here): (&Point, &Point)| {
                let mut zero =
                    Point { z: vec![0.0; here.z.len()], pace: 0.0, inputs: vec![0.0; here.inputs.len()] };
                add(&mut zero, there, 1.0 / step);
                add(&mut zero, here, -1.0 / step);
                zero
            };
            let moves: Vec<Point> = there.more.points.iter().zip(&seen.more.points).map(change).collect();
            Some(((there.objective - seen.objective) / step, limits, moves))
        };
        let columns: Vec<(f64, Vec<f64>, Vec<Point>)> =
            parallel::map(&columns, beside).into_iter().collect::<Option<_>>()?;
        let rows = seen.limits.len();
        let slopes = Slopes {
            objective: columns.iter().map(|(objective, ..)| *objective).collect(),
            limits: (0..rows).map(|j| columns.iter().map(|(_, limits, _)| limits[j]).collect()).collect(),
        };
        seen.more.moves = columns.into_iter().map(|(.., moves)| moves).collect();
        Some(slopes)
    }
}
