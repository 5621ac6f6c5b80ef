//! What a lattice is stepped through: surfaces in motion, a number of cycles, and the axes in which it is looked at.

mod case;
mod recorded;
mod stroke;
mod told;
mod watch;

pub use case::case;
pub use recorded::RecordedFlight;
pub use stroke::{PHASES, Stroke};
pub use told::{CourseSummary, DownOverUp, LeftOverRight, StretchSummary, WakeSummary};
pub use watch::{CourseWatch, LatticeShot, Strongest};

use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use crate::{
    Core, Error, FlightStretch, Lattice, LatticeSettings, PanelLayout, Panels, Scene, Spacing, WakeMotion,
};
use wingbeat::aero::SectionMotion;
use wingbeat::judge::Warning;
use wingbeat::math::Vec3;
use wingbeat::scenario::Moved;

/// Most rings of a wake: minutes of work.
pub(crate) const MOST_RINGS: usize = 200_000;
/// Segments of a wake from which it is summed by multipoles.
pub(crate) const FAST_FROM: usize = 20_000;
/// Core of bound vortices where wings pass through each other, over the distance along the arc. *Choice.*
pub(crate) const CROSSING: f64 = 0.2;
/// Fewest and most steps of a cycle that are chosen.
const STEPS: (f64, f64) = (24.0, 400.0);

/// Places of the wings at which they are held against their mirror image.
const COMPARED: usize = 97;
/// Distance from it below which a motion is symmetric, mean chords: positions of metres carry rounding.
const SYMMETRIC: f64 = 1e-9;

/// What is asked of the lattice of a case or along a flight.
#[derive(Clone, Debug, PartialEq)]
pub struct CourseRequest {
    /// Of a flight, the times at which the stretches end, s; without them before the turn and the end.
    pub at: Vec<f64>,
    /// Of a flight, cycles of a stretch, from rest; without it 3.
    pub cycles: Option<usize>,
    /// Of a flight, whether the circulations of the model that flew are shed, not those of the lattice.
    pub model: bool,
    /// Panels along the chord.
    pub chordwise: usize,
    /// Panels along the span.
    pub spanwise: usize,
    /// Steps per cycle; without it as many as make the way in a step a panel's chord, 24 to 400.
    pub steps: Option<usize>,
    /// Whether the wind alone carries the wake.
    pub prescribed: bool,
    /// Radius of the cores of the wake's vortices, mean chords.
    pub core: f64,
    /// Largest suction parameter of the leading edges, dimensionless; without it the flow stays attached.
    pub critical_suction: Option<f64>,
}

impl Default for CourseRequest {
    fn default() -> Self {
        Self {
            at: Vec::new(),
            cycles: None,
            model: false,
            chordwise: 6,
            spanwise: 24,
            steps: None,
            prescribed: false,
            core: 0.05,
            critical_suction: None,
        }
    }
}

impl CourseRequest {
    fn panels(&self) -> Panels {
        Panels { chordwise: self.chordwise, spanwise: self.spanwise, spacing: Spacing::Lan }
    }

    /// What is asked, with a lattice that can be.
    fn checked(&self) -> Result<&Self, Error> {
        let given = [("steps", self.steps), ("cycles", self.cycles)];
        match given.into_iter().find(|(_, count)| *count == Some(0)) {
            Some((key, _)) => Err(Error::Setting { key, value: 0.0, allowed: "1 or more".into() }),
            None => match self.critical_suction {
                // A0 of a flat plate is the sine of its incidence.
                Some(value) if !(0.0..=1.0).contains(&value) => {
                    Err(Error::Setting { key: "critical_suction", value, allowed: "0 to 1".into() })
                }
                Some(value) if self.model => {
                    let allowed = "none where the circulations are a model's".into();
                    Err(Error::Setting { key: "critical_suction", value, allowed })
                }
                _ => Ok(self),
            },
        }
    }

    /// Refuses a wake of too many rings through `clock`.
    fn check_size(&self, clock: CourseClock) -> Result<(), Error> {
        let edges = 1 + usize::from(self.critical_suction.is_some());
        let rings = clock.cycles.saturating_mul(clock.steps).saturating_mul(edges * self.spanwise);
        if rings > MOST_RINGS { Err(Error::Rings { rings, most: MOST_RINGS }) } else { Ok(()) }
    }

