//! The banking turn as a motion of the body along time: run-up, straight
//! approach, roll-in, steady turn (where is measured), run-down.

use crate::Pose;
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require::between;
use wingbeat_math::{Jet, Mat3, Scalar, Vec3, pitch_of_nose_up};

/// Longest part of a turn, s: it passes in an arm's reach.
const LONGEST_S: f64 = 60.0;
/// Longest way of a turn, m: far beyond any arm. *Choice.*
const LONGEST_M: f64 = 1e3;
/// Largest roll and pitch, deg.
const STEEPEST_DEG: f64 = 60.0;
/// Times are whole multiples of this, s.
const MILLISECOND: f64 = 1e-3;

/// A banking turn as written in a file; what is absent the planner chooses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct TurnSpec {
    /// Speed along the path where it is measured, m/s.
    pub speed_m_s: f64,
    /// Roll in the turn, deg; positive is right wing down, a turn to the right.
    #[serde(default)]
    pub roll_deg: f64,
    /// Pitch throughout, deg; positive is nose up.
    #[serde(default)]
    pub nose_up_deg: f64,
    /// Time of the steady turn, s.
    pub measured_s: f64,
    /// Centre of the turn in the arm's base frame, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre_m: Option<[f64; 2]>,
    /// Height of the path in the arm's base frame, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_m: Option<f64>,
    /// Radius of the turn, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Time from rest to full speed, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run_up_s: Option<f64>,
    /// Time of straight flight at full speed before the roll-in, s; negative
    /// when the roll-in begins while the speed still rises.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub straight_s: Option<f64>,
    /// Time from wings level to the full roll at full speed, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub roll_in_s: Option<f64>,
    /// Time from full speed to rest, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run_down_s: Option<f64>,
}

/// A banking turn with every number settled. SI units, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BankingPath {
    /// m/s
    pub speed: f64,
    /// rad, positive right wing down
    pub roll: f64,
    /// rad, negative nose up
    pub pitch: f64,
    /// m
    pub radius: f64,
    /// s
    pub run_up: f64,
    /// s
    pub straight: f64,
    /// s
    pub roll_in: f64,
    /// s
    pub measured: f64,
    /// s
    pub run_down: f64,
}

ranges!(TurnSpec {
    speed_m_s: Range::POSITIVE,
    roll_deg: Range::between(-STEEPEST_DEG, STEEPEST_DEG),
    nose_up_deg: Range::between(-STEEPEST_DEG, STEEPEST_DEG),
    measured_s: Range::between(MILLISECOND, LONGEST_S),
    radius_m: Range::POSITIVE,
    run_up_s: Range::between(MILLISECOND, LONGEST_S),
    straight_s: Range::between(-0.5 * LONGEST_S, LONGEST_S),
    roll_in_s: Range::between(MILLISECOND, LONGEST_S),
    run_down_s: Range::between(MILLISECOND, LONGEST_S),
});

