//! What a scenario says of the vortex lattice that it flies in.

use super::build::whole;
use super::{Scenario, ScenarioSpec};
use serde::{Deserialize, Serialize};
use wingbeat_aero::Aero;
use wingbeat_flight::simulate::{AirCoupling, Flow, Schedule, SensorSpec};
use wingbeat_judge::Warning;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_robot::{Robot, SurfaceOutline};

/// An unsteady vortex lattice in place of all that the aerodynamic model says of attached flow; profile drag is the model's. Membranes,
/// and flaps from root to tip, bear its pressure, their own inertia and weight; what a law of separated flow presses on them is left out.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct LatticeSpec {
    /// Step of the lattice, s: whole steps of the flight, of which an update of the controller is a whole number; on the rig whole
    /// samples of the load cell. Best where the way of the wing in a step is a panel's chord.
    pub step_s: f64,
    /// Panels along the chord.
    #[serde(default = "chordwise")]
    pub chordwise: usize,
    /// Panels along the span of the first surface; others have as many by their span.
    #[serde(default = "spanwise")]
    pub spanwise: usize,
    /// Whether the local air carries the wake; else the wind alone.
    #[serde(default)]
    pub free_wake: bool,
    /// Radius of the cores of the wake's vortices, mean chords of the first surface; as wings feel them, at most a tenth of their way from
    /// the trailing edge, unless air comes in over it.
    #[serde(default = "core")]
    pub core_chords: f64,
    /// Whether parts of the robot may pass through each other: bound vortices are then rounded off where they are felt further along
    /// the span than a mean chord, which changes the loads a little where nothing crosses.
    #[serde(default)]
    pub crossing: bool,
    /// Age at which the wake ends, s; without it never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longest_age_s: Option<f64>,
    /// Largest suction parameter of the leading edges (A0 of thin aerofoils, the angle of attack of a flat plate in steady flow): what is above
    /// leaves them in a vortex sheet. Without it the flow stays attached. It belongs to profile and Reynolds number: 0.11 for flat plates,
    /// 0.14 to 0.21 for SD7003 at 1e4 to 3e4 (Ramesh et al. 2014 and their program).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub critical_suction: Option<f64>,
}

ranges!(LatticeSpec {
    step_s: Range::POSITIVE,
    chordwise: Range::between(1.0, 64.0),
    spanwise: Range::between(1.0, 400.0),
    core_chords: Range::over(0.0, 1.0),
    longest_age_s: Range::POSITIVE,
    // A0 of a flat plate is the sine of its angle of attack.
    critical_suction: Range::between(0.0, 1.0),
});

fn chordwise() -> usize {
    4
}

fn spanwise() -> usize {
    24
}

fn core() -> f64 {
    0.02
}

/// What a lattice is made for.
#[derive(Debug)]
pub struct LatticeTask<'a> {
    /// What the scenario says.
    pub spec: &'a LatticeSpec,
    /// The robot that flies, in its air.
    pub robot: &'a Robot,
    /// Its surfaces.
    pub outlines: Vec<SurfaceOutline>,
    /// Density of the air, kg/m3.
    pub density_kg_m3: f64,
    /// Steps of the flight, or samples of the load cell, that one of the lattice takes.
    pub every: usize,
    /// Steps of the lattice.
    pub steps: usize,
}

/// Makes the air of a lattice.
pub type MakeLattice = for<'a> fn(LatticeTask<'a>) -> Result<Box<dyn Flow>, Error>;

impl LatticeTask<'_> {
    /// The air of the lattice, of a program that has one.
    pub(super) fn air(self, make: Option<MakeLattice>) -> Result<Box<dyn Flow>, Error> {
        let Some(make) = make else {
            let allowed = "none here: `wingbeat` has the lattice, and whatever opens a file with wingbeat_lattice::doors()";
            return Err(Error::invalid("lattice", "given", allowed));
        };
        make(self)
    }
}

/// Key of a lattice's step.
const STEP: &str = "lattice.step_s";

