//! A calibration from runs to what is known.

use crate::fit::{Fit, FitWatch, Keep, LinearisedRuns, fit, step};
use crate::problem::FitProblem;
use crate::uncertainty::{Covariances, Profile, covariances, inverse, profiles};
use crate::{CycleModel, Error, FittedParameter, HarmonicLayout, ObservedCycles};
use nalgebra::DMatrix;
use wingbeat::math::Random;

/// Rounds in which what the model cannot say is estimated and the fit is made again. *Choice.*
const ROUNDS: usize = 3;
/// Deviations of chi squared over its freedom beyond which the model is called wrong. *Choice.*
const WRONG: f64 = 4.0;
/// Load that counts as none, N and N m: below any cell's resolution.
const LEAST_LOAD: f64 = 1e-6;
/// Part of what cycles tell of their phase that must be left beside the parameters for it to be told. *Choice.*
const TAKEN: f64 = 1e-4;
/// Phases at which cycles are drawn and bands are held against measurements.
pub const PHASES: usize = 200;

/// What to do.
#[derive(Clone, Debug)]
pub struct FitPlan {
    /// Number of starts.
    pub starts: usize,
    /// Share by which starts differ.
    pub spread: f64,
    /// Seed of the starts.
    pub seed: u64,
    /// Whether to estimate what the model cannot say.
    pub discrepancy: bool,
}

/// A start and where it led.
#[derive(Clone, Debug)]
pub struct FitStart {
    /// Values it began with, in the units of the parameters.
    pub from: Vec<f64>,
    /// Where it ended; none where the model had no answer.
    pub fit: Option<Fit>,
}

/// What a calibration found.
pub struct SolvedCalibration<'a> {
    /// Runs, parameters and weights.
    pub problem: FitProblem<'a>,
    /// Values, in the units of the parameters.
    pub values: Vec<f64>,
    /// The starts.
    pub starts: Vec<FitStart>,
    /// Sum of squares over freedom, a ratio, with the noise of the cycles alone.
    pub chi_squared: f64,
    /// Residuals and Jacobian at the values, of the fitted runs.
    pub at: LinearisedRuns,
    /// Covariances.
    pub covariances: Covariances,
}

/// The starts of a fit, in the units of the parameters: that of the parameters, then others drawn evenly within `spread` of it.
pub fn starts(parameters: &[FittedParameter], plan: &FitPlan) -> Vec<Vec<f64>> {
    let mut random = Random::stream(plan.seed, u64::from(u32::MAX));
    let first: Vec<f64> = parameters.iter().map(|parameter| parameter.start).collect();
    let other = |_| {
        let drawn = |parameter: &FittedParameter| {
            let by = random.between(-plan.spread, plan.spread);
            (parameter.start + by * parameter.scale()).clamp(parameter.low, parameter.high)
        };
        parameters.iter().map(drawn).collect()
    };
    let others: Vec<Vec<f64>> = (1..plan.starts).map(other).collect();
    std::iter::once(first).chain(others).collect()
}

/// Fits the parameters to the runs that are not held out.
///
/// # Errors
/// A model without an answer at every start; [`Error::Stopped`].
pub fn solve<'a>(
    model: &'a dyn CycleModel,
    runs: &'a [ObservedCycles],
    parameters: &'a [FittedParameter],
    plan: &FitPlan,
    keep: &mut dyn Keep,
    watch: &mut FitWatch,
) -> Result<SolvedCalibration<'a>, Error> {
    let problem = FitProblem::new(model, runs, parameters)?;
    solve_problem(problem, plan, keep, watch)
}

