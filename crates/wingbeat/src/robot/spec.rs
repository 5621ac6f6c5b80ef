//! What a robot file says, before it is checked and built.

use super::MAX_ELEMENTS;
use crate::Error;
use crate::aero::{Gap, Planform, PlanformStation};
use crate::body::{Coupled, Element, FourierSeries, Gait, Linkage, LinkageDimensions, Response};
use crate::plant::{Channel, Role};
use crate::require::{finite, not_negative, positive, principal_inertias};
use serde::{Deserialize, Serialize};

/// A robot: body, left wing (the right one mirrors it), gait, structure.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RobotSpec {
    /// Name.
    pub name: String,
    /// Central body.
    pub body: BodySpec,
    /// Left wing.
    pub wing: WingSpec,
    /// Motion of shoulder and elbow over the flapping cycle.
    pub gait: GaitSpec,
    /// Response of the structure to its regulators.
    pub structure: StructureSpec,
}

/// Central body; lengths from the body origin in FLU axes.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BodySpec {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    pub com_m: [f64; 3],
    /// Principal inertias about the centre of mass along x, y, z, kg m2.
    pub inertia_kg_m2: [f64; 3],
    /// Drag areas of the body along x, y, z, m2: F_i = -rho/2 A_i |v_i| v_i.
    pub drag_area_m2: [f64; 3],
}

/// Left wing.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct WingSpec {
    /// Shoulder hinge from the body origin, m.
    pub shoulder_m: [f64; 3],
    /// Profile drag coefficient along the wind at zero incidence.
    pub cd0: f64,
    /// Additional drag coefficient broadside to the wind.
    pub cd90: f64,
    /// Shift of the planform along x against the hinge line, m.
    pub planform_shift_m: f64,
    /// Link between shoulder and elbow.
    pub proximal: LinkSpec,
    /// Link beyond the elbow.
    pub distal: LinkSpec,
    /// Outline by arc length from the middle, body strip included.
    pub planform: Vec<PlanformStation>,
    /// Where there is no wing, by the same arc; preset `full` only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<Gap>,
}

/// One wing link; lengths from its inner hinge, y along the span.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LinkSpec {
    /// Length along the span, m.
    pub length_m: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    pub com_m: [f64; 3],
    /// Principal inertias about the centre of mass along x, y, z, kg m2.
    pub inertia_kg_m2: [f64; 3],
}

/// How the wings flap.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum GaitSpec {
    /// Joint angles as Fourier series of the phase.
    Fourier {
        /// Flapping frequency, Hz; 0 holds the wings still.
        frequency_hz: f64,
        /// Shoulder, positive raises the wing.
        shoulder: FourierSeries,
        /// Elbow, positive raises the outer wing.
        elbow: FourierSeries,
    },
    /// Joint angles from the closed linkage of the computational structure.
    Linkage {
        /// Crank frequency, Hz; 0 holds the wings still.
        frequency_hz: f64,
        /// Dimensions of the linkage.
        #[serde(default)]
        dimensions: Box<LinkageDimensions>,
    },
}

impl GaitSpec {
    /// Flapping frequency, Hz.
    pub fn frequency_hz(&self) -> f64 {
        match self {
            Self::Fourier { frequency_hz, .. } | Self::Linkage { frequency_hz, .. } => *frequency_hz,
        }
    }

    /// The key under which a robot file gives it.
    fn kind(&self) -> &'static str {
        match self {
            Self::Fourier { .. } => "fourier",
            Self::Linkage { .. } => "linkage",
        }
    }

    /// Stops the flapping.
    pub fn hold_still(&mut self) {
        self.set_frequency_hz(0.0);
    }
    /// Flaps at another frequency, Hz.
    pub fn set_frequency_hz(&mut self, hz: f64) {
        match self {
            Self::Fourier { frequency_hz, .. } | Self::Linkage { frequency_hz, .. } => *frequency_hz = hz,
        }
    }

    /// The gait of one wing.
    pub(super) fn build(&self) -> Result<Gait, Error> {
        Ok(match self {
            Self::Fourier { shoulder, elbow, .. } => {
                Gait::Fourier { shoulder: shoulder.clone(), elbow: elbow.clone() }
            }
            Self::Linkage { dimensions, .. } => {
                let linkage =
                    Linkage::new(*dimensions.clone()).map_err(|e| e.within("linkage.dimensions"))?;
                Gait::Linkage(Box::new(linkage))
            }
        })
    }
}

