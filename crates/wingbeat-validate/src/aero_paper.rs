//! The paper's unsteady lifting line.

use std::f64::consts::PI;

use wingbeat::aero::{JONES_RATES, JONES_WEIGHTS, LiftingLine, LiftingLineSettings};
use wingbeat::math::{EqualSteps, RK4, Workspace};

use crate::aero_full::linear::{Complex, RigidMotion, SmallMotion};
use crate::aero_full::{ComparedPoint, ComparedPreset, wings};
use crate::{Case, ComparisonRow, Error, reference_table};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "aero.elliptic_steady", quick: true, run: elliptic_steady },
    Case { id: "aero.speed_invariance", quick: true, run: speed_invariance },
    Case { id: "aero.wagner_limit", quick: true, run: wagner_limit },
    Case { id: "aero.glauert_rectangular", quick: true, run: glauert_rectangular },
    Case { id: "aero.step_starts_at_half", quick: true, run: step_starts_at_half },
    Case { id: "aero.theodorsen_plunge", quick: true, run: theodorsen_plunge },
    Case { id: "aero.theodorsen_pitch", quick: true, run: theodorsen_pitch },
];

/// Largest number of nodes, for comparisons with converged sums.
const MANY_NODES: usize = 32;

/// A wing of 1 m span in a given stream: the lifting-line equations alone.
struct StreamWing {
    line: LiftingLine,
    chords: Vec<f64>,
    area: f64,
}

impl StreamWing {
    fn new(nodes: usize, area: f64, chord: impl Fn(f64) -> f64) -> Result<Self, Error> {
        let settings = LiftingLineSettings { nodes, chord_floor_m: 1e-9, ..Default::default() };
        let line = LiftingLine::with_chords(0.5, &chord, settings)?;
        let chords = line.arcs().iter().map(|&arc| chord(arc)).collect();
        Ok(Self { line, chords, area })
    }

    fn elliptic(aspect: f64, nodes: usize) -> Result<Self, Error> {
        let root = 4.0 / (PI * aspect);
        Self::new(nodes, 1.0 / aspect, |arc| root * (1.0 - 4.0 * arc * arc).sqrt())
    }

    fn rectangular(aspect: f64, nodes: usize) -> Result<Self, Error> {
        Self::new(nodes, 1.0 / aspect, |_| 1.0 / aspect)
    }

    /// Effective wash by node after `travel` mean chords from rest at
    /// `airspeed` m/s and unit incidence, in `steps` steps.
    fn sudden_start(&self, airspeed: f64, travel: f64, steps: usize) -> Result<Vec<f64>, Error> {
        let m = self.line.strips();
        let stream = vec![airspeed; m];
        let (mut x, mut dx, mut wash) = (vec![0.0; 3 * m], vec![0.0; 3 * m], vec![0.0; m]);
        let mut work = Workspace::new(3 * m, 4);
        let h = travel * self.area / (airspeed * steps.max(1) as f64);
        let mut rates = |_: f64, x: &[f64], dx: &mut [f64]| {
            self.line.rates_in_wash(&stream, &stream, x, dx, &mut wash);
            Ok::<(), Error>(())
        };
        RK4.integrate(&mut rates, EqualSteps::new(0.0, h, steps), &mut x, &mut work)?;
        self.line.rates_in_wash(&stream, &stream, &x, &mut dx, &mut wash);
        Ok(wash)
    }

    /// Lift coefficient per incidence, 1/rad: lift per span rho U a0 (c/2) w_eff.
    fn lift_slope(&self, airspeed: f64, effective_wash: &[f64]) -> f64 {
        let slope = self.line.settings().section.section_slope;
        let lift: f64 = self
            .line
            .widths()
            .iter()
            .zip(&self.chords)
            .zip(effective_wash)
            .map(|((width, chord), wash)| width * slope * chord * wash)
            .sum();
        lift / (airspeed * self.area)
    }

    fn steady_slope(&self, airspeed: f64) -> Result<f64, Error> {
        Ok(self.lift_slope(airspeed, &self.sudden_start(airspeed, 400.0, 8000)?))
    }
}

fn worst(errors: impl IntoIterator<Item = f64>) -> f64 {
    errors.into_iter().fold(0.0, |worst: f64, error| worst.max(error.abs()))
}

