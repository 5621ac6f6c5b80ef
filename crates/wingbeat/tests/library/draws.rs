//! How a sweep draws its numbers.

use std::path::Path;
use wingbeat::scenario::{Document, ReadTable, Sweep};

fn sweep() -> Sweep {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sweeps/banking_turn_robustness.toml");
    Sweep::load(&path, &[], NO_TABLES).unwrap_or_else(|e| panic!("{e}"))
}

fn ends(sweep: &Sweep, k: usize) -> [f64; 2] {
    let draw = &sweep.draws()[k];
    [draw.low, draw.high].map(|end| end.unwrap_or(f64::NAN))
}

const NO_TABLES: ReadTable = &|_: &Path| Err(String::new());

fn of_case(more: &str) -> Sweep {
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
    let text = format!(
        "name = \"map\"\n{more}\n[[draws]]\nkey = \"time.frequency_hz\"\nlow = 2.0\nhigh = 4.0\n[[draws]]\n\
         key = \"wing.hinges[0].angle_deg.fourier.sin[0]\"\nlow = 10.0\nhigh = 40.0\n"
    );
    let document = Document::text("map", &text).unwrap();
    Sweep::new(document.put("case", Document::file(&case).unwrap()).unwrap(), NO_TABLES).unwrap()
}

#[test]
fn a_grid_has_every_combination_and_a_hypercube_every_part_once() {
    let points = "sampling = \"grid\"\ndraws = [\
         { key = \"time.frequency_hz\", low = 2.0, high = 4.0, points = 3 },\
         { key = \"wind.speed_m_s\", low = 1.0, high = 2.0, points = 2 }]";
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
    let document = Document::text("map", &format!("name = \"map\"\n{points}\n")).unwrap();
    let document = document.put("case", Document::file(&case).unwrap()).unwrap();
    let grid = Sweep::new(document, NO_TABLES).unwrap();
    let values: Vec<Vec<f64>> = (0..grid.runs()).map(|run| grid.values(run)).collect();
    assert_eq!(values, [[2.0, 1.0], [2.0, 2.0], [3.0, 1.0], [3.0, 2.0], [4.0, 1.0], [4.0, 2.0]]);
    assert_eq!(grid.case(3, NO_TABLES).unwrap().spec.wind.speed_m_s, 2.0);
    let tenths =
        "sampling = \"grid\"\ndraws = [{ key = \"wind.speed_m_s\", low = 0.1, high = 0.7, points = 8 }]";
    let document = Document::text("map", &format!("name = \"map\"\n{tenths}\n")).unwrap();
    let tenths =
        Sweep::new(document.put("case", Document::file(&case).unwrap()).unwrap(), NO_TABLES).unwrap();
    assert_eq!((tenths.values(0), tenths.values(7)), (vec![0.1], vec![0.7]));

    let cube = of_case("runs = 20\nsampling = \"latin_hypercube\"\nseed = 3");
    let part = |run: usize, k: usize| {
        let [low, high] = ends(&cube, k);
        ((cube.values(run)[k] - low) / (high - low) * 20.0) as usize
    };
    for k in 0..2 {
        let mut parts: Vec<usize> = (0..20).map(|run| part(run, k)).collect();
        parts.sort_unstable();
        assert_eq!(parts, (0..20).collect::<Vec<_>>());
    }
    let orders: Vec<bool> = (0..20).map(|run| part(run, 0) == part(run, 1)).collect();
    assert!(orders.iter().filter(|same| **same).count() < 10);
}

#[test]
fn whole_numbers_are_drawn_from_a_grid_of_them() {
    let drawn = |sampling: &str| {
        let key = "key = \"time.steps_per_cycle\", low = 32.0, high = 96";
        let text = format!("name = \"steps\"\n{}", sampling.replace("KEY", key));
        let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
        let document = Document::text("steps", &text).unwrap();
        Sweep::new(document.put("case", Document::file(&case).unwrap()).unwrap(), NO_TABLES)
    };
    let grid = drawn("sampling = \"grid\"\ndraws = [{ KEY, points = 3 }]").unwrap();
    assert_eq!(grid.case(1, NO_TABLES).unwrap().spec.time.steps_per_cycle, 64);
    for other in ["sampling = \"grid\"\ndraws = [{ KEY, points = 4 }]", "runs = 3\ndraws = [{ KEY }]"] {
        let message = drawn(other).unwrap_err().to_string();
        assert!(message.contains("time.steps_per_cycle"), "{message}");
    }
}

