//! Small motions of rectangular wings, against the linear lifting surface and exact solutions in two dimensions.

use super::wings::{CHORD, CORE, SMALL, harmonic, lan, loads, loads_with, rectangle, wave};
use crate::{ComparisonRow, Error, reference_table};
use std::f64::consts::PI;
use wingbeat::math::Vec3;
use wingbeat_lattice::course::CourseRequest;

/// Span of a wing without ends, chords.
const ENDLESS: f64 = 1e4;
/// Way travelled until a start is forgotten on a wing with ends, chords.
const FORGOTTEN: f64 = 20.0;
const SURFACE: &str = "linear lifting surface";

/// Steady lift slope, 1/rad: a step so long that the last rings are horseshoes.
pub fn steady_slope(aspect: f64, chordwise: usize, spanwise: usize) -> Result<f64, Error> {
    let mut wing = rectangle(aspect)?;
    wing.wind = Vec3::new(-SMALL.cos(), 0.0, SMALL.sin());
    let run = loads(&wing, lan(chordwise, spanwise), Some(1e4 * CHORD), 2)?;
    let force = run[1].joukowski.force;
    Ok((force[0] * SMALL.sin() + force[2] * SMALL.cos()) / (0.5 * aspect * CHORD * CHORD * SMALL))
}

/// Worst error of the slope at 8 x 24 panels, and extrapolated from 4 and 8 chordwise ones.
pub fn slope() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("lifting_surface/steady.csv")?;
    let (mut plain, mut limit): (f64, f64) = (0.0, 0.0);
    for (aspect, exact) in table.column("AR")?.into_iter().zip(table.column("CLalpha_12x120")?) {
        let (coarse, fine) = (steady_slope(aspect, 4, 24)?, steady_slope(aspect, 8, 24)?);
        plain = plain.max((fine / exact - 1.0).abs());
        limit = limit.max((extrapolated(coarse, fine) / exact - 1.0).abs());
    }
    let row =
        |id: &str, metric: &str, value, limit| ComparisonRow::judged(id, SURFACE, metric, value, limit, "");
    Ok(vec![
        row("lattice.slope.panels_8_24", "AR 1 to 20, 8 x 24 panels: worst error of the slope", plain, 0.025),
        row("lattice.slope.extrapolated", "the same extrapolated from 4 and 8", limit, 0.01),
    ])
}

/// The limit of values at panels of a length and of half of it, in the unit of these: their error falls as the square of the length (`lattice.convergence`).
pub fn extrapolated(coarse: f64, fine: f64) -> f64 {
    (4.0 * fine - coarse) / 3.0
}

/// Lift over incidence after a sudden start at the times of the table, by aspect ratio.
fn started(aspect: f64, chordwise: usize, spanwise: usize, ways: &[f64]) -> Result<Vec<f64>, Error> {
    let mut wing = rectangle(aspect)?;
    wing.wind = Vec3::new(-SMALL.cos(), 0.0, SMALL.sin());
    let longest = ways.iter().fold(0.0_f64, |most, s| most.max(*s));
    let steps = (0.5 * longest * chordwise as f64).round() as usize + 1;
    let run = loads(&wing, lan(chordwise, spanwise), None, steps)?;
    let at = |s: &f64| (0.5 * s * chordwise as f64).round() as usize;
    let scale = 0.5 * aspect * CHORD * CHORD * SMALL;
    Ok(ways.iter().map(|s| run[at(s)].joukowski.force[2] / scale).collect())
}

/// Worst error of lift from one semichord on.
pub fn step() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("lifting_surface/impulsive.csv")?;
    let rows: Vec<(f64, f64, f64)> = table
        .column("AR")?
        .into_iter()
        .zip(table.column("s_semichords")?)
        .zip(table.column("CL_over_alpha")?)
        .map(|((aspect, s), slope)| (aspect, s, slope))
        .filter(|(_, s, _)| *s >= 1.0)
        .collect();
    let mut worst: f64 = 0.0;
    for aspect in [4.0, 6.0, 12.0, 20.0] {
        let own: Vec<_> = rows.iter().filter(|row| row.0 == aspect).collect();
        let ways: Vec<f64> = own.iter().map(|row| row.1).collect();
        let (coarse, fine) = (started(aspect, 4, 16, &ways)?, started(aspect, 8, 16, &ways)?);
        for (row, (coarse, fine)) in own.iter().zip(coarse.into_iter().zip(fine)) {
            worst = worst.max((extrapolated(coarse, fine) / row.2 - 1.0).abs());
        }
    }
    let metric = "AR 4 to 20, extrapolated from 4 and 8 x 16 panels: worst error of lift from one semichord on; limit a choice";
    Ok(vec![ComparisonRow::judged("lattice.step", SURFACE, metric, worst, 0.02, "")])
}

