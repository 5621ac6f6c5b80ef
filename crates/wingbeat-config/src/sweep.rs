//! Many runs of one scenario or case with keys drawn at random or from a grid.

use super::document::{ConfigError, Document, KeyProblem, ValuePlace, Wrong, spoken};
use super::fit;
use super::fit_draw::DrawnNumbers;
use super::shared::Shared;
use super::sweep_spec::{Draw, Hold, Sampling, SweepSpec};
use super::{PaperResults, ReadTable, Scenario, TetherCase};
use std::path::Path;
use std::sync::Arc;
use wingbeat_judge::{RunLimits, Warning};
use wingbeat_math::Error;
use wingbeat_math::Random;

/// A checked sweep.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// What the file said.
    pub spec: SweepSpec,
    /// What is run.
    pub of: SweepOf,
    /// The sweep as TOML, what is run inside; makes the same runs.
    pub resolved: String,
    document: Document,
    inner: Document,
    /// The numbers that are drawn.
    drawn: DrawnNumbers,
    /// Part of its range by draw and run, of a Latin hypercube.
    parts: Vec<Vec<usize>>,
    pub(super) shared: Arc<Shared>,
    pub(super) limits: RunLimits,
}

/// What a sweep runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SweepOf {
    /// Flights of a scenario.
    Flights(Hold),
    /// Runs of a tethered wing.
    Cases,
}

impl SweepOf {
    fn key(self) -> &'static str {
        match self {
            Self::Flights(_) => "scenario",
            Self::Cases => "case",
        }
    }
}

/// Keys of what is read into a sweep.
const READ: [&str; 5] =
    ["scenario", "scenario.robot", "scenario.robot.numbers", "scenario.robot.residual", "case"];

/// A sweep whose scenario or case has the overrides that its key `set` lists.
fn with_own_overrides(document: Document) -> Result<Document, ConfigError> {
    if document.written("set").is_none() {
        return Ok(document);
    }
    let of = if document.written("case").is_some() { "case" } else { "scenario" };
    document.overridden_by_list("set", of)?.merged(&READ, &|_, _| None)
}

/// A sweep with the fits that its draws name in their places.
fn with_read_fits(document: Document) -> Result<Document, ConfigError> {
    let keys = (0..).map(|draw| format!("draws[{draw}].fit"));
    let count = (0..).take_while(|draw| document.written(&format!("draws[{draw}]")).is_some()).count();
    let fits: Vec<String> = keys.take(count).filter(|key| document.written(key).is_some()).collect();
    let keys: Vec<&str> = fits.iter().map(String::as_str).collect();
    if keys.is_empty() { Ok(document) } else { document.merged(&keys, &|_, _| None) }
}

impl Sweep {
    /// Reads and checks a sweep file and its scenario or case; `read` reads the tables of a case.
    ///
    /// # Errors
    /// One message with file, line, key, the value given and what is allowed.
    pub fn load(path: &Path, overrides: &[String], read: ReadTable) -> Result<Self, ConfigError> {
        Self::new(Document::file(path)?.overridden(overrides), read)
    }

