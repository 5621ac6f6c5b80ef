//! Derivatives at four points side by side.

use super::super::{Double4, Lanes, Scalar};
use super::elimination::{TapeCells, TapeElimination};
use super::{Tape, TapeRecording, Traced};

/// Eliminations that are kept, and sequences of operations that are counted.
const KEPT: usize = 8;
const COUNTED: usize = 32;
/// Sequences longer than this are not eliminated: sweeps over them take less, as the products grow faster than the nodes
/// (709 for 133 nodes, 79 thousand for 1909, 628 thousand for 5252).
const LONGEST: usize = 1000;
/// How often a sequence is met before it is eliminated: sweeps over so many take as long as finding the order.
const OFTEN: u32 = 50;

/// Functions recorded at up to four points, the lanes, with the derivatives of them all. Points whose operations are the same
/// and were met often share the work; the others have sweeps of their own.
#[derive(Clone, Debug, Default)]
pub struct TapeFour {
    tape: Tape,
    /// What was recorded in lanes that have an elimination, of which the place is known.
    recorded: [TapeRecording; Double4::WIDTH],
    planned: [Option<usize>; Double4::WIDTH],
    /// Lanes recorded so far.
    lanes: usize,
    known: Vec<TapeElimination>,
    /// Hashes of sequences that have none, and how often they were met; the latest first.
    met: Vec<(u64, u32)>,
    cells: Option<TapeCells>,
    /// Jacobian and Hessian of each lane, of those that are taken apart.
    apart: [[Vec<f64>; 2]; Double4::WIDTH],
    /// Of the Jacobian and of the Hessian: all bits where no derivative was seen, none elsewhere.
    unseen: [Vec<u64>; 2],
    /// The non-zeros are more than they were when this was last reset.
    pub grown: bool,
    /// For each output the inputs along which it was seen to change, ascending.
    pub slopes: Vec<Vec<usize>>,
    /// For each input those with which it was seen to have a second derivative, ascending.
    pub bends: Vec<Vec<usize>>,
}

/// Derivatives at four points; what was zero so far is.
#[derive(Clone, Debug, Default)]
pub struct FourDerivatives {
    /// d outputs / d inputs, row-major.
    pub jacobian: Vec<Double4>,
    /// Hessian of the weighted outputs, row-major.
    pub hessian: Vec<Double4>,
    /// The elimination that wrote all lanes last.
    from: Option<usize>,
}

impl FourDerivatives {
    /// Zeros.
    pub fn new(outputs: usize, inputs: usize) -> Self {
        let zeros = |count: usize| vec![Double4::ZERO; count];
        Self { jacobian: zeros(outputs * inputs), hessian: zeros(inputs * inputs), from: None }
    }
}

impl TapeFour {
    /// For functions of so many outputs and inputs.
    pub fn new(outputs: usize, inputs: usize) -> Self {
        Self {
            apart: std::array::from_fn(|_| [vec![0.0; outputs * inputs], vec![0.0; inputs * inputs]]),
            unseen: [outputs, inputs].map(|rows| vec![u64::MAX; rows * inputs]),
            slopes: vec![Vec::new(); outputs],
            bends: vec![Vec::new(); inputs],
            grown: true,
            ..Self::default()
        }
    }

    /// Begins four points anew.
    pub fn begin(&mut self) {
        self.lanes = 0;
    }

