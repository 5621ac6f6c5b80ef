//! Turning the body by moving the wings, planned offline.

use super::roll_in::{RollIn, RollInSpec};
use super::{MAX_INTERVALS, MAX_ITERATIONS, MAX_MESHES};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use wingbeat_math::names::one_of;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Error, Vec3, require};
use wingbeat_ocp::plant::{Channel, Plant};

/// Largest rotation, deg: the rotation vector is singular at a full turn.
const MOST: f64 = 350.0;

/// Goal and effort of a reorientation: the least time from the scenario's start to another attitude.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct ReorientationSpec {
    /// Rotation vector from the attitude at the start, in the axes of the body there, deg: [0, -180, 0] is half a turn nose up. Its
    /// length is at most 350.
    pub rotation_deg: [f64; 3],
    /// How far each of its components may be off at the end, deg.
    pub within_deg: f64,
    /// Largest rate of each structure element at the end, rad/s or m/s.
    pub rate_within_rad_s: f64,
    /// Largest displacement of each structure element at the end, as a share of what its input may command.
    pub displacement_within: f64,
    /// Least clearance between parts on the way, m; without it any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clearance_m: Option<f64>,
    /// Longest duration, s.
    pub longest_s: f64,
    /// Cost of each input at its limit, seconds per second.
    pub effort: f64,
    /// The motion that the solver starts from.
    pub guess: GuessSpec,
    /// Intervals of the first mesh.
    pub intervals: usize,
    /// Most meshes.
    pub meshes: usize,
    /// Largest error of an interval, relative.
    pub tolerance: f64,
    /// Most iterations of the solver, over all meshes.
    #[serde(default = "super::most_iterations")]
    pub iterations: usize,
    /// Most processor time, s, beside `iterations`; without it any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_limit_s: Option<f64>,
}

/// Commands that turn the body a little in every cycle; they run until it has turned as far as asked.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct GuessSpec {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Commands over time; the other inputs rest.
    pub waves: Vec<WaveSpec>,
}

/// A wave of commands, amplitude cos(2 pi f t - phase).
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaveSpec {
    /// Input, by the name of its column.
    pub input: String,
    /// Amplitude, in the unit of the input.
    pub amplitude: f64,
    /// Phase, rad.
    pub phase_rad: f64,
}

ranges!(GuessSpec { frequency_hz: Range::POSITIVE });
ranges!(ReorientationSpec {
    rotation_deg: Range::between(-MOST, MOST),
    within_deg: Range::POSITIVE,
    rate_within_rad_s: Range::POSITIVE,
    displacement_within: Range::POSITIVE,
    longest_s: Range::POSITIVE,
    effort: Range::POSITIVE,
    intervals: Range::between(1.0, MAX_INTERVALS as f64),
    meshes: Range::between(1.0, MAX_MESHES as f64),
    tolerance: Range::POSITIVE,
    iterations: Range::between(1.0, MAX_ITERATIONS as f64),
    time_limit_s: Range::POSITIVE,
});

impl ReorientationSpec {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        self.guess.in_range().map_err(|e| e.within("guess"))?;
        require::finite("clearance_m", self.clearance_m.as_slice())?;
        let size = Vec3(self.rotation_deg).norm();
        if !(size > 0.0 && size <= MOST) {
            let allowed = format!("a rotation of more than 0 and at most {MOST} deg");
            return Err(Error::invalid("rotation_deg", format!("{:?}", self.rotation_deg), allowed));
        }
        for (i, wave) in self.guess.waves.iter().enumerate() {
            let key = format!("guess.waves[{i}]");
            require::finite("amplitude", &[wave.amplitude]).map_err(|e| e.within(&key))?;
            require::finite("phase_rad", &[wave.phase_rad]).map_err(|e| e.within(&key))?;
        }
        Ok(())
    }

    /// What it shares with a roll-in.
    pub fn roll_in(&self) -> RollInSpec {
        RollInSpec {
            start_s: 0.0,
            roll_deg: 0.0,
            nose_up_deg: 0.0,
            pitch_within_deg: self.within_deg,
            rate_within_rad_s: self.rate_within_rad_s,
            displacement_within: self.displacement_within,
            clearance_m: self.clearance_m,
            longest_s: self.longest_s,
            effort: self.effort,
            tracking: None,
            within_strokes: true,
            starts: 1,
            intervals: self.intervals,
            meshes: self.meshes,
            tolerance: self.tolerance,
            iterations: self.iterations,
            time_limit_s: self.time_limit_s,
        }
    }
}

/// The end of a reorientation, and the commands of its guess.
#[derive(Clone, Debug)]
pub(super) struct Turning {
    /// Rotation vector from the start, rad.
    pub rotation: Vec3,
    /// How far each component may be off, rad.
    pub within: f64,
    /// Input, amplitude and phase of each wave.
    waves: Vec<(usize, [f64; 2])>,
    /// Their frequency, rad/s.
    rate: f64,
}

impl Turning {
    fn new(spec: &ReorientationSpec, inputs: &[Channel]) -> Result<Self, Error> {
        let wave = |(i, wave): (usize, &WaveSpec)| {
            let input = inputs.iter().position(|input| input.name == wave.input).ok_or_else(|| {
                let names: Vec<&str> = inputs.iter().map(|input| input.name.as_str()).collect();
                let given = format!("\"{}\"", wave.input);
                Error::invalid(format!("guess.waves[{i}].input"), given, one_of(&wave.input, &names))
            })?;
            Ok((input, [wave.amplitude, wave.phase_rad]))
        };
        Ok(Self {
            rotation: Vec3(spec.rotation_deg.map(f64::to_radians)),
            within: spec.within_deg.to_radians(),
            waves: spec.guess.waves.iter().enumerate().map(wave).collect::<Result<_, _>>()?,
            rate: TAU * spec.guess.frequency_hz,
        })
    }

    /// Writes the commands of the guess at the time `t`, s.
    pub fn command(&self, t: f64, u: &mut [f64]) {
        for &(input, [amplitude, phase]) in &self.waves {
            u[input] = amplitude * (self.rate * t - phase).cos();
        }
    }

    /// Whether the rotation vector `d` (rad) has come as far as asked.
    pub fn is_reached(&self, d: &[f64]) -> bool {
        Vec3::from_slice(d).dot(self.rotation) >= self.rotation.norm_squared()
    }
}

impl<'a, P: Plant> RollIn<'a, P> {
    /// The reorientation of `plant`, whose structure elements have `strokes` (in the units of their channels), from its state
    /// `x` at the time 0. It takes the least time to another attitude by its own inertia and, where there is air, the air's.
    ///
    /// Equation: guide.reorientation
    /// `min t_f + int e sum (u_i/limit_i)^2 dt, log(R_0' R_f) = d within what is allowed, elements at rest again, strokes
    /// and clearances kept`
    /// Source: choice; turning without momentum, Kane & Scher 1969; bats, Bergou et al. 2015, PLoS Biology 13.
    /// Test: `a_free_body_turns_beyond_a_quarter_in_the_time_of_full_torque`.
    ///
    /// # Errors
    /// As [`RollIn::new`]; a guess that commands what is not there.
    pub fn reorientation(
        plant: &'a P,
        x: &[f64],
        strokes: &[[f64; 2]],
        spec: &ReorientationSpec,
    ) -> Result<Self, Error> {
        spec.check()?;
        let turn = Turning::new(spec, plant.inputs())?;
        let mut problem = Self::new(plant, x, strokes, &spec.roll_in())?;
        problem.turn = Some(turn);
        Ok(problem)
    }
}
