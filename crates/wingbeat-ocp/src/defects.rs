//! How far a trajectory misses the equations of collocation, from its states and inputs alone. Defects are in the units of the
//! states.

use super::problem::{Instant, OptimalControl};
use super::scheme::Scheme;
use super::trajectory::Trajectory;
use super::transcription::{IntervalEnds, Midpoint, Transcription};
use crate::plant::Fault;

/// Defects of `unknowns` under `scheme`: what the state of each point lacks that an integration from the start of its interval
/// gives it, x_j - x_0 - h sum_i A_ji f_i; zeros at the first point. The points are those of the unknown states: of the
/// compressed scheme the nodes, of the others every collocation point.
///
/// # Errors
/// The [`Fault`] of a state that the model refuses.
///
/// Equation: ocp.defect
pub fn defects<P: OptimalControl>(
    problem: &P,
    scheme: &Scheme,
    unknowns: &Trajectory,
) -> Result<Vec<Vec<f64>>, Fault> {
    let Trajectory { t, x, u, p } = unknowns;
    let rates = |t: f64, x: &[f64], u: &[f64], dx: &mut [f64]| problem.rates(Instant { t, x, u, p }, dx);
    let mut f = vec![vec![0.0; x[0].len()]; t.len()];
    for (k, f) in f.iter_mut().enumerate() {
        rates(t[k], &x[k], &u[k], f)?;
    }
    let mut out = vec![vec![0.0; x[0].len()]; t.len()];
    if scheme.compressed {
        let mut middle = Midpoint::new(x[0].len(), u[0].len());
        for k in 1..t.len() {
            let [x, u, f] = [x, u, &f].map(|of| [of[k - 1].as_slice(), &of[k]]);
            let interval = IntervalEnds { t: t[k - 1], h: t[k] - t[k - 1], x, u, f };
            Transcription::HermiteSimpson.defect(&interval, rates, &mut middle, &mut out[k])?;
        }
        return Ok(out);
    }
    let inner = scheme.points() - 1;
    for first in (0..t.len() - 1).step_by(inner) {
        let h = t[first + inner] - t[first];
        for j in 1..=inner {
            for (i, defect) in out[first + j].iter_mut().enumerate() {
                let sum: f64 = scheme.a[j].iter().zip(&f[first..]).map(|(a, f)| a * f[i]).sum();
                *defect = x[first + j][i] - x[first][i] - h * sum;
            }
        }
    }
    Ok(out)
}
