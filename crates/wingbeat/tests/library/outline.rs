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
