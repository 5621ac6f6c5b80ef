//! The plots beside the picture: what is drawn of a record, by its columns.

use wingbeat::math::DEGREES;
use wingbeat::rig::cell::CHANNELS;
use wingbeat::simulate::{Column, Record};
use wingbeat_figures::TurnsOfBody;

const MILLIMETRES: f64 = 1e3;
/// Most panels of a record that is drawn column by column.
const MOST_PANELS: usize = 40;
/// Least mean share of the weight that has a curve.
const SHARE: f64 = 0.02;

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveRole {
    /// A colour of its own.
    Own(usize),
    /// Of the left, and of the right side.
    Side(usize),
    /// The reference.
    Reference,
    /// A paler curve: of the left (0) or right (1) side, or of neither (2).
    Pale(usize),
    /// The sum of others.
    Total,
}

/// A curve of a panel.
#[derive(Clone, Debug)]
pub struct PageCurve {
    /// What it is.
    pub label: String,
    /// How it is drawn.
    pub role: CurveRole,
    /// Its values, in the unit of the panel.
    pub values: Vec<f64>,
}

impl PageCurve {
    /// Whether not all its values are the same.
    pub fn varies(&self) -> bool {
        self.values.windows(2).any(|pair| pair[0].to_bits() != pair[1].to_bits())
    }
}

/// A plot.
#[derive(Clone, Debug)]
pub struct PagePanel {
    /// What it shows.
    pub title: String,
    /// Unit of its values.
    pub unit: &'static str,
    /// Its curves.
    pub curves: Vec<PageCurve>,
    /// What its values are limited to, in the unit of the panel.
    pub limits: Option<(f64, f64)>,
}

/// Whether the plots show what the `earlier` ones do, to the bit, and what comes behind.
pub fn continue_all(panels: &[PagePanel], earlier: &[PagePanel]) -> bool {
    panels.len() == earlier.len() && panels.iter().zip(earlier).all(|(now, then)| now.continues(then))
}

impl PagePanel {
    fn continues(&self, earlier: &Self) -> bool {
        let same = |(now, then): (&PageCurve, &PageCurve)| {
            (&now.label, now.role) == (&then.label, then.role) && begins_with(&now.values, &then.values)
        };
        (&self.title, self.limits) == (&earlier.title, earlier.limits)
            && self.curves.len() == earlier.curves.len()
            && self.curves.iter().zip(&earlier.curves).all(same)
    }
}

/// Whether `values` begin with `earlier`, to the bit, both in the unit of the panel.
pub fn begins_with(values: &[f64], earlier: &[f64]) -> bool {
    let bits = |pair: (&f64, &f64)| pair.0.to_bits() == pair.1.to_bits();
    values.len() >= earlier.len() && values.iter().zip(earlier).all(bits)
}

/// What is taken of a record.
struct RecordRows<'a> {
    record: &'a Record,
    rows: &'a [usize],
}

impl RecordRows<'_> {
    fn values(&self, name: &str, factor: f64) -> Option<Vec<f64>> {
        Some(self.shown(self.record.values(name)?, factor))
    }

    /// What is shown of one value for each row of the record.
    fn shown(&self, values: &[f64], factor: f64) -> Vec<f64> {
        self.rows.iter().map(|&row| factor * values[row]).collect()
    }

    fn curve(&self, (name, label, role): (&str, &str, CurveRole), factor: f64) -> Option<PageCurve> {
        Some(PageCurve { label: label.into(), role, values: self.values(name, factor)? })
    }

    /// A panel of the columns that are there; none where none is.
    fn panel(
        &self,
        (title, unit): (&str, &'static str),
        factor: f64,
        curves: &[(&str, &str, CurveRole)],
    ) -> Option<PagePanel> {
        let curves: Vec<PageCurve> = curves.iter().filter_map(|curve| self.curve(*curve, factor)).collect();
        (!curves.is_empty()).then(|| PagePanel { title: title.into(), unit, curves, limits: None })
    }
}

use CurveRole::{Own, Pale, Reference, Side, Total};

