//! Small motions: steady slope, plunge, step and other wings, against our linear
//! lifting surface.

use super::ComparedPreset;
use super::lattice::loading;
use super::linear::{Complex, RigidMotion, SmallMotion};
use super::wings::{self, Still};
use crate::{ComparisonRow, Error, reference_table};
use std::f64::consts::PI;

const SOURCE: &str = "linear lifting surface (own lattice, Richardson)";

/// One compared number.
#[derive(Clone, Debug)]
pub struct ComparedPoint {
    /// Wing and motion.
    pub series: String,
    /// Aspect ratio, reduced frequency or semichords.
    pub x: f64,
    /// Force coefficient of the model.
    pub value: Complex,
    /// Force coefficient of the reference.
    pub exact: Complex,
}

impl ComparedPoint {
    /// Relative error |value - exact| / |exact|.
    pub fn error(&self) -> f64 {
        let (value, exact) = (self.value, self.exact);
        (value.0 - exact.0).hypot(value.1 - exact.1) / exact.0.hypot(exact.1)
    }
}

/// The row of the worst of `points`.
fn worst(
    preset: ComparedPreset,
    name: &str,
    metric: &str,
    points: &[ComparedPoint],
    limit: f64,
) -> ComparisonRow {
    let worst = points.iter().map(ComparedPoint::error).fold(0.0, f64::max);
    preset.row(&preset.id(name), SOURCE, metric, worst, limit)
}

fn linearise(preset: ComparedPreset, still: &Still, motion: RigidMotion) -> Result<SmallMotion, Error> {
    let model = preset.model(still.wing.planform(), &still.hinges(), 1.0, 1e-6)?;
    Ok(SmallMotion::new(&model, still, motion))
}

/// Steady lift slope of rectangles, AR 3 to 20.
pub fn slope(preset: ComparedPreset) -> Result<Vec<ComparisonRow>, Error> {
    let points = slope_points(preset)?;
    Ok(vec![worst(preset, "slope", "worst error of the steady lift slope, AR 3 to 20", &points, 0.02)])
}

/// Lift slope by aspect ratio, 1/rad.
///
/// # Errors
/// [`Error`] when a table or the model fails.
pub fn slope_points(preset: ComparedPreset) -> Result<Vec<ComparedPoint>, Error> {
    let table = reference_table!("lifting_surface/steady.csv")?;
    let columns = table.column("AR")?.into_iter().zip(table.column("CLalpha_12x120")?);
    columns
        .filter(|(aspect, _)| *aspect >= 3.0)
        .map(|(aspect, exact)| {
            let lift = linearise(preset, &wings::rectangular(aspect)?, RigidMotion::Plunge)?.steady(1)?[0];
            Ok(ComparedPoint {
                series: "rectangle".into(),
                x: aspect,
                value: (lift / (0.5 * aspect), 0.0),
                exact: (exact, 0.0),
            })
        })
        .collect()
}

/// Complex lift of plunging rectangles, k <= 1.
pub fn plunge(preset: ComparedPreset) -> Result<Vec<ComparisonRow>, Error> {
    let points = plunge_points(preset)?;
    Ok(vec![worst(preset, "plunge", "worst complex error of lift, AR 4 to 20, k <= 1", &points, 0.02)])
}

/// Lift per upwash angle by reduced frequency.
///
/// # Errors
/// [`Error`] when a table or the model fails.
pub fn plunge_points(preset: ComparedPreset) -> Result<Vec<ComparedPoint>, Error> {
    let table = reference_table!("lifting_surface/plunge.csv")?;
    let (aspects, ks) = (table.column("AR")?, table.column("k")?);
    let (re, im) = (table.column("Re_H")?, table.column("Im_H")?);
    let mut points = Vec::new();
    let mut wing: Option<(f64, SmallMotion)> = None;
    for i in (0..table.len()).filter(|&i| ks[i] <= 1.0) {
        let aspect = aspects[i];
        if wing.as_ref().is_none_or(|(a, _)| *a != aspect) {
            wing = Some((aspect, linearise(preset, &wings::rectangular(aspect)?, RigidMotion::Plunge)?));
        }
        let Some((_, small)) = &wing else { continue };
        points.push(ComparedPoint {
            series: format!("AR {aspect}"),
            x: ks[i],
            value: per_upwash(small.response(2.0 * ks[i])?[0], 2.0 * ks[i], 0.5 * aspect),
            exact: (re[i], im[i]),
        });
    }
    Ok(points)
}

/// y / (i omega scale): the response to unit upwash from that to unit plunge.
fn per_upwash(y: Complex, omega: f64, scale: f64) -> Complex {
    (y.1 / (omega * scale), -y.0 / (omega * scale))
}

