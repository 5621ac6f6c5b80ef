use std::cell::Cell;
use std::ops::ControlFlow;

use wingbeat_config::inside::{DescentPoint, Ended, Landscape, Slopes, descend};

/// The banana's valley (Rosenbrock 1960) in shares of [-2, 2]^2, above a line that cuts off its lowest point.
struct Valley;

fn place(x: &[f64]) -> [f64; 2] {
    [4.0 * x[0] - 2.0, 4.0 * x[1] - 2.0]
}

impl Landscape for Valley {
    type More = ();
    fn look(&self, x: &[f64], _: &DescentPoint<()>) -> Option<DescentPoint<()>> {
        let [a, b] = place(x);
        let objective = (1.0 - a).powi(2) + 10.0 * (b - a * a).powi(2);
        Some(DescentPoint { objective, limits: vec![a + b - 1.0], more: () })
    }
    fn slopes(&self, x: &[f64], _: &mut DescentPoint<()>) -> Option<Slopes> {
        let [a, b] = place(x);
        let (by_a, by_b) = (-2.0 * (1.0 - a) - 40.0 * a * (b - a * a), 20.0 * (b - a * a));
        Some(Slopes { objective: vec![4.0 * by_a, 4.0 * by_b], limits: vec![vec![4.0, 4.0]] })
    }
}

#[test]
fn a_descent_ends_on_the_limit_at_the_lowest_point() {
    let none = DescentPoint { objective: 0.0, limits: Vec::new(), more: () };
    let start = vec![0.3, 0.8];
    let seen = Valley.look(&start, &none).unwrap();
    let found = descend(&Valley, start, seen, 200, &mut |_, _| ControlFlow::Continue(())).unwrap();
    assert_eq!(found.ended, Ended::Converged);
    let [a, b] = place(&found.x);
    // On a + b = 1: -2 (1 - a) + 20 (1 - a - a^2) (-1 - 2 a) = 0 at a = .61825...
    let condition = |a: f64| -2.0 * (1.0 - a) - 20.0 * (1.0 - a - a * a) * (1.0 + 2.0 * a);
    assert!((a + b - 1.0).abs() < 1e-4 && condition(a).abs() < 0.2, "{a} {b} {}", condition(a));
}

/// Where nothing is to be gained.
struct Plain;

impl Landscape for Plain {
    type More = ();
    fn look(&self, _: &[f64], _: &DescentPoint<()>) -> Option<DescentPoint<()>> {
        panic!("no step is worth a try")
    }
    fn slopes(&self, _: &[f64], _: &mut DescentPoint<()>) -> Option<Slopes> {
        Some(Slopes { objective: vec![0.0], limits: Vec::new() })
    }
}

#[test]
fn a_descent_counts_the_steps_that_it_tries() {
    let seen = DescentPoint { objective: 1.0, limits: Vec::new(), more: () };
    let found = descend(&Plain, vec![0.5], seen, 200, &mut |_, _| ControlFlow::Continue(())).unwrap();
    assert_eq!((found.ended, found.iterations), (Ended::Converged, 0));
}

/// A slope that ends at half of its range, beyond which there is nothing.
struct Cliff;

impl Landscape for Cliff {
    type More = ();
    fn look(&self, x: &[f64], _: &DescentPoint<()>) -> Option<DescentPoint<()>> {
        (x[0] <= 0.5).then(|| DescentPoint { objective: -x[0], limits: Vec::new(), more: () })
    }
    fn slopes(&self, _: &[f64], _: &mut DescentPoint<()>) -> Option<Slopes> {
        Some(Slopes { objective: vec![-1.0], limits: Vec::new() })
    }
}

#[test]
fn a_descent_that_comes_to_an_edge_has_found_no_minimum() {
    let seen = DescentPoint { objective: -0.3, limits: Vec::new(), more: () };
    let found = descend(&Cliff, vec![0.3], seen, 200, &mut |_, _| ControlFlow::Continue(())).unwrap();
    assert!(
        found.ended == Ended::NoSlopes && !found.ended.is_minimum() && found.x[0] > 0.45,
        "{:?}",
        found.x
    );
}

/// Powell's circle (Maratos 1978): of 2 (a^2 + b^2 - 1) - a on the unit circle, whose every full step raises both the objective and what
/// is missed. In shares of [-1.5, 1.5]^2; counts where it was looked.
struct Circle(Cell<usize>);

fn on_plane(x: &[f64]) -> [f64; 2] {
    [3.0 * x[0] - 1.5, 3.0 * x[1] - 1.5]
}

impl Landscape for Circle {
    type More = ();
    fn look(&self, x: &[f64], _: &DescentPoint<()>) -> Option<DescentPoint<()>> {
        self.0.set(self.0.get() + 1);
        let [a, b] = on_plane(x);
        let off = a * a + b * b - 1.0;
        Some(DescentPoint { objective: 2.0 * off - a, limits: vec![off, -off], more: () })
    }
    fn slopes(&self, x: &[f64], _: &mut DescentPoint<()>) -> Option<Slopes> {
        let [a, b] = on_plane(x);
        let limit = vec![6.0 * a, 6.0 * b];
        let back = limit.iter().map(|slope| -slope).collect();
        Some(Slopes { objective: vec![12.0 * a - 3.0, 12.0 * b], limits: vec![limit, back] })
    }
}

#[test]
fn a_step_along_a_curved_limit_is_corrected() {
    let circle = Circle(Cell::new(0));
    let none = DescentPoint { objective: 0.0, limits: Vec::new(), more: () };
    let start: Vec<f64> = [2.0_f64.cos(), 2.0_f64.sin()].iter().map(|c| (c + 1.5) / 3.0).collect();
    let seen = circle.look(&start, &none).unwrap();
    let found = descend(&circle, start, seen, 200, &mut |_, _| ControlFlow::Continue(())).unwrap();
    assert_eq!(found.ended, Ended::Converged);
    let [a, b] = on_plane(&found.x);
    assert!((a - 1.0).abs() < 1e-6 && b.abs() < 1e-3, "{a} {b}");
    // Without the correction it creeps along the circle, in 109 iterations to b = .005.
    assert!(found.iterations < 30 && circle.0.get() < 60, "{} {}", found.iterations, circle.0.get());
}
