//! What the measured loads of a case say of themselves and beside the model, before they are fitted.

use crate::tethered::LOADS;
use crate::{
    CaseTarget, Error, FitProblem, HarmonicLayout, ModelStructure, ObservedCycles, PHASES, phase_of,
};
use nalgebra::DVector;
use wingbeat::judge::data::{
    CyclePair, Finding, MeasuredChannel, Purpose, Series, compared, examined, reversed_among,
};
use wingbeat::judge::limits::data::GAIN;
use wingbeat::judge::{RunLimits, Warning};
use wingbeat::rig::cell::CHANNELS;
use wingbeat::scenario::mended_in_compare;

/// What is wrong with the samples of one file at `phase` (cycles): `of` are the channels that it has.
pub fn findings(
    target: &CaseTarget,
    file: &str,
    phase: &[f64],
    (of, channels): (&[usize], &[Vec<f64>; 6]),
) -> Vec<Finding> {
    let channel =
        |i: &usize| MeasuredChannel { name: LOADS[*i], unit: CHANNELS[*i].1, samples: &channels[*i] };
    let series = Series {
        what: file,
        phase,
        frequency_hz: Some(target.case.measured_frequency()),
        channels: of.iter().map(channel).collect(),
        purpose: Purpose::Datum,
    };
    examined(&series, &target.case.limits).into_iter().map(mended_in_compare).collect()
}

/// Which of the channels `of` of one of the `passes`, each by its file and the harmonics of its mean cycle, is that of most others reversed.
/// Small ones, which may be noise, are left out. Harmonics are in the units of the channels.
pub fn beside_other_passes(target: &CaseTarget, of: &[usize], passes: &[(&str, Vec<f64>)]) -> Vec<Finding> {
    let layout = target.layout();
    let of_channel =
        |c: usize| passes.iter().map(|(file, mean)| (*file, values(layout, mean, c))).collect::<Vec<_>>();
    let all: Vec<_> = of.iter().map(|c| (*c, of_channel(*c))).collect();
    let range = |of: &[(&str, Vec<f64>)]| {
        let one = |of: &[f64]| {
            of.iter().copied().fold(f64::MIN, f64::max) - of.iter().copied().fold(f64::MAX, f64::min)
        };
        of.iter().map(|(_, cycle)| one(cycle)).fold(0.0, f64::max)
    };
    let most = |unit: &str| {
        let same = all.iter().filter(|(c, _)| CHANNELS[*c].1 == unit);
        same.map(|(_, of)| range(of)).fold(0.0, f64::max)
    };
    let telling = all.iter().filter(|(c, of)| range(of) > LARGE * most(CHANNELS[*c].1));
    let found = telling.flat_map(|(c, of)| reversed_among(LOADS[*c], of, &target.case.limits));
    found.map(mended_in_compare).collect()
}

/// Part of the largest range of its unit from which a channel is compared between passes. *Choice.*
const LARGE: f64 = 0.2;

/// What of the mean cycle of `run` cannot be the one that the model predicts.
fn beside(run: &ObservedCycles, predicted: &[f64], limits: &RunLimits) -> Vec<Finding> {
    let layout = run.layout;
    let cycles: Vec<[Vec<f64>; 2]> = (0..layout.channels)
        .map(|c| [run.mean.as_slice(), predicted].map(|of| values(layout, of, c)))
        .collect();
    let pairs: Vec<CyclePair> = (0..layout.channels)
        .filter(|channel| run.is_measured(*channel))
        .map(|c| CyclePair {
            name: LOADS[c],
            unit: CHANNELS[c].1,
            measured: &cycles[c][0],
            computed: &cycles[c][1],
        })
        .collect();
    compared(&run.name, &pairs, limits).into_iter().map(mended_in_compare).collect()
}

/// The runs as what they tell is reckoned from: channels that are dead or were stuck count as not measured, as the noise of what does not
/// move promises what no channel tells. None where all channels move.
///
/// # Errors
/// A case of which no channel moves.
pub fn telling(
    structure: &ModelStructure,
    runs: &[ObservedCycles],
    found: &[Vec<Finding>],
) -> Result<Option<Vec<ObservedCycles>>, Error> {
    let first = structure.model.targets.len();
    let mut telling = runs.to_vec();
    for (run, found) in telling[first..].iter_mut().zip(found) {
        for finding in found.iter().filter(|finding| finding.is_silence()) {
            let silent = |i: &usize| finding.channel.is_empty() || finding.channel == LOADS[*i];
            let silent: Vec<usize> = (0..LOADS.len()).filter(|i| silent(i) && run.is_measured(*i)).collect();
            run.unmeasured.extend(silent);
            if run.unmeasured.len() == LOADS.len() {
                let first = found.first().unwrap_or(finding);
                return Err(Error::data(&run.name, first.words()));
            }
        }
        run.unmeasured.sort_unstable();
    }
    let changed = telling.iter().zip(runs).any(|(own, run)| own.unmeasured != run.unmeasured);
    Ok(changed.then_some(telling))
}

/// Standard errors of a gain within which it says nothing: of noise one of 370 lies beyond.
const BELIEVED: f64 = 3.0;

