//! Files of samples written by other programs (tests/data/samples/make.py), read back to the numbers they hold.

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::process::InputSpec;
use wingbeat_io::samples::{ImportedRecord, read_samples};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/samples").join(name)
}

/// The channel `i` at sample `k`, N and N m.
fn truth(i: usize, k: usize) -> f64 {
    (i + 1) as f64 * (TAU * 25e-3 * k as f64 + i as f64).cos() * if i < 3 { 1.0 } else { 1e-3 }
}

fn import(name: &str, with: &str) -> Result<ImportedRecord, String> {
    let input: InputSpec = serde_toml(with);
    let table = read_samples(&file(name), &input).map_err(|error| error.to_string())?;
    table.import(&input).map_err(|error| error.to_string())
}

fn serde_toml(text: &str) -> InputSpec {
    toml::from_str(text).unwrap()
}

/// Checks every sample that is there; returns how many are not.
fn check(imported: &ImportedRecord, tolerance: f64) -> usize {
    let record = &imported.record;
    let mut missing = 0;
    for (i, (name, unit)) in CHANNELS.iter().enumerate() {
        let column = record.column(name).unwrap();
        assert_eq!(column.unit, *unit);
        for (k, value) in column.values.iter().enumerate() {
            missing += usize::from(value.is_nan());
            let scale = if i < 3 { 1.0 } else { 1e-3 };
            assert!(
                value.is_nan() || (value - truth(i, k)).abs() <= tolerance * scale,
                "{name} {k}: {value} {}",
                truth(i, k)
            );
        }
    }
    for (k, t) in record.values("t").unwrap().iter().enumerate() {
        assert!((t - k as f64 * 1e-3).abs() < 1e-9, "{k}: {t}");
    }
    missing
}

#[test]
fn arrays_of_numpy() {
    assert_eq!(check(&import("units_in_names.npz", "").unwrap(), 1e-14), 0);
    let mapped = "rate_hz = 1000\nunits = { force = \"N\", moment = \"N mm\" }\n[columns]\n";
    let matrix = |name: &str| {
        let lines = CHANNELS.iter().enumerate().map(|(i, (c, _))| format!("{c} = \"{name}[{i}]\"\n"));
        mapped.to_owned() + &lines.collect::<String>()
    };
    assert_eq!(check(&import("matrix.npz", &matrix("wrench")).unwrap(), 5e-7), 0);
    let si = matrix("matrix").replace("N mm", "N m");
    assert_eq!(check(&import("matrix.npy", &si).unwrap(), 1e-14), 0);
}

#[test]
fn variables_of_matlab() {
    let units = "units = { force = \"N\", moment = \"N m\", time = \"s\" }";
    assert_eq!(check(&import("columns.mat", units).unwrap(), 1e-14), 0);
    let counts = "rate_hz = 1000\ncounts_per_newton = 1e6\ncounts_per_newton_metre = 1e6\n\
                  units = { force = \"counts\", moment = \"counts\", angle = \"deg\" }\n\
                  columns = { Fx = \"counts[0]\", Fy = \"counts[1]\", Fz = \"counts[2]\", \
                  Tx = \"counts[3]\", Ty = \"counts[4]\", Tz = \"counts[5]\", phase = \"angle\" }";
    let imported = import("counts.mat", counts).unwrap();
    assert_eq!(check(&imported, 5.1e-4), 0);
    let phase = imported.record.column("phase").unwrap();
    assert!(phase.unit == "rad" && (phase.values[40] - TAU).abs() < 1e-12);
}

#[test]
fn datasets_of_hdf5_and_of_matlab_73() {
    let lines = CHANNELS.iter().map(|(c, _)| format!("{c} = \"run/1/{c}\"\n")).collect::<String>();
    let run = format!("[columns]\nt = \"run/1/clock\"\n{lines}");
    assert_eq!(check(&import("groups.h5", &run).unwrap(), 1e-14), 0);
    let lines =
        CHANNELS.iter().enumerate().map(|(i, (c, _))| format!("{c} = \"wrench[{i}]\"\n")).collect::<String>();
    let matrix = format!("units = {{ force = \"N\", moment = \"N m\" }}\n[columns]\n{lines}");
    assert_eq!(check(&import("version73.mat", &matrix).unwrap(), 1e-14), 0);
}

