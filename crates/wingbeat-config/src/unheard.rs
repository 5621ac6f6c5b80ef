//! What a run says of strips: keys that none of its models hears, keys that mislead, hinges that crowd them, few of them.

use super::doors::ChosenKinds;
use super::spec::{AeroSpec, FlightSpec, FullAeroSpec, ScenarioSpec};
use super::{Document, LatticeSpec};
use wingbeat_aero::{Aero, CD0, CRITICAL_SUCTION, Preset};
use wingbeat_judge::Warning;
use wingbeat_robot::{Robot, RobotSpec};

/// A key whose term the strip model alone has, and its value where one is given or is not the default.
type StripKey = (&'static str, fn(&FullAeroSpec) -> Option<bool>);

/// All of them.
const STRIP_KEYS: [StripKey; 3] = [
    ("aero.full.turning_impulse", |full| full.turning_impulse),
    ("aero.full.edge_suction", |full| full.edge_suction),
    ("aero.full.side_edges", |full| full.side_edges.then_some(true)),
];

/// Strips from which on a flapping wing's thrust errs by 5 % or less (`cases/flap_f2.toml`). *Choice.*
const FEW: usize = 6;

/// Mean sweep of the line of the quarter chords, deg, from which on a straight lifting line is told: 10 % of lift by the cosine, and more than
/// Aerobat has, 19 deg. *Choice.*
const SWEPT: f64 = 25.0;

/// The warning that hinges of one of `models` lie too close for its strips.
fn crowded(models: &[&Aero]) -> Option<Warning> {
    let is_crowded = |model: &&&Aero| matches!(model, Aero::Strip(strips) if strips.is_crowded());
    let strips = models.iter().find(is_crowded)?.strips();
    let text = format!(
        "hinges lie so close for {strips} strips that widths jump beside them, and a folded wing's lift errs by as much as one strip's share: take more strips"
    );
    Some(Warning::new("aero.strips_crowded", text).size(strips as f64).key("aero.full.strips"))
}

/// The warning that the largest of `models` has few strips, with what those of a flapping wing err by beside 32 (`cases/flap_f2.toml`).
fn few(models: &[&Aero]) -> Option<Warning> {
    let full = models.iter().filter(|model| model.preset() == Preset::Full);
    let most = full.map(|model| model.strips()).max().filter(|most| *most < FEW)?;
    let text = format!(
        "{most} strips are few: thrust and power of `cases/flap_f2.toml` err by 41 and 7 % with 3, by 17 and 4 % with 5, by 3 and 2 % with 8"
    );
    Some(Warning::new("aero.few_strips", text).size(most as f64).key("aero.full.strips"))
}

/// The warning that one of `models` is a straight lifting line of a wing that sweeps: a rectangle of aspect ratio 8 that is sheared by 30, 45
/// and 60 deg has 18, 37 and 83 % more lift slope with `paper` than with `full`.
fn straightened(models: &[&Aero]) -> Option<Warning> {
    let sweep = |model: &&Aero| match model {
        Aero::LiftingLine(line) => Some((line.mean_sweep().to_degrees(), model.preset().name())),
        Aero::Strip(_) => None,
    };
    let (most, name) = models.iter().filter_map(sweep).fold((0.0, ""), |a, b| if b.0 > a.0 { b } else { a });
    let text = format!(
        "the lifting line of preset `{name}` is straight, and this wing sweeps by {most:.0} deg in the mean: its lift is too large, by 18 % with 30 deg and by 37 % with 45 (`full` knows sweep)"
    );
    (most > SWEPT).then(|| Warning::new("aero.straight_line", text).size(most).key("aero.preset"))
}

/// The warning that the impulse of the circulation turns on one of `models` that folds and has a swept trailing edge: over the cycle the lift of
/// the shipped gaits errs by 0.39 to 0.52 of its rms with it (`trim.lattice.*.over_the_cycle`).
fn swept(models: &[&Aero]) -> Option<Warning> {
    let is_swept = |model: &&Aero| matches!(model, Aero::Strip(strips) if strips.turns_swept());
    let wrong = models.iter().any(is_swept);
    let text = "a wing that folds has a swept trailing edge: at whole strokes the lift of the shipped gaits errs over the cycle by 0.39 to 0.52 of its rms with this term, by 0.20 to 0.27 with edge_suction, which a membrane, a flap or one strip lacks";
    wrong.then(|| Warning::new("aero.turning_impulse", text.to_owned()).key("aero.full.turning_impulse"))
}

/// The warnings that a membrane of `models` has numbers that act between ribs, and no ribs.
fn ribless(models: &[&Aero]) -> Vec<Warning> {
    let loose =
        models.iter().filter_map(|model| model.membrane().filter(|skin| skin.is_ribbed() == Some(false)));
    let specs = loose.filter_map(|skin| skin.settings().membrane.as_ref());
    let said = |(key, value)| {
        let text = format!("membrane.{key} = {value} has no effect: no two ribs hold the membrane (ribs_m)");
        Warning::new("aero.unheard", text).key(format!("membrane.{key}"))
    };
    specs.flat_map(|spec| spec.of_ribs().map(said)).collect()
}

/// The warnings that `aero` changes a term and none of `models` is the strip model of preset `full`, that a membrane has no ribs, that hinges crowd its strips,
/// that a straight line
/// stands for a swept one, or, where no lattice bears them, that wings which fold have swept edges.
pub(super) fn of_strips<'a>(
    aero: &AeroSpec,
    lattice: Option<&LatticeSpec>,
    models: impl IntoIterator<Item = &'a Aero>,
) -> Vec<Warning> {
    let models: Vec<&Aero> = models.into_iter().collect();
    let presets: Vec<Preset> = models.iter().map(|model| model.preset()).collect();
    let preset = presets.first().filter(|_| !presets.contains(&Preset::Full)).map(|preset| preset.name());
    let changed = STRIP_KEYS.map(|(key, of)| Some((key, of(&aero.full)?)));
    let said = |(key, value)| {
        let text = format!("{key} = {value} has no effect: preset `{}` lacks the term", preset?);
        Some(Warning::new("aero.unheard", text).key(key))
    };
    changed
        .into_iter()
        .flatten()
        .filter_map(said)
        .chain(few(&models))
        .chain(crowded(&models))
        .chain(straightened(&models))
        .chain(ribless(&models))
        .chain(swept(&models).filter(|_| lattice.is_none()))
        .collect()
}

