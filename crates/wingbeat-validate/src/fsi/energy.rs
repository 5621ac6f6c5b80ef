//! A flight of an elastic flapper: work of drives, dampers and air against kinetic, potential and elastic energy, and its momentum.

use wingbeat::aero::{
    Aero, LiftLaw, LiftingLine, LiftingLineSettings, SectionSettings, StripModel, StripSettings,
};
use wingbeat::math::{GRAVITY, Quat, RK4, Vec3, Workspace};
use wingbeat::plant::{Fault, Linearisation, Plant};
use wingbeat::robot::{Air, Observation, Robot, SurfaceOutline, Wind};
use wingbeat::scenario::Document;

use crate::aero_full::ComparedPreset;
use crate::{ComparisonRow, Error};

/// Density of the air, kg/m3.
const DENSITY: f64 = 1.2;
/// Duration of the flight, one cycle of the gait, s.
const DURATION: f64 = 0.25;
/// Step, s.
pub(super) const STEP: f64 = 4e-4;

pub(super) fn model(
    preset: ComparedPreset,
    law: LiftLaw,
    density_kg_m3: f64,
    outline: SurfaceOutline,
) -> Result<Aero, Error> {
    let drag = outline.drag(law);
    let SurfaceOutline { planform, hinges, membrane, flap, .. } = outline;
    if preset == ComparedPreset::Paper {
        let settings = LiftingLineSettings {
            section: SectionSettings { density_kg_m3, law, drag, ..Default::default() },
            ..Default::default()
        };
        return Ok(Aero::LiftingLine(LiftingLine::new(&planform, settings)?));
    }
    let settings = StripSettings {
        hinge_arcs_m: hinges,
        membrane,
        flap,
        section: SectionSettings { density_kg_m3, law, drag, ..Default::default() },
        ..Default::default()
    };
    Ok(Aero::Strip(StripModel::new(&planform, settings)?))
}

/// A membrane of its wings: a film of 10 um, every number a choice.
const SKIN: &str = "membrane = { thickness_m = 1e-5, modulus_pa = 1e8, density_kg_m3 = 1000.0, prestrain = 0.005, damping_s = 1e-3, ribs_m = [0.02, 0.13, 0.2] }\n";

/// A flap of its wings that turns at some 20 Hz, every number a choice.
pub(super) const FLAP: &str =
    "flap = { chord_fraction = 0.3, stiffness_n_rad = 0.02, areal_density_kg_m2 = 0.05 }\n";

/// Elements of its wings that bear their loads, every number a choice.
const ELEMENTS: &str = "[structure]\nfrequency_hz = 12.0\ndamping = 0.3\nelements = [\n\
    { name = \"arm_left\", scales = [\"arm_left\"], low = -1.0, high = 1.0, inertia = 2e-6 },\n\
    { name = \"arm_right\", scales = [\"arm_right\"], low = -1.0, high = 1.0, inertia = 2e-6 },\n\
    { name = \"hand_left\", moves = [\"hand_left\"], low = -1.0, high = 1.0, inertia = 4e-7 },\n\
    { name = \"hand_right\", moves = [\"hand_right\"], low = -1.0, high = 1.0, inertia = 4e-7 },\n]\n";

/// A cycle of the flapper of `validation/fsi/flapper.toml` in a slight wind.
#[derive(Clone, Copy)]
pub(super) struct Trial {
    pub preset: ComparedPreset,
    pub law: LiftLaw,
    /// What its wings have beside, a line of the surface.
    pub soft: &'static str,
    /// Spring of the outer link, N m/rad and N m s/rad.
    pub spring: [f64; 2],
    /// Time of its inertance, s.
    pub inertance: f64,
    /// Whether the elements bear their loads.
    pub elements: bool,
    /// Density of the air, kg/m3.
    pub density: f64,
    /// s.
    pub step: f64,
}

/// A membrane's own time is short.
const OF_SKIN: Trial = Trial { soft: SKIN, step: 0.25 * STEP, ..OF_WING };
/// So is the flap's.
const OF_FLAP: Trial = Trial { soft: FLAP, step: 0.05 * STEP, ..OF_WING };
pub(super) const OF_WING: Trial = Trial {
    preset: ComparedPreset::Full,
    law: LiftLaw::Stall,
    soft: "",
    spring: [4e-3, 2e-5],
    inertance: 0.0,
    elements: false,
    density: DENSITY,
    step: STEP,
};

