//! A beam cut into elements: its nodes, their inertia, and the stiffness of its coordinates.

use crate::basis::{gauss, legendre};
use crate::group::{Pair, Place};
use crate::section::{CrossSection, SectionStation, Strain};
use wingbeat_math::{Error, Mat3, Scalar, Vec3, require};

/// Most coordinates of a beam. *Choice*: their matrices are dense.
pub const MAX_COORDINATES: usize = 600;

/// How a beam is discretised.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Elements of equal length; an edge lies at each step of the sections besides.
    pub elements: usize,
    /// Coefficients of each strain in each element: the polynomial's degree plus one.
    pub order: usize,
    /// Strains that are unknown; the others bear no force.
    pub strains: &'static [Strain],
    /// Arc coordinates at which nodes lie besides those of the rule, m.
    pub arcs: Vec<f64>,
}

/// A mass at one place of the beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lump {
    /// Distance from the root along the beam, m.
    pub arc_m: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass from the reference line, in the section's axes, m.
    pub centre: Vec3,
    /// Inertia about the centre of mass, kg m2.
    pub inertia: Mat3,
}

/// A node with the inertia of its share of the beam.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub arc: f64,
    pub mass: f64,
    /// Mass times centre of mass from the node, kg m.
    pub moment: Vec3,
    /// Inertia about the node, kg m2.
    pub inertia: Mat3,
}

/// The way from one node to the next.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub element: usize,
    pub length: f64,
    /// Integrals of the polynomials along it, m, and their first moments about its middle over its length, m.
    pub rows: [Vec<f64>; 2],
}

/// A beam along its reference line, straight along x of its root when nothing strains it.
#[derive(Clone, Debug)]
pub struct Beam {
    pub(crate) nodes: Vec<Node>,
    pub(crate) steps: Vec<Step>,
    /// Of the coordinates of each element, by rows.
    pub(crate) stiffness: Vec<Vec<f64>>,
    pub(crate) strains: &'static [Strain],
    pub(crate) order: usize,
    length: f64,
}

/// Two arcs closer than this share of the length are one.
const SAME: f64 = 1e-9;

/// Gauss points of an element: exact for the inertia of a bent element to beyond the strains' own accuracy. *Choice*.
fn points(order: usize) -> usize {
    order + 3
}

/// The section at an arc of the element between two edges, of which none lies within a piece's ends: a step of the sections is
/// seen from the element's side.
fn section_at(stations: &[SectionStation], arc: f64, [from, to]: [f64; 2]) -> CrossSection {
    let holds = |pair: &&[SectionStation]| {
        let [low, high] = [pair[0].arc_m, pair[1].arc_m];
        low <= arc && arc <= high && low < to && high > from && low < high
    };
    let pair = stations.windows(2).find(holds).unwrap_or(&stations[..2]);
    let share = (arc - pair[0].arc_m) / (pair[1].arc_m - pair[0].arc_m);
    pair[0].section.mixed(&pair[1].section, share)
}

impl Beam {
    /// The beam of these sections and lumps.
    ///
    /// # Errors
    /// Stations that do not run from 0 outboard, sections and masses that no beam has, places off the beam, a grid of too many or
    /// no coordinates.
    pub fn new(stations: &[SectionStation], lumps: &[Lump], grid: &Grid) -> Result<Self, Error> {
        let length = check(stations, lumps, grid)?;
        let edges = edges(stations, grid, length);
        let count = (edges.len() - 1) * grid.strains.len() * grid.order;
        if count > MAX_COORDINATES {
            let allowed = format!("at most {MAX_COORDINATES} coordinates; these make {count}");
            return Err(Error::invalid("elements", grid.elements, allowed));
        }
        let root = Node { arc: 0.0, mass: 0.0, moment: Vec3::ZERO, inertia: Mat3([[0.0; 3]; 3]) };
        let mut beam = Self {
            nodes: vec![root],
            steps: Vec::new(),
            stiffness: Vec::new(),
            strains: grid.strains,
            order: grid.order,
            length,
        };
        for (element, ends) in edges.windows(2).enumerate() {
            beam.add_element(stations, element, [ends[0], ends[1]], lumps, &grid.arcs);
        }
        for lump in lumps {
            let node = beam.nearest(lump.arc_m);
            beam.nodes[node].add(lump.mass, lump.centre, lump.inertia);
        }
        Ok(beam)
    }

