//! Mean forces: induced drag against the Trefftz plane, and measured thrust.

use super::thrust::{Waving, mean_thrust};
use super::wings::{self, Still, rectangle};
use super::{ComparedPreset, STRIPS, SectionLaw};
use crate::{ComparisonRow, Error, reference_table};
use std::f64::consts::PI;
use wingbeat::aero::{Loads, SurfaceNumbers};
use wingbeat::math::{Jet, Vec3};
use wingbeat::tether::TetheredBody;

/// Steady induced drag over the Trefftz drag of the wing's own circulation: without the force of edges along the span, and with it, whose
/// pull at the tips of a folded wing leans back by the angle of attack.
pub fn trefftz() -> Result<Vec<ComparisonRow>, Error> {
    let wings = [wings::rectangular(6.0)?, wings::swept(6.0, 30.0)?, wings::folded(6.0, 15.0, -60.0)?];
    let worst = |preset: ComparedPreset| -> Result<f64, Error> {
        let errors = wings.iter().map(|wing| Ok((drag_over_trefftz(preset, wing)? - 1.0).abs()));
        errors.collect::<Result<Vec<f64>, Error>>().map(|errors| errors.into_iter().fold(0.0, f64::max))
    };
    let source = "Munk: drag of its own far wake";
    let metric = "worst error of steady induced drag: flat, swept 30 deg, folded 75 deg";
    let (neither, edges) = (worst(ComparedPreset::Neither)?, worst(ComparedPreset::Full)?);
    let without = format!("{metric}, without edges' suction along the span");
    Ok(vec![
        ComparisonRow::judged("aero.full.trefftz", source, &without, neither, 0.005, ""),
        ComparisonRow::shown("aero.full.trefftz.edges", source, &format!("{metric}, with it"), edges, ""),
    ])
}

/// Ratio of the steady induced drag to the Trefftz drag of a wing of AR 6, swept by `angle` degrees, or folded: each half at
/// the dihedral 15 degrees up to 1/3 of it, then bent down by `angle` degrees.
///
/// # Errors
/// [`Error`] when the model cannot be built.
pub fn induced_over_trefftz(folded: bool, angle: f64) -> Result<f64, Error> {
    drag_over_trefftz(
        ComparedPreset::Full,
        &if folded { wings::folded(6.0, 15.0, 15.0 - angle)? } else { wings::swept(6.0, angle)? },
    )
}