impl TurnSpec {
    /// Checks the numbers that are given.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        let run_up = self.straight_s.map_or(1.0, |straight| (-2.0 * straight).clamp(1.0, LONGEST_S));
        self.settle([1.0, run_up, 0.0, 1.0, 1.0]).map(drop)
    }

    /// The turn with `choice` (radius in m; run-up, straight, roll-in, run-down in s) for what the file leaves open. Times are
    /// rounded to whole ms, so that 1 kHz samples meet both ends.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the key.
    pub fn settle(&self, choice: [f64; 5]) -> Result<BankingPath, Error> {
        let ms = |given: Option<f64>, chosen: f64| Some((given.unwrap_or(chosen) * 1e3).round() * 1e-3);
        let [radius, run_up, straight, roll_in, run_down] = choice;
        let settled = Self {
            radius_m: self.radius_m.or(Some(radius)),
            run_up_s: ms(self.run_up_s, run_up),
            straight_s: ms(self.straight_s, straight),
            roll_in_s: ms(self.roll_in_s, roll_in),
            measured_s: (self.measured_s * 1e3).round() * 1e-3,
            run_down_s: ms(self.run_down_s, run_down),
            ..*self
        };
        settled.in_range()?;
        let turn = settled.turn(choice);
        between("straight_s", turn.straight, -0.5 * turn.run_up, LONGEST_S)
            .map_err(|e| e.against(["run_up_s"]))?;
        let way = turn.speed * (turn.run_up + turn.straight + turn.roll_in + turn.measured + turn.run_down);
        if way > LONGEST_M {
            let allowed =
                format!("a way of at most {LONGEST_M} m, far beyond the reach of an arm; it is {way:.0} m");
            return Err(Error::invalid("speed_m_s", turn.speed, allowed).against(["measured_s"]));
        }
        Ok(turn)
    }

    /// The turn in SI units, with `choice` for what is not given.
    fn turn(&self, [radius, run_up, straight, roll_in, run_down]: [f64; 5]) -> BankingPath {
        BankingPath {
            speed: self.speed_m_s,
            roll: self.roll_deg.to_radians(),
            pitch: pitch_of_nose_up(self.nose_up_deg),
            radius: self.radius_m.unwrap_or(radius),
            run_up: self.run_up_s.unwrap_or(run_up),
            straight: self.straight_s.unwrap_or(straight),
            roll_in: self.roll_in_s.unwrap_or(roll_in),
            measured: self.measured_s,
            run_down: self.run_down_s.unwrap_or(run_down),
        }
    }

    /// What the file settles, in the order of the planner's search: centre x and y,
    /// height, radius, run-up, straight, roll-in, run-down.
    pub(super) fn given(&self) -> [Option<f64>; 8] {
        let [x, y] = self.centre_m.map_or([None; 2], |c| c.map(Some));
        [x, y, self.height_m, self.radius_m, self.run_up_s, self.straight_s, self.roll_in_s, self.run_down_s]
    }
}

/// The turn laid out in the path frame P: origin at the centre of the turn on
/// the ground, z up; the steady turn passes the point (0, radius) of a right
/// turn heading along +x in its middle.
#[derive(Clone, Debug)]
pub struct TurnPath {
    turn: BankingPath,
    /// Arc lengths at the start of roll-in and of the steady turn, m.
    roll_in: f64,
    steady: f64,
    /// Heading at the start, rad.
    heading0: f64,
    /// Shift that puts the centre of the turn at the origin, m.
    offset: Vec3,
    /// Positions at multiples of `GRID` along the arc, before the shift, m.
    nodes: Vec<[f64; 2]>,
}

const GRID: f64 = 0.01;

impl TurnPath {
    /// Lays out the turn.
    pub fn new(turn: &BankingPath) -> Self {
        let v = turn.speed;
        let roll_in = v * (0.5 * turn.run_up + turn.straight);
        let mut path = Self {
            turn: *turn,
            roll_in,
            steady: roll_in + v * turn.roll_in,
            heading0: 0.0,
            offset: Vec3::ZERO,
            nodes: vec![[0.0; 2]],
        };
        let middle = path.steady + 0.5 * v * turn.measured;
        path.heading0 = -path.heading(middle).0;
        let count = (path.length() / GRID).ceil() as usize + 1;
        for i in 0..count {
            let a = path.nodes[i];
            let d = path.gauss(i as f64 * GRID, (i + 1) as f64 * GRID);
            path.nodes.push([a[0] + d[0], a[1] + d[1]]);
        }
        let at = path.plane(middle);
        path.offset = Vec3([-at[0], path.side() * turn.radius - at[1], 0.0]);
        path
    }

    /// +1 when the centre lies to the right of the path.
    fn side(&self) -> f64 {
        if self.turn.roll < 0.0 { -1.0 } else { 1.0 }
    }

    /// The turn laid out.
    pub fn turn(&self) -> &BankingPath {
        &self.turn
    }
    /// Length of the path, m.
    pub fn length(&self) -> f64 {
        self.steady + self.turn.speed * (self.turn.measured + 0.5 * self.turn.run_down)
    }
    /// Duration of the motion, s.
    pub fn duration(&self) -> f64 {
        self.measured().1 + self.turn.run_down
    }
    /// Begin and end of the steady turn, s.
    pub fn measured(&self) -> (f64, f64) {
        let begin = self.turn.run_up + self.turn.straight + self.turn.roll_in;
        (begin, begin + self.turn.measured)
    }

