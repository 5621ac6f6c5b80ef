//! Ground and ceiling: what they ask of a scenario, how near a flight comes, and what is said of gusts.

use super::spec::{AirSpec, ScenarioSpec};
use wingbeat_aero::Preset;
use wingbeat_flight::simulate::Record;
use wingbeat_judge::Warning;
use wingbeat_math::Error;
use wingbeat_robot::Robot;

/// Key of the plane's height.
const KEY: &str = "air.ground_m";

impl ScenarioSpec {
    /// `robot` over the ground of the scenario, if there is one.
    ///
    /// # Errors
    /// A vacuum, a wind through the plane, a surface that would not feel it.
    pub(super) fn over_ground(&self, robot: Robot) -> Result<Robot, Error> {
        let Some(height) = self.air.ground_m else { return Ok(robot) };
        let refused = |allowed: String| Err(Error::invalid(KEY, height, allowed));
        if robot.is_in_vacuum() {
            return refused("none in a vacuum (air.density_kg_m3 = 0)".into());
        }
        if self.air.wind_m_s[2] != 0.0 {
            return refused("none in a wind that crosses it: air.wind_m_s[2] = 0".into());
        }
        if let Some((name, _)) = robot.surfaces().find(|(_, aero)| aero.preset() != Preset::Full) {
            return refused(format!(
                "none where a surface is not of preset \"full\": {name} would not feel it"
            ));
        }
        Ok(robot.over(height))
    }

    /// Refuses a ground where there is no height.
    pub(super) fn without_ground(&self, what: &str) -> Result<(), Error> {
        match self.air.ground_m {
            None => Ok(()),
            Some(height) => {
                Err(Error::invalid(KEY, height, format!("none in {what}, which knows no height")))
            }
        }
    }
}

/// Least distance of the body's origin and of the edges of the surfaces from a plane at the height `ground` m, on the side on which the
/// body begins, m; negative where something passes through.
pub(super) fn ground_distance(record: &Record, ground: f64) -> Option<f64> {
    let body = record.values("p_WB_z")?;
    let side = if *body.first()? < ground { -1.0 } else { 1.0 };
    let edge =
        |name: &str| name.ends_with("_z") && ["leading_", "trailing_"].iter().any(|of| name.starts_with(of));
    let edges = record.columns().iter().filter(|column| edge(&column.name));
    let heights = edges.filter_map(|column| record.values(&column.name)).chain([body]);
    heights.flatten().map(|height| (height - ground) * side).reduce(f64::min)
}

/// Mean chords from the plane below which strips are cautioned: at one their lift at 8 deg is 2 % above the lattice's, at half of one
/// 10 % (rows `aero.ground.lift.8deg.*`). *Choice.*
const NEAR: f64 = 1.0;

/// The caution that strips of the mean chord `chord` m come so near to the plane of `key` that what they leave out tells: the images'
/// part of the speed along the chord.
pub(super) fn near(distance: Option<f64>, chord: f64, key: &str) -> Option<Warning> {
    let chords = distance? / chord;
    let how =
        if chords > 0.0 { format!("come within {chords:.2} mean chords of") } else { "pass through".into() };
    let text = format!(
        "the wings {how} {key}: strips leave out the speed along the chord by the images, \
         and at 8 deg their lift is 2 % too high at one chord and 10 % at half of one"
    );
    (chords < NEAR).then(|| Warning::new("ground.near", text).size(chords).key(key))
}

impl ScenarioSpec {
    /// Mean chord of the outline of the surface of which it is largest, m, in which a flight of strips tells how near it comes to a plane.
    pub(super) fn strips_chord_m(&self) -> Option<f64> {
        let outlines = self.robot.outlines().ok().filter(|_| self.lattice.is_none())?;
        outlines.iter().map(|outline| outline.planform.mean_chord()).reduce(f64::max)
    }

    /// That caution of a flight of strips.
    pub(super) fn near_ground(&self, distance: Option<f64>) -> Option<Warning> {
        near(distance, self.strips_chord_m()?, KEY)
    }
}

/// The caution that gusts blow through the plane.
pub(super) fn crossing_gusts(air: &AirSpec) -> Option<Warning> {
    air.ground_m?;
    let pulses = air.gusts.iter().map(|gust| gust.velocity_m_s[2].abs());
    let turbulence = air.dryden.iter().filter_map(|dryden| dryden.turbulence(0.0).ok());
    let size = pulses.chain(turbulence.map(|of| of.deviation[2])).fold(air.gust_m_s, f64::max);
    let text =
        "gusts and turbulence are those far from a ground: their upward part blows through air.ground_m";
    (size > 0.0).then(|| Warning::new("flight.ground_gusts", text).size(size).key(KEY))
}
