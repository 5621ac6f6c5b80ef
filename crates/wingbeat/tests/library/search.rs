//! The search of a sweep: candidates that follow from those before, goals, and what is refused.

use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::judge::Status;
use wingbeat::scenario::{CandidateSearch, Document, Scenario, Sweep};
use wingbeat::simulate::Record;

const DRAWS: &str = "[[draws]]\nkey = \"controller.weights.roll\"\nlow = 2.0\nhigh = 8.0\nstart = 5.0\n\
                     [[draws]]\nkey = \"robot.structure.elements[0].high\"\nlow = 0.2\nhigh = 0.4\n\
                     also = [\"-robot.structure.elements[0].low\"]\n";

fn sweep(head: &str, search: &str, draws: &str) -> Result<Sweep, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/paper_turn.toml");
    let text = format!("name = \"search\"\n{head}\n[search]\npopulation = 4\n{search}\n{draws}");
    let scenario = Document::file(&path).map_err(|e| e.to_string())?.set("flight.duration_s=0.05");
    let document = Document::text("search", &text).map_err(|e| e.to_string())?;
    let document = document.put("scenario", scenario).map_err(|e| e.to_string())?;
    Sweep::new(document, &|_| Err("no tables".into())).map_err(|e| e.to_string())
}

/// Goes through all generations that are left, taking the rows of `made` first.
fn all(search: &mut CandidateSearch<'_>, made: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut rows = Vec::new();
    while !search.generation().is_empty() {
        let row = |run: usize| match made.get(run) {
            Some(row) => row.clone(),
            None => search.row(run, || ControlFlow::Continue(())).unwrap().unwrap(),
        };
        let own: Vec<Vec<f64>> = search.generation().map(row).collect();
        assert!(own.iter().all(|row| search.has_row(row)));
        search.tell(own.iter().map(Vec::as_slice));
        rows.extend(own);
    }
    rows
}

#[test]
fn a_search_goes_on_where_it_was_and_its_best_candidate_is_judged() {
    let flights = "flights = [[\"aero.paper.nodes=6\"], [\"aero.paper.nodes=7\"]]\n";
    let goals = "goals = [{ key = \"duration_s\", low = 0.05 }, { key = \"distance_x_m\", low = 1.0, per = 0.1 },\n\
                 { key = \"flight.saturation_fraction\", high = 1.0 }]\nends_within_m = 1.0";
    let sweep = sweep("runs = 6", &format!("{flights}{goals}"), DRAWS).unwrap();
    let rows = all(&mut sweep.search().unwrap(), &[]);
    assert_eq!(rows.len(), 6);
    assert!((rows[0][1] - 5.0).abs() < 1e-12 && (rows[0][2] - 0.3).abs() < 1e-12, "{:?}", rows[0]);
    assert_eq!(sweep.search_after(&rows[..5]).unwrap().unwrap().generation(), 4..6);
    assert!(sweep.search_after(&rows[1..]).unwrap().is_err());
    // Interrupted after three candidates it comes to the same.
    assert_eq!(all(&mut sweep.search().unwrap(), &rows[..3]), rows);
    let search = sweep.search().unwrap();
    let mut foreign = rows[1].clone();
    foreign[1] += 0.1;
    assert!(search.has_row(&rows[1]) && !search.has_row(&foreign) && !search.has_row(&rows[1][1..]));
    let mut record = Record::new(search.columns(), rows.len()).unwrap();
    rows.iter().for_each(|row| record.append(row));
    let found = sweep.searched(&record).unwrap().found;
    assert_eq!((found.candidates, found.flights.len()), (6, 2));
    let goals = &found.flights[1].goals;
    let met: Vec<bool> = goals.iter().map(|goal| goal.3).collect();
    assert_eq!(met, [true, false, true], "{goals:?}");
    // Two flights, each at about 0.04 m of 1 m, in tenths of a metre.
    let cost: f64 = found.flights.iter().map(|f| ((1.0 - f.goals[1].1.unwrap()) / 0.1).powi(2)).sum();
    assert!((found.cost - cost).abs() < 1e-9 && cost > 150.0, "{} {cost}", found.cost);
    let verdict = sweep.verdict(&record);
    assert_eq!(verdict.status, Status::NotFound);
    let missed: Vec<&str> = verdict.warnings.iter().map(|warning| warning.text.as_str()).collect();
    assert!(missed.len() == 2 && missed[1].contains("flight 1, aero.paper.nodes=7"), "{missed:?}");
    let best = search.scenario(&found).unwrap();
    let low = format!("low = {:?}", -found.values[1].1);
    assert!(best.contains("nodes = 6") && best.contains(&low), "{low}");
}

