//! Spars of links: chains of rigid pieces on springs that stand for a beam.

use super::super::numbers::{DAMPING, STIFFNESS};
use super::{CapsuleSpec, ElasticSpec, LinkSide, LinkSpec, PanelSpec, RobotSpec, SurfaceSpec};
use crate::body::{INERTIA, MASS};
use crate::mechanism::SIDES;
use serde::{Deserialize, Serialize};
use wingbeat_aero::Planform;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require::finite;

/// A beam along the link's y axis from its joint on, as a chain of rigid pieces with springs between them that raise and twist:
/// links `NAME_1`, `NAME_2` and so on, each with a joint in the middle of a segment and the stiffness of that segment over its length. The
/// lowest bending frequency of a uniform cantilever comes out 6.1 % high with 2 segments, 2.6 % with 3 and 1.5 % with 4 (rows
/// `fsi.beam.segments`). Surfaces whose panel names the link ride on all pieces.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct LinkSparSpec {
    /// Length from the link's joint along y, m.
    pub length_m: f64,
    /// Number of segments.
    pub segments: usize,
    /// Bending stiffness E I about x at the root, N m2.
    pub bending_n_m2: f64,
    /// Bending stiffness about z, in the plane of the wing, at the root, N m2; without, it does not bend there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge_bending_n_m2: Option<f64>,
    /// Torsional stiffness G J at the root, N m2; without, it does not twist.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torsion_n_m2: Option<f64>,
    /// Mass per length at the root, kg/m, beside that of the link.
    pub mass_kg_m: f64,
    /// Centre of mass ahead of the link's y axis, m.
    #[serde(default)]
    pub ahead_m: f64,
    /// Inertia per length about the span at the root, kg m, through the centre of mass.
    #[serde(default)]
    pub inertia_kg_m: f64,
    /// Ratio of stiffness, mass and inertia at the tip to those at the root; linear between.
    #[serde(default = "one")]
    pub taper: f64,
    /// Damping over stiffness, s.
    #[serde(default)]
    pub damping_s: f64,
}

ranges!(LinkSparSpec {
    length_m: Range::POSITIVE,
    segments: Range::between(1.0, 8.0),
    bending_n_m2: Range::POSITIVE,
    edge_bending_n_m2: Range::POSITIVE,
    torsion_n_m2: Range::POSITIVE,
    mass_kg_m: Range::POSITIVE,
    inertia_kg_m: Range::NOT_NEGATIVE,
    taper: Range::between(0.01, 10.0),
    damping_s: Range::NOT_NEGATIVE,
});

/// Segments of a chain that stands for the beam itself: of order two, it errs a thousand times less than 2. *Choice.*
const MANY: usize = 64;
/// Stretches of a spar over which its chord is looked at. *Choice.*
const STATIONS: usize = 8;
/// Steps of the power method, in each of which the second motion of a uniform beam fades by 40, that of its twist by 9. *Choice.*
const POWERS: usize = 40;

fn one() -> f64 {
    1.0
}

/// A rigid piece of a spar, from `from` to `to` along it, m.
struct Piece {
    from: f64,
    to: f64,
}

