//! Leading edges that shed: their suction against thin-aerofoil theory, what must be kept, and a measured plate pitched fast.

use super::flapping;
use super::wings::lan;
use crate::curve::{START, SampledCurve, eldredge};
use crate::{ComparisonRow, Error, reference_table};
use std::sync::Arc;
use wingbeat::aero::{Planform, PlanformStation, SectionMotion};
use wingbeat::math::Vec3;
use wingbeat_lattice::{
    Lattice, LatticeSettings, LatticeSurface, MovingSections, PanelLayout, Scene, Spacing, WakeMotion,
};

/// Critical suction of a flat plate (Ramesh et al. 2014 and the runs of their program). *Choice*, not fitted to the plate below.
const CRITICAL: f64 = 0.11;
/// Core of the sheets, chords, as commands have it.
const SHEET_CORE: f64 = 0.1;
/// Core of the wake, chords: well below the way of a step.
const CORE: f64 = 1e-3;
/// Chords of travel over which lift is averaged: the measured peaks of the carried air are as wide.
const WIDTH: f64 = 0.25;
/// The last measured point, chords of travel.
const END: f64 = 2.18;

/// A plate of unit chord whose leading edge moves with `velocity`, pitched about it as `angle` (rad, and rad/s) says.
struct PitchedPlate<F> {
    velocity: Vec3,
    angle: F,
}

impl<F: Fn(f64) -> (f64, f64) + Send + Sync> MovingSections for PitchedPlate<F> {
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        let ((sin, cos), rate) = ((self.angle)(t).0.sin_cos(), (self.angle)(t).1);
        out.clear();
        out.extend(arcs.iter().map(|arc| {
            let le = Vec3::new(0.0, *arc, 0.0) + self.velocity * t;
            SectionMotion {
                le,
                te: le - Vec3::new(cos, 0.0, sin),
                v_le: self.velocity,
                v_te: self.velocity + Vec3::new(sin, 0.0, -cos) * rate,
                ..SectionMotion::default()
            }
        }));
    }
}

/// The ramp of the measured plate.
fn ramp(s: f64) -> (f64, f64) {
    eldredge(s, START)
}

/// A plate of the aspect ratio `aspect` on `chordwise` x `spanwise` panels, whole or its left half; it flies at 1 m/s, `carried` of
/// that as wind.
fn scene<F: Fn(f64) -> (f64, f64) + Send + Sync + 'static>(
    aspect: f64,
    [chordwise, spanwise]: [usize; 2],
    halved: bool,
    carried: f64,
    angle: F,
) -> Result<Scene, Error> {
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -1.0 };
    let planform = Planform::new(&[station(0.0), station(0.5 * aspect)])?;
    let spacing = if spanwise == 1 { Spacing::Uniform } else { Spacing::Lan };
    let middle: &[f64] = if halved { &[0.0] } else { &[] };
    let whole = PanelLayout::of(&planform, middle, chordwise, spanwise, spacing)?;
    let layout =
        whole.iter().find_map(|layout| if halved { layout.left_half() } else { Some(layout.clone()) });
    let layout = layout.ok_or_else(|| Error::NoAnswer("no panels".into()))?;
    let sections = Arc::new(PitchedPlate { velocity: Vec3::new(1.0 - carried, 0.0, 0.0), angle });
    Ok(Scene {
        surfaces: vec![LatticeSurface { layout, sections }],
        wind: Vec3::new(-carried, 0.0, 0.0),
        density_kg_m3: 1.0,
        symmetric: halved,
        ground: None,
    })
}

/// The suction parameter in steady flow at an incidence and a rate of pitch about the leading edge, and after a sudden start, against
/// A0 = alpha + q c/(2 V) (Glauert 1926) and Wagner's function.
pub fn edge_suction() -> Result<Vec<ComparisonRow>, Error> {
    const LARGE: f64 = 1e9;
    let (mut steady, mut started) = (0.0_f64, 0.0_f64);
    for chordwise in [4, 8, 16] {
        for (angle, rate) in [(1e-3, 0.0), (0.0, 1e-3), (1e-3, 1e-3)] {
            let scene = scene(1e4, [chordwise, 1], false, 1.0, move |_| (angle, rate))?;
            let mut lattice = Lattice::new(
                scene,
                LatticeSettings { critical_suction: Some(LARGE), ..LatticeSettings::new(1e6, 1e-6) },
            )?;
            lattice.step()?;
            lattice.step()?;
            steady = steady.max((lattice.suction()[0] / (angle + 0.5 * rate) - 1.0).abs());
        }
    }
    let scene = scene(1e3, [32, 1], false, 1.0, |_| (1e-3, 0.0))?;
    let settings =
        LatticeSettings { critical_suction: Some(LARGE), ..LatticeSettings::new(1.0 / 32.0, 1e-6) };
    let mut lattice = Lattice::new(scene, settings)?;
    let mut history = Vec::new();
    for _ in 0..=320 {
        lattice.step()?;
        history.push(lattice.suction()[0] / 1e-3);
    }
    for (s, wagner) in [(2.0, 0.66929), (5.0, 0.788203), (20.0, 0.936649)] {
        started = started.max((history[(0.5 * s * 32.0) as usize] / wagner - 1.0).abs());
    }
    let row = |id: &str, source: &str, metric: &str, value| {
        ComparisonRow::judged(id, source, metric, value, 0.01, "")
    };
    Ok(vec![
        row(
            "lattice.shedding.suction.steady",
            "Glauert 1926",
            "suction parameter A0 of a flat plate at an incidence, pitching, and both, 4 to 16 panels: worst error",
            steady,
        ),
        row(
            "lattice.shedding.suction.started",
            "Wagner 1925",
            "the same after a sudden start, 32 panels, from one chord of travel on",
            started,
        ),
    ])
}

