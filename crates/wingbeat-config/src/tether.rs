//! From a case file to a tethered wing and its summary.

use super::fit::{ByName, model_of_wing, of_numbers};
use super::grounded::near;
use super::hinged::FlapSummary;
use super::moved::{Moved, ideal_power_fraction, repeating};
use super::skin::MembraneSummary;
use super::span_keys::{resolve, varied};
use super::spar_numbers::SparNumbers;
use super::stall;
use super::tether_spec::{ClockSpec, ReadTable, TetherSpec, TetheredWingSpec, WindSpec};
use super::unheard::{by_lattice, in_vain, of_strips, side_edges};
use super::web;
use super::{ConfigError, CoordinateSpec, Document, MeasuredComparison, Smoothed};
use serde::Serialize;
use std::path::{Path, PathBuf};
use wingbeat_aero::{Aero, CD0, Planform, Preset};
use wingbeat_flight::simulate::Ending;
use wingbeat_flight::tether::{
    CoefficientScales, CycleMean, CycleWrenches, Hinge, Motion, Periodicity, Plane, Side, Spar, Steady,
    Tether, TetherRun, Wing, WingNumbers,
};
use wingbeat_judge::data::Finding;
use wingbeat_judge::limits::{range, tether};
use wingbeat_judge::{Judge, RunLimits, Status, Verdict, Warning};
use wingbeat_math::Error;
use wingbeat_math::names::one_of;
use wingbeat_math::{Declared, NamedNumber, Parameters, Vec3};
use wingbeat_ocp::plant::Fault;
use wingbeat_robot::{DriveSpec, FittedModel};
use wingbeat_robot::{SurfaceOutline, check_given, former};

