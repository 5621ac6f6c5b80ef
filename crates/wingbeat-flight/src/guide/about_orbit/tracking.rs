//! Following a path: the bank, speed and height that it asks of the regulator about orbits.

use super::schedule::{CourseSchedule, Stretch, StretchPlace};
use crate::guide::path::{self, Path, PathSpec, Station};
use crate::orbit::Course;
use crate::simulate::Column;
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{GRAVITY, Scalar, Vec3};

/// How a path is followed: a linear law of the cross-track error makes the bank, one of the along-track error the speed.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct TrackingSpec {
    /// Largest bank to either side, deg; orbits are found up to it.
    pub bank_limit_deg: f64,
    /// Natural frequency at which a cross-track error dies out, rad/s.
    #[serde(default = "frequency")]
    pub cross_rad_s: f64,
    /// Damping ratio of that.
    #[serde(default = "damping")]
    pub damping: f64,
    /// Time by which the bank is ahead of the path's curvature, s: what the roll takes to follow.
    #[serde(default = "lead")]
    pub lead_s: f64,
    /// Time constant over which the bank asked is smoothed, s: that of a cycle.
    #[serde(default = "smooth")]
    pub smooth_s: f64,
    /// Rate at which an along-track error dies out, 1/s; 0 leaves it.
    #[serde(default = "along")]
    pub along_per_s: f64,
    /// Most that the speed differs for it, m/s.
    #[serde(default = "faster")]
    pub faster_m_s: f64,
}

fn frequency() -> f64 {
    1.2
}
fn damping() -> f64 {
    0.9
}
fn lead() -> f64 {
    0.3
}
fn smooth() -> f64 {
    0.1
}
fn along() -> f64 {
    0.3
}
fn faster() -> f64 {
    0.3
}

ranges!(TrackingSpec {
    bank_limit_deg: Range::inside(0.0, 80.0),
    cross_rad_s: Range::POSITIVE,
    damping: Range::POSITIVE,
    lead_s: Range::between(0.0, 10.0),
    smooth_s: Range::POSITIVE,
    along_per_s: Range::between(0.0, 10.0),
    faster_m_s: Range::between(0.0, 10.0),
});

/// What the path asks of the controller.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demand {
    pub place: Option<StretchPlace>,
    /// Height of the mean path, m.
    pub height: f64,
    /// Speed beyond that of the orbits, m/s.
    pub faster: f64,
    /// The path, where one is followed.
    pub beside: Option<OffsetPlace>,
}

/// A place beside a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct OffsetPlace {
    /// Where the path is nearest to it.
    station: Station,
    /// Arc from where the path should be followed by now to there, m; negative where it is missing.
    along: f64,
    /// Distance to the left of the path, m.
    cross: f64,
}

impl OffsetPlace {
    /// Heading of the path, rad.
    pub fn heading(&self) -> f64 {
        self.station.heading
    }

    /// Of a place near this one the arc from where the path should be followed by now, the distance to its left, m, and
    /// what the path turns up to there, rad; exact to first order.
    pub fn off<S: Scalar>(&self, place: Vec3<S>) -> (S, S, S) {
        let Station { curvature, .. } = self.station;
        let (ahead, cross) = self.station.offset(place);
        let arc = ahead * path::stretch(curvature * self.cross).recip();
        (arc + self.along, cross, arc * curvature)
    }
}

/// What was found of the path at the last update.
#[derive(Clone, Copy, Debug, Default)]
struct PathSighting {
    arc: f64,
    cross: f64,
    along: f64,
    bank: f64,
    nearest: Vec3,
}

/// A path as it is followed.
pub(super) struct PathTracking {
    spec: TrackingSpec,
    path: Path,
    speed: f64,
    period: f64,
    /// Whether distances across and along the path are left to what follows it.
    left: [bool; 2],
    seen: PathSighting,
}

impl TrackingSpec {
    /// The path, where it can be followed at `speed`.
    pub(super) fn checked(&self, path: Option<&PathSpec>, speed: f64) -> Result<Path, Error> {
        self.in_range()?;
        let missing = || Error::invalid("", "given", "a path to follow: add [path]");
        let spec = path.ok_or_else(missing)?;
        let path = spec.build().map_err(|e| e.within("path"))?;
        let bank = (path.sharpest() * speed * speed / GRAVITY).atan().to_degrees();
        if !(bank < self.bank_limit_deg) {
            let allowed =
                format!("more than {bank:.1} deg, which the path's least radius takes at this speed");
            let error = Error::invalid("bank_limit_deg", self.bank_limit_deg, allowed);
            return Err(error.against(spec.keys().into_iter().map(|key| format!("path.{key}"))));
        }
        Ok(path)
    }

