//! What is told of fits, held against many fits of a model that is linear.

use nalgebra::DMatrix;
use std::ops::ControlFlow;
use wingbeat::math::Random;
use wingbeat_calibrate::design::rank;
use wingbeat_calibrate::{
    CycleModel, Error, FitPlan, FitProblem, FitProgress, FittedParameter, HarmonicLayout, Information, Label,
    LinearisedRuns, ObservedCycles, RunRole, SolvedCalibration, solve,
};

const LAYOUT: HarmonicLayout = HarmonicLayout { channels: 2, harmonics: 3 };
const PLAN: FitPlan = FitPlan { starts: 1, spread: 0.0, seed: 0, discrepancy: true };

/// Cycles that are sums of the values times vectors, one list of vectors per run.
struct Sums(Vec<Vec<Vec<f64>>>);

impl Sums {
    fn new(runs: usize, parameters: usize, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let mut vector = || (0..LAYOUT.len()).map(|_| random.normal()).collect::<Vec<f64>>();
        Self((0..runs).map(|_| (0..parameters).map(|_| vector()).collect()).collect())
    }
}

impl CycleModel for Sums {
    fn predict(&self, run: usize, values: &[f64]) -> Result<Vec<f64>, Error> {
        let part = |i: usize| values.iter().zip(&self.0[run]).map(|(value, of)| value * of[i]).sum();
        Ok((0..LAYOUT.len()).map(part).collect())
    }
    fn slopes(&self, run: usize, _: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
        Ok(self.0[run].clone())
    }
}

fn parameters(count: usize) -> Vec<FittedParameter> {
    let one = |k: usize| FittedParameter {
        name: format!("p{k}"),
        start: 1.0,
        low: -100.0,
        high: 100.0,
        prior: None,
        stage: 1,
    };
    (0..count).map(one).collect()
}

/// Twenty cycles of every run about `means`, whose numbers scatter together.
fn observed(means: &[Vec<f64>], noise: f64, seed: u64) -> Vec<ObservedCycles> {
    let mut random = Random::new(seed);
    let run = |(k, mean): (usize, &Vec<f64>)| {
        let mut cycle = || {
            let common = random.normal();
            mean.iter().map(|x| x + noise * (0.8 * common + 0.6 * random.normal())).collect::<Vec<f64>>()
        };
        let mut run = ObservedCycles {
            name: format!("run {k}"),
            layout: LAYOUT,
            cycles: (0..20).map(|_| cycle()).collect(),
            weights: Vec::new(),
            mean: Vec::new(),
            sample_noise: DMatrix::identity(2, 2) * noise * noise,
            samples_per_cycle: 1000.0,
            left_out: 0,
            oddities: Vec::new(),
            found: Vec::new(),
            frequency_hz: 3.5,
            role: RunRole::Fitted,
            unmeasured: Vec::new(),
            common: Default::default(),
        };
        run.weigh(false);
        run
    };
    means.iter().enumerate().map(run).collect()
}

fn solved<'a>(
    model: &'a Sums,
    runs: &'a [ObservedCycles],
    parameters: &'a [FittedParameter],
) -> SolvedCalibration<'a> {
    let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
    solve(model, runs, parameters, &PLAN, &mut (), watch).unwrap()
}

fn means(model: &Sums, values: &[f64]) -> Vec<Vec<f64>> {
    (0..model.0.len()).map(|run| model.predict(run, values).unwrap()).collect()
}

