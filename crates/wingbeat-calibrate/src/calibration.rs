//! A calibration file, ready to be solved.

use crate::measured::{Pass, observed};
use crate::truth::clean;
use crate::{Error, Observed, Parameter, Plan, RigModel, RigTarget};
use std::path::Path;
use wingbeat::parallel;
use wingbeat::scenario::{
    CalibratedRunSpec, CalibrationSpec, ConfigError, Document, RigRun, StructureOfModel, Translate,
};

/// A checked calibration file.
pub struct Calibration {
    /// What the file says.
    pub spec: CalibrationSpec,
    /// The file as merged.
    pub resolved: String,
    document: Document,
}

/// Runs of one structure of the model.
pub struct Structure {
    /// The model.
    pub model: RigModel,
    /// What is fitted.
    pub parameters: Vec<Parameter>,
}

impl Calibration {
    /// Checks a calibration file.
    ///
    /// # Errors
    /// Messages with the place, the key, the value given and what is allowed.
    pub fn new(document: Document) -> Result<Self, ConfigError> {
        let document = document.merged(&[], &|_, _| None)?;
        let spec: CalibrationSpec = document.parse()?;
        spec.check().map_err(|error| document.explain(&error))?;
        Ok(Self { spec, resolved: document.resolved()?, document })
    }

    /// Says where the value that `error` refuses was given.
    pub fn explain(&self, error: &wingbeat::Error) -> ConfigError {
        self.document.explain(error)
    }

    /// Where the file of samples number `data` of run `run` is.
    pub fn data(&self, run: usize, data: usize) -> std::path::PathBuf {
        let folder = self.document.folder(&format!("runs[{run}].data[{data}]"));
        folder.join(&self.spec.runs[run].data[data])
    }

    /// The plan of its fit.
    pub fn plan(&self) -> Plan {
        let spec = &self.spec;
        Plan {
            starts: spec.starts,
            spread: spec.start_spread,
            seed: spec.seed,
            discrepancy: spec.discrepancy,
        }
    }

    fn runs(
        &self,
        list: (&str, &[CalibratedRunSpec]),
        set: &[String],
        translate: Translate,
    ) -> Result<Vec<(RigRun, String)>, ConfigError> {
        let (key, specs) = list;
        let keyed = specs.iter().enumerate().map(|(k, spec)| (format!("{key}[{k}]"), spec));
        self.keyed_runs(keyed, set, translate)
    }

    fn keyed_runs<'a>(
        &self,
        list: impl Iterator<Item = (String, &'a CalibratedRunSpec)>,
        set: &[String],
        translate: Translate,
    ) -> Result<Vec<(RigRun, String)>, ConfigError> {
        let mut runs: Vec<(RigRun, String)> = Vec::new();
        for (key, spec) in list {
            let document = self.document.part(&format!("{key}.run"))?;
            let run = RigRun::new(document.overridden(&spec.set).overridden(set), translate)?;
            let name = spec.name.clone().unwrap_or_else(|| run.spec.name.clone());
            if runs.iter().any(|(_, other)| *other == name) {
                let error = wingbeat::Error::invalid(format!("{key}.name"), &name, "a name of its own");
                return Err(self.document.explain(&error));
            }
            runs.push((run, name));
        }
        Ok(runs)
    }

    fn targets(&self, runs: Vec<(RigRun, String)>) -> Result<Vec<RigTarget>, Error> {
        self.tried(runs).into_iter().collect()
    }

    fn tried(&self, runs: Vec<(RigRun, String)>) -> Vec<Result<RigTarget, Error>> {
        let (harmonics, steps) = (self.spec.harmonics, self.spec.steps_per_cycle);
        let runs: Vec<_> = runs.into_iter().map(|run| std::sync::Mutex::new(Some(run))).collect();
        let built = parallel::map(&runs, |_, run| {
            let run = run.lock().ok().and_then(|mut run| run.take());
            run.map(|(run, name)| RigTarget::new(run, &name, harmonics, steps))
        });
        built.into_iter().flatten().collect()
    }

    /// Whether it asks for a next run.
    pub fn asks_for_a_next_run(&self) -> bool {
        !(self.spec.candidates.is_empty() && self.spec.design.is_empty())
    }

    /// The runs with the structure of the model that the file gives and `other` overrides.
    ///
    /// # Errors
    /// Bad runs; parameters that the model has not.
    pub fn structure(&self, other: &[String], translate: Translate) -> Result<Structure, Failure> {
        let set = [self.spec.model.as_slice(), other].concat();
        let runs = self.runs(("runs", &self.spec.runs), &set, translate)?;
        self.built(self.targets(runs)?)
    }

