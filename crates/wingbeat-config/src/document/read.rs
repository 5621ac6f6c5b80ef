//! From the tree of a document to a type of the library: every complaint carries its path, and all are collected.

mod access;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::de::{self, DeserializeOwned, Deserializer, Unexpected, Visitor};
use toml::Spanned;
use toml::de::DeValue;

use super::tree::dotted;
use access::{Entries, Items, VariantChoice};

/// Methods for a type that any value is asked for: zero, or what there is of the kind, answers where a placeholder stands.
macro_rules! typed {
    ($($method:ident => $visit:ident($($value:expr)?);)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Complaint> {
            if self.replaced { visitor.$visit($($value)?) } else { self.deserialize_any(visitor) }
        }
    )*};
}

/// Most complaints of one document.
const MOST: usize = 100;

/// What is wrong at a path. Boxed, as every field of every table is read into it or its value.
#[derive(Debug)]
pub struct Complaint(Box<(Option<String>, FormFault)>);

/// What can be wrong with the form of a document.
#[derive(Clone, Debug)]
pub enum FormFault {
    /// A key that must be given.
    Missing(String),
    /// A key that is not known, and those that are.
    Unknown(String, Vec<String>),
    /// A name that is not known, and those that are.
    Name(Vec<String>),
    /// Another value than what is allowed.
    Value(String),
}

/// The value `node` at `path` as a `T`, or everything that keeps it from being one.
pub fn read<T: DeserializeOwned>(node: &Spanned<DeValue<'_>>, path: &str) -> Result<T, Vec<Complaint>> {
    let mut mended = Mended::default();
    let mut complaints = Vec::new();
    loop {
        let reader = Reader::of(node, path.into(), &mended);
        match T::deserialize(reader) {
            Ok(value) if complaints.is_empty() => return Ok(value),
            Ok(_) => return Err(complaints),
            Err(complaint) => {
                let again = mended.mend(&complaint);
                complaints.push(complaint);
                if !again || complaints.len() == MOST {
                    return Err(complaints);
                }
            }
        }
    }
}

/// What earlier complaints were about: mended, so that the next one can be found.
#[derive(Debug, Default)]
struct Mended {
    /// Keys left out.
    ignored: BTreeSet<String>,
    /// Values with a placeholder in their place.
    replaced: BTreeSet<String>,
    /// Missing keys by their table, added with a placeholder.
    added: BTreeMap<String, Vec<String>>,
}

impl Mended {
    /// False when it was mended already and that did not help.
    fn mend(&mut self, complaint: &Complaint) -> bool {
        let path = complaint.path().unwrap_or_default().to_owned();
        match complaint.fault() {
            FormFault::Missing(name) => {
                let names = self.added.entry(path).or_default();
                let new = !names.contains(name);
                names.push(name.clone());
                new
            }
            FormFault::Unknown(name, _) => self.ignored.insert(dotted(&path, name)),
            FormFault::Name(_) | FormFault::Value(_) => !path.is_empty() && self.replaced.insert(path),
        }
    }
}

impl std::error::Error for Complaint {}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {:?}", self.path().unwrap_or_default(), self.fault())
    }
}

impl Complaint {
    fn new(fault: FormFault) -> Self {
        Self(Box::new((None, fault)))
    }

    /// The path of the value at fault, or of the table in which the named key is.
    pub fn path(&self) -> Option<&str> {
        self.0.0.as_deref()
    }

    /// What is wrong there.
    pub fn fault(&self) -> &FormFault {
        &self.0.1
    }

    /// The path is that of the innermost value.
    #[inline(never)]
    fn at(mut self, path: &str) -> Self {
        self.0.0.get_or_insert_with(|| path.into());
        self
    }
}

fn names(known: &[&str]) -> Vec<String> {
    known.iter().map(|name| (*name).to_owned()).collect()
}

