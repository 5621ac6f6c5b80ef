//! Time stepping of a tethered wing.

use super::recorder::TetherRecorder;
use super::spar::{Bent, Spar};
use super::wing::Frame;
use super::{Coordinate, Plane, Side, TetherRun, TetheredBody, Wing};
use crate::simulate::{Held, Moment, Observed, Record, Sizes, Stepper, System};
use std::ops::ControlFlow;
use wingbeat_aero::{Aero, Loads, MAX_STRIPS, SectionMotion};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;
use wingbeat_math::{Jet, Vec3};
use wingbeat_ocp::plant::Fault;

/// Instants of a cycle at which the motion alone is looked at.
const LOOKS: usize = 64;
/// Distance from the middle plane over that from the root along the arc below which a section lies on it, as one that flaps by 90 deg does: rounding.
const ON_PLANE: f64 = 1e-9;
/// Most steps of one run.
const MAX_STEPS: usize = 500_000;
/// Most rows of strips of a run: about half a GB in memory.
const MAX_STRIP_ROWS: usize = 2_000_000;

/// Cycles and steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Cycles per second; of a motion that is not periodic, one over its duration.
    pub frequency_hz: f64,
    /// Number of cycles from rest.
    pub cycles: usize,
    /// Steps per cycle.
    pub steps_per_cycle: usize,
}

ranges!(Clock { frequency_hz: Range::POSITIVE, cycles: Range::from(1.0), steps_per_cycle: Range::from(8.0) });

impl Clock {
    /// Step, s.
    pub fn step(&self) -> f64 {
        1.0 / (self.frequency_hz * self.steps_per_cycle as f64)
    }
    /// Number of steps.
    pub fn steps(&self) -> usize {
        self.cycles * self.steps_per_cycle
    }
    /// Position in the cycle at step `step`, cycles in [0, 1).
    pub fn phase(&self, step: usize) -> f64 {
        (step % self.steps_per_cycle) as f64 / self.steps_per_cycle as f64
    }
}

/// Motion of body and hinges over time, with a name for each hinge.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Forward, m.
    pub surge: Coordinate,
    /// Up, m.
    pub heave: Coordinate,
    /// Nose up, rad.
    pub nose_up: Coordinate,
    /// Right wing down, rad.
    pub roll: Coordinate,
    /// Place of the pitch axis ahead of the hinge line, m.
    pub axis_ahead_m: f64,
    /// Name and angle (rad) of each hinge of the wing, in order.
    pub hinges: Vec<(String, Coordinate)>,
}

impl Motion {
    /// At rest at the origin, without hinges.
    pub fn at_rest() -> Self {
        let still = || Coordinate::Constant(0.0);
        let hinges = Vec::new();
        Self { surge: still(), heave: still(), nose_up: still(), roll: still(), axis_ahead_m: 0.0, hinges }
    }

    /// Whether nothing moves.
    pub fn is_still(&self) -> bool {
        let body = [&self.surge, &self.heave, &self.nose_up, &self.roll];
        let mut all = body.into_iter().chain(self.hinges.iter().map(|(_, angle)| angle));
        all.all(|coordinate| matches!(coordinate, Coordinate::Constant(_)))
    }

    /// The body at time `t`.
    pub fn body(&self, t: f64) -> TetheredBody<f64> {
        TetheredBody {
            surge: self.surge.at(t),
            heave: self.heave.at(t),
            nose_up: self.nose_up.at(t),
            roll: self.roll.at(t),
            axis_ahead_m: self.axis_ahead_m,
        }
    }

    /// The hinge angles at time `t`, rad.
    pub fn angles(&self, t: f64) -> Vec<Jet<f64>> {
        self.hinges.iter().map(|(_, angle)| angle.at(t)).collect()
    }
}

/// Scales of the coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoefficientScales {
    /// Density, kg/m3.
    pub density_kg_m3: f64,
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Area, m2.
    pub area_m2: f64,
    /// Length of the pitching-moment coefficient, m.
    pub chord_m: f64,
}

