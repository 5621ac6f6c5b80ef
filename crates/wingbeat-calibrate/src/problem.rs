//! What is fitted to what, and how its differences weigh.

use crate::observed::{SPARE, scatter};
use crate::{Error, HarmonicLayout, ObservedCycles, RigTarget, RunRole};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use wingbeat::parallel;

/// What predicts the cycles of runs.
pub trait CycleModel: Sync {
    /// Numbers of the cycle of run `run` in the units of its channels (N and N m), with the parameters at `values`, in theirs.
    ///
    /// # Errors
    /// A model without an answer.
    fn predict(&self, run: usize, values: &[f64]) -> Result<Vec<f64>, Error>;

    /// Refuses values, in the units of the parameters, that no robot has.
    ///
    /// # Errors
    /// The first of them.
    fn check(&self, _values: &[f64]) -> Result<(), Error> {
        Ok(())
    }

    /// Their derivatives by each parameter: units of the channels over that of the parameter.
    ///
    /// # Errors
    /// A model without an answer.
    fn slopes(&self, run: usize, values: &[f64]) -> Result<Vec<Vec<f64>>, Error>;

    /// That part of the cycle of run `run` of which the model's error is a share; without one all of what was measured.
    ///
    /// # Errors
    /// A model without an answer.
    fn in_doubt(&self, _run: usize, _values: &[f64]) -> Result<Option<Vec<f64>>, Error> {
        Ok(None)
    }

    /// The run on the rig that run `run` is, if it is one.
    fn target(&self, _run: usize) -> Option<&RigTarget> {
        None
    }
}

/// A number to be fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedParameter {
    /// Name.
    pub name: String,
    /// Where the fit begins, in its unit.
    pub start: f64,
    /// Lowest value, in its unit.
    pub low: f64,
    /// Highest value, in its unit.
    pub high: f64,
    /// Mean and standard deviation of what is known beforehand, in its unit.
    pub prior: Option<[f64; 2]>,
    /// Stage in which it joins.
    pub stage: usize,
}

impl FittedParameter {
    /// Its size, in its unit: that of its start, or of its prior, or of its range.
    pub fn scale(&self) -> f64 {
        let prior = self.prior.map_or(0.0, |[_, deviation]| deviation);
        let range = 0.1 * (self.high - self.low);
        match self.start.abs() {
            start if start > 1e-12 => start,
            _ if prior > 0.0 => prior,
            _ => range.min(1.0),
        }
    }
}

/// Differences of the runs' means from the model, in deviations, one vector per run.
pub type Whitened = Vec<DVector<f64>>;

/// Runs, parameters, and the covariance of what is left.
pub struct FitProblem<'a> {
    /// The model.
    pub model: &'a dyn CycleModel,
    /// All runs; those held out do not weigh.
    pub runs: &'a [ObservedCycles],
    /// What is fitted.
    pub parameters: &'a [FittedParameter],
    /// Lower Cholesky factors of the covariance of each run's mean.
    factors: Vec<Factor>,
    /// Covariance from cycle to cycle by harmonic, of each run, in the units of the channels, squared.
    pub noise: Vec<Vec<DMatrix<f64>>>,
    /// Cycles beyond the means they take of which the covariances of each run were told; infinite where they are known.
    pub freedom: Vec<f64>,
    /// What the model cannot say, in parts of the amplitude of each channel and harmonic of what is in doubt.
    pub discrepancy: Vec<f64>,
    /// What of each run is in doubt.
    in_doubt: Vec<Vec<f64>>,
}

/// Lower Cholesky factors of the covariance of a run's mean.
enum Factor {
    /// By harmonic, whose numbers are independent of the others'.
    Harmonics(Vec<DMatrix<f64>>),
    /// Of all numbers, which errors in common tie together.
    Whole(DMatrix<f64>),
}

/// Share of a cycle's amplitude that every harmonic counts at least, where the discrepancy is in parts of it. *Choice.*
const LEAST_AMPLITUDE: f64 = 0.1;

