//! A search without derivatives, for goals that are no smooth function of what is searched.

use crate::Random;

/// Largest step, in widths of the box: beyond, what is drawn is even over it anyway. *Choice.*
const LARGEST_STEP: f64 = 1.0;

/// The separable evolution strategy with adaptation of the covariance, on the unit box: its normal distribution has a mean, a step
/// and a variance of its own for each number. What leaves the box is mirrored at its ends.
///
/// The candidates of a generation are a pure function of the seed and of the costs told before, so that a search that is told the
/// same costs goes on where it was.
///
/// ```
/// use wingbeat_math::Evolution;
///
/// let mut search = Evolution::new(vec![0.5, 0.5], 0.3, 8, 1);
/// for _ in 0..60 {
///     let cost = |x: Vec<f64>| (x[0] - 0.2).powi(2) + 9.0 * (x[1] - 0.9).powi(2);
///     let costs: Vec<f64> = (0..8).map(|k| cost(search.candidate(k))).collect();
///     search.tell(&costs);
/// }
/// assert!((search.mean()[0] - 0.2).abs() < 1e-3);
/// ```
#[derive(Clone, Debug)]
pub struct Evolution {
    mean: Vec<f64>,
    step: f64,
    variance: Vec<f64>,
    path: Vec<f64>,
    conjugate: Vec<f64>,
    weights: Vec<f64>,
    population: usize,
    generation: u64,
    seed: u64,
}

impl Evolution {
    /// Begins about `mean` with the deviation `step`, both as shares of the box, with `population` (2 or more) candidates a generation.
    pub fn new(mean: Vec<f64>, step: f64, population: usize, seed: u64) -> Self {
        let parents = (population / 2).max(1);
        let raw = (1..=parents).map(|rank| ((parents as f64 + 0.5) / rank as f64).ln());
        let sum: f64 = raw.clone().sum();
        let (weights, count) = (raw.map(|w| w / sum).collect(), mean.len());
        let (variance, path, conjugate) = (vec![1.0; count], vec![0.0; count], vec![0.0; count]);
        Self { mean, step, variance, path, conjugate, weights, population, generation: 0, seed }
    }

    /// The middle of the distribution, mirrored into the box, as shares of the box.
    pub fn mean(&self) -> Vec<f64> {
        self.mean.iter().copied().map(mirrored).collect()
    }

    /// Candidate `number` of this generation: m + sigma sqrt(C) z. The first of all is the mean.
    pub fn candidate(&self, number: usize) -> Vec<f64> {
        let drawn = self.drawn(number);
        let of = |i: usize| mirrored(self.mean[i] + self.step * self.variance[i].sqrt() * drawn[i]);
        (0..self.mean.len()).map(of).collect()
    }

    /// The normal numbers of a candidate.
    fn drawn(&self, number: usize) -> Vec<f64> {
        let place = self.generation * self.population as u64 + number as u64;
        let mut random = Random::stream(self.seed, place);
        (0..self.mean.len()).map(|_| if place == 0 { 0.0 } else { random.normal() }).collect()
    }

