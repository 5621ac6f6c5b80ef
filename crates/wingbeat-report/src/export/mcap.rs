//! A flight, or a run on the rig, as MCAP with the profile ros2: every message in CDR, chunks without compression, with an index.
//!
//! Format: <https://mcap.dev/spec>, version 0.

use std::collections::BTreeMap;

use flate2::Crc;
use wingbeat::math::Vec3;
use wingbeat::rig::cell::CHANNELS;
use wingbeat::simulate::Record;
use wingbeat_io::samples::MCAP_MAGIC;

use super::cdr::CdrMessage;
use super::ros;
use crate::flight::{axes, shown, taken};
use crate::motion::{RunMotion, SurfaceTrack, at, direction};

/// Bytes after which a chunk is closed.
const CHUNK: usize = 1 << 20;
/// Frames between two messages of transforms, and between two of the others.
const TRANSFORMS: usize = 2;
/// Names of the frames.
const WORLD: &str = "world";
const BODY: &str = "base_link";

/// A file while it is written.
struct File {
    bytes: Vec<u8>,
    channels: Vec<(&'static str, &'static str)>,
    topics: Vec<String>,
    counts: Vec<u64>,
    chunk: Vec<u8>,
    index: BTreeMap<u16, Vec<(u64, u64)>>,
    indices: Vec<u8>,
    /// Indices of metadata, and their number.
    kept: (Vec<u8>, u32),
    chunks: u32,
    span: (u64, u64),
    whole: (u64, u64),
}

fn string(out: &mut Vec<u8>, text: &str) {
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.as_bytes());
}

fn record(out: &mut Vec<u8>, opcode: u8, content: &[u8]) {
    out.push(opcode);
    out.extend((content.len() as u64).to_le_bytes());
    out.extend(content);
}

impl File {
    fn new() -> Self {
        let mut bytes = MCAP_MAGIC.to_vec();
        let mut head = Vec::new();
        string(&mut head, "ros2");
        string(&mut head, "wingbeat");
        record(&mut bytes, 1, &head);
        let none = (u64::MAX, 0);
        Self {
            bytes,
            channels: Vec::new(),
            topics: Vec::new(),
            counts: Vec::new(),
            chunk: Vec::new(),
            index: BTreeMap::new(),
            indices: Vec::new(),
            kept: (Vec::new(), 0),
            chunks: 0,
            span: none,
            whole: none,
        }
    }

    /// A new channel for messages of the type number `schema` of [`ros::TYPES`].
    fn channel(&mut self, topic: &str, schema: usize) -> u16 {
        self.channels.push(ros::TYPES[schema]);
        self.topics.push(topic.into());
        self.counts.push(0);
        let id = self.topics.len() as u16 - 1;
        let mut own = Vec::new();
        self.describe(&mut own, id);
        self.chunk.extend(own);
        id
    }

    /// Words beside the messages.
    fn metadata(&mut self, name: &str, pairs: &[(&str, String)]) {
        let (mut content, mut words) = (Vec::new(), Vec::new());
        string(&mut content, name);
        for (key, value) in pairs {
            string(&mut words, key);
            string(&mut words, value);
        }
        content.extend((words.len() as u32).to_le_bytes());
        content.extend(words);
        let at = self.bytes.len() as u64;
        record(&mut self.bytes, 12, &content);
        let mut index: Vec<u8> =
            [at, self.bytes.len() as u64 - at].iter().flat_map(|number| number.to_le_bytes()).collect();
        string(&mut index, name);
        record(&mut self.kept.0, 13, &index);
        self.kept.1 += 1;
    }

