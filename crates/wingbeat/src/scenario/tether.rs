//! From a case file to a tethered wing and its summary.

use super::tether_spec::{ReadTable, TetherSpec, TetheredWingSpec, WindSpec};
use super::{ConfigError, Document};
use crate::Error;
use crate::aero::{LiftLaw, Planform, ProfileDrag};
use crate::math::Vec3;
use crate::robot::SurfaceOutline;
use crate::simulate::Ending;
use crate::tether::{Clock, CycleMean, Hinge, Motion, Reference, Side, Tether, TetherRun, Wing};
use serde::Serialize;
use std::path::Path;

/// A checked case, ready to run.
#[derive(Debug)]
pub struct TetherCase {
    /// What the file and overrides said.
    pub spec: TetherSpec,
    /// The merged configuration as TOML.
    pub resolved: String,
    /// The wing in its wind.
    pub tether: Tether,
}

impl TetherCase {
    /// Reads, merges and checks a case file; `overrides` are `key=value`, `read`
    /// reads the tables it names.
    ///
    /// # Errors
    /// One message with file, line, key, the value given and what is allowed.
    pub fn load(path: &Path, overrides: &[String], read: ReadTable) -> Result<Self, ConfigError> {
        let document = Document::load(path, overrides, &[])?;
        let spec: TetherSpec = document.parse()?;
        let resolved = document.resolved()?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let tether = spec.build(folder, read).map_err(|error| document.explain(&error))?;
        Ok(Self { spec, resolved, tether })
    }

    /// The numbers of a run, with warnings.
    pub fn summary(&self, run: &TetherRun) -> TetherSummary {
        let law = self.tether.aero.law();
        let share = 100.0 * run.stall_fraction;
        let limit = self.tether.aero.stall_angle().to_degrees();
        let past = format!("{share:.1} % of the strips of the last cycle are past {limit:.0} deg");
        let warning = match law {
            LiftLaw::Linear => format!("{past}, where law linear knows no stall"),
            LiftLaw::Stall => format!("{past}: the result leans on law stall, +-50 % there"),
        };
        TetherSummary {
            status: match run.ending {
                Ending::Complete => "ok".into(),
                Ending::Stopped => "stopped".into(),
                Ending::Fault(fault) => format!("failed: {fault}"),
            },
            name: self.spec.name.clone(),
            preset: self.spec.aero.preset.name(),
            lift_law: law.name(),
            stall_fraction: run.stall_fraction,
            warnings: (run.stall_fraction > 0.0).then_some(warning).into_iter().collect(),
            cycle: run.means.clone(),
        }
    }
}

/// The numbers of a tethered run.
#[derive(Clone, Debug, Serialize)]
pub struct TetherSummary {
    /// `ok`, `stopped`, or what failed.
    pub status: String,
    /// Name of the case.
    pub name: String,
    /// Aerodynamic preset.
    pub preset: &'static str,
    /// Lift law.
    pub lift_law: &'static str,
    /// Share of strips past the stall angle over the last cycle.
    pub stall_fraction: f64,
    /// What to beware of.
    pub warnings: Vec<String>,
    /// Means and ranges over the last cycle.
    pub cycle: Vec<CycleMean>,
}

impl TetherSpec {
    fn build(&self, folder: &Path, read: ReadTable) -> Result<Tether, Error> {
        let clock = Clock {
            frequency_hz: self.time.frequency_hz,
            cycles: self.time.cycles,
            steps_per_cycle: self.time.steps_per_cycle,
        };
        let planform = self.wing.outline().map_err(|e| e.within("wing"))?;
        let drag = ProfileDrag { cd0: self.wing.cd0, cd90: self.wing.cd90 };
        let arcs: Vec<f64> = self.wing.hinges.iter().map(|h| h.arc_m).filter(|arc| *arc > 0.0).collect();
        let wing = self.wing.build(planform.clone())?;
        let outline = SurfaceOutline {
            name: "wing".into(),
            key: "wing".into(),
            planform: planform.clone(),
            hinges: arcs,
            drag,
            strips: None,
        };
        let aero = self.aero.build(&outline, self.wind.density_kg_m3)?;
        let halves = if self.wing.side == Side::Both { 1.0 } else { 0.5 };
        let area = planform.area() * halves;
        let tether = Tether {
            reference: Reference {
                density_kg_m3: self.wind.density_kg_m3,
                speed_m_s: self.reference.speed_m_s.unwrap_or(self.wind.speed_m_s),
                area_m2: self.reference.area_m2.unwrap_or(area),
                chord_m: self
                    .reference
                    .chord_m
                    .unwrap_or(area / (2.0 * halves * planform.covered_half_span())),
            },
            wing,
            motion: self.motion(folder, read)?,
            aero,
            wind: self.wind.velocity(),
            side: self.wing.side,
            clock,
        };
        tether.check()?;
        Ok(tether)
    }

    fn motion(&self, folder: &Path, read: ReadTable) -> Result<Motion, Error> {
        let frequency = self.time.frequency_hz;
        let degree = 1.0_f64.to_radians();
        let body = &self.body;
        let build = |spec: &super::CoordinateSpec, key: &str, factor| {
            spec.build(frequency, factor, folder, read).map_err(|e| e.within(key))
        };
        let hinge = |(i, h): (usize, &super::HingeSpec)| {
            let key = format!("wing.hinges[{i}].angle_deg");
            Ok((h.name.clone(), build(&h.angle_deg, &key, degree)?))
        };
        Ok(Motion {
            surge: build(&body.surge_m, "body.surge_m", 1.0)?,
            heave: build(&body.heave_m, "body.heave_m", 1.0)?,
            nose_up: build(&body.nose_up_deg, "body.nose_up_deg", degree)?,
            roll: build(&body.roll_deg, "body.roll_deg", degree)?,
            axis_ahead_m: body.pitch_axis_ahead_m,
            hinges: self.wing.hinges.iter().enumerate().map(hinge).collect::<Result<_, Error>>()?,
        })
    }
}

impl TetheredWingSpec {
    /// The planform with its gaps.
    fn outline(&self) -> Result<Planform, Error> {
        Planform::new(&self.planform)?.with_gaps(&self.gaps)
    }

    fn build(&self, planform: Planform) -> Result<Wing, Error> {
        let hinge = |h: &super::HingeSpec| Hinge {
            kind: h.kind,
            side: h.side,
            arc_m: h.arc_m,
            to_arc_m: h.to_arc_m,
            ahead_m: h.ahead_m,
        };
        Wing::new(planform, self.hinges.iter().map(hinge).collect()).map_err(|e| e.within("wing"))
    }
}

impl WindSpec {
    /// Velocity of the air in W, m/s.
    fn velocity(&self) -> Vec3 {
        let (up, level) = self.incidence_deg.to_radians().sin_cos();
        let (side, ahead) = self.sideslip_deg.to_radians().sin_cos();
        Vec3::new(-level * ahead, -level * side, up) * self.speed_m_s
    }
}
