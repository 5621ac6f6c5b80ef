//! The verdict on a periodic flight.

use super::summary::{TrimSummary, hover_wash};
use crate::nearness;
use crate::recorder::FlightMeans;
use crate::spec::{AirSpec, ScenarioSpec};
use crate::summary::touching;
use crate::{fit, plausible, stall, unheard, web};
use wingbeat_judge::limits::{range, trim};
use wingbeat_judge::{Judge, JudgedLimit, RunLimits, Verdict, Warning};
use wingbeat_math::Vec3;
use wingbeat_robot::Robot;

/// Numbers of an orbit that every one is held against, those of a family too; none where the robot has none.
pub(super) struct OrbitMeasures {
    /// Positive power of the drives over the mass, W/kg.
    pub(super) power_w_kg: Option<f64>,
    /// Share of strips and instants 20 deg and more past stall.
    pub(super) stall_fraction_20: Option<f64>,
    /// Least clearance between parts, m.
    pub(super) least_clearance_m: Option<f64>,
    /// Largest Floquet multiplier.
    pub(super) largest_multiplier: Option<f64>,
    /// Mean aerodynamic force upward over the weight.
    pub(super) lift_over_weight: Option<f64>,
}

impl OrbitMeasures {
    /// Holds those of an orbit of `robot` against the limits.
    pub(super) fn hold(&self, robot: &Robot, judge: &mut Judge) {
        // Thrusters carry too.
        let lift = self.lift_over_weight.filter(|_| robot.thrusters().is_empty());
        for (limit, value) in [
            (&trim::POWER, self.power_w_kg),
            (&trim::BEYOND_20, self.stall_fraction_20),
            (&trim::CLEARANCE, self.least_clearance_m),
            (&trim::MULTIPLIER, self.largest_multiplier),
            (&trim::WEIGHT, lift.map(|lift| (lift - 1.0).abs())),
        ] {
            judge.hold_if(limit, value);
        }
    }
}

