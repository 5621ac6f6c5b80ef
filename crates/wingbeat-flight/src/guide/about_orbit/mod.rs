//! Flight about orbits: references by the phase of the gait, and periodic feedback.

mod adapt;
mod ahead;
mod ddp;
mod dive;
mod family;
mod feedback;
mod gains;
mod governor;
mod landing;
mod plan_shape;
mod predictive;
mod schedule;
mod spec;
mod tracking;

pub use adapt::AdaptSpec;
pub use dive::DiveSpec;
pub use gains::{HoldingGains, gains_of, holding_inputs};
pub use landing::LandingSpec;
pub use plan_shape::PlanStructure;
pub use predictive::{PredictiveSpec, Terminal};
pub use spec::{AboutOrbitSpec, LegSpec, ORBIT_STEP, OrbitWeights};
pub use tracking::TrackingSpec;

use super::controllers::{ControllerSpec, ControllerTask, Prepared};
use super::inertial;
use super::receding;
use crate::orbit::{Deviations, Free};
use crate::simulate::{Column, Controller, Estimator, Measurement, Update};
use adapt::Adaptation;
use ahead::Ahead;
use family::{Asked, ReferenceFamily};
use feedback::{DEVIATIONS, INTEGRAL, effort};
use governor::Governor;
use landing::{Airs, Begun, Landing};
use nalgebra::DVector;
use predictive::{Height, Predictive};
use schedule::{CourseSchedule, StretchPlace};
use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::Instant;
use tracking::{Demand, PathTracking};
use wingbeat_math::Error;
use wingbeat_math::Vec3;
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_robot::{Perch, Robot};

/// Largest height off at which the integral of the height grows, m.
const INTEGRATED: f64 = 0.1;

/// The controller.
struct AboutOrbit<'a> {
    robot: &'a Robot,
    period: f64,
    deviations: Deviations,
    schedule: CourseSchedule,
    family: Arc<ReferenceFamily>,
    /// The path, where one is followed.
    tracking: Option<PathTracking>,
    /// Numbers of the inputs that are fed back.
    inputs: Vec<usize>,
    /// The plan, where commands are planned.
    predictive: Option<Predictive<'a>>,
    /// What is learned in flight, where the controller adapts.
    adaptation: Option<Adaptation<'a>>,
    /// What keeps to a clearance, where one is kept.
    governor: Option<Governor<'a>>,
    estimator: Box<dyn Estimator + 'a>,
    /// The state as it is known.
    x: Vec<f64>,
    /// Integral of the height's deviation, m s.
    integral: f64,
    held: Vec<f64>,
    /// Cycles at which the dive begins, once it is commanded.
    dives: Option<f64>,
    /// The perch to land on, and the landing once it has begun.
    perch: Option<Perch>,
    lands: Option<Begun>,
    /// Which law of lift holds, where the landing is planned under several.
    airs: Option<Airs>,
    /// What the last update found: legs done, deviations of height, roll and pitch, share of the dive or landing, how
    /// far ahead of the landing's plan, how far other laws than the one that is known are taken to hold.
    seen: [f64; 7],
    /// Height (m), roll and pitch (rad) that were asked then.
    asked: [f64; 4],
}

impl ControllerSpec for AboutOrbitSpec {
    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn check(&self, task: ControllerTask) -> Result<(), Error> {
        self.checked(task.model)?;
        self.tracked(&task)?;
        if self.landing.is_some() && task.perch.is_none() {
            let allowed = "none without [perch], on which it lands";
            return Err(Error::invalid("landing", "given", allowed).against(["perch"]));
        }
        if self.predictive.is_some() && task.solver.is_some() {
            let allowed = "none beside [controller.orbit.predictive], which has the shipped solver";
            return Err(Error::invalid("solver", "given", allowed));
        }
        match &self.estimator {
            Some(estimator) => estimator.check(task.sensors.as_ref()).map_err(|e| e.within("estimator")),
            None => Ok(()),
        }
    }