    /// Settings of the lattice of `course`.
    fn settings(&self, course: &LatticeCourse) -> LatticeSettings {
        let core = Core { radius_m: self.core * course.chord, viscosity_m2_s: 0.0, squire: 0.0 };
        let wake = if self.prescribed { WakeMotion::Prescribed } else { WakeMotion::Free };
        let crossing = if course.crosses { CROSSING } else { 0.0 };
        let own = LatticeSettings::new(course.clock.step_s(), core.radius_m);
        let own = own.shedding(self.critical_suction, course.chord);
        LatticeSettings { wake, core, crossing, fast_from: FAST_FROM, ..own }
    }
}

/// Steps of a cycle in which the way is `way` m so that the way of each is a panel's chord.
fn fitting(way: f64, chord: f64, chordwise: usize) -> usize {
    (way * chordwise as f64 / chord).round().clamp(STEPS.0, STEPS.1) as usize
}

/// The air's axes in W: direction of flight through it, left, up.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    /// Direction of flight through the air, a unit vector.
    pub flight: Vec3,
    /// To the left of it, a unit vector.
    pub left: Vec3,
    /// Up, across both, a unit vector.
    pub up: Vec3,
}

impl Axes {
    /// Of a flight with the velocity `through` (m/s, W) the air; at rest flight is along x.
    pub fn new(through: Vec3) -> Self {
        let flight = if through.norm() > 0.0 { through.unit() } else { Vec3::new(1.0, 0.0, 0.0) };
        let upward = if flight[0].hypot(flight[1]) > 1e-9 {
            Vec3::new(0.0, 0.0, 1.0)
        } else {
            Vec3::new(-1.0, 0.0, 0.0)
        };
        let up = (upward - flight * upward.dot(flight)).unit();
        Self { flight, left: up.cross(flight), up }
    }

    /// The components of `v` along flight, left and up, in its unit.
    pub fn of(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.flight), v.dot(self.left), v.dot(self.up))
    }
}

/// Cycles and steps from rest.
#[derive(Clone, Copy, Debug)]
pub struct CourseClock {
    /// Cycles per second.
    pub frequency_hz: f64,
    /// Number of cycles.
    pub cycles: usize,
    /// Steps per cycle.
    pub steps: usize,
}

impl CourseClock {
    /// Step, s.
    pub fn step_s(&self) -> f64 {
        1.0 / (self.frequency_hz * self.steps as f64)
    }
    /// Number of steps.
    pub fn total(&self) -> usize {
        self.cycles * self.steps
    }
    /// The first step of the last cycle.
    pub fn first_of_last(&self) -> usize {
        (self.cycles - 1) * self.steps
    }
}

/// The flight that moves the surfaces.
#[derive(Clone)]
pub struct MovingFlight {
    /// Motion and model.
    pub flight: Arc<FlightStretch>,
    /// Time of the flight at which the course begins, s.
    pub from_s: f64,
    /// Layouts of the scene's surfaces, with the number of the robot's surface.
    pub layouts: Vec<(usize, PanelLayout)>,
    /// Whether the circulations are those of the model that flew.
    pub by_model: bool,
}

/// What a lattice is stepped through.
#[derive(Clone)]
pub struct LatticeCourse {
    /// Beginning of its files' names; empty where there is no other course.
    pub name: String,
    /// What it is called in figures.
    pub title: String,
    /// Surfaces, wind and density.
    pub scene: Scene,
    /// Cycles and steps.
    pub clock: CourseClock,
    /// Begin and middle of the strokes of the last cycle.
    pub stroke: Stroke,
    /// Axes of the air.
    pub axes: Axes,
    /// Mean chord, m.
    pub chord: f64,
    /// Surfaces of the scene that mirror each other from both ends on.
    pub groups: Vec<Range<usize>>,
    /// Whether left and right move alike.
    pub symmetric: bool,
    /// The flight that moves them; none in a case.
    pub flown: Option<MovingFlight>,
    /// Share of strips and instants of the last cycle past the stall angle of their section; none where the strip model breaks down.
    pub past_stall: Option<f64>,
    /// Whether parts of the robot pass through each other on the way.
    pub crosses: bool,
    /// Of a case, its motion.
    pub moved: Option<Moved>,
    /// Largest suction parameter of the leading edges, which shed what is above, dimensionless; none in attached flow.
    pub critical_suction: Option<f64>,
    /// What is said of keys that the lattice does not hear.
    pub unheard: Vec<Warning>,
}