#[test]
fn lists_are_drawn_by_their_values() {
    let drawn = |draws: &str| {
        let text = format!("name = \"laws\"\nruns = 12\nsampling = \"latin_hypercube\"\n{draws}");
        let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
        let document = Document::text("laws", &text).unwrap();
        Sweep::new(document.put("case", Document::file(&case).unwrap()).unwrap(), NO_TABLES)
    };
    let laws = "draws = [{ key = \"aero.law\", values = [\"linear\", \"stall\", \"lev\"] }, \
                { key = \"aero.full.strips\", values = [12, 16] }]";
    let sweep = drawn(laws).unwrap();
    let count = |k: usize, v: f64| (0..12).filter(|&run| sweep.values(run)[k] == v).count();
    assert_eq!([0.0, 1.0, 2.0].map(|law| count(0, law)), [4, 4, 4]);
    assert_eq!([12.0, 16.0].map(|strips| count(1, strips)), [6, 6]);
    let stalling = (0..12).find(|&run| sweep.values(run)[0] == 1.0).unwrap();
    assert_eq!(sweep.case(stalling, NO_TABLES).unwrap().spec.aero.law.name(), "stall");
    for (bad, key) in [
        ("draws = [{ key = \"aero.law\", values = [\"linear\", \"still\"] }]", "key"),
        ("draws = [{ key = \"aero.law\", values = [\"linear\", 1.0] }]", "values"),
        ("draws = [{ key = \"aero.law\", values = [\"linear\"], low = 1.0 }]", "low"),
        ("draws = [{ key = \"wind.speed_m_s\", low = 1.0 }]", "high"),
    ] {
        let message = drawn(bad).unwrap_err().to_string();
        assert!(message.contains(&format!("draws[0].{key}")), "{message}");
    }
}

#[test]
fn keys_that_take_the_value_of_a_draw_are_checked_one_by_one() {
    let drawn = |draws: &str| {
        let text = format!("name = \"also\"\nruns = 2\ndraws = [{draws}]");
        let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
        let document = Document::text("also", &text).unwrap();
        Sweep::new(document.put("case", Document::file(&case).unwrap()).unwrap(), NO_TABLES).map(drop)
    };
    let speed = "{ key = \"wind.speed_m_s\", low = 1.0, high = 2.0 }";
    let with = |also: &str| speed.replace(" }", &format!(", also = [{also}] }}"));
    drawn(&with("\"time.frequency_hz\"")).unwrap();
    let words = "{ key = \"aero.law\", values = [\"stall\", \"lev\"], also = [\"-aero.preset\"] }";
    for (bad, key) in [
        (words.to_owned(), "draws[0].also[0]"),
        (with("\"-\""), "draws[0].also[0]"),
        (with("\"time.frequency_hz\", \"\""), "draws[0].also[1]"),
        (with("\"wind.speed_m_s\""), "draws[0].also[0]"),
        (with("\"time.frequency_hz\", \"-time.frequency_hz\""), "draws[0].also[1]"),
        (format!("{}, {speed}", with("\"time.frequency_hz\"")), "draws[1].key"),
        (with("\"time.frequency_hz\", \"time.frequenzy_hz\""), "draws[0].also[1]"),
        (with("\"-time.frequency_hz\""), "draws[0].also[0]"),
    ] {
        let message = drawn(&bad).unwrap_err().to_string();
        assert!(message.contains(key), "{bad}: {message}");
    }
}

#[test]
fn draws_lie_in_their_ranges_and_belong_to_their_flight() {
    let sweep = sweep();
    let later = sweep.values(41);
    for run in 0..50 {
        for (k, value) in sweep.values(run).into_iter().enumerate() {
            let [low, high] = ends(&sweep, k);
            assert!((low..=high).contains(&value), "{} = {value}", sweep.draws()[k].key);
        }
    }
    assert_eq!(sweep.values(41), later);
    assert_ne!(sweep.values(42), later);
}

#[test]
fn the_flown_robot_differs_and_the_known_one_does_not() {
    let sweep = sweep();
    let (a, b) = (sweep.scenario(0).unwrap(), sweep.scenario(1).unwrap());
    assert_eq!(a.model().mass(), b.model().mass());
    assert!(a.robot().mass() != b.robot().mass());
}

