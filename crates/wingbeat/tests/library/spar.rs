//! Wings that the air bends: spars of a case.

use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use wingbeat::judge::Status;
use wingbeat::plant::Plant;
use wingbeat::robot::LinkSparSpec;
use wingbeat::scenario::{Convergence, Document, StepChange, TetherCase};
use wingbeat::simulate::{Ending, Record};
use wingbeat::tether::{STRAIN, Shape, TetherRun};

fn none(_: &Path) -> Result<Record, String> {
    Err("no table".into())
}

/// No change with other steps.
const SAME: StepChange = StepChange { mean: 0.0, peak: 0.0, power: 0.0 };

fn try_pazy(overrides: &[&str]) -> Result<TetherCase, String> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../cases/pazy.toml");
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).into()).collect();
    TetherCase::load(&path, &overrides, &none).map_err(|error| error.to_string())
}

fn pazy(overrides: &[&str]) -> TetherCase {
    try_pazy(overrides).unwrap()
}

/// A light wing that flaps, on spars of the bending stiffness `bending` N m2.
fn flapper(bending: f64, spar: &str) -> Result<TetherCase, String> {
    let text = format!(
        r#"
name = "flapper"
wing.planform = [
  {{ arc_m = 0.0, leading_edge_m = 0.02, trailing_edge_m = -0.06 }},
  {{ arc_m = 0.2, leading_edge_m = 0.02, trailing_edge_m = -0.06 }},
]
wing.hinges = [{{ name = "shoulder", kind = "flap", arc_m = 0.02, angle_deg.fourier = {{ sin = [30.0] }} }}]
wind = {{ speed_m_s = 3.0, density_kg_m3 = 1.225 }}
aero = {{ law = "linear", full.strips = 12 }}
time = {{ frequency_hz = 4.0, cycles = 3, steps_per_cycle = 64 }}
[spar]
root_m = 0.02
order = 2
damping_s = 1e-3
stations = [
  {{ arc_m = 0.02, bending_n_m2 = {bending}, edge_bending_n_m2 = {edge}, torsion_n_m2 = {bending}, mass_kg_m = 0.02, inertia_kg_m = 1e-5 }},
  {{ arc_m = 0.2, bending_n_m2 = {bending}, edge_bending_n_m2 = {edge}, torsion_n_m2 = {bending}, mass_kg_m = 0.01, inertia_kg_m = 5e-6 }},
]
{spar}
"#,
        edge = 20.0 * bending
    );
    let document = Document::text("flapper", &text).map_err(|error| error.to_string())?;
    TetherCase::new(document.set("aero.preset=full"), &none).map_err(|error| error.to_string())
}

fn run(case: &TetherCase) -> TetherRun {
    let run = case.tether.run(|_| ControlFlow::Continue(()));
    assert_eq!(run.ending, Ending::Complete, "{:?}", run.steady);
    run
}

/// The steps stay in the shape that the search found, and near the one measured, on this coarse grid.
#[test]
fn the_pazy_wing_stays_at_rest_in_the_wind() {
    let case = pazy(&["aero.full.strips=12", "spar.order=1", "time.cycles=2", "time.steps_per_cycle=16"]);
    let run = run(&case);
    let steady = run.steady.as_ref().unwrap();
    assert!(steady.found && steady.least_damped[0] < 0.0, "{steady:?}");
    assert!((steady.tip[0] / 0.1004 - 1.0).abs() < 0.12, "{steady:?}");
    let up = run.loads.values("tip_up").unwrap();
    assert!(up.iter().all(|z| (z - steady.tip[0]).abs() < 1e-7 * steady.tip[0]), "{up:?}");
    // What holds the root carries the lift of the half, less what the weight along the span takes not.
    let force = run.mean("spar_force_z").unwrap();
    let [lift, drag] = ["force_z", "force_x"].map(|name| run.mean(name).unwrap());
    assert!((force + lift).abs() < 1e-3 * lift.abs() && drag.is_finite(), "{force} {lift}");
    let summary = case.summary(&run, Some(SAME), None);
    assert_ne!(summary.verdict.status, Status::NotPeriodic, "{:?}", run.periodicity);
    let spar = summary.spar.unwrap();
    assert!(spar.grid_change.unwrap() < 0.1 && spar.frequencies_hz[0] > 4.0 && spar.frequencies_hz[0] < 6.0);
}

