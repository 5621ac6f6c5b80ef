//! Cases of a tethered wing as what a calibration is fitted to, and what is refused of a calibration file.

use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::judge::Status;
use wingbeat::math::Random;
use wingbeat::robot::GivenNumbers;
use wingbeat::scenario::{Document, TetherCase};
use wingbeat_calibrate::{CalibrationFile, FitProgress, SampleFiles, words};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
/// The numbers of the wing that was measured.
const TRUTH: [(&str, f64); 3] = [
    ("surfaces.wing.lift_slope_per_rad", 5.4),
    ("surfaces.wing.cd0", 0.05),
    ("surfaces.wing.added_mass_scale", 0.8),
];
/// Cycles of a file.
const CYCLES: usize = 12;

const CASE: &str = "cases/flap_f2.toml";
/// Half the strips of the case, for what measures and what is fitted.
const FEW: &str = "aero.full.strips=8";

fn case(overrides: &[&str]) -> TetherCase {
    case_of(CASE, overrides)
}

fn case_of(file: &str, overrides: &[&str]) -> TetherCase {
    let overrides: Vec<String> = [FEW].iter().chain(overrides).map(|text| (*text).to_owned()).collect();
    TetherCase::load(&PathBuf::from(ROOT).join(file), &overrides, &|_| Err("no table".into())).unwrap()
}

/// A file of samples of the case with other numbers: lift downwards in mN, drag and the nose-down moment, with noise.
fn measured(file: &str, seed: u64) -> PathBuf {
    measured_of(&case(&[]), file, seed)
}

/// The same of another case.
fn measured_of(case: &TetherCase, file: &str, seed: u64) -> PathBuf {
    measured_with(case, &TRUTH, file, seed)
}

/// The same of a wing with the numbers `truth`.
fn measured_with(case: &TetherCase, truth: &[(&str, f64)], file: &str, seed: u64) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("wingbeat-calibrate-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let tether = case.adjusted(truth).unwrap();
    let run = tether.run(|_| ControlFlow::Continue(()));
    let of = |name: &str| run.last_cycle(name).unwrap().to_vec();
    let (up, ahead, moment) = (of("force_z"), of("force_x"), of("moment_y"));
    let mut random = Random::new(seed);
    let mut text = "t,down_mN,drag_N,My\n".to_owned();
    for k in 0..=CYCLES * up.len() {
        let (t, i) = (k as f64 * tether.clock.step(), k % up.len());
        let mut noise = |size: f64| size * random.normal();
        let down = -1e3 * (up[i] + noise(0.01));
        let row = (down, -ahead[i] + noise(0.005), moment[i] + noise(2e-4));
        writeln!(text, "{t},{},{},{}", row.0, row.1, row.2).unwrap();
    }
    let path = folder.join(file);
    std::fs::write(&path, text).unwrap();
    path
}

fn calibrated(text: &str) -> CalibrationFile {
    CalibrationFile::new(Document::text("cal", text).unwrap()).unwrap()
}

fn cases(data: &PathBuf) -> String {
    format!(
        "[[cases]]\ncase = \"{ROOT}/cases/flap_f2.toml\"\ndata = [{data:?}]\n\
         set = [\"{FEW}\", \"compare.channels.force_z=down_mN\", \"compare.scale.force_z=-1e-3\", \"compare.channels.force_x=drag_N\", \
         \"compare.scale.force_x=-1.0\", \"compare.channels.moment_y=My\"]\n"
    )
}

fn parameters() -> String {
    TRUTH.iter().fold(String::new(), |text, (name, _)| text + &format!("[[parameters]]\nname = \"{name}\"\n"))
}

