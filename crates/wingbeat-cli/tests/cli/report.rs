//! `wingbeat report` as a user meets it: the page of a run, of several, and what is refused.

use std::fs;
use std::path::Path;

use crate::{entries, root, scratch, wingbeat};

/// Glides for a tenth of a second into `out`.
fn glide(folder: &Path, out: &str, more: &[&str]) {
    let scenario = root().join("scenarios/glider.toml").display().to_string();
    let arguments = ["fly", &scenario, "--set", "flight.duration_s=0.1", "--quiet", "--out", out];
    let output = wingbeat(folder, &[&arguments, more].concat());
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn a_run_has_its_page_and_several_share_one() {
    let folder = scratch("report-page");
    glide(&folder, "a", &[]);
    glide(&folder, "b", &["--no-report"]);
    let page = fs::read_to_string(folder.join("a/report.html")).unwrap();
    assert!(page.contains("<h1>glider</h1>") && page.contains("id=\"bytes\""), "{}", page.len());
    // The only address is the name of SVG.
    assert_eq!((page.matches("http://").count(), page.contains("https://")), (1, false));
    assert!(page.contains("http://www.w3.org/2000/svg"));
    assert!(!folder.join("b/report.html").exists());
    let output = wingbeat(&folder, &["report", "b"]);
    assert!(output.status.success(), "{output:?}");
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.contains("b: flight, ") && told.contains("page: b/report.html"), "{told}");
    // The page belongs to the run now, which may be replaced as a whole.
    assert!(fs::read_to_string(folder.join("b/manifest.json")).unwrap().contains("report.html"));
    glide(&folder, "b", &["--force"]);
    let output = wingbeat(&folder, &["report", "a", "b", "--no-wake", "--no-strips"]);
    assert!(output.status.success(), "{output:?}");
    assert_eq!(entries(&folder), ["a", "b", "report.html"]);
    let both = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(both.contains("<title>a, b</title>"));
}

#[test]
fn a_run_is_animated_and_exported() {
    let folder = scratch("report-export");
    glide(&folder, "a", &["--no-report"]);
    let done = |arguments: &[&str]| {
        let output = wingbeat(&folder, arguments);
        assert!(output.status.success(), "{arguments:?}: {output:?}");
    };
    done(&["animate", "a", "--out", "a.png", "--width", "160", "--rate", "20"]);
    done(&[
        "animate", "a", "--out", "frames", "--width", "160", "--rate", "20", "--view", "behind", "--wide",
    ]);
    assert_eq!(entries(&folder.join("frames")), ["frame_0000.png", "frame_0001.png"]);
    let magic = [
        ("csv", "a.csv", &b"t,phase,"[..]),
        ("npz", "a.npz", b"PK\x03\x04"),
        ("mat", "a.mat", &[0, 0, 0, 0]),
        ("gltf", "a.glb", b"glTF\x02"),
        ("mcap", "a.mcap", b"\x89MCAP0\r\n\x01"),
    ];
    for (format, file, begins) in magic {
        done(&["export", "a", &format!("--{format}")]);
        let bytes = fs::read(folder.join(file)).unwrap();
        assert!(bytes.starts_with(begins), "{file}");
        let again = wingbeat(&folder, &["export", "a", &format!("--{format}")]);
        assert_eq!(again.status.code(), Some(2), "{file} is there");
        done(&["export", "a", &format!("--{format}"), "--force", "--quiet"]);
        assert_eq!(fs::read(folder.join(file)).unwrap(), bytes, "{file}");
    }
    done(&["export", "a", "--vtk"]);
    let frames = entries(&folder.join("a-vtk"));
    let frame = fs::read_to_string(folder.join("a-vtk/frame_00000.vtk")).unwrap();
    assert!(frames.contains(&"frames.vtk.series".into()) && frame.contains("VECTORS force_N double"));
    let listed = fs::read_to_string(folder.join("a-vtk/frames.vtk.series")).unwrap();
    assert_eq!(listed.matches("\"name\"").count() + 1, frames.len(), "each frame is listed");
    let refused = |arguments: &[&str], what: &str| {
        let output = wingbeat(&folder, arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.contains(what), "{arguments:?}: {said}");
    };
    refused(
        &["animate", "a", "--out", "a.png", "--force", "--width", "3840", "--speed", "0.002"],
        "pixels in all",
    );
    refused(&["animate", "a", "--out", "."], "allowed is a folder below");
    refused(&["animate", "a", "--out", "a.webp"], "allowed is FILE.png");
    refused(&["animate", "a", "--out", "b.png", "--speed", "nan"], "--speed NaN");
    refused(&["animate", "a", "--out", "b.png", "--speed", "1e300"], "--speed 1");
    refused(&["animate", "a", "--out", "b.png", "--rate", "0"], "--rate 0");
    refused(&["animate", "a", "--out", "a.png"], "is there already");
    refused(&["animate", "a", "--out", "a"], "allowed is a new or empty folder");
    refused(&["export", "a"], "--csv");
    refused(&["export", "a", "--csv", "--gltf"], "cannot be used");
    refused(&["export", "nowhere", "--gltf"], "no such folder");
    assert!(!folder.join("b.png").exists());
}

