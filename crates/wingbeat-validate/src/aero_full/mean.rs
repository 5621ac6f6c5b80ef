//! Mean forces: induced drag against the Trefftz plane, and measured thrust.

use super::Preset;
use super::flapping::last_cycle;
use super::wings::{self, Still, rectangle};
use crate::{Error, Row, reference_table};
use std::f64::consts::PI;
use wingbeat::aero::Loads;
use wingbeat::math::{Jet, Vec3};
use wingbeat::tether::{Clock, Coordinate, Motion, Reference, Side, Tether, TetheredBody, Wing};

/// Steady induced drag over the Trefftz drag of the wing's own circulation.
pub fn trefftz() -> Result<Vec<Row>, Error> {
    let wings = [wings::rectangular(6.0)?, wings::swept(6.0, 30.0)?, wings::folded(6.0, 15.0, -60.0)?];
    let mut worst: f64 = 0.0;
    for wing in wings {
        worst = worst.max((drag_over_trefftz(&wing)? - 1.0).abs());
    }
    let metric = "worst error of steady induced drag: flat, swept 30 deg, folded 75 deg";
    Ok(vec![Row::judged("aero.full.trefftz", "Munk: drag of its own far wake", metric, worst, 0.005, "")])
}

/// Steady induced drag over its Trefftz drag of a wing of AR 6, swept by `angle` degrees, or folded: each
/// half at the dihedral 15 degrees up to 1/3 of it, then bent down by `angle` degrees.
///
/// # Errors
/// [`Error`] when the model cannot be built.
pub fn induced_over_trefftz(folded: bool, angle: f64) -> Result<f64, Error> {
    drag_over_trefftz(&if folded {
        wings::folded(6.0, 15.0, 15.0 - angle)?
    } else {
        wings::swept(6.0, angle)?
    })
}

/// Steady drag at 2 degrees over the drag of its wake.
fn drag_over_trefftz(still: &Still) -> Result<f64, Error> {
    let model = Preset::Full.model(still.wing.planform(), &still.hinges(), 1.0, 1e-6)?;
    let alpha = 2_f64.to_radians();
    let wind = Vec3::new(-alpha.cos(), 0.0, alpha.sin());
    let angles: Vec<Jet<f64>> = still.angles.clone();
    let frame = TetheredBody::rest().frame();
    let sections: Vec<_> = model.arcs().iter().map(|&arc| still.wing.section(arc, &frame, &angles)).collect();
    let (mut x, mut dx) = (vec![0.0; model.states()], vec![0.0; model.states()]);
    let mut loads = Loads::default();
    for _ in 0..5000 {
        model.evaluate(&sections, wind, &x, &mut dx, &mut loads);
        x.iter_mut().zip(&dx).for_each(|(x, d)| *x += 0.06 * d);
    }
    let far = |p: Vec3| p - wind * p.dot(wind);
    let bound: Vec<Vec3> = sections.iter().map(|s| far(s.point(0.25))).collect();
    let middles = model.strip_arcs().iter().map(|&arc| still.wing.section(arc, &frame, &angles).point(0.25));
    let drag: f64 = middles
        .zip(bound.windows(2))
        .enumerate()
        .map(|(i, (middle, ends))| {
            let wash = far_velocity(&bound, &loads.circulation, far(middle), wind);
            -0.5 * loads.circulation[i] * wash.dot((ends[1] - ends[0]).cross(wind))
        })
        .sum();
    Ok(loads.wrench.force.dot(wind) / drag.abs())
}

/// Velocity at `p` of the straight wake far behind the strips between the points `bound`.
fn far_velocity(bound: &[Vec3], circulation: &[f64], p: Vec3, along: Vec3) -> Vec3 {
    let line = |q: Vec3| along.cross(p - q) * (1.0 / (2.0 * PI * (p - q).norm_squared()));
    bound
        .windows(2)
        .zip(circulation)
        .fold(Vec3::ZERO, |v, (ends, gamma)| v + (line(ends[1]) - line(ends[0])) * *gamma)
}

