//! Surfaces whose chords bend, in flight: what air, inertia and weight do along their bends.

use crate::layout::PanelLayout;
use crate::loads::PanelLoads;
use crate::mesh::Mesh;
use std::ops::Range;
use wingbeat::aero::{Aero, ChordBend, SkinSheet};
use wingbeat::math::{Dual, GRAVITY, Vec3, Wrench};

/// Points of Gauss's rule on a stretch from 0 to 1, each of which has half of it.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// How the chord lines at the arcs `arcs` (m) of a surface are bent whose bent states are `now`, with their `rates`.
pub(crate) fn moving_bends(
    aero: &Aero,
    [now, rates]: [&[f64]; 2],
    arcs: &[f64],
    out: &mut Vec<ChordBend<Dual<1>>>,
) {
    let [now, rates] = [now, rates].map(|of| aero.chord_bends(of, arcs));
    let dual = |re: f64, rate: f64| Dual { re, eps: [rate] };
    out.clear();
    out.extend(now.iter().zip(&rates).map(|(now, rate)| ChordBend {
        heights: [0, 1].map(|m| dual(now.heights[m], rate.heights[m])),
        angle: dual(now.angle, rate.angle),
        hinge: now.hinge,
    }));
}

/// A piece of a surface whose chords bend.
pub(crate) struct BentPiece {
    /// Where its surface stands among all that bends on the robot.
    pub bends: Range<usize>,
    /// Of each bent state of the surface which of both heights and the angle it is, and how much of each strip of panels lies on its strip.
    shares: Vec<(usize, Vec<f64>)>,
    /// What moves against the chord, by strip.
    sheets: Vec<Option<SkinSheet>>,
    /// Velocities of the points that carry its mass, as they are bent and on straight chords, m/s: now and at the instant before.
    now: Vec<[Vec3; 2]>,
    before: Option<Vec<[Vec3; 2]>>,
    /// Whether a step has ended: the rates of the start, which the air has not seen, are no velocities to differ from.
    begun: bool,
}

impl BentPiece {
    /// Of the panels `layout` of `aero`, whose bends stand at `first` and on; none of a surface that does not bend.
    pub fn new(aero: &Aero, layout: &PanelLayout, first: usize) -> Option<Self> {
        let model = aero.bent()?;
        let count = model.bent_states().len();
        let (strips, edges) = (model.strips(), model.arcs());
        let share = |k: usize| {
            let (of, strip) = if model.is_membrane() { (k / strips, k % strips) } else { (2, k) };
            let on = |arcs: &[f64]| {
                let common = arcs[0].min(edges[strip]) - arcs[1].max(edges[strip + 1]);
                if model.bends(k) { common.max(0.0) / (arcs[0] - arcs[1]) } else { 0.0 }
            };
            (of, layout.arcs.windows(2).map(on).collect())
        };
        let middle = |arcs: &[f64]| model.sheet_at(0.5 * (arcs[0] + arcs[1]));
        Some(Self {
            bends: first..first + count,
            shares: (0..count).map(share).collect(),
            sheets: layout.arcs.windows(2).map(middle).collect(),
            now: Vec::new(),
            before: None,
            begun: false,
        })
    }

    /// Adds what the panels `air` bear and the inertia and weight of what moves to `bends`, and to `strips` (N and N m in W) what the wing feels
    /// of that, whose links weigh as if chords were straight. `step` s are since the instant before.
    ///
    /// Equation: lattice.skin
    /// `Q_k += sum dm (g - a) . dp/db_k; on the wing dm (g - a) at p less dm (g - a_0) at p_0 on the straight chord; a = (v - v_before)/step`
    /// Source: d'Alembert, virtual work; accelerations from step to step, as the circulations' rates.
    /// Test: `a_skin_bears_its_inertia_and_weight`.
    pub fn bear(
        &mut self,
        mesh: &Mesh,
        air: &PanelLoads,
        step: f64,
        bends: &mut [f64],
        strips: &mut [Wrench<f64>],
    ) {
        let gravity = Vec3::new(0.0, 0.0, -GRAVITY);
        let m = mesh.chordwise as f64;
        let mut work = air.bends.clone();
        work.resize(mesh.strips, [0.0; 3]);
        self.now.clear();
        for (j, sheet) in self.sheets.iter().enumerate() {
            let Some(sheet) = sheet else { continue };
            for i in 0..mesh.chordwise {
                let from = sheet.from.max(i as f64 / m);
                let width = (i as f64 + 1.0) / m - from;
                if width <= 0.0 {
                    continue;
                }
                let mass = 0.5 * sheet.areal_density * mesh.controls[i * mesh.strips + j].area * width * m;
                for x in GAUSS.map(|share| from + width * share) {
                    let points = mesh.moved(j, x);
                    let velocities = points.map(|[_, velocity]| velocity);
                    let before = self.before.as_ref().map_or(velocities, |before| before[self.now.len()]);
                    let [bent, straight] =
                        [0, 1].map(|k| (gravity - (velocities[k] - before[k]) * step.recip()) * mass);
                    strips[j] += Wrench::at(points[0][0], bent) + -Wrench::at(points[1][0], straight);
                    for side in [j, j + 1] {
                        let raised = mesh.raised(j, side, x);
                        (0..3).for_each(|k| work[j][k] += 0.5 * bent.dot(raised[k]));
                    }
                    self.now.push(velocities);
                }
            }
        }
        for (bend, (of, shares)) in bends[self.bends.clone()].iter_mut().zip(&self.shares) {
            *bend += shares.iter().zip(&work).map(|(share, work)| share * work[*of]).sum::<f64>();
        }
    }

    /// Goes on to the next instant.
    pub fn keep(&mut self) {
        let now = std::mem::take(&mut self.now);
        self.before = std::mem::replace(&mut self.begun, true).then_some(now);
    }
}