#[test]
fn a_case_finds_the_numbers_of_another_tether_run_from_its_csv() {
    let data = measured("one.csv", 3);
    let text = format!("name = \"wing\"\nstarts = 2\n{}{}", cases(&data), parameters());
    let calibration = calibrated(&text);
    let prepared = calibration.prepared().unwrap();
    prepared.check().unwrap();
    assert_eq!((prepared.runs[0].cycles.len(), prepared.runs[0].unmeasured.clone()), (CYCLES, vec![1, 3, 5]));
    let mut found = prepared.fit(&mut (), &mut |_: &FitProgress| ControlFlow::Continue(())).unwrap();
    for (k, (name, truth)) in TRUTH.iter().enumerate() {
        let (value, error) = (found.values[k], found.errors[k]);
        println!("{name}: {value} +- {error}, truth {truth}");
        assert!((value - truth).abs() < 3.5 * error && error < 0.05 * truth, "{name}: {value} +- {error}");
        assert!((found.parameters[k].start - truth).abs() > 5.0 * error, "{name} begins elsewhere");
    }
    assert!((0.7..1.4).contains(&found.chi_squared), "{}", found.chi_squared);
    let verdict = found.verdict(calibration.limits());
    assert_eq!(verdict.status, Status::Ok, "{:?}", verdict.reason);
    assert!(verdict.judged.iter().all(|judged| judged.met));
    let _ = found.summary(&SampleFiles(Vec::new()), &verdict);
    let numbers = words::numbers(&found, &SampleFiles(Vec::new()), "commit", &verdict);
    let given: GivenNumbers = toml::from_str(&numbers).unwrap();
    assert!(given.len() == TRUTH.len() && given.verdict.unwrap().is_ok());
    assert!(found.record().is_ok());
    // A drag that is too small to be refused before the fit.
    let observed = &mut found.runs[0].observed;
    let drag = observed.layout.at(0, 0)..observed.layout.at(1, 0);
    observed.mean[drag].iter_mut().for_each(|load| *load = -*load);
    let told = found.verdict(calibration.limits()).warnings;
    let reversed = told.iter().find(|warning| warning.id == "calibration.reversed_fraction").unwrap();
    assert!(reversed.text.contains("of Fx"), "{reversed:?}");
    let flipped = text.replace("compare.scale.force_z=-1e-3", "compare.scale.force_z=1e-3");
    let flipped = calibrated(&flipped).prepared().map(drop).unwrap_err().to_string();
    assert!(flipped.contains("Fz is -Fz of the file") && flipped.contains("compare.scale"), "{flipped}");
}

#[test]
fn a_case_finds_the_stiffness_of_a_spar() {
    let wing = std::env::temp_dir().join(format!("wingbeat-bent-{}.toml", std::process::id()));
    let station = |arc: f64| {
        format!(
            "{{ arc_m = {arc}, bending_n_m2 = 0.04, edge_bending_n_m2 = 2.0, torsion_n_m2 = 0.002, mass_kg_m = 0.02, inertia_kg_m = 1e-5 }}"
        )
    };
    let text = format!(
        "name = \"bent\"\nwing.planform = [{{arc_m = 0.0, leading_edge_m = 0.02, trailing_edge_m = -0.06}}, \
         {{arc_m = 0.2, leading_edge_m = 0.02, trailing_edge_m = -0.06}}]\n\
         wing.hinges = [{{name = \"shoulder\", kind = \"flap\", arc_m = 0.02, angle_deg.fourier = {{sin = [30.0]}}}}]\n\
         wind = {{speed_m_s = 3.0, density_kg_m3 = 1.225}}\naero = {{preset = \"full\", law = \"linear\", full.strips = 8}}\n\
         time = {{frequency_hz = 4.0, cycles = 3, steps_per_cycle = 48}}\n\
         spar = {{root_m = 0.02, order = 2, damping_s = 1e-3, stations = [{}, {}]}}\n",
        station(0.02),
        station(0.2)
    );
    std::fs::write(&wing, text).unwrap();
    let wing = wing.to_str().unwrap();
    let truth = [("spar.bending_scale", 0.8), ("spar.torsion_scale", 0.8)];
    let data = measured_with(&case_of(wing, &[]), &truth, "bent.csv", 21);
    let cases = cases(&data).replace(&format!("{ROOT}/{CASE}"), wing);
    let parameters = truth.map(|(name, _)| format!("[[parameters]]\nname = \"{name}\"\n")).concat();
    let calibration = calibrated(&format!("name = \"bent\"\nstarts = 1\n{cases}{parameters}"));
    let prepared = calibration.prepared().unwrap();
    prepared.check().unwrap();
    let found = prepared.fit(&mut (), &mut |_: &FitProgress| ControlFlow::Continue(())).unwrap();
    for (k, (name, truth)) in truth.iter().enumerate() {
        let (value, error) = (found.values[k], found.errors[k]);
        println!("{name}: {value} +- {error}, truth {truth}");
        assert!((value - truth).abs() < 3.5 * error && error < 0.1 * truth, "{name}: {value} +- {error}");
    }
    let verdict = found.verdict(calibration.limits());
    assert_eq!(verdict.status, Status::Ok, "{:?}", verdict.reason);
}