/// Terms of `aero` that preset `as_printed` lacks, and settings of `aero.paper` that it alone has.
const NOT_PRINTED: [&str; 3] = ["added_mass", "section_moment", "pitch_suction"];
const PRINTED: [&str; 3] = ["paper.lag_speed", "paper.lift_tilt", "paper.printed_drag"];

/// The warnings that overrides of the merged `document` give keys of its table `aero` that none of `models` hears. The terms of
/// [`STRIP_KEYS`] are told wherever they are given.
pub(super) fn in_vain<'a>(
    document: &Document,
    aero: &str,
    models: impl IntoIterator<Item = &'a Aero>,
) -> Vec<Warning> {
    let models: Vec<&Aero> = models.into_iter().collect();
    let any = |preset: Preset| models.iter().any(|model| model.preset() == preset);
    let asks = |key: &str| {
        models.iter().any(|model| model.law().about().parameters.iter().any(|asked| asked.key == key))
    };
    let why = |key: &str| -> Option<String> {
        let lacks = |heard: bool| (!heard).then(|| "no surface has its preset".to_owned());
        match key {
            _ if PRINTED.contains(&key) => lacks(any(Preset::AsPrinted)),
            _ if NOT_PRINTED.contains(&key) => lacks(any(Preset::Full) || any(Preset::Paper)),
            _ if key.starts_with("paper.") => lacks(any(Preset::Paper) || any(Preset::AsPrinted)),
            _ if key.starts_with("full.") => lacks(any(Preset::Full)),
            _ if key == CRITICAL_SUCTION.key => {
                (!asks(key)).then(|| "the law of no surface asks for it".to_owned())
            }
            _ => None,
        }
    };
    let told = |key: &str| STRIP_KEYS.iter().any(|(told, _)| *told == key);
    let said = |(key, value): (String, String)| {
        let why = why(key.strip_prefix(aero)?.strip_prefix('.')?).filter(|_| !told(&key))?;
        Some(Warning::new("aero.unheard", format!("{key} = {value} has no effect: {why}")).key(key))
    };
    if models.is_empty() {
        return Vec::new();
    }
    document.given_by_overrides().into_iter().filter_map(said).collect()
}

/// The warnings that the merged `document` of a case gives keys that change no load of the vortex lattice: overrides of sections and of the
/// aerodynamic model, and fitted `numbers` wherever they stand.
pub(super) fn by_lattice(document: &Document, numbers: bool) -> Vec<Warning> {
    const NUMBERS: &str = "numbers";
    let unheard = |key: &str| {
        let under = ["aero.", "wing.section.", "wing.sections", "numbers."];
        ["wing.cd0", "wing.cd90"].contains(&key) || under.iter().any(|table| key.starts_with(table))
    };
    let said = |key: &str, value: &str| {
        let text =
            format!("{key}{value} has no effect on loads: the lattice has no sections and no friction");
        Warning::new("aero.unheard", text).key(key)
    };
    let given = document.given_by_overrides();
    let given = given.iter().filter(|(key, _)| unheard(key));
    let mut all: Vec<Warning> = given.map(|(key, value)| said(key, &format!(" = {value}"))).collect();
    if numbers && !all.iter().any(|warning| warning.key.as_ref().is_some_and(|key| key.starts_with(NUMBERS)))
    {
        all.push(said(NUMBERS, ""));
    }
    all
}