#[test]
fn clustered_errors_are_those_of_many_fits() {
    let (model, parameters) = (Sums::new(3, 2, 5), parameters(2));
    let means = means(&model, &[2.0, -1.0]);
    let (mut values, mut errors, mut white) = (Vec::new(), 0.0, 0.0);
    for seed in 0..200 {
        let runs = observed(&means, 0.1, 100 + seed);
        let solved = solved(&model, &runs, &parameters);
        assert!(solved.problem.discrepancy.iter().all(|share| *share < 0.05), "the model is right");
        values.push(solved.values[0]);
        errors += solved.errors()[0] / 200.0;
        white += solved.white_errors()[0] / 200.0;
    }
    let mean = values.iter().sum::<f64>() / 200.0;
    let scatter = (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 199.0).sqrt();
    // 200 fits tell a deviation to 5 %.
    assert!((errors / scatter - 1.0).abs() < 0.15, "{errors} against {scatter}");
    assert!((mean - 2.0).abs() < 4.0 * scatter / 200.0_f64.sqrt());
    assert!(white < 0.2 * errors, "samples that are taken for independent");
}

#[test]
fn a_model_that_is_wrong_is_told_by_how_much() {
    let (model, parameters) = (Sums::new(4, 2, 6), parameters(2));
    let mut means = means(&model, &[2.0, -1.0]);
    let mut random = Random::new(9);
    let wrong: Vec<f64> = (0..LAYOUT.len()).map(|_| 0.3 * random.normal()).collect();
    let mut share = 0.0;
    for mean in &mut means {
        let amplitude = |mean: &[f64]| LAYOUT.mean_square(mean, 0).sqrt();
        let size = amplitude(mean);
        mean.iter_mut().zip(&wrong).for_each(|(x, wrong)| *x += wrong);
        share += LAYOUT.mean_square(&wrong, 0).sqrt() / size / 4.0;
    }
    let runs = observed(&means, 0.001, 1);
    let solved = solved(&model, &runs, &parameters);
    assert!(solved.chi_squared > 100.0);
    let told = solved.problem.discrepancy[0];
    assert!((0.5..2.0).contains(&(told / share)), "{told} against {share}");
    let off = (solved.values[0] - 2.0).abs();
    assert!(off < 3.0 * solved.errors()[0] && solved.errors()[0] > 10.0 * solved.white_errors()[0]);
}

#[test]
fn bands_hold_a_run_unlike_those_fitted() {
    // Five runs alike, the last with loads half as large again, and an error of the model that all have: in the first half of the
    // stroke only.
    let mut model = Sums::new(1, 2, 6);
    let alike = model.0[0].clone();
    let larger = alike.iter().map(|vector| vector.iter().map(|x| 1.5 * x).collect()).collect();
    model.0 = vec![alike.clone(), alike.clone(), alike.clone(), alike, larger];
    let parameters = parameters(2);
    let mut means = means(&model, &[2.0, -1.0]);
    let mut random = Random::new(9);
    let wrong: Vec<f64> = (0..LAYOUT.len()).map(|_| 0.3 * random.normal()).collect();
    for (k, mean) in means.iter_mut().enumerate() {
        let grown = if k == 4 { 1.5_f64.sqrt() } else { 1.0 };
        mean.iter_mut().zip(&wrong).for_each(|(x, wrong)| *x += grown * wrong);
    }
    let mut runs = observed(&means, 0.001, 1);
    runs[4].role = RunRole::HeldOut;
    let solved = solved(&model, &runs, &parameters);
    let predicted = solved.predicted(4).unwrap();
    let (covered, half) = (predicted.coverage(&runs[4], &predicted.deviations), predicted.half_widths());
    let off = wingbeat_calibrate::rms(&runs[4], &predicted.cycle);
    for channel in 0..2 {
        let width = half[channel] / off[channel];
        assert!(covered[channel] > 0.85 && (1.4..2.5).contains(&width), "{covered:?} {width}");
    }
    let white = predicted.coverage(&runs[4], &predicted.white);
    assert!(white.iter().all(|share| *share < 0.3), "{white:?}");
}