impl LatticeSpec {
    /// How many of `units` of `unit` s a step takes.
    ///
    /// # Errors
    /// Numbers out of range, and steps that are no whole number of them.
    pub(super) fn every(&self, unit: f64, units: &str) -> Result<usize, Error> {
        self.in_range().map_err(|e| e.within("lattice"))?;
        let every = whole(STEP, self.step_s, unit, units)?;
        if let Some(age) = self.longest_age_s.filter(|age| *age < self.step_s) {
            let allowed = format!("at least a step of the lattice, {} s", self.step_s);
            return Err(Error::invalid("lattice.longest_age_s", age, allowed).against([STEP]));
        }
        Ok(every)
    }
}

/// How motion and lattice were brought together.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
pub struct LatticeSummary {
    /// Step of the lattice, s.
    pub step_s: f64,
    /// Steps of the lattice.
    pub steps: usize,
    /// Mean number of states tried for a step, until its loads and the motion agreed to 1e-6 of the weight.
    pub iterations_mean: f64,
    /// Most of them.
    pub iterations_most: usize,
    /// Way of the trailing edges through the air in a step, rms, chords of a panel; 0 where nothing moved.
    pub way_panels: f64,
    /// The same in radii of the wake's cores.
    pub way_cores: f64,
    /// Largest way of a vortex in a step that has left a leading edge, mean chords; none in attached flow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sheet_way_chords: Option<f64>,
    /// Share of trailing edges and steps at which the air comes in over the edge.
    #[serde(default)]
    pub inflow_fraction: f64,
    /// Length of the wake where it was forgotten at an age: way of the trailing edges until then, mean chords.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wake_chords: Option<f64>,
}

/// Way in a step above which a step is said to be long, chords of a panel. *Choice.*
const LONG: f64 = 2.0;
/// Way of a shed vortex in a step above which it is said to run away, mean chords. *Choice.*
const FAR: f64 = 0.5;
/// Length of a wake below which it is said to be forgotten too soon, mean chords. *Choice*: of the glider the rate of sink is 8 % off at 9
/// and 0.3 % at 18 (measured).
const SHORT: f64 = 12.0;

impl LatticeSummary {
    pub(super) fn new(coupling: AirCoupling, spec: Option<&LatticeSpec>) -> Self {
        let AirCoupling { step, steps, iterations, most, fineness } = coupling;
        let forgotten = spec.and_then(|spec| Some((spec.longest_age_s? / step, spec.chordwise)));
        let length = |(kept, chordwise): (f64, usize)| fineness.panels / chordwise as f64 * kept;
        Self {
            wake_chords: forgotten.filter(|(kept, _)| *kept < steps as f64).map(length),
            step_s: step,
            steps,
            iterations_mean: iterations as f64 / steps.max(1) as f64,
            iterations_most: most,
            way_panels: fineness.panels,
            way_cores: fineness.cores,
            sheet_way_chords: fineness.sheet,
            inflow_fraction: fineness.inflow,
        }
    }

    /// What a reader must know of the steps.
    pub fn cautions(&self) -> Vec<String> {
        let Self { step_s, way_panels, sheet_way_chords, wake_chords, .. } = *self;
        let mut cautions = Vec::new();
        if way_panels > LONG {
            let shorter = step_s / way_panels;
            cautions.push(format!(
                "the steps of the lattice are long: in one the wing goes {way_panels:.1} chords of a panel; with lattice.step_s \
                 = {shorter:.2e} it would go one"
            ));
        }
        if let Some(way) = sheet_way_chords.filter(|way| *way > FAR) {
            cautions.push(format!(
                "vortices that have left the leading edges run away: in a step of the lattice one goes {way:.1} mean chords; shorten \
                 lattice.step_s or raise lattice.critical_suction"
            ));
        }
        if let Some(length) = wake_chords.filter(|length| *length < SHORT && way_panels > 0.0) {
            cautions.push(format!(
                "the wake is forgotten {length:.1} mean chords behind the wing, where it still acts: raise lattice.longest_age_s"
            ));
        }
        cautions
    }
}

