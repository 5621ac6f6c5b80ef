//! From samples of the load cell to the cycles of a run; what is wrong with samples, and what would be right.

use crate::bins::Bins;
use crate::observed::{Common, RunRole};
use crate::problem::group;
use crate::rig::RigTarget;
use crate::tare::{Rest, Tare, clock, rest, share};
use crate::{Error, HarmonicLayout, ObservedCycles, Tilts, project};
use std::f64::consts::TAU;
use std::ops::Range;
use wingbeat::judge::limits::data::DEAD;
use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::netft::{StatusClass, classify};
use wingbeat::rig::process::{PhaseSource, Samples, fitted_phase, phase_of};
use wingbeat::simulate::Record;

/// Largest share by which the measured frequency may differ from the run's. *Choice.*
pub const FREQUENCY_TOLERANCE: f64 = 0.01;

/// Samples of one pass of a run.
#[derive(Clone, Debug)]
pub struct MeasuredPass {
    /// Where they come from.
    pub file: String,
    /// Time, s; the run begins at 0.
    pub time: Vec<f64>,
    /// Phase of the encoder, rad, without jumps; empty without one.
    pub phase: Vec<f64>,
    /// Fx .. Tz in the cell's frame, N and N m.
    pub channels: [Vec<f64>; 6],
    /// Status words of the box, bits without unit; empty when there are none.
    pub status: Vec<f64>,
    /// Time, and positions, rates and accelerations of the arm's joints; none where they are not recorded.
    pub motion: Option<Record>,
}

impl MeasuredPass {
    /// The columns t, Fx .. Tz, phase, status, and those of the joints of a record.
    ///
    /// # Errors
    /// A column that is missing.
    pub fn of(file: &str, record: Record) -> Result<Self, Error> {
        let motion = joints(&record);
        let Samples { time, phase, channels, status, .. } = Samples::from_record(record, "")?;
        Ok(Self { file: file.into(), time, phase, channels, status, motion })
    }
}

/// The columns of a record by which the joints of an arm move; none without the first joint.
fn joints(record: &Record) -> Option<Record> {
    record.column("q1")?;
    let of_joint = |name: &str| {
        let number = ["ddq", "dq", "q"].into_iter().find_map(|of| name.strip_prefix(of));
        number.is_some_and(|number| number.parse::<usize>().is_ok())
    };
    let columns = record.columns().iter().filter(|column| column.name == "t" || of_joint(&column.name));
    Record::new(columns.cloned().collect(), 0).ok()
}

/// What a pass gives.
struct Cycles {
    cycles: Vec<Vec<f64>>,
    /// What the noise of the rest puts into all of them.
    tare: Option<Tare>,
    left_out: usize,
    oddities: Vec<String>,
    frequency: f64,
    samples_per_cycle: f64,
}

/// The cycles of all passes of `target`.
///
/// # Errors
/// Samples that cannot be those of the run, with what would be right.
pub fn observed(
    target: &RigTarget,
    passes: &[MeasuredPass],
    role: RunRole,
    robust: bool,
) -> Result<ObservedCycles, Error> {
    for (k, pass) in passes.iter().enumerate() {
        let same = |other: &&MeasuredPass| other.channels == pass.channels;
        if let Some(other) = passes[..k].iter().find(same) {
            let what = format!("holds the very samples of {}: one pass counts once", other.file);
            return Err(Error::data(&pass.file, what));
        }
    }
    let mut bins = Bins::new();
    let parts = passes.iter().map(|pass| cycles_of(target, pass, &mut bins));
    let parts = parts.collect::<Result<Vec<Cycles>, _>>()?;
    let count = parts.len().max(1) as f64;
    let frequency_hz = parts.iter().map(|part| part.frequency).sum::<f64>() / count;
    let samples_per_cycle = parts.iter().map(|part| part.samples_per_cycle).sum::<f64>() / count;
    let left_out = parts.iter().map(|part| part.left_out).sum();
    let oddities = parts.iter().flat_map(|part| part.oddities.clone()).collect();
    let of = parts.iter().enumerate().flat_map(|(k, part)| std::iter::repeat_n(k, part.cycles.len()));
    let (of, tares): (Vec<usize>, Vec<Option<Tare>>) =
        (of.collect(), parts.iter().map(|part| part.tare.clone()).collect());
    let cycles: Vec<Vec<f64>> = parts.into_iter().flat_map(|part| part.cycles).collect();
    if cycles.is_empty() {
        let what = "no whole cycle without missing or saturated samples in the window";
        return Err(Error::data(&target.name, what));
    }
    let mut observed = ObservedCycles {
        name: target.name.clone(),
        layout: target.layout(),
        cycles,
        weights: Vec::new(),
        mean: Vec::new(),
        sample_noise: bins.covariance(),
        samples_per_cycle,
        left_out,
        oddities,
        found: Vec::new(),
        frequency_hz,
        role,
        unmeasured: Vec::new(),
        common: Common {
            groups: if target.tilts().is_some() { of.clone() } else { Vec::new() },
            ..Common::default()
        },
    };
    observed.weigh(robust);
    share(&mut observed, &of, &tares);
    Ok(observed)
}

