//! What a case says of the beams that carry the halves of its wing.

use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use wingbeat_aero::{Aero, Planform};
use wingbeat_flight::tether::{Spar, Steady};
use wingbeat_judge::limits::tether;
use wingbeat_judge::{Judge, Status};
use wingbeat_math::order::ascend;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Error, GRAVITY, Mat3, Vec3, require};
use wingbeat_structure::{Beam, CrossSection, Grid, Lump, SectionStation, Strain};

/// A beam along each half of the wing, straight from its root to the tip. It bends both ways and twists, by any amount; it does not
/// stretch or shear. The halves bend as mirror images of each other, so that roll and sideslip are refused.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
pub struct SparSpec {
    /// Arc at which it is clamped, m; hinges lie there or inboard, where the wing is rigid.
    #[serde(default)]
    pub root_m: f64,
    /// Its reference line ahead of the hinge line, m.
    #[serde(default)]
    pub ahead_m: f64,
    /// Sections from the root to the tip of the wing. Between them all is linear; two at one arc are a step.
    pub stations: Vec<SparStationSpec>,
    /// Masses on it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub masses: Vec<SparMassSpec>,
    /// Elements of equal length; steps of the sections divide them further.
    #[serde(default = "one")]
    pub elements: usize,
    /// Coefficients of twist and of each curvature per element. The summary says by how much one more moves the tip at rest.
    #[serde(default = "four")]
    pub order: usize,
    /// Damping over stiffness, s.
    #[serde(default)]
    pub damping_s: f64,
    /// Acceleration of gravity that it feels, forward, left and up, m/s2.
    #[serde(default = "downwards")]
    pub gravity_m_s2: [f64; 3],
}

/// A section of a spar.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
pub struct SparStationSpec {
    /// Arc from the plane of symmetry, m.
    pub arc_m: f64,
    /// Bending stiffness out of the plane of the wing, N m2.
    pub bending_n_m2: f64,
    /// Bending stiffness in the plane of the wing, N m2.
    pub edge_bending_n_m2: f64,
    /// Torsional stiffness, N m2.
    pub torsion_n_m2: f64,
    /// Couplings of twist and bending, twist and bending in the plane, and of the two bendings, N m2; twist counts nose down,
    /// bending tip down and tip aft.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub couplings_n_m2: [f64; 3],
    /// Mass of the wing per length, kg/m.
    #[serde(default)]
    pub mass_kg_m: f64,
    /// Centre of mass aft of the reference line, m.
    #[serde(default)]
    pub aft_m: f64,
    /// Centre of mass above it, m.
    #[serde(default)]
    pub up_m: f64,
    /// Inertia per length about the span through the centre of mass, kg m; as of a plate, it is that about the normal too.
    #[serde(default)]
    pub inertia_kg_m: f64,
}

/// A mass on a spar.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
pub struct SparMassSpec {
    /// Arc from the plane of symmetry, m.
    pub arc_m: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Its centre aft of the reference line, m.
    #[serde(default)]
    pub aft_m: f64,
    /// Its centre above it, m.
    #[serde(default)]
    pub up_m: f64,
    /// Its centre outboard of the arc, m.
    #[serde(default)]
    pub outboard_m: f64,
    /// Inertia about its centre: about span, chord and normal, kg m2.
    #[serde(default)]
    pub inertia_kg_m2: [f64; 3],
}

ranges!(SparSpec {
    root_m: Range::NOT_NEGATIVE,
    elements: Range::between(1.0, 64.0),
    order: Range::between(1.0, 12.0),
    damping_s: Range::NOT_NEGATIVE,
});
ranges!(SparStationSpec {
    arc_m: Range::NOT_NEGATIVE,
    bending_n_m2: Range::POSITIVE,
    edge_bending_n_m2: Range::POSITIVE,
    torsion_n_m2: Range::POSITIVE,
    mass_kg_m: Range::NOT_NEGATIVE,
    inertia_kg_m: Range::NOT_NEGATIVE,
});
ranges!(SparMassSpec { arc_m: Range::NOT_NEGATIVE, mass_kg: Range::NOT_NEGATIVE });

