//! Large flapping: the research script's output, the cycle mean of the added-mass
//! force, and a free-wake lattice.

use super::wings::rectangle;
use super::{ComparedPreset, STRIPS};
use std::ops::ControlFlow;

use crate::{ComparisonRow, Error, reference_table};
use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;
use wingbeat::aero::{Loads, Planform};
use wingbeat::math::{Vec3, Wrench};
use wingbeat::simulate::{Held, Moment, Observed, Stepper};
use wingbeat::tether::{Clock, CoefficientScales, Coordinate, Hinge, HingeKind, Motion, Side, Tether, Wing};

/// Flapping frequency of all cases, Hz.
const FREQUENCY: f64 = 3.5;
/// Chord of all wings, m.
const CHORD: f64 = 0.08;
/// Speed of the wind, m/s.
const SPEED: f64 = 1.5;

/// Reduced frequency pi f c / U of all cases.
pub fn reduced_frequency() -> f64 {
    PI * FREQUENCY * CHORD / SPEED
}

/// A flapping rectangular wing in a wind at 5 degrees.
pub struct Flap {
    half_span: f64,
    amplitude_deg: f64,
    /// Arc of the elbow over the half span, and how far the outer panel folds down, degrees.
    fold: Option<(f64, f64)>,
}

/// Small flapping.
pub const F1: Flap = Flap { half_span: 0.2, amplitude_deg: 5.0, fold: None };
/// Large flapping.
pub const F2: Flap = Flap { half_span: 0.2, amplitude_deg: 35.0, fold: None };
/// Flapping with the outer panel folded down in the upstroke.
pub const E1: Flap = Flap { half_span: 0.25, amplitude_deg: 30.0, fold: Some((0.45, 50.0)) };

impl Flap {
    fn wing(&self) -> Result<Planform, Error> {
        rectangle(2.0 * self.half_span, CHORD)
    }

    fn incidence() -> f64 {
        5_f64.to_radians()
    }

    /// The tethered wing with the model of `preset`.
    pub fn tether(&self, preset: ComparedPreset, steps: usize) -> Result<Tether, Error> {
        self.tether_of(preset, STRIPS, steps)
    }

    /// The same with another number of strips or nodes.
    pub(crate) fn tether_of(
        &self,
        preset: ComparedPreset,
        strips: usize,
        steps: usize,
    ) -> Result<Tether, Error> {
        let harmonic = |mean: f64, cos: f64, sin: f64| Coordinate::Fourier {
            frequency_hz: FREQUENCY,
            mean: mean.to_radians(),
            cos: vec![cos.to_radians()],
            sin: vec![sin.to_radians()],
        };
        let hinge = |kind, arc_m| Hinge { kind, side: Side::Both, arc_m, to_arc_m: None, ahead_m: 0.0 };
        let mut hinges = vec![hinge(HingeKind::Flap, 0.0)];
        let mut angles = vec![("shoulder".to_string(), harmonic(0.0, 0.0, self.amplitude_deg))];
        if let Some((place, down)) = self.fold {
            hinges.push(hinge(HingeKind::Fold, place * self.half_span));
            angles.push(("elbow".into(), harmonic(-0.5 * down, -0.5 * down, 0.0)));
        }
        let arcs: Vec<f64> = hinges.iter().map(|h| h.arc_m).filter(|arc| *arc > 0.0).collect();
        let aero = preset.model_of(strips, &self.wing()?, &arcs, 1.225, 0.02)?;
        let alpha = Self::incidence();
        Ok(Tether {
            wing: Wing::new(self.wing()?, hinges)?,
            motion: Motion { hinges: angles, ..Motion::at_rest() },
            aero,
            wind: Vec3::new(-alpha.cos(), 0.0, alpha.sin()) * SPEED,
            side: Side::Both,
            reference: CoefficientScales {
                density_kg_m3: 1.225,
                speed_m_s: SPEED,
                area_m2: 2.0 * CHORD * self.half_span,
                chord_m: CHORD,
            },
            clock: Clock { frequency_hz: FREQUENCY, cycles: 3, steps_per_cycle: steps },
            spar: None,
            ground: None,
        })
    }
}

