//! What a model leaves of runs on a stand: a known wrench is found again, and runs that do not tell it are refused.

use std::ops::ControlFlow;
use wingbeat::math::{Jet, Vec3};
use wingbeat::robot::{Residual, ResidualSpec};
use wingbeat::scenario::Document;
use wingbeat_calibrate::{CalibrationFile, CalibrationResult};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A wrench that vanishes in still air.
const KNOWN: &str = "{ frequency_hz = 3.5, low_m_s = [0.0, 0.0, -2.0], high_m_s = [3.0, 0.0, 2.0], terms = [\"u\", \"w\", \"uw\"], \
     loads = { Fx = [[0.05, 0.0, 0.0], [0.0, 0.03, 0.0], [0.02, 0.0, 0.0]], Fz = [[0.04, -0.06, 0.02], [0.08, 0.0, 0.0], [0.0, 0.0, 0.05]], \
     Ty = [[0.002, 0.001, 0.0], [0.0, 0.0, 0.001], [0.003, 0.0, 0.0]] } }";

/// What a bench costs is its samples: here they come at 1.75 kHz in place of 7.
const COARSE: &str = "\"rig.cell.rate_hz=1750\", \"rig.cell.filter_hz=500\"";

/// A stand in a wind, with what else its run says.
fn stand(speed: f64, pitch: f64, more: &str) -> String {
    format!(
        "[[runs]]\nname = \"{speed} {pitch}\"\nrun = \"{ROOT}/rigs/identification/still_air.toml\"\nresidual = true\nset = [\
         \"hold.each_s=2.0\", {COARSE}, \"hold.tilts_deg=[[0.0, {pitch:?}]]\", \"wind_m_s=[-{speed:?}, 0.0, 0.0]\", \"process.steps.tare=false\", \
         \"rig.cell.bias=[0, 0, 0, 0, 0, 0]\", \"rig.cell.drift_per_s=[0, 0, 0, 0, 0, 0]\"{more}]\n"
    )
}

/// What the truth has beyond the model: the known wrench, an encoder that lags, a heavier wing.
const BEYOND: &str = "'rig.robot.numbers={ \"gait.phase_rad\" = 0.06, \"links.twist.mass_kg\" = 0.0041 }'";

/// A calibration whose truth is the model with what is `beyond` it.
fn calibration(stands: &[String], beyond: &str) -> CalibrationFile {
    let text = format!(
        "name = \"stands\"\nmodel = [\"rig.aero.preset=paper\", \"rig.aero.law=linear\"]\nstarts = 1\nharmonics = 4\n\
         steps_per_cycle = 100\n\
         [truth]\nset = [\"rig.aero.preset=paper\", \"rig.aero.law=linear\", {beyond}]\npasses = 3\n\
         [[runs]]\nrun = \"{ROOT}/rigs/identification/still_air.toml\"\nset = [\"hold.each_s=2.0\", {COARSE}]\n\
         {}[[parameters]]\nname = \"links.twist.mass_kg\"\n\
         [[parameters]]\nname = \"gait.phase_rad\"\nprior = [0.0, 0.1]\n",
        stands.concat()
    );
    CalibrationFile::new(Document::text("stands", &text).unwrap()).unwrap()
}

fn found(stands: &[String], beyond: &str) -> Result<CalibrationResult, String> {
    let calibration = calibration(stands, beyond);
    let prepared = calibration.prepared().map_err(|error| error.to_string())?;
    prepared.fit(&mut (), &mut |_| ControlFlow::Continue(())).map_err(|error| error.to_string())
}

fn wrench(spec: &ResidualSpec, phase: f64, velocity: [f64; 3]) -> [f64; 6] {
    let rate = std::f64::consts::TAU * 3.5;
    let seen = Residual::new(spec).unwrap().wrench(&Jet::new(phase, rate, 0.0), Vec3(velocity));
    let [f, m] = [seen.force, seen.moment];
    [f[0], f[1], f[2], m[0], m[1], m[2]]
}

