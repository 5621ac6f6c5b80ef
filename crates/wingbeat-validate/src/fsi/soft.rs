//! Springs on the pins of a linkage against their energy, and what the pressure of a bent lattice does along its bends.

use super::energy::model;
use crate::aero_full::ComparedPreset;
use crate::{ComparisonRow, Error};
use std::f64::consts::PI;
use std::sync::Arc;
use wingbeat::aero::{ChordBend, LiftLaw, SectionMotion};
use wingbeat::math::{Dual, Quat, Vec3};
use wingbeat::plant::Plant;
use wingbeat::robot::{Air, Robot, Wind};
use wingbeat::scenario::Document;
use wingbeat_lattice::{Lattice, LatticeSettings, LatticeSurface, MovingSections, PanelLayout, Scene};

/// Springs of the linkage of Aerobat, every number a choice.
const SPRINGS: &str = "gait.linkage.springs=[{ pin = 'elbow', stiffness = 2e-3, damping = 1e-5 }, \
                       { pin = 'coupler_rod', stiffness = 1e-3, rest = 0.3 }, { pin = 'bell_crank', stiffness = 3e-3 }]";
/// A motor whose crank is so heavy that nothing but the springs' effort changes its rate between two robots.
const MOTOR: &str = "drive.motor={ stall_torque_n_m = 6e-3, no_load_speed_rad_s = 2500.0, gear_ratio = 60.0, rotor_inertia_kg_m2 = 4e-9, \
                     crank_inertia_kg_m2 = 1e3 }";

/// Aerobat with `set` in its file.
fn aerobat(set: &[&str]) -> Result<Robot, Error> {
    let file = "robots/aerobat_beta.toml";
    let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/aerobat_beta.toml"));
    let spec = Document::text(file, text)
        .and_then(|document| set.iter().fold(document, |document, set| document.set(*set)).robot())
        .map_err(|e| Error::reference(file, e.to_string()))?;
    let of = |outline| model(ComparedPreset::Paper, LiftLaw::Linear, 1.2, outline);
    let models: Result<Vec<_>, Error> = spec.outlines()?.into_iter().map(of).collect();
    Ok(Robot::new(&spec, models?, Air { density: 1.2, wind: Wind::steady(Vec3::ZERO) }, 0.3)?)
}

/// In flight with the crank at `phase`, where a motor turns it.
fn flying(robot: &Robot, phase: f64) -> Vec<f64> {
    let (l, mut x) = (*robot.layout(), vec![0.0; robot.states().len()]);
    Quat::from_roll_pitch_yaw(0.2, -0.3, 0.4).store_wxyz(&mut x[l.attitude..]);
    Vec3::new(2.0, 0.1, -0.3).store(&mut x[l.velocity..]);
    let coordinates = robot.start_coordinates();
    x[l.joints..][..coordinates.len()].copy_from_slice(&coordinates);
    if let Some([angle, rate]) = l.crank {
        (x[angle], x[rate]) = (phase, 20.0);
    }
    x
}

/// Effort of the springs along the crank less the slope of their energy, and power of a turn at an even rate less what dampers take.
pub fn springs() -> Result<Vec<ComparisonRow>, Error> {
    let undamped = SPRINGS.replace(", damping = 1e-5", "");
    let (with, without) = (aerobat(&[&undamped, MOTOR])?, aerobat(&[MOTOR])?);
    let u = vec![0.0; with.inputs().len()];
    let (mut off, mut size) = (0.0_f64, 0.0_f64);
    for k in 0..12 {
        let x = flying(&with, 0.5 * f64::from(k));
        let rate = |robot: &Robot| -> Result<f64, Error> {
            let mut dx = vec![0.0; x.len()];
            robot.rates_in_numbers(0.0, &x, &u, &mut dx)?;
            Ok(robot.layout().crank.map_or(0.0, |[_, rate]| dx[rate]))
        };
        let stored = |by: f64| -> Result<f64, Error> {
            let mut x = x.clone();
            with.layout().crank.iter().for_each(|[angle, _]| x[*angle] += by);
            Ok(with.observe(0.0, &x, &u)?.energy - without.observe(0.0, &x, &u)?.energy)
        };
        let h = 1e-3;
        let slope = (8.0 * (stored(h)? - stored(-h)?) - (stored(2.0 * h)? - stored(-2.0 * h)?)) / (12.0 * h);
        off = off.max((1e3 * (rate(&with)? - rate(&without)?) + slope).abs());
        size = size.max(slope.abs());
    }
    let even = aerobat(&[SPRINGS])?;
    let (u, cycle, count) = (vec![0.0; even.inputs().len()], 1.0 / even.frequency_hz(), 400);
    let x = flying(&even, 0.0);
    let (mut given, mut lost, mut moved) = (0.0, 0.0, 0.0);
    for k in 0..count {
        let seen = even.observe(cycle * f64::from(k) / f64::from(count), &x, &u)?;
        given += seen.pin_power;
        lost += seen.dissipation;
        moved += seen.pin_power.abs();
    }
    let row = |id: &str, source: &str, metric: &str, value: f64, limit: f64| {
        ComparisonRow::judged(&format!("fsi.springs.{id}"), source, metric, value, limit, "")
    };
    Ok(vec![
        row(
            "work",
            "virtual work",
            "effort of springs on pins along the crank + slope of their energy, over the largest slope, 12 phases",
            off / size,
            1e-5,
        ),
        row(
            "energy",
            "conservation of energy",
            "power into springs on pins less what dampers take, over the mean size of that power, one cycle at an even rate",
            (given - lost).abs() / moved,
            1e-10,
        ),
    ])
}