fn one() -> usize {
    1
}
fn four() -> usize {
    4
}
fn downwards() -> [f64; 3] {
    [0.0, 0.0, -GRAVITY]
}
fn is_zero(values: &[f64; 3]) -> bool {
    *values == [0.0; 3]
}

/// Most coordinates of a spar. *Choice*: a step solves dense equations of their number and that of the air's states.
const MOST: usize = 120;

impl SparSpec {
    /// The beam with nodes at the sections of `aero`, for a wing of the half span `tip` m.
    ///
    /// # Errors
    /// The key, the value and what is allowed.
    pub(super) fn build(&self, aero: &Aero, tip: f64) -> Result<Spar, Error> {
        self.in_range()?;
        require::finite("ahead_m", &[self.ahead_m])?;
        require::finite("gravity_m_s2", &self.gravity_m_s2)?;
        let stations = self.stations(tip)?;
        let lumps = self.masses.iter().enumerate();
        let lumps: Vec<Lump> = lumps
            .map(|(i, mass)| mass.lump(self.root_m, tip).map_err(|e| e.within(&format!("masses[{i}]"))))
            .collect::<Result<_, _>>()?;
        let beam = |order: usize| {
            let arcs = Spar::arcs(aero, self.root_m);
            let arcs = arcs.into_iter().filter(|arc| *arc <= tip - self.root_m).collect();
            Beam::new(
                &stations,
                &lumps,
                &Grid { elements: self.elements, order, strains: Strain::INEXTENSIBLE, arcs },
            )
        };
        let own = beam(self.order)?;
        if own.coordinates() > MOST {
            let allowed = format!(
                "{MOST} coordinates; these elements and steps of the sections make {}",
                own.coordinates()
            );
            return Err(
                Error::invalid("order", self.order, format!("at most {allowed}")).against(["elements"])
            );
        }
        if !own.moves() {
            let allowed = "a spar of which every part has mass and inertia: give mass_kg_m and inertia_kg_m, or fewer coefficients";
            return Err(Error::invalid("order", self.order, allowed).against(["elements"]));
        }
        Ok(Spar {
            beam: own,
            finer: Some(beam(self.order + 1)?),
            root_m: self.root_m,
            ahead_m: self.ahead_m,
            gravity: Vec3(self.gravity_m_s2),
            damping_s: self.damping_s,
        })
    }

    /// Least mass or inertia per length at a station, over the second or the fourth power of its chord, beside the median of all: 1 of
    /// wings whose sections are alike.
    fn least_mass(&self, planform: &Planform) -> f64 {
        let chord = |arc: f64| {
            let (leading, trailing) = planform.edges(arc);
            leading - trailing
        };
        let mut least = f64::INFINITY;
        let per_length = |station: &SparStationSpec| [station.mass_kg_m, station.inertia_kg_m];
        for (k, power) in [(0, 2), (1, 4)] {
            let of = |station: &SparStationSpec| {
                let chord = chord(station.arc_m);
                (chord > 0.0).then(|| per_length(station)[k] / chord.powi(power))
            };
            let mut all: Vec<f64> = self.stations.iter().filter_map(of).collect();
            wingbeat_math::order::ascend(&mut all);
            // Of an even number the larger of both in the middle.
            if let (Some(lowest), Some(middle)) = (all.first(), all.get(all.len() / 2))
                && *middle > 0.0
            {
                least = least.min(lowest / middle);
            }
        }
        if least.is_finite() { least } else { 0.0 }
    }

    /// Mass per length over that of the fluid of `density` in the circle on the chord, the median of the stations.
    fn over_air(&self, planform: &Planform, density: f64) -> f64 {
        let of = |station: &SparStationSpec| {
            let (leading, trailing) = planform.edges(station.arc_m);
            station.mass_kg_m / (0.25 * PI * density * (leading - trailing).powi(2))
        };
        let mut all: Vec<f64> = self.stations.iter().map(of).collect();
        ascend(&mut all);
        all.get(all.len() / 2).copied().unwrap_or(f64::INFINITY)
    }