/// The folder from which the path at a key is seen.
type Folder<'a> = &'a dyn Fn(&str) -> PathBuf;

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

    /// The numbers of a run, with warnings; `step_change` says by what share they depend on the steps, and `compared` what was
    /// found of a measurement.
    pub fn summary(
        &self,
        run: &TetherRun,
        step_change: Option<StepChange>,
        compared: Option<&MeasuredComparison>,
    ) -> TetherSummary {
        let law = self.tether.aero.law();
        // Of a run that broke down there is no last cycle to take means of.
        let complete = run.ending == Ending::Complete;
        let whole = |value: Option<f64>| value.filter(|_| complete);
        TetherSummary {
            verdict: self.verdict(run, step_change, compared),
            name: self.spec.name.clone(),
            preset: self.spec.aero.preset.name(),
            lift_law: law.name(),
            stall_fraction: whole(Some(run.stalled.stalled())),
            step_change: step_change.map(|change| change.mean),
            step_change_of_peaks: step_change.map(|change| change.peak),
            step_change_of_power: step_change.map(|change| change.power),
            separated_fraction: whole(Some(run.separated_fraction)),
            suction_lost_fraction: whole(Some(run.suction_lost_fraction)),
            membrane: self.skin(run),
            flap: self.hinged(run),
            mean_lift_n: whole(run.mean("force_wind_lift")),
            mean_thrust_n: whole(run.mean("thrust")),
            mean_power_w: whole(run.mean("power")),
            mean_positive_power_w: whole(run.mean_positive_power()),
            propulsive_efficiency: whole(run.efficiency),
            periodicity: run.periodicity.clone().filter(|_| complete),
            spar: run.steady.as_ref().map(SparSummary::of),
            smoothed: self.smoothed.clone(),
            cycle: if complete { run.means.clone() } else { Vec::new() },
        }
    }

    /// What the run is held against, with the tables of its motion and a measurement.
    pub(super) fn verdict(
        &self,
        run: &TetherRun,
        step_change: Option<StepChange>,
        compared: Option<&MeasuredComparison>,
    ) -> Verdict {
        let mut judge = Judge::new(&self.limits);
        match run.ending {
            Ending::Complete => {}
            Ending::Stopped => judge.find(Status::Interrupted, "stopped"),
            Ending::Fault(fault) if fault.is_not_finite() => {
                let mend = "loads grew without bound; take more time.steps_per_cycle, or less motion and speed (are they in m, deg and m/s?)";
                judge.find(Status::Failed, format!("not finite: {fault}: {mend}"));
            }
            Ending::Fault(fault) => judge.find(Status::Failed, fault.to_string()),
        }
        if run.ending == Ending::Complete {
            judge.hold_if(&tether::STEPS, step_change.map(|change| change.mean));
            judge.hold_if(&tether::STEPS_OF_POWER, step_change.map(|change| change.power));
            Moved::new(&self.tether).hold(&mut judge);
            judge.hold_if(&tether::IDEAL, ideal_power_fraction(&self.tether, run));
            let planform = self.tether.wing.planform();
            if let Some((spar, numbers)) = self.spec.spar.as_ref().zip(self.spar_numbers) {
                let held = self.tether.motion.is_still();
                numbers.on(spar).judge(
                    (planform, self.spec.wind.density_kg_m3),
                    (run.steady.as_ref(), held),
                    &mut judge,
                );
            }
            for limit in [&range::REVERSED, &range::REVERSED_OUTSIDE] {
                judge.hold(limit, run.reversed_fraction);
            }
            stall::hold(&mut judge, &run.stalled, "aero.law");
            judge.hold(&range::STALLED_OUTSIDE, run.stalled.untested());
            judge.hold(&tether::SLENDER, 2.0 * planform.covered_half_span() / planform.mean_chord());
            if let Some(Periodicity { change, quantity }) = &run.periodicity {
                let mend = format!("({quantity}; take more cycles, unless the motion does not repeat)");
                judge.hold_about(&tether::CYCLES, *change, &mend);
            }
        }
        if let Some(membrane) = self.skin(run) {
            membrane.judge(&mut judge);
        }
        if let Some(flap) = self.hinged(run) {
            flap.judge(&mut judge);
        }
        let (distance, chord) = (self.tether.ground_distance(), self.tether.wing.planform().mean_chord());
        judge.hold_if(&tether::LOW, distance.map(|distance| distance / chord));
        self.slow()
            .into_iter()
            .chain(near(distance, chord, "wind.ground_m"))
            .chain(repeating(run, self.tether.clock.frequency_hz).filter(|_| !self.tether.motion.is_still()))
            .chain(step_change.into_iter().flat_map(|change| self.coarse(change)))
            .chain(of_numbers("numbers", &self.spec.numbers, &self.fitted_model()))
            .chain(given_twice(&self.document, &self.spec))
            .chain(in_vain(&self.document, "aero", [&self.tether.aero]))
            .chain(side_edges(&self.spec.aero, [&self.tether.aero], Some(run.stalled.stalled())))
            .chain(of_strips(&self.spec.aero, None, [&self.tether.aero]))
            .chain(web::of_hinges(&self.spec.wing.hinges, &self.tether.aero))
            .chain(run.steady.iter().flat_map(|steady| {
                let still = self.tether.motion.is_still();
                let (growth, _) = self.limits.of(&tether::FLUTTER);
                SparSummary::of(steady).warnings(&self.spec.time, still, growth)
            }))
            .for_each(|warning| judge.warn(warning));
        // Peaks of a rough table move with the steps: then the data are at fault.
        let trusted = !self.found.iter().any(|finding| finding.serious);
        judge.hold_if(&tether::PEAKS, step_change.map(|change| change.peak).filter(|_| trusted));
        let found = self.found.iter().chain(compared.iter().flat_map(|compared| &compared.found));
        found.cloned().for_each(|finding| finding.put(&mut judge));
        judge.verdict()
    }

    /// The model that numbers that are fitted to it are of: that of a wing alone.
    pub fn fitted_model(&self) -> FittedModel {
        model_of_wing(&self.spec.wing.planform, &self.spec.aero)
    }

    /// The warnings that it gives keys that change no load of the vortex lattice.
    pub fn unheard_by_lattice(&self) -> Vec<Warning> {
        by_lattice(&self.document, !self.spec.numbers.is_empty())
    }

    /// The caution that the speed is near the one at which speeds are rounded off, V = sqrt(U^2 + delta^2): the coefficients of a
    /// wing at rest grow by V/U - 1.
    fn slow(&self) -> Option<Warning> {
        let (speed, floor) = (self.tether.reference.speed_m_s, self.tether.aero.regularisation_m_s());
        let excess = speed.hypot(floor) / speed - 1.0;
        (excess > ROUNDED_OFF).then(|| {
            let model = if self.tether.aero.preset() == Preset::Full { "full" } else { "paper" };
            let key = format!("aero.{model}.regularisation_m_s");
            let text = format!(
                "at {speed:?} m/s the speeds that {key} = {floor} rounds off make coefficients {:.0} % too large",
                100.0 * excess
            );
            Warning::new("tether.slow", text).size(excess).key(&key)
        })
    }

    /// The membrane over the last cycle; none of a wing without one, or of a run that broke down.
    fn skin(&self, run: &TetherRun) -> Option<MembraneSummary> {
        let (clock, strips) = (self.tether.clock, self.tether.aero.strips());
        let (camber, forward) = (run.strips.values("camber")?, run.strips.values("camber_forward")?);
        let heights = camber.iter().zip(forward).map(|(a, b)| [*a, *b]);
        let first = heights.len().saturating_sub(clock.steps_per_cycle * strips);
        let skin = MembraneSummary::of(&self.tether.aero, heights.skip(first), clock.frequency_hz);
        skin.filter(|_| run.ending == Ending::Complete)
    }

    /// The flap over the last cycle, likewise.
    fn hinged(&self, run: &TetherRun) -> Option<FlapSummary> {
        let last = self.tether.clock.steps_per_cycle * self.tether.aero.strips();
        let angles = run.strips.values("flap")?;
        let first = angles.len().saturating_sub(last);
        let flap = FlapSummary::tethered(&self.tether.aero, angles[first..].iter().copied());
        flap.filter(|_| run.ending == Ending::Complete)
    }
}