#[test]
fn each_run_scatters_by_its_own_size() {
    let (model, parameters) = (Sums::new(3, 2, 5), parameters(2));
    let means = means(&model, &[2.0, -1.0]);
    let mut runs = observed(&means, 0.1, 11);
    let loud = observed(&means, 0.5, 12).swap_remove(1);
    runs[1] = loud;
    let problem = FitProblem::new(&model, &runs, &parameters).unwrap();
    let size = |run: usize| problem.noise[run].iter().map(|of| of[(0, 0)]).sum::<f64>();
    assert!((size(1) / size(0) / 25.0 - 1.0).abs() < 0.5, "{}", size(1) / size(0));
    // Weighed so, what the cycles say of the errors is what the weights say.
    let solved = solved(&model, &runs, &parameters);
    let plain = solved.information_covariance();
    for (k, error) in solved.errors().iter().enumerate() {
        assert!((error / plain[(k, k)].sqrt() - 1.0).abs() < 0.35, "{error}");
    }
}

#[test]
fn a_next_run_promises_what_it_brings() {
    let (model, parameters) = (Sums::new(4, 3, 7), parameters(3));
    let means = means(&model, &[2.0, -1.0, 0.5]);
    let mut runs = observed(&means, 0.1, 3);
    runs[2].role = RunRole::HeldOut;
    runs[3].role = RunRole::HeldOut;
    let first = solved(&model, &runs, &parameters);
    let problem = FitProblem::new(&model, &runs, &parameters).unwrap();
    let promised = rank(&first, &problem).unwrap();
    let best = promised.iter().find(|candidate| candidate.index >= 2).unwrap();
    let mut more = runs.clone();
    more[best.index].role = RunRole::Fitted;
    let then = solved(&model, &more, &parameters);
    let ratio = best.errors[best.parameter] / then.errors()[best.parameter];
    assert!((ratio - 1.0).abs() < 0.3, "{ratio}");
}

#[test]
fn profiles_say_what_is_identified() {
    let (model, mut parameters) = (Sums::new(2, 2, 8), parameters(2));
    let means = means(&model, &[2.0, 0.0]);
    let runs = observed(&means, 0.1, 4);
    parameters[1].low = 0.0;
    let solved = solved(&model, &runs, &parameters);
    let profiles = solved.profiles().unwrap();
    assert_eq!(profiles[0].label, Label::Identified);
    let [Some(low), Some(high)] = profiles[0].interval else { panic!("two ends") };
    let half = 1.96 * solved.errors()[0];
    assert!((low - (solved.values[0] - half)).abs() < 0.1 * half);
    assert!((high - (solved.values[0] + half)).abs() < 0.1 * half);
    let bounded = solved.values[1] <= 2.0 * solved.errors()[1];
    assert!(!bounded || profiles[1].label == Label::OneSided, "{profiles:?}");
}

#[test]
fn what_is_not_told_is_refused_by_name() {
    let mut model = Sums::new(2, 3, 9);
    for run in &mut model.0 {
        run[2] = run[1].iter().map(|x| 3.0 * x).collect();
    }
    let parameters = parameters(3);
    let runs = observed(&means(&model, &[1.0, 1.0, 1.0]), 0.01, 4);
    let problem = FitProblem::new(&model, &runs, &parameters).unwrap();
    let at = LinearisedRuns::at(&problem, &[0, 1], &[1.0; 3]).unwrap();
    let information = Information::of(&problem, &at, &[1.0; 3]);
    let refusal = information.check(&problem).unwrap_err().to_string();
    assert!(refusal.contains("p1 and p2") && !refusal.contains("p0"), "{refusal}");
    assert!(information.together[0] < 0.1 && information.together[1].is_infinite());
    // With a prior on one of them both are told.
    let mut known = parameters.clone();
    known[2].prior = Some([1.0, 0.01]);
    let problem = FitProblem::new(&model, &runs, &known).unwrap();
    let at = LinearisedRuns::at(&problem, &[0, 1], &[1.0; 3]).unwrap();
    let information = Information::of(&problem, &at, &[1.0; 3]);
    information.check(&problem).unwrap();
}
