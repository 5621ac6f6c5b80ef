//! What the paper says in numbers, and what came out here.

use serde::Serialize;
use serde_json::Value;
use wingbeat::rig::cell::Calibration;
use wingbeat::scenario::PaperResults;
use wingbeat::simulate::Record;
use wingbeat_lattice::course::WakeSummary;

/// Largest difference from the paper that counts as reproduced: mean and rms of roll, mean of pitch (deg), end point (m). *Choice.*
const ROLL_DEG: f64 = 1.0;
const ROLL_RMS_DEG: f64 = 2.0;
const PITCH_DEG: f64 = 2.0;
const END_M: f64 = 0.5;

/// What a statement of the paper came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StatementOutcome {
    /// It came out here.
    Reproduced,
    /// It came out with numbers that were chosen for it.
    Fitted,
    /// It did not.
    Missed,
    /// It cannot hold beside another statement of the paper.
    Refuted,
    /// The paper leaves out what it would take.
    NotComparable,
    /// A run of ours did not give the number.
    NotComputed,
}

impl StatementOutcome {
    fn when(met: Option<bool>) -> Self {
        met.map_or(Self::NotComputed, |met| if met { Self::Reproduced } else { Self::Missed })
    }

    /// Of a turn whose numbers were chosen for what it should show.
    fn fitted(met: Option<bool>) -> Self {
        match Self::when(met) {
            Self::Reproduced => Self::Fitted,
            other => other,
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::Fitted => "fitted",
            Self::Missed => "missed",
            Self::Refuted => "refuted",
            Self::NotComparable => "not comparable",
            Self::NotComputed => "not computed",
        }
    }
}

/// A statement, the paper's words or numbers, and ours.
#[derive(Clone, Debug, Serialize)]
pub struct Statement {
    /// What is stated.
    pub what: &'static str,
    /// What the paper gives.
    pub paper: String,
    /// What came out here.
    pub here: String,
    /// In which run.
    pub of: &'static str,
    /// What that makes of it.
    pub outcome: StatementOutcome,
    /// What must be known to read it.
    pub note: &'static str,
}

/// Summaries and numbers that the statements rest on.
pub struct StatementSources {
    pub turn: Value,
    pub clear: Value,
    pub wake: Option<WakeSummary>,
    pub forces: Option<RigForces>,
    pub arm: Arm,
}

/// What the plan of the slowest run under the paper's limit of the tool's speed came to.
pub enum Arm {
    /// It keeps every limit.
    Planned,
    /// It breaks one, in words.
    Limited(String),
    /// It cannot be planned for another reason, in words.
    Refused(String),
}

/// Ranges of the simulated rig, N and N m.
pub struct RigForces {
    cell: [f64; 2],
    model: [f64; 2],
    pitch: [f64; 2],
}

impl RigForces {
    /// Of the envelope of the runs.
    pub fn of(envelope: &Record) -> Option<Self> {
        let range = |low: &str, high: &str| {
            let least = envelope.values(low)?.iter().copied().fold(f64::INFINITY, f64::min);
            let most = envelope.values(high)?.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            Some([least, most])
        };
        let model = range("simulation_Fz", "simulation_Fz").unwrap_or([f64::NAN; 2]);
        Some(Self { cell: range("low_Fz", "high_Fz")?, model, pitch: range("low_Ty", "high_Ty")? })
    }
}

/// Every statement that has a number.
pub fn all(told: &StatementSources, paper: Option<&PaperResults>) -> Vec<Statement> {
    let mut all = Vec::new();
    if let Some(paper) = paper {
        let main = "the fit of its end point; eight joints, added mass, a horizon of 125 ms for 25 ms or a cycle of 286 ms";
        turn(&mut all, &told.turn, paper, "banking_turn", main);
        let clear = "fitted, on the paper's joints, five intervals over 0.9 of a gait cycle, law without stall; it dives at 34 deg";
        turn(&mut all, &told.clear, paper, "paper_turn_clear", clear);
    }
    wake(&mut all, told.wake.as_ref());
    forces(&mut all, told.forces.as_ref());
    arm(&mut all, &told.arm);
    all.push(load_cell());
    all
}

