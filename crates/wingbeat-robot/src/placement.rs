//! Where the sections of a surface ride: its panels on links.

use super::clearance::Corner;
use super::mechanism::Mechanism;
use super::sections::{SurfaceSection, Web};
use super::spec::{PanelSpec, SurfaceSpec};
use arrayvec::ArrayVec;
use wingbeat_aero::{COORDINATE, Planform, Span, walk_web};
use wingbeat_math::Error;
use wingbeat_math::{DeclaredQuantity, Parameters, Scalar, Vec3, Walk};

/// Where a panel lies on its link; of a symmetric surface that of the left half.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanelNumbers<P: Scalar = f64> {
    /// Arc length from the root at which it begins, m.
    pub from_arc: P,
    /// Its begin in the link's frame, m.
    pub origin: Vec3<P>,
    /// Direction along the span from the root on, in the link's frame, dimensionless; its length does not matter.
    pub direction: Vec3<P>,
    /// Length over which chord lines pass over from the panel before, m.
    pub web: P,
    /// Whether it is the next piece of a spar, over which the web of the first goes on.
    pub piece: bool,
}

/// Numbers of a surface's place on its links.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacementNumbers<P: Scalar = f64> {
    /// Shift of the outline forward, m.
    pub shift: P,
    /// Of its panels, from the root on.
    pub panels: Vec<PanelNumbers<P>>,
}

/// A component of a direction.
const DIRECTION: DeclaredQuantity = DeclaredQuantity::free("");

/// The first panel begins at the root by definition.
impl<P: Scalar> Parameters<P> for PlacementNumbers<P> {
    type In<Q: Scalar> = PlacementNumbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> PlacementNumbers<Q> {
        let panel = |at: &mut Walk<'_, P, Q>, (i, panel): (usize, &PanelNumbers<P>)| PanelNumbers {
            from_arc: match i {
                0 => at.fixed(panel.from_arc),
                _ => at.number("from_arc_m", &COORDINATE, panel.from_arc),
            },
            origin: at.vector("origin_m", &[COORDINATE; 3], panel.origin),
            direction: at.vector("direction", &[DIRECTION; 3], panel.direction),
            web: walk_web(at, panel.web),
            piece: panel.piece,
        };
        let panels = self.panels.iter().enumerate();
        PlacementNumbers {
            shift: at.number("planform_shift_m", &COORDINATE, self.shift),
            panels: panels.map(|p| at.item("panels", "panels", p.0, |at| panel(at, p))).collect(),
        }
    }
}

/// A link, none for the body, and a chord line in its frame, m: leading and trailing edge.
pub(super) type LinkLine<P> = (Option<usize>, [Vec3<P>; 2]);

/// Where two panels meet: the arc coordinate of the hinge, m, whether that is on the left, and the chord lines there of the inner and the
/// outer panel.
pub(super) struct PanelMeeting<P: Scalar> {
    pub at: P,
    pub left: bool,
    pub lines: [LinkLine<P>; 2],
}

/// A stretch of one half of a surface on a link.
#[derive(Clone, Copy, Debug)]
struct Panel<P: Scalar = f64> {
    from_arc: P,
    link: Option<usize>,
    /// Begin in the link's frame, m.
    origin: Vec3<P>,
    /// Unit vector of the span from the root on, in the link's frame.
    along: Vec3<P>,
    web: P,
    piece: bool,
}

impl<P: Scalar> Panel<P> {
    /// That of one half, `mirror` 1 on the left and -1 on the right.
    fn new(numbers: &PanelNumbers<P>, link: Option<usize>, mirror: f64) -> Self {
        let across = |v: Vec3<P>| Vec3([v[0], v[1] * mirror, v[2]]);
        let along = across(numbers.direction);
        Self {
            from_arc: numbers.from_arc,
            link,
            origin: across(numbers.origin),
            along: along * along.norm().recip(),
            web: numbers.web,
            piece: numbers.piece,
        }
    }

