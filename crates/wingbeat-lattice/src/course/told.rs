//! `summary.json` and what is printed of it.

use super::{CourseRequest, CourseWatch, Strongest};
use serde::Serialize;
use wingbeat::judge::limits::wake;
use wingbeat::judge::{Judge, RunLimits, Status, Verdict, Warning};

/// Ratio of downstroke to upstroke.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DownOverUp {
    /// Ratio of the left half; negative where the bound circulation of one stroke lifts the wing's upper side and that of the other its lower.
    pub left: Option<f64>,
    /// Ratio of the right half.
    pub right: Option<f64>,
}

/// Ratio of left to right half.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LeftOverRight {
    /// Ratio in the downstroke.
    pub down: Option<f64>,
    /// Ratio in the upstroke.
    pub up: Option<f64>,
}

/// What is said of a course.
#[derive(Clone, Debug, Serialize)]
pub struct CourseSummary {
    /// Steps per cycle.
    pub steps_per_cycle: usize,
    /// Mean lift of the last cycle by Joukowski, N; across the flight, up.
    pub mean_lift_n: Option<f64>,
    /// The same by Bernoulli with suction of the leading edge, N.
    pub mean_lift_bernoulli_n: Option<f64>,
    /// Mean drag of the last cycle by Joukowski, N.
    pub mean_drag_n: Option<f64>,
    /// The same by Bernoulli with suction of the leading edge, N.
    pub mean_drag_bernoulli_n: Option<f64>,
    /// Drag of the wake far behind a steady wing, N (in the Trefftz plane); null where the flow is not steady or has no wind.
    pub wake_drag_n: Option<f64>,
    /// Span efficiency L^2/(pi q b^2 D) of a steady wing by that drag; null as that is.
    pub span_efficiency: Option<f64>,
    /// Largest relative change of a half's mean bound circulation within the last cycle, over it: above 0.02 the flow is not
    /// steady.
    pub unsteadiness: Option<f64>,
    /// Share of strips and instants of the last cycle that shed at the leading edge; null in attached flow.
    pub leading_edge_shed: Option<f64>,
    /// Largest way in a step of a vortex that has left a leading edge, mean chords; null in attached flow.
    pub sheet_way_chords: Option<f64>,
    /// Share of trailing edges and steps of the last cycle at which the air comes in over the edge.
    pub inflow_fraction: f64,
    /// Root mean square over the last cycle of the difference of the forces by Joukowski and by Bernoulli over that of the latter; null where they are
    /// rounding.
    pub force_apart_fraction: Option<f64>,
    /// Change of the mean force by Joukowski from the last cycle but one to the last, over its root mean square, dimensionless; null of flights, of motions
    /// that do not repeat, and of a single cycle.
    pub cycle_change_fraction: Option<f64>,
    /// Sum of all circulations over the largest (Kelvin).
    pub circulation_error: f64,
    /// Largest difference of a ring and its mirror image over the largest ring.
    pub symmetry_error: Option<f64>,
    /// Mean bound circulation of the downstroke over that of the upstroke; positive ones lift the wing's upper side.
    pub down_over_up: DownOverUp,
    /// The same of the left half over that of the right.
    pub left_over_right: LeftOverRight,
    /// Share of strips and instants of the last cycle past the stall angle; null where the strip model of a case breaks down.
    pub past_stall: Option<f64>,
    /// Names and shares of the cycle of the phases that are drawn.
    pub phases: Vec<(String, f64)>,
    /// At each of them the strongest ring of the wake: in an upstroke it was mostly shed before.
    pub strongest: Vec<Option<Strongest>>,
}

/// One of several courses.
#[derive(Clone, Debug, Serialize)]
pub struct StretchSummary {
    /// Beginning of the names of its files.
    pub name: String,
    /// Begin, s of the flight.
    pub from_s: f64,
    /// End, s of the flight.
    pub to_s: f64,
    /// What is said of it; nothing where the lattice broke down.
    #[serde(flatten)]
    pub told: Option<CourseSummary>,
}

/// `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct WakeSummary {
    /// The verdict: `ok`, `not_resolved`, `failed` or `interrupted`.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// Name of case or scenario.
    pub name: String,
    /// Whose circulations are shed.
    pub circulations: &'static str,
    /// `free` or `prescribed`.
    pub wake: &'static str,
    /// Panels along chord and span.
    pub panels: [usize; 2],
    /// Radius of the wake's cores, m.
    pub core_m: f64,
    /// Of the first course; nothing where its lattice broke down.
    #[serde(flatten)]
    pub first: Option<CourseSummary>,
    /// Of a flight all of them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stretches: Vec<StretchSummary>,
}

