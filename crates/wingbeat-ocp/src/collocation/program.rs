//! A collocated problem seen as a nonlinear program.

use super::assembly::unpack;
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
        self.parts.evaluate(self.problem, w)?;
        let Discretisation { setup, ends, .. } = &mut self.parts;
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
        parts.evaluate(self.problem, w)?;
        // The derivatives of the points of a group are assembled while they are in the cache; the ends of its intervals are
        // differentiated with the next one.
        parts.finite = true;
        let groups = parts.groups();
        for group in 0..=groups {
            parts.differentiate_group(self.problem, group, w, multipliers)?;
            if group > 0 {
                parts.assemble(group - 1, w, weight, out);
            }
        }
        parts.finish(out);
        Ok(())
    }

    fn derivatives_are_finite(&self) -> Option<bool> {
        Some(self.parts.finite)
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
            let [begin, end] = interval.ends;
            for i in begin..end + usize::from(k + 1 == self.layout.intervals.len()) {
                let Some(first) = self.layout.points[i].path else { continue };
                for row in 0..self.points.path() {
                    let entries = self.assembly.path_columns(i - begin);
                    structure.jacobian.extend(entries.map(|c| (first + row, columns[c])));
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

    /// The derivatives of the program that belong to the intervals of `group`, where those of the functions were taken.
    fn assemble(&mut self, group: usize, w: &[f64], weight: f64, out: &mut Derivatives) {
        let (span, last) = (self.span(w), self.last_of(group));
        self.begin_group(group, last);
        if self.transcribed.scheme.compressed {
            self.map_middle(group, span);
        }
        self.defect_rows(group, span);
        self.path_rows(group);
        self.hessian_block(group, weight, last);
        let costs = self.cost_slopes(group, span, last);
        let Assembly { rows, block, cost, .. } = &self.assembly;
        let first = Double4::WIDTH * group;
        let count = Double4::WIDTH.min(self.layout.intervals.len() - first);
        // All times zero are zero. What the derivatives of the ends add is looked through by `finish`.
        let zeros =
            rows.iter().chain(block).fold(Double4::ZERO, |sum, entry| entry.mul_add(Double4::ZERO, sum));
        self.finite &= zeros.is_zero();
        unpack(rows, &mut out.jacobian[first * rows.len()..][..count * rows.len()]);
        unpack(block, &mut out.hessian[first * block.len()..][..count * block.len()]);
        let times = self.layout.times;
        for lane in 0..count {
            for (column, cost) in self.columns(first + lane).into_iter().zip(cost) {
                self.gradient[column] += cost.lane(lane);
            }
            self.gradient[times + 1] += costs.lane(lane);
            self.gradient[times] -= costs.lane(lane);
        }
        if let Some(lane) = last
            && self.layout.points[self.layout.points.len() - 1].path.is_some()
        {
            let begin = self.layout.intervals.len() * rows.len();
            let end = out.jacobian.len() - self.ends.jacobian.len();
            self.last_path_rows(lane, &mut out.jacobian[begin..end]);
            self.finite &= out.jacobian[begin..end].iter().all(|slope| slope.is_finite());
        }
    }

    /// The derivatives of the functions of the ends, and the gradient.
    fn finish(&mut self, out: &mut Derivatives) {
        let (size, ends) = (self.ends.columns.len(), &self.ends);
        let first = out.jacobian.len() - ends.jacobian.len();
        for (out, &(i, j)) in out.jacobian[first..].iter_mut().zip(&ends.jacobian) {
            *out = ends.slopes[i * size + j];
        }
        let first = out.hessian.len() - ends.hessian.len();
        for (out, &(i, j)) in out.hessian[first..].iter_mut().zip(&ends.hessian) {
            *out = ends.curvature[i * size + j];
        }
        out.gradient.copy_from_slice(&self.gradient);
        self.finite &= ends.slopes.iter().chain(&ends.curvature).all(|slope| slope.is_finite());
    }
}
