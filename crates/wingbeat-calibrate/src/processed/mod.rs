//! What `rig process` says of its runs.

mod judged;
mod source;

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Serialize;
use wingbeat::judge::{Judge, Verdict};
use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::process::{Comparison, Steps};
use wingbeat::scenario::{CombinedRuns, Evaluated, ProcessedRun, TiltWeighing};
use wingbeat_io::samples::Import;

use judged::{findings, judged};
pub use source::{ProcessedTogether, SampleSource};

/// A file of samples, how it was read, and what of it was averaged, s.
pub struct ProcessedFile {
    /// Where it lies.
    pub file: PathBuf,
    /// How it was read.
    pub import: Import,
    /// Begin and end of what was averaged, s.
    pub window: (f64, f64),
}

/// The contents of summary.json.
#[derive(Serialize)]
pub struct ProcessSummary {
    /// What the samples are, what that rests on, and what to beware of.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// Steps made, as configured.
    steps: Steps,
    /// Runs whose samples are of a simulated load cell.
    simulated: Vec<String>,
    /// Run on whose measured motion the model makes the black line; none where it has no answer.
    simulation: Option<String>,
    /// Strokes of the envelope, one after the other.
    strokes: f64,
    /// Lowest and highest value of the envelope and of the simulation, by channel.
    ranges: BTreeMap<&'static str, Ranges>,
    /// Middle of the envelope against the simulation, by channel.
    envelope_against_simulation: BTreeMap<&'static str, Comparison>,
    /// Each run's phase average against that of the model on its measured motion, by channel.
    runs_against_model: BTreeMap<String, BTreeMap<&'static str, Comparison>>,
    /// Each run's phase average against its own noise-free wrench, by channel.
    runs_against_truth: BTreeMap<String, BTreeMap<&'static str, Comparison>>,
    /// Saturated samples of each run.
    saturated: BTreeMap<String, usize>,
    /// How each run was read and processed.
    runs: BTreeMap<String, RunNumbers>,
    /// Mass, centre and offsets from static tilts.
    static_tilts: BTreeMap<String, TiltWeighing>,
}

/// How a run was read and processed.
#[derive(Serialize)]
struct RunNumbers {
    file: PathBuf,
    import: Import,
    window_s: (f64, f64),
    cycles: usize,
    cycles_left_out: usize,
    serious: usize,
    /// Flapping frequency that was measured, Hz.
    frequency_hz: Option<f64>,
    /// By how much the wings are ahead of those of an even crank that begins with the run, rad.
    ahead_rad: Option<f64>,
    /// What does not agree with the model, with the keys that would mend it.
    disagreement: Option<String>,
    statement: Vec<String>,
}

/// Lowest and highest value of one channel, N or N m.
#[derive(Clone, Copy, Serialize)]
struct Ranges {
    measured: [f64; 2],
    simulation: Option<[f64; 2]>,
}

impl ProcessSummary {
    /// The numbers of `runs`, read from `files`.
    pub fn new(runs: &[ProcessedRun], files: &[ProcessedFile], together: Option<&CombinedRuns>) -> Self {
        let named = |c: [Comparison; 6]| CHANNELS.iter().map(|(name, _)| *name).zip(c).collect();
        let name = |one: &ProcessedRun| one.name().to_owned();
        let reference = together.and_then(|t| runs.iter().find(|one| one.name() == t.reference));
        let averaged = || runs.iter().filter_map(|one| Some((name(one), one.averaged()?)));
        let weighed = runs.iter().filter_map(|one| match &one.result {
            Evaluated::Weighed(weighed) => Some((name(one), (**weighed).clone())),
            Evaluated::Averaged(_) => None,
        });
        Self {
            verdict: verdict(runs, files),
            steps: reference.or(runs.first()).map_or(Steps::default(), |one| one.run.spec.process.steps),
            simulated: averaged().filter(|(_, p)| p.is_simulated()).map(|(name, _)| name).collect(),
            simulation: together.filter(|t| t.simulated).map(|t| t.reference.clone()),
            strokes: together.map_or(0.0, |t| t.turns),
            ranges: together.map_or(BTreeMap::new(), ranges),
            runs_against_model: averaged()
                .filter_map(|(name, p)| Some((name, named(p.against_model()?))))
                .collect(),
            envelope_against_simulation: together.map_or(BTreeMap::new(), |t| t.against_simulation.clone()),
            runs_against_truth: averaged()
                .filter_map(|(name, p)| Some((name, named(p.against_truth()?))))
                .collect(),
            saturated: averaged().map(|(name, p)| (name, p.saturated)).collect(),
            runs: runs.iter().zip(files).map(|(one, file)| (name(one), RunNumbers::of(one, file))).collect(),
            static_tilts: weighed.collect(),
        }
    }
}

