//! The search of gaits: what it finds is better, keeps to its limits, and flies; and what cannot be searched is refused.

use std::ops::ControlFlow;
use std::path::Path;

use wingbeat::scenario::{ConfigError, Scenario, Sweep, SweepOf, TrimProgress};
use wingbeat::simulate::Record;

fn scenario(overrides: &[&str]) -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/cruise_20g.toml");
    let coarse = "trim.step_s=1e-3";
    let overrides: Vec<String> =
        [&[coarse], overrides].concat().iter().map(|text| (*text).to_owned()).collect();
    Scenario::load(&path, &overrides).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_search_finds_a_gait_that_takes_less_power_within_its_limits() {
    let search = "trim.search={goal='power', limits={frequency_hz=6.2, clearance_m=0.004}, iterations=4, vary=[\
                  {key='trim.speed_m_s', low=3.4, high=4.4}, \
                  {key='robot.links[2].driven.harmonics[0].amplitude_rad', low=0.6, high=0.9}]}";
    let faster = ["trim.speed_m_s=4.1", search];
    let own = scenario(&faster[..1]);
    let scenario = scenario(&faster);
    let go_on = |_: TrimProgress| ControlFlow::Continue(());
    let before = own.trim(&mut { go_on }).unwrap().summary.power_w_kg.unwrap();
    let search = scenario.gait_search().unwrap().unwrap();
    let row = search.row(0, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(search.has_row(&row) && search.row(0, &mut |_| ControlFlow::Break(())).is_none());
    let bits = |row: &[f64]| row.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&search.row(0, &mut |_| ControlFlow::Continue(())).unwrap()), bits(&row));
    let mut record = Record::new(search.columns(), 1).unwrap();
    record.append(&row);
    let (best, summary) = search.best(&record).unwrap();
    let trimmed = best.trim(&mut { go_on }).unwrap().summary;
    let found = trimmed.power_w_kg.unwrap();
    assert!(summary.kept == 1 && found < before - 0.1, "{before} {found} {summary:?}");
    assert!(trimmed.frequency_hz.unwrap() < 6.2 + 1e-2 && trimmed.least_clearance_m.unwrap() > 0.0039);
    // A cycle in as many steps as the frequency found asks for, not in those of the first gait.
    assert!((record.values("power_w_kg").unwrap()[0] - found).abs() < 1e-3 * found);

    let mut told = [0; 2];
    let whole = scenario.trim(&mut |at| {
        told[usize::from(matches!(at, TrimProgress::Orbit { .. }))] += 1;
        ControlFlow::Continue(())
    });
    let whole = whole.unwrap();
    // On the orbit of the descent, which that found again from the scenario's own equals.
    assert!((whole.summary.power_w_kg.unwrap() / found - 1.0).abs() < 1e-9);
    assert_eq!(whole.summary.search.unwrap().values, summary.values);
    assert_eq!(whole.starts.unwrap().values("objective"), record.values("objective"));
    assert_eq!(
        whole.files.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
        ["orbit.toml", "gains.csv", "robot.toml"]
    );
    assert!(told.iter().all(|count| *count > 0), "{told:?}");
    let stopped = scenario.trim(&mut |_| ControlFlow::Break(())).unwrap();
    assert!(stopped.summary.status == wingbeat::judge::Status::NotFound && stopped.starts.is_none());
}

#[test]
fn rows_that_are_there_are_not_made_again() {
    let search = "trim.search={goal='frequency', limits={}, iterations=1, starts=2, vary=[\
                  {key='trim.speed_m_s', low=3.4, high=4.4}]}";
    let scenario = scenario(&[search]);
    let search = scenario.gait_search().unwrap().unwrap();
    let first = search.row(0, &mut |_| ControlFlow::Continue(())).unwrap();
    let mut kept = Vec::new();
    let mut keep = |row: &[f64]| {
        kept.push(row[0]);
        Ok::<(), ConfigError>(())
    };
    let searched = search.all(vec![first], &mut keep, &mut |_| ControlFlow::Continue(())).unwrap().unwrap();
    assert_eq!((kept, searched.starts.rows()), (vec![1.0], 2));
}