    /// Stretches to the limits of the bank on both sides.
    pub(super) fn fan(&self, first: Course) -> CourseSchedule {
        let stretch = |bank_deg: f64| Stretch {
            start: 0.0,
            duration: 1.0,
            from: first,
            to: Course { bank: bank_deg.to_radians(), ..first },
        };
        let stretches = vec![stretch(self.bank_limit_deg), stretch(-self.bank_limit_deg)];
        CourseSchedule { first, stretches, fan: true }
    }
}

impl PathTracking {
    /// `path` at `speed`, with an update every `period` s; of `left` the distances across and along it ask for nothing.
    pub fn new(spec: TrackingSpec, path: Path, speed: f64, period: f64, left: [bool; 2]) -> Self {
        Self { spec, path, speed, period, left, seen: PathSighting::default() }
    }

    /// Columns of [`numbers`](Self::numbers).
    pub fn columns(&self) -> Vec<Column> {
        vec![
            Column::new("path_arc", "m", ""),
            Column::new("path_cross", "m", ""),
            Column::new("path_along", "m", ""),
            Column::new("path_bank", "rad", ""),
            Column::new("path_nearest_x", "m", "W"),
            Column::new("path_nearest_y", "m", "W"),
            Column::new("path_nearest_z", "m", "W"),
        ]
    }

    /// What the last update found of the path, in the units of the columns.
    pub fn numbers(&self) -> [f64; 7] {
        let PathSighting { arc, cross, along, bank, nearest: Vec3([x, y, z]) } = self.seen;
        [arc, cross, along, bank, x, y, z]
    }

    /// What the path asks at the time `t` of a robot at `place` (m) with `velocity` (m/s) in W.
    ///
    /// Equation: guide.path_bank
    /// `g tan(bank) = w^2 e + 2 d w e' - k(s + V lead) V^2, so that e'' = -2 d w e' - w^2 e of a turn at V^2 k = -g
    /// tan(bank)`
    /// Source: coordinated turn; own derivation.
    /// Test: `a_path_is_followed_from_beside_it`.
    pub fn demand(&mut self, t: f64, place: Vec3, velocity: Vec3) -> Demand {
        let (spec, speed) = (&self.spec, self.speed);
        let beside = self.path.beside(place, self.seen.arc);
        let station = self.path.at(beside.arc);
        let (_, growth) = station.offset(station.place + velocity);
        let ahead = self.path.at(beside.arc + speed * spec.lead_s).curvature;
        let aside = spec.cross_rad_s * (2.0 * spec.damping * growth + spec.cross_rad_s * beside.cross);
        let aside = if self.left[0] { 0.0 } else { aside };
        let limit = spec.bank_limit_deg.to_radians();
        let bank = ((aside - ahead * speed * speed) / GRAVITY).atan().clamp(-limit, limit);
        let bank = self.seen.bank + (bank - self.seen.bank) * (1.0 - (-self.period / spec.smooth_s).exp());
        let along = beside.arc - speed * t;
        self.seen =
            PathSighting { arc: beside.arc, cross: beside.cross, along, bank, nearest: station.place };
        self.asked(station, along, beside.cross)
    }

    /// What it asks at the time `t` after the last update of a robot at `place` (m, W) then; the bank stays.
    pub fn ahead(&self, t: f64, place: Vec3) -> Demand {
        let beside = self.path.beside(place, self.seen.arc);
        self.asked(self.path.at(beside.arc), beside.arc - self.speed * t, beside.cross)
    }