/// The plots of a flight.
/// with the ground at a height in W that they come near, m.
pub fn flight(record: &Record, rows: &[usize], ground: Option<f64>) -> Vec<PagePanel> {
    let of = RecordRows { record, rows };
    let mut panels = Vec::new();
    let turns = TurnsOfBody::of(record).ok();
    panels.extend(attitude(&of, turns.as_ref()));
    panels.extend(turns.map(|turns| PagePanel {
        title: "heading, left +".into(),
        unit: "deg",
        curves: vec![PageCurve {
            label: "yaw".into(),
            role: Own(2),
            values: of.shown(&turns.heading, DEGREES),
        }],
        limits: None,
    }));
    panels.extend(height(&of, ground));
    let way = [("p_WB_x", "x", Own(0)), ("p_WB_y", "y, left +", Own(1))];
    panels.extend(of.panel(("position", "m"), 1.0, &way));
    panels.extend(speed(&of));
    panels.extend(weight(&of));
    panels.extend(forces(&of));
    panels.extend(joints(&of));
    panels.extend(commands(&of));
    let power = [
        ("joint_power", "all joints", Total),
        ("drive_power", "drive", Own(0)),
        ("regulator_power", "actuators", Own(1)),
        ("electrical_power", "electrical", Own(2)),
    ];
    panels.extend(of.panel(("mechanical power", "W"), 1.0, &power));
    panels.extend(clearances(&of));
    let errors = vec![
        of.curve(("orbit_roll_error", "roll, right wing down +", Own(0)), DEGREES),
        of.curve(("orbit_pitch_error", "pitch, nose up +", Own(1)), -DEGREES),
    ];
    panels.extend(together("error from the orbit", "deg", errors));
    panels.extend(of.panel(
        ("height from the orbit", "mm"),
        MILLIMETRES,
        &[("orbit_height_error", "height", Own(0))],
    ));
    let path = [("path_cross", "across, left +", Own(0)), ("path_along", "along", Own(1))];
    panels.extend(of.panel(("distance from the path", "mm"), MILLIMETRES, &path));
    let hover = ["x", "y", "z"].map(|axis| format!("hover_error_{axis}"));
    let hover: Vec<_> = hover.iter().zip(["x", "y", "z"]).enumerate().collect();
    let hover: Vec<_> = hover.iter().map(|(i, (name, axis))| (name.as_str(), *axis, Own(*i))).collect();
    panels.extend(of.panel(("distance from the place", "mm"), MILLIMETRES, &hover));
    panels
}

/// Roll and pitch with their references; the record counts pitch downward.
fn attitude(of: &RecordRows, turns: Option<&TurnsOfBody>) -> Option<PagePanel> {
    let roll = turns.map(|turns| PageCurve {
        label: "roll, right wing down +".into(),
        role: Own(0),
        values: of.shown(&turns.roll, DEGREES),
    });
    let curves = vec![
        roll,
        of.curve(("pitch", "pitch, nose up +", Own(1)), -DEGREES),
        of.curve(("roll_reference", "reference of roll", Reference), DEGREES),
        of.curve(("pitch_reference", "reference of pitch", Reference), -DEGREES),
    ];
    together("roll and pitch", "deg", curves)
}

/// A panel of the curves that are there; none where none is.
fn together(title: &str, unit: &'static str, curves: Vec<Option<PageCurve>>) -> Option<PagePanel> {
    let curves: Vec<PageCurve> = curves.into_iter().flatten().collect();
    (!curves.is_empty()).then(|| PagePanel { title: title.into(), unit, curves, limits: None })
}

/// Height, with the ground where that is no farther away than the heights are apart, or a metre.
fn height(of: &RecordRows, ground: Option<f64>) -> Option<PagePanel> {
    let mut panel = of.panel(("height", "m"), 1.0, &[("p_WB_z", "z", Own(0))])?;
    let values = &panel.curves[0].values;
    let [low, high] =
        [f64::min, f64::max].map(|least: fn(f64, f64) -> f64| values.iter().copied().reduce(least));
    let (low, high) = (low?, high?);
    if let Some(ground) = ground.filter(|z| (low - z).max(z - high) <= (high - low).max(1.0)) {
        let line = vec![ground; values.len()];
        panel.curves.push(PageCurve { label: "ground".into(), role: Reference, values: line });
    }
    Some(panel)
}

/// Speed over the ground and climb.
fn speed(of: &RecordRows) -> Option<PagePanel> {
    let [x, y, z] = ["x", "y", "z"].map(|axis| of.values(&format!("v_WB_W_{axis}"), 1.0));
    let (x, y, z) = (x?, y?, z?);
    let over = x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).collect();
    let curve = |label: &str, role, values| PageCurve { label: label.into(), role, values };
    let curves = vec![curve("over the ground", Own(0), over), curve("climb", Own(1), z)];
    Some(PagePanel { title: "speed".into(), unit: "m/s", curves, limits: None })
}