/// The warning that a membrane or flap of `models` flies in the lattice of `spec`. Gliding ones were compared with strips; of the flapping
/// `aerobat_membrane` (law `stall`) camber was three quarters of that by strips and positive power 1.27 times. What a step takes of a swing:
/// `robot.held_load`.
pub(super) fn soft<'a>(
    spec: Option<&LatticeSpec>,
    models: impl IntoIterator<Item = &'a Aero>,
) -> Vec<Warning> {
    let Some(LatticeSpec { step_s, .. }) = spec else { return Vec::new() };
    let bent: Vec<_> = models.into_iter().filter_map(Aero::bent).collect();
    let film = "membranes bear the pressure of attached flow, and flapping ones were compared with nothing measured: aerobat_membrane bulges a \
                quarter less in the lattice than by strips and takes a quarter more power";
    let flap = format!(
        "flaps bear the pressure of attached flow and were compared with strips in a glide; steps of {step_s} s damp a swing at w rad/s by {:.1e} \
         w of the critical damping",
        0.25 * step_s
    );
    let kinds = [
        (bent.iter().any(|model| model.is_membrane()), film.to_owned()),
        (bent.iter().any(|model| model.has_flap()), flap),
    ];
    let warning = |(_, text)| Warning::new("lattice.soft", text).key("lattice");
    kinds.into_iter().filter(|(is, _)| *is).map(warning).collect()
}

impl ScenarioSpec {
    /// Refuses a lattice that cannot be stepped beside the flight by the clock `schedule`; else the steps of the flight that one of
    /// its steps takes.
    pub(super) fn lattice_steps(&self, schedule: &Schedule) -> Result<Option<usize>, Error> {
        let Some(spec) = &self.lattice else { return Ok(None) };
        let (key, step) = (STEP, spec.step_s);
        let every = spec.every(schedule.step, "steps of").map_err(|e| e.against(["flight.step_s"]))?;
        if every > schedule.steps {
            let allowed = format!("at most the flight's {} s", self.flight.duration_s);
            return Err(Error::invalid(key, step, allowed).against(["flight.duration_s"]));
        }
        if let Some(update) = schedule.steps_per_update.filter(|update| !update.is_multiple_of(every)) {
            let period = update as f64 * schedule.step;
            let allowed = format!("a time of which the controller's period, {period} s, is a whole number");
            return Err(Error::invalid(key, step, allowed));
        }
        if self.sensors.as_ref().is_some_and(SensorSpec::reads) {
            let allowed = "no instruments beside a lattice: they read the robot's own models";
            return Err(Error::invalid("sensors", "given", allowed).against(["lattice"]));
        }
        if let Some(every) = self.flight.record_strips_every_s {
            let allowed = "nothing beside a lattice: strips are the model's";
            return Err(Error::invalid("flight.record_strips_every_s", every, allowed).against(["lattice"]));
        }
        Ok(Some(every))
    }
}

impl Scenario {
    /// The air of the lattice that the scenario flies in, if it does.
    pub(super) fn lattice(&self) -> Result<Option<Box<dyn Flow>>, Error> {
        let (Some(spec), Some(every)) = (&self.spec.lattice, self.spec.lattice_steps(&self.schedule)?) else {
            return Ok(None);
        };
        let task = LatticeTask {
            spec,
            robot: &self.robot,
            outlines: self.robot.surface_outlines(&self.spec.robot).map_err(|e| e.within("robot"))?,
            density_kg_m3: self.robot.density(),
            every,
            steps: self.schedule.steps.div_ceil(every),
        };
        task.air(self.choice.lattice).map(Some)
    }

    /// Refuses a lattice where derivatives of the flight are needed, or several flights at once.
    pub(crate) fn without_lattice(&self) -> Result<(), Error> {
        match self.spec.lattice {
            None => Ok(()),
            Some(_) => {
                let allowed =
                    "nothing but in `fly`: the lattice has no derivatives and flies one robot at a time";
                Err(Error::invalid("lattice", "given", allowed))
            }
        }
    }
}
