//! Which column of a file is which channel, and in what unit.

use wingbeat::rig::arm::MAX_JOINTS;
use wingbeat::rig::process::InputSpec;
use wingbeat::rig::unit::ChannelQuantity;
use wingbeat::simulate::Column;

use super::SampleTable;
use crate::Error;

/// A channel by its name in the record, what it measures, and names that files give it.
#[derive(Clone, Copy, Debug)]
pub struct KnownChannel {
    /// Its name in the record.
    pub name: &'static str,
    /// What it measures.
    pub quantity: Option<ChannelQuantity>,
    others: &'static [&'static str],
}

const fn known(
    name: &'static str,
    quantity: Option<ChannelQuantity>,
    others: &'static [&'static str],
) -> KnownChannel {
    KnownChannel { name, quantity, others }
}

const fn joint(name: &'static str) -> KnownChannel {
    known(name, Some(ChannelQuantity::Angle), &[])
}

impl KnownChannel {
    /// Its name and those that files give it.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        std::iter::once(self.name).chain(self.others.iter().copied())
    }
}

/// Time.
pub const TIME: KnownChannel = known("t", Some(ChannelQuantity::Time), &["time"]);
/// Forces and moments.
pub const SIX: [KnownChannel; 6] = [
    known("Fx", Some(ChannelQuantity::Force), &["force_x", "f_x"]),
    known("Fy", Some(ChannelQuantity::Force), &["force_y", "f_y"]),
    known("Fz", Some(ChannelQuantity::Force), &["force_z", "f_z"]),
    known("Tx", Some(ChannelQuantity::Moment), &["mx", "torque_x", "moment_x", "m_x"]),
    known("Ty", Some(ChannelQuantity::Moment), &["my", "torque_y", "moment_y", "m_y"]),
    known("Tz", Some(ChannelQuantity::Moment), &["mz", "torque_z", "moment_z", "m_z"]),
];
/// Channels that may be there: phase, status, joints of the longest arm.
pub const OTHERS: [KnownChannel; 9] = [
    known("phase", Some(ChannelQuantity::Angle), &["encoder", "stroke_phase"]),
    known("status", None, &[]),
    joint("q1"),
    joint("q2"),
    joint("q3"),
    joint("q4"),
    joint("q5"),
    joint("q6"),
    joint("q7"),
];
/// Numbers that count samples, the better ones first.
pub const SEQUENCES: [&str; 2] = ["rdt_sequence", "ft_sequence"];
/// What a simulation adds, beside the rates of joints.
const SIMULATED: [&str; 10] = [
    "quat_w", "quat_x", "quat_y", "quat_z", "true_fx", "true_fy", "true_fz", "true_tx", "true_ty", "true_tz",
];

/// The column that a mapping names, and its sign: `-Fz` is the column `Fz` turned about.
pub(super) fn signed(name: &str) -> (&str, f64) {
    name.strip_prefix('-').map_or((name, 1.0), |plain| (plain, -1.0))
}

/// Whether a mapping's `name` is the column called `column`: in full, or without its sign and unit.
pub(super) fn names(name: &str, column: &str) -> bool {
    name == column || signed(name).0 == column || signed(name).0 == base(column).0
}

/// Names of the columns that are of use; others are not kept.
#[derive(Clone, Debug, Default)]
pub struct WantedColumns {
    /// In lower case, without units.
    pub names: Vec<String>,
    /// As the mapping has them.
    mapped: Vec<String>,
    /// Every column, whatever its name.
    all: bool,
}

impl WantedColumns {
    /// Those that `input` names or processing knows.
    pub fn of(input: &InputSpec) -> Self {
        let known = [TIME].into_iter().chain(SIX).chain(OTHERS);
        let names = known.flat_map(|known| std::iter::once(known.name).chain(known.others.iter().copied()));
        let mut names: Vec<String> = names.chain(SEQUENCES).chain(SIMULATED).map(str::to_lowercase).collect();
        names.extend((1..=MAX_JOINTS).flat_map(|j| [format!("dq{j}"), format!("ddq{j}")]));
        Self { names, mapped: input.columns.values().cloned().collect(), all: false }
    }

    /// Every column.
    pub fn every() -> Self {
        Self { all: true, ..Self::default() }
    }

    /// True of a column that is to be kept.
    pub fn wants(&self, name: &str) -> bool {
        let plain = base(name).0.to_lowercase();
        self.all || self.mapped.iter().any(|mapped| self::names(mapped, name)) || self.names.contains(&plain)
    }
}