/// The warnings that overrides of the merged `document` of a case, `spec`, say numbers of its wing that `numbers` gives too.
pub(super) fn given_twice(document: &Document, spec: &TetherSpec) -> Vec<Warning> {
    let tables = &["wing", "wind", "aero", "spar"];
    let by_name = ByName { key: "numbers", of: "", given: &spec.numbers, tables };
    by_name.given_twice(document, |document| {
        let spec: TetherSpec = document.parse().ok()?;
        let (_, _, aero) = spec.own_aero().ok()?;
        Some(named(&WingNumbers::of(&aero), spec.spar.as_ref().map(SparNumbers::of).as_ref()))
    })
}

/// What the tables of a motion say.
#[derive(Default)]
struct MotionTables {
    smoothed: Vec<Smoothed>,
    found: Vec<Finding>,
}

/// The numbers of a tethered run.
#[derive(Clone, Debug, Serialize)]
pub struct TetherSummary {
    /// What the run is, what that rests on, and what to beware of.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// Name of the case.
    pub name: String,
    /// Aerodynamic preset.
    pub preset: &'static str,
    /// Lift law.
    pub lift_law: &'static str,
    /// Share of strips past the stall angle over the last cycle; this and all that follows is missing of a run that broke down.
    pub stall_fraction: Option<f64>,
    /// Mean separated share of the flow over the strips of the last cycle.
    pub separated_fraction: Option<f64>,
    /// Mean share of the linear leading-edge suction that law `lev` takes away, likewise.
    pub suction_lost_fraction: Option<f64>,
    /// Membrane: largest rise over the chord, slack share, frequency of the motion over its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub membrane: Option<MembraneSummary>,
    /// Flap: largest angle, and that by its weight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flap: Option<FlapSummary>,
    /// Largest change of a mean force or moment over the last cycle with half the steps per cycle, or where that is
    /// above 2 % with twice as many, over the range of the largest force or moment; NaN when that run fails.
    pub step_change: Option<f64>,
    /// The same of the least and the largest of a force or moment; compared with twice as many steps above 5 %.
    pub step_change_of_peaks: Option<f64>,
    /// The same of the mean power, over the mean of its size; compared with twice as many steps above 2 %.
    pub step_change_of_power: Option<f64>,
    /// Mean lift over the last cycle, N.
    pub mean_lift_n: Option<f64>,
    /// Mean force against the wind over the last cycle, N.
    pub mean_thrust_n: Option<f64>,
    /// Mean power that the motion gives to the air over the last cycle, W, with what it takes from the air: the net power.
    pub mean_power_w: Option<f64>,
    /// Mean of the positive part of that power, W: what a drive gives that takes nothing back.
    pub mean_positive_power_w: Option<f64>,
    /// Ratio of mean thrust times wind speed to mean power; negative where the wing drags.
    pub propulsive_efficiency: Option<f64>,
    /// How far the last cycle is from the one before; none of a single cycle.
    pub periodicity: Option<Periodicity>,
    /// Of a wing with spars.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spar: Option<SparSummary>,
    /// What fits of harmonics left of the tables.
    pub smoothed: Vec<Smoothed>,
    /// Means and ranges over the last cycle.
    pub cycle: Vec<CycleMean>,
}

/// The shape from which a wing with spars begins: at rest in the wind, body and hinges held as they are at the start.
#[derive(Clone, Debug, Serialize)]
pub struct SparSummary {
    /// Whether it was found; else the wing begins unbent.
    pub found: bool,
    /// Displacement of the tip up, m, in the axes of the spar's root.
    pub tip_up_m: f64,
    /// Displacement of the tip ahead, m.
    pub tip_ahead_m: f64,
    /// Twist of the tip, nose up, deg.
    pub tip_nose_up_deg: f64,
    /// Lowest frequencies of the unbent beam without air, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Growth rate, 1/s, of the small motion about it that decays least beside its angular frequency, or beside the lowest of the spar where
    /// that is larger, among those up to a reduced frequency of 2 or the third of the spar. Above `tether.growth_fraction` of that the wing flutters or diverges.
    pub growth_1_s: Option<f64>,
    /// Frequency of that motion, Hz; 0 of one that does not oscillate.
    pub frequency_hz: Option<f64>,
    /// Move of the tip with one more coefficient of the strains, over its displacement.
    pub grid_change: Option<f64>,
    /// Largest change of the three lowest frequencies with one more coefficient, over them.
    pub frequency_change: Option<f64>,
    /// The same of the lowest.
    pub lowest_frequency_change: Option<f64>,
}

