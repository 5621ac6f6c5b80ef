//! Robots side by side under one task.

use super::lanes::{LaneRoom, MOST_LANES, Precision};
use super::{Task, View};
use crate::Scenario;
use arrayvec::ArrayVec;
use std::ops::ControlFlow;
use std::sync::Arc;
use wingbeat_flight::simulate::{Saved, Stepper};
use wingbeat_math::Error;
use wingbeat_math::Random;
use wingbeat_math::parallel;
use wingbeat_math::require;
use wingbeat_ocp::plant::Plant;
use wingbeat_robot::Robot;

/// Time between two actions, s.
pub const PERIOD_S: f64 = 0.005;
/// Integration step, s: the attitude of the banking turn is exact to 1e-6 rad after a second.
pub const STEP_S: f64 = 0.001;
/// Most robots of a flock.
const MAX_ROBOTS: usize = 1 << 16;

/// What a step of a flock tells: one row per robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Observations in the units of their channels, robot after robot.
    pub observations: Vec<f64>,
    /// Rewards, dimensionless.
    pub rewards: Vec<f64>,
    /// Terms of the rewards, dimensionless, robot after robot.
    pub terms: Vec<f64>,
    /// Episodes that have failed.
    pub terminated: Vec<bool>,
    /// Episodes that were cut off at their end.
    pub truncated: Vec<bool>,
}

/// Robots of one scenario under one task, stepped several at once in the lanes of vector registers. What becomes of each
/// depends, to the bit, on its seed and its actions alone: a single robot is a lane of one.
pub struct Flock {
    robot: Arc<Robot>,
    task: Arc<dyn Task>,
    members: Vec<Member>,
    /// One for each group of neighbours that are stepped at once.
    sides: Vec<LaneRoom>,
    precision: Precision,
    start: Vec<f64>,
    threads: usize,
    /// Actions of an episode.
    longest: usize,
}

/// One robot.
struct Member {
    robot: Stepper<Arc<Robot>>,
    action: Vec<f64>,
    inputs: Vec<f64>,
    seed: u64,
    spread: f64,
    /// Episodes begun since the seed was given.
    episode: u64,
    /// Time of the stepper at the start of the episode, s.
    begun: f64,
    /// Actions since then.
    count: usize,
    over: bool,
}

/// All that changes of one robot while a flock is stepped, as [`Flock::save`] gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedRobot {
    /// State, inputs and clock.
    pub robot: Saved,
    /// Action in force, each a share of the command's range in [-1, 1].
    pub action: Vec<f64>,
    /// Seed of the episodes.
    pub seed: u64,
    /// How much the start varies, as a factor on what is usual.
    pub spread: f64,
    /// Episodes begun since the seed was given.
    pub episode: u64,
    /// Time of the clock at the start of the episode, s.
    pub begun: f64,
    /// Actions since then.
    pub count: usize,
    /// True when the next step begins the next episode.
    pub over: bool,
}

/// What a robot tells of a step.
struct MemberRow<'a> {
    observation: &'a mut [f64],
    reward: &'a mut f64,
    terms: &'a mut [f64],
    terminated: &'a mut bool,
    truncated: &'a mut bool,
}

impl Flock {
    /// `count` robots of the scenario, stepped on up to `threads` cores (0: all) with numbers of the given precision.
    ///
    /// # Errors
    /// [`Error::Invalid`] for no robots or too many.
    pub fn new(
        scenario: &Scenario,
        task: Arc<dyn Task>,
        count: usize,
        threads: usize,
        precision: Precision,
    ) -> Result<Self, Error> {
        require::between("count", count, 1, MAX_ROBOTS)?;
        let robot = Arc::new(scenario.robot().clone());
        let start = scenario.start();
        let inputs = robot.inputs().len();
        let member = || Member {
            robot: Stepper::new(robot.clone(), 0.0, &start),
            action: vec![0.0; inputs],
            inputs: vec![0.0; inputs],
            seed: 0,
            spread: 0.0,
            episode: 0,
            begun: 0.0,
            count: 0,
            over: false,
        };
        let longest = (task.duration_s() / PERIOD_S).round().max(1.0) as usize;
        let (members, groups) = ((0..count).map(|_| member()).collect(), count.div_ceil(precision.lanes()));
        let sides = (0..groups).map(|_| LaneRoom::new(precision, start.len(), inputs)).collect();
        Ok(Self { members, sides, precision, robot, task, start, threads, longest })
    }

    /// Number of robots.
    pub fn count(&self) -> usize {
        self.members.len()
    }
    /// Numbers of an action.
    pub fn actions(&self) -> usize {
        self.robot.inputs().len()
    }
    /// Numbers of an observation.
    pub fn observations(&self) -> usize {
        self.task.observation().len()
    }
    /// The task.
    pub fn task(&self) -> &dyn Task {
        &*self.task
    }
    /// The robot and time since the start of its episode, s.
    ///
    /// # Panics
    /// When there is no such robot.
    pub fn member(&self, number: usize) -> (&Stepper<Arc<Robot>>, f64) {
        let member = &self.members[number];
        (&member.robot, member.robot.time() - member.begun)
    }

