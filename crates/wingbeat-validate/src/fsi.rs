//! Elastic wings and the air that moves them.

pub mod beam;
mod element;
mod energy;
mod flap;
pub mod flapping;
pub mod flight;
mod flutter;
pub mod goland;
pub mod membrane;
pub mod pazy;
pub mod section;
mod soft;
mod stiff;
pub mod theodorsen;

use crate::aero_full::ComparedPreset;
use crate::{Case, ComparisonRow, Error};
use section::TypicalSection;

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "fsi.added_mass_frequency", quick: true, run: added_mass_frequency },
    Case { id: "fsi.divergence", quick: true, run: divergence },
    Case { id: "fsi.flutter", quick: false, run: flutter::rows },
    Case { id: "fsi.energy", quick: true, run: energy::rows },
    Case { id: "fsi.element", quick: true, run: element::rows },
    Case { id: "fsi.flap.rest", quick: true, run: flap::rest },
    Case { id: "fsi.flap.moving", quick: true, run: flap::moving },
    Case { id: "fsi.flap.energy", quick: true, run: flap::energy },
    Case { id: "fsi.flap.flight", quick: false, run: energy::flap_rows },
    Case { id: "fsi.stiff", quick: true, run: stiff::rows },
    Case { id: "fsi.springs", quick: true, run: soft::springs },
    Case { id: "fsi.lattice", quick: true, run: soft::bends },
];

/// A complex number.
type C = nalgebra::Complex<f64>;

/// Distance of the elastic axis behind the leading edge, chords.
const AXIS: f64 = 0.35;

/// Largest relative difference between pairs of numbers.
fn worst(pairs: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    pairs.into_iter().fold(0.0, |worst: f64, (value, exact)| worst.max((value / exact - 1.0).abs()))
}

/// Frequencies of the coupled plate in still air, rad/s, beside those of the structure with the air
/// that a flat plate carries (Theodorsen 1935): per unit span pi rho b2 at mid chord and
/// pi rho b4 / 8 about it.
fn still_air(preset: ComparedPreset) -> Result<Vec<(f64, f64)>, Error> {
    let mut pairs = Vec::new();
    for mass_ratio in [2.0, 10.0, 50.0] {
        let section = TypicalSection { mass_ratio, unbalance: 0.2, frequency_ratio: 0.6, axis: AXIS };
        let mut found: Vec<f64> = section.eigenvalues(preset, 0.0)?.iter().map(|s| s.im).collect();
        found.retain(|omega| *omega > 0.1);
        wingbeat::math::order::ascend(&mut found);
        let exact = section.frequencies_with_carried_air();
        if found.len() != exact.len() {
            return Err(Error::NoAnswer(format!("{} oscillations of a plate on two springs", found.len())));
        }
        pairs.extend(found.into_iter().zip(exact));
    }
    Ok(pairs)
}

fn added_mass_frequency() -> Result<Vec<ComparisonRow>, Error> {
    let (id, source) = ("fsi.added_mass_frequency", "eigenvalue of the 2 x 2 system by hand");
    let metric =
        "max relative error of the frequencies, heave and pitch coupled in still air, mass ratio 2, 10, 50";
    let full = format!("{metric}, preset full");
    Ok(vec![
        ComparisonRow::judged(id, source, metric, worst(still_air(ComparedPreset::Paper)?), 1e-3, ""),
        ComparisonRow::shown(
            &format!("{id}.full"),
            source,
            &full,
            worst(still_air(ComparedPreset::Full)?),
            "",
        ),
    ])
}

/// Dynamic pressure of divergence over K / (S e a0).
fn divergence_of(preset: ComparedPreset) -> Result<(f64, f64), Error> {
    let section = TypicalSection { mass_ratio: 20.0, unbalance: 0.1, frequency_ratio: 0.3, axis: AXIS };
    let exact = section.divergence_speed();
    let growth = |speed: f64| {
        let real = section.eigenvalues(preset, speed)?.into_iter().filter(|s| s.im.abs() < 1e-6);
        Ok(real.map(|s| s.re).fold(f64::NEG_INFINITY, f64::max))
    };
    let speed = section::crossing(growth, 0.7 * exact, 1.3 * exact)?;
    Ok((speed * speed, exact * exact))
}

fn divergence() -> Result<Vec<ComparisonRow>, Error> {
    let (id, source) = ("fsi.divergence", "q = K / (S e a0)");
    let metric = "relative error of the dynamic pressure where a real eigenvalue crosses zero, AR 1e5";
    let full = format!("{metric}, preset full");
    Ok(vec![
        ComparisonRow::judged(id, source, metric, worst([divergence_of(ComparedPreset::Paper)?]), 0.01, ""),
        ComparisonRow::shown(
            &format!("{id}.full"),
            source,
            &full,
            worst([divergence_of(ComparedPreset::Full)?]),
            "",
        ),
    ])
}