    /// What is asked at a station beside which the robot is, with the bank and the speed of the last update.
    fn asked(&self, station: Station, along: f64, cross: f64) -> Demand {
        let (spec, bank) = (&self.spec, self.seen.bank);
        let faster = (-spec.along_per_s * self.seen.along).clamp(-spec.faster_m_s, spec.faster_m_s);
        let share = bank.abs() / spec.bank_limit_deg.to_radians();
        Demand {
            place: Some(StretchPlace { stretch: usize::from(bank < 0.0), share }),
            height: station.place[2],
            faster: if self.left[1] { 0.0 } else { faster },
            beside: Some(OffsetPlace { station, along, cross }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEED: f64 = 4.2;
    const PERIOD: f64 = 0.0075;

    fn tracking(path: &str) -> PathTracking {
        let path: PathSpec = toml::from_str(path).unwrap();
        let spec: TrackingSpec =
            toml::from_str("bank_limit_deg = 35.0\nlead_s = 0.0\nsmooth_s = 0.01").unwrap();
        PathTracking::new(spec, spec.checked(Some(&path), SPEED).unwrap(), SPEED, PERIOD, [false; 2])
    }

    /// A point that turns as its bank says, from `aside` of the path's begin for `time` s; its distances across.
    fn flown(mut tracking: PathTracking, aside: f64, time: f64) -> Vec<f64> {
        let (mut place, mut heading) = (Vec3::new(0.0, aside, 0.0), 0.0_f64);
        let limit = tracking.spec.bank_limit_deg.to_radians();
        let step = |k: usize| {
            let velocity = Vec3::new(heading.cos(), heading.sin(), 0.0) * SPEED;
            let Demand { place: at, faster, .. } = tracking.demand(k as f64 * PERIOD, place, velocity);
            let at = at.unwrap();
            let bank = if at.stretch == 0 { at.share * limit } else { -at.share * limit };
            place += velocity * (PERIOD * (SPEED + faster) / SPEED);
            heading -= GRAVITY * bank.tan() / SPEED * PERIOD;
            tracking.seen.cross
        };
        (0..(time / PERIOD) as usize).map(step).collect()
    }

    #[test]
    fn a_path_is_followed_from_beside_it() {
        let cross = flown(tracking("curve = { line = { length_m = 100.0 } }"), 0.5, 8.0);
        // e'' + 2 d w e' + w^2 e = 0 from rest.
        let (w, d) = (frequency(), damping());
        let damped = w * (1.0 - d * d).sqrt();
        for (k, cross) in cross.iter().enumerate().step_by(40) {
            let t = k as f64 * PERIOD;
            let expected =
                0.5 * (-d * w * t).exp() * ((damped * t).cos() + d * w / damped * (damped * t).sin());
            assert!((cross - expected).abs() < 0.02, "{t}: {cross} for {expected}");
        }
        let eight = flown(tracking("lead_m = 4.0\ncurve = { figure_eight = { radius_m = 4.0 } }"), 0.0, 14.0);
        let largest = eight.iter().fold(0.0, |most: f64, e| most.max(e.abs()));
        assert!(largest < 0.03, "{largest}");
    }

    #[test]
    fn a_place_near_one_beside_the_path_is_told_to_first_order() {
        let mut tracking =
            tracking("lead_m = 4.0\ncurve = { helix = { radius_m = 4.0, turns = 2.0, rise_m = 1.0 } }");
        let place = |k: usize| Vec3::new(5.0 + 0.3 * k as f64, 0.8, 0.0);
        let t = 2.0;
        for k in 0..9 {
            tracking.demand(t, place(k), Vec3::new(SPEED, 0.0, 0.0));
        }
        let beside = |place: Vec3| tracking.ahead(t, place).beside.unwrap();
        let here = beside(place(8));
        assert!(here.station.curvature > 0.1 && here.cross.abs() > 0.1, "{here:?}");
        for by in [Vec3::new(1e-4, 0.0, 0.0), Vec3::new(0.0, 1e-4, 0.0)] {
            let moved = beside(place(8) + by);
            let (along, cross, turned) = here.off(place(8) + by);
            assert!((along - moved.along).abs() < 1e-7, "{along} {}", moved.along);
            assert!((cross - moved.cross).abs() < 1e-7, "{cross} {}", moved.cross);
            assert!((turned + here.heading() - moved.heading()).abs() < 1e-6, "{turned}");
        }
    }

    #[test]
    fn a_bank_that_the_path_needs_is_asked_for() {
        let path: PathSpec = toml::from_str("curve = { figure_eight = { radius_m = 2.0 } }").unwrap();
        let spec: TrackingSpec = toml::from_str("bank_limit_deg = 35.0").unwrap();
        let refused = spec.checked(Some(&path), SPEED).unwrap_err().to_string();
        assert!(refused.contains("bank_limit_deg = 35") && refused.contains("42.0 deg"), "{refused}");
    }
}
