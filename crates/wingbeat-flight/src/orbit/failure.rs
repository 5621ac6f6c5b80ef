//! Why there is no orbit.

use wingbeat_ocp::plant::Fault;

/// Why a search ended without an orbit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// The model could not be evaluated on the way.
    #[error("the model could not be evaluated: {0}")]
    Fault(#[from] Fault),
    /// Newton's matrix is singular.
    #[error(
        "the conditions do not depend on what is free: singular matrix in iteration {iteration}, residual {residual:.2e}"
    )]
    Singular {
        /// Iteration, from 1.
        iteration: usize,
        /// Largest condition missed, in its own SI unit.
        residual: f64,
    },
    /// Newton's method stopped before the conditions held.
    #[error(
        "not converged: residual {residual:.2e} after {iterations} iterations, the worst condition is {condition}: begin nearer to an orbit \
         ([start], robot.gait), or free other numbers"
    )]
    NotConverged {
        /// Iterations taken.
        iterations: usize,
        /// Largest condition missed, in its own SI unit.
        residual: f64,
        /// Its name.
        condition: String,
    },
    /// A number left its range.
    #[error(
        "{name} = {value:.4} {unit} is outside {low:.4} to {high:.4}: begin nearer to an orbit ([start], robot.gait), or free other numbers"
    )]
    Range {
        /// Name of the number.
        name: String,
        /// Where it went, in its unit.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// Least allowed, in its unit.
        low: f64,
        /// Largest allowed, in its unit.
        high: f64,
    },
    /// The frequency left the range of the measured residual loads.
    #[error(
        "frequency = {value:.4} Hz is outside {low:.4} to {high:.4}, where robot.residual holds (robot.residual.frequency_hz to 1 %): take          frequency out of trim.free, or measure the residual near {value:.1} Hz"
    )]
    Residual {
        /// Where it went, Hz.
        value: f64,
        /// Least allowed, Hz.
        low: f64,
        /// Largest allowed, Hz.
        high: f64,
    },
    /// Left and right differ: flight straight ahead was looked for as if they did not.
    #[error(
        "left and right differ: over the cycle that was found {condition} is missed by {missed:.2e}, and orbits straight ahead are looked for in \
         the plane of symmetry alone"
    )]
    Asymmetric {
        /// What differs after the cycle from before it, in SI units.
        missed: f64,
        /// Its name.
        condition: String,
    },
    /// The search took the most iterations that it may.
    #[error(
        "no orbit after {0} iterations of Newton's method: begin nearer to one ([start], robot.gait), or free other numbers"
    )]
    Exhausted(usize),
    /// The search was stopped.
    #[error("stopped")]
    Stopped,
}
