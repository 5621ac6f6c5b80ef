//! A path and how it was followed.

use wingbeat::math::DEGREES;
use wingbeat::simulate::Record;

use crate::chart::{Chart, ChartAxis, ChartSeries, Look, grid};
use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, needed, style};

/// Least and most of the height of the map, px.
const HEIGHT: (f64, f64) = (180.0, 760.0);
/// Room of a map's panel beside its axes, px: to the sides, and above and below.
const BESIDE: (f64, f64) = (74.0, 50.0);
/// Most points of a line.
const POINTS: usize = 1500;

/// The ground from above, one scale along both axes: the path where it was followed, and where the robot was.
///
/// Needs `p_WB_x`, `p_WB_y`, `path_nearest_x`, `path_nearest_y`.
pub fn ground(record: &Record) -> Result<Figure, Error> {
    let line = |prefix: &str| -> Result<Vec<(f64, f64)>, Error> {
        let (x, y) = (needed(record, &format!("{prefix}_x"))?, needed(record, &format!("{prefix}_y"))?);
        Ok(x.iter().copied().zip(y.iter().copied()).step_by(x.len().div_ceil(POINTS).max(1)).collect())
    };
    let (path, track) = (line("path_nearest")?, line("p_WB")?);
    let span = |of: fn(&(f64, f64)) -> f64| {
        let all = path.iter().chain(&track).map(of);
        let (low, high) =
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let margin = 0.05 * (high - low).max(1.0);
        (low - margin, high + margin)
    };
    let (across, up) = (span(|p| p.0), span(|p| p.1));
    let wide = style::WIDTH - BESIDE.0;
    let height = (wide * (up.1 - up.0) / (across.1 - across.0) + BESIDE.1).clamp(HEIGHT.0, HEIGHT.1);
    // Where the height is bounded the other axis gets the room that is left over.
    let scale = ((height - BESIDE.1) / (up.1 - up.0)).min(wide / (across.1 - across.0));
    let around = |(low, high): (f64, f64), room: f64| {
        let (middle, half) = (0.5 * (low + high), 0.5 * room / scale);
        (middle - half, middle + half)
    };
    let (across, up) = (around(across, wide), around(up, height - BESIDE.1));
    let chart = Chart {
        title: String::new(),
        x: ChartAxis::new("x [m]").over(across.0, across.1),
        y: ChartAxis::new("y [m], to the left").over(up.0, up.1),
        series: vec![
            ChartSeries { colour: style::INK.into(), ..ChartSeries::new("path", path, Look::Dashed, 0) },
            ChartSeries::new("flown", track, Look::Line, 0),
        ],
        passes: None,
    };
    Ok(grid("ground", vec![chart], 1, height))
}

/// Distances across and along the path, height less the path's, bank asked and roll over time.
///
/// Needs `t`, `roll`, `path_cross`, `path_along`, `path_bank`, `orbit_height_error`.
pub fn tracking(record: &Record) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    let scaled = |name: &str, factor: f64| -> Result<Vec<f64>, Error> {
        Ok(needed(record, name)?.iter().map(|value| factor * value).collect())
    };
    let one = |title: &str, name: &str| -> Result<FigurePanel, Error> {
        Ok(FigurePanel::new(title, vec![PanelCurve::new("", t, scaled(name, 1.0)?, 0).whole()]))
    };
    let roll = PanelCurve::new("roll", t, scaled("roll", DEGREES)?, 0).whole();
    let asked = PanelCurve::reference("asked", t, scaled("path_bank", DEGREES)?);
    let panels = vec![
        one("across the path, left + [m]", "path_cross")?,
        one("along the path, ahead + [m]", "path_along")?,
        one("height less the path's [m]", "orbit_height_error")?,
        FigurePanel::new("bank [°]", vec![roll, asked]),
    ];
    Ok(Figure::new("tracking", stacked(panels, "time [s]", style::PANEL)))
}
