//! Commands of a flight from a state on, part by part, of least cost within their limits.

use nalgebra::{DMatrix, DVector};
use wingbeat_math::parallel;
use wingbeat_ocp::plant::Fault;

/// Shares of a step that are tried.
const SHARES: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.03, 0.01];
/// Damping of a step over the cost of the commands: least, first, and the most that is tried.
const DAMPING: [f64; 3] = [1e-6, 1e-4, 1e6];

/// A cost that is quadratic in deviations d: d'Pd/2 + g'd.
pub(super) type Quadratic = (DMatrix<f64>, DVector<f64>);

/// The parts of a plan, and the commands that are held over each.
pub(super) struct Commanded {
    /// Number of the parts.
    pub parts: usize,
    /// Lowest and highest commands.
    pub low: DVector<f64>,
    pub high: DVector<f64>,
    /// Cost of the commands of a part.
    pub effort: DMatrix<f64>,
}

impl Commanded {
    /// A number of parts of commands that start at 0, within what is left of their ranges [low, high] (units of the channels) and at these
    /// costs (1 over their square).
    pub fn new(parts: usize, [low, high]: [DVector<f64>; 2], costs: &DVector<f64>) -> Self {
        let (low, high) = (low.map(|v| v.min(0.0)), high.map(|v| v.max(0.0)));
        Self { parts, low, high, effort: DMatrix::from_diagonal(costs) }
    }
}

/// What is planned: a flight in parts, over each of which the commands are held.
pub(super) trait Parts: Sync {
    /// The parts and their commands.
    fn commanded(&self) -> &Commanded;
    /// The state after part `k`; none where the model breaks down.
    fn next(&self, k: usize, s: &[f64], v: &DVector<f64>) -> Option<Vec<f64>>;
    /// What the state `s` is off `from`.
    fn apart(&self, s: &[f64], from: &[f64]) -> DVector<f64>;
    /// How deviations and commands grow over part `k`.
    fn linear(&self, k: usize, s: &[f64], v: &DVector<f64>) -> Result<[DMatrix<f64>; 2], Fault>;
    /// Cost of the state `s` before part `k`, or at the end.
    fn cost(&self, k: usize, s: &[f64]) -> f64;
    /// Half the second derivatives of that cost and half its slope; none where it has none.
    fn quadratic(&self, k: usize, s: &[f64]) -> Option<Quadratic>;
}

/// A plan under way: the states between the parts, the commands of every part, its cost.
pub(super) struct TrialPlan {
    pub nodes: Vec<Vec<f64>>,
    pub commands: Vec<DVector<f64>>,
    pub cost: f64,
    /// Share of the cost that the last iteration saved: no more than it may unless the iterations ran out.
    pub saved: f64,
}

/// Changes of the commands of every part, and feedback.
type Policy = Vec<(DVector<f64>, DMatrix<f64>)>;

/// When a plan is taken to be at its least.
#[derive(Clone, Copy)]
pub(super) struct Until {
    /// After so many iterations at the most.
    pub iterations: usize,
    /// After `on_end` iterations on end of which each saves less than this share of the cost. One alone says little: only a small part
    /// of its step may have been good.
    pub saved: f64,
    pub on_end: usize,
}

/// Improves the flight by `commands` step by step `until` little is saved: the model about the present plan is linear, the cost
/// quadratic, and backwards in time every part has its best command within the limits and its feedback. `damped` is the cost of the
/// commands that the damping is over.
///
/// # Errors
/// The [`Fault`] of a model that breaks down.
pub(super) fn solve(
    of: &dyn Parts,
    begin: &[f64],
    commands: Vec<DVector<f64>>,
    until: Until,
    damped: f64,
) -> Result<TrialPlan, Fault> {
    let none = Fault::NotFinite { state: 0, time: 0.0 };
    let mut best = roll(of, begin, &mut |k, _| commands[k].clone()).ok_or(none)?;
    let (mut damping, mut little) = (DAMPING[0], 0);
    for _ in 0..until.iterations {
        let linear = |k: usize, v: &DVector<f64>| of.linear(k, &best.nodes[k], v);
        let all: Vec<_> = parallel::map(&best.commands, linear).into_iter().collect::<Result<_, _>>()?;
        let better = loop {
            let found =
                backward(of, &all, &best, damping / damped).and_then(|policy| forward(of, &best, &policy));
            if found.is_some() || damping > DAMPING[2] {
                break found;
            }
            damping = (damping * 10.0).max(DAMPING[1]);
        };
        let Some(better) = better else {
            best.saved = 0.0;
            break;
        };
        damping = (damping / 5.0).max(DAMPING[0]);
        let less = (best.cost - better.cost) / better.cost;
        best = TrialPlan { saved: less, ..better };
        little = if less < until.saved { little + 1 } else { 0 };
        if little == until.on_end {
            break;
        }
    }
    Ok(best)
}

