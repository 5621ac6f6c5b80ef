//! The model at the collocation points: values, Jacobians and Hessians.

use super::super::nlp::EvaluationError;
use super::super::problem::{Instant, OptimalControl, Setup};
use super::layout::{StateOf, UnknownLayout};
use crate::plant::Fault;
use wingbeat_math::{Double4, Lanes, Scalar, Tape};

/// Share of h by which the difference of the ends' rates lifts the middle of
/// the cubic through them.
pub(super) const MIDDLE: f64 = 0.125;

/// Points whose derivatives are taken side by side.
pub(super) type Four = [usize; Double4::WIDTH];

/// Derivatives at four points along the local unknowns (t, x, u, p).
#[derive(Clone, Debug, Default)]
pub(super) struct FourPoints {
    /// d outputs / d locals, row-major.
    pub jacobian: Vec<Double4>,
    /// Hessian of the weighted outputs, row-major.
    pub hessian: Vec<Double4>,
}

impl FourPoints {
    fn new(outputs: usize, locals: usize) -> Self {
        let zeros = |count: usize| vec![Double4::ZERO; count];
        Self { jacobian: zeros(outputs * locals), hessian: zeros(locals * locals) }
    }
}

/// The entries that were not zero at some point so far: all others are.
#[derive(Clone, Debug, Default)]
pub(super) struct NonZeros {
    locals: usize,
    /// For each output the locals, ascending.
    pub jacobian: Vec<Vec<usize>>,
    /// For each local the locals with which it has a second derivative, ascending.
    pub hessian: Vec<Vec<usize>>,
}

impl NonZeros {
    fn new(outputs: usize, locals: usize) -> Self {
        Self { locals, jacobian: vec![Vec::new(); outputs], hessian: vec![Vec::new(); locals] }
    }

    /// Takes those of a tape in; true when some are new.
    fn take(&mut self, tape: &Tape) -> bool {
        let mut new = false;
        let mut add = |row: &mut Vec<usize>, column: usize| {
            if let Err(place) = row.binary_search(&column) {
                row.insert(place, column);
                new = true;
            }
        };
        for ((output, v), _) in tape.jacobian() {
            add(&mut self.jacobian[output], v);
        }
        for ((v, u), _) in tape.hessian() {
            add(&mut self.hessian[v], u);
            add(&mut self.hessian[u], v);
        }
        new
    }

    /// Zeros at all of them.
    fn clear(&self, points: &mut FourPoints) {
        for (row, columns) in self.jacobian.iter().enumerate() {
            columns.iter().for_each(|v| points.jacobian[row * self.locals + v] = Double4::ZERO);
        }
        for (row, columns) in self.hessian.iter().enumerate() {
            columns.iter().for_each(|v| points.hessian[row * self.locals + v] = Double4::ZERO);
        }
    }
}

/// Outputs (rates, running cost, path values) of all points, and the derivatives of those of two groups of intervals.
#[derive(Clone, Debug, Default)]
pub(super) struct Points {
    states: usize,
    inputs: usize,
    path: usize,
    /// Number of outputs and of local unknowns.
    pub outputs: usize,
    pub locals: usize,
    pub values: Vec<f64>,
    /// Points of an interval without its last one, twice: of two groups in turns.
    sets: Vec<FourPoints>,
    pub non_zeros: NonZeros,
    /// The non-zeros are more than they were when this was last reset.
    pub grown: bool,
    tape: Tape,
    local: Vec<f64>,
    apart: [Vec<f64>; Double4::WIDTH],
    gathered: Vec<Double4>,
    recorded: Vec<Double4>,
}

impl Points {
    pub fn new(setup: &Setup, layout: &UnknownLayout) -> Self {
        let (states, inputs, path) = (setup.states.len(), setup.inputs.len(), setup.path.len());
        let (outputs, locals) = (states + 1 + path, 1 + states + inputs + setup.parameters.len());
        let [first, last] = layout.intervals[0].ends;
        Self {
            states,
            inputs,
            path,
            outputs,
            locals,
            values: vec![0.0; layout.points.len() * outputs],
            sets: vec![FourPoints::new(outputs, locals); 2 * (last - first)],
            non_zeros: NonZeros::new(outputs, locals),
            grown: true,
            tape: Tape::default(),
            local: vec![0.0; locals],
            apart: std::array::from_fn(|_| vec![0.0; locals]),
            gathered: vec![Double4::ZERO; locals],
            recorded: vec![Double4::ZERO; outputs],
        }
    }

