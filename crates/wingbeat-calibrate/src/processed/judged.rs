//! Whether samples can be those of the run that is given for them.

use std::f64::consts::TAU;

use crate::{HarmonicLayout, disagreement, in_cell, project};
use wingbeat::judge::RunLimits;
use wingbeat::judge::data::{
    CyclePair, Finding, MeasuredChannel, Purpose, Series, compared, examined, mean_apart,
};
use wingbeat::judge::limits::data::{BACKWARD, COVERED, FREQUENCY, PHASE_RATE, RESONANCE};
use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::process::{CycleAverage, PhaseSource};
use wingbeat::scenario::ProcessedRun;

/// Harmonics by which a cycle is judged.
const HARMONICS: usize = 8;

/// What of the run does not agree with its model, with the keys that would mend it; none where nothing is wrong.
pub fn judged(one: &ProcessedRun) -> Option<String> {
    let processed = one.averaged()?;
    if of_phase(one).is_some_and(|finding| finding.breaks(&one.run.limits)) {
        return None;
    }
    let model = processed.model.as_ref()?;
    let layout = HarmonicLayout { channels: 6, harmonics: HARMONICS };
    let (measured, model) = (harmonics(&processed.cycles)?, harmonics(&model.cycles)?);
    let turned = |cycle: &[f64]| match one.run.spec.process.steps.body_frame {
        true => in_cell(&one.run.mount_as_drawn(), layout, cycle),
        false => cycle.to_vec(),
    };
    let cell = [turned(&measured), turned(&model)];
    let found = disagreement(layout, [&measured, &model], [&cell[0], &cell[1]])?;
    Some(format!("{}: --set '{}'", found.words(), found.mend()))
}

/// Mean and harmonics of averaged cycles.
fn harmonics(cycles: &[CycleAverage; 6]) -> Option<Vec<f64>> {
    let bins = cycles[0].mean.len();
    let at = |k: usize| (k + bins - 1) % bins;
    let phase: Vec<f64> = (0..bins + 3).map(|k| TAU * (k as f64 - 1.0) / bins as f64).collect();
    let channels = cycles.each_ref().map(|cycle| (0..bins + 3).map(|k| cycle.mean[at(k)]).collect());
    project(&phase, &channels, 0.0, HARMONICS)
}

/// What is wrong with the samples of a run in the `window` (s), by themselves and beside the model on the measured motion. What
/// is told as a disagreement with the model too is only noted.
pub fn findings(one: &ProcessedRun, window: (f64, f64), limits: &RunLimits) -> Vec<Finding> {
    let mut found: Vec<Finding> = one.averaged().map(|of| of.recorded.clone()).unwrap_or_default();
    found.extend(resonant(one).filter(|finding| finding.breaks(limits)));
    found.extend(cut(one, window).filter(|finding| finding.breaks(limits)));
    // With another phase nothing else can be told.
    if let Some(phase) = of_phase(one).filter(|finding| finding.breaks(limits)) {
        found.push(phase);
        return found.into_iter().map(keyed).collect();
    }
    // Once they are turned, few counts are no longer told, nor once more what is cut off.
    let told = |of: &Finding| {
        of.id == "data.coarse" || found.iter().any(|other| other.id == "data.clipped" && other.id == of.id)
    };
    let samples: Vec<Finding> =
        of_samples(one, limits).unwrap_or_default().into_iter().filter(|of| !told(of)).collect();
    let samples = samples.into_iter().map(|of| of.of_mean_cycle(limits));
    found.extend(samples);
    found.extend(beside_model(one, limits).unwrap_or_default());
    // Noise has no frequency.
    let noise = found.iter().any(|finding| finding.id == "data.noise");
    found.extend(of_frequency(one).filter(|finding| !noise && finding.breaks(limits)));
    found.into_iter().map(keyed).collect()
}