    /// The point `x` m ahead of the line of the panel at the arc length `arc`, in the link's frame.
    fn point(&self, arc: P, x: P) -> Vec3<P> {
        self.origin + self.along * (arc - self.from_arc) + Vec3([x, P::ZERO, P::ZERO])
    }
}

/// Geometry of a surface on its links.
#[derive(Clone, Debug)]
pub(super) struct Placement<P: Scalar = f64> {
    pub(super) planform: Planform<P>,
    shift: P,
    /// Panels of the left and right half, from the root on.
    panels: [Vec<Panel<P>>; 2],
}

impl Placement {
    pub(super) fn new(spec: &SurfaceSpec, mechanism: &Mechanism) -> Result<Self, Error> {
        let links = |side: usize| -> Result<Vec<Option<usize>>, Error> {
            let link =
                |(i, p): (usize, &PanelSpec)| mechanism.link_on(&format!("panels[{i}].link"), &p.link, side);
            spec.panels.iter().enumerate().map(link).collect()
        };
        // A one-sided surface lies where it is written; its side only orders its strips.
        let right = links(usize::from(spec.span == Span::Symmetric))?;
        Ok(Self::laid(spec.outline()?, &spec.placement(), &[links(0)?, right]))
    }
}

impl SurfaceSpec {
    /// Where it says that its panels lie.
    pub(super) fn placement(&self) -> PlacementNumbers {
        PlacementNumbers {
            shift: self.planform_shift_m,
            panels: self.panels.iter().map(|panel| panel.numbers(self.span)).collect(),
        }
    }
}

impl PanelSpec {
    /// The name of its begin.
    pub(super) fn begin(&self) -> String {
        self.name.clone().unwrap_or_else(|| self.link.clone())
    }

    /// Where it says that it lies.
    pub(super) fn numbers(&self, span: Span) -> PanelNumbers {
        PanelNumbers {
            from_arc: self.from_arc_m,
            origin: Vec3(self.origin_m),
            direction: Vec3(self.along(span)),
            web: self.web_m,
            piece: self.piece,
        }
    }
}

impl<P: Scalar> Placement<P> {
    /// An outline on panels, whose links of both halves are `links`.
    pub(super) fn laid(
        planform: Planform<P>,
        numbers: &PlacementNumbers<P>,
        links: &[Vec<Option<usize>>; 2],
    ) -> Self {
        let mirror = if planform.span() == Span::Symmetric { [1.0, -1.0] } else { [1.0, 1.0] };
        let half = |side: usize| {
            let panels = numbers.panels.iter().zip(&links[side]);
            panels.map(|(panel, link)| Panel::new(panel, *link, mirror[side])).collect()
        };
        Self { planform, shift: numbers.shift, panels: [half(0), half(1)] }
    }

    /// The links of the panels of both halves.
    pub(super) fn links(&self) -> [Vec<Option<usize>>; 2] {
        [0, 1].map(|side| self.panels[side].iter().map(|panel| panel.link).collect())
    }

    /// The section at the arc coordinate `s`, m. A section on a hinge belongs to the inner link.
    pub(super) fn section(&self, s: P, carriers: &[usize]) -> SurfaceSection<P> {
        let (leading, trailing) = self.planform.edges(s);
        let (arc, left) = (self.planform.from_root(s), self.planform.on_left(s));
        let panels = &self.panels[usize::from(!left)];
        let passed = panels.iter().skip(1).filter(|p| self.planform.beyond(arc, p.from_arc)).count();
        let panel = &panels[passed];
        let edge = |x: P| panel.point(arc, x + self.shift);
        let carrier = panel.link.and_then(|link| carriers.iter().position(|c| *c == link));
        let across = if left { -panel.along } else { panel.along };
        SurfaceSection::new(panel.link, carrier, [edge(leading), edge(trailing)], across)
    }

