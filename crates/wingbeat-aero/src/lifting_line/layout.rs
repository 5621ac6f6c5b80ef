//! Where the nodes lie on the wing and what of them follows from the outline alone.

use super::LiftingLineSettings;
use super::nodes::{Cell, cells, floored, influence, influence_between, node_angles};
use crate::Planform;
use std::f64::consts::PI;
use wingbeat_math::Error;
use wingbeat_math::Scalar;

/// Places, cells and mutual wash of the nodes.
#[derive(Clone, Debug)]
pub(super) struct NodeLayout<P: Scalar = f64> {
    /// Arcs of the sections: of the nodes, then of what else is looked at.
    pub arcs: Vec<P>,
    /// Chord in the middle, m.
    pub root_chord: P,
    pub widths: Vec<P>,
    pub cells: Vec<Cell<P>>,
    /// Wash per circulation, D_ij, row-major, 1/m.
    pub influence: Vec<P>,
    /// Whether D vanishes between different nodes an even number apart.
    pub alternating: bool,
}

impl<P: Scalar> NodeLayout<P> {
    /// Nodes at equal steps of the angle on a planform.
    pub fn smooth(planform: &Planform<P>, set: &LiftingLineSettings) -> Result<Self, Error> {
        refuse_gaps(planform)?;
        Ok(Self::of_chords(planform.half_span(), |arc| [planform.chord(arc), planform.sweep(arc)], set))
    }

    /// Nodes for cells that end at the hinges, whose arcs are in m.
    pub fn hinged(
        planform: &Planform<P>,
        hinge_arcs: &[P],
        set: &LiftingLineSettings,
    ) -> Result<Self, Error> {
        refuse_gaps(planform)?;
        let (mut arcs, cells, angles) = cells(planform, hinge_arcs, set)?;
        if set.as_printed {
            arcs.push(P::ZERO);
        }
        Ok(Self {
            arcs,
            root_chord: floored(planform.chord(P::ZERO), set),
            widths: cells.iter().map(|cell| cell.width).collect(),
            cells,
            influence: influence_between(&angles, planform.half_span() * 2.0),
            alternating: false,
        })
    }

    /// Nodes at equal steps of the angle on a wing of the given half span (m), and chord (m) and slope of the line of the
    /// quarter chords by arc (m).
    pub fn of_chords(half_span: P, section: impl Fn(P) -> [P; 2], set: &LiftingLineSettings) -> Self {
        let angles = node_angles(set.nodes);
        let mut arcs: Vec<P> = angles.iter().map(|t| half_span * t.cos()).collect();
        let step = PI / (set.nodes + 1) as f64;
        let widths: Vec<P> = angles.iter().map(|t| half_span * t.sin() * step).collect();
        let places = angles.iter().zip(&arcs).zip(&widths);
        let cells = places.map(|((&t, &arc), &width)| Cell::smooth(section(arc), width, half_span, t, set));
        let cells = cells.collect();
        let influence = influence(&angles, half_span * 2.0);
        if set.as_printed {
            arcs.push(P::ZERO);
        }
        Self {
            arcs,
            root_chord: floored(section(P::ZERO)[0], set),
            widths,
            cells,
            influence,
            alternating: true,
        }
    }

    /// The same layout in other numbers, `f` of each.
    pub fn map<Q: Scalar>(&self, f: impl Fn(P) -> Q) -> NodeLayout<Q> {
        let all = |numbers: &[P]| numbers.iter().map(|number| f(*number)).collect();
        let cell = |c: &Cell<P>| Cell {
            edge: f(c.edge),
            chord: f(c.chord),
            width: f(c.width),
            area: f(c.area),
            square: f(c.square),
            sweep: f(c.sweep),
        };
        NodeLayout {
            arcs: all(&self.arcs),
            root_chord: f(self.root_chord),
            widths: all(&self.widths),
            cells: self.cells.iter().map(cell).collect(),
            influence: all(&self.influence),
            alternating: self.alternating,
        }
    }
}

fn refuse_gaps<P: Scalar>(planform: &Planform<P>) -> Result<(), Error> {
    if planform.gaps().is_empty() {
        return Ok(());
    }
    let given = format!("{} gaps", planform.gaps().len());
    Err(Error::invalid("gaps", given, "none: one sine series spans the whole wing"))
}