/// The upward force of the air by part.
fn weight(of: &RecordRows) -> Option<PagePanel> {
    let names = of.record.columns().iter().filter_map(|column| column.name.strip_prefix("weight_"));
    let parts: Vec<(String, Vec<f64>)> = names
        .filter_map(|name| Some((name.replace('_', " "), of.values(&format!("weight_{name}"), 1.0)?)))
        .collect();
    let rows = parts.first()?.1.len();
    let total = (0..rows).map(|row| parts.iter().map(|(_, values)| values[row]).sum()).collect();
    let mean = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>() / rows.max(1) as f64;
    let parts = parts.into_iter().filter(|(_, values)| mean(values) > SHARE).enumerate();
    let mut curves: Vec<PageCurve> =
        parts.map(|(i, (label, values))| PageCurve { label, role: Own(i), values }).collect();
    curves.push(PageCurve { label: "all".into(), role: Total, values: total });
    Some(PagePanel { title: "upward force over the weight".into(), unit: "", curves, limits: None })
}

/// Forces by source, those of thrusters among them, along the body and to its top.
fn forces(of: &RecordRows) -> Vec<PagePanel> {
    let names = of.record.columns().iter().map(|column| column.name.as_str());
    let names: Vec<&str> = names.filter_map(|name| name.strip_prefix("force_")?.strip_suffix("_x")).collect();
    let panel = |(axis, title): (&str, &str)| {
        let curve = |(i, name): (usize, &&str)| {
            let label = name.replace('_', " ");
            of.curve((&format!("force_{name}_{axis}"), &label, Own(i)), 1.0)
        };
        let mut curves: Vec<PageCurve> = names.iter().enumerate().filter_map(curve).collect();
        curves.extend(of.curve((&format!("thrust_{axis}"), "thrusters", Own(names.len())), 1.0));
        (!curves.is_empty()).then(|| PagePanel { title: title.into(), unit: "N", curves, limits: None })
    };
    [("x", "force along the body, forward +"), ("z", "force to its top")]
        .into_iter()
        .filter_map(panel)
        .collect()
}

/// The name without its side, and the side.
fn pair(name: &str) -> (&str, Option<usize>) {
    let side = [("left", 0), ("right", 1)];
    let found = side.iter().find_map(|(side, k)| Some((name.strip_suffix(side)?.trim_end_matches('_'), *k)));
    found.filter(|(group, _)| !group.is_empty()).map_or((name, None), |(group, side)| (group, Some(side)))
}

/// What `unit` is drawn in, and the factor.
fn drawn(unit: &str) -> (&'static str, f64) {
    match unit {
        "rad" => ("deg", DEGREES),
        "rad/s" => ("deg/s", DEGREES),
        "rad/s2" => ("deg/s2", DEGREES),
        "m" => ("mm", MILLIMETRES),
        "N" => ("N", 1.0),
        "N m" => ("N m", 1.0),
        "W" => ("W", 1.0),
        "m/s" => ("m/s", 1.0),
        "s" => ("s", 1.0),
        "Hz" => ("Hz", 1.0),
        "m2/s" => ("m2/s", 1.0),
        _ => ("", 1.0),
    }
}

/// Adds the curves of a column to the panel of its pair.
fn add(panels: &mut Vec<PagePanel>, of: &RecordRows, column: &Column, name: &str, what: &str) {
    let (group, side) = pair(name);
    let (unit, factor) = drawn(&column.unit);
    let title = format!("{}{what}", group.replace('_', " "));
    let limits = (column.low.is_finite() && column.high.is_finite())
        .then_some((factor * column.low, factor * column.high));
    let place = panels.iter().position(|panel| panel.title == title).unwrap_or_else(|| {
        panels.push(PagePanel { title, unit, curves: Vec::new(), limits });
        panels.len() - 1
    });
    let (label, role) = match side {
        Some(side) => (["left", "right"][side], Side(side)),
        None if what == ", command" => ("command", Own(0)),
        None => ("", Own(0)),
    };
    let follows = ["displacement", "rate"].map(|what| format!("{what}_{name}"));
    let response = of
        .record
        .columns()
        .iter()
        .find(|other| what == ", command" && follows.contains(&other.name) && other.unit == column.unit);
    if let Some(response) = response {
        let label = if side.is_some() { format!("{label} response") } else { "response".into() };
        panels[place].curves.extend(of.curve((&response.name, &label, Pale(side.unwrap_or(2))), factor));
    }
    panels[place].curves.extend(of.curve((&column.name, label, role), factor));
}

/// The joints: what has a torque.
fn joints(of: &RecordRows) -> Vec<PagePanel> {
    let mut panels = Vec::new();
    let columns = of.record.columns();
    for column in columns.iter().filter(|c| of.record.column(&format!("torque_{}", c.name)).is_some()) {
        add(&mut panels, of, column, &column.name, ", joint");
    }
    panels
}

