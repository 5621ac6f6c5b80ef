//! The state of a robot at the start of a cycle, without place and heading.

use std::ops::Range;
use wingbeat_math::Error;
use wingbeat_math::{Mat3, Quat, Scalar, Vec3};
use wingbeat_ocp::plant::Plant;
use wingbeat_robot::{Layout, Robot};

/// A direction in the coordinates: numbers of coordinates with their shares.
pub type Direction = Vec<(usize, f64)>;

/// Velocity in heading axes (3), roll, pitch, angular rate in B (3); then elastic joints and air.
const BODY: usize = 8;
const BODY_NAMES: [&str; BODY] =
    ["v_H_x", "v_H_y", "v_H_z", "roll", "pitch", "w_WB_B_x", "w_WB_B_y", "w_WB_B_z"];
/// Those of flight in the plane of symmetry.
const LONGITUDINAL: [usize; 4] = [0, 2, 4, 6];
const LATERAL: [usize; 4] = [1, 3, 5, 7];

/// Coordinates of a robot at the start of a cycle: velocity in heading axes (W turned by the heading), roll, pitch,
/// angular rate, elastic joints with their rates, states of the air. Place, heading and the structure, which rests at
/// its held commands, are no coordinates.
#[derive(Clone, Debug)]
pub struct OrbitSection {
    layout: Layout,
    names: Vec<String>,
    symmetric: Vec<Direction>,
    antisymmetric: Vec<Direction>,
    alike: bool,
}

/// Accelerations across the plane of symmetry, m/s2 and rad/s2, up to which left and right count as alike, and differences of what left
/// and right do, over what they do: far above rounding, far below those of a centre of mass .01 mm beside the plane.
const ACROSS: f64 = 1e-6;
/// Displacement, rad, and rate, rad/s, of elastic joints where that is looked at, so that springs and dampers act.
const DISPLACED: [f64; 2] = [0.05, 1.0];

/// Whether a robot that flies ahead with both sides moving alike stays so, at four phases: no acceleration out of its plane of symmetry, the
/// same on both sides of each pair of states (`stands`, from the structure on), and no air of `odd` states, which act across the plane.
fn moves_alike(robot: &Robot, stands: &[usize], odd: &[usize]) -> bool {
    let layout = robot.layout();
    let mut x = vec![0.0; layout.len];
    Quat::from_roll_pitch_yaw(0.0, -0.1, 0.0).store_wxyz(&mut x[layout.attitude..]);
    Vec3::new(3.0, 0.0, -0.3).store(&mut x[layout.velocity..]);
    let joints = robot.start_coordinates();
    x[layout.joints..][..joints.len()].copy_from_slice(&joints);
    let (angles, rates) = x[layout.joints..layout.aero].split_at_mut((layout.aero - layout.joints) / 2);
    angles.iter_mut().for_each(|angle| *angle += DISPLACED[0]);
    rates.iter_mut().for_each(|rate| *rate += DISPLACED[1]);
    let (mut slope, held) = (vec![0.0; layout.len], vec![0.0; robot.inputs().len()]);
    (0..4).all(|quarter| {
        let t = f64::from(quarter) / (4.0 * robot.frequency_hz().max(1e-3));
        if robot.rates(t, &x, &held, &mut slope).is_err() {
            return true;
        }
        let across = [layout.velocity + 1, layout.rate, layout.rate + 2].map(|i| slope[i]);
        let rest = &slope[layout.structure..];
        let differs = |(i, &twin): (usize, &usize)| (rest[i] - rest[twin]).abs() / (1.0 + rest[i].abs());
        let pairs = stands.iter().enumerate().map(differs);
        across.into_iter().chain(odd.iter().map(|&i| rest[i])).chain(pairs).all(|by| by.abs() <= ACROSS)
    })
}

impl OrbitSection {
    /// Places of the velocity among the coordinates.
    pub const VELOCITY: Range<usize> = 0..3;
    /// Place of the roll.
    pub const ROLL: usize = 3;
    /// Place of the pitch.
    pub const PITCH: usize = 4;
    /// Places of the angular rate.
    pub const RATE: Range<usize> = 5..BODY;
    /// Number of those of the body, which are the first.
    pub const BODY: usize = BODY;

