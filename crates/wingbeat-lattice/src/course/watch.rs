//! What is kept of a stepped lattice.

use super::{LatticeCourse, PHASES};
use crate::mesh::EdgeInflow;
use crate::{Lattice, LatticeLoads, Mesh, VortexPicture};
use serde::Serialize;
use wingbeat::math::{Vec3, Wrench};
use wingbeat::simulate::{Column, Record};

/// The lattice at one of the phases.
#[derive(Clone, Debug)]
pub struct LatticeShot {
    /// Name of the phase.
    pub name: String,
    /// Share of the last cycle.
    pub phase: f64,
    /// Rings of wing and wake.
    pub picture: VortexPicture,
    /// Leading and trailing edges of the surfaces, m in W.
    pub edges: Vec<Vec<Vec3>>,
    /// The body's origin, m in W.
    pub origin: Vec3,
}

/// The ring of a wake with the largest circulation.
#[derive(Clone, Debug, Serialize)]
pub struct Strongest {
    /// Its circulation, m2/s.
    pub circulation_m2_s: f64,
    /// Cycles since it was shed.
    pub shed_before_cycles: f64,
    /// Whether that was in a downstroke.
    pub in_downstroke: bool,
}

/// Force that is rounding, over density times the square of speed and mean chord. *Choice.*
const NO_FORCE: f64 = 1e-6;

/// What is gathered step by step.
pub struct CourseWatch<'a> {
    /// What was stepped through.
    pub course: &'a LatticeCourse,
    /// Loads in W about the body's origin and mean bound circulations by step; positive ones lift the wing's upper side.
    pub record: Record,
    /// The four phases of the last cycle.
    pub shots: Vec<LatticeShot>,
    /// Sum of all circulations shed and bound, over the largest (Kelvin).
    pub circulation_error: f64,
    /// Why the lattice ended before the course did.
    pub failed: Option<String>,
    /// True where `progress` ended it.
    pub ended: bool,
    /// Largest way in a step of a vortex that has left a leading edge, mean chords.
    pub farthest: f64,
    /// Drag, N, of the wake that the last circulations would leave, and the width of the wings across the wind, m.
    pub far: Option<(f64, f64)>,
    /// Sum and count of the share of strips that shed at the leading edge, over the last cycle.
    shed: (f64, f64),
    /// Over the last cycle.
    inflow: EdgeInflow,
    asymmetry: f64,
    largest: f64,
}

#[inline(never)]
fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[inline(never)]
fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64
}

fn columns(with_loads: bool) -> Vec<Column> {
    let mut columns = vec![Column::new("t", "s", ""), Column::new("phase", "cycles", "")];
    for way in ["joukowski", "bernoulli", "suction"].into_iter().filter(|_| with_loads) {
        columns.extend(["x", "y", "z"].map(|axis| Column::new(format!("{way}_force_{axis}"), "N", "W")));
        columns.extend(["x", "y", "z"].map(|axis| Column::new(format!("{way}_moment_{axis}"), "N m", "W")));
    }
    columns.extend(["left", "right"].map(|side| Column::new(format!("circulation_{side}"), "m2/s", "")));
    columns
}

/// Circulations of each surface.
fn by_surface<'a>(meshes: &'a [Mesh], mut rings: &'a [f64]) -> Vec<(&'a Mesh, &'a [f64])> {
    let own = |mesh: &'a Mesh| {
        let (own, rest) = rings.split_at(mesh.panels());
        rings = rest;
        (mesh, own)
    };
    meshes.iter().map(own).collect()
}

impl<'a> CourseWatch<'a> {
    pub(super) fn new(course: &'a LatticeCourse) -> Self {
        let with_loads = !course.flown.as_ref().is_some_and(|flown| flown.by_model);
        Self {
            record: Record::new(columns(with_loads), course.clock.total()).unwrap_or_default(),
            course,
            shots: Vec::new(),
            circulation_error: 0.0,
            failed: None,
            ended: false,
            farthest: 0.0,
            far: None,
            shed: (0.0, 0.0),
            inflow: EdgeInflow::default(),
            asymmetry: 0.0,
            largest: 0.0,
        }
    }

    /// Beginning of the names of the course's files.
    pub fn prefix(&self) -> String {
        match self.course.name.as_str() {
            "" => String::new(),
            name => format!("{name}_"),
        }
    }

