//! `wingbeat average`: a file of loads, averaged over the cycles of the wings.

mod rest;

use std::time::Instant;

use serde::Serialize;
use wingbeat::judge::data::{AveragedFile, MeasuredChannel, SpectralLine, find_frequency, not_finite};
use wingbeat::judge::limits::data::LINE;
use wingbeat::judge::{RunLimits, Verdict};
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
    let line = match arguments.frequency {
        Some(_) => None,
        None => Some(find_frequency(&plain.time, &channels(&plain), limits.of(&LINE).0)),
    };
    let frequency = arguments.frequency.or(line.and_then(|line| line.frequency));
    bar.set_position(1);
    interrupt.check()?;
    let averages = frequency.map(|f| averages(arguments, &plain, f)).transpose()?;
    let averages = averages.filter(|averages| !averages.is_empty());
    let summary =
        AverageSummary::of(arguments, &plain, (frequency, line, rest), averages.as_deref(), &limits);
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
    plain.channels.iter().map(channel).collect()
}

fn channel(column: &Column) -> MeasuredChannel<'_> {
    MeasuredChannel { name: &column.name, unit: &column.unit, samples: &column.values }
}

/// A channel and its average.
type Of<'a> = (&'a Column, CycleAverage);

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
    let file = arguments.file.display().to_string();
    let broken = |column| not_finite(&file, &channel(column), plain.missing).is_some();
    let phase = phase_of(PhaseSource::Frequency, &plain.time, Vec::new(), &[], frequency).map_err(refused)?;
    let mut averages = Vec::new();
    for column in &plain.channels {
        match phase_average(&phase, &column.values, arguments.bins).map_err(refused) {
            Ok(average) => averages.push((column, average)),
            Err(_) if broken(column) => {}
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
        (frequency, line, rest): (Option<f64>, Option<SpectralLine>, Option<RestSummary>),
        averages: Option<&[Of]>,
        limits: &RunLimits,
    ) -> Self {
        let left_out = |(_, of): &Of| of.left_out as f64 / (of.cycles + of.left_out) as f64;
        let averages = averages.unwrap_or_default();
        let file = arguments.file.display().to_string();
        let averaged = AveragedFile {
            file: &file,
            time: &plain.time,
            channels: channels(plain),
            missing: plain.missing,
            rate: plain.rate,
            other_rate: plain.other_rate,
            frequency,
            line,
            rest_scatter: rest.as_ref().map(|rest| rest.scatter_fraction),
            left_out: averages.iter().map(left_out).reduce(f64::max),
        };
        let verdict = averaged.verdict(limits);
        let span = plain.time.last().unwrap_or(&0.0) - plain.time.first().unwrap_or(&0.0);
        Self {
            file,
            samples: plain.time.len(),
            missing: plain.missing,
            duplicates: plain.duplicates,
            rate_hz: plain.rate,
            duration_s: span,
            frequency_hz: frequency,
            frequency_error_hz: line.and_then(|line| line.frequency.map(|_| line.error)),
            frequency_from: if line.is_some() { "data" } else { "given" },
            strongest_line_hz: line.and_then(|line| line.frequency.map(|_| line.strongest)),
            channels: averages.iter().map(|(c, average)| ChannelAverage::of(c, average)).collect(),
            verdict,
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