/// Second-order response of the structure elements to their regulators:
/// [y'; y''] = A [y; y'] + B omega.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StructureSpec {
    /// Natural frequency of every element, Hz.
    pub frequency_hz: f64,
    /// Damping ratio of every element.
    pub damping: f64,
    /// The elements and their regulators.
    pub elements: Vec<ElementSpec>,
    /// Full matrix A (2n rows of 2n), in place of frequency and damping.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub a: Option<Vec<Vec<f64>>>,
    /// Full matrix B (2n rows of n).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub b: Option<Vec<Vec<f64>>>,
}

/// One structure element: what it displaces and how far.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ElementSpec {
    /// Name of its channel.
    pub name: String,
    /// Joints (rad) or link lengths (m) that it displaces about the gait, alike.
    pub moves: Vec<Displaced>,
    /// Lower limit of the regulator, rad; link lengths take theirs from the
    /// ranges of the linkage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Upper limit of the regulator, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
}

/// What a structure element can displace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)]
pub enum Displaced {
    SweepLeft,
    ShoulderLeft,
    ElbowLeft,
    TwistLeft,
    SweepRight,
    ShoulderRight,
    ElbowRight,
    TwistRight,
    L3bLeft,
    L5aLeft,
    L5bLeft,
    L3bRight,
    L5aRight,
    L5bRight,
}

impl Displaced {
    /// Index of the joint (see [`super::JOINTS`]), if it is one.
    pub fn joint(self) -> Option<usize> {
        let index = self as usize;
        (index < Self::L3bLeft as usize).then_some(index)
    }
    /// Wing (0 left, 1 right) and link (0 L3b, 1 L5a, 2 L5b), if it is a link length.
    pub fn link_length(self) -> Option<(usize, usize)> {
        (self as usize).checked_sub(Self::L3bLeft as usize).map(|i| (i / 3, i % 3))
    }
    /// The same of the other wing.
    pub fn mirrored(self) -> Self {
        use Displaced::*;
        match self {
            SweepLeft => SweepRight,
            ShoulderLeft => ShoulderRight,
            ElbowLeft => ElbowRight,
            TwistLeft => TwistRight,
            SweepRight => SweepLeft,
            ShoulderRight => ShoulderLeft,
            ElbowRight => ElbowLeft,
            TwistRight => TwistLeft,
            L3bLeft => L3bRight,
            L5aLeft => L5aRight,
            L5bLeft => L5bRight,
            L3bRight => L3bLeft,
            L5aRight => L5aLeft,
            L5bRight => L5bLeft,
        }
    }
    /// Unit of the displacement.
    pub fn unit(self) -> &'static str {
        if self.joint().is_some() { "rad" } else { "m" }
    }
}

impl RobotSpec {
    /// Checks what the types alone do not: ranges, names, clashes.
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.body.check().map_err(|e| e.within("body"))?;
        self.wing.check().map_err(|e| e.within("wing"))?;
        not_negative(&format!("gait.{}.frequency_hz", self.gait.kind()), self.gait.frequency_hz())?;
        self.structure.check(matches!(self.gait, GaitSpec::Linkage { .. })).map_err(|e| e.within("structure"))
    }
}

impl BodySpec {
    fn check(&self) -> Result<(), Error> {
        positive("mass_kg", self.mass_kg)?;
        finite("com_m", &self.com_m)?;
        self.drag_area_m2.iter().try_for_each(|&a| not_negative("drag_area_m2", a))?;
        principal_inertias("inertia_kg_m2", self.inertia_kg_m2)
    }
}

impl WingSpec {
    /// The planform with its gaps.
    pub fn outline(&self) -> Result<Planform, Error> {
        Planform::new(&self.planform)?.with_gaps(&self.gaps)
    }

    fn check(&self) -> Result<(), Error> {
        finite("shoulder_m", &self.shoulder_m)?;
        positive("shoulder_m", self.shoulder_m[1])?;
        finite("planform_shift_m", &[self.planform_shift_m])?;
        not_negative("cd0", self.cd0)?;
        not_negative("cd90", self.cd90)?;
        self.proximal.check().map_err(|e| e.within("proximal"))?;
        self.distal.check().map_err(|e| e.within("distal"))?;
        let span = self.shoulder_m[1] + self.proximal.length_m + self.distal.length_m;
        match self.planform.last() {
            Some(tip) if (tip.arc_m - span).abs() <= 1e-6 * span => Ok(()),
            Some(tip) => Err(Error::invalid(
                format!("planform[{}].arc_m", self.planform.len() - 1),
                tip.arc_m,
                format!("{span} m: shoulder plus both links"),
            )),
            None => Err(Error::invalid("planform", "[]", "at least two stations")),
        }
    }
}