/// What a trial lacks: see [`Trial::run`].
pub(super) struct Lacking {
    pub energy: f64,
    membrane: f64,
    pub momentum: f64,
}

impl Trial {
    pub fn robot(&self) -> Result<Robot, Error> {
        let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/fsi/flapper.toml"));
        let file = "fsi/flapper.toml";
        let wing = "[[surfaces]]\nname = \"wing\"\n";
        let text = text.replace(wing, &format!("{wing}{}", self.soft));
        let text = if self.elements { text + ELEMENTS } else { text };
        let [stiffness, damping] = self.spring;
        let spring = format!("elastic = {{ stiffness = {stiffness:e}, damping = {damping:e},");
        let text = text.replace("elastic = { stiffness = 4e-3, damping = 2e-5,", &spring);
        let spec = Document::text(file, &text)
            .and_then(|d| d.robot())
            .map_err(|e| Error::reference(file, e.to_string()))?;
        let of = |outline| model(self.preset, self.law, self.density, outline);
        let models = spec.outlines()?.into_iter().map(of);
        let air = Air { density: self.density, wind: Wind::steady(Vec3::new(0.1, -0.2, 0.05)) };
        let mut robot = Robot::new(&spec, models.collect::<Result<_, _>>()?, air, 0.3)?;
        robot.set_inertance(self.inertance)?;
        Ok(robot)
    }

    /// The state in which it starts, with room for `more` numbers behind it.
    fn start(robot: &Robot, u: &[f64], more: usize) -> Result<Vec<f64>, Error> {
        let (l, n) = (*robot.layout(), robot.states().len());
        let mut x = vec![0.0; n + more];
        Quat::from_roll_pitch_yaw(0.2, -0.3, 0.4).store_wxyz(&mut x[l.attitude..]);
        Vec3::new(2.0, 0.1, -0.3).store(&mut x[l.velocity..]);
        Vec3::new(0.4, -0.8, 0.5).store(&mut x[l.rate..]);
        let coordinates = robot.start_coordinates();
        x[l.joints..][..coordinates.len()].copy_from_slice(&coordinates);
        robot.settle(0.0, &mut x[..n], u)?;
        Ok(x)
    }

    /// Where it is after a cycle, m.
    pub fn place(&self) -> Result<Vec3, Error> {
        let robot = self.robot()?;
        let (u, rates) = ([], |t: f64, x: &[f64], dx: &mut [f64]| robot.rates_in_numbers(t, x, &[], dx));
        let mut x = Self::start(&robot, &u, 0)?;
        let mut work = Workspace::new(x.len(), RK4.b.len());
        for i in 0..(DURATION / self.step).round() as usize {
            RK4.step(rates, i as f64 * self.step, self.step, &mut x, &mut work)?;
        }
        Ok(Vec3::from_slice(&x[robot.layout().position..]))
    }