impl LinkSparSpec {
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        finite("ahead_m", &[self.ahead_m])?;
        for (key, range, value) in [
            ("bending_n_m2", STIFFNESS.range, self.bending_n_m2 / self.segment()),
            ("damping_s", DAMPING.range, self.damping_s * self.bending_n_m2 / self.segment()),
            ("mass_kg_m", MASS.range, self.mass_kg_m * self.length_m),
            ("inertia_kg_m", INERTIA.range, self.inertia_kg_m * self.length_m),
        ] {
            range.check(key, value)?;
        }
        Ok(())
    }

    /// Length of a segment, m.
    fn segment(&self) -> f64 {
        self.length_m / self.segments as f64
    }

    /// Place of the joint `i` from 1 on along the spar, m.
    fn joint(&self, i: usize) -> f64 {
        (i as f64 - 0.5) * self.segment()
    }

    /// The piece at `y` m along the spar.
    fn piece_at(&self, y: f64) -> usize {
        (1..=self.segments).rev().find(|i| y >= self.joint(*i)).unwrap_or(0)
    }

    /// A capsule of the unbent link in parts, each in the frame of the piece along which it runs.
    fn parts(&self, capsule: &CapsuleSpec) -> impl Iterator<Item = (usize, CapsuleSpec)> {
        let (capsule, spar) = (*capsule, *self);
        let [from, to] = [capsule.from_m[1], capsule.to_m[1]];
        (0..=spar.segments).filter_map(move |i| {
            let begin = if i == 0 { f64::NEG_INFINITY } else { spar.joint(i) };
            let end = if i == spar.segments { f64::INFINITY } else { spar.joint(i + 1) };
            let [low, high] = [from.min(to).max(begin), from.max(to).min(end)];
            // A capsule across the spar rides on one piece.
            if !(low < high || low == high && spar.piece_at(low) == i) {
                return None;
            }
            let along = |y: f64| if from == to { 0.0 } else { (y - from) / (to - from) };
            let ends = if from == to { [0.0, 1.0] } else { [along(low), along(high)] };
            let base = if i == 0 { 0.0 } else { begin };
            let at = |share: f64| {
                let mut place = std::array::from_fn(|k| {
                    capsule.from_m[k] + share * (capsule.to_m[k] - capsule.from_m[k])
                });
                place[1] -= base;
                place
            };
            Some((i, CapsuleSpec { from_m: at(ends[0]), to_m: at(ends[1]), ..capsule }))
        })
    }

    /// What the numbers at the root are times at `y` m.
    fn share(&self, y: f64) -> f64 {
        1.0 + (self.taper - 1.0) * y / self.length_m
    }

    /// The spring of the joint `i` of the stiffness `root` at the root.
    pub(in super::super) fn spring(&self, i: usize, root: f64) -> ElasticSpec {
        let stiffness = root * self.share(self.joint(i)) / self.segment();
        ElasticSpec { stiffness, damping: self.damping_s * stiffness, rest: 0.0, start: None, stops: None }
    }

    fn piece(&self, i: usize) -> Piece {
        let from = if i == 0 { 0.0 } else { self.joint(i) };
        let to = if i == self.segments { self.length_m } else { self.joint(i + 1) };
        Piece { from, to }
    }

    /// Mass of the piece `i`, kg, the distance of its centre from its begin, m, and its radius of gyration about that across the spar, squared, m2.
    ///
    /// Equation: robot.spar_piece
    /// `c = l (1 + 2 r)/(3 (1 + r)), rho^2 = l^2 (1 + 4 r + r^2)/(18 (1 + r)^2), r the ratio of the mass per length at the ends`
    /// Source: moments of a linear distribution.
    /// Test: `a_tapered_spar_weighs_as_its_beam_does`.
    fn weighed(&self, i: usize) -> (f64, f64, f64) {
        let Piece { from, to } = self.piece(i);
        let length = to - from;
        let ratio = self.share(to) / self.share(from);
        let both = 1.0 + ratio;
        let centre = length * (1.0 + 2.0 * ratio) / (3.0 * both);
        let squared = length * length * (1.0 + 4.0 * ratio + ratio * ratio) / (18.0 * both * both);
        (self.mass_kg_m * self.share(0.5 * (from + to)) * length, centre, squared)
    }

    /// Lowest frequencies at which the chain bends and twists by itself, clamped at its root and without air, its masses on its line, Hz.
    ///
    /// Equation: robot.spar_frequency
    /// `k_j t_j = w^2 sum_k M_jk t_k; bending: M_jk = sum over pieces i >= j, k of m_i (c_i - y_j)(c_i - y_k) + m_i rho_i^2; torsion: of I_i + m_i a^2`
    /// Source: Lagrange's equations of rigid pieces on springs, small angles t_j.
    /// Test: `few_pieces_bend_and_twist_at_the_frequencies_of_the_page`.
    pub fn frequencies_hz(&self) -> [Option<f64>; 2] {
        [Some(self.lowest(self.bending_n_m2, true)), self.torsion_n_m2.map(|stiff| self.lowest(stiff, false))]
    }

    /// One of these, of the stiffness `root` at the root; it `bends` or twists.
    fn lowest(&self, root: f64, bends: bool) -> f64 {
        let joints = 1..=self.segments;
        let about =
            if bends { 0.0 } else { self.inertia_kg_m / self.mass_kg_m + self.ahead_m * self.ahead_m };
        // Mass, distance to its centre along the spar, and inertia of a piece.
        let piece = |i: usize| {
            let (mass, centre, squared) = self.weighed(i);
            (mass, self.piece(i).from + centre, mass * if bends { squared } else { about })
        };
        let pieces: Vec<(f64, f64, f64)> = joints.clone().map(piece).collect();
        let arcs: Vec<f64> = joints.clone().map(|j| self.joint(j)).collect();
        let stiffness: Vec<f64> = joints.map(|j| self.spring(j, root).stiffness).collect();
        let arm = |centre: f64, j: usize| if bends { centre - arcs[j] } else { 0.0 };
        // The slowest motion grows most by the power method, by 1/w^2.
        let (mut turned, mut growth) = (vec![1.0; arcs.len()], 0.0);
        for _ in 0..POWERS {
            let mut torques = vec![0.0; arcs.len()];
            for (i, (mass, centre, inertia)) in pieces.iter().enumerate() {
                let angle: f64 = turned[..=i].iter().sum();
                let moved: f64 = (0..=i).map(|j| turned[j] * arm(*centre, j)).sum();
                for j in 0..=i {
                    torques[j] += mass * moved * arm(*centre, j) + inertia * angle;
                }
            }
            let next: Vec<f64> = torques.iter().zip(&stiffness).map(|(torque, k)| torque / k).collect();
            growth = next.iter().fold(0.0, |most: f64, angle| most.max(angle.abs()));
            turned = next.iter().map(|angle| angle / growth).collect();
        }
        growth.sqrt().recip() / std::f64::consts::TAU
    }

    /// Error of these frequencies by the few segments, the larger: over that of a chain of many, less one. What is without inertia does not
    /// twist by itself.
    pub fn frequency_error(&self) -> f64 {
        let many = Self { segments: MANY, ..*self };
        let pairs = self.frequencies_hz().into_iter().zip(many.frequencies_hz());
        let errors =
            pairs.filter_map(|(few, many)| Some(few? / many? - 1.0)).filter(|error| error.is_finite());
        errors.fold(0.0, larger)
    }

    /// A link without mass fixed to `link`.
    fn bare(link: &LinkSpec) -> LinkSpec {
        LinkSpec {
            parent: link.name.clone(),
            origin_m: [0.0; 3],
            orientation_deg: [0.0; 3],
            axis: [1.0, 0.0, 0.0],
            mass_kg: 0.0,
            com_m: [0.0; 3],
            inertia_kg_m2: [0.0; 3],
            capsule: None,
            driven: None,
            elastic: None,
            free: false,
            spar: None,
            joint: crate::body::JointKind::Revolute,
            ..link.clone()
        }
    }

    /// The links that stand for the spar of `link`: the piece at its root, fixed to it, and one to three for each joint, which raise, bend in
    /// the plane of the wing and twist.
    ///
    /// Equation: robot.spar
    /// `k = E I / h at the middle of each of n segments of length h = L/n; rigid pieces between`
    /// Source: lumped curvature, second order in h; Wittbrodt et al. 2006, chapter 3 (rigid finite elements).
    /// Test: `a_spar_is_a_chain_of_links_whose_panels_follow`.
    fn links(&self, link: &LinkSpec) -> Vec<LinkSpec> {
        let blank = Self::bare(link);
        let name = |i: usize| format!("{}_{i}", link.name);
        let mut links = vec![self.loaded(LinkSpec { name: name(0), ..blank.clone() }, 0)];
        for i in 1..=self.segments {
            let (parent, from) =
                if i == 1 { (link.name.clone(), 0.0) } else { (name(i - 1), self.joint(i - 1)) };
            let [bend, edge] = ["bend", "edge"].map(|of| format!("{}_{of}{i}", link.name));
            let joints = [
                Some((bend, [1.0, 0.0, 0.0], self.bending_n_m2)),
                self.edge_bending_n_m2.map(|stiffness| (edge, [0.0, 0.0, 1.0], stiffness)),
                self.torsion_n_m2.map(|stiffness| (name(i), [0.0, -1.0, 0.0], stiffness)),
            ];
            let first = links.len();
            let mut carrier = (parent, self.joint(i) - from);
            for (joint, axis, stiffness) in joints.into_iter().flatten() {
                let (parent, along) = std::mem::replace(&mut carrier, (joint.clone(), 0.0));
                let elastic = Some(self.spring(i, stiffness));
                links.push(LinkSpec {
                    name: joint,
                    parent,
                    origin_m: [0.0, along, 0.0],
                    axis,
                    elastic,
                    ..blank.clone()
                });
            }
            // The last of them is the piece.
            if let Some(last) = links[first..].last_mut() {
                *last = self.loaded(LinkSpec { name: name(i), ..last.clone() }, i);
            }
        }
        links
    }

    /// `link` with the mass of the piece `i`, which begins at its joint.
    fn loaded(&self, link: LinkSpec, i: usize) -> LinkSpec {
        let Piece { from, to } = self.piece(i);
        let ((mass, centre, squared), share) = (self.weighed(i), self.share(0.5 * (from + to)));
        let (about, along) = (mass * squared, self.inertia_kg_m * share * (to - from));
        LinkSpec {
            mass_kg: mass,
            com_m: [self.ahead_m, centre, 0.0],
            // Of a plate in the plane of the wing.
            inertia_kg_m2: [about, along, about + along],
            ..link
        }
    }
}

