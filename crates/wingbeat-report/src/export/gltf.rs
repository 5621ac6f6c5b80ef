//! A run as binary glTF 2.0 with its animation: every rib is a joint that carries the edges of the wing, the body a node of its own.

use serde_json::Value;
use wingbeat::math::{Mat3, Quat, Vec3};
use wingbeat::rig::rotation_vector;

use crate::motion::{RunMotion, SurfaceTrack, at, direction, spindle};

/// Component types of glTF.
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
/// Targets of vertices and of indices.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
/// Materials with their linear colours: sides 0 to 2, then body and path.
const MATERIALS: [(&str, &str); 5] = [
    ("left", "0,0.17,0.45"),
    ("right", "0.67,0.11,0"),
    ("middle", "0.26,0.29,0.33"),
    ("body", "0.16,0.18,0.21"),
    ("path", "0.02,0.02,0.02"),
];
/// A type of accessors, and of how many numbers it is.
type AccessorKind = (&'static str, usize);
const SCALAR: AccessorKind = ("SCALAR", 1);
const VEC3: AccessorKind = ("VEC3", 3);
const VEC4: AccessorKind = ("VEC4", 4);
const MAT4: AccessorKind = ("MAT4", 16);
/// Most ribs: 16 bits number their points, 5 a rib of a membrane.
const MOST_RIBS: usize = 13_000;
/// Shortest chord of a rib, and least rise of a membrane, m: a joint must not have the scale zero.
const SHORTEST: f64 = 1e-6;

/// Bytes, and views into them and accessors as JSON: written as text, which is less code than values.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Buffer {
    /// A view of what was written from `start`.
    fn view(&mut self, start: usize, target: Option<u32>) -> usize {
        let length = self.bytes.len() - start;
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        let target = target.map_or(String::new(), |target| format!(r#","target":{target}"#));
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{start},"byteLength":{length}{target}}}"#));
        self.views.len() - 1
    }

    /// Rows of numbers, with their least and most where `bounded`.
    fn floats(&mut self, numbers: &[f64], kind: AccessorKind, target: Option<u32>, bounded: bool) -> usize {
        let (name, parts) = kind;
        let start = self.bytes.len();
        self.bytes.extend(numbers.iter().flat_map(|v| (*v as f32).to_le_bytes()));
        let view = self.view(start, target);
        let count = numbers.len() / parts;
        let mut bounds = String::new();
        if bounded {
            let fold = |start: f32, pick: fn(f32, f32) -> f32| -> Vec<f32> {
                let column = |k: usize| numbers[k..].iter().step_by(parts);
                (0..parts).map(|k| column(k).fold(start, |all, v| pick(all, *v as f32))).collect()
            };
            let (low, high) = (fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max));
            bounds = format!(r#","min":{low:?},"max":{high:?}"#);
        }
        self.accessor(view, FLOAT, count, name, &bounds)
    }

    fn accessor(&mut self, view: usize, component: u32, count: usize, kind: &str, bounds: &str) -> usize {
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component},"count":{count},"type":"{kind}"{bounds}}}"#
        ));
        self.accessors.len() - 1
    }

    fn shorts(&mut self, numbers: &[u16], (kind, parts): AccessorKind, target: u32) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(numbers.iter().flat_map(|v| v.to_le_bytes()));
        let view = self.view(start, Some(target));
        let count = numbers.len() / parts;
        self.accessor(view, UNSIGNED_SHORT, count, kind, "")
    }
}

/// A joint in one frame: x from the trailing to the leading edge, scaled by the chord, and z above it, scaled by the rise of a membrane
/// in the middle.
struct RibJoint {
    origin: Vec3,
    rotation: Mat3,
    scale: [f64; 3],
}

/// Points of a rib between which it is straight, over chord and rise: of a membrane the parabola with its rise in the middle.
const FLAT: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 0.0]];
const BULGED: [[f64; 2]; 5] = [[1.0, 0.0], [0.75, 0.75], [0.5, 1.0], [0.25, 0.75], [0.0, 0.0]];

