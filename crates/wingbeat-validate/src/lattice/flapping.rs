//! Large flapping: against PteraSoftware, between the two ways to the forces, and the circulation.

use super::wings::{flapper, lift_drag};
use crate::{ComparisonRow, Error, ReferenceTable, reference_table};
use wingbeat::math::Vec3;
use wingbeat_lattice::{
    Conventions, FlappingWing, Lattice, LatticeLoads, LatticeSettings, Panels, Scene, Spacing, WakeMotion,
};

/// Chord of the flapping wings, m.
pub const CHORD: f64 = 0.08;
/// Steps of a cycle, cycles, frequency (Hz) of the tables.
pub const STEPS: usize = 48;
const CYCLES: usize = 3;
const FREQUENCY: f64 = 3.5;
/// Kinematic viscosity of the tables, m2/s.
const VISCOSITY: f64 = 1.506e-5;
/// Core of the wake of our own, chords.
pub const CORE: f64 = 0.02;

/// A run and the lattice at its end.
pub fn run(
    wing: &FlappingWing,
    panels: Panels,
    steps_per_cycle: usize,
    wake: WakeMotion,
    conventions: Conventions,
) -> Result<(Vec<LatticeLoads>, Lattice), Error> {
    let own = LatticeSettings::new(1.0 / (FREQUENCY * steps_per_cycle as f64), CORE * CHORD);
    let settings = match conventions {
        Conventions::Own => own,
        Conventions::PteraSoftware => own.like_pterasoftware(CHORD, VISCOSITY),
    };
    let mut lattice = Lattice::new(Scene::new(wing, panels, true)?, LatticeSettings { wake, ..settings })?;
    let loads = (0..CYCLES * steps_per_cycle).map(|_| lattice.step()).collect::<Result<_, _>>()?;
    Ok((loads, lattice))
}

/// Steps the whole wing `steps` times with Lan's strips and cores of `core` chords, shows the lattice after each and returns it.
pub fn whole(
    wing: &FlappingWing,
    steps: usize,
    wake: WakeMotion,
    core: f64,
    mut show: impl FnMut(&Lattice),
) -> Result<Lattice, Error> {
    let panels = Panels { chordwise: 4, spanwise: 20, spacing: Spacing::Lan };
    let own = LatticeSettings::new(1.0 / (FREQUENCY * STEPS as f64), core * CHORD);
    let mut lattice = Lattice::new(Scene::new(wing, panels, false)?, LatticeSettings { wake, ..own })?;
    for _ in 0..steps {
        lattice.step()?;
        show(&lattice);
    }
    Ok(lattice)
}

/// Panels of the tables.
fn tabled() -> Panels {
    Panels { chordwise: 4, spanwise: 20, spacing: Spacing::Uniform }
}

/// Rms difference over the rms of `exact`, over the last cycle of `value`; both begin at rest.
fn apart(value: &[f64], exact: &[f64], cycle: usize) -> f64 {
    let last = value.len() - cycle..value.len();
    let (value, exact) = (&value[last.clone()], &exact[last]);
    let difference: f64 = value.iter().zip(exact).map(|(a, b)| (a - b).powi(2)).sum();
    (difference / exact.iter().map(|b| b * b).sum::<f64>()).sqrt()
}

/// Lift and drag of PteraSoftware beside the lattice with its conventions, and with our own.
fn against(
    id: &str,
    wing: &FlappingWing,
    wake: WakeMotion,
    table: &ReferenceTable,
) -> Result<Vec<ComparisonRow>, Error> {
    let exact = [table.column("lift_N")?, table.column("drag_N")?];
    let name = if wake == WakeMotion::Free { "free" } else { "prescribed" };
    let mut rows = Vec::new();
    for conventions in [Conventions::PteraSoftware, Conventions::Own] {
        let (loads, _) = run(wing, tabled(), STEPS, wake, conventions)?;
        let forces: Vec<(f64, f64)> = loads.iter().map(|l| lift_drag(l.joukowski.force)).collect();
        let lift: Vec<f64> = forces.iter().map(|f| f.0).collect();
        let drag: Vec<f64> = forces.iter().map(|f| f.1).collect();
        let errors = [apart(&lift, &exact[0], STEPS), apart(&drag, &exact[1], STEPS)];
        let source = format!("PteraSoftware 5.1.0, {name} wake");
        for (of, error) in ["lift", "drag"].into_iter().zip(errors) {
            rows.push(match conventions {
                Conventions::PteraSoftware => {
                    let metric = format!("its conventions: rms error of {of} over its rms");
                    ComparisonRow::judged(&format!("{id}.{name}.{of}"), &source, &metric, error, 0.03, "")
                }
                Conventions::Own => {
                    let metric = format!("our own conventions: rms difference of {of} over its rms");
                    ComparisonRow::shown(&format!("{id}.{name}.own_{of}"), &source, &metric, error, "")
                }
            });
        }
    }
    Ok(rows)
}

/// Small flapping.
pub fn f1() -> Result<Vec<ComparisonRow>, Error> {
    let wing = flapper(0.2, 5.0, None)?;
    let free = reference_table!("uvlm/flap_F1_R0.20_phi5_a5_free.csv")?;
    let prescribed = reference_table!("uvlm/flap_F1_R0.20_phi5_a5_prescribed.csv")?;
    let mut rows = against("lattice.f1", &wing, WakeMotion::Prescribed, &prescribed)?;
    rows.extend(against("lattice.f1", &wing, WakeMotion::Free, &free)?);
    Ok(rows)
}

