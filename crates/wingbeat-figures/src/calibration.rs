//! What a calibration found: cycles with bands, correlations, profiles, spectra, information.

use crate::canvas::{Canvas, Colour, Primitive, TextAnchor};
use crate::chart::{Chart, ChartAxis, ChartSeries, Look, grid};
use crate::panel::{FigurePanel, PanelCurve, stacked};
use crate::style;
use crate::write::Figure;

/// Height of a panel of a cycle, px.
const HEIGHT: f64 = 150.0;
/// Height of a small panel, px.
const SMALL: f64 = 170.0;
/// Height of a row of a table, px.
const ROW: f64 = 26.0;
/// Room above a table for the slanted names of its columns, px.
const HEAD: f64 = 190.0;
/// Width of a letter, px.
const LETTER: f64 = 7.0;
/// Room around a figure, px.
const PADDING: f64 = 10.0;
/// Name of the row that shows the scale of colours.
const SCALE: &str = "scale of colours";
/// Rise of the names of columns, degrees.
const RISE: f64 = -50.0;

/// One channel of a run over its cycle.
pub struct Overlay {
    /// Channel with its unit in brackets.
    pub title: String,
    /// Measured mean, in the unit of the title.
    pub measured: Vec<f64>,
    /// Predicted with the values that the fit began with, in the unit of the title.
    pub before: Vec<f64>,
    /// Predicted with the fit, in the unit of the title.
    pub after: Vec<f64>,
    /// Low and high end of the 95 % band, in the unit of the title.
    pub band: Vec<(f64, f64)>,
    /// Predicted with the fit and the wrench that is learned of what it leaves, in the unit of the title.
    pub with_residual: Option<Vec<f64>>,
}

/// Measured cycles of a run, before and after the fit, with the 95 % band.
pub fn overlay(channels: Vec<Overlay>) -> Figure {
    let panels = channels
        .into_iter()
        .map(|channel| {
            // The cycle closes where the next begins.
            let count = channel.measured.len();
            let phase: Vec<f64> = (0..=count).map(|k| k as f64 / count as f64).collect();
            let closed = |values: &[f64]| (0..=count).map(|k| values[k % count]).collect::<Vec<f64>>();
            let band = (0..=count).map(|k| {
                let (low, high) = channel.band[k % count];
                (phase[k], low, high)
            });
            let bands = vec![band.collect()];
            let with_residual = channel.with_residual.as_deref().map(closed);
            let mut curves = vec![
                PanelCurve::new("before", &phase, closed(&channel.before), 1),
                PanelCurve::new("after", &phase, closed(&channel.after), 0).whole(),
                PanelCurve::reference("measured", &phase, closed(&channel.measured)),
            ];
            curves.extend(with_residual.map(|values| PanelCurve::new("with residual", &phase, values, 2)));
            FigurePanel { bands, ..FigurePanel::new(channel.title, curves) }
        })
        .collect();
    let across = "phase of the cycle [cycles]; shaded: 95 % of measured cycles, as predicted";
    Figure::new("overlay", stacked(panels, across, HEIGHT))
}

/// The cost along one parameter.
pub struct ProfileCurve {
    /// Parameter.
    pub name: String,
    /// What its profile says.
    pub title: String,
    /// (value in the unit of the parameter, cost above the least without unit).
    pub points: Vec<(f64, f64)>,
    /// Value and standard error of the fit, in the unit of the parameter.
    pub fit: (f64, f64),
}

/// Profiles of the cost with the parabolas that the standard errors mean; shaded: the 95 % that 3.84 bounds.
pub fn profiles(curves: Vec<ProfileCurve>) -> Figure {
    let chart = |curve: ProfileCurve| {
        let (value, error) = curve.fit;
        let parabola = |k: i32| {
            let deviations = f64::from(k) / 10.0;
            (value + deviations * error, deviations * deviations)
        };
        let mut series =
            vec![ChartSeries::new("other parameters fitted again", curve.points.clone(), Look::Circles, 0)];
        if error > 0.0 && error.is_finite() {
            let (low, high) =
                curve.points.iter().fold((value, value), |(low, high), (x, _)| (low.min(*x), high.max(*x)));
            let by_error = (-30..=30).map(parabola).filter(|(x, _)| (low..=high).contains(x)).collect();
            series.push(ChartSeries::new("parabola of the standard error", by_error, Look::Dashed, 1));
        }
        Chart {
            title: curve.title,
            x: ChartAxis::new(curve.name),
            y: ChartAxis::new("rise of chi-squared; grey: 95 %").over(0.0, 12.0),
            series,
            passes: Some((0.0, 3.84)),
        }
    };
    grid("profiles", curves.into_iter().map(chart).collect(), 2, SMALL)
}

/// One channel's residuals by harmonic: amplitudes before and after the fit, and of the noise of the mean.
pub struct ResidualSpectrum {
    /// Channel with its unit in brackets.
    pub title: String,
    /// Rms over the runs before the fit, by harmonic from 0, in the unit of the channel.
    pub before: Vec<f64>,
    /// The same after the fit.
    pub after: Vec<f64>,
    /// What noise leaves in the mean of the cycles, in the unit of the channel.
    pub noise: Vec<f64>,
}