/// Lift coefficient per upwash angle of a plunging rectangle, complex.
pub fn plunging(aspect: f64, k: f64, panels: (usize, usize), forgotten: f64) -> Result<(f64, f64), Error> {
    plunging_with(CORE, aspect, k, panels, forgotten)
}

/// The same with cores of the radius `core` chords.
fn plunging_with(
    core: f64,
    aspect: f64,
    k: f64,
    (chordwise, spanwise): (usize, usize),
    forgotten: f64,
) -> Result<(f64, f64), Error> {
    let omega = 2.0 * k;
    let mut wing = rectangle(aspect)?;
    // Falling at unit rate times SMALL: upwash SMALL cos(w t).
    wing.motion.heave = wave(k, 0.0, -SMALL / omega);
    // A whole number of steps to the cycle.
    let cycle = (2.0 * PI / omega * chordwise as f64).round();
    let step = 2.0 * PI / (omega * cycle);
    let steps = (forgotten / step).round() as usize + cycle as usize;
    let run = loads_with(core, &wing, lan(chordwise, spanwise), Some(step), steps)?;
    let lift: Vec<f64> = run.iter().map(|l| l.joukowski.force[2]).collect();
    let scale = (0.5 * aspect * CHORD * CHORD * SMALL).recip();
    let (re, im) = harmonic(&lift, step, omega);
    Ok((re * scale, im * scale))
}

/// Worst complex error of plunge extrapolated from half the panels along the chord.
fn plunge_error(
    aspect: f64,
    k: f64,
    (m, n): (usize, usize),
    forgotten: f64,
    exact: (f64, f64),
) -> Result<f64, Error> {
    let (coarse, fine) =
        (plunging(aspect, k, (m / 2, n), forgotten)?, plunging(aspect, k, (m, n), forgotten)?);
    let value = (extrapolated(coarse.0, fine.0), extrapolated(coarse.1, fine.1));
    Ok(complex_error(value, exact))
}

fn complex_error(value: (f64, f64), exact: (f64, f64)) -> f64 {
    (value.0 - exact.0).hypot(value.1 - exact.1) / exact.0.hypot(exact.1)
}

/// Worst complex error of lift in plunge.
pub fn plunge() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("lifting_surface/plunge.csv")?;
    let (re, im) = (table.column("Re_H")?, table.column("Im_H")?);
    let points: Vec<_> = table.column("AR")?.into_iter().zip(table.column("k")?).enumerate().collect();
    let mut worst: f64 = 0.0;
    for (row, (aspect, k)) in points {
        if [4.0, 6.0, 12.0, 20.0].contains(&aspect) && [0.1, 0.3, 0.5, 1.0].contains(&k) {
            worst = worst.max(plunge_error(aspect, k, (12, 16), FORGOTTEN, (re[row], im[row]))?);
        }
    }
    let metric =
        "AR 4 to 20, k 0.1 to 1, extrapolated from 6 and 12 x 16 panels: worst complex error of lift";
    Ok(vec![ComparisonRow::judged("lattice.plunge", SURFACE, metric, worst, 0.02, "")])
}

/// A sudden start in two dimensions.
pub fn wagner() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("lifting_surface/impulsive.csv")?;
    let ways: Vec<f64> = table.column("s_semichords")?.into_iter().take(16).filter(|s| *s >= 1.0).collect();
    let exact: Vec<f64> = table.column("wagner_exact_2D")?.into_iter().take(16).skip(1).collect();
    let lift = started(ENDLESS, 16, 1, &ways)?.into_iter().zip(started(ENDLESS, 32, 1, &ways)?);
    let error =
        |((coarse, fine), wagner): ((f64, f64), f64)| extrapolated(coarse, fine) / (2.0 * PI * wagner) - 1.0;
    let worst = lift.zip(exact).map(|both| error(both).abs()).fold(0.0, f64::max);
    let metric = "span of 10 000 chords, extrapolated from 16 and 32 panels: worst error of lift from one semichord on";
    Ok(vec![ComparisonRow::judged("lattice.wagner", "Wagner 1925, exact", metric, worst, 0.01, "")])
}

