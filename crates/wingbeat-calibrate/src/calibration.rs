//! A calibration file, ready to be solved.

use crate::measured::{MeasuredPass, observed};
use crate::truth::clean;
use crate::{
    CaseTarget, CycleModel, Error, FitPlan, FittedParameter, ObservedCycles, RigModel, RigTarget, RunRole,
    data,
};
use std::path::Path;
use wingbeat::judge::RunLimits;
use wingbeat::math::NamedNumber;
use wingbeat::parallel;
use wingbeat::robot::{FittedModel, PHASE_RATE};
use wingbeat::scenario::{
    CalibratedRunSpec, CalibrationSpec, ConfigError, Document, KeyProblem, RigRun, StructureOfModel,
    TetherCase, Translate, ValuePlace, Wrong, nearest_names,
};

/// Names that a refusal of an unknown one proposes.
const PROPOSED: usize = 4;
/// What is said of passes that recorded the joints.
const MEAN_MOTION: &str = "the model follows the mean of the joints that the passes recorded";
/// What is said of passes of which not all recorded all joints.
const NO_MOTION: &str = "not all passes recorded all joints without gaps: the model follows the plan";
/// What overrides of the model's air begin with: those of a case do without the first part.
const OF_RIG: &str = "rig.";

/// A checked calibration file.
pub struct CalibrationFile {
    /// What the file says.
    pub spec: CalibrationSpec,
    /// The file as merged.
    pub resolved: String,
    document: Document,
    limits: RunLimits,
}

/// Runs of one structure of the model.
pub struct ModelStructure {
    /// The model.
    pub model: RigModel,
    /// What is fitted.
    pub parameters: Vec<FittedParameter>,
}

impl ModelStructure {
    /// Robot, preset and law of its first run; of cases alone those of the first.
    pub fn fitted_with(&self) -> FittedModel {
        let of_case = || self.model.cases.first().map(|case| case.case.fitted_model());
        let of_run = self.model.targets.first().map(|target| target.run.fitted_model());
        of_run.or_else(of_case).unwrap_or_default()
    }
}

impl CalibrationFile {
    /// Checks a calibration file.
    ///
    /// # Errors
    /// Messages with the place, the key, the value given and what is allowed.
    pub fn new(document: Document) -> Result<Self, ConfigError> {
        let document = document.merged(&[], &|_, _| None)?;
        let spec: CalibrationSpec = document.parse()?;
        spec.check().map_err(|error| document.explain(&error))?;
        let limits = spec.limits.limits().map_err(|error| document.explain(&error))?;
        Ok(Self { spec, resolved: document.resolved()?, document, limits })
    }