    /// Where one panel ends and the next begins, for each half.
    pub(super) fn meetings(&self) -> Vec<PanelMeeting<P>> {
        let mut meetings = Vec::new();
        for (half, panels) in self.panels.iter().enumerate() {
            for pair in panels.windows(2) {
                let arc = pair[1].from_arc;
                let here = self
                    .planform
                    .coordinates(arc)
                    .into_iter()
                    .filter(|s| self.planform.on_left(*s) == (half == 0));
                meetings.extend(here.map(|s| {
                    let (leading, trailing) = self.planform.edges(s);
                    let line =
                        |panel: &Panel<P>| [leading, trailing].map(|x| panel.point(arc, x + self.shift));
                    let lines = [0, 1].map(|i| (pair[i].link, line(&pair[i])));
                    PanelMeeting { at: s, left: half == 0, lines }
                }));
            }
        }
        meetings
    }

    /// The chord line at the arc coordinate `s` (m), where the surface passes over from one link to the next: at b = (arc - h)/w beyond
    /// the hinge h, w the length of the web, the outer link's is moved by (1 - b) of what the chord lines of both links on the hinge
    /// differ by. A fold does not change it, and a twist grows from none to its own. Written as the sum of (1 - b) of a line fixed to the
    /// inner link and b of one fixed to the outer; on a further piece of a spar, of its own line and (1 - b) of what the inner link and
    /// the spar's first piece differ by.
    ///
    /// Equation: robot.web
    /// `line = outer(s) + (1 - b) [inner(h) - outer(h)], b = (s - h)/w`
    /// Source: choice: a ruled surface, as one strip over the web has it.
    /// Test: `a_web_makes_the_air_of_a_twisted_wing_converge_with_its_strips`.
    pub(super) fn web(&self, s: P, carriers: &[usize]) -> Option<Web<P>> {
        let (arc, left) = (self.planform.from_root(s), self.planform.on_left(s));
        let panels = &self.panels[usize::from(!left)];
        let passed = panels.iter().skip(1).filter(|p| self.planform.beyond(arc, p.from_arc)).count();
        let first = (0..=passed).rev().find(|k| !panels[*k].piece)?;
        let (before, begun, panel) = (panels.get(first.checked_sub(1)?)?, &panels[first], &panels[passed]);
        let hinge = begun.from_arc;
        if !self.planform.beyond(hinge + begun.web, arc) {
            return None;
        }
        let on_hinge =
            self.planform.coordinates(hinge).into_iter().find(|s| self.planform.on_left(*s) == left)?;
        let share = (arc - hinge) / begun.web;
        let rest = P::ONE - share;
        let [(leading, trailing), (h_leading, h_trailing)] = [s, on_hinge].map(|s| self.planform.edges(s));
        let outer = |x: P, h_x: P| {
            let [here, there] = [panel.point(arc, x + self.shift), panel.point(hinge, h_x + self.shift)];
            (here - there * rest) * share.recip()
        };
        let inner = |h_x: P| before.point(hinge, h_x + self.shift);
        let on = |panel: &Panel<P>, edges: [Vec3<P>; 2]| {
            let carrier = panel.link.and_then(|link| carriers.iter().position(|c| *c == link));
            SurfaceSection::new(panel.link, carrier, edges, if left { -panel.along } else { panel.along })
        };
        let mut outer_parts = ArrayVec::new();
        if panel.piece {
            let on_first = [h_leading, h_trailing].map(|x| begun.point(hinge, x + self.shift));
            outer_parts.push((self.section(s, carriers), P::ONE));
            outer_parts.push((on(begun, on_first), -rest));
        } else {
            outer_parts.push((on(panel, [outer(leading, h_leading), outer(trailing, h_trailing)]), share));
        }
        Some(Web { inner: on(before, [inner(h_leading), inner(h_trailing)]), outer: outer_parts })
    }
}

