//! Every figure of a made-up turn is drawn, written, and says what it shows.

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use wingbeat::simulate::{Column, Record};
use wingbeat_figures::{Error, Figure, FigureTargets, commands, forces, forces_since, path, states, write};

const SIDES: [(&str, f64); 2] = [("left", 1.0), ("right", -1.0)];

const WING: [(&str, &str); 6] = [
    ("leading", "shoulder"),
    ("leading", "elbow"),
    ("leading", "tip"),
    ("trailing", "shoulder"),
    ("trailing", "elbow"),
    ("trailing", "tip"),
];

fn columns() -> Vec<Column> {
    let plain = [("t", "s", ""), ("roll", "rad", ""), ("roll_reference", "rad", ""), ("pitch", "rad", "")];
    let position = [("yaw", "rad", ""), ("p_WB_x", "m", "W"), ("p_WB_y", "m", "W"), ("p_WB_z", "m", "W")];
    let mut columns: Vec<Column> =
        plain.into_iter().chain(position).map(|(name, unit, frame)| Column::new(name, unit, frame)).collect();
    for (side, _) in SIDES {
        columns.extend(
            [format!("shoulder_{side}"), format!("elbow_{side}")].map(|name| Column::new(name, "rad", "")),
        );
        columns.extend(["shoulder", "elbow"].map(|j| Column::new(format!("torque_{j}_{side}"), "N m", "")));
        for (element, limit) in [("shoulder", 0.3), ("elbow", 0.5)] {
            let command = Column::new(format!("command_{element}_{side}"), "rad", "");
            columns.push(Column { low: -limit, high: limit, ..command });
            columns.push(Column::new(format!("displacement_{element}_{side}"), "rad", ""));
        }
        for (line, joint) in WING {
            let name = format!("{line}_{side}_{joint}");
            columns.extend(["x", "y", "z"].map(|axis| Column::new(format!("{name}_{axis}"), "m", "W")));
        }
    }
    for source in ["circulatory", "added_mass", "profile_drag", "induced_drag", "inertia"] {
        columns.extend(["x", "y", "z"].map(|axis| Column::new(format!("force_{source}_{axis}"), "N", "B")));
    }
    columns
}

fn row(t: f64) -> Vec<f64> {
    let phase = TAU * 3.5 * t;
    let turn = (1.0 - (-(t - 1.0).max(0.0) / 0.4).exp()) * 15_f64.to_radians();
    let yaw = -0.45 * (t - 1.0).max(0.0);
    let (x, y) = if t < 1.0 { (1.5 * t, 0.0) } else { (1.5 - 3.3 * yaw.sin(), -3.3 * (1.0 - yaw.cos())) };
    let reference = if t < 1.0 { 0.0 } else { 15_f64.to_radians() };
    let pitch = -15_f64.to_radians() + 0.06 * phase.cos();
    let z = -0.4 * t + 0.02 * phase.sin();
    let mut row = vec![t, turn + 0.02 * phase.sin(), reference, pitch, yaw, x, y, z];
    for (_, sign) in SIDES {
        let shoulder = 0.1 + 0.95 * phase.cos();
        let elbow = -0.65 - 0.65 * (phase - 1.25 * TAU / 2.0).cos();
        row.extend([shoulder, elbow, 0.0, 0.0]);
        for limit in [0.3, 0.5] {
            let command = (sign * 0.4 * (phase / 3.0).sin() * t / 5.0).clamp(-limit, limit);
            row.extend([command, 0.9 * command]);
        }
        let (forward, lateral) = ([yaw.cos(), yaw.sin()], [-yaw.sin(), yaw.cos()]);
        for edges in [[0.06, 0.07, 0.06], [-0.1, -0.11, 0.02]] {
            let mut point = [x, y, z];
            for (ahead, (length, angle)) in
                edges.into_iter().zip([(0.02, 0.0), (0.05, shoulder), (0.132, shoulder + elbow)])
            {
                for i in 0..2 {
                    point[i] += sign * length * angle.cos() * lateral[i];
                }
                point[2] += length * angle.sin();
                row.extend([point[0] + ahead * forward[0], point[1] + ahead * forward[1], point[2]]);
            }
        }
    }
    for k in 0..15 {
        let k = f64::from(k);
        row.push((0.05 + 0.01 * k) * (phase + 0.4 * k).cos() + 0.02);
    }
    row
}

fn record() -> Record {
    let mut record = Record::new(columns(), 5001).unwrap();
    (0..=5000).for_each(|i| record.append(&row(1e-3 * f64::from(i))));
    record
}

fn folder() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("figures");
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// The drawing as SVG text, once its files are seen to be there.
fn written(folder: &Path, figure: &Figure) -> String {
    write(folder, figure).unwrap();
    let path = folder.join(figure.name);
    let png = fs::read(path.with_extension("png")).unwrap();
    assert_eq!(png[..8], *b"\x89PNG\r\n\x1a\n");
    let width = u32::from_be_bytes(png[16..20].try_into().unwrap());
    assert_eq!(width, 1290);
    fs::read_to_string(path.with_extension("svg")).unwrap()
}

