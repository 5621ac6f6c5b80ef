//! The structure elements and their actuators.

use crate::MAX_ELEMENTS;
use crate::body::{Coupled, Element, Response};
use crate::joints::CRANK;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wingbeat_math::Error;
use wingbeat_math::names::one_of;
use wingbeat_math::range::{Range, ranges};

/// Second-order response of n structure elements to m <= n actuators,
/// [y'; y''] = A [y; y'] + B omega with the state in the order y_1 .. y_n, y'_1 .. y'_n of `elements` and
/// the commands in that of `regulators`. Either every element is of its own, y'' = k (P omega - y) - c y'
/// by its frequency and damping; or `stiffness_per_s2` and `damping_per_s` couple them,
/// y'' = K (P omega - y) - C y'; or `a` and `b` give all. P is the placement of the actuators.
#[derive(Clone, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct StructureSpec {
    /// Natural frequency of every element that gives none, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// Damping ratio of every element that gives none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// What is displaced.
    pub elements: Vec<ElementSpec>,
    /// The actuators; without them each element has its own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub regulators: Vec<RegulatorSpec>,
    /// Stiffness K per unit inertia (n rows of n), 1/s2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_per_s2: Option<Vec<Vec<f64>>>,
    /// Damping C per unit inertia (n rows of n), 1/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping_per_s: Option<Vec<Vec<f64>>>,
    /// Full matrix A (2n rows of 2n), its upper rows [0 1], 1/s and 1/s2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub a: Option<Vec<Vec<f64>>>,
    /// Full matrix B (2n rows of m), its upper rows 0, 1/s2 for elements and commands of one unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub b: Option<Vec<Vec<f64>>>,
}

/// One actuator: which elements it moves.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegulatorSpec {
    /// Name of its channel.
    pub name: String,
    /// Displacement of each element at rest, in its unit, per unit of the command, by the name of the element: the column of
    /// the placement P; with `b` none, which holds it.
    #[serde(default)]
    pub elements: BTreeMap<String, f64>,
    /// Lower limit of the command, in the unit of the first of its elements. Without limits of its own
    /// it keeps each of its elements within theirs; link lengths always have theirs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Upper limit of the command, in the unit of `low`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
}

/// One structure element: what it displaces and how far.
#[derive(Clone, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct ElementSpec {
    /// Name of its channel.
    pub name: String,
    /// What it displaces about the gait, all alike: driven joints (rad, m) by name; elastic joints, the rest of
    /// whose spring it displaces; link lengths of the linkage (`l3b_left` and the like, m); or `crank` alone, which
    /// turns at the gait's rate and that of the element, whose command is a rate (rad/s): y'' = 2 pi f (omega - y').
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub moves: Vec<String>,
    /// Joints driven by series, by name, whose harmonics it scales by 1 + y, in place of `moves`; their means stay.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scales: Vec<String>,
    /// Lower limit of the actuator, rad or m; link lengths take theirs from the
    /// ranges of the linkage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Upper limit of the actuator, rad or m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// Inertia as what it moves meets it: of its actuator and of the gears between, kg m2 of joints that turn and of `scales`, kg of those
    /// that slide and of link lengths. It then bears what its joints bear: m y'' is m times the response by itself plus the
    /// load along y. Without it nothing pushes the element back.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<f64>,
    /// Natural frequency, Hz, in place of the structure's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// Damping ratio in place of the structure's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Number of the thruster whose thrust it is; no element of a file is one.
    #[serde(skip)]
    pub(crate) thruster: Option<usize>,
}

ranges!(StructureSpec { frequency_hz: Range::POSITIVE, damping: Range::NOT_NEGATIVE });
ranges!(ElementSpec {
    inertia: Range::POSITIVE,
    frequency_hz: Range::POSITIVE,
    damping: Range::NOT_NEGATIVE
});

impl ElementSpec {
    /// Whether it changes the rate of the crank.
    pub(crate) fn turns_crank(&self) -> bool {
        self.moves == [CRANK]
    }
}

impl StructureSpec {
    pub(super) fn check(&self) -> Result<(), Error> {
        let (elements, regulators) = (self.elements.len(), self.regulators.len());
        if elements > MAX_ELEMENTS {
            return Err(Error::invalid("elements", elements, format!("at most {MAX_ELEMENTS}")));
        }
        if regulators > elements {
            let allowed = format!("at most as many as elements, {elements}");
            return Err(Error::invalid("regulators", regulators, allowed));
        }
        for (i, e) in self.elements.iter().enumerate() {
            if e.moves.is_empty() && e.scales.is_empty() {
                let allowed = "at least one joint or link length, or `scales`";
                return Err(Error::invalid(format!("elements[{i}].moves"), "[]", allowed));
            }
            if !(e.moves.is_empty() || e.scales.is_empty()) {
                let allowed = "nothing beside `moves`";
                return Err(Error::invalid(
                    format!("elements[{i}].scales"),
                    format!("{:?}", e.scales),
                    allowed,
                ));
            }
            if let (true, Some(damping)) = (e.turns_crank(), e.damping) {
                let allowed = "nothing: the crank's rate follows its command";
                return Err(Error::invalid(format!("elements[{i}].damping"), damping, allowed));
            }
        }
        for (i, regulator) in self.regulators.iter().enumerate() {
            let placed = self.check_placement(regulator);
            placed.map_err(|e| e.within(&format!("regulators[{i}].elements")))?;
        }
        self.check_ways()
    }