    /// Over a cycle: work on the robot less the growth of its energy, over the largest work on the way; the same of the membrane alone,
    /// over all work whatever its sense; and the largest change of the momentum of links and membrane but by the weight, over it.
    pub fn run(&self) -> Result<Lacking, Error> {
        let (robot, n) = (self.robot()?, self.robot()?.states().len());
        let u = &[0.04, -0.03, 0.05, 0.02][..robot.inputs().len()];
        let mut x = Self::start(&robot, u, 3)?;
        // Behind the state: work of drives, dampers and air, work on the membrane less what it loses, and its size.
        let rates = |t: f64, x: &[f64], dx: &mut [f64]| -> Result<(), Fault> {
            robot.rates_in_numbers(t, &x[..n], u, &mut dx[..n])?;
            let seen = robot.observe(t, &x[..n], u)?;
            let skin = &seen.strips.membrane;
            dx[n] = seen.power + seen.air_power - seen.dissipation;
            (dx[n + 1], dx[n + 2]) = (skin.given - skin.lost, skin.given.abs());
            Ok(())
        };
        let mut work = Workspace::new(n + 3, RK4.b.len());
        let momentum = |seen: &Observation, t: f64| {
            let weight = Vec3::new(0.0, 0.0, -GRAVITY * robot.mass() * t);
            seen.momentum + seen.attitude * seen.strips.membrane.momentum - weight
        };
        let start = robot.observe(0.0, &x[..n], u)?;
        let before = momentum(&start, 0.0);
        let steps = (DURATION / self.step).round() as usize;
        let (mut largest, mut changed) = (0.0_f64, 0.0_f64);
        for i in 0..steps {
            RK4.step(rates, i as f64 * self.step, self.step, &mut x, &mut work)?;
            largest = largest.max(x[n].abs());
            let t = (i + 1) as f64 * self.step;
            changed = changed.max((momentum(&robot.observe(t, &x[..n], u)?, t) - before).norm());
        }
        let end = robot.observe(DURATION, &x[..n], u)?;
        let stored = end.strips.membrane.stored - start.strips.membrane.stored;
        Ok(Lacking {
            energy: (x[n] - (end.energy - start.energy)).abs() / largest,
            membrane: (x[n + 1] - stored).abs() / x[n + 2],
            momentum: changed / before.norm(),
        })
    }
}

/// The rows.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let row = |preset: ComparedPreset| {
        let metric = format!(
            "work of drives, dampers and air less change of energy, over the peak work, one cycle, preset {}",
            preset.name()
        );
        let id = if preset == ComparedPreset::Paper {
            "fsi.energy".into()
        } else {
            format!("fsi.energy.{}", preset.name())
        };
        let lacking = Trial { preset, ..OF_WING }.run()?.energy;
        Ok(ComparisonRow::judged(&id, "conservation of energy", &metric, lacking, 1e-8, ""))
    };
    [ComparedPreset::Paper, ComparedPreset::Full].into_iter().map(row).collect()
}

/// Momentum of wings of membrane without air.
pub fn momentum_rows() -> Result<Vec<ComparisonRow>, Error> {
    let lacking = Trial { density: 1e-12, ..OF_SKIN }.run()?.momentum;
    let metric = "largest change of the momentum of links and membrane but by the weight, over it, one cycle without air";
    Ok(vec![ComparisonRow::judged(
        "fsi.membrane.momentum",
        "conservation of momentum",
        metric,
        lacking,
        1e-10,
        "",
    )])
}

/// Energy with a membrane for a wing.
pub fn membrane_rows() -> Result<Vec<ComparisonRow>, Error> {
    let metric = "work of drives, dampers and air on links and membrane less change of their energy, over the peak work, one cycle, wings of membrane";
    let lacking = OF_SKIN.run()?.energy;
    Ok(vec![ComparisonRow::judged(
        "fsi.membrane.energy",
        "conservation of energy",
        metric,
        lacking,
        1e-8,
        "",
    )])
}

/// Energy of the membrane alone, by finer steps.
pub fn work_rows() -> Result<Vec<ComparisonRow>, Error> {
    let metric = "work of the air on the membrane less what its tension stores and its damping takes, over all that work, one cycle of the wings";
    let lacking = Trial { step: 0.4 * OF_SKIN.step, ..OF_SKIN }.run()?.membrane;
    Ok(vec![ComparisonRow::judged("fsi.membrane.work", "conservation of energy", metric, lacking, 1e-8, "")])
}

/// Energy of wings on elements that bear their loads.
pub fn element_rows() -> Result<Vec<ComparisonRow>, Error> {
    let metric = "work of drives, actuators, dampers and air less change of energy, over the peak work, one cycle, wings on elements with an inertia";
    let lacking = Trial { elements: true, ..OF_WING }.run()?.energy;
    Ok(vec![ComparisonRow::judged("fsi.element.energy", "conservation of energy", metric, lacking, 1e-8, "")])
}