/// Lift after a sudden start of rectangles, s >= 1.
pub fn step(preset: ComparedPreset) -> Result<Vec<ComparisonRow>, Error> {
    let points = step_points(preset)?;
    Ok(vec![worst(preset, "step", "worst error of lift after a sudden start, s >= 1", &points, 0.02)])
}

/// Lift per incidence by semichords travelled.
///
/// # Errors
/// [`Error`] when a table or the model fails.
pub fn step_points(preset: ComparedPreset) -> Result<Vec<ComparedPoint>, Error> {
    let table = reference_table!("lifting_surface/impulsive.csv")?;
    let (aspects, travel) = (table.column("AR")?, table.column("s_semichords")?);
    let exact = table.column("CL_over_alpha")?;
    let mut points = Vec::new();
    let mut first = 0;
    while first < table.len() {
        let aspect = aspects[first];
        let rows: Vec<usize> = (first..table.len()).take_while(|&i| aspects[i] == aspect).collect();
        first += rows.len();
        let late: Vec<usize> = rows.into_iter().filter(|&i| travel[i] >= 1.0).collect();
        let small = linearise(preset, &wings::rectangular(aspect)?, RigidMotion::Plunge)?;
        let times: Vec<f64> = late.iter().map(|&i| 0.5 * travel[i]).collect();
        for (i, y) in late.into_iter().zip(small.step(1, &times)) {
            points.push(ComparedPoint {
                series: format!("AR {aspect}"),
                x: travel[i],
                value: (y[0] / (0.5 * aspect), 0.0),
                exact: (exact[i], 0.0),
            });
        }
    }
    Ok(points)
}

/// Normal force along one half of the span of a plunging rectangle, from the tip inwards.
#[derive(Clone, Debug)]
pub struct SpanLoading {
    /// Aspect ratio.
    pub aspect: f64,
    /// Reduced frequency.
    pub k: f64,
    /// Places of the stations over the half span.
    pub places: Vec<f64>,
    /// Force per span over dynamic pressure, chord and upwash angle, of the model.
    pub value: Vec<Complex>,
    /// The same of the lattice, extrapolated from 12 and 24 panels.
    pub exact: Vec<Complex>,
    /// Largest relative error of the lattice's circulation, over its peak.
    pub lattice_error: f64,
}

/// Span loadings of rectangles, AR 4 to 20, k 0.1 to 0.5, beside a lattice whose circulation is
/// held against the tables.
///
/// # Errors
/// [`Error`] when a table, the lattice or the model fails.
pub fn span_loadings(preset: ComparedPreset) -> Result<Vec<SpanLoading>, Error> {
    let mut loadings = Vec::new();
    for (aspect, stations) in [(4.0, 16), (6.0, 16), (12.0, 24), (20.0, 24)] {
        for k in [0.1, 0.3, 0.5] {
            let [coarse, fine] = [loading(aspect, k, 12, stations)?, loading(aspect, k, 24, stations)?];
            let table = table_circulation(aspect, k)?;
            let step = PI / (stations + 1) as f64;
            loadings.push(SpanLoading {
                aspect,
                k,
                places: (1..=stations / 2).map(|j| (j as f64 * step).cos()).collect(),
                value: span_force(preset, aspect, k, stations)?,
                exact: extrapolated(&coarse.force, &fine.force),
                lattice_error: distance_over_peak(&fine.circulation, &table),
            });
        }
    }
    Ok(loadings)
}

/// The worst of the span loadings, and of the lattice that they are compared with.
pub fn span_loading(preset: ComparedPreset) -> Result<Vec<ComparisonRow>, Error> {
    let loadings = span_loadings(preset)?;
    let worst = loadings.iter().map(|l| distance_over_peak(&l.value, &l.exact)).fold(0.0, f64::max);
    let lattice_worst = loadings.iter().map(|l| l.lattice_error).fold(0.0, f64::max);
    let metric = "worst error of normal force over its peak, AR 4 to 20, k 0.1 to 0.5";
    let source = "linear vortex lattice, Richardson from 12 and 24 panels";
    let check = "error of the lattice's circulation over its peak";
    let id = preset.id("span_loading");
    Ok(vec![
        preset.row(&id, source, metric, worst, 0.03),
        preset.row(&format!("{id}.lattice"), SOURCE, check, lattice_worst, 0.01),
    ])
}

/// Richardson's extrapolation of a first-order method from n and 2n panels.
pub(super) fn extrapolated(coarse: &[Complex], fine: &[Complex]) -> Vec<Complex> {
    coarse.iter().zip(fine).map(|(c, f)| (2.0 * f.0 - c.0, 2.0 * f.1 - c.1)).collect()
}