    fn begins(&self) -> Vec<(String, f64)> {
        let legs = self.legs.iter().enumerate();
        legs.map(|(i, leg)| (format!("legs[{i}].start_s"), leg.start_s)).collect()
    }

    fn follows_path(&self) -> bool {
        self.tracking.is_some()
    }

    fn reads_instruments(&self) -> bool {
        self.estimator.is_some()
    }

    fn prepare(&self, task: ControllerTask) -> Result<Option<Prepared>, Error> {
        let (cycle, schedule) = self.checked(task.model)?;
        let family = ReferenceFamily::new(
            self,
            &cycle,
            &schedule,
            (&self.inputs(task.model)?, task.perch.as_ref()),
            &task.watch,
        )?;
        Ok(Some(Arc::new(family)))
    }

    fn build<'a>(&self, task: ControllerTask<'a>) -> Result<Box<dyn Controller + 'a>, Error> {
        let robot = task.model;
        let (cycle, schedule) = self.checked(robot)?;
        let tracking = self.tracked(&task)?;
        let inputs = self.inputs(robot)?;
        let family = match task.prepared.and_then(|prepared| prepared.downcast().ok()) {
            Some(family) => family,
            None => Arc::new(ReferenceFamily::new(
                self,
                &cycle,
                &schedule,
                (&inputs, task.perch.as_ref()),
                &task.watch,
            )?),
        };
        let deviations = Deviations::new(&cycle);
        let predictive = self.predictive.as_ref().map(|spec| {
            let made = Predictive::new(robot, &deviations, &inputs, spec, &self.weights, &family);
            made.map_err(|e| e.within("predictive"))
        });
        let adaptation = self.adapt.map(|spec| Adaptation::new(spec, robot, self.period_s, &deviations));
        let governor = self.clearance_m.map(|least| Governor::new(robot, least, &inputs, self.period_s));
        let Asked { commands: held, .. } = family.asked(None, 0.0);
        let airs = family.landing().and_then(Landing::airs);
        let estimator: Box<dyn Estimator + 'a> = match &self.estimator {
            None => Box::new(Ahead::new(robot)),
            Some(spec) => {
                let sensors = task.sensors.unwrap_or_default();
                spec.check(Some(&sensors)).map_err(|e| e.within("estimator"))?;
                let start = family.start().to_vec();
                let filter = inertial::filter(*spec, &sensors, robot, cycle.section(), start, &held);
                filter.map_err(|e| e.within("estimator"))?
            }
        };
        Ok(Box::new(AboutOrbit {
            robot,
            period: self.period_s,
            deviations,
            schedule,
            family,
            tracking,
            inputs,
            predictive: predictive.transpose()?,
            adaptation,
            governor,
            estimator,
            x: vec![0.0; robot.states().len()],
            integral: 0.0,
            held,
            dives: None,
            perch: task.perch,
            lands: None,
            airs,
            seen: [0.0; 7],
            asked: [0.0; 4],
        }))
    }
}

impl AboutOrbitSpec {
    /// The path of `task` as it is to be followed, if it is.
    fn tracked(&self, task: &ControllerTask) -> Result<Option<PathTracking>, Error> {
        let Some(spec) = self.tracking else { return Ok(None) };
        let path = spec.checked(task.path.as_ref(), self.speed_m_s).map_err(|e| e.within("tracking"))?;
        let planned = self.predictive.as_ref();
        let left = planned.map_or([false; 2], |spec| [spec.cross_m, spec.along_m].map(|size| size.is_some()));
        Ok(Some(PathTracking::new(spec, path, self.speed_m_s, self.period_s, left)))
    }

    /// Numbers of the inputs that are fed back.
    fn inputs(&self, robot: &Robot) -> Result<Vec<usize>, Error> {
        let mut inputs: Vec<usize> = self.free(robot, true)?.iter().flat_map(numbers).collect();
        inputs.sort_unstable();
        inputs.dedup();
        Ok(inputs)
    }
}