/// A long plate of unit chord at an incidence whose chord lines are bent.
struct BentPlate {
    incidence: f64,
    bend: ChordBend<Dual<1>>,
}

impl MovingSections for BentPlate {
    fn sections(&self, _: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        let (sine, cosine) = self.incidence.sin_cos();
        let (chord, span) = (Vec3::new(-cosine, 0.0, -sine), Vec3::new(0.0, -1.0, 0.0));
        out.clear();
        out.extend(arcs.iter().map(|arc| {
            let le = Vec3::new(0.0, *arc, 0.0);
            SectionMotion { le, te: le + chord, span, ..SectionMotion::default() }
        }));
    }

    fn bends(&self, _: f64, arcs: &[f64], out: &mut Vec<ChordBend<Dual<1>>>) {
        out.clear();
        out.extend(arcs.iter().map(|_| self.bend));
    }
}

/// Size of bends and incidence.
const SMALL: f64 = 1e-3;
/// Span in chords.
const LONG: f64 = 1e4;

/// Work of the pressure along both heights and the angle of a flap of a quarter of the chord, over [`SMALL`], for each span.
fn work(incidence: f64, heights: [f64; 2], angle: f64, chordwise: usize) -> Result<[f64; 3], Error> {
    let bend = ChordBend { heights: heights.map(Dual::constant), angle: Dual::constant(angle), hinge: 0.75 };
    let arcs = (0..=4).map(|j| LONG * (0.5 - 0.25 * f64::from(j))).collect();
    let layout = PanelLayout { chordwise, fractions: vec![0.5; 4], arcs };
    let surfaces = vec![LatticeSurface { layout, sections: Arc::new(BentPlate { incidence, bend }) }];
    let wind = Vec3::new(-1.0, 0.0, 0.0);
    let scene = Scene { surfaces, wind, density_kg_m3: 1.0, symmetric: false, ground: None };
    let failed = |error: wingbeat_lattice::Error| Error::NoAnswer(error.to_string());
    let mut lattice = Lattice::new(scene, LatticeSettings::new(1e6, 1e-6)).map_err(failed)?;
    lattice.step().map_err(failed)?;
    let loads = lattice.step().map_err(failed)?;
    let strips = loads.panels.iter().flat_map(|panels| &panels.bends);
    let mut sum = [0.0; 3];
    strips.for_each(|strip| (0..3).for_each(|k| sum[k] += strip[k] / (LONG * SMALL)));
    Ok(sum)
}

/// The pressure on bent panels along their bends, at rest.
pub fn bends() -> Result<Vec<ComparisonRow>, Error> {
    let source = "Glauert 1926, ch. 7; Theodorsen 1935, NACA Rep. 496";
    let c = 0.5_f64;
    let (root, arc) = ((1.0 - c * c).sqrt(), c.acos());
    let t4 = -arc + c * root;
    let t5 = -(1.0 - c * c) - arc * arc + 2.0 * c * root * arc;
    let (t10, t12) = (root + arc, root * (2.0 + c) - arc * (2.0 * c + 1.0));
    let hinge = [-0.25 * t12, -0.25 * ((t5 - t4 * t10) / PI + t12 * t10 / PI)];
    let mut rows = Vec::new();
    for (chordwise, [sail, flap]) in [(4, [0.25, 0.15]), (16, [0.02, 0.015])] {
        let mut off = 0.0_f64;
        for (incidence, heights, exact) in [
            (SMALL, [0.0, 0.0], [0.5 * PI, 0.125 * PI]),
            (0.0, [SMALL, 0.0], [1.5 * PI, 0.0]),
            (0.0, [0.0, SMALL], [-0.5 * PI, 0.25 * PI]),
        ] {
            let found = work(incidence, heights, 0.0, chordwise)?;
            off = (0..2)
                .fold(off, |off, k| off.max((found[k] - exact[k]).abs() / exact[k].abs().max(0.125 * PI)));
        }
        let hinged = [work(SMALL, [0.0; 2], 0.0, chordwise)?[2], work(0.0, [0.0; 2], SMALL, chordwise)?[2]];
        let turned = super::worst(hinged.into_iter().zip(hinge));
        let metric = "max error of the pressure's work on both shapes of a membrane, at incidence and bent";
        let metric = format!("{metric}, {chordwise} panels");
        rows.push(ComparisonRow::judged(
            &format!("fsi.lattice.membrane_{chordwise}"),
            source,
            &metric,
            off,
            sail,
            "",
        ));
        let metric =
            "max error of the hinge moment of a flap of a quarter of the chord, at incidence and turned";
        let metric = format!("{metric}, {chordwise} panels");
        rows.push(ComparisonRow::judged(
            &format!("fsi.lattice.flap_{chordwise}"),
            source,
            &metric,
            turned,
            flap,
            "",
        ));
    }
    Ok(rows)
}