impl de::Error for Complaint {
    fn custom<T: fmt::Display>(what: T) -> Self {
        Self::new(FormFault::Value(what.to_string()))
    }
    fn invalid_type(_: Unexpected, expected: &dyn de::Expected) -> Self {
        Self::new(FormFault::Value(in_words(&expected.to_string())))
    }
    fn invalid_value(_: Unexpected, expected: &dyn de::Expected) -> Self {
        Self::new(FormFault::Value(in_words(&expected.to_string())))
    }
    fn invalid_length(_: usize, expected: &dyn de::Expected) -> Self {
        Self::new(FormFault::Value(in_words(&expected.to_string())))
    }
    fn unknown_variant(_: &str, known: &'static [&'static str]) -> Self {
        Self::new(FormFault::Name(names(known)))
    }
    fn unknown_field(name: &str, known: &'static [&'static str]) -> Self {
        Self::new(FormFault::Unknown(name.into(), names(known)))
    }
    fn missing_field(name: &'static str) -> Self {
        Self::new(FormFault::Missing(name.into()))
    }
    fn duplicate_field(name: &'static str) -> Self {
        Self::new(FormFault::Value(format!("{name} once")))
    }
}

/// serde's names of types, in words.
fn in_words(expected: &str) -> String {
    let whole = ["u8", "u16", "u32", "u64", "usize"];
    match expected {
        "f64" | "f32" => "a number".into(),
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number".into(),
        name if whole.contains(&name) => "a whole number, not negative".into(),
        "a boolean" => "true or false".into(),
        "a string" | "path string" => "text in quotes".into(),
        "a sequence" => "a list".into(),
        "a map" => "a table".into(),
        name if name.starts_with("struct ") => "a table".into(),
        other => other.replace("an array of length", "a list of length"),
    }
}

/// A value of the tree with its path. A placeholder becomes whatever is asked for, zero of every type, of a choice the first: it stands
/// for what is missing or wrong while the rest is read. One type for both, as what serde derives is compiled for every type that reads.
struct Reader<'a, 'i> {
    /// None of what is missing.
    node: Option<&'a Spanned<DeValue<'i>>>,
    /// Whether a placeholder stands in its place.
    replaced: bool,
    path: String,
    mended: &'a Mended,
}

impl<'a, 'i> Reader<'a, 'i> {
    fn of(node: &'a Spanned<DeValue<'i>>, path: String, mended: &'a Mended) -> Self {
        Self { node: Some(node), replaced: mended.replaced.contains(&path), path, mended }
    }

    fn below(&self, node: &'a Spanned<DeValue<'i>>, path: String) -> Self {
        Self::of(node, path, self.mended)
    }

    /// What is missing below.
    fn placeholder(&self) -> Self {
        Self { node: None, replaced: true, path: String::new(), mended: self.mended }
    }

    /// The value, where it is not replaced.
    fn value(&self) -> Option<&'a DeValue<'i>> {
        self.node.filter(|_| !self.replaced).map(Spanned::get_ref)
    }

    /// A complaint with this value's path where it has none; one of a placeholder belongs to what is above.
    fn placed(&self, complaint: Complaint) -> Complaint {
        if self.replaced { complaint } else { complaint.at(&self.path) }
    }

    /// The complaint that this value should be `allowed`.
    fn should_be(&self, allowed: String) -> Complaint {
        Complaint::new(FormFault::Value(allowed)).at(&self.path)
    }