/// A wing in prescribed motion in a uniform wind.
#[derive(Clone, Debug)]
pub struct Tether {
    /// Geometry.
    pub wing: Wing,
    /// Motion.
    pub motion: Motion,
    /// Aerodynamic model of the wing's planform.
    pub aero: Aero,
    /// Velocity of the air in W, m/s.
    pub wind: Vec3,
    /// Whose loads count: a half alone has a mirror plane at its root.
    pub side: Side,
    /// Scales of the coefficients.
    pub reference: CoefficientScales,
    /// Cycles and steps.
    pub clock: Clock,
    /// The beam that carries each half, where the wing is not rigid.
    pub spar: Option<Spar>,
    /// The plane that the air does not cross, where there is one.
    pub ground: Option<Plane>,
}

impl Tether {
    /// Checks what the parts cannot check by themselves.
    ///
    /// # Errors
    /// [`Error::Invalid`] when an angle per hinge is missing or a scale or the
    /// clock is out of range.
    pub fn check(&self) -> Result<(), Error> {
        if self.motion.hinges.len() != self.wing.hinges().len() {
            let allowed = format!("{}: one angle per hinge", self.wing.hinges().len());
            return Err(Error::invalid("hinges", self.motion.hinges.len(), allowed));
        }
        TetherRecorder::columns(self)?;
        self.check_mirror()?;
        self.check_ground()?;
        if let Some(spar) = &self.spar {
            spar.check(self)?;
        }
        self.clock.in_range().map_err(|e| e.within("time"))?;
        let positive = [
            ("reference.speed_m_s", self.reference.speed_m_s),
            ("air.density_kg_m3", self.reference.density_kg_m3),
        ];
        for (key, value) in positive {
            require::positive(key, value)?;
        }
        let steps = self.clock.cycles.saturating_mul(self.clock.steps_per_cycle);
        if steps > MAX_STEPS {
            let allowed = format!("at most {MAX_STEPS} steps; these make {steps}");
            let error = Error::invalid("time.cycles", self.clock.cycles, allowed);
            return Err(error.against(["time.steps_per_cycle"]));
        }
        let rows = steps.saturating_mul(self.aero.strips());
        if rows > MAX_STRIP_ROWS {
            let allowed = format!("at most {MAX_STRIP_ROWS} rows of steps times strips; these make {rows}");
            let error = Error::invalid("time.cycles", self.clock.cycles, allowed);
            return Err(error.against(["time.steps_per_cycle"]));
        }
        Ok(())
    }

    /// Refuses of a half with a mirror plane at its root what would move both halves otherwise than as images.
    fn check_mirror(&self) -> Result<(), Error> {
        if self.side == Side::Both {
            return Ok(());
        }
        let refused = |key: &str, value: &str, allowed: &str| {
            Err(Error::invalid(
                key,
                value,
                format!("{allowed} of half a wing, which its mirror plane doubles"),
            ))
        };
        if !matches!(self.motion.roll, Coordinate::Constant(roll) if roll == 0.0) {
            return refused("body.roll_deg", "given", "0");
        }
        if self.wind[1] != 0.0 {
            return refused("wind.sideslip_deg", "given", "0");
        }
        for (i, hinge) in self.wing.hinges().iter().enumerate() {
            if hinge.side != Side::Both {
                return refused(&format!("hinges[{i}].side"), "given", "`both`");
            }
        }
        Ok(())
    }

    /// The columns of the loads, without rows.
    ///
    /// # Errors
    /// Two hinges of one name.
    pub fn columns(&self) -> Result<Record, Error> {
        TetherRecorder::columns(self)
    }

    /// The same with other steps per cycle.
    pub fn stepped(&self, steps_per_cycle: usize) -> Self {
        Self { clock: Clock { steps_per_cycle, ..self.clock }, ..self.clone() }
    }

    /// What share (dimensionless) of the loads of each strip counts, from the left tip: a half alone has a mirror plane at its root.
    pub fn strip_weights(&self) -> Vec<f64> {
        let weight = |arc: &f64| match self.side {
            Side::Both => 1.0,
            _ if *arc == 0.0 => 0.5,
            half if half.holds(arc.signum()) => 1.0,
            _ => 0.0,
        };
        self.aero.strip_arcs().iter().map(weight).collect()
    }