/// The unfiltered samples of the window; those that are missing are gaps.
fn of_samples(one: &ProcessedRun, limits: &RunLimits) -> Option<Vec<Finding>> {
    let trace = &one.averaged()?.trace;
    let raw = CHANNELS.iter().map(|(name, _)| trace.values(&format!("raw_{name}")));
    let raw = raw.collect::<Option<Vec<&[f64]>>>()?;
    let cycle = trace.values("cycle")?;
    let is_whole = |row: &usize| raw.iter().all(|channel| channel[*row].is_finite());
    let examined = |phase: &[f64], raw: &[&[f64]]| {
        let channel = |((name, unit), samples)| MeasuredChannel { name, unit, samples };
        let series = Series {
            what: one.name(),
            phase,
            frequency_hz: Some(one.run.frequency()),
            channels: CHANNELS.iter().copied().zip(raw.iter().copied()).map(channel).collect(),
            purpose: Purpose::Loads,
        };
        examined(&series, limits)
    };
    // Long files are not copied where nothing is missing.
    if (0..cycle.len()).all(|row| is_whole(&row)) {
        return Some(examined(cycle, &raw));
    }
    let whole: Vec<usize> = (0..cycle.len()).filter(is_whole).collect();
    let kept = |of: &[f64]| whole.iter().map(|row| of[*row]).collect::<Vec<f64>>();
    let (phase, kept): (_, Vec<Vec<f64>>) = (kept(cycle), raw.iter().map(|of| kept(of)).collect());
    let kept: Vec<&[f64]> = kept.iter().map(Vec::as_slice).collect();
    Some(examined(&phase, &kept))
}

/// An encoder that goes back, or turns at another rate than the gait.
fn of_phase(one: &ProcessedRun) -> Option<Finding> {
    let trace = &one.averaged()?.trace;
    let (t, cycle) = (trace.values("t")?, trace.values("cycle")?);
    if one.run.spec.process.phase != PhaseSource::Encoder {
        return None;
    }
    let about = || format!("phase of {}", one.name());
    let back = cycle.windows(2).filter(|pair| pair[1] <= pair[0]).count();
    if back > 0 {
        let text = format!(
            "does not go ahead at {back} of {} samples: the encoder stands still, loses counts, or its column is another one; leave \
             that part out, or take the phase by force or frequency",
            cycle.len()
        );
        return Some(Finding::new("data.phase", &BACKWARD, about(), back as f64, text));
    }
    let (given, turned) = (one.run.frequency(), (cycle.last()? - cycle.first()?) / (t.last()? - t.first()?));
    let ratio = turned / given;
    let text = format!(
        "turns at {turned:.4} Hz, {ratio:.3} times the {given} Hz that are given for the run: the encoder sits before a gear, its unit is \
         another one, or the frequency is; give the phase of the gait, or take it by force or frequency"
    );
    Some(Finding::new("data.phase", &PHASE_RATE, about(), (ratio - 1.0).abs(), text))
}

/// By how much the resonance of the mount on its cell makes the highest harmonic that is judged too large: 1 / (1 - (f / f_r)^2), which
/// is the gain of a mass on a spring that hardly damps.
fn resonant(one: &ProcessedRun) -> Option<Finding> {
    let trace = one.averaged()?;
    let (frequency, resonance) = (one.run.frequency(), one.run.spec.rig.cell.resonance_hz);
    let cutoff = one.run.spec.process.steps.cutoff_multiple;
    let kept = if cutoff > 0.0 { cutoff.min(HARMONICS as f64) } else { HARMONICS as f64 };
    let highest = kept.floor().max(1.0);
    let at = highest * frequency;
    let gain = |f: f64| 1.0 / (1.0 - (f / resonance).powi(2)).max(f64::MIN_POSITIVE) - 1.0;
    let text = format!(
        "the resonance at {resonance} Hz makes harmonic {highest} of the loads, at {at:.1} Hz, {:.0} % too large, and the model beside has \
         none: stiffen the mount, or average fewer harmonics",
        100.0 * gain(at)
    );
    (!trace.cycles.is_empty()).then(|| Finding::new("data.resonance", &RESONANCE, one.name(), gain(at), text))
}