impl LinkSpec {
    fn check(&self) -> Result<(), Error> {
        positive("length_m", self.length_m)?;
        positive("mass_kg", self.mass_kg)?;
        finite("com_m", &self.com_m)?;
        principal_inertias("inertia_kg_m2", self.inertia_kg_m2)
    }
}

impl StructureSpec {
    fn check(&self, linkage: bool) -> Result<(), Error> {
        if self.elements.len() > MAX_ELEMENTS {
            return Err(Error::invalid("elements", self.elements.len(), format!("at most {MAX_ELEMENTS}")));
        }
        for (i, e) in self.elements.iter().enumerate() {
            e.check(linkage).map_err(|error| error.within(&format!("elements[{i}]")))?;
            if self.elements[..i].iter().any(|other| other.name == e.name) {
                return Err(Error::invalid(format!("elements[{i}].name"), &e.name, "a name not yet used"));
            }
        }
        Ok(())
    }
}

impl StructureSpec {
    /// The regulators, in order.
    pub(super) fn channels(&self, gait: &Gait) -> Result<Vec<Channel>, Error> {
        let element = |(i, e): (usize, &ElementSpec)| {
            let channel = e.channel(gait).map_err(|error| error.within(&format!("elements[{i}]")))?;
            Ok(channel.of(Role::Command(i)))
        };
        self.elements.iter().enumerate().map(element).collect()
    }

    /// The response of all elements.
    pub(super) fn build(&self) -> Result<Response, Error> {
        match (&self.a, &self.b) {
            (None, None) => {
                let element = Element::new(self.frequency_hz, self.damping)?;
                Ok(Response::Uncoupled(vec![element; self.elements.len()]))
            }
            (Some(a), Some(b)) => {
                let coupled = Response::Coupled(Coupled::new(a, b)?);
                let (n, size) = (self.elements.len(), (coupled.elements(), coupled.commands()));
                if size != (n, n) {
                    let allowed = format!("{n} elements and {n} regulators, as listed");
                    return Err(Error::invalid("a", format!("{size:?}"), allowed));
                }
                Ok(coupled)
            }
            _ => Err(Error::invalid("a", "one matrix alone", "both a and b, or neither")),
        }
    }
}

impl ElementSpec {
    fn check(&self, linkage: bool) -> Result<(), Error> {
        let Some(first) = self.moves.first() else {
            return Err(Error::invalid("moves", "[]", "at least one joint or link length"));
        };
        let same = |m: &Displaced| match (first.link_length(), m.link_length()) {
            (None, None) => true,
            (Some((_, a)), Some((_, b))) => a == b,
            _ => false,
        };
        if !self.moves.iter().all(same) {
            let allowed = "either joints or one kind of link length";
            return Err(Error::invalid("moves", format!("{:?}", self.moves), allowed));
        }
        if first.link_length().is_some() && !linkage {
            return Err(Error::invalid("moves", format!("{first:?}"), "joints: a fourier gait has no links"));
        }
        Ok(())
    }

    /// The regulator's channel, the only home of its stroke limits.
    pub(super) fn channel(&self, gait: &Gait) -> Result<Channel, Error> {
        let length = self.moves.first().and_then(|m| m.link_length());
        let [low, high] = match (length, gait, self.low, self.high) {
            (Some((_, link)), Gait::Linkage(linkage), None, None) => linkage.displacement_limits()[link],
            (Some(_), _, Some(given), _) | (Some(_), _, _, Some(given)) => {
                let allowed = "no limits here: a link length has its range in gait.dimensions";
                return Err(Error::invalid("low", given, allowed));
            }
            (None, _, Some(low), Some(high)) if low < high && low.is_finite() && high.is_finite() => {
                [low, high]
            }
            _ => {
                let given = |limit: Option<f64>| limit.map_or("missing".into(), |l| l.to_string());
                let given = format!("{}, high = {}", given(self.low), given(self.high));
                return Err(Error::invalid("low", given, "finite limits, low below high"));
            }
        };
        Ok(Channel::limited(format!("command_{}", self.name), self.unit(), "", low, high))
    }
    /// Unit of the displacement.
    pub(super) fn unit(&self) -> &'static str {
        self.moves.first().map_or("", |m| m.unit())
    }
    /// Unit of the displacement's rate.
    pub(super) fn rate_unit(&self) -> &'static str {
        match self.unit() {
            "m" => "m/s",
            _ => "rad/s",
        }
    }
}
