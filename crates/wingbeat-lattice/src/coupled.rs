//! The lattice beside a robot in flight: both are stepped together.

use crate::course::MOST_RINGS;
use crate::flown::laid;
use crate::layout::{Layout, Spacing};
use crate::motion::{Panels, Scene, Sections, Surface};
use crate::settings::{Settings, WakeMotion};
use crate::{Error, Lattice};
use std::sync::{Arc, Mutex, PoisonError};
use wingbeat::aero::SectionMotion;
use wingbeat::math::{Quat, Vec3, Wrench};
use wingbeat::plant::Fault;
use wingbeat::robot::{Robot, SurfaceOutline};
use wingbeat::scenario::{Doors, LatticeSpec, LatticeTask};
use wingbeat::simulate::Flow;

/// What a scenario may choose, with the lattice of `[lattice]`.
///
/// ```
/// use std::ops::ControlFlow;
/// use wingbeat::scenario::{Document, Scenario};
///
/// let glide = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/glide.toml");
/// let document = Document::file(glide.as_ref())?.set("lattice.step_s=0.01").set("flight.duration_s=0.05");
/// let scenario = Scenario::open(document, &wingbeat_lattice::doors())?;
/// let run = scenario.fly(|_| ControlFlow::Continue(()))?;
/// assert!(run.summary.lattice.is_some_and(|lattice| lattice.steps == 5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn doors() -> Doors {
    Doors::shipped().lattice(|task| match Beside::new(&task) {
        Ok(beside) => Ok(Box::new(beside)),
        Err(error) => Err(refused(error, task.spec)),
    })
}

/// What the lattice refuses, by the keys of a scenario.
fn refused(error: Error, spec: &LatticeSpec) -> wingbeat::Error {
    match error {
        Error::Setting { key, value, allowed } => {
            let (chordwise, spanwise) = (spec.chordwise, spec.spanwise);
            let key = match key {
                "core.radius_m" => {
                    let given = format!("{} (a radius of {value} m)", spec.core_chords);
                    return wingbeat::Error::invalid("lattice.core_chords", given, allowed);
                }
                "panels" => {
                    let given = format!("{chordwise} by {spanwise} makes {value} panels");
                    return wingbeat::Error::invalid("lattice.chordwise", given, allowed);
                }
                "zero_lift_angle_deg" => format!("aero.{key}"),
                key => format!("lattice.{key}"),
            };
            wingbeat::Error::invalid(key, value, allowed)
        }
        Error::Rings { rings, most } => {
            let allowed = format!("steps whose wake has at most {most} rings: give lattice.longest_age_s");
            wingbeat::Error::invalid("lattice.step_s", format!("{rings} rings of the wake"), allowed)
        }
        Error::Layout(error) => {
            let allowed = error.0.split_once("allowed is ").map_or(error.0.as_str(), |(_, allowed)| allowed);
            wingbeat::Error::invalid("lattice.spanwise", spec.spanwise, allowed)
        }
        error => wingbeat::Error::invalid("lattice", "given", error.to_string()),
    }
}

/// Time and state in which the surfaces are.
type Pose = Arc<Mutex<(f64, Vec<f64>)>>;

/// A surface of a robot in the state that is being tried.
struct Posed {
    robot: Arc<Robot>,
    surface: usize,
    pose: Pose,
}

impl Sections for Posed {
    fn sections(&self, _: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        let pose = self.pose.lock().unwrap_or_else(PoisonError::into_inner);
        let (t, x) = (pose.0, &pose.1);
        if self.robot.chord_lines(t, x, self.surface, arcs, out).is_err() {
            // Found by the lattice as a panel that is not finite.
            let nowhere = Vec3::new(f64::NAN, f64::NAN, f64::NAN);
            out.clear();
            out.resize(arcs.len(), SectionMotion { le: nowhere, te: nowhere, ..SectionMotion::default() });
        }
    }
}

/// A lattice on the surfaces of a robot, stepped beside its flight.
pub struct Beside {
    robot: Arc<Robot>,
    lattice: Lattice,
    layouts: Vec<(usize, Layout)>,
    pose: Pose,
    every: usize,
    chord: f64,
}

/// Mean chord of a surface, m.
fn mean_chord(outline: &SurfaceOutline) -> f64 {
    outline.planform.area() / (2.0 * outline.planform.half_span())
}