impl TrimSummary {
    /// Judges the orbit that was found.
    pub(super) fn judge(
        &mut self,
        robot: &Robot,
        spec: &ScenarioSpec,
        limits: &RunLimits,
        means: Option<&FlightMeans>,
    ) {
        let mut judge = Judge::new(limits);
        let steps = spec
            .trim
            .as_ref()
            .zip(self.stroke_frequency_hz.or(self.frequency_hz))
            .map(|(trim, f)| (1.0 / (f * trim.step_s)).round());
        // An orbit is flown by itself or by its gains, whichever holds it.
        let growth =
            self.largest_multiplier.map(|alone| self.held_multiplier.map_or(alone, |held| held.min(alone)));
        // Of an orbit that holds itself the gains must not make more of a disturbance.
        let upset =
            self.largest_multiplier.filter(|alone| *alone <= trim::GROWS.value).and(self.held_multiplier);
        // Of an orbit that gains hold what grows without them is told.
        let alone =
            self.largest_multiplier.filter(|_| growth.is_some_and(|growth| growth <= trim::GROWS.value));
        let of_every_orbit = OrbitMeasures {
            power_w_kg: self.power_w_kg,
            stall_fraction_20: self.stall_fraction_20,
            least_clearance_m: self.least_clearance_m,
            largest_multiplier: self.largest_multiplier,
            lift_over_weight: self.lift_over_weight,
        };
        of_every_orbit.hold(robot, &mut judge);
        let held: [(&'static JudgedLimit, Option<f64>); 7] = [
            (&trim::HIGH_POWER, self.power_w_kg),
            (&trim::SKIN, self.least_clearance_m.and_then(touching)),
            (&trim::GROWS, growth),
            (&trim::ALONE_GROWS, alone),
            (&trim::GAINS_GROW, upset),
            (&trim::RESIDUAL, self.residual),
            (&trim::STEPS, steps),
        ];
        for (limit, value) in held {
            if let Some(value) = value {
                judge.hold(limit, value);
            }
        }
        plausible::hold(&mut judge, robot);
        if let Some(means) = means {
            means.hold(&mut judge);
            judge.hold(&range::REVERSED_OUTSIDE, means.reversed_fraction);
            stall::hold(&mut judge, &means.stalled, "aero.law");
            judge.hold(&range::STALLED_OUTSIDE, means.stalled.untested());
        }
        if let Some(membrane) = self.membrane {
            membrane.judge(&mut judge);
        }
        if let Some(flap) = self.flap {
            flap.judge(&mut judge);
        }
        if let Some(spar) = self.spar {
            spar.judge(&mut judge);
        }
        if let Some(pins) = self.pin_springs {
            pins.judge(&mut judge);
        }
        let slow = hover_wash(robot).filter(|wash| self.speed_m_s < *wash);
        judge_slow(&mut judge, self.speed_m_s, slow);
        said_of(spec, robot).for_each(|warning| judge.warn(warning));
        let surfaces = robot.surfaces().map(|(_, aero)| aero);
        let edges = unheard::side_edges(&spec.aero, surfaces, self.stall_fraction_12);
        edges.into_iter().for_each(|warning| judge.warn(warning));
        self.take(judge.verdict());
    }

    /// Judges the least clearance, m, of the orbits that a search flew beside this one, in other airs or by other numbers of strips.
    pub(super) fn hold_elsewhere(&mut self, limits: &RunLimits, least: Option<f64>) {
        let Some(least) = least.filter(|least| self.least_clearance_m.is_none_or(|own| *least < own)) else {
            return;
        };
        let mut judge = Judge::new(limits);
        judge.hold_about(&trim::CLEARANCE, least, "in trim.search.airs and strips");
        let verdict = judge.verdict();
        self.status = self.status.max(verdict.status);
        self.reason =
            [self.reason.take(), verdict.reason].into_iter().flatten().reduce(|a, b| format!("{a}; {b}"));
        self.judged.extend(verdict.judged);
    }

    /// Takes a verdict in.
    pub(super) fn take(&mut self, verdict: Verdict) {
        (self.status, self.reason) = (verdict.status, verdict.reason);
        (self.judged, self.warnings) = (verdict.judged, verdict.warnings);
    }
}

/// Warns of flight slower than the wash that carries the weight.
fn judge_slow(judge: &mut Judge, speed: f64, wash: Option<f64>) {
    let Some(wash) = wash else { return };
    let text = format!(
        "{speed:.2} m/s is slower than the wash of {wash:.2} m/s that carries its weight in hover: the wake has no stream to leave by"
    );
    judge.warn(Warning::new("trim.slower_than_wash", text).size(speed / wash).key("trim.speed_m_s"));
}

/// What the scenario says that a periodic flight of `robot` leaves out, and where its numbers are from.
pub(super) fn said_of(spec: &ScenarioSpec, robot: &Robot) -> impl Iterator<Item = Warning> {
    let surfaces = || robot.surfaces().map(|(_, aero)| aero);
    let unheard = unheard::of_strips(&spec.aero, None, surfaces());
    let web = web::open(&spec.robot, robot).into_iter().chain(web::unheard(&spec.robot, robot));
    ignored_gusts(&spec.air)
        .into_iter()
        .chain(fit::of_known(spec))
        .chain(unheard)
        .chain(web)
        .chain(unheard::frictionless(&spec.robot, robot))
        .chain(nearness::in_pieces(robot))
        .chain(unheard::inertance(&spec.flight, robot))
}

/// Gusts of the scenario, which no periodic flight can have; their size is the largest of what is left out, m/s.
fn ignored_gusts(air: &AirSpec) -> Option<Warning> {
    let stated = (!air.gusts.is_empty()).then_some("air.gusts");
    let turbulent = air.dryden.as_ref().map(|_| "air.dryden");
    let key = if air.gust_m_s > 0.0 { Some("air.gust_m_s") } else { stated.or(turbulent) }?;
    let text = format!("{key} is left out: a periodic flight is that in still air");
    let pulses = air.gusts.iter().map(|gust| Vec3(gust.velocity_m_s).norm());
    let turbulence = air.dryden.iter().filter_map(|dryden| dryden.turbulence(0.0).ok());
    let size = pulses.chain(turbulence.flat_map(|of| of.deviation)).fold(air.gust_m_s, f64::max);
    Some(Warning::new("trim.gusts_ignored", text).size(size).key(key))
}
