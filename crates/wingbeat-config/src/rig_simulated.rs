//! A run of the bench from its plan to its samples.

use super::lattice;
use super::link_spar::{LinkSparSummary, hold_shape};
use super::pinned::PinSummary;
use super::plausible;
use super::skin::MembraneSummary;
use super::stall;
use super::summary::touching;
use super::unheard::{frictionless, of_strips, side_edges};
use super::web;
use super::{LatticeSummary, RigRun};
use serde::Serialize;
use wingbeat_aero::Aero;
use wingbeat_flight::simulate::Record;
use wingbeat_judge::limits::{flap, rig, trim, wake};
use wingbeat_judge::{Judge, Status, Verdict, Warning};
use wingbeat_math::Error;
use wingbeat_ocp::plant::Plant;
use wingbeat_robot::Deflections;

/// What became of a simulated run.
#[derive(Clone, Debug)]
pub struct SimulatedRun {
    /// The verdict: `ok`, `outside`, `not_found` or `failed`.
    pub verdict: Verdict,
    /// `ok`, `refused` where the turn cannot be planned, or `fault`.
    pub ending: &'static str,
    /// Begin and end of what is averaged, s.
    pub window_s: (f64, f64),
    /// The samples, of a run that is `ok`.
    pub record: Option<Record>,
    /// Samples with a saturated channel.
    pub saturated: usize,
    /// Share of strips and samples after the rest that are past their stall angle.
    pub stall_fraction: Option<f64>,
    /// How motion and vortex lattice were brought together, where one takes the place of the preset's attached flow.
    pub lattice: Option<LatticeSummary>,
    /// Membranes; none of a robot without one, or without samples.
    pub membrane: Option<MembraneSummary>,
    /// Springs on pins of the linkage, likewise.
    pub pin_springs: Option<PinSummary>,
}

/// `summary.json` of a simulated run.
#[derive(Clone, Debug, Serialize)]
pub struct SimulatedSummary {
    /// The verdict: `ok`, `outside`, `not_found` or `failed`.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// `ok`, `refused` where the turn cannot be planned, or `fault`.
    pub ending: &'static str,
    /// Flapping frequency, Hz.
    pub frequency_hz: f64,
    /// Begin and end of what is averaged, s.
    pub window_s: (f64, f64),
    /// Samples.
    pub samples: usize,
    /// Samples with a saturated channel.
    pub saturated: usize,
    /// Share of strips and samples after the rest that are past their stall angle; missing without samples.
    pub stall_fraction: Option<f64>,
    /// How motion and vortex lattice were brought together, where one takes the place of the preset's attached flow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lattice: Option<LatticeSummary>,
    /// Membranes: largest rise over the chord, slack share, frequency of the gait over theirs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub membrane: Option<MembraneSummary>,
    /// Springs on pins of the linkage: largest deflection from rest, that over its limit, power.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pin_springs: Option<PinSummary>,
}

impl SimulatedRun {
    fn without_samples(ending: &'static str, verdict: Verdict, window_s: (f64, f64)) -> Self {
        Self {
            verdict,
            ending,
            window_s,
            record: None,
            saturated: 0,
            stall_fraction: None,
            lattice: None,
            membrane: None,
            pin_springs: None,
        }
    }

    /// What is written of it; `run` is whose it is.
    pub fn summary(&self, run: &RigRun) -> SimulatedSummary {
        SimulatedSummary {
            verdict: self.verdict.clone(),
            ending: self.ending,
            frequency_hz: run.frequency(),
            window_s: self.window_s,
            samples: self.record.as_ref().map_or(0, Record::rows),
            saturated: self.saturated,
            stall_fraction: self.stall_fraction,
            lattice: self.lattice,
            membrane: self.membrane,
            pin_springs: self.pin_springs,
        }
    }
}

/// Instants of a cycle at which clearances are looked at.
pub(super) const LOOKS: usize = 64;