/// Plunge in two dimensions.
pub fn theodorsen() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("lifting_surface/plunge.csv")?;
    let (re, im) = (table.column("Re_H_2D")?, table.column("Im_H_2D")?);
    let core = CourseRequest::default().core;
    let (mut worst, mut usual): (f64, f64) = (0.0, 0.0);
    for (row, k) in table.column("k")?.into_iter().enumerate().take(14) {
        if [0.2, 0.5, 1.0].contains(&k) {
            let exact = (re[row], im[row]);
            worst = worst.max(plunge_error(ENDLESS, k, (24, 1), 4.0 * PI / k, exact)?);
            let own = plunging_with(core, ENDLESS, k, (8, 1), 4.0 * PI / k)?;
            usual = usual.max(complex_error(own, exact));
        }
    }
    let metric = "span of 10 000 chords, k 0.2 to 1, extrapolated from 12 and 24 panels: worst complex error of lift in plunge";
    let row = |id: &str, metric: &str, value| {
        ComparisonRow::judged(id, "Theodorsen 1935, exact", metric, value, 0.01, "")
    };
    let default = "the same of 8 panels with the default core of `wingbeat wake`";
    Ok(vec![row("lattice.theodorsen", metric, worst), row("lattice.theodorsen.default", default, usual)])
}

/// Mean thrust as a ratio to rho U^2 S theta^2 of a pitching rectangle, by Joukowski and by Bernoulli with suction.
pub fn pitching(
    aspect: f64,
    k: f64,
    axis: f64,
    (chordwise, spanwise): (usize, usize),
) -> Result<[f64; 2], Error> {
    let theta = 10.0 * SMALL;
    let mut wing = rectangle(aspect)?;
    wing.motion.nose_up = wave(k, theta, 0.0);
    wing.motion.axis_ahead_m = -axis * CHORD;
    let omega = 2.0 * k;
    let cycle = (2.0 * PI / omega * chordwise as f64).round();
    let step = 2.0 * PI / (omega * cycle);
    let steps = (FORGOTTEN / step).round() as usize + cycle as usize;
    let run = loads(&wing, lan(chordwise, spanwise), Some(step), steps)?;
    let last = &run[run.len() - cycle as usize..];
    let scale = (cycle * aspect * CHORD * CHORD * theta * theta).recip();
    let mean = |of: fn(&wingbeat_lattice::LatticeLoads) -> f64| last.iter().map(of).sum::<f64>() * scale;
    Ok([mean(|l| l.joukowski.force[0]), mean(|l| l.bernoulli.force[0])])
}

/// Mean thrust of pitching wings.
pub fn pitch_thrust() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("lifting_surface/pitch_thrust.csv")?;
    let columns = ["AR", "k", "x_axis", "T", "S"].map(|name| table.column(name));
    let [aspects, ks, axes, thrusts, suctions] = columns;
    let (aspects, ks, axes, thrusts, suctions) = (aspects?, ks?, axes?, thrusts?, suctions?);
    let mut worst = [0.0_f64; 2];
    for row in 0..table.len() {
        let chosen = [4.0, 20.0].contains(&aspects[row]) && [0.1, 0.3, 0.5, 1.0].contains(&ks[row]);
        if chosen && [0.25, 0.75].contains(&axes[row]) {
            let at = |m: usize| pitching(aspects[row], ks[row], axes[row], (m, 16));
            let (coarse, fine) = (at(6)?, at(12)?);
            // The suction beside Bernoulli's forces errs as the length.
            let limits = [extrapolated(coarse[0], fine[0]), 2.0 * fine[1] - coarse[1]];
            for (worst, limit) in worst.iter_mut().zip(limits) {
                *worst = worst.max((limit - thrusts[row]).abs() / suctions[row]);
            }
        }
    }
    let row = |id: &str, metric: &str, value| ComparisonRow::judged(id, SURFACE, metric, value, 0.03, "");
    Ok(vec![
        row(
            "lattice.pitch_thrust.joukowski",
            "AR 4 and 20, k 0.1 to 1, extrapolated from 6 and 12 x 16 panels: worst error of mean thrust over suction",
            worst[0],
        ),
        row("lattice.pitch_thrust.bernoulli", "the same by Bernoulli with suction", worst[1]),
    ])
}