    /// Checks a sweep from files or memory. Its key `scenario` or `case` names a file, or holds what is run.
    ///
    /// ```no_run
    /// use std::path::Path;
    /// use wingbeat_config::{Document, Sweep};
    ///
    /// let text = r#"
    /// name = "gusts"
    /// runs = 20
    /// draws = [{ key = "air.gust_m_s", low = 0.0, high = 0.5 }]
    /// hold = { roll_within_deg = 5.0, pitch_within_deg = 10.0 }
    /// "#;
    /// let scenario = Document::file(Path::new("scenarios/banking_turn.toml"))?;
    /// let no_tables = &|_: &Path| Err("no tables here".to_owned());
    /// let sweep = Sweep::new(Document::text("gusts", text)?.put("scenario", scenario)?, no_tables)?;
    /// assert_eq!(sweep.values(3).len(), 1);
    /// # Ok::<(), wingbeat_config::ConfigError>(())
    /// ```
    ///
    /// # Errors
    /// Messages with the place, the key, the value given and what is allowed.
    pub fn new(document: Document, read: ReadTable) -> Result<Self, ConfigError> {
        // What is run is read here, once: all runs are of the same, and the sweep holds it.
        let document = document.merged(&READ, &|_, _| None)?;
        let document = with_read_fits(with_own_overrides(document)?)?;
        let spec: SweepSpec = document.parse()?;
        let mut resolved: toml::Table = document.parse()?;
        // What is run holds them, and would lose by them what is resolved there.
        resolved.remove("set");
        let of = spec.check().map_err(|error| document.explain(&error))?;
        let limits = spec.limits.limits().map_err(|error| document.explain(&error))?;
        let drawn = DrawnNumbers::of(&spec).map_err(|error| document.explain(&error))?;
        let inner = document.part(of.key())?;
        let fits = spec.draws.iter().filter_map(Draw::whole_fit).collect::<Vec<_>>();
        let inner = with_all(inner, &fits);
        SweepSpec::check_keys(&drawn, &|key| inner.numbered(key))
            .map_err(|error| document.explain(&error))?;
        let parts = spec.parts();
        let shared = Arc::default();
        let mut sweep =
            Self { spec, of, resolved: String::new(), document, inner, drawn, parts, shared, limits };
        sweep.check_draws(read)?;
        if sweep.of != SweepOf::Cases {
            let scenario = Scenario::new(sweep.inner.clone())?;
            scenario.resolve_span_keys(&mut resolved, "scenario.", &sweep.spec.settings());
        }
        sweep.resolved = resolved.to_string();
        Ok(sweep)
    }

    /// What is published of the scenario of its flights, where they are of that case but for what is drawn.
    pub fn paper(&self) -> Option<PaperResults> {
        Scenario::new(self.inner.clone()).ok()?.spec.paper
    }

    /// What a drawn key is, in words and with its unit; hinges, links and surfaces by their names.
    pub fn spoken(&self, key: &str) -> String {
        let tree: Option<toml::Value> = toml::from_str(&self.resolved).ok();
        let mut at = tree.as_ref().and_then(|tree| tree.get(self.of.key()));
        let mut told = Vec::new();
        for part in key.split('.') {
            let (name, place) = part.split_once('[').map_or((part, None), |(name, place)| {
                (name, place.strip_suffix(']').and_then(|place| place.parse::<usize>().ok()))
            });
            at = at.and_then(|at| at.get(name));
            let item = place.and_then(|place| at?.get(place));
            at = item.or(at);
            told.push(item.and_then(|item| item.get("name")?.as_str()).unwrap_or(part));
        }
        spoken(&told.join("."))
    }

    /// What is said of the fits that the numbers of its runs are from.
    pub(super) fn of_fits(&self) -> Vec<Warning> {
        match self.of {
            SweepOf::Flights(_) => {
                let spec = self.inner.parse::<super::ScenarioSpec>();
                spec.map(|spec| fit::of_flown(&spec).collect()).unwrap_or_default()
            }
            SweepOf::Cases => {
                let spec = self.inner.parse::<super::TetherSpec>();
                let of = |spec: super::TetherSpec| {
                    let model = fit::model_of_wing(&spec.wing.planform, &spec.aero);
                    fit::of_numbers("numbers", &spec.numbers, &model).collect()
                };
                spec.map(of).unwrap_or_default()
            }
        }
    }

    /// What is said of draws, and of overrides, of numbers that are given by name too.
    pub(super) fn given_twice(&self) -> Vec<Warning> {
        let drawn = self.drawn(0);
        let said = match self.of {
            SweepOf::Flights(_) => drawn.merged(&super::INCLUDES, &|_, _| None).and_then(|document| {
                let spec = document.parse()?;
                Ok(fit::given_twice(&document, &spec))
            }),
            SweepOf::Cases => drawn.merged(&["numbers"], &|_, _| None).and_then(|document| {
                let spec = document.parse()?;
                Ok(super::tether::given_twice(&document, &spec))
            }),
        };
        said.unwrap_or_default()
    }