impl CourseSummary {
    /// Of a course that was stepped to its end.
    fn new(watch: &CourseWatch<'_>) -> Option<Self> {
        if watch.failed.is_some() {
            return None;
        }
        let ratio = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a / b);
        let over_up = |side| ratio(watch.circulation(side, 0), watch.circulation(side, 1));
        let over_right = |stroke| ratio(watch.circulation(0, stroke), watch.circulation(1, stroke));
        let axes = watch.course.axes;
        let [wake_drag_n, span_efficiency] = far(watch).map_or([None; 2], |far| far.map(Some));
        Some(Self {
            wake_drag_n,
            span_efficiency,
            unsteadiness: watch.unsteadiness(),
            leading_edge_shed: watch.shed(),
            sheet_way_chords: watch.course.critical_suction.map(|_| watch.farthest),
            steps_per_cycle: watch.course.clock.steps,
            mean_lift_n: watch.mean("joukowski", axes.up),
            mean_lift_bernoulli_n: watch.mean("bernoulli", axes.up),
            mean_drag_n: watch.mean("joukowski", -axes.flight),
            mean_drag_bernoulli_n: watch.mean("bernoulli", -axes.flight),
            inflow_fraction: watch.inflow(),
            force_apart_fraction: watch.apart(),
            cycle_change_fraction: watch.cycle_change(),
            circulation_error: watch.circulation_error,
            symmetry_error: watch.symmetry_error(),
            down_over_up: DownOverUp { left: over_up(0), right: over_up(1) },
            left_over_right: LeftOverRight { down: over_right(0), up: over_right(1) },
            past_stall: watch.course.past_stall,
            phases: watch.shots.iter().map(|shot| (shot.name.clone(), shot.phase)).collect(),
            strongest: watch.shots.iter().map(|shot| watch.strongest(shot)).collect(),
        })
    }

    /// Rows of the printed table: name, number, unit.
    fn rows(&self) -> Vec<(&'static str, Option<f64>, &'static str)> {
        let bound = "mean bound circulation, positive where it lifts";
        let steady = [
            ("wake drag", self.wake_drag_n, "N, of the wake far behind"),
            ("span efficiency", self.span_efficiency, "by the drag of the wake"),
        ];
        let shedding = [
            ("leading edge shed", self.leading_edge_shed, "share of strips and instants"),
            ("way of the sheet", self.sheet_way_chords, "mean chords, largest in a step"),
        ];
        let rows = [
            ("mean lift", self.mean_lift_n, "N, by Joukowski"),
            ("", self.mean_lift_bernoulli_n, "N, by Bernoulli with leading-edge suction"),
            ("mean drag", self.mean_drag_n, "N, by Joukowski"),
            ("", self.mean_drag_bernoulli_n, "N, by Bernoulli with leading-edge suction"),
            ("both ways apart", self.force_apart_fraction, "rms, over that by Bernoulli"),
            ("last two cycles apart", self.cycle_change_fraction, "mean force, over its rms"),
            ("air comes in", Some(self.inflow_fraction), "share of trailing edges and steps, over the edge"),
            ("circulation error", Some(self.circulation_error), ""),
            ("symmetry error", self.symmetry_error, ""),
            ("down over up, left", self.down_over_up.left, bound),
            ("down over up, right", self.down_over_up.right, bound),
            ("left over right, down", self.left_over_right.down, bound),
            ("left over right, up", self.left_over_right.up, bound),
            ("past stall", self.past_stall, "share of strips and instants"),
        ];
        let steady = steady.into_iter().filter(|row| row.1.is_some());
        rows.into_iter().chain(steady).chain(shedding.into_iter().filter(|row| row.1.is_some())).collect()
    }
}

/// Largest unsteadiness of a flow that counts as steady. *Choice.*
const STEADY: f64 = 0.02;

/// Drag of the wake far behind, N, and the span efficiency by it, of a steady wing in a wind.
fn far(watch: &CourseWatch<'_>) -> Option<[f64; 2]> {
    let course = watch.course;
    let (drag, span) = watch.far.filter(|_| course.flown.is_none() && course.critical_suction.is_none())?;
    // A single instant is as steady as a start.
    watch.unsteadiness().filter(|unsteady| course.clock.total() > 1 && *unsteady <= STEADY)?;
    let lift = watch.mean("joukowski", course.axes.up)?;
    // What revolves may bear steady circulations too, and leaves no straight wake.
    watch.mean("joukowski", course.axes.flight).filter(|along| along.abs() <= lift.abs())?;
    let pressure = 0.5 * course.scene.density_kg_m3 * course.scene.wind.norm_squared();
    let efficiency = lift * lift / (std::f64::consts::PI * pressure * span * span * drag);
    (drag > 0.0 && efficiency.is_finite()).then_some([drag, efficiency])
}