    /// Schema and channel number `id`; each channel has a schema of its own number, from 1.
    fn describe(&self, out: &mut Vec<u8>, id: u16) {
        let (name, definition) = self.channels[usize::from(id)];
        let mut schema = (id + 1).to_le_bytes().to_vec();
        string(&mut schema, name);
        string(&mut schema, "ros2msg");
        string(&mut schema, definition);
        record(out, 3, &schema);
        let mut channel = id.to_le_bytes().to_vec();
        channel.extend((id + 1).to_le_bytes());
        string(&mut channel, &self.topics[usize::from(id)]);
        string(&mut channel, "cdr");
        // `ros2 bag` keeps the quality of service of a topic here.
        let mut kept = Vec::new();
        if self.topics[usize::from(id)] == "/robot_description" {
            string(&mut kept, "offered_qos_profiles");
            string(&mut kept, ros::LATCHED);
        }
        channel.extend((kept.len() as u32).to_le_bytes());
        channel.extend(kept);
        record(out, 4, &channel);
    }

    fn message(&mut self, channel: u16, time: u64, message: CdrMessage) {
        let sequence = self.counts[usize::from(channel)];
        self.counts[usize::from(channel)] += 1;
        self.index.entry(channel).or_default().push((time, self.chunk.len() as u64));
        let mut content = channel.to_le_bytes().to_vec();
        content.extend((sequence as u32).to_le_bytes());
        content.extend([time, time].iter().flat_map(|time| time.to_le_bytes()));
        content.extend(message.bytes());
        record(&mut self.chunk, 5, &content);
        self.span = (self.span.0.min(time), self.span.1.max(time));
        if self.chunk.len() > CHUNK {
            self.close_chunk();
        }
    }

    fn close_chunk(&mut self) {
        if self.index.is_empty() {
            return;
        }
        let at = self.bytes.len() as u64;
        let mut crc = Crc::new();
        crc.update(&self.chunk);
        let mut content = Vec::new();
        let size = self.chunk.len() as u64;
        content.extend([self.span.0, self.span.1, size].iter().flat_map(|number| number.to_le_bytes()));
        content.extend(crc.sum().to_le_bytes());
        string(&mut content, "");
        content.extend(size.to_le_bytes());
        content.append(&mut self.chunk);
        record(&mut self.bytes, 6, &content);
        let length = self.bytes.len() as u64 - at;
        let start = self.bytes.len() as u64;
        let mut places = Vec::new();
        for (channel, entries) in std::mem::take(&mut self.index) {
            places.extend(channel.to_le_bytes());
            places.extend((self.bytes.len() as u64).to_le_bytes());
            let mut index = channel.to_le_bytes().to_vec();
            index.extend((16 * entries.len() as u32).to_le_bytes());
            index.extend(
                entries.iter().flat_map(|(time, place)| [time.to_le_bytes(), place.to_le_bytes()]).flatten(),
            );
            record(&mut self.bytes, 7, &index);
        }
        let mut index = Vec::new();
        index.extend([self.span.0, self.span.1, at, length].iter().flat_map(|number| number.to_le_bytes()));
        index.extend((places.len() as u32).to_le_bytes());
        index.extend(places);
        index.extend((self.bytes.len() as u64 - start).to_le_bytes());
        string(&mut index, "");
        index.extend([size, size].iter().flat_map(|number| number.to_le_bytes()));
        record(&mut self.indices, 8, &index);
        self.chunks += 1;
        self.whole = (self.whole.0.min(self.span.0), self.whole.1.max(self.span.1));
        self.span = (u64::MAX, 0);
    }

    /// The file with its summary.
    fn finish(mut self) -> Vec<u8> {
        self.close_chunk();
        record(&mut self.bytes, 15, &0_u32.to_le_bytes());
        let summary = self.bytes.len() as u64;
        let mut described = Vec::new();
        (0..self.topics.len() as u16).for_each(|id| self.describe(&mut described, id));
        self.bytes.extend(described);
        let mut statistics = self.counts.iter().sum::<u64>().to_le_bytes().to_vec();
        let channels = self.topics.len() as u32;
        statistics.extend((channels as u16).to_le_bytes());
        statistics
            .extend([channels, 0, self.kept.1, self.chunks].iter().flat_map(|number| number.to_le_bytes()));
        statistics.extend([self.whole.0, self.whole.1].iter().flat_map(|time| time.to_le_bytes()));
        statistics.extend((10 * channels).to_le_bytes());
        for (id, count) in self.counts.iter().enumerate() {
            statistics.extend((id as u16).to_le_bytes());
            statistics.extend(count.to_le_bytes());
        }
        record(&mut self.bytes, 11, &statistics);
        self.bytes.append(&mut self.indices);
        self.bytes.append(&mut self.kept.0);
        let mut foot = summary.to_le_bytes().to_vec();
        // No offsets of groups, no check of the summary.
        foot.extend([0; 12]);
        record(&mut self.bytes, 2, &foot);
        self.bytes.extend(MCAP_MAGIC);
        self.bytes
    }
}