/// Modes whose waves are shorter than a strip grow by a share of their own frequency, however many elements have them.
#[test]
fn fast_modes_of_a_fine_spar_are_no_flutter() {
    let station = |arc: f64| {
        format!(
            "{{ arc_m = {arc}, bending_n_m2 = 2.0, edge_bending_n_m2 = 200.0, torsion_n_m2 = 1.5, mass_kg_m = 0.3, inertia_kg_m = 1e-3 }}"
        )
    };
    for elements in [2, 4] {
        let text = format!(
            r#"
name = "cantilever"
wing.planform = [
  {{ arc_m = 0.0, leading_edge_m = 0.05, trailing_edge_m = -0.05 }},
  {{ arc_m = 1.0, leading_edge_m = 0.05, trailing_edge_m = -0.05 }},
]
body.nose_up_deg.constant = 0.1
wind = {{ speed_m_s = 5.0, density_kg_m3 = 1.225 }}
aero = {{ preset = "full", law = "linear", full.strips = 8 }}
time = {{ frequency_hz = 2.0, cycles = 1, steps_per_cycle = 200 }}
[spar]
elements = {elements}
stations = [{}, {}]
"#,
            station(0.0),
            station(1.0)
        );
        let case = TetherCase::new(Document::text("cantilever", &text).unwrap(), &none).unwrap();
        let run = run(&case);
        let [growth, frequency] = run.steady.as_ref().unwrap().least_damped;
        assert!(growth < 1e-3 * frequency, "{elements} {growth} {frequency}");
        let verdict = case.summary(&run, Some(SAME), None).verdict;
        assert!(
            verdict.judged.iter().any(|row| row.id == "tether.growth_fraction" && row.value.unwrap() < 1e-3)
        );
        assert_eq!(verdict.status, Status::Ok, "{:?}", verdict.reason);
    }
}

/// Goland's wing at a tenth of its size, without damping, in a wind of `speed` m/s on so many strips.
fn goland(strips: usize, speed: f64) -> TetherCase {
    let station = |arc: f64| {
        format!(
            "{{ arc_m = {arc}, torsion_n_m2 = 98.7, bending_n_m2 = 977.0, edge_bending_n_m2 = 97700.0, mass_kg_m = 0.3571, aft_m = 0.018288, inertia_kg_m = 7.446e-4 }}"
        )
    };
    let text = format!(
        r#"
name = "goland"
wing.planform = [
  {{ arc_m = 0.0, leading_edge_m = 0.06035, trailing_edge_m = -0.12253 }},
  {{ arc_m = 0.6096, leading_edge_m = 0.06035, trailing_edge_m = -0.12253 }},
]
wind = {{ speed_m_s = {speed:?}, density_kg_m3 = 1.225 }}
aero = {{ preset = "full", law = "linear", full.strips = {strips} }}
time = {{ frequency_hz = 50.0, cycles = 1, steps_per_cycle = 64 }}
spar = {{ elements = 2, stations = [{}, {}] }}
"#,
        station(0.0),
        station(0.6096)
    );
    TetherCase::new(Document::text("goland", &text).unwrap(), &none).unwrap()
}

/// Fast motions, which air hardly damps, are neither told nor judged: bending with torsion is, which flutters above 147 m/s.
#[test]
fn motions_too_fast_for_the_air_are_no_flutter() {
    let at = |strips: usize, speed: f64| {
        let case = goland(strips, speed);
        let steady = case.tether.spar.as_ref().unwrap().steady(&case.tether);
        let [growth, omega] = steady.least_damped;
        (growth, omega / (2.0 * PI), steady)
    };
    for strips in [6, 12, 24] {
        for speed in [75.0, 140.0] {
            let (growth, hz, steady) = at(strips, speed);
            assert!(growth < -0.1 && hz < 800.0, "{strips} {speed} {growth} {hz}");
            // The loads of the strips do the work of their motion, or these would grow by 1e-3 of their frequency.
            let [growth, omega] = steady.least_damped_fast.unwrap();
            assert!(growth < 5e-5 * omega && omega > 3e3, "{strips} {speed} {growth} {omega}");
        }
    }
    let (growth, hz, _) = at(12, 175.0);
    assert!(growth > 1.0 && (90.0..120.0).contains(&hz), "{growth} {hz}");
    let told = |fast: [f64; 2]| {
        let case = goland(12, 140.0);
        let run = run(&case);
        let steady =
            wingbeat::tether::Steady { least_damped_fast: Some(fast), ..run.steady.clone().unwrap() };
        case.summary(&TetherRun { steady: Some(steady), ..run }, Some(SAME), None).verdict
    };
    let warned = |verdict: &wingbeat::judge::Verdict| -> Option<String> {
        let of = verdict.warnings.iter().find(|warning| warning.id == "tether.fast_growth_fraction");
        of.map(|warning| warning.text.clone())
    };
    let (quiet, loud) = (told([0.1, 3e4]), told([100.0, 3e4]));
    assert!(quiet.status == Status::Ok && loud.status == Status::Ok, "{quiet:?} {loud:?}");
    assert!(warned(&quiet).is_none() && warned(&loud).unwrap().contains("spar.damping_s"), "{loud:?}");
}

/// A stiff spar is the rigid wing: its ringing, which no step resolves, dies away.
#[test]
fn a_stiff_spar_is_a_rigid_wing() {
    for bending in [500.0, 20.0] {
        let stiff = run(&flapper(bending, "").unwrap());
        let mut case = flapper(bending, "").unwrap();
        case.tether.spar = None;
        let rigid = run(&case);
        for name in ["force_wind_lift", "thrust", "power", "torque_shoulder_left"] {
            let [a, b] = [&stiff, &rigid].map(|run| run.last_cycle(name).unwrap());
            let largest = b.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let far = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(far < 2e-3 * largest, "{name} {bending} {}", far / largest);
        }
        assert!(stiff.periodicity.as_ref().unwrap().change < 0.01, "{:?}", stiff.periodicity);
    }
}

