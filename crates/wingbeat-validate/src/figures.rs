//! A figure per comparison, drawn from the numbers that make its rows.

mod flapping;
mod rest;
mod section;
mod small;

use wingbeat_figures::Figure;
use wingbeat_figures::chart::{Chart, ChartAxis, ChartSeries, Look};

use crate::Error;
use crate::aero_full::{ComparedPoint, ComparedPreset};

/// A figure and the cases whose numbers it shows.
#[derive(Debug)]
pub struct ComparisonFigure {
    /// Name of its files without extension.
    pub name: &'static str,
    /// Ids of the cases.
    pub cases: &'static [&'static str],
    /// Runs the models and draws.
    pub draw: fn() -> Result<Figure, Error>,
}

/// Every figure, in the order of the cases.
pub const PICTURES: &[ComparisonFigure] = &[
    ComparisonFigure { name: "slope", cases: &["aero.full.slope", "aero.paper.slope"], draw: small::slope },
    ComparisonFigure {
        name: "plunge",
        cases: &["aero.full.plunge", "aero.paper.plunge"],
        draw: small::plunge,
    },
    ComparisonFigure { name: "step", cases: &["aero.full.step", "aero.paper.step"], draw: small::step },
    ComparisonFigure {
        name: "other_wings",
        cases: &["aero.full.other_wings", "aero.paper.other_wings"],
        draw: small::other_wings,
    },
    ComparisonFigure { name: "span_loading", cases: &["aero.full.span_loading"], draw: small::span_loading },
    ComparisonFigure { name: "trefftz", cases: &["aero.full.trefftz"], draw: flapping::trefftz },
    ComparisonFigure { name: "oracle", cases: &["aero.full.oracle"], draw: flapping::oracle },
    ComparisonFigure {
        name: "added_mass_mean",
        cases: &["aero.full.added_mass_mean", "aero.paper.added_mass_mean"],
        draw: flapping::added_mass_mean,
    },
    ComparisonFigure {
        name: "scherer",
        cases: &["aero.scherer", "aero.paper.scherer"],
        draw: flapping::scherer,
    },
    ComparisonFigure {
        name: "uvlm_small_flap",
        cases: &["aero.uvlm_small_flap", "aero.paper.uvlm_small_flap"],
        draw: flapping::lattice,
    },
    ComparisonFigure {
        name: "lifting_line",
        cases: &["aero.wagner_limit", "aero.elliptic_steady", "aero.glauert_rectangular"],
        draw: section::lifting_line,
    },
    ComparisonFigure { name: "theodorsen_plunge", cases: &["aero.theodorsen_plunge"], draw: section::plunge },
    ComparisonFigure { name: "theodorsen_pitch", cases: &["aero.theodorsen_pitch"], draw: section::pitch },
    ComparisonFigure { name: "linkage", cases: &["linkage.cycle"], draw: rest::linkage },
    ComparisonFigure { name: "pinocchio", cases: &["body.pinocchio"], draw: rest::tree },
    ComparisonFigure { name: "replay", cases: &["trim.replay"], draw: rest::replay },
    ComparisonFigure {
        name: "orders",
        cases: &["math.rk4_order", "ocp.hermite_simpson_order"],
        draw: rest::orders,
    },
    ComparisonFigure { name: "pipeline", cases: &["rig.pipeline_recovers_truth"], draw: rest::pipeline },
];

/// Those of comparisons that take minutes.
pub const SLOW_PICTURES: &[ComparisonFigure] =
    &[ComparisonFigure { name: "planned", cases: &["calibrate.flight.planned"], draw: rest::planned }];

/// Height of a panel of small multiples, px.
const SMALL: f64 = 165.0;
/// Height of a panel that is one of two in a row, px.
const HALF: f64 = 250.0;
/// The presets, in the order of their colours.
const PRESETS: [ComparedPreset; 2] = [ComparedPreset::Full, ComparedPreset::Paper];

/// `points` as the preset is drawn everywhere: `full` a blue line, `paper` a broken vermilion one.
fn model(preset: ComparedPreset, points: Vec<(f64, f64)>) -> ChartSeries {
    let (look, index) = match preset {
        ComparedPreset::Full | ComparedPreset::Turned | ComparedPreset::Neither => (Look::Line, 0),
        ComparedPreset::Paper => (Look::Dashed, 1),
        ComparedPreset::FiveLags => (Look::Dotted, 2),
    };
    ChartSeries::new(format!("preset {}", preset.name()), points, look, index)
}

fn chart(title: impl Into<String>, x: ChartAxis, y: ChartAxis, series: Vec<ChartSeries>) -> Chart {
    Chart { title: title.into(), x, y, series, passes: None }
}

/// The points of the series called `name`.
fn of<'a>(points: &'a [ComparedPoint], name: &'a str) -> impl Iterator<Item = &'a ComparedPoint> {
    points.iter().filter(move |point| point.series == name)
}

/// `f` of every point of the series called `name`, over x.
fn over_x(points: &[ComparedPoint], name: &str, f: impl Fn(&ComparedPoint) -> f64) -> Vec<(f64, f64)> {
    of(points, name).map(|point| (point.x, f(point))).collect()
}

fn size(value: (f64, f64)) -> f64 {
    value.0.hypot(value.1)
}

fn phase_deg(value: (f64, f64)) -> f64 {
    value.1.atan2(value.0).to_degrees()
}

fn percent(point: &ComparedPoint) -> f64 {
    100.0 * point.error()
}