/// Large flapping.
pub fn f2() -> Result<Vec<ComparisonRow>, Error> {
    let wing = flapper(0.2, 35.0, None)?;
    let free = reference_table!("uvlm/flap_F2_R0.20_phi35_a5_free.csv")?;
    let prescribed = reference_table!("uvlm/flap_F2_R0.20_phi35_a5_prescribed.csv")?;
    let mut rows = against("lattice.f2", &wing, WakeMotion::Prescribed, &prescribed)?;
    rows.extend(against("lattice.f2", &wing, WakeMotion::Free, &free)?);
    Ok(rows)
}

/// The wing that folds deeply, E1.
pub fn folding() -> Result<FlappingWing, Error> {
    flapper(0.25, 30.0, Some((0.45, 50.0)))
}

/// Lift in the last cycle of a wing that flaps and folds, N, means unless said.
pub struct FoldedLift {
    /// By Joukowski, N.
    pub joukowski: f64,
    /// By Bernoulli with the suction of the leading edge, which lacks that of the side edges, N.
    pub bernoulli: f64,
    /// Root mean square of the first about its mean, N.
    pub swing: f64,
}

/// Lift of a wing that flaps by `flap_deg` and folds down by `fold_deg` as E1 does, with cores of `core` chords in the wake.
pub fn deep_fold([flap_deg, fold_deg]: [f64; 2], wake: WakeMotion, core: f64) -> Result<FoldedLift, Error> {
    let wing = flapper(0.25, flap_deg, Some((0.45, fold_deg)))?;
    let panels = Panels { chordwise: 8, spanwise: 24, spacing: Spacing::Lan };
    let settings =
        LatticeSettings { wake, ..LatticeSettings::new(1.0 / (FREQUENCY * STEPS as f64), core * CHORD) };
    let mut lattice = Lattice::new(Scene::new(&wing, panels, true)?, settings)?;
    let loads = (0..CYCLES * STEPS).map(|_| lattice.step()).collect::<Result<Vec<_>, _>>()?;
    let last = &loads[loads.len() - STEPS..];
    let lifts =
        |of: fn(&LatticeLoads) -> Vec3| -> Vec<f64> { last.iter().map(|l| lift_drag(of(l)).0).collect() };
    let mean = |lifts: &[f64]| lifts.iter().sum::<f64>() / STEPS as f64;
    let own = lifts(|l| l.joukowski.force);
    let joukowski = mean(&own);
    let square = own.iter().map(|lift| (lift - joukowski).powi(2)).sum::<f64>() / STEPS as f64;
    let bernoulli = mean(&lifts(|l| l.bernoulli.force));
    Ok(FoldedLift { joukowski, bernoulli, swing: square.sqrt() })
}

/// Circulation of every strip and its wake.
pub fn kelvin() -> Result<Vec<ComparisonRow>, Error> {
    let wing = folding()?;
    let panels = Panels { chordwise: 4, spanwise: 20, spacing: Spacing::Lan };
    let (_, lattice) = run(&wing, panels, STEPS, WakeMotion::Prescribed, Conventions::Own)?;
    let metric = "flap_fold: largest circulation around a strip and its wake over that of the largest ring";
    let error = lattice.circulation_error();
    Ok(vec![ComparisonRow::judged("lattice.kelvin", "Kelvin 1869", metric, error, 1e-12, "")])
}

/// Forces over two cycles: along the normals, by Bernoulli and Joukowski, and forward, suction added to Bernoulli.
fn both_ways(chordwise: usize, steps: usize) -> Result<[[Vec<f64>; 2]; 2], Error> {
    let panels = Panels { chordwise, spanwise: 20, spacing: Spacing::Lan };
    let settings = LatticeSettings::new(1.0 / (FREQUENCY * steps as f64), CORE * CHORD);
    let mut lattice = Lattice::new(Scene::new(&flapper(0.2, 35.0, None)?, panels, true)?, settings)?;
    let mut forces: [[Vec<f64>; 2]; 2] = Default::default();
    for _ in 0..2 * steps {
        let loads = lattice.step()?;
        for (mesh, own) in lattice.meshes().iter().zip(&loads.panels) {
            let along = |forces: &[Vec3]| -> f64 {
                forces.iter().zip(&mesh.controls).map(|(force, control)| force.dot(control.normal)).sum()
            };
            forces[0][0].push(along(&own.bernoulli));
            forces[0][1].push(along(&own.joukowski));
        }
        forces[1][0].push(loads.bernoulli.force[0]);
        forces[1][1].push(loads.joukowski.force[0]);
    }
    Ok(forces)
}

/// Joukowski against Bernoulli, which acts along the normals alone.
pub fn force_methods_agree() -> Result<Vec<ComparisonRow>, Error> {
    let steps = 80;
    let ([normal, forward], [_, fine]) = (both_ways(8, steps)?, both_ways(16, 2 * steps)?);
    let row = |id: &str, metric: &str, [a, b]: &[Vec<f64>; 2]| {
        ComparisonRow::judged(id, "Joukowski against Bernoulli", metric, apart(a, b, steps), 0.02, "")
    };
    let limit = [0, 1].map(|way| {
        let at_same_time = fine[way].iter().step_by(2);
        forward[way].iter().zip(at_same_time).map(|(coarse, fine)| 2.0 * fine - coarse).collect::<Vec<f64>>()
    });
    let plain = apart(&forward[0], &forward[1], steps);
    let metric = format!(
        "the same of the forward force, suction added to Bernoulli, extrapolated from 8 and 16 panels ({plain:.3} at 8)"
    );
    Ok(vec![
        row(
            "lattice.force_methods_agree.normal",
            "F2, 8 x 20 panels: rms difference of the force along the normals",
            &normal,
        ),
        ComparisonRow::shown(
            "lattice.force_methods_agree.forward",
            "Joukowski against Bernoulli",
            &metric,
            apart(&limit[0], &limit[1], steps),
            "",
        ),
    ])
}
