//! The shape of a beam that does not move, or turns steadily.

use crate::beam::Beam;
use crate::motion::Setting;
use nalgebra::DVector;

/// Most Newton steps per step of the load.
const MOST: usize = 40;
/// Residual over the largest load, or a strain energy's gradient, at which a shape is found.
const TOLERANCE: f64 = 1e-11;

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StaticsStatus {
    /// The residual is as small as rounding lets it be.
    Converged,
    /// It is not, after all steps.
    NotConverged,
    /// The tangent stiffness is singular, or numbers are not finite.
    Singular,
}

/// A shape at rest.
#[derive(Clone, Debug)]
pub struct HeldShape {
    /// Coordinates: strains of twist and bending in rad/m, of extension and shear dimensionless; of a free root m and rad
    /// before them.
    pub q: Vec<f64>,
    /// How the search ended.
    pub status: StaticsStatus,
    /// Newton steps taken.
    pub iterations: usize,
    /// Largest residual over the largest generalised stiffness force.
    pub residual: f64,
}

/// The shape under the loads, weight and rotation of `setting`, by Newton's method with exact tangents; loads grow in `steps`
/// equal steps from none. A root that is free is held at its coordinates' zero by nothing: it needs loads that do so.
pub fn hold(beam: &Beam, setting: &Setting, steps: usize) -> HeldShape {
    let n = beam.unknowns(setting.free);
    let mut held =
        HeldShape { q: vec![0.0; n], status: StaticsStatus::Converged, iterations: 0, residual: 0.0 };
    for step in 1..=steps.max(1) {
        let share = step as f64 / steps.max(1) as f64;
        let mut now = setting.clone();
        now.gravity = setting.gravity * share;
        for load in &mut now.loads {
            (load.force, load.moment) = (load.force * share, load.moment * share);
        }
        relax(beam, &now, &mut held);
        if held.status != StaticsStatus::Converged {
            break;
        }
    }
    held
}

fn relax(beam: &Beam, setting: &Setting, held: &mut HeldShape) {
    let n = held.q.len();
    let zero = vec![0.0; n];
    let mut out = vec![0.0; n];
    let (mut least, mut stalled) = (f64::INFINITY, 0);
    for _ in 0..MOST {
        beam.residual(setting, [&held.q, &zero, &zero], &[], &mut out);
        let stiffness = beam.tangent_stiffness(setting, &held.q);
        let scale = (0..n).map(|i| (stiffness[(i, i)] * held.q[i]).abs()).fold(0.0, f64::max);
        let largest = out.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        held.residual = if largest == 0.0 { 0.0 } else { largest / scale.max(f64::MIN_POSITIVE) };
        if held.residual < TOLERANCE {
            held.status = StaticsStatus::Converged;
            return;
        }
        stalled = if held.residual < 0.5 * least { 0 } else { stalled + 1 };
        least = least.min(held.residual);
        // Rounding of a stiff beam may end a little above the tolerance.
        if stalled > 3 && held.residual < 1e3 * TOLERANCE {
            held.status = StaticsStatus::Converged;
            return;
        }
        held.iterations += 1;
        let change = stiffness.lu().solve(&DVector::from_column_slice(&out));
        match change.filter(|change| change.iter().all(|x| x.is_finite())) {
            Some(change) => held.q.iter_mut().zip(change.iter()).for_each(|(q, c)| *q -= c),
            None => {
                held.status = StaticsStatus::Singular;
                return;
            }
        }
    }
    held.status = StaticsStatus::NotConverged;
}
