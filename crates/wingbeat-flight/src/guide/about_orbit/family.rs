//! Orbits along the legs of a flight, as references, and the feedback about them.

use super::adapt::CrankTangent;
use super::dive::{Dive, Level};
use super::feedback::{CostToGo, Feedback, MeanPath, OFF_PATH};
use super::landing::{Approach, Landing, LandingSpec};
use super::plan_shape::ShapeSource;
use super::predictive::PredictiveSpec;
use super::schedule::{CourseSchedule, Stretch, StretchPlace};
use super::spec::AboutOrbitSpec;
use crate::guide::controllers::SearchWatch;
use crate::orbit::{
    Course, Cycle, Deviations, Direction, Failure, FoundOrbit, Free, OrbitSection, Point, intervals_along,
    search, search_from,
};
use nalgebra::DMatrix;
use std::ops::ControlFlow;
use wingbeat_math::Error;
use wingbeat_math::interpolation::lerp;
use wingbeat_math::parallel;
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_robot::Perch;

/// Largest steps from orbit to orbit: of the bank, rad, of speed and climb, m/s.
const BANK_STEP: f64 = 0.05;
const SPEED_STEP: f64 = 0.1;
/// Orbits from one whose feedback is made to the next.
const SPARSE: usize = 6;
/// Guesses of the mean pitch, rad, one after another until there is an orbit.
const PITCHES: [f64; 4] = [-0.2, 0.0, -0.4, -0.1];

/// An orbit as a reference: what may deviate, at every step of a cycle, and the commands held. Heights are those above
/// the mean path.
pub(super) struct OrbitReference {
    pub steps: Vec<Vec<f64>>,
    /// How far it is off its mean path over the ground at every step.
    off_path: Vec<[f64; OFF_PATH]>,
    pub commands: Vec<f64>,
    /// Its period, s.
    period: f64,
}

/// What is asked at a phase.
#[derive(Clone, Debug)]
pub(super) struct Asked {
    /// What may deviate.
    pub numbers: Vec<f64>,
    pub commands: Vec<f64>,
    /// Off the mean path: ahead, to its left, m, heading, rad.
    pub off_path: [f64; OFF_PATH],
}

/// The references of a stretch in its order, and the shares of it at which there is feedback.
struct StretchOrder {
    references: Vec<usize>,
    feedback: Vec<(f64, usize)>,
}

/// Orbits and feedback.
pub(super) struct ReferenceFamily {
    references: Vec<OrbitReference>,
    feedback: Vec<Feedback>,
    ways: Vec<StretchOrder>,
    /// How the first orbit changes with the rate of the crank, where the controller adapts it.
    tangent: Option<CrankTangent>,
    /// State at phase 0 of the first orbit.
    start: Vec<f64>,
    /// The dive out of it.
    dive: Option<Dive>,
    /// The landing out of it.
    landing: Option<Landing>,
}

/// Two of a list and how far from the one to the other.
struct Between(usize, usize, f64);

/// What is found of the ways before the references are made.
struct Search<'a> {
    cycle: &'a Cycle<'a>,
    straight: Vec<Free>,
    turning: Vec<Free>,
    found: Vec<FoundOrbit>,
    ways: Vec<Vec<usize>>,
    /// Number of all that are asked, and who is told of each.
    all: usize,
    watch: &'a SearchWatch,
}

/// Number of orbits from one end of a stretch to the other.
fn orbits_along(Stretch { from, to, .. }: &Stretch) -> usize {
    let steps = [
        (to.bank - from.bank).abs() / BANK_STEP,
        (to.speed - from.speed).abs() / SPEED_STEP,
        (to.climb - from.climb).abs() / SPEED_STEP,
    ];
    steps.into_iter().fold(1.0, f64::max).ceil() as usize
}