    /// All that changes, robot after robot, for [`restore`](Self::restore).
    pub fn save(&self) -> Vec<SavedRobot> {
        self.members.iter().map(Member::save).collect()
    }

    /// Goes back to what was saved; what follows repeats to the bit.
    ///
    /// # Errors
    /// [`Error::Invalid`] for what another flock saved: another number of robots, states, inputs or actions.
    pub fn restore(&mut self, saved: &[SavedRobot]) -> Result<(), Error> {
        let (states, inputs) = (self.start.len(), self.actions());
        let fits = |one: &SavedRobot| {
            let (x, u, _) = one.robot.parts();
            (x.len(), u.len(), one.action.len()) == (states, inputs, inputs)
        };
        if saved.len() != self.count() || !saved.iter().all(fits) {
            let allowed = format!("what a flock of {} robots of this scenario saved", self.count());
            return Err(Error::invalid("saved", format!("{} robots", saved.len()), allowed));
        }
        self.members.iter_mut().zip(saved).for_each(|(member, saved)| member.restore(saved));
        Ok(())
    }

    /// Starts all anew, each from its seed; the start varies by `spread` times what is usual, at 0 it is that of the scenario.
    /// The observations, in the units of their channels.
    ///
    /// # Panics
    /// When there is not one seed per robot.
    pub fn reset(&mut self, seeds: &[u64], spread: f64) -> Vec<f64> {
        assert_eq!(seeds.len(), self.members.len(), "one seed per robot");
        for (member, seed) in self.members.iter_mut().zip(seeds) {
            (member.seed, member.spread, member.episode) = (*seed, spread, 0);
        }
        self.again()
    }

    /// Starts all on their next episodes. The observations, in the units of their channels.
    pub fn again(&mut self) -> Vec<f64> {
        let mut observations = vec![0.0; self.count() * self.observations()];
        let rows = observations.chunks_mut(self.task.observation().len());
        for (member, row) in self.members.iter_mut().zip(rows) {
            member.begin(&self.start, &*self.task);
            self.task.observe(&member.view(), row);
        }
        observations
    }

    /// A step of all robots under actions in [-1, 1], shares of the commands' ranges, robot after robot, kept within. Where an
    /// episode was over the next one begins instead: its action is not used, its reward is 0.
    ///
    /// # Errors
    /// [`Error::Invalid`] for actions of another number, or that are not finite.
    pub fn step(&mut self, actions: &[f64]) -> Result<Batch, Error> {
        self.step_while(actions, &|| ControlFlow::Continue(()))
    }

    /// The same as long as `watch` lets it. After a break some robots stand before the step and some behind it:
    /// [`restore`](Self::restore) them.
    ///
    /// # Errors
    /// Those of [`step`](Self::step).
    pub fn step_while(
        &mut self,
        actions: &[f64],
        watch: &(dyn Fn() -> ControlFlow<()> + Sync),
    ) -> Result<Batch, Error> {
        let (count, inputs) = (self.count(), self.actions());
        if actions.len() != count * inputs {
            let allowed = match count {
                1 => format!("{inputs}, one of each input"),
                _ => format!("{}, {inputs} of each of {count} robots", count * inputs),
            };
            return Err(Error::invalid("actions", format!("{} numbers", actions.len()), allowed));
        }
        if let Some(place) = actions.iter().position(|action| !action.is_finite()) {
            let key = format!("actions[{}][{}]", place / inputs, place % inputs);
            return Err(Error::invalid(key, actions[place], "a finite number"));
        }
        let (seen, terms) = (self.observations(), self.task.terms().len());
        let mut batch = Batch {
            observations: vec![0.0; count * seen],
            rewards: vec![0.0; count],
            terms: vec![0.0; count * terms],
            terminated: vec![false; count],
            truncated: vec![false; count],
        };
        let rows = batch.observations.chunks_mut(seen).zip(batch.terms.chunks_mut(terms));
        let flags = batch.terminated.iter_mut().zip(&mut batch.truncated);
        let rows = rows.zip(&mut batch.rewards).zip(flags);
        let row = |(((observation, terms), reward), (terminated, truncated))| MemberRow {
            observation,
            reward,
            terms,
            terminated,
            truncated,
        };
        let mut rows: Vec<MemberRow> = rows.map(row).collect();
        let lanes = self.precision.lanes();
        let groups = self.members.chunks_mut(lanes).zip(actions.chunks(lanes * inputs));
        let groups = groups.zip(rows.chunks_mut(lanes)).zip(&mut self.sides);
        let mut groups: Vec<_> = groups
            .map(|(((members, actions), rows), side)| MemberGroup { members, actions, rows, side })
            .collect();
        let course = EpisodeTask { task: &*self.task, start: &self.start, longest: self.longest };
        parallel::chunks(&mut groups, self.threads, |group| {
            if watch().is_continue() {
                group.step(&course);
            }
        });
        Ok(batch)
    }
}