fn cycles_of(target: &RigTarget, pass: &MeasuredPass, bins: &mut Bins) -> Result<Cycles, Error> {
    let rows = window(target, pass)?;
    let range = target.run.spec.rig.cell.calibration.range();
    let outside = target.run.outside(&pass.time, &pass.channels, &pass.status, target.window().1);
    let outside = outside.map_err(|error| Error::data(&pass.file, target.run.explain(&error).to_string()))?;
    let finite = |k: usize| pass.channels.iter().all(|channel| channel[k].is_finite());
    let mut usable: Vec<bool> = (0..pass.time.len()).map(finite).collect();
    outside.rows.iter().for_each(|row| usable[*row] = false);
    let oddities = clipped(pass, rows.clone().filter(|k| usable[*k]), &range);
    let rest = rest(target, pass, &usable)?;
    let lines = rest.as_ref().map_or([(0.0, 0.0); 6], |rest| rest.lines);
    let mut channels: [Vec<f64>; 6] = Default::default();
    // One sample more on both sides.
    let (from, to) = (rows.start.saturating_sub(1), (rows.end + 1).min(pass.time.len()));
    for k in from..to {
        let raw = std::array::from_fn(|i| {
            let (offset, slope) = lines[i];
            pass.channels[i][k] - offset - slope * pass.time[k]
        });
        let body = if usable[k] { target.in_body(raw) } else { [f64::NAN; 6] };
        channels.iter_mut().zip(body).for_each(|(channel, x)| channel.push(x));
    }
    let read = TaredPass { target, pass, rows, usable, from, channels, rest, oddities };
    match target.tilts() {
        Some(tilts) => Ok(read.tilted(tilts, bins)),
        None => read.flapped(bins),
    }
}

/// The samples of `pass` over which the run is averaged.
fn window(target: &RigTarget, pass: &MeasuredPass) -> Result<Range<usize>, Error> {
    let (begin, end) = target.window();
    let from = pass.time.partition_point(|t| *t < begin - 1e-9);
    let to = pass.time.partition_point(|t| *t <= end + 1e-9);
    if from + 16 > to {
        let (first, last) = (pass.time.first().unwrap_or(&0.0), pass.time.last().unwrap_or(&0.0));
        let what = format!(
            "samples from {first:.3} to {last:.3} s: the run {} is averaged from {begin:.3} to {end:.3} s \
             (process.input.start_s says when the run begins)",
            target.name
        );
        return Err(Error::data(&pass.file, what));
    }
    Ok(from..to)
}

/// A pass less its tare, in the body's axes.
struct TaredPass<'a> {
    target: &'a RigTarget,
    pass: &'a MeasuredPass,
    /// Samples over which the run is averaged.
    rows: Range<usize>,
    /// Which samples are there and not left out.
    usable: Vec<bool>,
    /// The sample with which `channels` begin.
    from: usize,
    /// Loads; NaN where a sample cannot be used.
    channels: [Vec<f64>; 6],
    rest: Option<Rest>,
    oddities: Vec<String>,
}

