//! The lattice beside a robot in flight: both are stepped together.

use crate::course::{CROSSING, FAST_FROM, MOST_RINGS};
use crate::flown::laid;
use crate::layout::{PanelLayout, Spacing};
use crate::mesh::{EdgeInflow, Mesh};
use crate::motion::{LatticeSurface, MovingSections, Panels, Scene};
use crate::settings::{LatticeSettings, WakeMotion};
use crate::skin::{BentPiece, SurfaceEdges};
use crate::{Error, Lattice};
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};
use wingbeat::aero::{ChordBend, FlapSpec, SectionMotion};
use wingbeat::math::{Dual, Quat, Vec3, Wrench};
use wingbeat::plant::Fault;
use wingbeat::robot::{BeyondLoads, Robot, Stance, SurfaceOutline};
use wingbeat::scenario::{Doors, LatticeSpec, LatticeTask};
use wingbeat::simulate::{Fineness, Flow};

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
    Doors::shipped().lattice(|task| match CoupledLattice::new(&task) {
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
        Error::FlapEnds => {
            let allowed = "none beside a flap that ends before the tip or begins behind the root: panels beside its end lose part of its inertia";
            wingbeat::Error::invalid("lattice", "given", allowed)
        }
        error => wingbeat::Error::invalid("lattice", "given", error.to_string()),
    }
}

/// How the robot is whose surfaces are asked for.
type SharedStance = Arc<Mutex<Stance>>;

/// A surface of a robot in the state that is being tried.
struct Posed {
    robot: Arc<Robot>,
    edges: SurfaceEdges,
    /// Where its surface stands among all that bends.
    bends: Range<usize>,
    pose: SharedStance,
}

impl MovingSections for Posed {
    fn sections(&self, _: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        let pose = self.pose.lock().unwrap_or_else(PoisonError::into_inner);
        self.edges.sections(&self.robot, &pose, arcs, out);
    }

    fn bends(&self, _: f64, _: &[f64], out: &mut Vec<ChordBend<Dual<1>>>) {
        out.clear();
        let pose = self.pose.lock().unwrap_or_else(PoisonError::into_inner);
        if let (Some(edges), Some(bent)) = (&self.edges.bends, pose.bends.get(self.bends.clone())) {
            edges.bends(bent, out);
        }
    }
}

/// A lattice on the surfaces of a robot, stepped beside its flight.
pub struct CoupledLattice {
    robot: Arc<Robot>,
    lattice: Lattice,
    layouts: Vec<(usize, PanelLayout)>,
    /// What bends, by layout, and how much of it the robot has.
    bent: Vec<Option<BentPiece>>,
    bends: usize,
    pose: SharedStance,
    every: usize,
    chord: f64,
    /// What was asked for last at this instant, with its loads.
    last: Option<(Stance, BeyondLoads)>,
    way: EdgeTravel,
}

/// Ways of trailing edges through the air in steps in which they moved.
#[derive(Default)]
struct EdgeTravel {
    edges: usize,
    /// Sums of squares, m2 and chords of a panel.
    squares: [f64; 2],
    inflow: EdgeInflow,
}

impl EdgeTravel {
    /// Goes on by those of `meshes` in a step of `step` s.
    fn go(&mut self, meshes: &[Mesh], wind: Vec3, step: f64) {
        self.inflow.add(meshes, wind);
        for (mesh, edge) in meshes.iter().flat_map(|mesh| mesh.edges.iter().map(move |edge| (mesh, edge))) {
            let way = (edge.v_te - wind).norm() * step;
            if way > 0.0 {
                let panels = way * mesh.chordwise as f64 / mesh.mean_chord();
                self.edges += 1;
                self.squares = [self.squares[0] + way * way, self.squares[1] + panels * panels];
            }
        }
    }
}

/// Mean chord of a surface, m.
fn mean_chord(outline: &SurfaceOutline) -> f64 {
    outline.planform.mean_chord()
}

