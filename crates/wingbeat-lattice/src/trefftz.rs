//! The drag of a steady wing by the wake far behind it.

use crate::influence::Mirrors;
use crate::lattice::Lattice;
use wingbeat::math::Vec3;

impl Lattice {
    /// Width of the wings across the wind and square to the lift of level wings, m: from the outermost trailing edge to the other.
    /// None without a wind.
    pub fn span(&self) -> Option<f64> {
        let scene = self.scene();
        let wind = Some(scene.wind).filter(|wind| wind.norm() > 0.0)?;
        let aside = wind.cross(Vec3::new(0.0, 0.0, 1.0));
        let aside = if aside.norm() > 0.0 { aside.unit() } else { Vec3::new(0.0, 1.0, 0.0) };
        let edges = self.meshes().iter().flat_map(|mesh| mesh.edges.iter().map(|edge| edge.te.dot(aside)));
        let most = edges.clone().fold(f64::NEG_INFINITY, f64::max);
        let least = edges.fold(f64::INFINITY, f64::min);
        Some(if scene.symmetric { 2.0 * most.abs().max(least.abs()) } else { most - least })
    }

    /// Drag of the wake that the present circulations would leave if the wings stayed as they are, N: in the plane square to the wind
    /// far behind, where the wake is as wide as the trailing edges, D = -(rho/2) sum G_j w_j dy_j, with the downwash of the trailing
    /// vortices at the points where Lan's sums over strips are exact. None without a wind.
    ///
    /// Munk 1921: however the wings are swept, this is the drag of a steady wing, and the least that its loading can have.
    ///
    /// Equation: lattice.trefftz
    /// `D = -(rho/2) sum G_j w_j dy_j in the plane behind the wake`
    /// Source: Munk 1921, NACA Rep. 121.
    /// Test: `steady_wings_have_the_drag_of_their_wake`.
    pub fn wake_drag(&self) -> Option<f64> {
        let scene = self.scene();
        let speed = Some(scene.wind.norm()).filter(|speed| *speed > 0.0)?;
        let along = scene.wind * speed.recip();
        let across = |v: Vec3| v - along * v.dot(along);
        let mut strips = Vec::new();
        let mut rings = self.rings();
        for mesh in self.meshes() {
            let (own, rest) = rings.split_at(mesh.panels());
            rings = rest;
            let last = &own[mesh.panels() - mesh.strips..];
            for (j, ring) in last.iter().enumerate() {
                let [left, right] = [j, j + 1].map(|j| across(mesh.edges[j].te));
                strips.push((left, right, mesh.fractions[j], *ring));
            }
        }
        let own = strips.len();
        for image in Mirrors::of(scene).images() {
            for k in 0..own {
                let (left, right, f, ring) = strips[k];
                let [left, right] = [image.point(left), image.point(right)];
                // Mirrored once, a strip runs the other way.
                let turned = image.turns();
                strips.push(if turned { (right, left, 1.0 - f, ring) } else { (left, right, f, ring) });
            }
        }
        // A line along the wind of the circulation G: G (along x r)/(2 pi r^2).
        let line = |p: Vec3, from: Vec3| {
            let r = p - from;
            let square = r.norm_squared();
            if square > 0.0 { along.cross(r) * (0.5 / (std::f64::consts::PI * square)) } else { Vec3::ZERO }
        };
        let drag = strips.iter().map(|(left, right, f, ring)| {
            let at = *left + (*right - *left) * *f;
            let wash = strips.iter().fold(Vec3::ZERO, |sum, (left, right, _, ring)| {
                sum + (line(at, *right) - line(at, *left)) * *ring
            });
            ring * wash.cross(*right - *left).dot(along)
        });
        // Half of what the wings and their images at a ground have together.
        let share = if scene.ground.is_some() { 0.25 } else { 0.5 };
        Some(share * scene.density_kg_m3 * drag.sum::<f64>())
    }
}