/// The verdict on the samples of all runs.
fn verdict(runs: &[ProcessedRun], files: &[ProcessedFile]) -> Verdict {
    let judged = runs.iter().zip(files).map(|(one, file)| {
        let mut judge = Judge::new(&one.run.limits);
        findings(one, file.window, &one.run.limits).into_iter().for_each(|finding| finding.put(&mut judge));
        one.run.of_fit().for_each(|warning| judge.warn(warning));
        judge.verdict().of(&one.run.spec.name)
    });
    let judged: Vec<Verdict> = judged.collect();
    // Findings name their run themselves.
    Verdict::together(judged.iter().map(|verdict| ("", verdict)))
}

/// What the envelope covers.
fn ranges(together: &CombinedRuns) -> BTreeMap<&'static str, Ranges> {
    let of = |prefix: &str, name: &str| {
        let values = together.envelope.values(&format!("{prefix}{name}"))?;
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        Some([low, values.iter().copied().fold(f64::NEG_INFINITY, f64::max)])
    };
    let both = |name: &'static str| {
        let measured = [of("low_", name)?[0], of("high_", name)?[1]];
        Some((name, Ranges { measured, simulation: of("simulation_", name) }))
    };
    CHANNELS.iter().filter_map(|(name, _)| both(name)).collect()
}

impl RunNumbers {
    fn of(run: &ProcessedRun, origin: &ProcessedFile) -> Self {
        let processed = run.averaged();
        Self {
            file: origin.file.clone(),
            import: origin.import.clone(),
            window_s: origin.window,
            cycles: processed.map_or(0, |p| p.cycles[0].cycles),
            cycles_left_out: processed.map_or(0, |p| p.cycles[0].left_out),
            serious: processed.map_or(0, |p| p.serious),
            frequency_hz: processed.and_then(|p| Some(p.model.as_ref()?.frequency_hz)),
            ahead_rad: processed.and_then(|p| p.model.as_ref()?.ahead_rad),
            disagreement: judged(run),
            statement: processed.map_or(Vec::new(), |p| p.statement.clone()),
        }
    }
}

impl ProcessSummary {
    /// Runs whose samples are of a simulated load cell.
    pub fn simulated(&self) -> &[String] {
        &self.simulated
    }

    /// The numbers as tables.
    pub fn words(&self) -> String {
        let mut text = String::new();
        if !self.simulated.is_empty() {
            text += &format!("of a simulated load cell: {}\n", self.simulated.join(", "));
        }
        if !self.envelope_against_simulation.is_empty() {
            text += &self.against_simulation();
        }
        for (name, run) in &self.runs {
            text += &run.words(name);
        }
        for (name, count) in self.saturated.iter().filter(|(_, count)| **count > 0) {
            text += &format!("{name}: {count} samples saturated\n");
        }
        for warning in &self.verdict.warnings {
            text += &format!("{warning}\n");
        }
        for (name, weighed) in &self.static_tilts {
            text += &weighing(name, weighed);
        }
        text
    }