/// The same of a problem whose noise is known.
///
/// # Errors
/// Those of [`solve`].
pub fn solve_problem<'a>(
    mut problem: FitProblem<'a>,
    plan: &FitPlan,
    keep: &mut dyn Keep,
    watch: &mut FitWatch,
) -> Result<SolvedCalibration<'a>, Error> {
    let parameters = problem.parameters;
    let mut made = Vec::new();
    let mut best: Option<Fit> = None;
    let mut last = None;
    for (number, from) in starts(parameters, plan).into_iter().enumerate() {
        let made_before = keep.kept(number).filter(|kept| kept.values.len() == from.len());
        let found = match made_before.map_or_else(|| fit(&problem, &from, number, best.as_ref(), watch), Ok) {
            Ok(found) => {
                keep.keep(number, &found);
                Some(found)
            }
            Err(Error::Stopped) => return Err(Error::Stopped),
            Err(error) => {
                last = Some(error);
                None
            }
        };
        if let Some(found) = &found
            && best.as_ref().is_none_or(|best| found.cost < best.cost)
        {
            best = Some(found.clone());
        }
        made.push(FitStart { from, fit: found });
    }
    let Some(best) = best else {
        return Err(last.unwrap_or_else(|| Error::Uninformed("no start".into())));
    };
    let mut values = best.values;
    let of = problem.fitted();
    let freedom = freedom(&problem, &of);
    let mut at = LinearisedRuns::at(&problem, &of, &values)?;
    let chi_squared = problem.cost(&at.residuals, &values) / freedom;
    if plan.discrepancy && chi_squared > 1.0 + WRONG * (2.0 / freedom).sqrt() {
        for _ in 0..ROUNDS {
            problem.doubt(&values)?;
            let discrepancy = unsaid(&problem, &values)?;
            problem.weigh(discrepancy)?;
            values = fit(&problem, &values, made.len(), None, watch)?.values;
        }
        at = LinearisedRuns::at(&problem, &of, &values)?;
    }
    let covariances = covariances(&problem, &at, &values);
    Ok(SolvedCalibration { problem, values, starts: made, chi_squared, at, covariances })
}

/// Numbers measured less parameters fitted.
fn freedom(problem: &FitProblem, of: &[usize]) -> f64 {
    let measured = |run: &usize| {
        let (layout, left) = (problem.runs[*run].layout, problem.runs[*run].unmeasured.len());
        (layout.channels - left) * layout.width()
    };
    let numbers: usize = of.iter().map(measured).sum();
    (numbers as f64 - problem.parameters.len() as f64).max(1.0)
}

/// What the model does not say, in parts of the amplitude of each channel: the mean square of the residuals beyond the
/// noise over that of the amplitudes, for the parameters corrected as if all runs had one and the same error.
///
/// Equation: calibrate.discrepancy
/// `delta^2 = sum (residual^2 - noise) / sum amplitude^2 per channel, n/(n - p)`
/// Source: moments; form a choice.
/// Test: `a_model_that_is_wrong_is_told_by_how_much`.
fn unsaid(problem: &FitProblem, values: &[f64]) -> Result<Vec<f64>, Error> {
    let of = problem.fitted();
    let predictions = problem.predictions(&of, values)?;
    let channels = problem.runs[of[0]].layout.channels;
    let numbers = of.iter().map(|run| problem.runs[*run].layout.len()).max().unwrap_or(1) as f64;
    let correction = numbers / (numbers - problem.parameters.len() as f64).max(1.0);
    let channel = |channel: usize| {
        let (mut beyond, mut size) = (0.0, 0.0);
        for (run, predicted) in of.iter().zip(&predictions) {
            let observed = &problem.runs[*run];
            let (layout, squares) = (observed.layout, problem.amplitudes(*run));
            // Where nothing is in doubt, as in still air without motion, nothing is left unsaid.
            let in_doubt = problem.load(*run).iter().any(|load| *load > LEAST_LOAD);
            if !in_doubt || !observed.is_measured(channel) {
                continue;
            }
            for part in 0..layout.width() {
                let (i, k) = (layout.at(channel, part), HarmonicLayout::harmonic(part));
                let scatter = problem.noise[*run][k][(channel, channel)] / observed.effective();
                let noise = scatter + observed.tare_variance(i);
                beyond += HarmonicLayout::share(part) * ((predicted[i] - observed.mean[i]).powi(2) - noise);
                size += HarmonicLayout::share(part) * squares[channel][k];
            }
        }
        (correction * beyond.max(0.0) / size.max(f64::MIN_POSITIVE)).sqrt()
    };
    Ok((0..channels).map(channel).collect())
}

