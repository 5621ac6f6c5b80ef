//! A plan as the solver has it: states and inputs at its nodes, constants, and multipliers.

use serde::Serialize;
use wingbeat_flight::simulate::{Column, Record};
use wingbeat_math::Error;
use wingbeat_ocp::{Ends, Interpolant, Multipliers, OptimalControl, Optimum, Setup, Trajectory};

/// The unknowns of a plan with the multipliers that belong to them.
#[derive(Clone, Debug)]
pub struct PlanNodes {
    /// One row per point whose state is an unknown: times, states, inputs, multipliers.
    pub points: Record,
    /// What has one value in the whole plan.
    pub constants: PlanConstants,
}

/// `plan.json`: what of a plan has one value, with its limits and multiplier.
#[derive(Clone, Debug, Serialize)]
pub struct PlanConstants {
    /// Collocation scheme.
    pub scheme: &'static str,
    /// Its order.
    pub order: i32,
    /// Rows of `plan.parquet` from node to node: 1 where nodes alone are unknown.
    pub rows_per_interval: usize,
    /// Intervals.
    pub intervals: usize,
    /// What is least, in the unit of the plan's cost.
    pub objective: f64,
    /// Its unit; multipliers are in this unit per unit of what they belong to.
    pub objective_unit: &'static str,
    /// Initial and final time, s, then the parameters.
    pub unknowns: Vec<PlanValue>,
    /// Constraints on the ends.
    pub ends: Vec<PlanValue>,
}

/// A number of a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanValue {
    /// Name.
    pub name: String,
    /// Unit; empty when it has none.
    pub unit: &'static str,
    /// The number, in `unit`.
    pub value: f64,
    /// Lowest value allowed, in `unit`; absent without one.
    pub low: Option<f64>,
    /// Highest value allowed, in `unit`; absent without one.
    pub high: Option<f64>,
    /// Multiplier of its limits, in the unit of the objective over its own, positive at the upper one: the objective rises by
    /// its negative where the limit that holds goes up by one.
    pub multiplier: f64,
}

impl PlanConstants {
    /// The parameters, in their own units.
    pub fn parameters(&self) -> Vec<f64> {
        self.unknowns[2..].iter().map(|unknown| unknown.value).collect()
    }
}

/// What of `optimum` can be written; none where nothing could be evaluated.
///
/// # Errors
/// Two states or inputs of one name.
pub(super) fn nodes<P: OptimalControl>(
    problem: &P,
    optimum: &Optimum,
    objective_unit: &'static str,
) -> Result<Option<PlanNodes>, Error> {
    let (Some(solution), Some(multipliers)) = (&optimum.solution, &optimum.multipliers) else {
        return Ok(None);
    };
    let setup = problem.setup();
    let constants = PlanConstants {
        scheme: solution.scheme().name,
        order: solution.scheme().order,
        rows_per_interval: if solution.scheme().compressed { 1 } else { solution.scheme().points() - 1 },
        intervals: solution.intervals(),
        objective: optimum.objective,
        objective_unit,
        unknowns: unknowns(&setup, solution, multipliers),
        ends: ends(problem, &setup, solution, multipliers),
    };
    let points = points(&setup, solution, multipliers, objective_unit)?;
    Ok(Some(PlanNodes { points, constants }))
}

fn value(name: &str, unit: &'static str, value: f64, limits: [f64; 2], multiplier: f64) -> PlanValue {
    let [low, high] = limits.map(|limit| Some(limit).filter(|limit| limit.is_finite()));
    PlanValue { name: name.into(), unit, value, low, high, multiplier }
}

fn unknowns(setup: &Setup, solution: &Interpolant, multipliers: &Multipliers) -> Vec<PlanValue> {
    let Trajectory { t, p, .. } = &solution.points;
    let times = [("initial time", t[0], setup.times[0]), ("final time", t[t.len() - 1], setup.times[1])];
    let times = times.into_iter().map(|(name, t, limits)| (name, "s", t, limits));
    let parameters = setup.parameters.iter().zip(p);
    let parameters = parameters.map(|(c, p)| (c.name.as_ref(), c.unit, *p, [c.low, c.high]));
    let all = times.chain(parameters).zip(&multipliers.constants);
    all.map(|((name, unit, v, limits), multiplier)| value(name, unit, v, limits, *multiplier)).collect()
}

fn ends<P: OptimalControl>(
    problem: &P,
    setup: &Setup,
    solution: &Interpolant,
    multipliers: &Multipliers,
) -> Vec<PlanValue> {
    let Trajectory { t, x, p, .. } = &solution.points;
    let last = t.len() - 1;
    let mut values = vec![0.0; setup.ends.len()];
    problem.constrain_ends(Ends { t: [t[0], t[last]], x: [&x[0], &x[last]], p }, &mut values);
    let all = setup.ends.iter().zip(values).zip(&multipliers.ends);
    all.map(|((c, v), multiplier)| value(&c.name, c.unit, v, [c.low, c.high], *multiplier)).collect()
}

