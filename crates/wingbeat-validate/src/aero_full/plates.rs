//! Measured plates past their stall: a rigid one at rest in the wind, and one pitched fast.

use super::flapping::last_cycle;
use super::wings::rectangle;
use super::{ComparedPreset, STRIPS, SectionLaw};
use crate::curve::{START, SampledCurve, eldredge};
use crate::{ComparisonRow, Error, reference_table};
use wingbeat::aero::Loads;
use wingbeat::math::{CubicSpline, Vec3};
use wingbeat::tether::{Clock, CoefficientScales, Coordinate, Motion, Side, Tether, Wing};

/// Airspeed and chord of the rigid plate, m/s and m.
const SPEED: f64 = 5.0;
const CHORD: f64 = 0.0688;
const DENSITY: f64 = 1.208;

/// Force coefficients [forward, up] of a flat rectangle of that aspect ratio in unsteady or steady motion.
fn coefficients(loads: &Loads<f64>, reference: CoefficientScales) -> [f64; 2] {
    let CoefficientScales { density_kg_m3, speed_m_s, area_m2, .. } = reference;
    let scale = 0.5 * density_kg_m3 * speed_m_s * speed_m_s * area_m2;
    [loads.wrench.force[0] / scale, loads.wrench.force[2] / scale]
}

/// Share of the wind below which speeds are rounded off.
const FLOOR: f64 = 0.004;

/// A flat rectangular plate that pitches nose up about its leading edge, or stands at an incidence.
fn pitching(
    section: SectionLaw,
    [aspect, chord, speed, density]: [f64; 4],
    nose_up: Coordinate,
    clock: Clock,
) -> Result<Tether, Error> {
    let planform = rectangle(aspect * chord, chord)?;
    let aero = ComparedPreset::Full.model_with(section, STRIPS, &planform, &[], density, FLOOR * speed)?;
    Ok(Tether {
        aero,
        motion: Motion { nose_up, ..Motion::at_rest() },
        wind: Vec3::new(-speed, 0.0, 0.0),
        side: Side::Both,
        reference: CoefficientScales {
            density_kg_m3: density,
            speed_m_s: speed,
            area_m2: planform.area(),
            chord_m: chord,
        },
        clock,
        spar: None,
        ground: None,
        wing: Wing::new(planform, Vec::new())?,
    })
}

/// Chords of travel over which the force of a plate set into the wind at once is averaged, after three times as many.
const AVERAGED: f64 = 20.0;

/// Normal force coefficient of a plate at rest at the incidence `alpha_deg`.
///
/// # Errors
/// [`Error`] when the model cannot be built.
pub fn steady_normal_force(section: SectionLaw, aspect: f64, alpha_deg: f64) -> Result<f64, Error> {
    let alpha = alpha_deg.to_radians();
    let clock = Clock { frequency_hz: SPEED / CHORD / AVERAGED, cycles: 4, steps_per_cycle: 100 };
    let tether = pitching(section, [aspect, CHORD, SPEED, DENSITY], Coordinate::Constant(alpha), clock)?;
    let cycle = last_cycle(&tether)?;
    let normal = |loads: &Loads<f64>| {
        let [forward, up] = coefficients(loads, tether.reference);
        up * alpha.cos() - forward * alpha.sin()
    };
    Ok(cycle.iter().map(normal).sum::<f64>() / cycle.len() as f64)
}

/// Lift and drag coefficients over the chords of travel of a plate of AR 4 that pitches by 45 degrees.
pub struct Ramp {
    /// Chords of travel from the start of the motion.
    pub travel: Vec<f64>,
    /// Lift coefficients.
    pub lift: Vec<f64>,
    /// Drag coefficients.
    pub drag: Vec<f64>,
}

/// Where the measured lift has the peaks of the acceleration (0.24) and its dip that of the deceleration (1.25).
const LATER: f64 = 0.24;
/// Chords of travel in which the plate's acceleration makes lift: points of the measurement around its peak and its dip. *Choice.*
const PULSES: [[f64; 2]; 2] = [[0.0, 0.36], [1.05, 1.36]];
/// Chords of travel over which lift is averaged: a point, and the width of the measured peaks.
const POINT: f64 = 1e-3;
const QUARTER: f64 = 0.25;
/// Chords of travel that are computed, and steps in each.
const TRAVEL: f64 = 3.0;
const STEPS: usize = 200;