/// A flight of `motion` with its `record` as the bytes of an MCAP file: transforms of body and ribs, the robot's description, joints,
/// odometry and a wrench for each source of force.
///
/// # Errors
/// A record without the columns of a flight.
pub fn mcap(motion: &RunMotion, flown: &Record, name: &str) -> Result<Vec<u8>, String> {
    let ribs: usize = motion.surfaces.iter().map(|s| s.ribs.len() + 4 * s.raised.len()).sum();
    // Of every frame a transform a rib, odometry, and a state or wrench for each joint and source.
    let frame = 160.0 * ribs as f64 / TRANSFORMS as f64 + 1200.0 + 200.0 * motion.sources.len() as f64;
    super::fits("the .mcap file", motion.frames() as f64 * frame)?;
    let rows = shown(flown);
    let of_flight =
        |name: &str| axes(flown, &rows, name).map_err(|why| format!("{why}; --mcap takes a flight"));
    let [velocity, rate] = ["v_WB_W", "w_WB_B"].map(of_flight);
    let (velocity, rate) = (velocity?, rate?);
    let names = flown.columns().iter().map(|column| column.name.as_str());
    let joints: Vec<&str> = names.filter(|name| flown.values(&format!("torque_{name}")).is_some()).collect();
    let column = |name: &str| taken(flown, &rows, name);
    let positions = joints.iter().map(|name| column(name)).collect::<Result<Vec<_>, _>>()?;
    let efforts =
        joints.iter().map(|name| column(&format!("torque_{name}"))).collect::<Result<Vec<_>, _>>()?;
    let mut file = File::new();
    let described = file.channel("/robot_description", ros::STRING);
    let [transforms, odometry, states] =
        [("/tf", ros::TF), ("/odom", ros::ODOMETRY), ("/joint_states", ros::JOINTS)]
            .map(|(topic, schema)| file.channel(topic, schema));
    let mut wrenches = Vec::new();
    for source in motion.sources.iter().filter(|source| source.place.is_none()) {
        let plain = source.name.replace(' ', "_");
        let moment = axes(flown, &rows, &format!("moment_{plain}"))?;
        wrenches.push((file.channel(&format!("/wrench/{plain}"), ros::WRENCH), source.force.clone(), moment));
    }
    if let Ok(thrust) = axes(flown, &rows, "thrust") {
        let moment = axes(flown, &rows, "thrust_moment")?;
        wrenches.push((file.channel("/wrench/thrust", ros::WRENCH), thrust, moment));
    }
    let start = motion.t.first().copied().unwrap_or(0.0);
    for (i, t) in motion.t.iter().enumerate() {
        let time = ((t - start) * 1e9).round().max(0.0) as u64;
        if i == 0 {
            let mut text = CdrMessage::new();
            text.text(&ros::urdf(motion, name));
            file.message(described, time, text);
        }
        let turn: [f64; 4] = std::array::from_fn(|k| motion.attitude[(k + 1) % 4][i]);
        if i % TRANSFORMS == 0 {
            file.message(transforms, time, transform(motion, i, time, turn));
        }
        // The velocity is told in the axes of the child frame.
        let back = |v: Vec3| {
            Vec3([0, 1, 2].map(|axis| {
                let unit = Vec3(std::array::from_fn(|k| f64::from(u8::from(k == axis))));
                motion.turned(i, unit).dot(v)
            }))
        };
        let mut odom = CdrMessage::new();
        odom.header(time, WORLD)
            .text(BODY)
            .doubles(&at(&motion.position, i).0)
            .doubles(&turn)
            .doubles(&[0.0; 36]);
        odom.doubles(&back(at(&velocity, i)).0).doubles(&at(&rate, i).0).doubles(&[0.0; 36]);
        file.message(odometry, time, odom);
        let mut state = CdrMessage::new();
        state.header(time, "").int(joints.len() as u32);
        joints.iter().for_each(|name| {
            state.text(name);
        });
        let of = |columns: &[Vec<f64>]| columns.iter().map(|column| column[i]).collect::<Vec<f64>>();
        state.list(&of(&positions)).list(&[]).list(&of(&efforts));
        file.message(states, time, state);
        for (channel, force, moment) in &wrenches {
            let mut wrench = CdrMessage::new();
            wrench.header(time, BODY).doubles(&at(force, i).0).doubles(&at(moment, i).0);
            file.message(*channel, time, wrench);
        }
    }
    Ok(file.finish())
}

