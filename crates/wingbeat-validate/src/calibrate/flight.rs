//! What a calibration is worth in flight: truth and model under the same inputs, before and after the fit, and what the model
//! could reach at all.

use super::{all_clean, measured, no_answer, shipped, truth};
use crate::{Error, Row};
use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::math::Random;
use wingbeat::scenario::Scenario;
use wingbeat::simulate::{Controller, Measurement, Record, Update};
use wingbeat_calibrate::{
    Error as Fault, Layout, Model, Observed, Parameter, Plan, Problem, Progress, Rival, solve, solve_problem,
};

/// Draws of the numbers before the fit.
const DRAWS: usize = 20;
/// Share by which they are off.
const OFF: f64 = 0.2;
/// One stroke at 3.5 Hz, s, in whole records.
const CYCLE: f64 = 0.286;
/// Period of the controller, s: that of the scenario.
const PERIOD: f64 = 0.005;
/// Speeds at the start of the flights, m/s: that of the scenario, and that of the runs.
const SPEEDS: [f64; 2] = [1.5, 0.8];
/// What counts as one where the ends of flights are fitted: rad and m/s. *Choice.*
const ONE: [f64; 2] = [TAU / 360.0, 0.02];
/// The same where their loads are, in parts of the rms of those of the truth. *Choice.*
const LOAD: f64 = 0.1;
/// Parts of a stroke over which loads are taken. *Choice.*
const PARTS: usize = 28;
/// Step of a central difference, in parts of a number's size.
const STEP: f64 = 1e-3;
/// Models that are fitted, none of them the truth: preset and law. The first is the paper's.
pub(super) const STRUCTURES: [[&str; 2]; 4] =
    [["paper", "linear"], ["paper", "stall"], ["paper", "lev"], ["full", "stall"]];
/// The truth.
pub(super) const TRUTH: [&str; 2] = ["full", "lev"];
/// Numbers of a truth of the first structure: the right model.
const RIGHT: [(&str, f64); 6] = [
    ("surfaces.wing.section_slope", 5.2),
    ("surfaces.wing.cd0", 0.08),
    ("surfaces.wing.cd90", 1.7),
    ("surfaces.wing.added_mass_scale", 0.8),
    ("links.twist.mass_kg", 0.0041),
    ("links.twist.com_m[1]", 0.047),
];

/// Inputs of a record, played again.
struct Again<'a> {
    time: &'a [f64],
    inputs: Vec<&'a [f64]>,
}

impl<'a> Again<'a> {
    fn of(record: &'a Record) -> Self {
        let commands = record.columns().iter().filter(|column| column.name.starts_with("command_"));
        let inputs = commands.map(|column| column.values.as_slice()).collect();
        Self { time: record.values("t").unwrap_or_default(), inputs }
    }
}

impl Controller for Again<'_> {
    fn update(&mut self, _: f64, _: &Measurement) -> Update {
        Update::Kept
    }
    fn input(&self, t: f64, u: &mut [f64]) {
        let next = self.time.partition_point(|at| *at < t).clamp(1, self.time.len() - 1);
        let share = ((t - self.time[next - 1]) / (self.time[next] - self.time[next - 1])).clamp(0.0, 1.0);
        for (u, of) in u.iter_mut().zip(&self.inputs) {
            *u = of[next - 1] + share * (of[next] - of[next - 1]);
        }
    }
}

/// Overrides that choose preset and law.
pub(super) fn aero([preset, law]: [&str; 2]) -> [String; 2] {
    [format!("aero.preset={preset}"), format!("aero.law={law}")]
}

/// The override that sets numbers of a robot.
pub(super) fn set(key: &str, numbers: &[(String, f64)]) -> Option<String> {
    let list: Vec<String> = numbers.iter().map(|(name, value)| format!("{name:?} = {value:?}")).collect();
    (!list.is_empty()).then(|| format!("{key}={{ {} }}", list.join(", ")))
}

