//! Surfaces whose chords bend, in flight: what air, inertia and weight do along their bends.

use crate::layout::PanelLayout;
use crate::loads::PanelLoads;
use crate::mesh::Mesh;
use std::ops::Range;
use wingbeat::aero::{Aero, ChordBend, SectionMotion, SkinSheet};
use wingbeat::math::{Dual, GRAVITY, Vec3, Wrench};
use wingbeat::robot::{Robot, Stance};

/// Points of Gauss's rule on a stretch from 0 to 1, each of which has half of it.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// How the edges of panels are bent by what bends on the strips of their surface.
#[derive(Clone, Debug)]
pub struct EdgeBends {
    /// Shares of the strips in what each edge has.
    shares: Vec<Vec<f64>>,
    /// Which of both heights and the angle the states are.
    kinds: Range<usize>,
    hinge: f64,
}

impl EdgeBends {
    /// Of the edges at the arcs `arcs` (m) of a piece of `aero`; none of a surface that does not bend. States hold on their strips and go
    /// linearly across the edges between two, over the width of the narrower; an edge of panels has the mean of them that
    /// the panels beside it weigh. So alike states make an alike bend, and by virtual work an even load comes to each strip by its width.
    ///
    /// Equation: lattice.bent_edges
    /// `b = W s, Q = W' q; W_jk = int f_j N_k dy/int f_j dy, f_j falling linearly from edge j to the next ones, N_k from strip k`
    /// Source: virtual work; Farhat, Lesoinne & Le Tallec 1998, Comput. Methods Appl. Mech. Eng. 157; means in place of values a choice.
    /// Test: `edges_bend_alike_and_do_the_work_of_their_loads`.
    pub fn new(aero: &Aero, arcs: &[f64]) -> Option<Self> {
        let model = aero.bent()?;
        let (strips, ends) = (model.strips(), model.arcs());
        // Rounding must not put an end of strips beside that of the piece.
        let same = 1e-9 * (arcs[0] - arcs[arcs.len() - 1]);
        let [first, last] = [arcs[0] - same, arcs[arcs.len() - 1] + same];
        let half = |k: usize| 0.5 * (ends[k - 1] - ends[k]).min(ends[k] - ends[k + 1]);
        // Share of the strips from `k` on at an arc.
        let from = |k: usize, arc: f64| match k {
            _ if k == 0 || ends[k] >= first => 1.0,
            _ if k == strips || ends[k] <= last => 0.0,
            k => (0.5 + 0.5 * (ends[k] - arc) / half(k)).clamp(0.0, 1.0),
        };
        let mut shares = vec![vec![0.0; strips]; arcs.len()];
        for (j, pair) in arcs.windows(2).enumerate() {
            let bounds = (1..strips).flat_map(|k| [ends[k] + half(k), ends[k] - half(k)]);
            let mut cuts: Vec<f64> =
                bounds.filter(|cut| *cut < pair[0] && *cut > pair[1]).chain([pair[0], pair[1]]).collect();
            wingbeat::math::order::descend_by(&mut cuts, |cut| *cut);
            for cut in cuts.windows(2) {
                for arc in GAUSS.map(|share| cut[0] + (cut[1] - cut[0]) * share) {
                    let behind = (pair[0] - arc) / (pair[0] - pair[1]);
                    for k in 0..strips {
                        let weight = (cut[0] - cut[1]) * (from(k, arc) - from(k + 1, arc));
                        shares[j][k] += (1.0 - behind) * weight;
                        shares[j + 1][k] += behind * weight;
                    }
                }
            }
        }
        for row in &mut shares {
            let all: f64 = row.iter().sum();
            row.iter_mut()
                .enumerate()
                .for_each(|(k, share)| *share = if model.bends(k) { *share / all } else { 0.0 });
        }
        let flap = model.settings().flap;
        let kinds = if flap.is_some() { 2..3 } else { 0..2 };
        Some(Self { shares, kinds, hinge: flap.map_or(1.0, |flap| 1.0 - flap.chord_fraction) })
    }

    /// How the edges are bent in the states `states` of the surface, each with its rate: dimensionless and rad, 1/s and rad/s.
    pub fn bends(&self, states: &[[f64; 2]], out: &mut Vec<ChordBend<Dual<1>>>) {
        out.clear();
        for row in &self.shares {
            let mut of = [Dual::constant(0.0); 3];
            for (kind, states) in self.kinds.clone().zip(states.chunks_exact(row.len())) {
                for (share, [now, rate]) in row.iter().zip(states) {
                    of[kind] += Dual { re: share * now, eps: [share * rate] };
                }
            }
            out.push(ChordBend { heights: [of[0], of[1]], angle: of[2], hinge: self.hinge });
        }
    }