/// The plate pitched by Eldredge's ramp, its corner `start` chords of travel after the beginning.
///
/// # Errors
/// [`Error`] when the model cannot be built.
pub fn fast_pitch(section: SectionLaw, start: f64) -> Result<Ramp, Error> {
    let (chord, speed) = (0.0762, 0.26);
    // A chord of travel before the motion, in which nothing happens.
    let knots: Vec<f64> = (0..=(TRAVEL * STEPS as f64) as usize).map(|k| k as f64 / STEPS as f64).collect();
    let (times, angles): (Vec<f64>, Vec<f64>) =
        knots.iter().map(|s| (s * chord / speed, eldredge(s - 0.5, start).0)).unzip();
    let nose_up = Coordinate::Table(CubicSpline::natural(&times, &angles)?);
    let clock = Clock {
        frequency_hz: speed / chord / TRAVEL,
        cycles: 1,
        steps_per_cycle: (TRAVEL * STEPS as f64) as usize,
    };
    let tether = pitching(section, [4.0, chord, speed, 1000.0], nose_up, clock)?;
    let loads = last_cycle(&tether)?;
    let travel = (0..loads.len()).map(|k| k as f64 / STEPS as f64 - 0.5).collect();
    let (forward, lift): (Vec<f64>, Vec<f64>) =
        loads.iter().map(|l| coefficients(l, tether.reference).into()).unzip();
    Ok(Ramp { travel, lift, drag: forward.iter().map(|x| -x).collect() })
}

const PLATE_SOURCE: &str = "Rojratsirikul et al. 2011, measured";
const RAMP_SOURCE: &str = "Mancini et al. 2017, measured";

/// Least incidence that counts, degrees: below it the reading is uncertain by more than a tenth.
const LEAST: f64 = 4.0;

/// Mean |error| of the normal force over the measured one at both speeds, of the incidences that `counts`.
fn plate_error(section: SectionLaw, counts: impl Fn(f64) -> bool) -> Result<f64, Error> {
    let table = reference_table!("plates/normal_force_ar2.csv")?;
    let (alpha, slow, fast) =
        (table.column("alpha_deg")?, table.column("cn_5_m_s")?, table.column("cn_10_m_s")?);
    let (mut sum, mut count) = (0.0, 0.0);
    for i in (0..alpha.len()).filter(|&i| alpha[i] >= LEAST && counts(alpha[i])) {
        let model = steady_normal_force(section, 2.0, alpha[i])?;
        for measured in [slow[i], fast[i]] {
            sum += (model / measured - 1.0).abs();
            count += 1.0;
        }
    }
    Ok(sum / count)
}

/// Incidence at which forces go by its square, degrees.
const SMALL_DEG: f64 = 2.0;

/// A thin plate under the other laws, by their names.
const OTHERS: [(&str, SectionLaw); 3] = [
    ("lev", SectionLaw::PLATE),
    ("stall", SectionLaw::PLATE.stall()),
    ("linear", SectionLaw::PLATE.linear()),
];

/// Normal force of the rigid plate of AR 2.
pub fn plates() -> Result<Vec<ComparisonRow>, Error> {
    let shown = |name: &str, metric: &str, value: f64| {
        ComparisonRow::shown(&format!("aero.plates.{name}"), PLATE_SOURCE, metric, value, "")
    };
    let plate = SectionLaw::PLATE.lev3d();
    let metric = "law lev3d, AR 2, 4 to 29 deg: mean |error| of the normal force over it";
    let all = plate_error(plate, |_| true)?;
    let mut rows = vec![
        ComparisonRow::judged("aero.plates.normal_force", PLATE_SOURCE, metric, all, 0.1, ""),
        shown("rising", "the same up to 16 deg", plate_error(plate, |a| a <= 16.0)?),
        shown("stalled", "the same from 22 deg on", plate_error(plate, |a| a >= 22.0)?),
    ];
    let edged = plate.with_side_edges();
    rows.extend([
        shown("side_edges", "the same as the first with side_edges", plate_error(edged, |_| true)?),
        shown("side_edges.rising", "the same up to 16 deg", plate_error(edged, |a| a <= 16.0)?),
    ]);
    for (law, section) in OTHERS {
        let metric = format!("the same as the first under law {law}");
        rows.push(shown(&format!("law_{law}"), &metric, plate_error(section, |_| true)?));
    }
    Ok(rows)
}

