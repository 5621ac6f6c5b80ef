//! A collocated problem seen as a nonlinear program.

use super::*;

impl<P: OptimalControl> Program for Collocation<'_, P> {
    fn variables(&self) -> &[Channel] {
        &self.layout.variables
    }

    fn constraints(&self) -> &[Channel] {
        &self.layout.constraints
    }

    fn structure(&self) -> Structure {
        let mut structure = Structure {
            variable_block: self.layout.variable_block.clone(),
            constraint_block: self.layout.constraint_block.clone(),
            ..Structure::default()
        };
        let n = self.setup.states.len();
        for (k, interval) in self.layout.intervals.iter().enumerate() {
            let columns = self.columns(k);
            for row in 0..(self.transcribed.scheme.points() - 1) * n {
                structure.jacobian.extend(columns.iter().map(|&c| (interval.row + row, c)));
            }
            for i in self.owned(k) {
                let Some(first) = self.layout.points[i].path else { continue };
                for row in 0..self.points.path() {
                    for [(a, _), (b, wb)] in self.local_map(i, k) {
                        structure.jacobian.push((first + row, columns[a]));
                        if wb != 0.0 {
                            structure.jacobian.push((first + row, columns[b]));
                        }
                    }
                }
            }
            for (a, &row) in columns.iter().enumerate() {
                structure.hessian.extend(columns[..=a].iter().map(|&c| (row, c)));
            }
        }
        let ends = &self.ends;
        let row = |i: usize| self.layout.ends + i - 1;
        structure.jacobian.extend(ends.jacobian.iter().map(|&(i, j)| (row(i), ends.columns[j])));
        structure.hessian.extend(ends.hessian.iter().map(|&(i, j)| (ends.columns[i], ends.columns[j])));
        structure
    }

    fn evaluate(&mut self, w: &[f64], g: &mut [f64]) -> Result<f64, EvaluationError> {
        self.points.evaluate(self.problem, &self.setup, &self.layout, w)?;
        self.ends.evaluate(self.problem, &self.setup, w)?;
        let (n, times) = (self.setup.states.len(), self.layout.times);
        let (span, scheme) = (w[times + 1] - w[times], &self.transcribed.scheme);
        for interval in &self.layout.intervals {
            for j in 1..scheme.points() {
                let (x0, x) =
                    (self.layout.points[interval.point].x, self.layout.points[interval.point + j].x);
                for r in 0..n {
                    let rates = scheme.a[j].iter().enumerate();
                    let sum: f64 = rates.map(|(i, a)| a * self.points.value(interval.point + i)[r]).sum();
                    g[interval.row + (j - 1) * n + r] = w[x + r] - w[x0 + r] - span * interval.share * sum;
                }
            }
        }
        let mut cost = 0.0;
        for (i, place) in self.layout.points.iter().enumerate() {
            let value = self.points.value(i);
            cost += place.weight * value[n];
            if let Some(first) = place.path {
                g[first..first + self.points.path()].copy_from_slice(&value[n + 1..]);
            }
        }
        g[self.layout.ends..].copy_from_slice(&self.ends.values[1..]);
        Ok(self.ends.values[0] + span * cost + self.input_change(w, None))
    }

    fn differentiate(
        &mut self,
        w: &[f64],
        weight: f64,
        multipliers: &[f64],
        out: &mut Derivatives,
    ) -> Result<(), EvaluationError> {
        let (n, times) = (self.setup.states.len(), self.layout.times);
        let span = w[times + 1] - w[times];
        self.weigh(weight, multipliers);
        self.scale_weights(span, multipliers);
        self.points.differentiate(self.problem, &self.layout, w, &self.scaled)?;
        self.end_weights[0] = weight;
        self.end_weights[1..].copy_from_slice(&multipliers[self.layout.ends..]);
        self.ends.differentiate(self.problem, w, &self.end_weights);
        out.jacobian.clear();
        out.hessian.clear();
        for k in 0..self.layout.intervals.len() {
            self.defect_rows(k, span);
            out.jacobian.extend(&self.rows);
            self.path_rows(k, n, &mut out.jacobian);
            self.hessian_block(k, weight);
            let width = self.block.len().isqrt();
            for (a, row) in self.block.chunks_exact(width).enumerate() {
                out.hessian.extend(&row[..=a]);
            }
        }
        let size = self.ends.columns.len();
        out.jacobian.extend(self.ends.jacobian.iter().map(|&(i, j)| self.ends.slopes[i * size + j]));
        out.hessian.extend(self.ends.hessian.iter().map(|&(i, j)| self.ends.curvature[i * size + j]));
        self.objective_gradient(w);
        out.gradient.copy_from_slice(&self.gradient);
        Ok(())
    }
}

impl<P: OptimalControl> Collocation<'_, P> {
    /// Weights of the outputs as they enter the Hessian: the time span
    /// multiplies rates and cost, path values have their own multipliers.
    fn scale_weights(&mut self, span: f64, multipliers: &[f64]) {
        let (n, outputs) = (self.setup.states.len(), self.points.outputs);
        for (i, place) in self.layout.points.iter().enumerate() {
            let scaled = &mut self.scaled[i * outputs..(i + 1) * outputs];
            for (s, w) in scaled[..=n].iter_mut().zip(&self.weights[i * outputs..]) {
                *s = span * w;
            }
            match place.path {
                Some(first) => scaled[n + 1..].copy_from_slice(&multipliers[first..first + outputs - n - 1]),
                None => scaled[n + 1..].fill(0.0),
            }
        }
    }

    /// Jacobian rows of the path constraints that belong to interval `k`.
    fn path_rows(&self, k: usize, n: usize, out: &mut Vec<f64>) {
        let locals = self.points.locals;
        for i in self.owned(k) {
            if self.layout.points[i].path.is_none() {
                continue;
            }
            let map = self.local_map(i, k);
            for row in self.points.jacobian(i)[(n + 1) * locals..].chunks_exact(locals) {
                for (&[(_, wa), (_, wb)], slope) in map.iter().zip(row) {
                    out.push(wa * slope);
                    if wb != 0.0 {
                        out.push(wb * slope);
                    }
                }
            }
        }
    }
}