/// How a spar stands for a beam in its wing, as the file gives it; of several the worst of each.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SparShape {
    /// Error of its lowest frequencies by its few segments, as a share of them.
    pub frequency_error: f64,
    /// How it lies in the surface that it carries, if it carries one.
    pub in_wing: Option<SparInWing>,
}

/// How a spar lies in the surface that it carries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SparInWing {
    /// Distance of the centres of mass from the chord, beyond its edges, over the mean chord; negative within.
    pub off_chord: f64,
    /// Radius of gyration about the span over the mean chord.
    pub gyration: f64,
    /// Distance of its end from that of its part of the surface, over its length.
    pub end_fraction: f64,
}

/// The one of larger size.
fn larger(a: f64, b: f64) -> f64 {
    if b.abs() > a.abs() { b } else { a }
}

/// Arcs at which the spar of the panel `k` of `surface` begins and at which its part of the surface ends, at the next panel or at the `tip`, m.
fn reach(surface: &SurfaceSpec, k: usize, tip: f64) -> (f64, f64) {
    let panel = &surface.panels[k];
    let end = surface.panels.get(k + 1).map_or(tip, |next| next.from_arc_m.min(tip));
    (panel.from_arc_m - panel.origin_m[1], end)
}

impl SparInWing {
    fn worse(self, other: Self) -> Self {
        Self {
            off_chord: self.off_chord.max(other.off_chord),
            gyration: self.gyration.max(other.gyration),
            end_fraction: self.end_fraction.max(other.end_fraction),
        }
    }