    /// Records `f(inputs, outputs)` at the point of the next lane, whose outputs will have the given `weights`, and writes the
    /// output values, all in the units of the caller.
    pub fn record<E>(
        &mut self,
        inputs: &[f64],
        outputs: &mut [f64],
        weights: &[f64],
        f: impl FnOnce(&[Traced], &mut [Traced]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.tape.record(inputs, outputs, f)?;
        self.keep(weights);
        Ok(())
    }

    /// Keeps what was recorded for the elimination that it has, or sweeps it.
    fn keep(&mut self, weights: &[f64]) {
        let lane = self.lanes;
        self.lanes += 1;
        self.planned[lane] = self.plan();
        if self.planned[lane].is_some() {
            std::mem::swap(&mut self.recorded[lane], &mut self.tape.recorded);
            return;
        }
        let [jacobian, hessian] = &mut self.apart[lane];
        self.tape.second_order(weights, jacobian, hessian);
        let [first, second] = &mut self.unseen;
        self.grown |= widen(&mut self.slopes, first, jacobian);
        self.grown |= widen(&mut self.bends, second, hessian);
    }

    /// The elimination of what was recorded last.
    fn plan(&mut self) -> Option<usize> {
        let recorded = &self.tape.recorded;
        if recorded.nodes.len() > LONGEST {
            return None;
        }
        let latest = self.lanes.checked_sub(2).and_then(|before| self.planned[before]).unwrap_or(0);
        if self.known.get(latest).is_some_and(|known| known.fits(recorded)) {
            return Some(latest);
        }
        let hash = hash(recorded);
        let found = self.known.iter().position(|known| known.hash == hash && known.fits(recorded));
        if found.is_some() {
            return found;
        }
        let count = match self.met.iter().position(|met| met.0 == hash) {
            Some(place) => {
                self.met[..=place].rotate_right(1);
                self.met[0].1 += 1;
                self.met[0].1
            }
            None => {
                self.met.truncate(COUNTED - 1);
                self.met.insert(0, (hash, 1));
                1
            }
        };
        // One of which no elimination came stays counted, and is not tried again.
        if count != OFTEN || self.known.len() == KEPT {
            return None;
        }
        let known = TapeElimination::new(recorded, hash)?;
        let inputs = self.bends.len();
        for &((output, v), _) in &known.jacobian {
            self.grown |= insert(&mut self.slopes[output], v);
            self.unseen[0][output * inputs + v] = 0;
        }
        for &((v, u), _) in &known.hessian {
            self.grown |= insert(&mut self.bends[v], u) | insert(&mut self.bends[u], v);
            (self.unseen[1][v * inputs + u], self.unseen[1][u * inputs + v]) = (0, 0);
        }
        self.known.push(known);
        Some(self.known.len() - 1)
    }

    /// The derivatives at the points recorded since the last [`Self::begin`], for the `weights` of the outputs; lanes that were not
    /// recorded are as the last one.
    pub fn second_order(&mut self, weights: &[Double4], out: &mut FourDerivatives) {
        let last = self.lanes - 1;
        let planned: [_; Double4::WIDTH] = std::array::from_fn(|lane| self.planned[lane.min(last)]);
        let inputs = self.bends.len();
        if let Some(plan) = planned[0]
            && planned.iter().all(|other| *other == planned[0])
        {
            self.run(plan, weights, &planned);
            let (known, cells) = (&self.known[plan], self.cells.get_or_insert_default());
            if out.from.replace(plan) != Some(plan) {
                out.jacobian.fill(Double4::ZERO);
                out.hessian.fill(Double4::ZERO);
            }
            for &((output, v), cell) in &known.jacobian {
                out.jacobian[output * inputs + v] = Double4::new(cells.at(cell));
            }
            for &((v, u), cell) in &known.hessian {
                let bend = Double4::new(cells.at(cell));
                (out.hessian[v * inputs + u], out.hessian[u * inputs + v]) = (bend, bend);
            }
            return;
        }
        for lane in 0..Double4::WIDTH {
            if let Some(plan) = planned[lane]
                && !planned[..lane].contains(&planned[lane])
            {
                self.run(plan, weights, &planned);
                self.take_apart(plan, &planned);
            }
        }
        out.from = None;
        let [a, b, c, d] = [0, 1, 2, 3].map(|lane: usize| &self.apart[lane.min(last)]);
        bring_together([&a[0], &b[0], &c[0], &d[0]], &mut out.jacobian);
        bring_together([&a[1], &b[1], &c[1], &d[1]], &mut out.hessian);
    }

    /// Writes the numbers of the elimination `plan` in the lanes that have it; those in others are of no account.
    fn run(&mut self, plan: usize, weights: &[Double4], planned: &[Option<usize>; Double4::WIDTH]) {
        let last = self.lanes - 1;
        let one = planned.iter().position(|other| *other == Some(plan)).unwrap_or_default();
        let recorded = std::array::from_fn(|lane| {
            let own = if planned[lane] == Some(plan) { lane } else { one };
            &self.recorded[own.min(last)]
        });
        self.known[plan].run(recorded, weights, self.cells.get_or_insert_default());
    }

    /// Writes what an elimination gave to the lanes that have it.
    fn take_apart(&mut self, plan: usize, planned: &[Option<usize>; Double4::WIDTH]) {
        let (known, inputs) = (&self.known[plan], self.bends.len());
        let cells = self.cells.get_or_insert_default();
        for lane in (0..self.lanes).filter(|lane| planned[*lane] == Some(plan)) {
            let [jacobian, hessian] = &mut self.apart[lane];
            jacobian.fill(0.0);
            hessian.fill(0.0);
            for &((output, v), cell) in &known.jacobian {
                jacobian[output * inputs + v] = cells.at(cell)[lane];
            }
            for &((v, u), cell) in &known.hessian {
                let bend = cells.at(cell)[lane];
                (hessian[v * inputs + u], hessian[u * inputs + v]) = (bend, bend);
            }
        }
    }
}

/// The numbers of four lanes as numbers of four.
fn bring_together([a, b, c, d]: [&[f64]; Double4::WIDTH], out: &mut [Double4]) {
    let count = out.len();
    let (a, b, c, d) = (&a[..count], &b[..count], &c[..count], &d[..count]);
    let (fours, rest) = out.as_chunks_mut::<{ Double4::WIDTH }>();
    let ((a, ends_a), (b, ends_b)) = (a.as_chunks(), b.as_chunks());
    let ((c, ends_c), (d, ends_d)) = (c.as_chunks(), d.as_chunks());
    for k in 0..fours.len().min(a.len()).min(b.len()).min(c.len()).min(d.len()) {
        let lanes = [Double4::new(a[k]), Double4::new(b[k]), Double4::new(c[k]), Double4::new(d[k])];
        let [a, b, c, d] = Double4::transposed(lanes);
        fours[k] = [Double4::new(a), Double4::new(b), Double4::new(c), Double4::new(d)];
    }
    for k in 0..rest.len() {
        let numbers = [ends_a[k], ends_b[k], ends_c[k], ends_d[k]];
        rest[k] = Double4::of(|lane| numbers[lane]);
    }
}

/// Puts `column` where it belongs; true when it was not there.
fn insert(row: &mut Vec<usize>, column: usize) -> bool {
    match row.binary_search(&column) {
        Ok(_) => false,
        Err(place) => {
            row.insert(place, column);
            true
        }
    }
}

/// Takes in what was seen not to be zero; true when some of it is new. `unseen` has all bits where nothing was.
fn widen(rows: &mut [Vec<usize>], unseen: &mut [u64], values: &[f64]) -> bool {
    // Without the sign.
    let bits = |value: f64| value.to_bits() << 1;
    let mut new = 0;
    for k in 0..values.len().min(unseen.len()) {
        new |= bits(values[k]) & unseen[k];
    }
    if new == 0 {
        return false;
    }
    let inputs = values.len() / rows.len();
    for k in (0..values.len()).filter(|k| bits(values[*k]) & unseen[*k] != 0).collect::<Vec<_>>() {
        insert(&mut rows[k / inputs], k % inputs);
        unseen[k] = 0;
    }
    true
}

/// Tells sequences of operations apart: a multiplication for each, in two chains so that one does not wait for the other.
fn hash(recorded: &TapeRecording) -> u64 {
    const FACTOR: u64 = 0x9E37_79B9_7F4A_7C15;
    let mut sums = [recorded.nodes.len() as u64, recorded.outputs.len() as u64];
    for (i, node) in recorded.nodes.iter().enumerate() {
        let [a, b] = node.parents.map(u64::from);
        let sum = &mut sums[i % 2];
        *sum = (sum.rotate_left(5) ^ a ^ b << 32 ^ (node.kind as u64) << 28).wrapping_mul(FACTOR);
    }
    sums[0].rotate_left(32) ^ sums[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dual;

    const W: [f64; 3] = [0.4, -2.1, 1.0];
    /// A point of each lane.
    const POINTS: [[f64; 3]; 4] = [[0.7, -1.3, 0.9], [0.2, 0.4, 1.7], [-0.6, 2.1, 0.3], [1.9, -0.2, 2.5]];

    /// Every operation, sums of two factors, an operand met twice, and a branch.
    fn functions<S: Scalar>(x: &[S], out: &mut [S]) -> Result<(), f64> {
        let [a, b, c] = [x[0], x[1], x[2]];
        let (s, co) = (a * b).sin_cos();
        out[0] = s / (co + 2.0) + (a * a + c * c).sqrt() * b.exp() - c.ln();
        out[1] = a.atan2(b * c) + (b - c * 0.5).tanh() * c.recip() - a / b;
        out[2] = if a > b { (a + a) * (b - a) / (a + 3.0) } else { S::from(4.0) };
        out[0] *= a + 1.0;
        Ok(())
    }

    /// Records `count` points and looks at the derivatives of all lanes.
    fn check(tape: &mut TapeFour, found: &mut FourDerivatives, count: usize) {
        tape.begin();
        for x in &POINTS[..count] {
            let mut out = [0.0; 3];
            tape.record(x, &mut out, &W, functions).unwrap();
            let mut exact = [0.0; 3];
            functions(x, &mut exact).unwrap();
            assert!(out.iter().zip(exact).all(|(out, exact)| (out - exact).abs() < 1e-13));
        }
        tape.second_order(&W.map(Double4::from), found);
        type Second = Dual<3, Dual<3>>;
        for lane in 0..4 {
            let x = POINTS[lane.min(count - 1)];
            let xs: [Second; 3] = std::array::from_fn(|i| Dual::variable(Dual::variable(x[i], i), i));
            let mut ys = [Second::ZERO; 3];
            functions(&xs, &mut ys).unwrap();
            for i in 0..3 {
                for j in 0..3 {
                    let slope = ys[i].eps[j].re;
                    let error = found.jacobian[3 * i + j].lane(lane) - slope;
                    assert!(error.abs() < 1e-13 * (1.0 + slope.abs()), "{lane} {i} {j}");
                    let bend: f64 = (0..3).map(|k| W[k] * ys[k].eps[i].eps[j]).sum();
                    let error = found.hessian[3 * i + j].lane(lane) - bend;
                    assert!(error.abs() < 1e-12 * (1.0 + bend.abs()), "{lane} {i} {j}");
                    assert!(slope == 0.0 || tape.slopes[i].contains(&j));
                    assert!(bend == 0.0 || tape.bends[i].contains(&j));
                }
            }
        }
    }

    #[test]
    fn four_points_agree_with_nested_duals() {
        let (mut tape, mut found) = (TapeFour::new(3, 3), FourDerivatives::new(3, 3));
        // Two of the four go each way.
        for _ in 0..OFTEN {
            check(&mut tape, &mut found, 4);
            check(&mut tape, &mut found, 1);
        }
        assert_eq!(tape.known.len(), 2);
        // Fewer points than lanes, after all of them.
        for count in [4, 1, 2, 3, 1, 4] {
            check(&mut tape, &mut found, count);
        }
        assert_eq!((tape.known.len(), found.from), (2, None));
        check(&mut tape, &mut found, 1);
        assert_eq!(found.from, Some(0));
    }

    #[test]
    fn a_factor_that_is_one_at_a_point_is_no_unit_at_others() {
        fn scaled<S: Scalar>(x: &[S], out: &mut [S]) -> Result<(), f64> {
            // A number that is not recorded: the factor of both slopes.
            let factor = x[0].value();
            out[0] = x[1] * factor + x[2] * factor;
            Ok(())
        }
        let (mut tape, mut found) = (TapeFour::new(1, 3), FourDerivatives::new(1, 3));
        for first in [1.0].repeat(OFTEN as usize).into_iter().chain([2.0]) {
            tape.begin();
            tape.record(&[first, 3.0, 4.0], &mut [0.0], &[1.0], scaled).unwrap();
            tape.second_order(&[Double4::ONE], &mut found);
            assert_eq!(
                found.jacobian.iter().map(|slope| slope.lane(0)).collect::<Vec<_>>(),
                [0.0, first, first]
            );
        }
        assert_eq!(tape.known.len(), 1);
    }

    #[test]
    fn what_takes_more_products_than_sweeps_is_swept() {
        // Each sum is of all that came before it.
        fn dense<S: Scalar>(x: &[S], out: &mut [S]) -> Result<(), f64> {
            let mut all = x.to_vec();
            for _ in 0..2 {
                for i in 0..x.len() {
                    all[i] = all.iter().fold(S::ZERO, |sum, of| sum + *of * 0.1).sin();
                }
            }
            out[0] = all.iter().fold(S::ONE, |product, of| product * *of);
            Ok(())
        }
        let (mut tape, mut found) = (TapeFour::new(1, 20), FourDerivatives::new(1, 20));
        for _ in 0..OFTEN + 1 {
            tape.begin();
            tape.record(&[0.5; 20], &mut [0.0], &[1.0], dense).unwrap();
            tape.second_order(&[Double4::ONE], &mut found);
        }
        assert_eq!((tape.known.len(), tape.met[0].1), (0, OFTEN + 1));
    }
}
