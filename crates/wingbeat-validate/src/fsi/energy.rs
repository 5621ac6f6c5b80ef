//! A flight of an elastic flapper: work of drives, dampers and air against kinetic, potential and elastic energy.

use wingbeat::aero::{
    Aero, LiftLaw, LiftingLine, LiftingLineSettings, SectionSettings, StripModel, StripSettings,
};
use wingbeat::math::{Quat, RK4, Vec3, Workspace};
use wingbeat::plant::{Fault, Linearisation, Plant};
use wingbeat::robot::{Air, Robot, SurfaceOutline, Wind};
use wingbeat::scenario::Document;

use crate::aero_full::Preset;
use crate::{Error, Row};

/// Density of the air, kg/m3.
const DENSITY: f64 = 1.2;
/// Duration of the flight, one cycle of the gait, s.
const DURATION: f64 = 0.25;
/// Step, s.
const STEP: f64 = 4e-4;

fn model(preset: Preset, law: LiftLaw, outline: SurfaceOutline) -> Result<Aero, Error> {
    let drag = outline.drag(law);
    let SurfaceOutline { planform, hinges, membrane, .. } = outline;
    if preset == Preset::Paper {
        let settings = LiftingLineSettings {
            section: SectionSettings { density_kg_m3: DENSITY, law, drag, ..Default::default() },
            ..Default::default()
        };
        return Ok(Aero::LiftingLine(LiftingLine::new(&planform, settings)?));
    }
    let settings = StripSettings {
        hinge_arcs_m: hinges,
        membrane,
        section: SectionSettings { density_kg_m3: DENSITY, law, drag, ..Default::default() },
        ..Default::default()
    };
    Ok(Aero::Strip(StripModel::new(&planform, settings)?))
}

/// A membrane of its wings: a film of 10 um, every number a choice.
const SKIN: &str = "membrane = { thickness_m = 1e-5, modulus_pa = 1e8, density_kg_m3 = 1000.0, prestrain = 0.005, damping_s = 1e-3, ribs_m = [0.02, 0.13, 0.2] }\n";

/// The flapper of `validation/fsi/flapper.toml` in a slight wind.
fn flapper(preset: Preset, law: LiftLaw, skin: bool) -> Result<Robot, Error> {
    let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/fsi/flapper.toml"));
    let file = "fsi/flapper.toml";
    let wing = "[[surfaces]]\nname = \"wing\"\n";
    let text = if skin { text.replace(wing, &format!("{wing}{SKIN}")) } else { text.to_owned() };
    let spec = Document::text(file, &text)
        .and_then(|d| d.robot())
        .map_err(|e| Error::reference(file, e.to_string()))?;
    let models = spec.outlines()?.into_iter().map(|outline| model(preset, law, outline));
    let air = Air { density: DENSITY, wind: Wind::steady(Vec3::new(0.1, -0.2, 0.05)) };
    Ok(Robot::new(&spec, models.collect::<Result<_, _>>()?, air, 0.3)?)
}

/// Work done on the robot less the growth of its energy, over the largest work on the way.
fn imbalance(preset: Preset, skin: bool) -> Result<f64, Error> {
    let robot = flapper(preset, LiftLaw::Stall, skin)?;
    let (l, n) = (*robot.layout(), robot.states().len());
    let mut x = vec![0.0; n + 1];
    Quat::from_roll_pitch_yaw(0.2, -0.3, 0.4).store_wxyz(&mut x[l.attitude..]);
    Vec3::new(2.0, 0.1, -0.3).store(&mut x[l.velocity..]);
    Vec3::new(0.4, -0.8, 0.5).store(&mut x[l.rate..]);
    let coordinates = robot.start_coordinates();
    x[l.joints..][..coordinates.len()].copy_from_slice(&coordinates);
    // The last state is the work of drives, dampers and air.
    let rates = |t: f64, x: &[f64], dx: &mut [f64]| -> Result<(), Fault> {
        robot.rates_in_numbers(t, &x[..n], &[], &mut dx[..n])?;
        let seen = robot.observe(t, &x[..n], &[])?;
        dx[n] = seen.power + seen.air_power - seen.dissipation;
        Ok(())
    };
    let mut work = Workspace::new(n + 1, RK4.b.len());
    let start = robot.observe(0.0, &x[..n], &[])?.energy;
    let step = if skin { 0.25 * STEP } else { STEP };
    let (steps, mut largest) = ((DURATION / step).round() as usize, 0.0_f64);
    for i in 0..steps {
        RK4.step(rates, i as f64 * step, step, &mut x, &mut work)?;
        largest = largest.max(x[n].abs());
    }
    let end = robot.observe(DURATION, &x[..n], &[])?.energy;
    Ok((x[n] - (end - start)).abs() / largest)
}

