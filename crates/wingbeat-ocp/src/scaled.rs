//! A program whose unknowns and constraints are counted in their typical sizes.

use super::interior_point::{Iteration, Options, Solution, solve};
use super::nlp::{Derivatives, EvaluationError, Program, Structure};
use crate::plant::Channel;
use std::ops::ControlFlow;

/// Typical sizes of what a program holds: a number of size 1e6 and one of size 1e-6 are alike to the solver when both are
/// counted in them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TypicalSizes {
    /// Of each variable.
    pub variables: Vec<f64>,
    /// Of each constraint.
    pub constraints: Vec<f64>,
}

/// The program in x / size, with g / size.
struct Scaled<'a> {
    program: &'a mut dyn Program,
    sizes: &'a TypicalSizes,
    variables: Vec<Channel>,
    constraints: Vec<Channel>,
    structure: Structure,
    x: Vec<f64>,
    multipliers: Vec<f64>,
}

impl<'a> Scaled<'a> {
    fn new(program: &'a mut dyn Program, sizes: &'a TypicalSizes) -> Self {
        let divided = |channels: &[Channel], sizes: &[f64]| -> Vec<Channel> {
            let one =
                |(c, size): (&Channel, &f64)| Channel { low: c.low / size, high: c.high / size, ..c.clone() };
            channels.iter().zip(sizes).map(one).collect()
        };
        Self {
            variables: divided(program.variables(), &sizes.variables),
            constraints: divided(program.constraints(), &sizes.constraints),
            structure: program.structure(),
            x: vec![0.0; sizes.variables.len()],
            multipliers: vec![0.0; sizes.constraints.len()],
            program,
            sizes,
        }
    }

    fn place(&mut self, x: &[f64]) {
        for ((out, x), size) in self.x.iter_mut().zip(x).zip(&self.sizes.variables) {
            *out = x * size;
        }
    }
}

impl Program for Scaled<'_> {
    fn variables(&self) -> &[Channel] {
        &self.variables
    }
    fn constraints(&self) -> &[Channel] {
        &self.constraints
    }
    fn structure(&self) -> Structure {
        self.structure.clone()
    }
    fn evaluate(&mut self, x: &[f64], g: &mut [f64]) -> Result<f64, EvaluationError> {
        self.place(x);
        let objective = self.program.evaluate(&self.x, g)?;
        g.iter_mut().zip(&self.sizes.constraints).for_each(|(g, size)| *g /= size);
        Ok(objective)
    }
    fn differentiate(
        &mut self,
        x: &[f64],
        weight: f64,
        multipliers: &[f64],
        out: &mut Derivatives,
    ) -> Result<(), EvaluationError> {
        self.place(x);
        let (columns, rows) = (&self.sizes.variables, &self.sizes.constraints);
        for ((own, y), size) in self.multipliers.iter_mut().zip(multipliers).zip(rows) {
            *own = y / size;
        }
        self.program.differentiate(&self.x, weight, &self.multipliers, out)?;
        out.gradient.iter_mut().zip(columns).for_each(|(slope, size)| *slope *= size);
        for (slope, &(i, j)) in out.jacobian.iter_mut().zip(&self.structure.jacobian) {
            *slope *= columns[j] / rows[i];
        }
        for (bend, &(i, j)) in out.hessian.iter_mut().zip(&self.structure.hessian) {
            *bend *= columns[i] * columns[j];
        }
        Ok(())
    }
}

/// As [`solve`], counted in `sizes`; the solution is in the units of `program`.
pub(super) fn solve_in(
    sizes: &TypicalSizes,
    program: &mut dyn Program,
    start: &[f64],
    options: &Options,
    observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
) -> Solution {
    let begin: Vec<f64> = start.iter().zip(&sizes.variables).map(|(x, size)| x / size).collect();
    let mut solution = solve(&mut Scaled::new(program, sizes), &begin, options, observer);
    solution.x.iter_mut().zip(&sizes.variables).for_each(|(x, size)| *x *= size);
    solution.constraints.iter_mut().zip(&sizes.constraints).for_each(|(g, size)| *g *= size);
    solution.multipliers.iter_mut().zip(&sizes.constraints).for_each(|(y, size)| *y /= size);
    solution.bounds.iter_mut().zip(&sizes.variables).for_each(|(z, size)| *z /= size);
    solution
}