    /// Placement X_PB of the body at time `t` (s, 0 to [`duration`](Self::duration)) with its rates.
    pub fn body(&self, t: f64) -> Pose<Jet> {
        let s = self.arc(t);
        let (psi, curvature) = self.heading(s.x);
        let slope = self.curvature_slope(s.x);
        let heading = Jet::new(psi + self.heading0, curvature * s.d, slope * s.d * s.d + curvature * s.dd);
        let (sin, cos) = heading.x.sin_cos();
        let at = self.plane(s.x);
        let along = |p: f64, tangent: f64, normal: f64| {
            Jet::new(p, tangent * s.d, normal * curvature * s.d * s.d + tangent * s.dd)
        };
        let origin = Vec3([
            along(at[0] + self.offset[0], cos, -sin),
            along(at[1] + self.offset[1], sin, cos),
            Jet::ZERO,
        ]);
        let ramp = self.ramp(s);
        let roll = ramp * self.turn.roll;
        let pitch = Jet::from(self.turn.pitch);
        Pose { rotation: Mat3::from_roll_pitch_yaw(roll, pitch, heading), origin }
    }

    /// Arc length along time: smooth steps of speed up and down.
    fn arc(&self, t: f64) -> Jet {
        let (turn, v) = (&self.turn, self.turn.speed);
        let down = self.measured().1;
        if t < turn.run_up {
            let (area, step, slope) = quintic_step((t / turn.run_up).max(0.0));
            Jet::new(v * turn.run_up * area, v * step, v * slope / turn.run_up)
        } else if t <= down {
            Jet::new(v * (t - 0.5 * turn.run_up), v, 0.0)
        } else {
            let x = ((t - down) / turn.run_down).min(1.0);
            let (area, step, slope) = quintic_step(x);
            let begin = v * (down - 0.5 * turn.run_up);
            Jet::new(begin + v * turn.run_down * (x - area), v * (1.0 - step), -v * slope / turn.run_down)
        }
    }

    /// Share of the roll and of the curvature reached at the arc length `s`.
    fn ramp(&self, s: Jet) -> Jet {
        let x = (s - self.roll_in) * (1.0 / (self.steady - self.roll_in));
        if x.x <= 0.0 {
            Jet::ZERO
        } else if x.x >= 1.0 {
            Jet::ONE
        } else {
            let x4 = x * x * x * x;
            x4 * (x * (x * (x * -20.0 + 70.0) - 84.0) + 35.0)
        }
    }

    /// Heading (rad, from the start) and curvature (1/m) at the arc length `s`.
    fn heading(&self, s: f64) -> (f64, f64) {
        let full = -self.side() / self.turn.radius;
        let length = self.steady - self.roll_in;
        let x = (s - self.roll_in) / length;
        if x <= 0.0 {
            return (0.0, 0.0);
        }
        if x >= 1.0 {
            return (full * (0.5 * length + s - self.steady), full);
        }
        let area = x.powi(5) * (7.0 + x * (-14.0 + x * (10.0 - 2.5 * x)));
        (full * length * area, full * self.ramp(Jet::from(s)).x)
    }

    fn curvature_slope(&self, s: f64) -> f64 {
        -self.side() / self.turn.radius * self.ramp(Jet::new(s, 1.0, 0.0)).d
    }

    /// Position in the plane at the arc length `s`, before the shift.
    fn plane(&self, s: f64) -> [f64; 2] {
        let i = ((s / GRID) as usize).min(self.nodes.len() - 1);
        let d = self.gauss(i as f64 * GRID, s);
        [self.nodes[i][0] + d[0], self.nodes[i][1] + d[1]]
    }

    /// Integral of the tangent over [a, b] by five Gauss points.
    fn gauss(&self, a: f64, b: f64) -> [f64; 2] {
        const X: [f64; 5] = [
            -0.906_179_845_938_664,
            -0.538_469_310_105_683_1,
            0.0,
            0.538_469_310_105_683_1,
            0.906_179_845_938_664,
        ];
        const W: [f64; 5] = [
            0.236_926_885_056_189_08,
            0.478_628_670_499_366_47,
            0.568_888_888_888_888_9,
            0.478_628_670_499_366_47,
            0.236_926_885_056_189_08,
        ];
        let (half, mid) = (0.5 * (b - a), 0.5 * (a + b));
        let mut sum = [0.0; 2];
        for (x, w) in X.iter().zip(W) {
            let (sin, cos) = (self.heading(mid + half * x).0 + self.heading0).sin_cos();
            sum[0] += w * half * cos;
            sum[1] += w * half * sin;
        }
        sum
    }
}

