//! What a scenario file says, before it is checked and built.

use super::chosen::{Chosen, Named};
use super::dryden::DrydenSpec;
use super::lattice::LatticeSpec;
use super::mismatch::Mismatch;
use super::perch::PerchSpec;
use super::plan::PlanSpec;
use super::trim::TrimSpec;
use super::verdict_limits::VerdictLimits;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wingbeat_aero::{
    CRITICAL_SUCTION, LIFT_SLOPE, LagSet, LagSpeed, LiftLaw, LiftTilt, Preset, STALL_ANGLE, StripSettings,
    ZERO_LIFT_ANGLE,
};
use wingbeat_flight::guide::{MpcSpec, PathSpec, Turn};
use wingbeat_flight::simulate::SensorSpec;
use wingbeat_math::Error;
use wingbeat_math::order::ascend;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;
use wingbeat_robot::RobotSpec;

/// A flight: robot, air, start, manoeuvre, controller.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScenarioSpec {
    /// Name; the run folder is called after it.
    pub name: String,
    /// Seed of everything random: gust, sensor noise.
    #[serde(default)]
    pub seed: u64,
    /// The robot; a scenario names its file.
    #[schemars(schema_with = "crate::schema::file_or::<RobotSpec>")]
    pub robot: RobotSpec,
    /// Air.
    pub air: AirSpec,
    /// Aerodynamic model.
    pub aero: AeroSpec,
    /// The vortex lattice in place of the model's attached flow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lattice: Option<LatticeSpec>,
    /// State at t = 0.
    #[serde(default)]
    pub start: StartSpec,
    /// Clock.
    pub flight: FlightSpec,
    /// What to fly; needed by a predictive controller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub manoeuvre: Option<Chosen<Turn>>,
    /// The periodic flight that `wingbeat trim` looks for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trim: Option<TrimSpec>,
    /// What is flown along; needed by a controller that tracks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<PathSpec>,
    /// A perch beside the flight. Only the robot that flies meets it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub perch: Option<PerchSpec>,
    /// What `wingbeat plan` plans.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan: Option<PlanSpec>,
    /// The controller; without it every actuator rests.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller: Option<Chosen<MpcSpec>>,
    /// Horizon solver of the predictive controller, if not the shipped one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solver: Option<Named>,
    /// Sensors between robot and controller; without them the state is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<SensorSpec>,
    /// How the flown robot differs from the one the controller knows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mismatch: Option<Mismatch>,
    /// What counts as held.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal: Option<GoalSpec>,
    /// Limits of the verdict in place of the usual ones, by name: `flight.altitude_m = 3.0`.
    #[serde(default, skip_serializing_if = "VerdictLimits::is_empty")]
    pub limits: VerdictLimits,
    /// Published numbers of this very case, printed beside the run's. An override of anything but `name`, `paper` and what
    /// is recorded makes it another case: then they are left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper: Option<PaperResults>,
}

/// Air.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct AirSpec {
    /// Density, kg/m3; 0 is a vacuum, in which surfaces bear no load and have no states.
    pub density_kg_m3: f64,
    /// Wind velocity in W, m/s; none beside `[controller.orbit]`.
    #[serde(default)]
    pub wind_m_s: [f64; 3],
    /// Height of a plane that the air does not cross, m in W: ground beneath the robot, or a ceiling above it. Surfaces of preset `full`
    /// and the lattice feel the mirror images of all vortices; controllers do not know of it. Without it there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground_m: Option<f64>,
    /// Largest gust along each axis, m/s; the controller does not know of it.
    #[serde(default)]
    pub gust_m_s: f64,
    /// Gusts at stated times, of which the controller does not know either.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gusts: Vec<GustSpec>,
    /// Continuous turbulence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dryden: Option<DrydenSpec>,
}

/// A gust at a stated time: a velocity that swells and goes, (1 - cos) / 2 of its largest, the same everywhere.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct GustSpec {
    /// Begin, s.
    pub start_s: f64,
    /// From begin to end, s.
    pub duration_s: f64,
    /// Largest velocity, in the middle of that time, in W, m/s.
    pub velocity_m_s: [f64; 3],
}

