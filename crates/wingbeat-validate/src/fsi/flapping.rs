//! A teardrop that heaves in water with an elastic plate behind it: thrust over stiffness as Heathcote & Gursul measured it.
//!
//! The library's chords are straight. The plate's lowest bending shape is replaced by the straight line that is closest to it, weighed
//! by the apparent mass of a flat plate: it turns about an elastic hinge behind the leading edge, with the stiffness and the inertia of
//! the shape.

use crate::aero_full::{ComparedPreset, SectionLaw};
use crate::{Case, ComparisonRow, Error, ReferenceTable, reference_table};
use nalgebra::Complex;
use std::f64::consts::{PI, TAU};
use wingbeat::aero::Aero;
use wingbeat::math::{Quat, RK4, Vec3, Workspace};
use wingbeat::plant::{Fault, Plant};
use wingbeat::robot::{Air, Robot, SurfaceOutline, Wind};
use wingbeat::scenario::Document;

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "fsi.flapping.linear", quick: true, run: linear },
    Case { id: "fsi.flapping.measured", quick: false, run: measured },
];

/// Water, kg/m3, its speed, m/s, chord, length of the plate behind its clamp and amplitude of the heave, m.
const DENSITY: f64 = 1000.0;
const SPEED: f64 = 0.1;
const CHORD: f64 = 0.09;
const PLATE: f64 = 0.06;
const HEAVE: f64 = 0.0175;
/// Steel: Young's modulus, Pa (Heathcote's), Poisson's ratio and density, kg/m3.
const MODULUS: f64 = 2.05e11;
const POISSON: f64 = 0.3;
const STEEL: f64 = 7800.0;
/// Span, m: plane flow, as between end plates.
const SPAN: f64 = 1e4 * CHORD;
/// Strips along it, which are all alike but for the tips.
const STRIPS: usize = 4;
/// First root of cos cosh = -1, the ratio of its shape, and the mean of the shape over the length for a tip of 1 (Blevins 1979).
const ROOT: f64 = 1.875_104_07;
const RATIO: f64 = 0.734_095_514;
const MEAN: f64 = 0.391_496;
/// Cycles, the last of which counts, and steps of each.
const CYCLES: usize = 8;
const STEPS: usize = 300;
/// Strouhal numbers at which plates are compared. Markers lie near by but at 0.345, where one plate is taken beyond its first marker (0.354)
/// and one between markers at 0.279 and 0.430.
const COMPARED: [f64; 5] = [0.345, 0.70, 0.79, 0.86, 0.92];

/// Thickness over the chord up to which a plate is not judged: the thinnest is near its resonance there, and a straight chord turns a third
/// more. *Choice.*
const NEAR_RESONANCE: f64 = 0.6e-3;

/// Height of the plate's lowest bending shape at `x` behind the leading edge (m), its tip 1.
fn shape(x: f64) -> f64 {
    let at = ROOT * ((x - (CHORD - PLATE)) / PLATE).max(0.0);
    0.5 * (at.cosh() - at.cos() - RATIO * (at.sinh() - at.sin()))
}

/// Slope (1/m) and zero (m behind the leading edge) of the line closest to the shape, with the weight sqrt(1 - u^2) of a flat plate's
/// apparent mass, u = 2 x/c - 1: by Chebyshev's nodes of the second kind.
fn line() -> [f64; 2] {
    let (count, mut sums) = (2000, [0.0; 4]);
    for i in 1..count {
        let angle = PI * i as f64 / count as f64;
        let (u, weight) = (angle.cos(), angle.sin().powi(2));
        let z = shape(0.5 * CHORD * (1.0 + u));
        for (sum, part) in sums.iter_mut().zip([1.0, u * u, z, z * u]) {
            *sum += weight * part;
        }
    }
    let (mean, slope) = (sums[2] / sums[0], sums[3] / sums[1]);
    [2.0 * slope / CHORD, 0.5 * CHORD * (1.0 - mean / slope)]
}

/// A plate of the thickness `thickness` (chords) that heaves by `heave` m at `strouhal` = 2 f a/U, a the measured amplitude.
#[derive(Clone, Copy)]
struct HeavingPlate {
    thickness: f64,
    strouhal: f64,
    heave: f64,
    section: SectionLaw,
}

