//! Scenarios from text or from the shipped files, flown, and what is asked of the flights.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use wingbeat::judge::Status;
use wingbeat::math::{GRAVITY, Vec3};
use wingbeat::plant::Plant;
use wingbeat::scenario::{Run, Scenario};

/// The folder of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The scenario of the repository called `name`.
pub fn shipped(name: &str, overrides: &[String]) -> Scenario {
    let path = root().join(format!("scenarios/{name}.toml"));
    Scenario::load(&path, overrides).unwrap_or_else(|e| panic!("{e}"))
}

/// Files of a scenario of the text `flight` with the robot of the text `robot`.
fn files(name: &str, robot: &str, flight: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("flyers").join(name);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("robot.toml"), robot).unwrap();
    let path = folder.join("scenario.toml");
    fs::write(&path, format!("name = \"{name}\"\nrobot = \"robot.toml\"\n{flight}")).unwrap();
    path
}

/// The scenario of the text `flight` with the robot of the text `robot`.
pub fn scenario(name: &str, robot: &str, flight: &str, overrides: &[String]) -> Scenario {
    Scenario::load(&files(name, robot, flight), overrides).unwrap_or_else(|e| panic!("{e}"))
}

/// Why such a scenario is refused.
pub fn refused(name: &str, robot: &str, flight: &str) -> String {
    Scenario::load(&files(name, robot, flight), &[]).map(|_| ()).unwrap_err().to_string()
}

/// A scenario and its flight.
pub struct Flown {
    pub scenario: Scenario,
    pub run: Run,
}

/// Flies to the end.
pub fn fly(scenario: Scenario) -> Flown {
    let run = scenario.fly(|_| ControlFlow::Continue(())).unwrap();
    // Of a short flight it is open whether it is carried.
    assert!(run.summary.status <= Status::NotJudged, "{:?}", run.summary.reason);
    Flown { scenario, run }
}

impl Flown {
    /// A column of the record.
    pub fn column(&self, name: &str) -> &[f64] {
        self.run.record.values(name).unwrap_or_else(|| panic!("no column {name}"))
    }

    /// Largest less least.
    pub fn range(values: &[f64]) -> f64 {
        let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    }

    /// Weight, N.
    pub fn weight(&self) -> f64 {
        self.scenario.robot().mass() * GRAVITY
    }

    /// Rows between two times, s.
    fn rows(&self, from: f64, to: f64) -> std::ops::Range<usize> {
        let t = self.column("t");
        t.partition_point(|t| *t < from - 1e-9)..t.partition_point(|t| *t <= to + 1e-9)
    }

    /// Largest deviation from the mean over the `cycle` around, over the second half of the flight.
    pub fn ripple(&self, name: &str, cycle: f64) -> f64 {
        let (values, t) = (self.column(name), self.column("t"));
        let width = (cycle / (t[1] - t[0])).round() as usize;
        let windows = values[values.len() / 2..].windows(width);
        windows.map(|w| (w[width / 2] - w.iter().sum::<f64>() / width as f64).abs()).fold(0.0, f64::max)
    }

    /// State of the robot in a row of the record.
    pub fn state(&self, row: usize) -> Vec<f64> {
        self.scenario.robot().states().iter().map(|s| self.column(&s.name)[row]).collect()
    }

    /// Mean force of the air in W between two times, N (trapezoids).
    pub fn mean_force(&self, from: f64, to: f64) -> Vec3 {
        let (robot, t) = (self.scenario.robot(), self.column("t"));
        let at_rest = vec![0.0; robot.inputs().len()];
        let rows = self.rows(from, to);
        let force = |row: usize| {
            let seen = robot.observe(t[row], &self.state(row), &at_rest).unwrap();
            seen.attitude * (seen.air.total().force + seen.body_drag.force)
        };
        let forces: Vec<Vec3> = rows.map(force).collect();
        let sum = forces.windows(2).fold(Vec3::ZERO, |sum, f| sum + (f[0] + f[1]) * 0.5);
        sum * (1.0 / (forces.len() - 1) as f64)
    }

    /// Mean upward force of the air over the weight.
    pub fn share_of_weight(&self, from: f64, to: f64) -> f64 {
        self.mean_force(from, to)[2] / self.weight()
    }

    /// The air's impulse between two times is the weight's and the change of momentum, which the record's
    /// path of the centre of mass tells; within 1 % of the weight.
    pub fn assert_momentum_balance(&self, from: f64, to: f64) {
        let (t, rows) = (self.column("t"), self.rows(from, to));
        let (first, last) = (rows.start, rows.end - 1);
        let velocity = |name: &str, i: usize| {
            let p = self.column(name);
            (p[i + 1] - p[i - 1]) / (t[i + 1] - t[i - 1])
        };
        let last = last.min(t.len() - 2);
        let mean = self.mean_force(t[first], t[last]);
        for (axis, name) in ["com_x", "com_y", "com_z"].into_iter().enumerate() {
            let slope = (velocity(name, last) - velocity(name, first)) / (t[last] - t[first]);
            let weight = if axis == 2 { GRAVITY } else { 0.0 };
            let needed = self.scenario.robot().mass() * (slope + weight);
            assert!((mean[axis] - needed).abs() < 0.01 * self.weight(), "{name}: {} {needed}", mean[axis]);
        }
    }

    /// Growth between two times of height plus v2 / 2g, m.
    pub fn energy_height_gain(&self, from: f64, to: f64) -> f64 {
        let rows = self.rows(from, to);
        let at = |row: usize| {
            let v2: f64 =
                ["x", "y", "z"].map(|a| self.column(&format!("v_WB_W_{a}"))[row].powi(2)).iter().sum();
            self.column("com_z")[row] + 0.5 * v2 / GRAVITY
        };
        at(rows.end - 1) - at(rows.start)
    }

    /// A robot alike on both sides stays in its plane.
    pub fn assert_symmetric(&self) {
        for name in ["p_WB_y", "roll", "yaw"] {
            let largest = self.column(name).iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            assert!(largest < 1e-6, "{name} reaches {largest}");
        }
    }
}