#[test]
fn a_range_for_a_whole_number_asks_for_values() {
    let of = |draw: &str| {
        let text = format!("name = \"map\"\nruns = 3\n[[draws]]\nkey = \"aero.full.strips\"\n{draw}\n");
        let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
        let document = Document::text("map", &text).unwrap();
        Sweep::new(document.put("case", Document::file(&case).unwrap()).unwrap(), NO_TABLES)
    };
    let refused = of("low = 5.0\nhigh = 9.0").err().unwrap().to_string();
    assert!(
        refused.contains("draws[0].low = 5.0: allowed is values = [..] in place of a range"),
        "{refused}"
    );
    assert!(refused.contains("aero.full.strips is a whole number"), "{refused}");
    assert!(of("values = [5, 7, 9]").is_ok());
}

/// What a sweep lists under `set` is written in the sweep, so that files in it are sought from there and errors name its line.
#[test]
fn files_that_overrides_of_a_sweep_name_lie_beside_it() {
    let folder = std::env::temp_dir().join(format!("wingbeat-draws-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("sweeps")).unwrap();
    std::fs::write(folder.join("mine.toml"), "\"surfaces.wing.cd0\" = 0.041\n").unwrap();
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/glide.toml");
    let file = folder.join("sweeps/of_fit.toml");
    let load = |numbers: &str| {
        let text = format!(
            "name = \"of_fit\"\nscenario = {scenario:?}\nruns = 2\nset = [\n  \"flight.duration_s=0.1\",\n  \"robot.numbers={numbers}\",\n]\n\
             hold = {{ roll_within_deg = 5.0, pitch_within_deg = 10.0 }}\n[[draws]]\nkey = \"start.phase_rad\"\nlow = 0.0\nhigh = 1.0\n"
        );
        std::fs::write(&file, text).unwrap();
        Sweep::load(&file, &[], NO_TABLES).map_err(|error| error.to_string())
    };
    let sweep = load("../mine.toml").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(sweep.scenario(0).unwrap().spec.robot.numbers["surfaces.wing.cd0"], 0.041);
    // What is kept of it needs no file.
    assert!(!sweep.resolved.contains("mine.toml"), "{}", sweep.resolved);
    let told = load("../none.toml").map(drop).unwrap_err();
    assert!(
        told.contains("of_fit.toml:6: ") && told.contains("robot.numbers") && told.contains("none.toml"),
        "{told}"
    );
    assert!(!told.contains("--set"), "{told}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A sweep of a case that draws a fit of two numbers and a held one.
fn of_fit(uncertainty: &str, more: &str) -> Result<Sweep, String> {
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
    let text = format!(
        "name = \"fit\"\nruns = 4000\nseed = 2\n{more}\n[[draws]]\nkey = \"wind.speed_m_s\"\nlow = 1.0\nhigh = 2.0\n\
         [[draws]]\nkey = \"numbers\"\n[draws.fit]\n\"surfaces.wing.cd90\" = 1.9\n\"surfaces.wing.cd0\" = 0.06\n\
         \"surfaces.wing.added_mass_scale\" = 0.9\n{uncertainty}\n"
    );
    let document = Document::text("fit", &text).unwrap();
    let document = document.put("case", Document::file(&case).unwrap()).unwrap();
    Sweep::new(document, NO_TABLES).map_err(|error| error.to_string())
}

const UNCERTAINTY: &str = "uncertainty = { of = [\"surfaces.wing.cd0\", \"surfaces.wing.added_mass_scale\"], \
     standard_error = [0.01, 0.05], correlation = [[1.0, -0.8], [-0.8, 1.0]] }";

#[test]
fn a_fit_is_drawn_with_its_errors_and_correlations() {
    let sweep = of_fit(UNCERTAINTY, "").unwrap_or_else(|e| panic!("{e}"));
    let keys: Vec<&str> = sweep.draws().iter().map(|draw| draw.key.as_str()).collect();
    let of =
        ["wind.speed_m_s", "numbers.\"surfaces.wing.cd0\"", "numbers.\"surfaces.wing.added_mass_scale\""];
    assert_eq!(keys, of);
    let drawn: Vec<Vec<f64>> = (0..sweep.runs()).map(|run| sweep.values(run)).collect();
    let mean = |of: &dyn Fn(&[f64]) -> f64| drawn.iter().map(|x| of(x)).sum::<f64>() / drawn.len() as f64;
    let by = |k: usize, (value, error): (f64, f64)| move |x: &[f64]| (x[k] - value) / error;
    let (drag, mass) = (by(1, (0.06, 0.01)), by(2, (0.9, 0.05)));
    // Deviations of a mean of 4000 are 0.016, of a variance 0.022.
    assert!(mean(&drag).abs() < 0.06 && mean(&mass).abs() < 0.06);
    assert!(
        (mean(&|x| drag(x).powi(2)) - 1.0).abs() < 0.09 && (mean(&|x| mass(x).powi(2)) - 1.0).abs() < 0.09
    );
    assert!((mean(&|x| drag(x) * mass(x)) + 0.8).abs() < 0.08);
    assert_eq!(sweep.values(17), sweep.values(17));
    // A run has what was drawn, and what the fit held.
    let case = sweep.case(5, NO_TABLES).unwrap();
    let given = |name: &str| case.spec.numbers.get(name).copied();
    let values = sweep.values(5);
    assert_eq!(given("surfaces.wing.cd0"), Some(values[1]));
    assert_eq!(given("surfaces.wing.added_mass_scale"), Some(values[2]));
    assert_eq!(given("surfaces.wing.cd90"), Some(1.9));
    // The sweep as it is kept draws the same.
    let kept = sweep.kept(NO_TABLES, |path| path.display().to_string()).unwrap();
    let again = Sweep::new(Document::text("kept", &kept).unwrap(), NO_TABLES).unwrap();
    assert_eq!(again.values(5), values);
}

/// Shares of 4000 draws beyond quantiles of Student's distribution (Abramowitz & Stegun 1964, table 26.10).
#[test]
fn a_fit_of_few_cycles_is_drawn_by_student_s_distribution() {
    let freedom = |v: &str| UNCERTAINTY.replace(" }", &format!(", degrees_of_freedom = {v} }}"));
    let beyond = |uncertainty: &str, quantile: f64| -> [f64; 2] {
        let sweep = of_fit(uncertainty, "").unwrap_or_else(|e| panic!("{e}"));
        let runs = sweep.runs();
        let off = |run: usize| {
            let values = sweep.values(run);
            [(values[1] - 0.06) / 0.01, (values[2] - 0.9) / 0.05]
        };
        let misses: Vec<[f64; 2]> = (0..runs).map(off).collect();
        [0, 1].map(|k| misses.iter().filter(|miss| miss[k].abs() > quantile).count() as f64 / runs as f64)
    };
    for (v, quantile, share) in [
        ("6", 1.943, 0.1),
        ("6", 2.447, 0.05),
        ("6", 3.707, 0.01),
        ("30", 2.042, 0.05),
        ("30.0", 2.750, 0.01),
    ] {
        // Three standard errors of a share of 4000.
        let within = 3.0 * (share * (1.0 - share) / 4000.0_f64).sqrt();
        for found in beyond(&freedom(v), quantile) {
            assert!((found - share).abs() < within, "{v}: {found} beyond {quantile}, {share} expected");
        }
    }
    // Of the normal distribution 1.43 in 100 lie beyond that quantile of 6 degrees of freedom.
    for found in beyond(UNCERTAINTY, 2.447) {
        assert!((found - 0.0144).abs() < 0.006, "{found}");
    }
    for v in ["2.9", "-1", "0"] {
        let told = of_fit(&freedom(v), "").expect_err("refused");
        assert!(
            told.contains("draws[1].fit.uncertainty.degrees_of_freedom")
                && told.contains("a number from 3 on"),
            "{told}"
        );
    }
}

#[test]
fn a_fit_that_cannot_be_drawn_is_refused() {
    let of = |uncertainty: &str, more: &str| of_fit(uncertainty, more).expect_err("refused");
    let refused = [
        (of("", ""), "draws[1].fit.uncertainty"),
        (of(&UNCERTAINTY.replace("0.01,", "-0.01,"), ""), "standard_error[0] = -0.01"),
        (of(&UNCERTAINTY.replace("[0.01, ", "[0.01, 0.1, "), ""), "as many of standard_error"),
        (of(&UNCERTAINTY.replace("-0.8]", "0.8]"), ""), "the same both ways"),
        (of(&UNCERTAINTY.replace("-0.8", "-1.8"), ""), "no eigenvalue below 0"),
        (of(&UNCERTAINTY.replace("[0.01, ", "[0.2, "), ""), "2 standard errors off"),
        (of(&UNCERTAINTY.replace("wing.cd0", "wing.cd00"), ""), "names of numbers that the fit gives"),
        (of(UNCERTAINTY, "sampling = \"latin_hypercube\""), "a fit has no range to divide"),
        (
            of(
                &format!(
                    "{UNCERTAINTY}\n[[draws]]\nkey = \"numbers.\\\"surfaces.wing.cd0\\\"\"\nlow = 0.1\nhigh = 0.2"
                ),
                "",
            ),
            "a key that is drawn once",
        ),
    ];
    for (message, part) in refused {
        assert!(message.contains(part), "{part}: {message}");
    }
}
