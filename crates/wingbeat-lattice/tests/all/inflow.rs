//! Air that comes in over trailing edges.

use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::judge::RunLimits;
use wingbeat::scenario::{Document, TetherCase};
use wingbeat_lattice::course::{CourseRequest, WakeSummary, case};

/// Share of the edges over which the air comes in, the summary, and how far both ways to the force are apart, of a wing with edges swept
/// forward by 42 deg, in the wind `sideslip` deg from the left.
fn seen(sideslip: f64) -> (f64, WakeSummary, f64) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../cases/step.toml");
    let document = Document::file(Path::new(path)).unwrap();
    let document = document
        .set("wing.planform[0].trailing_edge_m=-2.0")
        .set("wing.planform[1].trailing_edge_m=-0.2")
        .set("time.frequency_hz=0.5")
        .set(format!("wind.sideslip_deg={sideslip}"));
    let of = TetherCase::new(document, &|_: &Path| Err("no tables here".to_owned())).unwrap();
    let asked = CourseRequest {
        chordwise: 4,
        spanwise: 12,
        steps: Some(16),
        prescribed: true,
        ..CourseRequest::default()
    };
    let course = case(&asked, &of, &|| ControlFlow::Continue(())).unwrap();
    let watch = course.step(&asked, &mut |_| ControlFlow::Continue(())).unwrap();
    let summary = WakeSummary::new("step", &asked, std::slice::from_ref(&watch), &RunLimits::default());
    (watch.inflow(), summary, watch.apart().unwrap())
}

#[test]
fn it_is_told_where_the_wind_comes_from_their_side() {
    let told =
        |summary: &WakeSummary| format!("{:?}", summary.verdict.warnings).contains("wake.inflow_fraction");
    let (share, summary, apart) = seen(40.0);
    assert!(share == 0.0 && !told(&summary) && apart < 0.2, "{share} {apart}");
    let (share, summary, _) = seen(60.0);
    assert!((share - 0.5).abs() < 1e-12 && told(&summary), "{share}");
}
