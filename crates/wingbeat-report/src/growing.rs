//! A flight that is shown while it is flown: each row that comes is placed once.

use crate::flight::{drawable, motion};
use crate::motion::{MOST, RunMotion};
use crate::panels::{continue_all, flight};
use crate::run::{FlownScenario, ShownRun, of_flight};

/// The rows of a flight that are shown.
#[derive(Clone, Debug, Default)]
pub struct GrowingRows {
    shown: Vec<usize>,
    /// The first row that was not looked at.
    next: usize,
}

impl GrowingRows {
    /// Takes into `run` what the record has more; true where it has only grown by rows behind those that it had.
    pub fn grow(&mut self, run: &mut ShownRun, flown: FlownScenario) -> bool {
        let sound = drawable(flown.record);
        let new: Vec<usize> = (self.next..sound).collect();
        self.next = self.next.max(sound);
        if new.is_empty() {
            return true;
        }
        self.shown.extend(&new);
        if self.shown.len() <= MOST && run.motion.as_mut().is_some_and(|motion| more(motion, flown, &new)) {
            return self.plotted(run, flown);
        }
        while self.shown.len() > MOST {
            let mut number = 0;
            self.shown.retain(|_| {
                number += 1;
                number % 2 == 1
            });
        }
        let whole = of_flight(&run.name, run.kind, flown, &self.shown);
        *run = ShownRun { settings: std::mem::take(&mut run.settings), ..whole };
        false
    }

    /// Takes the rows into the plots; true where these have only grown.
    fn plotted(&self, run: &mut ShownRun, FlownScenario { scenario, record }: FlownScenario) -> bool {
        let ground = scenario.robot().ground();
        let t = record.values("t").unwrap_or_default();
        let old = run.axis.values.len();
        run.axis.values.extend(self.shown[old..].iter().map(|&row| t[row]));
        let earlier = std::mem::replace(&mut run.panels, flight(record, &self.shown, ground));
        continue_all(&run.panels, &earlier)
    }
}

/// Adds the `new` rows to what moves; true where they can be placed.
fn more(motion_so_far: &mut RunMotion, flown: FlownScenario, new: &[usize]) -> bool {
    motion(flown.scenario, flown.record, new).is_ok_and(|more| motion_so_far.extend(more))
}
