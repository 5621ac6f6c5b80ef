//! How much the numbers of a case depend on its strips, steps and elements of its spar.

use super::steps::STEP_CHANGE;
use super::{ReadTable, TetherCase};
use crate::{ConfigError, Document};
use serde::Serialize;
use std::ops::ControlFlow;
use wingbeat_aero::{MAX_STRIPS, Preset};
use wingbeat_flight::simulate::Ending;
use wingbeat_flight::tether::{CycleMean, TetherRun};
use wingbeat_math::Error;
use wingbeat_math::parallel;

/// Levels of strips and of steps.
const LEVELS: usize = 3;
/// Least strips, or nodes, and steps per cycle of a level.
const LEAST: (usize, usize) = (3, 8);
/// Share of the largest force or power below which a mean counts as that share. *Choice.*
const FLOOR: f64 = 0.1;
/// Change over the largest below which two values are the same but for rounding. *Choice.*
const ROUNDING: f64 = 1e-9;

/// Strips and steps per cycle of the table, coarse to fine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Levels {
    /// Strips, or nodes of preset `paper`.
    pub strips: [usize; LEVELS],
    /// Steps per cycle.
    pub steps_per_cycle: [usize; LEVELS],
    /// Elements of its spar, where it has one: those of the case, and those of one more run with most strips and steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spar_elements: Option<[usize; 2]>,
}

/// Strips, steps per cycle and, where there is a spar, its elements, of a run.
pub type ConvergenceCell = (usize, usize, Option<usize>);

/// One run of the table; not-a-number where it failed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ConvergenceRun {
    /// Strips, or nodes of preset `paper`.
    pub strips: usize,
    /// Steps per cycle.
    pub steps_per_cycle: usize,
    /// Elements of its spar, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spar_elements: Option<usize>,
    /// Mean lift over the last cycle, N.
    pub mean_lift_n: f64,
    /// Mean thrust, N.
    pub mean_thrust_n: f64,
    /// Largest lift, N.
    pub peak_lift_n: f64,
    /// Mean power that the motion gives to the air, W.
    pub mean_power_w: f64,
    /// Largest lift or drag (N) and power (W).
    #[serde(skip)]
    scales: [f64; 2],
}

/// Power over force and speed below which it is rounding: that of a wing at rest. *Choice.*
const NO_POWER: f64 = 1e-6;

/// Names of the quantities of a cell.
pub const QUANTITIES: [&str; 4] = ["mean_lift_n", "mean_thrust_n", "peak_lift_n", "mean_power_w"];

impl ConvergenceRun {
    /// Of a run at the speed of reference `speed_m_s` (m/s); not-a-number when it did not end.
    pub fn of(
        (strips, steps_per_cycle, spar_elements): ConvergenceCell,
        run: &TetherRun,
        speed_m_s: f64,
    ) -> Self {
        let row = |name: &str| {
            run.means.iter().find(|row| row.name == name && matches!(run.ending, Ending::Complete))
        };
        let mean = |name: &str| row(name).map_or(f64::NAN, |row| row.mean);
        let largest = |name: &str| row(name).map_or(0.0, CycleMean::largest);
        let force = largest("force_wind_lift").max(largest("thrust"));
        Self {
            strips,
            steps_per_cycle,
            spar_elements,
            mean_lift_n: mean("force_wind_lift"),
            mean_thrust_n: mean("thrust"),
            peak_lift_n: row("force_wind_lift").map_or(f64::NAN, |row| row.high),
            mean_power_w: mean("power"),
            scales: [force, largest("power").max(NO_POWER * force * speed_m_s)],
        }
    }

    /// The quantities, by [`QUANTITIES`], in the units of these.
    pub fn values(&self) -> [f64; QUANTITIES.len()] {
        [self.mean_lift_n, self.mean_thrust_n, self.peak_lift_n, self.mean_power_w]
    }
}

/// How one quantity converges.
#[derive(Clone, Debug, Serialize)]
pub struct QuantitySpread {
    /// Its name, with the unit at its end.
    pub quantity: &'static str,
    /// Its value with most strips and steps, in the unit of the quantity.
    pub finest: f64,
    /// Observed order (dimensionless) in the strips, with most steps; none where the three values do not approach one.
    pub order_strips: Option<f64>,
    /// Observed order (dimensionless) in the steps, with most strips.
    pub order_steps: Option<f64>,
    /// Largest less smallest with the two finer levels of both and the other elements of a spar, over the finest value, or over a tenth of the largest
    /// force or power where that is more.
    pub spread: f64,
}

/// The table and what it says.
#[derive(Clone, Debug, Serialize)]
pub struct Convergence {
    /// `converged` or `not_converged`.
    pub status: &'static str,
    /// Why.
    pub verdict: String,
    /// Largest relative spread of all quantities.
    pub spread: f64,
    /// Strips and steps.
    #[serde(flatten)]
    pub levels: Levels,
    /// Orders and spread by quantity.
    pub quantities: Vec<QuantitySpread>,
    /// The runs, strips slowest; last that with other elements of a spar.
    pub cells: Vec<ConvergenceRun>,
}