    /// Derivatives at point `j` of the intervals of `group`.
    pub fn set(&self, group: usize, j: usize) -> &FourPoints {
        &self.sets[self.place(group, j)]
    }

    fn place(&self, group: usize, j: usize) -> usize {
        group % 2 * (self.sets.len() / 2) + j
    }

    /// Room for derivatives at the last points of the intervals of a group.
    pub fn room(&self) -> FourPoints {
        FourPoints::new(self.outputs, self.locals)
    }

    /// The derivatives at the first points of the intervals after those of `group`, each in the place of the one before it. The
    /// Hessian counts at the point in the place `last` alone, where there is one.
    pub fn shift(&self, group: usize, last: Option<usize>, out: &mut FourPoints) {
        let (own, next) = (self.set(group, 0), self.set(group + 1, 0));
        let shifted = |own: Double4, next: Double4| {
            Double4::of(|lane| if lane + 1 < Double4::WIDTH { own.lane(lane + 1) } else { next.lane(0) })
        };
        for (row, columns) in self.non_zeros.jacobian.iter().enumerate() {
            for v in columns.iter().map(|v| row * self.locals + v) {
                out.jacobian[v] = shifted(own.jacobian[v], next.jacobian[v]);
            }
        }
        let Some(last) = last else { return };
        let only = Double4::of(|lane| if lane == last { 1.0 } else { 0.0 });
        for (row, columns) in self.non_zeros.hessian.iter().enumerate() {
            for v in columns.iter().map(|v| row * self.locals + v) {
                out.hessian[v] = shifted(own.hessian[v], next.hessian[v]) * only;
            }
        }
    }

    /// Outputs of point `i`.
    pub fn value(&self, i: usize) -> &[f64] {
        &self.values[i * self.outputs..(i + 1) * self.outputs]
    }

    /// Gathers the local unknowns of point `i` from the unknowns `w`; a middle
    /// state also from the rates at the nodes.
    fn gather(&mut self, w: &[f64], layout: &UnknownLayout, i: usize) {
        let (n, m, place) = (self.states, self.inputs, &layout.points[i]);
        let times = layout.times;
        self.local[0] = w[times] * (1.0 - place.sigma) + w[times + 1] * place.sigma;
        match place.x {
            StateOf::Unknown(x) => self.local[1..=n].copy_from_slice(&w[x..x + n]),
            StateOf::Middle(k) => self.gather_middle(w, layout, k),
        }
        let [(a, wa), (b, wb)] = place.u;
        for j in 0..m {
            self.local[1 + n + j] = if wb == 0.0 { w[a + j] } else { wa * w[a + j] + wb * w[b + j] };
        }
        self.local[1 + n + m..].copy_from_slice(&w[times + 2..]);
    }

    /// x_c = (x_0 + x_1)/2 + h/8 (f_0 - f_1), as [`Interval::middle`](crate::IntervalEnds::middle).
    fn gather_middle(&mut self, w: &[f64], layout: &UnknownLayout, k: usize) {
        let interval = &layout.intervals[k];
        let [f0, f1] = interval.ends.map(|i| i * self.outputs);
        let [x0, x1] = [layout.nodes[k], layout.nodes[k + 1]];
        let h = interval.share * (w[layout.times + 1] - w[layout.times]);
        for r in 0..self.states {
            let bulge = self.values[f0 + r] - self.values[f1 + r];
            self.local[1 + r] = 0.5 * (w[x0 + r] + w[x1 + r]) + MIDDLE * h * bulge;
        }
    }

    fn outputs_at<P: OptimalControl, S: Scalar>(
        problem: &P,
        (n, m): (usize, usize),
        local: &[S],
        out: &mut [S],
    ) -> Result<(), Fault> {
        let (x, rest) = local[1..].split_at(n);
        let (u, p) = rest.split_at(m);
        let at = Instant { t: local[0], x, u, p };
        let (dx, rest) = out.split_at_mut(n);
        problem.rates(at, dx)?;
        rest[0] = problem.running_cost(at);
        problem.constrain_path(at, &mut rest[1..]);
        Ok(())
    }

    /// Time, state and input of point `i`.
    pub fn at(&mut self, w: &[f64], layout: &UnknownLayout, i: usize) -> (f64, &[f64], &[f64]) {
        self.gather(w, layout, i);
        let (x, rest) = self.local[1..].split_at(self.states);
        (self.local[0], x, &rest[..self.inputs])
    }

