//! Fixed points by secants.

/// Finds g with g = G(g) from what G gives: of what was found the part is taken away that earlier steps say it will change by (least
/// squares over their residuals: Anderson 1965; of strong coupling Degroote, Bathe & Vierendeels 2009).
#[derive(Clone, Debug, Default)]
pub(super) struct Secant {
    last: Option<[Vec<f64>; 2]>,
    /// Changes of the residual and of what G gives, from step to step.
    changes: Vec<[Vec<f64>; 2]>,
}

/// Most steps that are remembered.
const MEMORY: usize = 12;
/// Share of a change below which it is a sum of the others.
const DEPENDENT: f64 = 1e-9;

impl Secant {
    /// The next guess, after G gave `found` at `guess`, all in the caller's units.
    pub fn next(&mut self, guess: &[f64], found: &[f64]) -> Vec<f64> {
        let residual = minus(found, guess);
        if let Some([before, gave]) = self.last.take() {
            self.changes.push([minus(&residual, &before), minus(found, &gave)]);
            if self.changes.len() > MEMORY {
                self.changes.remove(0);
            }
        }
        let mut next = found.to_vec();
        let mut left = residual.clone();
        // The newest first, each less its part along those before it.
        let mut taken: Vec<[Vec<f64>; 2]> = Vec::with_capacity(self.changes.len());
        for change in self.changes.iter().rev() {
            let [mut residual, mut gave] = change.clone();
            let whole = norm(&residual);
            for [direction, with] in &taken {
                let part = dot(direction, &residual);
                add(&mut residual, -part, direction);
                add(&mut gave, -part, with);
            }
            let size = norm(&residual);
            if size <= DEPENDENT * whole || size == 0.0 {
                continue;
            }
            for vector in [&mut residual, &mut gave] {
                vector.iter_mut().for_each(|v| *v /= size);
            }
            let part = dot(&residual, &left);
            add(&mut left, -part, &residual);
            add(&mut next, -part, &gave);
            taken.push([residual, gave]);
        }
        self.last = Some([residual, found.to_vec()]);
        next
    }
}

fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

fn add(to: &mut [f64], share: f64, what: &[f64]) {
    to.iter_mut().zip(what).for_each(|(to, what)| *to += share * what);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_map_that_repels_is_solved_within_twice_its_dimensions() {
        // A step of it finds nothing new, where the residual does not change: one more than the dimensions and the first.
        let map = |g: &[f64]| vec![1.0 - 9.0 * g[0] + g[1], 2.0 + 3.0 * g[1], 0.5 * g[2] + g[0]];
        let (mut secant, mut guess) = (Secant::default(), vec![0.0; 3]);
        for _ in 0..2 * guess.len() {
            let found = map(&guess);
            guess = secant.next(&guess, &found);
        }
        assert!(norm(&minus(&map(&guess), &guess)) < 1e-10, "{guess:?}");
    }
}