impl SparSummary {
    /// Frequencies that are told.
    const TOLD: usize = 6;

    fn of(steady: &Steady) -> Self {
        let [up, ahead, nose_up] = steady.tip;
        let [growth, omega] = steady.least_damped.map(|x| x.is_finite().then_some(x));
        Self {
            found: steady.found,
            tip_up_m: up,
            tip_ahead_m: ahead,
            tip_nose_up_deg: nose_up.to_degrees(),
            frequencies_hz: steady.frequencies_hz.iter().copied().take(Self::TOLD).collect(),
            growth_1_s: growth,
            frequency_hz: omega.map(|omega| omega / std::f64::consts::TAU),
            grid_change: steady.grid_change,
            frequency_change: steady.frequency_change.map(|[_, largest]| largest),
            lowest_frequency_change: steady.frequency_change.map(|[lowest, _]| lowest),
        }
    }

    /// Cautions: no shape, disturbances that grow about the start of a motion by more than `most` of their angular frequency, steps that
    /// miss the lowest frequency.
    fn warnings(&self, clock: &ClockSpec, still: bool, most: f64) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if !self.found {
            let text = "no shape at rest in the wind was found, so that the wing begins unbent in still air";
            warnings.push(Warning::new("tether.spar_shape", text).key("wind.speed_m_s"));
        }
        if self.found && !still && self.growth_1_s.is_none() {
            let text = "no growth of small disturbances of the wing at rest in the wind was found: it may flutter or diverge";
            warnings.push(Warning::new("tether.flutter", text).key("wind.speed_m_s"));
        }
        if let (Some(growth), Some(frequency)) = (self.growth_1_s, self.frequency_hz)
            && let Some(lowest) = self.frequencies_hz.first()
            && growth > most * std::f64::consts::TAU * frequency.max(*lowest)
            && !still
        {
            let what = if frequency > 0.0 { "flutters" } else { "diverges" };
            let text = format!(
                "small disturbances of the wing at rest in the wind grow by {growth:.3} 1/s at {frequency:.3} Hz: it {what}"
            );
            warnings.push(Warning::new("tether.flutter", text).size(growth).key("wind.speed_m_s"));
        }
        let rate = clock.frequency_hz * clock.steps_per_cycle as f64;
        if let Some(lowest) = self.frequencies_hz.first()
            && rate < STEPS_PER_PERIOD * lowest
        {
            let text = format!(
                "the wing's lowest frequency of {lowest:.2} Hz has {:.1} steps per period; its oscillations need {STEPS_PER_PERIOD}",
                rate / lowest
            );
            warnings.push(
                Warning::new("tether.spar_steps", text).size(rate / lowest).key("time.steps_per_cycle"),
            );
        }
        warnings
    }
}

/// Steps per period of the lowest frequency of a spar below which there is a caution: the implicit steps are stable at any length,
/// and of third order. *Choice.*
const STEPS_PER_PERIOD: f64 = 12.0;

/// Excess of the coefficients by rounded speeds above which there is a caution. *Choice.*
const ROUNDED_OFF: f64 = 0.02;

/// Loads over those of the dynamic pressure on the wing below which they are rounding. *Choice.*
const ROUNDED: f64 = 1e-9;

/// Change of the means with other steps above which there is a caution. *Choice.*
pub(super) const STEP_CHANGE: f64 = 0.02;
/// The same of the least and the largest loads: 25 times what the shipped cases reach. *Choice.*
const PEAK_CHANGE: f64 = 0.05;

/// How much the loads of the last cycle depend on the steps: the largest change with other steps, forces and moments each over the
/// largest of their kind; NaN when the other run fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepChange {
    /// Of a mean, dimensionless.
    pub mean: f64,
    /// Of a least or largest value, dimensionless.
    pub peak: f64,
    /// Of the mean power, over the mean of its size, dimensionless.
    pub power: f64,
}

impl TetherCase {
    /// How much the loads of `run` depend on its steps: their relative change against the run with half the steps per
    /// cycle and, where that is large, against the one with twice as many, which tells whether this one or that coarse one is
    /// at fault. None for a run that did not end. `simulate` makes the other runs.
    ///
    /// # Errors
    /// Those of `simulate`.
    pub fn step_change<E>(
        &self,
        run: &TetherRun,
        mut simulate: impl FnMut(&Tether) -> Result<TetherRun, E>,
    ) -> Result<Option<StepChange>, E> {
        if !matches!(run.ending, Ending::Complete) {
            return Ok(None);
        }
        let steps = self.tether.clock.steps_per_cycle;
        let scales = self.tether.reference;
        let force = ROUNDED * 0.5 * scales.density_kg_m3 * scales.speed_m_s.powi(2) * scales.area_m2;
        let least = [force, force * scales.chord_m];
        let mut against = |steps| {
            let other = simulate(&self.tether.stepped(steps))?;
            let power = power_change(run, &other, force * scales.speed_m_s);
            Ok(StepChange { power, ..change(&run.means, &other.means, least) })
        };
        let coarse = against((steps / 2).max(2))?;
        let most = [STEP_CHANGE, PEAK_CHANGE, STEP_CHANGE];
        let parts = |of: StepChange| [of.mean, of.peak, of.power];
        let holds: [bool; 3] = std::array::from_fn(|k| parts(coarse)[k] <= most[k]);
        if holds == [true; 3] || self.tether.stepped(2 * steps).check().is_err() {
            return Ok(Some(coarse));
        }
        let fine = against(2 * steps)?;
        let [mean, peak, power] = std::array::from_fn(|k| parts(if holds[k] { coarse } else { fine })[k]);
        Ok(Some(StepChange { mean, peak, power }))
    }

