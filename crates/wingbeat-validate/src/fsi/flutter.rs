//! Flutter of the typical section: where an eigenvalue of the linearised robot crosses.

use super::section::{TypicalSection, crossing};
use super::theodorsen::{self, Flutter};
use super::{AXIS, worst};
use crate::aero_full::ComparedPreset;
use crate::{ComparisonRow, Error};

/// Least frequency of what counts as an oscillation of the structure, in pitch frequencies.
const OSCILLATION: f64 = 0.05;

/// The sections compared.
fn sections() -> impl Iterator<Item = TypicalSection> {
    let of = |mass_ratio: f64| {
        [0.1, 0.2].into_iter().flat_map(move |unbalance| {
            [0.3, 0.6].map(|frequency_ratio| TypicalSection {
                mass_ratio,
                unbalance,
                frequency_ratio,
                axis: AXIS,
            })
        })
    };
    [10.0, 20.0, 50.0].into_iter().flat_map(of)
}

/// Growth rate and frequency of the least damped oscillation at `speed` m/s.
fn least_damped(section: &TypicalSection, preset: ComparedPreset, speed: f64) -> Result<(f64, f64), Error> {
    let eigenvalues = section.eigenvalues(preset, speed)?;
    let oscillations = eigenvalues.iter().filter(|s| s.im > OSCILLATION);
    let least = oscillations.max_by(|a, b| a.re.total_cmp(&b.re));
    least.map(|s| (s.re, s.im)).ok_or_else(|| Error::NoAnswer(format!("no oscillation at {speed} m/s")))
}

/// The lowest speed of flutter of the library's model, the pitch frequency being 1 rad/s and the
/// semi-chord 0.5 m. `near` bounds the search: from a third of it on, to twice.
fn flutter(section: &TypicalSection, preset: ComparedPreset, near: f64) -> Result<Flutter, Error> {
    const STEPS: usize = 40;
    let growth = |speed: f64| least_damped(section, preset, speed).map(|(growth, _)| growth);
    let speeds = (0..=STEPS).map(|i| near * (0.33 + 1.67 * i as f64 / STEPS as f64));
    let mut before = None;
    for speed in speeds {
        if growth(speed)? < 0.0 {
            before = Some(speed);
            continue;
        }
        let stable = before.ok_or_else(|| Error::NoAnswer(format!("flutter below {speed} m/s")))?;
        let speed = crossing(growth, stable, speed)?;
        let frequency = least_damped(section, preset, speed)?.1;
        return Ok(Flutter { speed: speed / TypicalSection::SEMI_CHORD, frequency });
    }
    Err(Error::NoAnswer(format!("no flutter up to {} m/s", 2.0 * near)))
}

/// Pairs of speeds and of frequencies, the library's first.
fn compared(preset: ComparedPreset) -> Result<Vec<[(f64, f64); 2]>, Error> {
    let pair = |section: TypicalSection| {
        let exact = theodorsen::flutter(&section)
            .ok_or_else(|| Error::NoAnswer(format!("no flutter by Theodorsen: {section:?}")))?;
        let found = flutter(&section, preset, exact.speed * TypicalSection::SEMI_CHORD)?;
        Ok([(found.speed, exact.speed), (found.frequency, exact.frequency)])
    };
    sections().map(pair).collect()
}

/// The rows: speed and frequency, judged for preset `paper`.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = Vec::new();
    for (preset, limit, ids) in [
        (ComparedPreset::Paper, Some(0.02), ["fsi.flutter", "fsi.flutter.frequency"]),
        (ComparedPreset::Full, None, ["fsi.flutter.full", "fsi.flutter.full_frequency"]),
    ] {
        let pairs = compared(preset)?;
        for (i, quantity) in ["speed", "frequency"].into_iter().enumerate() {
            let metric = format!(
                "max relative error of the {quantity} of flutter, 12 sections, AR 1e5, preset {}",
                preset.name()
            );
            let value = worst(pairs.iter().map(|pair| pair[i]));
            rows.push(ComparisonRow {
                limit,
                ..ComparisonRow::shown(ids[i], "Theodorsen 1935, k method", &metric, value, "")
            });
        }
    }
    Ok(rows)
}
