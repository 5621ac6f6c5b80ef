use wingbeat_config::inside::{DrawingPoint, read_drawing as read};

/// A file of one entity from its groups, `10 1.5 20 0`.
fn curve(kind: &str, groups: &str) -> Vec<DrawingPoint> {
    let groups: Vec<&str> = groups.split_whitespace().collect();
    let text = format!("0\nSECTION\n2\nENTITIES\n0\n{kind}\n8\nwing\n{}\n0\nENDSEC\n", groups.join("\n"));
    read(&text).unwrap_or_else(|_| panic!("{text}")).curves.remove(0).points
}

#[test]
fn round_curves_lie_where_the_reference_says() {
    let near = |a: DrawingPoint, b: DrawingPoint| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12;
    let arc = curve("ARC", "10 1 20 2 40 3 50 90 51 180");
    assert!(near(arc[0], [1.0, 5.0]) && near(arc[90], [-2.0, 2.0]), "{arc:?}");
    let behind = curve("ARC", "10 1 20 2 40 3 50 90 51 180 230 -1");
    assert!(near(behind[0], [-1.0, 5.0]) && near(behind[90], [2.0, 2.0]));
    // A bulge of 1 is a half circle to the right of its chord, seen along it.
    let half = curve("LWPOLYLINE", "70 0 10 0 20 0 42 1 10 2 20 0");
    assert!(half.len() == 181 && near(half[90], [1.0, -1.0]), "{:?}", half[90]);
    let quarter = curve("ELLIPSE", "10 0 20 0 11 4 21 0 40 0.5 41 0 42 1.5707963267948966");
    assert!(near(quarter[45], [4.0 * 0.5_f64.sqrt(), 2.0 * 0.5_f64.sqrt()]));
    // A quadratic spline with weights 1, sqrt(1/2), 1 is a quarter of a circle.
    let circle =
        "71 2 40 0 40 0 40 0 40 1 40 1 40 1 41 1 41 0.7071067811865476 41 1 10 1 20 0 10 1 20 1 10 0 20 1";
    let quarter = curve("SPLINE", circle);
    assert!(quarter.len() == 33 && quarter.iter().all(|p| (p[0].hypot(p[1]) - 1.0).abs() < 1e-12));
    assert!(near(quarter[0], [1.0, 0.0]) && near(quarter[32], [0.0, 1.0]));
}
