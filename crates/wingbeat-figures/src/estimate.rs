//! The true flight, what an estimator took it for, and how sure it was.

use wingbeat::math::DEGREES;
use wingbeat::simulate::{Record, is_at};

use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::write::Figure;
use crate::{Error, needed, style};

/// What is estimated, the title of its panel, the factor of its unit.
const PANELS: [(&str, &str, f64); 6] = [
    ("height", "height error [mm]", 1e3),
    ("roll", "roll error [°]", DEGREES),
    ("pitch", "pitch error [°]", DEGREES),
    ("forward", "forward speed error [m/s]", 1.0),
    ("leftward", "sideways speed error [m/s]", 1.0),
    ("upward", "climb error [m/s]", 1.0),
];

/// Error of the estimated height, attitude and velocity at the updates, within three standard deviations of the filter's
/// own, shaded; the true height and roll above them.
///
/// Needs the columns `estimate_*` of a flight with an estimator and those of the true state.
pub fn estimate(record: &Record) -> Result<Figure, Error> {
    let (t, of) = (needed(record, "t")?, needed(record, "estimate_t")?);
    let rows: Vec<usize> = (0..t.len()).filter(|&row| is_at(t[row], of[row])).collect();
    let at: Vec<f64> = rows.iter().map(|&row| t[row]).collect();
    let pick =
        |name: &str| needed(record, name).map(|v| rows.iter().map(|&row| v[row]).collect::<Vec<f64>>());
    let (vx, vy, yaw) = (pick("v_WB_W_x")?, pick("v_WB_W_y")?, pick("yaw")?);
    let along: Vec<f64> = (0..at.len()).map(|i| vx[i] * yaw[i].cos() + vy[i] * yaw[i].sin()).collect();
    let aside: Vec<f64> = (0..at.len()).map(|i| vy[i] * yaw[i].cos() - vx[i] * yaw[i].sin()).collect();
    let truth = |name: &str| match name {
        "height" => pick("p_WB_z"),
        "forward" => Ok(along.clone()),
        "leftward" => Ok(aside.clone()),
        "upward" => pick("v_WB_W_z"),
        angle => pick(angle),
    };
    let mut panels = Vec::new();
    for (name, title, factor) in [("roll", "roll [°]", PANELS[1].2), ("height", "height [m]", 1.0)] {
        let scaled = |values: Vec<f64>| values.iter().map(|v| factor * v).collect::<Vec<f64>>();
        let believed =
            PanelCurve::new("estimate", &at, scaled(pick(&format!("estimate_{name}"))?), 1).whole();
        let true_one = PanelCurve {
            weight: style::BROAD,
            ..PanelCurve::new("true", &at, scaled(truth(name)?), 0).whole()
        };
        panels.push(FigurePanel::new(title, vec![true_one, believed]));
    }
    for (name, title, factor) in PANELS {
        let (estimates, truth) = (pick(&format!("estimate_{name}"))?, truth(name)?);
        let deviation = pick(&format!("estimate_deviation_{name}"))?;
        let error = estimates.iter().zip(&truth).map(|(e, t)| factor * (e - t)).collect();
        let band =
            at.iter().zip(&deviation).map(|(t, d)| (*t, -3.0 * factor * d, 3.0 * factor * d)).collect();
        let curve = PanelCurve::new("estimate less true", &at, error, 1).whole();
        panels.push(FigurePanel { bands: vec![band], ..FigurePanel::new(title, vec![curve]) });
    }
    if let Some(panel) = panels.get_mut(2) {
        panel.title += "; shaded: three standard deviations of the filter";
    }
    Ok(Figure::new("estimate", stacked(panels, "time [s]", 0.8 * style::PANEL)))
}