    /// The cautions that the steps are too long for the means and for the peaks.
    fn coarse(&self, change: StepChange) -> impl Iterator<Item = Warning> {
        let steps = self.spec.time.steps_per_cycle;
        let means = ("tether.steps", "mean loads", change.mean, STEP_CHANGE);
        let peaks = ("tether.steps_of_peaks", "least and largest loads", change.peak, PEAK_CHANGE);
        let power = ("tether.steps_of_power", "mean power", change.power, STEP_CHANGE);
        [means, peaks, power].into_iter().filter(|(_, _, change, most)| !(change <= most)).map(
            move |(name, loads, change, _)| {
                let by = percent(change);
                let text = match name {
                    "tether.steps_of_power" => format!(
                        "with other steps than time.steps_per_cycle = {steps} the {loads} changes by {by} of the mean of its size: \
                         take more steps per cycle"
                    ),
                    _ => format!(
                        "with other steps than time.steps_per_cycle = {steps} the {loads} change by {by} of their range: take \
                         more steps per cycle"
                    ),
                };
                Warning::new(name, text).size(change).key("time.steps_per_cycle")
            },
        )
    }
}

/// A share in per cent, with as many digits as say something; of what is not finite "without bound".
fn percent(share: f64) -> String {
    match 100.0 * share.abs() {
        size if !size.is_finite() => "more than can be told".to_owned(),
        size if size >= 1e4 => format!("{size:.1e} %"),
        size if size >= 10.0 => format!("{size:.0} %"),
        size => format!("{size:.1} %"),
    }
}

/// The change of the mean power over the last cycle between two runs, over the mean of its size in the one where that is smaller; below
/// `least`, W, it is rounding.
fn power_change(one: &TetherRun, other: &TetherRun, least: f64) -> f64 {
    let mean = |run: &TetherRun| run.mean("power").unwrap_or(f64::NAN);
    let size = |run: &TetherRun| {
        let power = run.last_cycle("power").unwrap_or_default();
        power.iter().map(|power| power.abs()).sum::<f64>() / power.len() as f64
    };
    let scale = size(one).min(size(other));
    match mean(one) - mean(other) {
        apart if !apart.is_finite() => f64::NAN,
        apart if scale > least => apart.abs() / scale,
        _ => 0.0,
    }
}

/// The largest relative changes of the loads between two runs, forces and moments each by the largest of their kind, in the run
/// where that is smaller: the other may have grown without bound. Loads below `least`, N and N m, are rounding; of power nothing is said.
pub fn change(one: &[CycleMean], other: &[CycleMean], least: [f64; 2]) -> StepChange {
    let of = |kind: &str, least: f64, apart: fn(&CycleMean, &CycleMean) -> f64| {
        let rows = |means: &[CycleMean]| -> Vec<CycleMean> {
            means.iter().filter(|row| row.name.starts_with(kind)).cloned().collect()
        };
        let (one, other) = (rows(one), rows(other));
        let largest =
            |rows: &[CycleMean]| rows.iter().map(|r| r.low.abs().max(r.high.abs())).fold(0.0, f64::max);
        let scale = largest(&one).min(largest(&other));
        let apart: Vec<f64> = one.iter().zip(&other).map(|(a, b)| apart(a, b)).collect();
        match apart.iter().any(|apart| apart.is_nan()) {
            true => f64::NAN,
            false if scale > least => apart.into_iter().fold(0.0, f64::max) / scale,
            false => 0.0,
        }
    };
    let both = |apart: fn(&CycleMean, &CycleMean) -> f64| {
        let (force, moment) = (of("force_wind_", least[0], apart), of("moment_", least[1], apart));
        if force.is_nan() || moment.is_nan() { f64::NAN } else { force.max(moment) }
    };
    let mean = both(|a, b| (a.mean - b.mean).abs());
    // A value that is not a number must not be lost.
    let peak = both(|a, b| {
        let [low, high] = [(a.low - b.low).abs(), (a.high - b.high).abs()];
        if low.is_nan() || high.is_nan() { f64::NAN } else { low.max(high) }
    });
    StepChange { mean, peak, power: 0.0 }
}

