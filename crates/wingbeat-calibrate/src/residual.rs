//! What a fitted model leaves of the loads of runs, learned by phase of the gait and velocity against the air.

use crate::rig::{beyond_cell, in_wind, respond};
use crate::{Error, HarmonicLayout, ObservedCycles, RigModel, RigTarget, RunRole};
use nalgebra::DMatrix;
use std::collections::BTreeMap;
use wingbeat::math::Vec3;
use wingbeat::math::order::filled;
use wingbeat::rig::cell::CHANNELS;
use wingbeat::robot::{RESIDUAL_FREQUENCY, ResidualSpec, Term};

/// Largest share of the speed by which the velocity of a run may move about its mean. *Choice.*
const STEADY: f64 = 0.02;
/// Instants at which the velocity of a run is looked at.
const LOOKS: usize = 24;
/// Share of the speed below which a component of the velocities counts as the same in all runs. *Choice.*
const SAME: f64 = 1e-3;
/// Smallest singular value of the terms at the runs, in parts of the largest, of which the runs tell all. *Choice.*
const TOLD: f64 = 1e-3;
/// To what the place of the wings is told, m.
const PLACE: f64 = 1e-6;
/// What a run's own weight in what is said of it must lack of 1: a run that alone tells a factor is met whatever it says. *Choice.*
const ALONE: f64 = 1e-2;
/// Speed above which the velocity of a run is held against itself, m/s.
const SLOW: f64 = 0.1;

/// What a channel leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedChannel {
    /// Name.
    pub name: String,
    /// Rms of what the model leaves of it, over the runs, N or N m.
    pub left: f64,
    /// The same of what the learned wrench leaves of each run that it is not learned from, in parts of `left`.
    pub missed: f64,
}

impl LearnedChannel {
    /// Whether it is part of the wrench: of a run left out it says something.
    pub fn is_told(&self) -> bool {
        self.missed < 1.0
    }
}

/// A wrench on the body learned from runs.
#[derive(Clone, Debug)]
pub struct LearnedResidual {
    /// The wrench, for `robot.residual`.
    pub spec: ResidualSpec,
    /// The runs and their velocities against the air, m/s in B.
    pub runs: Vec<(usize, Vec3)>,
    /// All channels.
    pub channels: Vec<LearnedChannel>,
    /// What is left of each run of `runs` with the wrench, as the cell shows it: numbers of its cycle, in the units of the
    /// channels.
    pub predicted: Vec<Vec<f64>>,
}

/// Middle of the surfaces at 3/4 of their chords over the cycle, from the body's origin in B, m: the load of a wing depends on the wash
/// that it meets there (Pistolesi 1933).
fn wings(target: &RigTarget) -> Result<Vec3, Error> {
    let robot = &target.run.robot;
    let (mut sum, mut area) = (Vec3::ZERO, 0.0);
    for k in 0..LOOKS {
        let t = k as f64 / (LOOKS as f64 * robot.frequency_hz());
        let seen = robot.at_rest(t).map_err(|fault| Error::Model { run: target.name.clone(), fault })?;
        for outline in &seen.outlines {
            let bays = outline.ribs.windows(2).zip(&outline.covered).filter(|(_, covered)| **covered);
            for (bay, _) in bays {
                let [[le0, te0], [le1, te1]] = [bay[0], bay[1]];
                let of_bay = 0.5 * (te1 - le0).cross(te0 - le1).norm();
                // Between two ribs chord and place go linearly: the integral of their product.
                let chords = [(te0 - le0).norm(), (te1 - le1).norm()];
                let places = [le0 + (te0 - le0) * 0.75, le1 + (te1 - le1) * 0.75];
                let whole = 3.0 * (chords[0] + chords[1]);
                let shares = [2.0 * chords[0] + chords[1], chords[0] + 2.0 * chords[1]];
                sum =
                    sum + places[0] * (of_bay * shares[0] / whole) + places[1] * (of_bay * shares[1] / whole);
                area += of_bay;
            }
        }
    }
    Ok(Vec3((sum * (1.0 / area)).0.map(|x| (x / PLACE).round() * PLACE)))
}

/// Velocity of `place` against the air in B, m/s: it hardly moves in the window of the run.
fn velocity(target: &RigTarget, place: Vec3) -> Result<Vec3, Error> {
    let (begin, end) = target.window();
    let at = |k: usize| target.velocity(place, begin + (end - begin) * k as f64 / LOOKS as f64);
    let all: Vec<Vec3> = (0..=LOOKS).map(at).collect();
    let mean = all.iter().fold(Vec3::ZERO, |sum, v| sum + *v) * (1.0 / all.len() as f64);
    let moved = all.iter().map(|v| (*v - mean).norm()).fold(0.0, f64::max);
    if moved > STEADY * mean.norm().max(SLOW) {
        let what = format!(
            "its velocity against the air moves by {moved:.2} m/s in its window: a run with residual = true stands in a steady wind, or \
             flies a steady turn"
        );
        return Err(Error::data(&target.name, what));
    }
    Ok(mean)
}