/// The commands with their limits, and what follows them.
fn commands(of: &RecordRows) -> Vec<PagePanel> {
    let mut panels = Vec::new();
    for column in of.record.columns() {
        if let Some(name) = column.name.strip_prefix("command_") {
            add(&mut panels, of, column, name, ", command");
        }
    }
    panels
}

/// Least distances of parts, which may not fall below zero.
fn clearances(of: &RecordRows) -> Option<PagePanel> {
    let names = of.record.columns().iter().map(|column| column.name.as_str());
    let names = names.filter(|name| name.starts_with("clearance_"));
    let curve = |(i, name): (usize, &str)| {
        let label = name.trim_start_matches("clearance_").replace('_', " ");
        of.curve((name, &label, Own(i)), MILLIMETRES)
    };
    let curves: Vec<PageCurve> = names.enumerate().filter_map(curve).collect();
    (!curves.is_empty()).then(|| PagePanel { title: "clearance".into(), unit: "mm", curves, limits: None })
}

/// The plots of the loads of a case.
pub fn loads(record: &Record, rows: &[usize]) -> Vec<PagePanel> {
    let of = RecordRows { record, rows };
    let wind = [
        ("force_wind_lift", "lift", Own(0)),
        ("force_wind_drag", "drag", Own(1)),
        ("force_wind_side", "to the side", Own(2)),
    ];
    let mut panels: Vec<PagePanel> = of.panel(("loads in the wind", "N"), 1.0, &wind).into_iter().collect();
    let coefficients = [("CL", "CL", Own(0)), ("CD", "CD", Own(1)), ("CM", "CM", Own(2))];
    panels.extend(of.panel(("coefficients", ""), 1.0, &coefficients));
    let moments = [("moment_x", "x", Own(0)), ("moment_y", "y", Own(1)), ("moment_z", "z", Own(2))];
    panels.extend(of.panel(("moment about the body's axes", "N m"), 1.0, &moments));
    panels.extend(forces(&of));
    panels.extend(of.panel(("power given to the air", "W"), 1.0, &[("power", "power", Own(0))]));
    let tip = [("tip_up", "up", Own(0)), ("tip_ahead", "ahead", Own(1))];
    panels.extend(of.panel(("tip of the spar, displacement", "mm"), MILLIMETRES, &tip));
    panels.extend(of.panel(
        ("tip of the spar, nose up", "deg"),
        DEGREES,
        &[("tip_nose_up", "nose up", Own(0))],
    ));
    for column in record.columns() {
        for (prefix, what, unit, factor) in
            [("hinge_", ", angle", "deg", DEGREES), ("torque_", ", torque", "N m", 1.0)]
        {
            if let Some(name) = column.name.strip_prefix(prefix) {
                let (group, side) = pair(name);
                let title = format!("{}{what}", group.replace('_', " "));
                let role = side.map_or(Own(0), Side);
                let Some(curve) = of.curve((&column.name, name, role), factor) else { continue };
                match panels.iter_mut().find(|panel| panel.title == title) {
                    Some(panel) => panel.curves.push(curve),
                    None => panels.push(PagePanel { title, unit, curves: vec![curve], limits: None }),
                }
            }
        }
    }
    panels
}

/// Of each channel of a comparison (columns over `phase`, cycles) the measured mean with the range of its cycles, and the computed curve as
/// it is and fitted, at the times `times` (s) of a run with that frequency.
pub fn compared(comparison: &Record, times: &[f64], frequency_hz: f64) -> Vec<PagePanel> {
    let rows = comparison.rows() as f64;
    let phases = times.iter().map(|t| (t * frequency_hz).rem_euclid(1.0));
    // The phases of a comparison are even, the first is 0: the nearest row is within half of one.
    let nearest: Vec<usize> =
        phases.map(|phase| (phase * rows).round() as usize % (rows as usize).max(1)).collect();
    let of = RecordRows { record: comparison, rows: &nearest };
    let kinds = [
        ("measured", Total),
        ("low", Reference),
        ("high", Reference),
        ("computed", Pale(2)),
        ("fitted", Own(0)),
    ];
    let channels =
        comparison.columns().iter().filter_map(|c| Some((c.name.strip_prefix("computed_")?, &c.unit)));
    let panel = |(channel, unit): (&str, &String)| {
        // A file with commas has no units: loads are told by the start of their names.
        let known = [("force", "N"), ("moment", "N m"), ("torque", "N m"), ("power", "W")];
        let known = known.iter().find(|(start, _)| unit.is_empty() && channel.starts_with(start));
        let (unit, factor) = drawn(known.map_or(unit.as_str(), |(_, unit)| unit));
        let curve = |(kind, role)| of.curve((format!("{kind}_{channel}").as_str(), kind, role), factor);
        let title = format!("{}, measured and computed", channel.replace('_', " "));
        PagePanel { title, unit, curves: kinds.into_iter().filter_map(curve).collect(), limits: None }
    };
    if rows > 0.0 { channels.map(panel).collect() } else { Vec::new() }
}

