//! What a case file of a tethered wing says.

use super::CompareSpec;
use crate::motion_table::TableSpec;
use crate::spar_spec::SparSpec;
use crate::verdict_limits::VerdictLimits;
use crate::{AeroSpec, RunName};
use serde::{Deserialize, Serialize};
use std::path::Path;
use wingbeat_aero::{CD0, CD90, DENSITY, FlapSpec, Gap, MembraneSpec, PlanformStation, SectionSpec};
use wingbeat_flight::simulate::Record;
use wingbeat_flight::tether::{Clock, HingeKind, Side};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;
use wingbeat_robot::GivenNumbers;

/// A wing in prescribed motion in a wind.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TetherSpec {
    /// Name; the run folder is called after it.
    pub name: String,
    /// The wing with its hinges.
    pub wing: TetheredWingSpec,
    /// Beams that carry its halves, so that the air bends them; without, the wing is rigid between its hinges.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spar: Option<SparSpec>,
    /// Motion of the body.
    #[serde(default)]
    pub body: TetheredBodySpec,
    /// Wind.
    pub wind: WindSpec,
    /// Aerodynamic model.
    pub aero: AeroSpec,
    /// Cycles and steps.
    pub time: ClockSpec,
    /// Scales of the coefficients.
    #[serde(default)]
    pub reference: ReferenceSpec,
    /// How a measured file is read that the loads are compared with.
    #[serde(default, skip_serializing_if = "CompareSpec::is_empty")]
    pub compare: CompareSpec,
    /// Limits of the verdict in place of the usual ones, by name: `data.frequency_fraction = 0.02`.
    #[serde(default, skip_serializing_if = "VerdictLimits::is_empty")]
    pub limits: VerdictLimits,
    /// Numbers by name, `"surfaces.wing.cd0" = 0.03` and `"air.density_kg_m3"`, in place of those that follow from the other
    /// keys; or a file of such numbers, as `wingbeat calibrate` writes it. Numbers of what a wing alone has not (`body.`,
    /// `links.`, `gait.`, `mount.`, `crank.`) do not count.
    #[serde(default, skip_serializing_if = "GivenNumbers::is_silent")]
    #[schemars(schema_with = "wingbeat_robot::file_or_numbers")]
    pub numbers: GivenNumbers,
}

/// Planform, profile drag and hinges.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct TetheredWingSpec {
    /// Stations of the half wing from the plane of symmetry to the tip; or in a file, `{ file = "outline.csv", unit = "mm", x = "aft" }` (docs/robots.md).
    pub planform: Vec<PlanformStation>,
    /// Where there is no wing; preset `full` only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<Gap>,
    /// Both halves, or one with a mirror plane at its root.
    #[serde(default)]
    pub side: Side,
    /// Drag coefficient along the chord; where not given 0 under law `linear`, that of a laminar plate under laws that
    /// separate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cd0: Option<f64>,
    /// Drag coefficient of the plate broadside on; where not given 0 under law `linear`, that of a flat plate under
    /// laws that separate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cd90: Option<f64>,
    /// What laws `stall` and `lev` need of its section, where it differs from the scenario's.
    #[serde(default, skip_serializing_if = "SectionSpec::is_empty")]
    pub section: SectionSpec,
    /// Membrane between its leading and trailing edge; rigid where not given. Preset `full` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub membrane: Option<MembraneSpec>,
    /// Flap at its trailing edge, turned by the air against a spring; none where not given. Preset `full` only, and not of a membrane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flap: Option<FlapSpec>,
    /// Hinges from body to tip; each turns what lies outboard of it.
    #[serde(default)]
    pub hinges: Vec<HingeSpec>,
}

ranges!(TetheredWingSpec { cd0: CD0.range, cd90: CD90.range });

/// One hinge.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HingeSpec {
    /// Name, unique.
    pub name: String,
    /// What it turns.
    pub kind: HingeKind,
    /// Which half has it.
    #[serde(default)]
    pub side: Side,
    /// Arc at which it lies, m.
    #[schemars(extend("minimum" = 0.0))]
    pub arc_m: f64,
    /// For a twist that grows evenly from `arc_m` to here, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0.0))]
    pub to_arc_m: Option<f64>,
    /// Place of a twist or sweep axis ahead of the hinge line, m.
    #[serde(default)]
    pub ahead_m: f64,
    /// Angle over time, deg.
    pub angle_deg: CoordinateSpec,
}

/// Motion of the body.
#[derive(Clone, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TetheredBodySpec {
    /// Forward, m.
    pub surge_m: CoordinateSpec,
    /// Up, m.
    pub heave_m: CoordinateSpec,
    /// Nose up, deg.
    pub nose_up_deg: CoordinateSpec,
    /// Right wing down, deg.
    pub roll_deg: CoordinateSpec,
    /// Place of the pitch axis ahead of the hinge line, m.
    pub pitch_axis_ahead_m: f64,
}

