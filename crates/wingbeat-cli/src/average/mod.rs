//! `wingbeat average`: a file of loads, averaged over the cycles of the wings.

mod rest;

use std::time::Instant;

use serde::Serialize;
use wingbeat::judge::data::{
    self, Finding, MeasuredChannel, Purpose, Series, SpectralLine, examined, find_frequency,
};
use wingbeat::judge::limits::data::{CYCLES_LOST, FEW_CYCLES_LOST, LINE, LOST, OF_LINE};
use wingbeat::judge::{Judge, RunLimits, Status, Verdict, Warning};
use wingbeat::rig::process::{CycleAverage, PhaseSource, phase_average, phase_of};
use wingbeat::simulate::{Column, Record};
use wingbeat_figures::DEVIATION;
use wingbeat_io::samples::{ChannelRequest, Plain, read_channels};
use wingbeat_io::write_csv;

use crate::args::Average;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::progress;
use crate::run_folder::{RunFolder, named_after};
use crate::say;
use rest::RestSummary;

/// Phases of an average that may be asked for.
const BINS: [usize; 2] = [2, 10_000];

/// Averages the file and writes its run folder.
pub fn average(arguments: &Average) -> Result<(), Error> {
    let start = Instant::now();
    let interrupt = Interrupt::listen()?;
    let asked = asked(arguments)?;
    let mut plain = read_channels(&arguments.file)?.plain(&asked)?;
    if arguments.columns.is_empty() {
        leave_out_counters(&mut plain);
    }
    let file = arguments.file.display().to_string();
    let rest = arguments.rest.map(|seconds| RestSummary::taken(&mut plain, seconds, &file)).transpose()?;
    plain.cautions.iter().for_each(|caution| say::note(&format!("note: {caution}")));
    let name = named_after(&arguments.file, arguments.out.as_deref())?;
    let folder = RunFolder::create(arguments.out.as_deref(), &name, arguments.force)?;
    let bar = progress::bar(Some(2), "averaging {bar:30} {pos} of {len} steps", arguments.quiet);
    let limits = RunLimits::default();
    let told = match arguments.frequency {
        Some(frequency) => FrequencySource::Given(frequency),
        None => FrequencySource::Found(find_frequency(&plain.time, &channels(&plain), limits.of(&LINE).0)),
    };
    bar.set_position(1);
    interrupt.check()?;
    let averages = told.frequency().map(|f| averages(arguments, &plain, f)).transpose()?;
    let averages = averages.filter(|averages| !averages.is_empty());
    let summary = AverageSummary::of(arguments, &plain, (&told, rest), averages.as_deref(), &limits);
    bar.finish_and_clear();
    folder.write_json("summary.json", &summary)?;
    if let Some(averages) = &averages {
        let cycles = cycles(averages)?;
        write_csv(&folder.file("cycles.csv"), &cycles)?;
        let drawn = wingbeat_figures::averaged(&cycles, averages[0].1.cycles);
        let figures = folder.folder("figures")?;
        crate::fly::left_out(drawn.and_then(|figure| wingbeat_figures::write(&figures, &figure)))?;
    }
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(0, start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    let printed =
        say::unless(arguments.quiet, || format!("{}\nrun folder: {}\n", summary.text(), shown.display()));
    let Verdict { status, reason, .. } = &summary.verdict;
    Error::unless_usable(*status, reason.as_deref(), shown)?;
    printed
}

/// Largest rate and frequency, Hz: faster than any load cell is read. *Choice.*
const FASTEST: f64 = 1e9;

/// What the command line asks of the file.
fn asked(arguments: &Average) -> Result<ChannelRequest, Error> {
    for (key, value) in [("--rate", arguments.rate), ("--frequency", arguments.frequency)] {
        if let Some(value) = value.filter(|value| !(*value > 0.0 && *value <= FASTEST)) {
            return Err(Error::Input(format!("{key} {value:?}: allowed is above 0, at most {FASTEST:e} Hz")));
        }
    }
    let [least, most] = BINS;
    if !(least..=most).contains(&arguments.bins) {
        let bins = arguments.bins;
        return Err(Error::Input(format!("--bins {bins}: allowed is a whole number from {least} to {most}")));
    }
    let (columns, units) = (arguments.columns.clone(), arguments.units.clone());
    Ok(ChannelRequest { rate: arguments.rate, columns, units })
}

/// Units of what an encoder counts.
const COUNTED: [&str; 9] = ["", "deg", "rad", "rev", "turn", "turns", "count", "counts", "ticks"];

/// Leaves out channels that only grow or only fall in the unit of an angle or a count, as an encoder or a counter does: no load.
fn leave_out_counters(plain: &mut Plain) {
    let counts = |column: &Column| {
        let values = || column.values.iter().filter(|x| x.is_finite());
        let whole = || values().all(|x| x.fract() == 0.0);
        let steps = || values().zip(values().skip(1)).map(|(a, b)| b - a);
        let moves = steps().any(|step| step != 0.0);
        let one_way = steps().all(|step| step >= 0.0) || steps().all(|step| step <= 0.0);
        COUNTED.contains(&column.unit.as_str()) && (!column.unit.is_empty() || whole()) && moves && one_way
    };
    let counters: Vec<String> =
        plain.channels.iter().filter(|column| counts(column)).map(|column| column.name.clone()).collect();
    if !counters.is_empty() && counters.len() < plain.channels.len() {
        plain.channels.retain(|column| !counters.contains(&column.name));
        let names = counters.join(", ");
        plain.cautions.push(format!(
            "{names}: grows from start to end as an encoder or a counter does, and is left out"
        ));
    }
}

fn channels(plain: &Plain) -> Vec<MeasuredChannel<'_>> {
    plain.channels.iter().map(|column| channel(column, &column.values)).collect()
}