/// A soft spar bends as the wing flaps, and repeats.
#[test]
fn a_soft_spar_bends() {
    let soft = run(&flapper(0.02, "").unwrap());
    let up = soft.last_cycle("tip_up").unwrap();
    let swing = up.iter().fold(0.0_f64, |most, z| most.max(z.abs()));
    // At rest under the inertia of wing and air, which grows linearly along the span: 11 w L^4 / (120 E I), w at the tip.
    let acceleration = 30f64.to_radians() * (2.0 * PI * 4.0).powi(2) * 0.2;
    let mass = 0.013 + PI / 4.0 * 1.225 * 0.08 * 0.08;
    let expected = 11.0 * mass * acceleration * 0.18_f64.powi(4) / (120.0 * 0.02);
    assert!(swing > 0.6 * expected && swing < 1.6 * expected, "{swing} {expected}");
    assert!(soft.periodicity.as_ref().unwrap().change < 0.05);
}

#[test]
fn bad_spars_are_refused_with_their_key() {
    let refused = |spar: &str| flapper(0.1, spar).map(drop).unwrap_err();
    let message = refused("masses = [{ arc_m = 0.3, mass_kg = 0.001 }]");
    assert!(message.contains("spar.masses[0].arc_m = 0.3: allowed is 0.02 to 0.2"), "{message}");
    let message = flapper(-0.1, "").map(drop).unwrap_err();
    assert!(message.contains("spar.stations[0].bending_n_m2 = -0.1"), "{message}");
    let set = |key: &str| {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../cases/pazy.toml");
        TetherCase::load(&path, &[key.into()], &none).map(drop).unwrap_err().to_string()
    };
    for (key, said) in [
        ("body.roll_deg.fourier.sin=[3.0]", "body.roll_deg"),
        ("wind.sideslip_deg=3.0", "wind.sideslip_deg"),
        ("spar.order=13", "spar.order = 13"),
        ("spar.elements=60", "coordinates"),
        ("spar.stations[11].arc_m=0.5", "spar.stations[11].arc_m"),
        ("spar.stations[0].couplings_n_m2=[900.0,0.0,0.0]", "positive definite"),
        ("spar.stations[1].mass_kg_m=nan", "spar.stations[1].mass_kg_m"),
        ("spar.stations=[]", "spar.stations"),
    ] {
        let message = set(key);
        assert!(message.contains(said), "{key}: {message}");
    }
}

/// The drawing is made from the coordinates that the run records: its tip lies where the run says, its chords stay as long.
#[test]
fn a_bent_wing_is_drawn_as_it_bends() {
    let case = flapper(0.02, "").unwrap();
    let (tether, run) = (&case.tether, run(&case));
    let strains: Vec<&[f64]> = (0..).map_while(|i| run.loads.values(&format!("{STRAIN}{i}"))).collect();
    assert_eq!(strains.len(), tether.spar.as_ref().unwrap().beam.coordinates());
    assert!(run.means.iter().all(|mean| !mean.name.starts_with(STRAIN)));
    let row = run.loads.rows() - 20;
    let q: Vec<f64> = strains.iter().map(|strain| strain[row]).collect();
    let [t, up, ahead] = ["t", "tip_up", "tip_ahead"].map(|name| run.loads.values(name).unwrap()[row]);
    let arcs = tether.drawn_arcs(12);
    assert!(arcs.windows(2).all(|pair| pair[0] > pair[1]) && arcs[0] == 0.2 && *arcs.last().unwrap() == -0.2);
    let bent = tether.outline(t, &arcs, Shape { spar: &q, ..Shape::default() });
    let flat = tether.outline(t, &arcs, Shape::default());
    let line = |rib: &[wingbeat::math::Vec3; 2]| rib[0] * 0.75 + rib[1] * 0.25;
    let off = (line(&bent.ribs[0]) - line(&flat.ribs[0])).norm();
    // The line at the hinge, 1/4 chord here, is the reference line; its shortening along the span is of second order.
    assert!(up.abs() > 2e-3 && (off / up.hypot(ahead) - 1.0).abs() < 0.1, "{off} {up} {ahead}");
    assert!(bent.ribs.iter().all(|[le, te]| ((*le - *te).norm() - 0.08).abs() < 1e-12));
    let mirrored = (bent.ribs[0][0][1] + bent.ribs.last().unwrap()[0][1]).abs();
    assert!(mirrored < 1e-12 && bent.covered.iter().all(|covered| *covered), "{mirrored}");
}