impl<'a> FitProblem<'a> {
    /// A problem whose noise is the scatter of the cycles, of one shape over the runs of one layout.
    ///
    /// # Errors
    /// Too few cycles to tell their scatter.
    pub fn new(
        model: &'a dyn CycleModel,
        runs: &'a [ObservedCycles],
        parameters: &'a [FittedParameter],
    ) -> Result<Self, Error> {
        let (mut noise, mut freedom) = (vec![Vec::new(); runs.len()], vec![0.0; runs.len()]);
        for (k, run) in runs.iter().enumerate() {
            if !noise[k].is_empty() {
                continue;
            }
            let same =
                |other: &ObservedCycles| (other.layout, &other.unmeasured) == (run.layout, &run.unmeasured);
            let alike: Vec<usize> = (0..runs.len()).filter(|other| same(&runs[*other])).collect();
            let of: Vec<&ObservedCycles> = alike.iter().map(|other| &runs[*other]).collect();
            let scatters = scatter(&of).ok_or_else(|| {
                let given: usize = of.iter().map(|run| run.cycles.len()).sum();
                let needed = of.len() + run.layout.channels - run.unmeasured.len() + SPARE;
                Error::data(
                    &run.name,
                    format!(
                        "{given} cycles in {} runs: at least {needed} are needed to tell their scatter; add passes",
                        of.len()
                    ),
                )
            })?;
            let together: f64 = of.iter().map(|run| run.freedom()).sum();
            alike.iter().for_each(|other| freedom[*other] = together);
            alike.into_iter().zip(scatters).for_each(|(other, own)| noise[other] = own);
        }
        Ok(Self { freedom, ..Self::with_noise(model, runs, parameters, noise)? })
    }

    /// A problem of which the covariance from cycle to cycle is known, by run and harmonic, in the units of the channels,
    /// squared.
    ///
    /// # Errors
    /// A covariance that is not positive definite.
    pub fn with_noise(
        model: &'a dyn CycleModel,
        runs: &'a [ObservedCycles],
        parameters: &'a [FittedParameter],
        noise: Vec<Vec<DMatrix<f64>>>,
    ) -> Result<Self, Error> {
        let channels = runs.first().map_or(0, |run| run.layout.channels);
        let discrepancy = vec![0.0; channels];
        let in_doubt = runs.iter().map(|run| run.mean.clone()).collect();
        let freedom = vec![f64::INFINITY; runs.len()];
        let mut problem =
            Self { model, runs, parameters, factors: Vec::new(), noise, freedom, discrepancy, in_doubt };
        problem.weigh(vec![0.0; channels])?;
        Ok(problem)
    }

    /// Sets the discrepancy, in parts of the amplitude, by channel.
    ///
    /// # Errors
    /// A covariance that is not positive definite.
    pub fn weigh(&mut self, discrepancy: Vec<f64>) -> Result<(), Error> {
        self.discrepancy = discrepancy;
        let factors = (0..self.runs.len()).map(|run| self.factors_of(run)).collect::<Result<_, _>>()?;
        self.factors = factors;
        Ok(())
    }