    /// Number of runs.
    pub fn runs(&self) -> usize {
        self.spec.count()
    }

    /// One draw for every number that is drawn: those of the file, of a fit one for each of its numbers.
    pub fn draws(&self) -> &[Draw] {
        &self.drawn.draws
    }

    /// The place in the file of what draws number `k` of [`draws`](Self::draws).
    pub(super) fn place(&self, k: usize) -> usize {
        self.drawn.places[k]
    }

    /// The values drawn for run `run`, in the order of [`draws`](Self::draws) and in the units of their keys. Random numbers are from a
    /// stream of its own for every run, so that order and interruption do not matter. Of a grid the last draw varies fastest.
    pub fn values(&self, run: usize) -> Vec<f64> {
        let mut random = Random::stream(self.spec.seed, run as u64);
        let (mut left, mut grid) = (self.runs(), run);
        let mut value = |(k, draw): (usize, &Draw), random: &mut Random| match self.spec.sampling {
            Sampling::Random => draw.share(random.unit()),
            Sampling::LatinHypercube => {
                draw.share((self.parts[k][run] as f64 + random.unit()) / self.runs() as f64)
            }
            Sampling::Grid => {
                let points = draw.count();
                left /= points;
                let place = grid / left;
                grid %= left;
                draw.at(place)
            }
        };
        self.spec
            .draws
            .iter()
            .enumerate()
            .flat_map(|(k, draw)| match self.drawn.fit(k) {
                Some(fit) => fit.drawn(&mut random),
                None => vec![value((k, draw), &mut random)],
            })
            .collect()
    }

    /// What run `run` runs, with its values.
    fn drawn(&self, run: usize) -> Document {
        self.with(&self.values(run))
    }

    /// What is run, with a value for each draw.
    pub(super) fn with(&self, values: &[f64]) -> Document {
        let draws = self.draws().iter().zip(values);
        draws.fold(self.inner.clone(), |document, (draw, value)| set(document, draw, *value))
    }

    /// The scenario of flight `run`.
    ///
    /// # Errors
    /// A drawn key that the scenario does not know, or refuses.
    pub fn scenario(&self, run: usize) -> Result<Scenario, ConfigError> {
        let seed = self.spec.seed + run as u64;
        Scenario::new(self.drawn(run).set(format!("seed={seed}")))
    }

    /// The case of run `run`.
    ///
    /// # Errors
    /// A drawn key that the case does not know, or refuses.
    pub fn case(&self, run: usize, read: ReadTable) -> Result<TetherCase, ConfigError> {
        TetherCase::new(self.drawn(run), read)
    }

    /// The sweep as TOML, each table of its case under the name that `name` gives for its file, beside the sweep.
    ///
    /// # Errors
    /// A sweep that TOML cannot hold.
    pub fn kept(&self, read: ReadTable, name: impl Fn(&Path) -> String) -> Result<String, ConfigError> {
        if self.of != SweepOf::Cases {
            return Ok(self.resolved.clone());
        }
        let case = TetherCase::new(self.inner.clone(), read)?.kept_under(self.spec.settings(), name)?;
        let spec = SweepSpec { case: None, set: Vec::new(), ..self.spec.clone() };
        Document::value("sweep", &spec)?.put("case", Document::text("case", &case)?)?.resolved()
    }