    /// Sections of the wing at time `t`, in W.
    pub(super) fn sections(&self, t: f64) -> [SectionMotion<f64>; MAX_STRIPS + 1] {
        let (body, angles) = (self.motion.body(t).frame(), self.motion.angles(t));
        let mut sections = [SectionMotion::default(); MAX_STRIPS + 1];
        for (section, &arc) in sections.iter_mut().zip(self.aero.arcs()) {
            *section = self.wing.section(arc, &body, &angles);
        }
        sections
    }

    /// Instants of the last cycle at which the motion alone is looked at, s.
    pub(super) fn instants(&self) -> impl Iterator<Item = f64> {
        let Clock { frequency_hz, cycles, .. } = self.clock;
        (0..LOOKS).map(move |k| (cycles as f64 - 1.0 + k as f64 / LOOKS as f64) / frequency_hz)
    }

    /// Share of the last cycle in which a section lies beyond the body's middle plane: the middle of its chord where it is further than
    /// its chord from the root, nearer both of its edges. At the root a wing that sweeps may pass the plane with one edge.
    pub fn crossing_fraction(&self) -> f64 {
        let crosses = |t: f64| {
            let (frame, sections) = (self.motion.body(t).frame(), self.sections(t));
            let origin = Vec3(frame.origin.0.map(|x| x.x));
            let across = Vec3([0, 1, 2].map(|i| frame.turn.0[i][1].x));
            let outboard = self.aero.arcs().iter().zip(&sections).filter(|(arc, _)| **arc != 0.0);
            outboard.into_iter().any(|(arc, section)| {
                let [leading, trailing] =
                    [section.le, section.te].map(|edge| arc.signum() * (edge - origin).dot(across));
                let far = arc.abs() > (section.le - section.te).norm();
                let inmost = if far { 0.5 * (leading + trailing) } else { leading.max(trailing) };
                inmost < -ON_PLANE * arc.abs()
            })
        };
        self.instants().filter(|t| crosses(*t)).count() as f64 / LOOKS as f64
    }

    /// Largest speed of an edge of the wing through the air in the last cycle, m/s.
    pub fn largest_speed(&self) -> f64 {
        let edges = |t: f64| self.sections(t).map(|section| [section.v_le, section.v_te]);
        let speeds =
            self.instants().flat_map(|t| edges(t).into_iter().take(self.aero.arcs().len()).flatten());
        speeds.map(|v| (v - self.wind).norm()).fold(0.0, f64::max)
    }

    /// Largest distance, m, of an edge of the wing in the last cycle from where the origin of the body is in the mean.
    pub fn reach(&self) -> f64 {
        let origins = || self.instants().map(|t| Vec3(self.motion.body(t).frame().origin.0.map(|x| x.x)));
        let middle = origins().fold(Vec3::ZERO, |sum, origin| sum + origin) * (1.0 / LOOKS as f64);
        let edges = self.instants().flat_map(|t| self.edges_at(t));
        edges.flatten().map(|edge| (edge - middle).norm()).fold(0.0, f64::max)
    }

    /// Longest way, m, that the middle of a chord goes in the last cycle, beside the wind.
    pub fn longest_way(&self) -> f64 {
        let middles: Vec<Vec<Vec3>> = self
            .instants()
            .map(|t| self.edges_at(t).map(|[leading, trailing]| (leading + trailing) * 0.5).collect())
            .collect();
        let steps = |section: usize| {
            let ends = middles.iter().zip(middles.iter().cycle().skip(1));
            ends.map(|(at, to)| (to[section] - at[section]).norm()).sum::<f64>()
        };
        (0..self.aero.arcs().len()).map(steps).fold(0.0, f64::max)
    }

    /// Leading and trailing edge of each section at the time `t`, s.
    fn edges_at(&self, t: f64) -> impl Iterator<Item = [Vec3; 2]> {
        self.sections(t).into_iter().take(self.aero.arcs().len()).map(|section| [section.le, section.te])
    }

