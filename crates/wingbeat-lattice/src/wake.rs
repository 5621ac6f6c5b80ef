//! The wake of a surface: rows of vertices from the oldest to the trailing edge.

use crate::kernel::VortexGrid;
use crate::mesh::Rear;
use crate::settings::{CLOSE, Core};
use wingbeat::math::Vec3;

/// A sheet of vortex rings. Ring row r lies between the rows r and r + 1 of vertices; the last row of vertices is the ends of the
/// bound rings.
#[derive(Clone, Debug, Default)]
pub struct Wake {
    /// Vertices and segments. The last row carries what the wake puts there; the bound rings' share is the mesh's.
    pub grid: VortexGrid,
    /// Circulations of the rings, by row, m2/s.
    pub rings: Vec<f64>,
    /// Velocities of the vertices one step ago, of those that were there, m/s.
    before: Vec<Vec3>,
}

impl Wake {
    /// Number of rows of rings.
    pub fn rows(&self) -> usize {
        self.grid.rows().saturating_sub(1)
    }

    /// The row of vertices that joined last, m in W.
    pub fn last_row(&self) -> Option<&[Vec3]> {
        self.grid.points.len().checked_sub(self.grid.columns.max(1)).map(|first| &self.grid.points[first..])
    }

    /// Joins the wake to the ends `trailing` (m) of the bound rings; `shed` are the circulations (m2/s) that the last rings had
    /// a step ago.
    pub fn join(&mut self, trailing: &[Vec3], shed: Option<&[f64]>) {
        self.grid.columns = trailing.len();
        self.rings.extend(shed.unwrap_or_default());
        self.grid.points.extend(trailing);
    }

    /// Lets the oldest rows go that are more than `rows`, or that all lie further than `distance` m from the trailing edge.
    pub fn truncate(&mut self, rows: usize, distance: f64) {
        let n = self.grid.columns;
        let total = self.rows();
        let Some(last) = self.grid.points.len().checked_sub(n) else { return };
        let (old, trailing) = self.grid.points.split_at(last);
        let far = |row: &[Vec3]| row.iter().zip(trailing).all(|(a, b)| (*a - *b).norm() > distance);
        let gone = old.chunks_exact(n).take_while(|row| far(row)).count().max(total.saturating_sub(rows));
        self.grid.points.drain(..gone * n);
        self.rings.drain(..gone * (n - 1));
        self.before.drain(..(gone * n).min(self.before.len()));
    }

    /// Puts the rings on the segments.
    ///
    /// Equation: lattice.wake_rings
    /// `the ring shed at t_n carries the last ring's circulation of t_n; segments the difference of their rings`
    /// Source: Kutta; Katz & Plotkin 2001, section 13.12.
    /// Test: `rings_close_and_leave_by_age_and_distance`.
    pub fn set_segments(&mut self) {
        let (n, rows) = (self.grid.columns - 1, self.rows());
        let rings = &self.rings;
        let ring = |r: usize, j: usize| rings[r * n + j];
        let grid = &mut self.grid;
        grid.across.clear();
        grid.along.clear();
        for r in 0..=rows {
            let (newer, older) = ((r < rows).then_some(r), r.checked_sub(1));
            let part = |r: Option<usize>, j: usize| r.map_or(0.0, |r| ring(r, j));
            grid.across.extend((0..n).map(|j| part(older, j) - part(newer, j)));
            if r < rows {
                let beside = |j: usize| if j < n { ring(r, j) } else { 0.0 };
                grid.along.extend((0..=n).map(|j| beside(j) - if j > 0 { beside(j - 1) } else { 0.0 }));
            }
        }
    }

    /// Gives the segments the cores that they have after steps of `step` s each; as the wing with the trailing edge `rear` feels them
    /// they have at most a share of their way along the sheet from there, and more as they lie over the wing.
    ///
    /// Equation: lattice.close_core
    /// `rc = min(core, s/10 + 8 d), s along the sheet from the trailing edge, d how far over the wing`
    /// Source: own: a vortex at s acts on control points as 1/(1 + rc^2/d^2) of a bare one, d > s.
    /// Test: `lift_in_plunge_is_that_of_theodorsen_with_the_default_core`.
    pub fn soften(&mut self, core: &Core, step: f64, rear: &[Rear]) {
        let (n, rows) = (self.grid.columns - 1, self.rows());
        let rings = &self.rings;
        let ring = |r: usize, j: usize| rings[r * n + j];
        let grid = &mut self.grid;
        // Squares of the longest cores, by vertex.
        let mut most = vec![f64::INFINITY; grid.points.len()];
        for (j, rear) in rear.iter().enumerate() {
            let mut way = 0.0;
            for at in (0..=rows).rev().map(|r| r * (n + 1) + j) {
                let here = grid.points[at];
                way += grid.points.get(at + n + 1).map_or(0.0, |newer| (*newer - here).norm());
                most[at] = (CLOSE * way + rear.over(here)).powi(2);
            }
        }
        let least = |r: usize, j: usize, next: usize| most[r * (n + 1) + j].min(most[r * (n + 1) + j + next]);
        let mean = |values: [Option<f64>; 2]| {
            let known = values.into_iter().flatten();
            known.clone().map(f64::abs).sum::<f64>() / (known.count().max(1)) as f64
        };
        let across = |r: usize, j: usize| {
            let strength = mean([r.checked_sub(1).map(|r| ring(r, j)), (r < rows).then(|| ring(r, j))]);
            core.square((rows - r) as f64 * step, strength).min(least(r, j, 1))
        };
        let along = |r: usize, j: usize| {
            let strength = mean([j.checked_sub(1).map(|j| ring(r, j)), (j < n).then(|| ring(r, j))]);
            core.square(((rows - r) as f64 - 0.5) * step, strength).min(least(r, j, n + 1))
        };
        grid.soften(across, along);
    }