/// Drag coefficient of the wing at rest that the published comparison takes off.
pub const STATIC_DRAG: f64 = 0.057;
/// The drag that Scherer gives.
const SCHERER_DRAG: f64 = 0.027;

/// Inviscid thrust coefficient of Scherer's wing, pitch amplitude and phase in degrees.
///
/// # Errors
/// [`Error`] when the model cannot be built.
pub fn scherer_thrust(preset: Preset, theta_deg: f64, psi_deg: f64) -> Result<f64, Error> {
    let (chord, span, speed, density, frequency_hz) = (0.1016, 0.3048, 3.048, 1000.0, 5.0);
    let wave = |amplitude: f64, phase: f64| Coordinate::Fourier {
        frequency_hz,
        mean: 0.0,
        cos: vec![amplitude * phase.cos()],
        sin: vec![-amplitude * phase.sin()],
    };
    let planform = rectangle(span, chord)?;
    let zero = Coordinate::Constant(0.0);
    let area = span * chord;
    let tether = Tether {
        aero: preset.model(&planform, &[], density, 0.02)?,
        wing: Wing::new(planform, Vec::new())?,
        motion: Motion {
            surge: zero.clone(),
            heave: wave(0.6 * chord, 0.0),
            nose_up: wave(theta_deg.to_radians(), psi_deg.to_radians()),
            roll: zero,
            axis_ahead_m: -0.75 * chord,
            hinges: Vec::new(),
        },
        wind: Vec3::new(-speed, 0.0, 0.0),
        side: Side::Both,
        reference: Reference { density_kg_m3: density, speed_m_s: speed, area_m2: area, chord_m: chord },
        clock: Clock { frequency_hz, cycles: 6, steps_per_cycle: 96 },
    };
    let cycle = last_cycle(&tether)?;
    let mean = cycle.iter().map(|l| l.wrench.force[0]).sum::<f64>() / cycle.len() as f64;
    Ok(mean / (0.5 * density * speed * speed * area))
}

/// A measured thrust coefficient of the heaving and pitching wing.
#[derive(Clone, Copy, Debug)]
pub struct Thrust {
    /// Pitch amplitude, degrees.
    pub theta_deg: f64,
    /// Phase of pitch before heave, degrees.
    pub psi_deg: f64,
    /// Inviscid model.
    pub value: f64,
    /// Measured.
    pub measured: f64,
    /// Error bars below and above.
    pub bars: (f64, f64),
}

/// The model at the measured points.
///
/// # Errors
/// [`Error`] when the table or the model fails.
pub fn scherer_points(preset: Preset) -> Result<Vec<Thrust>, Error> {
    let table = reference_table!("scherer1968/thrust.csv")?;
    let (theta, psi) = (table.column("theta_max_deg")?, table.column("psi_deg")?);
    let (measured, below, above) =
        (table.column("ct")?, table.column("err_minus")?, table.column("err_plus")?);
    let point = |i: usize| {
        let (theta_deg, psi_deg) = (theta[i], psi[i]);
        let value = scherer_thrust(preset, theta_deg, psi_deg)?;
        Ok(Thrust { theta_deg, psi_deg, value, measured: measured[i], bars: (below[i], above[i]) })
    };
    (0..table.len()).map(point).collect()
}

/// Mean |error| of the thrust coefficient over the measured points.
pub fn scherer(preset: Preset) -> Result<Vec<Row>, Error> {
    let points = scherer_points(preset)?;
    let error = |drag: f64| {
        points.iter().map(|p| (p.value - drag - p.measured).abs()).sum::<f64>() / points.len() as f64
    };
    let source = "Scherer 1968, measured; Izraelevitz et al. 2017 fig. 14";
    let metric = "mean |error| of thrust coefficient, Cd0 = 0.057";
    let id = if preset == Preset::Full { "aero.scherer".to_string() } else { preset.id("scherer") };
    let judged = preset.row(&id, source, metric, error(STATIC_DRAG), 0.0320);
    let other =
        Row::shown(&format!("{id}.low_drag"), source, "the same, Cd0 = 0.027", error(SCHERER_DRAG), "");
    Ok(vec![judged, other])
}