    /// Takes in step `k`; a model's circulations have no loads of the lattice.
    pub(super) fn see(&mut self, k: usize, lattice: &Lattice, loads: Option<&LatticeLoads>) {
        let (course, clock) = (self.course, self.course.clock);
        let time = k as f64 * clock.step_s();
        let origin = course.origin(time);
        // About the body's origin.
        let parts = |w: &Wrench<f64>| [w.force.0, (w.moment - origin.cross(w.force)).0].concat();
        let wrenches = loads.map(|loads| [&loads.joukowski, &loads.bernoulli, &loads.suction]);
        let sides = self.mean_circulations(lattice, origin);
        let instant = [time, time * clock.frequency_hz];
        let loads = wrenches.into_iter().flatten().flat_map(parts);
        let row: Vec<f64> =
            instant.into_iter().chain(loads).chain(sides.map(Option::unwrap_or_default)).collect();
        self.record.append(&row);
        self.compare_sides(lattice);
        let first_of_last = clock.first_of_last();
        if k < first_of_last {
            return;
        }
        self.inflow.add(lattice.meshes(), lattice.scene().wind);
        self.shed = (self.shed.0 + lattice.shed_share(), self.shed.1 + 1.0);
        let at = |i: &usize| course.stroke.steps.is_some_and(|steps| steps[*i] == k);
        for i in (0..4).filter(at) {
            self.shoot(PHASES[i], course.stroke.phases[i], lattice, time);
        }
        if course.stroke.steps.is_none() && k + 1 == clock.total() {
            self.shoot("end of the run", 1.0, lattice, time);
        }
    }

    fn shoot(&mut self, name: &str, phase: f64, lattice: &Lattice, time: f64) {
        let edges = lattice.meshes().iter().flat_map(|mesh| {
            [mesh.edges.iter().map(|e| e.le).collect(), mesh.edges.iter().map(|e| e.te).collect()]
        });
        self.shots.push(LatticeShot {
            name: name.into(),
            phase,
            picture: VortexPicture::new(lattice, time),
            edges: edges.collect(),
            origin: self.course.origin(time),
        });
    }

    /// Rings of left and right, which mirror each other where the motion does.
    fn compare_sides(&mut self, lattice: &Lattice) {
        let parts = by_surface(lattice.meshes(), lattice.rings());
        for group in &self.course.groups {
            let own = &parts[group.clone()];
            for ((mesh, a), (_, b)) in own.iter().zip(own.iter().rev()) {
                let n = mesh.strips;
                for (i, ring) in a.iter().enumerate() {
                    let mirrored = b.get(i / n * n + n - 1 - i % n);
                    self.largest = self.largest.max(ring.abs());
                    self.asymmetry = self.asymmetry.max(mirrored.map_or(0.0, |other| (ring - other).abs()));
                }
            }
        }
    }

    /// Mean bound circulation by width of the left and right half of the first surface, m2/s; positive lifts the wing's upper side.
    fn mean_circulations(&self, lattice: &Lattice, origin: Vec3) -> [Option<f64>; 2] {
        let (mut sums, mut widths) = ([0.0; 2], [0.0; 2]);
        let parts = by_surface(lattice.meshes(), lattice.rings());
        let first = self.course.groups.first().cloned().unwrap_or(0..parts.len());
        for (mesh, own) in &parts[first] {
            let last = &own[own.len() - mesh.strips..];
            for (ring, pair) in last.iter().zip(mesh.edges.windows(2)) {
                let width = (pair[1].le - pair[0].le).norm();
                let middle = (pair[0].le + pair[1].le) * 0.5 - origin;
                let side = usize::from(middle.dot(self.course.axes.left) < 0.0);
                sums[side] += ring * width;
                widths[side] += width;
            }
        }
        [0, 1].map(|side| (widths[side] > 0.0).then(|| sums[side] / widths[side]))
    }

    /// Mean bound circulation of a half (0 left, 1 right) over the down- (0) or upstroke (1) of the last cycle, m2/s; positive lifts the wing's
    /// upper side.
    pub fn circulation(&self, side: usize, stroke: usize) -> Option<f64> {
        self.course.stroke.steps?;
        let values = self.last_cycle(["circulation_left", "circulation_right"][side])?;
        Some(self.course.stroke.means(values)[stroke]).filter(|_| values.iter().any(|value| *value != 0.0))
    }

    /// The same over the last cycle but one.
    fn cycle_before(&self, name: &str) -> Option<&[f64]> {
        let (last, steps) = (self.course.clock.first_of_last(), self.course.clock.steps);
        self.record.values(name)?.get(last.checked_sub(steps)?..last)
    }

