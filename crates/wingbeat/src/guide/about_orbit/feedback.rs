//! Periodic feedback about an orbit.

use super::spec::OrbitWeights;
use crate::orbit::Interval;
use nalgebra::DMatrix;

/// Cycles after which the feedback of an orbit must have settled.
const CYCLES: usize = 80;
/// Change of the feedback over a cycle at which it has, relative.
const SETTLED: f64 = 1e-5;
/// Coordinates of the body among those that deviate.
pub const BODY: usize = 8;

/// Feedback at each phase: commands by deviations, the integral of the height first.
#[derive(Clone, Debug)]
pub(super) struct Feedback(Vec<DMatrix<f64>>);

impl Feedback {
    /// Equation: guide.periodic_regulator
    ///
    /// Feedback K_k at each phase that minimises sum s' Q s + u' R u over all time: backwards over cycles
    /// K = (R + B'PB)^-1 B'PA, P = Q + A'P(A - B K) until K is the same a cycle earlier; `None` where it does not settle. The
    /// state is the integral of the height before the deviations, of which `coordinates` after the height are those of an
    /// orbit; `limits` are those of the commands and `duration` is that of a cycle. The states of air and elastic joints
    /// take part in the prediction and are left out of the feedback: they are not measured.
    pub fn new(
        w: &OrbitWeights,
        all: &[Interval],
        coordinates: usize,
        limits: &[f64],
        duration: f64,
    ) -> Option<Self> {
        let (n, m) = (all[0].a.nrows() + 1, limits.len());
        let mut cost = vec![0.0; n];
        cost[0] = w.height_integral_m_s.powi(-2);
        cost[1] = w.height_m.powi(-2);
        cost[2..5].fill(w.velocity_m_s.powi(-2));
        cost[5..7].fill(w.angle_deg.to_radians().powi(-2));
        cost[7..10].fill(w.rate_rad_s.powi(-2));
        let q = DMatrix::from_diagonal(&cost.into());
        let r = DMatrix::from_diagonal(&limits.iter().map(|l| l.powi(-2)).collect::<Vec<_>>().into());
        let interval = duration / all.len() as f64;
        let augmented = all.iter().map(|i| {
            let (mut a, mut b) = (DMatrix::zeros(n, n), DMatrix::zeros(n, m));
            (a[(0, 0)], a[(0, 1)]) = (1.0, interval);
            a.view_mut((1, 1), (n - 1, n - 1)).copy_from(&i.a);
            b.view_mut((1, 0), (n - 1, m)).copy_from(&i.b);
            (a, b)
        });
        let augmented: Vec<_> = augmented.collect();
        let mut p = q.clone();
        let mut gains: Vec<DMatrix<f64>> = vec![DMatrix::zeros(m, n); all.len()];
        for _ in 0..CYCLES {
            let mut change: f64 = 0.0;
            for (k, (a, b)) in augmented.iter().enumerate().rev() {
                let pb = &p * b;
                let gain = (&r + b.transpose() * &pb).cholesky()?.solve(&(pb.transpose() * a));
                change = change.max((&gain - &gains[k]).amax() / gain.amax());
                p = &q + a.transpose() * &p * (a - b * &gain);
                p = (&p + p.transpose()) * 0.5;
                gains[k] = gain;
            }
            if change < SETTLED {
                // Before the coordinates stand the integral and the height.
                for gain in &mut gains {
                    (2 + BODY..2 + coordinates).for_each(|column| gain.column_mut(column).fill(0.0));
                }
                return Some(Self(gains));
            }
        }
        None
    }

    /// That at `cycles` of the gait's phase, linear between phases.
    pub fn at(&self, cycles: f64) -> DMatrix<f64> {
        let phase = cycles.rem_euclid(1.0) * self.0.len() as f64;
        let k = (phase as usize).min(self.0.len() - 1);
        let share = phase - k as f64;
        &self.0[k] * (1.0 - share) + &self.0[(k + 1) % self.0.len()] * share
    }
}
