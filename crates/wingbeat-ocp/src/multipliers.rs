//! What a solution would gain if its constraints moved.

/// Multipliers of the constraints on the last mesh, in the units of the problem: the Lagrangian is the objective plus
/// multipliers times constraints. Each is in the unit of the objective over that of its constraint, the caller's units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Multipliers {
    /// Middle of each interval, s.
    pub t: Vec<f64>,
    /// Costates there: by how much the objective would rise for one unit more of each state, to second order in the length of
    /// an interval.
    pub costates: Vec<Vec<f64>>,
    /// Time (s) and multipliers of the path constraints at each point where they hold, as the discrete problem has them: of a
    /// finer mesh each is smaller.
    pub path: Vec<(f64, Vec<f64>)>,
    /// Multipliers of the constraints on the ends: the objective rises by their negative where the value asked for rises by one.
    pub ends: Vec<f64>,
    /// Multipliers of the defect that ends at each collocation point, one per state; none at the first point of all, nor inside
    /// an interval whose states follow from its ends.
    pub defects: Vec<Vec<f64>>,
    /// Multipliers of the limits of states and inputs at each collocation point, positive at an upper one; none where they are
    /// no unknowns.
    pub bounds: Vec<[Vec<f64>; 2]>,
    /// The same of initial time, final time and parameters.
    pub constants: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use crate::plant::{Channel, Fault};
    use crate::{Ends, Instant, OptimalControl, Refinement, Scheme, Setup, optimise};
    use std::ops::ControlFlow;
    use wingbeat_math::Scalar;

    /// x' = u from 1 at least int x^2 + u^2 over a second: the costate is 2 sinh(1 - t) / cosh 1.
    struct Regulator;

    impl OptimalControl for Regulator {
        fn setup(&self) -> Setup {
            let states = vec![Channel::free("x", "m", "")];
            let setup = Setup::new(states, vec![Channel::free("u", "m/s", "")], [1.0, 1.0]);
            Setup { start: vec![[1.0, 1.0]], ..setup }
        }
        fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
            dx[0] = at.u[0];
            Ok(())
        }
        fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
            at.x[0].squared() + at.u[0].squared()
        }
    }

    /// x' = u from 0 to the asked end, u below `fastest`, at least int u^2 over a second: u is even.
    struct ReachProblem {
        end: f64,
    }

    impl OptimalControl for ReachProblem {
        fn setup(&self) -> Setup {
            let states = vec![Channel::free("x", "m", "")];
            let mut setup = Setup::new(states, vec![Channel::free("u", "m/s", "")], [1.0, 1.0]);
            setup.start = vec![[0.0, 0.0]];
            setup.ends = vec![Channel::limited("reached", "m", "", self.end, self.end)];
            setup
        }
        fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
            dx[0] = at.u[0];
            Ok(())
        }
        fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
            at.u[0].squared()
        }
        fn constrain_ends<S: Scalar>(&self, ends: Ends<S>, values: &mut [S]) {
            values[0] = ends.x[1][0];
        }
    }

    fn on(scheme: Scheme, intervals: usize) -> Refinement {
        Refinement { scheme, intervals, meshes: 1, tolerance: 1.0, ..Refinement::default() }
    }

    #[test]
    fn costates_are_those_of_the_regulator_to_second_order() {
        let worst =
            |scheme: &Scheme, intervals: usize| {
                let problem = Regulator;
                let guess = problem.setup().straight_line();
                let optimum = optimise(&problem, &guess, &on(scheme.clone(), intervals), &mut |_| {
                    ControlFlow::Continue(())
                });
                let of = optimum.multipliers.unwrap();
                assert_eq!((of.t.len(), of.costates.len()), (intervals, intervals), "{}", optimum.status);
                let exact = |t: f64| 2.0 * (1.0 - t).sinh() / 1.0_f64.cosh();
                of.t.iter().zip(&of.costates).map(|(t, c)| (c[0] - exact(*t)).abs()).fold(0.0, f64::max)
            };
        for scheme in [
            Scheme::trapezoid(),
            Scheme::hermite_simpson(),
            Scheme::separated_hermite_simpson(),
            Scheme::lobatto(),
        ] {
            let (coarse, fine) = (worst(&scheme, 8), worst(&scheme, 16));
            assert!(coarse < 5e-3 && fine < 0.3 * coarse, "{}: {coarse} {fine}", scheme.name);
        }
    }

    #[test]
    fn multipliers_of_the_ends_are_what_the_objective_gains() {
        let solved = |end: f64| {
            let problem = ReachProblem { end };
            let guess = problem.setup().straight_line();
            optimise(&problem, &guess, &on(Scheme::hermite_simpson(), 6), &mut |_| ControlFlow::Continue(()))
        };
        let (one, more) = (solved(1.0), solved(1.0 + 1e-4));
        let slope = (more.objective - one.objective) / 1e-4;
        let ends = one.multipliers.unwrap().ends;
        assert!((ends[0] + 2.0).abs() < 1e-6 && (slope + ends[0]).abs() < 1e-3, "{ends:?} {slope}");
    }
}
