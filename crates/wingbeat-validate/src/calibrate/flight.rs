//! What a calibration is worth in flight: truth and model under the same inputs, before and after the fit.

use super::learned::Learned;
use super::stroke::Turn;
use super::{all_clean, measured, no_answer, shipped, truth};
use crate::{Error, Row};
use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::math::Random;
use wingbeat::scenario::{ParameterSpec, Scenario};
use wingbeat::simulate::{Controller, Measurement, Record, Update};
use wingbeat_calibrate::{Parameter, Plan, Progress, Rival, solve};

/// Draws of the numbers before the fit.
const DRAWS: usize = 20;
/// Share by which they are off.
const OFF: f64 = 0.2;
/// One stroke at 3.5 Hz, s, in whole records.
const CYCLE: f64 = 0.286;
/// Period of the controller, s: that of the scenario.
const PERIOD: f64 = 0.005;
/// Speeds at the start of the flights of the Beta, which falls at 3.5 Hz, m/s: that of the scenario, and that of the runs.
const SPEEDS: [f64; 2] = [1.5, 0.8];
/// Strokes of the turn that carries its weight: begin, s; where; what ids end with.
const STROKES: [(f64, &str, &str); 3] =
    [(1.5, "level", ".level"), (2.0, "entering the turn", ".entering"), (3.5, "in the turn", ".turning")];
/// What may be left where the truth follows itself: deg, m/s. *Choice.*
const ITSELF: [f64; 2] = [0.1, 0.01];
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

fn column<'a>(record: &'a Record, name: &str) -> Result<&'a [f64], Error> {
    let values = record.values(name).filter(|values| !values.is_empty());
    values.ok_or_else(|| no_answer(format!("no column {name}")))
}

fn norm(of: &[f64]) -> f64 {
    of.iter().map(|x| x * x).sum::<f64>().sqrt()
}

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

    /// Attitude, rad, and velocity, m/s, by which they are apart.
    fn off(&self, structure: [&str; 2], numbers: &[(String, f64)]) -> Result<[f64; 2], Error> {
        let model = scenario(self.speed, structure, numbers)?;
        let mut again = Again::of(&self.record);
        let run = model.fly_with(&mut again, PERIOD, model.sensors(), |_| ControlFlow::Continue(()));
        let (own, truth) = (end(&run.map_err(no_answer)?.record)?, end(&self.record)?);
        let apart: Vec<f64> = own.iter().zip(truth).map(|(own, truth)| own - truth).collect();
        Ok([norm(&apart[..3]), norm(&apart[3..])])
    }
}

fn plan(discrepancy: bool) -> Plan {
    Plan { starts: 1, spread: 0.0, seed: 0, discrepancy }
}

/// Numbers of the robot by name; the encoder's lag is the rig's.
pub(super) fn named(parameters: &[Parameter], values: &[f64]) -> Vec<(String, f64)> {
    let all = parameters.iter().zip(values).map(|(parameter, value)| (parameter.name.clone(), *value));
    all.filter(|(name, _)| name != "gait.phase_rad").collect()
}