impl SolvedCalibration<'_> {
    /// Standard errors with cycles as clusters, in the units of the parameters.
    pub fn errors(&self) -> Vec<f64> {
        (0..self.values.len()).map(|k| self.covariances.clustered[(k, k)].max(0.0).sqrt()).collect()
    }

    /// Standard errors as if all samples were independent, in the units of the parameters.
    pub fn white_errors(&self) -> Vec<f64> {
        (0..self.values.len()).map(|k| self.covariances.white[(k, k)].max(0.0).sqrt()).collect()
    }

    /// The profiles of all parameters.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn profiles(&self) -> Result<Vec<Profile>, Error> {
        profiles(&self.problem, &self.at, &self.values, &self.errors())
    }

    /// The values without run `run`, in the units of the parameters: two Gauss-Newton steps from the fit, on its Jacobian and
    /// the model's own residuals.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn without(&self, run: usize) -> Result<Vec<f64>, Error> {
        let free: Vec<usize> = (0..self.values.len()).collect();
        let parameters = self.problem.parameters;
        let normal = self.at.normal(parameters, &self.values, &[run]);
        let once = step(&normal, 0.0, parameters, &self.values, &free);
        let predictions = self.problem.predictions(&self.at.of, &once)?;
        let residuals = self.problem.residuals(&self.at.of, &predictions);
        let moved = LinearisedRuns { residuals, ..self.at.clone() };
        let normal = moved.normal(parameters, &once, &[run]);
        Ok(step(&normal, 0.0, parameters, &once, &free))
    }

    /// By how much the cycles measured in run `run` are behind the model's, and its standard error, rad, were it fitted beside the parameters:
    /// what the residuals say of it once the parameters have taken what they can. None of a run that was not fitted, has no cycle, or of which
    /// the parameters tell the phase.
    ///
    /// Equation: calibrate.left_shift
    /// `D'C^-1 r / I, I = D'C^-1 D - D'C^-1 J B^-1 J'C^-1 D, D the slope of the cycle over its phase, r what is left; error I^(-1/2)`
    /// Source: score test, Rao 1948, Proc. Camb. Phil. Soc. 44.
    /// Test: `a_late_clock_is_told_beside_the_parameters`.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn left_shift(&self, run: usize) -> Result<Option<[f64; 2]>, Error> {
        let observed = &self.problem.runs[run];
        let Some(at) = self.at.of.iter().position(|of| *of == run).filter(|_| observed.frequency_hz > 0.0)
        else {
            return Ok(None);
        };
        let layout = observed.layout;
        let cycle = self.problem.model.predict(run, &self.values)?;
        let mut slope = vec![0.0; layout.len()];
        for (channel, k) in (0..layout.channels).flat_map(|c| (1..=layout.harmonics).map(move |k| (c, k))) {
            let [cosine, sine] = [2 * k - 1, 2 * k].map(|part| layout.at(channel, part));
            slope[cosine] = -(k as f64) * cycle[sine];
            slope[sine] = k as f64 * cycle[cosine];
        }
        let slope = self.problem.whiten(run, &slope);
        let told = self.at.jacobians[at].transpose() * &slope;
        let normal = self.at.normal(self.problem.parameters, &self.values, &[]).0;
        let own = slope.norm_squared();
        let information = own - told.dot(&(inverse(&normal) * &told));
        let known = information > TAKEN * own;
        Ok(known.then(|| [-slope.dot(&self.at.residuals[at]) / information, information.sqrt().recip()]))
    }

    /// Rms by channel, in its unit, of every fitted run that is left out, predicted from the others.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn left_out(&self) -> Result<Vec<(usize, Vec<f64>)>, Error> {
        if self.at.of.len() < 2 {
            return Ok(Vec::new());
        }
        let one = |run: &usize| {
            let values = self.without(*run)?;
            let predicted = self.problem.model.predict(*run, &values)?;
            Ok((*run, rms(&self.problem.runs[*run], &predicted)))
        };
        self.at.of.iter().map(one).collect()
    }

    /// Correlations of the estimates.
    pub fn correlations(&self) -> DMatrix<f64> {
        crate::uncertainty::correlations(&self.covariances.clustered)
    }

    /// Covariance of the estimates from noise alone, in the units of the parameters, squared: the inverse of the information.
    pub fn information_covariance(&self) -> DMatrix<f64> {
        inverse(&self.at.normal(self.problem.parameters, &self.values, &[]).0)
    }
}

/// Phase number `k` of those of a cycle, rad.
pub fn phase_of(k: usize) -> f64 {
    std::f64::consts::TAU * k as f64 / PHASES as f64
}

/// Root mean square over the cycle of what is predicted less what was measured, by channel, in its unit; NaN of one that was
/// not measured.
pub fn rms(observed: &ObservedCycles, predicted: &[f64]) -> Vec<f64> {
    let apart: Vec<f64> = predicted.iter().zip(&observed.mean).map(|(model, mean)| model - mean).collect();
    let one = |channel: usize| match observed.is_measured(channel) {
        true => observed.layout.mean_square(&apart, channel).sqrt(),
        false => f64::NAN,
    };
    (0..observed.layout.channels).map(one).collect()
}