/// Body in the world and every rib in the body, of a membrane its parts too: x along the chord forward, y along the span to the left.
fn transform(motion: &RunMotion, i: usize, time: u64, turn: [f64; 4]) -> CdrMessage {
    let of_surface = |surface: &SurfaceTrack| {
        (0..surface.ribs.len()).flat_map(|k| ros::pieces(surface, k, i)).collect::<Vec<_>>()
    };
    let pieces: Vec<ros::FlatPiece> = motion.surfaces.iter().flat_map(of_surface).collect();
    let mut message = CdrMessage::new();
    message.int(pieces.len() as u32 + 1);
    message.header(time, WORLD).text(BODY).doubles(&at(&motion.position, i).0).doubles(&turn);
    for ros::FlatPiece { frame, edges: [front, back], left, .. } in pieces {
        let q = super::gltf::quaternion(&basis(front - back, left));
        message.header(time, BODY).text(&frame).doubles(&((front + back) * 0.5).0).doubles(&q);
    }
    message
}

/// Axes with x along `chord` and y as far along `left` as that allows; where the span runs along the chord, as far up.
fn basis(chord: Vec3, left: Vec3) -> wingbeat::math::Mat3 {
    let x = direction(chord);
    let across = [direction(left), Vec3([0.0, 0.0, 1.0])].map(|v| x.cross(v));
    let z = if across[0].norm() > 0.1 { direction(across[0]) } else { direction(across[1]) };
    wingbeat::math::Mat3::from_columns(x, z.cross(x), z)
}

/// Wrenches of a run on the rig: the prefix of their columns, and the last part of their topic.
const WRENCHES: [(&str, &str); 4] =
    [("", "cell"), ("true_", "true"), ("air_", "air"), ("inertia_", "inertia")];

