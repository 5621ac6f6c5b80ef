//! Where panels lie on a wing's planform.

use crate::Error;
use wingbeat::aero::{AngleMap, Planform, lan_spacing};

/// How strips lie along the span.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spacing {
    /// Lan's: narrow at the tips, edges a little short of them, control points where the sums over strips are exact.
    #[default]
    Lan,
    /// Alike between hinges, control points in the middle.
    Uniform,
}

/// Panels of one piece of wing: strips between arc coordinates, each divided evenly along its chord, so that vortices at 1/4 and
/// control points at 3/4 of the panels stand evenly.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelLayout {
    /// Panels along the chord.
    pub chordwise: usize,
    /// Arc coordinates of the strips' edges from left to right, m (left positive).
    pub arcs: Vec<f64>,
    /// Place of the control points between the edges of their strip, as shares of its width.
    pub fractions: Vec<f64>,
}

/// Share of the half span below which two arcs are one.
const SAME: f64 = 1e-9;

impl PanelLayout {
    /// The pieces of `planform` between gaps, from left to right, `spanwise` strips in all; an edge lies on each of
    /// `hinge_arcs` (arc lengths from the root, m).
    ///
    /// # Errors
    /// No panel, or too few strips for the hinges.
    pub fn of(
        planform: &Planform,
        hinge_arcs: &[f64],
        chordwise: usize,
        spanwise: usize,
        spacing: Spacing,
    ) -> Result<Vec<Self>, Error> {
        for (key, value) in [("chordwise", chordwise), ("spanwise", spanwise)] {
            if value == 0 {
                return Err(Error::Setting { key, value: 0.0, allowed: "1 or more".into() });
            }
        }
        let (arcs, fractions) = match spacing {
            Spacing::Lan => {
                let laid = lan_spacing(planform, spanwise, hinge_arcs, AngleMap::Straight)?;
                let (edges, fractions) = (laid.edges, laid.fractions);
                // Edges are laid against the arc coordinate.
                (edges.into_iter().map(|edge| -edge).collect(), fractions)
            }
            Spacing::Uniform => uniform(planform, hinge_arcs, spanwise)?,
        };
        Ok(pieces(planform, &arcs, &fractions, chordwise))
    }

    /// The part left of the plane of symmetry; none where no edge lies there.
    pub fn left_half(&self) -> Option<Self> {
        let tip = self.arcs.iter().fold(0.0_f64, |tip, arc| tip.max(arc.abs()));
        let kept = self.arcs.iter().take_while(|arc| **arc > SAME * tip).count();
        match self.arcs.get(kept) {
            _ if kept == self.arcs.len() => Some(self.clone()),
            Some(arc) if arc.abs() <= SAME * tip && kept > 0 => {
                let arcs = self.arcs[..kept].iter().copied().chain([0.0]).collect();
                Some(Self { chordwise: self.chordwise, arcs, fractions: self.fractions[..kept].to_vec() })
            }
            _ => None,
        }
    }

    /// Number of strips.
    pub fn strips(&self) -> usize {
        self.fractions.len()
    }

    /// Number of panels.
    pub fn panels(&self) -> usize {
        self.chordwise * self.strips()
    }
}

/// Edges evenly between tips, hinges and gaps, as many as fit the lengths.
fn uniform(planform: &Planform, hinge_arcs: &[f64], spanwise: usize) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let tip = planform.half_span();
    let at_gaps = planform.gaps().iter().flat_map(|gap| [gap.from_arc_m, gap.to_arc_m]);
    let inner = hinge_arcs.iter().copied().chain(at_gaps).flat_map(|arc| planform.coordinates(arc));
    let mut bounds: Vec<f64> = inner.filter(|arc| arc.abs() < tip).chain([tip, -tip]).collect();
    wingbeat::math::order::descend(&mut bounds);
    bounds.dedup_by(|a, b| (*a - *b).abs() <= SAME * tip);
    let pieces = bounds.len() - 1;
    if spanwise < pieces {
        let allowed = format!("{pieces} or more: one for every piece between tips and hinges");
        return Err(Error::Setting { key: "spanwise", value: spanwise as f64, allowed });
    }
    let lengths: Vec<f64> = bounds.windows(2).map(|pair| pair[0] - pair[1]).collect();
    let mut counts = vec![1; pieces];
    for _ in pieces..spanwise {
        let width = |i: &usize| lengths[*i] / counts[*i] as f64;
        // Of pieces alike the outer ones first, from either side in turn.
        let rank = |i: &usize| (width(i) * (1.0 + SAME * (2 * i).abs_diff(pieces - 1) as f64), counts[*i]);
        let widest = (0..pieces).max_by(|a, b| rank(a).0.total_cmp(&rank(b).0)).unwrap_or(0);
        counts[widest] += 1;
    }
    let piece = |i: usize| (0..counts[i]).map(move |k| (i, k));
    let place = |(i, k): (usize, usize)| bounds[i] - lengths[i] * k as f64 / counts[i] as f64;
    let arcs = (0..pieces).flat_map(piece).map(place).chain([-tip]).collect();
    Ok((arcs, vec![0.5; spanwise]))
}

