//! Adaptation in flight: flights in unknown air, with and without it.

use std::ops::ControlFlow;

use crate::shipped::scenario;
use crate::{Error, Row};

/// What is asked: height held within, m.
const HELD: f64 = 0.05;
const ADAPTED: &str = "controller.orbit.adapt={crank_s=0.1, missed_s=0.09}";
const STALL: &[&str] = &["mismatch.aero={preset='full', law='stall'}"];

/// The comparisons.
pub(super) fn rows() -> Result<Vec<Row>, Error> {
    let flights: [(&str, &str, &str, &[&str]); 4] = [
        ("untold_stall", "bank30_20g_lev", "law `stall` untold", STALL),
        ("untold_stall_beta", "bank15_beta_lev", "law `stall` untold", STALL),
        (
            "untold_drag",
            "bank30_20g_lev",
            "profile drag x 1.5 and air 18 % thinner untold",
            &["mismatch.profile_drag=1.5", "mismatch.density=0.82"],
        ),
        ("gusts", "bank30_20g_lev", "gusts of 0.5 m/s", &["air.gust_m_s=0.5"]),
    ];
    let mut rows = Vec::new();
    for (name, of, what, untold) in flights {
        let fly = |adapted: &[&str]| -> Result<_, Error> {
            let run = scenario(of, &[untold, adapted].concat())?;
            Ok(run.fly(|_| ControlFlow::Continue(()))?.summary)
        };
        let (with, without) = (fly(&[ADAPTED])?, fly(&[])?);
        let height = |summary: &wingbeat::scenario::Summary| summary.height_max_error_m.unwrap_or(f64::NAN);
        let id = |end: &str| format!("flight.adaptation.{name}.{end}");
        let source = "what is asked of the flight";
        let metric = format!("largest error of the height of {of}, {what}");
        rows.push(Row::judged(
            &id("height"),
            source,
            &format!("{metric}, with adaptation"),
            height(&with),
            HELD,
            "m",
        ));
        rows.push(Row::shown(
            &id("height_without"),
            source,
            &format!("{metric}, without"),
            height(&without),
            "m",
        ));
        let least = with.least_clearance_m.unwrap_or(f64::NAN);
        rows.push(Row::shown(
            &id("clearance"),
            source,
            &format!("least clearance of {of}, {what}, with adaptation (3 mm asked)"),
            least,
            "m",
        ));
    }
    Ok(rows)
}