    fn add_element(
        &mut self,
        stations: &[SectionStation],
        element: usize,
        ends: [f64; 2],
        lumps: &[Lump],
        arcs: &[f64],
    ) {
        let [from, to] = ends;
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let size = self.strains.len() * self.order;
        let mut stiffness = vec![0.0; size * size];
        let rule = gauss(points(self.order));
        let mut places: Vec<(f64, Option<CrossSection>, f64)> = Vec::new();
        for (x, weight) in rule {
            let (arc, weight) = (middle + half * x, weight * half);
            let section = section_at(stations, arc, ends);
            let condensed = section.condensed(self.strains);
            let p = legendre(x, self.order);
            for (i, row) in stiffness.chunks_exact_mut(size).enumerate() {
                for (j, sum) in row.iter_mut().enumerate() {
                    let [a, b] = [i, j].map(|at| (at / self.order, at % self.order));
                    *sum += weight * condensed[(a.0, b.0)] * p[a.1] * p[b.1];
                }
            }
            places.push((arc, Some(section), weight));
        }
        self.stiffness.push(stiffness);
        let apart = |places: &[(f64, Option<CrossSection>, f64)], arc: f64| {
            places.iter().all(|p| (p.0 - arc).abs() > SAME * self.length)
        };
        let own = lumps.iter().map(|lump| lump.arc_m).chain(arcs.iter().copied());
        for arc in own.filter(|arc| *arc > from && *arc < to).chain([to]) {
            if apart(&places, arc) {
                places.push((arc, None, 0.0));
            }
        }
        wingbeat_math::order::ascend_by(&mut places, |item| item.0);
        let mut at = from;
        for (arc, section, weight) in places {
            let (centre, reach) = (0.5 * (at + arc), 0.5 * (arc - at));
            let mut rows = [vec![0.0; self.order], vec![0.0; self.order]];
            for (x, weight) in gauss(points(self.order)) {
                let values = legendre((centre + reach * x - middle) / half, self.order);
                for (j, p) in values.iter().enumerate() {
                    rows[0][j] += weight * reach * p;
                    rows[1][j] += 0.5 * weight * reach * x * p;
                }
            }
            self.steps.push(Step { element, length: arc - at, rows });
            let mut node = Node { arc, mass: 0.0, moment: Vec3::ZERO, inertia: Mat3([[0.0; 3]; 3]) };
            if let Some(section) = section {
                node.add(section.mass * weight, section.centre, section.inertia * weight);
            }
            self.nodes.push(node);
            at = arc;
        }
    }