impl Search<'_> {
    /// The first orbit, in straight flight.
    fn first(&mut self, course: &Course) -> Result<(), Failure> {
        let robot = self.cycle.robot();
        let joints = robot.start_coordinates();
        let mut found = Err(Failure::Stopped);
        for pitch in PITCHES {
            let mut z = vec![0.0; self.cycle.section().len()];
            (z[OrbitSection::VELOCITY.start], z[OrbitSection::PITCH]) = (course.speed, pitch);
            z[OrbitSection::BODY..][..joints.len()].copy_from_slice(&joints);
            let guess = Point { z, pace: 1.0, inputs: vec![0.0; robot.inputs().len()] };
            let next = search(self.cycle, course, self.free(course), guess, &mut go_on);
            let done = next.is_ok();
            found = if done || pitch == PITCHES[0] { next } else { found };
            if done {
                break;
            }
        }
        self.take(found?)?;
        Ok(())
    }

    /// What is free along `course`.
    fn free(&self, course: &Course) -> &[Free] {
        if self.cycle.coupled(course) { &self.turning } else { &self.straight }
    }

    /// The orbits along `stretch`, from the last that was found.
    fn along(&mut self, schedule: &CourseSchedule, stretch: &Stretch) -> Result<(), Failure> {
        if let Some(back) = schedule.back(stretch).filter(|&back| back < self.ways.len()) {
            let way = self.ways[back].iter().rev().copied().collect();
            self.ways.push(way);
            return Ok(());
        }
        let last = self.ways.last().filter(|_| !schedule.fan);
        let begin = last.map_or(0, |way| way[way.len() - 1]);
        let (from, to) = (stretch.from, stretch.to);
        let count = orbits_along(stretch);
        let mut way = vec![begin];
        for k in 1..=count {
            let share = k as f64 / count as f64;
            let course = Course {
                speed: lerp(from.speed, to.speed, share),
                climb: lerp(from.climb, to.climb, share),
                bank: lerp(from.bank, to.bank, share),
            };
            let free = self.free(&course);
            let last = &self.found[way[k - 1]].orbit.point;
            // The secant of the last two orbits predicts the next; the first step out of straight flight has none.
            let before = (k > 1).then(|| &self.found[way[k - 2]].orbit.point);
            let guess = before.map_or_else(|| last.clone(), |before| last.beyond(before, 1.0));
            let next = search_from(self.cycle, &course, free, guess, &mut go_on)
                .or_else(|_| search_from(self.cycle, &course, free, last.clone(), &mut go_on))?;
            way.push(self.take(next)?);
        }
        self.ways.push(way);
        Ok(())
    }

    /// Keeps an orbit whose crank can be paced.
    fn take(&mut self, found: FoundOrbit) -> Result<usize, Failure> {
        if let Some((input, value)) = self.cycle.pacing(found.orbit.point.pace) {
            let channel = &self.cycle.robot().inputs()[input];
            let (low, high) = (channel.low, channel.high);
            if !(value >= low && value <= high) {
                let (name, unit) = (channel.name.clone(), channel.unit);
                return Err(Failure::Range { name, value, unit, low, high });
            }
        }
        self.found.push(found);
        self.watch.see(self.found.len(), self.all);
        Ok(self.found.len() - 1)
    }
}