#[test]
fn a_known_wrench_is_found_again() {
    let stands: Vec<String> =
        [0.8, 1.2, 1.6].iter().flat_map(|s| [-20.0, -5.0, 10.0].map(|p| stand(*s, p, ""))).collect();
    let found = found(&stands, &format!("'rig.robot.residual={KNOWN}', {BEYOND}")).unwrap();
    assert!((found.values[0] - 0.0041).abs() < 2e-5 && (found.values[1] - 0.06).abs() < 0.005);
    let learned = found.residual.as_ref().unwrap();
    assert_eq!(learned.spec.terms, ["1", "u", "w", "uu", "uw", "ww"]);
    let told: Vec<bool> = learned.channels.iter().map(|channel| channel.is_told()).collect();
    assert_eq!(told, [true, false, true, false, true, false], "{:?}", learned.channels);
    let table: toml::Table = toml::from_str(&format!("residual = {KNOWN}")).unwrap();
    let known: ResidualSpec = table["residual"].clone().try_into().unwrap();
    for velocity in [[0.9, 0.0, 0.1], [1.2, 0.0, -0.1], [1.4, 0.0, 0.2]] {
        for phase in [0.0, 1.1, 2.3, 3.9, 5.2] {
            let (is, seen) = (wrench(&known, phase, velocity), wrench(&learned.spec, phase, velocity));
            for (channel, size) in [(0, 0.1), (2, 0.15), (4, 0.006)] {
                let apart = (is[channel] - seen[channel]).abs();
                assert!(
                    apart < 0.05 * size,
                    "{velocity:?} {phase} {channel}: {} {}",
                    is[channel],
                    seen[channel]
                );
            }
        }
    }
    // Runs that the wrench is learned from are neither fitted nor held out; with it their cycles are said.
    assert_eq!((found.fitted().count(), found.held_out().count()), (1, 0));
    for (run, _) in &learned.runs {
        let (cycle, measured) = (found.with_residual(*run).unwrap(), &found.runs[*run].observed.mean);
        let layout = found.runs[*run].observed.layout;
        let apart: Vec<f64> = cycle.iter().zip(measured).map(|(a, b)| a - b).collect();
        assert!(layout.mean_square(&apart, 2) < 0.01 * layout.mean_square(measured, 2));
    }
    // The file is read back as what it says.
    let files = wingbeat_calibrate::SampleFiles(Vec::new());
    let text = wingbeat_calibrate::words::residual(&found, &files, "test").unwrap();
    assert_eq!(toml::from_str::<ResidualSpec>(&text).unwrap(), learned.spec);
}

#[test]
#[ignore = "long: cargo xtask long tests"]
fn runs_that_do_not_tell_it_are_refused() {
    let refused = |stands: &[String]| found(stands, BEYOND).err().unwrap();
    let few = refused(&[stand(0.8, -5.0, ""), stand(1.2, -5.0, ""), stand(1.6, -5.0, "")]);
    assert!(few.contains("3 runs with residual = true do not tell") && few.contains("at least 4"), "{few}");
    let faster = refused(&[stand(0.8, -5.0, ""), stand(1.2, 10.0, ", \"frequency_hz=4.0\"")]);
    assert!(
        faster.contains("4.000 Hz, is not 3.500 Hz") && faster.contains("one robot at one frequency"),
        "{faster}"
    );
    // Three on a line and one beside it: that one is met whatever it says, and nothing tells how well.
    let alone =
        refused(&[stand(0.8, -5.0, ""), stand(1.2, -5.0, ""), stand(1.6, -5.0, ""), stand(1.2, 10.0, "")]);
    assert!(alone.contains("4 runs") && alone.contains("the only one that tells a factor"), "{alone}");
    let tilts =
        "[[runs]]\nname = \"tilts\"\nrun = \"ROOT/rigs/identification/static_tilts.toml\"\nresidual = true\n";
    let still = refused(&[tilts.replace("ROOT", ROOT)]);
    assert!(still.contains("tilts: its wings are still"), "{still}");
    let known = format!(", 'rig.robot.residual={KNOWN}'");
    let twice = refused(&[stand(0.8, -5.0, &known), stand(1.2, 10.0, "")]);
    assert!(twice.contains("has a rig.robot.residual"), "{twice}");
    let both = stand(0.8, -5.0, "").replace("residual = true", "residual = true\nheld_out = true");
    let text = format!("name = \"both\"\n[truth]\n{both}[[parameters]]\nname = \"links.twist.mass_kg\"\n");
    let told = CalibrationFile::new(Document::text("both", &text).unwrap()).err().unwrap().to_string();
    assert!(told.contains("runs[0].held_out = true"), "{told}");
}
