//! Numbers of a model by name. Each type of numbers walks once over what it holds and declares each number there: its name,
//! its unit, its limits, its mirror image, and where it lies. All else follows from that walk: the same numbers in another
//! scalar, their names and values, derivatives by one of them, and the check of what they may be.

use super::{Scalar, Vec3};
use crate::Error;
use crate::range::Range;

/// What is declared of a number beside its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeclaredQuantity {
    /// Unit; empty when dimensionless. Of a joint's numbers that of a joint that turns.
    pub unit: &'static str,
    /// What it may be in any robot.
    pub range: Range,
    /// Lowest and highest value that a numbers file or a fit may give it, in `unit`. *Choices*, wide of any robot: they keep a
    /// fit from numbers without meaning.
    pub given: [f64; 2],
    /// Whether the number of the mirror image has the other sign.
    pub turned: bool,
}

impl DeclaredQuantity {
    /// A number that may be anything finite, and is given up to a million.
    pub const fn free(unit: &'static str) -> Self {
        Self { unit, range: Range::FINITE, given: [-1e6, 1e6], turned: false }
    }

    /// A number in `unit` that may lie within `range`, and is given from `low` to `high`.
    pub const fn within(unit: &'static str, range: Range, low: f64, high: f64) -> Self {
        Self { unit, range, given: [low, high], turned: false }
    }

    /// The same, whose mirror image has the other sign.
    pub const fn turned(self) -> Self {
        Self { turned: true, ..self }
    }
}

/// Of a polar vector the part across the plane of symmetry changes sign in the mirror.
pub const fn polar(quantity: DeclaredQuantity) -> [DeclaredQuantity; 3] {
    [quantity, quantity.turned(), quantity]
}

/// Of a turn the parts in the plane of symmetry change sign in the mirror.
pub const fn axial(quantity: DeclaredQuantity) -> [DeclaredQuantity; 3] {
    [quantity.turned(), quantity, quantity.turned()]
}

/// A number as it is met on a walk.
#[derive(Clone, Copy, Debug)]
pub struct Declared<'a> {
    /// Its name.
    pub name: &'a str,
    /// What is declared of it.
    pub quantity: &'a DeclaredQuantity,
}

/// What the items of a list are called: by the kind of the list, the name of what holds it, and an item's place. A list of which no
/// names are known keeps the places.
pub type Labels<'a> = &'a dyn Fn(&str, &str, usize) -> Option<String>;

/// A walk over numbers of type `P` that makes numbers of type `Q` of them.
pub struct Walk<'a, P, Q> {
    name: String,
    labels: Labels<'a>,
    see: &'a mut dyn FnMut(Option<Declared>, P) -> Q,
}

impl<'a, P: Copy, Q> Walk<'a, P, Q> {
    /// A walk on which `see` makes the new numbers; it hears nothing of what has no name.
    pub fn new(labels: Labels<'a>, see: &'a mut dyn FnMut(Option<Declared>, P) -> Q) -> Self {
        Self { name: String::new(), labels, see }
    }

    /// A number.
    pub fn number(&mut self, key: &str, quantity: &DeclaredQuantity, value: P) -> Q {
        self.within(key, |walk| walk.here(quantity, value))
    }

    /// The number that is called as the place is.
    pub fn here(&mut self, quantity: &DeclaredQuantity, value: P) -> Q {
        (self.see)(Some(Declared { name: &self.name, quantity }), value)
    }

    /// A number with a whole name of its own, wherever the walk is.
    pub fn apart(&mut self, name: &str, quantity: &DeclaredQuantity, value: P) -> Q {
        (self.see)(Some(Declared { name, quantity }), value)
    }

    /// A number that is fixed by definition and has no name.
    pub fn fixed(&mut self, value: P) -> Q {
        (self.see)(None, value)
    }

    /// What lies at `key`.
    pub fn within<R>(&mut self, key: &str, walk: impl FnOnce(&mut Self) -> R) -> R {
        let before = enter(&mut self.name, key);
        let walked = walk(self);
        self.name.truncate(before);
        walked
    }

    /// Item `place` of the list at `key`, whose items are called as those of `kind`.
    pub fn item<R>(&mut self, key: &str, kind: &str, place: usize, walk: impl FnOnce(&mut Self) -> R) -> R {
        let before = enter_item(&mut self.name, self.labels, (key, kind), place);
        let walked = walk(self);
        self.name.truncate(before);
        walked
    }

    /// A list at `key`, whose items are called as those of `kind`.
    pub fn list<T, R>(
        &mut self,
        (key, kind): (&str, &str),
        items: &[T],
        mut walk: impl FnMut(&mut Self, &T) -> R,
    ) -> Vec<R> {
        let mut made = Vec::with_capacity(items.len());
        for (i, item) in items.iter().enumerate() {
            let before = enter_item(&mut self.name, self.labels, (key, kind), i);
            made.push(walk(self, item));
            self.name.truncate(before);
        }
        made
    }

    /// Numbers that are alike, by their places.
    pub fn array<const N: usize>(
        &mut self,
        key: &str,
        quantities: &[DeclaredQuantity; N],
        values: [P; N],
    ) -> [Q; N] {
        std::array::from_fn(|i| {
            let before = enter_item(&mut self.name, self.labels, (key, ""), i);
            let made = self.here(&quantities[i], values[i]);
            self.name.truncate(before);
            made
        })
    }
}

