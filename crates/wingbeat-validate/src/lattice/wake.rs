//! The wake as it is drawn: circulation through frontal planes, and the mirror image.

use super::flapping::{CHORD, CORE, STEPS, whole};
use super::wings::flapper;
use crate::{ComparisonRow, Error};
use wingbeat::math::Vec3;
use wingbeat_figures::{PlaneCut, half_circulations};
use wingbeat_lattice::{Lattice, VortexPicture, WakeMotion};

/// Distance of the plane behind the rearmost trailing edge, and radius of the spots drawn for vortices, chords: those of the figures.
const BEHIND: f64 = 0.5;
const SPREAD: f64 = 0.1;
/// Core of the wake held against the velocity around it, chords: thick ones take of vortices that pass near the way.
const THIN: f64 = 1e-3;
/// Points of each side of the way around a half of the plane.
const POINTS: usize = 2000;
/// The way around lies so far outside of the wing, half spans.
const OUTSIDE: f64 = 4.0;

/// Circulation of the velocity around the half y > 0 of the plane at `x`, about the direction of flight.
fn around(lattice: &Lattice, x: f64, half_span: f64) -> f64 {
    let far = OUTSIDE * half_span;
    let corners = [[0.0, -far], [far, -far], [far, far], [0.0, far], [0.0, -far]];
    let mut sum = 0.0;
    for pair in corners.windows(2) {
        let [from, to] = [pair[0], pair[1]].map(|[y, z]| Vec3::new(x, y, z));
        let step = (to - from) * (POINTS as f64).recip();
        let points: Vec<Vec3> = (0..POINTS).map(|k| from + step * (k as f64 + 0.5)).collect();
        sum += lattice.velocities(&points).iter().map(|v| v.dot(step)).sum::<f64>();
    }
    sum
}

/// Circulation through the left half of a frontal plane: drawn, around it, and of the vortices through it.
pub fn plane_circulation() -> Result<Vec<ComparisonRow>, Error> {
    let half_span = 0.2;
    let wing = flapper(half_span, 35.0, None)?;
    let lattice = whole(&wing, STEPS + STEPS / 2, WakeMotion::Prescribed, THIN, |_| ())?;
    let edges = lattice.meshes().iter().flat_map(|mesh| &mesh.edges);
    let rearmost = edges.map(|edge| edge.te[0]).fold(f64::INFINITY, f64::min);
    let x = rearmost - BEHIND * CHORD;
    let picture = VortexPicture::new(&lattice, 0.0);
    let crossings = picture.crossings(Vec3::new(x, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0));
    let vortices: Vec<_> = crossings.iter().map(|(place, g)| ([place[1], place[2]], *g)).collect();
    let through: f64 = vortices.iter().filter(|(place, _)| place[0] > 0.0).map(|(_, g)| g).sum();
    let cut = PlaneCut { vortices, ..PlaneCut::default() };
    let [drawn, _] = half_circulations(&cut, SPREAD * CHORD);
    let stokes = around(&lattice, x, half_span);
    let error = |value: f64| (value / through - 1.0).abs();
    let metric = "F2, prescribed wake, a cycle and a half: vorticity drawn in the left half of the plane, over the vortices through it";
    Ok(vec![
        ComparisonRow::judged("wake.plane_circulation.drawn", "Stokes", metric, error(drawn), 0.01, ""),
        ComparisonRow::judged(
            "wake.plane_circulation.velocity",
            "Stokes",
            "the same of the velocity around that half",
            error(stokes),
            0.01,
            "",
        ),
    ])
}

/// Largest difference between a ring and its mirror image over the largest ring, over all instants.
fn mirror_error(wake: WakeMotion, cycles: usize) -> Result<f64, Error> {
    let wing = flapper(0.2, 35.0, None)?;
    let (mut apart, mut largest): (f64, f64) = (0.0, 0.0);
    whole(&wing, cycles * STEPS, wake, CORE, |lattice| {
        let n = lattice.meshes()[0].strips;
        let rings = lattice.rings();
        for (at, ring) in rings.iter().enumerate() {
            largest = largest.max(ring.abs());
            apart = apart.max((ring - rings[at / n * n + n - 1 - at % n]).abs());
        }
    })?;
    Ok(apart / largest)
}

/// A wing that flaps alike on both sides, computed whole.
pub fn symmetry() -> Result<Vec<ComparisonRow>, Error> {
    let row =
        |id: &str, metric: &str, value| ComparisonRow::judged(id, "mirror image", metric, value, 1e-10, "");
    Ok(vec![
        row(
            "wake.symmetry.prescribed",
            "F2 whole, prescribed wake, 3 cycles: largest difference of a ring from its mirror image over the largest ring",
            mirror_error(WakeMotion::Prescribed, 3)?,
        ),
        ComparisonRow::shown(
            "wake.symmetry.free",
            "mirror image",
            "the same with a free wake, which is unstable and lets rounding grow",
            mirror_error(WakeMotion::Free, 3)?,
            "",
        ),
    ])
}