    /// Of a `spar` on the panel `k` of a `surface` with that outline.
    fn of(spar: &LinkSparSpec, (surface, k): (&SurfaceSpec, usize), planform: &Planform) -> Self {
        let (root, end) = reach(surface, k, tip_of(planform));
        let edges = |station: usize| {
            let arc = root + (end.min(root + spar.length_m) - root) * station as f64 / STATIONS as f64;
            planform.edges(planform.coordinates(arc)[0])
        };
        let chords = (0..=STATIONS).map(|station| edges(station).0 - edges(station).1);
        let chord = chords.sum::<f64>() / (STATIONS + 1) as f64;
        let ahead = spar.ahead_m - surface.panels[k].origin_m[0] - surface.planform_shift_m;
        let beyond = |(leading, trailing): (f64, f64)| (ahead - leading).max(trailing - ahead) / chord;
        Self {
            off_chord: (0..=STATIONS).map(|station| beyond(edges(station))).fold(f64::NEG_INFINITY, f64::max),
            gyration: (spar.inertia_kg_m / spar.mass_kg_m).sqrt() / chord,
            end_fraction: (root + spar.length_m - end).abs() / spar.length_m,
        }
    }
}

/// Arc of the tip, m.
fn tip_of(planform: &Planform) -> f64 {
    planform.station_arcs().last().copied().unwrap_or_default()
}