/// Roll, pitch, end and height of a turn.
fn turn(
    all: &mut Vec<Statement>,
    flight: &Value,
    paper: &PaperResults,
    of: &'static str,
    note: &'static str,
) {
    let number = |key: &str| flight[key].as_f64();
    let near = |key: &str, asked: f64, most: f64| Some((number(key)? - asked).abs() <= most);
    let say = |key: &str| number(key).map_or("-".into(), |value| format!("{value:.1}"));
    let mut put = |what, paper, here, outcome, note| {
        all.push(Statement { what, paper, here, of, outcome, note });
    };
    let held = near("roll_mean_deg", paper.roll_deg, ROLL_DEG)
        .zip(number("roll_rms_error_deg").map(|rms| rms <= ROLL_RMS_DEG));
    let roll = format!("{} deg, rms error {}", say("roll_mean_deg"), say("roll_rms_error_deg"));
    let asked = format!("{} deg", paper.roll_deg);
    put("a bank is held", asked, roll, StatementOutcome::fitted(held.map(|(mean, rms)| mean && rms)), note);
    let asked = format!("{} deg nose up", paper.nose_up_deg);
    // Summaries count nose up negative.
    let pitch = number("pitch_mean_deg").map_or("-".into(), |pitch| format!("{:.1} deg nose up", -pitch));
    let held = near("pitch_mean_deg", -paper.nose_up_deg, PITCH_DEG);
    put("pitch is held", asked, pitch, StatementOutcome::fitted(held), "fitted as the bank is");
    if let Some([low, high]) = paper.pitch_oscillation_deg {
        let within = number("pitch_half_amplitude_deg").map(|swing| (low..=high).contains(&swing));
        let swing = format!("{} deg", say("pitch_half_amplitude_deg"));
        put(
            "pitch swings",
            format!("{low} to {high} deg"),
            swing,
            StatementOutcome::fitted(within),
            "half of the range; fitted as the bank is",
        );
    }
    let end = number("distance_x_m").zip(number("distance_y_m"));
    // The turn of a positive roll is to the right, towards negative y.
    let right = paper.roll_deg.signum() * paper.distance_y_m;
    let away = end.map(|(x, y)| (x - paper.distance_x_m).hypot(-y - right));
    let here = end.zip(away).map_or("-".into(), |((x, y), away)| {
        format!("{x:.1} m ahead, {:.1} m to the right; {away:.1} m off", -y)
    });
    let asked = format!("{} m ahead, {} m to the right", paper.distance_x_m, right);
    let reached = away.map(|away| away <= END_M);
    put("end point", asked, here, StatementOutcome::fitted(reached), "within 0.5 m counts");
    let height = number("altitude_change_m").map_or("-".into(), |change| format!("{change:.1} m"));
    put(
        "height",
        "left out".into(),
        height,
        StatementOutcome::NotComparable,
        "its end point implies that it sinks or slips",
    );
}

fn wake(all: &mut Vec<Statement>, wake: Option<&WakeSummary>) {
    let mut put = |here, outcome| {
        let (what, paper) = ("vorticity falls in the upstroke", "said of its figure".into());
        let note = "no evidence where attached flow is assumed and does not hold";
        all.push(Statement { what, paper, here, of: "banking_turn, vortex lattice", outcome, note });
    };
    let Some(told) = wake.and_then(|wake| wake.first.as_ref()) else {
        return put("-".into(), StatementOutcome::NotComputed);
    };
    let ratio = |ratio: Option<f64>| ratio.map_or("-".into(), |ratio| format!("{ratio:.2}"));
    let both = told.down_over_up.left.zip(told.down_over_up.right);
    let past_stall = told.past_stall.unwrap_or(1.0);
    let here = format!(
        "mean bound circulation of the downstroke over the upstroke: left {}, right {}; {:.0} % of the strips are past stall",
        ratio(told.down_over_up.left),
        ratio(told.down_over_up.right),
        100.0 * past_stall
    );
    // Vorticity has a size, whichever way it turns.
    let falls = both.map(|(left, right)| left.abs().min(right.abs()) > 1.0);
    let attached = past_stall <= 0.05;
    put(here, if attached { StatementOutcome::when(falls) } else { StatementOutcome::NotComparable });
}

/// Loads of the seven runs.
fn forces(all: &mut Vec<Statement>, forces: Option<&RigForces>) {
    let mut put = |what, paper: &str, range: Option<String>, note| {
        let outcome =
            if range.is_some() { StatementOutcome::NotComparable } else { StatementOutcome::NotComputed };
        let (paper, here) = (paper.into(), range.unwrap_or("-".into()));
        all.push(Statement { what, paper, here, of: "seven_runs, simulated", outcome, note });
    };
    let newtons = |[low, high]: [f64; 2]| format!("{low:.2} to {high:.2} N");
    let simulated = "ours is a simulated rig, and no measured file is public";
    put("Fz of the experiment", "-0.5 to 0.5 N", forces.map(|of| newtons(of.cell)), simulated);
    let unsaid = "the paper does not say whether the inertia of the wings is in it";
    let model = forces.filter(|of| of.model[0].is_finite()).map(|of| newtons(of.model));
    put("Fz of the simulation", "-0.3 to 0.3 N", model, unsaid);
    let moment = forces.map(|RigForces { pitch: [low, high], .. }| format!("{low:.3} to {high:.3} N m"));
    put("My", "positive", moment, "its reference point is not given");
}