/// The tip of a cantilever under its own weight, m g L^3/(E I) = 1.256: its deflection by the exact elastica.
#[test]
fn a_wing_droops_by_its_weight_where_the_air_bears_nothing() {
    let station = |arc: f64| {
        format!(
            "{{ arc_m = {arc}, bending_n_m2 = 0.05, edge_bending_n_m2 = 5.0, torsion_n_m2 = 0.05, mass_kg_m = 0.1, inertia_kg_m = 1.5e-5 }}"
        )
    };
    let text = format!(
        r#"
name = "droop"
wing = {{ side = "left", planform = [
  {{ arc_m = 0.0, leading_edge_m = 0.02, trailing_edge_m = -0.02 }},
  {{ arc_m = 0.4, leading_edge_m = 0.02, trailing_edge_m = -0.02 }},
] }}
spar = {{ elements = 2, damping_s = 1e-4, stations = [{}, {}] }}
wind = {{ speed_m_s = 1.0, density_kg_m3 = 1.225 }}
aero = {{ preset = "full", law = "linear", full.strips = 12 }}
time = {{ frequency_hz = 5.0, cycles = 1, steps_per_cycle = 32 }}
"#,
        station(0.0),
        station(0.4)
    );
    let case = TetherCase::new(Document::text("droop", &text).unwrap(), &none).unwrap();
    let run = run(&case);
    let tip = run.loads.values("tip_up").unwrap().last().copied().unwrap();
    assert!((tip + 0.061568).abs() < 2e-5, "{tip}");
}

/// Beyond 80 m/s the wing leaves the shape whose loads are told; a wing that flaps through such a wind is only warned of.
#[test]
fn a_wing_beyond_its_speed_of_flutter_is_outside() {
    let coarse = ["aero.full.strips=12", "spar.order=1", "time.cycles=2", "time.steps_per_cycle=16"];
    let verdict = |more: &[&str]| {
        let case = pazy(&[&coarse, more].concat());
        let steady = case.tether.spar.as_ref().unwrap().steady(&case.tether);
        let run = TetherRun { steady: Some(steady), ..run(&pazy(&coarse)) };
        case.summary(&run, Some(SAME), None).verdict
    };
    let still = verdict(&["wind.speed_m_s=100.0"]);
    assert_eq!(still.status, Status::Outside, "{still:?}");
    assert!(still.reason.as_ref().unwrap().contains("limits.tether.growth_fraction"), "{still:?}");
    assert_eq!(verdict(&[]).status, Status::Ok);
    let blind = {
        let case = pazy(&coarse);
        let mut steady = case.tether.spar.as_ref().unwrap().steady(&case.tether);
        steady.least_damped = [f64::NAN; 2];
        case.summary(&TetherRun { steady: Some(steady), ..run(&case) }, Some(SAME), None).verdict
    };
    assert_eq!(blind.status, Status::NotResolved, "{blind:?}");
    assert!(blind.reason.as_ref().unwrap().contains("no growth of small disturbances"), "{blind:?}");
    let moved = verdict(&["wind.speed_m_s=100.0", "body.heave_m={fourier={sin=[0.001]}}"]);
    assert!(moved.warnings.iter().any(|warning| warning.id == "tether.flutter"), "{moved:?}");
    assert!(moved.judged.iter().all(|judged| judged.id != "tether.growth_fraction"));
    // By the limit of the case.
    let allowed =
        ["wind.speed_m_s=100.0", "body.heave_m={fourier={sin=[0.001]}}", "limits.tether.growth_fraction=10"];
    let moved = verdict(&allowed);
    assert!(moved.warnings.iter().all(|warning| warning.id != "tether.flutter"), "{moved:?}");
}

#[test]
fn a_spar_in_other_units_is_told() {
    let coarse = [
        "aero.full.strips=12",
        "spar.order=1",
        "time.cycles=2",
        "time.steps_per_cycle=16",
        "limits.tether.spar_grid_fraction=1",
        "limits.tether.spar_frequency_fraction=10",
    ];
    let pazy_run = run(&pazy(&coarse));
    let judged = pazy(&coarse[..5]).summary(&pazy_run, Some(SAME), None).verdict;
    assert!(
        judged.warnings.iter().any(|warning| warning.id == "tether.spar_frequency_fraction"),
        "{judged:?}"
    );
    for (set, id, status) in [
        ("spar.ahead_m=7.5", "tether.spar_off_chord", Status::Outside),
        ("spar.stations[3].aft_m=0.5", "tether.spar_off_chord", Status::Outside),
        ("spar.stations[3].inertia_kg_m=0.05", "tether.spar_gyration", Status::Outside),
        ("spar.gravity_m_s2=[0,0,-981]", "tether.spar_gravity_m_s2", Status::Ok),
        ("spar.damping_s=1", "tether.spar_damping_ratio", Status::Ok),
        ("spar.masses=[{ arc_m = 0.5, mass_kg = 50 }]", "tether.spar_lump_fraction", Status::Ok),
        (
            "spar.masses=[{ arc_m = 0.5, mass_kg = 0.1, outboard_m = 39 }]",
            "tether.spar_off_chord",
            Status::Outside,
        ),
        (
            "spar.masses=[{ arc_m = 0.5, mass_kg = 0.1, inertia_kg_m2 = [0.1, 0.1, 0.1] }]",
            "tether.spar_gyration",
            Status::Outside,
        ),
    ] {
        let case = pazy(&[&coarse[..], &[set]].concat());
        let verdict = case.summary(&pazy_run, Some(SAME), None).verdict;
        let held = verdict.judged.iter().find(|judged| judged.id == id).unwrap();
        assert!(!held.met, "{set}: {held:?}");
        assert_eq!(verdict.status, status, "{set}: {verdict:?}");
    }
    let own = pazy(&coarse).summary(&pazy_run, Some(SAME), None).verdict;
    assert!(own.judged.iter().all(|judged| judged.met), "{own:?}");
}