impl TaredPass<'_> {
    /// The parts of a pass through attitudes.
    fn tilted(mut self, tilts: Tilts, bins: &mut Bins) -> Cycles {
        let time = &self.pass.time[self.from..][..self.channels[0].len()];
        let load = |k: usize| self.channels[0][k].is_finite().then(|| self.channels.each_ref().map(|x| x[k]));
        let all = tilts.cycles(time, &load);
        for (k, t) in time.iter().enumerate() {
            if let (Some(phase), Some(load)) = (tilts.phase(*t), load(k)) {
                bins.add(phase, load);
            }
        }
        let left_out = all.iter().filter(|cycle| cycle.is_none()).count();
        if left_out > 0 {
            let what = unusable(self.target, self.pass, self.rows.clone());
            self.oddities.push(format!(
                "{}: {what}: {left_out} of {} parts of each attitude are left out",
                self.pass.file,
                all.len()
            ));
        }
        Cycles {
            tare: self.tare(&tilts.clock()),
            cycles: all.into_iter().flatten().collect(),
            left_out,
            oddities: self.oddities,
            frequency: 0.0,
            samples_per_cycle: tilts.samples(self.target.run.spec.rig.cell.rate_hz),
        }
    }

    /// The whole strokes of a pass.
    fn flapped(mut self, bins: &mut Bins) -> Result<Cycles, Error> {
        let Self { target, pass, channels, .. } = &self;
        let wrong = |what: String| Error::data(&pass.file, what);
        let layout = target.layout();
        let first = self.rows.start - self.from;
        let phase = phases(target, pass, &channels[2], self.from, channels[2].len())?;
        let last = (first + self.rows.len() - 1).min(phase.len() - 1);
        let time = |k: usize| pass.time[self.from + k];
        let turns = (phase[last] - phase[first]) / TAU;
        let frequency = turns / (time(last) - time(first));
        let wanted = target.run.frequency();
        if !((frequency / wanted - 1.0).abs() <= FREQUENCY_TOLERANCE) {
            return Err(wrong(format!(
                "the wings beat at {frequency:.4} Hz: the run {} says {wanted} Hz; if this is its file, set = \
                 [\"frequency_hz={frequency:.4}\"]",
                target.name
            )));
        }
        let whole = (turns + 1e-6).floor() as usize;
        let begin = phase[first];
        let all: Vec<Option<Vec<f64>>> = (0..whole)
            .map(|cycle| project(&phase, channels, begin + TAU * cycle as f64, layout.harmonics))
            .collect();
        let left_out = all.iter().filter(|cycle| cycle.is_none()).count();
        let some_bad = self.usable[self.rows.clone()].contains(&false);
        let what = || unusable(target, pass, self.rows.clone());
        if some_bad && left_out == 0 || left_out == whole {
            return Err(wrong(format!("{}: no cycle is left", what())));
        }
        let told = (left_out > 0)
            .then(|| format!("{}: {}: {left_out} of {whole} cycles are left out", pass.file, what()));
        for k in first..last {
            bins.add(phase[k], std::array::from_fn(|i| channels[i][k]));
        }
        let clock = clock(layout, (begin, frequency), 0.5 * (time(first) + time(last)));
        let tare = self.tare(&clock);
        let samples_per_cycle = (last - first) as f64 / turns;
        self.oddities.extend(told);
        let cycles = all.into_iter().flatten().collect();
        Ok(Cycles { tare, cycles, left_out, oddities: self.oddities, frequency, samples_per_cycle })
    }

    /// What the noise of the rest puts into all cycles of the pass, of which `clock` is the time.
    fn tare(&self, clock: &[f64]) -> Option<Tare> {
        self.rest.as_ref().map(|rest| rest.tare(self.target, self.target.layout(), clock))
    }
}

/// What of the samples `rows` cannot be used, by channel.
fn unusable(target: &RigTarget, pass: &MeasuredPass, rows: Range<usize>) -> String {
    let calibration = target.run.spec.rig.cell.calibration;
    let range = calibration.range();
    let mut told = Vec::new();
    for (i, (name, unit)) in CHANNELS.iter().enumerate() {
        let count = |bad: &dyn Fn(f64) -> bool| rows.clone().filter(|k| bad(pass.channels[i][*k])).count();
        let missing = count(&|x| !x.is_finite());
        let full = count(&|x| x.is_finite() && x.abs() >= range[i] * (1.0 - 1e-9));
        if missing > 0 {
            told.push(format!("{missing} of {name} are missing"));
        }
        if full > 0 {
            told.push(format!(
                "{full} of {name} are at the end of the cell's range, {} {unit} ({calibration:?})",
                range[i]
            ));
        }
    }
    let bad = |k: &usize| pass.status.get(*k).is_some_and(|word| classify(*word as u32) != StatusClass::Good);
    let by_box = rows.clone().filter(bad).count();
    if by_box > 0 {
        told.push(format!("{by_box} are not to be trusted by the status words of the box"));
    }
    format!("of {} samples {}", rows.len(), told.join(", "))
}