impl RobotSpec {
    /// The panels of surfaces that links with spars carry, each with its surface, its place there and the place of the link.
    fn on_spars(&self) -> impl Iterator<Item = (&SurfaceSpec, usize, usize)> {
        let spar = |name: &str| self.links.iter().position(|link| link.spar.is_some() && link.name == name);
        let of = move |surface| {
            let panels = SurfaceSpec::panels_of(surface);
            panels.filter_map(move |(k, name)| Some((surface, k, spar(name)?)))
        };
        self.surfaces.iter().flat_map(of)
    }

    /// How the spars of the links stand for beams in the surfaces that they carry; none without one.
    pub(in super::super) fn spar_shape(&self) -> Option<SparShape> {
        let spars = self.links.iter().filter_map(|link| link.spar);
        let frequency_error = spars.map(|spar| spar.frequency_error()).reduce(larger)?;
        let carried = self.on_spars().filter_map(|(surface, k, link)| {
            Some(SparInWing::of(&self.links[link].spar?, (surface, k), &surface.outline().ok()?))
        });
        Some(SparShape { frequency_error, in_wing: carried.reduce(SparInWing::worse) })
    }

    /// The links with those of their spars, each after its parent, and the place in the file of the link that each belongs to. What a
    /// link with a spar carries rides on the piece where its joint lies.
    pub(in super::super) fn all_links(&self) -> impl Iterator<Item = (usize, LinkSpec)> {
        self.links.iter().enumerate().flat_map(|(i, link)| {
            let chain = link.spar.map(|spar| spar.links(link)).unwrap_or_default();
            let mut own = link.clone();
            let seat = self.seat(link);
            if let Some(seat) = &seat {
                own.parent.clone_from(&seat.name);
            }
            seat.into_iter().chain([own]).chain(chain).map(move |link| (i, link))
        })
    }

    /// What carries `link` where its joint lies on a piece of its parent's spar: fixed to the piece, it is where the frame of the parent is
    /// while nothing bends, so that `origin_m` is as the file has it.
    fn seat(&self, link: &LinkSpec) -> Option<LinkSpec> {
        let mut sides = std::iter::once("").chain(SIDES);
        let (carrier, name, side, spar) = sides.find_map(|side| {
            let name = link.parent.strip_suffix(side)?;
            let sided = |of: &&LinkSpec| side.is_empty() || of.side == LinkSide::Mirrored;
            let carrier = self.links.iter().filter(sided).find(|of| of.name == name)?;
            Some((carrier, name, side, carrier.spar?))
        })?;
        // On the right side the spar runs along -y.
        let along = if side == SIDES[1] { -1.0 } else { 1.0 };
        let piece = spar.piece_at(along * link.origin_m[1]);
        (piece > 0).then(|| LinkSpec {
            name: format!("{}_seat", link.name),
            side: link.side,
            parent: format!("{name}_{piece}{side}"),
            origin_m: [0.0, -along * spar.joint(piece), 0.0],
            ..LinkSparSpec::bare(carrier)
        })
    }