impl AirSpec {
    /// Times at which gusts start and end, in their order, s.
    pub(super) fn breaks(&self) -> Vec<f64> {
        let ends = |gust: &GustSpec| [gust.start_s, gust.start_s + gust.duration_s];
        let mut times: Vec<f64> = self.gusts.iter().flat_map(ends).collect();
        ascend(&mut times);
        times
    }

    /// Checks ranges.
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        require::finite("wind_m_s", &self.wind_m_s)?;
        require::finite("ground_m", self.ground_m.as_slice())?;
        if let Some(dryden) = &self.dryden {
            dryden.turbulence(0.0).map_err(|e| e.within("dryden"))?;
        }
        let mut gusts = self.gusts.iter().enumerate();
        let one = |gust: &GustSpec| {
            gust.in_range().and_then(|()| require::finite("velocity_m_s", &gust.velocity_m_s))
        };
        gusts.try_for_each(|(i, gust)| one(gust).map_err(|e| e.within(&format!("gusts[{i}]"))))
    }
}

/// Aerodynamic model.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct AeroSpec {
    /// Which model.
    #[serde(default)]
    pub preset: Preset,
    /// Lift law.
    pub law: LiftLaw,
    /// Angle of attack beyond which a strip counts as stalled, and at which laws `stall` and `lev` have their largest
    /// attached lift, deg; where a surface says none of its own.
    #[serde(default = "default_stall_angle")]
    pub stall_angle_deg: f64,
    /// Dimensionless leading-edge suction parameter A0 beyond which the edge holds no more suction, for law `lev`; where a
    /// surface says none of its own.
    #[serde(default = "default_critical_suction")]
    pub critical_suction: f64,
    /// Angle of attack of the chord at which the section bears no lift, deg, negative with camber upward; where a surface says
    /// none of its own.
    #[serde(default = "default_zero_lift_angle")]
    pub zero_lift_angle_deg: f64,
    /// Lift slope of the section in plane flow, 1/rad; where a surface says none of its own.
    #[serde(default = "default_lift_slope")]
    pub lift_slope_per_rad: f64,
    /// Reaction of the accelerated air. Preset `as_printed` has none, nor any of the next two.
    #[serde(default = "yes")]
    pub added_mass: bool,
    /// Moment of pitching about the quarter chord.
    #[serde(default = "yes")]
    pub section_moment: bool,
    /// Leading-edge suction that the sections' rate of pitch adds.
    #[serde(default = "yes")]
    pub pitch_suction: bool,
    /// Settings of presets `paper` and `as_printed`.
    #[serde(default)]
    pub paper: PaperAeroSpec,
    /// Settings of preset `full`.
    #[serde(default)]
    pub full: FullAeroSpec,
}

/// Settings of presets `paper` and `as_printed`.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put_known(wingbeat_aero::LiftingLineSettings::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct PaperAeroSpec {
    /// Interior nodes over the full span.
    pub nodes: usize,
    /// Airspeed below which flow quantities are rounded off, m/s.
    pub regularisation_m_s: f64,
    /// Smallest chord, m.
    pub chord_floor_m: f64,
    /// Whether nodes stand for cells between the hinges, with means of the chord, instead of even angles.
    pub cells: bool,
    /// Under `as_printed`: the speed by which the reduced time of the lags runs.
    pub lag_speed: LagSpeed,
    /// Under `as_printed`: what turns the lift from the normal to the wind of motion.
    pub lift_tilt: LiftTilt,
    /// Under `as_printed`: whether the sections have their quasi-steady profile drag, cd0 + cd90 sin^2(angle of attack), which
    /// equations (1) to (4) lack.
    pub printed_drag: bool,
}

impl Default for PaperAeroSpec {
    fn default() -> Self {
        Self {
            nodes: 12,
            regularisation_m_s: 0.1,
            chord_floor_m: 0.01,
            cells: false,
            lag_speed: LagSpeed::default(),
            lift_tilt: LiftTilt::default(),
            printed_drag: false,
        }
    }
}

