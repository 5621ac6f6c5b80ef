use wingbeat::scenario::Sweep;
use wingbeat_validate::flight::draws::*;

#[test]
fn the_shipped_sweeps_are_those_that_are_asked_for() {
    let gust = |sweep: &Sweep| {
        sweep.spec.draws.iter().any(|d| d.key == "air.gust_m_s" && d.values == [toml::Value::Float(0.3)])
    };
    for asked in [LEVEL, BANK15, PASSIVE_LEVEL, PASSIVE_BANK15] {
        let (sweep, hold) = read(asked.sweep).unwrap();
        assert_eq!((sweep.runs(), hold.height_within_m, hold.clearance_m), (200, Some(0.07), 0.003));
        let range = |key: &str, low, high| {
            sweep.spec.draws.iter().any(|d| d.key == key && (d.low, d.high) == (Some(low), Some(high)))
        };
        let five = ["density", "mass", "inertia", "profile_drag", "broadside_drag"];
        assert!(five.iter().all(|key| range(&format!("mismatch.{key}"), 0.9, 1.1)), "{}", asked.sweep);
        assert!(["x", "y", "z"].iter().all(|a| range(&format!("mismatch.com_{a}_m"), -0.002, 0.002)));
        assert!(gust(&sweep), "{}", asked.sweep);
    }
    let (sweep, hold) = read(FIGURE8.sweep).unwrap();
    assert_eq!((sweep.runs(), hold.cross_rms_within_m), (100, Some(0.15)));
    assert!(gust(&sweep));
}
