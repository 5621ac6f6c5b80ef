//! Mean cycles beside those that a model computes: reversed, swapped, scaled, shifted, dead.

use super::Finding;
use crate::limits::RunLimits;
use crate::limits::data::{
    BENT, DEAD, GAIN, LAGS, LARGEST, MEAN, REVERSED, SHIFT, SWAPPED, UNLIKE, UNRELATED,
};

/// Share of the largest computed channel of its unit below which a channel says nothing. *Choice*: what is zero by
/// symmetry is computed as rounding.
const TELLING: f64 = 0.05;
/// The same share above which a channel must resemble what is computed. *Choice*: a small one may be wrong, as drags are.
const LARGE: f64 = 0.5;
/// Correlation above which a gain means something, and one above which a lag does. *Choice.*
const ALIKE: [f64; 2] = [0.97, 0.8];
/// Correlation below the highest that another peak may have for its lag to count. *Choice.*
const ALMOST: f64 = 0.05;
/// Lag beyond which no slope makes it, deg. *Choice.*
const CLOCK: f64 = 30.0;
/// Difference of the gain from 1 beyond which the model, not the clock, makes a shift. *Choice.*
const SLOPE: f64 = 0.4;
/// Ranges over one another beyond which a load is told though its shape is another one. *Choice.*
const FAR: f64 = 3.0;
/// Correlation above which a channel is another one. *Choice.*
const ANOTHER: f64 = 0.9;
/// Share of the largest computed channel of its unit above which one must resemble it where another does. *Choice.*
const COUNTS: f64 = 0.2;

/// Share of the largest range of its unit that another channel must put into one for that to be told, and what the fit of both leaves of
/// its power. *Choice.*
const TALKS: [f64; 2] = [0.1, 0.04];

/// Part of what its own load leaves of the power of a channel that a bend leaves at most. *Choice.*
const BENDS: f64 = 0.15;

/// A measured cycle and a computed one, at the same even phases.
#[derive(Clone, Copy, Debug)]
pub struct CyclePair<'a> {
    /// Name of the channel.
    pub name: &'a str,
    /// Unit of both; channels of one unit are compared in size.
    pub unit: &'a str,
    /// What was measured, in the unit of the channel.
    pub measured: &'a [f64],
    /// What is computed, in the unit of the channel.
    pub computed: &'a [f64],
}

/// What a pair says.
struct PairComparison {
    /// Computed range over the largest of the unit.
    share: f64,
    /// Ranges.
    measured: f64,
    computed: f64,
    /// Correlation as they are, and at the best lag.
    now: f64,
    best: f64,
    /// The best lag, deg; positive where the measured cycle is behind.
    lag_deg: f64,
    /// Slope of measured over computed.
    gain: f64,
    /// Correlation by lag.
    all: Vec<f64>,
}

/// What of the measured cycles of `what` cannot be those that are computed.
pub fn compared(what: &str, pairs: &[CyclePair], limits: &RunLimits) -> Vec<Finding> {
    let told: Vec<PairComparison> = pairs.iter().map(|pair| PairComparison::of(pair, pairs)).collect();
    let telling: Vec<(&CyclePair, &PairComparison)> =
        pairs.iter().zip(&told).filter(|(_, told)| told.share > TELLING && told.computed > 0.0).collect();
    let about = |pair: &CyclePair| format!("{} of {what}", pair.name);
    let mut found = swapped(what, &telling);
    found.extend(repeated(what, &telling));
    found.extend(turned(what, &telling));
    found.extend(backwards(what, &telling));
    if !found.iter().any(|finding| finding.breaks(limits)) {
        found.extend(telling.iter().map(|(pair, told)| reversed(about(pair), told)));
        let dead = |(pair, told): &(&CyclePair, &PairComparison)| {
            dead(about(pair), pair, told).in_channel(pair.name)
        };
        found.extend(telling.iter().map(dead));
        found.extend(telling.iter().filter_map(|(pair, told)| scaled(about(pair), told)));
        found.extend(telling.iter().filter_map(|(pair, told)| in_another_unit(about(pair), pair, told)));
        found.extend(shifted(what, &telling));
        found.extend(apart_in_time(what, &telling));
        found.extend(unrelated(what, &telling));
        found.extend(unlike(what, &telling));
        found.extend(mixed(what, &telling));
        found.extend(rolled(what, &telling));
    }
    found.retain(|finding| finding.breaks(limits));
    found
}

