//! Nonlinear programs: min f(x) subject to g_low <= g(x) <= g_high and x_low <= x <= x_high, with exact sparse first and second
//! derivatives. Variables, objective, constraints and their derivatives are in the caller's units.

use crate::plant::Channel;
use wingbeat_math::{Scalar, Tape};

/// Why a function could not be evaluated: what was wrong, in words.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct EvaluationError(pub String);

/// Where the non-zeros of a program are, and how its unknowns are grouped.
#[derive(Clone, Debug, Default)]
pub struct Structure {
    /// Non-zeros (row, column) of dg/dx; repeated ones are summed.
    pub jacobian: Vec<(usize, usize)>,
    /// Non-zeros (row, column) of the Hessian, each pair of unknowns once, in
    /// either triangle; repeated ones are summed.
    pub hessian: Vec<(usize, usize)>,
    /// Elimination block of each variable (stage by stage for a trajectory).
    pub variable_block: Vec<usize>,
    /// Elimination block of each constraint.
    pub constraint_block: Vec<usize>,
}

impl Structure {
    /// That of a small program in one block, of which no entry is known to be zero.
    pub fn dense(variables: usize, constraints: usize) -> Self {
        Self {
            jacobian: (0..constraints).flat_map(|i| (0..variables).map(move |j| (i, j))).collect(),
            hessian: (0..variables).flat_map(|i| (0..=i).map(move |j| (i, j))).collect(),
            variable_block: vec![0; variables],
            constraint_block: vec![0; constraints],
        }
    }
}

/// First and second derivatives at one point, in the order of [`Structure`].
#[derive(Clone, Debug, Default)]
pub struct Derivatives {
    /// df/dx.
    pub gradient: Vec<f64>,
    /// dg/dx at the non-zeros.
    pub jacobian: Vec<f64>,
    /// Hessian of `weight` f + multipliers . g at the non-zeros.
    pub hessian: Vec<f64>,
}

impl Derivatives {
    /// Storage for a program of `variables` variables and this structure.
    pub fn new(variables: usize, structure: &Structure) -> Self {
        Self {
            gradient: vec![0.0; variables],
            jacobian: vec![0.0; structure.jacobian.len()],
            hessian: vec![0.0; structure.hessian.len()],
        }
    }
}

/// A nonlinear program, as the solver sees it.
pub trait Program {
    /// The variables by name, with their limits.
    fn variables(&self) -> &[Channel];
    /// The constraints by name, with the limits of their values.
    fn constraints(&self) -> &[Channel];
    /// Non-zeros and elimination blocks.
    fn structure(&self) -> Structure;
    /// Objective at `x`; writes the constraint values.
    fn evaluate(&mut self, x: &[f64], constraints: &mut [f64]) -> Result<f64, EvaluationError>;
    /// Derivatives at `x`, the Hessian for `weight` f + `multipliers` . g.
    fn differentiate(
        &mut self,
        x: &[f64],
        weight: f64,
        multipliers: &[f64],
        out: &mut Derivatives,
    ) -> Result<(), EvaluationError>;
    /// Whether all derivatives taken last are finite, of a program that knows; those of others are looked through.
    fn derivatives_are_finite(&self) -> Option<bool> {
        None
    }
}

/// Objective and constraints written once over any scalar.
pub trait Functions {
    /// The variables by name, with their limits.
    fn variables(&self) -> Vec<Channel>;
    /// The constraints by name, with the limits of their values; a pair of
    /// equal limits is an equation.
    fn constraints(&self) -> Vec<Channel>;
    /// The objective.
    fn objective<S: Scalar>(&self, x: &[S]) -> S;
    /// The constraint values g(x), in the order of [`Functions::constraints`].
    fn constrain<S: Scalar>(&self, x: &[S], g: &mut [S]);
}

/// A [`Functions`] as a dense program, differentiated by a tape.
#[derive(Clone, Debug)]
pub struct Dense<'a, F> {
    functions: &'a F,
    variables: Vec<Channel>,
    constraints: Vec<Channel>,
    tape: Tape,
    outputs: Vec<f64>,
    weights: Vec<f64>,
    jacobian: Vec<f64>,
    hessian: Vec<f64>,
}

impl<'a, F: Functions> Dense<'a, F> {
    /// The program of `functions`.
    pub fn new(functions: &'a F) -> Self {
        let (variables, constraints) = (functions.variables(), functions.constraints());
        let (n, m) = (variables.len(), constraints.len());
        Self {
            functions,
            variables,
            constraints,
            tape: Tape::default(),
            outputs: vec![0.0; m + 1],
            weights: vec![0.0; m + 1],
            jacobian: vec![0.0; (m + 1) * n],
            hessian: vec![0.0; n * n],
        }
    }
}

impl<F: Functions> Program for Dense<'_, F> {
    fn variables(&self) -> &[Channel] {
        &self.variables
    }
    fn constraints(&self) -> &[Channel] {
        &self.constraints
    }
    fn structure(&self) -> Structure {
        Structure::dense(self.variables.len(), self.constraints.len())
    }
    fn evaluate(&mut self, x: &[f64], constraints: &mut [f64]) -> Result<f64, EvaluationError> {
        self.functions.constrain(x, constraints);
        let objective = self.functions.objective(x);
        finite("objective", objective)?;
        for (g, channel) in constraints.iter().zip(&self.constraints) {
            finite(&channel.name, *g)?;
        }
        Ok(objective)
    }
    fn differentiate(
        &mut self,
        x: &[f64],
        weight: f64,
        multipliers: &[f64],
        out: &mut Derivatives,
    ) -> Result<(), EvaluationError> {
        let n = x.len();
        let functions = self.functions;
        self.tape.record(x, &mut self.outputs, |x, out| {
            out[0] = functions.objective(x);
            functions.constrain(x, &mut out[1..]);
            Ok::<(), EvaluationError>(())
        })?;
        self.weights[0] = weight;
        self.weights[1..].copy_from_slice(multipliers);
        self.tape.second_order(&self.weights, &mut self.jacobian, &mut self.hessian);
        out.gradient.copy_from_slice(&self.jacobian[..n]);
        out.jacobian.copy_from_slice(&self.jacobian[n..]);
        let lower = (0..n).flat_map(|i| (0..=i).map(move |j| i * n + j));
        for (h, k) in out.hessian.iter_mut().zip(lower) {
            *h = self.hessian[k];
        }
        Ok(())
    }
}

fn finite(name: &str, value: f64) -> Result<(), EvaluationError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(EvaluationError(format!("{name} is {value}")))
}
