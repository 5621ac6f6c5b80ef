//! From a case file to a tethered wing and its summary.

mod build;
mod compare;
mod converge;
mod numbers;
mod spec;
mod steps;
mod summary;
mod verdict;

pub use compare::{CompareSpec, Compared, MeasuredComparison, mended_in_compare};
pub use converge::{
    Convergence, ConvergenceCell, ConvergenceRun, Levels, QUANTITIES, QuantitySpread, ladder, observed_order,
};
pub(super) use numbers::given_twice;
pub use spec::{
    ClockSpec, CoordinateSpec, FourierSpec, HingeSpec, ReadTable, ReferenceSpec, TetherSpec,
    TetheredBodySpec, TetheredWingSpec, WindSpec,
};
pub use steps::{StepChange, change};
pub use summary::{SparSummary, TetherSummary};

use super::fit::model_of_wing;
use super::span_keys::{resolve, varied};
use super::spar_numbers::SparNumbers;
use super::unheard::by_lattice;
use super::{ConfigError, Document, Smoothed};
use build::MotionTables;
use std::path::Path;
use wingbeat_flight::tether::Tether;
use wingbeat_judge::data::Finding;
use wingbeat_judge::{RunLimits, Warning};
use wingbeat_math::Error;
use wingbeat_robot::FittedModel;

/// A checked case, ready to run.
#[derive(Debug)]
pub struct TetherCase {
    /// What the file and overrides said.
    pub spec: TetherSpec,
    /// The merged configuration as TOML.
    pub resolved: String,
    /// The wing in its wind.
    pub tether: Tether,
    /// What fits of harmonics left of the tables.
    pub smoothed: Vec<Smoothed>,
    /// What is wrong with the tables.
    pub found: Vec<Finding>,
    /// What the verdict is held against.
    pub limits: RunLimits,
    /// The numbers of its spar.
    spar_numbers: Option<SparNumbers>,
    pub(super) document: Document,
}

impl TetherCase {
    /// Reads, merges and checks a case file; `overrides` are `key=value`, `read`
    /// reads the tables it names.
    ///
    /// # Errors
    /// One message with file, line, key, the value given and what is allowed.
    pub fn load(path: &Path, overrides: &[String], read: ReadTable) -> Result<Self, ConfigError> {
        Self::new(Document::file(path)?.overridden(overrides), read)
    }

    /// Merges and checks a case from files or memory. Tables are sought from the file that names them, or from the
    /// working folder.
    ///
    /// ```
    /// use wingbeat_config::{Document, TetherCase};
    ///
    /// let case = r#"
    /// name = "plate"
    /// wing.planform = [
    ///     { arc_m = 0.0, leading_edge_m = 0.25, trailing_edge_m = -0.75 },
    ///     { arc_m = 2.0, leading_edge_m = 0.25, trailing_edge_m = -0.75 },
    /// ]
    /// body.nose_up_deg.constant = 4.0
    /// wind = { speed_m_s = 1.0, density_kg_m3 = 1.225 }
    /// aero.law = "linear"
    /// time = { frequency_hz = 0.5, cycles = 1, steps_per_cycle = 16 }
    /// "#;
    /// let no_tables = &|_: &std::path::Path| Err("no tables here".to_owned());
    /// let case = TetherCase::new(Document::text("plate", case)?, no_tables)?;
    /// let run = case.tether.run(|_| std::ops::ControlFlow::Continue(()));
    /// assert_eq!(run.loads.rows(), 17);
    ///
    /// let mut spec = case.spec.clone();
    /// spec.wing.cd0 = Some(-1.0);
    /// let refused = TetherCase::new(Document::value("spec", &spec)?, no_tables).map(drop);
    /// let message = refused.map_err(|error| error.to_string());
    /// assert_eq!(message, Err("spec: wing.cd0 = -1.0: allowed is 0 to 2".into()));
    /// # Ok::<(), wingbeat_config::ConfigError>(())
    /// ```
    ///
    /// # Errors
    /// Messages with the place, the key, the value given and what is allowed.
    pub fn new(document: Document, read: ReadTable) -> Result<Self, ConfigError> {
        let document = document.merged(&["numbers"], &|_, _| None)?;
        let spec: TetherSpec = document.parse()?;
        let mut resolved: toml::Table = document.parse()?;
        let limits = spec.limits.limits().map_err(|error| document.explain(&error))?;
        let built = spec.build(&|key| document.folder(key), read, &limits);
        let (tether, MotionTables { smoothed, found }) = built.map_err(|error| document.explain(&error))?;
        let spar_numbers = spec.spar_numbers();
        resolve(&mut resolved, "aero", [&tether.aero]);
        let resolved = resolved.to_string();
        Ok(Self { spec, resolved, tether, smoothed, found, limits, spar_numbers, document })
    }

    /// The case as TOML, each table under the name that `name` gives for its file, beside the case.
    ///
    /// # Errors
    /// A case that TOML cannot hold.
    pub fn kept(&self, name: impl Fn(&Path) -> String) -> Result<String, ConfigError> {
        self.kept_under([], name)
    }

    /// The same, without what bears along the span where `settings` vary it.
    pub(super) fn kept_under<'a>(
        &self,
        settings: impl IntoIterator<Item = &'a str>,
        name: impl Fn(&Path) -> String,
    ) -> Result<String, ConfigError> {
        let mut spec = self.spec.clone();
        let hinges = spec.wing.hinges.iter_mut().enumerate();
        let hinges = hinges.map(|(i, hinge)| (format!("wing.hinges[{i}].angle_deg"), &mut hinge.angle_deg));
        let body = &mut spec.body;
        let body = [
            ("body.surge_m", &mut body.surge_m),
            ("body.heave_m", &mut body.heave_m),
            ("body.nose_up_deg", &mut body.nose_up_deg),
            ("body.roll_deg", &mut body.roll_deg),
        ];
        for (key, coordinate) in hinges.chain(body.map(|(key, coordinate)| (key.to_owned(), coordinate))) {
            if let CoordinateSpec::Table(table) = coordinate {
                let folder = self.document.folder(&format!("{key}.table.file"));
                table.file = name(&folder.join(&table.file)).into();
            }
        }
        if !varied(settings, "aero") {
            spec.aero.full.resolve([&self.tether.aero]);
        }
        Document::value("case", &spec)?.resolved()
    }

    /// Says where the value that `error` refuses was given.
    pub fn explain(&self, error: &Error) -> ConfigError {
        self.document.explain(error)
    }

    /// The model that numbers that are fitted to it are of: that of a wing alone.
    pub fn fitted_model(&self) -> FittedModel {
        model_of_wing(&self.spec.wing.planform, &self.spec.aero)
    }

    /// The warnings that it gives keys that change no load of the vortex lattice.
    pub fn unheard_by_lattice(&self) -> Vec<Warning> {
        by_lattice(&self.document, !self.spec.numbers.is_empty())
    }
}
