//! Kinds of one's own that a scenario chooses by name.

use super::chosen::{Chosen, Named, keys_of};
use super::document::{ConfigError, Document};
use super::lattice::MakeLattice;
use super::spec::ScenarioSpec;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::sync::Arc;
use wingbeat_flight::guide::{
    AboutOrbitSpec, CommandsSpec, ControllerSpec, HoverSpec, Manoeuvre, MpcSpec, SearchWatch, SolverSpec,
    Turn,
};
use wingbeat_math::Error;

/// Reads the table at a key of a document as a kind.
type KindReader<K> = fn(&Document, &str) -> Result<Arc<K>, ConfigError>;

/// The kinds of manoeuvres, controllers and horizon solvers that a scenario may choose beside those that ship:
/// `[manoeuvre.NAME]`, `[controller.NAME]`, `[solver.NAME]`. A table that is refused is refused with file, line
/// and key, as those of the shipped kinds are.
///
/// ```
/// use std::ops::ControlFlow;
/// use wingbeat_flight::guide::{Manoeuvre, Reference};
/// use wingbeat_math::Vec3;
/// use wingbeat_config::{Document, Doors, Scenario};
///
/// /// Rolls to and fro.
/// #[derive(Debug, serde::Deserialize)]
/// #[serde(deny_unknown_fields)]
/// struct Weave {
///     roll_deg: f64,
///     period_s: f64,
/// }
///
/// impl Manoeuvre for Weave {
///     fn reference(&self, t: f64) -> Reference {
///         let rate = std::f64::consts::TAU / self.period_s;
///         let (roll, phase) = (self.roll_deg.to_radians(), rate * t);
///         Reference { roll: roll * phase.sin(), pitch: 0.0, w: Vec3::new(roll * rate * phase.cos(), 0.0, 0.0) }
///     }
/// }
///
/// let doors = Doors::shipped().manoeuvre::<Weave>("weave");
/// let turn = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/banking_turn.toml");
/// let weave = Document::text("weave", "weave = { roll_deg = 5.0, period_s = 1.0 }")?;
/// let document = Document::file(turn.as_ref())?.put("manoeuvre", weave)?.set("flight.duration_s=0.02");
/// let run = Scenario::open(document, &doors)?.fly(|_| ControlFlow::Continue(()))?;
/// assert_eq!(run.summary.controller.failures, 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Doors {
    manoeuvres: BTreeMap<String, KindReader<dyn Manoeuvre>>,
    controllers: BTreeMap<String, KindReader<dyn ControllerSpec>>,
    solvers: BTreeMap<String, KindReader<dyn SolverSpec>>,
    lattice: Option<MakeLattice>,
}

/// What a scenario chose.
#[derive(Clone, Debug)]
pub(super) struct ChosenKinds {
    pub manoeuvre: Option<Arc<dyn Manoeuvre>>,
    pub controller: Option<Arc<dyn ControllerSpec>>,
    pub solver: Option<Arc<dyn SolverSpec>>,
    pub lattice: Option<MakeLattice>,
    /// Who is told how far the search is with which a controller begins a flight.
    pub watch: SearchWatch,
}

impl Doors {
    /// The kinds that ship under a name of their own: the controllers `[controller.orbit]`, [`AboutOrbitSpec`],
    /// `[controller.hover]`, [`HoverSpec`], and `[controller.commands]`, [`CommandsSpec`]. One line here makes a kind part of
    /// the program.
    pub fn shipped() -> Self {
        Self::default()
            .controller::<AboutOrbitSpec>("orbit")
            .controller::<HoverSpec>("hover")
            .controller::<CommandsSpec>("commands")
    }

    /// These doors and the manoeuvre `[manoeuvre.NAME]`.
    #[must_use]
    pub fn manoeuvre<M: Manoeuvre + DeserializeOwned + 'static>(mut self, name: &str) -> Self {
        self.manoeuvres.insert(name.into(), |document, key| {
            let manoeuvre: M = document.parse_at(key)?;
            manoeuvre.check().map_err(|error| document.explain(&error.within(key)))?;
            Ok(Arc::new(manoeuvre))
        });
        self
    }

    /// These doors and the controller `[controller.NAME]`.
    #[must_use]
    pub fn controller<C: ControllerSpec + DeserializeOwned + 'static>(mut self, name: &str) -> Self {
        self.controllers.insert(name.into(), |document, key| Ok(Arc::new(document.parse_at::<C>(key)?)));
        self
    }

    /// These doors and the horizon solver `[solver.NAME]`.
    #[must_use]
    pub fn solver<H: SolverSpec + DeserializeOwned + 'static>(mut self, name: &str) -> Self {
        self.solvers.insert(name.into(), |document, key| Ok(Arc::new(document.parse_at::<H>(key)?)));
        self
    }

    /// These doors and what makes the air of `[lattice]`.
    #[must_use]
    pub fn lattice(mut self, make: MakeLattice) -> Self {
        self.lattice = Some(make);
        self
    }

    /// What makes the air of `[lattice]`.
    pub(super) fn makes_lattice(&self) -> Option<MakeLattice> {
        self.lattice
    }

    /// What `spec`, read from `document`, chooses.
    pub(super) fn choose(
        &self,
        spec: &ScenarioSpec,
        document: &Document,
    ) -> Result<ChosenKinds, ConfigError> {
        let manoeuvre: Option<Arc<dyn Manoeuvre>> = match &spec.manoeuvre {
            None => None,
            Some(Chosen::Shipped(turn)) => {
                turn.check().map_err(|error| document.explain(&error.within("manoeuvre")))?;
                Some(Arc::new(turn.clone()))
            }
            Some(Chosen::Own(named)) => {
                Some(open(&self.manoeuvres, named, "manoeuvre", keys_of::<Turn>(), document)?)
            }
        };
        let controller: Option<Arc<dyn ControllerSpec>> = match &spec.controller {
            None => None,
            Some(Chosen::Shipped(predictive)) => Some(Arc::new(predictive.clone())),
            Some(Chosen::Own(named)) => {
                Some(open(&self.controllers, named, "controller", keys_of::<MpcSpec>(), document)?)
            }
        };
        let solver = spec.solver.as_ref().map(|named| open(&self.solvers, named, "solver", &[], document));
        Ok(ChosenKinds {
            manoeuvre,
            controller,
            solver: solver.transpose()?,
            lattice: self.lattice,
            watch: SearchWatch::default(),
        })
    }
}

/// Reads what stands under the `named` kind of the table `table`; `keys` are those of the kind that ships.
fn open<K: ?Sized>(
    kinds: &BTreeMap<String, KindReader<K>>,
    named: &Named,
    table: &str,
    keys: &[&str],
    document: &Document,
) -> Result<Arc<K>, ConfigError> {
    let key = format!("{table}.{}", named.name);
    if let Some(read) = kinds.get(&named.name) {
        return read(document, &key);
    }
    let known = kinds.keys().map(String::as_str).chain(keys.iter().copied()).collect::<Vec<_>>();
    let allowed = if known.is_empty() { "no name: there is no other kind".into() } else { known.join(", ") };
    Err(document.explain(&Error::invalid(key, "a table", allowed)))
}