#[test]
fn gravity_to_the_side_is_refused_of_both_halves() {
    let sideways = |side: &str| try_pazy(&["spar.gravity_m_s2=[0,-9.8,0]", &format!("wing.side={side}")]);
    assert!(sideways("left").is_ok());
    let error = sideways("both").unwrap_err();
    assert!(error.contains("spar.gravity_m_s2") && error.contains("wing.side"), "{error}");
}

#[test]
fn a_station_without_mass_is_outside() {
    for (key, outside) in
        [("spar.stations[4].mass_kg_m", true), ("spar.stations[5].inertia_kg_m", true), ("wing.cd0", false)]
    {
        let set = format!("{key}=0");
        // The grid is coarse, and not what is asked here.
        let case = pazy(&[
            "aero.full.strips=12",
            "spar.order=1",
            "time.cycles=2",
            "time.steps_per_cycle=16",
            "limits.tether.spar_grid_fraction=1",
            &set,
        ]);
        let verdict = case.summary(&run(&case), Some(SAME), None).verdict;
        assert_eq!(verdict.status, if outside { Status::Outside } else { Status::Ok }, "{key}: {verdict:?}");
        let told = verdict.reason.is_some_and(|reason| reason.contains("limits.tether.spar_mass_fraction"));
        assert_eq!(told, outside, "{key}");
    }
}

#[test]
fn a_coarse_spar_is_not_resolved() {
    let case = flapper(0.004, "").unwrap();
    let mut run = run(&flapper(0.02, "").unwrap());
    if let Some(steady) = &mut run.steady {
        steady.grid_change = Some(0.3);
    }
    assert_eq!(case.summary(&run, Some(SAME), None).verdict.status, Status::NotResolved);
    // In heave without a load at rest its shape there says nothing.
    if let Some(steady) = &mut run.steady {
        (steady.grid_change, steady.frequency_change) = (Some(0.0), Some([0.05, 0.7]));
    }
    let told = case.summary(&run, Some(SAME), None).verdict;
    assert_eq!(told.status, Status::NotResolved);
    assert!(told.reason.as_ref().unwrap().contains("limits.tether.spar_lowest_fraction"), "{told:?}");
    if let Some(steady) = &mut run.steady {
        (steady.found, steady.grid_change) = (false, None);
    }
    assert_eq!(case.summary(&run, Some(SAME), None).verdict.status, Status::NotResolved);
}

/// One element of order 1 twists and bends evenly: strips and steps alone would not tell.
#[test]
fn convergence_tells_of_a_coarse_spar() {
    let resolved = Document::text("flapper", &flapper(0.01, "").unwrap().resolved).unwrap();
    let table = |spar: &str| {
        let set = ["aero.full.strips=8", "time.steps_per_cycle=24", spar];
        let case = set.iter().fold(resolved.clone(), |document, set| document.set(*set));
        let case = TetherCase::new(case, &none).unwrap();
        let watch = || ControlFlow::Continue(());
        case.converge(&none, &watch, |_| {}).unwrap().unwrap()
    };
    let [coarse, fine] = ["spar.order=1", "spar.order=4"].map(table);
    for table in [&coarse, &fine] {
        assert_eq!((table.cells.len(), table.levels.spar_elements), (10, Some([1, 2])));
        let last = table.cells[9];
        assert_eq!((last.strips, last.steps_per_cycle, last.spar_elements), (16, 48, Some(2)));
        assert!(table.verdict.contains("and 1 to 2 elements of the spar spread by"), "{}", table.verdict);
    }
    let change = |table: &Convergence| {
        let [own, other] = [8, 9].map(|cell| table.cells[cell].mean_power_w);
        (other - own).abs() / own.abs()
    };
    assert!(change(&coarse) > 0.02 && coarse.status == "not_converged", "{}", coarse.verdict);
    assert!(change(&fine) < 1e-3, "{}", fine.verdict);
}

