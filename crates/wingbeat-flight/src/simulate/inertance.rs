//! Which robots need an inertance for the steps that they are flown in.

use wingbeat_ocp::plant::{Fault, Linearisation, Plant};
use wingbeat_robot::Robot;

/// Rate of the fastest vibration times the step up to which explicit steps follow it: those of Runge and Kutta err there by 1/144 of its
/// amplitude in a step, and are stable up to 2.6. *Choice.*
const FOLLOWED: f64 = 1.0;
/// Squarings of a matrix by which its spectral radius is told: what a matrix of a hundred rows adds to it is then below 1e-4.
const SQUARINGS: usize = 20;

/// Largest size of the eigenvalues of the square matrix `of` with `n` rows: the growth of its powers (Gelfand 1941).
fn spectral_radius(mut of: Vec<f64>, n: usize) -> f64 {
    let (mut log, mut share) = (0.0, 1.0);
    for _ in 0..SQUARINGS {
        let size = of.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
        if !(size > 0.0 && size.is_finite()) {
            return if size > 0.0 { size } else { 0.0 };
        }
        log += share * size.ln();
        share *= 0.5;
        of.iter_mut().for_each(|entry| *entry /= size);
        let entry = |k: usize| (0..n).map(|j| of[k / n * n + j] * of[j * n + k % n]).sum();
        of = (0..n * n).map(entry).collect();
    }
    log.exp()
}

/// Angular frequency or rate of decay of the fastest vibration of the structure, 1/s, where the robot rests: of joints on springs and of flaps. Zero
/// without either.
///
/// # Errors
/// The [`Fault`] that makes the model unusable there.
pub fn fastest_vibration(robot: &Robot) -> Result<f64, Fault> {
    let (layout, elastic) = (robot.layout(), robot.elastic_states());
    if elastic.is_empty() {
        return Ok(0.0);
    }
    let (x, u) = (robot.still(), vec![0.0; robot.inputs().len()]);
    let mut at = Linearisation::new(x.len(), u.len());
    at.evaluate(robot, 0.0, &x, &u)?;
    let mut block = Vec::with_capacity(elastic.len() * elastic.len());
    for row in &elastic {
        block.extend(elastic.iter().map(|column| at.a[row * layout.len + column]));
    }
    Ok(spectral_radius(block, elastic.len()))
}

/// Gives `robot` the inertance ([`Robot::set_inertance`]) that explicit steps of `step` s need to follow it: none where they follow its fastest
/// vibration as it is.
///
/// Equation: flight.inertance
/// `t = h where h s > 1, s the size of the largest eigenvalue of the structure at rest; else 0. With it h s <= 1`
/// Source: stability of Runge and Kutta's method, s h < 2.6 in the left half plane (Hairer & Wanner 1996, IV.2); limits a choice.
/// Test: `stiff_wings_keep_the_step_of_soft_ones`.
///
/// # Errors
/// The [`Fault`] that makes the model unusable at rest; the robot is then as it was.
pub fn follow(robot: &mut Robot, step: f64) -> Result<(), Fault> {
    let fast = step * fastest_vibration(robot)? > FOLLOWED;
    if fast { robot.set_inertance(step / FOLLOWED) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rotation that grows, which no single power tells; a matrix whose powers vanish; a fast decay in other units.
    #[test]
    fn the_growth_of_powers_is_the_largest_eigenvalue() {
        let turning = vec![0.6, -800.0, 0.0008, 0.6];
        assert!((spectral_radius(turning, 2) - 1.0_f64).abs() < 1e-4);
        assert_eq!(spectral_radius(vec![0.0, 5.0, 0.0, 0.0], 2), 0.0);
        let decay = vec![0.0, 1.0, -9e6, -1e4];
        assert!((spectral_radius(decay, 2) / 9e3 - 1.0).abs() < 1e-4);
    }
}
