//! Flights on membranes and flaps in the lattice.

use super::coupled::{fly, open, shipped};
use wingbeat::aero::{Aero, FlapSpec, Planform, PlanformStation, StripModel, StripSettings};
use wingbeat::math::{GRAVITY, Vec3};
use wingbeat::scenario::{Document, LatticeTask, Run};
use wingbeat::simulate::Flow;
use wingbeat_lattice::{CoupledLattice, EdgeBends};

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
    for (state, within) in [("camber", 0.03), ("camber_forward", 0.1)] {
        let [own, other] = [&lattice, &strips].map(|run| ends(run, state));
        let off = apart(&own, &other);
        assert!(off < within && own.len() > 3, "{state}: {off} {own:?} {other:?}");
        let mirrored: Vec<f64> = own.iter().rev().copied().collect();
        let skew = apart(&own, &mirrored);
        assert!(skew < 1e-10, "{state}: {skew}");
    }
}

/// Wings that flap and fold bend alike on either side: edges at the hinges lie between two planes.
#[test]
fn a_folding_membrane_bends_alike_on_either_side() {
    let set = ["lattice={ step_s = 0.002, chordwise = 2, spanwise = 16 }", "flight.duration_s=0.04"];
    let flown = fly(&open(shipped("aerobat_membrane.toml", &set)));
    for state in ["camber", "camber_forward"] {
        let own = ends(&flown, state);
        let mirrored: Vec<f64> = own.iter().rev().copied().collect();
        let skew = apart(&own, &mirrored);
        assert!(skew < 1e-9 && own.len() > 3, "{state}: {skew} {own:?}");
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
/// -(2/3) m c r/step, m the mass; of a flap of the chord l, -(m l^2/3) r/step + m g l/2, and the wing feels m (l/2) r/step.
#[test]
fn a_skin_bears_its_inertia_and_weight() {
    let (chord, step, small) = (0.2, 0.01, 1e-3);
    let membrane =
        "membrane = { thickness_m = 1e-3, modulus_pa = 1e6, density_kg_m3 = 100.0, prestrain = 0.05 }\n";
    let flap = "flap = { chord_fraction = 0.25, stiffness_n_rad = 1.0, areal_density_kg_m2 = 0.4 }\n";
    let length = 0.25 * chord;
    let (film, hinged) = (0.1 * chord, 0.4 * length);
    let cases = [
        (
            membrane,
            [-8.0 / 15.0 * film * chord * chord, -2.0 / 3.0 * film * chord, -2.0 / 3.0 * film * chord],
        ),
        (flap, [-hinged * length * length / 3.0, hinged * length / 2.0, hinged * length / 2.0]),
    ];
    for (skin, [inertia, weight, borne]) in cases {
        let scenario = open(sheet(skin));
        let (robot, spec) = (scenario.robot(), scenario.spec.lattice.as_ref().unwrap());
        let outlines = scenario.spec.robot.outlines().unwrap();
        let task = LatticeTask { spec, robot, outlines, density_kg_m3: 1e-9, every: 10, steps: 10 };
        let mut air = CoupledLattice::new(&task).unwrap();
        let bends = robot.bent_chords().count();
        // The first shape of each strip, or each flap.
        let moved = if skin == membrane { bends / 2 } else { bends };
        let mut at = robot.stance(0.0, &scenario.start());
        at.velocity = Vec3::ZERO;
        at.bends = vec![[0.0; 2]; bends];
        // What is there at the start has no rate to differ from.
        for _ in 0..2 {
            air.loads(0.0, &at).unwrap();
            air.keep();
        }
        at.bends[..moved].fill([0.0, small]);
        let loads = air.loads(step, &at).unwrap();
        let sum = loads.bends[..moved].iter().sum::<f64>();
        let exact = inertia * small / step + weight * GRAVITY;
        assert!((sum / exact - 1.0).abs() < 5e-3, "{sum} {exact}");
        let force = loads.links.iter().map(|load| load.force[2]).sum::<f64>();
        let exact = borne * small / step;
        assert!((force / exact - 1.0).abs() < 5e-3, "{force} {exact}");
    }
}

/// Angles of the flaps at the end, or heights of a sail, by strip.
fn ends(run: &Run, state: &str) -> Vec<f64> {
    (0..).map_while(|k| run.record.values(&format!("{state}_{k}"))?.last().copied()).collect()
}

fn apart(own: &[f64], other: &[f64]) -> f64 {
    let size = other.iter().fold(0.0_f64, |most, of| most.max(of.abs()));
    own.iter().zip(other).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) / size
}

/// Sixteen flaps on panels wider than they are, as wide, and narrower: the air gives no mass to what panels do not see, and a load that goes
/// straight over a step swings there by .088 s.
#[test]
fn flaps_stay_still_on_any_panels() {
    let fly_on = |spanwise: usize, step: f64| {
        let lattice = format!("lattice={{ step_s = {step}, chordwise = 4, spanwise = {spanwise} }}");
        fly(&open(shipped("flap_glide.toml", &[&lattice, "aero.full.strips=16", "flight.duration_s=0.1"])))
    };
    let finest = ends(&fly_on(24, 2e-3), "flap");
    assert_eq!(finest.len(), 16);
    for (spanwise, step) in [(8, 1e-3), (12, 2e-3), (16, 1e-3), (16, 2e-3)] {
        let own = ends(&fly_on(spanwise, step), "flap");
        let off = apart(&own, &finest);
        assert!(off < 0.05, "{spanwise} {step}: {off} {own:?}");
    }
}

/// A flap a hundred times as stiff flies as the rigid glider does; as soft as it is it stands as by strips, whose hinge
/// moment is Glauert's, and the same on either side.
#[test]
fn flaps_stand_in_the_lattice_as_by_strips_and_stiff_ones_as_none() {
    let fine = "lattice={ step_s = 0.005, chordwise = 8, spanwise = 24 }";
    let duration = "flight.duration_s=0.2";
    let rigid = fly(&open(shipped("glider.toml", &[fine, duration, "flight.step_s=5e-4"])));
    let stiff = ["stiffness_n_rad=100.0", "rest_deg=0.0"].map(|set| format!("robot.surfaces[0].flap.{set}"));
    let document = shipped("flap_glide.toml", &[fine, duration, "flight.step_s=5e-5"]);
    let stiff = fly(&open(stiff.iter().fold(document, |document, set| document.set(set))));
    let soft = fly(&open(shipped("flap_glide.toml", &[fine, duration])));
    let [lift, small] = ["force_circulatory_z", "pitch"];
    for of in [lift, small] {
        let off = |run: &Run| (last(run, of) - last(&rigid, of)).abs() / last(&rigid, of).abs();
        assert!(
            off(&stiff) < 2e-3 && off(&stiff) < 0.05 * off(&soft),
            "{of}: {} {}",
            off(&stiff),
            off(&soft)
        );
    }
    let strips = fly(&open(shipped("flap_glide.toml", &[duration])));
    let told = |run: &Run| format!("{:?}", run.summary.warnings).contains("lattice.soft");
    assert!(told(&soft) && !told(&strips));
    let [own, other] = [&soft, &strips].map(|run| ends(run, "flap"));
    let off = apart(&own, &other);
    assert!(off < 0.035 && own.len() > 3, "{off} {own:?} {other:?}");
    let mirrored: Vec<f64> = own.iter().rev().copied().collect();
    let skew = apart(&own, &mirrored);
    assert!(skew < 1e-10, "{skew}");
}

/// A flap that swings on a spring without damping next to no air: from one turning point to the next its strain falls by the step, as
/// `robot.held_load` says: of mass and spring alone a step keeps 1/(1 + (w step)^2/2) of it.
#[test]
fn a_swinging_flap_makes_no_energy() {
    let (density, stiffness, chord) = (4.0, 0.2, 0.05);
    let frequency = f64::sqrt(stiffness / (density * f64::powi(chord, 3) / 3.0));
    let period = std::f64::consts::TAU / frequency;
    let skin = format!(
        "flap = {{ chord_fraction = 0.25, stiffness_n_rad = {stiffness}, areal_density_kg_m2 = {density}, damping_s = 1e-6, rest_deg = 10.0 }}\n"
    );
    let lost = [2e-3, 1e-3].map(|step| {
        let steps = (1.2 * period / step).ceil();
        let keys = [
            ("lattice.step_s", step),
            ("lattice.longest_age_s", 2.0 * step),
            ("lattice.spanwise", 16.0),
            ("flight.duration_s", steps * step),
            ("flight.step_s", 1e-4),
            ("flight.record_every_s", step),
        ];
        let still = sheet(&skin).set("start.velocity_m_s=[0.01,0.0,0.0]");
        let run = fly(&open(
            keys.iter().fold(still, |document, (key, value)| document.set(format!("{key}={value}"))),
        ));
        let (times, angles) = (column(&run, "t"), column(&run, "flap_4"));
        let most = |from: f64, to: f64| {
            let strains = times.iter().zip(angles).filter(|(t, _)| (from..to).contains(&(*t / period)));
            strains.fold(0.0_f64, |most, (_, angle)| most.max((angle - 10_f64.to_radians()).powi(2)))
        };
        let [first, next] = [most(0.25, 0.75), most(0.75, 1.2)];
        let held = 1.0 - (1.0 + 0.5 * (frequency * step).powi(2)).powf(-0.5 * period / step);
        let lost = 1.0 - next / first;
        assert!(first > 0.01 && lost > 0.0 && lost < 2.0 * held, "{step}: {first} {next} {held}");
        lost
    });
    let halved = lost[0] / lost[1];
    assert!(halved > 1.6 && halved < 2.4, "{lost:?}");
}

/// Of flaps and any panels: states that are alike bend edges alike, an even load comes to each flap by its width, and what loads do on the edges
/// they do on the states.
#[test]
fn edges_bend_alike_and_do_the_work_of_their_loads() {
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.5, trailing_edge_m: -0.5 };
    let flap = FlapSpec {
        chord_fraction: 0.25,
        stiffness_n_rad: 2.0,
        areal_density_kg_m2: 0.1,
        damping_s: 0.01,
        rest_deg: 0.0,
        from_arc_m: 0.0,
        to_arc_m: None,
    };
    let settings = StripSettings { strips: 16, flap: Some(flap), ..Default::default() };
    let planform = Planform::new(&[station(0.0), station(5.0)]).unwrap();
    let aero = Aero::Strip(StripModel::new(&planform, settings).unwrap());
    let random = |k: usize| (k as f64 * 12.9898).sin();
    for panels in [5, 8, 16, 24, 61] {
        let even = |j: usize| 5.0 - 10.0 * j as f64 / panels as f64;
        let arcs: Vec<f64> = (0..=panels)
            .map(|j| if j % panels == 0 { even(j) } else { even(j) + 2.0 / panels as f64 * random(j) })
            .collect();
        let map = EdgeBends::new(&aero, &arcs).unwrap();
        let bent = |states: &[[f64; 2]]| {
            let mut out = Vec::new();
            map.bends(states, &mut out);
            out
        };
        for bend in bent(&[[0.1, -2.0]; 16]) {
            assert!((bend.angle.re - 0.1).abs() < 1e-15 && (bend.angle.eps[0] + 2.0).abs() < 1e-14);
        }
        let shared = |edges: &[[f64; 3]]| {
            let mut loads = vec![0.0; 16];
            map.share(edges, &mut loads);
            loads
        };
        let around = |j: usize| 0.5 * (arcs[j.saturating_sub(1)] - arcs[(j + 1).min(panels)]);
        let even: Vec<[f64; 3]> = (0..=panels).map(|j| [0.0, 0.0, around(j)]).collect();
        let (loads, ends) = (shared(&even), aero.bent().unwrap().arcs());
        for (k, load) in loads.iter().enumerate() {
            // What lies between the last strip and the tip counts to that strip.
            let from = if k == 0 { arcs[0] } else { ends[k] };
            let width = from - if k == 15 { arcs[panels] } else { ends[k + 1] };
            assert!((load - width).abs() < 1e-13, "{panels} {k}: {load} {width}");
        }
        let states: Vec<[f64; 2]> = (0..16).map(|k| [random(k + 7), 0.0]).collect();
        let loads: Vec<[f64; 3]> = (0..=panels).map(|j| [0.0, 0.0, random(3 * j + 1)]).collect();
        let on_edges: f64 =
            bent(&states).iter().zip(&loads).map(|(bend, load)| bend.angle.re * load[2]).sum();
        let on_states: f64 = shared(&loads).iter().zip(&states).map(|(load, state)| load * state[0]).sum();
        assert!((on_edges - on_states).abs() < 1e-13, "{panels}: {on_edges} {on_states}");
    }
}

/// The film's own mass is not what makes state and pressure hard to find together: what a membrane yields against has the air's mass too. So a
/// film next to without weight takes about as many trials as a heavy one.
#[test]
fn light_films_take_no_more_trials_than_heavy_ones() {
    let most = [0.1, 1.0, 950.0].map(|density| {
        let density = format!("robot.surfaces[0].membrane.density_kg_m3={density}");
        let run = fly(&open(shipped("sail_glide.toml", &[LATTICE, "flight.duration_s=0.1", &density])));
        run.summary.lattice.unwrap().iterations_most
    });
    assert!(most[0] <= most[2] && most[1] <= most[2] && most[2] < 12, "{most:?}");
}
