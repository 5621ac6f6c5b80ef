//! What `[controller.orbit]` says.

use super::adapt::AdaptSpec;
use super::dive::DiveSpec;
use super::governor::Governor;
use super::landing::LandingSpec;
use super::predictive::PredictiveSpec;
use super::schedule::{CourseSchedule, Stretch};
use super::tracking::TrackingSpec;
use crate::guide::inertial::EstimatorSpec;
use crate::orbit::{Course, Cycle, Deviations, Free};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_robot::Robot;

/// Integration step of orbits and feedback, s.
pub const ORBIT_STEP: f64 = 5e-4;

/// A periodic linear-quadratic regulator about level flight and the flights that legs lead to, each an orbit of the gait
/// that the controller finds itself: turns, climbs, other speeds.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct AboutOrbitSpec {
    /// Time between updates, s; best near a twentieth of a cycle.
    pub period_s: f64,
    /// Speed at the start, m/s; wings level.
    pub speed_m_s: f64,
    /// Climb at the start, m/s.
    #[serde(default)]
    pub climb_m_s: f64,
    /// What is flown after another, in the order of time.
    #[serde(default)]
    pub legs: Vec<LegSpec>,
    /// What may be chosen: actuators, by name or by that of a pair, and `frequency`, for which an actuator paces the
    /// crank. The first two hold straight flight, all together turns. All but the frequency are fed back.
    pub free: Vec<String>,
    /// Deviations that cost as much as a full command.
    #[serde(default)]
    pub weights: OrbitWeights,
    /// How the state is estimated from the readings of instruments; without it the controller receives the true state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimator: Option<EstimatorSpec>,
    /// How the controller adapts in flight to an unknown air; without it, it does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adapt: Option<AdaptSpec>,
    /// Clearance to keep over the next cycle, m, by the least change of the commands. It is at most the wings' reach from the body's origin.
    /// The robot must have clearances (of a symmetric surface or `[[clearances]]`), and all its joints must be driven. Without it no
    /// clearance is kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clearance_m: Option<f64>,
    /// A dive out of the orbit of the start and back to it below, in place of legs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dive: Option<DiveSpec>,
    /// A landing on `[perch]` out of the orbit of the start, in place of legs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub landing: Option<LandingSpec>,
    /// How `[path]` is followed, in place of legs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracking: Option<TrackingSpec>,
    /// Commands by a plan over the coming intervals that keeps within their limits, in place of the controller's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub predictive: Option<PredictiveSpec>,
}

/// A smooth way from one steady flight to another; what is not given stays.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct LegSpec {
    /// Begin, s.
    pub start_s: f64,
    /// Time that it takes, s.
    pub duration_s: f64,
    /// Speed at its end, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<f64>,
    /// Climb at its end, m/s; negative descends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub climb_m_s: Option<f64>,
    /// Bank at its end, deg, which the mean roll is too; positive is right wing down.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bank_deg: Option<f64>,
}

/// Deviations that each cost as much as a full command.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct OrbitWeights {
    /// Height, m.
    pub height_m: f64,
    /// Integral of the height, m s.
    pub height_integral_m_s: f64,
    /// Velocity along each heading axis, m/s.
    pub velocity_m_s: f64,
    /// Roll and pitch, deg.
    pub angle_deg: f64,
    /// Angular rate, rad/s.
    pub rate_rad_s: f64,
}

impl OrbitWeights {
    /// Those of the deviations of the body in their order.
    pub(super) fn sizes(&self) -> [f64; Deviations::BODY] {
        let mut sizes = [0.0; Deviations::BODY];
        sizes[Deviations::HEIGHT] = self.height_m;
        sizes[Deviations::VELOCITY].fill(self.velocity_m_s);
        (sizes[Deviations::ROLL], sizes[Deviations::PITCH]) =
            (self.angle_deg.to_radians(), self.angle_deg.to_radians());
        sizes[Deviations::RATE].fill(self.rate_rad_s);
        sizes
    }
}