    /// Asks the model at `values` (in the units of the parameters) what of the runs is in doubt.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn doubt(&mut self, values: &[f64]) -> Result<(), Error> {
        let all: Vec<usize> = (0..self.runs.len()).collect();
        let asked = parallel::map(&all, |_, run| self.model.in_doubt(*run, values));
        for (own, asked) in self.in_doubt.iter_mut().zip(asked) {
            if let Some(cycle) = asked? {
                *own = cycle;
            }
        }
        Ok(())
    }

    /// Covariances of the mean of run `run` by harmonic, of scatter and discrepancy.
    fn covariances_of(&self, run: usize) -> Vec<DMatrix<f64>> {
        let observed = &self.runs[run];
        let count = observed.effective().max(1.0);
        let squares = self.amplitudes(run);
        let one = |k: usize| {
            let mut covariance = &self.noise[run][k] / count;
            for (channel, squares) in squares.iter().enumerate() {
                let of = self.working(observed.layout, channel);
                // A floor far below any cell's resolution keeps silent channels regular.
                covariance[(channel, channel)] += of * of * squares[k] + 1e-24;
            }
            covariance
        };
        (0..=observed.layout.harmonics).map(one).collect()
    }

    fn factors_of(&self, run: usize) -> Result<Factor, Error> {
        let observed = &self.runs[run];
        let layout = observed.layout;
        let covariances = self.covariances_of(run);
        let Some(common) = &observed.common.mean else {
            let one = |(k, covariance): (usize, DMatrix<f64>)| {
                let factor = covariance.cholesky().ok_or_else(|| {
                    Error::data(&observed.name, format!("channels that repeat each other in harmonic {k}"))
                })?;
                Ok(factor.l())
            };
            return Ok(Factor::Harmonics(
                covariances.into_iter().enumerate().map(one).collect::<Result<_, Error>>()?,
            ));
        };
        let mut whole = common.clone();
        for part in 0..layout.width() {
            for a in 0..layout.channels {
                for b in 0..layout.channels {
                    whole[(layout.at(a, part), layout.at(b, part))] +=
                        covariances[HarmonicLayout::harmonic(part)][(a, b)];
                }
            }
        }
        let factor =
            whole.cholesky().ok_or_else(|| Error::data(&observed.name, "channels that repeat each other"))?;
        Ok(Factor::Whole(factor.l()))
    }

    /// Covariance of the mean of run `run` in channel `channel` alone, in its unit, squared.
    pub fn covariance_of_channel(&self, run: usize, channel: usize) -> DMatrix<f64> {
        let (observed, covariances) = (&self.runs[run], self.covariances_of(run));
        let layout = observed.layout;
        DMatrix::from_fn(layout.width(), layout.width(), |p, q| {
            let (i, j) = (layout.at(channel, p), layout.at(channel, q));
            let own = if p == q { covariances[HarmonicLayout::harmonic(p)][(channel, channel)] } else { 0.0 };
            own + observed.common.mean.as_ref().map_or(0.0, |of| of[(i, j)])
        })
    }

    /// The discrepancy by which channel `channel` is weighed: the rms of those of its group. Were each channel weighed by its own,
    /// a fit would give up the large loads that it says badly for quiet channels that it says well.
    fn working(&self, layout: HarmonicLayout, channel: usize) -> f64 {
        let group = group(layout, channel);
        let squares = group.clone().map(|of| self.discrepancy.get(of).copied().unwrap_or(0.0).powi(2));
        (squares.sum::<f64>() / group.len() as f64).sqrt()
    }

    /// Square by channel and harmonic of which the discrepancy of run `run` is a part: that of the amplitude of the harmonic of
    /// what is in doubt and a share of the whole cycle's. Of six channels each force is held against the whole force and each moment against the whole
    /// moment: loads that are wrong in size or direction are wrong in proportion to them.
    pub fn amplitudes(&self, run: usize) -> Vec<Vec<f64>> {
        let (cycle, layout) = (self.in_doubt[run].as_slice(), self.runs[run].layout);
        let of = |channel: usize| {
            let group = group(layout, channel);
            let own: f64 = group.clone().map(|channel| layout.mean_square(cycle, channel)).sum();
            let square = |k: usize| {
                let amplitude = |channel: usize| {
                    if k == 0 {
                        return cycle[layout.at(channel, 0)].powi(2);
                    }
                    let (cosine, sine) = (layout.at(channel, 2 * k - 1), layout.at(channel, 2 * k));
                    0.5 * (cycle[cosine].powi(2) + cycle[sine].powi(2))
                };
                group.clone().map(amplitude).sum::<f64>() + LEAST_AMPLITUDE * LEAST_AMPLITUDE * own
            };
            (0..=layout.harmonics).map(square).collect()
        };
        (0..layout.channels).map(of).collect()
    }

    /// Root mean square over the cycle of what of run `run` is in doubt, by channel and in its unit: the whole force's, the
    /// whole moment's.
    pub fn load(&self, run: usize) -> Vec<f64> {
        let (cycle, layout) = (self.in_doubt[run].as_slice(), self.runs[run].layout);
        let of =
            |channel| group(layout, channel).map(|own| layout.mean_square(cycle, own)).sum::<f64>().sqrt();
        (0..layout.channels).map(of).collect()
    }

    /// Runs that are fitted.
    pub fn fitted(&self) -> Vec<usize> {
        (0..self.runs.len()).filter(|run| self.runs[*run].role == RunRole::Fitted).collect()
    }

    /// What the model says of the runs `of`, in the units of the channels, with these values, if a robot can have them.
    ///
    /// # Errors
    /// Values that no robot has; a model without an answer.
    pub fn possible(&self, of: &[usize], values: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
        self.model.check(values)?;
        self.predictions(of, values)
    }

    /// What the model says of the runs `of`, in the units of the channels, with these values.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn predictions(&self, of: &[usize], values: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
        parallel::map(of, |_, run| self.model.predict(*run, values)).into_iter().collect()
    }

    /// Derivatives of what the model says of the runs `of` by the parameters, in the units of the channels over those of the
    /// parameters: one column each.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn jacobians(&self, of: &[usize], values: &[f64]) -> Result<Vec<DMatrix<f64>>, Error> {
        let one = |run: &usize| {
            let slopes = self.model.slopes(*run, values)?;
            let rows = self.runs[*run].layout.len();
            Ok(DMatrix::from_fn(rows, slopes.len(), |i, j| slopes[j][i]))
        };
        parallel::map(of, |_, run| one(run)).into_iter().collect()
    }

    /// `cycle`, numbers of run `run`, in deviations; none of channels that were not measured.
    pub fn whiten(&self, run: usize, cycle: &[f64]) -> DVector<f64> {
        let observed = &self.runs[run];
        let layout = observed.layout;
        let mut own = DVector::from_row_slice(cycle);
        for channel in &observed.unmeasured {
            (0..layout.width()).for_each(|part| own[layout.at(*channel, part)] = 0.0);
        }
        match &self.factors[run] {
            Factor::Whole(factor) => factor.solve_lower_triangular(&own).unwrap_or(own),
            Factor::Harmonics(factors) => {
                by_part(layout, &own, |k, own| factors[k].solve_lower_triangular(&own).unwrap_or(own))
            }
        }
    }

    /// The inverse of [`whiten`](Self::whiten).
    pub fn coloured(&self, run: usize, white: &DVector<f64>) -> Vec<f64> {
        let coloured = match &self.factors[run] {
            Factor::Whole(factor) => factor * white,
            Factor::Harmonics(factors) => by_part(self.runs[run].layout, white, |k, own| &factors[k] * own),
        };
        coloured.iter().copied().collect()
    }

    /// The columns of a Jacobian in deviations.
    pub fn whiten_columns(&self, run: usize, jacobian: &DMatrix<f64>) -> DMatrix<f64> {
        let columns: Vec<DVector<f64>> =
            jacobian.column_iter().map(|column| self.whiten(run, column.as_slice())).collect();
        DMatrix::from_columns(&columns)
    }

    /// Model less measurement of the runs `of`, in deviations.
    pub fn residuals(&self, of: &[usize], predictions: &[Vec<f64>]) -> Whitened {
        let one = |(run, predicted): (&usize, &Vec<f64>)| {
            let apart: Vec<f64> =
                predicted.iter().zip(&self.runs[*run].mean).map(|(model, mean)| model - mean).collect();
            self.whiten(*run, &apart)
        };
        of.iter().zip(predictions).map(one).collect()
    }

    /// Sum of squares, dimensionless, of the residuals and of the priors' differences.
    pub fn cost(&self, residuals: &Whitened, values: &[f64]) -> f64 {
        residuals.iter().map(DVector::norm_squared).sum::<f64>() + priors(self.parameters, values)
    }
}

