//! Class 2: small files that ask for much, and what has no end.

use std::fs;
use std::io::Write;

use flate2::Compression;
use flate2::write::{DeflateEncoder, ZlibEncoder};

use super::{ScriptedCase, process, refused_file, table};
use crate::tools;

/// The cases.
pub fn cases() -> Vec<ScriptedCase> {
    [matlab(), numpy(), hierarchical(), text(), endless()].into_iter().flatten().collect()
}

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

fn zeros(mut encoder: impl Write, megabytes: usize) {
    let zeros = vec![0; 1 << 20];
    (0..megabytes).for_each(|_| encoder.write_all(&zeros).unwrap_or_default());
}

/// So many MB of zeros behind `before`, as zlib packs them.
fn packed(before: &[u8], megabytes: usize) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(before.to_vec(), Compression::best());
    encoder.get_mut().clear();
    encoder.write_all(before).unwrap_or_default();
    zeros(&mut encoder, megabytes);
    encoder.finish().unwrap_or_default()
}

fn header() -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1, b'I', b'M']);
    bytes
}

/// The begin of a matrix of MATLAB level 5 with this name and size.
fn matrix(name: &str, rows: u32, columns: u32) -> Vec<u8> {
    let size = rows.wrapping_mul(columns).wrapping_mul(8);
    let body = words(&[6, 8, 6, 0, 5, 8, rows, columns, 1, name.len() as u32]);
    let mut bytes = [words(&[14, 56_u32.wrapping_add(size)]), body, name.as_bytes().to_vec()].concat();
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    [bytes, words(&[9, size])].concat()
}

fn compressed(matrix: &[u8], megabytes: usize) -> Vec<u8> {
    let packed = packed(matrix, megabytes);
    [words(&[15, packed.len() as u32]), packed].concat()
}

fn matlab() -> Vec<ScriptedCase> {
    let claim = |name: &str, rows: u32, columns: u32| {
        let bytes = move || [header(), matrix("Fx", rows, columns)].concat();
        refused_file(name, "claim.mat", bytes, &[], &[])
    };
    vec![
        refused_file(
            "mat_bomb",
            "bomb.mat",
            || [header(), compressed(&matrix("Fx", 1 << 28, 1), 2050)].concat(),
            &[],
            &["Fx"],
        )
        .long(),
        refused_file(
            "mat_bombs",
            "bombs.mat",
            || [header(), compressed(&matrix("Fx", 1 << 23, 1), 64).repeat(40)].concat(),
            &[],
            &["more than 67108864 numbers"],
        )
        .long(),
        claim("mat_claim_rows", u32::MAX, 1),
        claim("mat_claim_square", 1 << 31, 1 << 31),
        claim("mat_claim_wide", 1, 1 << 30),
        claim("mat_claim_just", 1 << 26, 1),
        refused_file("mat_cut_header", "cut.mat", || header()[..100].to_vec(), &[], &["cut short"]),
        refused_file(
            "mat_cut_packed",
            "cut.mat",
            || {
                let whole = [header(), compressed(&matrix("Fx", 4096, 1), 1)].concat();
                whole[..whole.len() - 20].to_vec()
            },
            &[],
            &["cut short"],
        ),
        refused_file(
            "mat4_claim",
            "claim4.mat",
            || [words(&[0, u32::MAX, u32::MAX, 0, 3]), b"Fx\0".to_vec()].concat(),
            &[],
            &[],
        ),
        refused_file(
            "mat4_cut",
            "cut4.mat",
            || [words(&[0, 80, 1, 0, 3]), b"Fx\0".to_vec(), vec![0; 100]].concat(),
            &[],
            &["cut short at sample 12 of 80"],
        ),
    ]
}

/// An npy file of this shape with so many bytes of zeros.
fn npy(shape: &str, fortran: &str, body: usize) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': {fortran}, 'shape': {shape}, }}\n");
    let length = (header.len() as u16).to_le_bytes().to_vec();
    [b"\x93NUMPY\x01\x00".to_vec(), length, header.into_bytes(), vec![0; body]].concat()
}

/// An archive whose only entry is `Fx.npy` with so many MB of zeros.
fn npz(megabytes: usize) -> Vec<u8> {
    let before = npy(&format!("({},)", megabytes << 17), "False", 0);
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&before).unwrap_or_default();
    zeros(&mut encoder, megabytes);
    let data = encoder.finish().unwrap_or_default();
    let whole = (before.len() + (megabytes << 20)) as u32;
    let name = b"Fx.npy";
    // Version, flags, method 8, time, date, checksum, sizes, length of the name.
    let entry = |first: &[u8]| {
        let sizes = words(&[0, data.len() as u32, whole]);
        [first, &[20, 0, 0, 0, 8, 0, 0, 0, 0, 0], &sizes, &[name.len() as u8, 0, 0, 0]].concat()
    };
    let local = [entry(b"PK\x03\x04"), name.to_vec(), data.clone()].concat();
    let central = [entry(b"PK\x01\x02\x14\x00"), vec![0; 10], words(&[0]), name.to_vec()].concat();
    let end = [
        b"PK\x05\x06\0\0\0\0\x01\0\x01\0".to_vec(),
        words(&[central.len() as u32, local.len() as u32]),
        vec![0; 2],
    ];
    [local, central, end.concat()].concat()
}