/// The channel whose mean differs most from the computed one, in parts of its computed range; a channel that is small beside another one
/// of its unit counts in parts of that. None where as good as nothing is computed for the unit, as of the air in a vacuum.
pub fn mean_apart(what: &str, pairs: &[CyclePair]) -> Option<Finding> {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let size = |pair: &CyclePair| {
        let same = pairs.iter().filter(|other| other.unit == pair.unit);
        let most = same.map(|other| range(other.computed)).fold(0.0, f64::max);
        (mean(pair.measured) - mean(pair.computed)).abs()
            / range(pair.computed).max(TELLING * most).max(f64::MIN_POSITIVE)
    };
    let computed = |pair: &&CyclePair| {
        let same = || pairs.iter().filter(|other| other.unit == pair.unit);
        let most = |of: fn(&CyclePair) -> f64| same().map(of).fold(0.0, f64::max);
        most(|pair| range(pair.computed)) > TELLING * most(|pair| range(pair.measured))
    };
    let pair = pairs.iter().filter(computed).max_by(|a, b| size(a).total_cmp(&size(b)))?;
    let text = format!(
        "its mean is {:.3e} {unit}, computed are {:.3e} {unit}: the fixture's mass, where the body sits in the cell, the tare, or the mean \
         load of the air in the model may cause it",
        mean(pair.measured),
        mean(pair.computed),
        unit = pair.unit
    );
    let about = format!("{} of {what}", pair.name);
    Some(Finding::new("data.mean", &MEAN, about, size(pair), text).in_channel(pair.name))
}

impl PairComparison {
    fn of(pair: &CyclePair, all: &[CyclePair]) -> Self {
        let same = all.iter().filter(|other| other.unit == pair.unit);
        let most = same.map(|other| range(other.computed)).fold(0.0, f64::max);
        let (measured, computed) = (apart(pair.measured), apart(pair.computed));
        let count = measured.len().min(computed.len());
        let spread = product(&computed, &computed, 0);
        let size = (product(&measured, &measured, 0) * spread).sqrt();
        let at = |lag: usize| if size > 0.0 { product(&measured, &computed, lag) / size } else { 0.0 };
        let all: Vec<f64> = (0..count).map(at).collect();
        let best = nearest_peak(&all);
        let lag = 360.0 * best.0 as f64 / count.max(1) as f64;
        Self {
            share: range(pair.computed) / most.max(f64::MIN_POSITIVE),
            measured: range(pair.measured),
            computed: range(pair.computed),
            now: at(0),
            best: best.1,
            lag_deg: if lag > 180.0 { lag - 360.0 } else { lag },
            gain: product(&measured, &computed, best.0) / spread.max(f64::MIN_POSITIVE),
            all,
        }
    }
}

/// Of the peaks of a correlation by lag that nearly reach the highest, the one nearest to no lag, and its height: a load of the second
/// harmonic is alike half a cycle later.
fn nearest_peak(all: &[f64]) -> (usize, f64) {
    let count = all.len();
    let highest = all.iter().copied().fold(0.0, f64::max);
    let peak = |lag: &usize| {
        let [before, here, after] = [count - 1, 0, 1].map(|step| all[(lag + step) % count]);
        here > highest - ALMOST && here >= before && here >= after
    };
    let lag = (0..count).filter(peak).min_by_key(|lag| *lag.min(&(count - lag)));
    lag.map_or((0, 0.0), |lag| (lag, all[lag]))
}

fn range(of: &[f64]) -> f64 {
    let (low, high) = of.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    (high - low).max(0.0)
}

/// A cycle about its mean.
fn apart(of: &[f64]) -> Vec<f64> {
    let mean = of.iter().sum::<f64>() / of.len() as f64;
    of.iter().map(|x| x - mean).collect()
}

/// Mean product of two cycles, `b` later by `lag` phases.
fn product(a: &[f64], b: &[f64], lag: usize) -> f64 {
    let count = a.len().min(b.len());
    let lag = lag.min(count);
    let (early, late) = b[..count].split_at(count - lag);
    let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    (sum(&a[..lag], late) + sum(&a[lag..count], early)) / count as f64
}

/// Correlation of two cycles as they are.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (apart(a), apart(b));
    let size = (product(&a, &a, 0) * product(&b, &b, 0)).sqrt();
    if size > 0.0 { product(&a, &b, 0) / size } else { 0.0 }
}

fn reversed(about: String, told: &PairComparison) -> Finding {
    let text = format!(
        "has a correlation of {:.2} with what is computed: its sign is reversed, or its column is another one",
        told.now
    );
    Finding::new("data.reversed", &REVERSED, about, told.now, text)
}

