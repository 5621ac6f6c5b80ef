//! From samples of the load cell to the cycles of a run; what is wrong with samples, and what would be right.

use crate::observed::Common;
use crate::rig::{RigTarget, SETTLING};
use crate::{Error, Layout, Observed, project};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::ops::Range;
use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::process::{PhaseSource, Samples, phase_of, tare_line};
use wingbeat::simulate::Record;

/// Largest share by which the measured frequency may differ from the run's. *Choice.*
pub const FREQUENCY_TOLERANCE: f64 = 0.01;
/// Phases by which the scatter from sample to sample is taken.
const BINS: usize = 128;

/// Samples of one pass of a run.
#[derive(Clone, Debug)]
pub struct Pass {
    /// Where they come from.
    pub file: String,
    /// Time, s; the run begins at 0.
    pub time: Vec<f64>,
    /// Phase of the encoder, rad, ascending; empty without one.
    pub phase: Vec<f64>,
    /// Fx .. Tz in the cell's frame.
    pub channels: [Vec<f64>; 6],
}

impl Pass {
    /// The columns t, Fx .. Tz and phase of a record.
    ///
    /// # Errors
    /// A column that is missing.
    pub fn of(file: &str, record: Record) -> Result<Self, Error> {
        let samples = Samples::from_record(record, "")?;
        Ok(Self { file: file.into(), time: samples.time, phase: samples.phase, channels: samples.channels })
    }
}

