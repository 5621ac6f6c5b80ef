use wingbeat::simulate::Column;
use wingbeat::simulate::Record;
use wingbeat_config::inside::rows;

#[test]
fn rows_end_where_a_size_cannot_be() {
    let column = |name: &str, unit: &str, values: &[f64]| Column {
        values: values.to_vec(),
        ..Column::new(name, unit, "")
    };
    let of = |speed: [f64; 3], power: [f64; 3]| {
        let columns =
            vec![column("phase", "rad", &[1e9; 3]), column("v", "m/s", &speed), column("p", "W", &power)];
        rows(&Record::new(columns, 3).unwrap())
    };
    assert_eq!(of([1.0, 2.0, 3.0], [0.1, -0.2, 0.3]), 3);
    assert_eq!(of([1.0, 2.0, 400.0], [0.1, -3.9e9, 0.3]), 1);
    assert_eq!(of([f64::NAN, 2.0, 3.0], [0.1, 0.2, 0.3]), 0);
}