/// Adds `key` to the name of a place; the length of the name before.
fn enter(name: &mut String, key: &str) -> usize {
    let before = name.len();
    if before > 0 && !key.is_empty() {
        name.push('.');
    }
    name.push_str(key);
    before
}

/// Adds item `place` of the list at `key` to the name of a place, by its label where it has one; the length of the name before.
fn enter_item(name: &mut String, labels: Labels, (key, kind): (&str, &str), place: usize) -> usize {
    let label = labels(kind, name, place);
    let before = enter(name, key);
    match label {
        Some(label) => drop(enter(name, &label)),
        None => name.push_str(&format!("[{place}]")),
    }
    before
}

impl<P: Scalar, Q: Scalar> Walk<'_, P, Q> {
    /// A vector, each component in the unit of its quantity.
    pub fn vector(&mut self, key: &str, quantities: &[DeclaredQuantity; 3], value: Vec3<P>) -> Vec3<Q> {
        Vec3(self.array(key, quantities, value.0))
    }
}

/// Numbers that a walk meets one by one.
pub trait Parameters<P: Scalar> {
    /// The same numbers in another scalar.
    type In<Q: Scalar>;

    /// Meets each number once, in the same order always, and makes the same of what the walk makes of them.
    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> Self::In<Q>;

    /// The same numbers in another scalar, `f` of each; values are in the unit of what is declared of them.
    fn map<Q: Scalar>(&self, mut f: impl FnMut(P) -> Q) -> Self::In<Q> {
        self.walk(&mut Walk::new(&|_, _, _| None, &mut |_, value| f(value)))
    }

    /// The same numbers in another scalar, `f` of what is declared of each and its value, in the unit of what is declared;
    /// `plain` of those without a name.
    fn map_named<Q: Scalar>(
        &self,
        labels: Labels,
        plain: impl Fn(P) -> Q,
        mut f: impl FnMut(Declared, P) -> Q,
    ) -> Self::In<Q> {
        let mut see = |declared: Option<Declared>, value| match declared {
            Some(declared) => f(declared, value),
            None => plain(value),
        };
        self.walk(&mut Walk::new(labels, &mut see))
    }

    /// Name, declaration and value of each number that has a name.
    fn named(&self, labels: Labels) -> Vec<NamedNumber<P>> {
        let mut all = Vec::new();
        self.map_named(
            labels,
            |value| value,
            |declared, value| {
                all.push(NamedNumber { name: declared.name.to_owned(), quantity: *declared.quantity, value });
                value
            },
        );
        all
    }
}

/// A number with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedNumber<P = f64> {
    /// Its name.
    pub name: String,
    /// What is declared of it.
    pub quantity: DeclaredQuantity,
    /// Its value.
    pub value: P,
}

impl NamedNumber {
    /// Refuses a value out of the number's range.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the name.
    pub fn check(&self) -> Result<(), Error> {
        self.quantity.range.check(&self.name, self.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dual;

    struct WeightedPlace<P: Scalar = f64> {
        weights: Vec<P>,
        place: Vec3<P>,
        zero: P,
    }

    impl<P: Scalar> Parameters<P> for WeightedPlace<P> {
        type In<Q: Scalar> = WeightedPlace<Q>;

        fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> WeightedPlace<Q> {
            let weight = DeclaredQuantity::within("kg", Range::POSITIVE, 0.1, 10.0);
            WeightedPlace {
                weights: at.list(("weights", "scales"), &self.weights, |at, w| at.number("kg", &weight, *w)),
                place: at.vector("place_m", &polar(DeclaredQuantity::free("m")), self.place),
                zero: at.fixed(self.zero),
            }
        }
    }

    #[test]
    fn one_walk_tells_names_limits_images_and_derivatives() {
        let pair = WeightedPlace { weights: vec![1.0, -2.0], place: Vec3::new(3.0, 4.0, 5.0), zero: 0.0 };
        let label =
            |kind: &str, _: &str, place: usize| (kind == "scales" && place == 0).then(|| "left".to_owned());
        let named = pair.named(&label);
        let names: Vec<&str> = named.iter().map(|number| number.name.as_str()).collect();
        assert_eq!(names, ["weights.left.kg", "weights[1].kg", "place_m[0]", "place_m[1]", "place_m[2]"]);
        assert_eq!(
            named.iter().map(|n| n.quantity.turned).collect::<Vec<_>>(),
            [false, false, false, true, false]
        );
        assert!(named[0].check().is_ok());
        assert!(named[1].check().unwrap_err().to_string().starts_with("weights[1].kg = -2"));
        let varied = pair.map_named(&label, Dual::<1>::constant, |declared, value| {
            if declared.name == "place_m[1]" { Dual::variable(value, 0) } else { Dual::constant(value) }
        });
        assert_eq!((varied.place[1].eps[0], varied.place[0].eps[0], varied.zero.re), (1.0, 0.0, 0.0));
        assert_eq!(pair.map(|x| 2.0 * x).weights, [2.0, -4.0]);
    }
}