/// Numbers of the inputs that are free.
fn numbers(free: &Free) -> Vec<usize> {
    match free {
        Free::Frequency => Vec::new(),
        Free::Inputs(direction) => direction.iter().map(|(i, _)| *i).collect(),
    }
}

/// Cycles of the gait since phase 0 of the orbits, which is where the robot's gait starts.
fn cycles(robot: &Robot, t: f64, x: &[f64]) -> f64 {
    let paced = robot.pacer().map_or(0.0, |pacer| x[robot.layout().structure + pacer.element]);
    (robot.phase(t) - robot.phase(0.0) + paced) / TAU
}

impl AboutOrbit<'_> {
    /// Whether a landing is under way, whose commands are then in force.
    fn land(&mut self, t: f64, cycles: f64) -> bool {
        let Some((landing, perch)) = self.family.landing().zip(self.perch.as_ref()) else { return false };
        let begun = self.lands.or_else(|| landing.begins(perch, t, &self.x, (cycles, self.period)));
        self.lands = begun;
        let Some(begun) = begun else { return false };
        let asked = landing.ask(&begun, perch, (t, cycles, self.period), (&self.x, self.airs.as_ref()));
        let [height, roll, pitch, ahead] = asked.off;
        self.seen = [0.0, height, roll, pitch, asked.done, ahead, asked.others];
        let mut retreat = asked.planned;
        self.held = asked.commands;
        for ((command, retreat), channel) in self.held.iter_mut().zip(&mut retreat).zip(self.robot.inputs()) {
            (*command, *retreat) = (channel.clamp(*command), channel.clamp(*retreat));
        }
        if let Some(governor) = &mut self.governor {
            let elements = &self.x[self.robot.layout().structure..][..2 * self.robot.response().elements()];
            let limits: Vec<f64> = self.inputs.iter().map(|i| self.robot.inputs()[*i].high).collect();
            let mut kept = self.held.clone();
            match governor.keep(t, elements, &effort(&limits), &retreat, &mut kept) {
                Ok(()) => self.held = kept,
                Err(_) => governor.not_kept += 1,
            }
        }
        true
    }

    /// Notes what was asked at an update: what `s` says of the body less the errors that were seen, `faster` of the speed.
    fn note(&mut self, s: &[f64], faster: f64) {
        let [_, height, roll, pitch, ..] = self.seen;
        let own = [Deviations::HEIGHT, Deviations::ROLL, Deviations::PITCH, Deviations::VELOCITY.start];
        let off = [height, roll, pitch, faster];
        self.asked = std::array::from_fn(|i| s[own[i]] - off[i]);
    }

    /// The controller's commands at the time `t` for deviations `error` from what is asked, `since` cycles after the start of a dive.
    ///
    /// # Errors
    /// The [`Fault`] of the gait over the cycle ahead, where a clearance is kept.
    fn regulate(
        &mut self,
        place: Option<StretchPlace>,
        (t, cycles, since): (f64, f64, f64),
        asked: Asked,
        error: &[f64],
    ) -> Result<(), Fault> {
        let gain = match self.family.dive() {
            Some(dive) if since > 0.0 && since < dive.cycles => dive.gain(since),
            _ => self.family.gain(place, cycles),
        };
        let mut commands = asked.commands.clone();
        if let Some(adaptation) = &self.adaptation {
            self.family.beside(adaptation.added(), &mut commands);
        }
        let mut retreat = commands.clone();
        if let Some(adaptation) = &self.adaptation
            && let Some((ahead, waves)) = self.family.ahead(place, cycles).zip(adaptation.waves())
        {
            let ahead = ahead * DVector::from_column_slice(waves);
            self.inputs.iter().zip(ahead.iter()).for_each(|(input, ahead)| commands[*input] += ahead);
        }
        for (row, &input) in self.inputs.iter().enumerate() {
            let fed: f64 = error.iter().enumerate().map(|(j, e)| gain[(row, DEVIATIONS + j)] * e).sum();
            commands[input] -= gain[(row, INTEGRAL)] * self.integral + fed;
        }
        for (commands, channel) in commands.iter_mut().zip(&mut retreat).zip(self.robot.inputs()) {
            let (command, retreat) = commands;
            (*command, *retreat) = (channel.clamp(*command), channel.clamp(*retreat));
        }
        if let Some(governor) = &mut self.governor {
            let elements = &self.x[self.robot.layout().structure..][..2 * self.robot.response().elements()];
            let hessian = self.family.hessian(place, cycles);
            governor.keep(t, elements, &hessian, &retreat, &mut commands)?;
        }
        if let (Some(adaptation), Some(tangent)) = (&mut self.adaptation, self.family.tangent()) {
            adaptation.pace(tangent, self.robot.inputs(), &asked.commands, &commands);
        }
        self.held = commands;
        Ok(())
    }
}