/// Steady drag at 2 degrees over the drag of its wake.
fn drag_over_trefftz(preset: ComparedPreset, still: &Still) -> Result<f64, Error> {
    let model = preset.model(still.wing.planform(), &still.hinges(), 1.0, 1e-6)?;
    let alpha = 2_f64.to_radians();
    let wind = Vec3::new(-alpha.cos(), 0.0, alpha.sin());
    let angles: Vec<Jet<f64>> = still.angles.clone();
    let frame = TetheredBody::rest().frame();
    let sections: Vec<_> = model.arcs().iter().map(|&arc| still.wing.section(arc, &frame, &angles)).collect();
    let (mut x, mut dx) = (vec![0.0; model.states()], vec![0.0; model.states()]);
    let mut loads = Loads::default();
    for _ in 0..5000 {
        model.evaluate_in_numbers(&sections, wind, &x, &mut dx, &mut loads);
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
pub fn scherer_thrust(preset: ComparedPreset, theta_deg: f64, psi_deg: f64) -> Result<f64, Error> {
    thrust_of(preset, SectionLaw::INVISCID, theta_deg, psi_deg)
}

/// The same under the law of a section.
fn thrust_of(
    preset: ComparedPreset,
    section: SectionLaw,
    theta_deg: f64,
    psi_deg: f64,
) -> Result<f64, Error> {
    changed_thrust(preset, section, [theta_deg, psi_deg], |_| ())
}

/// Thrust coefficient of the strip model under law `lev` with its numbers as `change` makes them, drag included.
pub fn scherer_lev_thrust(
    theta_deg: f64,
    psi_deg: f64,
    change: impl Fn(&mut SurfaceNumbers),
) -> Result<f64, Error> {
    let section = SectionLaw::stalling_at(NACA_63A015_STALL);
    changed_thrust(ComparedPreset::Full, section, [theta_deg, psi_deg], change)
}

fn changed_thrust(
    preset: ComparedPreset,
    section: SectionLaw,
    [theta_deg, psi_deg]: [f64; 2],
    change: impl Fn(&mut SurfaceNumbers),
) -> Result<f64, Error> {
    let (chord, span, speed, density) = (0.1016, 0.3048, 3.048, 1000.0);
    let planform = rectangle(span, chord)?;
    let model = preset.model_with(section, STRIPS, &planform, &[], density, 0.02)?;
    let mut numbers = model.numbers().clone();
    change(&mut numbers);
    let model = model.with(&numbers)?;
    let waving = Waving {
        heave: [0.6 * chord, 0.0],
        pitch: [theta_deg.to_radians(), psi_deg.to_radians()],
        axis: 0.75 * chord,
        frequency_hz: 5.0,
        speed,
        density,
        chord,
        cycles: 6,
        steps_per_cycle: 96,
    };
    let mean = mean_thrust(&waving.tether(planform, model)?)?;
    Ok(mean / (0.5 * density * speed * speed * span * chord))
}

/// A measured thrust coefficient of the heaving and pitching wing.
#[derive(Clone, Copy, Debug)]
pub struct Thrust {
    /// Pitch amplitude, degrees.
    pub theta_deg: f64,
    /// Phase of pitch before heave, degrees.
    pub psi_deg: f64,
    /// Thrust coefficient of the inviscid model.
    pub value: f64,
    /// Thrust coefficient measured.
    pub measured: f64,
    /// Error bars of the coefficient, below and above.
    pub bars: (f64, f64),
}

/// The model at the measured points.
///
/// # Errors
/// [`Error`] when the table or the model fails.
pub fn scherer_points(preset: ComparedPreset) -> Result<Vec<Thrust>, Error> {
    points_of(preset, SectionLaw::INVISCID)
}

fn points_of(preset: ComparedPreset, section: SectionLaw) -> Result<Vec<Thrust>, Error> {
    let table = reference_table!("scherer1968/thrust.csv")?;
    let (theta, psi) = (table.column("theta_max_deg")?, table.column("psi_deg")?);
    let (measured, below, above) =
        (table.column("ct")?, table.column("err_minus")?, table.column("err_plus")?);
    let point = |i: usize| {
        let (theta_deg, psi_deg) = (theta[i], psi[i]);
        let value = thrust_of(preset, section, theta_deg, psi_deg)?;
        Ok(Thrust { theta_deg, psi_deg, value, measured: measured[i], bars: (below[i], above[i]) })
    };
    (0..table.len()).map(point).collect()
}

/// Mean |error| of the thrust coefficient over the measured points.
fn mean_error(points: &[Thrust], drag: f64) -> f64 {
    points.iter().map(|p| (p.value - drag - p.measured).abs()).sum::<f64>() / points.len() as f64
}

const SOURCE: &str = "Scherer 1968, measured; Izraelevitz et al. 2017 fig. 14";

/// The error of the inviscid models: shown, because at the larger incidences the flow has left what they know.
pub fn scherer(preset: ComparedPreset) -> Result<Vec<ComparisonRow>, Error> {
    let points = scherer_points(preset)?;
    let metric = "mean |error| of thrust coefficient, law linear, Cd0 = 0.057";
    let id = if preset == ComparedPreset::Full { "aero.scherer".to_string() } else { preset.id("scherer") };
    let own = ComparisonRow::shown(&id, SOURCE, metric, mean_error(&points, STATIC_DRAG), "");
    let low = mean_error(&points, SCHERER_DRAG);
    let other = ComparisonRow::shown(&format!("{id}.low_drag"), SOURCE, "the same, Cd0 = 0.027", low, "");
    Ok(vec![own, other])
}

/// Static stall of the section NACA 63A015, degrees: that of NACA 63(2)-015 at the lowest Reynolds number (3e6) of
/// Abbott & von Doenhoff 1959, app. IV.
const NACA_63A015_STALL: f64 = 15.0;

/// The error under law `lev`, and its change with the critical suction parameter.
pub fn scherer_lev() -> Result<Vec<ComparisonRow>, Error> {
    let section = SectionLaw::stalling_at(NACA_63A015_STALL);
    let points = points_of(ComparedPreset::Full, section)?;
    let a0c = section.critical_suction;
    let metric = |drag: f64, a0c: f64| {
        format!("mean |error| of thrust coefficient, law lev, A0c = {a0c:.3}, Cd0 = {drag}")
    };
    let mut rows = Vec::new();
    let id = |name: &str| format!("aero.lev.scherer{name}");
    for (name, drag) in [("", STATIC_DRAG), (".low_drag", SCHERER_DRAG)] {
        let error = mean_error(&points, drag);
        rows.push(ComparisonRow::judged(&id(name), SOURCE, &metric(drag, a0c), error, 0.026, ""));
    }
    for (name, factor) in [(".less", 0.85), (".more", 1.15)] {
        let other = SectionLaw { critical_suction: factor * a0c, ..section };
        let points = points_of(ComparedPreset::Full, other)?;
        for (suffix, drag) in [("", STATIC_DRAG), (".low_drag", SCHERER_DRAG)] {
            let id = id(&format!("{name}{suffix}"));
            rows.push(ComparisonRow::shown(
                &id,
                SOURCE,
                &metric(drag, factor * a0c),
                mean_error(&points, drag),
                "",
            ));
        }
    }
    for (suffix, drag) in [("", STATIC_DRAG), (".low_drag", SCHERER_DRAG)] {
        let error = mean_error(&points_of(ComparedPreset::Full, section.lev3d())?, drag);
        let metric = format!("the same as the first under law lev3d, Cd0 = {drag}");
        rows.push(ComparisonRow::shown(&id(&format!(".lev3d{suffix}")), SOURCE, &metric, error, ""));
    }
    for (name, preset) in [(".five_lags", ComparedPreset::FiveLags), (".paper", ComparedPreset::Paper)] {
        let points = points_of(preset, section)?;
        let metric = format!("the same with {}", preset.name());
        rows.push(ComparisonRow::shown(&id(name), SOURCE, &metric, mean_error(&points, STATIC_DRAG), ""));
    }
    Ok(rows)
}
