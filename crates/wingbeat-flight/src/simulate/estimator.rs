//! From measurements to the state that a model-based controller starts from.

use super::record::Column;
use super::sensor::Measurement;
use wingbeat_ocp::plant::Fault;

/// Why there is no estimate.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoEstimate {
    /// Too little is measured.
    #[error("{measured} of {states} states are measured, and the estimator needs all")]
    Unmeasured {
        /// Channels measured.
        measured: usize,
        /// States of the plant.
        states: usize,
    },
    /// The estimator's model broke down.
    #[error(transparent)]
    Fault(#[from] Fault),
}

/// Estimates a plant's state from what is measured and what was commanded.
pub trait Estimator {
    /// Writes the state at time `t` (s) into `x`, given the inputs `u` commanded up to then.
    ///
    /// # Errors
    /// [`NoEstimate`] when the measurement holds too little, or a model of the estimator breaks down.
    fn estimate(
        &mut self,
        t: f64,
        measurement: &Measurement,
        u: &[f64],
        x: &mut [f64],
    ) -> Result<(), NoEstimate>;
    /// Columns of [`diagnostics`](Self::diagnostics).
    fn columns(&self) -> Vec<Column> {
        Vec::new()
    }
    /// Appends what the last estimate tells of itself, one number per column in its unit.
    fn diagnostics(&self, _row: &mut Vec<f64>) {}
}

/// Perfect knowledge: takes the measurement for the whole true state, that of the air included,
/// noise and delay as they come. No robot has it.
#[derive(Clone, Copy, Debug, Default)]
pub struct TrueState;

impl Estimator for TrueState {
    fn estimate(
        &mut self,
        _: f64,
        measurement: &Measurement,
        _: &[f64],
        x: &mut [f64],
    ) -> Result<(), NoEstimate> {
        let (values, states) = (measurement.values(), x.len());
        if values.len() != states {
            return Err(NoEstimate::Unmeasured { measured: values.len(), states });
        }
        x.copy_from_slice(values);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_ocp::plant::Channel;

    #[test]
    fn a_part_of_the_state_is_no_perfect_knowledge() {
        let channels = ["a", "b"].map(|name| Channel::free(name, "", ""));
        let mut x = [0.0; 2];
        let whole = Measurement::new(0.0, &channels, &[1.0, 2.0]);
        assert_eq!((TrueState.estimate(0.1, &whole, &[], &mut x), x), (Ok(()), [1.0, 2.0]));
        let part = Measurement::new(0.0, &channels[..1], &[1.0]);
        let refused = TrueState.estimate(0.1, &part, &[], &mut x).unwrap_err();
        assert_eq!(refused.to_string(), "1 of 2 states are measured, and the estimator needs all");
    }
}
