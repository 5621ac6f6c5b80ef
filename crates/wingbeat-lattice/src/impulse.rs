//! The impulse of all vortices, an independent way to the force.

use crate::influence::mirrored;
use crate::kernel::VortexGrid;
use crate::lattice::Lattice;
use wingbeat::math::Vec3;

impl Lattice {
    /// Impulse of the bound rings and of all that was shed, N s in W, the mirror image of a half included. Its rate, turned, is the
    /// force on the surfaces where the wake is free and nothing of it is left out.
    ///
    /// Equation: lattice.impulse
    /// `I = rho/2 sum G r x l, F = -dI/dt`
    /// Source: Saffman 1992, section 3.2.
    /// Test: `forces_are_the_rate_of_the_impulse`.
    pub fn impulse(&self) -> Vec3 {
        let bound = self.meshes().iter().flat_map(|m| [&m.bound, &m.trailing, &m.nose, &m.heads]);
        let shed = self.wakes().iter().chain(self.sheets()).map(|wake| &wake.grid);
        let sum = bound.chain(shed).map(impulse).fold(Vec3::ZERO, |sum, own| sum + own);
        let scene = self.scene();
        let image = if scene.symmetric { mirrored(sum) } else { Vec3::ZERO };
        (sum + image) * scene.density_kg_m3
    }
}

/// Half the sum of circulation times place times length over the segments of a grid, m4/s.
fn impulse(grid: &VortexGrid) -> Vec3 {
    let n = grid.columns;
    let of = |(pair, circulation): ([usize; 2], f64)| {
        let [a, b] = pair.map(|at| grid.points[at]);
        a.cross(b) * (0.5 * circulation)
    };
    // The segments of a row join it, those between rows come after each other: r x l of the line from a to b is a x b.
    let across = grid.across.iter().enumerate().map(|(k, circulation)| {
        let at = k / (n - 1) * n + k % (n - 1);
        ([at, at + 1], *circulation)
    });
    let along = grid.along.iter().enumerate().map(|(k, circulation)| ([k, k + n], *circulation));
    across.chain(along).map(of).fold(Vec3::ZERO, |sum, own| sum + own)
}