/// What the names of numbers begin with that a wing alone has not.
const ELSEWHERE: [&str; 7] = ["body", "links", "linkage", "structure", "gait", "mount", "crank"];

/// Whether the number called `name` is none of those that a wing alone has not.
fn is_own(name: &str) -> bool {
    let of = name.split_once('.').map_or("", |(of, _)| of);
    !ELSEWHERE.contains(&of) && !DriveSpec::NAMES.contains(&of)
}

/// A model, and its spar, with those of the numbers `to` that are their own.
fn renumbered(
    aero: &Aero,
    spar: Option<SparNumbers>,
    to: &[(&str, f64)],
) -> Result<(Aero, Option<SparNumbers>), Error> {
    let wing = WingNumbers::of(aero);
    let known = named(&wing, spar.as_ref());
    for (name, value) in to.iter().filter(|(name, _)| is_own(name)) {
        let Some(number) = known.iter().find(|number| number.name == *name) else {
            let names: Vec<&str> = known.iter().map(|number| number.name.as_str()).collect();
            let allowed =
                former(name).map_or_else(|| one_of(name, &names), |new| format!("its new name, {new:?}"));
            return Err(Error::invalid("numbers", format!("{name:?}"), allowed));
        };
        check_given(name, &number.quantity, *value)
            .map_err(|e| e.renamed(&[(*name, format!("numbers.\"{name}\""))]))?;
        NamedNumber { value: *value, ..number.clone() }.check()?;
    }
    let given = |number: Declared, own| {
        to.iter().find(|(name, _)| *name == number.name).map_or(own, |(_, value)| *value)
    };
    let WingNumbers(numbers) = wing.map_named(&|_, _, _| None, |own| own, given);
    let spar = spar.map(|spar| spar.map_named(&|_, _, _| None, |own| own, given));
    Ok((aero.with(&numbers)?, spar))
}

/// The numbers of a wing and of its spar, with what is declared of them.
fn named(wing: &WingNumbers, spar: Option<&SparNumbers>) -> Vec<NamedNumber> {
    let mut known = wing.named(&|_, _, _| None);
    known.extend(spar.into_iter().flat_map(|spar| spar.named(&|_, _, _| None)));
    known
}

/// Change of a number of a bent wing for a difference, over its value or, where that is less, over [`LEAST`]. *Choice.*
const DIFFERENCE: f64 = 1e-3;
/// Least size of such a number, in its unit. *Choice.*
const LEAST: f64 = 1e-3;

impl TetherCase {
    /// Says where the value that `error` refuses was given.
    pub fn explain(&self, error: &Error) -> ConfigError {
        self.document.explain(error)
    }

    /// Names and values of the numbers that `numbers` may give, as a robot calls those of its wing and air, in their declared
    /// units.
    pub fn named_numbers(&self) -> Vec<(String, f64)> {
        self.parameters().into_iter().map(|number| (number.name, number.value)).collect()
    }

    /// The same with what is declared of them.
    pub fn parameters(&self) -> Vec<NamedNumber> {
        named(&WingNumbers::of(&self.tether.aero), self.spar_numbers.as_ref())
    }

    /// The wing in its wind with other numbers, in their declared units; those of what a wing alone has not do not count.
    ///
    /// # Errors
    /// A number that the wing has not, or that cannot be.
    pub fn adjusted(&self, to: &[(&str, f64)]) -> Result<Tether, Error> {
        let (aero, numbers) = renumbered(&self.tether.aero, self.spar_numbers, to)?;
        let ground = self.tether.ground.as_ref().map(|plane| Plane::new(&aero, plane.height_m));
        let spar = self.spec.built_spar(&aero, self.tether.wing.planform(), numbers)?;
        // Loads do not ask how fine the shape at rest is.
        let spar = spar.map(|spar| Spar { finer: None, ..spar });
        Ok(Tether { aero, ground, spar, ..self.tether.clone() })
    }

    /// The derivatives of the loads over the last cycle, N and N m over the units of the numbers called `keys`, in their order, where the
    /// numbers are `to`; no load depends on what a wing alone has not. Those of a wing that bends are differences, central but at the ends of what a number may be.
    ///
    /// # Errors
    /// A number that the wing has not; a fault of the model.
    pub fn differentiated(
        &self,
        to: &[(&str, f64)],
        keys: &[&str],
    ) -> Result<Result<Vec<CycleWrenches>, Fault>, Error> {
        if self.tether.spar.is_some() {
            return keys.iter().map(|key| self.difference(to, key)).collect();
        }
        let tether = self.adjusted(to)?;
        let varied: Vec<&str> = keys.iter().copied().filter(|key| is_own(key)).collect();
        Ok(tether.differentiated(&varied)?.map(|found| {
            let mut found = found.into_iter();
            let none = || self.no_loads();
            let one = |key: &&str| is_own(key).then(|| found.next()).flatten().unwrap_or_else(none);
            keys.iter().map(one).collect()
        }))
    }

