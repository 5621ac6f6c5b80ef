//! What the files of runs on the test rig say, and the checks of it.

use super::{AeroSpec, AirSpec, LatticeSpec, RigTruthSpec, VerdictLimits, build};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::path::PathBuf;
use wingbeat_flight::simulate::follow;
use wingbeat_math::Error;
use wingbeat_math::Vec3;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;
use wingbeat_rig::arm::{ArmConfig, LinkConfig, ToolConfig};
use wingbeat_rig::carrier::CellMount;
use wingbeat_rig::cell::CellSpec;
use wingbeat_rig::plan::TurnSpec;
use wingbeat_rig::process::{InputSpec, PhaseSource, Steps};
use wingbeat_robot::{Air, Robot, RobotSpec, Wind};

/// One run as written in a file.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct RigRunSpec {
    /// Name; the run folder is called after it.
    pub name: String,
    /// Seed of the cell's noise; without it the run's number in its list, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// The rig; a run names its file.
    #[schemars(schema_with = "crate::schema::file_or::<RigSpec>")]
    pub rig: RigSpec,
    /// Another limit profile than the rig's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<String>,
    /// Wind in the arm's base frame, m/s, other than the rig's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wind_m_s: Option<[f64; 3]>,
    /// Flapping frequency, Hz, other than the robot's; 0 holds the wings still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// A banking turn on the arm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn: Option<TurnSpec>,
    /// Attitudes held one after another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold: Option<HoldSpec>,
    /// The vortex lattice in place of the model's attached flow, where the run is simulated; processing knows the model alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lattice: Option<LatticeSpec>,
    /// Corrections made by processing.
    #[serde(default)]
    pub process: ProcessSpec,
    /// Limits of the verdicts on the run and its samples, in place of those of the table: `data.drift_fraction = 0.3`.
    #[serde(default, skip_serializing_if = "VerdictLimits::is_empty")]
    pub limits: VerdictLimits,
}

/// A file that lists runs.
#[derive(Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RunList {
    /// Run files, relative to the list.
    pub(super) runs: Vec<PathBuf>,
}

/// Attitudes of the body held one after another, without motion between.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct HoldSpec {
    /// Roll and pitch of the body, deg; FLU: negative pitch is nose up.
    pub tilts_deg: Vec<[f64; 2]>,
    /// Time in each, s.
    pub each_s: f64,
}

/// How the samples become wrenches.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct ProcessSpec {
    /// Corrections.
    pub steps: Steps,
    /// Where the phase comes from.
    pub phase: PhaseSource,
    /// Phases of the average.
    pub bins: usize,
    /// Start and end of what is averaged, s from the start of the run; without it the steady
    /// turn, or what follows the start of the flapping.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window_s: Option<[f64; 2]>,
    /// What becomes of samples at the end of the cell's range.
    pub saturated: Saturated,
    /// Name of a run in still air, processed with this one, whose average is taken away.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub still_air: Option<String>,
    /// Whether this run's simulation stands for all when several are processed together.
    pub reference: bool,
    /// How measured files are to be read.
    pub input: InputSpec,
}

/// What becomes of samples at the end of the cell's range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Saturated {
    /// The run is refused.
    Refuse,
    /// Their cycles are left out.
    LeaveOut,
    /// They are used as they are.
    Keep,
}

/// Longest rest, spin-up and time in all attitudes together, s.
const LONGEST_S: f64 = 3600.0;
/// Most samples of a run: 3 GB in memory.
const MAX_SAMPLES: f64 = 4e6;
/// Fewest samples of a stroke that a cell takes: its tenth harmonic is at their Nyquist frequency. *Choice.*
const STROKE_SAMPLES: f64 = 20.0;
/// Most phases of an average.
const MAX_BINS: f64 = 1e4;

ranges!(HoldSpec { each_s: Range::POSITIVE });
ranges!(ProcessSpec { bins: Range::between(2.0, MAX_BINS) });
ranges!(RigSpec {
    clearance_m: Range::NOT_NEGATIVE,
    singularity_margin: Range::NOT_NEGATIVE,
    rest_s: Range::between(0.0, LONGEST_S),
    spin_up_s: Range::between(0.0, LONGEST_S),
});
ranges!(EnvelopeSpec {
    half_span_m: Range::POSITIVE,
    low_rad: Range::inside(-PI, PI),
    high_rad: Range::inside(-PI, PI),
    front_m: Range::NOT_NEGATIVE,
    back_m: Range::NOT_NEGATIVE,
});
ranges!(RigRunSpec { frequency_hz: Range::NOT_NEGATIVE });