/// Largest error of the exact derivatives of the rates by states against central differences, over the largest of their row.
fn derivative_error(trial: &Trial) -> Result<f64, Error> {
    let robot = trial.robot()?;
    let (l, n) = (*robot.layout(), robot.states().len());
    // The inertia of a strip's flap is of the order of 1e-8 kg m2.
    let of_hinge = |i: usize| robot.states()[i].unit == "N m s";
    let size = |i: usize| if of_hinge(i) { 2e-7 } else { 0.02 };
    let mut x: Vec<f64> = (0..n).map(|i| size(i) * ((i * 37 % 23) as f64 / 23.0 - 0.4)).collect();
    Quat::from_roll_pitch_yaw(0.2, -0.3, 0.4).store_wxyz(&mut x[l.attitude..]);
    Vec3::new(3.0, 0.1, -0.3).store(&mut x[l.velocity..]);
    let mut exact = Linearisation::new(n, 0);
    exact.evaluate(&robot, 0.03, &x, &[])?;
    let mut worst = 0.0_f64;
    for j in 0..n {
        // The momentum of a strip's membrane is of the order of a millionth; that of a hinge changes its rate by so many rad/s.
        let step = match robot.states()[j].unit {
            "N m s" => 0.07 / (0..n).fold(1.0, |m: f64, i| m.max(exact.a[i * n + j].abs())),
            "N s" => 1e-9,
            _ => 1e-6,
        };
        let rates = |sign: f64| -> Result<Vec<f64>, Error> {
            let (mut moved, mut dx) = (x.clone(), vec![0.0; n]);
            moved[j] += sign * step;
            robot.rates_in_numbers(0.03, &moved, &[], &mut dx)?;
            Ok(dx)
        };
        let (up, down) = (rates(1.0)?, rates(-1.0)?);
        // Rounding asks the hinge for steps that are large for laws with a vortex: to fourth order.
        let far = if of_hinge(j) { Some((rates(2.0)?, rates(-2.0)?)) } else { None };
        for i in 0..n {
            let row = exact.a[i * n..][..n].iter().fold(1.0, |m: f64, v| m.max(v.abs()));
            let near = (up[i] - down[i]) / (2.0 * step);
            let of_far =
                |(up, down): &(Vec<f64>, Vec<f64>)| (4.0 * near - (up[i] - down[i]) / (4.0 * step)) / 3.0;
            let difference = far.as_ref().map_or(near, of_far);
            worst = worst.max((difference - exact.a[i * n + j]).abs() / row);
        }
    }
    Ok(worst)
}

/// Derivatives of such wings under three laws.
pub(super) fn derivatives(id: &str, what: &str, of: Trial) -> Result<Vec<ComparisonRow>, Error> {
    let mut worst = 0.0_f64;
    for law in [LiftLaw::Linear, LiftLaw::Stall, LiftLaw::Lev3d] {
        worst = worst.max(derivative_error(&Trial { law, ..of })?);
    }
    let metric =
        format!("max error of the rates by each state, {what}, three laws, over the largest of the rate");
    Ok(vec![ComparisonRow::judged(id, "central differences", &metric, worst, 1e-6, "")])
}

/// Derivatives with a membrane for a wing.
pub fn derivative_rows() -> Result<Vec<ComparisonRow>, Error> {
    derivatives("fsi.membrane.derivatives", "wings of membrane", OF_SKIN)
}

/// Derivatives, energy and momentum with a flap at the wings.
pub fn flap_rows() -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = derivatives("fsi.flap.flight.derivatives", "wings with a flap", OF_FLAP)?;
    let energy = "work of drives, dampers and air on links and flaps less change of their energy, over the peak work, one cycle, wings with a flap";
    let lacking = OF_FLAP.run()?;
    rows.push(ComparisonRow::judged(
        "fsi.flap.flight.work",
        "conservation of energy",
        energy,
        lacking.energy,
        1e-8,
        "",
    ));
    let momentum =
        "largest change of the momentum of links and flaps but by the weight, over it, one cycle without air";
    let lacking = Trial { density: 1e-12, ..OF_FLAP }.run()?.momentum;
    rows.push(ComparisonRow::judged(
        "fsi.flap.flight.momentum",
        "conservation of momentum",
        momentum,
        lacking,
        1e-10,
        "",
    ));
    Ok(rows)
}