/// A run of `motion` as the bytes of a `.glb` file.
///
/// # Errors
/// More ribs than a file of glTF numbers here, a motion without any or without a surface between them, more than 2 GiB.
pub fn glb(motion: &RunMotion, name: &str) -> Result<Vec<u8>, String> {
    let ribs: usize = motion.surfaces.iter().map(|surface| surface.ribs.len()).sum();
    if ribs == 0 || ribs > MOST_RIBS || motion.frames() == 0 {
        return Err(format!("{ribs} ribs in {} frames: allowed are 1 to {MOST_RIBS} ribs", motion.frames()));
    }
    if !motion.surfaces.iter().any(|surface| surface.covered.contains(&true)) {
        return Err("no surface lies between the ribs: there is nothing to draw".into());
    }
    // Of every frame place and turn of each joint, of which the file holds a copy while it is made.
    let raised: usize = motion.surfaces.iter().map(|surface| surface.raised.len()).sum();
    let numbers = 28.0 * (ribs as f64 + 2.0) + 12.0 * raised as f64;
    super::fits("the .glb file", motion.frames() as f64 * numbers)?;
    let mut buffer = Buffer::default();
    let start = motion.t[0];
    let t: Vec<f64> = motion.t.iter().map(|t| t - start).collect();
    let times = buffer.floats(&t, SCALAR, None, true);
    // 0 the world with z up, 1 the wings, 2 the body, 3 the path; the joints follow.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let joints: Vec<usize> = (4..4 + ribs).collect();
    let mut nodes = vec![
        format!(
            r#"{{"name":"world, z up","rotation":[{},0,0,{half}],"children":[2,3,{}]}}"#,
            -half,
            listed(&joints)
        ),
        r#"{"name":"wings","mesh":0,"skin":0}"#.into(),
        if motion.bare { r#"{"name":"body"}"# } else { r#"{"name":"body","mesh":1}"# }.into(),
        r#"{"name":"path","mesh":2}"#.into(),
    ];
    let mut animated = Animated::default();
    let wings = wings(motion, &mut buffer, times, &mut nodes, &mut animated);
    let place: Vec<[f64; 3]> = (0..t.len()).map(|i| at(&motion.position, i).0).collect();
    let turn: Vec<[f64; 4]> = (0..t.len())
        .map(|i| {
            let [w, x, y, z] = [0, 1, 2, 3].map(|k| motion.attitude[k][i]);
            unit([x, y, z, w])
        })
        .collect();
    animated.add(&mut buffer, times, 2, &place, &turn);
    let path = buffer.floats(place.as_flattened(), VEC3, Some(VERTICES), true);
    let materials = MATERIALS.map(|(name, colour)| {
        format!(
            r#"{{"name":"{name}","doubleSided":true,"pbrMetallicRoughness":{{"baseColorFactor":[{colour},1],"metallicFactor":0,"roughnessFactor":0.9}}}}"#
        )
    });
    let body = body(motion, &mut buffer);
    let parts = [
        r#"{"asset":{"version":"2.0","generator":"wingbeat"},"scene":0,"scenes":[{"name":"#.into(),
        Value::from(name).to_string(),
        r#","nodes":[0,1]}],"nodes":["#.into(),
        nodes.join(","),
        r#"],"meshes":[{"name":"wings","primitives":["#.into(),
        wings.primitives.join(","),
        format!(r#"]}},{{"name":"body","primitives":[{body}]}},{{"name":"path","primitives":["#),
        format!(r#"{{"attributes":{{"POSITION":{path}}},"mode":3,"material":4}}]}}],"skins":[{{"joints":["#),
        listed(&joints),
        format!(r#"],"inverseBindMatrices":{},"skeleton":0}}],"materials":["#, wings.inverse),
        materials.join(","),
        r#"],"animations":[{"name":"flight","samplers":["#.into(),
        animated.samplers.join(","),
        r#"],"channels":["#.into(),
        animated.channels.join(","),
        format!(r#"]}}],"buffers":[{{"byteLength":{}}}],"bufferViews":["#, buffer.bytes.len()),
        buffer.views.join(","),
        r#"],"accessors":["#.into(),
        buffer.accessors.join(","),
        "]}".into(),
    ];
    Ok(container(parts.concat().into_bytes(), buffer.bytes))
}

/// Numbers with commas between them.
fn listed(numbers: &[usize]) -> String {
    numbers.iter().map(usize::to_string).collect::<Vec<_>>().join(",")
}

/// Channels of the animation.
#[derive(Default)]
struct Animated {
    samplers: Vec<String>,
    channels: Vec<String>,
}

impl Animated {
    /// The places and turns of a node.
    fn add(&mut self, buffer: &mut Buffer, times: usize, node: usize, place: &[[f64; 3]], turn: &[[f64; 4]]) {
        self.part(buffer, times, node, ("translation", place.as_flattened(), VEC3));
        self.part(buffer, times, node, ("rotation", turn.as_flattened(), VEC4));
    }

    /// What of a node is told by the numbers.
    fn part(
        &mut self,
        buffer: &mut Buffer,
        times: usize,
        node: usize,
        (path, numbers, kind): (&str, &[f64], AccessorKind),
    ) {
        let output = buffer.floats(numbers, kind, None, false);
        let sampler = self.samplers.len();
        self.channels.push(format!(r#"{{"sampler":{sampler},"target":{{"node":{node},"path":"{path}"}}}}"#));
        self.samplers.push(format!(r#"{{"input":{times},"output":{output},"interpolation":"LINEAR"}}"#));
    }
}

struct Wings {
    primitives: Vec<String>,
    inverse: usize,
}

/// The skinned mesh of all surfaces, and the joints of its ribs.
fn wings(
    motion: &RunMotion,
    buffer: &mut Buffer,
    times: usize,
    nodes: &mut Vec<String>,
    animated: &mut Animated,
) -> Wings {
    let (mut points, mut joints, mut weights, mut inverse) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut indices: [Vec<u16>; 3] = Default::default();
    for surface in &motion.surfaces {
        let first = points.len() as u16;
        let profile = if surface.raised.is_empty() { &FLAT[..] } else { &BULGED };
        let each = profile.len() as u16;
        for k in 0..surface.ribs.len() {
            let (bind, number) = (joint(motion, surface, k, 0), (inverse.len() / 16) as u16);
            for [x, z] in profile {
                let inside = Vec3([bind.scale[0] * x, 0.0, bind.scale[2] * z]);
                points.push((bind.origin + bind.rotation * inside).0);
                joints.extend([number, 0, 0, 0]);
                weights.extend([1.0, 0.0, 0.0, 0.0]);
            }
            inverse.extend(inverted(&bind));
            nodes.push(format!(
                r#"{{"name":{},"translation":{:?},"rotation":{:?},"scale":{:?}}}"#,
                Value::from(format!("{} rib {k}", surface.name)),
                bind.origin.0,
                quaternion(&bind.rotation),
                bind.scale
            ));
            let (mut place, mut turn): (Vec<[f64; 3]>, Vec<[f64; 4]>) = (Vec::new(), Vec::new());
            let mut scale: Vec<[f64; 3]> = Vec::new();
            for i in 0..motion.frames() {
                let now = joint(motion, surface, k, i);
                let next = quaternion(&now.rotation);
                let along = turn.last().map_or(1.0, |last| last.iter().zip(next).map(|(a, b)| a * b).sum());
                place.push(now.origin.0);
                scale.push(now.scale);
                turn.push(if along < 0.0 { next.map(|part| -part) } else { next });
            }
            let node = nodes.len() - 1;
            animated.add(buffer, times, node, &place, &turn);
            if !surface.raised.is_empty() {
                animated.part(buffer, times, node, ("scale", scale.as_flattened(), VEC3));
            }
        }
        for (k, side) in surface.side.iter().enumerate().filter(|(k, _)| surface.covered[*k]) {
            let at = first + each * k as u16;
            for a in at..at + each - 1 {
                let [b, c, d] = [a + 1, a + each + 1, a + each];
                indices[*side].extend([a, b, c, a, c, d]);
            }
        }
    }
    let position = buffer.floats(points.as_flattened(), VEC3, Some(VERTICES), true);
    let joints = buffer.shorts(&joints, VEC4, VERTICES);
    let weights = buffer.floats(&weights, VEC4, Some(VERTICES), false);
    let inverse = buffer.floats(&inverse, MAT4, None, false);
    let mut primitives = Vec::new();
    for (side, indices) in indices.iter().enumerate().filter(|(_, indices)| !indices.is_empty()) {
        let indices = buffer.shorts(indices, SCALAR, INDICES);
        primitives.push(format!(
            r#"{{"attributes":{{"POSITION":{position},"JOINTS_0":{joints},"WEIGHTS_0":{weights}}},"indices":{indices},"material":{side}}}"#
        ));
    }
    Wings { primitives, inverse }
}

/// Rib `k` of `surface` in frame `i`.
fn joint(motion: &RunMotion, surface: &SurfaceTrack, k: usize, i: usize) -> RibJoint {
    let [leading, trailing] = surface.ribs[k].each_ref().map(|edge| motion.in_world(i, at(edge, i)));
    let chord = (leading - trailing).norm().max(SHORTEST);
    let x = direction(leading - trailing);
    // What lies across: the body's own left, or its top where the chord lies along that.
    let across = |v: [f64; 3]| x.cross(motion.turned(i, Vec3(v)));
    let [left, top] = [across([0.0, 1.0, 0.0]), across([0.0, 0.0, 1.0])];
    let z = if left.norm() > 0.1 { direction(left) } else { direction(top) };
    let rotation = Mat3::from_columns(x, z.cross(x), z);
    let Some(raised) = surface.raised.get(k) else {
        return RibJoint { origin: trailing, rotation, scale: [chord, 1.0, 1.0] };
    };
    let rise = motion.in_world(i, at(&raised[1], i)) - (leading + trailing) * 0.5;
    let height = rise.dot(z);
    // No scale may be zero.
    let height = if height.abs() < SHORTEST { SHORTEST } else { height };
    RibJoint { origin: trailing, rotation, scale: [chord, 1.0, height] }
}

/// The inverse of a joint's matrix, S^-1 R^T (p - o), by columns.
fn inverted(joint: &RibJoint) -> [f64; 16] {
    let scale = joint.scale.map(|scale| 1.0 / scale);
    let back = joint.rotation.transpose_mul(-joint.origin);
    std::array::from_fn(|at| match (at / 4, at % 4) {
        (3, 3) => 1.0,
        (_, 3) => 0.0,
        (3, row) => scale[row] * back.0[row],
        (column, row) => scale[row] * joint.rotation.0[column][row],
    })
}

/// x, y, z, w.
pub(super) fn quaternion(rotation: &Mat3) -> [f64; 4] {
    let mut q = [0.0; 4];
    Quat::exp(rotation_vector(rotation)).store_wxyz(&mut q);
    unit([q[1], q[2], q[3], q[0]])
}

fn unit(q: [f64; 4]) -> [f64; 4] {
    let size = q.iter().map(|part| part * part).sum::<f64>().sqrt();
    if size > 0.0 { q.map(|part| part / size) } else { [0.0, 0.0, 0.0, 1.0] }
}

/// The spindle that stands for the body, in B.
fn body(motion: &RunMotion, buffer: &mut Buffer) -> String {
    let around = 8;
    let rings = spindle(at(&motion.com, 0), motion.reach(), around);
    let count = rings.len() as u16;
    let points: Vec<[f64; 3]> = rings.into_iter().flatten().map(|corner| corner.0).collect();
    let mut indices: Vec<u16> = Vec::new();
    for (r, k) in (0..count - 1).flat_map(|r| (0..around).map(move |k| (r, k))) {
        let next = (k + 1) % around;
        let [a, b, d, e] = [(r, k), (r, next), (r + 1, next), (r + 1, k)].map(|(r, k)| r * around + k);
        indices.extend([a, d, b, a, e, d]);
    }
    let position = buffer.floats(points.as_flattened(), VEC3, Some(VERTICES), true);
    let indices = buffer.shorts(&indices, SCALAR, INDICES);
    format!(r#"{{"attributes":{{"POSITION":{position}}},"indices":{indices},"material":3}}"#)
}

/// The two chunks of a `.glb` file with its head.
fn container(mut json: Vec<u8>, bytes: Vec<u8>) -> Vec<u8> {
    while !json.len().is_multiple_of(4) {
        json.push(b' ');
    }
    let length = (12 + 8 + json.len() + 8 + bytes.len()) as u32;
    let mut file = b"glTF\x02\x00\x00\x00".to_vec();
    file.extend(length.to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", bytes)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}