    /// Largest distance of the line or of a centre of mass from the chord, beyond its edges, across it or beyond the tip, over the mean chord;
    /// least and largest radius of gyration about the span over the mean chord, of stations with mass, the largest of its `masses` too.
    fn placed(&self, planform: &Planform) -> (f64, Option<[f64; 2]>) {
        let (mut off, mut radii) = (0.0_f64, None::<[f64; 2]>);
        let chord = planform.mean_chord();
        let (tip, mut beyond) = (planform.station_arcs().last().copied().unwrap_or_default(), 0.0_f64);
        let mut put = |arc: f64, ahead: f64, up: f64| {
            let (leading, trailing) = planform.edges(arc);
            off = off.max((ahead - leading).max(trailing - ahead).max(up.abs()) / chord);
        };
        for station in &self.stations {
            put(station.arc_m, self.ahead_m, 0.0);
            put(station.arc_m, self.ahead_m - station.aft_m, station.up_m);
            if station.mass_kg_m > 0.0 {
                let radius = (station.inertia_kg_m / station.mass_kg_m).sqrt() / chord;
                let [least, most] = radii.unwrap_or([radius; 2]);
                radii = Some([radius.min(least), radius.max(most)]);
            }
        }
        for mass in &self.masses {
            put(mass.arc_m, self.ahead_m - mass.aft_m, mass.up_m);
            beyond = beyond.max((mass.arc_m + mass.outboard_m - tip) / chord);
            if mass.mass_kg > 0.0 {
                let radius = (mass.inertia_kg_m2[0] / mass.mass_kg).sqrt() / chord;
                let [least, most] = radii.unwrap_or([f64::INFINITY, radius]);
                radii = Some([least, radius.max(most)]);
            }
        }
        (off.max(beyond), radii)
    }

    /// Largest of the `masses` over the mass of the spar without them; none without either.
    fn lump_over_spar(&self) -> Option<f64> {
        let largest = self.masses.iter().map(|mass| mass.mass_kg).reduce(f64::max)?;
        let pairs = self.stations.windows(2);
        let spar: f64 =
            pairs.map(|p| 0.5 * (p[1].arc_m - p[0].arc_m) * (p[0].mass_kg_m + p[1].mass_kg_m)).sum();
        (spar > 0.0).then(|| largest / spar)
    }

    /// Holds the spar of a wing in a fluid of that density, kg/m3, against what spars have, and its shape at rest against what is asked of
    /// one; of a wing that is `held` still the growth of small disturbances too.
    pub(super) fn judge(
        &self,
        (planform, density): (&Planform, f64),
        (steady, held): (Option<&Steady>, bool),
        judge: &mut Judge,
    ) {
        if steady.is_some_and(|steady| !steady.found) {
            judge.find(Status::NotResolved, "no shape of the spar at rest in the wind was found");
        }
        judge.hold_if(&tether::SPAR, steady.and_then(|steady| steady.grid_change));
        let changes = steady.and_then(|steady| steady.frequency_change);
        judge.hold_if(&tether::SPAR_LOWEST, changes.map(|[lowest, _]| lowest));
        judge.hold_if(&tether::SPAR_FREQUENCY, changes.map(|[_, largest]| largest));
        let growth = steady.filter(|steady| held && steady.found);
        let growth = growth.and_then(|steady| beside_frequency(steady, steady.least_damped));
        if growth.is_some_and(|growth| !growth.is_finite()) {
            let text = "no growth of small disturbances of the wing at rest in the wind was found: it may flutter or diverge";
            judge.find(Status::NotResolved, text);
        }
        judge.hold_if(&tether::FLUTTER, growth.filter(|growth| growth.is_finite()));
        let fast = steady.and_then(|steady| beside_frequency(steady, steady.least_damped_fast?));
        judge.hold_if(&tether::FAST, fast);
        judge.hold(&tether::MASSLESS, self.least_mass(planform));
        judge.hold(&tether::LIGHT, self.over_air(planform, density));
        let (off, radii) = self.placed(planform);
        judge.hold(&tether::OFF_CHORD, off);
        if let Some([least, most]) = radii {
            judge.hold(&tether::GYRATION, most);
            judge.hold(&tether::ROD, least);
        }
        judge.hold_if(&tether::LUMP, self.lump_over_spar());
        judge.hold(&tether::GRAVITY, Vec3(self.gravity_m_s2).norm());
        let lowest = steady.and_then(|steady| steady.frequencies_hz.first());
        judge.hold_if(&tether::DAMPED, lowest.map(|hz| PI * hz * self.damping_s));
    }

