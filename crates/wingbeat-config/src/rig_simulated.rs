//! A run of the bench from its plan to its samples.

use super::{LatticeSummary, RigRun};
use wingbeat_flight::simulate::Record;
use wingbeat_math::Error;

/// What became of a simulated run.
#[derive(Clone, Debug)]
pub struct SimulatedRun {
    /// `ok`, `refused` where the turn cannot be planned, or `fault`.
    pub status: &'static str,
    /// Why, when not `ok`.
    pub reason: Option<String>,
    /// Begin and end of what is averaged, s.
    pub window_s: (f64, f64),
    /// The samples, of a run that is `ok`.
    pub record: Option<Record>,
    /// Samples with a saturated channel.
    pub saturated: usize,
    /// Share of strips and samples after the rest that are past their stall angle.
    pub stall_fraction: f64,
    /// How motion and vortex lattice were brought together, where one takes the place of the preset's attached flow.
    pub lattice: Option<LatticeSummary>,
    /// Cautions that a reader must know.
    pub warnings: Vec<String>,
}

impl SimulatedRun {
    fn without_samples(status: &'static str, reason: String, window_s: (f64, f64)) -> Self {
        Self {
            status,
            reason: Some(reason),
            window_s,
            record: None,
            saturated: 0,
            stall_fraction: 0.0,
            lattice: None,
            warnings: Vec::new(),
        }
    }
}

impl RigRun {
    /// Plans the turn, where there is one, and simulates the run on the bench that `rig.truth` says is the true one; `progress` is told the share that is done.
    ///
    /// # Errors
    /// Those of [`plan`](Self::plan) and [`simulate`](Self::simulate).
    pub fn simulated(&self, seed: u64, progress: impl FnMut(f64)) -> Result<SimulatedRun, Error> {
        let plan = match self.spec.turn {
            None => None,
            Some(_) => match self.plan()? {
                Ok(plan) => Some(plan),
                Err(refusal) => {
                    let reason = format!("limit profile {}: {refusal}", self.profile.name);
                    return Ok(SimulatedRun::without_samples("refused", reason, (0.0, 0.0)));
                }
            },
        };
        let carrier = self.carrier(plan.as_ref());
        let window_s = self.window(plan.as_ref(), &carrier);
        Ok(match self.simulate_truth(&carrier, window_s, seed, progress)? {
            Ok(outcome) => {
                let lattice = outcome.coupling.map(LatticeSummary::new);
                SimulatedRun {
                    status: "ok",
                    reason: None,
                    window_s,
                    record: Some(outcome.record),
                    saturated: outcome.saturated,
                    stall_fraction: outcome.stall_fraction,
                    lattice,
                    warnings: lattice.iter().flat_map(LatticeSummary::cautions).collect(),
                }
            }
            Err(fault) => SimulatedRun::without_samples("fault", fault.to_string(), window_s),
        })
    }
}
