//! Mechanics, orders of the integrators, rig.

use wingbeat_figures::Figure;
use wingbeat_figures::chart::{Chart, ChartAxis, ChartSeries, Look, grid};

use super::{HALF, SMALL, chart};
use crate::Error;
use crate::body::{crank_angles, tree_accelerations};
use crate::calibrate::planned::{Plans, plans};
use crate::math::error_of_rk4;
use crate::ocp::collocation_errors;
use crate::rig::processed_run;
use wingbeat::rig::cell::CHANNELS;

/// Every this many rows of the table are marked.
const MARKED: usize = 40;

/// Humerus and radius over the crank angle.
pub fn linkage() -> Result<Figure, Error> {
    let angles = crank_angles()?;
    let names = ["humerus", "radius"];
    let over_crank = |values: &[f64]| -> Vec<(f64, f64)> {
        angles.crank.iter().copied().zip(values.iter().copied()).collect()
    };
    let (mut lines, mut marks) = (Vec::new(), Vec::new());
    for (index, name) in names.into_iter().enumerate() {
        let (value, exact) = (&angles.value[index], &angles.exact[index]);
        lines.push(ChartSeries::new(name, over_crank(value), Look::Line, index));
        let marked = over_crank(exact).into_iter().step_by(MARKED).collect();
        marks.push(ChartSeries::reference("loop closure by Newton", marked));
    }
    lines.append(&mut marks);
    let chart = chart(
        "",
        ChartAxis::new("crank angle [°]").over(-90.0, 270.0),
        ChartAxis::new("angle of the wing [°]"),
        lines,
    );
    Ok(grid("linkage", vec![chart], 1, HALF))
}

/// The ten accelerations, and their relative errors.
pub fn tree() -> Result<Figure, Error> {
    let pairs = tree_accelerations()?;
    let number = |i: usize| (i + 1) as f64;
    let of = |f: &dyn Fn(&(f64, f64)) -> f64| -> Vec<(f64, f64)> {
        pairs.iter().enumerate().map(|(i, pair)| (number(i), f(pair))).collect()
    };
    let accelerations = vec![
        ChartSeries::reference("Pinocchio and MuJoCo", of(&|pair| pair.1.abs())),
        ChartSeries::new("wingbeat", of(&|pair| pair.0.abs()), Look::Crosses, 0),
    ];
    let error = |pair: &(f64, f64)| ((pair.0 - pair.1).abs() / pair.1.abs()).max(f64::EPSILON / 2.0);
    let errors = vec![ChartSeries::new("wingbeat", of(&error), Look::Crosses, 0)];
    let x = || ChartAxis::new("acceleration: base 1 to 6, joints 7 to 10").over(0.5, 10.5);
    let charts = vec![
        chart("", x(), ChartAxis::log("acceleration [m/s², rad/s²]"), accelerations),
        Chart {
            passes: Some((1e-17, 1e-10)),
            ..chart("", x(), ChartAxis::log("relative error; limit shaded").over(1e-17, 1e-8), errors)
        },
    ];
    Ok(grid("pinocchio", charts, 2, HALF))
}

/// Errors of Runge-Kutta and of Hermite-Simpson over the number of steps, beside the fourth order.
pub fn orders() -> Result<Figure, Error> {
    let steps = [25, 50, 100, 200, 400];
    let runge_kutta: Vec<(f64, f64)> = steps.map(|n| (n as f64, error_of_rk4(n))).into();
    let intervals = [4, 8, 16, 32];
    let errors = collocation_errors(&intervals)?;
    let collocation: Vec<(f64, f64)> = intervals.iter().map(|n| *n as f64).zip(errors).collect();
    let of = |title: &str, x: &str, points: Vec<(f64, f64)>| {
        let (n, error) = points[0];
        let fourth = points.iter().map(|(m, _)| (*m, error * (n / m).powi(4))).collect();
        let series = vec![
            ChartSeries { colour: "#9a9a9a".into(), ..ChartSeries::new("order 4", fourth, Look::Dashed, 0) },
            ChartSeries::new("wingbeat", points, Look::Circles, 0),
        ];
        chart(title, ChartAxis::log(x), ChartAxis::log("error at the end"), series)
    };
    let charts = vec![
        of("Runge-Kutta, x' = x cos t", "steps", runge_kutta),
        of("Hermite-Simpson, flapping body", "intervals", collocation),
    ];
    Ok(grid("orders", charts, 2, HALF))
}

/// Phase averages of a simulated run on the rig and of its noise-free wrench.
pub fn pipeline() -> Result<Figure, Error> {
    let processed = processed_run()?;
    let truth = processed.truth.as_ref().ok_or_else(|| Error::NoAnswer("no truth in the record".into()))?;
    let axes = ["forward", "left", "up", "roll", "pitch", "yaw"];
    let panel = |i: usize| {
        let (name, _) = CHANNELS[i];
        let unit = if i < 3 { "mN" } else { "N mm" };
        let line = |values: &[f64]| -> Vec<(f64, f64)> {
            let n = values.len() as f64;
            values.iter().enumerate().map(|(k, value)| (k as f64 / n, 1e3 * value)).collect()
        };
        let marked = processed.cycles[i].mean.len().div_ceil(36).max(1);
        let series = vec![
            ChartSeries::new("recovered by the pipeline", line(&processed.cycles[i].mean), Look::Line, 0),
            ChartSeries::reference("noise-free", line(&truth[i].mean).into_iter().step_by(marked).collect()),
        ];
        let x = ChartAxis::new("phase of the stroke").over(0.0, 1.0);
        chart("", x, ChartAxis::new(format!("{name}, {} [{unit}]", axes[i])), series)
    };
    Ok(grid("pipeline", (0..6).map(panel).collect(), 3, SMALL))
}

/// Lift and power of an orbit's motion, prescribed, over the cycle.
pub fn replay() -> Result<Figure, Error> {
    let cycles = crate::orbit::replayed()?;
    let looks = [(Look::Line, 0), (Look::Dashed, 1), (Look::Line, 3), (Look::Dotted, 2)];
    let panel = |label: &str, of: fn(&crate::orbit::InstantLoads) -> f64| {
        let line =
            |((name, cycle), (look, index)): (&(&str, Vec<crate::orbit::InstantLoads>), (Look, usize))| {
                let share = |k: usize| k as f64 / cycle.len() as f64;
                // The cycle closes.
                let points = (0..=cycle.len()).map(|k| (share(k), of(&cycle[k % cycle.len()])));
                ChartSeries::new(*name, points.collect(), look, index)
            };
        let x = ChartAxis::new("share of the cycle").over(0.0, 1.0);
        chart("cruise_20g", x, ChartAxis::new(label), cycles.iter().zip(looks).map(line).collect())
    };
    let charts = vec![
        panel("lift of the wings over the weight", |instant| instant.up),
        panel("power of the joints against the air [W/kg]", |instant| instant.power),
    ];
    Ok(grid("replay", charts, 1, HALF))
}

/// Where turns of the truth end, planned by other models.
pub fn planned() -> Result<Figure, Error> {
    let panel = |plans: &Plans| {
        let [own, fitted, before] = plans.ends();
        let series = vec![
            ChartSeries::new("draws +-20 %", before, Look::Crosses, 0),
            ChartSeries::new("as calibrated", fitted, Look::Circles, 1),
            ChartSeries::reference("planned by the truth", own),
        ];
        chart(plans.title(), ChartAxis::new("forward [m]"), ChartAxis::new("to the left [m]"), series)
    };
    Ok(grid("planned", plans()?.iter().map(panel).collect(), 2, HALF))
}
