//! How the cycles of a channel differ from the mean one: in size, and in time.

use super::cycle::{ChannelParts, SplitChannel};
use super::noise::{Order, deviation, third};
use super::spread::CycleSpread;
use super::values::Extent;
use super::{Cause, Finding, Purpose, Series};
use crate::limits::data::{DIFFERS, EARLY, PHASES, RUN_AWAY, RUNS, SCATTER, TREND};
use crate::limits::{JudgedLimit, RunLimits};

/// Points of a cycle from which its slope is known. *Choice.*
const FOR_SLOPE: f64 = 8.0;
/// Standard errors of a line through how late the cycles come above which it is told. *Choice.*
const SURE: f64 = 6.0;

/// What each whole cycle holds of the mean cycle f and of its slope g, by least squares over its points x, which the mean cycle leaves l:
/// its size sum(x f) / sum(f f) and how late it comes, sum(l g) / sum(g g), in cycles.
pub(super) struct StrokeVariation {
    sizes: CycleSpread,
    late: CycleSpread,
    /// Variance that sizes and levels of the cycles explain of what the mean cycle leaves.
    explained: f64,
}

impl StrokeVariation {
    pub fn of(series: &Series, one: &SplitChannel) -> Self {
        let SplitChannel { at, part, left, .. } = one;
        let count = at.phase.len();
        let first = at.phase.first().copied().unwrap_or_default();
        // The last sample of a whole cycle lies a step before its end.
        let whole = (series.cycles() * (1.0 + 1.5 / count as f64)).min(count as f64) as usize;
        let sloped = count as f64 >= FOR_SLOPE * series.cycles();
        let fit = |k: usize| at.values[k] - left[k];
        // sum(x f), sum(f f), sum(l g), sum(g g), sum(l), count.
        let mut sums = vec![[0.0; 6]; whole];
        for k in 0..count {
            let Some(of) = sums.get_mut((at.phase[k] - first) as usize) else { continue };
            let f = fit(k) - part.mean;
            of[0] += (f + left[k]) * f;
            of[1] += f * f;
            of[4] += left[k];
            of[5] += 1.0;
            if sloped && k > 0 && k + 1 < count {
                let slope = (fit(k + 1) - fit(k - 1)) / (at.phase[k + 1] - at.phase[k - 1]);
                of[2] += left[k] * slope;
                of[3] += slope * slope;
            }
        }
        let explained = |[xf, ff, _, _, l, n]: &[f64; 6]| {
            (xf - ff).powi(2) / ff.max(f64::MIN_POSITIVE) + l * l / n.max(1.0)
        };
        let explained = sums.iter().map(explained).sum::<f64>() / count as f64;
        let sizes = CycleSpread::of(sums.iter().map(|of| [of[0], of[1]]), part.white);
        let late = if sloped { &sums[..] } else { &[] };
        Self { sizes, late: CycleSpread::of(late.iter().map(|of| [of[2], of[3]]), part.white), explained }
    }

    /// Variance (squares of the units of the channels) that neither repeats, nor is noise, nor comes of other sizes and levels of the cycles.
    pub fn left(&self, part: &ChannelParts) -> f64 {
        (part.slow - self.explained).max(0.0)
    }

    /// Whether sizes explain most of what does not repeat.
    pub fn differ(&self, part: &ChannelParts) -> bool {
        self.sizes.is_told() && self.explained > 0.5 * part.slow
    }

    /// The findings that the cycles differ in size, and that they grow or shrink from start to end by a straight line.
    pub fn sizes(&self, series: &Series, one: &SplitChannel) -> Vec<Finding> {
        let CycleSpread { mean, .. } = self.sizes;
        if !(mean > 0.0 && self.sizes.is_told()) {
            return Vec::new();
        }
        let size = self.sizes.size() / mean;
        let of = |limit: &'static JudgedLimit, size: f64, how: &str| {
            let text = format!(
                "the sizes of its cycles {how} by {:.0} %{}: the mean cycle {}; cut the file to its steady part",
                100.0 * size,
                if how == "differ" { " (rms)" } else { " from start to end" },
                if limit.status.is_some() { "is that of none of them" } else { "lies between theirs" }
            );
            Finding::new("data.not_periodic", limit, series.about(one.channel.name), size, text)
        };
        vec![
            of(&SCATTER, size, "differ"),
            of(&TREND, (self.sizes.trend()[0] / mean).abs(), "change"),
            of(&DIFFERS, size, "differ"),
        ]
    }

    /// The findings that the cycles come early and late.
    pub fn phases(&self, series: &Series, one: &SplitChannel) -> Vec<Finding> {
        if !self.late.is_told() {
            return Vec::new();
        }
        let size = 360.0 * self.late.size();
        let text = format!(
            "its cycles come early and late by {size:.0} deg (rms), as where the frequency drifts or the crank is unsteady: their mean is \
             flatter than each; give phases in place of times, or cut the file to its steady part"
        );
        let of = |limit| {
            Finding::new("data.not_periodic", limit, series.about(one.channel.name), size, text.clone())
        };
        vec![of(&PHASES), of(&EARLY)]
    }

    /// The finding that the cycles come later and later, or earlier, by a straight line: the frequency is another one.
    pub fn runs_away(&self, series: &Series, one: &SplitChannel, limits: &RunLimits) -> Option<Finding> {
        let [by, error] = self.late.trend();
        let told = self.late.is_told() && by.abs() > SURE * error;
        let (given, size) = (series.frequency_hz?, 360.0 * by.abs());
        // From begin to end a cycle passes less or more.
        let own = given * (1.0 + by / series.cycles());
        let text = format!(
            "its cycles come {} by {size:.1} deg from start to end: it repeats at {own:.4} Hz, and {given:.4} Hz is given for it",
            if by > 0.0 { "earlier" } else { "later" },
        );
        let away = series.purpose == Purpose::Datum && size > limits.of(&RUN_AWAY).0;
        let limit = if away { &RUN_AWAY } else { &RUNS };
        let about = series.about(one.channel.name);
        told.then(|| Finding::new("data.runs_away", limit, about, size, text).in_channel(one.channel.name))
    }
}

