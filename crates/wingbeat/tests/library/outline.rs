//! Outlines in files.

use std::fs;
use std::path::{Path, PathBuf};
use wingbeat::scenario::{Document, Scenario, TetherCase};

const CASE: &str = r#"
name = "plate"
wing.planform = { file = "outline.csv", unit = "mm", x = "aft" }
body.nose_up_deg.constant = 4.0
wind = { speed_m_s = 1.0, density_kg_m3 = 1.225 }
aero.law = "linear"
time = { frequency_hz = 0.5, cycles = 1, steps_per_cycle = 16 }
"#;
/// The outline of the paper's robot as a drawing has it.
const OUTLINE: &str = "\
# root first
arc,leading_edge,trailing_edge
0,-63.5,95.6
20.7,-63.5,95.6
70.7,-76.5,111
79.2,-80.7,115
154.7,-118,-17.05
202.7,-101,-81
";
/// The same in `robots/aerobat_paper.toml`.
const BY_HAND: [[f64; 3]; 6] = [
    [0.0, 0.0635, -0.0956],
    [0.0207, 0.0635, -0.0956],
    [0.0707, 0.0765, -0.111],
    [0.0792, 0.0807, -0.115],
    [0.1547, 0.118, 0.01705],
    [0.2027, 0.101, 0.081],
];

fn folder(name: &str, files: &[(&str, &str)]) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("wingbeat-outline-{}-{name}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    files.iter().for_each(|(name, text)| fs::write(folder.join(name), text).unwrap());
    folder
}

fn case(folder: &Path, overrides: &[&str]) -> Result<TetherCase, String> {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
    let no_tables = &|_: &Path| Err("no tables here".to_owned());
    TetherCase::load(&folder.join("case.toml"), &overrides, no_tables).map_err(|error| error.to_string())
}

