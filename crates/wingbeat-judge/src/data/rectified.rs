//! Loads of which only the magnitude was kept.

use super::cycle::{HARMONICS, variance};
use super::outliers::place;
use super::values::Extent;
use super::{Finding, MeasuredChannel, Series};
use crate::limits::data::RECTIFIED;
use wingbeat_math::Harmonics;

/// Most points of the mean cycle, and fewest in which a cusp is told from a smooth minimum. *Choice.*
const POINTS: std::ops::RangeInclusive<usize> = 24..=64;
/// Part of the largest sample that one of the other sign has in a channel that keeps its sign but for noise, at most. *Choice.*
const SIGNED: f64 = 0.3;
/// Part of the largest value, times the places of the cycle, below which it counts as touching zero, and above which it has left it. *Choice*:
/// a sine rises by 6.3 over the places from one to the next, and half of that lies beside zero.
const TOUCHES: [f64; 2] = [3.6, 7.2];
/// Part of the largest value by which noise may carry it across zero. *Choice.*
const ACROSS: f64 = 0.05;
/// Share of the variance that the harmonics must leave for a cusp to be seen. *Choice*: those of |sin| leave 1e-3.
const SEEN: f64 = 2e-4;

/// The finding that a channel keeps one sign, and that its cycle is a smooth one with every second arch turned over.
///
/// |y| has a cusp where y crosses zero, which harmonics follow poorly; y itself has none.
pub(super) fn rectified(series: &Series, channel: &MeasuredChannel, extent: Extent) -> Option<Finding> {
    let [least, largest] = [extent.low.abs().min(extent.high.abs()), extent.low.abs().max(extent.high.abs())];
    if extent.low < 0.0 && extent.high > 0.0 && least > SIGNED * largest {
        return None;
    }
    let (phase, mut cycle) = mean_cycle(series.phase, channel.samples, series.cycles())?;
    let turned = cycle.iter().sum::<f64>().signum();
    cycle.iter_mut().for_each(|y| *y *= turned);
    let most = cycle.iter().fold(0.0_f64, |most, y| most.max(*y));
    let touches = touches(&cycle, most);
    if touches.is_empty() || touches.len() % 2 == 1 || cycle.iter().any(|y| *y < -ACROSS * most) {
        return None;
    }
    // The points at the touches may lie on either side of them: they tell nothing.
    let clear: Vec<usize> = (0..cycle.len()).filter(|k| !touches.contains(k)).collect();
    let of = |from: &[f64]| -> Vec<f64> { clear.iter().map(|k| from[*k]).collect() };
    let (phase, folded) = (of(&phase), of(&cycle));
    let turns = |k: &usize| touches.iter().filter(|touch| *touch < k).count() % 2 == 1;
    let unfolded: Vec<f64> = clear.iter().map(|k| if turns(k) { -cycle[*k] } else { cycle[*k] }).collect();
    let (whole, folded) = (variance(&folded), left(&phase, &folded)?);
    let size = folded / left(&phase, &unfolded)?.max(f64::MIN_POSITIVE);
    let text = "keeps one sign, and its cycle is smooth only if every second half wave is inverted: the file holds the \
                magnitude of the load; export it with its sign";
    let found = || Finding::new("data.rectified", &RECTIFIED, series.about(channel.name), size, text);
    // A channel that is no component may be a magnitude by its meaning.
    let component = channel.name.ends_with(['x', 'y', 'z', 'X', 'Y', 'Z']);
    (folded > SEEN * whole).then(|| if component { found() } else { found().noted() })
}

/// Phases and values of the mean cycle at even shares of the samples; none of too few.
fn mean_cycle(phase: &[f64], samples: &[f64], cycles: f64) -> Option<(Vec<f64>, Vec<f64>)> {
    let points = (phase.len() as f64 / cycles.max(1.0)) as usize;
    if points < *POINTS.start() {
        return None;
    }
    let points = points.min(*POINTS.end());
    let mut sums = vec![(0.0, 0.0, 0.0); points];
    for (p, y) in phase.iter().zip(samples) {
        let sum = &mut sums[place(*p, points)];
        *sum = (sum.0 + 1.0, sum.1 + p - p.floor(), sum.2 + y);
    }
    sums.retain(|sum| sum.0 > 0.0);
    (sums.len() >= *POINTS.start()).then(|| sums.iter().map(|(n, p, y)| (p / n, y / n)).unzip())
}

/// The lowest points of the stretches in which the cycle touches zero, in order.
fn touches(cycle: &[f64], most: f64) -> Vec<usize> {
    let [low, high] = TOUCHES.map(|part| part * most / cycle.len() as f64);
    let Some(start) = cycle.iter().position(|y| *y > high) else { return Vec::new() };
    let mut found: Vec<usize> = Vec::new();
    let mut lowest: Option<usize> = None;
    for k in (start..start + cycle.len() + 1).map(|k| k % cycle.len()) {
        if cycle[k] > high {
            found.extend(lowest.take());
        } else if cycle[k] < low && lowest.is_none_or(|least| cycle[k] < cycle[least]) {
            lowest = Some(k);
        }
    }
    found.sort_unstable();
    found
}

/// Mean square of what the harmonics leave.
fn left(phase: &[f64], values: &[f64]) -> Option<f64> {
    let harmonics = HARMONICS.min(values.len() / 4);
    let cycle = Harmonics::fitted(1.0, phase, values, harmonics)?;
    let squares: f64 = phase.iter().zip(values).map(|(p, y)| (y - cycle.at(*p)).powi(2)).sum();
    Some(squares / values.len() as f64)
}
