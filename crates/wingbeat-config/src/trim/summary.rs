//! `summary.json` of a trimmed flight.

use super::alone::AloneSummary;
use super::search::SearchSummary;
use crate::CostSummary;
use crate::hinged::FlapSummary;
use crate::link_spar::LinkSparSummary;
use crate::pinned::PinSummary;
use crate::skin::MembraneSummary;
use crate::summary::{SAME, apart};
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use wingbeat_aero::Aero;
use wingbeat_flight::orbit::{Cycle, FoundOrbit, Measures, Mode, Modes};
use wingbeat_judge::{Judged, Status, Warning};
use wingbeat_math::GRAVITY;
use wingbeat_math::order::filled;
use wingbeat_ocp::plant::Plant;
use wingbeat_robot::Robot;

/// A Floquet multiplier and its mode.
#[derive(Clone, Debug, Serialize)]
pub struct Multiplier {
    /// Real part, dimensionless.
    pub re: f64,
    /// Imaginary part, dimensionless.
    pub im: f64,
    /// Magnitude: the ratio by which a small disturbance grows over a cycle.
    pub size: f64,
    /// Rate of growth, 1/s.
    pub growth_per_s: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// `longitudinal`, `lateral`, or of a turn `coupled`.
    pub sector: &'static str,
    /// Coordinate with the largest share of the mode; `heading` for the neutral one.
    pub label: String,
}

impl From<&Mode> for Multiplier {
    fn from(mode: &Mode) -> Self {
        Self {
            re: mode.multiplier[0],
            im: mode.multiplier[1],
            size: mode.size(),
            growth_per_s: mode.growth,
            frequency_hz: mode.frequency,
            sector: mode.sector.name(),
            label: mode.label.clone(),
        }
    }
}

/// `summary.json` of `wingbeat trim`. What an orbit alone can tell is missing where none was found.
#[derive(Clone, Debug, Default, Serialize)]
pub struct TrimSummary {
    /// The verdict: `ok`; `outside`; `not_found` without an orbit; `off_target` where no gait of a search keeps to its limits.
    pub status: Status,
    /// Why the status is not `ok`.
    pub reason: Option<String>,
    /// What the status rests on: each value with its limit.
    pub judged: Vec<Judged>,
    /// What a reader must know.
    pub warnings: Vec<Warning>,
    /// Frequency of the gait, Hz.
    pub frequency_hz: Option<f64>,
    /// Frequency of the strokes of a gait with a glide, Hz: that of the cycle times `strokes + glide`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stroke_frequency_hz: Option<f64>,
    /// Mean speed, m/s.
    pub speed_m_s: f64,
    /// Mean climb, m/s.
    pub climb_m_s: f64,
    /// Bank that the rate of turn asks for, deg.
    pub bank_deg: f64,
    /// Rate of the heading, rad/s, positive to the left.
    pub yaw_rate_rad_s: f64,
    /// Mean upward force of the air over the weight.
    pub lift_over_weight: Option<f64>,
    /// Mean force of the air across the plane of symmetry over the weight, positive to the left; a coordinated turn has none.
    pub side_force_over_weight: Option<f64>,
    /// The positive power of `cost`, W: the name under which it was known alone.
    pub power_w: Option<f64>,
    /// That over the mass, W/kg.
    pub power_w_kg: Option<f64>,
    /// Power of the joints, and what carries the weight.
    #[serde(flatten)]
    pub cost: CostSummary,
    /// Mean power of the twist joints, W.
    pub twist_power_w: Option<f64>,
    /// Mean power of the actuators, W.
    pub regulator_power_w: Option<f64>,
    /// Frequency times the vertical way of the tip against the body over the speed.
    pub strouhal: Option<f64>,
    /// Share of U^2 c dy dt beyond an angle of attack of 12 deg.
    pub stall_fraction_12: Option<f64>,
    /// The same beyond 20 deg.
    pub stall_fraction_20: Option<f64>,
    /// Share of strips and time beyond 12 and 20 deg, all strips alike.
    pub stalled_strips: Option<[f64; 2]>,
    /// Mean share of separated flow, weighted by U^2 c dy.
    pub separated_fraction: Option<f64>,
    /// Mean share of the leading edge's suction that law `lev` takes away, weighted alike.
    pub suction_lost_fraction: Option<f64>,
    /// Membranes: largest rise over the chord, slack share, frequency of the gait over theirs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub membrane: Option<MembraneSummary>,
    /// Flaps: largest angle, and that by their weight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flap: Option<FlapSummary>,
    /// Spars: largest angle between two pieces, error by their number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spar: Option<LinkSparSummary>,
    /// Springs on pins of the linkage: largest deflection from rest, that over its limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pin_springs: Option<PinSummary>,
    /// Least of all clearances over the cycle, m.
    pub least_clearance_m: Option<f64>,
    /// Between what it is, where it is the same all the time.
    #[serde(skip)]
    pub constant_clearance: Option<String>,
    /// Mean roll, deg; positive is right wing down.
    pub roll_mean_deg: Option<f64>,
    /// Mean pitch, deg; negative is nose up.
    pub pitch_mean_deg: Option<f64>,
    /// Half of the swing of the pitch, deg.
    pub pitch_half_amplitude_deg: Option<f64>,
    /// Vertical swing of the body origin, peak to peak, m.
    pub heave_m: Option<f64>,
    /// Held commands, in the unit of the actuator.
    pub commands: BTreeMap<String, f64>,
    /// Floquet multipliers, the largest first.
    pub multipliers: Vec<Multiplier>,
    /// Largest |multiplier| without the heading's, dimensionless.
    pub largest_multiplier: Option<f64>,
    /// Largest derivative, in SI units, that leads from flight in the plane of symmetry out of it, or
    /// back; straight flight only.
    pub sector_coupling: Option<f64>,
    /// Largest multiplier, dimensionless, of a deviation, the integral of the height among them, under the feedback of
    /// `gains.csv`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_multiplier: Option<f64>,
    /// Whether no multiplier but the heading's exceeds 1.
    pub stable: Option<bool>,
    /// Largest condition missed, in SI units.
    pub residual: Option<f64>,
    /// Iterations of Newton's method.
    pub iterations: Option<usize>,
    /// Runge-Kutta steps of a cycle.
    pub steps: usize,
    /// Wall time of recoil start and Newton's method, s.
    pub search_s: f64,
    /// Aerodynamic preset.
    pub aero_preset: String,
    /// Lift law.
    pub lift_law: String,
    /// Orbits of the family, the first included.
    pub family_orbits: Option<usize>,
    /// Why the family ended before its last orbit.
    pub family_ended: Option<String>,
    /// What the search of its gait came to.
    pub search: Option<SearchSummary>,
    /// What a trim from a robot's file alone chose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alone: Option<AloneSummary>,
}

