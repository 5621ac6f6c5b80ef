//! What a robot file says, before it is checked and built.

mod bound;
mod clearance;
mod gait;
mod given;
mod link;
mod residual;
mod spar;
mod structure;
mod surface;
mod thruster;
mod wing;

pub use bound::BoundSpec;
pub use clearance::{CapsuleSpec, ClearanceSpec};
pub use gait::{GaitSpec, PinSpringSpec};
pub use given::{FitUncertainty, FitVerdict, FittedModel, GivenNumbers};
pub use link::{DrivenSpec, ElasticSpec, JointSpec, LinkSide, LinkSpec, LinkageOutput, StopSpec};
pub use residual::ResidualSpec;
pub use spar::{LinkSparSpec, SparInWing, SparShape};
pub use structure::{ElementSpec, RegulatorSpec, StructureSpec};
pub use surface::{PanelSpec, SurfaceSpec};
pub use thruster::ThrusterSpec;
pub use wing::{WingLinkSpec, WingSpec};

use super::DriveSpec;
use super::mechanism::BODY;
use super::numbers::DRAG_AREA;
use crate::body::INERTIA;
use serde::{Deserialize, Serialize};
use wingbeat_aero::{FlapSpec, MembraneSpec};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require::{finite, principal_inertias};

/// A robot: body, links with their joints, surfaces, gait, structure. `wing` stands for the links
/// and the surface of a pair of two-panelled wings.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotSpec {
    /// Name.
    pub name: String,
    /// Central body.
    pub body: BodySpec,
    /// A pair of wings of two panels each, with sweep, shoulder, elbow and twist joints; the left one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wing: Option<WingSpec>,
    /// Links, each after its parent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub links: Vec<LinkSpec>,
    /// Lifting surfaces beside that of `wing`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<SurfaceSpec>,
    /// Parts whose clearance is watched, beside the halves of symmetric surfaces.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub clearances: Vec<ClearanceSpec>,
    /// What drives the joints over the flapping cycle.
    #[serde(default)]
    pub gait: GaitSpec,
    /// What turns the crank of the gait.
    #[serde(default, skip_serializing_if = "DriveSpec::is_constant")]
    pub drive: DriveSpec,
    /// Small propellers on the body; not beside `structure.regulators` or matrices of the structure.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub thrusters: Vec<ThrusterSpec>,
    /// Response of the structure to its actuators.
    #[serde(default)]
    pub structure: StructureSpec,
    /// Numbers by name, `"surfaces.wing.cd0" = 0.03`, in place of those that follow from the other keys; or a file of such
    /// numbers, as `wingbeat calibrate` writes it. Numbers of the rig (`mount.`, `crank.`, `gait.phase_rad`) count on the rig alone; a flight begins at `start.phase_rad`.
    /// Such a file may carry the `verdict` on its fit: a run that uses numbers of another one than `ok` says so.
    #[serde(default, skip_serializing_if = "GivenNumbers::is_silent")]
    #[schemars(schema_with = "file_or_numbers")]
    pub numbers: GivenNumbers,
    /// A wrench that acts on the body beside the loads of the surfaces: what their model leaves of measured loads; or a file of it, as
    /// `wingbeat calibrate` writes it. A `[lattice]` flies without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "file_or::<ResidualSpec>")]
    pub residual: Option<ResidualSpec>,
}

/// Central body; lengths from the body origin in FLU axes.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct BodySpec {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    #[serde(default)]
    pub com_m: [f64; 3],
    /// Principal inertias about the centre of mass along x, y, z, kg m2.
    pub inertia_kg_m2: [f64; 3],
    /// Drag areas of the body along x, y, z, m2: F_i = -rho/2 A_i |v_i| v_i.
    #[serde(default)]
    pub drag_area_m2: [f64; 3],
    /// Room it takes, from the body origin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capsule: Option<CapsuleSpec>,
}