/// Settings of preset `full`; each ingredient can be left out to show its effect.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put_known(StripSettings::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct FullAeroSpec {
    /// Strips over both wings and body.
    pub strips: usize,
    /// Airspeed below which flow quantities are rounded off, m/s.
    pub regularisation_m_s: f64,
    /// Lags carried per strip.
    pub lags: LagSet,
    /// Three-dimensional wash of bound and shed circulation.
    pub wake_wash: bool,
    /// Three-dimensional wash of the potential jump on the chord.
    pub doublet_wash: bool,
    /// Rates of that downwash as the wing folds and the wake turns, in the force of the added mass: one state more per strip. Without
    /// them that force has a mean over a cycle, 5 % of the lift of Aerobat on its stand; without added mass there is none.
    pub folding_rates: bool,
    /// Impulse of the bound circulation as a section turns about its chord and drifts along its span: a spanwise force and a couple.
    /// Without it a rectangular wing that folds by 50 degrees in the upstroke lifts 25 % more than the free lattice, with it as much. On
    /// wings with a swept trailing edge it is too large: over the cycle the lift of shipped gaits errs by 0.39 to 0.52 of its rms with
    /// it, by 0.20 to 0.27 with `edge_suction`. Where it is not given it is on, unless `edge_suction` is; false alone leaves that on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turning_impulse: Option<bool>,
    /// Suction square to swept leading edges and of the side edges at the tips along the span, and the pressure where sections drift
    /// along it. The rectangular wing that folds lifts 8 % less than the free lattice with it; over the cycle the lift of shipped gaits
    /// errs by 0.20 to 0.27 of its rms. On unless `turning_impulse` is true. Surfaces with a membrane, a flap or one strip keep to
    /// `turning_impulse`, and true is refused where all are such. Both are true where surfaces are of both kinds, and else refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge_suction: Option<bool>,
    /// Vortices above the tips of a wing that ends in sharp side edges, after Lamar: a normal force that grows with the square of the
    /// lift. A plate of aspect ratio 2 lifts a twentieth more with it at 5 degrees, a tenth at 10; past stall and in fast motion too much.
    pub side_edges: bool,
    /// Distance at which the downwash of a vortex on a strip is half faded, over the distance at which the
    /// two pass on the flat wing: 0.01 to 0.5.
    pub vortex_core: f64,
    /// Turning of the force by the downwash of wake and lags: induced drag.
    pub force_tilt: bool,
}

impl Default for FullAeroSpec {
    fn default() -> Self {
        let set = StripSettings::default();
        Self {
            strips: set.strips,
            regularisation_m_s: set.regularisation_m_s,
            lags: set.lags,
            wake_wash: set.wake_wash,
            doublet_wash: set.doublet_wash,
            folding_rates: set.folding_rates,
            turning_impulse: set.turning_impulse,
            edge_suction: set.edge_suction,
            side_edges: set.side_edges,
            vortex_core: set.vortex_core,
            force_tilt: set.force_tilt,
        }
    }
}

fn yes() -> bool {
    true
}

fn default_stall_angle() -> f64 {
    STALL_ANGLE.default
}

fn default_critical_suction() -> f64 {
    CRITICAL_SUCTION.default
}

fn default_zero_lift_angle() -> f64 {
    ZERO_LIFT_ANGLE.default
}

fn default_lift_slope() -> f64 {
    LIFT_SLOPE.default
}

/// State at t = 0; what is not given is 0.
#[derive(Clone, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct StartSpec {
    /// Velocity v_WB_W, m/s.
    pub velocity_m_s: [f64; 3],
    /// Roll, deg; positive is right wing down.
    pub roll_deg: f64,
    /// Pitch, deg; positive is nose up.
    pub nose_up_deg: f64,
    /// Heading, deg.
    pub yaw_deg: f64,
    /// Phase of the gait, rad.
    pub phase_rad: f64,
    /// Angular rate w_WB_B, rad/s.
    #[serde(skip_serializing_if = "is_zero")]
    pub rate_rad_s: [f64; 3],
    /// States of elastic joints and of the air by the names of their columns, in the unit of the column; what is not
    /// given starts at rest.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub states: BTreeMap<String, f64>,
    /// Commands in force from the start by the names of their columns and in the units of these: the structure starts displaced
    /// by them, and without a controller they are held.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub commands: BTreeMap<String, f64>,
}

