use wingbeat_config::inside::{RobotTrim, STALLED};
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