fn channel<'a>(column: &'a Column, samples: &'a [f64]) -> MeasuredChannel<'a> {
    MeasuredChannel { name: &column.name, unit: &column.unit, samples }
}

/// Where the frequency comes from.
enum FrequencySource {
    /// The command line, Hz.
    Given(f64),
    /// The data.
    Found(SpectralLine),
}

impl FrequencySource {
    fn frequency(&self) -> Option<f64> {
        match self {
            Self::Given(frequency) => Some(*frequency),
            Self::Found(line) => line.frequency,
        }
    }
}

/// A channel and its average.
type Of<'a> = (&'a Column, CycleAverage);

/// What is wrong with a channel that has values that are no numbers, beside the samples that are missing.
fn not_finite(arguments: &Average, plain: &Plain, column: &Column) -> Option<Finding> {
    let file = arguments.file.display().to_string();
    data::not_finite(&file, &channel(column, &column.values), plain.missing)
}

/// Every channel by the phase, which is 0 at the time 0; none of a channel that is no number in every cycle.
fn averages<'a>(arguments: &Average, plain: &'a Plain, frequency: f64) -> Result<Vec<Of<'a>>, Error> {
    let refused = |error: wingbeat::Error| {
        let wingbeat::Error::Invalid { value, .. } = error;
        let help = match plain.missing {
            0 => "give a longer file, or --frequency HZ".to_owned(),
            missing => format!(
                "by its times {missing} of {} samples are missing: --rate HZ takes the rows at even steps instead",
                plain.time.len()
            ),
        };
        Error::Input(format!(
            "{}: {value} at {frequency} Hz: allowed is at least one whole cycle without missing samples; {help}",
            arguments.file.display()
        ))
    };
    let phase = phase_of(PhaseSource::Frequency, &plain.time, Vec::new(), &[], frequency).map_err(refused)?;
    let mut averages = Vec::new();
    for column in &plain.channels {
        match phase_average(&phase, &column.values, arguments.bins).map_err(refused) {
            Ok(average) => averages.push((column, average)),
            Err(_) if not_finite(arguments, plain, column).is_some() => {}
            Err(error) => return Err(error),
        }
    }
    Ok(averages)
}

/// The table of phases, means and standard deviations.
fn cycles(averages: &[Of]) -> Result<Record, Error> {
    let bins = averages[0].1.mean.len();
    let phase = (0..bins).map(|k| k as f64 / bins as f64).collect();
    let mut columns = vec![Column { values: phase, ..Column::new("phase", "", "") }];
    for (channel, average) in averages {
        let of = |name: String, values: &[f64]| {
            let unit = channel.unit.as_str();
            Column { values: values.to_vec(), ..Column::new(name, unit, "") }
        };
        columns.push(of(channel.name.clone(), &average.mean));
        let unknown = vec![f64::NAN; bins];
        let deviation = if average.cycles > 1 { &average.deviation } else { &unknown };
        columns.push(of(format!("{}{DEVIATION}", channel.name), deviation));
    }
    Ok(Record::new(columns, 0)?)
}

