//! Runs on the test rig: what their files say, checked and built.

use super::{AeroSpec, AirSpec, ConfigError, Document, Translate};
use crate::Error;
use crate::math::{Mat3, Vec3};
use crate::plant::Fault;
use crate::require;
use crate::rig::arm::{ArmConfig, LimitProfile, LinkConfig, Payload, SerialArm, ToolConfig};
use crate::rig::carrier::{Carrier, Mount};
use crate::rig::cell::CellSpec;
use crate::rig::plan::{Approach, Envelope, Margins, Plan, Refusal, TurnSpec, Workspace};
use crate::rig::process::{InputSpec, PhaseSource, Steps};
use crate::rig::{Experiment, Outcome, Pose};
use crate::robot::{Air, Robot, RobotSpec, Wind};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Keys of a run that name a file to be put in their place, outer ones first.
const INCLUDES: [&str; 3] = ["rig", "rig.robot", "rig.arm"];

/// One run as written in a file.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigRunSpec {
    /// Name; the run folder is called after it.
    pub name: String,
    /// The rig; a run names its file.
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
    /// Corrections made by processing.
    #[serde(default)]
    pub process: ProcessSpec,
}

/// Attitudes of the body held one after another, without motion between.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoldSpec {
    /// Roll and pitch of the body, deg; FLU: negative pitch is nose up.
    pub tilts_deg: Vec<[f64; 2]>,
    /// Time in each, s.
    pub each_s: f64,
}

/// How the samples become wrenches.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ProcessSpec {
    /// Corrections.
    pub steps: Steps,
    /// Where the phase comes from.
    pub phase: PhaseSource,
    /// Phases of the average.
    pub bins: usize,
    /// Begin and end of what is averaged, s from the begin of the run; without it the steady
    /// turn, or what follows the start of the flapping.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window_s: Option<[f64; 2]>,
    /// What becomes of samples at the end of the cell's range.
    pub saturated: Saturated,
    /// Name of a run in still air, processed with this one, whose average is taken away.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub still_air: Option<String>,
    /// How measured files are to be read.
    pub input: InputSpec,
}

/// What becomes of samples at the end of the cell's range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Saturated {
    /// The run is refused.
    Refuse,
    /// Their cycles are left out.
    LeaveOut,
    /// They are used as they are.
    Keep,
}

/// Most phases of an average.
const MAX_BINS: usize = 10_000;

impl ProcessSpec {
    /// Refuses values without meaning.
    fn check(&self) -> Result<(), Error> {
        if !(2..=MAX_BINS).contains(&self.bins) {
            return Err(Error::invalid("bins", self.bins, format!("2 to {MAX_BINS}")));
        }
        require::not_negative("steps.cutoff_multiple", self.steps.cutoff_multiple)?;
        if let Some([begin, end]) = self.window_s
            && !(begin < end && begin.is_finite() && end.is_finite())
        {
            return Err(Error::invalid("window_s", format!("[{begin}, {end}]"), "begin before end, s"));
        }
        Ok(())
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
            input: InputSpec::default(),
        }
    }
}

/// The hardware.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigSpec {
    /// The robot; a rig names its file.
    pub robot: RobotSpec,
    /// The arm; a rig names its file: TOML, or `FILE.urdf`, `FILE.urdf#TIP` where it has several ends.
    pub arm: ArmConfig,
    /// Limit profile of the arm.
    pub profile: String,
    /// Height of the table in the arm's base frame, m.
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
    pub spin_up_s: f64,
}

/// Cell and mount.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MountSpec {
    /// Sensing frame of the cell in the tool frame.
    pub cell: ToolConfig,
    /// Robot body in the sensing frame.
    pub body: ToolConfig,
    /// What lies between sensing element and robot, in the sensing frame.
    pub link: LinkConfig,
}

/// Space that the wings sweep: a fan about the body's x axis.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnvelopeSpec {
    /// Half span, m.
    pub half_span_m: f64,
    /// Lowest stroke angle, rad.
    pub low_rad: f64,
    /// Highest stroke angle, rad.
    pub high_rad: f64,
    /// Length ahead of the body origin, m.
    pub front_m: f64,
    /// Length behind it, m.
    pub back_m: f64,
}

