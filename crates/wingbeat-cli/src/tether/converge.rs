//! `wingbeat tether CASE --converge`.

use wingbeat::scenario::{Convergence, ConvergenceRun, QUANTITIES, TetherCase};
use wingbeat_io::shortest;

use super::tables::CaseTables;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::progress;

/// Runs the case with every combination of strips and steps, and other elements of its spar, on all cores.
pub fn converge(
    case: &TetherCase,
    tables: &CaseTables,
    interrupt: &Interrupt,
    quiet: bool,
) -> Result<Convergence, Error> {
    let count = case.levels()?.cells().len() as u64;
    let bar = progress::bar(Some(count), "converging {bar:30} {pos} of {len} runs", quiet);
    let table =
        case.converge(&|path| tables.read(path), &|| interrupt.flow(), |done| bar.set_position(done as u64))?;
    bar.finish_and_clear();
    interrupt.check()?;
    table.ok_or(Error::Interrupted)
}

/// The runs as CSV.
pub fn csv(table: &Convergence) -> String {
    let row = |run: &ConvergenceRun| {
        let values = run.values().map(shortest).join(",");
        let elements = run.spar_elements.map(|elements| format!("{elements},")).unwrap_or_default();
        format!("{},{},{elements}{values}\n", run.strips, run.steps_per_cycle)
    };
    let elements = table.levels.spar_elements.map_or("", |_| "spar_elements,");
    let header = format!("strips,steps_per_cycle,{elements}{}\n", QUANTITIES.join(","));
    std::iter::once(header).chain(table.cells.iter().map(row)).collect()
}

/// The runs, orders and verdict in words.
pub fn text(table: &Convergence) -> String {
    let elements = table.levels.spar_elements.is_some();
    let mut text = format!("\n{:>7}{:>8}", "strips", "steps");
    text += if elements { "  elements" } else { "" };
    QUANTITIES.iter().for_each(|name| text += &format!("{name:>15}"));
    text.push('\n');
    for run in &table.cells {
        text += &format!("{:>7}{:>8}", run.strips, run.steps_per_cycle);
        text += &run.spar_elements.map(|elements| format!("{elements:>10}")).unwrap_or_default();
        run.values().iter().for_each(|value| text += &format!("{value:>15.6}"));
        text.push('\n');
    }
    let order = |order: Option<f64>| order.map_or("-".into(), |order| format!("{order:.2}"));
    let mut row = |name: &str, cell: &dyn Fn(usize) -> String| {
        text += &format!("{name:<width$}", width = if elements { 25 } else { 15 });
        (0..QUANTITIES.len()).for_each(|k| text += &format!("{:>15}", cell(k)));
        text.push('\n');
    };
    row("order, strips", &|k| order(table.quantities[k].order_strips));
    row("order, steps", &|k| order(table.quantities[k].order_steps));
    row("spread [%]", &|k| format!("{:.2}", 100.0 * table.quantities[k].spread));
    text + &format!("\n{}: {}\n", table.status.replace('_', " "), table.verdict)
}
