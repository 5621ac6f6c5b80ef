//! How findings become a verdict.

use wingbeat_judge::limits::flight::{ALTITUDE, CROSSING, SATURATION};
use wingbeat_judge::{Judge, RunLimits, Status, Verdict, Warning};

#[test]
fn the_worst_finding_is_the_status_and_all_reasons_are_kept() {
    let limits = RunLimits::default();
    let mut judge = Judge::new(&limits);
    assert!(!judge.hold(&ALTITUDE, 6.6) && !judge.hold(&CROSSING, 0.2) && judge.hold(&SATURATION, 0.1));
    let verdict = judge.verdict();
    assert_eq!(verdict.status, Status::Outside);
    let reason = verdict.reason.unwrap();
    assert!(
        reason.starts_with("share of the time in which parts of the robot pass through each other is 0.2"),
        "{reason}"
    );
    assert!(reason.contains("is 6.6 m, allowed is at most 2 m (limits.flight.altitude_m)"), "{reason}");
    assert_eq!(verdict.judged.iter().map(|j| j.met).collect::<Vec<_>>(), [false, false, true]);
}

#[test]
fn a_value_missed_by_a_hair_does_not_read_as_its_limit() {
    let limits = RunLimits::default();
    let mut judge = Judge::new(&limits);
    judge.hold(&ALTITUDE, 2.00004);
    let reason = judge.verdict().reason.unwrap();
    assert!(reason.contains("is 2.00004 m, allowed is at most 2 m"), "{reason}");
}

#[test]
fn a_value_that_is_no_number_breaks_every_limit() {
    let limits = RunLimits::default();
    let mut judge = Judge::new(&limits);
    judge.hold(&SATURATION, f64::NAN);
    let verdict = judge.verdict();
    assert!(verdict.status == Status::OffTarget && verdict.judged[0].value.is_none());
}

#[test]
fn nothing_judged_is_ok_and_warnings_do_not_change_that() {
    let limits = RunLimits::default();
    let mut judge = Judge::new(&limits);
    judge.warn(Warning::new("data.dead", "channel fx is zero throughout").size(0.0).key("channels"));
    let verdict = judge.verdict();
    assert!(verdict.status == Status::Ok && verdict.reason.is_none() && verdict.warnings.len() == 1);
}

#[test]
fn statuses_have_their_names_and_exit_codes() {
    for status in Status::ALL {
        assert_eq!(status.exit_code() == 0, status <= Status::NotJudged);
        assert!(!status.meaning().is_empty() && status.to_string() == status.name());
    }
    assert_eq!(Status::Interrupted.exit_code(), 130);
    assert_eq!(Status::OffTarget.exit_code(), 3);
}

#[test]
fn a_verdict_on_several_is_that_of_the_worst_with_their_names() {
    let limits = RunLimits::default();
    let one = |finds: Option<(Status, &str)>| {
        let mut judge = Judge::new(&limits);
        judge.hold(&SATURATION, 0.1);
        finds.into_iter().for_each(|(status, reason)| judge.find(status, reason));
        judge.warn(Warning::new("fit.rejected", "a fit").key("robot.numbers"));
        judge.verdict()
    };
    let (good, off) = (one(None), one(Some((Status::OffTarget, "it is off"))));
    let broken = one(Some((Status::Failed, "it broke")));
    let all = Verdict::together([("a", &off), ("", &good), ("c", &broken)]);
    assert_eq!((all.status, all.reason.as_deref()), (Status::Failed, Some("c: it broke; a: it is off")));
    assert_eq!((all.judged.len(), all.warnings.len()), (3, 3));
    let of: Vec<Option<&str>> = all.judged.iter().map(|judged| judged.of.as_deref()).collect();
    assert_eq!(of, [Some("c"), Some("a"), None]);
    let texts: Vec<&str> = all.warnings.iter().map(|warning| warning.text.as_str()).collect();
    assert_eq!(texts, ["c: a fit", "a: a fit", "a fit"]);
    assert_eq!(all.warnings[0].key.as_deref(), Some("robot.numbers"));
    let none = Verdict::together(std::iter::empty());
    assert!(none.status == Status::Ok && none.reason.is_none());
}