/// Strips beyond 32 are not allowed, so 32 are the finest.
#[test]
fn convergence_says_where_the_own_grid_is_the_finest() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/flap_f2.toml");
    let verdict = |strips: usize| {
        let set =
            [format!("aero.full.strips={strips}"), "time.steps_per_cycle=16".into(), "time.cycles=1".into()];
        let case = TetherCase::load(&file, &set, &none).unwrap();
        let watch = || ControlFlow::Continue(());
        case.converge(&none, &watch, |_| {}).unwrap().unwrap().verdict
    };
    let own = verdict(32);
    assert!(own.contains("8 to 32") || own.contains("16 to 32 strips"), "{own}");
    assert!(
        own.ends_with("aero.full.strips = 32 of the case is the finest, as twice that is not allowed"),
        "{own}"
    );
    assert!(!verdict(8).contains("is the finest"));
}

/// Against 1.875^2 sqrt(E I/(m L^4)) and pi/2 sqrt(G J/(I L^2)) of a uniform cantilever, and the rows `fsi.beam.segments` of chains in a robot.
#[test]
fn few_pieces_bend_and_twist_at_the_frequencies_of_the_page() {
    let spar = |segments| LinkSparSpec {
        length_m: 0.2,
        segments,
        bending_n_m2: 2e-3,
        edge_bending_n_m2: None,
        torsion_n_m2: None,
        mass_kg_m: 0.03,
        ahead_m: 0.0,
        inertia_kg_m: 0.0,
        taper: 1.0,
        damping_s: 0.0,
    };
    let beam = 1.8751041_f64.powi(2) / (2.0 * PI) * (2e-3_f64 / (0.03 * 0.2_f64.powi(4))).sqrt();
    let [bending, twist] = spar(64).frequencies_hz();
    assert!((bending.unwrap() / beam - 1.0).abs() < 1e-4 && twist.is_none());
    for (segments, error) in [(1, 0.393), (2, 0.0608), (3, 0.0261), (4, 0.0145)] {
        let found = spar(segments).frequency_error();
        assert!((found - error).abs() < 2e-3 * (1.0 + error), "{segments}: {found}");
    }
    let twisting = |segments| {
        let twisted = LinkSparSpec { torsion_n_m2: Some(1e-3), inertia_kg_m: 2e-6, ..spar(segments) };
        twisted.frequencies_hz()[1].unwrap()
    };
    let rod = 0.25 / 0.2 * (1e-3_f64 / 2e-6).sqrt();
    for (segments, error) in [(64, 0.0), (1, 0.0997), (2, 0.0255), (3, 0.0114), (4, 0.00641)] {
        let found = twisting(segments) / rod - 1.0;
        assert!((found.abs() - error).abs() < 2e-3, "{segments}: {found}");
    }
}

/// A robot's link with a spar: the pieces weigh what the spar weighs, carry the surface, and raise its tip when they bend.
#[test]
fn a_spar_is_a_chain_of_links_whose_panels_follow() {
    let text = r#"
name = "soft"
body = { mass_kg = 0.01, inertia_kg_m2 = [1e-5, 3e-5, 3e-5] }
[[links]]
name = "arm"
side = "mirrored"
origin_m = [0.0, 0.02, 0.0]
driven = { harmonics = [{ amplitude_rad = 0.5, phase_rad = 0.0 }] }
spar = { length_m = 0.12, segments = 3, bending_n_m2 = 1e-3, torsion_n_m2 = 2e-3, mass_kg_m = 0.02, ahead_m = 0.01, inertia_kg_m = 1e-6, taper = 0.5, damping_s = 1e-4 }
[[surfaces]]
name = "wing"
planform = [
  { arc_m = 0.0, leading_edge_m = 0.02, trailing_edge_m = -0.04 },
  { arc_m = 0.14, leading_edge_m = 0.02, trailing_edge_m = -0.04 },
]
panels = [{ link = "body" }, { link = "arm", from_arc_m = 0.02 }]
[gait.fourier]
frequency_hz = 5.0
"#;
    let spec = Document::text("soft", text).and_then(|d| d.robot()).unwrap();
    let outlines = spec.outlines().unwrap();
    let bounds = [0.02, 0.04, 0.08, 0.12];
    assert!(
        outlines[0].hinges.iter().zip(bounds).all(|(a, b)| (a - b).abs() < 1e-12),
        "{:?}",
        outlines[0].hinges
    );
    let models = outlines.iter().map(|outline| {
        let settings = wingbeat::aero::StripSettings {
            strips: 14,
            hinge_arcs_m: outline.hinges.clone(),
            ..Default::default()
        };
        wingbeat::aero::StripModel::new(&outline.planform, settings).map(wingbeat::aero::Aero::Strip).unwrap()
    });
    let air = wingbeat::robot::Air { density: 1.2, wind: wingbeat::robot::Wind::steady(Default::default()) };
    let robot = wingbeat::robot::Robot::new(&spec, models.collect(), air, 0.0).unwrap();
    // Raising and twisting in three joints of each side.
    // Coordinates and their rates.
    assert_eq!(robot.start_coordinates().len(), 24);
    let numbers = robot.tree();
    let names: Vec<&str> = (0..numbers.links()).map(|i| numbers.name(i)).collect();
    assert!(names.contains(&"arm_bend3_left") && names.contains(&"arm_3_right"), "{names:?}");
    let spar = 2.0 * 0.02 * 0.12 * 0.75;
    assert!((robot.mass() - 0.01 - spar).abs() < 1e-12, "{}", robot.mass());
    let mut spec = spec;
    spec.links[0].spar.as_mut().unwrap().segments = 0;
    assert!(spec.check().unwrap_err().to_string().starts_with("links[0].spar.segments = 0"));
}