/// All products of the components that vary among `velocities`, up to the power `degree`, the lowest first.
fn terms(velocities: &[Vec3], degree: usize) -> Vec<Term> {
    let speed = velocities.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let varies = |i: &usize| {
        let of = || velocities.iter().map(|v| v[*i]);
        of().fold(f64::MIN, f64::max) - of().fold(f64::MAX, f64::min) > SAME * speed
    };
    let letters: Vec<char> = (0..3).filter(varies).map(|i| ['u', 'v', 'w'][i]).collect();
    let mut all = vec![String::from("1")];
    let mut last = vec![String::new()];
    for _ in 0..degree {
        let longer = |name: &String| {
            let from = letters.iter().position(|letter| name.ends_with(*letter)).unwrap_or(0);
            letters[from..].iter().map(|letter| format!("{name}{letter}")).collect::<Vec<_>>()
        };
        last = last.iter().flat_map(longer).collect();
        all.extend(last.iter().cloned());
    }
    all.iter().filter_map(|name| Term::named(name)).collect()
}

/// The terms at the velocities, a row for each.
fn matrix(terms: &[Term], velocities: &[Vec3]) -> DMatrix<f64> {
    DMatrix::from_fn(velocities.len(), terms.len(), |i, j| terms[j].at(velocities[i]))
}

/// Whether the runs tell every factor, and none of them alone tells one: by the terms about the middle of the velocities, in parts of their
/// range.
fn told(terms: &[Term], velocities: &[Vec3]) -> bool {
    if velocities.len() <= terms.len() {
        return false;
    }
    let ends = range(velocities);
    let scaled = |v: &Vec3| {
        Vec3([0, 1, 2].map(|i| {
            let [low, high] = [ends[0][i], ends[1][i]];
            if high > low { (2.0 * v[i] - low - high) / (high - low) } else { 0.0 }
        }))
    };
    let scaled: Vec<Vec3> = velocities.iter().map(scaled).collect();
    let scaled = matrix(terms, &scaled);
    let values = scaled.singular_values();
    let Ok(inverse) = inverse(&scaled) else { return false };
    let hat = &scaled * inverse;
    values.min() > TOLD * values.max() && hat.diagonal().max() < 1.0 - ALONE
}

fn inverse(matrix: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    matrix.clone().pseudo_inverse(0.0).map_err(|what| Error::Uninformed(what.to_string()))
}

/// Least and largest of each component.
fn range(velocities: &[Vec3]) -> [[f64; 3]; 2] {
    let of = |i: usize, begin: f64, better: fn(f64, f64) -> f64| {
        velocities.iter().map(|v| v[i]).fold(begin, better)
    };
    [[0, 1, 2].map(|i| of(i, f64::MAX, f64::min)), [0, 1, 2].map(|i| of(i, f64::MIN, f64::max))]
}

/// Rms over cycles of a channel.
fn rms_of(layout: HarmonicLayout, cycles: &[Vec<f64>], channel: usize) -> f64 {
    let squares = cycles.iter().map(|cycle| layout.mean_square(cycle, channel));
    (squares.sum::<f64>() / cycles.len() as f64).sqrt()
}

/// The cycle in a phase that is `lag` ahead: sum c_k cos k p + s_k sin k p written in q = p + lag.
fn turned(layout: HarmonicLayout, cycle: &mut [f64], lag: f64) {
    for channel in 0..layout.channels {
        for k in 1..=layout.harmonics {
            let (sin, cos) = (k as f64 * lag).sin_cos();
            let (i, j) = (layout.at(channel, 2 * k - 1), layout.at(channel, 2 * k));
            (cycle[i], cycle[j]) = (cycle[i] * cos - cycle[j] * sin, cycle[i] * sin + cycle[j] * cos);
        }
    }
}

/// The runs of which the residual is learned, and what they tell.
pub(crate) struct Stands<'a> {
    /// Their numbers.
    own: Vec<usize>,
    targets: Vec<&'a RigTarget>,
    layout: HarmonicLayout,
    frequency: f64,
    place: Vec3,
    /// Of `place` against the air, in B.
    velocities: Vec<Vec3>,
    terms: Vec<Term>,
}