fn scenario(speed: f64, structure: [&str; 2], numbers: &[(String, f64)]) -> Result<Scenario, Error> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn_beta.toml");
    let mut overrides = vec![
        format!("flight.duration_s={CYCLE}"),
        "manoeuvre.turn_start_s=0.0".into(),
        format!("start.velocity_m_s=[{speed}, 0.0, 0.0]"),
    ];
    overrides.extend(aero(structure));
    overrides.extend(set("robot.numbers", numbers));
    Scenario::load(&file, &overrides).map_err(no_answer)
}

/// Attitude (rad) and velocity (m/s) at the end of a record.
fn end(record: &Record) -> Result<Vec<f64>, Error> {
    let last = |name: &&str| Ok(column(record, name)?.last().copied().unwrap_or(f64::NAN));
    ["roll", "pitch", "yaw", "v_WB_W_x", "v_WB_W_y", "v_WB_W_z"].iter().map(last).collect()
}

/// What rates (rad/s) and velocities (m/s) gain in each part of the stroke: the loads that act in it.
fn gains(record: &Record) -> Result<Vec<f64>, Error> {
    let time = column(record, "t")?;
    let edge = |part: usize| {
        let t = CYCLE * part as f64 / PARTS as f64;
        time.partition_point(|own| *own < t - 1e-9).min(time.len() - 1)
    };
    let mut gains = Vec::new();
    for name in ["w_WB_B_x", "w_WB_B_y", "w_WB_B_z", "v_WB_W_x", "v_WB_W_y", "v_WB_W_z"] {
        let values = column(record, name)?;
        gains.extend((0..PARTS).map(|part| values[edge(part + 1)] - values[edge(part)]));
    }
    Ok(gains)
}

fn column<'a>(record: &'a Record, name: &str) -> Result<&'a [f64], Error> {
    let values = record.values(name).filter(|values| !values.is_empty());
    values.ok_or_else(|| no_answer(format!("no column {name}")))
}

fn norm(of: &[f64]) -> f64 {
    of.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// What is looked at of a flight.
type Of = fn(&Record) -> Result<Vec<f64>, Error>;

/// A flight of the truth over one stroke, from one speed.
struct Flown {
    speed: f64,
    record: Record,
}

impl Flown {
    fn new(speed: f64, structure: [&str; 2], numbers: &[(String, f64)]) -> Result<Self, Error> {
        let run =
            scenario(speed, structure, numbers)?.fly(|_| ControlFlow::Continue(())).map_err(no_answer)?;
        Ok(Self { speed, record: run.record })
    }

    /// What `of` says of the model with these numbers under the same inputs, less what it says of the truth.
    fn apart(&self, structure: [&str; 2], numbers: &[(String, f64)], of: Of) -> Result<Vec<f64>, Error> {
        let model = scenario(self.speed, structure, numbers)?;
        let mut again = Again::of(&self.record);
        let run = model.fly_with(&mut again, PERIOD, model.sensors(), |_| ControlFlow::Continue(()));
        let (own, truth) = (of(&run.map_err(no_answer)?.record)?, of(&self.record)?);
        Ok(own.iter().zip(truth).map(|(own, truth)| own - truth).collect())
    }

    /// Attitude, rad, and velocity, m/s, by which they are apart.
    fn off(&self, structure: [&str; 2], numbers: &[(String, f64)]) -> Result<[f64; 2], Error> {
        let apart = self.apart(structure, numbers, end)?;
        Ok([norm(&apart[..3]), norm(&apart[3..])])
    }
}

/// Flights as what is fitted: how far the model is from the truth after each.
struct Flights<'a> {
    flown: &'a [Flown],
    structure: [&'a str; 2],
    parameters: &'a [Parameter],
    of: Of,
}

impl Model for Flights<'_> {
    fn predict(&self, run: usize, values: &[f64]) -> Result<Vec<f64>, Fault> {
        let apart = self.flown[run].apart(self.structure, &named(self.parameters, values), self.of);
        apart.map_err(|error| Fault::data("flight", error.to_string()))
    }
    fn slopes(&self, run: usize, values: &[f64]) -> Result<Vec<Vec<f64>>, Fault> {
        let by = |k: usize| {
            let Parameter { low, high, .. } = self.parameters[k];
            let step = STEP * self.parameters[k].scale();
            let [low, high] = [-step, step].map(|by| (values[k] + by).clamp(low, high));
            let at = |value: f64| {
                let mut moved = values.to_vec();
                moved[k] = value;
                self.predict(run, &moved)
            };
            let (above, below) = (at(high)?, at(low)?);
            Ok(above.iter().zip(&below).map(|(above, below)| (above - below) / (high - low)).collect())
        };
        (0..values.len()).map(by).collect()
    }
}

