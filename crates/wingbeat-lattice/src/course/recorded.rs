//! The courses of a recorded flight: stretches of it, from rest.

use super::{Axes, CourseClock, CourseRequest, LatticeCourse, MovingFlight, Stroke, fitting};
use crate::{Error, FlightStretch, Panels, RecordError, Scene};
use std::sync::Arc;
use wingbeat::aero::Span;
use wingbeat::math::Vec3;
use wingbeat::math::interpolation::piecewise_linear;
use wingbeat::plant::Plant;
use wingbeat::robot::{Observation, SurfaceOutline};
use wingbeat::scenario::{Chosen, Scenario};
use wingbeat::simulate::Record;

/// Cycles of a stretch where none are asked for.
const CYCLES: usize = 3;
/// Way of a stretch without flapping, mean chords a cycle. *Choice.*
const WAY: f64 = 10.0;
/// Instants of a cycle at which joints and tips are looked at.
const LOOKS: std::ops::Range<u32> = 0..48;
/// Swing of a joint from which it strokes, rad.
const SWINGS: f64 = 1e-3;

/// A recorded flight.
pub struct RecordedFlight {
    scenario: Arc<Scenario>,
    record: Record,
    outlines: Vec<SurfaceOutline>,
}

/// A stretch that is looked at.
struct ViewedStretch {
    name: String,
    title: String,
    to_s: f64,
}

impl RecordedFlight {
    /// The columns of a record that are needed.
    pub fn columns(scenario: &Scenario) -> Vec<&str> {
        let robot = scenario.robot();
        let channels = robot.states().iter().chain(robot.inputs()).map(|channel| channel.name.as_str());
        let clearances = robot.clearances().iter().map(|channel| channel.name.as_str());
        let names = ["t", "phase"].into_iter().chain(robot.joint_names()).chain(clearances);
        // A state of a joint may be the joint's own column.
        let mut once: Vec<&str> = names.chain(channels).collect();
        once.sort_unstable();
        once.dedup();
        once
    }

    /// The flight of `scenario` that `record` holds.
    ///
    /// # Errors
    /// A column that is missing; outlines that the robot cannot have.
    pub fn new(scenario: impl Into<Arc<Scenario>>, record: Record) -> Result<Self, Error> {
        let scenario = scenario.into();
        let missing = Self::columns(&scenario).into_iter().find(|name| record.values(name).is_none());
        if let Some(name) = missing {
            return Err(RecordError::Column { name: name.into() }.into());
        }
        let outlines = scenario.spec.robot.outlines()?;
        Ok(Self { scenario, record, outlines })
    }