/// What it does.
#[derive(Clone, Copy)]
struct PlateThrust {
    /// Mean thrust over 0.5 rho U^2 c.
    thrust: f64,
    /// Amplitude of the line from edge to edge, rad.
    pitch: f64,
}

impl HeavingPlate {
    fn frequency_hz(&self) -> f64 {
        self.strouhal * SPEED / (2.0 * HEAVE)
    }

    /// The robot file of a chord on a driven slide and an elastic hinge; as the wing stands upright, its weight does no work.
    fn toml(&self) -> String {
        let [slope, axis] = line();
        let b = self.thickness * CHORD;
        // Per metre of span, for a tip of 1: the shape's stiffness and mass.
        let stiffness =
            MODULUS * b.powi(3) / (12.0 * (1.0 - POISSON * POISSON)) * ROOT.powi(4) / (4.0 * PLATE.powi(3));
        let mass = STEEL * b * PLATE;
        let (stiffness, mass) = (SPAN * stiffness / slope.powi(2), SPAN * mass);
        let aft = MEAN / slope;
        let own = mass * (0.25 / slope.powi(2) - aft * aft);
        format!(
            r#"
name = "plate"
body = {{ mass_kg = 1e15, inertia_kg_m2 = [1e25, 1e25, 1e25] }}
[gait.fourier]
frequency_hz = {frequency:e}
[[links]]
name = "heave"
joint = "prismatic"
axis = [0.0, -1.0, 0.0]
driven = {{ harmonics = [{{ amplitude_rad = {heave:e} }}] }}
[[links]]
name = "plate"
parent = "heave"
axis = [0.0, 0.0, -1.0]
mass_kg = {mass:e}
com_m = [{com:e}, 0.0, 0.0]
inertia_kg_m2 = [{own:e}, {own:e}, {own:e}]
elastic = {{ stiffness = {stiffness:e} }}
[[surfaces]]
name = "wing"
span = "left"
planform = [
  {{ arc_m = 0.0, leading_edge_m = {axis:e}, trailing_edge_m = {behind:e} }},
  {{ arc_m = {SPAN:e}, leading_edge_m = {axis:e}, trailing_edge_m = {behind:e} }},
]
panels = [{{ link = "plate", origin_m = [0.0, 0.0, {root:e}], direction = [0.0, 0.0, 1.0] }}]
"#,
            frequency = self.frequency_hz(),
            heave = self.heave,
            com = -aft,
            behind = axis - CHORD,
            root = -0.5 * SPAN,
        )
    }

    fn robot(&self) -> Result<Robot, Error> {
        let spec = Document::text("plate", &self.toml())
            .and_then(|d| d.robot())
            .map_err(|e| Error::NoAnswer(e.to_string()))?;
        let model = |outline: SurfaceOutline| {
            let (wing, hinges) = (&outline.planform, &outline.hinges);
            ComparedPreset::Full.model_with(self.section, STRIPS, wing, hinges, DENSITY, 1e-3 * SPEED)
        };
        let models: Vec<Aero> = spec.outlines()?.into_iter().map(model).collect::<Result<_, _>>()?;
        let air = Air { density: DENSITY, wind: Wind::steady(Vec3::new(-SPEED, 0.0, 0.0)) };
        Ok(Robot::new(&spec, models, air, 0.0)?)
    }

    /// The last of its cycles, its body held.
    fn answer(&self) -> Result<PlateThrust, Error> {
        let robot = self.robot()?;
        let (n, held) = (robot.states().len(), robot.layout().joints);
        let mut x = vec![0.0; n];
        Quat::IDENTITY.store_wxyz(&mut x[robot.layout().attitude..]);
        let rates = |t: f64, x: &[f64], dx: &mut [f64]| -> Result<(), Fault> {
            robot.rates_in_numbers(t, x, &[], dx)?;
            dx[..held].fill(0.0);
            Ok(())
        };
        let step = self.frequency_hz().recip() / STEPS as f64;
        let mut work = Workspace::new(n, RK4.b.len());
        let (mut thrust, mut turn) = (0.0, Complex::new(0.0, 0.0));
        for i in 0..CYCLES * STEPS {
            let t = i as f64 * step;
            if i >= (CYCLES - 1) * STEPS {
                thrust += robot.observe(t, &x, &[])?.air.total().force[0] / STEPS as f64;
                turn += Complex::from_polar(2.0 / STEPS as f64, -TAU * i as f64 / STEPS as f64) * x[held];
            }
            RK4.step(rates, t, step, &mut x, &mut work)?;
        }
        // The tip's height is the turn over the slope of the line.
        let pitch = turn.norm() / (line()[0] * CHORD);
        Ok(PlateThrust { thrust: thrust / (0.5 * DENSITY * SPEED * SPEED * CHORD * SPAN), pitch })
    }
}