/// The rows.
pub fn rows() -> Result<Vec<Row>, Error> {
    let row = |preset: Preset| {
        let metric = format!(
            "work of drives, dampers and air - change of energy, over the peak work, one cycle, preset {}",
            preset.name()
        );
        let id = if preset == Preset::Paper {
            "fsi.energy".into()
        } else {
            format!("fsi.energy.{}", preset.name())
        };
        Ok(Row::judged(&id, "conservation of energy", &metric, imbalance(preset, false)?, 1e-8, ""))
    };
    [Preset::Paper, Preset::Full].into_iter().map(row).collect()
}

/// Energy of the links with a membrane for a wing. What the membrane stores and loses is the air's work on it, of which the links know
/// nothing; `work_on_a_membrane_is_what_it_stores_and_loses` balances that.
pub fn membrane_rows() -> Result<Vec<Row>, Error> {
    let metric = "work of drives, dampers and air on the links - change of their energy (the membrane's own is not in it), over the peak work, one cycle, wings of membrane";
    let value = imbalance(Preset::Full, true)?;
    Ok(vec![Row::judged("fsi.membrane.energy", "conservation of energy", metric, value, 1e-8, "")])
}

/// Largest error of the exact derivatives of the rates by states against central differences, over the largest of their row.
fn derivative_error(law: LiftLaw) -> Result<f64, Error> {
    let robot = flapper(Preset::Full, law, true)?;
    let (l, n) = (*robot.layout(), robot.states().len());
    let mut x: Vec<f64> = (0..n).map(|i| 0.02 * ((i * 37 % 23) as f64 / 23.0 - 0.4)).collect();
    Quat::from_roll_pitch_yaw(0.2, -0.3, 0.4).store_wxyz(&mut x[l.attitude..]);
    Vec3::new(3.0, 0.1, -0.3).store(&mut x[l.velocity..]);
    let mut exact = Linearisation::new(n, 0);
    exact.evaluate(&robot, 0.03, &x, &[])?;
    let mut worst = 0.0_f64;
    for j in 0..n {
        // The momentum of a strip's membrane is of the order of a millionth.
        let step = if robot.states()[j].unit == "N s" { 1e-9 } else { 1e-6 };
        let rates = |sign: f64| -> Result<Vec<f64>, Error> {
            let (mut moved, mut dx) = (x.clone(), vec![0.0; n]);
            moved[j] += sign * step;
            robot.rates_in_numbers(0.03, &moved, &[], &mut dx)?;
            Ok(dx)
        };
        let (up, down) = (rates(1.0)?, rates(-1.0)?);
        for i in 0..n {
            let row = exact.a[i * n..][..n].iter().fold(1.0, |m: f64, v| m.max(v.abs()));
            let difference = (up[i] - down[i]) / (2.0 * step);
            worst = worst.max((difference - exact.a[i * n + j]).abs() / row);
        }
    }
    Ok(worst)
}

/// Derivatives with a membrane for a wing.
pub fn derivative_rows() -> Result<Vec<Row>, Error> {
    let mut worst = 0.0_f64;
    for law in [LiftLaw::Linear, LiftLaw::Stall, LiftLaw::Lev3d] {
        worst = worst.max(derivative_error(law)?);
    }
    let metric =
        "max error of the rates by each state, wings of membrane, three laws, over the largest of the rate";
    Ok(vec![Row::judged("fsi.membrane.derivatives", "central differences", metric, worst, 1e-6, "")])
}