/// A channel in `summary.json`.
#[derive(Serialize)]
struct ChannelAverage {
    /// Its name.
    name: String,
    /// Its unit, as given or as the file says.
    unit: String,
    /// Mean over all phases.
    mean: f64,
    /// Least of the mean cycle.
    least: f64,
    /// Largest of the mean cycle.
    most: f64,
    /// Root mean square over the phases of the standard deviation over the cycles; unknown of a single one.
    std: Option<f64>,
    /// Whole cycles averaged.
    cycles: usize,
    /// Whole cycles left out because samples are missing in them.
    left_out: usize,
}

impl ChannelAverage {
    fn of(channel: &Column, average: &CycleAverage) -> Self {
        let bins = average.mean.len() as f64;
        Self {
            name: channel.name.clone(),
            unit: channel.unit.clone(),
            mean: average.mean.iter().sum::<f64>() / bins,
            least: average.mean.iter().copied().fold(f64::INFINITY, f64::min),
            most: average.mean.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            std: (average.cycles > 1)
                .then(|| (average.deviation.iter().map(|d| d * d).sum::<f64>() / bins).sqrt()),
            cycles: average.cycles,
            left_out: average.left_out,
        }
    }
}

/// `summary.json`.
#[derive(Serialize)]
struct AverageSummary {
    /// The file.
    file: String,
    /// Samples of each channel.
    samples: usize,
    /// Samples that are missing between the first and the last.
    missing: usize,
    /// Rows left out because they came again.
    duplicates: usize,
    /// Samples per second, Hz.
    rate_hz: f64,
    /// From the first sample to the last, s.
    duration_s: f64,
    /// Frequency of the cycle, Hz; absent where none was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    frequency_hz: Option<f64>,
    /// Its standard error, Hz; absent where the frequency was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    frequency_error_hz: Option<f64>,
    /// `data` or `given`.
    frequency_from: &'static str,
    /// Frequency of the strongest line, Hz: the frequency or a harmonic of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    strongest_line_hz: Option<f64>,
    channels: Vec<ChannelAverage>,
    /// The rest that was subtracted.
    #[serde(skip_serializing_if = "Option::is_none")]
    rest: Option<RestSummary>,
    #[serde(flatten)]
    verdict: Verdict,
}

impl AverageSummary {
    fn of(
        arguments: &Average,
        plain: &Plain,
        (told, rest): (&FrequencySource, Option<RestSummary>),
        averages: Option<&[Of]>,
        limits: &RunLimits,
    ) -> Self {
        let line = match told {
            FrequencySource::Found(line) => Some(line),
            FrequencySource::Given(_) => None,
        };
        let span = plain.time.last().unwrap_or(&0.0) - plain.time.first().unwrap_or(&0.0);
        Self {
            file: arguments.file.display().to_string(),
            samples: plain.time.len(),
            missing: plain.missing,
            duplicates: plain.duplicates,
            rate_hz: plain.rate,
            duration_s: span,
            frequency_hz: told.frequency(),
            frequency_error_hz: line.and_then(|line| line.frequency.map(|_| line.error)),
            frequency_from: if line.is_some() { "data" } else { "given" },
            strongest_line_hz: line.and_then(|line| line.frequency.map(|_| line.strongest)),
            channels: averages
                .iter()
                .copied()
                .flatten()
                .map(|(c, average)| ChannelAverage::of(c, average))
                .collect(),
            verdict: verdict(arguments, plain, (told, rest.as_ref()), averages.unwrap_or_default(), limits),
            rest,
        }
    }

    fn text(&self) -> String {
        let mut text = format!(
            "{}: {} samples at {:.6} Hz, {:.3} s\n",
            self.file, self.samples, self.rate_hz, self.duration_s
        );
        text.extend(self.rest.as_ref().map(RestSummary::text));
        if let Some(frequency) = self.frequency_hz {
            let error = self.frequency_error_hz.map_or("given".into(), |error| format!("+- {error:.1e} Hz"));
            text += &format!("frequency {frequency:.5} Hz ({error})\n");
            text += &format!(
                "\n{:<14}{:>12}{:>12}{:>12}{:>12}{:>8}\n",
                "", "mean", "least", "most", "std", "cycles"
            );
        }
        for ChannelAverage { name, unit, mean, least, most, std, cycles, .. } in &self.channels {
            let std = std.map_or("-".into(), |std| format!("{std:.5}"));
            text += format!("{name:<14}{mean:>12.5}{least:>12.5}{most:>12.5}{std:>12}{cycles:>8}  {unit}")
                .trim_end();
            text.push('\n');
        }
        for warning in &self.verdict.warnings {
            text += &format!("\n{warning}\n");
        }
        text
    }
}

/// Samples of a period of the strongest line below which its frequency may be another one. *Choice.*
const FEWEST: f64 = 4.0;

