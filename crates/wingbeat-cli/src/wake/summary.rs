//! `summary.json` and what is printed of it.

use serde::Serialize;

use super::watch::Watch;
use crate::args::Wake;

/// Difference of left and right, over the largest ring, above which there is a caution. *Choice.*
const DRIFTED: f64 = 0.01;

/// Ratio of downstroke to upstroke.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DownOverUp {
    pub left: Option<f64>,
    pub right: Option<f64>,
}

/// Ratio of left to right half.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LeftOverRight {
    pub down: Option<f64>,
    pub up: Option<f64>,
}

/// What is said of a course.
#[derive(Clone, Debug, Serialize)]
pub struct Told {
    pub steps_per_cycle: usize,
    pub mean_lift_n: Option<f64>,
    pub mean_lift_bernoulli_n: Option<f64>,
    pub mean_drag_n: Option<f64>,
    pub mean_drag_bernoulli_n: Option<f64>,
    pub circulation_error: f64,
    pub symmetry_error: Option<f64>,
    pub down_over_up: DownOverUp,
    pub left_over_right: LeftOverRight,
    /// Share of strips and instants of the last cycle past the stall angle.
    pub past_stall: f64,
    pub phases: Vec<(String, f64)>,
}

/// One of several courses.
#[derive(Clone, Debug, Serialize)]
pub struct Stretch {
    pub name: String,
    pub from_s: f64,
    pub to_s: f64,
    #[serde(flatten)]
    pub told: Told,
}

/// `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    pub status: String,
    pub name: String,
    pub circulations: &'static str,
    pub wake: &'static str,
    pub panels: [usize; 2],
    pub core_m: f64,
    /// Of the first course.
    #[serde(flatten)]
    pub first: Option<Told>,
    /// Of a flight all of them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stretches: Vec<Stretch>,
    pub warnings: Vec<String>,
}

impl Told {
    fn new(watch: &Watch<'_>) -> Self {
        let ratio = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a / b);
        let over_up = |side| ratio(watch.circulation(side, 0), watch.circulation(side, 1));
        let over_right = |stroke| ratio(watch.circulation(0, stroke), watch.circulation(1, stroke));
        let axes = watch.course.axes;
        Self {
            steps_per_cycle: watch.course.clock.steps,
            mean_lift_n: watch.mean("joukowski", axes.up),
            mean_lift_bernoulli_n: watch.mean("bernoulli", axes.up),
            mean_drag_n: watch.mean("joukowski", -axes.flight),
            mean_drag_bernoulli_n: watch.mean("bernoulli", -axes.flight),
            circulation_error: watch.circulation_error,
            symmetry_error: watch.symmetry_error(),
            down_over_up: DownOverUp { left: over_up(0), right: over_up(1) },
            left_over_right: LeftOverRight { down: over_right(0), up: over_right(1) },
            past_stall: watch.course.past_stall,
            phases: watch.shots.iter().map(|shot| (shot.name.clone(), shot.phase)).collect(),
        }
    }

    /// Rows of the printed table: name, number, unit.
    fn rows(&self) -> [(&'static str, Option<f64>, &'static str); 11] {
        let bound = "mean bound circulation";
        [
            ("mean lift", self.mean_lift_n, "N, by Joukowski"),
            ("", self.mean_lift_bernoulli_n, "N, by Bernoulli with leading-edge suction"),
            ("mean drag", self.mean_drag_n, "N, by Joukowski"),
            ("", self.mean_drag_bernoulli_n, "N, by Bernoulli with leading-edge suction"),
            ("circulation error", Some(self.circulation_error), ""),
            ("symmetry error", self.symmetry_error, ""),
            ("down over up, left", self.down_over_up.left, bound),
            ("down over up, right", self.down_over_up.right, bound),
            ("left over right, down", self.left_over_right.down, bound),
            ("left over right, up", self.left_over_right.up, bound),
            ("past stall", Some(self.past_stall), "share of strips and instants"),
        ]
    }
}

/// What of a course one must beware of.
fn warning(watch: &Watch<'_>) -> Option<String> {
    watch.symmetry_error().filter(|error| *error > DRIFTED).map(|error| {
        format!(
            "{}: left and right of a symmetric motion drifted apart by {:.1} % of the largest ring: the free wake is not \
             resolved where it meets the wing or itself; try --prescribed, a larger --core or more --steps",
            watch.course.title,
            100.0 * error
        )
    })
}

impl Summary {
    pub fn new(name: &str, arguments: &Wake, watches: &[Watch<'_>]) -> Self {
        let failed = watches.iter().any(|watch| watch.failed.is_some());
        let stretch = |watch: &Watch<'_>| {
            let (clock, flown) = (watch.course.clock, watch.course.flown.as_ref()?);
            let duration = clock.cycles as f64 / clock.frequency_hz;
            let (from_s, name) = (flown.from_s, watch.course.name.clone());
            Some(Stretch { name, from_s, to_s: from_s + duration, told: Told::new(watch) })
        };
        let chord = watches.first().map_or(0.0, |watch| watch.course.chord);
        let notes = watches.iter().map(|watch| match watch.course.name.as_str() {
            "" => watch.course.note(),
            _ => format!("{}: {}", watch.course.title, watch.course.note()),
        });
        Self {
            status: if failed { "failed".into() } else { "ok".into() },
            name: name.into(),
            circulations: if arguments.model { "of the model that flew" } else { "of the lattice" },
            wake: if arguments.prescribed { "prescribed" } else { "free" },
            panels: [if arguments.model { 1 } else { arguments.chordwise }, arguments.spanwise],
            core_m: arguments.core * chord,
            first: watches.first().map(Told::new),
            stretches: watches.iter().filter_map(stretch).collect(),
            warnings: notes.chain(watches.iter().filter_map(warning)).collect(),
        }
    }

    /// What is printed.
    pub fn table(&self) -> String {
        let [chordwise, spanwise] = self.panels;
        let mut text = format!(
            "{}: vortex lattice, {} wake, {chordwise} x {spanwise} panels, circulations {}; last cycle, from rest\n\n",
            self.name, self.wake, self.circulations
        );
        let told: Vec<&Told> = match self.stretches.is_empty() {
            true => self.first.iter().collect(),
            false => self.stretches.iter().map(|stretch| &stretch.told).collect(),
        };
        if !self.stretches.is_empty() {
            let heads: String = self.stretches.iter().map(|s| format!("{:>13}", s.name)).collect();
            text += &format!("{:<22}{heads}\n", "");
        }
        let columns: Vec<_> = told.iter().map(|told| told.rows()).collect();
        let rows = columns.first().map_or(0, |column| column.len());
        for row in 0..rows {
            let (name, _, unit) = columns[0][row];
            let values = columns.iter().map(|column| column[row].1);
            let values: String =
                values.map(|v| format!("{:>13}", v.map_or("-".into(), |v| format!("{v:.4e}")))).collect();
            text += format!("{name:<22}{values}  {unit}").trim_end();
            text.push('\n');
        }
        for warning in &self.warnings {
            text += &format!("\nnote: {warning}\n");
        }
        text
    }
}