impl TetherCase {
    /// Half, once and twice the case's strips and steps; a quarter, half and once where twice is not allowed. Of a spar's elements once and
    /// twice.
    ///
    /// # Errors
    /// Fewer strips or steps than can be halved.
    pub fn levels(&self) -> Result<Levels, ConfigError> {
        let (key, strips) = self.strips();
        let steps = self.spec.time.steps_per_cycle;
        for (key, given, least) in [(key, strips, LEAST.0), ("time.steps_per_cycle", steps, LEAST.1)] {
            if given < 2 * least {
                let allowed = format!("{} or more where convergence is asked for", 2 * least);
                return Err(self.document.explain(&Error::invalid(key, given, allowed)));
            }
        }
        let finer = self.tether.stepped(2 * steps).check().is_ok();
        Ok(Levels {
            strips: ladder(strips, 2 * strips <= MAX_STRIPS, LEAST.0),
            steps_per_cycle: ladder(steps, finer, LEAST.1),
            spar_elements: self.spec.spar.as_ref().map(|spar| [spar.elements, 2 * spar.elements]),
        })
    }

    /// The levels with half a spar's elements where twice is not allowed, and without where half is none.
    fn with_elements(&self, levels: Levels, read: ReadTable) -> Levels {
        let finest = (levels.strips[LEVELS - 1], levels.steps_per_cycle[LEVELS - 1]);
        let allowed = |elements: usize| self.refined((finest.0, finest.1, Some(elements)), read).is_ok();
        let other = |own: usize| [2 * own, own / 2].into_iter().find(|other| *other > 0 && allowed(*other));
        let spar_elements = levels.spar_elements.and_then(|[own, _]| Some([own, other(own)?]));
        Levels { spar_elements, ..levels }
    }

    /// The key of the number of strips, or of nodes, and what it is.
    fn strips(&self) -> (&'static str, usize) {
        let aero = &self.spec.aero;
        match aero.preset {
            Preset::Full => ("aero.full.strips", aero.full.strips),
            Preset::Paper | Preset::AsPrinted => ("aero.paper.nodes", aero.paper.nodes),
        }
    }

    /// Runs the case with every combination of strips and steps, and with other elements of its spar, on all cores; `done` is told of each run. `watch` may
    /// end the work: then there is no table.
    ///
    /// # Errors
    /// Those of [`levels`](Self::levels) and [`refined`](Self::refined).
    pub fn converge(
        &self,
        read: ReadTable,
        watch: &(dyn Fn() -> ControlFlow<()> + Sync),
        mut done: impl FnMut(usize),
    ) -> Result<Option<Convergence>, ConfigError> {
        let levels = self.with_elements(self.levels()?, read);
        let refined = |cell| Ok((cell, self.refined(cell, read)?));
        let cells = levels.cells().into_iter().map(refined).collect::<Result<Vec<_>, ConfigError>>()?;
        let mut runs = vec![None; cells.len()];
        // The longest first, so that no core waits for the last one.
        let order: Vec<usize> = (0..cells.len()).rev().collect();
        let mut count = 0;
        parallel::each(
            &order,
            |_, &cell| {
                let (of, case) = &cells[cell];
                let run = case.tether.run(|_| watch());
                ConvergenceRun::of(*of, &run, case.tether.reference.speed_m_s)
            },
            |index, run| {
                runs[order[index]] = Some(run);
                count += 1;
                done(count);
                watch()
            },
        );
        let runs: Vec<ConvergenceRun> = runs.into_iter().flatten().collect();
        let whole = watch().is_continue() && runs.len() == cells.len();
        let (key, strips) = self.strips();
        let own = [
            (key, strips, levels.strips),
            ("time.steps_per_cycle", self.spec.time.steps_per_cycle, levels.steps_per_cycle),
        ];
        let finest = own.into_iter().filter(|(_, own, levels)| levels[LEVELS - 1] == *own);
        Ok(whole.then(|| {
            let mut table = Convergence::new(levels, runs);
            for (key, own, _) in finest {
                table.verdict +=
                    &format!("; {key} = {own} of the case is the finest, as twice that is not allowed");
            }
            table
        }))
    }

    /// The same case with other strips, steps per cycle and, where they are given, elements of its spar.
    ///
    /// # Errors
    /// What the case refuses with them.
    pub fn refined(
        &self,
        (strips, steps, elements): ConvergenceCell,
        read: ReadTable,
    ) -> Result<Self, ConfigError> {
        let (key, _) = self.strips();
        let document = self.document.clone().set(format!("{key}={strips}"));
        let document = document.set(format!("time.steps_per_cycle={steps}"));
        let set = |document: Document, elements| document.set(format!("spar.elements={elements}"));
        Self::new(elements.into_iter().fold(document, set), read)
    }
}