/// The stretches of strips that are covered.
fn pieces(planform: &Planform, arcs: &[f64], fractions: &[f64], chordwise: usize) -> Vec<PanelLayout> {
    let mut pieces = Vec::new();
    let mut open: Option<PanelLayout> = None;
    for (j, fraction) in fractions.iter().enumerate() {
        if !planform.covers(0.5 * (arcs[j] + arcs[j + 1])) {
            pieces.extend(open.take());
            continue;
        }
        let piece =
            open.get_or_insert_with(|| PanelLayout { chordwise, arcs: vec![arcs[j]], fractions: Vec::new() });
        piece.arcs.push(arcs[j + 1]);
        piece.fractions.push(*fraction);
    }
    pieces.extend(open);
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::aero::{Gap, PlanformStation};

    fn rectangle(half_span: f64) -> Planform {
        let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -1.0 };
        Planform::new(&[station(0.0), station(half_span)]).unwrap()
    }

    #[test]
    fn edges_lie_on_hinges_and_mirror_each_other() {
        for spacing in [Spacing::Lan, Spacing::Uniform] {
            let pieces = PanelLayout::of(&rectangle(2.0), &[0.0, 0.9], 4, 12, spacing).unwrap();
            let [piece] = &pieces[..] else { panic!("{} pieces", pieces.len()) };
            assert_eq!((piece.strips(), piece.panels()), (12, 48));
            for hinge in [0.9, 0.0, -0.9] {
                assert!(piece.arcs.iter().any(|arc| (arc - hinge).abs() < 1e-12), "{hinge}");
            }
            let mirrored = piece.arcs.iter().zip(piece.arcs.iter().rev());
            assert!(mirrored.clone().all(|(a, b)| (a + b).abs() < 1e-12));
            assert!(piece.arcs.windows(2).all(|pair| pair[0] > pair[1]));
            let half = piece.left_half().unwrap();
            assert_eq!((half.strips(), half.arcs[6]), (6, 0.0));
        }
    }

    #[test]
    fn gaps_part_the_wing_and_bad_counts_are_refused() {
        let parted = rectangle(2.0).with_gaps(&[Gap { from_arc_m: 0.0, to_arc_m: 0.3 }]).unwrap();
        for spacing in [Spacing::Lan, Spacing::Uniform] {
            let pieces = PanelLayout::of(&parted, &[], 2, 13, spacing).unwrap();
            assert_eq!(pieces.len(), 2, "{spacing:?} {pieces:?}");
            assert!(pieces[0].arcs.iter().all(|arc| *arc > 0.29));
            assert!(pieces[0].left_half().is_some() && pieces[1].left_half().is_none());
        }
        let refused = |chordwise, spanwise, spacing| {
            PanelLayout::of(&rectangle(2.0), &[0.5], chordwise, spanwise, spacing).unwrap_err().to_string()
        };
        assert_eq!(refused(0, 8, Spacing::Lan), "chordwise = 0: allowed is 1 or more");
        let text = "spanwise = 2: allowed is 3 or more: one for every piece between tips and hinges";
        assert_eq!(refused(4, 2, Spacing::Uniform), text);
        assert!(PanelLayout::of(&rectangle(2.0), &[], 1, 1, Spacing::Lan).unwrap()[0].left_half().is_none());
    }
}