#[test]
fn earlier_frames_go_only_for_new_ones_and_other_files_stay() {
    let folder = scratch("report-force");
    glide(&folder, "a", &["--no-report"]);
    let small = ["--width", "160", "--quiet", "--force"];
    let animate = |out: &str, more: &[&str]| {
        wingbeat(&folder, &[&["animate", "a", "--out", out][..], &small, more].concat())
    };
    let export = |more: &[&str]| {
        wingbeat(&folder, &[&["export", "a", "--vtk", "--out", "vtk", "--quiet"][..], more].concat())
    };
    assert!(animate("frames", &["--rate", "40"]).status.success() && export(&[]).status.success());
    let four = ["frame_0000.png", "frame_0001.png", "frame_0002.png", "frame_0003.png"];
    assert_eq!(entries(&folder.join("frames")), four);
    // What cannot be drawn takes nothing away.
    assert_eq!(animate("frames", &["--speed", "0.001"]).status.code(), Some(2));
    fs::rename(folder.join("a/manifest.json"), folder.join("kept")).unwrap();
    assert_eq!(animate("frames", &[]).status.code(), Some(2));
    fs::rename(folder.join("kept"), folder.join("a/manifest.json")).unwrap();
    assert_eq!(entries(&folder.join("frames")), four);
    assert!(animate("frames", &["--rate", "20"]).status.success());
    assert_eq!(entries(&folder.join("frames")), four[..2]);
    assert_eq!(export(&[]).status.code(), Some(2), "there already");
    assert!(export(&["--force"]).status.success());
    for name in ["frame_notes.vtk.bak", "frame_0000.vtk.txt", "frame_.vtk", "frames.vtk"] {
        let own = folder.join("vtk").join(name);
        fs::write(&own, "mine").unwrap();
        let output = export(&["--force"]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.contains(name), "{said}");
        assert_eq!(fs::read_to_string(&own).unwrap(), "mine");
        fs::remove_file(own).unwrap();
    }
    // What a killed command left is written anew.
    fs::create_dir(folder.join(".vtk.partial")).unwrap();
    fs::write(folder.join(".vtk.partial/frame_99999.vtk"), "cut").unwrap();
    assert!(export(&["--force"]).status.success());
    assert!(!folder.join("vtk/frame_99999.vtk").exists());
    assert_eq!(entries(&folder), ["a", "frames", "vtk"]);
}

#[test]
fn what_is_no_run_or_a_damaged_one_is_refused_in_one_message() {
    let folder = scratch("report-refused");
    glide(&folder, "a", &[]);
    let refused = |arguments: &[&str], what: &str| {
        let output = wingbeat(&folder, arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.contains(what), "{arguments:?}: {said}");
        assert_eq!(said.lines().filter(|line| line.starts_with("error")).count(), 1, "{said}");
    };
    refused(&["report", "nowhere"], "no such folder");
    refused(&["report", "a", "--out", "a/summary.json", "--force"], "allowed is a page");
    refused(&["report", "a", "--out", "a/report.html"], "is there already");
    fs::create_dir(folder.join("empty")).unwrap();
    refused(&["report", "empty"], "manifest.json");
    for file in ["summary.json", "record.parquet", "scenario.toml"] {
        let path = folder.join("a").join(file);
        let whole = fs::read(&path).unwrap();
        fs::write(&path, [&whole[..], b" "].concat()).unwrap();
        refused(&["report", "a"], &format!("a/{file}: changed after its run was written"));
        fs::write(&path, whole).unwrap();
    }
    // A run of an earlier version has no checksums.
    let manifest = folder.join("a/manifest.json");
    let mut told: serde_json::Value = serde_json::from_slice(&fs::read(&manifest).unwrap()).unwrap();
    assert!(told.as_object_mut().unwrap().remove("checksums").is_some());
    fs::write(&manifest, told.to_string()).unwrap();
    let damaged = [
        ("summary.json", "{", "damaged"),
        ("summary.json", "[]", "damaged"),
        ("record.parquet", "PAR1", "record.parquet"),
        ("manifest.json", "{\"program\": \"other\"}", "not the manifest"),
    ];
    for (file, text, what) in damaged {
        let whole = fs::read(folder.join("a").join(file)).unwrap();
        fs::write(folder.join("a").join(file), text).unwrap();
        refused(&["report", "a"], what);
        fs::write(folder.join("a").join(file), whole).unwrap();
    }
    fs::write(folder.join("a/scenario.toml"), "name = 3").unwrap();
    let output = wingbeat(&folder, &["report", "a", "--out", "b.html"]);
    assert!(output.status.success(), "the plots need no scenario: {output:?}");
    assert!(fs::read_to_string(folder.join("b.html")).unwrap().contains("no picture in space"));
}