/// The numbers of a law, which are fitted with those that the calibration names.
pub(super) fn of_law(law: &str) -> Vec<ParameterSpec> {
    let number = |name: &str, low: f64, high: f64| ParameterSpec {
        name: format!("surfaces.wing.{name}"),
        start: None,
        low: Some(low),
        high: Some(high),
        prior: None,
        held: false,
        stage: 1,
    };
    let all = [number("stall_angle_rad", 0.05, 1.2), number("critical_suction", 0.01, 1.0)];
    let count = match law {
        "lev" => 2,
        "stall" => 1,
        _ => 0,
    };
    all.into_iter().take(count).collect()
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
        let mut own = shipped("seven_runs.toml", &["structures=[]"])?;
        own.spec.parameters.extend(of_law(structure[1]));
        let own = own.structure(&on_rig(aero(*structure)), &|_, _| None).map_err(no_answer)?;
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
        let off = |numbers: &[(String, f64)]| flown.off(*structure, numbers);
        worst = worse(worst, over_before(off(&after)?, &off, &drawn)?);
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

/// By how much a model with these numbers is off the truth: angle, rad, and velocity, m/s.
type Off<'a> = dyn Fn(&[(String, f64)]) -> Result<[f64; 2], Error> + Sync + 'a;

/// `after` over what the model is off with each of the drawn numbers: the median.
fn over_before(after: [f64; 2], off: &Off, drawn: &[Vec<(String, f64)>]) -> Result<[f64; 2], Error> {
    let before = wingbeat::parallel::map(drawn, |_, numbers| off(numbers));
    let before = before.into_iter().collect::<Result<Vec<_>, _>>()?;
    Ok([0, 1].map(|i| median(before.iter().map(|before| after[i] / before[i]).collect())))
}

/// The larger of each; no number where there is none.
fn worse(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| if a[i].is_nan() || b[i].is_nan() { f64::NAN } else { a[i].max(b[i]) })
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

/// What is asked of a structure, by the worst of the strokes.
fn judged(kind: &str, [preset, law]: [&str; 2], worst: [f64; 2]) -> [Row; 2] {
    let source = "own truth (full, lev) and another model under its inputs, one stroke";
    let with = if kind.is_empty() { "" } else { " with a learned wrench" };
    let metric = format!(
        "{preset}, {law}{with}: median after over before, 20 draws +-20 %, the worst of three strokes"
    );
    ["attitude", "velocity"].map(|what| {
        let (end, value) = if what == "attitude" { ("", worst[0]) } else { (".velocity", worst[1]) };
        let id = format!("calibrate.flight{kind}{end}");
        Row::judged(&id, source, &format!("{what}, {metric}"), value, 1.0 / 3.0, "")
    })
}

/// Rows of a structure in one flight.
fn rows_of(model: &Calibrated, flight: &str, suffix: &str, off: &Off) -> Result<[Row; 2], Error> {
    let Calibrated { structure: [preset, law], parameters, values, left_out } = model;
    let after = off(&named(parameters, values))?;
    let ratio = over_before(after, off, &drawn(parameters))?;
    let source = "own truth (full, lev) and another model under its inputs, one stroke";
    let fit = format!("{preset}, {law} (left out {:.1} %), numbers of the seven runs", 100.0 * left_out);
    let median = "median after over before, 20 draws +-20 %";
    let id = format!("calibrate.flight.{preset}_{law}{suffix}");
    let attitude = format!("attitude {flight}, {fit}: {median}; {:.2} deg after", after[0].to_degrees());
    let velocity = format!("velocity: the same; {:.3} m/s after", after[1]);
    Ok([
        Row::shown(&id, source, &attitude, ratio[0], ""),
        Row::shown(&format!("{id}.velocity"), source, &velocity, ratio[1], ""),
    ])
}

/// The same with what the fitted model leaves on nine stands of the robot that flies, learned and flown beside it.
fn with_learned(model: &Calibrated, turn: &Turn) -> Result<Vec<Row>, Error> {
    let Calibrated { structure, parameters, values, .. } = model;
    let [preset, law] = structure;
    let learned = Learned::new(model, turn.frequency_hz())?;
    let (fitted, before) = (named(parameters, values), drawn(parameters));
    let source = "own truth (full, lev) and another model with a learned wrench under its inputs, one stroke";
    let mut rows = Vec::new();
    for (begin, when, suffix) in STROKES {
        let after = turn.off(begin, *structure, &fitted, Some(&learned))?;
        let off = |numbers: &[(String, f64)]| turn.off(begin, *structure, numbers, None);
        let ratio = over_before(after, &off, &before)?;
        let id = format!("calibrate.flight.{preset}_{law}.learned{suffix}");
        let attitude = format!(
            "attitude {when}, {preset}, {law}, numbers of the seven runs and a wrench learned on nine stands, {:.0} % missed of one left out: \
             median after over before; {:.2} deg after",
            100.0 * learned.left,
            after[0].to_degrees()
        );
        let velocity = format!("velocity: the same; {:.3} m/s after", after[1]);
        rows.push(Row::shown(&id, source, &attitude, ratio[0], ""));
        rows.push(Row::shown(&format!("{id}.velocity"), source, &velocity, ratio[1], ""));
    }
    Ok(rows)
}

/// Medians over twenty draws of what is left after the fit, in parts of before. Judged is the structure that predicts the seven runs
/// best, each left out, by the worst of three strokes of a turn that carries its weight.
pub fn rows() -> Result<Vec<Row>, Error> {
    let all = calibrated(TRUTH, &[], &STRUCTURES)?;
    let chosen = all.iter().min_by(|a, b| a.left_out.total_cmp(&b.left_out));
    let chosen = chosen.ok_or_else(|| no_answer("no structure"))?.structure;
    let (turn, falling) = (Turn::new()?, flown(TRUTH, &[])?);
    let mut rows = right_model()?;
    let source = "own truth (full, lev), its air found again, under its own inputs, one stroke";
    for (begin, when, suffix) in STROKES {
        let own = turn.off(begin, TRUTH, &[], None)?;
        let attitude = format!("attitude {when}, the truth itself");
        let id = format!("calibrate.flight.itself{suffix}");
        rows.push(Row::judged(&id, source, &attitude, own[0].to_degrees(), ITSELF[0], "deg"));
        rows.push(Row::judged(
            &format!("{id}.velocity"),
            source,
            "velocity: the same",
            own[1],
            ITSELF[1],
            "m/s",
        ));
    }
    for model in &all {
        let mut worst = [0.0_f64; 2];
        for (begin, when, suffix) in STROKES {
            let own =
                rows_of(model, when, suffix, &|numbers| turn.off(begin, model.structure, numbers, None))?;
            worst = worse(worst, [own[0].value, own[1].value]);
            rows.extend(own);
        }
        let learned = with_learned(model, &turn)?;
        if model.structure == chosen {
            let all = learned.chunks(2).map(|pair| [pair[0].value, pair[1].value]);
            rows.extend(judged("", chosen, worst));
            rows.extend(judged(".learned", chosen, all.fold([0.0; 2], worse)));
        }
        rows.extend(learned);
        for (flown, suffix) in falling.iter().zip([".falling", ".falling_slowly"]) {
            let when = format!("falling from {} m/s", flown.speed);
            rows.extend(rows_of(model, &when, suffix, &|numbers| flown.off(model.structure, numbers))?);
        }
    }
    Ok(rows)
}