impl CoupledLattice {
    /// The lattice that `task` asks for.
    ///
    /// # Errors
    /// Flaps over part of the span, sections that lift at no incidence, panels that cannot be laid out, settings that are not allowed, a wake of too many rings.
    pub fn new(task: &LatticeTask<'_>) -> Result<Self, Error> {
        let LatticeTask { spec, robot, outlines, density_kg_m3, every, steps } = task;
        let (chordwise, spanwise) = (spec.chordwise, spec.spanwise);
        let panels = Panels { chordwise, spanwise, spacing: Spacing::Lan };
        for ((_, aero), outline) in robot.surfaces().zip(outlines) {
            let tip = outline.planform.station_arcs().last().map_or(0.0, |arc| *arc);
            let ends = |flap: FlapSpec| flap.from_arc_m > 0.0 || flap.to_arc_m.is_some_and(|end| end < tip);
            if aero.flap().and_then(|model| model.settings().flap).is_some_and(ends) {
                return Err(Error::FlapEnds);
            }
        }
        let layouts = laid(robot, outlines, panels)?;
        let longest_age_s = spec.longest_age_s.unwrap_or(f64::INFINITY);
        let rows = (*steps as f64).min(longest_age_s / spec.step_s);
        let edges = if spec.critical_suction.is_some() { 2.0 } else { 1.0 };
        let rings = edges * rows * layouts.iter().map(|(_, layout)| layout.strips()).sum::<usize>() as f64;
        if rings > MOST_RINGS as f64 {
            return Err(Error::Rings { rings: rings as usize, most: MOST_RINGS });
        }
        let chord = outlines.first().map_or(1.0, mean_chord);
        let robot = Arc::new((*robot).clone());
        let mut x = vec![0.0; robot.layout().len];
        Quat::IDENTITY.store_wxyz(&mut x[robot.layout().attitude..]);
        let coordinates = robot.start_coordinates();
        x[robot.layout().joints..][..coordinates.len()].copy_from_slice(&coordinates);
        let pose = Arc::new(Mutex::new(robot.stance(0.0, &x)));
        let mut bends = 0;
        let mut places = Vec::new();
        for (_, aero) in robot.surfaces() {
            let first = bends;
            bends += aero.bent_states().len();
            places.push(first..bends);
        }
        let piece = |(number, layout): &(usize, PanelLayout)| {
            let (_, aero) = robot.surfaces().nth(*number)?;
            BentPiece::new(aero, layout, places[*number].start)
        };
        let bent = layouts.iter().map(piece).collect();
        let surface = |piece: &(usize, PanelLayout)| {
            let bends = places[piece.0].clone();
            let edges = SurfaceEdges::new(&robot, piece);
            let posed = Posed { robot: robot.clone(), edges, bends, pose: pose.clone() };
            LatticeSurface { layout: piece.1.clone(), sections: Arc::new(posed) }
        };
        let scene = Scene {
            surfaces: layouts.iter().map(surface).collect(),
            wind: robot.mean_wind(),
            density_kg_m3: *density_kg_m3,
            symmetric: false,
            ground: robot.ground(),
        };
        let wake = if spec.free_wake { WakeMotion::Free } else { WakeMotion::Prescribed };
        let own = LatticeSettings::new(spec.step_s, spec.core_chords * chord);
        let crossing = if spec.crossing { CROSSING } else { 0.0 };
        let own = own.shedding(spec.critical_suction, chord);
        let settings = LatticeSettings { wake, longest_age_s, crossing, fast_from: FAST_FROM, ..own };
        let lattice = Lattice::new(scene, settings)?;
        Ok(Self {
            robot,
            lattice,
            layouts,
            bent,
            bends,
            pose,
            every: *every,
            chord,
            last: None,
            way: EdgeTravel::default(),
        })
    }
}

impl Flow for CoupledLattice {
    fn every(&self) -> usize {
        self.every
    }

    fn length(&self) -> f64 {
        self.chord
    }

    fn loads(&mut self, t: f64, at: &Stance) -> Result<BeyondLoads, Fault> {
        if let Some((_, borne)) = self.last.as_ref().filter(|(last, _)| last == at) {
            return Ok(borne.clone());
        }
        self.pose.lock().unwrap_or_else(PoisonError::into_inner).clone_from(at);
        self.lattice.set_wind(self.robot.wind_over_time().at(t).0);
        let loads = self.lattice.attempt().map_err(|error| fault(t, &error))?;
        let (attitude, origin) = (at.attitude, at.origin);
        let in_body = |load: &Wrench<f64>| Wrench {
            force: attitude.transpose_mul(load.force),
            moment: attitude.transpose_mul(load.moment - origin.cross(load.force)),
        };
        let mut borne = BeyondLoads {
            links: std::iter::repeat_n(Wrench::ZERO, self.robot.bearers()).collect(),
            bends: vec![0.0; self.bends],
        };
        let step = self.lattice.settings().step_s;
        let pieces = self.layouts.iter().zip(self.lattice.meshes()).zip(&mut self.bent);
        for ((((number, layout), mesh), bent), panels) in pieces.zip(&loads.panels) {
            let mut strips = panels.strips.clone();
            if let Some(bent) = bent {
                bent.bear(mesh, panels, step, &mut borne.bends, &mut strips);
            }
            let strips: Vec<Wrench<f64>> = strips.iter().map(in_body).collect();
            self.robot.bear(at, (*number, &layout.arcs), &strips, &mut borne.links)?;
        }
        self.last = Some((at.clone(), borne.clone()));
        Ok(borne)
    }

    fn keep(&mut self) {
        self.last = None;
        self.bent.iter_mut().flatten().for_each(BentPiece::keep);
        let (wind, step) = (self.lattice.scene().wind, self.lattice.settings().step_s);
        self.way.go(self.lattice.meshes(), wind, step);
        self.lattice.keep();
    }

    fn fineness(&self) -> Fineness {
        let [way, panels] = self.way.squares.map(|sum| (sum / self.way.edges.max(1) as f64).sqrt());
        let settings = self.lattice.settings();
        let sheet = settings.critical_suction.map(|_| self.lattice.farthest() / self.chord);
        let inflow = self.way.inflow.share();
        Fineness { panels, cores: way / settings.core.radius_m, sheet, inflow }
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