    /// The scenario that was flown.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    fn column(&self, name: &str) -> &[f64] {
        self.record.values(name).unwrap_or_default()
    }

    /// First and last time of the record, s.
    fn ends(&self) -> (f64, f64) {
        let t = self.column("t");
        (t.first().copied().unwrap_or(0.0), t.last().copied().unwrap_or(0.0))
    }

    /// Whether the gait runs.
    fn flaps(&self) -> bool {
        self.column("phase").windows(2).all(|pair| pair[0] < pair[1])
    }

    /// Time at which `cycles` end at `to_s` begin.
    fn begin(&self, to_s: f64, cycles: usize) -> f64 {
        let (t, phase) = (self.column("t"), self.column("phase"));
        if !self.flaps() {
            let way = WAY * self.chord() * cycles as f64;
            return to_s - way / self.speed(to_s).max(1e-3);
        }
        let at = piecewise_linear(t, phase, to_s) - std::f64::consts::TAU * cycles as f64;
        if at < phase[0] { f64::NEG_INFINITY } else { piecewise_linear(phase, t, at) }
    }

    /// Mean chord of the first surface, m.
    fn chord(&self) -> f64 {
        self.outlines.first().map_or(1.0, |outline| outline.planform.mean_chord())
    }

    /// Speed through the air at `t` s.
    fn speed(&self, t: f64) -> f64 {
        let velocity = ["x", "y", "z"]
            .map(|axis| piecewise_linear(self.column("t"), self.column(&format!("v_WB_W_{axis}")), t));
        (Vec3(velocity) - self.scenario.robot().mean_wind()).norm()
    }

    /// The stretches asked for, or that before the turn and the last of the flight, or that alone.
    fn stretches(&self, asked: &CourseRequest, cycles: usize) -> Vec<ViewedStretch> {
        let at = |to_s: f64| ViewedStretch {
            name: format!("until_{to_s}_s"),
            title: format!("until {to_s} s"),
            to_s,
        };
        if !asked.at.is_empty() {
            return asked.at.iter().map(|to_s| at(*to_s)).collect();
        }
        let (first, last) = self.ends();
        let turn = self.scenario.spec.manoeuvre.as_ref().and_then(Chosen::shipped);
        let starts = turn.filter(|turn| turn.roll_deg != 0.0).map(|turn| turn.turn_start_s);
        match starts.filter(|start| *start < last && self.begin(*start, cycles) >= first) {
            Some(start) => vec![
                ViewedStretch { name: "level".into(), title: "before the turn".into(), to_s: start },
                ViewedStretch { name: "banked".into(), title: "in the turn".into(), to_s: last },
            ],
            None => vec![ViewedStretch { title: "end of the flight".into(), ..at(last) }],
        }
    }

    /// The courses through the stretches that are asked for.
    ///
    /// # Errors
    /// What cannot be asked, stretches that were not recorded, and wings without a lattice.
    pub fn courses(&self, asked: &CourseRequest) -> Result<Vec<LatticeCourse>, Error> {
        let asked = asked.checked()?;
        let cycles = asked.cycles.unwrap_or(CYCLES);
        self.stretches(asked, cycles).iter().map(|s| self.course(asked, s, cycles)).collect()
    }

    fn course(
        &self,
        asked: &CourseRequest,
        stretch: &ViewedStretch,
        cycles: usize,
    ) -> Result<LatticeCourse, Error> {
        let (first, last) = self.ends();
        let from_s = self.begin(stretch.to_s, cycles);
        if from_s < first || stretch.to_s > last {
            let to_s = stretch.to_s;
            return Err(RecordError::Cycles { cycles, to_s, first, last }.into());
        }
        let robot = self.scenario.robot();
        let flight = FlightStretch::new(robot, &self.record, from_s, stretch.to_s)?;
        let flight = Arc::new(flight);
        let frequency_hz = cycles as f64 / (stretch.to_s - from_s);
        let panels = match asked.model {
            true => Panels { chordwise: 1, ..asked.panels() },
            false => asked.panels(),
        };
        let density = self.scenario.spec.air.density_kg_m3;
        let (scene, layouts) = Scene::flown(&flight, &self.outlines, from_s, density, panels)?;
        if asked.model {
            flight.circulations(from_s, &layouts)?;
        }
        let chord = self.chord();
        let way = scene.edge_speed(cycles as f64 / frequency_hz) / frequency_hz;
        let steps = asked.steps.unwrap_or_else(|| fitting(way, chord, asked.chordwise));
        let clock = CourseClock { frequency_hz, cycles, steps };
        asked.check_size(clock)?;
        let begin = stretch.to_s - 1.0 / frequency_hz;
        let through = (flight.body(stretch.to_s).0 - flight.body(begin).0) * frequency_hz - scene.wind;
        let groups =
            (0..self.outlines.len()).filter(|k| self.outlines[*k].planform.span() == Span::Symmetric);
        let of = |k: usize| {
            let first = layouts.iter().take_while(|(number, _)| *number < k).count();
            first..first + layouts.iter().filter(|(number, _)| *number == k).count()
        };
        let mut course = LatticeCourse {
            name: stretch.name.clone(),
            title: stretch.title.clone(),
            stroke: self.stroke(&flight, &clock, begin),
            axes: Axes::new(through),
            chord,
            groups: groups.map(of).collect(),
            symmetric: false,
            past_stall: Some(self.past_stall(&flight, begin, &clock)),
            crosses: self.crosses(from_s, stretch.to_s),
            moved: None,
            critical_suction: asked.critical_suction,
            unheard: Vec::new(),
            flown: Some(MovingFlight { flight, from_s, layouts, by_model: asked.model }),
            scene,
            clock,
        };
        course.symmetric = course.is_symmetric();
        Ok(course)
    }

    /// Whether a clearance is negative between two times.
    fn crosses(&self, from_s: f64, to_s: f64) -> bool {
        let t = self.column("t");
        let within = |name: &str| {
            let rows = t.iter().zip(self.column(name)).filter(|(t, _)| **t >= from_s && **t <= to_s);
            rows.fold(f64::INFINITY, |least, (_, clearance)| least.min(*clearance))
        };
        self.scenario.robot().clearances().iter().any(|channel| within(&channel.name) < 0.0)
    }

    /// The joint that swings most in the cycle from `begin` on, mean of left and right, twists only where nothing else swings; upwards as the
    /// tips of the wings go up with it.
    fn stroke(&self, flight: &FlightStretch, clock: &CourseClock, begin: f64) -> Stroke {
        let t = self.column("t");
        let cycle = |share: f64| begin + share / clock.frequency_hz;
        let at = |name: &str, share: f64| piecewise_linear(t, self.column(name), cycle(share));
        let swing = |name: &str| {
            let values = LOOKS.map(|k| at(name, f64::from(k) / f64::from(LOOKS.end)));
            let (low, high) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            high - low
        };
        let robot = self.scenario.robot();
        let most = |twist: bool| {
            let joints =
                robot.joint_names().enumerate().filter(move |(joint, _)| robot.is_twist(*joint) == twist);
            let most = joints.map(|(_, name)| name).max_by(|a, b| swing(a).total_cmp(&swing(b)));
            most.filter(|name| self.flaps() && swing(name) > SWINGS)
        };
        let Some(left) = most(false).or_else(|| most(true)) else { return Stroke::new(clock, |_| 0.0) };
        let right = left.replace("left", "right");
        let pair =
            [left, right.as_str()].map(|name| if self.record.values(name).is_some() { name } else { left });
        let stroke = |share: f64| pair.iter().map(|name| at(name, share)).sum::<f64>();
        let looks: Vec<[f64; 2]> = LOOKS
            .map(|k| f64::from(k) / f64::from(LOOKS.end))
            .filter_map(|share| Some([stroke(share), tip_height(&flight.observe(cycle(share))?)?]))
            .collect();
        let mean = |i: usize| looks.iter().map(|look| look[i]).sum::<f64>() / looks.len() as f64;
        let means = [mean(0), mean(1)];
        let together: f64 = looks.iter().map(|[stroke, tips]| (stroke - means[0]) * (tips - means[1])).sum();
        let upwards = if together < 0.0 { -1.0 } else { 1.0 };
        Stroke::new(clock, |share| upwards * stroke(share))
    }

    /// Share of strips and instants of the last cycle past the stall angle of their section, by the model that flew.
    fn past_stall(&self, flight: &FlightStretch, begin: f64, clock: &CourseClock) -> f64 {
        let surfaces = self.scenario.robot().surfaces();
        let limits: Vec<Option<f64>> = surfaces
            .flat_map(|(_, aero)| (0..aero.strips()).map(|i| aero.covers(i).then(|| aero.stall_angle())))
            .collect();
        let (mut past, mut all) = (0, 0);
        for k in 0..clock.steps {
            let seen = flight.observe(begin + k as f64 * clock.step_s());
            for (angle, limit) in
                seen.iter().flat_map(|seen| seen.incidence().zip(&limits).collect::<Vec<_>>())
            {
                past += usize::from(limit.is_some_and(|limit| angle.abs() > limit));
                all += usize::from(limit.is_some());
            }
        }
        past as f64 / all.max(1) as f64
    }
}

/// Mean height of the ends of all surfaces above the body's origin, along its z axis, m; none without a surface. Roots, which hardly move,
/// count as well.
fn tip_height(seen: &Observation) -> Option<f64> {
    let ends = seen.outlines.iter().flat_map(|outline| outline.first().into_iter().chain(outline.last()));
    let heights: Vec<f64> = ends.map(|end| end[0][2]).collect();
    (!heights.is_empty()).then(|| heights.iter().sum::<f64>() / heights.len() as f64)
}