/// Residuals by harmonic beside the noise.
pub fn residual_spectra(channels: Vec<ResidualSpectrum>) -> Figure {
    let chart = |channel: ResidualSpectrum| {
        let points = |of: &[f64]| {
            of.iter().enumerate().map(|(k, y)| (k as f64, y.max(1e-12))).collect::<Vec<(f64, f64)>>()
        };
        Chart {
            title: channel.title,
            x: ChartAxis::new("harmonic of the cycle"),
            y: ChartAxis::log("amplitude"),
            series: vec![
                ChartSeries::new("before", points(&channel.before), Look::Dashed, 1),
                ChartSeries::new("after", points(&channel.after), Look::Line, 0),
                ChartSeries::reference("noise of the mean", points(&channel.noise)),
            ],
            passes: None,
        }
    };
    grid("residual_spectra", channels.into_iter().map(chart).collect(), 2, SMALL)
}

/// Numbers by row and column as shaded cells.
pub struct ShadedCells {
    /// Name of the files.
    pub name: &'static str,
    /// What the numbers are.
    pub title: String,
    /// Names of the rows.
    pub rows: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Numbers in the unit of the title; those that are not finite stay blank.
    pub values: Vec<Vec<f64>>,
    /// Share of the scale of colours at a number, 0 to 1.
    pub shade: fn(f64) -> f64,
    /// The number in a cell, as it is written, in the unit of the title.
    pub text: fn(f64) -> String,
    /// Numbers that show the scale of colours below the table, in the unit of the title.
    pub scale: &'static [f64],
}

/// Correlations, from -1 to 1.
pub fn correlations(names: &[String], values: Vec<Vec<f64>>) -> Figure {
    cells(&ShadedCells {
        name: "correlations",
        title: "correlations of the estimates, dark where large of either sign".into(),
        rows: names.to_vec(),
        columns: names.to_vec(),
        values,
        shade: |value| value.abs(),
        text: |value| format!("{value:.2}").replace('-', "−"),
        scale: &[0.0, 0.25, 0.5, 0.75, 1.0],
    })
}

/// Standard error of each parameter from each run and channel alone, in parts of its size.
pub fn information(rows: Vec<String>, columns: Vec<String>, values: Vec<Vec<f64>>) -> Figure {
    cells(&ShadedCells {
        name: "information",
        title: "standard error in parts of the parameter's size, from one channel of one run alone".into(),
        rows,
        columns,
        values,
        // From one part in a thousand, dark, to the whole, light.
        shade: |value| (-value.log10() / 3.0).clamp(0.0, 1.0),
        text: |value| if value < 10.0 { format!("{value:.1e}") } else { "–".into() },
        scale: &[1e-3, 1e-2, 1e-1, 1.0],
    })
}

/// A table of shaded cells, dark where the share is large.
pub fn cells(of: &ShadedCells) -> Figure {
    let longest = |names: &[String]| names.iter().map(|name| name.chars().count()).max().unwrap_or(0) as f64;
    let left = PADDING + LETTER * longest(&of.rows).max(SCALE.len() as f64) + PADDING;
    let head = HEAD.min(40.0 + 0.8 * LETTER * longest(&of.columns));
    let count = of.columns.len().max(1) as f64;
    let beyond = 0.7 * LETTER * longest(&of.columns).min(40.0);
    let wide = ((style::WIDTH - left - beyond) / count).clamp(40.0, 80.0);
    let columns = count.max(of.scale.len() as f64);
    // As wide as the table, its scale and its title need.
    let titled = 2.0 * PADDING + LETTER * of.title.chars().count() as f64;
    let width = (left + wide * columns + beyond.max(PADDING)).max(titled);
    let below = head + ROW * of.rows.len() as f64 + PADDING;
    let mut scene = Canvas::new(width, below + ROW + PADDING);
    let put = |scene: &mut Canvas, x: f64, y: f64, text: &str, anchor, colour: &str, rotate| {
        let (content, color) = (text.to_owned(), Some(Colour::from(colour)));
        scene.elements.push(Primitive::Text {
            x,
            y,
            content,
            size: style::TICKS,
            anchor,
            rotate,
            bold: false,
            color,
        });
    };
    put(&mut scene, PADDING, 18.0, &of.title, TextAnchor::Start, style::INK, None);
    for (j, name) in of.columns.iter().enumerate() {
        let x = left + wide * (j as f64 + 0.5);
        put(&mut scene, x, head - 6.0, name, TextAnchor::Start, style::INK, Some(RISE));
    }
    let rows = of.rows.iter().map(String::as_str).zip(of.values.iter().map(Vec::as_slice));
    for (i, (name, values)) in rows.chain([(SCALE, of.scale)]).enumerate() {
        let y = if i < of.rows.len() { head + ROW * i as f64 } else { below };
        put(&mut scene, left - PADDING, y + 17.0, name, TextAnchor::End, style::INK, None);
        for (j, value) in values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
            let share = (of.shade)(*value).clamp(0.0, 1.0);
            let x = left + wide * j as f64;
            scene.elements.push(Primitive::Rect {
                x,
                y,
                width: wide - 1.0,
                height: ROW - 1.0,
                fill: Colour::Rgb(style::viridis(1.0 - 0.9 * share)),
                opacity: None,
            });
            let ink = if share > 0.5 { "#ffffff" } else { style::INK };
            let middle = x + 0.5 * wide;
            put(&mut scene, middle, y + 17.0, &(of.text)(*value), TextAnchor::Middle, ink, None);
        }
    }
    Figure::new(of.name, scene)
}