impl LatticeCourse {
    /// The body's origin, m in W, at `t` s of the course.
    pub fn origin(&self, t: f64) -> Vec3 {
        self.flown.as_ref().map_or(Vec3::ZERO, |flown| flown.flight.body(flown.from_s + t).0)
    }

    /// What is assumed of the flow.
    pub fn assumed(&self) -> String {
        let assumed = match self.critical_suction {
            Some(critical) => {
                format!("leading edges shed above a suction parameter of {critical}, side edges do not")
            }
            None => "attached flow is assumed".into(),
        };
        match self.past_stall {
            Some(share) if share > 0.0 => {
                format!("{assumed}, {:.0} % of the strips are past stall", 100.0 * share)
            }
            Some(_) => assumed,
            None => format!(
                "{assumed}, and the strip model that tells what is past stall breaks down (see `wingbeat tether`)"
            ),
        }
    }

    /// What is said of wings that pass through each other.
    pub fn crossing(&self) -> Option<&'static str> {
        self.crosses.then_some("the wings cross, bound vortices are rounded off there")
    }

    /// What must be known to read a figure.
    pub fn note(&self) -> String {
        std::iter::once(self.assumed()).chain(self.crossing().map(Into::into)).collect::<Vec<_>>().join("; ")
    }

    /// Steps the lattice of the course and keeps what is to be seen; `progress` is told the number of steps done and may end it. A lattice
    /// that fails ends the course with what there is, and the reason.
    ///
    /// # Errors
    /// Settings or surfaces of which there is no lattice.
    pub fn step(
        &self,
        asked: &CourseRequest,
        progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<CourseWatch<'_>, Error> {
        let mut lattice = Lattice::new(self.scene.clone(), asked.settings(self))?;
        let mut watch = CourseWatch::new(self);
        for k in 0..self.clock.total() {
            if let Err(error) = self.advance(&mut lattice, &mut watch, k) {
                watch.failed = Some(error.to_string());
                break;
            }
            if progress(k + 1).is_break() {
                watch.failed = Some("it was ended".into());
                watch.ended = true;
                break;
            }
        }
        watch.circulation_error = lattice.circulation_error();
        watch.farthest = lattice.farthest() / self.chord;
        watch.far = lattice.wake_drag().zip(lattice.span());
        Ok(watch)
    }

    /// One step, with the circulations of the model that flew where these are wanted.
    fn advance(&self, lattice: &mut Lattice, watch: &mut CourseWatch<'_>, k: usize) -> Result<(), Error> {
        let t = k as f64 * self.clock.step_s();
        match self.flown.as_ref().filter(|flown| flown.by_model) {
            None => {
                let loads = lattice.step()?;
                watch.see(k, lattice, Some(&loads));
            }
            Some(flown) => {
                let rings = flown.flight.circulations(flown.from_s + t, &flown.layouts)?;
                lattice.step_with(&rings.unwrap_or_default())?;
                watch.see(k, lattice, None);
            }
        }
        Ok(())
    }

    /// Whether the wings move as their mirror images at the plane of flight and up.
    pub fn is_symmetric(&self) -> bool {
        let end = self.clock.total() as f64 * self.clock.step_s();
        let mut edges: Vec<Vec<SectionMotion<f64>>> = vec![Vec::new(); self.scene.surfaces.len()];
        (0..COMPARED).all(|k| {
            let t = end * k as f64 / COMPARED as f64;
            for (surface, edges) in self.scene.surfaces.iter().zip(&mut edges) {
                surface.sections.sections(t, &surface.layout.arcs, edges);
            }
            let origin = self.origin(t);
            let at = |p: Vec3| self.axes.of(p - origin);
            self.groups.iter().all(|group| {
                let all = || edges[group.clone()].iter().flatten().flat_map(|edge| [edge.le, edge.te]);
                let back = edges[group.clone()].iter().flatten().rev().flat_map(|edge| [edge.le, edge.te]);
                all().zip(back).all(|(a, b)| {
                    let (a, b) = (at(a), at(b));
                    (a - Vec3::new(b[0], -b[1], b[2])).norm() < SYMMETRIC * self.chord
                })
            })
        })
    }
}
