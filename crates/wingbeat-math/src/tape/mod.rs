//! Derivatives of long functions: the operations are recorded once, at four points side by side, and eliminated one by one from the
//! graph of their slopes, which leaves the Jacobian and the Hessian of a weighted sum of the outputs, exactly. The order of the
//! elimination is found once for all points whose operations are the same.

mod elimination;
mod traced;

use super::{Double4, Lanes, Scalar};
use elimination::TapeElimination;
use traced::{TapeRecording, Traced};

/// Node number of a constant; the operand that is missing.
const CONSTANT: u32 = u32::MAX;
const NONE: u32 = u32::MAX;
/// Places of the numbers 0, 1 and -1; behind them are the weights of the outputs, then their factors.
const ZERO: u32 = 0;
const ONE: u32 = 1;
const MINUS: u32 = 2;
const FIRST: usize = 3;
/// Eliminations that are kept.
const KEPT: usize = 8;

/// A recorded function and the scratch of its derivatives; reused point after point without allocation once it has grown. Inputs and
/// outputs are in the caller's units.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    recording: TapeRecording,
    traced: Vec<Traced>,
    outputs: Vec<Traced>,
    /// Nodes of the outputs and places of their factors.
    ends: Vec<[u32; 2]>,
    /// The latest first.
    known: Vec<TapeElimination>,
}

impl Tape {
    /// Records `f(inputs, outputs)` at four points and writes the output values. False where `f` did not do the same at
    /// all of them: what was recorded then holds for none, and each is recorded by itself.
    pub fn record<E>(
        &mut self,
        inputs: &[Double4],
        outputs: &mut [Double4],
        f: impl FnOnce(&[Traced], &mut [Traced]) -> Result<(), E>,
    ) -> Result<bool, E> {
        let factors = FIRST + outputs.len();
        self.recording.begin(factors + outputs.len());
        traced::exchange(&mut self.recording);
        self.traced.clear();
        self.traced.extend(inputs.iter().map(|&value| Traced::input(value)));
        self.outputs.clear();
        self.outputs.resize(outputs.len(), Traced::ZERO);
        let result = f(&self.traced, &mut self.outputs);
        traced::exchange(&mut self.recording);
        self.ends.clear();
        for (i, (out, traced)) in outputs.iter_mut().zip(&self.outputs).enumerate() {
            *out = traced.value;
            let factor = if traced.unit == NONE { (factors + i) as u32 } else { traced.unit };
            self.recording.cells[factors + i] = traced.factor;
            self.ends.push([traced.node, factor]);
        }
        result.map(|()| !self.recording.asked)
    }

    /// The Jacobian of the outputs and the Hessian of sum_i weights_i output_i at the points recorded last. True where the operations
    /// are none that were met lately, so that other derivatives may be zero than before.
    pub fn second_order(&mut self, weights: &[Double4]) -> bool {
        let (shape, ends, inputs) = (&self.recording.shape, &self.ends, self.traced.len());
        let place = self.known.iter().position(|known| known.fits(shape, ends, inputs));
        match place {
            Some(0) => {}
            Some(place) => self.known[..=place].rotate_right(1),
            None => {
                self.known.truncate(KEPT - 1);
                self.known.insert(0, TapeElimination::new(shape, ends, inputs, self.recording.used));
            }
        }
        let cells = &mut self.recording.cells;
        (cells[ZERO as usize], cells[ONE as usize], cells[MINUS as usize]) =
            (Double4::ZERO, Double4::ONE, -Double4::ONE);
        cells[FIRST..][..weights.len()].copy_from_slice(weights);
        self.known[0].run(cells);
        place.is_none()
    }

    /// True when all recordings had the same operations.
    pub fn is_uniform(&self) -> bool {
        self.known.len() == 1
    }

    /// The derivatives (output, input) that are not zero wherever the operations are those recorded last.
    pub fn jacobian(&self) -> impl Iterator<Item = ((usize, usize), Double4)> {
        self.read(|known| &known.jacobian)
    }

    /// The second derivatives that are not, each pair of inputs once, the larger number first.
    pub fn hessian(&self) -> impl Iterator<Item = ((usize, usize), Double4)> {
        self.read(|known| &known.hessian)
    }

    fn read(
        &self,
        of: fn(&TapeElimination) -> &Vec<elimination::TapeEntry>,
    ) -> impl Iterator<Item = ((usize, usize), Double4)> {
        let entries = self.known.first().map_or(&[][..], |known| of(known).as_slice());
        entries.iter().map(|&(place, cell)| (place, self.recording.cells[cell as usize]))
    }