    /// The candidates for a next run: those that the file names, then those of its designs that can be planned; and why the
    /// others cannot.
    ///
    /// # Errors
    /// Bad runs.
    pub fn candidates(&self, translate: Translate) -> Result<(Structure, Vec<String>), Failure> {
        let spec = &self.spec;
        let runs = self.runs(("candidates", &spec.candidates), &spec.model, translate)?;
        let mut targets = self.targets(runs)?;
        let mut refused = Vec::new();
        for (k, design) in spec.design.iter().enumerate() {
            let (key, laid_out) = (format!("design[{k}]"), design.laid_out());
            let keyed = laid_out.iter().map(|run| (key.clone(), run));
            for tried in self.tried(self.keyed_runs(keyed, &spec.model, translate)?) {
                match tried {
                    Ok(target) => targets.push(target),
                    Err(error @ Error::Data { .. }) => refused.push(error.to_string()),
                    Err(error) => return Err(error.into()),
                }
            }
        }
        match refused.first() {
            Some(why) if targets.is_empty() => {
                let what = format!("design: none of {} runs can be made: {why}", refused.len());
                Err(Error::Uninformed(what).into())
            }
            _ => Ok((self.built(targets)?, refused)),
        }
    }

    fn built(&self, targets: Vec<RigTarget>) -> Result<Structure, Failure> {
        let known = targets.first().map_or(Vec::new(), |target| target.run.named_numbers());
        let value = |name: &str| {
            let found = known.iter().find(|(own, _)| own == name).or_else(|| {
                let left = |own: &&(String, f64)| own.0.replacen("_left.", ".", 1) == name;
                known.iter().find(left)
            });
            found.map(|(_, value)| *value)
        };
        let (mut parameters, mut names, mut held) = (Vec::new(), Vec::new(), Vec::new());
        for (k, spec) in self.spec.parameters.iter().enumerate() {
            let Some(own) = value(&spec.name) else {
                let names: Vec<&str> = known.iter().map(|(name, _)| name.as_str()).collect();
                let allowed = format!("of {}", names.join(", "));
                let error = wingbeat::Error::invalid(format!("parameters[{k}].name"), &spec.name, allowed);
                return Err(self.explain(&error).into());
            };
            let [low, high] = spec.bounds();
            let start = spec.start.unwrap_or(own).clamp(low, high);
            if spec.held {
                held.push((spec.name.clone(), start));
                continue;
            }
            names.push(spec.name.clone());
            parameters.push(Parameter {
                name: spec.name.clone(),
                start,
                low,
                high,
                prior: spec.prior,
                stage: spec.stage,
            });
        }
        Ok(Structure { model: RigModel { targets, names, held }, parameters })
    }

    /// What was measured in the runs of `structure`; `read` reads a file of samples for a run. Runs without files are
    /// made by the `truth`.
    ///
    /// # Errors
    /// Samples that cannot be used.
    pub fn observed(
        &self,
        structure: &Structure,
        translate: Translate,
        read: &(dyn Fn(&Path, &RigRun) -> Result<Pass, Error> + Sync),
    ) -> Result<Vec<Observed>, Failure> {
        let passes = self.passes(structure, translate, read)?;
        let one = |k: usize, passes: &Vec<Pass>| {
            let target = &structure.model.targets[k];
            observed(target, passes, self.spec.runs[k].held_out, self.spec.robust)
        };
        let all: Result<Vec<Observed>, Error> = parallel::map(&passes, one).into_iter().collect();
        Ok(all?)
    }

    /// The runs with the structure of the truth; none without one.
    ///
    /// # Errors
    /// Bad runs.
    pub fn truth(&self, translate: Translate) -> Result<Vec<RigTarget>, Failure> {
        let Some(truth) = &self.spec.truth else { return Ok(Vec::new()) };
        let runs = self.runs(("runs", &self.spec.runs), &truth.set, translate)?;
        Ok(self.targets(runs)?)
    }

    fn passes(
        &self,
        structure: &Structure,
        translate: Translate,
        read: &(dyn Fn(&Path, &RigRun) -> Result<Pass, Error> + Sync),
    ) -> Result<Vec<Vec<Pass>>, Failure> {
        let targets = self.truth(translate)?;
        let made = self.spec.truth.as_ref().map(|truth| (truth, targets));
        let indices: Vec<usize> = (0..self.spec.runs.len()).collect();
        let all: Result<Vec<Vec<Pass>>, Error> = parallel::map(&indices, |_, k| {
            let spec = &self.spec.runs[*k];
            if let (true, Some((truth, targets))) = (spec.data.is_empty(), &made) {
                let target = &targets[*k];
                let clean = clean(target)?;
                let seed = self.spec.seed.wrapping_add(1000 * *k as u64);
                return (0..truth.passes).map(|pass| clean.pass(target, truth, seed, pass)).collect();
            }
            let run = &structure.model.targets[*k].run;
            (0..spec.data.len()).map(|data| read(&self.data(*k, data), run)).collect()
        })
        .into_iter()
        .collect();
        Ok(all?)
    }

    /// The other structures that the file asks for.
    pub fn structures(&self) -> &[StructureOfModel] {
        &self.spec.structures
    }
}

/// Why a calibration file cannot be solved.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The file, or one it names.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Samples or model.
    #[error(transparent)]
    Other(#[from] Error),
}