/// 6x^5 - 15x^4 + 10x^3 with its integral from 0 and its slope.
fn quintic_step(x: f64) -> (f64, f64, f64) {
    let area = x.powi(4) * (2.5 + x * (-3.0 + x));
    let step = x.powi(3) * (10.0 + x * (-15.0 + 6.0 * x));
    let slope = 30.0 * x * x * (1.0 - x) * (1.0 - x);
    (area, step, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FrameMotion;

    const TURN: BankingPath = BankingPath {
        speed: 0.8,
        roll: 0.26,
        pitch: -0.26,
        radius: 0.6,
        run_up: 0.4,
        straight: 0.05,
        roll_in: 0.5,
        measured: 0.9,
        run_down: 0.4,
    };

    #[test]
    fn the_steady_turn_runs_on_the_circle_at_the_given_speed() {
        let path = TurnPath::new(&TURN);
        let (a, b) = path.measured();
        for k in 0..=10 {
            let m = FrameMotion::from_jets(&path.body(a + (b - a) * k as f64 / 10.0));
            assert!((m.pose.origin.norm() - 0.6).abs() < 1e-12, "{:?}", m.pose.origin);
            assert!((m.velocity.norm() - 0.8).abs() < 1e-12);
            let rpy = m.pose.rotation.roll_pitch_yaw();
            assert!((rpy[0] - 0.26).abs() < 1e-12);
            assert!((rpy[1] + 0.26).abs() < 1e-12);
            assert!((m.rate - Vec3([0.0, 0.0, -0.8 / 0.6])).norm() < 1e-12, "a turn to the right");
        }
        let middle = path.body(0.5 * (a + b)).values().origin;
        assert!((middle - Vec3([0.0, 0.6, 0.0])).norm() < 1e-12);
    }

    #[test]
    fn rates_are_the_slopes_of_the_placement() {
        let path = TurnPath::new(&TURN);
        let h = 1e-4;
        let at = |t: f64| FrameMotion::from_jets(&path.body(t));
        for t in [0.1, 0.3, 0.5, 0.7, 0.94, 1.2, 1.9, 2.1] {
            let (m, a, b) = (at(t), at(t - h), at(t + h));
            let slope = (b.pose.origin - a.pose.origin) * (0.5 / h);
            assert!((slope - m.velocity).norm() < 1e-6, "{t}");
            assert!(((b.velocity - a.velocity) * (0.5 / h) - m.acceleration).norm() < 1e-5, "{t}");
            assert!(((b.rate - a.rate) * (0.5 / h) - m.angular_acceleration).norm() < 2e-5, "{t}");
        }
        let end = at(path.duration());
        assert!(at(0.0).velocity.norm() < 1e-12 && end.velocity.norm() < 1e-12);
    }

    #[test]
    fn the_roll_in_may_begin_while_the_speed_rises() {
        let path = TurnPath::new(&BankingPath { straight: -0.2, ..TURN });
        let at = |t: f64| FrameMotion::from_jets(&path.body(t));
        assert!(at(0.15).pose.rotation.roll_pitch_yaw()[0] > 1e-9, "already rolling");
        assert!((at(path.measured().0).velocity.norm() - 0.8).abs() < 1e-12);
        let spec = TurnSpec {
            speed_m_s: 0.8,
            roll_deg: 15.0,
            nose_up_deg: 15.0,
            measured_s: 0.9,
            centre_m: None,
            height_m: None,
            radius_m: None,
            run_up_s: Some(0.4),
            straight_s: Some(-0.3),
            roll_in_s: None,
            run_down_s: None,
        };
        let message = spec.settle([0.6, 0.4, 0.0, 0.5, 0.4]).unwrap_err().to_string();
        assert!(message.contains("straight_s = -0.3"), "{message}");
    }

    #[test]
    fn a_negative_roll_turns_left() {
        let path = TurnPath::new(&BankingPath { roll: -0.26, ..TURN });
        let (a, b) = path.measured();
        let m = FrameMotion::from_jets(&path.body(0.5 * (a + b)));
        assert!(m.rate[2] > 0.0 && m.pose.origin[1] < 0.0);
    }
}
