//! Placing a turn in the arm's workspace.

use super::track::{PathPlacement, track};
use super::usage::{binding, peaks};
use super::{Clearance, Envelope, TrackInstant, TurnPath, TurnSpec};
use crate::Pose;
use crate::arm::{InverseKinematics, LimitProfile, MAX_JOINTS, Payload, SerialArm};
use wingbeat_math::Error;
use wingbeat_math::{Mat3, Random, Vec3};

/// What a placed turn must keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Smallest singular value of the Jacobian, m/rad.
    pub singularity: f64,
    /// Smallest distance to table, arm and wings, m.
    pub clearance: f64,
}

/// Everything that a search for a placement looks at.
#[derive(Debug)]
pub struct PlacementWorkspace<'a> {
    /// The arm.
    pub arm: &'a SerialArm,
    /// Its limits.
    pub profile: &'a LimitProfile,
    /// What it carries.
    pub payload: &'a Payload,
    /// Body in the tool frame, X_TB.
    pub body: Pose,
    /// Space that the wings sweep.
    pub envelope: &'a Envelope,
    /// Height of the table in the base frame, m; negative when the arm stands on a pedestal.
    pub table: f64,
    /// What must be kept.
    pub margins: Margins,
}

/// A turn with the place and the posture found for it.
#[derive(Clone, Debug)]
pub struct PlacedTurn {
    /// The path.
    pub path: TurnPath,
    /// Where it lies.
    pub placement: PathPlacement,
    /// Joint positions at its start, rad.
    pub start: [f64; MAX_JOINTS],
    /// Joint positions in the middle of the steady turn, rad.
    pub middle: [f64; MAX_JOINTS],
    /// Largest share of a limit, with the path's duration and broken margins added.
    pub cost: f64,
}

/// What the search may move: centre of the turn x, y and height of the path, m;
/// radius, m; run-up, straight, roll-in and run-down, s.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TurnCandidate {
    x: [f64; 8],
}

/// Lowest and highest value of what the search may move, in parts of the
/// arm's reach for lengths and s for times.
const RANGE: [[f64; 2]; 8] =
    [[-0.6, 0.6], [-0.6, 0.6], [-0.3, 0.8], [0.3, 1.5], [0.3, 1.2], [-0.3, 0.2], [0.3, 1.2], [0.3, 0.8]];

/// A rough place with a posture.
#[derive(Clone, Copy, Debug)]
struct RoughPlacement {
    at: TurnCandidate,
    posture: [f64; MAX_JOINTS],
    cost: f64,
}

/// Rough places that are refined.
const REFINED: usize = 6;
/// Trials of one refinement.
const TRIALS: usize = 1500;
/// Samples along a path while searching.
const COARSE: usize = 40;
/// Cost of a path that cannot be tracked.
const UNTRACKED: f64 = 1e3;
/// Cost of a second of motion: of two places that keep the limits, the shorter path wins.
const COST_PER_SECOND: f64 = 0.01;

