//! A channel that was cut off before noise was added: its end is flat, and quieter than the rest of the cycle.

use super::outliers::{OF_MEDIAN, median, place};
use super::{Channel, Finding, Series};
use crate::limits::data::CLIPPED;

/// Places of the cycle at least and at most, and samples of each at least. *Choice.*
const PLACES: [usize; 2] = [24, 64];
const SAME: usize = 12;
/// Part of the range within which the end is flat, and the places on it, in parts of a cycle. A slack line is flat for longer. *Choices.*
const FLAT: f64 = 0.01;
const SHARE: std::ops::Range<f64> = 0.05..0.36;
/// Part of the range within which an end is near zero. *Choice.*
const SLACK: f64 = 0.15;
/// Noise at the end over that elsewhere: what is cut off has that of the converter alone. Right loads went down to 0.54 in the
/// worst of 2000 files (measured). *Choice.*
const QUIET: f64 = 0.5;
/// Noise in parts of the range and in counts of the converter at least, for less of it to be seen. *Choice.*
const NOISE: [f64; 2] = [0.002, 2.0];

/// Mean, and noise about a line, of the samples of a place.
#[derive(Clone, Copy)]
struct Place {
    mean: f64,
    noise: f64,
}

/// The finding that an end is cut off under noise; `count` is that of the converter.
///
/// What goes beyond the range of an amplifier is lost with the noise that it has until there, so that the samples of one phase
/// scatter less at the end than elsewhere. A line that goes slack is flat and may be quiet as well, but near zero, and for longer:
/// an end near zero counts only where the other one is flat and quiet too.
pub(super) fn cut_off(series: &Series, channel: &Channel, count: f64) -> Option<Finding> {
    let places = places(series, channel.samples)?;
    let (low, high) = places.iter().fold((f64::MAX, f64::MIN), |(l, h), of| (l.min(of.mean), h.max(of.mean)));
    let range = high - low;
    let noise = median(&mut places.iter().map(|of| of.noise).collect::<Vec<_>>());
    let within = (FLAT * range).max(3.0 * noise / (series.phase.len() as f64 / places.len() as f64).sqrt());
    let share = |end: f64| {
        let (on, off): (Vec<Place>, Vec<Place>) =
            places.iter().partition(|of| (of.mean - end).abs() <= within);
        let noise = |of: Vec<Place>| median(&mut of.iter().map(|place| place.noise).collect::<Vec<_>>());
        let share = on.len() as f64 / places.len() as f64;
        let usual = noise(off);
        let seen = usual > (NOISE[0] * range).max(NOISE[1] * count);
        (seen && SHARE.contains(&share) && noise(on) < QUIET * usual).then_some(share)
    };
    let far = |end: f64| end.abs() > SLACK * range;
    let (top, bottom) = (share(high), share(low));
    let (share, end) = match (top, bottom) {
        (Some(top), Some(bottom)) => (top + bottom, if top > bottom { high } else { low }),
        (Some(top), None) if far(high) => (top, high),
        (None, Some(bottom)) if far(low) => (bottom, low),
        _ => return None,
    };
    let text = format!(
        "is flat at {end:.4} {} for {:.0} % of the cycle, and scatters less than half as much there as elsewhere: cut off before the \
         noise came to it, so that means and harmonics are too small; take a wider range",
        channel.unit,
        100.0 * share
    );
    Some(Finding::new("data.clipped", &CLIPPED, series.about(channel.name), share, text))
}

/// The places of the cycle; none where the samples of a place are too few.
fn places(series: &Series, samples: &[f64]) -> Option<Vec<Place>> {
    let per_cycle = samples.len() as f64 / series.cycles().max(1.0);
    let count = PLACES[1].min(samples.len() / SAME).min(per_cycle as usize);
    if count < PLACES[0] {
        return None;
    }
    let mut there = vec![Vec::new(); count];
    for (p, x) in series.phase.iter().zip(samples) {
        let within = (p.rem_euclid(1.0) * count as f64).fract() - 0.5;
        there[place(*p, count)].push((within, *x));
    }
    there.iter().map(|of| (of.len() >= SAME).then(|| Place::of(of))).collect()
}

impl Place {
    fn of(samples: &[(f64, f64)]) -> Self {
        let count = samples.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| samples.iter().map(of).sum::<f64>() / count;
        let (u, x) = (mean(&|s| s.0), mean(&|s| s.1));
        let (uu, ux) = (mean(&|s| (s.0 - u).powi(2)), mean(&|s| (s.0 - u) * (s.1 - x)));
        // Of samples that all have one phase there is no slope.
        let slope = if uu > 1e-6 { ux / uu } else { 0.0 };
        let mut left: Vec<f64> = samples.iter().map(|s| (s.1 - x - slope * (s.0 - u)).abs()).collect();
        Self { mean: x - slope * u, noise: OF_MEDIAN * median(&mut left) }
    }
}