/// What counts as one of a number of `end`.
fn ones_of_end() -> Vec<f64> {
    (0..6).map(|i| ONE[i / 3]).collect()
}

/// What counts as one of a number of `gains`: a part of the rms of all three rates or velocities of all flights.
fn ones_of_gains(flown: &[Flown]) -> Result<Vec<f64>, Error> {
    let all = flown.iter().map(|flown| gains(&flown.record)).collect::<Result<Vec<_>, _>>()?;
    let count = 3 * PARTS;
    let rms = |three: usize| {
        let own = all.iter().flat_map(|gains| &gains[three * count..(three + 1) * count]);
        LOAD * (own.map(|x| x * x).sum::<f64>() / (all.len() * count) as f64).sqrt()
    };
    Ok((0..2 * count).map(|i| rms(i / count)).collect())
}

/// The numbers with which `of` fits the flights themselves best, from `start`, and what is left in parts of `ones`.
fn bound(
    flown: &[Flown],
    Calibrated { structure, parameters, values: start, .. }: &Calibrated,
    of: Of,
    ones: Vec<f64>,
) -> Result<(Vec<f64>, f64), Error> {
    let channels = ones.len();
    let layout = Layout { channels, harmonics: 0 };
    let observed = |flown: &Flown| Observed {
        name: format!("{} m/s", flown.speed),
        layout,
        cycles: vec![vec![0.0; channels]; 2],
        weights: vec![1.0; 2],
        mean: vec![0.0; channels],
        sample_noise: DMatrix::zeros(channels, channels),
        samples_per_cycle: 1.0,
        left_out: 0,
        oddities: Vec::new(),
        frequency_hz: 3.5,
        held_out: false,
        unmeasured: Vec::new(),
        common: Default::default(),
    };
    let runs: Vec<Observed> = flown.iter().map(observed).collect();
    let one = DMatrix::from_fn(channels, channels, |i, j| if i == j { ones[i].powi(2) } else { 0.0 });
    let own: Vec<Parameter> = parameters
        .iter()
        .zip(start)
        .map(|(parameter, start)| Parameter { start: *start, prior: None, ..parameter.clone() })
        .collect();
    let model = Flights { flown, structure: *structure, parameters, of };
    let problem = Problem::with_noise(&model, &runs, &own, vec![vec![one]; runs.len()]).map_err(no_answer)?;
    let watch = &mut |_: &Progress| ControlFlow::Continue(());
    let values = solve_problem(problem, &plan(false), &mut (), watch).map_err(no_answer)?.values;
    let mut left = 0.0;
    for run in 0..flown.len() {
        let apart = model.predict(run, &values).map_err(no_answer)?;
        left += apart.iter().zip(&ones).map(|(x, one)| (x / one).powi(2)).sum::<f64>();
    }
    Ok((values, (left / (flown.len() * channels) as f64).sqrt()))
}

fn plan(discrepancy: bool) -> Plan {
    Plan { starts: 1, spread: 0.0, seed: 0, discrepancy }
}

