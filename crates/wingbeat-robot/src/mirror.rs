//! Left and right: a robot whose wings move alike, in an air that meets them alike.

use super::Robot;
use super::joints::Displaced;
use wingbeat_math::Error;

/// The states and inputs of a carried robot whose two wings move alike: one of
/// each pair is kept, the other equals it.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    /// Kept states, as numbers of [`Robot::carried`]'s.
    pub states: Vec<usize>,
    /// Kept inputs.
    pub inputs: Vec<usize>,
    /// For every state the place of the kept one that it equals.
    state_of: Vec<usize>,
    /// For every input the same.
    input_of: Vec<usize>,
}

impl Mirror {
    /// All states from the kept ones.
    pub fn expand_states<S: Copy>(&self, kept: &[S], all: &mut [S]) {
        expand(&self.state_of, kept, all);
    }
    /// All inputs from the kept ones.
    pub fn expand_inputs<S: Copy>(&self, kept: &[S], all: &mut [S]) {
        expand(&self.input_of, kept, all);
    }
}

fn expand<S: Copy>(of: &[usize], kept: &[S], all: &mut [S]) {
    for (value, &place) in all.iter_mut().zip(of) {
        *value = kept[place];
    }
}

impl Robot {
    /// Which states and inputs of the carried robot are one another's mirror images.
    ///
    /// # Errors
    /// [`Error::Invalid`] when an element of one wing has none on the other, or a surface is one-sided.
    pub fn mirror(&self) -> Result<Mirror, Error> {
        if let Some(surface) = self.covering.laid.iter().find(|surface| !surface.symmetric) {
            let allowed = "symmetric surfaces alone, where both wings move alike";
            return Err(Error::invalid("surfaces.span", &surface.name, allowed));
        }
        self.pairs()
    }

    /// The same of a robot that may have one-sided surfaces, such as a fin: these stand for themselves.
    ///
    /// # Errors
    /// [`Error::Invalid`] when an element of one wing has none on the other, or there are thrusters.
    pub fn pairs(&self) -> Result<Mirror, Error> {
        if !self.thrusters.is_empty() {
            let allowed = "no thrusters where left and right have to move alike";
            return Err(Error::invalid("thrusters", "given", allowed));
        }
        let elements = self.elements.len();
        let mut twin = Vec::with_capacity(elements);
        for element in &self.elements {
            twin.push(self.twin(&element.moves)?);
        }
        let inertia = |e: usize| self.loaded.iter().find(|of| of.element == e).map(|of| of.inertia);
        if let Some(e) = (0..elements).find(|&e| inertia(e) != inertia(twin[e])) {
            let allowed = "that of the same element of the other wing";
            let given = inertia(e).map_or("none".into(), |inertia| inertia.to_string());
            let key = |e: usize| format!("structure.elements[{e}].inertia");
            return Err(Error::invalid(key(e), given, allowed).against([key(twin[e])]));
        }
        let coordinates = &self.mechanism.coordinates;
        let image = |joint: &usize| {
            let twin = self.mechanism.twins[*joint];
            coordinates.iter().position(|c| *c == twin).unwrap_or_default()
        };
        let crank = self.motor.map(|_| coordinates.len());
        let joints: Vec<usize> = coordinates.iter().map(image).chain(crank).collect();
        let (first, count) = (2 * elements, self.degrees());
        let mut states: Vec<usize> = twin.clone();
        states.extend(twin.iter().map(|i| elements + i));
        states.extend(joints.iter().map(|i| first + i));
        states.extend(joints.iter().map(|i| first + count + i));
        let (air, first) = (&self.covering.aero, first + 2 * count);
        let image = |i: usize| if self.is_of_one_side(i) { i } else { air.mirrored(i) };
        states.extend((0..air.states()).map(|i| first + image(i)));
        let (states, state_of) = halves(&states);
        let (inputs, input_of) = halves(&self.regulator_twins(&twin)?);
        Ok(Mirror { states, inputs, state_of, input_of })
    }

    /// Whether state `i` of the air belongs to a one-sided surface.
    pub fn is_of_one_side(&self, i: usize) -> bool {
        let one_sided =
            |name: &str| self.covering.laid.iter().any(|laid| !laid.symmetric && laid.name == name);
        self.covering.aero.image(i).is_some_and(|(name, _)| one_sided(name))
    }

    /// The regulator that does on the other wing what each does; `twin` are the elements' images.
    fn regulator_twins(&self, twin: &[usize]) -> Result<Vec<usize>, Error> {
        let (n, response) = (twin.len(), &self.response);
        let state = |j: usize| if j < n { twin[j] } else { n + twin[j - n] };
        let alike = |a: f64, b: f64| (a - b).abs() <= ALIKE * a.abs().max(b.abs());
        let same =
            |(i, j): (usize, usize)| alike(response.state_gain(i, j), response.state_gain(twin[i], state(j)));
        if let Some((i, j)) = (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j))).find(|&ij| !same(ij)) {
            let allowed = "a response that is the same for both wings";
            // What couples elements stands in a matrix, the rest at the element too.
            let number = if j < n { "frequency_hz" } else { "damping" };
            let key = |e: usize| format!("structure.elements[{e}].{number}");
            return Err(if j % n == i {
                Error::invalid(key(i), "unlike its twin's", allowed).against([key(twin[i])])
            } else {
                Error::invalid("structure.a", format!("row {}, column {j}", n + i), allowed)
            });
        }
        let image = |r: usize, s: usize| {
            (0..n).all(|e| alike(response.command_gain(e, r), response.command_gain(twin[e], s)))
        };
        let of = |r: usize| {
            let missing = || {
                let allowed = "for every regulator one that does the same to the other wing";
                Error::invalid("structure.regulators", &self.inputs[r].name, allowed)
            };
            (0..self.inputs.len()).find(|&s| image(r, s)).ok_or_else(missing)
        };
        (0..self.inputs.len()).map(of).collect()
    }

    /// The element that moves on the other wing what `moves` says.
    fn twin(&self, moves: &[Displaced]) -> Result<usize, Error> {
        let image: Vec<Displaced> = moves.iter().map(|m| m.mirrored(&self.mechanism)).collect();
        let same =
            |other: &[Displaced]| other.len() == moves.len() && image.iter().all(|m| other.contains(m));
        let allowed = "for every element one that moves the same of the other wing";
        let missing = || Error::invalid("structure.elements.moves", format!("{moves:?}"), allowed);
        self.elements.iter().position(|e| same(&e.moves)).ok_or_else(missing)
    }
}

/// Relative difference at which two gains still count as the same.
const ALIKE: f64 = 1e-12;

/// Of every pair (i, twin) the first is kept; for each its place among the kept.
fn halves(twin: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let kept: Vec<usize> = (0..twin.len()).filter(|&i| i <= twin[i]).collect();
    let place = |(i, &t): (usize, &usize)| kept.partition_point(|&k| k < i.min(t));
    let of = twin.iter().enumerate().map(place).collect();
    (kept, of)
}