#[cfg(test)]
mod tests {
    use crate::plant::{Channel, Fault};
    use crate::{Ends, Instant, OptimalControl, Optimum, Refinement, Scales, Setup, Trajectory, optimise};
    use std::ops::ControlFlow;
    use wingbeat_math::Scalar;

    /// A pendulum brought to rest in least effort, its angle counted in `unit` rad and its rate in `unit` / 1e3 rad/s.
    struct Pendulum {
        unit: f64,
        scaled: bool,
    }

    impl OptimalControl for Pendulum {
        fn setup(&self) -> Setup {
            let sizes = self.sizes();
            let states = vec![Channel::free("angle", "", ""), Channel::free("rate", "", "")];
            let inputs = vec![Channel::limited("torque", "N m", "", -1.0, 1.0)];
            let start = [[1.0 / sizes[0]; 2], [0.0; 2]];
            let setup = Setup::new(states, inputs, [2.0, 8.0]).between(&start, &[[0.0; 2], [0.0; 2]]);
            match self.scaled {
                true => Setup {
                    scales: Scales { states: sizes.map(|size| 1.0 / size).into(), ..Scales::default() },
                    ..setup
                },
                false => setup,
            }
        }
        fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
            let [angle, rate] = self.sizes();
            dx[0] = at.x[1] * (rate / angle);
            dx[1] = (-(at.x[0] * angle).sin() + at.u[0]) / rate;
            Ok(())
        }
        fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
            at.u[0].squared()
        }
        fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
            ends.t[1] * 0.1
        }
    }

    impl Pendulum {
        fn sizes(&self) -> [f64; 2] {
            [self.unit, 1e-3 * self.unit]
        }

        fn solved(&self) -> Optimum {
            let [angle, _] = self.sizes();
            let guess = Trajectory {
                t: vec![0.0, 4.0],
                x: vec![vec![1.0 / angle, 0.0], vec![0.0; 2]],
                u: vec![vec![0.0]; 2],
                p: Vec::new(),
            };
            let refinement = Refinement { meshes: 1, tolerance: 1e-2, ..Refinement::default() };
            optimise(self, &guess, &refinement, &mut |_| ControlFlow::Continue(()))
        }
    }

    #[test]
    fn sizes_make_the_solver_blind_to_units() {
        let plain = Pendulum { unit: 1.0, scaled: true }.solved();
        let fine = Pendulum { unit: 1e-6, scaled: true }.solved();
        assert!(plain.status.is_success() && fine.status.is_success(), "{} {}", plain.status, fine.status);
        assert_eq!(plain.passes[0].iterations, fine.passes[0].iterations);
        assert!((plain.objective / fine.objective - 1.0).abs() < 1e-10);
        // Costates are per unit of the state: a million times smaller units, a million times smaller costates.
        let costate = |of: &Optimum| of.multipliers.as_ref().unwrap().costates[3][0];
        assert!((costate(&fine) * 1e6 / costate(&plain) - 1.0).abs() < 1e-6);
        let bare = Pendulum { unit: 1e-6, scaled: false }.solved();
        let (with, without) = (fine.passes[0].iterations, bare.passes[0].iterations);
        assert!(
            !bare.status.is_success() || without > with,
            "{}, {without} iterations, {with} with sizes",
            bare.status
        );
    }

    #[test]
    fn sizes_without_meaning_are_refused() {
        struct Bad(Vec<f64>);
        impl OptimalControl for Bad {
            fn setup(&self) -> Setup {
                let scales = Scales { states: self.0.clone(), ..Scales::default() };
                Setup { scales, ..Pendulum { unit: 1.0, scaled: false }.setup() }
            }
            fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
                Pendulum { unit: 1.0, scaled: false }.rates(at, dx)
            }
        }
        for sizes in [vec![1.0], vec![1.0, 0.0], vec![f64::NAN, 1.0]] {
            let problem = Bad(sizes);
            let guess = problem.setup().straight_line();
            let end = optimise(&problem, &guess, &Refinement::default(), &mut |_| ControlFlow::Continue(()));
            assert!(end.status.to_string().contains("scales"), "{}", end.status);
        }
    }
}