    /// That an actuator moves elements there are, by finite gains other than 0.
    fn check_placement(&self, regulator: &RegulatorSpec) -> Result<(), Error> {
        match (regulator.elements.is_empty(), &self.b) {
            (true, None) => return Err(Error::invalid("", "{}", "at least one element with its gain")),
            (false, Some(_)) => {
                let allowed = "nothing: b says what each regulator moves";
                return Err(Error::invalid("", format!("{:?}", regulator.elements), allowed));
            }
            _ => {}
        }
        for (name, gain) in &regulator.elements {
            if self.place(name).is_none() {
                let names: Vec<&str> = self.elements.iter().map(|e| e.name.as_str()).collect();
                return Err(Error::invalid("", format!("{name:?}"), one_of(name, &names)));
            }
            if !gain.is_finite() || *gain == 0.0 {
                return Err(Error::invalid(name, gain, "a finite gain other than 0"));
            }
        }
        Ok(())
    }

    /// That the response is given in one way alone.
    fn check_ways(&self) -> Result<(), Error> {
        self.in_range()?;
        let within = |i: usize| move |e: Error| e.within(&format!("elements[{i}]"));
        self.elements.iter().enumerate().try_for_each(|(i, e)| e.in_range().map_err(within(i)))?;
        let pair = |[one, other]: [(&'static str, bool); 2]| match (one.1, other.1) {
            (true, false) => {
                Err(Error::invalid(other.0, "missing", format!("both {} and {}", one.0, other.0)))
            }
            (false, true) => Err(Error::invalid(one.0, "missing", format!("both {} and {}", one.0, other.0))),
            (given, _) => Ok(given),
        };
        let full = pair([("a", self.a.is_some()), ("b", self.b.is_some())])?;
        let coupled = pair([
            ("stiffness_per_s2", self.stiffness_per_s2.is_some()),
            ("damping_per_s", self.damping_per_s.is_some()),
        ])?;
        if full && coupled {
            let allowed = "either a and b or stiffness_per_s2 and damping_per_s";
            return Err(Error::invalid("a", "both", allowed));
        }
        if !(full || coupled) {
            return Ok(());
        }
        let own = |(i, e): (usize, &ElementSpec)| {
            let numbers = [("frequency_hz", e.frequency_hz), ("damping", e.damping)];
            numbers.into_iter().find_map(|(k, v)| Some((format!("elements[{i}].{k}"), v?)))
        };
        let all = [("frequency_hz", self.frequency_hz), ("damping", self.damping)];
        let all = all.into_iter().find_map(|(k, v)| Some((k.to_string(), v?)));
        match all.or_else(|| self.elements.iter().enumerate().find_map(own)) {
            Some((key, value)) => {
                Err(Error::invalid(key, value, "nothing: the matrices say how the structure responds"))
            }
            None => Ok(()),
        }
    }

    /// Place of the element called `name`.
    pub(crate) fn place(&self, name: &str) -> Option<usize> {
        self.elements.iter().position(|e| e.name == name)
    }

    /// Placement of the actuators, n rows of m: displacement at rest per command. `None` where each
    /// element has its own, or `b` is given.
    pub(crate) fn placement(&self) -> Option<Vec<Vec<f64>>> {
        if self.regulators.is_empty() || self.b.is_some() {
            return None;
        }
        let gain = |e: &ElementSpec, r: &RegulatorSpec| r.elements.get(&e.name).copied().unwrap_or(0.0);
        let row = |e: &ElementSpec| self.regulators.iter().map(|r| gain(e, r)).collect();
        Some(self.elements.iter().map(row).collect())
    }

    /// The response of all elements.
    pub(crate) fn build(&self) -> Result<Response, Error> {
        let n = self.elements.len();
        let m = if self.regulators.is_empty() { n } else { self.regulators.len() };
        let coupled = match (&self.a, &self.b, &self.stiffness_per_s2, &self.damping_per_s) {
            (Some(a), Some(b), ..) => Coupled::new(a, b)?,
            (_, _, Some(stiffness), Some(damping)) => {
                let placement = self.placement().unwrap_or_else(|| identity(n));
                Coupled::placed(stiffness, damping, &placement)?
            }
            _ => return self.of_elements(),
        };
        let coupled = Response::Coupled(coupled);
        let size = (coupled.elements(), coupled.commands());
        if size == (n, m) {
            return Ok(coupled);
        }
        let allowed = format!("{n} elements and {m} regulators, as listed");
        Err(Error::invalid(
            if self.a.is_some() { "a" } else { "stiffness_per_s2" },
            format!("{size:?}"),
            allowed,
        ))
    }

    /// The response of elements that do not know of one another.
    fn of_elements(&self) -> Result<Response, Error> {
        let number = |i: usize, key: &str, own: Option<f64>, all: Option<f64>| match (own, all) {
            (Some(own), _) => Ok((format!("elements[{i}].{key}"), own)),
            (None, Some(all)) => Ok((key.to_string(), all)),
            (None, None) => Err(Error::invalid(key, "missing", "a number for all elements, or one in each")),
        };
        let element = |(i, e): (usize, &ElementSpec)| {
            let (frequency_key, frequency) = number(i, "frequency_hz", e.frequency_hz, self.frequency_hz)?;
            if e.turns_crank() {
                return Element::of_rate(frequency)
                    .map_err(|e| e.renamed(&[("frequency_hz", frequency_key)]));
            }
            let (damping_key, damping) = number(i, "damping", e.damping, self.damping)?;
            let keys = [("frequency_hz", frequency_key), ("damping", damping_key)];
            Element::new(frequency, damping).map_err(|e| e.renamed(&keys))
        };
        let elements: Vec<Element> =
            self.elements.iter().enumerate().map(element).collect::<Result<_, _>>()?;
        let Some(placement) = self.placement() else { return Ok(Response::Uncoupled(elements)) };
        Ok(Response::Coupled(Coupled::of_elements(&elements, &placement)))
    }
}

fn identity(n: usize) -> Vec<Vec<f64>> {
    (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect()
}