/// Three levels about `own`, the last of them twice it where `doubled`.
pub fn ladder(own: usize, doubled: bool, least: usize) -> [usize; LEVELS] {
    let fine = if doubled { 2 * own } else { own };
    let coarse = (fine / 4).max(least);
    let middle = (fine / 2).max(coarse + 1);
    [coarse, middle, fine.max(middle + 1)]
}

impl Levels {
    /// What every run has, strips slowest; last that with other elements of a spar.
    pub fn cells(&self) -> Vec<ConvergenceCell> {
        let own = self.spar_elements.map(|[own, _]| own);
        let of = |strips: usize| self.steps_per_cycle.map(|steps| (strips, steps, own));
        let finest = (self.strips[LEVELS - 1], self.steps_per_cycle[LEVELS - 1]);
        let other = self.spar_elements.map(|[_, other]| (finest.0, finest.1, Some(other)));
        self.strips.into_iter().flat_map(of).chain(other).collect()
    }
}

impl Convergence {
    /// What the runs of all cells say, in the order of [`Levels::cells`].
    pub fn new(levels: Levels, cells: Vec<ConvergenceRun>) -> Self {
        let value = |strips: usize, steps: usize, k: usize| cells[strips * LEVELS + steps].values()[k];
        let fine = LEVELS - 1;
        let of = |k: usize| {
            let scale = cells[fine * LEVELS + fine].scales[usize::from(k == QUANTITIES.len() - 1)];
            let by_strips = std::array::from_fn(|i| value(i, fine, k));
            let by_steps = std::array::from_fn(|i| value(fine, i, k));
            QuantitySpread {
                quantity: QUANTITIES[k],
                finest: value(fine, fine, k),
                order_strips: observed_order(levels.strips, by_strips, scale),
                order_steps: observed_order(levels.steps_per_cycle, by_steps, scale),
                spread: spread(
                    [(fine, fine), (fine - 1, fine), (fine, fine - 1), (fine - 1, fine - 1)]
                        .map(|(strips, steps)| value(strips, steps, k))
                        .into_iter()
                        .chain(cells.get(LEVELS * LEVELS).map(|other| other.values()[k])),
                    scale,
                ),
            }
        };
        let quantities: Vec<QuantitySpread> = (0..QUANTITIES.len()).map(of).collect();
        let worst = quantities.iter().max_by(|a, b| a.spread.total_cmp(&b.spread));
        let (spread, name) = worst.map_or((f64::NAN, ""), |worst| (worst.spread, worst.quantity));
        let converged = spread <= STEP_CHANGE;
        let ([_, few, many], [_, long, short]) = (levels.strips, levels.steps_per_cycle);
        let grid = match levels.spar_elements {
            None => format!("{few} to {many} strips and {long} to {short} steps per cycle"),
            Some([own, other]) => format!(
                "{few} to {many} strips, {long} to {short} steps per cycle and {} to {} elements of the spar",
                own.min(other),
                own.max(other)
            ),
        };
        let verdict = format!(
            "{grid} spread by {:.2} % at most ({name}); {} is {:.0} %",
            100.0 * spread,
            if converged { "allowed" } else { "the limit" },
            100.0 * STEP_CHANGE
        );
        let status = if converged { "converged" } else { "not_converged" };
        Self { status, verdict, spread, levels, quantities, cells }
    }
}

/// Range of the values over the first, or over a share of `scale`; infinite where a run failed.
fn spread(values: impl Iterator<Item = f64>, scale: f64) -> f64 {
    let values: Vec<f64> = values.collect();
    if values.iter().any(|value| !value.is_finite()) {
        return f64::INFINITY;
    }
    let (low, high) = values.iter().fold((values[0], values[0]), |(l, h), v| (l.min(*v), h.max(*v)));
    let size = values[0].abs().max(FLOOR * scale);
    if size > 0.0 { (high - low) / size } else { 0.0 }
}

/// The order p, dimensionless, with which values at `counts` approach one: f = f0 + C n^-p through all three.
///
/// Equation: tether.observed_order
/// `(f1 - f2)/(f2 - f3) = (n1^-p - n2^-p)/(n2^-p - n3^-p)`
/// Source: Roache 1998, Verification and Validation, ch. 5.
/// Test: `known_orders_are_observed`.
pub fn observed_order(counts: [usize; LEVELS], values: [f64; LEVELS], scale: f64) -> Option<f64> {
    const SOUGHT: (f64, f64) = (0.1, 12.0);
    let [first, second] = [values[0] - values[1], values[1] - values[2]];
    let told = second.abs() > ROUNDING * scale && first.is_finite() && second.is_finite();
    let ratio = first / second;
    let [a, b, c] = counts.map(|count| count as f64);
    let of = |p: f64| (a.powf(-p) - b.powf(-p)) / (b.powf(-p) - c.powf(-p));
    let (mut low, mut high) = SOUGHT;
    if !(told && ratio >= of(low) && ratio <= of(high)) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if of(middle) < ratio { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}
