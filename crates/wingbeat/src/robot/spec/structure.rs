//! The structure elements and their regulators.

use crate::Error;
use crate::body::{Coupled, Element, Response};
use crate::robot::MAX_ELEMENTS;
use serde::{Deserialize, Serialize};

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
    /// Driven joints (rad, m), by name, or link lengths of the linkage (`l3b_left` and the like, m)
    /// that it displaces about the gait, alike.
    pub moves: Vec<String>,
    /// Lower limit of the regulator, rad or m; link lengths take theirs from the
    /// ranges of the linkage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Upper limit of the regulator, rad or m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
}

impl Default for StructureSpec {
    /// No element.
    fn default() -> Self {
        Self { frequency_hz: 12.0, damping: 0.8, elements: Vec::new(), a: None, b: None }
    }
}

impl StructureSpec {
    pub(super) fn check(&self) -> Result<(), Error> {
        if self.elements.len() > MAX_ELEMENTS {
            return Err(Error::invalid("elements", self.elements.len(), format!("at most {MAX_ELEMENTS}")));
        }
        for (i, e) in self.elements.iter().enumerate() {
            if e.moves.is_empty() {
                let allowed = "at least one joint or link length";
                return Err(Error::invalid(format!("elements[{i}].moves"), "[]", allowed));
            }
            if self.elements[..i].iter().any(|other| other.name == e.name) {
                return Err(Error::invalid(format!("elements[{i}].name"), &e.name, "a name not yet used"));
            }
        }
        Ok(())
    }

    /// The response of all elements.
    pub(in crate::robot) fn build(&self) -> Result<Response, Error> {
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