/// The verdict on a course.
fn judged(watch: &CourseWatch<'_>, asked: &CourseRequest, limits: &RunLimits) -> Verdict {
    let mut judge = Judge::new(limits);
    match &watch.failed {
        Some(reason) if watch.ended => judge.find(Status::Interrupted, reason),
        Some(reason) => judge.find(Status::Failed, reason),
        None => {
            judge.hold(&wake::KELVIN, watch.circulation_error);
            // What the model sheds is one ring along the chord.
            if !asked.model {
                judge.hold(&wake::ALONG, asked.chordwise as f64);
                judge.hold(&wake::FEW_ALONG, asked.chordwise as f64);
            }
            judge.hold(&wake::ACROSS, asked.spanwise as f64);
            judge.hold(&wake::FEW_ACROSS, asked.spanwise as f64);
            judge.hold(&wake::CORE, asked.core);
            judge.hold(&wake::INFLOW, watch.inflow());
            judge.hold_if(&wake::APART, watch.apart());
            let moved = watch.course.moved;
            moved.iter().for_each(|moved| moved.hold(&mut judge));
            judge.hold_if(&wake::STAYS, moved.and_then(|moved| moved.advance).filter(|_| asked.prescribed));
            let clock = watch.course.clock;
            match moved {
                Some(moved) if moved.repeated.is_none() => {
                    judge.hold(&wake::STEPS_IN_ALL, clock.total() as f64);
                    judge.hold_if(&wake::STARTED, watch.unsteadiness().filter(|_| moved.is_still));
                }
                _ => {
                    judge.hold(&wake::STEPS, clock.steps as f64);
                    judge.hold(&wake::FEW_STEPS, clock.steps as f64);
                }
            }
            judge.hold_if(&wake::CYCLES, watch.cycle_change());
            if let Some(error) = watch.symmetry_error() {
                judge.hold(&wake::DRIFTED, error);
                judge.hold(&wake::LOST, error);
            }
            if watch.course.critical_suction.is_some() {
                judge.hold(&wake::RUNS, watch.farthest);
                judge.hold(&wake::RUN_AWAY, watch.farthest);
                judge.hold(&wake::SHEDS, watch.shed().unwrap_or_default());
            }
        }
    }
    let course = watch.course;
    let attached = Warning::new("wake.attached_flow", course.assumed());
    judge.warn(match course.past_stall {
        Some(share) => attached.size(share),
        None => attached,
    });
    course.unheard.iter().for_each(|warning| judge.warn(warning.clone()));
    course.crossing().into_iter().for_each(|text| judge.warn(Warning::new("wake.crossing", text)));
    judge.verdict()
}

impl WakeSummary {
    /// Of stepped courses, held against `limits`.
    pub fn new(name: &str, asked: &CourseRequest, watches: &[CourseWatch<'_>], limits: &RunLimits) -> Self {
        let judged: Vec<(&str, Verdict)> = watches
            .iter()
            .map(|watch| match watch.course.name.as_str() {
                "" => ("", judged(watch, asked, limits)),
                _ => (watch.course.title.as_str(), judged(watch, asked, limits)),
            })
            .collect();
        let stretch = |watch: &CourseWatch<'_>| {
            let (clock, flown) = (watch.course.clock, watch.course.flown.as_ref()?);
            let duration = clock.cycles as f64 / clock.frequency_hz;
            let (from_s, name) = (flown.from_s, watch.course.name.clone());
            Some(StretchSummary { name, from_s, to_s: from_s + duration, told: CourseSummary::new(watch) })
        };
        let chord = watches.first().map_or(0.0, |watch| watch.course.chord);
        Self {
            verdict: Verdict::together(judged.iter().map(|(name, verdict)| (*name, verdict))),
            name: name.into(),
            circulations: if asked.model { "of the model that flew" } else { "of the lattice" },
            wake: if asked.prescribed { "prescribed" } else { "free" },
            panels: [if asked.model { 1 } else { asked.chordwise }, asked.spanwise],
            core_m: asked.core * chord,
            first: watches.first().and_then(CourseSummary::new),
            stretches: watches.iter().filter_map(stretch).collect(),
        }
    }

    /// What is printed.
    pub fn table(&self) -> String {
        let [chordwise, spanwise] = self.panels;
        let mut text = format!(
            "{}: vortex lattice, {} wake, {chordwise} x {spanwise} panels, circulations {}; last cycle, from rest\n\n",
            self.name, self.wake, self.circulations
        );
        let told: Vec<Option<&CourseSummary>> = match self.stretches.is_empty() {
            true => vec![self.first.as_ref()],
            false => self.stretches.iter().map(|stretch| stretch.told.as_ref()).collect(),
        };
        if !self.stretches.is_empty() {
            let heads: String = self.stretches.iter().map(|s| format!("{:>13}", s.name)).collect();
            text += &format!("{:<22}{heads}\n", "");
        }
        let columns: Vec<_> = told.iter().map(|told| told.map(CourseSummary::rows)).collect();
        let names = columns.iter().flatten().next().map_or(&[][..], |rows| rows);
        for (row, (name, _, unit)) in names.iter().enumerate() {
            let values = columns
                .iter()
                .map(|column| column.as_ref().and_then(|rows| rows.get(row).and_then(|row| row.1)));
            let values: String =
                values.map(|v| format!("{:>13}", v.map_or("-".into(), |v| format!("{v:.4e}")))).collect();
            text += format!("{name:<22}{values}  {unit}").trim_end();
            text.push('\n');
        }
        if let Some(reason) = self.verdict.why_not_judged() {
            text += &format!("\n{}: {reason}\n", self.verdict.status);
        }
        text.extend(self.verdict.warnings.iter().map(|warning| format!("\n{warning}\n")));
        text
    }
}
