//! Ranges of the numbers of specs: declared once by key, checked with the spec, and written into its schema.

use std::collections::BTreeMap;
use std::fmt::Display;

use crate::Error;

/// What a finite number may be. Its ends are in the caller's unit, that of the key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    low: f64,
    high: f64,
    /// Whether the ends themselves are out of it.
    open: [bool; 2],
}

impl Range {
    /// Any finite number.
    pub const FINITE: Self = Self::between(f64::NEG_INFINITY, f64::INFINITY);
    /// Above 0.
    pub const POSITIVE: Self = Self::over(0.0, f64::INFINITY);
    /// 0 or more.
    pub const NOT_NEGATIVE: Self = Self::from(0.0);

    /// `low` or more.
    pub const fn from(low: f64) -> Self {
        Self::between(low, f64::INFINITY)
    }

    /// From `low` to `high`, both allowed.
    pub const fn between(low: f64, high: f64) -> Self {
        Self { low, high, open: [false, false] }
    }

    /// Above `low` and below `high`.
    pub const fn inside(low: f64, high: f64) -> Self {
        Self { low, high, open: [true, true] }
    }

    /// Above `low`, at most `high`.
    pub const fn over(low: f64, high: f64) -> Self {
        Self { low, high, open: [true, false] }
    }

    /// Refuses a number outside.
    ///
    /// # Errors
    /// [`Error::Invalid`] with `key`.
    pub fn check(&self, key: &str, value: f64) -> Result<(), Error> {
        self.shown(key, value, value)
    }

    /// As [`check`](Self::check), with the number as it was given.
    fn shown(&self, key: &str, value: f64, given: impl Display) -> Result<(), Error> {
        let above = if self.open[0] { value > self.low } else { value >= self.low };
        let below = if self.open[1] { value < self.high } else { value <= self.high };
        let within = value.is_finite() && above && below;
        if within { Ok(()) } else { Err(Error::invalid(key, given, self.allowed())) }
    }

    /// The range in words.
    pub fn allowed(&self) -> String {
        let Self { low, high, open } = self;
        match (low.is_finite(), high.is_finite(), open) {
            (false, false, _) => "a finite number".into(),
            (true, false, [true, _]) => format!("a finite number above {low}"),
            (true, false, _) => format!("a finite number, at least {low}"),
            (false, true, [_, true]) => format!("a finite number, below {high}"),
            (false, true, _) => format!("a finite number, at most {high}"),
            (true, true, [true, false]) => format!("above {low}, at most {high}"),
            (true, true, [true, true]) => format!("between {low} and {high}, neither itself"),
            (true, true, _) => format!("{low} to {high}"),
        }
    }
}

/// A number of a spec, or several: what is not given is in every range.
pub trait RangedNumbers {
    /// Refuses numbers outside `range`; of several the key says which.
    ///
    /// # Errors
    /// [`Error::Invalid`] with `key`.
    fn check(&self, key: &str, range: &Range) -> Result<(), Error>;
}

impl RangedNumbers for f64 {
    fn check(&self, key: &str, range: &Range) -> Result<(), Error> {
        range.check(key, *self)
    }
}

impl RangedNumbers for usize {
    fn check(&self, key: &str, range: &Range) -> Result<(), Error> {
        range.shown(key, *self as f64, self)
    }
}

impl<T: RangedNumbers> RangedNumbers for Option<T> {
    fn check(&self, key: &str, range: &Range) -> Result<(), Error> {
        self.as_ref().map_or(Ok(()), |given| given.check(key, range))
    }
}

impl<T: RangedNumbers> RangedNumbers for Vec<T> {
    fn check(&self, key: &str, range: &Range) -> Result<(), Error> {
        self.iter().enumerate().try_for_each(|(i, one)| one.check(&format!("{key}[{i}]"), range))
    }
}

impl<T: RangedNumbers, const N: usize> RangedNumbers for [T; N] {
    fn check(&self, key: &str, range: &Range) -> Result<(), Error> {
        self.iter().enumerate().try_for_each(|(i, one)| one.check(&format!("{key}[{i}]"), range))
    }
}

impl<T: RangedNumbers> RangedNumbers for BTreeMap<String, T> {
    fn check(&self, key: &str, range: &Range) -> Result<(), Error> {
        self.iter().try_for_each(|(name, one)| one.check(&format!("{key}.{name}"), range))
    }
}