/// Flights that no search judges need what counts as held.
#[test]
fn flights_without_a_hold_are_told_of_the_table() {
    let scenario =
        Document::file(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/paper_turn.toml"));
    let draws = DRAWS.replace("start = 5.0\n", "");
    let document = Document::text("held", &format!("name = \"held\"\nruns = 2\n{draws}")).unwrap();
    let document = document.put("scenario", scenario.unwrap()).unwrap();
    let message = Sweep::new(document, &|_| Err("no tables".into())).map(drop).unwrap_err().to_string();
    assert!(message.contains("hold = missing") && message.contains("roll_within_deg"), "{message}");
}

#[test]
fn what_a_search_cannot_do_is_refused() {
    let goals = "goals = [{ key = \"distance_x_m\", low = 1.0 }]";
    let refused = |head: &str, search: &str, draws: &str| sweep(head, search, draws).map(drop).unwrap_err();
    let (runs, hold) = ("runs = 6", "[hold]\nroll_within_deg = 5.0\npitch_within_deg = 5.0\n");
    let list = "[[draws]]\nkey = \"aero.paper.nodes\"\nvalues = [6, 7]\n";
    let twice = goals.replace(" }]", " }, { key = \"distance_x_m\", high = 2.0 }]");
    let outside = DRAWS.replace("start = 5.0", "start = 9.0");
    for (head, search, draws, key) in [
        (runs, goals, &format!("{DRAWS}{hold}")[..], "hold"),
        ("runs = 6\nlanes = true", goals, DRAWS, "lanes"),
        ("runs = 6\nsampling = \"latin_hypercube\"", goals, DRAWS, "sampling"),
        (runs, "goals = []", DRAWS, "search.goals"),
        (runs, "goals = [{ key = \"distance_x_m\" }]", DRAWS, "search.goals[0].low"),
        (runs, "goals = [{ key = \"distance_x_m\", low = 2.0, high = 1.0 }]", DRAWS, "search.goals[0].low"),
        (runs, "goals = [{ key = \"distance_x_m\", low = nan }]", DRAWS, "search.goals[0].low"),
        (runs, "goals = [{ key = \"distance_x_m\", low = 1.0, per = 0.0 }]", DRAWS, "per"),
        (runs, &format!("{goals}\nends_within_m = 1.0"), DRAWS, "search.ends_within_m"),
        (runs, &format!("{goals}\nspread = 1e300"), DRAWS, "search.spread"),
        (runs, &format!("{goals}\nflights = [[\"aero.nods=6\"]]"), DRAWS, "search.flights[0]"),
        (runs, goals, list, "draws[0].values"),
        (runs, goals, &outside, "draws[0].start"),
        (runs, "goals = [{ key = \"distanse_x_m\", low = 1.0 }]", DRAWS, "search.goals[0].key"),
        (runs, "goals = [{ key = \"aero_preset\", low = 1.0 }]", DRAWS, "search.goals[0].key"),
        (runs, "goals = [{ key = \"path\", low = 1.0 }]", DRAWS, "search.goals[0].key"),
        (runs, "goals = [{ key = \"path.cros_rms_m\", high = 1.0 }]", DRAWS, "search.goals[0].key"),
        (runs, "goals = [{ key = \"flight.altitude\", high = 1.0 }]", DRAWS, "search.goals[0].key"),
        (runs, &twice, DRAWS, "search.goals[1].key"),
        ("", goals, DRAWS, "runs"),
    ] {
        let message = refused(head, search, draws);
        assert!(message.contains(key), "{key}: {message}");
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sweeps/paper_turn_robustness.toml");
    let begun = Document::file(&path).unwrap().set("draws[0].start=1.0");
    let message = Sweep::new(begun, &|_| Err("no tables".into())).map(drop).unwrap_err().to_string();
    assert!(message.contains("draws[0].start"), "{message}");
}

#[test]
fn every_number_of_a_flights_summary_can_be_a_goal() {
    let keys = [
        "duration_s",
        "mean_speed_m_s",
        "height_max_error_m",
        "turn_roll_mean_deg",
        "least_clearance_m",
        "positive_power_w_kg",
        "weight_shares.body",
        "controller.failures",
        "controller.period_s",
        "estimate.height_rms_m",
        "path.cross_rms_m",
        "hover.place_rms_m",
        "lattice.iterations_most",
        "flight.path_angle_deg",
        "trim.power_w_kg",
    ];
    let goals: Vec<String> = keys.iter().map(|key| format!("{{ key = \"{key}\", low = 0.0 }}")).collect();
    sweep("runs = 6", &format!("goals = [{}]", goals.join(", ")), DRAWS).unwrap();
    // What a flight wrote is known too.
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/glider.toml");
    let scenario = Scenario::load(&path, &["flight.duration_s=0.05".into()]).unwrap();
    let told = serde_json::to_value(scenario.fly(|_| ControlFlow::Continue(())).unwrap().summary).unwrap();
    let numbers = told.as_object().unwrap().iter().filter(|(_, value)| value.is_number());
    let goals: Vec<String> = numbers.map(|(key, _)| format!("{{ key = \"{key}\", low = 0.0 }}")).collect();
    assert!(goals.len() > 10, "{goals:?}");
    sweep("runs = 6", &format!("goals = [{}]", goals.join(", ")), DRAWS).unwrap();
}

#[test]
fn the_end_points_of_a_refused_flight_are_not_met() {
    // Each draw alone leaves low below high; the first candidate of both does not, but for the flight that puts low back.
    let draws = "[[draws]]\nkey = \"robot.structure.elements[0].low\"\nlow = -0.3\nhigh = 0.2\nstart = 0.15\n\
                 [[draws]]\nkey = \"robot.structure.elements[0].high\"\nlow = 0.1\nhigh = 0.3\nstart = 0.12\n";
    let search = "flights = [[\"robot.structure.elements[0].low=-0.25\"], []]\n\
                  goals = [{ key = \"duration_s\", low = 0.05 }]\nends_within_m = 1.0";
    let sweep = sweep("runs = 4", search, draws).unwrap();
    let search = sweep.search().unwrap();
    let row = search.row(0, || ControlFlow::Continue(())).unwrap().unwrap();
    let [.., apart, cost] = row[..] else { panic!("{row:?}") };
    assert!(apart.is_nan() && cost >= 3e6, "{row:?}");
    let mut record = Record::new(search.columns(), 1).unwrap();
    record.append(&row);
    assert_eq!(sweep.searched(&record).unwrap().found.ends_apart_m, None);
    let verdict = sweep.verdict(&record);
    assert_eq!(verdict.status, Status::NotFound);
    assert!(verdict.warnings.iter().any(|w| w.text.contains("unknown distance")), "{:?}", verdict.warnings);
}
