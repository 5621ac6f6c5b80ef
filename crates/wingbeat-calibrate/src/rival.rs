//! Other structures of the model, and other runs, beside those that were fitted.

use crate::design::{Candidate, largest, rank};
use crate::{Error, Observed, Problem, Solved, Structure, channel_name, rms};
use serde::Serialize;
use std::collections::BTreeMap;

/// A structure of the model with what it leaves.
#[derive(Clone, Debug, Serialize)]
pub struct Rival {
    /// Name.
    pub name: String,
    /// Sum of squares over freedom with the noise of the cycles alone.
    pub chi_squared: f64,
    /// Rms in runs left out, mean over the runs, by channel.
    pub left_out_rms: BTreeMap<String, f64>,
    /// The same in parts of the channels' measured rms, mean over the channels.
    pub left_out_share: f64,
    /// Rms in runs held out, by channel.
    pub held_out_rms: BTreeMap<String, f64>,
    /// The same in parts of the channels' measured rms, mean over the channels.
    pub held_out_share: Option<f64>,
    /// Values.
    pub values: Vec<f64>,
}

/// Mean over runs of the rms by channel, and that in parts of the measured rms.
fn shares(runs: &[Observed], of: &[(usize, Vec<f64>)]) -> (BTreeMap<String, f64>, f64) {
    let Some((first, _)) = of.first() else { return (BTreeMap::new(), f64::NAN) };
    let layout = runs[*first].layout;
    let (mut by_channel, mut share) = (BTreeMap::new(), 0.0);
    for channel in 0..layout.channels {
        let mean = of.iter().map(|(_, rms)| rms[channel]).sum::<f64>() / of.len() as f64;
        let own = |run: usize| layout.mean_square(&runs[run].mean, channel).sqrt();
        let size = of.iter().map(|(run, _)| own(*run)).sum::<f64>() / of.len() as f64;
        by_channel.insert(channel_name(layout, channel), mean);
        share += mean / size.max(f64::MIN_POSITIVE) / layout.channels as f64;
    }
    (by_channel, share)
}

impl Rival {
    /// Of a fitted structure.
    pub fn of(name: &str, runs: &[Observed], solved: &Solved) -> Result<Self, Error> {
        let (left_out_rms, left_out_share) = shares(runs, &solved.left_out()?);
        let mut held = Vec::new();
        for run in (0..runs.len()).filter(|run| runs[*run].held_out) {
            let predicted = solved.problem.model.predict(run, &solved.values)?;
            held.push((run, rms(&runs[run], &predicted)));
        }
        let (held_out_rms, share) = shares(runs, &held);
        Ok(Self {
            name: name.into(),
            chi_squared: solved.chi_squared,
            left_out_rms,
            left_out_share,
            held_out_share: (!held.is_empty()).then_some(share),
            held_out_rms,
            values: solved.values.clone(),
        })
    }
}

/// A candidate for the next run.
#[derive(Clone, Debug, Serialize)]
pub struct NextRun {
    /// Name.
    pub name: String,
    /// The parameter that is known worst.
    pub parameter: String,
    /// Its standard error now.
    pub error_now: f64,
    /// What it will be.
    pub error_then: f64,
    /// Standard errors of all parameters then.
    pub errors: Vec<f64>,
    /// Largest load on the cell of the cycle predicted, in parts of its range: above 1 the cell does not read it.
    pub load_share: f64,
}

impl NextRun {
    /// All candidates, those that the cell can read before the others, the best first, each with as many passes as the runs made had.
    pub(crate) fn all(candidates: &Structure, solved: &Solved, passes: usize) -> Result<Vec<Self>, Error> {
        let values = &solved.values;
        let template = &solved.problem.runs[solved.at.of[0]];
        let observed = candidates.model.targets.iter().map(|target| {
            let mean = target.predict(&candidates.model.numbers(values))?;
            let cycles = target.cycles() * passes;
            Ok(Observed {
                name: target.name.clone(),
                layout: target.layout(),
                weights: vec![1.0; cycles],
                cycles: vec![mean.clone(); cycles],
                mean,
                held_out: false,
                left_out: 0,
                ..template.clone()
            })
        });
        let observed = observed.collect::<Result<Vec<Observed>, Error>>()?;
        let noise = vec![solved.problem.noise[solved.at.of[0]].clone(); observed.len()];
        let parameters = solved.problem.parameters;
        let problem = Problem::with_noise(&candidates.model, &observed, parameters, noise)?;
        let ranked = rank(solved, &problem)?;
        let (worst, _) = largest(&solved.errors(), parameters);
        let of = |candidate: Candidate| {
            let (target, observed) = (&candidates.model.targets[candidate.index], &observed[candidate.index]);
            Self {
                name: observed.name.clone(),
                parameter: parameters[worst].name.clone(),
                error_now: solved.errors()[worst],
                error_then: candidate.errors[worst],
                errors: candidate.errors,
                load_share: target.load_share(&observed.mean),
            }
        };
        let mut all: Vec<Self> = ranked.into_iter().map(of).collect();
        all.sort_by_key(|run| run.load_share > 1.0);
        Ok(all)
    }
}