#[test]
fn the_moment_of_one_wing_is_not_the_one_that_was_not_measured() {
    // A fin at the wall that heaves and pitches: both moments go with its force, and that about the wall is the larger one.
    let fin = std::env::temp_dir().join(format!("wingbeat-fin-{}.toml", std::process::id()));
    let text = "name = \"fin\"\nwing.side = \"left\"\n\
                wing.planform = [{arc_m = 0.0, leading_edge_m = 0.03, trailing_edge_m = -0.05}, \
                {arc_m = 0.25, leading_edge_m = -0.015, trailing_edge_m = -0.05}]\n\
                body.heave_m.fourier.cos = [0.035]\nbody.nose_up_deg.fourier = {mean = 1.0, sin = [-14.0]}\n\
                wind = {speed_m_s = 1.1, density_kg_m3 = 998.0}\naero = {preset = \"paper\", law = \"linear\", paper.nodes = 14}\n\
                time = {frequency_hz = 1.7, cycles = 3, steps_per_cycle = 96}\nbody.pitch_axis_ahead_m = 0.02\n";
    std::fs::write(&fin, text).unwrap();
    let fin = fin.to_str().unwrap();
    let data = measured_of(&case_of(fin, &[]), "fin.csv", 9);
    let cases = cases(&data).replace(&format!("{ROOT}/{CASE}"), fin);
    let calibration = calibrated(&format!("name = \"fin\"\nstarts = 1\n{cases}{}", parameters()));
    calibration.prepared().unwrap().check().unwrap();
}

#[test]
fn a_moment_reversed_in_one_of_three_passes_is_suspect() {
    let passes = [10, 11, 12].map(|seed| measured(&format!("pass{seed}.csv"), seed));
    let text = std::fs::read_to_string(&passes[2]).unwrap();
    let turned = |line: &str| match line.rsplit_once(',') {
        Some((before, moment)) if moment != "My" => format!("{before},{}\n", -moment.parse::<f64>().unwrap()),
        _ => format!("{line}\n"),
    };
    std::fs::write(&passes[2], text.lines().map(turned).collect::<String>()).unwrap();
    let all = cases(&passes[0])
        .replace(&format!("{:?}", passes[0]), &passes.each_ref().map(|pass| format!("{pass:?}")).join(", "));
    let calibration = calibrated(&format!("name = \"plug\"\nstarts = 1\n{all}{}", parameters()));
    let prepared = calibration.prepared().unwrap();
    let serious: Vec<String> =
        prepared.runs[0].found.iter().filter(|of| of.serious).map(|of| of.words().to_string()).collect();
    assert!(serious.len() == 1 && serious[0].contains("pass12.csv"), "{serious:?}");
}

/// Data past the stall angle, fitted with a law that knows none: it is the model that is wrong, and data that come late stay suspect.
#[test]
fn stalled_loads_under_attached_flow_are_a_wrong_model_and_no_wrong_data() {
    let told = |law: &str, angle: f64, later: f64, name: &str| {
        let pitch = [
            format!("body.nose_up_deg.fourier.cos=[{angle:?}]"),
            "time.frequency_hz=0.05".into(),
            "wing.cd0=0.02".into(),
        ];
        let own: Vec<&str> = pitch.iter().map(String::as_str).collect();
        let of = case_of("cases/pitch.toml", &[&own[..], &[&format!("aero.law={law}")]].concat());
        let data = measured_with(&of, &[], name, 31);
        let text = std::fs::read_to_string(&data).unwrap();
        let moved = |line: &str| match line.split_once(',') {
            Some((t, rest)) if t != "t" => format!("{},{rest}\n", t.parse::<f64>().unwrap() + later),
            _ => format!("{line}\n"),
        };
        std::fs::write(&data, text.lines().map(moved).collect::<String>()).unwrap();
        let cases = cases(&data).replace(CASE, "cases/pitch.toml");
        let sets: String = pitch.iter().map(|set| format!("{set:?}, ")).collect();
        let cases = cases.replace("set = [", &format!("set = [{sets}\"aero.law=linear\", "));
        let names = ["surfaces.wing.lift_slope_per_rad", "surfaces.wing.cd0"];
        let parameters = names.map(|name| format!("[[parameters]]\nname = \"{name}\"\n")).concat();
        let calibration = calibrated(&format!("name = \"stalled\"\nstarts = 1\n{cases}{parameters}"));
        let prepared = calibration.prepared().unwrap();
        prepared.check().unwrap();
        let found = prepared.fit(&mut (), &mut |_: &FitProgress| ControlFlow::Continue(())).unwrap();
        found.verdict(calibration.limits())
    };
    let stalled = told("stall", 25.0, 0.0, "stalled.csv");
    assert_eq!(stalled.status, Status::Outside, "{stalled:?}");
    let reason = stalled.reason.as_ref().unwrap();
    assert!(reason.contains("limits.calibration.wrong_model_chi_squared"), "{reason}");
    let shift = stalled.warnings.iter().find(|warning| warning.id == "data.shift").unwrap();
    assert!(shift.text.contains("law `linear`") && shift.text.contains("aero.law"), "{shift:?}");
    // Attached flow that comes 20 deg late.
    let late = told("linear", 6.0, 20.0 * 20.0 / 360.0, "late.csv");
    assert_eq!(late.status, Status::SuspectData, "{late:?}");
}

