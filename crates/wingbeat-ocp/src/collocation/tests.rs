use super::super::problem::{Ends, Instant};
use super::*;
use crate::plant::Fault;
use wingbeat_math::Scalar;

/// A problem that uses everything: free times, a parameter, explicit time,
/// path and end constraints, both costs.
struct Everything;

impl OptimalControl for Everything {
    fn setup(&self) -> Setup {
        let free = |name: &str| Channel::free(name, "", "");
        let mut setup = Setup::new(vec![free("a"), free("b")], vec![free("u"), free("v")], [0.5, 3.0]);
        setup.times[0] = [-1.0, 1.0];
        setup.parameters = vec![free("p")];
        setup.path = vec![free("power")];
        setup.ends = vec![free("closure")];
        setup.input_change = 0.3;
        setup
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        dx[0] = at.x[1].sin() * at.u[0] + at.t * at.p[0];
        dx[1] = at.x[0] * at.x[1] - at.u[1].squared() * at.t;
        Ok(())
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        at.u[0].squared() * at.x[0] + at.t * at.u[1] * at.p[0]
    }
    fn constrain_path<S: Scalar>(&self, at: Instant<S>, values: &mut [S]) {
        values[0] = at.x[0] * at.u[1] + at.t.squared() * at.u[0];
    }
    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        ends.t[1] * ends.x[1][0] * ends.p[0] + ends.x[0][1].exp()
    }
    fn constrain_ends<S: Scalar>(&self, ends: Ends<S>, values: &mut [S]) {
        values[0] = ends.x[0][0] * ends.x[1][1] - ends.t[0].squared();
    }
}

/// Central difference of `f` along component `j`.
fn slope(f: &mut impl FnMut(&[f64]) -> Vec<f64>, w: &[f64], j: usize) -> Vec<f64> {
    let h = 1e-5;
    let mut moved = w.to_vec();
    moved[j] = w[j] + h;
    let above = f(&moved);
    moved[j] = w[j] - h;
    let below = f(&moved);
    above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * h)).collect()
}

#[test]
fn derivatives_of_every_scheme_agree_with_differences() {
    for scheme in [
        Scheme::trapezoid(),
        Scheme::hermite_simpson(),
        Scheme::separated_hermite_simpson(),
        Scheme::lobatto(),
    ] {
        let transcribed = Transcribed { mesh: vec![0.0, 0.3, 1.0], scheme, cost_at_nodes: false };
        let mut guess = Everything.setup().straight_line();
        guess.p = vec![0.7];
        let mut program = Collocation::new(&Everything, transcribed, &guess);
        let structure = program.structure();
        let (n, m) = (program.variables().len(), program.constraints().len());
        let w: Vec<f64> = (0..n).map(|k| 0.4 + 0.3 * (k as f64 * 1.9).sin()).collect();
        let y: Vec<f64> = (0..m).map(|k| (k as f64 * 2.3).cos()).collect();
        let mut out = Derivatives::new(n, &structure);
        program.differentiate(&w, 1.7, &y, &mut out).unwrap();
        let mut jacobian = vec![0.0; m * n];
        structure.jacobian.iter().zip(&out.jacobian).for_each(|(&(i, j), v)| jacobian[i * n + j] += v);
        let mut hessian = vec![0.0; n * n];
        for (&(i, j), v) in structure.hessian.iter().zip(&out.hessian) {
            hessian[i * n + j] += v;
            if i != j {
                hessian[j * n + i] += v;
            }
        }
        let gradient = out.gradient.clone();
        for j in 0..n {
            let mut values = |w: &[f64]| {
                let mut g = vec![0.0; m + 1];
                g[m] = program.evaluate(w, &mut g[..m]).unwrap();
                g
            };
            let s = slope(&mut values, &w, j);
            assert!((s[m] - gradient[j]).abs() < 1e-7, "gradient {j}: {} {}", s[m], gradient[j]);
            (0..m).for_each(|i| assert!((s[i] - jacobian[i * n + j]).abs() < 1e-7, "row {i} column {j}"));
        }
        for j in 0..n {
            let mut lagrangian = |w: &[f64]| {
                program.differentiate(w, 1.7, &y, &mut out).unwrap();
                let mut r: Vec<f64> = out.gradient.iter().map(|g| 1.7 * g).collect();
                structure.jacobian.iter().zip(&out.jacobian).for_each(|(&(i, c), v)| r[c] += v * y[i]);
                r
            };
            let s = slope(&mut lagrangian, &w, j);
            (0..n).for_each(|i| {
                let h = hessian[i * n + j];
                assert!((s[i] - h).abs() < 1e-6, "hessian {i} {j}: {} {h}", s[i]);
            });
        }
    }
}