/// What is told of sizes that the wings change.
pub(super) fn explained(of: Finding, purpose: Purpose) -> Finding {
    let steady = if purpose == Purpose::Datum { ", which a steady case does not do" } else { "" };
    let text = format!(
        "{}; all loads change together, as where the wings rest, start or change their stroke{steady}",
        of.text
    );
    Finding { text, ..of }.explained(Cause::Strokes, purpose)
}

/// Correlation of the sizes of the cycles of two channels above which they change together, and the part of the one's spread that the
/// other's has at least. *Choices*: lift goes with the square of the stroke, drag with less.
const TOGETHER: f64 = 0.7;
const PART: f64 = 0.25;
/// Part of the spread that noise may have for sizes to be compared. *Choice.*
const KNOWN: f64 = 0.25;

/// Whether it is the wings that change the sizes of the cycles of channel `k`, as in bounding flight, a start, or a sweep of the stroke.
///
/// A wing changes all loads together; a channel whose gain fails is alone. Where all change together, the gain of the instrument and the
/// stroke are told apart by the noise, which comes after the stroke and before the gain. A file of one channel has its noise alone, one
/// without noise the other channels alone.
pub(super) fn are_of_wings(
    series: &Series,
    all: &[SplitChannel],
    strokes: &[StrokeVariation],
    k: usize,
) -> bool {
    let own = &strokes[k].sizes;
    if !series.purpose.is_loads() || !own.is_told() {
        return false;
    }
    let others = all.iter().zip(strokes).enumerate();
    let others =
        others.filter(|(other, (one, _))| *other != k && series.is_load(one.channel) && one.is_telling(all));
    let known: Vec<&CycleSpread> = others
        .map(|(_, (_, strokes))| &strokes.sizes)
        .filter(|sizes| sizes.noise < KNOWN * own.spread && sizes.mean > 0.0)
        .collect();
    let together = |other: &CycleSpread| {
        let products = own.of.iter().zip(&other.of).map(|(a, b)| (a - own.mean) * (b - other.mean));
        let product = products.sum::<f64>() / own.of.len() as f64;
        product > TOGETHER * (own.spread * other.spread).sqrt()
            && (other.spread / own.spread).sqrt() * own.mean > PART * other.mean
    };
    if !known.iter().all(|other| together(other)) {
        return false;
    }
    let small = own.of.iter().map(|size| size.abs()).fold(f64::MAX, f64::min);
    match noise_goes_along(series, &all[k], own) {
        Some(along) => !along,
        None => !known.is_empty() && small < RESTS * own.mean,
    }
}

/// Size of the smallest cycle over the mean one below which the wings rest or start, where no noise tells that the gain is kept. *Choice.*
const RESTS: f64 = 0.2;

/// Power of the ratio of the sizes of small and large cycles below which the ratio of their noise is nearer to that of a gain. *Choice.*
const ALONG: f64 = 0.7;

/// Whether the noise of the small cycles is smaller than that of the large ones as they are, by the medians of the third differences; none
/// where the noise is not seen.
fn noise_goes_along(series: &Series, one: &SplitChannel, sizes: &CycleSpread) -> Option<bool> {
    let (first, samples) = (series.phase.first()?, one.channel.samples);
    let mut groups: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
    let mut order = Order::default();
    for (p, of) in series.phase.iter().zip(samples.windows(4)) {
        let Some(size) = sizes.of.get((p - first) as usize) else { continue };
        let third = third(of);
        groups[usize::from(*size > sizes.mean)].push(third);
        order.add(third);
    }
    let [small, large] = groups.map(|mut of| deviation(&mut of));
    let mean = |large: bool| {
        let of = || sizes.of.iter().filter(|size| (**size > sizes.mean) == large).map(|size| size.abs());
        of().sum::<f64>() / of().count().max(1) as f64
    };
    let ratio = (mean(false) / mean(true)).max(f64::MIN_POSITIVE);
    let seen = order.is_noise() && large > Extent::of(samples)?.count;
    seen.then(|| small < large * ratio.powf(ALONG))
}
