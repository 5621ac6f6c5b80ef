//! Beams by equations written apart from the library: shooting along the span, and the elastica.

use crate::Error;
use wingbeat::math::{EqualSteps, RK4, Workspace};

/// Steps of the shooting along the span.
const STEPS: usize = 2000;

/// A beam whose numbers are linear along the span, x from 0 at the root to 1 at the tip; length 1 m.
#[derive(Clone, Copy, Debug, Default)]
pub struct TaperedBeam {
    /// Bending and torsional stiffness (N m2), mass (kg/m) and inertia about the axis (kg m) at the root.
    pub root: [f64; 4],
    /// The same at the tip.
    pub tip: [f64; 4],
    /// Static moment about the axis over mass, m.
    pub offset: f64,
    /// Rate of turn about an axis across the root, rad/s.
    pub turning: f64,
}

impl TaperedBeam {
    fn at(&self, x: f64) -> [f64; 4] {
        std::array::from_fn(|k| self.root[k] + (self.tip[k] - self.root[k]) * x)
    }

    /// Tension of the turning beam, N: the integral of m W^2 x from x to the tip.
    fn tension(&self, x: f64) -> f64 {
        let [from, slope] = [self.root[2], self.tip[2] - self.root[2]];
        let moment = |x: f64| from * x * x / 2.0 + slope * x.powi(3) / 3.0;
        self.turning.powi(2) * (moment(1.0) - moment(x))
    }

    /// Deflection, slope, moment, shear, twist and torque from the root to the tip for the `start` of the last three:
    /// E I y'' = M, M' = -V + T y', V' = w^2 (m y + m e t), t' = Q/GJ, Q' = -w^2 (I t + m e y); V is taken across the undeformed beam.
    fn shoot(&self, omega: f64, start: [f64; 3]) -> [f64; 6] {
        let mut y = [0.0, 0.0, start[0], start[1], 0.0, start[2]];
        let slope = |x: f64, y: &[f64], dy: &mut [f64]| -> Result<(), Error> {
            let [bend, twist, mass, inertia] = self.at(x);
            let square = omega * omega;
            let static_moment = mass * self.offset;
            dy.copy_from_slice(&[
                y[1],
                y[2] / bend,
                -y[3] + self.tension(x) * y[1],
                -square * (mass * y[0] + static_moment * y[4]),
                y[5] / twist,
                -square * (inertia * y[4] + static_moment * y[0]),
            ]);
            Ok(())
        };
        let mut work = Workspace::new(6, RK4.b.len());
        for i in 0..STEPS {
            let h = 1.0 / STEPS as f64;
            let _ = RK4.step(slope, i as f64 * h, h, &mut y, &mut work);
        }
        y
    }

    /// What the free tip asks, as a determinant: moment, shear and torque vanish.
    fn determinant(&self, omega: f64) -> f64 {
        let columns =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|start| self.shoot(omega, start));
        let [a, b, c] = columns.map(|y| [y[2], y[3], y[5]]);
        a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1])
            + c[0] * (a[1] * b[2] - a[2] * b[1])
    }

    /// The lowest `count` frequencies, rad/s, sought from 0 in steps of `width` rad/s.
    pub fn frequencies(&self, count: usize, width: f64) -> Vec<f64> {
        let (mut found, mut low, mut before) = (Vec::new(), 0.0, self.determinant(0.0));
        while found.len() < count {
            let (high, after) = (low + width, self.determinant(low + width));
            if before.signum() != after.signum() {
                let (mut a, mut b) = (low, high);
                while b - a > 1e-10 * b {
                    let middle = 0.5 * (a + b);
                    if self.determinant(middle).signum() == before.signum() { a = middle } else { b = middle }
                }
                found.push(0.5 * (a + b));
            }
            (low, before) = (high, after);
        }
        found
    }
}

/// Deflection and shortening over length of a cantilever under a tip load of fixed direction, P L^2 / E I = `load`
/// (Bisshopp & Drucker 1945): t'' = -a cos t with t(0) = 0, t'(1) = 0, by shooting for the curvature at the root.
pub fn elastica(load: f64) -> Result<[f64; 2], Error> {
    let end = |curvature: f64| {
        let mut y = [0.0, curvature, 0.0, 0.0];
        let slope = |_: f64, y: &[f64], dy: &mut [f64]| -> Result<(), Error> {
            dy.copy_from_slice(&[y[1], -load * y[0].cos(), y[0].sin(), y[0].cos()]);
            Ok(())
        };
        RK4.integrate(
            &mut { slope },
            EqualSteps::new(0.0, 1.0 / 4000.0, 4000),
            &mut y,
            &mut Workspace::new(4, 4),
        )
        .map(|_| y)
    };
    let (mut low, mut high) = (0.0, load);
    while high - low > 1e-14 * high {
        let middle = 0.5 * (low + high);
        if end(middle)?[1] < 0.0 { low = middle } else { high = middle }
    }
    let y = end(0.5 * (low + high))?;
    Ok([y[2], 1.0 - y[3]])
}

