//! Floquet multipliers: how small disturbances of an orbit grow over a cycle.

use super::along::MOST_ERROR;
use super::cycle::{Cycle, Point};
use super::linear::{Deviations, Interval};
use super::newton::Orbit;
use super::section::{Direction, OrbitSection};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;
use std::ops::Range;
use wingbeat_ocp::plant::{Early, Fault};
use wingbeat_structure::spectrum;

/// In which directions a disturbance lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sector {
    /// Left and right stay alike.
    Longitudinal,
    /// Left and right differ.
    Lateral,
    /// Of a turn, where the two do not part.
    Coupled,
}

impl Sector {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Longitudinal => "longitudinal",
            Self::Lateral => "lateral",
            Self::Coupled => "coupled",
        }
    }
}

/// One mode.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Multiplier: the ratio by which the mode grows over a cycle, real and imaginary part.
    pub multiplier: [f64; 2],
    /// Rate of growth, 1/s: ln |multiplier| / T.
    pub growth: f64,
    /// Frequency of its oscillation, Hz; at most half of that of the gait.
    pub frequency: f64,
    /// In which directions it lies.
    pub sector: Sector,
    /// The coordinate that moves most, measured by what the orbit's own scales are; `heading` for the neutral one.
    pub label: String,
    /// Share of each coordinate of the [`OrbitSection`] in the mode, in the same scales, the largest 1; none of the heading's.
    pub shares: Vec<f64>,
}

impl Mode {
    /// |multiplier|, a ratio.
    pub fn size(&self) -> f64 {
        self.multiplier[0].hypot(self.multiplier[1])
    }
}

/// The modes of an orbit.
#[derive(Clone, Debug)]
pub struct Modes {
    /// From the largest multiplier down.
    pub modes: Vec<Mode>,
    /// Largest entry of the monodromy, in SI units, that leads from one sector into the other, 0 in a robot whose sides are
    /// alike.
    pub coupling: f64,
}

impl Modes {
    /// Largest |multiplier| without the heading's, a ratio.
    pub fn largest(&self) -> f64 {
        self.modes.iter().filter(|m| m.label != HEADING).map(Mode::size).fold(0.0, f64::max)
    }

    /// True where every disturbance but that of the heading dies out or stays.
    pub fn stable(&self) -> bool {
        self.largest() <= 1.0 + NEUTRAL
    }
}

/// What a multiplier may exceed 1 by where derivatives of intervals err by as much. *Choice.*
const NEUTRAL: f64 = MOST_ERROR;
/// Label of the mode that is neutral by the symmetry of space.
const HEADING: &str = "heading";

/// The monodromy: derivatives of the coordinates after a cycle along `directions`.
///
/// # Errors
/// The [`Fault`] that makes the model unusable on the way.
fn monodromy(cycle: &Cycle, point: &Point, directions: &[Direction]) -> Result<DMatrix<f64>, Fault> {
    let rows = |z: &[Early]| directions.iter().map(|d| OrbitSection::along(d, z)).collect();
    let (_, matrix) = cycle.differentiate(point, directions, &[], |_, end| rows(&end.z))?;
    Ok(DMatrix::from_fn(directions.len(), directions.len(), |i, j| matrix[i][j]))
}

/// The same by the chain rule: the product of the matrices A of the intervals of the cycle, in which height and elements are no
/// directions.
fn monodromy_over(all: &[Interval], directions: &[Direction]) -> DMatrix<f64> {
    let size = all.first().map_or(0, |interval| interval.a.nrows());
    let product = all.iter().fold(DMatrix::identity(size, size), |product, interval| &interval.a * product);
    let place = Deviations::coordinate;
    DMatrix::from_fn(directions.len(), directions.len(), |i, j| {
        let moved = |row: usize| -> f64 {
            directions[j].iter().map(|(column, share)| product[(place(row), place(*column))] * share).sum()
        };
        let along: f64 = directions[i].iter().map(|(row, share)| moved(*row) * share).sum();
        along / directions[i].len() as f64
    })
}

/// The directions in which modes are told: those that keep left and right alike, then the others.
fn all_directions(cycle: &Cycle) -> Vec<Direction> {
    [cycle.section().symmetric(), cycle.section().antisymmetric()].concat()
}

/// As [`floquet`], by the intervals of a whole cycle of `orbit` in turn, which [`intervals`](super::intervals) gives.
///
/// # Errors
/// [`Fault::Multipliers`].
pub fn floquet_over(cycle: &Cycle, orbit: &Orbit, all: &[Interval]) -> Result<Modes, Fault> {
    modes_of(cycle, orbit, &monodromy_over(all, &all_directions(cycle)))
}