/// Declares the ranges of the fields of a spec: `RANGES`, by key, for its schema, and `in_range`, which refuses
/// what lies outside under the name of the field.
#[macro_export]
macro_rules! ranges {
    ($spec:ty { $($field:ident: $range:expr),* $(,)? }) => {
        impl $spec {
            /// Ranges of its numbers by key.
            pub const RANGES: &'static [(&'static str, $crate::range::Range)] =
                &[$((stringify!($field), $range)),*];

            /// Refuses numbers outside their ranges.
            ///
            /// # Errors
            /// [`Error::Invalid`]($crate::Error::Invalid) with the field.
            pub fn in_range(&self) -> Result<(), $crate::Error> {
                let mut ranges = Self::RANGES.iter();
                $(if let Some((key, range)) = ranges.next() {
                    $crate::range::RangedNumbers::check(&self.$field, key, range)?;
                })*
                Ok(())
            }
        }
    };
}

pub use ranges;

/// Writes `ranges` into the schema of their spec.
///
/// # Panics
/// When one of them is of no key of the spec.
#[cfg(feature = "schema")]
pub fn put(ranges: &'static [(&'static str, Range)]) -> impl FnMut(&mut schemars::Schema) {
    move |schema| {
        for (key, range) in ranges {
            assert!(range.put(key, schema), "{key} has a range and is no key");
        }
    }
}

/// Writes into the schema of a spec those of `ranges`, declared with the settings that it makes, which are of its keys.
#[cfg(feature = "schema")]
pub fn put_known(ranges: &'static [(&'static str, Range)]) -> impl FnMut(&mut schemars::Schema) {
    move |schema| {
        for (key, range) in ranges {
            range.put(key, schema);
        }
    }
}

#[cfg(feature = "schema")]
impl Range {
    /// Bounds the property `key` of a table's schema; false when there is none.
    fn put(&self, key: &str, schema: &mut schemars::Schema) -> bool {
        schema.pointer_mut(&format!("/properties/{key}")).map(|property| self.bound(property)).is_some()
    }

    /// Bounds a number's schema, or that of the numbers of a list or of a table under names of one's own.
    fn bound(&self, schema: &mut serde_json::Value) {
        let Some(object) = schema.as_object_mut() else { return };
        for inner in ["items", "additionalProperties"] {
            if let Some(numbers) = object.get_mut(inner) {
                return self.bound(numbers);
            }
        }
        let [low, high] = [("minimum", "exclusiveMinimum"), ("maximum", "exclusiveMaximum")];
        for ((closed, open), end, out) in [(low, self.low, self.open[0]), (high, self.high, self.open[1])] {
            if end.is_finite() {
                object.remove(closed);
                object.insert(if out { open } else { closed }.into(), end.into());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_in_or_out_and_said() {
        let said = |range: Range, value: f64| range.check("x", value).err().map(|error| error.to_string());
        assert_eq!(said(Range::POSITIVE, 1e-300), None);
        assert!(said(Range::POSITIVE, 0.0).unwrap().contains("a finite number above 0"));
        assert!(said(Range::NOT_NEGATIVE, -1.0).unwrap().contains("a finite number, at least 0"));
        assert!(said(Range::from(8.0), f64::NAN).unwrap().contains("at least 8"));
        assert!(said(Range::POSITIVE, f64::INFINITY).is_some());
        assert_eq!((said(Range::between(0.0, 1.0), 0.0), said(Range::between(0.0, 1.0), 1.0)), (None, None));
        assert!(said(Range::between(2.0, 1e4), 1.0).unwrap().contains("2 to 10000"));
        let below =
            [Range::between, Range::over, Range::inside].map(|of| of(f64::NEG_INFINITY, 5.0).allowed());
        assert_eq!(below, ["at most 5", "at most 5", "below 5"].map(|end| format!("a finite number, {end}")));
        assert!(said(Range::inside(-1.0, 1.0), 1.0).unwrap().contains("between -1 and 1, neither itself"));
    }

    struct Spec {
        rate: f64,
        limits: Option<Vec<f64>>,
        count: usize,
    }

    ranges!(Spec { rate: Range::POSITIVE, limits: Range::NOT_NEGATIVE, count: Range::between(1.0, 9.0) });

    #[test]
    fn every_field_is_checked_under_its_name() {
        let refused = |spec: Spec| spec.in_range().err().map(|error| error.to_string());
        assert_eq!(refused(Spec { rate: 1.0, limits: None, count: 9 }), None);
        let limits = Some(vec![0.0, -1.0]);
        assert!(refused(Spec { rate: 1.0, limits, count: 1 }).unwrap().contains("limits[1]"));
        assert!(refused(Spec { rate: 0.0, limits: None, count: 1 }).unwrap().contains("rate"));
        assert!(refused(Spec { rate: 1.0, limits: None, count: 10 }).unwrap().contains("count = 10"));
    }
}
