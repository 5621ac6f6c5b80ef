//! What `wingbeat trim` is asked.

use super::search::SearchSpec;
use crate::Scenario;
use serde::{Deserialize, Serialize};
use wingbeat_flight::orbit::{Course, Cycle, Free, Point, steadiness};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_robot::Robot;

/// What two free numbers count for that leave the frequency where it is, beside two of which it is one. *Choice*: a gait whose frequency
/// stays is seldom a good one.
const HELD_FREQUENCY: f64 = 0.1;

/// The periodic flight that `wingbeat trim` looks for, beginning from the scenario's start and the robot's gait.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct TrimSpec {
    /// Mean speed along the ground, m/s.
    pub speed_m_s: f64,
    /// Mean climb, m/s; negative descends.
    #[serde(default)]
    pub climb_m_s: f64,
    /// Bank of a turn with the yaw rate g tan(bank)/V, which is its mean roll, deg; positive is right wing down. 0 flies
    /// straight.
    #[serde(default)]
    pub bank_deg: f64,
    /// What may be chosen: `frequency`, and held commands by the name of their actuator; `twist` stands for
    /// `twist_left` and `twist_right`, which move alike in straight flight and each by itself in a turn. Straight flight takes
    /// the first two, a turn four or more and of them the least commands that fly it.
    pub free: Vec<String>,
    /// Integration step at the robot's own frequency, s; a cycle keeps its number of steps.
    #[serde(default = "step")]
    pub step_s: f64,
    /// Orbits along a parameter, from the one asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub family: Option<FamilySpec>,
    /// The gait that does something best, in place of the robot's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub search: Option<SearchSpec>,
}

fn step() -> f64 {
    5e-4
}

/// Orbits along a parameter.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct FamilySpec {
    /// What changes: `speed_m_s`, `climb_m_s` or `bank_deg` of `trim`, or any key of the scenario that holds a number, such as
    /// `robot.body.mass_kg`.
    pub along: String,
    /// Its value in the last orbit, in the unit of the key.
    pub to: f64,
    /// Number of orbits after the first.
    pub steps: usize,
}

ranges!(TrimSpec {
    speed_m_s: Range::between(0.1, 100.0),
    climb_m_s: Range::between(-50.0, 50.0),
    bank_deg: Range::inside(-80.0, 80.0),
    step_s: Range::over(0.0, 0.01),
});
ranges!(FamilySpec { to: Range::between(-1e9, 1e9), steps: Range::between(1.0, 1000.0) });

/// Numbers that are free at least in a turn, and in any flight of a robot whose left and right differ.
pub(super) const COUPLED: usize = 4;

impl TrimSpec {
    /// Level flight at `speed`, of which nothing is free yet.
    pub(super) fn level(speed_m_s: f64) -> Self {
        Self {
            speed_m_s,
            climb_m_s: 0.0,
            bank_deg: 0.0,
            free: Vec::new(),
            step_s: step(),
            family: None,
            search: None,
        }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        if let Some(family) = &self.family {
            family.in_range().map_err(|e| e.within("family"))?;
        }
        let Some(search) = &self.search else { return Ok(()) };
        search.check().map_err(|e| e.within("search"))?;
        if self.bank_deg != 0.0 {
            let allowed = "0: gaits are searched in straight flight";
            return Err(Error::invalid("bank_deg", self.bank_deg, allowed).against(["search"]));
        }
        Ok(())
    }

    /// The course asked.
    pub(super) fn course(&self) -> Course {
        Course { speed: self.speed_m_s, climb: self.climb_m_s, bank: self.bank_deg.to_radians() }
    }

    /// Puts those two first of what is free that lead to the orbits of straight flight about `point` of `scenario` best, where they do so
    /// `better` times as well as the first two.
    pub(super) fn frees_the_steadiest(
        &mut self,
        scenario: &Scenario,
        cycle: &Cycle,
        point: &Point,
        better: f64,
    ) -> Result<(), String> {
        let course = self.course();
        let named = |name: &String| Free::named(scenario.model(), name, false);
        let free: Vec<Free> = self.free.iter().filter_map(named).flatten().collect();
        if cycle.coupled(&course) || free.len() != self.free.len() || free.len() < 3 {
            return Ok(());
        }
        let all = steadiness(cycle, &course, &free, point).map_err(|failure| failure.to_string())?;
        let worth = |(pair, least): &([usize; 2], f64)| {
            let held = pair.iter().all(|place| free[*place] != Free::Frequency);
            if held { HELD_FREQUENCY * least } else { *least }
        };
        let best = all.iter().max_by(|a, b| worth(a).total_cmp(&worth(b)));
        if let Some(([i, j], _)) = best.filter(|best| worth(best) > better * worth(&all[0])) {
            self.free.swap(0, *i);
            self.free.swap(1, *j);
        }
        Ok(())
    }

    /// What is free: in straight flight the first two, of which pairs move alike; in a turn all, each by itself.
    pub(super) fn free(&self, robot: &Robot, turning: bool) -> Result<Vec<Free>, Error> {
        let mut all = Vec::new();
        let names = if turning { self.free.len() } else { self.free.len().min(2) };
        for (i, name) in self.free[..names].iter().enumerate() {
            let key = format!("trim.free[{i}]");
            if self.free[..i].contains(name) {
                return Err(Error::invalid(key, format!("{name:?}"), "each name once"));
            }
            all.extend(
                Free::named(robot, name, turning)
                    .ok_or_else(|| Error::invalid(key, format!("{name:?}"), Free::names(robot).join(", ")))?,
            );
        }
        let needed = if turning { COUPLED } else { 2 };
        if all.len() < needed || (!turning && all.len() != needed) {
            let allowed = if turning {
                "four numbers or more for a turn, or for a robot whose left and right differ"
            } else {
                "two for straight flight"
            };
            return Err(Error::invalid("trim.free", format!("{:?}", self.free), allowed));
        }
        Ok(all)
    }
}
