//! A collocated problem seen as a nonlinear program.

use super::*;

impl<P: OptimalControl> Program for Collocation<'_, P> {
    fn variables(&self) -> &[Channel] {
        &self.parts.layout.variables
    }

    fn constraints(&self) -> &[Channel] {
        &self.parts.layout.constraints
    }

    fn structure(&self) -> Structure {
        self.parts.structure()
    }

    fn evaluate(&mut self, w: &[f64], g: &mut [f64]) -> Result<f64, EvaluationError> {
        let Discretisation { setup, layout, points, ends, .. } = &mut self.parts;
        let order = layout.unknown_states().chain(layout.middle_states());
        points.evaluate(self.problem, setup, layout, w, order)?;
        ends.evaluate(self.problem, setup, w)?;
        Ok(self.parts.values(w, g))
    }

    fn differentiate(
        &mut self,
        w: &[f64],
        weight: f64,
        multipliers: &[f64],
        out: &mut Derivatives,
    ) -> Result<(), EvaluationError> {
        let parts = &mut self.parts;
        parts.weigh(weight, multipliers);
        parts.end_weights[0] = weight;
        parts.end_weights[1..].copy_from_slice(&multipliers[parts.layout.ends..]);
        parts.ends.differentiate(self.problem, w, &parts.end_weights);
        parts.begin_gradient(w);
        if parts.transcribed.scheme.compressed {
            let nodes = parts.layout.unknown_states();
            parts.points.evaluate(self.problem, &parts.setup, &parts.layout, w, nodes)?;
        }
        out.jacobian.clear();
        out.hessian.clear();
        // The derivatives of the points of an interval are assembled while they are in the cache; its end is differentiated with the
        // next one.
        let last = parts.layout.intervals.len() - 1;
        for k in 0..=last {
            parts.differentiate_interval(self.problem, k, w, multipliers)?;
            if k > 0 {
                parts.assemble(k - 1, w, weight, out);
            }
        }
        parts.assemble(last, w, weight, out);
        parts.finish(out);
        Ok(())
    }
}

impl Discretisation {
    /// Non-zeros and elimination blocks.
    fn structure(&self) -> Structure {
        let mut structure = Structure {
            variable_block: self.layout.variable_block.clone(),
            constraint_block: self.layout.constraint_block.clone(),
            ..Structure::default()
        };
        let n = self.setup.states.len();
        for (k, interval) in self.layout.intervals.iter().enumerate() {
            let columns = self.columns(k);
            for row in 0..self.transcribed.scheme.defects().len() * n {
                structure.jacobian.extend(columns.iter().map(|&c| (interval.row + row, c)));
            }
            for i in self.owned(k) {
                let Some(first) = self.layout.points[i].path else { continue };
                for row in 0..self.points.path() {
                    for &[(a, _), (b, wb)] in &self.assembly.map(k, i - interval.ends[0]).shares {
                        structure.jacobian.push((first + row, columns[a]));
                        if wb != 0.0 {
                            structure.jacobian.push((first + row, columns[b]));
                        }
                    }
                }
            }
            for (a, &row) in columns.iter().enumerate() {
                structure.hessian.extend(columns[a..].iter().map(|&c| (row, c)));
            }
        }
        let ends = &self.ends;
        let row = |i: usize| self.layout.ends + i - 1;
        structure.jacobian.extend(ends.jacobian.iter().map(|&(i, j)| (row(i), ends.columns[j])));
        structure.hessian.extend(ends.hessian.iter().map(|&(i, j)| (ends.columns[i], ends.columns[j])));
        structure
    }

    /// The objective at the unknowns `w`, where the functions were evaluated; writes the constraint values.
    fn values(&self, w: &[f64], g: &mut [f64]) -> f64 {
        let (n, times) = (self.setup.states.len(), self.layout.times);
        let (span, scheme) = (w[times + 1] - w[times], &self.transcribed.scheme);
        for interval in &self.layout.intervals {
            for (block, j) in scheme.defects().enumerate() {
                let StateOf::Unknown(x) = self.layout.points[interval.ends[0] + j].x else { continue };
                let StateOf::Unknown(x0) = self.layout.points[interval.ends[0]].x else { continue };
                for r in 0..n {
                    let rates = scheme.a[j].iter().enumerate();
                    let sum: f64 = rates.map(|(i, a)| a * self.points.value(interval.ends[0] + i)[r]).sum();
                    g[interval.row + block * n + r] = w[x + r] - w[x0 + r] - span * interval.share * sum;
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
        self.ends.values[0] + span * cost + self.input_change(w, None)
    }

    /// The derivatives of the program that belong to interval `k`, where those of the functions were taken.
    fn assemble(&mut self, k: usize, w: &[f64], weight: f64, out: &mut Derivatives) {
        let span = self.span(w);
        if self.transcribed.scheme.compressed {
            self.map_middle(k, span);
        }
        self.defect_rows(k, span, &mut out.jacobian);
        self.path_rows(k, &mut out.jacobian);
        self.hessian_block(k, weight);
        self.add_cost_slopes(k, span);
        for (a, row) in self.assembly.block.chunks_exact(self.assembly.width).enumerate() {
            out.hessian.extend(&row[a..]);
        }
    }

    /// The derivatives of the functions of the ends, and the gradient.
    fn finish(&mut self, out: &mut Derivatives) {
        let size = self.ends.columns.len();
        out.jacobian.extend(self.ends.jacobian.iter().map(|&(i, j)| self.ends.slopes[i * size + j]));
        out.hessian.extend(self.ends.hessian.iter().map(|&(i, j)| self.ends.curvature[i * size + j]));
        out.gradient.copy_from_slice(&self.gradient);
    }

    /// Jacobian rows of the path constraints that belong to interval `k`.
    fn path_rows(&self, k: usize, out: &mut Vec<f64>) {
        let (n, locals) = (self.setup.states.len(), self.points.locals);
        for i in self.owned(k) {
            if self.layout.points[i].path.is_none() {
                continue;
            }
            let map = self.assembly.map(k, i - self.layout.intervals[k].ends[0]);
            for row in self.points.jacobian(i)[(n + 1) * locals..].chunks_exact(locals) {
                for (&[(_, wa), (_, wb)], slope) in map.shares.iter().zip(row) {
                    out.push(wa * slope);
                    if wb != 0.0 {
                        out.push(wb * slope);
                    }
                }
            }
        }
    }
}
