//! The Pre-Pazy wing: measured bending of a very flexible wing.

use crate::{Case, ComparisonRow, Error, ReferenceTable, reference_table};
use wingbeat::aero::{Aero, LiftLaw, Planform, PlanformStation, SectionSettings, StripModel, StripSettings};
use wingbeat::math::{GRAVITY, Mat3, Vec3};
use wingbeat::structure::{
    Beam, CrossSection, Grid, Load, Lump, Place, SectionStation, Setting, StaticsStatus, Strain, frequencies,
    hold, linear,
};
use wingbeat::tether::{Clock, CoefficientScales, Coordinate, Motion, Side, Spar, Tether, Wing};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "fsi.pazy.bending", quick: true, run: bending },
    Case { id: "fsi.pazy.later", quick: true, run: later },
    Case { id: "fsi.pazy.static", quick: false, run: static_shape },
    Case { id: "fsi.pazy.wind", quick: false, run: later_wind },
];

/// Half span to which the measured displacements refer, m.
const SPAN: f64 = 0.55;
/// Chord, m, and the reference line behind the leading edge, chords (Goizueta et al. 2021).
const CHORD: f64 = 0.1;
const LINE: f64 = 0.44;
/// Speed from which the goal of the comparison holds: the reading below it is off the trend of the measurement itself, m/s.
const ASKED: f64 = 20.0;
/// Density of the air in the wind tunnel: not reported, taken at sea level, kg/m3.
const DENSITY: f64 = 1.225;
const SOURCE: &str = "measured at Technion; Goizueta et al., doi 10.5281/zenodo.4299868";

fn stiffness(later: bool) -> Result<ReferenceTable, Error> {
    if later {
        return reference_table!("pazy/stiffness_later.csv");
    }
    reference_table!("pazy/stiffness_with_skin.csv")
}

fn inertia() -> Result<ReferenceTable, Error> {
    reference_table!("pazy/inertia_with_skin.csv")
}

/// What is changed of the equivalent beam to ask for the cause of a miss.
#[derive(Clone, Copy)]
struct BeamChange {
    /// Bending stiffness out of plane over the table's.
    bending: f64,
    /// Stiffness of the clamp against bending, N m/rad; that of the table is rigid.
    clamp: f64,
    /// Coupling of stretch and bending in plane over the table's.
    coupling: f64,
    /// Place of the hung mass outboard of the tip, m.
    beyond: f64,
    /// Whether the stiffness is that of the later Pazy wing.
    later: bool,
}

const AS_GIVEN: BeamChange =
    BeamChange { bending: 1.0, clamp: f64::INFINITY, coupling: 1.0, beyond: 0.0, later: false };
/// Fitted to the bending under a mass, each alone, by least squares.
const SOFTER: BeamChange = BeamChange { bending: 0.908, ..AS_GIVEN };
const CLAMPED: BeamChange = BeamChange { clamp: 310.0, ..AS_GIVEN };
const BEYOND: BeamChange = BeamChange { beyond: 0.039, ..AS_GIVEN };