/// What `f` makes of the channels of every part of a cycle; it is told the part's harmonic.
fn by_part(
    layout: HarmonicLayout,
    cycle: &DVector<f64>,
    f: impl Fn(usize, DVector<f64>) -> DVector<f64>,
) -> DVector<f64> {
    let mut made = DVector::zeros(layout.len());
    for part in 0..layout.width() {
        let own = DVector::from_fn(layout.channels, |channel, _| cycle[layout.at(channel, part)]);
        let own = f(HarmonicLayout::harmonic(part), own);
        (0..layout.channels).for_each(|channel| made[layout.at(channel, part)] = own[channel]);
    }
    made
}

/// The channels that are one vector with channel `channel`: the forces or the moments of six.
pub fn group(layout: HarmonicLayout, channel: usize) -> Range<usize> {
    match (layout.channels, channel) {
        (6, 0..3) => 0..3,
        (6, _) => 3..6,
        _ => channel..channel + 1,
    }
}

/// Sum of squares, dimensionless, of the differences from the priors.
pub fn priors(parameters: &[FittedParameter], values: &[f64]) -> f64 {
    let prior = |(parameter, value): (&FittedParameter, &f64)| {
        parameter.prior.map_or(0.0, |[mean, deviation]| ((value - mean) / deviation).powi(2))
    };
    parameters.iter().zip(values).map(prior).sum()
}