/// Lift slope of ellipses beside a0 / (1 + 2/AR), 1/rad, by aspect ratio.
///
/// # Errors
/// [`Error`] when the model cannot be built.
pub fn elliptic_points() -> Result<Vec<ComparedPoint>, Error> {
    let point = |aspect: f64| {
        let exact = 2.0 * PI / (1.0 + 2.0 / aspect);
        let value = StreamWing::elliptic(aspect, 12)?.steady_slope(1.0)?;
        Ok(ComparedPoint { series: "ellipse".into(), x: aspect, value: (value, 0.0), exact: (exact, 0.0) })
    };
    [4.0, 8.0].into_iter().map(point).collect()
}

fn elliptic_steady() -> Result<Vec<ComparisonRow>, Error> {
    let errors = elliptic_points()?.into_iter().map(|point| point.error());
    let metric = "relative error of the lift slope, AR 4 and 8";
    Ok(vec![ComparisonRow::judged("aero.elliptic_steady", "Prandtl 1918", metric, worst(errors), 1e-9, "")])
}

fn speed_invariance() -> Result<Vec<ComparisonRow>, Error> {
    let wing = StreamWing::rectangular(6.0, 12)?;
    let slopes = [0.5, 1.3, 2.7, 4.0].map(|airspeed| wing.steady_slope(airspeed));
    let mut range = (f64::INFINITY, 0.0_f64);
    for slope in slopes {
        let slope = slope?;
        range = (range.0.min(slope), range.1.max(slope));
    }
    let metric = "spread of the lift coefficient, airspeed 0.5 to 4 m/s";
    let spread = (range.1 - range.0) / range.1;
    Ok(vec![ComparisonRow::judged(
        "aero.speed_invariance",
        "dimensional analysis",
        metric,
        spread,
        1e-12,
        "",
    )])
}

/// Effective wash at mid span of AR 1e5 beside Wagner's function after Jones, by semichords travelled.
///
/// # Errors
/// [`Error`] when the model cannot be built.
pub fn wagner_points() -> Result<Vec<ComparedPoint>, Error> {
    let wing = StreamWing::rectangular(1e5, 13)?;
    let point = |semichords: f64| {
        let steps = (semichords * 40.0) as usize;
        let value = wing.sudden_start(1.0, 0.5 * semichords, steps)?[6];
        let jones: f64 = (0..2).map(|k| JONES_WEIGHTS[k] * (-JONES_RATES[k] * semichords).exp()).sum();
        Ok(ComparedPoint {
            series: "mid span".into(),
            x: semichords,
            value: (value, 0.0),
            exact: (1.0 - jones, 0.0),
        })
    };
    [0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0].into_iter().map(point).collect()
}

fn wagner_limit() -> Result<Vec<ComparisonRow>, Error> {
    let errors = wagner_points()?.into_iter().map(|point| point.value.0 - point.exact.0);
    let metric = "error of Wagner's function at mid span, AR 1e5";
    Ok(vec![ComparisonRow::judged("aero.wagner_limit", "Jones 1940", metric, worst(errors), 4e-4, "")])
}

/// Lift slope of rectangles beside Glauert's series, 1/rad, by aspect ratio 3 to 20.
///
/// # Errors
/// [`Error`] when the table or the model fails.
pub fn glauert_points() -> Result<Vec<ComparedPoint>, Error> {
    let table = reference_table!("analytic/lifting_line_steady.csv")?;
    let (planforms, aspects) = (table.words("planform")?, table.column("AR")?);
    let slopes = table.column("CLalpha_per_rad")?;
    let point = |i: usize| {
        let wing = StreamWing::rectangular(aspects[i], MANY_NODES)?;
        let slope = wing.lift_slope(1.0, &wing.sudden_start(1.0, 150.0, 12000)?);
        let (value, exact) = ((slope, 0.0), (slopes[i], 0.0));
        Ok(ComparedPoint { series: "rectangle".into(), x: aspects[i], value, exact })
    };
    let wanted = |i: &usize| planforms[*i] == "rect" && (3.0..=20.0).contains(&aspects[*i]);
    (0..table.len()).filter(wanted).map(point).collect()
}

fn glauert_rectangular() -> Result<Vec<ComparisonRow>, Error> {
    let errors = glauert_points()?.into_iter().map(|point| point.error());
    let metric = "relative error of the lift slope, rectangles AR 3 to 20";
    Ok(vec![ComparisonRow::judged(
        "aero.glauert_rectangular",
        "Glauert 1926, 200 terms",
        metric,
        worst(errors),
        1e-3,
        "",
    )])
}