/// Every column of a record in a panel of its own, the three of an axis or the six of a cell together.
pub fn every(record: &Record, rows: &[usize], but: &str) -> Vec<PagePanel> {
    let of = RecordRows { record, rows };
    let mut panels: Vec<PagePanel> = Vec::new();
    for column in record.columns().iter().filter(|column| column.name != but) {
        let (unit, factor) = drawn(&column.unit);
        let (group, label) = grouped(&column.name);
        let found = panels.iter().position(|panel| panel.title == group && panel.unit == unit);
        let number = found.map_or(0, |place| panels[place].curves.len());
        let Some(curve) = of.curve((&column.name, label, Own(number)), factor) else { continue };
        match found {
            Some(place) => panels[place].curves.push(curve),
            None if panels.len() < MOST_PANELS => {
                panels.push(PagePanel { title: group, unit, curves: vec![curve], limits: None });
            }
            None => {}
        }
    }
    panels
}

/// Of a joint of an arm what is told of it, and its name.
fn joint(name: &str) -> Option<(&'static str, &str)> {
    let kinds = [
        ("ddq", "accelerations of the joints"),
        ("dq", "rates of the joints"),
        ("q", "angles of the joints"),
    ];
    let number = |prefix: &str| name.strip_prefix(prefix).is_some_and(|rest| rest.parse::<u8>().is_ok());
    kinds.into_iter().find(|(prefix, _)| number(prefix)).map(|(_, kind)| (kind, name.trim_start_matches('d')))
}

/// The group of a column and its place in it.
fn grouped(name: &str) -> (String, &str) {
    // Keys of documents stay as they are written.
    if name.contains('.') {
        return (name.into(), "");
    }
    if let Some((kind, joint)) = joint(name) {
        return (kind.into(), joint);
    }
    if let Some((channel, _)) = CHANNELS.iter().find(|(channel, _)| name.ends_with(channel)) {
        let kind = name.trim_end_matches(channel).trim_end_matches('_');
        return (format!("{} {kind}", if channel.starts_with('F') { "force" } else { "moment" }), channel);
    }
    match name.rsplit_once('_') {
        Some((group, axis)) if axis.len() == 1 && !group.is_empty() => (group.replace('_', " "), axis),
        _ => (name.replace('_', " "), ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_of_thrusters_are_drawn_beside_those_of_the_air() {
        let column = |name: &str, value: f64| Column { values: vec![value], ..Column::new(name, "N", "B") };
        let names = ["force_gravity_x", "force_gravity_z", "thrust_x", "thrust_z"];
        let columns =
            names.iter().zip([-0.1, -0.5, 0.2, 0.7]).map(|(name, value)| column(name, value)).collect();
        let record = Record::new(columns, 1).unwrap();
        let panels = forces(&RecordRows { record: &record, rows: &[0] });
        let told = |k: usize| -> Vec<(&str, f64)> {
            panels[k].curves.iter().map(|curve| (curve.label.as_str(), curve.values[0])).collect()
        };
        assert_eq!(told(0), [("gravity", -0.1), ("thrusters", 0.2)]);
        assert_eq!(told(1), [("gravity", -0.5), ("thrusters", 0.7)]);
    }

    #[test]
    fn a_comparison_is_shown_at_the_phases_of_the_times() {
        let column =
            |name: &str, values: [f64; 4]| Column { values: values.into(), ..Column::new(name, "", "") };
        let columns = vec![
            column("phase", [0.0, 0.25, 0.5, 0.75]),
            column("measured_force_z", [0.0, 1.0, 2.0, 3.0]),
            column("computed_force_z", [0.0, 2.0, 4.0, 6.0]),
        ];
        let record = Record::new(columns, 4).unwrap();
        // At 2 Hz: half a cycle, three quarters in the second cycle, and the end of the third, which is the start.
        let panels = compared(&record, &[0.25, 0.875, 1.499], 2.0);
        assert_eq!((panels.len(), panels[0].unit), (1, "N"));
        let curves: Vec<(&str, &[f64])> =
            panels[0].curves.iter().map(|curve| (curve.label.as_str(), &curve.values[..])).collect();
        assert_eq!(curves, [("measured", &[2.0, 3.0, 0.0][..]), ("computed", &[4.0, 6.0, 0.0][..])]);
    }
}
