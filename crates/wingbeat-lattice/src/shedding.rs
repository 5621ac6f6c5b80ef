//! Vortex sheets that leave the leading edges.
//!
//! Where the suction parameter of a strip's leading edge passes its critical value, vorticity is shed there until it is back at it: the
//! criterion of Ramesh et al. (J. Fluid Mech. 751, 2014) for aerofoils, by strips as Hirato et al. (J. Aircraft 56, 2019) use it on
//! wings. Here the sheet is of rings, as the wake is: the jump of the potential across it at the edge, which is all the circulation that
//! has left the strip, is that before the first bound vortex. So every vortex is closed, and the first bound vortex, which measures the
//! suction, has what the first ring has less that jump.

use crate::influence::Influence;
use crate::mesh::Mesh;
use crate::wake::Wake;
use wingbeat::math::Vec3;
use wingbeat::math::linear::{lu_factor, lu_solve};

/// The sheets of all leading edges.
pub struct Shedding {
    /// Largest suction parameter.
    critical: f64,
    /// By surface.
    pub sheets: Vec<Wake>,
    /// Jumps at the edges now and at the two instants before, by surface and strip, m2/s.
    pub jumps: [Vec<f64>; 3],
    /// Suction parameters, by surface and strip, dimensionless.
    pub suction: Vec<f64>,
    /// Largest way of a vortex of the sheets in a step beyond the wind's, m.
    pub farthest: f64,
}

/// A factorised matrix of the rings.
pub struct RingFactors<'a> {
    /// From [`lu_factor`]: wash over circulation, 1/m.
    pub matrix: &'a [f64],
    /// Beside it.
    pub pivots: &'a [usize],
}

/// The first and the last panel of a strip, and the shares of their rings in its suction parameter.
type EdgePanels = [(usize, f64); 2];

/// Those of all strips, by surface.
fn edges(meshes: &[Mesh], wind: Vec3) -> Vec<EdgePanels> {
    let mut first = 0;
    let of = |mesh: &Mesh| {
        let last = first + mesh.panels() - mesh.strips;
        let edge = |j: usize| {
            let [of_first, of_all] = mesh.suction_per_circulation(j, wind);
            [(first + j, of_first), (last + j, of_all)]
        };
        let own: Vec<EdgePanels> = (0..mesh.strips).map(edge).collect();
        first += mesh.panels();
        own
    };
    meshes.iter().flat_map(of).collect()
}

impl Shedding {
    /// Sheets of the surfaces `meshes`, whose edges bear suction up to the dimensionless parameter `critical`.
    pub fn new(critical: f64, meshes: &[Mesh]) -> Self {
        let strips = meshes.iter().map(|mesh| mesh.strips).sum();
        Self {
            critical,
            sheets: meshes.iter().map(|_| Wake::default()).collect(),
            jumps: std::array::from_fn(|_| vec![0.0; strips]),
            suction: vec![0.0; strips],
            farthest: 0.0,
        }
    }

    /// Joins `sheet` to the nose of `mesh`, whose jumps a step ago are `shed` (m2/s); before anything was shed it has no more
    /// than its last rows.
    pub fn join(sheet: &mut Wake, mesh: &Mesh, shed: Option<&[f64]>) {
        if sheet.rows() > 0 && sheet.rings.iter().all(|ring| *ring == 0.0) {
            sheet.truncate(0, f64::INFINITY);
        }
        // Rings of the sheet have their newer side on the wing's side of them, those of the nose theirs.
        let rings: Option<Vec<f64>> = shed.map(|shed| shed.iter().map(|jump| -jump).collect());
        sheet.join(&mesh.heads.points, rings.as_deref());
    }

    /// The tangency that the jumps of a step ago ask of the rings beyond `right` (m/s), and the columns of the noses (1/m).
    pub fn held(&self, influence: &Influence, meshes: &[Mesh], right: &mut [f64]) -> Vec<f64> {
        let columns = influence.noses(meshes);
        let held = &self.jumps[1];
        for (row, right) in columns.chunks_exact(held.len()).zip(right) {
            *right += row.iter().zip(held).map(|(column, jump)| column * jump).sum::<f64>();
        }
        columns
    }