    /// Carries every vertex on for `step` s by the velocities `now`: at second order (Adams & Bashforth) those whose velocity a step
    /// ago is known, or all at first order where `first_order` says so.
    ///
    /// Equation: lattice.wake_convection
    /// `x += h (3/2 v_n - 1/2 v_n-1)`
    /// Source: Adams & Bashforth 1883.
    /// Test: `vertices_are_carried_at_their_order`.
    pub fn carry(&mut self, now: Vec<Vec3>, step: f64, first_order: bool) {
        let known = if first_order { 0 } else { self.before.len() };
        for (k, (point, v)) in self.grid.points.iter_mut().zip(&now).enumerate() {
            let mean = if k < known { *v * 1.5 - self.before[k] * 0.5 } else { *v };
            *point += mean * step;
        }
        self.before = now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance of a vertex from where it should be after one turn in a whirl of the rate 1 rad/s.
    fn missed(steps: usize, first_order: bool) -> f64 {
        let step = std::f64::consts::TAU / steps as f64;
        let mut wake = Wake::default();
        wake.join(&[Vec3::new(1.0, 0.0, 0.0), Vec3::new(2.0, 0.0, 0.0)], None);
        for _ in 0..steps {
            let whirl = wake.grid.points.iter().map(|p| Vec3::new(-p[1], p[0], 0.0)).collect();
            wake.carry(whirl, step, first_order);
        }
        (wake.grid.points[0] - Vec3::new(1.0, 0.0, 0.0)).norm()
    }

    #[test]
    fn vertices_are_carried_at_their_order() {
        for (first_order, order) in [(true, 1.0), (false, 2.0)] {
            let found = (missed(400, first_order) / missed(800, first_order)).log2();
            assert!((found - order).abs() < 0.1, "{found} {order}");
        }
    }

    #[test]
    fn rings_close_and_leave_by_age_and_distance() {
        let mut wake = Wake::default();
        let core = Core { radius_m: 0.1, viscosity_m2_s: 0.0, squire: 0.0 };
        for k in 0..6 {
            let row: Vec<Vec3> = (0..3).map(|j| Vec3::new(f64::from(k), f64::from(j), 0.0)).collect();
            wake.join(&row, (k > 0).then_some(&[1.0, f64::from(k)]));
        }
        wake.set_segments();
        wake.soften(&core, 1.0, &[]);
        assert!(
            wake.grid.core_across.iter().chain(&wake.grid.core_along).all(|core| (core - 0.01).abs() < 1e-15)
        );
        // Rows are 1 m apart.
        // Two columns lie behind an edge, the third over it.
        let rear =
            |outward: f64| Rear { at: Vec3::new(5.0, 0.0, 0.0), outward: Vec3::new(outward, 0.0, 0.0) };
        let core = Core { radius_m: 0.25, ..core };
        wake.soften(&core, 1.0, &[rear(-1.0), rear(-1.0), rear(1.0)]);
        let of_rows: Vec<f64> = wake.grid.core_across.chunks(2).rev().map(|row| row[0].sqrt()).collect();
        let right = [0.0, 0.1, 0.2, 0.25, 0.25, 0.25];
        let over: Vec<f64> = wake.grid.core_along.chunks(3).rev().map(|row| row[2].sqrt()).collect();
        assert!(over[0] == 0.0 && over[1..].iter().all(|own| *own == 0.25), "{over:?}");
        assert!(of_rows.iter().zip(right).all(|(own, right)| (own - right).abs() < 1e-12), "{of_rows:?}");
        for j in 0..2 {
            let sum: f64 = wake.grid.across.iter().skip(j).step_by(2).sum();
            assert!(sum.abs() < 1e-15);
        }
        assert!(wake.grid.along.chunks(3).all(|row| row.iter().sum::<f64>().abs() < 1e-15));
        wake.truncate(4, f64::INFINITY);
        assert_eq!((wake.rows(), wake.rings.len(), wake.grid.points.len()), (4, 8, 15));
        wake.truncate(4, 2.5);
        assert_eq!(wake.rows(), 2);
    }
}