/// The equivalent beam of Riso & Cesnik: the stiffness is constant in each element, masses lie at the keypoints. The table's axes
/// are y along the span and x along the chord, taken to point aft; z then points down where ours points up.
fn beam(arcs: Vec<f64>, change: BeamChange) -> Result<Beam, Error> {
    let (stiffness, inertia) = (stiffness(change.later)?, inertia()?);
    let column = |table: &ReferenceTable, name: &str| table.column(name);
    let ends = column(&inertia, "span_m")?;
    let names = ["EA_N", "GJ_N_m2", "EI_flap_N_m2", "EI_lag_N_m2", "K12", "K13", "K14", "K23", "K24", "K34"];
    let k: Vec<Vec<f64>> = names.iter().map(|name| column(&stiffness, name)).collect::<Result<_, _>>()?;
    let mut stations = Vec::new();
    for (e, pair) in ends.windows(2).enumerate() {
        let mut numbers = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(|i: usize| k[i][e]);
        numbers[2] *= change.bending;
        numbers[6] *= change.coupling;
        if e == 0 {
            // The clamp gives way within the first element.
            let length = pair[1] - pair[0];
            numbers[2] = length / (length / numbers[2] + change.clamp.recip());
        }
        let section = section(numbers);
        stations.extend([pair[0], pair[1]].map(|arc_m| SectionStation { arc_m, section }));
    }
    let numbers: Vec<Vec<f64>> =
        ["mass_kg", "cg_x_m", "cg_y_m", "cg_z_m", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"]
            .iter()
            .map(|name| column(&inertia, name))
            .collect::<Result<_, _>>()?;
    let lumps: Vec<Lump> = ends
        .iter()
        .enumerate()
        .map(|(i, arc_m)| {
            let [mass, x, y, z, xx, yy, zz, xy, xz, yz] =
                [0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(|k: usize| numbers[k][i]);
            // Ours: x = theirs y, y = theirs x, z = minus theirs; products of inertia as they stand off the diagonal.
            let inertia = Mat3([[yy, xy, -yz], [xy, xx, -xz], [-yz, -xz, zz]]);
            Lump { arc_m: *arc_m, mass, centre: Vec3::new(y, x, -z), inertia }
        })
        .collect();
    let grid = Grid { elements: 1, order: 1, strains: Strain::INEXTENSIBLE, arcs };
    Ok(Beam::new(&stations, &lumps, &grid)?)
}

/// The section of an element: its shear is not given and taken as stiff.
fn section([ea, gj, flap, lag, k12, k13, k14, k23, k24, k34]: [f64; 10]) -> CrossSection {
    // Twist about theirs y is ours about x; bending about theirs x is ours about y; about theirs z minus ours about z.
    let mut s = CrossSection::isotropic(ea, [gj, flap, lag]);
    let mut pair = |i: usize, j: usize, value: f64| (s.stiffness[i][j], s.stiffness[j][i]) = (value, value);
    pair(0, 3, k12);
    pair(1, 3, k13);
    pair(2, 3, -k14);
    pair(0, 1, k23);
    pair(0, 2, -k24);
    pair(1, 2, -k34);
    s
}

/// Height of the tip of `beam` under its weight and a mass, m.
fn height(beam: &Beam, change: BeamChange, mass: f64) -> Result<f64, Error> {
    let force = Vec3::new(0.0, 0.0, -GRAVITY * mass);
    // Hung mid-chord, aft of the reference line, which shifts little as the tip turns.
    let moment = Vec3::new(change.beyond, (0.5 - LINE) * CHORD, 0.0).cross(force);
    let load = Load { moment, ..Load::dead(beam.tip(), force) };
    let setting = Setting { loads: vec![load], gravity: Vec3::new(0.0, 0.0, -GRAVITY), ..Setting::default() };
    let held = hold(beam, &setting, 6);
    match held.status {
        StaticsStatus::Converged => Ok(beam.places(&Place::IDENTITY, &held.q)[beam.tip()].p[2]),
        status => Err(Error::NoAnswer(format!("Pazy wing under {mass} kg: {status:?}"))),
    }
}

/// Largest and rms error of the tip's displacement under a mass, over the half span.
fn bent(change: BeamChange) -> Result<[f64; 2], Error> {
    let table = reference_table!("pazy/bending_with_skin.csv")?;
    let (masses, measured) = (table.column("tip_mass_kg")?, table.column("tip_displacement_m")?);
    let beam = beam(Vec::new(), change)?;
    let down = |mass: f64| height(&beam, change, mass);
    let unloaded = down(0.0)?;
    let (mut worst, mut sum, mut count, mut zero) = (0.0_f64, 0.0, 0.0, 0.0);
    for (mass, place) in masses.iter().zip(&measured) {
        if *mass == 0.0 {
            zero = *place;
            continue;
        }
        let off = (down(*mass)? - unloaded) - (place - zero);
        worst = worst.max(off.abs() / SPAN);
        sum += off * off;
        count += 1.0;
    }
    Ok([worst, f64::sqrt(sum / count) / SPAN])
}

/// Largest difference of the tip's displacement from that of UM/NAST on the same beam, and largest error of UM/NAST, over the half span, at
/// the masses that were measured and computed.
fn peer_bent() -> Result<[f64; 2], Error> {
    let (table, peer) =
        (reference_table!("pazy/bending_with_skin.csv")?, reference_table!("pazy/bending_um_nast.csv")?);
    let (masses, measured) = (table.column("tip_mass_kg")?, table.column("tip_displacement_m")?);
    let (computed, places) = (peer.column("tip_mass_kg")?, peer.column("um_nast_m")?);
    let beam = beam(Vec::new(), AS_GIVEN)?;
    let unloaded = height(&beam, AS_GIVEN, 0.0)?;
    let (mut worst, mut zero) = ([0.0_f64; 2], 0.0);
    for (mass, place) in masses.iter().zip(&measured) {
        if *mass == 0.0 {
            zero = *place;
        }
        let Some(at) = computed.iter().position(|other| (other - mass).abs() < 1e-9) else { continue };
        let (own, other) = (height(&beam, AS_GIVEN, *mass)? - unloaded, places[at] - places[0]);
        for (worst, off) in worst.iter_mut().zip([own - other, other - (place - zero)]) {
            *worst = worst.max(off.abs() / SPAN);
        }
    }
    Ok(worst)
}

/// The later wing: the library against another program on the same equivalent beam, and that program against the measurement.
fn later() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("pazy/bending_later.csv")?;
    let [masses, peer, measured] = ["tip_mass_kg", "um_nast", "measured"].map(|name| table.column(name));
    let (masses, peer, measured) = (masses?, peer?, measured?);
    let change = BeamChange { later: true, ..AS_GIVEN };
    let beam = beam(Vec::new(), change)?;
    let unloaded = height(&beam, change, 0.0)?;
    let mut worst = [0.0_f64; 3];
    for ((mass, peer), measured) in masses.into_iter().zip(peer).zip(measured) {
        let own = (height(&beam, change, mass)? - unloaded) / SPAN;
        for (worst, off) in worst.iter_mut().zip([own - peer, own - measured, peer - measured]) {
            *worst = worst.max(off.abs());
        }
    }
    let [apart, own, other] = worst;
    let source = "Riso & Cesnik, AIAA 2022-2313: UM/NAST on its equivalent beam of the later wing";
    let missed = "Avin et al. 2022, measured, the later wing";
    Ok(vec![
        ComparisonRow::judged(
            "fsi.pazy.later",
            source,
            "max difference of the tip's displacement over half span, 0.2 to 3 kg at the tip",
            apart,
            0.01,
            "",
        ),
        ComparisonRow::shown("fsi.pazy.later.measured", missed, "max error of the same", own, ""),
        ComparisonRow::shown("fsi.pazy.later.um_nast", missed, "max error of the same of UM/NAST", other, ""),
    ])
}

fn bending() -> Result<Vec<ComparisonRow>, Error> {
    let ([worst, rms], [apart, other]) = (bent(AS_GIVEN)?, peer_bent()?);
    let beam = beam(Vec::new(), AS_GIVEN)?;
    let rest = frequencies(&linear(&beam, &Setting::default(), &vec![0.0; beam.coordinates()]));
    let lowest = rest.first().map_or(f64::NAN, |mode| mode.0 / std::f64::consts::TAU);
    let shown = |id: &str, what: &str, value, unit| ComparisonRow::shown(id, SOURCE, what, value, unit);
    Ok(vec![
        shown(
            "fsi.pazy.bending",
            "max error of the tip's displacement over half span, 0.2 to 3.6 kg at the tip (goal: 0.01)",
            worst,
            "",
        ),
        shown("fsi.pazy.bending.rms", "rms of the same", rms, ""),
        ComparisonRow::judged(
            "fsi.pazy.bending.peer",
            "UM/NAST on the same beam; Goizueta et al., doi 10.5281/zenodo.4299868",
            "max difference of the tip from UM/NAST's over half span, 0.2 to 3.4 kg at the tip",
            apart,
            0.01,
            "",
        ),
        shown("fsi.pazy.bending.um_nast", "max error of UM/NAST, 0.2 to 3.4 kg", other, ""),
        shown(
            "fsi.pazy.bending.coupling",
            "change of the max error without the coupling of stretch and bending in plane",
            (bent(BeamChange { coupling: 0.0, ..AS_GIVEN })?[0] - worst).abs(),
            "",
        ),
        shown(
            "fsi.pazy.bending.beyond",
            "max error with the mass 39 mm beyond the tip (fitted)",
            bent(BEYOND)?[0],
            "",
        ),
        shown(
            "fsi.pazy.bending.softer",
            "max error with bending stiffness x 0.908 (fitted)",
            bent(SOFTER)?[0],
            "",
        ),
        shown(
            "fsi.pazy.bending.clamp",
            "max error with a clamp of 310 N m/rad (fitted)",
            bent(CLAMPED)?[0],
            "",
        ),
        shown("fsi.pazy.bending.frequency", "lowest frequency of the beam without air", lowest, "Hz"),
    ])
}

/// Displacement of the tip in the wind at rest, over that of the wing unloaded, m.
fn displaced(speed: f64, change: BeamChange) -> Result<f64, Error> {
    let ends = inertia()?.column("span_m")?;
    let half_span = ends.last().copied().unwrap_or(SPAN);
    let station = |arc_m| PlanformStation {
        arc_m,
        leading_edge_m: LINE * CHORD,
        trailing_edge_m: (LINE - 1.0) * CHORD,
    };
    let planform = Planform::new(&[station(0.0), station(half_span)])?;
    let settings = StripSettings {
        strips: 24,
        regularisation_m_s: 0.01,
        section: SectionSettings { density_kg_m3: DENSITY, law: LiftLaw::Linear, ..Default::default() },
        ..Default::default()
    };
    let aero = Aero::Strip(StripModel::new(&planform, settings)?);
    let beam = beam(Spar::arcs(&aero, 0.0), change)?;
    let tether = Tether {
        aero,
        motion: Motion { nose_up: Coordinate::Constant(5.0_f64.to_radians()), ..Motion::at_rest() },
        wind: Vec3::new(-speed, 0.0, 0.0),
        side: Side::Left,
        reference: CoefficientScales {
            density_kg_m3: DENSITY,
            speed_m_s: speed,
            area_m2: half_span * CHORD,
            chord_m: CHORD,
        },
        clock: Clock { frequency_hz: 1.0, cycles: 1, steps_per_cycle: 8 },
        // Upright on the floor of the tunnel: its weight points to the root.
        ground: None,
        spar: Some(Spar {
            beam,
            finer: None,
            root_m: 0.0,
            ahead_m: 0.0,
            gravity: Vec3::new(0.0, -GRAVITY, 0.0),
            damping_s: 0.0,
        }),
        wing: Wing::new(planform, Vec::new())?,
    };
    let steady = tether.spar.as_ref().map(|spar| spar.steady(&tether));
    match steady.filter(|steady| steady.found) {
        Some(steady) => Ok(steady.tip[0]),
        None => Err(Error::NoAnswer(format!("Pazy wing at {speed} m/s"))),
    }
}

fn static_shape() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("pazy/static_5deg.csv")?;
    let columns = ["airspeed_m_s", "tip_displacement_m", "spread_m"].map(|name| table.column(name));
    let [speeds, measured, spread] = columns;
    let (speeds, measured, spread) = (speeds?, measured?, spread?);
    let (mut rows, mut sum, mut count, mut changed) = (Vec::new(), 0.0, 0.0, [0.0; 2]);
    for ((speed, place), spread) in
        speeds.into_iter().zip(measured).zip(spread).filter(|((s, _), _)| *s > 0.0)
    {
        let found = displaced(speed, AS_GIVEN)?;
        let value = (found / place - 1.0).abs();
        let asked = if speed < ASKED {
            "no goal".to_owned()
        } else {
            sum += value * value;
            count += 1.0;
            for (change, sum) in [SOFTER, CLAMPED].into_iter().zip(&mut changed) {
                *sum += (displaced(speed, change)? / place - 1.0).powi(2);
            }
            format!("goal: {:.3}", 0.05_f64.max(spread / place))
        };
        let metric = format!(
            "relative error of the tip's displacement at {speed} m/s, 5 deg, computed {found:.4} m ({asked})"
        );
        rows.push(ComparisonRow::shown(&format!("fsi.pazy.static.{speed}"), SOURCE, &metric, value, ""));
    }
    let metric = "rms of the relative errors at 20 to 50 m/s";
    rows.push(ComparisonRow::judged("fsi.pazy.static.rms", SOURCE, metric, f64::sqrt(sum / count), 0.05, ""));
    let names = [
        ("softer", "the same with bending stiffness x 0.908, fitted to the bending"),
        ("clamp", "the same with a clamp of 310 N m/rad, fitted to the bending"),
    ];
    for ((id, what), sum) in names.into_iter().zip(changed) {
        let id = format!("fsi.pazy.static.{id}");
        rows.push(ComparisonRow::shown(&id, SOURCE, what, f64::sqrt(sum / count), ""));
    }
    rows.extend(peers_in_wind(&table)?);
    Ok(rows)
}

