//! How a search came to its best candidate.

use wingbeat::simulate::Record;

use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Cost below which a candidate counts as free of misses, for a logarithm. *Choice.*
const LEAST: f64 = 1e-4;

/// The cost of every candidate and the least so far, by the number of the candidate, in powers of ten.
///
/// Needs `run` and `cost`.
pub fn convergence_of_search(record: &Record) -> Result<Figure, Error> {
    let (run, cost) = (needed(record, "run")?, needed(record, "cost")?);
    if run.is_empty() {
        return Err(Error::Rows { rows: 0, needed: 1 });
    }
    let power = |cost: f64| cost.max(LEAST).log10();
    let mut least = f64::INFINITY;
    let best = cost.iter().map(|cost| {
        least = least.min(*cost);
        power(least)
    });
    let best = PanelCurve { weight: style::BROAD, ..PanelCurve::new("least so far", run, best.collect(), 1) }
        .whole();
    let each = PanelCurve::new("candidate", run, cost.iter().map(|cost| power(*cost)).collect(), 0);
    let title = format!("cost, power of ten; {LEAST} and less is drawn as {LEAST}");
    let panel = FigurePanel { levels: Vec::new(), ..FigurePanel::new(title, vec![each, best]) };
    Ok(Figure::new("search", stacked(vec![panel], "candidate", 1.6 * style::PANEL)))
}