/// Share of the samples that stand at one and the same extreme from which a channel is called clipped. *Choice*: noise
/// reaches an extreme once.
const CLIPPED: f64 = 0.03;

/// Channels that, at the samples `rows`, stand at their highest or lowest value within the range for longer than noise lets them.
fn clipped(pass: &MeasuredPass, rows: impl Iterator<Item = usize> + Clone, range: &[f64; 6]) -> Vec<String> {
    let mut told = Vec::new();
    for (i, (name, unit)) in CHANNELS.iter().enumerate() {
        let values = || rows.clone().map(|k| pass.channels[i][k]);
        for end in [values().fold(f64::NEG_INFINITY, f64::max), values().fold(f64::INFINITY, f64::min)] {
            let (count, all) = (values().filter(|x| *x == end).count(), values().count());
            let flat = values().all(|x| x == end);
            if !flat && end.abs() < range[i] * (1.0 - 1e-9) && count as f64 > CLIPPED * all as f64 {
                told.push(format!(
                    "{}: {count} of {all} samples of {name} stand at {end} {unit}: clipped before the end of the cell's range?",
                    pass.file
                ));
            }
        }
    }
    told
}

/// Phase of the samples `from ..` on, `count` of them.
fn phases(
    target: &RigTarget,
    pass: &MeasuredPass,
    force: &[f64],
    from: usize,
    count: usize,
) -> Result<Vec<f64>, Error> {
    let time = &pass.time[from..from + count];
    let source = target.run.spec.process.phase;
    if source != PhaseSource::Encoder {
        let spin_up = 0.5 * target.run.spec.rig.spin_up_s;
        let shifted: Vec<f64> = time.iter().map(|t| t - spin_up).collect();
        return Ok(phase_of(source, &shifted, Vec::new(), force, target.run.frequency())?);
    }
    if pass.phase.len() != pass.time.len() {
        let what = "no column of phase: process.phase = \"force\" or \"frequency\" does without an encoder";
        return Err(Error::data(&pass.file, what));
    }
    let step = (pass.time[pass.time.len() - 1] - pass.time[0]) / (pass.time.len() - 1) as f64;
    let whole = fitted_phase(pass.phase.clone(), step, target.run.frequency());
    let window = (time[0], time[time.len() - 1]);
    let turned = target.run.check_sense(&pass.time, &whole, window);
    turned.map_err(|error| Error::data(&pass.file, target.run.explain(&error).to_string()))?;
    let phase = whole[from..from + count].to_vec();
    match phase.windows(2).position(|pair| !(pair[1] > pair[0])) {
        None => Ok(phase),
        Some(k) => {
            let what = format!("the phase does not ascend at t = {:.4} s", time[k]);
            Err(Error::data(&pass.file, what))
        }
    }
}

/// A shift of phase between measurement and model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseShift {
    /// By how much the measured cycle is behind the model's, rad.
    pub by: f64,
    /// Correlation of the harmonics as they are and when shifted.
    pub correlation: [f64; 2],
    /// What the correlation of the measured cycle with itself loses by the shift.
    pub own_loss: f64,
}

/// Correlation of two cycles without their means, channels in parts of their measured amplitude, with the measured one
/// moved ahead by `shift` rad.
fn correlation(layout: HarmonicLayout, measured: &[f64], model: &[f64], shift: f64) -> f64 {
    let mut sums = [0.0; 3];
    for channel in 0..layout.channels {
        let weight = layout.mean_square(measured, channel).max(f64::MIN_POSITIVE).recip();
        for k in 1..=layout.harmonics {
            let (i, j) = (layout.at(channel, 2 * k - 1), layout.at(channel, 2 * k));
            let (sin, cos) = (k as f64 * shift).sin_cos();
            let moved = [measured[i] * cos + measured[j] * sin, measured[j] * cos - measured[i] * sin];
            sums[0] += weight * (moved[0] * model[i] + moved[1] * model[j]);
            sums[1] += weight * (moved[0].powi(2) + moved[1].powi(2));
            sums[2] += weight * (model[i].powi(2) + model[j].powi(2));
        }
    }
    sums[0] / (sums[1] * sums[2]).sqrt().max(f64::MIN_POSITIVE)
}

