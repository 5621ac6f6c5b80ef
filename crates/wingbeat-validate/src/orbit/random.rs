//! Gaits drawn at random: each has an orbit that closes and carries the weight, or a reason why there is none.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use wingbeat::math::Random;
use wingbeat::orbit::{Failure, measure};
use wingbeat::parallel;

use super::DRIVEN;
use crate::shipped::scenario;
use crate::{ComparisonRow, Error};

/// Gaits drawn.
const GAITS: u64 = 20;
/// Seed of the draws.
const SEED: u64 = 7;
/// Range of the factors of means and amplitudes, of what is added to phases, rad, and of the frequencies, Hz.
const FACTOR: [f64; 2] = [0.0, 2.0];
const LAG: [f64; 2] = [-PI, PI];
const FREQUENCY: [f64; 2] = [3.0, 12.0];
/// Largest condition missed by an orbit, SI, and of its lift over weight less 1.
const CLOSED: f64 = 1e-10;
const CARRIED: f64 = 1e-3;

/// How the search of a gait ended.
enum GaitEnd {
    Orbit,
    Named,
    Neither,
}

/// Overrides of the driven gait's series and frequency, each drawn.
fn drawn(gait: u64) -> Result<Vec<String>, Error> {
    let mut random = Random::stream(SEED, gait);
    let own = scenario(DRIVEN, &[])?;
    let mut overrides = Vec::new();
    for (i, link) in own.spec.robot.links.iter().enumerate() {
        let Some(series) = &link.driven else { continue };
        let key = format!("robot.links[{i}].driven");
        let mut scaled = |end: &str, value: f64| {
            let value = value * random.between(FACTOR[0], FACTOR[1]);
            overrides.push(format!("{key}.{end}={value:?}"));
        };
        scaled("mean_rad", series.mean_rad);
        for (n, harmonic) in series.harmonics.iter().enumerate() {
            scaled(&format!("harmonics[{n}].amplitude_rad"), harmonic.amplitude_rad);
        }
        for (n, harmonic) in series.harmonics.iter().enumerate() {
            let lag = harmonic.phase_rad + random.between(LAG[0], LAG[1]);
            overrides.push(format!("{key}.harmonics[{n}].phase_rad={:?}", lag.rem_euclid(TAU)));
        }
    }
    overrides
        .push(format!("robot.gait.fourier.frequency_hz={:?}", random.between(FREQUENCY[0], FREQUENCY[1])));
    Ok(overrides)
}

fn end(gait: u64) -> Result<GaitEnd, Error> {
    let overrides = drawn(gait)?;
    let scenario = scenario(DRIVEN, &overrides.iter().map(String::as_str).collect::<Vec<_>>())?;
    let cycle = scenario.cycle()?;
    let found = match scenario.find_orbit(&cycle, &mut |_, _| ControlFlow::Continue(()))? {
        Ok(found) => found,
        Err(Failure::Stopped) => return Ok(GaitEnd::Neither),
        Err(Failure::NotConverged { residual, .. } | Failure::Singular { residual, .. })
            if !residual.is_finite() =>
        {
            return Ok(GaitEnd::Neither);
        }
        Err(_) => return Ok(GaitEnd::Named),
    };
    let lift = measure(&cycle, &found.orbit, &[])?.lift_over_weight;
    let closed = found.residual <= CLOSED && (lift - 1.0).abs() <= CARRIED;
    Ok(if closed { GaitEnd::Orbit } else { GaitEnd::Neither })
}

pub(super) fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let gaits: Vec<u64> = (0..GAITS).collect();
    let ends: Vec<GaitEnd> =
        parallel::map(&gaits, |_, gait| end(*gait)).into_iter().collect::<Result<_, _>>()?;
    let count = |of: fn(&GaitEnd) -> bool| ends.iter().filter(|end| of(end)).count() as f64;
    let id = "trim.random";
    Ok(vec![
        ComparisonRow::judged(
            &format!("{id}.unnamed"),
            "own draws",
            "of 20 gaits with means, strokes, lags and frequency at random those without an orbit that closes and without a reason",
            count(|end| matches!(end, GaitEnd::Neither)),
            0.0,
            "",
        ),
        ComparisonRow::shown(
            &format!("{id}.orbits"),
            "own draws",
            "of the same those with an orbit",
            count(|end| matches!(end, GaitEnd::Orbit)),
            "",
        ),
    ])
}
