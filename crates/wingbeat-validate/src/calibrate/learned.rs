//! What a fitted model leaves of the loads of a robot on the stand, learned by phase and velocity, to be flown beside it.

use super::flight::{Calibrated, TRUTH, aero, of_law};
use super::{all_clean, measured, no_answer, shipped, truth};
use crate::Error;
use nalgebra::DMatrix;
use std::path::Path;
use wingbeat::math::{Mat3, Vec3, Wrench};
use wingbeat_calibrate::{Layout, Model};

/// Speeds of the wind, m/s, and pitches, deg, of the stands: about those of the turn. *Choice.*
const SPEEDS: [f64; 3] = [4.2, 4.8, 5.4];
const PITCHES: [f64; 3] = [-20.0, -8.0, 4.0];
/// Channels that do not vanish where both wings are alike and the air comes from ahead.
const LONGITUDINAL: [usize; 3] = [0, 2, 4];
/// Functions of the velocity.
const FUNCTIONS: usize = 6;

/// Forward speed u and upward speed w of the body against the air, in B: 1, u, w, u2, u w, w2.
fn functions(u: f64, w: f64) -> [f64; FUNCTIONS] {
    [1.0, u, w, u * u, u * w, w * w]
}

/// A wrench on the body by phase of the stroke and velocity against the air, as the cell shows it after its resonance and filter. A
/// *fit*; its form is a *choice*.
pub(super) struct Learned {
    layout: Layout,
    /// `gait.phase_rad` of the fit, rad: by the model the gait is that far ahead of the encoder, at whose zero the cell's cycles begin.
    lag: f64,
    /// By longitudinal channel, part of the cycle, function of the velocity.
    coefficients: Vec<[f64; FUNCTIONS]>,
    /// What it leaves of what was measured beyond the model on a stand that is left out: share of the rms.
    pub left: f64,
}

/// Overrides that put the robot that flies on nine stands, its gait at `frequency` (Hz), on a cell without bias and drift: a tare would
/// take what the wind does to the wings at rest away.
fn stands(frequency: f64) -> [String; 2] {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let (run, robot) =
        (root.join("rigs/identification/still_air.toml"), root.join("robots/cruise_beta_lev.toml"));
    let stand = |speed: f64, pitch: f64| {
        let set = [
            format!("rig.robot={}", robot.display()),
            "rig.cell.calibration=SI-50-0.5".into(),
            "rig.cell.bias=[0, 0, 0, 0, 0, 0]".into(),
            "rig.cell.drift_per_s=[0, 0, 0, 0, 0, 0]".into(),
            "process.steps.tare=false".into(),
            format!("frequency_hz={frequency}"),
            "hold.each_s=3.0".into(),
            format!("hold.tilts_deg=[[0.0, {pitch:?}]]"),
            format!("wind_m_s=[{:?}, 0.0, 0.0]", -speed),
        ];
        format!(
            "{{ name = \"{speed} m/s, {pitch} deg\", run = {:?}, set = {set:?} }}",
            run.display().to_string()
        )
    };
    let all = SPEEDS.iter().flat_map(|speed| PITCHES.iter().map(move |pitch| stand(*speed, *pitch)));
    [format!("runs=[{}]", all.collect::<Vec<_>>().join(", ")), "truth.passes=2".into()]
}

impl Learned {
    /// From what the cell shows on nine stands, less what the fitted model says of them.
    ///
    /// # Errors
    /// Stands that cannot be simulated.
    pub fn new(model: &Calibrated, frequency: f64) -> Result<Self, Error> {
        let on_rig = |keys: [String; 2]| keys.map(|key| format!("rig.{key}"));
        let [runs, passes] = stands(frequency);
        let truth_is = format!("truth.set={:?}", on_rig(aero(TRUTH)));
        let mut calibration =
            shipped("seven_runs.toml", &["structures=[]", "starts=1", &truth_is, &runs, &passes])?;
        let targets = truth(&calibration)?;
        let observed = measured(&calibration, &targets, &all_clean(&targets)?, 1)?;
        calibration.spec.parameters.extend(of_law(model.structure[1]));
        let own = calibration.structure(&on_rig(aero(model.structure)), &|_, _| None).map_err(no_answer)?;
        let layout = observed[0].layout;
        let mut left = Vec::new();
        for (run, observed) in observed.iter().enumerate() {
            let said = own.model.predict(run, &model.values).map_err(no_answer)?;
            left.push(observed.mean.iter().zip(said).map(|(is, said)| is - said).collect::<Vec<f64>>());
        }
        let velocity = |speed: f64, pitch: f64| {
            let attitude = Mat3::<f64>::from_roll_pitch_yaw(0.0, pitch.to_radians(), 0.0);
            attitude.transpose_mul(Vec3([speed, 0.0, 0.0]))
        };
        let points: Vec<[f64; FUNCTIONS]> = SPEEDS
            .iter()
            .flat_map(|speed| PITCHES.iter().map(move |pitch| velocity(*speed, *pitch)))
            .map(|v| functions(v[0], v[2]))
            .collect();
        let matrix = DMatrix::from_fn(points.len(), FUNCTIONS, |i, j| points[i][j]);
        let inverse = matrix.pseudo_inverse(1e-9).map_err(no_answer)?;
        // A stand left out is missed by r/(1 - h), r what is left of it, h its own weight in what is said of it.
        let weight_of = |i: usize| (0..FUNCTIONS).map(|j| points[i][j] * inverse[(j, i)]).sum::<f64>();
        let (mut coefficients, mut rest, mut whole) = (Vec::new(), 0.0, 0.0);
        for channel in LONGITUDINAL {
            // For the share that is left, 1 N and .1 N m are alike.
            let weight = if channel < 3 { 1.0 } else { 10.0 };
            for part in 0..layout.width() {
                let values: Vec<f64> = left.iter().map(|left| left[layout.at(channel, part)]).collect();
                let of: [f64; FUNCTIONS] = std::array::from_fn(|j| {
                    values.iter().enumerate().map(|(i, value)| inverse[(j, i)] * value).sum()
                });
                for (i, (value, point)) in values.iter().zip(&points).enumerate() {
                    let said: f64 = of.iter().zip(point).map(|(a, b)| a * b).sum();
                    rest += (weight * (value - said) / (1.0 - weight_of(i))).powi(2) * Layout::share(part);
                    whole += (weight * value).powi(2) * Layout::share(part);
                }
                coefficients.push(of);
            }
        }
        let named = model.parameters.iter().zip(&model.values);
        let lag =
            named.filter(|(parameter, _)| parameter.name == "gait.phase_rad").map(|(_, lag)| *lag).sum();
        Ok(Self { layout, lag, coefficients, left: (rest / whole).sqrt() })
    }

    /// The wrench about the body's origin, in B, at a phase of the gait and a velocity against the air in B.
    pub fn wrench(&self, phase: f64, velocity: Vec3) -> Wrench<f64> {
        let by = functions(velocity[0], velocity[2]);
        let [x, z, turning] = std::array::from_fn(|k| {
            let width = self.layout.width();
            let part = |part: usize| -> f64 {
                let of = &self.coefficients[k * width + part];
                Layout::wave(part, phase - self.lag) * of.iter().zip(by).map(|(a, b)| a * b).sum::<f64>()
            };
            (0..width).map(part).sum::<f64>()
        });
        Wrench { force: Vec3([x, 0.0, z]), moment: Vec3([0.0, turning, 0.0]) }
    }
}