    /// A column of the record over the last cycle; none before all of it has been stepped.
    fn last_cycle(&self, name: &str) -> Option<&[f64]> {
        let (first, steps) = (self.course.clock.first_of_last(), self.course.clock.steps);
        self.record.values(name)?.get(first..first + steps)
    }

    /// The strongest ring of the wake of a shot, and when it was shed; nothing of a wing that does not stroke.
    pub fn strongest(&self, shot: &LatticeShot) -> Option<Strongest> {
        let (clock, stroke) = (&self.course.clock, &self.course.stroke);
        stroke.steps?;
        let (ring, age) = shot.picture.strongest()?;
        let shed_before_cycles = age as f64 / clock.steps as f64;
        let in_downstroke = stroke.is_down(shot.phase - shed_before_cycles);
        Some(Strongest { circulation_m2_s: ring.circulation, shed_before_cycles, in_downstroke })
    }

    /// Largest difference between a ring and its mirror image, over the largest ring; none where the motion is not symmetric.
    pub fn symmetry_error(&self) -> Option<f64> {
        (self.course.symmetric && self.largest > 0.0).then(|| self.asymmetry / self.largest)
    }

    /// Share of strips and instants of the last cycle that shed at the leading edge; none in attached flow.
    pub fn shed(&self) -> Option<f64> {
        self.course.critical_suction.map(|_| self.shed.0 / f64::max(self.shed.1, 1.0))
    }

    /// Share of trailing edges and steps of the last cycle at which the air comes in.
    pub fn inflow(&self) -> f64 {
        self.inflow.share()
    }

    /// Root mean square over the last cycle of the difference of the forces by Joukowski and by Bernoulli over that of the latter; none of a
    /// model's circulations, or where they are rounding.
    pub fn apart(&self) -> Option<f64> {
        let (mut apart, mut all) = (0.0, 0.0);
        for axis in ["x", "y", "z"] {
            let [own, other] =
                ["joukowski", "bernoulli"].map(|way| self.last_cycle(&format!("{way}_force_{axis}")));
            for (own, other) in own?.iter().zip(other?) {
                (apart, all) = (apart + (own - other).powi(2), all + other * other);
            }
        }
        (all > self.course.clock.steps as f64 * self.no_force().powi(2)).then(|| (apart / all).sqrt())
    }

    /// Force, N, below which it is rounding.
    fn no_force(&self) -> f64 {
        let (scene, clock) = (&self.course.scene, self.course.clock);
        let speed = scene.edge_speed(clock.total() as f64 * clock.step_s());
        NO_FORCE * scene.density_kg_m3 * (speed * self.course.chord).powi(2)
    }

    /// Change of the mean force by Joukowski from the last cycle but one to the last, over its root mean square in the last, dimensionless; none of a flight,
    /// whose cycles differ, of a motion that does not repeat, of a single cycle, or of forces that are rounding.
    pub fn cycle_change(&self) -> Option<f64> {
        self.course.moved.filter(|moved| moved.is_still || moved.repeated.is_some())?;
        let (mut change, mut all) = (0.0, 0.0);
        for axis in ["x", "y", "z"] {
            let name = format!("joukowski_force_{axis}");
            let [last, earlier] = [self.last_cycle(&name)?, self.cycle_before(&name)?];
            change += (mean(last) - mean(earlier)).powi(2);
            all += mean_square(last);
        }
        (all > self.no_force().powi(2)).then(|| (change / all).sqrt())
    }

    /// Largest relative change of the mean bound circulation of a half within the last cycle, over it: none of a steady wing.
    pub fn unsteadiness(&self) -> Option<f64> {
        let of = |side: &str| {
            let last = self.last_cycle(&format!("circulation_{side}"))?;
            let least = last.iter().copied().fold(f64::INFINITY, f64::min);
            let most = last.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let largest = most.max(-least);
            (largest > 0.0).then(|| (most - least) / largest)
        };
        of("left").into_iter().chain(of("right")).reduce(f64::max)
    }

    /// Mean over the last cycle of the force along `axis`, N.
    pub fn mean(&self, way: &str, axis: Vec3) -> Option<f64> {
        let columns = ["x", "y", "z"].map(|name| self.record.values(&format!("{way}_force_{name}")));
        let first = self.course.clock.first_of_last();
        let count = self.record.rows().checked_sub(first).filter(|count| *count > 0)?;
        let mut sum = 0.0;
        for (k, column) in columns.into_iter().enumerate() {
            sum += column?[first..].iter().sum::<f64>() * axis[k];
        }
        Some(sum / count as f64)
    }
}
