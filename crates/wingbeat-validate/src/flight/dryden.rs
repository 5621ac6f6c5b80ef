//! Continuous turbulence: variance and spectra of long courses against the closed form.

use std::f64::consts::{PI, TAU};

use wingbeat::math::Vec3;
use wingbeat::robot::{Dryden, Wind};

use crate::{ComparisonRow, Error};

/// What is sampled: of one scale, so that the parts resolve the corner of each spectrum.
const SAMPLED: Dryden = Dryden { deviation: [0.5, 0.4, 0.3], length: [2.0; 3], airspeed: 4.0 };
/// Nodes of a part whose spectrum is taken, and parts.
const PART: usize = 2048;
const PARTS: usize = 2000;
/// Frequencies, in multiples of that of a part; each stands for itself and its four neighbours.
const PLACES: [usize; 5] = [3, 6, 12, 24, 48];
/// What is asked, of variance and spectra alike.
const WITHIN: f64 = 0.05;

/// The comparisons.
pub(super) fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let of = SAMPLED;
    let duration = (PART * PARTS) as f64 * of.step();
    let wind = Wind::steady(Vec3::ZERO).turbulent(&of, 0.0, duration, 1);
    let mut rows = Vec::new();
    for (axis, name) in ["along", "left", "up"].into_iter().enumerate() {
        // Half way between nodes as often as at them: the course is linear there.
        let samples: Vec<f64> =
            (0..2 * PART * PARTS).map(|k| wind.at(0.5 * k as f64 * of.step()).0[axis]).collect();
        let variance = samples.iter().map(|v| v * v).sum::<f64>() / samples.len() as f64;
        let expected = of.deviation[axis].powi(2);
        // Half way between nodes, where the straight course has least variance.
        let between: Vec<f64> = samples.into_iter().skip(1).step_by(2).collect();
        let worst = (spectrum(&between, of.step()).into_iter())
            .map(|(places, density)| {
                let closed: f64 = places.iter().map(|omega| of_axis(&of, axis, *omega)).sum();
                (density * places.len() as f64 / closed - 1.0).abs()
            })
            .fold(0.0, f64::max);
        let source = "Dryden's spectra, MIL-F-8785C";
        let of = |what: &str| format!("{what} of the component {name}, relative to the closed form");
        let mut judged = |end: &str, what: &str, value: f64| {
            rows.push(ComparisonRow::judged(
                &format!("flight.dryden.{end}.{name}"),
                source,
                &of(what),
                value,
                WITHIN,
                "",
            ));
        };
        judged("variance", "error of the variance", (variance / expected - 1.0).abs());
        judged("spectrum", "largest error of the spectral density at five frequencies", worst);
    }
    Ok(rows)
}

/// Two-sided density of the component `axis` at `omega` rad/s, (m/s)^2 s/rad; half of that from 0 on.
fn of_axis(of: &Dryden, axis: usize, omega: f64) -> f64 {
    let (time, x) = (of.length[axis] / of.airspeed, of.length[axis] * omega / of.airspeed);
    let one = of.deviation[axis].powi(2) * time / PI;
    match axis {
        0 => one / (1.0 + x * x),
        _ => 0.5 * one * (1.0 + 3.0 * x * x) / (1.0 + x * x).powi(2),
    }
}

/// Mean density of the parts of `samples` under Hann's window about each place, with its frequencies, rad/s.
fn spectrum(samples: &[f64], step: f64) -> Vec<(Vec<f64>, f64)> {
    let window: Vec<f64> = (0..PART).map(|k| 0.5 - 0.5 * (TAU * k as f64 / PART as f64).cos()).collect();
    let power: f64 = window.iter().map(|w| w * w).sum();
    let density = |place: usize| {
        let wave: Vec<(f64, f64)> = (0..PART)
            .map(|k| {
                let (sin, cos) = (TAU * (place * k % PART) as f64 / PART as f64).sin_cos();
                (window[k] * cos, window[k] * sin)
            })
            .collect();
        let each = samples.chunks_exact(PART).map(|part| {
            let (mut re, mut im) = (0.0, 0.0);
            for (v, (cos, sin)) in part.iter().zip(&wave) {
                re += v * cos;
                im += v * sin;
            }
            re * re + im * im
        });
        each.sum::<f64>() / PARTS as f64 * step / (TAU * power)
    };
    let about = |place: &usize| {
        let places = [place - 2, place - 1, *place, place + 1, place + 2];
        let omegas = places.map(|place| TAU * place as f64 / (PART as f64 * step));
        (omegas.to_vec(), places.into_iter().map(density).sum::<f64>() / places.len() as f64)
    };
    PLACES.iter().map(about).collect()
}
