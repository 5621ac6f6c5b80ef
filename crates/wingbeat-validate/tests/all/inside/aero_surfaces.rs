use wingbeat_validate::aero_surfaces::*;

#[test]
fn elliptic_loadings_have_prandtls_factors() {
    // Prandtl's table by gap over span.
    for (gap, factor) in [(0.1, 0.655), (0.2, 0.485), (0.3, 0.370), (0.4, 0.290), (0.5, 0.230)] {
        let value = elliptic_interference(gap);
        assert!((value - factor).abs() < 0.006, "{gap}: {value}");
    }
}

#[test]
fn factor_and_downwash_hold_on_other_strips_too() {
    for rows in [biplane().unwrap(), tandem().unwrap()] {
        for row in &rows {
            println!("{} {}", row.id, row.value);
            assert!(row.passes() && row.value < 0.05, "{}: {}", row.id, row.value);
        }
    }
}
