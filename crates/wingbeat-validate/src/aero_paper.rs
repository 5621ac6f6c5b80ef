//! The paper's unsteady lifting line.

use std::f64::consts::PI;

use wingbeat::aero::{Aero, JONES_RATES, JONES_WEIGHTS, LiftingLine, LiftingLineSettings, ProfileDrag};
use wingbeat::math::{RK4, Workspace};

use crate::aero_full::linear::{Complex, Motion, SmallMotion};
use crate::aero_full::wings;
use crate::{Case, Error, Row, reference_table};

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
struct Stream {
    line: LiftingLine,
    chords: Vec<f64>,
    area: f64,
}

impl Stream {
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
        for _ in 0..steps {
            let rates = |_: f64, x: &[f64], dx: &mut [f64]| {
                self.line.rates_in_wash(&stream, &stream, x, dx, &mut wash);
                Ok::<(), Error>(())
            };
            RK4.step(rates, 0.0, h, &mut x, &mut work)?;
        }
        self.line.rates_in_wash(&stream, &stream, &x, &mut dx, &mut wash);
        Ok(wash)
    }

    /// Lift coefficient per incidence, 1/rad: lift per span rho U a0 (c/2) w_eff.
    fn lift_slope(&self, airspeed: f64, effective_wash: &[f64]) -> f64 {
        let slope = self.line.settings().section_slope;
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

fn elliptic_steady() -> Result<Vec<Row>, Error> {
    let mut errors = Vec::new();
    for aspect in [4.0, 8.0] {
        let exact = 2.0 * PI / (1.0 + 2.0 / aspect);
        errors.push(Stream::elliptic(aspect, 12)?.steady_slope(1.0)? / exact - 1.0);
    }
    let metric = "relative error of the lift slope, AR 4 and 8";
    Ok(vec![Row::judged("aero.elliptic_steady", "Prandtl 1918", metric, worst(errors), 1e-9, "")])
}

fn speed_invariance() -> Result<Vec<Row>, Error> {
    let wing = Stream::rectangular(6.0, 12)?;
    let slopes = [0.5, 1.3, 2.7, 4.0].map(|airspeed| wing.steady_slope(airspeed));
    let mut range = (f64::INFINITY, 0.0_f64);
    for slope in slopes {
        let slope = slope?;
        range = (range.0.min(slope), range.1.max(slope));
    }
    let metric = "spread of the lift coefficient, airspeed 0.5 to 4 m/s";
    let spread = (range.1 - range.0) / range.1;
    Ok(vec![Row::judged("aero.speed_invariance", "dimensional analysis", metric, spread, 1e-12, "")])
}

fn wagner_limit() -> Result<Vec<Row>, Error> {
    let aspect = 1e5;
    let wing = Stream::rectangular(aspect, 13)?;
    let mut errors = Vec::new();
    for semichords in [0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0] {
        let steps = (semichords * 40.0) as usize;
        let lift = wing.sudden_start(1.0, 0.5 * semichords, steps)?[6];
        let jones: f64 = (0..2).map(|k| JONES_WEIGHTS[k] * (-JONES_RATES[k] * semichords).exp()).sum();
        errors.push(lift - (1.0 - jones));
    }
    let metric = "error of Wagner's function at mid span, AR 1e5";
    Ok(vec![Row::judged("aero.wagner_limit", "Jones 1940", metric, worst(errors), 4e-4, "")])
}

fn glauert_rectangular() -> Result<Vec<Row>, Error> {
    let table = reference_table!("analytic/lifting_line_steady.csv")?;
    let (planforms, aspects) = (table.words("planform")?, table.column("AR")?);
    let slopes = table.column("CLalpha_per_rad")?;
    let mut errors = Vec::new();
    for i in (0..table.len()).filter(|&i| planforms[i] == "rect" && (3.0..=20.0).contains(&aspects[i])) {
        let wing = Stream::rectangular(aspects[i], MANY_NODES)?;
        let slope = wing.lift_slope(1.0, &wing.sudden_start(1.0, 150.0, 12000)?);
        errors.push(slope / slopes[i] - 1.0);
    }
    let metric = "relative error of the lift slope, rectangles AR 3 to 20";
    Ok(vec![Row::judged(
        "aero.glauert_rectangular",
        "Glauert 1926, 200 terms",
        metric,
        worst(errors),
        1e-3,
        "",
    )])
}

fn step_starts_at_half() -> Result<Vec<Row>, Error> {
    let mut errors = Vec::new();
    for aspect in [4.0, 8.0] {
        let wing = Stream::elliptic(aspect, 12)?;
        errors.push(wing.lift_slope(1.0, &wing.sudden_start(1.0, 0.0, 0)?) / PI - 1.0);
    }
    let metric = "relative error of CL(0+) = a0 alpha / 2";
    Ok(vec![Row::judged("aero.step_starts_at_half", "Wagner 1925", metric, worst(errors), 1e-9, "")])
}

/// Aspect ratio at which a wing is a section.
const SECTION: f64 = 1e4;

/// Complex lift coefficient of a section of unit chord per unit of derivative
/// `order` of the small motion, at the reduced frequency `k` = omega c / (2 U).
fn section_response(motion: Motion, order: i32, ks: &[f64]) -> Result<Vec<Complex>, Error> {
    let still = wings::rectangular(SECTION)?;
    let settings = LiftingLineSettings {
        nodes: MANY_NODES,
        density_kg_m3: 1.0,
        regularisation_m_s: 1e-6,
        drag: ProfileDrag { cd0: 0.0, cd90: 0.0 },
        ..Default::default()
    };
    let line = LiftingLine::new(still.wing.planform(), settings)?;
    let small = SmallMotion::new(&Aero::LiftingLine(line), &still, motion);
    let coefficient = |&k: &f64| {
        let omega = 2.0 * k;
        let (re, im) = small.response(omega)?[0];
        let scale = 0.5 * still.area * omega.powi(order);
        Ok(if order == 1 { (im / scale, -re / scale) } else { (re / scale, im / scale) })
    };
    ks.iter().map(coefficient).collect()
}

/// Worst |value - exact| / |exact|, k <= 1.
fn worst_response(ks: &[f64], values: &[Complex], re: &[f64], im: &[f64]) -> f64 {
    let error = |i: usize| (values[i].0 - re[i]).hypot(values[i].1 - im[i]) / re[i].hypot(im[i]);
    worst((0..ks.len()).filter(|&i| ks[i] <= 1.0).map(error))
}

fn theodorsen_plunge() -> Result<Vec<Row>, Error> {
    let table = reference_table!("analytic/theodorsen_plunge_2d.csv")?;
    let (ks, re) = (table.column("k")?, table.column("Re_CL_over_alpha_e")?);
    let values = section_response(Motion::Plunge, 1, &ks)?;
    let error = worst_response(&ks, &values, &re, &table.column("Im_CL_over_alpha_e")?);
    let metric = "worst complex error of lift, k <= 1, AR 1e4";
    Ok(vec![Row::judged("aero.theodorsen_plunge", "Theodorsen 1935", metric, error, 0.025, "")])
}

fn theodorsen_pitch() -> Result<Vec<Row>, Error> {
    let table = reference_table!("analytic/theodorsen_pitch_2d.csv")?;
    let axes = table.column("a_semichords_from_midchord")?;
    let (ks, re, im) =
        (table.column("k")?, table.column("Re_CL_over_alpha0")?, table.column("Im_CL_over_alpha0")?);
    let mut errors = Vec::new();
    for axis in [-0.5, 0.0, 0.5] {
        let of_axis = |column: &[f64]| -> Vec<f64> {
            column.iter().zip(&axes).filter(|(_, a)| **a == axis).map(|(v, _)| *v).collect()
        };
        let ks = of_axis(&ks);
        let values = section_response(Motion::Pitch(-0.5 - 0.5 * axis), 0, &ks)?;
        errors.push(worst_response(&ks, &values, &of_axis(&re), &of_axis(&im)));
    }
    let metric = "worst complex error of lift, axes 1/4, 1/2, 3/4 chord, k <= 1, AR 1e4";
    Ok(vec![Row::judged("aero.theodorsen_pitch", "Theodorsen 1935", metric, worst(errors), 0.025, "")])
}