/// A file of samples of the case that `of` makes of time and force.
fn made(file: &str, mut of: impl FnMut(f64, f64) -> [f64; 3]) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("wingbeat-calibrate-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let tether = case(&[]);
    let run = tether.tether.run(|_| ControlFlow::Continue(()));
    let up = run.last_cycle("force_z").unwrap().to_vec();
    let mut text = "t,down_mN,drag_N,My\n".to_owned();
    for k in 0..=CYCLES * up.len() {
        let t = k as f64 * tether.tether.clock.step();
        let [down, drag, moment] = of(t, up[k % up.len()]);
        writeln!(text, "{t},{down},{drag},{moment}").unwrap();
    }
    let path = folder.join(file);
    std::fs::write(&path, text).unwrap();
    path
}

/// Data that say nothing of the wing are not `ok`, and their numbers carry that.
#[test]
fn a_fit_to_what_is_no_measurement_is_not_ok() {
    let mut random = Random::new(7);
    let mut noise = |size: f64| size * random.normal();
    let noisy = made("noise.csv", |_, _| [noise(10.0), noise(0.01), noise(1e-3)]);
    let mut random = Random::new(8);
    let mut count = |size: f64| size * random.normal();
    let constant =
        made("constant.csv", |_, _| [-500.0 + count(1e-6), 0.1 + count(1e-9), 0.01 + count(1e-10)]);
    let cd0 = "[[parameters]]\nname = \"surfaces.wing.cd0\"\n";
    let of = |data: &PathBuf| calibrated(&format!("name = \"wing\"\nstarts = 1\n{}{cd0}", cases(data)));
    let calibration = of(&noisy);
    let prepared = calibration.prepared().unwrap();
    prepared.check().unwrap();
    let found = prepared.fit(&mut (), &mut |_: &FitProgress| ControlFlow::Continue(())).unwrap();
    let verdict = found.verdict(calibration.limits());
    assert_eq!(verdict.status, Status::SuspectData, "{verdict:?}");
    let reason = verdict.reason.clone().unwrap();
    assert!(reason.contains("limits.calibration.explained_fraction"), "{reason}");
    // The channel that the fit makes worst is judged by the residuals that the summary has.
    let summary = serde_json::to_value(found.summary(&SampleFiles(Vec::new()), &verdict)).unwrap();
    let rmse = summary["rmse"].as_object().unwrap().values();
    let growth = rmse.filter_map(|rmse| Some(rmse["after"].as_f64()? / rmse["before"].as_f64()?));
    let growth = growth.fold(f64::NAN, f64::max);
    let judged = verdict.judged.iter().find(|judged| judged.id == "calibration.channel_growth").unwrap();
    assert!((judged.value.unwrap() - growth).abs() < 1e-12, "{judged:?}, {growth}");
    let numbers = words::numbers(&found, &SampleFiles(Vec::new()), "commit", &verdict);
    let given: GivenNumbers = toml::from_str(&numbers).unwrap();
    assert_eq!(given.verdict.unwrap().status, "suspect_data");
    // Of what does not move nothing is fitted.
    let refused = of(&constant).prepared().map(drop).unwrap_err().to_string();
    assert!(refused.contains("constant.csv: no channel has a load"), "{refused}");
}