impl Beside {
    /// The lattice that `task` asks for.
    ///
    /// # Errors
    /// Sections that lift at no incidence, panels that cannot be laid out, settings that are not allowed, a wake of too many rings.
    pub fn new(task: &LatticeTask<'_>) -> Result<Self, Error> {
        let LatticeTask { spec, robot, outlines, density_kg_m3, every, steps } = task;
        let (chordwise, spanwise) = (spec.chordwise, spec.spanwise);
        let panels = Panels { chordwise, spanwise, spacing: Spacing::Lan };
        let layouts = laid(robot, outlines, panels)?;
        let longest_age_s = spec.longest_age_s.unwrap_or(f64::INFINITY);
        let rows = (*steps as f64).min(longest_age_s / spec.step_s);
        let rings = rows * layouts.iter().map(|(_, layout)| layout.strips()).sum::<usize>() as f64;
        if rings > MOST_RINGS as f64 {
            return Err(Error::Rings { rings: rings as usize, most: MOST_RINGS });
        }
        let chord = outlines.first().map_or(1.0, mean_chord);
        let (robot, pose) = (Arc::new((*robot).clone()), Pose::default());
        let mut x = vec![0.0; robot.layout().len];
        Quat::IDENTITY.store_wxyz(&mut x[robot.layout().attitude..]);
        let coordinates = robot.start_coordinates();
        x[robot.layout().joints..][..coordinates.len()].copy_from_slice(&coordinates);
        *pose.lock().unwrap_or_else(PoisonError::into_inner) = (0.0, x);
        let surface = |(number, layout): &(usize, Layout)| {
            let posed = Posed { robot: robot.clone(), surface: *number, pose: pose.clone() };
            Surface { layout: layout.clone(), sections: Arc::new(posed) }
        };
        let scene = Scene {
            surfaces: layouts.iter().map(surface).collect(),
            wind: robot.mean_wind(),
            density_kg_m3: *density_kg_m3,
            symmetric: false,
        };
        let wake = if spec.free_wake { WakeMotion::Free } else { WakeMotion::Prescribed };
        let own = Settings::new(spec.step_s, spec.core_chords * chord);
        let settings = Settings { wake, longest_age_s, fast_from: crate::course::FAST_FROM, ..own };
        let lattice = Lattice::new(scene, settings)?;
        Ok(Self { robot, lattice, layouts, pose, every: *every, chord })
    }
}

impl Flow for Beside {
    fn every(&self) -> usize {
        self.every
    }

    fn length(&self) -> f64 {
        self.chord
    }

    fn loads(&mut self, t: f64, x: &[f64]) -> Result<Vec<Wrench<f64>>, Fault> {
        {
            let mut pose = self.pose.lock().unwrap_or_else(PoisonError::into_inner);
            pose.0 = t;
            pose.1.clear();
            pose.1.extend_from_slice(x);
        }
        self.lattice.set_wind(self.robot.wind_over_time().at(t).0);
        let loads = self.lattice.attempt().map_err(|error| fault(t, &error))?;
        let layout = self.robot.layout();
        let attitude = Quat::from_wxyz(&x[layout.attitude..]).matrix();
        let origin = Vec3::from_slice(&x[layout.position..]);
        let in_body = |load: &Wrench<f64>| Wrench {
            force: attitude.transpose_mul(load.force),
            moment: attitude.transpose_mul(load.moment - origin.cross(load.force)),
        };
        let mut borne = vec![Wrench::ZERO; self.robot.bearers()];
        for ((number, layout), panels) in self.layouts.iter().zip(&loads.panels) {
            let strips: Vec<Wrench<f64>> = panels.strips.iter().map(in_body).collect();
            self.robot.bear(t, x, (*number, &layout.arcs), &strips, &mut borne)?;
        }
        Ok(borne)
    }

    fn keep(&mut self) {
        self.lattice.keep();
    }
}

/// Why the lattice cannot be stepped.
fn fault(time: f64, error: &Error) -> Fault {
    let why = match error {
        Error::Singular { .. } => {
            "the lattice's panels do not determine their circulations: surfaces touch or cross"
        }
        _ => "the lattice gives numbers that are not finite",
    };
    Fault::Flow { time, why }
}
