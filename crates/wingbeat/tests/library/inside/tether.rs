use wingbeat::tether::CycleMean;
use wingbeat_config::inside;

#[test]
fn a_run_that_grew_without_bound_is_far_from_one_that_did_not() {
    let row = |name: &str, mean: f64, high: f64| CycleMean {
        name: name.into(),
        unit: "N".into(),
        mean,
        low: 0.0,
        high,
        mean_change: None,
        amplitude_change: None,
    };
    let change = |one: &[CycleMean], other: &[CycleMean]| inside::change(one, other, [1e-9; 2]);
    let good = [row("force_wind_lift", 1.0, 2.0), row("moment_y", 0.1, 0.2)];
    let near = [row("force_wind_lift", 1.01, 2.0), row("moment_y", 0.1, 0.2)];
    let wild = [row("force_wind_lift", 3e32, 3e33), row("moment_y", 0.1, 0.2)];
    assert!((change(&good, &near).mean - 0.005).abs() < 1e-12);
    assert!(change(&wild, &good).mean > 1e30 && change(&good, &wild).mean > 1e30);
    assert!(change(&good, &[row("force_wind_lift", f64::NAN, 2.0), row("moment_y", 0.1, 0.2)]).mean.is_nan());
    let spiked = [row("force_wind_lift", 1.0, 3.0), row("moment_y", 0.1, 0.2)];
    let apart = change(&good, &spiked);
    assert!((apart.mean, apart.peak) == (0.0, 0.5), "{apart:?}");
    assert!(change(&good, &[row("force_wind_lift", 1.0, f64::NAN), row("moment_y", 0.1, 0.2)]).peak.is_nan());
    // What is rounding has no range beside which its change would count.
    let [none, other] = [3e-17, 2e-16].map(|size| [row("force_wind_lift", size, 2.0 * size)]);
    assert_eq!((change(&none, &other).mean, change(&none, &other).peak), (0.0, 0.0));
}