impl Default for OrbitWeights {
    fn default() -> Self {
        Self { height_m: 0.03, height_integral_m_s: 0.03, velocity_m_s: 0.5, angle_deg: 6.0, rate_rad_s: 5.0 }
    }
}

/// Speeds and climbs that may be asked, m/s.
const SPEED: Range = Range::between(0.1, 100.0);
const CLIMB: Range = Range::between(-50.0, 50.0);

/// Clearances that may be kept, m.
const CLEARANCE: Range = Range::over(0.0, 1.0);

ranges!(AboutOrbitSpec {
    period_s: Range::POSITIVE,
    speed_m_s: SPEED,
    climb_m_s: CLIMB,
    clearance_m: CLEARANCE
});
ranges!(LegSpec {
    start_s: Range::NOT_NEGATIVE,
    duration_s: Range::POSITIVE,
    speed_m_s: SPEED,
    climb_m_s: CLIMB,
    bank_deg: Range::inside(-80.0, 80.0),
});
ranges!(OrbitWeights {
    height_m: Range::POSITIVE,
    height_integral_m_s: Range::POSITIVE,
    velocity_m_s: Range::POSITIVE,
    angle_deg: Range::POSITIVE,
    rate_rad_s: Range::POSITIVE,
});

impl AboutOrbitSpec {
    /// All that can be said without looking for orbits; the cycle and the schedule that they are looked for with.
    pub(super) fn checked<'a>(&self, robot: &'a Robot) -> Result<(Cycle<'a>, CourseSchedule), Error> {
        self.in_range()?;
        let wind = robot.mean_wind();
        if wind.norm() > 0.0 {
            let allowed = "still air beside controller.orbit, whose orbits are those of still air; what it is not told may blow: air.gusts";
            return Err(Error::invalid("wind_m_s", format!("{:?}", wind.0), allowed));
        }
        self.weights.in_range().map_err(|e| e.within("weights"))?;
        for (i, leg) in self.legs.iter().enumerate() {
            leg.in_range().map_err(|e| e.within(&format!("legs[{i}]")))?;
        }
        if let Some(predictive) = &self.predictive {
            predictive.check(robot, self.tracking.is_some()).map_err(|e| e.within("predictive"))?;
        }
        if let Some(adapt) = &self.adapt {
            adapt.check(robot).map_err(|e| e.within("adapt"))?;
            if self.predictive.is_some() {
                let allowed = "none beside predictive, whose plan adapts to nothing";
                return Err(Error::invalid("adapt", "given", allowed).against(["predictive"]));
            }
            if adapt.missed_s.is_some() && self.estimator.is_some() {
                let allowed = "none beside estimator: it is learned of the true state, and the estimator has one of its own";
                return Err(Error::invalid("adapt.missed_s", "given", allowed).against(["estimator"]));
            }
        }
        if let Some(least) = self.clearance_m {
            Governor::check(robot, least)?;
            if self.predictive.is_some() {
                let allowed = "none beside predictive, whose clearance_m is a soft limit of the plan";
                return Err(Error::invalid("clearance_m", least, allowed).against(["predictive"]));
            }
        }
        if let Some(dive) = &self.dive {
            dive.in_range().map_err(|e| e.within("dive"))?;
        }
        if let Some(landing) = &self.landing {
            landing.check(robot).map_err(|e| e.within("landing"))?;
        }
        let planned = [("dive", self.dive.is_some()), ("landing", self.landing.is_some())];
        if let Some((plan, _)) = planned.into_iter().find(|(_, given)| *given) {
            let lands = self.landing.is_some();
            let beside = [
                ("landing", plan == "dive" && lands),
                ("estimator", lands && self.estimator.is_some()),
                ("legs", !self.legs.is_empty()),
                ("climb_m_s", self.climb_m_s != 0.0),
                ("tracking", self.tracking.is_some()),
                ("predictive", self.predictive.is_some()),
                ("adapt", self.adapt.is_some()),
                ("clearance_m", plan == "dive" && self.clearance_m.is_some()),
            ];
            if let Some((key, _)) = beside.into_iter().find(|(_, given)| *given) {
                let allowed = format!("none beside {plan}, which leaves level flight by commands of its own");
                return Err(Error::invalid(key, "given", allowed).against([plan]));
            }
        }
        self.free(robot, true)?;
        if self.tracking.is_some() {
            let beside = [("legs", !self.legs.is_empty()), ("estimator", self.estimator.is_some())];
            if let Some((key, _)) = beside.into_iter().find(|(_, given)| *given) {
                let allowed = match key {
                    "legs" => "none beside tracking: the path says what is flown",
                    _ => "none beside tracking: the place is not estimated",
                };
                return Err(Error::invalid(key, "given", allowed).against(["tracking"]));
            }
        }
        Ok((Cycle::new(robot, ORBIT_STEP)?, self.schedule()?))
    }

    /// What is free in straight flight, or in a turn.
    pub(super) fn free(&self, robot: &Robot, turning: bool) -> Result<Vec<Free>, Error> {
        let names = if turning { &self.free[..] } else { &self.free[..self.free.len().min(2)] };
        let (mut all, turns) = (
            Vec::new(),
            self.tracking.is_some() || self.legs.iter().any(|leg| leg.bank_deg.is_some_and(|b| b != 0.0)),
        );
        for (i, name) in names.iter().enumerate() {
            let key = format!("free[{i}]");
            let allowed = || Free::names(robot).join(", ");
            let free = Free::named(robot, name, turning)
                .ok_or_else(|| Error::invalid(&key, format!("{name:?}"), allowed()))?;
            if free.contains(&Free::Frequency) && robot.pacer().is_none() {
                let allowed = "a robot with a regulator that moves its crank";
                return Err(Error::invalid(key, format!("{name:?}"), allowed));
            }
            if free.iter().any(|free| all.contains(free)) {
                return Err(Error::invalid(key, format!("{name:?}"), "each name once"));
            }
            all.extend(free);
        }
        let needed = if turning && turns { 4 } else { 2 };
        if all.len() < needed {
            let allowed = match turns {
                true => "for turns four actuators or more, a pair counting as two",
                false => "two actuators or pairs, or more",
            };
            return Err(Error::invalid("free", format!("{:?}", self.free), allowed));
        }
        Ok(all)
    }

    /// The legs with where each begins and ends.
    fn schedule(&self) -> Result<CourseSchedule, Error> {
        let mut course = Course { speed: self.speed_m_s, climb: self.climb_m_s, bank: 0.0 };
        if let Some(tracking) = &self.tracking {
            tracking.in_range().map_err(|e| e.within("tracking"))?;
            return Ok(tracking.fan(course));
        }
        let mut schedule = CourseSchedule { first: course, stretches: Vec::new(), fan: false };
        for (i, leg) in self.legs.iter().enumerate() {
            let key = |name: &str| format!("legs[{i}].{name}");
            let to = Course {
                speed: leg.speed_m_s.unwrap_or(course.speed),
                climb: leg.climb_m_s.unwrap_or(course.climb),
                bank: leg.bank_deg.map_or(course.bank, f64::to_radians),
            };
            let stretch = Stretch { start: leg.start_s, duration: leg.duration_s, from: course, to };
            if let Some(before) = schedule.stretches.last()
                && stretch.start < before.start + before.duration
            {
                let end = before.start + before.duration;
                let error = Error::invalid(
                    key("start_s"),
                    leg.start_s,
                    format!("{end} or more, the end of the leg before"),
                );
                let before = i - 1;
                return Err(error.against(["start_s", "duration_s"].map(|k| format!("legs[{before}].{k}"))));
            }
            if course.turns() && !(to.bank * course.bank > 0.0) && schedule.back(&stretch).is_none() {
                let allowed = "the same side; out of a turn a leg leads back to where one into it began";
                return Err(Error::invalid(key("bank_deg"), to.bank.to_degrees(), allowed));
            }
            schedule.stretches.push(stretch);
            course = to;
        }
        Ok(schedule)
    }
}