/// What a pass gives.
struct Cycles {
    cycles: Vec<Vec<f64>>,
    /// Covariance of what the noise of the rest puts into all of them.
    tare: Option<DMatrix<f64>>,
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
    passes: &[Pass],
    held_out: bool,
    robust: bool,
) -> Result<Observed, Error> {
    for (k, pass) in passes.iter().enumerate() {
        let same = |other: &&Pass| other.channels == pass.channels;
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
    let (of, tares): (Vec<usize>, Vec<Option<DMatrix<f64>>>) =
        (of.collect(), parts.iter().map(|part| part.tare.clone()).collect());
    let cycles: Vec<Vec<f64>> = parts.into_iter().flat_map(|part| part.cycles).collect();
    if cycles.is_empty() {
        let what = "no whole cycle without missing or saturated samples in the window";
        return Err(Error::data(&target.name, what));
    }
    let mut observed = Observed {
        name: target.name.clone(),
        layout: target.layout(),
        cycles,
        weights: Vec::new(),
        mean: Vec::new(),
        sample_noise: bins.covariance(),
        samples_per_cycle,
        left_out,
        oddities,
        frequency_hz,
        held_out,
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

/// Sets what the cycles have in common: `of` says of which pass each is, `tares` what the tare of each pass puts into its cycles.
/// The passes' tares are independent: of a mean with the weights w the covariance is the sum over the passes of (sum w / sum of all w)^2
/// times theirs.
fn share(observed: &mut Observed, of: &[usize], tares: &[Option<DMatrix<f64>>]) {
    let total: f64 = observed.weights.iter().sum();
    let size = observed.layout.len();
    let (mut mean, mut pass, mut known) = (DMatrix::zeros(size, size), DMatrix::zeros(size, size), 0.0);
    for (k, tare) in tares.iter().enumerate() {
        let Some(tare) = tare else { continue };
        let own = observed.weights.iter().zip(of).filter(|(_, of)| **of == k);
        let share = own.map(|(weight, _)| weight).sum::<f64>() / total;
        mean += tare * (share * share);
        pass += tare;
        known += 1.0;
    }
    if known > 0.0 {
        (observed.common.mean, observed.common.pass) = (Some(mean), Some(pass / known));
    }
}

fn cycles_of(target: &RigTarget, pass: &Pass, bins: &mut Bins) -> Result<Cycles, Error> {
    let wrong = |what: String| Error::data(&pass.file, what);
    let (begin, end) = target.window();
    let from = pass.time.partition_point(|t| *t < begin - 1e-9);
    let to = pass.time.partition_point(|t| *t <= end + 1e-9);
    if from + 16 > to {
        let (first, last) = (pass.time.first().unwrap_or(&0.0), pass.time.last().unwrap_or(&0.0));
        return Err(wrong(format!(
            "samples from {first:.3} to {last:.3} s: the run {} is averaged from {begin:.3} to {end:.3} s \
             (process.input.start_s says when the run begins)",
            target.name
        )));
    }
    let range = target.run.spec.rig.cell.calibration.range();
    let usable = |k: usize| {
        (0..6).all(|i| pass.channels[i][k].is_finite() && pass.channels[i][k].abs() < range[i] * (1.0 - 1e-9))
    };
    let bad = (from..to).filter(|k| !usable(*k)).count();
    let mut oddities = clipped(pass, from..to, &range);
    let rest = rest(target, pass)?;
    let lines = rest.as_ref().map_or([(0.0, 0.0); 6], |rest| rest.lines);
    let mut channels: [Vec<f64>; 6] = Default::default();
    for k in from.saturating_sub(1)..(to + 1).min(pass.time.len()) {
        let raw = std::array::from_fn(|i| {
            let (offset, slope) = lines[i];
            pass.channels[i][k] - offset - slope * pass.time[k]
        });
        let body = if usable(k) { target.in_body(raw) } else { [f64::NAN; 6] };
        channels.iter_mut().zip(body).for_each(|(channel, x)| channel.push(x));
    }
    if let Some(tilts) = target.tilts() {
        let time = &pass.time[from.saturating_sub(1)..];
        let time = &time[..channels[0].len()];
        let load = |k: usize| channels[0][k].is_finite().then(|| channels.each_ref().map(|x| x[k]));
        let all = tilts.cycles(time, &load);
        let left_out = all.iter().filter(|cycle| cycle.is_none()).count();
        if left_out > 0 {
            let what = unusable(target, pass, from..to);
            oddities.push(format!(
                "{}: {what}: {left_out} of {} parts of each attitude are left out",
                pass.file,
                all.len()
            ));
        }
        for (k, t) in time.iter().enumerate() {
            if let (Some(phase), Some(load)) = (tilts.phase(*t), load(k)) {
                bins.add(phase, load);
            }
        }
        let layout = target.layout();
        return Ok(Cycles {
            tare: rest.map(|rest| rest.covariance(target, layout, &tilts.clock())),
            cycles: all.into_iter().flatten().collect(),
            left_out,
            oddities,
            frequency: 0.0,
            samples_per_cycle: tilts.samples(target.run.spec.rig.cell.rate_hz),
        });
    }
    let first = from - from.saturating_sub(1);
    let phase = phases(target, pass, &channels[2], from.saturating_sub(1), channels[2].len())?;
    let last = (first + to - from - 1).min(phase.len() - 1);
    let time = |k: usize| pass.time[from.saturating_sub(1) + k];
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
        .map(|cycle| project(&phase, &channels, begin + TAU * cycle as f64, target.layout().harmonics))
        .collect();
    let left_out = all.iter().filter(|cycle| cycle.is_none()).count();
    let saturated_or_missing = bad > 0 && left_out == 0;
    if saturated_or_missing || left_out == whole {
        return Err(wrong(format!("{}: no cycle is left", unusable(target, pass, from..to))));
    }
    if left_out > 0 {
        let what = unusable(target, pass, from..to);
        oddities.push(format!("{}: {what}: {left_out} of {whole} cycles are left out", pass.file));
    }
    for k in first..last {
        bins.add(phase[k], std::array::from_fn(|i| channels[i][k]));
    }
    let layout = target.layout();
    let clock = clock(layout, (begin, frequency), 0.5 * (time(first) + time(last)));
    Ok(Cycles {
        tare: rest.map(|rest| rest.covariance(target, layout, &clock)),
        cycles: all.into_iter().flatten().collect(),
        left_out,
        oddities,
        frequency,
        samples_per_cycle: (last - first) as f64 / turns,
    })
}

/// What of the samples `rows` cannot be used, by channel.
fn unusable(target: &RigTarget, pass: &Pass, rows: Range<usize>) -> String {
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
    format!("of {} samples {}", rows.len(), told.join(", "))
}

/// Share of the samples that stand at one and the same extreme from which a channel is called clipped. *Choice*: noise
/// reaches an extreme once.
const CLIPPED: f64 = 0.03;

/// Channels that stand at their highest or lowest value within the range for longer than noise lets them.
fn clipped(pass: &Pass, rows: Range<usize>, range: &[f64; 6]) -> Vec<String> {
    let mut told = Vec::new();
    for (i, (name, unit)) in CHANNELS.iter().enumerate() {
        let values = || rows.clone().map(|k| pass.channels[i][k]).filter(|x| x.is_finite());
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

/// The rest before a run.
struct Rest {
    /// Offset at t = 0 and slope of each channel.
    lines: [(f64, f64); 6],
    /// Covariance of the channels' noise per sample, as far as it does not average out from sample to sample.
    noise: DMatrix<f64>,
    /// (X'X)^-1 of offset and slope: variances and covariance of both for noise of 1 per sample.
    spread: [f64; 3],
}

/// Batches of the rest by whose means its noise is told: what is correlated from sample to sample is uncorrelated from batch to
/// batch. *Choice.*
const BATCHES: usize = 24;

/// Offset and slope of each channel over the rest, as it is read; none where the run takes no tare.
fn rest(target: &RigTarget, pass: &Pass) -> Result<Option<Rest>, Error> {
    if !target.tared() {
        return Ok(None);
    }
    let end = pass.time.partition_point(|t| *t < -1e-9);
    let from = (end as f64 * SETTLING) as usize;
    let rows: Vec<usize> =
        (from..end).filter(|k| pass.channels.iter().all(|channel| channel[*k].is_finite())).collect();
    if rows.len() < 16 {
        let what = format!(
            "{} samples of rest before the run: at least 16 are needed for the tare (process.input.start_s says when \
             the run begins; process.steps.tare = false does without)",
            rows.len()
        );
        return Err(Error::data(&pass.file, what));
    }
    let time: Vec<f64> = rows.iter().map(|row| pass.time[*row]).collect();
    let drift = target.run.spec.process.steps.drift;
    let lines = pass.channels.each_ref().map(|channel| {
        let values: Vec<f64> = rows.iter().map(|k| channel[*k]).collect();
        if drift {
            tare_line(&time, &values)
        } else {
            (values.iter().sum::<f64>() / values.len() as f64, 0.0)
        }
    });
    let count = rows.len() as f64;
    let middle = time.iter().sum::<f64>() / count;
    let square: f64 = time.iter().map(|t| (t - middle).powi(2)).sum();
    let spread = match drift {
        true => [count.recip() + middle * middle / square, -middle / square, square.recip()],
        false => [count.recip(), 0.0, 0.0],
    };
    let batches = BATCHES.min(rows.len() / 2);
    let length = rows.len() / batches;
    let mut noise = DMatrix::zeros(6, 6);
    for batch in rows.chunks_exact(length).take(batches) {
        let mean = DVector::from_fn(6, |i, _| {
            let left = |k: &usize| pass.channels[i][*k] - lines[i].0 - lines[i].1 * pass.time[*k];
            batch.iter().map(left).sum::<f64>() / length as f64
        });
        noise += &mean * mean.transpose();
    }
    let taken = if drift { 2.0 } else { 1.0 };
    noise *= length as f64 / (batches as f64 - taken).max(1.0);
    Ok(Some(Rest { lines, noise, spread }))
}

impl Rest {
    /// Covariance of what the noise of the rest puts into the cycles of a pass: an error of the offset is a load of the same size at
    /// every phase, one of the slope that load times the time, which over the cycle is `clock`.
    ///
    /// Equation: calibrate.tare_covariance
    fn covariance(&self, target: &RigTarget, layout: Layout, clock: &[f64]) -> DMatrix<f64> {
        let turn = DMatrix::from_columns(
            &(0..6)
                .map(|i| {
                    let unit = std::array::from_fn(|k| f64::from(u8::from(k == i)));
                    DVector::from_row_slice(&target.in_body(unit))
                })
                .collect::<Vec<_>>(),
        );
        let body = &turn * &self.noise * turn.transpose();
        let [offset, both, slope] = self.spread;
        let constant = |part: usize| f64::from(u8::from(part == 0));
        let between = |p: usize, q: usize| {
            offset * constant(p) * constant(q)
                + both * (constant(p) * clock[q] + clock[p] * constant(q))
                + slope * clock[p] * clock[q]
        };
        let width = layout.width();
        DMatrix::from_fn(layout.len(), layout.len(), |i, j| {
            between(i % width, j % width) * body[(i / width, j / width)]
        })
    }
}

/// Mean and harmonics of the time over cycles that begin at the phase `begin.0` and have the frequency `begin.1`, about `middle`:
/// a sawtooth, whose sines about that phase are -1/(pi k f).
fn clock(layout: Layout, (begin, frequency): (f64, f64), middle: f64) -> Vec<f64> {
    let part = |part: usize| {
        let k = Layout::harmonic(part) as f64;
        let size = -1.0 / (std::f64::consts::PI * k * frequency);
        match part {
            0 => middle,
            part if part % 2 == 1 => -size * (k * begin).sin(),
            _ => size * (k * begin).cos(),
        }
    };
    (0..layout.width()).map(part).collect()
}

/// Phase of the samples `from ..` on, `count` of them.
fn phases(
    target: &RigTarget,
    pass: &Pass,
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
    let phase = pass.phase[from..from + count].to_vec();
    match phase.windows(2).position(|pair| !(pair[1] > pair[0])) {
        None => Ok(phase),
        Some(k) => {
            let what = format!("the phase does not ascend at t = {:.4} s", time[k]);
            Err(Error::data(&pass.file, what))
        }
    }
}

/// Sums by phase, for the scatter from sample to sample.
pub(crate) struct Bins {
    count: Vec<f64>,
    sum: Vec<[f64; 6]>,
    square: DMatrix<f64>,
}

impl Bins {
    pub fn new() -> Self {
        Self { count: vec![0.0; BINS], sum: vec![[0.0; 6]; BINS], square: DMatrix::zeros(6, 6) }
    }

    pub fn add(&mut self, phase: f64, x: [f64; 6]) {
        if x.iter().any(|x| !x.is_finite()) {
            return;
        }
        let bin = ((phase / TAU).rem_euclid(1.0) * BINS as f64) as usize % BINS;
        self.count[bin] += 1.0;
        for a in 0..6 {
            self.sum[bin][a] += x[a];
            for b in 0..6 {
                self.square[(a, b)] += x[a] * x[b];
            }
        }
    }

    /// Covariance about the mean of each phase.
    pub fn covariance(&self) -> DMatrix<f64> {
        let mut covariance = self.square.clone();
        let mut freedom = 0.0;
        for (count, sum) in self.count.iter().zip(&self.sum).filter(|(count, _)| **count > 0.0) {
            freedom += count - 1.0;
            for a in 0..6 {
                for b in 0..6 {
                    covariance[(a, b)] -= sum[a] * sum[b] / count;
                }
            }
        }
        covariance / f64::max(freedom, 1.0)
    }
}

/// A shift of phase between measurement and model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    /// By how much the measured cycle is behind the model's, rad.
    pub by: f64,
    /// Correlation of the harmonics as they are and when shifted.
    pub correlation: [f64; 2],
    /// What the correlation of the measured cycle with itself loses by the shift.
    pub own_loss: f64,
}

/// Correlation of two cycles without their means, channels in parts of their measured amplitude, with the measured one
/// moved ahead by `shift` rad.
fn correlation(layout: Layout, measured: &[f64], model: &[f64], shift: f64) -> f64 {
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

/// The shift at which measurement and model agree best.
pub fn shift(layout: Layout, measured: &[f64], model: &[f64]) -> Shift {
    let at = |by: f64| correlation(layout, measured, model, by);
    let steps = (-720..720).map(|k| f64::from(k) * 0.25_f64.to_radians());
    let by = steps.max_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(0.0);
    let own_loss = 1.0 - correlation(layout, measured, measured, by);
    Shift { by, correlation: [at(0.0), at(by)], own_loss }
}

/// Axes of the cell that were swapped or flipped: for each channel the measured one that it should be, and its sign.
pub type Axes = [(usize, f64); 6];

/// What a changed axis must bring at least, in parts of the whole agreement. *Choice*: quiet axes say nothing.
const TELLING: f64 = 0.03;
/// What all changed axes must bring together. *Choice*: a model may be wrong by half.
const CONVINCING: f64 = 0.4;

/// Axes with which the measured cycle agrees with the model much better than as they are; none where they are right.
/// Forces and moments are turned apart from each other: a plug may be wrong, as may a sign in a file.
pub fn axes(layout: Layout, measured: &[f64], model: &[f64]) -> Option<Axes> {
    if layout.channels != 6 {
        return None;
    }
    let product = |a: &[f64], i: usize, b: &[f64], j: usize| -> f64 {
        (1..layout.width()).map(|part| a[layout.at(i, part)] * b[layout.at(j, part)]).sum()
    };
    let mut found: Axes = std::array::from_fn(|i| (i, 1.0));
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