/// Weight, centre of mass and inertia about the root of a chain are those of the beam whose mass falls linearly, with any number of pieces.
#[test]
fn a_tapered_spar_weighs_as_its_beam_does() {
    let (length, taper) = (0.2, 0.158);
    for segments in [1, 2, 3, 8] {
        let text = format!(
            r#"
name = "beam"
body = {{ mass_kg = 0.01, inertia_kg_m2 = [1e-5, 3e-5, 3e-5] }}
[[links]]
name = "arm"
spar = {{ length_m = {length}, segments = {segments}, bending_n_m2 = 1e-3, mass_kg_m = 0.03, taper = {taper} }}
[gait.fourier]
frequency_hz = 5.0
"#
        );
        let spec = Document::text("beam", &text).and_then(|d| d.robot()).unwrap();
        let air =
            wingbeat::robot::Air { density: 1.2, wind: wingbeat::robot::Wind::steady(Default::default()) };
        let robot = wingbeat::robot::Robot::new(&spec, Vec::new(), air, 0.0).unwrap();
        let bodies = robot.numbers().bodies;
        let tree = robot.tree();
        // The pieces begin at the joints.
        let begin = |name: &str| match name.strip_prefix("arm_").map(|i| i.parse::<f64>().unwrap()) {
            Some(i) if i > 0.0 => (i - 0.5) * length / segments as f64,
            _ => 0.0,
        };
        let mut moments = [0.0; 3];
        for (i, body) in bodies[1..].iter().enumerate() {
            let y = begin(tree.name(i)) + body.com[1];
            let own = body.moments[0];
            for (moment, of) in moments.iter_mut().zip([body.mass, body.mass * y, body.mass * y * y + own]) {
                *moment += of;
            }
        }
        let whole = 0.03 * length;
        let expected = [
            whole * (1.0 + taper) / 2.0,
            whole * length * (1.0 + 2.0 * taper) / 6.0,
            whole * length * length * (1.0 + 3.0 * taper) / 12.0,
        ];
        for (found, expected) in moments.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{segments}: {moments:?} {expected}");
        }
    }
}

/// A beam as stiff in the plane of the wing as out of it moves alike in both.
#[test]
fn a_spar_bends_both_ways() {
    let text = r#"
name = "beam"
body = { mass_kg = 1e3, inertia_kg_m2 = [1e3, 1e3, 1e3] }
[[links]]
name = "arm"
spar = { length_m = 0.2, segments = 3, bending_n_m2 = 1e-3, edge_bending_n_m2 = 1e-3, mass_kg_m = 0.03, taper = 0.4, damping_s = 1e-3 }
[gait.fourier]
frequency_hz = 5.0
"#;
    let spec = Document::text("beam", text).and_then(|d| d.robot()).unwrap();
    let air = wingbeat::robot::Air { density: 1.2, wind: wingbeat::robot::Wind::steady(Default::default()) };
    let robot = wingbeat::robot::Robot::new(&spec, Vec::new(), air, 0.0).unwrap();
    let (l, tree) = (*robot.layout(), robot.tree());
    let names: Vec<&str> = (0..tree.links()).map(|i| tree.name(i)).collect();
    assert_eq!(names, ["arm", "arm_0", "arm_bend1", "arm_1", "arm_bend2", "arm_2", "arm_bend3", "arm_3"]);
    let rates = |first: usize, angles: [f64; 3]| {
        let mut x = vec![0.0; l.len];
        wingbeat::math::Quat::from_roll_pitch_yaw(0.0, 0.0, 0.0).store_wxyz(&mut x[l.attitude..]);
        for (segment, angle) in angles.into_iter().enumerate() {
            x[l.joints + 2 * segment + first] = angle;
            x[l.joints + 6 + 2 * segment + first] = 3.0 * angle;
        }
        let mut dx = vec![0.0; l.len];
        robot.rates_in_numbers(0.0, &x, &[], &mut dx).unwrap();
        [0, 1, 2].map(|segment| dx[l.joints + 6 + 2 * segment + first])
    };
    let angles = [0.02, -0.01, 0.03];
    // In free fall nothing but the springs loads the pieces.
    let (up, aft): ([f64; 3], [f64; 3]) = (rates(0, angles), rates(1, angles));
    let largest = aft.iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
    assert!(
        largest > 1.0 && up.iter().zip(aft).all(|(up, aft)| (up - aft).abs() < 2e-3 * largest),
        "{up:?} {aft:?}"
    );
    let stiff = robot.adjusted(&[("links.arm.spar.edge_bending_n_m2", 2e-3)]).unwrap();
    let value = |name: &str| stiff.named_numbers().iter().find(|(own, _)| own == name).unwrap().1;
    assert!((value("links.arm.spar.edge_bending_n_m2") - 2e-3).abs() < 1e-15);
    assert!((value("links.arm.spar.bending_n_m2") - 1e-3).abs() < 1e-15);
    assert!((value("links.arm.spar.damping_s") - 1e-3).abs() < 1e-15);
}

