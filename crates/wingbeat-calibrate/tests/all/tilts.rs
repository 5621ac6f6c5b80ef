//! Static tilts: what is said of numbers that they tell, held against many seeds of their noise.

use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::scenario::Document;
use wingbeat_calibrate::measured::{MeasuredPass, observed};
use wingbeat_calibrate::{
    CalibrationFile, FitProblem, FitProgress, Information, LinearisedRuns, RunRole, clean, solve,
};

/// Seeds of the noise.
const SEEDS: u64 = 30;

/// A calibration whose bench has other numbers, and that fits the mass as well or the places alone.
fn with(numbers: &str, mass: bool) -> CalibrationFile {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let mass = if mass { "[[parameters]]\nname = \"body.mass_kg\"\n" } else { "" };
    let text = format!(
        "name = \"weighed\"\nmodel = [\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]\nstarts = 1\n\
         [truth]\nset = [\"rig.aero.preset=paper\", \"rig.aero.law=linear\"{numbers}]\npasses = 3\n\
         [[runs]]\nrun = \"{root}/rigs/identification/static_tilts.toml\"\nset = [\"hold.each_s=2.0\", \"rig.cell.rate_hz=1750\", \
         \"rig.cell.filter_hz=500\"]\n{mass}\
         [[parameters]]\nname = \"body.com_m[0]\"\nlow = -0.1\nhigh = 0.1\n"
    );
    CalibrationFile::new(Document::text("weighed", &text).unwrap()).unwrap()
}

/// A cell that weighs the robot 15 % too heavy has another gain; where the mass is fitted, the weight says nothing of it.
#[test]
fn the_gain_is_checked_by_the_weight_where_it_is_known() {
    let right = with("", false);
    let prepared = right.prepared().unwrap();
    assert!(prepared.found.is_empty() && prepared.unchecked.is_none(), "{:?}", prepared.found);
    let robot = &prepared.structure.model.targets[0].run.robot;
    let own = robot.named_numbers();
    let body = own.iter().find(|(name, _)| name == "body.mass_kg").unwrap().1;
    let heavier = body + 0.15 * robot.mass();
    let heavy = with(&format!(", \"rig.robot.numbers={{'body.mass_kg'={heavier}}}\""), false);
    let found = heavy.prepared().unwrap().found;
    assert_eq!((found.len(), found[0].id, found[0].serious), (1, "data.scaled", false), "{found:?}");
    assert!((found[0].size - 0.15).abs() < 0.04, "{found:?}");
    let unchecked = with("", true).prepared().unwrap().unchecked.unwrap();
    assert!(unchecked.text.contains("body.mass_kg is fitted"), "{}", unchecked.text);
}

fn calibration() -> CalibrationFile {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let text = format!(
        "name = \"tilts\"\nmodel = [\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]\nstarts = 1\n\
         [truth]\nset = [\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]\npasses = 7\n\
         [[runs]]\nrun = \"{root}/rigs/identification/static_tilts.toml\"\nset = [\"hold.each_s=1.0\"]\n\
         [[parameters]]\nname = \"body.mass_kg\"\n\
         [[parameters]]\nname = \"body.com_m[0]\"\nlow = -0.1\nhigh = 0.1\n\
         [[parameters]]\nname = \"body.com_m[2]\"\nlow = -0.1\nhigh = 0.1\n\
         [[parameters]]\nname = \"body.com_m[1]\"\nlow = -0.1\nhigh = 0.1\n"
    );
    CalibrationFile::new(Document::text("tilts", &text).unwrap()).unwrap()
}

/// The noise of the rest goes with the tare into all attitudes of a pass, and with its slope, over six times the rest's length, far more
/// than the scatter within them.
#[test]
#[ignore = "long: cargo xtask long tests"]
fn standard_errors_of_what_tilts_tell_are_those_of_many_seeds() {
    let calibration = calibration();
    let structure = calibration.structure(&[], &|_: &Path, _| None).unwrap();
    let targets = calibration.truth(&|_: &Path, _| None).unwrap();
    let spec = calibration.spec.truth.as_ref().unwrap();
    let made = clean(&targets[0]).unwrap();
    let truth: Vec<f64> = structure.parameters.iter().map(|parameter| parameter.start).collect();
    let (mut squares, mut chi_squared, mut wrong) = (vec![0.0; truth.len()], 0.0, 0);
    for seed in 0..SEEDS {
        let passes: Vec<MeasuredPass> =
            (0..spec.passes).map(|pass| made.pass(&targets[0], spec, 1 + seed, pass).unwrap()).collect();
        let runs = [observed(&targets[0], &passes, RunRole::Fitted, true).unwrap()];
        let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
        let plan = calibration.plan();
        let solved = solve(&structure.model, &runs, &structure.parameters, &plan, &mut (), watch).unwrap();
        for (k, truth) in truth.iter().enumerate() {
            squares[k] += ((solved.values[k] - truth) / solved.errors()[k]).powi(2) / SEEDS as f64;
        }
        chi_squared += solved.chi_squared / SEEDS as f64;
        wrong += usize::from(solved.problem.discrepancy.iter().any(|share| *share > 0.0));
        if seed == 0 {
            let problem = FitProblem::new(&structure.model, &runs, &structure.parameters).unwrap();
            let at = LinearisedRuns::at(&problem, &[0], &truth).unwrap();
            let told = Information::of(&problem, &at, &truth);
            for k in 0..truth.len() {
                let alone = told.alone.iter().map(|row| row[k]).fold(f64::INFINITY, f64::min);
                let (known, together) = (told.known[k], told.together[k]);
                assert!(
                    known <= alone * (1.0 + 1e-9) && known <= together * (1.0 + 1e-9),
                    "{k}: {known} {alone}"
                );
            }
        }
    }
    let rms: Vec<f64> = squares.iter().map(|square| square.sqrt()).collect();
    let pooled = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    println!(
        "rms of (value - truth)/standard error: {rms:?}, pooled {pooled}; chi squared {chi_squared}, {wrong} called wrong"
    );
    // Thirty draws tell a deviation to 13 %.
    assert!((0.8..1.25).contains(&pooled) && rms.iter().all(|rms| (0.6..1.45).contains(rms)), "{rms:?}");
    assert!((0.85..1.15).contains(&chi_squared) && wrong <= 1, "{chi_squared}, {wrong} called wrong");
}