#[test]
fn what_cannot_be_searched_is_refused() {
    let refused = |vary: &str| {
        let search = format!("trim.search={{goal='power', limits={{}}, vary=[{vary}]}}");
        scenario(&[&search]).gait_search().err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert!(refused("{key='robot.links[9].mass_kg', low=0.0, high=1.0}").contains("vary[0].key"));
    assert!(refused("{key='trim.speed_m_s', low=4.0, high=5.0}").contains("vary[0].low"));
    assert!(refused("{key='robot.body.mass_kg', low=-0.1, high=0.1}").contains("vary[0].low"));
    assert!(scenario(&[]).gait_search().unwrap().is_none());
    let weightless = scenario(&[
        "trim.search={goal='payload', limits={}, vary=[{key='trim.speed_m_s', low=3.0, high=5.0}]}",
    ]);
    let message = weightless.gait_search().err().unwrap().to_string();
    assert!(message.contains("trim.search.vary") && message.contains("robot.body.mass_kg"), "{message}");
}

/// Beside a duration that is a whole number of steps is one that the scenario refuses: the search goes nowhere, and says so.
#[test]
fn a_search_that_cannot_step_is_told() {
    let search = "trim.search={goal='power', limits={}, vary=[{key='flight.duration_s', low=1.0, high=5.0}]}";
    let trimmed = scenario(&[search]).trim(&mut |_| ControlFlow::Continue(())).unwrap();
    let told = trimmed.summary.warnings.iter().find(|warning| warning.id == "trim.search_ended").unwrap();
    assert!(told.text.contains("ended after 0 iterations") && told.text.contains("refuses"), "{told:?}");
}

/// Wings that pass through each other in another air of the search are judged.
#[test]
fn a_gait_is_judged_in_all_airs_of_its_search() {
    let search = "trim.search={goal='power', iterations=1, limits={}, airs=[['trim.bank_deg=40']], \
                  vary=[{key='trim.speed_m_s', low=3.0, high=5.0}]}";
    let free = "trim.free=['frequency', 'twist', 'stroke', 'swing']";
    let trimmed = scenario(&[search, free]).trim(&mut |_| ControlFlow::Continue(())).unwrap();
    let summary = &trimmed.summary;
    let elsewhere = summary.search.as_ref().unwrap().least_clearance_m.unwrap();
    assert!(elsewhere < 0.0 && summary.least_clearance_m.unwrap() > 0.0, "{elsewhere}");
    assert_eq!(summary.status, wingbeat::judge::Status::Outside, "{:?}", summary.reason);
    assert!(summary.reason.as_ref().unwrap().contains("trim.search.airs"), "{:?}", summary.reason);
}

#[test]
fn flights_of_a_sweep_that_share_their_regulator_are_those_that_make_their_own() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sweeps/level_20g.toml");
    let brief = ["runs=2", "scenario.flight.duration_s=0.3"].map(String::from);
    let none = |_: &Path| Err(String::new());
    let sweep = Sweep::load(&path, &brief, &none).unwrap_or_else(|e| panic!("{e}"));
    assert!(matches!(sweep.of, SweepOf::Flights(_)));
    let columns = sweep.columns();
    for run in 0..2 {
        let row = sweep.rows(&[run], &none, || ControlFlow::Continue(())).unwrap().rows.remove(0);
        let alone = sweep.scenario(run).unwrap().fly(|_| ControlFlow::Continue(())).unwrap().summary;
        let at = |name: &str| row[columns.iter().position(|c| c.name == name).unwrap()].to_bits();
        assert_eq!(at("distance_x"), alone.distance_x_m.to_bits());
        assert_eq!(at("altitude_change"), alone.altitude_change_m.to_bits());
        assert_eq!(at("least_clearance"), alone.least_clearance_m.unwrap().to_bits());
    }
}