    /// The capsule of a link, cut where the joints of its spar lie, each part with the piece on which it rides, whose frame it is in.
    pub(in super::super) fn capsule_parts(link: &LinkSpec) -> Vec<(String, CapsuleSpec)> {
        let Some(capsule) = link.capsule else { return Vec::new() };
        let Some(spar) = link.spar else { return vec![(link.name.clone(), capsule)] };
        spar.parts(&capsule).map(|(piece, part)| (format!("{}_{piece}", link.name), part)).collect()
    }

    /// Refuses spars whose joints lie beyond their part of a surface, that do not run along it, or that carry a surface of one side alone.
    pub(in super::super) fn check_spars(&self) -> Result<(), Error> {
        for (surface, k, i) in self.on_spars() {
            let (Some(spar), panel) = (self.links[i].spar, &surface.panels[k]) else { continue };
            let (root, end) = reach(surface, k, tip_of(&surface.outline()?));
            let last = spar.joint(spar.segments);
            if root + last >= end {
                let allowed = format!(
                    "less than {}: a joint of the spar lies at or beyond the end of its part of the surface, {end}",
                    (end - root) * spar.length_m / last
                );
                return Err(Error::invalid(format!("links[{i}].spar.length_m"), spar.length_m, allowed));
            }
            let along = panel.along(surface.span);
            let [x, y, z] = along;
            if !(y > 0.0 && x == 0.0 && z == 0.0) {
                let key = format!("surfaces.{}.panels[{k}].direction", surface.name);
                return Err(Error::invalid(key, format!("{along:?}"), "along y, as the spar runs"));
            }
        }
        for (i, link) in self.links.iter().enumerate() {
            let of = self.links.iter().find(|of| of.name == link.parent && of.side == LinkSide::Single);
            if link.side == LinkSide::Mirrored && of.is_some() && self.seat(link).is_some() {
                let allowed =
                    "a link without a spar, or one of a mirrored pair: the image lies beyond its root";
                return Err(Error::invalid(
                    format!("links[{i}].parent"),
                    format!("{:?}", link.parent),
                    allowed,
                ));
            }
        }
        for surface in &self.surfaces {
            for (k, name) in SurfaceSpec::panels_of(surface) {
                let sided = |link: &&LinkSpec| {
                    let ends = SIDES.iter().any(|side| name.strip_suffix(side) == Some(link.name.as_str()));
                    ends && link.spar.is_some() && link.side == LinkSide::Mirrored
                };
                if let Some(link) = self.links.iter().find(sided) {
                    let key = format!("surfaces.{}.panels[{k}].link", surface.name);
                    let allowed =
                        format!("{:?} in a symmetric surface: its spar bends both halves alike", link.name);
                    return Err(Error::invalid(key, format!("{name:?}"), allowed));
                }
            }
        }
        Ok(())
    }

    /// `surface` with a panel for each piece of the spars that carry it.
    pub(in super::super) fn over_spars(&self, surface: SurfaceSpec) -> SurfaceSpec {
        let spar = |panel: &PanelSpec| self.links.iter().find(|l| l.name == panel.link).and_then(|l| l.spar);
        let pieces = |panel: PanelSpec| {
            let chain = spar(&panel).map_or_else(Vec::new, |spar| {
                let along = |i: usize| PanelSpec {
                    name: Some(format!("{}_{i}", panel.name.as_ref().unwrap_or(&panel.link))),
                    link: format!("{}_{i}", panel.link),
                    from_arc_m: panel.from_arc_m + spar.joint(i) - panel.origin_m[1],
                    origin_m: [panel.origin_m[0], 0.0, panel.origin_m[2]],
                    direction: panel.direction,
                    web_m: 0.0,
                    piece: true,
                };
                (1..=spar.segments).map(along).collect()
            });
            std::iter::once(panel).chain(chain)
        };
        let panels = surface.panels.into_iter().flat_map(pieces).collect();
        SurfaceSpec { panels, ..surface }
    }
}
