//! Large motions and mean forces.

use wingbeat_figures::Figure;
use wingbeat_figures::chart::{Chart, ChartAxis, ChartSeries, Look, grid};

use super::{HALF, PRESETS, SMALL, chart, model};
use crate::Error;
use crate::aero_full::{
    ComparedPreset, ForceComparison, STATIC_DRAG, added_mass_lift, induced_over_trefftz, lattice_lift,
    oracle_series, scherer_points, scherer_thrust, small_flap_lift,
};

/// Points of a curve over a cycle.
const POINTS: usize = 48;

/// [`POINTS`] of the `values` at even phases from 0, closed at 1.
fn over_cycle(values: &[f64], scale: f64) -> Vec<(f64, f64)> {
    let at = |i: usize| (i as f64 / values.len() as f64, scale * values[i % values.len()]);
    (0..=values.len()).step_by(values.len().div_ceil(POINTS)).map(at).collect()
}

fn phase() -> ChartAxis {
    ChartAxis::new("phase of the cycle").over(0.0, 1.0)
}

/// Induced drag over Trefftz drag, by sweep and by fold.
pub fn trefftz() -> Result<Figure, Error> {
    let line = |folded: bool| -> Result<ChartSeries, Error> {
        let mut points = Vec::new();
        for step in 0..=15 {
            let angle = f64::from(step) * 5.0;
            if folded || angle <= 45.0 {
                points.push((angle, 100.0 * (induced_over_trefftz(folded, angle)? - 1.0)));
            }
        }
        Ok(model(ComparedPreset::Full, points))
    };
    let y = || ChartAxis::new("error of drag [%]; limit shaded").over(-0.7, 0.7);
    let of = |title: &str, x: &str, series: ChartSeries| Chart {
        passes: Some((-0.5, 0.5)),
        ..chart(title, ChartAxis::new(x), y(), vec![series])
    };
    let charts =
        vec![of("swept, AR 6", "sweep [°]", line(false)?), of("folded, AR 6", "fold [°]", line(true)?)];
    Ok(grid("trefftz", charts, 2, HALF))
}

/// Forces of F2 and E1 over the cycle beside the script's.
pub fn oracle() -> Result<Figure, Error> {
    let (full, paper) = (oracle_series(ComparedPreset::Turned)?, oracle_series(ComparedPreset::Paper)?);
    let mut charts = Vec::new();
    for (part, label) in [("Fx", "Fx, aft [mN]"), ("Fz", "Fz, up [mN]"), ("Faz", "Fz, added mass [mN]")] {
        for (case, title) in [("F2", "F2: flap ±35°"), ("E1", "E1: flap ±30°, fold 50°")] {
            let found = |all: &[ForceComparison], of: fn(&ForceComparison) -> &Vec<f64>| {
                let found = all.iter().find(|c| c.case == case && c.part == part);
                found.map_or_else(Vec::new, |c| over_cycle(of(c), 1e3))
            };
            let reference = found(&full, |c| &c.exact).into_iter().step_by(2).collect();
            let series = vec![
                model(ComparedPreset::Full, found(&full, |c| &c.value)),
                model(ComparedPreset::Paper, found(&paper, |c| &c.value)),
                ChartSeries::reference("research script", reference),
            ];
            charts.push(chart(title, phase(), ChartAxis::new(label), series));
        }
    }
    Ok(grid("oracle", charts, 2, 1.05 * SMALL))
}

/// Added-mass lift over the cycle with its mean.
pub fn added_mass_mean() -> Result<Figure, Error> {
    let mut charts: Vec<Chart> = ["F2: flap ±35°", "E1: flap ±30°, fold 50°"]
        .map(|title| chart(title, phase(), ChartAxis::new("added-mass lift [mN]"), Vec::new()))
        .into();
    for preset in PRESETS {
        for (chart, (_, lift)) in charts.iter_mut().zip(added_mass_lift(preset)?) {
            chart.series.push(model(preset, over_cycle(&lift, 1e3)));
            let mean = 1e3 * lift.iter().sum::<f64>() / lift.len() as f64;
            let line = model(preset, vec![(0.0, mean), (1.0, mean)]);
            chart.series.push(ChartSeries {
                look: Look::Dotted,
                name: format!("{}, mean", preset.name()),
                ..line
            });
        }
    }
    Ok(grid("added_mass_mean", charts, 2, HALF))
}

/// Thrust coefficient over the phase between pitch and heave.
pub fn scherer() -> Result<Figure, Error> {
    let measured = scherer_points(ComparedPreset::Full)?;
    let mut charts = Vec::new();
    for theta in [15.0, 25.0] {
        let mut series = Vec::new();
        for preset in PRESETS {
            let mut line = Vec::new();
            for psi in (0..=24).map(|step| f64::from(step) * 5.0) {
                line.push((psi, scherer_thrust(preset, theta, psi)? - STATIC_DRAG));
            }
            series.push(model(preset, line));
        }
        let points = measured.iter().filter(|point| point.theta_deg == theta);
        series.push(ChartSeries {
            bars: points.clone().map(|point| point.bars).collect(),
            ..ChartSeries::reference(
                "measured",
                points.map(|point| (point.psi_deg, point.measured)).collect(),
            )
        });
        let title = format!("pitch amplitude {theta}°");
        let (x, y) =
            (ChartAxis::new("pitch before heave [°]").over(0.0, 120.0), ChartAxis::new("thrust coefficient"));
        charts.push(chart(title, x, y.over(-0.1, 0.4), series));
    }
    Ok(grid("scherer", charts, 2, HALF))
}

/// Lift of F1 over the cycle.
pub fn lattice() -> Result<Figure, Error> {
    let mut series = Vec::new();
    for preset in PRESETS {
        series.push(model(preset, over_cycle(&small_flap_lift(preset)?, 1e3)));
    }
    series.push(ChartSeries::reference("free-wake lattice", over_cycle(&lattice_lift()?, 1e3)));
    let chart = chart("F1: flap ±5°, AR 5, incidence 5°", phase(), ChartAxis::new("lift [mN]"), series);
    Ok(grid("uvlm_small_flap", vec![chart], 1, HALF))
}