impl PlacementWorkspace<'_> {
    /// Searches place, radius (when free) and posture for the smallest share
    /// of any limit: random postures at the middle of the measured turn, then
    /// a random search with adapted steps on place, radius and times.
    ///
    /// # Errors
    /// Bad numbers in the turn.
    pub fn place(&self, spec: &TurnSpec) -> Result<Option<PlacedTurn>, Error> {
        let mut starts = self.starts(spec)?;
        wingbeat_math::order::ascend_by(&mut starts, |item| item.cost);
        let mut best: Option<PlacedTurn> = None;
        for start in starts.iter().take(REFINED) {
            let found = self.refine(spec, start)?;
            if found.cost < best.as_ref().map_or(UNTRACKED, |b| b.cost) {
                best = Some(found);
            }
        }
        Ok(best)
    }

    /// Rough places and postures with what each costs.
    fn starts(&self, spec: &TurnSpec) -> Result<Vec<RoughPlacement>, Error> {
        let reach = self.reach();
        let mut starts = Vec::new();
        let mut seen: Vec<TurnCandidate> = Vec::new();
        for height in [0.0, 0.2, 0.4, 0.6].map(|k| k * reach) {
            for radius in [0.45, 0.6, 0.8].map(|k| k * reach) {
                for ahead in [-0.2, 0.0, 0.2].map(|k| k * reach) {
                    let guess = [0.0, ahead, height, radius, 0.6, -0.25, 0.7, 0.5];
                    let given = spec.given();
                    let at = TurnCandidate { x: std::array::from_fn(|i| given[i].unwrap_or(guess[i])) };
                    if seen.contains(&at) {
                        continue;
                    }
                    seen.push(at);
                    for posture in self.postures(spec, &at)? {
                        let cost = self.judge(spec, &at, &posture)?.cost;
                        starts.push(RoughPlacement { at, posture, cost });
                    }
                }
            }
        }
        Ok(starts)
    }

    /// Length of the stretched arm with the mount, m.
    fn reach(&self) -> f64 {
        let joints: f64 = self.arm.joints.iter().map(|j| j.mount.origin.norm()).sum();
        joints + self.arm.tool.origin.norm()
    }

    /// Postures that reach the middle of the measured turn.
    fn postures(&self, spec: &TurnSpec, at: &TurnCandidate) -> Result<Vec<[f64; MAX_JOINTS]>, Error> {
        let (path, placement) = self.lay(spec, at)?;
        let (a, b) = path.measured();
        let body = placement.path * path.body(0.5 * (a + b)).values();
        let solver = InverseKinematics::default();
        Ok(solver.postures(self.arm, &(body * self.body.inverse()), 24))
    }

    fn lay(&self, spec: &TurnSpec, at: &TurnCandidate) -> Result<(TurnPath, PathPlacement), Error> {
        let [x, y, z, radius, run_up, straight, roll_in, run_down] = at.x;
        let straight = straight.max(-0.45 * spec.run_up_s.unwrap_or(run_up));
        let path = TurnPath::new(
            &spec.settle([radius, run_up, straight, roll_in, run_down]).map_err(|e| e.within("turn"))?,
        );
        let placed = Pose { rotation: Mat3::IDENTITY, origin: Vec3([x, y, z]) };
        Ok((path, PathPlacement { path: placed, body: self.body }))
    }

    /// (1+1) evolution strategy with the one-fifth rule (Rechenberg 1973) from
    /// `start`; the posture stays on its branch.
    fn refine(&self, spec: &TurnSpec, start: &RoughPlacement) -> Result<PlacedTurn, Error> {
        let reach = self.reach();
        let open = spec.given().map(|x| x.is_none());
        let mut random = Random::new(1);
        let (mut at, mut posture) = (start.at, start.posture);
        let mut best = self.judge(spec, &at, &posture)?;
        let mut step = 0.1;
        let trials = if open.contains(&true) { TRIALS } else { 0 };
        for _ in 0..trials {
            let mut next = at;
            for i in (0..next.x.len()).filter(|&i| open[i]) {
                let scale = if i < 4 { reach } else { 1.0 };
                let [low, high] = RANGE[i].map(|x| x * scale);
                next.x[i] = (next.x[i] + step * scale * random.normal()).clamp(low, high);
            }
            let judged = self.judge(spec, &next, &posture)?;
            if judged.cost < best.cost {
                (best, at) = (judged, next);
                posture = best.middle;
                step *= 1.5;
            } else {
                step = (step * 0.92).max(1e-3);
            }
        }
        Ok(best)
    }

    /// Tracks the path coarsely from its middle outwards and weighs what it costs.
    fn judge(&self, spec: &TurnSpec, at: &TurnCandidate, posture: &[f64]) -> Result<PlacedTurn, Error> {
        let (path, placement) = self.lay(spec, at)?;
        let none = [0.0; MAX_JOINTS];
        let mut placed = PlacedTurn { path, placement, start: none, middle: none, cost: UNTRACKED };
        let Some((start, middle)) = self.back_to_start(&placed, posture) else { return Ok(placed) };
        (placed.start, placed.middle) = (start, middle);
        if let Ok(instants) = self.follow(&placed, COARSE) {
            placed.cost = self.cost(&instants);
        }
        Ok(placed)
    }

    /// Joint positions at the start and in the middle of the steady turn, on the branch of `posture`.
    fn back_to_start(
        &self,
        placed: &PlacedTurn,
        posture: &[f64],
    ) -> Option<([f64; MAX_JOINTS], [f64; MAX_JOINTS])> {
        let solver = InverseKinematics { restarts: 0, iterations: 40, ..Default::default() };
        let (a, b) = placed.path.measured();
        let middle = 0.5 * (a + b);
        let tool_in_body = placed.placement.body.inverse();
        let mut q: [f64; MAX_JOINTS] = std::array::from_fn(|i| posture.get(i).copied().unwrap_or(0.0));
        let mut at_middle = q;
        for k in (0..=COARSE / 2).rev() {
            let t = middle * k as f64 / (COARSE / 2) as f64;
            let goal = placed.placement.path * placed.path.body(t).values() * tool_in_body;
            let solution = solver.follow(self.arm, &goal, &q);
            if solution.position_error > 1e-6 || solution.angle_error > 1e-6 {
                return None;
            }
            q = solution.q;
            if k == COARSE / 2 {
                at_middle = q;
            }
        }
        Some((q, at_middle))
    }

    /// The placed motion at `samples` + 1 instants.
    pub fn follow(&self, placed: &PlacedTurn, samples: usize) -> Result<Vec<TrackInstant>, super::Untracked> {
        track(self.arm, &placed.path, &placed.placement, &placed.start, self.envelope, self.table, samples)
    }

    fn cost(&self, instants: &[TrackInstant]) -> f64 {
        let used = peaks(self.arm, self.profile, Some(self.payload), instants);
        let share = binding(&used).map_or(0.0, |p| p.share());
        let near = instants.iter().fold(Clearance::FREE, |c, i| c.min(i.clearance)).smallest();
        let margin = instants.iter().fold(f64::INFINITY, |m, i| m.min(i.margin));
        let short = |has: f64, wanted: f64| if has < wanted { 1.0 + (wanted - has) / wanted } else { 0.0 };
        let time = COST_PER_SECOND * instants.last().map_or(0.0, |i| i.t);
        share + time + short(near, self.margins.clearance) + short(margin, self.margins.singularity)
    }
}
