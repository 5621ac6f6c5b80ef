//! The wings of the comparisons.

use crate::Error;
use std::f64::consts::PI;
use wingbeat::aero::{Planform, PlanformStation};
use wingbeat::math::Jet;
use wingbeat::tether::{Hinge, HingeKind, Side, Wing};

/// A wing at rest with what its table says of it.
#[derive(Clone, Debug)]
pub struct Still {
    /// Planform and hinges.
    pub wing: Wing,
    /// Angles of the hinges, rad.
    pub angles: Vec<Jet<f64>>,
    /// Area to which force coefficients refer, m2.
    pub area: f64,
    /// Length to which reduced frequencies refer, m.
    pub chord: f64,
    /// Origin of pitch axes, m ahead of the hinge line.
    pub origin: f64,
}

impl Still {
    fn flat(planform: Planform, area: f64, chord: f64, origin: f64) -> Result<Self, Error> {
        Ok(Self { wing: Wing::new(planform, Vec::new())?, angles: Vec::new(), area, chord, origin })
    }

    /// Arcs of the hinges, m.
    pub fn hinges(&self) -> Vec<f64> {
        self.wing.hinges().iter().map(|h| h.arc_m).collect()
    }
}

/// A planform from rows of arc, leading and trailing edge (m, forward positive).
fn planform(rows: &[[f64; 3]]) -> Result<Planform, Error> {
    let station = |&[arc_m, leading_edge_m, trailing_edge_m]: &[f64; 3]| PlanformStation {
        arc_m,
        leading_edge_m,
        trailing_edge_m,
    };
    Ok(Planform::new(&rows.iter().map(station).collect::<Vec<_>>())?)
}

/// A rectangle of `span` and `chord` (both in m) with its leading edge on the hinge line.
pub fn rectangle(span: f64, chord: f64) -> Result<Planform, Error> {
    planform(&[[0.0, 0.0, -chord], [0.5 * span, 0.0, -chord]])
}

/// A flat rectangular wing of a chord of 1 m and the aspect ratio `aspect`.
pub fn rectangular(aspect: f64) -> Result<Still, Error> {
    Still::flat(rectangle(aspect, 1.0)?, aspect, 1.0, 0.0)
}

/// A flat wing of a chord of 1 m and the aspect ratio `aspect`, swept back by `degrees`.
pub fn swept(aspect: f64, degrees: f64) -> Result<Still, Error> {
    let back = 0.5 * aspect * degrees.to_radians().tan();
    let rows = [[0.0, 0.0, -1.0], [0.5 * aspect, -back, -1.0 - back]];
    Still::flat(planform(&rows)?, aspect, 1.0, 0.0)
}

/// Hinges at two arcs (m) that fold the panels outside of them to the dihedrals `inner` and `outer` (degrees).
fn shoulder_and_elbow([shoulder, elbow]: [f64; 2], inner: f64, outer: f64) -> (Vec<Hinge>, Vec<Jet<f64>>) {
    let hinge = |kind, arc_m| Hinge { kind, side: Side::Both, arc_m, to_arc_m: None, ahead_m: 0.0 };
    let hinges = vec![hinge(HingeKind::Flap, shoulder), hinge(HingeKind::Fold, elbow)];
    (hinges, [inner, outer - inner].map(|a| Jet::from(a.to_radians())).to_vec())
}

/// A rectangular wing of unit chord: each half at the dihedral `inner` up to the arc 1 m, then at
/// `outer` (degrees).
pub fn folded(aspect: f64, inner: f64, outer: f64) -> Result<Still, Error> {
    let (hinges, angles) = shoulder_and_elbow([0.0, 1.0], inner, outer);
    let wing = Wing::new(rectangle(aspect, 1.0)?, hinges)?;
    Ok(Still { wing, angles, area: aspect, chord: 1.0, origin: 0.0 })
}

/// A wing of lifting_surface/other_wings.csv, with the area and mean chord in its header.
pub fn other(name: &str) -> Result<Still, Error> {
    let still = match name {
        "rect4" => Still { area: 3.992107, ..rectangular(4.0)? },
        "ell4" => Still::flat(ellipse(4.0)?, 2.456436, 0.783454, 0.25)?,
        "tap.4_AR6" => Still::flat(planform(&[[0.0, 0.25, -0.75], [2.1, 0.1, -0.3]])?, 2.934199, 0.7, 0.25)?,
        "swept30_AR6" => Still { area: 5.988160, ..swept(6.0, 30.0)? },
        "aerobat_flat" => aerobat()?,
        "elbow-60_rect6" => Still { area: 5.868524, ..folded(6.0, 15.0, -60.0)? },
        unknown => {
            return Err(Error::reference("lifting_surface/other_wings.csv", format!("no wing {unknown}")));
        }
    };
    Ok(still)
}

/// Ellipse of root chord 1 m and the aspect ratio `aspect`, straight quarter chord.
pub fn ellipse(aspect: f64) -> Result<Planform, Error> {
    let span = 0.25 * aspect * PI;
    let rows: Vec<[f64; 3]> = (0..=200)
        .map(|i| {
            let angle = f64::from(i) / 400.0 * PI;
            let chord = angle.cos().max(1e-3);
            [angle.sin() * 0.5 * span, 0.25 * chord, -0.75 * chord]
        })
        .collect();
    planform(&rows)
}

/// Aerobat's planform in units of 0.1 m; pitch axes count from its hinge line.
fn aerobat() -> Result<Still, Error> {
    let rows = [
        [0.0, 0.635, -0.956],
        [0.25, 0.635, -0.956],
        [0.75, 0.765, -1.11],
        [0.835, 0.807, -1.15],
        [1.59, 1.18, 0.1705],
        [2.07, 1.01, 0.81],
    ];
    Still::flat(planform(&rows)?, 5.639158, 1.364809, 0.0)
}

/// Aerobat's planform, folded at its shoulders and elbows to the dihedrals `inner` and `outer` (degrees).
pub fn aerobat_folded(inner: f64, outer: f64) -> Result<Still, Error> {
    let flat = aerobat()?;
    let (hinges, angles) = shoulder_and_elbow([0.207, 0.707], inner, outer);
    Ok(Still { wing: Wing::new(flat.wing.planform().clone(), hinges)?, angles, ..flat })
}