impl ProcessSpec {
    /// Refuses values without meaning.
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        self.steps.in_range().map_err(|e| e.within("steps"))?;
        self.input.check().map_err(|e| e.within("input"))?;
        self.window_s.map_or(Ok(()), |window| require::range("window_s", window))
    }
}

impl Default for ProcessSpec {
    fn default() -> Self {
        Self {
            steps: Steps::default(),
            phase: PhaseSource::Encoder,
            bins: 200,
            window_s: None,
            saturated: Saturated::Refuse,
            still_air: None,
            reference: false,
            input: InputSpec::default(),
        }
    }
}

/// The hardware.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct RigSpec {
    /// The robot; a rig names its file.
    #[schemars(schema_with = "crate::schema::file_or::<RobotSpec>")]
    pub robot: RobotSpec,
    /// The arm; a rig names its file: TOML, or `FILE.urdf`, `FILE.urdf#TIP` where it has several ends.
    #[schemars(schema_with = "crate::schema::file_or::<ArmConfig>")]
    pub arm: ArmConfig,
    /// Limit profile of the arm.
    pub profile: String,
    /// Height of the table in the arm's base frame, m.
    #[serde(default)]
    pub table_m: f64,
    /// Smallest clearance to table, arm and wings, m.
    pub clearance_m: f64,
    /// Smallest singular value of the Jacobian, m/rad.
    pub singularity_margin: f64,
    /// Air.
    pub air: AirSpec,
    /// Aerodynamic model.
    pub aero: AeroSpec,
    /// Cell and what holds the robot on it.
    pub mount: MountSpec,
    /// The cell.
    pub cell: CellSpec,
    /// Space that the wings sweep.
    pub envelope: EnvelopeSpec,
    /// Rest before a run, s.
    pub rest_s: f64,
    /// Time in which flapping starts, s.
    #[serde(default)]
    pub spin_up_s: f64,
    /// The bench where it is simulated, in place of what the files say; processing does not know of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth: Option<RigTruthSpec>,
}

/// Cell and mount.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MountSpec {
    /// Sensing frame of the cell in the tool frame.
    pub cell: ToolConfig,
    /// Robot body in the sensing frame.
    pub body: ToolConfig,
    /// What lies between sensing element and robot, in the sensing frame.
    #[serde(default)]
    pub link: LinkConfig,
}

impl MountSpec {
    /// Cell and mount as they are drawn.
    pub(super) fn drawn(&self) -> CellMount {
        let body = self.link.body();
        CellMount {
            cell: self.cell.pose(),
            body: self.body.pose(),
            mass: body.mass,
            com: body.com,
            inertia: body.inertia,
        }
    }
}

/// Space that the wings sweep: a fan about the body's x axis.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct EnvelopeSpec {
    /// Half span, m.
    pub half_span_m: f64,
    /// Lowest flapping angle, rad.
    pub low_rad: f64,
    /// Highest flapping angle, rad.
    pub high_rad: f64,
    /// Length ahead of the body origin, m.
    #[serde(default)]
    pub front_m: f64,
    /// Length behind it, m.
    #[serde(default)]
    pub back_m: f64,
}

impl EnvelopeSpec {
    fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        require::at_most("low_rad", self.low_rad, self.high_rad).map_err(|e| e.against(["high_rad"]))
    }
}

impl HoldSpec {
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        if self.tilts_deg.is_empty() {
            return Err(Error::invalid("tilts_deg", "[]", "at least one attitude"));
        }
        let longest = LONGEST_S / self.tilts_deg.len() as f64;
        require::at_most("each_s", self.each_s, longest)
    }
}

impl RigSpec {
    /// Checks what the tables say by themselves.
    pub(super) fn check(&self) -> Result<(), Error> {
        self.cell.check().map_err(|e| e.within("cell"))?;
        self.mount.link.body().check().map_err(|e| e.within("mount.link"))?;
        self.envelope.check().map_err(|e| e.within("envelope"))?;
        self.air.check().map_err(|e| e.within("air"))?;
        self.truth.as_ref().map_or(Ok(()), |truth| truth.in_range()).map_err(|e| e.within("truth"))?;
        if self.air.dryden.is_some() {
            return Err(Error::invalid("air.dryden", "given", "none: a run on the rig has steady wind"));
        }
        if self.air.gust_m_s != 0.0 || !self.air.gusts.is_empty() {
            let several = format!("{} of them", self.air.gusts.len());
            let (key, given) = match self.air.gust_m_s {
                0.0 => ("air.gusts", several),
                peak => ("air.gust_m_s", peak.to_string()),
            };
            return Err(Error::invalid(key, given, "none: the air of the rig is steady"));
        }
        self.in_range()
    }
}