/// Which of the `passes` of one case, each by its file and its mean cycle of the channel `name` at the same even phases, are those of most
/// others with the sign reversed: a plug that was turned between them. The others may be off by anything else. Cycles are in the unit of the
/// channel.
pub fn reversed_among(name: &str, passes: &[(&str, Vec<f64>)], limits: &RunLimits) -> Vec<Finding> {
    let of = |k: usize| {
        let others = passes.iter().enumerate().filter(|(other, _)| *other != k);
        let mut all: Vec<f64> = others.map(|(_, pass)| correlation(&passes[k].1, &pass.1)).collect();
        wingbeat_math::order::ascend(&mut all);
        // The upper median: of an even number more than half lie at or below it.
        let usual = *all.get(all.len() / 2)?;
        let text = format!(
            "has a correlation of {usual:.2} with the same channel of most other passes: its sign is reversed in some of them"
        );
        let about = format!("{name} of {}", passes[k].0);
        let found = Finding::new("data.reversed", &REVERSED, about, usual, text).in_channel(name);
        Some(found).filter(|found| found.breaks(limits))
    };
    (0..passes.len()).filter_map(of).collect()
}

/// Correlations by which all channels turned must fit at any lag, and fit better than as they are. *Choices*: models of attached flow and
/// of stall fit by 0.95 and more as they are.
const TURNED: [f64; 2] = [0.9, 0.2];

