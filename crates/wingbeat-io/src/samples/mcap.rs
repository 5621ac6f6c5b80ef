//! Recordings of ROS 2 in MCAP: wrenches and joints, each message in CDR (<https://mcap.dev/spec>, version 0; OMG's DDS-XTypes 1.3, 7.4).

use std::collections::BTreeMap;
use std::io::{BufReader, Read};
use wingbeat::math::order::ascend_by;

use flate2::Crc;
use wingbeat::rig::cell::CHANNELS;

use super::opened;
use super::table::{ArrayShape, SampleTable};
use crate::{Error, MOST_COLUMNS, MOST_NUMBERS};

/// First bytes of a file, and its last.
pub const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Longest record that is read, bytes: writers close a chunk after some MB.
const LONGEST: u64 = 256 << 20;
/// Names that one sentence lists at most.
const LISTED: usize = 12;

/// What of a topic is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TopicKind {
    Wrench,
    Joints,
    /// Of which the accelerations alone are read.
    Point,
}

impl TopicKind {
    /// By the name of the schema.
    fn of(schema: &str) -> Option<Self> {
        match schema.replace("/msg/", "/").as_str() {
            "geometry_msgs/WrenchStamped" => Some(Self::Wrench),
            "sensor_msgs/JointState" => Some(Self::Joints),
            "trajectory_msgs/JointTrajectoryPoint" => Some(Self::Point),
            _ => None,
        }
    }
}

