//! What is kept of a stepped lattice.

use serde::Serialize;
use wingbeat::math::{Vec3, Wrench};
use wingbeat::scenario::TetherCase;
use wingbeat::simulate::{Column, Record};
use wingbeat::tether::Tether;
use wingbeat_lattice::{Lattice, Loads, Picture};

use super::stroke::{NAMES, Stroke};
use crate::args::Wake;

/// Difference of left and right, over the largest ring, above which there is a caution. *Choice.*
const DRIFTED: f64 = 0.01;

/// The wind's axes in W: direction of flight, left, up.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    pub flight: Vec3,
    pub left: Vec3,
    pub up: Vec3,
}

impl Axes {
    /// Without wind flight is along x.
    fn new(wind: Vec3) -> Self {
        let flight = if wind.norm() > 0.0 { -wind.unit() } else { Vec3::new(1.0, 0.0, 0.0) };
        let upward = if flight[0].hypot(flight[1]) > 1e-9 {
            Vec3::new(0.0, 0.0, 1.0)
        } else {
            Vec3::new(-1.0, 0.0, 0.0)
        };
        let up = (upward - flight * upward.dot(flight)).unit();
        Self { flight, left: up.cross(flight), up }
    }
}

/// The lattice at one of the phases.
pub struct Shot {
    pub name: String,
    pub phase: f64,
    pub picture: Picture,
    /// Leading and trailing edges of the surfaces.
    pub edges: Vec<Vec<Vec3>>,
}

/// What is gathered step by step.
pub struct Watch {
    pub record: Record,
    pub shots: Vec<Shot>,
    pub axes: Axes,
    pub chord: f64,
    pub circulation_error: f64,
    pub failed: Option<String>,
    stroke: Stroke,
    steps: usize,
    first_of_last: usize,
    frequency: f64,
    symmetric: bool,
    asymmetry: f64,
    largest: f64,
    /// Sum and count of the mean bound circulation of the left and right half, in down- and upstroke.
    halves: [[(f64, f64); 2]; 2],
}

/// Ratio of downstroke to upstroke.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DownOverUp {
    pub left: Option<f64>,
    pub right: Option<f64>,
}

/// `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    pub status: String,
    pub name: String,
    pub wake: &'static str,
    pub panels: [usize; 2],
    pub steps_per_cycle: usize,
    pub core_m: f64,
    pub mean_lift_n: Option<f64>,
    pub mean_lift_bernoulli_n: Option<f64>,
    pub mean_drag_n: Option<f64>,
    pub mean_drag_bernoulli_n: Option<f64>,
    pub circulation_error: f64,
    pub symmetry_error: Option<f64>,
    pub down_over_up: DownOverUp,
    pub phases: Vec<(String, f64)>,
    pub warnings: Vec<String>,
}

fn columns() -> Vec<Column> {
    let mut columns = vec![Column::new("t", "s", ""), Column::new("phase", "cycles", "")];
    for way in ["joukowski", "bernoulli", "suction"] {
        columns.extend(["x", "y", "z"].map(|axis| Column::new(format!("{way}_force_{axis}"), "N", "W")));
        columns.extend(["x", "y", "z"].map(|axis| Column::new(format!("{way}_moment_{axis}"), "N m", "W")));
    }
    columns
}

impl Watch {
    pub fn new(tether: &Tether, stroke: Stroke, steps: usize, symmetric: bool) -> Self {
        let clock = tether.clock;
        Self {
            record: Record::new(columns(), clock.cycles * steps).unwrap_or_default(),
            shots: Vec::new(),
            axes: Axes::new(tether.wind),
            chord: tether.reference.chord_m,
            circulation_error: 0.0,
            failed: None,
            stroke,
            steps,
            first_of_last: (clock.cycles - 1) * steps,
            frequency: clock.frequency_hz,
            symmetric,
            asymmetry: 0.0,
            largest: 0.0,
            halves: [[(0.0, 0.0); 2]; 2],
        }
    }

    /// Takes in step `k`.
    pub fn see(&mut self, k: usize, lattice: &Lattice, loads: &Loads) {
        let parts = |w: &Wrench<f64>| [w.force.0, w.moment.0].concat();
        let wrenches = [&loads.joukowski, &loads.bernoulli, &loads.suction];
        let time = [loads.time, loads.time * self.frequency];
        let row: Vec<f64> = time.into_iter().chain(wrenches.into_iter().flat_map(parts)).collect();
        self.record.append(&row);
        self.compare_sides(lattice);
        if k < self.first_of_last {
            return;
        }
        let phase = ((k - self.first_of_last) as f64 + 0.5) / self.steps as f64;
        self.add_circulation(lattice, usize::from(!self.stroke.is_down(phase)));
        let shots: Vec<usize> =
            (0..4).filter(|i| self.stroke.steps.is_some_and(|steps| steps[*i] == k)).collect();
        for i in shots {
            self.shoot(NAMES[i], self.stroke.phases[i], lattice, loads.time);
        }
        if self.stroke.steps.is_none() && k + 1 == self.first_of_last + self.steps {
            self.shoot("end of the run", 1.0, lattice, loads.time);
        }
    }