/// The finding that all channels together fit with the other sign alone. A phase that is taken from the force hides it: what is turned looks
/// as if it came half a cycle later, but for the even harmonics. Where all are reversed as they are, it is one of the two.
fn turned(what: &str, telling: &[(&CyclePair, &PairComparison)]) -> Option<Finding> {
    let large =
        || telling.iter().map(|(_, told)| *told).filter(|told| told.share > COUNTS && told.measured > 0.0);
    let weight: f64 = large().map(|told| told.share.powi(2)).sum();
    let count = large().map(|told| told.all.len()).min()?;
    let at = |lag: usize| large().map(|told| told.share.powi(2) * told.all[lag]).sum::<f64>() / weight;
    let most = (0..count).map(at).fold(f64::MIN, f64::max);
    let (least, lag) = (0..count).map(|lag| (at(lag), lag)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    // Where another channel is as computed, the one that is not is told by its name.
    let as_computed = telling.iter().any(|(_, told)| told.now > ALIKE[0]);
    let each = large().all(|told| told.all[lag] < 0.0) && !as_computed;
    let now = at(0);
    if large().count() > 1 && large().all(|told| told.now < REVERSED.value) && -now > TURNED[0] {
        let text = format!(
            "all channels together have a correlation of {now:.2} with what is computed: the cell is turned over, all signs are reversed, \
             or the phase is half a cycle off"
        );
        return Some(Finding::new("data.reversed", &REVERSED, what, now, text));
    }
    let text = format!(
        "all channels together have a correlation of {least:.2} with what is computed, and of {most:.2} at most: the cell is turned \
         over, or all signs are reversed"
    );
    (each && -least > TURNED[0] && -least - most > TURNED[1])
        .then(|| Finding::new("data.reversed", &REVERSED, what, least, text))
}

/// The finding that all channels together fit far better when the file runs backwards, at any lag, by the correlations of [`TURNED`]. Both
/// ways have the lag alone to be fitted; what is even in time fits as well either way.
fn backwards(what: &str, telling: &[(&CyclePair, &PairComparison)]) -> Option<Finding> {
    let large = || telling.iter().filter(|(_, told)| told.share > COUNTS && told.measured > 0.0);
    let weight: f64 = large().map(|(_, told)| told.share.powi(2)).sum();
    let count = large().map(|(_, told)| told.all.len()).min()?;
    let together = |of: &[(f64, Vec<f64>)]| {
        let at = |lag: usize| of.iter().map(|(share, all)| share * all[lag]).sum::<f64>() / weight;
        (0..count).map(at).fold(f64::MIN, f64::max)
    };
    let now = together(&large().map(|(_, told)| (told.share.powi(2), told.all.clone())).collect::<Vec<_>>());
    // Of most files it need not be asked.
    if now > TURNED[0] {
        return None;
    }
    let turned = |(pair, told): &(&CyclePair, &PairComparison)| {
        let computed: Vec<f64> = pair.computed.iter().rev().copied().collect();
        let backward = PairComparison::of(&CyclePair { computed: &computed, ..**pair }, &[**pair]);
        (told.share.powi(2), backward.all)
    };
    let back = together(&large().map(turned).collect::<Vec<_>>());
    let text = format!(
        "all channels together have a correlation of {back:.2} with what is computed when the file runs backwards, and of {now:.2} as it is: \
         its rows were written from the end"
    );
    (back > TURNED[0] && back - now > TURNED[1])
        .then(|| Finding::new("data.backwards", &REVERSED, what, -back, text))
}

fn dead(about: String, pair: &CyclePair, told: &PairComparison) -> Finding {
    let text = format!(
        "moves by {:.3e} {} where {:.3e} are computed: the channel is dead, its unit is another one, or the model \
         that computes it is wrong (aero.law)",
        told.measured, pair.unit, told.computed
    );
    Finding::new("data.dead", &DEAD, about, told.measured / told.computed, text)
}

fn scaled(about: String, told: &PairComparison) -> Option<Finding> {
    let text = format!(
        "is {:.3} times what is computed, and has its shape: a wrong gain looks like this, and so does a wrong \
         slope or density; weigh a known mass on the cell to tell them apart",
        told.gain
    );
    let alike = told.best > ALIKE[0] && told.measured > DEAD.value * told.computed;
    let ratio = told.measured / told.computed;
    // Of another shape as well, where a large load is several times too large or too small.
    let other = told.share > LARGE && !(1.0 / FAR..=FAR).contains(&ratio) && ratio > DEAD.value;
    match (alike, other) {
        (true, _) => Some(Finding::scaled(about, (told.gain - 1.0).abs(), text)),
        (false, true) => {
            let text = format!(
                "moves by {ratio:.3} times what is computed, in another shape: another unit or column"
            );
            Some(Finding::scaled(about, (ratio - 1.0).abs(), text))
        }
        (false, false) => None,
    }
}

fn in_another_unit(about: String, pair: &CyclePair, told: &PairComparison) -> Option<Finding> {
    let size = told.measured / told.computed;
    let text = format!(
        "moves by {:.3e} {} where {:.3e} are computed: its unit is another one, or its column",
        told.measured, pair.unit, told.computed
    );
    Some(Finding::new("data.scaled", &LARGEST, about, size, text))
}

/// The lag on which the channels agree, by the power that they lend it.
fn shifted(what: &str, telling: &[(&CyclePair, &PairComparison)]) -> Option<Finding> {
    let alike: Vec<&PairComparison> =
        telling.iter().map(|(_, told)| *told).filter(|told| told.best > ALIKE[1]).collect();
    let weight: f64 = alike.iter().map(|told| told.share.powi(2)).sum();
    if alike.is_empty() {
        return None;
    }
    let lag = alike.iter().map(|told| told.share.powi(2) * told.lag_deg).sum::<f64>() / weight;
    let text = format!(
        "is {:.1} deg {} what is computed: a shift of phase turns inertia and lift into drag; mend the time of the \
         first sample, or fit the phase of runs on a rig",
        lag.abs(),
        if lag > 0.0 { "behind" } else { "ahead of" }
    );
    let gain = alike.iter().map(|told| told.share.powi(2) * told.gain).sum::<f64>() / weight;
    let found = Finding::new("data.shift", &SHIFT, what, lag.abs(), text);
    // A slope that far off turns lift against inertia, and so the phase.
    Some(if (gain - 1.0).abs() > SLOPE && lag.abs() < CLOCK { found.noted() } else { found })
}

/// Channels of one file of which each is like its load, but at other times.
fn apart_in_time(what: &str, telling: &[(&CyclePair, &PairComparison)]) -> Option<Finding> {
    let alike = || telling.iter().filter(|(_, told)| told.best > ALIKE[1] && told.share > COUNTS);
    let mut worst: Option<(f64, &str, &str)> = None;
    for (a, one) in alike() {
        for (b, other) in alike() {
            let lag = (one.lag_deg - other.lag_deg).rem_euclid(360.0);
            let lag = lag.min(360.0 - lag);
            if worst.is_none_or(|(most, ..)| lag > most) {
                worst = Some((lag, a.name, b.name));
            }
        }
    }
    let (lag, a, b) = worst?;
    let text = format!(
        "{a} and {b} are each like what is computed, but {lag:.0} deg apart in phase: they were not sampled together, or one is reversed"
    );
    Some(Finding::new("data.lags", &LAGS, what, lag, text))
}

fn unrelated(what: &str, telling: &[(&CyclePair, &PairComparison)]) -> Option<Finding> {
    let large = telling.iter().filter(|(_, told)| told.share > LARGE);
    let best = large.map(|(_, told)| told.now.abs().max(told.best)).fold(f64::NAN, f64::max);
    let text = format!(
        "no large channel resembles what is computed at any phase (largest correlation {best:.2}): it is of another run, \
         of a multiple of the frequency, or noise"
    );
    (!telling.is_empty()).then(|| Finding::new("data.unrelated", &UNRELATED, what, best, text))
}

/// Channels that resemble nothing that is computed for them, though another does.
fn unlike(what: &str, telling: &[(&CyclePair, &PairComparison)]) -> Vec<Finding> {
    let best = |told: &PairComparison| told.now.abs().max(told.best);
    let well = telling.iter().any(|(_, told)| best(told) > ANOTHER);
    let large = telling.iter().filter(|(_, told)| well && told.share > COUNTS && told.measured > 0.0);
    large
        .map(|(pair, told)| {
            let size = best(told);
            let text = format!(
                "resembles what is computed for it by a correlation of {size:.2} at the best phase, though other channels do so well: \
                 another column, noise, or a load that the model does not have"
            );
            Finding::new("data.unlike", &UNLIKE, format!("{} of {what}", pair.name), size, text)
        })
        .collect()
}

/// Channels that are their own load and a part of another channel, where that one is as computed (cross talk, turned axes), or that are a
/// bent function of their own load (a poor amplifier).
fn mixed(what: &str, telling: &[(&CyclePair, &PairComparison)]) -> Vec<Finding> {
    let mut found = Vec::new();
    for (i, (pair, told)) in telling.iter().enumerate() {
        if !(told.share > COUNTS) || told.measured == 0.0 {
            continue;
        }
        let (x, own) = (apart(pair.measured), apart(pair.computed));
        let by = |second: &[f64]| PairRegression::of(&x, &own, second);
        let mut put = |id, limit, size: f64, text| {
            let finding = Finding::new(id, limit, format!("{} of {what}", pair.name), size, text);
            found.push(finding.noted().in_channel(pair.name));
        };
        let others = telling.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, of)| of);
        let others = others.filter(|(_, its)| its.now > ALIKE[0]);
        let talks = others.filter_map(|(other, its)| {
            let fit = by(&apart(other.measured))?;
            let size = fit.second.abs() * its.measured / told.computed;
            let told = told.now < ALIKE[0] && fit.left < TALKS[1] && fit.own > 0.5 && size > TALKS[0];
            told.then_some((other.name, size, fit))
        });
        if let Some((name, size, PairRegression { own, second, .. })) =
            talks.min_by(|a, b| a.2.left.total_cmp(&b.2.left))
        {
            let text = format!(
                "is {own:.2} times what is computed for it and {second:.2} times {name}: cross talk, or axes that are turned"
            );
            put("data.mixed", &GAIN, size, text);
            continue;
        }
        let largest = pair.computed.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        let bent = [1_i32, 2].map(|power| {
            let of = |c: &f64| c * (c.abs() / largest).powi(power);
            apart(&pair.computed.iter().map(of).collect::<Vec<_>>())
        });
        let halves = apart(&pair.computed.iter().map(|c| c.abs()).collect::<Vec<_>>());
        let best = bent.iter().chain([&halves]).filter_map(|second| by(second));
        if let Some(fit) = best.min_by(|a, b| a.left.total_cmp(&b.left))
            && fit.left < BENDS * (1.0 - told.now.powi(2))
        {
            let text = "is a bent function of what is computed for it: an amplifier that saturates or has two gains, or a poor calibration";
            put("data.bent", &BENT, (1.0 - told.now.powi(2)).sqrt(), text.into());
        }
    }
    found
}

