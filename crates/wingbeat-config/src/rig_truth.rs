//! A simulated bench that is not what its files say.

use super::RigRun;
use super::calibration::{unrest, unrest_time};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use wingbeat_flight::simulate::follow;
use wingbeat_math::Error;
use wingbeat_math::Random;
use wingbeat_math::range::{Range, ranges};
use wingbeat_ocp::plant::Fault;
use wingbeat_rig::carrier::ToolCarrier;
use wingbeat_rig::{BenchDeviations, Experiment, Instants, Outcome, Sinusoid, rms_about_mean};

/// A bench that is simulated in place of the one that the files draw: a truth unlike the model that processing draws beside
/// it. What is a share is drawn for each run by its seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct RigTruthSpec {
    /// Overrides of the run: `rig.aero.law=lev`. The motion stays as planned without them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// The wings flap faster or slower by up to this share, drawn.
    #[serde(default)]
    pub frequency_share: f64,
    /// The crank's rate ripples once a turn by this share, at a drawn phase; the encoder, read once a turn, does not show it.
    #[serde(default)]
    pub ripple_share: f64,
    /// The crank's rate differs from cycle to cycle by this share (rms), at drawn phases; the encoder shows it.
    #[serde(default)]
    pub pace_share: f64,
    /// The encoder shows this more than the phase, rad.
    #[serde(default)]
    pub encoder_offset_rad: f64,
    /// The arm lags behind its plan, s.
    #[serde(default)]
    pub tracking_lag_s: f64,
    /// Each joint of the arm errs by a wave of up to this amplitude and of 1 to 4 Hz, drawn, rad.
    #[serde(default)]
    pub tracking_rad: f64,
    /// Loads that differ from instant to instant (air of the room, arm, structure), as deviation in parts of each channel's
    /// rms: first-order noise of the time `unrest_time_s`.
    #[serde(default = "unrest")]
    pub unrest: f64,
    /// Time over which that noise forgets itself, s.
    #[serde(default = "unrest_time")]
    pub unrest_time_s: f64,
}

ranges!(RigTruthSpec {
    frequency_share: Range::between(0.0, 0.2),
    ripple_share: Range::between(0.0, 0.5),
    pace_share: Range::between(0.0, 0.2),
    encoder_offset_rad: Range::between(-TAU, TAU),
    tracking_lag_s: Range::between(0.0, 1.0),
    tracking_rad: Range::between(0.0, 0.2),
    unrest: Range::between(0.0, 1.0),
    unrest_time_s: Range::between(1e-4, 10.0),
});

/// The stream of what is drawn for a run, among those of its seed.
const DRAWN: u64 = 2;
/// Frequencies of the arm's errors, Hz. *Choice.*
const ERRORS_HZ: [f64; 2] = [1.0, 4.0];
/// Steps per second at which the size of the loads is found.
const LOOKED_AT_HZ: f64 = 700.0;

impl RigRun {
    /// Simulates the run on the bench that its files say is the true one, or else on the one that they draw.
    ///
    /// # Errors
    /// Bad numbers, overrides of the truth that no run takes; a fault of the model comes back with its time.
    pub(super) fn simulate_truth(
        &self,
        carrier: &ToolCarrier,
        window: (f64, f64),
        seed: u64,
        progress: impl FnMut(f64),
    ) -> Result<Result<Outcome, Fault>, Error> {
        let Some(truth) = &self.spec.rig.truth else { return self.simulate(carrier, seed, progress) };
        let mut random = Random::stream(seed, DRAWN);
        let mut set = truth.set.clone();
        let frequency = self.frequency() * (1.0 + truth.frequency_share * random.between(-1.0, 1.0));
        if frequency > 0.0 {
            set.push(format!("frequency_hz={frequency:?}"));
        }
        let other = self.overridden(&set).map_err(|error| {
            Error::invalid(
                "rig.truth.set",
                format!("{:?}", truth.set),
                format!("overrides of the run: {error}"),
            )
        })?;
        let phase = random.between(0.0, TAU);
        let [along, across] = [phase.cos(), phase.sin()].map(|part| truth.ripple_share * part);
        let ripple = [("crank.ripple_rad[0]", along), ("crank.ripple_rad[1]", across)];
        let (robot, numbers) = other.adjusted(&ripple)?;
        let tracked = truth.tracked(carrier, &mut random);
        let mut experiment = other.experiment(&robot, numbers, &tracked, seed);
        experiment.deviations = BenchDeviations {
            pace: match frequency > 0.0 {
                true => BenchDeviations::paces(truth.pace_share, frequency, &mut random),
                false => Vec::new(),
            },
            encoder_rad: truth.encoder_offset_rad,
            unrest: [0.0; 6],
            unrest_time_s: truth.unrest_time_s,
        };
        // The longer steps in which it is looked at may need more of an inertance.
        let mut looked = robot.clone();
        let _ = follow(&mut looked, 1.0 / LOOKED_AT_HZ);
        match truth.unrest > 0.0 && experiment.flapping {
            false => {}
            true => match size_of_loads(Experiment { robot: &looked, ..experiment.clone() }, window) {
                Ok(size) => experiment.deviations.unrest = size.map(|rms| truth.unrest * rms),
                Err(fault) => return Ok(Err(fault)),
            },
        }
        other.simulate_in(&experiment, progress)
    }
}

/// Rms about the mean of the loads in the window.
fn size_of_loads(experiment: Experiment, (begin, end): (f64, f64)) -> Result<[f64; 6], Fault> {
    let step = 1.0 / LOOKED_AT_HZ;
    let steps = (end / step).ceil() as usize;
    let rows = experiment.wrenches(&Instants { begin: 0.0, step, steps })?;
    Ok(rms_about_mean(&rows[((begin / step) as usize).min(rows.len())..]))
}

impl RigTruthSpec {
    /// The carrier as its arm moves; a stand stands.
    fn tracked(&self, carrier: &ToolCarrier, random: &mut Random) -> ToolCarrier {
        match carrier {
            ToolCarrier::Stand { .. } => carrier.clone(),
            ToolCarrier::Arm { arm, trajectory } => {
                let wave = |_| Sinusoid {
                    amplitude: self.tracking_rad * random.unit(),
                    rate: TAU * random.between(ERRORS_HZ[0], ERRORS_HZ[1]),
                    phase: random.between(0.0, TAU),
                };
                let errors: Vec<Sinusoid> = (0..arm.dof()).map(wave).collect();
                ToolCarrier::Arm {
                    arm: arm.clone(),
                    trajectory: trajectory.tracked(self.tracking_lag_s, &errors),
                }
            }
        }
    }
}