impl SampleTable {
    /// Names in the mapping that are no channels.
    pub(super) fn check_mapping(&self, input: &InputSpec) -> Result<(), Error> {
        let channels = || SIX.iter().chain([&TIME]).chain(&OTHERS).map(|known| known.name);
        match input.columns.keys().find(|key| !channels().any(|name| name == key.as_str())) {
            None => Ok(()),
            Some(key) => {
                let allowed: Vec<_> = channels().collect();
                Err(self.bad(format!("process.input.columns.{key}: allowed are {}", allowed.join(", "))))
            }
        }
    }

    /// The column of a channel: the one that the mapping names, or the only one with a name known for it.
    pub(super) fn find(&self, known: &KnownChannel, input: &InputSpec) -> Result<Option<usize>, Error> {
        let places = |fits: &dyn Fn(&Column) -> bool| -> Vec<usize> {
            (0..self.columns.len()).filter(|k| fits(&self.columns[*k])).collect()
        };
        if let Some(name) = input.columns.get(known.name) {
            let exactly = places(&|column| column.name == *name);
            let found = match exactly.is_empty() {
                true => places(&|column| names(name, &column.name)),
                false => exactly,
            };
            return match found.as_slice() {
                [one] => Ok(Some(*one)),
                [] => Err(self.bad(format!("no column `{name}` for {}; found {}", known.name, self.found()))),
                [..] => Err(self.bad(format!("several columns are called `{name}`: rename them"))),
            };
        }
        let names = || std::iter::once(known.name).chain(known.others.iter().copied());
        let fits = places(&|column| names().any(|name| base(&column.name).0.eq_ignore_ascii_case(name)));
        match fits.as_slice() {
            [] => Ok(None),
            [one] => Ok(Some(*one)),
            several => {
                let list: Vec<_> = several.iter().map(|k| self.columns[*k].name.as_str()).collect();
                Err(self.bad(format!(
                    "columns {} could all be {}: choose one with --set process.input.columns.{}=NAME",
                    list.join(", "),
                    known.name,
                    known.name
                )))
            }
        }
    }

    /// 1, or -1 where the mapping turns the column of a channel about.
    pub(super) fn sign(&self, known: &KnownChannel, column: usize, input: &InputSpec) -> f64 {
        let turned = |name: &String| *name != self.columns[column].name;
        input.columns.get(known.name).filter(|name| turned(name)).map_or(1.0, |name| signed(name).1)
    }

    /// Refuses a column that would be two channels.
    pub(super) fn check_used_once(&self, used: &[(&str, usize)]) -> Result<(), Error> {
        for (k, (channel, column)) in used.iter().enumerate() {
            if let Some((other, _)) = used[..k].iter().find(|(_, earlier)| earlier == column) {
                let name = &self.columns[*column].name;
                return Err(self.bad(format!(
                    "column {name} would be {other} and {channel}: each may be one, \
                     process.input.columns.{channel} and process.input.columns.{other} say which"
                )));
            }
        }
        Ok(())
    }

    pub(super) fn no_column(&self, channel: &str) -> Error {
        self.bad(format!(
            "no column for {channel}; found {}: name it with --set process.input.columns.{channel}=NAME",
            self.found()
        ))
    }

    /// The columns of the file, as many as one line bears.
    pub(super) fn found(&self) -> String {
        let names: Vec<_> = self.names.iter().map(String::as_str).take(40).collect();
        match (names.is_empty(), self.skipped.is_empty()) {
            (true, true) => "nothing".into(),
            (true, false) => format!("only what holds no numbers: {}", self.skipped.join(", ")),
            _ => names.join(", "),
        }
    }

    /// Factor from what stands in `column` to the SI unit of `known`.
    pub(super) fn to_si(
        &self,
        column: &Column,
        known: &KnownChannel,
        input: &InputSpec,
    ) -> Result<f64, Error> {
        let Some(quantity) = known.quantity else { return Ok(1.0) };
        let name = &column.name;
        let (key, given, counts) = asked(quantity, input);
        let unit = self.unit(column, quantity, given.as_deref(), key)?;
        let in_counts = unit.eq_ignore_ascii_case(COUNTS);
        match counts {
            Some((_, Some(per))) if in_counts => Ok(1.0 / per),
            Some((key, None)) if in_counts => {
                Err(self.bad(format!("column {name} is in counts: say --set process.input.{key}=N")))
            }
            Some((key, Some(_))) => Err(self.bad(format!(
                "column {name} is in {unit}: process.input.{key} is for columns in counts; leave it out, or say \
                 --set process.input.units.{}=counts",
                asked(quantity, input).0
            ))),
            _ => quantity.factor(&unit).ok_or_else(|| {
                self.bad(format!(
                    "column {name}: unit `{unit}` is not known: say --set process.input.units.{key}=UNIT, one of {}",
                    allowed(quantity)
                ))
            }),
        }
    }