fn is_zero(vector: &[f64; 3]) -> bool {
    *vector == [0.0; 3]
}

/// Clock.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct FlightSpec {
    /// Duration, s.
    pub duration_s: f64,
    /// Integration step, s.
    pub step_s: f64,
    /// Error of the last position that all steps may make, m: they are as long as it allows, and `step_s` is the clock. Without it all are equal.
    /// A controller flies twice, the second time within a tenth of it, and the distance of the ends is held against it too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_m: Option<f64>,
    /// Time of the inertance of springs, s, so that steps of this time follow any of them: what vibrates faster is slowed to it. Where not given:
    /// the step, if the structure is too fast for it, else none; none with `error_m`. The robot that a controller or a trim knows takes the
    /// longest of their steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertance_s: Option<f64>,
    /// Time between records, s. Means, powers and least clearance are those of the records: 32 or more in a cycle.
    pub record_every_s: f64,
    /// Time between records of the loads of every strip, s: whole records; without it there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record_strips_every_s: Option<f64>,
    /// Whether the wings flap; else they stay at the starting phase.
    #[serde(default = "yes")]
    pub flapping: bool,
}

/// What counts as held, from `settle_s` on.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct GoalSpec {
    /// Start of the means, s; a flight that ends before is not judged.
    pub settle_s: f64,
    /// Largest root mean square of roll minus reference, deg.
    pub roll_within_deg: f64,
    /// Largest root mean square of pitch minus reference, deg.
    pub pitch_within_deg: f64,
    /// Largest difference of the altitude from that at the start, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub altitude_within_m: Option<f64>,
    /// Least and largest mean ground speed, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_between_m_s: Option<[f64; 2]>,
    /// Least clearance over the whole flight, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clearance_m: Option<f64>,
}

ranges!(AeroSpec {
    stall_angle_deg: STALL_ANGLE.range,
    critical_suction: CRITICAL_SUCTION.range,
    zero_lift_angle_deg: ZERO_LIFT_ANGLE.range,
    lift_slope_per_rad: LIFT_SLOPE.range,
});
ranges!(AirSpec { density_kg_m3: Range::NOT_NEGATIVE, gust_m_s: Range::NOT_NEGATIVE });
ranges!(GustSpec { start_s: Range::NOT_NEGATIVE, duration_s: Range::POSITIVE });
ranges!(StartSpec {
    velocity_m_s: Range::between(-1000.0, 1000.0),
    roll_deg: Range::between(-180.0, 180.0),
    nose_up_deg: Range::between(-180.0, 180.0),
    yaw_deg: Range::between(-360.0, 360.0),
    rate_rad_s: Range::between(-1000.0, 1000.0),
});
ranges!(FlightSpec {
    duration_s: Range::POSITIVE,
    step_s: Range::POSITIVE,
    error_m: Range::POSITIVE,
    inertance_s: Range::between(0.0, 1.0),
    record_every_s: Range::POSITIVE,
    record_strips_every_s: Range::POSITIVE,
});
ranges!(GoalSpec {
    settle_s: Range::NOT_NEGATIVE,
    roll_within_deg: Range::POSITIVE,
    pitch_within_deg: Range::POSITIVE,
    altitude_within_m: Range::POSITIVE,
});

impl GoalSpec {
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        self.speed_between_m_s.map_or(Ok(()), |speeds| require::range("speed_between_m_s", speeds))
    }
}

/// Published numbers.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaperResults {
    /// Roll in the turn, deg.
    pub roll_deg: f64,
    /// Pitch, deg; positive is nose up.
    pub nose_up_deg: f64,
    /// Oscillation of pitch, from and to, deg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pitch_oscillation_deg: Option<[f64; 2]>,
    /// Distance along x, m.
    pub distance_x_m: f64,
    /// Distance along y, m, without sign.
    pub distance_y_m: f64,
}