impl TrimSummary {
    /// Fills in what the orbit tells.
    pub(super) fn found(&mut self, cycle: &Cycle, found: &FoundOrbit, measures: &Measures, modes: &Modes) {
        let orbit = &found.orbit;
        self.status = Status::Ok;
        self.frequency_hz = Some(1.0 / orbit.end.duration);
        let strokes = cycle.robot().strokes_per_cycle();
        self.stroke_frequency_hz = (strokes > 1).then(|| strokes as f64 / orbit.end.duration);
        self.lift_over_weight = Some(measures.lift_over_weight);
        self.side_force_over_weight = Some(measures.side_force_over_weight);
        self.cost = CostSummary::new(Some(measures.cost), cycle.robot());
        (self.power_w, self.power_w_kg) = (self.cost.positive_power_w, self.cost.positive_power_w_kg);
        self.twist_power_w = Some(measures.twist_power);
        self.regulator_power_w = Some(measures.regulator_power);
        self.strouhal = Some(measures.strouhal);
        [self.stall_fraction_12, self.stall_fraction_20] = measures.stall.sharp.map(Some);
        self.stalled_strips = Some(measures.stall.strips);
        [self.separated_fraction, self.suction_lost_fraction] = measures.stall.separated.map(Some);
        let mut first = 0;
        let skin = |(_, aero): (&str, &Aero)| {
            let own = first..first + aero.strips();
            first = own.end;
            let heights = measures.heights.iter().flat_map(|strips| strips[own.clone()].iter().copied());
            MembraneSummary::of(aero, heights, 1.0 / orbit.end.duration)
        };
        self.membrane = cycle.robot().surfaces().filter_map(skin).reduce(MembraneSummary::worse);
        let mut first = 0;
        let flap = |(_, aero): (&str, &Aero)| {
            let own = first..first + aero.strips();
            first = own.end;
            FlapSummary::of(
                aero,
                measures.flaps.iter().flat_map(|strips| strips[own.clone()].iter().copied()),
            )
        };
        self.flap = cycle.robot().surfaces().filter_map(flap).reduce(FlapSummary::worse);
        self.least_clearance_m = measures.least_clearance;
        let nearest = cycle.robot().clearances().get(measures.nearest);
        let varies = |least| measures.clearances.iter().any(|part| part - least > SAME);
        let constant = nearest.zip(measures.least_clearance).filter(|(_, least)| !varies(*least));
        self.constant_clearance = constant.map(|(channel, _)| apart(&channel.name));
        [self.roll_mean_deg, self.pitch_mean_deg] = measures.mean_angles.map(|a| Some(a.to_degrees()));
        let [low, high] = measures.pitch;
        self.pitch_half_amplitude_deg = Some(0.5 * (high - low).to_degrees());
        self.heave_m = Some(measures.heave);
        let inputs = cycle.robot().inputs().iter().zip(&orbit.point.inputs);
        self.commands = filled(inputs.map(|(channel, value)| (channel.name.clone(), *value)));
        self.multipliers = modes.modes.iter().map(Multiplier::from).collect();
        self.largest_multiplier = Some(modes.largest());
        self.sector_coupling = (!cycle.coupled(&orbit.course)).then_some(modes.coupling);
        self.stable = Some(modes.stable());
        self.residual = Some(found.residual);
        self.iterations = Some(found.iterations);
    }
}

/// The wash below a hovering robot, m/s, by momentum theory: sqrt(m g / (2 rho A)), A the circle of the span of its widest surface
/// (Leishman 2006, Principles of Helicopter Aerodynamics, 2.2).
///
/// Equation: trim.hover_wash
/// `sqrt(m g / (2 rho pi b^2/4))`
/// Source: momentum theory; Leishman 2006, Principles of Helicopter Aerodynamics, 2.2.
/// Test: `a_hover_is_outside_of_what_the_wake_can_do`.
pub(super) fn hover_wash(robot: &Robot) -> Option<f64> {
    let widths = robot.surfaces().filter_map(|(_, aero)| {
        let numbers = aero.numbers();
        Some((numbers.outline.as_ref()?.half_span(), numbers.density))
    });
    let (half_span, density) = widths.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((robot.mass() * GRAVITY / (2.0 * density * PI * half_span * half_span)).sqrt())
}
