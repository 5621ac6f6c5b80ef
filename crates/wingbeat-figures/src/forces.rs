//! The forces by source over the last stroke.

use wingbeat::aero::LoadSource;
use wingbeat::simulate::Record;

use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, cycle, needed, style};

const AXES: [(&str, &str); 3] =
    [("x", "along the body, forward [N]"), ("y", "to its left [N]"), ("z", "to its top [N]")];

/// Every `force_<source>_x`, `_y`, `_z` and the thrust of thrusters (body frame), which all sum to zero, and the sum of those of the air
/// over the last whole stroke; over the whole record when there is none.
pub fn forces(record: &Record) -> Result<Figure, Error> {
    forces_since(record, None)
}

/// As [`forces`], over all rows from the time `start`, s, on where there is one: those of a plan that a flight precedes.
///
/// # Errors
/// As [`forces`].
pub fn forces_since(record: &Record, start: Option<f64>) -> Result<Figure, Error> {
    let (panels, x_label) = panels(record, start)?;
    Ok(Figure::new("forces", stacked(panels, &x_label, style::PANEL)))
}

/// Name of a curve, and its values.
type NamedCurve = (String, Vec<f64>);

/// Name and values (N) of every curve that it draws, along each axis of the body.
///
/// # Errors
/// As [`forces`].
#[doc(hidden)]
pub fn drawn_forces(record: &Record) -> Result<[Vec<NamedCurve>; 3], Error> {
    let of = |panel: FigurePanel| panel.curves.into_iter().map(|curve| (curve.name, curve.y)).collect();
    let mut along = panels(record, None)?.0.into_iter().map(of);
    Ok([(); 3].map(|()| along.next().unwrap_or_default()))
}

/// Its panels, and what lies along them.
fn panels(record: &Record, since: Option<f64>) -> Result<(Vec<FigurePanel>, String), Error> {
    let t = needed(record, "t")?;
    let sources = sources(record);
    if sources.is_empty() {
        return Err(Error::Column("force_<source>_x".into()));
    }
    // By the phase of the gait, as loads and orbits are drawn; a record without one by its joints.
    let turning = if since.is_none() { cycle::last(record) } else { None };
    let phased = if turning.is_some() { cycle::phased(record) } else { None };
    let whole = phased.clone().map(|phased| phased.0).or(turning);
    let first = since.map_or(0, |start| t.partition_point(|now| *now < start - 1e-9));
    let rows = whole.clone().unwrap_or(first..t.len());
    if rows.len() < 2 {
        return Err(Error::Rows { rows: rows.len(), needed: 2 });
    }
    let start = if since.is_some() { 0.0 } else { t[rows.start] };
    let period = if whole.is_some() { t[rows.end - 1] - start } else { 1.0 };
    let x: Vec<f64> = match &phased {
        Some((_, cycles)) => cycles.clone(),
        None => t[rows.clone()].iter().map(|t| (t - start) / period).collect(),
    };
    let mut panels = Vec::new();
    for (axis, label) in AXES {
        let mut sum = vec![0.0; rows.len()];
        let mut curves = Vec::new();
        for (index, source) in sources.iter().enumerate() {
            let y = &needed(record, &format!("force_{source}_{axis}"))?[rows.clone()];
            if LoadSource::ALL.iter().any(|known| known.name() == *source && known.is_of_air()) {
                sum.iter_mut().zip(y).for_each(|(sum, y)| *sum += y);
            }
            curves.push(PanelCurve::new(spoken(source), &x, y.to_vec(), index));
        }
        if let Ok(thrust) = needed(record, &format!("thrust_{axis}")) {
            curves.push(PanelCurve::new("thrusters", &x, thrust[rows.clone()].to_vec(), sources.len()));
        }
        curves.push(PanelCurve::total("air, total", &x, sum));
        panels.push(FigurePanel::new(label, curves));
    }
    let x_label = if phased.is_some() {
        format!("phase [cycles], last whole cycle, from {start:.3} s to {:.3} s", start + period)
    } else if whole.is_some() {
        format!("share of the last whole cycle, from {start:.2} s on and {period:.3} s long")
    } else {
        "time [s]".into()
    };
    Ok((panels, x_label))
}

/// A source as the legend names it: the profile drag is that of attached flow, `cd0`, and of separated flow, `cd90`.
fn spoken(source: &str) -> String {
    match source {
        _ if source == LoadSource::ProfileDrag.name() => "profile (cd0, cd90)".into(),
        _ => source.replace('_', " "),
    }
}

/// Names of the sources, in the order of the record.
fn sources(record: &Record) -> Vec<&str> {
    let names = record.columns().iter().map(|column| column.name.as_str());
    names.filter_map(|name| name.strip_prefix("force_")?.strip_suffix("_x")).collect()
}