/// Multipliers and modes of `orbit`, of a straight one of a robot whose sides are alike split into what keeps left and right alike and what does not.
///
/// Equation: orbit.floquet
/// `eigenvalues of d z(T) / d z(0)`
/// Source: Floquet 1883.
/// Test: `an_orbit_is_judged`.
///
/// The eigenvalues of the derivative of the flow over a cycle, in heading axes. The heading itself is neutral.
///
/// # Errors
/// The [`Fault`] that makes the model unusable on the way.
pub fn floquet(cycle: &Cycle, orbit: &Orbit) -> Result<Modes, Fault> {
    modes_of(cycle, orbit, &monodromy(cycle, &orbit.point, &all_directions(cycle))?)
}

/// The modes of a monodromy in [`all_directions`].
fn modes_of(cycle: &Cycle, orbit: &Orbit, whole: &DMatrix<f64>) -> Result<Modes, Fault> {
    let section = cycle.section();
    let all = all_directions(cycle);
    let sectors: Vec<(Sector, Range<usize>)> = if cycle.coupled(&orbit.course) {
        vec![(Sector::Coupled, 0..all.len())]
    } else {
        let first = section.symmetric().len();
        vec![(Sector::Longitudinal, 0..first), (Sector::Lateral, first..all.len())]
    };
    let duration = orbit.end.duration;
    let mode = |multiplier: Complex<f64>, sector, label, shares| Mode {
        multiplier: [multiplier.re, multiplier.im],
        growth: multiplier.norm().ln() / duration,
        frequency: multiplier.arg().abs() / (TAU * duration),
        sector,
        label,
        shares,
    };
    let neutral = sectors.last().map_or(Sector::Lateral, |s| s.0);
    let mut modes = vec![mode(Complex::new(1.0, 0.0), neutral, HEADING.into(), vec![0.0; section.len()])];
    let mut coupling: f64 = 0.0;
    for (sector, own) in &sectors {
        let directions = &all[own.clone()];
        let others = (0..all.len()).filter(|i| !own.contains(i));
        let across = others.flat_map(|i| own.clone().map(move |j| (i, j)));
        coupling = across.fold(coupling, |most, at| most.max(whole[at].abs()));
        let matrix = whole.view((own.start, own.start), (own.len(), own.len()));
        let scales: Vec<f64> = directions.iter().map(|d| scale(cycle, orbit, d[0].0)).collect();
        // In the orbit's own scales, so that a mode's shares can be compared.
        let scaled =
            DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * scales[j] / scales[i]);
        for multiplier in &spectrum(&scaled).ok_or(Fault::Multipliers { size: scaled.nrows() })? {
            let along = shares(&scaled, *multiplier);
            let most = (0..along.len()).max_by(|&i, &j| along[i].total_cmp(&along[j]));
            let label =
                most.map_or_else(|| "undecided".into(), |i| section.names()[directions[i][0].0].clone());
            let mut shares = vec![0.0; section.len()];
            for (direction, share) in directions.iter().zip(&along) {
                direction.iter().for_each(|(i, _)| shares[*i] = *share);
            }
            modes.push(mode(*multiplier, *sector, label, shares));
        }
    }
    wingbeat_math::order::descend_by(&mut modes, |item| item.size());
    Ok(Modes { modes, coupling })
}

/// What counts as one of the coordinate `i`: velocities a share of the speed V, angles 1 rad, rates the crank's; of the air's states
/// by their units V, V^2, circulations the V^2 over the crank's rate of a cycle's travel, shares 1.
fn scale(cycle: &Cycle, orbit: &Orbit, i: usize) -> f64 {
    let (speed, rate) = (orbit.course.speed, cycle.rate(orbit.point.pace));
    match (i, cycle.section().kind(i)) {
        (0..3, _) => speed,
        (5..8, _) => rate,
        (_, "air") => match cycle.section().unit(cycle.robot(), i) {
            "m/s" => speed,
            "m2/s" => speed * speed / rate,
            "m2/s2" => speed * speed,
            _ => 1.0,
        },
        (_, "joint") if cycle.section().names()[i].starts_with("coordinate_rate") => rate,
        _ => 1.0,
    }
}

/// Magnitudes of the eigenvector of `multiplier`, the largest 1, by three steps of inverse iteration; empty where they fail.
fn shares(matrix: &DMatrix<f64>, multiplier: Complex<f64>) -> Vec<f64> {
    let n = matrix.nrows();
    let near = multiplier + Complex::new(1e-9, 1e-9) * (1.0 + multiplier.norm());
    let shifted = DMatrix::from_fn(n, n, |i, j| {
        Complex::new(matrix[(i, j)], 0.0) - if i == j { near } else { Complex::new(0.0, 0.0) }
    });
    let factors = shifted.lu();
    let mut vector = DVector::from_fn(n, |i, _| Complex::new(1.0 + 0.01 * i as f64, 0.0));
    for _ in 0..3 {
        let Some(solved) = factors.solve(&vector) else { return Vec::new() };
        let size = solved.iter().map(|v| v.norm()).fold(0.0, f64::max);
        vector = solved / Complex::new(size, 0.0);
    }
    vector.iter().map(|v| v.norm()).collect()
}