#[test]
fn slopes_of_a_case_are_those_of_differences() {
    for (preset, law) in [("full", "linear"), ("full", "stall"), ("paper", "linear")] {
        let preset = format!("aero.preset={preset}");
        let case = case(&[&preset, &format!("aero.law={law}"), "time.steps_per_cycle=96", "wing.cd0=0.02"]);
        let names = [
            "surfaces.wing.lift_slope_per_rad",
            "surfaces.wing.cd0",
            "air.density_kg_m3",
            "surfaces.wing.added_mass_scale",
        ];
        let own = case.named_numbers();
        let value = |name: &str| own.iter().find(|(other, _)| other == name).unwrap().1;
        let exact = case.differentiated(&[], &names).unwrap().unwrap();
        for (name, exact) in names.iter().zip(&exact) {
            let step = 1e-5 * value(name).max(0.1);
            let moved =
                |by: f64| case.adjusted(&[(name, value(name) + by)]).unwrap().last_wrenches().unwrap();
            let (high, low) = (moved(step), moved(-step));
            let (mut apart, mut size) = (0.0_f64, 0.0_f64);
            for (k, exact) in exact.iter().enumerate() {
                let by_difference = (high[k][2] - low[k][2]) / (2.0 * step);
                apart = apart.max((exact[2] - by_difference).abs());
                size = size.max(exact[2].abs());
            }
            assert!(apart <= 1e-6 * size, "{preset} {law} {name}: {apart} of {size}");
        }
    }
}

#[test]
fn a_run_on_the_rig_and_a_case_are_fitted_together() {
    let data = measured("two.csv", 4);
    let turn = format!(
        "[[runs]]\nrun = \"{ROOT}/rigs/runs/roll15_speed08.toml\"\nset = [\"rig.cell.rate_hz=1750\", \"rig.cell.filter_hz=500\"]\n[[cases]]\nname = \"held\"\nheld_out = true\ncase = \
         \"{ROOT}/cases/flap_f2.toml\"\nset = [\"{FEW}\", \"compare.channels.force_z=down_mN\", \"compare.scale.force_z=-1e-3\"]\n\
         data = [{:?}]\n",
        measured("three.csv", 5)
    );
    let calibration = calibrated(&format!(
        "name = \"both\"\nstarts = 1\nsteps_per_cycle = 100\nmodel = [\"rig.aero.preset=full\", \"rig.aero.law=linear\"]\n[truth]\n\
         set = [\"rig.aero.preset=full\", \"rig.aero.law=linear\", \"rig.robot.numbers={{\\\"surfaces.wing.lift_slope_per_rad\\\"=5.4, \
         \\\"surfaces.wing.cd0\\\"=0.05, \\\"surfaces.wing.added_mass_scale\\\"=0.8}}\"]\n{turn}{}{}",
        cases(&data),
        parameters()
    ));
    let prepared = calibration.prepared().unwrap();
    assert_eq!(prepared.runs.len(), 3);
    let found = prepared.fit(&mut (), &mut |_: &FitProgress| ControlFlow::Continue(())).unwrap();
    for (k, (name, truth)) in TRUTH.iter().enumerate() {
        let (value, error) = (found.values[k], found.errors[k]);
        assert!((value - truth).abs() < 4.0 * error && error < 0.05 * truth, "{name}: {value} +- {error}");
    }
    let held = found.held_out().next().unwrap();
    assert_eq!(held.observed.name, "held");
    let covered = held.after.coverage(&held.observed, &held.after.deviations);
    assert!(covered[2] > 0.85, "{covered:?}");
}