/// Angle from which axes are turned (its sine), and the share of the power that the turned loads leave, of all and of what they leave as
/// they are. *Choices*: a model with a poor drag turns the force by some degrees.
const ROLLED: [f64; 3] = [0.3, 0.1, 0.5];

/// Two channels of one unit that fit far better when they are turned about the third axis: m = s R(angle) c by least squares, where
/// tan(angle) = sum(m2 c1 - m1 c2) / sum(m1 c1 + m2 c2).
fn rolled(what: &str, telling: &[(&CyclePair, &PairComparison)]) -> Option<Finding> {
    let pairs = telling.iter().enumerate().flat_map(|(k, a)| telling[..k].iter().map(move |b| [*b, *a]));
    let of = |[(a, _), (b, _)]: [(&CyclePair, &PairComparison); 2]| {
        let [m1, c1, m2, c2] = [a.measured, a.computed, b.measured, b.computed].map(apart);
        let (along, across) =
            (product(&m1, &c1, 0) + product(&m2, &c2, 0), product(&m2, &c1, 0) - product(&m1, &c2, 0));
        let power =
            (product(&m1, &m1, 0) + product(&m2, &m2, 0)) * (product(&c1, &c1, 0) + product(&c2, &c2, 0));
        let left = |of: f64| 1.0 - of / power;
        let [turned, now] = [left(along.powi(2) + across.powi(2)), left(along.max(0.0).powi(2))];
        let angle = across.atan2(along);
        let told =
            turned < ROLLED[1] && turned < ROLLED[2] * now && (angle.sin().abs() > ROLLED[0] || along < 0.0);
        told.then(|| (angle, format!("{}, {} of {what}", a.name, b.name)))
    };
    let one = pairs.filter(|[(a, _), (b, _)]| a.unit == b.unit && a.measured.len() == b.measured.len());
    let (angle, about) = one.filter_map(of).next()?;
    let text = format!(
        "fit far better when their axes are turned by {:.0} deg: the cell is mounted at another angle, or the axes are those of the wind",
        angle.to_degrees()
    );
    Some(Finding::new("data.mixed", &GAIN, about, angle.abs(), text).noted())
}