/// A checked run.
#[derive(Debug)]
pub struct RigRun {
    /// What the files and overrides said.
    pub spec: RigRunSpec,
    /// The merged configuration as TOML.
    pub resolved: String,
    /// The robot in its air.
    pub robot: Robot,
    /// The arm.
    pub arm: SerialArm,
    /// Its limits.
    pub profile: LimitProfile,
    /// Cell and mount.
    pub mount: Mount,
}

impl RigRun {
    /// Reads, merges and checks a run; `overrides` are `key=value`.
    ///
    /// # Errors
    /// One message with file, line, key, the value given and what is allowed.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, ConfigError> {
        Self::load_translated(path, overrides, &|_, _| None)
    }

    /// As [`load`](Self::load); `translate` reads arms that are not written in TOML.
    ///
    /// # Errors
    /// Those of [`load`](Self::load), and what `translate` says of a file.
    pub fn load_translated(
        path: &Path,
        overrides: &[String],
        translate: Translate,
    ) -> Result<Self, ConfigError> {
        let document = Document::load_translated(path, overrides, &INCLUDES, translate)?;
        let spec: RigRunSpec = document.parse()?;
        let resolved = document.resolved()?;
        Self::build(spec, resolved).map_err(|error| document.explain(&error))
    }

    fn build(spec: RigRunSpec, resolved: String) -> Result<Self, Error> {
        spec.frequency_hz.map_or(Ok(()), |f| require::not_negative("frequency_hz", f))?;
        spec.process.check().map_err(|e| e.within("process"))?;
        if spec.turn.is_some() == spec.hold.is_some() {
            let given = if spec.turn.is_some() { "turn and hold" } else { "neither" };
            return Err(Error::invalid("turn", given, "either [turn] or [hold]"));
        }
        spec.rig.cell.check().map_err(|e| e.within("rig.cell"))?;
        let rest = spec.rig.rest_s;
        if !(rest >= 0.0 && rest.is_finite()) {
            return Err(Error::invalid("rig.rest_s", rest, "zero or more"));
        }
        let profile = spec.profile.as_ref().unwrap_or(&spec.rig.profile);
        let body = spec.rig.mount.link.body();
        let mount = Mount {
            cell: spec.rig.mount.cell.pose(),
            body: spec.rig.mount.body.pose(),
            mass: body.mass,
            com: body.com,
            inertia: body.inertia,
        };
        Ok(Self {
            robot: spec.robot()?,
            arm: spec.rig.arm.build().map_err(|e| e.within("rig.arm"))?,
            profile: spec.rig.arm.profile(profile).map_err(|e| e.within("rig.arm"))?,
            mount,
            resolved,
            spec,
        })
    }

    /// Flapping frequency, Hz.
    pub fn frequency(&self) -> f64 {
        self.spec.frequency_hz.unwrap_or_else(|| self.spec.rig.robot.gait.frequency_hz())
    }

    /// Body in the tool frame, X_TB.
    fn body_in_tool(&self) -> Pose {
        self.mount.cell * self.mount.body
    }

    /// Mount and robot as one payload in the tool frame.
    fn payload(&self) -> Payload {
        let robot = self.robot.mass();
        let mass = robot + self.mount.mass;
        let at = self.mount.cell.point(self.mount.com) * self.mount.mass + self.body_in_tool().origin * robot;
        Payload { mass, com: at * (1.0 / mass), inertia: Mat3::ZERO, radius: 0.0 }
    }

    /// Plans the run's turn.
    ///
    /// # Errors
    /// A run without a turn, or bad numbers in it.
    pub fn plan(&self) -> Result<Result<Plan, Refusal>, Error> {
        let Some(turn) = &self.spec.turn else {
            return Err(Error::invalid("turn", "absent", "a [turn] to plan"));
        };
        let (payload, envelope) = (self.payload(), self.envelope());
        self.workspace(&payload, &envelope).plan(turn)
    }

    /// The motion from rest at `from` (rad) to the begin of `plan`.
    ///
    /// # Errors
    /// A pose outside the joint limits.
    pub fn approach(&self, from: &[f64], plan: &Plan) -> Result<Result<Approach, Refusal>, Error> {
        let (payload, envelope) = (self.payload(), self.envelope());
        let Some(start) = plan.trajectory.position.first() else {
            return Err(Error::invalid("plan", "no points", "a plan with points"));
        };
        self.workspace(&payload, &envelope).approach(from, start)
    }

    fn envelope(&self) -> Envelope {
        let e = self.spec.rig.envelope;
        Envelope::fan(e.half_span_m, e.low_rad, e.high_rad, e.front_m, e.back_m)
    }

    fn workspace<'a>(&'a self, payload: &'a Payload, envelope: &'a Envelope) -> Workspace<'a> {
        let rig = &self.spec.rig;
        Workspace {
            arm: &self.arm,
            profile: &self.profile,
            payload,
            body: self.body_in_tool(),
            envelope,
            table: rig.table_m,
            margins: Margins { singularity: rig.singularity_margin, clearance: rig.clearance_m },
        }
    }

    /// What carries the robot in this run; a turn needs its `plan`.
    pub fn carrier(&self, plan: Option<&Plan>) -> Carrier {
        match (&self.spec.hold, plan) {
            (None, Some(plan)) => {
                Carrier::Arm { arm: Box::new(self.arm.clone()), trajectory: plan.trajectory.clone() }
            }
            (Some(hold), _) => Carrier::Stand { holds: self.holds(hold) },
            (None, None) => Carrier::Stand { holds: vec![(0.0, Pose::IDENTITY)] },
        }
    }

    fn holds(&self, hold: &HoldSpec) -> Vec<(f64, Pose)> {
        let tool_in_body = self.body_in_tool().inverse();
        let tool = |[roll, pitch]: [f64; 2]| {
            let rotation = Mat3::from_roll_pitch_yaw(roll.to_radians(), pitch.to_radians(), 0.0);
            Pose { rotation, origin: Vec3::ZERO } * tool_in_body
        };
        hold.tilts_deg.iter().enumerate().map(|(k, tilt)| (k as f64 * hold.each_s, tool(*tilt))).collect()
    }

    /// Duration after the rest, s.
    pub fn duration(&self, carrier: &Carrier) -> f64 {
        carrier.duration() + self.spec.hold.as_ref().map_or(0.0, |hold| hold.each_s)
    }

    /// Begin and end of what is averaged, s.
    pub fn window(&self, plan: Option<&Plan>, carrier: &Carrier) -> (f64, f64) {
        match plan {
            Some(plan) => plan.measured,
            None => (self.spec.rig.spin_up_s, self.duration(carrier)),
        }
    }

    /// Simulates the run.
    ///
    /// # Errors
    /// Bad numbers; a fault of the model comes back with its time.
    pub fn simulate(
        &self,
        carrier: &Carrier,
        seed: u64,
        progress: impl FnMut(f64),
    ) -> Result<Result<Outcome, Fault>, Error> {
        let experiment = Experiment {
            robot: &self.robot,
            carrier,
            mount: &self.mount,
            cell: &self.spec.rig.cell,
            seed,
            rest: self.spec.rig.rest_s,
            duration: self.duration(carrier),
            flapping: self.frequency() > 0.0,
            spin_up: self.spec.rig.spin_up_s,
        };
        experiment.simulate(progress)
    }
}

impl RigRunSpec {
    /// The robot in the rig's air, with this run's wind and frequency.
    fn robot(&self) -> Result<Robot, Error> {
        let mut robot = self.rig.robot.clone();
        match self.frequency_hz {
            Some(f) if f > 0.0 => robot.gait.set_frequency_hz(f),
            _ => {}
        }
        let rig = &self.rig;
        let outlines = robot.outlines().map_err(|e| e.within("rig.robot"))?;
        let density = rig.air.density_kg_m3;
        if !(density >= 0.0 && density.is_finite()) {
            return Err(Error::invalid("rig.air.density_kg_m3", density, "zero or more"));
        }
        let aero = rig.aero.models(&outlines, density).map_err(|e| e.within("rig"))?;
        let wind = Wind::steady(Vec3(self.wind_m_s.unwrap_or(rig.air.wind_m_s)));
        Robot::new(&robot, aero, Air { density, wind }, 0.0).map_err(|e| e.within("rig.robot"))
    }
}
