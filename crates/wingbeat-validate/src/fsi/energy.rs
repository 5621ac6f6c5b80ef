//! A flight of an elastic flapper: work of drives, dampers and air against kinetic, potential and elastic energy.

use wingbeat::aero::{
    Aero, LiftLaw, LiftingLine, LiftingLineSettings, SectionSettings, StripModel, StripSettings,
};
use wingbeat::math::{Quat, RK4, Vec3, Workspace};
use wingbeat::plant::{Fault, Plant};
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
    let SurfaceOutline { planform, hinges, .. } = outline;
    if preset == Preset::Paper {
        let settings = LiftingLineSettings {
            section: SectionSettings { density_kg_m3: DENSITY, law, drag, ..Default::default() },
            ..Default::default()
        };
        return Ok(Aero::LiftingLine(LiftingLine::new(&planform, settings)?));
    }
    let settings = StripSettings {
        hinge_arcs_m: hinges,
        section: SectionSettings { density_kg_m3: DENSITY, law, drag, ..Default::default() },
        ..Default::default()
    };
    Ok(Aero::Strip(StripModel::new(&planform, settings)?))
}

/// The flapper of `validation/fsi/flapper.toml` in a slight wind.
fn flapper(preset: Preset, law: LiftLaw) -> Result<Robot, Error> {
    let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/fsi/flapper.toml"));
    let file = "fsi/flapper.toml";
    let spec = Document::text(file, text)
        .and_then(|d| d.robot())
        .map_err(|e| Error::reference(file, e.to_string()))?;
    let models = spec.outlines()?.into_iter().map(|outline| model(preset, law, outline));
    let air = Air { density: DENSITY, wind: Wind::steady(Vec3::new(0.1, -0.2, 0.05)) };
    Ok(Robot::new(&spec, models.collect::<Result<_, _>>()?, air, 0.3)?)
}

/// Work done on the robot less the growth of its energy, over the largest work on the way.
fn imbalance(preset: Preset) -> Result<f64, Error> {
    let robot = flapper(preset, LiftLaw::Stall)?;
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
    let (steps, mut largest) = ((DURATION / STEP).round() as usize, 0.0_f64);
    for i in 0..steps {
        RK4.step(rates, i as f64 * STEP, STEP, &mut x, &mut work)?;
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
        Ok(Row::judged(&id, "conservation of energy", &metric, imbalance(preset)?, 1e-8, ""))
    };
    [Preset::Paper, Preset::Full].into_iter().map(row).collect()
}