/// Root of the mean square of the differences over that of what is right.
fn rms(pairs: &[(f64, f64)]) -> f64 {
    let [error, size] = pairs.iter().fold([0.0; 2], |[error, size], (value, right)| {
        [error + (value - right).powi(2), size + right * right]
    });
    (error / size).sqrt()
}

/// Small heave against the whole plate in linear theory.
fn linear() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("flapping/plate.csv")?;
    let [thickness, strouhal] = [table.column("thickness")?, table.column("strouhal")?];
    let [thrust, pitch] = [table.column("thrust")?, table.column("pitch_deg")?];
    let small = 0.01;
    let (mut thrusts, mut pitches) = (Vec::new(), Vec::new());
    for i in 0..table.len() {
        let plate = HeavingPlate {
            thickness: thickness[i],
            strouhal: strouhal[i],
            heave: small * HEAVE,
            section: SectionLaw::INVISCID,
        };
        let found = plate.answer()?;
        thrusts.push((found.thrust / (small * small), thrust[i]));
        pitches.push((found.pitch.to_degrees() / small, pitch[i]));
    }
    let source = "an elastic plate in linear theory, validation/flapping/plate.py";
    let stiffer = |pairs: &[(f64, f64)]| {
        let kept = pairs.iter().zip(&thickness).filter(|(_, b)| **b > NEAR_RESONANCE);
        rms(&kept.map(|(pair, _)| *pair).collect::<Vec<_>>())
    };
    let what = |of: &str, plates: usize| {
        format!(
            "rms error of {of} over its rms, small heave, law linear, {plates} plates, St 0.273 and 0.345"
        )
    };
    let mut rows = Vec::new();
    for (id, of, pairs) in [("", "thrust", &thrusts), (".pitch", "pitch amplitude", &pitches)] {
        let id = format!("fsi.flapping.linear{id}");
        rows.push(ComparisonRow::judged(&id, source, &what(of, 6), stiffer(pairs), 0.1, ""));
        rows.push(ComparisonRow::shown(&format!("{id}.all"), source, &what(of, 7), rms(pairs), ""));
    }
    Ok(rows)
}

/// Curves over the Strouhal number, one for each thickness.
struct Curves(Vec<(f64, Vec<[f64; 2]>)>);

impl Curves {
    fn of(table: &ReferenceTable, name: &str) -> Result<Self, Error> {
        let (thickness, strouhal) = (table.column("thickness")?, table.column("strouhal")?);
        let value = table.column(name)?;
        let mut curves: Vec<(f64, Vec<[f64; 2]>)> = Vec::new();
        for i in 0..table.len() {
            if curves.last().is_none_or(|last| last.0 != thickness[i]) {
                curves.push((thickness[i], Vec::new()));
            }
            if let Some((_, points)) = curves.last_mut() {
                points.push([strouhal[i], value[i]]);
            }
        }
        Ok(Self(curves))
    }

    /// Another value at each point.
    fn with(&self, of: impl Fn(f64, f64) -> Result<f64, Error>) -> Result<Self, Error> {
        let curve = |(thickness, points): &(f64, Vec<[f64; 2]>)| {
            let point = |[strouhal, _]: &[f64; 2]| Ok([*strouhal, of(*thickness, *strouhal)?]);
            Ok((*thickness, points.iter().map(point).collect::<Result<_, Error>>()?))
        };
        Ok(Self(self.0.iter().map(curve).collect::<Result<_, Error>>()?))
    }

    /// Values of all points beside those of another set of the same points.
    fn beside(&self, other: &Self) -> Vec<(f64, f64)> {
        let pairs = self.0.iter().zip(&other.0).flat_map(|(one, two)| one.1.iter().zip(&two.1));
        pairs.map(|(one, two)| (one[1], two[1])).collect()
    }

