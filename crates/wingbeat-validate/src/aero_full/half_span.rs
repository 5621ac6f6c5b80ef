//! What a half of a steady wing bears along its span, beside the lattice.

use super::STRIPS;
use super::wings;
use crate::lattice::steady_half;
use crate::{ComparisonRow, Error};
use wingbeat::aero::{
    Aero, LiftLaw, Loads, Planform, PlanformStation, ProfileDrag, SectionSettings, StripModel, StripSettings,
};
use wingbeat::math::Vec3;
use wingbeat::tether::{TetheredBody, Wing};

/// Incidence, rad.
const INCIDENCE: f64 = 0.1;
/// Panels of the lattice along the chord and a half of the span.
const PANELS: (usize, usize) = (16, 48);

/// Force along the span, outward, on the left half of `wing` by strips, and its lift, N, at 1 m/s in air of 1 kg/m3.
fn by_strips(wing: &Wing) -> Result<[f64; 2], Error> {
    let section = SectionSettings {
        law: LiftLaw::Linear,
        drag: ProfileDrag { cd0: 0.0, cd90: 0.0 },
        density_kg_m3: 1.0,
        ..Default::default()
    };
    let settings = StripSettings {
        strips: STRIPS,
        regularisation_m_s: 1e-6,
        edge_suction: Some(true),
        section,
        ..Default::default()
    };
    let model = Aero::Strip(StripModel::new(wing.planform(), settings)?);
    let wind = Vec3::new(-INCIDENCE.cos(), 0.0, INCIDENCE.sin());
    let frame = TetheredBody::rest().frame();
    let sections: Vec<_> = model.arcs().iter().map(|&arc| wing.section(arc, &frame, &[])).collect();
    let (mut x, mut dx) = (vec![0.0; model.states()], vec![0.0; model.states()]);
    let mut loads = Loads::default();
    for _ in 0..5000 {
        model.evaluate_in_numbers(&sections, wind, &x, &mut dx, &mut loads);
        x.iter_mut().zip(&dx).for_each(|(x, d)| *x += 0.06 * d);
    }
    let most = dx.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
    if most > 1e-6 {
        return Err(Error::NoAnswer(format!("states still move by {most} a second")));
    }
    let left = loads.strip[..STRIPS / 2].iter().fold(Vec3::ZERO, |sum, strip| sum + strip.total().force);
    Ok([left[1], left[2]])
}

/// A straight taper to .3 of the root's chord about the quarter line, of the aspect ratio 6.
fn tapered() -> Result<Planform, Error> {
    let station = |arc_m: f64, chord: f64| PlanformStation {
        arc_m,
        leading_edge_m: 0.25 * chord,
        trailing_edge_m: -0.75 * chord,
    };
    Ok(Planform::new(&[station(0.0, 1.0), station(1.95, 0.3)])?)
}

/// Half of each steady wing: what it bears along its span over its lift, beside the lattice, which on twice the panels changes by less than
/// 0.3 % (tapered 3.2 %). Where nothing turns the ninth of the tip's pull that is counted to the carried air is missing.
pub fn half_span() -> Result<Vec<ComparisonRow>, Error> {
    let taper = Wing::new(tapered()?, Vec::new())?;
    let wings = [
        ("rectangle_4", "AR 4", wings::rectangular(4.0)?.wing),
        ("rectangle_8", "AR 8", wings::rectangular(8.0)?.wing),
        ("swept", "AR 6, swept by 30 deg", wings::swept(6.0, 30.0)?.wing),
        ("forward", "AR 6, swept by -20 deg", wings::swept(6.0, -20.0)?.wing),
        ("tapered", "AR 6, taper 0.3", taper),
        ("aerobat", "Aerobat's, flat", wings::other("aerobat_flat")?.wing),
    ];
    let source = "the project's own lattice, 16 x 48 panels a half";
    let row = |(id, name, wing): (&str, &str, Wing)| {
        let [[own, lift], [panels, all]] = [by_strips(&wing)?, steady_half(&wing, INCIDENCE, PANELS)?];
        let [own, lattice] = [own / lift, panels / all];
        let metric = format!(
            "{name}: force along the span over lift of a half, {own:.4}, over the lattice's, {lattice:.4}, less 1"
        );
        let id = format!("aero.full.half_span.{id}");
        Ok(ComparisonRow::judged(&id, source, &metric, (own / lattice - 1.0).abs(), 0.1, ""))
    };
    wings.into_iter().map(row).collect()
}