#[test]
fn files_of_ati_in_counts_in_units_and_with_tabs() {
    for name in ["ati_units.csv", "ati_counts.csv", "ati_tabs.txt"] {
        let imported = import(name, "").unwrap();
        assert_eq!(imported.import.layout, "CSV of ATI's demo application", "{name}");
        // Half a count, 1e-6 N and 1e-6 N m.
        assert_eq!(check(&imported, 5.1e-4), 12, "{name}");
        let import = &imported.import;
        assert_eq!((import.rows, import.missing, import.gaps, import.longest_gap), (14, 2, 1, 2), "{name}");
        assert_eq!(imported.record.values("status").unwrap()[9], f64::from(0x8001_0000_u32), "{name}");
    }
    let bridged = import("ati_units.csv", "bridge_samples = 2").unwrap();
    assert_eq!(bridged.import.bridged, 2);
    let fz = bridged.record.values("Fz").unwrap();
    assert!((fz[5] - (2.0 * fz[4] + fz[7]) / 3.0).abs() < 1e-12);
}

#[test]
fn columns_with_names_and_units() {
    let imported = import("named.csv", "columns = { phase = \"stroke_deg\" }").unwrap();
    assert_eq!(check(&imported, 1e-8), 0);
    assert!((imported.record.values("phase").unwrap()[10] - TAU / 4.0).abs() < 1e-12);
    assert_eq!(check(&import("semicolons.csv", "").unwrap(), 1e-8), 0);
}

#[test]
fn what_is_missing_is_named_with_what_to_do() {
    for (name, with, parts) in [
        (
            "columns.mat",
            "",
            &["column Fx: unit missing", "--set process.input.units.force=UNIT", "N, mN"][..],
        ),
        ("columns.mat", "units.force = \"stone\"", &["unit `stone`", "counts"]),
        (
            "matrix.npz",
            "",
            &["no column for Fx; found wrench[0], wrench[1]", "--set process.input.columns.Fx="],
        ),
        ("named.csv", "columns.Fz = \"up\"", &["no column `up` for Fz; found time_s, fx_N"]),
        ("named.csv", "columns.F = \"up\"", &["process.input.columns.F", "Fx, Fy"]),
        ("named.csv", "rate_hz = -1.0", &["rate_hz = -1", "above 0"]),
        ("counts.mat", "units.force = \"counts\"\ncolumns.Fx = \"counts[0]\"", &["counts_per_newton"]),
        ("make.py", "", &["line 3: 1 columns; the header has 3"]),
    ] {
        let message = import(name, with).unwrap_err();
        assert!(message.contains(name), "{message}");
        for part in parts {
            assert!(message.contains(part), "{message}");
        }
    }
}

const ALL: [&str; 11] = [
    "units_in_names.npz",
    "matrix.npz",
    "matrix.npy",
    "columns.mat",
    "counts.mat",
    "groups.h5",
    "version73.mat",
    "ati_units.csv",
    "ati_tabs.txt",
    "named.csv",
    "semicolons.csv",
];

/// Reads and imports without a mapping.
fn take(path: &Path) -> Result<ImportedRecord, wingbeat_io::Error> {
    let input = InputSpec::default();
    read_samples(path, &input)?.import(&input)
}

fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("samples");
    fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

/// Cut anywhere, a file is refused with its name, or read with what it still holds; it never ends the program.
#[test]
fn files_cut_short_anywhere() {
    for name in ALL {
        let bytes = fs::read(file(name)).unwrap();
        let path = scratch(&format!("cut_{name}"));
        for length in (0..bytes.len()).step_by(if name.ends_with(".h5") { 197 } else { 13 }) {
            fs::write(&path, &bytes[..length]).unwrap();
            if let Err(error) = take(&path) {
                assert!(error.to_string().contains(name), "{error}");
            }
        }
    }
    let half = |name: &str, share: f64| {
        let bytes = fs::read(file(name)).unwrap();
        let path = scratch(&format!("half_{name}"));
        fs::write(&path, &bytes[..(bytes.len() as f64 * share) as usize]).unwrap();
        read_samples(&path, &InputSpec::default()).unwrap_err().to_string()
    };
    assert!(half("named.csv", 0.5).contains("cut short at sample 7: line 9"), "{}", half("named.csv", 0.5));
    assert!(half("matrix.npy", 0.5).contains("cut short at sample"), "{}", half("matrix.npy", 0.5));
    for name in ["units_in_names.npz", "columns.mat", "counts.mat", "groups.h5", "version73.mat"] {
        assert!(half(name, 0.5).contains("cut short"), "{}", half(name, 0.5));
    }
}

/// Bytes turned at random: an answer or an error, in bounded memory.
#[test]
fn damaged_files() {
    let mut random = wingbeat::math::Random::new(11);
    for name in ALL {
        let bytes = fs::read(file(name)).unwrap();
        let path = scratch(&format!("damaged_{name}"));
        for _ in 0..100 {
            let mut bytes = bytes.clone();
            for _ in 0..4 {
                let at = random.between(0.0, bytes.len() as f64) as usize;
                bytes[at] = random.between(0.0, 256.0) as u8;
            }
            fs::write(&path, &bytes).unwrap();
            let _ = take(&path);
        }
    }
}
