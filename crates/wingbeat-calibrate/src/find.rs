//! From a calibration file to what was found.

use crate::found::CalibrationResult;
use crate::residual::Stands;
use crate::{
    CalibrationFailure, CalibrationFile, FitPlan, FitProblem, FitProgress, FitWatch, Information, Keep,
    LinearisedRuns, ModelStructure, NextRun, ObservedCycles, Rival, SolvedCalibration, checked, data, doctor,
    solve,
};
use wingbeat::judge::data::Finding;
use wingbeat::judge::{Judge, Verdict, Warning};
use wingbeat_io::urdf_as_toml;

/// Deviations that a change of a number by its size must make at least for a run to say something of it. *Choice.*
const LEAST: f64 = 1e-3;
/// Passes of a candidate for the next run where the calibration's runs are measured.
const PASSES: usize = 7;

/// A calibration whose samples were read: what is known before the fit.
pub struct PreparedCalibration<'a> {
    calibration: &'a CalibrationFile,
    /// The model and what is fitted.
    pub structure: ModelStructure,
    /// What was measured.
    pub runs: Vec<ObservedCycles>,
    /// What the runs tell of the parameters.
    pub information: Information,
    /// What is odd of the samples.
    pub cautions: Vec<String>,
    /// What is wrong with the data of cases, and with the gain of runs that weigh.
    pub found: Vec<Finding>,
    /// The same as a fit tells it, which judges its model too.
    found_by_fit: Vec<Finding>,
    /// That no run checks the gain of the cell.
    pub unchecked: Option<Warning>,
}

impl CalibrationFile {
    /// Reads or makes the samples, and says what they tell.
    ///
    /// # Errors
    /// Bad runs, samples that cannot be used, a model without an answer.
    pub fn prepared(&self) -> Result<PreparedCalibration<'_>, CalibrationFailure> {
        let mut structure = self.structure(&[], &urdf_as_toml)?;
        let runs = self.observed(&mut structure, &urdf_as_toml, &data::read)?;
        let values: Vec<f64> = structure.parameters.iter().map(|parameter| parameter.start).collect();
        let mut cautions = checked(&structure, &runs, &values)?;
        let by_case = doctor::suspected(&structure, &runs, &values)?;
        let telling = doctor::telling(&structure, &runs, &by_case)?;
        let stands = Stands::of(&structure.model, &runs)?;
        cautions.extend(stands.iter().flat_map(Stands::cautions));
        let of_runs = telling.as_deref().unwrap_or(&runs);
        let problem = FitProblem::new(&structure.model, of_runs, &structure.parameters)?;
        let (weighed, unchecked) = doctor::gains(&structure, &problem, &values, self.limits())?;
        let of_fit = doctor::of_fit(&structure, &by_case, &values)?.into_iter().flatten();
        let found_by_fit = of_fit.chain(weighed.iter().cloned()).collect();
        let found = by_case.into_iter().flatten().chain(weighed).collect();
        let at = LinearisedRuns::at(&problem, &problem.fitted(), &values)?;
        self.check_stages(&problem, &at)?;
        let information = Information::of(&problem, &at, &values);
        Ok(PreparedCalibration {
            calibration: self,
            structure,
            runs,
            information,
            cautions,
            found,
            found_by_fit,
            unchecked,
        })
    }
}