/// Scales act as stations do that are stiffer, couplings with them, and are judged and refused as numbers are.
#[test]
fn a_spar_is_scaled_as_its_stations_are() {
    let coupled = |bending: f64, edge: f64, torsion: f64, coupling: f64| {
        let station = |arc: f64| {
            format!(
                "{{ arc_m = {arc}, bending_n_m2 = {bending}, edge_bending_n_m2 = {edge}, torsion_n_m2 = {torsion}, couplings_n_m2 = [{coupling}, 0.0, 0.0], \
                 mass_kg_m = 0.02, inertia_kg_m = 1e-5 }}"
            )
        };
        format!("spar.stations=[{}, {}]", station(0.02), station(0.2))
    };
    let of = |overrides: &[&str]| {
        let flapper = flapper(0.1, "").unwrap();
        let document =
            overrides.iter().fold(Document::text("case", &flapper.resolved).unwrap(), |d, o| d.set(*o));
        TetherCase::new(document, &none).map_err(|error| error.to_string())
    };
    let tip = |case: &TetherCase| case.tether.spar.as_ref().unwrap().steady(&case.tether).tip;
    let (soft, stiff) = (coupled(0.1, 2.0, 0.2, 0.02), coupled(0.2, 1.0, 0.1, 0.02));
    let scales = r#"numbers={"spar.bending_scale"=2.0, "spar.edge_bending_scale"=0.5, "spar.torsion_scale"=0.5, "spar.damping_s"=2e-3}"#;
    let scaled = of(&[&soft, scales]).unwrap();
    let written = of(&[&stiff, "spar.damping_s=2e-3"]).unwrap();
    let adjusted = of(&[&soft]).unwrap();
    let to = [
        ("spar.bending_scale", 2.0),
        ("spar.edge_bending_scale", 0.5),
        ("spar.torsion_scale", 0.5),
        ("spar.damping_s", 2e-3),
    ];
    let adjusted = adjusted.adjusted(&to).unwrap();
    let spar = adjusted.spar.as_ref().unwrap();
    for (a, b) in
        tip(&scaled).iter().zip(tip(&written)).chain(spar.steady(&adjusted).tip.iter().zip(tip(&written)))
    {
        assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{a}, {b}");
    }
    assert_eq!((spar.damping_s, scaled.tether.spar.as_ref().unwrap().damping_s), (2e-3, 2e-3));
    assert!((tip(&of(&[&soft]).unwrap())[0] / tip(&written)[0] - 1.0).abs() > 0.1);
    // A slope at an end of what a number may be asks for none beyond it.
    let short = of(&["time.cycles=1", "time.steps_per_cycle=16", "spar.order=1"]).unwrap();
    let slope = |value: f64| {
        let found = short.differentiated(&[("spar.bending_scale", value)], &["spar.bending_scale"]);
        found.unwrap().unwrap()[0].iter().flatten().map(|slope| slope.abs()).fold(0.0, f64::max)
    };
    let (stiff, middle) = (slope(1e3), slope(2.0));
    assert!(stiff < 1e-3 * middle && middle > 0.0, "{stiff}, {middle}");
    // It is that of a difference of fourth order with steps twenty times as long.
    for key in ["spar.bending_scale", "spar.damping_s"] {
        let at = |value: f64| short.adjusted(&[(key, value)]).unwrap().last_wrenches().unwrap();
        let (value, step) = if key == "spar.damping_s" { (2e-3, 4e-5) } else { (2.0, 0.04) };
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(value + k * step));
        let found = &short.differentiated(&[(key, value)], &[key]).unwrap().unwrap()[0];
        let (mut apart, mut largest) = (0.0_f64, 0.0_f64);
        for (row, found) in found.iter().enumerate() {
            for (k, found) in found.iter().enumerate() {
                let slope = (8.0 * (c[row][k] - b[row][k]) - (d[row][k] - a[row][k])) / (12.0 * step);
                apart = apart.max((slope - found).abs());
                largest = largest.max(slope.abs());
            }
        }
        assert!(apart < 1e-3 * largest && largest > 0.0, "{key}: {apart} {largest}");
    }
    let wide = of(&[r#"numbers={"spar.bending_scale"=0.0}"#]).map(drop).unwrap_err();
    assert!(wide.contains("0.001 to 1000"), "{wide}");
    let unknown = of(&[r#"numbers={"spar.bending_n_m2"=0.1}"#]).map(drop).unwrap_err();
    assert!(unknown.contains("spar.bending_scale"), "{unknown}");
}
