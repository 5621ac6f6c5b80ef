//! Cycles that run backwards in time among others.

use std::f64::consts::TAU;

use super::cycle::Condensed;
use super::noise::median;
use super::{Finding, MeasuredChannel, Series};
use crate::limits::data::BACKWARDS;

/// Harmonics by which cycles are compared. *Choice.*
const HARMONICS: usize = 4;
/// Cycles of a file, and points of each, from which they are. *Choices.*
const CYCLES: usize = 8;
const POINTS: usize = 12;
/// Lags that are tried. *Choice.*
const LAGS: usize = 48;
/// Power of what the cycle leaves turned round, over that of the best lag as it is, and over that of the cycle, at most. *Choices*: of
/// noise alone, with seven degrees of freedom each, the ratio is below 1/4 once in 25, and so in three cycles in a row once in 16,000.
const BETTER: f64 = 0.25;
const LIKE: f64 = 0.2;
/// Cycles in a row that are turned round at one lag, and the steps between their lags. *Choices.*
const ROW: usize = 3;
const BY: usize = 3;

/// Complex amplitudes of the harmonics of a cycle.
type Amplitudes = [[f64; 2]; HARMONICS];

/// The finding that whole cycles fit the others by far better when they run backwards, all at one lag: a stretch that was written from its
/// end.
///
/// The sample at the phase p of a stretch from a to b is that of a + b - p. Harmonic h of its cycles has the amplitude
/// conj(C_h) exp(-i h (a + b)) for C_h. A cycle that comes early or late has C_h exp(-i h l): both have one number to be
/// fitted, so that neither is favoured. C_h is the median over the cycles.
pub(super) fn backwards(series: &Series, channel: &MeasuredChannel, at: &Condensed) -> Option<Finding> {
    let cycles = series.cycles();
    let first = *at.phase.first()?;
    let whole = (cycles * (1.0 + 1.5 / at.phase.len() as f64)) as usize;
    if whole < CYCLES || at.phase.len() < POINTS * whole {
        return None;
    }
    let all = amplitudes(at, first, whole);
    let usual = usual(&all);
    let power: f64 = usual.iter().map(|[a, b]| a * a + b * b).sum();
    let left = |own: &Amplitudes, turned: bool, lag: usize| -> f64 {
        let by = |h: usize| (TAU * (h + 1) as f64 * lag as f64 / LAGS as f64).sin_cos();
        let each = (0..HARMONICS).map(|h| {
            let ([a, b], (sin, cos)) = (usual[h], by(h));
            let b = if turned { -b } else { b };
            (own[h][0] - a * cos - b * sin).powi(2) + (own[h][1] - b * cos + a * sin).powi(2)
        });
        each.sum()
    };
    let least = |own: &Amplitudes, turned: bool| {
        let of = (0..LAGS).map(|lag| (left(own, turned, lag), lag));
        of.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
    };
    let turned: Vec<Option<usize>> = all
        .iter()
        .map(|own| {
            if left(own, false, 0) < LIKE * power {
                return None;
            }
            let ((back, lag), (on, _)) = (least(own, true), least(own, false));
            (back < BETTER * on && back < LIKE * power).then_some(lag)
        })
        .collect();
    let near = |a: usize, b: usize| (a + LAGS - b) % LAGS <= BY || (b + LAGS - a) % LAGS <= BY;
    let one = |a: &Option<usize>, b: &Option<usize>| matches!((a, b), (Some(a), Some(b)) if near(*a, *b));
    let rows = turned.chunk_by(one).filter(|row| row[0].is_some() && row.len() >= ROW);
    let many: usize = rows.map(<[_]>::len).sum();
    let size = many as f64 / whole as f64;
    let text = format!(
        "{many} of {whole} cycles run backwards in time: a stretch was written from its end; leave it out, or turn it round"
    );
    (many > 0).then(|| {
        Finding::new("data.backwards", &BACKWARDS, series.about(channel.name), size, text)
            .in_channel(channel.name)
    })
}

/// Those of each whole cycle, by means over its points.
fn amplitudes(at: &Condensed, first: f64, whole: usize) -> Vec<Amplitudes> {
    let mut all = vec![([[0.0; 2]; HARMONICS], 0.0); whole];
    for (p, x) in at.phase.iter().zip(&at.values) {
        let Some((own, count)) = all.get_mut((p - first) as usize) else { continue };
        let (sin, cos) = (TAU * p).sin_cos();
        let (mut re, mut im) = (1.0, 0.0);
        for harmonic in own.iter_mut() {
            (re, im) = (re * cos - im * sin, re * sin + im * cos);
            harmonic[0] += x * re;
            harmonic[1] += x * im;
        }
        *count += 1.0;
    }
    let of = |(own, count): (Amplitudes, f64)| own.map(|[a, b]| [2.0 * a / count, 2.0 * b / count]);
    all.into_iter().map(of).collect()
}

/// Their medians.
fn usual(all: &[Amplitudes]) -> Amplitudes {
    let mut usual = [[0.0; 2]; HARMONICS];
    for (h, own) in usual.iter_mut().enumerate() {
        for (part, own) in own.iter_mut().enumerate() {
            *own = median(&mut all.iter().map(|of| of[h][part]).collect::<Vec<f64>>());
        }
    }
    usual
}