#[test]
fn a_drawing_in_millimetres_aft_is_the_outline_written_by_hand() {
    let folder = folder("case", &[("case.toml", CASE), ("outline.csv", OUTLINE)]);
    let read = case(&folder, &[]).unwrap();
    assert_eq!(read.spec.wing.planform.len(), BY_HAND.len());
    for (station, hand) in read.spec.wing.planform.iter().zip(BY_HAND) {
        let found = [station.arc_m, station.leading_edge_m, station.trailing_edge_m];
        assert!(found.iter().zip(hand).all(|(a, b)| (a - b).abs() <= 1e-12), "{found:?}, not {hand:?}");
    }
    // A station may be overridden, and the way of the file.
    let wider = case(&folder, &["wing.planform[5].arc_m=0.21"]).unwrap();
    assert_eq!(wider.spec.wing.planform[5].arc_m, 0.21);
    let refused = case(&folder, &["wing.planform.unit=m", "wing.planform.x=forward"]).unwrap_err();
    assert!(
        refused.contains("outline.csv:3: wing.planform[0].leading_edge_m = -63.5: allowed is ahead"),
        "{refused}"
    );
    // What is kept needs no file.
    let kept = read.kept(|_| String::new()).unwrap();
    assert!(!kept.contains("outline.csv") && kept.contains("0.0635"), "{kept}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_robot_with_its_outline_in_a_file_is_the_robot() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = fs::read_to_string(root.join("robots/aerobat_paper.toml")).unwrap();
    let (before, rest) = text.split_once("planform = [").unwrap();
    let (_, after) = rest.split_once("\n]").unwrap();
    let robot =
        format!("{before}planform = {{ file = \"shapes/outline.csv\", unit = \"mm\", x = \"aft\" }}{after}");
    let folder = folder("robot", &[("robot.toml", &robot)]);
    fs::create_dir_all(folder.join("shapes")).unwrap();
    fs::write(folder.join("shapes/outline.csv"), OUTLINE).unwrap();
    let glider = root.join("scenarios/banking_turn.toml");
    let load = |robot: &Path| {
        let robot = format!("robot={}", robot.display());
        Scenario::load(&glider, &[robot]).unwrap().spec.robot
    };
    let (own, shipped) = (load(&folder.join("robot.toml")), load(&root.join("robots/aerobat_paper.toml")));
    let stations = |robot: &wingbeat::robot::RobotSpec| robot.wing.as_ref().unwrap().planform.clone();
    assert_eq!(stations(&own).len(), 6);
    for (a, b) in stations(&own).iter().zip(stations(&shipped)) {
        assert!((a.arc_m - b.arc_m).abs() <= 1e-12 && (a.leading_edge_m - b.leading_edge_m).abs() <= 1e-12);
        assert!((a.trailing_edge_m - b.trailing_edge_m).abs() <= 1e-12);
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_file_that_is_no_outline_is_refused_by_line_key_and_value() {
    let long = format!("arc,leading_edge,trailing_edge\n{}", "0,1,0\n".repeat(20_000));
    let files = [
        ("case.toml", CASE),
        ("outline.csv", OUTLINE),
        ("back.csv", "arc,leading_edge,trailing_edge\n0,-1,1\n2,-1,1\n1,-1,1\n"),
        ("word.csv", "arc,leading_edge,trailing_edge\n0,-1,1\nroot,-1,1\n"),
        ("long.csv", long.as_str()),
    ];
    let folder = folder("refused", &files);
    for (overrides, said) in [
        (["wing.planform.file=back.csv"], "back.csv:4: wing.planform[2].arc_m = 0.001: allowed is more than"),
        (
            ["wing.planform.file=word.csv"],
            "word.csv:3: wing.planform[1].arc = root: allowed is a finite number",
        ),
        (["wing.planform.file=long.csv"], "long.csv:10002: wing.planform = 0,1,0: allowed is at most 10000"),
        (["wing.planform.file=none.csv"], "wing.planform.file"),
        (["wing.planform.file=/dev/zero"], "not a regular file"),
        (["wing.planform.unit=furlong"], "wing.planform.unit"),
        (["wing.planform.way=aft"], "unknown key wing.planform.way"),
    ] {
        // Paths of overrides are seen from the working folder.
        let text = overrides[0]
            .replace("file=", &format!("file={}/", folder.display()))
            .replace(&format!("{}//", folder.display()), "/");
        let error = case(&folder, &[&text]).unwrap_err();
        assert!(error.contains(said), "{text}: {error}\nnot: {said}");
    }
    let gone =
        Document::text("case", &CASE.replace("outline.csv", "gone.csv")).unwrap().merged(&[], &|_, _| None);
    let error = gone.unwrap_err().to_string();
    assert!(
        error.contains("case:3: wing.planform.file = \"gone.csv\": allowed is a file that can be read"),
        "{error}"
    );
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_layer_of_an_old_drawing_has_its_name() {
    let square = "LWPOLYLINE 8 Flügel 70 1 10 0 20 0 10 0 20 10 10 -1 20 10 10 -1 20 0";
    let old: Vec<u8> = drawing(4, &[square]).chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let case_text = CASE.replace(
        "\"outline.csv\", unit = \"mm\", x = \"aft\"",
        "\"wing.dxf\", x = \"aft\", layer = \"Flügel\"",
    );
    let folder = folder("old", &[("case.toml", &case_text)]);
    fs::write(folder.join("wing.dxf"), old).unwrap();
    assert_eq!(case(&folder, &[]).unwrap().spec.wing.planform.len(), 2);
    fs::remove_dir_all(folder).unwrap();
}

/// A drawing of entities, each `KIND code value code value ...`, in the unit with that code.
fn drawing(unit: u8, entities: &[&str]) -> String {
    let header = format!("0 SECTION 2 HEADER 9 $INSUNITS 70 {unit} 0 ENDSEC 0 SECTION 2 ENTITIES");
    let all = header
        + &entities.iter().map(|entity| format!(" 0 {entity}")).collect::<String>()
        + " 0 ENDSEC 0 EOF";
    all.split_whitespace().map(|word| format!("{word}\n")).collect()
}

/// The outline as a contour, aft to the right and the span upward, its middle at (10, -5).
fn contour() -> String {
    let leading = BY_HAND.iter().map(|[arc, edge, _]| [-edge, *arc]);
    let trailing = BY_HAND.iter().rev().map(|[arc, _, edge]| [-edge, *arc]);
    let corner = |[x, y]: [f64; 2]| format!(" 10 {} 20 {}", x * 1e3 + 10.0, y * 1e3 - 5.0);
    format!("LWPOLYLINE 8 wing 70 1{}", leading.chain(trailing).map(corner).collect::<String>())
}

/// The outline that a drawing gives a case.
fn drawn(name: &str, text: &str, keys: &str) -> Result<Vec<[f64; 3]>, String> {
    let case_text =
        CASE.replace("\"outline.csv\", unit = \"mm\", x = \"aft\"", &format!("\"wing.dxf\"{keys}"));
    let folder = folder(&format!("dxf-{name}"), &[("case.toml", &case_text), ("wing.dxf", text)]);
    let read = case(&folder, &[]);
    fs::remove_dir_all(folder).unwrap();
    read.map(|case| {
        case.spec.wing.planform.iter().map(|s| [s.arc_m, s.leading_edge_m, s.trailing_edge_m]).collect()
    })
}

#[test]
fn a_contour_in_a_drawing_is_the_outline_written_by_hand() {
    let line = "LINE 8 ribs 10 0 20 0 11 5 21 5";
    let of_wing = ", x = \"aft\", layer = \"wing\", origin = [10.0, -5.0]";
    let found = drawn("hand", &drawing(4, &[&contour(), line, "TEXT 8 wing 1 left"]), of_wing).unwrap();
    assert_eq!(found.len(), BY_HAND.len());
    for (station, hand) in found.iter().zip(BY_HAND) {
        assert!(station.iter().zip(hand).all(|(a, b)| (a - b).abs() <= 1e-12), "{station:?}, not {hand:?}");
    }
    // The same in pieces in any order and direction, in inches, the span to the right.
    let pieces = [
        "LINE 10 4 20 -1 11 4 21 1",
        "LINE 10 0 20 2 11 0 21 -2",
        "POLYLINE 70 0 0 VERTEX 10 0 20 2 0 VERTEX 10 2 20 1 0 VERTEX 10 4 20 1 0 SEQEND",
        "LINE 10 4 20 -1 11 0 21 -2",
    ];
    let found = drawn("pieces", &drawing(1, &pieces), ", span = \"x\"").unwrap();
    let inch = 0.0254;
    let expected = [[0.0, 2.0, -2.0], [2.0, 1.0, -1.5], [4.0, 1.0, -1.0]].map(|s| s.map(|v| v * inch));
    assert_eq!(found.len(), 3);
    for (station, hand) in found.iter().zip(expected) {
        assert!(station.iter().zip(hand).all(|(a, b)| (a - b).abs() <= 1e-12), "{station:?}, not {hand:?}");
    }
    // Half an ellipse, open at the root, ends in a point: its area is that of the ellipse, less its straight pieces.
    let ellipse = "ELLIPSE 10 0 20 0 11 0 21 300 40 0.2 41 -1.5707963267948966 42 1.5707963267948966";
    let found = drawn("ellipse", &drawing(0, &[ellipse]), ", unit = \"mm\"").unwrap();
    let area: f64 =
        found.windows(2).map(|w| 0.5 * (w[1][0] - w[0][0]) * (w[0][1] - w[0][2] + w[1][1] - w[1][2])).sum();
    let whole = 0.5 * std::f64::consts::PI * 0.3 * 0.06;
    assert!((area / whole - 1.0).abs() < 2e-4, "{area}, not {whole}");
    let tip = found.last().unwrap();
    assert!((tip[0] - 0.3).abs() < 1e-12 && (tip[1] - tip[2] - 0.0012).abs() < 1e-9, "{tip:?}");
    // A step of an edge takes a ten-thousandth of the span.
    let stepped = "LWPOLYLINE 70 1 10 0 20 0 10 0 20 10 10 -1 20 10 10 -1 20 5 10 -2 20 5 10 -2 20 0";
    let found = drawn("step", &drawing(6, &[stepped]), "").unwrap();
    assert_eq!(found.len(), 4, "{found:?}");
    assert!((found[2][0] - 5.001).abs() < 1e-12 && found[2][2] == -1.0 && found[1][2] == -2.0, "{found:?}");
}

#[test]
fn a_drawing_that_is_no_outline_is_refused_by_line_key_and_value() {
    let square = "LWPOLYLINE 70 1 10 0 20 0 10 0 20 10 10 -1 20 10 10 -1 20 0";
    let circle = "CIRCLE 8 hole 10 50 20 50 40 3";
    let back = "LWPOLYLINE 70 1 10 0 20 0 10 0 20 10 10 -1 20 4 10 -2 20 10 10 -2 20 0";
    let flat = "LWPOLYLINE 70 1 10 0 20 0 10 0 20 10";
    let crossed = "LWPOLYLINE 70 1 10 0 20 0 10 -1 20 10 10 0 20 10 10 -1 20 0";
    let bulges = format!("LWPOLYLINE 70 0{}", " 10 0 20 0 42 1".repeat(600));
    let nan = "LINE 10 nan 20 0 11 1 21 1";
    let huge = "LINE 10 1e300 20 0 11 1 21 1";
    for (name, text, keys, said) in [
        (
            "unit",
            drawing(0, &[square]),
            "",
            "wing.dxf:1: wing.planform.unit = not given: allowed is m, cm, mm or in",
        ),
        ("two", drawing(4, &[square]), ", unit = \"m\"", "wing.dxf:7: wing.planform.unit = m: allowed is mm"),
        (
            "feet",
            drawing(2, &[square]),
            "",
            "wing.dxf:7: wing.planform.unit = $INSUNITS 2: allowed is 1 (in)",
        ),
        ("none", drawing(4, &[]), "", "lines or curves that make one contour"),
        ("apart", drawing(4, &[square, circle]), "", "`layer` chooses among 0, hole"),
        (
            "layer",
            drawing(4, &[square, circle]),
            ", layer = \"ribs\"",
            "wing.planform.layer = ribs: allowed is a layer",
        ),
        ("off", drawing(4, &[circle]), "", "wing.planform.origin = outline: allowed is the point"),
        ("back", drawing(4, &[back]), "", "turns back along the span at 4"),
        ("block", drawing(4, &["INSERT 2 wing"]), "", "= INSERT: allowed is LINE, LWPOLYLINE"),
        ("nan", drawing(4, &[nan]), "", "wing.planform.file = nan: allowed is a finite number"),
        ("huge", drawing(4, &[huge]), "", "wing.planform.file = 1e300: allowed is a finite number"),
        ("short", drawing(4, &["ARC 10 0 20 0"]), "", "ARC: allowed is ARC with group 40"),
        ("spline", drawing(4, &["SPLINE 71 3 10 0 20 0"]), "", "control points"),
        ("line", drawing(4, &["LINE 10 0 20 0 11 0 21 10"]), "", "its ends lie at 0 and 10 along the span"),
        ("flat", drawing(4, &[flat]), "", "edges that do not meet between root and tip; they do at 0 mm"),
        ("crossed", drawing(4, &[crossed]), "", "have crossed at 10 mm along the span, station 1"),
        (
            "cut",
            drawing(4, &["LWPOLYLINE 70 0 10 0 20 0 10 90 20 50 10 0 20 100"]),
            "",
            "open along the root or the tip; its ends lie at 0 and 100 along the span",
        ),
        (
            "touching",
            drawing(4, &[square, "LWPOLYLINE 8 fold 70 1 10 0 20 0 10 5 20 10 10 9 20 0"]),
            "",
            "this curve of layer 0 is no part of that on line 35 of layer fold; `layer` chooses among 0, fold",
        ),
        ("bulges", drawing(4, &[&bulges]), "", "LWPOLYLINE: allowed is at most 100000 points in a drawing"),
        (
            "text",
            "not a drawing\n".into(),
            "",
            "wing.dxf:1: wing.planform.file = not a drawing: allowed is the group code",
        ),
        ("empty", String::new(), ", unit = \"m\"", "lines or curves that make one contour"),
        ("columns", drawing(4, &[square]), ", columns = [\"a\", \"b\", \"c\"]", "wing.planform.columns"),
    ] {
        let error = drawn(&format!("bad-{name}"), &text, keys).unwrap_err();
        assert!(error.contains(said), "{name}: {error}\nnot: {said}");
    }
    let folder = folder("dxf-csv", &[("case.toml", CASE), ("outline.csv", OUTLINE)]);
    let error = case(&folder, &["wing.planform.layer=a"]).unwrap_err();
    assert!(error.contains("wing.planform.layer = given: allowed is none: only a drawing"), "{error}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn the_coordinates_of_a_section_give_its_zero_lift_angle() {
    // A curved plate with its top of 3 % in the middle: -2 * 0.03 rad.
    let x = |k: u32| 0.5 * (1.0 + (std::f64::consts::PI * f64::from(k) / 100.0).cos());
    let side = |k: u32, up: f64| format!("{} {}\n", x(k), 0.12 * x(k) * (1.0 - x(k)) + up);
    let plate: String =
        (0..=100).map(|k| side(k, 0.001)).chain((0..100).rev().map(|k| side(k, -0.001))).collect();
    let text = CASE
        .replace("\naero.law", "\nwing.section.zero_lift_angle_deg = { airfoil = \"plate.dat\" }\naero.law");
    let files =
        [("case.toml", text.as_str()), ("outline.csv", OUTLINE), ("plate.dat", &format!("plate\n{plate}"))];
    let folder = folder("airfoil", &files);
    let read = case(&folder, &[]).unwrap();
    let angle = read.spec.wing.section.zero_lift_angle_deg.unwrap();
    assert!((angle.to_radians() + 0.06).abs() < 1e-4, "{angle}");
    let kept = read.kept(|_| String::new()).unwrap();
    assert!(!kept.contains("plate.dat") && kept.contains("zero_lift_angle_deg = -3.4"), "{kept}");
    let place = |file: &str| format!("aero.zero_lift_angle_deg.airfoil={}", folder.join(file).display());
    let all = case(&folder, &[&place("plate.dat")]).unwrap();
    assert!((all.spec.aero.zero_lift_angle_deg - angle).abs() < 1e-12);
    let error = case(&folder, &[&place("none.dat")]).unwrap_err();
    assert!(
        error.contains("aero.zero_lift_angle_deg.airfoil") && error.contains("a file that can be read"),
        "{error}"
    );
    let error = case(&folder, &["aero.zero_lift_angle_deg.section=plate.dat"]).unwrap_err();
    assert!(error.contains("aero.zero_lift_angle_deg"), "{error}");
    fs::remove_dir_all(folder).unwrap();
}