/// The warning that the vortices of side edges push too hard where the share `past_stall` of the strips of `models` is beyond the stall
/// angle: with them the force of a plate of aspect ratio 2 is 28 % too large from 22 degrees on, without them 8 % (`aero.plates`).
pub(super) fn side_edges<'a>(
    aero: &AeroSpec,
    models: impl IntoIterator<Item = &'a Aero>,
    past_stall: Option<f64>,
) -> Option<Warning> {
    let heard = models.into_iter().any(|model| model.preset() == Preset::Full);
    let share = past_stall.filter(|share| aero.full.side_edges && heard && *share > 0.0)?;
    let text = format!(
        "aero.full.side_edges makes the lift too large past stall; on {:.1} % of the strips the angle of attack exceeds stall_angle_deg",
        100.0 * share
    );
    Some(Warning::new("aero.side_edges", text).size(share).key("aero.full.side_edges"))
}

/// The warning that `robot` has nothing that an inertance could slow.
pub(super) fn inertance(flight: &FlightSpec, robot: &Robot) -> Option<Warning> {
    let time = flight.inertance_s.filter(|time| *time > 0.0)?;
    let text = || format!("flight.inertance_s = {time} has no effect: nothing of the robot is on springs");
    robot
        .elastic_states()
        .is_empty()
        .then(|| Warning::new("flight.inertance_unheard", text()).key("flight.inertance_s"))
}

/// The warning that surfaces of `robot` under a law that separates have no profile drag: of a robot `cd0` is 0 where it is left out, while
/// a wing on a tether then has that of a laminar plate.
pub(super) fn frictionless(spec: &RobotSpec, robot: &Robot) -> Option<Warning> {
    let smooth = |aero: &Aero| aero.law().separates() && aero.cd0() == 0.0;
    let names: Vec<&str> = robot.surfaces().filter(|(_, aero)| smooth(aero)).map(|(name, _)| name).collect();
    let first = names.first()?;
    let at = spec.surfaces.iter().position(|surface| surface.name == *first);
    let key = at.map_or("robot.wing.cd0".into(), |at| format!("robot.surfaces[{at}].cd0"));
    let text = format!(
        "cd0 is 0 or left out, so there is no profile drag and power may be far too low: {} (`{key}`); a case without the key takes {}, of a laminar plate",
        names.join(", "),
        CD0.default
    );
    Some(Warning::new("aero.no_profile_drag", text).size(names.len() as f64).key(key))
}

/// The warning that `robot` has nothing that could lift it: neither a surface in air nor a thruster.
pub(super) fn unlifted(robot: &Robot) -> Option<Warning> {
    let lifts = robot.surfaces().next().is_some() || !robot.thrusters().is_empty();
    let text = "the robot has no lifting surface and no thruster: it falls";
    (!lifts && !robot.is_in_vacuum())
        .then(|| Warning::new("flight.nothing_lifts", text).key("robot.surfaces"))
}

impl ScenarioSpec {
    /// The warnings that tables which a controller alone follows stand in a flight without one.
    pub(super) fn unfollowed(&self) -> impl Iterator<Item = Warning> {
        let tables = [
            ("manoeuvre", self.manoeuvre.is_some(), "nothing flies it"),
            ("path", self.path.is_some(), "nothing flies it"),
            ("sensors", self.sensors.is_some(), "nobody is told what they read"),
        ];
        tables.into_iter().filter(|(_, given, _)| *given).map(|(table, _, why)| {
            let text = format!("[{table}] has no effect on a flight without a controller: {why}");
            Warning::new("flight.not_controlled", text).key(table)
        })
    }

    /// The warning that the predictive controller has a clearance, and no weight for it.
    pub(super) fn unweighed(&self) -> Option<Warning> {
        let spec = self.controller.as_ref()?.shipped()?;
        let (key, asked) = (format!("{}.clearance_m", self.controller_table()), spec.clearance_m);
        let text = format!(
            "{key} = {asked} has no effect: weights.clearance, which weighs what is short of it, is 0"
        );
        let vain = asked != 0.0 && spec.weights.clearance == 0.0;
        vain.then(|| Warning::new("flight.clearance_unheard", text).size(asked).key(key))
    }

    /// The warnings of what begins when the flight is over, and so is never flown.
    pub(super) fn never_begun(&self, choice: &ChosenKinds) -> impl Iterator<Item = Warning> {
        let table = |table: String| move |(key, start): (String, f64)| (format!("{table}.{key}"), start);
        let manoeuvre = choice.manoeuvre.iter().flat_map(|manoeuvre| manoeuvre.begins());
        let manoeuvre = manoeuvre.map(table(self.manoeuvre_table()));
        let controller = choice.controller.iter().flat_map(|controller| controller.begins());
        let controller = controller.map(table(self.controller_table()));
        let gusts = self.air.gusts.iter().enumerate();
        let gusts = gusts.map(|(i, gust)| (format!("air.gusts[{i}].start_s"), gust.start_s));
        let end = self.flight.duration_s;
        let all: Vec<(String, f64)> = manoeuvre.chain(controller).chain(gusts).collect();
        all.into_iter().filter(move |(_, start)| *start >= end).map(move |(key, start)| {
            let text =
                format!("{key} = {start} is not before the end of the flight ({end} s): what begins there is never flown");
            Warning::new("flight.never_begins", text).size(start).key(key)
        })
    }
}
