//! A sail that heaves, against vortices on its chord and in its wake, independent of the library.
//!
//! Linear and in plane flow: vortices at the quarter of each piece of the chord, the normal wash vanishes at its three quarters, what
//! the circulation changes by is shed and drifts with the wind. Pressure rho (V gamma + d/dt of the circulation ahead). Chord,
//! wind and density are 1.

use super::super::C;
use super::{SailSheet, membrane};
use crate::{ComparisonRow, Error};
use nalgebra::{DMatrix, DVector};
use std::collections::VecDeque;
use std::f64::consts::TAU;
use wingbeat::aero::LiftLaw;
use wingbeat::tether::{Clock, Coordinate, Motion};

/// Amplitudes over that of the heave's rate: lift coefficient, height at mid chord.
struct SailResponse {
    lift: C,
    camber: C,
}

/// Heights and slopes of a strip's two shapes at x.
fn shapes(x: f64) -> [[f64; 2]; 2] {
    let u = 1.0 - 2.0 * x;
    let square = 1.0 - u * u;
    [[square, 4.0 * u], [square * u, 6.0 * u * u - 2.0]]
}

/// Stiffness of the shapes by tension: int z'^2 dx.
const STIFFNESS: [f64; 2] = [16.0 / 3.0, 16.0 / 5.0];

/// Wash at `x` of a vortex of unit circulation, positive lifting, at `from`.
fn wash(x: f64, from: f64) -> f64 {
    -1.0 / (TAU * (x - from))
}

/// Chords of wake that are kept, in which it fades to a few thousandths.
const WAKE: f64 = 40.0;
/// Pieces of the chord.
const PIECES: usize = 48;

/// A sail of the tension `tension` and the own damping `damping` that heaves with the rate cos(w t): implicit steps of a piece of the
/// chord each.
fn vortices(tension: f64, damping: f64, rate: f64) -> Result<SailResponse, Error> {
    let (n, dx) = (PIECES, 1.0 / PIECES as f64);
    let vortex = |j: usize| (j as f64 + 0.25) * dx;
    let control = |i: usize| (i as f64 + 0.75) * dx;
    let newest = 1.0 + 0.25 * dx;
    // Circulation of the pieces, then the heights; the shed vortex is what the circulation lacks of the one before.
    let mut system = DMatrix::zeros(n + 2, n + 2);
    for i in 0..n {
        for j in 0..n {
            system[(i, j)] = wash(control(i), vortex(j)) - wash(control(i), newest);
        }
        for (m, [height, slope]) in shapes(control(i)).into_iter().enumerate() {
            system[(i, n + m)] = -(height / dx + slope);
        }
    }
    for m in 0..2 {
        let stiffness = STIFFNESS[m] * tension;
        system[(n + m, n + m)] = stiffness * (damping / dx + 0.5);
        for j in 0..n {
            // Half of the load now: gamma plus the rate of the circulation ahead of the vortex, with half of its own.
            system[(n + m, j)] -= 0.5 * shapes(vortex(j))[m][0];
            for k in 0..=j {
                let own = if k == j { 0.5 } else { 1.0 };
                system[(n + m, k)] -= own * shapes(vortex(j))[m][0] * 0.5;
            }
        }
    }
    let system = system.lu();
    let per_cycle = (TAU / rate / dx).round();
    let rate = TAU / (per_cycle * dx);
    let steps = 6 * per_cycle as usize;
    let (mut bound, mut heights, mut loads) = (DVector::<f64>::zeros(n), [0.0; 2], [0.0; 2]);
    let mut shed: VecDeque<f64> = VecDeque::new();
    let mut sums = [C::new(0.0, 0.0); 2];
    for step in 1..=steps {
        let time = step as f64 * dx;
        let total: f64 = bound.sum();
        let mut right = DVector::zeros(n + 2);
        for i in 0..n {
            let x = control(i);
            let drifted: f64 =
                shed.iter().enumerate().map(|(k, g)| g * wash(x, newest + (k + 1) as f64 * dx)).sum();
            let heave = -(rate * time).cos();
            let moved: f64 = (0..2).map(|m| shapes(x)[m][0] * heights[m] / dx).sum();
            right[i] = -heave - drifted - wash(x, newest) * total - moved;
        }
        let old_load = |m: usize| -> f64 {
            // What of the load now is known: minus the circulation before.
            let mut ahead = 0.0;
            let mut sum = 0.0;
            for j in 0..n {
                sum -= shapes(vortex(j))[m][0] * (ahead + 0.5 * bound[j]);
                ahead += bound[j];
            }
            sum
        };
        for m in 0..2 {
            let stiffness = STIFFNESS[m] * tension;
            right[n + m] = stiffness * (damping / dx - 0.5) * heights[m] + 0.5 * (loads[m] + old_load(m));
        }
        let known = [old_load(0), old_load(1)];
        let found = system.solve(&right).ok_or_else(|| Error::NoAnswer("a singular sail".into()))?;
        let before = bound.clone();
        bound = found.rows(0, n).into_owned();
        for m in 0..2 {
            let mut ahead = 0.0;
            let mut sum = known[m];
            for j in 0..n {
                sum += shapes(vortex(j))[m][0] * (bound[j] + ahead + 0.5 * bound[j]);
                ahead += bound[j];
            }
            loads[m] = sum;
            heights[m] = found[n + m];
        }
        shed.push_front(total - bound.sum());
        shed.truncate((WAKE / dx) as usize);
        if step > steps - per_cycle as usize {
            let (mut lift, mut ahead) = (0.0, 0.0);
            for j in 0..n {
                let change = bound[j] - before[j];
                lift += 0.5 * (bound[j] + before[j]) + ahead + 0.5 * change;
                ahead += change;
            }
            // The lift over half a step is that of its middle.
            let turn = C::from_polar(2.0 / per_cycle, -rate * (time - 0.5 * dx));
            sums[0] += turn * 2.0 * lift;
            sums[1] += C::from_polar(2.0 / per_cycle, -rate * time) * heights[0];
        }
    }
    Ok(SailResponse { lift: sums[0], camber: sums[1] })
}