    /// The circulations of the rings (m2/s), `rings` with the jumps of a step ago, so that no edge has more than the critical
    /// suction: of the strips that shed, linear conditions, to which those are added that pass the critical value by it.
    ///
    /// Equation: lattice.shedding
    /// `jumps at the leading edges so that abs(A0) is at most the critical suction`
    /// Source: Ramesh et al. 2014, J. Fluid Mech. 751; by strips: Hirato et al. 2019, J. Aircraft 56; rings and their linear conditions: own.
    /// Test: `leading_edges_keep_the_critical_suction`.
    pub fn shed(
        &mut self,
        meshes: &[Mesh],
        wind: Vec3,
        factors: &RingFactors<'_>,
        mut columns: Vec<f64>,
        rings: &mut [f64],
    ) {
        let edges = edges(meshes, wind);
        let strips = edges.len();
        let held = self.jumps[1].clone();
        // The first bound vortex, and all of them, have a ring's circulation less the jump.
        let suction = |edge: &EdgePanels, jump: f64| {
            edge.iter().map(|(at, share)| (rings[*at] - jump) * share).sum::<f64>()
        };
        let before: Vec<f64> = edges.iter().zip(&held).map(|(edge, jump)| suction(edge, *jump)).collect();
        let beyond = |suction: f64| (suction.abs() > self.critical).then(|| suction.signum() * self.critical);
        let mut wanted: Vec<Option<f64>> = before.iter().map(|suction| beyond(*suction)).collect();
        self.suction.clone_from(&before);
        self.jumps[0].clone_from(&held);
        if wanted.iter().all(Option::is_none) {
            return;
        }
        lu_solve(factors.matrix, rings.len(), factors.pivots, &mut columns, strips);
        // Of the suction of one strip by the jump of another.
        let slope = |j: usize, k: usize| {
            let own = if j == k { 1.0 } else { 0.0 };
            edges[j].iter().map(|(at, share)| (columns[at * strips + k] - own) * share).sum::<f64>()
        };
        for _ in 0..strips {
            let own: Vec<usize> = (0..strips).filter(|j| wanted[*j].is_some()).collect();
            let n = own.len();
            let mut matrix: Vec<f64> = own.iter().flat_map(|j| own.iter().map(|k| slope(*j, *k))).collect();
            let mut change: Vec<f64> =
                own.iter().map(|j| wanted[*j].unwrap_or_default() - before[*j]).collect();
            let mut pivots = vec![0; n];
            if !lu_factor(&mut matrix, n, &mut pivots) {
                return;
            }
            lu_solve(&matrix, n, &pivots, &mut change, 1);
            self.jumps[0].clone_from(&held);
            own.iter().zip(&change).for_each(|(j, change)| self.jumps[0][*j] += change);
            let after = |j: usize| {
                let changes = own.iter().zip(&change).map(|(k, change)| slope(j, *k) * change);
                before[j] + changes.sum::<f64>()
            };
            self.suction = (0..strips).map(after).collect();
            let mut more = false;
            for (wanted, suction) in wanted.iter_mut().zip(&self.suction) {
                if let (None, Some(to)) = (*wanted, beyond(*suction)) {
                    (*wanted, more) = (Some(to), true);
                }
            }
            if !more {
                break;
            }
        }
        let changes: Vec<f64> = self.jumps[0].iter().zip(&held).map(|(now, held)| now - held).collect();
        for (row, ring) in columns.chunks_exact(strips).zip(rings) {
            *ring += row.iter().zip(&changes).map(|(column, change)| column * change).sum::<f64>();
        }
    }

    /// Puts the jumps on `meshes`.
    pub fn put(&self, meshes: &mut [Mesh]) {
        let mut rest = &self.jumps[0][..];
        for mesh in meshes {
            let (own, others) = rest.split_at(mesh.strips);
            mesh.jumps.copy_from_slice(own);
            rest = others;
        }
    }

    /// Share of the strips that shed at the last instant.
    pub fn share(&self) -> f64 {
        let shed = self.jumps[0].iter().zip(&self.jumps[1]).filter(|(now, before)| now != before);
        shed.count() as f64 / self.suction.len().max(1) as f64
    }
}
