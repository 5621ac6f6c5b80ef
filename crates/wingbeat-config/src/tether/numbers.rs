//! Numbers of a tethered wing by name, and derivatives of its loads by them.

use super::{TetherCase, TetherSpec};
use crate::Document;
use crate::fit::ByName;
use crate::spar_numbers::SparNumbers;
use wingbeat_aero::Aero;
use wingbeat_flight::tether::{CycleWrenches, Plane, Spar, Tether, WingNumbers};
use wingbeat_judge::Warning;
use wingbeat_math::names::one_of;
use wingbeat_math::{Declared, Error, NamedNumber, Parameters};
use wingbeat_ocp::plant::Fault;
use wingbeat_robot::{DriveSpec, check_given, former};

/// What the names of numbers begin with that a wing alone has not.
const ELSEWHERE: [&str; 7] = ["body", "links", "linkage", "structure", "gait", "mount", "crank"];

/// Whether the number called `name` is none of those that a wing alone has not.
fn is_own(name: &str) -> bool {
    let of = name.split_once('.').map_or("", |(of, _)| of);
    !ELSEWHERE.contains(&of) && !DriveSpec::NAMES.contains(&of)
}

/// A model, and its spar, with those of the numbers `to` that are their own.
fn renumbered(
    aero: &Aero,
    spar: Option<SparNumbers>,
    to: &[(&str, f64)],
) -> Result<(Aero, Option<SparNumbers>), Error> {
    let wing = WingNumbers::of(aero);
    let known = named(&wing, spar.as_ref());
    for (name, value) in to.iter().filter(|(name, _)| is_own(name)) {
        let Some(number) = known.iter().find(|number| number.name == *name) else {
            let names: Vec<&str> = known.iter().map(|number| number.name.as_str()).collect();
            let allowed =
                former(name).map_or_else(|| one_of(name, &names), |new| format!("its new name, {new:?}"));
            return Err(Error::invalid("numbers", format!("{name:?}"), allowed));
        };
        check_given(name, &number.quantity, *value)
            .map_err(|e| e.renamed(&[(*name, format!("numbers.\"{name}\""))]))?;
        NamedNumber { value: *value, ..number.clone() }.check()?;
    }
    let given = |number: Declared, own| {
        to.iter().find(|(name, _)| *name == number.name).map_or(own, |(_, value)| *value)
    };
    let WingNumbers(numbers) = wing.map_named(&|_, _, _| None, |own| own, given);
    let spar = spar.map(|spar| spar.map_named(&|_, _, _| None, |own| own, given));
    Ok((aero.with(&numbers)?, spar))
}

/// The numbers of a wing and of its spar, with what is declared of them.
fn named(wing: &WingNumbers, spar: Option<&SparNumbers>) -> Vec<NamedNumber> {
    let mut known = wing.named(&|_, _, _| None);
    known.extend(spar.into_iter().flat_map(|spar| spar.named(&|_, _, _| None)));
    known
}

/// Change of a number of a bent wing for a difference, over its value or, where that is less, over [`LEAST`]. *Choice.*
const DIFFERENCE: f64 = 1e-3;
/// Least size of such a number, in its unit. *Choice.*
const LEAST: f64 = 1e-3;

impl TetherCase {
    /// Names and values of the numbers that `numbers` may give, as a robot calls those of its wing and air, in their declared
    /// units.
    pub fn named_numbers(&self) -> Vec<(String, f64)> {
        self.parameters().into_iter().map(|number| (number.name, number.value)).collect()
    }

    /// The same with what is declared of them.
    pub fn parameters(&self) -> Vec<NamedNumber> {
        named(&WingNumbers::of(&self.tether.aero), self.spar_numbers.as_ref())
    }

    /// The wing in its wind with other numbers, in their declared units; those of what a wing alone has not do not count.
    ///
    /// # Errors
    /// A number that the wing has not, or that cannot be.
    pub fn adjusted(&self, to: &[(&str, f64)]) -> Result<Tether, Error> {
        let (aero, numbers) = renumbered(&self.tether.aero, self.spar_numbers, to)?;
        let ground = self.tether.ground.as_ref().map(|plane| Plane::new(&aero, plane.height_m));
        let spar = self.spec.built_spar(&aero, self.tether.wing.planform(), numbers)?;
        // Loads do not ask how fine the shape at rest is.
        let spar = spar.map(|spar| Spar { finer: None, ..spar });
        Ok(Tether { aero, ground, spar, ..self.tether.clone() })
    }