/// Columns of a landing, and their units.
const LANDING: [(&str, &str); 6] = [
    ("orbit_landing", ""),
    ("orbit_landing_ahead", "m"),
    ("orbit_landing_other_laws", ""),
    ("orbit_landing_saved", ""),
    ("orbit_landing_speed", "m/s"),
    ("orbit_landing_pitch", "rad"),
];

/// Columns where a clearance is kept, and their units.
const GOVERNED: [(&str, &str); 3] =
    [("orbit_governed", ""), ("orbit_clearance_asked", "m"), ("orbit_not_kept", "")];

impl Controller for AboutOrbit<'_> {
    fn update(&mut self, t: f64, measurement: &Measurement) -> Update {
        let begun = Instant::now();
        if self.estimator.estimate(t, measurement, &self.held, &mut self.x).is_err() {
            return Update::Kept;
        }
        let x = &self.x;
        let cycles = cycles(self.robot, t, x);
        let layout = self.robot.layout();
        let [position, velocity] = [layout.position, layout.velocity].map(|i| Vec3::from_slice(&x[i..]));
        let Demand { place, height, faster, .. } = match &mut self.tracking {
            None => self.schedule.demand(t),
            Some(tracking) => tracking.demand(t, position, velocity),
        };
        if let Some(airs) = &mut self.airs {
            airs.learn(t, (self.robot, &self.x), &self.held);
        }
        let mut s = vec![0.0; self.deviations.len()];
        self.deviations.of(&self.x, &mut s);
        if self.land(t, cycles) {
            // No speed is asked of a landing.
            self.note(&s, 0.0);
            return Update::Fresh;
        }
        let x = &self.x;
        let mut asked = self.family.asked(place, cycles);
        let since = match self.family.dive() {
            None => 0.0,
            Some(dive) => {
                if t >= dive.start_s {
                    self.dives.get_or_insert(cycles.ceil());
                }
                let since = self.dives.map_or(0.0, |begin| (cycles - begin).clamp(0.0, dive.cycles));
                let paced = self.robot.pacer().map_or(0.0, |pacer| pacer.gain * self.held[pacer.input]);
                dive.ask(since, self.period * (self.robot.frequency_hz() + paced / TAU), &mut asked);
                since
            }
        };
        if let Some(adaptation) = &mut self.adaptation {
            if adaptation.learn(t, cycles, x, &self.held).is_err() {
                return Update::Kept;
            }
            self.family.deviate(adaptation.added(), cycles, &mut asked.numbers);
        }
        let mut error: Vec<f64> = s.iter().zip(&asked.numbers).map(|(s, asked)| s - asked).collect();
        error[Deviations::HEIGHT] -= height;
        error[Deviations::VELOCITY.start] -= faster;
        let off = error[Deviations::HEIGHT];
        if off.abs() < INTEGRATED {
            self.integral += off * self.period;
        }
        let done = place.map_or(0.0, |place| place.stretch as f64 + place.share);
        let dived = self.family.dive().map_or(0.0, |dive| since / dive.cycles);
        self.seen = [done, off, error[Deviations::ROLL], error[Deviations::PITCH], dived, 0.0, 0.0];
        self.note(&s, error[Deviations::VELOCITY.start]);
        let Some(predictive) = &mut self.predictive else {
            return match self.regulate(place, (t, cycles, since), asked, &error) {
                Ok(()) => Update::Fresh,
                Err(_) => Update::Kept,
            };
        };
        let (schedule, tracking) = (&self.schedule, self.tracking.as_ref());
        let demand = |t: f64, place: Vec3| {
            tracking.map_or_else(|| schedule.demand(t), |tracking| tracking.ahead(t, place))
        };
        let height = Height { error: off, integral: self.integral };
        let update = predictive.update(t, &self.x, height, &self.family, demand, begun);
        // Commands are held, and those of a plan are linear in time.
        predictive.plan().input_at(t + 0.5 * self.period, &mut self.held);
        update
    }

    fn input(&self, _: f64, u: &mut [f64]) {
        u.copy_from_slice(&self.held);
    }

    fn columns(&self) -> Vec<Column> {
        let own = [
            Column::new("orbit_legs", "", ""),
            Column::new("orbit_height_error", "m", "W"),
            Column::new("orbit_roll_error", "rad", "WB"),
            Column::new("orbit_pitch_error", "rad", "WB"),
            Column::new("orbit_height_asked", "m", "W"),
            Column::new("orbit_roll_asked", "rad", "WB"),
            Column::new("orbit_pitch_asked", "rad", "WB"),
            Column::new("orbit_speed_asked", "m/s", "H"),
        ];
        let dive =
            self.family.dive().map(|_| ["orbit_dive", "orbit_dive_saved"].map(|n| Column::new(n, "", "")));
        let landing = LANDING.into_iter();
        let landing = landing.map(|(name, unit)| Column::new(name, unit, ""));
        let landing = landing.filter(|_| self.family.landing().is_some());
        let path = self.tracking.as_ref().map_or(Vec::new(), PathTracking::columns);
        let adapted = self.adaptation.as_ref().map_or(Vec::new(), Adaptation::columns);
        let governed = GOVERNED.into_iter().map(|(name, unit)| Column::new(name, unit, ""));
        let governed = governed.filter(|_| self.governor.is_some());
        let solver = self.predictive.iter().flat_map(|_| receding::columns());
        let missed = self.predictive.iter().filter(|planned| planned.is_reduced());
        own.into_iter()
            .chain(dive.into_iter().flatten())
            .chain(landing)
            .chain(path)
            .chain(adapted)
            .chain(governed)
            .chain(self.estimator.columns())
            .chain(solver)
            .chain(missed.map(|_| Column::new("orbit_plan_error", "", "")))
            .collect()
    }

    fn diagnostics(&self, row: &mut Vec<f64>) {
        row.extend(self.seen[..4].iter().chain(&self.asked));
        match (self.family.dive(), self.family.landing()) {
            (_, Some(landing)) => row.extend(self.seen[4..7].iter().chain(&landing.reached)),
            (Some(dive), None) => row.extend([self.seen[4], dive.saved]),
            (None, None) => {}
        }
        row.extend(self.tracking.iter().flat_map(PathTracking::numbers));
        row.extend(self.adaptation.iter().flat_map(Adaptation::numbers));
        row.extend(self.governor.iter().flat_map(Governor::numbers));
        self.estimator.diagnostics(row);
        row.extend(self.predictive.iter().flat_map(|p| receding::measures(&p.statistics())));
        row.extend(
            self.predictive.iter().filter(|planned| planned.is_reduced()).map(|planned| planned.missed),
        );
    }
}