/// Places of the corners of a frame for VTK, m.
fn corners(frame: &str) -> Vec<[f64; 3]> {
    let count = |line: &str| line.split_whitespace().nth(1).unwrap().parse::<usize>().unwrap();
    let mut lines = frame.lines().skip_while(|line| !line.starts_with("POINTS"));
    let points = count(lines.next().unwrap());
    let strips = frame.lines().find(|line| line.starts_with("VERTICES")).map_or(0, count);
    let numbers = |line: &str| line.split_whitespace().map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
    lines.take(points - strips).map(|line| numbers(line).try_into().unwrap()).collect()
}

/// The tip of a bent wing lies where the record says, and a membrane above its chord by its camber.
#[test]
fn wings_are_exported_as_they_bend_and_bulge() {
    let folder = scratch("bent");
    let done = |arguments: &[&str]| {
        let output = wingbeat(&folder, arguments);
        assert!(output.status.success(), "{arguments:?}: {output:?}");
    };
    let case = root().join("cases/pazy.toml").display().to_string();
    let coarse = [
        "aero.full.strips=12",
        "spar.order=1",
        "time.cycles=2",
        "time.steps_per_cycle=16",
        "limits.tether.spar_grid_fraction=1",
    ];
    let coarse: Vec<&str> = coarse.iter().flat_map(|set| ["--set", set]).collect();
    done(&[&["tether", &case, "--out", "bent", "--quiet"], &coarse[..]].concat());
    done(&["export", "bent", "--vtk", "--quiet"]);
    let frame = |run: &str| fs::read_to_string(folder.join(format!("{run}-vtk/frame_00000.vtk"))).unwrap();
    let points = corners(&frame("bent"));
    // Leading edges at the tip and at the root in the middle.
    let (tip, root_z) = (points[0], points[points.len() / 4 * 2][2]);
    let loads = fs::read_to_string(folder.join("bent/loads.csv")).unwrap();
    let place = loads.lines().next().unwrap().split(',').position(|name| name.starts_with("tip_up")).unwrap();
    let up: f64 = loads.lines().nth(1).unwrap().split(',').nth(place).unwrap().parse().unwrap();
    assert!(up > 0.08 && (tip[2] - root_z - up).abs() < 0.03 * up, "{tip:?} {root_z} {up}");
    let flight = root().join("scenarios/sail_glide.toml").display().to_string();
    done(&["fly", &flight, "--set", "flight.duration_s=0.3", "--out", "sail", "--quiet"]);
    done(&["export", "sail", "--vtk", "--quiet"]);
    done(&["export", "sail", "--gltf", "--quiet"]);
    done(&["export", "sail", "--mcap", "--quiet"]);
    let last =
        entries(&folder.join("sail-vtk")).into_iter().filter(|name| name.ends_with(".vtk")).max().unwrap();
    let points = corners(&fs::read_to_string(folder.join("sail-vtk").join(last)).unwrap());
    // Leading edge, three points between, trailing edge, from the tip on.
    let rib = &points[20..25];
    let middle: Vec<f64> = (0..3).map(|k| rib[2][k] - 0.5 * (rib[0][k] + rib[4][k])).collect();
    let chord = (0..3).map(|k| (rib[0][k] - rib[4][k]).powi(2)).sum::<f64>().sqrt();
    let rise = middle.iter().map(|x| x * x).sum::<f64>().sqrt() / chord;
    assert!(rise > 0.003 && rise < 0.2 && middle[2] > 0.0, "{rise} {middle:?}");
    let holds = |file: &str, word: &[u8]| {
        fs::read(folder.join(file)).unwrap().windows(word.len()).any(|at| at == word)
    };
    assert!(holds("sail.glb", b"\"scale\""));
    // What thrusters give is a load as others are.
    let hover = root().join("scenarios/hover_guarded.toml").display().to_string();
    done(&["fly", &hover, "--set", "flight.duration_s=0.02", "--out", "hover", "--quiet"]);
    done(&["export", "hover", "--mcap", "--quiet"]);
    assert!(holds("hover.mcap", b"/wrench/thrust") && !holds("sail.mcap", b"/wrench/thrust"));
    // The four parts of a rib of the sail stand in place of its chord.
    assert!(holds("sail.mcap", b"_rib_0_part_3\"><visual>") && holds("sail.mcap", b"_rib_0\"/>"));
}