#[test]
fn every_figure_names_its_axes_and_curves() {
    let (record, folder) = (record(), folder());
    let expected: [(Figure, &[&str]); 4] = [
        (
            states(&record, FigureTargets::default()).unwrap(),
            &[
                "roll and pitch [°]",
                "heading [°]",
                "position [m]",
                "elbow angle [°]",
                "time [s]",
                "references",
            ],
        ),
        (commands(&record).unwrap(), &["shoulder regulator [°]", "elbow regulator [°]", "left, response"]),
        (forces(&record).unwrap(), &["to its top [N]", "added mass", "air, total", "0.286 s long"]),
        (
            path(&record, None).unwrap(),
            &[
                "x [m]",
                "y [m]",
                "z [m]",
                "left wing",
                "robot enlarged 2 times about its body, every 0.66 s back from the end",
            ],
        ),
    ];
    for (figure, words) in expected {
        let svg = written(&folder, &figure);
        for word in words {
            assert!(svg.contains(word), "{}: {word}", figure.name);
        }
        assert!(!svg.contains("NaN"), "{}", figure.name);
    }
}

#[test]
fn a_figure_is_the_same_whatever_was_drawn_before_it() {
    let record = record();
    let drawn = || [forces(&record).unwrap().svg(), commands(&record).unwrap().svg()];
    let [forces, others] = drawn();
    assert!(["<clipPath id=\"commands-1\"", "url(#commands-1)"].iter().all(|word| others.contains(word)));
    assert_eq!([forces, others], drawn());
}

#[test]
fn a_missing_column_is_named() {
    let record = Record::new(vec![Column::new("t", "s", "")], 0).unwrap();
    for (outcome, name) in [
        (states(&record, FigureTargets::default()), "roll"),
        (commands(&record), "command_<element>"),
        (forces(&record), "force_<source>_x"),
        (path(&record, None), "p_WB_x"),
    ] {
        assert!(matches!(outcome, Err(Error::Column(column)) if column == name));
    }
}

#[test]
fn a_record_of_one_row_is_refused_or_drawn_but_never_a_panic() {
    let mut record = Record::new(columns(), 1).unwrap();
    record.append(&row(0.0));
    assert!(path(&record, None).is_err());
    assert!(forces(&record).is_err());
    let _ = (states(&record, FigureTargets::default()), commands(&record));
}

/// Of a robot on thrusters what is drawn sums to zero with the inertia, as without them.
#[test]
fn all_forces_that_are_drawn_sum_to_zero() {
    let mut all = columns();
    all.extend(["x", "y", "z"].map(|axis| Column::new(format!("thrust_{axis}"), "N", "B")));
    let mut record = Record::new(all, 1001).unwrap();
    for i in 0..=1000 {
        let mut row = row(1e-3 * f64::from(i));
        let sources = row[row.len() - 15..].to_vec();
        row.extend((0..3).map(|axis| -sources.iter().skip(axis).step_by(3).sum::<f64>()));
        record.append(&row);
    }
    for panel in wingbeat_figures::drawn_forces(&record).unwrap() {
        assert!(panel.iter().any(|(name, _)| name == "thrusters"));
        let parts: Vec<_> = panel.iter().filter(|(name, _)| name != "air, total").collect();
        for i in 0..parts[0].1.len() {
            let sum: f64 = parts.iter().map(|(_, values)| values[i]).sum();
            assert!(sum.abs() < 1e-12, "{sum}");
        }
    }
    assert!(forces(&record).unwrap().svg().contains("thrusters"));
}

/// Forces of a plan are those from its start on; a path of tenths of a second has its times to the millisecond, and does not tell an interval
/// of the one robot that it shows.
#[test]
fn a_short_plan_is_drawn_by_itself() {
    let rows: Vec<Vec<f64>> = (0..=1000).map(|k| row(1e-3 * f64::from(k))).collect();
    let mut record = Record::new(columns(), rows.len()).unwrap();
    rows.iter().for_each(|row| record.append(row));
    let whole = forces(&record).unwrap().svg();
    let plan = forces_since(&record, Some(0.9)).unwrap().svg();
    assert!(
        whole.contains("the last whole cycle") && !plan.contains("cycle") && plan.contains("time [s]"),
        "{plan}"
    );
    assert!(plan.contains(">0.90<") && plan.contains(">0.92<") && plan.contains(">1.00<"), "{plan}");
    let short = record.head(170);
    let text = path(&short, None).unwrap().svg();
    assert!(text.contains(">0.000 s<") && text.contains(">0.169 s<"), "{text}");
    assert!(text.contains(", at the end<") && !text.contains("back from the end"), "{text}");
}