impl Member {
    fn save(&self) -> SavedRobot {
        let Self { robot, action, inputs: _, seed, spread, episode, begun, count, over } = self;
        SavedRobot {
            robot: robot.save(),
            action: action.clone(),
            seed: *seed,
            spread: *spread,
            episode: *episode,
            begun: *begun,
            count: *count,
            over: *over,
        }
    }

    fn restore(&mut self, saved: &SavedRobot) {
        self.robot.restore(&saved.robot);
        self.action.clone_from(&saved.action);
        (self.seed, self.spread, self.episode) = (saved.seed, saved.spread, saved.episode);
        (self.begun, self.count, self.over) = (saved.begun, saved.count, saved.over);
    }

    fn view(&self) -> View<'_> {
        let (robot, x) = (self.robot.system(), self.robot.state());
        let phase =
            robot.layout().crank.map_or_else(|| robot.phase(self.robot.time()), |[angle, _]| x[angle]);
        View { t: self.count as f64 * PERIOD_S, phase, x, action: &self.action }
    }

    /// The start of the next episode: the gait begins at any phase where the start varies.
    fn begin(&mut self, start: &[f64], task: &dyn Task) {
        let mut random = Random::stream(self.seed, self.episode);
        let mut x = start.to_vec();
        self.begun = 0.0;
        if self.spread > 0.0 {
            task.vary(&mut x, self.spread, &mut random);
            let frequency = self.robot.system().frequency_hz();
            self.begun = if frequency > 0.0 { random.unit() / frequency } else { 0.0 };
        }
        self.robot.reset(self.begun, &x);
        self.action.fill(0.0);
        (self.count, self.over) = (0, false);
        self.episode += 1;
    }

    /// Takes the action; false, and the next episode begun, where an episode was over.
    fn take(&mut self, action: &[f64], course: &EpisodeTask) -> bool {
        if self.over {
            self.begin(course.start, course.task);
            return false;
        }
        for (held, action) in self.action.iter_mut().zip(action) {
            *held = action.clamp(-1.0, 1.0);
        }
        let channels = self.robot.system().inputs();
        for ((input, action), channel) in self.inputs.iter_mut().zip(&self.action).zip(channels) {
            *input = 0.5 * (channel.low + channel.high) + 0.5 * (channel.high - channel.low) * action;
        }
        self.robot.set_inputs(&self.inputs);
        true
    }

    /// Tells of the step that was taken.
    fn tell(&mut self, row: &mut MemberRow, course: &EpisodeTask) {
        let whole = self.robot.check().is_ok();
        self.count += 1;
        if !whole {
            // The numbers of a state that cannot be evaluated say nothing: the last observation is that of the start.
            self.robot.reset(self.begun, course.start);
        }
        let (view, task) = (self.view(), course.task);
        task.observe(&view, row.observation);
        if whole {
            task.reward(&view, row.terms);
            *row.reward = row.terms.iter().sum();
        }
        *row.terminated = !whole || task.failed(&view);
        *row.truncated = !*row.terminated && self.count >= course.longest;
        self.over = *row.terminated || *row.truncated;
    }
}

/// What all robots have before them.
struct EpisodeTask<'a> {
    task: &'a dyn Task,
    start: &'a [f64],
    longest: usize,
}

/// Robots that are stepped at once.
struct MemberGroup<'a, 'r> {
    members: &'a mut [Member],
    actions: &'a [f64],
    rows: &'a mut [MemberRow<'r>],
    side: &'a mut LaneRoom,
}

impl MemberGroup<'_, '_> {
    fn step(&mut self, course: &EpisodeTask) {
        let mut moving = ArrayVec::<_, MOST_LANES>::new();
        let inputs = self.actions.len() / self.members.len();
        for (member, action) in self.members.iter_mut().zip(self.actions.chunks(inputs)) {
            moving.push(member.take(action, course));
        }
        let steppers = self.members.iter_mut().zip(&moving).filter(|(_, moving)| **moving);
        let steppers: ArrayVec<_, MOST_LANES> = steppers.map(|(member, _)| &mut member.robot).collect();
        self.side.step(steppers, STEP_S, (PERIOD_S / STEP_S).round() as usize);
        for ((member, row), moved) in self.members.iter_mut().zip(self.rows.iter_mut()).zip(moving) {
            if moved {
                member.tell(row, course);
            } else {
                course.task.observe(&member.view(), row.observation);
            }
        }
    }
}