/// x = own c + second m by least squares, all about their means, and the share of the power of x that is left.
struct PairRegression {
    own: f64,
    second: f64,
    left: f64,
}

impl PairRegression {
    /// None of two of one shape, of which neither is told from the other.
    fn of(x: &[f64], own: &[f64], second: &[f64]) -> Option<Self> {
        let [cc, mm, cm] = [product(own, own, 0), product(second, second, 0), product(own, second, 0)];
        let [xc, xm, power] = [product(x, own, 0), product(x, second, 0), product(x, x, 0)];
        let spread = cc * mm - cm * cm;
        if !(spread > 0.01 * cc * mm) {
            return None;
        }
        let (own, second) = ((xc * mm - xm * cm) / spread, (xm * cc - xc * cm) / spread);
        Some(Self { own, second, left: 1.0 - (own * xc + second * xm) / power })
    }
}

/// Channels that hold the very values of another one, though other loads are computed for them; of two the one that fits worse.
fn repeated(what: &str, telling: &[(&CyclePair, &PairComparison)]) -> Vec<Finding> {
    let mut found = Vec::new();
    for (k, (pair, told)) in telling.iter().enumerate() {
        for (other, its) in &telling[..k] {
            let alike = correlation(pair.computed, other.computed).abs() > ALIKE[0];
            if alike || told.measured == 0.0 || pair.measured != other.measured {
                continue;
            }
            let (size, [name, from]) = match told.now.abs() < its.now.abs() {
                true => (its.now.abs() - told.now.abs(), [pair.name, other.name]),
                false => (told.now.abs() - its.now.abs(), [other.name, pair.name]),
            };
            let text = format!(
                "holds the very values of {from}, and does not fit what is computed for it: one column for two"
            );
            found.push(Finding::new("data.swapped", &SWAPPED, format!("{name} of {what}"), size, text));
        }
    }
    found
}

/// Channels of one unit that would each fit another one much better, as a permutation.
fn swapped(what: &str, telling: &[(&CyclePair, &PairComparison)]) -> Vec<Finding> {
    let of = |i: usize, j: usize| match telling[i].0.unit == telling[j].0.unit {
        true => correlation(telling[i].0.measured, telling[j].0.computed).abs(),
        false => 0.0,
    };
    let all = || 0..telling.len();
    let best = |i: usize| all().max_by(|a, b| of(i, *a).total_cmp(&of(i, *b))).unwrap_or(i);
    let to: Vec<usize> = all().map(best).collect();
    let whole = all().all(|j| to.contains(&j));
    let moved = all().filter(|i| whole && to[*i] != *i && of(*i, to[*i]) > ANOTHER);
    moved
        .map(|i| {
            let (name, other) = (telling[i].0.name, telling[to[i]].0.name);
            let text = format!(
                "fits {other} (correlation {:.2}) and not {name} ({:.2}): channels are swapped",
                of(i, to[i]),
                of(i, i)
            );
            Finding::new("data.swapped", &SWAPPED, format!("{name} of {what}"), of(i, to[i]) - of(i, i), text)
        })
        .collect()
}