fn numpy() -> Vec<ScriptedCase> {
    let claim = |name: &str, shape: &'static str, words: &[&str]| {
        let set = ["process.input.columns.Fx=claim"];
        refused_file(name, "claim.npy", move || npy(shape, "False", 64), &set, words)
    };
    vec![
        claim(
            "npy_claim_overflow",
            "(18446744073709551615, 2)",
            &["18446744073709551615 x 2 numbers; read are at most"],
        ),
        claim("npy_claim_beyond", "(99999999999999999999,)", &["shape"]),
        claim("npy_claim_2gib", "(268435456,)", &["cut short at sample 8 of 268435456"]),
        claim("npy_claim_just", "(67108864,)", &["cut short at sample 8 of 67108864"]),
        claim("npy_claim_wide", "(9000, 9000)", &["cut short at sample 0 of 9000"]),
        refused_file(
            "npy_fortran_cut",
            "cut.npy",
            || npy("(48, 6)", "True", 75 * 8),
            &["process.input.columns.Fx=cut[1]"],
            &["cut short at sample 27 of 48 of cut[1]"],
        ),
        refused_file(
            "npy_header_long",
            "head.npy",
            || [b"\x93NUMPY\x02\x00".to_vec(), words(&[u32::MAX])].concat(),
            &[],
            &["no npy header"],
        ),
        refused_file("npz_bomb", "bomb.npz", || npz(2048), &[], &["Fx", "more than 67108864 numbers"]).long(),
        refused_file("npz_cut", "cut.npz", || npz(1)[..900].to_vec(), &[], &["cut short"]),
    ]
}

/// A file of the repository's tests.
fn shipped(name: &str) -> Vec<u8> {
    fs::read(tools::root().join("crates/wingbeat-io/tests").join(name)).unwrap_or_default()
}

fn hierarchical() -> Vec<ScriptedCase> {
    let looped = || {
        let mut bytes = shipped("data/samples/groups.h5");
        let root = bytes.get(64..72).unwrap_or_default().to_vec();
        let nodes: Vec<usize> =
            (0..bytes.len().saturating_sub(8)).filter(|at| &bytes[*at..*at + 4] == b"SNOD").collect();
        for node in nodes {
            for entry in 0..usize::from(bytes[node + 6]) {
                let at = node + 16 + 40 * entry;
                bytes[at..at + 8].copy_from_slice(&root);
            }
        }
        bytes
    };
    let cut = |part: usize| {
        move || {
            let bytes = shipped("data/samples/groups.h5");
            bytes[..bytes.len() * part / 8].to_vec()
        }
    };
    vec![
        refused_file("hdf5_looped", "looped.h5", looped, &[], &["found nothing"]),
        refused_file("hdf5_cut_early", "cut.h5", cut(1), &[], &[]),
        refused_file("hdf5_cut_half", "cut.h5", cut(4), &[], &["cut short"]),
        refused_file(
            "parquet_constants",
            "constants.parquet",
            || shipped("damaged/constants.parquet"),
            &[],
            &["rows of 1 columns of use; read are at most 67108864 numbers"],
        ),
        refused_file(
            "parquet_page",
            "page.parquet",
            || shipped("damaged/page_not_as_told.parquet"),
            &[],
            &[],
        ),
        refused_file("parquet_chunk", "chunk.parquet", || shipped("damaged/chunk_outside.parquet"), &[], &[]),
        refused_file("parquet_magic", "magic.parquet", || b"PAR1PAR1".to_vec(), &[], &[]),
    ]
}

fn text() -> Vec<ScriptedCase> {
    let wide = || (vec!["x"; 20_000].join(",") + "\n1\n").into_bytes();
    let quoted = || [table(3, 1000.0, ','), b"\"".to_vec(), table(40_000, 1000.0, ',')].concat();
    let line = || [table(3, 1000.0, ','), vec![b'1'; 40 << 20]].concat();
    vec![
        refused_file("csv_wide", "wide.csv", wide, &[], &["20000 columns"]),
        refused_file("csv_open_quote", "quoted.csv", quoted, &[], &["line 5"]),
        refused_file("csv_long_line", "line.csv", line, &[], &["line 5 is longer than 65536 bytes"]),
        refused_file("csv_zeros", "zeros.csv", || vec![0; 5000], &[], &["not a file of samples"]),
        refused_file("empty", "empty.csv", Vec::new, &[], &["the file is empty"]),
        refused_file(
            "noise",
            "noise.bin",
            || (0..9999_u32).map(|k| ((k * k) >> 3) as u8).collect(),
            &[],
            &[],
        ),
    ]
}

/// A pipe that nobody writes into.
fn endless() -> Vec<ScriptedCase> {
    vec![ScriptedCase::new(2, "fifo_samples", |place| {
        let made = std::process::Command::new("mkfifo").arg(place.path("pipe.csv")).status();
        made.map_err(|error| error.to_string())?;
        process(place, "pipe.csv", &[])?.exits(2)?.says(&["pipe.csv", "not a regular file"])?;
        place.holds("", &["pipe.csv"])
    })]
}
