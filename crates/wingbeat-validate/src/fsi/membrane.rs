//! Membranes: sails in plane flow, and a latex wing in a wind tunnel.

mod latex;
mod moving;
mod sail;

use super::energy;
use crate::aero_full::last_cycle;
use crate::{Case, ComparisonRow, Error};
use std::f64::consts::PI;
use wingbeat::aero::{
    Aero, FlapSpec, LiftLaw, Loads, MembraneSpec, Planform, PlanformStation, ProfileDrag, SectionSettings,
    StripModel, StripSettings,
};
use wingbeat::math::Vec3;
use wingbeat::tether::{Clock, CoefficientScales, Coordinate, Motion, Side, Tether, Wing};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "fsi.membrane.pressure", quick: true, run: pressure },
    Case { id: "fsi.membrane.sail", quick: true, run: sails },
    Case { id: "fsi.membrane.moving", quick: false, run: moving::rows },
    Case { id: "fsi.membrane.latex", quick: false, run: latex::rows },
    Case { id: "fsi.membrane.energy", quick: true, run: energy::membrane_rows },
    Case { id: "fsi.membrane.work", quick: false, run: energy::work_rows },
    Case { id: "fsi.membrane.momentum", quick: false, run: energy::momentum_rows },
    Case { id: "fsi.membrane.derivatives", quick: true, run: energy::derivative_rows },
];

/// A rectangle of unit chord in a wind of 1 m/s of density 1 kg/m3: its membrane or flap, law and motion.
pub(super) struct SailSheet {
    pub membrane: Option<MembraneSpec>,
    pub flap: Option<FlapSpec>,
    pub law: LiftLaw,
    pub motion: Motion,
    pub clock: Clock,
}

/// Aspect ratio of a wing without ends, whose strips know nothing of each other.
const ASPECT: f64 = 1e5;

impl SailSheet {
    /// Its loads over the last cycle, N and N m, and the area of its strips, m2, which end a little short of the tips.
    pub fn loads(self) -> Result<(Vec<Loads<f64>>, f64), Error> {
        let tether = self.tether()?;
        let area = tether.aero.widths().iter().sum();
        Ok((last_cycle(&tether)?, area))
    }

    fn tether(self) -> Result<Tether, Error> {
        let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.5, trailing_edge_m: -0.5 };
        let planform = Planform::new(&[station(0.0), station(0.5 * ASPECT)])?;
        let cd90 = if self.law == LiftLaw::Linear { 0.0 } else { BROADSIDE };
        let settings = StripSettings {
            strips: 2,
            regularisation_m_s: 1e-3,
            wake_wash: false,
            doublet_wash: false,
            section: SectionSettings {
                law: self.law,
                drag: ProfileDrag { cd0: 0.0, cd90 },
                density_kg_m3: 1.0,
                ..Default::default()
            },
            membrane: self.membrane,
            flap: self.flap,
            ..Default::default()
        };
        Ok(Tether {
            spar: None,
            ground: None,
            aero: Aero::Strip(StripModel::new(&planform, settings)?),
            motion: self.motion,
            wind: Vec3::new(-1.0, 0.0, 0.0),
            side: Side::Both,
            reference: CoefficientScales {
                density_kg_m3: 1.0,
                speed_m_s: 1.0,
                area_m2: ASPECT,
                chord_m: 1.0,
            },
            clock: self.clock,
            wing: Wing::new(planform, Vec::new())?,
        })
    }
}

/// A membrane of that stiffness E t (N/m), prestrain, and time of damping (s), of no mass.
fn membrane(stiffness: f64, prestrain: f64, damping_s: f64) -> MembraneSpec {
    MembraneSpec {
        thickness_m: 1e-3,
        modulus_pa: 1e3 * stiffness,
        density_kg_m3: 0.0,
        prestrain,
        prestrain_span: None,
        poisson_ratio: 0.4,
        damping_s,
        ribs_m: Vec::new(),
    }
}

/// Drag coefficient of the sheets broadside on, under laws that separate.
const BROADSIDE: f64 = 2.0;

/// Held at an incidence (rad) long enough for the lags to have died.
fn held(membrane: MembraneSpec, law: LiftLaw, alpha: f64) -> SailSheet {
    let motion = Motion { nose_up: Coordinate::Constant(alpha), ..Motion::at_rest() };
    SailSheet {
        membrane: Some(membrane),
        flap: None,
        law,
        motion,
        clock: Clock { frequency_hz: 1.0 / 300.0, cycles: 1, steps_per_cycle: 3000 },
    }
}

/// At rest at an incidence (rad).
fn at_rest(membrane: MembraneSpec, law: LiftLaw, alpha: f64) -> Result<(Loads<f64>, f64), Error> {
    let (mut cycle, area) = held(membrane, law, alpha).loads()?;
    cycle.pop().map(|last| (last, area)).ok_or_else(|| Error::NoAnswer("a run without steps".into()))
}

/// Rise over chord and tension over chord and pressure of a membrane under an even pressure p: a circular arc of radius R, T = p R =
/// E t (e_0 + strain of the arc). `stiffness` is E t/(p c).
fn arc(stiffness: f64, prestrain: f64) -> [f64; 2] {
    // By the half angle f: c/(2 R) = sin f, strain f/sin f - 1; the tension falls with f where the pressure's, the stretch's grows.
    let lacking = |f: f64| 0.5 / f.sin() - stiffness * (prestrain + f / f.sin() - 1.0);
    let (mut low, mut high) = (1e-6_f64, 1.5_f64);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if lacking(middle) > 0.0 { low = middle } else { high = middle }
    }
    [(1.0 - low.cos()) * 0.5 / low.sin(), 0.5 / low.sin()]
}

