//! Standard errors from few cycles, held against many seeds of their noise.

use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::scenario::Document;
use wingbeat_calibrate::measured::{MeasuredPass, observed};
use wingbeat_calibrate::{
    CalibrationFile, Clean, CycleModel, Error, FitProgress, RunRole, clean, solve, student_95,
};

/// Seeds of the noise.
const SEEDS: u64 = 60;

/// A model that is straight about `at`: what is told of errors does not hang on how far it bends.
struct Straight {
    at: Vec<f64>,
    cycles: Vec<Vec<f64>>,
    slopes: Vec<Vec<Vec<f64>>>,
}

impl CycleModel for Straight {
    fn predict(&self, run: usize, values: &[f64]) -> Result<Vec<f64>, Error> {
        let mut cycle = self.cycles[run].clone();
        for ((slope, value), at) in self.slopes[run].iter().zip(values).zip(&self.at) {
            cycle.iter_mut().zip(slope).for_each(|(x, slope)| *x += (value - at) * slope);
        }
        Ok(cycle)
    }
    fn slopes(&self, run: usize, _: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
        Ok(self.slopes[run].clone())
    }
}

fn calibration() -> CalibrationFile {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let run = |name: &str| format!("[[runs]]\nrun = \"{root}/rigs/runs/{name}.toml\"\n");
    let parameter = |name: &str| format!("[[parameters]]\nname = \"{name}\"\n");
    let names = [
        "surfaces.wing.lift_slope_per_rad",
        "surfaces.wing.cd90",
        "surfaces.wing.added_mass_scale",
        "links.twist.mass_kg",
        "links.twist.com_m[1]",
    ];
    let text = format!(
        "name = \"few\"\nmodel = [\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]\nsteps_per_cycle = 100\nstarts = 1\n\
         [truth]\nset = [\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]\npasses = 3\n{}{}",
        ["roll10_speed08", "roll15_speed08", "roll20_speed08"].map(run).concat(),
        names.map(parameter).concat(),
    );
    CalibrationFile::new(Document::text("few", &text).unwrap()).unwrap()
}

/// Three runs of three passes: 24 cycles beyond their means tell the noise of six channels.
#[test]
#[ignore = "long: cargo xtask long tests"]
fn standard_errors_of_three_passes_are_those_of_many_seeds() {
    let calibration = calibration();
    let structure = calibration.structure(&[], &|_: &Path, _| None).unwrap();
    let targets = calibration.truth(&|_: &Path, _| None).unwrap();
    let spec = calibration.spec.truth.as_ref().unwrap();
    let made: Vec<Clean> = targets.iter().map(|target| clean(target).unwrap()).collect();
    let truth: Vec<f64> = structure.parameters.iter().map(|parameter| parameter.start).collect();
    let all = 0..targets.len();
    let model = Straight {
        at: truth.clone(),
        cycles: all.clone().map(|run| structure.model.predict(run, &truth).unwrap()).collect(),
        slopes: all.clone().map(|run| structure.model.slopes(run, &truth).unwrap()).collect(),
    };
    let (mut square, mut inside) = (0.0, 0.0);
    let share = 1.0 / (SEEDS as f64 * truth.len() as f64);
    for seed in 0..SEEDS {
        let run = |k: usize| {
            let pass = |pass: usize| made[k].pass(&targets[k], spec, 7919 * seed + 1000 * k as u64, pass);
            let passes: Vec<MeasuredPass> = (0..spec.passes).map(|number| pass(number).unwrap()).collect();
            observed(&targets[k], &passes, RunRole::Fitted, true).unwrap()
        };
        let runs: Vec<_> = all.clone().map(run).collect();
        let watch = &mut |_: &FitProgress| ControlFlow::Continue(());
        let plan = calibration.plan();
        let solved = solve(&model, &runs, &structure.parameters, &plan, &mut (), watch).unwrap();
        let reach = student_95(solved.covariances.freedom);
        for ((value, truth), error) in solved.values.iter().zip(&truth).zip(solved.errors()) {
            let apart = (value - truth) / error;
            square += share * apart * apart;
            inside += share * f64::from(u8::from(apart.abs() <= reach));
        }
    }
    let rms = square.sqrt();
    println!(
        "rms of (value - truth)/standard error: {rms:.3}; {:.1} % of the 95 % intervals hold",
        100.0 * inside
    );
    assert!((0.9..1.1).contains(&rms), "{rms}");
    assert!((0.92..0.98).contains(&inside), "{inside}");
}
