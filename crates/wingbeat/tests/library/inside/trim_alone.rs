use wingbeat_config::inside::{RobotTrim, STALLED, next};
use wingbeat_config::{Document, TrimSummary};
use wingbeat_judge::Status;

#[test]
fn an_orbit_beyond_the_limits_of_the_search_is_off_target() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/any/single_12g.toml");
    let trim = RobotTrim::new(Document::file(file.as_ref()).unwrap(), &[], 0.0).unwrap();
    let judged = |power: f64, stalled: f64| {
        let mut summary = TrimSummary {
            status: Status::Ok,
            power_w_kg: Some(power),
            stall_fraction_20: Some(stalled),
            frequency_hz: Some(5.0),
            ..TrimSummary::default()
        };
        trim.keeps_its_limits(&mut summary);
        (summary.status, summary.reason.unwrap_or_default())
    };
    assert_eq!(judged(200.0, STALLED), (Status::Ok, String::new()));
    let (status, reason) = judged(288.0, 0.355);
    assert_eq!(status, Status::OffTarget);
    assert!(reason.contains("the power is 288 W/kg, allowed is 200"), "{reason}");
    assert!(reason.contains("0.35") && !reason.contains("frequency"), "{reason}");
}

/// Of a gait within the limits at 151 W/kg the search goes on to the orbit of 71 that lies beyond them, and to no dearer one.
#[test]
fn a_gait_that_keeps_its_limits_is_not_the_last_that_is_searched() {
    assert_eq!(next(&[160.0, 71.0, 90.0], None, 0), Some(0));
    assert_eq!(next(&[200.0, 90.0, 71.0], Some((0.0, 151.0)), 1), Some(2));
    assert_eq!(next(&[200.0, 90.0], Some((0.0, 80.0)), 2), None);
    assert_eq!(next(&[71.0, 90.0], Some((0.3, 60.0)), 1), Some(0));
    assert_eq!(next(&[71.0], Some((0.3, 60.0)), 2), None);
    assert_eq!(next(&[], None, 0), None);
}