    /// Writes the derivatives of the first point: the Jacobian (row-major outputs x inputs) and the Hessian (row-major inputs x inputs).
    pub fn write_first(&self, jacobian: &mut [f64], hessian: &mut [f64]) {
        let n = self.traced.len();
        jacobian.fill(0.0);
        hessian.fill(0.0);
        for ((i, j), value) in self.jacobian() {
            jacobian[i * n + j] = value.lane(0);
        }
        for ((i, j), value) in self.hessian() {
            hessian[i * n + j] = value.lane(0);
            hessian[j * n + i] = value.lane(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dual;

    fn every_operation<S: Scalar>(x: &[S], out: &mut [S]) {
        let [a, b, c] = [x[0], x[1], x[2]];
        let (s, co) = (a * b).sin_cos();
        out[0] = s / (co + 2.0) + (a * a + c * c).sqrt() * b.exp() - c.ln();
        out[1] = a.atan2(b * c) + (b - c * 0.5).tanh() * c.recip() - a / b;
        out[2] = S::from(4.0);
        out[0] *= a + 1.0;
    }

    /// A point of each lane.
    const POINTS: [[f64; 3]; 4] = [[0.7, -1.3, 0.9], [0.2, 0.4, 1.7], [-0.6, 2.1, 0.3], [1.9, -0.2, 2.5]];

    fn inputs() -> [Double4; 3] {
        std::array::from_fn(|i| Double4::of(|lane| POINTS[lane][i]))
    }

    #[test]
    fn tape_agrees_with_nested_duals() {
        let w = [0.4, -2.1, 1.0];
        let (mut tape, mut out) = (Tape::default(), [Double4::ZERO; 3]);
        for _ in 0..2 {
            let record = |x: &[Traced], out: &mut [Traced]| {
                every_operation(x, out);
                Ok::<(), ()>(())
            };
            assert!(tape.record(&inputs(), &mut out, record).unwrap());
            tape.second_order(&w.map(Double4::from));
        }
        assert_eq!(tape.known.len(), 1);
        type Second = Dual<3, Dual<3>>;
        for (lane, x) in POINTS.iter().enumerate() {
            let xs: [Second; 3] = std::array::from_fn(|i| Dual::variable(Dual::variable(x[i], i), i));
            let mut ys = [Second::ZERO; 3];
            every_operation(&xs, &mut ys);
            let (mut jacobian, mut hessian) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
            tape.jacobian().for_each(|((i, j), slope)| jacobian[i][j] = slope.lane(lane));
            tape.hessian().for_each(|((i, j), bend)| hessian[i][j] = bend.lane(lane));
            for i in 0..3 {
                assert!((out[i].lane(lane) - ys[i].value()).abs() < 1e-13);
                for j in 0..3 {
                    let scale = 1.0 + ys[i].eps[j].re.abs();
                    assert!((jacobian[i][j] - ys[i].eps[j].re).abs() < 1e-13 * scale);
                    let second: f64 = (0..3).map(|k| w[k] * ys[k].eps[i].eps[j]).sum();
                    let found = hessian[i.max(j)][i.min(j)];
                    assert!((found - second).abs() < 1e-12 * (1.0 + second.abs()), "{lane} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn points_that_branch_apart_are_told() {
        fn branches<S: Scalar>(x: &[S], out: &mut [S]) -> Result<(), f64> {
            out[0] = if x[0].value() == x[0].value() && x[1] > x[2] { x[0] * x[1] } else { x[1].abs() };
            Ok(())
        }
        let (mut tape, mut out, mut slopes, mut bends) =
            (Tape::default(), [Double4::ZERO], [0.0; 3], [0.0; 9]);
        assert_eq!(tape.record(&inputs(), &mut out, branches), Ok(false));
        for (x, slope) in [(0, [0.0, -1.0, 0.0]), (2, [2.1, -0.6, 0.0])] {
            let one = POINTS[x].map(Double4::from);
            assert_eq!(tape.record(&one, &mut out, branches), Ok(true));
            tape.second_order(&[Double4::ONE]);
            tape.write_first(&mut slopes, &mut bends);
            assert_eq!(slopes, slope);
        }
        assert_eq!((bends[1], bends[3], tape.known.len()), (1.0, 1.0, 2));
    }
}
