//! What a tethered run is held against.

use super::{MeasuredComparison, SparSummary, StepChange, TetherCase, given_twice};
use crate::fit::of_numbers;
use crate::grounded::near;
use crate::moved::{Moved, ideal_power_fraction, repeating};
use crate::unheard::{in_vain, of_strips, side_edges};
use crate::{stall, web};
use wingbeat_aero::Preset;
use wingbeat_flight::simulate::Ending;
use wingbeat_flight::tether::{Periodicity, TetherRun};
use wingbeat_judge::limits::{range, tether};
use wingbeat_judge::{Judge, Status, Verdict, Warning};

/// Excess of the coefficients by rounded speeds above which there is a caution. *Choice.*
const ROUNDED_OFF: f64 = 0.02;

impl TetherCase {
    /// What the run is held against, with the tables of its motion and a measurement.
    pub(crate) fn verdict(
        &self,
        run: &TetherRun,
        step_change: Option<StepChange>,
        compared: Option<&MeasuredComparison>,
    ) -> Verdict {
        let mut judge = Judge::new(&self.limits);
        match run.ending {
            Ending::Complete => {}
            Ending::Stopped => judge.find(Status::Interrupted, "stopped"),
            Ending::Fault(fault) if fault.is_not_finite() => {
                let mend = "loads grew without bound; take more time.steps_per_cycle, or less motion and speed (are they in m, deg and m/s?)";
                judge.find(Status::Failed, format!("not finite: {fault}: {mend}"));
            }
            Ending::Fault(fault) => judge.find(Status::Failed, fault.to_string()),
        }
        if run.ending == Ending::Complete {
            judge.hold_if(&tether::STEPS, step_change.map(|change| change.mean));
            judge.hold_if(&tether::STEPS_OF_POWER, step_change.map(|change| change.power));
            Moved::new(&self.tether).hold(&mut judge);
            judge.hold_if(&tether::IDEAL, ideal_power_fraction(&self.tether, run));
            let planform = self.tether.wing.planform();
            if let Some((spar, numbers)) = self.spec.spar.as_ref().zip(self.spar_numbers) {
                let held = self.tether.motion.is_still();
                numbers.on(spar).judge(
                    (planform, self.spec.wind.density_kg_m3),
                    (run.steady.as_ref(), held),
                    &mut judge,
                );
            }
            for limit in [&range::REVERSED, &range::REVERSED_OUTSIDE] {
                judge.hold(limit, run.reversed_fraction);
            }
            stall::hold(&mut judge, &run.stalled, "aero.law");
            judge.hold(&range::STALLED_OUTSIDE, run.stalled.untested());
            judge.hold(&tether::SLENDER, 2.0 * planform.covered_half_span() / planform.mean_chord());
            if let Some(Periodicity { change, quantity }) = &run.periodicity {
                let mend = format!("({quantity}; take more cycles, unless the motion does not repeat)");
                judge.hold_about(&tether::CYCLES, *change, &mend);
            }
        }
        if let Some(membrane) = self.skin(run) {
            membrane.judge(&mut judge);
        }
        if let Some(flap) = self.hinged(run) {
            flap.judge(&mut judge);
        }
        let (distance, chord) = (self.tether.ground_distance(), self.tether.wing.planform().mean_chord());
        judge.hold_if(&tether::LOW, distance.map(|distance| distance / chord));
        self.slow()
            .into_iter()
            .chain(near(distance, chord, "wind.ground_m"))
            .chain(repeating(run, self.tether.clock.frequency_hz).filter(|_| !self.tether.motion.is_still()))
            .chain(step_change.into_iter().flat_map(|change| self.coarse(change)))
            .chain(of_numbers("numbers", &self.spec.numbers, &self.fitted_model()))
            .chain(given_twice(&self.document, &self.spec))
            .chain(in_vain(&self.document, "aero", [&self.tether.aero]))
            .chain(side_edges(&self.spec.aero, [&self.tether.aero], Some(run.stalled.stalled())))
            .chain(of_strips(&self.spec.aero, None, [&self.tether.aero]))
            .chain(web::of_hinges(&self.spec.wing.hinges, &self.tether.aero))
            .chain(run.steady.iter().flat_map(|steady| {
                let still = self.tether.motion.is_still();
                let (growth, _) = self.limits.of(&tether::FLUTTER);
                SparSummary::of(steady).warnings(&self.spec.time, still, growth)
            }))
            .for_each(|warning| judge.warn(warning));
        // Peaks of a rough table move with the steps: then the data are at fault.
        let trusted = !self.found.iter().any(|finding| finding.serious);
        judge.hold_if(&tether::PEAKS, step_change.map(|change| change.peak).filter(|_| trusted));
        let found = self.found.iter().chain(compared.iter().flat_map(|compared| &compared.found));
        found.cloned().for_each(|finding| finding.put(&mut judge));
        judge.verdict()
    }

    /// The caution that the speed is near the one at which speeds are rounded off, V = sqrt(U^2 + delta^2): the coefficients of a
    /// wing at rest grow by V/U - 1.
    fn slow(&self) -> Option<Warning> {
        let (speed, floor) = (self.tether.reference.speed_m_s, self.tether.aero.regularisation_m_s());
        let excess = speed.hypot(floor) / speed - 1.0;
        (excess > ROUNDED_OFF).then(|| {
            let model = if self.tether.aero.preset() == Preset::Full { "full" } else { "paper" };
            let key = format!("aero.{model}.regularisation_m_s");
            let text = format!(
                "at {speed:?} m/s the speeds that {key} = {floor} rounds off make coefficients {:.0} % too large",
                100.0 * excess
            );
            Warning::new("tether.slow", text).size(excess).key(&key)
        })
    }
}
