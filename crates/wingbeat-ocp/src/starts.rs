//! One problem from several guesses: how many minima there are.

use super::interior_point::SolveStatus;
use super::mesh::{Optimum, Progress, Refinement, optimise_stage};
use super::problem::OptimalControl;
use super::trajectory::Trajectory;
use std::ops::ControlFlow;

/// Objectives closer than this, relative, count as one minimum.
const ALIKE: f64 = 1e-3;

/// What several starts came to.
#[derive(Clone, Debug)]
pub struct Starts {
    /// The lowest solution; without any the best point that was met. Its status is that of a stopped solve where the observer asked for
    /// an end before all guesses were tried.
    pub best: Optimum,
    /// Objective of each start that was solved, in the unit of the problem's cost; none of the others, in order.
    pub objectives: Vec<Option<f64>>,
}

impl Starts {
    /// Number of minima: objectives of solutions that differ by more than a thousandth.
    pub fn minima(&self) -> usize {
        let mut found: Vec<f64> = self.objectives.iter().copied().flatten().collect();
        wingbeat_math::order::ascend(&mut found);
        let apart = |pair: &[f64]| pair[1] - pair[0] > ALIKE * pair[0].abs().max(pair[1].abs());
        usize::from(!found.is_empty()) + found.windows(2).filter(|pair| apart(pair)).count()
    }

    /// The same in words: whether the starts end alike.
    pub fn words(&self) -> String {
        let solved: Vec<f64> = self.objectives.iter().copied().flatten().collect();
        let (count, all) = (solved.len(), self.objectives.len());
        let low = solved.iter().copied().fold(f64::INFINITY, f64::min);
        let high = solved.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        match self.minima() {
            0 => format!("none of {all} starts was solved"),
            1 => format!("{count} of {all} starts solved, to one objective within {:.0e}", ALIKE),
            n => format!(
                "{count} of {all} starts solved, to {n} different minima, objectives {low:.6} to {high:.6}: the lowest is kept"
            ),
        }
    }
}

/// Solves `problem` from each of `guesses`, a stage each, mesh after mesh, and keeps the lowest solution.
///
/// # Panics
/// Without a guess.
pub fn optimise_from<P: OptimalControl>(
    problem: &P,
    guesses: &[Trajectory],
    refinement: &Refinement,
    observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Starts {
    let mut best: Option<Optimum> = None;
    let mut objectives = Vec::with_capacity(guesses.len());
    let mut stopped = false;
    for (stage, guess) in guesses.iter().enumerate() {
        let optimum = optimise_stage(problem, guess, refinement, observer, stage);
        let solved = optimum.status.is_success();
        stopped = optimum.status == SolveStatus::Stopped;
        objectives.push(solved.then_some(optimum.objective));
        if best.as_ref().is_none_or(|old| optimum.beats(old, refinement.solver.acceptable)) {
            best = Some(optimum);
        }
        if stopped {
            break;
        }
    }
    let mut best = best.expect("at least one guess");
    if stopped {
        best.status = SolveStatus::Stopped;
    }
    Starts { best, objectives }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Channel, Fault};
    use crate::{Ends, Instant, Setup};
    use wingbeat_math::Scalar;

    /// x' = u with the end cost (x^2 - 1)^2 + x/5: minima near -1 and 1.
    struct Wells;

    impl OptimalControl for Wells {
        fn setup(&self) -> Setup {
            let states = vec![Channel::free("x", "m", "")];
            Setup::new(states, vec![Channel::limited("u", "m/s", "", -5.0, 5.0)], [1.0, 1.0])
        }
        fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
            dx[0] = at.u[0];
            Ok(())
        }
        fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
            at.u[0].squared() * 1e-3
        }
        fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
            let x = ends.x[1][0];
            (x.squared() - 1.0).squared() + x * 0.2
        }
    }

    #[test]
    fn minima_are_counted_and_the_lowest_is_kept() {
        let guess = |x: f64| Trajectory {
            t: vec![0.0, 1.0],
            x: vec![vec![x], vec![x]],
            u: vec![vec![0.0]; 2],
            p: Vec::new(),
        };
        let guesses = [1.0, -1.0, 0.9].map(guess);
        let mut quiet = |_: Progress| ControlFlow::Continue(());
        let refinement = Refinement { intervals: 4, meshes: 1, tolerance: 1e-3, ..Refinement::default() };
        let starts = optimise_from(&Wells, &guesses, &refinement, &mut quiet);
        assert_eq!(starts.minima(), 2, "{:?}", starts.objectives);
        assert!(starts.words().contains("2 different minima"), "{}", starts.words());
        assert!(starts.best.objective < -0.19, "{}", starts.best.objective);
        let alike = optimise_from(&Wells, &guesses[..1], &refinement, &mut quiet);
        assert_eq!(alike.minima(), 1);
        // Asked to end in the second start: the first, the lower one, is kept, and the third is not tried.
        let lower = [guesses[1].clone(), guesses[0].clone(), guesses[2].clone()];
        let (mut passes, mut stages) = (0, Vec::new());
        let mut ends = |at: Progress| {
            if let Progress::Pass(pass) = at {
                stages.push(pass.stage);
            }
            passes += usize::from(matches!(at, Progress::Pass(_)));
            if passes == 1 && matches!(at, Progress::Iteration(_)) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let cut = optimise_from(&Wells, &lower, &refinement, &mut ends);
        assert_eq!((cut.best.status, cut.objectives.len()), (SolveStatus::Stopped, 2));
        assert_eq!(stages, [0, 1]);
        assert!(cut.best.objective < -0.19, "{}", cut.best.objective);
    }
}