/// The flight by `command` of part and state; none where the model breaks down.
fn roll(
    of: &dyn Parts,
    begin: &[f64],
    command: &mut dyn FnMut(usize, &[f64]) -> DVector<f64>,
) -> Option<TrialPlan> {
    let mut nodes = vec![begin.to_vec()];
    let Commanded { parts, effort, .. } = of.commanded();
    let mut commands = Vec::with_capacity(*parts);
    let mut cost = 0.0;
    for k in 0..*parts {
        let s = &nodes[k];
        let v = command(k, s);
        cost += v.dot(&(effort * &v)) + of.cost(k, s);
        let next = of.next(k, s, &v)?;
        nodes.push(next);
        commands.push(v);
    }
    cost += of.cost(*parts, &nodes[*parts]);
    cost.is_finite().then_some(TrialPlan { nodes, commands, cost, saved: f64::INFINITY })
}

/// For every part the change of its command and its feedback; none where the damping is too little.
fn backward(of: &dyn Parts, all: &[[DMatrix<f64>; 2]], flown: &TrialPlan, damping: f64) -> Option<Policy> {
    let Commanded { parts, low, high, effort } = of.commanded();
    let parts = *parts;
    let (mut p, mut g) = of.quadratic(parts, &flown.nodes[parts])?;
    let mut policy = Vec::with_capacity(parts);
    for k in (0..parts).rev() {
        let ([a, b], u) = (&all[k], &flown.commands[k]);
        let pb = &p * b;
        let curved = b.transpose() * &pb + effort * (1.0 + damping);
        let slope = effort * u + b.transpose() * &g;
        let cross = pb.transpose() * a;
        let (step, free) = boxed(&curved, &slope, &(low - u), &(high - u))?;
        let feedback = -masked(&curved, &free).cholesky()?.solve(&cross_of(&cross, &free));
        g = a.transpose() * &g
            + feedback.transpose() * (&curved * &step + &slope)
            + cross.transpose() * &step;
        p = a.transpose() * &p * a
            + feedback.transpose() * (&curved * &feedback + &cross)
            + cross.transpose() * &feedback;
        p = (&p + p.transpose()) * 0.5;
        if let Some((own, slope)) = of.quadratic(k, &flown.nodes[k]) {
            p += own;
            g += slope;
        }
        policy.push((step, feedback));
    }
    policy.reverse();
    Some(policy)
}

/// The flight by `policy` about the plan `flown`, by the first share of its steps that costs less.
fn forward(of: &dyn Parts, flown: &TrialPlan, policy: &Policy) -> Option<TrialPlan> {
    let Commanded { low, high, .. } = of.commanded();
    let by = |share: f64| {
        let found = roll(of, &flown.nodes[0], &mut |k, s| {
            let (step, feedback) = &policy[k];
            let v = &flown.commands[k] + step * share + feedback * of.apart(s, &flown.nodes[k]);
            v.sup(low).inf(high)
        });
        found.filter(|found| found.cost < flown.cost)
    };
    SHARES.into_iter().find_map(by)
}

/// Most steps of the quadratic problem of a command: each frees or holds some of a handful.
const BOXED: usize = 30;

/// The least of v'Hv/2 + g'v within limits, and which numbers are at none.
fn boxed(
    h: &DMatrix<f64>,
    g: &DVector<f64>,
    low: &DVector<f64>,
    high: &DVector<f64>,
) -> Option<(DVector<f64>, Vec<bool>)> {
    let mut v = DVector::zeros(g.len()).sup(low).inf(high);
    for _ in 0..BOXED {
        let slope = g + h * &v;
        let free: Vec<bool> = (0..g.len())
            .map(|i| !(v[i] <= low[i] && slope[i] > 0.0 || v[i] >= high[i] && slope[i] < 0.0))
            .collect();
        let step = -masked(h, &free)
            .cholesky()?
            .solve(&DVector::from_fn(g.len(), |i, _| if free[i] { slope[i] } else { 0.0 }));
        let next = (&v + step).sup(low).inf(high);
        let moved = (&next - &v).amax();
        v = next;
        if moved < 1e-12 {
            return Some((v, free));
        }
    }
    let free = (0..g.len()).map(|i| v[i] > low[i] && v[i] < high[i]).collect();
    Some((v, free))
}

/// The matrix of the free numbers, those held standing alone.
fn masked(h: &DMatrix<f64>, free: &[bool]) -> DMatrix<f64> {
    DMatrix::from_fn(h.nrows(), h.ncols(), |i, j| {
        if free[i] && free[j] { h[(i, j)] } else { f64::from(u8::from(i == j)) }
    })
}

/// Rows of the free numbers, zero for those held.
fn cross_of(cross: &DMatrix<f64>, free: &[bool]) -> DMatrix<f64> {
    DMatrix::from_fn(cross.nrows(), cross.ncols(), |i, j| if free[i] { cross[(i, j)] } else { 0.0 })
}
