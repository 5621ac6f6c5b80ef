//! Joint trajectories sampled at a fixed step.

use wingbeat_math::Error;

/// Joint positions, rates and accelerations at equal steps of time. One row per instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointTrajectory {
    /// Joint names.
    pub joints: Vec<String>,
    /// Step, s.
    pub step: f64,
    /// Positions, rad or m.
    pub position: Vec<Vec<f64>>,
    /// Rates, rad/s; empty when the source gives none.
    pub velocity: Vec<Vec<f64>>,
    /// Accelerations, rad/s2; empty when the source gives none.
    pub acceleration: Vec<Vec<f64>>,
}

impl JointTrajectory {
    /// Number of instants.
    pub fn len(&self) -> usize {
        self.position.len()
    }
    /// True without any instant.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }
    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.len().saturating_sub(1) as f64 * self.step
    }
    /// Positions, rates and accelerations as they follow from the positions
    /// alone, by central differences: what the receiver of the samples sees.
    /// Rows are those of `position`; the ends repeat their neighbours.
    pub fn differenced(&self) -> Self {
        let rate = difference(&self.position, self.step);
        let acceleration = second_difference(&self.position, self.step);
        Self { velocity: rate, acceleration, ..self.clone() }
    }
    /// Largest |jerk| of each joint, from third differences of the positions, rad/s3.
    pub fn peak_jerk(&self) -> Vec<f64> {
        let scale = 1.0 / self.step.powi(3);
        let mut peak = vec![0.0_f64; self.joints.len()];
        for w in self.position.windows(4) {
            for (j, peak) in peak.iter_mut().enumerate() {
                let third = w[3][j] - 3.0 * w[2][j] + 3.0 * w[1][j] - w[0][j];
                *peak = peak.max(third.abs() * scale);
            }
        }
        peak
    }
    /// Largest |rate| and |acceleration| of each joint, rad/s and rad/s2.
    pub fn peaks(&self) -> (Vec<f64>, Vec<f64>) {
        (peak(&self.velocity, self.joints.len()), peak(&self.acceleration, self.joints.len()))
    }
    /// Checks that every row has one finite number per joint.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the first bad row.
    pub fn check(&self) -> Result<(), Error> {
        if self.is_empty() {
            return Err(Error::invalid("trajectory.points", 0, "at least one point"));
        }
        if !(self.step > 0.0 && self.step.is_finite()) && self.len() > 1 {
            return Err(Error::invalid("trajectory.step_s", self.step, "more than zero"));
        }
        for (name, rows) in
            [("position", &self.position), ("velocity", &self.velocity), ("acceleration", &self.acceleration)]
        {
            if !rows.is_empty() && rows.len() != self.len() {
                let key = format!("trajectory.{name}.points");
                return Err(Error::invalid(key, rows.len(), format!("{}, as positions", self.len())));
            }
            let bad = rows
                .iter()
                .position(|row| row.len() != self.joints.len() || row.iter().any(|x| !x.is_finite()));
            if let Some(row) = bad {
                let allowed = format!("{} finite numbers", self.joints.len());
                return Err(Error::invalid(
                    format!("trajectory.{name}[{row}]"),
                    format!("{:?}", rows[row]),
                    allowed,
                ));
            }
        }
        Ok(())
    }
}

fn peak(rows: &[Vec<f64>], joints: usize) -> Vec<f64> {
    (0..joints).map(|j| rows.iter().fold(0.0_f64, |m, row| m.max(row[j].abs()))).collect()
}

fn difference(rows: &[Vec<f64>], step: f64) -> Vec<Vec<f64>> {
    inner(rows, |a, _, c| (c - a) / (2.0 * step))
}

fn second_difference(rows: &[Vec<f64>], step: f64) -> Vec<Vec<f64>> {
    inner(rows, |a, b, c| (a - 2.0 * b + c) / (step * step))
}

fn inner(rows: &[Vec<f64>], f: impl Fn(f64, f64, f64) -> f64) -> Vec<Vec<f64>> {
    let row = |w: &[Vec<f64>]| (0..w[1].len()).map(|j| f(w[0][j], w[1][j], w[2][j])).collect();
    let mut out: Vec<Vec<f64>> = rows.windows(3).map(row).collect();
    let (Some(first), Some(last)) = (out.first().cloned(), out.last().cloned()) else {
        return rows.iter().map(|r| vec![0.0; r.len()]).collect();
    };
    out.insert(0, first);
    out.push(last);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_of_a_cubic() {
        let step = 1e-3;
        let position = (0..50).map(|k| vec![(k as f64 * step).powi(3)]).collect();
        let t = JointTrajectory { joints: vec!["a".into()], step, position, ..Default::default() };
        let seen = t.differenced();
        assert!((seen.velocity[20][0] - 3.0 * 0.02_f64.powi(2)).abs() < 2e-6);
        assert!((seen.acceleration[20][0] - 6.0 * 0.02).abs() < 1e-8);
        assert!((t.peak_jerk()[0] - 6.0).abs() < 1e-4);
        t.check().unwrap();
    }

    #[test]
    fn a_short_row_is_named() {
        let position = vec![vec![0.0, 1.0], vec![0.0]];
        let joints = vec!["a".into(), "b".into()];
        let t = JointTrajectory { joints, step: 1e-3, position, ..Default::default() };
        assert!(t.check().unwrap_err().to_string().contains("position[1]"));
    }
}