/// Speed of the runs beside the limit of the arm.
fn arm(all: &mut Vec<Statement>, arm: &Arm) {
    let (here, outcome) = match arm {
        Arm::Planned => ("the run at 0.7 m/s keeps it".into(), StatementOutcome::Reproduced),
        Arm::Limited(words) => (format!("the run at 0.7 m/s: {words}"), StatementOutcome::Refuted),
        Arm::Refused(words) => (format!("the run at 0.7 m/s: {words}"), StatementOutcome::NotComputed),
    };
    let what = "runs at 0.7 to 0.9 m/s, arm within 0.5 m/s";
    let note = "refuted where the slowest run needs more than the limit that the paper states";
    let of = "roll15_speed07, planned with profile paper-tool";
    all.push(Statement { what, paper: "both".into(), here, of, outcome, note });
}

/// The range that the paper gives beside those of the data sheet.
fn load_cell() -> Statement {
    let [low, .., short] = Calibration::Si12.range();
    let [_, _, high, .., long] = Calibration::Si50.range();
    Statement {
        what: "load cell to 480 N and 1.9 N m",
        paper: "range".into(),
        here: format!("measuring ranges of a Nano17 are {low} to {high} N and {short} to {long} N m"),
        of: "data sheet",
        outcome: StatementOutcome::Refuted,
        note: "480 N is its overload; no run decides this",
    }
}

/// The statements as a table.
pub fn table(statements: &[Statement]) -> String {
    let mut text = String::new();
    for Statement { what, paper, here, of, outcome, .. } in statements {
        text += &format!("{:<15} {what} ({of}): the paper {paper}; here {here}\n", outcome.words());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcomes(flight: Value) -> Vec<StatementOutcome> {
        let pitch_oscillation_deg = Some([7.0, 10.0]);
        let (distance_x_m, distance_y_m) = (4.1, 5.0);
        let paper = PaperResults {
            roll_deg: 15.0,
            nose_up_deg: 15.0,
            pitch_oscillation_deg,
            distance_x_m,
            distance_y_m,
        };
        let mut all = Vec::new();
        turn(&mut all, &flight, &paper, "a", "");
        all.iter().map(|statement| statement.outcome).collect()
    }

    #[test]
    fn a_flight_is_held_against_the_papers_numbers() {
        use StatementOutcome::{Fitted, Missed, NotComparable, NotComputed};
        let good = serde_json::json!({ "roll_mean_deg": 15.9, "roll_rms_error_deg": 1.9, "pitch_mean_deg": -13.1,
            "pitch_half_amplitude_deg": 7.0, "distance_x_m": 4.1, "distance_y_m": -4.6, "altitude_change_m": -3.0 });
        assert_eq!(outcomes(good), [Fitted, Fitted, Fitted, Fitted, NotComparable]);
        let poor = serde_json::json!({ "roll_mean_deg": 15.9, "roll_rms_error_deg": 2.1, "pitch_mean_deg": -12.9,
            "pitch_half_amplitude_deg": 10.1, "distance_x_m": 4.1, "distance_y_m": 4.6 });
        assert_eq!(outcomes(poor), [Missed, Missed, Missed, Missed, NotComparable]);
        let none = [NotComputed, NotComputed, NotComputed, NotComputed, NotComparable];
        assert_eq!(outcomes(Value::Null), none);
    }

    #[test]
    fn what_no_run_gave_is_not_computed_and_the_arm_is_decided_by_its_plan() {
        let of = |wake, forces, arm| {
            let told = StatementSources { turn: Value::Null, clear: Value::Null, wake, forces, arm };
            all(&told, None).iter().map(|statement| (statement.of, statement.outcome)).collect::<Vec<_>>()
        };
        let none = of(None, None, Arm::Planned);
        assert_eq!(none.len(), 6);
        assert!(none[..4].iter().all(|(_, outcome)| *outcome == StatementOutcome::NotComputed), "{none:?}");
        assert_eq!(
            (none[4].1, none[5]),
            (StatementOutcome::Reproduced, ("data sheet", StatementOutcome::Refuted))
        );
        let unknown = RigForces { cell: [-0.6, 0.4], model: [f64::NAN; 2], pitch: [-0.1, 0.1] };
        let some = of(None, Some(unknown), Arm::Limited("too fast".into()));
        let outcomes: Vec<StatementOutcome> = some[1..].iter().map(|(_, outcome)| *outcome).collect();
        use StatementOutcome::{NotComparable, NotComputed, Refuted};
        assert_eq!(outcomes, [NotComparable, NotComputed, NotComparable, Refuted, Refuted]);
        assert_eq!(of(None, None, Arm::Refused("out of reach".into()))[4].1, NotComputed);
    }
}