    fn against_simulation(&self) -> String {
        let mut text = format!(
            "middle of the phase averages against the model on the measured motion of {}, {:.2} cycles\n\
             {:8}{:>12}{:>12}{:>13}{:>12}{:>22}{:>22}\n",
            self.simulation.as_deref().unwrap_or_default(),
            self.strokes,
            "channel",
            "rmse",
            "range",
            "correlation",
            "peak ratio",
            "measured",
            "model"
        );
        let range = |of: Option<[f64; 2]>| of.map_or(String::new(), |[a, b]| format!("{a:.4} to {b:.4}"));
        for (name, c) in &self.envelope_against_simulation {
            text += &format!(
                "{name:8}{:12.5}{:12.5}{:13.4}{:>12}{:>22}{:>22}\n",
                c.rmse,
                c.range,
                c.correlation,
                ratio(c.peak_ratio),
                range(self.ranges.get(name).map(|of| of.measured)),
                range(self.ranges.get(name).and_then(|of| of.simulation))
            );
        }
        if self.runs_against_truth.is_empty() {
            return text;
        }
        text += "largest RMSE of a run against its noise-free wrench, % of the channel's range\n";
        for (name, _) in CHANNELS {
            let share =
                |runs: &BTreeMap<&str, Comparison>| runs.get(name).map_or(0.0, |c| 100.0 * c.rmse / c.range);
            let worst = self.runs_against_truth.values().map(share).fold(0.0, f64::max);
            // Without a load there is no range.
            let worst = if worst < 1e4 { format!("{worst:.2}") } else { "-".into() };
            text += &format!("{name:8}{worst:>12}\n");
        }
        text
    }
}

impl RunNumbers {
    /// What a person must know of the run: gaps and cycles left out.
    fn words(&self, name: &str) -> String {
        let i = &self.import;
        let mut text = String::new();
        if i.missing > 0 || i.duplicates > 0 || i.late > 0 {
            text += &format!(
                "{name}: {} samples missing in {} gaps (longest {}, {} bridged), {} duplicates, {} late\n",
                i.missing, i.gaps, i.longest_gap, i.bridged, i.duplicates, i.late
            );
        }
        for caution in i.cautions.iter().chain(&self.disagreement) {
            text += &format!("{name}: caution: {caution}\n");
        }
        if self.serious > 0 {
            text += &format!("{name}: {} samples left out for a serious status of the box\n", self.serious);
        }
        if self.cycles_left_out > 0 {
            let all = self.cycles + self.cycles_left_out;
            text +=
                &format!("{name}: {} of {all} cycles left out for missing samples\n", self.cycles_left_out);
        }
        text
    }
}

/// A ratio of peaks; none where the model has no load to speak of.
fn ratio(of: f64) -> String {
    if of.abs() < 1e4 { format!("{of:.3}") } else { "-".into() }
}

fn weighing(name: &str, weighed: &TiltWeighing) -> String {
    let mut text = format!(
        "{name}: {} attitudes, least squares (plus-minus one standard deviation)\n",
        weighed.load.tilts
    );
    for (what, w) in [("load on the cell", &weighed.load), ("mount without robot", &weighed.mount)] {
        let com = |i: usize| format!("{:.3} +- {:.3}", 1e3 * w.com_m[i], 1e3 * w.com_sigma_m[i]);
        text += &format!(
            "  {what:20} mass {:.3} +- {:.3} g, centre {}, {}, {} mm\n",
            1e3 * w.mass_kg,
            1e3 * w.mass_sigma_kg,
            com(0),
            com(1),
            com(2)
        );
    }
    let w = &weighed.mount;
    let six = |values: &[f64; 6]| values.map(|value| format!("{value:.5}")).join(", ");
    text += &format!("  bias [{}] N, N m; drift [{}] per s\n", six(&w.bias), six(&w.drift_per_s));
    text += &format!(
        "  residual: forces {:.5} N rms, {:.5} N largest; moments {:.3} N mm rms, {:.3} N mm largest\n",
        w.residual_rms[0],
        w.residual_largest[0],
        1e3 * w.residual_rms[1],
        1e3 * w.residual_largest[1]
    );
    let moved = weighed.mount_mm_per_deg;
    if moved.iter().any(|x| *x != 0.0) {
        let moved = moved.map(|x| format!("{x:.3}")).join(", ");
        text += &format!(
            "  +- is that of the fit: where the robot's wings rest is by its model; 1 deg of its gait's phase moves the centre of the \
             mount by {moved} mm\n"
        );
    }
    text + &format!(
        "  to use it: --set rig.mount.link.mass_kg={:.6} --set 'rig.mount.link.com_m=[{:.6}, {:.6}, {:.6}]'\n",
        w.mass_kg, w.com_m[0], w.com_m[1], w.com_m[2]
    )
}