    /// Values of all outputs at `points`; those whose state is unknown come
    /// before middle states.
    pub fn evaluate<P: OptimalControl>(
        &mut self,
        problem: &P,
        setup: &Setup,
        layout: &UnknownLayout,
        w: &[f64],
        points: impl Iterator<Item = usize>,
    ) -> Result<(), EvaluationError> {
        let sizes = (self.states, self.inputs);
        for i in points {
            self.gather(w, layout, i);
            let out = &mut self.values[i * self.outputs..(i + 1) * self.outputs];
            Self::outputs_at(problem, sizes, &self.local, out).map_err(|f| EvaluationError(f.to_string()))?;
            if let Some(bad) = out.iter().position(|v| !v.is_finite()) {
                return Err(not_finite(setup, bad, out[bad], self.local[0]));
            }
        }
        Ok(())
    }

    /// Output `row` of four points.
    #[inline]
    pub fn four(&self, points: Four, row: usize) -> Double4 {
        Double4::of(|lane| self.values[points[lane] * self.outputs + row])
    }

    /// Jacobians of the points `at`, each point `j` of an interval of `group`, and the Hessians for the `weights` of their
    /// outputs; the values that enter middle states are known.
    pub fn differentiate<P: OptimalControl>(
        &mut self,
        problem: &P,
        layout: &UnknownLayout,
        (group, j): (usize, usize),
        at: Four,
        w: &[f64],
        weights: &[Double4],
    ) -> Result<(), EvaluationError> {
        let mut locals: [Vec<f64>; Double4::WIDTH] = std::mem::take(&mut self.apart);
        for (local, i) in locals.iter_mut().zip(at) {
            self.gather(w, layout, i);
            local.clone_from(&self.local);
        }
        for (v, out) in self.gathered.iter_mut().enumerate() {
            *out = Double4::of(|lane| locals[lane][v]);
        }
        self.apart = locals;
        let sizes = (self.states, self.inputs);
        let outputs = |local: &[_], out: &mut [_]| Self::outputs_at(problem, sizes, local, out);
        let together = self.tape.record(&self.gathered, &mut self.recorded, outputs);
        let set = self.place(group, j);
        if together == Ok(true) {
            let new = self.tape.second_order(weights);
            self.grown |= new && self.non_zeros.take(&self.tape);
            self.keep(set, None);
            return Ok(());
        }
        // What does not do the same at all of them is recorded at each, and so is what is refused, to tell where.
        let gathered = self.gathered.clone();
        for lane in 0..Double4::WIDTH {
            let splat = |of: &[Double4]| of.iter().map(|x| Double4::from(x.lane(lane))).collect::<Vec<_>>();
            let outputs = |local: &[_], out: &mut [_]| Self::outputs_at(problem, sizes, local, out);
            self.tape
                .record(&splat(&gathered), &mut self.recorded, outputs)
                .map_err(|fault| EvaluationError(fault.to_string()))?;
            let new = self.tape.second_order(&splat(weights));
            self.grown |= new && self.non_zeros.take(&self.tape);
            self.keep(set, Some(lane));
        }
        Ok(())
    }

    /// Keeps the derivatives of the tape, of all points or of one.
    fn keep(&mut self, set: usize, only: Option<usize>) {
        let (Self { tape, non_zeros, locals, sets, .. }, set) = (self, set);
        let set = &mut sets[set];
        if !tape.is_uniform() && only.is_none_or(|lane| lane == 0) {
            non_zeros.clear(set);
        }
        let put = |out: &mut Double4, value: Double4| {
            *out = match only {
                None => value,
                Some(lane) => with_lane(*out, lane, value.lane(lane)),
            }
        };
        for ((output, v), slope) in tape.jacobian() {
            put(&mut set.jacobian[output * *locals + v], slope);
        }
        for ((v, u), bend) in tape.hessian() {
            put(&mut set.hessian[v * *locals + u], bend);
            if u != v {
                put(&mut set.hessian[u * *locals + v], bend);
            }
        }
    }

    pub fn path(&self) -> usize {
        self.path
    }
}

/// `numbers` with `value` in the given lane.
fn with_lane(numbers: Double4, lane: usize, value: f64) -> Double4 {
    Double4::of(|l| if l == lane { value } else { numbers.lane(l) })
}

fn not_finite(setup: &Setup, output: usize, value: f64, t: f64) -> EvaluationError {
    let n = setup.states.len();
    let what = match output {
        i if i < n => format!("the rate of {}", setup.states[i].name),
        i if i == n => "the running cost".into(),
        i => setup.path[i - n - 1].name.clone(),
    };
    EvaluationError(format!("{what} is {value} at t = {t:.4} s"))
}