/// Settings of the pitched plate.
fn settings(panels: [usize; 2], critical_suction: Option<f64>, wake: WakeMotion) -> LatticeSettings {
    let own = LatticeSettings::new(0.5 / panels[0] as f64, CORE);
    LatticeSettings { wake, critical_suction, sheet_core_m: SHEET_CORE, ..own }
}

/// Kelvin's theorem and the suction kept on a folding wing; a plate whole and by halves, carried by the wind and through still air.
pub fn kept() -> Result<Vec<ComparisonRow>, Error> {
    let wing = flapping::folding()?;
    let own = LatticeSettings::new(1.0 / (3.5 * 32.0), 0.004);
    let settings_of =
        |wake| LatticeSettings { wake, critical_suction: Some(CRITICAL), sheet_core_m: 0.008, ..own };
    let mut lattice = Lattice::new(Scene::new(&wing, lan(6, 16), true)?, settings_of(WakeMotion::Free))?;
    let (mut kelvin, mut suction) = (0.0_f64, 0.0_f64);
    for _ in 0..40 {
        lattice.step()?;
        kelvin = kelvin.max(lattice.circulation_error());
        suction = lattice.suction().iter().fold(suction, |most, suction| most.max(suction.abs()));
    }
    let lift = |halved, carried| -> Result<Vec<f64>, Error> {
        let (panels, wake) = ([6, 12], WakeMotion::Free);
        let mut lattice =
            Lattice::new(scene(4.0, panels, halved, carried, ramp)?, settings(panels, Some(CRITICAL), wake))?;
        (0..13).map(|_| Ok(lattice.step()?.joukowski.force[2])).collect()
    };
    let (half, whole, still) = (lift(true, 1.0)?, lift(false, 1.0)?, lift(true, 0.0)?);
    let apart = |other: &[f64]| {
        let largest = half.iter().fold(0.0_f64, |most, lift| most.max(lift.abs()));
        half.iter().zip(other).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) / largest
    };
    let row = |id: &str, source: &str, metric: &str, value, limit| {
        ComparisonRow::judged(&format!("lattice.shedding.kept.{id}"), source, metric, value, limit, "")
    };
    let metric = "flap_fold with leading edges that shed, free wake: largest circulation around a strip and its sheets over that of the largest ring";
    Ok(vec![
        row("kelvin", "Kelvin 1869", metric, kelvin, 1e-12),
        row(
            "suction",
            "the criterion",
            "largest suction of these over the critical, less 1",
            suction / CRITICAL - 1.0,
            1e-9,
        ),
        row(
            "mirror",
            "its own half",
            "plate of AR 4 pitched fast, whole beside its half: lift over the largest",
            apart(&whole),
            1e-9,
        ),
        row("galilean", "the same in wind", "the same through still air beside in wind", apart(&still), 1e-9),
    ])
}

/// Largest lift past the acceleration, and where.
fn largest(curve: &SampledCurve) -> (f64, f64) {
    let late = curve.at.iter().zip(&curve.value).filter(|(travel, _)| **travel > 0.5 && **travel < 1.2);
    late.fold((0.0, 0.0), |most, (travel, lift)| if *lift > most.0 { (*lift, *travel) } else { most })
}

/// Lift coefficients of the plate of AR 4 that is pitched fast.
fn pitched(
    panels: [usize; 2],
    critical: Option<f64>,
    wake: WakeMotion,
    end: f64,
) -> Result<SampledCurve, Error> {
    let own = settings(panels, critical, wake);
    let mut lattice = Lattice::new(scene(4.0, panels, true, 1.0, ramp)?, own)?;
    let travel: Vec<f64> = (0..=(end / own.step_s).ceil() as usize).map(|k| k as f64 * own.step_s).collect();
    // Of the dynamic pressure 1/2 and the area 4.
    let lift = travel.iter().map(|_| Ok::<_, Error>(lattice.step()?.joukowski.force[2] / 2.0));
    Ok(SampledCurve { value: lift.collect::<Result<_, _>>()?, at: travel })
}