/// The shift at which measurement and model agree best, both in the units of the channels.
pub fn shift(layout: HarmonicLayout, measured: &[f64], model: &[f64]) -> PhaseShift {
    let at = |by: f64| correlation(layout, measured, model, by);
    let steps = (-720..720).map(|k| f64::from(k) * 0.25_f64.to_radians());
    let by = steps.max_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(0.0);
    let own_loss = 1.0 - correlation(layout, measured, measured, by);
    PhaseShift { by, correlation: [at(0.0), at(by)], own_loss }
}

/// Axes of the cell that were swapped or flipped: for each channel the measured one that it should be, and its sign.
pub type CellAxes = [(usize, f64); 6];

/// What a changed axis must bring at least, in parts of the whole agreement. *Choice*: quiet axes say nothing.
const TELLING: f64 = 0.03;
/// What all changed axes must bring together. *Choice*: a model may be wrong by half.
const CONVINCING: f64 = 0.4;

/// Mean square of a channel over the cycle about its mean, in the square of its unit.
pub fn variation(layout: HarmonicLayout, cycle: &[f64], channel: usize) -> f64 {
    (1..layout.width())
        .map(|part| HarmonicLayout::share(part) * cycle[layout.at(channel, part)].powi(2))
        .sum()
}

/// Share of the largest channel of the model of its kind from which one that does not move is dead. *Choice.*
const MOVES: f64 = 0.2;

/// Channels of the measured cycle, in their units, that stand still where the model moves them; of six.
pub fn dead(layout: HarmonicLayout, measured: &[f64], model: &[f64]) -> Vec<usize> {
    let swing = |cycle: &[f64], channel: usize| variation(layout, cycle, channel).sqrt();
    let stands = |channel: &usize| {
        let largest = group(layout, *channel).map(|other| swing(model, other)).fold(0.0, f64::max);
        let own = swing(model, *channel);
        own > MOVES * largest && swing(measured, *channel) < DEAD.value * own
    };
    (0..layout.channels).filter(stands).collect()
}

/// Axes with which the measured cycle, in the units of the channels, agrees with the model much better than as they are; none
/// where they are right. Forces and moments are turned apart from each other: a plug may be wrong, as may a sign in a file.
pub fn axes(layout: HarmonicLayout, measured: &[f64], model: &[f64]) -> Option<CellAxes> {
    if layout.channels != 6 {
        return None;
    }
    let product = |a: &[f64], i: usize, b: &[f64], j: usize| -> f64 {
        (1..layout.width()).map(|part| a[layout.at(i, part)] * b[layout.at(j, part)]).sum()
    };
    let mut found: CellAxes = std::array::from_fn(|i| (i, 1.0));
    let mut convinced = false;
    for three in [0, 3] {
        let size = |of: &[f64]| (three..three + 3).map(|i| product(of, i, of, i)).sum::<f64>();
        let scale = (size(measured) * size(model)).sqrt().max(f64::MIN_POSITIVE);
        let agreement =
            |ours: usize, theirs: usize| product(model, three + ours, measured, three + theirs) / scale;
        // Of each axis the better sign, less what a change must bring.
        let gain = |ours: usize, theirs: usize| {
            let agrees = agreement(ours, theirs);
            let changed = ours != theirs || agrees < 0.0;
            let kept = if ours == theirs { agrees } else { f64::NEG_INFINITY };
            if changed { (agrees.abs() - TELLING).max(kept) } else { agrees }
        };
        let score = |order: [usize; 3]| -> f64 { (0..3).map(|i| gain(i, order[i])).sum() };
        let now: f64 = (0..3).map(|i| agreement(i, i)).sum();
        let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let Some(best) = orders.into_iter().max_by(|a, b| score(*a).total_cmp(&score(*b))) else { continue };
        if score(best) - now < CONVINCING {
            continue;
        }
        convinced = true;
        for i in 0..3 {
            let agrees = agreement(i, best[i]);
            let flipped = agrees < 0.0 && agrees.abs() - TELLING > agrees;
            found[three + i] = (three + best[i], if flipped && -agrees > TELLING { -1.0 } else { 1.0 });
        }
    }
    convinced.then_some(found)
}
