//! Wings over a ground.

use wingbeat_validate::aero_ground;

#[test]
fn wings_over_a_ground_have_prandtls_drag() {
    let rows = aero_ground::drag().unwrap();
    assert_eq!(rows.iter().filter(|row| row.limit.is_some()).count(), 6);
    for row in rows {
        assert!(row.passes() && row.value < 0.03, "{}: {}", row.id, row.value);
    }
}