    /// The unit of a column by the key, by the file and by the column's name, which may not contradict one another.
    fn unit(
        &self,
        column: &Column,
        quantity: ChannelQuantity,
        given: Option<&str>,
        key: &str,
    ) -> Result<String, Error> {
        let name = &column.name;
        let by_file = Some(column.unit.as_str()).filter(|unit| !matches!(*unit, "" | "1"));
        let key = format!("process.input.units.{key}");
        let sources =
            [(given, key.as_str()), (by_file, "the file"), (base(name).1, "the column's name")].into_iter();
        let said: Vec<(&str, &str)> = sources.filter_map(|(unit, by)| Some((unit?, by))).collect();
        let known = said.iter().filter_map(|(unit, by)| Some((meaning(quantity, unit)?, unit, by)));
        let known: Vec<_> = known.collect();
        if let Some((_, other, by)) = known.iter().find(|(factor, ..)| *factor != known[0].0) {
            let (_, unit, first) = &known[0];
            return Err(self.bad(format!("column {name}: unit {unit} by {first}, but {other} by {by}")));
        }
        let unit = said.first().map(|(unit, _)| (*unit).to_owned());
        unit.ok_or_else(|| {
            let allowed = allowed(quantity);
            self.bad(format!("column {name}: unit missing: say --set {key}=UNIT, one of {allowed}"))
        })
    }
}

/// Name of the unit of numbers that come from a converter.
const COUNTS: &str = "counts";

/// Key of the unit, the unit given, and for channels that may be in counts the key and number of counts per unit.
type UnitRequest<'a> = (&'static str, &'a Option<String>, Option<(&'static str, Option<f64>)>);

fn asked(quantity: ChannelQuantity, input: &InputSpec) -> UnitRequest<'_> {
    let units = &input.units;
    match quantity {
        ChannelQuantity::Force => {
            ("force", &units.force, Some(("counts_per_newton", input.counts_per_newton)))
        }
        ChannelQuantity::Moment => {
            ("moment", &units.moment, Some(("counts_per_newton_metre", input.counts_per_newton_metre)))
        }
        ChannelQuantity::Time => ("time", &units.time, None),
        ChannelQuantity::Angle => ("angle", &units.angle, None),
    }
}

/// SI units in `unit`, not-a-number's stand-in 0 for counts; none where it is not known.
fn meaning(quantity: ChannelQuantity, unit: &str) -> Option<f64> {
    if unit.eq_ignore_ascii_case(COUNTS) { Some(0.0) } else { quantity.factor(unit) }
}

fn allowed(quantity: ChannelQuantity) -> String {
    let counts = matches!(quantity, ChannelQuantity::Force | ChannelQuantity::Moment).then_some(COUNTS);
    quantity.names().into_iter().chain(counts).collect::<Vec<_>>().join(", ")
}

/// Name and unit of a column called `Fx [N]`, `Fx (N)` or `fx_N`.
pub fn base(name: &str) -> (&str, Option<&str>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((start, rest)) = name.split_once(open)
            && let Some((unit, "")) = rest.split_once(close)
            && !start.is_empty()
            && unit.parse::<usize>().is_err()
        {
            return (start.trim(), Some(unit.trim()));
        }
    }
    let unit = |text: &str| text == COUNTS || ChannelQuantity::ALL.iter().any(|q| q.factor(text).is_some());
    match name.rsplit_once('_') {
        Some((start, end)) if unit(end) && !start.is_empty() => (start, Some(end)),
        _ => (name, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_off_names() {
        assert_eq!(base("Fx [N]"), ("Fx", Some("N")));
        assert_eq!(base("Tx (N-mm)"), ("Tx", Some("N-mm")));
        assert_eq!(base("time_s"), ("time", Some("s")));
        assert_eq!(base("force_x"), ("force_x", None));
        assert_eq!(base("wrench[2]"), ("wrench[2]", None));
    }

    #[test]
    fn what_processing_reads_is_wanted() {
        let mut input = InputSpec::default();
        input.columns.insert("Fz".into(), "up".into());
        input.columns.insert("Fy".into(), "-side".into());
        let wanted = WantedColumns::of(&input);
        for name in [
            "up",
            "side [N]",
            "-side",
            "Fx [N]",
            "TIME",
            "ddq7",
            "quat_w",
            "true_Tz",
            "rdt_sequence",
            "q3_deg",
        ] {
            assert!(wanted.wants(name), "{name}");
        }
        for name in ["Up", "counts_Fx", "t_kernel", "wrench[0]", "ddq9", "temperature"] {
            assert!(!wanted.wants(name), "{name}");
        }
    }
}