    /// Adds to the `loads` of the states, N m, those of the edges, per unit of both heights and of the angle, N m.
    pub fn share(&self, edges: &[[f64; 3]], loads: &mut [f64]) {
        for (row, of) in self.shares.iter().zip(edges) {
            for (kind, loads) in self.kinds.clone().zip(loads.chunks_exact_mut(row.len())) {
                loads.iter_mut().zip(row).for_each(|(load, share)| *load += share * of[kind]);
            }
        }
    }
}

/// The edges of the panels on a piece of a surface of a robot.
pub(crate) struct SurfaceEdges {
    /// Number of the surface.
    pub surface: usize,
    /// How they bend, if they do.
    pub bends: Option<EdgeBends>,
}

impl SurfaceEdges {
    /// Those of the panels `layout` on the surface number `surface` of `robot`.
    pub fn new(robot: &Robot, (surface, layout): &(usize, PanelLayout)) -> Self {
        let aero = robot.surfaces().nth(*surface).map(|(_, aero)| aero);
        Self { surface: *surface, bends: aero.and_then(|aero| EdgeBends::new(aero, &layout.arcs)) }
    }

    /// The sections at the arcs `arcs` (m) of `robot` as it is `at`; where it cannot be they are not finite, which the lattice finds as a
    /// panel that is not. An edge that bends between two planes, as of a dihedral, bends along their mean: those of the panels beside
    /// it, as the section at an edge is of one of them.
    pub fn sections(&self, robot: &Robot, at: &Stance, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        if robot.chord_lines(at, self.surface, arcs, out).is_err() {
            let nowhere = Vec3::new(f64::NAN, f64::NAN, f64::NAN);
            out.clear();
            out.resize(arcs.len(), SectionMotion { le: nowhere, te: nowhere, ..SectionMotion::default() });
        } else if self.bends.is_some() {
            let middles: Vec<f64> = arcs.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
            let mut sides = Vec::with_capacity(middles.len());
            if robot.chord_lines(at, self.surface, &middles, &mut sides).is_ok() {
                for (section, beside) in out.iter_mut().skip(1).zip(sides.windows(2)) {
                    section.span = (beside[0].span + beside[1].span).unit();
                    section.w = (beside[0].w + beside[1].w) * 0.5;
                }
            }
        }
    }
}

/// A piece of a surface whose chords bend.
pub(crate) struct BentPiece {
    /// Where its surface stands among all that bends on the robot.
    pub bends: Range<usize>,
    edges: EdgeBends,
    sheet: SkinSheet,
    /// Velocities of the points that carry its mass, as they are bent and on straight chords, m/s: now and at the instant before.
    now: Vec<[Vec3; 2]>,
    before: Option<Vec<[Vec3; 2]>>,
    /// Whether a step has ended, or rates are those of a momentum: the rates of a membrane at the start, which the air has not seen, are no
    /// velocities to differ from.
    begun: bool,
}

impl BentPiece {
    /// Of the panels `layout` of `aero`, whose bends stand at `first` and on; none of a surface that does not bend.
    pub fn new(aero: &Aero, layout: &PanelLayout, first: usize) -> Option<Self> {
        let model = aero.bent()?;
        Some(Self {
            bends: first..first + model.bent_states().len(),
            edges: EdgeBends::new(aero, &layout.arcs)?,
            sheet: model.sheet()?,
            now: Vec::new(),
            before: None,
            begun: !model.is_membrane(),
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
        work.resize(mesh.strips + 1, [0.0; 3]);
        self.now.clear();
        let sheet = self.sheet;
        for j in 0..mesh.strips {
            let still = |edge: usize| self.edges.shares[edge].iter().all(|share| *share == 0.0);
            if still(j) && still(j + 1) {
                continue;
            }
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
                        (0..3).for_each(|k| work[side][k] += 0.5 * bent.dot(raised[k]));
                    }
                    self.now.push(velocities);
                }
            }
        }
        self.edges.share(&work, &mut bends[self.bends.clone()]);
    }

    /// Goes on to the next instant.
    pub fn keep(&mut self) {
        let now = std::mem::take(&mut self.now);
        self.before = std::mem::replace(&mut self.begun, true).then_some(now);
    }
}
