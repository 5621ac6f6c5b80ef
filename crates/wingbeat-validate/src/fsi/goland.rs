//! Goland's wing: a uniform cantilever whose bending and torsion flutter.

use crate::{Case, Error, Row};
use wingbeat::aero::{Aero, LiftLaw, Planform, PlanformStation, SectionSettings, StripModel, StripSettings};
use wingbeat::math::{Mat3, Vec3};
use wingbeat::structure::{Beam, Grid, Section, Station, Strain};
use wingbeat::tether::{Clock, Motion, Reference, Side, Spar, Tether, Wing};

/// The comparisons.
pub const CASES: &[Case] = &[Case { id: "fsi.goland.strip", quick: false, run: strip }];

/// Goland 1945: semi-span and chord, m; elastic axis and centre of mass behind the leading edge, chords.
const SPAN: f64 = 6.096;
const CHORD: f64 = 1.8288;
const AXIS: f64 = 0.33;
const CENTRE: f64 = 0.43;
/// Bending and torsional stiffness, N m2; mass, kg/m, and inertia about the elastic axis, kg m.
const BENDING: f64 = 9.77e6;
const TORSION: f64 = 0.987e6;
const MASS: f64 = 35.71;
const INERTIA: f64 = 8.64;
/// Density with which strip theory and lattices publish their speeds (Murua et al. 2012), kg/m3.
const DENSITY: f64 = 1.02;
/// Strips of the strip model over both halves.
const STRIPS: usize = 20;

fn planform() -> Result<Planform, Error> {
    let station = |arc_m| PlanformStation {
        arc_m,
        leading_edge_m: AXIS * CHORD,
        trailing_edge_m: (AXIS - 1.0) * CHORD,
    };
    Ok(Planform::new(&[station(0.0), station(SPAN)])?)
}

/// The beam, with nodes at `arcs`; y points aft.
fn beam(arcs: Vec<f64>) -> Result<Beam, Error> {
    let offset = (CENTRE - AXIS) * CHORD;
    let own = INERTIA - MASS * offset * offset;
    // In its plane it is taken a hundred times stiffer.
    let section = Section::isotropic(1e10, [TORSION, BENDING, 100.0 * BENDING]).with_mass(
        MASS,
        Vec3::new(0.0, offset, 0.0),
        Mat3::diagonal(Vec3::new(own, 1e-6 * own, own)),
    );
    let stations = [0.0, SPAN].map(|arc_m| Station { arc_m, section });
    Ok(Beam::new(&stations, &[], &Grid { elements: 1, order: 4, strains: Strain::INEXTENSIBLE, arcs })?)
}

/// The wing in a wind of `speed` m/s with the model `aero`.
fn wing(speed: f64, aero: Aero) -> Result<Tether, Error> {
    let planform = planform()?;
    let beam = beam(Spar::arcs(&aero, 0.0))?;
    let reference =
        Reference { density_kg_m3: DENSITY, speed_m_s: speed, area_m2: planform.area(), chord_m: CHORD };
    Ok(Tether {
        aero,
        motion: Motion::at_rest(),
        wind: Vec3::new(-speed, 0.0, 0.0),
        side: Side::Both,
        reference,
        clock: Clock { frequency_hz: 1.0, cycles: 1, steps_per_cycle: 8 },
        spar: Some(Spar {
            beam,
            finer: None,
            root_m: 0.0,
            ahead_m: 0.0,
            gravity: Vec3::ZERO,
            damping_s: 0.0,
        }),
        wing: Wing::new(planform, Vec::new())?,
    })
}

/// Strips of an infinite wing, or with the wash of the finite one.
fn strips(finite: bool, density: f64) -> Result<Aero, Error> {
    let settings = StripSettings {
        strips: STRIPS,
        wake_wash: finite,
        doublet_wash: finite,
        regularisation_m_s: 0.01,
        section: SectionSettings { density_kg_m3: density, law: LiftLaw::Linear, ..Default::default() },
        ..Default::default()
    };
    Ok(Aero::Strip(StripModel::new(&planform()?, settings)?))
}

/// Speed (m/s) and frequency (rad/s) of flutter by the eigenvalues of beam and strips.
fn flutter(finite: bool, density: f64) -> Result<[f64; 2], Error> {
    let aero = strips(finite, density)?;
    let least = |speed: f64| -> Result<[f64; 2], Error> {
        let tether = wing(speed, aero.clone())?;
        let found = tether.spar.as_ref().map(|spar| spar.steady(&tether).least_damped);
        found.ok_or_else(|| Error::NoAnswer("no spar".into()))
    };
    // The secant, kept between speeds of which one is stable.
    let (mut low, mut high) = ((120.0_f64, least(120.0)?[0]), (200.0, least(200.0)?[0]));
    if !(low.1 < 0.0 && high.1 > 0.0) {
        return Err(Error::NoAnswer(format!("no flutter between {} and {} m/s", low.0, high.0)));
    }
    for _ in 0..12 {
        let speed =
            (low.0 + 0.02 * (high.0 - low.0)).max(high.0 - high.1 * (high.0 - low.0) / (high.1 - low.1));
        let growth = least(speed)?[0];
        if growth < 0.0 {
            low = (speed, growth)
        } else {
            high = (speed, growth)
        }
        if growth.abs() < 1e-3 {
            return Ok([speed, least(speed)?[1]]);
        }
    }
    Err(Error::NoAnswer("the speed of flutter".into()))
}

fn strip() -> Result<Vec<Row>, Error> {
    let [speed, frequency] = flutter(false, DENSITY)?;
    let source = "Goland 1945, Goland & Luke 1948: exact strip theory, 137.2 m/s, 70.7 rad/s";
    let finite = flutter(true, DENSITY)?;
    let shown = |id: &str, what: &str, value, unit| {
        Row::shown(id, "Murua, Palacios & Graham 2012: 165 m/s, 69 rad/s by a lattice", what, value, unit)
    };
    Ok(vec![
        Row::judged(
            "fsi.goland.strip",
            source,
            &format!("relative error of the speed of flutter, strips of an infinite wing ({speed:.1} m/s)"),
            (speed / 137.2 - 1.0).abs(),
            0.03,
            "",
        ),
        Row::judged(
            "fsi.goland.strip.frequency",
            source,
            &format!("relative error of its frequency ({frequency:.1} rad/s)"),
            (frequency / 70.7 - 1.0).abs(),
            0.03,
            "",
        ),
        shown(
            "fsi.goland.strip.finite",
            "speed of flutter, strips with the wash of the finite wing",
            finite[0],
            "m/s",
        ),
        shown("fsi.goland.strip.finite_frequency", "its frequency", finite[1], "rad/s"),
    ])
}