/// What the runs say of the gain of the cell at `values`, in the units of the parameters: those that weigh the robot at rest in
/// several attitudes are held against its weight. Where none does so well enough, a gain that is wrong looks like a slope or a
/// density that is wrong, and the warning says so.
///
/// # Errors
/// A model without an answer.
pub fn gains(
    structure: &ModelStructure,
    problem: &FitProblem,
    values: &[f64],
    limits: &RunLimits,
) -> Result<(Vec<Finding>, Option<Warning>), Error> {
    let model = &structure.model;
    let fitted = structure.parameters.iter().find(|p| p.name.ends_with("mass_kg") && p.prior.is_none());
    let (mut found, mut weighed, allowed) = (Vec::new(), false, limits.of(&GAIN).0);
    for (k, target) in model.targets.iter().enumerate().filter(|(_, target)| target.tilts().is_some()) {
        let predicted = target.predict(&model.numbers(values))?;
        let Some([gain, error]) = weighing(problem, k, &predicted) else { continue };
        weighed |= BELIEVED * error < allowed;
        let (name, size) = (&problem.runs[k].name, (gain - 1.0).abs());
        let text = format!(
            "weighs the robot as {gain:.3} +- {error:.3} times its weight in the model: the gain of the cell or the mass is \
             wrong"
        );
        let told = size > allowed && size > BELIEVED * error;
        found.extend(told.then(|| Finding::scaled(name, size, text)));
    }
    let why = match fitted {
        Some(mass) => format!("{} is fitted without a prior, and takes a wrong gain up", mass.name),
        None if weighed => return Ok((found, None)),
        None if model.targets.is_empty() => "no case weighs its wing at rest".to_owned(),
        None => {
            "no run weighs the robot at rest in several attitudes (hold.tilts_deg) well enough".to_owned()
        }
    };
    let text = format!(
        "the gain of the cell is not checked: {why}; a gain that is 15 % too large looks like a slope that is 15 % too large. Hang a \
         known mass on the cell"
    );
    Ok((found, Some(Warning::new("calibration.gain_unchecked", text))))
}

/// The factor on the forces `predicted` of run `run` that is nearest to those measured, and its standard error, by generalised least
/// squares within each channel; none where no weight turns.
fn weighing(problem: &FitProblem, run: usize, predicted: &[f64]) -> Option<[f64; 2]> {
    let observed = &problem.runs[run];
    let layout = observed.layout;
    let (mut both, mut own) = (0.0, 0.0);
    for channel in 0..3 {
        let of = |cycle: &[f64]| DVector::from_fn(layout.width(), |part, _| cycle[layout.at(channel, part)]);
        let (weight, measured) = (of(predicted), of(&observed.mean));
        let solved = problem.covariance_of_channel(run, channel).cholesky()?.solve(&weight);
        both += solved.dot(&measured);
        own += solved.dot(&weight);
    }
    (own > 0.0).then(|| [both / own, own.sqrt().recip()])
}

/// What is wrong with each of the cases of `structure`: what their samples say, and their cycles beside those predicted with
/// `values`, in the units of the parameters.
///
/// # Errors
/// A model without an answer.
pub fn suspected(
    structure: &ModelStructure,
    runs: &[ObservedCycles],
    values: &[f64],
) -> Result<Vec<Vec<Finding>>, Error> {
    let model = &structure.model;
    let of = |(case, run): (&CaseTarget, &ObservedCycles)| {
        let predicted = case.predict(&model.numbers(values))?;
        let beside = beside(run, &predicted, &case.case.limits);
        Ok(run.found.iter().cloned().chain(beside).collect())
    };
    model.cases.iter().zip(&runs[model.targets.len()..]).map(of).collect()
}

/// Share of strips and time past what their law holds for from which it is the law that may shift the loads. *Choice*: below it the
/// loads of the others tell the clock.
const PAST_LAW: f64 = 0.1;
/// Lag that a law makes at most where it does not hold, deg. *Choice*: a stall by a cosine of 25 to 40 deg lags 20 to 27 deg behind attached
/// flow (`aero.law`).
const LAW_LAGS: f64 = 30.0;

/// The findings of each case as a fit with `values`, in the units of the parameters, tells them: a shift of phase is a warning where the model
/// is past what its law holds for, as then the model may be wrong, which the misfit says.
///
/// # Errors
/// A model without an answer.
pub fn of_fit(
    structure: &ModelStructure,
    found: &[Vec<Finding>],
    values: &[f64],
) -> Result<Vec<Vec<Finding>>, Error> {
    let numbers = structure.model.numbers(values);
    let of = |(case, found): (&CaseTarget, &Vec<Finding>)| {
        found.iter().map(|finding| by_law(case, finding.clone(), &numbers)).collect()
    };
    structure.model.cases.iter().zip(found).map(of).collect()
}

fn by_law(case: &CaseTarget, finding: Finding, to: &[(&str, f64)]) -> Result<Finding, Error> {
    if finding.id != "data.shift" || !finding.serious || finding.size > LAW_LAGS {
        return Ok(finding);
    }
    Ok(match case.past_law(to)?.filter(|(_, share)| *share > PAST_LAW) {
        None => finding,
        Some((law, share)) => {
            let text = format!(
                "{}; {:.0} % of strips and time are past what law `{law}` holds for, and a wrong law shifts the loads as well: take one that holds \
                 there (aero.law) before the time is mended",
                finding.text,
                100.0 * share
            );
            let mut noted = finding.noted();
            noted.text = text;
            noted
        }
    })
}

fn values(layout: HarmonicLayout, cycle: &[f64], channel: usize) -> Vec<f64> {
    (0..PHASES).map(|k| layout.value(cycle, channel, phase_of(k))).collect()
}