/// Lift of the plate of AR 4 that is pitched fast.
pub fn mancini() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("plates/fast_pitch_ar4.csv")?;
    let measured = SampledCurve { at: table.column("t_star")?, value: table.column("cl")? };
    let ends = [measured.at[0], measured.at[measured.at.len() - 1]];
    let error = |section: SectionLaw, start: f64, window: f64| {
        let Ramp { travel, lift, .. } = fast_pitch(section, start)?;
        Ok::<_, Error>(SampledCurve { at: travel, value: lift }.error(&measured, window, ends))
    };
    let shown = |name: &str, metric: &str, value: f64| {
        ComparisonRow::shown(&format!("aero.mancini.{name}"), RAMP_SOURCE, metric, value, "")
    };
    let plate = SectionLaw::PLATE.lev3d();
    let point = "law lev3d, AR 4 pitched to 45 deg in a chord: rms error of lift to t* 2.2 over its rms";
    let mean = "the same of means over a quarter chord of travel";
    let Ramp { travel, lift, .. } = fast_pitch(plate, START)?;
    let model = SampledCurve { at: travel, value: lift };
    let between = |at: f64| PULSES.iter().all(|[from, to]| at < *from || at >= *to);
    let [from, to] = PULSES[0];
    let pulse = model.mean(from, to) / measured.mean(from, to) - 1.0;
    let mut rows = vec![
        shown("lift", point, error(plate, START, POINT)?),
        shown(
            "lift.between_pulses",
            "the same without the pulses of the added mass, t* below 0.36 and 1.05 to 1.36",
            model.error_where(&measured, POINT, ends, between),
        ),
        shown("lift.first_pulse", "error of the mean lift over the first pulse", pulse.abs()),
        ComparisonRow::judged(
            "aero.mancini.mean_lift",
            RAMP_SOURCE,
            mean,
            error(plate, START, QUARTER)?,
            0.15,
            "",
        ),
        shown("mean_lift.later", "the same with the ramp 0.04 chords later", error(plate, LATER, QUARTER)?),
    ];
    let windows = [("lift", "at the points", POINT), ("mean_lift", "of means", QUARTER)];
    for (law, section) in OTHERS {
        for (name, what, window) in windows {
            let value = error(section, START, window)?;
            rows.push(shown(&format!("{name}.law_{law}"), &format!("under law {law}, {what}"), value));
        }
    }
    for (name, what, window) in windows {
        let value = error(plate.with_side_edges(), START, window)?;
        rows.push(shown(
            &format!("{name}.side_edges"),
            &format!("under law lev3d with side_edges, {what}"),
            value,
        ));
    }
    Ok(rows)
}

/// Pull of the side edges of flat rectangles over q S a^2.
pub fn side_edges() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("lifting_surface/side_edges.csv")?;
    let (aspects, pulls) = (table.column("aspect")?, table.column("flat")?);
    let alpha = SMALL_DEG.to_radians();
    let mut rows = Vec::new();
    for (aspect, pull) in aspects.iter().zip(pulls) {
        let force = |section| steady_normal_force(section, *aspect, SMALL_DEG);
        let flat = SectionLaw::INVISCID;
        let found = (force(flat.with_side_edges())? - force(flat)?) / (alpha * alpha);
        let metric = format!(
            "AR {aspect}: normal force of the side edges over q S a^2, less that of the lattice, over it"
        );
        let (id, source) =
            (format!("aero.side_edges.ar{aspect}"), "own vortex lattice (validation/lifting_surface)");
        rows.push(ComparisonRow::judged(&id, source, &metric, (found / pull - 1.0).abs(), 0.08, ""));
    }
    Ok(rows)
}