fn go_on(_: usize, _: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

impl ReferenceFamily {
    /// Orbits along `schedule`, and feedback by `inputs` about every few of them; a landing ends at the `perch`. `watch` sees each
    /// orbit.
    pub fn new(
        spec: &AboutOrbitSpec,
        cycle: &Cycle,
        schedule: &CourseSchedule,
        (inputs, perch): (&[usize], Option<&Perch>),
        watch: &SearchWatch,
    ) -> Result<Self, Error> {
        let robot = cycle.robot();
        let fresh = schedule.stretches.iter().enumerate();
        let fresh = fresh.filter(|(i, stretch)| schedule.back(stretch).is_none_or(|back| back >= *i));
        let all = 1 + fresh.map(|(_, stretch)| orbits_along(stretch)).sum::<usize>();
        let (straight, turning) = (spec.free(robot, false)?, spec.free(robot, true)?);
        let mut search = Search { cycle, straight, turning, found: Vec::new(), ways: Vec::new(), all, watch };
        let none = |key: &str| {
            let key = key.to_string();
            move |failure: Failure| {
                Error::invalid(key, failure, "a flight of which the gait has an orbit, with what is free")
            }
        };
        search.first(&schedule.first).map_err(none("speed_m_s"))?;
        for (i, stretch) in schedule.stretches.iter().enumerate() {
            search.along(schedule, stretch).map_err(none(&format!("legs[{i}]")))?;
        }
        let Search { found, ways, .. } = search;
        let broken = |fault: Fault| Error::invalid("", fault, "orbits that can be flown");
        let deviations = Deviations::new(cycle);
        let references = found.iter().map(|found| OrbitReference::new(cycle, &deviations, found));
        let references = references.collect::<Result<Vec<_>, _>>().map_err(broken)?;
        let adapted = spec.adapt.filter(|adapt| adapt.crank_s.is_some());
        let tangent = adapted.map(|_| {
            let straight = spec.free(robot, false)?;
            CrankTangent::new(cycle, &straight, &found[0], &references[0]).map_err(none("adapt.crank_s"))
        });
        let tangent = tangent.transpose()?;
        let mut about: Vec<usize> = ways.iter().flat_map(|way| sparse(way).map(|(_, orbit)| orbit)).collect();
        about.push(0);
        about.sort_unstable();
        about.dedup();
        let learned = spec.adapt.and_then(|adapt| adapt.learned());
        let limits: Vec<f64> = inputs.iter().map(|i| robot.inputs()[*i].high).collect();
        let made = parallel::map(&about, |_, &orbit| {
            let orbit = &found[orbit].orbit;
            let intervals = intervals_along(cycle, &orbit.point, cycle.parts(), inputs)?;
            let coordinates = cycle.section().len();
            let path = spec.predictive.as_ref().and_then(PredictiveSpec::path);
            Ok(Feedback::new(
                &spec.weights,
                path,
                &intervals,
                coordinates,
                &limits,
                orbit.end.duration,
                learned,
            ))
        });
        let missing = || Error::invalid("weights", "given", "weights with which the feedback settles");
        let feedback = made
            .into_iter()
            .map(|made| made.map_err(broken).and_then(|feedback| feedback.ok_or_else(missing)))
            .collect::<Result<Vec<_>, _>>()?;
        let place = |orbit: usize| about.partition_point(|other| *other < orbit);
        let ways = ways.iter().map(|way| StretchOrder {
            references: way.clone(),
            feedback: sparse(way).map(|(share, orbit)| (share, place(orbit))).collect(),
        });
        let point = &found[0].orbit.point;
        let dive = spec.dive.as_ref().map(|dive| {
            if !cycle.section().alike() {
                return Err(Error::invalid("", "given", "none: left and right of the robot differ"));
            }
            let pairs = spec.free.iter().filter_map(|name| Free::named(robot, name, false)).flatten();
            let pairs = pairs.filter_map(|free| match free {
                Free::Inputs(direction) => Some(direction),
                Free::Frequency => None,
            });
            let pairs: Vec<Direction> = pairs.collect();
            let level = Level {
                cycle,
                deviations: &deviations,
                point,
                begin: &references[0].steps[0],
                feedback: &feedback[place(0)],
                weights: &spec.weights,
                pairs: &pairs,
                inputs,
            };
            Dive::plan(dive, &level, robot.inputs())
        });
        let dive = dive.transpose().map_err(|e| e.within("dive"))?;
        let landing = spec.landing.as_ref().zip(perch).map(|(landing, perch)| {
            Self::landing_by(landing, spec, (cycle, point), (inputs, perch)).map_err(|e| e.within("landing"))
        });
        let landing = landing.transpose()?;
        let (start, ways) = (cycle.start(point), ways.collect());
        Ok(Self { references, feedback, ways, tangent, start, dive, landing })
    }

    /// The landing out of the orbit at `point`, by what is free; the rate of the crank is commanded as the others are.
    fn landing_by(
        landing: &LandingSpec,
        spec: &AboutOrbitSpec,
        (cycle, point): (&Cycle, &Point),
        (inputs, perch): (&[usize], &Perch),
    ) -> Result<Landing, Error> {
        let robot = cycle.robot();
        if !cycle.section().alike() {
            return Err(Error::invalid("", "given", "none: left and right of the robot differ"));
        }
        let (mut pairs, mut inputs) = (Vec::new(), inputs.to_vec());
        for free in spec.free.iter().filter_map(|name| Free::named(robot, name, false)).flatten() {
            match (free, robot.pacer()) {
                (Free::Inputs(direction), _) => pairs.push(direction),
                (Free::Frequency, Some(pacer)) => {
                    pairs.push(vec![(pacer.input, 1.0)]);
                    inputs.push(pacer.input);
                }
                (Free::Frequency, None) => {}
            }
        }
        if point.pace != 1.0 {
            let allowed = "stroke, twist or another actuator before frequency: the orbit has the gait's own";
            return Err(Error::invalid("", "given", allowed));
        }
        Landing::plan(landing, &Approach { cycle, point, pairs: &pairs, inputs: &inputs, perch })
    }

    /// The landing out of the first orbit.
    pub fn landing(&self) -> Option<&Landing> {
        self.landing.as_ref()
    }

    /// The dive out of the first orbit.
    pub fn dive(&self) -> Option<&Dive> {
        self.dive.as_ref()
    }

    /// The state at phase 0 of the orbit of the begin, in the units of its channels.
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// The reference at `place` and the phase `cycles` of the gait, in cycles.
    pub fn asked(&self, place: Option<StretchPlace>, cycles: f64) -> Asked {
        let Between(one, other, between) = self.between(place);
        let (one, other) = (&self.references[one], &self.references[other]);
        let step = cycles.rem_euclid(1.0) * (one.steps.len() - 1) as f64;
        let i = (step as usize).min(one.steps.len() - 2);
        let share = step - i as f64;
        let at = |orbit: &OrbitReference, j: usize| lerp(orbit.steps[i][j], orbit.steps[i + 1][j], share);
        let off =
            |orbit: &OrbitReference, j: usize| lerp(orbit.off_path[i][j], orbit.off_path[i + 1][j], share);
        let numbers = (0..one.steps[0].len()).map(|j| lerp(at(one, j), at(other, j), between)).collect();
        let commands = one.commands.iter().zip(&other.commands).map(|(a, b)| lerp(*a, *b, between)).collect();
        Asked {
            numbers,
            commands,
            off_path: std::array::from_fn(|j| lerp(off(one, j), off(other, j), between)),
        }
    }

    /// Adds what `sources` say to `row`, at `place` and the phase `cycles` of the gait, which grows by `pace` cycles per s: numbers of the
    /// orbit, linear between its steps; those that are rates grow with that of the phase, and rates of numbers are central differences.
    ///
    /// Equation: guide.plan_shape
    /// `s(t) = s_orbit(phase), s' = p s'_orbit(phase), p = T phase'; rate of x: [x(phase + d) - x(phase - d)]/(2 d) phase', d a step of the orbit`
    /// Source: choice: the deviation of the structure from its orbit is left out.
    /// Test: `a_plan_may_take_the_shape_of_the_wings_from_the_orbit`.
    pub fn shape(
        &self,
        place: Option<StretchPlace>,
        [cycles, pace]: [f64; 2],
        sources: &[ShapeSource],
        row: &mut Vec<f64>,
    ) {
        let Between(one, other, between) = self.between(place);
        let orbits = [&self.references[one].steps, &self.references[other].steps];
        let count = orbits[0].len() - 1;
        let at = |number: usize, by: f64| {
            let step = (cycles * count as f64 + by).rem_euclid(count as f64);
            let i = (step as usize).min(count - 1);
            let of = |orbit: &[Vec<f64>]| lerp(orbit[i][number], orbit[i + 1][number], step - i as f64);
            lerp(of(orbits[0]), of(orbits[1]), between)
        };
        let period = lerp(self.references[one].period, self.references[other].period, between);
        row.extend(sources.iter().map(|&ShapeSource { number, is_rate, of_rate }| {
            let scale = if of_rate { period * pace } else { 1.0 };
            scale
                * match is_rate {
                    true => (at(number, 1.0) - at(number, -1.0)) * (0.5 * count as f64 * pace),
                    false => at(number, 0.0),
                }
        }));
    }

    /// How the first orbit changes with the rate of the crank.
    pub fn tangent(&self) -> Option<&CrankTangent> {
        self.tangent.as_ref()
    }

    /// Changes `commands` to those of an orbit whose crank turns by `added` rad/s faster.
    pub fn beside(&self, added: f64, commands: &mut [f64]) {
        let change = self.tangent.iter().flat_map(|tangent| &tangent.commands);
        commands.iter_mut().zip(change).for_each(|(command, change)| *command += added * change);
    }

    /// Changes what is asked of the `numbers` that deviate likewise.
    pub fn deviate(&self, added: f64, cycles: f64, numbers: &mut [f64]) {
        let Some(tangent) = &self.tangent else { return };
        let step = cycles.rem_euclid(1.0) * (tangent.steps.len() - 1) as f64;
        let i = (step as usize).min(tangent.steps.len() - 2);
        let (one, other) = (&tangent.steps[i], &tangent.steps[i + 1]);
        for (j, number) in numbers.iter_mut().enumerate() {
            *number += added * lerp(one[j], other[j], step - i as f64);
        }
    }

    /// Commands for what the model is learned to miss, by its waves, in the units of commands over those of accelerations.
    pub fn ahead(&self, place: Option<StretchPlace>, cycles: f64) -> Option<DMatrix<f64>> {
        match self.made(place) {
            (one, None) => one.ahead(cycles),
            (one, Some((other, share))) => {
                Some(one.ahead(cycles)? * (1.0 - share) + other.ahead(cycles)? * share)
            }
        }
    }

    /// The orbits on both sides of `place`.
    fn between(&self, place: Option<StretchPlace>) -> Between {
        let Some(StretchPlace { stretch, share }) = place else { return Between(0, 0, 0.0) };
        let way = &self.ways[stretch].references;
        let at = share * (way.len() - 1) as f64;
        let k = (at as usize).min(way.len() - 2);
        Between(way[k], way[k + 1], at - k as f64)
    }

    /// The feedback there, in the units of commands over those of deviations, linear between the orbits about which it was
    /// made.
    pub fn gain(&self, place: Option<StretchPlace>, cycles: f64) -> DMatrix<f64> {
        match self.made(place) {
            (one, None) => one.at(cycles),
            (one, Some((other, share))) => one.at(cycles) * (1.0 - share) + other.at(cycles) * share,
        }
    }

    /// The cost of a change of the commands there, dimensionless over their units squared, linear between the orbits.
    pub fn hessian(&self, place: Option<StretchPlace>, cycles: f64) -> DMatrix<f64> {
        match self.made(place) {
            (one, None) => one.hessian(cycles),
            (one, Some((other, share))) => {
                one.hessian(cycles) * (1.0 - share) + other.hessian(cycles) * share
            }
        }
    }

    /// The cost, dimensionless, of deviations from there on, linear between the orbits.
    pub fn cost(&self, place: Option<StretchPlace>, cycles: f64) -> CostToGo {
        match self.made(place) {
            (one, None) => one.cost(cycles),
            (one, Some((other, share))) => one.cost(cycles).towards(other.cost(cycles), share),
        }
    }

    /// Feedback about an orbit at `place`, or before it and after it with how far it is from the one to the other.
    fn made(&self, place: Option<StretchPlace>) -> (&Feedback, Option<(&Feedback, f64)>) {
        let Some(StretchPlace { stretch, share }) = place else { return (&self.feedback[0], None) };
        let made = &self.ways[stretch].feedback;
        let k = made.partition_point(|(at, _)| *at <= share).clamp(1, made.len() - 1);
        let ((from, one), (to, other)) = (made[k - 1], made[k]);
        (&self.feedback[one], Some((&self.feedback[other], (share - from) / (to - from))))
    }
}

/// Every few orbits of a way, the first and the last too, with their shares of it.
fn sparse(way: &[usize]) -> impl Iterator<Item = (f64, usize)> {
    let steps = way.len() - 1;
    let parts = steps.div_ceil(SPARSE);
    (0..=parts).map(move |i| {
        let k = i * steps / parts;
        (k as f64 / steps as f64, way[k])
    })
}

impl OrbitReference {
    pub fn new(cycle: &Cycle, deviations: &Deviations, found: &FoundOrbit) -> Result<Self, Fault> {
        let (point, climb) = (&found.orbit.point, found.orbit.course.climb);
        let (mut steps, mut ground) = (Vec::with_capacity(cycle.steps() + 1), Vec::new());
        let mut add = |t: f64, x: &[f64]| {
            let mut s = vec![0.0; deviations.len()];
            let (heading, place) = (deviations.of(x, &mut s), deviations.position());
            ground.push([x[place], x[place + 1], heading]);
            s[Deviations::HEIGHT] -= climb * t;
            steps.push(s);
        };
        add(0.0, &cycle.start(point));
        cycle.fly(&point.z, point.pace, &point.inputs, |_, t, x| {
            add(t, x);
            Ok(())
        })?;
        let mut commands = point.inputs.clone();
        if let Some((input, value)) = cycle.pacing(point.pace) {
            commands[input] = value;
        }
        Ok(Self { steps, off_path: MeanPath::new(&ground).off, commands, period: found.orbit.end.duration })
    }
}