fn distance_over_peak(value: &[Complex], exact: &[Complex]) -> f64 {
    let peak = exact.iter().map(|e| e.0.hypot(e.1)).fold(0.0, f64::max);
    let distance = value.iter().zip(exact).map(|(v, e)| (v.0 - e.0).hypot(v.1 - e.1));
    distance.fold(0.0, f64::max) / peak
}

/// Force per span over dynamic pressure, chord and upwash angle, at the stations of one half.
fn span_force(preset: ComparedPreset, aspect: f64, k: f64, stations: usize) -> Result<Vec<Complex>, Error> {
    let still = wings::rectangular(aspect)?;
    let model = preset.model_of(stations, still.wing.planform(), &[], 1.0, 1e-6)?;
    let response = SmallMotion::new(&model, &still, RigidMotion::Plunge).response(2.0 * k)?;
    let widths = model.arcs().windows(2).map(|a| a[0] - a[1]);
    let forces = response[1..].iter().zip(widths).take(stations / 2);
    Ok(forces.map(|(force, width)| per_upwash(*force, 2.0 * k, 0.5 * width)).collect())
}

/// Circulation over speed, chord and upwash angle of one half of lifting_surface/spanload.csv.
fn table_circulation(aspect: f64, k: f64) -> Result<Vec<Complex>, Error> {
    let table = reference_table!("lifting_surface/spanload.csv")?;
    let columns = ["AR", "k", "y_over_halfspan", "Re_Gamma", "Im_Gamma"].map(|name| table.column(name));
    let [aspects, ks, y, re, im] = columns;
    let (aspects, ks, y, re, im) = (aspects?, ks?, y?, re?, im?);
    let rows = (0..table.len()).filter(|&i| aspects[i] == aspect && ks[i] == k && y[i] < 0.0);
    Ok(rows.map(|i| (re[i], im[i])).collect())
}

/// Vertical force of other planforms and folds in plunge and pitch, k <= 0.5.
pub fn other_wings(preset: ComparedPreset) -> Result<Vec<ComparisonRow>, Error> {
    let points = other_points(preset)?;
    let (aerobat, others): (Vec<_>, Vec<_>) =
        points.into_iter().partition(|p| p.series.starts_with("aerobat"));
    let metric = "worst complex error of force, plunge and pitch, k <= 0.5";
    let mut rows = vec![worst(preset, "other_wings", metric, &others, 0.02)];
    rows.push(worst(preset, "other_wings.aerobat", metric, &aerobat, 0.03));
    Ok(rows)
}

/// Vertical force per upwash or pitch angle by reduced frequency.
///
/// # Errors
/// [`Error`] when a table or the model fails.
pub fn other_points(preset: ComparedPreset) -> Result<Vec<ComparedPoint>, Error> {
    let table = reference_table!("lifting_surface/other_wings.csv")?;
    let (names, motions, ks) = (table.words("wing")?, table.words("motion")?, table.column("k")?);
    let (re, im) = (table.column("Re_H")?, table.column("Im_H")?);
    let mut points = Vec::new();
    let mut at: Option<(&str, &str, Still, SmallMotion)> = None;
    for i in (0..table.len()).filter(|&i| ks[i] > 0.0 && ks[i] <= 0.5) {
        if at.as_ref().is_none_or(|(name, motion, ..)| *name != names[i] || *motion != motions[i]) {
            let still = wings::other(names[i])?;
            let small = linearise(preset, &still, motion_of(motions[i], &still)?)?;
            at = Some((names[i], motions[i], still, small));
        }
        let Some((_, _, still, small)) = &at else { continue };
        let omega = 2.0 * ks[i] / still.chord;
        let (force, scale) = (small.response(omega)?[0], 0.5 * still.area);
        let value = match motions[i] {
            "plunge" => per_upwash(force, omega, scale),
            _ => (force.0 / scale, force.1 / scale),
        };
        let series = format!("{} {}", names[i], motions[i]);
        points.push(ComparedPoint { series, x: ks[i], value, exact: (re[i], im[i]) });
    }
    Ok(points)
}

/// `plunge`, or `pitch` with the axis in mean chords behind the origin.
pub(super) fn motion_of(name: &str, still: &Still) -> Result<RigidMotion, Error> {
    let Some(axis) = name.strip_prefix("pitch") else { return Ok(RigidMotion::Plunge) };
    let behind: f64 = format!("0{axis}")
        .parse()
        .map_err(|_| Error::reference("lifting_surface/other_wings.csv", format!("no motion {name}")))?;
    Ok(RigidMotion::Pitch(still.origin - behind * still.chord))
}