/// Two other programs on the same beam in the same wind.
fn peers_in_wind(table: &ReferenceTable) -> Result<Vec<ComparisonRow>, Error> {
    let (speeds, measured) = (table.column("airspeed_m_s")?, table.column("tip_displacement_m")?);
    let others = reference_table!("pazy/static_5deg_others.csv")?;
    let computed = others.column("airspeed_m_s")?;
    let mut rows = Vec::new();
    for (id, name) in [("um_nast", "UM/NAST (strips)"), ("sharpy", "SHARPy (vortex lattice)")] {
        let places = others.column(&format!("{id}_m"))?;
        let mut sum = 0.0;
        for (speed, place) in computed.iter().zip(&places) {
            let at = speeds.iter().position(|other| other == speed);
            let at = at.ok_or_else(|| Error::NoAnswer(format!("no measurement at {speed} m/s")))?;
            let value = (place / measured[at] - 1.0).abs();
            sum += value * value;
            if *speed == 40.0 {
                let metric =
                    format!("relative error of {name} on the same beam at 40 m/s, computed {place:.4} m");
                rows.push(ComparisonRow::shown(
                    &format!("fsi.pazy.static.{id}.40"),
                    SOURCE,
                    &metric,
                    value,
                    "",
                ));
            }
        }
        let (id, rms) = (format!("fsi.pazy.static.{id}.rms"), f64::sqrt(sum / computed.len() as f64));
        rows.push(ComparisonRow::shown(
            &id,
            SOURCE,
            &format!("rms of its relative errors at 20 to 50 m/s, {name}"),
            rms,
            "",
        ));
    }
    Ok(rows)
}

/// The later wing in the wind.
fn later_wind() -> Result<Vec<ComparisonRow>, Error> {
    let table = reference_table!("pazy/static_5deg_later.csv")?;
    let (speeds, measured) = (table.column("airspeed_m_s")?, table.column("displacement")?);
    let (mut rows, mut sum) = (Vec::new(), 0.0);
    let source = "Avin et al. 2022, measured, the later wing";
    for (speed, measured) in speeds.iter().zip(&measured) {
        let found = displaced(*speed, BeamChange { later: true, ..AS_GIVEN })? / SPAN;
        let value = (found / measured - 1.0).abs();
        sum += value * value / speeds.len() as f64;
        let metric = format!(
            "relative error of the tip's displacement at {speed} m/s, 5 deg, the later wing, computed {found:.4} of the half span"
        );
        rows.push(ComparisonRow::shown(&format!("fsi.pazy.wind.{speed}"), source, &metric, value, ""));
    }
    rows.push(ComparisonRow::shown("fsi.pazy.wind.rms", source, "rms of these", sum.sqrt(), ""));
    Ok(rows)
}