    /// The derivatives of the loads over the last cycle, N and N m over the units of the numbers called `keys`, in their order, where the
    /// numbers are `to`; no load depends on what a wing alone has not. Those of a wing that bends are differences, central but at the ends of what a number may be.
    ///
    /// # Errors
    /// A number that the wing has not; a fault of the model.
    pub fn differentiated(
        &self,
        to: &[(&str, f64)],
        keys: &[&str],
    ) -> Result<Result<Vec<CycleWrenches>, Fault>, Error> {
        if self.tether.spar.is_some() {
            return keys.iter().map(|key| self.difference(to, key)).collect();
        }
        let tether = self.adjusted(to)?;
        let varied: Vec<&str> = keys.iter().copied().filter(|key| is_own(key)).collect();
        Ok(tether.differentiated(&varied)?.map(|found| {
            let mut found = found.into_iter();
            let none = || self.no_loads();
            let one = |key: &&str| is_own(key).then(|| found.next()).flatten().unwrap_or_else(none);
            keys.iter().map(one).collect()
        }))
    }

    fn no_loads(&self) -> CycleWrenches {
        vec![[0.0; 6]; self.tether.clock.steps_per_cycle]
    }

    /// The derivative by the number called `key`, by a difference.
    fn difference(&self, to: &[(&str, f64)], key: &str) -> Result<Result<CycleWrenches, Fault>, Error> {
        if !is_own(key) {
            return Ok(Ok(self.no_loads()));
        }
        let own = self.parameters().into_iter().find(|number| number.name == key);
        let own = own.ok_or_else(|| Error::invalid("numbers", format!("{key:?}"), "a number of the wing"))?;
        let value = to.iter().find(|(name, _)| *name == key).map_or(own.value, |(_, value)| *value);
        let step = DIFFERENCE * value.abs().max(LEAST);
        // Within what the number is given, and may be.
        let [least, most] = own.quantity.given;
        let (low, high) = ((value - step).max(least), (value + step).min(most));
        let at = |value: f64| -> Result<Result<CycleWrenches, Fault>, Error> {
            let others = to.iter().copied().filter(|(name, _)| *name != key);
            let moved: Vec<(&str, f64)> = others.chain([(key, value)]).collect();
            Ok(self.adjusted(&moved)?.last_wrenches())
        };
        let (below, above) = (at(low)?, at(high)?);
        let slope = |(below, above): (&[f64; 6], &[f64; 6])| -> [f64; 6] {
            std::array::from_fn(|k| (above[k] - below[k]) / (high - low))
        };
        Ok(below.and_then(|below| Ok(below.iter().zip(&above?).map(slope).collect())))
    }
}

impl TetherSpec {
    /// The wing's model and its spar with those of `numbers` that are their own; those of bodies, gait and rig do not count.
    pub(super) fn numbered(&self, aero: &Aero) -> Result<(Aero, Option<SparNumbers>), Error> {
        let given: Vec<(&str, f64)> =
            self.numbers.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        renumbered(aero, self.spar.as_ref().map(SparNumbers::of), &given)
    }

    /// The numbers of its spar.
    pub(super) fn spar_numbers(&self) -> Option<SparNumbers> {
        let given = |number: Declared, own| self.numbers.get(number.name).copied().unwrap_or(own);
        Some(SparNumbers::of(self.spar.as_ref()?).map_named(&|_, _, _| None, |own| own, given))
    }
}

/// The warnings that overrides of the merged `document` of a case, `spec`, say numbers of its wing that `numbers` gives too.
pub(crate) fn given_twice(document: &Document, spec: &TetherSpec) -> Vec<Warning> {
    let tables = &["wing", "wind", "aero", "spar"];
    let by_name = ByName { key: "numbers", of: "", given: &spec.numbers, tables };
    by_name.given_twice(document, |document| {
        let spec: TetherSpec = document.parse().ok()?;
        let (_, _, aero) = spec.own_aero().ok()?;
        Some(named(&WingNumbers::of(&aero), spec.spar.as_ref().map(SparNumbers::of).as_ref()))
    })
}