impl<'a> Stands<'a> {
    /// Those of `runs` whose role it is; none where there are none.
    ///
    /// # Errors
    /// Runs that do not belong together, or do not tell it.
    pub fn of(model: &'a RigModel, runs: &[ObservedCycles]) -> Result<Option<Self>, Error> {
        let own: Vec<usize> = (0..runs.len()).filter(|run| runs[*run].role == RunRole::Residual).collect();
        let Some(first) = own.first().copied() else { return Ok(None) };
        let targets: Vec<&RigTarget> = own.iter().map(|run| &model.targets[*run]).collect();
        let (layout, frequency) = (runs[first].layout, runs[first].frequency_hz);
        let still = targets.iter().find(|target| target.tilts().is_some());
        if let Some(target) = still {
            return Err(Error::data(&target.name, "its wings are still: a run with residual = true flaps"));
        }
        let (place, mass) = (wings(targets[0])?, targets[0].run.robot.mass());
        let mut velocities = Vec::new();
        for (run, target) in own.iter().zip(&targets) {
            let refused = |what: String| Err(Error::data(&target.name, what));
            let others = || {
                format!(
                    "that of {}: runs with residual = true are of one robot at one frequency",
                    runs[first].name
                )
            };
            if target.run.spec.rig.robot.residual.is_some() {
                let what = "its model has a rig.robot.residual, and only what that leaves would be learned: leave it out";
                return refused(what.into());
            }
            let its = runs[*run].frequency_hz;
            if (its - frequency).abs() > RESIDUAL_FREQUENCY * frequency {
                return refused(format!(
                    "its frequency, {its:.3} Hz, is not {frequency:.3} Hz, {}",
                    others()
                ));
            }
            let robot = &target.run.robot;
            if (wings(target)? - place).norm() > 2.0 * PLACE || (robot.mass() - mass).abs() > 1e-9 * mass {
                return refused(format!("its robot is not {}", others()));
            }
            velocities.push(velocity(target, place)?);
        }
        let mut highest_first = [2, 1].map(|degree| terms(&velocities, degree)).into_iter();
        let Some(terms) = highest_first.find(|terms| told(terms, &velocities)) else {
            let [squares, least] = [2, 1].map(|degree| terms(&velocities, degree).len() + 1);
            let what = format!(
                "{} runs with residual = true do not tell how loads depend on the velocity: at least {least} ({squares} for squares), of which \
                 none may be the only one that tells a factor",
                own.len()
            );
            return Err(Error::Uninformed(what));
        };
        Ok(Some(Self { own, targets, layout, frequency, place, velocities, terms }))
    }

    /// What is odd of them: runs whose tare takes away what a wind does to the wings at rest.
    pub fn cautions(&self) -> impl Iterator<Item = String> {
        let tared = self.targets.iter().filter(|target| target.tared() && in_wind(&target.run));
        tared.map(|target| {
            format!(
                "{}: the tare, taken in the wind, takes away what the air does to the wings at rest, and the learned wrench lacks what the \
                 model leaves of that; process.steps.tare=false where the cell has no bias",
                target.name
            )
        })
    }
}