    fn shoot(&mut self, name: &str, phase: f64, lattice: &Lattice, time: f64) {
        let edges = lattice.meshes().iter().flat_map(|mesh| {
            [mesh.edges.iter().map(|e| e.le).collect(), mesh.edges.iter().map(|e| e.te).collect()]
        });
        self.shots.push(Shot {
            name: name.into(),
            phase,
            picture: Picture::new(lattice, time),
            edges: edges.collect(),
        });
    }

    /// Rings of left and right, which mirror each other where the motion does.
    fn compare_sides(&mut self, lattice: &Lattice) {
        let mut parts = Vec::new();
        let mut rings = lattice.rings();
        for mesh in lattice.meshes() {
            let (own, rest) = rings.split_at(mesh.panels());
            parts.push((mesh.strips, own));
            rings = rest;
        }
        for ((n, a), (m, b)) in parts.iter().zip(parts.iter().rev()) {
            if n != m || a.len() != b.len() {
                continue;
            }
            for (i, ring) in a.iter().enumerate() {
                let (row, j) = (i / n, i % n);
                self.largest = self.largest.max(ring.abs());
                self.asymmetry = self.asymmetry.max((ring - b[row * n + n - 1 - j]).abs());
            }
        }
    }

    /// Adds the bound circulation of each half, by width, to that of down- (0) or upstroke (1).
    fn add_circulation(&mut self, lattice: &Lattice, stroke: usize) {
        let (mut sums, mut widths) = ([0.0; 2], [0.0; 2]);
        let mut rings = lattice.rings();
        for mesh in lattice.meshes() {
            let (own, rest) = rings.split_at(mesh.panels());
            rings = rest;
            let last = &own[own.len() - mesh.strips..];
            for (ring, pair) in last.iter().zip(mesh.edges.windows(2)) {
                let width = (pair[1].le - pair[0].le).norm();
                let side = usize::from((pair[0].le + pair[1].le).dot(self.axes.left) < 0.0);
                sums[side] += ring.abs() * width;
                widths[side] += width;
            }
        }
        for side in 0..2 {
            if widths[side] > 0.0 {
                let (sum, count) = &mut self.halves[side][stroke];
                (*sum, *count) = (*sum + sums[side] / widths[side], *count + 1.0);
            }
        }
    }

    /// Mean over the last cycle of the force along `axis`.
    fn mean(&self, way: &str, axis: Vec3) -> Option<f64> {
        let columns = ["x", "y", "z"].map(|name| self.record.values(&format!("{way}_force_{name}")));
        let count = self.record.rows().checked_sub(self.first_of_last).filter(|count| *count > 0)?;
        let sum: f64 = (0..3)
            .map(|k| columns[k].map_or(0.0, |v| v[self.first_of_last..].iter().sum::<f64>()) * axis[k])
            .sum();
        Some(sum / count as f64)
    }

    pub fn summary(&self, case: &TetherCase, arguments: &Wake) -> Summary {
        let ratio = |side: usize| {
            let mean = |stroke: usize| {
                let (sum, count) = self.halves[side][stroke];
                (count > 0.0 && sum > 0.0).then(|| sum / count)
            };
            self.stroke.steps.and(mean(0).zip(mean(1))).map(|(down, up)| down / up)
        };
        let Axes { flight, up, .. } = self.axes;
        let symmetry_error = (self.symmetric && self.largest > 0.0).then(|| self.asymmetry / self.largest);
        let drifted = symmetry_error.filter(|error| *error > DRIFTED).map(|error| {
            format!(
                "left and right of a symmetric motion drifted apart by {:.1} % of the largest ring: the free wake is \
                 not resolved where it meets the wing or itself; try --prescribed, a larger --core or more --steps",
                100.0 * error
            )
        });
        let attached = "attached flow is assumed everywhere".to_owned();
        Summary {
            status: if self.failed.is_some() { "failed".into() } else { "ok".into() },
            name: case.spec.name.clone(),
            wake: if arguments.prescribed { "prescribed" } else { "free" },
            panels: [arguments.chordwise, arguments.spanwise],
            steps_per_cycle: self.steps,
            core_m: arguments.core * self.chord,
            mean_lift_n: self.mean("joukowski", up),
            mean_lift_bernoulli_n: self.mean("bernoulli", up),
            mean_drag_n: self.mean("joukowski", -flight),
            mean_drag_bernoulli_n: self.mean("bernoulli", -flight),
            circulation_error: self.circulation_error,
            symmetry_error,
            down_over_up: DownOverUp { left: ratio(0), right: ratio(1) },
            phases: self.shots.iter().map(|shot| (shot.name.clone(), shot.phase)).collect(),
            warnings: std::iter::once(attached).chain(drifted).collect(),
        }
    }
}