/// Forces against the rate of the impulse of all vortices, by means over a quarter chord of travel behind the first pulse.
pub fn momentum() -> Result<Vec<ComparisonRow>, Error> {
    const STEPS: usize = 35;
    /// Steps of a quarter chord of travel, and the first that counts.
    const WINDOW: [usize; 2] = [4, 5];
    let mut rows = Vec::new();
    for (name, critical) in [("attached", None), ("shed", Some(CRITICAL))] {
        let own = settings([8, 12], critical, WakeMotion::Free);
        let mut lattice = Lattice::new(scene(4.0, [8, 12], true, 1.0, ramp)?, own)?;
        let (mut forces, mut impulses) = ([Vec::new(), Vec::new()], Vec::new());
        for _ in 0..=STEPS {
            let loads = lattice.step()?;
            forces[0].push(loads.joukowski.force[2]);
            forces[1].push(loads.bernoulli.force[2]);
            impulses.push(lattice.impulse()[2]);
        }
        let [window, first] = WINDOW;
        for (way, forces) in ["joukowski", "bernoulli"].into_iter().zip(&forces) {
            let (mut error, mut scale, mut excess) = (0.0, 0.0, 0.0);
            for k in first..=STEPS - window {
                let inner: f64 = forces[k + 1..k + window].iter().sum();
                let force = (inner + 0.5 * (forces[k] + forces[k + window])) / window as f64;
                let rate = (impulses[k] - impulses[k + window]) / (window as f64 * own.step_s);
                error += (force - rate).powi(2);
                scale += rate * rate;
                excess += (force - rate) * rate;
            }
            let metric = format!(
                "AR 4 pitched fast, {name}, 8 x 12 panels, free wake: force by {way} against the rate of the impulse, rms over its rms; in the mean {:+.1} %",
                100.0 * excess / scale
            );
            let id = format!("lattice.shedding.momentum.{name}.{way}");
            rows.push(ComparisonRow::shown(
                &id,
                "Saffman 1992, section 3.2",
                &metric,
                (error / scale).sqrt(),
                "",
            ));
        }
    }
    Ok(rows)
}

const MEASURED: &str = "Mancini et al. 2017, measured";

/// The plate of AR 4 pitched to 45 degrees in one chord of travel.
pub fn measured() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("plates/fast_pitch_ar4.csv")?;
    let measured = SampledCurve { at: table.column("t_star")?, value: table.column("cl")? };
    let (free, fixed, fine) = (WakeMotion::Free, WakeMotion::Prescribed, [12, 24]);
    let shed = pitched(fine, Some(CRITICAL), free, END)?;
    let attached = pitched(fine, None, free, END)?;
    let prescribed = pitched(fine, Some(CRITICAL), fixed, END)?;
    let error = |curve: &SampledCurve| curve.error(&measured, WIDTH, [0.0, END]);
    let ((lift, at), (most, when)) = (largest(&shed), largest(&measured));
    let judged = |id: &str, metric: &str, value, limit| {
        ComparisonRow::judged(&format!("lattice.shedding.measured.{id}"), MEASURED, metric, value, limit, "")
    };
    let shown = |id: &str, metric: &str, value| {
        ComparisonRow::shown(&format!("lattice.shedding.measured.{id}"), MEASURED, metric, value, "")
    };
    let metric = format!(
        "AR 4 pitched to 45 deg in a chord, critical suction {CRITICAL}, free wake, 12 x 24 panels, half a panel's chord a step: largest lift {lift:.2} over {most:.2}, less 1"
    );
    let mean =
        "the same: rms error to t* 2.18 of the lift's mean over a quarter chord of travel, over its rms";
    let mut rows = vec![
        judged("largest", &metric, (lift / most - 1.0).abs(), 0.07),
        judged("time", &format!("its time {at:.2} over {when:.2}, less 1"), (at / when - 1.0).abs(), 0.07),
        shown("mean_lift", mean, error(&shed)),
        shown("mean_lift_attached", "the same in attached flow", error(&attached)),
        shown("mean_lift_prescribed", "the same, shedding with a prescribed wake", error(&prescribed)),
    ];
    for panels in [[6, 24], [8, 24], [12, 16]] {
        let [m, n] = panels;
        let coarse = largest(&pitched(panels, Some(CRITICAL), free, 1.2)?).0;
        let metric = format!("largest lift with {m} x {n} panels over that with 12 x 24, less 1");
        rows.push(shown(&format!("panels_{m}_{n}"), &metric, (coarse / lift - 1.0).abs()));
    }
    for (id, critical) in [("half", 0.5 * CRITICAL), ("double", 2.0 * CRITICAL)] {
        let other = largest(&pitched(fine, Some(critical), free, 1.2)?).0;
        let metric =
            format!("largest lift with a critical suction of {critical} over that with {CRITICAL}, less 1");
        rows.push(shown(&format!("critical_{id}"), &metric, (other / lift - 1.0).abs()));
    }
    Ok(rows)
}