/// Tip, as shares of the length, of a cantilever along x under a load normal to its tip that turns with it, P L^2 / E I =
/// `load`: seen from the tip, where nothing bends it, an initial-value problem t'' = -a cos t.
pub fn followed(load: f64) -> Result<[f64; 2], Error> {
    // s from the tip; the load is along +y of the tip's axes, x points to the root.
    let mut y = [0.0_f64, 0.0, 0.0, 0.0];
    let slope = |_: f64, y: &[f64], dy: &mut [f64]| -> Result<(), Error> {
        dy.copy_from_slice(&[y[1], -load * y[0].cos(), y[0].cos(), y[0].sin()]);
        Ok(())
    };
    RK4.integrate(
        &mut { slope },
        EqualSteps::new(0.0, 1.0 / 4000.0, 4000),
        &mut y,
        &mut Workspace::new(4, 4),
    )?;
    // Tip seen from the root: the way back, turned so that the root's tangent lies along x.
    let (sin, cos) = y[0].sin_cos();
    Ok([y[2] * cos + y[3] * sin, (y[2] * sin - y[3] * cos).abs()])
}

/// How the root of a beam swings, by A (1 - cos(w t)), and the beam's bending stiffness.
#[derive(Clone, Copy, Debug)]
pub struct RootSwing {
    /// A, rad.
    pub amplitude: f64,
    /// w, rad/s.
    pub omega: f64,
    /// E I, N m2.
    pub stiffness: f64,
}

/// Deflections of the tip of a beam of length, mass per length and bending stiffness 1 in the axes of its root, which turns by
/// A (1 - cos(w t)) about an axis across it, at the ends of `steps` steps of `h`: small deflection y by six polynomials,
/// m (y.. + T.. x - T.^2 y) + y'''' - (T y')' = 0 with the tension m T.^2 (1 - x^2)/2.
/// Without `turning` the terms of T.^2 are left out.
pub fn flapped(swing: &RootSwing, turning: bool, h: f64, steps: usize) -> Result<Vec<f64>, Error> {
    let RootSwing { amplitude, omega, stiffness } = *swing;
    let share = if turning { 1.0 } else { 0.0 };
    const N: usize = 6;
    // y = sum c_k x^(k + 2); integrals of powers over the span are exact.
    let power = |k: usize| (k + 2) as f64;
    let pairs = |f: &dyn Fn(f64, f64) -> f64| -> [[f64; N]; N] {
        std::array::from_fn(|i| std::array::from_fn(|j| f(power(i), power(j))))
    };
    let mass = pairs(&|a, b| 1.0 / (a + b + 1.0));
    let bending = pairs(&|a, b| stiffness * a * (a - 1.0) * b * (b - 1.0) / (a + b - 3.0));
    let tension = pairs(&|a, b| 0.5 * a * b * (1.0 / (a + b - 1.0) - 1.0 / (a + b + 1.0)));
    let drive: [f64; N] = std::array::from_fn(|i| 1.0 / (power(i) + 2.0));
    let slope = |t: f64, y: &[f64], dy: &mut [f64]| -> Result<(), Error> {
        let (rate, acceleration) =
            (amplitude * omega * (omega * t).sin(), amplitude * omega * omega * (omega * t).cos());
        let load: [f64; N] = std::array::from_fn(|i| {
            let sum: f64 = (0..N)
                .map(|j| (bending[i][j] + share * rate * rate * (tension[i][j] - mass[i][j])) * y[j])
                .sum();
            -sum - acceleration * drive[i]
        });
        let solved = wingbeat::math::linear::solve_symmetric(mass, load);
        let a = solved.ok_or_else(|| Error::NoAnswer("the mass of six polynomials".into()))?;
        dy[..N].copy_from_slice(&y[N..]);
        dy[N..].copy_from_slice(&a);
        Ok(())
    };
    let (mut y, mut work, mut tips) = (vec![0.0; 2 * N], Workspace::new(2 * N, 4), Vec::new());
    const WITHIN: usize = 20;
    for k in 0..steps * WITHIN {
        let dt = h / WITHIN as f64;
        RK4.step(slope, k as f64 * dt, dt, &mut y, &mut work)?;
        if (k + 1) % WITHIN == 0 {
            tips.push(y[..N].iter().sum());
        }
    }
    Ok(tips)
}