/// Numbers of the robot by name; the encoder's lag is the rig's.
pub(super) fn named(parameters: &[Parameter], values: &[f64]) -> Vec<(String, f64)> {
    let all = parameters.iter().zip(values).map(|(parameter, value)| (parameter.name.clone(), *value));
    all.filter(|(name, _)| name != "gait.phase_rad").collect()
}

/// A structure of the model fitted to the seven runs.
pub(super) struct Calibrated {
    pub structure: [&'static str; 2],
    pub parameters: Vec<Parameter>,
    pub values: Vec<f64>,
    /// Error in runs left out, in parts of what was measured.
    left_out: f64,
}

/// `structures` fitted to the same samples of a truth.
pub(super) fn calibrated(
    truth_is: [&str; 2],
    numbers: &[(String, f64)],
    structures: &[[&'static str; 2]],
) -> Result<Vec<Calibrated>, Error> {
    let on_rig = |keys: [String; 2]| keys.map(|key| format!("rig.{key}"));
    let overrides: Vec<String> =
        on_rig(aero(truth_is)).into_iter().chain(set("rig.robot.numbers", numbers)).collect();
    let overrides = format!("truth.set={overrides:?}");
    let calibration = shipped("seven_runs.toml", &["structures=[]", "starts=1", &overrides])?;
    let targets = truth(&calibration)?;
    let runs = measured(&calibration, &targets, &all_clean(&targets)?, 1)?;
    let one = |structure: &[&'static str; 2]| {
        let own = calibration.structure(&on_rig(aero(*structure)), &|_, _| None).map_err(no_answer)?;
        let watch = &mut |_: &Progress| ControlFlow::Continue(());
        let solved =
            solve(&own.model, &runs, &own.parameters, &plan(true), &mut (), watch).map_err(no_answer)?;
        let left_out = Rival::of("", &runs, &solved).map_err(no_answer)?.left_out_share;
        let values = solved.values.clone();
        Ok(Calibrated { structure: *structure, parameters: own.parameters.clone(), values, left_out })
    };
    structures.iter().map(one).collect()
}

fn flown(structure: [&str; 2], numbers: &[(String, f64)]) -> Result<Vec<Flown>, Error> {
    SPEEDS.iter().map(|speed| Flown::new(*speed, structure, numbers)).collect()
}

/// The right model: what is left of a chain without a fault.
fn right_model() -> Result<Vec<Row>, Error> {
    let numbers = RIGHT.map(|(name, value)| (name.to_owned(), value));
    let all = calibrated(STRUCTURES[0], &numbers, &STRUCTURES[..1])?;
    let Calibrated { structure, parameters, values, .. } = &all[0];
    let (drawn, after) = (drawn(parameters), named(parameters, values));
    let mut worst = [0.0_f64; 2];
    for flown in flown(STRUCTURES[0], &numbers)? {
        let ratio = ratios(&flown, *structure, &drawn, &after)?;
        worst = [worst[0].max(ratio[0]), worst[1].max(ratio[1])];
    }
    let source = "own truth (paper, linear, other numbers) and the same model under its inputs, one stroke";
    let metric = "median after over before, 20 draws +-20 %, the worse of 1.5 and 0.8 m/s";
    let row = |end: &str, what: &str, value: f64| {
        let id = format!("calibrate.flight.right_model{end}");
        Row::judged(&id, source, &format!("{what}: {metric}"), value, 1.0 / 3.0, "")
    };
    Ok(vec![row("", "attitude", worst[0]), row(".velocity", "velocity", worst[1])])
}

pub(super) fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    0.5 * (of[(of.len() - 1) / 2] + of[of.len() / 2])
}

/// After over before for attitude and velocity, median over the draws, from one speed.
fn ratios(
    flown: &Flown,
    structure: [&str; 2],
    drawn: &[Vec<(String, f64)>],
    after: &[(String, f64)],
) -> Result<[f64; 2], Error> {
    let after = flown.off(structure, after)?;
    let before = wingbeat::parallel::map(drawn, |_, numbers| flown.off(structure, numbers));
    let before = before.into_iter().collect::<Result<Vec<_>, _>>()?;
    Ok([0, 1].map(|i| median(before.iter().map(|before| after[i] / before[i]).collect())))
}

/// Numbers up to 20 % off those that the fit begins with.
pub(super) fn drawn(parameters: &[Parameter]) -> Vec<Vec<(String, f64)>> {
    let draw = |draw: usize| {
        let mut random = Random::stream(29, draw as u64);
        let one = |parameter: &Parameter| {
            let value = parameter.start + random.between(-OFF, OFF) * parameter.scale();
            value.clamp(parameter.low, parameter.high)
        };
        named(parameters, &parameters.iter().map(one).collect::<Vec<f64>>())
    };
    (0..DRAWS).map(draw).collect()
}

/// Medians over twenty draws of what is left after the fit, in parts of before; judged is the structure that predicts the seven runs
/// best, each left out.
pub fn rows() -> Result<Vec<Row>, Error> {
    let all = calibrated(TRUTH, &[], &STRUCTURES)?;
    let flown = flown(TRUTH, &[])?;
    let chosen = (0..all.len()).min_by(|a, b| all[*a].left_out.total_cmp(&all[*b].left_out)).unwrap_or(0);
    let source = "own truth (full, lev) and another model under its inputs, one stroke";
    let mut rows = right_model()?;
    for (k, model) in all.iter().enumerate() {
        let Calibrated { structure, parameters, values, left_out } = model;
        let nominal: Vec<f64> = parameters.iter().map(|parameter| parameter.start).collect();
        let drawn = drawn(parameters);
        let [preset, law] = structure;
        let runs = format!("{preset}, {law} (left out {:.1} %), numbers of the seven runs", 100.0 * left_out);
        let mut fits = vec![(runs, "", values.clone())];
        if k == 0 {
            let (ends, _) = bound(&flown, model, end, ones_of_end())?;
            let name = format!("{preset}, {law}, numbers of the ends of these flights themselves");
            fits.push((name, ".bound", ends));
        }
        let (loads, left) = bound(&flown, model, gains, ones_of_gains(&flown)?)?;
        let left = 100.0 * LOAD * left;
        let name = format!(
            "{preset}, {law}, numbers of the loads of these flights themselves, of which {left:.0} % are left"
        );
        fits.push((name, ".loads", loads));
        for (flown, at) in flown.iter().zip(["", ".runs_speed"]) {
            let plain = flown.off(*structure, &named(parameters, &nominal))?;
            for (name, kind, fitted) in &fits {
                let numbers = named(parameters, fitted);
                let after = flown.off(*structure, &numbers)?;
                let ratio = ratios(flown, *structure, &drawn, &numbers)?;
                let attitude = format!(
                    "attitude from {} m/s, {name}: median after over before, 20 draws +-20 %; {:.2} deg after, {:.2} \
                     deg without draws",
                    flown.speed,
                    after[0].to_degrees(),
                    plain[0].to_degrees()
                );
                let velocity = format!(
                    "velocity: the same; {:.3} m/s after, {:.3} m/s without draws",
                    after[1], plain[1]
                );
                let judged = k == chosen && at.is_empty() && kind.is_empty();
                let own = if judged { String::new() } else { format!(".{preset}_{law}") };
                let id = format!("calibrate.flight{own}{at}{kind}");
                let velocity_id = format!("{id}.velocity");
                if judged {
                    rows.push(Row::judged(&id, source, &attitude, ratio[0], 1.0 / 3.0, ""));
                    rows.push(Row::judged(&velocity_id, source, &velocity, ratio[1], 1.0 / 3.0, ""));
                } else {
                    rows.push(Row::shown(&id, source, &attitude, ratio[0], ""));
                    rows.push(Row::shown(&velocity_id, source, &velocity, ratio[1], ""));
                }
            }
        }
    }
    Ok(rows)
}