    /// The entries of a table with these keys.
    fn entries(&self, keys: &'static [&'static str]) -> Result<Entries<'_, 'a, 'i>, Complaint> {
        match self.value() {
            None => Ok(Entries::placeholders(self, keys)),
            Some(DeValue::Table(_)) => Ok(Entries::new(self)),
            Some(_) => Err(self.should_be("a table".into())),
        }
    }

    /// The items of a list of this length.
    fn items(&self, length: usize) -> Result<Items<'_, 'a, 'i>, Complaint> {
        match self.value() {
            None => Ok(Items { reader: self, next: 0, placeholders: Some(length) }),
            Some(DeValue::Array(items)) if items.len() == length => Ok(Items::new(self)),
            Some(_) => Err(self.should_be(format!("a list of length {length}"))),
        }
    }

    /// The choice among these variants.
    fn choice(&self, variants: &'static [&'static str]) -> Result<VariantChoice<'_, 'a, 'i>, Complaint> {
        match self.value() {
            None => {
                let name = variants.first().copied().unwrap_or_default();
                Ok(VariantChoice { reader: self, name, inside: None })
            }
            Some(DeValue::String(text)) => Ok(VariantChoice { reader: self, name: text, inside: None }),
            Some(DeValue::Table(table)) => {
                let ignored = |key: &str| self.mended.ignored.contains(&dotted(&self.path, key));
                let mut kept = table.iter().filter(|(key, _)| !ignored(key.get_ref()));
                match (kept.next(), kept.next()) {
                    (Some((key, value)), None) => {
                        Ok(VariantChoice { reader: self, name: key.get_ref(), inside: Some(value) })
                    }
                    _ => {
                        let keys = table.keys().map(|key| key.get_ref());
                        Err(Complaint::new(not_one_of(keys, variants)).at(&self.path))
                    }
                }
            }
            Some(_) => Err(self.should_be(format!("one of {}", variants.join(", ")))),
        }
    }

    /// The value as it is, replaced or not.
    fn any<'de, V: Visitor<'de>>(&self, node: &'a DeValue<'i>, visitor: V) -> Result<V::Value, Complaint> {
        match node {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            DeValue::Float(float) => match float.as_str().parse() {
                Ok(value) => visitor.visit_f64(value),
                Err(_) => Err(Complaint::new(FormFault::Value("a number".into()))),
            },
            DeValue::Integer(integer) => match i128::from_str_radix(integer.as_str(), integer.radix()) {
                Ok(value) => match (i64::try_from(value), u64::try_from(value)) {
                    (Ok(value), _) => visitor.visit_i64(value),
                    (_, Ok(value)) => visitor.visit_u64(value),
                    _ => visitor.visit_f64(value as f64),
                },
                Err(_) => Err(Complaint::new(FormFault::Value("a whole number of fewer digits".into()))),
            },
            DeValue::Datetime(time) => visitor.visit_string(time.to_string()),
            DeValue::Array(_) => visitor.visit_seq(Items::new(self)),
            DeValue::Table(_) => visitor.visit_map(Entries::new(self)),
        }
    }
}

impl<'de> Deserializer<'de> for Reader<'_, '_> {
    type Error = Complaint;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Complaint> {
        match self.node {
            Some(node) => self.any(node.get_ref(), visitor).map_err(|complaint| complaint.at(&self.path)),
            None => visitor.visit_f64(0.0),
        }
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Complaint> {
        if self.node.is_none() { visitor.visit_unit() } else { self.deserialize_any(visitor) }
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Complaint> {
        self.deserialize_any(visitor)
    }

    fn deserialize_identifier<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Complaint> {
        if self.node.is_none() { visitor.visit_str("") } else { self.deserialize_any(visitor) }
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Complaint> {
        self.deserialize_unit(visitor)
    }

    typed! {
        deserialize_bool => visit_bool(false);
        deserialize_char => visit_char('0');
        deserialize_str => visit_str("");
        deserialize_string => visit_str("");
        deserialize_bytes => visit_bytes(&[]);
        deserialize_byte_buf => visit_bytes(&[]);
        deserialize_i8 => visit_i8(0);
        deserialize_i16 => visit_i16(0);
        deserialize_i32 => visit_i32(0);
        deserialize_i64 => visit_i64(0);
        deserialize_i128 => visit_i128(0);
        deserialize_u8 => visit_u8(0);
        deserialize_u16 => visit_u16(0);
        deserialize_u32 => visit_u32(0);
        deserialize_u64 => visit_u64(0);
        deserialize_u128 => visit_u128(0);
        deserialize_f32 => visit_f32(0.0);
        deserialize_f64 => visit_f64(0.0);
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Complaint> {
        if self.replaced { self.deserialize_tuple(0, visitor) } else { self.deserialize_any(visitor) }
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Complaint> {
        if self.replaced { self.deserialize_struct("", &[], visitor) } else { self.deserialize_any(visitor) }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Complaint> {
        if self.replaced { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Complaint> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Complaint> {
        let items = self.items(length)?;
        visitor.visit_seq(items).map_err(|complaint| self.placed(complaint))
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Complaint> {
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Complaint> {
        let entries = self.entries(fields)?;
        visitor.visit_map(entries).map_err(|complaint| self.placed(complaint))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Complaint> {
        let choice = self.choice(variants)?;
        visitor.visit_enum(choice).map_err(|complaint| self.placed(complaint))
    }
}

/// What is wrong with a table that should hold one of `variants` alone and has these `keys`.
fn not_one_of<K: AsRef<str>>(mut keys: impl Iterator<Item = K>, variants: &[&str]) -> FormFault {
    let unknown = keys.find(|key| !variants.contains(&key.as_ref()));
    let known = unknown.map(|key| FormFault::Unknown(key.as_ref().into(), names(variants)));
    known.unwrap_or_else(|| FormFault::Value(format!("one of {}, alone", variants.join(", "))))
}
