//! Wings in prescribed motion.

use crate::document::Document;
use crate::table::{Named, columns};
use crate::{refused, wait};
use pyo3::prelude::*;
use std::path::Path;
use wingbeat::scenario::TetherCase;
use wingbeat::simulate::Record;

/// Loads, strips and summary as JSON.
type Moved<'py> = (Vec<Named<'py>>, Vec<Named<'py>>, String);

/// The table in a file; the text says what is wrong with it.
pub fn read(path: &Path) -> Result<Record, String> {
    wingbeat_io::read_csv(path).map_err(|error| error.to_string())
}

/// Moves the wing of a case, and again with other steps, to say how much these matter.
#[pyfunction]
pub fn tether<'py>(py: Python<'py>, document: &Document) -> PyResult<Moved<'py>> {
    let case = TetherCase::new(document.0.clone(), &read).map_err(refused)?;
    let (run, summary) = wait::work(py, move |stop| {
        let run = case.tether.run(|_| stop.flow());
        let again =
            case.step_change(&run, |other| Ok::<_, std::convert::Infallible>(other.run(|_| stop.flow())));
        let step_change = match again {
            Ok(step_change) => step_change,
            Err(never) => match never {},
        };
        let summary = case.summary(&run, step_change);
        (run, summary)
    })?;
    let summary = serde_json::to_string(&summary).map_err(refused)?;
    Ok((columns(py, run.loads), columns(py, run.strips), summary))
}
