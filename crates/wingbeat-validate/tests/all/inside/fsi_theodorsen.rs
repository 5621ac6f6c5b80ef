use std::f64::consts::PI;
use wingbeat_validate::fsi::theodorsen::*;
use wingbeat_validate::reference_table;

use nalgebra::Complex;

type C = Complex<f64>;

#[test]
fn the_deficiency_is_that_of_the_table_in_plunge() {
    let table = reference_table!("analytic/theodorsen_plunge_2d.csv").unwrap();
    let (re, im) = (table.column("Re_CL_over_alpha_e").unwrap(), table.column("Im_CL_over_alpha_e").unwrap());
    for (i, k) in table.column("k").unwrap().into_iter().enumerate().filter(|(_, k)| *k <= 4.0) {
        let lift = deficiency(k) * 2.0 * PI + C::new(0.0, PI * k);
        assert!((lift - C::new(re[i], im[i])).norm() < 1e-9 * lift.norm(), "k {k}: {lift}");
    }
}
