//! Nonlinear programs of Hock & Schittkowski 1981 (Lecture Notes in Economics
//! and Mathematical Systems 187), each from its published start.

use crate::{Case, ComparisonRow, Error};
use std::ops::ControlFlow;
use wingbeat::math::Scalar;
use wingbeat::ocp::interior_point::{Options, SolveStatus, solve};
use wingbeat::ocp::nlp::{Dense, Functions};
use wingbeat::plant::Channel;

const SOURCE: &str = "Hock & Schittkowski 1981";
const INF: f64 = f64::INFINITY;

/// A program: its start, its optimum, limits, objective and constraints.
macro_rules! program {
    ($name:ident: $start:expr, $optimum:expr, limits $limits:expr, rows $rows:expr,
     $x:ident => $objective:expr, $g:ident: $constraints:block) => {
        struct $name;
        impl $name {
            fn row() -> Result<Vec<ComparisonRow>, Error> {
                compare(stringify!($name), &$name, &$start, $optimum)
            }
        }
        impl Functions for $name {
            fn variables(&self) -> Vec<Channel> {
                let [low, high] = $limits;
                (1..=$start.len()).map(|i| Channel::limited(format!("x{i}"), "", "", low, high)).collect()
            }
            fn constraints(&self) -> Vec<Channel> {
                let rows: &[[f64; 2]] = &$rows;
                let channel =
                    |(i, r): (usize, &[f64; 2])| Channel::limited(format!("g{}", i + 1), "", "", r[0], r[1]);
                rows.iter().enumerate().map(channel).collect()
            }
            fn objective<S: Scalar>(&self, $x: &[S]) -> S {
                $objective
            }
            fn constrain<S: Scalar>(&self, $x: &[S], $g: &mut [S]) {
                $constraints
            }
        }
    };
}

/// Relative distance (absolute below 1) of the optimum found from the published one.
fn compare<F: Functions>(
    name: &str,
    functions: &F,
    start: &[f64],
    optimum: f64,
) -> Result<Vec<ComparisonRow>, Error> {
    let mut quiet = |_: &_| ControlFlow::Continue(());
    let solution = solve(&mut Dense::new(functions), start, &Options::default(), &mut quiet);
    if solution.status != SolveStatus::Solved {
        return Err(Error::NoAnswer(solution.status.to_string()));
    }
    let value = (solution.objective - optimum).abs() / optimum.abs().max(1.0);
    let metric = format!("objective, relative; {} iterations", solution.iterations);
    Ok(vec![ComparisonRow::judged(&format!("nlp.{name}"), SOURCE, &metric, value, 1e-6, "")])
}

program!(HS6: [-1.2, 1.0], 0.0, limits [-INF, INF], rows [[0.0, 0.0]],
    x => (-x[0] + 1.0).squared(),
    g: { g[0] = (x[1] - x[0] * x[0]) * 10.0; });

program!(HS7: [2.0, 2.0], -3.0_f64.sqrt(), limits [-INF, INF], rows [[4.0, 4.0]],
    x => (x[0] * x[0] + 1.0).ln() - x[1],
    g: { g[0] = (x[0] * x[0] + 1.0).squared() + x[1] * x[1]; });

program!(HS14: [2.0, 2.0], 9.0 - 2.875 * 7.0_f64.sqrt(), limits [-INF, INF], rows [[-1.0, INF], [-1.0, -1.0]],
x => (x[0] - 2.0).squared() + (x[1] - 1.0).squared(),
g: {
    g[0] = -(x[0] * x[0]) * 0.25 - x[1] * x[1];
    g[1] = x[0] - x[1] * 2.0;
});

program!(HS35: [0.5, 0.5, 0.5], 1.0 / 9.0, limits [0.0, INF], rows [[-INF, 3.0]],
    x => {
        let [a, b, c] = [x[0], x[1], x[2]];
        (a * a + b * b) * 2.0 + c * c + a * b * 2.0 + a * c * 2.0 - a * 8.0 - b * 6.0 - c * 4.0 + 9.0
    },
    g: { g[0] = x[0] + x[1] + x[2] * 2.0; });

program!(HS71: [1.0, 5.0, 5.0, 1.0], 17.0140173, limits [1.0, 5.0], rows [[25.0, INF], [40.0, 40.0]],
x => x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2],
g: {
    g[0] = x[0] * x[1] * x[2] * x[3];
    g[1] = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3];
});

program!(HS76: [0.5, 0.5, 0.5, 0.5], -4.681818181, limits [0.0, INF],
rows [[-INF, 5.0], [-INF, 4.0], [1.5, INF]],
x => {
    let [a, b, c, d] = [x[0], x[1], x[2], x[3]];
    a * a + c * c + (b * b + d * d) * 0.5 - a * c + c * d - a - b * 3.0 + c - d
},
g: {
    let [a, b, c, d] = [x[0], x[1], x[2], x[3]];
    g[0] = a + b * 2.0 + c + d;
    g[1] = a * 3.0 + b + c * 2.0 - d;
    g[2] = b + c * 4.0;
});

program!(HS100: [1.0, 2.0, 0.0, 4.0, 0.0, 1.0, 1.0], 680.6300573, limits [-INF, INF],
rows [[-INF, 127.0], [-INF, 282.0], [-INF, 196.0], [-INF, 0.0]],
x => {
    let fourth = |x: S| x.squared().squared();
    (x[0] - 10.0).squared() + (x[1] - 12.0).squared() * 5.0 + fourth(x[2])
        + (x[3] - 11.0).squared() * 3.0 + fourth(x[4]) * x[4].squared() * 10.0
        + x[5].squared() * 7.0 + fourth(x[6]) - x[5] * x[6] * 4.0 - x[5] * 10.0 - x[6] * 8.0
},
g: {
    g[0] = x[0].squared() * 2.0 + x[1].squared().squared() * 3.0 + x[2] + x[3].squared() * 4.0 + x[4] * 5.0;
    g[1] = x[0] * 7.0 + x[1] * 3.0 + x[2].squared() * 10.0 + x[3] - x[4];
    g[2] = x[0] * 23.0 + x[1].squared() + x[5].squared() * 6.0 - x[6] * 8.0;
    g[3] = x[0].squared() * 4.0 + x[1].squared() - x[0] * x[1] * 3.0 + x[2].squared() * 2.0
        + x[5] * 5.0 - x[6] * 11.0;
});

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "nlp.HS6", quick: true, run: HS6::row },
    Case { id: "nlp.HS7", quick: true, run: HS7::row },
    Case { id: "nlp.HS14", quick: true, run: HS14::row },
    Case { id: "nlp.HS35", quick: true, run: HS35::row },
    Case { id: "nlp.HS71", quick: true, run: HS71::row },
    Case { id: "nlp.HS76", quick: true, run: HS76::row },
    Case { id: "nlp.HS100", quick: true, run: HS100::row },
];