/// The messages of a topic, column by column.
#[derive(Debug)]
struct Topic {
    name: String,
    kind: TopicKind,
    /// Times of its messages, ns: those of their heads, or those at which they were recorded where the heads have none.
    stamped: Vec<i64>,
    logged: Vec<i64>,
    /// Names with units, in the order of the first message.
    names: Vec<(String, &'static str)>,
    columns: Vec<Vec<f64>>,
}

/// What is known of a file on the way.
#[derive(Debug, Default)]
struct Recording {
    schemas: BTreeMap<u16, String>,
    topics: BTreeMap<u16, Topic>,
    /// Other topics, with their types.
    others: Vec<String>,
    numbers: usize,
    /// Time of the run at the first wrench, s: wingbeat's own recordings say it.
    begin_s: Option<f64>,
}

/// Reads the wrenches and joints of a recording.
pub fn read(mut table: SampleTable) -> Result<SampleTable, Error> {
    let (file, length) = opened(&table.path)?;
    let mut file = BufReader::new(file);
    let mut recording = Recording::default();
    let whole = whole(&mut file, length, &mut recording).map_err(|what| table.bad(what))?;
    if !whole {
        return Err(table.bad("cut short: no end of the data; `mcap recover` keeps what is whole"));
    }
    recording.into_table(&mut table)?;
    Ok(table)
}

/// Reads records until the end of the data; answers whether that came.
fn whole(file: &mut impl Read, length: u64, recording: &mut Recording) -> Result<bool, String> {
    let mut magic = [0; 8];
    let mut left = length.saturating_sub(8);
    if file.read_exact(&mut magic).is_err() || magic != MAGIC {
        return Err("no MCAP file: other first bytes".into());
    }
    let mut head = [0; 9];
    loop {
        if left < 9 || file.read_exact(&mut head).is_err() {
            return Ok(false);
        }
        let size = u64::from_le_bytes(std::array::from_fn(|i| head[1 + i]));
        left -= 9;
        if size > left {
            return Ok(false);
        }
        if size > LONGEST {
            return Err(format!("a record of {size} bytes; read are at most {LONGEST}"));
        }
        left -= size;
        let mut content = vec![0; size as usize];
        file.read_exact(&mut content).map_err(|error| error.to_string())?;
        match head[0] {
            DATA_END | FOOTER => return Ok(true),
            CHUNK => recording.chunk(&content)?,
            code => recording.record(code, &content)?,
        }
    }
}

const FOOTER: u8 = 2;
const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const METADATA: u8 = 12;
const DATA_END: u8 = 15;

/// Bytes that are taken from the front.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (front, rest) = self.0.split_at_checked(count).ok_or("damaged: a record ends too soon")?;
        self.0 = rest;
        Ok(front)
    }

    fn number(&mut self, size: usize) -> Result<u64, String> {
        Ok(self.take(size)?.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    fn text(&mut self) -> Result<String, String> {
        let size = self.number(4)? as usize;
        String::from_utf8(self.take(size)?.to_vec()).map_err(|_| "damaged: a text that is none".into())
    }
}

impl Recording {
    /// A chunk: what it holds are records again.
    fn chunk(&mut self, content: &[u8]) -> Result<(), String> {
        let mut bytes = Bytes(content);
        bytes.take(16)?;
        let (size, crc, compression) = (bytes.number(8)?, bytes.number(4)?, bytes.text()?);
        if !compression.is_empty() {
            return Err(format!(
                "chunks compressed by {compression}: allowed are such without compression, which \
                 `mcap decompress IN.mcap -o OUT.mcap` writes"
            ));
        }
        let stored = bytes.number(8)?;
        if stored != size || stored != bytes.0.len() as u64 {
            return Err("damaged: a chunk of another size than it says".into());
        }
        let mut sum = Crc::new();
        sum.update(bytes.0);
        if crc != 0 && u64::from(sum.sum()) != crc {
            return Err("damaged: the check sum of a chunk is another one".into());
        }
        while !bytes.0.is_empty() {
            let (code, size) = (bytes.number(1)? as u8, bytes.number(8)?);
            let size = usize::try_from(size).map_err(|_| "damaged: a record ends too soon")?;
            self.record(code, bytes.take(size)?)?;
        }
        Ok(())
    }

    fn record(&mut self, code: u8, content: &[u8]) -> Result<(), String> {
        let mut bytes = Bytes(content);
        match code {
            SCHEMA => {
                let (id, name) = (bytes.number(2)? as u16, bytes.text()?);
                self.schemas.insert(id, name);
            }
            CHANNEL => self.channel(&mut bytes)?,
            MESSAGE => {
                let id = bytes.number(2)? as u16;
                bytes.take(4)?;
                let logged = bytes.number(8)? as i64;
                bytes.take(8)?;
                if let Some(topic) = self.topics.get_mut(&id) {
                    self.numbers += topic.add(logged, bytes.0)?;
                    if self.numbers > 4 * MOST_NUMBERS {
                        return Err(format!(
                            "more than {} numbers, the most that are read",
                            4 * MOST_NUMBERS
                        ));
                    }
                }
            }
            METADATA if bytes.text()? == "wingbeat" => {
                let mut pairs = Bytes(bytes.0);
                let size = pairs.number(4)? as usize;
                let mut pairs = Bytes(pairs.take(size)?);
                while !pairs.0.is_empty() {
                    let (key, value) = (pairs.text()?, pairs.text()?);
                    if key == "begin_s" {
                        self.begin_s = value.parse().ok().filter(|begin: &f64| begin.is_finite());
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn channel(&mut self, bytes: &mut Bytes) -> Result<(), String> {
        let (id, schema) = (bytes.number(2)? as u16, bytes.number(2)? as u16);
        let (name, encoding) = (bytes.text()?, bytes.text()?);
        let schema = self.schemas.get(&schema).map_or("no schema", String::as_str);
        if self.topics.contains_key(&id) {
            return Ok(());
        }
        if self.topics.len() + self.others.len() >= MOST_COLUMNS {
            return Err(format!("more than {MOST_COLUMNS} topics, the most that are read"));
        }
        match TopicKind::of(schema) {
            Some(_) if encoding != "cdr" => {
                return Err(format!("topic {name}: messages in {encoding}; allowed is cdr, as ROS 2 writes"));
            }
            Some(kind) => {
                let (names, columns) = match kind {
                    TopicKind::Wrench => {
                        let names = CHANNELS.map(|(name, unit)| (name.to_owned(), unit));
                        (names.to_vec(), vec![Vec::new(); CHANNELS.len()])
                    }
                    TopicKind::Joints | TopicKind::Point => (Vec::new(), Vec::new()),
                };
                let (stamped, logged) = (Vec::new(), Vec::new());
                self.topics.insert(id, Topic { name, kind, stamped, logged, names, columns });
            }
            None => {
                let other = format!("{name} ({schema})");
                if !self.others.contains(&other) {
                    self.others.push(other);
                }
            }
        }
        Ok(())
    }

    /// The columns of all topics at the times of the wrench, where all topics that are wanted have messages.
    fn into_table(self, table: &mut SampleTable) -> Result<(), Error> {
        let found: Vec<&str> =
            self.topics.values().map(|topic| &topic.name).chain(&self.others).map(String::as_str).collect();
        let nothing = table.bad(format!(
            "no messages of the type geometry_msgs/msg/WrenchStamped; found {}",
            if found.is_empty() { "nothing".into() } else { listed(&found, 40) }
        ));
        let mut topics: Vec<Topic> =
            self.topics.into_values().filter(|topic| !topic.logged.is_empty()).collect();
        // Wrenches come first: where a joint has the name of a force, the force keeps it.
        ascend_by(&mut topics, |topic| if topic.kind == TopicKind::Wrench { 0.0 } else { 1.0 });
        let named = names_of(&topics);
        let wanted = |k: &usize| named[*k].iter().any(|name| table.wanted.wants(name));
        let wrenches = || (0..topics.len()).take_while(|k| topics[*k].kind == TopicKind::Wrench);
        let plain = wrenches().find(|k| named[*k][0] == CHANNELS[0].0);
        let main = plain.or_else(|| wrenches().find(wanted)).or_else(|| wrenches().next()).ok_or(nothing)?;
        if let Some(topic) =
            topics.iter().find(|topic| topic.times().windows(2).any(|pair| pair[0] > pair[1]))
        {
            let what = "messages that are not in the order of their times; `mcap sort` orders them";
            return Err(table.bad(format!("topic {}: {what}", topic.name)));
        }
        let used: Vec<&Topic> =
            (0..topics.len()).filter(|k| *k == main || wanted(k)).map(|k| &topics[k]).collect();
        let main = &topics[main];
        let (begin, first) = (self.begin_s.unwrap_or(0.0), main.times()[0]);
        let seconds = |time: i64| begin + time.saturating_sub(first) as f64 * 1e-9;
        let (times, left_out) = common(main, &used, seconds).map_err(|what| table.bad(what))?;
        table.cautions.extend(left_out);
        let shape = ArrayShape { rows: times.len(), columns: 1 };
        table.add("t", "s", shape, times.iter().map(|time| seconds(*time)))?;
        let mut skipped = Vec::new();
        for (topic, names) in topics.iter().zip(&named) {
            let own = topic.times();
            for ((name, (_, unit)), column) in names.iter().zip(&topic.names).zip(&topic.columns) {
                if table.names.contains(name) {
                    skipped.push(format!("{name} of {}", topic.name));
                    continue;
                }
                table.add(name, unit, shape, sampled(own, column, times))?;
            }
        }
        if !skipped.is_empty() {
            let list = listed(&skipped, LISTED);
            table.cautions.push(format!("columns that other columns have the names of are left out: {list}"));
        }
        table.skipped.extend(skipped.into_iter().chain(self.others));
        Ok(())
    }
}

/// The first `most` of `words`.
fn listed<T: AsRef<str>>(words: &[T], most: usize) -> String {
    let first: Vec<&str> = words.iter().take(most).map(AsRef::as_ref).collect();
    let rest = if words.len() > most { format!(" and {} more", words.len() - most) } else { String::new() };
    first.join(", ") + &rest
}

/// The names of the columns of each topic. Of several wrenches that of a `cell` keeps its names; the others have the last part of
/// their topic before them, or the whole topic where several have the same last part.
fn names_of(topics: &[Topic]) -> Vec<Vec<String>> {
    let wrenches: Vec<&str> =
        topics.iter().filter(|topic| topic.kind == TopicKind::Wrench).map(Topic::last).collect();
    let before = |topic: &Topic| match topic.last() {
        _ if topic.kind != TopicKind::Wrench || wrenches.len() == 1 => String::new(),
        last if wrenches.iter().filter(|other| **other == last).count() > 1 => format!("{}_", topic.name),
        "cell" => String::new(),
        last => format!("{last}_"),
    };
    let names = |topic: &Topic| {
        let before = before(topic);
        topic.names.iter().map(|(name, _)| format!("{before}{name}")).collect()
    };
    topics.iter().map(names).collect()
}

/// The times of `main` that the messages of all `topics` enclose, and what is left out in words; `seconds` gives the time of the run.
fn common<'a>(
    main: &'a Topic,
    topics: &[&Topic],
    seconds: impl Fn(i64) -> f64,
) -> Result<(&'a [i64], Option<String>), String> {
    let ends = |topic: &&&Topic| (topic.times()[0], topic.times()[topic.logged.len() - 1]);
    let late = topics.iter().max_by_key(|topic| ends(topic).0).map_or(main, |topic| topic);
    let early = topics.iter().min_by_key(|topic| ends(topic).1).map_or(main, |topic| topic);
    let (start, end) = (ends(&&late).0, ends(&&early).1);
    let times = main.times();
    let from = times.partition_point(|time| *time < start);
    let to = times.partition_point(|time| *time <= end);
    let [begins, ends] = [start, end].map(seconds);
    if from >= to {
        let main = &main.name;
        return Err(format!(
            "no sample of {main} lies where all topics have messages: {} begins at {begins:.3} s, {} ends at {ends:.3} s",
            late.name, early.name
        ));
    }
    let mut why = Vec::new();
    if from > 0 {
        why.push(format!("{} begins at {begins:.3} s", late.name));
    }
    if to < times.len() {
        why.push(format!("{} ends at {ends:.3} s", early.name));
    }
    let left_out = (!why.is_empty()).then(|| {
        format!("{} of {} samples of {} are used: {}", to - from, times.len(), main.name, why.join(", "))
    });
    Ok((&times[from..to], left_out))
}

impl Topic {
    /// The last part of its name.
    fn last(&self) -> &str {
        self.name.rsplit('/').next().unwrap_or_default()
    }

    /// The times by which its messages are ordered: of the heads where they go ahead.
    fn times(&self) -> &[i64] {
        let ahead = self.stamped.windows(2).all(|pair| pair[0] < pair[1]);
        let told = self.stamped.len() > 1 || self.stamped.first() != Some(&0);
        if ahead && told { &self.stamped } else { &self.logged }
    }

    /// Adds a message; answers how many numbers of it are kept.
    fn add(&mut self, logged: i64, bytes: &[u8]) -> Result<usize, String> {
        let named = |what: String| format!("topic {}: {what}", self.name);
        let mut cdr = Cdr::new(bytes).map_err(named)?;
        let (stamp, numbers) = match self.kind {
            TopicKind::Wrench => cdr.wrench().map_err(named)?,
            TopicKind::Joints | TopicKind::Point => {
                let (stamp, names, numbers) =
                    if self.kind == TopicKind::Joints { cdr.joints() } else { cdr.point(logged) }
                        .map_err(named)?;
                if self.names.is_empty() {
                    // A message without numbers says nothing; what is wanted begins with the first that has some.
                    if names.is_empty() {
                        return Ok(0);
                    }
                    self.columns = vec![Vec::new(); names.len()];
                    self.names = names;
                } else if names.len() != self.names.len()
                    || names.iter().zip(&self.names).any(|(new, old)| new.0 != old.0)
                {
                    let list = |names: &[(String, &str)]| {
                        let names: Vec<&str> = names.iter().map(|(name, _)| name.as_str()).collect();
                        listed(&names, LISTED)
                    };
                    return Err(named(format!(
                        "joints {} after {}; allowed are the same in every message",
                        list(&names),
                        list(&self.names)
                    )));
                }
                (stamp, numbers)
            }
        };
        self.stamped.push(stamp);
        self.logged.push(logged);
        self.columns.iter_mut().zip(&numbers).for_each(|(column, number)| column.push(*number));
        Ok(numbers.len() + 2)
    }
}

/// A column at other times: its own numbers where the times are the same, else straight lines between them; before and behind, none.
fn sampled<'a>(own: &'a [i64], column: &'a [f64], times: &'a [i64]) -> impl Iterator<Item = f64> + 'a {
    times.iter().map(move |time| {
        let next = own.partition_point(|own| own < time);
        match (next.checked_sub(1), own.get(next)) {
            (_, Some(own)) if own == time => column[next],
            (Some(before), Some(_)) => {
                let [part, whole] = [*time, own[next]].map(|time| time.saturating_sub(own[before]) as f64);
                let share = part / whole;
                column[before] + share * (column[next] - column[before])
            }
            _ => f64::NAN,
        }
    })
}

/// A message in CDR, whose numbers lie at multiples of their size from the end of its head.
struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    big: bool,
}

/// Stamp, names with units, and numbers.
type StampedNumbers = (i64, Vec<(String, &'static str)>, Vec<f64>);

impl<'a> Cdr<'a> {
    fn new(message: &'a [u8]) -> Result<Self, String> {
        match message {
            [0, order @ (0 | 1), _, _, bytes @ ..] => Ok(Self { bytes, at: 0, big: *order == 0 }),
            [a, b, ..] => Err(format!("a message in the encoding {a:02x} {b:02x}; allowed is plain CDR")),
            _ => Err("a message without its head".into()),
        }
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.at = self.at.next_multiple_of(N);
        let bytes = self.bytes.get(self.at..self.at + N).ok_or("a message that ends too soon")?;
        self.at += N;
        let mut number: [u8; N] = std::array::from_fn(|i| bytes[i]);
        if self.big {
            number.reverse();
        }
        Ok(number)
    }

    fn int(&mut self) -> Result<u32, String> {
        self.number().map(u32::from_le_bytes)
    }

    fn double(&mut self) -> Result<f64, String> {
        self.number().map(f64::from_le_bytes)
    }

    /// The length of a list whose members have at least `size` bytes each.
    fn length(&mut self, size: usize) -> Result<usize, String> {
        let length = self.int()? as usize;
        let there = self.bytes.len().saturating_sub(self.at) / size;
        if length <= there { Ok(length) } else { Err("a message that ends too soon".into()) }
    }

    /// The same of a list that makes columns.
    fn few(&mut self, size: usize) -> Result<usize, String> {
        let length = self.length(size)?;
        let told = format!("a list of {length}; read are at most {MOST_COLUMNS}");
        if length <= MOST_COLUMNS { Ok(length) } else { Err(told) }
    }

    fn text(&mut self) -> Result<String, String> {
        let length = self.length(1)?;
        let bytes = &self.bytes[self.at..self.at + length];
        self.at += length;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        String::from_utf8(text.to_vec()).map_err(|_| "a text that is none".into())
    }

    fn doubles(&mut self) -> Result<Vec<f64>, String> {
        let length = self.few(8)?;
        (0..length).map(|_| self.double()).collect()
    }

    /// The time, ns, of a head.
    fn header(&mut self) -> Result<i64, String> {
        let (seconds, nanoseconds) = (self.int()? as i32, self.int()?);
        self.text()?;
        Ok(i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds))
    }

    fn wrench(&mut self) -> Result<(i64, Vec<f64>), String> {
        let stamp = self.header()?;
        Ok((stamp, (0..CHANNELS.len()).map(|_| self.double()).collect::<Result<_, _>>()?))
    }

    /// Positions by the names of the joints, and where they are told velocities (`d` before the name) and efforts (`torque_`).
    fn joints(&mut self) -> Result<StampedNumbers, String> {
        let stamp = self.header()?;
        let count = self.few(5)?;
        let joints = (0..count).map(|_| self.text()).collect::<Result<Vec<_>, _>>()?;
        let lists = [self.doubles()?, self.doubles()?, self.doubles()?];
        let (mut names, mut numbers) = (Vec::new(), Vec::new());
        for ((prefix, unit), list) in [("", "rad"), ("d", "rad/s"), ("torque_", "")].iter().zip(lists) {
            if list.is_empty() {
                continue;
            }
            if list.len() != joints.len() {
                return Err(format!("{} names of joints for {} numbers", joints.len(), list.len()));
            }
            names.extend(joints.iter().map(|joint| (format!("{prefix}{joint}"), *unit)));
            numbers.extend(list);
        }
        Ok((stamp, names, numbers))
    }

    /// The accelerations of a point of a trajectory, in the order of the arm's joints.
    fn point(&mut self, logged: i64) -> Result<StampedNumbers, String> {
        self.doubles()?;
        self.doubles()?;
        let list = self.doubles()?;
        let names = (1..=list.len()).map(|joint| (format!("ddq{joint}"), "rad/s^2"));
        Ok((logged, names.collect(), list))
    }
}
