//! The typical section: a wing of unlimited span on a plunge and a pitch spring in a wind tunnel.

use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix};
use wingbeat::aero::Aero;
use wingbeat::math::{Quat, Vec3};
use wingbeat::plant::{Linearisation, Plant};
use wingbeat::robot::{Air, Robot, Wind};
use wingbeat::scenario::Document;

use crate::Error;
use crate::aero_full::ComparedPreset;

/// Semi-chord b, m.
const B: f64 = TypicalSection::SEMI_CHORD;
/// Span, m; aspect ratio 1e5.
const SPAN: f64 = 1e5;
/// Density of the air, kg/m3: the wing weighs some kilograms.
const DENSITY: f64 = 1e-5;
/// Airspeed below which the models round off, m/s.
const LEAST_SPEED: f64 = 1e-6;
/// Radius of gyration about the elastic axis, squared, as a ratio to the square of the semi-chord.
pub const GYRATION2: f64 = 0.25;
/// Nodes or strips.
const NODES: usize = 12;

/// A typical section; frequencies in units of the uncoupled pitch frequency, which is 1 rad/s.
#[derive(Clone, Copy, Debug)]
pub struct TypicalSection {
    /// Mass ratio m / (pi rho b2) per unit span.
    pub mass_ratio: f64,
    /// Distance of the centre of mass behind the elastic axis, semi-chords.
    pub unbalance: f64,
    /// Ratio of the uncoupled plunge frequency to the pitch frequency.
    pub frequency_ratio: f64,
    /// Elastic axis behind the leading edge, chords.
    pub axis: f64,
}

impl TypicalSection {
    /// Semi-chord, m.
    pub const SEMI_CHORD: f64 = 0.5;

    /// Elastic axis behind mid chord, semi-chords.
    pub fn a(&self) -> f64 {
        2.0 * self.axis - 1.0
    }

    /// Mass of the air that the wing carries, kg.
    fn carried_air(&self) -> f64 {
        PI * DENSITY * B * B * SPAN
    }

    /// Mass (kg), static moment (kg m) and moment of inertia (kg m2) about the elastic axis.
    fn inertia(&self) -> [f64; 3] {
        let mass = self.mass_ratio * self.carried_air();
        [mass, mass * self.unbalance * B, mass * GYRATION2 * B * B]
    }

    /// Stiffnesses in plunge (N/m) and pitch (N m/rad).
    fn stiffness(&self) -> [f64; 2] {
        let [mass, _, inertia] = self.inertia();
        [mass * self.frequency_ratio.powi(2), inertia]
    }

    /// Speed of divergence, m/s: q S e a0 = K with e from the quarter chord to the axis and a0 = 2 pi.
    pub fn divergence_speed(&self) -> f64 {
        let arm = (self.axis - 0.25) * 2.0 * B;
        let q = self.stiffness()[1] / (2.0 * B * SPAN * arm * 2.0 * PI);
        (2.0 * q / DENSITY).sqrt()
    }

    /// Frequencies of the section with the air that it carries, rad/s, ascending.
    pub fn frequencies_with_carried_air(&self) -> [f64; 2] {
        let ([mass, moment, inertia], [plunge, pitch]) = (self.inertia(), self.stiffness());
        let (air, a) = (self.carried_air(), self.a());
        let (m, s, i) = (mass + air, moment - air * a * B, inertia + air * B * B * (0.125 + a * a));
        // (k_h - m w2)(k_a - i w2) = (s w2)2
        let (lead, middle, last) = (m * i - s * s, m * pitch + i * plunge, plunge * pitch);
        let root = (middle * middle - 4.0 * lead * last).sqrt();
        [-1.0, 1.0].map(|sign| ((middle + sign * root) / (2.0 * lead)).sqrt())
    }

    /// The robot file of the section on a body that nothing moves. The wing stands upright, so that
    /// its weight does no work.
    fn toml(&self) -> String {
        let ([mass, moment, inertia], [plunge, pitch]) = (self.inertia(), self.stiffness());
        let (aft, own) = (moment / mass, inertia - moment * moment / mass);
        let (ahead, behind) = (2.0 * B * self.axis, 2.0 * B * (self.axis - 1.0));
        format!(
            r#"
name = "typical_section"
body = {{ mass_kg = 1e15, inertia_kg_m2 = [1e25, 1e25, 1e25] }}
[[links]]
name = "plunge"
joint = "prismatic"
axis = [0.0, -1.0, 0.0]
elastic = {{ stiffness = {plunge:e} }}
[[links]]
name = "pitch"
parent = "plunge"
axis = [0.0, 0.0, -1.0]
mass_kg = {mass:e}
com_m = [{com:e}, 0.0, 0.0]
inertia_kg_m2 = [{own:e}, {own:e}, {own:e}]
elastic = {{ stiffness = {pitch:e} }}
[[surfaces]]
name = "wing"
span = "left"
planform = [
  {{ arc_m = 0.0, leading_edge_m = {ahead:e}, trailing_edge_m = {behind:e} }},
  {{ arc_m = {SPAN:e}, leading_edge_m = {ahead:e}, trailing_edge_m = {behind:e} }},
]
panels = [{{ link = "pitch", origin_m = [0.0, 0.0, {root:e}], direction = [0.0, 0.0, 1.0] }}]
"#,
            com = -aft,
            root = -0.5 * SPAN,
        )
    }

    /// Eigenvalues of springs and air in a wind of `speed` m/s, rad/s: the linearised robot, its body held.
    pub fn eigenvalues(&self, preset: ComparedPreset, speed: f64) -> Result<Vec<Complex<f64>>, Error> {
        let spec = Document::text("typical section", &self.toml())
            .and_then(|d| d.robot())
            .map_err(|e| Error::NoAnswer(e.to_string()))?;
        let model = |outline: wingbeat::robot::SurfaceOutline| {
            preset.model_of(NODES, &outline.planform, &outline.hinges, DENSITY, LEAST_SPEED)
        };
        let models: Vec<Aero> = spec.outlines()?.into_iter().map(model).collect::<Result<_, _>>()?;
        let air = Air { density: DENSITY, wind: Wind::steady(Vec3::new(-speed, 0.0, 0.0)) };
        let robot = Robot::new(&spec, models, air, 0.0)?;
        let (n, held) = (robot.states().len(), robot.layout().joints);
        let mut x = vec![0.0; n];
        Quat::IDENTITY.store_wxyz(&mut x[robot.layout().attitude..]);
        let mut exact = Linearisation::new(n, 0);
        exact.evaluate(&robot, 0.0, &x, &[])?;
        let free = n - held;
        let a = DMatrix::from_fn(free, free, |i, j| exact.a[(held + i) * n + held + j]);
        Ok(a.complex_eigenvalues().iter().copied().collect())
    }
}

/// Where `f` crosses zero upwards, in the caller's unit, between `low` and `high`.
///
/// # Errors
/// [`Error::NoAnswer`] when it does not.
pub fn crossing(
    mut f: impl FnMut(f64) -> Result<f64, Error>,
    mut low: f64,
    mut high: f64,
) -> Result<f64, Error> {
    if !(f(low)? < 0.0 && f(high)? > 0.0) {
        return Err(Error::NoAnswer(format!("no crossing between {low} and {high}")));
    }
    while high - low > 1e-9 * high {
        let middle = 0.5 * (low + high);
        if f(middle)? < 0.0 { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}