    fn stations(&self, tip: f64) -> Result<Vec<SectionStation>, Error> {
        let given = format!("{} stations", self.stations.len());
        let (Some(first), Some(last), true) =
            (self.stations.first(), self.stations.last(), self.stations.len() > 1)
        else {
            return Err(Error::invalid(
                "stations",
                given,
                "two or more, from the root of the spar to the tip",
            ));
        };
        if first.arc_m != self.root_m {
            let allowed = format!("{}, the root of the spar", self.root_m);
            return Err(Error::invalid("stations[0].arc_m", first.arc_m, allowed).against(["root_m"]));
        }
        if (last.arc_m - tip).abs() > 1e-9 * tip {
            let key = format!("stations[{}].arc_m", self.stations.len() - 1);
            return Err(Error::invalid(key, last.arc_m, format!("{tip}, the tip of the wing")));
        }
        let mut before = self.root_m;
        let mut stations = Vec::new();
        for (i, station) in self.stations.iter().enumerate() {
            let key = format!("stations[{i}]");
            if !(station.arc_m >= before) {
                let allowed = format!("{before}, that of the one before, or more");
                return Err(Error::invalid(format!("{key}.arc_m"), station.arc_m, allowed));
            }
            before = station.arc_m;
            let section = station.section().map_err(|e| e.within(&key))?;
            let arc_m = if i + 1 == self.stations.len() { tip } else { station.arc_m } - self.root_m;
            stations.push(SectionStation { arc_m, section });
        }
        Ok(stations)
    }
}

/// Growth rate of a small disturbance over its angular frequency, or the lowest of the spar where that is larger; not finite where the
/// eigenvalues were not found.
fn beside_frequency(steady: &Steady, [growth, frequency]: [f64; 2]) -> Option<f64> {
    Some(growth / (TAU * steady.frequencies_hz.first()?).max(frequency))
}

impl SparStationSpec {
    fn section(&self) -> Result<CrossSection, Error> {
        self.in_range()?;
        require::finite("couplings_n_m2", &self.couplings_n_m2)?;
        require::finite("aft_m", &[self.aft_m])?;
        require::finite("up_m", &[self.up_m])?;
        let [torsion, bending, edge] = [self.torsion_n_m2, self.bending_n_m2, self.edge_bending_n_m2];
        // It does not stretch or shear, so that these stiffnesses have no effect.
        let mut section = CrossSection::isotropic(1.0, [torsion, bending, edge]);
        let [twist_bending, twist_edge, both] = self.couplings_n_m2;
        for (i, j, value) in [(0, 1, twist_bending), (0, 2, twist_edge), (1, 2, both)] {
            (section.stiffness[i][j], section.stiffness[j][i]) = (value, value);
        }
        if !section.is_stiff() {
            let allowed = "couplings that leave the stiffness positive definite";
            return Err(Error::invalid("couplings_n_m2", format!("{:?}", self.couplings_n_m2), allowed));
        }
        let inertia = Mat3::diagonal(Vec3::new(self.inertia_kg_m, 0.0, self.inertia_kg_m));
        Ok(section.with_mass(self.mass_kg_m, Vec3::new(0.0, self.aft_m, self.up_m), inertia))
    }
}

impl SparMassSpec {
    fn lump(&self, root: f64, tip: f64) -> Result<Lump, Error> {
        self.in_range()?;
        require::between("arc_m", self.arc_m, root, tip)?;
        for (key, value) in [("aft_m", self.aft_m), ("up_m", self.up_m), ("outboard_m", self.outboard_m)] {
            require::finite(key, &[value])?;
        }
        require::principal_inertias("inertia_kg_m2", self.inertia_kg_m2)?;
        Ok(Lump {
            arc_m: self.arc_m - root,
            mass: self.mass_kg,
            centre: Vec3::new(self.outboard_m, self.aft_m, self.up_m),
            inertia: Mat3::diagonal(Vec3(self.inertia_kg_m2)),
        })
    }
}