    /// Number of strain coordinates.
    pub fn coordinates(&self) -> usize {
        self.stiffness.len() * self.strains.len() * self.order
    }
    /// Length, m.
    pub fn length(&self) -> f64 {
        self.length
    }
    /// Arc coordinates of the nodes, m.
    pub fn arcs(&self) -> Vec<f64> {
        self.nodes.iter().map(|node| node.arc).collect()
    }
    /// Number of the last node.
    pub fn tip(&self) -> usize {
        self.nodes.len() - 1
    }
    /// Number of the node nearest to the arc coordinate `arc`, m.
    pub fn nearest(&self, arc: f64) -> usize {
        let distance = |i: &usize| (self.nodes[*i].arc - arc).abs();
        (0..self.nodes.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    }
    /// Whether every coordinate moves mass, so that the beam can be stepped in time.
    pub fn moves(&self) -> bool {
        let zero = vec![0.0; self.coordinates()];
        let [_, _, mass] = self.tangents(&crate::Setting::default(), [&zero, &zero, &zero], &[]);
        let scale = mass.diagonal().map(|x| x.max(f64::MIN_POSITIVE).sqrt().recip());
        let scaled =
            nalgebra::DMatrix::from_fn(zero.len(), zero.len(), |i, j| scale[i] * mass[(i, j)] * scale[j]);
        // The least pivot of a mass of unit diagonal.
        scaled.cholesky().is_some_and(|factors| factors.l_dirty().diagonal().iter().all(|x| *x > 1e-7))
    }
    /// Mass, kg.
    pub fn mass(&self) -> f64 {
        self.nodes.iter().map(|node| node.mass).sum()
    }

    /// Integral of the strains along a step, m, with that of the straight line, and their first moment about its middle over its
    /// length, m.
    pub(crate) fn moments_of<S: Scalar>(&self, step: &Step, q: &[S]) -> [Pair<S>; 2] {
        let own = &q[step.element * self.strains.len() * self.order..];
        let mut moments = step.rows.each_ref().map(|row| {
            let mut moment = Pair::ZERO;
            for (k, kind) in self.strains.iter().enumerate() {
                let mut sum = S::ZERO;
                for (j, p) in row.iter().enumerate() {
                    sum += own[k * self.order + j] * *p;
                }
                *moment.component_mut(*kind as usize) += sum;
            }
            moment
        });
        moments[0].push[0] += S::from(step.length);
        moments
    }

    /// The rigid motion along a step: the fourth-order Magnus expansion, which is exact to first order in the strains.
    ///
    /// Equation: structure.magnus
    /// `X = B0 + [B0, B1], B0 = int e ds, B1 = int (s - s_m) e ds / h: g' = g e gives g exp(X)`
    /// Source: Magnus 1954; Iserles & Norsett 1999, Phil. Trans. R. Soc. A 357; Blanes et al. 2000, BIT 40.
    /// Test: `the_shape_converges_with_the_fourth_power`.
    pub(crate) fn motion_along<S: Scalar>([mean, slope]: &[Pair<S>; 2]) -> Pair<S> {
        mean.plus(mean.bracket(*slope), 1.0)
    }

    /// Places of all nodes where the root is at `root` and the strain coordinates are `q`, of twist and bending in rad/m, of
    /// extension and shear dimensionless; positions in m.
    pub fn places<S: Scalar>(&self, root: &Place<S>, q: &[S]) -> Vec<Place<S>> {
        let mut places = Vec::with_capacity(self.nodes.len());
        let mut place = *root;
        places.push(place);
        for step in &self.steps {
            place = place.moved(&Self::motion_along(&self.moments_of(step, q)));
            places.push(place);
        }
        places
    }

    /// Mean strains of each step at its middle, in the order of [`Strain::ALL`] (twist and bending in rad/m, extension and
    /// shear dimensionless), behind its arc, m. Those of bending and twist are what gauges would see.
    pub fn strains(&self, q: &[f64]) -> Vec<(f64, [f64; 6])> {
        let along = self.steps.iter().zip(self.nodes.windows(2));
        along
            .map(|(step, ends)| {
                let [sum, _] = self.moments_of(step, q);
                let mean = |k: usize| sum.component(k) / step.length - f64::from(u8::from(k == 3));
                (0.5 * (ends[0].arc + ends[1].arc), std::array::from_fn(mean))
            })
            .collect()
    }
}

impl Node {
    fn add(&mut self, mass: f64, centre: Vec3, about_centre: Mat3) {
        self.mass += mass;
        self.moment += centre * mass;
        // Steiner: I + m (c.c 1 - c c').
        let square = Mat3::diagonal(Vec3::new(1.0, 1.0, 1.0)) * (centre.norm_squared() * mass);
        self.inertia = self.inertia + about_centre + (square - Mat3::outer(centre, centre) * mass);
    }
}

fn check(stations: &[SectionStation], lumps: &[Lump], grid: &Grid) -> Result<f64, Error> {
    let arcs: Vec<f64> = stations.iter().map(|s| s.arc_m).collect();
    let rising = arcs.windows(2).all(|pair| pair[0] <= pair[1]);
    let length = arcs.last().copied().unwrap_or(0.0);
    if arcs.len() < 2 || arcs[0] != 0.0 || !rising || !(length > 0.0 && length.is_finite()) {
        return Err(Error::invalid(
            "arc_m",
            format!("{arcs:?}"),
            "two or more numbers from 0 that do not fall",
        ));
    }
    for (i, station) in stations.iter().enumerate() {
        station.section.check().map_err(|error| error.within(&format!("stations[{i}]")))?;
    }
    for (i, lump) in lumps.iter().enumerate() {
        let key = |key: &str| format!("lumps[{i}].{key}");
        require::between(&key("arc_m"), lump.arc_m, 0.0, length)?;
        require::not_negative(&key("mass"), lump.mass)?;
        let numbers: Vec<f64> = lump.inertia.0.iter().flatten().chain(&lump.centre.0).copied().collect();
        require::finite(&key("inertia"), &numbers)?;
    }
    for (key, value) in [("elements", grid.elements), ("order", grid.order), ("strains", grid.strains.len())]
    {
        require::between(key, value, 1, MAX_COORDINATES)?;
    }
    grid.arcs.iter().try_for_each(|arc| require::between("arcs", *arc, 0.0, length))?;
    Ok(length)
}

/// Edges of the elements: evenly, and where sections step.
fn edges(stations: &[SectionStation], grid: &Grid, length: f64) -> Vec<f64> {
    let even = (0..=grid.elements).map(|i| length * i as f64 / grid.elements as f64);
    let steps = stations.windows(2).filter(|pair| pair[0].arc_m == pair[1].arc_m).map(|pair| pair[0].arc_m);
    let mut edges: Vec<f64> = even.chain(steps).collect();
    wingbeat_math::order::ascend(&mut edges);
    edges.dedup_by(|a, b| (*a - *b).abs() <= SAME * length);
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beam(elements: usize, order: usize) -> Beam {
        let section = CrossSection::isotropic(1e4, [1.0, 2.0, 3.0]).with_mass(
            0.7,
            Vec3::new(0.0, 0.01, -0.02),
            Mat3::diagonal(Vec3::new(3e-4, 1e-4, 2e-4)),
        );
        let stations = [0.0, 2.0].map(|arc_m| SectionStation { arc_m, section });
        Beam::new(&stations, &[], &Grid { elements, order, strains: Strain::ALL, arcs: vec![0.3] }).unwrap()
    }

    #[test]
    fn the_shape_converges_with_the_fourth_power() {
        let tip = |elements: usize| {
            let beam = beam(elements, 3);
            // One and the same polynomial of strain on every grid: curvature 1 + s about y, twist 0.5 + s^2.
            let mut q = vec![0.0; beam.coordinates()];
            for e in 0..elements {
                let half = 1.0 / elements as f64;
                let middle = (2 * e + 1) as f64 * half;
                let own = &mut q[e * 18..];
                own[3..5].copy_from_slice(&[1.0 + middle, half]);
                own[..3].copy_from_slice(&[
                    0.5 + middle * middle + half * half / 3.0,
                    2.0 * middle * half,
                    half * half * 2.0 / 3.0,
                ]);
            }
            beam.places(&Place::IDENTITY, &q)[beam.tip()].p
        };
        let [a, b, c, exact] = [1, 2, 4, 32].map(tip);
        let order = |a: Vec3, b: Vec3| ((a - exact).norm() / (b - exact).norm()).log2();
        assert!(order(a, b) > 3.5 && order(b, c) > 3.7, "{} {}", order(a, b), order(b, c));
    }

    #[test]
    fn mass_is_that_of_the_sections_and_refusals_name_the_key() {
        let beam = beam(3, 2);
        assert!((beam.mass() - 1.4).abs() < 1e-14);
        assert!((beam.arcs()[beam.nearest(0.3)] - 0.3).abs() < 1e-12);
        let section = CrossSection::isotropic(1.0, [1.0, 1.0, -1.0]);
        let stations = [0.0, 1.0].map(|arc_m| SectionStation { arc_m, section });
        let grid = Grid { elements: 1, order: 1, strains: Strain::ALL, arcs: vec![] };
        let message = Beam::new(&stations, &[], &grid).unwrap_err().to_string();
        assert!(message.starts_with("stations[0].stiffness"), "{message}");
    }
}