impl Placement {
    /// Corners of panel `i` of one half (0 left, 1 right) on `link`: both edges at its ends, at the stations in
    /// between and at the ends of gaps. Between them the outline is straight.
    fn panel_corners(&self, i: usize, half: usize, link: usize) -> impl Iterator<Item = Corner> {
        let panel = self.panels[half][i];
        let tip = self.planform.station_arcs().last().copied().unwrap_or_default();
        let end = self.panels[half].get(i + 1).map_or(tip, |next| next.from_arc);
        let side = if half == 0 { 1.0 } else { -1.0 };
        let gaps = self.planform.gaps().iter().flat_map(|g| [g.from_arc_m, g.to_arc_m]);
        let inner = self.planform.station_arcs().iter().copied().chain(gaps);
        let inner = inner.filter(move |&arc| arc > panel.from_arc && arc < end);
        let arcs = [panel.from_arc, end].into_iter().chain(inner).filter(|&arc| self.planform.covers(arc));
        arcs.flat_map(move |arc| {
            let (leading, trailing) = self.planform.edges(arc);
            let corner = |x: f64| Corner { link, place: panel.point(arc, x + self.shift), side };
            [corner(leading), corner(trailing)]
        })
    }

    /// Arc coordinates of stations, ends of gaps and hinges from left to right, m.
    pub(super) fn stations(&self) -> Vec<f64> {
        let hinges = self.panels[0].iter().skip(1).map(|panel| panel.from_arc);
        let gaps = self.planform.gaps().iter().flat_map(|gap| [gap.from_arc_m, gap.to_arc_m]);
        let arcs = self.planform.station_arcs().iter().copied().chain(hinges).chain(gaps);
        let mut all: Vec<f64> = arcs.flat_map(|arc| self.planform.coordinates(arc)).collect();
        wingbeat_math::order::descend(&mut all);
        all.dedup();
        all
    }

    /// Ends of the panels from left to right: arc coordinate and name.
    pub(super) fn ends(&self, panels: &[PanelSpec]) -> Vec<(f64, String)> {
        let named = |s: f64, name: &str| match (self.planform.span(), s >= 0.0) {
            (Span::Symmetric, true) => (s, format!("left_{name}")),
            (Span::Symmetric, false) => (s, format!("right_{name}")),
            _ => (s, name.to_string()),
        };
        let inner = panels[1..].iter().map(|p| (p.from_arc_m, p.begin()));
        let root = (self.planform.span() != Span::Symmetric).then(|| (0.0, "root".to_string()));
        let tip = (self.planform.half_span(), "tip".to_string());
        let tip = if root.is_some() { (2.0 * tip.0, tip.1) } else { tip };
        let arcs = root.into_iter().chain(inner).chain([tip]);
        let at = |(arc, name): (f64, String)| {
            self.planform.coordinates(arc).into_iter().map(move |s| (s, name.clone()))
        };
        let mut ends: Vec<(f64, String)> = arcs.flat_map(at).map(|(s, name)| named(s, &name)).collect();
        wingbeat_math::order::descend_by(&mut ends, |item| item.0);
        ends
    }
}

/// Corners of both halves of a symmetric surface, where these ride on links of their own side; none otherwise.
pub(super) fn corners(spec: &SurfaceSpec, mechanism: &Mechanism) -> Result<Vec<Corner>, Error> {
    let placement = Placement::new(spec, mechanism)?;
    let mut corners = Vec::new();
    if spec.span == Span::Symmetric {
        let links = |i: usize| [0, 1].map(|half| placement.panels[half][i].link);
        for i in 0..spec.panels.len() {
            let [Some(left), Some(right)] = links(i) else { continue };
            // A link on both sides carries its surface across the plane.
            if left != right {
                corners.extend(placement.panel_corners(i, 0, left));
                corners.extend(placement.panel_corners(i, 1, right));
            }
        }
    }
    Ok(corners)
}