    /// Goes on to the next generation by the costs of this one, in the order of its candidates; one that is not a number comes last.
    ///
    /// With weights w of the better half, mu = 1/sum(w^2), y = sqrt(C) z of the ranked candidates: m += sigma sum(w y);
    /// p_s = (1 - c_s) p_s + sqrt(c_s (2 - c_s) mu) sum(w z); ln sigma += c_s/d (|p_s|/E|N| - 1);
    /// p_c = (1 - c_c) p_c + h sqrt(c_c (2 - c_c) mu) sum(w y); C = (1 - c_1 - c_mu) C + c_1 p_c^2 + c_mu sum(w y^2), where c_1 and
    /// c_mu are (n + 2)/3 times those of the full matrix.
    ///
    /// Equation: math.evolution
    /// `separable CMA-ES: m, sigma, diagonal C from the ranked half of a generation`
    /// Source: Ros & Hansen 2008, PPSN X; constants of Hansen 2016, arXiv 1604.00772.
    /// Test: `it_finds_a_minimum_of_unequal_axes_and_one_at_an_end`.
    pub fn tell(&mut self, costs: &[f64]) {
        let n = self.mean.len() as f64;
        let mu = 1.0 / self.weights.iter().map(|w| w * w).sum::<f64>();
        let c_s = (mu + 2.0) / (n + mu + 5.0);
        let damping = 1.0 + 2.0 * (((mu - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_s;
        let c_c = (4.0 + mu / n) / (n + 4.0 + 2.0 * mu / n);
        let faster = (n + 2.0) / 3.0;
        let c_1 = (faster * 2.0 / ((n + 1.3).powi(2) + mu)).min(0.5);
        let c_mu = (faster * 2.0 * (mu - 2.0 + 1.0 / mu) / ((n + 2.0).powi(2) + mu)).min(1.0 - c_1);
        let expected = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));
        let mut order: Vec<usize> = (0..costs.len().min(self.population)).collect();
        let rank = |k: &usize| if costs[*k].is_nan() { f64::INFINITY } else { costs[*k] };
        crate::order::ascend_by(&mut order, |item| rank(item));
        let drawn: Vec<Vec<f64>> = order.iter().map(|k| self.drawn(*k)).collect();
        let weighted = |i: usize, power: i32| -> f64 {
            self.weights.iter().zip(&drawn).map(|(w, z)| w * z[i].powi(power)).sum()
        };
        let sums: Vec<[f64; 2]> = (0..self.mean.len()).map(|i| [weighted(i, 1), weighted(i, 2)]).collect();
        let mut square = 0.0;
        for (p, [first, _]) in self.conjugate.iter_mut().zip(&sums) {
            *p = (1.0 - c_s) * *p + (c_s * (2.0 - c_s) * mu).sqrt() * first;
            square += *p * *p;
        }
        let length = square.sqrt();
        let begun = 1.0 - (1.0 - c_s).powi(2 * (self.generation as i32 + 1));
        let h = f64::from(u8::from(length / begun.sqrt() < (1.4 + 2.0 / (n + 1.0)) * expected));
        for (i, [first, second]) in sums.into_iter().enumerate() {
            let root = self.variance[i].sqrt();
            self.mean[i] += self.step * root * first;
            self.path[i] = (1.0 - c_c) * self.path[i] + h * (c_c * (2.0 - c_c) * mu).sqrt() * root * first;
            let old = self.variance[i];
            let ranked = self.path[i].powi(2) + (1.0 - h) * c_c * (2.0 - c_c) * old;
            self.variance[i] = (1.0 - c_1 - c_mu) * old + c_1 * ranked + c_mu * old * second;
        }
        let factor = (c_s / damping * (length / expected - 1.0)).exp();
        self.step = (self.step * factor).min(LARGEST_STEP);
        self.generation += 1;
    }
}

/// A number mirrored at 0 and 1 until it lies between.
fn mirrored(x: f64) -> f64 {
    let turn = x.rem_euclid(2.0);
    if turn > 1.0 { 2.0 - turn } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(mean: Vec<f64>, generations: usize, cost: impl Fn(&[f64]) -> f64) -> Evolution {
        let mut search = Evolution::new(mean, 0.2, 10, 3);
        for _ in 0..generations {
            let costs: Vec<f64> = (0..10).map(|k| cost(&search.candidate(k))).collect();
            search.tell(&costs);
        }
        search
    }

    #[test]
    fn it_finds_a_minimum_of_unequal_axes_and_one_at_an_end() {
        let at = [0.3, 0.7, 0.5, 0.9, 0.0];
        let cost =
            |x: &[f64]| -> f64 { (0..5).map(|i| 10_f64.powi(i as i32) * (x[i] - at[i]).powi(2)).sum() };
        let search = run(vec![0.5; 5], 250, cost);
        let mean = search.mean();
        assert!((0..5).all(|i| (mean[i] - at[i]).abs() < 1e-4), "{mean:?}");
        // Costs that are not numbers come last, and candidates stay in the box.
        let broken = run(vec![0.5; 5], 60, |x| if x[1] > 0.8 { f64::NAN } else { cost(x) });
        assert!((broken.mean()[4]).abs() < 0.02);
        assert!((0..10).all(|k| search.candidate(k).iter().all(|x| (0.0..=1.0).contains(x))));
    }

    #[test]
    fn costs_that_say_nothing_do_not_let_the_step_grow_without_end() {
        for cost in [f64::NAN, 1.0, 1e300] {
            let search = run(vec![0.5; 3], 3000, |_| cost);
            assert!(search.step > 0.0 && search.step <= LARGEST_STEP, "{}", search.step);
            assert!((0..10).all(|k| search.candidate(k).iter().all(|x| (0.0..=1.0).contains(x))));
        }
    }

    #[test]
    fn the_same_costs_make_the_same_candidates() {
        let cost = |x: &[f64]| x.iter().sum();
        let (a, b) = (run(vec![0.4; 3], 7, cost), run(vec![0.4; 3], 7, cost));
        assert_eq!(a.candidate(2), b.candidate(2));
        assert_ne!(a.candidate(2), a.candidate(3));
        assert_eq!(Evolution::new(vec![0.4; 3], 0.2, 10, 3).candidate(0), [0.4; 3]);
    }
}