/// Loads of the last cycle, from phase 0.
pub fn last_cycle(tether: &Tether) -> Result<Vec<Loads<f64>>, Error> {
    let clock = tether.clock;
    let last = clock.steps() - clock.steps_per_cycle..clock.steps();
    let mut kept = Vec::with_capacity(clock.steps_per_cycle);
    let mut keep = Held(|step: usize, at: Moment| {
        if last.contains(&step) {
            kept.push(tether.observed(at)?);
        }
        Ok(ControlFlow::Continue(()))
    });
    let mut stepper = Stepper::new(tether, 0.0, &tether.start());
    stepper.run(clock.step(), clock.steps(), &mut keep).check()?;
    Ok(kept)
}

/// Part of a load in the frame of the tables (x aft, z up), N.
type LoadPart = (&'static str, fn(&Loads<f64>) -> f64);

fn circulatory(loads: &Loads<f64>) -> Wrench<f64> {
    let sources = loads.by_source();
    sources.circulatory + sources.induced_drag
}

const PARTS: [LoadPart; 5] = [
    ("Fx", |l| -l.wrench.force[0]),
    ("Fz", |l| l.wrench.force[2]),
    ("Fcx", |l| -circulatory(l).force[0]),
    ("Fcz", |l| circulatory(l).force[2]),
    ("Faz", |l| l.by_source().added_mass.force[2]),
];

/// A force over the cycle beside the research script's.
#[derive(Clone, Debug)]
pub struct ForceComparison {
    /// `F2` or `E1`.
    pub case: &'static str,
    /// Column of the table: x aft, z up; c circulatory, a added mass.
    pub part: &'static str,
    /// Phase, cycles.
    pub phase: Vec<f64>,
    /// The model, N.
    pub value: Vec<f64>,
    /// The script, N.
    pub exact: Vec<f64>,
}

impl ForceComparison {
    /// Rms difference over rms.
    pub fn error(&self) -> f64 {
        let difference = self.value.iter().zip(&self.exact).map(|(value, exact)| (value - exact).powi(2));
        (difference.sum::<f64>() / self.exact.iter().map(|exact| exact.powi(2)).sum::<f64>()).sqrt()
    }
}

/// Forces of F2 and E1 and their parts, where the script has them.
///
/// # Errors
/// [`Error`] when a table or the model fails.
pub fn oracle_series(preset: ComparedPreset) -> Result<Vec<ForceComparison>, Error> {
    let steps = 192;
    let cases = [
        ("F2", F2, reference_table!("strip_model/strip_model_F2.csv")?),
        ("E1", E1, reference_table!("strip_model/strip_model_E1.csv")?),
    ];
    let mut series = Vec::new();
    for (case, flap, table) in cases {
        let cycle = last_cycle(&flap.tether(preset, steps)?)?;
        let stride = cycle.len() / table.len();
        for (part, of) in PARTS {
            series.push(ForceComparison {
                case,
                part,
                phase: table.column("phase")?,
                value: cycle.iter().step_by(stride).map(of).collect(),
                exact: table.column(part)?,
            });
        }
    }
    Ok(series)
}

/// The worst of the forces of F2 and E1 and their parts.
pub fn oracle() -> Result<Vec<ComparisonRow>, Error> {
    let worst = oracle_series(ComparedPreset::Turned)?.iter().map(ForceComparison::error).fold(0.0, f64::max);
    let metric = "F2 and E1, the impulse of the circulation turning as in the script: worst rms error of force and its parts over their rms";
    Ok(vec![ComparisonRow::judged(
        "aero.full.oracle",
        "research script of the strip model",
        metric,
        worst,
        0.01,
        "",
    )])
}

/// Upward added-mass force of the wing over the last cycle of F2 and of E1, N.
///
/// # Errors
/// [`Error`] when the model cannot be built.
pub fn added_mass_lift(preset: ComparedPreset) -> Result<[(&'static str, Vec<f64>); 2], Error> {
    let lift = |flap: &Flap| -> Result<Vec<f64>, Error> {
        let cycle = last_cycle(&flap.tether(preset, 192)?)?;
        Ok(cycle.iter().map(|l| l.by_source().added_mass.force[2]).collect())
    };
    Ok([("F2", lift(&F2)?), ("E1", lift(&E1)?)])
}

/// Cycle mean of the added-mass force over its amplitude: of the sum for the strip
/// model, of the worst strip for the paper's.
pub fn added_mass_mean(preset: ComparedPreset) -> Result<Vec<ComparisonRow>, Error> {
    let mut worst: f64 = 0.0;
    for flap in [F2, E1] {
        let cycle = last_cycle(&flap.tether(preset, 192)?)?;
        let strip = |i: usize| mean_over_amplitude(&cycle, |l| l.strip[i].added_mass.force);
        worst = worst.max(match preset {
            ComparedPreset::Paper => (0..STRIPS).map(strip).fold(0.0, f64::max),
            _ => mean_over_amplitude(&cycle, |l| l.by_source().added_mass.force),
        });
    }
    let (of, limit) = if preset == ComparedPreset::Paper { ("worst strip", 1e-6) } else { ("wing", 0.01) };
    let metric = format!("F2 and E1: mean added-mass force of the {of} over its amplitude");
    Ok(vec![ComparisonRow::judged(
        &preset.id("added_mass_mean"),
        "momentum of the air",
        &metric,
        worst,
        limit,
        "",
    )])
}

fn mean_over_amplitude(cycle: &[Loads<f64>], of: impl Fn(&Loads<f64>) -> Vec3) -> f64 {
    let sum = cycle.iter().fold(Vec3::ZERO, |sum, l| sum + of(l));
    let largest = cycle.iter().map(|l| of(l).norm()).fold(0.0, f64::max);
    sum.norm() / cycle.len() as f64 / largest
}

/// Lift of F1 over the cycle, N.
///
/// # Errors
/// [`Error`] when the model cannot be built.
pub fn small_flap_lift(preset: ComparedPreset) -> Result<Vec<f64>, Error> {
    let alpha = Flap::incidence();
    let up = Vec3::new(alpha.sin(), 0.0, alpha.cos());
    Ok(last_cycle(&F1.tether(preset, 192)?)?.iter().map(|l| l.wrench.force.dot(up)).collect())
}

/// Lift of the lattice over its last cycle, N.
///
/// # Errors
/// [`Error`] when the table lacks it.
pub fn lattice_lift() -> Result<Vec<f64>, Error> {
    let table = reference_table!("uvlm/flap_F1_R0.20_phi5_a5_free.csv")?;
    let lift = table.column("lift_N")?;
    Ok(lift[lift.len() - 48..].to_vec())
}

/// Peak and mean lift of F1 against PteraSoftware's free wake, which is 10 to 13 % high: its
/// vortex core also acts on bound rings (against the linear lifting surface it errs by 6 to
/// 15 % in plunge and by 4 to 9 % in a sudden start).
pub fn lattice(preset: ComparedPreset) -> Result<Vec<ComparisonRow>, Error> {
    let (value, exact) = (small_flap_lift(preset)?, lattice_lift()?);
    let name = match preset {
        ComparedPreset::Full => "aero.uvlm_small_flap".to_string(),
        _ => preset.id("uvlm_small_flap"),
    };
    let (mean, peak) = first_harmonics(&value);
    let (exact_mean, exact_peak) = first_harmonics(&exact);
    let (mean, peak) = (mean / exact_mean - 1.0, peak / exact_peak - 1.0);
    let metric = format!(
        "worst error of lift over the cycle: peak {:+.1} %, mean {:+.1} %",
        100.0 * peak,
        100.0 * mean
    );
    Ok(vec![preset.row(&name, "PteraSoftware 5.1.0, free wake", &metric, peak.abs().max(mean.abs()), 0.15)])
}

/// Mean, and the largest value of mean and first three harmonics.
fn first_harmonics(v: &[f64]) -> (f64, f64) {
    let n = v.len() as f64;
    let mean = v.iter().sum::<f64>() / n;
    let wave = |order: usize, phase: f64| -> f64 {
        let step = 2.0 * PI * order as f64 / n;
        v.iter().enumerate().map(|(i, y)| 2.0 / n * y * (step * i as f64 - phase).cos()).sum()
    };
    let at = |t: f64| -> f64 {
        let harmonic = |order: usize| {
            let angle = 2.0 * PI * order as f64 * t;
            wave(order, 0.0) * angle.cos() + wave(order, FRAC_PI_2) * angle.sin()
        };
        mean + (1..=3).map(harmonic).sum::<f64>()
    };
    (mean, (0..360).map(|i| at(f64::from(i) / 360.0)).fold(f64::MIN, f64::max))
}