impl CalibrationFile {
    /// Refuses numbers of a stage that is fitted to runs with still wings alone, on which those do not depend.
    fn check_stages(&self, problem: &FitProblem, at: &LinearisedRuns) -> Result<(), CalibrationFailure> {
        let is_still = |run: usize| problem.model.target(run).is_some_and(|target| target.tilts().is_some());
        let still: Vec<_> = at.of.iter().zip(&at.jacobians).filter(|(run, _)| is_still(**run)).collect();
        let last = problem.parameters.iter().map(|parameter| parameter.stage).max().unwrap_or(1);
        for (k, parameter) in problem.parameters.iter().enumerate() {
            let told: f64 = still.iter().map(|(_, j)| j.column(k).norm()).sum();
            if still.is_empty() || parameter.stage == last || told * parameter.scale().abs() > LEAST {
                continue;
            }
            let at = self.spec.parameters.iter().position(|spec| spec.name == parameter.name).unwrap_or(k);
            let allowed = format!(
                "{last}, the last: the stages before it are fitted to the runs with still wings alone, which say nothing of {}",
                parameter.name
            );
            let error = wingbeat::Error::invalid(format!("parameters[{at}].stage"), parameter.stage, allowed);
            return Err(self.explain(&error).into());
        }
        Ok(())
    }
}

impl PreparedCalibration<'_> {
    /// Refuses what the runs cannot tell.
    ///
    /// # Errors
    /// The names of the parameters.
    pub fn check(&self) -> Result<(), CalibrationFailure> {
        let problem = FitProblem::new(&self.structure.model, &self.runs, &self.structure.parameters)?;
        Ok(self.information.check(&problem)?)
    }

    /// The verdict on the data alone, before any fit.
    pub fn verdict(&self) -> Verdict {
        let mut judge = Judge::new(self.calibration.limits());
        self.found.iter().cloned().for_each(|finding| finding.put(&mut judge));
        self.unchecked.iter().cloned().for_each(|warning| judge.warn(warning));
        judge.verdict()
    }

    /// The plan of the fit.
    pub fn plan(&self) -> FitPlan {
        self.calibration.plan()
    }

    /// Fits the numbers, then the other structures, and ranks the candidates for a next run. Fits that `keep` has are not made
    /// again; `watch` is told every step and may end it.
    ///
    /// # Errors
    /// [`Error::Stopped`](crate::Error::Stopped) where `watch` ended it; a model without an answer.
    pub fn fit(
        &self,
        keep: &mut dyn Keep,
        watch: &mut FitWatch,
    ) -> Result<CalibrationResult, CalibrationFailure> {
        let (structure, calibration) = (&self.structure, self.calibration);
        let solved =
            solve(&structure.model, &self.runs, &structure.parameters, &self.plan(), keep, &mut *watch)?;
        let (information, cautions) = (self.information.clone(), self.cautions.clone());
        let mut found =
            CalibrationResult::of(calibration, structure, &self.runs, &solved, information, cautions)?;
        found.findings.clone_from(&self.found_by_fit);
        found.unchecked.clone_from(&self.unchecked);
        for rival in calibration.structures() {
            found.rivals.push(self.rival(&rival.name, &rival.set, &solved, watch)?);
        }
        if calibration.asks_for_a_next_run() {
            let (candidates, refused) = calibration.candidates(&urdf_as_toml)?;
            let passes = calibration.spec.truth.as_ref().map_or(PASSES, |truth| truth.passes);
            found.next = NextRun::all(&candidates, &solved, passes)?;
            found.cautions.extend(refused.iter().map(|why| format!("left out of the design: {why}")));
        }
        found.rank_structures();
        Ok(found)
    }

    /// Another structure fitted to the same runs from the values found, and its error in runs left out.
    fn rival(
        &self,
        name: &str,
        set: &[String],
        solved: &SolvedCalibration,
        watch: &mut FitWatch,
    ) -> Result<Rival, CalibrationFailure> {
        let mut structure = self.calibration.structure(set, &urdf_as_toml)?;
        for (target, own) in structure.model.targets.iter_mut().zip(&self.structure.model.targets) {
            target.moves_as(own);
        }
        for (parameter, value) in structure.parameters.iter_mut().zip(&solved.values) {
            parameter.start = *value;
        }
        let plan = FitPlan { starts: 1, ..self.plan() };
        let mut told = |at: &FitProgress| watch(at);
        let fitted = solve(&structure.model, &self.runs, &structure.parameters, &plan, &mut (), &mut told)?;
        Ok(Rival::of(name, &self.runs, &fitted)?)
    }
}