/// The unit of a multiplier.
fn per(objective: &str, unit: &str) -> String {
    match unit {
        "" => objective.into(),
        _ if unit.contains(['/', ' ']) => format!("{objective}/({unit})"),
        _ => format!("{objective}/{unit}"),
    }
}

/// The columns of `plan.parquet`.
fn columns(setup: &Setup, objective: &str) -> Vec<Column> {
    let own = setup.states.iter().chain(&setup.inputs);
    let multiplier = |kind: &str, name: &str, unit: &str| {
        Column::new(format!("{kind}_{}", name.replace(' ', "_")), per(objective, unit), "")
    };
    let mut columns = vec![Column::new("t", "s", ""), Column::new("interval", "", "")];
    columns.extend(own.clone().map(|c| Column { name: c.name.replace(' ', "_"), ..Column::from(c) }));
    columns.extend(setup.states.iter().map(|c| multiplier("defect", &c.name, c.unit)));
    columns.extend(own.map(|c| multiplier("limit", &c.name, c.unit)));
    columns.extend(setup.path.iter().map(|c| multiplier("path", &c.name, c.unit)));
    columns
}

fn points(
    setup: &Setup,
    solution: &Interpolant,
    multipliers: &Multipliers,
    objective: &str,
) -> Result<Record, Error> {
    let Trajectory { t, x, u, .. } = &solution.points;
    let rows: Vec<usize> = (0..t.len()).filter(|point| solution.is_unknown(*point)).collect();
    let mut record = Record::new(columns(setup, objective), rows.len())?;
    let inner = solution.scheme().points() - 1;
    let or_zeros = |values: &[f64], count: usize| {
        if values.is_empty() { vec![0.0; count] } else { values.to_vec() }
    };
    let (states, inputs) = (setup.states.len(), setup.inputs.len());
    for k in rows {
        let [of_states, of_inputs] = &multipliers.bounds[k];
        let near = |at: f64| (at - t[k]).abs() <= 1e-9 * (t[t.len() - 1] - t[0]);
        let path = multipliers.path.iter().find(|(at, _)| near(*at)).map_or(&[][..], |(_, path)| path);
        let mut row = vec![t[k], (k.saturating_sub(1) / inner) as f64];
        row.extend(x[k].iter().chain(&u[k]));
        row.extend(or_zeros(&multipliers.defects[k], states));
        row.extend(or_zeros(of_states, states));
        row.extend(or_zeros(of_inputs, inputs));
        row.extend(or_zeros(path, setup.path.len()));
        record.append(&row);
    }
    Ok(record)
}

/// The unknowns that `points` and `parameters` say.
///
/// # Errors
/// A column that is not there, or no rows.
pub(super) fn trajectory(
    setup: &Setup,
    inner: usize,
    points: &Record,
    parameters: &[f64],
) -> Result<Trajectory, Error> {
    let column = |name: &str| {
        let name = name.replace(' ', "_");
        let known = || points.columns().iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ");
        points.values(&name).ok_or_else(|| {
            Error::invalid(
                "plan.column",
                &name,
                format!("the columns of a plan of this scenario, not of {}", known()),
            )
        })
    };
    let all = |channels: &[wingbeat_ocp::plant::Channel]| {
        channels.iter().map(|channel| column(&channel.name)).collect::<Result<Vec<&[f64]>, Error>>()
    };
    let (t, states, inputs) = (column("t")?, all(&setup.states)?, all(&setup.inputs)?);
    if t.len() < 2 || parameters.len() != setup.parameters.len() {
        let given = format!("{} rows, {} parameters", t.len(), parameters.len());
        let allowed = format!("at least 2 rows and {} parameters", setup.parameters.len());
        return Err(Error::invalid("plan", given, allowed));
    }
    if !(t.len() - 1).is_multiple_of(inner) {
        let allowed = format!("1 row and {inner} for each interval");
        return Err(Error::invalid("plan", format!("{} rows", t.len()), allowed));
    }
    let finite = states.iter().chain(&inputs).all(|values| values.iter().all(|value| value.is_finite()));
    if !finite || !parameters.iter().all(|value| value.is_finite()) {
        return Err(Error::invalid(
            "plan",
            "a value that is not finite",
            "finite states, inputs and parameters",
        ));
    }
    if let Some(row) = t.windows(2).position(|pair| !(pair[1] > pair[0] && pair[1].is_finite())) {
        let allowed = "times that grow from row to row";
        return Err(Error::invalid("plan.t", format!("{} in row {}", t[row + 1], row + 2), allowed));
    }
    let rows = |columns: &[&[f64]]| -> Vec<Vec<f64>> {
        (0..t.len()).map(|row| columns.iter().map(|values| values[row]).collect()).collect()
    };
    Ok(Trajectory { t: t.to_vec(), x: rows(&states), u: rows(&inputs), p: parameters.to_vec() })
}