/// A coordinate over time.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum CoordinateSpec {
    /// Always the same, in the unit of the key.
    Constant(f64),
    /// Harmonics of the case's frequency.
    Fourier(FourierSpec),
    /// A smooth curve through a table in a CSV file.
    Table(TableSpec),
}

impl Default for CoordinateSpec {
    fn default() -> Self {
        Self::Constant(0.0)
    }
}

/// `mean + sum_n cos[n] cos((n+1) phase) + sin[n] sin((n+1) phase)`.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FourierSpec {
    /// Mean, in the unit of the key.
    #[serde(default)]
    pub mean: f64,
    /// Cosine amplitudes from the first harmonic on, in the unit of the key.
    #[serde(default)]
    pub cos: Vec<f64>,
    /// Sine amplitudes from the first harmonic on, in the unit of the key.
    #[serde(default)]
    pub sin: Vec<f64>,
}

/// Wind.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct WindSpec {
    /// Speed, m/s; in still air, 0, the coefficients need a `reference.speed_m_s`, and a negative wind comes from behind.
    pub speed_m_s: f64,
    /// Angle by which it comes from below, deg.
    #[serde(default)]
    pub incidence_deg: f64,
    /// Angle by which it comes from the left, deg.
    #[serde(default)]
    pub sideslip_deg: f64,
    /// Density, kg/m3.
    pub density_kg_m3: f64,
    /// Height of a plane that the air does not cross, m in W, where the body's origin begins at 0: ground below the wing or a ceiling
    /// above it, by mirror images. Preset `full` and the lattice feel it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground_m: Option<f64>,
}

ranges!(WindSpec { density_kg_m3: DENSITY.range });

/// Cycles and steps.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put_known(Clock::RANGES))]
#[serde(deny_unknown_fields)]
pub struct ClockSpec {
    /// Cycles per second; of a motion that is not periodic, one over its duration.
    pub frequency_hz: f64,
    /// Number of cycles from rest.
    pub cycles: usize,
    /// Steps per cycle.
    pub steps_per_cycle: usize,
}

/// Scales of the coefficients; by default the wind's speed, the planform's area
/// and its mean chord.
#[derive(Clone, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct ReferenceSpec {
    /// Speed, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<f64>,
    /// Area, m2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area_m2: Option<f64>,
    /// Length of the pitching-moment coefficient, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chord_m: Option<f64>,
}

/// Reads the columns of a CSV file; the text says what is wrong with it.
pub type ReadTable<'a> = &'a dyn Fn(&Path) -> Result<Record, String>;

ranges!(ReferenceSpec { speed_m_s: Range::POSITIVE, area_m2: Range::POSITIVE, chord_m: Range::POSITIVE });

impl ClockSpec {
    /// Cycles and steps.
    pub(super) fn clock(&self) -> Clock {
        let Self { frequency_hz, cycles, steps_per_cycle } = *self;
        Clock { frequency_hz, cycles, steps_per_cycle }
    }
}

impl TetherSpec {
    /// The checked name.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key `name`.
    pub fn run_name(&self) -> Result<RunName, Error> {
        RunName::new("name", &self.name)
    }

    /// Checks what each table says by itself.
    pub(super) fn check(&self) -> Result<(), Error> {
        self.run_name()?;
        self.wing.in_range().map_err(|e| e.within("wing"))?;
        self.time.clock().in_range().map_err(|e| e.within("time"))?;
        self.wind.in_range().map_err(|e| e.within("wind"))?;
        require::finite("wind.ground_m", self.wind.ground_m.as_slice())?;
        self.wing.section.check().map_err(|e| e.within("wing.section"))?;
        self.wing.membrane.iter().try_for_each(|m| m.check().map_err(|e| e.within("wing.membrane")))?;
        self.wing.flap.iter().try_for_each(|f| f.check().map_err(|e| e.within("wing.flap")))?;
        self.compare.check().map_err(|e| e.within("compare"))?;
        for (i, hinge) in self.wing.hinges.iter().enumerate() {
            if let Some(k) = self.wing.hinges[..i].iter().position(|other| other.name == hinge.name) {
                let (key, given) = (format!("wing.hinges[{i}].name"), format!("{:?}", hinge.name));
                let error = Error::invalid(key, given, "a name that no other hinge has");
                return Err(error.against([format!("wing.hinges[{k}].name")]));
            }
        }
        self.reference.in_range().map_err(|e| e.within("reference"))
    }
}