    fn no_loads(&self) -> CycleWrenches {
        vec![[0.0; 6]; self.tether.clock.steps_per_cycle]
    }

    /// The derivative by the number called `key`, by a difference.
    fn difference(&self, to: &[(&str, f64)], key: &str) -> Result<Result<CycleWrenches, Fault>, Error> {
        if !is_own(key) {
            return Ok(Ok(self.no_loads()));
        }
        let own = self.parameters().into_iter().find(|number| number.name == key);
        let own = own.ok_or_else(|| Error::invalid("numbers", format!("{key:?}"), "a number of the wing"))?;
        let value = to.iter().find(|(name, _)| *name == key).map_or(own.value, |(_, value)| *value);
        let step = DIFFERENCE * value.abs().max(LEAST);
        // Within what the number is given, and may be.
        let [least, most] = own.quantity.given;
        let (low, high) = ((value - step).max(least), (value + step).min(most));
        let at = |value: f64| -> Result<Result<CycleWrenches, Fault>, Error> {
            let others = to.iter().copied().filter(|(name, _)| *name != key);
            let moved: Vec<(&str, f64)> = others.chain([(key, value)]).collect();
            Ok(self.adjusted(&moved)?.last_wrenches())
        };
        let (below, above) = (at(low)?, at(high)?);
        let slope = |(below, above): (&[f64; 6], &[f64; 6])| -> [f64; 6] {
            std::array::from_fn(|k| (above[k] - below[k]) / (high - low))
        };
        Ok(below.and_then(|below| Ok(below.iter().zip(&above?).map(slope).collect())))
    }
}

impl TetherSpec {
    fn build(
        &self,
        folder: Folder,
        read: ReadTable,
        limits: &RunLimits,
    ) -> Result<(Tether, MotionTables), Error> {
        self.check()?;
        let (motion, tables) = self.motion(folder, read, limits)?;
        let clock = self.time.clock();
        let (planform, wing, aero) = self.own_aero()?;
        let (aero, numbers) = self.numbered(&aero)?;
        let spar = self.built_spar(&aero, &planform, numbers)?;
        let halves = if self.wing.side == Side::Both { 1.0 } else { 0.5 };
        let area = planform.area() * halves;
        let tether = Tether {
            reference: CoefficientScales {
                density_kg_m3: aero.numbers().density,
                speed_m_s: self.reference_speed()?,
                area_m2: self.reference.area_m2.unwrap_or(area),
                chord_m: self
                    .reference
                    .chord_m
                    .unwrap_or(area / (2.0 * halves * planform.covered_half_span())),
            },
            wing,
            motion,
            ground: self.wind.ground_m.map(|height| Plane::new(&aero, height)),
            aero,
            wind: self.wind.velocity(),
            side: self.wing.side,
            clock,
            spar,
        };
        let names = [("air", "wind"), ("hinges", "wing.hinges")];
        tether.check().map_err(|e| e.renamed(&names))?;
        Ok((tether, tables))
    }

    /// Its planform, its wing, and the model of that with no number by its name.
    fn own_aero(&self) -> Result<(Planform, Wing, Aero), Error> {
        let planform = self.wing.outline().map_err(|e| e.within("wing"))?;
        self.wing
            .flap
            .iter()
            .try_for_each(|flap| flap.end_within(&planform))
            .map_err(|e| e.within("wing"))?;
        let outer = self.wing.hinges.iter().enumerate().filter(|(_, hinge)| hinge.arc_m > 0.0);
        let (keys, arcs): (Vec<String>, Vec<f64>) =
            outer.map(|(i, hinge)| (format!("wing.hinges[{i}].arc_m"), hinge.arc_m)).unzip();
        let wing = self.wing.build(planform.clone())?;
        let mut names = vec![
            ("half_span".to_owned(), format!("wing.{}", self.wing.tip_key())),
            ("gaps".into(), "wing.gaps".into()),
            ("membrane".into(), "wing.membrane".into()),
            ("flap".into(), "wing.flap".into()),
            ("drag".into(), "wing".into()),
            ("density_kg_m3".into(), "wind.density_kg_m3".into()),
        ];
        names.extend(keys.into_iter().enumerate().map(|(k, key)| (format!("hinge_arcs_m[{k}]"), key)));
        let outline = SurfaceOutline {
            name: "wing".into(),
            key: "wing".into(),
            planform: planform.clone(),
            hinges: arcs,
            webs: Vec::new(),
            cd0: self.wing.cd0.unwrap_or(if self.aero.law.separates() { CD0.default } else { 0.0 }),
            cd90: self.wing.cd90,
            section: self.wing.section,
            membrane: self.wing.membrane.clone(),
            flap: self.wing.flap,
            preset: None,
            law: None,
            strips: None,
        };
        let aero = self.aero.build(&outline, self.wind.density_kg_m3, false, &names)?;
        Ok((planform, wing, aero))
    }

