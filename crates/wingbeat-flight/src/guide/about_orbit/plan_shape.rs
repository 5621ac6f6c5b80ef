//! The shape of soft wings in a plan that does not find it: that of the orbit at the phase of the plan.

use crate::orbit::{Deviations, OrbitSection};
use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};
use wingbeat_math::Scalar;
use wingbeat_math::append_copies;
use wingbeat_ocp::plant::{MAX_STATES, Plant};
use wingbeat_robot::Robot;

/// What a plan knows of wings that give way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanStructure {
    /// Spars and membranes move in the plan as they are loaded there.
    #[default]
    Full,
    /// They move as on the orbit at the same phase.
    Orbit,
}

/// What a given state is taken from: a number that deviates from an orbit, or its rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShapeSource {
    pub number: usize,
    pub is_rate: bool,
    /// Whether the number is itself a rate, which grows with that of the phase.
    pub of_rate: bool,
}

/// The shape of the wings of a robot along its orbits.
pub(super) struct OrbitShape {
    /// For each state of the robot whose shape is given, but for those that are, that of the robot itself.
    kept: Vec<usize>,
    /// The other states of the robot, with their numbers among those that deviate.
    left_out: Vec<[usize; 2]>,
    /// What each given state is taken from.
    pub sources: Vec<ShapeSource>,
    /// Number of states of the robot.
    states: usize,
}

impl OrbitShape {
    /// That of `robot`; `given` is the same with its shape given.
    pub fn new(robot: &Robot, given: &Robot) -> Self {
        let place = |name: &str| robot.states().iter().position(|channel| channel.name == name);
        let number =
            |state: usize| Deviations::coordinate(OrbitSection::BODY + state - robot.layout().joints);
        let is_given = |i: &usize| given.given_states().iter().any(|run| run.contains(i));
        let name = |i: usize| given.states()[i].name.as_str();
        let all = 0..given.states().len();
        let kept: Vec<usize> = all.clone().filter(|i| !is_given(i)).filter_map(|i| place(name(i))).collect();
        let source = |i: usize| {
            let of = name(i).replacen("rate_of_", "", 1);
            let is_rate = of != name(i);
            place(&of).map(|state| ShapeSource {
                number: number(state),
                is_rate,
                of_rate: of.contains("_rate"),
            })
        };
        let states = robot.states().len();
        let wanted = all.clone().filter(is_given).count();
        let sources: Vec<ShapeSource> = all.filter(is_given).filter_map(source).collect();
        assert_eq!(sources.len(), wanted, "each given state is one of the robot or its rate");
        Self {
            sources,
            left_out: (0..states).filter(|i| !kept.contains(i)).map(|i| [i, number(i)]).collect(),
            kept,
            states,
        }
    }

    /// What of the state `x` of the robot, in the units of its channels, is left to the plan.
    pub fn keep(&self, x: &[f64], kept: &mut Vec<f64>) {
        kept.clear();
        kept.extend(self.kept.iter().map(|i| x[*i]));
    }

    /// The state of the robot, in the units of its channels, with the states `kept`, whose others are those of its `numbers` that may deviate
    /// from an orbit; in `room`, which is empty.
    pub fn complete<'x, S: Scalar>(
        &self,
        kept: &[S],
        numbers: &[f64],
        room: &'x mut ArrayVec<S, MAX_STATES>,
    ) -> &'x [S] {
        append_copies(room, S::ZERO, self.states);
        self.kept.iter().zip(kept).for_each(|(i, value)| room[*i] = *value);
        self.left_out.iter().for_each(|[i, number]| room[*i] = S::from(numbers[*number]));
        room
    }
}
