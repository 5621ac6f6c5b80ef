//! Preset `paper` against the classical limits.

use wingbeat_figures::Figure;
use wingbeat_figures::chart::{Chart, ChartAxis, ChartSeries, Look, grid};

use super::{HALF, chart, model, over_x, percent, phase_deg, size};
use crate::Error;
use crate::aero_full::{ComparedPoint, ComparedPreset};
use crate::aero_paper::{
    elliptic_points, glauert_points, theodorsen_pitch_points, theodorsen_plunge_points, wagner_points,
};

/// Wagner's function, and the lift slopes of ellipses and rectangles.
pub fn lifting_line() -> Result<Figure, Error> {
    let wagner: Vec<ComparedPoint> = wagner_points()?.into_iter().filter(|point| point.x > 0.0).collect();
    let growth = vec![
        model(ComparedPreset::Paper, over_x(&wagner, "mid span", |point| point.value.0)),
        ChartSeries::reference("reference", over_x(&wagner, "mid span", |point| point.exact.0)),
    ];
    let (rectangles, ellipses) = (glauert_points()?, elliptic_points()?);
    let value = |points: &[ComparedPoint], name: &str| over_x(points, name, |point| point.value.0);
    let exact = |points: &[ComparedPoint], name: &str| over_x(points, name, |point| point.exact.0);
    let slopes = vec![
        model(ComparedPreset::Paper, value(&rectangles, "rectangle")),
        ChartSeries::new("preset paper, ellipse", value(&ellipses, "ellipse"), Look::Crosses, 1),
        ChartSeries::reference("reference", exact(&rectangles, "rectangle")),
        ChartSeries::reference("reference", exact(&ellipses, "ellipse")),
    ];
    let charts = vec![
        chart(
            "",
            ChartAxis::log("s = 2Ut/c"),
            ChartAxis::new("lift after a sudden start, over steady"),
            growth,
        ),
        chart("", ChartAxis::new("aspect ratio"), ChartAxis::new("steady lift slope CLα [1/rad]"), slopes),
    ];
    Ok(grid("lifting_line", charts, 2, HALF))
}

/// Amplitude, phase and error of lift of a section in plunge.
pub fn plunge() -> Result<Figure, Error> {
    let points = theodorsen_plunge_points(ComparedPreset::Paper)?;
    Ok(grid("theodorsen_plunge", response(&points, "plunge", "|CL/αe| [1/rad]"), 3, 1.2 * super::SMALL))
}

/// The same in pitch about three axes.
pub fn pitch() -> Result<Figure, Error> {
    let points = theodorsen_pitch_points(ComparedPreset::Paper)?;
    let axes = ["axis at 1/4 chord", "axis at 1/2 chord", "axis at 3/4 chord"];
    let charts = axes.iter().flat_map(|axis| response(&points, axis, "|CL/α| [1/rad]")).collect();
    Ok(grid("theodorsen_pitch", charts, 3, super::SMALL))
}

/// Amplitude, phase and error over the reduced frequency.
fn response(points: &[ComparedPoint], series: &str, amplitude: &str) -> Vec<Chart> {
    let x = || ChartAxis::new("k = ωc/2U").over(0.0, 1.0);
    let compared = |f: fn((f64, f64)) -> f64| {
        vec![
            model(ComparedPreset::Paper, over_x(points, series, |point| f(point.value))),
            ChartSeries::reference("Theodorsen", over_x(points, series, |point| f(point.exact))),
        ]
    };
    let error = model(ComparedPreset::Paper, over_x(points, series, percent));
    let error = chart(series, x(), ChartAxis::new("error [%]").over(0.0, 5.0), vec![error]);
    vec![
        chart(series, x(), ChartAxis::new(amplitude).over(3.0, 7.0), compared(size)),
        chart(series, x(), ChartAxis::new("phase [°]").over(-20.0, 80.0), compared(phase_deg)),
        Chart { passes: Some((0.0, 2.5)), ..error },
    ]
}