ranges!(BodySpec { mass_kg: Range::POSITIVE, inertia_kg_m2: INERTIA.range, drag_area_m2: DRAG_AREA.range });

impl BodySpec {
    fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        finite("com_m", &self.com_m)?;
        self.capsule.iter().try_for_each(CapsuleSpec::check)?;
        principal_inertias("inertia_kg_m2", self.inertia_kg_m2)
    }
}

/// The name of a file of numbers, or the numbers.
#[cfg(feature = "schema")]
pub fn file_or_numbers(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({ "anyOf": [{ "type": "string" }, numbers_table(generator)] })
}

/// Numbers by name, with the verdict on their fit and the model that was fitted.
#[cfg(feature = "schema")]
pub fn numbers_table(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": "object",
        "properties": {
            "verdict": generator.subschema_for::<FitVerdict>(),
            "model": generator.subschema_for::<FittedModel>(),
            "uncertainty": generator.subschema_for::<FitUncertainty>()
        },
        "additionalProperties": { "type": "number" }
    })
}

/// The name of a file that holds a `T`, or the `T` itself.
#[cfg(feature = "schema")]
pub fn file_or<T: schemars::JsonSchema>(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let table = generator.subschema_for::<T>();
    schemars::json_schema!({ "anyOf": [{ "type": "string" }, table] })
}

/// The number that is the gait's frequency.
pub const PHASE_RATE: &str = "gait.phase_rate_rad_s";
/// Number that says where the crank is when its encoder shows 0.
pub const PHASE_START: &str = "gait.phase_rad";

/// Whether a number is one of the rig that carries the robot.
pub fn is_of_rig(name: &str) -> bool {
    ["mount.", "crank."].iter().any(|of| name.starts_with(of))
}

/// Whether a number counts on the rig alone: one of what carries the robot there, or of what its encoder shows. A flight begins where
/// its scenario says.
pub fn counts_on_rig_alone(name: &str) -> bool {
    is_of_rig(name) || name == PHASE_START
}