    /// The speed of the coefficients: as given, and else the wind's.
    fn reference_speed(&self) -> Result<f64, Error> {
        let wind = self.wind.speed_m_s;
        if wind == 0.0 && self.reference.speed_m_s.is_none() {
            let allowed = "another speed, or still air with a `reference.speed_m_s` for the coefficients";
            return Err(Error::invalid("wind.speed_m_s", wind, allowed).against(["reference.speed_m_s"]));
        }
        Ok(self.reference.speed_m_s.unwrap_or(wind.abs()))
    }

    /// The wing's model and its spar with those of `numbers` that are their own; those of bodies, gait and rig do not count.
    fn numbered(&self, aero: &Aero) -> Result<(Aero, Option<SparNumbers>), Error> {
        let given: Vec<(&str, f64)> =
            self.numbers.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        renumbered(aero, self.spar.as_ref().map(SparNumbers::of), &given)
    }

    /// The numbers of its spar.
    fn spar_numbers(&self) -> Option<SparNumbers> {
        let given = |number: Declared, own| self.numbers.get(number.name).copied().unwrap_or(own);
        Some(SparNumbers::of(self.spar.as_ref()?).map_named(&|_, _, _| None, |own| own, given))
    }

    /// The spar with these numbers, for a wing of that model and outline.
    fn built_spar(
        &self,
        aero: &Aero,
        planform: &Planform,
        numbers: Option<SparNumbers>,
    ) -> Result<Option<Spar>, Error> {
        let spar = self.spar.as_ref().zip(numbers);
        let built = spar.map(|(spar, numbers)| numbers.on(spar).build(aero, planform.half_span()));
        built.transpose().map_err(|e| e.within("spar"))
    }

    fn motion(
        &self,
        folder: Folder,
        read: ReadTable,
        limits: &RunLimits,
    ) -> Result<(Motion, MotionTables), Error> {
        let frequency = self.time.frequency_hz;
        let degree = 1.0_f64.to_radians();
        let body = &self.body;
        let mut tables = MotionTables::default();
        let mut build = |spec: &super::CoordinateSpec, key: &str, factor| {
            let folder = || folder(&format!("{key}.table.file"));
            let built = spec.build(frequency, &folder, read, limits).map_err(|e| e.within(key))?;
            tables.smoothed.extend(built.smoothed.map(|left| Smoothed { key: key.into(), ..left }));
            let keyed = |finding: Finding| {
                let whole = finding.key.as_ref().map(|end| format!("{key}.{end}"));
                finding.mended_by(whole)
            };
            tables.found.extend(built.found.into_iter().map(keyed));
            Ok(built.coordinate.scaled(factor))
        };
        let surge = build(&body.surge_m, "body.surge_m", 1.0)?;
        let heave = build(&body.heave_m, "body.heave_m", 1.0)?;
        let nose_up = build(&body.nose_up_deg, "body.nose_up_deg", degree)?;
        let roll = build(&body.roll_deg, "body.roll_deg", degree)?;
        let hinge = |(i, h): (usize, &super::HingeSpec)| {
            Ok((h.name.clone(), build(&h.angle_deg, &format!("wing.hinges[{i}].angle_deg"), degree)?))
        };
        let hinges = self.wing.hinges.iter().enumerate().map(hinge).collect::<Result<_, Error>>()?;
        Ok((Motion { surge, heave, nose_up, roll, axis_ahead_m: body.pitch_axis_ahead_m, hinges }, tables))
    }
}

impl TetheredWingSpec {
    /// The planform with its gaps.
    fn outline(&self) -> Result<Planform, Error> {
        Planform::new(&self.planform)?.with_gaps(&self.gaps)
    }

    /// The key that says how long the half wing is.
    fn tip_key(&self) -> String {
        format!("planform[{}].arc_m", self.planform.len().saturating_sub(1))
    }

    fn build(&self, planform: Planform) -> Result<Wing, Error> {
        let hinge = |h: &super::HingeSpec| Hinge {
            kind: h.kind,
            side: h.side,
            arc_m: h.arc_m,
            to_arc_m: h.to_arc_m,
            ahead_m: h.ahead_m,
        };
        let built = Wing::new(planform, self.hinges.iter().map(hinge).collect());
        built.map_err(|e| e.renamed(&[("half_span", self.tip_key())]).within("wing"))
    }
}

impl WindSpec {
    /// Velocity of the air in W, m/s.
    fn velocity(&self) -> Vec3 {
        let (up, level) = self.incidence_deg.to_radians().sin_cos();
        let (side, ahead) = self.sideslip_deg.to_radians().sin_cos();
        Vec3::new(-level * ahead, -level * side, up) * self.speed_m_s
    }
}