impl RigRun {
    /// Plans the turn, where there is one, and simulates the run on the bench that `rig.truth` says is the true one; `progress` is told the share that is done.
    ///
    /// # Errors
    /// Those of [`plan`](Self::plan) and [`simulate`](Self::simulate).
    pub fn simulated(&self, seed: u64, progress: impl FnMut(f64)) -> Result<SimulatedRun, Error> {
        let mut judge = Judge::new(&self.limits);
        self.of_fit().for_each(|warning| judge.warn(warning));
        let plan = match self.spec.turn {
            None => None,
            Some(_) => match self.plan()? {
                Ok(plan) => Some(plan),
                Err(refusal) => {
                    let reason = format!("limit profile {}: {refusal}", self.profile.name);
                    judge.find(Status::NotFound, reason);
                    return Ok(SimulatedRun::without_samples("refused", judge.verdict(), (0.0, 0.0)));
                }
            },
        };
        let carrier = self.carrier(plan.as_ref());
        let window_s = self.window(plan.as_ref(), &carrier);
        let outcome = match self.simulate_truth(&carrier, window_s, seed, progress)? {
            Ok(outcome) => outcome,
            Err(fault) => {
                let finer = plausible::of_short_periods(&self.robot, "a higher rig.cell.rate_hz");
                judge.find(Status::Failed, format!("{fault}{finer}"));
                return Ok(SimulatedRun::without_samples("fault", judge.verdict(), window_s));
            }
        };
        let lattice = outcome.coupling.map(|of| LatticeSummary::new(of, self.spec.lattice.as_ref()));
        judge.hold(&rig::SATURATED, outcome.saturated as f64 / outcome.record.rows().max(1) as f64);
        stall::hold(&mut judge, &outcome.stalled, "rig.aero.law");
        judge.hold_if(&wake::INFLOW, lattice.map(|lattice| lattice.inflow_fraction));
        let skin = |((_, aero), heights): ((&str, &Aero), &Vec<[f64; 2]>)| {
            MembraneSummary::of(aero, heights.iter().copied(), self.frequency())
        };
        let membrane =
            self.robot.surfaces().zip(&outcome.heights).filter_map(skin).reduce(MembraneSummary::worse);
        membrane.iter().for_each(|membrane| membrane.judge(&mut judge));
        let Deflections { flap, spar } = outcome.deflections;
        let hinged = self.robot.surfaces().any(|(_, aero)| aero.flap().is_some());
        for (limit, value, there) in
            [(&flap::ANGLE, flap.to_degrees(), hinged), (&flap::BEYOND_ANGLE, flap.to_degrees(), hinged)]
        {
            judge.hold_if(limit, there.then_some(value));
        }
        LinkSparSummary::new(&self.robot, spar).iter().for_each(|spar| spar.judge(&mut judge));
        let pin_springs = PinSummary::of(&self.robot, &outcome.record);
        pin_springs.iter().for_each(|pins| pins.judge(&mut judge));
        judge.hold_if(&trim::PEAK, pin_springs.map(|pins| pins.power_max_w / self.robot.mass()));
        hold_shape(&mut judge, &self.robot);
        plausible::hold_followed(&mut judge, &self.robot);
        let (crossing, least) = self.clearance();
        judge.hold(&rig::CROSSING, crossing);
        judge.hold(&rig::CROSSED, crossing);
        judge.hold_if(&trim::SKIN, least.and_then(touching));
        let cautions = lattice.iter().flat_map(LatticeSummary::cautions);
        cautions.for_each(|caution| judge.warn(Warning::new("rig.lattice", caution)));
        let surfaces = || self.robot.surfaces().map(|(_, aero)| aero);
        let edges = side_edges(&self.spec.rig.aero, surfaces(), Some(outcome.stalled.stalled()));
        let flow = self.spec.lattice.as_ref();
        let soft = lattice::soft(flow, surfaces());
        let said = of_strips(&self.spec.rig.aero, flow, surfaces()).into_iter().chain(edges).chain(soft);
        let unheard = web::unheard(&self.spec.rig.robot, &self.robot).filter(|_| flow.is_none());
        let said = said.chain(web::open(&self.spec.rig.robot, &self.robot)).chain(unheard);
        let said = said.chain(frictionless(&self.spec.rig.robot, &self.robot));
        said.for_each(|said| judge.warn(said));
        Ok(SimulatedRun {
            verdict: judge.verdict(),
            ending: "ok",
            window_s,
            record: Some(outcome.record),
            saturated: outcome.saturated,
            stall_fraction: Some(outcome.stalled.stalled()),
            lattice,
            membrane,
            pin_springs,
        })
    }

    /// Share of the cycle of the gait in which a clearance is below zero, and the least of all, m, elastic joints at rest.
    fn clearance(&self) -> (f64, Option<f64>) {
        let (robot, frequency) = (self.cranked(), self.frequency());
        if !(frequency > 0.0) {
            return (0.0, None);
        }
        let structure = vec![0.0; robot.states().len() - robot.layout().structure];
        let (mut below, mut least) = (0, None);
        for k in 0..LOOKS {
            let all = robot.least_clearances(k as f64 / (LOOKS as f64 * frequency), &structure);
            let Some(now) = all.ok().and_then(|all| all.into_iter().reduce(f64::min)) else { continue };
            below += usize::from(now < 0.0);
            least = Some(least.map_or(now, |least: f64| least.min(now)));
        }
        (below as f64 / LOOKS as f64, least)
    }
}