/// The `record` of a run on the rig as the bytes of an MCAP file: what the load cell read and its parts, the arm's joints with the phase
/// of the stroke, and the accelerations of the joints. Every row is kept; `wingbeat rig process` reads it back.
///
/// # Errors
/// A record without times or without the channels of the cell; too many bytes.
pub fn rig_mcap(record: &Record) -> Result<Vec<u8>, String> {
    let column = |name: &str| record.values(name).ok_or_else(|| format!("the record has no column {name}"));
    let t = column("t")?;
    super::record_fits("the .mcap file", record, 24.0)?;
    let start = t.first().copied().ok_or("the record has no rows")?;
    let mut file = File::new();
    file.metadata("wingbeat", &[("begin_s", format!("{start}"))]);
    let mut wrenches = Vec::new();
    for (prefix, topic) in WRENCHES {
        let six = CHANNELS.map(|(name, _)| column(&format!("{prefix}{name}")));
        match six.into_iter().collect::<Result<Vec<_>, _>>() {
            Ok(six) => wrenches.push((file.channel(&format!("/wrench/{topic}"), ros::WRENCH), six)),
            Err(why) if prefix.is_empty() => return Err(why),
            Err(_) => {}
        }
    }
    let joints: Vec<String> =
        (1..).map(|k| format!("q{k}")).take_while(|name| record.values(name).is_some()).collect();
    let all = |prefix: &str| -> Option<Vec<&[f64]>> {
        joints.iter().map(|joint| record.values(&format!("{prefix}{joint}"))).collect()
    };
    let (positions, rates, accelerations) = (all("").unwrap_or_default(), all("d"), all("dd"));
    let states = file.channel("/joint_states", ros::JOINTS);
    let points = file.channel("/joint_accelerations", ros::POINT);
    let phase = record.values("phase").map(|phase| (file.channel("/stroke", ros::JOINTS), phase));
    for i in 0..t.len() {
        let time = ((t[i] - start) * 1e9).round().max(0.0) as u64;
        for (channel, six) in &wrenches {
            let mut wrench = CdrMessage::new();
            wrench.header(time, "cell");
            six.iter().for_each(|part| {
                wrench.doubles(&[part[i]]);
            });
            file.message(*channel, time, wrench);
        }
        let row = |columns: &[&[f64]]| columns.iter().map(|column| column[i]).collect::<Vec<f64>>();
        if !joints.is_empty() {
            let rates = rates.as_ref().map_or(Vec::new(), |rates| row(rates));
            let state = joint_state(time, joints.iter().map(String::as_str), &row(&positions), &rates);
            file.message(states, time, state);
        }
        if let Some(accelerations) = accelerations.as_ref().filter(|_| !joints.is_empty()) {
            let mut point = CdrMessage::new();
            point.list(&[]).list(&[]).list(&row(accelerations)).list(&[]);
            point.int((time / 1_000_000_000) as u32).int((time % 1_000_000_000) as u32);
            file.message(points, time, point);
        }
        if let Some((channel, phase)) = phase {
            file.message(channel, time, joint_state(time, ["phase"], &[phase[i]], &[]));
        }
    }
    Ok(file.finish())
}

/// Names, positions and rates of joints.
fn joint_state<'a>(
    time: u64,
    names: impl IntoIterator<Item = &'a str, IntoIter: ExactSizeIterator>,
    positions: &[f64],
    rates: &[f64],
) -> CdrMessage {
    let mut state = CdrMessage::new();
    let names = names.into_iter();
    state.header(time, "").int(names.len() as u32);
    names.for_each(|name| {
        state.text(name);
    });
    state.list(positions).list(rates).list(&[]);
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_of_a_rib_lies_in_the_wing_however_it_is_raised() {
        // A half wing that is raised by 60 deg and twisted, and its image beyond a gap.
        let (up, twist) = (60_f64.to_radians(), 0.2_f64);
        let span = Vec3::new(0.0, up.cos(), up.sin());
        let chord = Vec3::new(twist.cos(), twist.sin() * up.sin(), -twist.sin() * up.cos());
        let point = |p: Vec3| p.0.map(|x| vec![x]);
        let rib = |side: f64, along: f64| {
            let mirrored = |v: Vec3| Vec3::new(v[0], side * v[1], v[2]);
            [0.05, -0.1].map(|x| point(mirrored(span * along + chord * x)))
        };
        let surface = SurfaceTrack {
            name: "wing".into(),
            ribs: vec![rib(1.0, 0.3), rib(1.0, 0.1), rib(-1.0, 0.1), rib(-1.0, 0.3)],
            covered: vec![true, false, true],
            ..SurfaceTrack::default()
        };
        for k in 0..4 {
            let piece = &ros::pieces(&surface, k, 0)[0];
            let frame = basis(piece.edges[0] - piece.edges[1], piece.left);
            let side = if k < 2 { 1.0 } else { -1.0 };
            let axis = |j: usize| Vec3([0, 1, 2].map(|i| frame.0[i][j]));
            let mirrored = |v: Vec3| Vec3::new(v[0], side * v[1], v[2]);
            assert!((axis(0) - mirrored(chord)).norm() < 1e-12, "rib {k}: {frame:?}");
            assert!((axis(1) - mirrored(span) * side).norm() < 1e-12, "rib {k}: {frame:?}");
        }
    }
}
