//! Flights on membranes in the lattice.

use super::coupled::{fly, open, shipped};
use wingbeat::math::{GRAVITY, Vec3};
use wingbeat::scenario::{Document, LatticeTask, Run};
use wingbeat::simulate::Flow;
use wingbeat_lattice::CoupledLattice;

const LATTICE: &str = "lattice={ step_s = 0.005, chordwise = 4, spanwise = 12 }";

fn column<'a>(run: &'a Run, name: &str) -> &'a [f64] {
    run.record.values(name).unwrap_or_else(|| panic!("{name}"))
}

fn last(run: &Run, name: &str) -> f64 {
    *column(run, name).last().unwrap()
}

/// A sail a thousand times as stiff, without weight, flies as the rigid glider does.
#[test]
fn a_stiff_sail_flies_in_the_lattice_as_a_rigid_wing() {
    let set = [LATTICE, "flight.duration_s=0.3"];
    let rigid = fly(&open(shipped("glider.toml", &set)));
    let stiff =
        ["modulus_pa=1.5e9", "density_kg_m3=0.0"].map(|set| format!("robot.surfaces[0].membrane.{set}"));
    let document = stiff.iter().fold(shipped("sail_glide.toml", &set), |document, set| document.set(set));
    let stiff = fly(&open(document));
    let soft = fly(&open(shipped("sail_glide.toml", &set)));
    let (mut apart, mut changed) = (0.0_f64, 0.0_f64);
    for source in ["circulatory_x", "circulatory_z"].map(|of| format!("force_{of}")) {
        let size = column(&rigid, &source).iter().fold(0.0_f64, |most, force| most.max(force.abs()));
        let off = |run: &Run| {
            let pairs = column(run, &source).iter().zip(column(&rigid, &source));
            pairs.skip(2).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) / size
        };
        apart = apart.max(off(&stiff));
        changed = changed.max(off(&soft));
    }
    assert!(apart < 1e-3 && changed > 1e-2, "{apart} {changed}");
    let off = (last(&stiff, "pitch") - last(&rigid, "pitch")).abs();
    assert!(off < 1e-3 * last(&rigid, "pitch").abs(), "{off}");
}

/// On a glide a sail stands as the strips' does, and the same on either side.
#[test]
fn sails_stand_in_the_lattice_as_by_strips() {
    let set = ["flight.duration_s=0.4", "robot.surfaces[0].membrane.density_kg_m3=0.0"];
    let strips = fly(&open(shipped("sail_glide.toml", &set)));
    let lattice = fly(&open(
        shipped("sail_glide.toml", &set).set("lattice={ step_s = 0.005, chordwise = 8, spanwise = 24 }"),
    ));
    let told = |run: &Run| format!("{:?}", run.summary.warnings).contains("lattice.soft");
    assert!(told(&lattice) && !told(&strips));
    for (state, within) in [("camber", 0.05), ("camber_forward", 0.1)] {
        let all = |run: &Run| -> Vec<f64> {
            (0..).map_while(|k| Some(*run.record.values(&format!("{state}_{k}"))?.last()?)).collect()
        };
        let (own, other) = (all(&lattice), all(&strips));
        let size = other.iter().fold(0.0_f64, |most, state| most.max(state.abs()));
        let apart = own.iter().zip(&other).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) / size;
        assert!(apart < within && own.len() > 3, "{state}: {apart} {own:?} {other:?}");
        let skew = own.iter().zip(own.iter().rev()).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(skew < 1e-5 * size, "{state}: {skew}");
    }
}

/// A rectangle of `skin` in air of next to no weight.
fn sheet(skin: &str) -> Document {
    let robot = format!(
        "name = \"sheet\"\n[body]\nmass_kg = 1.0\ninertia_kg_m2 = [1.0, 1.0, 1.0]\n[[surfaces]]\nname = \"wing\"\ncd0 = 0.0\ncd90 = 0.0\n\
         panels = [{{ link = \"body\" }}]\nplanform = [{{ arc_m = 0.0, leading_edge_m = 0.1, trailing_edge_m = -0.1 }}, \
         {{ arc_m = 0.5, leading_edge_m = 0.1, trailing_edge_m = -0.1 }}]\n{skin}"
    );
    let flight = "name = \"sheet\"\n[air]\ndensity_kg_m3 = 1e-9\n[aero]\npreset = \"full\"\nlaw = \"linear\"\n[lattice]\nstep_s = 0.01\n\
                  chordwise = 4\nspanwise = 24\n[flight]\nduration_s = 0.1\nstep_s = 0.001\nrecord_every_s = 0.01\n";
    let robot = Document::text("sheet.toml", &robot).unwrap();
    Document::text("flight.toml", flight).unwrap().put("robot", robot).unwrap()
}

/// By the rates r of the bends from rest within a step: of the parabola h, Q_1 = -(8/15) m c r/step c - (2/3) m g c and the wing feels
/// -(2/3) m c r/step, m the mass.
#[test]
fn a_skin_bears_its_inertia_and_weight() {
    let (chord, step, small) = (0.2, 0.01, 1e-3);
    let film = 0.1 * chord;
    let (inertia, weight) = (-8.0 / 15.0 * film * chord * chord, -2.0 / 3.0 * film * chord);
    let scenario = open(sheet(
        "membrane = { thickness_m = 1e-3, modulus_pa = 1e6, density_kg_m3 = 100.0, prestrain = 0.05 }\n",
    ));
    let (robot, spec) = (scenario.robot(), scenario.spec.lattice.as_ref().unwrap());
    let outlines = scenario.spec.robot.outlines().unwrap();
    let task = LatticeTask { spec, robot, outlines, density_kg_m3: 1e-9, every: 10, steps: 10 };
    let mut air = CoupledLattice::new(&task).unwrap();
    let bends = robot.bent_chords().count();
    let mut at = robot.stance(0.0, &scenario.start());
    at.velocity = Vec3::ZERO;
    at.bends = vec![[0.0; 2]; bends];
    // What is there at the start has no rate to differ from.
    for _ in 0..2 {
        air.loads(0.0, &at).unwrap();
        air.keep();
    }
    // The first shape of each strip.
    at.bends[..bends / 2].fill([0.0, small]);
    let loads = air.loads(step, &at).unwrap();
    let sum = loads.bends[..bends / 2].iter().sum::<f64>();
    let exact = inertia * small / step + weight * GRAVITY;
    assert!((sum / exact - 1.0).abs() < 5e-3, "{sum} {exact}");
    let force = loads.links.iter().map(|load| load.force[2]).sum::<f64>();
    let exact = weight * small / step;
    assert!((force / exact - 1.0).abs() < 5e-3, "{force} {exact}");
}