    /// Builds what is run, and then with both ends of every draw and a value between, one at a time.
    fn check_draws(&self, read: ReadTable) -> Result<(), ConfigError> {
        let built = |document: Document| match self.of {
            SweepOf::Flights(_) => {
                let scenario = Scenario::new(document)?;
                scenario.without_lattice().map_err(|error| scenario.explain(&error))
            }
            SweepOf::Cases => TetherCase::new(document, read).map(drop),
        };
        built(self.inner.clone())?;
        for (i, flight) in self.spec.search.iter().flat_map(|search| search.flights.iter().enumerate()) {
            let place = || format!("search.flights[{i}]");
            built(with_all(self.inner.clone(), flight)).map_err(|error| {
                let allowed = format!("keys and values of the scenario ({error})");
                self.document.explain(&Error::invalid(place(), flight.join(", "), allowed))
            })?;
        }
        for (i, draw) in self.drawn.places.iter().zip(self.draws()) {
            for (end, value) in draw.tried() {
                let end = if self.spec.draws[*i].fit.is_some() { "fit".into() } else { end };
                let outcome = built(set(self.inner.clone(), draw, value));
                outcome.map_err(|error| self.blamed(error, draw, value, (&format!("draws[{i}]"), &end)))?;
            }
        }
        Ok(())
    }

    /// An error about a drawn value as one about the end of the draw, or about the key that it is drawn for.
    fn blamed(&self, error: ConfigError, draw: &Draw, value: f64, (place, end): (&str, &str)) -> ConfigError {
        let of = |here: &ValuePlace| {
            let by_draw = |one: &&Wrong| one.place == *here || one.against.iter().any(|o| o.place == *here);
            error.all().iter().find(by_draw)
        };
        let places = overrides(draw, value).into_iter().map(ValuePlace::Override).enumerate();
        let Some((k, wrong)) = places.filter_map(|(k, here)| Some((k, of(&here)?))).next() else {
            return error;
        };
        if let KeyProblem::Value(allowed) = &wrong.problem
            && allowed.starts_with("a whole number")
            && draw.values.is_empty()
        {
            let allowed = format!("values = [..] in place of a range: {} is {allowed}", draw.key);
            let low = draw.low.unwrap_or(value);
            return self.document.explain(&Error::invalid(format!("{place}.low"), low, allowed));
        }
        let key = match (k, &wrong.problem) {
            (0, KeyProblem::Value(_)) => format!("{place}.{end}"),
            (0, _) => format!("{place}.key"),
            (k, _) => format!("{place}.also[{}]", k - 1),
        };
        let value = match end {
            "fit" => format!("{} = {value}, {} standard errors off,", draw.key, super::fit_draw::TRIED),
            _ => self.document.written(&key).map_or(String::new(), |(value, _)| value),
        };
        let allowed = format!("what the {} allows ({error})", self.of.key());
        self.document.explain(&Error::invalid(key, value, allowed))
    }
}

/// A document with the value of a draw at all its keys.
fn set(document: Document, draw: &Draw, value: f64) -> Document {
    with_all(document, &overrides(draw, value))
}

/// The overrides of one draw: that of its key, then those of `also`.
fn overrides(draw: &Draw, value: f64) -> Vec<String> {
    let twin = |also: &String| {
        let (key, value) = also.strip_prefix('-').map_or((also.as_str(), value), |key| (key, -value));
        drawn(&Draw { key: key.into(), ..draw.clone() }, value)
    };
    std::iter::once(drawn(draw, value)).chain(draw.also.iter().map(twin)).collect()
}

/// A document with overrides, `key=value`.
pub(super) fn with_all(document: Document, overrides: &[String]) -> Document {
    overrides.iter().fold(document, |document, one| document.set(one.as_str()))
}

/// Below this whole numbers are floats without a gap.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// The override of one draw: without a fraction a whole number, which keys of either kind take.
fn drawn(draw: &Draw, value: f64) -> String {
    if let Some(word) = draw.word(value) {
        return format!("{}={word}", draw.key);
    }
    match value.fract() == 0.0 && value.abs() < LARGEST_WHOLE {
        true => format!("{}={value}", draw.key),
        false => format!("{}={value:?}", draw.key),
    }
}