    /// Mean chord over the arc, m, and the root mean square over the last cycle of the speed at which the middles of the strips move
    /// through the air, weighted by their areas, m/s.
    pub fn mean_chord_and_speed(&self) -> [f64; 2] {
        let (mut width, mut area, mut square) = (0.0, 0.0, 0.0);
        for t in self.instants() {
            let sections = self.sections(t);
            for (pair, ends) in sections.windows(2).zip(self.aero.arcs().windows(2)) {
                let [at, to] = [&pair[0], &pair[1]];
                // Arcs run from left to right; what stands behind the last is no strip.
                let across = (ends[0] - ends[1]).max(0.0);
                let part = 0.5 * ((at.le - at.te).norm() + (to.le - to.te).norm()) * across;
                let speed = (at.v_le + at.v_te + to.v_le + to.v_te) * 0.25 - self.wind;
                width += across;
                area += part;
                square += speed.dot(speed) * part;
            }
        }
        [area / width, (square / area).sqrt()]
    }

    /// Whether the motion repeats with the clock, and is one.
    pub fn repeats(&self) -> bool {
        let Motion { surge, heave, nose_up, roll, hinges, .. } = &self.motion;
        let hinges = hinges.iter().map(|(_, angle)| angle);
        [surge, heave, nose_up, roll].into_iter().chain(hinges).any(Coordinate::repeats)
    }

    /// Sections at the arc coordinates `arcs` (m) for a frame of the body and angles (rad) of the hinges, of a wing that its
    /// spars bend.
    pub fn sections_at(
        &self,
        arcs: &[f64],
        body: &Frame<f64>,
        angles: &[Jet<f64>],
        bent: Option<&Bent>,
    ) -> Vec<SectionMotion<f64>> {
        match (&self.spar, bent) {
            (Some(spar), Some(bent)) => spar.sections_at(self, arcs, body, angles, bent),
            _ => arcs.iter().map(|arc| self.wing.section(*arc, body, angles)).collect(),
        }
    }

    /// The states, in the units of the air's models, of still air in which the wing has always moved as it does at first.
    pub fn start(&self) -> Vec<f64> {
        let mut x = vec![0.0; self.air_states()];
        self.settle(0.0, &mut x);
        x
    }

    /// Sets states that follow the impulse of the air to that impulse: see [`Aero::settle`].
    pub fn settle(&self, t: f64, x: &mut [f64]) {
        let own = &mut x[..self.aero.states()];
        self.aero.settle(&&self.sections(t)[..self.aero.arcs().len()], self.wind, own);
    }

    /// Runs all cycles from rest with the fourth-order Runge-Kutta method.
    /// `progress` hears the share done and may stop the run.
    ///
    /// # Panics
    /// When [`check`](Self::check) would refuse two hinges of one name.
    pub fn run(&self, mut progress: impl FnMut(f64) -> ControlFlow<()>) -> TetherRun {
        if let Some(spar) = &self.spar {
            return spar.run(self, &mut progress);
        }
        let mut recorder = TetherRecorder::new(self);
        let steps = self.clock.steps();
        let mut watch = Held(|step: usize, at: Moment| {
            recorder.sample(self, step, &self.observed(at)?, None)?;
            let done = step as f64 / steps as f64;
            Ok(if step < steps { progress(done) } else { ControlFlow::Continue(()) })
        });
        let mut stepper = Stepper::new(self, 0.0, &self.start());
        let ending = stepper.run(self.clock.step(), steps, &mut watch);
        recorder.finish(self, ending)
    }
}

/// The states are those of the air; the motion is given, so that there are no inputs.
impl System for Tether {
    type Memory = ();

    fn sizes(&self) -> Sizes {
        Sizes { states: self.air_states(), inputs: 0 }
    }
    fn slope(&self, at: Moment, dx: &mut [f64]) -> Result<(), Fault> {
        if self.ground.is_some() {
            self.evaluate(at.t, at.x, dx, &mut Loads::default());
            return Ok(());
        }
        let count = self.aero.arcs().len();
        self.aero.rates_in_numbers(&self.sections(at.t)[..count], self.wind, at.x, dx);
        Ok(())
    }
}

impl Observed for Tether {
    /// Loads in W about W's origin.
    type Observation = Loads<f64>;

    fn observed(&self, at: Moment) -> Result<Loads<f64>, Fault> {
        let (mut dx, mut loads) = (vec![0.0; at.x.len()], Loads::boxed());
        self.evaluate(at.t, at.x, &mut dx, &mut loads);
        match dx.iter().position(|rate| !rate.is_finite()) {
            Some(state) => Err(Fault::NotFinite { state, time: at.t }),
            None => Ok(*loads),
        }
    }
}