    /// Thickness and thrust over St^2 of each plate at `strouhal`, linear between the markers.
    fn at(&self, strouhal: f64) -> Vec<[f64; 2]> {
        let scaled = |[s, thrust]: [f64; 2]| [s, thrust / (s * s)];
        let value = |points: &[[f64; 2]]| {
            let above = points.iter().position(|p| p[0] > strouhal).unwrap_or(points.len() - 1).max(1);
            let ([a, low], [b, high]) = (scaled(points[above - 1]), scaled(points[above]));
            low + (high - low) * (strouhal - a) / (b - a)
        };
        self.0.iter().map(|(thickness, points)| [*thickness, value(points)]).collect()
    }
}

/// Place of the most thrust over the thickness: the vertex of the parabola through the best plate and its neighbours, over the
/// logarithm of the thickness; the plate itself at an end.
fn best(curve: &[[f64; 2]]) -> f64 {
    let top = (0..curve.len()).max_by(|i, j| curve[*i][1].total_cmp(&curve[*j][1])).unwrap_or(0);
    if top == 0 || top + 1 == curve.len() {
        return curve[top][0];
    }
    let [a, b, c] = [top - 1, top, top + 1].map(|i| [curve[i][0].ln(), curve[i][1]]);
    let (left, right) = ((b[1] - a[1]) / (b[0] - a[0]), (c[1] - b[1]) / (c[0] - b[0]));
    // Zero of the slope, which is linear between the middles of the intervals.
    let (low, high) = (0.5 * (a[0] + b[0]), 0.5 * (b[0] + c[0]));
    (low + (high - low) * left / (left - right)).exp()
}

/// Place of the most thrust (thousandths of the chord), thrust coefficients of the best plate and of the stiffest.
fn summary(curve: &[[f64; 2]], strouhal: f64) -> String {
    let most = curve.iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max);
    let stiffest = curve.last().map_or(f64::NAN, |p| p[1]);
    let square = strouhal * strouhal;
    format!("{:.2} (C_T {:.2}, stiffest {:.2})", 1e3 * best(curve), most * square, stiffest * square)
}

/// The measured plates under two laws, the linear one without drag.
fn measured() -> Result<Vec<ComparisonRow>, Error> {
    let source = "Heathcote & Gursul 2007, measured (validation/flapping)";
    let thrust = Curves::of(&reference_table!("flapping/thrust.csv")?, "thrust")?;
    let pitch = Curves::of(&reference_table!("flapping/pitch.csv")?, "pitch_deg")?;
    let mut rows = Vec::new();
    for (law, section) in [("linear", SectionLaw::INVISCID), ("lev", SectionLaw::PLATE)] {
        let answer =
            |thickness, strouhal| HeavingPlate { thickness, strouhal, heave: HEAVE, section }.answer();
        let thrusts = thrust.with(|b, s| Ok(answer(b, s)?.thrust))?;
        let pitches = pitch.with(|b, s| Ok(answer(b, s)?.pitch.to_degrees()))?;
        let mut show = |id: &str, what: String, value: f64| {
            let id = format!("fsi.flapping.measured.{law}{id}");
            rows.push(ComparisonRow::shown(&id, source, &format!("{what}, law {law}"), value, ""));
        };
        let (off, turned) = (rms(&thrusts.beside(&thrust)), rms(&pitches.beside(&pitch)));
        show("", "rms error of thrust over its rms, 5 plates, St 0.1 to 1".into(), off);
        show(".pitch", "rms error of the pitch amplitude over its rms, 4 plates, St 0.1 to 1".into(), turned);
        let mut sum = 0.0;
        for strouhal in COMPARED {
            let (own, right) = (thrusts.at(strouhal), thrust.at(strouhal));
            let off = (best(&own) / best(&right) - 1.0).abs();
            sum += off / COMPARED.len() as f64;
            let what = format!(
                "error of the thickness of most thrust at St {strouhal}: {}, measured {} (thousandths of the chord; goal: 0.2)",
                summary(&own, strouhal),
                summary(&right, strouhal)
            );
            show(&format!(".{strouhal}"), what, off);
        }
        show(".optimum", "mean error of the thickness of most thrust (goal: 0.2)".into(), sum);
    }
    Ok(rows)
}