/// The frequency of the strokes that the force tells, against that of the run: a phase by the force follows any.
fn of_frequency(one: &ProcessedRun) -> Option<Finding> {
    let trace = &one.averaged()?.trace;
    let (t, cycle) = (trace.values("t")?, trace.values("cycle")?);
    let (given, turns) = (one.run.frequency(), cycle.last()? - cycle.first()?);
    let measured = turns / (t.last()? - t.first()?);
    let text = format!(
        "the force repeats at {measured:.4} Hz over {turns:.1} cycles, but {given} Hz is given for the run: give the frequency of the \
         data, or mend their rate"
    );
    // The phase at either end is known to a fiftieth of a cycle (*choice*), which must be less than half of the limit.
    let told = one.run.spec.process.phase == PhaseSource::Force && turns * FREQUENCY.value > 0.08;
    let size = (measured / given - 1.0).abs();
    told.then(|| Finding::new("data.frequency", &FREQUENCY, one.name(), size, text))
}

/// That the file ends before the `window` (s) of its run does.
fn cut(one: &ProcessedRun, window: (f64, f64)) -> Option<Finding> {
    let trace = one.averaged()?.trace.values("t")?;
    let share = (trace.last()? - trace.first()?) / (window.1 - window.0);
    let text = format!(
        "the file covers {:.0} % of the {:.3} s that are averaged: it begins late, or ends before its run does; check \
         process.input.start_s",
        100.0 * share,
        window.1 - window.0
    );
    (share.is_finite()).then(|| Finding::new("data.cut", &COVERED, one.name(), share, text))
}

fn beside_model(one: &ProcessedRun, limits: &RunLimits) -> Option<Vec<Finding>> {
    let processed = one.averaged()?;
    let model = processed.model.as_ref()?;
    let pair = |(i, (name, unit)): (usize, &(&'static str, &'static str))| CyclePair {
        name,
        unit,
        measured: &processed.cycles[i].mean,
        computed: &model.cycles[i].mean,
    };
    let pairs: Vec<CyclePair> = CHANNELS.iter().enumerate().map(pair).collect();
    // A model may be wrong by much, but not so that the loads turned over are like it.
    let turned = |finding: &Finding| finding.id == "data.reversed" && finding.about == one.name();
    let noted = |finding: Finding| if turned(&finding) { finding } else { finding.noted() };
    // A reversed Fz that gives the phase turns it by half a cycle, and the others with it.
    let by_force = one.run.spec.process.phase == PhaseSource::Force;
    let or_fz = |mut finding: Finding| {
        let of_other = !finding.about.starts_with("Fz") && finding.about != one.name();
        if by_force && finding.id == "data.reversed" && of_other {
            finding.text += "; or Fz is, from which the phase is taken";
        }
        finding
    };
    let all = compared(one.name(), &pairs, limits).into_iter();
    let mut found: Vec<Finding> = all.map(noted).map(or_fz).collect();
    // Without a tare the mean is that of the cell's offset.
    if one.run.spec.process.steps.tare {
        found.extend(mean_apart(one.name(), &pairs).filter(|finding| finding.breaks(limits)));
    }
    Some(found)
}

/// The same with the key of the run that mends it.
fn keyed(finding: Finding) -> Finding {
    let key = match finding.id {
        "data.frequency" => Some("frequency_hz"),
        "data.phase" => Some("process.input.columns"),
        "data.resonance" => Some("process.steps.cutoff_multiple"),
        "data.mean" => Some("rig.mount"),
        "data.cut" | "data.rest" => Some("process.input.start_s"),
        "data.drift" => Some("process.steps.drift"),
        "data.reversed" | "data.swapped" | "data.dead" => Some("process.input.columns"),
        "data.noise" | "data.not_periodic" => Some("process.window_s"),
        _ => None,
    };
    finding.mended_by(key.map(Into::into))
}
