//! The starts of a search of gaits.

use wingbeat::simulate::Record;

use crate::clouds::{PointCloud, clouds};
use crate::plot_frame::{FrameAxis, MarkShape};
use crate::scale::TickScale;
use crate::write::Figure;
use crate::{Error, needed, style};

/// Every start by the frequency and power of the gait it comes to, those that keep to the limits and those that do not.
///
/// Needs `frequency_hz`, `power_w_kg` and `kept` (1 or 0).
pub fn starts(record: &Record) -> Result<Figure, Error> {
    let (frequency, power) = (needed(record, "frequency_hz")?, needed(record, "power_w_kg")?);
    let kept = needed(record, "kept")?;
    if record.rows() == 0 {
        return Err(Error::Rows { rows: 0, needed: 1 });
    }
    let cloud = |wanted: bool, name: &str, index: usize| -> Option<PointCloud> {
        let rows = (0..record.rows()).filter(|&row| (kept[row] == 1.0) == wanted);
        let points: Vec<(f64, f64)> = rows.map(|row| (frequency[row], power[row])).collect();
        let name = format!("{name}: {} of {}", points.len(), record.rows());
        let colour = style::colour(index).into();
        (!points.is_empty()).then_some(PointCloud {
            name,
            points,
            shape: MarkShape::Disc,
            size: 4.0,
            colour,
            opacity: 0.75,
        })
    };
    let all = [cloud(true, "limits kept", 0), cloud(false, "limits missed", 1)];
    let all: Vec<PointCloud> = all.into_iter().flatten().collect();
    let scale = |values: &[f64]| {
        let (low, high) = style::span(values.iter().copied());
        TickScale::padded(low, high, 0.07)
    };
    let (across, up) = (scale(frequency), scale(power));
    let x = FrameAxis::of(across).labelled(across.label("frequency of the gait [Hz]"));
    let y = FrameAxis::of(up).labelled(up.label("power over the mass [W/kg]"));
    Ok(clouds("starts", &all, (x, y), 0.6, |_| ()))
}