impl LearnedResidual {
    /// From those of `runs` whose role it is, none where there are none; `said` predicts one of them with the `values` of the fit.
    ///
    /// The place whose velocity counts is the middle of the wings at 3/4 of their chords: stands do not turn, and say nothing of it.
    /// Harmonic by harmonic, what the model leaves of the load before the cell is a polynomial of the velocity, of the second power where
    /// the runs tell it, else of the first, by least squares. What it says of a run that it is not learned from is r/(1 - h) off, r what is
    /// left of that run and h its own weight in what is said of it (Allen 1974). The mount is taken as drawn.
    ///
    /// # Errors
    /// Runs that do not tell it.
    pub fn of(
        model: &RigModel,
        runs: &[ObservedCycles],
        values: &[f64],
        said: &dyn Fn(usize) -> Result<Vec<f64>, Error>,
    ) -> Result<Option<Self>, Error> {
        let Some(stands) = Stands::of(model, runs)? else { return Ok(None) };
        let Stands { own, targets, layout, frequency, place, velocities, terms } = stands;
        let after = own.iter().map(|run| said(*run)).collect::<Result<Vec<_>, _>>()?;
        let numbers = model.numbers(values);
        // At the encoder's zero the model's gait is that far on.
        let lag = |target: &RigTarget| target.run.adjusted(&numbers).map(|(robot, _)| robot.phase(0.0));
        let lags = targets.iter().map(|target| lag(target)).collect::<Result<Vec<f64>, _>>()?;
        let left = |i: usize| {
            let mean = &runs[own[i]].mean;
            let mut left: Vec<f64> = mean.iter().zip(&after[i]).map(|(is, said)| is - said).collect();
            beyond_cell(&targets[i].run.spec.rig.cell, frequency, layout, &mut left);
            turned(layout, &mut left, lags[i]);
            left
        };
        let left: Vec<Vec<f64>> = (0..own.len()).map(left).collect();
        let matrix = matrix(&terms, &velocities);
        let inverse = inverse(&matrix)?;
        let hat = &matrix * &inverse;
        let row = |place: usize| -> Vec<f64> {
            (0..terms.len()).map(|j| (0..own.len()).map(|i| inverse[(j, i)] * left[i][place]).sum()).collect()
        };
        let factors: Vec<Vec<f64>> = (0..layout.len()).map(row).collect();
        let of_run = |i: usize| -> Vec<f64> {
            let at = |row: &Vec<f64>| row.iter().enumerate().map(|(j, x)| x * matrix[(i, j)]).sum();
            factors.iter().map(at).collect()
        };
        let all: Vec<Vec<f64>> = (0..own.len()).map(of_run).collect();
        let missed = |i: usize| -> Vec<f64> {
            left[i].iter().zip(&all[i]).map(|(is, said)| (is - said) / (1.0 - hat[(i, i)])).collect()
        };
        let missed: Vec<Vec<f64>> = (0..own.len()).map(missed).collect();
        let channel = |(channel, (name, _)): (usize, &(&str, &str))| {
            let whole = rms_of(layout, &left, channel);
            let missed = rms_of(layout, &missed, channel) / whole.max(f64::MIN_POSITIVE);
            LearnedChannel { name: (*name).into(), left: whole, missed }
        };
        let channels: Vec<LearnedChannel> = CHANNELS.iter().enumerate().map(channel).collect();
        let rows = |channel: usize| {
            (0..layout.width()).map(|part| factors[layout.at(channel, part)].clone()).collect()
        };
        let told = || channels.iter().enumerate().filter(|(_, channel)| channel.is_told());
        let loads: BTreeMap<String, Vec<Vec<f64>>> =
            filled(told().map(|(number, channel)| (channel.name.clone(), rows(number))));
        let predicted = |i: usize| {
            let mut with = vec![0.0; layout.len()];
            for (channel, _) in told() {
                let own = layout.at(channel, 0)..layout.at(channel, 0) + layout.width();
                with[own.clone()].copy_from_slice(&all[i][own]);
            }
            turned(layout, &mut with, -lags[i]);
            respond(&targets[i].run.spec.rig.cell, frequency, layout, &mut with);
            with.iter().zip(&after[i]).map(|(with, said)| with + said).collect()
        };
        let [low_m_s, high_m_s] = range(&velocities);
        let [preset, law] = targets[0].run.robot.model_of_air();
        Ok(Some(Self {
            spec: ResidualSpec {
                preset: Some(preset),
                law: Some(law),
                frequency_hz: frequency,
                place_m: place.0,
                low_m_s,
                high_m_s,
                terms: terms.iter().map(|term| term.name()).collect(),
                loads,
            },
            predicted: (0..own.len()).map(predicted).collect(),
            runs: own.iter().copied().zip(velocities).collect(),
            channels,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(velocities: &[Vec3], degree: usize) -> Vec<String> {
        terms(velocities, degree).iter().map(|term| term.name()).collect()
    }

    #[test]
    fn terms_are_of_the_components_that_vary() {
        let ahead = [Vec3([4.0, 0.0, 0.5]), Vec3([5.0, 0.0, -0.5])];
        assert_eq!(names(&ahead, 2), ["1", "u", "w", "uu", "uw", "ww"]);
        assert_eq!(names(&ahead, 1), ["1", "u", "w"]);
        let oblique = [Vec3([4.0, 0.3, 0.5]), Vec3([5.0, -0.3, -0.5])];
        assert_eq!(names(&oblique, 2), ["1", "u", "v", "w", "uu", "uv", "uw", "vv", "vw", "ww"]);
    }

    #[test]
    fn runs_on_a_line_tell_no_plane() {
        let on_a_line: Vec<Vec3> =
            (0..9).map(|k| Vec3([4.0 + 0.1 * f64::from(k), 0.0, 0.2 * f64::from(k)])).collect();
        assert!(!told(&terms(&on_a_line, 1), &on_a_line));
        let bent = |k: i32| Vec3([4.0 + 0.1 * f64::from(k), 0.0, 0.02 * f64::from(k * k)]);
        let bent: Vec<Vec3> = (0..4).map(bent).collect();
        assert!(told(&terms(&bent, 1), &bent) && !told(&terms(&bent, 2), &bent));
        assert!(!told(&terms(&bent[..3], 1), &bent[..3]), "three factors and no run to spare");
    }

    #[test]
    fn a_turned_cycle_is_the_same_in_the_other_phase() {
        let layout = HarmonicLayout { channels: 1, harmonics: 3 };
        let cycle = vec![0.3, 0.5, -0.2, 0.1, 0.4, -0.3, 0.2];
        let mut other = cycle.clone();
        turned(layout, &mut other, 0.7);
        for k in 0..7 {
            let phase = 0.9 * f64::from(k);
            let (a, b) = (layout.value(&cycle, 0, phase), layout.value(&other, 0, phase + 0.7));
            assert!((a - b).abs() < 1e-14);
        }
    }
}