fn step_starts_at_half() -> Result<Vec<ComparisonRow>, Error> {
    let mut errors = Vec::new();
    for aspect in [4.0, 8.0] {
        let wing = StreamWing::elliptic(aspect, 12)?;
        errors.push(wing.lift_slope(1.0, &wing.sudden_start(1.0, 0.0, 0)?) / PI - 1.0);
    }
    let metric = "relative error of CL(0+) = a0 alpha / 2";
    Ok(vec![ComparisonRow::judged(
        "aero.step_starts_at_half",
        "Wagner 1925",
        metric,
        worst(errors),
        1e-9,
        "",
    )])
}

/// Aspect ratio at which a wing is a section.
const SECTION: f64 = 1e4;

/// Complex lift coefficient of a section of unit chord per unit of derivative
/// `order` of the small motion, by reduced frequency `k` = omega c / (2 U), beside `exact`.
fn section_points(
    preset: ComparedPreset,
    series: &str,
    (motion, order): (RigidMotion, i32),
    exact: impl Iterator<Item = (f64, Complex)>,
) -> Result<Vec<ComparedPoint>, Error> {
    let still = wings::rectangular(SECTION)?;
    let model = preset.model_of(MANY_NODES, still.wing.planform(), &[], 1.0, 1e-6)?;
    let small = SmallMotion::new(&model, &still, motion);
    let point = |(k, exact): (f64, Complex)| {
        let omega = 2.0 * k;
        let (re, im) = small.response(omega)?[0];
        let scale = 0.5 * still.area * omega.powi(order);
        let value = if order == 1 { (im / scale, -re / scale) } else { (re / scale, im / scale) };
        Ok(ComparedPoint { series: series.into(), x: k, value, exact })
    };
    exact.filter(|(k, _)| *k <= 1.0).map(point).collect()
}

/// Lift per upwash angle of a section in plunge, by reduced frequency.
///
/// # Errors
/// [`Error`] when the table or the model fails.
pub fn theodorsen_plunge_points(preset: ComparedPreset) -> Result<Vec<ComparedPoint>, Error> {
    let table = reference_table!("analytic/theodorsen_plunge_2d.csv")?;
    let (re, im) = (table.column("Re_CL_over_alpha_e")?, table.column("Im_CL_over_alpha_e")?);
    let exact = table.column("k")?.into_iter().zip(re.into_iter().zip(im));
    section_points(preset, "plunge", (RigidMotion::Plunge, 1), exact)
}

/// Lift per pitch angle of a section about three axes, by reduced frequency.
///
/// # Errors
/// [`Error`] when the table or the model fails.
pub fn theodorsen_pitch_points(preset: ComparedPreset) -> Result<Vec<ComparedPoint>, Error> {
    let table = reference_table!("analytic/theodorsen_pitch_2d.csv")?;
    let axes = table.column("a_semichords_from_midchord")?;
    let (ks, re, im) =
        (table.column("k")?, table.column("Re_CL_over_alpha0")?, table.column("Im_CL_over_alpha0")?);
    let mut points = Vec::new();
    for (axis, name) in [(-0.5, "axis at 1/4 chord"), (0.0, "axis at 1/2 chord"), (0.5, "axis at 3/4 chord")]
    {
        let rows = (0..table.len()).filter(|&i| axes[i] == axis);
        let exact = rows.map(|i| (ks[i], (re[i], im[i])));
        let motion = RigidMotion::Pitch(-0.5 - 0.5 * axis);
        points.extend(section_points(preset, name, (motion, 0), exact)?);
    }
    Ok(points)
}

fn theodorsen_plunge() -> Result<Vec<ComparisonRow>, Error> {
    let errors = theodorsen_plunge_points(ComparedPreset::Paper)?.into_iter().map(|point| point.error());
    let metric = "worst complex error of lift, k <= 1, AR 1e4";
    Ok(vec![ComparisonRow::judged(
        "aero.theodorsen_plunge",
        "Theodorsen 1935",
        metric,
        worst(errors),
        0.025,
        "",
    )])
}

fn theodorsen_pitch() -> Result<Vec<ComparisonRow>, Error> {
    let errors = theodorsen_pitch_points(ComparedPreset::Paper)?.into_iter().map(|point| point.error());
    let metric = "worst complex error of lift, axes 1/4, 1/2, 3/4 chord, k <= 1, AR 1e4";
    Ok(vec![ComparisonRow::judged(
        "aero.theodorsen_pitch",
        "Theodorsen 1935",
        metric,
        worst(errors),
        0.025,
        "",
    )])
}