    /// What its verdict rests on.
    pub fn limits(&self) -> &RunLimits {
        &self.limits
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

    /// The files of samples: the key that names each, and where it is.
    pub fn files(&self) -> Vec<(String, std::path::PathBuf)> {
        let runs = self.spec.runs.iter().enumerate().map(|(k, run)| (format!("runs[{k}]"), &run.data));
        let cases = self.spec.cases.iter().enumerate().map(|(k, case)| (format!("cases[{k}]"), &case.data));
        let of = |(key, data): (String, &Vec<std::path::PathBuf>)| -> Vec<(String, std::path::PathBuf)> {
            let one = |(i, file): (usize, &std::path::PathBuf)| {
                let key = format!("{key}.data[{i}]");
                let path = self.document.folder(&key).join(file);
                (key, path)
            };
            data.iter().enumerate().map(one).collect()
        };
        runs.chain(cases).flat_map(of).collect()
    }

    /// What is wrong with the file of samples at `key`, beside the line that names it.
    pub(crate) fn wrong_file(&self, key: &str, what: impl std::fmt::Display) -> ConfigError {
        let (value, place) = self.document.written(key).unwrap_or((String::new(), ValuePlace::Nowhere));
        let problem = KeyProblem::File(what.to_string());
        Wrong { place, key: key.into(), value: Some(value), problem, against: Vec::new() }.into()
    }

    /// The override `text` of the list at `key`, its number `i`, with the file that it names seen from this one.
    fn seen_from_here(&self, key: &str, i: usize, text: &str) -> String {
        let file = |(name, value): (&str, &str)| {
            let value = value.trim().trim_matches(['"', '\'']);
            let names_a_file = RigRun::FILES.contains(&name.trim()) && !value.starts_with('{');
            let folder = self.document.folder(&format!("{key}[{i}]"));
            names_a_file.then(|| format!("{}={}", name.trim(), folder.join(value).display()))
        };
        text.split_once('=').and_then(file).unwrap_or_else(|| text.to_owned())
    }

    /// The overrides of the list at `key`.
    fn overrides(&self, key: &str, texts: &[String]) -> Vec<String> {
        texts.iter().enumerate().map(|(i, text)| self.seen_from_here(key, i, text)).collect()
    }

    /// The same error with the lines of this file in place of overrides that stand in its lists at `keys`.
    fn placed(&self, error: ConfigError, keys: &[String]) -> ConfigError {
        let place = |text: &str| {
            let written = |key: &str, i: usize| {
                let (written, place) = self.document.written(&format!("{key}[{i}]"))?;
                Some((self.seen_from_here(key, i, written.trim_matches(['"', '\''])), place))
            };
            let lists = keys.iter().flat_map(|key| (0..).map_while(|i| written(key, i)));
            let same = |written: &str| written == text || written.strip_prefix(OF_RIG) == Some(text);
            let mut found = lists.filter(|(written, _)| same(written)).map(|(_, place)| place);
            found.next()
        };
        let one = |wrong: &Wrong| {
            let mut wrong = wrong.clone();
            if let ValuePlace::Override(text) = &wrong.place
                && let Some(place) = place(text)
            {
                wrong.place = place;
            }
            wrong
        };
        error.all().iter().map(one).collect()
    }

    /// The plan of its fit.
    pub fn plan(&self) -> FitPlan {
        let spec = &self.spec;
        FitPlan {
            starts: spec.starts,
            spread: spec.start_spread,
            seed: spec.seed,
            discrepancy: spec.discrepancy,
        }
    }

    fn runs(
        &self,
        list: (&str, &[CalibratedRunSpec]),
        set: &Overrides,
        translate: Translate,
    ) -> Result<Vec<(RigRun, String)>, ConfigError> {
        let (key, specs) = list;
        let keyed = specs.iter().enumerate().map(|(k, spec)| (format!("{key}[{k}]"), spec));
        self.keyed_runs(keyed, set, translate)
    }

    /// The cases with overrides.
    fn cases(&self, set: &Overrides) -> Result<Vec<CaseTarget>, ConfigError> {
        let mut cases: Vec<CaseTarget> = Vec::new();
        let air: Vec<String> = set
            .texts
            .iter()
            .filter_map(|text| {
                let own = text.strip_prefix(OF_RIG).unwrap_or(text);
                own.starts_with("aero.").then(|| own.to_owned())
            })
            .collect();
        for (k, spec) in self.spec.cases.iter().enumerate() {
            let key = format!("cases[{k}]");
            let keys: Vec<String> = set.keys.iter().cloned().chain([format!("{key}.set")]).collect();
            let document = self.document.part(&format!("{key}.case"))?;
            let document = document.overridden(&air).overridden(&spec.set);
            let read = &|path: &Path| wingbeat_io::read_csv(path).map_err(|error| error.to_string());
            let case = TetherCase::new(document, read).map_err(|error| self.placed(error, &keys))?;
            let name = spec.name.clone().unwrap_or_else(|| case.spec.name.clone());
            let taken = |name: &String| {
                let run = |run: &CalibratedRunSpec| run.name.as_ref() == Some(name);
                self.spec.runs.iter().any(run) || cases.iter().any(|other| other.name == *name)
            };
            if taken(&name) {
                let error = wingbeat::Error::invalid(format!("{key}.name"), &name, "a name of its own");
                return Err(self.document.explain(&error));
            }
            let target = CaseTarget::new(case, &name, self.spec.harmonics);
            cases.push(target.map_err(|error| self.placed(error, &keys))?);
        }
        Ok(cases)
    }

    fn keyed_runs<'a>(
        &self,
        list: impl Iterator<Item = (String, &'a CalibratedRunSpec)>,
        set: &Overrides,
        translate: Translate,
    ) -> Result<Vec<(RigRun, String)>, ConfigError> {
        let mut runs: Vec<(RigRun, String)> = Vec::new();
        for (key, spec) in list {
            let document = self.document.part(&format!("{key}.run"))?;
            let own = format!("{key}.set");
            let document = document.overridden(&self.overrides(&own, &spec.set)).overridden(&set.texts);
            let keys: Vec<String> = set.keys.iter().cloned().chain([own]).collect();
            let run = RigRun::new(document, translate).map_err(|error| self.placed(error, &keys))?;
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
        let own = |list: &'static str, count: usize| {
            (0..count).map(move |k| format!("{list}[{k}].set")).collect::<Vec<_>>()
        };
        let (runs_set, candidates_set) =
            (own("runs", self.spec.runs.len()), own("candidates", self.spec.candidates.len()));
        let keys = [runs_set, candidates_set, vec!["model".into(), "truth.set".into()]].concat();
        let placed = |error: Error| match error {
            Error::Config(error) => Error::Config(self.placed(error, &keys)),
            other => other,
        };
        self.tried(runs).into_iter().map(|tried| tried.map_err(placed)).collect()
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
    pub fn structure(
        &self,
        other: &[String],
        translate: Translate,
    ) -> Result<ModelStructure, CalibrationFailure> {
        let structures = (0..self.spec.structures.len()).map(|k| format!("structures[{k}].set"));
        let model = self.model();
        let set = Overrides {
            texts: [model.texts.as_slice(), other].concat(),
            keys: model.keys.into_iter().chain(structures).collect(),
        };
        let runs = self.runs(("runs", &self.spec.runs), &set, translate)?;
        self.built(self.targets(runs)?, self.cases(&set)?)
    }

    fn model(&self) -> Overrides {
        Overrides { texts: self.overrides("model", &self.spec.model), keys: vec!["model".into()] }
    }

    /// The candidates for a next run: those that the file names, then those of its designs that can be planned; and why the
    /// others cannot.
    ///
    /// # Errors
    /// Bad runs.
    pub fn candidates(
        &self,
        translate: Translate,
    ) -> Result<(ModelStructure, Vec<String>), CalibrationFailure> {
        let spec = &self.spec;
        let model = self.model();
        let runs = self.runs(("candidates", &spec.candidates), &model, translate)?;
        let mut targets = self.targets(runs)?;
        let mut refused = Vec::new();
        for (k, design) in spec.design.iter().enumerate() {
            let (key, laid_out) = (format!("design[{k}]"), design.laid_out());
            let keyed = laid_out.iter().map(|run| (key.clone(), run));
            for tried in self.tried(self.keyed_runs(keyed, &model, translate)?) {
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
            _ => Ok((self.built(targets, Vec::new())?, refused)),
        }
    }

    fn built(
        &self,
        targets: Vec<RigTarget>,
        cases: Vec<CaseTarget>,
    ) -> Result<ModelStructure, CalibrationFailure> {
        let known = known(&targets, &cases);
        let (mut parameters, mut names, mut held) = (Vec::new(), Vec::new(), Vec::new());
        for (k, spec) in self.spec.parameters.iter().enumerate() {
            let key = |end: &str| format!("parameters[{k}].{end}");
            let Some(number) = known.iter().find(|number| number.name == spec.name) else {
                let names: Vec<&str> = known.iter().map(|number| number.name.as_str()).collect();
                let today = targets.first().and_then(|target| target.run.robot.renamed(&spec.name));
                let listed = || {
                    let near = nearest_names(&spec.name, &names, PROPOSED).join(", ");
                    let count = names.len();
                    format!(
                        "one of {count} names, the nearest {near}; `wingbeat calibrate FILE --names` lists all"
                    )
                };
                let renamed = || today.map_or_else(listed, |new| format!("its new name, {new:?}"));
                let allowed = if spec.name == PHASE_RATE {
                    "a number of the model: how fast the crank turns is read from the data of each run".into()
                } else {
                    renamed()
                };
                return Err(self.explain(&wingbeat::Error::invalid(key("name"), &spec.name, allowed)).into());
            };
            let of_key = |e: wingbeat::Error| e.within(&format!("parameters[{k}]"));
            spec.check(&number.quantity).map_err(|e| self.explain(&of_key(e)))?;
            let (own, [low, high]) = (number.value, spec.bounds(&number.quantity));
            if spec.start.is_none() && !(low..=high).contains(&own) {
                let (end, bound, side) =
                    if own < low { ("low", low, "at most") } else { ("high", high, "at least") };
                let allowed = format!(
                    "{side} {own}, the model's own value with which the fit would begin, or give a start within the bounds"
                );
                return Err(self.explain(&wingbeat::Error::invalid(key(end), bound, allowed)).into());
            }
            let start = spec.start.unwrap_or(own);
            if spec.held {
                held.push((spec.name.clone(), start));
                continue;
            }
            names.push(spec.name.clone());
            parameters.push(FittedParameter {
                name: spec.name.clone(),
                start,
                low,
                high,
                prior: spec.prior,
                stage: spec.stage,
            });
        }
        let model = RigModel { targets, cases, names, held };
        let starts: Vec<f64> = parameters.iter().map(|parameter| parameter.start).collect();
        model.check(&starts).map_err(|error| self.at_starts(error))?;
        Ok(ModelStructure { model, parameters })
    }

    /// What the library refuses of the numbers at which the fit starts, with the keys of the parameters that gave them.
    fn at_starts(&self, error: Error) -> Error {
        let Error::Refused(refused) = error else { return error };
        let names = self.spec.parameters.iter().enumerate();
        let names: Vec<(&str, String)> =
            names.map(|(k, spec)| (spec.name.as_str(), format!("parameters[{k}].start"))).collect();
        self.explain(&refused.renamed(&names)).into()
    }

    /// What was measured in the runs of `structure`, which then moves as it was measured; `read` reads a file of samples for a run. Runs
    /// without files are made by the `truth`.
    ///
    /// # Errors
    /// Samples that cannot be used.
    pub fn observed(
        &self,
        structure: &mut ModelStructure,
        translate: Translate,
        read: &(dyn Fn(&Path, &RigRun) -> Result<MeasuredPass, Error> + Sync),
    ) -> Result<Vec<ObservedCycles>, CalibrationFailure> {
        let passes = self.passes(structure, translate, read)?;
        let targets = structure.model.targets.iter_mut().zip(&passes);
        let follows: Vec<bool> = targets.map(|(target, passes)| target.follow(passes)).collect();
        let structure = &*structure;
        let one = |k: usize, passes: &Vec<MeasuredPass>| {
            let target = &structure.model.targets[k];
            let mut seen = observed(target, passes, RunRole::of(&self.spec.runs[k]), self.spec.robust)?;
            let some = || passes.iter().any(|pass| pass.motion.is_some());
            seen.oddities.extend(match follows[k] {
                true if passes.len() > 1 => Some(MEAN_MOTION.to_owned()),
                false if some() => Some(NO_MOTION.to_owned()),
                _ => None,
            });
            Ok(seen)
        };
        let all: Result<Vec<ObservedCycles>, Error> = parallel::map(&passes, one).into_iter().collect();
        let mut all = all?;
        for (k, (spec, target)) in self.spec.cases.iter().zip(&structure.model.cases).enumerate() {
            let read = |(i, file): (usize, &std::path::PathBuf)| {
                let key = format!("cases[{k}].data[{i}]");
                let record = data::table(&self.document.folder(&key).join(file));
                record
                    .map(|record| (file.display().to_string(), record))
                    .map_err(|what| self.wrong_file(&key, what))
            };
            let files = spec.data.iter().enumerate().map(read).collect::<Result<Vec<_>, _>>()?;
            all.push(target.observed(&files, RunRole::of_case(spec), self.spec.robust)?);
        }
        Ok(all)
    }

    /// The runs with the structure of the truth; none without one.
    ///
    /// # Errors
    /// Bad runs.
    pub fn truth(&self, translate: Translate) -> Result<Vec<RigTarget>, CalibrationFailure> {
        let Some(truth) = &self.spec.truth else { return Ok(Vec::new()) };
        let set =
            Overrides { texts: self.overrides("truth.set", &truth.set), keys: vec!["truth.set".into()] };
        let runs = self.runs(("runs", &self.spec.runs), &set, translate)?;
        Ok(self.targets(runs)?)
    }

    /// What the runs, those of the truth and the cases resolve to, each with what it is.
    ///
    /// # Errors
    /// Bad runs and cases.
    pub(crate) fn resolved_runs(
        &self,
        translate: Translate,
    ) -> Result<Vec<(String, String)>, CalibrationFailure> {
        let model = self.model();
        let texts = self.spec.truth.as_ref().map(|truth| self.overrides("truth.set", &truth.set));
        let truth = texts.map(|texts| Overrides { texts, keys: vec!["truth.set".into()] });
        let mut all = Vec::new();
        for (of, set) in std::iter::once(("run", &model)).chain(truth.iter().map(|set| ("truth of", set))) {
            let runs = self.runs(("runs", &self.spec.runs), set, translate)?;
            all.extend(runs.into_iter().map(|(run, name)| (format!("{of} {name}"), run.resolved)));
        }
        let cases = self.cases(&model)?;
        all.extend(cases.into_iter().map(|of| (format!("case {}", of.name), of.case.resolved)));
        Ok(all)
    }

    fn passes(
        &self,
        structure: &ModelStructure,
        translate: Translate,
        read: &(dyn Fn(&Path, &RigRun) -> Result<MeasuredPass, Error> + Sync),
    ) -> Result<Vec<Vec<MeasuredPass>>, CalibrationFailure> {
        let targets = self.truth(translate)?;
        let made = self.spec.truth.as_ref().map(|truth| (truth, targets));
        let indices: Vec<usize> = (0..self.spec.runs.len()).collect();
        let all: Result<Vec<Vec<MeasuredPass>>, Error> = parallel::map(&indices, |_, k| {
            let spec = &self.spec.runs[*k];
            if let (true, Some((truth, targets))) = (spec.data.is_empty(), &made) {
                let target = &targets[*k];
                let clean = clean(target)?;
                let seed = self.spec.seed.wrapping_add(1000 * *k as u64);
                return (0..truth.passes).map(|pass| clean.pass(target, truth, seed, pass)).collect();
            }
            let run = &structure.model.targets[*k].run;
            let one = |data: usize| {
                read(&self.data(*k, data), run)
                    .map_err(|error| self.wrong_file(&format!("runs[{k}].data[{data}]"), error).into())
            };
            (0..spec.data.len()).map(one).collect()
        })
        .into_iter()
        .collect();
        Ok(all?)
    }

    /// Names and values of all numbers that can be fitted, in their declared units.
    ///
    /// # Errors
    /// Bad runs.
    pub fn named_numbers(&self, translate: Translate) -> Result<Vec<(String, f64)>, CalibrationFailure> {
        let model = self.model();
        let runs = self.runs(("runs", &self.spec.runs), &model, translate)?;
        let all = known(&self.targets(runs)?, &self.cases(&model)?);
        Ok(all.into_iter().map(|number| (number.name, number.value)).collect())
    }

    /// The other structures that the file asks for.
    pub fn structures(&self) -> Vec<StructureOfModel> {
        let one = |(k, structure): (usize, &StructureOfModel)| StructureOfModel {
            name: structure.name.clone(),
            set: self.overrides(&format!("structures[{k}].set"), &structure.set),
        };
        self.spec.structures.iter().enumerate().map(one).collect()
    }
}

/// Overrides of runs, and the lists of the calibration in which they stand.
struct Overrides {
    texts: Vec<String>,
    keys: Vec<String>,
}

/// Names and values of all numbers that runs and cases have, each name once; those that both sides of a robot share by their shared name
/// too.
fn known(targets: &[RigTarget], cases: &[CaseTarget]) -> Vec<NamedNumber> {
    let mut known = targets.first().map_or(Vec::new(), |target| target.run.parameters());
    let both: Vec<NamedNumber> = known
        .iter()
        .filter(|number| number.name.contains("_left."))
        .map(|number| NamedNumber { name: number.name.replacen("_left.", ".", 1), ..number.clone() })
        .collect();
    for number in both.into_iter().chain(cases.iter().flat_map(|case| case.case.parameters())) {
        if !known.iter().any(|other| other.name == number.name) {
            known.push(number);
        }
    }
    known.retain(|number| number.name != PHASE_RATE);
    known
}

/// Why a calibration file cannot be solved.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationFailure {
    /// The file, or one it names.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Samples or model.
    #[error(transparent)]
    Other(#[from] Error),
}