/// Broadside on, where a plate in separated flow bears an even pressure: taut, without prestrain, slack.
fn pressure() -> Result<Vec<ComparisonRow>, Error> {
    let source = "circular arc of an elastic membrane under even pressure, by hand";
    let mut worst = [0.0_f64; 2];
    // Prescribed by the plate's coefficient in a wind of 1 m/s and 1 kg/m3.
    let pressure = 0.5 * BROADSIDE;
    for (stiffness, prestrain) in [(20.0, 0.1), (200.0, 0.0), (100.0, 0.02), (400.0, -0.005), (600.0, -0.008)]
    {
        let tether = held(membrane(stiffness, prestrain, 0.3), LiftLaw::Stall, 0.5 * PI).tether()?;
        let cycle = last_cycle(&tether)?;
        let (Some(loads), Some(skin)) = (cycle.last(), tether.aero.membrane()) else {
            return Err(Error::NoAnswer("a run without steps or a membrane".into()));
        };
        let exact = arc(stiffness / pressure, prestrain);
        let camber = loads.camber[0];
        let stretch = skin.membrane_stretch(camber, loads.camber_forward[0]).unwrap_or_default();
        let tension = stiffness * stretch / pressure;
        for (k, value) in [camber, tension].into_iter().enumerate() {
            worst[k] = worst[k].max((value / exact[k] - 1.0).abs());
        }
    }
    let row = |id: &str, what: &str, value: f64| {
        let metric = format!("{what}, five membranes taut to slack, rise of 5 to 7 % of the chord");
        ComparisonRow::judged(&format!("fsi.membrane.pressure.{id}"), source, &metric, value, 0.02, "")
    };
    Ok(vec![
        row("camber", "max relative error of the rise", worst[0]),
        row("tension", "max relative error of the tension", worst[1]),
    ])
}

/// Incidence of the sails, rad: small, so that they do not stretch.
const SAIL_INCIDENCE: f64 = 1e-3;
/// Tensions over q c from near divergence on.
const TENSIONS: [f64; 6] = [2.5, 3.0, 4.0, 6.0, 10.0, 30.0];
/// The least of them that is judged.
const LEAST_TENSION: f64 = 3.0;

/// Sails between two points in plane flow.
fn sails() -> Result<Vec<ComparisonRow>, Error> {
    let source = "sail equation by Glauert's series, twelve shapes, own";
    let (mut lift, mut rise, mut panels) = ([0.0_f64; 2], 0.0_f64, 0.0_f64);
    for ratio in TENSIONS {
        let exact = sail::solve(ratio, 12);
        // T = C_T q c with q = 1/2; 1 m/s, 1 kg/m3, 1 m.
        let stiffness = 50.0;
        let skin = membrane(stiffness, 0.5 * ratio / stiffness, 0.1);
        let (loads, area) = at_rest(skin, LiftLaw::Linear, SAIL_INCIDENCE)?;
        let force = loads.wrench.force;
        let slope = force[2] / (0.5 * area * SAIL_INCIDENCE);
        let of = usize::from(ratio < LEAST_TENSION);
        lift[of] = lift[of].max((slope / exact.slope - 1.0).abs());
        let found = loads.camber[0] / SAIL_INCIDENCE;
        rise = rise.max((found / exact.middle - 1.0).abs());
        panels = panels.max((moving::at_rest(ratio, 160)? / exact.slope - 1.0).abs());
    }
    let found = sail::divergence(12);
    let two = sail::divergence(2);
    let id = |name: &str| format!("fsi.membrane.sail.{name}");
    let tensions = "T/(q c) 2.5 to 30";
    Ok(vec![
        ComparisonRow::judged(
            &id("divergence"),
            "Nielsen 1963: T/(q c) = 1.727",
            "relative error of the tension at which a sail bulges by itself, twelve shapes",
            (found / 1.727 - 1.0).abs(),
            2e-3,
            "",
        ),
        ComparisonRow::shown(
            &id("divergence_two_shapes"),
            source,
            "the same of the two shapes of a strip",
            (two / found - 1.0).abs(),
            "",
        ),
        ComparisonRow::judged(
            &id("panels"),
            source,
            &format!(
                "max relative error of the lift slope of 160 vortices on a stretched string, {tensions}"
            ),
            panels,
            0.02,
            "",
        ),
        ComparisonRow::judged(
            &id("slope"),
            source,
            "max relative error of the lift slope, preset full, T/(q c) 3 to 30",
            lift[0],
            0.02,
            "",
        ),
        ComparisonRow::shown(&id("slope_near_divergence"), source, "the same at T/(q c) 2.5", lift[1], ""),
        ComparisonRow::shown(
            &id("rise"),
            source,
            &format!("max relative error of the rise at mid chord, preset full, {tensions}"),
            rise,
            "",
        ),
        ComparisonRow::shown(
            &id("one_shape"),
            source,
            &format!("max relative error of the lift slope with the parabola alone, {tensions}"),
            TENSIONS
                .iter()
                .map(|&r| (sail::solve(r, 1).slope / sail::solve(r, 12).slope - 1.0).abs())
                .fold(0.0, f64::max),
            "",
        ),
    ])
}