#[test]
fn refusals_say_where_and_what() {
    let turn = format!("[[runs]]\nrun = \"{ROOT}/rigs/runs/roll15_speed08.toml\"\n");
    let told = |text: &str| {
        let calibration = Document::text("cal", text).and_then(CalibrationFile::new);
        let refused = |calibration: CalibrationFile| {
            SampleFiles::of(&calibration).map_err(|error| error.to_string())?;
            calibration.prepared().map(drop).map_err(|error| error.to_string())
        };
        calibration.map_err(|error| error.to_string()).and_then(refused).unwrap_err()
    };
    let with = |head: &str, parameters: &str| format!("name = \"c\"\n{head}\n[truth]\n{turn}{parameters}");
    let cd0 = "[[parameters]]\nname = \"surfaces.wing.cd0\"\n";
    let model = told(&with("model = [\n\"rig.aero.preset=paper\",\n\"rig.aero.law=foo\"]", cd0));
    assert!(model.starts_with("cal:4: rig.aero.law"), "{model}");
    let data = told(&format!("name = \"c\"\n{turn}data = [\"no.csv\"]\n{cd0}"));
    assert!(
        data.starts_with("cal:4: runs[0].data[0] = \"no.csv\"") && data.contains("No such file"),
        "{data}"
    );
    let tilts = turn.replace("runs/roll15_speed08", "identification/static_tilts");
    let few = told(&format!(
        "name = \"c\"\n[truth]\n{tilts}set = [\"hold.tilts_deg=[[0.0, 0.0], [45.0, 0.0]]\"]\n{cd0}"
    ));
    assert!(few.contains("cal:5: hold.tilts_deg = 2 attitudes"), "{few}");
    let unknown = told(&with("", "[[parameters]]\nname = \"surfaces.wing.cd9\"\n"));
    assert!(unknown.contains("surfaces.wing.cd90") && unknown.contains("--names"), "{unknown}");
    assert!(unknown.len() < 400 && unknown.starts_with("cal:"), "{unknown}");
    let rate = told(&with("", "[[parameters]]\nname = \"gait.phase_rate_rad_s\"\n"));
    assert!(
        rate.contains("gait.phase_rate_rad_s") && rate.contains("read from the data of each run"),
        "{rate}"
    );
    let bounds = told(&with("", "[[parameters]]\nname = \"surfaces.wing.lift_slope_per_rad\"\nhigh = 4.0\n"));
    assert!(bounds.contains("parameters[0].high = 4.0"), "{bounds}");
    assert!(bounds.contains("the model's own value"), "{bounds}");
    let stages = |first: usize, second: usize| {
        format!("{cd0}stage = {first}\n[[parameters]]\nname = \"body.mass_kg\"\nstage = {second}\n")
    };
    let swapped = told(&with("", &stages(1, 2)));
    assert!(
        swapped.contains("parameters[0].stage = 1") && swapped.contains("come before the air"),
        "{swapped}"
    );
    let empty = told(&with("", &stages(3, 1)));
    assert!(empty.contains("no number is fitted in stage 2"), "{empty}");
    let phase = "[[parameters]]\nname = \"gait.phase_rad\"\nprior = [0.0, 0.1]\nstage = 2\n";
    let coarse = "set = [\"rig.cell.rate_hz=1750\", \"rig.cell.filter_hz=500\"]\n";
    let silent =
        told(&format!("name = \"c\"\n[truth]\n{turn}{coarse}{tilts}{coarse}{cd0}stage = 1\n{phase}"));
    assert!(silent.contains("say nothing of surfaces.wing.cd0"), "{silent}");
}

/// A fit goes on from what another command left where these texts are the same: they say what runs and cases resolve to.
#[test]
fn a_fit_goes_on_only_with_what_bears_along_its_span() {
    let run = format!("{ROOT}/rigs/runs/roll15_speed08.toml");
    let identity = |model: &str, truth: &str| {
        let text = format!(
            "name = \"same\"\nmodel = [{model}]\n[truth]\nset = [{truth}]\n[[runs]]\nname = \"turn\"\nrun = \"{run}\"\n\
             {}[[parameters]]\nname = \"surfaces.wing.cd0\"\n",
            cases(&PathBuf::from("none.csv"))
        );
        SampleFiles(Vec::new()).identity(&calibrated(&text)).unwrap()
    };
    let of = |identity: &str, run: &str| {
        let start = format!("# {run} fnv1a64 ");
        let line = identity.lines().find_map(|line| line.strip_prefix(&start)).unwrap();
        line.split_once(", ").map_or((line.to_owned(), String::new()), |(h, k)| (h.into(), k.into()))
    };
    let full = "\"rig.aero.preset=full\"";
    let impulse = format!("{full}, \"rig.aero.full.turning_impulse=true\"");
    let told = "\"rig.aero.full.edge_suction=true\"";
    let [first, other, same] =
        [full, &impulse, &format!("{full}, {told}")].map(|model| identity(model, full));
    for run in ["run turn", "truth of turn", "case flap_f2"] {
        assert_eq!(of(&first, run).1, "edge_suction = true", "{first}");
        assert_eq!(of(&first, run) == of(&other, run), run == "truth of turn", "{run}: {other}");
        assert_eq!(of(&first, run), of(&same, run), "what is the default and what is given");
    }
    assert_eq!(of(&other, "run turn").1, "edge_suction = false, turning_impulse = true");
    assert_eq!(of(&identity("\"rig.aero.preset=paper\"", full), "run turn").1, "");
}
