//! Calibrations.

use crate::document::PyDocument;
use crate::table::{NamedColumn, columns};
use crate::{refused, wait};
use pyo3::prelude::*;
use wingbeat_calibrate::{CalibrationFile, SampleFiles, words};

/// What the runs tell, as text; the record of cycles, numbers and learned wrench as TOML, the report and the summary as JSON: none of it
/// of the information alone.
type FittedTexts<'py> = (String, Option<(Vec<NamedColumn<'py>>, (String, String), String, String)>);

/// Fits the numbers of a calibration file, or says what its runs tell of them.
#[pyfunction]
#[pyo3(signature = (document, information=false))]
pub fn calibrate<'py>(
    py: Python<'py>,
    document: &PyDocument,
    information: bool,
) -> PyResult<FittedTexts<'py>> {
    let calibration = CalibrationFile::new(document.0.clone()).map_err(refused)?;
    let files = SampleFiles::of(&calibration).map_err(refused)?;
    let done = wait::work(py, move |stop| {
        let prepared = calibration.prepared()?;
        let told = words::information(&prepared.information, &prepared.structure.parameters);
        if information {
            return Ok((told, None));
        }
        prepared.check()?;
        let found = prepared.fit(&mut (), &mut |_| stop.flow())?;
        let verdict = found.verdict(calibration.limits());
        let record = found.record()?;
        let numbers = words::numbers(&found, &files, "Python package", &verdict);
        let residual = words::residual(&found, &files, "Python package").unwrap_or_default();
        let summary = serde_json::to_string(&found.summary(&files, &verdict));
        Ok::<_, wingbeat_calibrate::CalibrationFailure>((
            told,
            Some((record, (numbers, residual), words::report(&found, &verdict), summary)),
        ))
    })?;
    let (told, found) = done.map_err(refused)?;
    let Some((record, files, report, summary)) = found else { return Ok((told, None)) };
    Ok((told, Some((columns(py, record), files, report, summary.map_err(refused)?))))
}
