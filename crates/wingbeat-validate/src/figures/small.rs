//! Small motions against the linear lifting surface.

use wingbeat_figures::Figure;
use wingbeat_figures::chart::{Chart, ChartAxis, ChartSeries, Look, grid};

use super::{HALF, PRESETS, SMALL, chart, model, over_x, percent, phase_deg, size};
use crate::Error;
use crate::aero_full::{
    ComparedPoint, ComparedPreset, other_points, plunge_points, slope_points, span_loadings, step_points,
};

const REFERENCE: &str = "lifting surface";
/// Aspect ratios of the small multiples.
const ASPECTS: [f64; 4] = [4.0, 6.0, 12.0, 20.0];

/// Points of both presets, in the order of [`PRESETS`].
fn both(
    points: fn(ComparedPreset) -> Result<Vec<ComparedPoint>, Error>,
) -> Result<[Vec<ComparedPoint>; 2], Error> {
    Ok([points(PRESETS[0])?, points(PRESETS[1])?])
}

/// The reference in circles above both presets, each `f` over x.
fn compared(
    points: &[Vec<ComparedPoint>; 2],
    series: &str,
    f: impl Fn((f64, f64)) -> f64 + Copy,
) -> Vec<ChartSeries> {
    let mut all: Vec<ChartSeries> = PRESETS
        .into_iter()
        .zip(points)
        .map(|(preset, points)| model(preset, over_x(points, series, |point| f(point.value))))
        .collect();
    all.push(ChartSeries::reference(REFERENCE, over_x(&points[0], series, |point| f(point.exact))));
    all
}

/// Errors of both presets in per cent; the limit shaded.
fn errors(points: &[Vec<ComparedPoint>; 2], series: &str, title: &str, x: ChartAxis, limit: f64) -> Chart {
    let lines = PRESETS
        .into_iter()
        .zip(points)
        .map(|(preset, points)| model(preset, over_x(points, series, percent)));
    let chart = chart(title, x, ChartAxis::new("error [%]"), lines.collect());
    Chart { passes: Some((0.0, limit)), ..chart }
}

/// Steady lift slope and its error over the aspect ratio.
pub fn slope() -> Result<Figure, Error> {
    let points = both(slope_points)?;
    let x = || ChartAxis::new("aspect ratio");
    let value = compared(&points, "rectangle", |value| value.0);
    let mut error = errors(&points, "rectangle", "", x(), 2.0);
    error.y = ChartAxis::new("error [%]; limit shaded").over(0.0, 16.0);
    let charts = vec![chart("rectangles", x(), ChartAxis::new("CLα [1/rad]"), value), error];
    Ok(grid("slope", charts, 2, HALF))
}

/// Amplitude, phase and error of lift per upwash angle over the reduced frequency.
pub fn plunge() -> Result<Figure, Error> {
    let points = both(plunge_points)?;
    let x = || ChartAxis::new("k = ωc/2U").over(0.0, 1.0);
    let names = ASPECTS.map(|aspect| format!("AR {aspect}"));
    let mut charts = Vec::new();
    for name in &names {
        let y = ChartAxis::new("|CL/αe| [1/rad]").over(2.0, 7.0);
        charts.push(chart(name.clone(), x(), y, compared(&points, name, size)));
    }
    for name in &names {
        let y = ChartAxis::new("phase [°]").over(-15.0, 60.0);
        charts.push(chart(name.clone(), x(), y, compared(&points, name, phase_deg)));
    }
    for name in &names {
        let error = errors(&points, name, name, x(), 2.0);
        charts.push(Chart { y: error.y.clone().over(0.0, 20.0), ..error });
    }
    Ok(grid("plunge", charts, 4, SMALL))
}

/// Lift and its error after a sudden start over the way travelled.
pub fn step() -> Result<Figure, Error> {
    let points = both(step_points)?;
    let x = || ChartAxis::log("s = 2Ut/c").over(0.9, 60.0);
    let names = ASPECTS.map(|aspect| format!("AR {aspect}"));
    let mut charts = Vec::new();
    for name in &names {
        let y = ChartAxis::new("CL/α [1/rad]").over(2.4, 5.8);
        charts.push(chart(name.clone(), x(), y, compared(&points, name, |value| value.0)));
    }
    for name in &names {
        let error = errors(&points, name, name, x(), 2.0);
        charts.push(Chart { y: error.y.clone().over(0.0, 12.0), ..error });
    }
    Ok(grid("step", charts, 4, SMALL))
}

/// The wings of the table and the limit of their error, per cent.
const WINGS: [(&str, &str, f64); 6] = [
    ("rect4", "rectangle, AR 4", 2.0),
    ("ell4", "ellipse, AR 4", 2.0),
    ("tap.4_AR6", "taper 0.4, AR 6", 2.0),
    ("swept30_AR6", "sweep 30°, AR 6", 2.0),
    ("elbow-60_rect6", "folded by 75°, AR 6", 2.0),
    ("aerobat_flat", "Aerobat, flat", 3.0),
];

/// Error of six wings over the reduced frequency, in plunge and pitch.
pub fn other_wings() -> Result<Figure, Error> {
    let points = both(other_points)?;
    let mut charts = Vec::new();
    for (wing, title, limit) in WINGS {
        let mut series = Vec::new();
        for (index, (preset, points)) in PRESETS.into_iter().zip(&points).enumerate() {
            let motions = ["pitch0", "pitch.25", "pitch.5", "pitch.75", "plunge"];
            for motion in motions {
                let line = over_x(points, &format!("{wing} {motion}"), percent);
                let look = if motion == "plunge" { Look::Line } else { Look::Dotted };
                let kind = if motion == "plunge" { "plunge" } else { "pitch about four axes" };
                series.push(ChartSeries::new(format!("{}, {kind}", preset.name()), line, look, index));
            }
        }
        let (x, y) =
            (ChartAxis::new("k = ωc/2U").over(0.0, 0.5), ChartAxis::log("error [%]").over(0.02, 50.0));
        charts.push(Chart { passes: Some((0.02, limit)), ..chart(title, x, y, series) });
    }
    Ok(grid("other_wings", charts, 3, 1.1 * SMALL))
}

/// Normal force along the half span in plunge.
pub fn span_loading() -> Result<Figure, Error> {
    let loadings = PRESETS.map(span_loadings);
    let [full, paper] = loadings;
    let loadings = [full?, paper?];
    let mut charts = Vec::new();
    for k in [0.1, 0.5] {
        for aspect in ASPECTS {
            let found = |index: usize| loadings[index].iter().find(|l| l.aspect == aspect && l.k == k);
            let mut series = Vec::new();
            for (index, preset) in PRESETS.into_iter().enumerate() {
                let Some(loading) = found(index) else { continue };
                let line = |force: &[(f64, f64)]| {
                    loading.places.iter().copied().zip(force.iter().map(|force| size(*force))).collect()
                };
                series.push(model(preset, line(&loading.value)));
                if preset == ComparedPreset::Paper {
                    series.push(ChartSeries::reference("linear lattice", line(&loading.exact)));
                }
            }
            let y = ChartAxis::new("cn/αe").over(0.0, 6.5);
            let title = format!("AR {aspect}, k {k}");
            charts.push(chart(title, ChartAxis::new("place over half span").over(0.0, 1.0), y, series));
        }
    }
    Ok(grid("span_loading", charts, 4, SMALL))
}