impl RigRunSpec {
    /// Refuses more samples than memory holds; what the planner chooses of a turn takes seconds.
    pub(super) fn check_samples(&self) -> Result<(), Error> {
        let held = self.hold.as_ref().map_or(0.0, |hold| hold.each_s * hold.tilts_deg.len() as f64);
        let turning = self.turn.as_ref().map_or(0.0, |turn| {
            let rest = [turn.run_up_s, turn.straight_s, turn.roll_in_s, turn.run_down_s];
            turn.measured_s + rest.iter().flatten().sum::<f64>()
        });
        let rate = self.rig.cell.rate_hz;
        let longest = MAX_SAMPLES / rate - held - turning;
        require::at_most("rig.rest_s", self.rig.rest_s, longest).map_err(|e| {
            e.against([
                "rig.cell.rate_hz",
                "hold.each_s",
                "turn.measured_s",
                "turn.run_up_s",
                "turn.straight_s",
            ])
            .against(["turn.roll_in_s", "turn.run_down_s"])
        })
    }

    /// Samples that a step of the lattice takes, where there is one.
    pub(super) fn lattice_samples(&self) -> Result<Option<usize>, Error> {
        let every = |spec: &LatticeSpec| spec.every(1.0 / self.rig.cell.rate_hz, "samples of");
        self.lattice.as_ref().map(every).transpose().map_err(|e| e.against(["rig.cell.rate_hz"]))
    }

    /// Refuses a gait whose strokes are over before the cell has taken [`STROKE_SAMPLES`] of them.
    pub(super) fn check_frequency(&self) -> Result<(), Error> {
        let rate = self.rig.cell.rate_hz;
        let (frequency, most) =
            (self.frequency_hz.unwrap_or_else(|| self.rig.robot.gait.frequency_hz()), rate / STROKE_SAMPLES);
        if !(frequency > most) {
            return Ok(());
        }
        let allowed =
            format!("0 to {most}: rig.cell.rate_hz = {rate} then takes {STROKE_SAMPLES} samples of a stroke");
        Err(Error::invalid("frequency_hz", frequency, allowed).against(["rig.cell.rate_hz"]))
    }

    /// Refuses to take inertia away where the phase of the wings is not known.
    pub(super) fn check_inertia(&self) -> Result<(), Error> {
        if self.process.phase == PhaseSource::Encoder {
            return Ok(());
        }
        let allowed = "false, or process.phase = encoder with a column of the gait's phase \
                       (process.input.columns.phase): by force or frequency alone the pose of the wings is not known";
        let flaps = self.frequency_hz.unwrap_or_else(|| self.rig.robot.gait.frequency_hz()) > 0.0;
        if !(self.process.steps.robot_inertia && flaps) {
            return Ok(());
        }
        Err(Error::invalid("process.steps.robot_inertia", true, allowed).against(["process.phase"]))
    }

    /// The run of the same robot without the motor that turns its crank.
    pub(super) fn without_motor(&self) -> Self {
        let mut other = self.clone();
        other.rig.robot.drive = Default::default();
        other.rig.robot.numbers.retain(|name, _| !name.starts_with("motor."));
        other
    }

    /// The robot in the rig's air, with this run's wind and frequency.
    pub(super) fn robot(&self) -> Result<Robot, Error> {
        let mut robot = self.rig.robot.clone();
        if self.lattice.is_some() {
            robot.residual = None;
        }
        match self.frequency_hz {
            Some(f) if f > 0.0 => robot.gait.set_frequency_hz(f),
            _ => {}
        }
        let rig = &self.rig;
        let wind = Wind::steady(Vec3(self.wind_m_s.unwrap_or(rig.air.wind_m_s)));
        let air = Air { density: rig.air.density_kg_m3, wind };
        let mut robot = build::robot(&robot, &rig.aero, air, 0.0, None).map_err(|e| e.within("rig"))?;
        // Where the model fails at rest, the run does, and says why.
        let _ = follow(&mut robot, 1.0 / rig.cell.rate_hz);
        Ok(robot)
    }
}