/// What the samples say of themselves. Those that are missing are gaps.
fn verdict(
    arguments: &Average,
    plain: &Plain,
    (told, rest): (&FrequencySource, Option<&RestSummary>),
    averages: &[Of],
    limits: &RunLimits,
) -> Verdict {
    let mut judge = Judge::new(limits);
    let of_rows = "(by the times of the file; --rate HZ takes the rows at even steps instead)";
    let left_out = |(_, of): &Of| of.left_out as f64 / (of.cycles + of.left_out) as f64;
    if let Some(share) = averages.iter().map(left_out).reduce(f64::max).filter(|_| plain.missing > 0) {
        judge.hold_about(&CYCLES_LOST, share, of_rows);
        judge.hold_about(&FEW_CYCLES_LOST, share, of_rows);
    }
    if let Some(rest) = rest {
        rest.judge(&mut judge);
    }
    if let FrequencySource::Found(line) = told {
        judge.hold(&LINE, line.over_noise);
    }
    if let FrequencySource::Found(SpectralLine { frequency: None, over_noise, .. }) = told {
        let text = format!(
            "{}: no channel has a load that repeats: noise, or less than four cycles; give the frequency with \
             --frequency HZ if you know it",
            arguments.file.display()
        );
        judge.warn(Warning::new("data.noise", text).size(*over_noise));
        let lines = "lines stand above the noise, but no channel repeats at one frequency: too short a file, a frequency that \
                     changes, or a jump of phase";
        if *over_noise >= limits.of(&LINE).0 {
            judge.find(Status::NotFound, lines);
        }
    }
    if let FrequencySource::Found(SpectralLine { frequency: Some(_), strongest, .. }) = told
        && plain.rate < FEWEST * strongest
    {
        let size = plain.rate / strongest;
        let text = format!(
            "{size:.2} samples a period of the strongest line: at {:.6} Hz a frequency of {:.6} Hz looks the same; sample faster, or \
             give --frequency HZ",
            plain.rate,
            plain.rate - strongest
        );
        judge.warn(Warning::new("data.aliased", text).size(size).key("--frequency"));
        judge.hold(&OF_LINE, size);
    }
    if let Some(own) = plain.other_rate {
        let text = format!(
            "--rate {} was followed; by its own times {} has {own:.6} Hz",
            plain.rate,
            arguments.file.display()
        );
        judge.warn(Warning::new("data.rate", text).size(own).key("--rate"));
    }
    let (broken, all): (Vec<&Column>, Vec<&Column>) =
        plain.channels.iter().partition(|column| not_finite(arguments, plain, column).is_some());
    for finding in broken.iter().filter_map(|column| not_finite(arguments, plain, column)) {
        finding.put(&mut judge);
    }
    // Without a frequency there is no cycle to judge by.
    let Some(frequency) = told.frequency() else { return judge.verdict() };
    let whole: Vec<usize> = (0..plain.time.len())
        .filter(|row| all.iter().all(|channel| channel.values[*row].is_finite()))
        .collect();
    let phase: Vec<f64> = whole.iter().map(|row| frequency * plain.time[*row]).collect();
    let kept = |column: &Column| whole.iter().map(|row| column.values[*row]).collect::<Vec<f64>>();
    let kept: Vec<Vec<f64>> = all.iter().map(|column| kept(column)).collect();
    let series = Series {
        what: &arguments.file.display().to_string(),
        phase: &phase,
        frequency_hz: Some(frequency),
        channels: all.iter().zip(&kept).map(|(column, samples)| channel(column, samples)).collect(),
        purpose: Purpose::Loads,
    };
    let found = examined(&series, limits);
    if plain.missing > 0 && !found.iter().any(|finding| finding.limit.id == LOST.id) {
        let is_missing = |row: &usize| plain.channels.iter().all(|channel| !channel.values[*row].is_finite());
        let missing = (0..plain.time.len()).filter(is_missing).count();
        judge.hold_about(&LOST, missing as f64 / plain.time.len() as f64, of_rows);
    }
    let none = found.iter().find(|finding| !finding.serious && finding.has_no_mean_cycle(limits));
    if let Some(finding) = none {
        let why = "leave a rest at the start out by --rest SECONDS";
        judge.find(Status::NotPeriodic, format!("{}; {why}", finding.words()));
    }
    for finding in found {
        let key = (finding.id == "data.frequency").then(|| "--frequency".to_owned());
        finding.mended_by(key).put(&mut judge);
    }
    judge.verdict()
}