impl RobotSpec {
    /// Checks what the types alone do not: ranges, names, clashes.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.check_names()?;
        self.body.check().map_err(|e| e.within("body"))?;
        if let Some(wing) = &self.wing {
            wing.check().map_err(|e| e.within("wing"))?;
        }
        for (i, link) in self.links.iter().enumerate() {
            link.check(&self.gait).map_err(|e| e.within(&format!("links[{i}]")))?;
        }
        for (i, surface) in self.surfaces.iter().enumerate() {
            surface.check().map_err(|e| e.within(&format!("surfaces[{i}]")))?;
        }
        self.gait.check(self.wing.is_some()).map_err(|e| e.within("gait"))?;
        self.drive.build().map_err(|e| e.within("drive"))?;
        self.structure.check().map_err(|e| e.within("structure"))?;
        self.check_thrusters()?;
        self.residual.iter().try_for_each(|residual| residual.check().map_err(|e| e.within("residual")))?;
        match self.numbers.get(PHASE_RATE) {
            None => Ok(()),
            Some(rate) => {
                let key = format!("numbers.\"{PHASE_RATE}\"");
                let allowed =
                    format!("no such number: the frequency is gait.{}.frequency_hz", self.gait.kind());
                Err(Error::invalid(key, rate, allowed))
            }
        }
    }

    /// Whether anything of it has a stiffness: a spring on a joint or pin, a spar, a flap or a membrane.
    pub fn gives_way(&self) -> bool {
        let joint =
            |link: &LinkSpec| link.spar.is_some() || link.elastic.is_some_and(|of| of.stiffness > 0.0);
        let skin = |membrane: &Option<MembraneSpec>, flap: &Option<FlapSpec>| {
            membrane.is_some() || flap.is_some_and(|of| of.stiffness_n_rad > 0.0)
        };
        self.links.iter().any(joint)
            || self.wing.iter().any(|wing| skin(&wing.membrane, &wing.flap))
            || self.surfaces.iter().any(|surface| skin(&surface.membrane, &surface.flap))
            || matches!(&self.gait, GaitSpec::Linkage { springs, .. } if springs.iter().any(|of| of.stiffness > 0.0))
    }

    /// The parts with a name: the key of each, and the name. Those of one list are told apart by them: links and their joints,
    /// surfaces, elements with thrusters, actuators.
    pub fn named_parts(&self) -> [Vec<(String, &str)>; 4] {
        fn parts<'a>(list: &str, names: impl Iterator<Item = &'a str>) -> Vec<(String, &'a str)> {
            names.enumerate().map(|(i, name)| (format!("{list}[{i}].name"), name)).collect()
        }
        let Self { links, surfaces, structure, thrusters, .. } = self;
        let mut elements = parts("structure.elements", structure.elements.iter().map(|e| e.name.as_str()));
        elements.extend(parts("thrusters", thrusters.iter().map(|t| t.name.as_str())));
        [
            parts("links", links.iter().map(|link| link.name.as_str())),
            parts("surfaces", surfaces.iter().map(|surface| surface.name.as_str())),
            elements,
            parts("structure.regulators", structure.regulators.iter().map(|r| r.name.as_str())),
        ]
    }

    /// Refuses blank names, names that come twice among parts that they tell apart, and links with the name of the base.
    fn check_names(&self) -> Result<(), Error> {
        if let Some(i) = self.links.iter().position(|link| link.name == BODY) {
            let allowed = format!("another name: {BODY} is the floating base");
            return Err(Error::invalid(format!("links[{i}].name"), format!("{BODY:?}"), allowed));
        }
        for parts in self.named_parts() {
            for (i, (key, name)) in parts.iter().enumerate() {
                let taken = parts[..i].iter().find(|(_, other)| other == name);
                let allowed = match taken {
                    Some((other, _)) => format!("a name of its own: {other} is the same"),
                    None if name.trim().is_empty() => "a name that is not blank".into(),
                    None => continue,
                };
                return Err(Error::invalid(key, format!("{name:?}"), allowed));
            }
        }
        Ok(())
    }

    fn check_thrusters(&self) -> Result<(), Error> {
        for (i, thruster) in self.thrusters.iter().enumerate() {
            thruster.check().map_err(|e| e.within(&format!("thrusters[{i}]")))?;
        }
        let s = &self.structure;
        let elements = s.elements.len() + self.thrusters.len();
        if elements > super::MAX_ELEMENTS {
            let allowed = format!("with the structure's elements at most {}", super::MAX_ELEMENTS);
            return Err(Error::invalid("thrusters", elements, allowed));
        }
        let matrices = s.a.is_some() || s.stiffness_per_s2.is_some();
        if !self.thrusters.is_empty() && (matrices || !s.regulators.is_empty()) {
            let allowed = "no thrusters beside regulators or matrices of the structure";
            return Err(Error::invalid("thrusters", "given", allowed));
        }
        Ok(())
    }

    /// The same with the thrusters among the elements, after the others.
    pub(super) fn with_thrusts(&self) -> Self {
        let mut all = self.clone();
        let thrusts = self.thrusters.iter().enumerate().map(|(i, thruster)| thruster.element(i));
        all.structure.elements.extend(thrusts);
        all
    }

    /// The numbers given by name that are the robot's own, in their declared units.
    pub fn own_numbers(&self) -> Vec<(&str, f64)> {
        let own = self.numbers.iter().filter(|(name, _)| !is_of_rig(name));
        own.map(|(name, value)| (name.as_str(), *value)).collect()
    }

    /// Stops the flapping and takes away whatever motor turns the crank, with its numbers.
    pub fn hold_still(&mut self) {
        self.gait.set_frequency_hz(0.0);
        self.drive = DriveSpec::default();
        let of_motor =
            |name: &str| name.split_once('.').is_some_and(|(of, _)| DriveSpec::NAMES.contains(&of));
        self.numbers.retain(|name, _| !of_motor(name));
    }
}