    /// Coordinates of `robot`.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a motor turns the crank, or left and right differ.
    pub fn new(robot: &Robot) -> Result<Self, Error> {
        let layout = *robot.layout();
        if layout.crank.is_some() {
            return Err(Error::invalid("drive.motor", "given", "a crank that turns at the gait's rate"));
        }
        let mirror = robot.pairs()?;
        // Numbers of the states from the structure on, each with that of the one that stands for it.
        let mut stands = vec![0; layout.len - layout.structure];
        mirror.expand_states(&mirror.states, &mut stands);
        let first = layout.joints - layout.structure;
        // The air of a fin acts across the plane of symmetry.
        let air = layout.aero - layout.structure;
        let odd: Vec<usize> = (air..stands.len()).filter(|i| robot.is_of_one_side(i - air)).collect();
        let side = |both: f64| {
            let pairs = (first..stands.len()).filter(|&i| stands[i] == i);
            pairs
                .filter_map(|i| {
                    let twin = (i + 1..stands.len()).find(|&j| stands[j] == i);
                    let own = BODY + i - first;
                    match twin {
                        Some(twin) => Some(vec![(own, 1.0), (BODY + twin - first, both)]),
                        None => ((both > 0.0) != odd.contains(&i)).then(|| vec![(own, 1.0)]),
                    }
                })
                .collect::<Vec<_>>()
        };
        let body = |which: [usize; 4]| which.map(|i| vec![(i, 1.0)]);
        let of_rest = robot.states()[layout.joints..].iter().map(|channel| channel.name.clone());
        Ok(Self {
            layout,
            names: BODY_NAMES.iter().map(|name| (*name).to_string()).chain(of_rest).collect(),
            symmetric: body(LONGITUDINAL).into_iter().chain(side(1.0)).collect(),
            antisymmetric: body(LATERAL).into_iter().chain(side(-1.0)).collect(),
            alike: moves_alike(robot, &stands, &odd),
        })
    }

    /// Where the states of the robot are.
    pub(super) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Number of coordinates.
    pub fn len(&self) -> usize {
        self.names.len()
    }
    /// Never true.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }
    /// Names of the coordinates.
    pub fn names(&self) -> &[String] {
        &self.names
    }
    /// Directions that keep left and right alike.
    pub fn symmetric(&self) -> &[Direction] {
        &self.symmetric
    }
    /// Directions in which left and right differ.
    pub fn antisymmetric(&self) -> &[Direction] {
        &self.antisymmetric
    }
    /// Whether straight flight keeps left and right alike: not where a mass or a gait lies beside the plane of symmetry.
    pub fn alike(&self) -> bool {
        self.alike
    }
    /// Coordinate of the kind of the coordinate `i`: of the body, of an elastic joint, of the air.
    pub fn kind(&self, i: usize) -> &'static str {
        match i {
            0..BODY => "body",
            _ if i < BODY + self.layout.aero - self.layout.joints => "joint",
            _ => "air",
        }
    }

    /// Unit of the coordinate `i` of a joint or the air of `robot`.
    pub fn unit<'r>(&self, robot: &'r Robot, i: usize) -> &'r str {
        robot.states()[self.layout.joints + i - BODY].unit
    }

    /// Share of `direction` in the coordinates `z`.
    pub fn along<S: Scalar>(direction: &[(usize, f64)], z: &[S]) -> S {
        let sum = direction.iter().fold(S::ZERO, |sum, (i, share)| sum + z[*i] * *share);
        sum * (1.0 / direction.len() as f64)
    }

    /// The state at the origin with heading zero; `structure` holds the displacements of the elements and their rates, all in
    /// the units of their channels.
    pub fn state<S: Scalar>(&self, z: &[S], structure: &[S], x: &mut [S]) {
        let l = &self.layout;
        x[l.position..l.position + 3].fill(S::ZERO);
        Quat::from_roll_pitch_yaw(z[Self::ROLL], z[Self::PITCH], S::ZERO).store_wxyz(&mut x[l.attitude..]);
        x[l.velocity..l.velocity + 3].copy_from_slice(&z[Self::VELOCITY]);
        x[l.rate..l.rate + 3].copy_from_slice(&z[Self::RATE]);
        x[l.structure..l.joints].copy_from_slice(structure);
        x[l.joints..l.len].copy_from_slice(&z[BODY..]);
    }

    /// Roll of the state `x`, rad.
    pub fn roll<S: Scalar>(&self, x: &[S]) -> S {
        Quat::from_wxyz(&x[self.layout.attitude..]).matrix().roll_pitch_yaw()[0]
    }

    /// The coordinates of the state `x`; returns its heading, rad.
    pub fn coordinates<S: Scalar>(&self, x: &[S], z: &mut [S]) -> S {
        let l = &self.layout;
        let [roll, pitch, yaw] = Quat::from_wxyz(&x[l.attitude..]).matrix().roll_pitch_yaw().0;
        let heading = Mat3::rotation_z(-yaw);
        (heading * Vec3::from_slice(&x[l.velocity..])).store(z);
        (z[Self::ROLL], z[Self::PITCH]) = (roll, pitch);
        z[Self::RATE].copy_from_slice(&x[l.rate..l.rate + 3]);
        z[BODY..].copy_from_slice(&x[l.joints..l.len]);
        yaw
    }
}
