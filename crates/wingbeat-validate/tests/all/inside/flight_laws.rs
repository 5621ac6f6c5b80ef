use wingbeat_validate::flight::laws::flown;

#[test]
#[ignore = "long: cargo xtask long tests"]
fn a_gait_without_an_orbit_under_another_law_is_told() {
    assert!(flown("bank30_beta", true).unwrap().is_none());
    let own = flown("bank15_20g_lev", false).unwrap().unwrap();
    let other = flown("bank15_20g_lev", true).unwrap().unwrap();
    let power = |of: &wingbeat::scenario::Summary| of.cost.positive_power_w_kg.unwrap();
    assert!(power(&other) > 1.2 * power(&own));
}
