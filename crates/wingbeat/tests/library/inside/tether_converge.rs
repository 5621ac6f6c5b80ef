use wingbeat_config::inside::{ladder, observed_order};

#[test]
fn known_orders_are_observed() {
    for counts in [[8, 16, 32], [6, 12, 24], [3, 5, 9]] {
        for order in [0.5, 1.0, 2.0, 4.0] {
            let values = counts.map(|n: usize| 0.7 - 0.3 * (n as f64).powf(-order));
            assert!((observed_order(counts, values, 1.0).unwrap() - order).abs() < 1e-6);
        }
    }
    assert_eq!(observed_order([8, 16, 32], [1.0, 2.0, 1.5], 1.0), None);
    assert_eq!(observed_order([8, 16, 32], [1.0; 3], 1.0), None);
}

#[test]
fn levels_end_at_what_is_allowed() {
    assert_eq!(ladder(16, true, 3), [8, 16, 32]);
    assert_eq!(ladder(24, false, 3), [6, 12, 24]);
    assert_eq!(ladder(3, true, 3), [3, 4, 6]);
}