/// Lift slope, 1/rad, of a sail at rest of that tension over q c: vortices on `pieces` of a stretched string between two
/// points.
pub fn at_rest(ratio: f64, pieces: usize) -> Result<f64, Error> {
    let dx = 1.0 / pieces as f64;
    // Circulations, then heights at the ends of the pieces: T z'' = -dp with dp = gamma, T = C_T/2; the slope of a piece washes.
    let n = pieces;
    let mut system = DMatrix::zeros(2 * n - 1, 2 * n - 1);
    let mut right = DVector::zeros(2 * n - 1);
    for i in 0..n {
        let control = (i as f64 + 0.75) * dx;
        for j in 0..n {
            system[(i, j)] = wash(control, (j as f64 + 0.25) * dx);
        }
        // The slope at three quarters of a piece lies between that of it and of the next: linear between the middles of the pieces.
        for (piece, weight) in [
            (i, if i + 1 < n { 0.75 } else { 1.25 }),
            (if i + 1 < n { i + 1 } else { i - 1 }, if i + 1 < n { 0.25 } else { -0.25 }),
        ] {
            if piece > 0 {
                system[(i, n + piece - 1)] += weight / dx;
            }
            if piece + 1 < n {
                system[(i, n + piece)] -= weight / dx;
            }
        }
        right[i] = -1.0;
    }
    for k in 0..n - 1 {
        let row = n + k;
        let stiffness = 0.5 * ratio / dx;
        system[(row, row)] += 2.0 * stiffness;
        if k > 0 {
            system[(row, row - 1)] -= stiffness;
        }
        if k + 2 < n {
            system[(row, row + 1)] -= stiffness;
        }
        // A vortex at the quarter of its piece bears on both of its ends.
        system[(row, k)] -= 0.25;
        system[(row, k + 1)] -= 0.75;
    }
    let found = system.lu().solve(&right).ok_or_else(|| Error::NoAnswer("a singular sail".into()))?;
    Ok(2.0 * found.rows(0, n).sum())
}

/// The same of preset full.
fn strips(tension: f64, damping: f64, rate: f64) -> Result<SailResponse, Error> {
    let stiffness = 50.0 * tension;
    let heave = Coordinate::Fourier {
        frequency_hz: rate / TAU,
        mean: 0.0,
        cos: Vec::new(),
        sin: vec![AMPLITUDE / rate],
    };
    let steps_per_cycle = 400;
    let clock = Clock { frequency_hz: rate / TAU, cycles: 8, steps_per_cycle };
    let skin = membrane(stiffness, tension / stiffness, damping);
    let sheet = SailSheet {
        membrane: Some(skin),
        flap: None,
        law: LiftLaw::Linear,
        motion: Motion { heave, ..Motion::at_rest() },
        clock,
    };
    let mut answer = SailResponse { lift: C::new(0.0, 0.0), camber: C::new(0.0, 0.0) };
    let (cycle, area) = sheet.loads()?;
    for (k, loads) in cycle.iter().enumerate() {
        let turn =
            C::from_polar(2.0 / steps_per_cycle as f64 / AMPLITUDE, -TAU * k as f64 / steps_per_cycle as f64);
        answer.lift += turn * (2.0 * loads.wrench.force[2] / area);
        answer.camber += turn * loads.camber[0];
    }
    Ok(answer)
}

/// Rate of the heave over the speed: small, so that nothing stretches.
const AMPLITUDE: f64 = 1e-3;

/// Time of the membrane's own damping, chords of travel.
const DAMPING: f64 = 0.05;

/// The rows.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let source = "48 vortices on the chord and those shed, own";
    let mut rows = Vec::new();
    for reduced in [0.1, 0.25, 0.5] {
        let rate = 2.0 * reduced;
        let (mut lift, mut camber) = (0.0_f64, 0.0_f64);
        for ratio in [3.0, 6.0] {
            let (exact, found) = (vortices(0.5 * ratio, DAMPING, rate)?, strips(0.5 * ratio, DAMPING, rate)?);
            lift = lift.max((found.lift - exact.lift).norm() / exact.lift.norm());
            camber = camber.max((found.camber - exact.camber).norm() / exact.camber.norm());
        }
        let (stiff, own) = (vortices(1e4, DAMPING, rate)?, strips(1e4, DAMPING, rate)?);
        let rigid = (own.lift - stiff.lift).norm() / stiff.lift.norm();
        for (name, value, of) in [
            ("lift", lift, "a sail's lift, T/(q c) 3 and 6"),
            ("camber", camber, "a sail's rise, T/(q c) 3 and 6"),
            ("rigid", rigid, "a rigid chord's lift"),
        ] {
            let (id, metric) = (
                format!("fsi.membrane.moving.{name}_{reduced}"),
                format!("complex error of {of}, heave at k = {reduced}"),
            );
            rows.push(match name {
                "rigid" => ComparisonRow::shown(&id, source, &metric, value, ""),
                _ => ComparisonRow::judged(&id, source, &metric, value, 0.05, ""),
            });
        }
    }
    Ok(rows)
}
